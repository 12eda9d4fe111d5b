//! The case file of a problem.

use crate::amount::Amount;
use crate::problem::{
    Against, Analysis, Bar, Beyond, Body, Contact, Couple, Drawing, Drive, Edge, Field, Gap, Law,
    Load, Metal, Pairing, Place, Problem, Shape, Side, Spring, Support, Surface,
};
use std::fmt::Write;

impl<const D: usize> Problem<D> {
    /// The case file.
    pub fn text(&self) -> String {
        let mut out = format!(
            "title    = \"campaign: {}\"\nanalysis = \"{}\"\n",
            self.family,
            self.analysis.name()
        );
        if let Some(drawing) = &self.drawing {
            write_drawing(&mut out, drawing);
        }
        for body in &self.bodies {
            write_body(&mut out, body, self.analysis);
        }
        for contact in &self.contacts {
            write_contact(&mut out, contact);
        }
        for body in &self.bodies {
            write_bar(&mut out, body);
        }
        for section in &self.sections {
            line(
                &mut out,
                format_args!(
                    "\n[[section]]\nname     = \"{}\"\nbody     = \"{}\"\nsides    = {:?}\nstations = {:?}",
                    section.name, section.body, section.sides, section.stations
                ),
            );
        }
        let method = (self.method != "auto").then(|| format!("method = \"{}\"", self.method));
        let pieces = self.subdomains.map(|count| format!("subdomains = {count}"));
        let solver: Vec<String> = method.into_iter().chain(pieces).collect();
        if !solver.is_empty() {
            line(&mut out, format_args!("\n[solver]\n{}", solver.join("\n")));
        }
        if self.times != [1.0] {
            for time in &self.times {
                line(&mut out, format_args!("\n[[step]]\ntime = {time:?}"));
            }
        }
        out
    }
}

/// Writing to a String cannot fail.
fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = writeln!(out, "{text}");
}

