//! Cuts of the facets of a side in space, so that on each piece all shape functions of both sides are smooth.
//!
//! A facet is cut in a *chart*, two coordinates in which its edges are straight: its reference coordinates if the facet is affine,
//! or coordinates of its plane if it is a plane quadrilateral that is not affine. In the chart a corner y of the other side's
//! facets has the place ξ from which a line along the contact normal meets it,
//!
//! ```text
//!   x(ξ) + s n(ξ) = y,
//! ```
//!
//! and each of these facets cuts out a convex polygon (I. E. Sutherland and G. W. Hodgman, Commun. ACM 17 (1974) 32–42), which is
//! integrated triangle by triangle. On plane sides all cuts are exact. On curved ones their edges are straight lines of the chart
//! between exact ends: rows stay in balance, because every point of integration has its own line along n; only the kinks of shape
//! functions are misplaced, by an amount that depends on the turn between neighbouring facets.

use crate::contact::Against;
use crate::contact::functions::{Cell, Piece};
use crate::contact::opposite::Opposite;
use crate::contact::search::{Line, Prism, meet};
use crate::fem::quadrature::{QuadraturePoint, rule};
use crate::geometry::{
    Point, Settling, add_scaled, bounding_box, centroid, clip, cross, dot, invert, norm, sub, unit,
};
use crate::mesh::{CellKind, Domain, Facet, Mesh};
use rayon::prelude::*;

/// The pieces of all cells with an opposite, in their order; a cell is a whole facet.
pub(super) fn pieces(sides: &Opposite<'_, 3>, cells: &[Cell]) -> Vec<Piece> {
    let each = cells.par_iter().enumerate();
    each.flat_map_iter(|(index, cell)| match sides.against {
        Against::Side(mortar) => cut(sides, &mortar.body.mesh, index, cell),
        Against::Obstacle(..) => over_obstacle(sides, index, cell).into_iter().collect(),
    })
    .collect()
}

/// The whole of a facet whose corners and middle face the obstacle.
fn over_obstacle(sides: &Opposite<'_, 3>, index: usize, cell: &Cell) -> Option<Piece> {
    let Against::Obstacle(rigid, _) = sides.against else {
        return None;
    };
    let kind = sides.mesh().facet_kind(cell.facet);
    let [x, y, _] = kind.domain().centre();
    let middle = [x, y];
    let mut places = cell.places.iter().chain([&middle]);
    let faces = |xi: &[f64; 2]| {
        let line = sides.line(cell.facet, xi);
        rigid.faces(line.start, line.direction)
    };
    let points = rule(kind, degree(kind) + functions_degree(kind) + CURVED);
    places.all(faces).then(|| Piece {
        cell: index,
        opposite: None,
        corners: cell.places.clone(),
        part: 1.0,
        points: points.iter().map(flat).collect(),
    })
}

fn flat(point: &QuadraturePoint) -> ([f64; 2], f64) {
    ([point.xi[0], point.xi[1]], point.weight)
}

/// Cuts a facet into the parts that face facets of the other side.
fn cut(sides: &Opposite<'_, 3>, other: &Mesh<3>, index: usize, cell: &Cell) -> Vec<Piece> {
    let Some(search) = &sides.search else {
        return Vec::new();
    };
    let chart = Chart::new(sides, cell);
    let seen = |facet: Facet| {
        let outlines = outlines(other, facet).into_iter();
        let parts = outlines.map(|outline| chart.cut_by(&outline));
        let parts = parts.filter(|polygon| area(polygon) >= SLIVER * chart.area);
        parts.map(move |polygon| Part { facet, polygon })
    };
    let parts = search.within(&chart.prism).into_iter().flat_map(seen);
    let parts = chart.visible(sides, other, parts.collect());
    let seen = |part: &Part| chart.sees(sides, other, part.facet, centroid(&part.polygon));
    let piece = |Part { facet, polygon }: Part| {
        let degree = chart.degree(other, facet);
        let points = chart.points(&polygon, degree)?;
        let corners: Option<Vec<[f64; 2]>> = polygon.iter().map(|&c| chart.xi(c)).collect();
        Some(Piece {
            cell: index,
            opposite: Some(facet),
            corners: corners?,
            part: area(&polygon) / chart.area,
            points,
        })
    };
    parts.into_iter().filter(seen).filter_map(piece).collect()
}

