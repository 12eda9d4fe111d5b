//! A mesh cut into connected pieces of about the same size.
//!
//! The cells are divided again and again across the direction in which they extend most, into as many parts as make pieces like cubes,
//! which have short borders. Where the number of pieces is free, every part has as many of them as it is large, so that the cuts across
//! parts side by side meet.
//!
//! Where cells become small towards a place, halves of their number across a direction are slabs beside it, and their parts needles:
//! there the cells are halved by the plane or the sphere that cuts the fewest facets, so that pieces are as wide as they are long,
//! measured in cells.
//!
//! Then cells go to the piece with which they have most facets in common, so that borders have no teeth, and what is connected with
//! the rest of its piece through no facet joins the neighbour with which it has most facets in common.
//!
//! Sources: H. D. Simon, Partitioning of unstructured problems for parallel processing, Comput. Syst. Engng 2 (1991) 135–148;
//! J. R. Gilbert, G. L. Miller, S.-H. Teng, Geometric mesh partitioning, SIAM J. Sci. Comput. 19 (1998) 2091–2110.

use crate::geometry::{Point, add_scaled, bounding_box, determinant, dot, norm, sub};
use crate::mesh::facets::components;
use crate::mesh::{CellBlock, Mesh};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Part of the cells by which a cut may be moved to lie between layers.
const AWAY: f64 = 0.1;

/// Products with the matrix of spreads after which a direction is long enough: any direction does where several are as long.
const TURNS: usize = 20;

/// How many pieces there shall be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Count {
    Exactly(usize),
    /// As many as lie side by side.
    About(f64),
}

impl<const D: usize> Mesh<D> {
    /// For each cell, block after block, the number of its piece. Pieces are numbered in the order of their first cells. Each is
    /// connected through facets; where the mesh itself is not, there may be more of them.
    pub(crate) fn pieces(&self, count: Count) -> Vec<u32> {
        let cells = self.extents();
        let mut all: Vec<u32> = (0..cells.len() as u32).collect();
        let count = match count {
            Count::Exactly(count) => Count::Exactly(count.clamp(1, cells.len())),
            about => about,
        };
        let pairs = self.neighbours();
        let mut pieces = Pieces {
            of_cell: vec![0; cells.len()],
            next: 0,
            beyond: vec![false; cells.len()],
            cells,
        };
        pieces.divide(&mut all, &pairs, count);
        connected(smooth(pieces.of_cell, &pairs), &pairs)
    }

    /// The cells of every piece as a mesh without sides, with the nodes of this mesh that are its own, ascending.
    pub(crate) fn parts(&self, of_cell: &[u32]) -> Vec<(Self, Vec<u32>)> {
        let count = of_cell.iter().max().map_or(0, |last| *last as usize + 1);
        let mut blocks: Vec<Vec<CellBlock>> = vec![Vec::new(); count];
        let mut of_cells = of_cell.iter();
        for block in self.blocks() {
            let none = CellBlock {
                nodes: Vec::new(),
                ..block.clone()
            };
            blocks.iter_mut().for_each(|own| own.push(none.clone()));
            for (cell, &piece) in block.cells().zip(&mut of_cells) {
                if let Some(last) = blocks[piece as usize].last_mut() {
                    last.nodes.extend_from_slice(cell);
                }
            }
        }
        let part = |mut blocks: Vec<CellBlock>| {
            blocks.retain(|block| !block.nodes.is_empty());
            let mut nodes: Vec<u32> = blocks.iter().flat_map(|b| &b.nodes).copied().collect();
            nodes.sort_unstable();
            nodes.dedup();
            let place = |node: u32| nodes.partition_point(|&own| own < node) as u32;
            let all = blocks.iter_mut().flat_map(|block| &mut block.nodes);
            all.for_each(|node| *node = place(*node));
            let points = nodes
                .iter()
                .map(|&node| self.points[node as usize])
                .collect();
            (Self::of_parts(points, blocks), nodes)
        };
        blocks.into_par_iter().map(part).collect()
    }

