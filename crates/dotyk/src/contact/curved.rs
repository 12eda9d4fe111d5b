//! The curve behind a side: the true surface where it is known, else the distance of the mesh from it.

use crate::contact::{ContactError, End};
use crate::fem::{TrueSurface, show};
use crate::geometry::{Groups, Point, add_scaled, cross, distance, dot, norm, sub, unit};
use crate::mesh::{Facet, Mesh, SHARP};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Nodes may lie off the true surface of their side by this part of a facet.
const OFF_SURFACE: f64 = 0.01;

/// The true surface of the facets of one end of an interface.
///
/// Errors: nodes off the given surface.
pub(super) fn true_surface<'a, const D: usize>(
    end: End<'a, D>,
    facets: &[Facet],
) -> Result<TrueSurface<'a, D>, ContactError> {
    let mesh = &end.body.mesh;
    let surface = TrueSurface::of(end.body, end.side);
    for &facet in facets {
        let Some(given) = surface.given(facet).flatten() else {
            continue;
        };
        let limit = OFF_SURFACE * mesh.facet_length(facet);
        for node in mesh.facet_nodes(facet) {
            let point = mesh.points()[node as usize];
            let distance = given.distance(point).abs();
            if distance > limit {
                return Err(ContactError::OffSurface {
                    side: end.name(),
                    node: node as usize,
                    point: show(point),
                    distance,
                });
            }
        }
    }
    Ok(surface)
}

/// Largest distance of the facets around each node of a side from the smooth curve or surface that they approximate. Nodes with zero
/// distance are left out; it is zero where the true surface is known, and across corners.
///
/// * Straight facets of length L that turn by θ at their common node miss Lθ/8. In space a facet has the extent L across each of
///   its edges, and its errors in two directions add up: half of the sum over four edges, the sum over three.
/// * Parabolas of length L and rise s, whose curvature κ = 8s/L² changes by Δκ at a common node: s³/L² is the error of a parabola
///   through three points of a circle, Δκ L²/(72√3) that for a curve whose curvature changes; and a quarter of the error of
///   straight facets, since parabolas on a circle turn, too.
/// * A corner is a sharp one, or a blunt one between two flat parts of the side, each of which goes on beyond its first facet: a
///   curve would turn again there. The bend of a step is taken as drawn.
///
/// Errors: unknown or empty sides.
pub(crate) fn missed_by_nodes<const D: usize>(
    end: End<'_, D>,
) -> Result<BTreeMap<usize, f64>, ContactError> {
    let mesh = &end.body.mesh;
    let facets = end.facets()?;
    let surface = true_surface(end, facets)?;
    let curved = facets.iter().filter(|&&facet| surface.at(facet).is_none());
    let curved: Vec<Facet> = curved.copied().collect();
    let pieces: Vec<Vec<Piece<D>>> = curved.iter().map(|&facet| pieces(mesh, facet)).collect();
    let mut around: BTreeMap<[u32; 2], Vec<(usize, &Piece<D>)>> = BTreeMap::new();
    for (facet, pieces) in pieces.iter().enumerate() {
        for piece in pieces {
            around.entry(piece.place).or_default().push((facet, piece));
        }
    }
    let flat = Flat::of(mesh, &curved, &around);
    let missed_at = |piece: &Piece<D>| match around[&piece.place][..] {
        [a, b] if dot(a.1.normal, b.1.normal) > SHARP && !flat.meet_at_corner(a, b) => {
            missed_between(a.1, b.1)
        }
        _ => 0.0,
    };
    let missed = |of_facet: &Vec<Piece<D>>| {
        let between = of_facet.iter().map(missed_at);
        let between = match D {
            2 => between.fold(0.0, f64::max),
            _ => between.sum::<f64>() / (of_facet.len().max(3) - 2) as f64,
        };
        let own = of_facet
            .iter()
            .map(|p| p.rise.abs().powi(3) / (p.length * p.length));
        own.fold(between, f64::max)
    };
    let mut by_nodes = BTreeMap::new();
    for (&facet, pieces) in curved.iter().zip(&pieces) {
        let missed = missed(pieces);
        for node in mesh.facet_nodes(facet).filter(|_| missed > 0.0) {
            let most: &mut f64 = by_nodes.entry(node as usize).or_default();
            *most = most.max(missed);
        }
    }
    Ok(by_nodes)
}

