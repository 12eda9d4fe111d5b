//! `BODY.vtu` and `case.pvd` for ParaView: undeformed points, cell kinds kept, point data at the nodes.
//!
//! Stress and strain components are in the order xx yy zz xy yz xz (strain: tensor components), with axial symmetry
//! radial, axial and hoop. `principal_stress` is largest first. `reaction` and `contact_force` are nodal forces of supports and of
//! all contacts and couples on the body: with loads they balance the internal forces at every node. `pressure`, `gap`,
//! `contact_normal` and `contact_state` are defined at the nodes of a nonmortar side and, where the contact pairs nodes, at their
//! partners (whose normal is the opposite one); elsewhere they are NaN, and the state is −1: 0 open, 1 closed, 2 stick, 3 slip,
//! 4 tied, 5 fixed. In space, where corners of facets carry the multipliers, nodes between them have linearly interpolated values
//! and the state of the corner with the largest force. With friction or a tie there is `shear`, the traction on this body.
//! `utilisation` is present if a body of the model has a strength: 1 is failure, infinite beyond the apex of a criterion, NaN for
//! a body or group without a strength. `plastic_strain`, `equivalent_plastic_strain` and `yielded`, the share of the cells around
//! that has yielded in this step, are present if a material of the model yields. Cells have the index of their body, and `yielded`,
//! the share of their own points, if a material of the model yields; field data are the time and the units. A node on a border between materials is a point for each of them, with its own stress and strain: the
//! cells of the further materials refer to points after the nodes. All other fields are the same at both.
//! Arrays are inline, little-endian, zlib in blocks, base64.
//! Source: VTK file formats, section "XML file formats" (vtk.org).

use crate::geometry::{Point, padded, unit};
use crate::host::processes;
use crate::mesh::{Count, Mesh};
use crate::model::{
    Analysis, BodyField, BodySolution, Law, Model, On, OnSide, Shape, Solution, Status,
};
use crate::output::encode::zlib_fast;
use crate::output::markup::{Markup, markup};
use crate::output::text::{AXES, Labels};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Uncompressed bytes per block.
const BLOCK: usize = 1 << 20;

/// Some of the cells of a body, and their points.
pub struct Part {
    /// Whether it has each cell, block after block.
    cells: Vec<bool>,
}

/// A body in so many parts, which border each other and are about as large; parts of small bodies may be empty.
pub fn parts<const D: usize>(mesh: &Mesh<D>, count: usize) -> Vec<Part> {
    let of_cell = mesh.pieces(Count::Exactly(count));
    let pieces = of_cell.iter().max().map_or(1, |last| *last as usize + 1);
    // what is not connected comes in more pieces
    let part_of = |piece: u32| piece as usize * count / pieces.max(count);
    let part = |own: usize| Part {
        cells: of_cell.iter().map(|&piece| part_of(piece) == own).collect(),
    };
    (0..count).map(part).collect()
}

/// The rows, of so many numbers each, that are picked; all of them without a choice.
fn picked<'v>(values: &'v [f64], size: usize, picks: Option<&[usize]>) -> Cow<'v, [f64]> {
    let Some(picks) = picks else {
        return Cow::Borrowed(values);
    };
    let rows = picks.iter().map(|&row| &values[size * row..][..size]);
    Cow::Owned(rows.flatten().copied().collect())
}

/// The fields of a body that its files have.
pub struct Fields {
    results: Vec<BodyField>,
    contact: ContactFields,
}

impl Fields {
    /// `body` is an index into both `model.bodies` and `solution.bodies`.
    pub fn of<const D: usize>(model: &Model<D>, solution: &Solution<D>, body: usize) -> Self {
        let mesh = &model.bodies[body].mesh;
        Self {
            results: body_fields(solution, body, mesh.cell_count()),
            contact: contact_fields(solution, body, mesh),
        }
    }
}

