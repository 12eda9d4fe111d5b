//! The dual problem of a model, with the contact force of each unknown and the rows of B, and the way back: from forces of any
//! source to displacements, their certificate and a solution. Factored once for any number of these.

use crate::dual::{Certificate, Compliance, Multipliers};
use crate::geometry::Point;
use crate::linalg::SparseMatrix;
use crate::model::march::attempt::{Attempt, Start};
use crate::model::march::equilibrate::certified;
use crate::model::march::finish::{finish, tell};
use crate::model::march::judge::{Judged, judge};
use crate::model::march::objection::objection;
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::event::Event;
use crate::model::nouns::model::Method;
use crate::model::nouns::presence::Stage;
use crate::model::nouns::solution::Solution;
use crate::model::read::view::View;
use crate::model::system::compliance::ASSEMBLED;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Source, row_ranges};
use crate::model::system::parts::{Owner, part_name};
use crate::solve::Outcome;
use std::ops::Range;

/// A model condensed onto its contact forces λ (m,) and rigid amplitudes α (r,), at one time; made by `Model::dual`.
///
/// ```text
///   min 1/2 λᵀFλ − dᵀλ over λ ∈ Λ, Gλ = e,      gap = Fλ − d − Gᵀα = g₀ − Bu
/// ```
///
/// The unknowns are ordered contact by contact as in the model, within one contact node by node as in
/// [`ContactSolution::nodes`](crate::model::ContactSolution::nodes); a node with friction or a tie has its normal force first, then the
/// tangential ones. The couples follow in the order of the bodies. Nodes without an opposite side, or with a prescribed displacement,
/// have no unknown; [`Unknown`] gives the place of each.
pub struct Dual<const D: usize> {
    pub(crate) stage: Stage<'static, D>,
    pub(crate) condensed: Condensed<D>,
    pub(crate) view: View<D>,
}

/// Description of a contact force λᵢ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknown<const D: usize> {
    /// Index of its contact in the model; those of couples follow in the order of the bodies, then beds, then members.
    pub contact: usize,
    /// Index of its node among those of the contact in a solution.
    pub place: usize,
    /// Index of its node in the mesh of the nonmortar body. For an average couple, which moves the whole side, any of its nodes; for an
    /// element of a member, whose ends need not be nodes, the node that moves it most, or zero where that body does not move it.
    pub node: usize,
    /// 0: along the contact normal, else along a tangent.
    pub component: usize,
    /// Index of its block in the admissible set.
    pub block: usize,
    /// Undeformed position of the node; of an element of a member its middle.
    pub point: Point<D>,
    /// Unit vector of its row of B. λ > 0 pushes the nonmortar body against it, the mortar body along it; of an element of a
    /// member from its beginning to its end, λ > 0 is tension, of one that bears compression alone the other way round.
    pub direction: Point<D>,
    /// ∫ψ, an area (times thickness or 2πr): pressure, or shear traction, is λ over it.
    pub weight: f64,
}

impl<const D: usize> Dual<D> {
    /// Description of each contact force, m in number.
    pub(crate) fn list_unknowns(&self) -> Vec<Unknown<D>> {
        let mut list = Vec::with_capacity(self.condensed.gaps.len());
        let mut block = 0;
        for (contact, condition) in self.condensed.conditions.iter().enumerate() {
            let points = self.stage.model.bodies[condition.nonmortar.body.0]
                .mesh
                .points();
            for (place, node) in condition.interface.nodes.iter().enumerate() {
                let components = (0..D).filter(|&component| node.rows[component].is_some());
                let before = list.len();
                list.extend(components.map(|component| Unknown {
                    contact,
                    place,
                    node: node.node,
                    component,
                    block,
                    point: condition.place(place, points),
                    direction: node.frame[component],
                    weight: node.weight,
                }));
                block += usize::from(list.len() > before);
            }
        }
        list
    }

