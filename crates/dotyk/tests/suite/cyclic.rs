//! Cyclic symmetry: a sector beside the whole ring that it stands for, meshed alike, under loads that come back N times in the turn.
//!
//! Tolerance: rounding of a linear solve, 1e-9 of the largest displacement.

use crate::links::{near, refused, solved};
use dotyk::case::Case;
use dotyk::model::{Model, Solution};

const ROUNDING: f64 = 1e-9;

/// A ring with a load on its rim that is no mirror image of itself, the whole of it or a fifth.
fn ring(sector: bool, cell: &str) -> String {
    let (part, cells, cyclic) = match sector {
        true => (
            "from = 0, to = 72, ",
            8,
            "cyclic = { from = \"start\", to = \"end\", sectors = 5 }\n",
        ),
        false => ("", 40, ""),
    };
    format!(
        "analysis = \"plane-stress\"\n\
         [[body]]\nname = \"ring\"\n\
         mesh = {{ ring = {{ inner = 1, outer = 2, {part}cells = [{cells}, 4], cell = \"{cell}\" }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\n{cyclic}\
         spring = [{{ side = \"inner\", normal = 90, tangential = 40 }}]\n\
         load = [{{ side = \"outer\", traction = [\"-cos(5*atan2(y, x)+0.4)*x - 0.3*y\", \"-cos(5*atan2(y, x)+0.4)*y + 0.3*x\"] }}]\n\
         body_force = [\"x\", \"y\"]\n"
    )
}

/// Largest difference of the displacements of the nodes of a sector and those of the whole at the same places, over the largest one.
fn apart<const D: usize>(
    part: &(Model<D>, Vec<Solution<D>>),
    whole: &(Model<D>, Vec<Solution<D>>),
) -> f64 {
    let points =
        |of: &(Model<D>, Vec<Solution<D>>), body: usize| of.0.bodies[body].mesh.points().to_vec();
    let mut most: f64 = 0.0;
    let mut largest: f64 = 0.0;
    for body in 0..part.0.bodies.len() {
        let all = points(whole, body);
        for (k, x) in points(part, body).iter().enumerate() {
            let off = |y: &[f64; D]| (0..D).map(|d| (x[d] - y[d]).abs()).fold(0.0, f64::max);
            let same = (0..all.len()).find(|&j| off(&all[j]) < 1e-9).unwrap();
            let u = |of: &(Model<D>, Vec<Solution<D>>), node: usize| {
                of.1.last().unwrap().bodies[body].displacement[node]
            };
            for d in 0..D {
                most = most.max((u(part, k)[d] - u(whole, same)[d]).abs());
                largest = largest.max(u(whole, same)[d].abs());
            }
        }
    }
    most / largest
}

fn solved_in_space(text: &str) -> (Model<3>, Vec<Solution<3>>) {
    let model = Case::<3>::from_str(text, "cyclic.toml", "".as_ref())
        .unwrap()
        .model;
    let steps = model.solve_steps().unwrap();
    assert!(steps.iter().all(|step| step.converged));
    (model, steps)
}

#[test]
fn a_sector_moves_as_its_place_in_the_whole() {
    for cell in ["quad4", "tri3", "quad8", "tri6", "quad9"] {
        let off = apart(&solved(&ring(true, cell)), &solved(&ring(false, cell)));
        assert!(off < ROUNDING, "{cell}: {off:e}");
    }
}

/// A square about the origin on springs, under a load that comes back after a quarter turn; or the quarter whose corner is the axis.
fn square(quarter: bool) -> String {
    let (from, cells, cyclic) = match quarter {
        true => (
            0,
            4,
            "cyclic = { from = \"bottom\", to = \"left\", sectors = 4 }\n",
        ),
        false => (-1, 8, ""),
    };
    let all = [
        ("right", "1 + y^3", "0.2 + 0.5*y"),
        ("top", "-0.2 + 0.5*x", "1 - x^3"),
        ("left", "-1 + y^3", "-0.2 + 0.5*y"),
        ("bottom", "0.2 + 0.5*x", "-1 - x^3"),
    ];
    let loaded = all.into_iter().take(if quarter { 2 } else { 4 });
    let (springs, loads): (String, String) = loaded
        .map(|(side, x, y)| {
            (
                format!("{{ side = \"{side}\", normal = 3, tangential = 5 }}, "),
                format!("{{ side = \"{side}\", traction = [\"{x}\", \"{y}\"] }}, "),
            )
        })
        .unzip();
    format!(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"square\"\n\
         mesh = {{ rectangle = {{ from = [{from}, {from}], to = [1, 1], cells = [{cells}, {cells}], cell = \"quad9\" }} }}\n\
         material = {{ young = 100, poisson = 0.2 }}\n{cyclic}\
         spring = [{springs}]\nload = [{loads}]\n"
    )
}

