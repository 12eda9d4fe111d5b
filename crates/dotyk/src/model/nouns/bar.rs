//! Bars: bolts, anchors and ties, straight and stiff along themselves alone.
//!
//! A bar is a chain of elements between points that move with the bodies. With the direction t of the bar, the displacement u_k
//! of its k-th point and the lengths L_k between them, element k pulls its ends together by
//!
//! ```text
//!   N_k = P + (EA/L_k) (e_k − e_a),       e_k = t·(u_{k+1} − u_k)
//! ```
//!
//! P is its prestress and e_a its reference elongation. A prestressed bar pulls with constant P in the step in which it comes, and e_a is
//! the elongation at the end of that step; without prestress e_a is that before the step. Its force may be limited: in compression
//! (`tension_only`, N ≥ 0), or where it yields, |N| ≤ yield · A, with a plastic elongation that stays.
//!
//! A bar held at its ends has one element. A grouted one has two or, in cells of second order, four in each cell that it crosses; its
//! points move with the cells in which they lie, and meshes need not fit. Across itself it has no stiffness.
//!
//! Units: N a force, of one bar. In the plane a model is as thick as its bodies: with `spacing` it holds thickness/spacing bars.

use crate::fem::Active;
use crate::geometry::Point;
use crate::model::nouns::ids::{BodyId, SideRef};

/// A bar between two places.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar<const D: usize> {
    /// Unique name.
    pub name: String,
    /// Where it begins and ends.
    pub ends: [BarEnd<D>; 2],
    /// The bodies in which its points lie; for sides the bodies of these.
    pub bodies: Vec<BodyId>,
    /// How it is connected to them.
    pub bond: Bond,
    /// Young's modulus.
    pub young: f64,
    /// Cross section of one bar.
    pub area: f64,
    /// The force with which it pulls in the step in which it comes; `None`: it comes without a force.
    pub prestress: Option<f64>,
    /// Distance of one bar to the next across a plane model; `None`: one bar in the thickness.
    pub spacing: Option<f64>,
    /// It bears no compression.
    pub tension_only: bool,
    /// Stress at which it yields.
    pub yields: Option<f64>,
    /// Its ends at points pull at a disc of this radius across it, in the plane at a line twice as long; `None`: at the point itself.
    pub radius: Option<f64>,
    /// When it is there, as long as its bodies are.
    pub active: Active,
}

/// Where a bar ends.
#[derive(Debug, Clone, PartialEq)]
pub enum BarEnd<const D: usize> {
    /// A point of one of its bodies.
    Point(Point<D>),
    /// The mean displacement of a side, at its centroid.
    Side(SideRef),
}

/// How a bar is connected to its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bond {
    /// At both ends.
    #[default]
    Ends,
    /// All along.
    Grouted,
}

impl Bond {
    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ends => "ends",
            Self::Grouted => "grouted",
        }
    }
}

/// Why a bar is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BarError {
    /// A number out of its range.
    #[error("its {what} is {value}: it must be {range}")]
    Number {
        /// Which.
        what: &'static str,
        /// The number.
        value: f64,
        /// The allowed range.
        range: &'static str,
    },
    /// A point that lies in no body of its own.
    #[error("its end {} lies in none of the bodies {bodies}", show(.point))]
    Off {
        /// Which end, from zero.
        end: usize,
        /// The point.
        point: Vec<f64>,
        /// The bodies, as a list.
        bodies: String,
    },
    /// Both ends are at the same place.
    #[error("its ends lie at the same place: it has no direction")]
    NoLength,
    /// A side without area.
    #[error("its side \"{side}\" is unknown, or has no area")]
    Side {
        /// The side.
        side: String,
        /// Which end, from zero.
        end: usize,
    },
    /// A grouted bar that lies in its bodies at less than two points.
    #[error("it lies in none of its bodies but at its ends: it cannot be grouted")]
    NotWithin,
    /// With axial symmetry.
    #[error("a bar has no meaning with axial symmetry")]
    Axial,
    /// Bodies of different thickness beside a spacing.
    #[error("its bodies differ in thickness: how many bars a spacing makes is not clear")]
    Thickness,
    /// A spacing in space.
    #[error("`spacing` is across a plane model; in space every bar is there by itself")]
    Spacing,
}

