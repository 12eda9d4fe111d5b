//! Conditions that follow from others, such as those of a pair of nodes in two contacts.
//!
//! A condition implied by *ties and supports* has a gap that no contact force changes, and of two frictionless conditions that are
//! the same at all times one is redundant: these get no multiplier, are named in a warning, and are judged all the same. A slip
//! prescribed by supports of both sides is not such a condition: the law gives a shear for it. Other inequalities imply none: of
//! two obstacles under one side either may be the nearer one, and on the two rough walls of a corner a node may stick or slip.
//! They keep their multipliers although F is singular; where dependent ones bear a force, their shares of the sum are not unique:
//! those of least pressures are told, and a warning says so.
//!
//! Dependence is found by Cholesky factorisation of BBᵀ on the free dofs with diagonal pivoting. A row with a free dof of its
//! own is independent; setting such rows aside repeatedly leaves few rows, mostly none, for the factorisation.

use crate::contact::Coupling;
use crate::dual::DualProblem;
use crate::fem::{BodySystem, CoupleKind, show};
use crate::linalg::dense::{
    cholesky_in_place, solve_lower_in_place, solve_lower_transpose_in_place,
};
use crate::linalg::{Mat, pivoted_cholesky};
use crate::model::nouns::model::{Law, Model};
use crate::model::system::bodies::LoadedBody;
use crate::model::system::condition::{Condition, gap_varies, row_ranges};
use std::collections::{BTreeMap, BTreeSet};

/// A row is dependent when less than this part of its square is its own.
const DEPENDENT: f64 = 1e-12;

/// Coefficients below this part of the largest of a row are rounding of its integrals: no dof of its own.
const NO_PART: f64 = 1e-12;

/// Larger groups of forces that share dofs are only counted, not examined one by one.
const TOGETHER: usize = 3000;

/// Tractions of ties count by so much less than those of contacts.
const LESS: f64 = 1e6;

/// Parts of forces below this are rounding.
const ROUNDING: f64 = 1e-10;

/// Coefficients of one row on the free dofs, by (body, dof).
type Sparse = Vec<((usize, usize), f64)>;

/// Where a row is: its contact, and its index there.
type Place = (usize, usize);

/// Tangential gaps above this part of the length scale are slip.
const SLIP: f64 = 1e-9;

/// Two gaps are the same within this part of the size of the body.
const SAME_GAP: f64 = 1e-12;

/// Takes the multipliers of implied conditions. Returns warnings, one for each contact that loses some.
pub(crate) fn drop_implied<const D: usize>(
    model: &Model<D>,
    systems: &[BodySystem<D>],
    conditions: &mut [Condition<D>],
) -> Vec<String> {
    let refs: Vec<&BodySystem<D>> = systems.iter().collect();
    let (places, rows) = suspects(&refs, conditions);
    let tied = |&(contact, _): &Place| conditions[contact].interface.coupling == Coupling::Tied;
    let equalities: Vec<usize> = (0..rows.len()).filter(|&i| tied(&places[i])).collect();
    let (basis, mut implied) = split(&rows, &equalities);
    // a slip prescribed by supports follows from them, but the law still gives its shear
    let shears: Vec<Vec<bool>> = conditions.iter().map(|p| p.slides()).collect();
    let prescribed = |i: usize| rows[i].is_empty() && shears[places[i].0][places[i].1];
    let rest = (0..rows.len()).filter(|&i| !tied(&places[i]) && !prescribed(i));
    implied.extend(within(&rows, &basis, rest));
    implied.extend(repeated(model, conditions, &places, &rows));
    implied.sort_unstable();
    implied.dedup();
    let mut dropped: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for index in implied {
        let (contact, row) = places[index];
        dropped.entry(contact).or_default().push(row);
    }
    let drop = |(contact, rows): (usize, Vec<usize>)| {
        let nodes = describe(model, &conditions[contact], &rows);
        let condition = &mut conditions[contact];
        let mut nodes_of = condition.interface.nodes.iter();
        let pressure = nodes_of.any(|node| node.rows[0].is_some_and(|row| rows.contains(&row)));
        condition.drop_rows(&rows);
        let undefined = match condition.contact() {
            Some(_) if pressure => "the pressure there is not defined",
            Some(_) => "the shear there is not defined",
            None => "how it shares its force with these is not unique",
        };
        format!(
            "{}: the condition of {nodes} follows from supports and other conditions; it is dropped, and {undefined}",
            condition.called(model)
        )
    };
    dropped.into_iter().map(drop).collect()
}

