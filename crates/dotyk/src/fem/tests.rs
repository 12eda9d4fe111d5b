//! A single body: supports, rigid motions, loads, energies and recovered stresses.
//!
//! Lengths and moduli are of size one: tolerances of 1e-13 and 1e-12 are rounding of sums of some hundred numbers.

use super::cells::{CellTable, stiffness_degree};
use super::loads::{NodalLoads, nodal_loads};
use super::modes::{carried_motion, free_modes};
use super::*;
use crate::geometry::{Field, Point, add_scaled, dot, norm};
use crate::mesh::{CellBlock, CellKind, Cuboid, Diagonals, Mesh, Rectangle};

const ELASTIC: Elastic = Elastic {
    young: 2.6,
    poisson: 0.3,
};
/// Lamé's parameters of it: E/(2(1 + ν)) = 1 and νE/((1 + ν)(1 − 2ν)) = 1.5.
const MU: f64 = 1.0;
const LAMBDA: f64 = 1.5;

/// The supports of a body, in the plane.
fn supported(body: &Body<2>, analysis: Analysis) -> Result<Constraints<2>, FemError> {
    Constraints::new((body, &History::default()), analysis, 0.0)
}

/// The loads of a body.
fn loaded<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    time: f64,
) -> Result<NodalLoads, FemError> {
    nodal_loads((body, &History::default()), analysis, time)
}

const PLANES: [Analysis; 3] = [
    Analysis::PlaneStrain,
    Analysis::PlaneStress,
    Analysis::Axisymmetric,
];

pub(super) fn body<const D: usize>(mesh: Mesh<D>) -> Body<D> {
    Body {
        materials: vec![Material {
            group: None,
            elastic: ELASTIC,
            strength: None,
            plastic: None,
            ages: None,
        }],
        ..Body::of("block", mesh.into())
    }
}

/// [1, 3] × [0, 1], cells of one kind.
fn rectangle(cell: CellKind, cells: [usize; 2]) -> Mesh<2> {
    Rectangle {
        from: [1.0, 0.0],
        to: [3.0, 1.0],
        cells,
        cell,
        diagonals: Diagonals::Forward,
    }
    .build()
    .unwrap()
}

fn cuboid(cell: CellKind) -> Mesh<3> {
    Cuboid {
        from: [0.0; 3],
        to: [1.0, 2.0, 1.0],
        cells: [2, 2, 1],
        cell,
    }
    .build()
    .unwrap()
}

fn on_side<const D: usize>(side: &str, components: [Option<f64>; D]) -> Support<D> {
    Support {
        place: Place::Side(side.to_string()),
        components: components.map(|value| value.map(Field::constant)),
        normal: None,
        active: Default::default(),
    }
}

fn at_point<const D: usize>(point: Point<D>, components: [Option<f64>; D]) -> Support<D> {
    Support {
        place: Place::Point(point),
        ..on_side("", components)
    }
}

fn roller<const D: usize>(side: &str, normal: f64) -> Support<D> {
    Support {
        normal: Some(Field::constant(normal)),
        ..on_side(side, [None; D])
    }
}

fn traction(side: &str, components: [Field; 2]) -> Load<2> {
    Load::Traction {
        side: side.to_string(),
        traction: components,
    }
}

fn constants(values: [f64; 2]) -> [Field; 2] {
    values.map(Field::constant)
}

/// Node at a point.
fn node<const D: usize>(mesh: &Mesh<D>, point: Point<D>) -> usize {
    nearest_node(mesh, point, "test").unwrap()
}

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} {b}");
}

fn scattered<const D: usize>(n: usize) -> Vec<Point<D>> {
    let number = |k: usize| ((k * k) as f64 * 0.073).sin();
    (0..n)
        .map(|k| std::array::from_fn(|i| number(D * k + i + 1)))
        .collect()
}

#[test]
fn materials_out_of_range_are_refused() {
    let with = |change: fn(&mut Body<2>)| {
        let mut body = body(rectangle(CellKind::Quad4, [2, 1]));
        change(&mut body);
        match assemble(&body, Analysis::PlaneStrain, 0.0) {
            Ok(_) => "",
            Err(FemError::Material { name, .. }) => name,
            Err(other) => panic!("{other}"),
        }
    };
    for (young, name) in [
        (with(|b| b.materials[0].elastic.young = 0.0), "young"),
        (with(|b| b.materials[0].elastic.young = -1.0), "young"),
        (
            with(|b| b.materials[0].elastic.young = f64::INFINITY),
            "young",
        ),
        (with(|b| b.materials[0].elastic.young = f64::NAN), "young"),
        (with(|b| b.materials[0].elastic.young = 1e-9), ""),
        (with(|b| b.materials[0].elastic.poisson = 0.5), "poisson"),
        (with(|b| b.materials[0].elastic.poisson = 0.499), ""),
        (with(|b| b.materials[0].elastic.poisson = -1.0), "poisson"),
        (with(|b| b.materials[0].elastic.poisson = -0.99), ""),
        (with(|b| b.materials[0].elastic.poisson = 0.0), ""),
        (
            with(|b| b.materials[0].elastic.poisson = f64::NAN),
            "poisson",
        ),
        (with(|b| b.thickness = 0.0), "thickness"),
        (with(|b| b.thickness = f64::INFINITY), "thickness"),
        (with(|b| b.thickness = f64::NAN), "thickness"),
        (with(|b| b.thickness = 1e-9), ""),
    ] {
        assert_eq!(young, name);
    }
}

/// Two squares beside each other, [0, 1]² of group "a" and [1, 3] × [0, 1] of group "b".
pub(super) fn groups() -> Mesh<2> {
    let points = [
        [0.0, 0.0],
        [1.0, 0.0],
        [3.0, 0.0],
        [0.0, 1.0],
        [1.0, 1.0],
        [3.0, 1.0],
    ];
    let block = |nodes: [u32; 4], group: &str| CellBlock {
        kind: CellKind::Quad4,
        nodes: nodes.to_vec(),
        group: Some(group.to_string()),
    };
    let blocks = vec![block([0, 1, 4, 3], "a"), block([1, 2, 5, 4], "b")];
    Mesh::new(points.to_vec(), blocks).unwrap()
}

#[test]
fn each_group_has_the_first_material_that_is_given_for_it() {
    let elastic = |young: f64| Elastic {
        young,
        poisson: 0.25,
    };
    let material = |group: Option<&str>, young: f64| Material {
        group: group.map(str::to_string),
        elastic: elastic(young),
        strength: None,
        plastic: None,
        ages: None,
    };
    let mut body = body(groups());
    body.materials = vec![
        material(Some("b"), 2.0),
        material(None, 3.0),
        material(Some("a"), 5.0),
    ];
    let found: Vec<f64> = (body.mesh.blocks().iter())
        .map(|block| body.elastic(block).unwrap().young)
        .collect();
    assert_eq!(found, [3.0, 2.0]);
    assert!(assemble(&body, Analysis::PlaneStrain, 0.0).is_ok());
    body.materials.truncate(1);
    let Err(FemError::NoMaterial { group }) = assemble(&body, Analysis::PlaneStrain, 0.0) else {
        panic!("group a has no material");
    };
    assert_eq!(group, "a");
    body.materials[0].group = Some("c".to_string());
    let Err(FemError::UnknownGroup { group, known }) = assemble(&body, Analysis::PlaneStrain, 0.0)
    else {
        panic!("there is no group c");
    };
    assert_eq!((group.as_str(), known.as_str()), ("c", "a, b"));
}

#[test]
fn analyses_of_another_dimension_are_refused() {
    let plane = body(rectangle(CellKind::Quad4, [1, 1]));
    let solid = body(cuboid(CellKind::Hex8));
    let refused = |error: Option<FemError>| matches!(error, Some(FemError::Dimension { .. }));
    for analysis in PLANES {
        assert!(assemble(&plane, analysis, 0.0).is_ok());
        assert!(
            refused(assemble(&solid, analysis, 0.0).err()),
            "{}",
            analysis.name()
        );
    }
    assert!(refused(assemble(&plane, Analysis::Solid, 0.0).err()));
    assert!(assemble(&solid, Analysis::Solid, 0.0).is_ok());
    let names = PLANES.map(Analysis::name);
    assert_eq!(names, ["plane-strain", "plane-stress", "axisymmetric"]);
    assert_eq!(Analysis::Solid.name(), "3d");
    // the plane modulus: 2.6/(1 − 0.09)
    near(ELASTIC.plane_modulus(), 2.857_142_857_142_857, 1e-15);
}

