//! The dual problem of a case for solvers elsewhere: F, d, G, e, Λ and B as NumPy arrays and as Matrix Market text.
//!
//! Signs and the order of rows are those of the library; `dual.txt` says them beside the files.

use crate::dual::{Block, Compliance, Modes, Multipliers};
use crate::model::{ASSEMBLED, Analysis, Dual, Unknown};
use crate::output::csv::quoted;
use crate::output::files::Stage;
use crate::output::npz::Archive;
use crate::output::text::AXES;
use crate::output::{Error, market};
use std::fmt::Write as _;
use std::io;

/// Most entries of a G that is in the archive with its zeros.
const WHOLE: usize = 10_000_000;

/// Files that not every export has: those of arrays without entries, and of an answer.
pub const OPTIONAL: [&str; 10] = [
    "F.mtx",
    "d.mtx",
    "G.mtx",
    "e.mtx",
    "B.mtx",
    "g0.mtx",
    "blocks.mtx",
    "lambda.mtx",
    "alpha.mtx",
    "gap.mtx",
];

/// A matrix by rows, without its zeros.
struct Sparse {
    columns: usize,
    /// First entry of each row, and the number of all.
    starts: Vec<usize>,
    index: Vec<usize>,
    values: Vec<f64>,
}

impl Sparse {
    fn of<R: Iterator<Item = (usize, f64)>>(columns: usize, rows: impl Iterator<Item = R>) -> Self {
        let mut matrix = Self {
            columns,
            starts: vec![0],
            index: Vec::new(),
            values: Vec::new(),
        };
        for row in rows {
            for (j, value) in row {
                matrix.index.push(j);
                matrix.values.push(value);
            }
            matrix.starts.push(matrix.index.len());
        }
        matrix
    }

    fn of_modes(modes: &Modes) -> Self {
        let rows = modes.rows();
        Self::of(modes.ncols(), rows.iter().map(|row| row.entries()))
    }

    fn shape(&self) -> [usize; 2] {
        [self.starts.len() - 1, self.columns]
    }

    /// (row, column, value).
    fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let rows = self.starts.windows(2).enumerate();
        rows.flat_map(move |(i, ends)| {
            (ends[0]..ends[1]).map(move |k| (i, self.index[k], self.values[k]))
        })
    }

    /// All entries, row by row.
    fn whole(&self) -> Vec<f64> {
        let [rows, columns] = self.shape();
        let mut whole = vec![0.0; rows * columns];
        for (i, j, value) in self.entries() {
            whole[i * columns + j] = value;
        }
        whole
    }

    /// Its arrays, as for `scipy.sparse.csr_array`.
    fn put_into(&self, archive: &mut Archive<'_>, name: &str) {
        archive.floats(
            &format!("{name}_data"),
            &[self.values.len()],
            self.values.clone(),
        );
        archive.integers(&format!("{name}_indices"), self.index.clone());
        archive.integers(&format!("{name}_indptr"), self.starts.clone());
        archive.integers(&format!("{name}_shape"), self.shape().to_vec());
    }
}

