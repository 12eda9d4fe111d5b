//! Figure "Mesh, supports and loads": the model as a textbook draws it.

use crate::geometry::{Field, Point, unit};
use crate::model::{
    Body, Bond, Contact, Material, Member, MemberKind, MemberWords, Model, Pair, Place, Support,
};
use crate::output::markup::Markup;
use crate::output::points::{couples, draw_points, forces, in_words};
use crate::output::scene::{Scene, mesh_lines, outline_path, polyline, strands};
use crate::output::svg::{
    ALARM, Anchor, BAR, INK, LOAD, MUTED, Pixel, RULE, SERIES, SUPPORT, Svg, TINTS, Type,
    text_width,
};
use crate::output::symbols::{
    Hold, draw_load, draw_spring, draw_support, hatch, hold, roller, zigzag,
};
use crate::output::text::{Labels, number, quantity, vector};
use crate::output::view::{Margin, STRIP, View, mark_detail, on_paper, scale_bar};

/// Room around the bodies for arrows and their values, where there are any.
const LOADED: f64 = 68.0;

/// Room around the bodies for support symbols.
const BARE: f64 = 30.0;

/// Most bodies and most contacts that the legend names.
pub const NAMED: usize = 12;

/// The figure as an SVG element; `alone` are contact nodes without an opposite side.
pub fn setup_figure(scene: &Scene, alone: &[Point<2>], width: f64) -> Markup {
    let labels = Labels::of(scene.model);
    let (views, height) = scene.views(width, margin(scene), STRIP);
    let mut svg = Svg::new("setup", "Mesh, supports and loads", width, height);
    for view in &views {
        draw_view(&mut svg, scene, view, &labels);
        for &point in alone.iter().filter(|p| view.sees(view.pixel(**p))) {
            svg.circle(view.pixel(point), 2.6, ALARM, "white", "faces nothing");
        }
    }
    if let [whole, detail] = views.as_slice() {
        mark_detail(&mut svg, whole, detail);
    }
    let place = [width, height + 6.0];
    let bottom = legend(&mut svg, scene, &labels, !alone.is_empty(), place);
    svg.set_height(bottom);
    svg.finish()
}

/// Room where arrows stand outside the bodies.
fn margin(scene: &Scene) -> Margin {
    let (low, high) = scene.bounds;
    let near = 0.12 * (high[0] - low[0]).max(high[1] - low[1]);
    let mut margin = Margin::all(BARE);
    let mut widen = |point: Point<2>, outward: Point<2>| {
        let sides = [
            (&mut margin.left, point[0] - low[0], -outward[0]),
            (&mut margin.right, high[0] - point[0], outward[0]),
            (&mut margin.bottom, point[1] - low[1], -outward[1]),
            (&mut margin.top, high[1] - point[1], outward[1]),
        ];
        for (room, distance, along) in sides {
            if distance < near && along > 0.3 {
                *room = LOADED;
            }
        }
    };
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let points = body.mesh.points();
        for load in &body.loads {
            match load.place() {
                Place::Side(side) => {
                    for strand in scene.body_side(i, &side) {
                        let marks = strand.marks(points, 24, true);
                        marks.iter().for_each(|s| widen(s.point, s.normal));
                    }
                }
                Place::Point(point) => {
                    let force = load.at(point, [0.0; 2], scene.model.last_time());
                    if let Some(along) = unit(force) {
                        widen(point, along.map(|c| -c));
                    }
                }
            }
        }
    }
    forces(scene)
        .into_iter()
        .for_each(|(point, from)| widen(point, from));
    margin
}

