//! Section "Section forces" of the report: diagrams on the geometry and over the middle line, the envelope over the load steps,
//! its extremes, and the forces inside the limit curve of a section.

use crate::geometry::{Point, bounding_box, sub};
use crate::model::{
    Analysis, Capacity, Model, Section, SectionQuantity, SectionSolution, SideRef, Station,
};
use crate::output::Overview;
use crate::output::colour;
use crate::output::encode::png;
use crate::output::html::{column, fitted, left, plain, table_of_vectors, text};
use crate::output::markup::{Markup, markup};
use crate::output::plot::{Axis, Frame};
use crate::output::ranges::{BAR, colour_bar};
use crate::output::scene::{PHONE, Strand, outline_path, strands, ticks};
use crate::output::svg::{
    Anchor, INK, MUTED, Pixel, SERIES, SIGNS, Svg, Type, segments, text_width,
};
use crate::output::text::{Labels, count, number, quantity, vector, with_unit, without_noise};
use crate::output::view::{Margin, View, on_paper, scale_bar};

/// Between the steps.
const SHADE: &str = "#cfe0ee";

/// More stations than this have no lines across their diagram.
const MOST_LINES: usize = 90;

/// Points of a limit curve, and the most points of forces beside it.
const LIMIT_POINTS: usize = 120;
const MOST_POINTS: usize = 4000;

/// A quantity of a station that is drawn.
struct Curve {
    name: &'static str,
    unit: String,
    value: fn(&Station) -> f64,
}

fn curves(labels: &Labels) -> [Curve; 3] {
    let curve = |name: &'static str, unit: &str, value: fn(&Station) -> f64| Curve {
        name,
        unit: unit.to_string(),
        value,
    };
    [
        curve("N", &labels.per_length, |s| s.normal),
        curve("V", &labels.per_length, |s| s.shear),
        curve("M", &labels.moment_per_length, |s| s.moment),
    ]
}

/// Curves of V2, M2 and T in space.
fn curves_across(section: &SectionSolution, labels: &Labels) -> Vec<Curve> {
    let curve = |quantity: SectionQuantity, unit: &str, value: fn(&Station) -> f64| Curve {
        name: quantity.name(),
        unit: unit.to_string(),
        value,
    };
    let whole = |s: &Station| s.across.is_some_and(|own| own.moment.is_some());
    let whole = section.stations.iter().any(whole);
    let across = section.extrusion.is_some();
    let force = across.then(|| {
        curve(SectionQuantity::AxialShear, &labels.per_length, |s| {
            SectionQuantity::AxialShear.at(s)
        })
    });
    let moment = whole.then(|| {
        curve(
            SectionQuantity::AxialMoment,
            &labels.moment_per_length,
            |s| SectionQuantity::AxialMoment.at(s),
        )
    });
    let twist = across.then(|| {
        curve(SectionQuantity::Twist, &labels.moment_per_length, |s| {
            SectionQuantity::Twist.at(s)
        })
    });
    [force, moment, twist].into_iter().flatten().collect()
}

/// Curves of forces in space, of hoop forces and of the utilisation, if present.
fn more_curves(section: &SectionSolution, labels: &Labels) -> Vec<Curve> {
    let mut more = curves_across(section, labels);
    if section.stations.iter().any(|s| s.hoop.is_some()) {
        more.push(Curve {
            name: "hoop N",
            unit: labels.per_length.clone(),
            value: |s| s.hoop.map_or(f64::NAN, |hoop| hoop[0]),
        });
        more.push(Curve {
            name: "hoop M",
            unit: labels.moment_per_length.clone(),
            value: |s| s.hoop.map_or(f64::NAN, |hoop| hoop[1]),
        });
    }
    if section.stations.iter().any(|s| s.utilisation.is_some()) {
        more.push(Curve {
            name: "utilisation",
            unit: String::new(),
            value: |s| s.utilisation.unwrap_or(f64::NAN),
        });
    }
    more
}

/// The section; empty without section forces.
pub fn sections_section<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    let asked = run.model.sections.iter().enumerate();
    let several = run.last.sections.len() > 1;
    let parts: Markup = asked
        .map(|(k, section)| one_section(run, (k, section), several, labels))
        .collect();
    if parts.is_empty() {
        return parts;
    }
    let per = match run.model.analysis {
        Analysis::Axisymmetric => "circumference at the middle of the cut",
        Analysis::Solid => "length along the axis of extrusion",
        _ => "thickness",
    };
    let more = match run.model.analysis {
        Analysis::Solid => {
            " V2 is positive where it pushes the part ahead along the axis, M2 with tension at the end to which the axis points; T \
             turns the part behind right-handed about s."
        }
        _ => "",
    };
    let head = markup!(
        "<h2>Section forces</h2>\n<p>By equilibrium of the parts that each cut divides, about the middle of the cut, per unit of {}. \
         N is positive in tension; M is positive with tension on the first side; V is positive where it pushes the part ahead \
         towards the first side, which lies on the left of s.{}</p>\n",
        per,
        more
    );
    match several {
        true => head + all_sections(run, labels) + parts,
        false => head + parts,
    }
}

