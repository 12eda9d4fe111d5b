//! `contact.csv`: one row per contact node.
//!
//! Signs: gap ≥ 0 open, pressure ≥ 0 compression. Vectors along the interface are given in 2D as one number along the
//! tangent, which is the normal rotated by +90°. Numbers are the shortest that read back to the same bits.

use crate::geometry::dot;
use crate::model::{ContactNode, Law, Model, Solution};
use crate::output::chain::tangent;
use std::fmt::Write;

/// Content of `contact.csv` for the steps of one run (numbered from 1).
///
/// The columns `shear` and `slip` are there as soon as one contact bears shear (friction or tied).
pub fn contact_csv(model: &Model<2>, steps: &[Solution<2>]) -> String {
    let shear = model
        .contacts
        .iter()
        .any(|contact| !matches!(contact.law, Law::Frictionless));
    let mut out = String::from("step,contact,node,x,y,nx,ny,weight,gap,pressure");
    if shear {
        out.push_str(",shear,slip");
    }
    out.push_str(",status\n");
    for (step, solution) in steps.iter().enumerate() {
        for contact in &solution.contacts {
            for node in &contact.nodes {
                // Writing to a String cannot fail.
                let _ = write!(out, "{},{}", step + 1, contact.name);
                row(&mut out, node, shear);
            }
        }
    }
    out
}

fn row(out: &mut String, node: &ContactNode<2>, shear: bool) {
    let _ = write!(out, ",{}", node.node);
    let mut numbers = vec![
        node.point[0],
        node.point[1],
        node.normal[0],
        node.normal[1],
        node.weight,
        node.gap,
        node.pressure,
    ];
    if shear {
        let tangent = tangent(node.normal);
        numbers.extend([dot(node.shear, tangent), dot(node.slip, tangent)]);
    }
    for value in numbers {
        // Adding zero turns −0 into 0.
        let _ = write!(out, ",{:?}", value + 0.0);
    }
    let _ = writeln!(out, ",{}", node.status.name());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Field;
    use crate::output::tunnel;

    #[test]
    fn frictionless_header_is_the_contracted_one() {
        let (model, solution) = tunnel::solved();
        let text = contact_csv(&model, std::slice::from_ref(&solution));
        let mut lines = text.lines();
        assert_eq!(
            lines.next(),
            Some("step,contact,node,x,y,nx,ny,weight,gap,pressure,status")
        );
        let first: Vec<&str> = lines.next().unwrap().split(',').collect();
        let node = &solution.contacts[0].nodes[0];
        assert_eq!(first[0..2], ["1", "lining"]);
        assert_eq!(first[2].parse(), Ok(node.node));
        assert_eq!(first[9].parse(), Ok(node.pressure), "bits must survive");
        assert_eq!(lines.count() + 1, solution.contacts[0].nodes.len());
    }

    #[test]
    fn friction_adds_scalars_along_the_tangent() {
        let (mut model, mut solution) = tunnel::solved();
        model.contacts[0].law = Law::Coulomb(Field::constant(0.3));
        let node = &mut solution.contacts[0].nodes[0];
        (node.normal, node.shear, node.slip) = ([0.0, -1.0], [2.5, 0.0], [f64::NAN; 2]);
        let text = contact_csv(&model, std::slice::from_ref(&solution));
        let mut lines = text.lines();
        assert!(
            lines
                .next()
                .unwrap()
                .ends_with(",gap,pressure,shear,slip,status")
        );
        let first: Vec<&str> = lines.next().unwrap().split(',').collect();
        // (0, −1) rotated by +90° is (1, 0).
        assert_eq!(first[10..12], ["2.5", "NaN"]);
    }
}
