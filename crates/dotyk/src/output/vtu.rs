//! `BODY.vtu` and `case.pvd` for ParaView: undeformed points, cell kinds kept, point data at the nodes.
//!
//! Stress components are in the order xx yy zz xy yz xz. `pressure` and `gap` are NaN off the contact: they are defined
//! at the nodes of a nonmortar side and, where the contact pairs nodes, at their partners. With friction or a tie there are
//! `shear` (the traction on this body) and `contact_state`: 0 open, 1 closed, 2 stick, 3 slip, 4 tied, 5 fixed.
//! Arrays are inline, little-endian, zlib in blocks, base64.
//! Source: VTK file formats, section "XML file formats" (vtk.org).

use crate::geometry::padded;
use crate::model::{Law, Model, Solution, Status};
use crate::output::encode::zlib;
use crate::output::html::escape;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// Uncompressed bytes per block.
const BLOCK: usize = 1 << 20;

/// Content of the VTU file of one body.
///
/// `body` is an index into both `model.bodies` and `solution.bodies`.
pub fn body_vtu<const D: usize>(model: &Model<D>, solution: &Solution<D>, body: usize) -> String {
    let mesh = &model.bodies[body].mesh;
    let answer = &solution.bodies[body];
    let points: Vec<f64> = mesh.points().iter().flat_map(|&p| padded(p)).collect();
    let displacement: Vec<f64> = answer
        .displacement
        .iter()
        .flat_map(|&u| padded(u))
        .collect();
    let fields = contact_fields(solution, body, mesh.points().len());
    let (mut connectivity, mut offsets, mut types) = (Vec::new(), Vec::new(), Vec::new());
    for block in mesh.blocks() {
        for cell in block.cells() {
            connectivity.extend(cell.iter().map(|&n| i64::from(n)));
            offsets.push(connectivity.len() as i64);
            types.push(block.kind.vtk());
        }
    }

    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n",
    );
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        mesh.points().len(),
        types.len()
    );
    out.push_str("<PointData Vectors=\"displacement\" Scalars=\"von_mises\">\n");
    floats(&mut out, "displacement", 3, &displacement);
    floats(&mut out, "stress", 6, answer.stress.as_flattened());
    floats(&mut out, "von_mises", 1, &answer.von_mises);
    floats(&mut out, "pressure", 1, &fields.pressure);
    floats(&mut out, "gap", 1, &fields.gap);
    let laws = model.contacts.iter().map(|contact| &contact.law);
    if laws
        .into_iter()
        .any(|law| !matches!(law, Law::Frictionless))
    {
        floats(&mut out, "shear", 3, fields.shear.as_flattened());
        floats(&mut out, "contact_state", 1, &fields.state);
    }
    out.push_str("</PointData>\n<Points>\n");
    floats(&mut out, "points", 3, &points);
    out.push_str("</Points>\n<Cells>\n");
    integers(&mut out, "connectivity", &connectivity);
    integers(&mut out, "offsets", &offsets);
    array(&mut out, "UInt8", "types", 1, &types);
    out.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    out
}

/// Name of the VTU file of a body in a step, counted from 0, of several or of the only one.
pub fn file_name(body: &str, step: usize, several: bool) -> String {
    match several {
        true => format!("{body}_{:04}.vtu", step + 1),
        false => format!("{body}.vtu"),
    }
}

/// Content of `case.pvd`: all bodies at all times; `several`: the model has several load steps.
pub fn collection<const D: usize>(steps: &[Solution<D>], several: bool) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (step, solution) in steps.iter().enumerate() {
        for (part, body) in solution.bodies.iter().enumerate() {
            let _ = writeln!(
                out,
                "<DataSet timestep=\"{:?}\" part=\"{part}\" name=\"{}\" {FILE}{}\"/>",
                solution.time,
                escape(&body.name),
                escape(&file_name(&body.name, step, several))
            );
        }
    }
    out.push_str("</Collection>\n</VTKFile>\n");
    out
}

/// How a collection names a file.
const FILE: &str = "file=\"";

