//! The input of the user: bodies, supports, loads, contacts, solver options, probes.

use crate::model::nouns::ids::{BodyId, SideRef};
use std::convert::Infallible;
use std::fmt;

use crate::contact::Coupling;
use crate::dual::Friction;
use crate::geometry::{Field, Point};
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::gasket::Gasket;
use crate::model::nouns::member::MemberWords;
use crate::model::nouns::members::{Member, by_kind};
use crate::model::nouns::quantity::Quantity;
use crate::model::nouns::section::Section;

pub use crate::contact::Rigid;
pub use crate::fem::{
    Active, Ages, Analysis, Bed, Body, Components, Couple, CoupleKind, Cyclic, Elastic, Load,
    Material, Place, Support,
};

/// Names of units; they label the report and do not change numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Units {
    /// Unit of length, such as "m".
    pub length: Option<String>,
    /// Unit of force, such as "N".
    pub force: Option<String>,
}

/// A rigid obstacle: fixed, moved, or free to translate under a force.
#[derive(Debug, Clone)]
pub struct Obstacle<const D: usize> {
    /// Where its surface is.
    pub shape: Rigid<D>,
    /// Whether its motion is prescribed or follows from forces.
    pub motion: Motion<D>,
}

/// The drive of a rigid obstacle.
#[derive(Debug, Clone)]
pub enum Motion<const D: usize> {
    /// A prescribed displacement.
    Prescribed([Field; D]),
    /// It is free to translate, and carries this force.
    Loaded([Field; D]),
}

/// Who touches whom.
#[derive(Debug, Clone)]
pub enum Pair<const D: usize> {
    /// The first side carries the multipliers.
    Given {
        /// Carries the multipliers; its outward normal is the contact normal.
        nonmortar: SideRef,
        /// The other side.
        mortar: SideRef,
    },
    /// The more compliant body becomes the nonmortar side; within a factor 10 the finer one, unless its pressures would
    /// show the straight facets of the other.
    Automatic([SideRef; 2]),
    /// A body against a rigid obstacle.
    Obstacle {
        /// Carries the multipliers.
        nonmortar: SideRef,
        /// The obstacle that it touches.
        obstacle: Obstacle<D>,
    },
}

impl<const D: usize> Pair<D> {
    /// The side that it names first: results with a sign are those of its body.
    pub fn first(&self) -> &SideRef {
        match self {
            Self::Given { nonmortar, .. } | Self::Obstacle { nonmortar, .. } => nonmortar,
            Self::Automatic([first, _]) => first,
        }
    }

    /// The sides of bodies that it names, the nonmortar side first where it is known.
    pub fn sides(&self) -> Vec<&SideRef> {
        match self {
            Self::Given { nonmortar, mortar } => vec![nonmortar, mortar],
            Self::Automatic([a, b]) => vec![a, b],
            Self::Obstacle { nonmortar, .. } => vec![nonmortar],
        }
    }
}

/// How the two sides are coupled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pairing {
    /// One multiplier for each pair of coincident nodes.
    NodeToNode,
    /// Mortar integration over the common part of both sides.
    Mortar,
}

/// The initial gap.
#[derive(Debug, Clone)]
pub enum Gap {
    /// Measured between the two sides.
    Geometric,
    /// Measured between the two sides, where gaps up to this length, and overlaps, count as closed.
    Adjusted(f64),
    /// Zero by design, whatever the meshes say.
    Closed,
    /// Clearance > 0 or interference < 0 along the normal.
    Given(Field),
}

/// The contact law.
#[derive(Debug, Clone)]
pub enum Law {
    /// Unilateral, without friction.
    Frictionless,
    /// Unilateral with Coulomb friction (coefficient).
    Coulomb(Field),
    /// Unilateral with a given bound of the shear traction.
    Tresca(Field),
    /// A joint: it bears a tension up to its strength, and while closed a shear traction up to cohesion + coefficient · pressure; an open
    /// joint bears no traction. Where it parts or slips, cohesion and tension are lost from the next load step on: dry friction remains.
    Cohesive {
        /// A stress.
        cohesion: Field,
        /// Coefficient of friction.
        coefficient: Field,
        /// A stress, at most cohesion over coefficient.
        tension: Field,
    },
    /// Both sides move together; tension is allowed.
    Tied,
}

