//! Stress and strain at the nodes, recovered from the displacements; stresses are total, σ = C(ε(u) − ε₀) + σ₀.
//!
//! In each cell the stress is sampled at the points where it is most accurate (the centre of a linear simplex, else the
//! corners drawn towards the centre: three points in a quadratic triangle, four in a quadratic tetrahedron, 2 × 2 (× 2) in
//! quadrilaterals and hexahedra, 3 × 2 in prisms), extrapolated to the
//! nodes by the linear function through the samples and averaged there with the cells' volumes, separately for each material.
//! In bodies that have yielded the stress is known at the points of the stiffness: these are the samples, and the linear function
//! is the one nearest to them.

use crate::fem::block::{Cells, Deformation};
use crate::fem::borders::Borders;
use crate::fem::cells::CellTable;
use crate::fem::elasticity::Lame;
use crate::fem::error::FemError;
use crate::fem::loads::points_within;
use crate::fem::nouns::{Analysis, Body};
use crate::fem::plastic::{Yielded, plastic_stress};
use crate::geometry::Point;
use crate::linalg::Mat;
use crate::linalg::dense::{cholesky_in_place, solve_cholesky_in_place};
use crate::mesh::{CellKind, Mesh};
use rayon::prelude::*;

/// Recovered total stress (xx yy zz xy yz xz) at every place of a body ([`Borders`]) with the given nodal displacements at a
/// time. An initial stress is evaluated at the places, the stress of an initial strain at the samples of the displacements.
///
/// Errors: a group of cells without a material; an initial stress or strain that is not finite.
/// Source: J. Barlow's optimal sampling points, as described in finite-element textbooks.
pub fn recover_stress<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
    time: f64,
) -> Result<Vec<[f64; 6]>, FemError> {
    recover_yielded_stress((body, analysis), displacement, time, None)
}

/// The same for a body with these plastic strains.
///
/// Errors: those of [`recover_stress`].
pub(crate) fn recover_yielded_stress<const D: usize>(
    (body, analysis): (&Body<D>, Analysis),
    displacement: &[Point<D>],
    time: f64,
    yielded: Option<&Yielded>,
) -> Result<Vec<[f64; 6]>, FemError> {
    let plastic = yielded.map(|yielded| yielded.of_blocks(body, analysis));
    let plastic = plastic.transpose()?;
    let local = |lame: Lame, at: Sample, here: &Deformation<D>| {
        let less = body.initial.of_strain((lame, analysis), here.point, time)?;
        let stress = sum(lame.stress(here.gradient, here.hoop), less);
        Ok(match &plastic {
            Some(points) => {
                let less = plastic_stress(lame, analysis, &points[at.block][at.place]);
                std::array::from_fn(|c| stress[c] - less[c])
            }
            None => stress,
        })
    };
    let borders = Borders::of(body)?;
    let samples = match plastic {
        Some(_) => Samples::OfStiffness,
        None => Samples::Best,
    };
    let state = (displacement, time);
    let mut stress = recover((body, analysis), state, samples, local, &borders)?;
    if body.initial.stress.is_some() {
        for (stress, node) in stress.iter_mut().zip(borders.nodes()) {
            let point = body.mesh.points()[node];
            *stress = sum(*stress, body.initial.stress_at(point, time)?);
        }
    }
    Ok(stress)
}

/// a + b.
pub(crate) fn sum(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|c| a[c] + b[c])
}

/// Recovered strain (xx yy zz xy yz xz, tensor components) at every place, as [`recover_stress`].
///
/// Errors: a group of cells without a material; an initial strain that is not finite.
pub fn recover_strain<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
    time: f64,
) -> Result<Vec<[f64; 6]>, FemError> {
    let local = |lame: Lame, _: Sample, here: &Deformation<D>| strain(body, lame, here, time);
    let (state, borders) = ((displacement, time), Borders::of(body)?);
    recover((body, analysis), state, Samples::Best, local, &borders)
}

/// Total strain (xx yy zz xy yz xz) of a deformation.
///
/// Errors: an initial strain that is not finite.
pub(crate) fn strain<const D: usize>(
    body: &Body<D>,
    lame: Lame,
    here: &Deformation<D>,
    time: f64,
) -> Result<[f64; 6], FemError> {
    let mut strain = lame.strain(here.gradient, here.hoop);
    strain[2] += body.initial.across(lame, here.point, time)?;
    Ok(strain)
}

