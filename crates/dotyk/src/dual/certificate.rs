//! The certificate: eleven figures that measure the error of an answer. It is the only judge of convergence, whatever the
//! solver.
//!
//! Each figure is a violation in the problem's units; over its scale it must not exceed its limit.
//!
//! | Figure | Violation | Scale | Limit |
//! |---|---|---|---|
//! | penetration | largest −gap of a unilateral contact, largest ‖gap‖ of a tied one | length | tolerance |
//! | tension | largest −λₙ of a unilateral contact | force | tolerance |
//! | complementarity | Σ‖λ·gap‖ over normal and tied components | energy | tolerance |
//! | imbalance of forces | largest resultant force on a body | force | 1e-10 |
//! | imbalance of moments | largest resultant moment on a body | force · arm | 1e-10 |
//! | energy gap | difference of the primal and the dual energy | energy | tolerance |
//! | slip violation | largest distance of λₜ from what friction makes of the bound and the slip | force | tolerance |
//! | force error | largest change of a force that its gap asks for | force | 10 tolerances |
//! | rounding | largest change of a force that rounding of the gaps leaves open | force | 0.01 |
//! | between nodes | deepest penetration between the nodes of the sides | resolution of the meshes | 10 |
//! | overlap | deepest overlap of two bodies beyond that at first, whoever named a contact | what small displacements and the meshes explain | 1 |
//!
//! Scales: length is max‖d‖; force is the larger of max‖λ‖ and the largest resultant load, where the force on a support that
//! moves is a load like any other; arm is the largest diameter of a body; energy is the elastic energy of all bodies, in stressed
//! ground at least what it would release without its contacts. A scale of zero counts as 1.
//!
//! *Domains.* A domain is a set of bodies that contacts couple ([`Coupled`]), and each has its own scales: the forces on a far body
//! are no scale of this contact. A figure is that of the worst domain. Loads may bypass a contact because supports take them or
//! because they balance each other, as thermal loads do. So a load counts in full in the scale of resultants, but only by a millionth
//! in the scale of contact forces. A contact whose forces are smaller than those of others is judged by its own, down to a thousandth
//! of the largest.
//!
//! *Force error.* The scale of gaps is one length for a whole domain. Between two stiff bodies a gap that is negligible beside
//! that length may stand for a large force, and complementarity, a product, does not see it either. So every gap is divided by
//! the softness of its own component, its compliance under a unit force: the figure is ‖λ − P(λ − gap/softness)‖, zero for an
//! exact answer. Neighbouring contacts may be much stiffer against each other than each of them by itself, which their
//! softness does not show. So forces from an iteration are also compared with those of the exact answer nearby, where exact
//! steps find it.
//!
//! *Slip violation* is the same for the shear alone: λₜ against the trial shear λₜ − gapₜ/softness, shortened to the bound that
//! the law of the node gives beside λₙ. Where the node sticks gapₜ = 0; where it slips the trial shear points along the slip.
//!
//! *Rounding of forces.* Where multipliers are finer than the mesh of the softer side, that side responds alike to different forces.
//! Only the stiffer side distinguishes them, by gaps that may be less than the rounding of the coordinates: all figures above may be
//! zero and the forces still wrong. This figure is the change of the forces when gaps change by their uncertainty.
//!
//! *Between nodes.* The conditions of a contact are imposed at its nodes. What the sides do between them is measured without
//! knowing which conditions were imposed.
//!
//! *Overlap.* A model names its contacts, and facets are paired as they face each other at first. So the deformed surfaces of all
//! bodies are compared, too; that is done where the bodies are known.
//!
//! *Rounding of gaps.* A gap is a difference of displacements that may be much larger: a soft body carries a stiff one along.
//! The part of a gap that is rounding of these displacements says nothing, and every figure is computed without it. Bodies may be carried
//! without any strain: where even the elastic energy is no more than the rounding of a work, of the force times the length, works below that
//! count as zero, provided that the gaps are known well enough for the forces.

use std::fmt;

use crate::dual::{AdmissibleSet, Component, DualProblem, Multipliers, Scales};

/// Limit of the relative imbalances, whatever the tolerance.
pub const IMBALANCE_LIMIT: f64 = 1e-10;

/// Limit of the force error, in tolerances: neighbouring forces share their errors, a component by itself overstates them.
pub const FORCE_LIMIT: f64 = 10.0;

/// Limit of the uncertainty of forces by rounding: pressures are read to a percent.
const OPEN_LIMIT: f64 = 1e-2;

/// Limit of the penetration between nodes, in depths that the meshes can resolve.
pub const BETWEEN_LIMIT: f64 = 10.0;

/// Limit of stress beyond the yield stress, and of work gained by plastic strain: both are rounding of the return mapping.
const YIELD_LIMIT: f64 = 1e-10;

/// Relative uncertainty of a gap: to this part of the numbers whose difference it is.
pub(crate) const ROUNDING: f64 = 4e-15;

/// One figure of the certificate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figure {
    /// The violation in the problem's units.
    pub value: f64,
    /// The violation over its scale.
    pub relative: f64,
    /// Largest admissible `relative`.
    pub limit: f64,
}

impl Figure {
    /// A violation against its scale (1 where the scale is zero).
    pub fn new(value: f64, scale: f64, limit: f64) -> Self {
        let relative = if scale > 0.0 { value / scale } else { value };
        Self {
            value,
            relative,
            limit,
        }
    }

    /// The figure is within its limit; a NaN never is.
    pub fn holds(&self) -> bool {
        self.relative <= self.limit
    }
}

/// The figures of an answer: the only judge of convergence, whatever the solver.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Certificate {
    /// Largest penetration, a length.
    pub penetration: Figure,
    /// Largest tension of a unilateral contact, a force.
    pub tension: Figure,
    /// Σ|λ·gap|, an energy.
    pub complementarity: Figure,
    /// Largest resultant force of a body that is not balanced.
    pub imbalance_force: Figure,
    /// Largest resultant moment of a body that is not balanced.
    pub imbalance_moment: Figure,
    /// Difference of primal and dual energy.
    pub energy_gap: Figure,
    /// Violation of the friction law, a force.
    pub slip_violation: Figure,
    /// Largest change of a force that its own gap asks for.
    pub force_error: Figure,
    /// Uncertainty of forces: their largest change when gaps change by their rounding. Computed where multipliers are finer than the
    /// softer side and F is assembled; zero elsewhere.
    pub rounding: Figure,
    /// Deepest penetration between the nodes, a length; relative to the resolution of the meshes.
    pub between_nodes: Figure,
    /// Deepest overlap of the deformed bodies beyond the initial one, a length; relative to the explained one. Zero where not computed.
    pub overlap: Figure,
    /// Figures of bodies that yield; `None` where no body may yield.
    pub yields: Option<OfYield>,
}

