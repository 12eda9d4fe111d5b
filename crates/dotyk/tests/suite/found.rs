//! Contacts that are found between bodies: the same as written ones, nothing through a body, clear words where nothing is found.

use crate::norms::difference;
use dotyk::case::{AnyCase, Case};
use dotyk::geometry::{Point, cross, unit};
use dotyk::mesh::{CellBlock, CellKind, Cuboid, Diagonals, Facet, Mesh, Rectangle};
use dotyk::model::{
    Active, BodyId, Contact, Elastic, Finding, FindingError, Law, Model, Pair, Solution,
};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::path::Path;

const STEEL: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};

fn finding(name: &str, bodies: impl IntoIterator<Item = usize>, reach: Option<f64>) -> Finding {
    Finding {
        name: name.to_string(),
        bodies: bodies.into_iter().map(BodyId).collect(),
        reach,
        pairing: None,
        gap: None,
        law: Law::Frictionless,
        active: Active::ALWAYS,
    }
}

/// The bodies of a contact between two, in the order of the model.
fn pair<const D: usize>(contact: &Contact<D>) -> [usize; 2] {
    let sides = contact.pair.sides();
    let (a, b) = (sides[0].body.0, sides[1].body.0);
    [a.min(b), a.max(b)]
}

/// The model with its contacts written as `sides`, and with the same contacts found.
fn both_ways<const D: usize>(mut model: Model<D>) -> [Model<D>; 2] {
    let mut found = model.clone();
    found.contacts.clear();
    for contact in &mut model.contacts {
        let sides = contact.pair.sides();
        let mut sides = [sides[0].clone(), sides[1].clone()];
        sides.sort_by_key(|side| side.body);
        let sought = Finding {
            pairing: contact.pairing,
            gap: contact.gap.clone(),
            law: contact.law.clone(),
            active: contact.active,
            ..finding(&contact.name, pair(contact), None)
        };
        let result = found.find_contacts(&sought).unwrap();
        assert_eq!(result.contacts.len(), 1);
        contact.pair = Pair::Automatic(sides);
    }
    [model, found]
}

fn same_as_written<const D: usize>(case: &Case<D>, solve: impl Fn(&Model<D>) -> Solution<D>) {
    let [written, found] = both_ways(case.model.clone());
    let [a, b] = [written, found].map(|model| solve(&model));
    let off = difference(&a, &b);
    assert!(off <= 1e-9, "{}: {off:e}", case.stem);
    for (a, b) in a.probes.iter().zip(&b.probes) {
        let near = (a.value - b.value).abs() <= 1e-9 * a.value.abs().max(1.0);
        assert!(
            near || a.value.is_nan() && b.value.is_nan(),
            "{}: {a:?} {b:?}",
            case.stem
        );
    }
}

/// Cases of the verification whose contacts are written.
const CASES: [&str; 24] = [
    "bolted-plates/preload",
    "couple/press",
    "dragged-block/base_moves",
    "einstein-schwartz/slip_medium_k2",
    "floating-punch/inclined_load",
    "friction-hysteresis/layer_non_matching",
    "friction-limits/patch_unlike_quad9",
    "ground-lining/friction_03",
    "heated-ring/plane_stress",
    "janovsky-prochazka-1980/case_2",
    "lame-axisymmetric/held_ends_quad9",
    "lame-press-fit/full_ring_quad9",
    "patch-matching/three_blocks_tri6",
    "patch-non-matching/same_nodes_quad8_quad4_upper",
    "pin-in-hole/clearance_quad9",
    "space-hysteresis/layer_on_base",
    "space-hertz/ball",
    "space-lining/two_cells_hex20",
    "space-press-fit/hollow",
    "space-punch/stiff",
    "space-ring/k0",
    "space-spheres/pair",
    "space-extrusion/space",
    "tunnel-friction/non_matching_38_56_05",
];

#[test]
fn found_contacts_are_those_that_would_be_written() {
    for name in CASES {
        let path = format!("{}/../../cases/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        match AnyCase::read_with(Path::new(&path), &[]).unwrap() {
            AnyCase::Plane(case) => same_as_written(&case, |model| model.solve().unwrap()),
            AnyCase::Space(case) => same_as_written(&case, |model| model.solve().unwrap()),
        }
    }
}

/// A box with its axes along those of the plane or space.
#[derive(Debug, Clone, Copy)]
struct Brick<const D: usize> {
    low: Point<D>,
    high: Point<D>,
}

impl<const D: usize> Brick<D> {
    fn overlaps(&self, other: &Self) -> bool {
        (0..D).all(|d| self.low[d] < other.high[d] && other.low[d] < self.high[d])
    }
}

