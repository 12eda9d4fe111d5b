//! Performance profiles: which part of the problems a solver solves within τ times the time of the fastest.
//!
//! ```text
//!   profile of s at τ = #{p: t(p, s) ≤ τ · min over s' of t(p, s')} / #{p}
//! ```
//!
//! Times of problems that are not solved are infinite; times below a millisecond count as a millisecond, since they mean nothing.
//! As described in Dolan & Moré (2002).

use std::fmt::Write;

/// τ of the columns of the text.
pub const FACTORS: [f64; 8] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 1000.0];

/// Shortest distinguished time, in seconds.
const SHORTEST: f64 = 1e-3;

/// Colours of the lines, distinct also with red-green blindness (after Okabe and Ito).
const COLOURS: [&str; 8] = [
    "#c2410c", "#0b6aa8", "#00795b", "#8a3d7c", "#8a6d00", "#3a4a5a", "#1d2733", "#5a6672",
];

/// Seconds of one solver, one per problem; `None` where it did not solve.
#[derive(Debug, Clone)]
pub struct Times {
    /// Name of the solver.
    pub solver: String,
    /// Seconds.
    pub seconds: Vec<Option<f64>>,
}

/// For each solver the ratios to the fastest, ascending, and the number of problems.
pub fn ratios(all: &[Times]) -> (Vec<(String, Vec<f64>)>, usize) {
    let problems = all
        .iter()
        .map(|times| times.seconds.len())
        .max()
        .unwrap_or(0);
    let time = |times: &Times, p: usize| {
        let seconds = times.seconds.get(p).copied().flatten();
        seconds.map_or(f64::INFINITY, |t| t.max(SHORTEST))
    };
    let fastest: Vec<f64> = (0..problems)
        .map(|p| all.iter().map(|t| time(t, p)).fold(f64::INFINITY, f64::min))
        .collect();
    let of = |times: &Times| {
        let mut ratios: Vec<f64> = (0..problems)
            .map(|p| time(times, p) / fastest[p])
            .filter(|ratio| ratio.is_finite())
            .collect();
        ratios.sort_by(f64::total_cmp);
        (times.solver.clone(), ratios)
    };
    (all.iter().map(of).collect(), problems)
}

fn within(ratios: &[f64], factor: f64) -> usize {
    ratios.partition_point(|&ratio| ratio <= factor)
}

/// The profile as a table, and the number of solved problems.
pub fn text(all: &[Times]) -> String {
    let (ratios, problems) = ratios(all);
    let width = ratios
        .iter()
        .map(|(name, _)| name.len())
        .max()
        .unwrap_or(0)
        .max(8);
    let mut text = format!("{:<width$}", "solver");
    for factor in FACTORS {
        let _ = write!(text, " {:>7}", format!("τ={factor}"));
    }
    let _ = writeln!(text, " {:>9}", "solved");
    for (name, ratios) in &ratios {
        let _ = write!(text, "{name:<width$}");
        for factor in FACTORS {
            let part = within(ratios, factor) as f64 / problems.max(1) as f64;
            let _ = write!(text, " {part:>7.2}");
        }
        let _ = writeln!(text, " {:>9}", format!("{}/{problems}", ratios.len()));
    }
    text
}

/// The profile as a drawing, τ on a logarithmic axis from 1 to 1000.
pub fn svg(all: &[Times], title: &str) -> String {
    let (ratios, problems) = ratios(all);
    let (left, top, width, height) = (60.0, 40.0, 560.0, 320.0);
    let x = |factor: f64| left + width * (factor.log10() / 3.0).clamp(0.0, 1.0);
    let y = |part: f64| top + height * (1.0 - part);
    let mut out = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" height=\"420\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"800\" height=\"420\" fill=\"#ffffff\"/>\n",
    );
    let mut label = |x: f64, y: f64, anchor: &str, colour: &str, text: &str| {
        let text = text
            .replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('>', "&gt;");
        let _ = writeln!(
            out,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{text}</text>"
        );
    };
    let ink = "#1d2733";
    label(left, 24.0, "start", ink, title);
    let caption = "time over the time of the fastest";
    label(left + width / 2.0, 404.0, "middle", ink, caption);
    for factor in [1.0, 10.0, 100.0, 1000.0] {
        label(
            x(factor),
            top + height + 18.0,
            "middle",
            ink,
            &factor.to_string(),
        );
    }
    for tenth in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
        label(
            left - 8.0,
            y(tenth) + 4.0,
            "end",
            ink,
            &format!("{tenth:.1}"),
        );
    }
    for (k, (name, ratios)) in ratios.iter().enumerate() {
        let at = top + 16.0 + 18.0 * k as f64;
        let text = format!("{name} {}/{problems}", ratios.len());
        label(
            left + width + 12.0,
            at,
            "start",
            COLOURS[k % COLOURS.len()],
            &text,
        );
    }
    for tenth in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
        let (from, to, at) = (left, left + width, y(tenth));
        let _ = writeln!(
            out,
            "<path d=\"M{from:.1} {at:.1}H{to:.1}\" stroke=\"#d5dbe1\"/>"
        );
    }
    for (k, (_, ratios)) in ratios.iter().enumerate() {
        let part = |count: usize| count as f64 / problems.max(1) as f64;
        let mut path = format!("M{:.1} {:.1}", x(1.0), y(part(within(ratios, 1.0))));
        for (count, &ratio) in ratios
            .iter()
            .enumerate()
            .filter(|(_, ratio)| **ratio > 1.0 && **ratio <= 1000.0)
        {
            let _ = write!(path, "H{:.1}V{:.1}", x(ratio), y(part(count + 1)));
        }
        let _ = writeln!(
            out,
            "<path d=\"{path}H{:.1}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>",
            x(1000.0),
            COLOURS[k % COLOURS.len()]
        );
    }
    out.push_str("</svg>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times() -> [Times; 2] {
        let of = |solver: &str, seconds: [Option<f64>; 4]| Times {
            solver: solver.to_string(),
            seconds: seconds.to_vec(),
        };
        [
            of("ours", [Some(1.0), Some(4.0), None, Some(1e-7)]),
            of("theirs", [Some(3.0), Some(2.0), None, Some(5e-4)]),
        ]
    }

    #[test]
    fn profile_counts_what_is_solved_within_the_factor() {
        let (ratios, problems) = ratios(&times());
        assert_eq!(problems, 4);
        assert_eq!(ratios[0].1, [1.0, 1.0, 2.0]);
        assert_eq!(ratios[1].1, [1.0, 1.0, 3.0]);
        let text = text(&times());
        let line = text
            .lines()
            .find(|line| line.starts_with("theirs"))
            .unwrap();
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[1..4], ["0.50", "0.50", "0.75"]);
        assert_eq!(words.last(), Some(&"3/4"));
    }

    #[test]
    fn drawing_has_a_line_for_each_solver_and_escapes_names() {
        let mut all = times();
        all[0].solver = "a<b".to_string();
        let svg = svg(&all, "seconds & more");
        assert_eq!(svg.matches("stroke-width=\"2\"").count(), 2);
        assert!(svg.contains("a&lt;b 3/4") && svg.contains("seconds &amp; more"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}
