//! Capacity of a section of a lining, wall or beam: the N–M limit from strain compatibility with rectangular blocks.
//!
//! Form: EN 1992-1-1, 3.1.7 (3) (rectangular stress block) with 6.1 (plane sections, bars strained as the concrete beside
//! them); without bars and tension it is 12.6.1 there, M = N h/2 (1 − N/(h f_c)) of a compression N. Strengths are those
//! that the case gives: partial factors are the user's.
//!
//! ```text
//!   compressed edge at the strain 3.5e-3, neutral axis at x below it, x from 0 to ∞
//!   concrete:  −compression over the depth y = min(0.8 x, h),  +tension over h − y
//!   bar at d:  strain 3.5e-3 (1 − d/x) shortening, elastic up to its yield stress, which it keeps
//! ```
//!
//! With a tension strength the block of the other zone is that of fibre concrete (rigid-plastic, fib Model Code 2010, 5.6.4).
//! Neglected: the strain limit 2e-3 (1.75e-3) of the norm under uniform compression, so that all bars yield there, and the
//! concrete that bars displace. A bar yields at the strain 2.175e-3 (B500: 435 MPa over 200 GPa) unless its modulus is
//! given.
//!
//! Signs as of section forces: N > 0 tension, M > 0 tension on the first side; both per unit of thickness.

/// Strengths of a section, stresses; depths from the first side.
#[derive(Debug, Clone, PartialEq)]
pub struct Capacity {
    /// Compressive strength, > 0.
    pub compression: f64,
    /// Tensile strength, ≥ 0.
    pub tension: f64,
    /// Layers of bars.
    pub reinforcement: Vec<Reinforcement>,
}

/// A layer of bars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reinforcement {
    /// From the first side, within the section.
    pub depth: f64,
    /// Area per unit of thickness, > 0.
    pub area: f64,
    /// Yield stress, > 0.
    pub yields: f64,
    /// Young's modulus; `None`: it yields at the strain 2.175e-3.
    pub young: Option<f64>,
}

/// Strain of the compressed edge in the limit.
const CRUSHED: f64 = 3.5e-3;

/// Depth of the block over that of the neutral axis.
const BLOCK: f64 = 0.8;

/// Strain at which a bar yields, where its modulus is not given.
const YIELDS: f64 = 2.175e-3;

/// Steps of the bisections.
const CAPACITY_BISECTIONS: usize = 100;

impl Capacity {
    /// N and M of the limit, thickness h, the second side compressed (`second`) or the first, the neutral axis at
    /// x = h τ/(1 − τ), τ from 0 (tension alone) to 1 (compression alone).
    fn limit(&self, h: f64, tau: f64, second: bool) -> [f64; 2] {
        // h/x, infinite in pure tension
        let over = (1.0 - tau) / tau;
        let y = if BLOCK >= over { h } else { BLOCK / over * h };
        let sign = if second { 1.0 } else { -1.0 };
        let mut forces = [
            self.tension * (h - y) - self.compression * y,
            sign * 0.5 * (self.compression + self.tension) * y * (h - y),
        ];
        for bar in &self.reinforcement {
            let from_edge = if second { h - bar.depth } else { bar.depth };
            let strain = CRUSHED * (from_edge / h * over - 1.0);
            let modulus = bar.young.unwrap_or(bar.yields / YIELDS);
            let stress = match from_edge == 0.0 && !over.is_finite() {
                true => -bar.yields,
                false => (modulus * strain).clamp(-bar.yields, bar.yields),
            };
            forces[0] += bar.area * stress;
            forces[1] += bar.area * stress * (0.5 * h - bar.depth);
        }
        forces
    }

    /// The limit curve (N, M) of a section of thickness h, once around from tension alone; `points` on each half.
    pub fn curve(&self, h: f64, points: usize) -> Vec<[f64; 2]> {
        // even in the depth of the block, which is all of it from τ = 1/(1 + 0.8) on
        let half = |second: bool| {
            let taus = (0..=points).map(move |k| {
                let part = k as f64 / points as f64;
                let depth = part / BLOCK;
                depth / (1.0 + depth)
            });
            let rest = (1..=points / 4).map(move |k| {
                let full = 1.0 / (1.0 + BLOCK);
                full + (1.0 - full) * k as f64 / (points / 4) as f64
            });
            let taus: Vec<f64> = taus.chain(rest).collect();
            taus.into_iter()
                .map(move |tau| self.limit(h, tau, second))
                .collect::<Vec<_>>()
        };
        let mut all = half(true);
        all.extend(half(false).into_iter().rev());
        all
    }

    /// The moment of the limit at a normal force, one side compressed; `None` beyond tension or compression alone.
    fn moment(&self, h: f64, n: f64, second: bool) -> Option<f64> {
        let (mut low, mut high) = (0.0, 1.0);
        let ends = [self.limit(h, low, second), self.limit(h, high, second)];
        let tolerance = 1e-14 * (ends[0][0] - ends[1][0]);
        if n > ends[0][0] + tolerance || n < ends[1][0] - tolerance {
            return None;
        }
        for _ in 0..CAPACITY_BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.limit(h, middle, second)[0] >= n {
                low = middle;
            } else {
                high = middle;
            }
        }
        // between the last two N may still jump by a rounding: linear in between
        let [a, b] = [self.limit(h, low, second), self.limit(h, high, second)];
        let part = if a[0] > b[0] {
            ((a[0] - n) / (a[0] - b[0])).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Some(a[1] + part * (b[1] - a[1]))
    }

    fn bears(&self, h: f64, [n, m]: [f64; 2]) -> bool {
        let limits = [true, false].map(|second| self.moment(h, n, second));
        match limits {
            [Some(most), Some(least)] => least <= m && m <= most,
            _ => false,
        }
    }

