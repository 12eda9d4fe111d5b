//! Section forces N, V, M of rings, walls, slabs and beams: on cuts across a body with two long sides, by equilibrium. Several bodies
//! may stand side by side between the two sides (the segments of a ring), or lie one upon the other (the shells of a lining): the
//! forces are those of all bodies that a cut divides, about its middle.
//!
//! With the resultant F of all forces on the part ahead of a cut and their moment m about its middle (`fem/cut.rs`), the
//! direction t of s and the direction e from the second side to the first, which is on the left of s:
//!
//! ```text
//!   N = F·t      V = −F·e      M = −m
//! ```
//!
//! N > 0 is tension, V > 0 pushes the part ahead towards the first side, M > 0 is tension on the first side. In the plane they
//! are per unit of thickness, with axial symmetry (meridional forces) per unit of circumference at the middle of the cut; there
//! ∫σ_θ dy and ∫σ_θ y dy of the recovered hoop stress, y from the middle to the first side, are given, too.
//!
//! In space the bodies are extruded along an axis a = t × e, and all are per unit of length along it: the mean over the length, about
//! the middle of the cut,
//!
//! ```text
//!   N = F·t/L     V = −F·e/L     V2 = −F·a/L     M = −m·a/L     M2 = m·e/L     T = m·t/L
//! ```
//!
//! or their distribution along it, n(z), v(z), .. at some places, moments about the middle line there.
//! V2 > 0 pushes the part ahead along the axis, M2 > 0 is tension at its end, T > 0 turns the part behind about s.

use crate::geometry::Point;
use crate::mesh::{ExtrudedError, StripError};
use crate::model::nouns::capacity::Capacity;
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::ids::{BodyId, SideRef};
use std::borrow::Cow;

/// One or several bodies with the cuts at which their section forces are found.
#[derive(Debug, Clone, PartialEq)]
pub struct Section<const D: usize> {
    /// Unique name.
    pub name: String,
    /// The bodies, each once.
    pub bodies: Vec<BodyId>,
    /// The two long sides, each a path along sides of these bodies; s runs with the first on its left.
    pub sides: [Vec<SideRef>; 2],
    /// Where they are cut.
    pub stations: Stations<D>,
    /// In space: the direction of extrusion, a unit vector; found where the long sides are not plane.
    pub axis: Option<Point<D>>,
    /// In space: at how many equally spaced places along the axis, both ends included, forces are told; 1 tells their mean.
    pub places: usize,
    /// Its capacity.
    pub capacity: Option<Capacity>,
}

/// Where a body is cut.
#[derive(Debug, Clone, PartialEq)]
pub enum Stations<const D: usize> {
    /// This number of stations at equal distances along the middle line, both ends included.
    Number(usize),
    /// At the places of the middle line nearest to these points, in their order.
    Points(Vec<Point<D>>),
}

/// Why a section cannot be cut.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SectionError {
    /// In space.
    #[error(transparent)]
    Extruded(#[from] ExtrudedError),
    /// In the plane.
    #[error("`axis` and `places` are those of sections in space")]
    Plane,
    /// No place.
    #[error("forces are told at one place along the axis at least")]
    NoPlace,
    /// The sides.
    #[error(transparent)]
    Sides(#[from] StripError),
    /// Less than two.
    #[error("a number of stations is at least 2, both ends included")]
    TooFew,
    /// No body, or one twice.
    #[error("a section has at least one body, and each once")]
    Bodies,
    /// A long side along none of the bodies, or along another body.
    #[error("the {} of its long sides runs along no body of the section", ["first", "second"][*.0])]
    Beside(usize),
    /// Bodies of different thicknesses.
    #[error("its bodies have different thicknesses, {} and {}: section forces are per unit of thickness", .0[0], .0[1])]
    Thicknesses([f64; 2]),
    /// A point that lies on no cut.
    #[error("station {} at ({}) lies beside the body", .index + 1, .point.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))]
    Off {
        /// From zero.
        index: usize,
        /// The point.
        point: Vec<f64>,
    },
    /// A cut that ends within the body.
    #[error("the cut of station {} ends within the body, at ({:.4}, {:.4}): its line goes on through it there", .index + 1, .at[0], .at[1])]
    NotThrough {
        /// From zero.
        index: usize,
        /// The end.
        at: [f64; 2],
    },
    /// A bar outside of the section.
    #[error("bars at the depth {depth} lie outside of the section, which is {thickness:.4e} thick at ({:.4}, {:.4})", .at[0], .at[1])]
    Depth {
        /// From zero.
        layer: usize,
        /// Their depth.
        depth: f64,
        /// Thickness of the section.
        thickness: f64,
        /// Where it is that thin.
        at: [f64; 2],
    },
}

/// Forces of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionSolution {
    /// Its name.
    pub name: String,
    /// Length of the middle line.
    pub length: f64,
    /// It goes all around; the last station may be the first.
    pub closed: bool,
    /// In space: the extrusion.
    pub extrusion: Option<Extrusion>,
    /// In their order; in space all of them once for each place along the axis.
    pub stations: Vec<Station>,
}

