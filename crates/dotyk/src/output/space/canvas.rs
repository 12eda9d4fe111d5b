//! A picture with depth: triangles and lines, hidden parts removed, smoothed by several samples per pixel.
//!
//! Every sample keeps the nearest surface: it is drawn where its third camera coordinate, towards the viewer, is largest.
//! Within a triangle depth, shade and value are linear. Lines are drawn after all surfaces, into a layer of their own: a
//! sample of a line is seen where no surface is nearer by more than a few pixels, which lets edges lie on their own facets.
//! Invariant: one thread, plain arithmetic, the order of the calls; the same calls give the same bytes.

use crate::output::colour;
use crate::output::encode::png_nearest;
use crate::output::svg::Pixel;

/// Pixels of the picture per pixel of the drawing: crisp in print.
pub const FINE: usize = 2;

/// Samples per pixel of the picture and direction.
const SAMPLES: usize = 2;

/// Colour of places without a value.
pub const NONE: [u8; 3] = [0xc9, 0xce, 0xd3];

/// A corner of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Pixels from the upper left corner, and depth.
    pub at: [f64; 3],
    /// Brightness, at most 1.
    pub shade: f64,
    /// In [0, 1] along the colours; NaN where there is none.
    pub value: f64,
}

/// Paint of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paint {
    /// One colour.
    Plain([u8; 3]),
    /// The colours of the values.
    Scale,
}

/// A kind of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    /// Its colour.
    pub colour: [u8; 3],
    /// Its opacity, at most 1.
    pub cover: f32,
    /// Width in pixels of the drawing.
    pub width: f64,
    /// A line is seen where no surface is nearer by more than this many pixels; `None`: seen through all surfaces.
    pub depth: Option<f64>,
}

/// A picture that grows.
pub struct Canvas {
    width: usize,
    height: usize,
    /// Samples per pixel of the drawing and direction.
    fine: usize,
    depth: Vec<f32>,
    colour: Vec<[u8; 3]>,
    /// One more than the number of the visible body; 0: no body.
    owner: Vec<u16>,
    /// One more than the number of the ink; of several the last counts.
    ink: Vec<u8>,
    inks: Vec<Ink>,
    palette: Vec<[u8; 3]>,
    cut: Option<Cut>,
}

/// A half-space: the places where a·place ≤ b.
pub type Cut = ([f64; 3], f64);

impl Canvas {
    /// An empty picture for a window of this size, in pixels of the drawing.
    pub fn new(size: Pixel, inks: &[Ink]) -> Self {
        Self::sampled(size, FINE * SAMPLES, inks)
    }

    /// The same with this many samples per pixel and direction.
    pub fn sampled(size: Pixel, fine: usize, inks: &[Ink]) -> Self {
        let [width, height] = size.map(|s| s.max(1.0).ceil() as usize * fine);
        let samples = width * height;
        Self {
            width,
            height,
            fine,
            depth: vec![f32::NEG_INFINITY; samples],
            colour: vec![[255; 3]; samples],
            owner: vec![0; samples],
            ink: vec![0; samples],
            inks: inks.to_vec(),
            palette: colour::palette(),
            cut: None,
        }
    }

    /// Clips all further drawing at a plane.
    pub fn cut(&mut self, cut: Option<Cut>) {
        self.cut = cut;
    }

