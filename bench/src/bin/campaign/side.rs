//! Sides of meshes: points, normals, intersections with lines; and true surfaces.
//!
//! A facet of the plane is a line, which counts as a strip of depth one: its second tangent points along z. The normal as a field:
//! that of the true surface behind the side, else at each node the mean of the facets' unit normals where they meet smoothly,
//! interpolated along each facet. Opposite a point x lies the nearest point of the line x + s·n, forwards or (overlap) backwards,
//! on facets that look the other way.
//! All facets are searched in turn: slow, but without the possible gaps of a tree of boxes.

use crate::cells::{Functions, Kind, Place, Point};
use crate::problem::Surface;
use crate::raw::Mesh;
use crate::vector::{
    across, cross, dot, length, lowered, mean, minus, plus, raised, sum, times, unit,
};
use std::collections::BTreeMap;

/// Facets whose normals have a smaller cosine meet at a corner.
pub const SHARP: f64 = 0.866;

/// Surfaces face each other when the cosine of their normals is below this.
pub const OPPOSED: f64 = -0.1;

/// A point of a facet.
pub struct At<const D: usize> {
    pub x: [f64; D],
    /// Outward normal, its length the area per reference area.
    pub normal: [f64; D],
    /// Shape functions of the nodes of the facet, with their slopes.
    pub shape: Functions,
    tangents: [[f64; 3]; 2],
}

impl<const D: usize> At<D> {
    /// Shape functions of nodes.
    pub fn shape_of(&self, nodes: &[usize]) -> Vec<(usize, f64)> {
        let values = self.shape.iter().map(|(n, _)| *n);
        nodes.iter().copied().zip(values).collect()
    }

    /// Gradients of the shape functions along the facet.
    pub fn gradients(&self) -> Vec<[f64; D]> {
        let [a, b] = self.tangents;
        let normal = raised(self.normal);
        let size = dot(normal, normal);
        let dual = [cross(b, normal), cross(normal, a)].map(|v| times(1.0 / size, v));
        let along = |s: &Place| plus(times(s[0], dual[0]), s[1], dual[1]);
        self.shape.iter().map(|(_, s)| lowered(along(s))).collect()
    }
}

/// A facet.
#[derive(Debug, Clone)]
pub struct Facet<const D: usize> {
    pub nodes: Vec<usize>,
    pub kind: Kind,
    points: Vec<[f64; D]>,
    /// Reference coordinates of the nodes.
    places: Vec<Place>,
    /// Unit normals at the nodes.
    normals: Vec<[f64; D]>,
    /// A ball around the facet.
    pub centre: [f64; D],
    pub radius: f64,
}

impl<const D: usize> Facet<D> {
    fn new(nodes: &[usize], mesh: &Mesh<D>) -> Self {
        let points: Vec<[f64; D]> = nodes.iter().map(|&n| mesh.points[n]).collect();
        let kind = Kind::of_facet(D, nodes.len());
        let centre = mean(&points);
        let far = points.iter().map(|&p| length(minus(p, centre)));
        let mut facet = Self {
            nodes: nodes.to_vec(),
            kind,
            places: kind.nodes(),
            normals: Vec::new(),
            centre,
            // parabolas exceed the hull of their nodes by less than that
            radius: 1.3 * far.fold(0.0, f64::max),
            points,
        };
        let places = facet.places.iter();
        facet.normals = places.map(|&xi| unit(facet.at(xi).normal)).collect();
        facet
    }

    /// Place, normal and shape functions at reference coordinates.
    pub fn at(&self, xi: Place) -> At<D> {
        let shape = self.kind.shape(xi);
        let weighted = |weight: &dyn Fn(&(f64, Place)) -> f64| {
            let pairs = self.points.iter().zip(&shape);
            pairs.fold([0.0; D], |s, (&p, n)| plus(s, weight(n), p))
        };
        let x = weighted(&|n| n.0);
        let along = |d: usize| raised(weighted(&|n| n.1[d]));
        let second = match self.kind.dimension() {
            1 => [0.0, 0.0, 1.0],
            _ => along(1),
        };
        let tangents = [along(0), second];
        At {
            x,
            normal: lowered(cross(tangents[0], tangents[1])),
            shape,
            tangents,
        }
    }

