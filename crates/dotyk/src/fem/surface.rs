//! The surface behind the facets of a side, and its normals.
//!
//! The normal of a facet differs from that of a curve by up to half the angle between two facets. A ring on radial springs then
//! seems to be held against spinning: its facets are pressed on one half and lifted on the other. The energy of that, the part
//! (half angle)²/3 of the energy of springs in all directions, is an error of the mesh. So springs act along the normals of the
//! curve:
//!
//! * of the true surface where it is known;
//! * else interpolated between nodes, and at nodes the sum of the normals n of the facets that meet there, weighted by 1/L with the
//!   lengths L of edges in the plane, by sin α/(L₁L₂) with the edges of corners in space, those of flat triangles between nodes.
//!   On circles, on spheres, and on cylinders with edges along the axis, that is the radius however different the facets are: for
//!   chords of the angles 2a and 2b, of lengths 2R sin a and 2R sin b, the normals' parts along the tangent are
//!   −sin a/(2R sin a) + sin b/(2R sin b) = 0. Normals along the radius x/R at nodes are so between them. At the end of a line its
//!   last edge bends as at its other end.
//!
//! A motion along such a surface is then not resisted, to rounding, and one across it by the whole spring, however weak.
//! Facets that meet at a sharp corner keep their own normals.
//!
//! Source of the weights: N. Max, Weights for computing vertex normals from facet normals, J. Graphics Tools 4 (1999) 1–6.

use crate::fem::error::FemError;
use crate::fem::nouns::Body;
use crate::fem::sides::side_facets;
use crate::geometry::{Point, Surface, add_scaled, cross, dot, norm, padded, sub, unit};
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh, SHARP, divided};
use std::collections::BTreeMap;

/// The given surface behind a side; `None`: its facets are the true surface.
type Behind<const D: usize> = Option<Surface<D>>;

/// The true surface of a side, facet by facet: the one given for the side, or for another side of the body with that facet, or
/// the one that the mesh knows.
pub(crate) struct TrueSurface<'a, const D: usize> {
    own: Option<Behind<D>>,
    /// Facets of the body's other sides with a given surface.
    around: Vec<(&'a [Facet], Behind<D>)>,
    mesh: &'a Mesh<D>,
}

impl<'a, const D: usize> TrueSurface<'a, D> {
    /// The true surface of a side of a body.
    pub fn of(body: &'a Body<D>, side: &str) -> Self {
        let whole = |side: &str| body.mesh.side(side).unwrap_or_default();
        let around = body.surfaces.iter();
        Self {
            own: body.surfaces.get(side).copied(),
            around: around
                .map(|(side, &surface)| (whole(side), surface))
                .collect(),
            mesh: &body.mesh,
        }
    }

    /// The given surface of a facet.
    pub fn given(&self, facet: Facet) -> Option<Behind<D>> {
        let mut around = self.around.iter();
        let belongs = |side: &[Facet]| side.binary_search(&facet).is_ok();
        let found = || {
            around
                .find(|(side, _)| belongs(side))
                .map(|(_, surface)| *surface)
        };
        self.own.or_else(found)
    }

    /// The surface behind a facet; `None` if it is not known.
    pub fn at(&self, facet: Facet) -> Option<Surface<D>> {
        self.given(facet).unwrap_or_else(|| self.mesh.curve(facet))
    }

    /// Outward unit normal at ξ of a facet: that of the surface behind it, or its own; zero for a degenerate facet.
    pub fn normal(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let own = unit(self.mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]);
        self.along(facet, xi, own)
    }

    /// The normal of the surface behind a facet at ξ, oriented like `other`; without a surface `other`.
    pub fn along(&self, facet: Facet, xi: &[f64], other: Point<D>) -> Point<D> {
        let surface = self.at(facet);
        let behind = surface.and_then(|s| s.normal(self.mesh.facet_point(facet, xi)));
        behind.map_or(other, |n| n.map(|c| c * dot(n, other).signum()))
    }
}

/// Outward unit normals of a side along which its springs act.
pub(crate) struct SideNormals<'a, const D: usize> {
    surface: TrueSurface<'a, D>,
    /// Normals at the nodes of facets without a known surface.
    at_nodes: BTreeMap<Facet, [Point<D>; MAX_FACET_NODES]>,
}

/// A part of a facet at one of its nodes: the facet, its unit normal, and the weight of that.
type FacetPart<const D: usize> = (Facet, Point<D>, f64);

/// A part of a facet at one of its nodes, with the others of its edge or triangle.
struct Part<const D: usize> {
    node: u32,
    beside: [u32; 2],
    normal: Point<D>,
    weight: f64,
}