    /// The direction of a contact force in a word: the component of a contact, else the kind of connection.
    pub(crate) fn component_name(&self, unknown: &Unknown<D>) -> &'static str {
        let components: &[&str] = match D {
            2 => &["normal", "tangent"],
            _ => &["normal", "tangent_1", "tangent_2"],
        };
        match self.condensed.conditions[unknown.contact].source {
            Source::Contact(_) => components[unknown.component],
            Source::Of(Owner::Bed(..)) => "spring",
            Source::Of(Owner::Member(of)) => self.stage.model.members[of].kind.words().apart,
            Source::Of(other) => other.kind(&self.stage.model),
        }
    }

    /// B (m, n).
    pub(crate) fn assemble_rows(&self) -> SparseMatrix {
        let columns = self.list_columns();
        let mut entries = Vec::new();
        for (range, condition) in row_ranges(&self.condensed.conditions) {
            for (part, rows) in condition.ends() {
                let start = columns[part].1.start;
                for (i, row) in range.clone().zip(rows) {
                    let parts = row.iter().flat_map(|(node, coefficients)| {
                        let first = start + D * node;
                        (first..).zip(*coefficients)
                    });
                    entries.extend(parts.map(|(j, value)| (i, j, value)));
                }
            }
        }
        entries.retain(|entry| entry.2 != 0.0);
        let dofs = columns.last().map_or(0, |(_, last)| last.end);
        SparseMatrix::from_triplets(self.condensed.gaps.len(), dofs, &entries)
    }

    /// Columns of B: those of each body, then of each obstacle that a force moves and of the point of each couple.
    pub(crate) fn list_columns(&self) -> Vec<(String, Range<usize>)> {
        let mut last = 0;
        let parts = self.condensed.bodies.iter().enumerate();
        let columns = parts.map(|(part, body)| {
            let first = last;
            last += body.system.load.len();
            (part_name(&self.stage.model, part), first..last)
        });
        columns.collect()
    }

    /// Assembles F with all its entries if that is not yet done and F is not too large; `true` where F is assembled.
    pub(crate) fn assemble_compliance(&mut self) -> bool {
        let problem = &mut self.condensed.problem;
        match problem.compliance {
            Compliance::Operator { .. } => problem.assemble(ASSEMBLED),
            Compliance::Dense(_) | Compliance::Sparse(_) => true,
        }
    }

    /// λ and α by one of the methods, as in a load step of the model.
    pub(crate) fn solved(
        &mut self,
        method: Method,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Multipliers, Error<D>> {
        let solver = &mut self.stage.model.to_mut().solver;
        let own = std::mem::replace(&mut solver.method, method);
        // the certificate may correct d for the rounding of the displacements; this problem keeps its own
        let shift = self.condensed.problem.shift.clone();
        let start = Start::default();
        let solved = certified(&self.stage.model, &mut self.condensed, start, observe);
        self.condensed.problem.shift = shift;
        self.stage.model.to_mut().solver.method = own;
        let (attempt, judged) = solved?;
        let multipliers = attempt.outcome.multipliers.clone();
        match objection(&self.stage.model, &self.condensed, &attempt, &judged) {
            None => Ok(multipliers),
            Some(reason) => {
                let here = (&self.condensed, &self.view);
                let mut solution = finish(&self.stage, here, attempt, judged, false)?;
                tell(&self.stage.model, here, &mut solution)?;
                Err(no_answer(reason, solution))
            }
        }
    }

    /// The certificate of given forces.
    pub(crate) fn certified(&self, multipliers: &Multipliers) -> Result<Certificate, Error<D>> {
        self.judged(multipliers)
            .map(|(_, judged)| judged.certificate)
    }

    /// The solution with given forces.
    pub(crate) fn recovered(&self, multipliers: &Multipliers) -> Result<Solution<D>, Error<D>> {
        let (attempt, judged) = self.judged(multipliers)?;
        let objection = objection(&self.stage.model, &self.condensed, &attempt, &judged);
        let holds = objection.is_none();
        let here = (&self.condensed, &self.view);
        let mut solution = finish(&self.stage, here, attempt, judged, holds)?;
        tell(&self.stage.model, here, &mut solution)?;
        match objection {
            None => Ok(solution),
            Some(reason) => Err(no_answer(reason, solution)),
        }
    }

    fn judged(&self, multipliers: &Multipliers) -> Result<(Attempt<D>, Judged<D>), Error<D>> {
        let shape = self.condensed.problem.check_multipliers(multipliers);
        shape.map_err(|error| Error::Solver(error.into()))?;
        let attempt = Attempt {
            method: "given".to_string(),
            outcome: Outcome::new(multipliers.clone(), 0),
            history: Vec::new(),
            failure: None,
        };
        let mut judged = judge(&self.stage.model, &self.condensed, &attempt.outcome, None)?;
        let here = (&self.condensed, &self.view);
        judged.look_for_intrusion(&self.stage, here, &multipliers.lambda);
        Ok((attempt, judged))
    }
}

fn no_answer<const D: usize>(reason: Objection<D>, solution: Solution<D>) -> Error<D> {
    Error::NotConverged {
        reason: Box::new(reason),
        solution: Box::new(solution),
        earlier: Vec::new(),
    }
}
