//! Interior points: forces and their complements stay inside the cones of the law, and approach its border together.
//!
//! With s = (bound, λₜ), which lies in the cone K = {s₀ ≥ ‖sₜ‖} of every node, the conditions of a contact problem are those of
//!
//! ```text
//!   Fλ − d − Ĝᵀα̂ = Aᵀz − growth · ‖zₜ‖ n,    Ĝλ = ê,    s = Aλ + given,    s ∈ K,  z ∈ K,  s∘z = 0
//! ```
//!
//! where Aᵀz has growth · z₀ along the normal and zₜ along the tangents. Coulomb's law: gapₙ = growth (z₀ − ‖zₜ‖) and
//! gapₜ = zₜ, so that an open node has z₀ > ‖zₜ‖, a slipping one s and z on opposite edges of the cone, and a sticking one no z.
//! Without the term in ‖zₜ‖, which is de Saxcé's, this is the minimum of an energy under λ ∈ Λ, whose slip lifts; given bounds have
//! no such term. A contact without friction is a cone without tangents, growth 1; a bound that is given has a cone for the
//! normal force and one of constant s₀.
//!
//! Newton's method on s∘z = τ, τ → 0, linearised where the same transformation of the cone takes s and z to one point
//! (Nesterov & Todd). A first step towards τ = 0 shows how far τ can fall (Mehrotra). Where there is an energy, further steps bring
//! products s∘z that are far from τ nearer to it, as long as that lengthens the step (Gondzio). ‖zₜ‖ is rounded by a part of z₀ − ‖zₜ‖.
//! Each step is one linear problem
//!
//! ```text
//!   (F + (Aᵀ − N) W⁻² A) dλ − Ĝᵀdα̂ = ..,    Ĝdλ = ..
//! ```
//!
//! with N the derivative of growth ‖zₜ‖. It is regular for any F, however contacts share their forces and however many bodies float.
//! No states are guessed, so that no circle of states is possible: ten to twenty steps in nearly all problems. Once all contacts are
//! clearly open or closed their states are those of the answer, mostly but for a node, long before τ is small: exact steps end it.
//! With friction the term in ‖zₜ‖ may stall the steps: then there may be no answer, or another stage finds it.
//!
//! As described in Nesterov & Todd (1998), Mehrotra (1992) and Gondzio (1996) for cones and for the order of steps; Acary, Cadoux, Lemaréchal & Malick
//! (2011) for friction as a problem in cones, with ‖zₜ‖ given.

use crate::dual::{Block, Compliance};
use crate::linalg::Mat;
use crate::linalg::dense::{Lu, matvec};
use crate::solve::exact::{CERTAIN, Ended, Search, Settled};
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::State;
use crate::solve::{Observer, dot, largest, norm};
use std::ops::Range;

/// Most steps: most problems take ten, and a problem that takes more than thirty has no answer.
const INTERIOR_STEPS: usize = 40;

/// The steps have stalled after more than so many without a residual below this part of the least one.
const INTERIOR_PATIENCE: usize = 12;
const PROGRESS: f64 = 0.9;

/// A residual that meets the tolerance and exceeds this part of the one before is the least within reach.
const SLOW: f64 = 0.5;

/// States are tried if all contacts are this far from the middle between closed and open: at once, or if the states come twice. Contacts
/// with a negligible force and a negligible gap never are; with residuals as small as the third, states that come twice are tried.
const SURELY: f64 = 0.9;
const LIKELY: f64 = 0.3;
const SMALL_RESIDUAL: f64 = 1e-2;

/// A step goes this part of the way to the border, and a further part where the first step can go far. Where slip lifts, and there is
/// an energy, it leaves this part of the way that the first step leaves, at least the second.
const SHORT: f64 = 0.9;
const FURTHER: f64 = 0.09;
const LEFT: f64 = 0.1;
const LEAST_LEFT: f64 = 1e-4;

/// Where there is an energy: most corrections, which bring outlying products s∘z between τ over and τ times the second number; by how
/// much each aims to lengthen the step, and the part of that which makes it worth while.
const CENTRED: usize = 3;
const SPREAD: f64 = 10.0;
const FARTHER: f64 = 0.3;
const WORTH: f64 = 0.1;

/// Largest reduction of τ in one step.
const FALL: f64 = 1e-8;

/// ‖zₜ‖ is rounded by this part of z₀ − ‖zₜ‖: more would leave steps short, less would leave a corner.
const ROUNDED: f64 = 0.05;

/// Largest ratio of the starting force to the load of floating bodies: their load gives the size of the forces, and overlaps count
/// beyond it only up to this factor.
const BEYOND_LOAD: f64 = 10.0;

/// Starting gaps are at least this part of the largest one.
const NEAREST: f64 = 1e-3;

/// Coefficients below this one count as this one in the starting gaps.
const SMOOTH: f64 = 0.1;

/// More unknowns than this are too many for a factor of all of them in each step.
const MOST_FACTORED: usize = 2000;

/// F where interior points apply; `None` where F is not assembled or too large, and where admissible forces form no cone: for
/// cohesive nodes, and for bounds that bend.
fn assembled<'a>(setup: &Setup<'a>) -> Option<&'a Mat<f64>> {
    match &setup.problem.compliance {
        Compliance::Dense(compliance)
            if setup.len() <= MOST_FACTORED && setup.admissible.is_straight() =>
        {
            Some(compliance)
        }
        _ => None,
    }
}