/// VTU files that a collection of an earlier run names: they are ours. Other folders are not.
pub fn collected(pvd: &str) -> Vec<String> {
    let files = pvd
        .split(FILE)
        .skip(1)
        .filter_map(|rest| rest.split('"').next());
    let ours = |name: &&str| name.ends_with(".vtu") && !name.contains(['/', '\\']);
    files.filter(ours).map(str::to_string).collect()
}

/// Contact at the nodes of a body; NaN off the contact.
struct ContactFields {
    pressure: Vec<f64>,
    gap: Vec<f64>,
    shear: Vec<[f64; 3]>,
    state: Vec<f64>,
}

/// The number of a state.
fn state_number(status: Status) -> f64 {
    match status {
        Status::Open => 0.0,
        Status::Closed => 1.0,
        Status::Stick => 2.0,
        Status::Slip => 3.0,
        Status::Tied => 4.0,
        Status::Fixed => 5.0,
    }
}

/// What the contacts do at the nodes of a body; a node of several contacts keeps the first that defines a number.
fn contact_fields<const D: usize>(
    solution: &Solution<D>,
    body: usize,
    nodes: usize,
) -> ContactFields {
    let mut fields = ContactFields {
        pressure: vec![f64::NAN; nodes],
        gap: vec![f64::NAN; nodes],
        shear: vec![[f64::NAN; 3]; nodes],
        state: vec![f64::NAN; nodes],
    };
    // Own sides first: what is read off a partner must not hide what a body says itself.
    for own in [true, false] {
        for contact in &solution.contacts {
            let side = if own {
                Some(&contact.nonmortar)
            } else {
                contact.mortar.as_ref()
            };
            if side.is_none_or(|side| side.body.0 != body) {
                continue;
            }
            for node in &contact.nodes {
                let Some(at) = (if own { Some(node.node) } else { node.partner }) else {
                    continue;
                };
                if fields.state[at].is_nan() {
                    let sign = if own { 1.0 } else { -1.0 };
                    fields.shear[at] = padded(node.shear).map(|s| sign * s);
                    fields.state[at] = state_number(node.status);
                }
                let scalars = [
                    (&mut fields.pressure, node.pressure),
                    (&mut fields.gap, node.gap),
                ];
                for (field, value) in scalars {
                    if field[at].is_nan() {
                        field[at] = value;
                    }
                }
            }
        }
    }
    fields
}