    /// One triangle of a body; its corners in any sense.
    pub fn triangle(&mut self, corners: &[Corner; 3], paint: Paint, owner: usize) {
        let fine = self.fine as f64;
        let [a, b, c] = corners.map(|corner| [corner.at[0] * fine, corner.at[1] * fine]);
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if !(twice.is_finite() && twice.abs() > 1e-9) {
            return;
        }
        let owner = number(owner);
        // of one colour, where it is one
        let shades = corners.map(|corner| corner.shade);
        let flat = match paint {
            Paint::Plain(colour) if shades == [shades[0]; 3] => Some(shaded(colour, shades[0])),
            _ => None,
        };
        let rows = span([a[1], b[1], c[1]], self.height);
        for row in rows {
            let y = row as f64 + 0.5;
            // Weights of the corners are linear along the row: start and slope.
            let weight = |p: Pixel, q: Pixel| {
                let slope = -(q[1] - p[1]) / twice;
                let start = (q[0] - p[0]) * (y - p[1]) / twice + (q[1] - p[1]) * p[0] / twice;
                [start, slope]
            };
            let weights = [weight(b, c), weight(c, a), weight(a, b)];
            let Some((first, last)) = inside(&weights, self.width) else {
                continue;
            };
            let along = |of: &dyn Fn(&Corner) -> f64| {
                [0, 1].map(|k| (0..3).map(|i| weights[i][k] * of(&corners[i])).sum::<f64>())
            };
            let depth = along(&|p| p.at[2]);
            let shade = along(&|p| p.shade);
            let value = along(&|p| p.value);
            let cut = self.cut.map(|cut| along(&|p| excess(Some(cut), p.at)));
            let run = row * self.width + first..=row * self.width + last;
            let depths = self.depth[run.clone()].iter_mut();
            let owners = self.owner[run.clone()].iter_mut();
            let colours = self.colour[run].iter_mut();
            for (k, ((deep, owned), colour)) in depths.zip(owners).zip(colours).enumerate() {
                let x = (first + k) as f64 + 0.5;
                let near = (depth[0] + depth[1] * x) as f32;
                if near <= *deep || cut.is_some_and(|[start, slope]| start + slope * x > 0.0) {
                    continue;
                }
                *deep = near;
                *owned = owner;
                *colour = match (paint, flat) {
                    (Paint::Plain(_), Some(colour)) => colour,
                    (Paint::Plain(colour), None) => shaded(colour, shade[0] + shade[1] * x),
                    (Paint::Scale, _) => {
                        let value = value[0] + value[1] * x;
                        let plain = match value.is_nan() {
                            true => NONE,
                            false => self.palette[usize::from(colour::index(value))],
                        };
                        shaded(plain, shade[0] + shade[1] * x)
                    }
                };
            }
        }
    }

    /// A straight line with one of the inks, between places as [`Corner::at`].
    pub fn line(&mut self, a: [f64; 3], b: [f64; 3], ink: usize) {
        let Some(&Ink { width, depth, .. }) = self.inks.get(ink) else {
            return;
        };
        let fine = self.fine as f64;
        let beyond = [a, b].map(|p| excess(self.cut, p));
        let [a, b] = match beyond {
            [s, t] if s > 0.0 && t > 0.0 => return,
            [s, t] if s > 0.0 => [between(a, b, s / (s - t)), b],
            [s, t] if t > 0.0 => [a, between(a, b, s / (s - t))],
            _ => [a, b],
        };
        let [a, b] = [a, b].map(|p| [p[0] * fine, p[1] * fine, p[2]]);
        if !a.iter().chain(&b).all(|c| c.is_finite()) {
            return;
        }
        let steep = (b[1] - a[1]).abs() > (b[0] - a[0]).abs();
        // (along, across): columns and rows, or the other way round
        let (u, v) = if steep { (1, 0) } else { (0, 1) };
        let (a, b) = if a[u] <= b[u] { (a, b) } else { (b, a) };
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let run = b[u] - a[u];
        let half = 0.5 * width * fine;
        let reach = match run > 0.0 {
            true => half * length / run,
            false => half,
        };
        let [most_u, most_v] = match steep {
            true => [self.height, self.width],
            false => [self.width, self.height],
        };
        for i in span([a[u] - 0.5 * half, b[u] + 0.5 * half, a[u]], most_u) {
            let t = match run > 0.0 {
                true => ((i as f64 + 0.5 - a[u]) / run).clamp(0.0, 1.0),
                false => 0.5,
            };
            let centre = a[v] + t * (b[v] - a[v]);
            let near = a[2] + t * (b[2] - a[2]);
            let from = (centre - reach - 0.5).ceil().max(0.0) as usize;
            for j in from..most_v {
                if j as f64 + 0.5 > centre + reach {
                    break;
                }
                let sample = match steep {
                    true => i * self.width + j,
                    false => j * self.width + i,
                };
                let seen = depth.is_none_or(|room| near + room >= f64::from(self.depth[sample]));
                if seen {
                    self.ink[sample] = self.ink[sample].max(ink as u8 + 1);
                }
            }
        }
    }

    fn sample(&self, at: Pixel) -> Option<usize> {
        let [x, y] = at.map(|c| (c * self.fine as f64).floor());
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then(|| y as usize * self.width + x as usize)
    }

    /// Whether a place is visible: no surface is nearer by more than `room` pixels.
    pub fn sees(&self, place: [f64; 3], room: f64) -> bool {
        let sample = self.sample([place[0], place[1]]);
        sample.is_some_and(|s| f64::from(self.depth[s]) <= place[2] + room)
    }

