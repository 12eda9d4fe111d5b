//! Anchors of a case file: bars that are free over a length behind their head, and grouted over the rest.
//!
//! Such a bar is a bar between its head and the place where the bond begins, and a grouted one from there on. Both end at the same point of
//! a body, so that they are one chain of elements, free element first. The prestress is that of the free length: the bond is there before,
//! bears it, and lets it into the ground.

use crate::case::document::{Entry, Table};
use crate::case::error::Fault;
use crate::fem::{Short, show};
use crate::geometry::{Point, add_scaled, distance, sub};
use crate::mesh::locate;
use crate::model::{Analysis, Body, Bond, Member, MemberEnd, MemberKind};

/// Names of the bond.
const BOND: &str = "-bond";

/// The free and the bonded part are at least this part of the whole bar.
const LEAST: f64 = 1e-6;

/// The place where the bond of a bar begins; `None` where no length is given.
///
/// Errors: both lengths, or one that leaves nothing of the other; a bar that is not grouted; a place in none of its bodies.
pub(crate) fn bond_length<const D: usize>(
    table: Table<'_>,
    member: &Member<D>,
    (bodies, analysis): (&[Body<D>], Analysis),
) -> Result<Option<Point<D>>, Fault> {
    let entries = ["free_length", "bond_length"].map(|key| table.entry(key));
    let (entry, free) = match entries {
        [None, None] => return Ok(None),
        [Some(entry), None] => (entry, true),
        [None, Some(entry)] => (entry, false),
        [Some(_), Some(entry)] => {
            let message = "the length of the bar is that of the free and of the bonded part";
            return Err(Fault::new(&entry.key_span, message).label("give one of the two"));
        }
    };
    let given = entry.node.positive(&format!("`{}`", entry.key))?;
    if member.line.bond != Bond::Grouted {
        let message = format!("`{}` is of a bar that is grouted", entry.key);
        return Err(Fault::new(&entry.key_span, message)
            .label("not grouted")
            .help("add `bond = \"grouted\"`"));
    }
    if let (MemberEnd::Side(_), Some(entry)) = (&member.line.ends[0], table.entry("radius")) {
        let message = "`radius` is that of the plate of an anchor at its head, which is at a side";
        return Err(Fault::new(&entry.key_span, message).label("superfluous"));
    }
    let place = |end| {
        let place = member.line.place(bodies, analysis, end);
        place.map_err(|error| Fault::new(table.span, error.to_string()).label(error.label))
    };
    let (from, to) = (place(0)?, place(1)?);
    let whole = distance(from, to);
    if given.min(whole - given) <= LEAST * whole {
        let message = format!(
            "its {} is {given}, and the bar is {} long",
            words(entry),
            Short(whole)
        );
        return Err(Fault::new(&entry.node.span, message).label(
            match (free, given < whole / 2.0) {
                (true, false) | (false, true) => "nothing is left to bond",
                (false, false) | (true, true) => "nothing is left free: leave it out",
            },
        ));
    }
    let share = if free { given } else { whole - given } / whole;
    let start = add_scaled(from, share, sub(to, from));
    let mut inside = member.line.bodies.iter();
    match inside.any(|id| locate(&bodies[id.0].mesh, start).is_some()) {
        true => Ok(Some(start)),
        false => {
            let message = format!("its bond begins at {}, in none of its bodies", show(start));
            Err(Fault::new(&entry.node.span, message).label("outside of them"))
        }
    }
}

fn words(entry: &Entry) -> String {
    entry.key.replace('_', " ")
}

/// The free part of a bar, and its bond, which begins at a place and has a name of its own.
pub(crate) fn parts<const D: usize>(whole: Member<D>, start: Point<D>) -> [Member<D>; 2] {
    let (mut free, mut bond) = (whole.clone(), whole);
    free.line.ends[1] = MemberEnd::Point(start);
    free.line.bond = Bond::Ends;
    free.line.radius[1] = None;
    bond.name.push_str(BOND);
    bond.line.ends[0] = MemberEnd::Point(start);
    bond.line.radius = [None; 2];
    if let MemberKind::Bar(law) = &mut bond.kind {
        law.prestress = None;
    }
    [free, bond]
}