/// Content of the VTU file of one body.
///
/// `body` is an index into both `model.bodies` and `solution.bodies`.
pub fn body_vtu<const D: usize>(model: &Model<D>, solution: &Solution<D>, body: usize) -> String {
    let fields = Fields::of(model, solution, body);
    part_vtu(model, solution, (body, &fields), None)
}

/// The same of a part of it.
pub fn part_vtu<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    (
        body,
        Fields {
            results,
            contact: fields,
        },
    ): (usize, &Fields),
    part: Option<&Part>,
) -> String {
    let mesh = &model.bodies[body].mesh;
    let answer = &solution.bodies[body];
    let borders = &answer.borders;
    // what does not jump between materials
    let vectors = |values: &[Point<D>]| -> Vec<f64> {
        borders
            .nodes()
            .flat_map(|node| padded(values[node]))
            .collect()
    };
    let numbers = |values: &[f64]| -> Vec<f64> { borders.nodes().map(|n| values[n]).collect() };
    let triples =
        |values: &[[f64; 3]]| -> Vec<f64> { borders.nodes().flat_map(|n| values[n]).collect() };
    let (mut connectivity, mut offsets, mut types) = (Vec::new(), Vec::new(), Vec::new());
    let blocks = mesh.blocks().iter().enumerate();
    let cells =
        blocks.flat_map(|(index, block)| block.cells().map(move |cell| (index, block.kind, cell)));
    let mut own_cells = Vec::new();
    for (number, (index, kind, cell)) in cells.enumerate() {
        if part.is_some_and(|part| !part.cells[number]) {
            continue;
        }
        let places = cell.iter().map(|&n| borders.place(index, n as usize));
        connectivity.extend(places.map(|place| place as i64));
        offsets.push(connectivity.len() as i64);
        types.push(kind.vtk());
        own_cells.push(number);
    }
    let own_points = part.map(|_| {
        let own: BTreeSet<i64> = connectivity.iter().copied().collect();
        let own: Vec<i64> = own.into_iter().collect();
        for point in &mut connectivity {
            *point = own.partition_point(|other| other < point) as i64;
        }
        own.into_iter()
            .map(|point| point as usize)
            .collect::<Vec<_>>()
    });
    let own_cells = part.map(|_| &own_cells[..]);
    let own_points = own_points.as_deref();

    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n",
    );
    field_data(&mut out, model, solution.time);
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        own_points.map_or(borders.count(), <[_]>::len),
        types.len()
    );
    out.push_str("<PointData Vectors=\"displacement\" Scalars=\"von_mises\">\n");
    let (tensor, vector) = component_names(model.analysis);
    let put = |out: &mut String, on: On| {
        for field in results.iter().filter(|field| field.on == on) {
            let components: &[&str] = match field.shape {
                Shape::Number => &[],
                Shape::Vector => &vector,
                Shape::Tensor => &tensor,
                Shape::Principal => &["s1", "s2", "s3"],
            };
            let picks = match on {
                On::Nodes => own_points,
                On::Cells => own_cells,
            };
            let values = picked(&field.values, field.shape.components(), picks);
            floats(out, field.name, components, &values);
        }
    };
    put(&mut out, On::Nodes);
    let at_points = |out: &mut String, name: &str, components: &[&str], values: Vec<f64>| {
        let values = picked(&values, components.len().max(1), own_points);
        floats(out, name, components, &values);
    };
    at_points(&mut out, "pressure", &[], numbers(&fields.pressure));
    at_points(&mut out, "gap", &[], numbers(&fields.gap));
    let normals = triples(&fields.normal);
    at_points(&mut out, "contact_normal", &vector, normals);
    let laws = model.contacts.iter().map(|contact| &contact.law);
    if laws
        .into_iter()
        .any(|law| !matches!(law, Law::Frictionless))
    {
        at_points(&mut out, "shear", &vector, triples(&fields.shear));
    }
    let states: Vec<i32> = borders.nodes().map(|node| fields.state[node]).collect();
    let states: Vec<i32> = match own_points {
        Some(own) => own.iter().map(|&point| states[point]).collect(),
        None => states,
    };
    let states: Vec<u8> = states.into_iter().flat_map(i32::to_le_bytes).collect();
    array(&mut out, "Int32", "contact_state", &[], &states);
    out.push_str("</PointData>\n<Points>\n");
    at_points(&mut out, "points", &AXES, vectors(mesh.points()));
    out.push_str("</Points>\n<Cells>\n");
    integers(&mut out, "connectivity", &connectivity);
    integers(&mut out, "offsets", &offsets);
    array(&mut out, "UInt8", "types", &[], &types);
    out.push_str("</Cells>\n<CellData>\n");
    let index: Vec<u8> = types
        .iter()
        .flat_map(|_| (body as i32).to_le_bytes())
        .collect();
    array(&mut out, "Int32", "body", &[], &index);
    put(&mut out, On::Cells);
    out.push_str("</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    out
}