/// Figures of bodies that yield, found from displacements and plastic strains.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OfYield {
    /// Largest nodal force that the stress leaves unbalanced, over the largest force of a cell on a node; of the worst body.
    pub equilibrium: Figure,
    /// Largest stress beyond the yield stress, over the largest stress before anything yielded; of the worst body.
    pub yield_violation: Figure,
    /// Work gained by plastic strain, which must dissipate, over the elastic energy.
    pub flow: Figure,
}

impl OfYield {
    /// From the unbalanced force, the largest force and the limit; the largest stress beyond the yield stress and its scale; the gained
    /// work and its scale.
    pub fn new(
        ([left, force], tolerance): ([f64; 2], f64),
        [beyond, trial]: [f64; 2],
        [gained, energy]: [f64; 2],
    ) -> Self {
        Self {
            equilibrium: Figure::new(left, force, tolerance),
            yield_violation: Figure::new(beyond.max(0.0), trial, YIELD_LIMIT),
            flow: Figure::new(gained.max(0.0), energy, YIELD_LIMIT),
        }
    }
}

/// Names of the figures that no contact solver can change.
pub(crate) const NOT_OF_THE_SOLVER: [&str; 6] = [
    "rounding",
    "between_nodes",
    "overlap",
    "equilibrium",
    "yield_violation",
    "flow",
];

impl Certificate {
    /// The figures with their names in `summary.json`, in its order.
    pub fn figures(&self) -> Vec<(&'static str, Figure)> {
        let [rounding, between_nodes, overlap, ..] = NOT_OF_THE_SOLVER;
        let mut figures = vec![
            ("penetration", self.penetration),
            ("tension", self.tension),
            ("complementarity", self.complementarity),
            ("imbalance_force", self.imbalance_force),
            ("imbalance_moment", self.imbalance_moment),
            ("energy_gap", self.energy_gap),
            ("slip_violation", self.slip_violation),
            ("force_error", self.force_error),
            (rounding, self.rounding),
            (between_nodes, self.between_nodes),
            (overlap, self.overlap),
        ];
        if let Some(own) = self.yields {
            let [.., equilibrium, yield_violation, flow] = NOT_OF_THE_SOLVER;
            figures.extend([
                (equilibrium, own.equilibrium),
                (yield_violation, own.yield_violation),
                (flow, own.flow),
            ]);
        }
        figures
    }

    /// Every figure is within its limit.
    pub fn holds(&self) -> bool {
        self.figures().iter().all(|(_, figure)| figure.holds())
    }

    /// Which figures do not hold, in words.
    pub fn objection(&self) -> String {
        let violated = |(name, figure): &(&str, Figure)| {
            let Figure {
                relative, limit, ..
            } = figure;
            let words = name.replace('_', " ");
            (!figure.holds()).then(|| format!("{words} {relative:.1e} > {limit:.0e}"))
        };
        let violated: Vec<String> = self.figures().iter().filter_map(violated).collect();
        format!("the certificate does not hold: {}", violated.join(", "))
    }
}

impl fmt::Display for Certificate {
    /// One line per figure, in words.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (name, figure)) in self.figures().iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(
                f,
                "{:<16} {:>11.3e}, relative {:.1e}, limit {:.0e}: {}",
                name.replace('_', " "),
                figure.value,
                figure.relative,
                figure.limit,
                if figure.holds() { "holds" } else { "VIOLATED" }
            )?;
        }
        Ok(())
    }
}

/// Quantities that a caller has computed from the displacements, independently of F.
#[derive(Debug, Clone, PartialEq)]
pub struct Recomputed<'a> {
    /// Gap at the contact unknowns (m,).
    pub gap: &'a [f64],
    /// Uncertainty of these gaps (m,), a length.
    pub rounding: &'a [f64],
    /// Distance of each force from the answer of exact steps nearby (m,); empty where that answer is not known.
    pub exact: Vec<f64>,
    /// Uncertainty of each force by rounding of the gaps (m,), infinite where they do not determine it; empty where not computed.
    pub open: Vec<f64>,
    /// Deepest penetration between the nodes, and the resolution of the meshes there: lengths.
    pub between: [f64; 2],
    /// The rest, by domain of [`DualProblem::coupled`].
    pub domains: Vec<OfDomain>,
}

/// Quantities that a caller has computed for one domain of coupled bodies.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OfDomain {
    /// Largest violation of a condition without a multiplier, a length.
    pub implied: f64,
    /// Largest resultant force of a body that is not balanced.
    pub imbalance_force: f64,
    /// Largest resultant moment of a body that is not balanced.
    pub imbalance_moment: f64,
    /// Difference of primal and dual energy; with friction the primal one includes Σ bound·|slip|
    /// ([`AdmissibleSet::slip_potentials`]).
    pub energy_gap: f64,
    /// Elastic energy 1/2 uᵀKu of all bodies: the scale of energies.
    pub elastic_energy: f64,
    /// Largest resultant force of a support that moves: a load like any other.
    pub driving_force: f64,
}

/// The violation that is largest beside its scale.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Worst {
    value: f64,
    scale: f64,
}

impl Worst {
    /// Takes another violation if its relative value is at least as large. NaN counts as the largest.
    fn raise(&mut self, value: f64, scale: f64) {
        let other = Self { value, scale };
        let (own, new) = (self.relative(), other.relative());
        if !own.is_nan() && (new.is_nan() || new >= own) {
            *self = other;
        }
    }

    fn relative(&self) -> f64 {
        self.value / one_if_zero(self.scale)
    }

    fn figure(&self, limit: f64) -> Figure {
        Figure::new(self.value, self.scale, limit)
    }
}

/// Largest values over one contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct OfContact {
    force: f64,
    tension: f64,
    error: f64,
    open: f64,
    slip: f64,
}

/// Sums and largest values over one domain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sums {
    force: f64,
    /// Largest force by which a unit gap changes one.
    stiffness: f64,
    penetration: f64,
    complementarity: f64,
    primal_dual: f64,
    stored: f64,
    imbalance_force: f64,
    imbalance_moment: f64,
}

impl Sums {
    /// The figures of a domain from these sums alone, where nothing was recomputed from displacements.
    fn told(&self, scales: &Scales) -> OfDomain {
        OfDomain {
            implied: 0.0,
            imbalance_force: self.imbalance_force,
            imbalance_moment: self.imbalance_moment,
            energy_gap: self.primal_dual.abs(),
            elastic_energy: scales.energy + 0.5 * self.stored,
            driving_force: 0.0,
        }
    }
}

