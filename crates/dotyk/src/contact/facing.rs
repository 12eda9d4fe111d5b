//! Which parts of two sides face each other although their nodes do not coincide.
//!
//! A facet sees the other side when a ray from one of its points along its outward normal meets a facet there whose
//! outward normal is opposed; against the normal it may meet one, too (the bodies overlap), but not farther than the size
//! of the other side. Node-to-node pairing is right where no facet with a node of its own sees the other side.
//! Curved facets count as the polygon of their nodes. Plane meshes only: sides of solids see nothing here.

use crate::contact::node_to_node::{facets, matching_nodes};
use crate::contact::{ContactError, End};
use crate::geometry::{Point, add_scaled, bounding_box, distance, dot, sub, unit};
use crate::mesh::{Facet, Mesh};

/// A node without a partner on a facet that faces the other side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unmatched<const D: usize> {
    /// It belongs to the mortar side.
    pub of_mortar: bool,
    /// The node.
    pub node: usize,
    /// Its position.
    pub point: Point<D>,
    /// Distance of the nearest node of the other side.
    pub distance: f64,
}

/// The first facet that faces the other side and has a node without a partner; `None` when node-to-node pairing leaves
/// nothing out, be it that all nodes there coincide or that the sides do not face each other.
///
/// Errors: unknown or empty sides.
pub fn unmatched_facing<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
) -> Result<Option<Unmatched<D>>, ContactError> {
    for (own, other, of_mortar) in [(nonmortar, mortar, false), (mortar, nonmortar, true)] {
        let matches = matching_nodes(own, other)?;
        let mesh = &own.body.mesh;
        let screen = Screen::new(&other.body.mesh, facets(other)?);
        for &facet in facets(own)? {
            let lonely = mesh
                .facet_nodes(facet)
                .map(|node| node as usize)
                .find(|node| matches[node].0.is_none());
            if let Some(node) = lonely
                && sees(mesh, facet, &screen)
            {
                return Ok(Some(Unmatched {
                    of_mortar,
                    node,
                    point: mesh.points()[node],
                    distance: matches[&node].1,
                }));
            }
        }
    }
    Ok(None)
}

/// Points of a facet from which rays start.
const STARTS: [f64; 5] = [-0.9, -0.5, 0.0, 0.5, 0.9];

fn sees<const D: usize>(mesh: &Mesh<D>, facet: Facet, screen: &Screen<D>) -> bool {
    D == 2
        && STARTS.iter().any(|&xi| {
            let normal = unit(mesh.outward_normal(facet, &[xi]));
            normal.is_some_and(|n| screen.is_hit(mesh.facet_point(facet, &[xi]), n))
        })
}

/// The other side as segments.
struct Screen<const D: usize> {
    segments: Vec<[Point<D>; 2]>,
    corners: [Point<D>; 2],
}

impl<const D: usize> Screen<D> {
    fn new(mesh: &Mesh<D>, facets: &[Facet]) -> Self {
        let mut segments = Vec::new();
        for &facet in facets {
            // ends with the body on the left, then the middle
            let points: Vec<Point<D>> = mesh.facet_points(facet).collect();
            match points[..] {
                [a, b, middle] => segments.extend([[a, middle], [middle, b]]),
                [a, b, ..] => segments.push([a, b]),
                _ => {}
            }
        }
        let all: Vec<Point<D>> = segments.iter().flatten().copied().collect();
        let (low, high) = bounding_box(&all);
        Self {
            segments,
            corners: [low, high],
        }
    }

    /// A ray along the normal, or a short one against it, meets a segment that looks the other way.
    fn is_hit(&self, start: Point<D>, normal: Point<D>) -> bool {
        let [low, high] = self.corners;
        let depth = distance(low, high);
        let turned = |v: Point<D>| [v[1], -v[0]];
        // the box of the other side must lie on both sides of the line of the ray
        let along = |p: Point<D>| {
            let t = turned(sub(p, start));
            t[0] * normal[0] + t[1] * normal[1]
        };
        let box_corners = [low, high].map(|p| [p[0], p[1]]);
        let across = (0..4).map(|k| {
            let mut p = start;
            (p[0], p[1]) = (box_corners[k & 1][0], box_corners[k >> 1][1]);
            along(p)
        });
        let (least, most) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), a| {
            (l.min(a), m.max(a))
        });
        if least > 0.0 || most < 0.0 {
            return false;
        }
        self.segments.iter().any(|&[a, b]| {
            let outward = turned(sub(b, a));
            if outward[0] * normal[0] + outward[1] * normal[1] >= 0.0 {
                return false;
            }
            let (side_a, side_b) = (along(a), along(b));
            if side_a * side_b > 0.0 || side_a == side_b {
                return false;
            }
            let hit = add_scaled(a, side_a / (side_a - side_b), sub(b, a));
            dot(sub(hit, start), normal) >= -depth
        })
    }
}