/// Whether [`interior`] applies.
pub(crate) fn serves(setup: &Setup<'_>) -> bool {
    assembled(setup).is_some()
}

/// Steps from the middle of the cones, each ended by exact ones where its states settle.
pub(crate) fn interior(
    search: &mut Search<'_>,
    states: Vec<State>,
    observe: Observer<'_>,
) -> Ended {
    let setup = search.setup;
    let Some(compliance) = assembled(setup) else {
        return Ended::Stuck(states);
    };
    let mut at = Interior::new(setup);
    let follows = at.cones.iter().any(|cone| cone.follows);
    let mut settled = Settled::default();
    let (mut before, mut least, mut still) = (f64::INFINITY, f64::INFINITY, 0);
    for _ in 0..INTERIOR_STEPS {
        if search.exhausted() || still > INTERIOR_PATIENCE || at.step(compliance).is_none() {
            break;
        }
        search.steps += 1;
        search.move_to(at.at.lambda.clone(), at.at.alpha.clone());
        search.kind = 'i';
        at.at.product.copy_from_slice(&search.point.product);
        if search.tell(observe) {
            return Ended::Stopped;
        }
        let residual = search.residual;
        let asked = at.states(&search.judge.gap);
        let decided = at.decided(&search.judge.gap);
        let times = match decided {
            // without an energy points may stall although their states are those of the answer
            _ if follows => 2,
            _ if decided >= SURELY => 1,
            _ if decided >= LIKELY || residual <= SMALL_RESIDUAL => 2,
            _ => usize::MAX,
        };
        if let Some(ended) = settled.exact(search, asked, times, observe) {
            return ended;
        }
        // undecided contacts keep small forces and gaps: steps go on while these get smaller
        let enough = residual <= CERTAIN * search.tolerance || residual > SLOW * before;
        if enough && passes(search) {
            return Ended::Converged;
        }
        before = residual;
        still = if residual < PROGRESS * least {
            0
        } else {
            still + 1
        };
        least = least.min(residual);
    }
    search.go_back();
    match passes(search) {
        true => Ended::Converged,
        false => Ended::Stuck(states),
    }
}

/// Whether forces meet the tolerance, and, if they answer the problem itself, the certificate: beside a large clearance the residual
/// may pass where the certificate does not.
fn passes(search: &Search<'_>) -> bool {
    let (setup, point) = (search.setup, &search.point);
    let certified = || {
        let answer = setup.multipliers(&point.lambda, &point.alpha);
        setup.problem.certify(&answer, search.tolerance).holds()
    };
    let own = setup.admissible == setup.problem.admissible;
    search.residual <= search.tolerance && (!own || certified())
}

/// A vector of a cone's space: s₀, and one or two of sₜ; zero beyond these.
type Vector = [f64; 3];

/// s₀ tₒ + sₜ·tₜ.
fn inner(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// ‖sₜ‖.
fn tail(a: &Vector) -> f64 {
    a[1].hypot(a[2])
}

/// s₀² − ‖sₜ‖².
fn determinant(a: &Vector) -> f64 {
    (a[0] - tail(a)) * (a[0] + tail(a))
}

/// (s₀, −sₜ).
fn mirrored(a: &Vector) -> Vector {
    [a[0], -a[1], -a[2]]
}

/// s + t · ds.
fn moved(a: &Vector, t: f64, by: &Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + t * by[i])
}

/// a∘b.
fn jordan(a: &Vector, b: &Vector) -> Vector {
    [
        inner(a, b),
        a[0] * b[1] + b[0] * a[1],
        a[0] * b[2] + b[0] * a[2],
    ]
}

/// x with a∘x = b.
fn divided(b: &Vector, a: &Vector) -> Vector {
    let head = inner(&mirrored(a), b) / determinant(a);
    [
        head,
        (b[1] - head * a[1]) / a[0],
        (b[2] - head * a[2]) / a[0],
    ]
}

/// Largest t for which s + t · ds is in the cone, for s inside.
fn reach(s: &Vector, ds: &Vector) -> f64 {
    let (square, half, own) = (determinant(ds), inner(&mirrored(s), ds), determinant(s));
    // the smallest positive zero of square t² + 2 half t + own; it has real ones for any s inside, but for rounding
    let far = (half * half - square * own).max(0.0).sqrt() - half;
    match far > 0.0 {
        true => own / far,
        false => f64::INFINITY,
    }
}

/// The change of a product s∘z that brings its eigenvalues s₀ ± ‖sₜ‖ between τ/[`SPREAD`] and τ·[`SPREAD`], but lowers neither by
/// more than the latter.
fn lacking(product: &Vector, tau: f64) -> Vector {
    let size = tail(product);
    let lacks = |value: f64| (value.clamp(tau / SPREAD, tau * SPREAD) - value).max(-tau * SPREAD);
    let [most, least] = [product[0] + size, product[0] - size].map(lacks);
    let along = match size > 0.0 {
        true => 0.5 * (most - least) / size,
        false => 0.0,
    };
    [0.5 * (most + least), along * product[1], along * product[2]]
}