    /// The extents of all cells.
    fn extents(&self) -> Vec<Extent<D>> {
        let extent = |nodes: &[u32], corners: usize| {
            let points = nodes[..corners].iter();
            let points: Vec<Point<D>> = points.map(|&node| self.points()[node as usize]).collect();
            let sum = points
                .iter()
                .fold([0.0; D], |sum, x| add_scaled(sum, 1.0, *x));
            let (low, high) = bounding_box(&points);
            Extent {
                centre: sum.map(|c| c / corners as f64),
                spread: sub(high, low).map(|length| length * length / 12.0),
                size: norm(sub(high, low)),
                nodes: nodes.len() as f64,
            }
        };
        let blocks = self.blocks().iter();
        let cells = blocks.flat_map(|block| block.cells().map(move |cell| (block.kind, cell)));
        cells
            .map(|(kind, cell)| extent(cell, kind.corners()))
            .collect()
    }
}

/// What of a cell matters for its piece.
struct Extent<const D: usize> {
    centre: Point<D>,
    /// The mean square of its coordinates about the centre, as a box has it.
    spread: Point<D>,
    /// The diagonal of that box.
    size: f64,
    nodes: f64,
}

/// Cells that differ more than this in size are not cut side by side.
const GRADED: f64 = 3.0;

/// Pieces of cells, numbered so far.
struct Pieces<const D: usize> {
    cells: Vec<Extent<D>>,
    of_cell: Vec<u32>,
    /// The number of the next piece.
    next: u32,
    /// Whether a cell is beyond the last cut that was tried.
    beyond: Vec<bool>,
}

impl<const D: usize> Pieces<D> {
    /// Divides some cells, which meet in these pairs.
    fn divide(&mut self, own: &mut [u32], pairs: &[[u32; 2]], count: Count) {
        let sizes = own.iter().map(|&cell| self.cells[cell as usize].size);
        let (least, most) = sizes.fold((f64::INFINITY, 0.0f64), |(least, most), size| {
            (least.min(size), most.max(size))
        });
        match most > GRADED * least {
            true => self.halve(own, pairs, count),
            false => self.cut_side_by_side(own, count),
        }
    }

    fn number(&mut self, own: &[u32]) {
        own.iter()
            .for_each(|&cell| self.of_cell[cell as usize] = self.next);
        self.next += 1;
    }

    /// Divides cells of about the same size into parts side by side.
    fn cut_side_by_side(&mut self, own: &mut [u32], count: Count) {
        let (along, slender) = longest(&self.cells, own);
        let wanted = |pieces: f64| slender * pieces.powf(1.0 / D as f64);
        let parts = match count {
            Count::Exactly(count) if count > 1 => parts_of(count, wanted(count as f64)),
            Count::Exactly(_) => Vec::new(),
            Count::About(count) => vec![1; (wanted(count).round() as usize).min(own.len())],
        };
        if parts.len() < 2 {
            self.number(own);
            return;
        }
        let size = own.len() as f64;
        let (mut rest, mut left) = (own, parts.iter().sum::<usize>());
        Across::Plane(along).sort(&self.cells, rest);
        for part in parts {
            let cut = match left > part {
                true => Across::Plane(along).cut(&self.cells, rest, (part, left)),
                false => rest.len(),
            };
            let (below, above) = rest.split_at_mut(cut);
            let count = match count {
                Count::Exactly(_) => Count::Exactly(part),
                // as large as all others, so that the cuts across lie side by side
                Count::About(count) => Count::About(count * below.len() as f64 / size),
            };
            self.cut_side_by_side(below, count);
            (rest, left) = (above, left - part);
        }
    }

