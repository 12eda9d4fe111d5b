//! Utilisation of strengths: uniform states in every analysis, Kirsch's plate, and what is told of it.

use dotyk::geometry::{Field, Point};
use dotyk::mesh::{CellKind, Cuboid, Diagonals, Mesh, Rectangle, Ring};
use dotyk::model::{Analysis, Elastic, Load, Model, Reading, Solution, Strength};
use std::f64::consts::PI;

const ROCK: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.25,
};

const COULOMB: Strength = Strength::MohrCoulomb {
    friction_angle: 30.0,
    cohesion: 2.0,
    tension: None,
};

fn block(cell: CellKind) -> Mesh<2> {
    let rectangle = Rectangle {
        from: [1.0, 0.0],
        to: [3.0, 1.0],
        cells: [3, 2],
        cell,
        diagonals: Diagonals::Forward,
    };
    let bent = |[x, y]: Point<2>| {
        let bump = (x - 1.0) * (3.0 - x) * y * (1.0 - y);
        [x + 0.2 * bump, y - 0.15 * bump]
    };
    rectangle.build().unwrap().map_points(bent).unwrap()
}

/// Uniform stresses to rounding: nine digits are more than enough to tell formulae apart.
fn close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-9 * expected.abs().max(1.0),
        "{found} {expected}"
    );
}

/// A block under a pressure on its top, on rollers beneath, free or held aside; every node has this utilisation.
fn uniform(
    analysis: Analysis,
    cell: CellKind,
    held: bool,
    strength: Strength,
    expected: f64,
) -> Solution<2> {
    let mut model = Model::<2>::new();
    model.analysis = analysis;
    let body = model.body("block", block(cell), ROCK);
    model.bodies[0].materials[0].strength = Some(strength);
    model.roller(body, "bottom", 0.0).press(body, "top", 6.0);
    model.roller(body, "left", 0.0);
    if held {
        model.roller(body, "right", 0.0);
    }
    for (name, reading) in [
        ("at", Reading::At([1.9, 0.4])),
        ("max", Reading::Largest),
        ("mean", Reading::Mean),
    ] {
        model.probe(name, "block.utilisation", reading).unwrap();
    }
    let solution = model.solve().unwrap();
    let own = solution.bodies[0].utilisation.as_ref().unwrap();
    own.nodal.iter().for_each(|&u| close(u, expected));
    solution
        .probes
        .iter()
        .for_each(|probe| close(probe.value, expected));
    close(own.judged, 2.0);
    solution
}

#[test]
fn uniform_stress_has_the_utilisation_of_all_three_principal_stresses() {
    for cell in [
        CellKind::Tri3,
        CellKind::Tri6,
        CellKind::Quad4,
        CellKind::Quad8,
        CellKind::Quad9,
    ] {
        // plane strain, free aside: σ_zz = ν p = 1.5, σ_xx = 0: uniaxial strength 2 c √3 = 6.928
        let solution = uniform(
            Analysis::PlaneStrain,
            cell,
            false,
            COULOMB,
            6.0 / (4.0 * 3f64.sqrt()),
        );
        assert_eq!(
            solution.bodies[0]
                .utilisation
                .as_ref()
                .unwrap()
                .overstressed,
            0.0
        );
        // held aside: both others are ν/(1 − ν) p = 2
        uniform(
            Analysis::PlaneStrain,
            cell,
            true,
            COULOMB,
            4.0 / (4.0 + 4.0 * 3f64.sqrt()),
        );
        // von Mises in plane stress, twice the yield stress: all of it is overstressed, the area without thickness
        let steel = Strength::VonMises { yield_stress: 3.0 };
        let solution = uniform(Analysis::PlaneStress, cell, false, steel, 2.0);
        close(
            solution.bodies[0]
                .utilisation
                .as_ref()
                .unwrap()
                .overstressed,
            2.0,
        );
    }
}

#[test]
fn the_hoop_stress_counts_with_axial_symmetry() {
    // a tube 1 to 3 under an outer pressure p, ends free: Lamé: at the bore σ_θ = 2 p b²/(b² − a²) = 2.25 p, σ_r = σ_z = 0
    let mut model = Model::<2>::new();
    model.analysis = Analysis::Axisymmetric;
    let mesh = Rectangle {
        from: [1.0, 0.0],
        to: [3.0, 1.0],
        cells: [32, 2],
        cell: CellKind::Quad9,
        diagonals: Diagonals::Forward,
    };
    let body = model.body("tube", mesh.build().unwrap(), ROCK);
    model.bodies[0].materials[0].strength = Some(Strength::Principal {
        tension: 1.0,
        compression: 18.0,
    });
    model.roller(body, "bottom", 0.0).press(body, "right", 4.0);
    let solution = model.solve().unwrap();
    let own = solution.bodies[0].utilisation.as_ref().unwrap();
    let peak = own.peak.unwrap().most;
    // recovered stress at the boundary: O((h/a)²) of the largest, h/a = 1/16
    assert!((peak.value - 9.0 / 18.0).abs() < 0.004 * 0.5, "{peak:?}");
    assert_eq!(peak.at[0], 1.0);
    // the area is that of the section, not 2πr times it
    close(own.judged, 2.0);
}

