//! Random legal problems, by family.
//!
//! A family builds its bodies in units in which they are about one long and the softest modulus is one; strains are about
//! 1e-5 to 1e-3, so that displacements stay small beside cells. Units are scaled afterwards.
//! If statics decides whether the contacts can hold the load, the family records it: with forces in the cones of friction at
//! points that face each other, and a margin on either side.

mod axis;
mod blocks;
mod faces;
mod floors;
mod friction;
mod histories;
mod metals;
mod rounds;
mod structures;
mod travel;

use crate::amount::{Amount, Time, vector_at};
use crate::carry::Carry;
use crate::cells::{Kind, gauss};
use crate::plane::Vector;
use crate::problem::{
    Against, Analysis, Body, Contact, Drive, Gap, Known, Law, Load, Pairing, Problem, Shape, Side,
    Surface, hold, on,
};
use crate::random::Random;
pub use crate::statics::Push;
use crate::statics::{MARGIN, both, held, poisson};
use crate::vector::{cross, length, minus, plus, times};

/// Makes a problem.
type Make = fn(&mut Scene);

/// All families.
pub const FAMILIES: [(&str, Make); 28] = [
    ("stack", blocks::stack),
    ("chain", blocks::chain),
    ("masonry", blocks::masonry),
    ("punch", blocks::punch),
    ("indenter", blocks::indenter),
    ("beam", blocks::beam),
    ("hanging", blocks::hanging),
    ("hook", blocks::hook),
    ("tied", blocks::tied),
    ("corner", friction::corner),
    ("tip", friction::tip),
    ("slide", friction::slide),
    ("incline", friction::incline),
    ("tresca", friction::tresca),
    ("floors", floors::floors),
    ("moving", floors::moving),
    ("free_obstacle", floors::free_obstacle),
    ("wedge", rounds::wedge),
    ("disc_box", rounds::disc_box),
    ("disc_v", rounds::disc_v),
    ("disc_plates", rounds::disc_plates),
    ("rings", rounds::rings),
    ("pin", rounds::pin),
    ("bore", rounds::bore),
    ("pocket", rounds::pocket),
    ("axi_stack", axis::stack),
    ("axi_sphere", axis::sphere),
    ("axi_fit", axis::fit),
];

/// Families that were added later. They are drawn separately: a new family in the first list would change the problem of every
/// seed. The problem of a seed in a named family never changes.
pub const MORE: [(&str, Make); 18] = [
    ("travel", travel::travel),
    ("steps", faces::steps_of_a_floor),
    ("teeth", faces::teeth),
    ("whole", faces::whole),
    ("shared", faces::shared),
    ("stages", histories::stages),
    ("resumed", histories::resumed),
    ("ground", histories::ground),
    ("bed", structures::bed),
    ("section", structures::section),
    ("layers", structures::layers),
    ("joint", structures::joint),
    ("couple", structures::couple),
    ("bar", structures::bar),
    ("graded", structures::graded),
    ("edge", rounds::edge),
    ("yielding", structures::yielding),
    ("metal", metals::metal),
];

/// The problem of a seed; `only` is the family, else the seed chooses among the first families, or with `more` among the later ones.
pub fn problem(seed: u64, only: Option<&str>, more: bool) -> Problem {
    let mut random = Random::new(seed);
    let number = random.bits() as usize;
    let mut all = FAMILIES.iter().chain(&MORE);
    let named = all.find(|(name, _)| Some(*name) == only);
    let &(family, make) = match named {
        Some(named) => named,
        None if more => &MORE[number % MORE.len()],
        None => &FAMILIES[number % FAMILIES.len()],
    };
    let mut scene = Scene::new(random, family);
    make(&mut scene);
    scene.scaled()
}

/// A problem in the making.
pub struct Scene {
    pub random: Random,
    pub problem: Problem,
    /// Nominal strain.
    pub strain: f64,
    /// Largest modulus over the smallest.
    ratio: f64,
    /// Unknowns of the displacements, about.
    pub dofs: f64,
    kinds: Vec<Kind>,
}

