//! A lined tunnel for the tests of this module: a ring in the half plate x ≥ 0, pressed from above and below. The lining
//! floats along y; the rock leaves it at the springline.

use crate::geometry::Field;
use crate::mesh::{CellKind, Diagonals, Ring, TunnelRock};
use crate::model::{Elastic, Load, Model, Reading, Solution, Units};
use crate::output::Overview;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Radius of the interface.
pub const RADIUS: f64 = 3.0;
/// Half the size of the plate.
const HALF: f64 = 20.0;

/// A directory of one test, removed at its end.
pub struct Scratch(PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("dotyk-output-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Names of all files and folders in a folder, sorted.
pub fn names(dir: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(dir).unwrap();
    let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// The tunnel with `around` cells along the interface, and given numbers of them through ring and rock.
pub fn model(around: usize, [ring, rock]: [usize; 2], cell: CellKind) -> Model<2> {
    let lining = Ring {
        center: [0.0; 2],
        inner: RADIUS - 1.0,
        outer: RADIUS,
        angles: Some([-90.0, 90.0]),
        cells: [around, ring],
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    };
    let plate = TunnelRock {
        radius: RADIUS,
        half_width: HALF,
        half_height: HALF,
        cells: [around, rock],
        ratio: 10f64.powf(1.0 / rock as f64),
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    };
    let elastic = |young| Elastic {
        young,
        poisson: 0.3,
    };
    let mut model = Model::new();
    model.title = "Lined tunnel under uneven pressure".to_string();
    model.units = Units {
        length: Some("m".to_string()),
        force: Some("MN".to_string()),
    };
    let ring = model.body("ring", lining.build().unwrap(), elastic(30e3));
    let rock = model.body("rock", plate.build().unwrap(), elastic(1e3));
    model
        .fix(ring, "start", [Some(0.0), None])
        .fix(ring, "end", [Some(0.0), None])
        .fix(rock, "axis", [Some(0.0), None])
        .pin(rock, [HALF, -HALF], [None, Some(0.0)]);
    for side in ["bottom", "top"] {
        let side = side.to_string();
        let pressure = Field::function("1 + x/40", |p, _| 1.0 + p[0] / (2.0 * HALF));
        model.load(rock, Load::Pressure { side, pressure });
    }
    model.contact((ring, "outer"), (rock, "hole")).name = "lining".to_string();
    let crown = Reading::At([0.0, RADIUS]);
    model.probe("crown", "ring.displacement.y", crown).unwrap();
    model
}

/// The tunnel with 16 bilinear cells along the interface, and its solution.
pub fn solved() -> (Model<2>, Solution<2>) {
    static TUNNEL: OnceLock<(Model<2>, Solution<2>)> = OnceLock::new();
    let solve = || {
        let model = model(16, [2, 8], CellKind::Quad4);
        let solution = model.solve().unwrap();
        (model, solution)
    };
    TUNNEL.get_or_init(solve).clone()
}

/// A run of one step.
pub fn run<'a>(model: &'a Model<2>, solution: &'a Solution<2>) -> Overview<'a, 2> {
    Overview {
        model,
        stages: vec![std::borrow::Cow::Borrowed(model)],
        earlier: &[],
        failed: None,
        last: solution,
        stem: "case_1",
        converged: solution.converged,
        seconds: solution.seconds,
        peak_memory: 1 << 20,
    }
}