/// The diagrams of all sections to one scale, as around the segments of a ring.
fn all_sections<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    let solved = run.last.sections.iter();
    let drawn = solved.filter_map(|own| {
        let asked = run
            .model
            .sections
            .iter()
            .find(|asked| asked.name == own.name)?;
        Some(Drawn::of(run.model, asked, own.mean().into_owned()))
    });
    let Some(drawn) = drawn.collect::<Option<Vec<Drawn>>>() else {
        return Markup::default();
    };
    let draw = |width| on_geometry(&drawn, "sections", labels, width);
    let step = if run.earlier.is_empty() {
        ""
    } else {
        " The last load step."
    };
    let caption = format!(
        "All {} sections to one scale, with the extremes of all. {TOWARDS_FIRST}{step}",
        count(drawn.len())
    );
    fitted(&draw, "N, V and M of all sections", &caption)
}

/// Which side of its middle line a diagram is drawn on.
const TOWARDS_FIRST: &str = "Positive values are drawn from the middle line towards the first side: M on the side in tension.";

fn one_section<const D: usize>(
    run: &Overview<'_, D>,
    (index, asked): (usize, &Section<D>),
    among_others: bool,
    labels: &Labels,
) -> Markup {
    // in some steps its body may not be there
    let there = run.steps().enumerate().filter_map(|(step, solution)| {
        let mut sections = solution.sections.iter();
        Some((step + 1, sections.find(|s| s.name == asked.name)?))
    });
    let (numbers, steps): (Vec<usize>, Vec<&SectionSolution>) = there.unzip();
    let Some(&told) = steps.last() else {
        return Markup::default();
    };
    let mean = told.mean();
    let last = &*mean;
    let mut out = markup!("<h3>{}</h3>\n", asked.name);
    let bodies = asked.bodies.iter();
    let bodies: Vec<&str> = bodies.map(|b| &run.model.bodies[b.0].name[..]).collect();
    let [first, second] = asked
        .sides
        .each_ref()
        .map(|sides| long_side(run.model, asked, sides));
    let extruded = told.extrusion.as_ref().map_or(String::new(), |own| {
        let means = if own.places > 1 {
            "; means along it"
        } else {
            ""
        };
        format!(
            " Extruded along {} by {}{means}.",
            vector(&own.axis, ""),
            quantity(own.length, &labels.length)
        )
    });
    let between = format!(
        "{} between {} (first) and {}, {} stations, length of the middle line {}.{extruded}",
        bodies.join(", "),
        first,
        second,
        count(last.stations.len()),
        quantity(last.length, &labels.length)
    );
    let several = if steps.len() > 1 {
        " The last load step."
    } else {
        ""
    };
    match Drawn::of(run.model, asked, last.clone()) {
        Some(drawn) if !among_others => {
            let id = format!("section{index}");
            let draw = |width| on_geometry(std::slice::from_ref(&drawn), &id, labels, width);
            let caption = format!("{between} {TOWARDS_FIRST}{several}");
            out += fitted(&draw, "N, V and M on the geometry", &caption);
        }
        _ => out += markup!("<p>{}</p>\n", between),
    }
    let along = match (steps.len(), told.places()) {
        (1, 1) => "Along the middle line; s counts from the first station.".to_string(),
        (1, places) => format!(
            "Along the middle line. Line: the mean along the axis; shaded: between the least and the largest value at {} places.",
            count(places)
        ),
        (n, places) => format!(
            "Along the middle line. Line: the last load step; shaded: between the least and the largest value of all {} steps{}.",
            count(n),
            if places > 1 {
                " and places along the axis"
            } else {
                ""
            }
        ),
    };
    let draw = |width| over_s((last, &steps), index, labels, width);
    out += fitted(&draw, "Section forces over s", &along);
    if told.places() > 1 {
        let draw = |width| maps(told, index, labels, width);
        let caption = format!(
            "Unrolled: s to the right, the axis upwards, from the end of the bodies where it begins.{several}"
        );
        out += fitted(&draw, "Section forces along the axis", &caption);
    }
    if let Some(capacity) = &asked.capacity {
        let draw = |width| interaction(capacity, &steps, index, labels, width);
        let caption = limit_in_words(capacity, steps.len() > 1, labels);
        out += fitted(&draw, "Normal force and moment within the limit", &caption);
    }
    out + extremes((&numbers, &steps), labels)
}

