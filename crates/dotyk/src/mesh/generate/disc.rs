//! A disc or a sector of one: a core of quadrilaterals in the middle, rings around it, no degenerate cell.
//!
//! The core of a full disc is one patch of a × b squares, 2(a + b) = around; that of a sector has one patch between each
//! two of q + 1 spokes with m₀ … m_q cells, so that around = Σ (mᵢ + mᵢ₊₁), and q is such that the patches meet in the
//! centre at about 90°. Corner and edges of the core lie between those of a polygon and of a circle, which leaves angles
//! of 90° to 120° everywhere; inside, the patch is Coons' blend of its edges. Rings are straight lines from the core to the
//! circle, whose nodes are spaced equally.

use crate::geometry::{Point, add_scaled};
use crate::mesh::generate::{direction, is_full, within_reach, wrong};
use crate::mesh::{CellBlock, CellKind, Facet, Mesh, MeshError};
use std::collections::BTreeMap;

/// Disc about the origin; sides outer, and start end unless it is full.
pub(super) struct Disc {
    /// In messages.
    pub generator: &'static str,
    pub radius: f64,
    /// First and last angle in degrees.
    pub angles: [f64; 2],
    /// Cells around, and from the core outwards.
    pub cells: [usize; 2],
    /// Kind of quadrilaterals.
    pub cell: CellKind,
}

/// Place of a node: patch or spoke, and its steps in it; the rings come after the last spoke.
type Key = [usize; 3];

/// A patch of the core.
struct Patch {
    /// Cells in its two directions.
    cells: [usize; 2],
    /// Where along the rim its edge at the end of the first direction begins; that at the end of the second follows, and
    /// around a full disc the other two.
    rim: usize,
}

/// Layout of the core.
struct Core {
    full: bool,
    /// Cells along each spoke; of a full disc the cells along its two directions.
    spokes: Vec<usize>,
    patches: Vec<Patch>,
    /// Corners of the core along the rim, in cells.
    corners: Vec<usize>,
    /// Angle of the first node of the rim, angle of a cell, in degrees.
    first: f64,
    step: f64,
    around: usize,
    /// Distance of its corners from the centre.
    radius: f64,
}

/// Roundness of the core: between 0, a polygon, and 1, a circle.
const ROUND: f64 = 0.5;

impl Disc {
    /// The mesh.
    ///
    /// Errors: too many cells, too few for a core, an odd number around a full disc.
    pub fn build(&self) -> Result<Mesh<2>, MeshError> {
        let [around, through] = self.cells;
        let order = self.cell.order();
        within_reach(self.cell_count().saturating_mul((order * order) as u128))?;
        let core = self.core()?;
        let mut weave = Weave::new(self.cell);
        for (index, patch) in core.patches.iter().enumerate() {
            weave.patch(patch.cells, |u, v| {
                let key = core.key(index, [u, v]);
                let share = |at: usize, n: usize| at as f64 / (order * n) as f64;
                let [s, t] = [share(u, patch.cells[0]), share(v, patch.cells[1])];
                (key, core.inside(patch, s, t))
            });
        }
        let rim = core.rim(order);
        let last = rim.len() - 1;
        let ends = if core.full { last } else { last + 1 };
        let of_rings = weave.cells();
        weave.patch([through, around], |u, v| {
            let key = match u {
                0 => rim[v],
                _ => [core.patches.len() + 1, u, v % ends],
            };
            let at = v as f64 / order as f64;
            let s = u as f64 / (order * through) as f64;
            let outer = direction(core.angle(at)).map(|c| self.radius * c);
            let inner = core.edge(at);
            let point = std::array::from_fn(|d| match s {
                1.0 => outer[d],
                _ => inner[d] + s * (outer[d] - inner[d]),
            });
            (key, point)
        });
        let facet = |cell: usize, local: u32| Facet {
            block: 0,
            cell: cell as u32,
            local,
        };
        let outer = (1..=around).map(|j| facet(of_rings + j * through - 1, 1));
        let mut sides = BTreeMap::from([("outer".to_string(), outer.collect::<Vec<_>>())]);
        if !core.full {
            let rings = (0..through).map(|i| facet(of_rings + i, 0));
            let spoke = (0..core.spokes[0]).map(|i| facet(i, 0));
            sides.insert("start".to_string(), spoke.chain(rings).collect());
            let rings = (of_rings + (around - 1) * through..weave.cells()).map(|i| facet(i, 2));
            let [m, n] = core.patches.last().map_or([0, 0], |patch| patch.cells);
            let spoke = (0..n).map(|j| facet(of_rings - m * n + j * m, 3));
            sides.insert("end".to_string(), spoke.chain(rings).collect());
        }
        Mesh::new(weave.points, vec![weave.block])?.with_sides(sides)
    }

