//! The gaps of an interface again, after something has moved, without pairing it again.
//!
//! ```text
//!   gapᵢ = Σₖ wₖ s(xₖ) / Σₖ wₖ,     s(x) = n·(y − x) + what the meshes miss of their curves
//! ```
//!
//! Kept: which points x and y face each other (nodes and shape functions), the normals n, the weights wₖ = ψᵢ(xₖ) dxₖ and the
//! rows. What moves: the nodes of both sides, the obstacle, and the time of a gap that is given as a function.

use crate::contact::obstacle::{Rigid, finite_gap};
use crate::contact::{ContactError, End, Interface};
use crate::geometry::{Field, Point, add_scaled, dot, sub};

/// A point of the nonmortar side and what lies opposite it.
#[derive(Debug, Clone, PartialEq)]
pub struct GapPoint<const D: usize> {
    /// Nodes and shape functions of the nonmortar side.
    pub own: Vec<(usize, f64)>,
    /// Those of the mortar side; not used against an obstacle.
    pub opposite: Vec<(usize, f64)>,
    /// Contact normal, outward from the nonmortar side.
    pub normal: Point<D>,
    /// The direction in which an obstacle is looked for: the normal of the side.
    pub along: Point<D>,
    /// Gap when it was paired.
    pub gap: f64,
}

/// How the gap of a node follows from those of [`Interface::points`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GapShares {
    /// Points and weights wₖ.
    pub mean: Vec<(usize, f64)>,
    /// The point at the node itself; none where it faces nothing there, and the mean stands for it.
    pub at_node: Option<usize>,
}

impl GapShares {
    /// The same shares of points that others precede.
    pub(super) fn after(self, before: usize) -> Self {
        let mean = self.mean.into_iter();
        Self {
            mean: mean
                .map(|(point, weight)| (before + point, weight))
                .collect(),
            at_node: self.at_node.map(|point| before + point),
        }
    }
}

/// How far what a contact sees has moved since it was paired.
pub struct Moved<'a, const D: usize> {
    /// Displacements of the nodes of the nonmortar body.
    pub own: &'a [Point<D>],
    /// Those of the mortar body; `None` against an obstacle.
    pub other: Option<&'a [Point<D>]>,
    /// Displacement of the obstacle.
    pub obstacle: Point<D>,
}

impl<const D: usize> GapPoint<D> {
    /// The gap between sides, or to a plane, after they have moved.
    pub fn after(&self, moved: &Moved<'_, D>) -> f64 {
        let at = |nodes: &[(usize, f64)], u: &[Point<D>]| {
            let along = nodes.iter().map(|&(j, n)| n * dot(self.normal, u[j]));
            along.sum::<f64>()
        };
        let other = match moved.other {
            Some(u) => at(&self.opposite, u),
            None => dot(self.normal, moved.obstacle),
        };
        self.gap + (other - at(&self.own, moved.own))
    }

    /// The gap to an obstacle that has moved, whatever its shape, from where the nodes of the nonmortar mesh are. NaN where it has
    /// moved out of sight.
    ///
    /// Errors: a gap that is not finite.
    pub fn above(
        &self,
        (rigid, displacement): (&Rigid<D>, Point<D>),
        end: End<'_, D>,
        own: &[Point<D>],
        time: f64,
    ) -> Result<f64, ContactError> {
        let place = (sub(self.place(own), displacement), self.along);
        let found = rigid.opposite(place, time, end)?;
        Ok(found.map_or(f64::NAN, |(_, gap)| gap))
    }

    /// A gap that is given as a function of place and time.
    ///
    /// Errors: a gap that is not finite.
    pub fn given(&self, field: &Field, end: End<'_, D>, time: f64) -> Result<f64, ContactError> {
        finite_gap(field, self.place(end.body.mesh.points()), time, end)
    }

    fn place(&self, points: &[Point<D>]) -> Point<D> {
        let nodes = self.own.iter();
        nodes.fold([0.0; D], |sum, &(node, n)| add_scaled(sum, n, points[node]))
    }
}