/// The fields of a body; fields that only other bodies have are NaN, so that readers of several bodies find the same arrays in all.
fn body_fields<const D: usize>(
    solution: &Solution<D>,
    body: usize,
    cells: usize,
) -> Vec<BodyField> {
    let bodies = &solution.bodies;
    let mut own = bodies[body].fields();
    let some: [fn(&BodySolution<D>) -> bool; 3] = [
        |b| b.utilisation.is_some(),
        |b| b.yielding.is_some(),
        |b| b.pore_pressure.is_some(),
    ];
    for has in some.into_iter().filter(|has| !has(&bodies[body])) {
        let Some(other) = bodies.iter().find(|other| has(other)) else {
            continue;
        };
        for (at, field) in other.fields().into_iter().enumerate() {
            let is = |known: &BodyField| (known.name, known.on) == (field.name, field.on);
            if !own.iter().any(is) {
                let count = match field.on {
                    On::Nodes => bodies[body].borders.count(),
                    On::Cells => cells,
                };
                let values = vec![f64::NAN; count * field.shape.components()];
                own.insert(at.min(own.len()), BodyField { values, ..field });
            }
        }
    }
    own
}

/// Some body has a strength.
pub fn judged<const D: usize>(solution: &Solution<D>) -> bool {
    solution
        .bodies
        .iter()
        .any(|body| body.utilisation.is_some())
}

/// Names of the components of tensors and vectors.
fn component_names(analysis: Analysis) -> ([&'static str; 6], [&'static str; 3]) {
    match analysis {
        Analysis::Axisymmetric => (
            ["rr", "axial", "hoop", "r_axial", "axial_hoop", "r_hoop"],
            ["r", "axial", "hoop"],
        ),
        _ => (["xx", "yy", "zz", "xy", "yz", "xz"], AXES),
    }
}

/// Time, and the units of length, force and stress where the model has them, as names of ones.
fn field_data<const D: usize>(out: &mut String, model: &Model<D>, time: f64) {
    let labels = Labels::of(model);
    out.push_str("<FieldData>\n");
    let _ = writeln!(
        out,
        "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:?}</DataArray>"
    );
    // units are names of numbers: readers such as meshio refuse files with texts
    for (name, unit) in [
        ("length", &labels.length),
        ("force", &labels.force),
        ("stress", &labels.stress),
    ] {
        if !unit.is_empty() {
            *out += &markup!(
                "<DataArray type=\"Float64\" Name=\"unit of {}: {}\" NumberOfTuples=\"1\" format=\"ascii\">1</DataArray>\n",
                name,
                unit
            );
        }
    }
    out.push_str("</FieldData>\n");
}

