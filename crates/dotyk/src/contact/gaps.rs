//! Updates the gaps of an interface after a motion, without pairing again.
//!
//! ```text
//!   gapᵢ = Σₖ wₖ s(xₖ) / Σₖ wₖ,     s(x) = n·(y − x) + the distances of the meshes from their curves
//! ```
//!
//! Kept: the points x and y that face each other (nodes and shape functions), the normals n, the weights wₖ = ψᵢ(xₖ) dxₖ and the
//! rows. Changed: the nodes of both sides, the obstacle, and the time of a gap that is given as a function.

use crate::contact::obstacle::finite_gap;
use crate::contact::{ContactError, End, Interface};
use crate::geometry::{Field, Point, add_scaled, dot};
use std::borrow::Cow;

/// A point of the nonmortar side and the point opposite it.
#[derive(Debug, Clone, PartialEq)]
pub struct GapPoint<const D: usize> {
    /// Nodes and shape functions of the nonmortar side.
    pub own: Vec<(usize, f64)>,
    /// Those of the mortar side; not used against an obstacle.
    pub opposite: Vec<(usize, f64)>,
    /// Contact normal, outward from the nonmortar side.
    pub normal: Point<D>,
    /// Gap when it was paired.
    pub gap: f64,
}

/// How the gap of a node follows from those of [`Interface::points`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GapShares {
    /// Points and weights wₖ.
    pub mean: Vec<(usize, f64)>,
    /// The point at the node itself; `None` if nothing is opposite there, and the mean replaces it.
    pub at_node: Option<usize>,
}

impl GapShares {
    /// Takes in those of another node, each by its part of the weight of both; a single point stands for both.
    pub(super) fn join(&mut self, other: Self, parts: [f64; 2]) {
        if self.mean.len() < 2 {
            return;
        }
        let sum = |shares: &[(usize, f64)]| shares.iter().map(|share| share.1).sum::<f64>();
        let factors = [parts[0] / sum(&self.mean), parts[1] / sum(&other.mean)];
        self.mean.iter_mut().for_each(|share| share.1 *= factors[0]);
        let further = other.mean.into_iter();
        self.mean
            .extend(further.map(|(point, weight)| (point, factors[1] * weight)));
    }

    /// The same shares, with the indices of points shifted by `before`.
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

/// Displacements of the sides of a contact since it was paired.
pub struct Moved<'a, const D: usize> {
    /// Displacements of the nodes of the nonmortar body.
    pub own: Cow<'a, [Point<D>]>,
    /// Those of the mortar body; `None` against an obstacle.
    pub other: Option<Cow<'a, [Point<D>]>>,
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
        let other = match &moved.other {
            Some(u) => at(&self.opposite, u),
            None => dot(self.normal, moved.obstacle),
        };
        self.gap + (other - at(&self.own, &moved.own))
    }

    /// A gap that is given as a function of place and time.
    ///
    /// Errors: a gap that is not finite.
    pub fn given(&self, field: &Field, end: End<'_, D>, time: f64) -> Result<f64, ContactError> {
        finite_gap(field, self.place(end.body.mesh.points()), time, end)
    }

    /// Its position.
    pub fn place(&self, points: &[Point<D>]) -> Point<D> {
        let nodes = self.own.iter();
        nodes.fold([0.0; D], |sum, &(node, n)| add_scaled(sum, n, points[node]))
    }
}