impl<'a, const D: usize> SideNormals<'a, D> {
    /// The normals of a side of a body. Errors: an unknown or empty side.
    pub fn new(body: &'a Body<D>, side: &str) -> Result<Self, FemError> {
        let mesh = &body.mesh;
        let surface = TrueSurface::of(body, side);
        let facets = side_facets(mesh, side)?.iter().copied();
        // a side given without a surface is its facets
        let smooth = facets.filter(|&f| surface.given(f).is_none() && mesh.curve(f).is_none());
        let smooth: Vec<Facet> = smooth.collect();
        let mut around: BTreeMap<u32, Vec<FacetPart<D>>> = BTreeMap::new();
        for &facet in &smooth {
            for part in parts(mesh, facet) {
                let around = around.entry(part.node).or_default();
                around.push((facet, part.normal, part.weight));
            }
        }
        let sum = |own: Point<D>, all: &[FacetPart<D>]| {
            let alike = all.iter().filter(|(_, n, _)| dot(*n, own) > SHARP);
            let sum = alike.fold([0.0; D], |sum, (_, n, w)| add_scaled(sum, *w, *n));
            unit(sum).unwrap_or(own)
        };
        let mut at_nodes = BTreeMap::new();
        for &facet in &smooth {
            let xi = mesh.facet_kind(facet).reference_nodes();
            let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
            let mut normals = [[0.0; D]; MAX_FACET_NODES];
            for ((normal, node), xi) in normals.iter_mut().zip(&nodes).zip(xi) {
                let own = unit(mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]);
                *normal = sum(own, &around[node]);
            }
            if D == 2 {
                bend_ends(&nodes, &around, &mut normals);
            }
            at_nodes.insert(facet, normals);
        }
        Ok(Self { surface, at_nodes })
    }

    /// Normal at ξ of a facet.
    pub fn at(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let Some(nodal) = self.at_nodes.get(&facet) else {
            return self.surface.normal(facet, xi);
        };
        let mut shape = [0.0; MAX_FACET_NODES];
        self.surface.mesh.facet_kind(facet).shape(xi, &mut shape);
        let sum = nodal.iter().zip(shape);
        let sum = sum.fold([0.0; D], |sum, (&n, value)| add_scaled(sum, value, n));
        unit(sum).unwrap_or(sum)
    }
}

/// Outward unit normals at the nodes of a side along which its supports act: the mean of those of its facets there, as `fem/surface.rs`
/// has them, so that rollers around a circle let it turn; at a sharp corner of two straight edges that is the bisector of their angle.
/// Faces of a sector have those of the whole.
///
/// Errors: an unknown or empty side.
///
/// Source: the bisector rule of Janovský & Procházka (1980) III, section 7.
pub fn node_normals<const D: usize>(
    body: &Body<D>,
    side: &str,
) -> Result<BTreeMap<usize, Point<D>>, FemError> {
    let mesh = &body.mesh;
    let of_side = SideNormals::new(body, side)?;
    let mut sums: BTreeMap<usize, Point<D>> = BTreeMap::new();
    for &facet in side_facets(mesh, side)? {
        let kind = mesh.facet_kind(facet);
        for (node, xi) in mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
            let sum = sums.entry(node as usize).or_insert([0.0; D]);
            *sum = add_scaled(*sum, 1.0, of_side.at(facet, xi));
        }
    }
    body.twins().inspect(|twins| twins.add_up(&mut sums));
    let units = sums.into_iter();
    Ok(units
        .filter_map(|(node, sum)| Some((node, unit(sum)?)))
        .collect())
}