    /// Halves cells where the fewest of their pairs are parted.
    fn halve(&mut self, own: &mut [u32], pairs: &[[u32; 2]], count: Count) {
        let (part, all) = match count {
            Count::Exactly(count) => (count / 2, count),
            Count::About(count) if count >= 1.5 => (1, 2),
            Count::About(_) => (0, 1),
        };
        if part == 0 || own.len() < 2 {
            self.number(own);
            return;
        }
        let mut best: Option<(usize, Vec<u32>, usize)> = None;
        for across in Across::candidates(&self.cells, own) {
            let mut order = own.to_vec();
            across.sort(&self.cells, &mut order);
            let cut = across.cut(&self.cells, &order, (part, all));
            self.mark(&order, cut);
            let parted = pairs.iter().filter(|pair| self.parts(pair)).count();
            if best.as_ref().is_none_or(|(least, ..)| parted < *least) {
                best = Some((parted, order, cut));
            }
        }
        let Some((_, order, cut)) = best else { return };
        self.mark(&order, cut);
        own.copy_from_slice(&order);
        let inner = pairs.iter().copied().filter(|pair| !self.parts(pair));
        let is_below = |pair: &[u32; 2]| !self.beyond[pair[0] as usize];
        let (near, far): (Vec<_>, Vec<_>) = inner.partition(is_below);
        let share = cut as f64 / own.len() as f64;
        let counts = match count {
            Count::Exactly(count) => [part, count - part].map(Count::Exactly),
            Count::About(count) => [share, 1.0 - share].map(|share| Count::About(share * count)),
        };
        let (below, above) = own.split_at_mut(cut);
        self.divide(below, &near, counts[0]);
        self.divide(above, &far, counts[1]);
    }

    fn mark(&mut self, order: &[u32], cut: usize) {
        for (place, &cell) in order.iter().enumerate() {
            self.beyond[cell as usize] = place >= cut;
        }
    }

    fn parts(&self, pair: &[u32; 2]) -> bool {
        let [a, b] = pair.map(|cell| self.beyond[cell as usize]);
        a != b
    }
}

/// What cells are cut across.
#[derive(Clone, Copy)]
enum Across<const D: usize> {
    /// A direction.
    Plane(Point<D>),
    /// The distance from a point.
    Sphere(Point<D>),
}

impl<const D: usize> Across<D> {
    /// Planes across the axes and across the direction in which the cells extend most; spheres around their middle and around the
    /// smallest of them.
    fn candidates(cells: &[Extent<D>], own: &[u32]) -> Vec<Self> {
        let axis = |d: usize| std::array::from_fn(|k| f64::from(u8::from(k == d)));
        let planes = (0..D).map(axis).chain([longest(cells, own).0]);
        let centre = |&cell: &u32| cells[cell as usize].centre;
        let middle = |d: usize| {
            let mut places: Vec<f64> = own.iter().map(|cell| centre(cell)[d]).collect();
            let half = places.len() / 2;
            *places.select_nth_unstable_by(half, f64::total_cmp).1
        };
        let size = |cell: &u32| cells[*cell as usize].size;
        let smallest = own
            .iter()
            .min_by(|a, b| size(a).total_cmp(&size(b)).then(a.cmp(b)));
        let points = smallest
            .map(centre)
            .into_iter()
            .chain([std::array::from_fn(middle)]);
        planes
            .map(Self::Plane)
            .chain(points.map(Self::Sphere))
            .collect()
    }

    fn place(&self, x: Point<D>) -> f64 {
        match self {
            Self::Plane(along) => dot(x, *along),
            Self::Sphere(middle) => norm(sub(x, *middle)),
        }
    }

    /// Sorts cells in ascending order of their places.
    fn sort(&self, cells: &[Extent<D>], own: &mut [u32]) {
        let places = own
            .iter()
            .map(|&cell| (self.place(cells[cell as usize].centre), cell));
        let mut places: Vec<(f64, u32)> = places.collect();
        places.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let sorted = own.iter_mut().zip(places);
        sorted.for_each(|(own, (_, cell))| *own = cell);
    }

    /// How many of sorted cells are the share of `part` of `whole` pieces.
    fn cut(&self, cells: &[Extent<D>], own: &[u32], share: (usize, usize)) -> usize {
        cut_off(cells, own, share, |cell| {
            self.place(cells[cell as usize].centre)
        })
    }
}

/// Most sweeps over all cells.
const SWEEPS: usize = 20;

/// By how much of its cells a piece may grow or shrink so that its borders have no teeth.
const GROWTH: f64 = 0.25;

