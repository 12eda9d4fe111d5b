//! Bodies on paper: outlines, mesh lines, and the windows through which the figures look at them.
//!
//! World coordinates have y upward, pixels have y downward. Facets run counterclockwise around their body, so that
//! its outside lies to their right.

use crate::geometry::{Point, add_scaled, bounding_box, distance, sub, unit};
use crate::mesh::{Facet, Mesh};
use crate::model::{Model, SideRef};
use crate::output::points::in_reach;
use crate::output::svg::{Pixel, segments, short};
use crate::output::view::{Box2, Margin, View};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Width of figures on a page.
pub const WIDTH: f64 = 760.0;

/// Width of figures on a phone, where they are drawn anew: letters keep their size, and what stood side by side stands one below the
/// other.
pub const PHONE: f64 = 372.0;

/// Most ticks on an axis along a figure of this width.
pub fn ticks(width: f64) -> usize {
    (width / 92.0) as usize
}

/// Cells narrower than this are drawn without their edges.
const LEAST_WIDTH: f64 = 2.0;

/// A contact smaller than this part of the model gets a window of its own.
const DETAIL: f64 = 0.4;

/// One facet of a strand: its ends and its middle node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Link {
    /// Start and end.
    pub ends: [usize; 2],
    /// Middle node of a quadratic facet.
    pub middle: Option<usize>,
}

/// Facets in a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Strand {
    /// The facets, each starting where the one before ends.
    pub links: Vec<Link>,
    /// The last ends where the first starts.
    pub closed: bool,
}

/// A point of a strand where something is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Undeformed position.
    pub point: Point<2>,
    /// Outward unit normal.
    pub normal: Point<2>,
    /// Arc length from the start.
    pub arc: f64,
}

impl Strand {
    /// Path commands; quadratic facets become parabolas.
    pub fn path(&self, place: &dyn Fn(usize) -> Pixel) -> String {
        let mut out = String::new();
        for (i, link) in self.links.iter().enumerate() {
            let (a, b) = (place(link.ends[0]), place(link.ends[1]));
            if i == 0 {
                let _ = write!(out, "M{} {}", short(a[0]), short(a[1]));
            }
            out.push_str(&curve_to(a, link.middle.map(place), b));
        }
        if self.closed {
            out.push('Z');
        }
        out
    }

    /// The strand as a fine polygon, with outward normals of its facets.
    fn fine(&self, points: &[Point<2>]) -> Vec<Mark> {
        let mut marks: Vec<Mark> = Vec::new();
        let mut arc = 0.0;
        for link in &self.links {
            let [a, b] = link.ends.map(|n| points[n]);
            let parts = if link.middle.is_some() { 6 } else { 1 };
            let mut before = a;
            for k in 1..=parts {
                let t = f64::from(k) / f64::from(parts);
                let next = link.middle.map_or(b, |m| parabola(a, points[m], b, t));
                let along = unit(sub(next, before)).unwrap_or([1.0, 0.0]);
                let normal = [along[1], -along[0]];
                marks.push(Mark {
                    point: before,
                    normal,
                    arc,
                });
                arc += distance(before, next);
                marks.push(Mark {
                    point: next,
                    normal,
                    arc,
                });
                before = next;
            }
        }
        marks
    }

    /// `parts` + 1 points at equal distances, the ends included; or the middles of `parts` equal pieces.
    pub fn marks(&self, points: &[Point<2>], parts: usize, middles: bool) -> Vec<Mark> {
        let fine = self.fine(points);
        let length = fine.last().map_or(0.0, |s| s.arc);
        let count = if middles { parts } else { parts + 1 };
        let shift = if middles { 0.5 } else { 0.0 };
        let mut at = 0;
        (0..count)
            .filter_map(|i| {
                let arc = length * (i as f64 + shift) / parts as f64;
                while at + 2 < fine.len() && fine[at + 1].arc < arc {
                    at += 2;
                }
                let (a, b) = (fine.get(at)?, fine.get(at + 1)?);
                let t = if b.arc > a.arc {
                    (arc - a.arc) / (b.arc - a.arc)
                } else {
                    0.0
                };
                Some(Mark {
                    point: add_scaled(a.point, t, sub(b.point, a.point)),
                    normal: a.normal,
                    arc,
                })
            })
            .collect()
    }

