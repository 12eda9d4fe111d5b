//! `contact.csv`: one row per contact node; `lines.csv`: one row per place of a probe along a line; `beds.csv`: one row per point of a
//! bed; `sections.csv` and files of members, such as `bars.csv`: one row per station of a section or of a member.
//!
//! Signs: gap ≥ 0 open, pressure ≥ 0 compression. Vectors along the interface are given in 2D as one number along the
//! tangent, which is the normal rotated by +90°, in space by their components. Numbers are the shortest that read back to the same
//! bits.

use crate::model::{
    Analysis, ContactNode, ContactSolution, Law, MemberWords, Model, SideRef, Solution,
};
use crate::output::chain::{along_tangent, angles, arc_lengths};
use crate::output::text::AXES;
use std::borrow::Cow;
use std::fmt::Write;

/// Content of `contact.csv` for the steps of one run (numbered from 1), with the model of each.
///
/// The columns `shear` and `slip` (in space `shear_x` ...) are present if one contact bears shear (friction or tied).
/// After the status: time of the step; in the plane `arc`, the distance from the first node along the undeformed side, and
/// `angle`, if all nodes lie on a circle, about its centre in degrees from +x, continued beyond half a turn; the sides,
/// "BODY.SIDE", the other one `obstacle` for an obstacle.
pub fn contact_csv<const D: usize>(stages: &[Cow<'_, Model<D>>], steps: &[Solution<D>]) -> String {
    let mut contacts = stages.iter().flat_map(|stage| &stage.contacts);
    let shear = contacts.any(|contact| !matches!(contact.law, Law::Frictionless));
    let axes = AXES[..D].join(",");
    let mut out = format!(
        "step,contact,node,{axes},n{},weight,gap,pressure",
        AXES[..D].join(",n")
    );
    for vector in ["shear", "slip"].iter().filter(|_| shear) {
        match D {
            2 => out += &format!(",{vector}"),
            _ => AXES
                .iter()
                .for_each(|axis| out += &format!(",{vector}_{axis}")),
        }
    }
    out.push_str(",status,time");
    out.push_str(if D == 2 { ",arc,angle" } else { "" });
    out.push_str(",nonmortar,mortar\n");
    for (step, (solution, model)) in steps.iter().zip(stages).enumerate() {
        for contact in &solution.contacts {
            rows(&mut out, model, (step + 1, solution.time), contact, shear);
        }
    }
    out
}

/// The rows of one contact in one step.
fn rows<const D: usize>(
    out: &mut String,
    model: &Model<D>,
    (step, time): (usize, f64),
    contact: &ContactSolution<D>,
    shear: bool,
) {
    let nodes = contact.nodes.iter();
    let points: Vec<[f64; 2]> = nodes.map(|node| [node.point[0], node.point[1]]).collect();
    let plane = (D == 2).then(|| (arc_lengths(&points), angles(&points)));
    let name =
        |side: &SideRef| quoted(&format!("{}.{}", model.bodies[side.body.0].name, side.side));
    let mortar = contact.mortar.as_ref().map_or("obstacle".to_string(), name);
    let sides = format!("{},{mortar}", name(&contact.nonmortar));
    let start = format!("{step},{}", quoted(&contact.name));
    for (k, node) in contact.nodes.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = write!(out, "{start},{}", node.node);
        numbers(out, &of_node(node, shear));
        let _ = write!(out, ",{}", node.status.name());
        numbers(out, &[time]);
        if let Some((arcs, angles)) = &plane {
            let angle = angles.as_ref().map_or(f64::NAN, |angles| angles[k]);
            numbers(out, &[arcs[k], angle]);
        }
        let _ = writeln!(out, ",{sides}");
    }
}

/// Beginning of `lines.csv`.
pub const LINES_HEAD: &str = "step,probe,s,x,y";

/// Content of `lines.csv` for the steps of one run (numbered from 1), probe by probe; `None` without a probe along a line.
pub fn lines_csv<const D: usize>(steps: &[Solution<D>]) -> Option<String> {
    let mut out = format!("{LINES_HEAD}{}value\n", if D == 2 { "," } else { ",z," });
    let head = out.len();
    for (step, solution) in steps.iter().enumerate() {
        for probe in &solution.probes {
            let start = format!("{},{}", step + 1, quoted(&probe.name));
            for place in &probe.line {
                out.push_str(&start);
                numbers(&mut out, &[place.s]);
                numbers(&mut out, &place.point[..D]);
                numbers(&mut out, &[place.value]);
                out.push('\n');
            }
        }
    }
    (out.len() > head).then_some(out)
}

/// Beginning of `beds.csv`.
pub const BEDS_HEAD: &str = "step,bed,point,x,y";

