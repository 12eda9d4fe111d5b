//! The `.frd`: mesh and nodal answers for CalculiX GraphiX and other viewers, in ASCII.
//!
//! The format is that of the chapter "Result Format" of the manual of CalculiX GraphiX, in the
//! long format (numbers of ten digits), laid out as ccx 2.20 writes it. A file is a sequence of
//! records whose key stands in the first columns:
//!
//! | key             | record                                                    |
//! |-----------------|-----------------------------------------------------------|
//! | `1C`, `1U`      | name of the job, remarks                                  |
//! | `2C`            | nodes                                                     |
//! | `3C`            | elements                                                  |
//! | `1PSTEP`        | number of the block, of the increment and of the step     |
//! | `100CL`         | time and number of nodes of a block of answers            |
//! | `-4`, `-5`      | name of the quantity, of a component                      |
//! | `-1`, `-2`      | one node or element, the nodes of that element            |
//! | `-3`, `9999`    | end of a block, of the file                               |

use crate::number::scientific;
use crate::results::{ContactNode, Element, FrdQuantity, Kind, Mesh, Step};
use std::borrow::Borrow;
use std::collections::HashMap;
use std::io::{self, BufWriter, Write};

/// The quantities in the order of ccx.
const ORDER: [FrdQuantity; 5] = [
    FrdQuantity::Displacement,
    FrdQuantity::Stress,
    FrdQuantity::Strain,
    FrdQuantity::Reaction,
    FrdQuantity::Contact,
];

/// Program and version that the file names as its source.
const PROGRAM: [&str; 2] = ["dotyk", env!("CARGO_PKG_VERSION")];

/// Writes mesh and steps as a `.frd` whose model is called `job`.
///
/// Each block lists every node of the mesh, the quantities of a step in the order of ccx.
///
/// # Panics
/// Where an array of a step, asked for, is shorter than the nodes of the mesh.
pub fn write<S: Borrow<Step>>(
    out: &mut impl Write,
    job: &str,
    mesh: &Mesh,
    steps: &[(S, Vec<FrdQuantity>)],
) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    write_header(&mut out, job, mesh)?;
    write_nodes(&mut out, mesh)?;
    write_elements(&mut out, mesh)?;
    let mut block = 0;
    for (index, (step, requested)) in steps.iter().enumerate() {
        for quantity in ORDER.into_iter().filter(|each| requested.contains(each)) {
            block += 1;
            write_block_head(&mut out, block, index + 1, step.borrow(), mesh.nodes.len())?;
            write_components(&mut out, quantity)?;
            write_values(&mut out, mesh, step.borrow(), quantity)?;
        }
    }
    writeln!(out, " 9999")?;
    out.flush()
}

/// Heading, job, program and materials. User, host and folder stay blank and the time is no real one, so that the same answer is
/// the same file everywhere; a reader may insist that it is a time.
fn write_header(out: &mut impl Write, job: &str, mesh: &Mesh) -> io::Result<()> {
    writeln!(out, "    1C{job}")?;
    for line in &mesh.headings {
        writeln!(out, "    1U{line:<66}")?;
    }
    let [program, version] = PROGRAM;
    let version = format!("Version {version}");
    for (key, text) in [
        ("USER", ""),
        ("DATE", "01.january.1970"),
        ("TIME", "00:00:00"),
        ("HOST", ""),
        ("PGM", program),
        ("VERSION", &version),
        ("DIR", ""),
        ("DBN", ""),
    ] {
        writeln!(out, "    1U{key:<18}{text:<48}")?;
    }
    for (index, name) in mesh.materials.iter().enumerate() {
        writeln!(out, "    1UMAT{:5}{name:<58}", index + 1)?;
    }
    Ok(())
}

fn write_nodes(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    writeln!(out, "    2C{:30}{:38}", mesh.nodes.len(), 1)?;
    write_rows(out, mesh, |index| mesh.nodes[index].1)
}

fn write_elements(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    writeln!(out, "    3C{:30}{:38}", mesh.elements.len(), 1)?;
    for element in &mesh.elements {
        let kind = element.kind as u8;
        writeln!(
            out,
            " -1{:10}{kind:5}{:5}{:5}",
            element.number, 0, element.material
        )?;
        for part in frd_nodes(element).chunks(10) {
            write!(out, " -2")?;
            for node in part {
                write!(out, "{node:10}")?;
            }
            writeln!(out)?;
        }
    }
    writeln!(out, " -3")
}

/// The nodes of an element in the order of the `.frd`: where the deck has the middle nodes of
/// the top before those of the vertical edges, the `.frd` has them after.
fn frd_nodes(element: &Element) -> Vec<u64> {
    let mut nodes = element.nodes.clone();
    match element.kind {
        Kind::Hex20 => nodes[12..].rotate_left(4),
        Kind::Prism15 => nodes[9..].rotate_left(3),
        _ => {}
    }
    nodes
}

