//! Condensation: the bodies as a dual problem on the contact unknowns, at one time and at the next.
//!
//! ```text
//!   F = B K⁺ Bᵀ,        d = B (u_D + K⁺(f − K u_D)) − g₀,        G = RᵀBᵀ,  e = Rᵀf
//! ```
//!
//! [`linearise`] makes it in layers, and finds by their keys (`key.rs`) those that were made before. A load step only updates loads,
//! prescribed displacements and gaps, which changes d and e alone; stiffness, factors, pairs and F are made once. A stage, in which
//! parts have come or gone, and a model with another body are connected and condensed anew, with the stiffness, order and factor of
//! bodies that are the same.
//!
//! Source: Janovský & Procházka (1980) III, section 7, (7.5)–(7.9).

use crate::contact::Coupling;
use crate::dual::{Compliance, DualProblem};
use crate::fem::{BodySystem, Constraints, Part};
use crate::host::in_order;
use crate::linalg::Mat;
use crate::mesh::Count;
use crate::model::nouns::error::Error;
use crate::model::nouns::event::{Event, Lap, Work};
use crate::model::nouns::model::{Body, Method, Model};
use crate::model::nouns::presence::Stage;
use crate::model::nouns::solution::Seconds;
use crate::model::system::admissible::{admissible_set, neighbours};
use crate::model::system::bodies::{
    BodyRows, LoadedBody, body_rows, least_softness, systems, turn_to_forces,
};
use crate::model::system::compliance::{
    Assembled, DENSE_LIMIT, compliance, is_assembled, is_scattered, pays,
};
use crate::model::system::condition::{Condition, initial_gaps};
use crate::model::system::conditions::all_conditions;
use crate::model::system::domains::{coupled, whole};
use crate::model::system::drive::{complete, driven};
use crate::model::system::factor::{FactoredBody, Inverse, Last, Ordered, factor, order};
use crate::model::system::floating::Floating;
use crate::model::system::joints::restore;
use crate::model::system::key::{same_conditions, same_stiffness};
use crate::model::system::memory::{self, Demand};
use crate::model::system::pieces::{
    DIVISIBLE, fewest_entries, of_moderate_size, pieces, products_as_dear,
};
use crate::model::system::state::{AllYielded, State};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::mem::take;
use std::sync::Arc;

/// If all overlaps are below this part of the displacements whose differences they are, they are rounding.
const OVERLAP_ROUNDING: f64 = 1e-12;

/// Gaps that differ by less than this part of the size of a body are the same.
const SAME_GAP: f64 = 1e-9;

/// The bodies of a model condensed onto the contact unknowns, at one time.
pub(crate) struct Condensed<const D: usize> {
    pub bodies: Vec<LoadedBody<D>>,
    pub ordered: Vec<Arc<Ordered>>,
    pub factored: Vec<FactoredBody>,
    pub conditions: Vec<Condition<D>>,
    pub gaps: Vec<f64>,
    pub floating: Floating,
    pub problem: DualProblem,
    /// Warnings about conditions that were dropped.
    pub dropped: Vec<String>,
    /// Nodes of each part that other stages touch.
    lasting: Vec<Vec<usize>>,
    /// Spent so far, earlier steps included.
    pub seconds: Seconds,
    pub time: f64,
    /// The fraction of the step reached, if not its end.
    part: Option<Part>,
    /// The state from which it goes on.
    pub state: Arc<State<D>>,
    /// Products with F that cost as much as wholes, where bodies are in pieces for the time that this saves.
    dear: Option<usize>,
    /// The model of which its parts and conditions were made.
    made_of: Model<D>,
}

/// What a dual problem is made for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Purpose {
    /// Most assembled unknowns.
    pub dense_limit: usize,
    /// An answer by few products with F: bodies may be divided for the time that this saves.
    pub few_products: bool,
}

impl Purpose {
    /// Answers of the model's own method.
    pub const ANSWERS: Self = Self {
        dense_limit: DENSE_LIMIT,
        few_products: true,
    };

    /// Any other one.
    pub const fn others(dense_limit: usize) -> Self {
        Self {
            dense_limit,
            few_products: false,
        }
    }
}