/// The part of a window on one face of a brick, of the given axis and direction, from which another brick is seen straight ahead within
/// a reach: its measure, by dividing the window at the edges of all bricks between.
fn open_window<const D: usize>(
    bricks: &[Brick<D>],
    [a, b]: [usize; 2],
    (axis, ahead): (usize, bool),
    window: &Brick<D>,
    reach: f64,
) -> f64 {
    let (own, other) = (&bricks[a], &bricks[b]);
    let way = match ahead {
        true => [own.high[axis], other.low[axis]],
        false => [other.high[axis], own.low[axis]],
    };
    if way[1] < way[0] || way[1] - way[0] > reach {
        return 0.0;
    }
    let between = bricks.iter().enumerate().filter(|(k, brick)| {
        *k != a && *k != b && brick.low[axis] < way[1] && brick.high[axis] > way[0]
    });
    let between: Vec<&Brick<D>> = between.map(|(_, brick)| brick).collect();
    let across: Vec<usize> = (0..D).filter(|&d| d != axis).collect();
    let cuts = |d: usize| {
        let (low, high) = (
            window.low[d].max(other.low[d]),
            window.high[d].min(other.high[d]),
        );
        let inner = between
            .iter()
            .flat_map(|brick| [brick.low[d], brick.high[d]]);
        let mut cuts: Vec<f64> = inner
            .filter(|c| low < *c && *c < high)
            .chain([low, high])
            .collect();
        cuts.sort_by(f64::total_cmp);
        if low < high { cuts } else { Vec::new() }
    };
    let mut parts: Vec<(Vec<f64>, f64)> = vec![(Vec::new(), 1.0)];
    for &d in &across {
        let cuts = cuts(d);
        let split = |(middle, size): &(Vec<f64>, f64)| {
            let spans = cuts.windows(2).map(|s| {
                let middle = middle
                    .iter()
                    .copied()
                    .chain([0.5 * (s[0] + s[1])])
                    .collect();
                (middle, size * (s[1] - s[0]))
            });
            spans.collect::<Vec<(Vec<f64>, f64)>>()
        };
        parts = parts.iter().flat_map(split).collect();
    }
    let hidden = |middle: &[f64]| {
        let inside = |brick: &Brick<D>| {
            let mut places = across.iter().zip(middle);
            places.all(|(&d, &m)| brick.low[d] < m && m < brick.high[d])
        };
        between.iter().any(|brick| inside(brick))
    };
    let open = parts.iter().filter(|(middle, _)| !hidden(middle));
    open.map(|(_, size)| size).sum()
}

/// The box of a facet, and the axis and direction of its normal.
fn looks<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> (Brick<D>, (usize, bool)) {
    let mut bounds = Brick {
        low: [f64::INFINITY; D],
        high: [f64::NEG_INFINITY; D],
    };
    for point in mesh.facet_points(facet) {
        bounds.low = std::array::from_fn(|d| bounds.low[d].min(point[d]));
        bounds.high = std::array::from_fn(|d| bounds.high[d].max(point[d]));
    }
    let normal = mesh.outward_normal(facet, &[0.3, 0.3]);
    let axis = (0..D).find(|&d| normal[d].abs() > 1e-9).unwrap();
    (bounds, (axis, normal[axis] > 0.0))
}

/// What is found between bricks faces each other, and what faces each other is found.
fn bricks_see_each_other<const D: usize>(bricks: &[Brick<D>], meshes: Vec<Mesh<D>>, reach: f64) {
    if bricks.len() < 2 {
        return;
    }
    let mut model = Model::<D>::new();
    for (k, mesh) in meshes.into_iter().enumerate() {
        model.body(&format!("b{k}"), mesh, STEEL);
    }
    let found = model.find_contacts(&finding("c", 0..bricks.len(), Some(reach)));
    let contacts = match found {
        Ok(found) => found.contacts,
        Err(FindingError::Nothing { .. }) => Vec::new(),
        Err(error) => panic!("{error}"),
    };
    for a in 0..bricks.len() {
        for b in (0..bricks.len()).filter(|&b| b != a) {
            let mesh = &model.bodies[a].mesh;
            let contact = contacts.iter().find(|c| pair(c) == [a.min(b), a.max(b)]);
            let side = contact.map(|c| {
                let sides = c.pair.sides();
                let own = sides.into_iter().find(|side| side.body.0 == a).unwrap();
                mesh.side(&own.side).unwrap()
            });
            for facet in mesh.boundary_facets() {
                let (window, ahead) = looks(mesh, facet);
                let open = open_window(bricks, [a, b], ahead, &window, reach);
                let whole: f64 = (0..D)
                    .filter(|&d| d != ahead.0)
                    .map(|d| window.high[d] - window.low[d])
                    .product();
                let taken = side.is_some_and(|side| side.contains(&facet));
                assert!(
                    !taken || open > 0.0,
                    "b{a} sees b{b} through a body at {window:?}"
                );
                assert!(taken || open < whole, "b{a} misses b{b} at {window:?}");
            }
        }
    }
}