/// Violations of the optimality conditions, each where it is largest beside its scale; with the workspace to find them.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Violations {
    penetration: Worst,
    tension: Worst,
    force_error: Worst,
    open: Worst,
    complementarity: Worst,
    imbalance_force: Worst,
    imbalance_moment: Worst,
    energy_gap: Worst,
    slip: Worst,
    contacts: Vec<OfContact>,
    domains: Vec<Sums>,
}

/// Forces of a contact are compared with its own largest one, at least this part of the largest one of its domain.
const SMALL_CONTACT: f64 = 1e-3;

/// Loads of a domain count by this part beside the forces of its contacts.
const PASSES: f64 = 1e-6;

/// Forces whose change by the rounding of gaps is below this part of them are known.
const KNOWN_FORCE: f64 = 1e-7;

impl Violations {
    /// Finds them at (λ, α) with the gap there; `components` may call a component free that is not (a bolt).
    ///
    /// `gap` must be Fλ − d − Gᵀα; `admissible` has the bounds of friction, which may be other than those of the problem.
    /// Shapes: (m,), α (r,).
    ///
    /// The energy gap is λ·gap + Σ bound·|slip| + α·(Gλ − e): with friction the tangential part of λ·gap is minus the
    /// dissipated work, and bound·|slip| + λₜ·gapₜ ≥ 0 vanishes exactly where the friction law holds.
    pub(crate) fn find(
        &mut self,
        problem: &DualProblem,
        admissible: &AdmissibleSet,
        (lambda, alpha): (&[f64], &[f64]),
        gap: &[f64],
        components: &[Component],
    ) {
        let own = problem.rounding(gap, alpha);
        let told = |i: usize| beyond(gap[i], own(i));
        self.sum(
            problem,
            admissible,
            (lambda, alpha),
            (gap, told),
            components,
        );
        self.compare(problem, |domain, sums| {
            sums.told(problem.domain_scales(domain))
        });
    }

    /// Sums and largest values over contacts and domains; `told` is the gap without its rounding.
    fn sum(
        &mut self,
        problem: &DualProblem,
        admissible: &AdmissibleSet,
        (lambda, alpha): (&[f64], &[f64]),
        (gap, told): (&[f64], impl Fn(usize) -> f64),
        components: &[Component],
    ) {
        let coupled = &problem.coupled;
        let (contacts, domains) = (&mut self.contacts, &mut self.domains);
        contacts.clear();
        contacts.resize(coupled.contacts(), OfContact::default());
        domains.clear();
        domains.resize(coupled.domains(), Sums::default());
        for (i, &component) in components.iter().enumerate() {
            let force = lambda[i];
            let contact = &mut contacts[coupled.contact(i)];
            let domain = &mut domains[coupled.domain_of(i)];
            contact.force = contact.force.max(force.abs());
            domain.force = domain.force.max(force.abs());
            domain.stiffness = domain.stiffness.max(1.0 / problem.softness[i]);
            let rigid = problem.balance.modes().motion(i, alpha);
            domain.stored += force * (gap[i] + problem.shift[i] + rigid);
            let gap = told(i);
            domain.primal_dual += force * gap;
            let asked = gap / problem.softness[i];
            contact.error = larger(contact.error, error_along(component, force, asked));
            match component {
                Component::Free => domain.penetration = larger(domain.penetration, gap.abs()),
                Component::Normal => {
                    domain.penetration = larger(domain.penetration, -gap);
                    contact.tension = larger(contact.tension, -force);
                }
                Component::Tangent => continue,
            }
            domain.complementarity += (force * gap).abs();
        }
        let carried = problem.balance.modes().product(lambda);
        for (row, &load) in problem.balance.load().iter().enumerate() {
            let domain = coupled.domain_of_mode(row);
            let arm = one_if_zero(problem.domain_scales(domain).moment_arm);
            let domain = &mut domains[domain];
            let rest = carried[row] - load;
            domain.primal_dual += alpha[row] * rest;
            if problem.balance.moments()[row] {
                domain.imbalance_moment = larger(domain.imbalance_moment, rest.abs() * arm);
            } else {
                domain.imbalance_force = larger(domain.imbalance_force, rest.abs());
            }
        }
        if admissible.has_friction() {
            let potentials = admissible.slip_potentials(lambda, &told);
            for (first, potential) in potentials {
                domains[coupled.domain_of(first)].primal_dual += potential;
            }
            let trial = |i: usize| lambda[i] - told(i) / problem.softness[i];
            for (first, distance) in admissible.slip_violations(lambda, trial) {
                let contact = &mut contacts[coupled.contact(first)];
                contact.slip = larger(contact.slip, distance);
                contact.error = larger(contact.error, distance);
            }
        }
    }

    /// Compares errors of forces with the forces of their contact, and the other violations, `told` for each domain, with the scales
    /// of the domain.
    fn compare(&mut self, problem: &DualProblem, told: impl Fn(usize, &Sums) -> OfDomain) {
        let contacts = std::mem::take(&mut self.contacts);
        let domains = std::mem::take(&mut self.domains);
        *self = Self::default();
        for (contact, found) in contacts.iter().enumerate() {
            let domain = problem.coupled.domain(contact);
            let driving = told(domain, &domains[domain]).driving_force;
            let load = problem.domain_scales(domain).force.max(driving);
            let whole = domains[domain].force.max(PASSES * load);
            let scale = found.force.max(SMALL_CONTACT * whole);
            self.tension.raise(found.tension, scale);
            self.force_error.raise(found.error, scale);
            self.open.raise(found.open, scale);
            self.slip.raise(found.slip, scale);
        }
        for (domain, sums) in domains.iter().enumerate() {
            let (scales, own) = (problem.domain_scales(domain), told(domain, sums));
            let force = sums.force.max(own.driving_force).max(scales.force);
            let moment = one_if_zero(force) * one_if_zero(scales.moment_arm);
            let (depth, energy) = (larger(sums.penetration, own.implied), own.elastic_energy);
            // works of what is hardly strained, if gaps are known well enough for its forces
            let none = ROUNDING * force * scales.length;
            let bears = sums.force.max(PASSES * force);
            let known = ROUNDING * scales.length * sums.stiffness <= KNOWN_FORCE * bears;
            let idle = energy <= none && known;
            let told = |work: f64| above(work, if idle { none } else { 0.0 });
            self.penetration.raise(depth, scales.length);
            self.complementarity
                .raise(told(sums.complementarity), energy);
            self.imbalance_force.raise(own.imbalance_force, force);
            self.imbalance_moment.raise(own.imbalance_moment, moment);
            self.energy_gap.raise(told(own.energy_gap), energy);
        }
        (self.contacts, self.domains) = (contacts, domains);
    }

