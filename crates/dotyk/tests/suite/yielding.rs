//! Metal that yields: uniform states by hand, tubes against a program of their own in one dimension, contact, and what must not
//! change the answer.

use dotyk::geometry::{Field, Point};
use dotyk::mesh::{CellKind, Cuboid, Diagonals, Mesh, Rectangle, Ring};
use dotyk::model::{
    Active, Along, Analysis, BodyId, Components, Elastic, Error, Gap, Law, Load, Model, Objection,
    Past, Plastic, Reading, SideRef, Solution, Strength,
};

const STEEL: Elastic = Elastic {
    young: 200.0,
    poisson: 0.3,
};

/// Makes a body yield.
fn yields<const D: usize>(model: &mut Model<D>, body: usize, yield_stress: f64, hardening: f64) {
    let material = &mut model.bodies[body].materials[0];
    material.strength = Some(Strength::VonMises { yield_stress });
    material.plastic = Some(Plastic { hardening });
}

fn close(found: f64, expected: f64, part: f64) {
    let off = (found - expected).abs();
    assert!(off < part * expected.abs().max(1e-3), "{found} {expected}");
}

/// A bar that yields at 1 and hardens by 10, drawn and pressed along itself by these stresses in turn: its stretches.
fn stretches(stresses: &[f64]) -> Vec<[f64; 2]> {
    let (mut plastic, mut gone) = (0.0, 0.0);
    let each = stresses.iter().map(|&stress: &f64| {
        let beyond = stress.abs() - (1.0 + 10.0 * gone);
        if beyond > 0.0 {
            gone += beyond / 10.0;
            plastic += beyond.copysign(stress) / 10.0;
        }
        [stress / 200.0 + plastic, gone]
    });
    each.collect()
}

#[test]
fn bars_follow_their_law_to_and_fro_in_space_and_around_an_axis() {
    let stresses = [0.9, 1.5, -1.2, 0.3, -1.9, 0.0];
    let expected = stretches(&stresses);
    let load = || Field::function("stress", move |_, t| stresses[t as usize - 1]);
    let cuboid = |cell| {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [1.0, 1.0, 2.0],
            cells: [1, 2, 2],
            cell,
        };
        cuboid.build().unwrap()
    };
    for cell in [
        CellKind::Hex8,
        CellKind::Hex20,
        CellKind::Hex27,
        CellKind::Tet4,
        CellKind::Tet10,
        CellKind::Prism6,
        CellKind::Prism15,
    ] {
        let mut model = Model::<3>::new();
        let body = model.body("bar", cuboid(cell), STEEL);
        yields(&mut model, 0, 1.0, 10.0);
        model.times = times(stresses.len());
        for side in ["left", "front", "bottom"] {
            model.roller(body, side, 0.0);
        }
        let side = "top".to_string();
        let traction = [Field::constant(0.0), Field::constant(0.0), load()];
        model.load(body, Load::Traction { side, traction });
        let solutions = model.solve_steps().unwrap();
        follows(
            &model,
            &solutions,
            &expected,
            [[1.0, 1.0, 2.0], [0.0; 3]],
            2.0,
        );
    }
    for cell in [CellKind::Quad8, CellKind::Tri6, CellKind::Quad4] {
        let mut model = Model::<2>::new();
        model.analysis = Analysis::Axisymmetric;
        let body = model.body("bar", rectangle(cell, [2, 3]), STEEL);
        yields(&mut model, 0, 1.0, 10.0);
        model.times = times(stresses.len());
        model.roller(body, "bottom", 0.0);
        let (side, traction) = ("top".to_string(), [Field::constant(0.0), load()]);
        model.load(body, Load::Traction { side, traction });
        let solutions = model.solve_steps().unwrap();
        follows(&model, &solutions, &expected, [[1.0, 2.0], [0.0; 2]], 2.0);
    }
}

fn rectangle(cell: CellKind, cells: [usize; 2]) -> Mesh<2> {
    let rectangle = Rectangle {
        from: [0.0, 0.0],
        to: [1.0, 2.0],
        cells,
        cell,
        diagonals: Diagonals::default(),
    };
    rectangle.build().unwrap()
}