/// The records `1PSTEP` and `100CL`: `block` counts the blocks, `point` the points of time.
fn write_block_head(
    out: &mut impl Write,
    block: usize,
    point: usize,
    step: &Step,
    nodes: usize,
) -> io::Result<()> {
    let [number, increment] = step.number;
    writeln!(
        out,
        "    1PSTEP{:14}{block:12}{increment:12}{number:12}{:10}",
        "", ""
    )?;
    let time = frd_time(step.time);
    let analysis = 0; // static
    writeln!(
        out,
        "  100CL{:5}{time}{nodes:12}{analysis:22}{point:5}{:12}",
        100 + point,
        1
    )
}

/// A time in twelve columns: ten digits where they fit without an exponent.
fn frd_time(time: f64) -> String {
    let places = time.log10().floor();
    if (0.0..10.0).contains(&places) {
        return format!("{time:12.*}", 9 - places as usize);
    }
    let mut text = Vec::with_capacity(12);
    scientific(&mut text, single(time), 12, 5);
    text.into_iter().map(char::from).collect()
}

/// The records `-4` and `-5`: names of the quantity and of its components.
///
/// Three components and `ALL`, their length, make a vector; six make a tensor. ccx declares
/// the six values of contact as a tensor too.
fn write_components(out: &mut impl Write, quantity: FrdQuantity) -> io::Result<()> {
    let (name, components) = match quantity {
        FrdQuantity::Displacement => ("DISP", "D1 D2 D3 ALL"),
        FrdQuantity::Stress => ("STRESS", "SXX SYY SZZ SXY SYZ SZX"),
        FrdQuantity::Strain => ("TOSTRAIN", "EXX EYY EZZ EXY EYZ EZX"),
        FrdQuantity::Reaction => ("FORC", "F1 F2 F3 ALL"),
        FrdQuantity::Contact => ("CONTACT", "COPEN CSLIP1 CSLIP2 CPRESS CSHEAR1 CSHEAR2"),
    };
    let components: Vec<&str> = components.split(' ').collect();
    writeln!(out, " -4  {name:<12}{}    1", components.len())?;
    let vector = [
        "1    2    1    0",
        "1    2    2    0",
        "1    2    3    0",
        "1    2    0    0    1ALL",
    ];
    let tensor = [(1, 1), (2, 2), (3, 3), (1, 2), (2, 3), (3, 1)];
    for (index, component) in components.iter().enumerate() {
        write!(out, " -5  {component:<12}")?;
        if components.len() == vector.len() {
            writeln!(out, "{}", vector[index])?;
        } else {
            writeln!(out, "1    4{:5}{:5}", tensor[index].0, tensor[index].1)?;
        }
    }
    Ok(())
}

fn write_values(
    out: &mut impl Write,
    mesh: &Mesh,
    step: &Step,
    quantity: FrdQuantity,
) -> io::Result<()> {
    match quantity {
        FrdQuantity::Displacement => write_rows(out, mesh, |index| step.displacement[index]),
        FrdQuantity::Stress => write_rows(out, mesh, |index| frd_tensor(step.stress[index])),
        FrdQuantity::Strain => write_rows(out, mesh, |index| frd_tensor(step.strain[index])),
        FrdQuantity::Reaction => write_rows(out, mesh, |index| step.reaction[index]),
        FrdQuantity::Contact => {
            let contact: HashMap<u64, [f64; 6]> = step
                .contact
                .iter()
                .map(|node| (node.node, frd_contact(node)))
                .collect();
            // a node off the slave surfaces has no contact: zeros, as ccx writes face to face
            write_rows(out, mesh, |index| {
                contact
                    .get(&mesh.nodes[index].0)
                    .copied()
                    .unwrap_or_default()
            })
        }
    }
}

