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

use crate::geometry::Point;
use crate::mesh::StripError;
use crate::model::nouns::capacity::Capacity;
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::ids::{BodyId, SideRef};

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
    #[error("section forces in space are not supported yet")]
    Space,
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
    #[error("station {} at ({}, {}) lies beside the body", .index + 1, .point[0], .point[1])]
    Off {
        /// From zero.
        index: usize,
        /// The point.
        point: [f64; 2],
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
    /// In their order.
    pub stations: Vec<Station>,
}

/// Forces on one cut; not a number where no body is there yet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Length of the middle line up to it.
    pub s: f64,
    /// Middle of the cut.
    pub point: [f64; 2],
    /// Unit vector from the second side to the first.
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
    /// With a capacity: 1 is the limit.
    pub utilisation: Option<f64>,
}

impl Station {
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
    /// Where there is a capacity.
    Utilisation,
}

impl SectionQuantity {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Normal, Self::Shear, Self::Moment, Self::Utilisation];

    /// Its name in quantities and result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "N",
            Self::Shear => "V",
            Self::Moment => "M",
            Self::Utilisation => "utilisation",
        }
    }

    /// Its dimension.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Normal | Self::Shear => Dimension::ForcePerLength,
            Self::Moment => Dimension::MomentPerLength,
            Self::Utilisation => Dimension::Ratio,
        }
    }

    /// Its value at a station; NaN without a capacity.
    pub fn at(self, station: &Station) -> f64 {
        match self {
            Self::Normal => station.normal,
            Self::Shear => station.shear,
            Self::Moment => station.moment,
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