/// A corner at the end of a bar moves as the bar is stretched, all of it has yielded where it has, and the certificate knows.
fn follows<const D: usize>(
    model: &Model<D>,
    solutions: &[Solution<D>],
    expected: &[[f64; 2]],
    [corner, _]: [Point<D>; 2],
    length: f64,
) {
    let points = model.bodies[0].mesh.points();
    let node = points.iter().position(|point| *point == corner).unwrap();
    for (solution, [stretch, gone]) in solutions.iter().zip(expected) {
        let body = &solution.bodies[0];
        close(body.displacement[node][D - 1], length * stretch, 1e-7);
        let own = body.yielding.as_ref().unwrap();
        for equivalent in &own.equivalent {
            close(*equivalent, *gone, 1e-7);
        }
        assert_eq!(own.extent > 0.0, *gone > 0.0);
        let figures = solution.certificate.yields.unwrap();
        assert!(figures.equilibrium.holds() && figures.flow.holds());
        assert!(figures.yield_violation.relative < 1e-13);
        let utilisation = &body.utilisation.as_ref().unwrap().nodal;
        assert!(utilisation.iter().all(|u| *u <= 1.0));
        assert_eq!(body.utilisation.as_ref().unwrap().overstressed, 0.0);
    }
}

/// A tube of radii a < b in plane strain under pressures on its inner side in turn, by linear elements along the radius with one
/// point each, and steps with the elastic stiffness: displacements of both sides.
fn tube([a, b]: [f64; 2], hardening: f64, pressures: &[f64]) -> Vec<[f64; 2]> {
    const N: usize = 1600;
    let Elastic { young, poisson } = STEEL;
    let mu = young / (2.0 * (1.0 + poisson));
    let bulk = young / (3.0 * (1.0 - 2.0 * poisson));
    let h = (b - a) / N as f64;
    let middle = |i: usize| a + (i as f64 + 0.5) * h;
    let (mut u, mut plastic, mut gone) = (vec![0.0; N + 1], vec![[0.0; 3]; N], vec![0.0; N]);
    // elastic stiffness, tridiagonal
    let (mut diagonal, mut beside) = (vec![0.0; N + 1], vec![0.0; N]);
    for i in 0..N {
        let (r, l) = (middle(i), bulk - 2.0 / 3.0 * mu);
        let rows = [[-1.0 / h, 0.5 / r], [1.0 / h, 0.5 / r]];
        let k = |p: usize, q: usize| {
            let (x, y): ([f64; 2], [f64; 2]) = (rows[p], rows[q]);
            let trace = (x[0] + x[1]) * (y[0] + y[1]);
            r * h * (l * trace + 2.0 * mu * (x[0] * y[0] + x[1] * y[1]))
        };
        diagonal[i] += k(0, 0);
        diagonal[i + 1] += k(1, 1);
        beside[i] = k(0, 1);
    }
    let mut answers = Vec::new();
    for &pressure in pressures {
        let (before, then) = (plastic.clone(), gone.clone());
        for _ in 0..20_000 {
            let mut left = vec![0.0; N + 1];
            left[0] = pressure * a;
            for i in 0..N {
                let r = middle(i);
                let strain = [(u[i + 1] - u[i]) / h, 0.5 * (u[i] + u[i + 1]) / r, 0.0];
                let elastic: [f64; 3] = std::array::from_fn(|c| strain[c] - before[i][c]);
                let mean = elastic.iter().sum::<f64>() / 3.0;
                let deviator = elastic.map(|e| 2.0 * mu * (e - mean));
                let size = (1.5 * deviator.iter().map(|s| s * s).sum::<f64>()).sqrt();
                let more = ((size - 1.0 - hardening * then[i]) / (3.0 * mu + hardening)).max(0.0);
                let along = deviator.map(|s| 1.5 * more * s / size.max(1e-300));
                plastic[i] = std::array::from_fn(|c| before[i][c] + along[c]);
                gone[i] = then[i] + more;
                let stress: [f64; 3] =
                    std::array::from_fn(|c| 3.0 * bulk * mean + deviator[c] - 2.0 * mu * along[c]);
                left[i] -= r * h * (-stress[0] / h + 0.5 * stress[1] / r);
                left[i + 1] -= r * h * (stress[0] / h + 0.5 * stress[1] / r);
            }
            if left.iter().all(|f| f.abs() < 1e-12) {
                break;
            }
            // Thomas's elimination
            let mut pivots = diagonal.clone();
            for i in 0..N {
                let factor = beside[i] / pivots[i];
                pivots[i + 1] -= factor * beside[i];
                left[i + 1] -= factor * left[i];
            }
            left[N] /= pivots[N];
            for i in (0..N).rev() {
                left[i] = (left[i] - beside[i] * left[i + 1]) / pivots[i];
            }
            u.iter_mut().zip(&left).for_each(|(u, more)| *u += more);
        }
        answers.push([u[0], u[N]]);
    }
    answers
}

