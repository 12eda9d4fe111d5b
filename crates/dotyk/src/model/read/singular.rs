//! The largest stress of a body, and whether it converges: places where linear elasticity has no finite stress.
//!
//! They are found from the model, not from the values: nodes with a point force, and corners of the boundary whose interior
//! angle is too large for the supports of their two sides,
//!
//! ```text
//!   the same on both (free, or held alike)  180°      free beside clamped  60°      all other pairs  90°
//! ```
//!
//! and ends of contacts that bear a force and form, with the other body, an angle above 180°. Nodes of a polygon that represents
//! a curve are not corners: they turn as their neighbours do.
//!
//! Source: M. L. Williams, Stress singularities resulting from various boundary conditions in angular corners of plates in
//! extension, J. Appl. Mech. 19 (1952) 526–528, as described in textbooks.

use crate::fem::{CoupleKind, Load, Material, measure, nearest_node, nodal_volumes};
use crate::geometry::{Point, distance, dot, norm, unit};
use crate::mesh::{Facet, Mesh};
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::{Bed, Body, Law, Model, Place};
use crate::model::nouns::solution::{
    BodySolution, ContactNode, ContactSolution, Peak, Singular, SingularPeak, Status, StressAt,
};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// Tolerance of angles, in degrees: meshes and drawings are not exact.
const ROOM: f64 = 10.0;

/// A larger turn at a node is a corner whatever its neighbours do: six facets are not a circle. In degrees.
const NO_CURVE: f64 = 60.0;

/// A point force counts if it causes at least this part of the stress there.
const FELT: f64 = 0.01;

/// A normal is along an axis if the square of the sine of their angle is below this.
const PARALLEL: f64 = 1e-9;

/// The two ends of a contact lie opposite within this many facets.
const OPPOSITE: f64 = 1.5;

/// With stresses elsewhere within this factor the largest one is not due to the place.
const STANDS_OUT: f64 = 1.05;

/// Part of a body's volume, with thickness or 2πr, that the usual stresses hold.
const USUAL: f64 = 0.995;

/// Outlines of all bodies, made on first use: they are those of every load step.
#[derive(Default)]
pub(crate) struct Outlines(OnceLock<Known>);

/// Data of each body that do not change from step to step.
struct Known {
    outlines: Vec<Outline>,
    /// Facets that are sides of a contact.
    covered: Vec<BTreeSet<Facet>>,
    /// Nodes on ties, but for their ends.
    tied: Vec<BTreeSet<usize>>,
}

impl Known {
    fn of<const D: usize>(model: &Model<D>, contacts: &[ContactSolution<D>]) -> Self {
        let bodies = model.bodies.par_iter();
        let tied = (0..model.bodies.len()).into_par_iter();
        Self {
            outlines: bodies.map(Outline::of).collect(),
            covered: covered(model, contacts),
            tied: tied.map(|body| tied_nodes(model, contacts, body)).collect(),
        }
    }
}

/// A value below this part of its scale is rounding.
const VALUE_ROUNDING: f64 = 1e-10;

/// Nodes of a body at which the stress is not finite, each with the reason.
type Places = BTreeMap<usize, Singular>;

/// The largest von Mises stress and the largest utilisation of every body, from its solution at a time and that of the contacts.
pub(crate) fn peaks<const D: usize>(
    model: &Model<D>,
    outlines: &Outlines,
    bodies: &[BodySolution<D>],
    contacts: &[ContactSolution<D>],
    time: f64,
) -> Vec<[Option<Peak<D>>; 2]> {
    let known = outlines.0.get_or_init(|| Known::of(model, contacts));
    let ends = ends_of_contacts(model, known, contacts);
    let each = model.bodies.par_iter().zip(bodies).zip(ends).enumerate();
    let each = each.map(|(index, ((body, solved), mut places))| {
        places.extend(known.outlines[index].corners(body, &known.tied[index]));
        places.extend(point_forces(model, body, solved, time));
        // under equal pressure on all sides von Mises' stress is rounding
        let components = solved.stress.as_flattened().iter();
        let scale = components.fold(0.0, |most: f64, s| most.max(s.abs()));
        let utilised = solved.utilisation.as_ref();
        [
            peak(model, (body, solved), (&solved.von_mises, scale), &places),
            utilised.and_then(|own| peak(model, (body, solved), (&own.nodal, 1.0), &places)),
        ]
    });
    each.collect()
}

