//! Mortar pairing: contact conditions as weighted means along the nonmortar side.
//!
//! Two meshes that do not match have no common nodes at which a gap could be measured. So every node j of the nonmortar side
//! carries a multiplier λⱼ, a force that is spread along the side with a weight ψⱼ(x), and its condition is that
//!
//! ```text
//!   row j:  ∫ψⱼ n(x)·(u_s(x) − u_m(y)) dx / ∫ψⱼ dx  ≤  g₀ⱼ = s(pⱼ)
//! ```
//!
//! x runs along the nonmortar side, n is its normal ([`Normals`](crate::contact::normals::Normals)), y the point where the line
//! x + s·n(x) meets the other side at the distance s, u_s and u_m are the displacements of the two sides. The gap s is measured
//! between the true surfaces where a side has one. The force acts on both bodies at the two ends of one line along n, so that forces
//! and moments balance whatever the two polygons are.
//!
//! **Gaps.** pⱼ is where the force acts: ψⱼ are biorthogonal to the functions of their facet, so that the mean of any of these
//! with ψⱼ is its value at one place. Of a gap that is one of them the mean and the value at pⱼ are the same, and patches are
//! exact. Of a gap that bends they are not, because ψⱼ is negative on parts of its facet: a side that touches another one in node
//! j alone, with s = κx²/2 to both sides of it, would have the mean −κh²/12, an overlap of sides that do not overlap, and a body
//! that is pressed down would rise by as much; in front of an edge beyond which the other side is H farther away, the mean is of the
//! size −H. A value has no such part: where no place overlaps, no row does. Overlaps of a facet between its nodes are found by the
//! judge (`model/march/between.rs`). Displacements stay means: only so do the forces of both bodies balance. Where ψ are
//! hats, and nowhere negative, the gap is their mean.
//!
//! **Sheets.** A near surface and one beyond an edge are two surfaces, such as two faces of a step, lands beside a groove, or the
//! next tooth (`sheets.rs`): a node has a row for each surface that its facets face, with ψ on the parts that face it, as if there
//! were two contacts.
//!
//! **Integration.** Facets are cut where the line from them meets a node, in space an edge of the other side (`pieces.rs`,
//! `polygons.rs`): on each piece all shape functions are smooth, and a Gauss rule is exact for straight facets.
//!
//! **Weights.** On a facet that faces the other side as a whole, the ψ are biorthogonal to the functions N of the facet
//! (`functions.rs`: in space the hats of its corners, which alone carry multipliers), ∫ψᵢNⱼ = δᵢⱼ∫Nⱼ. They sum to one, so that
//! a uniform pressure is exact, and on matching meshes of linear facets they give what pairing node by node gives. There are
//! three exceptions.
//! * A facet that faces the other side in part: biorthogonal functions of the whole facet would act as forces at nodes without
//!   an opposite side. There the ψ are biorthogonal to linear functions on the box around the covered part of each cell, and act
//!   at the corners of the box. As the cover grows to the whole of a straight facet, both become the same.
//!   Where the cover has a hole, ψ are the hats of the cell.
//! * A weight ∫N that is not positive (a quadratic facet that ends at the axis of revolution): ψ are linear between
//!   neighbouring nodes, middle nodes included.
//! * A node without a multiplier, because its displacement is prescribed or less than a thousandth of its surroundings faces
//!   the other side: on its facets ψ are linear, and its own share goes to the neighbours. So does its share of the shear where
//!   supports hold both sides obliquely, see `relative.rs`; rows of shear are divided by the weight of the normal row, so that
//!   bounds on tractions are bounds on forces.
//!
//! **Corners** that meet the other side between the faces of their body (`corners.rs`) have rows along the direction there, which
//! compare u_s with u_m continued rigidly, as tangential ones do, and the gap between the corner and the place that it meets. On
//! facets that are covered in part, or have a node without a multiplier, they are of the displacements of the corner and of that place
//! alone: a mean there would compare the gap of the corner with the displacements of its neighbours.
//!
//! **Tangential rows** compare u_s with u_m continued rigidly from y to x by the rotation of the other facet, because forces
//! along t at two points a distance s apart would be a couple. The tangents are those of the node, carried to n(x) by the
//! smallest rotation.
//!
//! Against a rigid obstacle u_m is its translation, and the rows on the other side act on it.

use crate::contact::functions::{Basis, Cell, Cover, FUNCTIONS, Piece, cells, functions};
use crate::contact::lever::Lever;
use crate::contact::opposite::{Corner, Found, Opposite, shape};
use crate::contact::relative::{
    Relative, axes, carried, frame, free_part, separates, tangents_along,
};
use crate::contact::search::{Hit, meet};
use crate::contact::share::{GapAt, Share, Station, Sums};
use crate::contact::sheets::sheets;
use crate::contact::{
    Against, ContactError, Coupling, Driven, End, GapPoint, GapShares, InitialGap, Interface,
    InterfaceNode, Rigid, Role, pieces, polygons,
};
use crate::fem::{Analysis, Held, measure};
use crate::geometry::{Point, dot, norm, unit};
use crate::host::in_order;
use crate::mesh::{Facet, Mesh};
use rayon::prelude::*;
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};

/// A node carries no multiplier if less than this part of its support faces the other side and a neighbour is covered more.
const SLIVER: f64 = 1e-3;

/// Facets whose lengths differ by no more than this part are of the same length.
const SAME_LENGTH: f64 = 1e-3;

/// Degree of the rule over whole facets, for weights of nodes.
const DEGREE: usize = 9;

/// Directions with a larger cosine are the same, but for the turn of a facet.
const ALIKE: f64 = 0.9;

/// Degree of the rule whose points check the pieces independently.
const LOOKED_AT: usize = 3;

/// A line from a corner of a piece starts this part of the way to its middle: at the corner itself the other side may end.
const TO_MIDDLE: f64 = 1e-3;

/// Components of nodes.
type Components<const D: usize> = BTreeMap<usize, [bool; D]>;

/// Pairs a side with another, or with an obstacle, by mortar integration.
///
/// Errors: unknown or empty sides, nodes off their true surface, a gap that is not finite.
pub fn pair_mortar<const D: usize>(
    nonmortar: End<'_, D>,
    against: Against<'_, D>,
    gap: InitialGap<'_>,
    coupling: Coupling,
    analysis: Analysis,
    time: f64,
) -> Result<Interface<D>, ContactError> {
    if let Against::Obstacle(Rigid::Tool(tool), driven) = against {
        let side = Against::Side(tool.end(driven));
        let interface = pair_mortar(nonmortar, side, gap, coupling, analysis, time)?;
        return Ok(interface.on_translation());
    }
    let neither = || ContactError::NeitherPlaneNorSpace {
        side: nonmortar.name(),
    };
    let of_plane = (nonmortar.of_dimension(), against.of_dimension());
    if let (Some(nonmortar), Some(against)) = of_plane {
        let sides = Opposite::new(nonmortar, against, gap, time)?;
        let interface = paired(sides, coupling, analysis, pieces::pieces)?;
        return same(interface).ok_or_else(neither);
    }
    let in_space = (nonmortar.of_dimension(), against.of_dimension());
    if let (Some(nonmortar), Some(against)) = in_space {
        let sides = Opposite::new(nonmortar, against, gap, time)?;
        let interface = paired(sides, coupling, analysis, polygons::pieces)?;
        return same(interface).ok_or_else(neither);
    }
    Err(neither())
}

fn paired<const D: usize>(
    sides: Opposite<'_, D>,
    coupling: Coupling,
    analysis: Analysis,
    cut: impl Fn(&Opposite<'_, D>, &[Cell]) -> Vec<Piece>,
) -> Result<Interface<D>, ContactError> {
    let (pairing, pieces) = Pairing::new(sides, coupling, analysis, cut)?;
    pairing.interface(pieces)
}

/// A place on the nonmortar side: a facet and ξ.
type Place = (Facet, [f64; 2]);

/// Contributions of one sheet of the other side to the nodes of the side.
struct Sheet<const D: usize> {
    /// Facets of the other side.
    facets: BTreeSet<Facet>,
    stations: Vec<Station<D>>,
    sums: BTreeMap<usize, Sums<D>>,
    /// Which components of which nodes carry multipliers.
    kept: Components<D>,
    unborne: usize,
}

/// Stands for the piece of a corner, which lies on none.
const AT_CORNER: usize = usize::MAX - 1;

struct Pairing<'a, const D: usize> {
    sides: Opposite<'a, D>,
    coupling: Coupling,
    analysis: Analysis,
    cells: Vec<Cell>,
    /// Nodes in the order of the interface, with one of their places.
    places: Vec<(usize, Place)>,
    /// Places from which nodes are projected to the other side.
    looks: BTreeMap<usize, Place>,
    /// Corners that meet the other side between their faces.
    corners: BTreeMap<usize, Corner<D>>,
    /// Normal and tangents at the nodes.
    frames: BTreeMap<usize, [Point<D>; D]>,
    /// The same with the directions of the corners.
    leaning: BTreeMap<usize, [Point<D>; D]>,
    cyclic: bool,
}

