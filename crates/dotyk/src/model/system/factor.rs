//! One factorisation per body, contact dofs last.
//!
//! A floating body is held for the factorisation at r dofs away from its contacts, chosen by pivoting on R. Which ones
//! does not change the answer: a different choice changes F by Gᵀ(..) + (..)G only, which Gλ = e and α absorb.

use crate::fem::{BodySystem, FemError, show};
use crate::linalg::{
    Cholesky, LinalgError, SymbolicCholesky, expand_to_dofs, fill_reducing_order,
    fill_reducing_order_in_space,
};
use crate::model::nouns::error::Error;
use crate::model::nouns::event::Work;
use crate::model::nouns::model::Model;
use crate::model::system::bodies::{BodyRows, LoadedBody};
use crate::model::system::parts::part_name;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// A dof away from the contacts is grounded only if a mode, of largest displacement 1, moves it by more than this: else the pivot
/// would cost three digits or more.
const FAR_ENOUGH: f64 = 1e-3;

/// Elimination order of one body, with its symbolic analysis.
pub(crate) struct Ordered {
    analysis: SymbolicCholesky,
    /// Contact dofs, the last ones of the order.
    pub trailing: Vec<usize>,
    /// Dofs that hold the free rigid modes.
    pub grounded: Vec<usize>,
}

/// The factor of one body, and its displacement without contact.
pub(crate) struct FactoredBody {
    /// Factor of K on the free dofs, grounded ones left out.
    pub factor: Arc<Cholesky>,
    /// u_D + K⁺(f − K u_D), (D·n,), less the rigid motion that u_D contains.
    pub base: Vec<f64>,
}

impl Ordered {
    /// Operations of the factorisation.
    pub fn operations(&self) -> f64 {
        self.analysis.operations()
    }

    /// Entries of the factor, of 8 bytes each.
    pub fn stored(&self) -> usize {
        self.analysis.stored()
    }
}

impl FactoredBody {
    /// Solves for the displacement without contact.
    pub fn new<const D: usize>(body: &LoadedBody<D>, factor: Arc<Cholesky>) -> Self {
        let mut base = body.reduced_load.clone();
        factor.solve(&mut base);
        base.iter_mut()
            .zip(&body.system.lift)
            .for_each(|(u, lift)| *u += lift);
        Self { factor, base }
    }

    /// Elastic energy of the displacement without contact.
    pub fn energy<const D: usize>(&self, body: &LoadedBody<D>) -> f64 {
        let works = self.base.iter().zip(&body.reduced_load);
        works.map(|(u, f)| 0.5 * u * f).sum()
    }
}

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
    fn trailing<const D: usize>(&self, keep: &[bool], dense: bool) -> Vec<usize> {
        // in the plane, where contacts are short, nodes stay whole
        let is_last = |dof: usize| self.dofs[dof] || D == 2 && self.nodes[dof / D];
        match dense {
            true => (0..keep.len())
                .filter(|&dof| keep[dof] && is_last(dof))
                .collect(),
            false => Vec::new(),
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
        dense: bool,
    ) -> bool {
        let keep = kept_dofs(system, &self.grounded);
        let touched = Touched::by(system, rows, lasting);
        let apart = self.grounded.iter().all(|&dof| !touched.dofs[dof]);
        apart && touched.trailing::<D>(&keep, dense) == self.trailing
    }
}

/// Orders a body: free dofs, those of the contacts last (when F is assembled), grounded dofs left out; `lasting` are nodes
/// that contacts of other stages touch.
pub(crate) fn order<const D: usize>(
    model: &Model<D>,
    body: usize,
    system: &BodySystem<D>,
    (rows, lasting): (&BodyRows, &[usize]),
    dense: bool,
) -> Result<Ordered, Error<D>> {
    let touched = Touched::by(system, rows, lasting);
    let keep = kept_dofs(system, &[]);
    let grounded = grounded_dofs(system, &keep, &touched.nodes);
    let keep = kept_dofs(system, &grounded);
    let trailing = touched.trailing::<D>(&keep, dense);
    let analysis =
        analyse(system, &keep, &trailing).map_err(|source| singular(model, body, source))?;
    Ok(Ordered {
        analysis,
        trailing,
        grounded,
    })
}

/// Orders and analyses K on the dofs with `keep`, those of `trailing` at the end.
///
/// If only some dofs of a node are trailing, its other dofs are ordered among the inner nodes: their graph, and with it their
/// elimination tree, is the same.
///
/// Errors: [`LinalgError::TooLarge`].
pub(crate) fn analyse<const D: usize>(
    system: &BodySystem<D>,
    keep: &[bool],
    trailing: &[usize],
) -> Result<SymbolicCholesky, LinalgError> {
    let mut inner = keep.to_vec();
    trailing.iter().for_each(|&dof| inner[dof] = false);
    let [nodes, inner_nodes] = [keep, &inner].map(some_of_node::<D>);
    let last: Vec<usize> = (0..nodes.len())
        .filter(|&node| nodes[node] && !inner_nodes[node])
        .collect();
    let order = match D {
        3 => fill_reducing_order_in_space(&system.graph, &nodes, &last),
        _ => fill_reducing_order(&system.graph, &nodes, &last),
    };
    let mut dofs = expand_to_dofs(&order, D, &inner);
    dofs.extend_from_slice(trailing);
    let analysis = SymbolicCholesky::new(&system.stiffness, &dofs, trailing.len())?;
    Ok(if D == 3 { analysis.shared() } else { analysis })
}

/// Whether some dof of each node is marked.
fn some_of_node<const D: usize>(marked: &[bool]) -> Vec<bool> {
    let nodes = marked.chunks_exact(D);
    nodes.map(|dofs| dofs.contains(&true)).collect()
}

/// Dofs that hold the free rigid modes for the factorisation: complete pivoting on R, away from the contacts if possible.
fn grounded_dofs<const D: usize>(
    system: &BodySystem<D>,
    keep: &[bool],
    contact_node: &[bool],
) -> Vec<usize> {
    let mut modes = system.modes.clone();
    let mut grounded: Vec<usize> = Vec::new();
    let mut open: Vec<usize> = (0..modes.len()).collect();
    let candidates = |away: bool| {
        (0..keep.len()).filter(move |&dof| keep[dof] && (!away || !contact_node[dof / D]))
    };
    while !open.is_empty() {
        let best = |away: bool| {
            let mut best = (0.0, 0, 0);
            for (position, &mode) in open.iter().enumerate() {
                for dof in candidates(away) {
                    let size = modes[mode][dof].abs();
                    if size > best.0 {
                        best = (size, position, dof);
                    }
                }
            }
            best
        };
        let mut pivot = best(true);
        if pivot.0 < FAR_ENOUGH {
            pivot = best(false);
        }
        let (size, position, dof) = pivot;
        if size == 0.0 {
            break;
        }
        let mode = open.remove(position);
        grounded.push(dof);
        let row = modes[mode].clone();
        for &other in &open {
            let factor = modes[other][dof] / row[dof];
            modes[other]
                .iter_mut()
                .zip(&row)
                .for_each(|(value, r)| *value -= factor * r);
        }
    }
    grounded
}

/// Factors a body; `work` counts the operations.
pub(crate) fn factor<const D: usize>(
    model: &Model<D>,
    body: usize,
    system: &BodySystem<D>,
    ordered: &Ordered,
    work: &Work,
) -> Result<Cholesky, Error<D>> {
    let factor = ordered.analysis.factor(&system.stiffness);
    let factor = factor.map_err(|source| singular(model, body, source))?;
    let operations = ordered.analysis.operations() as u64;
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
