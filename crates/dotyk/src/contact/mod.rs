//! Interfaces: from two sides to rows B, initial gaps g₀ and weights, so that
//!
//! ```text
//!   gap = g₀ − B u ≥ 0,     (B u)ᵢ = ∫ψᵢ n·(u_nonmortar − u_mortar) / ∫ψᵢ,     pressure = λ / weight,  weight = ∫ψᵢ
//! ```
//!
//! n is the outward normal of the nonmortar side. λ is a force, the gap a length, the weight an area. Node-to-node
//! pairing is the same with the integrals replaced by values at nodes. Tangential rows, one in the plane and two in space, have
//! t instead of n and no gap.
//! An interface knows the two meshes and the directions held by their supports, but no stiffness.

mod corners;
mod couple;
mod curved;
mod error;
mod exclude;
mod facing;
mod found;
mod functions;
mod gaps;
mod lever;
mod mortar;
mod node_to_node;
mod normals;
mod obstacle;
mod opposite;
mod pieces;
mod polygons;
mod relative;
mod sampling;
mod search;
mod sectors;
mod share;
mod sheets;
mod tool;
mod weights;

pub use corners::{Corners, corners_above, is_pointed, smooth_parts};
pub use couple::pair_couple;
pub(crate) use curved::missed_by_nodes;
pub use curved::straight_turn;
pub use error::ContactError;
pub use facing::{facets_coincide, unmatched_facing};
pub use found::{Faced, Neighbours, Sight, taking_part};
pub use gaps::{GapPoint, GapShares, Moved};
pub use mortar::pair_mortar;
pub use node_to_node::{pair_nodes, pair_obstacle};
pub use obstacle::{Driven, Rigid};
pub use relative::frame;
pub use sampling::{Sample, samples};
pub(crate) use sectors::check_sectors;
pub use tool::Tool;
pub use weights::nodal_weights;

use crate::fem::{Body, Constraints, side_facets};
use crate::geometry::{Field, Point, add_scaled, cross, dot, sub};
use crate::mesh::Facet;
use std::any::Any;

/// Which components of the displacement jump an interface couples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// The normal one.
    Normal,
    /// The normal one, and with it the tangential ones.
    Frictional,
    /// All, each by itself.
    Tied,
}

/// One end of an interface: a side of a body, with the directions held by the body's supports.
#[derive(Clone, Copy)]
pub struct End<'a, const D: usize> {
    /// The body.
    pub body: &'a Body<D>,
    /// Name of the side.
    pub side: &'a str,
    /// Held directions of the body's nodes.
    pub constraints: &'a Constraints<D>,
    /// Only these facets of the side.
    pub part: Option<&'a [Facet]>,
}

impl<'a, const D: usize> End<'a, D> {
    /// `body.side`, as in the case file.
    pub fn name(&self) -> String {
        format!("{}.{}", self.body.name, self.side)
    }

    /// Its facets; an error when the side is unknown or empty.
    pub fn facets(&self) -> Result<&'a [Facet], ContactError> {
        if let Some(part) = self.part {
            return Ok(part);
        }
        side_facets(&self.body.mesh, self.side).map_err(|source| ContactError::Side {
            body: self.body.name.clone(),
            source,
        })
    }

    /// The same end as one of a body of E dimensions; `None` where D is not E.
    pub(crate) fn of_dimension<const E: usize>(self) -> Option<End<'a, E>> {
        Some(End {
            body: same(self.body)?,
            side: self.side,
            constraints: same(self.constraints)?,
            part: self.part,
        })
    }
}

/// A value of D dimensions as one of E dimensions, if these are the same.
fn same<T: Any, P: Any>(thing: &T) -> Option<&P> {
    (thing as &dyn Any).downcast_ref()
}

