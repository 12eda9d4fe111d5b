//! Bodies in space: the cost of one solution, the extra cost of contact, and the growth of costs with the number of bodies.
//!
//! ```text
//! cargo run --release -p dotyk-bench --bin space -- body [CELLS]             one block of CELLS³ hexahedra (21: 30 000 dofs)
//! cargo run --release -p dotyk-bench --bin space -- blocks [SIDE] [HEIGHT]   two blocks of SIDE² · HEIGHT each on each other,
//!                                                    beside both as one body (44 16: 200 000 dofs, 2000 contact nodes)
//! cargo run --release -p dotyk-bench --bin space -- tilted [SIDE] [HEIGHT]   the two blocks, turned about an oblique axis
//! cargo run --release -p dotyk-bench --bin space -- boxes [ROW] [CELLS]      ROW³ floating boxes of CELLS³ of random size
//!                                                    with random friction between rigid walls (10 1)
//! ```
//!
//! Seconds are wall time; the time of all processors is that of the whole process. Contact and one body take turns, `--repeat N`
//! times, so that other load on the machine affects both alike. `--threads N` bounds the threads, `--friction F` gives the blocks
//! friction and shears them.

mod boxes;
mod linear;

use dotyk::geometry::Field;
use dotyk::mesh::{CellKind, Cuboid, Mesh};
use dotyk::model::{Elastic, Gap, Law, Model, Solution};
use std::process::ExitCode;
use std::str::FromStr;

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
    let friction = option(&mut words, "--friction", 0.0)?;
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
            Some("blocks") => {
                let (side, layers) = (or(first, 44), or(second, 16));
                told(
                    "two blocks in contact",
                    &pair(side, layers, friction, |x| x)?.solve()?,
                );
                linear::solve(&whole(side, layers)?)
            }
            Some("tilted") => {
                let model = pair(or(first, 44), or(second, 16), friction, tilted)?;
                told("two oblique blocks in contact", &model.solve()?);
                Ok(())
            }
            Some("boxes") => boxes::solve(or(first, 10), or(second, 1)),
            _ => Err("body, blocks, tilted or boxes?".into()),
        })
    })
}

/// Takes an option with its number out of the words.
fn option<T: FromStr>(words: &mut Vec<String>, name: &str, default: T) -> Result<T, Failure> {
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

/// A turn by 50° about an axis oblique to all coordinates.
fn tilted([x, y, z]: [f64; 3]) -> [f64; 3] {
    let about = |angle: f64, [a, b]: [f64; 2]| {
        let (sin, cos) = angle.sin_cos();
        [cos * a - sin * b, sin * a + cos * b]
    };
    let [x, z] = about(0.7, [x, z]);
    let [y, z] = about(0.5, [y, z]);
    [x, y, z]
}

/// Two blocks of `side`² · `layers` hexahedra each, one pressed on the other, moved by `place`.
fn pair(
    side: usize,
    layers: usize,
    friction: f64,
    place: impl Fn([f64; 3]) -> [f64; 3] + Copy,
) -> Result<Model<3>, Failure> {
    let height = layers as f64 / side as f64;
    let mut model = Model::<3>::new();
    let below = block(side, [0.0, height], layers)?.map_points(place)?;
    let below = model.body("below", below, SOLID);
    let above = block(side, [height, 2.0 * height], layers)?.map_points(place)?;
    let above = model.body("above", above, SOLID);
    model.fix(below, "bottom", [Some(0.0); 3]);
    let shear = if friction > 0.0 { 0.002 } else { 0.0 };
    model.fix(above, "top", place([shear, 0.0, -0.01]).map(Some));
    // the sides touch in the middle alone
    let middle = place([0.5, 0.4, height]);
    let dish = move |x: [f64; 3], _: f64| {
        let apart = (0..3).map(|i| (x[i] - middle[i]).powi(2));
        0.02 * apart.sum::<f64>()
    };
    let contact = model.contact((above, "bottom"), (below, "top"));
    contact.gap = Some(Gap::Given(Field::function("a dish", dish)));
    if friction > 0.0 {
        contact.law = Law::Coulomb(Field::constant(friction));
    }
    Ok(model)
}

/// The two blocks as one body.
fn whole(side: usize, layers: usize) -> Result<Model<3>, Failure> {
    let height = layers as f64 / side as f64;
    let mut model = Model::<3>::new();
    let whole = block(side, [0.0, 2.0 * height], 2 * layers)?;
    let whole = model.body("both", whole, SOLID);
    model.fix(whole, "bottom", [Some(0.0); 3]);
    model.fix(whole, "top", [Some(0.0), Some(0.0), Some(-0.01)]);
    Ok(model)
}

/// Prints the costs of a solution.
fn told(what: &str, solution: &Solution<3>) {
    let s = &solution.seconds;
    println!(
        "{what}: {} dofs, {} contact unknowns, {} iterations, {} products, peak {:.2} GB, {:.1} s of all processors",
        solution.dofs,
        solution.contact_unknowns,
        solution.solver.iterations,
        solution.solver.products,
        dotyk::host::peak_memory_bytes() as f64 / 1e9,
        linear::processor_seconds(),
    );
    println!(
        "  assemble {:.2}  order {:.2}  factor {:.2}  condense {:.2}  contact {:.2}  recover {:.2}  all {:.2}",
        s.assemble, s.order, s.factor, s.condense, s.contact, s.recover, s.total
    );
}
