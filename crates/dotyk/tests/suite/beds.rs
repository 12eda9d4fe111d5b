//! Beds: what they tell of pressure, gap and area, and stiffnesses that vary with the place.
//!
//! Blocks of Young's modulus 1e12 on beds of 1e2 … 1e6 are rigid to 1e-5; other tolerances are told where they stand.

use crate::friction::Random;
use crate::links::{near, refused};
use dotyk::case::Case;
use dotyk::model::{BedSolution, Reuse, Solution};
use std::f64::consts::PI;

fn plane(text: &str) -> Vec<Solution<2>> {
    let case = Case::<2>::from_str(text, "links.toml", "".as_ref()).unwrap();
    let steps = case.model.solve_steps().unwrap();
    assert!(steps.iter().all(|step| step.converged));
    steps
}

fn space(text: &str) -> Solution<3> {
    let case = Case::<3>::from_str(text, "links.toml", "".as_ref()).unwrap();
    let solution = case.model.solve().unwrap();
    assert!(solution.converged);
    solution
}

/// A footing from x = 0 to 2, 0.5 thick, that these springs hold and these forces at the point (x, 1) press.
fn footing(springs: &str, loads: &[(f64, [f64; 2])], more: &str) -> String {
    let each = loads.iter().enumerate();
    let points = each.clone().map(|(k, (x, _))| format!("P{k} = [{x}, 1]"));
    let loads = each.map(|(k, (_, [x, y]))| format!("{{ point = \"P{k}\", force = [{x}, {y}] }}"));
    format!(
        "analysis = \"plane-stress\"\n[[body]]\nname = \"f\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [12, 2], cell = \"quad9\" }} }}\n\
         material = {{ young = 1e12, poisson = 0.0, thickness = 0.5 }}\npoints = {{ {} }}\n\
         spring = [{springs}]\nload = [{}]\n{more}",
        points.collect::<Vec<_>>().join(", "),
        loads.collect::<Vec<_>>().join(", ")
    )
}

const HELD: &str = "fix = [{ point = [0, 0], x = 0 }]\n";

/// The force and its moment about the origin of a bed in the plane, from the pressure and shear at its points.
fn pressed(bed: &BedSolution<2>) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for at in &bed.points {
        let force = [0, 1].map(|i| at.area * (at.shear[i] - at.pressure * at.normal[i]));
        sums[0] += force[0];
        sums[1] += force[1];
        sums[2] += at.point[0] * force[1] - at.point[1] * force[0];
    }
    sums
}

/// Winkler's trapezium under a force off the middle: P/A (1 ± 6 e/B), with or without tension.
#[test]
fn a_bed_tells_the_trapezium_below_a_footing() {
    for (off, only) in [(0.0, true), (0.25, true), (0.25, false), (0.5, false)] {
        let springs = format!("{{ side = \"bottom\", normal = 100, compression_only = {only} }}");
        let text = footing(&springs, &[(1.0 + off, [0.0, -8.0])], HELD);
        let solution = &plane(&text)[0];
        let bed = solution.bed("f.bottom").unwrap();
        assert_eq!((solution.beds.len(), bed.compression_only), (1, only));
        near(bed.area(), 1.0, 1e-12);
        near(bed.mean_pressure(), 8.0, 1e-6);
        near(bed.resultant[1], 8.0, 1e-6);
        for at in &bed.points {
            let p = 8.0 * (1.0 + 6.0 * off / 2.0 * (at.point[0] - 1.0));
            near(at.pressure, p, 1e-5);
            assert_eq!((at.gap, at.closed), (0.0, p > 0.0), "{p}");
            assert_eq!(at.normal, [0.0, -1.0]);
        }
        let tension = 3.0 * off > 1.0;
        assert_eq!(bed.min_pressure() < 0.0, tension);
        assert_eq!(bed.closed_area() < 0.9, tension);
    }
}

