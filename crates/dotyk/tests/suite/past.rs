//! Runs that go on behind steps that were solved before.

use dotyk::case::Case;
use dotyk::model::{Law, Past, PastNode};
use dotyk::prelude::*;
use std::path::PathBuf;

fn case(name: &str) -> Model<2> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../cases")
        .join(name);
    Case::<2>::read(&path)
        .unwrap_or_else(|e| panic!("{e}"))
        .model
}

fn silent(_: dotyk::model::Event) {}

fn forces(solution: &Solution<2>) -> Vec<f64> {
    let nodes = solution.contacts.iter().flat_map(|contact| &contact.nodes);
    let each = nodes.flat_map(|n| [n.pressure, n.shear[0], n.shear[1]].map(|t| t * n.weight));
    each.map(|force| if force.is_nan() { 0.0 } else { force })
        .collect()
}

/// Forces are relative to the largest, probes to the largest of their dimension in any step: the certificate knows gaps to 1e-8 of
/// the displacements and forces to ten times that, stresses at single points are worse than their largest by another digit.
fn assert_same(a: &Solution<2>, b: &Solution<2>, all: &[Solution<2>]) {
    let scale = forces(b).iter().fold(0.0, |s: f64, f| s.max(f.abs()));
    for (a, b) in forces(a).iter().zip(forces(b)) {
        assert!((a - b).abs() <= 1e-7 * scale, "{a} {b} of {scale}");
    }
    for (a, b) in a.probes.iter().zip(&b.probes) {
        let probes = all.iter().flat_map(|solution| &solution.probes);
        let alike = probes.filter(|probe| probe.dimension == b.dimension);
        let scale = alike.fold(0.0, |s: f64, probe| s.max(probe.value.abs()));
        let off = (a.value - b.value).abs();
        assert!(off <= 1e-6 * scale, "{}: {off} of {scale}", b.name);
    }
}

#[test]
fn a_run_that_goes_on_is_the_whole_run() {
    for name in [
        "friction-hysteresis/block_and_spring.toml",
        "friction-hysteresis/layer_non_matching.toml",
        "steps-clearance/rising_floor.toml",
        "cattaneo-mindlin/cycle.toml",
        "shrink-fit-pull/quad4_non_matching.toml",
        "tresca-and-coulomb/elastic_coulomb.toml",
    ] {
        let model = case(name);
        let whole = model.solve_steps().unwrap();
        for done in [1, whole.len() - 1] {
            let past: Vec<Past<2>> = whole[..done].iter().map(Past::from).collect();
            let on = model.solve_steps_after(&past, &mut silent);
            let on = on.unwrap_or_else(|e| panic!("{name}, {done}: {e}"));
            assert_eq!(on.len(), whole.len());
            for (step, (a, b)) in on.iter().zip(&whole).enumerate() {
                assert_same(a, b, &whole);
                if step < done {
                    assert_eq!(a.solver.iterations, b.solver.iterations);
                }
            }
        }
    }
}

