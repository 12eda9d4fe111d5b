//! A made-up tunnel for the tests of this module: a ring in the half plate x ≥ 0, fields by formulas.

use crate::dual::{Certificate, Figure};
use crate::geometry::{Field, Point};
use crate::mesh::{CellBlock, CellKind, Facet, Mesh};
use crate::model::*;
use crate::output::Run;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Radius of the interface.
pub const RADIUS: f64 = 3.0;
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

/// The image of an n × m grid; sides bottom right top left of the square become the four names.
fn mapped(
    cells: [usize; 2],
    kind: CellKind,
    names: [&str; 4],
    map: impl Fn(f64, f64) -> Point<2>,
) -> Mesh<2> {
    let [n, m] = cells;
    let quadratic = kind != CellKind::Quad4;
    let step = if quadratic { 2 } else { 1 };
    // Nodes of the doubled grid; the centres of serendipity cells are left out.
    let mut number = BTreeMap::new();
    let mut points = Vec::new();
    for j in 0..=step * m {
        for i in 0..=step * n {
            if kind == CellKind::Quad8 && i % 2 == 1 && j % 2 == 1 {
                continue;
            }
            number.insert((i, j), points.len() as u32);
            points.push(map(
                i as f64 / (step * n) as f64,
                j as f64 / (step * m) as f64,
            ));
        }
    }
    let mut nodes = Vec::new();
    let mut sides: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
    for j in 0..m {
        for i in 0..n {
            let (a, b) = (step * i, step * j);
            let mut places = vec![(a, b), (a + step, b), (a + step, b + step), (a, b + step)];
            if quadratic {
                places.extend([(a + 1, b), (a + 2, b + 1), (a + 1, b + 2), (a, b + 1)]);
            }
            if kind == CellKind::Quad9 {
                places.push((a + 1, b + 1));
            }
            nodes.extend(places.iter().map(|p| number[p]));
            let on = [j == 0, i + 1 == n, j + 1 == m, i == 0];
            for (local, _) in on.iter().enumerate().filter(|(_, on)| **on) {
                sides
                    .entry(names[local].to_string())
                    .or_default()
                    .push(Facet {
                        block: 0,
                        cell: (j * n + i) as u32,
                        local: local as u32,
                    });
            }
        }
    }
    let block = CellBlock {
        kind,
        nodes,
        group: None,
    };
    Mesh::new(points, vec![block])
        .unwrap()
        .with_sides(sides)
        .unwrap()
}

/// Rectangle with sides bottom right top left.
pub fn rectangle(from: Point<2>, to: Point<2>, cells: [usize; 2], kind: CellKind) -> Mesh<2> {
    mapped(cells, kind, ["bottom", "right", "top", "left"], |s, t| {
        [
            from[0] + s * (to[0] - from[0]),
            from[1] + t * (to[1] - from[1]),
        ]
    })
}

/// Radius of the square of half size `HALF` in a direction.
fn square(angle: f64) -> f64 {
    HALF / angle.cos().abs().max(angle.sin().abs())
}

fn polar(radius: f64, angle: f64) -> Point<2> {
    [radius * angle.cos(), radius * angle.sin()]
}

fn body(name: &str, mesh: Mesh<2>, young: f64) -> Body<2> {
    Body {
        name: name.to_string(),
        mesh,
        materials: vec![Material {
            group: None,
            elastic: Elastic {
                young,
                poisson: 0.3,
            },
        }],
        thickness: 1.0,
        body_force: [Field::constant(0.0), Field::constant(0.0)],
        supports: Vec::new(),
        loads: Vec::new(),
        surfaces: Default::default(),
    }
}

/// A support of a side.
fn held(side: &str, components: [Option<f64>; 2]) -> Support<2> {
    Support {
        place: Place::Side(side.to_string()),
        components: components.map(|c| c.map(Field::constant)),
        normal: None,
    }
}

/// The tunnel with `around` bilinear cells along the interface.
pub fn tunnel(around: usize) -> (Model<2>, Solution<2>) {
    tunnel_of(around, CellKind::Quad4)
}

/// The same with another kind of quadrilateral.
pub fn tunnel_of(around: usize, kind: CellKind) -> (Model<2>, Solution<2>) {
    tunnel_with([around, (around / 12).max(2)], [around, around / 2], kind)
}

