//! Sides of meshes as curves: points, normals, and the opposite point of a point.
//!
//! A side runs with its body on the left; its outward normal is the tangent turned by −90°. The normal as a field: the
//! mean of the facets' unit normals where they meet smoothly, interpolated along each facet, or that of the true circle
//! behind the side. Opposite a point x lies the first point of the line x + s·n, forwards or (overlap) backwards, on
//! facets that look the other way.
//! All facets are searched in turn: slow, but without the possible gaps of a tree of boxes.

use crate::cells::along;
use crate::plane::{Vector, cross, dot, length, minus, plus, unit};
use crate::problem::Circle;
use crate::raw::Mesh;
use std::collections::BTreeMap;

/// Facets whose normals have a smaller cosine meet at a corner.
pub const SHARP: f64 = 0.866;

/// Surfaces face each other when the cosine of their normals is below this.
pub const OPPOSED: f64 = -0.1;

/// A facet.
#[derive(Debug, Clone)]
pub struct Facet {
    pub nodes: Vec<usize>,
    points: Vec<Vector>,
    /// Unit normals at the nodes.
    normals: Vec<Vector>,
    pub length: f64,
}

impl Facet {
    /// The point at ξ.
    pub fn point(&self, xi: f64) -> Vector {
        let (n, _) = along(self.points.len(), xi);
        let places = self.points.iter().zip(n);
        places.fold([0.0; 2], |s, (&p, n)| plus(s, n, p))
    }

    /// The derivative of the point with respect to ξ.
    pub fn tangent(&self, xi: f64) -> Vector {
        let (_, slopes) = along(self.points.len(), xi);
        let places = self.points.iter().zip(slopes);
        places.fold([0.0; 2], |s, (&p, n)| plus(s, n, p))
    }

    /// The outward unit normal of the facet itself.
    pub fn own_normal(&self, xi: f64) -> Vector {
        let [x, y] = unit(self.tangent(xi));
        [y, -x]
    }

    /// Rotation of the facet at ξ as coefficients of its nodes' displacements: −n·u'/|x'|.
    pub fn rotation(&self, xi: f64) -> Vec<(usize, Vector)> {
        let (_, slopes) = along(self.points.len(), xi);
        let (n, size) = (self.own_normal(xi), length(self.tangent(xi)));
        let each = self.nodes.iter().zip(slopes);
        each.map(|(&node, slope)| (node, crate::plane::times(-slope / size, n)))
            .collect()
    }

    /// Shape functions of the nodes at ξ.
    pub fn shape(&self, xi: f64) -> Vec<(usize, f64)> {
        let (n, _) = along(self.points.len(), xi);
        self.nodes.iter().copied().zip(n).collect()
    }
}

/// Where a line meets a side.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    pub facet: usize,
    pub xi: f64,
    /// Distance along the line.
    pub distance: f64,
}

/// A side of a body.
#[derive(Debug, Clone)]
pub struct Curve {
    pub facets: Vec<Facet>,
    /// Largest angle between neighbouring facets that meet smoothly, radians.
    pub turn: f64,
    /// Neighbouring facets meet at a corner somewhere.
    pub corners: bool,
    /// Largest length of a facet.
    pub longest: f64,
    /// For each facet the first facet of its smooth part.
    pub sheets: Vec<usize>,
    circle: Option<(Vector, f64)>,
    /// Facets at each node.
    pub around: BTreeMap<usize, Vec<usize>>,
}