fn write_drawing(out: &mut String, drawing: &Drawing) {
    let Drawing {
        from: [x, y],
        to: [z, w],
        border,
        size,
        cell,
    } = drawing;
    let cell = cell.name();
    let high = 0.5 * (y + w);
    line(
        out,
        format_args!(
            "\n[drawing]\ncell    = \"{cell}\"\nsize    = {size:?}\nlines   = [{{ from = [{x:?}, {y:?}], edges = [\
             {{ to = [{border:?}, {y:?}], name = \"bottom\" }}, {{ to = [{z:?}, {y:?}], name = \"bottom\" }}, \
             {{ to = [{z:?}, {w:?}], name = \"right\" }}, {{ to = [{border:?}, {w:?}], name = \"top\" }}, \
             {{ to = [{x:?}, {w:?}], name = \"top\" }}, {{ to = [{x:?}, {y:?}], name = \"left\" }}] }}, \
             {{ from = [{border:?}, {y:?}], to = [{border:?}, {w:?}], name = \"border\" }}]\n\
             regions = [{{ name = \"a\", at = [{:?}, {high:?}] }}, {{ name = \"b\", at = [{:?}, {high:?}] }}]",
            0.5 * (x + border),
            0.5 * (border + z)
        ),
    );
}
fn write_body<const D: usize>(out: &mut String, body: &Body<D>, analysis: Analysis) {
    line(
        out,
        format_args!("\n[[body]]\nname     = \"{}\"", body.name),
    );
    let patches: Vec<String> = body
        .patches
        .iter()
        .map(|p| {
            format!(
                "{} = {{ of = \"{}\", min = {:?}, max = {:?} }}",
                p.name, p.of, p.low, p.high
            )
        })
        .collect();
    let patches = match patches.len() {
        0 => String::new(),
        _ => format!(", sides = {{ {} }}", patches.join(", ")),
    };
    line(
        out,
        format_args!("mesh     = {{ {}{patches} }}", shape(body)),
    );
    let thickness = match analysis {
        Analysis::Axisymmetric => String::new(),
        _ if body.thickness == 1.0 => String::new(),
        _ => format!(", thickness = {:?}", body.thickness),
    };
    let material = |group: &str, young: f64, poisson: f64| {
        format!("{{ {group}young = {young:?}, poisson = {poisson:?}{thickness} }}")
    };
    let metal = body.more.metal.as_ref();
    let metal = metal.map_or(String::new(), |Metal { yields, hardening }| {
        format!("strength = {{ yield = {yields:?} }}, plastic = true, hardening = {hardening:?}, ")
    });
    let plain = material(&metal, body.young, body.poisson);
    let materials = match &body.more.beyond {
        None => plain,
        Some(Beyond { young, poisson, .. }) => {
            format!(
                "[{plain}, {}]",
                material("group = \"b\", ", *young, *poisson)
            )
        }
    };
    line(out, format_args!("material = {materials}"));
    if let Some(from) = body.more.from {
        line(out, format_args!("active   = {{ from = {from:?} }}"));
    }
    if let Some([xx, yy, zz, xy]) = &body.more.initial {
        let [xx, yy, zz, xy] = [xx, yy, zz, xy].map(Amount::text);
        line(
            out,
            format_args!("initial_stress = {{ xx = {xx}, yy = {yy}, zz = {zz}, xy = {xy} }}"),
        );
    }
    let mut springs: Vec<String> = body.more.springs.iter().map(spring).collect();
    if let Some(Bar {
        at,
        stiffness,
        to: None,
        ..
    }) = &body.more.bar
    {
        springs.push(format!("{{ point = {at:?}, x = {stiffness:?} }}"));
    }
    if !springs.is_empty() {
        line(out, format_args!("spring   = [{}]", springs.join(", ")));
    }
    if let Some(couple) = &body.more.couple {
        let kind = if couple.rigid { "rigid" } else { "average" };
        line(
            out,
            format_args!(
                "points   = {{ c = {:?} }}\ncouple   = [{{ side = \"{}\", point = \"c\", kind = \"{kind}\" }}]",
                couple.point, couple.side
            ),
        );
    }
    if !body.supports.is_empty() {
        let each = body.supports.iter().map(|s| support(s, &body.more.couple));
        let each: Vec<String> = each.collect();
        line(out, format_args!("fix      = [{}]", each.join(", ")));
    }
    if !body.loads.is_empty() {
        let each = body.loads.iter().map(|l| load(l, &body.more.couple));
        let each: Vec<String> = each.collect();
        line(out, format_args!("load     = [{}]", each.join(", ")));
    }
    if body.weight.iter().any(|w| !w.is_zero()) {
        line(out, format_args!("body_force = {}", vector(&body.weight)));
    }
    if !body.surfaces.is_empty() {
        let each = body.surfaces.iter();
        let each =
            each.map(|(side, true_one)| format!("{side} = {{ {} }}", surface(true_one, false)));
        let each: Vec<String> = each.collect();
        line(out, format_args!("surface  = {{ {} }}", each.join(", ")));
    }
}

fn shape<const D: usize>(body: &Body<D>) -> String {
    let cell = body.kind.name();
    match &body.shape {
        Shape::Block {
            from,
            to,
            cells,
            diagonals,
        } if D == 2 => format!(
            "rectangle = {{ from = {from:?}, to = {to:?}, cells = {cells:?}, cell = \"{cell}\", diagonals = \"{diagonals}\" }}"
        ),
        Shape::Block {
            from, to, cells, ..
        } => format!(
            "box = {{ from = {from:?}, to = {to:?}, cells = {cells:?}, cell = \"{cell}\" }}"
        ),
        Shape::Ring {
            center,
            radii,
            angles,
            cells,
            ratio,
        } => {
            let part = match angles {
                Some([from, to]) => format!("from = {from:?}, to = {to:?}, "),
                None => String::new(),
            };
            format!(
                "ring = {{ center = {center:?}, inner = {:?}, outer = {:?}, {part}cells = {cells:?}, ratio = {ratio:?}, cell = \"{cell}\" }}",
                radii[0], radii[1]
            )
        }
        Shape::Outline { size, from, edges } => {
            let each: Vec<String> = edges.iter().map(edge).collect();
            format!(
                "outline = {{ size = {size:?}, cell = \"{cell}\", from = {from:?}, edges = [{}] }}",
                each.join(", ")
            )
        }
        Shape::Disc {
            size,
            center,
            radius,
            cells,
        } => {
            let cells = cells.map_or(String::new(), |n| format!(", cells = {n}"));
            format!(
                "outline = {{ size = {size:?}, cell = \"{cell}\", circle = {{ center = {center:?}, radius = {radius:?}, name = \"round\"{cells} }} }}"
            )
        }
        Shape::Cylinder {
            base,
            axis,
            radii: [inner, outer],
            height,
            cells,
        } => format!(
            "cylinder = {{ base = {base:?}, axis = {axis:?}, radius = {outer:?}, inner = {inner:?}, height = {height:?}, cells = {cells:?}, cell = \"{cell}\" }}"
        ),
        Shape::Ball {
            center,
            radius,
            cells,
        } => format!(
            "sphere = {{ center = {center:?}, radius = {radius:?}, cells = {cells:?}, cell = \"{cell}\" }}"
        ),
        Shape::Column {
            corners,
            names,
            size,
            height,
            layers,
        } => {
            let ends = corners.iter().cycle().skip(1);
            let edges = ends
                .zip(names)
                .map(|(to, name)| format!("{{ to = {to:?}, name = \"{name}\" }}"));
            let edges: Vec<String> = edges.collect();
            let flat = if body.kind.linear() { "tri3" } else { "tri6" };
            format!(
                "extrude = {{ mesh = {{ outline = {{ size = {size:?}, cell = \"{flat}\", from = {:?}, edges = [{}] }} }}, height = {height:?}, layers = {layers} }}",
                corners[0],
                edges.join(", ")
            )
        }
        Shape::File { name, .. } => format!("file = {{ path = \"{name}\" }}"),
        Shape::Region(names) => format!("region = {names:?}"),
    }
}

