//! One factorisation per body, the dofs of long contacts last.
//!
//! A floating body is held for the factorisation at r dofs away from its contacts, chosen by pivoting on R. Which ones
//! does not change the answer: a different choice changes F by Gᵀ(..) + (..)G only, which Gλ = e and α absorb.

use crate::fem::{self, BodySystem, FemError, show};
use crate::host::{share, team};
use crate::linalg::dense::dot;
use crate::linalg::{
    Cholesky, Divided, Glued, LinalgError, Mat, Reached, SparseVector, SymbolicCholesky, analyse,
    ground, some_of_node,
};
use crate::mesh::Count;
use crate::model::nouns::error::Error;
use crate::model::nouns::event::Work;
use crate::model::nouns::model::Model;
use crate::model::nouns::solution::Division;
use crate::model::system::bodies::{BodyRows, LoadedBody};
use crate::model::system::parts::part_name;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Elimination order of one body, with its symbolic analysis.
pub(crate) struct Ordered {
    analysis: Analysis,
    /// Contact dofs that are the last ones of the order; none where contacts are short, or F is applied.
    pub trailing: Vec<usize>,
    /// Dofs that hold the free rigid modes.
    pub grounded: Vec<usize>,
    /// Number of nodes with frames of their own.
    turned: usize,
}

/// How a body is factored.
enum Analysis {
    Whole(SymbolicCholesky),
    Pieces(Arc<Divided>),
}

/// K⁺ of a body.
pub(crate) enum Inverse {
    /// By one factor.
    Whole(Cholesky),
    /// By those of its pieces, which are glued in every solution.
    Pieces(Box<Glued>),
}

impl Inverse {
    /// u = K⁺f in place.
    pub fn solve(&self, f: &mut [f64]) {
        match self {
            Self::Whole(factor) => factor.solve(f),
            Self::Pieces(glued) => glued.solve(f),
        }
    }

    /// u = K⁺f in place, of pieces to three digits: for corrections.
    pub fn correct(&self, f: &mut [f64]) {
        match self {
            Self::Whole(factor) => factor.solve(f),
            Self::Pieces(glued) => glued.correct(f),
        }
    }

    /// U = K⁺F in place.
    pub fn solve_many(&self, f: &mut Mat<f64>) {
        match self {
            Self::Whole(factor) => factor.solve_many(f),
            Self::Pieces(glued) => {
                (0..f.ncols()).for_each(|j| glued.solve_afresh(f.col_as_slice_mut(j)));
            }
        }
    }

    /// The pieces, of a body that is divided.
    pub fn glued(&self) -> Option<&Glued> {
        match self {
            Self::Whole(_) => None,
            Self::Pieces(glued) => Some(glued),
        }
    }

    /// Solutions with every piece so far, of a body that is divided.
    pub fn iterations(&self) -> usize {
        self.glued().map_or(0, Glued::iterations)
    }

    /// BK⁺Bᵀ of rows over all dofs, of a body that is whole.
    pub fn compliance(&self, rows: &[SparseVector]) -> Mat<f64> {
        match self {
            Self::Whole(factor) => factor.compliance(rows),
            Self::Pieces(_) => Mat::zeros(0, 0),
        }
    }

    /// The factor of its boundary stiffness, of a body with contact dofs ordered last.
    pub fn trailing_factor(&self) -> Mat<f64> {
        match self {
            Self::Whole(factor) => factor.trailing_factor(),
            Self::Pieces(_) => Mat::zeros(0, 0),
        }
    }
}

/// The factor of one body, and its displacement without contact.
pub(crate) struct FactoredBody {
    /// Factor of K on the free dofs, grounded ones left out.
    pub factor: Arc<Inverse>,
    /// u_D + K⁺(f − K u_D), (D·n,), less the rigid motion that u_D contains; of a body with a half, at what its rows read alone.
    pub base: Vec<f64>,
    /// The first half of a solution, of a body with one factor and without prescribed displacements.
    half: Option<Half>,
}

/// L⁻¹Pf, and the part of the factor that the rows of a body reach.
struct Half {
    y: Vec<f64>,
    reached: Reached,
}

/// Where the forces of contacts leave less than this of the energy of the load, both are solved for together: alone each may bend a
/// slender body far more than both, and that much of the digits is lost.
const CANCELLED: f64 = 1e-4;

impl Ordered {
    /// Operations of the factorisation.
    pub fn operations(&self) -> f64 {
        match &self.analysis {
            Analysis::Whole(analysis) => analysis.operations(),
            Analysis::Pieces(divided) => divided.operations(),
        }
    }

    /// Entries of the factor, of 8 bytes each.
    pub fn stored(&self) -> usize {
        match &self.analysis {
            Analysis::Whole(analysis) => analysis.stored(),
            Analysis::Pieces(divided) => divided.stored(),
        }
    }

