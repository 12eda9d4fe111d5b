//! From the user's outline to curves: checked, closed, disjoint, each with the body on its left.

use crate::geometry::{Point, add_scaled, bounding_box, distance, sub, unit};
use crate::mesh::outline::curve::{Curve, cross};
use crate::mesh::outline::divide::{Rib, WIDEST_PIECE};
use crate::mesh::outline::nouns::{
    Contour, Division, EdgeShape, MOST_VERTICES, Outline, OutlineEdge, OutlinePart, OutlinePlace,
};
use crate::mesh::outline::wishes::Wishes;
use crate::mesh::{CellKind, MeshError, SizePoint};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Two points nearer than this share of the diameter coincide.
pub(crate) const SAME: f64 = 1e-9;

/// Largest relative difference of the two radii of an arc given by its centre.
const SAME_RADIUS: f64 = 1e-6;

/// Magnitudes of coordinates and diameters whose squares are finite and not zero.
const MAGNITUDES: [f64; 2] = [1e-100, 1e100];

/// A curve of a contour, before the meeting points are known.
#[derive(Clone)]
pub(crate) struct Drawn {
    pub curve: Curve,
    pub place: OutlinePlace,
    pub names: Vec<String>,
    pub division: Option<Division>,
}

/// All curves of all contours, each contour with the body on the left.
pub(crate) struct Curves {
    pub ribs: Vec<Rib>,
    pub places: Vec<OutlinePlace>,
    /// Name of the side of each.
    pub sides: Vec<Vec<String>>,
    /// Of the outer path less the holes.
    pub area: f64,
}

impl Curves {
    /// The contours of an outline as curves, checked and turned.
    pub fn of(outline: &Outline, wishes: &Wishes<'_>) -> Result<Self, MeshError> {
        check_values(outline.size, outline.growth, &outline.refine, outline.cell)?;
        let contours = std::iter::once((OutlinePart::Outer, &outline.boundary));
        let contours = contours.chain((0..).map(OutlinePart::Hole).zip(&outline.holes));
        let mut paths = Vec::new();
        for (part, contour) in contours {
            paths.push(contour.curves(part)?);
        }
        let (low, diameter) = extent(paths.iter().flatten())?;
        for drawn in paths.iter().flatten() {
            check_division(outline.size, drawn, diameter)?;
        }
        let paths = paths.into_iter();
        let paths: Vec<_> = paths.map(|p| wishes.cut(p, SAME * diameter)).collect();
        separate(&paths, diameter)?;
        let mut curves = Self {
            ribs: Vec::new(),
            places: Vec::new(),
            sides: Vec::new(),
            area: 0.0,
        };
        for (index, path) in paths.iter().enumerate() {
            let twice: f64 = path.iter().map(|d| d.curve.twice_area(low)).sum();
            let area = 0.5 * twice.abs();
            if area <= SAME * diameter * diameter {
                return Err(contour_place(path).error("it encloses no area"));
            }
            curves.area += if index == 0 { area } else { -area };
            curves.add_path(path, (twice > 0.0) != (index == 0), outline.size);
        }
        nested(&paths)?;
        Ok(curves)
    }

    /// Adds the curves of a contour, in the opposite direction with `turn`.
    fn add_path(&mut self, path: &[Drawn], turn: bool, largest: f64) {
        // The corner of a path where its k-th edge begins has the number of that edge.
        let first = self.ribs.len();
        let count = path.len();
        for k in 0..count {
            let drawn = &path[if turn { count - 1 - k } else { k }];
            let (size, pieces) = wanted(drawn.division, largest);
            self.ribs.push(Rib {
                curve: match turn {
                    true => drawn.curve.reversed(),
                    false => drawn.curve,
                },
                size,
                pieces,
                widest: WIDEST_PIECE,
                ends: [first + k, first + (k + 1) % count],
                faces: [Some(0), None],
            });
            let without = || match drawn.place.part {
                OutlinePart::Hole(hole) => format!("hole_{}", hole + 1),
                _ => "outline".to_string(),
            };
            self.sides.push(match &drawn.names[..] {
                [] => vec![without()],
                names => names.to_vec(),
            });
            self.places.push(drawn.place.clone());
        }
    }
}