/// Puts all files into a folder's stage.
///
/// Errors: F is applied, not assembled; the system refuses a file.
pub fn put<const D: usize>(
    stage: &mut Stage,
    dual: &Dual<D>,
    answer: Option<&Multipliers>,
    stem: &str,
) -> Result<(), Error> {
    let problem = dual.problem();
    let modes = Sparse::of_modes(problem.balance.modes());
    let rows = dual.assemble_rows();
    let jumps = Sparse::of(rows.cols(), (0..rows.rows()).map(|i| rows.row(i)));
    let unknowns = dual.list_unknowns();
    let blocks = problem.admissible.blocks();
    let gap = answer.map(|answer| problem.gap(answer));
    let mut vectors: Vec<(&str, &[f64])> = vec![
        ("d", &problem.shift),
        ("e", problem.balance.load()),
        ("g0", dual.initial_gaps()),
    ];
    if let (Some(answer), Some(gap)) = (answer, &gap) {
        vectors.push(("lambda", &answer.lambda));
        vectors.push(("alpha", &answer.alpha));
        vectors.push(("gap", gap));
    }

    let [r, m] = modes.shape();
    let text = description(dual, [m, r, jumps.columns], answer.is_some(), stem);
    stage.put("dual.txt", text.as_bytes())?;
    stage.put("rows.csv", rows_csv(dual, &unknowns).as_bytes())?;

    let mut archive = Archive::default();
    let mut market = Market { stage };
    match &problem.compliance {
        Compliance::Dense(f) => {
            let columns = move || (0..m).flat_map(move |j| (0..m).map(move |i| f[(i, j)]));
            archive.matrix("F", &[m, m], true, columns);
            market.array("F", [m, m], &|i, j| f[(i, j)])?;
        }
        Compliance::Sparse(f) => {
            let f = Sparse::of(f.cols(), (0..f.rows()).map(|i| f.row(i)));
            f.put_into(&mut archive, "F");
            market.sparse("F", &f)?;
        }
        Compliance::Operator { .. } => {
            return Err(Error::Unassembled {
                unknowns: problem.len(),
                most: ASSEMBLED,
            });
        }
    }
    match r * m <= WHOLE {
        true => archive.floats("G", &[r, m], modes.whole()),
        false => modes.put_into(&mut archive, "G"),
    }
    market.sparse("G", &modes)?;
    jumps.put_into(&mut archive, "B");
    market.sparse("B", &jumps)?;
    for (name, values) in &vectors {
        archive.floats(name, &[values.len()], values.to_vec());
        market.array(name, [values.len(), 1], &|i, _| values[i])?;
    }
    let values = |block: &Block| {
        let told = block.told();
        [told.bound, told.coefficient].map(|value| value.unwrap_or(0.0))
    };
    let (bounds, coefficients) = blocks.iter().map(values).map(<(f64, f64)>::from).unzip();
    archive.words("block_law", blocks.iter().map(|b| b.name()).collect());
    archive.integers("block_size", blocks.iter().map(|b| b.size()).collect());
    archive.floats("block_bound", &[blocks.len()], bounds);
    archive.floats("block_coefficient", &[blocks.len()], coefficients);
    market.array("blocks", [blocks.len(), 4], &|i, j| {
        let block = &blocks[i];
        let [bound, coefficient] = values(block);
        let size = block.size() as f64;
        [block.told().kind as f64, size, bound, coefficient][j]
    })?;
    let weights = unknowns.iter().map(|unknown| unknown.weight).collect();
    archive.floats("weight", &[unknowns.len()], weights);
    stage.put_with("dual.npz", &mut |out| archive.write(out))
}

/// `.mtx` files, except for matrices without rows or columns, which readers reject.
struct Market<'a> {
    stage: &'a mut Stage,
}

impl Market<'_> {
    fn array(
        &mut self,
        name: &str,
        shape: [usize; 2],
        entry: &dyn Fn(usize, usize) -> f64,
    ) -> Result<(), Error> {
        self.put(name, shape, &mut |out| market::array(out, shape, entry))
    }

    fn sparse(&mut self, name: &str, matrix: &Sparse) -> Result<(), Error> {
        let (shape, count) = (matrix.shape(), matrix.values.len());
        self.put(name, shape, &mut |out| {
            market::coordinate(out, shape, count, matrix.entries())
        })
    }

    fn put(
        &mut self,
        name: &str,
        shape: [usize; 2],
        write: &mut dyn FnMut(&mut dyn io::Write) -> io::Result<()>,
    ) -> Result<(), Error> {
        match shape.contains(&0) {
            true => Ok(()),
            false => self.stage.put_with(&format!("{name}.mtx"), write),
        }
    }
}

/// Content of `rows.csv`: description of each contact force.
fn rows_csv<const D: usize>(dual: &Dual<D>, unknowns: &[Unknown<D>]) -> String {
    let blocks = dual.problem().admissible.blocks();
    let mut out = format!(
        "row,block,law,contact,node,component,{},direction_{},weight\n",
        AXES[..D].join(","),
        AXES[..D].join(",direction_")
    );
    for (row, unknown) in unknowns.iter().enumerate() {
        let component = dual.component_name(unknown);
        // Writing to a String cannot fail.
        let _ = write!(
            out,
            "{row},{},{},{},{},{component}",
            unknown.block,
            blocks[unknown.block].name(),
            quoted(dual.contact_name(unknown.contact)),
            unknown.node,
        );
        let place = unknown.point.into_iter().chain(unknown.direction);
        for value in place.chain([unknown.weight]) {
            // Adding zero turns −0 into 0.
            let _ = write!(out, ",{:?}", value + 0.0);
        }
        out.push('\n');
    }
    out
}

