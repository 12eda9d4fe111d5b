//! Contact sides with sharp corners as several contacts, one for each smooth part: a corner has a row for each of its faces. A corner
//! that meets an obstacle between its faces has one row, which stands for a row of each face with the same pressure.

use crate::plane::{Vector, cross, dot, length, minus, times, unit};
use crate::problem::{Against, Contact as Touching, Law, Pairing, Problem, Surface};
use crate::raw::{Answer, Contact, Mesh, Row};
use crate::side::SHARP;
use crate::touch::faces_obstacle;

/// Separator between the name of a side and the number of its part.
const MARK: char = '#';

/// The name of the side that a part belongs to.
pub fn whole(side: &str) -> &str {
    side.split(MARK).next().unwrap_or(side)
}

/// The answer with the parts of sides as sides, and the contact of the problem that each of its contacts is a part of.
pub fn split(problem: &Problem, answer: &Answer) -> (Answer, Vec<usize>) {
    let mut parted = answer.clone();
    let mut owners = Vec::new();
    let Some(first) = answer.steps.first() else {
        return (parted, owners);
    };
    for step in &mut parted.steps {
        step.contacts.clear();
    }
    for (c, (contact, raw)) in problem.contacts.iter().zip(&first.contacts).enumerate() {
        let (body, side) = &raw.nonmortar;
        let mesh = &answer.meshes[*body];
        let parts = match contact.law {
            Law::Tied => Vec::new(),
            _ => parts(mesh, &mesh.sides[side]),
        };
        if parts.len() < 2 {
            owners.push(c);
            for (to, from) in parted.steps.iter_mut().zip(&answer.steps) {
                to.contacts.push(from.contacts[c].clone());
            }
            continue;
        }
        for (number, facets) in parts.iter().enumerate() {
            let name = format!("{side}{MARK}{number}");
            parted.meshes[*body]
                .sides
                .insert(name.clone(), facets.clone());
            owners.push(c);
            for (to, from) in parted.steps.iter_mut().zip(&answer.steps) {
                let rows = from.contacts[c].rows.iter();
                let own = rows.filter_map(|row| {
                    let whole = &mesh.sides[side];
                    match (&contact.against, met(contact, mesh, whole, row.node)) {
                        (Against::Obstacle { surface, .. }, Some(way)) => {
                            shared(surface, mesh, whole, (facets, way), row)
                        }
                        _ => {
                            (nearest(mesh, &parts, row.node, row.normal) == number).then_some(*row)
                        }
                    }
                });
                to.contacts.push(Contact {
                    nonmortar: (*body, name.clone()),
                    rows: own.collect(),
                    resultant: from.contacts[c].resultant,
                    moment: from.contacts[c].moment,
                });
            }
        }
    }
    (parted, owners)
}

/// The outward normal at an end of a facet, of the straight line to its next node.
fn normal(mesh: &Mesh, facet: &[usize], node: usize) -> Vector {
    let at = |place: usize| mesh.points[facet[place]];
    let tangent = match (facet.len(), node) {
        (3, n) if n == facet[0] => {
            let (a, b, m) = (at(0), at(1), at(2));
            [
                4.0 * m[0] - 3.0 * a[0] - b[0],
                4.0 * m[1] - 3.0 * a[1] - b[1],
            ]
        }
        (3, n) if n == facet[1] => {
            let (a, b, m) = (at(0), at(1), at(2));
            [
                3.0 * b[0] + a[0] - 4.0 * m[0],
                3.0 * b[1] + a[1] - 4.0 * m[1],
            ]
        }
        _ => minus(at(1), at(0)),
    };
    let [x, y] = unit(tangent);
    [y, -x]
}