/// The flat parts of a side: chains of facets without a turn.
struct Flat<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    /// For each facet, by index, the nodes of its part.
    parts: Vec<Rc<[u32]>>,
    /// The facets.
    facets: &'a [Facet],
}

/// Facets that turn by less, in radians, are one flat part, and those that turn by ten times that may meet at a corner.
const FLAT_PART: f64 = 1e-3;

/// A flat part continues beyond a facet if it reaches farther by this factor.
const BEYOND: f64 = 1.1;

impl<'a, const D: usize> Flat<'a, D> {
    fn of(
        mesh: &'a Mesh<D>,
        facets: &'a [Facet],
        around: &BTreeMap<[u32; 2], Vec<(usize, &Piece<D>)>>,
    ) -> Self {
        let mut groups = Groups::new(facets.len());
        for meeting in around.values() {
            if let [(a, first), (b, second)] = meeting[..]
                && angle(first.normal, second.normal) < FLAT_PART
                && first.straight()
                && second.straight()
            {
                groups.join(a, b);
            }
        }
        let mut nodes: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (index, &facet) in facets.iter().enumerate() {
            let part = nodes.entry(groups.first(index)).or_default();
            part.extend(mesh.facet_nodes(facet));
        }
        let nodes: BTreeMap<usize, Rc<[u32]>> = nodes
            .into_iter()
            .map(|(first, nodes)| (first, nodes.into()))
            .collect();
        let part = |index| Rc::clone(&nodes[&groups.first(index)]);
        Self {
            mesh,
            parts: (0..facets.len()).map(part).collect(),
            facets,
        }
    }

    /// Two facets turn at a common place, and the flat parts of both continue beyond them.
    fn meet_at_corner(&self, a: (usize, &Piece<D>), b: (usize, &Piece<D>)) -> bool {
        let turn = angle(a.1.normal, b.1.normal);
        let goes_on = |(index, piece)| self.goes_on(index, piece);
        turn > 10.0 * FLAT_PART && goes_on(a) && goes_on(b)
    }

    /// The flat part of a straight facet reaches farther from one of its places than the facet.
    fn goes_on(&self, index: usize, piece: &Piece<D>) -> bool {
        let points = self.mesh.points();
        let [first, second] = piece.place.map(|node| points[node as usize]);
        let along = unit(sub(second, first)).unwrap_or([0.0; D]);
        let facet = self.mesh.facet_points(self.facets[index]);
        let off = |point: Point<D>| {
            let away = sub(point, first);
            add_scaled(away, -dot(away, along), along)
        };
        let farthest = facet.map(off).max_by(|a, b| norm(*a).total_cmp(&norm(*b)));
        let Some(across) = farthest.and_then(unit) else {
            return false;
        };
        let mut nodes = self.parts[index].iter();
        let far = BEYOND * piece.length;
        piece.straight() && nodes.any(|&node| dot(off(points[node as usize]), across) > far)
    }
}

/// Distance of two facets that meet at a place from a smooth curve across it.
fn missed_between<const D: usize>(a: &Piece<D>, b: &Piece<D>) -> f64 {
    let length = a.length.max(b.length);
    let straight = length * angle(a.normal, b.normal) / 8.0;
    let bent = |piece: &Piece<D>| piece.rise.abs() > straight;
    let change = (a.curvature() - b.curvature()).abs();
    match bent(a) && bent(b) {
        true => (0.25 * straight).max(change * length * length / (72.0 * 3f64.sqrt())),
        false => straight,
    }
}