    /// How many square pixels of the drawing a body shows, and their centre.
    pub fn shown(&self, owner: usize) -> (f64, Pixel) {
        let (mut count, mut sum) = (0.0, [0.0, 0.0]);
        for (row, samples) in self.owner.chunks(self.width).enumerate() {
            for (column, _) in samples
                .iter()
                .enumerate()
                .filter(|(_, o)| **o == number(owner))
            {
                count += 1.0;
                sum[0] += column as f64 + 0.5;
                sum[1] += row as f64 + 0.5;
            }
        }
        let fine = self.fine as f64;
        (count / (fine * fine), sum.map(|s| s / (count * fine)))
    }

    /// Whether a body is seen at a place.
    pub fn shows(&self, owner: usize, at: Pixel) -> bool {
        self.sample(at)
            .is_some_and(|s| self.owner[s] == number(owner))
    }

    /// Sum of the red parts of all covered samples, in [0, 1] each.
    pub fn redness(&self) -> f64 {
        let seen = self.colour.iter().zip(&self.owner);
        let red = seen.filter(|(_, owner)| **owner > 0);
        red.map(|(c, _)| f64::from(c[0]) / 255.0).sum()
    }

    /// Width, height and pixels: the means of their samples.
    pub fn pixels(&self, samples: usize) -> (usize, usize, Vec<[u8; 3]>) {
        let (width, height) = (self.width / samples, self.height / samples);
        let mut out = Vec::with_capacity(width * height);
        let share = 1.0 / (samples * samples) as f32;
        for row in 0..height {
            for column in 0..width {
                let first = row * samples * self.width + column * samples;
                let rows = || (0..samples).map(|i| first + i * self.width);
                let plain = rows().all(|at| self.ink[at..at + samples].iter().all(|&ink| ink == 0));
                let one = self.colour[first];
                let alike = |at: usize| self.colour[at..at + samples].iter().all(|&c| c == one);
                // most pixels
                if plain && rows().all(alike) {
                    out.push(one);
                    continue;
                }
                let mut sum = [0.0f32; 3];
                for sample in rows().flat_map(|at| at..at + samples) {
                    let sample = self.inked(sample);
                    (0..3).for_each(|c| sum[c] += sample[c]);
                }
                out.push(sum.map(|s| (s * share + 0.5) as u8));
            }
        }
        (width, height, out)
    }

    fn inked(&self, sample: usize) -> [f32; 3] {
        let base = self.colour[sample].map(f32::from);
        match self.ink[sample] {
            0 => base,
            ink => {
                let Ink { colour, cover, .. } = self.inks[usize::from(ink) - 1];
                [0, 1, 2].map(|c| base[c] + cover * (f32::from(colour[c]) - base[c]))
            }
        }
    }

    /// The picture as a PNG file.
    pub fn png(&self) -> Vec<u8> {
        let (width, height, pixels) = self.pixels(SAMPLES);
        png_nearest(width, height, &pixels)
    }
}

/// A colour at a brightness.
fn shaded(colour: [u8; 3], shade: f64) -> [u8; 3] {
    let shade = shade.clamp(0.0, 1.0) as f32;
    colour.map(|c| (f32::from(c) * shade + 0.5) as u8)
}

/// Number of a body in [`Canvas::owner`]; the last one for all beyond.
fn number(owner: usize) -> u16 {
    u16::try_from(owner + 1).unwrap_or(u16::MAX)
}

/// How far a place lies beyond a plane.
fn excess(cut: Option<Cut>, at: [f64; 3]) -> f64 {
    cut.map_or(-1.0, |(a, b)| (0..3).map(|i| a[i] * at[i]).sum::<f64>() - b)
}

/// a + t (b − a).
pub fn between(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + t * (b[i] - a[i]))
}

/// The samples between the smallest and the largest of three coordinates.
fn span(v: [f64; 3], size: usize) -> std::ops::Range<usize> {
    let low = (v[0].min(v[1]).min(v[2]) - 0.5).ceil().max(0.0);
    let high = (v[0].max(v[1]).max(v[2]) + 0.5).floor().min(size as f64);
    low as usize..high.max(0.0) as usize
}

