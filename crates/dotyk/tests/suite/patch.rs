//! Contact patches of every kind of cell, and what an elastic contact problem must obey whatever its data:
//! action = reaction, balance, energy identities, independence of axes, units, names and order.
//!
//! Tolerances are rounding: 1e-10 of the largest value for fields (a factorisation loses some digits), 1e-12 for sums.

use dotyk::fem::assemble;
use dotyk::geometry::{Field, Point, dot};
use dotyk::mesh::{CellKind, Diagonals, Mesh, Rectangle};
use dotyk::model::{
    BodyId, BodySolution, DENSE_LIMIT, Elastic, Gap, Load, Model, Place, Solution, Status, Support,
};

/// A pile of blocks [0, 2] × [k, k + 1], each on rollers at its left, the lowest on rollers at its bottom.
///
/// The blocks above float along y: contact alone carries them. Everything is turned by `angle`, then scaled.
#[derive(Clone, Copy)]
struct Pile {
    cell: CellKind,
    blocks: usize,
    /// Cells of each block.
    cells: [usize; 2],
    /// Degrees.
    angle: f64,
    /// Factor of all lengths.
    length: f64,
    /// Factor of all forces.
    force: f64,
    /// The lower side of each contact carries the multipliers.
    swapped: bool,
    /// Bodies are listed from the top.
    reversed: bool,
    /// Right end of the load on the top, of a width of 2.
    loaded: f64,
    /// Initial gap along the first contact, as a function of x in [0, 2].
    crown: f64,
}

const WIDTH: f64 = 2.0;
const PRESSURE: f64 = 3.0;
const MATERIALS: [Elastic; 3] = [
    Elastic {
        young: 1000.0,
        poisson: 0.3,
    },
    Elastic {
        young: 400.0,
        poisson: 0.2,
    },
    Elastic {
        young: 2500.0,
        poisson: 0.4,
    },
];

impl Pile {
    fn of(cell: CellKind, blocks: usize) -> Self {
        Self {
            cell,
            blocks,
            cells: [4, 3],
            angle: 0.0,
            length: 1.0,
            force: 1.0,
            swapped: false,
            reversed: false,
            loaded: WIDTH,
            crown: 0.0,
        }
    }

    /// The load on a part of the top only, and a crowned interface: the contact opens.
    fn opening(cell: CellKind) -> Self {
        Self {
            cells: [12, 4],
            loaded: 1.0,
            crown: 1e-3,
            ..Self::of(cell, 2)
        }
    }

    fn turned(&self, [x, y]: Point<2>) -> Point<2> {
        let (s, c) = self.angle.to_radians().sin_cos();
        [c * x - s * y, s * x + c * y]
    }

    /// The way back, of a vector.
    fn turned_back(&self, [x, y]: Point<2>) -> Point<2> {
        let (s, c) = self.angle.to_radians().sin_cos();
        [c * x + s * y, c * y - s * x]
    }

    fn stress_unit(&self) -> f64 {
        self.force / (self.length * self.length)
    }

    /// A block with distorted (curved, where quadratic) cells inside and straight sides.
    fn mesh(&self, block: usize) -> Mesh<2> {
        let bottom = block as f64;
        let rectangle = Rectangle {
            from: [0.0, bottom],
            to: [WIDTH, bottom + 1.0],
            cells: self.cells,
            cell: self.cell,
            diagonals: Diagonals::Checkerboard,
        };
        let place = |[x, y]: Point<2>| {
            let bump = 0.5 * x * (WIDTH - x) * (y - bottom) * (bottom + 1.0 - y);
            let moved = [x + 0.6 * bump * (1.0 - y), y + 0.4 * bump * (x - 0.7)];
            self.turned(moved).map(|c| self.length * c)
        };
        let mesh = rectangle.build().unwrap();
        let on_load = {
            let end = self.loaded + 1e-9;
            move |[x, y]: Point<2>| (y - bottom - 1.0).abs() < 1e-9 && x < end
        };
        mesh.with_side("loaded", on_load).map_points(place).unwrap()
    }

