//! Pictures of a contact in space: pressure, gap and state on its faces alone, each seen from where it is open.
//!
//! The nonmortar side carries the values. On the other side a node has those of the point of the nonmortar side that is
//! nearest to it, by the triangles around the nearest node; none where it faces no part of that side.

use crate::geometry::{Point, add_scaled, cross, distance, dot, norm, sub, unit};
use crate::mesh::{Facet, Mesh};
use crate::model::{ContactNode, ContactSolution, OnSide, SideRef, Solution, Status};
use crate::output::colour;
use crate::output::encode::png;
use crate::output::html;
use crate::output::interface::largest_gap;
use crate::output::json::largest;
use crate::output::plot::Axis;
use crate::output::scene::WIDTH;
use crate::output::space::camera::{Camera, Window};
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::scene::{GHOST, HEAVY, PALE, STRIP, Scene, THIN, triad_and_scale};
use crate::output::space::setup::rgb;
use crate::output::space::skin::{Lattices, Look, Skin};
use crate::output::svg::{Anchor, INK, MUTED, Svg, Type, text_width};
use crate::output::text::{Labels, count};
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Room around the faces.
const MARGIN: f64 = 14.0;

/// Room above the windows for the names of the columns and below for their scales.
const HEAD: f64 = 22.0;
const FOOT: f64 = 48.0;

/// Room between columns.
const BETWEEN: f64 = 14.0;

/// Most contacts with pictures: those that bear most.
const PICTURED: usize = 6;

/// Colours of the states.
const STATES: [(Status, &str); 6] = [
    (Status::Open, "#d9dfe5"),
    (Status::Closed, "#d7825a"),
    (Status::Stick, "#5b93cc"),
    (Status::Slip, "#e6b84a"),
    (Status::Tied, "#74a889"),
    (Status::Fixed, "#a08db8"),
];

/// Edges of cells on the colours of states.
const CELLS: Ink = Ink { cover: 0.3, ..THIN };

/// A side with what its nodes know of the contact; NaN and `None` where they know nothing.
pub struct Face<'a> {
    title: String,
    /// Index of the body.
    pub body: usize,
    skin: Skin<'a>,
    /// By node of the body.
    pub pressure: Vec<f64>,
    gap: Vec<f64>,
    status: Vec<Option<Status>>,
    camera: Camera,
}

/// The figure of a contact; nothing for a contact without nodes, and where many others bear more.
pub fn contact_figure(scene: &Scene<'_>, solution: &Solution<3>, index: usize) -> Option<String> {
    let force = |i: usize| norm(solution.contacts[i].resultant);
    let before = (0..solution.contacts.len()).filter(|&i| {
        let more = force(i).total_cmp(&force(index));
        more.then(index.cmp(&i)).is_gt()
    });
    if before.count() >= PICTURED {
        return None;
    }
    let contact = &solution.contacts[index];
    let faces = faces(scene, contact)?;
    let labels = Labels::of(scene.model);
    let width = ((WIDTH - 2.0 * BETWEEN) / 3.0).floor();
    let title = format!("Pressure, gap and state on the faces of {}", contact.name);
    let mut svg = Svg::new(&format!("faces{index}"), &title, WIDTH, 0.0);
    let high = Highest {
        pressure: largest(contact.nodes.iter().map(|n| n.pressure)),
        gap: largest_gap(&contact.nodes),
    };
    let mut top = HEAD;
    for face in &faces {
        let extent = face.extent();
        let aspect =
            (extent.1[0] - extent.0[0]) / (extent.1[1] - extent.0[1]).max(f64::MIN_POSITIVE);
        let height = (width / aspect.clamp(0.2, 5.0)).clamp(120.0, 250.0).floor();
        let start = Type::SMALL.bold().anchored(Anchor::Start);
        svg.text([0.0, top - 6.0], &face.title, start);
        let columns = (0..3).into_par_iter().map(|column| {
            let corner = [column as f64 * (width + BETWEEN), top];
            let window = Window::fitted(face.camera, extent, corner, [width, height], MARGIN);
            let png = face.draw(scene, &window, column, &high).png();
            (window, png)
        });
        let columns: Vec<(Window, Vec<u8>)> = columns.collect();
        for (window, png) in &columns {
            svg.picture(window.corner, window.size, png);
        }
        triad_and_scale(&mut svg, &columns[0].0, &labels, "");
        top += height + STRIP + HEAD;
    }
    let base = top - HEAD + 4.0;
    let bars = [
        ("Pressure", &labels.stress, high.pressure),
        ("Gap", &labels.length, high.gap),
    ];
    for (column, (name, unit, high)) in bars.into_iter().enumerate() {
        let left = column as f64 * (width + BETWEEN);
        bar(
            &mut svg,
            [left, base],
            width,
            &Axis::linear(name, unit, &[0.0, high], true, 4),
        );
    }
    states(&mut svg, [2.0 * (width + BETWEEN), base], width, contact);
    svg.set_height(base + FOOT);
    let caption = "The faces alone, each seen from where it is open, the bodies as grey edges. Pressure is positive in \
                   compression, the gap is that after deformation. The nonmortar side carries the values; the other side \
                   shows those of the nearest point. Light grey: no value.";
    Some(html::figure(&svg.finish(), &title, caption))
}

