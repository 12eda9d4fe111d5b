//! The TOML case file, its validation with locations, and published reference values.
//!
//! A case file becomes a [`Model`]: plain data, with every name, number and quantity checked, so that only errors of
//! mechanics remain. Unknown keys are errors. Keys of features that this version does not have are known,
//! and refused as "not supported yet". Numbers are in any consistent units; paths are relative to the case file.

mod body;
mod contact;
mod couple;
mod cyclic;
mod document;
mod error;
mod expression;
mod given;
mod initial;
pub mod keys;
mod members;
mod mesh;
mod mesh_file;
mod outline;
mod parameters;
mod points;
mod probe;
mod reference;
mod run;
mod section;
mod source;
mod spring;
mod steps;
mod strength;
mod suggest;
mod surface;
mod tool;

pub use error::CaseError;
pub use expression::{ExpressionError, parse as parse_expression};
pub use given::{Given, GivenMesh, HANDLE, ReadMesh, read_mesh, to_json};
pub use reference::{Criterion, Kind, Reference, References, Verdict};
pub use run::{Failure, Run};
pub use source::AnyCase;
pub use suggest::nearest;

use crate::case::contact::Aside;
use crate::case::document::{Node, Span, Value, coordinates};
use crate::case::error::{Fault, read_text};
use crate::case::mesh::Generated;
use crate::case::mesh_file::MeshFiles;
use crate::case::probe::Owners;
use crate::case::source::{Source, analysis};
use crate::case::steps::Steps;
use crate::case::suggest::listed;
use crate::host::free_memory;
use crate::mesh::Mesh;
use crate::model::{
    Analysis, Body, Bolts, Check, Event, Formula, MemberKind, Method, Model, Past, ProbeError,
    ProbeValue, Solution, SolverOptions, Study, Subdomains, Subject, Units, Varied,
    check_file_names,
};
use crate::solve::ContactSolver;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A case file, read and checked, of D dimensions; [`AnyCase`] reads a case of either.
#[derive(Debug, Clone)]
pub struct Case<const D: usize> {
    /// Name of the file without its extension: the `case` of result files.
    pub stem: String,
    /// The file, or the name that the text was given.
    pub path: PathBuf,
    /// The problem.
    pub model: Model<D>,
    /// Warnings of reading, such as parts of mesh files that no body uses.
    pub warnings: Vec<String>,
    /// Wall seconds of reading and of making the meshes.
    seconds: f64,
    /// The text, its name in messages, the folder of its paths, and the parts that it names by handles.
    text: Arc<str>,
    name: Arc<str>,
    folder: Arc<Path>,
    given: Arc<Given>,
    /// Paths of the files that the text names.
    files: BTreeSet<String>,
    /// Where the names of bodies and contacts stand, and where probes are read.
    places: Vec<(Subject, Span)>,
    aside: Aside,
}