/// First and last sample of a row where no weight is negative; a hair of overlap leaves no seams between neighbours.
fn inside(weights: &[[f64; 2]; 3], width: usize) -> Option<(usize, usize)> {
    const HAIR: f64 = -1e-9;
    let (mut low, mut high) = (0.5, width as f64 - 0.5);
    for &[start, slope] in weights {
        let root = (HAIR - start) / slope;
        match slope {
            s if s > 0.0 => low = f64::max(low, root),
            s if s < 0.0 => high = f64::min(high, root),
            _ if start < HAIR => return None,
            _ => {}
        }
    }
    let (first, last) = ((low - 0.5).ceil(), (high - 0.5).floor());
    (first <= last).then_some((first as usize, last as usize))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Ink = Ink {
        colour: [0; 3],
        cover: 1.0,
        width: 2.0,
        depth: Some(0.5),
    };

    fn flat(points: [[f64; 2]; 3], depth: f64, value: f64) -> [Corner; 3] {
        points.map(|[x, y]| Corner {
            at: [x, y, depth],
            shade: 1.0,
            value,
        })
    }

    #[test]
    fn the_nearer_triangle_is_seen_whatever_the_order() {
        let left = [[0.0, 0.0], [20.0, 0.0], [0.0, 20.0]];
        let near = (flat(left, 2.0, 0.0), Paint::Plain([255, 0, 0]), 0);
        let far = (flat(left, 1.0, 0.0), Paint::Plain([0, 0, 255]), 1);
        for order in [[&near, &far], [&far, &near]] {
            let mut canvas = Canvas::sampled([20.0, 20.0], 1, &[]);
            for (corners, paint, owner) in order {
                canvas.triangle(corners, *paint, *owner);
            }
            assert_eq!(canvas.pixels(1).2[0], [255, 0, 0]);
            assert!(canvas.shows(0, [3.0, 3.0]) && !canvas.shows(1, [3.0, 3.0]));
        }
    }

    #[test]
    fn triangles_cover_their_area_and_neighbours_leave_no_seam() {
        // A fan around a point that lies on no sample, over a square.
        let (middle, rim) = (
            [7.3, 11.9],
            [[1.0, 1.0], [19.0, 1.0], [19.0, 19.0], [1.0, 19.0]],
        );
        let mut canvas = Canvas::sampled([20.0, 20.0], 3, &[]);
        for i in 0..4 {
            let corners = flat([middle, rim[i], rim[(i + 1) % 4]], 0.0, 0.0);
            canvas.triangle(&corners, Paint::Plain([0; 3]), 0);
        }
        let (area, centre) = canvas.shown(0);
        assert_eq!(area, 18.0 * 18.0);
        assert!((centre[0] - 10.0).abs() < 1e-12 && (centre[1] - 10.0).abs() < 1e-12);
    }

    #[test]
    fn values_are_linear_and_what_has_none_is_grey() {
        let mut canvas = Canvas::sampled([100.0, 10.0], 1, &[]);
        let corner = |x: f64, y: f64| Corner {
            at: [x, y, 0.0],
            shade: 1.0,
            value: x / 100.0,
        };
        let rim = [
            corner(0.0, 0.0),
            corner(100.0, 0.0),
            corner(100.0, 10.0),
            corner(0.0, 10.0),
        ];
        canvas.triangle(&[rim[0], rim[1], rim[2]], Paint::Scale, 0);
        canvas.triangle(&[rim[0], rim[2], rim[3]], Paint::Scale, 0);
        let pixels = canvas.pixels(1).2;
        for column in [3, 40, 77, 99] {
            let expected =
                colour::palette()[usize::from(colour::index((column as f64 + 0.5) / 100.0))];
            assert_eq!(pixels[500 + column], expected);
        }
        let mut blank = rim;
        blank.iter_mut().for_each(|c| {
            c.value = f64::NAN;
            c.at[2] = 1.0;
        });
        canvas.triangle(&[blank[0], blank[1], blank[2]], Paint::Scale, 0);
        assert_eq!(canvas.pixels(1).2[90], NONE);
    }

    #[test]
    fn lines_hide_behind_surfaces_and_show_on_them() {
        let all = [[0.0, 0.0], [40.0, 0.0], [0.0, 40.0]];
        let dark = |depth: f64| {
            let mut canvas = Canvas::sampled([20.0, 20.0], 1, &[BLACK]);
            canvas.triangle(&flat(all, 5.0, 0.0), Paint::Plain([255; 3]), 0);
            canvas.line([2.0, 8.0, depth], [18.0, 11.0, depth], 0);
            let pixels = canvas.pixels(1).2;
            pixels.iter().filter(|p| p[0] == 0).count()
        };
        assert_eq!(dark(4.0), 0);
        // on the surface: as long as the line, as wide as the ink
        assert!((28..=38).contains(&dark(5.0)), "{}", dark(5.0));
        assert_eq!(dark(5.0), dark(9.0));
    }
}