/// The direction from a sharp corner (a node) of a side to the obstacle that it meets between its faces; `None` for other nodes.
pub fn met(contact: &Touching, mesh: &Mesh, side: &[Vec<usize>], node: usize) -> Option<Vector> {
    let Against::Obstacle { surface, .. } = &contact.against else {
        return None;
    };
    if contact.pairing == Pairing::Mortar || matches!(contact.law, Law::Tied) {
        return None;
    }
    let at_node = side.iter().filter(|facet| facet.contains(&node));
    let normals: Vec<Vector> = at_node.map(|facet| normal(mesh, facet, node)).collect();
    let [a, b] = normals[..] else {
        return None;
    };
    let way = match surface {
        Surface::Gap(_) => return None,
        Surface::Plane { normal, .. } => times(-1.0, *normal),
        Surface::Circle { center, inside, .. } => {
            let outward = unit(minus(mesh.points[node], *center));
            if *inside {
                outward
            } else {
                times(-1.0, outward)
            }
        }
    };
    let parts = [cross(way, b), cross(a, way)].map(|part| part / cross(a, b));
    (dot(a, b) <= SHARP && parts.iter().all(|&part| part > 1e-9)).then_some(way)
}

/// The share of one face in the row of such a corner: in proportion to the lengths of its facets that face the obstacle, or of all
/// its facets if no facet at the corner faces it.
fn shared(
    surface: &Surface,
    mesh: &Mesh,
    side: &[Vec<usize>],
    (facets, way): (&[Vec<usize>], Vector),
    row: &Row,
) -> Option<Row> {
    let faces = |facet: &&Vec<usize>| {
        facet.iter().take(2).all(|&node| {
            let own = normal(mesh, facet, node);
            let towards = if node == row.node { way } else { own };
            faces_obstacle(surface, mesh.points[node], towards)
        })
    };
    let at_node = || side.iter().filter(|facet| facet.contains(&row.node));
    let none = !at_node().any(|facet| faces(&facet));
    let bears = |facet: &&Vec<usize>| none || faces(facet);
    let long = |facet: &Vec<usize>| length(minus(mesh.points[facet[1]], mesh.points[facet[0]]));
    let all: f64 = at_node().filter(bears).map(long).sum();
    let own = facets.iter().filter(|facet| facet.contains(&row.node));
    let own: f64 = own.filter(bears).map(long).sum();
    let weight = row.weight * own / all;
    (own > 0.0).then_some(Row { weight, ..*row })
}

/// Facets of a side, divided at sharp corners; empty for a side without sharp corners.
fn parts(mesh: &Mesh, side: &[Vec<usize>]) -> Vec<Vec<Vec<usize>>> {
    let mut part: Vec<usize> = (0..side.len()).collect();
    let mut sharp = false;
    for (a, first) in side.iter().enumerate() {
        for (b, second) in side.iter().enumerate().skip(a + 1) {
            for node in first.iter().filter(|node| second.contains(node)) {
                let normals = (normal(mesh, first, *node), normal(mesh, second, *node));
                if dot(normals.0, normals.1) > SHARP {
                    let (from, to) = (part[a].max(part[b]), part[a].min(part[b]));
                    part.iter_mut()
                        .filter(|p| **p == from)
                        .for_each(|p| *p = to);
                } else {
                    sharp = true;
                }
            }
        }
    }
    if !sharp {
        return Vec::new();
    }
    let mut names = part.clone();
    names.sort_unstable();
    names.dedup();
    let of = |name: &usize| {
        let own = side.iter().zip(&part).filter(|(_, p)| *p == name);
        own.map(|(facet, _)| facet.clone()).collect()
    };
    names.iter().map(of).collect()
}

/// The part to which a row belongs: the one at its node whose normal there is nearest to that of the row.
fn nearest(mesh: &Mesh, parts: &[Vec<Vec<usize>>], node: usize, row: Vector) -> usize {
    let angle = |facet: &Vec<usize>| {
        let own = normal(mesh, facet, node);
        cross(own, row).atan2(dot(own, row)).abs()
    };
    let least = |part: &Vec<Vec<usize>>| {
        let at = part.iter().filter(|facet| facet.contains(&node));
        at.map(angle).fold(f64::INFINITY, f64::min)
    };
    let angles: Vec<f64> = parts.iter().map(least).collect();
    (0..parts.len())
        .min_by(|&a, &b| angles[a].total_cmp(&angles[b]))
        .unwrap_or(0)
}