    /// Reference coordinates and weights of a fine Gauss rule.
    pub fn rule(&self) -> Vec<Point> {
        self.kind.fine_rule()
    }

    /// Reference coordinates of a node.
    pub fn place(&self, node: usize) -> Option<Place> {
        let place = self.nodes.iter().position(|&n| n == node)?;
        Some(self.places[place])
    }

    /// The corners, counter-clockwise from outside.
    pub fn corners(&self) -> &[[f64; D]] {
        &self.points[..self.kind.corners().len()]
    }

    /// Length of the longest edge.
    pub fn longest(&self) -> f64 {
        let corners = self.corners();
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        edges.fold(0.0, |s: f64, (&a, &b)| s.max(length(minus(b, a))))
    }

    /// Nodes between corners lie in the middles of straight edges.
    fn straight(&self) -> bool {
        let n = self.corners().len();
        let edges = self.points[n..].iter().take(n).enumerate();
        let mut off = edges.map(|(k, &m)| {
            let ends = mean(&[self.points[k], self.points[(k + 1) % n]]);
            length(minus(m, ends))
        });
        off.all(|off| off < 1e-9 * self.radius)
    }

    /// Where a line meets the facet: reference coordinates, and the distance along it.
    pub fn hit(&self, start: [f64; D], direction: [f64; D]) -> Option<(Place, f64)> {
        if length(across(minus(self.centre, start), direction)) > self.radius {
            return None;
        }
        let way = raised(direction);
        let triangle = self.kind.triangle();
        let middle = if triangle { 1.0 / 3.0 } else { 0.0 };
        let mut xi = [middle, middle, 0.0];
        if self.kind.dimension() == 1 {
            xi[1] = 0.0;
        }
        for _ in 0..20 {
            let at = self.at(xi);
            let [a, b] = at.tangents;
            let off = raised(minus(start, at.x));
            // off = a ξ' + b η' − s direction
            let volume = dot(at.normal, direction);
            let by = [
                dot(cross(off, b), way) / volume,
                dot(cross(a, off), way) / volume,
            ];
            let reach = by[0].abs().max(by[1].abs());
            if !reach.is_finite() || reach > 1e3 {
                return None;
            }
            xi = [xi[0] + by[0], xi[1] + by[1], 0.0];
            // Newton's method squares the error in each step
            if reach < 1e-7 {
                let inside = match triangle {
                    true => xi[0].min(xi[1]).min(1.0 - xi[0] - xi[1]) >= -1e-9,
                    false => xi[0].abs().max(xi[1].abs()) <= 1.0 + 1e-9,
                };
                let distance = dot(minus(self.at(xi).x, start), direction);
                return inside.then_some((xi, distance));
            }
        }
        None
    }
}

/// Where a line meets a side.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    pub facet: usize,
    pub xi: Place,
    /// Distance along the line.
    pub distance: f64,
}

/// A side of a body.
#[derive(Debug, Clone)]
pub struct Skin<const D: usize> {
    pub facets: Vec<Facet<D>>,
    /// Largest angle between neighbouring facets that meet smoothly, and within a facet, radians; zero for a plane side, or one of
    /// plane parts.
    pub turn: f64,
    /// All edges are straight.
    pub straight: bool,
    /// Neighbouring facets meet at a corner somewhere.
    pub corners: bool,
    /// Largest length of an edge.
    pub longest: f64,
    /// For each facet the number of its smooth part.
    pub sheets: Vec<usize>,
    surface: Option<Surface<D>>,
    /// Facets at each node.
    pub around: BTreeMap<usize, Vec<usize>>,
}

