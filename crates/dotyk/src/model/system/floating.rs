//! Floating bodies: the rigid motions that the contacts control, and the treatment of the others.
//!
//! The columns of R of all bodies are the modes; G = RᵀBᵀ and e = Rᵀf. A combination z with Gᵀz = 0 is a
//! motion that no contact can resist: driven by the load it is an error, else it is fixed by least norm with a warning.
//! If no admissible λ satisfies Gλ = e, the load pulls a body away from everything that could hold it, or the forces that could hold
//! it act beyond the nodes.
//!
//! A body without a contact in reach is an error, unless it is on springs: a bed also holds motions along its normal and leaves the
//! others free, such as the spin of a ring.

use crate::dual::{AdmissibleSet, Balance, Modes, NO_WORK};
use crate::fem::{ALONG, describe_motion, list_motions};
use crate::geometry::norm;
use crate::linalg::SparseVector;
use crate::model::nouns::error::{Error, NotHeld};
use crate::model::nouns::model::Model;
use crate::model::nouns::told::named;
use crate::model::system::bodies::{LoadedBody, load_size};
use crate::model::system::condition::{Condition, clearances};
use crate::model::system::parts::{Parts, part_name, part_points};
use crate::model::system::reach::hold_between_nodes;
use std::collections::BTreeSet;

/// Rigid modes of all bodies, and their control by the contact.
pub(crate) struct Floating {
    /// (body, index of the mode in its system) of every mode.
    pub modes: Vec<(usize, usize)>,
    /// The k combinations (r,) of modes that enter the dual problem.
    controlled: Vec<SparseVector>,
    /// The r − k combinations (r,) that no contact can control.
    pub uncontrolled: Vec<SparseVector>,
    /// G of all modes, r rows (m,).
    all: Vec<SparseVector>,
    /// Gλ = e in the controlled combinations.
    pub balance: Balance,
    /// Warnings to the user.
    pub warnings: Vec<String>,
}

impl Floating {
    /// Sets up G and e for these conditions. Errors: as [`Self::set_loads`].
    pub fn new<const D: usize>(
        model: &Model<D>,
        bodies: &[LoadedBody<D>],
        conditions: &[Condition<D>],
    ) -> Result<Self, Error<D>> {
        let gaps = clearances(conditions);
        let m = gaps.len();
        let modes: Vec<(usize, usize)> = bodies
            .iter()
            .enumerate()
            .flat_map(|(body, b)| (0..b.system.modes.len()).map(move |mode| (body, mode)))
            .collect();
        let r = modes.len();
        let work = |&(body, mode): &(usize, usize)| {
            let b = &bodies[body];
            let motion = &b.system.modes[mode];
            let rows = b.rows.index.iter().enumerate().map(|(local, &row)| {
                let parts = || b.rows.matrix.row(local);
                let sum: f64 = parts().map(|(dof, value)| value * motion[dof]).sum();
                // what joins a body to itself, a member or the faces of a sector, does not hold it: the sum of its terms is rounding
                let size: f64 = parts().map(|(_, value)| value.abs()).sum();
                let work = if sum.abs() <= ALONG * size { 0.0 } else { sum };
                (row, work)
            });
            SparseVector::sum(m, rows.filter(|(_, work)| *work != 0.0).collect())
        };
        let all: Vec<SparseVector> = modes.iter().map(work).collect();
        let whole = Balance::new(Modes::of_rows(&all, m), vec![0.0; r]);
        let split = whole.split().map_err(Error::RigidModes)?.clone();
        let (controlled, balance) = if split.uncontrolled.is_empty() {
            let unit = |k: usize| SparseVector::new(r, [(k, 1.0)]);
            let balance = whole.with_moments(moments(model, bodies, &modes));
            ((0..r).map(unit).collect(), balance)
        } else {
            let c = split.controlled;
            let combined = |z: &SparseVector| {
                let parts = z.entries().flat_map(|(k, part)| {
                    let row = all[k].entries();
                    row.map(move |(i, g)| (i, part * g))
                });
                SparseVector::sum(m, parts.collect())
            };
            let reduced: Vec<SparseVector> = c.iter().map(combined).collect();
            let balance = Balance::new(Modes::of_rows(&reduced, m), vec![0.0; c.len()]);
            (c, balance)
        };
        let mut unloaded = Self {
            modes,
            controlled,
            uncontrolled: split.uncontrolled,
            all,
            balance,
            warnings: Vec::new(),
        };
        unloaded.set_loads(model, bodies, conditions)?;
        Ok(unloaded)
    }

