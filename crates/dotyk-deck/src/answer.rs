//! Solutions on the nodes and elements of the deck, for the result files that it asks for.
//!
//! RF is what acts on a node from outside, as in CalculiX: reactions and loads, that is the nodal forces of the stress less those of
//! contacts. Tangents of a contact are CalculiX's: the projection of the first axis, of the third where the normal is along the
//! first, and the normal times it.

use crate::Deck;
use crate::deck::Index;
use crate::frd;
use crate::lines::folded;
use crate::results::{
    ContactForce, ContactNode, ContactPrint, ContactQuantity, Element, FrdQuantity, Kind, Mesh,
    NodePrint, NodeQuantity, PointPrint, PointQuantity, PointRow, Print, Step, Totals,
};
use crate::{dat, steps};
use dotyk::fem::{CellPoints, FemError, cell_points, nodal_forces, recover_spin};
use dotyk::geometry::Point;
use dotyk::model::{ContactSolution, Model, Solution, Status};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Strains and rotations up to these are small: lengths are wrong by less than a two-hundredth of the rest.
const SMALL: (f64, f64) = (0.02, 0.1);

impl Deck {
    /// The files `JOB.frd` and `JOB.dat` as the deck's requests have them: names and contents.
    ///
    /// Errors: fields that cannot be evaluated.
    pub fn files<const D: usize>(
        &self,
        model: &Model<D>,
        solutions: &[Solution<D>],
    ) -> Result<Vec<(String, Vec<u8>)>, FemError> {
        let mesh = self.result_mesh();
        let mut steps = Vec::with_capacity(solutions.len());
        let (mut quantities, mut prints) = (Vec::new(), Vec::new());
        for (solution, own) in solutions.iter().zip(&self.deck.steps) {
            let asked = &own.requests;
            let words = asked.iter().flat_map(|request| &request.quantities);
            let forces = words.clone().any(|word| word == "RF");
            let (step, rows) =
                self.step((model, solution), [own.number[0], own.number[1]], forces)?;
            steps.push(step);
            quantities.push(frd_quantities(asked));
            prints.push(self.prints(model, solution, asked, rows)?);
        }
        let to_frd: Vec<_> = steps.iter().zip(quantities).collect();
        let to_dat: Vec<_> = steps.iter().zip(prints).collect();
        // writing into memory does not fail
        let (mut frd, mut dat) = (Vec::new(), Vec::new());
        let _ = frd::write(&mut frd, &self.stem, &mesh, &to_frd);
        let _ = dat::write(&mut dat, &mesh, &to_dat);
        Ok(vec![
            (format!("{}.frd", self.stem), frd),
            (format!("{}.dat", self.stem), dat),
        ])
    }

    /// `JOB.sta` of CalculiX, a line for each step: name and content.
    pub fn status(&self, steps: usize) -> (String, Vec<u8>) {
        let mut text = String::from(
            "SUMMARY OF JOB INFORMATION\n  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME\n",
        );
        for step in self.deck.steps.iter().take(steps) {
            let (time, period, [number, increment, _]) = (step.time, step.period, step.number);
            text += &format!("{number:6}{increment:9}{:8}{:6}", 1, 1);
            for value in [time, increment as f64 * period, period] {
                let mut line = Vec::new();
                crate::number::scientific(&mut line, value, 14, 6);
                text += &String::from_utf8_lossy(&line);
            }
            text.push('\n');
        }
        (format!("{}.sta", self.stem), text.into_bytes())
    }