/// The largest of the values of one body at the places of its stress, and, if it is at or next to one of these nodes, the values away
/// from them; a value far below `scale` is rounding.
fn peak<const D: usize>(
    model: &Model<D>,
    (body, BodySolution { borders, .. }): (&Body<D>, &BodySolution<D>),
    (values, scale): (&[f64], f64),
    places: &Places,
) -> Option<Peak<D>> {
    let points = body.mesh.points();
    let largest = |among: &dyn Fn(usize) -> bool| {
        let values = borders.nodes().zip(values);
        let values = values.filter(|(node, value)| !value.is_nan() && among(*node));
        let found = values.reduce(|best, next| if next.1 > best.1 { next } else { best });
        found.map(|(node, &value)| {
            let at = points[node];
            (node, StressAt { value, at })
        })
    };
    let (node, most) = largest(&|_| true)?;
    let near = around(&body.mesh, places);
    let singular = near
        .get(&node)
        .filter(|_| most.value > VALUE_ROUNDING * scale);
    let place = singular.and_then(|&place| {
        let two = around(&body.mesh, &near);
        let away = largest(&|node| !two.contains_key(&node)).map(|(_, away)| away);
        if away.is_some_and(|away| most.value < STANDS_OUT * away.value) {
            return None;
        }
        let bound = away.map_or(f64::INFINITY, |away| away.value);
        let volumes = nodal_volumes(body, borders, model.analysis);
        let (usual, share) = usual(&volumes, values, bound);
        Some(SingularPeak {
            place,
            away,
            usual,
            share,
        })
    });
    Some(Peak { most, place })
}

/// These nodes, and all that share a cell with one of them.
fn around<const D: usize>(mesh: &Mesh<D>, places: &Places) -> Places {
    let mut wider = places.clone();
    if places.is_empty() {
        return wider;
    }
    let mut is_place = vec![false; mesh.points().len()];
    places.keys().for_each(|&node| is_place[node] = true);
    for cell in mesh.blocks().iter().flat_map(|block| block.cells()) {
        let inside = cell.iter().find(|&&node| is_place[node as usize]);
        let inside = inside.and_then(|&node| places.get(&(node as usize)));
        if let Some(&place) = inside {
            for &node in cell {
                wider.entry(node as usize).or_insert(place);
            }
        }
    }
    wider
}

/// The value not exceeded in [`USUAL`] of the volume, or this bound if it is less; and the part of the volume below it.
fn usual(volumes: &[f64], values: &[f64], bound: f64) -> (f64, f64) {
    let nodes = values.iter().zip(volumes);
    // volumes of corners of quadratic cells may be negative
    let nodes = nodes.map(|(&value, &volume)| (value, volume.max(0.0)));
    let mut sorted: Vec<(f64, f64)> = nodes.filter(|(value, _)| !value.is_nan()).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = sorted.iter().map(|(_, volume)| volume).sum();
    let (mut held, mut high) = (0.0, f64::NEG_INFINITY);
    for (value, volume) in sorted {
        if value > bound || (held >= USUAL * whole && value > high) {
            break;
        }
        held += volume;
        high = value;
    }
    (high, held / whole)
}

/// The support of a facet of the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hold {
    Free,
    Guided {
        /// 0 and 1 the axes, 2 the normal.
        direction: usize,
        /// The direction is that of the normal.
        normal: bool,
    },
    Clamped,
}

impl Hold {
    /// Two facets are held the same way: along one direction, or each along its normal.
    fn is_like(self, other: Self) -> bool {
        match (self, other) {
            (
                Self::Guided {
                    direction: a,
                    normal: n,
                },
                Self::Guided {
                    direction: b,
                    normal: m,
                },
            ) => a == b || (n && m),
            _ => self == other,
        }
    }
}

