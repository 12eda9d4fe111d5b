//! The colour scale of pictures: viridis, perceptually uniform and readable without colour vision.
//!
//! Source: S. van der Walt, N. Smith, viridis (2015), CC0; polynomial fit of degree 6 by M. Zucker.

/// Colours of a picture: index 0 is transparent, 1 to 254 run along the scale.
pub const STEPS: usize = 254;

/// Colour at t in [0, 1], as RGB.
pub fn viridis(t: f64) -> [u8; 3] {
    const C: [[f64; 3]; 7] = [
        [0.2777273272234177, 0.005407344544966578, 0.3340998053353061],
        [0.1050930431085774, 1.404613529898575, 1.384590162594685],
        [-0.3308618287255563, 0.214847559468213, 0.09509516302823659],
        [-4.634230498983486, -5.799100973351585, -19.33244095627987],
        [6.228269936347081, 14.17993336680509, 56.69055260068105],
        [4.776384997670288, -13.74514537774601, -65.35303263337234],
        [-5.435455855934631, 4.645852612178535, 26.3124352495832],
    ];
    let t = t.clamp(0.0, 1.0);
    std::array::from_fn(|c| {
        let value = C.iter().rev().fold(0.0, |sum, row| sum * t + row[c]);
        (value.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}

/// Palette of [`index`].
pub fn palette() -> Vec<[u8; 3]> {
    let step = |i: usize| viridis(i as f64 / (STEPS - 1) as f64);
    std::iter::once([255; 3])
        .chain((0..STEPS).map(step))
        .collect()
}

/// Index into [`palette`] of t in [0, 1].
pub fn index(t: f64) -> u8 {
    1 + (t.clamp(0.0, 1.0) * (STEPS - 1) as f64 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lightness_grows_along_the_scale() {
        // Relative luminance with the weights of sRGB; a scale that is not monotone misleads in grey.
        let light = |t| {
            let [r, g, b] = viridis(t).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for i in 0..50 {
            assert!(light(f64::from(i + 1) / 50.0) > light(f64::from(i) / 50.0));
        }
        // The dark end of viridis, #440154, within the error of the fit.
        assert_eq!(viridis(0.0), [0x47, 0x01, 0x55]);
    }
}