/// Content of `beds.csv` for the steps of one run (numbered from 1), points of integration numbered from 1; `None` without beds.
pub fn beds_csv<const D: usize>(steps: &[Solution<D>]) -> Option<String> {
    let axes = &AXES[..D];
    let mut out = format!(
        "{BEDS_HEAD}{},n{},area,pressure,gap,shear_{},closed\n",
        if D == 2 { "" } else { ",z" },
        axes.join(",n"),
        axes.join(",shear_")
    );
    let head = out.len();
    for (step, solution) in steps.iter().enumerate() {
        for bed in &solution.beds {
            let points = bed.points.iter().enumerate();
            numbered(&mut out, (step, &bed.name), points, |out, at| {
                numbers(out, &at.point);
                numbers(out, &at.normal);
                numbers(out, &[at.area, at.pressure, at.gap]);
                numbers(out, &at.shear);
                let _ = write!(out, ",{}", u8::from(at.closed));
            });
        }
    }
    (out.len() > head).then_some(out)
}

/// The file of a kind of members.
pub fn members_file(kind: &MemberWords) -> String {
    format!("{}.csv", kind.plural)
}

/// Its beginning.
pub fn members_head(kind: &MemberWords) -> String {
    format!("step,{},station,s,x,y", kind.key)
}

/// Its content for the steps of one run (numbered from 1), stations numbered from 1: the middles of the elements of each member,
/// with N of one; `None` without members of this kind.
pub fn members_csv<const D: usize>(kind: MemberWords, steps: &[Solution<D>]) -> Option<String> {
    let mut out = members_head(&kind) + if D == 2 { ",force\n" } else { ",z,force\n" };
    let head = out.len();
    for (step, solution) in steps.iter().enumerate() {
        for member in solution.members.iter().filter(|own| own.kind == kind) {
            let stations = member.stations.iter().enumerate();
            numbered(&mut out, (step, &member.name), stations, |out, station| {
                numbers(out, &[station.s]);
                numbers(out, &station.point[..D]);
                numbers(out, &[station.force]);
            });
        }
    }
    (out.len() > head).then_some(out)
}

/// Beginning of `sections.csv`.
pub const SECTIONS_HEAD: &str =
    "step,section,station,s,x,y,angle,thickness,N,V,M,stress_first,stress_second";

/// The same in space.
pub const SECTIONS_IN_SPACE: &str =
    "step,section,station,s,along,x,y,z,angle,thickness,N,V,M,stress_first,stress_second,V2,M2,T";

/// Content of `sections.csv` for the steps of one run (numbered from 1), stations numbered from 1; `None` without sections.
/// With axial symmetry `hoop_N` and `hoop_M` follow, the forces around the axis, and `utilisation` if a section has a capacity.
pub fn sections_csv<const D: usize>(model: &Model<D>, steps: &[Solution<D>]) -> Option<String> {
    let hoop = model.analysis == Analysis::Axisymmetric;
    let limited = model
        .sections
        .iter()
        .any(|section| section.capacity.is_some());
    let more = if hoop { ",hoop_N,hoop_M" } else { "" };
    let last = if limited { ",utilisation" } else { "" };
    let start = if D == 3 {
        SECTIONS_IN_SPACE
    } else {
        SECTIONS_HEAD
    };
    let mut out = format!("{start}{more}{last}\n");
    let head = out.len();
    for (step, solution) in steps.iter().enumerate() {
        for section in &solution.sections {
            numbered(
                &mut out,
                (step, &section.name),
                section.known(),
                |out, station| {
                    numbers(out, &[station.s]);
                    let along = station.across.map(|across| across.along);
                    numbers(out, along.as_slice());
                    numbers(out, &station.place()[..D]);
                    numbers(out, &[station.angle(), station.thickness]);
                    numbers(out, &[station.normal, station.shear, station.moment]);
                    numbers(out, &station.edge_stress());
                    if let Some(own) = station.across {
                        numbers(out, &[own.shear, own.moment.unwrap_or(f64::NAN), own.twist]);
                    }
                    numbers(out, station.hoop.as_ref().map_or(&[], |hoop| &hoop[..]));
                    if limited {
                        numbers(out, &[station.utilisation.unwrap_or(f64::NAN)]);
                    }
                },
            );
        }
    }
    (out.len() > head).then_some(out)
}

/// A row for each place of a part in a step, from 0, which begins with the number of the step, the name and the number of the place.
fn numbered<'p, T: 'p>(
    out: &mut String,
    (step, name): (usize, &str),
    places: impl Iterator<Item = (usize, &'p T)>,
    write: impl Fn(&mut String, &T),
) {
    let start = format!("{},{}", step + 1, quoted(name));
    for (index, place) in places {
        // Writing to a String cannot fail.
        let _ = write!(out, "{start},{}", index + 1);
        write(out, place);
        out.push('\n');
    }
}

/// Characters with which a cell becomes a formula.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// A text as one cell: quoted if a comma, a quote or a new line would end it, and preceded by an apostrophe if a spreadsheet would
/// run it as a formula.
pub fn quoted(text: &str) -> String {
    let guard = if text.starts_with(FORMULA) { "'" } else { "" };
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{guard}{}\"", text.replace('"', "\"\"")),
        false => format!("{guard}{text}"),
    }
}

