//! `report.html` and `check.html`: one self-contained page each, which needs no network. In space one figure, a view that turns, brings its script.
//!
//! Numbers are rounded to four significant digits; the full ones are in the other files. The page carries no date: the
//! same solution gives the same bytes, but for the block of timings.

use crate::geometry::Point;
use crate::model::{Analysis, BodySolution, ContactSolution, Dimension, Model, Solution, Status};
use crate::output::beds::beds_section;
use crate::output::figures::Figures;
use crate::output::html::{self, Head, column, left, plain, table, table_of_vectors, text};
use crate::output::interface::largest_gap;
use crate::output::json::{VERSION, largest, range};
use crate::output::lines::{lines_section, place_in_words};
use crate::output::markup::{Markup, markup};
use crate::output::members::member_sections;
use crate::output::sections::sections_section;
use crate::output::steps::steps_section;
use crate::output::strength::strength_section;
use crate::output::text::{
    Labels, Scales, count, number, quantity, seconds, singular_peak, vector,
};
use crate::output::utilisation::largest_utilisation;
use crate::output::yielding::yielding_section;
use crate::output::{Overview, contacts, csv, verdict};

/// Content of `report.html`.
pub fn page<const D: usize>(run: &Overview<'_, D>) -> Markup {
    let (model, solution) = (run.stage(), run.last);
    let lines = solution.probes.iter().any(|p| !p.line.is_empty());
    let files = [
        (lines, ", lines.csv"),
        (!solution.sections.is_empty(), ", sections.csv"),
        (!solution.beds.is_empty(), ", beds.csv"),
    ];
    let files = files.iter().filter(|(there, _)| *there);
    let files = files.map(|(_, name)| name.to_string());
    let members = solution.members_by_kind();
    let files = files.chain(members.map(|(kind, _)| format!(", {}", csv::members_file(&kind))));
    let footer = format!(
        "Computed with dotyk {VERSION}, case {}. Full numbers: summary.json, contact.csv{}; fields: case.pvd.",
        run.stem,
        files.collect::<String>()
    );
    framed(model, run.stem, &content(run), &footer)
}

/// The figures of `report.html` in their order: title and `<figure>` of each.
pub fn figures<const D: usize>(run: &Overview<'_, D>) -> Vec<(String, String)> {
    content(run).figures()
}

/// The content between head and footer of `report.html`.
fn content<const D: usize>(run: &Overview<'_, D>) -> Markup {
    let (model, solution) = (run.stage(), run.last);
    let labels = Labels::of(model);
    let figures = Figures::of(model);
    let nodes = solution.contacts.iter().flat_map(|c| &c.nodes);
    let alone: Vec<Point<D>> = nodes.filter(|n| n.gap.is_nan()).map(|n| n.point).collect();
    let steps: Vec<&Solution<D>> = run.steps().collect();
    // what was computed comes before its numbers, and these before what they rest on
    [
        verdict::banner(run),
        verdict::warnings(run),
        key_figures(model, solution, &labels),
        markup!("<h2>Model</h2>\n"),
        figures.model(&alone),
        markup!("<h2>Deformation and stress</h2>\n"),
        figures.deformed(solution),
        figures.trough(&steps),
        probes(model, solution, &labels),
        lines_section(run, &labels),
        sections_section(run, &labels),
        beds_section(solution, &labels),
        member_sections(run, &labels),
        steps_section(run, &labels),
        strength_section(solution, &figures, &labels),
        yielding_section(solution, &figures, &labels),
        contacts::contacts(solution, &figures, &labels),
        bodies(model, solution, &labels),
        points(solution, &labels),
        contacts::balance(model, solution, &labels),
        verdict::certificate(solution, &labels),
        verdict::solver(model, solution, &labels),
        contacts::contact_nodes(solution, &labels),
        timings(run),
    ]
    .into_iter()
    .collect()
}

/// Content of `check.html`; `text` are the findings of the check, line by line, and `alone` the contact nodes without an opposite
/// side.
pub fn check_page<const D: usize>(
    model: &Model<D>,
    text: &str,
    alone: &[Point<D>],
    stem: &str,
) -> Markup {
    let body = markup!(
        "<h2>Mesh, supports and loads</h2>\n{}<h2>Findings</h2>\n<pre>{}</pre>\n",
        Figures::of(model).model(alone),
        text
    );
    let footer = format!("Checked with dotyk {VERSION}. Nothing has been solved.");
    framed(model, stem, &body, &footer)
}

