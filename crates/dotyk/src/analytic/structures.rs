//! Beams, rings, arches, bolts and joints by statics and the theory of bars.
//!
//! **Beam on springs** (M. Hetényi, Beams on Elastic Foundation, 1946): EI w'''' + k w = 0 except at the force P, which acts
//! along w > 0. Solutions are waves e^{−βs}(A cos βs + B sin βs), β⁴ = k/(4EI); the infinite beam has A = B = Pβ/(2k).
//! A beam with free ends has additional waves from either end, such that M and V vanish there.
//! M = −EI w'' is positive where the side away from the force is in tension, V = M'.
//!
//! **Pinched ring** (S. Timoshenko, Strength of Materials II, 1941): a thin ring of radius R between two opposite forces F.
//! φ is counted from a force; N = F/2 sin φ, V = F/2 cos φ, M = FR(1/π − sin φ/2), where M makes the rotation over a quarter vanish.
//!
//! **Three-hinged arch**: statics alone.
//!
//! **Grouted bolt** (shear lag, H. L. Cox, Brit. J. Appl. Phys. 3 (1952) 72–79; for bolts as described by I. W. Farmer, Int. J.
//! Rock Mech. Min. Sci. 12 (1975) 347–351): EA u'' = k (u − g), g the displacement of the ground along the bolt, k the force
//! per length and slip of the bond; forces die away over ℓ = √(EA/k).
//!
//! **Bolted joint** (VDI 2230, the load introduced under the head): springs k_b of the bolt and k_p of the plates share the load F in
//! the ratio Φ : 1 − Φ, Φ = k_b/(k_b + k_p), until the plates part at F_V/(1 − Φ).
//!
//! **Joint between segments** (F. Leonhardt, H. Reimann 1965 and P. Janssen 1983, as described in the literature on
//! segmental linings): a face of height h that bears no tension, on zones of depth h that are strained uniformly along
//! their depth. With N > 0 in compression, m = |M|/(Nh):
//!
//! ```text
//!   closed, m ≤ 1/6:        φ = 12 M / (E h²)
//!   open, 1/6 < m < 1/2:    φ = 8 N / (9 E h (1 − 2m)²),   contact over 3h(1/2 − m)
//! ```
//!
//! N is positive in compression throughout; V and M as stated at each. Units: any consistent ones; joints are per unit width.

use crate::analytic::{SectionForces, solve};
use crate::geometry::Point;
use std::f64::consts::PI;

/// Deflection and section forces of a beam at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamState {
    /// w, along the force.
    pub deflection: f64,
    /// w'.
    pub slope: f64,
    /// M = −EI w'', positive where the side away from the force is in tension.
    pub moment: f64,
    /// V = M'.
    pub shear: f64,
}

/// A beam on springs without end, or with free ends at x = 0 and x = L.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WinklerBeam {
    /// Bending stiffness EI; E/(1−ν²) in plane strain.
    pub stiffness: f64,
    /// k: force of the springs per length and deflection.
    pub foundation: f64,
}

impl WinklerBeam {
    /// β = (k/4EI)^¼, per length.
    pub fn wave_number(&self) -> f64 {
        (0.25 * self.foundation / self.stiffness).powf(0.25)
    }

    /// The infinite beam at the distance x from a force.
    pub fn infinite(&self, force: f64, x: f64) -> BeamState {
        self.state(self.under_force(force, x))
    }

