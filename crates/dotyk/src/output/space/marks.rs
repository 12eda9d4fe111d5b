//! Symbols of supports and loads on surfaces in space, and labels that keep clear of each other.
//!
//! Symbols are drawn at visible points of the facets of their side, a fixed distance apart on paper, along their directions in
//! space, with the foreshortening of the camera.

use crate::geometry::{Point, add_scaled, dot, norm, unit};
use crate::mesh::{Facet, Mesh};
use crate::model::Support;
use crate::output::space::camera::{Window, faces};
use crate::output::space::canvas::Canvas;
use crate::output::space::skin::Lattices;
use crate::output::svg::{LOAD, Pixel, SUPPORT, Svg, Type, segments, text_width};
use crate::output::view::Box2;
use std::collections::BTreeMap;

/// Longest load arrow, where it is seen from its side.
const ARROW: f64 = 32.0;

/// From one symbol to the next on paper.
const SPACING: f64 = 27.0;

/// A symbol shortened to less than this part points at the viewer.
const END_ON: f64 = 0.3;

/// A point of a surface with its outward unit normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Undeformed position.
    pub point: Point<3>,
    /// Outward unit normal.
    pub normal: Point<3>,
}

/// Points of facets that are seen, at equal distances on paper.
pub fn seen(mesh: &Mesh<3>, facets: &[Facet], window: &Window, canvas: &Canvas) -> Vec<Mark> {
    let mut squares = Squares::new(SPACING);
    let mut lattices = Lattices::default();
    for &facet in facets {
        let kind = mesh.facet_kind(facet);
        let size = mesh.facet_length(facet) * window.scale;
        let parts = ((size / (0.5 * SPACING)).ceil() as usize).clamp(1, 24);
        let lattice = lattices.of(kind, parts);
        for triangle in &lattice.triangles {
            let xi = [0, 1, 2].map(|d| {
                let corners = triangle.iter().map(|&i| lattice.points[i][d]);
                corners.sum::<f64>() / 3.0
            });
            let point = mesh.facet_point(facet, &xi);
            let Some(normal) = unit(mesh.outward_normal(facet, &xi)) else {
                continue;
            };
            let place = window.place(point);
            if !(faces(&window.camera, normal) && canvas.sees(place, 1.5)) {
                continue;
            }
            squares.offer([place[0], place[1]], Mark { point, normal });
        }
    }
    squares.into_list()
}

/// Things on paper about a fixed distance apart: of those in one square of a grid the one that is nearest to its middle.
pub struct Squares<T> {
    size: f64,
    /// By row and column, with its distance from the middle in squares.
    best: BTreeMap<(i64, i64), (f64, T)>,
}

impl<T> Squares<T> {
    /// A grid of squares of this size.
    pub fn new(size: f64) -> Self {
        let best = BTreeMap::new();
        Self { size, best }
    }

    /// A thing at a place.
    pub fn offer(&mut self, place: Pixel, thing: T) {
        let square = place.map(|p| (p / self.size).floor());
        let off = [0, 1].map(|d| place[d] / self.size - square[d] - 0.5);
        let far = off[0].hypot(off[1]);
        let key = (square[1] as i64, square[0] as i64);
        if self.best.get(&key).is_none_or(|old| far < old.0) {
            self.best.insert(key, (far, thing));
        }
    }

    /// Those that are left, row by row.
    pub fn into_list(self) -> Vec<T> {
        self.best.into_values().map(|(_, thing)| thing).collect()
    }
}

/// Unit directions in which a support holds a point with this outward normal, towards the outside.
pub fn held(support: &Support<3>, normal: Point<3>) -> Vec<Point<3>> {
    let axis = |i: usize| {
        let mut d = [0.0; 3];
        d[i] = if normal[i] < -1e-9 { -1.0 } else { 1.0 };
        d
    };
    let axes = (0..3).filter(|&i| support.components[i].is_some());
    let mut list: Vec<Point<3>> = axes.map(axis).collect();
    if support.normal.is_some() && list.len() < 3 {
        list.push(normal);
    }
    list
}

