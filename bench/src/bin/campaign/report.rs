//! The report of a campaign.

use crate::problem::Known;
use crate::run::{Result, Verdict};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// All results, counted.
pub struct Report<'a> {
    results: &'a [Result],
    seconds: f64,
    /// Name of the other method.
    method: &'a str,
}

/// Counts of one family.
#[derive(Default)]
struct Count {
    right: usize,
    wrong: usize,
    rightly_refused: usize,
    not_converged: usize,
    refused: usize,
    panicked: usize,
    slow: usize,
    /// Problems not converged or refused although statics shows that the contacts hold.
    holdable: usize,
}

impl<'a> Report<'a> {
    /// The report of results in the order of their seeds.
    pub fn new(results: &'a [Result], seconds: f64, method: &'a str) -> Self {
        Self {
            results,
            seconds,
            method,
        }
    }

    /// Every certified answer is right, and no run panics; with `answered` every seed has a right answer.
    pub fn clean(&self, answered: bool) -> bool {
        let good = |r: &Result| match r.verdict {
            Verdict::Right => true,
            Verdict::Wrong | Verdict::Panicked => false,
            _ => !answered,
        };
        self.results.iter().all(good)
    }

    /// Prints it.
    pub fn print(&self, margins: bool) {
        self.print_failures();
        self.print_families();
        self.print_kinds();
        self.print_iterations();
        self.print_stages();
        self.print_comparisons();
        if margins {
            self.print_margins();
        }
        self.print_seconds();
    }

    fn print_failures(&self) {
        for result in self.results {
            let kind = match result.verdict {
                Verdict::Wrong => "WRONG",
                Verdict::Panicked => "PANIC",
                _ => continue,
            };
            println!(
                "{kind} {:>6} {:<14} {}",
                result.seed, result.family, result.message
            );
        }
        for result in self.results {
            let lost = matches!(result.verdict, Verdict::NotConverged | Verdict::Refused);
            if lost && result.known == Known::Holds {
                println!(
                    "not converged {:>6} {:<14} {}",
                    result.seed, result.family, result.message
                );
            }
        }
        for result in self.results {
            if result.verdict == Verdict::Slow {
                println!(
                    "slow {:>6} {:<14} {}",
                    result.seed, result.family, result.message
                );
            }
            if result.verdict == Verdict::Refused && result.known == Known::Open {
                println!(
                    "refused {:>6} {:<14} {}",
                    result.seed, result.family, result.message
                );
            }
            if result.verdict == Verdict::NotConverged && result.known == Known::Open {
                println!(
                    "unknown, not converged {:>6} {:<14} {}",
                    result.seed, result.family, result.message
                );
            }
            if result.verdict == Verdict::Right && !result.message.is_empty() {
                println!(
                    "twin {:>6} {:<14} {}",
                    result.seed, result.family, result.message
                );
            }
        }
    }

    fn print_families(&self) {
        let mut counts: BTreeMap<&str, Count> = BTreeMap::new();
        for result in self.results {
            for name in [result.family, "~ all"] {
                let count = counts.entry(name).or_default();
                match result.verdict {
                    Verdict::Right => count.right += 1,
                    Verdict::Wrong => count.wrong += 1,
                    Verdict::RightlyRefused => count.rightly_refused += 1,
                    Verdict::NotConverged => count.not_converged += 1,
                    Verdict::Refused => count.refused += 1,
                    Verdict::Panicked => count.panicked += 1,
                    Verdict::Slow => count.slow += 1,
                }
                let lost = matches!(result.verdict, Verdict::NotConverged | Verdict::Refused);
                count.holdable += usize::from(lost && result.known == Known::Holds);
            }
        }
        println!(
            "\n{:<14} {:>7} {:>7} {:>15} {:>13} {:>8} {:>10} {:>5} {:>7}",
            "family",
            "right",
            "WRONG",
            "rightly refused",
            "not converged",
            "refused",
            "(holdable)",
            "slow",
            "panics"
        );
        for (name, c) in counts {
            println!(
                "{name:<14} {:>7} {:>7} {:>15} {:>13} {:>8} {:>10} {:>5} {:>7}",
                c.right,
                c.wrong,
                c.rightly_refused,
                c.not_converged,
                c.refused,
                c.holdable,
                c.slow,
                c.panicked
            );
        }
    }

    /// Wrong answers by check and family, each with the seed of the smallest one.
    fn print_kinds(&self) {
        let mut kinds: BTreeMap<(&str, bool, &str), Vec<&Result>> = BTreeMap::new();
        for result in self.results.iter().filter(|r| r.verdict == Verdict::Wrong) {
            let kind = (result.what, result.dropped, result.family);
            kinds.entry(kind).or_default().push(result);
        }
        if !kinds.is_empty() {
            println!(
                "\nwrong answers by check, and the smallest of each (`dropped`: the program warned that it dropped conditions)"
            );
        }
        for ((what, dropped, family), results) in kinds {
            let dropped = if dropped { "dropped" } else { "" };
            if let Some(least) = results.iter().min_by_key(|r| (r.dofs, r.seed)) {
                println!(
                    "{what:<14} {dropped:<8} {family:<14} {:>5}, seed {} ({} dofs)",
                    results.len(),
                    least.seed,
                    least.dofs
                );
            }
        }
    }