/// The part of a chart in front of a facet of the other side: a convex polygon, counter-clockwise.
struct Part {
    facet: Facet,
    polygon: Vec<[f64; 2]>,
}

/// Pieces smaller than this part of their facet are rounding.
const SLIVER: f64 = 1e-12;

/// Lengths below this part of a facet are rounding.
const LENGTH_ROUNDING: f64 = 1e-9;

/// A facet of the nonmortar side, and coordinates in which it is cut.
struct Chart<'a> {
    mesh: &'a Mesh<3>,
    facet: Facet,
    kind: CellKind,
    /// The facet's plane, if its coordinates replace those of the reference facet.
    plane: Option<Plane>,
    /// Corners in these coordinates, counter-clockwise.
    polygon: Vec<[f64; 2]>,
    area: f64,
    /// Contact normals at the corners.
    normals: Vec<Point<3>>,
    prism: Prism,
    shape: Form,
    /// All normals are the same.
    parallel: bool,
}

/// A plane with two axes.
#[derive(Clone, Copy)]
struct Plane {
    origin: Point<3>,
    axes: [Point<3>; 2],
    normal: Point<3>,
}

impl Plane {
    fn coordinates(&self, x: Point<3>) -> [f64; 2] {
        self.axes.map(|axis| dot(axis, sub(x, self.origin)))
    }
}

/// The shape of a facet.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    /// An affine image of its reference facet.
    Affine,
    /// Plane, with straight edges; how far it is from affine, as part of its size.
    Plane(f64),
    Curved,
}

/// The shape of a facet, with its middle and size.
fn form(mesh: &Mesh<3>, facet: Facet) -> (Form, Plane, f64) {
    let kind = mesh.facet_kind(facet);
    let centre = kind.domain().centre();
    let points: Vec<Point<3>> = mesh.facet_points(facet).collect();
    let corners = kind.corners();
    let origin = mesh.facet_point(facet, &centre);
    let normal = unit(mesh.outward_normal(facet, &centre)).unwrap_or([0.0; 3]);
    let tangents = mesh.facet_tangents(facet, &centre);
    let first = unit(tangents[0]).unwrap_or([0.0; 3]);
    let plane = Plane {
        origin,
        axes: [first, cross(normal, first)],
        normal,
    };
    let away = |x: &Point<3>| norm(sub(*x, origin));
    let size = points.iter().map(away).fold(0.0, f64::max);
    let off_plane = |x: &Point<3>| dot(normal, sub(*x, origin)).abs();
    let level = points.iter().map(off_plane).fold(0.0, f64::max) <= LENGTH_ROUNDING * size;
    let linear = kind.domain().linear();
    let mut straight = true;
    for (xi, point) in kind.reference_nodes().iter().zip(&points).skip(corners) {
        let mut hats = [0.0; 4];
        linear.shape(xi, &mut hats);
        let middle = hats[..corners].iter().zip(&points);
        let middle = middle.fold([0.0; 3], |sum, (&h, &x)| add_scaled(sum, h, x));
        straight &= norm(sub(middle, *point)) <= LENGTH_ROUNDING * size;
    }
    let taper = match points[..corners] {
        [a, b, c, d] => norm(sub(add_scaled(a, 1.0, c), add_scaled(b, 1.0, d))) / (4.0 * size),
        _ => 0.0,
    };
    let form = match (straight, level) {
        (true, _) if taper <= LENGTH_ROUNDING => Form::Affine,
        (true, true) => Form::Plane(taper),
        _ => Form::Curved,
    };
    (form, plane, size)
}

impl<'a> Chart<'a> {
    fn new(sides: &Opposite<'a, 3>, cell: &Cell) -> Self {
        let (mesh, facet) = (sides.mesh(), cell.facet);
        let kind = mesh.facet_kind(facet);
        let (shape, plane, _) = form(mesh, facet);
        let normals: Vec<Point<3>> = cell
            .places
            .iter()
            .map(|xi| sides.normals.at(facet, xi))
            .collect();
        let same = |n: &Point<3>| norm(sub(*n, normals[0])) <= LENGTH_ROUNDING;
        let parallel = normals.iter().all(same);
        let in_plane = parallel && matches!(shape, Form::Plane(_));
        let plane = in_plane.then_some(plane);
        let place = |xi: &[f64; 2]| match &plane {
            Some(plane) => plane.coordinates(mesh.facet_point(facet, xi)),
            None => *xi,
        };
        let polygon: Vec<[f64; 2]> = cell.places.iter().map(place).collect();
        Self {
            area: area(&polygon),
            polygon,
            prism: Prism::new(mesh.facet_points(facet), &normals),
            plane,
            normals,
            mesh,
            facet,
            kind,
            shape,
            parallel,
        }
    }

