//! Middle lines and cuts of beams, rings, steps, corners and wedges on grids and free meshes, against hand drawings.

use super::*;
use crate::mesh::{CellKind, Contour, Diagonals, Division, Outline, OutlineEdge, Rectangle, Ring};

/// Triangles inside straight edges, each with its name and number of cells.
fn outline(from: Point<2>, edges: &[(Point<2>, &str, usize)]) -> Mesh<2> {
    let edges = edges.iter().map(|&(to, name, cells)| {
        let edge = OutlineEdge::line(to).named(name);
        edge.divided(Division::Cells(cells))
    });
    let edges = edges.collect();
    let outline = Outline::new(Contour::Path { from, edges }, 0.3);
    outline.build().unwrap()
}

fn rectangle(cells: [usize; 2]) -> Mesh<2> {
    let rectangle = Rectangle {
        from: [0.0, 0.0],
        to: [4.0, 0.5],
        cells,
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    };
    rectangle.build().unwrap()
}

fn between<'m>(mesh: &'m Mesh<2>, first: &str, second: &str) -> Result<Strip<'m>, StripError> {
    Strip::between([&[(mesh, first)], &[(mesh, second)]])
}

fn close(a: Point<2>, b: Point<2>, tolerance: f64) {
    assert!(distance(a, b) < tolerance, "{a:?} {b:?}");
}

#[test]
fn cuts_of_a_beam_are_upright_whatever_its_meshes_are() {
    let structured = rectangle([13, 2]);
    let free = outline(
        [0.0, 0.0],
        &[
            ([4.0, 0.0], "bottom", 17),
            ([4.0, 0.5], "right", 2),
            ([0.0, 0.5], "top", 29),
            ([0.0, 0.0], "left", 3),
        ],
    );
    for mesh in [structured, free] {
        let strip = between(&mesh, "top", "bottom").unwrap();
        assert!(!strip.closed() && (strip.length() - 4.0).abs() < 1e-12);
        for x in [0.0, 0.1, 1.37, 2.0, 3.999, 4.0] {
            let cut = strip.at(x);
            close(cut.first, [x, 0.5], 1e-9);
            close(cut.second, [x, 0.0], 1e-9);
            close(cut.along(), [1.0, 0.0], 1e-9);
            assert_eq!(cut.last, x == 4.0);
        }
        // the other way round s runs back
        let back = between(&mesh, "bottom", "top").unwrap();
        close(back.at(1.0).first, [3.0, 0.0], 1e-9);
        close(back.at(1.0).along(), [-1.0, 0.0], 1e-9);
        assert!((strip.nearest([1.2, 0.4]).unwrap().s - 1.2).abs() < 1e-9);
        assert_eq!(strip.nearest([1.2, 0.9]), None);
        assert_eq!(strip.nearest([5.0, 0.25]), None);
    }
}

#[test]
fn cuts_of_a_ring_are_radial_and_begin_at_its_springline() {
    let ring = Ring {
        center: [3.0, -1.0],
        inner: 1.0,
        outer: 1.6,
        angles: None,
        cells: [30, 2],
        ratio: 1.0,
        grade: 1.0,
        cell: CellKind::Quad9,
        diagonals: Diagonals::default(),
    };
    let mesh = ring.build().unwrap();
    for (first, turn) in [("inner", 1.0), ("outer", -1.0_f64)] {
        let other = if first == "inner" { "outer" } else { "inner" };
        let strip = between(&mesh, first, other).unwrap();
        // a polygon of four times as many edges: off by π²/6/120² of the length
        let length = std::f64::consts::TAU * 1.3;
        assert!(strip.closed() && (strip.length() / length - 1.0).abs() < 2e-4);
        for part in [0.0, 0.13, 0.5, 0.77, 1.0] {
            let angle = turn * std::f64::consts::TAU * part;
            let cut = strip.at(part * strip.length());
            let at = |radius: f64| [3.0 + radius * angle.cos(), -1.0 + radius * angle.sin()];
            // parabolas for arcs, and lengths of the polygon for angles
            close(cut.middle(), at(1.3), 1e-3);
            let outward = unit(sub(cut.middle(), [3.0, -1.0])).unwrap();
            let toward = cut.toward_first();
            // within a thousandth, as parabolas run
            assert!((dot(outward, toward) + turn).abs() < 1e-6, "radial");
            assert!((cut.thickness() - 0.6).abs() < 1e-5 && !cut.last);
        }
    }
}