/// Beyond the core: a triangle over c = 3 (B/2 − e), its largest pressure 2P/(c t), and a gap that grows with the turn. The points of
/// integration are 1/18 of the width apart.
#[test]
fn a_bed_tells_the_triangle_below_a_footing_that_lifts() {
    let springs = "{ side = \"bottom\", normal = 100, compression_only = true }";
    let probes = "[[probe]]\nname = \"a\"\nquantity = \"f.bottom.pressure\"\nreduce = \"max\"\n\
                  [[probe]]\nname = \"b\"\nquantity = \"f.bottom.closed_area\"\n\
                  [[probe]]\nname = \"c\"\nquantity = \"f.bottom.gap\"\nreduce = \"max\"\n\
                  [[probe]]\nname = \"d\"\nquantity = \"f.bottom.pressure\"\nreduce = \"integral\"\n\
                  [[probe]]\nname = \"e\"\nquantity = \"f.bottom.pressure\"\nat = [2, 0]\n";
    let text = footing(springs, &[(1.5, [0.0, -8.0])], &format!("{HELD}{probes}"));
    let solution = &plane(&text)[0];
    let bed = &solution.beds[0];
    let (wide, most) = (1.5, 2.0 * 8.0 / (1.5 * 0.5));
    near(bed.closed_area(), wide * 0.5, 0.03);
    near(bed.mean_pressure(), 8.0, 1e-6);
    for at in &bed.points {
        let p = most * (at.point[0] - 0.5) / wide;
        // the edge of the triangle is known to the distance of the points
        near(at.pressure, p.max(0.0), 0.03 * most);
        near(at.gap, (-p / 100.0).max(0.0), 3e-3);
        assert!(at.pressure == 0.0 || at.gap == 0.0);
    }
    let [_, force, moment] = pressed(bed);
    near(force, 8.0, 1e-6);
    near(moment, 1.5 * 8.0, 1e-6);
    for (probe, value) in [
        ("a", bed.largest().unwrap().pressure),
        ("b", bed.closed_area()),
        ("c", bed.max_gap()),
        ("d", 8.0),
        ("e", bed.largest().unwrap().pressure),
    ] {
        near(solution.probe(probe).unwrap(), value, 1e-9);
    }
}

/// A stiffness k(1 + x) sinks evenly under a force at its centroid, ∫x(1 + x)/∫(1 + x) = 7/6, and shears evenly.
#[test]
fn a_stiffness_that_varies_sinks_evenly_under_its_centroid() {
    for only in [true, false] {
        let springs = format!(
            "{{ side = \"bottom\", normal = \"100*(1 + x)\", tangential = \"30*(1 + x)\", compression_only = {only} }}"
        );
        let text = footing(&springs, &[(7.0 / 6.0, [0.0, -8.0])], "");
        let solution = &plane(&text)[0];
        let bed = &solution.beds[0];
        for u in &solution.bodies[0].displacement {
            near(u[1], -8.0 / 200.0, 1e-6);
        }
        for at in &bed.points {
            near(at.pressure, 100.0 * (1.0 + at.point[0]) * 8.0 / 200.0, 1e-5);
        }
        near(bed.resultant[1], 8.0, 1e-7);
    }
    // a force along the bed: the same along it, and a moment about it that the normal part bears
    let springs = "{ side = \"bottom\", normal = \"1e4*(1 + x)\", tangential = \"30*(1 + x)\" }";
    let text = footing(springs, &[(1.0, [6.0, 0.0])], "");
    let solution = &plane(&text)[0];
    let bed = &solution.beds[0];
    near(bed.resultant[0], -6.0, 1e-7);
    let [along, ..] = pressed(bed);
    near(along, -6.0, 1e-6);
    let u = 6.0 / 60.0;
    for at in &bed.points {
        near(at.shear[0], -30.0 * (1.0 + at.point[0]) * u, 1e-4);
    }
}

