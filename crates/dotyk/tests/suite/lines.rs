//! Probes along lines and sides: closed forms, rates, turned bodies, and the contact read the same way twice.

use dotyk::analytic::lame::ThickRing;
use dotyk::analytic::{Material, Plane};
use dotyk::geometry::distance;
use dotyk::model::{LinePoint, ProbeError, ProbeValue};
use dotyk::prelude::*;
use proptest::prelude::*;
use std::f64::consts::PI;

const STEEL: Elastic = Elastic {
    young: 210e3,
    poisson: 0.3,
};

fn ring(angles: Option<[f64; 2]>, cells: [usize; 2], cell: CellKind) -> Mesh<2> {
    let ring = Ring {
        center: [0.0; 2],
        inner: 1.0,
        outer: 2.0,
        angles,
        cells,
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    ring.build().unwrap()
}

fn line(from: Point<2>, to: Point<2>, points: usize) -> Along<2> {
    Along::Line { from, to, points }
}

fn side(body: BodyId, side: &str) -> Along<2> {
    let side = side.to_string();
    Along::Side(SideRef { body, side })
}

fn ask(model: &mut Model<2>, quantity: &str, along: Along<2>, reading: Reading<2>) {
    model.probe(quantity, quantity, reading).unwrap().along = Some(along);
}

/// The values of probes along lines.
fn lines(model: &Model<2>) -> Vec<Vec<LinePoint>> {
    let probes = model.solve().unwrap().probes;
    probes.into_iter().map(|probe| probe.line).collect()
}

/// A quarter of a ring under a pressure inside, read along a radius, along its loaded side, and the force there.
fn pressed(n: usize, cell: CellKind) -> (Model<2>, Vec<ProbeValue>) {
    let mut model = Model::<2>::new();
    let mesh = ring(Some([0.0, 90.0]), [2 * n, n], cell);
    let body = model.body("ring", mesh, STEEL);
    model
        .fix(body, "start", [None, Some(0.0)])
        .fix(body, "end", [Some(0.0), None])
        .press(body, "inner", 3.0);
    let turned = |r: f64| [r * 0.8, r * 0.6];
    let radius = line(turned(1.0), turned(2.0), 101);
    ask(&mut model, "ring.stress.hoop", radius, Reading::Whole);
    for reading in [Reading::Whole, Reading::Integral] {
        ask(
            &mut model,
            "ring.stress.normal",
            side(body, "inner"),
            reading,
        );
    }
    let probes = model.solve().unwrap().probes;
    (model, probes)
}

#[test]
fn stresses_of_a_ring_along_its_radius_and_its_hole_converge_to_lame() {
    let exact = ThickRing {
        inner: 1.0,
        outer: 2.0,
        material: Material {
            young: STEEL.young,
            poisson: STEEL.poisson,
        },
        plane: Plane::Strain,
        inner_pressure: 3.0,
        outer_pressure: 0.0,
    };
    // recovered at the nodes of the boundary stresses are of the first order with linear cells
    let (linear, quadratic) = ([1.2, 0.9, 0.9], [1.2, 1.8, 1.8]);
    for (cell, rates, limit) in [
        (CellKind::Tri3, linear, 0.5),
        (CellKind::Quad4, linear, 0.5),
        (CellKind::Tri6, quadratic, 0.01),
        (CellKind::Quad8, quadratic, 0.01),
        (CellKind::Quad9, quadratic, 0.01),
    ] {
        let errors = [8, 16].map(|n| {
            let (_, probes) = pressed(n, cell);
            let (radius, wall, force) = (&probes[0].line, &probes[1].line, probes[2].value);
            assert_eq!((radius.len(), probes[0].value.is_nan()), (101, true));
            let squares = radius.iter().map(|place| {
                let r = place.point[0].hypot(place.point[1]);
                assert!((place.s - (r - 1.0)).abs() < 1e-12);
                (place.value - exact.stress(r)[1]).powi(2)
            });
            let radial = (squares.sum::<f64>() / 101.0).sqrt();
            let off = wall.iter().map(|place| (place.value + 3.0).abs());
            let arc = wall.last().unwrap().s;
            assert!(arc < 0.5 * PI && arc > 0.499 * PI);
            [radial, off.fold(0.0, f64::max), (force / arc + 3.0).abs()]
        });
        for ((rate, coarse), fine) in rates.iter().zip(errors[0]).zip(errors[1]) {
            let found = (coarse / fine).log2();
            assert!(found > *rate, "{cell:?} {found} {errors:?}");
            assert!(fine < limit, "{cell:?} {errors:?}");
        }
    }
}

/// A part of a ring, all of whose boundary moves as `strain` says: its stress is uniform.
fn strained(angles: [f64; 2], strain: [[f64; 2]; 2], cell: CellKind) -> (Model<2>, BodyId) {
    let mut model = Model::<2>::new();
    let body = model.body("part", ring(Some(angles), [8, 2], cell), STEEL);
    for side in ["inner", "outer", "start", "end"] {
        let moved = strain.map(|row| {
            let along = move |x: [f64; 3], _: f64| row[0] * x[0] + row[1] * x[1];
            Some(Field::function("strain", along))
        });
        model.bodies[0].supports.push(Support {
            place: Place::Side(side.to_string()),
            components: moved,
            normal: None,
            active: Default::default(),
        });
    }
    (model, body)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// A turned body under a turned strain has the same stresses normal to its sides, in the same order; they are n·σ·n
    /// with the radius as normal, except where the side ends.
    #[test]
    fn normal_stresses_do_not_see_how_the_body_is_turned(
        start in -180.0..180.0_f64,
        span in 40.0..200.0_f64,
        strain in [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64],
        kind in 0..5_usize,
    ) {
        let cell = [CellKind::Tri3, CellKind::Quad4, CellKind::Tri6, CellKind::Quad8, CellKind::Quad9][kind];
        let [xx, yy, xy] = strain.map(|e| 1e-3 * e);
        let (s, c) = start.to_radians().sin_cos();
        // Q ε Qᵀ
        let turned = [
            [c * c * xx + s * s * yy - 2.0 * s * c * xy, s * c * (xx - yy) + (c * c - s * s) * xy],
            [s * c * (xx - yy) + (c * c - s * s) * xy, s * s * xx + c * c * yy + 2.0 * s * c * xy],
        ];
        let values = |angles: [f64; 2], strain: [[f64; 2]; 2]| {
            let (mut model, body) = strained(angles, strain, cell);
            ask(&mut model, "part.stress.normal", side(body, "outer"), Reading::Whole);
            lines(&model).remove(0)
        };
        let straight = values([0.0, span], [[xx, xy], [xy, yy]]);
        let other = values([start, start + span], turned);
        prop_assert_eq!(straight.len(), other.len());
        let size = STEEL.young * 1e-3;
        // Lamé's constants
        let mu = STEEL.young / (2.0 * (1.0 + STEEL.poisson));
        let lambda = 2.0 * mu * STEEL.poisson / (1.0 - 2.0 * STEEL.poisson);
        let ends = [0, straight.len() - 1];
        for (k, (a, b)) in straight.iter().zip(&other).enumerate() {
            prop_assert!((a.value - b.value).abs() < 1e-9 * size, "{a:?} {b:?}");
            prop_assert!((a.s - b.s).abs() < 1e-12);
            let n = [a.point[0] / 2.0, a.point[1] / 2.0];
            let strained = xx * n[0] * n[0] + yy * n[1] * n[1] + 2.0 * xy * n[0] * n[1];
            let exact = lambda * (xx + yy) + 2.0 * mu * strained;
            if !ends.contains(&k) {
                prop_assert!((a.value - exact).abs() < 1e-9 * size, "{a:?} {exact}");
            }
        }
    }
}

#[test]
fn a_closed_side_ends_where_it_begins_and_its_integral_is_that_of_the_whole() {
    for (cell, order) in [(CellKind::Quad4, 1.0), (CellKind::Quad9, 2.0)] {
        let mut model = Model::<2>::new();
        let body = model.body("ring", ring(None, [24, 3], cell), STEEL);
        model.bodies[0].thickness = 0.7;
        // pressed all around it is under the same pressure everywhere
        model
            .press(body, "inner", 3.0)
            .press(body, "outer", 3.0)
            .pin(body, [1.0, 0.0], [Some(0.0), Some(0.0)])
            .pin(body, [-1.0, 0.0], [None, Some(0.0)]);
        for reading in [Reading::Whole, Reading::Mean, Reading::Integral] {
            ask(
                &mut model,
                "ring.stress.normal",
                side(body, "inner"),
                reading,
            );
        }
        let probes = model.solve().unwrap().probes;
        let line = &probes[0].line;
        assert_eq!(line.len() as f64, 24.0 * order + 1.0);
        assert_eq!(
            (line[0].point, line[0].s),
            (line[line.len() - 1].point, 0.0)
        );
        assert!(line.iter().skip(1).all(|place| !place.starts) && line[0].starts);
        let steps = line.windows(2).map(|pair| {
            let [a, b] = [pair[0], pair[1]].map(|place| [place.point[0], place.point[1]]);
            (distance(a, b), pair[1].s - pair[0].s)
        });
        for (way, step) in steps {
            assert!((way - step).abs() < 1e-12, "{way} {step}");
        }
        // chords of a polygon, or parabolas through three nodes: by Simpson's rule with so many points that it is exact
        let perimeter = match cell {
            CellKind::Quad4 => 24.0 * 2.0 * (PI / 24.0).sin(),
            _ => 24.0 * parabola(PI / 24.0),
        };
        for place in line {
            assert!((place.value + 3.0).abs() < 1e-8, "{place:?}");
        }
        assert!((probes[1].value + 3.0).abs() < 1e-8);
        let force = -3.0 * 0.7 * perimeter;
        assert!(
            (probes[2].value / force - 1.0).abs() < 1e-8,
            "{force} {probes:?}"
        );
    }
}

/// Length of the parabola through the ends and the middle of an arc of the unit circle of twice this angle.
fn parabola(half: f64) -> f64 {
    // x = half chord · t, y = sagitta · t²
    let (chord, sagitta) = (half.sin(), 1.0 - half.cos());
    let slope = 2.0 * sagitta / chord;
    chord * ((1.0 + slope * slope).sqrt() + slope.asinh() / slope)
}

#[test]
fn the_area_of_a_body_of_revolution_is_that_of_the_full_turn() {
    let rectangle = Rectangle {
        from: [1.0, 0.0],
        to: [3.0, 5.0],
        cells: [4, 5],
        cell: CellKind::Quad8,
        diagonals: Diagonals::Checkerboard,
    };
    let mut model = Model::<2>::new();
    model.analysis = Analysis::Axisymmetric;
    let body = model.body("tube", rectangle.build().unwrap(), STEEL);
    for side in ["left", "right", "top"] {
        model.press(body, side, 2.0);
    }
    model.roller(body, "bottom", 0.0);
    for (name, area) in [("right", 2.0 * PI * 3.0 * 5.0), ("bottom", PI * 8.0)] {
        ask(
            &mut model,
            "tube.stress.normal",
            side(body, name),
            Reading::Integral,
        );
        let force = model.solve().unwrap().probes.pop().unwrap().value;
        assert!((force / (-2.0 * area) - 1.0).abs() < 1e-9, "{name} {force}");
    }
}

/// A block pressed onto a wider one, whose nodes do not match.
fn blocks() -> (Model<2>, [BodyId; 2]) {
    let block = |from: Point<2>, to: Point<2>, cells| {
        let rectangle = Rectangle {
            from,
            to,
            cells,
            cell: CellKind::Quad8,
            diagonals: Diagonals::Checkerboard,
        };
        rectangle.build().unwrap()
    };
    let mut model = Model::<2>::new();
    let lower = model.body("lower", block([0.0, 0.0], [4.0, 1.0], [13, 4]), STEEL);
    let mesh = block([1.0, 1.0], [3.0, 2.0], [9, 4]);
    let mesh = mesh
        .with_patch("half", "bottom", [1.9, 1.0], [3.0, 1.0])
        .unwrap();
    let upper = model.body("upper", mesh, STEEL);
    model
        .fix(lower, "bottom", [Some(0.0), Some(0.0)])
        .fix(upper, "left", [Some(0.0), None])
        .press(upper, "top", 2.0)
        .contact((upper, "bottom"), (lower, "top"))
        .name = "sole".to_string();
    (model, [lower, upper])
}

#[test]
fn a_contact_along_its_side_has_the_values_of_its_nodes() {
    let (mut model, [lower, upper]) = blocks();
    let halved = line([1.0, 1.0], [3.0, 1.0], 19);
    for along in [side(upper, "bottom"), side(upper, "half"), halved] {
        ask(&mut model, "sole.pressure", along, Reading::Whole);
    }
    let solution = model.solve().unwrap();
    let contact = &solution.contacts[0];
    let [whole, half, between] = [0, 1, 2].map(|k| &solution.probes[k].line);
    assert_eq!((whole.len(), half.len(), between.len()), (19, 9, 19));
    for (place, node) in whole.iter().zip(&contact.nodes) {
        assert_eq!(place.point[..2], node.point);
        assert_eq!(place.value, node.pressure);
    }
    for (place, node) in half.iter().zip(&contact.nodes[10..]) {
        assert_eq!(place.value, node.pressure);
        assert!((place.s - (node.point[0] - half[0].point[0])).abs() < 1e-12);
    }
    // its points are the nodes
    for (place, other) in between.iter().zip(whole) {
        assert!(
            (place.value / other.value - 1.0).abs() < 1e-9,
            "{place:?} {other:?}"
        );
    }
    for (along, why) in [
        (side(lower, "top"), "lower.top is no part of upper.bottom"),
        (side(upper, "top"), "upper.top is no part of upper.bottom"),
        (
            line([0.5, 1.0], [3.0, 1.0], 4),
            "does not lie on the nonmortar side",
        ),
    ] {
        let (mut model, _) = blocks();
        ask(&mut model, "sole.pressure", along, Reading::Whole);
        let error = model.solve().unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
        assert!(model.check().errors[0].contains(why));
    }
}

#[test]
fn a_line_beside_the_body_and_a_side_of_another_are_refused() {
    let (model, [lower, upper]) = blocks();
    let read = |quantity: &str, along: Option<Along<2>>, reading: Reading<2>| {
        let mut model = model.clone();
        model.probe("here", quantity, reading).unwrap().along = along;
        // before anything is solved
        let found = model.check().errors;
        match model.solve().unwrap_err() {
            error @ Error::Probe { .. } if found != [error.to_string()] => panic!("{found:?}"),
            Error::Probe { source, .. } => source,
            other => panic!("{other}"),
        }
    };
    let refused = |quantity: &str, along| read(quantity, along, Reading::Whole);
    let (from, to) = ([0.0, 1.5], [0.9, 1.5]);
    let found = refused("upper.stress.xx", Some(line(from, to, 5)));
    assert_eq!(found, ProbeError::LineOutside { from, to });
    let found = refused("upper.stress.xx", Some(side(lower, "top")));
    assert!(matches!(found, ProbeError::OtherBody { .. }), "{found}");
    let found = refused("upper.stress.normal", Some(line(from, [1.5; 2], 5)));
    assert_eq!(found, ProbeError::NoSide);
    let found = refused("upper.stress.xx", Some(side(upper, "bottm")));
    assert!(matches!(found, ProbeError::Side(_)), "{found}");
    assert_eq!(refused("upper.stress.xx", None), ProbeError::NoPlace);
    assert_eq!(refused("sole.pressure", None), ProbeError::NoPlace);
    for reading in [Reading::Mean, Reading::Integral] {
        let inside = Some(line([0.5, 1.5], [1.5, 1.5], 5));
        let found = read("upper.stress.xx", inside, reading);
        assert_eq!(found, ProbeError::LineHasNoArea);
    }
}

#[test]
fn a_side_with_corners_has_two_normals_there_and_one_stress() {
    let mut mesh = ring(Some([0.0, 90.0]), [6, 3], CellKind::Quad4);
    let all = mesh
        .join_sides(&["inner", "outer", "start", "end"])
        .unwrap();
    let mut model = Model::<2>::new();
    let body = model.body("part", mesh, STEEL);
    model
        .pull(body, "outer", [1.0, 0.0])
        .fix(body, "inner", [Some(0.0), Some(0.0)]);
    for quantity in ["part.stress.xx", "part.stress.normal"] {
        ask(&mut model, quantity, side(body, &all), Reading::Whole);
    }
    let solution = model.solve().unwrap();
    let [stress, normal] = [0, 1].map(|k| &solution.probes[k].line);
    // closed: the first node comes once more; four corners come twice, but that at the start
    let starts = |line: &[LinePoint]| line.iter().filter(|place| place.starts).count();
    assert_eq!((stress.len(), starts(stress)), (19, 1));
    assert_eq!((normal.len(), starts(normal)), (22, 4));
    // each piece has the normals of its own face: of a face along an axis n·σ·n is a component
    let stress_at = |point: [f64; 3]| {
        let points = model.bodies[0].mesh.points();
        let node = points.iter().position(|p| *p == point[..2]).unwrap();
        solution.bodies[0].stress[node]
    };
    for piece in normal.chunk_by(|_, next| !next.starts) {
        for axis in [0, 1] {
            if piece.iter().all(|place| place.point[axis].abs() < 1e-12) {
                let off = piece
                    .iter()
                    .map(|p| (p.value - stress_at(p.point)[axis]).abs());
                assert!(off.fold(0.0, f64::max) < 1e-12);
            }
        }
    }
}
