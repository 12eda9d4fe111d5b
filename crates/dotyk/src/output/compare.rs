//! `compare.csv` and `compare.svg`: all solvers on one case, and iterations as a function of ρ·λ_max.
//!
//! The picture is that of Fig. 11 of V. Janovský, P. Procházka, Contact problem of two elastic bodies III,
//! Apl. mat. 25 (1980): a long branch of about C/ρ, and a wall at ρ = 2/λ_max.

use crate::model::{Comparison, ComparisonRow};
use crate::output::csv::quoted;
use crate::output::markup::Markup;
use crate::output::plot::{Axis, Frame};
use crate::output::svg::{ALARM, Anchor, MUTED, SERIES, Svg, Type, short, text_width};
use crate::output::text::{count, seconds};
use std::fmt::Write;

/// Content of `compare.csv`; the field of ρ is empty for a method without ρ.
pub fn comparison_csv(comparison: &Comparison) -> String {
    let mut out = String::from(
        "method,rho,rho_lambda_max,converged,iterations,products,seconds,difference\n",
    );
    let optional = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:?}"));
    for row in &comparison.rows {
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "{},{},{},{},{},{},{:?},{:?}",
            quoted(&row.method),
            optional(row.rho),
            optional(row.rho_lambda_max),
            row.converged,
            row.iterations,
            row.products,
            row.seconds,
            row.difference
        );
    }
    out
}

/// Content of `compare.svg`: curves where ρ was varied, otherwise bars.
pub fn comparison_svg(comparison: &Comparison) -> Markup {
    let steps = |method: &str| {
        let rows = comparison.rows.iter().filter(|r| r.method == method);
        rows.filter(|r| r.rho_lambda_max.is_some()).count()
    };
    if methods(comparison).into_iter().any(|m| steps(m) > 1) {
        curves(comparison)
    } else {
        bars(comparison)
    }
}

fn methods(comparison: &Comparison) -> Vec<&str> {
    let mut list: Vec<&str> = Vec::new();
    for row in &comparison.rows {
        if !list.contains(&row.method.as_str()) {
            list.push(&row.method);
        }
    }
    list
}

fn curves(comparison: &Comparison) -> Markup {
    let mut svg = canvas("Iterations as a function of rho times lambda max", 470.0);
    headline(&mut svg, 70.0, &comparison.title);
    let places: Vec<f64> = comparison
        .rows
        .iter()
        .filter_map(|r| r.rho_lambda_max)
        .chain([2.0])
        .collect();
    let counts: Vec<f64> = comparison
        .rows
        .iter()
        .filter(|r| r.converged)
        .map(|r| r.iterations as f64)
        .collect();
    let frame = Frame {
        corner: [70.0, 70.0],
        size: [488.0, 350.0],
        x: Axis::log("ρ · λₘₐₓ", &places),
        y: Axis::log("Iterations", &counts),
    };
    let [left, top] = frame.corner;
    // Beyond the wall the fixed step cannot contract.
    let wall = frame.across(2.0);
    svg.rectangle(
        [wall, top],
        [left + frame.size[0] - wall, frame.size[1]],
        "none",
        "#f6e3e1",
    );
    frame.draw(&mut svg, true);
    svg.line([wall, top], [wall, top + frame.size[1]], ALARM, 1.4);
    let label = Type::LABEL.coloured(ALARM).anchored(Anchor::End).rimmed();
    svg.text([wall - 6.0, top + 16.0], "ρ = 2/λₘₐₓ", label);
    let mut key = top + 8.0;
    let mut diverged = false;
    for (i, method) in methods(comparison).into_iter().enumerate() {
        let colour = SERIES[i % SERIES.len()];
        let rows: Vec<&ComparisonRow> = comparison
            .rows
            .iter()
            .filter(|r| r.method == method)
            .collect();
        let fixed = rows.iter().find(|r| r.rho_lambda_max.is_none());
        let mut curve: Vec<[f64; 2]> = rows
            .iter()
            .filter_map(|r| {
                r.rho_lambda_max.map(|x| {
                    [
                        x,
                        if r.converged {
                            r.iterations as f64
                        } else {
                            f64::NAN
                        },
                    ]
                })
            })
            .collect();
        curve.sort_by(|a, b| a[0].total_cmp(&b[0]));
        frame.curve(&mut svg, &curve, colour, 1.8);
        for p in &curve {
            if p[1].is_finite() {
                svg.circle(
                    frame.at(p[0], p[1]),
                    2.6,
                    colour,
                    "#fff",
                    &format!("{method}: {} iterations", p[1]),
                );
            } else {
                diverged = true;
                // Methods side by side, not on top of each other.
                cross(
                    &mut svg,
                    [frame.across(p[0]), top - 8.0 - 9.0 * i as f64 % 27.0],
                    colour,
                );
            }
        }
        let mut text = method.to_string();
        if let Some(row) = fixed.filter(|r| r.converged && r.iterations > 0) {
            let y = frame.up(row.iterations as f64);
            let path = format!(
                "M{} {}H{}",
                short(left),
                short(y),
                short(left + frame.size[0])
            );
            svg.path(&path, colour, 1.4, "none", "stroke-dasharray=\"6 3\"");
            text = format!("{method}, no ρ: {}", count(row.iterations));
        }
        svg.line([572.0, key], [592.0, key], colour, 2.0);
        svg.text(
            [598.0, key + 4.0],
            &text,
            Type::LABEL.sized(11.0).anchored(Anchor::Start),
        );
        key += 20.0;
    }
    if diverged {
        cross(&mut svg, [582.0, key], MUTED);
        svg.text(
            [598.0, key + 4.0],
            "not converged",
            Type::LABEL.sized(11.0).anchored(Anchor::Start),
        );
    }
    svg.finish()
}

