//! Every example is run: its assertions are tests.

// Where `main` writes files, what it rests on is called here.
#[allow(dead_code)]
#[path = "../../examples/beads.rs"]
mod beads;
#[allow(dead_code)]
#[path = "../../examples/dual.rs"]
mod dual;
#[path = "../../examples/identify.rs"]
mod identify;
#[allow(dead_code)]
#[path = "../../examples/own_solver.rs"]
mod own_solver;
#[allow(dead_code)]
#[path = "../../examples/punch.rs"]
mod punch;
#[allow(dead_code)]
#[path = "../../examples/ring.rs"]
mod ring;

#[test]
fn the_punch_sinks_into_the_block() {
    let model = punch::model().unwrap();
    let solution = punch::solve(&model).unwrap();
    assert_eq!(solution.bodies[1].floating_modes.len(), 1);
}

#[test]
fn the_lining_is_pressed_as_the_exact_solution_says() {
    // the example itself holds the pressures against the exact ones
    let (solution, _) = ring::solve(&ring::model().unwrap()).unwrap();
    let nodes = &solution.contacts[0].nodes;
    assert_eq!(nodes.len(), 65);
    let most = nodes
        .iter()
        .max_by(|a, b| a.pressure.total_cmp(&b.pressure));
    let [x, y] = most.unwrap().point;
    assert!(
        x.abs() < 1e-9 * y.abs(),
        "the crown bears most, not ({x}, {y})"
    );
}

#[test]
fn the_identified_data_explain_the_tables_of_the_paper() {
    identify::main();
}

#[test]
fn beads_on_a_wire_add_up_what_pulls_at_them() {
    let (forces, positions) = beads::solve().unwrap();
    assert_eq!((forces.len(), positions.len()), (5, 4));
}

#[test]
fn forces_from_outside_become_a_solution() {
    let solution = dual::solve(&dual::model().unwrap()).unwrap();
    assert!(solution.converged && solution.solver.method == "given");
}

#[test]
fn an_own_solver_is_named_in_summary_and_report() {
    let model = own_solver::model().unwrap();
    let solution = own_solver::solve(&model).unwrap();
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("own_solver");
    let record = dotyk::output::Record::of(&model, std::slice::from_ref(&solution), "own_solver");
    let held = dotyk::output::Folder::hold(&folder).unwrap();
    record.write(&held).unwrap();
    for file in ["summary.json", "report.html"] {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        assert!(text.contains("fast gradient"), "{file}");
    }
}

#[test]
fn every_example_is_run_here() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../dotyk/examples");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let known = [
            "beads.rs",
            "dual.rs",
            "identify.rs",
            "own_solver.rs",
            "punch.rs",
            "ring.rs",
        ]
        .contains(&name.as_str());
        assert!(
            known,
            "examples/{name} is not run by tests/suite/examples.rs"
        );
    }
}
