//! The `.dat`: tables of the answers that the deck asks to be printed.
//!
//! The requests are those of the sections "*NODE PRINT", "*EL PRINT" and "*CONTACT PRINT" of the
//! manual of CalculiX CrunchiX; the manual leaves the text itself open, which is that of ccx 2.20.
//! Each table is a blank line, a heading that ends with the time, a blank line, and rows: numbers
//! of nodes and elements in ten columns, values as `1x,1pE13.6` of Fortran.

use crate::number::{fraction, scientific};
use crate::results::{
    ContactForce, ContactPrint, ContactQuantity, Mesh, NodePrint, NodeQuantity, PointPrint,
    PointQuantity, Print, Step, Totals,
};
use std::borrow::Borrow;
use std::fmt::Arguments;
use std::io::{self, BufWriter, Write};

/// Writes the tables of each step, in the order of its requests.
///
/// ccx prints the tables of a step in the order of the deck, but CF after all others.
///
/// # Panics
/// Where a request names an index that `mesh` or a step lacks.
pub fn write<S: Borrow<Step>>(
    out: &mut impl Write,
    mesh: &Mesh,
    steps: &[(S, Vec<Print>)],
) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    for (step, prints) in steps {
        let step = step.borrow();
        for print in prints {
            match print {
                Print::Nodes(print) => write_node_print(&mut out, mesh, step, print)?,
                Print::Points(print) => write_point_print(&mut out, step.time, print)?,
                Print::Contact(print) => write_contact_print(&mut out, step, print)?,
                Print::ContactForce(force) => write_contact_force(&mut out, step.time, force)?,
            }
        }
    }
    out.flush()
}

fn write_node_print(
    out: &mut impl Write,
    mesh: &Mesh,
    step: &Step,
    print: &NodePrint,
) -> io::Result<()> {
    let set = print.set.to_uppercase();
    let (heading, values, totals) = match print.quantity {
        NodeQuantity::Displacement => ("displacements (vx,vy,vz)", &step.displacement, Totals::No),
        NodeQuantity::Reaction => ("forces (fx,fy,fz)", &step.reaction, print.totals),
    };
    if totals != Totals::Only {
        write_heading(
            out,
            &format!(" {heading} for set {set} and time "),
            step.time,
        )?;
        for &index in &print.nodes {
            write_row(
                out,
                format_args!("{:10}", mesh.nodes[index].0),
                &values[index],
            )?;
        }
    }
    if totals != Totals::No {
        write_heading(
            out,
            &format!(" total force (fx,fy,fz) for set {set} and time "),
            step.time,
        )?;
        let total = print
            .nodes
            .iter()
            .fold([0.0; 3], |total: [f64; 3], &index| {
                std::array::from_fn(|axis| total[axis] + values[index][axis])
            });
        write_row(out, format_args!("{:6}", ""), &total)?;
    }
    Ok(())
}

fn write_point_print(out: &mut impl Write, time: f64, print: &PointPrint) -> io::Result<()> {
    let heading = match print.quantity {
        PointQuantity::Stress => "stresses (elem, integ.pnt.,sxx,syy,szz,sxy,sxz,syz)",
        PointQuantity::Strain => "strains (elem, integ.pnt.,exx,eyy,ezz,exy,exz,eyz)",
    };
    let set = print.set.to_uppercase();
    write_heading(out, &format!(" {heading} for set {set} and time "), time)?;
    for (element, point, values) in &print.rows {
        write_row(out, format_args!("{element:10} {point:3}"), values)?;
    }
    Ok(())
}

fn write_contact_print(out: &mut impl Write, step: &Step, print: &ContactPrint) -> io::Result<()> {
    let heading = match print.quantity {
        ContactQuantity::Displacement => {
            "relative contact displacement (slave node,normal,tang1,tang2)"
        }
        ContactQuantity::Stress => "contact stress (slave node,press,tang1,tang2)",
    };
    write_heading(
        out,
        &format!(" {heading} for all contact elements and time"),
        step.time,
    )?;
    for node in &step.contact[print.nodes.clone()] {
        let (normal, tangential) = match print.quantity {
            ContactQuantity::Displacement => (node.gap, node.slip),
            ContactQuantity::Stress => (node.pressure, node.shear),
        };
        let values = [normal, tangential[0], tangential[1]];
        write_row(out, format_args!("{:10}", node.node), &values)?;
    }
    Ok(())
}

