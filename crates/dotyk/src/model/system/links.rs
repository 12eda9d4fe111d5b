//! Links: rows of B between bodies and small elastic parts of their own, with one stiffness k for each row and the elastic displacement
//! q. Beds that only press (`bed.rs`), members (`member.rs`) and gaskets (`gasket.rs`) are made of them. The displacements u_a at which a
//! link came are in its gaps.

use crate::contact::{GapShares, Interface, InterfaceNode, Role, Row};
use crate::geometry::Point;
use crate::model::nouns::ids::SideRef;
use crate::model::system::bodies::LoadedBody;
use crate::model::system::condition::{Condition, Elastic, Source};

/// The unit vector of a dof of a part.
pub(crate) fn axis<const D: usize>(i: usize) -> Point<D> {
    std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 })
}

/// Minus a dof of a node of a part, as a row.
pub(crate) fn less<const D: usize>(node: usize, dof: usize) -> Row<D> {
    vec![(node, axis::<D>(dof).map(|c| -c))]
}

/// A link between a body, or a side of it, and a part of its own.
pub(crate) fn linked<const D: usize>(
    (source, name): (Source, String),
    (nonmortar, part): (SideRef, usize),
    interface: Interface<D>,
    elastic: Elastic<D>,
) -> Condition<D> {
    let nothing = vec![0.0; interface.nonmortar.len()];
    Condition {
        opposite: Some(part),
        offset: nothing.clone(),
        came_with: nothing,
        elastic: Some(elastic),
        ..Condition::new(source, name, nonmortar, interface)
    }
}

/// The carrier of a row, without a place on a side.
pub(crate) fn carrier<const D: usize>(row: usize) -> InterfaceNode<D> {
    InterfaceNode {
        node: 0,
        opposite: Vec::new(),
        frame: std::array::from_fn(axis),
        weight: 1.0,
        extent: 0.0,
        share: 1.0,
        gap: 0.0,
        clearance: 0.0,
        shares: GapShares::default(),
        role: Role::Multiplier,
        rows: std::array::from_fn(|k| (k == 0).then_some(row)),
    }
}

/// Twice the elastic energy of a part less the work of its load, the energy, and the imbalance of the forces on it, under
/// forces `lambda` (m,) and displacements u.
pub(crate) fn part_balance<const D: usize>(
    part: &LoadedBody<D>,
    lambda: &[f64],
    u: &[f64],
) -> [f64; 3] {
    let mut inner = vec![0.0; u.len()];
    part.system.stiffness.mul(u, &mut inner);
    let energy = 0.5 * inner.iter().zip(u).map(|(k, u)| k * u).sum::<f64>();
    let work: f64 = part.system.load.iter().zip(u).map(|(f, u)| f * u).sum();
    let mut rest: Vec<f64> = part
        .system
        .load
        .iter()
        .zip(&inner)
        .map(|(f, k)| f - k)
        .collect();
    part.rows.add_forces(-1.0, lambda, &mut rest);
    let free = rest
        .iter()
        .zip(&part.system.held)
        .filter(|(_, held)| !**held);
    let left = free.map(|(f, _)| f * f).sum::<f64>().sqrt();
    [2.0 * energy - work, energy, left]
}