/// As in [`Model`]: generic code is compiled here, once for each dimension.
macro_rules! doors {
    ($($D:literal)*) => {$(
        impl Case<$D> {
            /// Reads a case file.
            ///
            /// Errors: an unreadable file; invalid TOML; every mistake with its line and column; a case of another number
            /// of dimensions.
            pub fn read(path: &Path) -> Result<Self, CaseError> {
                Self::read_with(path, &[])
            }

            /// Reads a case file of which some parameters have another value: names, and numbers or expressions of the
            /// parameters before each.
            ///
            /// Errors: as [`Self::read`]; parameters that the file does not have.
            pub fn read_with(path: &Path, given: &[(String, String)]) -> Result<Self, CaseError> {
                let text = read_text(path)?;
                of_source(Source::at(path, &text, given)?)
            }

            /// Reads the text of a case file; `name` is how messages call it, and `folder` is where its paths start.
            ///
            /// Errors: as [`Self::read`].
            pub fn from_str(text: &str, name: &str, folder: &Path) -> Result<Self, CaseError> {
                of_source(Source::parse(text, name, folder, &[], &Arc::default())?)
            }

            /// What [`Model::check`](Model) tells, and what was noticed in reading.
            pub fn check(&self) -> Check<$D> {
                let mut check = self.model.check();
                self.warn_first(&mut check.warnings);
                check.notes.extend(self.aside.notes.iter().cloned());
                check
            }

            /// Solves all load steps, after those that were solved before, with an observer of the events.
            pub fn run(&self, past: &[Past<$D>], observe: &mut dyn FnMut(Event)) -> Run<$D> {
                self.became(self.model.solve_steps_after(past, observe))
            }

            /// The same, and `kept` is shown the finished steps after each of them.
            pub fn run_keeping(
                &self,
                past: &[Past<$D>],
                observe: &mut dyn FnMut(Event),
                kept: &dyn Fn(&[Solution<$D>]),
            ) -> Run<$D> {
                self.became(self.model.solve_steps_keeping(past, observe, kept))
            }

            /// Solves all load steps with a solver from outside, as [`Model::solve_steps_by`](Model).
            pub fn run_by(&self, solver: &dyn ContactSolver, observe: &mut dyn FnMut(Event)) -> Run<$D> {
                self.became(self.model.solve_steps_by(solver, observe))
            }

            /// Solves the case for all combinations of some values of its parameters; other parameters may be given values
            /// in place of its own. The text is read again for each member. `observe` is called when a member is done.
            ///
            /// Errors: as [`Self::read_with`], for the names. A member with bad input carries its reason.
            pub fn study(
                &self,
                given: &[(String, String)],
                varied: Vec<Varied>,
                observe: &(dyn Fn() + Sync),
            ) -> Result<Study, CaseError> {
                let read = |values: &[f64]| with_values(self, given, &varied, values);
                let own = varied.iter().map(|varied| self.parameter(&varied.name));
                let Some(own) = own.collect::<Option<Vec<f64>>>() else {
                    // the names are wrong whatever the values are
                    let first = varied.iter().filter_map(|varied| varied.values.first());
                    let case: Result<Self, _> = read(&first.copied().collect::<Vec<_>>());
                    let nothing = || CaseError::unplaced(&self.name, "nothing is varied");
                    return Err(case.err().unwrap_or_else(nothing));
                };
                let make = |values: &[f64]| {
                    let case: Result<Self, _> = read(values);
                    case.map(|case| case.model).map_err(|error| error.message)
                };
                Ok(self.model.clone().study(&own, varied.clone(), &make, observe))
            }

            /// Reads a probe off the solution of a step: `text` is the content of a table `[[probe]]` without its name.
            ///
            /// Errors: mistakes in the probe, or a probe that cannot be read there.
            pub fn probe(&self, text: &str, solution: &Solution<$D>) -> Result<ProbeValue, CaseError> {
                read_probe(self, text, solution)
            }
        }
    )*};
}

doors!(2 3);

