//! Reference points of sides: a couple makes a side and a point move together, so that loads and supports of the point act on the
//! side.

use crate::fem::error::{FemError, show};
use crate::fem::nouns::{Analysis, Body};
use crate::fem::sides::side_nodes;
use crate::fem::supports::finite;
use crate::geometry::{Field, Point, distance};

/// How a side and its reference point move together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoupleKind {
    /// The side moves with the point as a rigid body does. With axial symmetry it keeps its radii and moves along the axis.
    Rigid,
    /// The point has the mean motion of the side, the rigid one that is nearest to it in the least-squares sense; a force at
    /// the point is the traction that varies linearly over the side and has the same resultant and moment. The side may strain.
    Average,
}

impl CoupleKind {
    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Average => "average",
        }
    }
}

/// A side and its reference point, which need not lie on the mesh. Rotations and moments are about x, y and z; in the plane
/// only those about z count, and with axial symmetry the point only moves along the axis.
#[derive(Debug, Clone)]
pub struct Couple<const D: usize> {
    /// Name of the point, unique among the couples of a body.
    pub name: String,
    /// Its position.
    pub point: Point<D>,
    /// The side that moves with it.
    pub side: String,
    /// How.
    pub kind: CoupleKind,
    /// Prescribed displacement of the point along each axis; `None` is free.
    pub displacement: [Option<Field>; D],
    /// Prescribed rotation in radians; `None` is free.
    pub rotation: [Option<Field>; 3],
    /// Force at the point; with axial symmetry that of the full turn.
    pub force: [Field; D],
    /// Moment at the point.
    pub moment: [Field; 3],
}

/// Load and held components of a point at a time: first along the axes, then for its rotations, as lengths and forces at the end
/// of an arm.
pub(crate) struct Drive<const D: usize> {
    pub load: [Point<D>; 2],
    pub held: [[Option<f64>; D]; 2],
}

impl<const D: usize> Couple<D> {
    /// A free point without a load, which moves with its side.
    pub fn new(name: &str, point: Point<D>, side: &str, kind: CoupleKind) -> Self {
        let zero = |_| Field::constant(0.0);
        Self {
            name: name.to_string(),
            point,
            side: side.to_string(),
            kind,
            displacement: std::array::from_fn(|_| None),
            rotation: [None, None, None],
            force: std::array::from_fn(zero),
            moment: std::array::from_fn(zero),
        }
    }

    /// The axes, of x, y and z, about which a point turns.
    pub(crate) fn turns(analysis: Analysis) -> std::ops::Range<usize> {
        match analysis {
            Analysis::Axisymmetric => 0..0,
            Analysis::Solid => 0..3,
            Analysis::PlaneStrain | Analysis::PlaneStress => 2..3,
        }
    }

    /// Distance of the farthest node of the side: rotations times it are lengths, moments over it are forces.
    ///
    /// Errors: an unknown or empty side; a point that is not finite.
    pub(crate) fn arm(&self, body: &Body<D>) -> Result<f64, FemError> {
        let nodes = side_nodes(&body.mesh, &self.side)?;
        let distances = nodes
            .iter()
            .map(|&node| distance(body.mesh.points()[node], self.point));
        // a NaN is not smaller
        let arm = distances.fold(0.0, |arm: f64, d| if d <= arm { arm } else { d });
        match arm.is_finite() {
            true => Ok(arm),
            false => Err(FemError::NotFinite {
                what: "point".to_string(),
                text: self.name.clone(),
                point: show(self.point),
            }),
        }
    }

    /// Its loads and prescribed values at a time.
    ///
    /// Errors: a value that is not finite; with axial symmetry a rotation, a moment, or anything along the radius but zero.
    pub(crate) fn drive(
        &self,
        analysis: Analysis,
        arm: f64,
        time: f64,
    ) -> Result<Drive<D>, FemError> {
        let value = |field: &Field, what: &str| {
            let what = || format!("{what} of point \"{}\"", self.name);
            finite(field, self.point, time, what)
        };
        let mut drive = Drive {
            load: [[0.0; D]; 2],
            held: [[None; D], [Some(0.0); D]],
        };
        for axis in 0..D {
            drive.load[0][axis] = value(&self.force[axis], "force")?;
            let given = self.displacement[axis].as_ref();
            drive.held[0][axis] = given.map(|f| value(f, "displacement")).transpose()?;
        }
        for axis in 0..3 {
            let moment = value(&self.moment[axis], "moment")?;
            let given = self.rotation[axis].as_ref();
            let rotation = given.map(|f| value(f, "rotation")).transpose()?;
            match Self::turns(analysis).position(|turn| turn == axis) {
                Some(place) => {
                    drive.load[1][place] = moment / arm;
                    drive.held[1][place] = rotation.map(|angle| angle * arm);
                }
                None if analysis == Analysis::Axisymmetric
                    && (rotation.is_some() || moment != 0.0) =>
                {
                    return Err(self.not_axial("a rotation or moment"));
                }
                None => {}
            }
        }
        if analysis == Analysis::Axisymmetric {
            let held = drive.held[0][0].replace(0.0);
            if drive.load[0][0] != 0.0 || held.is_some_and(|u| u != 0.0) {
                return Err(self.not_axial("a displacement or force along the radius"));
            }
        }
        Ok(drive)
    }

    fn not_axial(&self, what: &'static str) -> FemError {
        FemError::NotAxial {
            name: self.name.clone(),
            what,
        }
    }
}