#[test]
fn steps_of_another_model_are_refused() {
    let model = case("friction-hysteresis/block_and_spring.toml");
    let whole = model.solve_steps().unwrap();
    let past: Vec<Past<2>> = whole[..2].iter().map(Past::from).collect();
    let refused = |change: &dyn Fn(&mut Model<2>, &mut Vec<Past<2>>)| {
        let (mut model, mut past) = (model.clone(), past.clone());
        change(&mut model, &mut past);
        model
            .solve_steps_after(&past, &mut silent)
            .unwrap_err()
            .to_string()
    };
    let load = refused(&|model, _| model.bodies[0].body_force[1] = Field::constant(-0.3));
    assert!(
        load.starts_with("step 1 of the run before is not one of this model"),
        "{load}"
    );
    let friction = refused(&|model, _| {
        model.contacts[0].law = Law::Coulomb(Field::constant(0.01));
    });
    assert!(friction.contains("of the run before"), "{friction}");
    let body = refused(&|_, past| past[0].bodies[0].name = "other".to_string());
    assert!(body.contains("its bodies were other"), "{body}");
    let time = refused(&|_, past| past[1].time += 1e-3);
    assert!(
        time.contains("step 2") && time.contains("it was at t ="),
        "{time}"
    );
    let name = refused(&|_, past| past[0].contacts[0].0 = "other".to_string());
    assert!(name.contains("it has no contact"), "{name}");
    let nodes = refused(&|_, past| past[0].contacts[0].1.truncate(1));
    assert!(nodes.contains("had other nodes"), "{nodes}");
    for broken in [f64::NAN, f64::INFINITY] {
        let at = |past: &mut Vec<Past<2>>| past[0].contacts[0].1[1];
        let shear = refused(&|_, past| {
            past[0].contacts[0].1[1] = PastNode {
                shear: [broken, 0.0],
                ..at(past)
            };
        });
        let pressure = refused(&|_, past| {
            past[0].contacts[0].1[1] = PastNode {
                pressure: f64::INFINITY,
                ..at(past)
            };
        });
        for told in [shear, pressure] {
            assert!(told.contains("the force of contact"), "{told}");
        }
    }
    let all = refused(&|model, past| {
        model.times.truncate(1);
        past.truncate(1);
    });
    assert!(all.contains("all 1 steps were solved before"), "{all}");
    let more = refused(&|model, _| model.times.truncate(1));
    assert!(more.contains("the model has 1 steps"), "{more}");
}

