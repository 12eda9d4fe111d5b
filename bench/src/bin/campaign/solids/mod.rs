//! Random legal problems of space, by family.
//!
//! A family builds its bodies in units in which they are about one long and the softest modulus is one; strains are about
//! 1e-5 to 1e-3, so that displacements stay small beside cells. Afterwards most problems are turned in space, scaled to other
//! units, their cells made skew; meshes are files then.
//! If statics decides whether the contacts can hold the load, the family records it: with forces in the cones of friction at
//! points that face each other, and a margin on either side.

mod boxes;
mod friction;
mod rounds;

use crate::amount::{Amount, Time};
use crate::carry::Carry;
use crate::cells::Kind;
use crate::elastic::external;
use crate::jitter::jitter;
use crate::problem::{
    self, Against, Analysis, Contact, Gap, Known, Pairing, Side, constant, driven, on, roller,
    steps,
};
use crate::random::Random;
use crate::raw::Mesh;
use crate::solve::meshes;
use crate::statics::{MARGIN, both, held, poisson};
use crate::vector::{axes, cross, minus, random_rotation};

type Vector = [f64; 3];
type Number = Amount<3>;
type Field = problem::Field<3>;
type Body = problem::Body<3>;
type Problem = problem::Problem<3>;
type Shape = problem::Shape<3>;
type Surface = problem::Surface<3>;
type Drive = problem::Drive<3>;
type Law = problem::Law<3>;

/// Makes a problem.
type Make = fn(&mut Scene);

/// All families; the last one, which is large, comes only where it is named.
pub const FAMILIES: [(&str, Make); 12] = [
    ("uniform", boxes::uniform),
    ("stack", boxes::stack),
    ("bridge", boxes::bridge),
    ("history", boxes::history),
    ("incline", friction::incline),
    ("groove", friction::groove),
    ("corner", friction::corner),
    ("mover", friction::mover),
    ("ball", rounds::ball),
    ("bowl", rounds::bowl),
    ("fit", rounds::fit),
    ("crowd", boxes::crowd),
];

/// The problem of a seed; `only` is the family, else the seed chooses.
pub fn problem(seed: u64, only: Option<&str>) -> Problem {
    let mut random = Random::new(seed);
    let chosen = random.count(0, FAMILIES.len() - 2);
    let place = FAMILIES.iter().position(|(name, _)| Some(*name) == only);
    let (family, make) = FAMILIES[place.unwrap_or(chosen)];
    let mut scene = Scene::new(random, family);
    make(&mut scene);
    scene.finished()
}

/// Bodies whose loads some points must hold.
struct Part {
    bodies: Vec<usize>,
    pushes: Vec<Push>,
    margin: Margin,
}

/// The margin with which bodies are known to be held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Margin {
    /// A very small margin: there is only one way to slide.
    Sharp,
    /// A quarter of lengths and coefficients: pushes of coarse meshes do not reach the ends of a side.
    Wide,
    /// Unknown: a wedge may use up its friction across the direction of sliding.
    Unknown,
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
    dofs: f64,
    kinds: Vec<Kind>,
    parts: Vec<Part>,
}

impl Scene {
    fn new(mut random: Random, family: &'static str) -> Self {
        use Kind::{Hex8, Hex20, Hex27, Prism6, Prism15, Prism18, Tet4, Tet10};
        let all = [Hex8, Tet4, Hex20, Tet10, Hex27, Prism6, Prism15, Prism18];
        let ratio = match random.count(0, 9) {
            0..=4 => 1.0,
            5..=8 => random.magnitude(1.0, 30.0),
            _ => random.magnitude(30.0, 1e6),
        };
        Self {
            strain: random.magnitude(1e-5, 1e-3),
            ratio,
            dofs: random.magnitude(150.0, 1500.0),
            kinds: match random.chance(0.5) {
                true => vec![random.pick(&all)],
                false => all.to_vec(),
            },
            problem: Problem::new(family, Analysis::Space),
            parts: Vec::new(),
            random,
        }
    }