    /// Reference coordinates of a place of the chart; `None` if they are not found.
    fn xi(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let Some(plane) = &self.plane else {
            return Some(place);
        };
        let start = (0..2).fold(plane.origin, |x, k| add_scaled(x, place[k], plane.axes[k]));
        let line = Line {
            start,
            direction: plane.normal,
        };
        meet(self.mesh, self.facet, line).map(|hit| hit.xi)
    }

    /// The place whose normal line passes through a point.
    fn seen_from(&self, y: Point<3>) -> Option<[f64; 2]> {
        if let Some(plane) = &self.plane {
            let slope = dot(self.normals[0], plane.normal);
            let s = dot(plane.normal, sub(y, plane.origin)) / slope;
            return Some(plane.coordinates(add_scaled(y, -s, self.normals[0])));
        }
        let linear = self.kind.domain().linear();
        let [x, y0, _] = self.kind.domain().centre();
        let (mut xi, mut s, mut settling) = ([x, y0], 0.0, Settling::new());
        for _ in 0..PLACE_STEPS {
            let (mut hats, mut slopes) = ([0.0; 4], [[0.0; 2]; 4]);
            linear.shape(&xi, &mut hats);
            linear.gradients(&xi, &mut slopes);
            let tangents = self.mesh.facet_tangents(self.facet, &xi);
            let (mut direction, mut bends) = ([0.0; 3], [[0.0; 3]; 2]);
            for ((&normal, hat), slope) in self.normals.iter().zip(hats).zip(slopes) {
                direction = add_scaled(direction, hat, normal);
                bends = [0, 1].map(|k| add_scaled(bends[k], slope[k], normal));
            }
            let at = add_scaled(self.mesh.facet_point(self.facet, &xi), s, direction);
            let columns = [
                add_scaled(tangents[0], s, bends[0]),
                add_scaled(tangents[1], s, bends[1]),
                direction,
            ];
            let jacobian = std::array::from_fn(|i| columns.map(|column| column[i]));
            let (inverse, _) = invert::<3>(&jacobian);
            let rest = sub(y, at);
            let change = inverse.map(|row| dot(row, rest));
            (xi[0], xi[1], s) = (xi[0] + change[0], xi[1] + change[1], s + change[2]);
            if settling.ends(&change[..2], &xi) {
                return Some(xi);
            }
        }
        None
    }

    /// The part of the facet that a polygon of space covers, as a polygon of the chart; empty if there is none, or if the polygon has
    /// the same orientation as the facet.
    fn cut_by(&self, outline: &[Point<3>]) -> Vec<[f64; 2]> {
        // far from a curved facet, lines along its normals meet unrelated points
        let near = match self.shape == Form::Affine && self.parallel || self.plane.is_some() {
            true => outline.to_vec(),
            false => self.prism.clip(outline),
        };
        let places = near.into_iter().map(|y| self.seen_from(y));
        let Some(mut places) = places.collect::<Option<Vec<[f64; 2]>>>() else {
            return Vec::new();
        };
        merge(&mut places);
        if places.len() < 3 || signed_area(&places) >= 0.0 {
            return Vec::new();
        }
        places.reverse();
        intersection(&self.polygon, &places)
    }