    /// The largest relative violation.
    pub(crate) fn residual(&self) -> f64 {
        [
            self.penetration.relative(),
            self.tension.relative(),
            self.force_error.relative() / FORCE_LIMIT,
            self.complementarity.relative(),
            self.imbalance_force.relative(),
            self.imbalance_moment.relative(),
            self.energy_gap.relative(),
            self.slip.relative(),
        ]
        .into_iter()
        .fold(0.0, larger)
    }
}

impl DualProblem {
    /// The scales of a domain.
    pub(crate) fn domain_scales(&self, domain: usize) -> &Scales {
        self.coupled.scales.get(domain).unwrap_or(&self.scales)
    }

    /// The certificate of an answer, from the data of the dual problem alone.
    ///
    /// Figures are relative to the scales of the problem; their limits stand in the table of the module.
    /// Panics if lengths differ.
    pub fn certify(&self, multipliers: &Multipliers, tolerance: f64) -> Certificate {
        let gap = self.gap(multipliers);
        let own = self.rounding(&gap, &multipliers.alpha);
        let rounding: Vec<f64> = (0..gap.len()).map(own).collect();
        let found = self.violations(multipliers);
        let domains = found.domains.iter().enumerate();
        let domains = domains.map(|(domain, sums)| sums.told(self.domain_scales(domain)));
        let recomputed = Recomputed {
            gap: &gap,
            rounding: &rounding,
            exact: Vec::new(),
            open: Vec::new(),
            between: [0.0, 1.0],
            domains: domains.collect(),
        };
        self.certify_with(multipliers, &recomputed, tolerance)
    }

    /// The certificate of an answer from what the caller recomputed from the displacements.
    pub fn certify_with(
        &self,
        multipliers: &Multipliers,
        recomputed: &Recomputed<'_>,
        tolerance: f64,
    ) -> Certificate {
        let Multipliers { lambda, alpha } = multipliers;
        let (gap, rounding) = (recomputed.gap, recomputed.rounding);
        let told = |i: usize| beyond(gap[i], rounding[i]);
        let components = self.admissible.components();
        let mut found = Violations::default();
        found.sum(
            self,
            &self.admissible,
            (lambda, alpha),
            (gap, told),
            &components,
        );
        for (i, &off) in recomputed.exact.iter().enumerate() {
            let contact = &mut found.contacts[self.coupled.contact(i)];
            contact.error = larger(contact.error, off);
        }
        for (i, &open) in recomputed.open.iter().enumerate() {
            let contact = &mut found.contacts[self.coupled.contact(i)];
            contact.open = larger(contact.open, open);
        }
        let told = |domain: usize| recomputed.domains.get(domain).copied();
        found.compare(self, |domain, _| told(domain).unwrap_or_default());
        let [depth, resolved] = recomputed.between;
        Certificate {
            penetration: found.penetration.figure(tolerance),
            tension: found.tension.figure(tolerance),
            complementarity: found.complementarity.figure(tolerance),
            imbalance_force: found.imbalance_force.figure(IMBALANCE_LIMIT),
            imbalance_moment: found.imbalance_moment.figure(IMBALANCE_LIMIT),
            energy_gap: found.energy_gap.figure(tolerance),
            slip_violation: found.slip.figure(tolerance),
            force_error: found.force_error.figure(FORCE_LIMIT * tolerance),
            rounding: found.open.figure(OPEN_LIMIT),
            between_nodes: Figure::new(depth, resolved, BETWEEN_LIMIT),
            overlap: Figure::new(0.0, 0.0, 1.0),
            yields: None,
        }
    }

    /// Largest relative violation of the optimality conditions and of the friction law: what the solvers stop on.
    ///
    /// It bounds every figure of [`DualProblem::certify`] over its limit, in tolerances. Costs one product with F.
    pub fn kkt_residual(&self, multipliers: &Multipliers) -> f64 {
        self.violations(multipliers).residual()
    }

    /// Distance (m,) of every force from the one that its gap asks for; that of a shear stands beside its first component.
    pub(crate) fn force_errors(&self, multipliers: &Multipliers) -> Vec<f64> {
        let (lambda, gap) = (&multipliers.lambda, self.gap(multipliers));
        let rounding = self.rounding(&gap, &multipliers.alpha);
        let asked = |i: usize| beyond(gap[i], rounding(i)) / self.softness[i];
        let components = self.admissible.components().into_iter().enumerate();
        let mut errors: Vec<f64> = components
            .map(|(i, component)| error_along(component, lambda[i], asked(i)))
            .collect();
        let trial = |i: usize| lambda[i] - asked(i);
        for (first, distance) in self.admissible.slip_violations(lambda, trial) {
            errors[first] = larger(errors[first], distance);
        }
        errors
    }

