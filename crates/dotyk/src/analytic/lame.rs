//! Lamé: thick rings under pressure, and the press fit of two of them.
//!
//! A ring a ≤ r ≤ b under the pressures p_a inside and p_b outside (G. Lamé, Leçons sur la théorie mathématique de
//! l'élasticité, 1852; S. Timoshenko, J. N. Goodier, Theory of Elasticity, 1970, articles 28 and 41):
//!
//! ```text
//!   σr = C − D/r²,   σθ = C + D/r²,   u = [(1−ν)Cr + (1+ν)D/r]/E
//!   C = (p_a q − p_b)/(1 − q),    D = (p_a − p_b) a²/(1 − q),    q = a²/b², 0 for an infinite plate
//! ```
//!
//! with (E, ν) of plane stress, or (E/(1−ν²), ν/(1−ν)) in plane strain.
//! A press fit with the radial interference δ at r = b closes the gap: u_outer(b) − u_inner(b) = δ.
//!
//! A ring that fits its hole when cold, and is then warmer by ΔT, is a press fit with the interference αΔT R,
//! in plane strain (1+ν)αΔT R: Hooke's law with the strain αΔT in all directions has, where εz = 0, the strain (1+ν)αΔT in
//! the plane and σz = ν(σr + σθ) − EαΔT (S. Timoshenko, J. N. Goodier, article 151).
//!
//! Pressure is positive in compression, stress in tension, displacement outward.

use crate::analytic::{Material, Plane};

/// A ring between two radii under pressure on both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThickRing {
    /// Inner radius, > 0.
    pub inner: f64,
    /// Outer radius, > inner; may be infinite.
    pub outer: f64,
    /// Its material.
    pub material: Material,
    /// Plane strain (no axial strain) or plane stress (no axial stress).
    pub plane: Plane,
    /// Pressure on the inner side.
    pub inner_pressure: f64,
    /// Pressure on the outer side.
    pub outer_pressure: f64,
}

impl ThickRing {
    /// The constants C and D of the stress.
    fn constants(&self) -> [f64; 2] {
        let ratio = (self.inner / self.outer).powi(2);
        let rest = 1.0 - ratio;
        [
            (self.inner_pressure * ratio - self.outer_pressure) / rest,
            (self.inner_pressure - self.outer_pressure) * self.inner * self.inner / rest,
        ]
    }

    /// Stress [σr, σθ] at radius r.
    pub fn stress(&self, r: f64) -> [f64; 2] {
        let [c, d] = self.constants();
        [c - d / (r * r), c + d / (r * r)]
    }

    /// Radial displacement at radius r, positive outward.
    pub fn displacement(&self, r: f64) -> f64 {
        let [c, d] = self.constants();
        let Material { young, poisson } = self.material.in_plane(self.plane);
        ((1.0 - poisson) * c * r + (1.0 + poisson) * d / r) / young
    }
}

/// Two rings pressed into one another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressFit {
    /// Bore of the inner ring.
    pub bore: f64,
    /// Radius of the interface.
    pub radius: f64,
    /// Outer radius of the outer ring; may be infinite.
    pub outer: f64,
    /// Material of the inner ring.
    pub inner_material: Material,
    /// Material of the outer ring.
    pub outer_material: Material,
    /// Plane strain or plane stress.
    pub plane: Plane,
    /// Radial interference δ > 0: the excess radius of the undeformed inner ring.
    pub interference: f64,
}

impl PressFit {
    /// Contact pressure: δ over the sum of the two radial compliances at the interface.
    pub fn pressure(&self) -> f64 {
        let [inner, outer] = self.rings_under(1.0);
        self.interference / (outer.displacement(self.radius) - inner.displacement(self.radius))
    }

    /// The inner and the outer ring under the contact pressure.
    pub fn rings(&self) -> [ThickRing; 2] {
        self.rings_under(self.pressure())
    }

