//! The contact normal as a field on the nonmortar side.
//!
//! Where the side has a true surface, its normal. Else unit normals at the nodes, interpolated on each facet: at an end
//! the mean of the facets that meet there, unless they meet at a sharp corner. At the end of a side on a plane of
//! symmetry, in space along its rim there, the polygon's last normal is tilted by half the angle of a facet; it is turned back
//! into that plane, but never by more than the side itself turns there. On the faces of a sector the facets beyond count, too.
//! For the judge, a corner that meets the other side between its faces may have the direction there (`corners.rs`): facets beside it lead
//! over to it.
//!
//! Source: the bisector rule and the axis direction on the axis, Janovský & Procházka (1980) III, section 7.

use crate::contact::curved::true_surface;
use crate::contact::relative::free_part;
use crate::contact::{ContactError, End};
use crate::fem::{TrueSurface, Twins};
use crate::geometry::{Point, add_scaled, dot, sub, unit};
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh, SHARP};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Outward unit normals of a side.
pub(crate) struct Normals<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    at_nodes: HashMap<Facet, [Point<D>; MAX_FACET_NODES]>,
    surface: TrueSurface<'a, D>,
    /// Facets some of whose nodes lean.
    leaning: HashSet<Facet>,
}

impl<'a, const D: usize> Normals<'a, D> {
    /// Normals of the facets of one end of an interface.
    ///
    /// Errors: nodes off the true surface of the side.
    pub fn new(end: End<'a, D>, facets: &[Facet]) -> Result<Self, ContactError> {
        let mesh = &end.body.mesh;
        let surface = true_surface(end, facets)?;
        let mut at_nodes: HashMap<Facet, [Point<D>; MAX_FACET_NODES]> = HashMap::new();
        let mut around: BTreeMap<usize, Vec<(Facet, Point<D>)>> = BTreeMap::new();
        for &facet in facets {
            let kind = mesh.facet_kind(facet);
            let own = at_nodes.entry(facet).or_insert([[0.0; D]; _]);
            let places = mesh.facet_nodes(facet).zip(kind.reference_nodes());
            for (normal, (node, xi)) in own.iter_mut().zip(places) {
                *normal = unit(mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]);
                around
                    .entry(node as usize)
                    .or_default()
                    .push((facet, *normal));
            }
        }
        let own = at_nodes.clone();
        let rim = rim(mesh, facets);
        let whole = with_those_of_twins(end, &around);
        for (&facet, normals) in &mut at_nodes {
            for (normal, node) in normals.iter_mut().zip(mesh.facet_nodes(facet)) {
                let meeting = &whole[&(node as usize)];
                if meeting.len() > 1 {
                    *normal = mean(*normal, meeting);
                }
                if meeting.len() == 1 || rim.contains(&node) {
                    *normal = turned_back(end, node as usize, facet, &own, &around, *normal);
                }
            }
        }
        Ok(Self {
            mesh,
            at_nodes,
            surface,
            leaning: HashSet::new(),
        })
    }

    /// Gives nodes other directions, which the facets around them lead over to.
    pub fn lean(&mut self, nodes: &BTreeMap<usize, Point<D>>) {
        let facets: Vec<Facet> = self.at_nodes.keys().copied().collect();
        for facet in facets {
            let kind = self.mesh.facet_kind(facet);
            let own = self.mesh.facet_nodes(facet).zip(kind.reference_nodes());
            let own: Vec<(Option<&Point<D>>, &[f64; 3])> = own
                .map(|(node, xi)| (nodes.get(&(node as usize)), xi))
                .collect();
            if own.iter().all(|(leaning, _)| leaning.is_none()) {
                continue;
            }
            let mut normals = [[0.0; D]; MAX_FACET_NODES];
            for (normal, (leaning, xi)) in normals.iter_mut().zip(own) {
                *normal = leaning.copied().unwrap_or_else(|| self.at(facet, xi));
            }
            self.at_nodes.insert(facet, normals);
            self.leaning.insert(facet);
        }
    }

    /// Normal at ξ of a facet.
    pub fn at(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let sum = self.interpolated(facet, xi);
        let normal = unit(sum).unwrap_or(sum);
        match self.leaning.contains(&facet) {
            true => normal,
            false => self.surface.along(facet, xi, normal),
        }
    }

    /// Normal of the surface at ξ of a facet for what comes near from outside: that of the facet itself where it is hollow, since two such
    /// facets are two walls.
    pub fn nearby(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let kind = self.mesh.facet_kind(facet);
        let middle = self.mesh.facet_point(facet, &kind.domain().centre());
        let nodes = self.mesh.facet_points(facet).zip(&self.at_nodes[&facet]);
        let spread = |(point, &normal): (Point<D>, &Point<D>)| dot(normal, sub(point, middle));
        match nodes.map(spread).sum::<f64>() < 0.0 {
            true => {
                let own = unit(self.mesh.outward_normal(facet, xi));
                self.surface
                    .along(facet, xi, own.unwrap_or_else(|| self.at(facet, xi)))
            }
            false => self.at(facet, xi),
        }
    }

    /// The sum of the normals at the nodes of a facet with their shape functions at ξ.
    fn interpolated(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let kind = self.mesh.facet_kind(facet);
        let mut shape = [0.0; MAX_FACET_NODES];
        kind.shape(xi, &mut shape);
        let nodal = self.at_nodes[&facet][..kind.nodes()].iter().zip(shape);
        nodal.fold([0.0; D], |sum, (&n, value)| add_scaled(sum, value, n))
    }

    /// Normals at the nodes: the mean of those of the facets that meet there.
    pub fn nodal(&self) -> BTreeMap<usize, Point<D>> {
        let mut facets: Vec<Facet> = self.at_nodes.keys().copied().collect();
        facets.sort_unstable();
        let mut sums: BTreeMap<usize, Point<D>> = BTreeMap::new();
        for facet in facets {
            let kind = self.mesh.facet_kind(facet);
            for (node, xi) in self.mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
                let sum = sums.entry(node as usize).or_insert([0.0; D]);
                *sum = add_scaled(*sum, 1.0, self.at(facet, xi));
            }
        }
        sums.into_iter()
            .filter_map(|(node, sum)| Some((node, unit(sum)?)))
            .collect()
    }
}