    /// 1 over the largest factor on (N, M) that stays inside the limit of a section of thickness h, along the ray from the
    /// origin: 0 without forces, infinite where no point of the ray is inside.
    pub fn utilisation(&self, h: f64, n: f64, m: f64) -> f64 {
        let bars: f64 = self
            .reinforcement
            .iter()
            .map(|bar| bar.area * bar.yields)
            .sum();
        let most = (self.compression + self.tension) * h + bars;
        let size = n.abs().max(m.abs() / h);
        if size <= f64::EPSILON * most {
            return 0.0;
        }
        // no force is larger than `most`
        let (mut inside, mut outside) = (0.0, 2.0 * most / size);
        for _ in 0..CAPACITY_BISECTIONS {
            let factor = 0.5 * (inside + outside);
            if self.bears(h, [factor * n, factor * m]) {
                inside = factor;
            } else {
                outside = factor;
            }
        }
        match inside * size <= 1e-12 * most {
            true => f64::INFINITY,
            false => 1.0 / inside,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Capacity = Capacity {
        compression: 20.0,
        tension: 0.0,
        reinforcement: Vec::new(),
    };

    #[test]
    fn the_plain_rectangle_is_a_parabola() {
        let h = 0.3;
        for part in [0.05, 0.3, 0.5, 0.8, 0.99] {
            // compression positive, as in the closed form
            let n = part * h * PLAIN.compression;
            let limit = 0.5 * n * h * (1.0 - n / (h * PLAIN.compression));
            for sign in [1.0, -1.0] {
                let full = PLAIN.utilisation(h, -n, sign * limit);
                assert!((full - 1.0).abs() < 1e-9, "{part}: {full}");
            }
        }
        // along the ray of an eccentricity e the limit is N = f h (1 − 2e/h)
        let (e, n) = (0.05, 1.0);
        let limit = PLAIN.compression * h * (1.0 - 2.0 * e / h);
        assert!((PLAIN.utilisation(h, -n, e * n) - n / limit).abs() < 1e-9);
        assert!((PLAIN.utilisation(h, -3.0, 0.0) - 0.5).abs() < 1e-9);
        assert_eq!(PLAIN.utilisation(h, 0.0, 0.0), 0.0);
        // neither tension nor a moment alone is borne, nor a force beyond the edge
        for [n, m] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.51 * h]] {
            assert_eq!(PLAIN.utilisation(h, n, m), f64::INFINITY);
        }
    }

    #[test]
    fn two_blocks_bear_what_plasticity_says() {
        let (h, c, t) = (0.4, 30.0, 3.0);
        let fibres = Capacity {
            compression: c,
            tension: t,
            reinforcement: Vec::new(),
        };
        // bending alone: c y = t (h − y)
        let y = t * h / (c + t);
        let moment = c * y * 0.5 * h;
        assert!((fibres.utilisation(h, 0.0, moment) - 1.0).abs() < 1e-9);
        assert!((fibres.utilisation(h, t * h, 0.0) - 1.0).abs() < 1e-9);
        assert!((fibres.utilisation(h, -2.0 * c * h, 0.0) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn bars_bend_as_the_textbook_says() {
        // singly reinforced, tension at the second side: A f = c·0.8x, M = A f (d − 0.4 x), the bar yields
        let (h, d, c) = (0.5, 0.45, 20.0);
        let bar = Reinforcement {
            depth: d,
            area: 1e-3,
            yields: 435.0,
            young: Some(200e3),
        };
        let section = Capacity {
            compression: c,
            tension: 0.0,
            reinforcement: vec![bar],
        };
        let x = bar.area * bar.yields / (c * 0.8);
        assert!(CRUSHED * (d / x - 1.0) > bar.yields / 200e3);
        let moment = bar.area * bar.yields * (d - 0.4 * x);
        assert!((section.utilisation(h, 0.0, -moment) - 1.0).abs() < 1e-9);
        // tension alone at the level of the bar, compression alone with the block over all
        let n = bar.area * bar.yields;
        assert!((section.utilisation(h, n, n * (0.5 * h - d)) - 1.0).abs() < 1e-6);
        let all = section.limit(h, 1.0, true);
        assert!((all[0] + c * h + n).abs() < 1e-12);
        // the balanced section: the bar begins to yield as the edge is crushed
        let x = d / (1.0 + 435.0 / 200e3 / CRUSHED);
        let balanced = [
            n - c * 0.8 * x,
            -(c * 0.8 * x * (0.5 * h - 0.4 * x) + n * (d - 0.5 * h)),
        ];
        assert!((section.utilisation(h, balanced[0], balanced[1]) - 1.0).abs() < 1e-9);
        // turned over, the same
        let over = Capacity {
            reinforcement: vec![Reinforcement {
                depth: h - d,
                ..bar
            }],
            ..section
        };
        assert!((over.utilisation(h, 0.0, moment) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_curve_is_closed_and_on_the_limit() {
        let bar = |depth: f64| Reinforcement {
            depth,
            area: 5e-4,
            yields: 435.0,
            young: None,
        };
        let section = Capacity {
            reinforcement: vec![bar(0.05), bar(0.25)],
            ..PLAIN
        };
        let curve = section.curve(0.3, 40);
        let [first, last] = [curve[0], curve[curve.len() - 1]];
        assert!((0..2).all(|i| (first[i] - last[i]).abs() < 1e-12));
        for [n, m] in curve {
            let full = section.utilisation(0.3, n, m);
            assert!((full - 1.0).abs() < 1e-6, "{n} {m}: {full}");
        }
    }
}