impl Law {
    /// The law of friction of a node, its fields evaluated by `at` and stresses multiplied by `weight`; `None` without friction. For a
    /// whole joint the normal force counts from its tensile strength.
    pub(crate) fn friction<E>(
        &self,
        at: impl Fn(&Field) -> Result<f64, E>,
        weight: f64,
    ) -> Result<Option<Friction>, E> {
        Ok(match self {
            Self::Frictionless | Self::Tied => None,
            Self::Coulomb(field) => Some(Friction::Coulomb {
                coefficient: at(field)?,
            }),
            Self::Tresca(field) => Some(Friction::Tresca {
                bound: at(field)? * weight,
            }),
            Self::Cohesive {
                cohesion,
                coefficient,
                tension,
            } => {
                let coefficient = at(coefficient)?;
                let borne = coefficient * at(tension)?;
                Some(Friction::Cohesive {
                    cohesion: (at(cohesion)? - borne).max(0.0) * weight,
                    coefficient,
                })
            }
        })
    }

    /// The displacements that it couples at a node.
    pub(crate) fn coupling(&self) -> Coupling {
        match self {
            Self::Frictionless => Coupling::Normal,
            Self::Tied => Coupling::Tied,
            _ => Coupling::Frictional,
        }
    }

    /// Its expressions.
    pub(crate) fn fields(&self) -> Vec<&Field> {
        match self {
            Self::Frictionless | Self::Tied => Vec::new(),
            Self::Coulomb(field) | Self::Tresca(field) => vec![field],
            Self::Cohesive {
                cohesion,
                coefficient,
                tension,
            } => vec![cohesion, coefficient, tension],
        }
    }

    /// The law after a joint has parted or slipped.
    pub(crate) fn dry(&self) -> Self {
        match self {
            Self::Cohesive { coefficient, .. } => Self::Coulomb(coefficient.clone()),
            other => other.clone(),
        }
    }

    /// Cohesion over coefficient: the largest strength in tension that a joint can have.
    pub(crate) fn most_tension<const D: usize>(&self, point: Point<D>, time: f64) -> f64 {
        match self {
            Self::Cohesive {
                cohesion,
                coefficient,
                ..
            } => match (cohesion.at(point, time), coefficient.at(point, time)) {
                (_, 0.0) => f64::INFINITY,
                (cohesion, coefficient) => cohesion / coefficient,
            },
            _ => 0.0,
        }
    }

    /// The tensile strength of a whole joint, a stress; `None` for other laws.
    pub(crate) fn tension(&self) -> Option<&Field> {
        match self {
            Self::Cohesive { tension, .. } => Some(tension),
            _ => None,
        }
    }

    /// Largest shear traction at a pressure, a point and a time; `None` without friction. For a joint that of the whole joint.
    pub fn shear_limit<const D: usize>(
        &self,
        pressure: f64,
        point: Point<D>,
        time: f64,
    ) -> Option<f64> {
        let at = |field: &Field| Ok::<f64, Infallible>(field.at(point, time));
        let Ok(law) = self.friction(at, 1.0);
        let tension = self.tension().map_or(0.0, |field| field.at(point, time));
        Some(law?.bound(pressure + tension))
    }
}

impl fmt::Display for Law {
    /// In words, with its fields.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frictionless => write!(f, "frictionless"),
            Self::Coulomb(field) => write!(f, "Coulomb friction {field}"),
            Self::Tresca(field) => write!(f, "Tresca friction {field}"),
            Self::Cohesive {
                cohesion,
                coefficient,
                tension,
            } => {
                write!(f, "friction {coefficient} with cohesion {cohesion}")?;
                match tension.as_constant() {
                    Some(0.0) => Ok(()),
                    _ => write!(f, " and tension {tension}"),
                }
            }
            Self::Tied => write!(f, "tied"),
        }
    }
}

