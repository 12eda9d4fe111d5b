//! Gaskets: what lies in a contact is compressed, and presses by its closure alone.
//!
//! ```text
//!   loading      p = f(c), the table of pressure over closure, linear between its points and along its last line beyond them
//!   unloading    p = k (c − c₀) from the largest pressure so far on, and again as far as it; c₀ the closure that stays without pressure
//!   parted       p = 0 below c₀: a gasket does not pull
//! ```
//!
//! f grows from (0, 0) on, and k is nowhere less than its slope, so that c₀ never falls. Without k it unloads along f.
//! The inverse is a closure c = α + β p in each of some branches of p: that of unloading, then the lines of the table beyond the largest pressure
//! so far.

use std::fmt;

/// The law of a gasket.
#[derive(Debug, Clone, PartialEq)]
pub struct Gasket {
    /// Closures, a length, growing from 0 on; at least two.
    pub closure: Vec<f64>,
    /// The pressure at each, a stress, growing from 0 on.
    pub pressure: Vec<f64>,
    /// Pressure over closure when it is unloaded, stress per length; `None`: it unloads along the table.
    pub unloading: Option<f64>,
}

/// Why a gasket has no law.
#[derive(Debug, Clone, PartialEq)]
pub enum GasketError {
    /// Lists of different lengths, or too short.
    Lengths([usize; 2]),
    /// One of the lists does not begin at 0, or does not grow, at this place.
    Grows(&'static str, usize),
    /// It unloads less steeply than the table.
    Flat {
        /// Its unloading.
        unloading: f64,
        /// The steepest line of the table.
        steepest: f64,
    },
}

impl fmt::Display for GasketError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lengths([closures, pressures]) => write!(
                f,
                "a gasket has a pressure for each closure, and at least two: it has {closures} closures and {pressures} pressures"
            ),
            Self::Grows(list, 0) => write!(f, "`{list}` of a gasket begins with 0"),
            Self::Grows(list, place) => write!(
                f,
                "`{list}` of a gasket grows from number to number: number {} does not",
                place + 1
            ),
            Self::Flat {
                unloading,
                steepest,
            } => write!(
                f,
                "`unloading` of a gasket is {unloading}, and its table is as steep as {steepest}: it is at least as steep"
            ),
        }
    }
}

/// A line of the law: closure = `set` + `softness` · pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Branch {
    /// 0: unloading; k: line k of the table.
    pub id: usize,
    /// Pressures from which and up to which it holds.
    pub low: f64,
    pub high: f64,
    /// Closure without a pressure, on the line.
    pub set: f64,
    /// Length per stress.
    pub softness: f64,
}

/// It unloads along its table if it does so no more steeply than this above it.
const STEEPER: f64 = 1.0 + 1e-9;

impl Gasket {
    /// Errors: lists that are no law.
    pub fn check(&self) -> Result<(), GasketError> {
        let lengths = [self.closure.len(), self.pressure.len()];
        if lengths[0] != lengths[1] || lengths[0] < 2 {
            return Err(GasketError::Lengths(lengths));
        }
        for (name, list) in [("closure", &self.closure), ("pressure", &self.pressure)] {
            if list[0] != 0.0 {
                return Err(GasketError::Grows(name, 0));
            }
            let wrong = |pair: &[f64]| !(pair[1] > pair[0] && pair[1].is_finite());
            if let Some(place) = list.windows(2).position(wrong) {
                return Err(GasketError::Grows(name, place + 1));
            }
        }
        let steepest = (0..self.lines()).map(|k| self.slope(k)).fold(0.0, f64::max);
        match self.unloading {
            Some(unloading) if !(unloading * STEEPER >= steepest && unloading.is_finite()) => {
                Err(GasketError::Flat {
                    unloading,
                    steepest,
                })
            }
            _ => Ok(()),
        }
    }

    /// Number of lines of the table.
    fn lines(&self) -> usize {
        self.closure.len() - 1
    }

    fn slope(&self, line: usize) -> f64 {
        let rise = self.pressure[line + 1] - self.pressure[line];
        rise / (self.closure[line + 1] - self.closure[line])
    }

    /// Closure on the table at a pressure ≥ 0.
    fn loading(&self, pressure: f64) -> f64 {
        let line = self.pressure[1..self.lines()].partition_point(|&p| p < pressure);
        self.closure[line] + (pressure - self.pressure[line]) / self.slope(line)
    }

