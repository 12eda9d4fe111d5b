//! What a machine can do, and how much of it each stage of a run reaches.
//!
//! ```text
//! cargo run --release -p dotyk-bench --bin limits -- [--cells N] [--large N]
//! ```
//!
//! Two blocks of hexahedra that do not match, N cells along the edge of the larger one, are solved as wholes and in pieces, on one
//! thread and on all. A stage is bound by the operations that it cannot do without, at the rate of products of dense matrices, or by the
//! bytes that it must at least read and write once, at the rate at which memory is read; the larger of both is its share of the limit.
//! Tables are in Markdown.

mod machine;

use dotyk::linalg::{
    CellMatrices, Graph, SymbolicCholesky, assemble_blocks, expand_to_dofs, fill_reducing_order,
};
use dotyk::mesh::{CellKind, Cuboid};
use dotyk::model::{Elastic, Event, Model, Seconds, Solution, Subdomains, Work};
use machine::Machine;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Cells along the edge of the blocks that are solved as wholes, and of those in pieces alone.
const CELLS: [usize; 2] = [48, 60];

/// Fewest: the smaller block has one cell then.
const LEAST: usize = 12;

/// Pieces of which the coarse problem is solved alone, along an edge of a cube.
const PIECES: usize = 22;

fn main() -> ExitCode {
    match arguments(std::env::args().skip(1)).and_then(measure) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn arguments(mut words: impl Iterator<Item = String>) -> Result<[usize; 2], String> {
    let mut cells = CELLS;
    while let Some(word) = words.next() {
        let place = match word.as_str() {
            "--cells" => 0,
            "--large" => 1,
            _ => return Err(format!("`{word}` is not an argument: --cells N, --large N")),
        };
        let value = words.next().and_then(|text| text.parse().ok());
        let value = value.filter(|&n: &usize| n >= LEAST);
        cells[place] = value.ok_or_else(|| format!("{word} needs a number from {LEAST}"))?;
    }
    Ok(cells)
}

fn measure([cells, large]: [usize; 2]) -> Result<(), String> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut threads = vec![1, all];
    threads.dedup();
    let machines: Vec<Machine> = threads.iter().map(|&n| Machine::measured(n)).collect();
    println!(
        "| threads | products of matrices, GFlop/s | reading, GB/s | reading and writing, GB/s |\n|---|---|---|---|"
    );
    for Machine {
        threads,
        peak,
        read,
        triad,
    } in &machines
    {
        println!("| {threads} | {peak:.0} | {read:.1} | {triad:.1} |");
    }
    let runs = [
        (cells, Subdomains::Parts(2)),
        (cells, Subdomains::Parts(pieces_of(cells))),
        (large, Subdomains::Parts(pieces_of(large))),
    ];
    for (cells, subdomains) in runs {
        for machine in &machines {
            let run = Run::of(cells, subdomains, machine.threads)?;
            run.print(machine);
        }
    }
    coarse()
}

/// Pieces of about 200 unknowns of the larger block.
fn pieces_of(cells: usize) -> usize {
    let nodes = (cells + 1) * (cells + 1) * (cells / 2 + 1);
    3 * nodes / 200
}

/// A solved model.
struct Run {
    pieces: usize,
    solution: Solution<3>,
    /// Operations and bytes of the factors.
    operations: f64,
    bytes: f64,
}

impl Run {
    fn of(cells: usize, subdomains: Subdomains, threads: usize) -> Result<Self, String> {
        let mut model = blocks(cells)?;
        model.solver.subdomains = subdomains;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| error.to_string())?;
        let mut factored: Vec<Arc<Work>> = Vec::new();
        let solved = pool.install(|| {
            model.solve_steps_with(&mut |event| {
                if let Event::Factoring(work) = event {
                    factored.push(work);
                }
            })
        });
        let mut steps = solved.map_err(|error| error.to_string())?;
        let solution = steps.pop().ok_or("no step was solved")?;
        let sum = |count: fn(&Work) -> u64| factored.iter().map(|w| count(w) as f64).sum();
        Ok(Self {
            pieces: solution.division.subdomains,
            solution,
            operations: sum(|work| work.all.load(Ordering::Relaxed)),
            bytes: sum(|work| work.bytes.load(Ordering::Relaxed)),
        })
    }

    fn print(&self, machine: &Machine) {
        let s = &self.solution;
        let Seconds {
            assemble,
            order,
            factor,
            condense,
            contact,
            recover,
            ..
        } = s.seconds;
        println!(
            "\n{} unknowns, {} contact unknowns, {} pieces, {} iterations in pieces, {} threads: {:.1} Gflop and {:.0} MB of factors\n",
            s.dofs,
            s.contact_unknowns,
            self.pieces,
            s.division.iterations,
            machine.threads,
            1e-9 * self.operations,
            1e-6 * self.bytes,
        );
        println!("| stage | s | Gflop | GB | share of the limit |\n|---|---|---|---|---|");
        let row = |stage: &str, seconds: f64, [flops, bytes]: [f64; 2]| {
            let least = f64::max(flops / (1e9 * machine.peak), bytes / (1e9 * machine.read));
            let share = match least > 0.0 {
                true => format!("{:.0} %", 100.0 * least / seconds),
                false => String::new(),
            };
            println!(
                "| {stage} | {seconds:.2} | {} | {} | {share} |",
                tell(flops),
                tell(bytes)
            );
        };
        let iterations = s.division.iterations as f64;
        row("assemble", assemble, [0.0; 2]);
        row("order", order, [0.0; 2]);
        row("factor", factor, [self.operations, self.bytes]);
        match self.pieces > 2 {
            // every iteration reads each triangle twice, and makes two operations of an entry
            true => row(
                "all iterations",
                condense + contact,
                [0.5, 2.0].map(|times| times * self.bytes * iterations),
            ),
            false => {
                row("condense", condense, [0.0; 2]);
                row("contact", contact, [0.0; 2]);
            }
        }
        row("recover", recover, [0.0; 2]);
    }
}

