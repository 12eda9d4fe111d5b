//! Euler–Bernoulli beams that meet an obstacle.
//!
//! EI w'''' = q − reaction, w ≤ g: deflection w and load q > 0 towards the obstacle at distance g, per unit thickness when
//! EI is (E h³/12 for a strip of height h in plane stress). Elementary (S. Timoshenko, Strength of Materials, 1940).
//!
//! Both ends clamped over a flat obstacle: first contact at q1 = 384EIg/L⁴ in the middle, contact along a line beyond
//! q2 = 3 q1; each free span s is then clamped at one end and lies flat (w' = w'' = 0) at the other,
//!
//! ```text
//!   w = q/(24EI) (x⁴ − (8/3) s x³ + 2 s² x²),   w(s) = q s⁴/(72EI) = g
//! ```
//!
//! so that each edge of the contact bears the force qs/3, with the uniform reaction q between them.
//! A cantilever with a stop at its tip: R = 3qL/8 − 3EIg/L³ for a uniform load, R = P − 3EIg/L³ for a tip load.

/// A beam clamped at both ends, uniformly loaded, over a flat obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampedOverObstacle {
    /// Bending stiffness EI.
    pub stiffness: f64,
    /// Length L.
    pub length: f64,
    /// Distance g of the obstacle.
    pub gap: f64,
}

impl ClampedOverObstacle {
    /// Load q1 of the first contact, in the middle.
    pub fn first_contact_load(&self) -> f64 {
        384.0 * self.stiffness * self.gap / self.length.powi(4)
    }

    /// Load q2 beyond which the beam lies on the obstacle along a line.
    pub fn line_contact_load(&self) -> f64 {
        3.0 * self.first_contact_load()
    }

    /// Length s of each free span under a load q > q2.
    pub fn free_span(&self, load: f64) -> f64 {
        (72.0 * self.stiffness * self.gap / load).powf(0.25)
    }

    /// Concentrated reaction at each edge of the contact under a load q > q2.
    pub fn edge_force(&self, load: f64) -> f64 {
        load * self.free_span(load) / 3.0
    }

    /// Shear force at each clamp under a load q > q2.
    pub fn clamp_shear(&self, load: f64) -> f64 {
        2.0 * load * self.free_span(load) / 3.0
    }

    /// Magnitude of the clamping moment under a load q > q2.
    pub fn clamp_moment(&self, load: f64) -> f64 {
        load * self.free_span(load).powi(2) / 6.0
    }

    /// Deflection at x in [0, L] under a load q > q2.
    pub fn deflection(&self, load: f64, x: f64) -> f64 {
        let s = self.free_span(load);
        let x = x.min(self.length - x);
        if x >= s {
            return self.gap;
        }
        let shape = x * x * (x * x - 8.0 / 3.0 * s * x + 2.0 * s * s);
        load / (24.0 * self.stiffness) * shape
    }
}

/// A cantilever clamped at x = 0 under a uniform load and a tip load, with a stop at distance g under its tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CantileverOnStop {
    /// Bending stiffness EI.
    pub stiffness: f64,
    /// Length L.
    pub length: f64,
    /// Uniform load q.
    pub load: f64,
    /// Load P at the tip.
    pub tip_load: f64,
    /// Distance g of the stop.
    pub gap: f64,
}

impl CantileverOnStop {
    /// Reaction R of the stop; zero when the tip does not reach it.
    pub fn reaction(&self) -> f64 {
        let l = self.length;
        let bilateral =
            0.375 * self.load * l + self.tip_load - 3.0 * self.stiffness * self.gap / l.powi(3);
        bilateral.max(0.0)
    }

    /// Deflection at x in [0, L].
    pub fn deflection(&self, x: f64) -> f64 {
        let l = self.length;
        let uniform = self.load * x * x * (6.0 * l * l - 4.0 * l * x + x * x) / 24.0;
        let tip = (self.tip_load - self.reaction()) * x * x * (3.0 * l - x) / 6.0;
        (uniform + tip) / self.stiffness
    }

    /// Bending moment at x, positive when the loaded face is in tension.
    pub fn moment(&self, x: f64) -> f64 {
        let arm = self.length - x;
        0.5 * self.load * arm * arm + (self.tip_load - self.reaction()) * arm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, derivative};