/// A page with the title, the source and the analysis of a model.
fn framed<const D: usize>(model: &Model<D>, stem: &str, body: &Markup, footer: &str) -> Markup {
    let title = match model.title.as_str() {
        "" => stem,
        title => title,
    };
    let case = format!("Case {stem} · {}", analysis_in_words(model));
    let parameters = model.parameters.iter();
    let parameters = parameters.map(|(name, value)| format!("{name} = {}", number(*value)));
    let parameters = match parameters.collect::<Vec<_>>().join(", ") {
        list if list.is_empty() => list,
        list => format!("Parameters {list}"),
    };
    let lines = [model.source.as_str(), &case, &parameters];
    let intro = lines.iter().filter(|line| !line.is_empty());
    let intro = intro.map(|line| markup!("<p class=\"source\">{}</p>\n", line));
    html::page(title, &intro.collect(), body, footer)
}

fn analysis_in_words<const D: usize>(model: &Model<D>) -> String {
    let length = model.units.length.as_deref().unwrap_or("");
    let plane = |name: &str| {
        let first = model.bodies.first().map_or(1.0, |b| b.thickness);
        if model.bodies.iter().all(|b| b.thickness == first) {
            format!("{name}, thickness {}", quantity(first, length))
        } else {
            format!("{name}, thickness by body")
        }
    };
    match model.analysis {
        Analysis::PlaneStrain => plane("plane strain"),
        Analysis::PlaneStress => plane("plane stress"),
        Analysis::Axisymmetric => "axisymmetric, forces for the full turn".to_string(),
        Analysis::Solid => "three-dimensional".to_string(),
    }
}

fn key_figures<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    labels: &Labels,
) -> Markup {
    let mut cards: Vec<(&str, String, String)> = Vec::new();
    let scales = Scales::of(solution);
    let as_stress = |value: f64| {
        let value = scales.without_noise(value, Dimension::Stress);
        quantity(value, &labels.stress)
    };
    if let Some((body, value)) = greatest(&solution.bodies, BodySolution::max_displacement) {
        cards.push((
            "Largest displacement",
            quantity(value, &labels.length),
            body,
        ));
    }
    let stress = |b: &BodySolution<D>| largest(b.von_mises.iter().copied());
    if let Some((mut body, value)) = greatest(&solution.bodies, stress) {
        let peaks = solution.bodies.iter().filter_map(|b| b.peak);
        let most = peaks.max_by(|a, b| a.most.value.total_cmp(&b.most.value));
        if let Some(singular) = most.and_then(|peak| peak.place) {
            body += &format!(", at {}", singular.place);
        }
        cards.push(("Largest von Mises stress", as_stress(value), body));
    }
    if let Some((body, peak)) = largest_utilisation(solution) {
        let place = peak
            .place
            .map(|singular| format!(", at {}", singular.place));
        cards.push((
            "Largest utilisation",
            number(peak.most.value),
            format!("in {body}{}", place.unwrap_or_default()),
        ));
    }
    if !solution.contacts.is_empty() {
        let peak = |c: &ContactSolution<D>| largest(c.nodes.iter().map(|n| n.pressure));
        let name = solution
            .contacts
            .iter()
            .max_by(|a, b| peak(a).total_cmp(&peak(b)))
            .map_or(String::new(), |c| c.name.clone());
        cards.push((
            "Largest contact pressure",
            as_stress(largest(solution.contacts.iter().map(peak))),
            name,
        ));
        // ties do not count as contacts, unless there are no others
        let loose = |c: &&ContactSolution<D>| c.nodes.iter().all(|n| n.status != Status::Tied);
        let any = solution.contacts.iter().any(|c| loose(&c));
        let counted = || solution.contacts.iter().filter(|c| !any || loose(c));
        let whole: f64 = counted().map(|contact| side_extent(model, contact)).sum();
        let closed: f64 = counted().map(|c| c.length).sum();
        let (_, unit) = labels.extent();
        cards.push((
            labels.in_contact(),
            quantity(closed, unit),
            format!("of {}", quantity(whole, unit)),
        ));
        let gap = largest(solution.contacts.iter().map(|c| largest_gap(&c.nodes)));
        cards.push((
            "Largest gap",
            quantity(gap, &labels.length),
            "after deformation".to_string(),
        ));
    }
    let energy: f64 = solution.bodies.iter().map(|b| b.strain_energy).sum();
    cards.push((
        "Elastic energy",
        quantity(energy, &labels.energy),
        "all bodies".to_string(),
    ));
    cards.push((
        "Unknowns",
        count(solution.dofs),
        format!(
            "displacements; {} contact forces",
            count(solution.contact_unknowns)
        ),
    ));
    let plural = if solution.solver.iterations == 1 {
        "iteration"
    } else {
        "iterations"
    };
    cards.push((
        "Contact solver",
        solution.solver.method.to_string(),
        format!("{} {plural}", count(solution.solver.iterations)),
    ));
    let cards: Markup = cards
        .iter()
        .map(|(name, value, note)| {
            markup!(
                "<div><span>{}</span><strong>{}</strong><span>{}</span></div>\n",
                name,
                value,
                note
            )
        })
        .collect();
    markup!("<div class=\"keys\">\n{}</div>\n", cards)
}