    /// Numbers that are kept beside the factor while it is formed.
    pub fn beside(&self) -> usize {
        match &self.analysis {
            Analysis::Whole(analysis) => analysis.beside(),
            Analysis::Pieces(_) => 0,
        }
    }

    /// The pieces, of a body that is divided.
    pub fn divided(&self) -> Option<&Divided> {
        match &self.analysis {
            Analysis::Whole(_) => None,
            Analysis::Pieces(divided) => Some(divided),
        }
    }
}

impl FactoredBody {
    /// Solves for the displacement without contact: by half where that is enough.
    pub fn new<const D: usize>(body: &LoadedBody<D>, factor: Arc<Inverse>) -> Self {
        let lift = &body.system.lift;
        if let (Inverse::Whole(cholesky), true) = (&*factor, lift.iter().all(|&u| u == 0.0)) {
            let y = cholesky.forward(&body.reduced_load);
            let reached = cholesky.reached(body.rows.dofs());
            let base = cholesky.backward_reached(&y, &reached);
            let half = Some(Half { y, reached });
            return Self { factor, base, half };
        }
        let mut base = body.reduced_load.clone();
        factor.solve(&mut base);
        base.iter_mut().zip(lift).for_each(|(u, lift)| *u += lift);
        Self {
            factor,
            base,
            half: None,
        }
    }

    /// K⁺(f − Bᵀλ) from the half that the load left; `None` where there is none, or where that would cost digits.
    pub fn completed<const D: usize>(
        &self,
        body: &LoadedBody<D>,
        lambda: &[f64],
    ) -> Option<Vec<f64>> {
        let (Some(half), Inverse::Whole(cholesky)) = (&self.half, &*self.factor) else {
            return None;
        };
        let mut pushed = vec![0.0; body.reduced_load.len()];
        body.rows.add_forces(-1.0, lambda, &mut pushed);
        let mut y = half.y.clone();
        cholesky.forward_reached(&pushed, &half.reached, &mut y);
        let [before, now] = [&half.y, &y].map(|y| dot(y, y));
        (now >= CANCELLED * before).then(|| cholesky.backward(y))
    }

    /// Elastic energy of the displacement without contact.
    pub fn energy<const D: usize>(&self, body: &LoadedBody<D>) -> f64 {
        let [a, b] = match &self.half {
            Some(half) => [&half.y, &half.y],
            None => [&self.base, &body.reduced_load],
        };
        0.5 * dot(a, b)
    }
}

/// Which dofs of a body are ordered last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Last {
    /// None: F is applied.
    Nothing,
    /// Those of contacts that are not [`SHORT`]: F is assembled, of other bodies from what rows reach.
    LongContacts,
    /// Those of contacts: F is assembled, and the stiffness of boundaries is needed.
    Contacts,
}

/// Contacts of bodies of the plane with at least so many times as many dofs are short. Ground around a tunnel with 305 and 609 nodes in
/// contact: factor and F together take 195 and 569 ms with their dofs last and 158 and 454 ms without, with friction 214 and 670 ms
/// against 213 and 610 ms. In space many rows reach the large fronts near the root: blocks of 18 layers take 503 ms and 563 ms, with
/// friction 1241 ms and 1598 ms; there none are short.
const SHORT: usize = 10;

/// The dofs of a body that contacts touch.
struct Touched {
    /// By a row.
    dofs: Vec<bool>,
    /// Nodes with such a dof, or that another stage touches.
    nodes: Vec<bool>,
}

impl Touched {
    /// By rows; `lasting` are nodes that other stages touch.
    fn by<const D: usize>(system: &BodySystem<D>, rows: &BodyRows, lasting: &[usize]) -> Self {
        let mut dofs = vec![false; system.load.len()];
        for local in 0..rows.index.len() {
            for (dof, _) in rows.matrix.row(local) {
                dofs[dof] = true;
            }
        }
        let mut nodes = some_of_node::<D>(&dofs);
        // in space they would cost more than they save
        let lasting = lasting.iter().filter(|_| D == 2);
        lasting.for_each(|&node| nodes[node] = true);
        Self { dofs, nodes }
    }

    /// The kept dofs that are ordered last.
    fn trailing<const D: usize>(&self, keep: &[bool], last: Last) -> Vec<usize> {
        // in the plane, where contacts are short, nodes stay whole
        let is_last = |dof: usize| self.dofs[dof] || D == 2 && self.nodes[dof / D];
        let dofs = (0..keep.len()).filter(|&dof| keep[dof] && is_last(dof));
        let dofs: Vec<usize> = dofs.collect();
        match last {
            Last::Contacts => dofs,
            Last::LongContacts if D == 3 || keep.len() < SHORT * dofs.len() => dofs,
            _ => Vec::new(),
        }
    }
}

/// Free dofs that are not grounded.
fn kept_dofs<const D: usize>(system: &BodySystem<D>, grounded: &[usize]) -> Vec<bool> {
    let mut keep: Vec<bool> = system.held.iter().map(|held| !held).collect();
    grounded.iter().for_each(|&dof| keep[dof] = false);
    keep
}