/// The symbol of held directions at a pixel: a cone for each, whose tip is the point held; a clamp where there are three.
pub fn hold(svg: &mut Svg, window: &Window, at: Pixel, directions: &[Point<3>], normal: Point<3>) {
    if directions.len() >= 3 {
        let out = window.camera.turned(normal);
        let n = unit([out[0], -out[1]]).unwrap_or([0.0, 1.0]);
        cone(svg, at, n, SUPPORT);
        let t = [-n[1], n[0]];
        let side = |s: f64| [0, 1].map(|i| at[i] + 8.0 * n[i] + s * t[i]);
        svg.line(side(-6.5), side(6.5), SUPPORT, 1.6);
        return;
    }
    for &direction in directions {
        let [x, y, _] = window.camera.turned(direction);
        let short = x.hypot(y);
        if short < END_ON {
            svg.circle(at, 3.4, SUPPORT, "white", "");
            svg.circle(at, 1.0, SUPPORT, SUPPORT, "");
            continue;
        }
        let length = short.max(0.6);
        cone(svg, at, [x / short * length, -y / short * length], "white");
    }
}

fn cone(svg: &mut Svg, at: Pixel, d: Pixel, fill: &str) {
    let n = unit(d).unwrap_or([0.0, 1.0]);
    let base = |s: f64| {
        let t = [-n[1], n[0]];
        [0, 1].map(|i| at[i] + 8.0 * d[i] + s * t[i])
    };
    let path = segments(&[at, base(-4.0), base(4.0)], true);
    svg.path(&path, SUPPORT, 1.0, fill, "stroke-linejoin=\"round\"");
}

/// An arrow of a load of this size, at most 1, on a point of a surface; returns its ends, the outer one last.
pub fn push(
    svg: &mut Svg,
    window: &Window,
    mark: &Mark,
    load: Point<3>,
    size: f64,
) -> Option<[Pixel; 2]> {
    let direction = unit(load)?;
    let [x, y, _] = window.camera.turned(direction);
    let length = ARROW * size;
    let step = [length * x, -length * y];
    let at = window.pixel(mark.point);
    if x.hypot(y) < END_ON {
        end_on(svg, at, dot(window.camera.towards, direction) > 0.0);
        return Some([at; 2]);
    }
    let along = dot(direction, mark.normal);
    let (tail, tip) = match along {
        a if a < -0.15 => ([0, 1].map(|i| at[i] - step[i]), at),
        a if a > 0.15 => (at, [0, 1].map(|i| at[i] + step[i])),
        // along the surface: in its middle
        _ => (
            [0, 1].map(|i| at[i] - 0.4 * step[i]),
            [0, 1].map(|i| at[i] + 0.4 * step[i]),
        ),
    };
    svg.arrow(tail, tip, LOAD, 1.3);
    Some(if along < -0.15 {
        [tip, tail]
    } else {
        [tail, tip]
    })
}

/// An arrow that points at the viewer, or away from him.
pub fn end_on(svg: &mut Svg, at: Pixel, towards: bool) {
    svg.circle(at, 4.0, LOAD, "white", "");
    if towards {
        svg.circle(at, 1.2, LOAD, LOAD, "");
    } else {
        for d in [[2.6, 2.6], [2.6, -2.6]] {
            let ends = [-1.0, 1.0].map(|s| [at[0] + s * d[0], at[1] + s * d[1]]);
            svg.line(ends[0], ends[1], LOAD, 1.0);
        }
    }
}

/// The arrow of a force at a point, with its ends, the outer one last.
pub fn force(
    svg: &mut Svg,
    window: &Window,
    point: Point<3>,
    force: Point<3>,
) -> Option<[Pixel; 2]> {
    let direction = unit(force).filter(|_| norm(force).is_finite())?;
    let [x, y, _] = window.camera.turned(direction);
    let tip = window.pixel(point);
    if x.hypot(y) < END_ON {
        end_on(svg, tip, dot(window.camera.towards, direction) > 0.0);
        return Some([tip; 2]);
    }
    let tail = add_scaled(tip, -1.2 * ARROW, [x, -y]);
    svg.arrow(tail, tip, LOAD, 2.0);
    Some([tip, tail])
}

/// Where labels are.
#[derive(Default)]
pub struct Labelled {
    taken: Vec<Box2>,
    /// Where symbols are: labels keep clear of them where there is room elsewhere.
    symbols: Vec<Box2>,
}

