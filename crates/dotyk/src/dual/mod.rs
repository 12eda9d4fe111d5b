//! The waist: the dual contact problem, its admissible set, its projection and its certificate. Pure algebra.
//!
//! ```text
//!   min  1/2 λᵀFλ − dᵀλ    over λ ∈ Λ,  subject to  Gλ = e,     gap(λ, α) = Fλ − d − Gᵀα
//! ```
//!
//! It knows no mesh, no body, no dimension.
//!
//! | Symbol | Meaning | Shape | Unit |
//! |---|---|---|---|
//! | λ | contact forces | (m,) | force |
//! | F | compliance of the bodies seen from the contact, symmetric, positive semidefinite | (m, m) | length / force |
//! | d | overlap of the separately loaded bodies | (m,) | length |
//! | G, e | balance of the floating bodies, modes scaled to largest displacement 1 | (r, m), (r,) | –, force |
//! | α | rigid amplitudes, the multiplier of Gλ = e | (r,) | length |
//!
//! Signs: gap ≥ 0 is open, λ ≥ 0 is compression. With friction the block of a node is (normal, tangential..); its
//! tangential gap is minus the slip of the nonmortar body relative to the mortar body in this step (d holds the slip at the
//! last one), and its tangential force is along the slip: λₜ = bound · slip/|slip|, less than the bound where it sticks.
//!
//! The gap is the gradient of the dual functional, so that a solver needs
//! nothing but products with F and the projection onto Λ ∩ {Gλ = e}, and every answer, whoever found it, is judged by the
//! same [`Certificate`].

mod admissible;
mod balance;
mod certificate;
mod cone;
mod feasibility;
mod law;
mod modes;
mod projection;
mod split;

pub use admissible::{AdmissibleSet, Component};
pub use balance::Balance;
pub(crate) use certificate::{
    BETWEEN_LIMIT, FORCE_LIMIT, NOT_OF_THE_SOLVER, ROUNDING, Violations, above,
};
pub use certificate::{Certificate, Figure, IMBALANCE_LIMIT, OfDomain, OfYield, Recomputed};
pub use feasibility::{Feasibility, NO_WORK};
pub(crate) use law::NONE;
pub use law::{Block, Friction, Told};
pub use modes::Modes;
pub use projection::Projector;
pub use split::ModeSplit;

use crate::linalg::dense::matvec;
use crate::linalg::{LinalgError, LinearOperator, Mat, SparseMatrix, SparseVector};

/// F, the compliance of the bodies seen from the contact unknowns: (m, m), symmetric, positive semidefinite.
pub enum Compliance {
    /// Assembled.
    Dense(Mat<f64>),
    /// Assembled without its zeros: of many bodies each is touched by few contacts. It may be unsymmetric.
    Sparse(SparseMatrix),
    /// Applied by one solve with each factored body.
    Operator {
        /// x ↦ Fx.
        apply: Box<dyn LinearOperator>,
        /// x ↦ Mx, an approximation of F⁻¹ (scaled Dirichlet preconditioner).
        preconditioner: Box<dyn LinearOperator>,
        /// The forces that glue the pieces of which bodies are made.
        glue: Option<Box<dyn Glue>>,
    },
}

/// Bodies in pieces: contact forces λ (m,) beside forces t (g,) of the glue, which have no resultant, and jumps (g,) of the
/// displacements. F belongs to the forces of the glue that leave no jumps. Pieces have N rigid motions R; those that the forces of the
/// glue resist, seen as springs of stiffness D, have the stiffness RᵀDJR.
pub trait Glue: Send + Sync {
    /// Number g of forces of the glue.
    fn len(&self) -> usize;
    /// There is no glue.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Number N of rigid motions of all pieces.
    fn modes(&self) -> usize;
    /// BR: of every contact row (m) its motions by those of pieces.
    fn motions(&self) -> &[Vec<(usize, f64)>];
    /// Whether some dof yields to a force on a contact row, (m,).
    fn yields(&self) -> &[bool];
    /// Entries of RᵀDJR (N, N), of which those above the diagonal may be missing.
    fn network(&self) -> Vec<(usize, usize, f64)>;
    /// work = Rᵀt, (N,).
    fn works(&self, t: &[f64], work: &mut [f64]);
    /// pull = RᵀDJu, (N,), of jumps.
    fn pulls(&self, jumps: &[f64], pull: &mut [f64]);
    /// t ← t + DJRβ.
    fn push(&self, amplitudes: &[f64], t: &mut [f64]);
    /// Jumps ← jumps + JRα.
    fn part(&self, amplitudes: &[f64], jumps: &mut [f64]);
    /// The motion of the contact rows (m,) and the jumps (g,) under balanced forces, pieces `placed` such that the jumps are least, or
    /// somewhere.
    fn respond(
        &self,
        forces: (&[f64], &[f64]),
        placed: bool,
        product: &mut [f64],
        jumps: &mut [f64],
    );
    /// Products with F that cost as much as another way to the answer.
    fn enough(&self) -> usize {
        usize::MAX
    }
    /// Keeps the forces of the glue that belong to λ: displacements under λ are soon asked for.
    fn keep(&self, lambda: &[f64], t: &[f64]);
    /// Forces (m,) and (g,) that about cause some motions of the contact rows (m,) and jumps (g,).
    fn precondition(&self, product: &[f64], jumps: &[f64], lambda: &mut [f64], t: &mut [f64]);
}