impl Curve {
    /// A side of a mesh; a true circle counts when it is given for this side.
    pub fn new(mesh: &Mesh, side: &str, circles: &[Circle]) -> Self {
        let mut facets: Vec<Facet> = mesh.sides[side]
            .iter()
            .map(|nodes| {
                let points: Vec<Vector> = nodes.iter().map(|&n| mesh.points[n]).collect();
                let facet = Facet {
                    length: match points[..] {
                        [a, b, m] => length(minus(m, a)) + length(minus(b, m)),
                        _ => length(minus(points[1], points[0])),
                    },
                    nodes: nodes.clone(),
                    points,
                    normals: Vec::new(),
                };
                let places = [-1.0, 1.0, 0.0].into_iter().take(nodes.len());
                let normals = places.map(|xi| facet.own_normal(xi)).collect();
                Facet { normals, ..facet }
            })
            .collect();
        let mut around: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, facet) in facets.iter().enumerate() {
            for &node in &facet.nodes {
                around.entry(node).or_default().push(index);
            }
        }
        let own: Vec<Vec<Vector>> = facets.iter().map(|f| f.normals.clone()).collect();
        let (mut turn, mut corners) = (0.0f64, false);
        for (index, facet) in facets.iter_mut().enumerate() {
            for (place, node) in facet.nodes.iter().enumerate() {
                let mine = own[index][place];
                let mut sum = [0.0; 2];
                for &other in &around[node] {
                    let at = position(&own[other], &around, other, *node, mesh, side);
                    let cosine = dot(mine, at);
                    if cosine > SHARP {
                        sum = plus(sum, 1.0, at);
                        turn = turn.max(cosine.min(1.0).acos());
                    } else {
                        corners = true;
                    }
                }
                facet.normals[place] = unit(sum);
            }
            let [first, last] = [own[index][0], own[index][1]];
            turn = turn.max(dot(first, last).clamp(-1.0, 1.0).acos());
        }
        let mut sheets: Vec<usize> = (0..facets.len()).collect();
        for (&node, list) in &around {
            for (k, &a) in list.iter().enumerate() {
                for &b in &list[k + 1..] {
                    let [at_a, at_b] =
                        [a, b].map(|f| position(&own[f], &around, f, node, mesh, side));
                    let (low, high) = (sheets[a].min(sheets[b]), sheets[a].max(sheets[b]));
                    if dot(at_a, at_b) > SHARP {
                        sheets
                            .iter_mut()
                            .filter(|s| **s == high)
                            .for_each(|s| *s = low);
                    }
                }
            }
        }
        let circle = circles
            .iter()
            .find(|c| c.side == crate::corners::whole(side));
        Self {
            longest: facets.iter().fold(0.0, |s: f64, f| s.max(f.length)),
            // the angle of a cosine that is one up to rounding
            corners,
            sheets,
            turn: if turn < 1e-7 { 0.0 } else { turn },
            facets,
            circle: circle.map(|c| (c.center, c.radius)),
            around,
        }
    }

    /// The side is straight.
    pub fn straight(&self) -> bool {
        self.turn == 0.0
    }

    /// Distance of the side from the smooth curve that it stands for.
    pub fn sagitta(&self) -> f64 {
        let polygon = self.facets.iter().all(|f| f.nodes.len() == 2);
        let bend = if polygon {
            self.turn / 8.0
        } else {
            self.turn * self.turn / 16.0
        };
        self.longest * bend
    }

    /// The normal field at ξ of a facet.
    pub fn normal(&self, facet: usize, xi: f64) -> Vector {
        let facet = &self.facets[facet];
        if let Some((center, _)) = self.circle {
            let radial = unit(minus(facet.point(xi), center));
            return crate::plane::times(dot(radial, facet.own_normal(xi)).signum(), radial);
        }
        let (n, _) = along(facet.nodes.len(), xi);
        let sum = facet.normals.iter().zip(n);
        unit(sum.fold([0.0; 2], |s, (&normal, n)| plus(s, n, normal)))
    }

    /// Replaces the normals at a node by another, if the angle between the two is at most the turn of the side there.
    pub fn believe_normal(&mut self, node: usize, normal: Vector) -> bool {
        let limit = (1.1 * self.turn + 1e-9).min(1.0);
        let mut near = true;
        for &index in self.around.get(&node).into_iter().flatten() {
            let facet = &mut self.facets[index];
            let Some(place) = facet.nodes.iter().position(|&n| n == node) else {
                continue;
            };
            let own = facet.normals[place];
            if cross(own, normal).abs().asin() <= limit && dot(own, normal) > 0.0 {
                facet.normals[place] = normal;
            } else {
                near = false;
            }
        }
        near
    }

    /// The mean normal at a node.
    pub fn normal_at(&self, node: usize) -> Vector {
        let mut sum = [0.0; 2];
        for &index in self.around.get(&node).into_iter().flatten() {
            let facet = &self.facets[index];
            if let Some(place) = facet.nodes.iter().position(|&n| n == node) {
                sum = plus(sum, 1.0, self.normal(index, [-1.0, 1.0, 0.0][place]));
            }
        }
        unit(sum)
    }

    /// The point of this side on a line from the side of another body.
    pub fn hit(&self, start: Vector, direction: Vector, deepest: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for (index, facet) in self.facets.iter().enumerate() {
            for xi in meetings(facet, start, direction) {
                let distance = dot(minus(facet.point(xi), start), direction);
                let nearer = best.is_none_or(|b| distance.abs() < b.distance.abs());
                let opposed = dot(facet.own_normal(xi), direction) < OPPOSED;
                if nearer && opposed && distance >= -deepest {
                    best = Some(Hit {
                        facet: index,
                        xi,
                        distance,
                    });
                }
            }
        }
        best
    }

    /// Distance along a line from the point on the mesh to the true circle; zero without a true circle.
    pub fn true_offset(&self, at: Vector, direction: Vector) -> f64 {
        let Some((center, radius)) = self.circle else {
            return 0.0;
        };
        nearest_on_circle(at, direction, center, radius).unwrap_or(0.0)
    }
}

