//! The pieces of a body: stiffness and rigid motions of parts of its cells, of which those of the body are the sum.

use crate::fem::assemble::{BodySystem, into_frames, stiffness};
use crate::fem::error::FemError;
use crate::fem::modes::RigidBasis;
use crate::fem::nouns::{Analysis, Body};
use crate::fem::springs::{Entry, spring_points};
use crate::geometry::{Point, bounding_box, norm, sub};
use crate::host::in_order;
use crate::linalg::{Connectivity, Graph, Piece};
use crate::mesh::Mesh;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// Those `wanted` of the pieces of an assembled body whose cells have these numbers, block after block. A point of a spring belongs to
/// the first piece with a cell that has all of its nodes, so that no piece has a negative stiffness.
///
/// Errors: those of the assembly of the body.
pub(crate) fn pieces<const D: usize>(
    (body, system): (&Body<D>, &BodySystem<D>),
    analysis: Analysis,
    of_cell: &[u32],
    wanted: Range<usize>,
) -> Result<Vec<Piece>, FemError> {
    let parts = body.mesh.parts(of_cell);
    let springs = spring_points(body, analysis)?;
    let owners = owners(&parts, body.mesh.points().len(), &springs);
    let first = wanted.start;
    let parts = parts.into_iter().skip(first).take(wanted.len());
    let parts = parts.collect::<Vec<_>>().into_par_iter();
    let piece = |(mesh, nodes): (_, Vec<u32>)| {
        let part = Body {
            materials: body.materials.clone(),
            formulation: body.formulation,
            thickness: body.thickness,
            ..Body::of(&body.name, Arc::new(mesh))
        };
        let blocks = part.mesh.blocks().iter().map(|block| Connectivity {
            nodes: &block.nodes,
            nodes_per_cell: block.kind.nodes(),
        });
        let graph = Graph::from_cells(nodes.len(), &blocks.collect::<Vec<_>>());
        let graph = graph.placed(part.mesh.points());
        let frames = nodes.iter().enumerate().filter_map(|(local, &node)| {
            let axes = system.frames.get(&(node as usize))?;
            Some((local, *axes))
        });
        let frames: BTreeMap<usize, [[f64; D]; D]> = frames.collect();
        let stiffness = stiffness(&part, analysis, &graph)?;
        let motions = rigid_motions(part.mesh.points(), RigidBasis::of(analysis), &frames);
        let piece = Piece {
            dofs: nodes.iter().flat_map(|&node| dofs::<D>(node)).collect(),
            graph,
            stiffness,
            motions,
        };
        Ok((piece, nodes, frames))
    };
    let mut pieces = in_order(parts.map(piece))?;
    for (point, owner) in springs.iter().zip(owners) {
        let own = owner.and_then(|owner| (owner as usize).checked_sub(first));
        let Some((piece, nodes, _)) = own.and_then(|own| pieces.get_mut(own)) else {
            continue;
        };
        let local =
            |dof: usize| D * nodes.partition_point(|&node| (node as usize) < dof / D) + dof % D;
        for &(row, column, value) in point {
            piece.stiffness.add(local(row), local(column), value);
        }
    }
    let turned = pieces.into_iter().map(|(mut piece, _, frames)| {
        piece.stiffness.turn(&frames);
        piece
    });
    Ok(turned.collect())
}

/// The first part that has a cell with all nodes of each point of a spring: nodes alone may belong to cells of which none has them all.
fn owners<const D: usize>(
    parts: &[(Mesh<D>, Vec<u32>)],
    nodes: usize,
    springs: &[Vec<Entry>],
) -> Vec<Option<u32>> {
    let mut of_node: Vec<Vec<u32>> = vec![Vec::new(); nodes];
    if !springs.is_empty() {
        for (place, (_, nodes)) in parts.iter().enumerate() {
            let own = nodes.iter();
            own.for_each(|&node| of_node[node as usize].push(place as u32));
        }
    }
    let owner = |point: &Vec<Entry>| {
        let mut wanted: Vec<u32> = point.iter().map(|e| (e.0 / D) as u32).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let pieces_of = |&node: &u32| &of_node[node as usize];
        let has_all = |piece: &u32| wanted.iter().map(pieces_of).all(|own| own.contains(piece));
        let first = wanted.first().map_or(&[][..], |node| pieces_of(node));
        let mut candidates = first.iter().copied().filter(has_all);
        match (candidates.next(), candidates.next()) {
            (Some(first), Some(second)) => {
                let mut all = [first, second].into_iter().chain(candidates);
                all.find(|&piece| has_cell(&parts[piece as usize], &wanted))
            }
            (only, _) => only,
        }
    };
    springs.iter().map(owner).collect()
}

/// Whether some cell of a part has all of these nodes of the whole.
fn has_cell<const D: usize>((mesh, nodes): &(Mesh<D>, Vec<u32>), wanted: &[u32]) -> bool {
    let local = wanted.iter().map(|node| nodes.binary_search(node).ok());
    let Some(local) = local.collect::<Option<Vec<usize>>>() else {
        return false;
    };
    let has = |cell: &[u32]| local.iter().all(|&node| cell.contains(&(node as u32)));
    mesh.blocks().iter().any(|block| block.cells().any(has))
}