/// Ends of the scales.
struct Highest {
    pressure: f64,
    gap: f64,
}

impl Face<'_> {
    /// The box on paper of what the side knows of the contact.
    fn extent(&self) -> ([f64; 2], [f64; 2]) {
        let mesh = self.skin.mesh;
        let known = |facet: &&Facet| {
            mesh.facet_nodes(**facet)
                .any(|n| self.status[n as usize].is_some())
        };
        let facets = || self.skin.facets.iter();
        let any = facets().any(|facet| known(&facet));
        let shown = facets().filter(|facet| !any || known(facet));
        self.camera
            .extent(shown.flat_map(|&facet| mesh.facet_points(facet)))
    }

    /// Pressure, gap or state, by the column.
    fn draw(&self, scene: &Scene<'_>, window: &Window, column: usize, high: &Highest) -> Canvas {
        let cells = if column == 2 { CELLS } else { PALE };
        let mut canvas = Canvas::new(window.size, &[GHOST, cells, HEAVY]);
        let mut look = Look::at(window, self.skin.mesh.points());
        let scaled = |values: &[f64], high: f64| -> Vec<f64> {
            let high = if high > 0.0 { high } else { 1.0 };
            values.iter().map(|v| v / high).collect()
        };
        if column == 2 {
            let colour = |node: u32| {
                let status = self.status[node as usize]?;
                let own = STATES.iter().find(|s| s.0 == status)?;
                Some(rgb(own.1))
            };
            self.skin.patches(&mut canvas, &look, 0, &colour);
        } else {
            look.values = match column {
                0 => scaled(&self.pressure, high.pressure),
                _ => scaled(&self.gap, high.gap),
            };
            self.skin.fill(&mut canvas, &look, 0, &|_| Paint::Scale);
        }
        let body = &scene.skins[self.body];
        body.outline(&mut canvas, window, &look, [None, Some(0)]);
        self.skin
            .outline(&mut canvas, window, &look, [Some(1), Some(2)]);
        canvas
    }
}

/// The nonmortar side, then the mortar side; of a contact with an obstacle the first alone, from two directions.
pub fn faces<'a>(scene: &Scene<'a>, contact: &ContactSolution<3>) -> Option<Vec<Face<'a>>> {
    let own = &contact.nonmortar;
    let skin = side_skin(scene, own)?;
    let mesh = skin.mesh;
    let nodes = mesh.points().len();
    let (mut pressure, mut gap) = (vec![f64::NAN; nodes], vec![f64::NAN; nodes]);
    let mut status = vec![None; nodes];
    // NaN stays NaN
    let opened = |node: &ContactNode<3>| node.gap.max(0.0) + 0.0 * node.gap;
    for node in &contact.nodes {
        pressure[node.node] = node.pressure;
        gap[node.node] = opened(node);
        status[node.node] = Some(node.status);
    }
    for place in OnSide::new(mesh, contact).between() {
        pressure[place.node] = place.mean(|node| node.pressure);
        gap[place.node] = place.mean(opened);
    }
    let name = |side: &SideRef| format!("{}.{}", scene.model.bodies[side.body.0].name, side.side);
    let [first, second] = cameras(mesh, &skin.facets);
    let nonmortar = Face {
        title: name(own),
        body: own.body.0,
        skin,
        pressure,
        gap,
        status,
        camera: first,
    };
    let other = match contact
        .mortar
        .as_ref()
        .and_then(|m| Some((m, side_skin(scene, m)?)))
    {
        Some((mortar, skin)) => carried(&nonmortar, mortar, skin, name(mortar)),
        None => Face {
            title: format!("{}, another direction", name(own)),
            skin: side_skin(scene, own)?,
            pressure: nonmortar.pressure.clone(),
            gap: nonmortar.gap.clone(),
            status: nonmortar.status.clone(),
            camera: second,
            ..nonmortar
        },
    };
    Some(vec![nonmortar, other])
}