/// A number of operations or bytes in 10⁹; nothing where it was not counted.
fn tell(count: f64) -> String {
    match count > 0.0 {
        true => format!("{:.1}", 1e-9 * count),
        false => String::new(),
    }
}

/// A block on a larger one, whose cells do not match.
fn blocks(cells: usize) -> Result<Model<3>, String> {
    let block = |from: [f64; 3], to: [f64; 3], cells: [usize; 3]| {
        let cuboid = Cuboid {
            from,
            to,
            cells,
            cell: CellKind::Hex8,
        };
        cuboid.build().map_err(|error| error.to_string())
    };
    let elastic = Elastic {
        young: 1000.0,
        poisson: 0.3,
    };
    let lower = block([0.0; 3], [2.0, 2.0, 1.0], [cells, cells, cells / 2])?;
    let own = cells / 4 - 2;
    let upper = block([0.5, 0.5, 1.0], [1.5, 1.5, 2.0], [own; 3])?;
    let mut model = Model::new();
    let lower = model.body("lower", lower, elastic);
    let upper = model.body("upper", upper, elastic);
    model.fix(lower, "bottom", [Some(0.0); 3]);
    model.fix(upper, "top", [Some(0.0), Some(0.0), Some(-0.01)]);
    model.contact((upper, "bottom"), (lower, "top"));
    Ok(model)
}

/// The coarse problem of a cube of pieces, alone: six rigid motions each, of which those of neighbours meet.
fn coarse() -> Result<(), String> {
    let side = PIECES as u32;
    let at = |i: u32, j: u32, k: u32| i + side * (j + side * k);
    let mut nodes = Vec::new();
    for k in 0..side - 1 {
        for j in 0..side - 1 {
            for i in 0..side - 1 {
                for corner in 0..8 {
                    nodes.push(at(i + corner % 2, j + corner / 2 % 2, k + corner / 4));
                }
            }
        }
    }
    let dofs = 48;
    let own: Vec<f64> = (0..dofs)
        .flat_map(|i| (0..=i).map(move |j| if i == j { 50.0 } else { -1.0 }))
        .collect();
    let matrices = own.repeat(nodes.len() / 8);
    let cells = CellMatrices {
        nodes: &nodes,
        nodes_per_cell: 8,
        values: &matrices,
    };
    let count = PIECES.pow(3);
    let said = |error: dotyk::linalg::LinalgError| error.to_string();
    let graph = Graph::from_cells(count, &[cells.connectivity()]);
    let matrix = assemble_blocks::<6>(&graph, &[cells]).map_err(said)?;
    let clock = Instant::now();
    let order = fill_reducing_order(&graph, &vec![true; count], &[]);
    let order = expand_to_dofs(&order, 6, &vec![true; 6 * count]);
    let analysis = SymbolicCholesky::new(&matrix, &order, 0).map_err(said)?;
    let ordered = clock.elapsed().as_secs_f64();
    let factor = analysis.factor(&matrix).map_err(said)?;
    let factored = clock.elapsed().as_secs_f64() - ordered;
    let mut x = vec![1.0; 6 * count];
    let clock = Instant::now();
    const TURNS: u32 = 5;
    (0..TURNS).for_each(|_| factor.solve(&mut x));
    let solved = clock.elapsed().as_secs_f64() / f64::from(TURNS);
    println!(
        "\nCoarse problem of {count} pieces, {} unknowns, alone: order {ordered:.2} s, factor {factored:.2} s ({:.1} Gflop, {:.0} MB), one solution {:.1} ms",
        6 * count,
        1e-9 * analysis.operations(),
        8e-6 * factor.stored() as f64,
        1e3 * solved,
    );
    Ok(())
}
