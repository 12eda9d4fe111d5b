//! The utilisation of a body's materials at its nodes, and its overstressed area.
//!
//! Stress jumps where elasticity does: there a node has one recovered stress, and one utilisation, for each elasticity of its cells
//! ([`Borders`]). Between materials of equal elasticity the utilisation is the larger one; each cell is judged by its own.
//!
//! A place is overstressed where the stress of its cell, interpolated between the nodes, exceeds the strength. Cells are cut into
//! simplices, on which the excess over the strength is taken as linear between the corners:
//!
//! ```text
//!   overstressed = Σ_T |T| · share of T in which the linear excess is positive
//! ```
//!
//! Its boundary is off by O(h²), and so is the area; counting points of integration instead is off by O(h) and jumps with the load.

use crate::fem::borders::Borders;
use crate::fem::cells::CellTable;
use crate::fem::error::FemError;
use crate::fem::nouns::{Body, Material};
use crate::fem::strength::Strength;
use crate::fem::stress::von_mises;
use crate::mesh::{CellBlock, CellKind, MAX_CELL_NODES, Mesh};
use rayon::prelude::*;

/// Utilisation of the strengths of a body's materials.
pub(crate) struct Overstress {
    /// Utilisation at every place; NaN where no cell has a strength.
    pub utilisation: Vec<f64>,
    /// Area of the mesh where it exceeds 1, without thickness and 2πr; in space the volume.
    pub extent: f64,
    /// The area of all cells with a strength.
    pub whole: f64,
}

/// Utilisation and overstressed area of a body whose recovered total stress is `stress` (places,); `None` where no material has
/// a strength. A material that yields has at most its yield stress at its points, which has `grown` with the equivalent plastic strain
/// (places,): it is not overstressed.
///
/// Errors: a group of cells without a material.
pub(crate) fn overstress<const D: usize>(
    body: &Body<D>,
    borders: &Borders,
    stress: &[[f64; 6]],
    grown: Option<&[f64]>,
) -> Result<Option<Overstress>, FemError> {
    if body.materials.iter().all(|m| m.strength.is_none()) {
        return Ok(None);
    }
    let mut found = Overstress {
        utilisation: vec![f64::NAN; stress.len()],
        extent: 0.0,
        whole: 0.0,
    };
    for (index, block) in body.mesh.blocks().iter().enumerate() {
        let Material {
            strength: Some(strength),
            plastic,
            ..
        } = *body.material(block)?
        else {
            continue;
        };
        let place = |&node: &u32| borders.place(index, node as usize);
        let places: Vec<usize> = block.nodes.iter().map(place).collect();
        match (plastic, strength) {
            (Some(plastic), Strength::VonMises { yield_stress }) => {
                let grown = |place: usize| grown.map_or(0.0, |grown| grown[place]);
                found.whole += extent(&body.mesh, block);
                for place in places {
                    let now = yield_stress + plastic.hardening * grown(place);
                    let own = (von_mises(stress[place]) / now).min(1.0);
                    let known = &mut found.utilisation[place];
                    *known = known.max(own);
                }
            }
            _ => found.add(&body.mesh, (block, &places), strength, stress),
        }
    }
    Ok(Some(found))
}

/// Area of the cells of a block, in space volume.
fn extent<const D: usize>(mesh: &Mesh<D>, block: &CellBlock) -> f64 {
    let table = CellTable::<D>::new(block.kind, 2 * block.kind.order());
    let of_cell = |cell: &[u32]| -> f64 {
        let at = |local: usize| mesh.points()[cell[local] as usize];
        (0..table.len()).map(|q| table.map(q, at).2).sum()
    };
    block.cells().map(of_cell).sum()
}

impl Overstress {
    /// Adds the cells of a block, whose nodes have these places.
    fn add<const D: usize>(
        &mut self,
        mesh: &Mesh<D>,
        (block, places): (&CellBlock, &[usize]),
        strength: Strength,
        stress: &[[f64; 6]],
    ) {
        let mut once = places.to_vec();
        once.sort_unstable();
        once.dedup();
        let values: Vec<f64> = once
            .par_iter()
            .map(|&place| strength.utilisation(stress[place]))
            .collect();
        let mut safe = vec![false; stress.len()];
        for (&place, value) in once.iter().zip(values) {
            let known = &mut self.utilisation[place];
            // the larger one; NaN is ignored
            *known = known.max(value);
            safe[place] = value <= 1.0;
        }
        let division = Division::<D>::new(block.kind);
        let k = block.kind.nodes();
        let extents: Vec<[f64; 2]> = (block.nodes)
            .par_chunks(k)
            .zip(places.par_chunks(k))
            .map(|(cell, places)| {
                // safe states form a convex set: between safe nodes of a linear cell no state fails
                let linear = block.kind.order() == 1;
                let whole = linear && places.iter().all(|&place| safe[place]);
                division.extent(mesh, cell, |at| match whole {
                    true => -1.0,
                    false => strength.excess(interpolated(places, at, stress)),
                })
            })
            .collect();
        for [extent, whole] in extents {
            self.extent += extent;
            self.whole += whole;
        }
    }
}

