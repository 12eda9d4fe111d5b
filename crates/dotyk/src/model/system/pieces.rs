//! Into how many pieces each body is divided.

use crate::host::processes;
use crate::mesh::Count;
use crate::model::nouns::model::{Body, Method, Model, Subdomains};

/// The number of pieces of every body, as the model asks for them; none where it stays whole.
///
/// Of a given number each body has one, and the others go one after the other to the body whose pieces are largest. Several processes
/// share out large bodies where nothing else is asked for.
pub(crate) fn pieces<const D: usize>(model: &Model<D>) -> Vec<Option<Count>> {
    let bodies = model.bodies.len();
    let Subdomains::Parts(all) = model.solver.subdomains else {
        let shared = processes().and_then(|_| of_moderate_size(model, SHARED));
        return shared.unwrap_or_else(|| vec![None; bodies]);
    };
    let mut counts = vec![1; bodies];
    let cells: Vec<usize> = model
        .bodies
        .iter()
        .map(|body| body.mesh.cell_count())
        .collect();
    for _ in bodies..all {
        let size = |body: usize| unknowns(model, body) / counts[body] as f64;
        let divisible = (0..bodies).filter(|&body| counts[body] < cells[body]);
        let largest = divisible.max_by(|&a, &b| size(a).total_cmp(&size(b)).then(b.cmp(&a)));
        let Some(largest) = largest else { break };
        counts[largest] += 1;
    }
    let several = |count| (count > 1).then_some(Count::Exactly(count));
    counts.into_iter().map(several).collect()
}

/// Components of displacement of the nodes of a body.
fn unknowns<const D: usize>(model: &Model<D>, body: usize) -> f64 {
    (D * model.bodies[body].mesh.points().len()) as f64
}

/// Unknowns from which on a body is shared out to several processes, in the plane and in space.
const SHARED: [f64; 2] = [400_000.0, 50_000.0];

/// The same where there is no other way.
pub(crate) const DIVISIBLE: [f64; 2] = [30_000.0, 300.0];

/// Unknowns of a piece in the plane and in space where their number is not given: few enough for small triangles of borders, and enough
/// for a coarse problem that costs little beside them. The contact of two blocks of 402 000 unknowns took 12.6 s in pieces of 150, 14.4 s
/// of 200, 11.9 s of 260 and 12.1 s of 400.
const MODERATE: [f64; 2] = [20_000.0, 200.0];

/// Operations of the factor of a whole that take as long as an entry of the factors of pieces takes in a product with F: blocks in space
/// of 80 000 to 350 000 unknowns, on one thread and two.
const ENTRY: f64 = 150.0;

/// What comes before the first product, in products.
const BEFORE: f64 = 15.0;

/// Products with F for which pieces are tried, where sides lie on each other and elsewhere: blocks take 40, a lining of which a part opens
/// 130; balls on blocks 290, which take up to twice as long for each entry. With friction it is 80 to 750: too uncertain.
const FEWEST: [f64; 2] = [100.0, 500.0];

/// How many products with F of bodies in pieces whose factors have so many `entries` take as long as factors of so many `operations`, in
/// each load step; `None` if wholes are expected to take less time. `fits`: sides lie on each other, or are the same distance apart.
/// Yielding and gaskets ask for many answers in a step.
pub(crate) fn products_as_dear<const D: usize>(
    model: &Model<D>,
    fits: bool,
    (operations, entries): (f64, f64),
) -> Option<usize> {
    let gasket = model
        .contacts
        .iter()
        .any(|contact| contact.gasket.is_some());
    if gasket || model.bodies.iter().any(Body::is_plastic) {
        return None;
    }
    let steps = model.times.len().max(1) as f64;
    let products = (operations / (ENTRY * entries) - BEFORE) / steps;
    (products >= FEWEST[usize::from(!fits)]).then_some(products as usize)
}

/// Entries of the factors of pieces for each unknown, of blocks of hexahedra, which have few.
const ENTRIES: f64 = 220.0;

/// About as few entries as the factors of pieces of all bodies can have.
pub(crate) fn fewest_entries<const D: usize>(model: &Model<D>) -> f64 {
    let all = (0..model.bodies.len()).map(|body| unknowns(model, body));
    ENTRIES * all.sum::<f64>()
}

/// Pieces of moderate size of bodies that have at least so many unknowns; `None` if none has, or where something else is asked for.
pub(crate) fn of_moderate_size<const D: usize>(
    model: &Model<D>,
    least: [f64; 2],
) -> Option<Vec<Option<Count>>> {
    let few_products = matches!(model.solver.method, Method::Auto | Method::Newton);
    if model.solver.subdomains != Subdomains::Auto || !few_products {
        return None;
    }
    let [least, moderate] = [least, MODERATE].map(|of| of[usize::from(D == 3)]);
    let of_body = |body: usize| {
        let unknowns = unknowns(model, body);
        (unknowns >= least).then_some(Count::About(unknowns / moderate))
    };
    let counts: Vec<_> = (0..model.bodies.len()).map(of_body).collect();
    counts.iter().any(Option::is_some).then_some(counts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Diagonals, Rectangle};
    use crate::model::nouns::model::Elastic;

    #[test]
    fn wholes_are_dear_where_their_factor_costs_a_hundred_products_in_each_step() {
        let rectangle = Rectangle {
            from: [0.0, 0.0],
            to: [1.0, 1.0],
            cells: [4, 4],
            cell: CellKind::Quad4,
            diagonals: Diagonals::default(),
        };
        let steel = Elastic {
            young: 210e3,
            poisson: 0.3,
        };
        let mut model = Model::<2>::new();
        model.body("plate", rectangle.build().unwrap(), steel);
        let entries = fewest_entries(&model);
        assert_eq!(entries, 220.0 * 50.0);
        let dear = |model: &Model<2>, products: f64| {
            products_as_dear(
                model,
                true,
                (ENTRY * entries * (BEFORE + products), entries),
            )
        };
        assert_eq!(dear(&model, 99.0), None);
        assert_eq!(dear(&model, 150.5), Some(150));
        let curved = |products: f64| {
            products_as_dear(
                &model,
                false,
                (ENTRY * entries * (BEFORE + products), entries),
            )
        };
        assert_eq!([curved(499.0), curved(500.5)], [None, Some(500)]);
        model.times = vec![1.0, 2.0];
        assert_eq!(dear(&model, 150.5), None);
        assert_eq!(dear(&model, 401.0), Some(200));
    }
}