fn floats(out: &mut String, name: &str, components: usize, values: &[f64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(out, "Float64", name, components, &bytes);
}

fn integers(out: &mut String, name: &str, values: &[i64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(out, "Int64", name, 1, &bytes);
}

/// One data array: a header of (blocks, block size, last block size, compressed sizes..), then the blocks.
fn array(out: &mut String, kind: &str, name: &str, components: usize, bytes: &[u8]) {
    let blocks: Vec<Vec<u8>> = bytes.chunks(BLOCK).map(zlib).collect();
    let mut header = vec![
        blocks.len() as u64,
        BLOCK as u64,
        // Zero says that the last block is full.
        (bytes.len() % BLOCK) as u64,
    ];
    header.extend(blocks.iter().map(|b| b.len() as u64));
    let header: Vec<u8> = header.iter().flat_map(|v| v.to_le_bytes()).collect();
    // Readers take a single component for a column of a matrix when it is spelled out.
    let components = match components {
        1 => String::new(),
        several => format!(" NumberOfComponents=\"{several}\""),
    };
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"binary\">\n{}{}\n</DataArray>",
        STANDARD.encode(&header),
        STANDARD.encode(blocks.concat())
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;
    use crate::model::Status;
    use crate::output::tunnel;
    use std::io::Read;

    fn unbase64(text: &str) -> Vec<u8> {
        STANDARD.decode(text).unwrap()
    }

    /// The numbers of an array, read back by the rules of the format.
    fn read(vtu: &str, name: &str) -> Vec<f64> {
        let tag = format!("Name=\"{name}\"");
        let text = vtu.split(&tag).nth(1).unwrap();
        let line = text.lines().nth(1).unwrap();
        let word = |b: &[u8], i: usize| {
            u64::from_le_bytes(b[8 * i..8 * i + 8].try_into().unwrap()) as usize
        };
        let blocks = word(&unbase64(&line[..32]), 0);
        let length = (8 * (3 + blocks)).div_ceil(3) * 4;
        let (header, data) = (unbase64(&line[..length]), unbase64(&line[length..]));
        let (mut bytes, mut start) = (Vec::new(), 0);
        for b in 0..blocks {
            let end = start + word(&header, 3 + b);
            flate2::read::ZlibDecoder::new(&data[start..end])
                .read_to_end(&mut bytes)
                .unwrap();
            start = end;
        }
        assert_eq!(start, data.len());
        assert_eq!(bytes.len() % BLOCK, word(&header, 2));
        bytes
            .chunks(8)
            .map(|c| f64::from_le_bytes(c.try_into().unwrap()))
            .collect()
    }

    #[test]
    fn arrays_read_back_with_their_counts() {
        let (model, solution) = tunnel::solved();
        let ring = body_vtu(&model, &solution, 0);
        let nodes = model.bodies[0].mesh.points().len();
        assert!(ring.contains(&format!("NumberOfPoints=\"{nodes}\"")));
        let displacement = read(&ring, "displacement");
        assert_eq!(displacement.len(), 3 * nodes);
        assert_eq!(displacement[3..5], solution.bodies[0].displacement[1]);
        assert_eq!(displacement[5], 0.0);
        assert_eq!(
            read(&ring, "stress"),
            solution.bodies[0].stress.as_flattened()
        );
        assert_eq!(read(&ring, "von_mises").len(), nodes);
        assert_eq!(read(&ring, "points").len(), 3 * nodes);
    }

    #[test]
    fn a_collection_names_every_body_at_every_time() {
        let (_, solution) = tunnel::solved();
        let one = collection(std::slice::from_ref(&solution), false);
        assert_eq!(collected(&one), ["ring.vtu", "rock.vtu"]);
        let mut first = solution.clone();
        first.time = 0.25;
        let text = collection(&[first, solution], true);
        let names = [
            "ring_0001.vtu",
            "rock_0001.vtu",
            "ring_0002.vtu",
            "rock_0002.vtu",
        ];
        assert_eq!(collected(&text), names);
        assert!(text.contains("timestep=\"0.25\" part=\"1\" name=\"rock\" file=\"rock_0001.vtu\""));
        let foreign = "<DataSet file=\"../mine.vtu\"/><DataSet file=\"notes.txt\"/>";
        assert!(collected(foreign).is_empty());
    }

    #[test]
    fn long_arrays_are_cut_into_blocks() {
        let values: Vec<f64> = (0..BLOCK / 8 * 2 + 5).map(|i| i as f64).collect();
        let mut out = String::new();
        floats(&mut out, "long", 1, &values);
        assert_eq!(read(&out, "long"), values);
    }

    #[test]
    fn pressure_is_nan_off_the_contact_and_reaches_the_partner() {
        let (model, solution) = tunnel::solved();
        let contact = &solution.contacts[0];
        for body in 0..2 {
            let pressure = read(&body_vtu(&model, &solution, body), "pressure");
            let defined = pressure.iter().filter(|p| !p.is_nan()).count();
            assert_eq!(defined, contact.nodes.len());
            for node in &contact.nodes {
                let at = if body == contact.nonmortar.body.0 {
                    node.node
                } else {
                    node.partner.unwrap()
                };
                assert_eq!(pressure[at], node.pressure);
            }
        }
        assert!(contact.nodes.iter().any(|n| n.status == Status::Open));
    }

    #[test]
    fn quadratic_cells_stay_quadratic() {
        let model = tunnel::model(8, [2, 4], CellKind::Quad8);
        let solution = model.solve().unwrap();
        let vtu = body_vtu(&model, &solution, 0);
        let cells: usize = model.bodies[0]
            .mesh
            .blocks()
            .iter()
            .map(|b| b.cells().len())
            .sum();
        let text = vtu.split("Name=\"types\"").nth(1).unwrap();
        let line = text.lines().nth(1).unwrap();
        let mut types = Vec::new();
        flate2::read::ZlibDecoder::new(&unbase64(&line[44..])[..])
            .read_to_end(&mut types)
            .unwrap();
        assert_eq!(types, vec![23; cells]);
    }
}