/// A long side in words: its name, and those of the bodies where these have sides of different names.
fn long_side<const D: usize>(model: &Model<D>, asked: &Section<D>, sides: &[SideRef]) -> String {
    let same = sides.iter().all(|side| side.side == sides[0].side);
    if same && (asked.bodies.len() == 1 || sides.len() > 1) {
        return sides[0].side.clone();
    }
    let each = sides
        .iter()
        .map(|s| format!("{}.{}", model.bodies[s.body.0].name, s.side));
    each.collect::<Vec<_>>().join(", ")
}

/// Stations in the order of s, those of each place along the axis.
fn rows(section: &SectionSolution) -> Vec<Vec<&Station>> {
    let count = section.stations.len() / section.places();
    let places = section.stations.chunks(count.max(1));
    let sorted = places.map(|stations| {
        let mut stations: Vec<&Station> = stations.iter().collect();
        stations.sort_by(|a, b| a.s.total_cmp(&b.s));
        stations
    });
    sorted.collect()
}

/// How much larger than other rounding the error of the direction of a cut is.
const DIRECTION: f64 = 200.0;

/// Sets values to zero that are rounding relative to the others: moments relative to forces times the thickness.
fn quiet(
    section: &SectionSolution,
    value: fn(&Station) -> f64,
    name: &str,
) -> impl Fn(&Station) -> f64 {
    let force = section.stations.iter().map(|s| {
        s.normal
            .abs()
            .max(s.shear.abs())
            .max(s.moment.abs() / s.thickness)
    });
    let force = force.filter(|f| f.is_finite()).fold(0.0, f64::max);
    let thickness = section
        .stations
        .iter()
        .map(|s| s.thickness)
        .fold(0.0, f64::max);
    let scale = match name {
        "M" | "hoop M" | "T" => force * thickness,
        "M2" => force * section.extrusion.as_ref().map_or(0.0, |own| own.length),
        "utilisation" => 0.0,
        // the direction of a cut is known to 1e-8, and so is that of N
        "V" => DIRECTION * force,
        _ => force,
    };
    move |station| without_noise(value(station), scale)
}

/// A section with the outlines of its bodies.
struct Drawn {
    solution: SectionSolution,
    /// The outline of each body, with its nodes.
    outlines: Vec<(Vec<Strand>, Vec<Point<2>>)>,
}

impl Drawn {
    /// `None` where its bodies have no profile.
    fn of<const D: usize>(
        model: &Model<D>,
        asked: &Section<D>,
        mut solution: SectionSolution,
    ) -> Option<Self> {
        solution.stations.sort_by(|a, b| a.s.total_cmp(&b.s));
        let profiles = asked.profiles(&model.bodies).ok()?;
        let outlines = profiles.iter().map(|mesh| {
            let outline = strands(mesh, &mesh.boundary_facets());
            (outline, mesh.points().to_vec())
        });
        Some(Self {
            outlines: outlines.collect(),
            solution,
        })
    }
}

/// The three diagrams on the outlines of the bodies; beside each other, or one above the other where the bodies are long and on a
/// phone.
fn on_geometry(drawn: &[Drawn], id: &str, labels: &Labels, width: f64) -> Markup {
    let outlines = drawn.iter().flat_map(|own| &own.outlines);
    let points = outlines.flat_map(|(_, points)| points).copied();
    let bounds = bounding_box(&points.collect::<Vec<_>>());
    let size = sub(bounds.1, bounds.0);
    let below = size[0] > 1.8 * size[1] || width <= PHONE;
    let reach: f64 = if below { 46.0 } else { 34.0 };
    let margin = Margin {
        left: reach + 26.0,
        right: reach + 26.0,
        top: reach + 30.0,
        bottom: reach + 12.0,
    };
    let own = if below { width } else { width / 3.0 };
    let tall = (own - margin.left - margin.right) * (size[1] / size[0]).min(3.0);
    let least = if below { 8.0 } else { 60.0 };
    let panel = [own, tall.clamp(least, 380.0) + margin.top + margin.bottom];
    let strip = 34.0;
    let height = strip + if below { 3.0 * panel[1] } else { panel[1] };
    let mut svg = Svg::new(id, "Diagrams of N, V and M on the bodies", width, height);
    let mut last_view = None;
    for (k, curve) in curves(labels).iter().enumerate() {
        let corner = match below {
            true => [0.0, k as f64 * panel[1]],
            false => [k as f64 * panel[0], 0.0],
        };
        let view = View::fitted(bounds, corner, panel, margin);
        diagrams(&mut svg, &view, drawn, curve, reach);
        let style = Type::LABEL.anchored(Anchor::Start).bold();
        svg.text(
            [corner[0] + 8.0, corner[1] + 16.0],
            &with_unit(curve.name, &curve.unit),
            style,
        );
        if k == 0 || below {
            last_view = Some(view);
        }
    }
    if let Some(view) = last_view {
        scale_bar(&mut svg, &view, labels);
    }
    svg.finish()
}

