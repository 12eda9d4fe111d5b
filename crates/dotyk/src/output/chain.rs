//! Points along a contact of the plane: tangent, arc length, angle.

use crate::geometry::{Point, distance, dot, sub};

/// The contact tangent in 2D: the normal rotated by +90°.
pub fn tangent(normal: Point<2>) -> Point<2> {
    [-normal[1], normal[0]]
}

/// Component of a vector along the contact tangent of the plane.
pub fn along_tangent<const D: usize>(vector: Point<D>, normal: Point<D>) -> f64 {
    dot([vector[0], vector[1]], tangent([normal[0], normal[1]]))
}

/// Length of the way to each of these points, (n,).
pub fn arc_lengths<const D: usize>(points: &[Point<D>]) -> Vec<f64> {
    let mut arc = 0.0;
    (0..points.len())
        .map(|i| {
            if i > 0 {
                arc += distance(points[i - 1], points[i]);
            }
            arc
        })
        .collect()
}

/// Angles of points about the centre of their common circle, in degrees from +x, without jumps; `None` if they do not lie on a
/// circle.
pub fn angles(points: &[Point<2>]) -> Option<Vec<f64>> {
    let (center, _) = circle_through(points)?;
    let mut before = f64::NAN;
    let each = points.iter().map(|&p| {
        let [x, y] = sub(p, center);
        let mut angle = y.atan2(x).to_degrees();
        if before.is_finite() {
            angle += 360.0 * ((before - angle) / 360.0).round();
        }
        before = angle;
        angle
    });
    Some(each.collect())
}

/// A circle through points (centre, radius), if they lie on a circle within half a per cent.
///
/// Source: algebraic least-squares fit, I. Kåsa, IEEE Trans. Instrum. Meas. 25 (1976), as described in textbooks.
fn circle_through(points: &[Point<2>]) -> Option<(Point<2>, f64)> {
    let count = points.len() as f64;
    if points.len() < 4 {
        return None;
    }
    let mean = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / count);
    let (mut xx, mut xy, mut yy, mut xr, mut yr) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut spread = 0.0;
    for p in points {
        let [x, y] = sub(*p, mean);
        let r = x * x + y * y;
        xx += x * x;
        xy += x * y;
        yy += y * y;
        xr += x * r;
        yr += y * r;
        spread += r;
    }
    let det = xx * yy - xy * xy;
    if det <= 1e-6 * spread * spread {
        return None;
    }
    let center = [
        0.5 * (xr * yy - yr * xy) / det,
        0.5 * (yr * xx - xr * xy) / det,
    ];
    let radius = (spread / count + center[0] * center[0] + center[1] * center[1]).sqrt();
    let center = [center[0] + mean[0], center[1] + mean[1]];
    let off = points.iter().map(|&p| (distance(p, center) - radius).abs());
    (off.fold(0.0, f64::max) < 0.005 * radius).then_some((center, radius))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_run_on_past_half_a_turn() {
        let points: Vec<Point<2>> = (0..=8)
            .map(|i| f64::from(i) * 45f64.to_radians())
            .map(|t: f64| [t.cos(), t.sin()])
            .collect();
        let list = angles(&points).unwrap();
        assert!((list[8] - 360.0).abs() < 1e-9 && (list[5] - 225.0).abs() < 1e-9);
    }

    #[test]
    fn circles_are_recognised_and_lines_are_not() {
        let arc: Vec<Point<2>> = (0..9)
            .map(|i| f64::from(i) * 0.2)
            .map(|t: f64| [1.0 + 3.0 * t.cos(), 3.0 * t.sin()])
            .collect();
        let (center, radius) = circle_through(&arc).unwrap();
        assert!(distance(center, [1.0, 0.0]) < 1e-12 && (radius - 3.0).abs() < 1e-12);
        let line: Vec<Point<2>> = (0..9).map(|i| [f64::from(i), 2.0]).collect();
        assert_eq!(circle_through(&line), None);
    }
}
