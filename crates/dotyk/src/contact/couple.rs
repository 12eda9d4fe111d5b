//! Couples: a side and its reference point as an interface with free multipliers, without a gap.
//!
//! The point is a part of two nodes after the bodies. Node 0 has its displacement u_p, node 1 its rotation θ as the
//! length φ = Lθ at the end of an arm L, so that forces there are M/L. With r = x − x_p and the rigid motion
//! u_p + Σₖ θₖ eₖ × r, a rigid couple has the rows
//!
//! ```text
//!   uᵢ − u_p − Σₖ (φₖ/L) eₖ × rᵢ = 0                                         at every node i of the side
//! ```
//!
//! An average one takes the rigid motion that is nearest to that of the side, min over (u_p, θ) of ∫|u − u_p − θ × r|² dS. With
//! W = ∫dS, the centroid c = ∫r dS / W, s = r − c and the moments Jₖₗ = ∫(eₖ × s)·(eₗ × s) dS its conditions are
//!
//! ```text
//!   ∫u dS / W − u_p − θ × c = 0,         Σₗ J⁻¹ₖₗ ∫(eₗ × s)·u dS − θₖ = 0
//! ```
//!
//! The second is taken times ρ = √(tr J/W), a length as the first. Their multipliers, a force F and M/ρ, push the side by the
//! traction F/W + Σₖₗ Mₖ J⁻¹ₖₗ eₗ × s: linear over the side, with the resultant F and about the centroid the moment M, and the
//! least one in ∫|t|² dS that has these. A side that does not lie on a line (in space) or in a point has J > 0; sides have area.
//! With u and r interpolated by the same functions all integrals are exact where facets are straight.
//!
//! With axial symmetry dS carries 2πr and the only rigid motion is the one along the axis: an average couple has one row, in a
//! rigid one the side keeps its radii.

use crate::contact::{Coupling, End, GapShares, Interface, InterfaceNode, Role, Row};
use crate::fem::{Analysis, Couple, CoupleKind, FemError, RigidBasis, side_nodes, side_points};
use crate::geometry::{Point, add_scaled, dot, invert, sub};
use std::collections::BTreeMap;

/// The interface of a couple of the body at this end. Its nodes carry the rows in order; those of an average couple are mere
/// carriers without a place on the side.
///
/// Errors: an unknown or empty side, one without area, a point that is not finite.
pub fn pair_couple<const D: usize>(
    couple: &Couple<D>,
    end: End<'_, D>,
    analysis: Analysis,
) -> Result<Interface<D>, FemError> {
    let arm = couple.arm(end.body)?;
    let conditions = match couple.kind {
        CoupleKind::Rigid => rigid(couple, end, analysis, arm)?,
        CoupleKind::Average => average(couple, end, analysis, arm)?,
    };
    let mut interface = Interface::empty(Coupling::Tied);
    for (node, rows) in conditions {
        let first = interface.nonmortar.len();
        let count = rows.len();
        interface.nodes.push(InterfaceNode {
            node,
            opposite: Vec::new(),
            frame: std::array::from_fn(axis),
            weight: 1.0,
            extent: 0.0,
            share: 1.0,
            gap: 0.0,
            clearance: 0.0,
            shares: GapShares::default(),
            role: Role::Multiplier,
            rows: std::array::from_fn(|k| (k < count).then_some(first + k)),
        });
        for [own, point] in rows {
            interface.nonmortar.push(own);
            interface.mortar.push(point);
        }
    }
    Ok(interface)
}

/// Rows on the body and on the point, at most D, and the node that carries them.
type Conditions<const D: usize> = Vec<(usize, Vec<[Row<D>; 2]>)>;

fn axis<const D: usize>(i: usize) -> Point<D> {
    std::array::from_fn(|j| f64::from(u8::from(i == j)))
}

/// eₖ × r of the k-th rotation of an analysis.
fn turned<const D: usize>(k: usize, r: Point<D>) -> Point<D> {
    RigidBasis::Full.displacement(k, r)
}

/// Row on the point of minus its motion along an axis at r from it.
fn at_point<const D: usize>(i: usize, r: Point<D>, turns: usize, arm: f64) -> Row<D> {
    let turn = |k: usize| match k < turns {
        true => -turned(k, r)[i] / arm,
        false => 0.0,
    };
    let moved = (0, axis::<D>(i).map(|c| -c));
    let spun = (turns > 0).then(|| (1, std::array::from_fn(turn)));
    std::iter::once(moved).chain(spun).collect()
}