/// The bodies of a model at one time with their contacts paired, not yet condensed.
struct Connected<const D: usize> {
    systems: Vec<BodySystem<D>>,
    conditions: Vec<Condition<D>>,
    gaps: Vec<f64>,
    dropped: Vec<String>,
    /// Nodes of each part that other stages touch.
    lasting: Vec<Vec<usize>>,
    /// Order and factor of bodies that have been before.
    kept: Vec<Option<Factored>>,
    seconds: Seconds,
    time: f64,
    state: Arc<State<D>>,
    /// As in [`Condensed`], of bodies that have been before.
    dear: Option<usize>,
}

/// The dual problem of a stage at a time, from a state, for a purpose; layers equal to those of `before` are reused. `look` is called with the conditions, and whether they are those of `before`, before the factorisation.
///
/// Errors: bodies or contacts that cannot be assembled, paired or factored; values that are not finite; too little memory; a floating
/// body that no contact can hold; an invalid law; those of `look`.
pub(crate) fn linearise<const D: usize, V>(
    stage: &Stage<'_, D>,
    (time, state): (f64, Arc<State<D>>),
    (before, purpose): (Option<Condensed<D>>, Purpose),
    look: impl FnOnce(&[Condition<D>], bool) -> Result<V, Error<D>>,
    observe: &mut dyn FnMut(Event),
) -> Result<(Condensed<D>, V), Error<D>> {
    let model = stage.model.as_ref();
    let before = before.map(|mut before| {
        if !state.goes_on() {
            before.seconds = Seconds::default();
        }
        before
    });
    match before {
        Some(before) if before.connects(model, &state) => {
            let seen = look(&before.conditions, true)?;
            Ok((before.drive_to(model, (time, state), observe)?, seen))
        }
        before => {
            let connected = connect(stage, (time, state), before, observe)?;
            let seen = look(&connected.conditions, false)?;
            let condensed = connected.condense(model, purpose, observe)?;
            Ok((condensed, seen))
        }
    }
}

/// Assembles the bodies and pairs the contacts of a stage at a time, from a state; bodies that are the same as `before` go on.
///
/// Errors: bodies that cannot be assembled, contacts that cannot be paired.
fn connect<const D: usize>(
    stage: &Stage<'_, D>,
    (time, state): (f64, Arc<State<D>>),
    before: Option<Condensed<D>>,
    observe: &mut dyn FnMut(Event),
) -> Result<Connected<D>, Error<D>> {
    let model = stage.model.as_ref();
    let mut seconds = before.as_ref().map_or(Seconds::default(), |b| b.seconds);
    let dear = before.as_ref().and_then(|before| before.dear);
    let mut lap = Lap::start();
    observe(Event::Stage("assemble"));
    let (before, kept) = going_on(model, before, state.goes_on());
    let mut systems = systems(model, (before, state.histories()), time)?;
    let constraints: Vec<&Constraints<D>> = systems.iter().map(|s| &s.constraints).collect();
    let mut conditions = all_conditions(stage, &constraints, time)?;
    state.place(model, &mut conditions)?;
    let before = |name: &str| state.before(name);
    let dropped = complete(model, &mut systems, (&mut conditions, &before), time)?;
    turn_to_forces(&mut systems[..model.bodies.len()], &conditions);
    seconds.assemble += lap.seconds();
    Ok(Connected {
        gaps: gaps_after(&conditions, &state.slips(&conditions)),
        lasting: state.lasting(stage, systems.len()),
        systems,
        conditions,
        dropped,
        kept,
        seconds,
        time,
        state,
        dear,
    })
}

/// Order and factor of a body.
type Factored = (Arc<Ordered>, Arc<Inverse>);

/// Systems and factors of the bodies of a model in the condensed model `before`, by their names. In another run (`goes_on` false) bodies
/// with nodes turned to contact forces are not reused.
fn going_on<const D: usize>(
    model: &Model<D>,
    before: Option<Condensed<D>>,
    goes_on: bool,
) -> (Vec<Option<BodySystem<D>>>, Vec<Option<Factored>>) {
    let Some(before) = before else {
        return (0..model.bodies.len()).map(|_| (None, None)).unzip();
    };
    let of_bodies = before.bodies.into_iter().zip(before.ordered);
    let mut of_bodies: BTreeMap<&str, _> = (before.made_of.bodies.iter())
        .zip(of_bodies.zip(before.factored))
        .map(|(body, found)| (&body.name[..], (body, found)))
        .collect();
    let same = before.made_of.analysis == model.analysis;
    let find = |body: &Body<D>| {
        let (known, ((loaded, ordered), factored)) = of_bodies.remove(&body.name[..])?;
        let turned = loaded.system.is_turned();
        (same && same_stiffness(known, body) && (goes_on || !turned))
            .then_some((loaded.system, (ordered, factored.factor)))
    };
    model.bodies.iter().map(find).map(Option::unzip).unzip()
}