/// Outward unit normals at the nodes of sides along which their supports act, in the order of the sides: those of [`node_normals`], but
/// one where sides go on smoothly from each other. With one normal for each of them such a node would be held in two directions, and
/// rollers around a circle of two sides would not let it turn. It is the mean of the facets of all these sides that meet there, weighted
/// as above; lines have bent ends.
///
/// Errors: an unknown or empty side.
pub(crate) fn joined_normals<const D: usize>(
    body: &Body<D>,
    sides: &[&str],
) -> Result<Vec<BTreeMap<usize, Point<D>>>, FemError> {
    let each = sides.iter().map(|side| node_normals(body, side));
    let mut each = each.collect::<Result<Vec<_>, _>>()?;
    let mut ends: BTreeMap<usize, Vec<SideEnd<D>>> = BTreeMap::new();
    for (place, side) in sides.iter().enumerate() {
        let of_side = SideNormals::new(body, side)?;
        let is_end = |node: usize| {
            let others = each.iter().enumerate().filter(|(other, _)| *other != place);
            let mut normals = others.filter_map(|(_, normals)| normals.get(&node));
            normals.any(|normal| dot(*normal, each[place][&node]) > SHARP)
        };
        for &facet in side_facets(&body.mesh, side)? {
            for (node, part) in of_side.ends(facet, is_end) {
                let ends = ends.entry(node).or_default();
                let known = ends.iter_mut().find(|end| end.side == place);
                match known {
                    Some(end) => end.parts.push(part),
                    None => ends.push(SideEnd {
                        side: place,
                        parts: vec![part],
                    }),
                }
            }
        }
    }
    for (node, ends) in ends {
        for end in &ends {
            let on = ends.iter().filter(|other| end.goes_on_to(other));
            let mut parts: Vec<&EndPart<D>> = on.flat_map(|other| &other.parts).collect();
            if parts.len() > end.parts.len() {
                parts.sort_by_key(|part| part.facet);
                parts.dedup_by_key(|part| (part.facet, part.corner));
                let sum = parts.iter().fold([0.0; D], |sum, part| {
                    add_scaled(sum, part.weight, part.normal)
                });
                let own = each[end.side].get_mut(&node);
                own.into_iter()
                    .for_each(|own| *own = unit(sum).unwrap_or(*own));
            }
        }
    }
    Ok(each)
}

/// The facets of a side that meet at a node which other sides have, too.
struct SideEnd<const D: usize> {
    side: usize,
    parts: Vec<EndPart<D>>,
}

/// A part of a facet there.
struct EndPart<const D: usize> {
    facet: Facet,
    /// Which part of the facet.
    corner: usize,
    weight: f64,
    /// The normal of the part itself, that which counts in the mean, and that of the side if it bends there as at its other nodes.
    own: Point<D>,
    normal: Point<D>,
    bent: Point<D>,
}

/// Normals that differ by less are the same: coordinates with six digits.
const SAME_NORMAL: f64 = 1e-4;

/// Sides go on from each other if bending them brings their normals together by this factor: those of facets on a curve meet, those of
/// straight sides with a kink stay apart.
const BROUGHT_TOGETHER: f64 = 0.5;

impl<const D: usize> SideEnd<D> {
    /// Whether another side goes on smoothly from this one, or is it.
    fn goes_on_to(&self, other: &Self) -> bool {
        let mean = |end: &Self, of: fn(&EndPart<D>) -> Point<D>| {
            let parts = end.parts.iter();
            let sum = parts.fold([0.0; D], |sum, part| add_scaled(sum, part.weight, of(part)));
            unit(sum).unwrap_or(sum)
        };
        let apart = |of| norm(sub(mean(self, of), mean(other, of)));
        let [own, bent] = [apart(|part| part.own), apart(|part| part.bent)];
        let alike = dot(mean(self, |p| p.own), mean(other, |p| p.own)) > SHARP;
        alike && bent <= SAME_NORMAL.max(BROUGHT_TOGETHER * own)
    }
}

impl<const D: usize> SideNormals<'_, D> {
    /// The parts of a facet at those of its nodes that are ends of the side. In the plane lines have bent ends; in space a facet bends
    /// as at its nodes that are no ends.
    fn ends(&self, facet: Facet, is_end: impl Fn(usize) -> bool) -> Vec<(usize, EndPart<D>)> {
        let mesh = self.surface.mesh;
        let places = mesh.facet_kind(facet).reference_nodes();
        let places: BTreeMap<u32, _> = mesh.facet_nodes(facet).zip(places).collect();
        let curved = D == 3 && self.at_nodes.contains_key(&facet);
        let parts = parts(mesh, facet).into_iter().enumerate();
        let parts = parts.filter(|(_, part)| is_end(part.node as usize));
        let end = |(corner, part): (usize, Part<D>)| {
            let (own, at) = (part.normal, |node: u32| self.at(facet, places[&node]));
            let inner = part.beside.iter().filter(|node| !is_end(**node as usize));
            let mirrored = inner.fold([0.0; D], |sum, node| {
                let n = at(*node);
                add_scaled(add_scaled(sum, -1.0, n), 2.0 * dot(n, own), own)
            });
            let of_end = EndPart {
                facet,
                corner,
                weight: part.weight,
                own,
                normal: if curved { own } else { at(part.node) },
                bent: match curved {
                    true => unit(mirrored).unwrap_or(own),
                    false => at(part.node),
                },
            };
            (part.node as usize, of_end)
        };
        parts.map(end).collect()
    }
}