/// The opposite of a nonmortar side.
#[derive(Clone, Copy)]
pub enum Against<'a, const D: usize> {
    /// A side of another body.
    Side(End<'a, D>),
    /// A rigid obstacle.
    Obstacle(&'a Rigid<D>, Driven),
}

impl<'a, const D: usize> Against<'a, D> {
    /// The same, a tool as a side.
    fn paired(self) -> Self {
        match self {
            Self::Obstacle(Rigid::Tool(tool), driven) => Self::Side(tool.end(driven)),
            other => other,
        }
    }

    /// The same as one of E dimensions; `None` where D is not E.
    pub(crate) fn of_dimension<const E: usize>(self) -> Option<Against<'a, E>> {
        Some(match self {
            Self::Side(end) => Against::Side(end.of_dimension()?),
            Self::Obstacle(rigid, driven) => Against::Obstacle(same(rigid)?, driven),
        })
    }
}

/// The initial gap of node pairs.
#[derive(Clone, Copy)]
pub enum InitialGap<'a> {
    /// Measured between the nodes along the normal.
    Measured,
    /// Measured, zero where it is at most this length.
    Adjusted(f64),
    /// Zero.
    Closed,
    /// Given at the undeformed nonmortar point.
    Given(&'a Field),
}

/// Role of a node of the nonmortar side in the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It carries multipliers.
    Multiplier,
    /// Nothing is opposite.
    Alone,
    /// It is excluded.
    Excluded,
    /// Its displacement is prescribed (node-to-node: on both sides), or its condition follows from others.
    Fixed,
}

/// A node of the nonmortar side.
#[derive(Debug, Clone, PartialEq)]
pub struct InterfaceNode<const D: usize> {
    /// Node of the nonmortar mesh.
    pub node: usize,
    /// Nodes of the mortar mesh and their shape functions at the point opposite; empty without such a point.
    pub opposite: Vec<(usize, f64)>,
    /// The unit vectors of its rows: the outward normal, projected onto the directions that the supports leave free, then the
    /// tangents.
    pub frame: [Point<D>; D],
    /// ∫ψ: an area, times thickness or 2πr.
    pub weight: f64,
    /// The part of the side that belongs to the multiplier: a length (in space an area) without thickness or 2πr.
    pub extent: f64,
    /// The part of its surroundings that faces the other side, ∫ of its hat there over that of the whole.
    pub share: f64,
    /// Initial gap, ∫ψ s/∫ψ; NaN where nothing is opposite.
    pub gap: f64,
    /// Initial gap at the node itself: between the surfaces, or as given. NaN where nothing is opposite.
    pub clearance: f64,
    /// Their weights in the points of the interface.
    pub shares: GapShares,
    /// Its role in the interface.
    pub role: Role,
    /// Rows of its multipliers: normal, then tangential.
    pub rows: [Option<usize>; D],
}

/// If less than this part of a node's surroundings faces the other side, its force belongs to a sliver of its facets, and its pressure
/// may be much larger or smaller than those beside it.
const SLIVER: f64 = 0.1;

impl<const D: usize> InterfaceNode<D> {
    /// It carries a multiplier for only a sliver of its facets.
    pub fn is_sliver(&self) -> bool {
        self.role == Role::Multiplier && self.share < SLIVER
    }

    /// Outward unit normal.
    pub fn normal(&self) -> Point<D> {
        self.frame[0]
    }

    /// The coincident node of the mortar mesh.
    pub fn partner(&self) -> Option<usize> {
        match self.opposite[..] {
            [(node, _)] => Some(node),
            _ => None,
        }
    }
}

/// A row of B: coefficients of global displacement vectors at nodes.
pub type Row<const D: usize> = Vec<(usize, Point<D>)>;

/// Two sides, or a side and an obstacle, ready for condensation.
#[derive(Debug, Clone, PartialEq)]
pub struct Interface<const D: usize> {
    /// Nodes of the nonmortar side in its order: along its chain, in space ascending.
    pub nodes: Vec<InterfaceNode<D>>,
    /// The chain closes on itself.
    pub cyclic: bool,
    /// The coupled components.
    pub coupling: Coupling,
    /// Row of every multiplier on the nonmortar body.
    pub nonmortar: Vec<Row<D>>,
    /// Row of every multiplier on the mortar body (sign included); of an obstacle, on its translation (node 0).
    pub mortar: Vec<Row<D>>,
    /// Points at which gaps are taken.
    pub points: Vec<GapPoint<D>>,
    /// Conditions that others imply.
    pub implied: Vec<Implied<D>>,
    /// Check of the integrated pieces by independent points: the number of points that face the other side but lie in no piece, and of
    /// all that face it.
    pub missed: [usize; 2],
    /// Nodes whose shear along a direction held on both sides is borne by no node: see `relative.rs`.
    pub unborne: usize,
}

