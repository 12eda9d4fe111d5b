//! Every example is run: its assertions are tests.

// `main` prints and writes files; what it rests on is called here.
#[allow(dead_code)]
#[path = "../examples/punch.rs"]
mod punch;
#[allow(dead_code)]
#[path = "../examples/ring.rs"]
mod ring;

#[test]
fn the_punch_sinks_into_the_block() {
    let model = punch::model().unwrap();
    let solution = punch::solve(&model).unwrap();
    assert_eq!(solution.bodies[1].floating_modes.len(), 1);
}

#[test]
fn the_lining_is_pressed_as_the_exact_solution_says() {
    let (solution, error) = ring::solve(&ring::model().unwrap()).unwrap();
    assert_eq!(solution.contacts[0].nodes.len(), 65);
    assert!(error > 0.0);
}

#[test]
fn every_example_is_run_here() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let known = ["punch.rs", "ring.rs"].contains(&name.as_str());
        assert!(known, "examples/{name} is not run by tests/examples.rs");
    }
}
