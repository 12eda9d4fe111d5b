//! Known geometry, colours of known values, the same bytes, and their number.

use super::*;
use crate::geometry::Field;
use crate::mesh::{CellKind, Cuboid, Mesh};
use crate::model::{Borders, Couple, CoupleKind, Elastic, Law, Model};
use crate::output::space::camera::{Camera, Window};
use crate::output::space::canvas::{Canvas, Paint};
use crate::output::space::skin::{Look, Skin, shade};
use crate::output::{Record, colour, report};

pub const STEEL: Elastic = Elastic {
    young: 210e3,
    poisson: 0.3,
};

/// A box of cells.
pub fn cuboid(from: [f64; 3], to: [f64; 3], cells: [usize; 3], cell: CellKind) -> Mesh<3> {
    let cuboid = Cuboid {
        from,
        to,
        cells,
        cell,
    };
    cuboid.build().unwrap()
}

/// A small punch on a block, pressed and pushed sideways.
pub fn punch() -> (Model<3>, Solution<3>) {
    let mut model = Model::new();
    let block = cuboid([0.0; 3], [2.0, 2.0, 1.0], [4, 4, 2], CellKind::Hex8);
    let block = model.body("block", block, STEEL);
    let top = cuboid([0.5, 0.5, 1.0], [1.5, 1.5, 2.0], [2, 2, 2], CellKind::Hex8);
    let top = model.body("punch", top, STEEL);
    model.fix(block, "bottom", [Some(0.0); 3]);
    model.press(top, "top", 80.0);
    model.pull(top, "right", [4.0, 0.0, 0.0]);
    let contact = model.contact((top, "bottom"), (block, "top"));
    contact.name = "sole".to_string();
    contact.law = Law::Coulomb(Field::constant(0.3));
    let solution = model.solve().unwrap();
    (model, solution)
}

const SIDES: [(&str, [f64; 3]); 6] = [
    ("left", [0.0, 0.5, 0.5]),
    ("right", [1.0, 0.5, 0.5]),
    ("front", [0.5, 0.0, 0.5]),
    ("back", [0.5, 1.0, 0.5]),
    ("bottom", [0.5, 0.5, 0.0]),
    ("top", [0.5, 0.5, 1.0]),
];

#[test]
fn a_cube_along_its_diagonal_is_a_hexagon_of_three_faces() {
    for cell in [CellKind::Hex8, CellKind::Tet4] {
        let mesh = cuboid([0.0; 3], [1.0; 3], [3; 3], cell);
        let skin = Skin::new(&mesh, mesh.boundary_facets());
        let camera = Camera::from([1.0, -1.0, 1.0]);
        let extent = camera.extent(mesh.points().iter().copied());
        let window = Window::fitted(camera, extent, [0.0; 2], [300.0, 300.0], 5.0);
        let mut canvas = Canvas::sampled(window.size, 2, &[]);
        // every side its number as a red of its own
        let side = |index: usize| {
            let facet = skin.facets[index];
            SIDES
                .iter()
                .position(|(name, _)| mesh.side(name).unwrap().contains(&facet))
        };
        let look = Look::at(&window, mesh.points());
        skin.fill(&mut canvas, &look, 0, &|index| {
            Paint::Plain([40 * (1 + side(index).unwrap() as u8), 0, 0])
        });
        let (area, _) = canvas.shown(0);
        // a part in a thousand: samples at the rim
        let area = area / (window.scale * window.scale);
        assert!((area / 3f64.sqrt() - 1.0).abs() < 1e-3, "{cell:?} {area}");
        let (width, _, pixels) = canvas.pixels(2);
        for (number, (name, centre)) in SIDES.iter().enumerate() {
            let [x, y] = window.pixel(*centre);
            let red = pixels[y as usize * width + x as usize][0];
            // brightness lies between 0.6 and 1
            let own = 40 * (1 + number as u8);
            let seen = (own as f64 * 0.6 - 1.0) as u8 <= red && red <= own;
            let expected = ["right", "front", "top"].contains(name);
            let behind = SIDES
                .iter()
                .position(|(n, _)| *n == opposite(name))
                .unwrap();
            assert_eq!(
                expected,
                seen && red != 40 * (1 + behind as u8),
                "{name} {red}"
            );
        }
    }
}

fn opposite(name: &str) -> &'static str {
    match name {
        "left" => "right",
        "right" => "left",
        "front" => "back",
        "back" => "front",
        "bottom" => "top",
        _ => "bottom",
    }
}