/// A condition without a multiplier, because others imply it. It is judged all the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Implied<const D: usize> {
    /// Place of its node in [`Interface::nodes`].
    pub node: usize,
    /// 0: normal, else tangential.
    pub component: usize,
    /// Its rows on the nonmortar and on the mortar body.
    pub rows: [Row<D>; 2],
}

impl<const D: usize> Interface<D> {
    /// Adds the nodes and rows of another part of the side, none of whose conditions may be implied yet.
    pub fn append(&mut self, part: Self) {
        let before = self.nonmortar.len();
        let points = self.points.len();
        let moved = part.nodes.into_iter().map(|node| InterfaceNode {
            rows: node.rows.map(|row| row.map(|row| row + before)),
            shares: node.shares.after(points),
            ..node
        });
        self.nodes.extend(moved);
        self.points.extend(part.points);
        self.nonmortar.extend(part.nonmortar);
        self.mortar.extend(part.mortar);
        self.missed = [0, 1].map(|k| self.missed[k] + part.missed[k]);
        self.unborne += part.unborne;
        self.cyclic = false;
    }

    /// An interface without nodes.
    pub fn empty(coupling: Coupling) -> Self {
        Self {
            nodes: Vec::new(),
            cyclic: false,
            coupling,
            nonmortar: Vec::new(),
            mortar: Vec::new(),
            points: Vec::new(),
            implied: Vec::new(),
            missed: [0; 2],
            unborne: 0,
        }
    }

    /// Initial gap between the undeformed surfaces in every row; tangential rows have none.
    pub fn gaps(&self) -> Vec<f64> {
        let mut gaps = vec![0.0; self.nonmortar.len()];
        for node in &self.nodes {
            if let Some(row) = node.rows[0] {
                gaps[row] = node.gap;
            }
        }
        gaps
    }

    /// Whether each row is tangential under friction.
    pub fn tangential(&self) -> Vec<bool> {
        let mut tangential = vec![false; self.nonmortar.len()];
        if self.coupling == Coupling::Frictional {
            let rows = self.nodes.iter().flat_map(|node| &node.rows[1..]);
            rows.flatten().for_each(|&row| tangential[row] = true);
        }
        tangential
    }

    /// Sets all initial gaps to zero.
    pub fn close(&mut self) {
        for node in self.nodes.iter_mut().filter(|node| !node.gap.is_nan()) {
            (node.gap, node.clearance) = (0.0, 0.0);
        }
        self.points.iter_mut().for_each(|point| point.gap = 0.0);
    }

    /// Sets initial gaps to zero that are within some rounding.
    pub fn settle(&mut self, rounding: f64) {
        let nodes = self.nodes.iter_mut();
        let gaps = nodes.flat_map(|node| [&mut node.gap, &mut node.clearance]);
        let gaps = gaps.chain(self.points.iter_mut().map(|point| &mut point.gap));
        let none = gaps.filter(|gap| gap.abs() <= rounding);
        none.for_each(|gap| *gap = 0.0);
    }

    /// Removes the multipliers of rows, and with a normal row under friction those of the tangential ones: the rows become
    /// implied conditions, the rows after them move up, and nodes that lose all rows become fixed. Returns whether each row is kept (m,).
    pub fn drop_rows(&mut self, rows: &[usize]) -> Vec<bool> {
        let mut kept = vec![true; self.nonmortar.len()];
        rows.iter().for_each(|&row| kept[row] = false);
        if self.coupling == Coupling::Frictional {
            for node in &self.nodes {
                if node.rows[0].is_some_and(|row| !kept[row]) {
                    node.rows
                        .iter()
                        .flatten()
                        .for_each(|&row| kept[row] = false);
                }
            }
        }
        for (place, node) in self.nodes.iter().enumerate() {
            for (component, row) in node.rows.iter().enumerate() {
                if let Some(row) = row.filter(|&row| !kept[row]) {
                    self.implied.push(Implied {
                        node: place,
                        component,
                        rows: [self.nonmortar[row].clone(), self.mortar[row].clone()],
                    });
                }
            }
        }
        self.keep_rows(&kept);
        for node in &mut self.nodes {
            if node.role == Role::Multiplier && node.rows.iter().all(Option::is_none) {
                node.role = Role::Fixed;
            }
        }
        kept
    }