fn edge(edge: &Edge) -> String {
    let arc = edge
        .center
        .map_or(String::new(), |c| format!(", center = {c:?}"));
    let cells = edge
        .cells
        .map_or(String::new(), |n| format!(", cells = {n}"));
    let names = quoted(edge.name.split(' '));
    format!("{{ to = {:?}, name = {names}{arc}{cells} }}", edge.to)
}

fn support<const D: usize>(support: &Support<D>, couple: &Option<Couple<D>>) -> String {
    let rigid = |side: &String| couple.as_ref().is_some_and(|c| c.rigid && c.side == *side);
    let mut keys = vec![match &support.place {
        Place::Side(side) if rigid(side) => "point = \"c\", rotation = 0".to_string(),
        Place::Side(side) => format!("side = \"{side}\""),
        Place::Point(point) => format!("point = {point:?}"),
    }];
    let named = support.axes.iter().zip(["x", "y", "z"]);
    for (value, name) in named.chain([(&support.normal, "normal")]) {
        keys.extend(value.as_ref().map(|v| format!("{name} = {}", v.text())));
    }
    if let Some(from) = support.from {
        keys.push(format!("active = {{ from = {from:?} }}"));
    }
    format!("{{ {} }}", keys.join(", "))
}

fn spring(spring: &Spring) -> String {
    format!(
        "{{ side = \"{}\", normal = {:?}, tangential = {:?}, compression_only = {} }}",
        spring.side, spring.normal, spring.tangential, spring.compression_only
    )
}

fn load<const D: usize>(load: &Load<D>, couple: &Option<Couple<D>>) -> String {
    match load {
        Load::Traction { side, field }
            if couple.as_ref().is_some_and(|c| !c.rigid && c.side == *side) =>
        {
            let area = couple.as_ref().map_or(1.0, |c| c.area);
            let force = field.each_ref().map(|f| f.times(area));
            format!("{{ point = \"c\", force = {} }}", vector(&force))
        }
        Load::Traction { side, field } => {
            format!("{{ side = \"{side}\", traction = {} }}", vector(field))
        }
        Load::Pressure { side, field } => {
            format!("{{ side = \"{side}\", pressure = {} }}", field.text())
        }
        Load::Force { point, field } => {
            format!("{{ point = {point:?}, force = {} }}", vector(field))
        }
        Load::InSitu { side, factor } => {
            format!("{{ side = \"{side}\", in_situ = {} }}", factor.text())
        }
    }
}

fn vector<const D: usize>(field: &Field<D>) -> String {
    let each = field.each_ref().map(Amount::text);
    format!("[{}]", each.join(", "))
}