impl<const D: usize> Skin<D> {
    /// A side of a mesh, or several joined by plus signs, with the true surface.
    pub fn new(mesh: &Mesh<D>, side: &str, surface: Option<Surface<D>>) -> Self {
        let mut facets: Vec<Facet<D>> = mesh.side(side).map(|f| Facet::new(f, mesh)).collect();
        let mut around: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut meeting: BTreeMap<usize, Vec<(usize, [f64; D])>> = BTreeMap::new();
        for (index, facet) in facets.iter().enumerate() {
            for (&node, &normal) in facet.nodes.iter().zip(&facet.normals) {
                around.entry(node).or_default().push(index);
                meeting.entry(node).or_default().push((index, normal));
            }
        }
        let (mut turn, mut corners) = (0.0f64, false);
        let mut sheets: Vec<usize> = (0..facets.len()).collect();
        for (index, facet) in facets.iter_mut().enumerate() {
            let own = facet.normals.clone();
            for (&node, normal) in facet.nodes.iter().zip(&mut facet.normals) {
                let mut total = [0.0; D];
                for &(other, n) in &meeting[&node] {
                    // a true surface has no corners, even if few facets approximate it
                    if surface.is_none() && dot(n, *normal) <= SHARP {
                        corners = true;
                        continue;
                    }
                    turn = turn.max(length(minus(n, *normal)));
                    total = plus(total, 1.0, n);
                    join(&mut sheets, index, other);
                }
                *normal = unit(total);
                turn = turn.max(length(minus(own[0], *normal)));
            }
        }
        Self {
            turn: if turn < 1e-7 { 0.0 } else { turn },
            straight: facets.iter().all(Facet::straight),
            corners,
            longest: facets.iter().fold(0.0, |s, f| s.max(f.longest())),
            sheets,
            facets,
            surface,
            around,
        }
    }

    /// The side is plane, or its smooth parts are.
    pub fn flat(&self) -> bool {
        self.turn == 0.0
    }

    /// All facets are of first order.
    pub fn linear(&self) -> bool {
        self.facets.iter().all(|f| f.kind.linear())
    }

    /// Distance of the side from the smooth surface that it approximates, which in space may be curved in two directions.
    pub fn sagitta(&self) -> f64 {
        let bend = match self.linear() {
            true => self.turn / 8.0,
            false => self.turn * self.turn / 16.0,
        };
        (D - 1) as f64 * self.longest * bend
    }

    /// The normal field at a point of a facet.
    pub fn normal(&self, facet: usize, at: &At<D>) -> [f64; D] {
        let pairs = self.facets[facet].normals.iter().zip(&at.shape);
        let own = unit(pairs.fold([0.0; D], |s, (&normal, n)| plus(s, n.0, normal)));
        match &self.surface {
            None => own,
            Some(surface) => {
                let normal = surface.normal(at.x);
                times(dot(normal, own).signum(), normal)
            }
        }
    }

    /// The normal of a facet at one of its nodes.
    fn normal_of(&self, facet: usize, node: usize) -> Option<[f64; D]> {
        let own = &self.facets[facet];
        Some(self.normal(facet, &own.at(own.place(node)?)))
    }

    /// The mean normal of some facets at a node.
    pub fn mean_normal(&self, facets: &[usize], node: usize) -> [f64; D] {
        unit(sum(facets.iter().filter_map(|&f| self.normal_of(f, node))))
    }

    /// The mean normal at a node.
    pub fn normal_at(&self, node: usize) -> [f64; D] {
        self.mean_normal(self.around(node), node)
    }

    /// The facets around a node.
    pub fn around(&self, node: usize) -> &[usize] {
        self.around.get(&node).map_or(&[], |facets| facets)
    }

    /// The facets around a node by smooth parts of the side.
    pub fn groups(&self, node: usize) -> Vec<Vec<usize>> {
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &facet in self.around(node) {
            groups.entry(self.sheets[facet]).or_default().push(facet);
        }
        groups.into_values().collect()
    }