impl Scene {
    fn new(mut random: Random, family: &'static str) -> Self {
        let analysis = if random.chance(0.7) {
            Analysis::PlaneStrain
        } else {
            Analysis::PlaneStress
        };
        let ratio = match random.count(0, 19) {
            0..=7 => 1.0,
            8..=15 => random.magnitude(1.0, 30.0),
            16..=18 => random.magnitude(30.0, 1e4),
            _ => random.magnitude(1e4, 1e12),
        };
        let dofs = if random.chance(0.02) {
            random.magnitude(3000.0, 20_000.0)
        } else {
            random.magnitude(50.0, 3000.0)
        };
        let kinds = if random.chance(0.6) {
            vec![random.pick(&Kind::PLANE)]
        } else {
            Kind::PLANE.to_vec()
        };
        Self {
            strain: random.magnitude(1e-5, 1e-3),
            ratio,
            dofs,
            kinds,
            problem: Problem::new(family, analysis),
            random,
        }
    }

    /// The problem in random units, the softest modulus one before that.
    fn scaled(mut self) -> Problem {
        let moduli = self.problem.bodies.iter().map(|b| b.young);
        let softest = moduli.fold(f64::INFINITY, f64::min);
        let other = self.problem.other.as_deref_mut();
        let others = other.into_iter().flat_map(|o| &mut o.problem.bodies);
        for body in self.problem.bodies.iter_mut().chain(others) {
            body.young /= softest;
            if let Some(beyond) = &mut body.more.beyond {
                beyond.young /= softest;
            }
            if let Some(metal) = &mut body.more.metal {
                metal.yields /= softest;
                metal.hardening /= softest;
            }
        }
        if self.random.chance(0.4) {
            return self.problem;
        }
        let lengths = self.random.magnitude(1e-6, 1e6);
        let forces = self.random.magnitude(1e-6, 1e6);
        let carried = Carry::units(lengths, forces).problem(&self.problem, None);
        carried.unwrap_or(self.problem)
    }

    /// Kind of the next body's cells.
    pub fn kind(&mut self) -> Kind {
        self.random.pick(&self.kinds.clone())
    }

    fn modulus(&mut self) -> f64 {
        if self.ratio > 1.0 && self.random.chance(0.5) {
            match self.random.chance(0.5) {
                true => self.ratio,
                false => self.random.magnitude(1.0, self.ratio),
            }
        } else {
            1.0
        }
    }

    /// A body without supports and loads.
    pub fn add(&mut self, name: &str, shape: Shape, kind: Kind) -> usize {
        let young = self.modulus();
        let poisson = poisson(&mut self.random);
        let thickness = match self.problem.bodies.first() {
            Some(_) if self.random.chance(0.05) => self.random.magnitude(0.3, 3.0),
            Some(first) => first.thickness,
            None if self.random.chance(0.8) => 1.0,
            None => self.random.magnitude(0.1, 10.0),
        };
        let body = Body::new(name, shape, kind, [young, poisson]);
        self.problem.bodies.push(Body { thickness, ..body });
        self.problem.bodies.len() - 1
    }

    /// Length of cells with which an area has its share of the unknowns.
    pub fn cell_length(&self, area: f64, bodies: usize, kind: Kind) -> f64 {
        let per_cell = match kind {
            Kind::Tri3 | Kind::Quad4 => 2.0,
            Kind::Quad8 => 6.0,
            _ => 8.0,
        };
        (area * per_cell * bodies as f64 / self.dofs).sqrt()
    }

    /// A rectangle whose cells have about their share of the unknowns, one of `bodies` bodies.
    pub fn block(&mut self, name: &str, from: Vector, to: Vector, bodies: usize) -> usize {
        let kind = self.kind();
        let [w, h] = minus(to, from);
        let cell = self.cell_length(w * h, bodies, kind) * self.random.magnitude(0.6, 1.7);
        let cells = [w, h].map(|side| ((side / cell).round() as usize).clamp(1, 160));
        self.rectangle(name, from, to, cells, kind)
    }

