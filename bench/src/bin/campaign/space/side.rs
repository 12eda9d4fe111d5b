//! Sides of meshes as surfaces: points, normals, intersections with lines; and true surfaces.
//!
//! The normal as a field: that of the true surface behind the side, else at each node the mean of the facets' unit normals
//! where they meet smoothly, interpolated along each facet. All facets are searched in turn: slow, but without the possible gaps
//! of a tree of boxes.

use super::Mesh;
use super::geometry::{Vector, across, cross, dot, length, mean, minus, plus, times, unit};
use super::problem::{Form, Surface};
use crate::cells::Kind;
use crate::side::{OPPOSED, SHARP};
use std::collections::BTreeMap;

/// The kind of a facet with this number of nodes.
pub fn kind(nodes: usize) -> Kind {
    match nodes {
        3 => Kind::Tri3,
        4 => Kind::Quad4,
        6 => Kind::Tri6,
        8 => Kind::Quad8,
        _ => Kind::Quad9,
    }
}

/// Reference coordinates of the nodes of a facet.
fn places(kind: Kind) -> Vec<[f64; 2]> {
    let corners: &[[f64; 2]] = match kind.triangle() {
        true => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        false => &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
    };
    let mut places = corners.to_vec();
    for (k, &a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        places.push([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
    }
    places.push([0.0; 2]);
    places
}

/// A point of a facet.
pub struct At {
    pub x: Vector,
    /// Outward normal, its length the area per reference area.
    pub normal: Vector,
    /// Shape functions of the nodes of the facet.
    pub shape: Vec<f64>,
    tangents: [Vector; 2],
}

/// A facet.
#[derive(Debug, Clone)]
pub struct Facet {
    pub nodes: Vec<usize>,
    pub kind: Kind,
    pub points: Vec<Vector>,
    /// Unit normals at the nodes.
    normals: Vec<Vector>,
    /// A ball around the facet.
    centre: Vector,
    radius: f64,
}

impl Facet {
    fn new(nodes: &[usize], mesh: &Mesh) -> Self {
        let points: Vec<Vector> = nodes.iter().map(|&n| mesh.points[n]).collect();
        let kind = kind(nodes.len());
        let centre = mean(&points);
        let far = points.iter().map(|&p| length(minus(p, centre)));
        let mut facet = Self {
            nodes: nodes.to_vec(),
            kind,
            normals: Vec::new(),
            centre,
            // parabolas exceed the hull of their nodes by less than that
            radius: 1.3 * far.fold(0.0, f64::max),
            points,
        };
        let normals = places(kind).into_iter().take(nodes.len());
        facet.normals = normals.map(|xi| unit(facet.at(xi).normal)).collect();
        facet
    }

    /// Place, normal and shape functions at reference coordinates.
    pub fn at(&self, xi: [f64; 2]) -> At {
        let (shape, slopes) = self.kind.shape(xi);
        let sum = |weights: &dyn Fn(usize) -> f64| {
            let points = self.points.iter().enumerate();
            points.fold([0.0; 3], |s, (k, &p)| plus(s, weights(k), p))
        };
        let tangents = [sum(&|k| slopes[k][0]), sum(&|k| slopes[k][1])];
        At {
            x: sum(&|k| shape[k]),
            normal: cross(tangents[0], tangents[1]),
            shape,
            tangents,
        }
    }

    /// Reference coordinates and weights of a fine Gauss rule.
    pub fn rule(&self) -> Vec<([f64; 2], f64)> {
        self.kind.fine_rule()
    }

    /// The corners, counter-clockwise from outside.
    pub fn corners(&self) -> &[Vector] {
        &self.points[..if self.kind.triangle() { 3 } else { 4 }]
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
    pub fn hit(&self, start: Vector, direction: Vector) -> Option<([f64; 2], f64)> {
        if length(across(minus(self.centre, start), direction)) > self.radius {
            return None;
        }
        let triangle = self.kind.triangle();
        let mut xi = if triangle { [1.0 / 3.0; 2] } else { [0.0; 2] };
        for _ in 0..20 {
            let at = self.at(xi);
            let [a, b] = at.tangents;
            let off = minus(start, at.x);
            // off = a ξ' + b η' − s direction
            let volume = dot(at.normal, direction);
            let by = [
                dot(cross(off, b), direction) / volume,
                dot(cross(a, off), direction) / volume,
            ];
            let reach = by[0].abs().max(by[1].abs());
            if !reach.is_finite() || reach > 1e3 {
                return None;
            }
            xi = [xi[0] + by[0], xi[1] + by[1]];
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
    pub xi: [f64; 2],
    /// Distance along the line.
    pub distance: f64,
}

/// A side of a body.
#[derive(Debug, Clone)]
pub struct Skin {
    pub facets: Vec<Facet>,
    /// Largest angle between neighbouring facets that meet smoothly, and within a facet, radians; zero for a plane side.
    pub turn: f64,
    /// All edges are straight.
    pub straight: bool,
    /// Largest length of an edge.
    pub longest: f64,
    surface: Option<Surface>,
    /// Facets at each node.
    pub around: BTreeMap<usize, Vec<usize>>,
}

impl Skin {
    /// A side of a mesh, with its true surface.
    pub fn new(mesh: &Mesh, side: &str, surface: Option<Surface>) -> Self {
        let sides = mesh.sides[side].iter();
        let mut facets: Vec<Facet> = sides.map(|nodes| Facet::new(nodes, mesh)).collect();
        let mut around: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut meeting: BTreeMap<usize, Vec<Vector>> = BTreeMap::new();
        for (index, facet) in facets.iter().enumerate() {
            for (&node, &normal) in facet.nodes.iter().zip(&facet.normals) {
                around.entry(node).or_default().push(index);
                meeting.entry(node).or_default().push(normal);
            }
        }
        let mut turn = 0.0f64;
        for facet in &mut facets {
            let own = facet.normals.clone();
            for (&node, normal) in facet.nodes.iter().zip(&mut facet.normals) {
                // a true surface has no corners, even if few facets approximate it
                let known = surface.is_some();
                let meets = |n: &&Vector| known || dot(**n, *normal) > SHARP;
                let smooth = meeting[&node].iter().filter(meets);
                let mut sum = [0.0; 3];
                for &other in smooth {
                    turn = turn.max(length(minus(other, *normal)));
                    sum = plus(sum, 1.0, other);
                }
                *normal = unit(sum);
                turn = turn.max(length(minus(own[0], *normal)));
            }
        }
        Self {
            turn: if turn < 1e-7 { 0.0 } else { turn },
            straight: facets.iter().all(Facet::straight),
            longest: facets.iter().fold(0.0, |s, f| s.max(f.longest())),
            facets,
            surface,
            around,
        }
    }

    /// The side is plane.
    pub fn flat(&self) -> bool {
        self.turn == 0.0
    }

    /// All facets are of first order.
    pub fn linear(&self) -> bool {
        self.facets.iter().all(|f| f.kind.linear())
    }

    /// Distance of the side from the smooth surface that it approximates, which may be curved in two directions.
    pub fn sagitta(&self) -> f64 {
        let bend = match self.linear() {
            true => self.turn / 4.0,
            false => self.turn * self.turn / 8.0,
        };
        self.longest * bend
    }

    /// The normal field at a point of a facet.
    pub fn normal(&self, facet: usize, at: &At) -> Vector {
        let facet = &self.facets[facet];
        let pairs = facet.normals.iter().zip(&at.shape);
        let own = unit(pairs.fold([0.0; 3], |s, (&normal, n)| plus(s, *n, normal)));
        match self.surface {
            None => own,
            Some(surface) => {
                let normal = surface.normal(at.x);
                times(dot(normal, own).signum(), normal)
            }
        }
    }

    /// The mean normal at a node.
    pub fn normal_at(&self, node: usize) -> Vector {
        let normals = self.normals_at(node);
        unit(normals.fold([0.0; 3], |sum, normal| plus(sum, 1.0, normal)))
    }

    /// The normals that the facets around a node have there: more than one at a sharp edge.
    pub fn normals_at(&self, node: usize) -> impl Iterator<Item = Vector> + '_ {
        let around = self.around.get(&node).into_iter().flatten();
        around.filter_map(move |&index| {
            let facet = &self.facets[index];
            let place = facet.nodes.iter().position(|&n| n == node)?;
            Some(self.normal(index, &facet.at(places(facet.kind)[place])))
        })
    }

    /// Reference coordinates of a node on a facet.
    pub fn place(&self, facet: usize, node: usize) -> Option<[f64; 2]> {
        let facet = &self.facets[facet];
        let place = facet.nodes.iter().position(|&n| n == node)?;
        Some(places(facet.kind)[place])
    }

    /// The point of this side on a line from the side of another body.
    pub fn hit(&self, start: Vector, direction: Vector, deepest: f64) -> Option<Hit> {
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
    pub fn true_offset(&self, at: Vector, direction: Vector) -> f64 {
        let meetings = self.surface.map_or(Vec::new(), |s| s.meets(at, direction));
        let nearest = meetings
            .into_iter()
            .min_by(|a, b| a.abs().total_cmp(&b.abs()));
        nearest.unwrap_or(0.0)
    }
}

impl Surface {
    /// The unit normal at a point, away from the centre or the axis.
    pub fn normal(&self, x: Vector) -> Vector {
        match self.form {
            Form::Plane => self.axis,
            _ => unit(across(minus(x, self.point), self.axis)),
        }
    }

    /// Where a line meets the surface, as distances along it.
    pub fn meets(&self, x: Vector, n: Vector) -> Vec<f64> {
        if self.form == Form::Plane {
            return vec![dot(minus(self.point, x), self.axis) / dot(n, self.axis)];
        }
        // the axis of a sphere is zero, so that `across` changes nothing
        let from = across(minus(x, self.point), self.axis);
        let along = across(n, self.axis);
        let (a, b) = (dot(along, along), dot(from, along));
        let power = (length(from) - self.radius) * (length(from) + self.radius);
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
    pub fn opposite(&self, inside: bool, x: Vector, n: Vector) -> Option<(Vector, f64)> {
        if self.form == Form::Plane {
            let away = dot(minus(x, self.point), self.axis);
            let faces = dot(n, self.axis) < OPPOSED;
            return faces.then(|| (times(-1.0, self.axis), away));
        }
        let sign = if inside { -1.0 } else { 1.0 };
        let faces = |s: &f64| sign * dot(self.normal(plus(x, *s, n)), n) < OPPOSED;
        // a point away from the obstacle has none of its surface behind it
        let clear = sign * (length(across(minus(x, self.point), self.axis)) - self.radius);
        let ahead = |s: &f64| *s >= 0.0 || clear < 1e-12 * self.radius;
        let facing = self.meets(x, n).into_iter().filter(ahead).filter(faces);
        let nearest = facing.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some((n, nearest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::mutations::{ball, body, cuboid, mesh_of};
    use crate::space::solids::Solid;

    #[test]
    fn lines_meet_a_ball_where_it_is_and_normals_point_outwards() {
        for kind in [Solid::Hex8, Solid::Hex20, Solid::Tet4, Solid::Tet10] {
            let mesh = mesh_of(&body("b", ball([1.0, 2.0, 3.0], 2.0, [16, 1]), kind));
            let skin = Skin::new(&mesh, "outer", None);
            let off = 1.5 * skin.sagitta();
            for n in [[1.0, 0.2, 0.1], [-0.3, 0.9, 0.4], [0.1, 0.1, -1.0]].map(unit) {
                let start = plus([1.0, 2.0, 3.0], 3.0, n);
                let hit = skin.hit(start, times(-1.0, n), 0.1).unwrap();
                assert!(
                    (hit.distance - 1.0).abs() < off,
                    "{kind:?} {} {off}",
                    hit.distance
                );
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
        for kind in [Solid::Hex8, Solid::Hex27, Solid::Tet10, Solid::Prism15] {
            let mesh = mesh_of(&body(
                "b",
                cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 1, 2]),
                kind,
            ));
            for (name, n) in [("left", [-1.0, 0.0, 0.0]), ("top", [0.0, 0.0, 1.0])] {
                let skin = Skin::new(&mesh, name, None);
                assert!(skin.flat() && skin.straight);
                for &node in skin.around.keys() {
                    assert!(length(minus(skin.normal_at(node), n)) < 1e-14);
                }
            }
        }
    }

    #[test]
    fn surfaces_are_met_on_the_side_that_faces() {
        let (down, cylinder) = (
            [0.0, 0.0, -1.0],
            Surface::cylinder([5.0, 0.0, -3.0], [1.0, 0.0, 0.0], 2.0),
        );
        let near = |inside, x| cylinder.opposite(inside, x, down).unwrap().1;
        assert!((near(false, [0.0, 0.0, 0.5]) - 1.5).abs() < 1e-14);
        assert!((near(false, [0.0, 1.2, 0.0]) - 1.4).abs() < 1e-14);
        assert!((near(true, [0.0, 0.0, -2.0]) - 3.0).abs() < 1e-14);
        assert!(cylinder.opposite(false, [0.0, 2.1, 0.0], down).is_none());
    }
}