/// The facets around each node, and on the faces of a sector those around its twin, with their normals turned.
fn with_those_of_twins<const D: usize>(
    end: End<'_, D>,
    around: &BTreeMap<usize, Vec<(Facet, Point<D>)>>,
) -> BTreeMap<usize, Vec<(Facet, Point<D>)>> {
    let mut whole = around.clone();
    let Some(Twins { turn, pairs }) = end.body.twins() else {
        return whole;
    };
    for [node, twin] in pairs {
        let (Some(own), Some(other)) = (around.get(&node), around.get(&twin)) else {
            continue;
        };
        let back = other.iter().map(|&(facet, n)| (facet, turn.back(n)));
        whole.entry(node).or_default().extend(back);
        let forth = own.iter().map(|&(facet, n)| (facet, turn.vector(n)));
        whole.entry(twin).or_default().extend(forth);
    }
    whole
}

/// Nodes at which some facets end: in space those of the edges there, in the plane the corners of one facet alone.
pub(super) fn ends<const D: usize>(mesh: &Mesh<D>, facets: &[Facet]) -> BTreeSet<u32> {
    if D > 2 {
        return rim(mesh, facets);
    }
    let mut ends = BTreeSet::new();
    for &facet in facets {
        for node in mesh.facet_nodes(facet).take(2) {
            // the second facet of a node takes it out again
            if !ends.insert(node) {
                ends.remove(&node);
            }
        }
    }
    ends
}