/// Forces that are free to change, of rows that may depend on others.
struct Movable {
    /// What one unit of each does.
    columns: Vec<Sparse>,
    owners: Vec<Place>,
    /// The components of λ that change by one unit of each: a normal force takes the shear of a node that slips along.
    parts: Vec<Vec<(usize, f64)>>,
}

impl Movable {
    /// Normal forces that push, with the shear of nodes that slip, and shears that stick; `gaps` (m,) show which nodes slip.
    fn of<const D: usize>(
        (bodies, conditions): (&[LoadedBody<D>], &[Condition<D>]),
        problem: &DualProblem,
        lambda: &[f64],
        gaps: &[f64],
    ) -> Self {
        let systems: Vec<&BodySystem<D>> = bodies.iter().map(|body| &body.system).collect();
        let (places, rows) = suspects(&systems, conditions);
        let (columns, owners, parts) = (Vec::new(), Vec::new(), Vec::new());
        let mut found = Self {
            columns,
            owners,
            parts,
        };
        if rows.is_empty() {
            return found;
        }
        let starts: Vec<usize> = row_ranges(conditions).map(|(rows, _)| rows.start).collect();
        let row_of: BTreeMap<usize, usize> = (0..rows.len())
            .map(|i| (starts[places[i].0] + places[i].1, i))
            .collect();
        let slips = |i: usize| gaps[i].abs() > SLIP * problem.scales.length;
        for (block, range) in problem.admissible.iter() {
            // an interval has an elastic part of its own
            let free = block.is_free();
            if !free && (!block.is_normal() || lambda[range.start] <= 0.0) {
                continue;
            }
            let known = range.clone().filter_map(|i| Some((i, *row_of.get(&i)?)));
            let alone = |&(i, _): &(usize, usize)| free || i > range.start && !slips(i);
            for (i, row) in known.filter(alone) {
                found.push((rows[row].clone(), places[row]), vec![(i, 1.0)]);
            }
            let normal = row_of.get(&range.start).filter(|_| !free);
            let Some(&first) = normal else { continue };
            let (mut column, mut along) = (rows[first].clone(), vec![(range.start, 1.0)]);
            let slipping = range.clone().skip(1).filter(|&i| slips(i));
            let rows_along: Option<Vec<(usize, usize)>> =
                slipping.map(|i| Some((i, *row_of.get(&i)?))).collect();
            // a shear with a dof of its own that goes with the normal force holds this
            let Some(rows_along) = rows_along else {
                continue;
            };
            for (i, row) in rows_along {
                let share = lambda[i] / lambda[range.start];
                column = combine(&column, share, &rows[row]);
                along.push((i, share));
            }
            found.push((column, places[first]), along);
        }
        found
    }

    fn push(&mut self, (column, owner): (Sparse, Place), parts: Vec<(usize, f64)>) {
        self.columns.push(column);
        self.owners.push(owner);
        self.parts.push(parts);
    }
}

/// Forces that are not unique.
pub(crate) struct Shared {
    /// A warning.
    pub words: String,
    /// Forces (m,) of contacts that do the same with the least pressures and shears ∫ p² (and of ties, where these do not decide): where
    /// two tied bodies stand on a third one, the pressure goes on from one to the other. `None` where they are the given ones.
    pub least: Option<Vec<f64>>,
}

/// What is not unique of forces λ (m,) of these bodies and conditions, because the rows of several contacts at a node are dependent;
/// `gaps` (m,) show which nodes slip.
pub(crate) fn shared_forces<const D: usize>(
    model: &Model<D>,
    (bodies, conditions): (&[LoadedBody<D>], &[Condition<D>]),
    problem: &DualProblem,
    lambda: &[f64],
    gaps: &[f64],
) -> Option<Shared> {
    let movable = Movable::of((bodies, conditions), problem, lambda, gaps);
    let (columns, owners) = (&movable.columns, &movable.owners);
    let all: Vec<usize> = (0..columns.len()).collect();
    let (mut dependent, mut involved) = (Vec::new(), BTreeSet::new());
    for together in connected(columns, &all) {
        let contacts = together.iter().map(|&i| owners[i].0);
        let contacts: BTreeSet<usize> = contacts.collect();
        let found = match together.len() > TOGETHER {
            // more forces than dofs: some of them are dependent
            true if together.len() > dofs_of(columns, &together) => together,
            true => Vec::new(),
            false => split_together(columns, &together).1,
        };
        if !found.is_empty() {
            involved.extend(contacts);
            dependent.extend(found);
        }
    }
    let (contact, _) = *dependent.iter().map(|&i| &owners[i]).min()?;
    let own = dependent.iter().filter(|&&i| owners[i].0 == contact);
    let own: Vec<usize> = own.map(|&i| owners[i].1).collect();
    let bear = match involved.len() {
        1 => "several of its forces do the same",
        _ => "several contacts bear the same force",
    };
    Some(Shared {
        words: format!(
            "{}: at {} {bear}; how they share it is not unique",
            conditions[contact].called(model),
            describe(model, &conditions[contact], &own)
        ),
        least: movable.least(conditions, problem, lambda),
    })
}