/// The angle between two unit vectors, accurate for small angles; zero below their rounding.
fn angle<const D: usize>(a: Point<D>, b: Point<D>) -> f64 {
    let turn = 2.0 * (0.5 * norm(sub(a, b))).min(1.0).asin();
    if turn > PARALLEL { turn } else { 0.0 }
}

/// Rounding of unit vectors.
const PARALLEL: f64 = 1e-13;

/// The largest angle by which neighbouring straight facets of a side turn, corners left out; `None` for a side that has
/// facets of higher order.
///
/// Errors: unknown or empty sides.
pub fn straight_turn<const D: usize>(end: End<'_, D>) -> Result<Option<f64>, ContactError> {
    let mesh = &end.body.mesh;
    let facets = end.facets()?;
    if facets
        .iter()
        .any(|&facet| mesh.facet_kind(facet).order() > 1)
    {
        return Ok(None);
    }
    let mut around: BTreeMap<[u32; 2], Vec<Point<D>>> = BTreeMap::new();
    for piece in facets.iter().flat_map(|&facet| pieces(mesh, facet)) {
        around.entry(piece.place).or_default().push(piece.normal);
    }
    let turn = |normals: &Vec<Point<D>>| match normals[..] {
        [a, b] if dot(a, b) > SHARP => angle(a, b),
        _ => 0.0,
    };
    Ok(Some(around.values().map(turn).fold(0.0, f64::max)))
}

/// A facet where it meets another: at an end node, in space along an edge.
struct Piece<const D: usize> {
    /// The node, or the corners of the edge.
    place: [u32; 2],
    /// Outward unit normal there, in space in the middle of the edge.
    normal: Point<D>,
    /// Extent of the facet across the place.
    length: f64,
    /// Rise of the facet over that length: distance of its middle node from the chord, along its normal in the middle.
    rise: f64,
}

/// A facet at all places where it may meet others.
fn pieces<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> Vec<Piece<D>> {
    let kind = mesh.facet_kind(facet);
    let (corners, at) = (kind.corners(), kind.reference_nodes());
    let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
    let bows = bows(mesh, facet);
    let piece = |k: usize| {
        let next = if D == 2 { k } else { (k + 1) % corners };
        let xi: [f64; 3] = std::array::from_fn(|d| 0.5 * (at[k][d] + at[next][d]));
        let normal = unit(mesh.outward_normal(facet, &xi))?;
        let length = match D {
            2 => mesh.facet_length(facet),
            _ => extent_across(mesh, facet, k),
        };
        // edges that lead away from this one bend across it, by less where they are longer than the way across
        let across = bows
            .iter()
            .enumerate()
            .filter(|&(j, _)| D == 2 || j != k && (corners == 3 || (j + corners - k) % 2 == 1));
        let rises = across.map(|(_, &(rise, chord))| rise * (length / chord).powi(2).min(1.0));
        let (a, b) = (nodes[k], nodes[next]);
        Some(Piece {
            place: [a.min(b), a.max(b)],
            normal,
            length,
            rise: rises.fold(
                0.0,
                |most: f64, rise| {
                    if rise.abs() > most.abs() { rise } else { most }
                },
            ),
        })
    };
    (0..corners).filter_map(piece).collect()
}

/// Extent of a facet of space across its edge `k`.
fn extent_across<const D: usize>(mesh: &Mesh<D>, facet: Facet, k: usize) -> f64 {
    let corners = mesh.facet_kind(facet).corners();
    let points: Vec<Point<D>> = mesh.facet_points(facet).take(corners).collect();
    let doubled = |ends: &[Point<D>]| cross(sub(ends[0], points[0]), sub(ends[1], points[0]));
    let area = points
        .windows(2)
        .map(doubled)
        .fold([0.0; 3], |sum, part| add_scaled(sum, 1.0, part));
    let edge = distance(points[k], points[(k + 1) % corners]);
    // of a triangle its height
    let part = if corners == 3 { 1.0 } else { 0.5 };
    part * norm(area) / edge
}

