//! The same problem elsewhere: turned, moved, and in other units.

use crate::amount::{Amount, moved_vector};
use crate::cells::Kind;
use crate::problem::{
    Against, Analysis, Body, Drive, Field, Gap, Law, Load, More, Place, Problem, Shape, Support,
    Surface,
};
use crate::raw::Mesh;
use crate::vector::{applied, axes, dot, lowered, plus, raised, times};

/// A rotation, a translation, and a change of the units of length and force.
#[derive(Debug, Clone, Copy)]
pub struct Carry<const D: usize> {
    /// Rows of the rotation.
    pub turn: [[f64; D]; D],
    pub lengths: f64,
    pub forces: f64,
    /// The new place of the origin.
    pub shift: [f64; D],
}

impl<const D: usize> Carry<D> {
    /// Other units alone.
    pub fn units(lengths: f64, forces: f64) -> Self {
        Self {
            turn: axes(),
            lengths,
            forces,
            shift: [0.0; D],
        }
    }

    /// A rotation alone.
    pub fn turn(turn: [[f64; D]; D]) -> Self {
        Self {
            turn,
            ..Self::units(1.0, 1.0)
        }
    }

    fn turns(&self) -> bool {
        self.turn != axes()
    }

    /// The new unit of stress.
    fn stress(&self) -> f64 {
        self.forces / (self.lengths * self.lengths)
    }

    /// The new place of a point.
    pub fn point(&self, x: [f64; D]) -> [f64; D] {
        plus(self.shift, self.lengths, applied(self.turn, x))
    }

    fn number(&self, number: &Amount<D>, factor: f64) -> Amount<D> {
        self.shifted(number.moved(factor, self.lengths, self.turn))
    }

    fn field(&self, field: &Field<D>, factor: f64) -> Field<D> {
        moved_vector(field, factor, self.lengths, self.turn).map(|c| self.shifted(c))
    }

    fn shifted(&self, mut number: Amount<D>) -> Amount<D> {
        for term in &mut number.0 {
            term.constant -= dot(term.slope, self.shift);
        }
        number
    }

    fn surface(&self, surface: &Surface<D>) -> Surface<D> {
        match *surface {
            Surface::Gap(ref gap) => Surface::Gap(self.number(gap, self.lengths)),
            Surface::Plane { point, normal } => Surface::Plane {
                point: self.point(point),
                normal: applied(self.turn, normal),
            },
            Surface::Round {
                center,
                radius,
                inside,
            } => Surface::Round {
                center: self.point(center),
                radius: radius * self.lengths,
                inside,
            },
            Surface::Cylinder {
                point,
                axis,
                radius,
                inside,
            } => Surface::Cylinder {
                point: self.point(point),
                axis: applied(self.turn, axis),
                radius: radius * self.lengths,
                inside,
            },
        }
    }

    /// A support in the new place; one axis alone can only be turned onto another axis.
    fn support(&self, support: &Support<D>) -> Option<Support<D>> {
        let place = match &support.place {
            Place::Side(side) => Place::Side(side.clone()),
            Place::Point(x) => Place::Point(self.point(*x)),
        };
        let given = support.axes.iter().flatten().count();
        let mut axes = std::array::from_fn(|_| None);
        if given == D {
            let field = support.axes.clone().map(Option::unwrap_or_default);
            axes = self.field(&field, self.lengths).map(Some);
        } else {
            for (axis, value) in support.axes.iter().enumerate() {
                let Some(value) = value else { continue };
                let direction = self.turn.map(|row| row[axis]);
                let new = direction.iter().position(|c| c.abs() == 1.0)?;
                axes[new] = Some(self.number(value, self.lengths * direction[new]));
            }
        }
        let normal = support.normal.as_ref();
        Some(Support {
            place,
            axes,
            normal: normal.map(|n| self.number(n, self.lengths)),
            from: support.from,
        })
    }

    fn load(&self, load: &mut Load<D>) {
        match load {
            Load::Traction { field, .. } => *field = self.field(field, self.stress()),
            Load::Pressure { field, .. } => *field = self.number(field, self.stress()),
            Load::InSitu { factor, .. } => *factor = self.number(factor, 1.0),
            Load::Force { point, field } => {
                *point = self.point(*point);
                *field = self.field(field, self.forces);
            }
        }
    }

    /// `None` for what cannot be turned: the components of an initial stress, and a bar along x.
    fn more(&self, more: &mut More<D>) -> Option<()> {
        let stress = self.stress();
        if self.turns() && (more.bar.is_some() || more.initial.is_some()) {
            return None;
        }
        for spring in &mut more.springs {
            spring.normal *= stress / self.lengths;
            spring.tangential *= stress / self.lengths;
        }
        if let Some(couple) = &mut more.couple {
            couple.point = self.point(couple.point);
            couple.area *= self.lengths * self.lengths;
        }
        if let Some(bar) = &mut more.bar {
            bar.at = self.point(bar.at);
            bar.stiffness = bar.stiffness * stress * self.lengths;
            if let Some(most) = bar.gives.as_mut().and_then(|gives| gives.most.as_mut()) {
                *most *= stress * self.lengths * self.lengths;
            }
            bar.to = bar.to.take().map(|(body, to)| (body, self.point(to)));
        }
        if let Some(metal) = &mut more.metal {
            (metal.yields, metal.hardening) = (metal.yields * stress, metal.hardening * stress);
        }
        if let Some(beyond) = &mut more.beyond {
            (beyond.border, beyond.young) = (beyond.border * self.lengths, beyond.young * stress);
        }
        for component in more.initial.iter_mut().flatten() {
            *component = self.number(component, stress);
        }
        Some(())
    }

