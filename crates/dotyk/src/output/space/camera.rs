//! Projection of space onto paper: parallel projection along a direction, and the window that shows it.
//!
//! Camera coordinates of a point p are (right·q, up·q, towards·q) with q = scale (p − centre): right-handed, in pixels, the
//! third one grows towards the viewer. Pixels have y downward: (x, y) = middle + (right·q, −up·q).
//! The projection is linear, so that values can be interpolated between pixels as between points.

use crate::geometry::{Point, cross, dot, sub, unit};
use crate::output::svg::Pixel;

/// An orthonormal frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// To the right on paper.
    pub right: Point<3>,
    /// Up on paper.
    pub up: Point<3>,
    /// From the model to the viewer.
    pub towards: Point<3>,
}

impl Camera {
    /// Looks from this direction at the model, z upward; along z, y is upward.
    pub fn from(direction: Point<3>) -> Self {
        let towards = unit(direction).unwrap_or([0.0, -1.0, 0.0]);
        let vertical = match towards[2].abs() > 0.999 {
            true => [0.0, 1.0, 0.0],
            false => [0.0, 0.0, 1.0],
        };
        let right = unit(cross(vertical, towards)).unwrap_or([1.0, 0.0, 0.0]);
        Self {
            right,
            up: cross(towards, right),
            towards,
        }
    }

    /// The same picture from a place turned about z by an azimuth in degrees, 0 at −y and 90 at +x, and lifted by an
    /// elevation.
    pub fn around(azimuth: f64, elevation: f64) -> Self {
        let (s, c) = azimuth.to_radians().sin_cos();
        let (lift, level) = elevation.to_radians().sin_cos();
        Self::from([s * level, -c * level, lift])
    }

    /// From the opposite side.
    pub fn opposite(&self) -> Self {
        Self::from(self.towards.map(|c| -c))
    }

    /// A direction or a difference of points in camera coordinates.
    pub fn turned(&self, v: Point<3>) -> Point<3> {
        [dot(self.right, v), dot(self.up, v), dot(self.towards, v)]
    }

    /// Lower and upper corner on paper of points, in units of length.
    pub fn extent(&self, points: impl Iterator<Item = Point<3>>) -> (Pixel, Pixel) {
        points.fold(
            ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]),
            |(low, high), p| {
                let [x, y, _] = self.turned(p);
                (
                    [low[0].min(x), low[1].min(y)],
                    [high[0].max(x), high[1].max(y)],
                )
            },
        )
    }
}

/// A rectangle of a drawing through which a camera looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Upper left corner in the drawing.
    pub corner: Pixel,
    /// Size in pixels.
    pub size: Pixel,
    /// The camera.
    pub camera: Camera,
    /// The point in the middle of the window, in camera directions and units of length.
    pub centre: Pixel,
    /// Pixel of that point in the drawing.
    pub middle: Pixel,
    /// Pixels per unit of length.
    pub scale: f64,
    /// The bodies continue beyond the frame.
    pub filled: bool,
}

impl Window {
    /// Shows an extent as large as the window allows, this many pixels kept free on all sides.
    pub fn fitted(
        camera: Camera,
        (low, high): (Pixel, Pixel),
        corner: Pixel,
        size: Pixel,
        margin: f64,
    ) -> Self {
        let fit = |i: usize| (size[i] - 2.0 * margin).max(1.0) / (high[i] - low[i]);
        let scale = fit(0).min(fit(1));
        Self {
            corner,
            size,
            camera,
            centre: [0, 1].map(|i| 0.5 * (low[i] + high[i])),
            middle: [0, 1].map(|i| corner[i] + 0.5 * size[i]),
            scale: if scale.is_finite() { scale } else { 1.0 },
            filled: false,
        }
    }

    /// Camera coordinates in pixels, from the upper left corner of the window, y downward and the third towards the viewer.
    pub fn place(&self, point: Point<3>) -> Point<3> {
        let [x, y, z] = self.camera.turned(point);
        [
            self.middle[0] - self.corner[0] + self.scale * (x - self.centre[0]),
            self.middle[1] - self.corner[1] - self.scale * (y - self.centre[1]),
            self.scale * z,
        ]
    }

    /// Pixel of a point in the drawing.
    pub fn pixel(&self, point: Point<3>) -> Pixel {
        let [x, y, _] = self.place(point);
        [self.corner[0] + x, self.corner[1] + y]
    }

    /// A pixel of the drawing lies inside the window, this far from its frame.
    pub fn sees(&self, p: Pixel, room: f64) -> bool {
        (0..2)
            .all(|i| p[i] >= self.corner[i] + room && p[i] <= self.corner[i] + self.size[i] - room)
    }
}

/// Whether a facet with this outward normal at a point looks at the viewer.
pub fn faces(camera: &Camera, normal: Point<3>) -> bool {
    dot(camera.towards, normal) > 0.0
}

/// Distance of a point from a plane through `on`, positive on the side of its normal.
pub fn beyond(point: Point<3>, (on, normal): (Point<3>, Point<3>)) -> f64 {
    dot(sub(point, on), normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::norm;

    /// The corners of a box.
    fn corners((low, high): (Point<3>, Point<3>)) -> impl Iterator<Item = Point<3>> {
        (0..8).map(move |k| [0, 1, 2].map(|i| if k >> i & 1 == 0 { low[i] } else { high[i] }))
    }

    #[test]
    fn from_the_front_x_is_right_and_z_is_up() {
        let camera = Camera::from([0.0, -2.0, 0.0]);
        assert_eq!(camera.right, [1.0, 0.0, 0.0]);
        assert_eq!(camera.up, [0.0, 0.0, 1.0]);
        let above = Camera::from([0.0, 0.0, 3.0]);
        assert_eq!((above.right, above.up), ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for azimuth in [-170.0, -40.0, 0.0, 33.0, 120.0] {
            for elevation in [-60.0, 0.0, 25.0, 89.0] {
                let c = Camera::around(azimuth, elevation);
                let wrong = sub(cross(c.right, c.up), c.towards);
                assert!(norm(wrong) < 1e-15 && dot(c.right, c.up).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_fitted_window_shows_its_extent() {
        let camera = Camera::around(30.0, 25.0);
        let cube = || corners(([0.0; 3], [2.0, 1.0, 1.0]));
        let window = Window::fitted(
            camera,
            camera.extent(cube()),
            [10.0, 20.0],
            [300.0, 200.0],
            12.0,
        );
        for corner in cube() {
            assert!(window.sees(window.pixel(corner), 12.0 - 1e-9));
        }
    }
}