/// Random stiffnesses and forces: pressure and shear at the points balance the loads, in force and moment, and where all presses the bed
/// that only presses is the other one.
#[test]
fn pressures_balance_the_loads_whatever_the_stiffness() {
    let mut numbers = Random(7);
    let mut random = || numbers.unit();
    for _ in 0..8 {
        let [a, b, c] = [random(), random(), random()];
        let stiffness = format!("100*(0.3 + {a}*x + {b}*(2 - x)^2 + {c}*sin(x)^2)");
        let at = [1.0 / 12.0, 0.5, 1.0, 1.5, 23.0 / 12.0][(5.0 * random()) as usize];
        let loads = [
            (1.0, [2.0 * random() - 1.0, -9.0]),
            (at, [0.0, -8.0 * random()]),
        ];
        let mut found = Vec::new();
        for only in [true, false] {
            let springs = format!(
                "{{ side = \"bottom\", normal = \"{stiffness}\", tangential = \"{a} + x\", compression_only = {only} }}"
            );
            let solution = plane(&footing(&springs, &loads, "")).remove(0);
            let bed = &solution.beds[0];
            let mut sums = pressed(bed);
            for (x, [fx, fy]) in loads {
                sums[0] += fx;
                sums[1] += fy;
                sums[2] += x * fy - fx;
            }
            for sum in sums {
                near(sum, 0.0, 1e-6);
            }
            near(bed.resultant[1], -loads[0].1[1] - loads[1].1[1], 1e-6);
            found.push(bed.clone());
        }
        if found[0].points.iter().all(|at| at.closed) {
            let pairs = found[0].points.iter().zip(&found[1].points);
            for (only, both) in pairs {
                near(only.pressure, both.pressure, 1e-6);
            }
        }
    }
}

/// A stiffness with a kink within one facet: what is told to press is what presses.
#[test]
fn a_bed_of_one_facet_bears_what_it_is_told_to_bear() {
    for only in [true, false] {
        for cell in ["quad4", "quad8"] {
            let springs = format!(
                "{{ side = \"bottom\", normal = \"100*max(0, x - 0.7)\", compression_only = {only} }}"
            );
            let loads = [(0.0, [0.0, -2.0]), (2.0, [0.0, -6.0])];
            let text = footing(&springs, &loads, HELD);
            let text = text.replace("[12, 2]", "[1, 1]").replace("quad9", cell);
            let bed = &plane(&text)[0].beds[0];
            near(bed.mean_pressure() * bed.area(), bed.resultant[1], 1e-9);
        }
    }
}

/// Without a load the pressures are rounding, or nothing at all.
#[test]
fn a_bed_without_a_load_presses_nowhere() {
    for only in [true, false] {
        let springs = format!("{{ side = \"bottom\", normal = 100, compression_only = {only} }}");
        for loads in [vec![], vec![(1.0, [0.0, -8.0]), (1.0, [0.0, 8.0])]] {
            let bed = &plane(&footing(&springs, &loads, HELD))[0].beds[0];
            let area = bed.closed_area();
            assert!(area == 0.0 && area.is_sign_positive(), "{only}: {area}");
        }
    }
}

/// Of a side with a spring that holds and one that only presses the gap is that of the second.
#[test]
fn a_gap_is_that_of_the_springs_that_only_press() {
    let springs = "{ side = \"bottom\", normal = 100 }, { side = \"bottom\", normal = 50, compression_only = true }";
    let bed = &plane(&footing(springs, &[(1.0, [0.0, 8.0])], HELD))[0].beds[0];
    near(bed.max_gap(), 0.08, 1e-6);
    near(bed.mean_pressure(), -8.0, 1e-6);
}

/// A disc on a bed of k₀(1 + r): w = P / ∫k 2πr dr, in the full turn.
#[test]
fn a_bed_around_an_axis_is_that_of_the_full_turn() {
    for only in [true, false] {
        let text = format!(
            "analysis = \"axisymmetric\"\n[[body]]\nname = \"disc\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [6, 2], cell = \"quad8\" }} }}\n\
             material = {{ young = 1e12, poisson = 0.0 }}\nload = [{{ side = \"top\", force = [0, -50] }}]\n\
             spring = [{{ side = \"bottom\", normal = \"10*(1 + x)\", compression_only = {only} }}]\n"
        );
        let solution = &plane(&text)[0];
        let bed = &solution.beds[0];
        near(bed.area(), 4.0 * PI, 1e-9);
        near(bed.closed_area(), 4.0 * PI, 1e-9);
        let stiffness = 10.0 * 2.0 * PI * (2.0 + 8.0 / 3.0);
        let w = 50.0 / stiffness;
        for at in &bed.points {
            near(at.pressure, 10.0 * (1.0 + at.point[0]) * w, 1e-5);
        }
        near(bed.resultant[1], 50.0, 1e-7);
    }
}

