//! Displacements that count from a load step: the difference to the end of the step before, in every result, and nothing else.

use crate::friction::Random;
use crate::links::near;
use dotyk::case::Case;
use dotyk::model::{Past, Solution};

/// A block on a floor with friction, a lid that comes later with a couple, a tool that moves, a bed, and ground with an in-situ stress; times 1 to 5.
fn text(zeroed: &[usize], more: &str) -> String {
    let steps: String = (1..=5)
        .map(|k| {
            let anew = zeroed.contains(&k);
            format!("[[step]]\ntime = {k}\nzero_displacements = {anew}\n")
        })
        .collect();
    format!(
        r#"analysis = "plane-strain"
[[body]]
name = "base"
mesh = {{ rectangle = {{ from = [-1, -2], to = [3, 0], cells = [8, 4] }} }}
material = {{ young = 100, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "block"
mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [5, 3], cell = "quad9" }} }}
material = {{ young = 80, poisson = 0.2 }}
load = [{{ side = "right", traction = ["-0.2*sin(t)", 0] }}, {{ side = "top", pressure = "1 + 0.2*t" }}]
[[body]]
name = "lid"
active = {{ from = 3 }}
mesh = {{ rectangle = {{ from = [0, 1], to = [2, 1.5], cells = [4, 2] }} }}
material = {{ young = 50, poisson = 0.3 }}
points = {{ p = [1, 2] }}
couple = [{{ side = "top", point = "p", kind = "rigid" }}]
load = [{{ point = "p", force = ["0.1*t", "-0.5*t"] }}]
[[body]]
name = "late"
active = {{ from = 4 }}
mesh = {{ rectangle = {{ from = [-1, 0], to = [-0.5, 0.5], cells = [2, 2] }} }}
material = {{ young = 50, poisson = 0.3 }}
body_force = [0, "-t"]
[[contact]]
name = "floor"
nonmortar = "block.bottom"
mortar = "base.top"
friction = 0.4
[[contact]]
name = "glue"
nonmortar = "lid.bottom"
mortar = "block.top"
tied = true
[[contact]]
name = "foot"
nonmortar = "late.bottom"
mortar = "base.top"
friction = 0.3
[[contact]]
name = "tool"
nonmortar = "block.left"
obstacle = {{ gap = 0.2, displacement = ["0.205 + 0.001*t", 0] }}
[[probe]]
name = "u"
quantity = "block.displacement.y"
at = [1, 1]
[[probe]]
name = "s"
quantity = "block.stress.yy"
at = [1, 0.5]
{steps}{more}"#
    )
}

fn solved(text: &str) -> (Case<2>, Vec<Solution<2>>) {
    let case =
        Case::<2>::from_str(text, "zeroed.toml", "".as_ref()).unwrap_or_else(|e| panic!("{e}"));
    let steps = case.model.solve_steps().unwrap_or_else(|e| panic!("{e}"));
    (case, steps)
}