/// Content of the file that names the parts of a body, which are in these files: the arrays of its fields are those of one of them.
pub fn whole(part: &str, files: &[String]) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<PUnstructuredGrid GhostLevel=\"0\">\n",
    );
    let mut of_all = false;
    // the lines of data begin with another character
    for line in part.lines().filter(|line| line.starts_with('<')) {
        let begins = |tags: [&str; 3]| tags.iter().any(|tag| line.starts_with(tag));
        let ends = begins(["</PointData>", "</Points>", "</CellData>"]);
        of_all |= begins(["<PointData", "<Points>", "<CellData>"]);
        if of_all {
            let parallel = line
                .replacen("</", "</P", 1)
                .replacen("<", "<P", usize::from(!ends));
            match line.starts_with("<DataArray") {
                true => out += &parallel.replace(" format=\"binary\">", "/>"),
                false if line == "</DataArray>" => continue,
                false => out += &parallel,
            }
            out.push('\n');
        }
        of_all &= !ends;
    }
    for file in files {
        out += &markup!("<Piece {}{}\"/>\n", Markup::own(SOURCE), file);
    }
    out.push_str("</PUnstructuredGrid>\n</VTKFile>\n");
    out
}

/// How that file names a part.
const SOURCE: &str = "Source=\"";

/// The files of the parts that such a file names.
pub fn sources(whole: &str) -> Vec<String> {
    files_named(whole, SOURCE)
}

/// Name of the file of a part of a body, of that of the body.
pub fn part_name(file: &str, part: usize) -> String {
    let body = file.strip_suffix(".pvtu").unwrap_or(file);
    format!("{body}.p{part}.vtu")
}

/// End of the names of the files of bodies: in parts, or not.
fn ending() -> &'static str {
    match processes() {
        Some(_) => "pvtu",
        None => "vtu",
    }
}

/// Name of the VTU file of a body in a step, counted from 0, of several or of the only one.
pub fn file_name(body: &str, step: usize, several: bool) -> String {
    named(body, step, several, ending())
}

/// Name of the file that names the bodies of a step as blocks.
pub fn blocks_name(step: usize, several: bool) -> String {
    named("case", step, several, "vtm")
}

fn named(stem: &str, step: usize, several: bool, ending: &str) -> String {
    match several {
        true => format!("{stem}_{:04}.{ending}", step + 1),
        false => format!("{stem}.{ending}"),
    }
}

/// Content of that file: all bodies at one time.
pub fn blocks<const D: usize>(solution: &Solution<D>, step: usize, several: bool) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
         <vtkMultiBlockDataSet>\n",
    );
    for (index, body) in solution.bodies.iter().enumerate() {
        let file = file_name(&body.name, step, several);
        let Some(parts) = processes() else {
            out += &block(index, &body.name, &file);
            continue;
        };
        // not every reader of blocks reads files of parts
        out += &markup!("<Block index=\"{}\" name=\"{}\">\n", index, body.name);
        for part in 0..parts {
            let name = format!("{} {part}", body.name);
            out += &block(part, &name, &part_name(&file, part));
        }
        out.push_str("</Block>\n");
    }
    out.push_str("</vtkMultiBlockDataSet>\n</VTKFile>\n");
    out
}

fn block(index: usize, name: &str, file: &str) -> Markup {
    let before = Markup::own(FILE);
    markup!(
        "<DataSet index=\"{}\" name=\"{}\" {}{}\"/>\n",
        index,
        name,
        before,
        file
    )
}