impl Compliance {
    /// Number m of contact forces.
    pub fn len(&self) -> usize {
        match self {
            Self::Dense(matrix) => matrix.nrows(),
            Self::Sparse(matrix) => matrix.rows(),
            Self::Operator { apply, .. } => apply.len(),
        }
    }

    /// There is no contact force.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// y = Fx. Shapes: both (m,). Units: x force, y length.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Dense(matrix) => matvec(matrix, x, y),
            Self::Sparse(matrix) => matrix.mul(x, y),
            Self::Operator { apply, .. } => apply.apply(x, y),
        }
    }

    /// Products with F that cost as much as another way to the answer.
    pub(crate) fn enough(&self) -> usize {
        match self {
            Self::Operator {
                glue: Some(glue), ..
            } => glue.enough(),
            _ => usize::MAX,
        }
    }

    /// The diagonal of an assembled F, (m,).
    pub fn diagonal(&self) -> Option<Vec<f64>> {
        let entry = |i: usize| match self {
            Self::Dense(matrix) => Some(matrix[(i, i)]),
            Self::Sparse(matrix) => {
                let own = matrix.row(i).find(|&(j, _)| j == i);
                Some(own.map_or(0.0, |(_, value)| value))
            }
            Self::Operator { .. } => None,
        };
        (0..self.len()).map(entry).collect()
    }
}

/// Fewest floating modes of a crowd.
const CROWD: usize = 96;

/// Columns of F that are assembled at a time.
const COLUMNS: usize = 256;

/// λ and α: contact forces (m,) and rigid amplitudes (r,), the multiplier of Gλ = e.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipliers {
    /// Contact forces (m,).
    pub lambda: Vec<f64>,
    /// Rigid displacement amplitudes of the floating bodies (r,).
    pub alpha: Vec<f64>,
}

/// Scales of lengths, forces, moments and energies. A scale of zero counts as 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scales {
    /// max|d|.
    pub length: f64,
    /// Largest resultant load; the largest contact force is added by the certificate where it is larger.
    pub force: f64,
    /// Largest body diameter: moments are compared with force times this.
    pub moment_arm: f64,
    /// Elastic energy that does not come from λ; 1/2 λᵀFλ is added by the certificate.
    pub energy: f64,
}

/// The contact of each component and the domain of each contact. A domain is a set of bodies coupled by contacts; its figures are
/// compared with its own scales. Missing entries belong to the first one; if empty, all is one contact.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Coupled {
    /// Contact of every component, (m,).
    pub contact: Vec<usize>,
    /// Domain of every contact.
    pub domain: Vec<usize>,
    /// Domain of every mode, (r,).
    pub modes: Vec<usize>,
    /// Scales of every domain; where missing, those of the problem.
    pub scales: Vec<Scales>,
}

impl Coupled {
    /// Number of contacts.
    pub(crate) fn contacts(&self) -> usize {
        self.domain.len().max(1)
    }

    /// Number of domains.
    pub(crate) fn domains(&self) -> usize {
        self.scales.len().max(1)
    }

    /// Contact of a component.
    pub(crate) fn contact(&self, component: usize) -> usize {
        self.contact.get(component).copied().unwrap_or(0)
    }

    /// Domain of a contact.
    pub(crate) fn domain(&self, contact: usize) -> usize {
        self.domain.get(contact).copied().unwrap_or(0)
    }

    /// Domain of a component.
    pub(crate) fn domain_of(&self, component: usize) -> usize {
        self.domain(self.contact(component))
    }

    /// Domain of a mode.
    pub(crate) fn domain_of_mode(&self, mode: usize) -> usize {
        self.modes.get(mode).copied().unwrap_or(0)
    }
}

impl Scales {
    /// Scales that follow from d and e alone.
    pub fn of(shift: &[f64], balance: &Balance) -> Self {
        let largest = |v: &[f64]| v.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
        Self {
            length: largest(shift),
            force: largest(balance.load()),
            moment_arm: 0.0,
            energy: 0.0,
        }
    }
}