/// The same with given cells (around, through) of ring and rock.
pub fn tunnel_with(ring: [usize; 2], rock: [usize; 2], kind: CellKind) -> (Model<2>, Solution<2>) {
    // Clockwise in the first direction, so that the second one points outward in a right-handed grid.
    let angle = |s: f64| PI * (0.5 - s);
    let names = ["inner", "end", "outer", "start"];
    let ring = mapped(ring, kind, names, |s, t| {
        polar(RADIUS - 0.4 * (1.0 - t), angle(s))
    });
    let names = ["hole", "axis_bottom", "far", "axis_top"];
    let rock = mapped(rock, kind, names, |s, t| {
        let a = angle(s);
        polar(RADIUS + t.powf(1.8) * (square(a) - RADIUS), a)
    });
    let mut ring = body("ring", ring, 30e3);
    let mut rock = body("rock", rock, 1e3);
    ring.supports = vec![
        held("start", [Some(0.0), None]),
        held("end", [Some(0.0), None]),
    ];
    rock.supports = vec![
        held("axis_top", [Some(0.0), None]),
        held("axis_bottom", [Some(0.0), None]),
    ];
    rock.loads = vec![Load::Pressure {
        side: "far".to_string(),
        pressure: Field::function("1 + 0.5*y/20", |p, _| 1.0 + 0.5 * p[1] / HALF),
    }];
    rock.supports.push(Support {
        place: Place::Point([HALF, -HALF]),
        components: [None, Some(Field::constant(0.0))],
        normal: None,
    });
    let side = |body: usize, name: &str| SideRef {
        body: BodyId(body),
        side: name.to_string(),
    };
    let model = Model {
        title: "Lined tunnel under uneven pressure".to_string(),
        source: "made-up fields for the tests of the report".to_string(),
        analysis: Analysis::PlaneStrain,
        units: Units {
            length: Some("m".to_string()),
            force: Some("MN".to_string()),
        },
        bodies: vec![ring, rock],
        contacts: vec![Contact {
            name: "lining".to_string(),
            pair: Pair::Given {
                nonmortar: side(0, "outer"),
                mortar: side(1, "hole"),
            },
            pairing: None,
            gap: None,
            law: Law::Frictionless,
        }],
        solver: SolverOptions::default(),
        probes: Vec::new(),
        times: vec![1.0],
    };
    let solution = solution(&model);
    (model, solution)
}

/// A run of one step.
pub fn run<'a>(model: &'a Model<2>, solution: &'a Solution<2>) -> Run<'a> {
    Run {
        model,
        earlier: &[],
        failed: None,
        last: solution,
        stem: "case_1",
        converged: solution.converged,
        seconds: solution.seconds,
        peak_memory: 1 << 20,
    }
}

/// Plausible fields on any model; contacts of given sides with matching nodes get 1 + cos 2θ, cut off where it is small.
fn solution(model: &Model<2>) -> Solution<2> {
    let bodies = model.bodies.iter().map(body_solution).collect();
    let contacts: Vec<_> = model
        .contacts
        .iter()
        .map(|c| contact_solution(model, c))
        .collect();
    let figure = |value: f64, limit: f64| Figure::new(value, 2.0, limit);
    let unknowns = contacts.iter().map(|c| c.nodes.len()).sum();
    Solution {
        time: 1.0,
        bodies,
        contacts,
        certificate: Certificate {
            penetration: figure(3e-12, 1e-8),
            tension: figure(0.0, 1e-8),
            complementarity: figure(4.2e-13, 1e-8),
            imbalance_force: figure(5.1e-15, 1e-10),
            imbalance_moment: figure(8e-14, 1e-10),
            energy_gap: figure(2e-11, 1e-8),
            slip_violation: figure(0.0, 1e-8),
            force_error: figure(0.0, 1e-7),
            between_nodes: figure(0.0, 10.0),
        },
        converged: true,
        solver: SolverReport {
            method: "newton",
            iterations: 6,
            products: 7,
            rho: None,
            history: (1..=6)
                .map(|i| HistoryPoint {
                    iteration: i,
                    residual: 10f64.powi(-((i * i) as i32) / 3),
                    active: 30 - i,
                })
                .collect(),
            bolts: Vec::new(),
            contraction: None,
        },
        warnings: vec![
            "contact lining: 3 nodes of side \"outer\" face nothing & stay open".to_string(),
        ],
        probes: vec![ProbeValue {
            name: "crown".to_string(),
            quantity: "ring.displacement.y".to_string(),
            value: -6.96812e-4,
        }],
        dofs: model.bodies.iter().map(|b| 2 * b.mesh.points().len()).sum(),
        contact_unknowns: unknowns,
        threads: 2,
        seconds: Seconds {
            read: 0.011,
            assemble: 0.032,
            order: 0.02,
            factor: 0.041,
            condense: 0.022,
            contact: 0.003,
            recover: 0.012,
            write: 0.0,
            total: 0.141,
        },
    }
}