/// The extrusion of the bodies of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct Extrusion {
    /// Its direction.
    pub axis: [f64; 3],
    /// How long it is; forces are per unit of it.
    pub length: f64,
    /// Number of places along it; 1: the mean.
    pub places: usize,
    /// With several places, the means of all cuts.
    pub means: Vec<Station>,
}

/// Forces on one cut; not a number where no body is there yet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Length of the middle line up to it.
    pub s: f64,
    /// Middle of the cut, in the plane of the cuts.
    pub point: [f64; 2],
    /// Unit vector from the second side to the first, in the plane of the cuts.
    pub toward_first: [f64; 2],
    /// Length of the cut.
    pub thickness: f64,
    /// N, tension positive.
    pub normal: f64,
    /// V, positive where it pushes the part ahead towards the first side.
    pub shear: f64,
    /// M, positive with tension on the first side.
    pub moment: f64,
    /// With axial symmetry: normal force and moment around the axis.
    pub hoop: Option<[f64; 2]>,
    /// In space.
    pub across: Option<Across>,
    /// With a capacity: 1 is the limit.
    pub utilisation: Option<f64>,
}

/// What a cut in space has besides N, V and M.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Across {
    /// Its middle.
    pub point: [f64; 3],
    /// Its place along the axis, from the end of the bodies.
    pub along: f64,
    /// V2, positive where it pushes the part ahead along the axis.
    pub shear: f64,
    /// M2, positive with tension at the end to which the axis points; of a cut as a whole.
    pub moment: Option<f64>,
    /// T, right-handed about s on the part behind.
    pub twist: f64,
}

impl Station {
    /// The middle of the cut; the third coordinate is zero in the plane.
    pub fn place(&self) -> [f64; 3] {
        let [x, y] = self.point;
        self.across.map_or([x, y, 0.0], |across| across.point)
    }

    /// The coordinates of the middle of the cut, two in the plane, three in space.
    pub fn coordinates(&self) -> Vec<f64> {
        match self.across {
            Some(across) => across.point.to_vec(),
            None => self.point.to_vec(),
        }
    }

    /// Direction of s in degrees from +x, in (−180, 180].
    pub fn angle(&self) -> f64 {
        let [x, y] = self.toward_first;
        // zero is no −0, else a direction along −x would be −180
        (-x + 0.0).atan2(y + 0.0).to_degrees()
    }

    /// N/h + 6M/h² on the first side and N/h − 6M/h² on the second.
    pub fn edge_stress(&self) -> [f64; 2] {
        let (mean, bending) = (
            self.normal / self.thickness,
            6.0 * self.moment / self.thickness.powi(2),
        );
        [mean + bending, mean - bending]
    }
}