    /// A rectangle with these cells.
    pub fn rectangle(
        &mut self,
        name: &str,
        from: Vector,
        to: Vector,
        cells: [usize; 2],
        kind: Kind,
    ) -> usize {
        let diagonals =
            self.random
                .pick(&["checkerboard", "forward", "backward", "checkerboard-odd"]);
        let shape = Shape::Block {
            from,
            to,
            cells,
            diagonals,
        };
        self.add(name, shape, kind)
    }

    /// A contact of two sides, in either order and by either kind of name.
    pub fn touch(&mut self, a: Side, b: Side, law: Law) -> usize {
        let (own, other) = if self.random.chance(0.5) {
            (a, b)
        } else {
            (b, a)
        };
        let chosen = self.random.chance(0.3);
        self.push(
            own,
            Against::Side {
                side: other,
                chosen,
            },
            law,
        )
    }

    /// A contact with an obstacle.
    pub fn stand(&mut self, own: Side, surface: Surface, drive: Drive, law: Law) -> usize {
        self.push(own, Against::Obstacle { surface, drive }, law)
    }

    fn push(&mut self, own: Side, against: Against, law: Law) -> usize {
        let name = format!("c{}", self.problem.contacts.len());
        let pairing = if self.random.chance(0.12) {
            Pairing::Mortar
        } else {
            Pairing::Default
        };
        self.problem.contacts.push(Contact {
            name,
            own,
            against,
            pairing,
            gap: Gap::Default,
            law,
        });
        self.problem.contacts.len() - 1
    }

    /// A coefficient of friction.
    pub fn coefficient(&mut self) -> f64 {
        match self.random.count(0, 9) {
            0 => 0.05,
            1 => self.random.between(1.0, 2.0),
            _ => self.random.between(0.1, 0.8),
        }
    }

    /// Frictionless or, with this probability, Coulomb's law.
    pub fn law(&mut self, rough: f64) -> Law {
        if self.random.chance(rough) {
            Law::Coulomb(Amount::from(self.coefficient()))
        } else {
            Law::Frictionless
        }
    }

    /// The same with a coefficient that may vary along x and in time, for problems whose statics does not depend on it.
    pub fn varied_law(&mut self, rough: f64) -> Law {
        let law = self.law(rough);
        let Law::Coulomb(_) = law else { return law };
        if self.random.chance(0.7) {
            return law;
        }
        let (mu, slope) = (
            self.random.between(0.2, 0.6),
            self.random.between(-0.015, 0.05),
        );
        let time = match self.random.chance(0.5) {
            true => Time::Always,
            false => Time::Line(1.0, self.random.between(-0.1, 0.2)),
        };
        Law::Coulomb(Amount::new(mu, [slope, 0.0], time))
    }

    /// Presses a body on its top, held along x at its left side.
    pub fn press_upright(&mut self, body: usize) {
        let pressure = self.strain * self.random.between(0.2, 1.0);
        let body = &mut self.problem.bodies[body];
        body.supports.push(hold(on("left"), 0));
        body.press("top", Amount::from(pressure));
    }

    /// Decides from single bodies whether the contacts hold: each with the wrench of its loads (about the origin) at every
    /// time, and its possible pushes. Pushes of coarse meshes do not reach the ends of a side: a body counts as held only if it is
    /// held without a quarter of the sides.
    pub fn judge(&mut self, parts: &[(Vec<Wrench>, Vec<Push>)], why: &str) {
        self.judge_within(parts, why, 0.25);
    }

    /// The same with the small margin `MARGIN`.
    pub fn judge_sharply(&mut self, parts: &[(Vec<Wrench>, Vec<Push>)], why: &str) {
        self.judge_within(parts, why, MARGIN);
    }