#[test]
fn nodes_on_the_axis_stay_there() {
    let quarter = solved(&square(true));
    let off = apart(&quarter, &solved(&square(false)));
    assert!(off < ROUNDING, "{off:e}");
    let mesh = &quarter.0.bodies[0].mesh;
    let middle = mesh.points().iter().position(|x| *x == [0.0, 0.0]).unwrap();
    let moved = quarter.1[0].bodies[0].displacement[middle];
    assert!(moved.iter().all(|u| u.abs() < 1e-12), "{moved:?}");
}

/// Two rings, one shrunk on the other, and turned against each other through friction, in two steps.
fn shrunk(sector: bool) -> String {
    let (part, cells) = if sector {
        ("from = 0, to = 60, ", 6)
    } else {
        ("", 36)
    };
    let cyclic = match sector {
        true => "cyclic = { from = \"start\", to = \"end\", sectors = 6 }\n",
        false => "",
    };
    let ring = |name: &str, inner: f64, outer: f64, keys: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\n\
             mesh = {{ ring = {{ inner = {inner}, outer = {outer}, {part}cells = [{cells}, 3] }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n{cyclic}{keys}\n"
        )
    };
    let hub = ring(
        "hub",
        1.0,
        2.0,
        "fix = [{ side = \"inner\", x = 0, y = 0 }]",
    );
    // a load that is largest at one angle of each sector, on the side where t is 2
    let rim = ring(
        "rim",
        2.0,
        3.0,
        "load = [{ side = \"outer\", traction = [\"-0.03*(t-1)*y\", \"0.03*(t-1)*x\"] }, \
         { side = \"outer\", pressure = \"cos(6*atan2(y, x) + 0.5)\" }]",
    );
    format!(
        "analysis = \"plane-strain\"\n{hub}{rim}\
         [[contact]]\nname = \"fit\"\nnonmortar = \"rim.inner\"\nmortar = \"hub.outer\"\nfriction = 0.2\ngap = -0.01\n\
         [[step]]\ntime = 1\n[[step]]\ntime = 2\n"
    )
}

#[test]
fn sectors_in_contact_move_and_press_as_whole_bodies() {
    let (part, whole) = (solved(&shrunk(true)), solved(&shrunk(false)));
    let off = apart(&part, &whole);
    assert!(off < 1e-7, "{off:e}");
    let [part, whole] = [part, whole].map(|of| {
        of.1.into_iter()
            .map(|mut step| step.contacts.remove(0))
            .collect::<Vec<_>>()
    });
    for (part, whole) in part.iter().zip(&whole) {
        let force = |of: &dotyk::model::ContactSolution<2>| {
            of.nodes.iter().map(|n| n.pressure * n.weight).sum::<f64>()
        };
        near(6.0 * force(part), force(whole), 1e-7);
        assert!(
            whole
                .nodes
                .iter()
                .any(|n| n.status != dotyk::model::Status::Open)
        );
        for node in &part.nodes {
            // a node on the border has half of its weight on either side
            let same = whole
                .nodes
                .iter()
                .find(|n| (0..2).all(|d| (n.point[d] - node.point[d]).abs() < 1e-9));
            let same = same.unwrap();
            near(node.pressure, same.pressure, 1e-7);
        }
    }
}

/// A wedge of triangles whose two faces are divided differently, from the axis on.
fn wedge(load: &str) -> String {
    format!(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"disc\"\n\
         mesh = {{ outline = {{ cell = \"tri6\", size = 0.3, from = [0, 0], edges = [\
         {{ to = [1, 0], cells = 3, name = \"low\" }}, \
         {{ to = [0.5, 0.8660254037844386], center = [0, 0], name = \"rim\" }}, {{ to = [0, 0], cells = 5, name = \"high\" }}] }} }}\n\
         material = {{ young = 100, poisson = 0.2 }}\n\
         cyclic = {{ from = \"low\", to = \"high\", sectors = 6 }}\n\
         spring = [{{ side = \"rim\", tangential = 1 }}]\n\
         load = [{{ side = \"rim\", {load} }}]\n"
    )
}

#[test]
fn faces_that_do_not_match_bear_a_uniform_stress() {
    let (_, steps) = solved(&wedge("pressure = 2"));
    for stress in &steps[0].bodies[0].stress {
        near(stress[0], -2.0, 1e-8);
        near(stress[1], -2.0, 1e-8);
        near(stress[3] + 1.0, 1.0, 1e-8);
    }
}

/// A ring extruded along z, or turned about y: a sector beside the whole.
#[test]
fn sectors_of_space_move_as_their_place_in_the_whole() {
    let along_z = |sector: bool| {
        let (part, cells) = if sector {
            ("from = 0, to = 72, ", 4)
        } else {
            ("", 20)
        };
        let cyclic = match sector {
            true => "cyclic = { from = \"start\", to = \"end\", sectors = 5, axis = [0, 0, -2] }\n",
            false => "",
        };
        format!(
            "analysis = \"3d\"\n\
             [[body]]\nname = \"ring\"\n\
             mesh = {{ extrude = {{ mesh = {{ ring = {{ inner = 1, outer = 2, {part}cells = [{cells}, 2] }} }}, height = 0.5, layers = 2 }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n{cyclic}\
             fix = [{{ side = \"first\", z = 0 }}]\n\
             spring = [{{ side = \"outer\", normal = 20, tangential = 7 }}]\n\
             load = [{{ side = \"outer\", traction = [\"-cos(5*atan2(y, x)+0.4)*x - 0.3*y\", \"-cos(5*atan2(y, x)+0.4)*y + 0.3*x\", \"z*sin(5*atan2(y, x))\"] }}]\n"
        )
    };
    let off = apart(
        &solved_in_space(&along_z(true)),
        &solved_in_space(&along_z(false)),
    );
    assert!(off < ROUNDING, "{off:e}");
}

#[test]
fn what_is_no_sector_is_refused() {
    let sector = ring(true, "quad4");
    let says = |text: &str, words: &[&str]| {
        let error = refused(text).to_string();
        for word in words {
            assert!(error.contains(word), "{word}: {error}");
        }
    };
    says(
        &sector.replace("sectors = 5", "sectors = 6"),
        &["ring", "does not lie on side \"end\"", "centroid"],
    );
    says(
        &sector.replace("sectors = 5", "sectors = 1"),
        &["2 or more"],
    );
    says(
        &sector.replace("to = \"end\"", "to = \"start\""),
        &["share facets"],
    );
    says(
        &sector.replace("to = \"end\"", "to = \"outer\""),
        &["does not lie on side \"outer\""],
    );
    says(
        &sector.replace("to = \"end\"", "to = \"nowhere\""),
        &["nowhere"],
    );
    says(
        &sector.replace("sectors = 5", "sectors = 5, axis = [0, 0, 1]"),
        &["`axis`", "plane"],
    );
    says(
        &sector.replace("plane-stress", "axisymmetric"),
        &["axial symmetry"],
    );
    says(
        &sector.replace("sectors = 5", "point = [0.5, 0], sectors = 5"),
        &["does not lie on"],
    );
}

/// A sixth of a ring whose rim is held along its normal, and whose inner side turns on springs.
#[test]
fn a_rim_held_along_its_normal_lets_the_whole_turn() {
    let ring = "analysis = \"plane-stress\"\n\
         [[body]]\nname = \"ring\"\n\
         mesh = { ring = { inner = 1, outer = 2, from = 0, to = 60, cells = [6, 3] } }\n\
         material = { young = 1000, poisson = 0.3 }\n\
         cyclic = { from = \"start\", to = \"end\", sectors = 6 }\n\
         fix = [{ side = \"outer\", normal = 0 }]\n\
         spring = [{ side = \"inner\", tangential = 20 }]\n\
         load = [{ side = \"inner\", traction = [\"-0.1*y\", \"0.1*x\"] }]\n";
    let (model, steps) = solved(ring);
    let moved = &steps[0].bodies[0].displacement;
    for (x, u) in model.bodies[0].mesh.points().iter().zip(moved) {
        // shear on the spring alone: the ring turns as it is, by 0.1/20, but for the chords of its cells
        assert!((u[0] + 0.005 * x[1]).abs() < 1e-6, "{x:?} {u:?}");
        assert!((u[1] - 0.005 * x[0]).abs() < 1e-6, "{x:?} {u:?}");
    }
}

/// The same polygons, sector and whole: normals of a polygon are means of the facets that meet, those of the next sector included.
#[test]
fn sectors_of_polygons_press_as_whole_polygons() {
    let polygons = |sector: bool| {
        let mut model = Case::<2>::from_str(&shrunk(sector), "cyclic.toml", "".as_ref())
            .unwrap()
            .model;
        for (body, side) in [(0, "outer"), (1, "inner")] {
            model.bodies[body].surfaces.insert(side.to_string(), None);
        }
        let steps = model.solve_steps().unwrap();
        assert!(steps.iter().all(|step| step.converged));
        (model, steps)
    };
    let off = apart(&polygons(true), &polygons(false));
    assert!(off < 1e-7, "{off:e}");
}

#[test]
fn what_is_left_out_at_one_face_is_left_out_at_the_other() {
    let points = "points = { a = [2, 0], b = [1, 1.7320508075688772] }\n[[contact]]";
    for key in ["exclude", "friction_exclude"] {
        let without = |names: &str| {
            let text = shrunk(true)
                .replace("[[contact]]", points)
                .replace("gap = -0.01", &format!("gap = -0.01\n{key} = [{names}]"));
            solved(&text).1.remove(1)
        };
        let both = without("\"a\", \"b\"");
        for one in ["\"a\"", "\"b\""] {
            let one = without(one);
            for (one, both) in one.bodies.iter().zip(&both.bodies) {
                assert_eq!(one.displacement, both.displacement);
            }
        }
    }
}

#[test]
fn contacts_go_on_in_the_sectors_beside() {
    let says = |text: &str, words: &[&str]| {
        let error = refused(text).to_string();
        for word in words {
            assert!(error.contains(word), "{word}: {error}");
        }
    };
    let sectors = shrunk(true);
    let symmetry = "cyclic = { from = \"start\", to = \"end\", sectors = 6 }\n";
    let (hub, rim) = sectors.split_at(sectors.find("name = \"rim\"").unwrap());
    // only one of both is a sector, the one with the multipliers or the other
    says(
        &format!("{}{rim}", hub.replace(symmetry, "")),
        &["rim", "hub", "`cyclic`, too", "goes on beyond"],
    );
    says(
        &format!("{hub}{}", rim.replace(symmetry, "")),
        &["rim", "hub", "`cyclic`, too", "goes on beyond"],
    );
    // cut at other angles
    says(
        &format!(
            "{hub}{}",
            rim.replace("from = 0, to = 60", "from = 5, to = 65")
        ),
        &["hub", "rim", "at the same places"],
    );
    // another number of sectors
    let three = rim
        .replace("from = 0, to = 60", "from = 0, to = 120")
        .replace("sectors = 6", "sectors = 3");
    says(
        &format!("{hub}{three}"),
        &["hub", "rim", "different wholes"],
    );
}

/// A pin in a hole within each sector needs no symmetry of its own.
#[test]
fn a_body_within_a_sector_is_one_in_each() {
    let (_, steps) = solved(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"disc\"\n\
         mesh = { ring = { inner = 1, outer = 2, from = 0, to = 60, cells = [6, 3] } }\n\
         material = { young = 1000, poisson = 0.3 }\n\
         cyclic = { from = \"start\", to = \"end\", sectors = 6 }\n\
         spring = [{ side = \"inner\", normal = 20, tangential = 20 }]\n\
         [[body]]\nname = \"pad\"\n\
         mesh = { ring = { inner = 2, outer = 2.5, from = 20, to = 40, cells = [4, 2] } }\n\
         material = { young = 1000, poisson = 0.3 }\n\
         load = [{ side = \"outer\", pressure = 1 }]\n\
         spring = [{ side = \"outer\", normal = 0.1, tangential = 0.1 }]\n\
         [[contact]]\nname = \"fit\"\nsides = [\"pad.inner\", \"disc.outer\"]\nfriction = 0.3\n",
    );
    assert!(steps[0].contacts[0].resultant.iter().any(|f| f.abs() > 0.1));
}

#[test]
fn a_gap_that_is_not_the_same_in_all_sectors_is_told() {
    let warned = |gap: &str| {
        let (_, steps) = solved(&shrunk(true).replace("gap = -0.01", &format!("gap = \"{gap}\"")));
        let warnings = steps[0].warnings.iter();
        warnings
            .filter(|w| w.contains("one place of the whole"))
            .count()
    };
    assert_eq!(warned("-0.01 - 0.002*cos(6*atan2(y, x))"), 0);
    assert_eq!(warned("-0.01 - 0.002*cos(2*atan2(y, x))"), 1);
}

/// An eighth of a ring whose rim is held along its normal under a pressure within: u = B(1/r − r/b²), E(B/b² + B/a²) = p at ν = 0.
/// Nothing holds its turn, and nothing drives it.
#[test]
fn a_sector_that_nothing_turns_stays() {
    let ring = "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"rock\"\n\
         mesh = { ring = { inner = 5, outer = 12, cells = [6, 24], cell = \"quad9\", ratio = 1.04, from = 0, to = 45 } }\n\
         material = { young = 500, poisson = 0 }\n\
         fix = [{ side = \"outer\", normal = 0 }]\n\
         load = [{ side = \"inner\", pressure = 1 }]\n\
         cyclic = { from = \"start\", to = \"end\", sectors = 8 }\n";
    let (model, steps) = solved(ring);
    assert!(steps[0].warnings.iter().any(|w| w.contains("least norm")));
    let [a, b] = [5.0f64, 12.0];
    let part = 1.0 / (500.0 * (1.0 / (b * b) + 1.0 / (a * a)));
    let moved = &steps[0].bodies[0].displacement;
    for (x, u) in model.bodies[0].mesh.points().iter().zip(moved) {
        let r = x[0].hypot(x[1]);
        let exact = part * (1.0 / r - r / (b * b));
        assert!((u[0] - exact * x[0] / r).abs() < 1e-6 * part, "{x:?} {u:?}");
        assert!((u[1] - exact * x[1] / r).abs() < 1e-6 * part, "{x:?} {u:?}");
    }
}

/// Ground in its first stress with a ring in it, an eighth of both: nothing moves and nothing presses.
#[test]
fn sectors_at_rest_stay() {
    let (_, steps) = solved(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"rock\"\n\
         mesh = { ring = { inner = 5, outer = 12, cells = [6, 24], cell = \"quad9\", from = 0, to = 45 } }\n\
         material = { young = 2000, poisson = 0 }\n\
         initial_stress = { xx = -1, yy = -1, zz = -1 }\n\
         load = [{ side = \"inner\", in_situ = 1 }, { side = \"outer\", in_situ = 1 }]\n\
         cyclic = { from = \"start\", to = \"end\", sectors = 8 }\n\
         [[body]]\nname = \"ring\"\n\
         mesh = { ring = { inner = 4.8, outer = 5, cells = [6, 3], cell = \"quad9\", from = 0, to = 45 } }\n\
         material = { young = 5000, poisson = 0.2 }\n\
         cyclic = { from = \"start\", to = \"end\", sectors = 8 }\n\
         [[contact]]\nname = \"back\"\nnonmortar = \"ring.outer\"\nmortar = \"rock.inner\"\n",
    );
    for body in &steps[0].bodies {
        assert!(
            body.max_displacement() < 1e-12,
            "{}",
            body.max_displacement()
        );
    }
}