impl<const D: usize> Condensed<D> {
    /// Whether a stage of a model, at a state, has the same parts, connected by the same conditions.
    fn connects(&self, model: &Model<D>, state: &State<D>) -> bool {
        self.state.has_things_of(state) && same_conditions(&self.made_of, model)
    }

    /// At another time, from another state: d, e and the friction bounds are updated, all else stays.
    ///
    /// Errors: values that are not finite, an invalid law.
    fn drive_to(
        mut self,
        model: &Model<D>,
        (time, state): (f64, Arc<State<D>>),
        observe: &mut dyn FnMut(Event),
    ) -> Result<Self, Error<D>> {
        let lost = |name: &str| state.before(name).0;
        restore(model, &mut self.conditions, &lost);
        carry(&mut self, state.yielded());
        (self.time, self.part, self.state) = (time, None, Arc::clone(&state));
        drive(model, &mut self, observe)?;
        Ok(self)
    }
}

impl<const D: usize> Connected<D> {
    /// The dual problem, for a purpose.
    ///
    /// Errors: too little memory; a body that cannot be factored; a floating body that no contact can hold; an invalid law.
    fn condense(
        self,
        model: &Model<D>,
        purpose: Purpose,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Condensed<D>, Error<D>> {
        let Self {
            systems,
            conditions,
            gaps,
            dropped,
            mut seconds,
            time,
            state,
            ..
        } = self;
        let mut lap = Lap::start();
        observe(Event::Stage("order"));
        let rows = body_rows(&systems, &conditions);
        let of_bodies = OfBodies {
            systems: &systems,
            rows: &rows,
            kept: &self.kept,
            lasting: &self.lasting,
        };
        let (orders, dear) = ordered(model, of_bodies, &conditions, (purpose, self.dear))?;
        let Orders { ordered, dense } = orders;
        seconds.order += lap.seconds();
        observe(Event::Stage("factor"));
        let loaded = systems
            .into_par_iter()
            .zip(rows)
            .map(|(system, rows)| LoadedBody::new(system, rows));
        let bodies: Vec<LoadedBody<D>> = loaded.collect();
        // kept bodies have their factors
        let factors = reused(&ordered, self.kept);
        let work = Arc::new(work_of(&ordered, &factors));
        observe(Event::Factoring(Arc::clone(&work)));
        let factored = factor_bodies(model, &bodies, &ordered, (factors, &work))?;
        seconds.factor += lap.seconds();
        observe(Event::Stage("condense"));
        let how = (dense, dear.unwrap_or(usize::MAX));
        let (compliance, parts) = compliance(&bodies, &factored, &ordered, gaps.len(), how);
        let floating = Floating::new(model, &bodies, &conditions)?;
        let balance = floating.balance.clone();
        let admissible = admissible_set(model, &conditions, time)?;
        let shift = overlap(&bodies, &factored, &gaps);
        let mut problem = DualProblem::new(compliance, shift, admissible, balance)
            .map_err(|error| Error::Solver(error.into()))?;
        let of_bodies = (&bodies[..], &factored[..]);
        problem.coupled = coupled(model, of_bodies, (&conditions, &floating), &problem.shift);
        problem.scales = whole(&problem.coupled);
        problem.soften(least_softness(&bodies, gaps.len()));
        problem.neighbours = neighbours(model, &conditions);
        problem.parts = parts;
        seconds.condense += lap.seconds();
        Ok(Condensed {
            bodies,
            ordered,
            factored,
            conditions,
            gaps,
            floating,
            problem,
            dropped,
            lasting: self.lasting,
            seconds,
            time,
            part: None,
            state,
            dear,
            made_of: model.clone(),
        })
    }
}

/// Input of the orders: system and rows of each part, order and factor of bodies assembled before, and nodes that other stages
/// touch.
#[derive(Clone, Copy)]
struct OfBodies<'a, const D: usize> {
    systems: &'a [BodySystem<D>],
    rows: &'a [Arc<BodyRows>],
    kept: &'a [Option<Factored>],
    lasting: &'a [Vec<usize>],
}