    /// A beam with free ends at 0 and `length` under a force at `place`, at x. All within [0, `length`].
    pub fn finite(&self, length: f64, force: f64, place: f64, x: f64) -> BeamState {
        let beta = self.wave_number();
        // Waves from both ends, each with its cosine and its sine.
        let waves = |at: f64| {
            let from =
                |amplitudes, distance: f64, side: f64| wave(amplitudes, beta, distance, side);
            [
                from([1.0, 0.0], at, 1.0),
                from([0.0, 1.0], at, 1.0),
                from([1.0, 0.0], length - at, -1.0),
                from([0.0, 1.0], length - at, -1.0),
            ]
        };
        let ends = [0.0, length].map(|at| (waves(at), self.under_force(force, at - place)));
        // w'' = w''' = 0 at both ends, in units of β.
        let conditions = [(0, 2), (0, 3), (1, 2), (1, 3)];
        let matrix = conditions.map(|(end, order)| {
            let scale = beta.powi(order as i32);
            ends[end].0.map(|w: [f64; 4]| w[order] / scale)
        });
        let right = conditions.map(|(end, order)| -ends[end].1[order] / beta.powi(order as i32));
        let amplitudes = solve(matrix, right);

        let mut sum = self.under_force(force, x - place);
        for (amplitude, wave) in amplitudes.into_iter().zip(waves(x)) {
            for (total, part) in sum.iter_mut().zip(wave) {
                *total += amplitude * part;
            }
        }
        self.state(sum)
    }

    /// w and its derivatives at the distance x from a force on the infinite beam.
    fn under_force(&self, force: f64, x: f64) -> [f64; 4] {
        let beta = self.wave_number();
        let amplitude = 0.5 * force * beta / self.foundation;
        wave(
            [amplitude; 2],
            beta,
            x.abs(),
            if x < 0.0 { -1.0 } else { 1.0 },
        )
    }

    fn state(&self, [deflection, slope, second, third]: [f64; 4]) -> BeamState {
        BeamState {
            deflection,
            slope,
            moment: -self.stiffness * second,
            shear: -self.stiffness * third,
        }
    }
}

/// e^{−βs}(A cos βs + B sin βs) and its derivatives with respect to x, ds/dx = ±1.
fn wave([mut cosine, mut sine]: [f64; 2], beta: f64, s: f64, direction: f64) -> [f64; 4] {
    let decay = (-beta * s).exp();
    let (sin, cos) = (beta * s).sin_cos();
    let mut scale = 1.0;
    std::array::from_fn(|_| {
        let value = scale * decay * (cosine * cos + sine * sin);
        (cosine, sine) = (sine - cosine, -cosine - sine);
        scale *= beta * direction;
        value
    })
}

/// A thin ring pinched by two opposite forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinchedRing {
    /// Radius R of its middle line.
    pub radius: f64,
    /// Bending stiffness EI; E/(1−ν²) in plane strain.
    pub stiffness: f64,
    /// F > 0 pushes inward on both sides.
    pub force: f64,
}

impl PinchedRing {
    /// N, V and M at the angle φ in [0, π] from a force. M is positive where the inner fibre is in tension, V where the part
    /// behind the cut (at smaller φ) is pushed outward.
    pub fn section(&self, angle: f64) -> SectionForces {
        let (sine, cosine) = angle.sin_cos();
        SectionForces {
            normal: 0.5 * self.force * sine,
            shear: 0.5 * self.force * cosine,
            moment: self.force * self.radius * (1.0 / PI - 0.5 * sine),
        }
    }

    /// Shortening of the diameter between the forces: (π² − 8)/(4π) FR³/EI, bending alone.
    pub fn shortening(&self) -> f64 {
        (PI * PI - 8.0) / (4.0 * PI) * self.scale()
    }

    /// Lengthening of the diameter across: (4 − π)/(2π) FR³/EI.
    pub fn widening(&self) -> f64 {
        (4.0 - PI) / (2.0 * PI) * self.scale()
    }

    fn scale(&self) -> f64 {
        self.force * self.radius.powi(3) / self.stiffness
    }
}

/// An arch with a hinge at each support and one between; its axis goes from left to right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreeHingedArch {
    /// Left support.
    pub left: Point<2>,
    /// The hinge between.
    pub crown: Point<2>,
    /// Right support.
    pub right: Point<2>,
}

/// A force [Fx, Fy] that acts at a point of the arch.
pub type PointForce = (Point<2>, [f64; 2]);