/// The case of a document.
fn of_source<const D: usize>(source: Source<'_>) -> Result<Case<D>, CaseError>
where
    Mesh<D>: Generated<D>,
{
    let (text, name) = (source.text, &source.name[..]);
    let path = match Path::new(name).file_name() {
        Some(file) => source.folder.join(file),
        None => source.folder.join(name),
    };
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    let stem = stem.to_string_lossy().into_owned();
    let mut files = MeshFiles::new(source.folder);
    let model = model(&source.document, &stem, &mut files);
    let (mut model, aside) = model.map_err(|fault| fault.in_source(name, text))?;
    model.parameters.clone_from(&source.parameters.values);
    let unused = source.parameters.unused(&source.document);
    let named = std::mem::take(&mut files.named);
    let mut warnings = files.warnings();
    warnings.extend(initial::along_profiles(&source.document));
    warnings.extend(idle(&unused));
    warnings.extend(aside.warnings.iter().cloned());
    warnings.extend(without_contact(&model));
    let found = aside.places.iter();
    let found = found.map(|(name, span)| (Subject::Contact(name.clone()), span.clone()));
    let places = places(&source.document).into_iter().chain(found).collect();
    Ok(Case {
        stem,
        path,
        model,
        warnings,
        seconds: source.start.elapsed().as_secs_f64(),
        text: text.into(),
        name: name.into(),
        folder: source.folder.into(),
        given: Arc::clone(&source.parameters.given),
        files: named,
        places,
        aside,
    })
}

/// As [`Case::<2>::probe`](Case).
fn read_probe<const D: usize>(
    case: &Case<D>,
    text: &str,
    solution: &Solution<D>,
) -> Result<ProbeValue, CaseError>
where
    Mesh<D>: Generated<D>,
{
    let parameters = case.model.parameters.iter();
    let parameters = parameters.map(|(name, value)| format!("parameters.{name} = {value:?}\n"));
    let parameters: String = parameters.collect();
    let text = format!("{parameters}name = \"probe\"\n{text}");
    let source = Source::parse(&text, "probe", &case.folder, &[], &case.given)?;
    let stage = case.model.stage(solution.time);
    // a list of sides becomes a side of the body
    let mut bodies = stage.bodies.clone();
    let names = case.model.probes.iter().map(|probe| probe.name.as_str());
    let names: Vec<&str> = names.collect();
    let owners = Owners {
        probes: &names,
        contacts: &stage.contacts,
        sought: &case.aside.sought,
        sections: &stage.sections,
        members: &stage.members,
    };
    let probe = probe::probe(&source.document, &mut bodies, &owners);
    let probe = probe.map_err(|fault| fault.in_source(&source.name, &text))?;
    let lines = case.model.probes.iter().filter(|probe| probe.is_line());
    let mut lines = lines.map(|line| &line.name);
    let taken = probe.quantity.formula().map_or(&[][..], Formula::probes);
    if let Some(name) = lines.find(|name| taken.contains(name)) {
        let name = name.clone();
        let error = ProbeError::<D>::OfLine { name };
        return Err(CaseError::unplaced(&source.name, &error.to_string()));
    }
    let model = Model {
        bodies,
        ..stage.into_owned()
    };
    let value = crate::model::read_probe(&model, &probe, solution);
    value.map_err(|error| CaseError::unplaced(&source.name, &error.to_string()))
}

/// A case read again, with values of varied parameters.
fn with_values<const D: usize>(
    case: &Case<D>,
    given: &[(String, String)],
    varied: &[Varied],
    values: &[f64],
) -> Result<Case<D>, CaseError>
where
    Mesh<D>: Generated<D>,
{
    let names = varied.iter().map(|parameter| parameter.name.clone());
    let own = names.zip(values.iter().map(|value| format!("{value:?}")));
    let given: Vec<_> = given.iter().cloned().chain(own).collect();
    let (text, folder) = (&case.text, &case.folder);
    of_source(Source::parse(
        text,
        &case.name,
        folder,
        &given,
        &case.given,
    )?)
}

impl<const D: usize> Case<D> {
    /// The text, how messages call it, and where its paths start: what [`AnyCase::from_parts`] makes the same case of.
    pub fn source(&self) -> (&str, &str, &Path) {
        (&self.text, &self.name, &self.folder)
    }

    /// Contents of the files that the text names, by the paths that it has for them, for [`Given::files`]; without those that cannot be
    /// read now.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let read = |name: &String| {
            let content = match self.given.files.get(name) {
                Some(given) => given.clone(),
                None => crate::host::read(&self.folder.join(name)).ok()?,
            };
            Some((name.clone(), content))
        };
        self.files.iter().filter_map(read).collect()
    }

    /// Value of a parameter.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        let parameters = self.model.parameters.iter();
        parameters
            .rev()
            .find(|(known, _)| known == name)
            .map(|(_, value)| *value)
    }

    /// Puts the warnings of reading before the warnings of a result.
    pub(crate) fn warn_first(&self, warnings: &mut Vec<String>) {
        warnings.splice(0..0, self.warnings.iter().cloned());
    }

    /// An error of the model as an error of the file, at the name of the body or contact that it is about, or at the place of the probe.
    pub fn error(&self, subject: Option<&Subject>, message: &str) -> CaseError {
        let place = self.places.iter().find(|(s, _)| Some(s) == subject);
        match place {
            Some((subject, span)) => {
                let label = match subject {
                    Subject::Body(_) => "this body".to_string(),
                    Subject::Contact(_) => "this contact".to_string(),
                    Subject::Section(_) => "this section".to_string(),
                    Subject::Member(kind, _) => format!("this {}", kind.key),
                    Subject::Probe(_) => "here".to_string(),
                };
                Fault::new(span, message)
                    .label(label)
                    .in_source(&self.name, &self.text)
            }
            None => CaseError::unplaced(&self.name, message),
        }
    }
}