    fn rings_under(&self, pressure: f64) -> [ThickRing; 2] {
        let inner = ThickRing {
            inner: self.bore,
            outer: self.radius,
            material: self.inner_material,
            plane: self.plane,
            inner_pressure: 0.0,
            outer_pressure: pressure,
        };
        let outer = ThickRing {
            inner: self.radius,
            outer: self.outer,
            material: self.outer_material,
            plane: self.plane,
            inner_pressure: pressure,
            outer_pressure: 0.0,
        };
        [inner, outer]
    }
}

/// A ring that fits a hole free of stress and is then warmer than its surroundings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatedRing {
    /// Bore of the ring.
    pub bore: f64,
    /// Radius of the hole.
    pub radius: f64,
    /// Outer radius of the material around the hole; may be infinite.
    pub outer: f64,
    /// Material of the ring.
    pub ring: Material,
    /// Material around the hole.
    pub around: Material,
    /// Plane strain or plane stress.
    pub plane: Plane,
    /// Coefficient of thermal expansion α of the ring.
    pub expansion: f64,
    /// ΔT: temperature of the ring above that of its surroundings.
    pub temperature: f64,
}

impl HeatedRing {
    /// The press fit of the same pressure.
    pub fn fit(&self) -> PressFit {
        PressFit {
            bore: self.bore,
            radius: self.radius,
            outer: self.outer,
            inner_material: self.ring,
            outer_material: self.around,
            plane: self.plane,
            interference: self.strain() * self.radius,
        }
    }

    /// Contact pressure.
    pub fn pressure(&self) -> f64 {
        self.fit().pressure()
    }

    /// Stress [σr, σθ, σz] of the ring at radius r.
    pub fn ring_stress(&self, r: f64) -> [f64; 3] {
        let [ring, _] = self.fit().rings();
        let [radial, hoop] = ring.stress(r);
        let Material { young, poisson } = self.ring;
        let axial = match self.plane {
            Plane::Strain => poisson * (radial + hoop) - young * self.expansion * self.temperature,
            Plane::Stress => 0.0,
        };
        [radial, hoop, axial]
    }

    /// Radial displacement of the ring at radius r, positive outward.
    pub fn ring_displacement(&self, r: f64) -> f64 {
        let [ring, _] = self.fit().rings();
        ring.displacement(r) + self.strain() * r
    }