    fn model(&self) -> Model<2> {
        let mut model = Model::new();
        let mut order: Vec<usize> = (0..self.blocks).collect();
        if self.reversed {
            order.reverse();
        }
        let mut ids = vec![BodyId(0); self.blocks];
        for &block in &order {
            let Elastic { young, poisson } = MATERIALS[block];
            let elastic = Elastic {
                young: young * self.stress_unit(),
                poisson,
            };
            ids[block] = model.body(&name(block), self.mesh(block), elastic);
            model.roller(ids[block], "left", 0.0);
        }
        model.roller(ids[0], "bottom", 0.0);
        let traction = self.turned([0.0, -PRESSURE * self.stress_unit()]);
        model.pull(ids[self.blocks - 1], "loaded", traction);
        for (lower, pair) in ids.windows(2).enumerate() {
            let (below, above) = ((pair[0], "top"), (pair[1], "bottom"));
            let contact = match self.swapped {
                false => model.contact(above, below),
                true => model.contact(below, above),
            };
            if lower == 0 && self.crown != 0.0 {
                contact.gap = Some(Gap::Given(self.gap()));
            }
        }
        model
    }

    /// Initial gap: closed in the middle of the load, open to both sides.
    fn gap(&self) -> Field {
        let pile = *self;
        Field::function("crown", move |p, _| {
            let [x, _] = pile.turned_back([p[0] / pile.length, p[1] / pile.length]);
            pile.length * pile.crown * (x - 0.5).powi(2)
        })
    }

    fn solve(&self) -> Solution<2> {
        let solution = self.model().solve().unwrap();
        assert!(solution.certificate.holds());
        solution
    }
}

fn name(block: usize) -> String {
    ["low", "middle", "high"][block].to_string()
}

fn body<'a>(model: &Model<2>, solution: &'a Solution<2>, block: usize) -> &'a BodySolution<2> {
    let index = model.bodies.iter().position(|b| b.name == name(block));
    &solution.bodies[index.unwrap()]
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    let difference = (found - expected).abs();
    assert!(
        difference <= tolerance,
        "{what}: {found:e}, not {expected:e} ± {tolerance:e}"
    );
}

fn largest<'a>(points: impl IntoIterator<Item = &'a Point<2>>) -> f64 {
    let sizes = points.into_iter().flatten().map(|c| c.abs());
    sizes.fold(0.0, f64::max)
}

/// The uniaxial state of a patch: pressure q everywhere, stress −q along the turned y axis and nothing else, and the sum
/// of the forces.
fn check_patch(pile: Pile, what: &str) {
    let (model, solution) = (pile.model(), pile.solve());
    let q = PRESSURE * pile.stress_unit();
    for contact in &solution.contacts {
        for node in &contact.nodes {
            close(node.pressure, q, 1e-10 * q, what);
            assert_eq!(node.status, Status::Closed, "{what}");
        }
        let sign = if pile.swapped { -1.0 } else { 1.0 };
        let expected = pile.turned([0.0, sign * q * WIDTH * pile.length]);
        for (found, expected) in contact.resultant.iter().zip(expected) {
            close(*found, expected, 1e-12 * q * pile.length, what);
        }
        assert!(
            contact.imbalance <= 1e-12,
            "{what}: {:e}",
            contact.imbalance
        );
    }
    let axis = pile.turned([0.0, 1.0]);
    for (block, Elastic { poisson, .. }) in MATERIALS.iter().enumerate().take(pile.blocks) {
        let expected = [
            -q * axis[0] * axis[0],
            -q * axis[1] * axis[1],
            -q * poisson,
            -q * axis[0] * axis[1],
            0.0,
            0.0,
        ];
        for stress in &body(&model, &solution, block).stress {
            for (found, expected) in stress.iter().zip(expected) {
                close(*found, expected, 1e-10 * q, what);
            }
        }
    }
    let reaction = body(&model, &solution, 0).reaction;
    let expected = pile.turned([0.0, q * WIDTH * pile.length]);
    for (found, expected) in reaction.iter().zip(expected) {
        close(*found, expected, 1e-12 * q * pile.length * WIDTH, what);
    }
}

