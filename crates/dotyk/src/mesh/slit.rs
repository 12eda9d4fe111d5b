//! Cuts through a mesh along facets: the cells ahead of the cut get nodes of their own there.
//!
//! Cells on both sides keep their shape, so that the two sides of a cut have the same facets, node on node. A cut goes through: around
//! each of its nodes the cells behind it and those ahead of it meet only at facets of the cut.

use crate::geometry::{Point, add_scaled, dot, padded, sub};
use crate::mesh::{Facet, Mesh, MeshError, Recipe};
use std::collections::{BTreeMap, BTreeSet};

/// Middles of cells nearer to a plane than this part of the mesh lie on it.
const ON_PLANE: f64 = 1e-9;

impl<const D: usize> Mesh<D> {
    /// The facets between the cells behind and those ahead of the plane through a point, across an axis: as facets of the cells behind,
    /// and of several patches the one nearest to the point. Cells count by their middles, so that the facets lie as near to the plane
    /// as the cells allow; empty where the plane misses the mesh.
    pub fn across(&self, at: Point<D>, axis: Point<D>) -> Vec<Facet> {
        let tolerance = ON_PLANE * self.diameter() * dot(axis, axis).sqrt();
        let ahead = |facet: Facet| {
            let nodes = self.cell_nodes(facet.block as usize, facet.cell as usize);
            dot(sub(self.mean(nodes.iter().copied()), at), axis) > tolerance
        };
        let table = self.facet_table();
        let between = table.groups().filter_map(|group| match *group {
            [(_, a), (_, b)] if ahead(a) != ahead(b) => Some(if ahead(a) { b } else { a }),
            _ => None,
        });
        let between: Vec<Facet> = between.collect();
        let distance = |facet: Facet| {
            let apart = sub(self.mean(self.facet_nodes(facet)), at);
            dot(apart, apart)
        };
        let nearest = (0..between.len())
            .min_by(|&a, &b| distance(between[a]).total_cmp(&distance(between[b])));
        let mut of_node: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (place, facet) in between.iter().enumerate() {
            for node in self.facet_nodes(*facet) {
                of_node.entry(node).or_default().push(place);
            }
        }
        let mut reached: BTreeSet<usize> = nearest.into_iter().collect();
        let mut open: Vec<usize> = reached.iter().copied().collect();
        while let Some(place) = open.pop() {
            let beside = self.facet_nodes(between[place]);
            for &other in beside.flat_map(|node| &of_node[&node]) {
                if reached.insert(other) {
                    open.push(other);
                }
            }
        }
        reached.into_iter().map(|place| between[place]).collect()
    }

    /// The mesh cut along inner facets, given as facets of the cells behind the cut: the nodes of these facets stay with the cells behind,
    /// new ones at the end of the list are those of the cells ahead. The two sides of the cut have these names. How the mesh was
    /// made is lost.
    ///
    /// Errors: no facet; a facet that is not between two cells; a cut that ends within the mesh; names that exist already.
    pub fn slit(mut self, facets: &[Facet], [behind, ahead]: [&str; 2]) -> Result<Self, MeshError> {
        let table = self.facet_table();
        let mut partners = Vec::new();
        for &facet in facets {
            let corners = self.facet_kind(facet).corners();
            let corners: Vec<u32> = self.facet_nodes(facet).take(corners).collect();
            let mut others = table.find(&corners).filter(|other| *other != facet);
            let outside = || MeshError::CutOutside {
                point: padded(self.mean(corners.iter().copied())),
            };
            partners.push(others.next().ok_or_else(outside)?);
        }
        let nodes = facets.iter().flat_map(|facet| self.facet_nodes(*facet));
        let nodes: BTreeSet<u32> = nodes.collect();
        let moved = self.ahead_of((facets, &partners), &nodes)?;
        let fresh = self.points.len() as u32..;
        let renamed: BTreeMap<u32, u32> = nodes.iter().copied().zip(fresh).collect();
        let copies: Vec<Point<D>> = nodes.iter().map(|&n| self.points[n as usize]).collect();
        for (block, cell) in moved {
            let count = self.blocks[block].kind.nodes();
            for node in &mut self.blocks[block].nodes[cell * count..(cell + 1) * count] {
                *node = renamed.get(node).copied().unwrap_or(*node);
            }
        }
        self.points.extend(copies);
        let mut cut = self.checked()?;
        cut.add_side(behind, facets.to_vec())?;
        cut.add_side(ahead, partners)?;
        cut.recipe = Recipe::default();
        Ok(cut)
    }

    /// The cells, by block and place, with nodes of a cut that lie ahead of it.
    fn ahead_of(
        &self,
        (facets, partners): (&[Facet], &[Facet]),
        nodes: &BTreeSet<u32>,
    ) -> Result<BTreeSet<(usize, usize)>, MeshError> {
        let cell = |facet: Facet| (facet.block as usize, facet.cell as usize);
        let touches = |facet: Facet| {
            let (block, cell) = cell(facet);
            let mut own = self.cell_nodes(block, cell).iter();
            own.any(|node| nodes.contains(node))
        };
        let cut: BTreeSet<Facet> = facets.iter().chain(partners).copied().collect();
        let mut beside: BTreeMap<(usize, usize), Vec<(usize, usize)>> = BTreeMap::new();
        for group in self.facet_table().groups() {
            for pair in group.windows(2) {
                let [a, b] = [pair[0].1, pair[1].1];
                if !cut.contains(&a) && touches(a) && touches(b) {
                    beside.entry(cell(a)).or_default().push(cell(b));
                    beside.entry(cell(b)).or_default().push(cell(a));
                }
            }
        }
        let mut ahead: BTreeSet<(usize, usize)> = partners.iter().map(|p| cell(*p)).collect();
        let mut open: Vec<(usize, usize)> = ahead.iter().copied().collect();
        while let Some(next) = open.pop() {
            for &other in beside.get(&next).into_iter().flatten() {
                if ahead.insert(other) {
                    open.push(other);
                }
            }
        }
        match facets.iter().find(|facet| ahead.contains(&cell(**facet))) {
            Some(&facet) => Err(MeshError::CutEnds {
                point: padded(self.mean(self.facet_nodes(facet))),
            }),
            None => Ok(ahead),
        }
    }