impl ThreeHingedArch {
    /// Reactions [Fx, Fy] of the left and the right support. A load belongs to the half on its side of the crown, one at the
    /// crown itself to either.
    pub fn reactions(&self, loads: &[PointForce]) -> [[f64; 2]; 2] {
        let sum = |i: usize| loads.iter().map(|(_, force)| force[i]).sum::<f64>();
        let about = |pole: Point<2>, loads: &mut dyn Iterator<Item = &PointForce>| {
            loads
                .map(|&(at, force)| moment(at, pole, force))
                .sum::<f64>()
        };
        let all = about(self.left, &mut loads.iter());
        let half = about(
            self.crown,
            &mut loads.iter().filter(|(at, _)| at[0] < self.crown[0]),
        );
        let span = [self.right[0] - self.left[0], self.right[1] - self.left[1]];
        let arm = [self.left[0] - self.crown[0], self.left[1] - self.crown[1]];
        let [lx, ly, rx, ry] = solve(
            [
                [1.0, 0.0, 1.0, 0.0],
                [0.0, 1.0, 0.0, 1.0],
                [0.0, 0.0, -span[1], span[0]],
                [-arm[1], arm[0], 0.0, 0.0],
            ],
            [-sum(0), -sum(1), -all, -half],
        );
        [[lx, ly], [rx, ry]]
    }

    /// N, V and M at a point of the axis with the unit tangent t (left to right). V > 0 pushes the part ahead to the left of
    /// t, M > 0 has that side, the extrados, in tension. Loads at smaller x act behind the cut.
    pub fn section(
        &self,
        point: Point<2>,
        tangent: [f64; 2],
        loads: &[PointForce],
    ) -> SectionForces {
        let [reaction, _] = self.reactions(loads);
        let behind = loads.iter().copied().filter(|(at, _)| at[0] < point[0]);
        let (mut force, mut couple) = ([0.0; 2], 0.0);
        for (at, acting) in std::iter::once((self.left, reaction)).chain(behind) {
            force = [force[0] + acting[0], force[1] + acting[1]];
            couple += moment(at, point, acting);
        }
        SectionForces {
            normal: force[0] * tangent[0] + force[1] * tangent[1],
            shear: force[1] * tangent[0] - force[0] * tangent[1],
            moment: couple,
        }
    }
}

/// Moment of a force about a pole, counterclockwise.
fn moment(at: Point<2>, pole: Point<2>, force: [f64; 2]) -> f64 {
    (at[0] - pole[0]) * force[1] - (at[1] - pole[1]) * force[0]
}

/// A bolt tied along its length to the ground by a bond with a force proportional to the slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroutedBolt {
    /// Axial stiffness EA.
    pub stiffness: f64,
    /// k: force per length and slip.
    pub bond: f64,
    /// Length L.
    pub length: f64,
}

impl GroutedBolt {
    /// ℓ = √(EA/k).
    pub fn transfer_length(&self) -> f64 {
        (self.stiffness / self.bond).sqrt()
    }

    /// Tension at the distance x from the head of a bolt that is pulled there by `force` out of ground at rest.
    pub fn pulled(&self, force: f64, x: f64) -> f64 {
        let l = self.transfer_length();
        force * ((self.length - x) / l).sinh() / (self.length / l).sinh()
    }

    /// Displacement of the head: F ℓ/(EA) coth(L/ℓ).
    pub fn pull_out(&self, force: f64) -> f64 {
        let l = self.transfer_length();
        force * l / (self.stiffness * (self.length / l).tanh())
    }

    /// Tension at the distance x from one end, in ground that is strained by `strain` along the bolt.
    pub fn in_strained_ground(&self, strain: f64, x: f64) -> f64 {
        let l = self.transfer_length();
        let middle = 0.5 * self.length;
        self.stiffness * strain * (1.0 - ((x - middle) / l).cosh() / (middle / l).cosh())
    }

    /// Tension at the distance x from one end of a bolt whose middle crosses a joint that opens by `opening`; the ground
    /// on both sides of it is rigid.
    pub fn across_joint(&self, opening: f64, x: f64) -> f64 {
        let l = self.transfer_length();
        let middle = 0.5 * self.length;
        let from_end = x.min(self.length - x);
        0.5 * self.stiffness * opening / l * (from_end / l).sinh() / (middle / l).cosh()
    }
}