/// A node of a plane boundary between two facets.
#[derive(Debug, Clone, Copy)]
struct Corner {
    /// The facets that end and begin here.
    facets: [Facet; 2],
    /// Interior, in degrees; 180 on a curve.
    angle: f64,
}

/// The boundary of a plane body.
#[derive(Debug, Default)]
struct Outline {
    corners: BTreeMap<usize, Corner>,
    held: BTreeMap<Facet, Hold>,
}

impl Outline {
    /// The outline of a plane body; empty in space.
    fn of<const D: usize>(body: &Body<D>) -> Self {
        let mesh = &body.mesh;
        if D != 2 {
            return Self::default();
        }
        // the facets that end and begin at each node, where it is one of each
        let mut meeting: BTreeMap<usize, [Vec<Facet>; 2]> = BTreeMap::new();
        for facet in mesh.boundary_facets() {
            for (end, node) in mesh.facet_nodes(facet).take(2).enumerate() {
                meeting.entry(node as usize).or_default()[1 - end].push(facet);
            }
        }
        let pair = |(node, meeting): (usize, [Vec<Facet>; 2])| match meeting {
            [a, b] if a.len() == 1 && b.len() == 1 => Some((node, [a[0], b[0]])),
            _ => None,
        };
        let pairs: BTreeMap<usize, [Facet; 2]> = meeting.into_iter().filter_map(pair).collect();
        let turn = |node: usize| pairs.get(&node).map_or(0.0, |facets| turn(mesh, *facets));
        let corner = |(&node, &facets): (&usize, &[Facet; 2])| {
            let own = turn(node);
            let ends = [(facets[0], 0), (facets[1], 1)];
            let beside = ends.map(|(facet, end)| {
                let node = mesh.facet_nodes(facet).nth(end);
                node.map_or(0.0, |node| turn(node as usize))
            });
            let alike = beside.map(|turn| turn * own.signum());
            let excess = own.abs() - alike[0].max(alike[1]).max(0.0);
            let curve = own.abs() < NO_CURVE && excess < ROOM;
            let angle = if curve { 180.0 } else { 180.0 - own };
            (node, Corner { facets, angle })
        };
        Self {
            corners: pairs.iter().map(corner).collect(),
            held: held(body),
        }
    }

    fn hold(&self, facet: Facet) -> Hold {
        self.held.get(&facet).copied().unwrap_or(Hold::Free)
    }

    fn angle(&self, node: usize) -> f64 {
        self.corners.get(&node).map_or(180.0, |corner| corner.angle)
    }

    /// The facet that meets another one at a node.
    fn beside(&self, node: usize, facet: Facet) -> Option<Facet> {
        let corner = self.corners.get(&node)?;
        corner.facets.into_iter().find(|&other| other != facet)
    }

    /// Corners too wide for the supports of their sides; not those inside a tie, where the other body goes on.
    fn corners<const D: usize>(&self, body: &Body<D>, tied: &BTreeSet<usize>) -> Places {
        let contracts = |m: &Material| m.elastic.poisson != 0.0;
        let contracts = body.materials.iter().any(contracts);
        let corners = self.corners.iter().filter(|(node, _)| !tied.contains(node));
        let singular = corners.filter_map(|(&node, corner)| {
            let [a, b] = corner.facets.map(|facet| self.hold(facet));
            let free_beside_clamped =
                (a == Hold::Free && b == Hold::Clamped) || (a == Hold::Clamped && b == Hold::Free);
            let (limit, place) = match a.is_like(b) {
                true => (180.0, Singular::Corner),
                false if free_beside_clamped && contracts => (60.0, Singular::EndOfSupport),
                false => (90.0, Singular::EndOfSupport),
            };
            (corner.angle > limit + ROOM).then_some((node, place))
        });
        singular.collect()
    }
}