/// The text of a cell that needed no quotes.
pub fn unguarded(cell: &str) -> &str {
    let text = cell.strip_prefix('\'');
    text.filter(|text| text.starts_with(FORMULA))
        .unwrap_or(cell)
}

fn of_node<const D: usize>(node: &ContactNode<D>, shear: bool) -> Vec<f64> {
    let mut list = Vec::with_capacity(15);
    list.extend(node.point);
    list.extend(node.normal);
    list.extend([node.weight, node.gap, node.pressure]);
    if shear {
        for vector in [node.shear, node.slip] {
            match D {
                2 => list.push(along_tangent(vector, node.normal)),
                _ => list.extend(vector),
            }
        }
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
    use crate::model::{BodyId, Capacity, Stations};
    use crate::output::tunnel;

    #[test]
    fn frictionless_header_is_the_contracted_one() {
        let (model, solution) = tunnel::solved();
        let text = contact_csv(&[Cow::Borrowed(&model)], std::slice::from_ref(&solution));
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
    fn texts_are_no_formulas_of_a_spreadsheet() {
        for (text, cell) in [
            ("=1+2", "'=1+2"),
            ("-x", "'-x"),
            ("+a", "'+a"),
            ("@b", "'@b"),
            ("\tc", "'\tc"),
            ("a-b", "a-b"),
            ("'a", "'a"),
        ] {
            assert_eq!(quoted(text), cell);
            assert_eq!(unguarded(cell), text);
        }
        assert_eq!(
            quoted("=HYPERLINK(\"a\",1)"),
            "\"'=HYPERLINK(\"\"a\"\",1)\""
        );
        assert_eq!(quoted("\r"), "\"'\r\"");
    }

    #[test]
    fn names_that_begin_as_formulas_do_not_in_a_file() {
        let (mut model, mut solution) = tunnel::solved();
        solution.contacts[0].name = "-1".to_string();
        model.bodies[0].name = "-ring".to_string();
        let text = contact_csv(&[Cow::Borrowed(&model)], std::slice::from_ref(&solution));
        let row: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
        assert_eq!(
            [row[1], row[14], row[15]],
            ["'-1", "'-ring.outer", "rock.hole"]
        );
    }

    #[test]
    fn friction_adds_scalars_along_the_tangent() {
        let (mut model, mut solution) = tunnel::solved();
        model.contacts[0].law = Law::Coulomb(Field::constant(0.3));
        let node = &mut solution.contacts[0].nodes[0];
        (node.normal, node.shear, node.slip) = ([0.0, -1.0], [2.5, 0.0], [f64::NAN; 2]);
        let text = contact_csv(&[Cow::Borrowed(&model)], std::slice::from_ref(&solution));
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

    #[test]
    fn sections_have_the_contracted_header_and_a_row_for_each_station() {
        let (mut model, _) = tunnel::solved();
        assert_eq!(sections_csv(&model, &[]), None);
        model.section("wall", BodyId(0), ["inner", "outer"], Stations::Number(5));
        let solution = model.solve().unwrap();
        let text = sections_csv(&model, std::slice::from_ref(&solution)).unwrap();
        let mut lines = text.lines();
        assert_eq!(
            lines.next(),
            Some("step,section,station,s,x,y,angle,thickness,N,V,M,stress_first,stress_second")
        );
        let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
        assert_eq!(rows.len(), 5);
        let station = &solution.sections[0].stations[3];
        assert_eq!(rows[3][..3], ["1", "wall", "4"]);
        assert_eq!(rows[3][8].parse(), Ok(station.normal), "bits must survive");
        let used = rows.iter().map(|row| row.len());
        assert!(used.eq([13; 5]), "no utilisation without a capacity");
        model.sections[0].capacity = Some(Capacity {
            compression: 30.0,
            tension: 3.0,
            reinforcement: Vec::new(),
        });
        let solution = model.solve().unwrap();
        let text = sections_csv(&model, std::slice::from_ref(&solution)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with(",stress_second,utilisation"));
        let used = solution.sections[0].stations[3].utilisation;
        let told = lines[4].rsplit(',').next().map(|cell| cell.parse::<f64>());
        assert_eq!(told, used.map(Ok), "bits must survive");
        // half a ring from its invert up to its crown, the inner side on the left
        assert_eq!(rows[0][6].parse::<f64>().unwrap().round(), 0.0);
        assert_eq!(rows[4][6].parse::<f64>().unwrap().abs().round(), 180.0);
    }
}