/// These pressures one after the other, at t = 1, 2, ..
fn pressed(side: &str, pressures: &[f64]) -> Load<2> {
    let pressures = pressures.to_vec();
    Load::Pressure {
        side: side.to_string(),
        pressure: Field::function("p", move |_, t| pressures[t as usize - 1]),
    }
}

/// The times of so many steps.
fn times(steps: usize) -> Vec<f64> {
    (1..=steps).map(|t| t as f64).collect()
}

/// A ring of angles from this one in radians on, 90 degrees long.
fn ring([inner, outer]: [f64; 2], from: f64, cells: [usize; 2], cell: CellKind) -> Mesh<2> {
    let ring = Ring {
        center: [0.0, 0.0],
        inner,
        outer,
        angles: Some([from.to_degrees(), from.to_degrees() + 90.0]),
        cells,
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    };
    ring.build().unwrap()
}

/// A quarter of a tube of radii 1 and 2, pressed from inside by the time.
fn quarter(cell: CellKind, cells: usize, hardening: f64, pressures: &[f64]) -> Model<2> {
    let mut model = Model::<2>::new();
    let mesh = ring([1.0, 2.0], 0.0, [cells, cells], cell);
    let body = model.body("tube", mesh, STEEL);
    yields(&mut model, 0, 1.0, hardening);
    model.times = times(pressures.len());
    model.roller(body, "start", 0.0).roller(body, "end", 0.0);
    model.load(body, pressed("inner", pressures));
    for (name, x) in [("inner", 1.0), ("outer", 2.0)] {
        let at = Reading::At([x, 0.0]);
        model.probe(name, "tube.displacement.x", at).unwrap();
    }
    model
}

/// Displacements of both sides in each step.
fn moved(solutions: &[Solution<2>]) -> Vec<[f64; 2]> {
    let each = solutions.iter();
    each.map(|s| [s.probes[0].value, s.probes[1].value])
        .collect()
}

#[test]
fn tubes_yield_from_inside_as_a_program_in_one_dimension_says() {
    // beyond first yield, deep, back, and again farther
    let pressures = [0.42, 0.5, 0.65, 0.7, 0.1, 0.75];
    for hardening in [0.0, 20.0] {
        let expected = tube([1.0, 2.0], hardening, &pressures);
        for (cell, cells, part) in [
            (CellKind::Quad9, 16, 4e-4),
            (CellKind::Tri6, 12, 8e-4),
            (CellKind::Quad8, 24, 3e-4),
        ] {
            let solutions = quarter(cell, cells, hardening, &pressures)
                .solve_steps()
                .unwrap();
            // what is left behind an unloading is a difference of the displacements before it
            let most = expected.iter().fold(0.0f64, |most, own| most.max(own[0]));
            for (found, expected) in moved(&solutions).iter().zip(&expected) {
                for (found, expected) in found.iter().zip(expected) {
                    assert!((found - expected).abs() < part * most, "{found} {expected}");
                }
            }
        }
    }
}