fn dofs<const D: usize>(node: u32) -> impl Iterator<Item = u32> {
    (0..D as u32).map(move |component| D as u32 * node + component)
}

/// All rigid motions of some nodes about their middle, (D·nodes,) in the frames of the nodes, of size 1.
fn rigid_motions<const D: usize>(
    points: &[Point<D>],
    basis: RigidBasis,
    frames: &BTreeMap<usize, [[f64; D]; D]>,
) -> Vec<Vec<f64>> {
    let (low, high) = bounding_box(points);
    let size = 0.5 * norm(sub(high, low));
    let motion = |k: usize| {
        let at = |x: &Point<D>| {
            let middle: Point<D> = std::array::from_fn(|d| 0.5 * (low[d] + high[d]));
            basis.displacement(k, sub(*x, middle).map(|c| c / size))
        };
        let mut motion = points.iter().flat_map(at).collect::<Vec<f64>>();
        into_frames(frames, &mut motion);
        motion
    };
    (0..basis.len(D)).map(motion).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::nouns::{Place, Support};
    use crate::fem::springs::{Bed, Spring};
    use crate::fem::tests::body;
    use crate::fem::{History, assemble, assemble_after};
    use crate::geometry::Field;
    use crate::mesh::{CellKind, Count, Cuboid};

    /// A cuboid that stands askew on a bed, beside a wall.
    fn leaning(cell: CellKind, cells: [usize; 3]) -> Body<3> {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [3.0, 2.0, 1.0],
            cells,
            cell,
        };
        let turned = |[x, y, z]: [f64; 3]| [0.8 * x + 0.6 * z, y, 0.8 * z - 0.6 * x];
        let mut body = body(cuboid.build().unwrap().map_points(turned).unwrap());
        // a roller on an oblique side turns frames, a bed joins the nodes of a facet
        body.supports = vec![Support {
            place: Place::Side("right".to_string()),
            components: [const { None }; 3],
            normal: Some(Field::constant(0.0)),
            active: Default::default(),
        }];
        body.springs = vec![Spring {
            bed: Bed::Side {
                side: "bottom".to_string(),
                normal: Field::constant(3.0),
                tangential: Field::constant(1.0),
                compression_only: false,
            },
            active: Default::default(),
        }];
        body
    }

    #[test]
    fn what_is_assembled_of_divided_bodies_has_their_diagonal_and_moves_their_supports() {
        let body = leaning(CellKind::Hex20, [3, 2, 2]);
        let assembled =
            |whole| assemble_after((&body, History::default()), Analysis::Solid, 1.0, whole);
        let [mut whole, mut part] = [true, false].map(|whole| assembled(whole).unwrap());
        // nodes that are turned later, too
        let turned = [(20, [0.6, 0.0, 0.8]), (33, [0.0, 0.8, -0.6])];
        whole.turn(turned.into_iter());
        part.turn(turned.into_iter());
        let moved: Vec<f64> = (0..whole.held.len())
            .map(|dof| f64::from(u8::from(whole.held[dof])) * (1.7 * dof as f64).sin())
            .collect();
        assert!(whole.frames.len() > 2 && moved.iter().any(|u| *u != 0.0));
        assert!(2 * part.stiffness.stored() < whole.stiffness.stored());
        let [expected, found] = [&whole, &part].map(|system| {
            let mut forces = vec![0.0; moved.len()];
            system.stiffness.mul(&moved, &mut forces);
            [forces, system.stiffness.diagonal()].concat()
        });
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    /// Of tetrahedra pieces may have all nodes of a facet of the bed without its cell.
    #[test]
    fn pieces_add_up_to_the_body() {
        let tetrahedra = [2, 3, 4, 5, 6].map(|count| (CellKind::Tet4, [3, 2, 1], count));
        for (cell, cells, count) in [(CellKind::Hex20, [3, 2, 2], 5)]
            .into_iter()
            .chain(tetrahedra)
        {
            let body = leaning(cell, cells);
            let system = assemble(&body, Analysis::Solid, 1.0).unwrap();
            assert!(!system.frames.is_empty());
            let of_cell = body.mesh.pieces(Count::Exactly(count));
            let some = |wanted: Range<usize>| {
                pieces((&body, &system), Analysis::Solid, &of_cell, wanted).unwrap()
            };
            // as two processes have them
            let pieces: Vec<Piece> = some(0..2).into_iter().chain(some(2..count)).collect();
            assert_eq!(pieces.len(), count);
            let dofs = system.load.len();
            let u: Vec<f64> = (0..dofs).map(|i| (1.7 * i as f64).sin()).collect();
            let (mut whole, mut sum) = (vec![0.0; dofs], vec![0.0; dofs]);
            system.stiffness.mul(&u, &mut whole);
            for piece in &pieces {
                let own: Vec<f64> = piece.dofs.iter().map(|&dof| u[dof as usize]).collect();
                let mut force = vec![0.0; own.len()];
                piece.stiffness.mul(&own, &mut force);
                let both = piece.dofs.iter().zip(&force);
                both.for_each(|(&dof, force)| sum[dof as usize] += force);
            }
            for (a, b) in sum.iter().zip(&whole) {
                assert!((a - b).abs() < 1e-12);
            }
        }
    }
}