    /// Gives each two nodes one multiplier, that of the first: its rows become the means of those of both by weight, along the frame of
    /// the first and, at the second, along these directions, which stand for them there. The second node carries nothing then; its
    /// weight stays its own, and is part of that of the first, too.
    pub fn join(&mut self, pairs: &[([usize; 2], [Point<D>; D])]) {
        let mut kept = vec![true; self.nonmortar.len()];
        for &([first, second], directions) in pairs {
            let second_node = self.nodes[second].clone();
            let whole = self.nodes[first].weight + second_node.weight;
            let [own, other] = [self.nodes[first].weight, second_node.weight].map(|w| w / whole);
            for (c, row) in self.nodes[first].rows.into_iter().enumerate() {
                let Some(row) = row else { continue };
                let parts = second_node.rows.iter().enumerate();
                let parts = parts.filter(|(j, _)| (*j == 0) == (c == 0));
                let parts: Vec<(usize, f64)> = parts
                    .filter_map(|(j, other)| {
                        let along = dot(directions[c], second_node.frame[j]);
                        Some(((*other)?, if c == 0 { 1.0 } else { along }))
                    })
                    .collect();
                for side in [&mut self.nonmortar, &mut self.mortar] {
                    let mut sum: Row<D> = Vec::new();
                    add_row(&mut sum, &side[row], own);
                    for &(further, along) in &parts {
                        add_row(&mut sum, &side[further], other * along);
                    }
                    side[row] = sum;
                }
            }
            second_node
                .rows
                .iter()
                .flatten()
                .for_each(|&row| kept[row] = false);
            let node = &mut self.nodes[first];
            node.gap = own * node.gap + other * second_node.gap;
            node.share = own * node.share + other * second_node.share;
            node.shares.join(second_node.shares, [own, other]);
            node.weight = whole;
            node.extent += second_node.extent;
            let node = &mut self.nodes[second];
            (node.rows, node.role, node.extent) = ([None; D], Role::Fixed, 0.0);
        }
        self.keep_rows(&kept);
    }

    /// Keeps the marked rows, which move up.
    fn keep_rows(&mut self, kept: &[bool]) {
        let mut next = 0;
        let place: Vec<Option<usize>> = kept
            .iter()
            .map(|&kept| {
                next += usize::from(kept);
                kept.then(|| next - 1)
            })
            .collect();
        for node in &mut self.nodes {
            node.rows = node.rows.map(|row| row.and_then(|row| place[row]));
        }
        for side in [&mut self.nonmortar, &mut self.mortar] {
            let mut kept = kept.iter();
            side.retain(|_| kept.next().copied().unwrap_or(true));
        }
    }

    /// The nodes that carry multipliers, in the order of the rows.
    pub fn carriers(&self) -> impl Iterator<Item = &InterfaceNode<D>> {
        self.nodes
            .iter()
            .filter(|node| node.role == Role::Multiplier)
    }
}

/// Adds a row times a factor to another one.
fn add_row<const D: usize>(sum: &mut Row<D>, row: &Row<D>, factor: f64) {
    for &(node, c) in row {
        match sum.iter_mut().find(|entry| entry.0 == node) {
            Some((_, own)) => *own = add_scaled(*own, factor, c),
            None => sum.push((node, c.map(|c| factor * c))),
        }
    }
}