/// A box turned in its plane on a bed of which half is hard: sums in space, and what springs of one side together are.
#[test]
fn beds_of_space_tell_area_and_force() {
    let solve = |springs: &str| {
        space(&format!(
            "analysis = \"3d\"\n[[body]]\nname = \"b\"\n\
             mesh = {{ box = {{ from = [-1, -2, 0], to = [1, 2, 1], cells = [4, 4, 1], cell = \"hex20\" }} }}\n\
             material = {{ young = 1e12, poisson = 0.0 }}\nload = [{{ side = \"top\", force = [1, 2, -40] }}]\n\
             spring = [{springs}]\n"
        ))
    };
    let one = solve(
        "{ side = \"bottom\", normal = \"10*(2 + x*y)\", tangential = 5, compression_only = true }",
    );
    let bed = &one.beds[0];
    near(bed.area(), 8.0, 1e-12);
    near(bed.closed_area(), 8.0, 1e-12);
    for (force, load) in bed.resultant.iter().zip([1.0, 2.0, -40.0]) {
        near(*force, -load, 1e-6);
    }
    let two = solve(
        "{ side = \"bottom\", normal = \"10*(2 + x*y)\", compression_only = true }, { side = \"bottom\", tangential = 5 }",
    );
    assert_eq!(two.beds.len(), 1);
    for (a, b) in bed.points.iter().zip(&two.beds[0].points) {
        near(a.pressure, b.pressure, 1e-7);
        for i in 0..3 {
            near(a.shear[i], b.shear[i], 1e-7);
        }
    }
}

/// There is no spring where the stiffness is 0, in either kind of bed.
#[test]
fn where_the_stiffness_is_nothing_there_is_no_spring() {
    for only in [true, false] {
        let springs = format!(
            "{{ side = \"bottom\", normal = \"100*min(1, max(0, 1e9*(x - 0.5)))\", compression_only = {only} }}"
        );
        // over the middle of what bears, from 0.5 to 2
        let text = footing(&springs, &[(1.25, [0.0, -6.0])], HELD);
        // 1.25 is no node of twelve cells
        let text = text.replace("[12, 2]", "[16, 2]");
        let bed = &plane(&text)[0].beds[0];
        near(bed.closed_area(), 0.75, 1e-12);
        near(bed.largest().unwrap().pressure, 6.0 / 0.75, 1e-5);
        let off = bed.points.iter().filter(|at| at.point[0] < 0.5);
        assert!(off.clone().count() > 0 && off.clone().all(|at| at.pressure == 0.0));
        assert!(off.clone().all(|at| at.gap == 0.0));
    }
}

/// A bed that comes later has no pressure where it finds the body.
#[test]
fn pressures_count_from_where_a_bed_came() {
    for only in [true, false] {
        let springs = format!(
            "{{ side = \"bottom\", normal = 100 }}, {{ side = \"top\", normal = \"50*(1 + 0*x)\", compression_only = {only}, active = {{ from = 2 }} }}"
        );
        let text = footing(&springs, &[(1.0, [0.0, 0.0])], HELD)
            .replace("force = [0, 0]", "force = [0, \"-5*(t - 2)\"]")
            + "[[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n";
        let steps = plane(&text);
        assert!(steps[0].bed("f.top").is_none());
        near(
            steps[0].bed("f.bottom").unwrap().mean_pressure(),
            -5.0,
            1e-6,
        );
        // at the time 2 nothing acts: the body sinks back by 0.05 from where the upper bed found it
        let upper = steps[1].bed("f.top").unwrap();
        let (lower, k) = (
            steps[1].bed("f.bottom").unwrap(),
            if only { 0.0 } else { 50.0 },
        );
        let u = 0.05 * k / (100.0 + k);
        near(upper.mean_pressure(), k * (u - 0.05), 1e-6);
        near(lower.mean_pressure(), -100.0 * u, 1e-6);
        near(upper.max_gap(), if only { 0.05 } else { 0.0 }, 1e-6);
    }
}