    /// The problem turned, in random units, with skew cells and sides without their true surfaces, or as it is.
    fn finished(mut self) -> Problem {
        let moduli = self.problem.bodies.iter().map(|b| b.young);
        let softest = moduli.fold(f64::INFINITY, f64::min);
        let bodies = self.problem.bodies.iter_mut();
        bodies.for_each(|body| body.young /= softest);
        // the problem is solved without a change, so that the program reports its own error
        let Ok(mut meshes) = meshes::<3>(&self.problem.text()) else {
            return self.problem;
        };
        self.judge(&meshes);
        let random = &mut self.random;
        if random.chance(0.25) {
            return self.problem;
        }
        for (body, mesh) in self.problem.bodies.iter_mut().zip(&mut meshes) {
            if random.chance(0.2) {
                jitter(body, mesh, 0.12, random);
            }
            if random.chance(0.25) {
                body.surfaces.clear();
            }
        }
        let units = random.chance(0.5);
        let mut unit = || {
            if units {
                random.magnitude(1e-6, 1e6)
            } else {
                1.0
            }
        };
        let (lengths, forces) = (unit(), unit());
        let turn = match random.chance(0.8) {
            true => random_rotation(random),
            false => axes(),
        };
        let far = match random.chance(0.3) {
            true => lengths * random.magnitude(1.0, 100.0),
            false => 0.0,
        };
        let carry = Carry {
            turn,
            lengths,
            forces,
            shift: random_rotation(random)[0].map(|c| far * c),
        };
        let carried = carry.problem(&self.problem, Some(&meshes));
        carried.unwrap_or(self.problem)
    }

    /// Decides from the parts whether the contacts hold: each with the wrench of its loads at every time, and its possible pushes.
    fn judge(&mut self, meshes: &[Mesh<3>]) {
        let mut known = Known::Holds;
        for part in &self.parts {
            for &t in &self.problem.times {
                let mut load = ([0.0; 3], [0.0; 3]);
                for &b in &part.bodies {
                    let forces = external(&meshes[b], &self.problem.bodies[b], Analysis::Space, t);
                    for (&x, &f) in meshes[b].points.iter().zip(&forces) {
                        load = both(load, (f, cross(x, f)));
                    }
                }
                let inside = match part.margin {
                    Margin::Sharp => MARGIN,
                    _ => 0.25,
                };
                match held(load, &part.pushes, inside) {
                    Known::Holds if part.margin != Margin::Unknown => {}
                    Known::Falls => {
                        self.problem.known = Known::Falls;
                        return;
                    }
                    _ => known = Known::Open,
                }
            }
        }
        if !self.parts.is_empty() {
            self.problem.known = known;
        }
    }

    /// The loads of these bodies must be held by these pushes.
    pub fn must_hold(&mut self, bodies: Vec<usize>, pushes: Vec<Push>, margin: Margin, why: &str) {
        self.problem.reason = why.to_string();
        self.parts.push(Part {
            bodies,
            pushes,
            margin,
        });
    }

    /// It is known that the contacts hold.
    pub fn holds(&mut self, why: &str) {
        self.problem.known = Known::Holds;
        self.problem.reason = why.to_string();
    }

    /// Kind of the next body's cells.
    pub fn kind(&mut self) -> Kind {
        self.random.pick(&self.kinds)
    }

    /// A body without supports and loads.
    pub fn add(&mut self, name: &str, shape: Shape, kind: Kind) -> usize {
        let young = match self.ratio > 1.0 && self.random.chance(0.5) {
            true => self.random.magnitude(1.0, self.ratio),
            false => 1.0,
        };
        let poisson = poisson(&mut self.random);
        let body = Body::new(name, shape, kind, [young, poisson]);
        self.problem.bodies.push(body);
        self.problem.bodies.len() - 1
    }

    /// A box whose cells have about their share of the unknowns, one of `bodies` bodies.
    pub fn cuboid(&mut self, name: &str, from: Vector, to: Vector, bodies: usize) -> usize {
        let kind = self.kind();
        let per_cell = match kind {
            Kind::Hex8 | Kind::Tet4 | Kind::Prism6 => 3.0,
            Kind::Hex20 => 12.0,
            Kind::Prism15 => 15.0,
            _ => 24.0,
        };
        let [a, b, c] = minus(to, from);
        let cell = (a * b * c * per_cell * bodies as f64 / self.dofs).cbrt();
        let cell = cell * self.random.magnitude(0.7, 1.5);
        let cells = [a, b, c].map(|side| ((side / cell).round() as usize).clamp(1, 6));
        let shape = Shape::Block {
            from,
            to,
            cells,
            diagonals: "",
        };
        self.add(name, shape, kind)
    }

    /// Holds all components of a side, or moves it.
    pub fn hold(&mut self, body: usize, side: &str, field: Field) {
        let supports = &mut self.problem.bodies[body].supports;
        supports.push(driven(on(side), field));
    }

    /// Holds a side along its normal.
    pub fn roll(&mut self, body: usize, side: &str) {
        let supports = &mut self.problem.bodies[body].supports;
        supports.push(roller(side, Number::from(0.0)));
    }