/// A line that ends at an end of a facet bends there as it does at the other end of its last edge: the normal of that, mirrored in
/// the normal of the edge.
fn bend_ends<const D: usize>(
    nodes: &[u32],
    around: &BTreeMap<u32, Vec<FacetPart<D>>>,
    normals: &mut [Point<D>; MAX_FACET_NODES],
) {
    let middle = nodes.get(2).map(|_| 2);
    let known = *normals;
    for end in 0..2 {
        if let [(_, edge, _)] = around[&nodes[end]][..] {
            let other = known[middle.unwrap_or(1 - end)];
            normals[end] = add_scaled(other.map(|c| -c), 2.0 * dot(other, edge), edge);
        }
    }
}

/// The parts of a facet at its nodes: edges between neighbouring nodes in the plane, corners of flat triangles between nodes in space.
fn parts<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> Vec<Part<D>> {
    let kind = mesh.facet_kind(facet);
    let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
    let at = |k: usize| mesh.points()[nodes[k] as usize];
    let mut parts = Vec::new();
    for &[a, b, c] in divided(kind) {
        let corners = match D {
            2 => vec![[a, b, c], [b, a, c]],
            _ => vec![[a, b, c], [b, c, a], [c, a, b]],
        };
        for [k, others @ ..] in corners {
            let [first, second] = others.map(|other| sub(at(other), at(k)));
            let (across, lengths) = match D {
                2 => (turned(first), dot(first, first)),
                _ => (
                    crossed(first, second),
                    dot(first, first) * dot(second, second),
                ),
            };
            let own = unit(mesh.outward_normal(facet, &kind.reference_nodes()[k]));
            if let (Some(n), Some(own)) = (unit(across), own) {
                let n = n.map(|c| c * dot(n, own).signum());
                parts.push(Part {
                    node: nodes[k],
                    beside: others.map(|other| nodes[other]),
                    normal: n,
                    weight: norm(across) / lengths,
                });
            }
        }
    }
    parts
}

/// A vector of the plane turned by −90°.
fn turned<const D: usize>(v: Point<D>) -> Point<D> {
    std::array::from_fn(|i| if i == 0 { v[1] } else { -v[0] })
}

