//! `spring` of a body: beddings of sides and weak supports of points.

use crate::case::body::{no_z, side};
use crate::case::couple::Couples;
use crate::case::document::{AXES, Node, Table, later};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::mesh_file::Named;
use crate::case::points::places;
use crate::case::steps::Steps;
use crate::case::suggest::listed;
use crate::fem::show;
use crate::geometry::{Field, Point, centroid};
use crate::mesh::Mesh;
use crate::model::{Bed, Spring};

/// A spring: one at each point of a name.
pub(crate) fn springs<const D: usize>(
    node: &Node,
    couples: &mut Couples<'_, D>,
    mesh: &mut Mesh<D>,
    points: &Named<D>,
    steps: &Steps,
) -> Result<Vec<Spring<D>>, Fault> {
    let table = node.table(keys::SPRING)?;
    let active = steps.active(table)?;
    let body = couples.body;
    no_z::<D>(table)?;
    let beds = match (table.get("side"), table.get("point")) {
        (Some(node), None) => {
            let side = side(node, body, mesh)?;
            vec![of_side(table, &side, mesh)?]
        }
        (None, Some(node)) => {
            if couples.of_point(Some(node)).is_some() {
                return Err(later(&node.span, "a spring at the point of a couple"));
            }
            let places = places(node, body, points)?.into_iter();
            let bed = |point| {
                let stiffness = of_point(table, point)?;
                Ok(Bed::Point { point, stiffness })
            };
            places.map(bed).collect::<Result<_, Fault>>()?
        }
        (Some(_), Some(node)) => {
            let message = format!("a spring of body `{body}` has both `side` and `point`");
            return Err(Fault::new(&node.span, message).label("give one of the two"));
        }
        (None, None) => {
            let message = format!("a spring of body `{body}` needs `side` or `point`");
            return Err(Fault::new(table.span, message).label("neither `side` nor `point`"));
        }
    };
    let springs = beds.into_iter().map(|bed| Spring { bed, active });
    Ok(springs.collect())
}

/// A stiffness by place, from 0 on at these; 0 where it is not given.
fn stiffness<const D: usize>(
    table: Table<'_>,
    key: &str,
    places: impl IntoIterator<Item = Point<D>>,
) -> Result<Field, Fault> {
    let Some(node) = table.get(key) else {
        return Ok(Field::constant(0.0));
    };
    let name = format!("the stiffness `{key}` of a spring");
    let field = node.stiffness(&name)?;
    if field.as_constant().is_some() || field.is_sampled() {
        return Ok(field);
    }
    for place in places {
        let value = field.at(place, 0.0);
        if !(value >= 0.0 && value.is_finite()) {
            let message = format!("{name} is {value} at {}", show(place));
            return Err(Fault::new(&node.span, message)
                .label("not a number from 0 on there")
                .help("use max(..., 0) where there shall be no spring"));
        }
    }
    Ok(field)
}

/// Refuses keys of the other kind of springs.
fn refuse(table: Table<'_>, keys: &[&str], help: &str) -> Result<(), Fault> {
    match keys.iter().find_map(|key| table.entry(key)) {
        Some(entry) => {
            let message = format!("this spring has no `{}`", entry.key);
            Err(Fault::new(&entry.key_span, message)
                .label("superfluous")
                .help(help.to_string()))
        }
        None => Ok(()),
    }
}

fn soft(table: Table<'_>, keys: String) -> Fault {
    Fault::new(table.span, "a spring without a stiffness")
        .label("it holds nothing")
        .help(format!("add {keys}"))
}

fn of_side<const D: usize>(table: Table<'_>, side: &str, mesh: &Mesh<D>) -> Result<Bed<D>, Fault> {
    let help = "a spring on a side has `normal` and `tangential`, force per area and displacement";
    refuse(table, &AXES, help)?;
    // nodes may lie where an expression has no value, and points of integration do not
    let facets = mesh.side(side).unwrap_or_default();
    let centres = || {
        let points = facets.iter().map(|facet| mesh.facet_points(*facet));
        points.map(|points| centroid(&points.collect::<Vec<_>>()))
    };
    let [normal, tangential] = ["normal", "tangential"].map(|key| stiffness(table, key, centres()));
    let (normal, tangential) = (normal?, tangential?);
    let none = |field: &Field| field.as_constant() == Some(0.0);
    if none(&normal) && none(&tangential) {
        return Err(soft(table, "`normal` or `tangential`".to_string()));
    }
    let only = table.entry("compression_only");
    let compression_only = only.map_or(Ok(false), |entry| entry.node.boolean())?;
    if let (true, Some(entry)) = (compression_only && none(&normal), only) {
        let message = "`compression_only` is of the stiffness along the normal";
        return Err(Fault::new(&entry.key_span, message).label("no `normal`"));
    }
    Ok(Bed::Side {
        side: side.to_string(),
        normal,
        tangential,
        compression_only,
    })
}

fn of_point<const D: usize>(table: Table<'_>, point: Point<D>) -> Result<[f64; D], Fault> {
    let of_side = ["normal", "tangential", "compression_only"];
    let axes = listed(AXES[..D].iter().copied());
    let help = format!("a spring at a point has {axes}, force per displacement");
    refuse(table, &of_side, &help)?;
    let mut values = [0.0; D];
    for (value, axis) in values.iter_mut().zip(AXES) {
        *value = stiffness(table, axis, [point])?.at(point, f64::NAN);
    }
    match values.iter().all(|&k| k == 0.0) {
        true => Err(soft(table, axes)),
        false => Ok(values),
    }
}