#[test]
fn two_blocks_transmit_a_uniform_pressure() {
    for cell in CellKind::of_dimension(2) {
        check_patch(Pile::of(cell, 2), cell.name());
    }
}

#[test]
fn a_floating_block_between_two_transmits_a_uniform_pressure() {
    for cell in CellKind::of_dimension(2) {
        check_patch(Pile::of(cell, 3), cell.name());
    }
}

#[test]
fn a_patch_knows_no_axes() {
    for cell in CellKind::of_dimension(2) {
        for blocks in [2, 3] {
            let pile = Pile {
                angle: 37.0,
                ..Pile::of(cell, blocks)
            };
            check_patch(pile, cell.name());
        }
    }
}

#[test]
fn a_patch_knows_no_units() {
    for cell in CellKind::of_dimension(2) {
        for (length, force) in [(1e6, 1.0), (1.0, 1e6), (1e-6, 1.0), (1.0, 1e-6), (1e6, 1e6)] {
            let pile = Pile {
                length,
                force,
                ..Pile::of(cell, 3)
            };
            check_patch(pile, &format!("{} {length:e} {force:e}", cell.name()));
        }
    }
}

#[test]
fn a_patch_does_not_care_which_side_carries_the_multipliers_nor_which_body_comes_first() {
    for cell in CellKind::of_dimension(2) {
        for (swapped, reversed) in [(true, false), (false, true), (true, true)] {
            let pile = Pile {
                swapped,
                reversed,
                ..Pile::of(cell, 3)
            };
            check_patch(pile, &format!("{} {swapped} {reversed}", cell.name()));
        }
    }
}

/// Pressures by the x of the unturned model, and displacements body by body turned back; both in units of the model.
type State = (Vec<(f64, f64)>, Vec<Vec<Point<2>>>);

fn state(pile: Pile) -> State {
    let (model, solution) = (pile.model(), pile.solve());
    let unit = pile.stress_unit();
    let nodes = &solution.contacts[0].nodes;
    let mut pressure: Vec<(f64, f64)> = nodes
        .iter()
        .map(|node| {
            let x = pile.turned_back(node.point)[0] / pile.length;
            (x, node.pressure / unit)
        })
        .collect();
    pressure.sort_by(|a, b| a.0.total_cmp(&b.0));
    let displacement = (0..pile.blocks)
        .map(|block| {
            let u = &body(&model, &solution, block).displacement;
            u.iter()
                .map(|u| pile.turned_back(*u).map(|c| c / pile.length))
                .collect()
        })
        .collect();
    (pressure, displacement)
}

#[test]
fn a_contact_that_opens_is_the_same_in_every_frame_unit_and_order() {
    for cell in CellKind::of_dimension(2) {
        let plain = Pile::opening(cell);
        let (pressure, displacement) = state(plain);
        let peak = pressure.iter().map(|p| p.1).fold(0.0, f64::max);
        let open = pressure.iter().filter(|p| p.1 == 0.0).count();
        assert!(
            open > 2 && open + 2 < pressure.len(),
            "{open} of {} are open",
            pressure.len()
        );
        let variants = [
            (
                "turned",
                Pile {
                    angle: 37.0,
                    ..plain
                },
            ),
            (
                "longer",
                Pile {
                    length: 1e6,
                    ..plain
                },
            ),
            (
                "stronger",
                Pile {
                    force: 1e6,
                    ..plain
                },
            ),
            (
                "reversed",
                Pile {
                    reversed: true,
                    ..plain
                },
            ),
            (
                "swapped",
                Pile {
                    swapped: true,
                    ..plain
                },
            ),
        ];
        for (what, variant) in variants {
            let (p, u) = state(variant);
            for (a, b) in pressure.iter().zip(&p) {
                close(b.0, a.0, 1e-12 * WIDTH, what);
                close(b.1, a.1, 1e-9 * peak, what);
                assert_eq!(
                    a.1 == 0.0,
                    b.1 == 0.0,
                    "{} {what}: the active set differs",
                    cell.name()
                );
            }
            for (a, b) in displacement.iter().flatten().zip(u.iter().flatten()) {
                for (a, b) in a.iter().zip(b) {
                    close(*b, *a, 1e-9 * largest(displacement.iter().flatten()), what);
                }
            }
        }
    }
}

