//! `report.html` and `check.html`: one self-contained page each, which needs no network and no script.
//!
//! Numbers are rounded to four significant digits; the full ones are in the other files. The page carries no date: the
//! same solution gives the same bytes, but for the block of timings.

use crate::dual::{Certificate, Figure};
use crate::geometry::{Point, add_scaled, norm};
use crate::model::{Analysis, BodySolution, ContactSolution, Model, Solution};
use crate::output::Run;
use crate::output::deformed::deformed_figure;
use crate::output::history::history_figure;
use crate::output::interface::{arc_lengths, interface_figure, largest_gap};
use crate::output::json::{
    VERSION, closed_and_open, in_contact, largest, max_displacement, max_penetration,
};
use crate::output::scene::Scene;
use crate::output::setup::setup_figure;
use crate::output::steps::steps_section;
use crate::output::text::{
    Labels, count, escape, number, power, quantity, seconds, vector, vector_on, without_noise,
};

/// More contact nodes than this are left to `contact.csv`.
const MOST_ROWS: usize = 600;

/// Content of `report.html`.
pub fn page(run: &Run<'_>) -> String {
    let (model, solution) = (run.model, run.last);
    let labels = Labels::of(model);
    let scene = Scene::new(model);
    let mut out = head(model, run.stem);
    out += &banner(run);
    out += &warnings(&all_warnings(run));
    out += &key_figures(solution, &labels);
    out += &probes(model, solution, &labels);
    out += &steps_section(run, &labels);
    out += "<h2>Model</h2>\n";
    let nodes = solution.contacts.iter().flat_map(|c| &c.nodes);
    let alone: Vec<Point<2>> = nodes.filter(|n| n.gap.is_nan()).map(|n| n.point).collect();
    out += &figure(
        &setup_figure(&scene, &alone),
        "Mesh, supports and loads",
        &mesh_caption(model),
    );
    out += "<h2>Deformation and stress</h2>\n";
    let (svg, caption) = deformed_figure(&scene, solution);
    let more = " Dashed: undeformed outline. Colour: von Mises stress, recovered at the nodes.";
    out += &figure(&svg, "Deformed shape", &format!("{caption}{more}"));
    out += &bodies(model, solution, &labels);
    out += &contacts(model, solution, &scene, &labels);
    out += &balance(model, solution, &labels);
    out += &certificate(solution, &labels);
    out += &solver(model, solution, &labels);
    out += &contact_nodes(solution, &labels);
    out += &timings(run);
    out += &foot(run.stem);
    out
}

/// Warnings of all steps, each once.
fn all_warnings(run: &Run<'_>) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for warning in run.steps().flat_map(|step| &step.warnings) {
        if !list.contains(warning) {
            list.push(warning.clone());
        }
    }
    list
}

/// Content of `check.html`; `text` is what the check found, line by line, and `alone` the contact nodes that face nothing.
pub fn check_page(model: &Model<2>, text: &str, alone: &[Point<2>], stem: &str) -> String {
    let scene = Scene::new(model);
    let mut out = head(model, stem);
    out += "<h2>Mesh, supports and loads</h2>\n";
    out += &figure(
        &setup_figure(&scene, alone),
        "Mesh, supports and loads",
        &mesh_caption(model),
    );
    out += &format!("<h2>Findings</h2>\n<pre>{}</pre>\n", escape(text));
    out += &format!(
        "<footer>Checked with dotyk {VERSION}. Nothing has been solved.</footer>\n</main>\n</body>\n</html>\n"
    );
    out
}

fn head(model: &Model<2>, stem: &str) -> String {
    let title = if model.title.is_empty() {
        stem
    } else {
        &model.title
    };
    let source = if model.source.is_empty() {
        String::new()
    } else {
        format!("<p class=\"source\">{}</p>\n", escape(&model.source))
    };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{css}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{source}\
         <p class=\"source\">Case {stem} · {analysis}</p>\n",
        title = escape(title),
        css = include_str!("report.css"),
        stem = escape(stem),
        analysis = escape(&analysis_in_words(model)),
    )
}