    /// Where the deck asks for finite motion: how large strains and rotations are, and whether that is small; `None` where it does not.
    ///
    /// Errors: fields that cannot be evaluated.
    pub fn motion<const D: usize>(
        &self,
        model: &Model<D>,
        solutions: &[Solution<D>],
    ) -> Result<Option<(String, bool)>, FemError> {
        let Some(step) = self.deck.steps.iter().find(|step| step.nlgeom) else {
            return Ok(None);
        };
        let (mut strain, mut rotation) = (0.0f64, 0.0f64);
        for solution in solutions {
            for (body, own) in model.bodies.iter().zip(&solution.bodies) {
                for e in own.strain.iter().flatten() {
                    strain = strain.max(e.abs());
                }
                let spins = recover_spin(body, model.analysis, &own.displacement, solution.time)?;
                for spin in spins {
                    rotation = rotation.max(spin.iter().map(|s| s * s).sum::<f64>().sqrt());
                }
            }
        }
        let source = &self.sources.files[step.place.file as usize].name;
        let is_small = strain <= SMALL.0 && rotation <= SMALL.1;
        let judged = match is_small {
            true => "that is small",
            false => {
                "that is not small, and finite motion is not supported yet: this answer is a rough one"
            }
        };
        let told = format!(
            "{source}:{}: *STEP: NLGEOM: strains reach {strain:.1e} and rotations {rotation:.1e} rad: {judged}",
            step.place.line
        );
        Ok(Some((told, is_small)))
    }

    fn result_mesh(&self) -> Mesh {
        let deck = &self.deck;
        let mut names: Vec<String> = Vec::new();
        let mut of_section = Vec::new();
        for section in &deck.sections {
            let place = names.iter().position(|name| *name == section.material);
            of_section.push(place.unwrap_or_else(|| {
                names.push(section.material.clone());
                names.len() - 1
            }));
        }
        let element = |(index, own): (usize, &crate::deck::Element)| Element {
            number: own.number,
            kind: deck.shape(index as Index).form,
            nodes: own
                .nodes
                .iter()
                .map(|node| deck.numbers[*node as usize])
                .collect(),
            material: of_section[self.bodies.section_of[index]] as u32 + 1,
        };
        Mesh {
            nodes: deck
                .numbers
                .iter()
                .copied()
                .zip(deck.points.iter().copied())
                .collect(),
            elements: deck.elements.iter().enumerate().map(element).collect(),
            materials: names,
            headings: deck.headings.clone(),
        }
    }

    /// A solution on the nodes of the deck, and the number of its rows of contacts.
    fn step<const D: usize>(
        &self,
        (model, solution): (&Model<D>, &Solution<D>),
        number: [usize; 2],
        with_forces: bool,
    ) -> Result<(Step, usize), FemError> {
        let count = self.deck.points.len();
        let mut step = Step {
            number,
            time: solution.time,
            displacement: vec![[0.0; 3]; count],
            reaction: vec![[0.0; 3]; count],
            stress: vec![[0.0; 6]; count],
            strain: vec![[0.0; 6]; count],
            contact: Vec::new(),
        };
        for (index, own) in solution.bodies.iter().enumerate() {
            let body = &model.bodies[index];
            let forces = match with_forces {
                true => nodal_forces(body, model.analysis, &own.displacement, solution.time)?,
                false => own.contact_forces.clone(),
            };
            for (local, &node) in self.bodies.list[index].nodes.iter().enumerate() {
                let node = node as usize;
                step.displacement[node] = space(own.displacement[local]);
                let (total, contact) = (space(forces[local]), space(own.contact_forces[local]));
                let of_bolts = own.member_forces.get(&local).filter(|_| with_forces);
                let of_bolts = of_bolts.map_or([0.0; 3], |force| space(*force));
                step.reaction[node] = std::array::from_fn(|d| total[d] - contact[d] - of_bolts[d]);
                step.stress[node] = tensor(own.stress[local]);
                step.strain[node] = tensor(own.strain[local]);
            }
        }
        for [kept, gone] in self
            .deck
            .same
            .iter()
            .rev()
            .map(|pair| pair.map(|node| node as usize))
        {
            step.displacement[gone] = step.displacement[kept];
            step.stress[gone] = step.stress[kept];
            step.strain[gone] = step.strain[kept];
        }
        // the two nodes of a cut are one of the deck
        for (node, copy) in &self.deck.copies {
            let (node, copy) = (*node as usize, *copy as usize);
            let other = std::mem::take(&mut step.reaction[copy]);
            (0..3).for_each(|d| step.reaction[node][d] += other[d]);
        }
        for (node, bolt) in &self.shortenings {
            if let Some(member) = solution.member(bolt) {
                let force = member.largest().map_or(0.0, |station| station.force);
                let length = member.shortening.unwrap_or(0.0);
                step.displacement[*node as usize] = [length, 0.0, 0.0];
                step.reaction[*node as usize] = [force, 0.0, 0.0];
            }
        }
        self.references(solution, &mut step);
        let rows = solution.contacts.iter();
        step.contact = rows
            .flat_map(|contact| self.contact_nodes(contact))
            .collect();
        let rows = step.contact.len();
        Ok((step, rows))
    }