#[test]
fn the_answer_is_homogeneous_in_load_and_gap() {
    for cell in CellKind::of_dimension(2) {
        let plain = Pile::opening(cell);
        // Without a crown the load alone is scaled, with one both are.
        for crown in [0.0, plain.crown] {
            let one = Pile { crown, ..plain };
            let before = one.solve();
            let factor = 7.3;
            let mut model = Pile {
                crown: factor * crown,
                ..one
            }
            .model();
            for load in &mut model.bodies[1].loads {
                if let Load::Traction { traction, .. } = load {
                    *traction = traction
                        .clone()
                        .map(|t| Field::constant(factor * t.as_constant().unwrap()));
                }
            }
            let after = model.solve().unwrap();
            let peak = before.contacts[0]
                .nodes
                .iter()
                .map(|n| n.pressure)
                .fold(0.0, f64::max);
            for (a, b) in before.contacts[0]
                .nodes
                .iter()
                .zip(&after.contacts[0].nodes)
            {
                assert_eq!(a.status, b.status, "{}", cell.name());
                close(b.pressure / factor, a.pressure, 1e-11 * peak, "pressure");
            }
            for (a, b) in before.bodies.iter().zip(&after.bodies) {
                let size = largest(&a.displacement);
                for (a, b) in a
                    .displacement
                    .iter()
                    .flatten()
                    .zip(b.displacement.iter().flatten())
                {
                    close(b / factor, *a, 1e-11 * size, "displacement");
                }
            }
        }
    }
}

/// Work of the load on the displacement of the loaded side: quadrature of the traction, element by element.
fn work_of_load(pile: &Pile, model: &Model<2>, solution: &Solution<2>) -> f64 {
    let top = model
        .bodies
        .iter()
        .position(|b| b.name == name(pile.blocks - 1))
        .unwrap();
    let (mesh, u) = (&model.bodies[top].mesh, &solution.bodies[top].displacement);
    let traction = pile.turned([0.0, -PRESSURE * pile.stress_unit()]);
    let mut work = 0.0;
    for &facet in mesh.side("loaded").unwrap() {
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        let along = |k: usize| dot(traction, u[nodes[k] as usize]);
        let length = dotyk::geometry::distance(
            mesh.points()[nodes[0] as usize],
            mesh.points()[nodes[1] as usize],
        );
        // Trapezium or Simpson: exact for the displacement of a straight facet.
        work += length
            * match nodes.len() {
                2 => (along(0) + along(1)) / 2.0,
                _ => (along(0) + along(1) + 4.0 * along(2)) / 6.0,
            };
    }
    work
}

#[test]
fn the_elastic_energy_is_half_the_work_of_loads_less_that_of_the_gaps() {
    for cell in CellKind::of_dimension(2) {
        for crown in [0.0, 1e-3] {
            let pile = Pile {
                crown,
                ..Pile::opening(cell)
            };
            let (model, solution) = (pile.model(), pile.solve());
            let stored: f64 = solution.bodies.iter().map(|b| b.strain_energy).sum();
            let gap = pile.gap();
            let closing: f64 = solution.contacts[0]
                .nodes
                .iter()
                .map(|node| node.pressure * node.weight * gap.at(node.point, 1.0))
                .sum();
            let expected = 0.5 * work_of_load(&pile, &model, &solution) - 0.5 * closing;
            close(stored, expected, 1e-11 * stored, cell.name());
            assert!(
                closing > 1e-4 * stored || crown == 0.0,
                "the gap does no work"
            );
            // Primal and dual energies agree to rounding, not only to the tolerance.
            let gap = solution.certificate.energy_gap.relative;
            assert!(gap <= 1e-11, "{}: energy gap {gap:e}", cell.name());
        }
    }
}