    /// A facet and its neighbours in the same smooth part.
    pub fn neighbours(&self, facet: usize) -> impl Iterator<Item = usize> + '_ {
        let nodes = self.facets[facet].nodes.iter();
        let all = nodes.flat_map(|&n| self.around(n).iter().copied());
        all.filter(move |&f| self.sheets[f] == self.sheets[facet])
    }

    /// The normals that the facets around a node have there: more than one at a sharp edge.
    pub fn normals_at(&self, node: usize) -> impl Iterator<Item = [f64; D]> + '_ {
        let around = self.around(node).iter();
        around.filter_map(move |&facet| self.normal_of(facet, node))
    }

    /// Some facets around a node meet in a sharp edge.
    pub fn sharp(&self, node: usize) -> bool {
        let faces: Vec<[f64; D]> = self.normals_at(node).collect();
        let sharp = |a: &[f64; D]| faces.iter().any(|b| dot(*a, *b) <= SHARP);
        faces.iter().any(sharp)
    }

    /// The point of this side on a line from the side of another body.
    pub fn hit(&self, start: [f64; D], direction: [f64; D], deepest: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for (facet, own) in self.facets.iter().enumerate() {
            let Some((xi, distance)) = own.hit(start, direction) else {
                continue;
            };
            let nearer = best.is_none_or(|b| distance.abs() < b.distance.abs());
            if nearer && distance >= -deepest && dot(unit(own.at(xi).normal), direction) < OPPOSED {
                best = Some(Hit {
                    facet,
                    xi,
                    distance,
                });
            }
        }
        best
    }

    /// Distance along a line from the point on the mesh to the true surface; zero without one.
    pub fn true_offset(&self, at: [f64; D], direction: [f64; D]) -> f64 {
        let surface = self.surface.as_ref();
        let meetings = surface.map_or(Vec::new(), |s| s.meets(at, direction));
        let nearest = meetings
            .into_iter()
            .min_by(|a, b| a.abs().total_cmp(&b.abs()));
        nearest.unwrap_or(0.0)
    }
}

/// Two facets are of one smooth part.
fn join(sheets: &mut [usize], a: usize, b: usize) {
    let (low, high) = (sheets[a].min(sheets[b]), sheets[a].max(sheets[b]));
    if low < high {
        let joined = sheets.iter_mut().filter(|s| **s == high);
        joined.for_each(|s| *s = low);
    }
}

impl<const D: usize> Surface<D> {
    /// Centre or point of the axis, the axis, which is zero for a circle or a sphere, the radius, and whether the body is inside.
    pub fn bent(&self) -> Option<([f64; D], [f64; D], f64, bool)> {
        match *self {
            Self::Round {
                center,
                radius,
                inside,
            } => Some((center, [0.0; D], radius, inside)),
            Self::Cylinder {
                point,
                axis,
                radius,
                inside,
            } => Some((point, axis, radius, inside)),
            Self::Gap(_) | Self::Plane { .. } => None,
        }
    }

    /// The unit normal at a point, away from the centre or the axis; zero without a surface.
    pub fn normal(&self, x: [f64; D]) -> [f64; D] {
        match (self, self.bent()) {
            (_, Some((point, axis, ..))) => unit(across(minus(x, point), axis)),
            (Self::Plane { normal, .. }, _) => *normal,
            _ => [0.0; D],
        }
    }

    /// Where a line meets the surface, as distances along it.
    pub fn meets(&self, x: [f64; D], n: [f64; D]) -> Vec<f64> {
        if let Self::Plane { point, normal } = *self {
            return vec![dot(minus(point, x), normal) / dot(n, normal)];
        }
        let Some((point, axis, radius, _)) = self.bent() else {
            return Vec::new();
        };
        let from = across(minus(x, point), axis);
        let along = across(n, axis);
        let (a, b) = (dot(along, along), dot(from, along));
        // the smaller root from the product of both, which is the power of x
        let power = (length(from) - radius) * (length(from) + radius);
        let rest = b * b - a * power;
        if a == 0.0 || rest < 0.0 {
            return Vec::new();
        }
        let far = -(b + rest.sqrt().copysign(b));
        match far == 0.0 {
            true => vec![0.0],
            false => vec![far / a, power / far],
        }
    }