/// The turn of the boundary from one facet to the next, in degrees; positive to the left, around a convex corner.
fn turn<const D: usize>(mesh: &Mesh<D>, [before, after]: [Facet; 2]) -> f64 {
    let a = mesh.facet_tangents(before, &[1.0])[0];
    let b = mesh.facet_tangents(after, &[-1.0])[0];
    (a[0] * b[1] - a[1] * b[0]).atan2(dot(a, b)).to_degrees()
}

/// The facets held by supports, and those that move rigidly with a point.
fn held<const D: usize>(body: &Body<D>) -> BTreeMap<Facet, Hold> {
    let mut directions: BTreeMap<Facet, BTreeSet<usize>> = BTreeMap::new();
    for support in &body.supports {
        let Place::Side(side) = &support.place else {
            continue;
        };
        let axes = support.components.iter().enumerate();
        let axes = axes.filter(|(_, component)| component.is_some());
        let normal = support.normal.is_some().then_some(2);
        let held: BTreeSet<usize> = axes.map(|(axis, _)| axis).chain(normal).collect();
        for &facet in body.mesh.side(side).unwrap_or_default() {
            directions.entry(facet).or_default().extend(&held);
        }
    }
    let rigid = body.couples.iter().filter(|c| c.kind == CoupleKind::Rigid);
    for &facet in rigid.flat_map(|c| body.mesh.side(&c.side).unwrap_or_default()) {
        directions.entry(facet).or_default().extend(0..D);
    }
    let hold = |(facet, directions): (Facet, BTreeSet<usize>)| {
        let normal = unit(body.mesh.outward_normal(facet, &[0.0])).unwrap_or([0.0; D]);
        let along = |d: &usize| *d == 2 || normal[*d].abs() > 1.0 - PARALLEL;
        let mut list = directions.iter();
        let hold = match (list.next(), list.next()) {
            (None, _) => Hold::Free,
            (Some(&only), None) => Hold::Guided {
                direction: only,
                normal: along(&only),
            },
            // the normal, and the axis that it is along
            (Some(only), Some(2)) if directions.len() == 2 && along(only) => Hold::Guided {
                direction: 2,
                normal: true,
            },
            _ => Hold::Clamped,
        };
        (facet, hold)
    };
    directions.into_iter().map(hold).collect()
}

/// Nodes of a body on ties, but for their ends.
fn tied_nodes<const D: usize>(
    model: &Model<D>,
    contacts: &[ContactSolution<D>],
    body: usize,
) -> BTreeSet<usize> {
    let mut nodes = BTreeSet::new();
    for (contact, solved) in model.contacts.iter().zip(contacts) {
        let sides = [Some(&solved.nonmortar), solved.mortar.as_ref()];
        let own = sides.into_iter().flatten().filter(|s| s.body.0 == body);
        for side in own.filter(|_| matches!(contact.law, Law::Tied)) {
            let all = model.bodies[body].mesh.side_nodes(&side.side);
            nodes.extend(all.unwrap_or_default().into_iter().map(|n| n as usize));
            for (end, _) in ends(model, side) {
                nodes.remove(&end);
            }
        }
    }
    nodes
}

/// The two ends of every chain of a side that is not closed: node and facet.
fn ends<const D: usize>(model: &Model<D>, side: &SideRef) -> Vec<(usize, Facet)> {
    let Some(mesh) = model.bodies[side.body.0].mesh.in_plane() else {
        return Vec::new();
    };
    let chains = mesh.chain(&side.side).unwrap_or_default();
    let open = chains.iter().filter(|chain| !chain.cyclic);
    let both = open.flat_map(|chain| {
        let first = chain.nodes.first().zip(chain.facets.first());
        let last = chain.nodes.last().zip(chain.facets.last());
        [first, last]
    });
    let both = both.flatten();
    both.map(|(&node, &facet)| (node as usize, facet)).collect()
}