fn side_skin<'a>(scene: &Scene<'a>, side: &SideRef) -> Option<Skin<'a>> {
    let body = scene.model.bodies.get(side.body.0)?;
    let facets = scene.side(side.body.0, &side.side);
    (!facets.is_empty()).then(|| Skin::new(&body.mesh, facets.to_vec()))
}

/// Two directions that show a side: about its mean normal, or the usual ones where it has none.
fn cameras(mesh: &Mesh<3>, facets: &[Facet]) -> [Camera; 2] {
    let (mut sum, mut area) = ([0.0; 3], 0.0);
    for &facet in facets {
        let normal = mesh.outward_normal(facet, &mesh.facet_kind(facet).domain().centre());
        sum = add_scaled(sum, 1.0, normal);
        area += norm(normal);
    }
    let [x, y, z] = sum.map(|s| s / area);
    match x.hypot(y).hypot(z) {
        r if r < 0.3 => [Camera::around(32.0, 26.0), Camera::around(-148.0, 26.0)],
        r if z.abs() > 0.75 * r => [32.0, -148.0].map(|a| Camera::around(a, 52.0_f64.copysign(z))),
        _ => {
            let own = x.atan2(-y).to_degrees();
            let lift = 24.0 + 0.5 * z.asin().to_degrees();
            [
                Camera::around(own + 30.0, lift),
                Camera::around(own - 30.0, lift),
            ]
        }
    }
}

/// The other side with the values of the nearest points.
fn carried<'a>(from: &Face<'_>, mortar: &SideRef, skin: Skin<'a>, title: String) -> Face<'a> {
    let mesh = skin.mesh;
    let count = mesh.points().len();
    let mut face = Face {
        title,
        body: mortar.body.0,
        pressure: vec![f64::NAN; count],
        gap: vec![f64::NAN; count],
        status: vec![None; count],
        camera: cameras(mesh, &skin.facets)[0],
        skin,
    };
    let nearest = Nearest::new(&from.skin);
    let nodes = face
        .skin
        .facets
        .iter()
        .flat_map(|&facet| mesh.facet_nodes(facet));
    for node in nodes.map(|n| n as usize) {
        let Some(on) = nearest.on(mesh.points()[node]) else {
            continue;
        };
        let value = |values: &[f64]| on.iter().map(|&(n, w)| w * values[n]).sum();
        face.pressure[node] = value(&from.pressure);
        face.gap[node] = value(&from.gap);
        let near = on.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        face.status[node] = near.and_then(|&(n, _)| from.status[n]);
    }
    face
}

/// Triangles of a side by their corners.
struct Nearest<'a> {
    mesh: &'a Mesh<3>,
    tree: RTree<GeomWithData<[f64; 3], usize>>,
    /// Triangles at each corner, by the order of the tree's data.
    around: Vec<Vec<[usize; 3]>>,
}