impl<const D: usize> OfBodies<'_, D> {
    /// The order of a body: the previous one, or one that is `known`, if it fits.
    fn order(
        &self,
        model: &Model<D>,
        (body, known): (usize, Option<&Arc<Ordered>>),
        (last, pieces): (Last, Option<Count>),
    ) -> Result<Arc<Ordered>, Error<D>> {
        let (system, rows) = (&self.systems[body], &self.rows[body]);
        let lasting = &self.lasting[body];
        let kept = self.kept.get(body).and_then(Option::as_ref);
        let mut before = kept.map(|(ordered, _)| ordered).into_iter().chain(known);
        let how = (last, pieces.is_some());
        match before.find(|ordered| ordered.serves(system, rows, lasting, how)) {
            Some(ordered) => Ok(Arc::clone(ordered)),
            None => {
                let how = (last, pieces);
                Ok(Arc::new(order(model, body, system, (rows, lasting), how)?))
            }
        }
    }
}

/// The orders of all bodies, and whether F is assembled.
struct Orders {
    ordered: Vec<Arc<Ordered>>,
    dense: bool,
}

/// The orders of all bodies. Where nothing else is asked for, bodies are divided that are too large or need too much memory as wholes;
/// and for few products with F also where wholes take more time: then with the number of products that cost as much, which is
/// `known` of bodies that have been before.
///
/// Errors: those of the orders; too little memory.
fn ordered<const D: usize>(
    model: &Model<D>,
    of: OfBodies<'_, D>,
    conditions: &[Condition<D>],
    (purpose, known): (Purpose, Option<usize>),
) -> Result<(Orders, Option<usize>), Error<D>> {
    let in_pieces =
        |pieces: &[Option<Count>]| ordered_in(pieces, model, of, conditions, purpose.dense_limit);
    let divided = || of_moderate_size(model, DIVISIBLE).map(|pieces| in_pieces(&pieces));
    let as_asked = pieces(model);
    // a body that was divided before
    let again = |(kept, asked): (&Option<Factored>, &Option<Count>)| {
        let divided = kept.as_ref().and_then(|(ordered, _)| ordered.divided());
        divided.is_some() && asked.is_none()
    };
    if of.kept.iter().zip(&as_asked).any(again)
        && let Some(again) = divided()
    {
        return Ok((again?, known));
    }
    let found = match in_pieces(&as_asked) {
        Err(error @ (Error::TooLarge { .. } | Error::Memory { .. })) => {
            let divided = divided().and_then(Result::ok).ok_or(error)?;
            return Ok((divided, None));
        }
        found => found?,
    };
    let new = purpose.few_products
        && as_asked.iter().all(Option::is_none)
        && of.kept.iter().all(Option::is_none);
    let operations = found.ordered.iter().map(|order| order.operations()).sum();
    let open = new && !rough(conditions);
    let fits = conditions.iter().all(|condition| fits(model, condition));
    let dear = |entries: f64| products_as_dear(model, fits, (operations, entries)).filter(|_| open);
    // pieces are only made where they may be worth it
    let divided = dear(fewest_entries(model)).and_then(|_| divided()?.ok());
    let chosen = divided.and_then(|divided| {
        let entries: usize = divided.ordered.iter().map(|order| order.stored()).sum();
        Some((divided, Some(dear(entries as f64)?)))
    });
    Ok(chosen.unwrap_or((found, None)))
}

/// Whether anything slides with friction.
fn rough<const D: usize>(conditions: &[Condition<D>]) -> bool {
    let slides = |condition: &Condition<D>| condition.slides().contains(&true);
    conditions.iter().any(slides)
}

/// Whether the sides of a condition are tied, lie on each other, or are everywhere the same distance apart.
fn fits<const D: usize>(model: &Model<D>, condition: &Condition<D>) -> bool {
    if condition.interface.coupling == Coupling::Tied {
        return true;
    }
    let Some(body) = model.bodies.get(condition.nonmortar.body.0) else {
        return true;
    };
    let gaps = condition.interface.carriers().map(|node| node.gap);
    let [least, most] = gaps.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], gap| {
        [least.min(gap), most.max(gap)]
    });
    most - least <= SAME_GAP * body.mesh.diameter()
}