/// Ends of contacts that bear a force there, unless both bodies end there.
fn ends_of_contacts<const D: usize>(
    model: &Model<D>,
    Known {
        outlines, covered, ..
    }: &Known,
    contacts: &[ContactSolution<D>],
) -> Vec<Places> {
    let mut places = vec![Places::new(); model.bodies.len()];
    for contact in contacts {
        let sides = [Some(&contact.nonmortar), contact.mortar.as_ref()];
        for (side, other) in [(sides[0], sides[1]), (sides[1], sides[0])] {
            let Some(side) = side else { continue };
            let body = side.body.0;
            for (node, facet) in ends(model, side) {
                let mesh = &model.bodies[body].mesh;
                let at = mesh.points()[node];
                let reach = OPPOSITE * mesh.facet_length(facet);
                let opposite =
                    other.and_then(|other| Some((other.body.0, nearest(model, other, at)?)));
                let end = End {
                    node,
                    beside: outlines[body].beside(node, facet),
                    opposite,
                };
                if bears(&contact.nodes, at, reach) && end.is_edge(outlines, body, covered) {
                    places[body].insert(node, Singular::EndOfContact);
                    if let Some((other, node)) = opposite {
                        places[other].insert(node, Singular::EndOfContact);
                    }
                }
            }
        }
    }
    places
}

/// The end of a side in contact.
struct End {
    node: usize,
    /// The facet of the boundary beyond it.
    beside: Option<Facet>,
    /// Body and node that it touches; `None` for an obstacle.
    opposite: Option<(usize, usize)>,
}

impl End {
    /// The bodies do not both end here, and neither goes on in a neighbour or beyond a line of symmetry.
    fn is_edge(&self, outlines: &[Outline], body: usize, covered: &[BTreeSet<Facet>]) -> bool {
        let Some(beside) = self.beside.filter(|beside| !covered[body].contains(beside)) else {
            return false;
        };
        let own = outlines[body].angle(self.node);
        let opposite = match self.opposite {
            Some((other, node)) => outlines[other].angle(node),
            // a rigid plane mirrors the body
            None => own,
        };
        if outlines[body].hold(beside) == Hold::Free {
            return own + opposite > 180.0 + ROOM;
        }
        // with a support it is a guided punch if the other body goes on without a support
        self.opposite.is_some_and(|(other, node)| {
            let corner = outlines[other].corners.get(&node);
            let facets = corner.map_or(&[][..], |corner| &corner.facets[..]);
            let free = |facet: &Facet| outlines[other].hold(*facet) == Hold::Free;
            opposite > 180.0 - ROOM && facets.iter().all(free)
        })
    }
}

/// Facets of every body that are sides of a contact.
fn covered<const D: usize>(
    model: &Model<D>,
    contacts: &[ContactSolution<D>],
) -> Vec<BTreeSet<Facet>> {
    let mut covered = vec![BTreeSet::new(); model.bodies.len()];
    for contact in contacts {
        for side in [Some(&contact.nonmortar), contact.mortar.as_ref()] {
            let Some(side) = side else { continue };
            let facets = model.bodies[side.body.0].mesh.side(&side.side);
            covered[side.body.0].extend(facets.unwrap_or_default());
        }
    }
    covered
}

/// The node of a contact nearest to a point is within reach and in contact.
fn bears<const D: usize>(nodes: &[ContactNode<D>], at: Point<D>, reach: f64) -> bool {
    let away = |node: &&ContactNode<D>| distance(node.point, at);
    let nearest = nodes.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.is_some_and(|node| away(&node) <= reach && node.status != Status::Open)
}

/// The node of a side that is nearest to a point.
fn nearest<const D: usize>(model: &Model<D>, side: &SideRef, at: Point<D>) -> Option<usize> {
    let mesh = &model.bodies[side.body.0].mesh;
    let away = |node: &u32| distance(mesh.points()[*node as usize], at);
    let nodes = mesh.side_nodes(&side.side)?;
    let nearest = nodes.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.map(|&node| node as usize)
}