    /// Takes the loads and initial gaps of another time: G stays, e is updated. Errors: a floating body without a contact in reach, or
    /// whose load drives an uncontrolled motion.
    pub fn set_loads<const D: usize>(
        &mut self,
        model: &Model<D>,
        bodies: &[LoadedBody<D>],
        conditions: &[Condition<D>],
    ) -> Result<(), Error<D>> {
        reachable(model, bodies, &self.modes, &clearances(conditions))?;
        let e = self.works(bodies);
        self.warnings.clear();
        let sizes: Vec<f64> = bodies.iter().map(load_size).collect();
        let silent = |mode: usize| NO_WORK * sizes[self.modes[mode].0];
        for z in &self.uncontrolled {
            let moved = z.entries().filter(|(_, amplitude)| *amplitude != 0.0);
            let silent = moved.map(|(mode, _)| silent(mode)).fold(0.0, f64::max);
            let z = z.to_dense();
            let warning = check_undriven(model, bodies, &self.modes, &z, &e, silent)?;
            self.warnings.push(warning);
        }
        let controlled = self.controlled.iter().map(|z| z.dot(&e));
        self.balance.set_load(controlled.collect());
        Ok(())
    }

    /// The part that each row of the balance moves most.
    pub fn parts_of_balance(&self) -> impl Iterator<Item = usize> {
        self.controlled.iter().map(|z| {
            let largest = z.entries().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            largest.map_or(0, |(mode, _)| self.modes[mode].0)
        })
    }

    /// Work of a unit force of multiplier i on mode k.
    pub fn work(&self, k: usize, i: usize) -> f64 {
        self.all[k][i]
    }

    /// Combinations (r,) of the modes of some parts that do no work on some rows.
    ///
    /// Errors: a split that does not succeed.
    pub fn left_by<const D: usize>(
        &self,
        parts: &[usize],
        rows: impl Fn(usize) -> bool,
    ) -> Result<Vec<SparseVector>, Error<D>> {
        let r = self.modes.len();
        let own: Vec<usize> = (0..r)
            .filter(|&k| parts.contains(&self.modes[k].0))
            .collect();
        let kept = |k: &usize| -> Vec<(usize, f64)> {
            self.all[*k]
                .entries()
                .filter(|(row, _)| rows(*row))
                .collect()
        };
        let kept: Vec<Vec<(usize, f64)>> = own.iter().map(kept).collect();
        if kept.iter().all(Vec::is_empty) {
            let unit = |&k: &usize| SparseVector::new(r, [(k, 1.0)]);
            return Ok(own.iter().map(unit).collect());
        }
        let met: BTreeSet<usize> = kept.iter().flatten().map(|entry| entry.0).collect();
        let met: Vec<usize> = met.into_iter().collect();
        let place = |row: usize| met.partition_point(|&m| m < row);
        let of_met = |entries: Vec<(usize, f64)>| {
            let entries = entries.into_iter().map(|(row, g)| (place(row), g));
            SparseVector::new(met.len(), entries)
        };
        let kept: Vec<SparseVector> = kept.into_iter().map(of_met).collect();
        let balance = Balance::new(Modes::of_rows(&kept, met.len()), vec![0.0; own.len()]);
        let split = balance.split().map_err(Error::RigidModes)?;
        let of_all =
            |z: &SparseVector| SparseVector::new(r, z.entries().map(|(k, part)| (own[k], part)));
        Ok(split.uncontrolled.iter().map(of_all).collect())
    }