/// One quantity of all sections, `reach` pixels for its largest value, with its extremes.
fn diagrams(svg: &mut Svg, view: &View, drawn: &[Drawn], curve: &Curve, reach: f64) {
    for own in drawn {
        for (outline, points) in &own.outlines {
            let body = outline_path(outline, &|node| view.pixel(points[node]));
            svg.path(&body, "#9aa5b0", 0.8, "#eef1f4", "fill-rule=\"evenodd\"");
        }
    }
    let values = |own: &Drawn| -> Vec<f64> {
        let value = quiet(&own.solution, curve.value, curve.name);
        own.solution.stations.iter().map(value).collect()
    };
    let values: Vec<Vec<f64>> = drawn.iter().map(values).collect();
    let finite = values.iter().flatten().filter(|v| v.is_finite());
    let largest = finite.fold(0.0, |m: f64, v| m.max(v.abs()));
    let scale = if largest > 0.0 { reach / largest } else { 0.0 };
    let mut ends: Vec<(f64, &Station)> = Vec::new();
    for (own, values) in drawn.iter().zip(&values) {
        diagram(svg, view, &own.solution.stations, values, scale);
        let known = values.iter().copied().zip(&own.solution.stations);
        ends.extend(known.filter(|(value, _)| value.is_finite()));
    }
    let most = ends.iter().rev().max_by(|a, b| a.0.total_cmp(&b.0));
    let least = ends.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    if let (Some(&least), Some(&most)) = (least, most) {
        mark(svg, view, most, scale);
        if (most.0 - least.0).abs() > 1e-3 * largest {
            mark(svg, view, least, scale);
        }
    }
}

/// Where the value of a station is drawn: from the middle line towards the first side.
fn tip(view: &View, station: &Station, length: f64) -> Pixel {
    let (at, [x, y]) = (view.pixel(station.point), on_paper(station.toward_first));
    [at[0] + length * x, at[1] + length * y]
}

/// One diagram from the middle line.
fn diagram(svg: &mut Svg, view: &View, stations: &[Station], values: &[f64], scale: f64) {
    let base: Vec<Pixel> = stations.iter().map(|s| view.pixel(s.point)).collect();
    let tips = stations.iter().zip(values);
    let tips: Vec<Pixel> = tips.map(|(s, value)| tip(view, s, scale * value)).collect();
    let mut fills = [String::new(), String::new()];
    for k in 1..stations.len() {
        let (a, b) = (values[k - 1], values[k]);
        if !(a.is_finite() && b.is_finite()) {
            continue;
        }
        let mut piece = |corners: &[Pixel], value: f64| {
            fills[usize::from(value < 0.0)] += &segments(corners, true)
        };
        if a * b < 0.0 {
            let part = a / (a - b);
            let zero = [0, 1].map(|i| base[k - 1][i] + part * (base[k][i] - base[k - 1][i]));
            piece(&[base[k - 1], tips[k - 1], zero], a);
            piece(&[zero, tips[k], base[k]], b);
        } else {
            piece(&[base[k - 1], tips[k - 1], tips[k], base[k]], a + b);
        }
    }
    for (fill, colour) in fills.iter().zip(SIGNS) {
        svg.path(fill, "none", 0.0, colour, "fill-opacity=\"0.22\"");
    }
    if stations.len() <= MOST_LINES {
        for k in 0..stations.len() {
            svg.line(base[k], tips[k], SIGNS[usize::from(values[k] < 0.0)], 0.6);
        }
    }
    let dashes = "stroke-dasharray=\"6 2 1.5 2\"";
    svg.path(&segments(&base, false), INK, 0.8, "none", dashes);
    let round = "stroke-linejoin=\"round\"";
    svg.path(&segments(&tips, false), INK, 1.3, "none", round);
}