impl<'a, const D: usize> Pairing<'a, D> {
    /// With the pieces that `cut` makes.
    fn new(
        sides: Opposite<'a, D>,
        coupling: Coupling,
        analysis: Analysis,
        cut: impl Fn(&Opposite<'_, D>, &[Cell]) -> Vec<Piece>,
    ) -> Result<(Self, Vec<Piece>), ContactError> {
        let (nonmortar, mesh) = (sides.nonmortar, sides.mesh());
        let mut cyclic = false;
        let facets = match mesh.in_plane() {
            None => nonmortar.facets()?.to_vec(),
            Some(plane) => {
                let chains = plane.chain(nonmortar.side).unwrap_or_default();
                cyclic = nonmortar.part.is_none() && chains.len() == 1 && chains[0].cyclic;
                let of_part =
                    |facet: &Facet| nonmortar.part.is_none_or(|part| part.contains(facet));
                let along = chains.iter().flat_map(|chain| &chain.facets);
                along.copied().filter(of_part).collect()
            }
        };
        let cells: Vec<Cell> = facets
            .into_iter()
            .flat_map(|facet| cells(mesh, facet))
            .collect();
        let mut seen = BTreeSet::new();
        let mut places = Vec::new();
        for cell in &cells {
            for (&node, &xi) in cell.nodes.iter().zip(&cell.places) {
                if seen.insert(node) {
                    places.push((node, (cell.facet, xi)));
                }
            }
        }
        if mesh.in_plane().is_none() {
            places.sort_unstable_by_key(|place| place.0);
        }
        // a tie holds all directions
        let corners = match coupling {
            Coupling::Tied => BTreeMap::new(),
            Coupling::Normal | Coupling::Frictional => sides.corners()?,
        };
        let mut pairing = Self {
            corners,
            frames: BTreeMap::new(),
            leaning: BTreeMap::new(),
            looks: BTreeMap::new(),
            sides,
            coupling,
            analysis,
            cells,
            places,
            cyclic,
        };
        let pieces = cut(&pairing.sides, &pairing.cells);
        pairing.looks = pairing.looks(&pieces);
        let mut normals = pairing.sides.normals.nodal();
        pairing.frames = pairing.frames(&normals);
        if !pairing.corners.is_empty() {
            let corners = pairing.corners.iter();
            normals.extend(corners.map(|(&node, corner)| (node, corner.at.normal)));
            pairing.leaning = pairing.frames(&normals);
        }
        Ok((pairing, pieces))
    }

    /// Places from which the nodes of some pieces are projected to the facets opposite: the node itself, or the nearest place in a piece.
    fn looks(&self, pieces: &[Piece]) -> BTreeMap<usize, Place> {
        let mut nearest: BTreeMap<usize, (f64, Place)> = BTreeMap::new();
        for piece in pieces {
            let cell = &self.cells[piece.cell];
            let corners = piece.corners.len() as f64;
            let middle = [0, 1].map(|d| piece.corners.iter().map(|c| c[d]).sum::<f64>() / corners);
            for (&node, at) in cell.nodes.iter().zip(&cell.places) {
                for corner in &piece.corners {
                    let away = (corner[0] - at[0]).hypot(corner[1] - at[1]);
                    let found = nearest
                        .entry(node)
                        .or_insert((f64::INFINITY, (cell.facet, *at)));
                    if away < found.0 {
                        let inside = |d: usize| corner[d] + TO_MIDDLE * (middle[d] - corner[d]);
                        *found = (away, (cell.facet, [0, 1].map(inside)));
                    }
                }
            }
        }
        let own: BTreeMap<usize, Place> = self.places.iter().copied().collect();
        let among: BTreeSet<Facet> = pieces.iter().filter_map(|p| p.opposite).collect();
        let from = |(node, (_, nearest)): (usize, (f64, Place))| {
            let (facet, xi) = own[&node];
            let faces = self.sides.facing(facet, self.sides.line(facet, &xi));
            let faces = faces.is_some_and(|hit| among.contains(&hit.facet));
            (node, if faces { (facet, xi) } else { nearest })
        };
        nearest.into_iter().map(from).collect()
    }

    /// Normal and tangents at the nodes. A node and those that take its shear must have the same tangents: under friction those of an
    /// oblique direction held somewhere, in a tie those of no supports or, where these are not among them, of a direction held somewhere.
    /// Without one, or if other supports disagree with it, they follow the supports of the node.
    fn frames(&self, normals: &BTreeMap<usize, Point<D>>) -> BTreeMap<usize, [Point<D>; D]> {
        let normal = |node: usize| normals.get(&node).copied().unwrap_or([0.0; D]);
        let oblique =
            |&(node, _): &(usize, _)| self.relative(node, &self.looks).oblique(normal(node));
        let held_at = |node: usize| axes(self.sides.nonmortar.constraints.at(node), |_| true);
        let among = |node: usize, directions: &[Point<D>]| {
            let frame = frame(normal(node), directions);
            Some(frame).filter(|frame| separates(frame, &held_at(node)))
        };
        // a direction held somewhere that is not among the tangents of no supports
        let turned = |&(node, _): &(usize, _)| match among(node, &[]) {
            Some(_) => None,
            None => held_at(node)
                .into_iter()
                .find(|h| free_part(*h, [normal(node)]).is_some()),
        };
        let common: Option<Vec<Point<D>>> = match self.coupling {
            Coupling::Frictional => self.places.iter().find_map(oblique).map(|o| vec![o]),
            Coupling::Tied => Some(self.places.iter().find_map(turned).into_iter().collect()),
            Coupling::Normal => None,
        };
        let frame_at = |&(node, _): &(usize, _)| {
            let common = common.as_ref().and_then(|common| among(node, common));
            (
                node,
                common.unwrap_or_else(|| frame(normal(node), &held_at(node))),
            )
        };
        self.places.iter().map(frame_at).collect()
    }

    fn mesh(&self) -> &'a Mesh<D> {
        self.sides.mesh()
    }

    /// The opposite of a facet at ξ (a facet of the other side or its continuation, or the obstacle), and the point where the line from
    /// there meets it; `None` where it misses.
    ///
    /// Errors: a gap that is not finite.
    fn seen(
        &self,
        facet: Facet,
        xi: [f64; 2],
        opposite: Option<Facet>,
    ) -> Result<Option<(GapPoint<D>, Option<Hit>)>, ContactError> {
        let line = self.sides.line(facet, &xi);
        let own = shape(self.mesh(), facet, &xi);
        Ok(match (self.sides.against, opposite) {
            (Against::Side(mortar), Some(other)) => match meet(&mortar.body.mesh, other, line) {
                Some(hit) => {
                    let at = GapPoint {
                        own,
                        opposite: shape(&mortar.body.mesh, other, &hit.xi),
                        normal: line.direction,
                        gap: self.sides.gap_at(facet, line, hit)?,
                    };
                    Some((at, Some(hit)))
                }
                None => None,
            },
            (Against::Obstacle(..), _) => {
                let found = self.sides.obstacle(facet, line)?;
                found.map(|(normal, gap)| {
                    let at = GapPoint {
                        own,
                        opposite: vec![(0, 1.0)],
                        normal,
                        gap,
                    };
                    (at, None)
                })
            }
            (Against::Side(_), None) => None,
        })
    }

    /// Everything at a point of a piece; `None` where the line misses the facet by rounding of a tangent.
    fn station(
        &self,
        (index, piece): (usize, &Piece),
        xi: [f64; 2],
        reference: f64,
    ) -> Result<Option<Station<D>>, ContactError> {
        let facet = self.cells[piece.cell].facet;
        let Some((at, hit)) = self.seen(facet, xi, piece.opposite)? else {
            return Ok(None);
        };
        let mesh = self.mesh();
        let extent = reference * norm(mesh.outward_normal(facet, &xi));
        let thickness = self.sides.nonmortar.body.thickness;
        let start = mesh.facet_point(facet, &xi);
        Ok(Some(Station {
            cell: piece.cell,
            piece: index,
            xi,
            area: extent * measure(self.analysis, thickness, start),
            extent,
            at,
            hit,
        }))
    }

    fn interface(&self, pieces: Vec<Piece>) -> Result<Interface<D>, ContactError> {
        let missed = self.missed(&pieces);
        let whole = self.whole_weights();
        let ties = self.coupling == Coupling::Tied;
        let sheets = sheets(&self.cells, pieces, self.sides.against, ties)?;
        let sheets = sheets.iter().map(|pieces| self.sheet(pieces, &whole));
        let sheets = sheets.collect::<Result<Vec<_>, _>>()?;
        Ok(Interface {
            missed,
            ..self.assembled(sheets, &whole)?
        })
    }

    /// Contributions of one sheet of the other side to the nodes.
    fn sheet(
        &self,
        pieces: &[Piece],
        whole: &BTreeMap<usize, f64>,
    ) -> Result<Sheet<D>, ContactError> {
        let stations = self.stations(pieces)?;
        let mut sums: BTreeMap<usize, Sums<D>> = BTreeMap::new();
        for (index, station) in stations.iter().enumerate() {
            let cell = &self.cells[station.cell];
            for (&node, hat) in cell.nodes.iter().zip(cell.hats(station.xi)) {
                let sums = sums.entry(node).or_insert_with(Sums::new);
                sums.own += hat * station.area;
                sums.hats.push((index, hat * station.area));
            }
        }
        let looks = self.looks(pieces);
        let kept = self.kept(&sums, whole, (&stations, &looks));
        let implied = self.implied();
        let facets: BTreeSet<Facet> = pieces.iter().filter_map(|piece| piece.opposite).collect();
        let cover = Cover::new(&self.cells, pieces);
        // pieces follow the side, so the stations of a facet follow one another
        let facet = |station: &Station<D>| self.cells[station.cell].facet;
        let mut first = 0;
        let of_facets = stations.chunk_by(|a, b| facet(a) == facet(b)).map(|chunk| {
            first += chunk.len();
            (first - chunk.len(), chunk)
        });
        let of_facets: Vec<(usize, &[Station<D>])> = of_facets.collect();
        let shares = of_facets.par_iter().map(|&(first, stations)| {
            self.shares(first, stations, (&kept, &implied), (&cover, &facets))
        });
        for share in in_order(shares)?.into_iter().flatten() {
            if let Some(sums) = sums.get_mut(&share.node) {
                sums.add(share);
            }
        }
        Ok(Sheet {
            facets,
            unborne: self.unborne(&stations, &kept, &implied),
            sums,
            kept,
            stations,
        })
    }

