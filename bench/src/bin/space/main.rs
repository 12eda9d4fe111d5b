//! Bodies in space: what one solution costs, what contact adds to it, and how costs grow with the number of bodies.
//!
//! ```text
//! cargo run --release -p dotyk-bench --bin space -- body [CELLS]             one block of CELLS³ hexahedra (21: 30 000 dofs)
//! cargo run --release -p dotyk-bench --bin space -- blocks [SIDE] [HEIGHT]   two blocks of SIDE² · HEIGHT each on each other,
//!                                                    beside both as one body (44 16: 200 000 dofs, 2000 contact nodes)
//! cargo run --release -p dotyk-bench --bin space -- boxes [ROW] [CELLS]      ROW³ floating boxes of CELLS³ of random size
//!                                                    with random friction between rigid walls (10 1)
//! ```
//!
//! Seconds are wall time; the time of all processors is that of the whole process. Contact and one body take turns, `--repeat N`
//! times, so that other load on the machine meets both alike. `--threads N` bounds the threads.

mod boxes;
mod linear;

use dotyk::geometry::Field;
use dotyk::mesh::{CellKind, Cuboid, Mesh};
use dotyk::model::{Elastic, Gap, Model, Solution};
use std::process::ExitCode;

/// A stiff solid.
const SOLID: Elastic = Elastic {
    young: 1e4,
    poisson: 0.3,
};

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> ExitCode {
    match run(std::env::args().skip(1).collect()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run(mut words: Vec<String>) -> Result<(), Failure> {
    let repeat = option(&mut words, "--repeat", 1)?;
    let threads = option(&mut words, "--threads", 0)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let number = |place: usize, default: usize| {
        words
            .get(place)
            .map_or(Ok(default), |word| word.parse::<usize>())
    };
    let (first, second) = (number(1, 0), number(2, 0));
    let or = |value: usize, default: usize| if value == 0 { default } else { value };
    let (first, second) = (first?, second?);
    pool.install(|| {
        (0..repeat).try_for_each(|_| match words.first().map(String::as_str) {
            Some("body") => body(or(first, 21)),
            Some("blocks") => blocks(or(first, 44), or(second, 16)),
            Some("boxes") => boxes::solve(or(first, 10), or(second, 1)),
            _ => Err("body, blocks or boxes?".into()),
        })
    })
}

/// Takes an option with its number out of the words.
fn option(words: &mut Vec<String>, name: &str, default: usize) -> Result<usize, Failure> {
    let Some(place) = words.iter().position(|word| word == name) else {
        return Ok(default);
    };
    words.remove(place);
    match words.get(place).map(|word| word.parse()) {
        Some(Ok(number)) => {
            words.remove(place);
            Ok(number)
        }
        _ => Err(format!("{name} needs a number").into()),
    }
}

/// A box from a height to another over the square of side 1.
fn block(side: usize, heights: [f64; 2], layers: usize) -> Result<Mesh<3>, Failure> {
    let cuboid = Cuboid {
        from: [0.0, 0.0, heights[0]],
        to: [1.0, 1.0, heights[1]],
        cells: [side, side, layers],
        cell: CellKind::Hex8,
    };
    Ok(cuboid.build()?)
}

fn body(cells: usize) -> Result<(), Failure> {
    let mut model = Model::<3>::new();
    let body = model.body("block", block(cells, [0.0, 1.0], cells)?, SOLID);
    model.fix(body, "bottom", [Some(0.0); 3]);
    model.pull(body, "top", [1.0, 0.0, -1.0]);
    told("one block", &model.solve()?);
    linear::solve(&model)
}

fn blocks(side: usize, layers: usize) -> Result<(), Failure> {
    let height = layers as f64 / side as f64;
    let mut model = Model::<3>::new();
    let below = model.body("below", block(side, [0.0, height], layers)?, SOLID);
    let above = block(side, [height, 2.0 * height], layers)?;
    let above = model.body("above", above, SOLID);
    model.fix(below, "bottom", [Some(0.0); 3]);
    model.fix(above, "top", [Some(0.0), Some(0.0), Some(-0.01)]);
    // the sides touch in the middle alone
    let dish = |x: [f64; 3], _: f64| 0.02 * ((x[0] - 0.5).powi(2) + (x[1] - 0.4).powi(2));
    model.contact((above, "bottom"), (below, "top")).gap =
        Some(Gap::Given(Field::function("a dish", dish)));
    told("two blocks in contact", &model.solve()?);
    let mut model = Model::<3>::new();
    let whole = block(side, [0.0, 2.0 * height], 2 * layers)?;
    let whole = model.body("both", whole, SOLID);
    model.fix(whole, "bottom", [Some(0.0); 3]);
    model.fix(whole, "top", [Some(0.0), Some(0.0), Some(-0.01)]);
    linear::solve(&model)
}

/// Tells what a solution took.
fn told(what: &str, solution: &Solution<3>) {
    let s = &solution.seconds;
    println!(
        "{what}: {} dofs, {} contact unknowns, {} iterations, {} products, peak {:.2} GB, {:.1} s of all processors",
        solution.dofs,
        solution.contact_unknowns,
        solution.solver.iterations,
        solution.solver.products,
        dotyk::output::peak_memory_bytes() as f64 / 1e9,
        linear::processor_seconds(),
    );
    println!(
        "  assemble {:.2}  order {:.2}  factor {:.2}  condense {:.2}  contact {:.2}  recover {:.2}  all {:.2}",
        s.assemble, s.order, s.factor, s.condense, s.contact, s.recover, s.total
    );
}