/// A surface; `rigid` if it is that of an obstacle.
fn surface<const D: usize>(surface: &Surface<D>, rigid: bool) -> String {
    let side = |inside: &bool| match rigid {
        true => format!(", inside = {inside}"),
        false => String::new(),
    };
    match surface {
        Surface::Gap(gap) => format!("gap = {}", gap.text()),
        Surface::Plane { point, normal } => {
            format!("plane = {{ point = {point:?}, normal = {normal:?} }}")
        }
        Surface::Round {
            center,
            radius,
            inside,
        } => {
            let name = if D == 2 { "circle" } else { "sphere" };
            let inside = side(inside);
            format!("{name} = {{ center = {center:?}, radius = {radius:?}{inside} }}")
        }
        Surface::Cylinder {
            point,
            axis,
            radius,
            inside,
        } => format!(
            "cylinder = {{ point = {point:?}, axis = {axis:?}, radius = {radius:?}{} }}",
            side(inside)
        ),
    }
}

/// A bar to another body.
fn write_bar<const D: usize>(out: &mut String, body: &Body<D>) {
    let Some(Bar {
        at,
        stiffness,
        to: Some((other, to)),
        gives,
    }) = &body.more.bar
    else {
        return;
    };
    let long = (to[0] - at[0]).abs();
    line(
        out,
        format_args!(
            "\n[[bar]]\nname     = \"bar\"\nfrom     = {at:?}\nto       = {to:?}\n\
             bodies   = {:?}\nyoung    = {:?}\narea     = 1.0",
            [&body.name, other],
            stiffness * long
        ),
    );
    if let Some(most) = gives.as_ref().and_then(|gives| gives.most) {
        line(out, format_args!("yield    = {most:?}"));
    }
    if gives.as_ref().is_some_and(|gives| gives.slack) {
        line(out, format_args!("tension_only = true"));
    }
}

fn write_contact<const D: usize>(out: &mut String, contact: &Contact<D>) {
    let own = named(&contact.own);
    line(
        out,
        format_args!("\n[[contact]]\nname      = \"{}\"", contact.name),
    );
    match &contact.against {
        Against::Side { side, chosen } => {
            let other = named(side);
            if *chosen {
                line(out, format_args!("sides     = [{own}, {other}]"));
            } else {
                line(out, format_args!("nonmortar = {own}\nmortar    = {other}"));
            }
        }
        Against::Obstacle {
            surface: obstacle,
            drive,
        } => {
            let obstacle = surface(obstacle, true);
            let drive = match drive {
                Drive::Nothing => String::new(),
                Drive::Displacement(field) => format!(", displacement = {}", vector(field)),
                Drive::Force(field) => format!(", force = {}", vector(field)),
            };
            line(
                out,
                format_args!("nonmortar = {own}\nobstacle  = {{ {obstacle}{drive} }}"),
            );
        }
    }
    if contact.pairing == Pairing::Mortar {
        line(out, format_args!("pairing   = \"mortar\""));
    }
    match &contact.gap {
        Gap::Default => {}
        Gap::Closed => line(out, format_args!("gap       = \"closed\"")),
        Gap::Geometric => line(out, format_args!("gap       = \"geometric\"")),
        Gap::Given(gap) => line(out, format_args!("gap       = {}", gap.text())),
    }
    match &contact.law {
        Law::Frictionless => {}
        Law::Coulomb(value) => line(out, format_args!("friction  = {}", value.text())),
        Law::Tresca(value) => {
            line(
                out,
                format_args!("friction  = {{ tresca = {} }}", value.text()),
            );
        }
        Law::Tied => line(out, format_args!("tied      = true")),
        Law::Joint {
            coulomb,
            cohesion,
            tension,
        } => line(
            out,
            format_args!(
                "friction  = {{ coulomb = {coulomb:?}, cohesion = {cohesion:?}, tension = {tension:?} }}"
            ),
        ),
    }
}

/// A side, or a list of sides, in quotes.
fn named(side: &Side) -> String {
    quoted(side.side.split('+').map(|s| format!("{}.{s}", side.body)))
}

/// A name, or a list of names, in quotes.
fn quoted(names: impl Iterator<Item = impl std::fmt::Debug>) -> String {
    match &names.collect::<Vec<_>>()[..] {
        [one] => format!("{one:?}"),
        several => format!("{several:?}"),
    }
}
