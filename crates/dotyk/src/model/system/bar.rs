//! Bars as links, one for each of their elements.
//!
//! ```text
//!   a bar                  gap = e_a − (e − q) = 0      k = EA/L       q = (λ − P)/k: lengthened, λ = N
//!   tension only           gap ≥ 0, λ ≥ 0
//!   yields                 −slip = gap,  −N_y ≤ λ ≤ N_y: the plastic elongation is a slip
//!   both                   0 ≤ λ ≤ N_y, and slack bars keep their slip
//!   being tightened        no row: both ends are pulled with P
//! ```
//!
//! Bars of a plane model count as many times as there are in its thickness.

use crate::contact::{Coupling, Interface, InterfaceNode, Row, frame};
use crate::dual::Block;
use crate::geometry::{add_scaled, norm};
use crate::model::nouns::bar::{Bar, BarSolution, BarStation};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::presence::Stage;
use crate::model::system::condition::{Condition, Elastic, Source, row_ranges};
use crate::model::system::laid::{Anchor, LaidBar, lay_bars};
use crate::model::system::links::{axis, carrier, less, linked};

impl<const D: usize> Bar<D> {
    /// The block of one of its elements for `count` bars, and the force from which its λ counts.
    pub(crate) fn law(&self, count: f64) -> (Block, f64) {
        let half = |most: f64| 0.5 * count * most;
        match (self.strength(), self.tension_only) {
            (None, false) => (Block::Free { size: 1 }, 0.0),
            (None, true) => (Block::Unilateral, 0.0),
            (Some(most), false) => (
                Block::Interval {
                    bound: count * most,
                },
                0.0,
            ),
            (Some(most), true) => (Block::Interval { bound: half(most) }, half(most)),
        }
    }

    /// Its slip is a plastic elongation, which only grows; slackness is not part of it.
    pub(crate) fn slackens(&self) -> bool {
        self.tension_only && self.yields.is_some()
    }
}

/// Rows of the elements of a bar on one body.
fn rows_on<const D: usize>(laid: &LaidBar<D>, body: usize) -> Vec<Row<D>> {
    let row = |[from, to]: [&Anchor<D>; 2]| {
        let mut row: Row<D> = Vec::new();
        for (anchor, sign) in [(from, -1.0), (to, 1.0)] {
            for &(node, n) in anchor.nodes.iter().filter(|_| anchor.body == body) {
                let pull = laid.along.map(|c| sign * n * c);
                match row.iter_mut().find(|entry| entry.0 == node) {
                    Some((_, sum)) => *sum = add_scaled(*sum, 1.0, pull),
                    None => row.push((node, pull)),
                }
            }
        }
        row
    };
    laid.elements().map(row).collect()
}

/// The condition of a bar from its place in the model, its laid-out points, and its part.
pub(crate) fn barred<const D: usize>(
    stage: &Stage<'_, D>,
    (place, laid): (usize, &LaidBar<D>),
    part: usize,
) -> Condition<D> {
    let (bar, tightening) = (&stage.model.bars[place], stage.tightening[place]);
    let mut bodies: Vec<usize> = laid.anchors.iter().map(|anchor| anchor.body).collect();
    bodies.sort_unstable();
    bodies.dedup();
    let prestress = laid.count * bar.prestress.unwrap_or(0.0);
    let mut elastic = Elastic::default();
    for [from, to] in laid.elements() {
        let length = laid.length_to(to.point) - laid.length_to(from.point);
        let k = laid.count * bar.young * bar.area / length;
        elastic.stiffness.push(axis::<D>(0).map(|c| c * k));
        elastic.load.push(axis::<D>(0).map(|c| -c * prestress));
    }
    let mut of_bodies: Vec<(usize, Vec<Row<D>>)> = bodies
        .iter()
        .map(|&body| (body, rows_on(laid, body)))
        .collect();
    let mut steady = Vec::new();
    if tightening {
        for (body, rows) in &of_bodies {
            let pulls = rows.iter().flatten();
            let pulls = pulls.map(|&(node, c)| (*body, node, c.map(|c| -prestress * c)));
            steady.extend(pulls);
        }
        of_bodies.iter_mut().for_each(|(_, rows)| rows.clear());
    }
    let (block, offset) = bar.law(laid.count);
    let mut interface = Interface::empty(match block.is_free() || tightening {
        true => Coupling::Tied,
        false => Coupling::Normal,
    });
    let mut of_bodies = of_bodies.into_iter();
    let (body, rows) = of_bodies.next().unwrap_or_default();
    let mut places = Vec::new();
    for (row, (element, [from, to])) in rows.iter().zip(laid.elements().enumerate()) {
        let most = row.iter().max_by(|a, b| norm(a.1).total_cmp(&norm(b.1)));
        interface.nodes.push(InterfaceNode {
            node: most.map_or(0, |&(node, _)| node),
            frame: frame(laid.along, &[]),
            ..carrier(element)
        });
        interface.mortar.push(less(element, 0));
        places.push(add_scaled(from.point.map(|c| 0.5 * c), 0.5, to.point));
    }
    interface.nonmortar = rows;
    let end = SideRef {
        body: BodyId(body),
        side: String::new(),
    };
    let offset = vec![offset; interface.nonmortar.len()];
    let source = (Source::Bar(place), bar.name.clone());
    Condition {
        law: Some(block),
        offset,
        further: of_bodies.collect(),
        steady,
        places,
        ..linked(source, (end, part), interface, elastic)
    }
}

/// Forces of all bars under forces `lambda` (m,).
///
/// Errors: bars that cannot be laid.
pub(crate) fn bar_solutions<const D: usize>(
    stage: &Stage<'_, D>,
    conditions: &[Condition<D>],
    lambda: &[f64],
) -> Result<Vec<BarSolution<D>>, Error<D>> {
    let model = stage.model.as_ref();
    let laid = lay_bars(model)?;
    let solved = row_ranges(conditions).filter_map(|(rows, condition)| {
        let Source::Bar(place) = condition.source else {
            return None;
        };
        let (bar, laid) = (&model.bars[place], &laid[place]);
        let forces = condition.forces(&lambda[rows]);
        let along: Vec<f64> = forces.iter().map(|force| force / laid.count).collect();
        let stations = laid.elements().enumerate().map(|(element, [from, to])| {
            let middle = add_scaled(from.point.map(|c| 0.5 * c), 0.5, to.point);
            let own = along.get(element).copied();
            BarStation {
                s: laid.length_to(middle),
                point: middle,
                length: laid.length_to(to.point) - laid.length_to(from.point),
                force: own.or(bar.prestress).unwrap_or(0.0),
            }
        });
        let last = laid
            .anchors
            .last()
            .map_or(0.0, |end| laid.length_to(end.point));
        Some(BarSolution {
            name: bar.name.clone(),
            length: last,
            stations: stations.collect(),
            tightening: stage.tightening[place],
        })
    });
    Ok(solved.collect())
}