/// Where the plastic zone of a tube ends at a pressure, by p = (2 ln(c/a) + 1 − c²/b²)/√3, and what cells, nodes and probes tell of it.
#[test]
fn cells_nodes_and_probes_tell_how_far_a_tube_has_yielded() {
    let pressures = [0.6, 0.65];
    let bears = |c: f64| (2.0 * c.ln() + 1.0 - c * c / 4.0) / 3.0f64.sqrt();
    let (mut low, mut end) = (1.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + end);
        match bears(middle) < pressures[1] {
            true => low = middle,
            false => end = middle,
        }
    }
    let mut model = quarter(CellKind::Quad9, 20, 0.0, &pressures);
    let mesh = model.bodies[0].mesh.clone();
    let middle = |cell: usize| {
        let nodes = &mesh.cell_nodes(0, cell)[..4];
        let sum = |d: usize| {
            nodes
                .iter()
                .map(|&n| mesh.points()[n as usize][d])
                .sum::<f64>()
        };
        [0.25 * sum(0), 0.25 * sum(1)]
    };
    let cells = mesh.cell_count();
    for cell in 0..cells {
        let at = Reading::At(middle(cell));
        let name = format!("cell{cell}");
        model.probe(&name, "tube.yielded", at).unwrap();
    }
    model
        .probe("corner", "tube.yielded", Reading::At([1.0, 0.0]))
        .unwrap();
    let solutions = model.solve_steps().unwrap();
    let solved = &solutions[1];
    let own = solved.bodies[0].yielding.as_ref().unwrap();
    assert_eq!(own.cells.len(), cells);
    let mut partly = 0;
    for (cell, share) in own.cells.iter().enumerate() {
        let [x, y] = middle(cell);
        // half a cell is 0.025 thick
        match x.hypot(y) - end {
            beyond if beyond > 0.05 => assert_eq!(*share, 0.0),
            beyond if beyond < -0.05 => assert_eq!(*share, 1.0),
            _ => partly += 1,
        }
        let ninths = 9.0 * share;
        assert!((ninths - ninths.round()).abs() < 1e-12, "{share}");
        let name = format!("cell{cell}");
        let probe = solved.probes.iter().find(|probe| probe.name == name);
        assert_eq!(probe.unwrap().value, *share);
    }
    assert!((20..=40).contains(&partly), "{partly}");
    let corner = solved.probes.iter().find(|probe| probe.name == "corner");
    assert_eq!(corner.unwrap().value, 1.0);
    assert!(own.share.iter().all(|share| (0.0..=1.0).contains(share)));
    let of_cells = |field: &dotyk::model::BodyField| field.on == dotyk::model::On::Cells;
    let fields = solved.bodies[0].fields();
    let fields: Vec<_> = fields.iter().filter(|field| of_cells(field)).collect();
    assert!(fields.len() == 1 && fields[0].name == "yielded" && fields[0].values == own.cells);
}

#[test]
fn a_tube_collapses_where_theory_says() {
    // 2/√3 ln(b/a)
    let limit = 2.0f64.ln() * 2.0 / 3.0f64.sqrt();
    let solved = |load: f64| quarter(CellKind::Quad9, 12, 0.0, &[load]).solve();
    assert!(solved(0.999 * limit).is_ok());
    let Err(Error::NotConverged { reason, .. }) = solved(1.003 * limit) else {
        panic!("a load above the limit is carried");
    };
    let Objection::Yields { carried, .. } = *reason else {
        panic!("{reason}");
    };
    let (told, carried) = (reason.to_string(), carried.unwrap());
    // the part is told to a thousandth
    assert!(
        told.contains("of the step") && (carried * 1.003 - 1.0).abs() < 2e-3,
        "{told}"
    );
}