/// Recovered rotation vector at every place, radians, as [`recover_stress`]; in the plane its third component.
///
/// Errors: a group of cells without a material; an initial strain that is not finite.
pub fn recover_spin<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
    time: f64,
) -> Result<Vec<[f64; 3]>, FemError> {
    let spins = recover(
        (body, analysis),
        (displacement, time),
        Samples::Best,
        |_, _, Deformation { gradient, .. }| {
            let of = |i: usize, j: usize| match i.max(j) < D {
                true => 0.5 * (gradient[j][i] - gradient[i][j]),
                false => 0.0,
            };
            Ok([of(1, 2), of(2, 0), of(0, 1), 0.0, 0.0, 0.0])
        },
        &Borders::of(body)?,
    )?;
    Ok(spins
        .into_iter()
        .map(|spin| [spin[0], spin[1], spin[2]])
        .collect())
}

/// Yielding at every place of a body.
pub(crate) struct YieldedFields {
    /// Plastic strain, xx yy zz xy yz xz, tensor components.
    pub strain: Vec<[f64; 6]>,
    /// Equivalent plastic strain.
    pub equivalent: Vec<f64>,
    /// Mean of `cells` around.
    pub share: Vec<f64>,
    /// By cell, block by block: the share of its points at which it has grown.
    pub cells: Vec<f64>,
}

/// Plastic strains of a body, and the growth since `before`, as [`recover_stress`]; shares are means over cells.
///
/// Errors: a group of cells without a material.
pub(crate) fn recover_yielded<const D: usize>(
    (body, analysis): (&Body<D>, Analysis),
    yielded: &Yielded,
    before: Option<&Yielded>,
) -> Result<YieldedFields, FemError> {
    let borders = Borders::of(body)?;
    let still = vec![[0.0; D]; body.mesh.points().len()];
    let points = yielded.of_blocks(body, analysis)?;
    let before = before.map(|before| before.of_blocks(body, analysis));
    let before = before.transpose()?;
    let of_points = |samples: Samples, value: &(dyn Fn(Sample) -> [f64; 6] + Sync)| {
        let local = |_: Lame, at: Sample, _: &Deformation<D>| Ok(value(at));
        recover((body, analysis), (&still, 0.0), samples, local, &borders)
    };
    let equivalent = |at: Sample| points[at.block][at.place][6];
    let grown = |block: usize, place: usize| {
        let then = before.as_ref();
        let then = then.map_or(0.0, |before| before[block][place][6]);
        f64::from(u8::from(points[block][place][6] > then))
    };
    // share of the points of each cell, block by block
    let cells: Vec<Vec<f64>> = (body.mesh.blocks().iter().enumerate())
        .map(|(index, block)| {
            let number = block.cells().len();
            let count = points[index].len() / number.max(1);
            let share = |cell: usize| {
                (count * cell..count * (cell + 1))
                    .map(|place| grown(index, place))
                    .sum::<f64>()
                    / count as f64
            };
            (0..number).map(share).collect()
        })
        .collect();
    let of_cell =
        |at: Sample| cells[at.block][at.place * cells[at.block].len() / points[at.block].len()];
    let first = |values: Vec<[f64; 6]>| -> Vec<f64> { values.iter().map(|own| own[0]).collect() };
    let strain = of_points(Samples::OfStiffness, &|at| {
        std::array::from_fn(|c| points[at.block][at.place][c])
    })?;
    let sizes = of_points(Samples::OfStiffness, &|at| [equivalent(at); 6])?;
    let share = of_points(Samples::MeansOfStiffness, &|at| [of_cell(at); 6])?;
    Ok(YieldedFields {
        strain,
        // near the border of the plastic zone a linear function may become negative
        equivalent: first(sizes).into_iter().map(|own| own.max(0.0)).collect(),
        // rounding of a mean
        share: first(share).into_iter().map(|own| own.min(1.0)).collect(),
        cells: cells.concat(),
    })
}

/// Sampling points in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Samples {
    /// Where elastic stresses are most accurate.
    Best,
    /// At the points of the stiffness.
    OfStiffness,
    /// At these points, and the mean counts for the whole cell.
    MeansOfStiffness,
}

/// One of the samples of a block.
#[derive(Debug, Clone, Copy)]
struct Sample {
    block: usize,
    /// Its place among those of the block.
    place: usize,
}