/// Distances of the middle nodes of a facet, in space those of its edges, from their chords along its normal in the middle, with
/// the chords; zero without middle nodes.
fn bows<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> Vec<(f64, f64)> {
    let kind = mesh.facet_kind(facet);
    let corners = kind.corners();
    let points: Vec<Point<D>> = mesh.facet_points(facet).collect();
    let normal = unit(mesh.outward_normal(facet, &kind.domain().centre())).unwrap_or([0.0; D]);
    let middles = points.iter().skip(corners).take(corners).enumerate();
    let bow = |(k, &middle): (usize, &Point<D>)| {
        let ends = [points[k], points[(k + 1) % corners]];
        let off = ends.map(|end| dot(normal, sub(middle, end)));
        // in the plane the tangent in the middle is along the chord
        match D {
            2 => (off[0], mesh.facet_length(facet)),
            _ => (0.5 * (off[0] + off[1]), distance(ends[0], ends[1])),
        }
    };
    middles.map(bow).collect()
}

impl<const D: usize> Piece<D> {
    fn straight(&self) -> bool {
        self.rise.abs() < FLAT_PART * self.length
    }

    fn curvature(&self) -> f64 {
        8.0 * self.rise / (self.length * self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{end, flat, node_at, ring, wall};
    use crate::fem::{Body, Constraints};
    use crate::geometry::Surface;
    use crate::mesh::CellKind;

    /// The largest distance of a side from its curve.
    fn sagitta<const D: usize>(end: End<'_, D>) -> Result<f64, ContactError> {
        let missed = missed_by_nodes(end)?;
        Ok(missed.values().fold(0.0, |most, &missed| most.max(missed)))
    }

    fn off(body: &Body<2>) -> f64 {
        sagitta(end(body, "bottom", &Constraints::default())).unwrap()
    }

    fn turn(body: &Body<2>) -> Option<f64> {
        straight_turn(end(body, "bottom", &Constraints::default())).unwrap()
    }

    /// A wall of straight facets of these lengths, each turned against the one before.
    fn polygon(lengths: &[f64], turns: &[f64], cell: CellKind) -> Body<2> {
        let (mut at, mut angle) = ([0.0, 0.0], 0.0);
        let mut points = vec![at];
        for (k, &length) in lengths.iter().enumerate() {
            if k > 0 {
                angle += turns[k - 1];
            }
            let direction = [f64::cos(angle), f64::sin(angle)];
            for _ in 0..cell.order() {
                let part = length / cell.order() as f64;
                at = [at[0] + part * direction[0], at[1] + part * direction[1]];
                points.push(at);
            }
        }
        wall(&points, 9.0, cell)
    }

    #[test]
    fn straight_facets_are_off_by_an_eighth_of_the_longer_one_times_the_turn() {
        // the cosine of a small angle knows it to 1e-8 of one over the angle
        let near = |a: f64, b: f64| (a - b).abs() < 1e-13;
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            let off = |lengths: &[f64], turns: &[f64]| off(&polygon(lengths, turns, cell));
            assert!(near(off(&[1.0, 3.0], &[0.2]), 3.0 * 0.2 / 8.0));
            assert!(near(off(&[3.0, 1.0], &[-0.2]), 3.0 * 0.2 / 8.0));
            // the largest of all nodes
            assert!(near(off(&[1.0, 1.0, 1.0], &[0.05, -0.03]), 0.05 / 8.0));
            assert!(near(off(&[1.0, 1.0, 1.0], &[0.03, -0.05]), 0.05 / 8.0));
            // a sharp corner counts as a corner
            assert!(near(off(&[1.0, 1.0, 1.0], &[0.05, 0.53]), 0.05 / 8.0));
            assert!(near(off(&[1.0, 1.0], &[0.52]), 0.52 / 8.0));
        }
        assert_eq!(
            off(&flat(&[0.0, 1.0, 2.0, 4.0, 5.0], 1.0, CellKind::Quad8)),
            0.0
        );
    }

    #[test]
    fn a_bend_between_flat_parts_is_a_corner_and_nothing_is_missed_there() {
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            let off = |lengths: &[f64], turns: &[f64]| off(&polygon(lengths, turns, cell));
            // a step with flanks, a bend
            let step = [0.0, 0.4, 0.0, -0.4, 0.0];
            // the rise of a straight parabola is rounding, and enters with its third power
            assert!(off(&[1.0; 6], &step) < 1e-40);
            assert!(off(&[1.0, 2.0, 3.0, 1.0], &[0.0, 0.3, 0.0]) < 1e-40);
            // beside a single facet a corner is not recognised, and an arc between tangents turns at all of its nodes
            let near = |a: f64, b: f64| (a - b).abs() < 1e-13;
            assert!(near(off(&[1.0, 1.0, 1.0], &[0.0, 0.3]), 0.3 / 8.0));
            let arc = [0.0, 0.1, 0.2, 0.1, 0.0];
            assert!(near(off(&[1.0; 6], &arc), 0.2 / 8.0));
            assert!(near(off(&[1.0; 6], &[0.0, 0.1, 0.1, 0.0, 0.0]), 0.1 / 8.0));
        }
    }