    /// Amplitudes of all modes from those of the controlled combinations.
    pub fn amplitudes(&self, alpha: &[f64]) -> Vec<f64> {
        let mut amplitudes = vec![0.0; self.modes.len()];
        for (z, a) in self.controlled.iter().zip(alpha) {
            z.add_to(*a, &mut amplitudes);
        }
        amplitudes
    }

    /// e of all modes (r,): a free mode causes no strain, so that prescribed displacements do no work on it.
    fn works<const D: usize>(&self, bodies: &[LoadedBody<D>]) -> Vec<f64> {
        let work = |&(body, mode): &(usize, usize)| -> f64 {
            let system = &bodies[body].system;
            let both = system.modes[mode].iter().zip(&system.load);
            both.map(|(r, f)| r * f).sum()
        };
        self.modes.iter().map(work).collect()
    }

    /// The error for a load that no admissible contact force balances; `direction` is that of the dual problem.
    pub fn pulled_away<const D: usize>(
        &self,
        model: &Model<D>,
        (bodies, conditions): (&[LoadedBody<D>], &[Condition<D>]),
        admissible: &AdmissibleSet,
        direction: &[f64],
    ) -> Error<D> {
        let (names, motion) = self.motion(model, bodies, direction);
        let body = names.into_iter().next().unwrap_or_default();
        let balance = (&self.modes[..], &self.all[..], self.works(bodies));
        let z = self.amplitudes(direction);
        if let Some(contacts) = hold_between_nodes(bodies, conditions, admissible, balance, &z) {
            let contacts = named(contacts.into_iter());
            return Error::OutOfReach {
                body,
                motion,
                contacts,
            };
        }
        let work = direction.iter().zip(self.balance.load());
        let load = work.map(|(z, e)| z * e).sum();
        let until = None;
        Error::PulledAway {
            body,
            motion,
            load,
            until,
        }
    }

    /// The parts that move along a direction of the dual problem, first the one that moves most, and the motion of that in words.
    pub fn motion<const D: usize>(
        &self,
        model: &Model<D>,
        bodies: &[LoadedBody<D>],
        direction: &[f64],
    ) -> (Vec<String>, String) {
        let z = self.amplitudes(direction);
        let body = main_body(model, &self.modes, &z);
        let motion = describe(model, bodies, body, |mode| {
            amplitude(&self.modes, &z, body, mode)
        });
        let largest = z.iter().fold(0.0, |s: f64, z| s.max(z.abs()));
        // points of couples move with their bodies, and are not bodies themselves
        let parts = Parts::of(model);
        let others = self.modes.iter().map(|mode| mode.0);
        let mut others: Vec<usize> = others.filter(|part| parts.owner(*part).is_free()).collect();
        others.dedup();
        let moves = |part: &usize| {
            let own = self
                .modes
                .iter()
                .zip(&z)
                .filter(|(mode, _)| mode.0 == *part);
            *part != body && own.fold(0.0, |s: f64, (_, z)| s.max(z.abs())) > STILL * largest
        };
        others.retain(moves);
        let parts = [body].into_iter().chain(others);
        (parts.map(|part| part_name(model, part)).collect(), motion)
    }
}

/// Bodies with less than this part of the largest motion are moved only by strain or rounding.
const STILL: f64 = 1e-3;

/// A larger clearance, in diameters of the body, cannot be intended: strains would be lost in rounding.
const OUT_OF_REACH: f64 = 1e6;

/// Errors: a floating body without a contact in reach.
fn reachable<const D: usize>(
    model: &Model<D>,
    bodies: &[LoadedBody<D>],
    modes: &[(usize, usize)],
    gaps: &[f64],
) -> Result<(), Error<D>> {
    for &(body, _) in modes {
        if let Some(reason) = unreachable_contacts(model, body, &bodies[body], gaps) {
            let count = bodies[body].system.modes.len();
            let motions =
                (0..count).map(|mode| describe(model, bodies, body, |k| f64::from(k == mode)));
            return Err(Error::NotHeld {
                body: part_name(model, body),
                motion: list_motions::<D>(&motions.collect::<Vec<_>>()),
                reason,
            });
        }
    }
    Ok(())
}