    /// Strain in the plane of the ring alone.
    fn strain(&self) -> f64 {
        let free = self.expansion * self.temperature;
        match self.plane {
            Plane::Strain => (1.0 + self.ring.poisson) * free,
            Plane::Stress => free,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, derivative, integral};

    const STEEL: Material = Material {
        young: 210_000.0,
        poisson: 0.3,
    };

    fn ring(plane: Plane) -> ThickRing {
        ThickRing {
            inner: 2.0,
            outer: 5.0,
            material: STEEL,
            plane,
            inner_pressure: 30.0,
            outer_pressure: 11.0,
        }
    }

    fn fit(plane: Plane) -> PressFit {
        PressFit {
            bore: 20.0,
            radius: 40.0,
            outer: 80.0,
            inner_material: STEEL,
            outer_material: STEEL,
            plane,
            interference: 0.04,
        }
    }

    #[test]
    fn a_ring_is_in_equilibrium_and_carries_its_pressures() {
        let ring = ring(Plane::Stress);
        for r in [2.3, 3.1, 4.8] {
            let [radial, hoop] = ring.stress(r);
            let slope = derivative(|r| ring.stress(r)[0], r, 1e-3);
            close(slope + (radial - hoop) / r, 0.0, 1e-8);
        }
        close(ring.stress(2.0)[0], -30.0, 1e-12);
        close(ring.stress(5.0)[0], -11.0, 1e-12);
        // Boiler formula: the hoop force balances the pressures on a half ring.
        let hoop = integral(|r| ring.stress(r)[1], 2.0, 5.0, 2000);
        close(hoop, 30.0 * 2.0 - 11.0 * 5.0, 1e-4);
    }

    #[test]
    fn displacement_and_stress_obey_hooke_in_three_dimensions() {
        for plane in [Plane::Strain, Plane::Stress] {
            let ring = ring(plane);
            let (e, nu) = (STEEL.young, STEEL.poisson);
            for r in [2.4, 3.7] {
                let [radial, hoop] = ring.stress(r);
                let axial = match plane {
                    Plane::Strain => nu * (radial + hoop),
                    Plane::Stress => 0.0,
                };
                let strain = derivative(|r| ring.displacement(r), r, 1e-3);
                close(strain, (radial - nu * (hoop + axial)) / e, 1e-11);
                let around = ring.displacement(r) / r;
                close(around, (hoop - nu * (radial + axial)) / e, 1e-15);
            }
        }
    }

    #[test]
    fn a_press_fit_closes_its_interference() {
        for plane in [Plane::Strain, Plane::Stress] {
            let [inner, outer] = fit(plane).rings();
            close(
                outer.displacement(40.0) - inner.displacement(40.0),
                0.04,
                1e-15,
            );
            close(outer.stress(40.0)[0], inner.stress(40.0)[0], 1e-12);
        }
    }

    #[test]
    fn steel_in_steel() {
        // Catalogue, plane stress: p = 63.0, hoop of the outer ring +105 at r = 40, of the inner one −168 at r = 20.
        let fit = fit(Plane::Stress);
        close(fit.pressure(), 63.0, 1e-10);
        let [inner, outer] = fit.rings();
        close(outer.stress(40.0)[1], 105.0, 1e-9);
        close(inner.stress(20.0)[1], -168.0, 1e-9);
    }

    #[test]
    fn an_infinite_plate_is_the_limit_of_large_rings() {
        let plate = |outer: f64| ThickRing {
            outer,
            outer_pressure: 0.0,
            ..ring(Plane::Strain)
        };
        let (large, infinite) = (plate(2e6), plate(f64::INFINITY));
        close(large.displacement(3.0), infinite.displacement(3.0), 1e-15);
        close(infinite.stress(2.0)[0], -30.0, 0.0);
        close(infinite.stress(2.0)[1], 30.0, 0.0);
    }

    #[test]
    fn a_heated_ring_obeys_hooke_with_heat_and_stays_in_its_hole() {
        for plane in [Plane::Strain, Plane::Stress] {
            let heated = HeatedRing {
                bore: 4.85,
                radius: 5.15,
                outer: f64::INFINITY,
                ring: Material {
                    young: 30_000.0,
                    poisson: 0.2,
                },
                around: Material {
                    young: 500.0,
                    poisson: 0.3,
                },
                plane,
                expansion: 1e-5,
                temperature: 30.0,
            };
            let Material { young, poisson } = heated.ring;
            for r in [4.9, 5.1] {
                let [radial, hoop, axial] = heated.ring_stress(r);
                let free = 1e-5 * 30.0;
                let strain = derivative(|r| heated.ring_displacement(r), r, 1e-3);
                close(
                    strain,
                    (radial - poisson * (hoop + axial)) / young + free,
                    1e-11,
                );
                let around = heated.ring_displacement(r) / r;
                close(
                    around,
                    (hoop - poisson * (radial + axial)) / young + free,
                    1e-15,
                );
                if plane == Plane::Strain {
                    let along = (axial - poisson * (radial + hoop)) / young + free;
                    close(along, 0.0, 1e-18);
                }
            }
            let [_, plate] = heated.fit().rings();
            close(
                heated.ring_displacement(5.15),
                plate.displacement(5.15),
                1e-15,
            );
            close(heated.ring_stress(4.85)[0], 0.0, 1e-14);
            close(heated.ring_stress(5.15)[0], -heated.pressure(), 1e-14);
        }
    }
}