    /// Motion of, and forces at, reference and rotation nodes.
    fn references<const D: usize>(&self, solution: &Solution<D>, step: &mut Step) {
        for coupling in &self.deck.couplings {
            let Some((body, name)) = self.references.get(&coupling.reference) else {
                continue;
            };
            let mut couples = solution.bodies[*body].couples.iter();
            let Some(couple) = couples.find(|couple| couple.name == *name) else {
                continue;
            };
            let node = coupling.reference as usize;
            step.displacement[node] = space(couple.displacement);
            // what acts on the point from outside is what it hands on to the body, of which it may be a node itself
            let force = space(couple.force);
            (0..3).for_each(|d| step.reaction[node][d] += force[d]);
            if let Some(turning) = coupling.rotation {
                let turned = |values: &[f64]| match values {
                    [about_z] => [0.0, 0.0, *about_z],
                    [x, y, z] => [*x, *y, *z],
                    _ => [0.0; 3],
                };
                step.displacement[turning as usize] = turned(&couple.rotation);
                step.reaction[turning as usize] = turned(&couple.moment);
            }
        }
    }

    fn contact_nodes<const D: usize>(&self, contact: &ContactSolution<D>) -> Vec<ContactNode> {
        let nodes = &self.bodies.list[contact.nonmortar.body.0].nodes;
        let faces = contact.nodes.iter().filter(|node| node.gap.is_finite());
        let row = |node: &dotyk::model::ContactNode<D>| {
            let tangents = tangents(space(node.normal));
            let along = |v: Point<D>| {
                let v = space(v);
                tangents.map(|t| (0..3).map(|d| t[d] * v[d]).sum::<f64>())
            };
            ContactNode {
                node: self.deck.numbers[nodes[node.node] as usize],
                gap: node.gap,
                slip: along(node.slip),
                pressure: node.pressure,
                shear: along(node.shear),
            }
        };
        faces.map(row).collect()
    }