/// Why no contact can hold a floating body; `None` if one may.
fn unreachable_contacts<const D: usize>(
    model: &Model<D>,
    body: usize,
    loaded: &LoadedBody<D>,
    gaps: &[f64],
) -> Option<NotHeld> {
    let nearest = loaded.rows.index.iter().map(|&row| gaps[row]);
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    let own = model.bodies.get(body);
    if own.is_some_and(|body| !body.springs.is_empty()) {
        return None;
    }
    if nearest == f64::INFINITY {
        return Some(NotHeld::Alone);
    }
    let sizes = own.map_or(&model.bodies[..], std::slice::from_ref).iter();
    let size = sizes.map(|body| body.mesh.diameter()).fold(0.0, f64::max);
    let far = nearest > OUT_OF_REACH * size;
    far.then_some(NotHeld::OutOfReach { clearance: nearest })
}

/// A mode whose displacements differ in size by more is a rotation: those of a translation are all 1 to rounding.
const TURNS: f64 = 1e-9;

/// Rows of G that balance moments: modes with a rotation. Rigid parts have no such modes; rotations of points are scaled to lengths.
fn moments<const D: usize>(
    model: &Model<D>,
    bodies: &[LoadedBody<D>],
    modes: &[(usize, usize)],
) -> Vec<bool> {
    modes
        .iter()
        .map(|&(body, mode)| {
            if body >= model.bodies.len() {
                return false;
            }
            let u = bodies[body]
                .system
                .to_global(&bodies[body].system.modes[mode]);
            u.iter().any(|&v| (norm(v) - 1.0).abs() > TURNS)
        })
        .collect()
}

/// The part that a combination of modes moves most; points of couples only move with their bodies.
fn main_body<const D: usize>(model: &Model<D>, modes: &[(usize, usize)], z: &[f64]) -> usize {
    let parts = Parts::of(model);
    let own = (0..z.len()).filter(|&k| parts.owner(modes[k].0).is_free());
    let largest = own.max_by(|&a, &b| z[a].abs().total_cmp(&z[b].abs()).then(b.cmp(&a)));
    largest.map_or(0, |k| modes[k].0)
}

fn amplitude(modes: &[(usize, usize)], z: &[f64], body: usize, mode: usize) -> f64 {
    modes
        .iter()
        .position(|&m| m == (body, mode))
        .map_or(0.0, |k| z[k])
}

/// A rigid motion of one body in words.
pub(crate) fn describe<const D: usize>(
    model: &Model<D>,
    bodies: &[LoadedBody<D>],
    body: usize,
    amplitude: impl Fn(usize) -> f64,
) -> String {
    let system = &bodies[body].system;
    let mut motion = vec![0.0; system.load.len()];
    for (mode, column) in system.modes.iter().enumerate() {
        let a = amplitude(mode);
        motion.iter_mut().zip(column).for_each(|(u, r)| *u += a * r);
    }
    describe_motion(&part_points(model, body), &system.to_global(&motion))
}

/// Warning about a motion that no contact controls and no load drives; an error if the load does more work on it than
/// `silent`.
fn check_undriven<const D: usize>(
    model: &Model<D>,
    bodies: &[LoadedBody<D>],
    modes: &[(usize, usize)],
    z: &[f64],
    e: &[f64],
    silent: f64,
) -> Result<String, Error<D>> {
    let body = main_body(model, modes, z);
    let name = part_name(model, body);
    let motion = describe(model, bodies, body, |mode| amplitude(modes, z, body, mode));
    let work: f64 = z.iter().zip(e).map(|(z, e)| z * e).sum();
    if work.abs() > silent {
        return Err(Error::NotHeld {
            body: name,
            motion,
            reason: NotHeld::Driven { load: work },
        });
    }
    Ok(format!(
        "body \"{name}\": nothing controls its {motion} and no load drives it; it is fixed by least norm of the displacement"
    ))
}