/// The same of bodies in so many pieces each. Problems that do not fit the memory are refused; an F that would pay to assemble, but does
/// not fit, is applied.
fn ordered_in<const D: usize>(
    pieces: &[Option<Count>],
    model: &Model<D>,
    of: OfBodies<'_, D>,
    conditions: &[Condition<D>],
    dense_limit: usize,
) -> Result<Orders, Error<D>> {
    let m = conditions.iter().map(|p| p.interface.nonmortar.len()).sum();
    let rough = rough(conditions);
    let few_products = matches!(model.solver.method, Method::Auto | Method::Newton);
    let all = |dense: bool, known: &[Arc<Ordered>]| {
        let last = match dense {
            false => Last::Nothing,
            true if is_scattered(of.rows, m) => Last::Contacts,
            true => Last::LongContacts,
        };
        let each = (0..of.systems.len()).into_par_iter();
        in_order(each.map(|body| {
            let how = (last, pieces.get(body).copied().flatten());
            of.order(model, (body, known.get(body)), how)
        }))
    };
    let fits = |ordered: &[Arc<Ordered>], dense| {
        let each = of.systems.iter().zip(of.rows).zip(ordered);
        let demands = each
            .enumerate()
            .map(|(part, ((system, rows), ordered))| Demand {
                trailing: ordered.trailing.len(),
                factor: ordered.stored(),
                beside: ordered.beside(),
                pieces: ordered.divided().map(|own| own.in_process()),
                stiffness: system.stiffness.stored(),
                dofs: system.load.len(),
                rows: rows.index.len(),
                yields: model.bodies.get(part).is_some_and(Body::is_plastic),
            });
        memory::check(model, &demands.collect::<Vec<_>>(), dense, m)
    };
    let assembled = match pieces.iter().any(Option::is_some) {
        true => Assembled::Never,
        false => is_assembled::<D>(of.rows, m, (dense_limit, rough, few_products)),
    };
    let dense = assembled == Assembled::Always;
    let orders = all(dense, &[])?;
    if assembled == Assembled::IfCheaper && pays(m, &orders) {
        let last = all(true, &orders)?;
        if fits(&last, true).is_ok() {
            return Ok(Orders {
                ordered: last,
                dense: true,
            });
        }
    }
    fits(&orders, dense)?;
    Ok(Orders {
        ordered: orders,
        dense,
    })
}

/// Factors of bodies whose order is unchanged.
fn reused(ordered: &[Arc<Ordered>], kept: Vec<Option<Factored>>) -> Vec<Option<Arc<Inverse>>> {
    let mut kept = kept.into_iter();
    let each = ordered.iter().map(|ordered| {
        let (before, factor) = kept.next()??;
        Arc::ptr_eq(&before, ordered).then_some(factor)
    });
    each.collect()
}

/// The same step again, with the nodes that joints have lost on the way.
///
/// Errors: those of the step itself.
pub(crate) fn again<const D: usize>(
    model: &Model<D>,
    here: &mut Condensed<D>,
    lost: &[Vec<bool>],
    observe: &mut dyn FnMut(Event),
) -> Result<(), Error<D>> {
    for (condition, lost) in here.conditions.iter_mut().zip(lost) {
        condition.touch.lost.clone_from(lost);
    }
    drive(model, here, observe)
}

/// The same step with other plastic strains of its bodies, which change its loads.
///
/// Errors: those of the step itself.
pub(crate) fn assume<const D: usize>(
    model: &Model<D>,
    here: &mut Condensed<D>,
    yielded: AllYielded,
) -> Result<(), Error<D>> {
    carry(here, yielded);
    drive(model, here, &mut |_| {})
}

/// The same step at a fraction of it: loads and prescribed displacements vary linearly from those of the step before, or from zero, to
/// its own. `None`: at its end.
///
/// Errors: those of the step itself.
pub(crate) fn go_part<const D: usize>(
    model: &Model<D>,
    here: &mut Condensed<D>,
    share: Option<f64>,
) -> Result<(), Error<D>> {
    let before = here.state.time();
    here.part = share.map(|share| Part { before, share });
    drive(model, here, &mut |_| {})
}