    /// Length of the strand.
    pub fn length(&self, points: &[Point<2>]) -> f64 {
        self.fine(points).last().map_or(0.0, |s| s.arc)
    }
}

/// Path command from a through `middle` to b.
fn curve_to(a: Pixel, middle: Option<Pixel>, b: Pixel) -> String {
    match middle {
        None => format!("L{} {}", short(b[0]), short(b[1])),
        Some(m) => {
            let control = [0, 1].map(|i| 2.0 * m[i] - 0.5 * (a[i] + b[i]));
            format!(
                "Q{} {} {} {}",
                short(control[0]),
                short(control[1]),
                short(b[0]),
                short(b[1])
            )
        }
    }
}

/// Point of the parabola through a (t = 0), m (t = 1/2) and b (t = 1).
pub fn parabola(a: Point<2>, m: Point<2>, b: Point<2>, t: f64) -> Point<2> {
    let (na, nm, nb) = (
        (1.0 - t) * (1.0 - 2.0 * t),
        4.0 * t * (1.0 - t),
        t * (2.0 * t - 1.0),
    );
    std::array::from_fn(|i| na * a[i] + nm * m[i] + nb * b[i])
}

/// Joins facets into strands; each facet is used once.
pub fn strands(mesh: &Mesh<2>, facets: &[Facet]) -> Vec<Strand> {
    let links: Vec<Link> = facets
        .iter()
        .map(|&facet| {
            let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
            Link {
                ends: [nodes[0] as usize, nodes[1] as usize],
                middle: nodes.get(2).map(|&n| n as usize),
            }
        })
        .collect();
    let mut from: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut arrivals: BTreeMap<usize, usize> = BTreeMap::new();
    for (i, link) in links.iter().enumerate() {
        from.entry(link.ends[0]).or_default().push(i);
        *arrivals.entry(link.ends[1]).or_default() += 1;
    }
    // Open strands start where no facet arrives; what is left after them are rings.
    let starts = links.iter().filter(|l| !arrivals.contains_key(&l.ends[0]));
    let order: Vec<usize> = starts.chain(&links).map(|l| l.ends[0]).collect();
    let mut out = Vec::new();
    for start in order {
        let mut strand = Vec::new();
        let mut node = start;
        while let Some(next) = from.get_mut(&node).and_then(Vec::pop) {
            node = links[next].ends[1];
            strand.push(links[next]);
        }
        if !strand.is_empty() {
            out.push(Strand {
                links: strand,
                closed: node == start,
            });
        }
    }
    out
}

/// The common data of all figures of a model.
pub struct Scene<'a> {
    /// The model.
    pub model: &'a Model<2>,
    /// Boundary of each body.
    pub outlines: Vec<Vec<Strand>>,
    /// Box around each body.
    pub extents: Vec<Box2>,
    /// Box around everything.
    pub bounds: Box2,
    /// Box around the contacts, where they are small.
    pub detail: Option<Box2>,
}

impl<'a> Scene<'a> {
    /// Outlines and boxes of a model.
    pub fn new(model: &'a Model<2>) -> Self {
        let outlines = model
            .bodies
            .iter()
            .map(|body| strands(&body.mesh, &body.mesh.boundary_facets()))
            .collect();
        let all: Vec<Point<2>> = model
            .bodies
            .iter()
            .flat_map(|b| b.mesh.points())
            .copied()
            .collect();
        let extents = model.bodies.iter().map(|b| bounding_box(b.mesh.points()));
        let bounds = bounding_box(&all);
        // points of couples belong to the picture, unless they would make the bodies small
        let near = in_reach(model, bounds);
        let bounds = bounding_box(&near.chain([bounds.0, bounds.1]).collect::<Vec<_>>());
        let touching: Vec<Point<2>> = model
            .contacts
            .iter()
            .flat_map(|contact| contact.pair.sides())
            .flat_map(|side| side_points(model, side))
            .collect();
        Self {
            model,
            outlines,
            extents: extents.collect(),
            bounds,
            detail: detail_box(bounds, &touching),
        }
    }

    /// Windows that together take this width, with this margin around the bodies; and the height of the figure.
    ///
    /// Below each window `strip` pixels are kept free for its scale bar.
    pub fn views(&self, width: f64, margin: Margin, strip: f64) -> (Vec<View>, f64) {
        self.views_of(self.bounds, width, margin, strip)
    }