    fn print_iterations(&self) {
        for (name, rough, goal) in [("frictionless", false, 20), ("friction", true, 60)] {
            let mut families: BTreeMap<&str, Vec<(usize, u64)>> = BTreeMap::new();
            for result in self.results.iter().filter(|r| r.rough == rough) {
                for family in [result.family, "~ all"] {
                    let counts = result.iterations.iter().map(|&count| (count, result.seed));
                    families.entry(family).or_default().extend(counts);
                }
            }
            families.retain(|_, counts| !counts.is_empty());
            if families.is_empty() {
                continue;
            }
            println!(
                "\n{:<28} {:>7} {:>7} {:>6} {:>6} {:>7} {:>9}  most (seeds)",
                format!("iterations, {name}"),
                "steps",
                "median",
                "90 %",
                "99 %",
                "99.9 %",
                format!("over {goal}")
            );
            for (family, mut counts) in families {
                counts.sort_unstable();
                let at = |part: f64| counts[(part * (counts.len() - 1) as f64) as usize].0;
                let over = counts.iter().filter(|(count, _)| *count > goal).count();
                println!(
                    "{family:<28} {:>7} {:>7} {:>6} {:>6} {:>7} {over:>9}  {}",
                    counts.len(),
                    at(0.5),
                    at(0.9),
                    at(0.99),
                    at(0.999),
                    with_seeds(counts.iter().rev(), usize::to_string)
                );
            }
        }
        println!();
    }

    /// Which stage of the solver answered how many steps, in how many iterations, and the least seed of each.
    fn print_stages(&self) {
        for (name, rough) in [("frictionless", false), ("friction", true)] {
            let mut stages: BTreeMap<&str, (usize, usize, u64)> = BTreeMap::new();
            for result in self.results.iter().filter(|r| r.rough == rough) {
                for (&stage, &count) in result.answered.iter().zip(&result.iterations) {
                    let (steps, all, least) = stages.entry(stage).or_insert((0, 0, u64::MAX));
                    (*steps, *all) = (*steps + 1, *all + count);
                    *least = result.seed.min(*least);
                }
            }
            let mut stages: Vec<_> = stages.into_iter().collect();
            stages.sort_by_key(|(_, (steps, ..))| Reverse(*steps));
            for (stage, (steps, all, least)) in stages {
                println!(
                    "answered, {name}: {stage:<26} {steps:>7} steps {all:>8} iterations, seed {least}"
                );
            }
        }
        println!();
    }

    fn print_comparisons(&self) {
        let mut twins: BTreeMap<String, Vec<(f64, u64)>> = BTreeMap::new();
        for result in self.results {
            if let Some((name, off)) = result.twin {
                let law = if result.coulomb { " with friction" } else { "" };
                let name = format!("twins{law}, {name}");
                twins.entry(name).or_default().push((off, result.seed));
            }
        }
        for (name, offs) in twins {
            println!("{name}: {}", apart(offs));
        }
        let methods = self.results.iter();
        let methods: Vec<(f64, u64)> = methods.filter_map(|r| Some((r.method?, r.seed))).collect();
        if !methods.is_empty() {
            println!("method `{}`: {}", self.method, apart(methods));
        }
    }

    fn print_margins(&self) {
        let mut all: BTreeMap<&str, Vec<(f64, u64)>> = BTreeMap::new();
        for result in self.results.iter().filter(|r| r.verdict == Verdict::Right) {
            for (&what, &times) in &result.margins {
                all.entry(what).or_default().push((times, result.seed));
            }
        }
        println!("\nright answers, violations over their limits: median, 90 %, 99 %, most (seed)");
        for (what, mut list) in all {
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
            let at = |part: f64| list[(part * (list.len() - 1) as f64) as usize];
            let (most, seed) = at(1.0);
            println!(
                "{what:<14} {:>6} seeds {:>9.1e} {:>9.1e} {:>9.1e} {most:>9.1e} ({seed})",
                list.len(),
                at(0.5).0,
                at(0.9).0,
                at(0.99).0
            );
        }
    }

    fn print_seconds(&self) {
        let mut slow: Vec<&Result> = self.results.iter().collect();
        slow.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        let slowest: Vec<String> = slow
            .iter()
            .take(5)
            .map(|r| {
                format!(
                    "{} {} {:.1} s ({} dofs)",
                    r.seed, r.family, r.seconds, r.dofs
                )
            })
            .collect();
        println!("slowest: {}", slowest.join(", "));
        println!("{} seeds in {:.1} s", self.results.len(), self.seconds);
    }
}

/// Differences of pairs of answers that should be the same, in words; NaN stands for a missing answer.
fn apart(mut offs: Vec<(f64, u64)>) -> String {
    let lost = offs.iter().filter(|o| o.0.is_nan()).count();
    let asked = offs.len();
    offs.retain(|o| o.0 > 1e-6);
    offs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = with_seeds(offs.iter(), |off| format!("{off:.1e}"));
    format!(
        "{asked} asked, {lost} without an answer, {} apart by more than 1e-6 where they may be: {most}",
        offs.len()
    )
}

/// The first few numbers with the seeds of their problems.
fn with_seeds<'a, T: 'a>(
    list: impl Iterator<Item = &'a (T, u64)>,
    show: impl Fn(&T) -> String,
) -> String {
    let words = list
        .take(6)
        .map(|(x, seed)| format!("{} ({seed})", show(x)));
    words.collect::<Vec<_>>().join(", ")
}