fn draw_view(svg: &mut Svg, scene: &Scene, view: &View, labels: &Labels) {
    svg.begin_clip(view.corner, view.size);
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let place = |n: usize| view.pixel(body.mesh.points()[n]);
        let outline = outline_path(&scene.outlines[i], &place);
        svg.path(
            &outline,
            "none",
            0.0,
            TINTS[i % TINTS.len()],
            "fill-rule=\"evenodd\"",
        );
        shade_groups(svg, body, &place);
        svg.path(
            &mesh_lines(&body.mesh, view, &place),
            "#7c8894",
            0.4,
            "none",
            "",
        );
        svg.path(&outline, INK, 0.9, "none", "stroke-linejoin=\"round\"");
    }
    for (i, contact) in scene.model.contacts.iter().enumerate() {
        contact_line(svg, scene, view, contact, SERIES[i % SERIES.len()]);
    }
    if labels.axes[0] == "r" {
        let x = view.pixel([0.0, 0.0])[0];
        let line = [[x, view.corner[1]], [x, view.corner[1] + view.size[1]]];
        svg.path(
            &polyline(&line),
            MUTED,
            0.8,
            "none",
            "stroke-dasharray=\"12 3 2 3\"",
        );
    }
    for (i, body) in scene.model.bodies.iter().enumerate() {
        for load in &body.loads {
            draw_load(svg, scene, view, i, load, labels);
        }
    }
    for (i, body) in scene.model.bodies.iter().enumerate() {
        for support in &body.supports {
            draw_support(svg, scene, view, i, support, labels);
        }
        for spring in &body.springs {
            draw_spring(svg, scene, view, i, spring);
        }
    }
    for member in &scene.model.members {
        if let Ok(ends) = member.places(scene.model) {
            let look = look(member);
            draw_member(svg, ends.map(|end| view.pixel(end)), look);
        }
    }
    draw_points(svg, scene, view, labels);
    svg.end_clip();
    scale_bar(svg, view, labels);
}

/// The groups of cells of a body of several materials, as they are shaded; in the plane.
fn shaded_groups<const D: usize>(body: &Body<D>) -> Vec<&str> {
    match D == 2 && body.materials.len() > 1 {
        true => body.mesh.groups(),
        false => Vec::new(),
    }
}

/// How much darker than its body the groups of its cells are drawn, by turns.
const SHADES: [&str; 4] = [
    "fill-rule=\"evenodd\" fill-opacity=\"0\"",
    "fill-rule=\"evenodd\" fill-opacity=\"0.08\"",
    "fill-rule=\"evenodd\" fill-opacity=\"0.16\"",
    "fill-rule=\"evenodd\" fill-opacity=\"0.24\"",
];

/// Groups of cells that have materials of their own, one darker than the other.
fn shade_groups(svg: &mut Svg, body: &Body<2>, place: &dyn Fn(usize) -> Pixel) {
    for (k, group) in shaded_groups(body).into_iter().enumerate() {
        let outline = strands(&body.mesh, &body.mesh.group_boundary(group));
        svg.path(
            &outline_path(&outline, place),
            INK,
            0.7,
            INK,
            SHADES[k % SHADES.len()],
        );
    }
}

/// Both sides of a contact, heavy; a rigid obstacle as a hatched line.
fn contact_line(svg: &mut Svg, scene: &Scene, view: &View, contact: &Contact<2>, colour: &str) {
    for side in contact.pair.sides() {
        let points = scene.model.bodies[side.body.0].mesh.points();
        for strand in scene.side(side) {
            let path = strand.path(&|n| view.pixel(points[n]));
            svg.path(&path, colour, 2.4, "none", "stroke-linecap=\"round\"");
        }
    }
    if let Pair::Obstacle {
        nonmortar,
        obstacle,
    } = &contact.pair
    {
        let points = scene.model.bodies[nonmortar.body.0].mesh.points();
        for strand in scene.side(nonmortar) {
            let surface: Vec<(Pixel, Pixel)> = strand
                .marks(points, 60, false)
                .iter()
                .map(|s| {
                    let point = obstacle
                        .shape
                        .drawn(s.point, s.normal, scene.model.last_time());
                    (view.pixel(point), on_paper(s.normal))
                })
                .collect();
            let line: Vec<Pixel> = surface.iter().map(|s| s.0).collect();
            svg.path(&polyline(&line), INK, 1.6, "none", "");
            hatch(svg, &surface, INK);
        }
    }
}

/// Names of tints, lines and symbols below a figure of this width and height; returns the lower end.
fn legend(svg: &mut Svg, scene: &Scene, labels: &Labels, alone: bool, below: Pixel) -> f64 {
    let mut flow = name_parts(svg, scene.model, labels, below);
    if alone {
        name_alone(svg, &mut flow);
    }
    symbols(svg, scene, &mut flow);
    flow.y + 12.0
}