    /// The visible parts: where a near and a far facet lie in front of the same place, it faces the near one. Parts of one surface
    /// overlap only by rounding and by the turn between its facets.
    fn visible(&self, sides: &Opposite<'_, 3>, other: &Mesh<3>, parts: Vec<Part>) -> Vec<Part> {
        let boxes: Vec<_> = parts.iter().map(|p| bounding_box(&p.polygon)).collect();
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by(|&a, &b| boxes[a].0[0].total_cmp(&boxes[b].0[0]));
        let mut hidden_by: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
        for (place, &a) in order.iter().enumerate() {
            let later = order[place + 1..].iter();
            let beside = |&&b: &&usize| boxes[b].0[0] < boxes[a].1[0];
            let level =
                |&&b: &&usize| boxes[b].0[1] < boxes[a].1[1] && boxes[a].0[1] < boxes[b].1[1];
            for &b in later.take_while(beside).filter(level) {
                let common = intersection(&parts[a].polygon, &parts[b].polygon);
                if area(&common) <= OVERLAPS * area(&parts[a].polygon).min(area(&parts[b].polygon))
                {
                    continue;
                }
                let at = centroid(&common);
                let sees = |k: usize| self.sees(sides, other, parts[k].facet, at);
                match (sees(a), sees(b)) {
                    (true, false) => hidden_by[b].push(a),
                    (false, true) => hidden_by[a].push(b),
                    _ => {}
                }
            }
        }
        let without_hidden = |(part, nearer): (&Part, &Vec<usize>)| {
            let whole = vec![part.polygon.clone()];
            let left = nearer.iter().fold(whole, |left, &k| {
                let rest = left.iter().flat_map(|p| difference(p, &parts[k].polygon));
                rest.filter(|p| area(p) >= SLIVER * self.area).collect()
            });
            let facet = part.facet;
            left.into_iter().map(move |polygon| Part { facet, polygon })
        };
        let both = parts.iter().zip(&hidden_by);
        both.flat_map(without_hidden).collect()
    }

    /// Whether a place of the chart faces this facet of the other side, without a nearer one.
    fn sees(&self, sides: &Opposite<'_, 3>, other: &Mesh<3>, facet: Facet, at: [f64; 2]) -> bool {
        let Some(xi) = self.xi(at) else {
            return false;
        };
        let line = sides.line(self.facet, &xi);
        let Some(found) = sides.facing(self.facet, line) else {
            return false;
        };
        let same = |distance: f64| {
            // of two facets that meet, either is the same sheet
            (distance - found.distance).abs() <= SHEET * other.facet_length(facet)
        };
        found.facet == facet || meet(other, facet, line).is_some_and(|hit| same(hit.distance))
    }

    /// The degree that integrates exactly on a piece in front of a facet, or to rounding where exactness is impossible.
    fn degree(&self, other: &Mesh<3>, facet: Facet) -> usize {
        let kind = other.facet_kind(facet);
        let base = functions_degree(self.kind) + degree(self.kind).max(degree(kind));
        let (opposite, ..) = form(other, facet);
        let own = match (self.shape, &self.plane) {
            (Form::Plane(_), None) => Form::Curved,
            (shape, _) => shape,
        };
        match (own, opposite) {
            (Form::Affine, Form::Affine) => base,
            (Form::Curved, _) | (_, Form::Curved) => base + CURVED,
            (a, b) => {
                let taper = |form| {
                    if let Form::Plane(taper) = form {
                        taper
                    } else {
                        0.0
                    }
                };
                let taper = f64::max(taper(a), taper(b));
                // shape functions of a tapered facet are power series in its taper: required digits over digits per term
                let terms = (-LENGTH_ROUNDING.log10() / -taper.min(0.5).log10()).ceil();
                base + (terms as usize).min(MOST_DEGREES)
            }
        }
    }

    /// Points of integration on a polygon of the chart.
    fn points(&self, polygon: &[[f64; 2]], degree: usize) -> Option<Vec<([f64; 2], f64)>> {
        let rule = rule(CellKind::Tri3, degree);
        let mut points = Vec::with_capacity(rule.len() * (polygon.len() - 2));
        let first = polygon[0];
        for ends in polygon[1..].windows(2) {
            let double = turn(first, ends[0], ends[1]);
            for QuadraturePoint {
                xi: [u, v, _],
                weight,
            } in &rule
            {
                let at = [0, 1]
                    .map(|d| first[d] + u * (ends[0][d] - first[d]) + v * (ends[1][d] - first[d]));
                let xi = self.xi(at)?;
                let stretch = match self.plane {
                    Some(_) => norm(self.mesh.outward_normal(self.facet, &xi)),
                    None => 1.0,
                };
                points.push((xi, weight * double / stretch));
            }
        }
        Some(points)
    }
}

/// Most steps of the search for the place of a point.
const PLACE_STEPS: usize = 20;

/// Distances along a line that differ by less than this part of a facet are of one sheet.
const SHEET: f64 = 0.01;