    const OVER: ClampedOverObstacle = ClampedOverObstacle {
        stiffness: 1.0,
        length: 1.0,
        gap: 0.01,
    };

    /// w', w'', w''', w'''' by differences; polynomials of degree four are differentiated to rounding.
    fn derivatives(w: &dyn Fn(f64) -> f64, x: f64, h: f64) -> [f64; 4] {
        let d1 = |t: f64| derivative(w, t, h);
        let d2 = |t: f64| derivative(d1, t, h);
        let d3 = |t: f64| derivative(d2, t, h);
        [d1(x), d2(x), d3(x), derivative(d3, x, h)]
    }

    #[test]
    fn the_free_span_is_a_loaded_beam_that_lands_flat() {
        let load = 30.0;
        let s = OVER.free_span(load);
        let w = |x: f64| OVER.deflection(load, x);
        close(s, 0.393598, 5e-7);
        let [.., fourth] = derivatives(&w, 0.5 * s, 5e-3);
        close(fourth, load, 1e-4);
        close(w(0.0), 0.0, 0.0);
        close(w(s * (1.0 - 1e-12)), OVER.gap, 1e-14);
        // One-sided limits at the landing, from the polynomial continued by its own Taylor series.
        let [slope, curvature, third, _] = derivatives(&w, 0.8 * s, 5e-3);
        let d = 0.2 * s;
        let landing_slope = slope + d * curvature + d * d / 2.0 * third + d.powi(3) / 6.0 * load;
        close(landing_slope, 0.0, 1e-7);
        close(curvature + d * third + d * d / 2.0 * load, 0.0, 1e-6);
        // Jump of the shear force at the landing, and its value and the moment at the clamp.
        close(third + d * load, OVER.edge_force(load), 1e-4);
        let [_, bend, shear, _] = derivatives(&w, 0.2 * s, 5e-3);
        close(-(shear - 0.2 * s * load), OVER.clamp_shear(load), 1e-4);
        let clamp = bend - 0.2 * s * shear + (0.2 * s).powi(2) / 2.0 * load;
        close(clamp, OVER.clamp_moment(load), 1e-5);
    }

    #[test]
    fn the_reactions_carry_the_load() {
        let load = 30.0;
        let inside = load * (OVER.length - 2.0 * OVER.free_span(load));
        let carried = inside + 2.0 * (OVER.edge_force(load) + OVER.clamp_shear(load));
        close(carried, load * OVER.length, 1e-12);
    }

    #[test]
    fn contact_begins_in_the_middle_and_spreads_when_the_spans_meet() {
        // A clamped beam without obstacle: w(L/2) = ∫∫ of the moment, by the polynomial q x²(L−x)²/24.
        let first = OVER.first_contact_load();
        close(first * 0.25f64.powi(2) / 24.0, OVER.gap, 1e-15);
        close(OVER.free_span(OVER.line_contact_load()), 0.5, 1e-15);
        close(OVER.line_contact_load(), 11.52, 1e-12);
    }

    #[test]
    fn the_cantilever_rests_on_its_stop() {
        let beam = CantileverOnStop {
            stiffness: 1e6,
            length: 40.0,
            load: 1.0,
            tip_load: 2.0,
            gap: 0.1,
        };
        let w = |x: f64| beam.deflection(x);
        close(w(40.0), 0.1, 1e-14);
        close(w(0.0), 0.0, 0.0);
        close(derivative(w, 0.0, 1.0), 0.0, 1e-15);
        let [_, second, third, fourth] = derivatives(&w, 40.0, 2.0);
        close(1e6 * second, 0.0, 1e-6);
        close(-1e6 * third, beam.tip_load - beam.reaction(), 1e-6);
        close(1e6 * fourth, beam.load, 1e-6);
        let [_, bend, ..] = derivatives(&w, 10.0, 2.0);
        close(1e6 * bend, beam.moment(10.0), 1e-6);
    }

    #[test]
    fn a_stop_out_of_reach_does_not_pull() {
        let beam = CantileverOnStop {
            stiffness: 1.0,
            length: 1.0,
            load: 1.0,
            tip_load: 0.0,
            gap: 1.0,
        };
        assert_eq!(beam.reaction(), 0.0);
        close(beam.deflection(1.0), 1.0 / 8.0, 1e-15);
    }
}