    #[test]
    fn polygons_turn_by_the_largest_angle_that_is_no_corner() {
        let of = |turns: &[f64]| turn(&polygon(&[1.0, 2.0, 1.0], turns, CellKind::Quad4)).unwrap();
        for (turns, largest) in [
            ([0.05, -0.03], 0.05),
            ([0.03, -0.05], 0.05),
            ([0.3, 0.2], 0.3),
            ([0.05, 0.53], 0.05),
            ([-0.05, 0.52], 0.52),
        ] {
            assert!((of(&turns) - largest).abs() < 1e-13, "{turns:?}");
        }
        assert_eq!(of(&[0.0, 0.0]), 0.0);
        assert_eq!(turn(&polygon(&[1.0, 2.0], &[0.1], CellKind::Quad8)), None);
    }

    #[test]
    fn in_space_facets_miss_what_they_turn_across_their_edges_whatever_their_lengths() {
        let free = Constraints::default();
        // a block whose top is bent about an axis, about both, and turned
        let off = |cell: CellKind, cells: [usize; 3], height: fn(Point<3>) -> f64| {
            let cuboid = crate::mesh::Cuboid {
                from: [-1.0, -1.0, 0.0],
                to: [1.0, 1.0, 1.0],
                cells,
                cell,
            };
            let place = |[x, y, z]: Point<3>| {
                let top = [x, y, 1.0 + height([x, y, z])];
                [top[0], top[1], z * top[2]]
            };
            let mesh = cuboid.build().unwrap().map_points(place).unwrap();
            let body = crate::contact::gaps::tests::body(mesh);
            sagitta(end(&body, "top", &free)).unwrap()
        };
        let bent: fn(Point<3>) -> f64 = |[x, _, _]| -0.02 * x * x;
        let bowl: fn(Point<3>) -> f64 = |[x, y, _]| -0.02 * (x * x + y * y);
        for (cell, part) in [(CellKind::Hex8, 1.0), (CellKind::Tet4, 1.0)] {
            // κ L²/8 with κ = 0.04, in both directions together
            let missed = part * 0.04 * 0.25f64.powi(2) / 8.0;
            for along in [1, 2, 40] {
                let found = off(cell, [8, along, 1], bent);
                assert!(
                    (found / missed - 1.0).abs() < 0.01,
                    "{cell:?} {along} {found}"
                );
            }
            let found = off(cell, [8, 8, 1], bowl);
            assert!(
                (found / (2.0 * missed) - 1.0).abs() < 0.5,
                "{cell:?} {found}"
            );
        }
        // a roof of two flat halves is not a curve, and one with as many facets as planes may be
        let roof: fn(Point<3>) -> f64 = |[x, _, _]| -0.2 * x.abs();
        for cell in [CellKind::Hex8, CellKind::Tet4, CellKind::Hex20] {
            for along in [1, 8] {
                let found = off(cell, [8, along, 1], roof);
                assert!(found < 1e-40, "{cell:?} {along} {found}");
                assert!(off(cell, [2, along, 1], roof) > 1e-3, "{cell:?} {along}");
            }
        }
        // parabolas are on a parabola but for rounding, in one direction or both
        for cell in [CellKind::Hex20, CellKind::Tet10] {
            for along in [1, 8, 40] {
                let found = off(cell, [8, along, 1], bent);
                assert!(
                    found < 1e-3 * 0.04 * 0.25f64.powi(2) / 8.0,
                    "{cell:?} {along} {found}"
                );
            }
        }
        // flat, and turned against the axes
        let slant: fn(Point<3>) -> f64 = |[x, y, _]| 0.3 * x + 0.17 * y;
        for cell in [CellKind::Hex8, CellKind::Tet4, CellKind::Hex20] {
            assert!(off(cell, [7, 5, 1], slant) < 1e-15, "{cell:?}");
        }
    }