fn rigid<const D: usize>(
    couple: &Couple<D>,
    end: End<'_, D>,
    analysis: Analysis,
    arm: f64,
) -> Result<Conditions<D>, FemError> {
    let turns = Couple::<D>::turns(analysis).len();
    let axial = analysis == Analysis::Axisymmetric;
    let rows = |node: usize| {
        let r = sub(end.body.mesh.points()[node], couple.point);
        // components held by the axis of symmetry need no condition
        let held = end.constraints.at(node);
        let by_symmetry = held.iter().any(|h| h.supports.is_empty());
        let components = (0..D).filter(|&i| !(by_symmetry && i == 0));
        let row = |i: usize| {
            if axial && i == 0 {
                return [vec![(node, axis(i))], Vec::new()];
            }
            [vec![(node, axis(i))], at_point(i, r, turns, arm)]
        };
        (node, components.map(row).collect())
    };
    let nodes = side_nodes(&end.body.mesh, &couple.side)?;
    Ok(nodes.into_iter().map(rows).collect())
}

/// Terms of the integrals over a side: for every node ∫N, and ∫N r.
#[derive(Clone, Copy)]
struct Share<const D: usize> {
    weight: f64,
    moment: Point<D>,
}

fn average<const D: usize>(
    couple: &Couple<D>,
    end: End<'_, D>,
    analysis: Analysis,
    arm: f64,
) -> Result<Conditions<D>, FemError> {
    let mesh = &end.body.mesh;
    let turns = Couple::<D>::turns(analysis).len();
    let places = || side_points(end.body, &couple.side, analysis);
    let (mut area, mut centre) = (0.0, [0.0; D]);
    for place in places()? {
        area += place.area;
        centre = add_scaled(centre, place.area, sub(place.point, couple.point));
    }
    let centre = centre.map(|c| c / area);
    let mut shares: BTreeMap<usize, Share<D>> = BTreeMap::new();
    let mut inertia = [[0.0; D]; D];
    for place in places()? {
        let s = sub(sub(place.point, couple.point), centre);
        for (node, n) in mesh.facet_nodes(place.facet).zip(place.shape) {
            let share = shares.entry(node as usize).or_insert(Share {
                weight: 0.0,
                moment: [0.0; D],
            });
            share.weight += n * place.area;
            share.moment = add_scaled(share.moment, n * place.area, s);
        }
        for (k, row) in inertia.iter_mut().enumerate().take(turns) {
            for (l, entry) in row.iter_mut().enumerate().take(turns) {
                *entry += place.area * dot(turned(k, s), turned(l, s));
            }
        }
    }
    if area <= 0.0 {
        return Err(FemError::NoArea {
            side: couple.side.clone(),
        });
    }
    // rotations that an analysis lacks are decoupled from the others
    (turns..D).for_each(|k| inertia[k][k] = 1.0);
    let (inverse, _) = invert(&inertia);
    let radius = ((0..turns).map(|k| inertia[k][k]).sum::<f64>() / area).sqrt();
    let over_nodes = |part: &dyn Fn(Share<D>) -> Point<D>| -> Row<D> {
        let parts = shares.iter().map(|(&node, &share)| (node, part(share)));
        parts.collect()
    };
    let translation = |i: usize| {
        let own = over_nodes(&|share| axis::<D>(i).map(|c| c * share.weight / area));
        [own, at_point(i, centre, turns, arm)]
    };
    let rotation = |k: usize| {
        let own = over_nodes(&|share| {
            (0..turns).fold([0.0; D], |sum, l| {
                add_scaled(sum, radius * inverse[k][l], turned(l, share.moment))
            })
        });
        [own, vec![(1, axis::<D>(k).map(|c| -radius / arm * c))]]
    };
    let translations: Vec<_> = match analysis {
        Analysis::Axisymmetric => vec![translation(1)],
        _ => (0..D).map(translation).collect(),
    };
    let rotations: Vec<_> = (0..turns).map(rotation).collect();
    let carriers = shares.keys().copied();
    let rows = [translations, rotations]
        .into_iter()
        .filter(|rows| !rows.is_empty());
    Ok(carriers.zip(rows).collect())
}
