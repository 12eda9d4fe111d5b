//! Space: rigid motions, patches, rates and contacts of boxes of tetrahedra and hexahedra.
//!
//! Tolerances are rounding unless they say otherwise.

use dotyk::fem::{Analysis, assemble, describe_motion};
use dotyk::geometry::{Point, norm};
use dotyk::mesh::{CellKind, Cuboid, Mesh};
use dotyk::model::{Elastic, Model};

const CELLS: [CellKind; 2] = [CellKind::Tet4, CellKind::Hex8];

const SOFT: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};

/// A box with corners at the origin and at `to`, its inner nodes moved.
fn distorted(to: Point<3>, cells: [usize; 3], cell: CellKind) -> Mesh<3> {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to,
        cells,
        cell,
    };
    let place = |x: Point<3>| {
        let inside: f64 = (0..3).map(|d| x[d] * (to[d] - x[d])).product();
        let wave = [x[1] - x[2], 0.7 * x[2] + x[0], 0.9 - x[0] * x[1]];
        std::array::from_fn(|d| x[d] + 0.5 * inside * wave[d])
    };
    cuboid.build().unwrap().map_points(place).unwrap()
}

#[test]
fn a_free_box_has_six_rigid_motions_that_strain_nothing() {
    for cell in CELLS {
        let mut model = Model::<3>::new();
        let mesh = distorted([1.0, 1.2, 0.8], [3, 3, 3], cell);
        model.body("body", mesh, SOFT);
        let system = assemble(&model.bodies[0], Analysis::Solid, 1.0).unwrap();
        assert_eq!(system.modes.len(), 6, "{cell:?}");
        let largest = system.stiffness.diagonal().into_iter().fold(0.0, f64::max);
        for mode in &system.modes {
            let mut force = vec![0.0; mode.len()];
            system.stiffness.mul(mode, &mut force);
            let worst = force.iter().fold(0.0, |s: f64, f| s.max(f.abs()));
            assert!(worst < 1e-13 * largest, "{cell:?} {worst:e}");
        }
        let points = model.bodies[0].mesh.points();
        let words = |motion: &dyn Fn(Point<3>) -> Point<3>| {
            let motion: Vec<Point<3>> = points.iter().map(|&x| motion(x)).collect();
            describe_motion(points, &motion)
        };
        assert_eq!(words(&|_| [0.0, 2.0, 0.0]), "translation along y");
        assert_eq!(
            words(&|[x, y, _]| [-y, x, 0.0]),
            "rotation about z through (0, 0, 0.4)"
        );
        assert_eq!(
            words(&|[x, y, _]| [-y, x, 1.0]),
            "screw about z through (0, 0, 0.4)"
        );
        assert!(
            system
                .modes
                .iter()
                .all(|mode| mode.len() == 3 * points.len())
        );
        let longest = |mode: &Vec<f64>| {
            mode.chunks(3)
                .map(|u| norm([u[0], u[1], u[2]]))
                .fold(0.0, f64::max)
        };
        assert!(
            system
                .modes
                .iter()
                .all(|mode| (longest(mode) - 1.0).abs() < 1e-14)
        );
    }
}