fn cross(svg: &mut Svg, at: [f64; 2], colour: &str) {
    let r = 3.2;
    svg.line([at[0] - r, at[1] - r], [at[0] + r, at[1] + r], colour, 1.5);
    svg.line([at[0] - r, at[1] + r], [at[0] + r, at[1] - r], colour, 1.5);
}

fn bars(comparison: &Comparison) -> Markup {
    let each = 34.0;
    let height = 66.0 + each * comparison.rows.len() as f64;
    let mut svg = canvas("Products with the compliance by method", height);
    headline(&mut svg, 16.0, &comparison.title);
    svg.text(
        [110.0, 48.0],
        "Products with the compliance F (logarithmic)",
        Type::SMALL.coloured(MUTED).anchored(Anchor::Start),
    );
    let most = comparison
        .rows
        .iter()
        .map(|r| r.products)
        .max()
        .unwrap_or(1)
        .max(2) as f64;
    for (i, row) in comparison.rows.iter().enumerate() {
        let y = 60.0 + each * i as f64;
        // One product is still a bar that can be seen.
        let part = (1.0 + row.products as f64).ln() / (1.0 + most).ln();
        let colour = if row.converged {
            SERIES[i % SERIES.len()]
        } else {
            "#b9c0c7"
        };
        svg.text(
            [100.0, y + 15.0],
            &row.method,
            Type::LABEL.anchored(Anchor::End),
        );
        svg.rectangle([110.0, y + 2.0], [370.0 * part, 18.0], "none", colour);
        let state = if row.converged { "" } else { ", not converged" };
        let text = format!(
            "{}  ({} iterations, {}{state})",
            count(row.products),
            count(row.iterations),
            seconds(row.seconds)
        );
        svg.text(
            [118.0 + 370.0 * part, y + 15.0],
            &text,
            Type::SMALL.anchored(Anchor::Start),
        );
    }
    svg.finish()
}

/// The title in one line: long ones in smaller letters.
fn headline(svg: &mut Svg, left: f64, title: &str) {
    let room = 750.0 - left;
    // Heavy letters are about a tenth wider.
    let size = (14.0 * room / (1.1 * text_width(title, 14.0)).max(1.0)).clamp(8.0, 14.0);
    let style = Type::LABEL.sized(size).bold().anchored(Anchor::Start);
    svg.text([left, 22.0], title, style);
}

fn canvas(description: &str, height: f64) -> Svg {
    let mut svg = Svg::new("compare", description, 760.0, height);
    svg.rectangle([0.0, 0.0], [760.0, height], "none", "#fff");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Iterations of about C/ρ up to the wall.
    fn example() -> Comparison {
        let mut rows = Vec::new();
        for (method, constant, wall) in [("uzawa", 600.0, 2.0), ("gradient", 115.0, 2.05)] {
            for i in 0..25 {
                let x = 0.05 * 80f64.powf(f64::from(i) / 24.0);
                let converged = x < wall;
                rows.push(ComparisonRow {
                    method: method.to_string(),
                    rho: Some(18.0 * x),
                    rho_lambda_max: Some(x),
                    converged,
                    iterations: if converged {
                        (constant / x) as usize
                    } else {
                        5000
                    },
                    products: (constant / x) as usize + 1,
                    seconds: 0.01,
                    difference: if converged { 1e-9 } else { f64::NAN },
                });
            }
        }
        for (method, iterations) in [("newton", 6), ("mprgp", 74), ("accelerated", 121)] {
            rows.push(ComparisonRow {
                method: method.to_string(),
                rho: None,
                rho_lambda_max: None,
                converged: true,
                iterations,
                products: iterations,
                seconds: 2e-4,
                difference: 0.0,
            });
        }
        Comparison {
            title: "Case 1".to_string(),
            rows,
        }
    }

    #[test]
    fn csv_leaves_missing_rho_empty() {
        let text = comparison_csv(&example());
        assert!(text.contains("\nnewton,,,true,6,6,0.0002,0.0\n"));
        assert!(text.contains("NaN"), "a diverged run has no difference");
        assert_eq!(text.lines().count(), 1 + 53);
    }

    #[test]
    fn diverged_runs_are_crossed_above_the_frame() {
        let svg = comparison_svg(&example());
        assert!(svg.contains("not converged") && svg.contains("2/λₘₐₓ"));
        let mut calm = example();
        calm.rows.retain(|r| r.converged);
        assert!(!comparison_svg(&calm).contains("not converged"));
    }

    #[test]
    fn without_rho_there_are_bars() {
        let mut plain = example();
        // One automatic step of a method is not a curve.
        let mut first = true;
        plain
            .rows
            .retain(|r| r.rho.is_none() || std::mem::take(&mut first));
        assert_eq!(plain.rows.len(), 4);
        let svg = comparison_svg(&plain);
        assert!(svg.contains("Products with the compliance F") && svg.contains("mprgp"));
    }
}
