//! Boxes between rigid walls: sizes and coefficients of friction at random, no box held by a support.
//!
//! Walls between boxes are planes at random places, so that nodes match.

use crate::{Failure, SOLID, told};
use dotyk::geometry::Field;
use dotyk::mesh::{CellKind, Cuboid};
use dotyk::model::{BodyId, Gap, Law, Model};

/// Sides of a box behind and before the neighbour along each axis.
const SIDES: [[&str; 2]; 3] = [["left", "right"], ["front", "back"], ["bottom", "top"]];

/// Pseudo-random numbers in [0, 1), the same in every run.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Packs `row`³ boxes of `cells`³ hexahedra under their own weight.
pub fn solve(row: usize, cells: usize) -> Result<(), Failure> {
    let mut noise = Noise(0x9E37_79B9_7F4A_7C15);
    let mut planes: [Vec<f64>; 3] = Default::default();
    for planes in &mut planes {
        planes.push(0.0);
        for _ in 0..row {
            planes.push(planes.last().unwrap_or(&0.0) + 0.5 + noise.next());
        }
    }
    let mut model = Model::<3>::new();
    let place = |i: [usize; 3]| (i[2] * row + i[1]) * row + i[0];
    let all = (0..row.pow(3)).map(|k| [k % row, k / row % row, k / row / row]);
    for i in all.clone() {
        let corner = |end: usize| std::array::from_fn(|d| planes[d][i[d] + end]);
        let cuboid = Cuboid {
            from: corner(0),
            to: corner(1),
            cells: [cells; 3],
            cell: CellKind::Hex8,
        };
        let body = model.body(&format!("box_{}", place(i) + 1), cuboid.build()?, SOLID);
        model.bodies[body.0].body_force = [0.0, 0.0, -1.0].map(Field::constant);
    }
    for i in all {
        for (axis, [behind, before]) in SIDES.into_iter().enumerate() {
            let body = BodyId(place(i));
            let friction = Law::Coulomb(Field::constant(0.1 + 0.5 * noise.next()));
            if i[axis] == 0 {
                model.obstacle((body, behind), Field::constant(0.0)).law = friction.clone();
            }
            let contact = match i[axis] + 1 < row {
                true => {
                    let mut next = i;
                    next[axis] += 1;
                    let contact = model.contact((body, before), (BodyId(place(next)), behind));
                    contact.gap = Some(Gap::Closed);
                    contact
                }
                false => model.obstacle((body, before), Field::constant(0.0)),
            };
            contact.law = friction;
        }
    }
    let solution = model.solve()?;
    told(&format!("{} boxes", row.pow(3)), &solution);
    Ok(())
}