    /// Number of sample points in the cells that face the other side outside of every piece, and of all that face it. Facets face an
    /// obstacle as a whole.
    fn missed(&self, pieces: &[Piece]) -> [usize; 2] {
        let mut of_cells = vec![0..0; self.cells.len()];
        let mut first = 0;
        for of_cell in pieces.chunk_by(|a, b| a.cell == b.cell) {
            of_cells[of_cell[0].cell] = first..first + of_cell.len();
            first += of_cell.len();
        }
        let each = self.cells.par_iter().zip(of_cells);
        let each = each.map(|(cell, own)| {
            let places = cell.rule(LOOKED_AT).map(|(xi, _)| xi);
            let faces = |xi: &[f64; 2]| {
                let line = self.sides.line(cell.facet, xi);
                self.sides.facing(cell.facet, line).is_some()
            };
            let facing: Vec<[f64; 2]> = places.filter(faces).collect();
            let beside = |xi: &&[f64; 2]| !pieces[own.clone()].iter().any(|p| p.near(**xi));
            [facing.iter().filter(beside).count(), facing.len()]
        });
        each.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
    }

    /// Components of the shear that follow from the normal condition.
    fn implied(&self) -> Components<D> {
        if self.coupling != Coupling::Frictional {
            return BTreeMap::new();
        }
        let implied = |&(node, _): &(usize, Place)| {
            let frame = self.frames[&node];
            let oblique = self.relative(node, &self.looks).oblique(frame[0])?;
            Some((node, tangents_along(&frame, oblique)))
        };
        self.places.iter().filter_map(implied).collect()
    }

    /// Whether some nodes have a component of the shear along the same direction, and some of them leave theirs to the others.
    fn shared(
        &self,
        nodes: &[usize],
        component: usize,
        (kept, implied): (&Components<D>, &Components<D>),
    ) -> bool {
        let leaves = |node: &&usize| implied.get(node).is_some_and(|implied| implied[component]);
        let Some(first) = nodes.iter().find(leaves) else {
            return false;
        };
        let along = |node: &usize| self.frames[node][component];
        let mut others = nodes.iter().filter(|node| kept[node][component]).peekable();
        others.peek().is_some() && others.all(|node| dot(along(node), along(first)) > ALIKE)
    }

    /// Number of nodes that leave a component of their shear to neighbours without that component.
    fn unborne(
        &self,
        stations: &[Station<D>],
        kept: &Components<D>,
        implied: &Components<D>,
    ) -> usize {
        let mut borne: Components<D> = BTreeMap::new();
        for of_cell in stations.chunk_by(|a, b| a.cell == b.cell) {
            let nodes = &self.cells[of_cell[0].cell].nodes;
            let by_some: [bool; D] =
                std::array::from_fn(|c| self.shared(nodes, c, (kept, implied)));
            for node in nodes.iter().filter(|node| implied.contains_key(node)) {
                let borne = borne.entry(*node).or_insert([false; D]);
                *borne = std::array::from_fn(|c| borne[c] || by_some[c]);
            }
        }
        let lacks =
            |(node, borne): &(&usize, &[bool; D])| (1..D).any(|c| implied[node][c] && !borne[c]);
        borne.iter().filter(lacks).count()
    }

    /// Constraints by supports on the motion of a node relative to the other side.
    fn relative(&self, node: usize, looks: &BTreeMap<usize, Place>) -> Relative<D> {
        let held = self.sides.nonmortar.constraints.at(node);
        let place = looks.get(&node);
        if self.opposite_itself(node, place) {
            return Relative::none();
        }
        let still = |h: &Held<D>| h.still && self.opposite_held(place, h.axis, true);
        Relative {
            prescribed: axes(held, |_| true),
            still: axes(held, still),
        }
    }

    /// The points of integration of all pieces.
    fn stations(&self, pieces: &[Piece]) -> Result<Vec<Station<D>>, ContactError> {
        let each = pieces.par_iter().enumerate().map(|piece| {
            let points = piece.1.points.iter();
            let stations =
                points.filter_map(|&(xi, weight)| self.station(piece, xi, weight).transpose());
            stations.collect::<Result<Vec<_>, _>>()
        });
        Ok(in_order(each)?.into_iter().flatten().collect())
    }

    /// ∫ of the hat of every node over the whole side.
    fn whole_weights(&self) -> BTreeMap<usize, f64> {
        let thickness = self.sides.nonmortar.body.thickness;
        let mesh = self.mesh();
        let mut whole = BTreeMap::new();
        for cell in &self.cells {
            for (xi, weight) in cell.rule(DEGREE) {
                let extent = weight * norm(mesh.outward_normal(cell.facet, &xi));
                let point = mesh.facet_point(cell.facet, &xi);
                let area = extent * measure(self.analysis, thickness, point);
                for (&node, hat) in cell.nodes.iter().zip(cell.hats(xi)) {
                    *whole.entry(node).or_insert(0.0) += hat * area;
                }
            }
        }
        whole
    }

    /// Which components of which nodes carry multipliers.
    fn kept(
        &self,
        sums: &BTreeMap<usize, Sums<D>>,
        whole: &BTreeMap<usize, f64>,
        (stations, looks): (&[Station<D>], &BTreeMap<usize, Place>),
    ) -> Components<D> {
        let covered = |node: &usize| sums.get(node).map_or(0.0, |s| s.own) / whole[node];
        let decided = |&(node, _): &(usize, Place)| {
            let frame = self.frames[&node];
            let held = self.relative(node, looks).decided(frame, self.coupling);
            let led = |c: usize| held[c] && c > 0 && self.leads((node, looks.get(&node)), frame[c]);
            (node, std::array::from_fn(|c| !held[c] || led(c)))
        };
        let mut kept: Components<D> = self.places.iter().map(decided).collect();
        let cells: BTreeSet<usize> = stations.iter().map(|station| station.cell).collect();
        // a prescribed node gives its functions to its neighbours; where all of a cell are prescribed they keep their own
        let coupled = match self.coupling {
            Coupling::Tied => D,
            _ => 1,
        };
        let decided = kept.clone();
        for component in 0..coupled {
            let lone = |cell: &&usize| {
                let nodes = &self.cells[**cell].nodes;
                nodes.iter().all(|node| !decided[node][component])
            };
            let alone = cells.iter().filter(lone);
            let nodes = alone.flat_map(|&cell| &self.cells[cell].nodes);
            let nodes: BTreeSet<usize> = nodes.copied().collect();
            for node in nodes {
                let axis = self.frames[&node][component];
                let place = looks.get(&node);
                if self.opposite_itself(node, place) || self.opposite_held(place, axis, false) {
                    continue;
                }
                if let Some(own) = kept.get_mut(&node) {
                    own[component] = true;
                    own[1..]
                        .iter_mut()
                        .for_each(|shear| *shear |= self.coupling == Coupling::Frictional);
                }
            }
        }
        // a sliver leaves its force to neighbours with a larger covered part
        for cell in cells {
            let nodes = &self.cells[cell].nodes;
            for node in nodes {
                let more = |other: &usize| covered(other) > covered(node) && kept[other][0];
                if covered(node) < SLIVER && nodes.iter().any(more) {
                    kept.insert(*node, [false; D]);
                }
            }
        }
        kept
    }