/// Lower corner and diagonal of the box around some curves.
///
/// Errors: a diagonal whose square is not finite.
pub(crate) fn extent<'d>(
    drawn: impl Iterator<Item = &'d Drawn> + Clone,
) -> Result<(Point<2>, f64), MeshError> {
    let corners = drawn.clone();
    let corners = corners.flat_map(|drawn| <[Point<2>; 2]>::from(drawn.curve.bounds()));
    let (low, high) = bounding_box(&corners.collect::<Vec<_>>());
    let diameter = distance(low, high);
    if (MAGNITUDES[0]..MAGNITUDES[1]).contains(&diameter) {
        return Ok((low, diameter));
    }
    let place = drawn.map(|drawn| drawn.place.whole()).next();
    let problem = format!("the outline is {diameter} across: use other units");
    Err(place.unwrap_or_default().error(problem))
}

/// Size and number of pieces of a division.
pub(crate) fn wanted(division: Option<Division>, largest: f64) -> (f64, Option<usize>) {
    match division {
        Some(Division::Size(size)) => (size, None),
        Some(Division::Cells(cells)) => (largest, Some(cells)),
        None => (largest, None),
    }
}

pub(crate) fn check_values(
    size: f64,
    growth: f64,
    refine: &[SizePoint],
    cell: CellKind,
) -> Result<(), MeshError> {
    let wrong = |key, value: String, need| MeshError::Parameter {
        generator: "outline",
        key,
        value,
        need,
    };
    if !matches!(cell, CellKind::Tri3 | CellKind::Tri6) {
        let need = "an outline is filled with `tri3` or `tri6`";
        return Err(wrong("cell", cell.name().to_string(), need));
    }
    if !(size > 0.0 && size.is_finite()) {
        let need = "must be positive and finite";
        return Err(wrong("size", size.to_string(), need));
    }
    if !(growth > 0.0 && growth <= 1.0) {
        let need = "must be positive and at most 1: 0.3 lets neighbours differ by a third";
        return Err(wrong("growth", growth.to_string(), need));
    }
    let mut points = refine.iter();
    points.try_for_each(|point| point.check("outline", "refine"))
}

pub(crate) fn check_division(largest: f64, drawn: &Drawn, diameter: f64) -> Result<(), MeshError> {
    let size = match drawn.division {
        Some(Division::Size(size)) => size,
        None => largest,
        Some(Division::Cells(cells)) => {
            let sweep = drawn.curve.arc.map_or(0.0, |arc| arc.sweep.abs());
            if cells == 0 || cells > MOST_VERTICES {
                let problem = format!("it cannot have {cells} cells");
                return Err(drawn.place.error(problem));
            }
            // A quarter of a circle may have one cell, whatever rounding says.
            if sweep > FRAC_PI_2 * (cells as f64 + SAME) {
                let problem = format!(
                    "with {cells} cells, one spans {:.0} degrees: use more, at most 90 degrees each",
                    (sweep / cells as f64).to_degrees()
                );
                return Err(drawn.place.error(problem));
            }
            return Ok(());
        }
    };
    if !(size > 0.0 && size.is_finite()) {
        let problem = format!("the size {size} must be positive and finite");
        return Err(drawn.place.error(problem));
    }
    let whole = match drawn.place.part {
        OutlinePart::Line(_) => "drawing",
        _ => "outline",
    };
    if size > largest {
        let problem = format!(
            "the size {size} exceeds that of the whole {whole}, {}: leave it out or make it smaller",
            largest
        );
        return Err(drawn.place.error(problem));
    }
    if size > diameter {
        let problem = format!(
            "the size {size} exceeds the whole {whole}, which is {diameter} across: check the units"
        );
        return Err(drawn.place.error(problem));
    }
    Ok(())
}