    /// The same where the whole is a larger box.
    pub fn views_of(
        &self,
        bounds: Box2,
        width: f64,
        margin: Margin,
        strip: f64,
    ) -> (Vec<View>, f64) {
        let aspect = width_over_height(bounds);
        let (across, along) = (margin.left + margin.right, margin.top + margin.bottom);
        let Some(detail) = self.detail else {
            let height = ((width - across) / aspect).clamp(120.0, 480.0) + along;
            let view = View::fitted(bounds, [0.0, 0.0], [width, height], margin);
            return (vec![view], height + strip);
        };
        let inset = |corner: Pixel, size: Pixel| View {
            detail: true,
            ..View::fitted(detail, corner, size, Margin::all(6.0))
        };
        let between = 18.0;
        if aspect < 1.2 && width > PHONE {
            // Side by side.
            let own = (460.0 * aspect).clamp(60.0, (0.46 * width - across).max(60.0)) + across;
            let height = ((own - across) / aspect).min(460.0) + along;
            let whole = View::fitted(bounds, [0.0, 0.0], [own, height], margin);
            let start = own + between;
            let size = [width - start - 1.0, height - 8.0];
            return (vec![whole, inset([start, 8.0], size)], height + strip);
        }
        let upper = ((width - across) / aspect).clamp(80.0, 400.0) + along;
        let whole = View::fitted(bounds, [0.0, 0.0], [width, upper], margin);
        let lower = (width / width_over_height(detail)).clamp(120.0, 400.0);
        let corner = [1.0, upper + strip + between];
        let height = corner[1] + lower + strip;
        (vec![whole, inset(corner, [width - 2.0, lower])], height)
    }

    /// Facets of a named side as strands; empty without such a side.
    pub fn side(&self, side: &SideRef) -> Vec<Strand> {
        self.body_side(side.body.0, &side.side)
    }

    /// The same by index of the body.
    pub fn body_side(&self, body: usize, side: &str) -> Vec<Strand> {
        let Some(body) = self.model.bodies.get(body) else {
            return Vec::new();
        };
        let facets: Vec<Facet> = body.mesh.side(side).unwrap_or(&[]).to_vec();
        strands(&body.mesh, &facets)
    }
}

fn width_over_height((low, high): Box2) -> f64 {
    let aspect = (high[0] - low[0]) / (high[1] - low[1]);
    if aspect.is_finite() {
        aspect.clamp(1e-3, 1e3)
    } else {
        1.0
    }
}

fn side_points(model: &Model<2>, side: &SideRef) -> Vec<Point<2>> {
    let Some(body) = model.bodies.get(side.body.0) else {
        return Vec::new();
    };
    let facets = body.mesh.side(&side.side).unwrap_or(&[]);
    facets
        .iter()
        .flat_map(|&facet| body.mesh.facet_nodes(facet))
        .map(|node| body.mesh.points()[node as usize])
        .collect()
}

/// The box of the contacts with room around it, where it is much smaller than the model.
fn detail_box(bounds: Box2, touching: &[Point<2>]) -> Option<Box2> {
    if touching.is_empty() {
        return None;
    }
    let size = |(low, high): Box2| (high[0] - low[0]).max(high[1] - low[1]);
    let contact = bounding_box(touching);
    let extent = size(contact);
    if !(extent > 0.0 && extent < DETAIL * size(bounds)) {
        return None;
    }
    let room = 0.16 * extent;
    let low = [0, 1].map(|i| (contact.0[i] - room).max(bounds.0[i] - 0.4 * room));
    let high = [0, 1].map(|i| (contact.1[i] + room).min(bounds.1[i] + 0.4 * room));
    Some((low, high))
}

