//! `couple` of a body: the reference points of its sides, and the supports and loads that name these points.

use crate::case::document::{AXES, Entry, Node, Table, Value, coordinates};
use crate::case::error::Fault;
use crate::case::mesh_file::Named;
use crate::case::points::places;
use crate::case::suggest::listed;
use crate::geometry::Field;
use crate::model::{Active, Analysis, Couple, CoupleKind};

const KINDS: [(&str, CoupleKind); 2] = [
    ("rigid", CoupleKind::Rigid),
    ("average", CoupleKind::Average),
];

/// The couples of a body so far, and the motions of its analysis.
pub(crate) struct Couples<'a, const D: usize> {
    pub body: &'a str,
    pub axial: bool,
    pub list: Vec<Couple<D>>,
}

impl<'a, const D: usize> Couples<'a, D> {
    pub fn new(body: &'a str, analysis: Analysis) -> Self {
        Self {
            body,
            axial: analysis == Analysis::Axisymmetric,
            list: Vec::new(),
        }
    }

    /// Adds a couple of a side.
    pub fn add(&mut self, table: Table<'_>, side: &str, points: &Named<D>) -> Result<(), Fault> {
        let node = table.require("point", "a couple")?;
        let Value::Text(name) = &node.value else {
            return Err(node.expected("the name of a point").help(format!(
                "write `points = {{ NAME = {} }}` in the body and the name here",
                coordinates::<D>()
            )));
        };
        let place = places(node, self.body, points)?;
        let [point] = place[..] else {
            let message = format!(
                "`{name}` of body `{}` are {} points",
                self.body,
                place.len()
            );
            return Err(Fault::new(&node.span, message).label("one is needed"));
        };
        if self.list.iter().any(|couple| couple.name == *name) {
            let message = format!(
                "two couples of body `{}` have the point `{name}`",
                self.body
            );
            return Err(Fault::new(&node.span, message)
                .label("second couple")
                .help("a point moves with one side: give both sides as a list, or name a second point at the same place"));
        }
        let kind = table.require("kind", "a couple")?;
        let kind = kind.choice("kind of couple", &KINDS)?;
        self.list.push(Couple::new(name, point, side, kind));
        Ok(())
    }

    /// The couple whose point a support or load names.
    pub fn of_point(&mut self, node: Option<&Node>) -> Option<&mut Couple<D>> {
        match &node?.value {
            Value::Text(name) => self.list.iter_mut().find(|couple| couple.name == *name),
            _ => None,
        }
    }

    /// Adds the values of a support to the couple whose point it names; `false` if it names no such point.
    pub fn hold(&mut self, table: Table<'_>) -> Result<bool, Fault> {
        let axial = self.axial;
        let Some(couple) = self.of_point(table.get("point")) else {
            return match table.entry("rotation") {
                Some(entry) => Err(self.not_coupled(entry)),
                None => Ok(false),
            };
        };
        let Couple {
            name,
            displacement,
            rotation,
            ..
        } = couple;
        let take = |entry: &Entry, held: &mut Option<Field>| {
            let (key, field) = (&entry.key, entry.node.field()?);
            if held.replace(field).is_some() {
                let message = format!("`{key}` of the point `{name}` is prescribed twice");
                return Err(Fault::new(&entry.key_span, message).label("second time"));
            }
            Ok(())
        };
        for (key, held) in AXES.into_iter().zip(displacement) {
            let Some(entry) = table.entry(key) else {
                continue;
            };
            take(entry, held)?;
            if axial && key == "x" && held.as_ref().and_then(Field::as_constant) != Some(0.0) {
                return Err(not_axial(entry));
            }
        }
        match table.entry("rotation") {
            Some(entry) if axial => return Err(not_axial(entry)),
            Some(entry) if D == 2 => take(entry, &mut rotation[2])?,
            Some(entry) => {
                let about = entry.node.table(&AXES)?;
                if about.present().is_empty() {
                    let message = "`rotation` prescribes nothing";
                    return Err(Fault::new(&entry.node.span, message).label("no axis").help(
                        "write the axes that it is held about: `rotation = { x = 0.0, z = 0.0 }`",
                    ));
                }
                for (axis, held) in AXES.into_iter().zip(rotation) {
                    about
                        .entry(axis)
                        .map_or(Ok(()), |entry| take(entry, held))?;
                }
            }
            None => {}
        }
        Ok(true)
    }

    /// Adds a load to the couple whose point it names; `false` if it names no such point.
    pub fn load(&mut self, table: Table<'_>, active: Active) -> Result<bool, Fault> {
        let axial = self.axial;
        let Some(couple) = self.of_point(table.get("point")) else {
            return match table.entry("moment") {
                Some(entry) => Err(self.not_coupled(entry)),
                None => Ok(false),
            };
        };
        let known = ["point", "force", "moment"];
        if let Some(entry) = table.first_but(&known) {
            let message = format!("a load at a coupled point has no `{}`", entry.key);
            return Err(Fault::new(&entry.key_span, message)
                .label("superfluous")
                .help(format!("its keys are {}", listed(known))));
        }
        let (force, moment) = (table.entry("force"), table.entry("moment"));
        if force.is_none() && moment.is_none() {
            let message = format!(
                "a load at the point `{}` needs `force` or `moment`",
                couple.name
            );
            return Err(Fault::new(table.span, message).label("neither `force` nor `moment`"));
        }
        if let Some(entry) = force {
            let given: [Field; D] = entry.node.fields()?;
            if axial && given[0].as_constant() != Some(0.0) {
                return Err(not_axial(entry));
            }
            for (sum, field) in couple.force.iter_mut().zip(given) {
                *sum = sum.clone() + active.gate(field);
            }
        }
        if let Some(entry) = moment {
            if axial {
                return Err(not_axial(entry));
            }
            let given = match D {
                2 => [
                    Field::constant(0.0),
                    Field::constant(0.0),
                    entry.node.field()?,
                ],
                _ => entry.node.fields()?,
            };
            for (sum, field) in couple.moment.iter_mut().zip(given) {
                *sum = sum.clone() + active.gate(field);
            }
        }
        Ok(true)
    }

    /// The error for keys that only the point of a couple has.
    fn not_coupled(&self, entry: &Entry) -> Fault {
        let message = format!("`{}` only for a coupled point", entry.key);
        let names = self.list.iter().map(|couple| couple.name.as_str());
        Fault::new(&entry.key_span, message)
            .label("what it names does not turn")
            .help(match self.list.len() {
                0 => format!(
                    "give body `{}` a couple, such as `couple = [{{ side = \"SIDE\", point = \"NAME\", kind = \"rigid\" }}]`",
                    self.body
                ),
                _ => format!("coupled points of body `{}`: {}", self.body, listed(names)),
            })
    }
}

fn not_axial(entry: &Entry) -> Fault {
    let message = "with axial symmetry a coupled point only moves along the axis";
    Fault::new(&entry.key_span, message)
        .label(format!("`{}` has no meaning here", entry.key))
        .help("hold and load it along y")
}