/// Force and moment about a place ON the nodes of some rows of B under forces `lambda`: −Bᵀλ.
pub(crate) fn pushed<const D: usize>(
    rows: &[Row<D>],
    lambda: &[f64],
    points: &[Point<D>],
    about: Point<D>,
) -> (Point<D>, [f64; 3]) {
    let (mut force, mut moment) = ([0.0; D], [0.0; 3]);
    for (row, l) in rows.iter().zip(lambda) {
        for &(node, coefficients) in row {
            let push = coefficients.map(|c| -l * c);
            force = add_scaled(force, 1.0, push);
            moment = add_scaled(moment, 1.0, cross(sub(points[node], about), push));
        }
    }
    (force, moment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{cube, end, flat, node_at};
    use crate::fem::Analysis;
    use crate::mesh::CellKind;

    /// Three nodes of a side with four above a side with three, a given gap of 1 + x.
    fn interface(coupling: Coupling) -> Interface<2> {
        let free = Constraints::default();
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let lower = flat(&[0.0, 1.0, 2.0], -1.0, CellKind::Quad4);
        let gap = Field::function("1 + x", |p, _| 1.0 + p[0]);
        let (nonmortar, mortar) = (end(&upper, "bottom", &free), end(&lower, "bottom", &free));
        let (gap, analysis) = (InitialGap::Given(&gap), Analysis::PlaneStrain);
        pair_nodes(nonmortar, mortar, gap, coupling, analysis, 0.0).unwrap()
    }

    fn rows(interface: &Interface<2>) -> Vec<[Option<usize>; 2]> {
        interface.nodes.iter().map(|node| node.rows).collect()
    }

    #[test]
    fn normal_rows_have_gaps_and_tangential_ones_are_rough_under_friction() {
        let frictional = interface(Coupling::Frictional);
        assert_eq!(frictional.gaps(), [1.0, 0.0, 2.0, 0.0, 3.0, 0.0]);
        let rough = [false, true, false, true, false, true];
        assert_eq!(frictional.tangential(), rough);
        assert_eq!(interface(Coupling::Tied).tangential(), [false; 6]);
        let normal = interface(Coupling::Normal);
        assert_eq!(normal.tangential(), [false; 3]);
        assert_eq!(normal.gaps(), [1.0, 2.0, 3.0]);
        let carriers: Vec<usize> = normal.carriers().map(|node| node.node).collect();
        let expected: Vec<usize> = normal.nodes[..3].iter().map(|node| node.node).collect();
        assert_eq!(carriers, expected);
    }

    #[test]
    fn a_normal_row_takes_the_tangential_ones_with_it_under_friction() {
        let before = interface(Coupling::Frictional);
        let mut after = before.clone();
        after.drop_rows(&[2]);
        let left = [
            [Some(0), Some(1)],
            [None, None],
            [Some(2), Some(3)],
            [None; 2],
        ];
        assert_eq!(rows(&after), left);
        let roles: Vec<Role> = after.nodes.iter().map(|node| node.role).collect();
        let expected = [Role::Multiplier, Role::Fixed, Role::Multiplier, Role::Alone];
        assert_eq!(roles, expected);
        for (after, before) in [
            (&after.nonmortar, &before.nonmortar),
            (&after.mortar, &before.mortar),
        ] {
            let kept: Vec<_> = [0, 1, 4, 5].map(|row| before[row].clone()).into();
            assert_eq!(*after, kept);
        }
        // both are judged all the same
        for (component, implied) in after.implied.iter().enumerate() {
            assert_eq!((implied.node, implied.component), (1, component));
            let row = 2 + component;
            let expected = [before.nonmortar[row].clone(), before.mortar[row].clone()];
            assert_eq!(implied.rows, expected);
        }
        assert_eq!(after.implied.len(), 2);
    }

    #[test]
    fn other_rows_go_alone() {
        let mut frictional = interface(Coupling::Frictional);
        frictional.drop_rows(&[3]);
        let left = [
            [Some(0), Some(1)],
            [Some(2), None],
            [Some(3), Some(4)],
            [None; 2],
        ];
        assert_eq!(rows(&frictional), left);
        assert_eq!(frictional.nodes[1].role, Role::Multiplier);
        assert_eq!(frictional.implied.len(), 1);
        let mut tied = interface(Coupling::Tied);
        tied.drop_rows(&[2]);
        let left = [
            [Some(0), Some(1)],
            [None, Some(2)],
            [Some(3), Some(4)],
            [None; 2],
        ];
        assert_eq!(rows(&tied), left);
        assert_eq!(tied.nodes[1].role, Role::Multiplier);
        assert_eq!((tied.nonmortar.len(), tied.mortar.len()), (5, 5));
        // the same index again removes the row that has moved up
        tied.drop_rows(&[2]);
        assert_eq!(tied.nodes[1].role, Role::Fixed);
        assert_eq!((tied.implied[1].node, tied.implied[1].component), (1, 1));
    }

    #[test]
    fn an_appended_part_keeps_its_rows_gaps_and_points() {
        let part = interface(Coupling::Frictional);
        let mut both = part.clone();
        both.cyclic = true;
        both.append(part.clone());
        assert!(!both.cyclic);
        // the fourth faces nothing: its gap is no number
        assert_eq!(both.nodes[..3], part.nodes[..3]);
        for (moved, node) in both.nodes[4..].iter().zip(&part.nodes) {
            assert_eq!(moved.rows, node.rows.map(|row| row.map(|row| row + 6)));
            let mean = node.shares.mean.iter();
            let mean: Vec<_> = mean.map(|&(point, weight)| (point + 3, weight)).collect();
            assert_eq!(moved.shares.mean, mean);
            assert_eq!((moved.node, moved.role), (node.node, node.role));
        }
        for (both, part) in [
            (&both.nonmortar, &part.nonmortar),
            (&both.mortar, &part.mortar),
        ] {
            assert_eq!(both[..6], **part);
            assert_eq!(both[6..], **part);
        }
        assert_eq!(both.points.len(), 6);
        assert_eq!(both.gaps()[6..], part.gaps());
    }

    #[test]
    fn closing_takes_the_gaps_of_what_faces_something() {
        let mut closed = interface(Coupling::Normal);
        closed.close();
        assert_eq!(closed.gaps(), [0.0; 3]);
        assert!(closed.nodes[..3].iter().all(|node| node.clearance == 0.0));
        assert!(closed.nodes[3].gap.is_nan() && closed.nodes[3].clearance.is_nan());
        assert!(closed.points.iter().all(|point| point.gap == 0.0));
    }

    #[test]
    fn a_partner_is_the_only_node_opposite() {
        let (upper, lower) = (
            flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4),
            flat(&[0.0, 1.5, 2.0], -1.0, CellKind::Quad4),
        );
        let mut node = interface(Coupling::Normal).nodes[1].clone();
        let below = flat(&[0.0, 1.0, 2.0], -1.0, CellKind::Quad4);
        assert_eq!(node.partner(), Some(node_at(&below, [1.0, 0.0])));
        assert_eq!(node.normal(), [0.0, -1.0]);
        node.opposite.clear();
        assert_eq!(node.partner(), None);
        let free = Constraints::default();
        let against = Against::Side(end(&lower, "bottom", &free));
        let mortar = pair_mortar(
            end(&upper, "bottom", &free),
            against,
            InitialGap::Closed,
            Coupling::Normal,
            Analysis::PlaneStrain,
            0.0,
        );
        assert_eq!(mortar.unwrap().nodes[1].partner(), None);
    }

    #[test]
    fn an_end_of_the_plane_is_one_and_one_of_space_is_not() {
        let (plane, free) = (
            flat(&[0.0, 1.0], 1.0, CellKind::Quad4),
            Constraints::default(),
        );
        assert!(end(&plane, "bottom", &free).of_dimension::<2>().is_some());
        let (cube, free) = (cube(0.0), Constraints::default());
        let space = end(&cube, "bottom", &free);
        assert!(space.of_dimension::<2>().is_none());
        assert!(space.of_dimension::<3>().is_some());
        assert!(Against::Side(space).of_dimension::<2>().is_none());
        let rigid = Rigid::<3>::Gap(Field::constant(0.0));
        let obstacle = Against::Obstacle(&rigid, Driven::Free);
        assert!(obstacle.of_dimension::<2>().is_none());
        let of_part = End {
            part: Some(&[]),
            ..space
        };
        assert_eq!(of_part.facets(), Ok(&[][..]));
        assert_eq!(of_part.name(), "body.bottom");
    }
}