/// The stress between the nodes of a cell, which have these places.
fn interpolated(places: &[usize], shape: &[f64], stress: &[[f64; 6]]) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (&place, n) in places.iter().zip(shape) {
        for (s, own) in sum.iter_mut().zip(stress[place]) {
            *s += n * own;
        }
    }
    sum
}

/// A reference cell cut into simplices.
struct Division<const D: usize> {
    /// Shape functions at the corners of the simplices.
    shapes: Vec<[f64; MAX_CELL_NODES]>,
    /// Corners of each simplex, D + 1 of them.
    simplices: Vec<Vec<usize>>,
    /// The middles of the simplices with their volumes.
    middles: CellTable<D>,
}

impl<const D: usize> Division<D> {
    fn new(kind: CellKind) -> Self {
        let mut points: Vec<[f64; 3]> = Vec::new();
        let mut index = |point: &[f64; 3]| {
            let same = |p: &[f64; 3]| {
                p.iter()
                    .zip(point)
                    .all(|(a, b)| (a - b).abs() < SAME_CORNER)
            };
            points.iter().position(same).unwrap_or_else(|| {
                points.push(*point);
                points.len() - 1
            })
        };
        let (mut simplices, mut middles) = (Vec::new(), Vec::new());
        for simplex in cones(kind) {
            simplices.push(simplex.iter().map(&mut index).collect());
            let count = simplex.len() as f64;
            let middle = std::array::from_fn(|d| simplex.iter().map(|p| p[d]).sum::<f64>() / count);
            middles.push((middle, volume::<D>(&simplex)));
        }
        let shapes = points.iter().map(|point| {
            let mut shape = [0.0; MAX_CELL_NODES];
            kind.shape(point, &mut shape);
            shape
        });
        Self {
            shapes: shapes.collect(),
            simplices,
            middles: CellTable::at(kind, &middles),
        }
    }

    /// The part of a cell where a function of its shape functions is positive, and all of it: areas in the plane, volumes in space.
    fn extent(&self, mesh: &Mesh<D>, cell: &[u32], excess: impl Fn(&[f64]) -> f64) -> [f64; 2] {
        let values: Vec<f64> = self.shapes.iter().map(|shape| excess(shape)).collect();
        let mut sums = [0.0; 2];
        for (k, simplex) in self.simplices.iter().enumerate() {
            let at = |local: usize| mesh.points()[cell[local] as usize];
            let (_, _, volume) = self.middles.map(k, at);
            let corners: Vec<f64> = simplex.iter().map(|&corner| values[corner]).collect();
            sums[0] += volume * share(&corners);
            sums[1] += volume;
        }
        sums
    }
}

/// Points of a reference cell this near to each other coincide.
const SAME_CORNER: f64 = 1e-9;

/// The simplices of a reference cell, by their corners: cones from its centre over those of its facets; a line with a middle node is
/// two.
fn cones(kind: CellKind) -> Vec<Vec<[f64; 3]>> {
    let nodes = kind.reference_nodes();
    if kind.dimension() == 1 {
        return match kind.order() {
            1 => vec![nodes[..2].to_vec()],
            _ => vec![vec![nodes[0], nodes[2]], vec![nodes[2], nodes[1]]],
        };
    }
    let mut list = Vec::new();
    for &(facet, local) in kind.facets() {
        let place = |xi: &[f64; 3]| {
            let mut shape = [0.0; MAX_CELL_NODES];
            facet.shape(xi, &mut shape);
            let parts = local.iter().zip(shape);
            parts.fold([0.0; 3], |sum, (&node, n)| {
                std::array::from_fn(|d| sum[d] + n * nodes[node][d])
            })
        };
        for simplex in cones(facet) {
            let corners = simplex.iter().map(place);
            list.push(corners.chain([kind.domain().centre()]).collect());
        }
    }
    list
}