/// Why data make no [`DualProblem`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DualError {
    /// Two parts have different numbers of contact forces or modes.
    #[error("{part} has length {found}, but {expected} is expected")]
    Length {
        /// Which part.
        part: &'static str,
        /// Its length.
        found: usize,
        /// The length that the compliance (m) or the load (r) asks for.
        expected: usize,
    },
    /// A bound or a coefficient of friction is negative or not a finite number.
    #[error(
        "the friction of block {block} of the admissible set is {value}: it must be a number from 0 on"
    )]
    Friction {
        /// Index of the block.
        block: usize,
        /// Its bound or its coefficient.
        value: f64,
    },
    /// The rigid modes cannot be split by what the contact controls.
    #[error("what the contact controls of the rigid modes cannot be told: {0}")]
    Modes(LinalgError),
    /// An entry is not a finite number.
    #[error("entry {index} of {part} is {value}: it must be finite")]
    NotFinite {
        /// Which part.
        part: &'static str,
        /// Index, column-major for matrices.
        index: usize,
        /// The entry.
        value: f64,
    },
}

/// The dual contact problem: min 1/2 λᵀFλ − dᵀλ over λ ∈ Λ with Gλ = e.
pub struct DualProblem {
    /// F.
    pub compliance: Compliance,
    /// d, (m,).
    pub shift: Vec<f64>,
    /// Λ.
    pub admissible: AdmissibleSet,
    /// Gλ = e.
    pub balance: Balance,
    /// Scales of violations, where all is one domain.
    pub scales: Scales,
    /// Contacts and domains, which are judged separately.
    pub coupled: Coupled,
    /// Compliance of every component alone, (m,), length over force: it turns a gap into a force.
    pub softness: Vec<f64>,
    /// Pairs of blocks that lie beside each other on a contact; may be empty. They tell solvers which contacts to take
    /// together in coarser problems.
    pub neighbours: Vec<[usize; 2]>,
    /// F body by body, where it is assembled without its zeros; else empty. F is their sum.
    pub parts: Vec<Part>,
}

/// The part of F of one body: BᵀS⁻¹B with its boundary stiffness S.
#[derive(Debug, Clone)]
pub struct Part {
    /// Its contact forces, n numbers below m.
    pub rows: Vec<usize>,
    /// S, (c, c), force over length, definite: the stiffness condensed onto the dofs of its contacts, without rigid motions.
    pub stiffness: Mat<f64>,
    /// B by columns, n vectors (c,).
    pub columns: Vec<SparseVector>,
}

impl DualProblem {
    /// Many floating bodies with friction, F known entry by entry or body by body: they share their forces in many ways, so
    /// that states of contacts do not determine them.
    pub(crate) fn is_crowd(&self) -> bool {
        let known = matches!(self.compliance, Compliance::Dense(_)) || !self.parts.is_empty();
        let many = self.balance.rank() >= CROWD && known;
        many && self.admissible.bounds_follow() && !self.admissible.jumps()
    }

    /// The problem with scales from its data; the softness is the diagonal of an assembled F, its mean over the tangents
    /// of a node, else the same for all components.
    ///
    /// Errors: lengths that differ, entries of d, G or e that are not finite, friction that is negative.
    pub fn new(
        compliance: Compliance,
        shift: Vec<f64>,
        admissible: AdmissibleSet,
        balance: Balance,
    ) -> Result<Self, DualError> {
        let scales = Scales::of(&shift, &balance);
        let mut problem = Self {
            softness: vec![1.0; shift.len()],
            coupled: Coupled::default(),
            neighbours: Vec::new(),
            parts: Vec::new(),
            compliance,
            shift,
            admissible,
            balance,
            scales,
        };
        problem.check()?;
        problem.softness = problem.diagonal_softness();
        Ok(problem)
    }

    fn diagonal_softness(&self) -> Vec<f64> {
        match self.compliance.diagonal() {
            Some(diagonal) => self.positive_softness(diagonal),
            None => {
                let or_one = |scale: f64| if scale > 0.0 { scale } else { 1.0 };
                let ratio = or_one(self.scales.length) / or_one(self.scales.force);
                vec![ratio; self.len()]
            }
        }
    }

    /// Sets the softness to the larger of the diagonal of F and `least`, a lower bound of every component's compliance, (m,). The
    /// diagonal may be smaller where a body is grounded; if F is applied the diagonal is not known.
    pub(crate) fn soften(&mut self, least: Vec<f64>) {
        self.softness = match self.compliance.diagonal() {
            Some(diagonal) => {
                let larger = least.iter().zip(&diagonal).map(|(a, b)| a.max(*b));
                self.positive_softness(larger.collect())
            }
            None => self.positive_softness(least),
        };
    }