#[test]
fn cells_that_cannot_flow_bear_no_load() {
    let limit = 2.0f64.ln() * 2.0 / 3.0f64.sqrt();
    for (cell, count, factor) in [
        (CellKind::Quad8, 4, 1.94),
        (CellKind::Quad9, 5, 1.02),
        (CellKind::Quad9, 5, 2.4),
    ] {
        let mut model = quarter(cell, count, 0.0, &[factor * limit]);
        // what moves beside it does not make the load a prescribed motion
        let rectangle = Rectangle {
            from: [5.0, 0.0],
            to: [6.0, 1.0],
            cells: [1, 1],
            cell: CellKind::Quad4,
            diagonals: Diagonals::default(),
        };
        let beside = model.body("beside", rectangle.build().unwrap(), STEEL);
        model.roller(beside, "left", 0.0);
        model.roller(beside, "bottom", 0.01);
        let Err(Error::NotConverged { reason, .. }) = model.solve() else {
            panic!("{cell:?}: {factor} of the limit is carried");
        };
        let Objection::Yields { carried, .. } = *reason else {
            panic!("{reason}");
        };
        let carried = factor * carried.unwrap();
        // what these meshes miss of the limit
        assert!((carried - 1.0).abs() < 0.012, "{cell:?} {count}: {carried}");
    }
    // triangles whose problem has an answer at 1.74 of the limit, by mean stresses that swing within them
    let ratio: f64 = 2.1831193686154435;
    let pressures = [0.2969232124547668, 1.5644199424345688];
    let material = Elastic {
        young: 34.66086538326763,
        poisson: 0.47944344912037884,
    };
    let mut model = Model::<2>::new();
    let mesh = ring([1.0, ratio], 0.0, [4, 4], CellKind::Tri6);
    let body = model.body("tube", mesh, material);
    yields(&mut model, 0, 1.0, 0.0);
    model.times = times(2);
    model.roller(body, "start", 0.0).roller(body, "end", 0.0);
    model.load(body, pressed("inner", &pressures));
    let Err(Error::NotConverged { reason, .. }) = model.solve_steps() else {
        panic!("triangles bear 1.74 of the limit");
    };
    let told = reason.to_string();
    assert!(told.contains("only cells that cannot flow"), "{told}");
    let Objection::Yields {
        carried: Some(share),
        ..
    } = *reason
    else {
        panic!("{told}");
    };
    let carried = pressures[0] + share * (pressures[1] - pressures[0]);
    let limit = ratio.ln() * 2.0 / 3.0f64.sqrt();
    assert!((carried / limit - 1.0).abs() < 0.012, "{carried}");
}

#[test]
fn the_part_of_a_step_that_is_borne_counts_from_what_acted_before() {
    // half of the yield stress in the first step, and as much again that comes at once in the second
    let limit = 2.0f64.ln() * 2.0 / 3.0f64.sqrt();
    let mut model = quarter(CellKind::Quad9, 12, 0.0, &[0.5, 0.5]);
    let from = Active {
        from: 2.0,
        until: f64::INFINITY,
    };
    let more = Load::Pressure {
        side: "inner".to_string(),
        pressure: Field::constant(0.5),
    };
    model.load(BodyId(0), more.during(from));
    let Err(Error::NotConverged { reason, .. }) = model.solve_steps() else {
        panic!("a load above the limit is carried");
    };
    let Objection::Yields { carried, .. } = *reason else {
        panic!("{reason}");
    };
    let off = carried.unwrap() - (limit - 0.5) / 0.5;
    assert!(off.abs() < 3e-3, "{reason}");
}