impl Contour {
    /// The curves in the order of the user. The path of an outline closes, a line of a drawing need not.
    pub(crate) fn curves(&self, part: OutlinePart) -> Result<Vec<Drawn>, MeshError> {
        match self {
            Self::Path { from, edges } => path_curves(*from, edges, part),
            Self::Circle {
                center,
                radius,
                names,
                division,
            } => {
                let place = OutlinePlace {
                    part,
                    edge: None,
                    names: names.clone(),
                };
                check_points(&place, center)?;
                if !(*radius > 0.0 && *radius < MAGNITUDES[1]) {
                    let problem = format!("the radius {radius} must be positive and finite");
                    return Err(place.error(problem));
                }
                let quarter = match division {
                    Some(Division::Cells(cells)) if !cells.is_multiple_of(4) => {
                        let problem = format!(
                            "{cells} cells: a circle has a multiple of four, so that its outermost points are nodes"
                        );
                        return Err(place.error(problem));
                    }
                    Some(Division::Cells(cells)) => Some(Division::Cells(cells / 4)),
                    other => *other,
                };
                let quarters = Curve::quarters(*center, *radius).map(|curve| Drawn {
                    curve,
                    place: place.clone(),
                    names: names.clone(),
                    division: quarter,
                });
                Ok(quarters.into())
            }
        }
    }
}

fn path_curves(
    from: Point<2>,
    edges: &[OutlineEdge],
    part: OutlinePart,
) -> Result<Vec<Drawn>, MeshError> {
    let place = |edge: usize| OutlinePlace {
        part,
        edge: Some(edge),
        names: edges.get(edge).map_or(Vec::new(), |e| e.names.clone()),
    };
    let whole = OutlinePlace {
        part,
        ..OutlinePlace::default()
    };
    check_points(&whole, &from)?;
    for (index, edge) in edges.iter().enumerate() {
        check_points(&place(index), &edge.to)?;
    }
    let ends: Vec<Point<2>> = edges.iter().map(|edge| edge.to).chain([from]).collect();
    let (low, high) = bounding_box(&ends);
    let diameter = distance(low, high);
    let Some(last) = edges.last() else {
        return Err(whole.error("it has no edges"));
    };
    let closed = distance(last.to, from) <= SAME * diameter;
    if !closed && !matches!(part, OutlinePart::Line(_)) {
        let problem = format!(
            "it ends at {:?}, but the path begins at {from:?}: let the last edge end there",
            last.to
        );
        return Err(place(edges.len() - 1).error(problem));
    }
    let mut start = from;
    let mut curves = Vec::with_capacity(edges.len());
    for (index, edge) in edges.iter().enumerate() {
        // To the bit, so that the last node is the first.
        let end = if closed && index + 1 == edges.len() {
            from
        } else {
            edge.to
        };
        let place = place(index);
        if distance(start, end) <= SAME * diameter {
            let problem = format!(
                "it begins and ends at {end:?}: remove it, or use `circle` for a whole circle"
            );
            return Err(place.error(problem));
        }
        curves.push(Drawn {
            curve: shaped(start, end, edge.shape, &place)?,
            place,
            names: edge.names.clone(),
            division: edge.division,
        });
        start = end;
    }
    Ok(curves)
}

fn check_points(place: &OutlinePlace, point: &Point<2>) -> Result<(), MeshError> {
    // Squares of what passes are numbers.
    if point.iter().all(|c| c.abs() < MAGNITUDES[1]) {
        return Ok(());
    }
    Err(place.error(format!("the coordinates {point:?} are not finite")))
}

/// The curve of an edge.
fn shaped(
    start: Point<2>,
    end: Point<2>,
    shape: EdgeShape,
    place: &OutlinePlace,
) -> Result<Curve, MeshError> {
    let chord = sub(end, start);
    let length = distance(start, end);
    match shape {
        EdgeShape::Line => Ok(Curve::line(start, end)),
        EdgeShape::Center { center, clockwise } => {
            check_points(place, &center)?;
            let radii = [distance(start, center), distance(end, center)];
            let [least, most] = [radii[0].min(radii[1]), radii[0].max(radii[1])];
            if most - least > SAME_RADIUS * most || 2.0 * most < length {
                return Err(place.error(format!(
                    "its start is {} away from the center {center:?} and its end {}: they must be equal; correct one of them, or give `radius` or `via` instead",
                    radii[0], radii[1]
                )));
            }
            Ok(Curve::arc(start, end, center, clockwise))
        }
        EdgeShape::Via(via) => {
            check_points(place, &via)?;
            let side = cross(chord, sub(via, start));
            // The height of the arc over its chord: below this the arc is a line but for rounding.
            if side.abs() <= SAME * length * (length + distance(start, via)) {
                return Err(place.error(format!(
                    "the point {via:?} of `via` lies on the line through both ends: leave it out, or choose a point on the arc"
                )));
            }
            let (u, v) = (sub(via, start), chord);
            let (uu, vv) = (u[0] * u[0] + u[1] * u[1], v[0] * v[0] + v[1] * v[1]);
            let twice = 2.0 * cross(u, v);
            let center = [
                start[0] + (v[1] * uu - u[1] * vv) / twice,
                start[1] + (u[0] * vv - v[0] * uu) / twice,
            ];
            Ok(Curve::arc(start, end, center, side > 0.0))
        }
        EdgeShape::Radius { radius, clockwise } => {
            if !(radius > 0.0 && radius < MAGNITUDES[1]) {
                return Err(place.error(format!("the radius {radius} must be positive and finite")));
            }
            if length > 2.0 * radius * (1.0 + SAME) {
                return Err(place.error(format!(
                    "its ends are {length} apart, more than twice the radius {radius}: use a larger radius"
                )));
            }
            let height = (radius * radius - 0.25 * length * length).max(0.0).sqrt();
            let [x, y] = unit(chord).unwrap_or([0.0; 2]);
            let middle = add_scaled(start, 0.5, chord);
            let left = if clockwise { [y, -x] } else { [-y, x] };
            let center = add_scaled(middle, height, left);
            Ok(Curve::arc(start, end, center, clockwise))
        }
    }
}