    /// Assembles F with all its zeros if it has at most `limit` unknowns; an applied F by products with unit forces. `true` if it
    /// did.
    pub fn assemble(&mut self, limit: usize) -> bool {
        let m = self.len();
        if m > limit {
            return false;
        }
        let f = match &self.compliance {
            Compliance::Dense(_) => return false,
            Compliance::Sparse(matrix) => matrix.to_dense(),
            Compliance::Operator { apply, .. } => of_products(apply.as_ref()),
        };
        let known = self.compliance.diagonal().is_some();
        self.compliance = Compliance::Dense(f);
        // a softness that includes the diagonal stays: means over tangents are not taken twice
        if !known {
            let least = std::mem::take(&mut self.softness);
            self.soften(least);
        }
        true
    }

    /// Means over the tangents of a node; a component of zero softness takes the scale of the others.
    fn positive_softness(&self, mut softness: Vec<f64>) -> Vec<f64> {
        for (block, range) in self.admissible.iter() {
            if block.friction().is_some() {
                let tangents = &mut softness[block.shear(&range)];
                let mean = tangents.iter().sum::<f64>() / tangents.len().max(1) as f64;
                tangents.fill(mean);
            }
        }
        let largest = softness.iter().fold(0.0, |s: f64, f| s.max(*f));
        let fallback = if largest > 0.0 { largest } else { 1.0 };
        let rigid = softness.iter_mut().filter(|f| **f <= 0.0);
        rigid.for_each(|f| *f = fallback);
        softness
    }

    /// Lengths agree, d, G, e and an assembled F are finite, friction is finite and not negative.
    pub fn check(&self) -> Result<(), DualError> {
        let (m, r) = (self.compliance.len(), self.balance.load().len());
        let lengths = [
            ("d", self.shift.len(), m),
            ("the admissible set", self.admissible.len(), m),
            ("the softness", self.softness.len(), m),
            ("a row of G", self.balance.modes().ncols(), m),
            ("a column of G", self.balance.modes().nrows(), r),
            ("the list of moment rows", self.balance.moments().len(), r),
        ];
        agree(lengths)?;
        finite("d", self.shift.iter())?;
        finite("e", self.balance.load().iter())?;
        let modes = self.balance.modes().columns().iter();
        finite("G", modes.flat_map(SparseVector::values))?;
        self.balance.split().map_err(DualError::Modes)?;
        match &self.compliance {
            Compliance::Dense(matrix) => finite("F", columns(matrix))?,
            Compliance::Sparse(matrix) => finite("F", matrix.values().iter())?,
            Compliance::Operator { .. } => {}
        }
        let blocks = self.admissible.blocks().len();
        if let Some(&found) = self
            .neighbours
            .iter()
            .flatten()
            .find(|&&block| block >= blocks)
        {
            agree([("the list of neighbours", found + 1, blocks)])?;
        }
        for Part {
            rows,
            stiffness,
            columns,
        } in &self.parts
        {
            let own = stiffness.nrows();
            let last = rows.iter().max().map_or(0, |row| row + 1);
            let shapes = [
                ("the columns of a part of F", columns.len(), rows.len()),
                ("a stiffness of a part of F", stiffness.ncols(), own),
                ("the rows of a part of F", last.max(m), m),
            ];
            let columns = columns.iter();
            let columns = columns.map(|column| ("a column of a part of F", column.len(), own));
            agree(shapes.into_iter().chain(columns))?;
        }
        for (block, law) in self.admissible.blocks().iter().enumerate() {
            let Some(touch) = law.friction().map(|law| law.touch(0.0)) else {
                continue;
            };
            let wrong = |value: &f64| !(*value >= 0.0 && value.is_finite());
            if let Some(value) = [touch.given, touch.growth].into_iter().find(wrong) {
                return Err(DualError::Friction { block, value });
            }
        }
        Ok(())
    }

    /// λ and α fit this problem: (m,) and (r,), all finite.
    pub fn check_multipliers(&self, multipliers: &Multipliers) -> Result<(), DualError> {
        let Multipliers { lambda, alpha } = multipliers;
        for (part, values, expected) in [
            ("λ", lambda, self.len()),
            ("α", alpha, self.balance.load().len()),
        ] {
            agree([(part, values.len(), expected)])?;
            finite(part, values.iter())?;
        }
        Ok(())
    }

    /// Number m of contact forces.
    pub fn len(&self) -> usize {
        self.shift.len()
    }