/// A block, pressed on the middle half of its top: coarse cells, in which an elastic block yields first while one with the more
/// compliant cells of a flowing body does not. It hardens, so every load has an answer, and more of it moves the block farther.
#[test]
fn every_load_just_above_first_yield_has_an_answer() {
    let pressed = |cell: CellKind, load: f64| {
        let rectangle = Rectangle {
            from: [0.0, 0.0],
            to: [4.0, 2.0],
            cells: [4, 2],
            cell,
            diagonals: Diagonals::default(),
        };
        let mesh = rectangle.build().unwrap();
        let mesh = mesh.with_patch("pad", "top", [1.0, 2.0], [3.0, 2.0]);
        let mut model = Model::<2>::new();
        let elastic = Elastic {
            young: 100.0,
            poisson: 0.3,
        };
        let body = model.body("block", mesh.unwrap(), elastic);
        yields(&mut model, 0, 1.0, 2.0);
        model.fix(body, "bottom", [Some(0.0); 2]);
        model.load(
            body,
            Load::Pressure {
                side: "pad".to_string(),
                pressure: Field::constant(load),
            },
        );
        let side = "pad".to_string();
        let along = Along::Side(SideRef { body, side });
        let pad = model.probe("pad", "block.displacement.y", Reading::Mean);
        pad.unwrap().along = Some(along);
        let solution = model.solve().unwrap();
        let extent = solution.bodies[0].yielding.as_ref().unwrap().extent;
        (solution.probes[0].value / load, extent)
    };
    for cell in [CellKind::Quad8, CellKind::Quad9] {
        let loads: Vec<f64> = (0..30).map(|k| 1.1 + 0.01 * f64::from(k)).collect();
        let found: Vec<_> = loads.iter().map(|&load| pressed(cell, load)).collect();
        assert!(found[0].1 == 0.0 && found[29].1 > 0.0);
        // by the mean of the pad, on which the load works: the compliance grows, by half a percent where the cells change
        for (pair, load) in found.windows(2).zip(&loads) {
            let step = pair[1].0 / pair[0].0 - 1.0;
            assert!((-1e-9..0.02).contains(&step), "{load} {step}");
        }
    }
}

/// Mean stress of a body without supports that bear anything: ∫σ dV = ∮ t⊗x dA.
#[test]
fn integrals_of_the_stress_of_a_body_that_yields_are_those_of_its_loads() {
    for (cell, cells) in [
        (CellKind::Quad8, [12, 8]),
        (CellKind::Quad9, [12, 8]),
        (CellKind::Tri6, [12, 8]),
    ] {
        let rectangle = Rectangle {
            from: [0.0, 0.0],
            to: [3.0, 2.0],
            cells,
            cell,
            diagonals: Diagonals::default(),
        };
        let mesh = rectangle.build().unwrap();
        let mesh = mesh.with_patch("above", "top", [1.0, 2.0], [2.0, 2.0]);
        let mesh = mesh
            .unwrap()
            .with_patch("below", "bottom", [1.0, 0.0], [2.0, 0.0]);
        let mut model = Model::<2>::new();
        let body = model.body("block", mesh.unwrap(), STEEL);
        yields(&mut model, 0, 1.0, 1.0);
        for (side, traction) in [
            ("above", [0.2, -1.6]),
            ("below", [-0.2, 1.6]),
            ("left", [-0.3, -0.2 / 3.0]),
            ("right", [0.3, 0.2 / 3.0]),
        ] {
            model.load(
                body,
                Load::Traction {
                    side: side.to_string(),
                    traction: traction.map(Field::constant),
                },
            );
        }
        // what holds it bears nothing
        model.pin(body, [0.0, 0.0], [Some(0.0), Some(0.0)]);
        model.pin(body, [3.0, 0.0], [None, Some(0.0)]);
        // tₓ x on the patches cancels, on the right 0.3 · 3 · 2; t_y y: -1.6 · 2; tₓ y: 0.2 · 2
        let expected = [("xx", 1.8), ("yy", -3.2), ("xy", 0.4)];
        for (component, _) in expected {
            let quantity = format!("block.stress.{component}");
            model
                .probe(component, &quantity, Reading::Integral)
                .unwrap();
        }
        let solution = model.solve().unwrap();
        assert!(solution.bodies[0].yielding.as_ref().unwrap().extent > 0.5);
        for (probe, (component, expected)) in solution.probes.iter().zip(expected) {
            let off = (probe.value - expected).abs();
            assert!(
                off < 1e-6,
                "{cell:?} {component}: {} {expected}",
                probe.value
            );
        }
    }
}