/// Additional degrees for curved facets, and the most for tapered ones.
const CURVED: usize = 2;
const MOST_DEGREES: usize = 14;

/// Total degree of the shape functions of a facet.
fn degree(kind: CellKind) -> usize {
    match kind {
        CellKind::Quad8 => 3,
        _ => functions_degree(kind) * kind.order(),
    }
}

/// Total degree of the hats of its corners.
fn functions_degree(kind: CellKind) -> usize {
    match kind.domain() {
        Domain::Square => 2,
        _ => 1,
    }
}

/// Polygons with straight edges that make up a facet: the one of its corners, or where its edges are curved, triangles around
/// its middle.
fn outlines(mesh: &Mesh<3>, facet: Facet) -> Vec<Vec<Point<3>>> {
    let kind = mesh.facet_kind(facet);
    let corners = kind.corners();
    let points: Vec<Point<3>> = mesh.facet_points(facet).collect();
    let limit = BENT * mesh.facet_length(facet);
    let edge = |k: usize| [points[k], points[(k + 1) % corners]];
    let bent = (corners..points.len().min(2 * corners)).any(|m| {
        let [a, b] = edge(m - corners);
        let middle = add_scaled(a.map(|c| 0.5 * c), 0.5, b);
        norm(sub(points[m], middle)) > limit
    });
    if !bent {
        return vec![points[..corners].to_vec()];
    }
    let middle = mesh.facet_point(facet, &kind.domain().centre());
    let halves = (0..corners).flat_map(|k| {
        let [a, b] = edge(k);
        let m = points[corners + k];
        [vec![a, m, middle], vec![m, b, middle]]
    });
    halves.collect()
}

/// Edges that are bent less than this part of a facet count as straight where they cut.
const BENT: f64 = 1e-6;

/// Twice the area of a triangle, positive when counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

fn signed_area(polygon: &[[f64; 2]]) -> f64 {
    let Some((&first, rest)) = polygon.split_first() else {
        return 0.0;
    };
    let triangles = rest.windows(2).map(|ends| turn(first, ends[0], ends[1]));
    0.5 * triangles.sum::<f64>()
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    signed_area(polygon).abs()
}

/// Merges corners that differ by rounding: the direction of the edge between them would be arbitrary.
fn merge(polygon: &mut Vec<[f64; 2]>) {
    let far = polygon
        .iter()
        .flatten()
        .fold(1.0, |most: f64, c| most.max(c.abs()));
    let same =
        |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= LENGTH_ROUNDING * far;
    polygon.dedup_by(|a, b| same(a, b));
    while polygon.len() > 1 && same(&polygon[0], &polygon[polygon.len() - 1]) {
        polygon.pop();
    }
}

/// Parts that overlap by less than this lie side by side.
const OVERLAPS: f64 = 1e-6;

/// The edges of a polygon.
fn edges(polygon: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    (0..polygon.len()).map(|k| [polygon[k], polygon[(k + 1) % polygon.len()]])
}

/// The part of a polygon of a chart on the left of an edge, or on the right.
fn beside(polygon: &[[f64; 2]], [a, b]: [[f64; 2]; 2], left: bool) -> Vec<[f64; 2]> {
    let sign = if left { 1.0 } else { -1.0 };
    let inside = |p: [f64; 2]| sign * turn(a, b, p);
    clip(polygon, inside, |p, q, t| {
        [0, 1].map(|d| p[d] + t * (q[d] - p[d]))
    })
}

/// The intersection of two polygons; the second one convex, counter-clockwise.
fn intersection(polygon: &[[f64; 2]], other: &[[f64; 2]]) -> Vec<[f64; 2]> {
    edges(other).fold(polygon.to_vec(), |left, edge| beside(&left, edge, true))
}