/// The same step with whole bodies, where they are in pieces for the time that this saves; `false` where they are not.
///
/// Errors: those of the step itself.
pub(crate) fn make_whole<const D: usize>(
    model: &Model<D>,
    here: &mut Condensed<D>,
    observe: &mut dyn FnMut(Event),
) -> Result<bool, Error<D>> {
    if here.dear.is_none() {
        return Ok(false);
    }
    // the factors of the pieces go before those of the wholes come
    here.problem.compliance = Compliance::Dense(Mat::zeros(0, 0));
    here.factored.clear();
    let bodies = take(&mut here.bodies).into_iter();
    let connected = Connected {
        systems: bodies.map(|body| body.system).collect(),
        conditions: take(&mut here.conditions),
        gaps: take(&mut here.gaps),
        dropped: take(&mut here.dropped),
        lasting: take(&mut here.lasting),
        kept: Vec::new(),
        seconds: here.seconds,
        time: here.time,
        state: Arc::clone(&here.state),
        dear: None,
    };
    let part = here.part;
    *here = connected.condense(model, Purpose::others(DENSE_LIMIT), observe)?;
    here.part = part;
    drive(model, here, observe)?;
    Ok(true)
}

/// Gives the bodies the plastic strains whose load they carry.
fn carry<const D: usize>(here: &mut Condensed<D>, yielded: AllYielded) {
    for (body, yielded) in here.bodies.iter_mut().zip(yielded) {
        body.system.history.yielded = yielded;
    }
}

/// Updates d, e and the friction bounds to the time and the state of `here`.
fn drive<const D: usize>(
    model: &Model<D>,
    here: &mut Condensed<D>,
    observe: &mut dyn FnMut(Event),
) -> Result<(), Error<D>> {
    let (mut lap, time) = (Lap::start(), here.time);
    observe(Event::Stage("loads"));
    let (bodies, conditions) = (take(&mut here.bodies), take(&mut here.conditions));
    let (bodies, conditions) = driven(model, bodies, conditions, (time, here.part))?;
    (here.bodies, here.conditions) = (bodies, conditions);
    here.gaps = gaps_after(&here.conditions, &here.state.slips(&here.conditions));
    here.seconds.assemble += lap.seconds();
    observe(Event::Stage("condense"));
    here.factored = (&here.bodies, take(&mut here.factored))
        .into_par_iter()
        .map(|(body, factored)| FactoredBody::new(body, factored.factor))
        .collect();
    here.floating
        .set_loads(model, &here.bodies, &here.conditions)?;
    let (of_bodies, problem) = ((&here.bodies[..], &here.factored[..]), &mut here.problem);
    problem.admissible = admissible_set(model, &here.conditions, time)?;
    problem.balance = here.floating.balance.clone();
    problem.shift = overlap(of_bodies.0, of_bodies.1, &here.gaps);
    problem
        .check()
        .map_err(|error| Error::Solver(error.into()))?;
    let fitted = (&here.conditions[..], &here.floating);
    problem.coupled = coupled(model, of_bodies, fitted, &problem.shift);
    problem.scales = whole(&problem.coupled);
    here.seconds.condense += lap.seconds();
    Ok(())
}

/// Operations and memory of the factorisations that are still to be done.
fn work_of(ordered: &[Arc<Ordered>], factors: &[Option<Arc<Inverse>>]) -> Work {
    let new = || {
        ordered
            .iter()
            .zip(factors)
            .filter(|(_, factor)| factor.is_none())
    };
    let operations: f64 = new().map(|(ordered, _)| ordered.operations()).sum();
    let entries: usize = new().map(|(ordered, _)| ordered.stored()).sum();
    Work {
        all: (operations as u64).into(),
        bytes: (8 * entries as u64).into(),
        ..Work::default()
    }
}

fn factor_bodies<const D: usize>(
    model: &Model<D>,
    bodies: &[LoadedBody<D>],
    ordered: &[Arc<Ordered>],
    (factors, work): (Vec<Option<Arc<Inverse>>>, &Work),
) -> Result<Vec<FactoredBody>, Error<D>> {
    let each = (bodies, ordered, factors).into_par_iter().enumerate();
    let factored = each.map(|(index, (body, ordered, before))| {
        let factor = match before {
            Some(factor) => factor,
            None => Arc::new(factor(model, index, &body.system, ordered, work)?),
        };
        Ok(FactoredBody::new(body, factor))
    });
    in_order(factored)
}

/// The gaps g₀ of a step that begins with a slip, (m,): friction counts the slip from there.
fn gaps_after<const D: usize>(conditions: &[Condition<D>], slip: &[f64]) -> Vec<f64> {
    let gaps = initial_gaps(conditions).into_iter().zip(slip);
    gaps.map(|(gap, slip)| gap + slip).collect()
}