/// Where the names of bodies and contacts stand, and where probes are read.
fn places(document: &Node) -> Vec<(Subject, Span)> {
    let of = |key: &str, name: String| {
        let mut members = MemberKind::ALL.iter();
        match key {
            "body" => Some(Subject::Body(name)),
            "contact" => Some(Subject::Contact(name)),
            "section" => Some(Subject::Section(name)),
            "probe" => Some(Subject::Probe(name)),
            key => {
                let kind = members.find(|kind| kind.key == key)?;
                Some(Subject::Member(*kind, name))
            }
        }
    };
    let mut places = Vec::new();
    let entries = document.entries().unwrap_or_default();
    for key in keys::CASE {
        let lists = entries.iter().filter(|entry| entry.key == *key);
        for element in lists.flat_map(|entry| entry.node.list().unwrap_or_default()) {
            let fields = element.entries().unwrap_or_default();
            let field = |key: &str| fields.iter().find(|entry| entry.key == key);
            let Some((Ok(text), name)) = field("name").map(|e| (e.node.text(), &e.node)) else {
                continue;
            };
            // only probes have these keys: their errors concern the position
            let place = field("at").or_else(|| field("along"));
            let place = place.map_or(name, |entry| &entry.node);
            let subject = of(key, text.to_string());
            places.extend(subject.map(|subject| (subject, place.span.clone())));
        }
    }
    places
}

/// Warnings about probes of contacts that were not found.
fn without_contact<const D: usize>(model: &Model<D>) -> Vec<String> {
    let absent = model
        .probes
        .iter()
        .filter(|probe| probe.quantity.is_absent());
    let told = absent.map(|probe| {
        format!(
            "probe \"{}\": the contact of `{}` was not found; its value is NaN",
            probe.name, probe.quantity
        )
    });
    told.collect()
}

/// A warning about parameters that no value depends on.
fn idle(names: &[String]) -> Option<String> {
    let first = names.first()?;
    let told = listed(names.iter().take(NAMED).map(String::as_str));
    let which = match names.len() {
        1 => format!("parameter {told}"),
        all if all > NAMED => format!("parameters {told} and {} more", all - NAMED),
        _ => format!("parameters {told}"),
    };
    Some(format!(
        "no number of this case depends on the {which}: in a string its name stands for it, as in young = \"{first}\""
    ))
}

/// Most names in a message.
const NAMED: usize = 4;