/// Nodes on the edges at which some facets of space end; empty in the plane.
fn rim<const D: usize>(mesh: &Mesh<D>, facets: &[Facet]) -> BTreeSet<u32> {
    let mut edges: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for &facet in facets.iter().filter(|_| D > 2) {
        let corners = mesh.facet_kind(facet).corners();
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        for k in 0..corners {
            let (a, b) = (nodes[k], nodes[(k + 1) % corners]);
            let on_edge = [a, b].into_iter().chain(nodes.get(corners + k).copied());
            let edge = edges.entry([a.min(b), a.max(b)]).or_default();
            match edge.is_empty() {
                true => edge.extend(on_edge),
                // two facets meet here
                false => edge.truncate(1),
            }
        }
    }
    let ends = edges.into_values().filter(|nodes| nodes.len() > 1);
    ends.flatten().collect()
}

/// Mean of a facet's normal and those that meet it without a corner.
fn mean<const D: usize>(own: Point<D>, meeting: &[(Facet, Point<D>)]) -> Point<D> {
    let smooth = meeting.iter().filter(|(_, n)| dot(*n, own) > SHARP);
    let sum = smooth.fold([0.0; D], |sum, (_, n)| add_scaled(sum, 1.0, *n));
    unit(sum).unwrap_or(own)
}