#[test]
fn a_step_is_cut_upright_on_both_of_its_sides() {
    // 0.5 thick up to x = 2, then 0.8: the face of the step belongs to the top
    let mesh = outline(
        [0.0, 0.0],
        &[
            ([4.0, 0.0], "bottom", 23),
            ([4.0, 0.8], "right", 4),
            ([2.0, 0.8], "top", 11),
            ([2.0, 0.5], "top", 2),
            ([0.0, 0.5], "top", 13),
            ([0.0, 0.0], "left", 3),
        ],
    );
    let strip = between(&mesh, "top", "bottom").unwrap();
    // the middle line climbs by half of the step
    assert!((strip.length() - 4.15).abs() < 1e-9);
    for (s, x, h) in [
        (0.7, 0.7, 0.5),
        (1.9, 1.9, 0.5),
        (2.2, 2.05, 0.8),
        (3.0, 2.85, 0.8),
    ] {
        let cut = strip.at(s);
        close(cut.first, [x, h], 1e-6);
        close(cut.second, [x, 0.0], 1e-6);
    }
}

#[test]
fn the_corner_of_a_frame_is_cut_along_its_diagonal() {
    // two legs of 3 and 2.5, 0.4 thick
    let mesh = outline(
        [0.0, 0.0],
        &[
            ([3.0, 0.0], "outer", 17),
            ([3.0, 0.4], "end", 3),
            ([0.4, 0.4], "inner", 13),
            ([0.4, 2.5], "inner", 12),
            ([0.0, 2.5], "start", 3),
            ([0.0, 0.0], "outer", 15),
        ],
    );
    let strip = between(&mesh, "inner", "outer").unwrap();
    // with the inner side on the left s runs down the upright leg, and on along the other
    let (upright, lying) = (2.5 - 0.2, 3.0 - 0.2);
    assert!(
        (strip.length() - upright - lying).abs() < 1e-6,
        "{}",
        strip.length()
    );
    let corner = strip.at(upright);
    close(corner.first, [0.4, 0.4], 1e-6);
    close(corner.second, [0.0, 0.0], 1e-6);
    let cut = strip.at(1.0);
    close(cut.middle(), [0.2, 1.5], 1e-6);
    close(cut.along(), [0.0, -1.0], 1e-6);
    close(strip.at(upright + 1.0).middle(), [1.2, 0.2], 1e-6);
    let named = strip.nearest([0.2, 0.2]).unwrap();
    assert!((named.s - upright).abs() < 1e-6);
}

#[test]
fn a_wedge_is_cut_with_equal_angles_to_both_sides() {
    let mesh = outline(
        [0.0, 0.0],
        &[
            ([5.0, 0.0], "bottom", 25),
            ([5.0, 1.0], "right", 4),
            ([0.0, 0.5], "top", 25),
            ([0.0, 0.0], "left", 3),
        ],
    );
    let strip = between(&mesh, "top", "bottom").unwrap();
    let half = 0.5 * (0.5_f64 / 5.0).atan();
    for x in [1.0, 2.5, 4.2] {
        let cut = strip.at(x);
        let [_, rise] = cut.along();
        assert!((rise - half.sin()).abs() < 1e-3, "{x}: {rise}");
    }
}

#[test]
fn what_is_no_strip_is_said() {
    let mesh = rectangle([8, 2]);
    let error = |a: &str, b: &str| between(&mesh, a, b).unwrap_err();
    assert!(matches!(error("top", "roof"), StripError::Unknown(_)));
    assert!(matches!(error("top", "right"), StripError::Meet(..)));
    assert!(matches!(error("top", "top"), StripError::Meet(..)));
    assert!(matches!(error("left", "right"), StripError::Short { .. }));
}