    fn judge_within(&mut self, parts: &[(Vec<Wrench>, Vec<Push>)], why: &str, inside: f64) {
        let mut known = Known::Holds;
        for (loads, pushes) in parts {
            for load in loads {
                match held(*load, pushes, inside) {
                    Known::Holds => {}
                    Known::Falls => {
                        self.problem.known = Known::Falls;
                        self.problem.reason = why.to_string();
                        return;
                    }
                    Known::Open => known = Known::Open,
                }
            }
        }
        self.problem.known = known;
        self.problem.reason = why.to_string();
    }

    /// The loads of a rectangle at all times, about the origin.
    pub fn loads(&self, body: usize) -> Vec<Wrench> {
        let times = self.problem.times.iter();
        times
            .map(|&t| rectangle_loads(&self.problem.bodies[body], t))
            .collect()
    }

    /// It is known that the contacts hold.
    pub fn holds(&mut self, why: &str) {
        self.problem.known = Known::Holds;
        self.problem.reason = why.to_string();
    }
}

/// Force and moment about the origin.
pub type Wrench = (Vector, [f64; 3]);

/// The wrench of a force at a point.
pub fn wrench(x: Vector, force: Vector) -> Wrench {
    (force, cross(x, force))
}

/// The loads of a rectangle.
pub fn rectangle_loads(body: &Body, t: f64) -> Wrench {
    let Shape::Block { from, to, .. } = body.shape else {
        return ([0.0; 2], [0.0; 3]);
    };
    let mut total = ([0.0; 2], [0.0; 3]);
    let mut add = |x: Vector, f: Vector| total = both(total, wrench(x, f));
    for load in &body.loads {
        let (side, field) = match load {
            Load::Traction { side, field } => (side, field.clone()),
            Load::Pressure { side, field } => {
                let into: Vector = match side.as_str() {
                    "top" => [0.0, -1.0],
                    "bottom" => [0.0, 1.0],
                    "left" => [1.0, 0.0],
                    _ => [-1.0, 0.0],
                };
                (side, into.map(|c| field.times(c)))
            }
            Load::InSitu { .. } => continue,
            Load::Force { point, field } => {
                add(*point, vector_at(field, *point, t));
                continue;
            }
        };
        let (a, b) = match side.as_str() {
            "top" => ([from[0], to[1]], to),
            "bottom" => (from, [to[0], from[1]]),
            "left" => (from, [from[0], to[1]]),
            _ => ([to[0], from[1]], to),
        };
        for (s, weight) in gauss(3) {
            let x = plus(times(0.5 * (1.0 - s), a), 0.5 * (1.0 + s), b);
            let area = 0.5 * weight * length(minus(b, a)) * body.thickness;
            add(x, times(area, vector_at(&field, x, t)));
        }
    }
    let middle = times(0.5, plus(from, 1.0, to));
    let [w, h] = minus(to, from);
    let volume = w * h * body.thickness;
    add(middle, times(volume, vector_at(&body.weight, middle, t)));
    total
}

/// Pushes from below at the ends of an interval at a height.
pub fn from_below(interval: [f64; 2], y: f64, friction: f64) -> Vec<Push> {
    let push = |x: f64| Push {
        at: [x, y],
        direction: [0.0, 1.0],
        friction,
    };
    interval.map(push).to_vec()
}

/// A load history: constant, or growing, or waving.
pub fn course(random: &mut Random, steps: usize) -> Time {
    if steps == 1 {
        return Time::Always;
    }
    match random.count(0, 2) {
        0 => Time::Line(0.0, 1.0 / steps as f64),
        1 => Time::Wave(random.between(0.5, 2.5), random.between(0.0, 6.0)),
        _ => Time::Always,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_writes_the_same_file_for_the_same_seed() {
        for (name, _) in FAMILIES.iter().chain(&MORE) {
            for seed in 0..20 {
                let made = || problem(seed, Some(name), false);
                let (a, b) = (made(), made());
                assert_eq!(a.text(), b.text());
                assert!(!a.bodies.is_empty(), "{name}");
            }
        }
    }
}