#[test]
fn what_does_not_yield_is_elastic_to_the_bit() {
    let pressures = [0.2, 0.4];
    let mut elastic = quarter(CellKind::Quad8, 6, 0.0, &pressures);
    elastic.bodies[0].materials[0].plastic = None;
    let plastic = quarter(CellKind::Quad8, 6, 0.0, &pressures)
        .solve_steps()
        .unwrap();
    for (a, b) in elastic.solve_steps().unwrap().iter().zip(&plastic) {
        assert_eq!(a.bodies[0].displacement, b.bodies[0].displacement);
        assert_eq!(a.bodies[0].stress, b.bodies[0].stress);
        assert_eq!(a.probes, b.probes);
        assert_eq!(
            (
                a.certificate.yields,
                b.bodies[0].yielding.as_ref().unwrap().extent
            ),
            (None, 0.0)
        );
        assert!(b.certificate.yields.is_some());
    }
}

#[test]
fn a_run_goes_on_behind_steps_that_yielded() {
    let pressures = [0.5, 0.7, 0.2, 0.76];
    let model = quarter(CellKind::Quad9, 8, 5.0, &pressures);
    let whole = model.solve_steps().unwrap();
    let mut past: Vec<Past<2>> = whole[..3].iter().map(Past::from).collect();
    let again = model.solve_steps_after(&past, &mut |_| {}).unwrap();
    assert_eq!(again.len(), 4);
    for (a, b) in moved(&whole).iter().zip(moved(&again)) {
        close(b[0], a[0], 1e-7);
    }
    // the same without the state, from forces alone
    past.iter_mut()
        .for_each(|step| step.bodies[0].yielded = None);
    let again = model.solve_steps_after(&past, &mut |_| {}).unwrap();
    close(moved(&again)[3][0], moved(&whole)[3][0], 1e-7);
    // and that of another mesh is refused
    past[1].bodies[0].yielded = Some(vec![[0.0; 8]; 5]);
    let error = model.solve_steps_after(&past, &mut |_| {}).unwrap_err();
    assert!(error.to_string().contains("another mesh"), "{error}");
    // the other figures of the step are looked at, whatever the state says
    let mut past: Vec<Past<2>> = whole[..3].iter().map(Past::from).collect();
    past[1].bodies[0].max_displacement *= 1.01;
    assert!(model.solve_steps_after(&past, &mut |_| {}).is_err());
}

#[test]
fn a_turned_tube_of_two_tied_halves_yields_the_same() {
    let pressures = [0.6, 0.72];
    let whole = moved(
        &quarter(CellKind::Quad9, 8, 10.0, &pressures)
            .solve_steps()
            .unwrap(),
    );
    let mut model = Model::<2>::new();
    let angle = 0.4f64;
    for (name, radii, cells) in [
        ("inside", [1.0, 1.5], [8, 9]),
        ("outside", [1.5, 2.0], [7, 8]),
    ] {
        let mesh = ring(radii, angle, cells, CellKind::Quad9);
        let body = model.body(name, mesh, STEEL);
        yields(&mut model, body.0, 1.0, 10.0);
        model.roller(body, "start", 0.0).roller(body, "end", 0.0);
    }
    let [inside, outside] = [0, 1].map(BodyId);
    model.contact((inside, "outer"), (outside, "inner")).law = Law::Tied;
    model.times = times(pressures.len());
    model.load(inside, pressed("inner", &pressures));
    let (sin, cos) = angle.sin_cos();
    for (name, r) in [("inside", 1.0), ("outside", 2.0)] {
        for axis in ["x", "y"] {
            let quantity = format!("{name}.displacement.{axis}");
            let at = Reading::At([r * cos, r * sin]);
            model.probe(&quantity, &quantity, at).unwrap();
        }
    }
    for (solution, expected) in model.solve_steps().unwrap().iter().zip(&whole) {
        let u: Vec<f64> = solution.probes.iter().map(|probe| probe.value).collect();
        // two meshes of (h/r)² = 1/64, which do not match
        close(u[0].hypot(u[1]), expected[0], 2e-3);
        close(u[2].hypot(u[3]), expected[1], 2e-3);
    }
}

