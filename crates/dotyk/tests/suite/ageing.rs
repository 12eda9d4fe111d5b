//! Young's modulus that changes with time: the stress stays, and grows with the modulus of each step.
//!
//! Tolerance: rounding of linear solves, 1e-9 of the largest value, where nothing else is told.

use crate::links::{near, refused, solved};
use dotyk::case::Case;
use dotyk::model::{Past, Solution};

/// A bar along x with E = 10, 20, 40 at t = 1, 2, 3, held at its left end, and free to contract.
fn bar(keys: &str, more: &str) -> String {
    format!(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"bar\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [4, 1], cells = [4, 2], cell = \"quad8\" }} }}\n\
         material = {{ young = \"5*2^t\", poisson = 0.25 }}\n\
         fix = [{{ side = \"left\", x = 0 }}, {{ side = \"bottom\", y = 0 }}]\n{keys}\n\
         [[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n{more}"
    )
}

/// Lengthening and stress along x of the bar after each step.
fn lengthening(text: &str) -> Vec<[f64; 2]> {
    let (model, steps) = solved(text);
    let points = model.bodies[0].mesh.points();
    let end = points.iter().position(|x| *x == [4.0, 0.0]).unwrap();
    steps
        .iter()
        .map(|step| {
            let body = &step.bodies[0];
            [body.displacement[end][0], body.stress[end][0]]
        })
        .collect()
}

#[test]
fn each_increment_of_a_load_meets_the_modulus_of_its_step() {
    let text = bar(
        "load = [{ side = \"right\", traction = [\"0.3*t\", 0] }]",
        "",
    );
    let plane = 1.0 - 0.25_f64.powi(2);
    let mut u = 0.0;
    for (step, [found, stress]) in lengthening(&text).into_iter().enumerate() {
        u += 4.0 * 0.3 * plane / (10.0 * 2.0_f64.powi(step as i32));
        near(found, u, 1e-9);
        near(stress, 0.3 * (step + 1) as f64, 1e-9);
    }
}

#[test]
fn what_is_held_keeps_its_stress_when_it_hardens() {
    // stretched in the first step alone; the modulus of later ones changes nothing
    let held = "fix = [{ side = \"left\", x = 0 }, { side = \"bottom\", y = 0 }, { side = \"right\", x = \"0.4*min(t, 1)\" }]";
    let text = bar("", "").replace(
        "fix = [{ side = \"left\", x = 0 }, { side = \"bottom\", y = 0 }]",
        held,
    );
    let stress = 10.0 * 0.1 / (1.0 - 0.25_f64.powi(2));
    for [u, found] in lengthening(&text) {
        near(u, 0.4, 1e-12);
        near(found, stress, 1e-9);
    }
}

/// Shrinkage while it hardens: each increment of free strain meets the modulus of its step.
#[test]
fn a_free_strain_grows_while_the_modulus_does() {
    let text = bar(
        "initial_strain = { xx = \"-0.01*t\", yy = \"-0.01*t\", zz = \"-0.01*t\" }",
        "",
    )
    .replace(
        "{ side = \"bottom\", y = 0 }]",
        "{ side = \"bottom\", y = 0 }, { side = \"right\", x = 0 }]",
    );
    let mut stress = 0.0;
    for (step, [_, found]) in lengthening(&text).into_iter().enumerate() {
        // of a strain alike in all directions, held along x and out of the plane
        stress += 10.0 * 2.0_f64.powi(step as i32) * 0.01 / (1.0 - 0.25);
        near(found, stress, 1e-9);
    }
}