/// The transformation W of a cone that takes z and, backwards, s to the same point: W = η(2vvᵀ − J).
struct Scaling {
    eta: f64,
    /// v, and w with W⁻² = (2wwᵀ − J)/η².
    v: Vector,
    w: Vector,
}

impl Scaling {
    /// `None` where rounding has taken a point to the border.
    fn new(s: &Vector, z: &Vector) -> Option<Self> {
        let sizes = [s, z].map(|x| determinant(x).sqrt());
        if !sizes.iter().all(|&size| size > 0.0) || s[0] <= 0.0 || z[0] <= 0.0 {
            return None;
        }
        let [own, other] = sizes;
        let (unit, mirror) = (s.map(|x| x / own), mirrored(z).map(|x| x / other));
        let gamma = (0.5 * (1.0 + inner(&unit, &mirrored(&mirror)))).sqrt();
        let middle = [0, 1, 2].map(|i| (unit[i] + mirror[i]) / (2.0 * gamma));
        let size = (2.0 * (middle[0] + 1.0)).sqrt();
        Some(Self {
            eta: (own / other).sqrt(),
            v: [middle[0] + 1.0, middle[1], middle[2]].map(|x| x / size),
            w: mirrored(&middle),
        })
    }

    /// 2u(u·x) − Jx.
    fn reflected(u: &Vector, x: &Vector) -> Vector {
        let part = 2.0 * inner(u, x);
        let mirror = mirrored(x);
        [0, 1, 2].map(|i| part * u[i] - mirror[i])
    }

    /// Wx.
    fn forth(&self, x: &Vector) -> Vector {
        Self::reflected(&self.v, x).map(|y| self.eta * y)
    }

    /// W⁻¹x.
    fn back(&self, x: &Vector) -> Vector {
        Self::reflected(&mirrored(&self.v), x).map(|y| y / self.eta)
    }

    /// W⁻²x.
    fn back_twice(&self, x: &Vector) -> Vector {
        Self::reflected(&self.w, x).map(|y| y / (self.eta * self.eta))
    }
}

/// A cone of one node, and where s and z are in it.
struct Cone {
    normal: usize,
    tangents: Range<usize>,
    /// s₀ = given + growth · λₙ.
    given: f64,
    growth: f64,
    /// Slip does not lift: the bound follows from the normal force.
    follows: bool,
    s: Vector,
    z: Vector,
}

impl Cone {
    fn new(normal: usize, tangents: Range<usize>, (given, growth): (f64, f64)) -> Self {
        Self {
            follows: !tangents.is_empty() && growth > 0.0,
            normal,
            tangents,
            given,
            growth,
            s: [0.0; 3],
            z: [0.0; 3],
        }
    }

    /// The cones of a node whose components are `range`.
    fn of_node(block: &Block, range: Range<usize>) -> Vec<Self> {
        let (normal, tangents) = (range.start, block.shear(&range));
        let alone = || Self::new(normal, normal..normal, (0.0, 1.0));
        let law = block.friction().filter(|law| !law.is_smooth());
        let bounded = law.map(|law| {
            let touch = law.touch(0.0);
            let cone = Self::new(normal, tangents, (touch.given, touch.growth));
            (law.follows(), cone)
        });
        match (block.is_normal(), bounded) {
            (false, None) => Vec::new(),
            (false, Some((_, bounded))) | (true, Some((true, bounded))) => vec![bounded],
            (true, Some((false, bounded))) => vec![alone(), bounded],
            (true, None) => vec![alone()],
        }
    }

    /// A x for x (m,).
    fn image(&self, x: &[f64]) -> Vector {
        let mut image = [self.growth * x[self.normal], 0.0, 0.0];
        for (to, i) in image[1..].iter_mut().zip(self.tangents.clone()) {
            *to = x[i];
        }
        image
    }

    /// ‖zₜ‖, rounded, and its derivative; zero where slip lifts.
    fn slip(&self) -> (f64, [f64; 2]) {
        if !self.follows {
            return (0.0, [0.0; 2]);
        }
        let size = tail(&self.z);
        let rounded = size.hypot(ROUNDED * (self.z[0] - size));
        (rounded, [self.z[1] / rounded, self.z[2] / rounded])
    }

    /// Adds (Aᵀ − N) y to `out` (m,).
    fn add(&self, y: &Vector, slope: [f64; 2], out: &mut [f64]) {
        let lift = y[0] - slope[0] * y[1] - slope[1] * y[2];
        out[self.normal] += self.growth * lift;
        for (i, y) in self.tangents.clone().zip(&y[1..]) {
            out[i] += y;
        }
    }

    /// Its components of λ.
    fn components(&self) -> impl Iterator<Item = usize> {
        let normal = (self.growth > 0.0).then_some(self.normal);
        normal.into_iter().chain(self.tangents.clone())
    }
}

/// The change by a step.
struct Change {
    lambda: Vec<f64>,
    alpha: Vec<f64>,
    cones: Vec<(Vector, Vector)>,
}