    /// There is no contact force.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Gap at the contact unknowns, Fλ − d − Gᵀα; the gradient of the dual functional.
    ///
    /// Shapes: λ and the gap (m,), α (r,). Units: λ force, gap and α length. Panics if lengths differ.
    /// Source: Janovský & Procházka (1980) III, section 7, STEP 1.
    pub fn gap(&self, multipliers: &Multipliers) -> Vec<f64> {
        let mut product = vec![0.0; self.len()];
        self.compliance.apply(&multipliers.lambda, &mut product);
        let mut gap = vec![0.0; self.len()];
        self.gap_from_product(&product, &multipliers.alpha, &mut gap);
        gap
    }

    /// Gap from the product Fλ. Shapes: `product` and `gap` (m,), `alpha` (r,).
    pub(crate) fn gap_from_product(&self, product: &[f64], alpha: &[f64], gap: &mut [f64]) {
        for (i, gap) in gap.iter_mut().enumerate() {
            let rigid = self.balance.modes().motion(i, alpha);
            *gap = product[i] - self.shift[i] - rigid;
        }
    }

    /// λ = P(y), the nearest force that is admissible and balanced; y − λ − Gᵀτ is normal to Λ at λ.
    ///
    /// Shapes: y, λ (m,), `tau` (r,), starting value on entry. Returns ‖Gλ − e‖ in orthonormal modes, which is far from
    /// rounding only when no admissible force balances the load. Solvers keep a [`Projector`] instead.
    pub fn project(&self, y: &[f64], tau: &mut [f64], lambda: &mut [f64]) -> f64 {
        let balance = &self.balance;
        let mut reduced = vec![0.0; balance.rank()];
        balance.from_original(tau, &mut reduced);
        let rest = balance
            .projector(&self.admissible)
            .project(y, &mut reduced, lambda);
        balance.to_original(&reduced, tau);
        rest
    }
}

/// The symmetric matrix of an operator, from its products with unit vectors.
fn of_products(operator: &dyn LinearOperator) -> Mat<f64> {
    let m = operator.len();
    let mut f = Mat::<f64>::zeros(m, m);
    for first in (0..m).step_by(COLUMNS) {
        let width = COLUMNS.min(m - first);
        let units = Mat::from_fn(m, width, |i, j| f64::from(u8::from(i == first + j)));
        let images = operator.apply_many(&units);
        for j in 0..width {
            let column = f.col_as_slice_mut(first + j);
            column.copy_from_slice(images.col_as_slice(j));
        }
    }
    for j in 0..m {
        for i in 0..j {
            let mean = 0.5 * (f[(i, j)] + f[(j, i)]);
            (f[(i, j)], f[(j, i)]) = (mean, mean);
        }
    }
    f
}

fn columns(matrix: &Mat<f64>) -> impl Iterator<Item = &f64> {
    (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j))
}

