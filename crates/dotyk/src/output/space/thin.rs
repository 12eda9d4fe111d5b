//! Surfaces for the view that turns: triangles on nodes, and fewer of them where they are many.
//!
//! Nodes that lie in one cube of a grid, belong to one body, look into the same of six directions and lie on edges of features
//! or do not, are merged into the first of them; triangles that lose a corner are left out. So features keep their nodes, the
//! two faces of a plate stay separate, and no holes open, because neighbours lose the same corners. The grid is the finest of a
//! sequence that leaves few enough triangles.
//!
//! Source: J. Rossignac, P. Borrel, Multi-resolution 3D approximations for rendering complex scenes (1993), as described in
//! later texts.

use crate::geometry::{Point, add_scaled, cross, sub};
use crate::model::Borders;
use crate::output::space::skin::Skin;
use std::collections::BTreeMap;

/// Triangles and edges of features of a body, by its nodes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Surface {
    /// Corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Ends.
    pub edges: Vec<[u32; 2]>,
}

impl Surface {
    /// All nodes of facets are corners, each at the place where its cell has its stress.
    pub fn of(skin: &Skin<'_>, borders: &Borders) -> Self {
        let mut triangles = Vec::new();
        for &facet in &skin.facets {
            let kind = skin.mesh.facet_kind(facet);
            let place = |node: u32| borders.place(facet.block as usize, node as usize) as u32;
            let nodes: Vec<u32> = skin.mesh.facet_nodes(facet).map(place).collect();
            divide(&nodes, kind.corners(), &mut triangles);
        }
        let features = skin.edges.iter().filter(|edge| edge.feature);
        let edges = features.flat_map(|edge| {
            edge.nodes()
                .windows(2)
                .map(|ab| [ab[0], ab[1]])
                .collect::<Vec<_>>()
        });
        Self {
            edges: edges.collect(),
            triangles,
        }
    }
}

/// A facet as triangles on its nodes: corners, middles of edges and a centre, as many as there are.
fn divide(nodes: &[u32], corners: usize, out: &mut Vec<[u32; 3]>) {
    if nodes.len() == corners {
        out.extend((2..corners).map(|i| [nodes[0], nodes[i - 1], nodes[i]]));
        return;
    }
    let (ring, middles) = nodes.split_at(corners);
    let after = |i: usize| (i + 1) % corners;
    if let Some(&centre) = middles.get(corners) {
        for i in 0..corners {
            out.push([centre, ring[i], middles[i]]);
            out.push([centre, middles[i], ring[after(i)]]);
        }
        return;
    }
    out.extend((0..corners).map(|i| [middles[i], ring[after(i)], middles[after(i)]]));
    out.extend((2..corners).map(|i| [middles[0], middles[i - 1], middles[i]]));
}

/// Surfaces of at most this many triangles in all; `points` by body and node, `size` that of the model.
pub fn thinned(
    surfaces: Vec<Surface>,
    points: &[&[Point<3>]],
    size: f64,
    most: usize,
) -> Vec<Surface> {
    let count = |list: &[Surface]| list.iter().map(|s| s.triangles.len()).sum::<usize>();
    if count(&surfaces) <= most {
        return surfaces;
    }
    let classes: Vec<Vec<u8>> = surfaces
        .iter()
        .zip(points)
        .map(|(surface, points)| classes(surface, points))
        .collect();
    let mut parts = 512.0;
    loop {
        let each = surfaces.iter().zip(points).zip(&classes);
        let list: Vec<Surface> = each
            .map(|((surface, points), classes)| clustered(surface, points, classes, size / parts))
            .collect();
        if count(&list) <= most || parts < 4.0 {
            return list;
        }
        parts *= 0.9;
    }
}

/// Which of six directions a node looks into; 8 more on an edge of a feature.
fn classes(surface: &Surface, points: &[Point<3>]) -> Vec<u8> {
    let mut normals = vec![[0.0; 3]; points.len()];
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|n| points[n as usize]);
        let normal = cross(sub(b, a), sub(c, a));
        for &n in triangle {
            normals[n as usize] = add_scaled(normals[n as usize], 1.0, normal);
        }
    }
    let looks = |normal: &Point<3>| {
        let along = |i: usize| normal[i].abs();
        let axis = (1..3).fold(0, |best, i| if along(i) > along(best) { i } else { best });
        2 * axis as u8 + u8::from(normal[axis] < 0.0)
    };
    let mut classes: Vec<u8> = normals.iter().map(looks).collect();
    for node in surface.edges.as_flattened() {
        // corners of features look nowhere in particular
        classes[*node as usize] = 8;
    }
    classes
}

fn clustered(surface: &Surface, points: &[Point<3>], classes: &[u8], cube: f64) -> Surface {
    let mut first: BTreeMap<([i64; 3], u8), u32> = BTreeMap::new();
    let mut kept: Vec<u32> = (0..points.len() as u32).collect();
    let mut used: Vec<u32> = surface.triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    for node in used {
        let n = node as usize;
        let place = points[n].map(|c| (c / cube).floor() as i64);
        kept[n] = *first.entry((place, classes[n])).or_insert(node);
    }
    let moved = surface
        .triangles
        .iter()
        .map(|t| t.map(|n| kept[n as usize]));
    let whole = moved.filter(|[a, b, c]| a != b && b != c && c != a);
    let triangles: Vec<[u32; 3]> = whole.collect();
    let edges = surface.edges.iter().map(|e| e.map(|n| kept[n as usize]));
    let mut edges: Vec<[u32; 2]> = edges
        .filter(|[a, b]| a != b)
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    Surface { triangles, edges }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{dot, norm};
    use crate::mesh::CellKind;
    use crate::output::space::tests::cuboid;

    /// Area and enclosed volume.
    fn measure(surface: &Surface, points: &[Point<3>]) -> (f64, f64) {
        surface
            .triangles
            .iter()
            .fold((0.0, 0.0), |(area, volume), t| {
                let [a, b, c] = t.map(|n| points[n as usize]);
                let normal = cross(sub(b, a), sub(c, a));
                (area + 0.5 * norm(normal), volume + dot(normal, a) / 6.0)
            })
    }

    #[test]
    fn thinned_surfaces_stay_closed_and_keep_their_edges() {
        let sizes = [2.0, 1.0, 0.1];
        let mesh = cuboid([0.0; 3], sizes, [60, 30, 3], CellKind::Hex8);
        let skin = Skin::new(&mesh, mesh.boundary_facets());
        let whole = Surface::of(&skin, &Borders::default());
        let most = whole.triangles.len() / 5;
        let thin = thinned(vec![whole], &[mesh.points()], 2.0, most).remove(0);
        assert!(thin.triangles.len() <= most && thin.triangles.len() > most / 3);
        let (area, volume) = measure(&thin, mesh.points());
        let exact = 2.0 * (sizes[0] * sizes[1] + sizes[1] * sizes[2] + sizes[2] * sizes[0]);
        // clusters reach over a face, not around its edges
        assert!((area / exact - 1.0).abs() < 0.02, "{area} {exact}");
        assert!((volume / 0.2 - 1.0).abs() < 0.02, "{volume}");
        let mut boundary: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for [a, b, c] in thin.triangles {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                *boundary.entry([p.min(q), p.max(q)]).or_insert(0) += if p < q { 1 } else { -1 };
            }
        }
        assert!(boundary.values().all(|count| *count == 0));
    }
}