/// The iterate.
struct Interior<'a> {
    setup: &'a Setup<'a>,
    cones: Vec<Cone>,
    /// Components of λ that are unknowns: not the shears of nodes without friction.
    unknown: Vec<usize>,
    /// λ inside the cones, α̂ and Fλ.
    at: Forces,
    /// Ĝ by columns, (k,) each.
    modes: Vec<Vec<f64>>,
}

impl<'a> Interior<'a> {
    /// The start. Where bounds follow: the same force at every node, of the size of loads and overlaps, and the same gap. Where there is
    /// an energy: the gaps −d, at least the compression by that force, and forces with the same product of force and gap.
    fn new(setup: &'a Setup<'a>) -> Self {
        let mut cones: Vec<Cone> = setup
            .admissible
            .iter()
            .flat_map(|(block, range)| Cone::of_node(block, range))
            .collect();
        let unknown = setup.admissible.iter().flat_map(|(block, range)| {
            let smooth = block.friction().is_some_and(|law| law.is_smooth());
            let sheared = block.shear(&range);
            range.filter(move |i| !(smooth && sheared.contains(i)))
        });
        let unknown = unknown.collect();
        let softness = &setup.problem.softness;
        let mut asked: Vec<f64> = setup
            .shift
            .iter()
            .zip(softness)
            .map(|(d, c)| (d / c).abs())
            .collect();
        let mut soft = softness.clone();
        let load = largest(0.0, &{
            let mut push = vec![0.0; setup.len()];
            setup
                .balance
                .add_transposed(1.0, setup.balance.target(), &mut push);
            push
        });
        let asked = median(&mut asked);
        let force = match load > 0.0 {
            true => load.max(asked.min(BEYOND_LOAD * load)),
            false => asked,
        };
        let force = if force > 0.0 { force } else { 1.0 };
        let give = force * median(&mut soft);
        let gap = largest(give, &setup.shift);
        let least = give.max(NEAREST * gap);
        let follows = cones.iter().any(|cone| cone.follows);
        let mut at = Forces::none(setup);
        for cone in &mut cones {
            let gap = match follows {
                true => gap,
                false => least.max(-setup.shift[cone.normal]),
            };
            let force = if follows { force } else { force * least / gap };
            // a given bound involves no normal force
            if cone.growth > 0.0 {
                at.lambda[cone.normal] = force;
            }
            cone.s[0] = cone.given + cone.growth * force;
            let growth = if cone.growth > 0.0 {
                cone.growth.max(SMOOTH)
            } else {
                1.0
            };
            cone.z[0] = gap / growth;
        }
        let mut product = vec![0.0; setup.len()];
        setup.multiply(&at.lambda, &mut product);
        at.product = product;
        Self {
            modes: (0..setup.len()).map(|i| setup.balance.column(i)).collect(),
            setup,
            cones,
            unknown,
            at,
        }
    }

    /// States of forces and gaps (m,).
    fn states(&self, gap: &[f64]) -> Vec<State> {
        let softness = &self.setup.problem.softness;
        let blocks = self.setup.admissible.iter();
        let state = |(block, range): (&_, Range<usize>)| {
            let trial: Vec<f64> = range
                .map(|i| self.at.lambda[i] - gap[i] / softness[i])
                .collect();
            State::of_trial(block, &trial)
        };
        blocks.map(state).collect()
    }

    /// Least distance of a contact from the middle between closed and open: |λ − gap/c|/(λ + gap/c).
    fn decided(&self, gap: &[f64]) -> f64 {
        let softness = &self.setup.problem.softness;
        let pressed = self.cones.iter().filter(|cone| cone.growth > 0.0);
        pressed.fold(1.0, |least: f64, cone| {
            let i = cone.normal;
            let (force, other) = (self.at.lambda[i], gap[i] / softness[i]);
            least.min((force - other).abs() / (force.abs() + other.abs()))
        })
    }