    /// What *NODE PRINT, *EL PRINT and *CONTACT PRINT ask for.
    fn prints<const D: usize>(
        &self,
        model: &Model<D>,
        solution: &Solution<D>,
        asked: &[steps::Request],
        rows: usize,
    ) -> Result<Vec<Print>, FemError> {
        let copies: BTreeSet<Index> = self.deck.copies.values().copied().collect();
        let mut prints = Vec::new();
        let mut points: Option<HashMap<Index, CellPoints>> = None;
        for request in asked {
            let totals = match request.totals.as_deref() {
                Some("YES") => Totals::Yes,
                Some("ONLY") => Totals::Only,
                _ => Totals::No,
            };
            let set = request.set.clone().unwrap_or_default();
            for quantity in &request.quantities {
                match (request.keyword.as_str(), quantity.as_str()) {
                    ("NODE PRINT", "U" | "RF") => {
                        let known = self.deck.node_sets.get(&folded(&set));
                        let nodes = known.map_or(Vec::new(), |set| {
                            let members = set.members.iter().filter(|node| !copies.contains(node));
                            members.map(|node| *node as usize).collect()
                        });
                        let quantity = if quantity == "U" {
                            NodeQuantity::Displacement
                        } else {
                            NodeQuantity::Reaction
                        };
                        prints.push(Print::Nodes(NodePrint {
                            set: folded(&set),
                            nodes,
                            quantity,
                            totals,
                        }));
                    }
                    ("EL PRINT", "S" | "E") => {
                        if points.is_none() {
                            points = Some(self.points(model, solution)?);
                        }
                        let quantity = if quantity == "S" {
                            PointQuantity::Stress
                        } else {
                            PointQuantity::Strain
                        };
                        let rows = points
                            .as_ref()
                            .map_or(Vec::new(), |points| self.point_rows(&set, points, quantity));
                        prints.push(Print::Points(PointPrint {
                            set: folded(&set),
                            quantity,
                            rows,
                        }));
                    }
                    ("CONTACT PRINT", "CDIS" | "CDISP" | "CSTR" | "CSTRESS") => {
                        let quantity = if quantity.starts_with("CD") {
                            ContactQuantity::Displacement
                        } else {
                            ContactQuantity::Stress
                        };
                        prints.push(Print::Contact(ContactPrint {
                            quantity,
                            nodes: 0..rows,
                        }));
                    }
                    ("CONTACT PRINT", "CF" | "CFN" | "CFS") => {
                        let asked = |own: &[&String; 2]| {
                            let mut wanted = request.pair.iter().zip(own);
                            wanted.all(|(wanted, own)| wanted.as_ref().is_none_or(|w| w == *own))
                        };
                        let pairs = self.pairs().into_iter().filter(|(pair, _)| asked(pair));
                        let forces = pairs.filter_map(|(pair, names)| {
                            let has =
                                |contact: &&ContactSolution<D>| names.contains(&&contact.name);
                            let contacts: Vec<_> = solution.contacts.iter().filter(has).collect();
                            (!contacts.is_empty()).then(|| force(pair, &contacts))
                        });
                        prints.extend(forces.map(Print::ContactForce));
                    }
                    _ => {}
                }
            }
        }
        Ok(prints)
    }

    /// Slave and master of every pair in the order of the deck, with the names of its contacts: one for each pair of bodies.
    fn pairs(&self) -> Vec<([&String; 2], Vec<&String>)> {
        let mut pairs: Vec<([&String; 2], Vec<&String>)> = Vec::new();
        for named in &self.contacts {
            let own = [&named.slave, &named.master];
            match pairs.iter_mut().find(|(pair, _)| *pair == own) {
                Some((_, names)) => names.push(&named.name),
                None => pairs.push((own, vec![&named.name])),
            }
        }
        pairs
    }

    /// Stress and strain at the points of every element.
    fn points<const D: usize>(
        &self,
        model: &Model<D>,
        solution: &Solution<D>,
    ) -> Result<HashMap<Index, CellPoints>, FemError> {
        let mut all = HashMap::new();
        for (index, own) in solution.bodies.iter().enumerate() {
            let body = &model.bodies[index];
            let order = self.cell_order(index);
            for cell in cell_points(body, model.analysis, &own.displacement, solution.time)? {
                if let Some(element) = order.get(&(cell.block, cell.cell)) {
                    all.insert(*element, cell);
                }
            }
        }
        Ok(all)
    }

    /// The element of each cell of a body: blocks by kind and section, in the order of the mesh file.
    fn cell_order(&self, body: usize) -> BTreeMap<(usize, usize), Index> {
        let body = &self.bodies.list[body];
        let mut blocks: Vec<(Kind, usize, usize)> = Vec::new();
        let mut order = BTreeMap::new();
        for (section, _) in &body.sections {
            for &element in body
                .elements
                .iter()
                .filter(|e| self.bodies.section_of[**e as usize] == *section)
            {
                let form = self.deck.shape(element).form;
                let known = blocks
                    .iter()
                    .position(|(known, of, _)| *known == form && of == section);
                let block = known.unwrap_or_else(|| {
                    blocks.push((form, *section, 0));
                    blocks.len() - 1
                });
                order.insert((block, blocks[block].2), element);
                blocks[block].2 += 1;
            }
        }
        order
    }