/// Under given loads, stiffnesses that change together leave the contact forces as they are, and everything else not.
#[test]
fn a_step_of_other_stiffnesses_or_without_contact_is_refused() {
    let text = |young: f64, contact: &str| {
        // nothing keeps them apart without a contact
        let sole = if contact.is_empty() { 1.1 } else { 1.0 };
        format!(
            r#"analysis = "plane-strain"
[[body]]
name = "slab"
mesh = {{ rectangle = {{ from = [0, 0], to = [3, 1], cells = [12, 4] }} }}
material = {{ young = {young}, poisson = 0.25 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
load = [{{ side = "left", pressure = "t" }}]
[[body]]
name = "shoe"
mesh = {{ rectangle = {{ from = [1, {sole}], to = [2, 2], cells = [4, 4] }} }}
material = {{ young = {young}, poisson = 0.25 }}
fix = [{{ side = "top", x = 0, y = 0 }}]
{contact}
[[step]]
time = 1
[[step]]
time = 2
"#
        )
    };
    let pressed = "[[contact]]\nname = \"sole\"\nnonmortar = \"shoe.bottom\"\nmortar = \"slab.top\"\nfriction = 0.3";
    for contact in [pressed, ""] {
        let model = |young: f64| {
            let case = Case::<2>::from_str(&text(young, contact), "past.toml", "".as_ref());
            case.unwrap_or_else(|e| panic!("{e}")).model
        };
        let first = &model(1e3).solve_steps().unwrap()[..1];
        let past = [Past::from(&first[0])];
        let on = model(1e3).solve_steps_after(&past, &mut silent).unwrap();
        assert_eq!(on.len(), 2);
        let refused = model(2e3).solve_steps_after(&past, &mut silent);
        let refused = refused.unwrap_err().to_string();
        let told = refused.contains("was moved by") && refused.contains("now");
        assert!(
            told && refused.contains("step 1 of the run before"),
            "{refused}"
        );
    }
}

/// Forces of couples are not recorded: such steps are solved as they were, and the limit for the others is of the others.
#[test]
fn steps_with_couples_are_repeated() {
    let text = |extra: &str| {
        format!(
            r#"analysis = "plane-strain"
[[body]]
name = "slab"
mesh = {{ rectangle = {{ from = [0, 0], to = [3, 1], cells = [12, 4] }} }}
material = {{ young = 1e3, poisson = 0.25 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "shoe"
mesh = {{ rectangle = {{ from = [1, 1], to = [2, 2], cells = [5, 4] }} }}
material = {{ young = 1e3, poisson = 0.25 }}
points = {{ P = [1.4, 3] }}
couple = [{{ side = "top", point = "P", kind = "rigid" }}]
load = [{{ point = "P", force = ["0.4*t", -2], moment = 0.3 }}]
[[body]]
name = "wall"
mesh = {{ rectangle = {{ from = [10, 0], to = [11, 1], cells = [2, 2] }} }}
material = {{ young = 1e7, poisson = 0.25 }}
fix = [{{ side = "left", x = 0, y = 0 }}]
{extra}
[[contact]]
name = "sole"
nonmortar = "shoe.bottom"
mortar = "slab.top"
friction = 0.3
[[step]]
time = 0
[[step]]
time = 1
[[step]]
time = 1.2
"#
        )
    };
    let far = r#"points = { Q = [11, 0.5] }
couple = [{ side = "right", point = "Q", kind = "average" }]
load = [{ point = "Q", force = [1e5, 0] }]"#;
    for extra in ["", far] {
        let case = Case::<2>::from_str(&text(extra), "couples.toml", "".as_ref());
        let model = case.unwrap_or_else(|e| panic!("{e}")).model;
        let whole = model.solve_steps().unwrap();
        let mut past: Vec<Past<2>> = whole[..2].iter().map(Past::from).collect();
        let on = model.solve_steps_after(&past, &mut silent).unwrap();
        for (a, b) in on.iter().zip(&whole) {
            assert_eq!(a.solver.history, b.solver.history);
            assert_eq!(a.contacts, b.contacts);
        }
        let largest = past[1].contacts[0].1.iter().map(|node| node.pressure);
        let largest = largest.fold(0.0, f64::max);
        past[1].contacts[0].1[2].pressure += 1e-4 * largest;
        let refused = model.solve_steps_after(&past, &mut silent).unwrap_err();
        let told = refused.to_string();
        assert!(told.contains("the forces of contact \"sole\""), "{told}");
    }
}

/// A run goes on behind ground that nobody has touched, and behind steps in which supports of contacts came and went.
#[test]
fn runs_go_on_behind_rest_and_behind_supports_that_leave() {
    let ground = |law: &str| {
        format!(
            "title = \"Ground\"\nanalysis = \"plane-strain\"\n[[step]]\ntime = 0\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n\
             [[body]]\nname = \"rock\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [2, 3], cells = [3, 5], cell = \"tri3\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             initial_stress = {{ vertical = \"-0.1*(3.1 - y)\", k0 = 0.7 }}\nbody_force = [0, -0.1]\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0 }}, {{ side = \"left\", x = 0 }}]\n\
             load = [{{ side = \"top\", in_situ = 1 }}, {{ side = \"right\", in_situ = 1 }}]\n\
             [[body]]\nname = \"wall\"\nmesh = {{ rectangle = {{ from = [2, 0], to = [3, 3], cells = [2, 7], cell = \"quad9\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"right\", x = \"-0.0001*t\", y = \"-0.001*t\" }}]\n\
             [[contact]]\nname = \"joint\"\nnonmortar = \"wall.left\"\nmortar = \"rock.right\"\n{law}\n"
        )
    };
    let held = "title = \"Sole\"\nanalysis = \"plane-strain\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n\
         [[body]]\nname = \"base\"\nmesh = { rectangle = { from = [-1, 0], to = [3, 1], cells = [8, 2] } }\n\
         material = { young = 1000, poisson = 0 }\n\
         fix = [{ side = \"bottom\", x = \"0.01*t\", y = 0 }, { side = \"top\", y = 0, active = { until = 2 } }]\n\
         [[body]]\nname = \"block\"\nmesh = { rectangle = { from = [0, 1], to = [2, 2], cells = [4, 2] } }\n\
         material = { young = 1000, poisson = 0 }\nload = [{ side = \"top\", pressure = 1 }]\n\
         spring = [{ side = \"top\", tangential = 1, normal = 1e-3 }]\n\
         fix = [{ side = \"bottom\", x = 0, y = 0, active = { until = 2 } }]\n\
         [[contact]]\nname = \"sole\"\nnonmortar = \"block.bottom\"\nmortar = \"base.top\"\nfriction = 0.5\n";
    for text in [
        ground("friction = 0.3"),
        ground("friction = { coulomb = 0.3, cohesion = 1, tension = 0.5 }"),
        held.to_string(),
    ] {
        let model = Case::<2>::from_str(&text, "past.toml", "".as_ref())
            .unwrap()
            .model;
        let whole = model.solve_steps().unwrap();
        for done in 1..whole.len() {
            let past: Vec<Past<2>> = whole[..done].iter().map(Past::from).collect();
            let on = model.solve_steps_after(&past, &mut silent);
            let on = on.unwrap_or_else(|e| panic!("{done}: {e}\n{text}"));
            for (a, b) in on.iter().zip(&whole) {
                assert_same(a, b, &whole);
            }
        }
    }
}

/// Where several answers exist, the recorded one goes on: a joint that parts at a node within the step, a block that hovers beside a bound
/// which bears shear whether the sides touch or not.
#[test]
fn a_run_goes_on_where_the_recorded_answer_is_one_of_several() {
    let ground = "[[body]]\nname = \"ground\"\n\
         mesh = { rectangle = { from = [-2, -2], to = [4, 0], cells = [12, 4], cell = \"quad8\" } }\n\
         material = { young = 2000, poisson = 0.4 }\n\
         spring = [{ side = \"bottom\", normal = 500, tangential = 300 }]\nbody_force = [0, \"-1 - 0.5*t\"]\n";
    let block = "[[body]]\nname = \"block\"\n\
         mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [4, 4], cell = \"quad8\" } }\n\
         material = { young = 8000, poisson = 0.2 }\n";
    let contact =
        "[[contact]]\nname = \"joint\"\nnonmortar = \"block.bottom\"\nmortar = \"ground.top\"\n";
    let parts = |heat: f64, falls: f64, law: [f64; 3]| {
        let [coulomb, cohesion, tension] = law;
        format!(
            "{ground}{block}initial_strain = {{ thermal = \"-{heat}*t*(1 - {falls}*y)\", expansion = 1e-4 }}\n\
             {contact}friction = {{ coulomb = {coulomb}, cohesion = {cohesion}, tension = {tension} }}\n"
        )
    };
    let hovers = format!(
        "{ground}{block}fix = [{{ side = \"left\", normal = \"-0.001*t\", active = {{ until = 2 }} }}]\n\
         {contact}friction = {{ tresca = 5 }}\n"
    );
    for (text, told) in [
        (parts(19.8, 0.03, [0.33, 2.0, 1.6]), "has parted there"),
        (parts(11.0, 0.87, [0.78, 3.0, 1.6]), "has parted there"),
        (parts(35.4, 0.6, [0.77, 3.6, 0.6]), "has parted there"),
        (hovers, "although its sides stay"),
    ] {
        let steps =
            "analysis = \"plane-strain\"\nstep = [{ time = 1 }, { time = 2 }, { time = 3 }]\n";
        let model = Case::<2>::from_str(&format!("{steps}{text}"), "past.toml", "".as_ref());
        let model = model.unwrap().model;
        let whole = model.solve_steps().unwrap();
        let mut warnings = whole.iter().flat_map(|step| &step.warnings);
        assert!(warnings.any(|words| words.contains(told)), "{text}");
        for done in 1..whole.len() {
            let past: Vec<Past<2>> = whole[..done].iter().map(Past::from).collect();
            let on = model.solve_steps_after(&past, &mut silent);
            let on = on.unwrap_or_else(|e| panic!("{done}: {e}\n{text}"));
            for (a, b) in on.iter().zip(&whole) {
                assert_same(a, b, &whole);
            }
        }
    }
}
