//! Stress and strain at the nodes, recovered from the displacements; stresses are total, σ = C(ε(u) − ε₀) + σ₀.
//!
//! In each cell the stress is sampled at the points where it is most accurate (the centre of a linear simplex, else the
//! corners drawn towards the centre: three points in a quadratic triangle, four in a quadratic tetrahedron, 2 × 2 (× 2) in
//! quadrilaterals and hexahedra, 3 × 2 in prisms), extrapolated to the
//! nodes by the linear function through the samples and averaged there with the cells' volumes, those of each material by
//! themselves.

use crate::fem::block::{Cells, Deformation};
use crate::fem::borders::Borders;
use crate::fem::cells::CellTable;
use crate::fem::elasticity::Lame;
use crate::fem::error::FemError;
use crate::fem::loads::points_within;
use crate::fem::nouns::{Analysis, Body};
use crate::geometry::Point;
use crate::mesh::{CellKind, Mesh};
use rayon::prelude::*;

/// Recovered total stress (xx yy zz xy yz xz) at every place of a body ([`Borders`]) with the given nodal displacements at a
/// time. An initial stress is taken there as it is given, the stress of an initial strain where that of the displacements is.
///
/// Errors: a group of cells without a material; an initial stress or strain that is not finite.
/// Source: J. Barlow's optimal sampling points, as described in finite-element textbooks.
pub fn recover_stress<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
    time: f64,
) -> Result<Vec<[f64; 6]>, FemError> {
    let local = |lame: Lame, here: &Deformation<D>| {
        let less = body.initial.of_strain((lame, analysis), here.point, time)?;
        Ok(sum(lame.stress(here.gradient, here.hoop), less))
    };
    let borders = Borders::of(body)?;
    let mut stress = recover(body, analysis, (displacement, time), local, &borders)?;
    if body.initial.stress.is_some() {
        for (stress, node) in stress.iter_mut().zip(borders.nodes()) {
            let point = body.mesh.points()[node];
            *stress = sum(*stress, body.initial.stress_at(point, time)?);
        }
    }
    Ok(stress)
}

fn sum(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
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
    let local = |lame: Lame, here: &Deformation<D>| Ok(lame.strain(here.gradient, here.hoop));
    let state = (displacement, time);
    recover(body, analysis, state, local, &Borders::of(body)?)
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
        body,
        analysis,
        (displacement, time),
        |_, Deformation { gradient, .. }| {
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

/// Values of what is `local` to a material and a deformation, at every place.
fn recover<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    (displacement, time): (&[Point<D>], f64),
    local: impl Fn(Lame, &Deformation<D>) -> Result<[f64; 6], FemError> + Sync,
    borders: &Borders,
) -> Result<Vec<[f64; 6]>, FemError> {
    let mut sums = vec![[0.0; 7]; borders.count()];
    for (index, block) in body.mesh.blocks().iter().enumerate() {
        let whole = Cells::new(body, block, analysis, body.formulation)?;
        let of_initial = whole.for_initial(block);
        let table = CellTable::at(block.kind, &sampling_points(block.kind));
        let own = whole.at(table.formulated(block.kind, body.formulation));
        let count = own.table.len();
        let extrapolation = extrapolation(block.kind);
        let k = block.kind.nodes();
        // each cell writes its own slice: (stress, volume) of its samples; the gather below is in cell order
        let mut samples = vec![[0.0; 7]; count * (block.nodes.len() / k)];
        samples
            .par_chunks_mut(count * CHUNK)
            .zip(block.nodes.par_chunks(k * CHUNK))
            .try_for_each(|(out, cells)| {
                for (out, cell) in out.chunks_exact_mut(count).zip(cells.chunks_exact(k)) {
                    let held = body.initial.held_modes(&of_initial, (cell, time))?;
                    let modes = whole.modes(cell, displacement, &held);
                    for (q, sample) in out.iter_mut().enumerate() {
                        let here = own.deformation(q, (cell, &modes), displacement);
                        sample[..6].copy_from_slice(&local(own.lame, &here)?);
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

/// Von Mises stress of (xx yy zz xy yz xz).
pub fn von_mises(s: [f64; 6]) -> f64 {
    let d = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    (0.5 * d + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt()
}

/// Principal stresses of (xx yy zz xy yz xz), largest first.
///
/// By Jacobi's rotations, each of which makes one of the shears zero: to rounding of the largest component, equal ones, too, of
/// which the characteristic equation knows half the digits.
/// Source: as described in G. H. Golub and C. F. Van Loan, Matrix Computations, section 8.5.
pub fn principal(s: [f64; 6]) -> [f64; 3] {
    let mut values = [s[0], s[1], s[2]];
    // of the axes that follow each one: yz, zx, xy
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