/// Gives cells to the piece with which they have most facets in common.
fn smooth(mut of_cell: Vec<u32>, pairs: &[[u32; 2]]) -> Vec<u32> {
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); of_cell.len()];
    for &[a, b] in pairs {
        beside[a as usize].push(b);
        beside[b as usize].push(a);
    }
    let mut sizes = vec![0usize; of_cell.iter().max().map_or(0, |last| *last as usize + 1)];
    of_cell.iter().for_each(|&piece| sizes[piece as usize] += 1);
    let least: Vec<f64> = sizes.iter().map(|&n| (1.0 - GROWTH) * n as f64).collect();
    let most: Vec<f64> = sizes.iter().map(|&n| (1.0 + GROWTH) * n as f64).collect();
    for _ in 0..SWEEPS {
        let mut moved = false;
        for cell in 0..of_cell.len() {
            let own = of_cell[cell];
            let facets = |piece: u32| {
                let others = beside[cell].iter();
                others
                    .filter(|&&other| of_cell[other as usize] == piece)
                    .count()
            };
            let others = beside[cell].iter().map(|&other| of_cell[other as usize]);
            let found = others.max_by_key(|&piece| (facets(piece), std::cmp::Reverse(piece)));
            let Some(other) = found.filter(|&other| facets(other) > facets(own)) else {
                continue;
            };
            let [from, to] = [own, other].map(|piece| piece as usize);
            if sizes[from] as f64 - 1.0 >= least[from] && sizes[to] as f64 + 1.0 <= most[to] {
                of_cell[cell] = other;
                sizes[from] -= 1;
                sizes[to] += 1;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    of_cell
}

/// Parts that are this much more or fewer than wanted are nearly as compact.
const NEAR: f64 = 1.2;

/// The numbers of pieces of parts that are cut side by side: about as many parts as wanted, with as many pieces each where some number
/// near that divides the count.
fn parts_of(count: usize, wanted: f64) -> Vec<usize> {
    let off = |parts: usize| (parts as f64 / wanted).ln().abs();
    let near = (wanted / NEAR) as usize..=(wanted * NEAR) as usize + 1;
    let divides = |parts: &usize| (2..=count).contains(parts) && count.is_multiple_of(*parts);
    let alike = near.filter(|parts| divides(parts) && off(*parts) <= NEAR.ln());
    let alike = alike.min_by(|&a, &b| off(a).total_cmp(&off(b)));
    let parts = alike.unwrap_or((wanted.round() as usize).clamp(2, count));
    let rest = count % parts;
    let part = |k: usize| count / parts + usize::from(k < rest);
    (0..parts).map(part).collect()
}

/// How many cells, in ascending order of their `place`, are the share of `part` of `whole` pieces.
fn cut_off<const D: usize>(
    cells: &[Extent<D>],
    own: &[u32],
    (part, whole): (usize, usize),
    place: impl Fn(u32) -> f64,
) -> usize {
    let weight = |&cell: &u32| cells[cell as usize].nodes;
    let share = own.iter().map(weight).sum::<f64>() * part as f64 / whole as f64;
    let below = own.iter().scan(0.0, |sum, cell| {
        *sum += weight(cell);
        Some(*sum)
    });
    // of sums that are alike but for rounding the first one is meant
    let below = below.take_while(|sum| *sum <= share * (1.0 + 1e-9)).count();
    let cut = between_layers(own.len(), below, |i| place(own[i]));
    cut.clamp(part, own.len() - (whole - part))
}

/// Where to cut `count` cells in ascending order of their `place`, near a cut: between two layers, if there are any.
fn between_layers(count: usize, cut: usize, place: impl Fn(usize) -> f64) -> usize {
    let away = (count as f64 * AWAY) as usize;
    let gap = |i: usize| place(i) - place(i - 1);
    let near = cut.saturating_sub(away).max(1)..(cut + away + 1).min(count);
    let widest = near.clone().map(gap).fold(0.0, f64::max);
    let as_wide = near.filter(|&i| gap(i) >= 0.5 * widest);
    as_wide.min_by_key(|i| i.abs_diff(cut)).unwrap_or(cut)
}

/// The direction in which some cells extend most, and their length along it over the side of a cube, or square, of the same size.
fn longest<const D: usize>(cells: &[Extent<D>], own: &[u32]) -> (Point<D>, f64) {
    let all = || own.iter().map(|&cell| &cells[cell as usize]);
    let share = 1.0 / own.len() as f64;
    let mean = all().fold([0.0; D], |sum, cell| add_scaled(sum, share, cell.centre));
    let mut spread = [[0.0; D]; D];
    for cell in all() {
        let x = sub(cell.centre, mean);
        for (d, row) in spread.iter_mut().enumerate() {
            row.iter_mut()
                .zip(x)
                .for_each(|(entry, b)| *entry += share * x[d] * b);
            row[d] += share * cell.spread[d];
        }
    }
    let widest = (0..D).max_by(|&a, &b| spread[a][a].total_cmp(&spread[b][b]).then(b.cmp(&a)));
    let mut along = [0.0; D];
    along[widest.unwrap_or(0)] = 1.0;
    for _ in 0..TURNS {
        let next: Point<D> = spread.map(|row| dot(row, along));
        let size = norm(next);
        if size == 0.0 {
            break;
        }
        along = next.map(|c| c / size);
    }
    let largest = dot(along, spread.map(|row| dot(row, along)));
    let size = determinant(&spread).powf(1.0 / D as f64);
    let slender = if size > 0.0 {
        (largest / size).sqrt()
    } else {
        1.0
    };
    (along, slender)
}

/// The pieces made connected by `pairs` of cells, and numbered in the order of their first cells.
fn connected(mut of_cell: Vec<u32>, pairs: &[[u32; 2]]) -> Vec<u32> {
    loop {
        let alike = |pair: &&[u32; 2]| of_cell[pair[0] as usize] == of_cell[pair[1] as usize];
        let component = components(of_cell.len(), pairs.iter().filter(alike).copied());
        let stays = largest(&of_cell, &component);
        // facets that a component which does not stay has in common with pieces that do
        let mut shared: BTreeMap<u32, BTreeMap<u32, usize>> = BTreeMap::new();
        for &[a, b] in pairs {
            for [a, b] in [[a, b], [b, a]].map(|ends| ends.map(|cell| cell as usize)) {
                if !stays[component[a] as usize] && stays[component[b] as usize] {
                    *shared
                        .entry(component[a])
                        .or_default()
                        .entry(of_cell[b])
                        .or_default() += 1;
                }
            }
        }
        if shared.is_empty() {
            return component;
        }
        for (piece, own) in of_cell.iter_mut().zip(&component) {
            let others = shared.get(own).into_iter().flatten();
            let most = others.max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(a.0)));
            if let Some((&other, _)) = most {
                *piece = other;
            }
        }
    }
}