/// Components `[xx, yy, zz, xy, yz, zx]` of a tensor `[xx, yy, zz, xy, xz, yz]`.
fn frd_tensor([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> [f64; 6] {
    [xx, yy, zz, xy, yz, xz]
}

/// Gap, slip, pressure and shear as one row.
fn frd_contact(node: &ContactNode) -> [f64; 6] {
    let [slip, shear] = [node.slip, node.shear];
    [
        node.gap,
        slip[0],
        slip[1],
        node.pressure,
        shear[0],
        shear[1],
    ]
}

/// One record `-1` for each node, and the `-3` that ends the block.
fn write_rows<const N: usize>(
    out: &mut impl Write,
    mesh: &Mesh,
    values: impl Fn(usize) -> [f64; N],
) -> io::Result<()> {
    let mut line = Vec::new();
    for (index, (number, _)) in mesh.nodes.iter().enumerate() {
        line.clear();
        write!(line, " -1{number:10}")?;
        for value in values(index) {
            scientific(&mut line, single(value), 12, 5);
        }
        line.push(b'\n');
        out.write_all(&line)?;
    }
    writeln!(out, " -3")
}

/// `value` in single precision, as ccx writes it.
///
/// Readers refuse the whole file for one NaN or infinity. So what is not finite is written as 0,
/// and what single precision can't hold as its largest number.
fn single(value: f64) -> f64 {
    let largest = f64::from(f32::MAX);
    if value.is_finite() {
        f64::from(value.clamp(-largest, largest) as f32)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // what ccx 2.20 wrote for the decks of the same names in the folder `golden`
    const BLOCKS: &str = include_str!("../golden/blocks.frd");
    const PLANE: &str = include_str!("../golden/plane.frd");
    const SOLIDS: &str = include_str!("../golden/solids.frd");
    const CONTACT: &str = include_str!("../golden/contact.frd");

    /// The first field of a record and its columns of twelve characters.
    fn columns(line: &str) -> (u64, Vec<f64>) {
        let values = line.as_bytes()[13..].chunks(12);
        let values = values.map(|each| str::from_utf8(each).unwrap().trim().parse().unwrap());
        (line[3..13].trim().parse().unwrap(), values.collect())
    }

    /// Nodes of a file and its steps, read by columns; a step ends where the time changes.
    fn read(text: &str) -> (Mesh, Vec<(Step, Vec<FrdQuantity>)>) {
        let mut mesh = Mesh::default();
        let mut steps: Vec<(Step, Vec<FrdQuantity>)> = Vec::new();
        let mut block = String::new();
        for line in text.lines() {
            match (&line[..line.len().min(5)], block.as_str()) {
                ("    1", _) if line.starts_with("    1UMAT") => {
                    mesh.materials.push(line[14..].trim().to_owned());
                }
                ("    2" | "    3", _) => block = line[4..6].to_owned(),
                ("  100", _) => {
                    let time = line[12..24].trim().parse().unwrap();
                    if steps.last().is_none_or(|(step, _)| step.time != time) {
                        let step = Step {
                            number: [steps.len() + 1, 1],
                            time,
                            ..Step::default()
                        };
                        steps.push((step, Vec::new()));
                    }
                }
                (" -4  ", _) => {
                    block = line[5..17].trim().to_owned();
                    steps.last_mut().unwrap().1.push(quantity(&block));
                }
                (head, "2C") if head.starts_with(" -1") => {
                    let (number, at) = columns(line);
                    mesh.nodes.push((number, at.try_into().unwrap()));
                }
                (head, name) if head.starts_with(" -1") && name != "3C" => {
                    read_row(&mut steps.last_mut().unwrap().0, name, line);
                }
                _ => {}
            }
        }
        (mesh, steps)
    }

    fn quantity(block: &str) -> FrdQuantity {
        let index = ["DISP", "STRESS", "TOSTRAIN", "FORC", "CONTACT"]
            .iter()
            .position(|name| *name == block);
        ORDER[index.unwrap()]
    }

    fn read_row(step: &mut Step, block: &str, line: &str) {
        let (node, v) = columns(line);
        match quantity(block) {
            FrdQuantity::Displacement => step.displacement.push([v[0], v[1], v[2]]),
            FrdQuantity::Reaction => step.reaction.push([v[0], v[1], v[2]]),
            FrdQuantity::Stress => step.stress.push([v[0], v[1], v[2], v[3], v[5], v[4]]),
            FrdQuantity::Strain => step.strain.push([v[0], v[1], v[2], v[3], v[5], v[4]]),
            FrdQuantity::Contact if v.iter().all(|value| *value == 0.0) => {}
            FrdQuantity::Contact => step.contact.push(ContactNode {
                node,
                gap: v[0],
                slip: [v[1], v[2]],
                pressure: v[3],
                shear: [v[4], v[5]],
            }),
        }
    }

    /// The file that the answers of `golden` make with the elements of its deck.
    fn rewritten(golden: &str, elements: &[(u64, Kind, u32, &[u64])]) -> String {
        let (mut mesh, steps) = read(golden);
        mesh.elements = elements
            .iter()
            .map(|&(number, kind, material, nodes)| Element {
                number,
                kind,
                nodes: nodes.to_vec(),
                material,
            })
            .collect();
        written("", &mesh, &steps)
    }

    fn written(job: &str, mesh: &Mesh, steps: &[(Step, Vec<FrdQuantity>)]) -> String {
        let mut out = Vec::new();
        write(&mut out, job, mesh, steps).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// The part of a file from its materials on; before it stand date and version.
    fn body(text: &str) -> &str {
        &text[text.find("    1UMAT").unwrap()..]
    }

    const BRICK: [u64; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

    #[test]
    fn two_bricks_are_the_file_of_ccx() {
        let upper = [5, 6, 7, 8, 9, 10, 11, 12];
        let elements: [(u64, Kind, u32, &[u64]); 2] =
            [(1, Kind::Hex8, 1, &BRICK), (2, Kind::Hex8, 1, &upper)];
        assert_eq!(body(&rewritten(BLOCKS, &elements)), body(BLOCKS));
    }

    #[test]
    fn elements_of_the_plane_are_the_file_of_ccx() {
        let elements: [(u64, Kind, u32, &[u64]); 4] = [
            (1, Kind::Quad8, 1, &BRICK),
            (2, Kind::Tri6, 1, &[2, 9, 3, 11, 12, 6]),
            (3, Kind::Tri3, 1, &[9, 10, 3]),
            (4, Kind::Quad4, 1, &[9, 15, 16, 10]),
        ];
        assert_eq!(body(&rewritten(PLANE, &elements)), body(PLANE));
    }

    #[test]
    fn solid_elements_are_the_file_of_ccx() {
        let hex20: Vec<u64> = (1..=20).collect();
        let prism15 = [2, 21, 3, 6, 22, 7, 23, 25, 10, 24, 26, 14, 18, 27, 19];
        let elements: [(u64, Kind, u32, &[u64]); 6] = [
            (1, Kind::Hex20, 2, &hex20),
            (2, Kind::Prism15, 2, &prism15),
            (3, Kind::Prism6, 2, &[21, 31, 3, 22, 32, 7]),
            (4, Kind::Tet10, 2, &[31, 33, 35, 34, 37, 43, 42, 41, 38, 46]),
            (5, Kind::Tet4, 2, &[31, 33, 35, 36]),
            (6, Kind::Hex8, 2, &BRICK),
        ];
        assert_eq!(body(&rewritten(SOLIDS, &elements)), body(SOLIDS));
    }

    #[test]
    fn contact_is_the_file_of_ccx() {
        let upper = [11, 12, 13, 14, 15, 16, 17, 18];
        let elements: [(u64, Kind, u32, &[u64]); 2] =
            [(1, Kind::Hex8, 1, &BRICK), (2, Kind::Hex8, 1, &upper)];
        assert_eq!(body(&rewritten(CONTACT, &elements)), body(CONTACT));
    }

    /// The keys, the columns of program and version, and the length of the lines.
    #[test]
    fn header_is_that_of_ccx() {
        let (mesh, _) = read(BLOCKS);
        let text = written("", &mesh, &[]);
        for line in BLOCKS.lines().take_while(|line| !line.contains("2C")) {
            let blank = ["    1C", "USER", "HOST", "DIR", "DBN"]
                .iter()
                .any(|key| line.contains(key));
            assert!(!blank || text.contains(&format!("{line}\n")), "{line}");
        }
        let program = text.find(PROGRAM[0]).unwrap() - text.find("    1UPGM").unwrap();
        assert_eq!(
            program,
            BLOCKS.find("CalculiX").unwrap() - BLOCKS.find("    1UPGM").unwrap()
        );
    }

    #[test]
    fn nothing_but_finite_numbers_is_written() {
        let mesh = Mesh {
            nodes: vec![(7, [f64::NAN, 1e300, -1e300])],
            ..Mesh::default()
        };
        let displacement = vec![[f64::INFINITY, f64::NEG_INFINITY, 1e-300]];
        let step = Step {
            number: [1, 1],
            time: 1.0,
            displacement,
            ..Step::default()
        };
        let text = written("job", &mesh, &[(step, vec![FrdQuantity::Displacement])]);
        assert!(text.starts_with("    1Cjob\n"));
        assert!(text.contains(" -1         7 0.00000E+00 3.40282E+38-3.40282E+38\n"));
        assert!(text.contains(" -1         7 0.00000E+00 0.00000E+00 0.00000E+00\n"));
    }

    #[test]
    fn times_have_ten_digits_where_they_fit() {
        assert_eq!(frd_time(0.0), " 0.00000E+00");
        assert_eq!(frd_time(0.5), " 5.00000E-01");
        assert_eq!(frd_time(1.0), " 1.000000000");
        assert_eq!(frd_time(12.5), " 12.50000000");
        assert_eq!(frd_time(1e9), "  1000000000");
        assert_eq!(frd_time(1e10), " 1.00000E+10");
        assert_eq!(frd_time(f64::NAN), " 0.00000E+00");
    }
}