/// The model of a whole document.
fn model<const D: usize>(
    document: &Node,
    stem: &str,
    files: &mut MeshFiles,
) -> Result<(Model<D>, Aside), Fault>
where
    Mesh<D>: Generated<D>,
{
    let table = document.table(keys::CASE)?;
    let text = |key: &str, default: &str| {
        let node = table.get(key);
        node.map_or(Ok(default), Node::text).map(str::to_string)
    };
    let title = text("title", stem)?;
    let source = text("source", "")?;
    let analysis = analysis(document)?;
    if (analysis == Analysis::Solid) != (D == 3) {
        let node = table.require("analysis", "a case")?;
        let message = format!("this is a case of {D} dimensions to its reader");
        return Err(Fault::new(&node.span, message).label("another number of dimensions"));
    }
    let units = table.get("units").map_or(Ok(Units::default()), units)?;

    let bodies = table.list("body")?;
    if bodies.is_empty() {
        let span = table.get("body").map_or(table.span, |node| &node.span);
        return Err(Fault::new(span, "the case has no body")
            .label("no body")
            .help("add a table `[[body]]` with `name`, `mesh` and `material`"));
    }
    let (contacts, sections) = (table.list("contact")?, table.list("section")?);
    let mut named = vec![
        (bodies, ["body", "bodies"]),
        (contacts, ["contact", "contacts"]),
        (sections, ["section", "sections"]),
    ];
    for kind in MemberKind::ALL {
        named.push((table.list(kind.key)?, [kind.key, kind.plural]));
    }
    own_names(&named)?;
    names_of_files(bodies)?;
    if let Analysis::Axisymmetric | Analysis::Solid = analysis {
        let refused = |body| no_thickness(body, analysis);
        bodies.iter().try_for_each(refused)?;
    }
    let steps = Steps::read(table)?;
    files.drawing = table.get("drawing").map(outline::drawing).transpose()?;
    let bodies = bodies
        .iter()
        .map(|node| body::body(node, analysis, files, &steps));
    let mut bodies = bodies.collect::<Result<Vec<_>, _>>()?;
    own_regions(&files.used, &bodies)?;

    let found = contact::contacts(contacts, &mut bodies, &steps, files)?;
    names_of_found(&found.aside.places, &named)?;

    let sections = sections.iter();
    let sections = sections.map(|node| section::section(node, &mut bodies));
    let sections = sections.collect::<Result<Vec<_>, _>>()?;

    let members = members::members(table, &mut bodies, analysis, &steps)?;
    let (members, nodes): (Vec<_>, Vec<_>) = members.into_iter().unzip();

    let solver = table.get("solver");
    let solver = solver.map_or(Ok(SolverOptions::default()), solver_options)?;

    let probes = table.list("probe")?;
    unique_names(probes, "probes")?;
    let names: Vec<&str> = probes.iter().filter_map(name_of).collect();
    let owners = Owners {
        probes: &names,
        contacts: &found.list,
        sought: &found.aside.sought,
        sections: &sections,
        members: &members,
    };
    let read = probes.iter();
    let read = read.map(|node| probe::probe(node, &mut bodies, &owners));
    let read = read.collect::<Result<Vec<_>, _>>()?;
    for material in bodies.iter_mut().flat_map(|body| &mut body.materials) {
        material.age_until(steps.times.last().copied());
    }

    let model = Model {
        title,
        source,
        analysis,
        units,
        bodies,
        contacts: found.list,
        members,
        sections,
        solver: SolverOptions {
            memory: free_memory(),
            ..solver
        },
        probes: read,
        times: steps.times,
        step_names: steps.names,
        zeroed: steps.zeroed,
        parameters: Vec::new(),
    };
    for (member, node) in model.members.iter().zip(nodes) {
        if let Err(error) = member.check(&model) {
            return Err(members::fault(&error, node, member));
        }
    }
    model
        .check_formulas()
        .map_err(|error| probe::formula_fault(&error, probes))?;
    Ok((model, found.aside))
}

/// Refuses two bodies of one region at the same time.
fn own_regions<const D: usize>(
    used: &[(String, String, Span)],
    bodies: &[Body<D>],
) -> Result<(), Fault> {
    let active = |name: &str| {
        bodies
            .iter()
            .find(|body| body.name == name)
            .map(|b| b.active)
    };
    for (k, (region, body, span)) in used.iter().enumerate() {
        let before = used[..k].iter().filter(|(other, ..)| other == region);
        let together = |other: &str| match (active(other), active(body)) {
            (Some(a), Some(b)) => a.meets(b),
            _ => false,
        };
        if let Some((_, other, _)) = before.into_iter().find(|(_, name, _)| together(name)) {
            let message =
                format!("the bodies `{other}` and `{body}` are both made of region `{region}`");
            return Err(Fault::new(span, message)
                .label("second body at one place")
                .help("give them `active` so that one leaves before the other comes, or name another region"));
        }
    }
    Ok(())
}