/// Content of `case.pvd`: all bodies at all times; `several`: the model has several load steps.
pub fn collection<const D: usize>(steps: &[Solution<D>], several: bool) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (step, solution) in steps.iter().enumerate() {
        for (part, body) in solution.bodies.iter().enumerate() {
            out += &markup!(
                "<DataSet timestep=\"{}\" part=\"{}\" name=\"{}\" {}{}\"/>\n",
                format!("{:?}", solution.time),
                part,
                body.name,
                Markup::own(FILE),
                file_name(&body.name, step, several)
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
    files_named(pvd, FILE)
}

fn files_named(text: &str, before: &str) -> Vec<String> {
    let files = text.split(before).skip(1);
    let files = files.filter_map(|rest| rest.split('"').next());
    let ours = |name: &&str| {
        (name.ends_with(".vtu") || name.ends_with(".pvtu")) && !name.contains(['/', '\\'])
    };
    files.filter(ours).map(str::to_string).collect()
}

/// Files that name the blocks of the steps of which a collection names files.
pub fn collected_blocks(pvd: &str) -> Vec<String> {
    let step = |file: &String| {
        let (_, step) = file.rsplit_once('.')?.0.rsplit_once('_')?;
        let is_step = step.len() >= 4 && step.bytes().all(|b| b.is_ascii_digit());
        is_step.then(|| format!("case_{step}.vtm"))
    };
    let files = collected(pvd);
    let steps: BTreeSet<String> = files.iter().filter_map(step).collect();
    let one = (!files.is_empty()).then(|| "case.vtm".to_string());
    steps.into_iter().chain(one).collect()
}

/// Contact at the nodes of a body; NaN off the contact.
struct ContactFields {
    pressure: Vec<f64>,
    gap: Vec<f64>,
    shear: Vec<[f64; 3]>,
    /// Outward.
    normal: Vec<[f64; 3]>,
    state: Vec<i32>,
}

/// The same at one node.
struct NodeState {
    status: Option<Status>,
    normal: [f64; 3],
    shear: [f64; 3],
    pressure: f64,
    gap: f64,
}

impl ContactFields {
    /// Fills in values of a node that are not known yet.
    fn take(&mut self, at: usize, state: NodeState) {
        if self.state[at] == NO_STATE {
            self.normal[at] = state.normal;
            self.shear[at] = state.shear;
            self.state[at] = state.status.map_or(NO_STATE, state_number);
        }
        for (known, value) in [
            (&mut self.pressure[at], state.pressure),
            (&mut self.gap[at], state.gap),
        ] {
            if known.is_nan() {
                *known = value;
            }
        }
    }
}

/// The state of a node without contact.
const NO_STATE: i32 = -1;

/// The number of a state.
fn state_number(status: Status) -> i32 {
    match status {
        Status::Open => 0,
        Status::Closed => 1,
        Status::Stick => 2,
        Status::Slip => 3,
        Status::Tied => 4,
        Status::Fixed => 5,
    }
}

/// Fields of the contacts at the nodes of a body; a node of several contacts keeps the first that defines a number.
fn contact_fields<const D: usize>(
    solution: &Solution<D>,
    body: usize,
    mesh: &Mesh<D>,
) -> ContactFields {
    let nodes = mesh.points().len();
    let mut fields = ContactFields {
        pressure: vec![f64::NAN; nodes],
        gap: vec![f64::NAN; nodes],
        shear: vec![[f64::NAN; 3]; nodes],
        normal: vec![[f64::NAN; 3]; nodes],
        state: vec![NO_STATE; nodes],
    };
    // Own sides first: values read off a partner must not hide those of the body itself.
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
                let sign = if own { 1.0 } else { -1.0 };
                fields.take(
                    at,
                    NodeState {
                        status: Some(node.status),
                        normal: padded(node.normal).map(|n| sign * n),
                        shear: padded(node.shear).map(|s| sign * s),
                        pressure: node.pressure,
                        gap: node.gap,
                    },
                );
            }
            if own {
                for place in OnSide::new(mesh, contact).between() {
                    let normal = unit(place.mean_vector(|node| node.normal)).unwrap_or([0.0; D]);
                    fields.take(
                        place.node,
                        NodeState {
                            status: place.status(),
                            normal: padded(normal),
                            shear: padded(place.mean_vector(|node| node.shear)),
                            pressure: place.mean(|node| node.pressure),
                            gap: place.mean(|node| node.gap),
                        },
                    );
                }
            }
        }
    }
    fields
}