#[test]
fn colours_on_a_face_are_those_of_the_values_at_its_nodes() {
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], CellKind::Hex8);
    let skin = Skin::new(&mesh, mesh.boundary_facets());
    let camera = Camera::from([0.0, -1.0, 0.0]);
    let extent = camera.extent(mesh.points().iter().copied());
    let window = Window::fitted(camera, extent, [0.0; 2], [200.0, 100.0], 0.0);
    let mut canvas = Canvas::sampled(window.size, 1, &[]);
    let mut look = Look::at(&window, mesh.points());
    look.values = mesh
        .points()
        .iter()
        .map(|p| 0.3 * p[0] + 0.4 * p[2])
        .collect();
    skin.fill(&mut canvas, &look, 0, &|_| Paint::Scale);
    let light = shade([0.0, 0.0, 1.0]) as f32;
    let pixels = canvas.pixels(1).2;
    for (column, row) in [(10, 20), (55, 80), (130, 41), (199, 0)] {
        let (x, z) = (
            (column as f64 + 0.5) / 100.0,
            1.0 - (row as f64 + 0.5) / 100.0,
        );
        let value = colour::palette()[usize::from(colour::index(0.3 * x + 0.4 * z))];
        let expected = value.map(|c| (f32::from(c) * light + 0.5) as u8);
        let found = pixels[row * 200 + column];
        // the index of a colour may round the other way
        let off = (0..3)
            .map(|i| expected[i].abs_diff(found[i]))
            .max()
            .unwrap();
        assert!(off <= 3, "{column} {row}: {expected:?} {found:?}");
    }
}

#[test]
fn pages_are_the_same_bytes_and_name_what_they_show() {
    let (model, solution) = punch();
    let draw = || {
        let scene = Scene::new(&model);
        [
            model_figure(&scene, &[]),
            stress_figures(&scene, &solution),
            contact_figure(&scene, &solution, 0),
        ]
    };
    let [mesh, stress, contact] = draw();
    assert_eq!(draw(), [mesh.clone(), stress.clone(), contact.clone()]);
    for word in [
        ">block<",
        ">punch<",
        "contact sole",
        ">80<",
        "all displacements held",
    ] {
        assert!(mesh.contains(word), "{word}");
    }
    assert!(stress.contains("magnified") && stress.contains("middle of the contact sole"));
    for word in [">punch.bottom<", ">block.top<", "stick ("] {
        assert!(contact.contains(word), "{word}");
    }
    for page in [&mesh, &stress, &contact] {
        // letters of base64 may say anything, attributes and texts may not
        let wrong = ["=\"NaN", ">NaN", "=\"inf", "src=", "@import"];
        assert!(wrong.iter().all(|text| !page.contains(text)));
    }
}

#[test]
fn points_of_couples_are_in_the_picture_and_in_its_legend() {
    let (mut model, _) = punch();
    let top = model.bodies.len() - 1;
    for (name, height) in [("jack", 3.5), ("moon", 40.0)] {
        let kind = CoupleKind::Rigid;
        let couple = Couple::new(name, [1.0, 1.0, height], "top", kind);
        model.bodies[top].couples.push(couple);
    }
    let scene = Scene::new(&model);
    let (windows, _) = scene.windows(46.0, 760.0);
    assert_eq!(windows.len(), 2);
    for window in windows {
        let sees = |height| window.sees(window.pixel([1.0, 1.0, height]), 46.0 - 1e-9);
        // as far as the size of the bodies, not farther
        assert!(sees(3.5) && sees(0.0) && !sees(40.0));
    }
    let figure = model_figure(&scene, &[]);
    assert!(figure.contains(">punch.top moves rigidly with point jack<"));
}

#[test]
fn the_pages_of_a_model_in_space_show_it() {
    let (model, solution) = punch();
    let count = |page: &str, what: &str| page.matches(what).count();
    let check = report::check_page(&model, "fine", &[[0.5, 0.5, 1.0]], "punch");
    // for pages and for phones
    assert_eq!((count(&check, "<image"), count(&check, "<canvas")), (4, 0));
    assert!(check.contains("contact node that faces nothing"));
    let steps = [solution];
    let record = Record::of(&model, &steps, "punch");
    let page = report::page(&record.overview().unwrap());
    // for pages and for phones: the mesh twice; the shape twice with its scale; the section with its scale; for both: three pictures
    // of two faces, a scale or two; shear and slip, with a scale or two
    let pictures = count(&page, "<image");
    assert!((24..=26).contains(&pictures), "{pictures}");
    assert_eq!((count(&page, "<canvas"), count(&page, "<script>")), (1, 1));
    assert_eq!(record.figures().len(), count(&page, "<figure"));
}

#[test]
fn a_hundred_thousand_triangles_are_small() {
    let (small, mut solution) = punch();
    let mut model = Model::new();
    let plate = cuboid([0.0; 3], [2.0, 1.0, 0.02], [224, 111, 1], CellKind::Hex8);
    model.body("plate", plate, STEEL);
    model.body("punch", small.bodies[1].mesh.clone(), STEEL);
    let points = model.bodies[0].mesh.points();
    let wave = |p: &[f64; 3]| (9.0 * p[0]).sin() * (7.0 * p[1]).cos();
    solution.contacts.clear();
    solution.bodies[0].displacement = points.iter().map(|p| [0.0, 0.0, wave(p)]).collect();
    solution.bodies[0].von_mises = points.iter().map(|p| 1.0 + wave(p)).collect();
    solution.bodies[0].borders = Borders::of(&model.bodies[0]).unwrap();
    let scene = Scene::new(&model);
    let triangles = 2 * scene.skins[0].facets.len();
    assert!(triangles > 100_000, "{triangles}");
    let view = turning::turning_view(&scene, &solution);
    assert!(view.len() < 2_000_000, "{}", view.len());
    let figure = stress::stress_figure(&scene, &solution);
    assert!(figure.len() < 3_000_000, "{}", figure.len());
}