/// Lamé's tube in all analyses and cells: the displacement is a sum over increments, the stress that of the whole pressure.
#[test]
fn a_tube_that_hardens_is_a_sum_of_increments() {
    let (inner, outer, nu) = (1.0_f64, 2.0_f64, 0.3);
    let moves = |e: f64, p: f64| {
        // plane strain, at the inner radius
        let (a2, b2) = (inner * inner, outer * outer);
        p * inner * (1.0 + nu) / (e * (b2 - a2)) * ((1.0 - 2.0 * nu) * a2 + b2)
    };
    let plane = "analysis = \"plane-strain\"\n[[body]]\nname = \"tube\"\nmesh = { ring = { inner = 1, outer = 2, from = 0, to = 90, cells = [12, 16], cell = \"CELL\" } }\n\
         fix = [{ side = \"start\", normal = 0 }, { side = \"end\", normal = 0 }]\nload = [{ side = \"inner\", pressure = \"t\" }]\n";
    let round = "analysis = \"axisymmetric\"\n[[body]]\nname = \"tube\"\nmesh = { rectangle = { from = [1, 0], to = [2, 0.5], cells = [16, 2], cell = \"CELL\" } }\n\
         fix = [{ side = \"bottom\", y = 0 }, { side = \"top\", y = 0 }]\nload = [{ side = \"left\", pressure = \"t\" }]\n";
    for base in [plane, round] {
        for cell in ["quad8", "quad9", "tri6"] {
            let text = format!(
                "{}material = {{ young = \"100*(1 + t)\", poisson = {nu} }}\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 4\n",
                base.replace("CELL", cell)
            );
            let (model, steps) = solved(&text);
            let points = model.bodies[0].mesh.points();
            let place = points.iter().position(|x| *x == [1.0, 0.0]).unwrap();
            let mut u = 0.0;
            for (step, (e, p)) in steps.iter().zip([(200.0, 1.0), (300.0, 1.0), (500.0, 2.0)]) {
                u += moves(e, p);
                // cells of second order on the circle: 3e-5
                near(step.bodies[0].displacement[place][0] / u, 1.0, 1e-4);
                let radial = step.bodies[0].stress[place][0];
                // at the rim, recovered: 1 %
                near(radial / step.time, -1.0, 2e-2);
            }
        }
    }
}

/// A lining in a bore, in contact with friction, that hardens while the ground is loaded: steps in which neither load nor modulus changes
/// change nothing, and a run that goes on from its middle is the whole run.
#[test]
fn steps_without_a_change_change_nothing() {
    let text = |times: &[f64]| {
        let steps: String = times
            .iter()
            .map(|t| format!("[[step]]\ntime = {t}\n"))
            .collect();
        format!(
            "analysis = \"plane-strain\"\n\
             [[body]]\nname = \"rock\"\nmesh = {{ ring = {{ inner = 2, outer = 8, from = 0, to = 90, cells = [12, 8], cell = \"quad8\" }} }}\n\
             material = {{ young = 1000, poisson = 0.25 }}\n\
             fix = [{{ side = \"start\", normal = 0 }}, {{ side = \"end\", normal = 0 }}]\n\
             load = [{{ side = \"outer\", traction = [\"-max(0, min(t - 1, 2))*x/8\", \"-0.5*max(0, min(t - 1, 2))*y/8\"] }}]\n\
             [[body]]\nname = \"lining\"\nmesh = {{ ring = {{ inner = 1.7, outer = 2, from = 0, to = 90, cells = [14, 2], cell = \"quad8\" }} }}\n\
             material = {{ young = \"2000*(1 + min(2, max(0, t - 1)))\", poisson = 0.2 }}\n\
             fix = [{{ side = \"start\", normal = 0 }}, {{ side = \"end\", normal = 0 }}]\n\
             [[contact]]\nname = \"joint\"\nsides = [\"rock.inner\", \"lining.outer\"]\nfriction = 0.3\n{steps}"
        )
    };
    let (_, few) = solved(&text(&[1.0, 2.0, 3.0]));
    let (_, many) = solved(&text(&[1.0, 1.9, 2.0, 3.0, 3.5, 4.0]));
    let last = |steps: &[Solution<2>]| steps.last().unwrap().clone();
    let (few, many) = (last(&few), last(&many));
    assert!(few.contacts[0].resultant[0].abs() > 0.1);
    // the load of 1.9 meets the modulus of the first step, so the answers differ; the last steps change nothing
    let (_, up_to_three) = solved(&text(&[1.0, 1.9, 2.0, 3.0]));
    let reference = last(&up_to_three);
    for (a, b) in many.bodies.iter().zip(&reference.bodies) {
        for (a, b) in a.displacement.iter().zip(&b.displacement) {
            // of displacements of some 1e-3
            near(1e3 * a[0], 1e3 * b[0], 1e-9);
            near(1e3 * a[1], 1e3 * b[1], 1e-9);
        }
    }
    assert_ne!(few.bodies[1].displacement, reference.bodies[1].displacement);
    let (model, whole) = solved(&text(&[1.0, 1.9, 2.0, 3.0]));
    let past: Vec<Past<2>> = whole[..2].iter().map(Past::from).collect();
    let on = model.solve_steps_after(&past, &mut |_| {}).unwrap();
    for (a, b) in last(&on).bodies.iter().zip(&last(&whole).bodies) {
        assert_eq!(a.inelastic.is_some(), a.name == "lining");
        for (a, b) in a.displacement.iter().zip(&b.displacement) {
            near(1e3 * a[0], 1e3 * b[0], 1e-9);
        }
    }
}