/// Refuses a thickness, which bodies of revolution and of space do not have.
fn no_thickness(body: &Node, analysis: Analysis) -> Result<(), Fault> {
    let materials = body.entries()?.iter().filter(|e| e.key == "material");
    for entry in materials {
        let one = std::slice::from_ref(&entry.node);
        let list = entry.node.list().unwrap_or(one);
        let fields = list.iter().flat_map(|m| m.entries().unwrap_or_default());
        if let Some(thickness) = fields.into_iter().find(|e| e.key == "thickness") {
            let (kind, instead) = match analysis {
                Analysis::Solid => ("a 3D", "the mesh has all three dimensions"),
                _ => ("an axisymmetric", "forces are for the full turn"),
            };
            let message = format!("`thickness` has no meaning in {kind} analysis");
            return Err(Fault::new(&thickness.key_span, message)
                .label("superfluous")
                .help(instead));
        }
    }
    Ok(())
}

fn units(node: &Node) -> Result<Units, Fault> {
    let table = node.table(keys::UNITS)?;
    let label = |key: &str| {
        let text = table.get(key).map(Node::text).transpose()?;
        Ok(text.map(str::to_string))
    };
    Ok(Units {
        length: label("length")?,
        force: label("force")?,
    })
}

/// Refuses one `name` for two of these parts, each with a word for one and for several.
fn own_names(lists: &[(&[Node], [&str; 2])]) -> Result<(), Fault> {
    for (list, [_, several]) in lists {
        unique_names(list, several)?;
    }
    let named = lists.iter().flat_map(|(list, [kind, _])| {
        let names = list
            .iter()
            .filter_map(|node| node.entries().ok()?.iter().find(|e| e.key == "name"));
        names.filter_map(move |entry| Some((kind, entry.node.text().ok()?, &entry.node.span)))
    });
    let named: Vec<_> = named.collect();
    for (k, (kind, name, span)) in named.iter().enumerate() {
        if let Some((before, ..)) = named[..k].iter().find(|(_, known, _)| known == name) {
            let message = format!("`{name}` names a {before} already and cannot name a {kind}");
            let parts: Vec<&str> = lists.iter().map(|(_, words)| words[1]).collect();
            let help = format!(
                "names of {} are unique together: quantities of probes begin with them",
                crate::model::listed(&parts, "and")
            );
            return Err(Fault::new(span, message)
                .label("second use of the name")
                .help(help));
        }
    }
    Ok(())
}

/// The name of a table, where it has one.
fn name_of(node: &Node) -> Option<&str> {
    let entry = node.entries().ok()?.iter().find(|e| e.key == "name")?;
    entry.node.text().ok()
}

/// Refuses a contact that was found under the name of another part; `found` are names with the places of their tables.
fn names_of_found(found: &[(String, Span)], lists: &[(&[Node], [&str; 2])]) -> Result<(), Fault> {
    let tables = lists.iter().flat_map(|(list, _)| list.iter());
    let mut names: BTreeSet<&str> = tables.filter_map(name_of).collect();
    match found.iter().find(|(name, _)| !names.insert(name)) {
        None => Ok(()),
        Some((name, span)) => {
            let message =
                format!("a contact that was found would be the second part with the name `{name}`");
            Err(Fault::new(span, message)
                .label("its first part")
                .help("give one of the two another name"))
        }
    }
}

/// Refuses bodies whose names cannot be those of result files.
fn names_of_files(bodies: &[Node]) -> Result<(), Fault> {
    let named = bodies.iter().filter_map(|node| {
        let entry = node.entries().ok()?.iter().find(|e| e.key == "name")?;
        Some((entry.node.text().ok()?, &entry.node.span))
    });
    let named: Vec<_> = named.collect();
    let Err(error) = check_file_names(named.iter().map(|(name, _)| *name)) else {
        return Ok(());
    };
    let refused = named.iter().find(|(name, _)| *name == error.name());
    let span = refused.map_or(0..0, |(_, span)| (*span).clone());
    let message = format!("body `{}`: {error}", error.name());
    Err(Fault::new(&span, message).label("names a result file"))
}