    /// Goes one step; `None` where rounding prevents it.
    fn step(&mut self, compliance: &Mat<f64>) -> Option<()> {
        let scalings: Option<Vec<Scaling>> = self
            .cones
            .iter()
            .map(|cone| Scaling::new(&cone.s, &cone.z))
            .collect();
        let scalings = scalings?;
        let slips: Vec<(f64, [f64; 2])> = self.cones.iter().map(Cone::slip).collect();
        let system = Linear::new(self, compliance, &scalings, &slips)?;
        let products = self.cones.iter().map(|cone| inner(&cone.s, &cone.z));
        let count = self.cones.len() as f64;
        let tau = products.sum::<f64>() / count;
        // L and the required change of L∘L
        let middles: Vec<Vector> = self
            .cones
            .iter()
            .zip(&scalings)
            .map(|(cone, w)| w.forth(&cone.z))
            .collect();
        let towards = middles
            .iter()
            .map(|l| jordan(l, l).map(|x| -x))
            .collect::<Vec<_>>();
        let first = system.solve(self, &scalings, &slips, (&middles, &towards));
        let length = self.reach(&first).min(1.0);
        let after = self.cones.iter().zip(&first.cones).map(|(cone, (ds, dz))| {
            inner(&moved(&cone.s, length, ds), &moved(&cone.z, length, dz))
        });
        let part = (after.sum::<f64>() / count / tau)
            .clamp(0.0, 1.0)
            .powi(3)
            .max(FALL);
        let corrected =
            towards
                .iter()
                .zip(&scalings)
                .zip(&first.cones)
                .map(|((t, w), (ds, dz))| {
                    let second = jordan(&w.back(ds), &w.forth(dz));
                    let mut t = moved(t, -1.0, &second);
                    t[0] += part * tau;
                    t
                });
        let mut corrected: Vec<Vector> = corrected.collect();
        let mut change = system.solve(self, &scalings, &slips, (&middles, &corrected));
        let mut far = self.reach(&change).min(1.0);
        let follows = self.cones.iter().any(|cone| cone.follows);
        for _ in 0..if follows { 0 } else { CENTRED } {
            let aimed = (far + FARTHER).min(1.0);
            let outside = self.outside(&scalings, &change, (aimed, part * tau));
            let terms = corrected.iter().zip(&outside);
            let terms: Vec<Vector> = terms.map(|(t, more)| moved(t, 1.0, more)).collect();
            let other = system.solve(self, &scalings, &slips, (&middles, &terms));
            let reach = self.reach(&other).min(1.0);
            if reach < far + WORTH * FARTHER {
                break;
            }
            (corrected, change, far) = (terms, other, reach);
        }
        let border = match follows {
            true => SHORT + FURTHER * length,
            false => 1.0 - (LEFT * (1.0 - length)).max(LEAST_LEFT),
        };
        let length = (border * self.reach(&change)).min(1.0);
        let finite = change
            .lambda
            .iter()
            .chain(&change.alpha)
            .all(|x| x.is_finite());
        if !finite {
            return None;
        }
        let add =
            |to: &mut [f64], by: &[f64]| to.iter_mut().zip(by).for_each(|(x, d)| *x += length * d);
        add(&mut self.at.lambda, &change.lambda);
        add(&mut self.at.alpha, &change.alpha);
        for (cone, (_, dz)) in self.cones.iter_mut().zip(&change.cones) {
            cone.s = cone.image(&self.at.lambda);
            cone.s[0] += cone.given;
            cone.z = moved(&cone.z, length, dz);
        }
        Some(())
    }

    /// Changes that bring the products s∘z near τ after a step of length `aimed`: an outlying product keeps all cones from longer
    /// steps.
    fn outside(
        &self,
        scalings: &[Scaling],
        change: &Change,
        (aimed, tau): (f64, f64),
    ) -> Vec<Vector> {
        let cones = self.cones.iter().zip(scalings).zip(&change.cones);
        let each = cones.map(|((cone, w), (ds, dz))| {
            let own = w.back(&moved(&cone.s, aimed, ds));
            let other = w.forth(&moved(&cone.z, aimed, dz));
            lacking(&jordan(&own, &other), tau)
        });
        each.collect()
    }

    /// The longest step along a change within the cones.
    fn reach(&self, change: &Change) -> f64 {
        let cones = self.cones.iter().zip(&change.cones);
        cones.fold(f64::INFINITY, |t, (cone, (ds, dz))| {
            t.min(reach(&cone.s, ds)).min(reach(&cone.z, dz))
        })
    }
}

/// Rows of the balance as orthonormal ones.
struct Orthonormal {
    /// Q = TG, (k) of (n,).
    rows: Vec<Vec<f64>>,
    /// T, (k) of (k,).
    from: Vec<Vec<f64>>,
}

impl Orthonormal {
    /// Gram–Schmidt, twice, the longest row first: where few contacts press, the remainders of the other rows are small beside it,
    /// and yet they hold the body.
    fn of(mut rows: Vec<Vec<f64>>) -> Self {
        let k = rows.len();
        let mut from: Vec<Vec<f64>> = (0..k)
            .map(|i| (0..k).map(|j| f64::from(i == j)).collect())
            .collect();
        let subtract = |lists: &mut [Vec<f64>], i: usize, part: f64, j: usize| {
            let [own, other] = lists.get_disjoint_mut([i, j]).expect("rows are two");
            own.iter_mut()
                .zip(&*other)
                .for_each(|(x, y)| *x -= part * y);
        };
        for next in 0..k {
            let longest = (next..k).max_by(|&a, &b| norm(&rows[a]).total_cmp(&norm(&rows[b])));
            let longest = longest.expect("a row is left");
            rows.swap(next, longest);
            from.swap(next, longest);
            for before in 0..next {
                let part = dot(&rows[next], &rows[before]);
                subtract(&mut rows, next, part, before);
                subtract(&mut from, next, part, before);
            }
            let size = norm(&rows[next]);
            for list in [&mut rows[next], &mut from[next]] {
                list.iter_mut().for_each(|x| *x /= size);
            }
            for after in next + 1..k {
                let part = dot(&rows[after], &rows[next]);
                subtract(&mut rows, after, part, next);
                subtract(&mut from, after, part, next);
            }
        }
        Self { rows, from }
    }
}

/// The linear problem of one step, scaled to a unit diagonal beside orthonormal rows of the balance, and factored.
struct Linear {
    matrix: Mat<f64>,
    factors: Lu,
    /// Scale factors of the unknowns.
    scales: Vec<f64>,
    rows: Orthonormal,
    /// Right sides: minus the residuals of the conditions of the bodies, (m,), and of the balance, (k,).
    rest: (Vec<f64>, Vec<f64>),
}