    /// The closure that stays after a pressure ≥ 0 on the table.
    pub(crate) fn set_by(&self, pressure: f64) -> f64 {
        match self.unloading {
            Some(k) => (self.loading(pressure) - pressure / k).max(0.0),
            None => 0.0,
        }
    }

    /// The largest pressure that leaves a set behind: the branch of unloading ends there.
    fn yields_at(&self, set: f64) -> f64 {
        let Some(k) = self.unloading else {
            return 0.0;
        };
        for line in 0..self.lines() {
            let before = self.closure[line] - self.pressure[line] / k;
            let grows = 1.0 / self.slope(line) - 1.0 / k;
            let more = (set - before).max(0.0);
            let last = line + 1 == self.lines();
            let end = if last {
                f64::INFINITY
            } else {
                self.pressure[line + 1]
            };
            // lines as steep as unloading leave nothing behind
            let reach = match grows > (STEEPER - 1.0) / k {
                true => self.pressure[line] + more / grows,
                false => end,
            };
            if reach < end || last {
                return reach;
            }
        }
        0.0
    }

    /// The branches of a gasket on which this set has stayed, by growing pressure.
    pub(crate) fn branches(&self, set: f64) -> Vec<Branch> {
        let yields = self.yields_at(set);
        let unloading = self.unloading.filter(|_| yields > 0.0);
        let unloading = unloading.map(|k| Branch {
            id: 0,
            low: 0.0,
            high: yields,
            set,
            softness: 1.0 / k,
        });
        let lines = (0..self.lines()).filter_map(|line| {
            let last = line + 1 == self.lines();
            let high = if last {
                f64::INFINITY
            } else {
                self.pressure[line + 1]
            };
            let low = self.pressure[line].max(yields);
            let softness = 1.0 / self.slope(line);
            (low < high).then_some(Branch {
                id: line + 1,
                low,
                high,
                set: self.closure[line] - self.pressure[line] * softness,
                softness,
            })
        });
        unloading.into_iter().chain(lines).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gasket(unloading: Option<f64>) -> Gasket {
        Gasket {
            closure: vec![0.0, 1.0, 2.0, 4.0],
            pressure: vec![0.0, 10.0, 40.0, 60.0],
            unloading,
        }
    }

    #[test]
    fn branches_are_one_curve() {
        for unloading in [None, Some(30.0), Some(100.0)] {
            let law = gasket(unloading);
            law.check().unwrap();
            let mut before = 0.0;
            for most in [0.0, 3.0, 10.0, 25.0, 40.0, 55.0, 90.0] {
                let set = law.set_by(most);
                assert!(set >= before - 1e-15, "{unloading:?} {most}");
                before = set;
                let branches = law.branches(set);
                assert_eq!(
                    (branches[0].low, branches[branches.len() - 1].high),
                    (0.0, f64::INFINITY)
                );
                for pair in branches.windows(2) {
                    assert_eq!(pair[0].high, pair[1].low);
                    let at = |b: &Branch| b.set + b.softness * pair[0].high;
                    assert!((at(&pair[0]) - at(&pair[1])).abs() < 1e-12, "{pair:?}");
                }
                // it comes back from the largest pressure, each way
                for part in [0.0, 0.4, 1.0] {
                    let p = part * most;
                    let own = branches.iter().find(|b| p <= b.high).unwrap();
                    let law = match unloading {
                        Some(k) => law.loading(most) - (most - p) / k,
                        None => law.loading(p),
                    };
                    let found = own.set + own.softness * p;
                    assert!((found - law).abs() < 1e-12, "{most} {p}: {found} {law}");
                }
                // loading goes on along the table
                let last = branches[branches.len() - 1];
                assert!((last.set + last.softness * 80.0 - law.loading(80.0)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn what_is_no_law_is_refused() {
        let with = |change: &dyn Fn(&mut Gasket)| {
            let mut law = gasket(Some(30.0));
            change(&mut law);
            law.check().unwrap_err().to_string()
        };
        for (found, word) in [
            (with(&|g| g.closure = vec![0.0]), "1 closures and 4"),
            (with(&|g| g.closure[0] = 0.1), "begins with 0"),
            (with(&|g| g.pressure[2] = 10.0), "number 3"),
            (with(&|g| g.pressure[3] = f64::NAN), "number 4"),
            (with(&|g| g.unloading = Some(29.0)), "as steep as 30"),
            (with(&|g| g.unloading = Some(f64::NAN)), "as steep as 30"),
        ] {
            assert!(found.contains(word), "{found}");
        }
    }
}