/// Bricks that do not overlap, of corners and sizes in quarters.
fn apart<const D: usize>(drawn: Vec<([i32; 3], [i32; 3])>) -> Vec<Brick<D>> {
    let mut bricks: Vec<Brick<D>> = Vec::new();
    for (at, size) in drawn {
        let low = std::array::from_fn(|d| 0.25 * f64::from(at[d]));
        let high = std::array::from_fn(|d| low[d] + 0.25 * f64::from(size[d]));
        let brick = Brick { low, high };
        if !bricks.iter().any(|other| other.overlaps(&brick)) {
            bricks.push(brick);
        }
    }
    bricks
}

fn drawn(within: i32, most: usize) -> impl Strategy<Value = Vec<([i32; 3], [i32; 3])>> {
    let at = prop::array::uniform3(0..within);
    let size = prop::array::uniform3(1..9);
    prop::collection::vec((at, size), 2..most)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn nothing_is_found_through_a_body(drawn in drawn(24, 12), reach in 0.1..6.0) {
        let bricks = apart::<2>(drawn);
        let meshes = bricks.iter().map(|&Brick { low: from, high: to }| {
            let cells = [0, 1].map(|d| 1 + (to[d] - from[d]) as usize);
            let cell = CellKind::Quad4;
            Rectangle { from, to, cells, cell, diagonals: Diagonals::default() }.build().unwrap()
        });
        bricks_see_each_other(&bricks, meshes.collect(), reach);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn nothing_is_found_through_a_body_of_space(drawn in drawn(14, 12), reach in 0.1..4.0) {
        let bricks = apart::<3>(drawn);
        let meshes = bricks.iter().map(|&Brick { low: from, high: to }| {
            let cells = [0, 1, 2].map(|d| 1 + (to[d] - from[d]) as usize);
            Cuboid { from, to, cells, cell: CellKind::Hex8 }.build().unwrap()
        });
        bricks_see_each_other(&bricks, meshes.collect(), reach);
    }
}

fn read(text: &str) -> Case<2> {
    Case::<2>::from_str(text, "case.toml", Path::new(".")).unwrap()
}

fn refused(text: &str) -> String {
    let case = Case::<2>::from_str(text, "case.toml", Path::new("."));
    let error = case.unwrap_err();
    let help = error.help.clone().unwrap_or_default();
    format!("{} | {} | {help}", error.message, error.label)
}

/// Two blocks on a base, and a plate above them that touches one and is 0.2 above the other.
const PILE: &str = r#"
analysis = "plane-strain"
[[body]]
name = "base"
mesh = { rectangle = { from = [0, 0], to = [6, 1], cells = [12, 2] } }
material = { young = 1000, poisson = 0 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "plate"
mesh = { rectangle = { from = [0, 2], to = [6, 3], cells = [12, 2] } }
material = { young = 1000, poisson = 0 }
fix = [{ side = "left", x = 0 }, { side = "right", x = 0, y = 0 }]
load = [{ side = "top", pressure = 1 }]
[[body]]
name = "one"
mesh = { rectangle = { from = [1, 1], to = [2, 2], cells = [3, 2] } }
material = { young = 1000, poisson = 0 }
fix = [{ side = "left", x = 0 }]
[[body]]
name = "two"
mesh = { rectangle = { from = [4, 1], to = [5, 1.8], cells = [3, 2] } }
material = { young = 1000, poisson = 0 }
fix = [{ side = "left", x = 0 }]
[[contact]]
name = "c"
bodies = "all"
"#;

fn names<const D: usize>(model: &Model<D>) -> Vec<&str> {
    model.contacts.iter().map(|c| c.name.as_str()).collect()
}

#[test]
fn pairs_are_named_in_the_order_of_the_case() {
    let all = read(PILE);
    // the plate is 0.2 above the second block, and a tenth of that block's diagonal is less
    assert_eq!(
        names(&all.model),
        ["c-base-one", "c-base-two", "c-plate-one"]
    );
    let near = PILE.replace(
        "\"all\"",
        "[\"two\", \"plate\", \"one\", \"base\"]\nreach = 0.25",
    );
    let near = read(&near);
    let four = ["c-base-one", "c-base-two", "c-plate-one", "c-plate-two"];
    assert_eq!(names(&near.model), four);
    let solution = near.model.solve().unwrap();
    for contact in &solution.contacts {
        assert!(
            contact.nodes.iter().any(|node| node.gap.is_finite()),
            "{}",
            contact.name
        );
    }
    // sides that are whole keep their names, parts of them are named after what they face
    let sides = |index: usize| -> Vec<&str> {
        let sides = near.model.contacts[index].pair.sides();
        sides.iter().map(|side| side.side.as_str()).collect()
    };
    assert_eq!(sides(0), ["contact-one", "bottom"]);
    assert_eq!(sides(3), ["contact-two", "top"]);
}

#[test]
fn a_probe_of_a_pair_that_was_not_found_is_nan_with_a_warning() {
    let text = format!(
        "{PILE}[[probe]]\nname = \"far\"\nquantity = \"c-plate-two.resultant.y\"\n[[probe]]\nname = \"near\"\nquantity = \"c-plate-one.resultant.y\"\n[[probe]]\nname = \"deep\"\nquantity = \"c-plate-two.pressure\"\nat = [4.5, 1.8]\n"
    );
    let case = read(&text);
    assert_eq!(case.warnings.len(), 2, "{:?}", case.warnings);
    assert!(case.warnings[0].contains("\"far\""), "{:?}", case.warnings);
    let run = case.run(&[], &mut |_| {});
    let solution = &run.steps.last().unwrap();
    let value = |name: &str| {
        solution
            .probes
            .iter()
            .find(|p| p.name == name)
            .unwrap()
            .value
    };
    assert!(value("far").is_nan() && value("deep").is_nan());
    assert!(value("near").abs() > 0.1);
    let wrong = text.replace("c-plate-two.resultant", "c-plate-three.resultant");
    assert!(
        refused(&wrong).contains("c-plate-three"),
        "{}",
        refused(&wrong)
    );
}

#[test]
fn pairs_of_written_contacts_are_left_to_them() {
    let text = format!(
        "{PILE}[[contact]]\nname = \"w\"\nsides = [\"one.left\", \"plate.left\"]\nfriction = 0.1\n"
    );
    let case = read(&text);
    assert_eq!(names(&case.model), ["c-base-one", "c-base-two", "w"]);
    let notes = case.check().notes;
    assert!(
        notes.len() == 1 && notes[0].contains("left to contact \"w\""),
        "{notes:?}"
    );
}

#[test]
fn what_fills_a_gap_hides_what_is_behind() {
    let text = PILE
        .replace("to = [2, 2]", "to = [5.5, 2]")
        .replace("from = [4, 1]", "from = [-3, 1]")
        .replace("to = [5, 1.8]", "to = [-2, 1.8]");
    let wide = text.replace("\"all\"", "\"all\"\nreach = 1.5");
    // the base and the plate see each other beside it alone
    let case = read(&wide);
    assert!(names(&case.model).contains(&"c-base-plate"));
    let contact = case
        .model
        .contacts
        .iter()
        .find(|c| c.name == "c-base-plate")
        .unwrap();
    let side = contact.pair.sides()[0].clone();
    let mesh = &case.model.bodies[0].mesh;
    for &facet in mesh.side(&side.side).unwrap() {
        let middle = mesh.facet_point(facet, &[0.0]);
        assert!(middle[0] < 1.0 || middle[0] > 5.5, "{middle:?}");
    }
    // a filling that goes hides nothing at last
    let going = text.replace("\"all\"", "\"all\"\nreach = 1.5").replace(
        "fix = [{ side = \"left\", x = 0 }]\n[[body]]\nname = \"two\"",
        "fix = [{ side = \"left\", x = 0 }]\nactive = { until = 2 }\n[[body]]\nname = \"two\"",
    );
    let going = format!("{going}[[step]]\ntime = 1\n[[step]]\ntime = 2\n");
    let case = read(&going);
    let contact = case
        .model
        .contacts
        .iter()
        .find(|c| c.name == "c-base-plate")
        .unwrap();
    let side = contact.pair.sides()[0].clone();
    assert_eq!(side.side, "top");
}

#[test]
fn the_reach_is_no_more_than_half_a_thin_plate() {
    let plate = |gap: &str, more: &str| {
        PILE.replace(
            "from = [1, 1], to = [2, 2]",
            &format!("from = [0, \"3 + {gap}\"], to = [6, \"3.5 + {gap}\"]"),
        )
        .replace("\"all\"", &format!("[\"one\", \"plate\"]{more}"))
    };
    assert_eq!(read(&plate("0.24", "")).model.contacts.len(), 1);
    let far = refused(&plate("0.26", ""));
    assert!(
        far.contains("2.6000e-1 apart") && far.contains("reach"),
        "{far}"
    );
    assert_eq!(
        read(&plate("0.26", "\nreach = 0.27")).model.contacts.len(),
        1
    );
}

#[test]
fn wrong_words_are_errors_that_name_them() {
    for (words, told) in [
        ("bodies = [\"one\"]", "at least two"),
        ("bodies = [\"one\", \"one\"]", "twice"),
        ("bodies = \"every\"", "\"all\""),
        ("bodies = [\"one\", \"twoo\"]", "two"),
        ("bodies = \"all\"\nreach = 0", "reach"),
        ("bodies = \"all\"\nreach = -1", "reach"),
        ("bodies = \"all\"\nexclude = \"left\"", "exclude"),
        (
            "bodies = \"all\"\nsides = [\"one.left\", \"two.left\"]",
            "sides",
        ),
        ("bodies = [\"one\", \"two\"]", "nearest"),
        (
            "nonmortar = \"one.bottom\"\nobstacle = { gap = 0.0 }\nreach = 1",
            "reach",
        ),
    ] {
        let text = PILE.replace("bodies = \"all\"", words);
        let error = refused(&text);
        assert!(error.contains(told), "{words}: {error}");
    }
    let twice = format!("{PILE}[[contact]]\nname = \"d\"\nbodies = \"all\"\n");
    assert!(
        refused(&twice).contains("both found between"),
        "{}",
        refused(&twice)
    );
    let named = format!(
        "{PILE}[[contact]]\nname = \"c-base-one\"\nsides = [\"one.left\", \"two.right\"]\n"
    );
    assert!(
        refused(&named).contains("c-base-one"),
        "{}",
        refused(&named)
    );
}

#[test]
fn a_written_contact_ends_at_its_reach() {
    let text = PILE.replace(
        "bodies = \"all\"",
        "sides = [\"base.top\", \"plate.bottom\"]\nreach = 0.9",
    );
    let case = read(&text);
    let error = case.model.solve().unwrap_err().to_string();
    assert!(error.contains("`reach` = 0.9"), "{error}");
    // a slope above a floor: the near part alone takes part
    let slope = r#"
analysis = "plane-strain"
[[body]]
name = "base"
mesh = { rectangle = { from = [0, 0], to = [4, 1], cells = [16, 2] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "wedge"
mesh = { outline = { size = 0.25, cell = "tri3", from = [0, 1], edges = [ { to = [4, 2], name = "slope" }, { to = [4, 3], name = "right" }, { to = [0, 3], name = "top" }, { to = [0, 1], name = "left" } ] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "top", x = 0, y = -0.1 }]
[[contact]]
name = "c"
nonmortar = "wedge.slope"
mortar = "base.top"
reach = 0.5
"#;
    let solution = read(slope).model.solve().unwrap();
    let far = solution.contacts[0].nodes.iter().map(|node| node.point[0]);
    let far = far.fold(0.0, f64::max);
    assert!(1.8 < far && far < 2.6, "{far}");
}

/// Three bodies, one above the other, of which the middle one is named `p`.
const LAYERS: &str = r#"
analysis = "plane-strain"
[[body]]
name = "a"
mesh = { rectangle = { from = [0, 0], to = [4, 1], cells = [3, 1] } }
material = { young = 1e5, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "p"
mesh = { rectangle = { from = [0, 1], to = [4, 1.05], cells = [5, 1] } }
material = { young = 1e5, poisson = 0.3 }
fix = [{ side = "left", x = 0 }]
[[body]]
name = "b"
mesh = { rectangle = { from = [0, 1.05], to = [4, 2], cells = [3, 2] } }
material = { young = 1e5, poisson = 0.3 }
load = [{ side = "top", pressure = 10 }]
fix = [{ side = "left", x = 0 }]
"#;

#[test]
fn a_written_contact_has_nothing_through_a_third_body() {
    let contact = |name: &str, sides: &str| {
        format!("[[contact]]\nname = \"{name}\"\nsides = {sides}\ntied = true\n")
    };
    let [lower, upper] = [
        contact("lower", "[\"a.top\", \"p.bottom\"]"),
        contact("upper", "[\"p.top\", \"b.bottom\"]"),
    ];
    let through = contact("through", "[\"a.top\", \"b.bottom\"]");
    let error = read(&format!("{LAYERS}{lower}{upper}{through}"));
    let error = error.model.solve().unwrap_err().to_string();
    assert!(
        error.contains("another body") && error.contains("\"p\""),
        "{error}"
    );
    // what lies beside the middle one is not hidden
    let part = LAYERS.replace(
        "to = [4, 1.05], cells = [5, 1]",
        "to = [2.7, 1.05], cells = [5, 1]",
    );
    let beside = read(&format!("{part}{lower}{upper}{through}"))
        .model
        .solve()
        .unwrap();
    let nodes = &beside.contacts[2].nodes;
    let taken = nodes
        .iter()
        .filter(|node| node.gap.is_finite())
        .map(|node| node.point[0]);
    assert!(taken.fold(f64::INFINITY, f64::min) > 2.6);
}

/// A table whose foot stands on a ground of one facet, between two blocks below its top.
const TABLE: &str = r#"
analysis = "plane-strain"
[[body]]
name = "ground"
mesh = { rectangle = { from = [0, 0], to = [4, 1], cells = [1, 1] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "one"
mesh = { rectangle = { from = [0, 1], to = [1.2, 1.4], cells = [4, 2] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "two"
mesh = { rectangle = { from = [1.8, 1], to = [4, 1.4], cells = [6, 2] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "table"
mesh = { outline = { size = 0.25, from = [1.3, 1], edges = [ { to = [1.7, 1], name = "foot" }, { to = [1.7, 1.5], name = "leg" }, { to = [4, 1.5], name = "right" }, { to = [4, 2], name = "end" }, { to = [0, 2], name = "top" }, { to = [0, 1.5], name = "end" }, { to = [1.3, 1.5], name = "left" }, { to = [1.3, 1], name = "leg" } ] } }
material = { young = 1000, poisson = 0.3 }
load = [{ side = "top", pressure = 0.01 }]
fix = [{ side = "end", x = 0 }]
[[contact]]
name = "c"
nonmortar = ["table.foot", "table.left", "table.right"]
mortar = "ground.top"
"#;

#[test]
fn a_facet_takes_part_where_another_one_alone_sees_it() {
    // all that the ground sees from where it looks is the top of the table, behind the blocks
    let solution = read(TABLE).model.solve().unwrap();
    let contact = &solution.contacts[0];
    // the load, to the tolerance of the balance
    let off = (contact.resultant[1].abs() - 0.04).abs();
    assert!(off < 1e-10, "{:?}", contact.resultant);
}

/// A wedge whose tip ends between two bodies, where they see each other past it; the slope of large facets.
const TIP: &str = r#"
analysis = "plane-strain"
[[body]]
name = "wedge"
mesh = { outline = { size = 0.4, from = [1.00033, 1.4995], edges = [ { to = [1.00033, 0.001], name = "left" }, { to = [1.99933, 1.4995], name = "under" }, { to = [1.00033, 1.4995], name = "top" } ] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "top", x = 0, y = -0.005 }]
[[body]]
name = "slope"
mesh = { outline = { size = 1, from = [1.99967, 1.499], edges = [ { to = [1.00067, 0.0005], name = "over" }, { to = [1.99967, 0.0005], name = "bottom" }, { to = [1.99967, 1.499], name = "right" } ] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "wall"
mesh = { outline = { size = 0.2, from = [0.9995, 0.00075], edges = [ { to = [0.9995, 1.49925], name = "right" }, { to = [0.0005, 1.49925], name = "top" }, { to = [0.0005, 0.00075], name = "left" }, { to = [0.9995, 0.00075], name = "bottom" } ] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "left", x = 0, y = 0 }]
"#;

#[test]
fn bodies_that_see_each_other_past_a_tip_alone_do_not_touch() {
    for law in ["friction = 0.2", "tied = true", "gap = \"closed\""] {
        let found =
            format!("{TIP}[[contact]]\nname = \"c\"\nbodies = \"all\"\nreach = 0.05\n{law}\n");
        let contact = |name: &str, sides: [&str; 2]| {
            format!("[[contact]]\nname = \"{name}\"\nsides = {sides:?}\n{law}\n")
        };
        let written = [
            TIP.to_string(),
            contact("below", ["wedge.under", "slope.over"]),
            contact("beside", ["wedge.left", "wall.right"]),
        ];
        let written = written.concat();
        let [a, b] = [written, found].map(|text| read(&text).model.solve().unwrap());
        let off = difference(&a, &b);
        assert!(off <= 1e-9, "{law}: {off:e}");
    }
}

#[test]
fn a_pair_is_there_when_what_hides_it_has_gone() {
    let found = "[[contact]]\nname = \"c\"\nbodies = \"all\"\ntied = true\n";
    let steps = "[[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n";
    let gone = LAYERS.replace("name = \"p\"", "name = \"p\"\nactive = { until = 2 }");
    let case = read(&format!("{gone}{found}{steps}"));
    let through = case
        .model
        .contacts
        .iter()
        .find(|c| c.name == "c-a-b")
        .unwrap();
    assert!(!through.active.at(1.0) && through.active.at(2.0) && through.active.at(3.0));
}

#[test]
fn curved_bodies_do_not_see_each_other_through_a_ring_between() {
    let ring = |name: &str, inner: f64, outer: f64, around: usize| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ ring = {{ inner = {inner}, outer = {outer}, cells = [{around}, 2] }} }}\nmaterial = {{ young = 1000, poisson = 0.3 }}\n"
        )
    };
    let head = "analysis = \"plane-strain\"\n";
    let found = "[[contact]]\nname = \"c\"\nbodies = \"all\"\ntied = true\n";
    for thin in [2.02, 2.2] {
        let sizes = [[24, 40, 30], [96, 160, 120], [30, 24, 40], [12, 9, 10]];
        // the polygons of the last do not lie on both sides of a thin ring
        let sizes = &sizes[..if thin < 2.1 { 3 } else { 4 }];
        for &cells in sizes {
            let rings = [
                ring("shaft", 0.5, 2.0, cells[0]),
                ring("sleeve", 2.0, thin, cells[1]),
                ring("hub", thin, 3.0, cells[2]),
            ];
            let case = read(&format!("{head}{}{found}", rings.concat()));
            assert_eq!(
                names(&case.model),
                ["c-shaft-sleeve", "c-sleeve-hub"],
                "{thin} {cells:?}"
            );
            // all of the surfaces that truly touch take part
            for contact in &case.model.contacts {
                for side in contact.pair.sides() {
                    let mesh = &case.model.bodies[side.body.0].mesh;
                    let whole = ["inner", "outer"].map(|name| mesh.side(name).unwrap());
                    assert!(
                        whole.contains(&mesh.side(&side.side).unwrap()),
                        "{thin} {cells:?} {side:?}"
                    );
                }
            }
        }
    }
}

/// A cube as six tetrahedra around its diagonal, of which the bodies have some each.
fn divided_cube(bodies: &[&[usize]]) -> Model<3> {
    let corner = |k: usize| -> Point<3> { [0, 1, 2].map(|d| ((k >> d) & 1) as f64) };
    let tetrahedra = [
        [0, 1, 3, 7],
        [0, 3, 2, 7],
        [0, 2, 6, 7],
        [0, 6, 4, 7],
        [0, 4, 5, 7],
        [0, 5, 1, 7],
    ];
    let mut model = Model::<3>::new();
    for (k, own) in bodies.iter().enumerate() {
        let corners: Vec<usize> = own.iter().flat_map(|&t| tetrahedra[t]).collect();
        let used: BTreeSet<usize> = corners.iter().copied().collect();
        let place = |node: &usize| used.range(..node).count() as u32;
        let block = CellBlock {
            kind: CellKind::Tet4,
            nodes: corners.iter().map(place).collect(),
            group: None,
        };
        let points = used.iter().map(|&node| corner(node)).collect();
        let mesh = Mesh::new(points, vec![block]).unwrap();
        model.body(&format!("b{k}"), mesh, STEEL);
    }
    model
}

#[test]
fn the_outside_of_a_divided_cube_faces_nothing() {
    let divisions: [&[&[usize]]; 4] = [
        &[&[0, 1, 5], &[2], &[3, 4]],
        &[&[0, 1], &[2, 3], &[4, 5]],
        &[&[0], &[1], &[2], &[3], &[4], &[5]],
        &[&[0, 1, 2], &[3, 4, 5]],
    ];
    for bodies in divisions {
        let mut model = divided_cube(bodies);
        model
            .find_contacts(&finding("c", 0..bodies.len(), Some(0.01)))
            .unwrap();
        for body in &model.bodies {
            let own = body.mesh.sides().iter();
            for (side, facets) in own.filter(|(side, _)| side.starts_with("contact-")) {
                for &facet in facets {
                    let middle = body.mesh.facet_point(facet, &[1.0 / 3.0, 1.0 / 3.0]);
                    let inside = middle.iter().all(|c| 1e-9 < *c && *c < 1.0 - 1e-9);
                    assert!(inside, "{}.{side}: {middle:?}", body.name);
                }
            }
        }
    }
}

#[test]
fn bodies_that_overlap_by_more_than_the_reach_are_told() {
    let sunk = PILE.replace(
        "from = [4, 1], to = [5, 1.8]",
        "from = [4, 0.4], to = [5, 1.2]",
    );
    let case = read(&sunk);
    let told = case
        .warnings
        .iter()
        .any(|w| w.contains("overlap at first by 4.0000e-1"));
    assert!(told, "{:?}", case.warnings);
    assert!(!names(&case.model).contains(&"c-base-two"));
}

/// A block lies flush on the floor of a pocket beside a wall that leans away, with a clearance or none: its corner has the conditions of
/// both faces of the pocket, as two contacts have them.
#[test]
fn a_corner_on_a_floor_does_not_lose_the_wall_beside_it() {
    for (clearance, degrees) in [(5e-4, 20.0f64), (0.0, 20.0), (5e-4, 40.0)] {
        let foot = 1.0 + clearance;
        let [top, up] = [
            foot + degrees.to_radians().sin(),
            degrees.to_radians().cos(),
        ];
        let bodies = format!(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"p\"\n\
             mesh = {{ outline = {{ size = 0.3, from = [-1, 0], edges = [{{ to = [{foot:?}, 0], name = \"floor\" }}, \
             {{ to = [{top:?}, {up:?}], name = \"wall\" }}, {{ to = [3, {up:?}] }}, {{ to = [3, -1], name = \"far\" }}, \
             {{ to = [-1, -1], name = \"base\" }}, {{ to = [-1, 0] }}] }} }}\n\
             material = {{ young = 1e6, poisson = 0.3 }}\n\
             fix = [{{ side = \"base\", x = 0, y = 0 }}, {{ side = \"far\", x = 0, y = 0 }}]\n\
             [[body]]\nname = \"b\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [4, 4], cell = \"quad8\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\nload = [{{ side = \"top\", traction = [0.3, -1] }}]\n"
        );
        let one = "[[contact]]\nname = \"c\"\nnonmortar = [\"b.bottom\", \"b.right\"]\nmortar = [\"p.floor\", \"p.wall\"]\n";
        let two = "[[contact]]\nname = \"c\"\nnonmortar = \"b.bottom\"\nmortar = \"p.floor\"\n\
                   [[contact]]\nname = \"d\"\nnonmortar = \"b.right\"\nmortar = \"p.wall\"\n";
        let [one, two] =
            [one, two].map(|contacts| read(&format!("{bodies}{contacts}")).model.solve().unwrap());
        let off = difference(&one, &two);
        assert!(off < 1e-6, "{clearance} {degrees}: {off}");
    }
}

/// A box stands on its corner above a flat block, between whose nodes the corner lies, and is pressed down. The found contact gives the
/// corner its condition, along the normal of the block; written the other way round it is no answer that the corner sinks in freely.
#[test]
fn a_corner_between_the_nodes_of_a_flat_side_does_not_sink_in() {
    for (cell, lies) in [
        (CellKind::Tet4, [0.11, 0.07]),
        (CellKind::Hex8, [-0.2, 0.15]),
    ] {
        let build = |from: Point<3>, to: Point<3>, cells: [usize; 3]| {
            let cuboid = Cuboid {
                from,
                to,
                cells,
                cell,
            };
            cuboid.build().unwrap()
        };
        let low = build([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0], [3, 3, 2]);
        // the diagonal of the cube is turned upright, past an axis of symmetry
        let [a, b] = [[0.8, 0.1, 0.5], [-0.2, 0.8, 0.45f64]];
        let (x, z) = (unit(a).unwrap(), unit(cross(a, b)).unwrap());
        let y = cross(z, x);
        let up = build([0.0; 3], [1.0; 3], [2, 2, 2]);
        let up = up.map_points(|p| {
            let at = |k: usize| p[0] * x[k] + p[1] * y[k] + p[2] * z[k];
            [lies[0] + at(0), lies[1] + at(1), at(2)]
        });
        let mut model = Model::new();
        let low = model.body("low", low, STEEL);
        let up = model.body("up", up.unwrap(), STEEL);
        model.fix(low, "bottom", [Some(0.0); 3]);
        model.fix(up, "top", [Some(0.0), Some(0.0), Some(-0.02)]);
        let mut found = model.clone();
        let contacts = found.find_contacts(&finding("c", [0, 1], None)).unwrap();
        assert_eq!(contacts.contacts.len(), 1);
        let solution = found.solve().unwrap();
        let [fx, fy, fz] = solution.contacts[0].resultant;
        assert!(fz.abs() > 0.5 && fx.hypot(fy) < 1e-9 * fz.abs(), "{cell:?}");
        // the sides of the corner as the mortar side
        let mut blind = model;
        let mesh = (*blind.bodies[1].mesh).clone();
        let near = mesh.with_side("near", |p| p[2] < 0.72);
        blind.bodies[1].mesh = near.into();
        blind.contact((low, "top"), (up, "near"));
        let refused = blind.solve().unwrap_err().to_string();
        assert!(refused.contains("overlap"), "{cell:?}: {refused}");
    }
}