fn analysis_in_words(model: &Model<2>) -> String {
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

fn mesh_caption(model: &Model<2>) -> String {
    let cells: usize = model
        .bodies
        .iter()
        .flat_map(|b| b.mesh.blocks())
        .map(|b| b.cells().len())
        .sum();
    let nodes: usize = model.bodies.iter().map(|b| b.mesh.points().len()).sum();
    format!(
        "{} cells, {} nodes. Cells narrower than two pixels are drawn without their edges. Arrows of one load are to scale among \
         themselves.",
        count(cells),
        count(nodes)
    )
}

pub fn figure(svg: &str, title: &str, caption: &str) -> String {
    format!(
        "<figure>\n{svg}<figcaption><b>{}.</b> {}</figcaption>\n</figure>\n",
        escape(title),
        escape(caption)
    )
}

fn banner(run: &Run<'_>) -> String {
    let solution = run.last;
    if run.converged {
        let steps = if run.earlier.is_empty() {
            ""
        } else {
            " in every step"
        };
        return format!(
            "<div class=\"banner good\"><b>✓ Certified</b>The computed answer satisfies equilibrium and the contact \
             conditions: every figure of the certificate is within its limit{steps}.</div>\n"
        );
    }
    if let Some(failed) = run.failed.filter(|_| solution.converged) {
        return format!(
            "<div class=\"banner bad\"><b>✗ Step {} of {} (t = {}) failed</b>{}. The numbers below are those of the step \
             before it, which is certified.</div>\n",
            failed.step,
            run.model.times.len(),
            number(failed.time),
            escape(&failed.reason)
        );
    }
    let failed: Vec<String> = solution
        .certificate
        .figures()
        .iter()
        .filter(|(_, f)| !f.holds())
        .map(|(name, f)| {
            format!(
                "{} (relative {}, limit {})",
                name.replace('_', " "),
                power(f.relative),
                power(f.limit)
            )
        })
        .collect();
    let reason = if failed.is_empty() {
        "The solver reports that it did not reach its goal.".to_string()
    } else {
        format!("Out of limits: {}.", failed.join(", "))
    };
    format!(
        "<div class=\"banner bad\"><b>✗ Not converged</b>The numbers below are those of the last iterate and must not be \
         used. {}</div>\n",
        escape(&reason)
    )
}

fn warnings(list: &[String]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let items: String = list
        .iter()
        .map(|w| format!("<li>{}</li>\n", escape(w)))
        .collect();
    let title = if list.len() == 1 {
        "Warning".to_string()
    } else {
        format!("{} warnings", list.len())
    };
    format!("<div class=\"banner warn\"><b>{title}</b><ul>\n{items}</ul></div>\n")
}

fn key_figures(solution: &Solution<2>, labels: &Labels) -> String {
    let mut cards: Vec<(&str, String, String)> = Vec::new();
    if let Some((body, value)) = greatest(&solution.bodies, max_displacement) {
        cards.push((
            "Largest displacement",
            quantity(value, &labels.length),
            body,
        ));
    }
    let stress = |b: &BodySolution<2>| largest(b.von_mises.iter().copied());
    if let Some((body, value)) = greatest(&solution.bodies, stress) {
        cards.push((
            "Largest von Mises stress",
            quantity(value, &labels.stress),
            body,
        ));
    }
    if !solution.contacts.is_empty() {
        let peak = |c: &ContactSolution<2>| largest(c.nodes.iter().map(|n| n.pressure));
        let name = solution
            .contacts
            .iter()
            .max_by(|a, b| peak(a).total_cmp(&peak(b)))
            .map_or(String::new(), |c| c.name.clone());
        cards.push((
            "Largest contact pressure",
            quantity(largest(solution.contacts.iter().map(peak)), &labels.stress),
            name,
        ));
        let whole: f64 = solution.contacts.iter().map(side_length).sum();
        let closed: f64 = solution.contacts.iter().map(|c| c.length).sum();
        cards.push((
            "Length in contact",
            quantity(closed, &labels.length),
            format!("of {}", quantity(whole, &labels.length)),
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
    let cards: String = cards
        .iter()
        .map(|(name, value, note)| {
            format!(
                "<div><span>{name}</span><strong>{}</strong><span>{}</span></div>\n",
                escape(value),
                escape(note)
            )
        })
        .collect();
    format!("<div class=\"keys\">\n{cards}</div>\n")
}

/// Length of the whole nonmortar side, undeformed.
fn side_length(contact: &ContactSolution<2>) -> f64 {
    let mut chain: Vec<_> = contact.nodes.iter().collect();
    if contact.cyclic {
        chain.extend(contact.nodes.first());
    }
    arc_lengths(&chain).last().copied().unwrap_or(0.0)
}

/// Name and value of the body where a number is largest.
fn greatest(
    bodies: &[BodySolution<2>],
    of: impl Fn(&BodySolution<2>) -> f64,
) -> Option<(String, f64)> {
    bodies
        .iter()
        .map(|b| (b.name.clone(), of(b)))
        .filter(|(_, v)| !v.is_nan())
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(name, value)| (format!("in {name}"), value))
}

fn probes(model: &Model<2>, solution: &Solution<2>, labels: &Labels) -> String {
    if solution.probes.is_empty() {
        return String::new();
    }
    let rows = solution
        .probes
        .iter()
        .map(|p| {
            let at = model
                .probes
                .iter()
                .find(|m| m.name == p.name)
                .and_then(|m| m.at)
                .map_or("–".to_string(), |at| vector(&at, ""));
            let unit = unit_of(&p.quantity, labels);
            vec![
                text(&p.name),
                text(&p.quantity),
                plain(at),
                plain(quantity(p.value, unit)),
            ]
        })
        .collect();
    let at = column("at", &labels.length);
    format!(
        "<h2>Results asked for</h2>\n{}",
        table(
            &[left("probe"), left("quantity"), at, column("value", "")],
            rows
        )
    )
}

/// Unit of a probe's quantity, `NAME.WHAT...`.
pub fn unit_of<'a>(quantity: &str, labels: &'a Labels) -> &'a str {
    let has = |word: &str| quantity.split('.').any(|part| part == word);
    if has("reaction") || has("resultant") {
        &labels.force
    } else if has("stress") || has("pressure") || has("shear") {
        &labels.stress
    } else {
        &labels.length
    }
}

fn bodies(model: &Model<2>, solution: &Solution<2>, labels: &Labels) -> String {
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
                plain(number(max_displacement(b))),
                plain(number(largest(b.von_mises.iter().copied()))),
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
        column("elastic energy", &labels.energy),
    ];
    let mut out = format!("<h3>Bodies</h3>\n{}", table(&heads, rows));
    let rows = solution
        .bodies
        .iter()
        .map(|b| {
            let modes: Vec<&str> = b
                .floating_modes
                .iter()
                .map(|m| m.description.as_str())
                .collect();
            let held = if modes.is_empty() {
                "held by its supports".to_string()
            } else {
                format!("{} held by contact alone", modes.join(", "))
            };
            vec![
                text(&b.name),
                plain(vector(&b.rigid.translation, "")),
                plain(
                    b.rigid
                        .rotation
                        .iter()
                        .map(|&r| number(r))
                        .collect::<Vec<_>>()
                        .join(", "),
                ),
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
    out += &format!(
        "<h3>Rigid motion</h3>\n<p>The rigid motion that comes closest to the displacements of the nodes, about their \
         centroid.</p>\n{}",
        table(&heads, rows)
    );
    out
}

fn contacts(model: &Model<2>, solution: &Solution<2>, scene: &Scene, labels: &Labels) -> String {
    if solution.contacts.is_empty() {
        return String::new();
    }
    let mut out = "<h2>Contact</h2>\n".to_string();
    let rows = solution
        .contacts
        .iter()
        .map(|c| {
            let (closed, open) = closed_and_open(&c.nodes);
            vec![
                text(&c.name),
                plain(format!("{} / {}", count(closed), count(open))),
                plain(number(c.length)),
                plain(number(largest(c.nodes.iter().map(|n| n.pressure)))),
                plain(number(largest_gap(&c.nodes))),
                plain(if max_penetration(&c.nodes) == 0.0 {
                    "0".to_string()
                } else {
                    power(max_penetration(&c.nodes))
                }),
                plain(vector(&c.resultant, "")),
            ]
        })
        .collect();
    let heads = [
        left("contact"),
        column("nodes closed / open", ""),
        column("length in contact", &labels.length),
        column("largest pressure", &labels.stress),
        column("largest gap", &labels.length),
        column("penetration", &labels.length),
        column("force on the nonmortar body", &labels.force),
    ];
    out += &table(&heads, rows);
    for (i, (contact, law)) in solution
        .contacts
        .iter()
        .zip(model.contacts.iter().map(|c| &c.law))
        .enumerate()
    {
        let Some(svg) = interface_figure(scene, contact, law, &format!("interface{i}")) else {
            continue;
        };
        let name = |side: &crate::model::SideRef| {
            let body = model
                .bodies
                .get(side.body.0)
                .map_or("?", |b| b.name.as_str());
            format!("{body}.{}", side.side)
        };
        let other = contact
            .mortar
            .as_ref()
            .map_or("a rigid obstacle".to_string(), name);
        let caption = format!(
            "{} against {other}. Pressure is positive in compression, the gap is that after deformation. Arrows: pressure on {}.",
            name(&contact.nonmortar),
            model
                .bodies
                .get(contact.nonmortar.body.0)
                .map_or("the body", |b| b.name.as_str()),
        );
        let title = format!(
            "Contact pressure and gap along the interface {}",
            contact.name
        );
        out += &figure(&svg, &title, &caption);
    }
    out
}

fn balance(model: &Model<2>, solution: &Solution<2>, labels: &Labels) -> String {
    let forces: Vec<(Point<2>, Point<2>)> = solution
        .bodies
        .iter()
        .enumerate()
        .map(|(i, body)| (body.reaction, contact_force(solution, i)))
        .collect();
    let scale = largest(forces.iter().flat_map(|(a, b)| [norm(*a), norm(*b)]));
    let axial = model.analysis == Analysis::Axisymmetric;
    let rows = solution
        .bodies
        .iter()
        .zip(&forces)
        .map(|(body, (reaction, contact))| {
            let rest: Point<2> = std::array::from_fn(|k| -(reaction[k] + contact[k]));
            // radial forces balance over the full turn
            let force = |f: &Point<2>| match axial {
                true => plain(number(without_noise(f[1], scale))),
                false => plain(vector_on(f, scale, "")),
            };
            vec![
                text(&body.name),
                force(reaction),
                force(contact),
                force(&rest),
            ]
        })
        .collect();
    let heads = [
        left("body"),
        column("reaction of its supports", &labels.force),
        column("force of its contacts", &labels.force),
        column("applied load, by balance", &labels.force),
    ];
    let mut out = format!(
        "<h2>Reactions and balance</h2>\n<p>Forces ON each body, {}. The three add up to zero; what is below 10⁻¹⁰ of the largest is shown as 0.</p>\n{}",
        match axial {
            true => "along the axis z, for the full turn".to_string(),
            false => format!("as ({}, {})", labels.axes[0], labels.axes[1]),
        },
        table(&heads, rows)
    );
    let c = &solution.certificate;
    let sides: Vec<String> = solution
        .contacts
        .iter()
        .map(|k| format!("{} {}", escape(&k.name), power(k.imbalance)))
        .collect();
    let action = if sides.is_empty() {
        String::new()
    } else {
        format!(
            " Action and reaction across the contacts differ by (relative): {}.",
            sides.join(", ")
        )
    };
    out += &format!(
        "<p>What is left over on the worst body: force {}, moment {} (relative {} and {}).{action}</p>\n",
        quantity(c.imbalance_force.value, &labels.force),
        quantity(c.imbalance_moment.value, &labels.energy),
        power(c.imbalance_force.relative),
        power(c.imbalance_moment.relative),
    );
    out
}

/// Force of all contacts ON a body.
fn contact_force(solution: &Solution<2>, body: usize) -> Point<2> {
    let mut force: Point<2> = [0.0; 2];
    for contact in &solution.contacts {
        if contact.nonmortar.body.0 == body {
            force = add_scaled(force, 1.0, contact.resultant);
        }
        if contact.mortar.as_ref().is_some_and(|m| m.body.0 == body) {
            force = add_scaled(force, -1.0, contact.resultant);
        }
    }
    force
}

fn certificate(solution: &Solution<2>, labels: &Labels) -> String {
    let Certificate {
        penetration,
        tension,
        complementarity,
        imbalance_force,
        imbalance_moment,
        energy_gap,
        slip_violation,
        force_error,
        between_nodes,
    } = solution.certificate;
    let lines: [(&str, &str, Figure, &str); 9] = [
        (
            "Penetration",
            "No contact point lies inside the other body by more than",
            penetration,
            &labels.length,
        ),
        (
            "Tension",
            "No contact that can open pulls by more than",
            tension,
            &labels.force,
        ),
        (
            "Complementarity",
            "Where there is force there is no gap: the sum of force times gap is",
            complementarity,
            &labels.energy,
        ),
        (
            "Balance of forces",
            "The forces on every body add up to zero within",
            imbalance_force,
            &labels.force,
        ),
        (
            "Balance of moments",
            "The moments on every body add up to zero within",
            imbalance_moment,
            &labels.energy,
        ),
        (
            "Energy",
            "The energies of displacements and of forces bound the exact discrete answer from two sides; they differ by",
            energy_gap,
            &labels.energy,
        ),
        (
            "Friction",
            "No shear force exceeds or contradicts the friction law by more than",
            slip_violation,
            &labels.force,
        ),
        (
            "Contact forces",
            "No contact force would change, if it answered its own gap, by more than",
            force_error,
            &labels.force,
        ),
        (
            "Between the nodes",
            "Looked at between their nodes, whatever was imposed, the sides overlap, compared with what the meshes can resolve, by",
            between_nodes,
            &labels.length,
        ),
    ];
    let rows = lines
        .iter()
        .map(|(name, sentence, figure, unit)| {
            let mark = if figure.holds() {
                Cell {
                    html: "<span class=\"yes\" title=\"within its limit\">✓</span>".to_string(),
                    text: false,
                }
            } else {
                Cell {
                    html: "<span class=\"no\" title=\"out of its limit\">✗</span>".to_string(),
                    text: false,
                }
            };
            let value = if unit.is_empty() {
                power(figure.value)
            } else {
                format!("{}\u{202f}{unit}", power(figure.value))
            };
            let words = Cell {
                html: format!("<b>{name}.</b> {sentence} {}.", escape(&value)),
                text: true,
            };
            vec![
                words,
                plain(power(figure.relative)),
                plain(power(figure.limit)),
                mark,
            ]
        })
        .collect();
    format!(
        "<h2>Certificate</h2>\n<p>Checked on the answer itself, whichever method computed it.</p>\n{}",
        table(
            &[
                left("what was checked"),
                column("relative", ""),
                column("limit", ""),
                column("", "")
            ],
            rows
        )
    )
}

fn solver(model: &Model<2>, solution: &Solution<2>, labels: &Labels) -> String {
    let report = &solution.solver;
    let mut out = format!(
        "<h2>Convergence</h2>\n<p>Method {}: {} iterations, {} products with the compliance{}.</p>\n",
        escape(report.method),
        count(report.iterations),
        count(report.products),
        report
            .rho
            .map_or(String::new(), |rho| format!(", step ρ = {}", number(rho)))
    );
    if let Some(svg) = history_figure(solution, model.solver.tolerance) {
        let caption = "Largest relative violation of the optimality conditions, and the number of contact unknowns with a force.";
        out += &figure(&svg, "Convergence", caption);
    }
    if report.bolts.is_empty() {
        return out;
    }
    let rows = report
        .bolts
        .iter()
        .map(|b| {
            let state = match (b.moved, b.force < 0.0) {
                (true, _) => "improper, moved away",
                (false, true) => "improper",
                (false, false) => "proper",
            };
            vec![
                text(&b.contact),
                plain(vector(&b.point, "")),
                plain(number(b.force)),
                text(state),
            ]
        })
        .collect();
    out += "<h3>Bolts</h3>\n<p>A bolt holds a rigid motion while the forces are iterated. It is proper when it ends in compression.</p>\n";
    let heads = [
        left("contact"),
        column("at", &labels.length),
        column("force", &labels.force),
        left("state"),
    ];
    out + &table(&heads, rows)
}

fn contact_nodes(solution: &Solution<2>, labels: &Labels) -> String {
    if solution.contacts.is_empty() {
        return String::new();
    }
    let mut out = "<h2>Contact nodes</h2>\n".to_string();
    for contact in &solution.contacts {
        if contact.nodes.len() > MOST_ROWS {
            out += &format!(
                "<p>Contact {}: {} nodes, listed in contact.csv.</p>\n",
                escape(&contact.name),
                count(contact.nodes.len())
            );
            continue;
        }
        let shear = contact.nodes.iter().any(|n| norm(n.shear) > 0.0);
        let mut heads = vec![
            column("node", ""),
            column(labels.axes[0], &labels.length),
            column(labels.axes[1], &labels.length),
            column("weight", ""),
            column("gap", &labels.length),
            column("pressure", &labels.stress),
        ];
        if shear {
            heads.push(column("shear", &labels.stress));
        }
        heads.push(column("status", ""));
        let rows = contact
            .nodes
            .iter()
            .map(|n| {
                let mut row = vec![
                    plain(n.node.to_string()),
                    plain(number(n.point[0])),
                    plain(number(n.point[1])),
                    plain(number(n.weight)),
                    plain(number(n.gap)),
                    plain(number(n.pressure)),
                ];
                if shear {
                    let along =
                        crate::geometry::dot(n.shear, crate::output::csv::tangent(n.normal));
                    row.push(plain(number(along)));
                }
                let status = n.status.name();
                row.push(Cell {
                    html: if in_contact(n.status) {
                        format!("<b>{status}</b>")
                    } else {
                        status.to_string()
                    },
                    text: false,
                });
                row
            })
            .collect();
        out += &format!(
            "<details{}>\n<summary>{}: {} nodes</summary>\n{}</details>\n",
            if contact.nodes.len() <= 12 {
                " open"
            } else {
                ""
            },
            escape(&contact.name),
            count(contact.nodes.len()),
            table(&heads, rows)
        );
    }
    out
}

fn timings(run: &Run<'_>) -> String {
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
    let heads: Vec<Head> = stages
        .iter()
        .map(|(name, _)| Head {
            left: false,
            ..column(name, "")
        })
        .collect();
    let row = stages
        .iter()
        .map(|(_, value)| plain(seconds(*value)))
        .collect();
    format!(
        "<h2>Effort</h2>\n{}<p>{} {}, largest memory {} MB.</p>\n",
        table(&heads, vec![row]),
        threads,
        if threads == 1 { "thread" } else { "threads" },
        count((run.peak_memory as f64 / 1e6).round() as usize)
    )
}

fn foot(stem: &str) -> String {
    format!(
        "<footer>Computed with dotyk {VERSION}, case {}. Full numbers: summary.json, contact.csv; fields: case.pvd.</footer>\n\
         </main>\n</body>\n</html>\n",
        escape(stem)
    )
}

/// Head of a table column.
pub struct Head {
    name: String,
    unit: String,
    left: bool,
}

pub fn column(name: &str, unit: &str) -> Head {
    Head {
        name: name.to_string(),
        unit: unit.to_string(),
        left: false,
    }
}

fn left(name: &str) -> Head {
    Head {
        left: true,
        ..column(name, "")
    }
}

/// Content of a table cell, already escaped.
pub struct Cell {
    html: String,
    text: bool,
}

pub fn plain(text: String) -> Cell {
    Cell {
        html: escape(&text),
        text: false,
    }
}

fn text(text: &str) -> Cell {
    Cell {
        html: escape(text),
        text: true,
    }
}

pub fn table(heads: &[Head], rows: Vec<Vec<Cell>>) -> String {
    let class = |is_text: bool| if is_text { " class=\"text\"" } else { "" };
    let mut out = String::from("<div class=\"scroll\"><table>\n<thead><tr>");
    for head in heads {
        let unit = if head.unit.is_empty() {
            String::new()
        } else {
            format!("<small>{}</small>", escape(&head.unit))
        };
        out += &format!("<th{}>{}{unit}</th>", class(head.left), escape(&head.name));
    }
    out += "</tr></thead>\n<tbody>\n";
    for row in rows {
        out += "<tr>";
        for cell in row {
            out += &format!("<td{}>{}</td>", class(cell.text), cell.html);
        }
        out += "</tr>\n";
    }
    out + "</tbody></table></div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;
    use crate::output::sample;
    use std::time::Instant;

    #[test]
    fn page_needs_no_network_and_no_script() {
        let (model, solution) = sample::tunnel(16);
        let page = page(&sample::run(&model, &solution));
        let outside = page.replace("http://www.w3.org/2000/svg", "");
        for word in [
            "http://", "https://", "//cdn", "@import", "<script", "<link",
        ] {
            assert!(!outside.contains(word), "{word}");
        }
        assert!(
            page.contains("✓ Certified") && page.contains("Lined tunnel under uneven pressure")
        );
        // What comes from the user is escaped.
        assert!(page.contains("&quot;outer&quot; face nothing &amp; stay open"));
    }

    #[test]
    fn same_solution_gives_the_same_bytes() {
        let (model, solution) = sample::tunnel(16);
        let once = page(&sample::run(&model, &solution));
        assert!(once == page(&sample::run(&model, &solution)));
    }

    #[test]
    fn a_failed_certificate_is_said_in_the_banner() {
        let (model, mut solution) = sample::tunnel(16);
        solution.converged = false;
        solution.certificate.energy_gap = Figure::new(0.1, 1.0, 1e-8);
        let page = page(&sample::run(&model, &solution));
        assert!(page.contains("✗ Not converged") && page.contains("energy gap (relative 10⁻¹"));
        assert!(!page.contains("✓ Certified"));
    }

    #[test]
    fn page_of_a_hundred_thousand_cells_is_small_and_quick() {
        let (model, solution) = sample::tunnel_with([500, 20], [500, 180], CellKind::Quad4);
        let mut quickest = f64::INFINITY;
        // The best of three: other work on the machine only adds.
        for _ in 0..3 {
            let start = Instant::now();
            let page = page(&sample::run(&model, &solution));
            quickest = quickest.min(start.elapsed().as_secs_f64());
            assert!(page.len() < 5_000_000, "{} bytes", page.len());
        }
        assert!(quickest < 1.0, "{quickest} s");
    }

    #[test]
    fn a_model_without_contact_still_has_a_page() {
        let (mut model, mut solution) = sample::tunnel(16);
        model.contacts.clear();
        solution.contacts.clear();
        solution.solver.history.clear();
        let page = page(&sample::run(&model, &solution));
        assert!(page.contains("Reactions and balance") && !page.contains("Contact nodes"));
    }

    #[test]
    fn check_page_shows_the_findings() {
        let (model, _) = sample::tunnel(16);
        let page = check_page(&model, "ring: <held> by contact", &[], "case_1");
        assert!(page.contains("ring: &lt;held&gt; by contact") && page.contains("<svg"));
    }
}