/// An extreme with its value.
fn mark(svg: &mut Svg, view: &View, (value, station): (f64, &Station), scale: f64) {
    let away = if value < 0.0 { -1.0 } else { 1.0 };
    let at = tip(view, station, scale * value);
    let [x, y] = on_paper(station.toward_first);
    let label = number(value);
    let style = Type::LABEL
        .coloured(SIGNS[usize::from(value < 0.0)])
        .bold()
        .rimmed();
    let half = 0.5 * text_width(&label, style.size) + 2.0;
    let place = [
        at[0] + away * (4.0 + half) * x,
        at[1] + away * 10.0 * y + 4.0,
    ];
    let (low, high) = (view.corner[0] + half, view.corner[0] + view.size[0] - half);
    let top = view.corner[1] + 30.0;
    let bottom = view.corner[1] + view.size[1] - 2.0;
    svg.circle(at, 2.2, "#fff", style.colour, "");
    let place = [
        place[0].clamp(low, high.max(low)),
        place[1].clamp(top, bottom),
    ];
    svg.text(place, &label, style);
}

/// Plots over s, one above the other, with the envelope of the steps and places behind the last means.
fn over_s(
    (last, steps): (&SectionSolution, &[&SectionSolution]),
    index: usize,
    labels: &Labels,
    width: f64,
) -> Markup {
    let mut all: Vec<Curve> = curves(labels).into();
    all.extend(more_curves(last, labels));
    let (high, foot) = (128.0, 44.0);
    let height = all.len() as f64 * (high + 22.0) + foot;
    let mut svg = Svg::new(
        &format!("section{index}-s"),
        "Section forces over s",
        width,
        height,
    );
    let order: Vec<&Station> = rows(last).concat();
    let ways: Vec<f64> = order.iter().map(|s| s.s).collect();
    for (k, curve) in all.iter().enumerate() {
        let of = |section: &SectionSolution| -> Vec<Vec<f64>> {
            let value = quiet(section, curve.value, curve.name);
            let row = |row: &Vec<&Station>| row.iter().map(|s| value(s)).collect();
            rows(section).iter().map(row).collect()
        };
        let mut values: Vec<Vec<f64>> = steps.iter().flat_map(|step| of(step)).collect();
        let envelope = values.len() > 1;
        values.extend(of(last));
        let now = &values[values.len() - 1];
        let bound = |choose: fn(f64, f64) -> f64| -> Vec<f64> {
            (0..now.len())
                .map(|i| {
                    values
                        .iter()
                        .filter_map(|v| v.get(i))
                        .fold(f64::NAN, |m, v| choose(m, *v))
                })
                .collect()
        };
        let (least, most) = (bound(f64::min), bound(f64::max));
        let shown: Vec<f64> = values
            .concat()
            .into_iter()
            .filter(|v| v.is_finite())
            .collect();
        let top = 12.0 + k as f64 * (high + 22.0);
        let frame = Frame {
            corner: [92.0, top],
            size: [width - 112.0, high],
            x: Axis::linear("s", &labels.length, &ways, false, ticks(width)).roomy(),
            y: Axis::linear(curve.name, &curve.unit, &shown, true, 4).widened(0.12),
        };
        if envelope {
            let upper = ways.iter().zip(&most).map(|(&s, &v)| frame.at(s, v));
            let lower = ways.iter().zip(&least).map(|(&s, &v)| frame.at(s, v));
            let around: Vec<Pixel> = upper.chain(lower.rev()).collect();
            svg.polygon(&around, SHADE);
        }
        frame.draw(&mut svg, k + 1 == all.len());
        let zero: Vec<Pixel> = [ways.first(), ways.last()]
            .into_iter()
            .flatten()
            .map(|&s| frame.at(s, 0.0))
            .collect();
        svg.path(&segments(&zero, false), MUTED, 0.9, "none", "");
        let points: Vec<[f64; 2]> = ways.iter().zip(now).map(|(&s, &v)| [s, v]).collect();
        frame.curve(&mut svg, &points, SERIES[1], 1.8);
        if points.len() <= MOST_LINES {
            for (p, station) in points.iter().zip(&order).filter(|(p, _)| p[1].is_finite()) {
                let hint = format!(
                    "s = {}, {}: {} = {}",
                    number(p[0]),
                    vector(&station.coordinates(), ""),
                    curve.name,
                    number(p[1])
                );
                svg.circle(frame.at(p[0], p[1]), 2.2, SERIES[1], "#fff", &hint);
            }
        }
        if curve.name == "utilisation" && frame.y.range[1] > 1.0 {
            frame.level(&mut svg, 1.0, SERIES[0]);
        }
        // the extremes of all steps, with their values
        let place = |bounds: &[f64], sign: f64| {
            let finite = (0..bounds.len()).filter(|&i| bounds[i].is_finite());
            finite.reduce(|best, i| {
                if sign * bounds[i] > sign * bounds[best] {
                    i
                } else {
                    best
                }
            })
        };
        let mut marks: Vec<(usize, f64)> = place(&most, 1.0)
            .map(|i| (i, most[i]))
            .into_iter()
            .collect();
        let span = frame.y.range[1] - frame.y.range[0];
        marks.extend(
            place(&least, -1.0)
                .map(|i| (i, least[i]))
                .filter(|m| marks.iter().all(|o| (o.1 - m.1).abs() > 0.02 * span)),
        );
        for (upper, (i, value)) in marks.into_iter().enumerate() {
            let [x, y] = frame.at(ways[i], value);
            let label = number(value);
            let half = 0.5 * text_width(&label, Type::SMALL.size);
            let x = x.clamp(
                frame.corner[0] + half + 2.0,
                frame.corner[0] + frame.size[0] - half - 2.0,
            );
            let y = if upper == 0 { y - 5.0 } else { y + 13.0 };
            let y = y.clamp(top + 10.0, top + high - 3.0);
            svg.text([x, y], &label, Type::SMALL.bold().rimmed());
        }
    }
    svg.finish()
}

