//! Contact sides with sharp corners as several contacts, one for each smooth part: a corner has a row for each of its faces.

use crate::plane::{Vector, cross, dot, minus, unit};
use crate::problem::{Law, Problem};
use crate::raw::{Answer, Contact, Mesh};
use crate::side::SHARP;

/// Between the name of a side and the number of its part.
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
                let own = rows.filter(|row| nearest(mesh, &parts, row.node, row.normal) == number);
                to.contacts.push(Contact {
                    nonmortar: (*body, name.clone()),
                    rows: own.copied().collect(),
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

/// Facets of a side, taken apart at sharp corners; empty where it has none.
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