    /// The shape elsewhere; `None` for one that is turned, a file, and those of space.
    fn shape(&self, shape: &mut Shape<D>) -> Option<()> {
        let larger = self.lengths;
        let place = |x: [f64; 2]| lowered(raised(self.point(lowered(raised(x)))));
        match shape {
            _ if self.turns() => return None,
            Shape::Block { from, to, .. } => {
                (*from, *to) = (self.point(*from), self.point(*to));
            }
            Shape::Ring { center, radii, .. } => {
                (*center, *radii) = (place(*center), radii.map(|r| r * larger));
            }
            Shape::Outline { size, from, edges } => {
                (*size, *from) = (*size * larger, place(*from));
                for edge in edges {
                    edge.to = place(edge.to);
                    edge.center = edge.center.map(place);
                }
            }
            Shape::Disc {
                size,
                center,
                radius,
                ..
            } => {
                (*size, *center, *radius) = (*size * larger, place(*center), *radius * larger);
            }
            Shape::Region(_) => {}
            _ => return None,
        }
        Some(())
    }

    /// With `mesh` the body has this mesh, as a file.
    fn body(&self, body: &mut Body<D>, analysis: Analysis, mesh: Option<&Mesh<D>>) -> Option<()> {
        let stress = self.stress();
        body.young *= stress;
        self.more(&mut body.more)?;
        if matches!(analysis, Analysis::PlaneStrain | Analysis::PlaneStress) {
            body.thickness *= self.lengths;
        }
        body.weight = self.field(&body.weight, stress / self.lengths);
        let supports = body.supports.iter().map(|s| self.support(s));
        body.supports = supports.collect::<Option<_>>()?;
        body.loads.iter_mut().for_each(|load| self.load(load));
        for (_, surface) in &mut body.surfaces {
            *surface = self.surface(surface);
        }
        if let Some(mesh) = mesh {
            body.patches.clear();
            body.shape = Shape::File {
                name: format!("{}.msh", body.name),
                text: gmsh(mesh, |x| self.point(x)),
            };
            return Some(());
        }
        if self.turns() && !body.patches.is_empty() {
            return None;
        }
        for patch in &mut body.patches {
            (patch.low, patch.high) = (self.point(patch.low), self.point(patch.high));
        }
        self.shape(&mut body.shape)
    }

    /// The same problem elsewhere, with these meshes as files; without meshes `None` if a mesh generator cannot move a body.
    pub fn problem(&self, problem: &Problem<D>, meshes: Option<&[Mesh<D>]>) -> Option<Problem<D>> {
        let stress = self.stress();
        let mut twin = problem.clone();
        let uniform = problem.uniform.as_ref();
        twin.uniform = uniform.map(|p| self.number(p, stress));
        if let Some(other) = &mut twin.other {
            other.problem = self.problem(&other.problem, None)?;
        }
        // the mesh of a region depends on rounding where distances between points are equal
        if twin.drawing.is_some() || (self.turns() && !twin.sections.is_empty()) {
            return None;
        }
        for station in twin.sections.iter_mut().flat_map(|s| &mut s.stations) {
            *station = times(self.lengths, *station);
        }
        for (b, body) in twin.bodies.iter_mut().enumerate() {
            self.body(body, problem.analysis, meshes.map(|all| &all[b]))?;
        }
        for contact in &mut twin.contacts {
            if let Gap::Given(gap) = &mut contact.gap {
                *gap = self.number(gap, self.lengths);
            }
            match &mut contact.law {
                Law::Tresca(bound) => *bound = self.number(bound, stress),
                Law::Coulomb(coefficient) => *coefficient = self.number(coefficient, 1.0),
                Law::Joint {
                    cohesion, tension, ..
                } => (*cohesion, *tension) = (*cohesion * stress, *tension * stress),
                Law::Frictionless | Law::Tied => {}
            }
            if let Against::Obstacle { surface, drive } = &mut contact.against {
                *surface = self.surface(surface);
                match drive {
                    Drive::Nothing => {}
                    Drive::Displacement(field) => *field = self.field(field, self.lengths),
                    Drive::Force(field) => *field = self.field(field, self.forces),
                }
            }
        }
        Some(twin)
    }
}

/// A mesh file with moved nodes.
pub fn gmsh<const D: usize>(mesh: &Mesh<D>, place: impl Fn([f64; D]) -> [f64; D]) -> String {
    let points: Vec<[f64; 3]> = mesh.points.iter().map(|&x| raised(place(x))).collect();
    let cell = |(kind, nodes): &(Kind, Vec<usize>)| (kind.gmsh(), kind.in_gmsh(nodes));
    let cells: Vec<_> = mesh.cells.iter().map(cell).collect();
    let facet = |nodes: &Vec<usize>| {
        let kind = Kind::of_facet(D, nodes.len());
        (kind.gmsh(), nodes.clone())
    };
    let side = |(name, facets): (&String, &Vec<Vec<usize>>)| {
        (name.clone(), facets.iter().map(facet).collect())
    };
    crate::gmsh::text(D, &points, &cells, &mesh.sides.iter().map(side).collect())
}