#[test]
fn radii_may_be_negative_by_rounding_alone() {
    let moved = |x: f64| {
        let mesh = rectangle(CellKind::Quad4, [2, 1]);
        let mesh = mesh.map_points(|p| if p[0] == 1.0 { [x, p[1]] } else { p });
        assemble(&body(mesh.unwrap()), Analysis::Axisymmetric, 0.0)
    };
    // 1e-9 of the diameter √10
    let tolerance = 1e-9 * 10f64.sqrt();
    assert!(moved(-0.9 * tolerance).is_ok());
    let Err(FemError::NegativeRadius { node, .. }) = moved(-1.1 * tolerance) else {
        panic!("the radius is negative");
    };
    assert_eq!(node, 0);
    // and nodes that near to the axis are held along the radius
    let held = |x: f64| moved(x).ok().map(|system| system.held);
    assert_eq!(
        held(0.9 * tolerance).map(|held| held[..2].to_vec()),
        Some(vec![true, false])
    );
    assert_eq!(
        held(-0.9 * tolerance).map(|held| held[..2].to_vec()),
        Some(vec![true, false])
    );
    assert_eq!(
        held(1.1 * tolerance).map(|held| held[..2].to_vec()),
        Some(vec![false; 2])
    );
}

/// Symmetric product of K with itself.
fn energy<const D: usize>(system: &BodySystem<D>, u: &[Point<D>]) -> (Vec<f64>, f64) {
    let mut flat: Vec<f64> = u.iter().flatten().copied().collect();
    system.to_frames(&mut flat);
    let mut product = vec![0.0; flat.len()];
    system.stiffness.mul(&flat, &mut product);
    let work: f64 = product.iter().zip(&flat).map(|(f, u)| f * u).sum();
    (product, 0.5 * work)
}

#[test]
fn energy_of_a_linear_field_is_that_of_hooke() {
    let h = [[0.3, -0.2], [0.5, 0.1]];
    let square =
        |a: f64, b: f64, shear: f64, hoop: f64| a * a + b * b + hoop * hoop + 2.0 * shear * shear;
    for cell in [
        CellKind::Tri3,
        CellKind::Tri6,
        CellKind::Quad4,
        CellKind::Quad8,
    ] {
        for analysis in PLANES {
            let mut body = body(rectangle(cell, [3, 2]));
            body.thickness = 0.7;
            let system = assemble(&body, analysis, 0.0).unwrap();
            let axisymmetric = analysis == Analysis::Axisymmetric;
            // with axial symmetry the hoop strain is u_r/r = h₀₀: no shear in u_r
            let h = if axisymmetric {
                [[0.3, 0.0], [0.5, 0.1]]
            } else {
                h
            };
            let u: Vec<Point<2>> = (body.mesh.points().iter())
                .map(|x| [0, 1].map(|i| h[i][0] * x[0] + h[i][1] * x[1]))
                .collect();
            let hoop = if axisymmetric { 0.3 } else { 0.0 };
            let trace = h[0][0] + h[1][1] + hoop;
            // the plane-stress λ is 2λμ/(λ + 2μ) = 3/3.5
            let lambda = match analysis {
                Analysis::PlaneStress => 3.0 / 3.5,
                _ => LAMBDA,
            };
            let shear = 0.5 * (h[0][1] + h[1][0]);
            let squares = square(h[0][0], h[1][1], shear, hoop);
            let density = 0.5 * lambda * trace * trace + MU * squares;
            // area 2, thickness 0.7; or π(3² − 1²)
            let volume = if axisymmetric {
                8.0 * std::f64::consts::PI
            } else {
                1.4
            };
            let (product, stored) = energy(&system, &u);
            near(stored, density * volume, 1e-12 * density * volume);
            let (forces, stored) = internal_forces(&body, analysis, &u).unwrap();
            near(stored, density * volume, 1e-12 * density * volume);
            for (force, product) in forces.iter().flatten().zip(&product) {
                near(*force, *product, 1e-12 * volume);
            }
        }
    }
}

#[test]
fn internal_forces_are_those_of_the_stiffness_for_any_displacement() {
    // more cells than a task takes, in one block
    for analysis in PLANES {
        let mut body = body(rectangle(CellKind::Quad4, [24, 12]));
        body.thickness = 0.5;
        let system = assemble(&body, analysis, 0.0).unwrap();
        let u = scattered::<2>(body.mesh.points().len());
        let (product, stored) = energy(&system, &u);
        let (forces, own) = internal_forces(&body, analysis, &u).unwrap();
        near(own, stored, 1e-12 * stored);
        let largest = product.iter().fold(0.0, |s: f64, f| s.max(f.abs()));
        for (force, product) in forces.iter().flatten().zip(&product) {
            near(*force, *product, 1e-13 * largest);
        }
    }
    for cell in CellKind::of_dimension(3) {
        let body = body(cuboid(cell));
        let system = assemble(&body, Analysis::Solid, 0.0).unwrap();
        let u = scattered::<3>(body.mesh.points().len());
        let (product, stored) = energy(&system, &u);
        let (forces, own) = internal_forces(&body, Analysis::Solid, &u).unwrap();
        near(own, stored, 1e-13 * stored);
        for (force, product) in forces.iter().flatten().zip(&product) {
            near(*force, *product, 1e-13 * stored);
        }
    }
}

#[test]
fn stiffness_in_turned_frames_has_the_same_energy() {
    let angle = 0.4f64;
    let (sin, cos) = angle.sin_cos();
    let turned = rectangle(CellKind::Quad4, [3, 2])
        .map_points(|[x, y]| [cos * x - sin * y, sin * x + cos * y])
        .unwrap();
    let free = assemble(&body(turned.clone()), Analysis::PlaneStrain, 0.0).unwrap();
    let mut held = body(turned);
    held.supports = vec![roller("left", 0.0), roller("bottom", 0.1)];
    let system = assemble(&held, Analysis::PlaneStrain, 0.0).unwrap();
    // the nodes of both sides have frames: 3 + 4, one of them twice
    assert_eq!((free.frames.len(), system.frames.len()), (0, 6));
    let u = scattered::<2>(held.mesh.points().len());
    let (_, expected) = energy(&free, &u);
    let (product, stored) = energy(&system, &u);
    near(stored, expected, 1e-13 * expected);
    let back = system.to_global(&product);
    let (forces, _) = energy(&free, &u);
    for (back, force) in back.iter().flatten().zip(&forces) {
        near(*back, *force, 1e-12);
    }
    // a row in a frame does the same work as in global axes
    for (&node, axes) in &system.frames {
        for (k, axis) in axes.iter().enumerate() {
            let row: Vec<(usize, f64)> = system.row_in_frames(&[(node, *axis)]).collect();
            assert_eq!((row.len(), row[0].0), (1, 2 * node + k));
            near(row[0].1, 1.0, 1e-15);
        }
    }
    let without = (0..held.mesh.points().len()).find(|n| !system.frames.contains_key(n));
    let (node_without, row) = (without.unwrap(), [3.0, 4.0]);
    let kept: Vec<(usize, f64)> = system.row_in_frames(&[(node_without, row)]).collect();
    assert_eq!(kept, [(2 * node_without, 3.0), (2 * node_without + 1, 4.0)]);
    // the normal of the turned bottom is (sin, −cos)
    let at = node(&held.mesh, [cos * 3.0, sin * 3.0]);
    let [held_dir] = system.constraints.at(at) else {
        panic!("one direction is held");
    };
    near(dot(held_dir.axis, [sin, -cos]), 1.0, 1e-14);
    assert!(system.held[2 * at] && !system.held[2 * at + 1]);
    near(system.prescribed[2 * at], 0.1, 1e-15);
}