    /// The component with the largest finite force error, the difference between its force and the projected trial force; else `None`.
    pub(crate) fn least_settled(&self, multipliers: &Multipliers) -> Option<usize> {
        let (lambda, gap) = (&multipliers.lambda, self.gap(multipliers));
        let terms = lambda.iter().zip(&gap).zip(&self.softness);
        let trial: Vec<f64> = terms.map(|((l, gap), c)| l - gap / c).collect();
        let mut allowed = vec![0.0; trial.len()];
        self.admissible.project(&trial, &mut allowed);
        let off = |i: &usize| (lambda[*i] - allowed[*i]).abs();
        let finite = (0..lambda.len()).filter(|i| off(i).is_finite());
        finite.max_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// Uncertainty of gaps from Fλ, d and Gᵀα. A motion that is large in one component rounds the others of its domain, too, because
    /// rotations and translations are separated by differences of these.
    pub(crate) fn rounding(&self, gap: &[f64], alpha: &[f64]) -> impl Fn(usize) -> f64 {
        let domain = |i: usize| self.coupled.domain_of(i);
        let mut moved = vec![0.0f64; self.coupled.domains()];
        for (i, shift) in self.shift.iter().enumerate() {
            let rigid = self.balance.modes().motion(i, alpha).abs();
            let largest = &mut moved[domain(i)];
            *largest = largest.max(rigid + shift.abs());
        }
        move |i| ROUNDING * (gap[i].abs() + moved[domain(i)])
    }

    fn violations(&self, multipliers: &Multipliers) -> Violations {
        let Multipliers { lambda, alpha } = multipliers;
        let (gap, components) = (self.gap(multipliers), self.admissible.components());
        let mut violations = Violations::default();
        violations.find(self, &self.admissible, (lambda, alpha), &gap, &components);
        violations
    }

    /// Work that friction dissipates in this step, Σ λₜ·slip ≥ 0 at a solution.
    ///
    /// `gap` (m,) is that of [`DualProblem::gap`] or one recomputed from the displacements: its tangential part is minus
    /// the slip of this step. Per block: [`AdmissibleSet::dissipated`]. Unit: energy. Panics if lengths differ.
    pub fn dissipation(&self, lambda: &[f64], gap: &[f64]) -> f64 {
        self.admissible.dissipated(lambda, gap).iter().sum()
    }
}

/// Distance of a force from the one that its component alone asks for, whose change by the gap is `asked`; zero along a shear.
fn error_along(component: Component, force: f64, asked: f64) -> f64 {
    match component {
        Component::Free => asked.abs(),
        Component::Normal => {
            let trial = force - asked;
            // in this order a NaN stays NaN
            let nearest = if trial < 0.0 { 0.0 } else { trial };
            (force - nearest).abs()
        }
        Component::Tangent => 0.0,
    }
}

/// A number, zero where it is no larger than its uncertainty.
pub(crate) fn above(value: f64, uncertainty: f64) -> f64 {
    match value.abs() <= uncertainty {
        true => 0.0,
        false => value,
    }
}

/// The part of a number beyond an uncertainty.
fn beyond(value: f64, uncertainty: f64) -> f64 {
    // in this order a NaN stays NaN
    if value.abs() <= uncertainty {
        return 0.0;
    }
    value - uncertainty.copysign(value)
}

fn one_if_zero(scale: f64) -> f64 {
    if scale > 0.0 { scale } else { 1.0 }
}

/// The larger of two numbers; NaN wins.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() || b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Balance, Block, Compliance, Coupled, Friction, Mat};

    /// Two springs of compliance 1 pressed by 3 into a floating plate: λ = (2, 1), both closed.
    fn plate() -> (DualProblem, Multipliers) {
        let problem = DualProblem::new(
            Compliance::Dense(Mat::from_fn(2, 2, |i, j| f64::from(i == j))),
            vec![1.0, 0.0],
            AdmissibleSet::new(vec![Block::Unilateral; 2]),
            Balance::new(Mat::from_fn(1, 2, |_, _| 1.0), vec![3.0]),
        )
        .unwrap();
        let answer = Multipliers {
            lambda: vec![2.0, 1.0],
            alpha: vec![1.0],
        };
        (problem, answer)
    }

    #[test]
    fn right_answer_is_certified() {
        let (problem, answer) = plate();
        assert!(problem.certify(&answer, 1e-8).holds());
        assert!(problem.kkt_residual(&answer) < 1e-15);
    }

    #[test]
    fn each_wrong_answer_fails_in_its_own_figure() {
        let (problem, answer) = plate();
        let failing = |lambda: [f64; 2], alpha: f64| -> Vec<&'static str> {
            let wrong = Multipliers {
                lambda: lambda.to_vec(),
                alpha: vec![alpha],
            };
            let residual = problem.kkt_residual(&wrong);
            assert!(residual > 1e-8 || residual.is_nan());
            let certificate = problem.certify(&wrong, 1e-8);
            let violated =
                |(name, figure): &(&'static str, Figure)| (!figure.holds()).then_some(*name);
            certificate.figures().iter().filter_map(violated).collect()
        };
        assert!(failing([2.0, 1.0], 1.0 + 1e-6).contains(&"penetration"));
        assert!(failing([2.0, 1.0], 1.0 - 1e-6).contains(&"complementarity"));
        assert!(failing([2.0 + 1e-6, 1.0], 1.0).contains(&"imbalance_force"));
        assert!(failing([3.0 + 1e-6, -1e-6], 1.0).contains(&"tension"));
        assert!(failing([f64::NAN, 1.0], 1.0).len() >= 3);
        assert_eq!(
            problem.certify(&answer, 1e-8).to_string().lines().count(),
            11
        );
    }

    #[test]
    fn force_error_is_what_a_gap_would_take_to_close() {
        let (problem, answer) = plate();
        let error = |lambda: [f64; 2], alpha: f64| {
            let (lambda, alpha) = (lambda.to_vec(), vec![alpha]);
            let wrong = Multipliers { lambda, alpha };
            problem.certify(&wrong, 1e-8).force_error.value
        };
        assert!(error([2.0, 1.0], answer.alpha[0]) < 1e-15);
        // gaps count but for their rounding; both springs part by 0.1, or are pressed into each other by 0.5
        assert!((error([2.0, 1.0], 0.9) - 0.1).abs() < 1e-13);
        assert!((error([2.0, 1.0], 1.5) - 0.5).abs() < 1e-13);
        // a contact that is open by more than its force would take to open bears what it should not
        assert!((error([4.0, 1.0], -2.0) - 4.0).abs() < 1e-13);
    }

    #[test]
    fn moments_are_compared_with_force_times_arm() {
        let (mut problem, answer) = plate();
        problem.balance = problem.balance.with_moments(vec![true]);
        problem.scales.moment_arm = 10.0;
        problem.balance.set_load(vec![3.3]);
        let certificate = problem.certify(&answer, 1e-8);
        assert!((certificate.imbalance_moment.value - 3.0).abs() < 1e-12);
        assert!((certificate.imbalance_moment.relative - 0.3 / 3.0).abs() < 1e-12);
        assert_eq!(certificate.imbalance_force.value, 0.0);
    }

    #[test]
    fn recomputed_gap_is_what_counts() {
        let (problem, answer) = plate();
        let recomputed = Recomputed {
            gap: &[0.0, -1e-3],
            rounding: &[0.0; 2],
            exact: Vec::new(),
            open: Vec::new(),
            between: [0.0, 1.0],
            domains: vec![OfDomain {
                elastic_energy: 2.5,
                ..OfDomain::default()
            }],
        };
        let certificate = problem.certify_with(&answer, &recomputed, 1e-8);
        assert!(!certificate.penetration.holds());
        assert!((certificate.complementarity.relative - 1e-3 / 2.5).abs() < 1e-15);
    }

