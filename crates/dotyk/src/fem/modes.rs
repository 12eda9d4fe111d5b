//! Rigid motions that supports leave free: the kernel of K on the free dofs.
//!
//! Every facet-connected component c of a body may move as u(x) = Σ aₖ φₖ(x − x_c). Held directions, those of springs, and nodes that two
//! components share without sharing a facet, are linear conditions on the amplitudes a; their null space is the kernel.

use crate::fem::error::{Short, show};
use crate::fem::nouns::Analysis;
use crate::fem::springs::Direction;
use crate::fem::supports::Constraints;
use crate::geometry::{Point, add_scaled, bounding_box, cross, dot, norm, padded, sub};
use crate::linalg::{Mat, least_squares, null_space};
use crate::mesh::Mesh;

/// Which rigid motions an analysis knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RigidBasis {
    /// All translations and rotations.
    Full,
    /// Translation along the axis of symmetry (y) only.
    Axial,
}

impl RigidBasis {
    /// The strain-free motions of an analysis.
    pub fn of(analysis: Analysis) -> Self {
        if analysis == Analysis::Axisymmetric {
            Self::Axial
        } else {
            Self::Full
        }
    }

    /// Number of motions of one component in D dimensions.
    pub fn len(self, dimension: usize) -> usize {
        if self == Self::Axial {
            1
        } else {
            dimension * (dimension + 1) / 2
        }
    }

    /// Whether there are none (never).
    pub fn is_empty(self) -> bool {
        false
    }

    /// Displacement of the k-th motion at a point relative to the centre: rotations first, then translations.
    pub(crate) fn displacement<const D: usize>(self, k: usize, x: Point<D>) -> Point<D> {
        if self == Self::Axial {
            return std::array::from_fn(|i| if i == 1 { 1.0 } else { 0.0 });
        }
        let rotations = D * (D - 1) / 2;
        if k >= rotations {
            return std::array::from_fn(|i| if i == k - rotations { 1.0 } else { 0.0 });
        }
        // rotation in the plane (p, q): (x_p, x_q) ↦ (−x_q, x_p); in space the k-th is about axis k
        let (p, q) = match D {
            2 => (0, 1),
            _ => ((k + 1) % 3, (k + 2) % 3),
        };
        std::array::from_fn(|i| {
            if i == p {
                -x[q]
            } else if i == q {
                x[p]
            } else {
                0.0
            }
        })
    }
}

/// Conditions count as satisfied below this fraction of the largest.
const RANK_TOLERANCE: f64 = 1e-9;

/// Columns of R in global axes, (D·n,) each, scaled to largest displacement 1; `sprung` are the directions in which springs hold.
pub(crate) fn free_modes<const D: usize>(
    mesh: &Mesh<D>,
    (constraints, sprung): (&Constraints<D>, &[Direction<D>]),
    basis: RigidBasis,
) -> Vec<Vec<f64>> {
    let (components, members) = node_components(mesh);
    let count = basis.len(D);
    let frames: Vec<(Point<D>, f64)> = components.iter().map(|nodes| centre(mesh, nodes)).collect();
    let motion = |component: usize, k: usize, node: usize| -> Point<D> {
        let (origin, size) = frames[component];
        basis.displacement(k, sub(mesh.points()[node], origin).map(|c| c / size))
    };
    let unknowns = count * components.len();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let supports = constraints.nodes.iter();
    let held = supports.flat_map(|(&node, held)| held.iter().map(move |h| (node, h.axis)));
    let held = held.map(|(node, axis)| (vec![(node, 1.0)], axis));
    for (nodes, axis) in held.chain(sprung.iter().cloned()) {
        let mut row = vec![0.0; unknowns];
        for (node, n) in nodes {
            let component = members[node][0];
            for k in 0..count {
                row[count * component + k] += n * dot(axis, motion(component, k, node));
            }
        }
        rows.push(row);
    }
    for (node, owners) in members.iter().enumerate() {
        for pair in owners.windows(2) {
            for i in 0..D {
                let mut row = vec![0.0; unknowns];
                for k in 0..count {
                    row[count * pair[0] + k] = motion(pair[0], k, node)[i];
                    row[count * pair[1] + k] = -motion(pair[1], k, node)[i];
                }
                rows.push(row);
            }
        }
    }
    amplitudes(&rows, unknowns)
        .iter()
        .map(|a| expand(mesh, &members, count, a, &motion))
        .collect()
}