/// A contact between two sides, or a side and a rigid obstacle.
#[derive(Debug, Clone)]
pub struct Contact<const D: usize> {
    /// Unique name.
    pub name: String,
    /// The sides.
    pub pair: Pair<D>,
    /// `None`: node-to-node where facets coincide and all nodal weights are positive, else mortar.
    pub pairing: Option<Pairing>,
    /// `None`: closed where node-to-node, else geometric.
    pub gap: Option<Gap>,
    /// The law of the interface.
    pub law: Law,
    /// What lies between the two bodies and is compressed; usually with [`Gap::Closed`], which counts its closure from the meshes as drawn.
    pub gasket: Option<Gasket>,
    /// Only facets that face each other within this distance take part, a length; `None`: all.
    pub reach: Option<f64>,
    /// Points and sides of the nonmortar body whose nodes are excluded: open, whatever is opposite.
    pub exclude: Vec<Place<D>>,
    /// Points and sides of the nonmortar body whose nodes take part without friction.
    pub friction_exclude: Vec<Place<D>>,
    /// When it is there, as long as its bodies are. One that appears later sees the true gap of its sides.
    pub active: Active,
}

/// Which algorithm solves the contact problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The best for the problem: Newton.
    #[default]
    Auto,
    /// Semismooth Newton (primal-dual active set).
    Newton,
    /// MPRGP with SMALBE for the balance.
    Mprgp,
    /// Projected gradient with exact projection.
    Gradient,
    /// Accelerated projected gradient with restart.
    Accelerated,
    /// Uzawa's iteration with crossed-secant acceleration.
    Secant,
    /// The paper's p,A-algorithm with bolts.
    Uzawa,
}

impl Method {
    /// All methods that name one algorithm.
    pub const NAMED: [Self; 6] = [
        Self::Newton,
        Self::Mprgp,
        Self::Gradient,
        Self::Accelerated,
        Self::Secant,
        Self::Uzawa,
    ];

    /// The name on the command line and in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Newton => "newton",
            Self::Mprgp => "mprgp",
            Self::Gradient => "gradient",
            Self::Accelerated => "accelerated",
            Self::Secant => "secant",
            Self::Uzawa => "uzawa",
        }
    }

    /// The method of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Auto]
            .into_iter()
            .chain(Self::NAMED)
            .find(|m| m.name() == name)
    }
}

/// Where the p,A-algorithm puts its bolts.
#[derive(Debug, Clone, PartialEq)]
pub enum Bolts<const D: usize> {
    /// Chosen from a bilateral solve, one per rigid mode.
    Automatic,
    /// The contact nodes nearest to these points, one per rigid mode.
    Points(Vec<Point<D>>),
}

/// Solver options; the default needs no choice of the user.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverOptions<const D: usize> {
    /// The algorithm.
    pub method: Method,
    /// Limit of every relative figure of the certificate (imbalances: 1e-10).
    pub tolerance: f64,
    /// Most iterations; `None`: the method's own default.
    pub max_iterations: Option<usize>,
    /// Step of gradient and uzawa, for λ in forces, unscaled; `None`: automatic.
    pub rho: Option<f64>,
    /// Bolts of uzawa.
    pub bolts: Bolts<D>,
    /// Bytes that matrices and factors may take; `None`: no limit. For cases it is the memory of the machine.
    pub memory: Option<u64>,
    /// Into how many pieces the bodies are divided.
    pub subdomains: Subdomains,
}

/// How bodies are divided into pieces, which are factored by themselves and glued in every solution (`linalg/glued.rs`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Subdomains {
    /// As size and memory ask for.
    #[default]
    Auto,
    /// So many pieces of about the same size in all; each body is at least one, and so is each part of it that no facet joins to others.
    Parts(usize),
}

