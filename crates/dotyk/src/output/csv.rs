//! `contact.csv`: one row per contact node; `lines.csv`: one row per place of a probe along a line.
//!
//! Signs: gap ≥ 0 open, pressure ≥ 0 compression. Vectors along the interface are given in 2D as one number along the
//! tangent, which is the normal rotated by +90°. Numbers are the shortest that read back to the same bits.

use crate::geometry::dot;
use crate::model::{ContactNode, ContactSolution, Law, Model, SideRef, Solution};
use crate::output::chain::{angles, arc_lengths, tangent};
use std::fmt::Write;

/// Content of `contact.csv` for the steps of one run (numbered from 1).
///
/// The columns `shear` and `slip` are there as soon as one contact bears shear (friction or tied). After the status:
/// time of the step; `arc`, the length of the way from the first node along the undeformed side; `angle`, where all nodes
/// lie on a circle, about its centre in degrees from +x, running on past half a turn; the sides, "BODY.SIDE", of which the
/// other is `obstacle` where it is one.
pub fn contact_csv(model: &Model<2>, steps: &[Solution<2>]) -> String {
    let shear = model
        .contacts
        .iter()
        .any(|contact| !matches!(contact.law, Law::Frictionless));
    let mut out = String::from("step,contact,node,x,y,nx,ny,weight,gap,pressure");
    if shear {
        out.push_str(",shear,slip");
    }
    out.push_str(",status,time,arc,angle,nonmortar,mortar\n");
    for (step, solution) in steps.iter().enumerate() {
        for contact in &solution.contacts {
            rows(&mut out, model, (step + 1, solution.time), contact, shear);
        }
    }
    out
}

/// The rows of one contact in one step.
fn rows(
    out: &mut String,
    model: &Model<2>,
    (step, time): (usize, f64),
    contact: &ContactSolution<2>,
    shear: bool,
) {
    let points: Vec<_> = contact.nodes.iter().map(|node| node.point).collect();
    let (arcs, angles) = (arc_lengths(&points), angles(&points));
    let name = |side: &SideRef| format!("{}.{}", model.bodies[side.body.0].name, side.side);
    let mortar = contact.mortar.as_ref().map_or("obstacle".to_string(), name);
    let sides = format!("{},{mortar}", name(&contact.nonmortar));
    for (k, node) in contact.nodes.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = write!(out, "{step},{},{}", contact.name, node.node);
        numbers(out, &of_node(node, shear));
        let _ = write!(out, ",{}", node.status.name());
        let angle = angles.as_ref().map_or(f64::NAN, |angles| angles[k]);
        numbers(out, &[time, arcs[k], angle]);
        let _ = writeln!(out, ",{sides}");
    }
}

/// Columns of `lines.csv`.
pub const LINES_HEAD: &str = "step,probe,s,x,y,value\n";

/// Content of `lines.csv` for the steps of one run (numbered from 1), probe by probe; nothing where no probe is read along a
/// line.
pub fn lines_csv(steps: &[Solution<2>]) -> Option<String> {
    let mut out = String::from(LINES_HEAD);
    for (step, solution) in steps.iter().enumerate() {
        for probe in &solution.probes {
            let start = format!("{},{}", step + 1, quoted(&probe.name));
            for place in &probe.line {
                out.push_str(&start);
                numbers(
                    &mut out,
                    &[place.s, place.point[0], place.point[1], place.value],
                );
                out.push('\n');
            }
        }
    }
    (out.len() > LINES_HEAD.len()).then_some(out)
}

/// A text as one cell: quoted where a comma, a quote or a new line would end it.
pub fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_string(),
    }
}

fn of_node(node: &ContactNode<2>, shear: bool) -> Vec<f64> {
    let mut list = Vec::with_capacity(9);
    list.extend(node.point);
    list.extend(node.normal);
    list.extend([node.weight, node.gap, node.pressure]);
    if shear {
        let tangent = tangent(node.normal);
        list.extend([dot(node.shear, tangent), dot(node.slip, tangent)]);
    }
    list
}

/// Columns after the first one.
fn numbers(out: &mut String, values: &[f64]) {
    for value in values {
        // Adding zero turns −0 into 0.
        let _ = write!(out, ",{:?}", value + 0.0);
    }
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
            Some(
                "step,contact,node,x,y,nx,ny,weight,gap,pressure,status,time,arc,angle,nonmortar,mortar"
            )
        );
        let first: Vec<&str> = lines.next().unwrap().split(',').collect();
        let node = &solution.contacts[0].nodes[0];
        assert_eq!(first[0..2], ["1", "lining"]);
        assert_eq!(first[2].parse(), Ok(node.node));
        assert_eq!(first[9].parse(), Ok(node.pressure), "bits must survive");
        assert_eq!(first[14..], ["ring.outer", "rock.hole"]);
        assert_eq!(lines.count() + 1, solution.contacts[0].nodes.len());
        // on a circle the arc grows by the chord of the angle
        let cells: Vec<Vec<&str>> = text
            .lines()
            .skip(1)
            .map(|l| l.split(',').collect())
            .collect();
        let at = |k: usize, column: usize| cells[k][column].parse::<f64>().unwrap();
        let radius = node.point[0].hypot(node.point[1]);
        for k in 1..cells.len() {
            let [chord, turn] = [12, 13].map(|column| at(k, column) - at(k - 1, column));
            let exact = 2.0 * radius * (0.5 * turn.abs()).to_radians().sin();
            assert!(
                turn != 0.0 && (chord - exact).abs() < 1e-9 * radius,
                "{chord} {exact}"
            );
        }
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
                .contains(",gap,pressure,shear,slip,status,")
        );
        let first: Vec<&str> = lines.next().unwrap().split(',').collect();
        // (0, −1) rotated by +90° is (1, 0).
        assert_eq!(first[10..12], ["2.5", "NaN"]);
    }
}