/// For each component whether it is the largest one of its piece, the first of equals.
fn largest(of_cell: &[u32], component: &[u32]) -> Vec<bool> {
    let count = component.iter().max().map_or(0, |last| *last as usize + 1);
    let (mut size, mut piece) = (vec![0usize; count], vec![0; count]);
    for (&own, &of) in component.iter().zip(of_cell) {
        size[own as usize] += 1;
        piece[own as usize] = of;
    }
    let mut best: BTreeMap<u32, usize> = BTreeMap::new();
    for own in 0..count {
        let before = best.entry(piece[own]).or_insert(own);
        if size[own] > size[*before] {
            *before = own;
        }
    }
    (0..count).map(|own| best[&piece[own]] == own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Cuboid, Diagonals, Rectangle};

    fn rectangle(cells: [usize; 2], cell: CellKind) -> Mesh<2> {
        let rectangle = Rectangle {
            from: [0.0, 0.0],
            to: cells.map(|n| n as f64),
            cells,
            cell,
            diagonals: Diagonals::default(),
        };
        rectangle.build().unwrap()
    }

    fn box_of(cells: [usize; 3], cell: CellKind) -> Mesh<3> {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: cells.map(|n| n as f64),
            cells,
            cell,
        };
        cuboid.build().unwrap()
    }

    fn sizes(of_cell: &[u32]) -> Vec<usize> {
        let count = of_cell.iter().max().map_or(0, |last| *last as usize + 1);
        let mut sizes = vec![0; count];
        of_cell.iter().for_each(|&piece| sizes[piece as usize] += 1);
        sizes
    }

    #[test]
    fn halves_are_cut_across_the_longer_direction_between_layers() {
        let mesh = rectangle([9, 4], CellKind::Quad4);
        // 36 cells: the cut nearest to 18 lies behind the fourth or fifth layer
        let two = sizes(&mesh.pieces(Count::Exactly(2)));
        assert!(two == [16, 20] || two == [20, 16], "{two:?}");
        assert_eq!(sizes(&mesh.pieces(Count::Exactly(1))), [36]);
        assert_eq!(sizes(&mesh.pieces(Count::Exactly(0))), [36]);
        assert_eq!(sizes(&mesh.pieces(Count::Exactly(1000))), [1; 36]);
        let square = rectangle([8, 8], CellKind::Quad4);
        assert_eq!(sizes(&square.pieces(Count::Exactly(4))), [16; 4]);
        assert_eq!(sizes(&square.pieces(Count::Exactly(16))), [4; 16]);
    }

    #[test]
    fn free_number_of_pieces_is_one_of_pieces_side_by_side() {
        let mesh = box_of([14, 14, 7], CellKind::Hex8);
        // 3.4 cells across each: 4, 4 and 2 pieces
        let of_cell = mesh.pieces(Count::About(35.0));
        let sizes = sizes(&of_cell);
        assert_eq!(sizes.len(), 32);
        let mut cuts = [(); 3].map(|()| std::collections::BTreeSet::new());
        for (part, _) in mesh.parts(&of_cell) {
            let (low, high) = bounding_box(part.points());
            let volume: f64 = sub(high, low).iter().product();
            assert_eq!(part.cell_count() as f64, volume);
            (0..3).for_each(|d| {
                cuts[d].insert(low[d] as usize);
            });
        }
        assert_eq!(cuts.map(|cuts| cuts.len()), [4, 4, 2]);
    }

    #[test]
    fn pieces_are_connected_and_about_as_large() {
        for (mesh, count) in [
            (rectangle([17, 5], CellKind::Tri3), 7),
            (rectangle([6, 6], CellKind::Tri6), 5),
            (rectangle([30, 1], CellKind::Quad8), 4),
        ] {
            let of_cell = mesh.pieces(Count::Exactly(count));
            let sizes = sizes(&of_cell);
            assert_eq!(sizes.len(), count);
            let (least, most) = (sizes.iter().min().unwrap(), sizes.iter().max().unwrap());
            assert!(2 * least >= *most, "{sizes:?}");
            let parts = mesh.parts(&of_cell);
            assert!(parts.iter().all(|(part, _)| part.component_count() == 1));
            let cells: usize = parts.iter().map(|(part, _)| part.cell_count()).sum();
            assert_eq!(cells, mesh.cell_count());
        }
    }

    #[test]
    fn parts_have_the_nodes_of_the_whole() {
        let mesh = box_of([6, 4, 2], CellKind::Hex20);
        for (part, nodes) in mesh.parts(&mesh.pieces(Count::Exactly(6))) {
            assert_eq!(part.points().len(), nodes.len());
            let points = nodes.iter().map(|&node| mesh.points()[node as usize]);
            assert!(points.eq(part.points().iter().copied()));
            assert_eq!(part.component_count(), 1);
        }
    }

    #[test]
    fn what_falls_apart_joins_its_neighbours() {
        // a row of cells 0 0 1 1 0 0: the second half of 0 joins 1
        let pairs: Vec<[u32; 2]> = (0..5).map(|k| [k, k + 1]).collect();
        assert_eq!(
            connected(vec![0, 0, 1, 1, 0, 0], &pairs),
            [0, 0, 1, 1, 1, 1]
        );
        // two rows that nothing connects
        assert_eq!(connected(vec![0; 4], &[[0, 1], [2, 3]]), [0, 0, 1, 1]);
    }
}