/// Content of `dual.txt`: the problem, its signs and units, the order of rows and columns, the files.
fn description<const D: usize>(
    dual: &Dual<D>,
    [m, r, n]: [usize; 3],
    answered: bool,
    stem: &str,
) -> String {
    let model = dual.model();
    let parts = dual.list_columns().into_iter();
    let parts = parts.map(|(name, part)| format!("  {} to {}: {name}\n", part.start, part.end - 1));
    let columns: String = parts.collect();
    let length = model.units.length.as_deref().unwrap_or("length");
    let force = model.units.force.as_deref().unwrap_or("force");
    let extent = match model.analysis {
        Analysis::Solid => "of the whole bodies",
        Analysis::Axisymmetric => "for the full turn",
        _ => "per unit thickness, or for the thickness of the body where one is given",
    };
    let axes = match model.analysis {
        Analysis::Axisymmetric => "x = r, y = z",
        Analysis::Solid => "x, y, z",
        _ => "x, y",
    };
    let (tangent, rotation) = match D {
        2 => ("tangent ", "rotation as a length, and nothing"),
        _ => ("tangents", "rotations as lengths"),
    };
    let answer = match answered {
        true => "lambda, alpha, gap: dotyk's own answer, with its gap",
        false => "dotyk has no answer to this problem: lambda, alpha and gap are missing",
    };
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "The contact problem of {stem} at t = {time:?}, from dotyk {version}.

    min 1/2 lambda' F lambda - d' lambda    over lambda in Lambda, subject to G lambda = e
    gap = F lambda - d - G' alpha = g0 - B u

m = {m} contact forces lambda, r = {r} rigid amplitudes alpha, n = {n} displacements u.
Forces (lambda, e) in {force}, {extent}.
Lengths (d, alpha, gap, g0, u) in {length}.

SIGNS. A normal gap >= 0 is open, a normal lambda >= 0 is compression; pressure = lambda / weight, and shear = -lambda_t / weight, the
traction on the nonmortar body. A tangential gap is minus the slip of this load step (slip in contact.csv is that since the
beginning), and lambda points along the slip. The nodal forces of the contacts on the bodies are -B' lambda.

LAMBDA is a product of blocks, one for each node, whose rows follow each other:
  0 unilateral  1 row                  lambda >= 0, gap >= 0, lambda gap = 0
  1 free        1 row or more          gap = 0 (a tie)
  2 tresca      normal, then {tangent}  normal as unilateral; |lambda_t| <= bound; below it gap_t = 0, at it lambda_t and gap_t
                                       have opposite signs
  3 coulomb     normal, then {tangent}  |lambda_t| <= bound + coefficient lambda_n, else as tresca; a bound > 0 is cohesion
                                       and counts only while lambda_n > 0. No minimum: the bound follows from lambda_n
  4 interval    1 row                  |lambda| <= bound; below it gap = 0, at it lambda and gap have opposite signs
With friction the gaps hold for one load step: what slipped in earlier ones is in g0 and d.

ROWS go contact by contact in the order of the case and node by node in that of contact.csv, without the nodes that are
`fixed` there, face nothing or take no part (their gap is NaN); rows.csv tells contact, node, direction and weight of each.
Behind them stand the couples, called BODY.POINT: a rigid one has a row for each node and direction, an average one those of its
displacement and then that of its rotation, whatever node and direction are written there. Then come springs that only press,
a row for each of their points, and bars, a row for each element: in rows.csv its middle and its direction from the beginning of
the bar to its end; lambda > 0 is tension. Of a bar that yields lambda counts from the middle of what it bears; what lambda = 0
pulls there is in d and e. Springs between places come behind bars, as these; of one that bears compression alone lambda > 0 is
compression, and its direction the other way round. Bolts come last: rows of each pair of nodes of the cut, along its axis and
across it.

COLUMNS of B and u are displacements in the directions {axes}, prescribed ones included, node by node (column first + {D} node
+ direction, all from 0); the point of a couple has two nodes, the second for its {rotation}:
{columns}
G = R'B' and e = R'f with those rigid motions R that supports leave free and contacts control. F = B K^+ B' holds floating
bodies at some dofs: another choice changes F by G'X + X'G, and with it d and alpha, but neither lambda nor gap.

FILES. dual.npz has all of it for NumPy: F, d, G, e, g0, block_law, block_size, block_bound, block_coefficient, weight of each
row, and B (and, where most of their entries are zeros, F and G) as parts:
  z = numpy.load(\"dual.npz\")
  B = scipy.sparse.csr_array((z[\"B_data\"], z[\"B_indices\"], z[\"B_indptr\"]), shape=z[\"B_shape\"])
F.mtx, d.mtx, G.mtx, e.mtx, g0.mtx, B.mtx are the same as Matrix Market text; what has no rows or columns has no such file.
blocks.mtx has a row for each block: number of its law as above, number of rows, bound, coefficient.
{answer}.
",
        time = dual.time(),
    )
}