fn contour_place(path: &[Drawn]) -> OutlinePlace {
    OutlinePlace {
        part: path.first().map_or(OutlinePart::Outer, |d| d.place.part),
        ..OutlinePlace::default()
    }
}

/// Refuses curves that cross or touch elsewhere than at their common corners.
fn separate(paths: &[Vec<Drawn>], diameter: f64) -> Result<(), MeshError> {
    // Path, place in the path, curve, box.
    let all: Vec<(usize, usize, &Drawn)> = paths
        .iter()
        .enumerate()
        .flat_map(|(p, path)| path.iter().enumerate().map(move |(k, drawn)| (p, k, drawn)))
        .collect();
    let boxes: Vec<_> = all.iter().map(|(_, _, d)| d.curve.bounds()).collect();
    let near = SAME * diameter;
    for (i, &(path, k, a)) in all.iter().enumerate() {
        for (j, &(other, l, b)) in all.iter().enumerate().skip(i + 1) {
            let apart = |d: usize| {
                boxes[i].1[d] + near < boxes[j].0[d] || boxes[j].1[d] + near < boxes[i].0[d]
            };
            if apart(0) || apart(1) {
                continue;
            }
            let count = paths[path].len();
            let mut corners = Vec::new();
            if path == other && (k + 1) % count == l {
                corners.push(a.curve.end);
            }
            if path == other && (l + 1) % count == k {
                corners.push(b.curve.end);
            }
            // Intersections within a thousandth of an edge from a corner are rounding of a tangent arc.
            let margin = 1e-3 * a.curve.length().min(b.curve.length());
            let approach = a.curve.approach(&b.curve, &corners, margin);
            if let Some((gap, at)) = approach.filter(|(gap, _)| *gap <= near) {
                let rounding = 64.0 * f64::EPSILON * diameter;
                let how = if gap > rounding { "touches" } else { "meets" };
                let problem = format!(
                    "it {how} {} near {at:?}: edges may meet at their common corners only",
                    b.place
                );
                return Err(a.place.error(problem));
            }
        }
    }
    Ok(())
}

/// Refuses holes that are not inside the outer path or inside another hole.
fn nested(paths: &[Vec<Drawn>]) -> Result<(), MeshError> {
    let inside = |p: Point<2>, path: &[Drawn]| {
        let turns: f64 = path.iter().map(|drawn| drawn.curve.winding(p)).sum();
        turns.abs() > 0.5 * TAU
    };
    let starts: Vec<Point<2>> = paths.iter().map(|path| path[0].curve.start).collect();
    for (hole, &start) in starts.iter().enumerate().skip(1) {
        let place = contour_place(&paths[hole]);
        if !inside(start, &paths[0]) {
            return Err(place.error("it lies outside of the outer path"));
        }
        for (other, path) in paths.iter().enumerate().skip(1) {
            if other != hole && inside(start, path) {
                let problem = format!("it lies inside of {}: remove it", contour_place(path));
                return Err(place.error(problem));
            }
        }
    }
    Ok(())
}