impl Ordered {
    /// Whether the order fits the same body with other rows.
    pub fn serves<const D: usize>(
        &self,
        system: &BodySystem<D>,
        rows: &BodyRows,
        lasting: &[usize],
        (last, divided): (Last, bool),
    ) -> bool {
        let keep = kept_dofs(system, &self.grounded);
        let touched = Touched::by(system, rows, lasting);
        let apart = self.grounded.iter().all(|&dof| !touched.dofs[dof]);
        let fits = match self.divided() {
            Some(own) => divided && own.is_touched_at(&touched.dofs),
            None => !divided && touched.trailing::<D>(&keep, last) == self.trailing,
        };
        apart && fits && self.turned == system.frames.len()
    }
}

/// Orders a body: free dofs, some of those of the contacts last, grounded dofs left out; `lasting` are nodes
/// that contacts of other stages touch.
pub(crate) fn order<const D: usize>(
    model: &Model<D>,
    body: usize,
    system: &BodySystem<D>,
    (rows, lasting): (&BodyRows, &[usize]),
    (last, pieces): (Last, Option<Count>),
) -> Result<Ordered, Error<D>> {
    let touched = Touched::by(system, rows, lasting);
    let keep = kept_dofs(system, &[]);
    let away = |dof: usize| keep[dof] && !touched.nodes[dof / D];
    let away: Vec<bool> = (0..keep.len()).map(away).collect();
    let grounded = ground(&system.modes, &keep, &away);
    let keep = kept_dofs(system, &grounded);
    let last = if pieces.is_some() {
        Last::Nothing
    } else {
        last
    };
    let trailing = touched.trailing::<D>(&keep, last);
    let fail = |source| singular(model, body, source);
    let analysis = match model.bodies.get(body).zip(pieces) {
        Some((own, count)) => {
            let of_cell = own.mesh.pieces(count);
            let all = of_cell.iter().max().map_or(0, |last| *last as usize + 1);
            let team = team();
            let parts = share(&*team, all);
            let parts = fem::pieces((own, system), model.analysis, &of_cell, parts);
            let parts = parts.map_err(|source| Error::in_body(own, source))?;
            let divided = Divided::new::<D>(keep, &touched.dofs, parts, team).map_err(fail)?;
            Analysis::Pieces(Arc::new(divided))
        }
        None => {
            let analysis = analyse::<D>(&system.graph, &system.stiffness, &keep, &trailing);
            Analysis::Whole(analysis.map_err(fail)?)
        }
    };
    Ok(Ordered {
        analysis,
        trailing,
        grounded,
        turned: system.frames.len(),
    })
}

/// Factors a body; `work` counts the operations.
pub(crate) fn factor<const D: usize>(
    model: &Model<D>,
    body: usize,
    system: &BodySystem<D>,
    ordered: &Ordered,
    work: &Work,
) -> Result<Inverse, Error<D>> {
    let factor = match &ordered.analysis {
        Analysis::Whole(analysis) => analysis.factor(&system.stiffness).map(Inverse::Whole),
        Analysis::Pieces(divided) => divided.glue().map(|glued| Inverse::Pieces(Box::new(glued))),
    };
    let factor = factor.map_err(|source| singular(model, body, source))?;
    let operations = ordered.operations() as u64;
    work.done.fetch_add(operations, Ordering::Relaxed);
    Ok(factor)
}

/// Names the node of a dof where the linear algebra failed.
fn singular<const D: usize>(model: &Model<D>, body: usize, source: LinalgError) -> Error<D> {
    if let LinalgError::TooLarge { unknowns } = source {
        return Error::TooLarge {
            body: part_name(model, body),
            unknowns,
        };
    }
    let dof = match &source {
        LinalgError::NotPositiveDefinite { dof } | LinalgError::NearlySingular { dof, .. } => *dof,
        LinalgError::NotFinite { row } => *row,
        _ => 0,
    };
    let node = dof / D;
    let Some(body) = model.bodies.get(body) else {
        return Error::Part {
            part: part_name(model, body),
            source,
        };
    };
    let point = show(body.mesh.points()[node]);
    Error::Body {
        body: body.name.clone(),
        source: FemError::Singular {
            node,
            point,
            source,
        },
    }
}

/// How bodies with these orders are divided; `factored` are all parts, of which they are the first.
pub(crate) fn division(ordered: &[Arc<Ordered>], factored: &[FactoredBody]) -> Division {
    let divided = || ordered.iter().filter_map(|ordered| ordered.divided());
    let inverses = factored.iter().map(|factored| &factored.factor);
    Division {
        subdomains: ordered.len() - divided().count()
            + divided().map(|own| own.pieces()).sum::<usize>(),
        coarse: divided().map(|own| own.coarse()).sum(),
        iterations: inverses.map(|inverse| inverse.iterations()).sum(),
    }
}