/// The rigid motion of the whole body that fits the prescribed displacements best (least squares, of least norm where
/// they leave it open), (D·n,) in global axes; zero when all prescribed values are.
pub(crate) fn carried_motion<const D: usize>(
    mesh: &Mesh<D>,
    constraints: &Constraints<D>,
    basis: RigidBasis,
) -> Vec<f64> {
    let none = || vec![0.0; D * mesh.points().len()];
    let held: Vec<(usize, Point<D>, f64)> = constraints
        .nodes
        .iter()
        .flat_map(|(&node, held)| held.iter().map(move |h| (node, h.axis, h.value)))
        .collect();
    if held.iter().all(|h| h.2 == 0.0) {
        return none();
    }
    let all: Vec<usize> = (0..mesh.points().len()).collect();
    let (origin, size) = centre(mesh, &all);
    let motion = |k: usize, node: usize| {
        basis.displacement(k, sub(mesh.points()[node], origin).map(|c| c / size))
    };
    // normal equations: a body may have many held nodes, and the motions are well scaled
    let count = basis.len(D);
    let mut normal = Mat::<f64>::zeros(count, count);
    let mut rhs = Mat::<f64>::zeros(count, 1);
    for &(node, axis, value) in &held {
        let row: Vec<f64> = (0..count).map(|k| dot(axis, motion(k, node))).collect();
        for (k, a) in row.iter().enumerate() {
            rhs[(k, 0)] += a * value;
            for (l, b) in row.iter().enumerate() {
                normal[(k, l)] += a * b;
            }
        }
    }
    // finite input cannot fail
    let Ok(amplitudes) = least_squares(&normal, &rhs, RANK_TOLERANCE) else {
        return none();
    };
    (0..mesh.points().len())
        .flat_map(|node| {
            (0..count).fold([0.0; D], |sum, k| {
                add_scaled(sum, amplitudes[(k, 0)], motion(k, node))
            })
        })
        .collect()
}

/// Null space of the conditions, reduced so that pure motions show as such.
fn amplitudes(rows: &[Vec<f64>], unknowns: usize) -> Vec<Vec<f64>> {
    if rows.is_empty() {
        let unit = |k: usize| {
            (0..unknowns)
                .map(|i| if i == k { 1.0 } else { 0.0 })
                .collect()
        };
        return (0..unknowns).map(unit).collect();
    }
    let matrix = Mat::from_fn(rows.len(), unknowns, |i, j| rows[i][j]);
    // the conditions are finite: directions are unit vectors and points were checked by the mesh
    let Ok(null) = null_space(&matrix, RANK_TOLERANCE) else {
        return Vec::new();
    };
    let mut basis: Vec<Vec<f64>> = (0..null.ncols())
        .map(|j| (0..unknowns).map(|i| null[(i, j)]).collect())
        .collect();
    reduce(&mut basis);
    basis
}

/// Gauss–Jordan on the vectors, with the largest entry as pivot, entries below rounding cleared.
fn reduce(basis: &mut [Vec<f64>]) {
    let mut used: Vec<usize> = Vec::new();
    for k in 0..basis.len() {
        let pivot = (0..basis[k].len())
            .filter(|i| !used.contains(i))
            .max_by(|&i, &j| {
                basis[k][i]
                    .abs()
                    .total_cmp(&basis[k][j].abs())
                    .then(j.cmp(&i))
            });
        let Some(pivot) = pivot else { return };
        used.push(pivot);
        let scale = basis[k][pivot];
        basis[k].iter_mut().for_each(|value| *value /= scale);
        let row = basis[k].clone();
        for (other, vector) in basis.iter_mut().enumerate() {
            if other != k {
                let factor = vector[pivot];
                vector
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(value, r)| *value -= factor * r);
            }
        }
    }
    for value in basis.iter_mut().flatten() {
        if value.abs() < 1e-12 {
            *value = 0.0;
        }
    }
}

