//! The same bits for any number of threads.

use dotyk::geometry::Field;
use dotyk::mesh::{CellKind, Cuboid, Diagonals, Rectangle, Ring, TunnelRock};
use dotyk::model::{Elastic, Law, Method, Model, Solution};

fn with_threads<const D: usize>(
    solve: &(impl Fn() -> Solution<D> + Sync),
    threads: usize,
) -> Solution<D> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let solution = pool.build().unwrap().install(solve);
    assert_eq!(solution.threads, threads);
    solution
}

/// Every number of the answer, as bits.
fn bits<const D: usize>(solution: &Solution<D>) -> Vec<u64> {
    let bodies = solution.bodies.iter().flat_map(|body| {
        let displacement = body.displacement.iter().flatten();
        let stress = body.stress.iter().flatten();
        let reactions = body.reactions.iter().flatten();
        displacement
            .chain(stress)
            .chain(reactions)
            .chain([&body.strain_energy])
    });
    let nodes = solution.contacts.iter().flat_map(|contact| &contact.nodes);
    let contacts = nodes.flat_map(|node| [&node.pressure, &node.gap, &node.weight]);
    let history = solution.solver.history.iter().map(|point| &point.residual);
    bodies
        .chain(contacts)
        .chain(history)
        .map(|x| x.to_bits())
        .collect()
}

fn check<const D: usize>(solve: impl Fn() -> Solution<D> + Sync, what: &str) {
    let one = bits(&with_threads(&solve, 1));
    assert!(one.len() > 1000, "{what}");
    for threads in [2, 3, 2] {
        let other = bits(&with_threads(&solve, threads));
        let differing = one.iter().zip(&other).filter(|(a, b)| a != b).count();
        assert!(
            one.len() == other.len() && differing == 0,
            "{what}: {differing} numbers differ with {threads} threads"
        );
    }
}

/// Case 2 of the paper: a lining that floats along y, contact that opens.
fn tunnel(cell: CellKind, around: usize, method: Method) -> Model<2> {
    let rock = TunnelRock {
        radius: 15.0,
        half_width: 40.0,
        half_height: 40.0,
        cells: [around, around / 3],
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    let lining = Ring {
        center: [0.0, 0.0],
        inner: 12.0,
        outer: 15.0,
        angles: Some([-90.0, 90.0]),
        cells: [around, 5],
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    let mut model = Model::new();
    let rock = model.body(
        "rock",
        rock.build().unwrap(),
        Elastic {
            young: 2000.0,
            poisson: 0.25,
        },
    );
    let lining = model.body(
        "lining",
        lining.build().unwrap(),
        Elastic {
            young: 2.1e6,
            poisson: 0.15,
        },
    );
    model
        .fix(rock, "axis", [Some(0.0), None])
        .fix(rock, "bottom", [None, Some(0.0)])
        .pull(rock, "top", [0.0, -50.0])
        .fix(lining, "start", [Some(0.0), None])
        .fix(lining, "end", [Some(0.0), None]);
    model.contact((rock, "hole"), (lining, "outer"));
    model.solver.method = method;
    model
}

#[test]
fn the_tunnel_has_the_same_bits_for_any_number_of_threads() {
    for (cell, around, method) in [
        (CellKind::Tri3, 38, Method::Auto),
        (CellKind::Quad9, 40, Method::Auto),
        (CellKind::Quad4, 60, Method::Accelerated),
    ] {
        let model = tunnel(cell, around, method);
        check(|| model.solve().unwrap(), &format!("{cell:?} {method:?}"));
    }
}

#[test]
fn three_bodies_have_the_same_bits_for_any_number_of_threads() {
    let mut model = Model::new();
    let widths = [[0.0, 6.0], [1.0, 5.0], [2.0, 4.0]];
    let ids = [0, 1, 2].map(|k| {
        let [left, right] = widths[k];
        let cells = 10 * (right - left) as usize;
        let block = Rectangle {
            from: [left, k as f64],
            to: [right, k as f64 + 1.0],
            cells: [cells, 10],
            cell: CellKind::Quad8,
            diagonals: Diagonals::Checkerboard,
        };
        let elastic = Elastic {
            young: 1000.0 * (k + 1) as f64,
            poisson: 0.3,
        };
        model.body(
            ["low", "middle", "high"][k],
            block.build().unwrap(),
            elastic,
        )
    });
    model.fix(ids[0], "bottom", [Some(0.0), Some(0.0)]);
    for (id, [left, _]) in ids.into_iter().zip(widths).skip(1) {
        model.pin(id, [left, id.0 as f64 + 0.5], [Some(0.0), None]);
    }
    model.pull(ids[2], "top", [0.0, -1.0]);
    model.contact((ids[1], "bottom"), (ids[0], "top"));
    model.contact((ids[2], "bottom"), (ids[1], "top"));
    check(|| model.solve().unwrap(), "three bodies");
}

/// Factors of more operations than a body has to have for threads to share its kernels, two of them at once.
#[test]
fn large_bodies_in_space_have_the_same_bits_for_any_number_of_threads() {
    let mut model = Model::<3>::new();
    let elastic = Elastic {
        young: 1000.0,
        poisson: 0.3,
    };
    let [below, above] = [("below", 0.0, 17), ("above", 1.0, 16)].map(|(name, from, cells)| {
        let cuboid = Cuboid {
            from: [0.0, 0.0, from],
            to: [1.0, 1.0, from + 1.0],
            cells: [cells; 3],
            cell: CellKind::Hex8,
        };
        model.body(name, cuboid.build().unwrap(), elastic)
    });
    model.fix(below, "bottom", [Some(0.0); 3]);
    model.pull(above, "top", [0.2, 0.0, -1.0]);
    model.contact((above, "bottom"), (below, "top")).law = Law::Coulomb(Field::constant(0.5));
    check(|| model.solve().unwrap(), "two bodies in space");
}