impl Labelled {
    /// Keeps labels off the line between two places, if possible.
    pub fn keep(&mut self, [a, b]: [Pixel; 2]) {
        const ROOM: f64 = 4.0;
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let parts = (length / ROOM).ceil().max(1.0);
        let at = |k: usize| [0, 1].map(|d| a[d] + k as f64 / parts * (b[d] - a[d]));
        let boxes = (0..=parts as usize).map(|k| around(at(k), [ROOM; 2]));
        self.symbols.extend(boxes);
    }

    /// A label near a place, inside the window, clear of those before, and of symbols if that is possible; `false` where there
    /// is no room.
    pub fn put(
        &mut self,
        svg: &mut Svg,
        window: &Window,
        at: Pixel,
        text: &str,
        style: Type,
    ) -> bool {
        let half = [0.5 * text_width(text, style.size) + 3.0, 0.62 * style.size];
        let free = |place: &Pixel, symbols: &[Box2]| {
            let own = around(*place, half);
            let apart =
                |other: &Box2| (0..2).any(|i| own.0[i] >= other.1[i] || own.1[i] <= other.0[i]);
            let inside = window.sees(own.0, 1.0) && window.sees(own.1, 1.0);
            inside && self.taken.iter().chain(symbols).all(apart)
        };
        let rows = [0.0, -10.0, 10.0, -20.0, 20.0, -30.0, 30.0];
        let aside = [8.0, 34.0].map(|room| half[0] + room);
        let columns = [0.0, aside[0], -aside[0], aside[1], -aside[1]];
        let places = columns
            .iter()
            .flat_map(|x| rows.iter().map(move |y| [at[0] + x, at[1] + y]));
        let places: Vec<Pixel> = places.collect();
        let mut tried = [&self.symbols[..], &[]].into_iter();
        let found = tried.find_map(|symbols| places.iter().find(|place| free(place, symbols)));
        let Some(&place) = found else {
            return false;
        };
        self.taken.push(around(place, half));
        svg.text([place[0], place[1] + 0.35 * style.size], text, style);
        true
    }
}

fn around(at: Pixel, half: Pixel) -> Box2 {
    (
        [0, 1].map(|i| at[i] - half[i]),
        [0, 1].map(|i| at[i] + half[i]),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::space::camera::Camera;

    /// Pixels of the labels that an SVG element holds.
    fn written(svg: Svg) -> Vec<Pixel> {
        let page = svg.finish();
        let number = |tag: &str, name: &str| -> f64 {
            let rest = tag.split(&format!(" {name}=\"")).nth(1).unwrap();
            rest.split('"').next().unwrap().parse().unwrap()
        };
        let tags = page.split("<text").skip(1);
        tags.map(|tag| [number(tag, "x"), number(tag, "y")])
            .collect()
    }

    #[test]
    fn labels_keep_clear_of_each_other_and_of_arrows_where_there_is_room() {
        let camera = Camera::from([0.0, -1.0, 0.0]);
        let size = [400.0, 300.0];
        let window = Window::fitted(camera, ([0.0; 2], [1.0; 2]), [0.0; 2], size, 0.0);
        let labels = |arrows: &[[Pixel; 2]]| {
            let mut svg = Svg::new("labels", "", 400.0, 300.0);
            let mut labelled = Labelled::default();
            arrows.iter().for_each(|ends| labelled.keep(*ends));
            let place = [200.0, 150.0];
            let mut put = || labelled.put(&mut svg, &window, place, "20 N", Type::LABEL);
            assert!((0..4).all(|_| put()));
            written(svg)
        };
        let apart = |list: &[Pixel]| {
            list.iter().enumerate().all(|(i, a)| {
                let far = |b: &Pixel| (a[0] - b[0]).abs() > 25.0 || (a[1] - b[1]).abs() > 13.0;
                list[i + 1..].iter().all(far)
            })
        };
        let plain = labels(&[]);
        assert!(apart(&plain) && (plain[0][0] - 200.0).abs() < 1.0);
        // one arrow from top to bottom through the place: all stand beside it
        let beside = labels(&[[[200.0, 20.0], [200.0, 280.0]]]);
        assert!(apart(&beside) && beside.iter().all(|p| (p[0] - 200.0).abs() > 15.0));
        // arrows everywhere: they stand on them, apart
        let rows: Vec<[Pixel; 2]> = (0..38)
            .map(|k| f64::from(k) * 8.0)
            .map(|y| [[0.0, y], [400.0, y]])
            .collect();
        assert!(apart(&labels(&rows)));
    }
}