#[test]
fn turned_nodes_keep_energy_loads_and_modes_and_held_ones_stay() {
    let mut body = body(cuboid(CellKind::Hex8));
    body.supports = vec![roller("left", 0.0)];
    body.loads = vec![Load::Pressure {
        side: "top".to_string(),
        pressure: Field::constant(3.0),
    }];
    let plain = assemble(&body, Analysis::Solid, 0.0).unwrap();
    let mut turned = assemble(&body, Analysis::Solid, 0.0).unwrap();
    let oblique = [2.0 / 7.0, 3.0 / 7.0, -6.0 / 7.0];
    turned.turn((0..8).map(|node| (node, oblique)));
    let held = (0..8).filter(|node| plain.constraints.nodes.contains_key(node));
    assert_eq!(turned.frames.len(), 8 - held.count());
    let u = scattered::<3>(body.mesh.points().len());
    let (expected, stored) = energy(&plain, &u);
    let (product, same) = energy(&turned, &u);
    near(same, stored, 1e-13 * stored);
    let forces = turned.to_global(&product);
    for (a, b) in forces.iter().flatten().zip(&expected) {
        near(*a, *b, 1e-12);
    }
    let vectors = |system: &BodySystem<3>| {
        let all = [&system.load, &system.carried].into_iter();
        let global = all.chain(&system.modes).map(|v| system.to_global(v));
        global.flatten().flatten().collect::<Vec<f64>>()
    };
    for (a, b) in vectors(&turned).iter().zip(vectors(&plain)) {
        near(*a, b, 1e-15);
    }
    for &node in turned.frames.keys() {
        // and a coefficient that is rounding
        let row = [(node, oblique.map(|c| 2.0 * c)), (node, [1e-14, 0.0, 0.0])];
        let row: Vec<(usize, f64)> = turned.row_in_frames(&row).collect();
        assert_eq!((row.len(), row[0].0), (1, 3 * node));
        near(row[0].1, 2.0, 1e-15);
    }
}

#[test]
fn oblique_directions_in_space_are_completed_to_frames() {
    let (sin, cos) = 0.3f64.sin_cos();
    let turn = |[x, y, z]: Point<3>| {
        let [x, y] = [cos * x - sin * y, sin * x + cos * y];
        [x, cos * y - sin * z, sin * y + cos * z]
    };
    let mut body = body(cuboid(CellKind::Hex8).map_points(turn).unwrap());
    body.supports = vec![
        roller("left", 0.0),
        roller("front", 0.0),
        roller("bottom", 0.0),
    ];
    let system = assemble(&body, Analysis::Solid, 0.0).unwrap();
    let mut counts = [0; 4];
    for (&node, axes) in &system.frames {
        let held = system.constraints.at(node);
        counts[held.len()] += 1;
        for (k, axis) in axes.iter().enumerate() {
            if let Some(held) = held.get(k) {
                assert_eq!(*axis, held.axis);
                assert!(system.held[3 * node + k]);
            } else {
                assert!(!system.held[3 * node + k]);
            }
            for (l, other) in axes.iter().enumerate() {
                near(dot(*axis, *other), f64::from(u8::from(k == l)), 1e-14);
            }
        }
    }
    // a corner, the nodes inside of the three edges from it, and those of the three faces: 3 × 3 × 2 nodes in all
    assert_eq!(counts, [0, 8, 5, 1]);
    assert!(system.modes.is_empty());
}

#[test]
fn a_node_with_one_oblique_direction_has_a_frame_whatever_else_holds_it() {
    let (sin, cos) = 0.3f64.sin_cos();
    let turn = |[x, y, z]: Point<3>| [cos * x - sin * y, sin * x + cos * y, z];
    let mut body = body(cuboid(CellKind::Hex8).map_points(turn).unwrap());
    body.supports = vec![roller("bottom", 0.0), roller("left", 0.0)];
    let system = assemble(&body, Analysis::Solid, 0.0).unwrap();
    // the left face has 3 × 2 nodes, half of them at the bottom, too
    assert_eq!(system.frames.len(), 6);
    let both = system
        .frames
        .keys()
        .filter(|node| system.constraints.at(**node).len() == 2);
    for node in both.clone() {
        assert_eq!(system.held[3 * node..3 * node + 3], [true, true, false]);
        near(system.frames[node][0][2].abs(), 1.0, 1e-15);
    }
    assert_eq!(both.count(), 3);
    // the motion along the oblique face
    assert_eq!(system.modes.len(), 1);
}

#[test]
fn prescribed_displacements_are_a_rigid_motion_and_a_rest() {
    // all ends move as one: no strain remains
    let mut moved = body(rectangle(CellKind::Quad4, [2, 2]));
    moved.supports = vec![
        on_side("left", [Some(2.0), Some(-1.0)]),
        on_side("right", [Some(2.0), None]),
    ];
    let system = assemble(&moved, Analysis::PlaneStrain, 0.0).unwrap();
    assert!(system.lift.iter().all(|lift| *lift == 0.0));
    for u in system.carried.chunks(2) {
        near(u[0], 2.0, 1e-14);
        near(u[1], -1.0, 1e-14);
    }
    // one end is pulled off the other: half of it is carried, and the rest is that of each end
    moved.supports[1] = on_side("right", [Some(4.0), None]);
    let system = assemble(&moved, Analysis::PlaneStrain, 0.0).unwrap();
    for (n, x) in moved.mesh.points().iter().enumerate() {
        let left = x[0] == 1.0;
        let (prescribed, lift) = match x[0] {
            1.0 => (2.0, -1.0),
            3.0 => (4.0, 1.0),
            _ => (0.0, 0.0),
        };
        assert_eq!(system.prescribed[2 * n], prescribed);
        near(system.lift[2 * n], lift, 1e-13);
        assert_eq!(system.held[2 * n], lift != 0.0);
        assert_eq!(system.held[2 * n + 1], left);
        near(system.carried[2 * n], 3.0, 1e-13);
        // the carried motion is fitted to all held dofs
        if left {
            near(
                system.carried[2 * n + 1] + system.lift[2 * n + 1],
                -1.0,
                1e-13,
            );
        }
    }
    // an axis that is held the other way round
    let mut pressed = body(rectangle(CellKind::Quad4, [2, 2]));
    pressed.supports = vec![roller("left", 0.25), roller("bottom", 0.0)];
    let system = assemble(&pressed, Analysis::PlaneStrain, 0.0).unwrap();
    let at = node(&pressed.mesh, [1.0, 1.0]);
    assert_eq!(
        (system.held[2 * at], system.prescribed[2 * at]),
        (true, -0.25)
    );
}

#[test]
fn motions_that_fit_turns_are_turns() {
    // u = ω × x about (2, 1): the whole of it is carried
    let turn = |x: Point<2>| [-0.5 * (x[1] - 1.0), 0.5 * (x[0] - 2.0)];
    let mut body = body(rectangle(CellKind::Quad4, [2, 2]));
    body.supports = vec![Support {
        components: [
            Some(Field::function("u", move |p, _| turn([p[0], p[1]])[0])),
            Some(Field::function("v", move |p, _| turn([p[0], p[1]])[1])),
        ],
        ..on_side("left", [None; 2])
    }];
    let constraints = supported(&body, Analysis::PlaneStrain).unwrap();
    let carried = carried_motion(&body.mesh, &constraints, RigidBasis::Full);
    for (u, &x) in carried.chunks(2).zip(body.mesh.points()) {
        near(u[0], turn(x)[0], 1e-13);
        near(u[1], turn(x)[1], 1e-13);
    }
    // pushed by one value everywhere: it moves by that value
    body.supports = vec![on_side("left", [Some(0.1), None])];
    let constraints = supported(&body, Analysis::PlaneStrain).unwrap();
    for u in carried_motion(&body.mesh, &constraints, RigidBasis::Full).chunks(2) {
        near(u[0], 0.1, 1e-14);
        near(u[1], 0.0, 1e-14);
    }
    // one held point determines no rotation
    body.supports = vec![at_point([1.0, 0.0], [Some(0.0), Some(0.0)])];
    let constraints = supported(&body, Analysis::PlaneStrain).unwrap();
    let carried = carried_motion(&body.mesh, &constraints, RigidBasis::Full);
    assert!(carried.iter().all(|u| *u == 0.0));
}