fn floats(out: &mut String, name: &str, components: &[&str], values: &[f64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(out, "Float64", name, components, &bytes);
}

fn integers(out: &mut String, name: &str, values: &[i64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(out, "Int64", name, &[], &bytes);
}

/// One data array, of vectors where its components have names: a header of (blocks, block size, last block size, compressed sizes..), then the blocks.
fn array(out: &mut String, kind: &str, name: &str, components: &[&str], bytes: &[u8]) {
    let blocks: Vec<Vec<u8>> = bytes.par_chunks(BLOCK).map(zlib_fast).collect();
    let mut header = vec![
        blocks.len() as u64,
        BLOCK as u64,
        // Zero says that the last block is full.
        (bytes.len() % BLOCK) as u64,
    ];
    header.extend(blocks.iter().map(|b| b.len() as u64));
    let header: Vec<u8> = header.iter().flat_map(|v| v.to_le_bytes()).collect();
    // Readers take a single component for a column of a matrix when it is spelled out.
    let mut named = match components.len() {
        0 => String::new(),
        several => format!(" NumberOfComponents=\"{several}\""),
    };
    for (k, name) in components.iter().enumerate() {
        named += &format!(" ComponentName{k}=\"{name}\"");
    }
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\"{named} format=\"binary\">"
    );
    STANDARD.encode_string(header, out);
    STANDARD.encode_string(blocks.concat(), out);
    out.push_str("\n</DataArray>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Field;
    use crate::mesh::{CellBlock, CellKind, Cuboid};
    use crate::model::{Elastic, Material, Status};
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
    fn parts_have_all_cells_and_the_values_of_their_points() {
        let (model, solution) = tunnel::solved();
        let mesh = &model.bodies[0].mesh;
        let all = body_vtu(&model, &solution, 0);
        let fields = Fields::of(&model, &solution, 0);
        let rows = |vtu: &str, name: &str, size: usize| -> Vec<Vec<u64>> {
            let values: Vec<u64> = read(vtu, name).into_iter().map(f64::to_bits).collect();
            values.chunks(size).map(<[u64]>::to_vec).collect()
        };
        let at = |vtu: &str| -> BTreeSet<Vec<u64>> {
            let points = rows(vtu, "points", 3);
            let fields = [
                ("stress", 6),
                ("displacement", 3),
                ("pressure", 1),
                ("gap", 1),
            ];
            let fields = fields.map(|(name, size)| rows(vtu, name, size));
            let row = |i: usize| {
                let own = fields.iter().flat_map(|field| field[i].clone());
                points[i].iter().copied().chain(own).collect()
            };
            (0..points.len()).map(row).collect()
        };
        for count in [1, 3, mesh.cell_count() + 2] {
            let parts = parts(mesh, count);
            assert_eq!(parts.len(), count);
            let parts = parts
                .iter()
                .map(|part| part_vtu(&model, &solution, (0, &fields), Some(part)));
            let parts: Vec<String> = parts.collect();
            let cells = |vtu: &String| {
                let number = vtu.split("NumberOfCells=\"").nth(1).unwrap();
                number.split('"').next().unwrap().parse::<usize>().unwrap()
            };
            assert_eq!(parts.iter().map(cells).sum::<usize>(), mesh.cell_count());
            let some: BTreeSet<Vec<u64>> = parts.iter().flat_map(|part| at(part)).collect();
            assert_eq!(some, at(&all));
        }
        let files = ["ring.p0.vtu", "ring.p1.vtu"].map(String::from);
        let whole = whole(&all, &files);
        assert_eq!(sources(&whole), files);
        let arrays = |text: &str, tag: &str| text.matches(tag).count();
        assert!(whole.contains(
            "<PDataArray type=\"Float64\" Name=\"displacement\" NumberOfComponents=\"3\""
        ));
        assert!(
            whole.contains("<PPoints>")
                && whole.contains("</PCellData>")
                && !whole.contains("connectivity")
        );
        // without those of the cells themselves, time and units
        let named = arrays(&all, "format=\"binary\"");
        assert_eq!(arrays(&whole, "<PDataArray"), named - 3);
    }

    #[test]
    fn nodes_between_materials_are_points_of_either() {
        // two columns of cells, pushed together by 1 %: 10 in the first, 1 in the second
        let points = [0.0, 1.0].map(|y| [0.0, 1.0, 2.0].map(|x| [x, y])).concat();
        let block = |nodes: [u32; 4], group: &str| CellBlock {
            kind: CellKind::Quad4,
            nodes: nodes.to_vec(),
            group: Some(group.to_string()),
        };
        let blocks = vec![block([0, 1, 4, 3], "stiff"), block([1, 2, 5, 4], "soft")];
        let mesh = Mesh::<2>::new(points, blocks).unwrap();
        let material = |group: &str, young: f64| Material {
            group: Some(group.to_string()),
            elastic: Elastic {
                young,
                poisson: 0.0,
            },
            strength: None,
            plastic: None,
            ages: None,
        };
        let mut model = Model::new();
        let elastic = material("stiff", 1000.0).elastic;
        let body = model.body("bar", mesh, elastic);
        model.bodies[0].materials = vec![material("stiff", 1000.0), material("soft", 100.0)];
        for x in [0.0, 1.0, 2.0] {
            model.pin(body, [x, 0.0], [Some(-0.01 * x), Some(0.0)]);
            model.pin(body, [x, 1.0], [Some(-0.01 * x), None]);
        }
        let vtu = body_vtu(&model, &model.solve().unwrap(), 0);
        assert!(vtu.contains("NumberOfPoints=\"8\""));
        let points = read(&vtu, "points");
        assert_eq!(points[18..], [1.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
        let stress = read(&vtu, "von_mises");
        for (found, expected) in stress
            .iter()
            .zip([10.0, 10.0, 1.0, 10.0, 10.0, 1.0, 1.0, 1.0])
        {
            assert!((found - expected).abs() < 1e-12, "{stress:?}");
        }
        assert_eq!(
            read(&vtu, "displacement")[18..20],
            read(&vtu, "displacement")[3..5]
        );
        assert_eq!(read(&vtu, "pressure").len(), 8);
        // numbers of points, read as another type
        let cells = read(&vtu, "connectivity").into_iter().map(f64::to_bits);
        assert_eq!(cells.collect::<Vec<_>>(), [0, 1, 4, 3, 6, 2, 5, 7]);
    }

    #[test]
    fn nodes_between_the_corners_of_a_side_in_space_have_values_and_a_state() {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [1.0; 3],
            cells: [2; 3],
            cell: CellKind::Hex20,
        };
        let elastic = Elastic {
            young: 1000.0,
            poisson: 0.3,
        };
        let mut model = Model::<3>::new();
        let body = model.body("block", cuboid.build().unwrap(), elastic);
        model.fix(body, "top", [Some(0.0); 3]);
        let gap = Field::function("wedge", |[x, ..], _| 0.001 * (x - 0.6));
        model.obstacle((body, "bottom"), gap);
        let solution = model.solve().unwrap();
        let mesh = &model.bodies[0].mesh;
        let fields = contact_fields(&solution, 0, mesh);
        let at = |x: Point<3>| {
            let node = mesh.points().iter().position(|&p| p == x);
            node.unwrap()
        };
        let mut mixed = 0;
        for node in mesh.side_nodes("bottom").unwrap() {
            let x = mesh.points()[node as usize];
            // along which axis it lies between two corners
            let Some(axis) = (0..2).find(|&d| (2.0 * x[d]).fract() != 0.0) else {
                continue;
            };
            let ends = [-0.25, 0.25].map(|step| {
                let mut end = x;
                end[axis] += step;
                at(end)
            });
            let (node, mean) = (node as usize, |values: &[f64]| {
                0.5 * (values[ends[0]] + values[ends[1]])
            });
            assert_eq!(fields.pressure[node], mean(&fields.pressure));
            assert_eq!(fields.gap[node], mean(&fields.gap));
            assert_eq!(fields.normal[node], [0.0, 0.0, -1.0]);
            assert_eq!(fields.shear[node], [0.0; 3]);
            let states = ends.map(|end| fields.state[end]);
            mixed += usize::from(states[0] != states[1]);
            assert_eq!(fields.state[node], states[0].max(states[1]));
        }
        assert!(mixed > 0);
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
    fn strains_forces_and_states_are_told() {
        let (model, solution) = tunnel::solved();
        let ring = body_vtu(&model, &solution, 0);
        let answer = &solution.bodies[0];
        assert_eq!(read(&ring, "strain"), answer.strain.as_flattened());
        // plane strain, Hooke's law for one node
        let elastic = model.bodies[0].materials[0].elastic;
        let (s, e) = (answer.stress[5], answer.strain[5]);
        let xx = (s[0] - elastic.poisson * (s[1] + s[2])) / elastic.young;
        assert!((xx - e[0]).abs() < 1e-12 * e[0].abs() && e[2] == 0.0);
        let principal = read(&ring, "principal_stress");
        let trace = |s: &[f64]| s[..3].iter().sum::<f64>();
        assert!((trace(&principal[15..18]) - trace(&s)).abs() < 1e-9 * trace(&s).abs());
        // the contact pushes the ring as it says
        let forces = read(&ring, "contact_force");
        let contact = &solution.contacts[0];
        for axis in 0..2 {
            let sum: f64 = forces.iter().skip(axis).step_by(3).sum();
            let sign = if contact.first.body.0 == 0 { 1.0 } else { -1.0 };
            let scale = forces.iter().fold(0.0f64, |m, f| m.max(f.abs()));
            assert!((sum - sign * contact.resultant[axis]).abs() < 1e-9 * scale);
        }
        let numbers = |name: &str| -> Vec<i32> {
            let line = ring.split(&format!("Name=\"{name}\"")).nth(1).unwrap();
            let mut bytes = Vec::new();
            let data = unbase64(&line.lines().nth(1).unwrap()[44..]);
            flate2::read::ZlibDecoder::new(&data[..])
                .read_to_end(&mut bytes)
                .unwrap();
            bytes
                .chunks(4)
                .map(|c| i32::from_le_bytes(c.try_into().unwrap()))
                .collect()
        };
        let states = numbers("contact_state");
        let closed = |status: Status| i32::from(status != Status::Open);
        for node in &contact.nodes {
            let at = if contact.nonmortar.body.0 == 0 {
                node.node
            } else {
                node.partner.unwrap()
            };
            assert_eq!(states[at], closed(node.status));
        }
        let off = states.iter().filter(|state| **state == -1).count();
        assert_eq!(off, states.len() - contact.nodes.len());
        assert!(numbers("body").iter().all(|body| *body == 0));
        assert!(ring.contains("ComponentName3=\"xy\""));
        assert!(ring.contains("Name=\"unit of stress: MN/m²\""));
    }

    #[test]
    fn blocks_have_the_names_of_the_bodies() {
        let (_, solution) = tunnel::solved();
        let text = blocks(&solution, 0, false);
        assert!(text.contains("<DataSet index=\"1\" name=\"rock\" file=\"rock.vtu\"/>"));
        assert_eq!(blocks_name(6, true), "case_0007.vtm");
        let steps = collection(&[solution.clone(), solution], true);
        let expected = ["case_0001.vtm", "case_0002.vtm", "case.vtm"];
        assert_eq!(collected_blocks(&steps), expected);
        assert!(collected_blocks("").is_empty());
    }

    #[test]
    fn long_arrays_are_cut_into_blocks() {
        let values: Vec<f64> = (0..BLOCK / 8 * 2 + 5).map(|i| i as f64).collect();
        let mut out = String::new();
        floats(&mut out, "long", &[], &values);
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