/// Plates that a bolt presses together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoltedJoint {
    /// k_b: tension of the bolt over its elongation.
    pub bolt: f64,
    /// k_p: force over the shortening of the plates.
    pub plates: f64,
    /// F_V: tension of the bolt before the load.
    pub preload: f64,
}

impl BoltedJoint {
    /// Φ = k_b/(k_b + k_p): share of the load that the bolt takes while the plates touch.
    pub fn load_factor(&self) -> f64 {
        self.bolt / (self.bolt + self.plates)
    }

    /// The load F_V/(1 − Φ) at which the plates part.
    pub fn separation(&self) -> f64 {
        self.preload / (1.0 - self.load_factor())
    }

    /// Tension of the bolt under the load F that pulls the plates apart.
    pub fn bolt_force(&self, load: f64) -> f64 {
        load.max(self.preload + self.load_factor() * load)
    }

    /// Force between the plates.
    pub fn clamping(&self, load: f64) -> f64 {
        self.bolt_force(load) - load
    }
}

/// A dry joint between two segments of a lining, per unit width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentJoint {
    /// Young's modulus of the segments; E/(1−ν²) in plane strain.
    pub young: f64,
    /// Height h of the face.
    pub height: f64,
}

impl SegmentJoint {
    /// N h/6: the moment beyond which the joint opens. N > 0 is compression.
    pub fn opening_moment(&self, normal: f64) -> f64 {
        normal * self.height / 6.0
    }

    /// Height of the face in contact under N > 0 and M; NaN from |M| = N h/2 on, which no face can bear.
    pub fn contact_height(&self, normal: f64, moment: f64) -> f64 {
        let eccentricity = moment.abs() / normal;
        if moment.abs() <= self.opening_moment(normal) {
            self.height
        } else if eccentricity < 0.5 * self.height {
            3.0 * (0.5 * self.height - eccentricity)
        } else {
            f64::NAN
        }
    }

    /// Rotation φ of the segments against one another, of the sign of M.
    pub fn rotation(&self, normal: f64, moment: f64) -> f64 {
        let (e, h) = (self.young, self.height);
        if moment.abs() <= self.opening_moment(normal) {
            return 12.0 * moment / (e * h * h);
        }
        let contact = self.contact_height(normal, moment);
        moment.signum() * 2.0 * normal * h / (e * contact * contact)
    }

    /// The moment at a rotation φ under N > 0.
    pub fn moment(&self, normal: f64, rotation: f64) -> f64 {
        let (e, h) = (self.young, self.height);
        let closed = e * h * h * rotation / 12.0;
        if closed.abs() <= self.opening_moment(normal) {
            return closed;
        }
        let open = (2.0 * normal / (e * h * rotation.abs())).sqrt();
        rotation.signum() * normal * h * (0.5 - open / 3.0)
    }

    /// M/φ: E h²/12 while closed, less when open.
    pub fn stiffness(&self, normal: f64, moment: f64) -> f64 {
        if moment.abs() <= self.opening_moment(normal) {
            return self.young * self.height * self.height / 12.0;
        }
        moment / self.rotation(normal, moment)
    }
}