/// Begins a legend below a figure of this width and height: bodies, contacts and points of couples.
pub fn name_parts<const D: usize>(
    svg: &mut Svg,
    model: &Model<D>,
    labels: &Labels,
    [width, top]: Pixel,
) -> Flow {
    svg.line([0.0, top], [width, top], RULE, 1.0);
    let mut flow = Flow {
        x: 4.0,
        y: top + 20.0,
        width,
    };
    let more = |svg: &mut Svg, flow: &mut Flow, count: usize, what: &str| {
        if count > NAMED {
            let text = format!("and {} more {what}", count - NAMED);
            let at = flow.next(&text);
            let start = Type::LABEL.coloured(MUTED).anchored(Anchor::Start);
            svg.text([at[0] + 22.0, at[1]], &text, start);
        }
    };
    for (i, body) in model.bodies.iter().enumerate().take(NAMED) {
        let tint = TINTS[i % TINTS.len()];
        let at = flow.explain(svg, &body_text(body, labels));
        svg.rectangle([at[0], at[1] - 9.0], [16.0, 10.0], INK, tint);
        for (k, group) in shaded_groups(body).into_iter().enumerate().take(NAMED) {
            let own = body
                .materials
                .iter()
                .find(|m| m.group.as_deref() == Some(group));
            let Some(material) = own.or(body.materials.last()) else {
                continue;
            };
            let text = format!("{group} {}", stiffness(material, labels));
            let [x, y] = flow.explain(svg, &text);
            svg.rectangle([x, y - 9.0], [16.0, 10.0], INK, tint);
            let corners = [
                [x, y - 9.0],
                [x + 16.0, y - 9.0],
                [x + 16.0, y + 1.0],
                [x, y + 1.0],
            ];
            svg.path(
                &polyline(&corners),
                "none",
                0.0,
                INK,
                SHADES[k % SHADES.len()],
            );
        }
    }
    more(svg, &mut flow, model.bodies.len(), "bodies");
    for (i, contact) in model.contacts.iter().enumerate().take(NAMED) {
        let filled = contact.gasket.as_ref().map_or("", |_| ", gasket");
        let law = format!("contact {} ({}{filled})", contact.name, contact.law);
        let at = flow.explain(svg, &law);
        let y = at[1] - 4.0;
        svg.line([at[0], y], [at[0] + 16.0, y], SERIES[i % SERIES.len()], 2.6);
    }
    more(svg, &mut flow, model.contacts.len(), "contacts");
    for (body, couple) in couples(model).take(NAMED) {
        let at = flow.explain(svg, &in_words(&model.bodies[body].name, couple));
        let point = [at[0] + 8.0, at[1] - 9.0];
        for end in [-7.0, 7.0] {
            svg.line(point, [point[0] + end, at[1]], MUTED, 0.7);
        }
        svg.circle(point, 3.0, INK, "white", "");
    }
    more(svg, &mut flow, couples(model).count(), "points");
    flow
}

/// The entry of contact nodes without an opposite side.
pub fn name_alone(svg: &mut Svg, flow: &mut Flow) {
    let at = flow.explain(svg, "contact node that faces nothing");
    svg.circle([at[0] + 8.0, at[1] - 4.0], 2.6, ALARM, "white", "");
}

/// Support symbols and loads that occur, in words.
fn symbols(svg: &mut Svg, scene: &Scene, flow: &mut Flow) {
    let supports = || scene.model.bodies.iter().flat_map(|b| &b.supports);
    let rolling = |s: &Support<2>| matches!(hold(s), Some(Hold::Axis(_) | Hold::Normal));
    let clamped = |s: &Support<2>| hold(s) == Some(Hold::Clamp);
    if supports().any(rolling) {
        let at = flow.explain(svg, "one displacement held");
        roller(svg, [at[0] + 8.0, at[1] - 11.0], [0.0, 1.0]);
    }
    if supports().any(clamped) {
        let at = flow.explain(svg, "both displacements held");
        svg.line(
            [at[0], at[1] - 8.0],
            [at[0] + 16.0, at[1] - 8.0],
            SUPPORT,
            2.0,
        );
        let ground: Vec<(Pixel, Pixel)> = (0..4)
            .map(|k| ([at[0] + 3.0 + 4.5 * f64::from(k), at[1] - 8.0], [0.0, 1.0]))
            .collect();
        hatch(svg, &ground, SUPPORT);
    }
    if scene.model.bodies.iter().any(|b| !b.loads.is_empty()) {
        name_loads(svg, flow);
    }
    name_links(svg, scene.model, flow);
}

/// Kind and bond of a member, which a drawing shows.
type Look = (MemberWords, Bond);

/// Those of a member.
pub fn look<const D: usize>(member: &Member<D>) -> Look {
    (member.kind.words(), member.line.bond)
}

/// Dashes of the kinds, by turns.
const DASHES: [&str; 3] = ["", "stroke-dasharray=\"5 3\"", "stroke-dasharray=\"2 2\""];