    /// A block pressed by 2 that slips by 0.5 against Coulomb friction 0.5: springs of compliance 1.
    fn slipping() -> (DualProblem, Multipliers) {
        let problem = DualProblem::new(
            Compliance::Dense(Mat::from_fn(2, 2, |i, j| f64::from(i == j))),
            vec![2.0, 1.5],
            AdmissibleSet::new(vec![Friction::Coulomb { coefficient: 0.5 }.block(1)]),
            Balance::none(2),
        )
        .unwrap();
        let answer = Multipliers {
            lambda: vec![2.0, 1.0],
            alpha: Vec::new(),
        };
        (problem, answer)
    }

    #[test]
    fn dissipated_work_is_no_energy_gap() {
        let (problem, answer) = slipping();
        let certificate = problem.certify(&answer, 1e-12);
        assert!(certificate.holds(), "{certificate}");
        assert!(problem.kkt_residual(&answer) < 1e-15);
        let gap = problem.gap(&answer);
        assert_eq!(problem.dissipation(&answer.lambda, &gap), 0.5);
    }

    #[test]
    fn wrong_shear_fails_in_slip_and_in_energy() {
        let (problem, answer) = slipping();
        for shear in [1.0 + 1e-6, 1.0 - 1e-6, 0.0, -1.0, f64::NAN] {
            let mut wrong = answer.clone();
            wrong.lambda[1] = shear;
            let certificate = problem.certify(&wrong, 1e-8);
            assert!(!certificate.slip_violation.holds(), "{shear}");
            assert!(!certificate.energy_gap.holds(), "{shear}");
            let residual = problem.kkt_residual(&wrong);
            assert!(residual > 1e-8 || residual.is_nan());
        }
    }

    /// Two tied components, a frictionless node, one with Coulomb's law in space and one with Tresca's in the plane; sinking
    /// and tipping are free.
    fn every_kind() -> DualProblem {
        let f = Mat::from_fn(8, 8, |i, j| {
            let (a, b) = (i.min(j), i.max(j));
            if i == j {
                2.0
            } else {
                0.3 * ((a * 7 + b) as f64).sin()
            }
        });
        let modes = Mat::from_fn(2, 8, |i, j| if i == 0 { 1.0 } else { 0.2 * j as f64 - 0.7 });
        let blocks = vec![
            Block::Free { size: 2 },
            Block::Unilateral,
            Friction::Coulomb { coefficient: 0.4 }.block(2),
            Friction::Tresca { bound: 0.3 }.block(1),
        ];
        let mut problem = DualProblem::new(
            Compliance::Dense(f),
            (0..8).map(|i| (1.3 * i as f64).cos()).collect(),
            AdmissibleSet::new(blocks),
            Balance::new(modes, vec![1.5, -0.6]).with_moments(vec![false, true]),
        )
        .unwrap();
        problem.scales.moment_arm = 2.5;
        problem.scales.energy = 0.7;
        problem.softness = (0..8).map(|i| 0.5 + 0.1 * i as f64).collect();
        problem
    }

    /// Wrong answers.
    fn wrong_answers() -> Vec<Multipliers> {
        let numbers = crate::linalg::grid::noise(400);
        let of = |numbers: &[f64]| Multipliers {
            lambda: numbers[..8].iter().map(|x| 2.0 * x).collect(),
            alpha: numbers[8..].to_vec(),
        };
        numbers.chunks_exact(10).map(of).collect()
    }

    #[test]
    fn figures_are_those_of_the_table_for_any_answer() {
        let problem = every_kind();
        let Compliance::Dense(f) = &problem.compliance else {
            panic!("F was given");
        };
        let g = problem.balance.modes().to_dense();
        for Multipliers { lambda, alpha } in wrong_answers() {
            let sum = |term: &dyn Fn(usize) -> f64| (0..8).map(term).sum::<f64>();
            let product = |i: usize| sum(&|j| f[(i, j)] * lambda[j]);
            let rigid = |j: usize| g[(0, j)] * alpha[0] + g[(1, j)] * alpha[1];
            let gap: Vec<f64> = (0..8)
                .map(|i| product(i) - problem.shift[i] - rigid(i))
                .collect();
            let rest = [0, 1].map(|k| sum(&|j| g[(k, j)] * lambda[j]) - problem.balance.load()[k]);
            let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
            let normal = [2, 3, 6];
            let depth = normal.map(|i| -gap[i]);
            let bounds = [0.4 * lambda[3].max(0.0), 0.3];
            let trial = |i: usize| lambda[i] - gap[i] / problem.softness[i];
            // the tangents of both nodes: those in space beside each other, that in the plane alone
            let far = f64::hypot(trial(4), trial(5));
            let cut = if far > bounds[0] {
                bounds[0] / far
            } else {
                1.0
            };
            let slips = [
                f64::hypot(lambda[4] - cut * trial(4), lambda[5] - cut * trial(5)),
                (lambda[7] - trial(7).clamp(-0.3, 0.3)).abs(),
            ];
            let slip = largest(&slips);
            let pushes = normal.map(|i| (lambda[i] - trial(i).max(0.0)).abs());
            let pulls = [0, 1].map(|i| (gap[i] / problem.softness[i]).abs());
            let dissipated = bounds[0] * f64::hypot(gap[4], gap[5]) + bounds[1] * gap[7].abs();
            let work = sum(&|i| lambda[i] * gap[i]);
            let energy = 0.7 + 0.5 * sum(&|i| lambda[i] * product(i));
            let borne = largest(&lambda.iter().map(|l| l.abs()).collect::<Vec<_>>());
            let force = borne.max(1.5);
            let contacts = [0, 1, 2, 3, 6];
            let expected = [
                (
                    "penetration",
                    largest(&[depth[0], depth[1], depth[2], gap[0].abs(), gap[1].abs()]),
                    1.0,
                ),
                ("tension", largest(&normal.map(|i| -lambda[i])), borne),
                (
                    "complementarity",
                    contacts.iter().map(|&i| (lambda[i] * gap[i]).abs()).sum(),
                    energy,
                ),
                ("imbalance_force", rest[0].abs(), force),
                ("imbalance_moment", 2.5 * rest[1].abs(), 2.5 * force),
                (
                    "energy_gap",
                    (work + dissipated + alpha[0] * rest[0] + alpha[1] * rest[1]).abs(),
                    energy,
                ),
                ("slip_violation", slip, borne),
                (
                    "force_error",
                    largest(&[largest(&pushes), largest(&pulls), slip]),
                    borne,
                ),
                ("rounding", 0.0, borne),
                ("between_nodes", 0.0, 1.0),
            ];
            let answer = Multipliers { lambda, alpha };
            let certificate = problem.certify(&answer, 1e-6);
            let limits = [1e-6, 1e-6, 1e-6, 1e-10, 1e-10, 1e-6, 1e-6, 1e-5, 1e-2, 10.0];
            for ((name, found), ((own, value, scale), limit)) in certificate
                .figures()
                .iter()
                .zip(expected.iter().zip(limits))
            {
                assert_eq!(name, own);
                // sums of some dozens of numbers
                assert!(
                    (found.value - value).abs() < 1e-13 * value.max(1.0),
                    "{name} {} {value}",
                    found.value
                );
                assert!(
                    (found.relative - value / scale).abs() < 1e-13 * value.max(1.0),
                    "{name}"
                );
                assert!(
                    (found.limit - limit).abs() < 1e-20,
                    "{name} {}",
                    found.limit
                );
            }
            // the scale of lengths is max|d| = cos 0, and solvers stop on the worst of all figures, in tolerances
            let of = |(k, (_, value, scale)): (usize, &(&str, f64, f64))| {
                value / scale / if k == 7 { 10.0 } else { 1.0 }
            };
            let worst = expected.iter().enumerate().map(of).fold(0.0, f64::max);
            let residual = problem.kkt_residual(&answer);
            assert!(
                (residual - worst).abs() < 1e-13 * worst.max(1.0),
                "{residual} {worst}"
            );
        }
    }