impl Movable {
    /// The least forces, as [`Shared`] tells of them, within the bounds of their laws: an iteration may leave λ beside these by more than
    /// rounding. Whether they still balance is for the judge.
    fn least<const D: usize>(
        &self,
        conditions: &[Condition<D>],
        problem: &DualProblem,
        lambda: &[f64],
    ) -> Option<Vec<f64>> {
        let (columns, owners) = (&self.columns, &self.owners);
        let all = 0..columns.len();
        let own = all.filter(|&i| conditions[owners[i].0].contact().is_some());
        let own: Vec<usize> = own.collect();
        let area = |i: usize| area_of(&conditions[owners[i].0], owners[i].1);
        let force = |i: usize| lambda[self.parts[i][0].0];
        let mut least = lambda.to_vec();
        let groups = connected(columns, &own).into_iter();
        for together in groups.filter(|together| together.len() <= TOGETHER) {
            let (basis, dependent) = split_together(columns, &together);
            if dependent.is_empty() {
                continue;
            }
            let change = to_least(columns, (&basis, &dependent), area, force)?;
            for (index, change) in change {
                for &(row, share) in &self.parts[index] {
                    least[row] += share * change;
                }
            }
        }
        let mut allowed = least.clone();
        problem.admissible.project(&least, &mut allowed);
        let size = |of: &mut dyn Iterator<Item = f64>| of.map(|x| x * x).sum::<f64>().sqrt();
        let moved = size(&mut allowed.iter().zip(lambda).map(|(a, b)| a - b));
        (moved > ROUNDING * size(&mut lambda.iter().copied())).then_some(allowed)
    }
}

/// Changes of forces, by their index, to those of least Σ force²/area that do the same: with aⱼ the shares of a dependent force among
/// the basis, nⱼ = eⱼ − aⱼ changes nothing, and the changes are −N (Nᵀ A⁻¹ N)⁻¹ Nᵀ A⁻¹ λ. `None` where that cannot be solved.
fn to_least(
    columns: &[Sparse],
    (basis, dependent): (&[usize], &[usize]),
    area: impl Fn(usize) -> f64,
    force: impl Fn(usize) -> f64,
) -> Option<Vec<(usize, f64)>> {
    let products = |of: &[usize]| {
        Mat::from_fn(basis.len(), of.len(), |i, j| {
            product(&columns[basis[i]], &columns[of[j]])
        })
    };
    let mut factor = products(basis);
    let mut shares = products(dependent);
    cholesky_in_place(&mut factor).ok()?;
    solve_lower_in_place(&factor, &mut shares);
    solve_lower_transpose_in_place(&factor, &mut shares);
    let by_area = |i: usize, j: usize| -> f64 {
        let own = if i == j {
            1.0 / area(dependent[i])
        } else {
            0.0
        };
        let all = (0..basis.len()).map(|k| shares[(k, i)] * shares[(k, j)] / area(basis[k]));
        own + all.sum::<f64>()
    };
    let mut metric = Mat::from_fn(dependent.len(), dependent.len(), by_area);
    let mut amounts = Mat::from_fn(dependent.len(), 1, |j, _| {
        let own = force(dependent[j]) / area(dependent[j]);
        let all = (0..basis.len()).map(|k| shares[(k, j)] * force(basis[k]) / area(basis[k]));
        all.sum::<f64>() - own
    });
    cholesky_in_place(&mut metric).ok()?;
    solve_lower_in_place(&metric, &mut amounts);
    solve_lower_transpose_in_place(&metric, &mut amounts);
    let amount = |j: usize| amounts[(j, 0)];
    let of_basis = basis.iter().enumerate().map(|(k, &index)| {
        let shares = (0..dependent.len()).map(|j| shares[(k, j)] * amount(j));
        (index, -shares.sum::<f64>())
    });
    let own = dependent.iter().enumerate();
    Some(
        own.map(|(j, &index)| (index, amount(j)))
            .chain(of_basis)
            .collect(),
    )
}