fn body_solution(body: &Body<2>) -> BodySolution<2> {
    let points = body.mesh.points();
    let soft = 1.0 / body.materials[0].elastic.young;
    let displacement: Vec<Point<2>> = points
        .iter()
        .map(|p| [soft * 0.3 * p[0], -soft * (0.8 * p[1] + 2.0)])
        .collect();
    let stress: Vec<[f64; 6]> = points
        .iter()
        .map(|p| {
            let r2 = p[0] * p[0] + p[1] * p[1];
            let near = 9.0 / r2.max(1.0);
            let cos2 = (p[0] * p[0] - p[1] * p[1]) / r2.max(1e-9);
            let size = (30.0 * body.materials[0].elastic.young / 30e3).max(1.0);
            [
                -size * (1.0 - near),
                -size * (1.0 + near * cos2),
                -0.3 * size,
                size * near * p[0] * p[1] / r2.max(1e-9),
                0.0,
                0.0,
            ]
        })
        .collect();
    let von_mises = stress
        .iter()
        .map(|s| {
            let d = [s[0] - s[1], s[1] - s[2], s[2] - s[0]];
            (0.5 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) + 3.0 * s[3] * s[3]).sqrt()
        })
        .collect();
    BodySolution {
        name: body.name.clone(),
        reactions: vec![[0.0, 0.0]; points.len()],
        dofs: 2 * points.len(),
        displacement,
        stress,
        von_mises,
        floating_modes: vec![RigidMode {
            description: "translation along y".to_string(),
            displacement: vec![[0.0, 1.0]; points.len()],
        }],
        rigid: RigidMotion {
            translation: [0.0, -2.0 * soft],
            rotation: vec![1e-5],
        },
        side_reactions: BTreeMap::new(),
        reaction: [-40.0, 0.0],
        strain_energy: 0.0123,
    }
}

fn contact_solution(model: &Model<2>, contact: &Contact<2>) -> ContactSolution<2> {
    let (nonmortar, mortar) = match &contact.pair {
        Pair::Given { nonmortar, mortar } => (nonmortar.clone(), Some(mortar.clone())),
        Pair::Automatic([a, b]) => (a.clone(), Some(b.clone())),
        Pair::Obstacle { nonmortar, .. } => (nonmortar.clone(), None),
    };
    let mesh = &model.bodies[nonmortar.body.0].mesh;
    let strand = crate::output::scene::strands(mesh, mesh.side(&nonmortar.side).unwrap()).remove(0);
    let mut order = vec![strand.links[0].ends[0]];
    for link in &strand.links {
        order.extend(link.middle);
        order.push(link.ends[1]);
    }
    if strand.closed {
        order.pop();
    }
    let nodes = order
        .iter()
        .map(|&node| {
            let point = mesh.points()[node];
            let radius = point[0].hypot(point[1]);
            let normal = [point[0] / radius, point[1] / radius];
            let cos2 = normal[0] * normal[0] - normal[1] * normal[1];
            let pressure = (1.0 + 1.4 * cos2).max(0.0);
            let partner = mortar.as_ref().and_then(|m| {
                let other = model.bodies[m.body.0].mesh.points();
                other
                    .iter()
                    .position(|q| (q[0] - point[0]).hypot(q[1] - point[1]) < 1e-9)
            });
            ContactNode {
                node,
                partner,
                point,
                normal,
                weight: PI * RADIUS / (order.len() - 1) as f64,
                gap: (-1e-4 * (1.0 + 1.4 * cos2)).max(0.0),
                pressure,
                shear: [0.0, 0.0],
                slip: [0.0, 0.0],
                displacement_nonmortar: 1e-4,
                displacement_mortar: 2e-4,
                status: if pressure > 0.0 {
                    Status::Closed
                } else {
                    Status::Open
                },
            }
        })
        .collect();
    ContactSolution {
        name: contact.name.clone(),
        nonmortar,
        mortar,
        nodes,
        cyclic: strand.closed,
        resultant: [-6.2, 0.1],
        length: 7.1,
        imbalance: 3e-16,
        dissipated: 0.0,
    }
}