/// A convex polygon minus another one, in convex parts.
fn difference(polygon: &[[f64; 2]], other: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let mut rest = polygon.to_vec();
    let mut outside = Vec::new();
    for edge in edges(other) {
        outside.push(beside(&rest, edge, false));
        rest = beside(&rest, edge, true);
    }
    outside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::functions::cells;
    use crate::contact::gaps::tests::{body, end, together};
    use crate::contact::{End, InitialGap};
    use crate::fem::Constraints;
    use crate::mesh::{Cuboid, Cylinder};

    #[test]
    fn facets_with_curved_edges_tile_each_other_wherever_corners_and_edges_coincide() {
        let disc = |cells: [usize; 3], cell: CellKind, z: f64| {
            let cylinder = Cylinder {
                base: [0.0, 0.0, z],
                axis: [0.0, 0.0, 1.0],
                inner: 0.0,
                radius: 1.0,
                height: 0.5,
                angles: None,
                cells,
                cell,
            };
            body(cylinder.build().unwrap())
        };
        let free = Constraints::default();
        for kind in [CellKind::Hex20, CellKind::Hex27, CellKind::Tet10] {
            for (own, other) in [([24, 6, 1], [16, 4, 1]), ([16, 4, 1], [32, 8, 1])] {
                let (lower, upper) = (disc(other, kind, 0.0), disc(own, kind, 0.5));
                let against = Against::Side(end(&lower, "top", &free));
                let nonmortar = end(&upper, "bottom", &free);
                let sides = Opposite::new(nonmortar, against, InitialGap::Measured, 0.0).unwrap();
                let facets = nonmortar.facets().unwrap().iter();
                let cells: Vec<Cell> = facets.flat_map(|&f| cells(&upper.mesh, f)).collect();
                let mut covered = vec![0.0; cells.len()];
                for piece in pieces(&sides, &cells) {
                    covered[piece.cell] += piece.part;
                }
                for (cell, part) in cells.iter().zip(covered) {
                    let corners = upper.mesh.facet_points(cell.facet);
                    let rim = corners.map(|[x, y, _]| x.hypot(y)).fold(0.0, f64::max) > 0.999;
                    // at the rim the chords of the other polygon count
                    let limit = if rim { 0.02 } else { 1e-12 };
                    assert!((part - 1.0).abs() < limit, "{kind:?} {own:?} {part}");
                }
            }
        }
    }

    /// A floor under a slab, nearer to it than another one, with facets that do not match.
    #[test]
    fn what_a_near_surface_hides_of_a_far_one_faces_that_alone() {
        let cuboid = |from: Point<3>, to: Point<3>, cells: [usize; 3], cell: CellKind| {
            let cuboid = Cuboid {
                from,
                to,
                cells,
                cell,
            };
            cuboid.build().unwrap()
        };
        let free = Constraints::default();
        for cell in [CellKind::Hex8, CellKind::Tet4] {
            let slab = body(cuboid([0.0; 3], [4.0, 4.0, 1.0], [2, 2, 1], cell));
            let near = cuboid([0.5, 1.0, -1.0], [3.0, 2.7, -0.1], [4, 3, 1], cell);
            let far = cuboid([-1.0, -1.0, -4.0], [5.0, 5.0, -3.0], [3, 1, 1], cell);
            let mesh = together(&near, &far);
            let down = |facet: &Facet| {
                let normal = mesh.outward_normal(*facet, &[0.3, 0.3]);
                normal[2] < 0.0 || normal[2].abs() < norm(normal)
            };
            let mut tops = mesh.boundary_facets();
            tops.retain(|facet| !down(facet));
            let lower = body(mesh);
            let mortar = End {
                part: Some(&tops),
                ..end(&lower, "tops", &free)
            };
            let nonmortar = end(&slab, "bottom", &free);
            let against = Against::Side(mortar);
            let sides = Opposite::new(nonmortar, against, InitialGap::Measured, 0.0).unwrap();
            let facets = nonmortar.facets().unwrap().iter();
            let cells: Vec<Cell> = facets.flat_map(|&f| cells(&slab.mesh, f)).collect();
            let mut covered = vec![0.0; cells.len()];
            let mut on_near = 0.0;
            for piece in pieces(&sides, &cells) {
                covered[piece.cell] += piece.part;
                let facet = cells[piece.cell].facet;
                let area = norm(slab.mesh.outward_normal(facet, &[0.3, 0.3]));
                let integrated: f64 = piece.points.iter().map(|point| area * point.1).sum();
                let opposite = lower.mesh.facet_point(piece.opposite.unwrap(), &[0.0; 2]);
                if opposite[2] > -1.0 {
                    on_near += integrated;
                }
            }
            assert!(covered.iter().all(|part| (part - 1.0).abs() < 1e-12));
            assert!((on_near - 2.5 * 1.7).abs() < 1e-12, "{on_near}");
        }
    }
}