fn off(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

#[test]
fn displacements_are_differences_and_all_else_stays() {
    let (_, plain) = solved(&text(&[], ""));
    for zeroed in [&[2][..], &[3], &[4], &[2, 4], &[1, 5], &[1]] {
        let (case, steps) = solved(&text(zeroed, ""));
        for (k, (now, before)) in steps.iter().zip(&plain).enumerate() {
            // the last of them that has come, and whose step is not the first
            let from = zeroed
                .iter()
                .copied()
                .filter(|&z| z > 1 && z <= k + 1)
                .max();
            let then = from.map(|z| &plain[z - 2]);
            assert_eq!(
                now.counted_from,
                then.map(|then| then.time),
                "{zeroed:?} {k}"
            );
            for (body, same) in now.bodies.iter().zip(&before.bodies) {
                assert_eq!(body.stress, same.stress);
                assert_eq!(body.reactions, same.reactions);
                let own = then.and_then(|then| then.bodies.iter().find(|b| b.name == body.name));
                let nodes = body.displacement.iter().zip(&same.displacement).enumerate();
                for (node, (u, all)) in nodes {
                    let z = own.map_or([0.0; 2], |own| own.displacement[node]);
                    assert!(off(*u, [all[0] - z[0], all[1] - z[1]]) < 1e-15);
                }
                // the rigid part is linear in the displacements
                let z = own.map_or([0.0; 3], |own| {
                    let [x, y] = own.rigid.translation;
                    [x, y, own.rigid.rotation[0]]
                });
                let [x, y] = same.rigid.translation;
                let moved = [x - z[0], y - z[1]];
                assert!(off(body.rigid.translation, moved) < 1e-14);
                let turned = same.rigid.rotation[0] - z[2];
                assert!((body.rigid.rotation[0] - turned).abs() < 1e-14);
                for (j, (point, all)) in body.couples.iter().zip(&same.couples).enumerate() {
                    let z = own.map_or([0.0; 2], |own| own.couples[j].displacement);
                    let a = own.map_or(0.0, |own| own.couples[j].rotation[0]);
                    let [x, y] = all.displacement;
                    assert!(off(point.displacement, [x - z[0], y - z[1]]) < 1e-15);
                    assert!((point.rotation[0] - (all.rotation[0] - a)).abs() < 1e-15);
                }
                // in pictures the bodies stand beside each other as they did, less the earlier places
                let shown = |s: &dotyk::model::BodySolution<2>| s.shown().to_vec();
                if let Some(own) = own {
                    let (a, b, z) = (shown(body), shown(same), shown(own));
                    let all = a.iter().zip(&b).zip(&z);
                    all.for_each(|((a, b), z)| {
                        assert!(off(*a, [b[0] - z[0], b[1] - z[1]]) < 1e-15)
                    });
                }
            }
            for (contact, same) in now.contacts.iter().zip(&before.contacts) {
                let own = then.and_then(|then| then.contact(&contact.name));
                let tool = [contact, same].map(|c| c.obstacle.map_or(0.0, |moved| moved[0]));
                let before = own
                    .and_then(|own| own.obstacle)
                    .map_or(0.0, |moved| moved[0]);
                near(tool[0], tool[1] - before, 1e-15);
                for (j, (a, b)) in contact.nodes.iter().zip(&same.nodes).enumerate() {
                    let bits = |n: &dotyk::model::ContactNode<2>| {
                        [n.gap, n.pressure, n.shear[0], n.slip[0]].map(f64::to_bits)
                    };
                    assert_eq!(bits(a), bits(b));
                    if let Some(own) = own {
                        let z = &own.nodes[j];
                        near(
                            a.displacement_nonmortar,
                            b.displacement_nonmortar - z.displacement_nonmortar,
                            1e-14,
                        );
                        if !b.displacement_mortar.is_nan() {
                            near(
                                a.displacement_mortar,
                                b.displacement_mortar - z.displacement_mortar,
                                1e-14,
                            );
                        }
                    }
                }
            }
            let value = |s: &Solution<2>, name: &str| s.probe(name).unwrap();
            assert_eq!(value(now, "s"), value(before, "s"));
            let z = then.map_or(0.0, |then| value(then, "u"));
            near(value(now, "u"), value(before, "u") - z, 1e-14);
        }
        assert_eq!(case.model.zeroed.len(), zeroed.len());
    }
}

/// A lid that comes after the moment is drawn where the top of its block stands since then.
#[test]
fn what_comes_later_stands_on_its_neighbours_in_pictures() {
    let (_, steps) = solved(&text(&[2], ""));
    let find = |name: &str| steps[2].bodies.iter().find(|b| b.name == name).unwrap();
    let (block, lid) = (find("block"), find("lid"));
    assert!(lid.fitted.is_some());
    let model = solved(&text(&[2], "")).0.model;
    let place = |body: usize, x: [f64; 2]| {
        let mut points = model.bodies[body].mesh.points().iter();
        points.position(|p| off(*p, x) < 1e-12).unwrap()
    };
    let (on, under) = (place(2, [1.0, 1.0]), place(1, [1.0, 1.0]));
    let (a, b) = (lid.shown()[on], block.shown()[under]);
    // glued there, but for the mesh that does not fit: a part of what the block has moved
    let most = block.max_displacement();
    assert!(off(a, b) < 0.02 * most, "{a:?} {b:?} of {most}");
}

#[test]
fn a_run_that_goes_on_counts_alike() {
    let (case, steps) = solved(&text(&[3], ""));
    for done in 1..5 {
        let past: Vec<Past<2>> = steps[..done].iter().map(Past::from).collect();
        let again = case
            .model
            .solve_steps_after(&past, &mut |_| {})
            .unwrap_or_else(|e| panic!("{e}"));
        for (a, b) in again.iter().zip(&steps) {
            assert_eq!(a.counted_from, b.counted_from);
            for (a, b) in a.bodies.iter().zip(&b.bodies) {
                let most = a
                    .displacement
                    .iter()
                    .zip(&b.displacement)
                    .map(|(a, b)| off(*a, *b));
                assert!(most.fold(0.0, f64::max) < 1e-9);
            }
        }
    }
}

/// Random moments, in steps that are themselves at random times.
#[test]
fn moments_add_up() {
    let mut random = Random(90_417);
    for _ in 0..4 {
        let zeroed: Vec<usize> = (1..=5).filter(|_| random.unit() < 0.5).collect();
        let (_, steps) = solved(&text(&zeroed, ""));
        let (_, plain) = solved(&text(&[], ""));
        let node = 7;
        let mut sum = [0.0; 2];
        for (k, step) in steps.iter().enumerate() {
            if zeroed.contains(&(k + 1)) && k > 0 {
                let before = steps[k - 1].bodies[1].displacement[node];
                sum = [sum[0] + before[0], sum[1] + before[1]];
            }
            let u = step.bodies[1].displacement[node];
            let all = plain[k].bodies[1].displacement[node];
            assert!(off([u[0] + sum[0], u[1] + sum[1]], all) < 1e-14);
        }
    }
}

/// A run that goes on from one whose displacements counted otherwise is refused with that reason.
#[test]
fn another_moment_is_told() {
    let (_, plain) = solved(&text(&[], ""));
    let (case, _) = solved(&text(&[2], ""));
    let past: Vec<Past<2>> = plain[..3].iter().map(Past::from).collect();
    let error = case
        .model
        .solve_steps_after(&past, &mut |_| {})
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("`zero_displacements` was another"),
        "{error}"
    );
}