impl<const D: usize> Interface<D> {
    /// Evaluates all gaps again by what is the gap of a point now. Pairs, normals, weights and rows stay.
    ///
    /// Errors: those of the points.
    pub fn measure(
        &mut self,
        gap: impl Fn(&GapPoint<D>) -> Result<f64, ContactError>,
    ) -> Result<(), ContactError> {
        let gaps = self
            .points
            .iter()
            .map(gap)
            .collect::<Result<Vec<f64>, _>>()?;
        for node in self.nodes.iter_mut().filter(|node| !node.gap.is_nan()) {
            let mean = node.shares.mean.iter();
            let sum: f64 = mean.map(|&(point, weight)| weight * gaps[point]).sum();
            node.gap = sum / node.shares.mean.iter().map(|share| share.1).sum::<f64>();
            node.clearance = node.shares.at_node.map_or(node.gap, |point| gaps[point]);
        }
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::contact::{
        Against, Coupling, Driven, InitialGap, Row, pair_mortar, pair_nodes, pair_obstacle,
    };
    use crate::fem::{Analysis, Body, Constraints, Elastic, Material};
    use crate::geometry::Surface;
    use crate::mesh::{CellKind, Cuboid, Diagonals, Mesh, Rectangle};
    use std::collections::BTreeMap;

    fn body<const D: usize>(mesh: Mesh<D>) -> Body<D> {
        let elastic = Elastic {
            young: 1.0,
            poisson: 0.3,
        };
        Body {
            name: "body".to_string(),
            mesh,
            materials: vec![Material {
                group: None,
                elastic,
            }],
            thickness: 1.0,
            body_force: std::array::from_fn(|_| Field::constant(0.0)),
            supports: Vec::new(),
            loads: Vec::new(),
            surfaces: BTreeMap::new(),
        }
    }

    pub fn plate(from: Point<2>, to: Point<2>, cells: [usize; 2]) -> Body<2> {
        let rectangle = Rectangle {
            from,
            to,
            cells,
            cell: CellKind::Quad8,
            diagonals: Diagonals::default(),
        };
        body(rectangle.build().unwrap())
    }

    fn cube(z: f64) -> Body<3> {
        let cuboid = Cuboid {
            from: [0.0, 0.0, z],
            to: [1.0, 1.2, z + 1.0],
            cells: [3; 3],
            cell: CellKind::Tet4,
        };
        body(cuboid.build().unwrap())
    }

    pub fn end<'a, const D: usize>(
        body: &'a Body<D>,
        side: &'a str,
        constraints: &'a Constraints<D>,
    ) -> End<'a, D> {
        End {
            body,
            side,
            constraints,
            part: None,
        }
    }

    /// Some displacements of the nodes of a body.
    fn waves<const D: usize>(body: &Body<D>, phase: f64) -> Vec<Point<D>> {
        let points = body.mesh.points().iter();
        let wave = |x: &Point<D>| {
            let along: f64 = x.iter().sum();
            std::array::from_fn(|d| 0.1 * (3.0 * along + phase + d as f64).sin())
        };
        points.map(wave).collect()
    }

    /// The gaps after the nodes have moved are those of the rows, which were integrated apart from them.
    fn check_rows<const D: usize>(
        interface: &Interface<D>,
        nonmortar: End<'_, D>,
        mortar: End<'_, D>,
    ) {
        let (own, other) = (waves(nonmortar.body, 0.2), waves(mortar.body, 1.9));
        let mut again = interface.clone();
        let moved = Moved {
            own: &own,
            other: Some(&other),
            obstacle: [0.0; D],
        };
        again.measure(|point| Ok(point.after(&moved))).unwrap();
        let along = |rows: &[Row<D>], row: usize, u: &[Point<D>]| -> f64 {
            rows[row].iter().map(|&(node, c)| dot(c, u[node])).sum()
        };
        let mut rows = 0;
        for (before, node) in interface.nodes.iter().zip(&again.nodes) {
            let Some(row) = node.rows[0] else { continue };
            let moved =
                along(&interface.nonmortar, row, &own) + along(&interface.mortar, row, &other);
            assert!((node.gap - (before.gap - moved)).abs() < 1e-13, "{node:?}");
            rows += 1;
        }
        assert!(rows > 4);
        // nothing has moved: the same gaps as when they were paired
        again.measure(|point| Ok(point.gap)).unwrap();
        for (before, node) in interface.nodes.iter().zip(&again.nodes) {
            let same = |a: f64, b: f64| (a - b).abs() < 1e-15 || (a.is_nan() && b.is_nan());
            assert!(same(before.gap, node.gap) && same(before.clearance, node.clearance));
        }
    }

    #[test]
    fn nodes_that_have_moved_have_the_gaps_of_their_rows() {
        let (lower, upper) = (
            plate([0.0, 0.0], [3.0, 1.0], [7, 2]),
            plate([0.4, 1.1], [3.6, 2.0], [5, 2]),
        );
        let free = Constraints::default();
        let (nonmortar, mortar) = (end(&upper, "bottom", &free), end(&lower, "top", &free));
        let (gap, coupling) = (InitialGap::Measured, Coupling::Frictional);
        let against = Against::Side(mortar);
        let interface = pair_mortar(
            nonmortar,
            against,
            gap,
            coupling,
            Analysis::PlaneStrain,
            0.0,
        );
        check_rows(&interface.unwrap(), nonmortar, mortar);
        let (lower, upper) = (cube(0.0), cube(1.0));
        let free = Constraints::default();
        let (nonmortar, mortar) = (end(&upper, "bottom", &free), end(&lower, "top", &free));
        let interface = pair_nodes(nonmortar, mortar, gap, coupling, Analysis::Solid, 0.0);
        check_rows(&interface.unwrap(), nonmortar, mortar);
    }

    /// The gaps to a ball that has moved are those to a ball that was always there.
    fn check_ball<const D: usize>(
        nonmortar: End<'_, D>,
        [before, after]: [Point<D>; 2],
        pair: impl Fn(&Rigid<D>) -> Interface<D>,
    ) {
        let ball = |center| Rigid::Surface {
            surface: Surface::Sphere {
                center,
                radius: 2.0,
            },
            inside: false,
        };
        let (was, is) = (ball(before), ball(after));
        let mut interface = pair(&was);
        let own = nonmortar.body.mesh.points();
        let moved = (&was, sub(after, before));
        let gap = |point: &GapPoint<D>| point.above(moved, nonmortar, own, 0.0);
        interface.measure(gap).unwrap();
        for (node, expected) in interface.nodes.iter().zip(pair(&is).nodes) {
            assert!((node.gap - expected.gap).abs() < 1e-14, "{node:?}");
            assert!((node.clearance - expected.clearance).abs() < 1e-14);
        }
    }

    #[test]
    fn an_obstacle_that_has_moved_has_the_gaps_of_one_that_is_there() {
        let free = Constraints::default();
        let plate = plate([0.0, 0.0], [1.0, 1.0], [4, 2]);
        let nonmortar = end(&plate, "top", &free);
        let centers = [[0.3, 3.2], [0.6, 3.1]];
        let analysis = Analysis::PlaneStrain;
        check_ball(nonmortar, centers, |rigid| {
            let against = Against::Obstacle(rigid, Driven::Prescribed);
            let (gap, coupling) = (InitialGap::Measured, Coupling::Normal);
            pair_mortar(nonmortar, against, gap, coupling, analysis, 0.0).unwrap()
        });
        let free = Constraints::default();
        let cube = cube(0.0);
        let nonmortar = end(&cube, "top", &free);
        let centers = [[0.3, 0.5, 3.2], [0.6, 0.4, 3.1]];
        check_ball(nonmortar, centers, |rigid| {
            let obstacle = (rigid, Driven::Prescribed);
            pair_obstacle(nonmortar, obstacle, Coupling::Normal, Analysis::Solid, 0.0).unwrap()
        });
    }
}