#[test]
fn a_later_time_changes_loads_and_prescribed_values_alone() {
    let mut body = body(rectangle(CellKind::Quad4, [2, 1]));
    let mut support = on_side("left", [None, Some(0.0)]);
    support.components[0] = Some(Field::function("t", |_, t| t));
    body.supports = vec![support];
    let load = [Field::function("2 t", |_, t| 2.0 * t), Field::constant(0.0)];
    body.loads = vec![traction("right", load)];
    let expected = assemble(&body, Analysis::PlaneStrain, 3.0).unwrap();
    let first = assemble(&body, Analysis::PlaneStrain, 1.0).unwrap();
    let values = first.stiffness.values().to_vec();
    let later = first.at_time(&body, Analysis::PlaneStrain, 3.0).unwrap();
    assert_eq!(later.stiffness.values(), values);
    assert_eq!(later.constraints, expected.constraints);
    assert_eq!(
        (later.load, later.prescribed),
        (expected.load, expected.prescribed)
    );
    assert_eq!(
        (later.carried, later.lift),
        (expected.carried, expected.lift)
    );
    assert_eq!(
        (later.held, later.largest_load),
        (expected.held, expected.largest_load)
    );
    // the side is 1 long
    near(later.largest_load, 6.0, 1e-14);
}