    /// Contributions of a facet to its nodes; its stations are those from `first` on, opposite facets of one sheet.
    ///
    /// Errors: a gap that is not finite.
    fn shares(
        &self,
        first: usize,
        stations: &[Station<D>],
        (kept, implied): (&Components<D>, &Components<D>),
        (cover, faced): (&Cover, &BTreeSet<Facet>),
    ) -> Result<Vec<Share<D>>, ContactError> {
        let facet = self.cells[stations[0].cell].facet;
        let (kind, of_facet) = functions(self.mesh(), facet);
        let mut shares: BTreeMap<usize, Share<D>> = BTreeMap::new();
        // under friction shear and pressure share functions and weights, except for shear that goes to neighbours
        let apart = |c: &usize| {
            self.coupling == Coupling::Tied || self.shared(&of_facet, *c, (kept, implied))
        };
        let (own, common): (Vec<usize>, Vec<usize>) = (1..D).partition(apart);
        let with_normal = std::iter::once(0).chain(common).collect();
        let mut groups: Vec<(usize, Vec<usize>)> = vec![(0, with_normal)];
        groups.extend(own.into_iter().map(|c| (c, vec![c])));
        for (shared, components) in groups {
            let carries = |node: &usize| kept[node][shared];
            let whole = match cover.facet(facet) && of_facet.iter().all(carries) {
                true => Basis::of_facet(kind, stations.iter().map(|s| (s.xi, s.area))),
                false => None,
            };
            // a mean over a part of a facet would compare the gap at a corner with displacements elsewhere
            let at_corners = whole.is_none();
            // the parts with functions of their own: the whole facet, or its cells
            let parts = match whole {
                Some(basis) => vec![(stations, &of_facet, basis)],
                None => {
                    let of_cells = stations.chunk_by(|a, b| a.cell == b.cell);
                    let of_cells = of_cells.map(|stations| {
                        let (index, points) = (stations[0].cell, stations.iter());
                        let cell = &self.cells[index];
                        let covered = cover.of_cell(index);
                        let covered = covered.filter(|_| cell.nodes.iter().all(carries));
                        let points = points.map(|s| (s.xi, s.area));
                        let basis = covered.and_then(|c| Basis::of_cell(cell, c, points));
                        (stations, &cell.nodes, basis.unwrap_or(Basis::Hats))
                    });
                    of_cells.collect()
                }
            };
            let mut index = first;
            for (stations, nodes, basis) in parts {
                let carrying: Vec<bool> = nodes.iter().map(carries).collect();
                let corners = nodes.iter().map(|&node| self.corner(node, faced));
                let corners: Vec<Option<&Corner<D>>> = corners.collect();
                let mut weights = [0.0; FUNCTIONS];
                for station in stations {
                    let cell = &self.cells[station.cell];
                    let lever = self.lever(station);
                    let psi = basis.values(cell, station.xi, &carrying);
                    let parts = basis.shares(cell, station.xi, &carrying);
                    for (k, &node) in nodes.iter().enumerate() {
                        let share = shares.entry(node).or_insert_with(|| Share::new(node));
                        if shared == 0 {
                            share.extent += parts[k] * station.extent;
                        }
                        let weight = psi[k] * station.area;
                        let corner = corners[k];
                        let frame = match corner {
                            Some(_) => self.leaning[&node],
                            None => carried(self.frames[&node], station.at.normal),
                        };
                        let kept = components.iter().filter(|&&c| kept[&node][c]);
                        let within = weight != 0.0 && !(at_corners && corner.is_some());
                        for &component in kept.filter(|_| within) {
                            let along = (component, frame[component]);
                            let lever =
                                lever.as_ref().filter(|_| component > 0 || corner.is_some());
                            share.add(along, weight, station, lever);
                            if component == 0 && matches!(basis, Basis::Hats) {
                                share.take_gap(GapAt::Station(index), weight);
                            }
                        }
                        weights[k] += weight;
                    }
                    index += 1;
                }
                for (k, &node) in nodes.iter().enumerate() {
                    let share = shares.entry(node).or_insert_with(|| Share::new(node));
                    match corners[k] {
                        Some(corner) if at_corners => {
                            let kept = components.iter().filter(|&&c| kept[&node][c]);
                            let kept = kept.copied().filter(|_| weights[k] != 0.0);
                            self.add_corner((node, corner), kept, weights[k], share);
                        }
                        _ if shared > 0 || !carrying[k] => {}
                        corner => {
                            if let Some(place) = basis.acts_at(k) {
                                let at = match corner {
                                    Some(corner) => corner.at.clone(),
                                    None => self.gap_at(facet, place, stations)?,
                                };
                                share.take_gap(GapAt::Place(at), weights[k]);
                            }
                        }
                    }
                }
            }
        }
        Ok(shares.into_values().collect())
    }

    /// Adds the rows of a corner with a weight: of its own displacement, and of that of the place which it meets.
    fn add_corner(
        &self,
        (node, corner): (usize, &Corner<D>),
        components: impl Iterator<Item = usize>,
        weight: f64,
        share: &mut Share<D>,
    ) {
        let lever = match self.sides.against {
            Against::Side(mortar) => Some(Lever::new(&mortar.body.mesh, corner.hit, corner.along)),
            Against::Obstacle(..) => None,
        };
        let station = Station {
            cell: 0,
            piece: AT_CORNER,
            xi: [0.0; 2],
            area: 0.0,
            extent: 0.0,
            at: corner.at.clone(),
            hit: Some(corner.hit),
        };
        for component in components {
            let along = (component, self.leaning[&node][component]);
            share.add(along, weight, &station, lever.as_ref());
            if component == 0 {
                share.take_gap(GapAt::Place(corner.at.clone()), weight);
            }
        }
    }

    /// A corner that meets one of some facets of the other side between its faces.
    fn corner(&self, node: usize, faced: &BTreeSet<Facet>) -> Option<&Corner<D>> {
        let corner = self.corners.get(&node);
        corner.filter(|corner| faced.contains(&corner.hit.facet))
    }

    /// The gap at a place of a facet to the sheet that some of its stations face, by the pairing of the nearest of these.
    ///
    /// Errors: a gap that is not finite.
    fn gap_at(
        &self,
        facet: Facet,
        xi: [f64; 2],
        stations: &[Station<D>],
    ) -> Result<GapPoint<D>, ContactError> {
        let away = |station: &Station<D>| (station.xi[0] - xi[0]).hypot(station.xi[1] - xi[1]);
        let nearest = stations.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let nearest = nearest.unwrap_or(&stations[0]);
        let across = match (self.sides.against, nearest.hit) {
            (Against::Side(_), Some(hit)) => Some(hit.facet),
            _ => None,
        };
        let seen = self.seen(facet, xi, across)?;
        Ok(seen.map_or_else(|| nearest.at.clone(), |(at, _)| at))
    }

    /// The lever of tangential rows at a station, and of those of corners that lean, due to the distance between the sides; `None` without
    /// such rows.
    fn lever(&self, station: &Station<D>) -> Option<Lever<D>> {
        match (self.sides.against, station.hit) {
            (Against::Side(mortar), Some(hit))
                if self.coupling != Coupling::Normal || !self.corners.is_empty() =>
            {
                Some(Lever::new(&mortar.body.mesh, hit, station.at.normal))
            }
            _ => None,
        }
    }

    /// All sheets together: a node has an entry for each sheet on which it carries multipliers or is fixed, or one without an opposite.
    fn assembled(
        &self,
        sheets: Vec<Sheet<D>>,
        whole: &BTreeMap<usize, f64>,
    ) -> Result<Interface<D>, ContactError> {
        let mut interface = Interface {
            cyclic: self.cyclic && sheets.len() < 2,
            unborne: sheets.iter().map(|sheet| sheet.unborne).sum(),
            ..Interface::empty(self.coupling)
        };
        // indices of the interface points made of stations
        let mut taken: Vec<BTreeMap<usize, usize>> = vec![BTreeMap::new(); sheets.len()];
        for &(node, place) in &self.places {
            let before = interface.nodes.len();
            for (sheet, taken) in sheets.iter().zip(&mut taken) {
                let sums = sheet.sums.get(&node);
                if let Some(sums) = sums.filter(|sums| sums.own > SLIVER * whole[&node]) {
                    let entry = self.on_sheet((node, place), (sheet, sums), taken, &mut interface);
                    let share = sums.own / whole[&node];
                    interface.nodes.push(InterfaceNode { share, ..entry? });
                }
            }
            if interface.nodes.len() == before {
                interface.nodes.push(InterfaceNode {
                    node,
                    opposite: Vec::new(),
                    frame: self.frames[&node],
                    weight: whole[&node],
                    extent: 0.0,
                    share: 0.0,
                    gap: f64::NAN,
                    clearance: f64::NAN,
                    shares: GapShares::default(),
                    role: Role::Alone,
                    rows: [None; D],
                });
            }
        }
        Ok(interface)
    }

    /// A node on a sheet; its rows and points are added to the interface.
    ///
    /// Errors: a gap that is not finite.
    fn on_sheet(
        &self,
        (node, (facet, xi)): (usize, Place),
        (sheet, sums): (&Sheet<D>, &Sums<D>),
        taken: &mut BTreeMap<usize, usize>,
        interface: &mut Interface<D>,
    ) -> Result<InterfaceNode<D>, ContactError> {
        let mut entry = InterfaceNode {
            node,
            opposite: Vec::new(),
            frame: self.frames[&node],
            weight: sums.own,
            extent: 0.0,
            share: 0.0,
            gap: f64::NAN,
            clearance: f64::NAN,
            shares: GapShares::default(),
            role: Role::Fixed,
            rows: [None; D],
        };
        let among = |other: Facet| sheet.facets.contains(&other);
        if let Some(corner) = self.corner(node, &sheet.facets) {
            let at = &corner.at;
            entry.frame = self.leaning[&node];
            (entry.opposite, entry.clearance) = (at.opposite.clone(), at.gap);
            entry.shares.at_node = Some(interface.points.len());
            interface.points.push(at.clone());
        } else if let Some(found) = self.sides.at_among(facet, &xi, among)? {
            (entry.opposite, entry.clearance) = (found.nodes.clone(), found.gap);
            entry.shares.at_node = Some(interface.points.len());
            interface.points.push(GapPoint {
                own: vec![(node, 1.0)],
                opposite: found.nodes,
                normal: self.sides.line(facet, &xi).direction,
                gap: found.gap,
            });
        }
        let points = &mut interface.points;
        let mut of_station = |station: usize, points: &mut Vec<GapPoint<D>>| {
            *taken.entry(station).or_insert_with(|| {
                points.push(sheet.stations[station].at.clone());
                points.len() - 1
            })
        };
        if sheet.kept[&node][0] && sums.weight[0] > 0.0 {
            for (at, weight) in &sums.gaps {
                let point = match at {
                    GapAt::Station(station) => of_station(*station, points),
                    GapAt::Place(at) => {
                        points.push(at.clone());
                        points.len() - 1
                    }
                };
                entry.shares.mean.push((point, *weight));
            }
            if let Some(normal) = unit(sums.normal) {
                entry.frame = carried(entry.frame, normal);
            }
        } else {
            let hats = sums.hats.iter();
            let hats = hats.map(|&(station, weight)| (of_station(station, points), weight));
            entry.shares.mean = hats.collect();
        }
        let gaps = entry.shares.mean.iter();
        let gaps = gaps.map(|&(point, weight)| weight * interface.points[point].gap);
        let weights: f64 = entry.shares.mean.iter().map(|share| share.1).sum();
        entry.gap = gaps.sum::<f64>() / weights;
        if entry.clearance.is_nan() {
            entry.clearance = entry.gap;
        }
        for component in (0..D).filter(|&c| sheet.kept[&node][c] && sums.weight[c] > 0.0) {
            if entry.role == Role::Fixed {
                (entry.weight, entry.extent) = (sums.weight[component], sums.extent);
            }
            entry.role = Role::Multiplier;
            entry.rows[component] = Some(interface.nonmortar.len());
            let divisor = match self.coupling {
                Coupling::Tied => component,
                _ => 0,
            };
            let [own, other] = sums.rows(component, sums.weight[divisor]);
            interface.nonmortar.push(own);
            interface.mortar.push(other);
        }
        Ok(entry)
    }