    /// Distance of the facets of a wall from a curve, sampled at many places.
    fn far(body: &Body<2>, distance: impl Fn(Point<2>) -> f64) -> f64 {
        let facets = body.mesh.side("bottom").unwrap();
        let places = (0..=100).map(|k| 0.02 * f64::from(k) - 1.0);
        let places = places.flat_map(|xi| facets.iter().map(move |&facet| (facet, xi)));
        places
            .map(|(facet, xi)| distance(body.mesh.facet_point(facet, &[xi])).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn parabolas_through_a_circle_are_off_by_the_cube_of_their_rise() {
        for half_angle in [0.05f64, 0.2] {
            let on = |k: usize| {
                let angle = half_angle * (k as f64 - 3.0);
                [angle.sin(), 1.0 - angle.cos()]
            };
            let points: Vec<Point<2>> = (0..7).map(on).collect();
            let body = wall(&points, 3.0, CellKind::Quad8);
            let exact = far(&body, |x| distance(x, [0.0, 1.0]) - 1.0);
            // the largest terms in the angle of each
            assert!(
                (off(&body) / exact - 1.0).abs() < 0.05,
                "{} {exact}",
                off(&body)
            );
            // the other way up
            let mirrored: Vec<Point<2>> = points.iter().map(|[x, y]| [*x, -y]).collect();
            let mirrored = wall(&mirrored, 3.0, CellKind::Quad8);
            assert!((off(&mirrored) / off(&body) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn parabolas_through_a_curve_of_growing_curvature_are_off_by_its_growth() {
        // y = c x³ between 2 and 8, in three parabolas
        let cubic = |x: f64| 0.0002 * x * x * x;
        let points: Vec<Point<2>> = (0..7)
            .map(|k| f64::from(k) + 2.0)
            .map(|x| [x, cubic(x)])
            .collect();
        let body = wall(&points, 3.0, CellKind::Quad8);
        let exact = far(&body, |[x, y]| y - cubic(x));
        // the slope is small, but not zero
        assert!(
            (off(&body) / exact - 1.0).abs() < 0.02,
            "{} {exact}",
            off(&body)
        );
    }

    #[test]
    fn a_kink_between_parabolas_counts_as_one_of_straight_facets_unless_both_are_bent_more() {
        // two parabolas of half chord 1 and these rises, their chords turned; the kink is what is left of the turn
        let build = |rises: [f64; 2], turn: f64| {
            let (s, c) = turn.sin_cos();
            let points = [
                [-2.0, 0.0],
                [-1.0, -rises[0]],
                [0.0, 0.0],
                [c + rises[1] * s, s - rises[1] * c],
                [2.0 * c, 2.0 * s],
            ];
            wall(&points, 9.0, CellKind::Quad8)
        };
        let length = |rise: f64| 2.0 * (1.0 + rise * rise).sqrt();
        let kink = |rises: [f64; 2], turn: f64| {
            let inclined = rises.map(|rise| (2.0 * rise).atan());
            (inclined[0] + inclined[1] - turn).abs()
        };
        for (rises, turn, part) in [
            ([0.1f64, 0.1], 0.39, 0.25),
            ([0.1, 0.1], 0.41, 0.25),
            // one of them is straight
            ([0.1, 0.0], 0.19, 1.0),
            ([0.0, 0.1], 0.19, 1.0),
            // both are bent less than they turn
            ([0.01, 0.01], -0.2, 1.0),
        ] {
            let most = rises[0].max(rises[1]);
            let longest = length(most);
            let expected = part * longest * kink(rises, turn) / 8.0;
            let single = most.powi(3) / 4.0;
            let found = off(&build(rises, turn));
            assert!(
                (found / expected.max(single) - 1.0).abs() < 0.05,
                "{rises:?} {found}"
            );
        }
    }

    #[test]
    fn a_side_whose_curve_is_known_is_not_off_it() {
        let mut body = ring([0.0, 0.0], [1.0, 2.0], 12);
        let free = Constraints::default();
        let angle = std::f64::consts::PI / 12.0;
        let rough = sagitta(end(&body, "outer", &free)).unwrap();
        // 2R sin φ · 2φ/8
        assert!(
            (rough - 4.0 * angle.sin() * angle / 4.0).abs() < 1e-13,
            "{rough}"
        );
        let surface = Surface::Sphere {
            center: [0.0, 0.0],
            radius: 2.0,
        };
        // without the surface that the mesh generator knew
        body.surfaces.remove("outer");
        assert_eq!(sagitta(end(&body, "outer", &free)).unwrap(), 0.0);
        body.surfaces.insert("outer".to_string(), Some(surface));
        assert_eq!(sagitta(end(&body, "outer", &free)).unwrap(), 0.0);
        assert!(sagitta(end(&body, "inner", &free)).unwrap() > 0.1 * rough);
        // part of that side has its curve
        let [min, max] = [[-3.0, 0.0], [3.0, 3.0]];
        let half = Mesh::clone(&body.mesh).with_patch("half", "outer", min, max);
        body.mesh = half.unwrap().into();
        assert_eq!(sagitta(end(&body, "half", &free)).unwrap(), 0.0);
        // on a side that extends beyond it the other facets are as far off as alone
        body.mesh = Mesh::clone(&body.mesh).with_side("all", |_| true).into();
        let rest = sagitta(end(&body, "inner", &free)).unwrap();
        assert_eq!(sagitta(end(&body, "all", &free)).unwrap(), rest);
    }

    #[test]
    fn a_node_off_its_surface_by_more_than_a_hundredth_of_its_facet_is_an_error() {
        for (off, allowed) in [
            (0.0195, true),
            (0.0205, false),
            (-0.0195, true),
            (-0.0205, false),
        ] {
            let points = [[0.0, 0.0], [2.0, off], [4.0, 0.0]];
            let mut body = wall(&points, 3.0, CellKind::Quad4);
            let surface = Surface::Plane {
                point: [0.0, 0.0],
                normal: [0.0, 1.0],
            };
            body.surfaces.insert("bottom".to_string(), Some(surface));
            let free = Constraints::default();
            let end = end(&body, "bottom", &free);
            match (true_surface(end, end.facets().unwrap()), allowed) {
                (Ok(found), true) => {
                    assert_eq!(found.at(end.facets().unwrap()[0]), Some(surface));
                }
                (Err(ContactError::OffSurface { node, distance, .. }), false) => {
                    assert_eq!(node, node_at(&body, [2.0, off]));
                    assert!((distance - off.abs()).abs() < 1e-15);
                }
                _ => panic!("{off}"),
            }
        }
    }

    #[test]
    fn curvature_is_that_of_a_flat_parabola() {
        // y = κ x²/2 rises by κ L²/8 over a chord L
        let piece = Piece {
            place: [0, 0],
            normal: [0.0, 1.0],
            length: 3.0,
            rise: 0.2 * 9.0 / 8.0,
        };
        assert!((piece.curvature() - 0.2).abs() < 1e-15);
    }
}