#[test]
fn volumes_of_space_are_overstressed() {
    for cell in [
        CellKind::Tet4,
        CellKind::Tet10,
        CellKind::Hex8,
        CellKind::Hex20,
        CellKind::Hex27,
        CellKind::Prism6,
        CellKind::Prism15,
    ] {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [1.0, 2.0, 1.5],
            cells: [2, 2, 2],
            cell,
        };
        let mut model = Model::<3>::new();
        let body = model.body("block", cuboid.build().unwrap(), ROCK);
        model.bodies[0].materials[0].strength = Some(COULOMB);
        for side in ["left", "front", "bottom"] {
            model.roller(body, side, 0.0);
        }
        // compressions 2, 1 and 12: 11/(2 · 1 + 4 √3)
        for (side, pressure) in [("right", 2.0), ("back", 1.0), ("top", 12.0)] {
            model.press(body, side, pressure);
        }
        let solution = model.solve().unwrap();
        let own = solution.bodies[0].utilisation.as_ref().unwrap();
        own.nodal
            .iter()
            .for_each(|&u| close(u, 11.0 / (2.0 + 4.0 * 3f64.sqrt())));
        close(own.overstressed, 3.0);
        close(own.judged, 3.0);
    }
}

/// Kirsch: radial, hoop and shear stress at (r, θ) under a tension 1 along x, a = 1.
fn kirsch(r: f64, angle: f64) -> [f64; 3] {
    let (a, cosine, sine) = (1.0 / (r * r), (2.0 * angle).cos(), (2.0 * angle).sin());
    [
        0.5 * (1.0 - a) + 0.5 * (1.0 - 4.0 * a + 3.0 * a * a) * cosine,
        0.5 * (1.0 + a) - 0.5 * (1.0 + 3.0 * a * a) * cosine,
        -0.5 * (1.0 + 2.0 * a - 3.0 * a * a) * sine,
    ]
}

/// A quarter of the plate, 1 ≤ r ≤ 3, with the exact tractions around it, in plane stress, that yields at 1.5.
fn plate(n: usize, cell: CellKind) -> Solution<2> {
    let ring = Ring {
        center: [0.0; 2],
        inner: 1.0,
        outer: 3.0,
        angles: Some([0.0, 90.0]),
        cells: [n, n],
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    let mut model = Model::<2>::new();
    model.analysis = Analysis::PlaneStress;
    let body = model.body("plate", ring.build().unwrap(), ROCK);
    model.bodies[0].materials[0].strength = Some(Strength::VonMises { yield_stress: 1.5 });
    // without any influence on the area
    model.bodies[0].thickness = 0.1;
    model.roller(body, "start", 0.0).roller(body, "end", 0.0);
    let traction = [0, 1].map(|axis| {
        Field::function("Kirsch", move |[x, y, _], _| {
            let angle = y.atan2(x);
            let [radial, _, shear] = kirsch(3.0, angle);
            match axis {
                0 => radial * angle.cos() - shear * angle.sin(),
                _ => radial * angle.sin() + shear * angle.cos(),
            }
        })
    });
    let side = "outer".to_string();
    model.load(body, Load::Traction { side, traction });
    model.solve().unwrap()
}

/// The area of that quarter where von Mises' stress of the exact solution exceeds 1.5: midpoints of a fine polar grid, to 1e-5.
fn exact_area() -> f64 {
    let (around, out) = (3000, 6000);
    let mut area = 0.0;
    for i in 0..around {
        let angle = 0.5 * PI * (i as f64 + 0.5) / around as f64;
        for j in 0..out {
            let r = 1.0 + 2.0 * (j as f64 + 0.5) / out as f64;
            let [s, t, shear] = kirsch(r, angle);
            if s * s + t * t - s * t + 3.0 * shear * shear > 2.25 {
                area += r;
            }
        }
    }
    area * (0.5 * PI / around as f64) * (2.0 / out as f64)
}

#[test]
fn overstressed_area_converges_to_that_of_kirsch() {
    let exact = exact_area();
    assert!((exact - 0.24396).abs() < 2e-5, "{exact}");
    // recovered stress is of the second order, at the boundary of linear cells of the first
    for (cell, rate, limit) in [
        (CellKind::Tri3, 0.9, 0.08),
        (CellKind::Quad4, 0.9, 0.08),
        (CellKind::Tri6, 1.7, 0.01),
        (CellKind::Quad8, 1.7, 0.01),
        (CellKind::Quad9, 1.7, 0.01),
    ] {
        let errors = [10, 20, 40].map(|n| {
            let solution = plate(n, cell);
            let own = solution.bodies[0].utilisation.as_ref().unwrap();
            own.overstressed / exact - 1.0
        });
        let found = (errors[0] / errors[2]).abs().log2() / 2.0;
        println!("{cell:?} {errors:?} {found}");
        assert!(
            found > rate && errors[2].abs() < limit,
            "{cell:?} {errors:?} {found}"
        );
    }
}