fn expand<const D: usize>(
    mesh: &Mesh<D>,
    members: &[Vec<usize>],
    count: usize,
    amplitudes: &[f64],
    motion: &impl Fn(usize, usize, usize) -> Point<D>,
) -> Vec<f64> {
    let mut mode = Vec::with_capacity(D * members.len());
    let mut largest: f64 = 0.0;
    for (node, owners) in members.iter().enumerate().take(mesh.points().len()) {
        let component = owners[0];
        let u = (0..count).fold([0.0; D], |sum, k| {
            add_scaled(
                sum,
                amplitudes[count * component + k],
                motion(component, k, node),
            )
        });
        largest = largest.max(norm(u));
        mode.extend(u);
    }
    mode.iter_mut().for_each(|value| *value /= largest);
    mode
}

/// Nodes of every facet-connected component, and the components of every node.
fn node_components<const D: usize>(mesh: &Mesh<D>) -> (Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let of_cell = mesh.facet_components();
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); mesh.points().len()];
    let cells = mesh.blocks().iter().flat_map(|block| block.cells());
    let mut count = 0;
    for (cell, &component) in cells.zip(&of_cell) {
        let component = component as usize;
        count = count.max(component + 1);
        for &node in cell {
            let owners = &mut members[node as usize];
            if !owners.contains(&component) {
                owners.push(component);
            }
        }
    }
    let mut components = vec![Vec::new(); count];
    for (node, owners) in members.iter().enumerate() {
        for &component in owners {
            components[component].push(node);
        }
    }
    (components, members)
}

/// Centroid of some nodes and half the diagonal of their bounding box.
fn centre<const D: usize>(mesh: &Mesh<D>, nodes: &[usize]) -> (Point<D>, f64) {
    let points: Vec<Point<D>> = nodes.iter().map(|&node| mesh.points()[node]).collect();
    let (low, high) = bounding_box(&points);
    let middle = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
    (middle, 0.5 * norm(sub(high, low)))
}

/// Motions of a body of D dimensions in words, from those of each; six of space are every one.
pub fn list_motions<const D: usize>(motions: &[String]) -> String {
    match (D, motions.len()) {
        (3, 6) => "every rigid motion".to_string(),
        _ => motions.join(", "),
    }
}

/// A rigid motion in words, from the displacement it gives every node: "translation along y", "rotation about (1, 2)", in
/// space "rotation about z through (1, 2, 0)", or a screw, which moves along its axis, too. Of a body in pieces it is that of those which
/// move.
pub fn describe_motion<const D: usize>(points: &[Point<D>], motion: &[Point<D>]) -> String {
    let (centre, _) = middle(points);
    let fit = fit_rigid(RigidBasis::Full, points, motion, centre);
    let most = motion.iter().fold(0.0, |most: f64, u| most.max(norm(*u)));
    let fits = |(&point, &u): (&Point<D>, &Point<D>)| {
        norm(sub(u, moved_by(&fit, sub(point, centre)))) <= AT_REST * most
    };
    if points.iter().zip(motion).all(fits) {
        return as_one(points, fit);
    }
    let both = points.iter().zip(motion);
    let moving = both.filter(|(_, u)| norm(**u) > AT_REST * most);
    let (points, motion): (Vec<Point<D>>, Vec<Point<D>>) = moving.unzip();
    let (centre, _) = middle(&points);
    let fit = fit_rigid(RigidBasis::Full, &points, &motion, centre);
    format!("{} of a part of it", as_one(&points, fit))
}

/// Motions below this part of the largest one are none.
const AT_REST: f64 = 1e-6;

/// Centre and size of the box around some points.
fn middle<const D: usize>(points: &[Point<D>]) -> (Point<D>, f64) {
    let (low, high) = bounding_box(points);
    let centre = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
    (centre, norm(sub(high, low)))
}