fn write_contact_force(out: &mut impl Write, time: f64, print: &ContactForce) -> io::Result<()> {
    let ContactForce {
        force,
        moment,
        center,
        normal,
        area,
        ..
    } = print;
    let [slave, master] = [&print.slave, &print.master].map(|name| name.to_uppercase());
    writeln!(out)?;
    let heading = format!(" statistics for slave set {slave}, master set {master} and time ");
    write_heading(out, &heading, time)?;
    writeln!(
        out,
        "   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)\n"
    )?;
    write_row(out, format_args!("  "), &[*force, *moment].concat())?;
    writeln!(out, "\n   center of gravity and mean normal\n")?;
    write_row(out, format_args!("  "), &[*center, *normal].concat())?;
    writeln!(out, "\n   moment about the center of gravity(mx,my,mz)\n")?;
    let lever = cross(*center, *force);
    let moment: [f64; 3] = std::array::from_fn(|axis| moment[axis] - lever[axis]);
    write_row(out, format_args!("  "), &moment)?;
    writeln!(
        out,
        "\n   area,  normal force (+ = tension) and shear force (size)\n"
    )?;
    let along: f64 = force.iter().zip(normal).map(|(f, n)| f * n).sum();
    let across = force
        .iter()
        .zip(normal)
        .map(|(f, n)| (f - along * n).powi(2))
        .sum::<f64>();
    write_row(out, format_args!("  "), &[*area, along, across.sqrt()])
}

/// The cross product of two vectors.
fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// A blank line, `text` with the time after it, a blank line.
fn write_heading(out: &mut impl Write, text: &str, time: f64) -> io::Result<()> {
    let mut line = format!("\n{text}").into_bytes();
    fraction(&mut line, time, 14, 7);
    line.extend_from_slice(b"\n\n");
    out.write_all(&line)
}

