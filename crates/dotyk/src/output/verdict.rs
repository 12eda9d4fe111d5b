//! Sections of the report on the reliability of its numbers: banner, warnings, certificate and convergence.

use crate::model::{Model, Solution, told_in_steps};
use crate::output::Overview;
use crate::output::history::history_figure;
use crate::output::html::{self, column, described, fitted, left, marked, plain, table, text};
use crate::output::markup::{Markup, markup};
use crate::output::text::{Labels, count, number, power, vector};

/// Whether the answer is certified, and if not, why.
pub fn banner<const D: usize>(run: &Overview<'_, D>) -> Markup {
    let solution = run.last;
    if run.converged {
        let steps = match run.earlier {
            [] => "",
            _ => " in every step",
        };
        let body = markup!(
            "The computed answer satisfies equilibrium and the contact conditions: every figure of the certificate is \
             within its limit{}.",
            steps
        );
        return html::banner("good", "✓ Certified", &body);
    }
    if let Some(failed) = run.failed.filter(|_| solution.converged) {
        let title = format!(
            "✗ Step {} of {} (t = {}) failed",
            failed.step,
            run.model.times.len(),
            number(failed.time)
        );
        let body = markup!(
            "{}. The numbers below are those of the step before it, which is certified.",
            failed.reason
        );
        return html::banner("bad", &title, &body);
    }
    let figures = solution.certificate.figures();
    let failed = figures.iter().filter(|(_, f)| !f.holds()).map(|(name, f)| {
        let (relative, limit) = (power(f.relative), power(f.limit));
        format!(
            "{} (relative {relative}, limit {limit})",
            name.replace('_', " ")
        )
    });
    let failed: Vec<String> = failed.collect();
    let reason = match failed.len() {
        0 => "The solver reports that it did not reach its goal.".to_string(),
        _ => format!("Out of limits: {}.", failed.join(", ")),
    };
    let body = markup!(
        "The numbers below are those of the last iterate and must not be used. {}",
        reason
    );
    html::banner("bad", "✗ Not converged", &body)
}

/// Warnings of all steps, each once.
pub fn warnings<const D: usize>(run: &Overview<'_, D>) -> Markup {
    let list = told_in_steps(run.steps().map(|step| &step.warnings[..]));
    let items = list.iter().map(|w| markup!("<li>{}</li>\n", w));
    let body = markup!("<ul>\n{}</ul>", items.collect::<Markup>());
    match list.len() {
        0 => Markup::default(),
        1 => html::banner("warn", "Warning", &body),
        count => html::banner("warn", &format!("{count} warnings"), &body),
    }
}

/// A figure of the certificate: its name, its title in the report, its meaning, and its unit.
type Sentence = (
    &'static str,
    &'static str,
    &'static str,
    fn(&Labels) -> &str,
);

/// All figures.
const SENTENCES: [Sentence; 14] = [
    (
        "penetration",
        "Penetration",
        "No contact point lies inside the other body by more than",
        |labels| &labels.length,
    ),
    (
        "tension",
        "Tension",
        "No contact that can open pulls by more than",
        |labels| &labels.force,
    ),
    (
        "complementarity",
        "Complementarity",
        "Where there is force there is no gap: the sum of force times gap is",
        |labels| &labels.energy,
    ),
    (
        "imbalance_force",
        "Balance of forces",
        "The forces on every body add up to zero within",
        |labels| &labels.force,
    ),
    (
        "imbalance_moment",
        "Balance of moments",
        "The moments on every body add up to zero within",
        |labels| &labels.energy,
    ),
    (
        "energy_gap",
        "Energy",
        "The energies of displacements and of forces bound the exact discrete answer from two sides; they differ by",
        |labels| &labels.energy,
    ),
    (
        "slip_violation",
        "Friction",
        "No shear force exceeds or contradicts the friction law by more than",
        |labels| &labels.force,
    ),
    (
        "force_error",
        "Contact forces",
        "No contact force would change, if it answered its own gap, by more than",
        |labels| &labels.force,
    ),
    (
        "rounding",
        "Rounding",
        "Where multipliers are finer than the softer side, rounding of coordinates and displacements changes no contact force by more than",
        |labels| &labels.force,
    ),
    (
        "between_nodes",
        "Between the nodes",
        "Looked at between their nodes, whatever was imposed, the sides overlap, compared with what the meshes can resolve, by",
        |labels| &labels.length,
    ),
    (
        "overlap",
        "Overlap",
        "Where they have moved to, no two bodies overlap more than at first, compared with what small displacements explain, by more than",
        |labels| &labels.length,
    ),
    (
        "equilibrium",
        "Yielding in equilibrium",
        "Where bodies yield, their stress leaves no node unbalanced by more than",
        |labels| &labels.force,
    ),
    (
        "yield_violation",
        "Yield stress",
        "Nowhere does the stress exceed what the material bears by more than",
        |labels| &labels.stress,
    ),
    (
        "flow",
        "Flow",
        "What yields takes up work everywhere; it gives back no more than",
        |labels| &labels.energy,
    ),
];

/// The figures of the certificate in sentences.
pub fn certificate<const D: usize>(solution: &Solution<D>, labels: &Labels) -> Markup {
    let lines = solution.certificate.figures().into_iter();
    let rows = lines
        .filter_map(|(name, figure)| Some((SENTENCES.iter().find(|own| own.0 == name)?, figure)))
        .map(|(&(_, name, sentence, unit), figure)| {
            let unit = unit(labels);
            let mark = match figure.holds() {
                true => markup!("<span class=\"yes\" title=\"within its limit\">✓</span>"),
                false => markup!("<span class=\"no\" title=\"out of its limit\">✗</span>"),
            };
            let value = match unit.is_empty() {
                true => power(figure.value),
                false => format!("{}\u{202f}{unit}", power(figure.value)),
            };
            let words = markup!("<b>{}.</b> {} {}.", name, sentence, value);
            vec![
                described(words),
                plain(power(figure.relative)),
                plain(power(figure.limit)),
                marked(mark),
            ]
        })
        .collect();
    markup!(
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

/// Convergence of the solver, and its bolts.
pub fn solver<const D: usize>(model: &Model<D>, solution: &Solution<D>, labels: &Labels) -> Markup {
    let report = &solution.solver;
    let mut out = markup!(
        "<h2>Convergence</h2>\n<p>Method {}: {} iterations, {} products with the compliance{}.</p>\n",
        report.method,
        count(report.iterations),
        count(report.products),
        report
            .rho
            .map_or(String::new(), |rho| format!(", step ρ = {}", number(rho)))
    );
    if !report.history.is_empty() {
        let tolerance = model.solver.tolerance;
        let draw = |width| history_figure(solution, tolerance, width).unwrap_or_default();
        let caption = "Largest relative violation of the optimality conditions, and the number of contact unknowns with a force.";
        out += fitted(&draw, "Convergence", caption);
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
    out += markup!(
        "<h3>Bolts</h3>\n<p>A bolt holds a rigid motion while the forces are iterated. It is proper when it ends in compression.</p>\n"
    );
    let heads = [
        left("contact"),
        column("at", &labels.length),
        column("force", &labels.force),
        left("state"),
    ];
    out + table(&heads, rows)
}