/// The displacement of a rigid motion at x from its centre: t + ω × x.
fn moved_by<const D: usize>((translation, spin): &(Point<D>, Vec<f64>), x: Point<D>) -> Point<D> {
    let turned = cross(spin_in_space(spin), padded(x));
    std::array::from_fn(|i| translation[i] + turned[i])
}

/// A rigid motion about the middle of some points, in words.
fn as_one<const D: usize>(
    points: &[Point<D>],
    (translation, spin): (Point<D>, Vec<f64>),
) -> String {
    let (centre, size) = middle(points);
    let spin = spin_in_space(&spin);
    let turn = norm(spin);
    // a centre a thousand sizes away is useless
    if turn * size < 1e-3 * norm(translation) {
        return format!("translation along {}", direction(translation));
    }
    // the axis passes through c = centre + ω × t/|ω|², where t + ω × (c − centre) lies along ω
    let offset = cross(spin, padded(translation));
    let c: Point<D> = std::array::from_fn(|i| centre[i] + offset[i] / (turn * turn));
    let place = show(c.map(|v| if v.abs() < 1e-9 * size { 0.0 } else { v }));
    if D == 2 {
        return format!("rotation about {place}");
    }
    let along = dot(spin, padded(translation)).abs();
    let motion = match along < 1e-3 * turn * turn * size {
        true => "rotation",
        false => "screw",
    };
    format!("{motion} about {} through {place}", direction(spin))
}

/// Angular velocity of a rigid motion from its components: about z in the plane.
fn spin_in_space(spin: &[f64]) -> [f64; 3] {
    match *spin {
        [z] => [0.0, 0.0, z],
        [x, y, z] => [x, y, z],
        _ => [0.0; 3],
    }
}

fn direction<const D: usize>(vector: Point<D>) -> String {
    let size = norm(vector);
    let unit = vector.map(|c| if c.abs() < 1e-9 * size { 0.0 } else { c / size });
    match unit.iter().position(|c| (c.abs() - 1.0).abs() < 1e-9) {
        Some(axis) => ["x", "y", "z"][axis].to_string(),
        None => format!("({})", unit.map(|c| Short(c).to_string()).join(", ")),
    }
}

/// Least-squares rigid motion about a centre: translation, and one angle in 2D or the angles about x, y, z in 3D.
pub(crate) fn fit_rigid<const D: usize>(
    basis: RigidBasis,
    points: &[Point<D>],
    motion: &[Point<D>],
    centre: Point<D>,
) -> (Point<D>, Vec<f64>) {
    let count = basis.len(D);
    let (low, high) = bounding_box(points);
    let size = norm(sub(high, low)).max(f64::MIN_POSITIVE);
    let mut normal = Mat::<f64>::zeros(count, count);
    let mut rhs = vec![0.0; count];
    for (&point, &u) in points.iter().zip(motion) {
        let x = sub(point, centre).map(|c| c / size);
        for k in 0..count {
            let phi = basis.displacement(k, x);
            rhs[k] += dot(phi, u);
            for l in 0..count {
                normal[(k, l)] += dot(phi, basis.displacement(l, x));
            }
        }
    }
    let rhs = Mat::from_fn(count, 1, |i, _| rhs[i]);
    // finite input cannot fail; a motion that is not finite has no best rigid motion
    let amplitudes = least_squares(&normal, &rhs, RANK_TOLERANCE)
        .map_or_else(|_| vec![f64::NAN; count], |x| x.col_as_slice(0).to_vec());
    let rotations = D * (D - 1) / 2;
    if basis == RigidBasis::Axial {
        let along = std::array::from_fn(|i| if i == 1 { amplitudes[0] } else { 0.0 });
        return (along, vec![0.0; rotations]);
    }
    let spin = amplitudes[..rotations].iter().map(|a| a / size).collect();
    (std::array::from_fn(|i| amplitudes[rotations + i]), spin)
}
