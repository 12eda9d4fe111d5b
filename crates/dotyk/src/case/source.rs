//! The text of a case, and whether it is one of the plane or of space.

use crate::case::document::{self, Node};
use crate::case::error::{Fault, read_text};
use crate::case::given::Given;
use crate::case::parameters::Parameters;
use crate::case::{Case, CaseError, keys, of_source};
use crate::model::{Analysis, Model};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

/// A case of the plane or of space, as its `analysis` says.
#[derive(Debug, Clone)]
pub enum AnyCase {
    /// Plane strain, plane stress or axial symmetry.
    Plane(Case<2>),
    /// Three dimensions.
    Space(Case<3>),
}

impl AnyCase {
    /// Reads a case file of which some parameters have another value, as [`Case::<2>::read_with`](Case).
    ///
    /// Errors: an unreadable file; invalid TOML; every mistake with its line and column; parameters that the file does not
    /// have.
    pub fn read_with(path: &Path, given: &[(String, String)]) -> Result<Self, CaseError> {
        let text = read_text(path)?;
        Self::of(Source::at(path, &text, given)?)
    }

    /// Reads the text of a case file; `name` is how messages call it, and `folder` is where its paths start.
    ///
    /// Errors: as [`Self::read_with`].
    pub fn from_str(text: &str, name: &str, folder: &Path) -> Result<Self, CaseError> {
        Self::from_parts(text, name, folder, &[], &Arc::default())
    }

    /// The same with other values of parameters, and with meshes and functions that the text names.
    ///
    /// Errors: as [`Self::read_with`].
    pub fn from_parts(
        text: &str,
        name: &str,
        folder: &Path,
        set: &[(String, String)],
        given: &Arc<Given>,
    ) -> Result<Self, CaseError> {
        Self::of(Source::parse(text, name, folder, set, given)?)
    }

    /// Names of its probes, and whether they have values along a line.
    pub(crate) fn probes(&self) -> Vec<(&str, bool)> {
        match self {
            Self::Plane(case) => probes(&case.model),
            Self::Space(case) => probes(&case.model),
        }
    }

    /// Number of its load steps.
    pub(crate) fn steps(&self) -> usize {
        match self {
            Self::Plane(case) => case.model.times.len(),
            Self::Space(case) => case.model.times.len(),
        }
    }

    fn of(source: Source<'_>) -> Result<Self, CaseError> {
        let analysis = analysis(&source.document);
        match analysis.map_err(|fault| fault.in_source(&source.name, source.text))? {
            Analysis::Solid => of_source(source).map(Self::Space),
            _ => of_source(source).map(Self::Plane),
        }
    }
}

fn probes<const D: usize>(model: &Model<D>) -> Vec<(&str, bool)> {
    let probes = model.probes.iter();
    let told = probes.map(|probe| (probe.name.as_str(), probe.is_line()));
    told.collect()
}

/// A text of a case, parsed.
pub(crate) struct Source<'t> {
    pub text: &'t str,
    /// Its name in messages.
    pub name: String,
    /// The folder of its paths.
    pub folder: &'t Path,
    pub document: Node,
    pub parameters: Rc<Parameters>,
    /// When the reading began.
    pub start: Instant,
}

impl<'t> Source<'t> {
    /// The text of a file.
    ///
    /// Errors: as [`Self::parse`].
    pub fn at(
        path: &'t Path,
        text: &'t str,
        given: &[(String, String)],
    ) -> Result<Self, CaseError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.display().to_string();
        Self::parse(text, &name, folder, given, &Arc::default())
    }

    /// A text in which some parameters have another value.
    ///
    /// Errors: invalid TOML; wrong parameters.
    pub fn parse(
        text: &'t str,
        name: &str,
        folder: &'t Path,
        set: &[(String, String)],
        given: &Arc<Given>,
    ) -> Result<Self, CaseError> {
        let start = Instant::now();
        let parsed = document::parse_with(text, set, given);
        let (document, parameters) = parsed.map_err(|fault| fault.in_source(name, text))?;
        Ok(Self {
            text,
            name: name.to_string(),
            folder,
            document,
            parameters,
            start,
        })
    }
}

const ANALYSES: [(&str, Analysis); 4] = [
    ("plane-strain", Analysis::PlaneStrain),
    ("plane-stress", Analysis::PlaneStress),
    ("axisymmetric", Analysis::Axisymmetric),
    ("3d", Analysis::Solid),
];

/// The kind of analysis of a document.
///
/// Errors: keys that no case has; an analysis that is missing or unknown.
pub(crate) fn analysis(document: &Node) -> Result<Analysis, Fault> {
    let node = document.table(keys::CASE)?.require("analysis", "a case")?;
    node.choice("analysis", &ANALYSES)
}