/// Every length is the expected one.
fn agree(lengths: impl IntoIterator<Item = (&'static str, usize, usize)>) -> Result<(), DualError> {
    match lengths
        .into_iter()
        .find(|(_, found, expected)| found != expected)
    {
        None => Ok(()),
        Some((part, found, expected)) => Err(DualError::Length {
            part,
            found,
            expected,
        }),
    }
}

fn finite<'a>(
    part: &'static str,
    mut values: impl Iterator<Item = &'a f64>,
) -> Result<(), DualError> {
    let mut index = 0;
    let found = values.find(|value| {
        index += 1;
        !value.is_finite()
    });
    match found {
        None => Ok(()),
        Some(&value) => Err(DualError::NotFinite {
            part,
            index: index - 1,
            value,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix that can only be applied.
    struct Applied(Mat<f64>);

    impl LinearOperator for Applied {
        fn len(&self) -> usize {
            self.0.nrows()
        }

        fn apply(&self, x: &[f64], y: &mut [f64]) {
            matvec(&self.0, x, y);
        }
    }

    fn applied(f: &Mat<f64>) -> Compliance {
        Compliance::Operator {
            apply: Box::new(Applied(f.clone())),
            preconditioner: Box::new(Applied(Mat::identity(f.nrows(), f.nrows()))),
            glue: None,
        }
    }

    /// Each way to give F.
    fn ways(f: &Mat<f64>) -> [Compliance; 3] {
        let sparse = SparseMatrix::from_dense(f);
        [
            Compliance::Dense(f.clone()),
            Compliance::Sparse(sparse),
            applied(f),
        ]
    }

    /// Compliance of two nodes (normal, two tangents) and of a frictionless one, which is zero.
    fn soft() -> Mat<f64> {
        let diagonal = [3.0, 1.0, 5.0, 2.0, 4.0, 8.0, 0.0];
        Mat::from_fn(7, 7, |i, j| match i == j {
            true => diagonal[i],
            false => 0.1 * f64::from(u8::from(i + j == 3)),
        })
    }

    fn nodes() -> AdmissibleSet {
        let node = Friction::Coulomb { coefficient: 0.5 }.block(2);
        AdmissibleSet::new(vec![node, node, Block::Unilateral])
    }

    /// Two modes, sinking and tipping.
    fn modes() -> Mat<f64> {
        Mat::from_fn(2, 7, |i, j| if i == 0 { 1.0 } else { j as f64 - 3.0 })
    }

    fn problem(compliance: Compliance) -> DualProblem {
        let shift = vec![0.5, 0.1, 0.0, -0.75, 0.2, 0.0, 0.3];
        let balance = Balance::new(modes(), vec![2.0, -3.0]);
        DualProblem::new(compliance, shift, nodes(), balance).unwrap()
    }

    #[test]
    fn compliance_is_the_same_however_it_is_given() {
        let f = soft();
        let x: Vec<f64> = (0..7).map(|i| (i as f64).sin()).collect();
        for compliance in ways(&f) {
            assert_eq!((compliance.len(), compliance.is_empty()), (7, false));
            let mut y = vec![9.0; 7];
            compliance.apply(&x, &mut y);
            for i in 0..7 {
                let sum: f64 = (0..7).map(|j| f[(i, j)] * x[j]).sum();
                assert!((y[i] - sum).abs() < 1e-15);
            }
            let diagonal = (0..7).map(|i| f[(i, i)]).collect::<Vec<_>>();
            let known = !matches!(compliance, Compliance::Operator { .. });
            assert_eq!(compliance.diagonal(), known.then_some(diagonal));
        }
        for none in ways(&Mat::zeros(0, 0)) {
            assert_eq!((none.len(), none.is_empty()), (0, true));
        }
        let full = problem(applied(&f));
        assert_eq!((full.len(), full.is_empty()), (7, false));
        let none = DualProblem::new(
            applied(&Mat::zeros(0, 0)),
            Vec::new(),
            AdmissibleSet::default(),
            Balance::none(0),
        );
        assert!(none.is_ok_and(|none| none.is_empty()));
    }

    #[test]
    fn scales_are_the_largest_sizes_of_overlap_and_load() {
        let balance = Balance::new(modes(), vec![2.0, -3.0]);
        let expected = Scales {
            length: 0.75,
            force: 3.0,
            moment_arm: 0.0,
            energy: 0.0,
        };
        assert_eq!(Scales::of(&[0.5, -0.75], &balance), expected);
        assert_eq!(Scales::of(&[], &Balance::none(0)), Scales::default());
        assert_eq!(problem(applied(&soft())).scales, expected);
    }

    #[test]
    fn softness_is_the_diagonal_and_its_mean_over_tangents() {
        // the last compliance is zero: it takes the largest of the others
        let expected = [3.0, 3.0, 3.0, 2.0, 6.0, 6.0, 6.0];
        let [dense, sparse, applied] = ways(&soft());
        assert_eq!(problem(dense).softness, expected);
        assert_eq!(problem(sparse).softness, expected);
        // an applied F has no known diagonal: the scale of lengths over that of forces
        assert_eq!(problem(applied).softness, [0.75 / 3.0; 7]);
        let rigid = problem(Compliance::Dense(Mat::zeros(7, 7)));
        assert_eq!(rigid.softness, [1.0; 7]);
        let unloaded = |shift: f64, load: f64| {
            let balance = Balance::new(modes(), vec![load; 2]);
            let [_, _, compliance] = ways(&soft());
            let problem = DualProblem::new(compliance, vec![shift; 7], nodes(), balance);
            problem.unwrap().softness[0]
        };
        assert_eq!(unloaded(0.0, 4.0), 0.25);
        assert_eq!(unloaded(4.0, 0.0), 4.0);
    }

    #[test]
    fn components_give_way_at_least_as_much_as_they_are_told() {
        let least = vec![1.0, 2.0, 4.0, 9.0, 0.0, 0.0, 1.0];
        let mut dense = problem(Compliance::Dense(soft()));
        dense.soften(least.clone());
        assert_eq!(dense.softness, [3.0, 3.5, 3.5, 9.0, 6.0, 6.0, 1.0]);
        let mut applied = problem(applied(&soft()));
        applied.soften(least);
        assert_eq!(applied.softness, [1.0, 3.0, 3.0, 9.0, 9.0, 9.0, 1.0]);
    }

    #[test]
    fn compliance_is_assembled_up_to_a_limit_and_keeps_the_softness() {
        for limit in [6, 7] {
            for (k, compliance) in ways(&soft()).into_iter().enumerate() {
                let mut problem = problem(compliance);
                let applied = matches!(problem.compliance, Compliance::Operator { .. });
                let assembles = problem.assemble(limit);
                assert_eq!(assembles, limit == 7 && k > 0);
                if let Compliance::Dense(f) = &problem.compliance {
                    assert_eq!(*f, soft());
                }
                let dense = matches!(problem.compliance, Compliance::Dense(_));
                assert_eq!(dense, assembles || k == 0);
                if !applied {
                    let expected = [3.0, 3.0, 3.0, 2.0, 6.0, 6.0, 6.0];
                    assert_eq!(problem.softness, expected);
                }
            }
        }
    }

    #[test]
    fn products_with_an_operator_give_all_its_columns_and_its_symmetric_part() {
        // more than two batches of columns, the last not full
        let m = 2 * COLUMNS + 5;
        let skew = Mat::from_fn(m, m, |i, j| ((3 * i + j) % 7) as f64);
        let f = of_products(&Applied(skew.clone()));
        for j in 0..m {
            for i in 0..m {
                assert_eq!(f[(i, j)], 0.5 * (skew[(i, j)] + skew[(j, i)]));
            }
        }
    }

    #[test]
    fn gap_is_the_slope_of_the_functional() {
        for compliance in ways(&soft()) {
            let problem = problem(compliance);
            let multipliers = Multipliers {
                lambda: (0..7).map(|i| (i as f64).cos()).collect(),
                alpha: vec![0.3, -0.2],
            };
            // 1/2 λᵀFλ − dᵀλ − αᵀ(Gλ − e), whose differences are exact but for rounding
            let functional = |lambda: &[f64]| -> f64 {
                let (f, g) = (soft(), modes());
                let pair = |i: usize, j: usize| 0.5 * lambda[i] * f[(i, j)] * lambda[j];
                let energy: f64 = (0..7).flat_map(|i| (0..7).map(move |j| pair(i, j))).sum();
                let work: f64 = (0..7).map(|i| problem.shift[i] * lambda[i]).sum();
                let rigid = |k: usize| (0..7).map(|j| g[(k, j)] * lambda[j]).sum::<f64>();
                let alpha = &multipliers.alpha;
                energy - work - alpha[0] * (rigid(0) - 2.0) - alpha[1] * (rigid(1) + 3.0)
            };
            for (i, gap) in problem.gap(&multipliers).iter().enumerate() {
                let at = |step: f64| {
                    let mut lambda = multipliers.lambda.clone();
                    lambda[i] += step;
                    functional(&lambda)
                };
                let slope = 0.5 * (at(1.0) - at(-1.0));
                assert!((gap - slope).abs() < 1e-13, "{i}: {gap} {slope}");
            }
        }
    }

    #[test]
    fn projection_of_the_problem_takes_and_gives_amplitudes_of_its_own_modes() {
        let problem = problem(Compliance::Dense(soft()));
        let y: Vec<f64> = (0..7).map(|i| 3.0 * (i as f64).sin()).collect();
        let (mut tau, mut lambda) = (vec![0.0; 2], vec![0.0; 7]);
        let rest = problem.project(&y, &mut tau, &mut lambda);
        assert!(rest < 1e-14, "{rest:e}");
        let carried = problem.balance.modes().product(&lambda);
        for (carried, load) in carried.iter().zip(problem.balance.load()) {
            assert!((carried - load).abs() < 1e-13);
        }
        // λ = P_Λ(y − Gᵀτ)
        let shifted = |tau: &[f64]| -> Vec<f64> {
            let along = |j: usize| problem.balance.modes().motion(j, tau);
            (0..7).map(|j| y[j] - along(j)).collect()
        };
        let mut again = vec![0.0; 7];
        problem.admissible.project(&shifted(&tau), &mut again);
        for (a, b) in again.iter().zip(&lambda) {
            assert!((a - b).abs() < 1e-13);
        }
        // from the answer as a start nothing changes
        let start = tau.clone();
        problem.project(&y, &mut tau, &mut again);
        for (a, b) in start.iter().zip(&tau) {
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    fn parts_of_other_lengths_are_no_problem() {
        let told = |change: fn(&mut DualProblem)| {
            let mut problem = problem(Compliance::Dense(soft()));
            change(&mut problem);
            match problem.check() {
                Err(DualError::Length {
                    part,
                    found,
                    expected,
                }) => (part, found, expected),
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(told(|p| p.shift.truncate(6)), ("d", 6, 7));
        let short = told(|p| p.admissible = AdmissibleSet::new(vec![Block::Unilateral]));
        assert_eq!(short, ("the admissible set", 1, 7));
        assert_eq!(told(|p| p.softness.truncate(6)), ("the softness", 6, 7));
        let short = told(|p| p.balance = Balance::none(3));
        assert_eq!(short, ("a row of G", 3, 7));
        let short = told(|p| p.balance.set_load(vec![1.0]));
        assert_eq!(short, ("a column of G", 2, 1));
        let short = told(|p| p.balance = p.balance.clone().with_moments(vec![true]));
        assert_eq!(short, ("the list of moment rows", 1, 2));
        let part = || Part {
            rows: vec![1, 6],
            stiffness: soft().submatrix(0, 0, 3, 3).to_owned(),
            columns: vec![SparseVector::new(3, [(0, 1.0)]); 2],
        };
        assert!({
            let mut problem = problem(Compliance::Dense(soft()));
            problem.parts = vec![part()];
            problem.check().is_ok()
        });
        let told_of = |change: fn(&mut Part)| {
            let mut problem = problem(Compliance::Dense(soft()));
            problem.parts = vec![part()];
            change(&mut problem.parts[0]);
            match problem.check() {
                Err(DualError::Length { part, .. }) => part,
                other => panic!("{other:?}"),
            }
        };
        let wide = told_of(|p| p.stiffness = Mat::zeros(3, 2));
        assert_eq!(wide, "a stiffness of a part of F");
        assert_eq!(told_of(|p| p.rows[1] = 7), "the rows of a part of F");
        let few = told_of(|p| p.columns.truncate(1));
        assert_eq!(few, "the columns of a part of F");
        let short = told_of(|p| p.columns[0] = SparseVector::new(2, []));
        assert_eq!(short, "a column of a part of F");
        let beyond = told(|p| p.neighbours = vec![[0, 1], [2, 3]]);
        assert_eq!(beyond, ("the list of neighbours", 4, 3));
        let mut problem = problem(Compliance::Dense(soft()));
        problem.neighbours = vec![[0, 1], [1, 2]];
        assert_eq!(problem.check(), Ok(()));
    }

    #[test]
    fn entries_that_are_not_finite_are_named() {
        let told = |change: fn(&mut DualProblem)| {
            let mut problem = problem(Compliance::Dense(soft()));
            change(&mut problem);
            match problem.check() {
                Err(DualError::NotFinite { part, index, value }) => {
                    assert!(!value.is_finite());
                    (part, index)
                }
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(told(|p| p.shift[0] = f64::NAN), ("d", 0));
        assert_eq!(told(|p| p.shift[5] = f64::INFINITY), ("d", 5));
        assert_eq!(told(|p| p.balance.set_load(vec![0.0, f64::NAN])), ("e", 1));
        let in_f = told(|p| {
            let mut f = soft();
            f[(2, 1)] = f64::NAN;
            p.compliance = Compliance::Dense(f);
        });
        assert_eq!(in_f, ("F", 9));
        let in_f = told(|p| {
            let mut f = soft();
            f[(0, 0)] = f64::INFINITY;
            p.compliance = Compliance::Sparse(SparseMatrix::from_dense(&f));
        });
        assert_eq!(in_f, ("F", 0));
        let in_g = told(|p| {
            let mut g = modes();
            g[(0, 1)] = f64::INFINITY;
            p.balance = Balance::new(g, vec![0.0; 2]);
        });
        assert_eq!(in_g, ("G", 2));
    }

    #[test]
    fn friction_is_a_number_from_zero_on() {
        let told = |law: Friction| {
            let mut problem = problem(Compliance::Dense(soft()));
            let node = Friction::Coulomb { coefficient: 0.0 }.block(2);
            problem.admissible = AdmissibleSet::new(vec![node, law.block(2), Block::Unilateral]);
            match problem.check() {
                Err(DualError::Friction { block, value }) => {
                    assert_eq!(block, 1);
                    Some(value)
                }
                other => {
                    assert_eq!(other, Ok(()));
                    None
                }
            }
        };
        let cohesive = |cohesion, coefficient| Friction::Cohesive {
            cohesion,
            coefficient,
        };
        assert_eq!(told(Friction::Tresca { bound: 0.0 }), None);
        assert_eq!(told(Friction::Tresca { bound: -0.1 }), Some(-0.1));
        let infinite = Friction::Coulomb {
            coefficient: f64::INFINITY,
        };
        assert_eq!(told(infinite), Some(f64::INFINITY));
        assert_eq!(told(cohesive(-1.0, 0.5)), Some(-1.0));
        assert_eq!(told(cohesive(1.0, -0.5)), Some(-0.5));
        assert!(told(cohesive(f64::NAN, 0.5)).is_some_and(f64::is_nan));
        assert_eq!(told(cohesive(1.0, 0.5)), None);
    }
}