/// A member from one end to the other, dashed by its kind, with its ends marked, or its whole length if it is grouted.
pub fn draw_member(svg: &mut Svg, [from, to]: [Pixel; 2], (kind, bond): Look) {
    if bond == Bond::Grouted {
        svg.line(from, to, "white", 5.0);
    }
    let place = MemberKind::ALL.iter().position(|own| *own == kind);
    match DASHES[place.unwrap_or(0) % DASHES.len()] {
        "" => svg.line(from, to, BAR, 2.2),
        dashes => svg.path(&polyline(&[from, to]), BAR, 2.2, "none", dashes),
    }
    for end in [from, to] {
        svg.circle(
            end,
            2.8,
            BAR,
            if bond == Bond::Ends { BAR } else { "white" },
            "",
        );
    }
}

/// The entries of springs and members, if there are any.
pub fn name_links<const D: usize>(svg: &mut Svg, model: &Model<D>, flow: &mut Flow) {
    if model.bodies.iter().any(|body| !body.springs.is_empty()) {
        let at = flow.explain(svg, "spring");
        zigzag(svg, [at[0] + 8.0, at[1] - 12.0], [0.0, 1.0]);
    }
    for (kind, members) in model.members_by_kind() {
        for bond in [Bond::Ends, Bond::Grouted] {
            if members.iter().any(|member| member.line.bond == bond) {
                let bolts = members.iter().any(|member| member.kind.is_bolt());
                let at = flow.explain(
                    svg,
                    &match bolts {
                        true => format!("{}, drawn together at its cut", kind.key),
                        false => format!("{}, {}", kind.key, bond.held()),
                    },
                );
                let y = at[1] - 4.0;
                draw_member(svg, [[at[0], y], [at[0] + 16.0, y]], (kind, bond));
            }
        }
    }
}

/// The entry of loads.
pub fn name_loads(svg: &mut Svg, flow: &mut Flow) {
    let at = flow.explain(svg, "load on the undeformed surface");
    svg.arrow([at[0], at[1] - 4.0], [at[0] + 17.0, at[1] - 4.0], LOAD, 1.1);
}

/// Stiffness of a material.
fn stiffness(material: &Material, labels: &Labels) -> String {
    let young = match &material.ages {
        Some(ages) => format!(
            "{}, now {}",
            ages.young,
            quantity(material.elastic.young, &labels.stress)
        ),
        None => quantity(material.elastic.young, &labels.stress),
    };
    format!("(E = {young}, ν = {})", number(material.elastic.poisson))
}

/// Name, stiffness, sector, body force and water of a body.
pub fn body_text<const D: usize>(body: &Body<D>, labels: &Labels) -> String {
    let mut text = body.name.clone();
    if let [material] = body.materials.as_slice() {
        text += &format!(" {}", stiffness(material, labels));
    }
    if body.body_force.iter().any(|f| f.as_constant() != Some(0.0)) {
        let constant: Option<Vec<f64>> = body.body_force.iter().map(Field::as_constant).collect();
        text += &match constant {
            Some(values) => format!(", body force {}", vector(&values, &labels.density)),
            None => {
                let fields: Vec<String> = body.body_force.iter().map(Field::to_string).collect();
                format!(", body force ({})", fields.join(", "))
            }
        };
    }
    if let Some(cyclic) = &body.cyclic {
        text += &format!(", one of {} sectors", cyclic.sectors);
    }
    if body.initial.pore.is_some() {
        text += ", water in its pores";
    }
    text
}

/// A text in lines that are not wider than this, divided at its spaces.
fn wrapped(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_string()),
        }
    }
    lines
}

/// Places entries of a legend in rows.
pub struct Flow {
    /// Where the next entry begins.
    pub x: f64,
    /// Baseline of the row.
    pub y: f64,
    /// Of the figure.
    pub width: f64,
}

impl Flow {
    /// Writes the text of the next entry, in several lines if it is wider than the figure; returns the place of its symbol, 16 px
    /// wide.
    pub fn explain(&mut self, svg: &mut Svg, text: &str) -> Pixel {
        let at = self.next(text);
        let start = Type::LABEL.anchored(Anchor::Start);
        for (k, line) in wrapped(text, start.size, self.width - 26.0)
            .iter()
            .enumerate()
        {
            self.y = at[1] + 14.0 * k as f64;
            svg.text([at[0] + 22.0, self.y], line, start);
        }
        at
    }

    fn next(&mut self, text: &str) -> Pixel {
        let width = 22.0 + text_width(text, Type::LABEL.size) + 20.0;
        if self.x > 4.0 && self.x + width > self.width {
            (self.x, self.y) = (4.0, self.y + 20.0);
        }
        let at = [self.x, self.y];
        self.x += width;
        at
    }
}