/// The moment N h/2 (1 − N/(h f)) that a plain rectangle of height h bears with N > 0, without tension, on a block of
/// constant stress f; per unit width. Negative beyond N = h f.
pub fn plain_section_moment(normal: f64, height: f64, strength: f64) -> f64 {
    0.5 * normal * height * (1.0 - normal / (height * strength))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, derivative, integral};
    use std::f64::consts::FRAC_PI_2;

    const BEAM: WinklerBeam = WinklerBeam {
        stiffness: 3.0,
        foundation: 0.8,
    };

    #[test]
    fn the_springs_carry_the_beam_and_its_force() {
        let (length, force, place) = (7.0, 2.5, 2.1);
        let at = |x: f64| BEAM.finite(length, force, place, x);
        for x in [0.4, 1.7, 3.0, 6.6] {
            let here = at(x);
            close(derivative(|x| at(x).deflection, x, 1e-3), here.slope, 1e-10);
            let bend = derivative(|x| at(x).slope, x, 1e-3);
            close(-3.0 * bend, here.moment, 1e-9);
            close(derivative(|x| at(x).moment, x, 1e-3), here.shear, 1e-9);
            // EI w'''' = −V' = −k w.
            let reaction = derivative(|x| at(x).shear, x, 1e-3);
            close(reaction, 0.8 * here.deflection, 1e-9);
        }
        for end in [0.0, length] {
            close(at(end).moment, 0.0, 1e-12);
            close(at(end).shear, 0.0, 1e-12);
        }
        close(
            at(place - 1e-12).shear - at(place + 1e-12).shear,
            force,
            1e-9,
        );
        let springs = |from, to| integral(|x| 0.8 * at(x).deflection, from, to, 2000);
        close(springs(0.0, place) + springs(place, length), force, 1e-5);
    }

    #[test]
    fn a_beam_under_a_force_in_its_middle_is_that_of_hetenyi() {
        // Hetényi, section 19: Pβ/2k (2 + cosh βl + cos βl)/(sinh βl + sin βl), ends 2Pβ/k cosh cos /(...), moment.
        let (length, force) = (5.0, 2.0);
        let beta = BEAM.wave_number();
        let l = beta * length;
        let below = l.sinh() + l.sin();
        let middle = BEAM.finite(length, force, 2.5, 2.5);
        let exact = force * beta / (2.0 * 0.8) * (2.0 + l.cosh() + l.cos()) / below;
        close(middle.deflection, exact, 1e-13);
        close(
            middle.moment,
            force / (4.0 * beta) * (l.cosh() - l.cos()) / below,
            1e-13,
        );
        let end = BEAM.finite(length, force, 2.5, 0.0).deflection;
        let half = 0.5 * l;
        close(
            end,
            2.0 * force * beta / 0.8 * half.cosh() * half.cos() / below,
            1e-13,
        );
    }

    #[test]
    fn far_ends_are_not_felt_and_a_short_beam_is_rigid() {
        for x in [-2.0, 0.0, 3.0] {
            let infinite = BEAM.infinite(1.0, x);
            let long = BEAM.finite(200.0, 1.0, 100.0, 100.0 + x);
            close(infinite.deflection, long.deflection, 1e-15);
            close(infinite.moment, long.moment, 1e-13);
            close(infinite.shear, long.shear, 1e-13);
        }
        close(
            BEAM.infinite(1.0, 0.0).moment,
            0.25 / BEAM.wave_number(),
            1e-15,
        );
        // A rigid beam of length 1: w = P/k (1 + 12 e (x − 1/2)), to (βL)⁴ = 6e-9.
        let rigid = WinklerBeam {
            stiffness: 3e7,
            ..BEAM
        };
        let exact = 1.0 / 0.8 * (1.0 + 12.0 * 0.2 * (0.9 - 0.5));
        close(rigid.finite(1.0, 1.0, 0.7, 0.9).deflection, exact, 1e-7);
    }

    #[test]
    fn a_pinched_ring_is_balanced_closes_and_gives_way_as_its_energy_says() {
        let ring = PinchedRing {
            radius: 2.0,
            stiffness: 5.0,
            force: 3.0,
        };
        // Catalogue: 0.318310 and −0.181690 FR (FR = 6), 0.148779 and 0.136620 FR³/EI.
        close(ring.section(0.0).moment, 1.90986, 6e-6);
        close(ring.section(FRAC_PI_2).moment, -0.181690 * 6.0, 6e-6);
        close(ring.shortening(), 0.148779 * 4.8, 5e-6);
        close(ring.widening(), 0.136620 * 4.8, 5e-6);
        // No rotation over a quarter; Castigliano with F, and with forces across.
        let quarter = |f: &dyn Fn(f64) -> f64| integral(f, 0.0, FRAC_PI_2, 4000);
        close(quarter(&|t| ring.section(t).moment), 0.0, 1e-6);
        let unit = PinchedRing { force: 1.0, ..ring };
        let work = |other: &dyn Fn(f64) -> f64| {
            4.0 * quarter(&|t| ring.section(t).moment * other(t)) * 2.0 / 5.0
        };
        close(work(&|t| unit.section(t).moment), ring.shortening(), 1e-6);
        close(
            -work(&|t| unit.section(FRAC_PI_2 - t).moment),
            ring.widening(),
            1e-6,
        );
        // dM/ds of a cut with the inner fibre in tension, dN/dφ = V, dV/dφ = −N.
        for t in [0.3, 1.2] {
            let SectionForces { normal, shear, .. } = ring.section(t);
            close(
                derivative(|t| ring.section(t).moment, t, 1e-3),
                -2.0 * shear,
                1e-9,
            );
            close(derivative(|t| ring.section(t).normal, t, 1e-3), shear, 1e-9);
            close(
                derivative(|t| ring.section(t).shear, t, 1e-3),
                -normal,
                1e-9,
            );
        }
    }

    #[test]
    fn an_arch_on_the_line_of_thrust_is_pressed_and_nothing_else() {
        // Equal loads at equal distances on a parabola; H = q l²/(8 f), the hinge at a load.
        let on = |x: f64| [x, 4.0 * 3.0 * x * (10.0 - x) / 100.0];
        let arch = ThreeHingedArch {
            left: on(0.0),
            crown: on(5.0),
            right: on(10.0),
        };
        let loads: Vec<_> = (1..20)
            .map(|k| (on(0.5 * f64::from(k)), [0.0, -0.5]))
            .collect();
        let [left, right] = arch.reactions(&loads);
        close(left[0], 100.0 / 24.0, 1e-12);
        close(right[0], -100.0 / 24.0, 1e-12);
        close(left[1], 4.75, 1e-12);
        for k in 1..20 {
            let (from, to) = (on(0.5 * f64::from(k) - 0.5), on(0.5 * f64::from(k)));
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let tangent = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
            let SectionForces {
                normal,
                shear,
                moment,
            } = arch.section(to, tangent, &loads);
            close(normal, left[0] / tangent[0], 1e-12);
            close(shear, 0.0, 1e-12);
            close(moment, 0.0, 1e-12);
        }
    }

    #[test]
    fn an_arch_with_supports_of_different_heights_is_balanced_and_turns_at_its_hinge() {
        let arch = ThreeHingedArch {
            left: [0.0, 0.0],
            crown: [4.0, 5.0],
            right: [9.0, 1.5],
        };
        let loads = [([1.0, 2.0], [0.5, -3.0]), ([6.0, 4.0], [-0.2, -1.0])];
        let [left, right] = arch.reactions(&loads);
        for i in 0..2 {
            close(
                left[i] + right[i] + loads[0].1[i] + loads[1].1[i],
                0.0,
                1e-14,
            );
        }
        let crown = arch.section(arch.crown, [1.0, 0.0], &loads);
        close(crown.moment, 0.0, 1e-13);
        // From the right: the same force through the hinge, and no moment of the right half about it.
        close(crown.normal, -(right[0] - 0.2), 1e-13);
        close(crown.shear, -(right[1] - 1.0), 1e-13);
        let half =
            moment([9.0, 1.5], arch.crown, right) + moment([6.0, 4.0], arch.crown, [-0.2, -1.0]);
        close(half, 0.0, 1e-13);
        // A simple beam's reaction bends the left half so that its lower side is in tension.
        let flat = ThreeHingedArch {
            left: [0.0, 0.0],
            crown: [5.0, 1e-9],
            right: [10.0, 0.0],
        };
        let sagging = flat.section([2.5, 0.0], [1.0, 0.0], &[([2.5, 0.0], [0.0, -1.0])]);
        assert!(sagging.moment < 0.0);
    }

    #[test]
    fn a_bond_hands_the_force_of_a_bolt_to_the_ground() {
        let bolt = GroutedBolt {
            stiffness: 80.0,
            bond: 20.0,
            length: 5.0,
        };
        close(bolt.transfer_length(), 2.0, 0.0);
        // EA u'' = k (u − g): the slip is N'/k, and its slope N/EA less the strain of the ground.
        let slip = |force: &dyn Fn(f64) -> f64, x: f64| derivative(force, x, 1e-2) / 20.0;
        let holds = |force: &dyn Fn(f64) -> f64, strain: f64, x: f64| {
            let slope = derivative(|x| slip(force, x), x, 1e-2);
            close(slope, force(x) / 80.0 - strain, 1e-8);
        };
        for x in [0.6, 2.0, 4.1] {
            holds(&|x| bolt.pulled(3.0, x), 0.0, x);
            holds(&|x| bolt.in_strained_ground(1e-2, x), 1e-2, x);
            holds(&|x| bolt.across_joint(0.1, x), 0.0, x);
        }
        close(bolt.pulled(3.0, 0.0), 3.0, 0.0);
        for end in [0.0, 5.0] {
            close(bolt.in_strained_ground(1e-2, end), 0.0, 1e-15);
            close(bolt.across_joint(0.1, end), 0.0, 1e-15);
        }
        close(bolt.pulled(3.0, 5.0), 0.0, 0.0);
        close(
            -slip(&|x| bolt.pulled(3.0, x), 0.0),
            bolt.pull_out(3.0),
            1e-8,
        );
        // Half of the opening is the slip on either side of the joint.
        close(slip(&|x| bolt.across_joint(0.1, x), 2.47), 0.05, 1e-3);
    }

    #[test]
    fn a_bolted_joint_parts_where_its_plates_are_slack() {
        let joint = BoltedJoint {
            bolt: 1.0,
            plates: 3.0,
            preload: 6.0,
        };
        close(joint.load_factor(), 0.25, 0.0);
        close(joint.separation(), 8.0, 1e-14);
        // The preload triangle: bolt and plates change their length alike.
        for load in [2.0, 5.0, 7.9] {
            let elongation = (joint.bolt_force(load) - 6.0) / 1.0;
            close(elongation, (6.0 - joint.clamping(load)) / 3.0, 1e-14);
        }
        close(joint.clamping(8.0), 0.0, 1e-14);
        close(joint.bolt_force(9.0), 9.0, 0.0);
        close(joint.clamping(9.0), 0.0, 0.0);
    }

    #[test]
    fn a_joint_opens_at_a_sixth_and_its_stress_balances_n_and_m() {
        let joint = SegmentJoint {
            young: 30_000.0,
            height: 0.3,
        };
        let normal = 2.0;
        close(joint.opening_moment(normal), 0.1, 1e-16);
        for moment in [0.02, 0.1, 0.15, 0.25, -0.25] {
            let rotation = joint.rotation(normal, moment);
            close(joint.moment(normal, rotation), moment, 1e-14);
            close(joint.stiffness(normal, moment) * rotation, moment, 1e-15);
            // Zones of depth h: stress E φ/h times the distance from its zero, over the face in contact.
            let slope = 30_000.0 * rotation.abs() / 0.3;
            let contact = joint.contact_height(normal, moment);
            let least = if contact < 0.3 {
                0.0
            } else {
                normal / 0.3 - 0.15 * slope
            };
            let stress = |z: f64| least + slope * z;
            let force = integral(stress, 0.0, contact, 2000);
            let couple = integral(|z| stress(z) * (z + 0.15 - contact), 0.0, contact, 2000);
            close(force, normal, 1e-5);
            close(couple, moment.abs(), 1e-6);
            assert!(least >= -1e-12);
        }
        assert!(joint.rotation(normal, 0.3).is_nan());
    }

    #[test]
    fn a_plain_section_bears_what_its_block_does() {
        // A block of height x at the edge: N = f x, M = N (h − x)/2.
        let (height, strength) = (0.3, 20.0);
        for x in [0.05, 0.15, 0.3] {
            let normal = strength * x;
            let moment = plain_section_moment(normal, height, strength);
            close(moment, normal * (height - x) / 2.0, 1e-15);
        }
    }
}