    /// The mean of some nodes.
    fn mean(&self, nodes: impl ExactSizeIterator<Item = u32>) -> Point<D> {
        let share = 1.0 / nodes.len() as f64;
        let points = nodes.map(|node| self.points[node as usize]);
        points.fold([0.0; D], |sum, x| add_scaled(sum, share, x))
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::{CellKind, Cuboid, Diagonals, Mesh, MeshError, Rectangle};

    fn bar() -> Mesh<2> {
        let bar = Rectangle {
            from: [0.0, 0.0],
            to: [1.0, 3.0],
            cells: [2, 6],
            cell: CellKind::Quad4,
            diagonals: Diagonals::Forward,
        };
        bar.build().unwrap()
    }

    #[test]
    fn a_cut_through_a_bar_leaves_two_parts_with_equal_sides() {
        let mesh = bar();
        let (points, cells) = (mesh.points().len(), mesh.cell_count());
        let facets = mesh.across([0.5, 1.3], [0.0, 2.0]);
        let cut = mesh.slit(&facets, ["lower", "upper"]).unwrap();
        assert_eq!(cut.points().len(), points + 3);
        assert_eq!((cut.cell_count(), cut.component_count()), (cells, 2));
        let sides = ["lower", "upper"].map(|side| {
            let nodes = cut.side_nodes(side).unwrap();
            let mut at: Vec<_> = nodes.iter().map(|&n| cut.points()[n as usize]).collect();
            at.sort_by(|a, b| a[0].total_cmp(&b[0]));
            at
        });
        assert_eq!(sides[0], sides[1]);
        // as near to the plane as the cells allow
        assert!(sides[0].iter().all(|x| x[1] == 1.5));
        let height = |side: &str| {
            let facet = cut.side(side).unwrap()[0];
            let nodes = cut.cell_nodes(facet.block as usize, facet.cell as usize);
            cut.mean(nodes.iter().copied())[1]
        };
        assert_eq!([height("lower"), height("upper")], [1.25, 1.75]);
    }

    #[test]
    fn of_two_legs_the_nearer_one_is_cut() {
        let block = Cuboid {
            from: [0.0; 3],
            to: [3.0, 1.0, 3.0],
            cells: [3, 1, 3],
            cell: CellKind::Hex8,
        };
        let mesh = block.build().unwrap();
        // without the middle of the lower two layers it has two legs
        let kept = |x: [f64; 3]| !(x[0] > 1.0 && x[0] < 2.0 && x[2] < 2.0);
        let mesh = picked(&mesh, kept);
        let mesh_points = mesh.points().len();
        let facets = mesh.across([2.6, 0.5, 1.0], [0.0, 0.0, 1.0]);
        assert_eq!(facets.len(), 1);
        let cut = mesh.slit(&facets, ["a", "b"]).unwrap();
        // the foot of that leg, and the rest
        assert_eq!(cut.component_count(), 2);
        assert_eq!(cut.points().len(), mesh_points + 4);
        let at = cut.side_nodes("a").unwrap();
        assert!(at.iter().all(|&n| cut.points()[n as usize][0] >= 2.0));
    }

    /// The cells whose middles satisfy a condition.
    fn picked(mesh: &Mesh<3>, kept: impl Fn([f64; 3]) -> bool) -> Mesh<3> {
        let mut block = mesh.blocks()[0].clone();
        let nodes = block.nodes.chunks(8).filter(|nodes| {
            let mean = |d: usize| {
                let sum: f64 = nodes.iter().map(|&n| mesh.points()[n as usize][d]).sum();
                sum / 8.0
            };
            kept([mean(0), mean(1), mean(2)])
        });
        let nodes: Vec<u32> = nodes.flatten().copied().collect();
        let mut used: Vec<u32> = nodes.clone();
        used.sort_unstable();
        used.dedup();
        let place = |node: &u32| used.binary_search(node).unwrap() as u32;
        block.nodes = nodes.iter().map(place).collect();
        let points = used.iter().map(|&n| mesh.points()[n as usize]).collect();
        Mesh::new(points, vec![block]).unwrap()
    }

    #[test]
    fn a_cut_that_ends_in_the_body_or_lies_outside_is_refused() {
        let mesh = bar();
        let facets = mesh.across([0.5, 1.3], [0.0, 1.0]);
        let ends = mesh.clone().slit(&facets[..1], ["a", "b"]);
        assert!(matches!(ends, Err(MeshError::CutEnds { .. })), "{ends:?}");
        let top = mesh.side("top").unwrap().to_vec();
        let outside = mesh.clone().slit(&top, ["a", "b"]);
        assert!(matches!(outside, Err(MeshError::CutOutside { .. })));
        assert!(mesh.across([0.5, 7.0], [0.0, 1.0]).is_empty());
    }
}