    #[test]
    fn solvers_stop_on_the_worst_figure_whichever_it_is() {
        let residual = |change: fn(&mut Violations, Worst), value: f64| {
            let mut violations = Violations::default();
            change(&mut violations, Worst { value, scale: 2.0 });
            violations.residual()
        };
        assert_eq!(Violations::default().residual(), 0.0);
        let changes: [fn(&mut Violations, Worst); 7] = [
            |v, worst| v.penetration = worst,
            |v, worst| v.tension = worst,
            |v, worst| v.complementarity = worst,
            |v, worst| v.imbalance_force = worst,
            |v, worst| v.imbalance_moment = worst,
            |v, worst| v.energy_gap = worst,
            |v, worst| v.slip = worst,
        ];
        for change in changes {
            assert_eq!(residual(change, 8.0), 4.0);
            assert!(residual(change, f64::NAN).is_nan());
        }
        let error = residual(|v, worst| v.force_error = worst, 8.0);
        assert!((error - 0.4).abs() < 1e-15);
    }

    #[test]
    fn the_worst_is_that_beside_its_scale() {
        let mut worst = Worst::default();
        for (value, scale, relative) in [
            (1.0, 10.0, 0.1),
            (0.5, 1.0, 0.5),
            (3.0, 100.0, 0.5),
            // a scale of zero is one
            (0.7, 0.0, 0.7),
            (f64::NAN, 1.0, f64::NAN),
            (5.0, 1.0, f64::NAN),
        ] {
            worst.raise(value, scale);
            let found = worst.relative();
            assert!(found == relative || (found.is_nan() && relative.is_nan()));
        }
    }

    /// Two uncoupled plates, the second one with a billion times the forces of the first one: a millionth of the forces of the first is
    /// negligible beside those of the second, and still a violation in its own domain.
    #[test]
    fn what_bears_a_far_domain_is_no_scale() {
        let far = 1e9;
        let mut problem = DualProblem::new(
            Compliance::Dense(Mat::from_fn(4, 4, |i, j| f64::from(i == j))),
            vec![1.0, 0.0, far, 0.0],
            AdmissibleSet::new(vec![Block::Unilateral; 4]),
            Balance::new(
                Mat::from_fn(2, 4, |i, j| f64::from(i == j / 2)),
                vec![3.0, 3.0 * far],
            ),
        )
        .unwrap();
        let answer = |error: f64| Multipliers {
            lambda: vec![2.0 + error, 1.0 - error, 2.0 * far, far],
            alpha: vec![1.0, far],
        };
        let wrong = answer(1e-6);
        assert!(problem.certify(&wrong, 1e-8).holds());
        assert!(problem.kkt_residual(&wrong) < 1e-8);
        problem.coupled = Coupled {
            contact: vec![0, 0, 1, 1],
            domain: vec![0, 1],
            modes: vec![0, 1],
            scales: [1.0, far]
                .map(|size| Scales {
                    length: size,
                    force: 3.0 * size,
                    ..Scales::default()
                })
                .to_vec(),
        };
        let certificate = problem.certify(&wrong, 1e-8);
        let violated = certificate.figures().into_iter().filter(|f| !f.1.holds());
        let violated: Vec<&str> = violated.map(|(name, _)| name).collect();
        let expected = [
            "penetration",
            "complementarity",
            "energy_gap",
            "force_error",
        ];
        assert_eq!(violated, expected);
        assert!((certificate.force_error.relative - 0.5e-6).abs() < 1e-12);
        assert!(problem.kkt_residual(&wrong) > 1e-8);
        assert!(problem.certify(&answer(0.0), 1e-8).holds());
        // two contacts of one domain: each by its own forces, down to a thousandth of the larger ones
        problem.coupled.domain = vec![0, 0];
        problem.coupled.modes = vec![0, 0];
        problem.coupled.scales = vec![problem.scales];
        let error = problem.certify(&answer(0.1), 1e-8).force_error;
        assert!((error.value - 0.1).abs() < 1e-4, "{error:?}");
        assert!((error.relative * 1e-3 * 2.0 * far - 0.1).abs() < 1e-4);
    }

    #[test]
    fn scales_of_zero_count_as_one() {
        let problem = DualProblem::new(
            Compliance::Dense(Mat::from_fn(2, 2, |i, j| f64::from(i == j))),
            vec![0.0; 2],
            AdmissibleSet::new(vec![Block::Unilateral; 2]),
            Balance::new(Mat::from_fn(1, 2, |_, _| 1.0), vec![0.0]),
        )
        .unwrap();
        let answer = Multipliers {
            lambda: vec![0.0; 2],
            alpha: vec![0.25],
        };
        let certificate = problem.certify(&answer, 1e-8);
        let Figure {
            value, relative, ..
        } = certificate.penetration;
        assert!((value - 0.25).abs() < 1e-14 && relative == value);
        assert!((problem.kkt_residual(&answer) - 0.25).abs() < 1e-14);
        assert_eq!(Figure::new(3.0, 0.0, 1.0).relative, 3.0);
        assert_eq!(Figure::new(3.0, 0.5, 1.0).relative, 6.0);
    }

    #[test]
    fn a_figure_holds_up_to_its_limit() {
        assert!(Figure::new(2.0, 2.0, 1.0).holds());
        assert!(!Figure::new(2.0 + 1e-15, 2.0, 1.0).holds());
        assert!(!Figure::new(f64::NAN, 2.0, 1.0).holds());
        assert!(Certificate::default().holds());
    }