    /// Contact normal and distance from a point with this outward normal, when the surface is a rigid obstacle.
    pub fn opposite(&self, x: [f64; D], n: [f64; D]) -> Option<([f64; D], f64)> {
        if let Self::Plane { point, normal } = *self {
            let faces = dot(n, normal) < OPPOSED;
            return faces.then(|| (times(-1.0, normal), dot(minus(x, point), normal)));
        }
        let Some((point, axis, radius, inside)) = self.bent() else {
            return Some((n, 0.0));
        };
        let sign = if inside { -1.0 } else { 1.0 };
        let faces = |s: &f64| sign * dot(self.normal(plus(x, *s, n)), n) < OPPOSED;
        // a point away from the obstacle has none of its surface behind it
        let clear = sign * (length(across(minus(x, point), axis)) - radius);
        let ahead = |s: &f64| *s >= 0.0 || clear < 1e-12 * radius;
        let facing = self.meets(x, n).into_iter().filter(ahead).filter(faces);
        let nearest = facing.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some((n, nearest))
    }

    /// The direction of the shortest way from a body at a point to the obstacle.
    pub fn way(&self, x: [f64; D]) -> [f64; D] {
        let inside = self.bent().is_some_and(|(.., inside)| inside);
        times(if inside { 1.0 } else { -1.0 }, self.normal(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mutations::{ball, block, body, mesh_of};

    fn arc(nodes: usize, n: usize, radius: f64) -> Mesh {
        let order = nodes - 1;
        let place = |k: usize| {
            let (s, c) = (std::f64::consts::FRAC_PI_2 * k as f64 / (order * n) as f64).sin_cos();
            [radius * c, radius * s]
        };
        let facet = |k: usize| match order {
            1 => vec![k, k + 1],
            _ => vec![2 * k, 2 * k + 2, 2 * k + 1],
        };
        let facets = (0..n).map(facet).collect();
        Mesh {
            points: (0..=order * n).map(place).collect(),
            cells: Vec::new(),
            sides: [("arc".to_string(), facets)].into(),
        }
    }

    #[test]
    fn lines_meet_the_arc_where_it_is_and_normals_point_outwards() {
        for nodes in [2, 3] {
            let skin = Skin::new(&arc(nodes, 8, 2.0), "arc", None);
            assert!(!skin.flat());
            for (index, facet) in skin.facets.iter().enumerate() {
                for xi in [-0.7, 0.0, 0.6] {
                    let at = facet.at([xi, 0.0, 0.0]);
                    let off = length(cross(skin.normal(index, &at), unit(at.x)));
                    // at the ends of the polygon the last facet's own normal is half a facet off
                    assert!(off < if nodes == 2 { 0.11 } else { 0.01 }, "{off}");
                }
            }
            for angle in [0.1, 0.55, 1.2f64] {
                let outwards = [angle.cos(), angle.sin()];
                let start = times(3.0, outwards);
                let hit = skin.hit(start, times(-1.0, outwards), 0.1).unwrap();
                let off = (hit.distance - 1.0).abs();
                assert!(off < 1.01 * skin.sagitta(), "{off}");
                // from inside, outwards: the same facets look the same way, nothing is opposite
                assert!(skin.hit([0.0, 0.0], outwards, 0.1).is_none());
            }
            assert!(skin.hit([3.0, -0.5], [-1.0, 0.0], 0.1).is_none());
        }
    }

    /// Σ (n·u) ∇N is the change of the normal in a rotation, with the opposite sign.
    fn tells_its_rotation<const D: usize>(skin: &Skin<D>) {
        for facet in &skin.facets {
            let at = facet.at([0.3, if D == 2 { 0.0 } else { 0.2 }, 0.0]);
            let spin = if D == 2 {
                [0.0, 0.0, 0.01]
            } else {
                [0.01, -0.02, 0.03]
            };
            let turn = |x: [f64; D]| lowered(cross(spin, raised(x)));
            let normal = unit(at.normal);
            let each = facet.points.iter().zip(at.gradients());
            let found = sum(each.map(|(&x, g)| times(dot(normal, turn(x)), g)));
            let off = length(plus(found, 1.0, turn(normal)));
            assert!(off < 1e-15, "{off}");
        }
    }

    #[test]
    fn a_turned_side_tells_its_rotation() {
        tells_its_rotation(&Skin::new(&arc(3, 4, 2.0), "arc", None));
        let mesh = mesh_of(&body("b", ball([0.0; 3], 1.0, [8, 1]), Kind::Hex20));
        tells_its_rotation(&Skin::new(&mesh, "outer", None));
    }

    #[test]
    fn lines_meet_a_ball_where_it_is_and_normals_point_outwards() {
        for kind in [Kind::Hex8, Kind::Hex20, Kind::Tet4, Kind::Tet10] {
            let mesh = mesh_of(&body("b", ball([1.0, 2.0, 3.0], 2.0, [16, 1]), kind));
            let skin = Skin::new(&mesh, "outer", None);
            let off = 1.5 * skin.sagitta();
            for n in [[1.0, 0.2, 0.1], [-0.3, 0.9, 0.4], [0.1, 0.1, -1.0]].map(unit) {
                let start = plus([1.0, 2.0, 3.0], 3.0, n);
                let hit = skin.hit(start, times(-1.0, n), 0.1).unwrap();
                let far = (hit.distance - 1.0).abs();
                assert!(far < off, "{kind:?} {} {off}", hit.distance);
                let at = skin.facets[hit.facet].at(hit.xi);
                assert!(length(across(minus(at.x, start), n)) < 1e-12);
                let normal = skin.normal(hit.facet, &at);
                assert!(dot(normal, n) > 0.9 && dot(unit(at.normal), n) > 0.8);
                assert!(skin.hit([1.0, 2.0, 3.0], n, 0.1).is_none());
            }
            assert!(!skin.flat());
        }
    }

    #[test]
    fn sides_of_a_box_are_plane_and_look_outwards() {
        for kind in [Kind::Hex8, Kind::Hex27, Kind::Tet10, Kind::Prism15] {
            let shape = block([0.0; 3], [1.0, 2.0, 3.0], [2, 1, 2]);
            let mesh = mesh_of(&body("b", shape, kind));
            for (name, n) in [("left", [-1.0, 0.0, 0.0]), ("top", [0.0, 0.0, 1.0])] {
                let skin = Skin::new(&mesh, name, None);
                assert!(skin.flat() && skin.straight && !skin.corners);
                for &node in skin.around.keys() {
                    assert!(length(minus(skin.normal_at(node), n)) < 1e-14);
                }
            }
            let both = Skin::new(&mesh, "left+top", None);
            assert!(both.flat() && both.corners);
            let first = both.sheets.iter().filter(|s| **s == 0);
            assert_eq!(first.count(), mesh.side("left").count());
        }
    }

    #[test]
    fn surfaces_are_met_on_the_side_that_faces() {
        let down = [0.0, 0.0, -1.0];
        let near = |inside, x| {
            let cylinder = Surface::Cylinder {
                point: [5.0, 0.0, -3.0],
                axis: [1.0, 0.0, 0.0],
                radius: 2.0,
                inside,
            };
            cylinder.opposite(x, down).map(|(_, far)| far)
        };
        let is = |found: Option<f64>, far: f64| (found.unwrap() - far).abs() < 1e-14;
        assert!(is(near(false, [0.0, 0.0, 0.5]), 1.5));
        assert!(is(near(false, [0.0, 1.2, 0.0]), 1.4));
        assert!(is(near(true, [0.0, 0.0, -2.0]), 3.0));
        assert!(near(false, [0.0, 2.1, 0.0]).is_none());
        let circle = crate::problem::round("", [0.0; 2], 2.0).1;
        let far = circle.opposite([2.1, 0.0], [-1.0, 0.0]);
        assert!((far.unwrap().1 - 0.1).abs() < 1e-15);
        assert!(circle.opposite([2.1, 3.0], [-1.0, 0.0]).is_none());
    }
}