/// Length of the whole nonmortar side, in space the area of the part that faces the other side, undeformed.
fn side_extent<const D: usize>(model: &Model<D>, contact: &ContactSolution<D>) -> f64 {
    if D == 3 {
        return contact.nodes.iter().map(|n| n.weight).sum();
    }
    let mesh = &model.bodies[contact.nonmortar.body.0].mesh;
    let facets = mesh.side(&contact.nonmortar.side).unwrap_or_default();
    facets.iter().map(|&facet| mesh.facet_length(facet)).sum()
}

/// Name and value of the body where a number is largest.
fn greatest<const D: usize>(
    bodies: &[BodySolution<D>],
    of: impl Fn(&BodySolution<D>) -> f64,
) -> Option<(String, f64)> {
    bodies
        .iter()
        .map(|b| (b.name.clone(), of(b)))
        .filter(|(_, v)| !v.is_nan())
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(name, value)| (format!("in {name}"), value))
}

fn probes<const D: usize>(model: &Model<D>, solution: &Solution<D>, labels: &Labels) -> Markup {
    if solution.probes.is_empty() {
        return Markup::default();
    }
    let scales = Scales::of(solution);
    let rows = solution
        .probes
        .iter()
        .map(|p| {
            let quiet = |value: f64| scales.without_noise(value, p.dimension);
            let asked = model.probes.iter().find(|m| m.name == p.name);
            let point = asked.and_then(|m| m.reading.point());
            let point = point.map(|at| vector(&at, ""));
            let point = point.or(p.at.map(|at| scales.place(&at[..D])));
            let coupled = asked.and_then(|m| m.coupled(model)).map(|c| c.name.clone());
            let at = coupled
                .or(point)
                .unwrap_or_else(|| place_in_words(model, p));
            let unit = labels.unit(p.dimension);
            let value = match p.line.is_empty() {
                true => quantity(quiet(p.value), unit),
                false => {
                    let [low, high] = range(p.line.iter().map(|place| place.value));
                    format!("{} … {}", number(quiet(low)), quantity(quiet(high), unit))
                }
            };
            vec![text(&p.name), text(&p.quantity), plain(at), plain(value)]
        })
        .collect();
    let at = column("at", &labels.length);
    markup!(
        "<h2>Results asked for</h2>\n{}",
        table(
            &[left("probe"), left("quantity"), at, column("value", "")],
            rows
        )
    )
}

fn bodies<const D: usize>(model: &Model<D>, solution: &Solution<D>, labels: &Labels) -> Markup {
    let scales = Scales::of(solution);
    let rows = model
        .bodies
        .iter()
        .zip(&solution.bodies)
        .map(|(body, b)| {
            let cells: usize = body.mesh.blocks().iter().map(|k| k.cells().len()).sum();
            vec![
                text(&b.name),
                plain(count(cells)),
                plain(count(b.dofs)),
                plain(number(b.max_displacement())),
                plain(number(scales.without_noise(
                    largest(b.von_mises.iter().copied()),
                    Dimension::Stress,
                ))),
                plain(
                    b.peak
                        .map_or("–".to_string(), |peak| vector(&peak.most.at, "")),
                ),
                plain(number(b.strain_energy)),
            ]
        })
        .collect();
    let heads = [
        left("body"),
        column("cells", ""),
        column("unknowns", ""),
        column("largest displacement", &labels.length),
        column("largest von Mises", &labels.stress),
        column("at", &labels.length),
        column("elastic energy", &labels.energy),
    ];
    let mut out = markup!("<h2>Bodies</h2>\n{}", table(&heads, rows));
    let told = solution.bodies.iter().filter_map(|b| {
        let what = format!("von Mises stress of {}", b.name);
        singular_peak(&what, b.peak, [&labels.stress, &labels.length])
    });
    out += told.map(|line| markup!("<p>{}</p>\n", line)).collect();
    let rows = solution
        .bodies
        .iter()
        .map(|b| {
            let held = if b.floating_modes.is_empty() {
                "held by its supports".to_string()
            } else {
                format!("{} held by contact alone", b.floating())
            };
            vec![
                text(&b.name),
                plain(vector(&b.rigid.translation, "")),
                plain(turned(&b.rigid.rotation)),
                text(&held),
            ]
        })
        .collect();
    let heads = [
        left("body"),
        column("rigid translation", &labels.length),
        column("rotation", "rad"),
        left("rigid motions"),
    ];
    out + markup!(
        "<h3>Rigid motion</h3>\n<p>The rigid motion that comes closest to the displacements of the nodes, about their \
         centroid.</p>\n{}",
        table_of_vectors(&heads, rows)
    )
}

