//! Parts of one body that lie on each other without common nodes: a mesh whose coincident nodes were never merged.
//!
//! Such parts are not connected; they penetrate and separate without a message. A facet of the boundary lies on another one if each
//! of its corners lies on one of the other, within [`SAME`] of the facet. Sides of contacts and of bolts are intended to do so.

use crate::fem::show;
use crate::geometry::{Point, distance};
use crate::mesh::{Facet, Mesh};
use crate::model::nouns::ids::BodyId;
use crate::model::nouns::member::MemberEnd;
use crate::model::nouns::model::Model;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::collections::BTreeSet;

/// Nodes nearer than this part of an edge coincide.
const SAME_EDGE: f64 = 1e-6;

/// A warning about facets of two parts of a body that coincide, with the place of the first.
pub(crate) fn unglued<const D: usize>(model: &Model<D>, id: BodyId) -> Option<String> {
    let body = &model.bodies[id.0];
    let mesh = &body.mesh;
    let parts = mesh.facet_components();
    if parts.iter().all(|&part| part == 0) {
        return None;
    }
    let offsets = block_offsets(mesh);
    let part = |facet: Facet| parts[offsets[facet.block as usize] + facet.cell as usize];
    let sides = model
        .contacts
        .iter()
        .flat_map(|contact| contact.pair.sides());
    let of_members = model.members.iter().flat_map(|member| &member.line.ends);
    let of_members = of_members.filter_map(|end| match end {
        MemberEnd::Side(side) => Some(side),
        MemberEnd::Point(_) => None,
    });
    let sides = sides.chain(of_members).filter(|side| side.body == id);
    let meant = sides.flat_map(|side| mesh.side(&side.side).unwrap_or_default());
    let meant: BTreeSet<Facet> = meant.copied().collect();
    let facets = mesh.boundary_facets().into_iter();
    let facets = facets.filter(|facet| !meant.contains(facet));
    let facets = facets.map(|facet| GeomWithData::new(centre(mesh, facet), facet));
    let facets: Vec<_> = facets.collect();
    let tree = RTree::bulk_load(facets.clone());
    let lies_on_another = |own: &&GeomWithData<Point<D>, Facet>| {
        let reach = SAME_EDGE * size(mesh, own.data);
        let near = tree.locate_within_distance(*own.geom(), reach * reach);
        let mut others = near.filter(|other| part(other.data) != part(own.data));
        others.any(|other| coincide(mesh, own.data, other.data, reach))
    };
    let doubled: Vec<_> = facets.iter().filter(lies_on_another).collect();
    let first = doubled.first()?;
    Some(format!(
        "body \"{}\": parts of it lie on each other without common nodes, at {} and {} facets in all: they are not glued, and pass through each other; merge their coincident nodes, or make bodies of them and a contact between these",
        body.name,
        show(*first.geom()),
        doubled.len()
    ))
}

/// Number of cells before each block.
fn block_offsets<const D: usize>(mesh: &Mesh<D>) -> Vec<usize> {
    let counts = mesh.blocks().iter().map(|block| block.cells().len());
    let before = counts.scan(0, |sum, count| {
        *sum += count;
        Some(*sum - count)
    });
    before.collect()
}

fn corners<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> impl Iterator<Item = Point<D>> + '_ {
    mesh.facet_points(facet)
        .take(mesh.facet_kind(facet).corners())
}

fn centre<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> Point<D> {
    let count = mesh.facet_kind(facet).corners() as f64;
    let add = |sum: Point<D>, x: Point<D>| std::array::from_fn(|d| sum[d] + x[d] / count);
    corners(mesh, facet).fold([0.0; D], add)
}

/// Length of its shortest edge.
fn size<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> f64 {
    let all: Vec<Point<D>> = corners(mesh, facet).collect();
    let next = |k: usize| all[(k + 1) % all.len()];
    let edges = all.iter().enumerate().map(|(k, &x)| distance(x, next(k)));
    edges.fold(f64::INFINITY, f64::min)
}

fn coincide<const D: usize>(mesh: &Mesh<D>, a: Facet, b: Facet, reach: f64) -> bool {
    mesh.facet_kind(a).corners() == mesh.facet_kind(b).corners()
        && corners(mesh, a).all(|x| corners(mesh, b).any(|y| distance(x, y) <= reach))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellBlock, CellKind};
    use crate::model::Elastic;

    /// Two squares on each other, [0, 1] × [0, 2], the upper one `apart` from the lower one, with nodes of its own.
    fn stack(apart: f64) -> Model<2> {
        let square = |y: f64| [[0.0, y], [1.0, y], [1.0, y + 1.0], [0.0, y + 1.0]];
        let points = [square(0.0), square(1.0 + apart)].concat();
        let block = CellBlock {
            kind: CellKind::Quad4,
            nodes: (0..8).collect(),
            group: None,
        };
        let mesh = Mesh::new(points, vec![block]).unwrap();
        let side = |name: &str, nodes: [u32; 2]| {
            (name.to_string(), mesh.facets_at(&[nodes.to_vec()]).unwrap())
        };
        let sides = [side("low", [2, 3]), side("high", [4, 5])].into();
        let mesh = mesh.with_sides(sides).unwrap();
        let mut model = Model::new();
        let elastic = Elastic {
            young: 1000.0,
            poisson: 0.3,
        };
        model.body("stack", mesh, elastic);
        model
    }

    #[test]
    fn parts_that_coincide_without_common_nodes_are_told_with_the_place() {
        let told = unglued(&stack(0.0), BodyId(0)).unwrap();
        assert!(
            told.contains("(0.5, 1)") && told.contains("2 facets"),
            "{told}"
        );
        assert!(unglued(&stack(1e-8), BodyId(0)).is_some());
        assert_eq!(unglued(&stack(1e-3), BodyId(0)), None);
    }

    #[test]
    fn parts_between_which_there_is_a_contact_are_meant_to_be_apart() {
        let mut model = stack(0.0);
        let body = BodyId(0);
        model.contact((body, "high"), (body, "low"));
        assert_eq!(unglued(&model, body), None);
    }
}