/// Nodes with a point load, or the force of a point support, that is noticeable in the stress there.
fn point_forces<const D: usize>(
    model: &Model<D>,
    body: &Body<D>,
    solved: &BodySolution<D>,
    time: f64,
) -> Places {
    let mesh = &body.mesh;
    let mut places = Places::new();
    let mut add = |point: Point<D>, place: Singular, force: &dyn Fn(usize) -> Point<D>| {
        if let Ok(node) = nearest_node(mesh, point, "point force")
            && is_felt(model, body, solved, (node, force(node)))
        {
            places.insert(node, place);
        }
    };
    for support in &body.supports {
        if let Place::Point(point) = support.place {
            // a side may hold the node in other directions
            let own = |node: usize| {
                let force = solved.reactions[node];
                std::array::from_fn(|i| support.components[i].as_ref().map_or(0.0, |_| force[i]))
            };
            add(point, Singular::PointSupport, &own);
        }
    }
    for spring in &body.springs {
        if let Bed::Point { point, stiffness } = &spring.bed {
            let own = |node: usize| {
                let force = solved.reactions[node];
                std::array::from_fn(|i| if stiffness[i] > 0.0 { force[i] } else { 0.0 })
            };
            add(*point, Singular::PointSupport, &own);
        }
    }
    for load in &body.loads {
        if let Load::Force { point, .. } = load {
            let force = |node: usize| load.at(mesh.points()[node], [0.0; D], time);
            add(*point, Singular::PointLoad, &force);
        }
    }
    places
}