/// One line: `label`, then the values.
fn write_row(out: &mut impl Write, label: Arguments, values: &[f64]) -> io::Result<()> {
    let mut line = Vec::with_capacity(128);
    line.write_fmt(label)?;
    for &value in values {
        line.push(b' ');
        scientific(&mut line, value, 13, 6);
    }
    line.push(b'\n');
    out.write_all(&line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{ContactNode, PointRow};

    // what ccx 2.20 printed for the decks of the same names in the folder `golden`
    const BLOCKS: &str = include_str!("../golden/blocks.dat");
    const PENALTY: &str = include_str!("../golden/penalty.dat");
    const CONTACT: &str = include_str!("../golden/contact.dat");

    /// The rows of numbers of each table.
    fn tables(text: &str) -> Vec<Vec<Vec<f64>>> {
        let mut tables = Vec::new();
        for line in text.lines().filter(|line| !line.is_empty()) {
            let row: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
            match row {
                Ok(row) => tables
                    .last_mut()
                    .map(|table: &mut Vec<_>| table.push(row))
                    .unwrap(),
                Err(_) => tables.push(Vec::new()),
            }
        }
        tables
    }

    /// Three numbers of each row, after its label.
    fn vectors(table: &[Vec<f64>]) -> Vec<[f64; 3]> {
        table.iter().map(|row| [row[1], row[2], row[3]]).collect()
    }

    fn point_rows(table: &[Vec<f64>]) -> Vec<PointRow> {
        let row = |row: &Vec<f64>| (row[0] as u64, row[1] as usize, row[2..].try_into().unwrap());
        table.iter().map(row).collect()
    }

    fn node_print(set: &str, nodes: &[usize], quantity: NodeQuantity, totals: Totals) -> Print {
        Print::Nodes(NodePrint {
            set: set.to_owned(),
            nodes: nodes.to_vec(),
            quantity,
            totals,
        })
    }

    fn written(mesh: &Mesh, steps: &[(Step, Vec<Print>)]) -> String {
        let mut out = Vec::new();
        write(&mut out, mesh, steps).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn tables_of_two_bricks_are_those_of_ccx() {
        use NodeQuantity::{Displacement, Reaction};
        let tables = tables(BLOCKS);
        let nodes = tables[0]
            .iter()
            .map(|row| (row[0] as u64, [0.0; 3]))
            .collect();
        let mesh = Mesh {
            nodes,
            ..Mesh::default()
        };
        let first = Step {
            number: [1, 1],
            time: 1.0,
            displacement: vectors(&tables[0]),
            reaction: vectors(&tables[1]),
            ..Step::default()
        };
        let (all, part): (Vec<usize>, _) = ((0..12).collect(), [0, 10]);
        let set = String::from("Eall");
        let point = |quantity, index: usize| {
            let rows = point_rows(&tables[index]);
            Print::Points(PointPrint {
                set: set.clone(),
                quantity,
                rows,
            })
        };
        let prints = vec![
            node_print("Nall", &all, Displacement, Totals::No),
            node_print("Nall", &all, Reaction, Totals::No),
            node_print("Npart", &part, Reaction, Totals::Yes),
            node_print("Npart", &part, Displacement, Totals::Yes),
            point(PointQuantity::Stress, 5),
            point(PointQuantity::Strain, 6),
        ];
        let mut displacement = vec![[0.0; 3]; 12];
        displacement[10] = vectors(&tables[8])[1];
        let total: [f64; 3] = tables[7][0].clone().try_into().unwrap();
        let second = Step {
            number: [2, 1],
            time: 2.0,
            displacement,
            reaction: [vec![total], vec![[0.0; 3]; 11]].concat(),
            ..Step::default()
        };
        let later = vec![
            node_print("Npart", &part, Reaction, Totals::Only),
            node_print("Npart", &part, Displacement, Totals::Only),
        ];
        assert_eq!(written(&mesh, &[(first, prints), (second, later)]), BLOCKS);
    }

    #[test]
    fn tables_of_contact_are_those_of_ccx() {
        let tables = tables(PENALTY);
        let contact = vectors(&tables[0])
            .into_iter()
            .zip(vectors(&tables[1]))
            .zip(&tables[0]);
        let contact = contact
            .map(|((motion, stress), row)| ContactNode {
                node: row[0] as u64,
                gap: motion[0],
                slip: [motion[1], motion[2]],
                pressure: stress[0],
                shear: [stress[1], stress[2]],
            })
            .collect();
        let step = Step {
            number: [1, 1],
            time: 1.0,
            contact,
            ..Step::default()
        };
        let print = |quantity| {
            Print::Contact(ContactPrint {
                quantity,
                nodes: 0..4,
            })
        };
        let prints = vec![
            print(ContactQuantity::Displacement),
            print(ContactQuantity::Stress),
        ];
        assert_eq!(written(&Mesh::default(), &[(step, prints)]), PENALTY);
    }

    /// Byte for byte but the moment about the center: a difference of rounded numbers here.
    #[test]
    fn force_of_a_pair_is_that_of_ccx() {
        let tables = tables(CONTACT);
        let [force, center] = [1, 2].map(|table| &tables[table][0]);
        let print = ContactForce {
            slave: "Sslav".into(),
            master: "Smast".into(),
            force: force[..3].try_into().unwrap(),
            moment: force[3..].try_into().unwrap(),
            center: center[..3].try_into().unwrap(),
            normal: center[3..].try_into().unwrap(),
            area: tables[4][0][0],
        };
        let step = Step {
            number: [1, 1],
            time: 1.0,
            ..Step::default()
        };
        let text = written(
            &Mesh::default(),
            &[(step, vec![Print::ContactForce(print)])],
        );
        let moment = CONTACT
            .lines()
            .position(|line| line.contains("moment about the center"));
        let moment = moment.unwrap() + 2;
        for (index, (ours, theirs)) in text.lines().zip(CONTACT.lines()).enumerate() {
            assert!(index == moment || ours == theirs, "{ours}\n{theirs}");
        }
        assert_eq!(text.len(), CONTACT.len());
        let ours = text.lines().nth(moment).unwrap().split_whitespace();
        let theirs = CONTACT.lines().nth(moment).unwrap().split_whitespace();
        for (ours, theirs) in ours.zip(theirs) {
            let [ours, theirs] = [ours, theirs].map(|text| text.parse::<f64>().unwrap());
            assert!((ours - theirs).abs() < 1e-3, "{ours} {theirs}");
        }
    }
}