#[test]
fn what_is_rigid_moves_where_nothing_holds_it() {
    let free = BodySystem::<2>::rigid(&[[3.0, -4.0]], &[[None; 2]]);
    assert_eq!((free.load, free.largest_load), (vec![3.0, -4.0], 5.0));
    assert_eq!(free.modes, [[1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(free.held, [false; 2]);
    assert_eq!(
        (free.prescribed, free.carried, free.lift),
        (vec![0.0; 2], vec![0.0; 2], vec![0.0; 2])
    );
    assert_eq!((free.graph.nodes(), free.stiffness.len()), (1, 2));
    let held = [[None, Some(0.1)], [Some(-0.2), Some(0.0)]];
    let point = BodySystem::<2>::rigid(&[[3.0, -4.0], [0.0, 6.0]], &held);
    assert_eq!((point.load.len(), point.largest_load), (4, 6.0));
    assert_eq!(point.held, [false, true, true, true]);
    assert_eq!(point.modes, [[1.0, 0.0, 0.0, 0.0]]);
    // it causes no strain: it is carried along
    let values = vec![0.0, 0.1, -0.2, 0.0];
    assert_eq!((&point.prescribed, &point.carried), (&values, &values));
    assert_eq!(point.lift, [0.0; 4]);
    assert_eq!((point.graph.nodes(), point.stiffness.len()), (2, 4));
}

#[test]
fn rigid_motions_strain_nothing_and_are_counted() {
    assert_eq!(
        [
            RigidBasis::Full.len(2),
            RigidBasis::Full.len(3),
            RigidBasis::Axial.len(2)
        ],
        [3, 6, 1]
    );
    assert!(!RigidBasis::Full.is_empty() && !RigidBasis::Axial.is_empty());
    assert_eq!(RigidBasis::of(Analysis::Axisymmetric), RigidBasis::Axial);
    assert_eq!(RigidBasis::of(Analysis::Solid), RigidBasis::Full);
    let gradient = |k: usize| -> [[f64; 3]; 3] {
        // differences of a linear field are exact
        let at = |x: Point<3>| RigidBasis::Full.displacement(k, x);
        let unit = |j: usize| std::array::from_fn(|i| f64::from(u8::from(i == j)));
        std::array::from_fn(|i| std::array::from_fn(|j| at(unit(j))[i] - at([0.0; 3])[i]))
    };
    for k in 0..6 {
        let h = gradient(k);
        for (i, row) in h.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert_eq!(*entry, -h[j][i]);
            }
        }
        // the k-th turns about axis k: (h₂₁, h₀₂, h₁₀); then come the translations
        let spin = [h[2][1], h[0][2], h[1][0]];
        assert_eq!(spin, std::array::from_fn(|i| f64::from(u8::from(i == k))));
        let moved = RigidBasis::Full.displacement(k, [0.0; 3]);
        assert_eq!(
            moved,
            std::array::from_fn(|i| f64::from(u8::from(i + 3 == k)))
        );
    }
    assert_eq!(RigidBasis::Full.displacement(0, [2.0, 3.0]), [-3.0, 2.0]);
    assert_eq!(RigidBasis::Full.displacement(1, [2.0, 3.0]), [1.0, 0.0]);
    assert_eq!(RigidBasis::Full.displacement(2, [2.0, 3.0]), [0.0, 1.0]);
    assert_eq!(RigidBasis::Axial.displacement(0, [2.0, 3.0]), [0.0, 1.0]);
}

/// Number of motions that supports leave free; each strains nothing, moves no held dof and has largest displacement 1.
fn free(mesh: Mesh<2>, analysis: Analysis, supports: Vec<Support<2>>) -> usize {
    let mut body = body(mesh);
    body.supports = supports;
    let system = assemble(&body, analysis, 0.0).unwrap();
    for mode in &system.modes {
        let motion = system.to_global(mode);
        let largest = motion.iter().fold(0.0, |s: f64, u| s.max(norm(*u)));
        near(largest, 1.0, 1e-14);
        let (_, stored) = internal_forces(&body, analysis, &motion).unwrap();
        near(stored, 0.0, 1e-26);
        assert!(
            mode.iter()
                .zip(&system.held)
                .all(|(u, held)| !held || *u == 0.0)
        );
    }
    system.modes.len()
}

#[test]
fn supports_leave_free_what_they_do_not_hold() {
    use Analysis::{Axisymmetric, PlaneStrain};
    let mesh = || rectangle(CellKind::Quad4, [2, 1]);
    assert_eq!(free(mesh(), PlaneStrain, vec![]), 3);
    assert_eq!(
        free(
            mesh(),
            PlaneStrain,
            vec![on_side("left", [Some(0.0), None])]
        ),
        1
    );
    assert_eq!(
        free(
            mesh(),
            PlaneStrain,
            vec![at_point([1.0, 0.0], [Some(0.0); 2])]
        ),
        1
    );
    assert_eq!(
        free(mesh(), PlaneStrain, vec![on_side("left", [Some(0.0); 2])]),
        0
    );
    assert_eq!(free(mesh(), Axisymmetric, vec![]), 1);
    assert_eq!(
        free(
            mesh(),
            Axisymmetric,
            vec![on_side("bottom", [None, Some(0.0)])]
        ),
        0
    );
    // rollers across each other leave no rotation
    let rollers = vec![roller("left", 0.0), roller("bottom", 0.0)];
    assert_eq!(free(mesh(), PlaneStrain, rollers), 0);
    // in whatever unit lengths are given
    for size in [1e-6, 1e6] {
        let scaled = || mesh().map_points(|p| p.map(|c| size * c)).unwrap();
        assert_eq!(free(scaled(), PlaneStrain, vec![roller("left", 0.0)]), 1);
        assert_eq!(free(scaled(), PlaneStrain, vec![]), 3);
    }
    // a chain of three squares, each hinged to the next at a corner
    let square = |i: usize| {
        let [low, high] = [i as f64, i as f64 + 1.0];
        [[high, low], [high, high], [low, high]]
    };
    let points = [vec![[0.0, 0.0]], (0..3).flat_map(square).collect()].concat();
    let block = CellBlock {
        kind: CellKind::Quad4,
        nodes: vec![0, 1, 2, 3, 2, 4, 5, 6, 5, 7, 8, 9],
        group: None,
    };
    assert_eq!(
        free(Mesh::new(points, vec![block]).unwrap(), PlaneStrain, vec![]),
        5
    );
    // two squares that share a corner: a hinge; and two apart
    let pair = |shared: bool| {
        let mut points = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let start = if shared { 2 } else { 7 };
        points.extend([[2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]);
        if !shared {
            points.iter_mut().skip(4).for_each(|p| p[0] += 0.5);
            points.push([1.5, 1.0]);
        }
        let block = CellBlock {
            kind: CellKind::Quad4,
            nodes: vec![0, 1, 2, 3, start, 4, 5, 6],
            group: None,
        };
        Mesh::new(points, vec![block]).unwrap()
    };
    assert_eq!(free(pair(true), PlaneStrain, vec![]), 4);
    assert_eq!(free(pair(false), PlaneStrain, vec![]), 6);
    assert_eq!(
        free(
            pair(true),
            PlaneStrain,
            vec![at_point([0.0, 0.0], [Some(0.0); 2])]
        ),
        2
    );
}

#[test]
fn motions_of_a_free_body_are_pure_ones() {
    let mesh = rectangle(CellKind::Quad4, [2, 1]);
    let told = |supports: Vec<Support<2>>| -> Vec<String> {
        let mut body = body(mesh.clone());
        body.supports = supports;
        let constraints = supported(&body, Analysis::PlaneStrain).unwrap();
        let modes = free_modes(&mesh, (&constraints, &[]), RigidBasis::Full);
        let points =
            |mode: &Vec<f64>| -> Vec<Point<2>> { mode.chunks(2).map(|u| [u[0], u[1]]).collect() };
        let describe = |mode: &Vec<f64>| describe_motion(mesh.points(), &points(mode));
        modes.iter().map(describe).collect()
    };
    assert_eq!(
        told(vec![]),
        [
            "rotation about (2, 0.5)",
            "translation along x",
            "translation along y"
        ]
    );
    assert_eq!(
        told(vec![on_side("left", [Some(0.0), None])]),
        ["translation along y"]
    );
    assert_eq!(
        told(vec![at_point([1.0, 0.0], [Some(0.0); 2])]),
        ["rotation about (1, 0)"]
    );
}

#[test]
fn motions_are_told_in_words_and_by_their_numbers() {
    let plane = rectangle(CellKind::Quad4, [2, 1]);
    let of = |u: &dyn Fn(Point<2>) -> Point<2>| {
        let motion: Vec<Point<2>> = plane.points().iter().map(|&x| u(x)).collect();
        describe_motion(plane.points(), &motion)
    };
    assert_eq!(of(&|_| [3.0, 4.0]), "translation along (0.6, 0.8)");
    assert_eq!(of(&|_| [0.0, -2.0]), "translation along y");
    let upper = |x: Point<2>| [0.0, if x[1] > 0.5 { 3.0 } else { 0.0 }];
    assert_eq!(of(&upper), "translation along y of a part of it");
    let about = |centre: f64| of(&move |x| [-x[1], x[0] - centre]);
    assert_eq!(about(7.0), "rotation about (7, 0)");
    // about a centre more than a thousand sizes (√5) away
    assert_eq!(about(2200.0), "rotation about (2200, 0)");
    assert!(
        about(2270.0).starts_with("translation along ("),
        "{}",
        about(2270.0)
    );

    let solid = cuboid(CellKind::Hex8);
    let of = |u: &dyn Fn(Point<3>) -> Point<3>| {
        let motion: Vec<Point<3>> = solid.points().iter().map(|&x| u(x)).collect();
        describe_motion(solid.points(), &motion)
    };
    assert_eq!(of(&|_| [0.0, 0.0, 1.0]), "translation along z");
    let centre = [0.5, 1.0, 0.5];
    // about z through (3, 4): and the point of the axis nearest to the centre of the box is told
    let turn = |along: f64| of(&move |x| [-(x[1] - 4.0), x[0] - 3.0, along]);
    assert_eq!(turn(0.0), "rotation about z through (3, 4, 0.5)");
    // along the axis by less than a thousandth of the size √6 in a turn of one
    assert_eq!(
        turn(0.9e-3 * 6f64.sqrt()),
        "rotation about z through (3, 4, 0.5)"
    );
    assert_eq!(
        turn(1.1e-3 * 6f64.sqrt()),
        "screw about z through (3, 4, 0.5)"
    );
    let about_x = of(&move |x| [0.0, -(x[2] - centre[2]), x[1] - centre[1]]);
    assert_eq!(about_x, "rotation about x through (0.5, 1, 0.5)");
}

#[test]
fn rigid_motions_are_found_again() {
    let points: Vec<Point<3>> = scattered::<3>(20)
        .iter()
        .map(|p| p.map(|c| 5.0 * c + 2.0))
        .collect();
    let (translation, spin) = ([0.3, -0.2, 0.5], [0.1, 0.7, -0.4]);
    let centre = [1.0, -2.0, 3.0];
    let motion = |x: Point<3>| {
        let r: Point<3> = std::array::from_fn(|i| x[i] - centre[i]);
        let turned = crate::geometry::cross(spin, r);
        add_scaled(translation, 1.0, turned)
    };
    let u: Vec<Point<3>> = points.iter().map(|&x| motion(x)).collect();
    let (t, s) = fit_rigid(RigidBasis::Full, &points, &u, centre);
    (0..3).for_each(|i| near(t[i], translation[i], 1e-12));
    (0..3).for_each(|i| near(s[i], spin[i], 1e-12));
    let points: Vec<Point<2>> = points.iter().map(|p| [p[0], p[1]]).collect();
    let u: Vec<Point<2>> = points
        .iter()
        .map(|x| [0.5 - 0.3 * (x[1] + 2.0), 0.3 * (x[0] - 1.0)])
        .collect();
    let (t, s) = fit_rigid(RigidBasis::Full, &points, &u, [1.0, -2.0]);
    near(t[0], 0.5, 1e-12);
    near(t[1], 0.0, 1e-12);
    near(s[0], 0.3, 1e-12);
    assert_eq!(s.len(), 1);
    // with axial symmetry the mean along the axis
    let u: Vec<Point<2>> = (0..20).map(|i| [9.0, f64::from(i)]).collect();
    let (t, s) = fit_rigid(RigidBasis::Axial, &points, &u, [1.0, -2.0]);
    near(t[1], 9.5, 1e-12);
    assert_eq!((t[0], s), (0.0, vec![0.0]));
    let (t, s) = fit_rigid(
        RigidBasis::Full,
        &points,
        &vec![[f64::NAN; 2]; 20],
        [0.0; 2],
    );
    assert!(t[0].is_nan() && s[0].is_nan());
}

/// Resultant of nodal forces.
fn sum<const D: usize>(forces: &[f64]) -> Point<D> {
    let nodes = forces.chunks(D);
    nodes.fold([0.0; D], |sum, f| {
        add_scaled(sum, 1.0, std::array::from_fn(|i| f[i]))
    })
}

#[test]
fn nodal_forces_do_the_work_of_the_loads() {
    // x and y as displacements: ∫ t·u over the side, and ∫ b·u over the body
    for cell in [
        CellKind::Tri3,
        CellKind::Quad4,
        CellKind::Tri6,
        CellKind::Quad8,
    ] {
        let mut body = body(rectangle(cell, [3, 2]));
        body.thickness = 0.5;
        let work = |body: &Body<2>, analysis: Analysis, u: &dyn Fn(Point<2>) -> Point<2>| -> f64 {
            let forces = loaded(body, analysis, 0.0).unwrap().forces;
            let points = body.mesh.points().iter();
            forces
                .chunks(2)
                .zip(points)
                .map(|(f, &x)| dot([f[0], f[1]], u(x)))
                .sum()
        };
        // t = (y², 1) on the right, x = 3: ∫ y²·y + 1·x dy = 1/4 + 3
        let square = Field::function("y^2", |p, _| p[1] * p[1]);
        body.loads = vec![traction("right", [square, Field::constant(1.0)])];
        let u = |x: Point<2>| [x[1], x[0]];
        near(work(&body, Analysis::PlaneStress, &u), 0.5 * 3.25, 1e-13);
        let turn = 2.0 * std::f64::consts::PI * 3.0;
        near(work(&body, Analysis::Axisymmetric, &u), turn * 3.25, 1e-12);
        // pressure x on the top: pushes down, ∫ −x · x dx = −26/3
        body.loads = vec![Load::Pressure {
            side: "top".to_string(),
            pressure: Field::function("x", |p, _| p[0]),
        }];
        near(
            work(&body, Analysis::PlaneStrain, &u),
            -0.5 * 26.0 / 3.0,
            1e-12,
        );
        // b = (x y, 2): ∫ x y · y + 2 · x = 4/3 + 8
        body.loads.clear();
        body.body_force = [
            Field::function("x y", |p, _| p[0] * p[1]),
            Field::constant(2.0),
        ];
        near(
            work(&body, Analysis::PlaneStrain, &u),
            0.5 * (4.0 / 3.0 + 8.0),
            1e-12,
        );
        // and with 2πr: ∫ x² y² + 2 x² = 26/9 + 52/3
        let expected = 2.0 * std::f64::consts::PI * (26.0 / 9.0 + 52.0 / 3.0);
        near(work(&body, Analysis::Axisymmetric, &u), expected, 1e-11);
    }
}

#[test]
fn resultants_are_spread_and_forces_act_at_their_node() {
    let mut body = body(rectangle(CellKind::Quad4, [2, 2]));
    body.thickness = 0.5;
    body.loads = vec![
        Load::Resultant {
            side: "top".to_string(),
            force: constants([3.0, -4.0]),
        },
        Load::Force {
            point: [1.1, 0.1],
            force: [
                Field::function("x + t", |p, t| p[0] + t),
                Field::constant(2.0),
            ],
        },
    ];
    for analysis in PLANES {
        let NodalLoads {
            forces,
            largest,
            rounding,
        } = loaded(&body, analysis, 0.5).unwrap();
        assert!(rounding.is_empty());
        let total = sum::<2>(&forces);
        near(total[0], 4.5, 1e-13);
        near(total[1], -2.0, 1e-13);
        near(largest, 5.0, 1e-13);
        // the value at the node (1, 0), not at the point
        let at = node(&body.mesh, [1.0, 0.0]);
        assert_eq!(forces[2 * at..2 * at + 2], [1.5, 2.0]);
    }
    assert_eq!(body.loads[0].place(), Place::Side("top".to_string()));
    assert_eq!(body.loads[1].place(), Place::Point([1.1, 0.1]));
    let amounts = |load: &Load<2>| load.amount();
    assert_eq!(
        [amounts(&body.loads[0]), amounts(&body.loads[1])],
        [Amount::Whole; 2]
    );
    assert_eq!(
        traction("top", constants([1.0, 0.0])).amount(),
        Amount::PerArea
    );
}

#[test]
fn scale_of_a_load_is_its_resultant_unless_that_is_rounding() {
    let largest = |down: f64, up: f64| {
        let mut body = body(rectangle(CellKind::Quad4, [2, 2]));
        let step = move |p: [f64; 3], _: f64| if p[0] < 2.0 { -down } else { up };
        body.loads = vec![traction(
            "top",
            [Field::constant(0.0), Field::function("step", step)],
        )];
        loaded(&body, Analysis::PlaneStrain, 0.0).unwrap().largest
    };
    near(largest(3.0, 1.0), 2.0, 1e-13);
    // resultants of 1.1 and 0.9 thousandths of the magnitudes
    near(largest(1.0011, 0.9989), 2.2e-3, 1e-13);
    near(largest(1.0009, 0.9991), 2.0, 1e-13);
    // the largest of several, of a body force too
    let mut several = body(rectangle(CellKind::Quad4, [2, 2]));
    several.loads = vec![
        traction("top", constants([0.0, 1.0])),
        traction("top", constants([0.0, -1.0])),
    ];
    let of = |body: &Body<2>| loaded(body, Analysis::PlaneStrain, 0.0).unwrap().largest;
    near(of(&several), 2.0, 1e-13);
    several.body_force = constants([3.0, 4.0]);
    near(of(&several), 10.0, 1e-12);
    several.body_force[0] = Field::constant(0.0);
    near(of(&several), 8.0, 1e-12);
    near(of(&body(rectangle(CellKind::Quad4, [1, 1]))), 0.0, 0.0);
}

#[test]
fn loads_and_supports_that_are_no_numbers_are_named() {
    let told = |change: fn(&mut Body<2>)| {
        let mut body = body(rectangle(CellKind::Quad4, [2, 2]));
        change(&mut body);
        assemble(&body, Analysis::PlaneStrain, 0.0)
            .err()
            .map(|e| e.to_string())
    };
    let starts = |found: Option<String>, expected: &str| {
        assert!(
            found
                .as_ref()
                .is_some_and(|found| found.starts_with(expected)),
            "{found:?}"
        );
    };
    starts(
        told(|b| b.loads = vec![traction("top", constants([0.0, f64::NAN]))]),
        "traction on side \"top\" = NaN is not finite at (",
    );
    starts(
        told(|b| {
            b.loads = vec![Load::Pressure {
                side: "left".to_string(),
                pressure: Field::constant(f64::INFINITY),
            }]
        }),
        "pressure on side \"left\" = inf is not finite at (1, ",
    );
    starts(
        told(|b| {
            b.loads = vec![Load::Force {
                point: [1.0, 0.0],
                force: constants([f64::NAN, 0.0]),
            }]
        }),
        "force at point (1, 0) = NaN is not finite at (1, 0)",
    );
    starts(
        told(|b| b.body_force[1] = Field::constant(f64::NAN)),
        "body_force = NaN is not finite",
    );
    starts(
        told(|b| b.supports = vec![on_side("left", [Some(f64::NAN), None])]),
        "support on side \"left\" = NaN is not finite at (1, 0)",
    );
    starts(
        told(|b| b.supports = vec![roller("left", f64::NAN)]),
        "support on side \"left\" = NaN",
    );
    starts(
        told(|b| b.supports = vec![on_side("lid", [Some(0.0), None])]),
        "there is no side \"lid\"; the sides are: bottom, left, right, top",
    );
    starts(
        told(|b| {
            b.mesh = Mesh::clone(&b.mesh).with_side("lid", |_| false).into();
            b.loads = vec![traction("lid", constants([1.0, 0.0]))];
        }),
        "side \"lid\" has no facets",
    );
}

#[test]
fn supports_that_agree_are_one_and_others_are_a_contradiction() {
    let new = |supports: Vec<Support<2>>| {
        let mut body = body(rectangle(CellKind::Quad4, [2, 1]));
        body.supports = supports;
        supported(&body, Analysis::PlaneStrain)
    };
    let held = |supports: Vec<Support<2>>| new(supports).unwrap().at(0).to_vec();
    let both = held(vec![
        on_side("left", [Some(0.5), None]),
        at_point([1.0, 0.0], [Some(0.5), Some(0.0)]),
    ]);
    assert_eq!(both.len(), 2);
    assert_eq!(
        (both[0].axis, both[0].value, both[0].still),
        ([1.0, 0.0], 0.5, false)
    );
    assert_eq!(both[0].supports, [0, 1]);
    assert_eq!(
        (both[1].axis, both[1].value, both[1].still),
        ([0.0, 1.0], 0.0, true)
    );
    assert_eq!(both[1].supports, [1]);
    // a support that asks twice is named once
    let twice = held(vec![Support {
        normal: Some(Field::constant(-0.5)),
        ..on_side("left", [Some(0.5), None])
    }]);
    assert_eq!((twice.len(), twice[0].supports.clone()), (1, vec![0]));
    // up to 1e-9 of the larger value
    let apart = |a: f64, b: f64| {
        let supports = vec![
            on_side("left", [Some(a), None]),
            at_point([1.0, 0.0], [Some(b), None]),
        ];
        new(supports).err()
    };
    assert_eq!(apart(2.0, 2.0 * (1.0 + 0.9e-9)), None);
    assert_eq!(apart(-2.0 * (1.0 + 0.9e-9), -2.0), None);
    let Some(FemError::Contradiction {
        node,
        first,
        second,
        a,
        b,
        ..
    }) = apart(2.0, 2.0 * (1.0 + 1.1e-9))
    else {
        panic!("they differ by more");
    };
    assert_eq!(
        (node, first.as_str(), second.as_str()),
        (0, "on side \"left\"", "at point (1, 0)")
    );
    assert_eq!((a, b), (2.0, 2.0 * (1.0 + 1.1e-9)));
    // what differs by rounding of a length of the body is the same
    assert!(apart(0.0, 1e-12).is_some() && apart(0.0, 1e-17).is_none());
    assert!(apart(2.0, -2.0).is_some());
    assert!(new(vec![]).unwrap().at(0).is_empty());
}

#[test]
fn supports_whose_terms_cancel_agree_to_the_rounding_of_these() {
    let new = |supports: Vec<Support<2>>, angle: f64| {
        // the normal of the left side is that of a wedge
        let (sin, cos) = angle.sin_cos();
        let turned = rectangle(CellKind::Quad4, [2, 1])
            .map_points(|[x, y]| [cos * x - sin * y, sin * x + cos * y]);
        let mut body = body(turned.unwrap());
        body.supports = supports;
        supported(&body, Analysis::PlaneStrain)
    };
    for k in 1..30 {
        let angle = 0.1 * f64::from(k);
        // along the side, which its normal does not move
        let [x, y] = [-angle.sin() * 0.01, angle.cos() * 0.01];
        let all = [
            on_side("left", [Some(x), None]),
            on_side("left", [None, Some(y)]),
            roller("left", 0.0),
        ];
        for order in [[0, 1, 2], [2, 0, 1], [0, 2, 1], [1, 2, 0]] {
            let supports = order.map(|i| all[i].clone()).to_vec();
            assert_eq!(new(supports, angle).err(), None, "{angle} {order:?}");
        }
        let mut apart = all.to_vec();
        apart[2] = roller("left", 1e-8 * 0.01);
        assert!(new(apart, angle).is_err(), "{angle}");
    }
    // a value that is only rounding of those beside it
    let mut rest = on_side("left", [Some(0.0), None]);
    let field = Field::function("0.01*(y - y0)", |[_, y, _], _| 0.01 * y + 1e-18);
    rest.components[0] = Some(field);
    let still = at_point([1.0, 0.0], [Some(0.0), None]);
    assert_eq!(new(vec![rest, still], 0.0).err(), None);
}

#[test]
fn an_oblique_condition_counts_beyond_those_that_hold_already() {
    // the wall of a wedge at 45° beside a vertical one: its normal is (−1, −1)/√2
    let mesh = rectangle(CellKind::Quad4, [1, 1])
        .map_points(|[x, y]| [x + y, y])
        .unwrap();
    let mut body = body(mesh);
    let new = |body: &Body<2>| supported(body, Analysis::PlaneStrain);
    body.supports = vec![on_side("bottom", [None, Some(0.2)]), roller("left", 0.1)];
    let constraints = new(&body).unwrap();
    // at (1, 0) both hold: u_y = 0.2 and (−u_x + u_y)/√2 = 0.1
    let held = constraints.at(node(&body.mesh, [1.0, 0.0]));
    assert_eq!(held.len(), 2);
    let u = held
        .iter()
        .fold([0.0; 2], |u, h| add_scaled(u, h.value, h.axis));
    near(u[1], 0.2, 1e-14);
    near((u[1] - u[0]) / 2f64.sqrt(), 0.1, 1e-14);
    near(held[1].axis[0], -1.0, 1e-14);
    // zero at all times only if its terms are
    assert_eq!([held[0].still, held[1].still], [false; 2]);
    let still = |first: f64, second: f64| {
        let mut body = body.clone();
        body.supports = vec![
            on_side("bottom", [None, Some(first)]),
            roller("left", second),
        ];
        let held = new(&body)
            .unwrap()
            .at(node(&body.mesh, [1.0, 0.0]))
            .to_vec();
        [held[0].still, held[1].still]
    };
    assert_eq!(still(0.0, 0.0), [true, true]);
    assert_eq!(still(0.0, 0.1), [true, false]);
    assert_eq!(still(0.2, 0.0), [false, false]);
    // perpendicular supports do not interact
    body.supports = vec![on_side("bottom", [Some(0.0), Some(0.2)])];
    let held = new(&body).unwrap().at(0).to_vec();
    assert_eq!([held[0].still, held[1].still], [true, false]);
}

#[test]
fn the_axis_of_symmetry_holds_without_a_support() {
    let mesh = rectangle(CellKind::Quad4, [2, 1])
        .map_points(|[x, y]| [x - 1.0, y])
        .unwrap();
    let mut body = body(mesh);
    let constraints = supported(&body, Analysis::Axisymmetric).unwrap();
    assert_eq!(constraints.nodes.len(), 2);
    for held in constraints.nodes.values() {
        let [h] = held.as_slice() else {
            panic!("one direction")
        };
        assert_eq!((h.axis, h.value, h.still), ([1.0, 0.0], 0.0, true));
        assert!(h.supports.is_empty());
    }
    assert!(
        supported(&body, Analysis::PlaneStrain)
            .unwrap()
            .nodes
            .is_empty()
    );
    body.supports = vec![on_side("left", [Some(0.1), None])];
    let Err(FemError::Contradiction { first, .. }) = supported(&body, Analysis::Axisymmetric)
    else {
        panic!("the axis cannot move");
    };
    assert_eq!(first, "by symmetry about the axis r = 0");
}

#[test]
fn the_nearest_node_is_no_farther_than_half_the_longest_edge_there() {
    // edges of 1 and 0.5 meet at the corner (1, 0)
    let mesh = rectangle(CellKind::Quad4, [2, 2]);
    let at = |x: Point<2>| nearest_node(&mesh, x, "support");
    assert_eq!(at([1.0, 0.0]), Ok(0));
    assert_eq!(at([0.5, 0.0]), Ok(0));
    assert!(at([0.5, -0.01]).is_err());
    assert_eq!(at([1.0, 0.2]), Ok(0));
    assert_eq!(at([2.9, 0.9]), Ok(node(&mesh, [3.0, 1.0])));
    let Err(FemError::NoNodeNear {
        what,
        node,
        distance,
        limit,
        ..
    }) = at([0.25, 0.0])
    else {
        panic!("it is 0.75 away");
    };
    assert_eq!(
        (what.as_str(), node, distance, limit),
        ("support", 0, 0.75, 0.5)
    );
    // however small the cells are
    let tiny = mesh.clone().map_points(|p| p.map(|c| 1e-3 * c)).unwrap();
    assert!(nearest_node(&tiny, [0.5e-3, 0.0], "support").is_ok());
    assert!(nearest_node(&tiny, [0.49e-3, 0.0], "support").is_err());
    // edges differ from cell to cell: at (3, 0) of the two groups they are 2 long
    let groups = groups();
    assert!(nearest_node(&groups, [4.0, 0.0], "support").is_ok());
    assert!(nearest_node(&groups, [-0.6, 0.0], "support").is_err());
    assert!(nearest_node(&groups, [1.0, -0.9], "support").is_ok());
}

#[test]
fn normals_at_corners_bisect() {
    let mesh =
        rectangle(CellKind::Quad4, [2, 1]).with_side("corner", |[x, y]| x == 3.0 || y == 1.0);
    let normals = node_normals(&body(mesh.clone()), "corner").unwrap();
    let root = 0.5f64.sqrt();
    let of = |x: Point<2>| normals[&node(&mesh, x)];
    assert_eq!(normals.len(), 4);
    assert_eq!((of([3.0, 0.0]), of([1.0, 1.0])), ([1.0, 0.0], [0.0, 1.0]));
    (0..2).for_each(|i| near(of([3.0, 1.0])[i], root, 1e-15));
}

#[test]
fn cells_map_areas_points_and_gradients() {
    assert_eq!(measure(Analysis::PlaneStrain, 0.5, [2.0, 0.0]), 0.5);
    assert_eq!(measure(Analysis::PlaneStress, 0.5, [2.0, 0.0]), 0.5);
    near(
        measure(Analysis::Axisymmetric, 0.5, [2.0, 0.0]),
        12.566_370_614_359_172,
        1e-14,
    );
    assert_eq!(measure(Analysis::Solid, 0.5, [2.0, 0.0, 0.0]), 1.0);
    for kind in [
        CellKind::Tri3,
        CellKind::Tri6,
        CellKind::Quad4,
        CellKind::Quad8,
    ] {
        // x = 1 + 2ξ + η, y = 3 − ξ + 2η: the area grows five times
        let table = CellTable::<2>::new(kind, 2);
        let nodes = kind.reference_nodes();
        let at = |n: usize| {
            let [xi, eta, _] = nodes[n];
            [1.0 + 2.0 * xi + eta, 3.0 - xi + 2.0 * eta]
        };
        let mut volume = 0.0;
        for q in 0..table.len() {
            let (point, gradients, part) = table.map(q, at);
            volume += part;
            let shape = table.shape(q);
            assert_eq!(shape.len(), kind.nodes());
            for (i, x) in point.iter().enumerate() {
                let image: f64 = (0..kind.nodes()).map(|n| shape[n] * at(n)[i]).sum();
                near(*x, image, 1e-14);
                for j in [0, 1] {
                    let slope: f64 = (0..kind.nodes()).map(|n| at(n)[i] * gradients[n][j]).sum();
                    near(slope, f64::from(u8::from(i == j)), 1e-14);
                }
            }
        }
        near(volume, 5.0 * kind.domain().volume(), 1e-13);
        let plane = stiffness_degree(kind, Analysis::PlaneStrain);
        assert_eq!(plane, kind.stiffness_degree());
        assert!(stiffness_degree(kind, Analysis::Axisymmetric) >= 2);
    }
    // one point serves a constant stress, but not a hoop strain
    assert!(stiffness_degree(CellKind::Tri3, Analysis::PlaneStrain) < 2);
    assert_eq!(stiffness_degree(CellKind::Tri3, Analysis::Axisymmetric), 2);
}

#[test]
fn stress_of_a_linear_field_is_the_same_at_every_node() {
    let h = [[0.3, -0.2, 0.15], [0.5, 0.1, -0.4], [0.2, 0.7, -0.6]];
    let strain = |i: usize, j: usize| 0.5 * (h[i][j] + h[j][i]);
    let trace = 0.3 + 0.1 - 0.6;
    let direct = |i: usize| LAMBDA * trace + 2.0 * MU * h[i][i];
    let shear = |i: usize, j: usize| 2.0 * MU * strain(i, j);
    let expected = [
        direct(0),
        direct(1),
        direct(2),
        shear(0, 1),
        shear(1, 2),
        shear(0, 2),
    ];
    for cell in CellKind::of_dimension(3) {
        let body = body(cuboid(cell));
        let points = body.mesh.points().iter();
        let u: Vec<Point<3>> = points
            .map(|x| std::array::from_fn(|i| dot(h[i], *x)))
            .collect();
        for stress in recover_stress(&body, Analysis::Solid, &u, 1.0).unwrap() {
            (0..6).for_each(|c| near(stress[c], expected[c], 1e-13));
        }
    }
    // with axial symmetry a tube that grows: u_r = 0.2 r, u_z = −0.1 z
    for cell in [
        CellKind::Tri3,
        CellKind::Tri6,
        CellKind::Quad4,
        CellKind::Quad8,
    ] {
        let body = body(rectangle(cell, [3, 2]));
        let u: Vec<Point<2>> = body
            .mesh
            .points()
            .iter()
            .map(|x| [0.2 * x[0], -0.1 * x[1]])
            .collect();
        let expected = [0.45 + 0.4, 0.45 - 0.2, 0.45 + 0.4, 0.0, 0.0, 0.0];
        for stress in recover_stress(&body, Analysis::Axisymmetric, &u, 1.0).unwrap() {
            (0..6).for_each(|c| near(stress[c], expected[c], 1e-13));
        }
    }
}

#[test]
fn stress_of_bending_is_linear_where_cells_are_quadratic() {
    // pure bending, ν = 0: σ_xx = E y is recovered at the nodes without an error
    for cell in [CellKind::Tri6, CellKind::Quad8] {
        let mut body = body(rectangle(cell, [3, 2]));
        body.materials[0].elastic.poisson = 0.0;
        let u: Vec<Point<2>> = (body.mesh.points().iter())
            .map(|x| [x[0] * x[1], -0.5 * x[0] * x[0]])
            .collect();
        let stress = recover_stress(&body, Analysis::PlaneStress, &u, 1.0).unwrap();
        for (stress, x) in stress.iter().zip(body.mesh.points()) {
            let expected = [2.6 * x[1], 0.0, 0.0, 0.0, 0.0, 0.0];
            (0..6).for_each(|c| near(stress[c], expected[c], 1e-12));
        }
    }
}

#[test]
fn stress_of_a_material_is_its_own_and_the_mean_by_volume_between_its_cells() {
    let material = |group: &str, young: f64| Material {
        group: Some(group.to_string()),
        elastic: Elastic {
            young,
            poisson: 0.0,
        },
        strength: None,
        plastic: None,
        ages: None,
    };
    let mut body = body(groups());
    body.materials = vec![material("a", 3.0), material("b", 9.0)];
    let u: Vec<Point<2>> = body.mesh.points().iter().map(|x| [x[0], 0.0]).collect();
    let along = |body: &Body<2>, u: &[Point<2>], expected: &[f64]| {
        let stress = recover_stress(body, Analysis::PlaneStress, u, 1.0).unwrap();
        assert_eq!(stress.len(), expected.len());
        let both = stress.iter().zip(expected);
        both.for_each(|(stress, expected)| near(stress[0], *expected, 1e-13));
    };
    // nodes 1 and 4 lie on the border: that of the first material there, those of the second behind all nodes
    along(&body, &u, &[3.0, 3.0, 9.0, 3.0, 3.0, 9.0, 9.0, 9.0]);
    let borders = Borders::of(&body).unwrap();
    assert_eq!([borders.place(0, 4), borders.place(1, 4)], [4, 7]);
    assert_eq!(
        borders.nodes().collect::<Vec<_>>(),
        [0, 1, 2, 3, 4, 5, 1, 4]
    );
    assert_eq!(
        borders.largest(&[0.0, 1.0, 0.0, 0.0, f64::NAN, 0.0, 0.5, 0.5]),
        [0, 1, 2, 3, 7, 5]
    );
    // two groups of one elasticity are one material: areas 1 and 2
    body.materials = vec![material("a", 3.0), material("b", 3.0)];
    let bent = |x: &Point<2>| [x[0] + 2.0 * (x[0] - 1.0).max(0.0), 0.0];
    let u: Vec<Point<2>> = body.mesh.points().iter().map(bent).collect();
    along(&body, &u, &[3.0, 7.0, 9.0, 3.0, 7.0, 9.0]);
    // with axial symmetry by that of the ring, 2πr at the samples: their mean radii are 1/2 and 2
    let ring = recover_stress(&body, Analysis::Axisymmetric, &u, 1.0).unwrap();
    let volumes = [0.5, 4.0];
    near(
        ring[1][0],
        (3.0 * volumes[0] + 9.0 * volumes[1]) / 4.5,
        1e-13,
    );
}

#[test]
fn von_mises_stress_counts_what_is_not_pressure() {
    near(von_mises([-7.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 7.0, 1e-15);
    near(von_mises([5.0, 5.0, 5.0, 0.0, 0.0, 0.0]), 0.0, 0.0);
    near(
        von_mises([0.0, 3.0, -1.0, 0.0, 0.0, 0.0]),
        13f64.sqrt(),
        1e-15,
    );
    for shear in 3..6 {
        let mut s = [0.0; 6];
        s[shear] = 2.0;
        near(von_mises(s), 12f64.sqrt(), 1e-15);
    }
}

#[test]
fn numbers_are_short_between_a_ten_thousandth_and_ten_millions() {
    let told = |x: f64| format!("{}", Short(x));
    assert_eq!(told(1e-4), "0.0001");
    assert_eq!(told(0.99e-4), "9.9e-5");
    assert_eq!(told(-9_999_990.0), "-9999990");
    assert_eq!(told(1e7), "1e7");
    // rounded first
    assert_eq!(
        (told(9_999_999.9), told(0.999_999_9), told(1.0 / 3.0)),
        ("1e7".into(), "1".into(), "0.333333".into())
    );
    assert_eq!((told(0.0), told(-0.0)), ("0".into(), "0".into()));
    assert_eq!(
        (told(f64::INFINITY), told(f64::NAN)),
        ("inf".into(), "NaN".into())
    );
}

#[test]
fn a_gauss_rule_has_at_least_one_point() {
    assert_eq!(quadrature::gauss(0), [(0.0, 2.0)]);
    assert_eq!(quadrature::gauss(0), quadrature::gauss(1));
}
