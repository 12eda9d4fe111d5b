//! The curve behind a side: the true surface where it is known, and how far the mesh is off it where it is not.

use crate::contact::corners::SHARP;
use crate::contact::{ContactError, End};
use crate::fem::show;
use crate::geometry::{Point, Surface, dot, sub, unit};
use crate::mesh::{Facet, Mesh};
use std::collections::BTreeMap;

/// Nodes may lie off the true surface of their side by this part of a facet.
const OFF_SURFACE: f64 = 0.01;

/// The true surface of a side: the one that is given, else facet by facet what the mesh knows.
pub(super) struct TrueSurface<'a, const D: usize> {
    given: Option<Surface<D>>,
    mesh: &'a Mesh<D>,
}

impl<'a, const D: usize> TrueSurface<'a, D> {
    /// That of the facets of one end of an interface.
    ///
    /// Errors: nodes off the given surface.
    pub fn of(end: End<'a, D>, facets: &[Facet]) -> Result<Self, ContactError> {
        let mesh = &end.body.mesh;
        let given = given_surface(end, facets);
        for &facet in facets.iter().filter(|_| given.is_some()) {
            let limit = OFF_SURFACE * mesh.facet_length(facet);
            for node in mesh.facet_nodes(facet) {
                let point = mesh.points()[node as usize];
                let distance = given.map_or(0.0, |surface| surface.distance(point).abs());
                if distance > limit {
                    return Err(ContactError::OffSurface {
                        side: end.name(),
                        node: node as usize,
                        point: show(point),
                        distance,
                    });
                }
            }
        }
        Ok(Self { given, mesh })
    }

    /// The surface behind a facet; `None` where nothing is known.
    pub fn at(&self, facet: Facet) -> Option<Surface<D>> {
        self.given.or_else(|| self.mesh.curve(facet))
    }
}

/// The surface given for a side, or for another side of the body that contains it.
fn given_surface<const D: usize>(end: End<'_, D>, facets: &[Facet]) -> Option<Surface<D>> {
    let surfaces = &end.body.surfaces;
    let contains = |side: &str| {
        let whole = end.body.mesh.side(side).unwrap_or_default();
        facets
            .iter()
            .all(|facet| whole.binary_search(facet).is_ok())
    };
    let own = surfaces.get(end.side);
    let around = || surfaces.iter().find(|(side, _)| contains(side));
    own.or_else(|| around().map(|(_, surface)| surface))
        .copied()
}

/// Largest distance of the facets of a side from the smooth curve that they stand for. Zero where their true surface is
/// known, and across sharp corners.
///
/// * Straight facets of length L that turn by θ at their common node: Lθ/8. Parabolas on a circle turn, too, but miss a
///   quarter of that.
/// * Parabolas of length L and rise s, whose curvature κ = 8s/L² changes by Δκ at a common node: s³/L² is what a parabola
///   through three points of a circle misses, Δκ L²/(72√3) what it misses of a curve whose curvature changes.
///
/// Errors: unknown or empty sides.
pub fn sagitta(end: End<'_, 2>) -> Result<f64, ContactError> {
    let mesh = &end.body.mesh;
    let facets = end.facets()?;
    let surface = TrueSurface::of(end, facets)?;
    let mut around: BTreeMap<u32, Vec<Piece>> = BTreeMap::new();
    let mut largest = 0.0f64;
    for &facet in facets.iter().filter(|&&facet| surface.at(facet).is_none()) {
        let points: Vec<Point<2>> = mesh.facet_points(facet).collect();
        let [Some(first), Some(last)] = [-1.0, 1.0].map(|x| unit(mesh.outward_normal(facet, &[x])))
        else {
            continue;
        };
        let length = mesh.facet_length(facet);
        let rise = match (points.as_slice(), unit(mesh.outward_normal(facet, &[0.0]))) {
            (&[a, b, middle], Some(normal)) => {
                dot(normal, sub(middle, a)) - 0.5 * dot(normal, sub(b, a))
            }
            _ => 0.0,
        };
        largest = largest.max(rise.abs().powi(3) / (length * length));
        for (node, normal) in mesh.facet_nodes(facet).zip([first, last]) {
            around.entry(node).or_default().push(Piece {
                normal,
                length,
                rise,
            });
        }
    }
    let at_node = |meeting: &Vec<Piece>| match meeting.as_slice() {
        [a, b] if dot(a.normal, b.normal) > SHARP => {
            let length = a.length.max(b.length);
            let turn = length * dot(a.normal, b.normal).min(1.0).acos() / 8.0;
            let bent = |piece: &Piece| piece.rise.abs() > turn;
            let change = (a.curvature() - b.curvature()).abs();
            match bent(a) && bent(b) {
                true => (0.25 * turn).max(change * length * length / (72.0 * 3f64.sqrt())),
                false => turn,
            }
        }
        _ => 0.0,
    };
    Ok(around.values().map(at_node).fold(largest, f64::max))
}

/// The largest angle by which neighbouring straight facets of a side turn, corners left out; `None` for a side that has
/// facets of higher order.
///
/// Errors: unknown or empty sides.
pub fn straight_turn(end: End<'_, 2>) -> Result<Option<f64>, ContactError> {
    let mesh = &end.body.mesh;
    let facets = end.facets()?;
    if facets
        .iter()
        .any(|&facet| mesh.facet_kind(facet).order() > 1)
    {
        return Ok(None);
    }
    let mut around: BTreeMap<u32, Vec<Point<2>>> = BTreeMap::new();
    for &facet in facets {
        let normal = unit(mesh.outward_normal(facet, &[0.0]));
        for node in mesh.facet_nodes(facet) {
            around.entry(node).or_default().extend(normal);
        }
    }
    let turn = |normals: &Vec<Point<2>>| match normals[..] {
        [a, b] if dot(a, b) > SHARP => dot(a, b).min(1.0).acos(),
        _ => 0.0,
    };
    Ok(Some(around.values().map(turn).fold(0.0, f64::max)))
}

/// A facet at one of its ends.
struct Piece {
    normal: Point<2>,
    length: f64,
    rise: f64,
}

impl Piece {
    fn curvature(&self) -> f64 {
        8.0 * self.rise / (self.length * self.length)
    }
}