/// Refuses two elements of a list of tables with the same `name`.
fn unique_names(list: &[Node], what: &str) -> Result<(), Fault> {
    let mut seen: Vec<&str> = Vec::new();
    for node in list {
        let entry = node.entries()?.iter().find(|e| e.key == "name");
        let Some((name, node)) = entry.and_then(|e| Some((e.node.text().ok()?, &e.node))) else {
            continue;
        };
        if seen.contains(&name) {
            let message = format!("two {what} are named `{name}`");
            return Err(Fault::new(&node.span, message).label("second use of the name"));
        }
        seen.push(name);
    }
    Ok(())
}

fn solver_options<const D: usize>(node: &Node) -> Result<SolverOptions<D>, Fault> {
    let table = node.table(keys::SOLVER)?;
    let default = SolverOptions::default();
    let methods = [Method::Auto].into_iter().chain(Method::NAMED);
    let methods: Vec<_> = methods.map(|m| (m.name(), m)).collect();
    let method = table.get("method");
    let method = method.map_or(Ok(default.method), |node| node.choice("method", &methods))?;
    let tolerance = table.get("tolerance");
    let tolerance = tolerance.map_or(Ok(default.tolerance), |n| n.positive("`tolerance`"))?;
    let iterations = table.get("max_iterations");
    let iterations = iterations.map(|node| node.positive_integer("`max_iterations`"));

    let only_for = |key: &str, methods: &[Method]| match table.entry(key) {
        Some(entry) if !methods.contains(&method) => {
            let names = listed_methods(methods);
            let message = format!("`{key}` has no meaning for the method `{}`", method.name());
            Err(Fault::new(&entry.key_span, message)
                .label(format!("only for {names}"))
                .help(format!("remove `{key}`, or set `method` to {names}")))
        }
        Some(entry) => Ok(Some(&entry.node)),
        None => Ok(None),
    };
    let rho = only_for("rho", &[Method::Gradient, Method::Uzawa])?;
    let bolts = only_for("bolt", &[Method::Uzawa])?;
    Ok(SolverOptions {
        method,
        tolerance,
        max_iterations: iterations.transpose()?,
        rho: rho.map_or(Ok(None), step_length)?,
        bolts: bolts.map_or(Ok(default.bolts), bolt_places)?,
        memory: None,
        subdomains: table
            .get("subdomains")
            .map_or(Ok(Subdomains::Auto), subdomains)?,
    })
}

/// `"auto"`, or a number of pieces.
fn subdomains(node: &Node) -> Result<Subdomains, Fault> {
    match &node.value {
        Value::Text(text) if text == "auto" => Ok(Subdomains::Auto),
        _ => node.positive_integer("`subdomains`").map(Subdomains::Parts),
    }
}

fn listed_methods(methods: &[Method]) -> String {
    let names: Vec<String> = methods.iter().map(|m| format!("`{}`", m.name())).collect();
    names.join(" or ")
}

fn step_length(node: &Node) -> Result<Option<f64>, Fault> {
    match &node.value {
        Value::Text(text) if text == "auto" => Ok(None),
        _ => node.positive("`rho`").map(Some),
    }
}

/// `"auto"`, one point, or a list of points.
fn bolt_places<const D: usize>(node: &Node) -> Result<Bolts<D>, Fault> {
    let point = coordinates::<D>();
    let expected = || node.expected(&format!("\"auto\", a point {point} or a list of points"));
    match &node.value {
        Value::Text(text) if text == "auto" => Ok(Bolts::Automatic),
        Value::List(list) if list.is_empty() => Err(expected()),
        Value::List(list) if list.iter().all(|n| matches!(n.value, Value::List(_))) => {
            let points = list.iter().map(Node::point).collect::<Result<_, _>>()?;
            Ok(Bolts::Points(points))
        }
        Value::List(_) => Ok(Bolts::Points(vec![node.point()?])),
        _ => Err(expected()),
    }
}

#[cfg(test)]
mod tests;