    /// Whether the other side of a tie, free along an axis, has to follow a held node: without a condition of the node it would part from
    /// it at its edge. Where its facets are larger, neighbours of the node hold it well enough, and one condition for each node would
    /// hold more than its edge.
    fn leads(&self, (node, place): (usize, Option<&Place>), axis: Point<D>) -> bool {
        let Against::Side(mortar) = self.sides.against else {
            return false;
        };
        if self.coupling != Coupling::Tied || self.opposite_itself(node, place) {
            return false;
        }
        let finer = |(facet, _): &Place| {
            let own = self.mesh().facet_length(*facet);
            let found = self.opposite(place)?;
            Some(mortar.body.mesh.facet_length(found.facet) <= own * (1.0 + SAME_LENGTH))
        };
        place.and_then(finer).unwrap_or(false) && !self.opposite_held(place, axis, false)
    }

    /// Whether a node is opposite itself, as that at the tip of a slit is: it does not move relative to the other side.
    fn opposite_itself(&self, node: usize, place: Option<&Place>) -> bool {
        let itself = |&(other, shape): &(usize, f64)| other == node && shape > 0.5;
        self.sides.common.contains(&node)
            && (self.opposite(place)).is_some_and(|found| found.nodes.iter().any(itself))
    }

    /// What is opposite a place; `None` also where a gap there is not finite, which is told elsewhere.
    fn opposite(&self, place: Option<&Place>) -> Option<Found> {
        place.and_then(|(facet, xi)| self.sides.at(*facet, xi).ok().flatten())
    }

    /// Whether the motion of the other side along an axis is prescribed opposite a place; with `still`, whether it is zero at all
    /// times. Without a place there is nothing that moves.
    fn opposite_held(&self, place: Option<&Place>, axis: Point<D>, still: bool) -> bool {
        let mortar = match self.sides.against {
            Against::Obstacle(_, Driven::Free) => return false,
            Against::Obstacle(_, driven) => return driven == Driven::Still || !still,
            Against::Side(mortar) => mortar,
        };
        let opposite = self.opposite(place);
        let held = |node: usize| {
            let held = axes(mortar.constraints.at(node), |h| h.still || !still);
            let part: f64 = held.iter().map(|&h| dot(h, axis).powi(2)).sum();
            part > 1.0 - 1e-6
        };
        let bearing = |&&(_, shape): &&(usize, f64)| shape.abs() > 1e-6;
        opposite.is_none_or(|found| {
            let mut bearing = found.nodes.iter().filter(bearing);
            bearing.all(|(node, _)| held(*node))
        })
    }
}

