//! Nodes on two rough faces, and bodies between them, which jam: where Coulomb's law need not have an answer.
//!
//! ```text
//!   N₁(n₁ − μ₁s₁) + N₂(n₂ − μ₂s₂) = f,     Nᵢ ≥ 0
//! ```
//!
//! An overlap moves a node off both of its faces, along their normals n₁ and n₂ into its body, which responds with a force f
//! between these. So the node slips on each face towards the normal of the other one, sᵢ, and friction inclines the force of each
//! face away from the other one, by the angle φᵢ = atan μᵢ. With the angle θ between the normals the two forces enclose
//! θ + φ₁ + φ₂. From 180° on no force between n₁ and n₂ is a sum of them: at a right angle, where μ₁μ₂ ≥ 1.
//!
//! From there on the cones of friction of two flat faces of one body contain opposite forces, too. By statics alone they bear any
//! load then, even one that draws the body out from between the faces. But those forces have to come from elasticity, and a body
//! that was not pressed in before is not pressed by being drawn out: it has no such forces.

use crate::dual::{Block, Multipliers};
use crate::fem::show;
use crate::geometry::{Point, dot};
use crate::model::nouns::error::Advice;
use crate::model::nouns::model::Model;
use crate::model::system::condense::Condensed;
use crate::model::system::parts::part_name;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Faces whose normals are closer than this to opposite ones are those of a slit, not of a corner.
const SLIT: f64 = 1e-3;

/// A side is flat whose normals differ by less than this, as the cosines of angles do from 1.
const FLAT_SIDE: f64 = 1e-9;

/// A rough face at a node, or a flat one: its normal and coefficient.
type Face<const D: usize> = (Point<D>, f64);

/// Advice about the first node that two rough faces jam, among the nodes that press both faces or overlap them under some forces.
pub(crate) fn jammed<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    forces: &Multipliers,
) -> Option<Advice> {
    let gap = condensed.problem.gap(forces);
    let meets = |row: usize| forces.lambda[row] > 0.0 || gap[row] < 0.0;
    let carriers = condensed.conditions.iter().flat_map(|condition| {
        let carriers = condition.interface.carriers();
        carriers.map(move |node| ((condition.nonmortar.body.0, node.node), node.normal()))
    });
    let blocks = condensed.problem.admissible.iter();
    let mut faces: BTreeMap<(usize, usize), Vec<Face<D>>> = BTreeMap::new();
    for ((at, normal), (block, rows)) in carriers.zip(blocks) {
        if let Some(coefficient) = coefficient(block).filter(|_| meets(rows.start)) {
            faces.entry(at).or_default().push((normal, coefficient));
        }
    }
    faces.into_iter().find_map(|((body, node), faces)| {
        let (coefficients, limit) = first_jam(&faces)?;
        let at = show(model.bodies[body].mesh.points()[node]);
        Some(Advice::Jammed {
            node: format!("node {node} at {at} of body \"{}\"", part_name(model, body)),
            coefficients,
            limit,
        })
    })
}

/// Advice about the first floating body that two flat rough faces jam.
pub(crate) fn wedged<const D: usize>(model: &Model<D>, condensed: &Condensed<D>) -> Option<Advice> {
    let mut blocks = condensed.problem.admissible.blocks().iter();
    let mut faces: BTreeMap<usize, Vec<Face<D>>> = BTreeMap::new();
    for condition in &condensed.conditions {
        let normals: Vec<Point<D>> = condition.interface.carriers().map(|n| n.normal()).collect();
        let own = blocks.by_ref().take(normals.len());
        let rough = own.filter_map(coefficient).reduce(f64::min);
        let (Some(coefficient), Some(&normal)) = (rough, normals.first()) else {
            continue;
        };
        if normals.iter().all(|n| dot(*n, normal) > 1.0 - FLAT_SIDE) {
            let own = (condition.nonmortar.body.0, normal);
            let other = condition.mortar.as_ref();
            let other = other.map(|side| (side.body.0, normal.map(|x| -x)));
            for (body, normal) in [Some(own), other].into_iter().flatten() {
                faces.entry(body).or_default().push((normal, coefficient));
            }
        }
    }
    faces.into_iter().find_map(|(body, faces)| {
        let floats = !condensed.bodies[body].system.modes.is_empty();
        let (coefficients, limit) = floats.then(|| first_jam(&faces)).flatten()?;
        Some(Advice::Wedged {
            body: part_name(model, body),
            coefficients,
            limit,
        })
    })
}

/// The first two of some faces that jam.
fn first_jam<const D: usize>(faces: &[Face<D>]) -> Option<([f64; 2], f64)> {
    let pairs = (1..faces.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    pairs.map(|(i, j)| [faces[i], faces[j]]).find_map(jam)
}

/// Coefficients of two faces that jam, and the limit below which they do not.
fn jam<const D: usize>([first, second]: [Face<D>; 2]) -> Option<([f64; 2], f64)> {
    let between = dot(first.0, second.0).clamp(-1.0, 1.0).acos();
    let coefficients = [first.1, second.1];
    let enclosed = between + coefficients.map(f64::atan).iter().sum::<f64>();
    let limit = (0.5 * (PI - between)).tan();
    (between < PI - SLIT && enclosed >= PI).then_some((coefficients, limit))
}

/// The coefficient of a law whose bound follows from the normal force: that of small forces, where it is largest.
fn coefficient(block: &Block) -> Option<f64> {
    let law = block.friction().filter(|law| law.follows());
    law.map(|law| law.touch(0.0).growth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_at_a_right_angle_jam_where_the_product_of_their_coefficients_is_one() {
        let faces = |a: f64, b: f64| jam([([0.0, 1.0], a), ([1.0, 0.0], b)]);
        assert_eq!(faces(0.9, 1.0), None);
        let (coefficients, limit) = faces(0.6, 1.7).unwrap();
        assert_eq!(coefficients, [0.6, 1.7]);
        assert!((limit - 1.0).abs() < 1e-15);
        assert_eq!(faces(0.6, 1.6), None);
    }

    #[test]
    fn acute_wedges_jam_sooner_and_slits_are_none() {
        // faces that enclose 60 degrees: normals 120 degrees apart
        let normal = |angle: f64| [angle.to_radians().cos(), angle.to_radians().sin()];
        let wedge = |mu: f64| jam([(normal(0.0), mu), (normal(120.0), mu)]);
        assert_eq!(wedge(0.57), None);
        assert!((wedge(0.58).unwrap().1 - 1.0 / 3f64.sqrt()).abs() < 1e-12);
        assert_eq!(jam([([1.0, 0.0], 0.3), ([-1.0, 0.0], 0.3)]), None);
        // one plane in two contacts
        assert_eq!(jam([([1.0, 0.0], 5.0), ([1.0, 0.0], 5.0)]), None);
    }
}