/// The normal of a facet at one of its nodes.
fn position(
    normals: &[Vector],
    around: &BTreeMap<usize, Vec<usize>>,
    facet: usize,
    node: usize,
    mesh: &Mesh,
    side: &str,
) -> Vector {
    debug_assert!(around[&node].contains(&facet));
    let place = mesh.sides[side][facet].iter().position(|&n| n == node);
    normals[place.unwrap_or(0)]
}

/// The parameter s of the point x + s·n on a circle that is nearest to x.
pub fn nearest_on_circle(x: Vector, n: Vector, center: Vector, radius: f64) -> Option<f64> {
    let [near, far] = on_circle(x, n, center, radius)?;
    Some(if near.abs() < far.abs() { near } else { far })
}

/// Parameters of the points of a line on a circle, ascending.
pub fn on_circle(x: Vector, n: Vector, center: Vector, radius: f64) -> Option<[f64; 2]> {
    let from = minus(x, center);
    let middle = -dot(from, n);
    let foot = plus(from, middle, n);
    let rest = radius * radius - dot(foot, foot);
    if rest < 0.0 {
        return None;
    }
    // the smaller root from the product of both, which is the power of x
    let far = middle + rest.sqrt().copysign(middle);
    let power = (length(from) - radius) * (length(from) + radius);
    let near = if far == 0.0 { 0.0 } else { power / far };
    Some([near.min(far), near.max(far)])
}

/// Reference coordinates at which a facet meets a line, its ends included.
fn meetings(facet: &Facet, start: Vector, direction: Vector) -> Vec<f64> {
    let across = |x: &Vector| cross(direction, minus(*x, start));
    let heights: Vec<f64> = facet.points.iter().map(across).collect();
    let size = heights.iter().fold(0.0, |s: f64, h| s.max(h.abs()));
    let slack = 1e-10 * facet.length;
    if size == 0.0 || heights.iter().all(|h| *h > slack) || heights.iter().all(|h| *h < -slack) {
        // beyond the heights of its three nodes, a parabola may rise at most by its own sagitta
        if heights.len() < 3 || size > 2.0 * facet.length {
            return Vec::new();
        }
    }
    let roots = match heights[..] {
        [a, b] => vec![(a + b) / (a - b)],
        [a, b, m] => {
            let (p, q, r) = (0.5 * (a + b) - m, 0.5 * (b - a), m);
            quadratic(p, q, r)
        }
        _ => Vec::new(),
    };
    let inside = |xi: &f64| xi.abs() <= 1.0 + 1e-9;
    roots
        .into_iter()
        .filter(inside)
        .map(|xi| xi.clamp(-1.0, 1.0))
        .collect()
}