/// The normal at the end of a side, in the directions that the supports leave free, if the side is curved enough for that.
fn turned_back<const D: usize>(
    end: End<'_, D>,
    node: usize,
    facet: Facet,
    own: &HashMap<Facet, [Point<D>; MAX_FACET_NODES]>,
    around: &BTreeMap<usize, Vec<(Facet, Point<D>)>>,
    normal: Point<D>,
) -> Point<D> {
    let held = end.constraints.at(node);
    let Some(free) = free_part(normal, held.iter().map(|h| h.axis)) else {
        return normal;
    };
    let angle = |a: Point<D>, b: Point<D>| dot(a, b).clamp(-1.0, 1.0).acos();
    let mesh = &end.body.mesh;
    let neighbours = mesh.facet_nodes(facet).map(|n| n as usize);
    let turns = neighbours
        .flat_map(|n| &around[&n])
        .flat_map(|(other, _)| &own[other][..mesh.facet_kind(*other).nodes()])
        .map(|&other| angle(normal, other));
    let most = turns.filter(|turn| turn.is_finite()).fold(0.0, f64::max);
    let sharp = SHARP.acos();
    if angle(normal, free) <= 1.05 * most.min(sharp) {
        free
    } else {
        normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{end, flat, held, node_at, noise, ring, wall};
    use crate::fem::Constraints;
    use crate::geometry::{Surface, distance, norm};
    use crate::mesh::CellKind;

    fn degrees(angle: f64) -> Point<2> {
        [angle.to_radians().cos(), angle.to_radians().sin()]
    }

    /// The outward normal of a wall below a body whose tangent has this angle.
    fn below(angle: f64) -> Point<2> {
        degrees(angle - 90.0)
    }

    fn along(angles: &[f64]) -> Vec<Point<2>> {
        let mut points = vec![[0.0, 0.0]];
        for &angle in angles {
            points.push(add_scaled(points[points.len() - 1], 1.0, degrees(angle)));
        }
        points
    }

    #[test]
    fn normals_at_nodes_bisect_those_of_the_facets_and_are_interpolated_between() {
        let points = along(&[0.0, 20.0, -10.0]);
        let wall = wall(&points, 5.0, CellKind::Quad4);
        let free = Constraints::default();
        let end = end(&wall, "bottom", &free);
        let facets = end.facets().unwrap();
        let normals = Normals::new(end, facets).unwrap();
        let nodal = normals.nodal();
        let expected = [0.0, 10.0, 5.0, -10.0].map(below);
        for (point, expected) in points.iter().zip(expected) {
            let found = nodal[&node_at(&wall, *point)];
            assert!(distance(found, expected) < 1e-14, "{found:?}");
        }
        // halfway of a facet the bisector of its ends
        for (facet, expected) in facets.iter().zip([5.0, 7.5, -2.5].map(below)) {
            assert!(distance(normals.at(*facet, &[0.0]), expected) < 1e-14);
            assert!((norm(normals.at(*facet, &[0.7])) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn facets_that_meet_at_a_corner_keep_their_normals() {
        for (angle, sharp) in [(30.0, false), (30.1, true)] {
            let points = along(&[0.0, angle]);
            let wall = wall(&points, 5.0, CellKind::Quad4);
            let free = Constraints::default();
            let end = end(&wall, "bottom", &free);
            let facets = end.facets().unwrap();
            let normals = Normals::new(end, facets).unwrap();
            let at_corner = [
                normals.at(facets[0], &[1.0]),
                normals.at(facets[1], &[-1.0]),
            ];
            let expected = match sharp {
                true => [below(0.0), below(angle)],
                false => [below(0.5 * angle); 2],
            };
            for (found, expected) in at_corner.into_iter().zip(expected) {
                assert!(distance(found, expected) < 1e-14, "{angle}");
            }
            // the node itself has the bisector
            let nodal = normals.nodal()[&node_at(&wall, points[1])];
            assert!(distance(nodal, below(0.5 * angle)) < 1e-14);
        }
    }

    #[test]
    fn the_normal_of_a_true_surface_points_out_of_the_body() {
        let mut ring = ring([1.0, 2.0], [1.0, 2.0], 12);
        for (side, radius) in [("inner", 1.0), ("outer", 2.0)] {
            let center = [1.0, 2.0];
            let surface = Surface::Sphere { center, radius };
            ring.surfaces.insert(side.to_string(), Some(surface));
        }
        let free = Constraints::default();
        let mut noise = noise();
        for (side, sign) in [("inner", -1.0), ("outer", 1.0)] {
            let end = end(&ring, side, &free);
            let normals = Normals::new(end, end.facets().unwrap()).unwrap();
            for &facet in end.facets().unwrap() {
                let xi = noise();
                let [x, y] = ring.mesh.facet_point(facet, &[xi]);
                let expected = unit([sign * (x - 1.0), sign * (y - 2.0)]).unwrap();
                assert!(distance(normals.at(facet, &[xi]), expected) < 1e-14);
            }
        }
    }

    /// The normal at the left end of a wall whose first facet is inclined against the second, its first node held along x.
    fn at_held_end(angles: [f64; 2]) -> Point<2> {
        let wall = wall(&along(&angles), 5.0, CellKind::Quad4);
        let first = node_at(&wall, [0.0, 0.0]);
        let supports = held(&[(first, [1.0, 0.0], true)]);
        let end = end(&wall, "bottom", &supports);
        let normals = Normals::new(end, end.facets().unwrap()).unwrap();
        normals.nodal()[&first]
    }

    #[test]
    fn the_normal_at_a_plane_of_symmetry_is_turned_back_as_far_as_the_side_turns_there() {
        // at most 5 % more than from the first facet to the second, and than a corner turns: 1.05 · 30°
        for (angles, turned) in [
            ([10.0, 20.0], true),
            ([10.4, 20.4], true),
            ([10.6, 20.6], false),
            ([-10.4, -20.4], true),
            ([-10.6, -20.6], false),
            ([10.0, 10.0], false),
            ([-31.4, 28.6], true),
            ([-31.6, 28.4], false),
        ] {
            let expected = if turned { below(0.0) } else { below(angles[0]) };
            let found = at_held_end(angles);
            assert!(distance(found, expected) < 1e-14, "{angles:?} {found:?}");
        }
    }

    #[test]
    fn an_end_that_is_held_altogether_keeps_its_normal() {
        let wall = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
        let first = node_at(&wall, [0.0, 0.0]);
        let supports = held(&[(first, [1.0, 0.0], true), (first, [0.0, 1.0], true)]);
        let end = end(&wall, "bottom", &supports);
        let normals = Normals::new(end, end.facets().unwrap()).unwrap();
        assert_eq!(normals.nodal()[&first], [0.0, -1.0]);
    }
}