    fn point_rows(
        &self,
        set: &str,
        points: &HashMap<Index, CellPoints>,
        quantity: PointQuantity,
    ) -> Vec<PointRow> {
        let Some(set) = self.deck.element_sets.get(&folded(set)) else {
            return Vec::new();
        };
        let mut rows = Vec::new();
        for element in &set.members {
            let Some(cell) = points.get(element) else {
                continue;
            };
            let values = match quantity {
                PointQuantity::Stress => &cell.stress,
                PointQuantity::Strain => &cell.strain,
            };
            let number = self.deck.elements[*element as usize].number;
            rows.extend(
                (1..)
                    .zip(values)
                    .map(|(point, value)| (number, point, tensor(*value))),
            );
        }
        rows
    }
}

/// Quantities of the `.frd` that *NODE FILE, *EL FILE and *CONTACT FILE ask for.
fn frd_quantities(asked: &[steps::Request]) -> Vec<FrdQuantity> {
    let asks = |keyword: &str, words: &[&str]| {
        let own = asked.iter().filter(|request| request.keyword == keyword);
        own.flat_map(|request| &request.quantities)
            .any(|word| words.contains(&word.as_str()))
    };
    let all = [
        (FrdQuantity::Displacement, asks("NODE FILE", &["U"])),
        (FrdQuantity::Stress, asks("EL FILE", &["S"])),
        (FrdQuantity::Strain, asks("EL FILE", &["E"])),
        (FrdQuantity::Reaction, asks("NODE FILE", &["RF"])),
        (
            FrdQuantity::Contact,
            asks("CONTACT FILE", &["CDIS", "CDISP", "CSTR", "CSTRESS"]),
        ),
    ];
    all.into_iter()
        .filter(|(_, wanted)| *wanted)
        .map(|(quantity, _)| quantity)
        .collect()
}

/// A vector with z = 0 in the plane.
fn space<const D: usize>(v: Point<D>) -> [f64; 3] {
    std::array::from_fn(|d| v.get(d).copied().unwrap_or(0.0))
}

/// xx yy zz xy yz xz as xx yy zz xy xz yz.
fn tensor([xx, yy, zz, xy, yz, xz]: [f64; 6]) -> [f64; 6] {
    [xx, yy, zz, xy, xz, yz]
}

/// The two tangents of a normal.
fn tangents(n: [f64; 3]) -> [[f64; 3]; 2] {
    let axis = if n[0].abs() < 0.99999 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let along: f64 = (0..3).map(|d| axis[d] * n[d]).sum();
    let first: [f64; 3] = std::array::from_fn(|d| axis[d] - along * n[d]);
    let size = first.iter().map(|x| x * x).sum::<f64>().sqrt();
    let first = first.map(|x| x / size);
    let second = [
        n[1] * first[2] - n[2] * first[1],
        n[2] * first[0] - n[0] * first[2],
        n[0] * first[1] - n[1] * first[0],
    ];
    [first, second]
}

/// The force of the contacts of a pair on their slave sides; area, its centre and normal are those of what is closed.
fn force<const D: usize>(
    [slave, master]: [&String; 2],
    contacts: &[&ContactSolution<D>],
) -> ContactForce {
    let mut all = ContactForce {
        slave: slave.clone(),
        master: master.clone(),
        ..ContactForce::default()
    };
    for contact in contacts {
        let force = space(contact.resultant);
        let closed = contact.nodes.iter();
        for node in closed.filter(|node| node.status != Status::Open) {
            let (point, n) = (space(node.point), space(node.normal));
            all.area += node.weight;
            for d in 0..3 {
                all.center[d] += node.weight * point[d];
                all.normal[d] += node.weight * n[d];
            }
        }
        let add = |sum: &mut [f64; 3], more: [f64; 3]| {
            sum.iter_mut()
                .zip(more)
                .for_each(|(sum, more)| *sum += more);
        };
        add(&mut all.force, force);
        add(&mut all.moment, contact.moment);
    }
    let size = all.normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let over = |size: f64| move |x: f64| if size > 0.0 { x / size } else { 0.0 };
    ContactForce {
        center: all.center.map(over(all.area)),
        normal: all.normal.map(over(size)),
        ..all
    }
}