/// A point force at a node would make a part of the stress there: F against σ h t, h the largest edge of a cell there.
fn is_felt<const D: usize>(
    model: &Model<D>,
    body: &Body<D>,
    solved: &BodySolution<D>,
    (node, force): (usize, Point<D>),
) -> bool {
    let mesh = &body.mesh;
    let size = mesh.longest_edge_at(node);
    let depth = match D {
        2 => measure(model.analysis, body.thickness, mesh.points()[node]),
        _ => size,
    };
    norm(force) > FELT * solved.von_mises[node] * size * depth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Field;
    use crate::mesh::{CellKind, Contour, Diagonals, Outline as Drawing, Rectangle, Ring};
    use crate::model::nouns::ids::BodyId;
    use crate::model::nouns::model::{Elastic, Gap};

    const STEEL: Elastic = Elastic {
        young: 210e3,
        poisson: 0.3,
    };

    fn block(from: Point<2>, to: Point<2>, cells: [usize; 2]) -> Mesh<2> {
        let rectangle = Rectangle {
            from,
            to,
            cells,
            cell: CellKind::Quad4,
            diagonals: Diagonals::default(),
        };
        rectangle.build().unwrap()
    }

    fn ring(around: usize, cell: CellKind) -> Mesh<2> {
        let ring = Ring {
            center: [0.0; 2],
            inner: 1.0,
            outer: 2.0,
            angles: None,
            cells: [around, 2],
            ratio: 1.0,
            grade: 1.0,
            cell,
            diagonals: Diagonals::default(),
        };
        ring.build().unwrap()
    }

    fn held_body(mesh: Mesh<2>, elastic: Elastic, hold: &dyn Fn(&mut Model<2>)) -> Model<2> {
        let mut model = Model::new();
        model.body("body", mesh, elastic);
        hold(&mut model);
        model
    }

    /// Places of a body alone, sorted by x.
    fn corners(model: &Model<2>) -> Vec<(Point<2>, Singular)> {
        let body = &model.bodies[0];
        let found = Outline::of(body).corners(body, &BTreeSet::new());
        let at = |(node, place)| (body.mesh.points()[node], place);
        let mut list: Vec<_> = found.into_iter().map(at).collect();
        list.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        list
    }

    #[test]
    fn a_re_entrant_corner_is_found_and_no_other() {
        let points = [
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        for size in [0.2, 1.0] {
            let drawing = Drawing::new(Contour::polygon(&points), size);
            let model = held_body(drawing.build().unwrap(), STEEL, &|_| {});
            assert_eq!(corners(&model), [([1.0, 1.0], Singular::Corner)], "{size}");
        }
    }

    #[test]
    fn polygons_for_circles_have_no_corners() {
        for around in [8, 12, 40] {
            for cell in [CellKind::Tri3, CellKind::Quad4, CellKind::Quad8] {
                let model = held_body(ring(around, cell), STEEL, &|_| {});
                assert_eq!(corners(&model), [], "{around} {cell:?}");
            }
        }
        let square = Contour::polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        let drawing = Drawing {
            holes: vec![Contour::circle([2.0, 2.0], 1.0)],
            ..Drawing::new(square, 0.8)
        };
        let model = held_body(drawing.build().unwrap(), STEEL, &|_| {});
        assert_eq!(corners(&model), []);
    }

    #[test]
    fn supports_end_in_a_singularity_where_the_angle_is_too_wide() {
        let mesh = || {
            let mesh = block([0.0, 0.0], [4.0, 1.0], [8, 2]);
            mesh.with_patch("middle", "bottom", [1.0, 0.0], [3.0, 0.0])
                .unwrap()
        };
        let place = |x: f64| ([x, 0.0], Singular::EndOfSupport);
        let of = |elastic, side: &str, components: [Option<f64>; 2]| {
            let hold = |model: &mut Model<2>| {
                model.fix(BodyId(0), side, components);
            };
            corners(&held_body(mesh(), elastic, &hold))
        };
        let clamp = [Some(0.0); 2];
        assert_eq!(of(STEEL, "bottom", clamp), [place(0.0), place(4.0)]);
        assert_eq!(of(STEEL, "middle", clamp), [place(1.0), place(3.0)]);
        // a right angle on rollers is half of a straight boundary; on a part of it they end in the middle
        let roller = [None, Some(0.0)];
        assert_eq!(of(STEEL, "bottom", roller), []);
        assert_eq!(of(STEEL, "middle", roller), [place(1.0), place(3.0)]);
        // a rigid couple is a clamp that moves, an average one lets its side strain
        let coupled = |kind| {
            let couple = |model: &mut Model<2>| {
                model.couple(BodyId(0), "middle", ("P", [2.0, 5.0]), kind);
            };
            corners(&held_body(mesh(), STEEL, &couple))
        };
        assert_eq!(coupled(CoupleKind::Rigid), [place(1.0), place(3.0)]);
        assert_eq!(coupled(CoupleKind::Average), []);
        // a material without lateral contraction is not restrained
        let cork = Elastic {
            poisson: 0.0,
            ..STEEL
        };
        assert_eq!(of(cork, "bottom", clamp), []);
        // two lines of symmetry, and a clamp up to one
        let both = |model: &mut Model<2>| {
            model.fix(BodyId(0), "left", [Some(0.0), None]);
            model.roller(BodyId(0), "bottom", 0.0);
        };
        assert_eq!(corners(&held_body(mesh(), STEEL, &both)), []);
        let half = |model: &mut Model<2>| {
            model.fix(BodyId(0), "left", [Some(0.0), None]);
            model.fix(BodyId(0), "bottom", clamp);
        };
        assert_eq!(corners(&held_body(mesh(), STEEL, &half)), [place(4.0)]);
    }

    #[test]
    fn the_edge_of_a_punch_is_told_with_the_stress_beside_it() {
        let mut model = Model::new();
        let low = model.body("low", block([0.0, 0.0], [4.0, 4.0], [32, 32]), STEEL);
        let up = model.body("up", block([0.0, 4.0], [1.0, 5.0], [8, 8]), STEEL);
        model
            .roller(low, "bottom", 0.0)
            .fix(low, "left", [Some(0.0), None])
            .fix(up, "left", [Some(0.0), None])
            .press(up, "top", 5.0);
        model.contact((up, "bottom"), (low, "top"));
        let bodies = model.solve().unwrap().bodies;
        // on the line of symmetry, x = 0, there is no edge
        let edge = [1.0, 4.0];
        let contacts = model.solve().unwrap().contacts;
        let known = Known::of(&model, &contacts);
        for (body, places) in ends_of_contacts(&model, &known, &contacts)
            .iter()
            .enumerate()
        {
            let points = model.bodies[body].mesh.points();
            let found: Vec<Point<2>> = places.keys().map(|&node| points[node]).collect();
            assert_eq!(found, [edge]);
        }
        let peak = bodies[1].peak.unwrap();
        let singular = peak.place.unwrap();
        assert_eq!(singular.place, Singular::EndOfContact);
        assert!(distance(peak.most.at, edge) < 0.2, "{peak:?}");
        let away = singular.away.unwrap();
        assert!(away.value < peak.most.value && singular.usual <= away.value);
        assert!(distance(away.at, edge) > 0.25, "{away:?}");
    }

    #[test]
    fn bodies_that_end_together_and_contacts_that_are_open_have_no_edge() {
        let stack = |gap: f64| {
            let mut model = Model::new();
            let low = model.body("low", block([0.0, 0.0], [2.0, 1.0], [4, 2]), STEEL);
            let up = model.body("up", block([0.0, 1.0], [2.0, 2.0], [6, 3]), STEEL);
            model
                .fix(low, "bottom", [None, Some(0.0)])
                .fix(low, "left", [Some(0.0), None])
                .fix(up, "left", [Some(0.0), None])
                .press(up, "top", 3.0);
            if gap > 0.0 {
                model.roller(up, "top", 0.0);
            }
            model.contact((up, "bottom"), (low, "top")).gap =
                Some(Gap::Given(Field::constant(gap)));
            model.solve().unwrap()
        };
        for gap in [0.0, 1.0] {
            let bodies = stack(gap).bodies;
            assert!(bodies.iter().all(|b| b.peak.unwrap().place.is_none()));
        }
    }

    #[test]
    fn a_force_at_a_node_is_told_and_a_pin_without_one_is_not() {
        let mut model = Model::new();
        let body = model.body("block", block([-2.0, 0.0], [2.0, 4.0], [16, 16]), STEEL);
        let force = [Field::constant(0.0), Field::constant(-1.0)];
        let point = [0.0, 4.0];
        model
            .roller(body, "bottom", 0.0)
            .pin(body, [0.0, 0.0], [Some(0.0), None])
            .load(body, Load::Force { point, force });
        let solved = model.solve().unwrap().bodies.remove(0);
        let found = point_forces(&model, &model.bodies[0], &solved, 1.0);
        let found: Vec<_> = found.into_iter().collect();
        let points = model.bodies[0].mesh.points();
        let node = points.iter().position(|p| *p == point).unwrap();
        assert_eq!(found, [(node, Singular::PointLoad)]);
        let peak = solved.peak.unwrap();
        assert_eq!(peak.place.unwrap().place, Singular::PointLoad);
        assert!(distance(peak.most.at, point) < 0.3, "{peak:?}");
        // pulled aside, the pin bears the force
        model.pull(body, "right", [1.0, 0.0]);
        let solved = model.solve().unwrap().bodies.remove(0);
        let found = point_forces(&model, &model.bodies[0], &solved, 1.0);
        assert_eq!(found.len(), 2);
        // a ring in balance is held at nodes without a force
        let mut model = Model::new();
        let body = model.body("ring", ring(24, CellKind::Quad8), STEEL);
        model
            .press(body, "inner", 1.0)
            .pin(body, [1.0, 0.0], [None, Some(0.0)])
            .pin(body, [-1.0, 0.0], [None, Some(0.0)])
            .pin(body, [0.0, 1.0], [Some(0.0), None]);
        let solved = model.solve().unwrap().bodies.remove(0);
        assert!(solved.peak.unwrap().place.is_none());
    }

    #[test]
    fn the_usual_stress_leaves_half_a_per_cent_out_or_what_is_bounded() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let even = vec![2.0; 1000];
        assert_eq!(usual(&even, &values, f64::INFINITY), (994.0, 0.995));
        assert_eq!(usual(&even, &values, 500.0), (500.0, 0.501));
        // large stresses may fill most of the body
        let mut heavy = even;
        heavy[999] = 1e6;
        assert_eq!(usual(&heavy, &values, f64::INFINITY).0, 999.0);
    }
}