/// Another function of place is another stiffness: what was factored for one serves only its copies.
#[test]
fn nothing_is_reused_where_a_stiffness_differs() {
    let model = |slope: f64| {
        let springs = format!(
            "{{ side = \"bottom\", normal = \"100 + {slope}*x\", compression_only = true }}"
        );
        let text = footing(&springs, &[(1.0, [0.0, -8.0])], HELD);
        let case = Case::<2>::from_str(&text, "links.toml", "".as_ref());
        case.unwrap().model
    };
    let (flat, steep) = (model(0.0001), model(100.0));
    assert!(flat.has_stiffness_of(&flat.clone()) && !flat.has_stiffness_of(&steep));
    let mut reuse = Reuse::default();
    for _ in 0..2 {
        for model in [&flat, &steep] {
            let found = model.solve_steps_reusing(&mut reuse, &mut |_| {}).unwrap();
            let alone = model.solve().unwrap();
            let pairs = found[0].beds[0].points.iter().zip(&alone.beds[0].points);
            for (a, b) in pairs {
                near(a.pressure, b.pressure, 1e-9);
            }
        }
    }
}

#[test]
fn wrong_beds_are_told_by_key() {
    let text = |springs: &str| footing(springs, &[(1.0, [0.0, -8.0])], HELD);
    for (springs, words) in [
        (
            "{ side = \"bottom\", normal = \"100*t\" }",
            "`t` has no meaning here: this is the same at all times",
        ),
        (
            "{ side = \"bottom\", tangential = \"100*(x - 1)\" }",
            "the stiffness `tangential` of a spring is -",
        ),
        (
            "{ side = \"bottom\", normal = \"sqrt(x - 3)\" }",
            "the stiffness `normal` of a spring is NaN",
        ),
        ("{ side = \"bottom\", normal = \"1/0\" }", "not finite"),
        ("{ side = \"bottom\", normal = -1 }", "must not be negative"),
        (
            "{ side = \"bottom\", normal = \"0*x\" }",
            "the bed of side \"bottom\" has no stiffness: 0*x is 0",
        ),
        (
            "{ side = \"bottom\", normal = \"0*x\", compression_only = true }",
            "the bed of side \"bottom\" has no stiffness: 0*x is 0",
        ),
        (
            "{ side = \"bottom\", normal = \"0*x\", tangential = 5, compression_only = true }",
            "the bed of side \"bottom\" has no stiffness: 0*x is 0",
        ),
        ("{ point = [0, 0], y = \"x - 1\" }", "`y` of a spring is -1"),
        ("{ point = [0, 0], y = \"t\" }", "`t` has no meaning here"),
    ] {
        let error = refused(&text(springs)).to_string();
        assert!(error.contains(words), "{springs}: {error}");
    }
    let bed = "{ side = \"bottom\", normal = 100 }";
    for (probe, words) in [
        (
            "quantity = \"f.top.pressure\"\nreduce = \"max\"",
            "side `top` has no bed",
        ),
        (
            "quantity = \"f.bottom\"",
            "the quantity ends after `bottom`",
        ),
        (
            "quantity = \"f.bottom.pressures\"\nreduce = \"max\"",
            "unknown quantity of a side `pressures`",
        ),
        ("quantity = \"f.bottom.pressure\"", "must say where"),
        (
            "quantity = \"f.bottom.closed_area\"\nreduce = \"max\"",
            "is one number",
        ),
        (
            "quantity = \"f.bottom.pressure\"\nalong = \"f.bottom\"",
            "known at points of integration",
        ),
        (
            "quantity = \"f.nowhere.pressure\"\nreduce = \"max\"",
            "unknown",
        ),
    ] {
        let text = format!("{}[[probe]]\nname = \"p\"\n{probe}\n", text(bed));
        let error = refused(&text).to_string();
        assert!(error.contains(words), "{probe}: {error}");
    }
}

/// Springs at points of one name take their stiffness each from its place.
#[test]
fn springs_at_points_have_the_stiffness_of_their_places() {
    let text = footing(
        "{ point = [0, 0], y = \"10 + 5*x\", x = 1 }, { point = [2, 0], y = \"10 + 5*x\" }",
        &[(1.5, [0.0, -8.0])],
        "",
    );
    let solution = &plane(&text)[0];
    assert!(solution.beds.is_empty());
    let sunk = |x: f64| {
        let least = solution.bodies[0].displacement.iter();
        let ends = least.map(|u| u[1]).collect::<Vec<_>>();
        if x == 0.0 {
            ends.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        } else {
            ends.iter().copied().fold(f64::INFINITY, f64::min)
        }
    };
    near(sunk(0.0), -2.0 / 10.0, 1e-5);
    near(sunk(2.0), -6.0 / 20.0, 1e-5);
}