/// Recovers, at every place, values given by `local` for a material, a sample and a deformation.
fn recover<const D: usize>(
    (body, analysis): (&Body<D>, Analysis),
    (displacement, time): (&[Point<D>], f64),
    samples_at: Samples,
    local: impl Fn(Lame, Sample, &Deformation<D>) -> Result<[f64; 6], FemError> + Sync,
    borders: &Borders,
) -> Result<Vec<[f64; 6]>, FemError> {
    let mut sums = vec![[0.0; 7]; borders.count()];
    for (index, block) in body.mesh.blocks().iter().enumerate() {
        let whole = Cells::new(body, block, analysis, body.formulation)?;
        let of_initial = whole.for_initial(block);
        let rule = match samples_at {
            Samples::Best => sampling_points(block.kind),
            Samples::OfStiffness | Samples::MeansOfStiffness => whole.table.rule(),
        };
        let table = CellTable::at(block.kind, &rule);
        let own = whole.at(table.formulated(block.kind, body.formulation));
        let count = own.table.len();
        let extrapolation = match samples_at {
            Samples::Best => extrapolation(block.kind),
            Samples::OfStiffness => nearest_linear(block.kind, &rule),
            Samples::MeansOfStiffness => means(block.kind, &rule),
        };
        let k = block.kind.nodes();
        // each cell writes its own slice: (stress, volume) of its samples; the gather below is in cell order
        let mut samples = vec![[0.0; 7]; count * (block.nodes.len() / k)];
        samples
            .par_chunks_mut(count * CHUNK)
            .zip(block.nodes.par_chunks(k * CHUNK))
            .enumerate()
            .try_for_each(|(chunk, (out, cells))| {
                let cells = out.chunks_exact_mut(count).zip(cells.chunks_exact(k));
                for (number, (out, cell)) in cells.enumerate() {
                    let first = (chunk * CHUNK + number) * count;
                    let held = body.initial.held_modes(&of_initial, (cell, time))?;
                    let modes = whole.modes(cell, displacement, &held);
                    for (q, sample) in out.iter_mut().enumerate() {
                        let here = own.deformation(q, (cell, &modes), displacement);
                        let at = Sample {
                            block: index,
                            place: first + q,
                        };
                        sample[..6].copy_from_slice(&local(own.lame, at, &here)?);
                        sample[6] = here.volume;
                    }
                }
                Ok(())
            })?;
        for (cell, samples) in block.cells().zip(samples.chunks_exact(count)) {
            let volume: f64 = samples.iter().map(|s| s[6]).sum();
            for (&node, weights) in cell.iter().zip(&extrapolation) {
                let sum = &mut sums[borders.place(index, node as usize)];
                for c in 0..6 {
                    sum[c] += volume
                        * samples
                            .iter()
                            .zip(weights)
                            .map(|(s, w)| w * s[c])
                            .sum::<f64>();
                }
                sum[6] += volume;
            }
        }
    }
    Ok(sums
        .iter()
        .map(|s| std::array::from_fn(|c| s[c] / s[6]))
        .collect())
}

/// Cells per parallel task.
const CHUNK: usize = 256;

/// A point drawn towards the centre of a reference cell by a factor along each coordinate.
fn drawn(kind: CellKind, xi: [f64; 3], factors: [f64; 3]) -> [f64; 3] {
    let centre = kind.domain().centre();
    std::array::from_fn(|d| centre[d] + factors[d] * (xi[d] - centre[d]))
}

/// Reference points where the stress is sampled, with weights that sum to the reference volume.
fn sampling_points(kind: CellKind) -> Vec<([f64; 3], f64)> {
    let count = if kind.sampling()[0] > 0.0 {
        kind.corners()
    } else {
        1
    };
    let weight = kind.domain().volume() / count as f64;
    let corners = kind.reference_nodes()[..count].iter();
    corners
        .map(|&corner| (drawn(kind, corner, kind.sampling()), weight))
        .collect()
}

/// The places in all cells where the stress is sampled.
pub(crate) fn sampled_points<const D: usize>(mesh: &Mesh<D>) -> Vec<Point<D>> {
    points_within(mesh, |kind| CellTable::at(kind, &sampling_points(kind)))
}

/// Weights of the samples at each node of the cell: the linear shape functions of the samples, evaluated there.
fn extrapolation(kind: CellKind) -> Vec<Vec<f64>> {
    let linear = kind.domain().linear();
    let weights = |&xi: &[f64; 3]| {
        if kind.sampling()[0] == 0.0 {
            return vec![1.0];
        }
        let mut shape = vec![0.0; linear.nodes()];
        linear.shape(
            &drawn(kind, xi, kind.sampling().map(|s| 1.0 / s)),
            &mut shape,
        );
        shape
    };
    kind.reference_nodes().iter().map(weights).collect()
}

/// Weights of samples at the points of a rule, at each node of the cell: those of their mean.
fn means(kind: CellKind, rule: &[([f64; 3], f64)]) -> Vec<Vec<f64>> {
    let whole: f64 = rule.iter().map(|(_, weight)| weight).sum();
    let mean: Vec<f64> = rule.iter().map(|(_, weight)| weight / whole).collect();
    vec![mean; kind.nodes()]
}