/// d of all bodies: their overlap without contact forces.
fn overlap<const D: usize>(
    bodies: &[LoadedBody<D>],
    factored: &[FactoredBody],
    gaps: &[f64],
) -> Vec<f64> {
    let mut overlap: Vec<f64> = gaps.iter().map(|gap| -gap).collect();
    // rigid motions first: they may cancel a clearance that is large beside the strains
    for body in bodies {
        for (row, product) in body.rows.products(&body.system.carried) {
            overlap[row] += product;
        }
    }
    let mut largest = gaps.iter().fold(0.0, |s: f64, gap| s.max(gap.abs()));
    for (body, factored) in bodies.iter().zip(factored) {
        for (row, product) in body.rows.products(&factored.base) {
            overlap[row] += product;
        }
        let moved = body.system.carried.iter().chain(&factored.base);
        largest = moved.fold(largest, |s, u| s.max(u.abs()));
    }
    // Bodies that their supports carry along together do not overlap: the rest is rounding of the displacement.
    if overlap
        .iter()
        .all(|d| d.abs() <= OVERLAP_ROUNDING * largest)
    {
        overlap.fill(0.0);
    }
    overlap
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Field;
    use crate::mesh::{CellKind, Cuboid};
    use crate::model::nouns::model::{Elastic, Law, Subdomains};
    use crate::solve::{ContactSolver, Newton, SolveError};
    use std::ops::ControlFlow;

    /// A block on a larger one, which is held below; the upper one is pressed down and aside.
    fn blocks() -> Model<3> {
        let block = |from: [f64; 3], to: [f64; 3], cells: [usize; 3]| {
            let cuboid = Cuboid {
                from,
                to,
                cells,
                cell: CellKind::Hex8,
            };
            cuboid.build().unwrap()
        };
        let steel = Elastic {
            young: 1000.0,
            poisson: 0.3,
        };
        let mut model = Model::new();
        let lower = block([0.0, 0.0, 0.0], [2.0, 2.0, 1.0], [6, 6, 3]);
        let lower = model.body("lower", lower, steel);
        model.fix(lower, "bottom", [Some(0.0); 3]);
        let upper = block([0.4, 0.4, 1.0], [1.6, 1.6, 2.0], [4, 5, 4]);
        let upper = model.body("upper", upper, steel);
        model.fix(upper, "top", [Some(0.004), Some(0.0), Some(-0.02)]);
        model.contact((upper, "bottom"), (lower, "top"));
        model
    }

    fn condensed(model: &Model<3>, before: Option<Condensed<3>>) -> Condensed<3> {
        let stage = Stage::whole(model);
        let from = (1.0, Arc::new(State::new(model, 1.0, false)));
        let how = (before, Purpose::ANSWERS);
        let made = linearise(&stage, from, how, |_, _| Ok(()), &mut |_| {});
        made.unwrap().0
    }

    fn forces(here: &Condensed<3>) -> Result<Vec<f64>, SolveError> {
        let solved =
            Newton::default().solve(&here.problem, None, &mut |_| ControlFlow::Continue(()));
        solved.map(|outcome| outcome.multipliers.lambda)
    }

    #[test]
    fn pieces_that_take_longer_than_wholes_give_way_to_these() {
        let mut model = blocks();
        model.solver.subdomains = Subdomains::Parts(4);
        let mut before = condensed(&model, None);
        assert!(before.ordered.iter().all(|order| order.divided().is_some()));
        assert!(!make_whole(&model, &mut before, &mut |_| {}).unwrap());
        // as if their number had been chosen for the time that it saves
        model.solver.subdomains = Subdomains::Auto;
        before.dear = Some(2);
        model.contacts[0].law = Law::Coulomb(Field::constant(0.3));
        let whole = forces(&condensed(&model, None)).unwrap();
        let mut here = condensed(&model, Some(before));
        assert!(here.ordered.iter().all(|order| order.divided().is_some()));
        assert_eq!(here.problem.compliance.enough(), 2);
        assert!(matches!(
            forces(&here),
            Err(SolveError::NotConverged { .. })
        ));
        assert!(make_whole(&model, &mut here, &mut |_| {}).unwrap());
        assert!(here.ordered.iter().all(|order| order.divided().is_none()));
        assert_eq!(forces(&here).unwrap(), whole);
        assert!(!make_whole(&model, &mut here, &mut |_| {}).unwrap());
    }
}