/// The area over which the force of a row acts; that of ties counts as so much larger that pressures decide.
fn area_of<const D: usize>(condition: &Condition<D>, row: usize) -> f64 {
    let mut nodes = condition.interface.nodes.iter();
    let own = nodes.find(|node| node.rows.contains(&Some(row)));
    let area = own.map_or(1.0, |node| node.weight.abs().max(f64::MIN_POSITIVE));
    match condition.interface.coupling {
        Coupling::Tied => area * LESS,
        _ => area,
    }
}

/// Rows that may depend on others, with their places.
fn suspects<const D: usize>(
    systems: &[&BodySystem<D>],
    conditions: &[Condition<D>],
) -> (Vec<Place>, Vec<Sparse>) {
    let mut places = Vec::new();
    let mut rows = Vec::new();
    for (contact, condition) in conditions.iter().enumerate() {
        for row in 0..condition.interface.nonmortar.len() {
            places.push((contact, row));
            rows.push(free_part(systems, condition, row));
        }
    }
    let suspects = without_own_dof(&rows);
    let mut rows: Vec<Option<Sparse>> = rows.into_iter().map(Some).collect();
    suspects
        .into_iter()
        .filter_map(|i| Some((places[i], rows[i].take()?)))
        .unzip()
}

fn free_part<const D: usize>(
    systems: &[&BodySystem<D>],
    condition: &Condition<D>,
    row: usize,
) -> Sparse {
    let mut sums: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for (body, rows) in condition.ends() {
        let in_frames = systems[body].row_in_frames(&rows[row]);
        for (dof, value) in in_frames.filter(|(dof, _)| !systems[body].held[*dof]) {
            *sums.entry((body, dof)).or_insert(0.0) += value;
        }
    }
    let most = sums.values().fold(0.0, |most: f64, c| most.max(c.abs()));
    sums.retain(|_, c| c.abs() > NO_PART * most);
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

/// The chosen rows as independent ones and those that depend on them.
fn split(rows: &[Sparse], chosen: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let (mut independent, mut dependent) = (Vec::new(), Vec::new());
    for together in connected(rows, chosen) {
        let (some, others) = split_together(rows, &together);
        independent.extend(some);
        dependent.extend(others);
    }
    independent.sort_unstable();
    dependent.sort_unstable();
    (independent, dependent)
}

/// The same by one factorisation.
fn split_together(rows: &[Sparse], chosen: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let gram = Mat::from_fn(chosen.len(), chosen.len(), |i, j| {
        product(&rows[chosen[i]], &rows[chosen[j]])
    });
    let named = |list: Vec<usize>| list.into_iter().map(|i| chosen[i]).collect();
    // cannot fail: rows are finite (else the contact was refused), so that their products are, with squares ≥ 0
    match pivoted_cholesky(&gram, DEPENDENT) {
        Ok((independent, dependent)) => (named(independent), named(dependent)),
        Err(_) => (chosen.to_vec(), Vec::new()),
    }
}

/// The chosen rows, those together that share dofs; each group in the order of `chosen`, groups by their first row.
fn connected(rows: &[Sparse], chosen: &[usize]) -> Vec<Vec<usize>> {
    // the group of each row is the first one that it leads to
    let mut leads_to: Vec<usize> = (0..chosen.len()).collect();
    fn first(leads_to: &mut [usize], mut at: usize) -> usize {
        while leads_to[at] != at {
            leads_to[at] = leads_to[leads_to[at]];
            at = leads_to[at];
        }
        at
    }
    let mut users: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (at, &row) in chosen.iter().enumerate() {
        for &(dof, _) in &rows[row] {
            let user = *users.entry(dof).or_insert(at);
            let (a, b) = (first(&mut leads_to, user), first(&mut leads_to, at));
            leads_to[a.max(b)] = a.min(b);
        }
    }
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (at, &row) in chosen.iter().enumerate() {
        groups
            .entry(first(&mut leads_to, at))
            .or_default()
            .push(row);
    }
    groups.into_values().collect()
}

/// On how many dofs the chosen rows act.
fn dofs_of(rows: &[Sparse], chosen: &[usize]) -> usize {
    let dofs = chosen.iter().flat_map(|&row| &rows[row]);
    let dofs: BTreeSet<(usize, usize)> = dofs.map(|(dof, _)| *dof).collect();
    dofs.len()
}

/// Those of some rows that lie in the span of the independent rows `basis`.
fn within(rows: &[Sparse], basis: &[usize], some: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut factor = Mat::from_fn(basis.len(), basis.len(), |i, j| {
        product(&rows[basis[i]], &rows[basis[j]])
    });
    // cannot fail: each of these rows has a part of its own, far above rounding
    let usable = cholesky_in_place(&mut factor).is_ok();
    let implied = |&row: &usize| {
        let square = product(&rows[row], &rows[row]);
        let mut parts = Mat::from_fn(basis.len(), 1, |i, _| product(&rows[basis[i]], &rows[row]));
        if usable {
            solve_lower_in_place(&factor, &mut parts);
        }
        let inside: f64 = parts.col_as_slice(0).iter().map(|x| x * x).sum();
        square == 0.0 || usable && square - inside <= DEPENDENT * square
    };
    some.filter(implied).collect()
}

/// Rows of frictionless contacts that are the same as an earlier one at all times.
fn repeated<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
    places: &[Place],
    rows: &[Sparse],
) -> Vec<usize> {
    let gaps: Vec<Vec<f64>> = conditions.iter().map(Condition::gaps).collect();
    let diameters: Vec<f64> = model.bodies.iter().map(|b| b.mesh.diameter()).collect();
    let lasting = |contact: usize| {
        let contact = conditions[contact].contact_of(model);
        contact.is_some_and(|c| matches!(c.law, Law::Frictionless) && !gap_varies(c))
    };
    let mut alike: BTreeMap<Vec<(usize, usize)>, Vec<usize>> = BTreeMap::new();
    let mut repeated = Vec::new();
    for (i, row) in rows.iter().enumerate().filter(|(_, row)| !row.is_empty()) {
        let (contact, own) = places[i];
        if !lasting(contact) {
            continue;
        }
        let square = product(row, row);
        let gap = gaps[contact][own];
        let size = diameters[conditions[contact].nonmortar.body.0];
        let same = |&other: &usize| {
            let factor = product(row, &rows[other]) / square;
            let rest = combine(&rows[other], -factor, row);
            let (contact, other) = places[other];
            factor > 0.0
                && product(&rest, &rest) <= DEPENDENT * square * factor * factor
                && (gaps[contact][other] - factor * gap).abs() <= SAME_GAP * size
        };
        let seen = alike
            .entry(row.iter().map(|(dof, _)| *dof).collect())
            .or_default();
        match seen.iter().any(same) {
            true => repeated.push(i),
            false => seen.push(i),
        }
    }
    repeated
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

/// a + factor · b.
fn combine(a: &Sparse, factor: f64, b: &Sparse) -> Sparse {
    let mut sums: BTreeMap<(usize, usize), f64> = a.iter().copied().collect();
    for &(dof, value) in b {
        *sums.entry(dof).or_insert(0.0) += factor * value;
    }
    sums.into_iter().collect()
}

/// Most nodes that a warning names.
const NAMED: usize = 4;

/// The nodes of some rows of a contact, in words.
fn describe<const D: usize>(model: &Model<D>, condition: &Condition<D>, rows: &[usize]) -> String {
    let body = &model.bodies[condition.nonmortar.body.0];
    if condition.source.couple(model) == Some(CoupleKind::Average) {
        return format!("side {}.{}", body.name, condition.nonmortar.side);
    }
    let rows: BTreeSet<usize> = rows.iter().copied().collect();
    let nodes = condition.interface.nodes.iter();
    let places: Vec<String> = nodes
        .filter(|node| node.rows.iter().flatten().any(|row| rows.contains(row)))
        .map(|node| format!("{} at {}", node.node, show(body.mesh.points()[node.node])))
        .collect();
    let more = match places.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let word = if places.len() > 1 { "nodes" } else { "node" };
    format!(
        "{word} {}{more} of {}.{}",
        places[..places.len().min(NAMED)].join(", "),
        body.name,
        condition.nonmortar.side
    )
}