fn show(point: &[f64]) -> String {
    let numbers: Vec<String> = point.iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}

impl<const D: usize> Bar<D> {
    /// A bar between two places of some bodies, with a bond, always there, without prestress.
    pub fn new(
        name: &str,
        ends: [BarEnd<D>; 2],
        bodies: &[BodyId],
        [young, area]: [f64; 2],
    ) -> Self {
        Self {
            name: name.to_string(),
            ends,
            bodies: bodies.to_vec(),
            bond: Bond::Ends,
            young,
            area,
            prestress: None,
            spacing: None,
            tension_only: false,
            yields: None,
            radius: None,
            active: Active::ALWAYS,
        }
    }

    /// All bodies that it touches.
    pub fn touched(&self) -> impl Iterator<Item = BodyId> {
        let sides = self.ends.iter().filter_map(|end| match end {
            BarEnd::Side(side) => Some(side.body),
            BarEnd::Point(_) => None,
        });
        let within = self.ends.iter().any(|end| matches!(end, BarEnd::Point(_)));
        let within = within || self.bond == Bond::Grouted;
        let bodies = self.bodies.iter().copied().filter(move |_| within);
        sides.chain(bodies)
    }

    /// The largest force that it bears.
    pub fn strength(&self) -> Option<f64> {
        self.yields.map(|stress| stress * self.area)
    }

    /// Errors: a number out of its range.
    pub(crate) fn check_numbers(&self) -> Result<(), BarError> {
        let positive = |what, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(BarError::Number {
                what,
                value,
                range: "positive",
            }),
        };
        positive("young", self.young)?;
        positive("area", self.area)?;
        let given = [
            ("spacing", self.spacing),
            ("yield", self.yields),
            ("radius", self.radius),
        ];
        for (what, value) in given {
            value.map_or(Ok(()), |value| positive(what, value))?;
        }
        let Some(prestress) = self.prestress else {
            return Ok(());
        };
        let wrong = |range| {
            Err(BarError::Number {
                what: "prestress",
                value: prestress,
                range,
            })
        };
        if !prestress.is_finite() {
            return wrong("a finite number");
        }
        if self.tension_only && prestress < 0.0 {
            return wrong("a tension, as the bar bears no compression");
        }
        match self.strength() {
            Some(most) if prestress.abs() > most => {
                wrong("at most yield times area, else the bar yields while it is tightened")
            }
            _ => Ok(()),
        }
    }
}

/// Forces of a bar.
#[derive(Debug, Clone, PartialEq)]
pub struct BarSolution<const D: usize> {
    /// Its name.
    pub name: String,
    /// From its beginning to its end.
    pub length: f64,
    /// One for each of its elements, in their order.
    pub stations: Vec<BarStation<D>>,
    /// It was tightened in this step.
    pub tightening: bool,
}

/// Force of an element of a bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarStation<const D: usize> {
    /// Length from the beginning of the bar to the middle of the element.
    pub s: f64,
    /// The middle.
    pub point: Point<D>,
    /// Length of the element.
    pub length: f64,
    /// N of one bar, tension positive.
    pub force: f64,
}

impl<const D: usize> BarSolution<D> {
    /// The station with the force of the largest magnitude.
    pub fn largest(&self) -> Option<&BarStation<D>> {
        let mut stations = self.stations.iter();
        let first = stations.next()?;
        Some(stations.fold(first, |best, next| {
            if next.force.abs() > best.force.abs() {
                next
            } else {
                best
            }
        }))
    }
}