#[test]
fn a_hub_that_yields_presses_as_its_program_says() {
    // a rigid shaft that grows in the tube: pressure and displacement of the tube go together as under that pressure
    let mut model = quarter(CellKind::Quad9, 16, 0.0, &[0.0; 3]);
    model.bodies[0].loads.clear();
    let stiff = Elastic {
        young: 400.0,
        poisson: 0.3,
    };
    let mesh = ring([0.5, 1.0], 0.0, [14, 3], CellKind::Quad9);
    let shaft = model.body("shaft", mesh, stiff);
    model.roller(shaft, "start", 0.0).roller(shaft, "end", 0.0);
    let hub = BodyId(0);
    let contact = model.contact((shaft, "outer"), (hub, "inner"));
    // the shaft is larger by up to 0.01
    contact.gap = Some(Gap::Given(Field::function("fit", |_, t| -0.0033 * t)));
    let name = contact.name.clone();
    model
        .probe("pressure", &format!("{name}.pressure"), Reading::Mean)
        .unwrap();
    let solutions = model.solve_steps().unwrap();
    let pressures: Vec<f64> = solutions.iter().map(|s| s.probes[2].value).collect();
    assert!(pressures[0] < 0.43 && pressures[2] > 0.6, "{pressures:?}");
    let expected = tube([1.0, 2.0], 0.0, &pressures);
    for (found, expected) in moved(&solutions).iter().zip(&expected) {
        close(found[0], expected[0], 1e-3);
        close(found[1], expected[1], 1e-3);
    }
}

#[test]
fn linear_cells_that_yield_and_what_has_no_law_are_told() {
    let solution = quarter(CellKind::Quad4, 6, 0.0, &[0.6]).solve().unwrap();
    let told = |words: &str| {
        solution
            .warnings
            .iter()
            .any(|warning| warning.contains(words))
    };
    assert!(
        told("yields in linear cells (quad4)"),
        "{:?}",
        solution.warnings
    );
    let refused = |change: fn(&mut Model<2>)| {
        let mut model = quarter(CellKind::Quad8, 2, 0.0, &[0.6]);
        change(&mut model);
        model.solve().unwrap_err().to_string()
    };
    let flat = refused(|model| model.analysis = Analysis::PlaneStress);
    assert!(flat.contains("not supported yet in plane stress"), "{flat}");
    let lawless = refused(|model| model.bodies[0].materials[0].strength = None);
    assert!(
        lawless.contains("add `strength = { yield = .. }`"),
        "{lawless}"
    );
    let soft = refused(|model| {
        model.bodies[0].materials[0].plastic = Some(Plastic { hardening: -1.0 });
    });
    assert!(soft.contains("hardening = -1"), "{soft}");
    let error = quarter(CellKind::Quad8, 2, 0.0, &[0.6])
        .dual(0.6)
        .err()
        .unwrap();
    assert!(error.to_string().contains("dual problem"), "{error}");
}

#[test]
fn an_initial_stress_beyond_the_yield_stress_is_refused() {
    let ground = |stress: f64| {
        let mut model = Model::<2>::new();
        let body = model.body("ground", rectangle(CellKind::Quad8, [4, 2]), STEEL);
        yields(&mut model, body.0, 1.0, 0.0);
        let component = |c| Field::constant(if c == 1 { stress } else { 0.0 });
        model.bodies[body.0].initial.stress = Some(Components(std::array::from_fn(component)));
        model.fix(body, "bottom", [Some(0.0), Some(0.0)]);
        model.solve_steps()
    };
    assert!(ground(-0.999).is_ok());
    let error = ground(-1.5).unwrap_err().to_string();
    for words in [
        "ground",
        "outside the yield surface",
        "1.5000e0",
        "5.0000e-1 beyond",
    ] {
        assert!(error.contains(words), "{error}");
    }
}