/// Weights of samples at the points of a rule, at each node of the cell: those of the linear function that is nearest to them by
/// least squares, or of their mean where they are too few for one. Each square has the weight of its point, so that the mean of a
/// cell is kept.
fn nearest_linear(kind: CellKind, rule: &[([f64; 3], f64)]) -> Vec<Vec<f64>> {
    let linear = kind.domain().linear();
    let n = linear.nodes();
    let shapes = |xi: &[f64; 3]| {
        let mut shape = vec![0.0; n];
        linear.shape(xi, &mut shape);
        shape
    };
    let samples: Vec<Vec<f64>> = rule.iter().map(|(xi, _)| shapes(xi)).collect();
    let part = |(sample, (_, weight)): (&Vec<f64>, &([f64; 3], f64)), i: usize, j: usize| {
        weight * sample[i] * sample[j]
    };
    let product = |i, j| samples.iter().zip(rule).map(|at| part(at, i, j)).sum();
    let mut normal = Mat::from_fn(n, n, product);
    if samples.len() < n || cholesky_in_place(&mut normal).is_err() {
        return means(kind, rule);
    }
    let weights = |xi: &[f64; 3]| {
        let mut of_corners = shapes(xi);
        solve_cholesky_in_place(&normal, &mut of_corners);
        let each = samples.iter().zip(rule);
        each.map(|(s, (_, weight))| {
            weight * s.iter().zip(&of_corners).map(|(s, c)| s * c).sum::<f64>()
        })
        .collect()
    };
    kind.reference_nodes().iter().map(weights).collect()
}

/// Von Mises stress of (xx yy zz xy yz xz).
pub fn von_mises(s: [f64; 6]) -> f64 {
    let d = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    (0.5 * d + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt()
}

/// Principal stresses of (xx yy zz xy yz xz), largest first.
///
/// By Jacobi's rotations, each of which makes one of the shears zero: accurate to rounding of the largest component, also for equal
/// values, of which the characteristic equation gives half the digits.
/// Source: as described in G. H. Golub and C. F. Van Loan, Matrix Computations, section 8.5.
pub fn principal(s: [f64; 6]) -> [f64; 3] {
    let mut values = [s[0], s[1], s[2]];
    // for each axis the shear of the two that follow: yz, zx, xy
    let mut shears = [s[4], s[5], s[3]];
    let least = 1e-3 * f64::EPSILON * s.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
    for step in 0..3 * SWEEPS {
        let r = step % 3;
        let (p, q) = ((r + 1) % 3, (r + 2) % 3);
        if shears[r].abs() <= least {
            continue;
        }
        let slope = 0.5 * (values[q] - values[p]) / shears[r];
        let tangent = 1.0f64.copysign(slope) / (slope.abs() + slope.hypot(1.0));
        let cosine = 1.0 / tangent.hypot(1.0);
        let sine = tangent * cosine;
        values[p] -= tangent * shears[r];
        values[q] += tangent * shears[r];
        shears[r] = 0.0;
        // shears of the third axis with these two
        let (with_p, with_q) = (shears[q], shears[p]);
        shears[q] = cosine * with_p - sine * with_q;
        shears[p] = sine * with_p + cosine * with_q;
    }
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// Rounds of rotations: the shears fall with their squares, and are below rounding after four or five.
const SWEEPS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    /// R diag(values) Rᵀ with a rotation R from a quaternion.
    fn turned(values: [f64; 3]) -> [f64; 6] {
        let [w, x, y, z] = [0.1f64, 0.5, -0.7, 0.5];
        let rotation = [
            [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y - w * z),
                2.0 * (x * z + w * y),
            ],
            [
                2.0 * (x * y + w * z),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z - w * x),
            ],
            [
                2.0 * (x * z - w * y),
                2.0 * (y * z + w * x),
                1.0 - 2.0 * (x * x + y * y),
            ],
        ];
        let entry = |[i, j]: [usize; 2]| -> f64 {
            (0..3)
                .map(|k| rotation[i][k] * values[k] * rotation[j][k])
                .sum()
        };
        [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]].map(entry)
    }

    #[test]
    fn principal_stresses_do_not_depend_on_the_axes() {
        // the last three have equal ones, or nearly so
        for values in [
            [3.0, 1.0, -2.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [2.0, 2.0 - 1e-9, 0.5],
        ] {
            for (found, expected) in principal(turned(values)).into_iter().zip(values) {
                let off = (found - expected).abs();
                assert!(off < 1e-14, "{found} {expected} of {values:?}");
            }
        }
    }

    #[test]
    fn principal_stresses_of_known_states() {
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12);
        assert!(close(
            principal([3.0, 1.0, -2.0, 0.0, 0.0, 0.0]),
            [3.0, 1.0, -2.0]
        ));
        assert!(close(
            principal([0.0, 0.0, 0.0, 5.0, 0.0, 0.0]),
            [5.0, 0.0, -5.0]
        ));
        assert!(close(
            principal([-2.0, -2.0, -2.0, 0.0, 0.0, 0.0]),
            [-2.0; 3]
        ));
    }
}