impl Linear {
    fn new(
        at: &Interior<'_>,
        compliance: &Mat<f64>,
        scalings: &[Scaling],
        slips: &[(f64, [f64; 2])],
    ) -> Option<Self> {
        let setup = at.setup;
        let (m, k) = (setup.len(), setup.modes());
        let mut gained: Vec<f64> = at
            .at
            .product
            .iter()
            .zip(&setup.shift)
            .map(|(p, d)| d - p)
            .collect();
        setup.balance.add_transposed(1.0, &at.at.alpha, &mut gained);
        for (cone, (size, _)) in at.cones.iter().zip(slips) {
            let mut push = cone.z;
            push[0] -= size;
            cone.add(&push, [0.0; 2], &mut gained);
        }
        let mut balance = vec![0.0; k];
        setup.balance.imbalance(&at.at.lambda, &mut balance);
        balance.iter_mut().for_each(|x| *x = -*x);

        let n = at.unknown.len();
        let mut place = vec![usize::MAX; m];
        at.unknown
            .iter()
            .enumerate()
            .for_each(|(own, &i)| place[i] = own);
        let mut matrix = Mat::zeros(n + k, n + k);
        for (column, &j) in at.unknown.iter().enumerate() {
            let (from, to) = (compliance.col_as_slice(j), matrix.col_as_slice_mut(column));
            at.unknown.iter().zip(to).for_each(|(&i, to)| *to = from[i]);
        }
        let mut column = vec![0.0; m];
        for ((cone, scaling), (_, slope)) in at.cones.iter().zip(scalings).zip(slips) {
            for j in cone.components() {
                let mut unit = [0.0; 3];
                match j == cone.normal {
                    true => unit[0] = cone.growth,
                    false => unit[j - cone.tangents.start + 1] = 1.0,
                }
                cone.add(&scaling.back_twice(&unit), *slope, &mut column);
                for i in cone.components() {
                    matrix[(place[i], place[j])] += std::mem::take(&mut column[i]);
                }
            }
        }
        let scales: Vec<f64> = (0..n).map(|i| power_of_two(matrix[(i, i)])).collect();
        let rows = at.unknown.iter().zip(&scales);
        let rows = (0..k).map(|row| {
            rows.clone()
                .map(|(&i, scale)| at.modes[i][row] * scale)
                .collect()
        });
        let rows = Orthonormal::of(rows.collect());
        for (column, own) in scales.iter().enumerate() {
            let entries = matrix.col_as_slice_mut(column)[..n].iter_mut();
            entries
                .zip(&scales)
                .for_each(|(x, scale)| *x *= own * scale);
        }
        for (row, values) in rows.rows.iter().enumerate() {
            for (column, &value) in values.iter().enumerate() {
                matrix[(n + row, column)] = value;
                matrix[(column, n + row)] = -value;
            }
        }
        Some(Self {
            factors: Lu::graded(matrix.clone()).ok()?,
            matrix,
            scales,
            rows,
            rest: (gained, balance),
        })
    }

    /// The change that takes L∘L by `towards` in every cone.
    fn solve(
        &self,
        at: &Interior<'_>,
        scalings: &[Scaling],
        slips: &[(f64, [f64; 2])],
        (middles, towards): (&[Vector], &[Vector]),
    ) -> Change {
        let (mut gained, n) = (self.rest.0.clone(), at.unknown.len());
        let cones = at.cones.iter().zip(scalings);
        let pushes = cones.clone().zip(middles.iter().zip(towards));
        let pushes: Vec<Vector> = pushes
            .map(|((_, w), (l, t))| w.back(&divided(t, l)))
            .collect();
        for ((cone, push), (_, slope)) in at.cones.iter().zip(&pushes).zip(slips) {
            cone.add(push, *slope, &mut gained);
        }
        let right = at.unknown.iter().zip(&self.scales);
        let right = right.map(|(&i, scale)| gained[i] * scale);
        let balance = self.rows.from.iter().map(|row| dot(row, &self.rest.1));
        let right: Vec<f64> = right.chain(balance).collect();
        let mut solution = vec![0.0; right.len()];
        let mut image = vec![0.0; right.len()];
        // the second pass removes rounding
        for _ in 0..2 {
            matvec(&self.matrix, &solution, &mut image);
            let mut left = Mat::from_fn(right.len(), 1, |i, _| right[i] - image[i]);
            self.factors.solve_in_place(&mut left);
            solution
                .iter_mut()
                .zip(left.col_as_slice(0))
                .for_each(|(x, d)| *x += d);
        }
        let (forces, amplitudes) = solution.split_at(n);
        let mut alpha = vec![0.0; amplitudes.len()];
        for (row, amplitude) in self.rows.from.iter().zip(amplitudes) {
            alpha
                .iter_mut()
                .zip(row)
                .for_each(|(alpha, x)| *alpha += amplitude * x);
        }
        let mut lambda = vec![0.0; at.setup.len()];
        let forces = forces.iter().zip(&self.scales);
        at.unknown
            .iter()
            .zip(forces)
            .for_each(|(&i, (x, scale))| lambda[i] = x * scale);
        let cones = cones.zip(&pushes).map(|((cone, scaling), push)| {
            let ds = cone.image(&lambda);
            (ds, moved(push, -1.0, &scaling.back_twice(&ds)))
        });
        Change {
            cones: cones.collect(),
            alpha,
            lambda,
        }
    }
}