/// Real roots of p ξ² + q ξ + r.
fn quadratic(p: f64, q: f64, r: f64) -> Vec<f64> {
    let rest = q * q - 4.0 * p * r;
    if rest < 0.0 {
        return Vec::new();
    }
    let s = -0.5 * (q + rest.sqrt().copysign(q));
    let mut roots = Vec::new();
    if s != 0.0 {
        roots.push(r / s);
    } else if r == 0.0 {
        roots.push(0.0);
    }
    if p != 0.0 {
        roots.push(s / p);
    }
    roots.retain(|root| root.is_finite());
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(kinds: usize, n: usize, radius: f64) -> Mesh {
        let mut mesh = Mesh {
            points: Vec::new(),
            cells: Vec::new(),
            sides: BTreeMap::new(),
        };
        let order = kinds - 1;
        for k in 0..=order * n {
            let angle = std::f64::consts::FRAC_PI_2 * k as f64 / (order * n) as f64;
            mesh.points
                .push([radius * angle.cos(), radius * angle.sin()]);
        }
        let facet = |k: usize| match order {
            1 => vec![k, k + 1],
            _ => vec![2 * k, 2 * k + 2, 2 * k + 1],
        };
        mesh.sides
            .insert("arc".to_string(), (0..n).map(facet).collect());
        mesh
    }

    #[test]
    fn normals_of_an_arc_point_outwards() {
        for kinds in [2, 3] {
            let curve = Curve::new(&arc(kinds, 8, 2.0), "arc", &[]);
            for (index, facet) in curve.facets.iter().enumerate() {
                for xi in [-0.7, 0.0, 0.6] {
                    let radial = unit(facet.point(xi));
                    let off = cross(curve.normal(index, xi), radial).abs();
                    // at the ends of the polygon the last facet's own normal is half a facet off
                    let limit = if kinds == 2 { 0.11 } else { 0.01 };
                    assert!(off < limit, "{off}");
                }
            }
            assert!(!curve.straight() && curve.sagitta() > 0.0);
        }
    }

    #[test]
    fn lines_meet_the_arc_where_it_is() {
        for kinds in [2, 3] {
            let mesh = arc(kinds, 8, 2.0);
            let curve = Curve::new(&mesh, "arc", &[]);
            for angle in [0.1, 0.55, 1.2f64] {
                let start = [3.0 * angle.cos(), 3.0 * angle.sin()];
                let inwards = [-angle.cos(), -angle.sin()];
                let hit = curve.hit(start, inwards, 0.1).unwrap();
                let limit = 1.01 * curve.sagitta();
                assert!((hit.distance - 1.0).abs() < limit, "{}", hit.distance);
                // from inside, outwards: the same facets look the same way, nothing is opposite
                assert!(curve.hit([0.0, 0.0], unit(start), 0.1).is_none());
            }
            assert!(curve.hit([3.0, -0.5], [-1.0, 0.0], 0.1).is_none());
        }
    }

    #[test]
    fn a_turned_side_tells_its_rotation() {
        let mesh = arc(3, 4, 2.0);
        let curve = Curve::new(&mesh, "arc", &[]);
        for facet in &curve.facets {
            let turn = |x: Vector| crate::plane::times(0.01, crate::plane::turned(x));
            let found: f64 = facet
                .rotation(0.3)
                .iter()
                .map(|&(n, c)| dot(c, turn(mesh.points[n])))
                .sum();
            assert!((found - 0.01).abs() < 1e-15, "{found}");
        }
    }

    #[test]
    fn circles_are_met_on_their_near_side() {
        let near = nearest_on_circle([2.1, 0.0], [-1.0, 0.0], [0.0; 2], 2.0).unwrap();
        assert!((near - 0.1).abs() < 1e-15);
        assert!(nearest_on_circle([2.1, 3.0], [-1.0, 0.0], [0.0; 2], 2.0).is_none());
    }
}