#[test]
fn in_space_an_ageing_block_is_the_bar_of_the_plane() {
    let text = "analysis = \"3d\"\n\
         [[body]]\nname = \"bar\"\n\
         mesh = { box = { from = [0, 0, 0], to = [4, 1, 1], cells = [4, 2, 1], cell = \"hex20\" } }\n\
         material = { young = \"5*2^t\", poisson = 0.25 }\n\
         fix = [{ side = \"left\", x = 0 }, { side = \"front\", y = 0 }, { side = \"bottom\", z = 0 }]\n\
         load = [{ side = \"right\", traction = [\"0.3*t\", 0, 0] }]\n[[step]]\ntime = 1\n[[step]]\ntime = 3\n";
    let model = Case::<3>::from_str(text, "ageing.toml", "".as_ref())
        .unwrap()
        .model;
    let steps = model.solve_steps().unwrap();
    assert!(steps.iter().all(|step| step.converged));
    let points = model.bodies[0].mesh.points();
    let end = points.iter().position(|x| *x == [4.0, 0.0, 0.0]).unwrap();
    for (step, u) in steps.iter().zip([0.12, 0.12 + 4.0 * 0.6 / 40.0]) {
        near(step.bodies[0].displacement[end][0], u, 1e-9);
        near(step.bodies[0].stress[end][0], 0.3 * step.time, 1e-9);
    }
}

#[test]
fn a_modulus_that_is_none_is_refused() {
    let text = bar(
        "load = [{ side = \"right\", traction = [\"0.3*t\", 0] }]",
        "",
    );
    for (from, to, words) in [
        ("5*2^t", "2 - t", "`young` = 2 - t is 0 at t = 2"),
        ("5*2^t", "sqrt(2 - t)", "at t = 2"),
        ("5*2^t", "1 + x", "`x`"),
        (
            "plane-strain",
            "plane-stress",
            "not supported yet in plane stress",
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25, strength = { yield = 1 }, plastic = true",
            "of a body that yields",
        ),
    ] {
        let error = refused(&text.replace(from, to)).to_string();
        assert!(error.contains(words), "{to}: {error}");
    }
}

/// A bar that ages beside a block that yields, and that it does not touch.
#[test]
fn what_yields_leaves_the_stress_of_what_ages() {
    let other = "[[body]]\nname = \"metal\"\n\
        mesh = { rectangle = { from = [9, 0], to = [10, 1], cells = [2, 2], cell = \"quad9\" } }\n\
        material = { young = 1000, poisson = 0, strength = { yield = 6 }, plastic = true, hardening = 100 }\n\
        fix = [{ side = \"bottom\", y = 0 }, { point = [9, 0], x = 0 }]\n\
        load = [{ side = \"top\", traction = [0, \"-q\"] }]";
    let load = "load = [{ side = \"right\", traction = [\"0.3*t\", 0] }]";
    let alone = lengthening(&bar(load, ""));
    for q in ["3", "4*t"] {
        let beside = lengthening(&bar(load, &other.replace("-q", &format!("-{q}"))));
        for (beside, alone) in beside.iter().zip(&alone) {
            near(beside[0], alone[0], 1e-9);
            near(beside[1], alone[1], 1e-9);
        }
    }
}

/// A loose block between rollers that swells and shrinks as it ages, free of stress at all times, above a floor that it does not touch.
#[test]
fn what_ages_without_stress_hovers() {
    let (_, steps) = solved(
        "analysis = \"plane-strain\"\nstep = [{ time = 1 }, { time = 2 }]\n\
         [[body]]\nname = \"floor\"\n\
         mesh = { rectangle = { from = [0, 0], to = [1, 0.5], cells = [4, 3], cell = \"quad4\" } }\n\
         material = { young = 3000, poisson = 0 }\nfix = [{ side = \"bottom\", x = 0, y = 0 }]\n\
         [[body]]\nname = \"block\"\n\
         mesh = { rectangle = { from = [0, 0.5], to = [1, 1.3], cells = [4, 3], cell = \"quad4\" } }\n\
         material = { young = \"400 + 500*(t - 1)\", poisson = 0 }\n\
         fix = [{ side = \"left\", x = 0 }, { side = \"right\", x = 0 }]\n\
         initial_strain = { yy = \"-0.002*(2 - t)\" }\n\
         [[contact]]\nname = \"gap\"\nnonmortar = \"floor.top\"\nmortar = \"block.bottom\"\ngap = -0.003\n",
    );
    for step in &steps {
        let nodes = &step.contacts[0].nodes;
        assert!(nodes.iter().all(|node| node.pressure == 0.0));
        let stress = step.bodies[1].stress.iter().flatten();
        let largest = stress.fold(0.0, |s: f64, c| s.max(c.abs()));
        assert!(largest < 1e-12, "{largest:e}");
    }
}