    /// Number of cells of the mesh.
    pub fn cell_count(&self) -> u128 {
        let area = |[m, n]: [usize; 2]| m as u128 * n as u128;
        let core = self.core().map_or(Vec::new(), |core| core.patches);
        let patches = core.iter().map(|patch| area(patch.cells));
        patches.sum::<u128>().saturating_add(area(self.cells))
    }

    fn core(&self) -> Result<Core, MeshError> {
        let [around, through] = self.cells;
        let [from, to] = self.angles;
        let wrong = |need| {
            let value = format!("{:?}", self.cells);
            Err(wrong(self.generator, "cells", value, need))
        };
        let span = to - from;
        let full = is_full(span);
        let (spokes, patches, corners, shift);
        if full {
            if around < 4 || !around.is_multiple_of(2) {
                return wrong(
                    "around a full turn without `inner` use an even number of cells, at least 4",
                );
            }
            let a = around.div_ceil(4);
            let b = around / 2 - a;
            spokes = vec![a, b];
            patches = vec![Patch {
                cells: [a, b],
                rim: 0,
            }];
            corners = vec![0, b, a + b, a + 2 * b];
            shift = b / 2;
        } else {
            let q = ((span / 90.0).round() as usize).clamp(1, 4);
            if around < 2 * q {
                return wrong(
                    "use at least two cells around for each 90 degrees of a part without `inner`",
                );
            }
            let inner = around / (2 * q);
            let rest = around - 2 * (q - 1) * inner;
            let mut m = vec![inner; q + 1];
            (m[0], m[q]) = (rest / 2, rest - rest / 2);
            let starts: Vec<usize> = (0..q)
                .map(|i| m[..i].iter().sum::<usize>() + m[1..=i].iter().sum::<usize>())
                .collect();
            corners = (0..q).map(|i| starts[i] + m[i + 1]).collect();
            let patch = |i: usize| Patch {
                cells: [m[i], m[i + 1]],
                rim: starts[i],
            };
            patches = (0..q).map(patch).collect();
            spokes = m;
            shift = 0;
        }
        let step = span / around as f64;
        // cells of the core and of the rings of about the same size
        let deep = around as f64 * 45.0 / span.max(90.0);
        let share = (deep / (deep + through as f64)).clamp(0.3, 0.75);
        Ok(Core {
            full,
            spokes,
            patches,
            corners,
            first: from - step * shift as f64,
            step,
            around,
            radius: 1.1 * share * self.radius,
        })
    }
}

impl Core {
    /// Angle of a place of the rim, in degrees.
    fn angle(&self, at: f64) -> f64 {
        self.first + self.step * at
    }

    /// The point of the edge of the core at a place of the rim.
    fn edge(&self, at: f64) -> Point<2> {
        let (n, corners) = (self.around as f64, &self.corners);
        // the end of a sector is not a beginning
        let at = if self.full { at % n } else { at };
        let (first, last) = (corners[0] as f64, corners[corners.len() - 1] as f64);
        // beyond the last corner is the first one again, or its image in the last spoke
        let (before, after) = match self.full {
            true => (last - n, first + n),
            false => (-first, 2.0 * n - last),
        };
        let mut ends = [before, after];
        for corner in corners.iter().map(|&c| c as f64) {
            if corner <= at {
                ends[0] = ends[0].max(corner);
            } else {
                ends[1] = ends[1].min(corner);
            }
        }
        let angle = |cells: f64| (self.step * cells).to_radians();
        let half = angle(0.5 * (ends[1] - ends[0]));
        let chord = half.cos() / angle(at - 0.5 * (ends[0] + ends[1])).cos();
        let radius = self.radius * ((1.0 - ROUND) * chord + ROUND);
        direction(self.angle(at)).map(|c| radius * c)
    }