/// An interface of one dimension as that of the same dimension.
fn same<const D: usize, const E: usize>(interface: Interface<D>) -> Option<Interface<E>> {
    let any: Box<dyn Any> = Box::new(interface);
    any.downcast().ok().map(|same| *same)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, end, flat, held, node_at, ring, wall};
    use crate::contact::{Rigid, Row, pair_nodes};
    use crate::fem::quadrature;
    use crate::fem::{Body, Constraints};
    use crate::geometry::{Field, Surface, add_scaled, distance};
    use crate::mesh::{CellKind, Cuboid};

    /// The bottom of a body over a side of another, without supports.
    fn over<const D: usize>(
        own: &Body<D>,
        (other, side): (&Body<D>, &str),
        coupling: Coupling,
        analysis: Analysis,
    ) -> Interface<D> {
        let free = Constraints::default();
        let against = Against::Side(end(other, side, &free));
        let nonmortar = end(own, "bottom", &free);
        let gap = InitialGap::Measured;
        pair_mortar(nonmortar, against, gap, coupling, analysis, 0.0).unwrap()
    }

    /// Both sides in the plane.
    fn paired(own: &Body<2>, other: &Body<2>, coupling: Coupling) -> Interface<2> {
        over(own, (other, "bottom"), coupling, Analysis::PlaneStrain)
    }

    /// Lost pieces are noticed whatever the reason: independent points show which parts face the other side.
    #[test]
    fn pieces_that_are_lost_are_missed() {
        let (upper, lower) = (
            flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4),
            flat(&[0.0, 0.7, 2.5], -1.0, CellKind::Quad4),
        );
        let free = Constraints::default();
        let against = Against::Side(end(&lower, "bottom", &free));
        let nonmortar = end(&upper, "bottom", &free);
        let sides = Opposite::new(nonmortar, against, InitialGap::Closed, 0.0).unwrap();
        let (coupling, analysis) = (Coupling::Normal, Analysis::PlaneStrain);
        let pairing = Pairing::new(sides, coupling, analysis, pieces::pieces);
        let (pairing, _) = pairing.unwrap();
        let pieces = || pieces::pieces(&pairing.sides, &pairing.cells);
        let looked_at = pairing.cells.len() * pairing.cells[0].rule(LOOKED_AT).count();
        assert_eq!(pairing.interface(pieces()).unwrap().missed, [0, looked_at]);
        let mut fewer = pieces();
        fewer.pop();
        let [missed, facing] = pairing.interface(fewer).unwrap().missed;
        assert!(missed > 0 && facing == looked_at);
    }

    /// A row times the displacements of its body, given as a function of place.
    fn times<const D: usize>(
        row: &Row<D>,
        body: &Body<D>,
        u: impl Fn(Point<D>) -> Point<D>,
    ) -> f64 {
        let points = body.mesh.points();
        row.iter().map(|&(node, c)| dot(c, u(points[node]))).sum()
    }

    fn arc(from: f64, to: f64, count: usize, lift: f64) -> Vec<Point<2>> {
        let place = |k: usize| from + (to - from) * k as f64 / (count - 1) as f64;
        let points = (0..count).map(place);
        points.map(|x| [x, 0.15 * x * x + lift]).collect()
    }

    #[test]
    fn a_rigid_motion_of_both_bodies_together_neither_opens_nor_slips() {
        let motion = |[x, y]: Point<2>| [0.3 - 0.7 * y, -0.2 + 0.7 * x];
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            for other in [CellKind::Quad4, CellKind::Quad8] {
                let upper = wall(&arc(-1.5, 1.5, 9, 0.0), 4.0, cell);
                let lower = wall(&arc(-1.2, 2.0, 7, -0.3), -3.0, other);
                for coupling in [Coupling::Frictional, Coupling::Tied] {
                    let interface = paired(&upper, &lower, coupling);
                    assert!(interface.nonmortar.len() >= 14);
                    for (own, other) in interface.nonmortar.iter().zip(&interface.mortar) {
                        let moved = times(own, &upper, motion) + times(other, &lower, motion);
                        // rounding
                        assert!(moved.abs() < 1e-13, "{moved}");
                    }
                }
            }
        }
    }

    #[test]
    fn rows_times_their_weights_add_up_to_the_integrals_over_what_is_covered() {
        // from 0.5 to 3.5, of the thickness 2
        let us = |[x, _]: Point<2>| [1.0 + 0.5 * x, 0.3 + 0.2 * x];
        let um = |[x, _]: Point<2>| [2.0 - 0.5 * x, 0.1 * x];
        let free = Constraints::default();
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            for other in [CellKind::Quad4, CellKind::Quad8] {
                let mut upper = flat(&[0.0, 1.0, 2.0, 3.0, 4.0], 1.0, cell);
                upper.thickness = 2.0;
                let lower = flat(&[0.5, 1.3, 2.1, 2.7, 3.5], -1.0, other);
                let gap = Field::function("x² t", |p, t| p[0] * p[0] * t);
                let interface = pair_mortar(
                    end(&upper, "bottom", &free),
                    Against::Side(end(&lower, "bottom", &free)),
                    InitialGap::Given(&gap),
                    Coupling::Frictional,
                    Analysis::PlaneStress,
                    3.0,
                );
                let interface = interface.unwrap();
                let sum = |f: &dyn Fn(&InterfaceNode<2>) -> f64| -> f64 {
                    interface.carriers().map(|node| node.weight * f(node)).sum()
                };
                let row = |node: &InterfaceNode<2>, component: usize| node.rows[component].unwrap();
                let (own, other) = (&interface.nonmortar, &interface.mortar);
                let found = [
                    sum(&|_| 1.0),
                    interface.carriers().map(|node| node.extent).sum(),
                    sum(&|node| node.gap),
                    sum(&|node| times(&own[row(node, 0)], &upper, us)),
                    sum(&|node| times(&own[row(node, 1)], &upper, us)),
                    sum(&|node| times(&other[row(node, 0)], &lower, um)),
                    sum(&|node| times(&other[row(node, 1)], &lower, um)),
                ];
                // the normal is −y, the tangent +x; the gap is taken at 0.5, 1, 2, 3 and 3.5
                let trapezia = 0.25 * 1.25 + 0.5 * 5.0 + 0.5 * 13.0 + 0.25 * 21.25;
                let expected = [6.0, 3.0, 6.0 * trapezia, -4.2, 12.0, 1.2, -6.0];
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn nodes_of_covered_facets_have_rows_of_their_own() {
        let places = [0.0, 1.0, 2.0, 3.0, 4.0];
        for (cell, weights) in [
            (CellKind::Quad4, [0.5, 1.0, 1.0, 1.0, 0.5]),
            // a third, four thirds, two thirds of a half
            (
                CellKind::Quad8,
                [1.0, 4.0, 2.0, 4.0, 1.0].map(|w: f64| w / 3.0),
            ),
        ] {
            let upper = flat(&places, 1.0, cell);
            let sloping = [-1.0, 0.7, 2.3, 4.5].map(|x| [x, -1.0 + 0.1 * x]);
            let lower = wall(&sloping, -3.0, CellKind::Quad4);
            let interface = paired(&upper, &lower, Coupling::Frictional);
            let nodes = interface.nodes.iter().zip(places).zip(weights);
            for ((node, x), weight) in nodes {
                assert_eq!(node.node, node_at(&upper, [x, 0.0]));
                assert!((node.weight - weight).abs() < 1e-13 && node.extent > 0.0);
                if x == 4.0 {
                    // the corner leans to the slope that rises towards it, its row with it
                    let slope = unit([0.1, -1.0]).unwrap();
                    assert!(distance(node.normal(), slope) < 1e-12);
                    assert!((node.gap - 0.6 * -slope[1]).abs() < 1e-12, "{}", node.gap);
                    let own = &interface.nonmortar[node.rows[0].unwrap()];
                    let at = own.iter().find(|(j, _)| *j == node.node).unwrap().1;
                    assert!(distance(at, slope) < 1e-12);
                    continue;
                }
                // a mean of a linear gap is that at the node
                assert!((node.gap - (1.0 - 0.1 * x)).abs() < 1e-12, "{}", node.gap);
                assert!((node.clearance - (1.0 - 0.1 * x)).abs() < 1e-13);
                let point = &interface.points[node.shares.at_node.unwrap()];
                assert_eq!(point.own, [(node.node, 1.0)]);
                for (row, direction) in node.rows.into_iter().zip([[0.0, -1.0], [1.0, 0.0]]) {
                    let row = row.unwrap();
                    for &(j, c) in &interface.nonmortar[row] {
                        let own = f64::from(u8::from(j == node.node));
                        let rest = add_scaled(c, -own, direction);
                        assert!(norm(rest) < 1e-12, "{c:?}");
                    }
                    if direction[1] != 0.0 {
                        // linear displacements of the other side are taken at the node as well
                        let u = |[x, _]: Point<2>| [9.0, 2.0 + x];
                        let found = times(&interface.mortar[row], &lower, u);
                        assert!((found - (2.0 + x)).abs() < 1e-12, "{found}");
                    }
                }
            }
        }
    }

    #[test]
    fn on_matching_meshes_rows_are_those_of_the_pairs() {
        let places = [0.0, 1.0, 1.8, 3.0, 4.0];
        let (upper, lower) = (
            flat(&places, 1.0, CellKind::Quad4),
            flat(&places, -1.0, CellKind::Quad4),
        );
        let free = Constraints::default();
        let mortar = paired(&upper, &lower, Coupling::Frictional);
        let ends = [end(&upper, "bottom", &free), end(&lower, "bottom", &free)];
        let (gap, coupling) = (InitialGap::Measured, Coupling::Frictional);
        let analysis = Analysis::PlaneStrain;
        let nodal = pair_nodes(ends[0], ends[1], gap, coupling, analysis, 0.0).unwrap();
        let u = |[x, y]: Point<2>| [(3.0 * x).sin() + y, (2.0 * x).cos()];
        for (a, b) in mortar.nodes.iter().zip(&nodal.nodes) {
            assert_eq!((a.node, a.rows, a.role), (b.node, b.rows, b.role));
            assert!((a.weight - b.weight).abs() < 1e-13 && (a.extent - b.extent).abs() < 1e-13);
        }
        let rows = |interface: &Interface<2>| -> Vec<[f64; 2]> {
            let rows = interface.nonmortar.iter().zip(&interface.mortar);
            rows.map(|(own, other)| [times(own, &upper, u), times(other, &lower, u)])
                .collect()
        };
        for (a, b) in rows(&mortar).into_iter().zip(rows(&nodal)) {
            assert!((a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_facet_that_is_covered_in_part_is_loaded_at_the_ends_of_that_part() {
        let upper = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
        let lower = flat(&[0.5, 1.0, 3.0], -1.0, CellKind::Quad4);
        let interface = paired(&upper, &lower, Coupling::Normal);
        let u = |[x, _]: Point<2>| [9.0, 2.0 + x];
        for (node, (place, weight)) in
            interface
                .nodes
                .iter()
                .zip([(0.5, 0.25), (1.0, 0.75), (2.0, 0.5)])
        {
            assert!((node.weight - weight).abs() < 1e-14);
            let row = node.rows[0].unwrap();
            let found = times(&interface.nonmortar[row], &upper, u);
            assert!((found + 2.0 + place).abs() < 1e-13, "{found}");
        }
    }

    #[test]
    fn what_lies_beyond_a_hole_is_a_sheet_of_its_own() {
        let upper = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        let lower = flat(&[0.0, 0.4, 0.6, 1.0], -1.0, CellKind::Quad4);
        let free = Constraints::default();
        let whole = end(&lower, "bottom", &free);
        let facets = whole.facets().unwrap();
        let mortar = End {
            part: Some(&[facets[0], facets[2]]),
            ..whole
        };
        let interface = pair_mortar(
            end(&upper, "bottom", &free),
            Against::Side(mortar),
            InitialGap::Measured,
            Coupling::Normal,
            Analysis::PlaneStrain,
            0.0,
        );
        let interface = interface.unwrap();
        // each node has a row for each of them, which acts where that ends
        assert_eq!(interface.nodes.len(), 4);
        for (node, place) in interface.nodes.iter().zip([0.0, 0.6, 0.4, 1.0]) {
            let row = &interface.nonmortar[node.rows[0].unwrap()];
            assert!((node.weight - 0.2).abs() < 1e-14);
            let found = times(row, &upper, |[x, _]| [0.0, x]);
            assert!((found + place).abs() < 1e-13, "{found}");
        }
    }

    #[test]
    fn a_prescribed_node_gives_its_facets_to_its_neighbours() {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let lower = flat(&[-1.0, 1.5, 4.0], -1.0, CellKind::Quad4);
        let middle = node_at(&upper, [1.0, 0.0]);
        let supports = held(&[(middle, [0.0, 1.0], true)]);
        let free = Constraints::default();
        let interface = pair_mortar(
            end(&upper, "bottom", &supports),
            Against::Side(end(&lower, "bottom", &free)),
            InitialGap::Measured,
            Coupling::Frictional,
            Analysis::PlaneStrain,
            0.0,
        );
        let interface = interface.unwrap();
        let fixed = &interface.nodes[1];
        assert_eq!((fixed.role, fixed.rows), (Role::Fixed, [None; 2]));
        // the weight of the part that faces the other side there
        assert!((fixed.weight - 1.0).abs() < 1e-14 && fixed.gap.abs() < 1e-14);
        let u = |[x, _]: Point<2>| [0.0, x];
        for (place, weight, mean) in [(0, 1.0, 0.5), (2, 1.5, (1.5 + 1.0) / 1.5), (3, 0.5, 3.0)] {
            let node = &interface.nodes[place];
            assert!((node.weight - weight).abs() < 1e-14);
            assert!((node.extent - weight).abs() < 1e-14);
            let found = times(&interface.nonmortar[node.rows[0].unwrap()], &upper, u);
            assert!((found + mean).abs() < 1e-13, "{found}");
        }
    }

    /// Which rows the nodes of a side at x = 0, 1, 2, 3 have over a plane.
    fn over_a_plane(
        directions: &[(f64, Point<2>, bool)],
        driven: Driven,
        coupling: Coupling,
    ) -> Result<Vec<[bool; 2]>, ContactError> {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let directions: Vec<_> = directions
            .iter()
            .map(|&(x, axis, still)| (node_at(&upper, [x, 0.0]), axis, still))
            .collect();
        let supports = held(&directions);
        let rigid = Rigid::Surface {
            surface: Surface::Plane {
                point: [0.0, -0.5],
                normal: [0.0, 1.0],
            },
            inside: false,
        };
        let interface = pair_mortar(
            end(&upper, "bottom", &supports),
            Against::Obstacle(&rigid, driven),
            InitialGap::Measured,
            coupling,
            Analysis::PlaneStrain,
            0.0,
        )?;
        assert!(
            interface
                .nodes
                .iter()
                .all(|node| (node.gap - 0.5).abs() < 1e-14)
        );
        assert!(interface.nodes.iter().all(|node| node.opposite.is_empty()));
        let length: f64 = interface.carriers().map(|node| node.weight).sum();
        assert!(coupling == Coupling::Tied || length == 0.0 || (length - 3.0).abs() < 1e-13);
        let rows = |node: &InterfaceNode<2>| node.rows.map(|row| row.is_some());
        Ok(interface.nodes.iter().map(rows).collect())
    }

    const X: Point<2> = [1.0, 0.0];
    const Y: Point<2> = [0.0, 1.0];
    const BOTH: [bool; 2] = [true, true];
    const NONE: [bool; 2] = [false, false];
    const NORMAL: [bool; 2] = [true, false];

    #[test]
    fn a_node_that_stays_still_slips_against_an_obstacle_that_moves() {
        for (driven, still, rows) in [
            (Driven::Still, true, NORMAL),
            (Driven::Still, false, BOTH),
            (Driven::Prescribed, true, BOTH),
            (Driven::Free, true, BOTH),
        ] {
            let found = over_a_plane(&[(1.0, X, still)], driven, Coupling::Frictional).unwrap();
            assert_eq!(found, [BOTH, rows, BOTH, BOTH], "{driven:?} {still}");
        }
    }

    #[test]
    fn between_two_prescribed_nodes_a_free_obstacle_is_borne() {
        let two = [(0.0, Y, true), (1.0, Y, true)];
        for (coupling, free) in [(Coupling::Frictional, BOTH), (Coupling::Normal, NORMAL)] {
            let found = |driven| over_a_plane(&two, driven, coupling);
            // forces may move the obstacle against them
            assert_eq!(found(Driven::Free), Ok(vec![free; 4]));
        }
        // and by a tie, which is redundant there against an opposite that does not move
        for (driven, tied) in [(Driven::Free, BOTH), (Driven::Still, [false, true])] {
            let found = over_a_plane(&two, driven, Coupling::Tied).unwrap();
            assert_eq!(found, [tied, tied, BOTH, BOTH]);
        }
        // one alone gives way
        let found = over_a_plane(&two[..1], Driven::Free, Coupling::Frictional).unwrap();
        assert_eq!(found, [NONE, BOTH, BOTH, BOTH]);
        let all = [0.0, 1.0, 2.0, 3.0].map(|x| (x, Y, true));
        for (driven, rows) in [(Driven::Free, NORMAL), (Driven::Still, NONE)] {
            let found = over_a_plane(&all, driven, Coupling::Normal);
            assert_eq!(found, Ok(vec![rows; 4]));
        }
    }

    /// Which rows the nodes of a side at x = 0, 1, 2, 3 have over one at x = −1, 0.5, 1.5, 4.
    fn over_a_side(
        own: &[(f64, Point<2>, bool)],
        other: &[(f64, Point<2>, bool)],
    ) -> Vec<[bool; 2]> {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let lower = flat(&[-1.0, 0.5, 1.5, 4.0], -1.0, CellKind::Quad4);
        let supports = |body: &Body<2>, directions: &[(f64, Point<2>, bool)]| {
            let directions = directions.iter();
            let directions: Vec<_> = directions
                .map(|&(x, axis, still)| (node_at(body, [x, 0.0]), axis, still))
                .collect();
            held(&directions)
        };
        let (own, other) = (supports(&upper, own), supports(&lower, other));
        let interface = pair_mortar(
            end(&upper, "bottom", &own),
            Against::Side(end(&lower, "bottom", &other)),
            InitialGap::Measured,
            Coupling::Frictional,
            Analysis::PlaneStrain,
            0.0,
        );
        let rows = |node: &InterfaceNode<2>| node.rows.map(|row| row.is_some());
        interface.unwrap().nodes.iter().map(rows).collect()
    }

    #[test]
    fn nothing_slips_where_both_sides_stay_still() {
        let own = [(1.0, X, true)];
        // the node at x = 1 lies between those at 0.5 and 1.5
        for (other, rows) in [
            (vec![(0.5, X, true), (1.5, X, true)], NORMAL),
            (vec![(0.5, X, true)], BOTH),
            (vec![(1.5, X, true)], BOTH),
            (vec![(0.5, X, true), (1.5, X, false)], BOTH),
            (vec![(0.5, Y, true), (1.5, Y, true)], BOTH),
            (vec![], BOTH),
        ] {
            assert_eq!(
                over_a_side(&own, &other),
                [BOTH, rows, BOTH, BOTH],
                "{other:?}"
            );
        }
    }

    #[test]
    fn prescribed_neighbours_keep_their_pressure_unless_the_other_side_is_prescribed_too() {
        let own = [(1.0, Y, true), (2.0, Y, false)];
        // the node at x = 1 lies between those at 0.5 and 1.5, that at x = 2 between those at 1.5 and 4
        for (other, rows) in [
            (vec![], [BOTH; 4]),
            (
                vec![(0.5, Y, true), (1.5, Y, false)],
                [BOTH, NONE, BOTH, BOTH],
            ),
            (
                vec![(1.5, Y, false), (4.0, Y, false)],
                [BOTH, BOTH, NONE, BOTH],
            ),
            (vec![(1.5, X, true), (4.0, X, true)], [BOTH; 4]),
        ] {
            assert_eq!(over_a_side(&own, &other), rows, "{other:?}");
        }
    }

    #[test]
    fn a_node_of_whose_surroundings_less_than_a_thousandth_is_covered_carries_nothing() {
        // over the last ε of its facet the hat of an end node is ε² of its whole
        for (cover, carries) in [(0.031, false), (0.0322, true)] {
            let upper = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
            let lower = flat(&[1.0 - cover, 3.0], -1.0, CellKind::Quad4);
            let interface = paired(&upper, &lower, Coupling::Normal);
            let first = &interface.nodes[0];
            assert_eq!(first.rows[0].is_some(), carries, "{cover}");
            assert_eq!(first.role == Role::Alone, !carries);
            // its share goes to its neighbour
            let length: f64 = interface.carriers().map(|node| node.weight).sum();
            assert!((length - 1.0 - cover).abs() < 1e-13);
            let expected = if carries { 0.5 * cover } else { 0.5 };
            assert!((first.weight - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn what_faces_nothing_weighs_its_surroundings() {
        let turn = 2.0 * std::f64::consts::PI;
        let free = Constraints::default();
        let other = flat(&[3.5, 5.0], -1.0, CellKind::Quad4);
        for (cell, analysis, weights) in [
            (CellKind::Quad4, Analysis::PlaneStrain, [1.0, 2.0, 2.0]),
            (CellKind::Quad8, Analysis::PlaneStrain, [1.0, 2.0, 2.0]),
            // ∫N r of a facet of length L from r to R: L (2r + R)/6
            (
                CellKind::Quad4,
                Analysis::Axisymmetric,
                [turn / 6.0, turn, 2.0 * turn],
            ),
        ] {
            let mut upper = flat(&[0.0, 1.0, 2.0, 3.0, 4.0], 1.0, cell);
            upper.thickness = 2.0;
            let interface = pair_mortar(
                end(&upper, "bottom", &free),
                Against::Side(end(&other, "bottom", &free)),
                InitialGap::Measured,
                Coupling::Normal,
                analysis,
                0.0,
            );
            let interface = interface.unwrap();
            for (node, weight) in interface.nodes.iter().zip(weights) {
                assert_eq!((node.role, node.rows), (Role::Alone, [None; 2]));
                assert!(
                    (node.weight - weight).abs() < 1e-13,
                    "{} {weight}",
                    node.weight
                );
                assert!(node.gap.is_nan() && node.clearance.is_nan() && node.extent == 0.0);
                assert_eq!(node.normal(), [0.0, -1.0]);
            }
        }
    }

    #[test]
    fn where_a_node_weighs_too_little_the_functions_are_linear() {
        // the inner end of a quadratic facet from r to r + 1 weighs r/2 : (r + 1/2) of the mean
        let free = Constraints::default();
        for (radius, own) in [(0.12, false), (0.13, true)] {
            let places = [radius, radius + 0.5, radius + 1.0];
            let upper = flat(&places, 1.0, CellKind::Quad8);
            let lower = flat(&[0.0, 2.0], -1.0, CellKind::Quad4);
            let interface = pair_mortar(
                end(&upper, "bottom", &free),
                Against::Side(end(&lower, "bottom", &free)),
                InitialGap::Measured,
                Coupling::Normal,
                Analysis::Axisymmetric,
                0.0,
            );
            let interface = interface.unwrap();
            let first = &interface.nodes[0];
            let row = &interface.nonmortar[first.rows[0].unwrap()];
            let others = row.iter().filter(|(node, _)| *node != first.node);
            let largest = others.map(|(_, c)| norm(*c)).fold(0.0, f64::max);
            assert_eq!(largest < 1e-9, own, "{radius} {largest}");
        }
    }

    #[test]
    fn a_ring_closes_on_itself_and_neither_its_parts_nor_two_circles_do() {
        let (mut inner, outer) = (
            ring([0.0, 0.0], [1.0, 2.0], 12),
            ring([0.0, 0.0], [2.1, 3.0], 17),
        );
        inner.mesh = Mesh::clone(&inner.mesh).with_side("both", |_| true).into();
        let free = Constraints::default();
        let pair = |nonmortar: End<'_, 2>| {
            let against = Against::Side(end(&outer, "inner", &free));
            let (gap, coupling) = (InitialGap::Measured, Coupling::Normal);
            pair_mortar(
                nonmortar,
                against,
                gap,
                coupling,
                Analysis::PlaneStrain,
                0.0,
            )
            .unwrap()
        };
        let whole = end(&inner, "outer", &free);
        let interface = pair(whole);
        assert!(interface.cyclic);
        let order: Vec<usize> = interface.nodes.iter().map(|node| node.node).collect();
        let chain = &inner.mesh.chain("outer").unwrap()[0];
        let expected: Vec<usize> = chain.nodes.iter().map(|&node| node as usize).collect();
        assert_eq!(order, expected);
        let part = End {
            part: Some(&chain.facets[1..4]),
            ..whole
        };
        let part = pair(part);
        assert!(!part.cyclic && part.nodes.len() == 4);
        assert!(!pair(end(&inner, "both", &free)).cyclic);
    }

    #[test]
    fn sides_that_are_not_there_and_gaps_that_are_no_numbers_are_errors() {
        let body = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        let free = Constraints::default();
        let gap = Field::constant(f64::NAN);
        let lower = flat(&[0.0, 1.0], -1.0, CellKind::Quad4);
        for (own, other, word) in [
            ("nowhere", "bottom", "nowhere"),
            ("bottom", "elsewhere", "elsewhere"),
            ("bottom", "bottom", "not finite"),
        ] {
            let against = Against::Side(end(&lower, other, &free));
            let (gap, coupling) = (InitialGap::Given(&gap), Coupling::Normal);
            let own = end(&body, own, &free);
            let found = pair_mortar(own, against, gap, coupling, Analysis::PlaneStrain, 0.0);
            let message = found.unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }

    #[test]
    fn a_tie_of_a_node_that_is_held_along_the_normal_keeps_its_tangent() {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let lower = flat(&[-1.0, 0.4, 1.5, 4.0], -1.0, CellKind::Quad4);
        let middle = node_at(&upper, [1.0, 0.0]);
        let supports = held(&[(middle, Y, true)]);
        let free = Constraints::default();
        let interface = pair_mortar(
            end(&upper, "bottom", &supports),
            Against::Side(end(&lower, "bottom", &free)),
            InitialGap::Measured,
            Coupling::Tied,
            Analysis::PlaneStrain,
            0.0,
        );
        let interface = interface.unwrap();
        let u = |[x, _]: Point<2>| [5.0 + x, x];
        let nodes = &interface.nodes;
        assert_eq!(nodes[1].rows[0], None);
        let times = |row: Option<usize>| times(&interface.nonmortar[row.unwrap()], &upper, u);
        // the neighbour's pressure spreads over the facet, while the shear of each node is its own
        assert!((times(nodes[0].rows[0]) + 0.5).abs() < 1e-13);
        for (node, x) in nodes.iter().zip([0.0, 1.0, 2.0, 3.0]) {
            assert!((times(node.rows[1]) - 5.0 - x).abs() < 1e-13);
        }
        // its weight is that of the row that it has
        assert!((nodes[1].weight - 1.0).abs() < 1e-14);
        assert!((nodes[0].weight - 1.0).abs() < 1e-14);
        assert_eq!(nodes[1].role, Role::Multiplier);
    }

    /// A box between two heights with its bottom (or top) on a surface, turned about the vertical axis.
    fn bowl(cell: CellKind, cells: [usize; 3], z: [f64; 2], angle: f64) -> Body<3> {
        let cuboid = Cuboid {
            from: [-1.0, -1.0, 0.0],
            to: [1.0, 1.0, 1.0],
            cells,
            cell,
        };
        let mesh = cuboid.build().unwrap().map_points(|[x, y, t]| {
            let (s, c) = angle.sin_cos();
            let [x, y] = [c * x - s * y, s * x + c * y];
            let foot = 0.15 * x * x + 0.1 * x * y - 0.05 * y * y;
            [x, y, foot + z[0] + t * (z[1] - z[0])]
        });
        body(mesh.unwrap())
    }

    #[test]
    fn in_space_a_rigid_motion_of_both_bodies_together_neither_opens_nor_slips() {
        let axis = [0.3, -0.7, 0.5];
        let motion =
            |x: Point<3>| add_scaled([0.2, 0.1, -0.4], 1.0, crate::geometry::cross(axis, x));
        for own in [CellKind::Tet4, CellKind::Hex8] {
            for other in [CellKind::Tet4, CellKind::Hex8] {
                let upper = bowl(own, [3, 4, 1], [0.2, 1.0], 0.0);
                let lower = bowl(other, [4, 3, 1], [-1.0, 0.0], 0.35);
                for coupling in [Coupling::Frictional, Coupling::Tied] {
                    let interface = over(&upper, (&lower, "top"), coupling, Analysis::Solid);
                    assert!(interface.nonmortar.len() >= 48);
                    for (own, other) in interface.nonmortar.iter().zip(&interface.mortar) {
                        let moved = times(own, &upper, motion) + times(other, &lower, motion);
                        // rounding
                        assert!(moved.abs() < 1e-12, "{own:?} {moved:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn in_space_what_is_covered_stays_whatever_the_distance_from_the_origin_and_the_sizes_of_facets()
     {
        let area = |upper: &Body<3>, lower: &Body<3>| -> f64 {
            let interface = over(upper, (lower, "top"), Coupling::Normal, Analysis::Solid);
            interface.carriers().map(|node| node.weight).sum()
        };
        let sized = |mut body: Body<3>, size: f64, away: f64| {
            let place = |x: Point<3>| x.map(|c| size * c + away);
            body.mesh = Mesh::clone(&body.mesh).map_points(place).unwrap().into();
            body
        };
        for own in [CellKind::Hex8, CellKind::Hex20, CellKind::Tet10] {
            let upper = |size, away| sized(bowl(own, [3, 4, 1], [0.0, 1.0], 0.2), size, away);
            let lower = |away| {
                sized(
                    bowl(CellKind::Hex8, [5, 3, 1], [-1.0, 0.0], 0.35),
                    1.0,
                    away,
                )
            };
            let near = area(&upper(1.0, 0.0), &lower(0.0));
            for away in [1e2, 1e3, 1e5] {
                let far = area(&upper(1.0, away), &lower(away));
                // rounding of places shifts the edges of pieces
                assert!(
                    (far / near - 1.0).abs() < 1e-13 * away,
                    "{own:?} {away} {far} {near}"
                );
            }
            // small facets on a large one
            let floor = Cuboid {
                from: [-1e3; 3],
                to: [1e3, 1e3, 0.0],
                cells: [1; 3],
                cell: CellKind::Hex8,
            };
            let floor = body(floor.build().unwrap());
            let on_floor = |size: f64| area(&upper(size, 0.0), &floor) / (size * size);
            let large = on_floor(10.0);
            let small = on_floor(1e-2);
            assert!(
                (small / large - 1.0).abs() < 1e-9,
                "{own:?} {small} {large}"
            );
        }
    }

    /// ∫ of f over the part of the square (−1, 1)² that lies in the same one turned, by a fine sum over cells of a polar grid: both
    /// are star-shaped about the origin.
    fn over_common(angle: f64, f: impl Fn(Point<2>) -> f64) -> f64 {
        let reach = |direction: Point<2>| 1.0 / direction[0].abs().max(direction[1].abs());
        let rays = quadrature::gauss(40);
        let radii = quadrature::gauss(4);
        // the boundary is smooth between directions of corners of the two squares and of their crossings
        let quarter = std::f64::consts::FRAC_PI_4;
        let mut kinks: Vec<f64> = (0..8)
            .flat_map(|k| {
                let corner = f64::from(k) * quarter;
                [corner, corner + angle, corner + 0.5 * angle]
            })
            .map(|a| a.rem_euclid(8.0 * quarter))
            .collect();
        kinks.sort_by(f64::total_cmp);
        kinks.push(kinks[0] + 8.0 * quarter);
        let mut sum = 0.0;
        for ends in kinks.windows(2) {
            for &(t, wt) in &rays {
                let a = 0.5 * (ends[0] + ends[1]) + 0.5 * t * (ends[1] - ends[0]);
                let (s, c) = a.sin_cos();
                let (sb, cb) = (a - angle).sin_cos();
                let far = reach([c, s]).min(reach([cb, sb]));
                for &(q, wq) in &radii {
                    let r = 0.5 * far * (1.0 + q);
                    let area = 0.25 * wt * wq * (ends[1] - ends[0]) * far * r;
                    sum += area * f([r * c, r * s]);
                }
            }
        }
        sum
    }

    #[test]
    fn in_space_rows_times_their_weights_add_up_to_the_integrals_over_what_is_covered() {
        let angle = 0.35;
        let us = |[x, y, _]: Point<3>| [1.0 + 0.5 * x, 0.3 * y, 0.3 + 0.2 * x - 0.1 * y];
        let um = |[x, y, _]: Point<3>| [0.2 * y, 2.0 - 0.5 * x, 0.1 * x + 0.4 * y - 1.0];
        for own in [CellKind::Tet4, CellKind::Hex8] {
            for other in [CellKind::Tet4, CellKind::Hex8] {
                let flat = |cell, cells, z: [f64; 2], angle| {
                    let mut body = bowl(cell, cells, z, angle);
                    let level = |[x, y, z]: Point<3>| {
                        [x, y, z - (0.15 * x * x + 0.1 * x * y - 0.05 * y * y)]
                    };
                    body.mesh = Mesh::clone(&body.mesh).map_points(level).unwrap().into();
                    body
                };
                let upper = flat(own, [3, 4, 1], [0.25, 1.0], 0.0);
                let lower = flat(other, [5, 3, 1], [-1.0, 0.0], angle);
                let interface = over(
                    &upper,
                    (&lower, "top"),
                    Coupling::Frictional,
                    Analysis::Solid,
                );
                let sum = |f: &dyn Fn(&InterfaceNode<3>) -> f64| -> f64 {
                    interface.carriers().map(|node| node.weight * f(node)).sum()
                };
                let slip = |node: &InterfaceNode<3>, axis: usize| -> [f64; 2] {
                    let mut sums = [0.0; 2];
                    for c in 0..3 {
                        let row = node.rows[c].unwrap();
                        let part = node.frame[c][axis];
                        sums[0] += part * times(&interface.nonmortar[row], &upper, us);
                        sums[1] += part * times(&interface.mortar[row], &lower, um);
                    }
                    sums
                };
                let integral =
                    |f: &dyn Fn(Point<3>) -> f64| over_common(angle, |[x, y]| f([x, y, 0.0]));
                let check = |found: f64, expected: f64| {
                    assert!(
                        (found - expected).abs() < 1e-9,
                        "{own:?} {other:?} {found} {expected}"
                    );
                };
                check(sum(&|_| 1.0), integral(&|_| 1.0));
                check(
                    interface.carriers().map(|n| n.extent).sum(),
                    integral(&|_| 1.0),
                );
                check(sum(&|node| node.gap), 0.25 * integral(&|_| 1.0));
                for axis in 0..3 {
                    check(sum(&|node| slip(node, axis)[0]), integral(&|x| us(x)[axis]));
                    // across the gap the lower side is carried on by the rotation of its facets
                    let tilt = [0.1, 0.4, 0.0][axis] * 0.25;
                    check(
                        sum(&|node| slip(node, axis)[1]),
                        -integral(&|x| um(x)[axis] - tilt),
                    );
                }
            }
        }
    }
}