    /// A traction on a side.
    pub fn pull(&mut self, body: usize, side: &str, field: Field) {
        self.problem.bodies[body].pull(side, field);
    }

    /// A contact of two sides, in either order and by either kind of name.
    pub fn touch(&mut self, a: Side, b: Side, law: Law) {
        let swap = self.random.chance(0.5);
        let (own, side) = if swap { (b, a) } else { (a, b) };
        let chosen = self.random.chance(0.3);
        self.push(own, Against::Side { side, chosen }, law);
    }

    /// A contact with an obstacle.
    pub fn stand(&mut self, own: Side, surface: Surface, drive: Drive, law: Law) {
        self.push(own, Against::Obstacle { surface, drive }, law);
    }

    /// A contact.
    pub fn push(&mut self, own: Side, against: Against<3>, law: Law) {
        let name = format!("c{}", self.problem.contacts.len());
        let gap = match law != Law::Tied && self.random.chance(0.1) {
            true => Gap::Geometric,
            false => Gap::Default,
        };
        let pairing = match self.random.chance(0.12) {
            true => Pairing::Mortar,
            false => Pairing::Default,
        };
        self.problem.contacts.push(Contact {
            name,
            own,
            against,
            pairing,
            gap,
            law,
        });
    }

    /// A coefficient of friction.
    pub fn coefficient(&mut self) -> f64 {
        match self.random.count(0, 9) {
            0 => 0.05,
            1 => self.random.between(0.8, 1.5),
            _ => self.random.between(0.1, 0.8),
        }
    }

    /// Frictionless or, with this probability, Coulomb's law.
    pub fn law(&mut self, rough: f64) -> Law {
        match self.random.chance(rough) {
            true => Law::Coulomb(Amount::from(self.coefficient())),
            false => Law::Frictionless,
        }
    }

    /// Steps at the times 1, 2, ..
    pub fn steps(&mut self, counts: &[usize]) -> usize {
        let count = self.random.pick(counts);
        self.problem.times = steps(count);
        count
    }

    /// A path in the plane, with a random length between the parts `part` of `size`: to and fro along a line, around an ellipse, or
    /// straight on.
    pub fn path(&mut self, size: f64, part: [f64; 2], count: usize) -> [Number; 2] {
        let [x, y] = self.direction(size, part);
        let omega = self.random.between(0.6, 2.2);
        let times = match self.random.count(0, 2) {
            0 => [Time::Wave(omega, 0.0); 2],
            1 => [Time::Wave(omega, 0.0), Time::Wave(omega, 1.2)],
            _ => [Time::Line(0.0, 1.0 / count as f64); 2],
        };
        [Number::timed(x, times[0]), Number::timed(y, times[1])]
    }

    /// A random vector in the plane, with a length between the parts `part` of `size`.
    pub fn direction(&mut self, size: f64, part: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.random.between(0.0, 6.3).sin_cos();
        let size = size * self.random.between(part[0], part[1]);
        [size * c, size * s]
    }
}

/// A history of loads: constant, growing, or to and fro.
pub fn course(random: &mut Random, steps: usize) -> Time {
    match (steps, random.count(0, 2)) {
        (1, _) | (_, 0) => Time::Always,
        (_, 1) => Time::Line(0.0, 1.0 / steps as f64),
        _ => Time::Wave(random.between(0.5, 2.5), random.between(0.0, 6.0)),
    }
}

/// A possible push.
pub type Push = crate::statics::Push<3>;

/// Pushes from below at the corners of a rectangle at a height.
pub fn from_below(low: [f64; 2], high: [f64; 2], z: f64, friction: f64) -> Vec<Push> {
    let corners = [
        [low[0], low[1]],
        [high[0], low[1]],
        [high[0], high[1]],
        [low[0], high[1]],
    ];
    let push = |[x, y]: [f64; 2]| Push {
        at: [x, y, z],
        direction: axes()[2],
        friction,
    };
    corners.map(push).to_vec()
}

/// The same everywhere and always, along z.
pub fn upwards(force: f64) -> Field {
    constant([0.0, 0.0, force])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_writes_the_same_file_for_the_same_seed() {
        for (name, _) in FAMILIES {
            for seed in 0..10 {
                let (a, b) = (problem(seed, Some(name)), problem(seed, Some(name)));
                assert_eq!(a.text(), b.text());
                assert!(!a.bodies.is_empty() && !a.contacts.is_empty(), "{name}");
            }
        }
    }
}