    /// The point of a patch at shares of its two directions.
    fn inside(&self, patch: &Patch, s: f64, t: f64) -> Point<2> {
        let [m, n] = patch.cells.map(|cells| cells as f64);
        let along = |place: f64| self.edge(patch.rim as f64 + place);
        let (right, top) = (along(t * n), along(n + (1.0 - s) * m));
        let (bottom, left) = match self.full {
            true => (along(2.0 * n + m + s * m), along(n + m + (1.0 - t) * n)),
            false => (along(0.0).map(|c| s * c), along(n + m).map(|c| t * c)),
        };
        let corner = [
            if self.full {
                along(2.0 * n + m)
            } else {
                [0.0; 2]
            },
            along(0.0),
            along(n),
            along(n + m),
        ];
        let edges = [(1.0 - t, bottom), (t, top), (1.0 - s, left), (s, right)];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t];
        let blend = edges
            .iter()
            .fold([0.0; 2], |sum, &(w, x)| add_scaled(sum, w, x));
        corner
            .iter()
            .zip(weights)
            .fold(blend, |sum, (&x, w)| add_scaled(sum, -w, x))
    }

    /// The key of a node of a patch; neighbours have those on their common spoke in common.
    fn key(&self, index: usize, [u, v]: [usize; 2]) -> Key {
        match (self.full, u, v) {
            (false, 0, 0) => [0, 0, 0],
            (false, 0, _) => [index + 1, v, 0],
            _ => [index, u, v],
        }
    }

    /// Keys of the nodes along the edge of the core.
    fn rim(&self, order: usize) -> Vec<Key> {
        let mut rim = Vec::new();
        for (index, patch) in self.patches.iter().enumerate() {
            let [m, n] = patch.cells.map(|cells| order * cells);
            let key = |at| self.key(index, at);
            rim.pop();
            rim.extend((0..=n).map(|v| key([m, v])));
            rim.extend((0..m).rev().map(|u| key([u, n])));
            if self.full {
                rim.extend((0..n).rev().map(|v| key([0, v])));
                rim.extend((1..=m).map(|u| key([u, 0])));
            }
        }
        rim
    }
}

/// A mesh of one kind of quadrilaterals from patches whose nodes are the same where their keys are.
struct Weave {
    numbers: BTreeMap<Key, u32>,
    points: Vec<Point<2>>,
    block: CellBlock,
}

impl Weave {
    fn new(kind: CellKind) -> Self {
        let (nodes, group) = (Vec::new(), None);
        Self {
            numbers: BTreeMap::new(),
            points: Vec::new(),
            block: CellBlock { kind, nodes, group },
        }
    }

    fn cells(&self) -> usize {
        self.block.cells().len()
    }

    /// m × n cells, the first direction fastest; `node` tells key and point at each place of their lattice.
    fn patch(&mut self, [m, n]: [usize; 2], node: impl Fn(usize, usize) -> (Key, Point<2>)) {
        let kind = self.block.kind;
        for cell in 0..m * n {
            for xi in kind.reference_nodes() {
                let step = |d: usize| ((xi[d] + 1.0) as usize) * kind.order() / 2;
                let (i, j) = (cell % m, cell / m);
                let (key, point) = node(kind.order() * i + step(0), kind.order() * j + step(1));
                let number = *self.numbers.entry(key).or_insert_with(|| {
                    self.points.push(point);
                    self.points.len() as u32 - 1
                });
                self.block.nodes.push(number);
            }
        }
    }
}
