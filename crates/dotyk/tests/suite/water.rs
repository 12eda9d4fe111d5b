//! Water in pores: ground at rest, the same ground without water, and a water table that falls.
//!
//! Tolerance: rounding of a linear solve, 1e-9 of the largest value.

use crate::links::{near, refused, solved};
use dotyk::case::Case;

const ROUNDING: f64 = 1e-9;

/// A column of ground, 10 deep, between smooth walls; its sides by these loads, in these steps.
fn column(analysis: &str, keys: &str, rest: &str) -> String {
    format!(
        "analysis = \"{analysis}\"\n\
         [[body]]\nname = \"ground\"\n\
         mesh = {{ rectangle = {{ from = [0, -10], to = [2, 0], cells = [2, 10], cell = \"quad9\" }} }}\n\
         material = {{ young = 1e4, poisson = 0.3, strength = {{ cohesion = 2, friction_angle = 30 }} }}\n\
         fix = [{{ side = \"bottom\", y = 0 }}, {{ side = \"left\", x = 0 }}, {{ side = \"right\", x = 0 }}]\n{keys}\n{rest}"
    )
}

/// With water up to a level over time; the weight of grains and water is 20, that of water 9.81.
fn wet(analysis: &str, level: &str, rest: &str) -> String {
    let keys = format!(
        "body_force = [0, -20]\ninitial_stress = {{ vertical = \"10.19*y\", k0 = 0.5 }}\n\
         pore_pressure = {{ level = {level}, weight = 9.81 }}"
    );
    column(analysis, &keys, rest)
}

#[test]
fn wet_ground_is_at_rest_under_its_total_weight_and_as_strong_as_its_effective_stress() {
    for analysis in ["plane-strain", "axisymmetric"] {
        let dry = "body_force = [0, -10.19]\ninitial_stress = { vertical = \"10.19*y\", k0 = 0.5 }";
        let [dry, wet] =
            [column(analysis, dry, ""), wet(analysis, "0", "")].map(|text| solved(&text));
        let points = wet.0.bodies[0].mesh.points();
        let [dry, wet] = [&dry.1[0].bodies[0], &wet.1[0].bodies[0]];
        let utilised = |of: &dotyk::model::BodySolution<2>| of.utilisation.clone().unwrap().nodal;
        for (node, &[_, y]) in points.iter().enumerate() {
            assert!(wet.displacement[node].iter().all(|u| u.abs() < 1e-12));
            near(wet.stress[node][1], 20.0 * y, ROUNDING);
            near(wet.stress[node][0], 0.5 * 10.19 * y + 9.81 * y, ROUNDING);
            near(
                wet.pore_pressure.as_ref().unwrap()[node],
                -9.81 * y,
                ROUNDING,
            );
            near(utilised(wet)[node], utilised(dry)[node], ROUNDING);
        }
    }
}

/// The settlement of a layer between walls: the grains take what the water no longer bears, u = -int dp / M dy.
#[test]
fn ground_settles_as_its_water_table_falls() {
    let probes = "[[step]]\ntime = 0\n[[step]]\ntime = 1\n\
        [[probe]]\nname = \"settlement\"\nquantity = \"ground.displacement.y\"\nat = [1, 0]\n\
        [[probe]]\nname = \"water\"\nquantity = \"ground.pore_pressure\"\nat = [1, -7.5]\n\
        [[probe]]\nname = \"grains\"\nquantity = \"ground.effective_stress.yy\"\nat = [1, -7.5]\n\
        [[probe]]\nname = \"total\"\nquantity = \"ground.stress.yy\"\nat = [1, -7.5]\n";
    let (_, steps) = solved(&wet("plane-strain", "\"-5*t\"", probes));
    let modulus = 1e4 * 0.7 / (1.3 * 0.4);
    let value = |step: usize, probe: usize| steps[step].probes[probe].value;
    near(value(0, 0), 0.0, 1e-12);
    near(value(1, 0), -9.81 * 37.5 / modulus, ROUNDING);
    near(value(1, 1), 9.81 * 2.5, ROUNDING);
    near(value(1, 3), -150.0, 1e-8);
    near(value(1, 2), -150.0 + 9.81 * 2.5, 1e-8);
}

#[test]
fn in_space_as_in_the_plane() {
    let text = "analysis = \"3d\"\n\
        [[body]]\nname = \"ground\"\n\
        mesh = { box = { from = [0, 0, -4], to = [1, 1, 0], cells = [1, 1, 4] } }\n\
        material = { young = 1e4, poisson = 0.3 }\n\
        fix = [{ side = \"bottom\", z = 0 }, { side = [\"left\", \"right\"], x = 0 }, { side = [\"front\", \"back\"], y = 0 }]\n\
        body_force = [0, 0, -20]\ninitial_stress = { vertical = \"10.19*z\", k0 = 0.5 }\n\
        pore_pressure = { level = \"-2*t\", weight = 9.81 }\n\
        [[step]]\ntime = 0\n[[step]]\ntime = 1\n\
        [[probe]]\nname = \"settlement\"\nquantity = \"ground.displacement.z\"\nat = [0, 0, 0]\n";
    let model = Case::<3>::from_str(text, "water.toml", "".as_ref())
        .unwrap()
        .model;
    let steps = model.solve_steps().unwrap();
    let modulus = 1e4 * 0.7 / (1.3 * 0.4);
    near(steps[0].probes[0].value, 0.0, 1e-12);
    near(steps[1].probes[0].value, -9.81 * 6.0 / modulus, 1e-7);
}

#[test]
fn what_water_cannot_be_is_refused() {
    let says = |text: &str, words: &[&str]| {
        let error = refused(text).to_string();
        for word in words {
            assert!(error.contains(word), "{word}: {error}");
        }
    };
    says(&wet("plane-stress", "0", ""), &["plane stress", "water"]);
    says(
        &wet("plane-strain", "0", "").replace("weight = 9.81", "weight = -1"),
        &["`weight`"],
    );
    for level in ["\"1/x\"", "\"sqrt(x - 5)\""] {
        says(&wet("plane-strain", level, ""), &["ground", "not finite"]);
    }
    let probe = "[[probe]]\nname = \"p\"\nquantity = \"ground.pore_pressure\"\nat = [1, -1]\n";
    says(
        &column("plane-strain", "", probe),
        &["pore_pressure", "without water"],
    );
}