impl<'a> Nearest<'a> {
    fn new(skin: &Skin<'a>) -> Self {
        let mesh = skin.mesh;
        let mut around: Vec<Vec<[usize; 3]>> = vec![Vec::new(); mesh.points().len()];
        let mut lattices = Lattices::default();
        for &facet in &skin.facets {
            let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|n| n as usize).collect();
            let lattice = lattices.of(mesh.facet_kind(facet), 0);
            for triangle in &lattice.triangles {
                let corners = triangle.map(|i| nodes[i]);
                corners.iter().for_each(|&n| around[n].push(corners));
            }
        }
        let corners = around
            .iter()
            .enumerate()
            .filter(|(_, list)| !list.is_empty());
        let corners = corners.map(|(n, _)| GeomWithData::new(mesh.points()[n], n));
        Self {
            mesh,
            tree: RTree::bulk_load(corners.collect()),
            around,
        }
    }

    /// The nearest point of the side as weights of three nodes; `None` where it lies beside the foot of the normal by more
    /// than half an edge.
    fn on(&self, point: Point<3>) -> Option<[(usize, f64); 3]> {
        let corner = self.tree.nearest_neighbor(point)?.data;
        let at = |n: usize| self.mesh.points()[n];
        let candidates = self.around[corner].iter().map(|triangle| {
            let corners = triangle.map(at);
            let weights = closest(corners, point);
            let foot = (0..3).fold([0.0; 3], |sum, i| add_scaled(sum, weights[i], corners[i]));
            (distance(foot, point), foot, corners, weights, triangle)
        });
        let (_, foot, corners, weights, triangle) =
            candidates.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let normal = unit(cross(
            sub(corners[1], corners[0]),
            sub(corners[2], corners[0]),
        ))?;
        let away = sub(point, foot);
        let beside = norm(add_scaled(away, -dot(away, normal), normal));
        let edge = distance(corners[0], corners[1]).max(distance(corners[0], corners[2]));
        (beside <= 0.5 * edge).then(|| [0, 1, 2].map(|i| (triangle[i], weights[i])))
    }
}

/// Weights of the corners in the point of a triangle that is nearest to a point.
///
/// Source: C. Ericson, Real-Time Collision Detection (2005), section 5.1.5, as described in.
fn closest([a, b, c]: [Point<3>; 3], p: Point<3>) -> [f64; 3] {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

/// A lying colour bar with its name and numbers; in words where all values are zero.
fn bar(svg: &mut Svg, [left, top]: [f64; 2], width: f64, axis: &Axis) {
    let small = Type::SMALL.coloured(MUTED);
    if axis.range[0] < 0.0 {
        let text = format!("{}: 0 everywhere", axis.label);
        svg.text([left + 0.5 * width, top + 6.0], &text, small);
        return;
    }
    let strip: Vec<u8> = (0..colour::STEPS).map(|i| 1 + i as u8).collect();
    let picture = png(colour::STEPS, 1, &strip, &colour::palette());
    let room = 14.0;
    let (start, length) = (left + room, width - 2.0 * room);
    svg.text([left + 0.5 * width, top + 6.0], &axis.label, small);
    svg.picture([start, top + 12.0], [length, 11.0], &picture);
    svg.rectangle([start, top + 12.0], [length, 11.0], INK, "none");
    for (value, text) in &axis.ticks {
        let x = start + axis.fraction(*value) * length;
        svg.line([x, top + 23.0], [x, top + 27.0], INK, 0.8);
        svg.text([x, top + 37.0], text, Type::SMALL);
    }
}

/// Colours of the states that occur, with their numbers of nodes.
fn states(svg: &mut Svg, [left, top]: [f64; 2], width: f64, contact: &ContactSolution<3>) {
    let small = Type::SMALL;
    svg.text(
        [left + 0.5 * width, top + 6.0],
        "State",
        small.coloured(MUTED),
    );
    let (mut x, mut y) = (left + 4.0, top + 12.0);
    for (status, fill) in STATES {
        let nodes = contact.nodes.iter().filter(|n| n.status == status).count();
        if nodes == 0 {
            continue;
        }
        let text = format!("{} ({})", status.name(), count(nodes));
        let room = 18.0 + text_width(&text, small.size) + 10.0;
        if x > left + 4.0 && x + room > left + width {
            (x, y) = (left + 4.0, y + 16.0);
        }
        svg.rectangle([x, y], [13.0, 11.0], INK, fill);
        svg.text([x + 18.0, y + 9.0], &text, small.anchored(Anchor::Start));
        x += room;
    }
}