/// A rotation or moment: a number in the plane, in space one about each axis.
fn turned(values: &[f64]) -> String {
    match values {
        [one] => number(*one),
        all => vector(all, ""),
    }
}

/// The points of couples; empty without couples.
fn points<const D: usize>(solution: &Solution<D>, labels: &Labels) -> Markup {
    let scales = Scales::of(solution);
    let shown = |values: &[f64], dimension: Dimension| {
        let values: Vec<f64> = values
            .iter()
            .map(|&value| scales.without_noise(value, dimension))
            .collect();
        plain(vector(&values, ""))
    };
    let couples = solution.bodies.iter();
    let couples = couples.flat_map(|body| body.couples.iter().map(move |couple| (body, couple)));
    let rows: Vec<_> = couples
        .map(|(body, couple)| {
            vec![
                text(&format!("{}.{}", body.name, couple.name)),
                text(couple.kind.name()),
                shown(&couple.displacement, Dimension::Length),
                plain(turned(&couple.rotation)),
                shown(&couple.force, Dimension::Force),
                plain(turned(
                    &couple
                        .moment
                        .iter()
                        .map(|&moment| scales.without_noise(moment, Dimension::Force))
                        .collect::<Vec<_>>(),
                )),
            ]
        })
        .collect();
    if rows.is_empty() {
        return Markup::default();
    }
    let heads = [
        left("point"),
        left("couple"),
        column("displacement", &labels.length),
        column("rotation", "rad"),
        column("force on the body", &labels.force),
        column("moment on the body", &labels.energy),
    ];
    markup!(
        "<h3>Coupled points</h3>\n{}",
        table_of_vectors(&heads, rows)
    )
}

fn timings<const D: usize>(run: &Overview<'_, D>) -> Markup {
    let (s, threads) = (run.seconds, run.last.threads);
    let stages = [
        ("read", s.read),
        ("assemble", s.assemble),
        ("order", s.order),
        ("factor", s.factor),
        ("condense", s.condense),
        ("contact", s.contact),
        ("recover", s.recover),
        ("write", s.write),
        ("total", s.total),
    ];
    let heads: Vec<Head> = stages.iter().map(|(name, _)| column(name, "")).collect();
    let row = stages
        .iter()
        .map(|(_, value)| plain(seconds(*value)))
        .collect();
    markup!(
        "<h2>Effort</h2>\n{}<p>{} {}, largest memory {} MB.</p>\n",
        table(&heads, vec![row]),
        threads,
        if threads == 1 { "thread" } else { "threads" },
        count((run.peak_memory as f64 / 1e6).round() as usize)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::Figure;
    use crate::output::tunnel;

    #[test]
    fn page_needs_no_network_and_no_script() {
        let (model, mut solution) = tunnel::solved();
        let warning = "3 nodes of side \"outer\" face nothing & stay open";
        solution.warnings.push(warning.to_string());
        let page = page(&tunnel::run(&model, &solution));
        let outside = page.replace("http://www.w3.org/2000/svg", "");
        for word in [
            "http://", "https://", "//cdn", "@import", "<script", "<link",
        ] {
            assert!(!outside.contains(word), "{word}");
        }
        assert!(
            page.contains("✓ Certified") && page.contains("Lined tunnel under uneven pressure")
        );
        // Text of the user is escaped.
        assert!(page.contains("&quot;outer&quot; face nothing &amp; stay open"));
    }

    #[test]
    fn same_solution_gives_the_same_bytes() {
        let (model, solution) = tunnel::solved();
        let once = page(&tunnel::run(&model, &solution));
        assert!(once == page(&tunnel::run(&model, &solution)));
    }

    #[test]
    fn a_failed_certificate_is_said_in_the_banner() {
        let (model, mut solution) = tunnel::solved();
        solution.converged = false;
        solution.certificate.energy_gap = Figure::new(0.1, 1.0, 1e-8);
        let page = page(&tunnel::run(&model, &solution));
        assert!(page.contains("✗ Not converged") && page.contains("energy gap (relative 10⁻¹"));
        assert!(!page.contains("✓ Certified"));
    }

    #[test]
    fn a_model_without_contact_still_has_a_page() {
        let (mut model, mut solution) = tunnel::solved();
        model.contacts.clear();
        solution.contacts.clear();
        solution.solver.history.clear();
        let page = page(&tunnel::run(&model, &solution));
        assert!(page.contains("Reactions and balance") && !page.contains("Contact nodes"));
    }

    #[test]
    fn check_page_shows_the_findings() {
        let (model, _) = tunnel::solved();
        let page = check_page(&model, "ring: <held> by contact", &[], "case_1");
        assert!(page.contains("ring: &lt;held&gt; by contact") && page.contains("<svg"));
    }
}