impl<const D: usize> SolverOptions<D> {
    /// Takes another method and step instead of those of a case; options that the method does not use are dropped.
    ///
    /// Errors: the method, where it has no step.
    pub fn take(&mut self, method: Option<Method>, rho: Option<f64>) -> Result<(), Method> {
        self.method = method.unwrap_or(self.method);
        let steps = matches!(self.method, Method::Gradient | Method::Uzawa);
        if rho.is_some() && !steps {
            return Err(self.method);
        }
        self.rho = rho.or(self.rho).filter(|_| steps);
        if self.method != Method::Uzawa {
            self.bolts = Bolts::Automatic;
        }
        Ok(())
    }
}

impl<const D: usize> Default for SolverOptions<D> {
    fn default() -> Self {
        Self {
            method: Method::Auto,
            tolerance: crate::solve::TOLERANCE,
            max_iterations: None,
            rho: None,
            bolts: Bolts::Automatic,
            memory: None,
            subdomains: Subdomains::Auto,
        }
    }
}

/// A number to read off the solution, or numbers along a line.
#[derive(Debug, Clone)]
pub struct Probe<const D: usize> {
    /// Unique name.
    pub name: String,
    /// The quantity read.
    pub quantity: Quantity,
    /// Where, or how its values become one number.
    pub reading: Reading<D>,
    /// The line or side along which it is read; `None`: its whole body or contact.
    pub along: Option<Along<D>>,
    /// Minus the least-squares amplitude of the rigid modes that this body's supports leave free.
    pub minus_rigid: Option<BodyId>,
    /// Centre of hoop stresses in plane analyses, and of moments in space.
    pub center: Point<D>,
    /// A factor of each value before values become one number: of place and time, of time alone where there is one number.
    pub factor: Option<Field>,
}

/// How a quantity that varies becomes one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading<const D: usize> {
    /// As it is: a resultant or a length, which does not vary, or all values along a line.
    Whole,
    /// Its value at a point, interpolated.
    At(Point<D>),
    /// At the point of a couple, by its place among those of the body; of displacements.
    Coupled(usize),
    /// Mean of the two nodes nearest to a point (the paper's B and C).
    MeanOfNeighbours(Point<D>),
    /// Its largest value at a node.
    Largest,
    /// Its smallest value at a node.
    Smallest,
    /// Its mean over the volume of the body, over the nonmortar side where it has a value, or over the side that it is read
    /// along.
    Mean,
    /// Its integral over them, with thickness or 2πr.
    Integral,
}

/// Places in a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Along<const D: usize> {
    /// Points at equal distances from one to another, both included.
    Line {
        /// The first.
        from: Point<D>,
        /// The last.
        to: Point<D>,
        /// How many, at least two.
        points: usize,
    },
    /// The nodes of a side in the order of its chains, of a closed one the first once more at its end.
    Side(SideRef),
}

impl<const D: usize> Probe<D> {
    /// Of a quantity as it is.
    pub fn new(name: &str, quantity: Quantity, reading: Reading<D>) -> Self {
        Self {
            name: name.to_string(),
            quantity,
            reading,
            along: None,
            minus_rigid: None,
            center: [0.0; D],
            factor: None,
        }
    }

    /// The couple at whose point it is read.
    pub fn coupled<'m>(&self, model: &'m Model<D>) -> Option<&'m Couple<D>> {
        let Reading::Coupled(place) = self.reading else {
            return None;
        };
        let body = self.quantity.displaced_body()?;
        model.bodies.get(body)?.couples.get(place)
    }

    /// The dimension of its value.
    pub fn dimension(&self) -> Dimension {
        if self.factor.is_some() {
            return Dimension::Other;
        }
        match (self.reading, self.quantity.dimension()) {
            (Reading::Integral, Dimension::Stress)
                if self.quantity.is_of_contact()
                    || self.quantity.is_of_bed()
                    || self.along.is_some() =>
            {
                Dimension::Force
            }
            (Reading::Integral, _) => Dimension::Other,
            _ if D == 3 && self.quantity.is_extent() => Dimension::Area,
            (_, dimension) => dimension,
        }
    }

    /// It has values along a line, and no single one.
    pub fn is_line(&self) -> bool {
        self.along.is_some() && self.reading == Reading::Whole && self.quantity.is_field()
    }
}

