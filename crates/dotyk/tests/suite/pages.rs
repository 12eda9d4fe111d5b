//! Pages of models that are large: how many bytes, and which of many contacts have pictures.

use dotyk::output::Record;
use dotyk::prelude::*;

const STEEL: Elastic = Elastic {
    young: 210e3,
    poisson: 0.3,
};

#[test]
fn page_of_a_hundred_thousand_cells_is_small() {
    let rectangle = |from, to, cells| {
        let rectangle = Rectangle {
            from,
            to,
            cells,
            cell: CellKind::Quad4,
            diagonals: Diagonals::default(),
        };
        rectangle.build().unwrap()
    };
    let mut model = Model::new();
    let ground = rectangle([0.0, -2.0], [10.0, 0.0], [450, 200]);
    let ground = model.body("ground", ground, STEEL);
    let block = rectangle([3.0, 0.0], [7.0, 1.0], [180, 60]);
    let block = model.body("block", block, STEEL);
    model.fix(ground, "bottom", [Some(0.0); 2]);
    model.fix(block, "top", [Some(0.0), Some(-1e-3)]);
    model.contact((block, "bottom"), (ground, "top"));
    let solution = model.solve().unwrap();
    let steps = [solution];
    let page = Record::of(&model, &steps, "ground").report().unwrap();
    assert!(page.len() < 5_000_000, "{} bytes", page.len());
}

#[test]
fn of_many_contacts_those_that_bear_most_are_drawn_and_the_page_says_so() {
    let mut model = Model::new();
    let cuboid = |from, to, cells| {
        let cuboid = Cuboid {
            from,
            to,
            cells,
            cell: CellKind::Hex8,
        };
        cuboid.build().unwrap()
    };
    let block = cuboid([0.0; 3], [2.0, 2.0, 1.0], [4, 4, 2]);
    let block = model.body("block", block, STEEL);
    let top = cuboid([0.5, 0.5, 1.0], [1.5, 1.5, 2.0], [2, 2, 2]);
    let top = model.body("punch", top, STEEL);
    model.fix(block, "bottom", [Some(0.0); 3]);
    model.press(top, "top", 80.0);
    let contact = model.contact((top, "bottom"), (block, "top"));
    contact.name = "sole0".to_string();
    let mut solution = model.solve().unwrap();
    for k in 1..9 {
        let mut contact = model.contacts[0].clone();
        contact.name = format!("sole{k}");
        model.contacts.push(contact);
        let mut solved = solution.contacts[0].clone();
        solved.name = format!("sole{k}");
        // the one that bears most is glued
        solved.resultant[2] *= 1.0 + f64::from(k);
        if k == 8 {
            let nodes = solved.nodes.iter_mut();
            nodes.for_each(|node| node.status = Status::Tied);
        }
        solution.contacts.push(solved);
    }
    let steps = [solution];
    let page = Record::of(&model, &steps, "punch").report().unwrap();
    let drawn = |k: &usize| page.contains(&format!("state on the faces of sole{k}"));
    let list: Vec<usize> = (0..9).filter(drawn).collect();
    assert_eq!(list, [2, 3, 4, 5, 6, 7]);
    assert!(
        page.contains(
            "Pictures show the 6 contacts that bear most, tied ones last; of the other 3"
        )
    );
}
