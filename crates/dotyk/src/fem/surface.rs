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
use std::collections::{BTreeMap, BTreeSet};

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
type Part<const D: usize> = (Facet, Point<D>, f64);

impl<'a, const D: usize> SideNormals<'a, D> {
    /// The normals of a side of a body. Errors: an unknown or empty side.
    pub fn new(body: &'a Body<D>, side: &str) -> Result<Self, FemError> {
        let mesh = &body.mesh;
        let surface = TrueSurface::of(body, side);
        let facets = side_facets(mesh, side)?.iter().copied();
        // a side given without a surface is its facets
        let smooth = facets.filter(|&f| surface.given(f).is_none() && mesh.curve(f).is_none());
        let smooth: Vec<Facet> = smooth.collect();
        let mut around: BTreeMap<u32, Vec<Part<D>>> = BTreeMap::new();
        for &facet in &smooth {
            for (node, normal, weight) in parts(mesh, facet) {
                around
                    .entry(node)
                    .or_default()
                    .push((facet, normal, weight));
            }
        }
        let sum = |own: Point<D>, all: &[Part<D>]| {
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
    let mesh = &body.mesh;
    let each = sides.iter().map(|side| node_normals(body, side));
    let mut each = each.collect::<Result<Vec<_>, _>>()?;
    let mut count: BTreeMap<usize, usize> = BTreeMap::new();
    for node in each.iter().flat_map(BTreeMap::keys) {
        *count.entry(*node).or_default() += 1;
    }
    count.retain(|_, sides| *sides > 1);
    let mut around: BTreeMap<usize, Vec<(Point<D>, f64)>> = BTreeMap::new();
    let mut seen = BTreeSet::new();
    for side in sides {
        let of_side = SideNormals::new(body, side)?;
        for &facet in side_facets(mesh, side)? {
            if !seen.insert(facet) {
                continue;
            }
            let places = mesh.facet_kind(facet).reference_nodes();
            let places: BTreeMap<u32, _> = mesh.facet_nodes(facet).zip(places).collect();
            for (node, own, weight) in parts(mesh, facet) {
                if count.contains_key(&(node as usize)) {
                    let flat = D == 3 && of_side.at_nodes.contains_key(&facet);
                    let normal = match flat {
                        true => own,
                        false => of_side.at(facet, places[&node]),
                    };
                    let around = around.entry(node as usize).or_default();
                    around.push((normal, weight));
                }
            }
        }
    }
    for (node, around) in around {
        for normal in each.iter_mut().filter_map(|of_side| of_side.get_mut(&node)) {
            let alike = around.iter().filter(|(n, _)| dot(*n, *normal) > SHARP);
            let sum = alike.fold([0.0; D], |sum, (n, w)| add_scaled(sum, *w, *n));
            *normal = unit(sum).unwrap_or(*normal);
        }
    }
    Ok(each)
}

/// A line that ends at an end of a facet bends there as it does at the other end of its last edge: the normal of that, mirrored in
/// the normal of the edge.
fn bend_ends<const D: usize>(
    nodes: &[u32],
    around: &BTreeMap<u32, Vec<Part<D>>>,
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
fn parts<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> Vec<(u32, Point<D>, f64)> {
    let kind = mesh.facet_kind(facet);
    let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
    let at = |k: usize| mesh.points()[nodes[k] as usize];
    let mut parts = Vec::new();
    for &[a, b, c] in divided(kind) {
        let corners = match D {
            2 => vec![[a, b, c], [b, a, c]],
            _ => vec![[a, b, c], [b, c, a], [c, a, b]],
        };
        for [k, first, second] in corners {
            let [first, second] = [first, second].map(|other| sub(at(other), at(k)));
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
                parts.push((nodes[k], n, norm(across) / lengths));
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