impl<const D: usize> Interface<D> {
    /// Evaluates all gaps again from the present gaps of the points. Pairs, normals, weights and rows stay.
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
        Against, Corners, Coupling, Driven, InitialGap, Rigid, Row, pair_mortar, pair_nodes,
        pair_obstacle,
    };
    use crate::fem::{Analysis, Body, Constraints, Elastic, Held, Material};
    use crate::geometry::distance;
    use crate::mesh::{CellKind, Cuboid, Diagonals, Mesh, Rectangle, Ring};

    pub fn body<const D: usize>(mesh: Mesh<D>) -> Body<D> {
        let elastic = Elastic {
            young: 1.0,
            poisson: 0.3,
        };
        Body {
            materials: vec![Material {
                group: None,
                elastic,
                strength: None,
                plastic: None,
                ages: None,
            }],
            ..Body::of("body", mesh.into())
        }
    }

    /// A ring of one layer of cells, without a true surface behind its facets.
    pub fn ring(center: Point<2>, [inner, outer]: [f64; 2], around: usize) -> Body<2> {
        let ring = Ring {
            center,
            inner,
            outer,
            angles: None,
            cells: [around, 1],
            ratio: 1.0,
            grade: 1.0,
            cell: CellKind::Quad4,
            diagonals: Default::default(),
        };
        let mut ring = body(ring.build().unwrap());
        for side in ["inner", "outer"] {
            ring.surfaces.insert(side.to_string(), None);
        }
        ring
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

    /// A body between a height and a wall, its side "bottom", through these points from left to right; of quadratic cells every
    /// second one is a middle node.
    pub fn wall(points: &[Point<2>], height: f64, cell: CellKind) -> Body<2> {
        let last = points.len() - 1;
        let rectangle = Rectangle {
            from: [0.0, 0.0],
            to: [last as f64, 1.0],
            cells: [last / cell.order(), 1],
            cell,
            diagonals: Diagonals::default(),
        };
        let mesh = rectangle.build().unwrap().map_points(|[x, y]| {
            let [along, foot] = points[x.round() as usize];
            [along, foot + y * (height - foot)]
        });
        body(mesh.unwrap())
    }

    /// A wall along y = 0 with nodes at these places.
    pub fn flat(places: &[f64], height: f64, cell: CellKind) -> Body<2> {
        let points: Vec<Point<2>> = places.iter().map(|&x| [x, 0.0]).collect();
        wall(&points, height, cell)
    }

    /// The node of a body at a place.
    pub fn node_at<const D: usize>(body: &Body<D>, place: Point<D>) -> usize {
        let mut points = body.mesh.points().iter();
        points.position(|&x| distance(x, place) < 1e-9).unwrap()
    }

    /// Held directions of nodes, and whether they are zero at all times.
    pub fn held<const D: usize>(directions: &[(usize, Point<D>, bool)]) -> Constraints<D> {
        let mut constraints = Constraints::default();
        for &(node, axis, still) in directions {
            let held = Held {
                axis,
                value: 0.0,
                terms: 0.0,
                still,
                supports: Vec::new(),
            };
            constraints.nodes.entry(node).or_default().push(held);
        }
        constraints
    }

    /// Numbers in [−1, 1), the same at every run.
    pub fn noise() -> impl FnMut() -> f64 {
        let mut state = 1u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    pub fn cube(z: f64) -> Body<3> {
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

    /// Two meshes of one block each as one, without sides.
    pub fn together<const D: usize>(a: &Mesh<D>, b: &Mesh<D>) -> Mesh<D> {
        let first = a.points().len() as u32;
        let points = a.points().iter().chain(b.points()).copied();
        let mut blocks = [a.blocks(), b.blocks()].concat();
        let moved = blocks[1].nodes.iter_mut();
        moved.for_each(|node| *node += first);
        Mesh::new(points.collect(), blocks).unwrap()
    }

    /// Some displacements of the nodes of a body; affine, so that the mean in a row is the value at one place.
    fn strained<const D: usize>(body: &Body<D>, phase: f64) -> Vec<Point<D>> {
        let points = body.mesh.points().iter();
        let moved = |x: &Point<D>| {
            let component = |d: usize| -> f64 {
                let slope = |k: usize| (3.0 * phase + 1.7 * d as f64 + k as f64).sin();
                phase + (0..D).map(|k| 0.1 * slope(k) * x[k]).sum::<f64>()
            };
            std::array::from_fn(component)
        };
        points.map(moved).collect()
    }

    /// The gaps after the nodes have moved are those of the rows, which were integrated apart from them.
    fn check_rows<const D: usize>(
        interface: &Interface<D>,
        nonmortar: End<'_, D>,
        mortar: End<'_, D>,
    ) {
        let (own, other) = (strained(nonmortar.body, 0.2), strained(mortar.body, 1.9));
        let mut again = interface.clone();
        let moved = Moved {
            own: Cow::Borrowed(&own),
            other: Some(Cow::Borrowed(&other)),
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
        // no motion: the same gaps as when they were paired
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

    #[test]
    fn a_given_gap_at_another_time_is_that_of_an_interface_of_that_time() {
        let field = Field::function("0.1 + t x", |p, t| 0.1 + t * p[0]);
        let rigid = Rigid::Gap(field.clone());
        let check = |nonmortar: End<'_, 3>, pair: &dyn Fn(f64) -> Interface<3>| {
            let mut interface = pair(0.0);
            let gap = |point: &GapPoint<3>| point.given(&field, nonmortar, 2.0);
            interface.measure(gap).unwrap();
            for (node, expected) in interface.nodes.iter().zip(pair(2.0).nodes) {
                assert!((node.gap - expected.gap).abs() < 1e-14, "{node:?}");
                assert!((node.clearance - expected.clearance).abs() < 1e-14);
            }
        };
        let (cube, free) = (cube(0.0), Constraints::default());
        let nonmortar = end(&cube, "top", &free);
        let coupling = Coupling::Normal;
        check(nonmortar, &|time| {
            let obstacle = (&rigid, Driven::Prescribed, &Corners::new());
            pair_obstacle(nonmortar, obstacle, coupling, Analysis::Solid, time).unwrap()
        });
        check(nonmortar, &|time| {
            let against = Against::Obstacle(&rigid, Driven::Prescribed);
            let gap = InitialGap::Measured;
            pair_mortar(nonmortar, against, gap, coupling, Analysis::Solid, time).unwrap()
        });
    }

    #[test]
    fn the_gap_of_a_point_follows_both_sides_or_the_obstacle() {
        let point = GapPoint {
            own: vec![(0, 0.25), (2, 0.75)],
            opposite: vec![(1, 1.0)],
            normal: [0.6, 0.8],
            gap: 10.0,
        };
        let own = [[1.0, 0.0], [9.0, 9.0], [0.0, 2.0]];
        let other = [[9.0, 9.0], [5.0, 0.0]];
        // 0.25 · 0.6 + 0.75 · 1.6 = 1.35 towards the other side, which moves away by 3, the obstacle by 4
        for (other, obstacle, gap) in [
            (Some(&other[..]), [7.0, 7.0], 10.0 - 1.35 + 3.0),
            (None, [0.0, 5.0], 10.0 - 1.35 + 4.0),
        ] {
            let moved = Moved {
                own: Cow::Borrowed(&own),
                other: other.map(Cow::Borrowed),
                obstacle,
            };
            assert!((point.after(&moved) - gap).abs() < 1e-14);
        }
    }

    #[test]
    fn a_given_gap_is_taken_where_the_point_is_undeformed() {
        let (plate, free) = (
            flat(&[0.0, 2.0], 1.0, CellKind::Quad4),
            Constraints::default(),
        );
        let nonmortar = end(&plate, "bottom", &free);
        let ends = [node_at(&plate, [0.0, 0.0]), node_at(&plate, [2.0, 0.0])];
        let point = GapPoint {
            own: vec![(ends[0], 0.25), (ends[1], 0.75)],
            opposite: Vec::new(),
            normal: [0.0, -1.0],
            gap: 0.0,
        };
        let field = Field::function("x + 10 t", |p, t| p[0] + 10.0 * t);
        assert_eq!(point.given(&field, nonmortar, 2.0), Ok(21.5));
        let broken = Field::constant(f64::INFINITY);
        assert!(point.given(&broken, nonmortar, 0.0).is_err());
    }

    #[test]
    fn a_mean_stands_for_the_gap_at_a_node_that_faces_nothing() {
        let (upper, lower) = (
            flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4),
            flat(&[-1.0, 1.5], -1.0, CellKind::Quad4),
        );
        let free = Constraints::default();
        let against = Against::Side(end(&lower, "bottom", &free));
        let interface = pair_mortar(
            end(&upper, "bottom", &free),
            against,
            InitialGap::Closed,
            Coupling::Normal,
            Analysis::PlaneStrain,
            0.0,
        );
        let mut interface = interface.unwrap();
        let gap = |point: &GapPoint<2>| {
            // a slope, so that means and nodes differ
            let place = point
                .own
                .iter()
                .map(|&(j, n)| n * upper.mesh.points()[j][0]);
            Ok(1.0 + place.sum::<f64>())
        };
        interface.measure(gap).unwrap();
        let [first, middle, last] = &interface.nodes[..] else {
            panic!("three nodes");
        };
        // biorthogonal functions of the whole facet take linear ones at its node
        assert!((first.gap - 1.0).abs() < 1e-13 && (first.clearance - 1.0).abs() < 1e-15);
        assert!((middle.clearance - 2.0).abs() < 1e-15);
        // half of the facet is covered: its end is
        assert!((last.gap - 2.5).abs() < 1e-13, "{}", last.gap);
        assert_eq!(last.clearance, last.gap);
        let error = ContactError::NeitherPlaneNorSpace {
            side: String::new(),
        };
        assert_eq!(
            interface.measure(|_| Err(error.clone())),
            Err(error.clone())
        );
    }

    #[test]
    fn shares_after_other_points_count_on() {
        let shares = GapShares {
            mean: vec![(0, 0.5), (3, 1.5)],
            at_node: Some(2),
        };
        let expected = GapShares {
            mean: vec![(7, 0.5), (10, 1.5)],
            at_node: Some(9),
        };
        assert_eq!(shares.after(7), expected);
        assert_eq!(GapShares::default().after(7), GapShares::default());
    }
}