/// Edges of the cells in sight that are at least a few pixels wide.
pub fn mesh_lines(mesh: &Mesh<2>, view: &View, place: &dyn Fn(usize) -> Pixel) -> String {
    const NONE: u32 = u32::MAX;
    // (smaller node, larger node, middle node)
    let mut edges: Vec<(u32, u32, u32)> = Vec::new();
    let mut pixels = Vec::new();
    for block in mesh.blocks() {
        let corners = block.kind.corners();
        for cell in block.cells() {
            pixels.clear();
            pixels.extend(cell[..corners].iter().map(|&n| place(n as usize)));
            if !pixels.iter().any(|&p| view.sees(p)) {
                continue;
            }
            let longest = (0..corners)
                .map(|i| distance(pixels[i], pixels[(i + 1) % corners]))
                .fold(0.0, f64::max);
            // the altitude of a triangle, the width of a quadrilateral
            let width = polygon_area(&pixels) * if corners == 3 { 2.0 } else { 1.0 } / longest;
            if width < LEAST_WIDTH {
                continue;
            }
            for i in 0..corners {
                let (a, b) = (cell[i], cell[(i + 1) % corners]);
                let middle = if cell.len() > corners {
                    cell[corners + i]
                } else {
                    NONE
                };
                edges.push((a.min(b), a.max(b), middle));
            }
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let mut out = String::new();
    for (a, b, middle) in edges {
        let (start, end) = (place(a as usize), place(b as usize));
        let _ = write!(out, "M{} {}", short(start[0]), short(start[1]));
        if middle == NONE {
            let _ = write!(
                out,
                "l{} {}",
                short(end[0] - start[0]),
                short(end[1] - start[1])
            );
        } else {
            out.push_str(&curve_to(start, Some(place(middle as usize)), end));
        }
    }
    out
}

/// Area of a polygon, whatever its sense.
pub fn polygon_area(points: &[Pixel]) -> f64 {
    let twice: f64 = (0..points.len())
        .map(|i| {
            let (a, b) = (points[i], points[(i + 1) % points.len()]);
            a[0] * b[1] - a[1] * b[0]
        })
        .sum();
    0.5 * twice.abs()
}

/// One path around a body, holes included (fill rule evenodd).
pub fn outline_path(outline: &[Strand], place: &dyn Fn(usize) -> Pixel) -> String {
    outline.iter().map(|strand| strand.path(place)).collect()
}

/// Straight segments of a polygon in pixels.
pub fn polyline(points: &[Pixel]) -> String {
    segments(points, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;
    use crate::output::tunnel;

    #[test]
    fn boundary_of_a_ring_sector_is_one_loop() {
        let model = tunnel::model(12, [2, 6], CellKind::Quad8);
        let scene = Scene::new(&model);
        for outline in &scene.outlines {
            assert_eq!(outline.len(), 1);
            assert!(outline[0].closed);
        }
    }

    #[test]
    fn marks_stay_on_a_curved_side_with_outward_normals() {
        let model = tunnel::model(12, [2, 6], CellKind::Quad8);
        let scene = Scene::new(&model);
        let side = scene.body_side(0, "outer");
        assert_eq!((side.len(), side[0].closed), (1, false));
        let marks = side[0].marks(model.bodies[0].mesh.points(), 40, true);
        assert_eq!(marks.len(), 40);
        for s in marks {
            let radius = s.point[0].hypot(s.point[1]);
            // 12 parabolas over half a circle: off by far less than a thousandth.
            assert!((radius / tunnel::RADIUS - 1.0).abs() < 1e-3);
            let outward = (s.normal[0] * s.point[0] + s.normal[1] * s.point[1]) / radius;
            assert!(outward > 0.99, "{outward}");
        }
    }

    #[test]
    fn small_contacts_get_a_window_of_their_own() {
        let (model, _) = tunnel::solved();
        let scene = Scene::new(&model);
        for width in [WIDTH, PHONE] {
            let (views, height) = scene.views(width, Margin::all(60.0), 30.0);
            assert_eq!(views.len(), 2);
            for view in &views {
                assert!(view.corner[0] >= 0.0 && view.corner[0] + view.size[0] <= width);
                assert!(view.corner[1] + view.size[1] <= height);
                for corner in [view.low, view.high] {
                    assert!(view.sees(view.pixel(corner)));
                }
            }
        }
    }

    #[test]
    fn lines_too_close_to_see_are_left_out() {
        let (model, _) = tunnel::solved();
        let scene = Scene::new(&model);
        let (views, _) = scene.views(WIDTH, Margin::all(60.0), 30.0);
        let mesh = &model.bodies[1].mesh;
        let place = |view: &View, n: usize| view.pixel(mesh.points()[n]);
        let near = &views[1];
        assert!(!mesh_lines(mesh, near, &|n| place(near, n)).is_empty());
        let mut far = views[0].clone();
        far.scale /= 100.0;
        assert!(mesh_lines(mesh, &far, &|n| place(&far, n)).is_empty());
    }
}