/// About 1/√x, a power of two, which rounds nothing; 1 where x has no such power.
fn power_of_two(x: f64) -> f64 {
    match x > 0.0 && x.is_finite() {
        true => (-0.5 * x.log2()).round().exp2(),
        false => 1.0,
    }
}

/// The middle one of some values.
fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{DualProblem, Friction};
    use crate::solve::tests::{apart, applied, by_trial, definite, of, of_rank, silent};

    const S: Vector = [2.0, 0.7, -0.9];
    const Z: Vector = [0.9, -0.6, 0.2];

    #[test]
    fn products_far_from_the_others_are_brought_nearer() {
        let tau = 0.2;
        // without tangents: near, too small, too large, far too large
        for (product, lacks) in [(0.3, 0.0), (0.005, 0.015), (2.5, -0.5), (9.0, -2.0)] {
            let [head, rest @ ..] = lacking(&[product, 0.0, 0.0], tau);
            assert!((head - lacks).abs() < 1e-15 && rest == [0.0; 2]);
        }
        // eigenvalues -0.5 and 3.5 along (0.6, -0.8): to 0.02 and 2
        let change = lacking(&[1.5, 1.2, -1.6], tau);
        let after = moved(&[1.5, 1.2, -1.6], 1.0, &change);
        assert!(apart(&after, &[1.01, 0.99 * 0.6, -0.99 * 0.8]) < 1e-14);
    }

    #[test]
    fn both_points_of_a_cone_are_taken_to_one() {
        for (s, z) in [
            (S, Z),
            ([3.0, 0.4, 0.0], [0.5, 0.1, 0.0]),
            ([5.0, 0.0, 0.0], [0.2, 0.0, 0.0]),
        ] {
            let scaling = Scaling::new(&s, &z).unwrap();
            let (from, back) = (scaling.forth(&z), scaling.back(&s));
            assert!(apart(&from, &back) < 1e-14, "{from:?} {back:?}");
            assert!(apart(&scaling.back(&scaling.forth(&s)), &s) < 1e-14);
            let twice = scaling.back(&scaling.back(&s));
            assert!(apart(&scaling.back_twice(&s), &twice) < 1e-14);
            // s and z change by W, and stay inside
            assert!(determinant(&from) > 0.0 && from[0] > 0.0);
            // without tangents it is √(s/z)
            if s[1] == 0.0 {
                assert!((scaling.forth(&z)[0] - 1.0).abs() < 1e-14);
            }
        }
        assert!(Scaling::new(&[1.0, 1.0, 0.0], &Z).is_none());
        assert!(Scaling::new(&S, &[-2.0, 0.5, 0.0]).is_none());
    }

    #[test]
    fn products_of_a_cone_are_divided() {
        let product = jordan(&S, &Z);
        assert!(apart(&divided(&product, &S), &Z) < 1e-14);
        assert!(
            apart(
                &product,
                &[2.0 * 0.9 - 0.42 - 0.18, -1.2 + 0.63, 0.4 - 0.81]
            ) < 1e-14
        );
    }

    #[test]
    fn ways_end_at_the_border_of_a_cone() {
        let unit = [1.0, 0.0, 0.0];
        assert_eq!(reach(&unit, &[-1.0, 0.0, 0.0]), 1.0);
        assert_eq!(reach(&unit, &[0.0, 0.0, 4.0]), 0.25);
        assert_eq!(reach(&unit, &[1.0, 1.0, 0.0]), f64::INFINITY);
        assert_eq!(reach(&unit, &[1.0, 0.0, 0.0]), f64::INFINITY);
        assert_eq!(reach(&S, &[0.3, -0.3, 0.0]), f64::INFINITY);
        for ds in [
            [0.5, 1.0, 0.3],
            [-1.0, 0.2, 0.1],
            [1.0, -2.0, 2.0],
            [-1.0, 1.0, 0.0],
        ] {
            let t = reach(&S, &ds);
            let [inside, outside] = [0.999, 1.001].map(|part| moved(&S, part * t, &ds));
            assert!(inside[0] > tail(&inside), "{ds:?} {t}");
            assert!(outside[0] < tail(&outside), "{ds:?} {t}");
        }
    }

    fn solved(problem: &DualProblem) -> (Vec<f64>, usize) {
        let setup = Setup::new(problem).unwrap();
        let mut search = Search::new((1e-9, 200), &setup);
        let closed = search.all_closed();
        let ended = interior(&mut search, closed, &mut silent);
        assert!(matches!(ended, Ended::Converged), "{}", search.residual);
        let outcome = search.outcome(false);
        let certificate = problem.certify(&outcome.multipliers, 1e-8);
        assert!(certificate.holds(), "{certificate}");
        (outcome.multipliers.lambda, search.steps)
    }

    #[test]
    fn pressing_is_what_trial_of_all_choices_finds() {
        let (f, modes) = (
            definite(9),
            vec![vec![1.0; 9], (0..9).map(|i| i as f64 - 4.0).collect()],
        );
        for (modes, load) in [(&modes[..0], &[][..]), (&modes[..], &[3.0, 2.0])] {
            for turn in 0..20 {
                let shift: Vec<f64> = (0..9)
                    .map(|i| ((1.7 + 0.3 * turn as f64) * i as f64).cos())
                    .collect();
                let problem = of(
                    Compliance::Dense(f.clone()),
                    &shift,
                    vec![Block::Unilateral; 9],
                    (modes, load),
                );
                let (lambda, steps) = solved(&problem);
                let expected = by_trial(&f, &shift, (modes, load));
                assert!(apart(&lambda, &expected.lambda) < 1e-12);
                assert!(steps <= 14, "{steps}");
            }
        }
    }

    /// Contacts of compliances that differ by orders of magnitude.
    #[test]
    fn stiff_contacts_beside_soft_ones_are_found() {
        let c = [1.0, 1e-6, 1e6, 1.0];
        let f = Mat::from_fn(4, 4, |i, j| if i == j { c[i] } else { 0.0 });
        let shift = [1.0, -1e-3, 2e-3, -1.0];
        let problem = of(
            Compliance::Dense(f),
            &shift,
            vec![Block::Unilateral; 4],
            (&[], &[]),
        );
        let (lambda, _) = solved(&problem);
        assert!(apart(&lambda, &[1.0, 0.0, 2e-9, 0.0]) < 1e-15, "{lambda:?}");
    }

    /// Two nodes of a body that a load presses and pulls aside, with as much friction as holds it, and with given bounds.
    #[test]
    fn shears_of_a_floating_body_are_those_of_its_load() {
        let aside = [0.0, 1.0, 0.0, 1.0];
        let down = [1.0, 0.0, 1.0, 0.0];
        let a = [[1.0, 0.1, 0.2, 0.0], [0.0, 1.0, 0.0, 0.2]];
        for law in [
            Friction::Coulomb { coefficient: 0.5 },
            Friction::Tresca { bound: 0.5 },
        ] {
            let problem = of_rank(
                &a,
                &[0.0; 4],
                vec![law.block(1); 2],
                (&[down, aside], &[2.0, 0.9]),
            );
            let (lambda, _) = solved(&problem);
            assert!((lambda[0] + lambda[2] - 2.0).abs() < 1e-12);
            assert!((lambda[1] + lambda[3] - 0.9).abs() < 1e-12);
        }
    }

    /// A single node in space slips along its shear, at its bound, and is not lifted by that.
    #[test]
    fn slip_in_space_is_along_its_shear_and_does_not_lift() {
        let f = Mat::from_fn(3, 3, |i, j| if i == j { 2.0 } else { 0.0 });
        let law = |law: Friction| {
            let problem = of(
                Compliance::Dense(f.clone()),
                &[4.0, 3.0, -4.0],
                vec![law.block(2)],
                (&[], &[]),
            );
            solved(&problem).0
        };
        // pressed by 2; asked for (1.5, −2)
        let coulomb = law(Friction::Coulomb { coefficient: 0.5 });
        assert!(apart(&coulomb, &[2.0, 0.6, -0.8]) < 1e-12, "{coulomb:?}");
        let tresca = law(Friction::Tresca { bound: 1.5 });
        assert!(apart(&tresca, &[2.0, 0.9, -1.2]) < 1e-12, "{tresca:?}");
        let rough = law(Friction::Coulomb { coefficient: 1e9 });
        assert!(apart(&rough, &[2.0, 1.5, -2.0]) < 1e-12, "{rough:?}");
        let smooth = law(Friction::Tresca { bound: 0.0 });
        assert!(apart(&smooth, &[2.0, 0.0, 0.0]) < 1e-12, "{smooth:?}");
    }

    #[test]
    fn what_has_no_answer_or_no_matrix_ends_without_one() {
        let aside = [0.0, 1.0, 0.0, 1.0];
        let a = [[1.0, 0.1, 0.2, 0.0], [0.0, 1.0, 0.0, 0.2]];
        let block = Friction::Coulomb { coefficient: 0.5 }.block(1);
        // one pressed node bears 0.5, the other floats off
        let problem = of_rank(
            &a,
            &[1.0, 0.0, -1.0, 0.0],
            vec![block; 2],
            (&[aside], &[5.0]),
        );
        let setup = Setup::unchecked(&problem);
        let mut search = Search::new((1e-9, 200), &setup);
        let closed = search.all_closed();
        let ended = interior(&mut search, closed, &mut silent);
        assert!(matches!(ended, Ended::Stuck(_)) && search.steps <= 2 * INTERIOR_STEPS);

        let cohesive = Friction::Cohesive {
            cohesion: 1.0,
            coefficient: 0.5,
        }
        .block(1);
        let f = definite(2);
        for (compliance, block) in [
            (applied(&f, definite(2)), block),
            (Compliance::Dense(f.clone()), cohesive),
        ] {
            let problem = of(compliance, &[1.0, 0.1], vec![block], (&[], &[]));
            let setup = Setup::new(&problem).unwrap();
            let mut search = Search::new((1e-9, 200), &setup);
            let closed = search.all_closed();
            let ended = interior(&mut search, closed, &mut silent);
            assert!(matches!(ended, Ended::Stuck(_)) && search.steps == 0);
        }
    }
}