/// Area of a triangle in the plane, volume of a tetrahedron in space.
fn volume<const D: usize>(simplex: &[[f64; 3]]) -> f64 {
    let edge = |k: usize| -> [f64; 3] { std::array::from_fn(|d| simplex[k][d] - simplex[0][d]) };
    let [a, b] = [edge(1), edge(2)];
    let twice = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    match D {
        2 => 0.5 * twice[2].abs(),
        _ => {
            let c = edge(3);
            (twice[0] * c[0] + twice[1] * c[1] + twice[2] * c[2]).abs() / 6.0
        }
    }
}

/// The share of a triangle or tetrahedron in which the linear function with these values at its corners is positive; zero if one is
/// NaN.
///
/// A corner alone on its side is cut off by its similar part, Π v/(v − vⱼ); a tetrahedron with two on either side is cut
/// into two such through the place on an edge where the function vanishes. Only differences of values of unlike sign occur.
fn share(values: &[f64]) -> f64 {
    let cut_off = |corner: f64, others: &[f64]| -> f64 {
        others
            .iter()
            .map(|other| corner / (corner - other))
            .product()
    };
    let (above, below): (Vec<f64>, Vec<f64>) = values.iter().partition(|value| **value > 0.0);
    match (&above[..], &below[..]) {
        _ if values.iter().any(|value| value.is_nan()) => 0.0,
        ([], _) => 0.0,
        (_, []) => 1.0,
        ([corner], others) => cut_off(*corner, others),
        (others, [corner]) => 1.0 - cut_off(*corner, others),
        ([a, b], [c, d]) => {
            // the place on the edge from a to c, seen from c
            let part = c / (c - a);
            part * cut_off(*b, &[*c, *d]) + (1.0 - part) * (1.0 - cut_off(*d, &[*a, *b]))
        }
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::nouns::{Analysis, Elastic, Material};
    use crate::fem::tests::{body, groups};
    use crate::geometry::Point;
    use crate::mesh::{Cuboid, Diagonals, Rectangle};

    const KINDS: [CellKind; 5] = [
        CellKind::Tri3,
        CellKind::Tri6,
        CellKind::Quad4,
        CellKind::Quad8,
        CellKind::Quad9,
    ];
    const SOLIDS: [CellKind; 7] = [
        CellKind::Tet4,
        CellKind::Tet10,
        CellKind::Hex8,
        CellKind::Hex20,
        CellKind::Hex27,
        CellKind::Prism6,
        CellKind::Prism15,
    ];

    /// A tension that grows as x, from zero at x = 0, beside a yield stress.
    fn graded<const D: usize>(mesh: Mesh<D>, yield_stress: f64) -> Overstress {
        let mut body = body(mesh);
        body.materials[0].strength = Some(Strength::VonMises { yield_stress });
        let points = body.mesh.points();
        let stress: Vec<[f64; 6]> = points
            .iter()
            .map(|p| [p[0], 0.0, 0.0, 0.0, 0.0, 0.0])
            .collect();
        overstress(&body, &Borders::of(&body).unwrap(), &stress, None)
            .unwrap()
            .unwrap()
    }

    #[test]
    fn linear_fields_are_cut_exactly() {
        for cell in KINDS {
            let rectangle = Rectangle {
                from: [0.0, 0.0],
                to: [2.0, 1.0],
                cells: [3, 2],
                cell,
                diagonals: Diagonals::Forward,
            };
            // parallelograms: the excess is linear on them, too
            let slanted = |[x, y]: Point<2>| [x + 0.5 * y, y];
            let mesh = rectangle.build().unwrap().map_points(slanted).unwrap();
            let found = graded(mesh, 0.7);
            // all but the part left of x = 0.7 in the parallelogram: at y it is 0.7 − y/2 wide
            let expected = 2.0 - (0.7 - 0.25);
            assert!(
                (found.extent - expected).abs() < 1e-12,
                "{cell:?} {}",
                found.extent
            );
            assert!((found.whole - 2.0).abs() < 1e-12);
        }
        for cell in SOLIDS {
            let cuboid = Cuboid {
                from: [0.0; 3],
                to: [2.0, 1.0, 0.5],
                cells: [3, 2, 1],
                cell,
            };
            let slanted = |[x, y, z]: Point<3>| [x + 0.5 * y + 0.2 * z, y, z];
            let mesh = cuboid.build().unwrap().map_points(slanted).unwrap();
            let found = graded(mesh, 0.7);
            let expected = 1.0 - 0.5 * (0.7 - 0.25 - 0.05);
            assert!(
                (found.extent - expected).abs() < 1e-12,
                "{cell:?} {}",
                found.extent
            );
            assert!((found.whole - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn shares_of_simplices_are_those_of_counted_points() {
        // barycentric midpoints of a fine lattice: off by the surface of the cut, some 1/n
        let n = 60;
        let triangle = |v: [f64; 3]| {
            let (mut above, mut all) = (0.0, 0.0);
            for i in 0..n {
                for j in 0..n - i {
                    let [a, b] = [i, j].map(|k| (k as f64 + 1.0 / 3.0) / n as f64);
                    all += 1.0;
                    above += f64::from(u8::from((1.0 - a - b) * v[0] + a * v[1] + b * v[2] > 0.0));
                }
            }
            above / all
        };
        for v in [[1.0, -2.0, -0.5], [1.0, 2.0, -3.0], [-1.0, -1.0, 4.0]] {
            assert!((share(&v) - triangle(v)).abs() < 0.03, "{v:?}");
        }
        let tetrahedron = |v: [f64; 4]| {
            let (mut above, mut all) = (0.0, 0.0);
            for i in 0..n {
                for j in 0..n - i {
                    for k in 0..n - i - j {
                        let [a, b, c] = [i, j, k].map(|k| (k as f64 + 0.25) / n as f64);
                        let value = (1.0 - a - b - c) * v[0] + a * v[1] + b * v[2] + c * v[3];
                        all += 1.0;
                        above += f64::from(u8::from(value > 0.0));
                    }
                }
            }
            above / all
        };
        for v in [
            [1.0, -2.0, -0.5, -1.0],
            [1.0, 2.0, -3.0, 0.5],
            [1.0, 2.0, -3.0, -0.5],
            [-1.0, 3.0, -3.0, 0.2],
        ] {
            assert!((share(&v) - tetrahedron(v)).abs() < 0.03, "{v:?}");
        }
        // zero is not beyond
        assert_eq!(share(&[0.0, 0.0, 0.0]), 0.0);
        assert_eq!(share(&[1.0, 1.0, 0.0, 0.0]), 1.0);
        assert_eq!(share(&[-1.0, -1.0, 0.0]), 0.0);
        assert_eq!(share(&[f64::NAN, 1.0, 1.0]), 0.0);
    }

    #[test]
    fn materials_are_judged_by_their_own_stress() {
        // stretched by ε = 1 along x: 3 in group a, 9 in group b, 7 where they are averaged
        let material = |group: &str, young: f64, yield_stress: Option<f64>| Material {
            group: Some(group.to_string()),
            elastic: Elastic {
                young,
                poisson: 0.0,
            },
            strength: yield_stress.map(|yield_stress| Strength::VonMises { yield_stress }),
            plastic: None,
            ages: None,
        };
        let mut body = body(groups());
        let u: Vec<Point<2>> = body.mesh.points().iter().map(|x| [x[0], 0.0]).collect();
        let mut judge = |a: (f64, Option<f64>), b: (f64, Option<f64>)| {
            body.materials = vec![material("a", a.0, a.1), material("b", b.0, b.1)];
            let plane = Analysis::PlaneStress;
            let stress = crate::fem::recover_stress(&body, plane, &u, 1.0).unwrap();
            overstress(&body, &Borders::of(&body).unwrap(), &stress, None).unwrap()
        };
        // nodes 1 and 4 lie between the groups, and are listed again after the six
        let near = |found: &[f64], expected: [f64; 8]| {
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                let same = found.is_nan() && expected.is_nan();
                assert!(
                    same || (found - expected).abs() < 1e-12,
                    "{found} {expected}"
                );
            }
        };
        // each side has its own utilisation, and the soft rock beside the stiff lining is not overstressed
        let found = judge((3.0, Some(4.0)), (9.0, Some(10.0))).unwrap();
        near(
            &found.utilisation,
            [0.75, 0.75, 0.9, 0.75, 0.75, 0.9, 0.9, 0.9],
        );
        assert_eq!((found.extent, found.whole), (0.0, 3.0));
        let found = judge((3.0, Some(2.0)), (9.0, Some(10.0))).unwrap();
        near(&found.utilisation, [1.5, 1.5, 0.9, 1.5, 1.5, 0.9, 0.9, 0.9]);
        assert!((found.extent - 1.0).abs() < 1e-12);
        // a group without a strength has no utilisation; no group with one, no field
        let none = f64::NAN;
        let found = judge((3.0, None), (9.0, Some(6.0))).unwrap();
        near(
            &found.utilisation,
            [none, none, 1.5, none, none, 1.5, 1.5, 1.5],
        );
        assert!((found.extent - 2.0).abs() < 1e-12 && (found.whole - 2.0).abs() < 1e-12);
        assert!(judge((3.0, None), (9.0, None)).is_none());
    }
}