/// Most pixels of a map.
const PIXELS: [usize; 2] = [240, 80];

/// Colours of N, V, M and the others over s and along the axis, one above the other.
fn maps(section: &SectionSolution, index: usize, labels: &Labels, width: f64) -> Markup {
    let Some(extrusion) = &section.extrusion else {
        return Markup::default();
    };
    let mut all: Vec<Curve> = curves(labels).into();
    all.extend(more_curves(section, labels));
    let (high, foot) = (110.0, 44.0);
    let height = all.len() as f64 * (high + 26.0) + foot;
    let mut svg = Svg::new(
        &format!("section{index}-along"),
        "Section forces along the axis",
        width,
        height,
    );
    let rows = rows(section);
    let ways: Vec<f64> = rows[0].iter().map(|s| s.s).collect();
    let places = [0.0, extrusion.length];
    for (k, curve) in all.iter().enumerate() {
        let value = quiet(section, curve.value, curve.name);
        let values: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| row.iter().map(|s| value(s)).collect())
            .collect();
        let axis = Axis::linear(curve.name, &curve.unit, &values.concat(), false, 4);
        let top = 22.0 + k as f64 * (high + 26.0);
        let frame = Frame {
            corner: [72.0, top],
            size: [width - 84.0 - BAR, high],
            x: Axis::linear("s", &labels.length, &ways, false, ticks(width)).roomy(),
            y: Axis::linear("along", &labels.length, &places, false, 3),
        };
        frame.draw(&mut svg, k + 1 == all.len());
        let (first, last) = (ways[0], ways[ways.len() - 1]);
        let corner = frame.at(first, extrusion.length);
        let end = frame.at(last, 0.0);
        let picture = raster(&ways, &values, &axis);
        svg.picture(corner, [end[0] - corner[0], end[1] - corner[1]], &picture);
        let style = Type::SMALL.anchored(Anchor::Start).bold();
        svg.text([frame.corner[0], top - 8.0], &axis.label, style);
        colour_bar(&mut svg, [width - BAR + 4.0, top], high, &axis, false);
    }
    svg.finish()
}

/// A picture of values between stations and between places, the last place on top.
fn raster(ways: &[f64], values: &[Vec<f64>], axis: &Axis) -> Vec<u8> {
    let [across, up] = PIXELS;
    let (first, last) = (ways[0], ways[ways.len() - 1]);
    let mut indices = Vec::with_capacity(across * up);
    for j in 0..up {
        let place = (1.0 - (j as f64 + 0.5) / up as f64) * (values.len() - 1) as f64;
        let below = (place as usize).min(values.len() - 2);
        let part = place - below as f64;
        for i in 0..across {
            let s = first + (i as f64 + 0.5) / across as f64 * (last - first);
            let next = ways
                .partition_point(|way| *way <= s)
                .clamp(1, (ways.len() - 1).max(1));
            let before = next - 1;
            let next = next.min(ways.len() - 1);
            let step = ways[next] - ways[before];
            let ahead = if step > 0.0 {
                (s - ways[before]) / step
            } else {
                0.0
            };
            let along = |row: &[f64]| row[before] + ahead * (row[next] - row[before]);
            let value = (1.0 - part) * along(&values[below]) + part * along(&values[below + 1]);
            // 0 is transparent: nothing is there
            let shown = value
                .is_finite()
                .then(|| colour::index(axis.fraction(value)));
            indices.push(shown.unwrap_or(0));
        }
    }
    png(across, up, &indices, &colour::palette())
}