/// The cross product in space.
fn crossed<const D: usize>(a: Point<D>, b: Point<D>) -> Point<D> {
    let across = cross(padded(a), padded(b));
    std::array::from_fn(|i| across[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::tests::body;
    use crate::mesh::{CellKind, Cuboid, Diagonals, Rectangle};
    use std::collections::BTreeSet;

    #[test]
    fn lines_on_a_circle_have_its_radius_whatever_their_lengths() {
        for cell in [CellKind::Quad4, CellKind::Quad8, CellKind::Quad9] {
            let rectangle = Rectangle {
                from: [0.0, 1.0],
                to: [2.0, 1.5],
                cells: [9, 1],
                cell,
                diagonals: Diagonals::default(),
            };
            let bent = |[x, r]: Point<2>| {
                let angle = x + 0.2 * (3.0 * x).sin();
                [3.0 - r * angle.cos(), r * angle.sin()]
            };
            let body = body(rectangle.build().unwrap().map_points(bent).unwrap());
            let normals = SideNormals::new(&body, "top").unwrap();
            for &facet in body.mesh.side("top").unwrap() {
                for xi in [-1.0, -0.7, 0.0, 0.31, 1.0] {
                    let [x, y] = body.mesh.facet_point(facet, &[xi]);
                    let radius = unit([x - 3.0, y]).unwrap();
                    let off = norm(sub(normals.at(facet, &[xi]), radius));
                    assert!(off < 1e-14, "{cell:?} {xi}: {off:.1e}");
                    // the normal of the facet itself is off
                    let own = unit(body.mesh.outward_normal(facet, &[-1.0])).unwrap();
                    assert!(norm(sub(own, normals.at(facet, &[-1.0]))) > 1e-5);
                }
            }
            // straight ends keep theirs, as do corners
            let normals = SideNormals::new(&body, "left").unwrap();
            for &facet in body.mesh.side("left").unwrap() {
                assert!(norm(sub(normals.at(facet, &[-1.0]), [0.0, -1.0])) < 1e-14);
            }
        }
    }

    /// The normals of the two halves of the top of a body at a node that both have.
    fn at_the_joint<const D: usize>(
        body: &Body<D>,
        at: impl Fn(Point<D>) -> bool,
    ) -> [Point<D>; 2] {
        let normals = joined_normals(body, &["west", "east"]).unwrap();
        let on = |node: &&usize| normals[1].contains_key(*node) && at(body.mesh.points()[**node]);
        let node = *normals[0].keys().find(on).unwrap();
        [normals[0][&node], normals[1][&node]]
    }

    #[test]
    fn sides_that_go_on_from_each_other_have_one_normal_and_a_kink_has_two() {
        let top = |r: f64| (r - 1.5).abs() < 1e-9;
        let cells = [
            CellKind::Hex8,
            CellKind::Tet4,
            CellKind::Tet10,
            CellKind::Hex20,
        ];
        let flat = [CellKind::Quad4, CellKind::Tri6];
        for (kink, turn) in [(0.0, 1.0), (0.05, 0.0), (0.4, 0.0)] {
            let check = |normals: [Point<3>; 2], cell: CellKind| {
                let apart = norm(sub(normals[0], normals[1]));
                let right = 2.0 * f64::sin(f64::atan(kink));
                assert!(
                    (apart - right).abs() < 1e-12,
                    "{cell:?} {kink}: {apart} {right}"
                );
                if kink == 0.0 {
                    let off = norm(sub(normals[0], [0.0, 1.0, 0.0]));
                    assert!(off < 1e-12, "{cell:?}: {off:.1e}");
                }
            };
            // a ring from angles, or a roof
            let bent = |x: f64, r: f64| match turn {
                0.0 => [x, r - kink * x.abs()],
                _ => [r * x.sin(), r * x.cos()],
            };
            let halves =
                |x: f64, r: f64, west: bool| top(r) && if west { x < 1e-9 } else { x > -1e-9 };
            for cell in cells {
                let cuboid = Cuboid {
                    from: [-1.0, 1.0, 0.0],
                    to: [1.2, 1.5, 1.0],
                    cells: [11, 1, 3],
                    cell,
                };
                let mesh = cuboid.build().unwrap();
                let mesh = mesh
                    .with_side("west", |[x, r, _]| halves(x, r, true))
                    .with_side("east", |[x, r, _]| halves(x, r, false));
                let mesh = mesh.map_points(|[x, r, z]| {
                    let [x, y] = bent(x, r);
                    [x, y, z]
                });
                let inside = |[_, _, z]: Point<3>| z > 0.1 && z < 0.9;
                check(at_the_joint(&body(mesh.unwrap()), inside), cell);
            }
            for cell in flat {
                let rectangle = Rectangle {
                    from: [-1.0, 1.0],
                    to: [1.2, 1.5],
                    cells: [11, 1],
                    cell,
                    diagonals: Diagonals::default(),
                };
                let mesh = rectangle.build().unwrap();
                let mesh = mesh
                    .with_side("west", |[x, r]| halves(x, r, true))
                    .with_side("east", |[x, r]| halves(x, r, false));
                let mesh = mesh.map_points(|[x, r]| bent(x, r)).unwrap();
                let normals = at_the_joint(&body(mesh), |_| true);
                check(normals.map(|[x, y]| [x, y, 0.0]), cell);
            }
        }
    }

    #[test]
    fn corners_on_a_sphere_have_its_radius() {
        for cell in [
            CellKind::Hex8,
            CellKind::Tet4,
            CellKind::Tet10,
            CellKind::Hex20,
            CellKind::Hex27,
        ] {
            let cuboid = Cuboid {
                from: [-0.5, -0.5, 1.0],
                to: [0.5, 0.5, 1.2],
                cells: [5, 5, 1],
                cell,
            };
            let bent = |[x, y, r]: Point<3>| {
                let way = unit([x + 0.2 * x * y, y - 0.3 * x * x, 1.0]).unwrap();
                way.map(|c| r * c)
            };
            let body = body(cuboid.build().unwrap().map_points(bent).unwrap());
            let normals = SideNormals::new(&body, "top").unwrap();
            let facets = body.mesh.side("top").unwrap();
            let rim = ["left", "right", "front", "back"].iter();
            let rim = rim.flat_map(|side| body.mesh.side_nodes(side).unwrap());
            let rim: BTreeSet<u32> = rim.collect();
            let mut within = 0;
            for &facet in facets {
                let xi = body.mesh.facet_kind(facet).reference_nodes();
                for (node, xi) in body.mesh.facet_nodes(facet).zip(xi) {
                    if !rim.contains(&node) {
                        let radius = unit(body.mesh.points()[node as usize]).unwrap();
                        let off = norm(sub(normals.at(facet, xi), radius));
                        assert!(off < 1e-14, "{cell:?}: {off:.1e}");
                        within += 1;
                    }
                }
            }
            assert!(within > 16);
        }
    }
}