    #[test]
    fn objection_names_what_does_not_hold_and_how_far() {
        let (problem, answer) = plate();
        let mut certificate = problem.certify(&answer, 1e-8);
        certificate.imbalance_moment = Figure::new(0.5, 2.0, 1e-10);
        certificate.force_error = Figure::new(3e-3, 1.0, 1e-7);
        assert_eq!(
            certificate.objection(),
            "the certificate does not hold: imbalance moment 2.5e-1 > 1e-10, force error 3.0e-3 > 1e-7"
        );
        let told = certificate.to_string();
        let lines: Vec<&str> = told.lines().collect();
        assert_eq!(
            lines[4],
            "imbalance moment    5.000e-1, relative 2.5e-1, limit 1e-10: VIOLATED"
        );
        assert_eq!(
            lines
                .iter()
                .filter(|line| line.ends_with(": holds"))
                .count(),
            9
        );
    }

    #[test]
    fn what_is_rounding_of_large_motions_is_no_gap() {
        // a body moved by 10⁶: gaps are known to ROUNDING times the sum of motion and overlap, 8e-9
        let known = 2e6 * ROUNDING;
        let figures = |gap: f64| {
            let problem = DualProblem::new(
                Compliance::Dense(Mat::from_fn(1, 1, |_, _| 1.0)),
                vec![1e6 - gap],
                AdmissibleSet::new(vec![Block::Free { size: 1 }]),
                Balance::new(Mat::from_fn(1, 1, |_, _| 1.0), vec![0.0]),
            );
            let problem = problem.unwrap();
            let answer = Multipliers {
                lambda: vec![0.0],
                alpha: vec![-1e6],
            };
            let own = problem.rounding(&problem.gap(&answer), &answer.alpha)(0);
            assert!((own - known).abs() < 1e-6 * known, "{own:e}");
            problem.certify(&answer, 1e-8).penetration.value
        };
        // powers of two, so that the gap itself is exact
        let (below, above) = (2f64.powi(-27), 2f64.powi(-26));
        assert!(below < known && known < above);
        assert_eq!([figures(below), figures(-below)], [0.0; 2]);
        for gap in [above, -above] {
            assert!((figures(gap) - (above - known)).abs() < 1e-6 * known);
        }
    }

    #[test]
    fn uncertainty_is_taken_off_either_sign() {
        assert_eq!([0.5, -0.5, 0.25, -0.25].map(|x| beyond(x, 0.5)), [0.0; 4]);
        assert_eq!([2.0, -2.0].map(|x| beyond(x, 0.5)), [1.5, -1.5]);
        assert!(beyond(f64::NAN, 0.5).is_nan());
        assert_eq!((larger(1.0, 2.0), larger(2.0, 1.0)), (2.0, 2.0));
        assert!(larger(1.0, f64::NAN).is_nan() && larger(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn what_the_caller_found_counts_beside_the_gaps() {
        let (problem, answer) = plate();
        let none = Recomputed {
            gap: &[0.0; 2],
            rounding: &[0.0; 2],
            exact: Vec::new(),
            open: Vec::new(),
            between: [0.0, 1.0],
            domains: vec![OfDomain {
                elastic_energy: 2.5,
                ..OfDomain::default()
            }],
        };
        let certify = |change: fn(&mut Recomputed)| {
            let mut found = none.clone();
            change(&mut found);
            problem.certify_with(&answer, &found, 1e-8)
        };
        assert!(certify(|_| ()).holds());
        assert_eq!(
            certify(|f| f.domains[0].implied = 0.5).penetration.value,
            0.5
        );
        assert_eq!(certify(|f| f.exact = vec![0.1, 0.5]).force_error.value, 0.5);
        let open = certify(|f| f.open = vec![0.0, 1.5]).rounding;
        // forces of 2
        assert_eq!((open.value, open.relative, open.limit), (1.5, 0.75, 1e-2));
        let between = certify(|f| f.between = [0.5, 0.25]).between_nodes;
        assert_eq!(
            (between.value, between.relative, between.limit),
            (0.5, 2.0, 10.0)
        );
        assert_eq!(
            certify(|f| f.domains[0].imbalance_force = 0.5)
                .imbalance_force
                .value,
            0.5
        );
        let moment = certify(|f| f.domains[0].imbalance_moment = 0.5).imbalance_moment;
        // an arm of zero counts as one; the load of 3 is the scale of forces
        assert_eq!((moment.value, moment.relative), (0.5, 0.5 / 3.0));
        let gap = certify(|f| f.domains[0].energy_gap = 0.5).energy_gap;
        assert_eq!((gap.value, gap.relative), (0.5, 0.2));
        let driven = |f: &mut Recomputed| {
            let own = &mut f.domains[0];
            (own.imbalance_force, own.driving_force) = (0.5, 10.0);
        };
        assert_eq!(certify(driven).imbalance_force.relative, 0.05);
        // a gap whose uncertainty covers it
        let told = certify(|f| (f.gap, f.rounding) = (&[0.0, -1e-3], &[0.0, 2e-3]));
        assert_eq!(told.penetration.value, 0.0);
    }

    #[test]
    fn least_settled_force_is_the_one_farthest_from_its_law() {
        let (problem, answer) = plate();
        let least = |lambda: [f64; 2], alpha: f64| {
            problem.least_settled(&Multipliers {
                lambda: lambda.to_vec(),
                alpha: vec![alpha],
            })
        };
        // gaps are λ − (1, 0) − α, and both springs have the compliance 1
        assert_eq!(least([3.0, 1.1], answer.alpha[0]), Some(0));
        assert_eq!(least([2.1, 3.0], answer.alpha[0]), Some(1));
        // an open contact without a force is settled, however wide it is
        assert_eq!(least([0.0, 0.0], -5.0), least([0.0, 0.0], -7.0));
        assert_eq!(least([f64::NAN, 1.5], 1.0), Some(1));
        assert_eq!(least([f64::NAN; 2], 1.0), None);
        // the compliance of a contact turns its gap into a force
        let (mut stiff, _) = plate();
        stiff.softness = vec![100.0, 0.1];
        let both = Multipliers {
            lambda: vec![4.0, 1.5],
            alpha: vec![1.0],
        };
        assert_eq!(stiff.least_settled(&both), Some(1));
        // and the force that a law asks for is taken at the trial force
        let (slipping, _) = slipping();
        let sheared = |shear: f64| Multipliers {
            lambda: vec![2.0, shear],
            alpha: Vec::new(),
        };
        assert_eq!(slipping.least_settled(&sheared(0.5)), Some(1));
    }
}