/// The limit curves of the thinnest and the thickest cut, and the forces of all stations and steps.
fn interaction(
    capacity: &Capacity,
    steps: &[&SectionSolution],
    index: usize,
    labels: &Labels,
    width: f64,
) -> Markup {
    let stations = || steps.iter().flat_map(|step| &step.stations);
    let (thin, thick) = stations().fold((f64::INFINITY, 0.0_f64), |(a, b), s| {
        (a.min(s.thickness), b.max(s.thickness))
    });
    let mut thicknesses = vec![thin];
    if thick > thin * 1.001 {
        thicknesses.push(thick);
    }
    let limits: Vec<Vec<[f64; 2]>> = thicknesses
        .iter()
        .map(|&h| capacity.curve(h, LIMIT_POINTS))
        .collect();
    let all = || {
        let forces = stations()
            .map(|s| [s.normal, s.moment])
            .filter(|p| p.iter().all(|c| c.is_finite()));
        limits.iter().flatten().copied().chain(forces)
    };
    let side = |i: usize| -> Vec<f64> { all().map(|p| p[i]).collect() };
    let mut svg = Svg::new(
        &format!("section{index}-limit"),
        "Normal force and moment within the limit",
        width,
        380.0,
    );
    let frame = Frame {
        corner: [100.0, 14.0],
        size: [width - 130.0, 316.0],
        x: Axis::linear("N", &labels.per_length, &side(0), true, ticks(width)).roomy(),
        y: Axis::linear("M", &labels.moment_per_length, &side(1), true, 7).widened(0.06),
    };
    for (limit, fill) in limits.iter().zip(["#eef4ee", "none"]) {
        let pixels: Vec<Pixel> = limit.iter().map(|p| frame.at(p[0], p[1])).collect();
        svg.path(&segments(&pixels, true), "none", 0.0, fill, "");
    }
    frame.draw(&mut svg, true);
    let mut axes = |a: [f64; 2], b: [f64; 2]| {
        svg.path(
            &segments(&[frame.at(a[0], a[1]), frame.at(b[0], b[1])], false),
            MUTED,
            0.9,
            "none",
            "",
        )
    };
    axes([frame.x.range[0], 0.0], [frame.x.range[1], 0.0]);
    axes([0.0, frame.y.range[0]], [0.0, frame.y.range[1]]);
    for (k, limit) in limits.iter().enumerate() {
        let mut points = limit.clone();
        points.extend(limit.first());
        let colour = [SERIES[2], SERIES[4]][k];
        frame.curve(&mut svg, &points, colour, 1.8);
        let at = [
            frame.corner[0] + 12.0,
            frame.corner[1] + 18.0 + 16.0 * k as f64,
        ];
        let label = format!(
            "limit, thickness {}",
            quantity(thicknesses[k], &labels.length)
        );
        svg.text(
            at,
            &label,
            Type::LABEL
                .anchored(Anchor::Start)
                .coloured(colour)
                .rimmed(),
        );
    }
    let earlier = steps.len() - 1;
    let many = stations().count() > MOST_POINTS;
    for (k, step) in steps
        .iter()
        .enumerate()
        .filter(|(k, _)| *k == earlier || !many)
    {
        let colour = if k == earlier { SERIES[1] } else { "#a9b6c2" };
        for station in step.stations.iter().filter(|s| s.normal.is_finite()) {
            let used = station
                .utilisation
                .map_or(String::new(), |u| format!(", utilisation {}", number(u)));
            let hint = format!(
                "N = {}, M = {} at {}{used}",
                number(station.normal),
                number(station.moment),
                vector(&station.coordinates(), "")
            );
            svg.circle(
                frame.at(station.normal, station.moment),
                2.4,
                colour,
                colour,
                &hint,
            );
        }
    }
    svg.finish()
}

/// The limit in words.
fn limit_in_words(capacity: &Capacity, several: bool, labels: &Labels) -> String {
    let mut strengths = format!(
        "Compressive strength {}, tensile strength {}",
        quantity(capacity.compression, &labels.stress),
        quantity(capacity.tension, &labels.stress)
    );
    if !capacity.reinforcement.is_empty() {
        strengths += &format!(", {} layers of bars", count(capacity.reinforcement.len()));
    }
    let grey = if several {
        " Grey: earlier load steps."
    } else {
        ""
    };
    format!(
        "{strengths}. Limit by strain compatibility with rectangular stress blocks (form of EN 1992-1-1, 3.1.7 and 6.1; without bars \
         12.6.1): block over 0.8 of the depth of the neutral axis, crushing strain 0.0035. Dots: the stations.{grey} The \
         utilisation is 1 over the factor that takes N and M to the limit together."
    )
}