/// A quantity at a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SectionQuantity {
    /// N.
    Normal,
    /// V.
    Shear,
    /// M.
    Moment,
    /// V2, in space.
    AxialShear,
    /// M2, in space.
    AxialMoment,
    /// T, in space.
    Twist,
    /// Where there is a capacity.
    Utilisation,
}

impl SectionQuantity {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Normal,
        Self::Shear,
        Self::Moment,
        Self::AxialShear,
        Self::AxialMoment,
        Self::Twist,
        Self::Utilisation,
    ];

    /// Its name in quantities and result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "N",
            Self::Shear => "V",
            Self::Moment => "M",
            Self::AxialShear => "V2",
            Self::AxialMoment => "M2",
            Self::Twist => "T",
            Self::Utilisation => "utilisation",
        }
    }

    /// It is one of those in space alone.
    pub fn is_across(self) -> bool {
        matches!(self, Self::AxialShear | Self::AxialMoment | Self::Twist)
    }

    /// Its dimension.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Normal | Self::Shear | Self::AxialShear => Dimension::ForcePerLength,
            Self::Moment | Self::AxialMoment | Self::Twist => Dimension::MomentPerLength,
            Self::Utilisation => Dimension::Ratio,
        }
    }

    /// Its value at a station; NaN where it has none.
    pub fn at(self, station: &Station) -> f64 {
        let across = |value: fn(&Across) -> f64| station.across.as_ref().map_or(f64::NAN, value);
        match self {
            Self::Normal => station.normal,
            Self::Shear => station.shear,
            Self::Moment => station.moment,
            Self::AxialShear => across(|own| own.shear),
            Self::AxialMoment => across(|own| own.moment.unwrap_or(f64::NAN)),
            Self::Twist => across(|own| own.twist),
            Self::Utilisation => station.utilisation.unwrap_or(f64::NAN),
        }
    }
}

impl SectionSolution {
    /// The stations that are there, by their number from zero: those at which a body is present.
    pub fn known(&self) -> impl Iterator<Item = (usize, &Station)> {
        let all = self.stations.iter().enumerate();
        all.filter(|(_, station)| !station.normal.is_nan())
    }

    /// Number of places along the axis.
    pub fn places(&self) -> usize {
        self.extrusion.as_ref().map_or(1, |own| own.places)
    }

    /// The part of the length along the axis that belongs to a place: the trapezoidal rule.
    pub fn share(&self, place: usize) -> f64 {
        match self.places() {
            1 => 1.0,
            places if place == 0 || place + 1 == places => 0.5 / (places - 1) as f64,
            places => 1.0 / (places - 1) as f64,
        }
    }

    /// Its means along the axis, with the largest utilisation; itself where they are told already.
    pub fn mean(&self) -> Cow<'_, Self> {
        let Some(extrusion) = self.extrusion.as_ref().filter(|own| own.places > 1) else {
            return Cow::Borrowed(self);
        };
        let count = extrusion.means.len();
        let means = extrusion.means.iter().enumerate().map(|(k, mean)| {
            let used = self.stations.iter().skip(k).step_by(count.max(1));
            let used = used.filter_map(|station| station.utilisation);
            Station {
                utilisation: used.reduce(f64::max),
                ..*mean
            }
        });
        Cow::Owned(Self {
            name: self.name.clone(),
            length: self.length,
            closed: self.closed,
            extrusion: Some(Extrusion {
                places: 1,
                means: Vec::new(),
                ..extrusion.clone()
            }),
            stations: means.collect(),
        })
    }

    /// Station (from zero) and value of the smallest and the largest; `None` without values.
    pub fn extremes(&self, quantity: SectionQuantity) -> Option<[(usize, f64); 2]> {
        let values = self
            .stations
            .iter()
            .map(|station| quantity.at(station))
            .enumerate();
        let values = values.filter(|(_, value)| !value.is_nan());
        // of equal ones the first
        let least = values
            .clone()
            .reduce(|best, next| if next.1 < best.1 { next } else { best })?;
        let most = values.reduce(|best, next| if next.1 > best.1 { next } else { best })?;
        Some([least, most])
    }
}
