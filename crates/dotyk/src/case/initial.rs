//! `initial_stress` and `initial_strain` of a body.

use crate::case::document::{Node, Table, Value};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::suggest::listed;
use crate::geometry::{Field, Point, dot, padded, unit};
use crate::model::{Analysis, COMPONENTS, Components, Initial};

/// Initial state of a body.
pub(crate) fn initial<const D: usize>(
    body: Table<'_>,
    analysis: Analysis,
) -> Result<Initial, Fault> {
    let nodes = ["initial_stress", "initial_strain"].map(|key| body.get(key));
    let [stress, strain] = nodes;
    let stress = stress.map(|node| self::stress::<D>(node, analysis));
    let (stress, vertical) = stress.transpose()?.unzip();
    let pore = body.get("pore_pressure");
    let initial = Initial {
        stress,
        pore: None,
        strain: strain.map(self::strain).transpose()?,
        vertical: vertical.flatten(),
    };
    // each separately, to find out which one
    let alone = [
        Initial {
            strain: None,
            ..initial.clone()
        },
        Initial {
            stress: None,
            vertical: None,
            ..initial.clone()
        },
    ];
    for (node, initial) in nodes.into_iter().zip(alone) {
        if let (Some(node), Some(why)) = (node, initial.unfit(analysis)) {
            return Err(Fault::new(&node.span, why).label("not in this analysis"));
        }
    }
    let Some(node) = pore else {
        return Ok(initial);
    };
    let initial = initial.with_pores(pressure::<D>(node)?);
    match initial.unfit(analysis) {
        Some(why) => Err(Fault::new(&node.span, why).label("not in this analysis")),
        None => Ok(initial),
    }
}

/// The pressure of water in pores: a value, or that of water at rest below a level.
fn pressure<const D: usize>(node: &Node) -> Result<Field, Fault> {
    let Value::Table(_) = node.value else {
        return node.field();
    };
    let table = node.table(keys::PORE_PRESSURE)?;
    let what = "a pore pressure below a level";
    let level = table.require("level", what)?.field()?;
    let weight = table.require("weight", what)?.positive("`weight`")?;
    let up: Point<D> = match table.get("direction") {
        None => std::array::from_fn(|axis| f64::from(u8::from(axis == D - 1))),
        Some(node) => unit(node.point()?).ok_or_else(|| {
            Fault::new(&node.span, "the direction upwards has no length")
                .label("all components are zero")
        })?,
    };
    let up = padded(up);
    let height = Field::function("height", move |x, _| dot(x, up));
    let head = level + Field::constant(-1.0) * height;
    Ok((Field::constant(weight) * head).at_least(0.0))
}

/// Components, or the vertical stress with its direction and the part of it that acts across.
fn stress<const D: usize>(
    node: &Node,
    analysis: Analysis,
) -> Result<(Components, Option<[f64; 3]>), Fault> {
    let table = node.table(keys::INITIAL_STRESS)?;
    let ways = [&["vertical", "k0", "direction"][..], &COMPONENTS];
    let words = "a stress is `vertical` with `k0`, or components: `xx`, `yy`, `zz`, `xy` (tension positive)";
    one_of(table, &ways, words)?;
    if ways[0].iter().all(|key| table.get(key).is_none()) {
        return Ok((components(table)?, None));
    }
    let vertical = table
        .require("vertical", "an initial stress with `k0` or `direction`")?
        .field()?;
    let k0 = table.get("k0").ok_or_else(|| {
        let message = "an initial stress with `vertical` needs the key `k0`";
        Fault::new(table.span, message)
            .label("`k0` is missing")
            .help("the horizontal stress over the vertical one, such as `k0 = 0.6`; one number, or two for the two directions")
    })?;
    let [first, second] = match &k0.value {
        Value::List(_) => k0.fields::<2>()?,
        // in plane stress there is no stress across
        _ if analysis == Analysis::PlaneStress => [k0.field()?, Field::constant(0.0)],
        _ => [k0.field()?, k0.field()?],
    };
    let direction = match table.get("direction") {
        None => std::array::from_fn(|axis| f64::from(axis == D - 1)),
        Some(node) => {
            let direction: Point<D> = node.point()?;
            let direction = unit(direction).ok_or_else(|| {
                Fault::new(&node.span, "the direction of the vertical has no length")
                    .label("all components are zero")
                    .help("such as `direction = [0, 1, 0]` where the vertical is along y")
            });
            direction?
        }
    };
    let stress = Components::ground(direction, vertical, [first, second]);
    Ok((stress, Some(padded(direction))))
}

/// Warnings about bodies that are profiles extruded along z, the default vertical of their stress, and have no weight that would
/// confirm it: most such profiles are those of tunnels.
pub(crate) fn along_profiles(document: &Node) -> Vec<String> {
    fn at<'n>(node: &'n Node, key: &str) -> Option<&'n Node> {
        let mut entries = node.entries().ok()?.iter();
        entries.find(|e| e.key == key).map(|e| &e.node)
    }
    let bodies = at(document, "body").and_then(|list| list.list().ok());
    let told = bodies.unwrap_or_default().iter().filter_map(|body| {
        at(at(at(body, "mesh")?, "extrude")?, "height")?;
        let stress = at(body, "initial_stress")?;
        at(stress, "vertical")?;
        let open = at(stress, "direction").is_none() && at(body, "body_force").is_none();
        let name = at(body, "name")?.text().ok()?;
        open.then(|| {
            format!("body \"{name}\": the vertical of its initial stress is z, along which its profile is extruded; name it, `direction = [0, 1, 0]` for a tunnel along z and [0, 0, 1] for a shaft")
        })
    });
    told.collect()
}

/// A temperature with its coefficient, an isotropic strain, or components.
fn strain(node: &Node) -> Result<Components, Fault> {
    let table = node.table(keys::INITIAL_STRAIN)?;
    let ways = [&["thermal", "expansion"][..], &["isotropic"], &COMPONENTS];
    let words = "a strain is `thermal` (a change of temperature) with `expansion`, `isotropic`, or components: `xx`, `yy`, `zz`, `xy`";
    one_of(table, &ways, words)?;
    let what = "an initial strain of a temperature";
    match (
        table.get("thermal"),
        table.get("expansion"),
        table.get("isotropic"),
    ) {
        (None, None, None) => components(table),
        (_, _, Some(strain)) => Ok(Components::isotropic(strain.field()?)),
        _ => {
            let change = table.require("thermal", what)?.field()?;
            let expansion = table.require("expansion", what)?.number()?;
            Ok(Components::isotropic(Field::constant(expansion) * change))
        }
    }
}

/// Refuses missing keys, and keys of more than one of the ways to give a value, which `words` name.
fn one_of(table: Table<'_>, ways: &[&[&str]], words: &str) -> Result<(), Fault> {
    let used = |way: &&&[&str]| way.iter().any(|key| table.get(key).is_some());
    if ways.iter().filter(used).count() == 1 {
        return Ok(());
    }
    let found = match table.present() {
        none if none.is_empty() => "nothing is given".to_string(),
        keys => format!("{} do not go together", listed(keys)),
    };
    Err(Fault::new(table.span, found)
        .label("give it in one way")
        .help(words))
}

/// Components that are not given are zero.
fn components(table: Table<'_>) -> Result<Components, Fault> {
    let mut fields = [(); 6].map(|()| Field::constant(0.0));
    for (field, key) in fields.iter_mut().zip(COMPONENTS) {
        if let Some(node) = table.get(key) {
            *field = node.field()?;
        }
    }
    Ok(Components(fields))
}
