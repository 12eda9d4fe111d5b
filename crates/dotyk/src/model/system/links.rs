//! Beds that only press, and bars: rows of B between bodies and small elastic parts of their own.
//!
//! Each row has a part with one stiffness, K = k, whose displacement q is what gives way:
//!
//! ```text
//!   bed       gap = −(n·u − q) ≥ 0,  λ ≥ 0      k = kₙ A         q = λ/k: pressed in
//!   bar       gap = e_a − (e − q) = 0           k = EA/L         q = (λ − P)/k: lengthened, λ = N
//!             tension only                      gap ≥ 0, λ ≥ 0
//!             yields                            −slip = gap,  −N_y ≤ λ ≤ N_y: the plastic elongation is a slip
//!             both                              0 ≤ λ ≤ N_y, and slack bars keep their slip
//!             being tightened                   no row: both ends are pulled with P
//! ```
//!
//! A bed is springs side by side, each of which parts by itself. They stand at the points of integration of the facets, of the area
//! A = weight · Jacobian: u = Σ Nₐuₐ there, and where all press they do the work of the bed that acts both ways,
//!
//! ```text
//!   Σ_q k_q (n·u)² = Σ_q kₙ A_q (n·u)² = ∫ kₙ (n·u)² dS        for every u of straight facets, with rules of degree 2 · order
//! ```
//!
//! of a line 2 points, or 3 with a middle node; 4 or 9 of a quadrilateral, 3 or 6 of a triangle: one to three times its nodes, and
//! all of positive weight. Conditions at nodes would have to share the area out among them, k = kₙ∫N: a stiffness that a side which
//! turns feels too large, by a third with one facet across a footing, by 1/n² of that with n. And with the nodal forces of
//! the whole bed, ∫NᵀCN dS u, as what must not pull, corners of curved facets would part under an even pressure, because
//! their ∫N is no more than zero.
//!
//! What a bed or a bar was there with (u_a) stands in its gaps. Bars of a plane model count as many times as there are in its
//! thickness.

use crate::contact::{Coupling, GapShares, Interface, InterfaceNode, Role, Row, frame};
use crate::dual::Block;
use crate::fem::pads;
use crate::geometry::{Point, add_scaled, norm};
use crate::model::nouns::bar::{Bar, BarSolution, BarStation};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::Model;
use crate::model::nouns::presence::Stage;
use crate::model::system::bars::{Anchor, LaidBar, lay_bars};
use crate::model::system::bodies::LoadedBody;
use crate::model::system::condition::{Condition, Elastic, Source, row_ranges};

/// The unit vector of a dof of a part.
fn axis<const D: usize>(i: usize) -> Point<D> {
    std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 })
}

/// Minus a dof of a node of a part, as a row.
fn less<const D: usize>(node: usize, dof: usize) -> Row<D> {
    vec![(node, axis::<D>(dof).map(|c| -c))]
}

/// The condition of a bed, by its body and which of its springs it is, and its part.
///
/// Errors: a side that has no points of integration.
pub(crate) fn bedded<const D: usize>(
    model: &Model<D>,
    (of, place): (usize, usize),
    part: usize,
) -> Result<Condition<D>, Error<D>> {
    let body = &model.bodies[of];
    let (side, stiffness) = body.springs[place].presses().unwrap_or_default();
    let pads = pads(body, side, model.analysis);
    let pads = pads.map_err(|source| Error::in_body(body, source))?;
    let mut interface = Interface::empty(Coupling::Normal);
    let mut elastic = Elastic::default();
    for (row, pad) in pads.into_iter().enumerate() {
        let along = |n: f64| pad.normal.map(|c| n * c);
        let own: Row<D> = pad.nodes.iter().map(|&(k, n)| (k, along(n))).collect();
        let nearest = pad.nodes.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        interface.nodes.push(InterfaceNode {
            node: nearest.map_or(0, |nearest| nearest.0),
            frame: frame(pad.normal, &[]),
            weight: pad.area,
            extent: pad.extent,
            ..carrier(row)
        });
        interface.nonmortar.push(own);
        interface.mortar.push(less(row, 0));
        elastic
            .stiffness
            .push(axis::<D>(0).map(|c| c * stiffness * pad.area));
        elastic.load.push([0.0; D]);
    }
    let name = format!("spring of {}.{side}", body.name);
    let nonmortar = SideRef {
        body: BodyId(of),
        side: side.to_string(),
    };
    Ok(Condition {
        law: Some(Block::Unilateral),
        ..linked(
            (Source::Bed(of, place), name),
            (nonmortar, part),
            interface,
            elastic,
        )
    })
}

/// A link between a body, or a side of it, and a part of its own.
fn linked<const D: usize>(
    (source, name): (Source, String),
    (nonmortar, part): (SideRef, usize),
    interface: Interface<D>,
    elastic: Elastic<D>,
) -> Condition<D> {
    let nothing = vec![0.0; interface.nonmortar.len()];
    Condition {
        opposite: Some(part),
        offset: nothing.clone(),
        came_with: nothing,
        elastic: Some(elastic),
        ..Condition::new(source, name, nonmortar, interface)
    }
}

impl<const D: usize> Bar<D> {
    /// What one of its elements can bear, of so many bars, and from where that counts.
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

    /// Its slip is a plastic elongation, which grows, and slackness is none of it.
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

/// The condition of a bar, by its place, where it lies, and its part.
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

/// What carries a row, in no place of a side.
fn carrier<const D: usize>(row: usize) -> InterfaceNode<D> {
    InterfaceNode {
        node: 0,
        opposite: Vec::new(),
        frame: std::array::from_fn(axis),
        weight: 1.0,
        extent: 0.0,
        share: 1.0,
        gap: 0.0,
        clearance: 0.0,
        shares: GapShares::default(),
        role: Role::Multiplier,
        rows: std::array::from_fn(|k| (k == 0).then_some(row)),
    }
}

/// Twice the elastic energy of a part less the work of its load, the energy, and what is left of the forces on it, under
/// forces `lambda` (m,) and displacements u.
pub(crate) fn part_balance<const D: usize>(
    part: &LoadedBody<D>,
    lambda: &[f64],
    u: &[f64],
) -> [f64; 3] {
    let mut inner = vec![0.0; u.len()];
    part.system.stiffness.mul(u, &mut inner);
    let energy = 0.5 * inner.iter().zip(u).map(|(k, u)| k * u).sum::<f64>();
    let work: f64 = part.system.load.iter().zip(u).map(|(f, u)| f * u).sum();
    let mut rest: Vec<f64> = part
        .system
        .load
        .iter()
        .zip(&inner)
        .map(|(f, k)| f - k)
        .collect();
    part.rows.add_forces(-1.0, lambda, &mut rest);
    let free = rest
        .iter()
        .zip(&part.system.held)
        .filter(|(_, held)| !**held);
    let left = free.map(|(f, _)| f * f).sum::<f64>().sqrt();
    [2.0 * energy - work, energy, left]
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