#[test]
fn contact_forces_balance_each_floating_body_in_force_and_moment() {
    for cell in CellKind::of_dimension(2) {
        let pile = Pile::opening(cell);
        let (model, solution) = (pile.model(), pile.solve());
        let contact = &solution.contacts[0];
        let load = PRESSURE * pile.loaded;
        close(contact.resultant[1], load, 1e-12 * load, cell.name());
        assert!(contact.imbalance <= 1e-12);
        // Moments about the origin of contact forces, load and the reactions of the rollers.
        let moment: f64 = contact
            .nodes
            .iter()
            .map(|n| n.pressure * n.weight * n.point[0])
            .sum();
        let top = body(&model, &solution, 1);
        let mesh = &model.bodies[1].mesh;
        let held: f64 = top
            .reactions
            .iter()
            .zip(mesh.points())
            .map(|(f, p)| p[0] * f[1] - p[1] * f[0])
            .sum();
        let of_load = -load * pile.loaded / 2.0;
        close(moment + held + of_load, 0.0, 1e-11 * load, cell.name());
    }
}

#[test]
fn a_rigid_motion_takes_no_force() {
    for cell in CellKind::of_dimension(2) {
        for angle in [0.0, 37.0] {
            let mut model = Pile {
                angle,
                ..Pile::of(cell, 1)
            }
            .model();
            model.bodies[0].supports.clear();
            let system = assemble(&model.bodies[0], model.analysis, 1.0).unwrap();
            assert_eq!(system.modes.len(), 3);
            // Against the forces of a motion of the same size that is not rigid.
            let n = system.load.len();
            let mut force = vec![0.0; n];
            let bent: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            system.stiffness.mul(&bent, &mut force);
            let scale = force.iter().fold(0.0_f64, |s, f| s.max(f.abs()));
            for mode in &system.modes {
                system.stiffness.mul(mode, &mut force);
                let rest = force.iter().fold(0.0_f64, |s, f| s.max(f.abs()));
                assert!(
                    rest <= 1e-13 * scale,
                    "{}: {rest:e} of {scale:e}",
                    cell.name()
                );
            }
        }
    }
}

#[test]
fn a_rigid_shift_of_the_supports_moves_everything_and_strains_nothing() {
    // The whole pile is carried along by its supports; the contact stays closed without a force.
    for cell in CellKind::of_dimension(2) {
        for force in [1.0, 1e9] {
            let pile = Pile {
                force,
                ..Pile::of(cell, 2)
            };
            let mut model = pile.model();
            model.bodies[1].loads.clear();
            for body in &mut model.bodies {
                body.supports = vec![Support {
                    place: Place::Side("left".to_string()),
                    components: [Some(Field::constant(0.25)), Some(Field::constant(-0.5))],
                    normal: None,
                    active: Default::default(),
                }];
            }
            let solution = model.solve().unwrap();
            for body in &solution.bodies {
                for u in &body.displacement {
                    close(u[0], 0.25, 1e-12, cell.name());
                    close(u[1], -0.5, 1e-12, cell.name());
                }
                let stiff = MATERIALS[0].young * force;
                assert!(
                    body.strain_energy <= 1e-18 * stiff,
                    "{:e}",
                    body.strain_energy
                );
            }
        }
    }
}

#[test]
fn a_contact_too_large_for_an_assembled_compliance_is_solved_through_the_factors() {
    let pile = Pile {
        cells: [DENSE_LIMIT + 100, 1],
        ..Pile::of(CellKind::Quad4, 2)
    };
    let solution = pile.solve();
    assert!(solution.contact_unknowns > DENSE_LIMIT);
    // Conjugate gradients end at the tolerance of the certificate, 1e-8, of cells two thousand times as high as wide.
    for node in &solution.contacts[0].nodes {
        close(node.pressure, PRESSURE, 1e-6 * PRESSURE, "pressure");
    }
}