impl<const D: usize> Reading<D> {
    /// The point that it is read at.
    pub fn point(self) -> Option<Point<D>> {
        match self {
            Self::At(point) | Self::MeanOfNeighbours(point) => Some(point),
            Self::Whole
            | Self::Coupled(_)
            | Self::Largest
            | Self::Smallest
            | Self::Mean
            | Self::Integral => None,
        }
    }
}

/// A complete problem.
#[derive(Debug, Clone)]
pub struct Model<const D: usize> {
    /// Title of the report.
    pub title: String,
    /// Where the problem comes from.
    pub source: String,
    /// Kind of analysis.
    pub analysis: Analysis,
    /// Labels of the report.
    pub units: Units,
    /// The bodies.
    pub bodies: Vec<Body<D>>,
    /// The contacts.
    pub contacts: Vec<Contact<D>>,
    /// Bolts, anchors, ties, and springs between places; those of a kind stand together in a case file and in results.
    pub members: Vec<Member<D>>,
    /// Bodies that are cut across for their section forces.
    pub sections: Vec<Section<D>>,
    /// How to solve.
    pub solver: SolverOptions<D>,
    /// The probes to read.
    pub probes: Vec<Probe<D>>,
    /// Times of the load steps, strictly increasing: loads, prescribed displacements, gaps and the motion of obstacles
    /// are taken at these times.
    pub times: Vec<f64>,
    /// Names of the load steps, empty where they have none; as many as times, or none at all.
    pub step_names: Vec<String>,
    /// Times: from the first load step at or after each of them on, displacements in results count from the end of the step before. They
    /// change nothing else.
    pub zeroed: Vec<f64>,
    /// Named values with which the model was made, for the results.
    pub parameters: Vec<(String, f64)>,
}

impl<const D: usize> Model<D> {
    /// The members of each kind that it has, in the order of all kinds.
    pub(crate) fn members_by_kind(&self) -> impl Iterator<Item = (MemberWords, Vec<&Member<D>>)> {
        by_kind(&self.members, |member| member.kind.words())
    }
}

impl<const D: usize> Model<D> {
    /// Time of the last load step.
    pub fn last_time(&self) -> f64 {
        self.times.last().copied().unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(method: Method) -> SolverOptions<2> {
        SolverOptions {
            method,
            rho: Some(2.0),
            bolts: Bolts::Points(vec![[1.0, 2.0]]),
            ..SolverOptions::default()
        }
    }

    #[test]
    fn what_belongs_to_the_replaced_method_goes_with_it() {
        let mut replaced = options(Method::Uzawa);
        replaced.take(Some(Method::Newton), None).unwrap();
        assert_eq!(replaced.method, Method::Newton);
        assert_eq!((replaced.rho, replaced.bolts), (None, Bolts::Automatic));

        let mut kept = options(Method::Uzawa);
        kept.take(Some(Method::Gradient), None).unwrap();
        assert_eq!((kept.rho, kept.bolts), (Some(2.0), Bolts::Automatic));

        let mut same = options(Method::Uzawa);
        same.take(None, Some(3.0)).unwrap();
        assert_eq!(same.rho, Some(3.0));
        assert_eq!(same.bolts, Bolts::Points(vec![[1.0, 2.0]]));
    }

    #[test]
    fn a_step_needs_a_method_that_takes_it() {
        for method in [
            Method::Auto,
            Method::Newton,
            Method::Mprgp,
            Method::Accelerated,
            Method::Secant,
        ] {
            assert_eq!(options(method).take(None, Some(1.0)), Err(method));
        }
    }
}