/// The extremes over all stations and steps, each with the other forces there; σ are the stresses of the two sides.
fn extremes((numbers, steps): (&[usize], &[&SectionSolution]), labels: &Labels) -> Markup {
    let across = steps.first().map(|first| curves_across(first, labels));
    let across = across.unwrap_or_default();
    let mut rows = Vec::new();
    for quantity in SectionQuantity::ALL {
        let found = steps
            .iter()
            .enumerate()
            .filter_map(|(k, step)| Some((k, step.extremes(quantity)?)));
        let most = found
            .clone()
            .reduce(|a, b| if b.1[1].1 > a.1[1].1 { b } else { a });
        let least = found.reduce(|a, b| if b.1[0].1 < a.1[0].1 { b } else { a });
        let ends = [
            ("max", most.map(|f| (f.0, f.1[1]))),
            ("min", least.map(|f| (f.0, f.1[0]))),
        ];
        for (word, found) in ends {
            let Some((step, (station, _))) = found else {
                continue;
            };
            if quantity == SectionQuantity::Utilisation && word == "min" {
                continue;
            }
            let (section, place) = (steps[step], &steps[step].stations[station]);
            // forces that are rounding give no stress
            let heard = |curve: &Curve| quiet(section, curve.value, curve.name)(place);
            let [normal, _, moment] = curves(labels).each_ref().map(heard);
            let [first, second] = Station {
                normal,
                moment,
                ..*place
            }
            .edge_stress();
            let mut row = vec![text(&format!("{word} {}", quantity.name()))];
            row.extend((steps.len() > 1).then(|| plain(count(numbers[step]))));
            row.extend([
                plain(count(station + 1)),
                plain(number(place.s)),
                plain(vector(&place.coordinates(), "")),
            ]);
            let own = curves(labels);
            let shown = own.iter().chain(&across);
            row.extend(shown.map(|curve| plain(number(heard(curve)))));
            row.extend([first, second].map(|stress| plain(number(stress))));
            row.extend(place.utilisation.map(|u| {
                plain(if u.is_finite() {
                    number(u)
                } else {
                    "∞".to_string()
                })
            }));
            rows.push(row);
        }
    }
    let mut heads = vec![left("extreme")];
    heads.extend((steps.len() > 1).then(|| column("step", "")));
    heads.extend([
        column("station", ""),
        column("s", &labels.length),
        column("at", &labels.length),
    ]);
    let own = curves(labels);
    let shown = own.iter().chain(&across);
    heads.extend(shown.map(|curve| column(curve.name, &curve.unit)));
    heads.extend(["first", "second"].map(|name| column(&format!("σ {name}"), &labels.stress)));
    let used = steps
        .iter()
        .flat_map(|s| &s.stations)
        .any(|s| s.utilisation.is_some());
    heads.extend(used.then(|| column("utilisation", "")));
    table_of_vectors(&heads, rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{BodyId, Reinforcement, Stations};
    use crate::output::tunnel;

    #[test]
    fn a_section_has_its_diagrams_its_limit_and_its_extremes() {
        let (mut model, _) = tunnel::solved();
        let section = model.section("wall", BodyId(0), ["inner", "outer"], Stations::Number(9));
        section.capacity = Some(Capacity {
            compression: 30.0,
            tension: 0.0,
            reinforcement: vec![Reinforcement {
                depth: 0.05,
                area: 1e-3,
                yields: 435.0,
                young: None,
            }],
        });
        let solution = model.solve().unwrap();
        let labels = Labels::of(&model);
        let page = sections_section(&tunnel::run(&model, &solution), &labels);
        assert_eq!(page.matches("<figure>").count(), 3);
        for words in [
            "ring between inner (first) and outer, 9 stations",
            "N [MN/m]",
            "utilisation",
            "max M",
            "12.6.1",
        ] {
            assert!(page.contains(words), "{words}");
        }
        assert!(!page.contains("shaded"), "one step has no envelope");
        let earlier = [solution.clone()];
        let run = Overview {
            earlier: &earlier,
            ..tunnel::run(&model, &solution)
        };
        assert!(
            sections_section(&run, &labels)
                .contains("shaded: between the least and the largest value of all 2 steps")
        );
        let none = tunnel::solved();
        assert!(sections_section(&tunnel::run(&none.0, &none.1), &labels).is_empty());
    }
}
