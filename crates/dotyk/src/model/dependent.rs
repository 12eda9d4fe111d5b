//! Dependent contact conditions: rows of B that follow from others, such as those of a pair of nodes in two contacts.
//!
//! With dependent rows the contact forces are not unique and F is singular. They are found by Cholesky factorisation of
//! BBᵀ on the free dofs with diagonal pivoting, dropped, and named in a warning. A row with a free dof of its own is
//! independent; setting such rows aside again and again leaves few rows, mostly none, for the factorisation.

use crate::fem::{BodySystem, show};
use crate::linalg::{Mat, pivoted_cholesky};
use crate::model::Model;
use crate::model::pair::Paired;
use std::collections::BTreeMap;

/// A row is dependent when less than this part of its square is its own.
const DEPENDENT: f64 = 1e-12;

/// Coefficients of one row on the free dofs, by (body, dof).
type Sparse = Vec<((usize, usize), f64)>;

/// Drops dependent rows: their nodes become fixed. Returns warnings, one for each contact that loses rows.
pub(crate) fn drop_dependent<const D: usize>(
    model: &Model<D>,
    systems: &[BodySystem<D>],
    paired: &mut [Paired<D>],
) -> Vec<String> {
    let mut places = Vec::new();
    let mut rows = Vec::new();
    for (contact, pair) in paired.iter().enumerate() {
        for row in 0..pair.interface.nonmortar.len() {
            places.push((contact, row));
            rows.push(free_part(systems, pair, row));
        }
    }
    let suspects = without_own_dof(&rows);
    if suspects.is_empty() {
        return Vec::new();
    }
    let gram = Mat::from_fn(suspects.len(), suspects.len(), |i, j| {
        product(&rows[suspects[i]], &rows[suspects[j]])
    });
    // finite rows cannot fail
    let Ok((_, dependent)) = pivoted_cholesky(&gram, DEPENDENT) else {
        return Vec::new();
    };
    let mut dropped: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for index in dependent {
        let (contact, row) = places[suspects[index]];
        dropped.entry(contact).or_default().push(row);
    }
    dropped
        .into_iter()
        .map(|(contact, rows)| {
            let warning = describe(
                model,
                &model.contacts[contact].name,
                &paired[contact],
                &rows,
            );
            paired[contact].interface.drop_rows(&rows);
            warning
        })
        .collect()
}

fn free_part<const D: usize>(systems: &[BodySystem<D>], pair: &Paired<D>, row: usize) -> Sparse {
    let mut sums: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    let mut add = |body: usize, row: &[(usize, [f64; D])]| {
        for &(node, coefficients) in row {
            let in_frame = systems[body].row_in_frame(node, coefficients);
            for (component, &value) in in_frame.iter().enumerate() {
                let dof = D * node + component;
                if !systems[body].held[dof] && value != 0.0 {
                    *sums.entry((body, dof)).or_insert(0.0) += value;
                }
            }
        }
    };
    add(pair.nonmortar.body.0, &pair.interface.nonmortar[row]);
    if let Some(part) = pair.opposite {
        add(part, &pair.interface.mortar[row]);
    }
    sums.into_iter().collect()
}

/// Rows that have no dof of their own, once all rows that have one are set aside.
fn without_own_dof(rows: &[Sparse]) -> Vec<usize> {
    let mut users: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        for (dof, _) in row {
            users.entry(*dof).or_default().push(index);
        }
    }
    let mut count: BTreeMap<(usize, usize), usize> =
        users.iter().map(|(dof, rows)| (*dof, rows.len())).collect();
    let mut aside = vec![false; rows.len()];
    let mut own: Vec<(usize, usize)> = count
        .iter()
        .filter(|(_, n)| **n == 1)
        .map(|(dof, _)| *dof)
        .collect();
    while let Some(dof) = own.pop() {
        let Some(&index) = users[&dof].iter().find(|&&index| !aside[index]) else {
            continue;
        };
        aside[index] = true;
        for (other, _) in &rows[index] {
            let left = count.entry(*other).or_insert(0);
            *left = left.saturating_sub(1);
            if *left == 1 {
                own.push(*other);
            }
        }
    }
    (0..rows.len()).filter(|&index| !aside[index]).collect()
}

fn product(a: &Sparse, b: &Sparse) -> f64 {
    let (mut i, mut j, mut sum) = (0, 0, 0.0);
    while i < a.len() && j < b.len() {
        match a[i].0.cmp(&b[j].0) {
            std::cmp::Ordering::Less => i += 1,
            std::cmp::Ordering::Greater => j += 1,
            std::cmp::Ordering::Equal => {
                sum += a[i].1 * b[j].1;
                i += 1;
                j += 1;
            }
        }
    }
    sum
}

/// Most nodes that a warning names.
const NAMED: usize = 4;

fn describe<const D: usize>(
    model: &Model<D>,
    contact: &str,
    pair: &Paired<D>,
    rows: &[usize],
) -> String {
    let body = &model.bodies[pair.nonmortar.body.0];
    let nodes = pair.interface.nodes.iter();
    let places: Vec<String> = nodes
        .filter(|node| node.rows.iter().flatten().any(|row| rows.contains(row)))
        .map(|node| format!("{} at {}", node.node, show(body.mesh.points()[node.node])))
        .collect();
    let more = match places.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!(
        "contact \"{contact}\": the condition of node {}{more} of {}.{} follows from supports and other contacts; it is dropped, and the pressure there is not defined",
        places[..places.len().min(NAMED)].join(", "),
        body.name,
        pair.nonmortar.side
    )
}
