//! Sides split at sharp corners (in space edges): a corner has a normal, and a condition, for each of its faces.
//!
//! One condition along the mean of two normals would let the corner of a block slide through the floor of the pocket that
//! it sits in, as soon as it leaves the wall.
//!
//! An obstacle is not always met along the normal of a face: the edge of a wedge moves straight down onto a roller, and with faces at
//! 45° the distances along their normals would let it go twice as far. A corner has every normal of the cone that its faces span, and
//! meets an obstacle along the one nearest to the direction to the obstacle. If that is not the normal of a face, the faces have one
//! common condition.
//!
//! So does a corner that meets another side, or a tool: in front of an inclined face the corner of a block leans ([`leaning`]) from the
//! normal of its own face to the direction of that one's. The faces of the corner have one condition if they lean to the same place, and
//! in a pocket, where they lean to different walls, one each.

use crate::contact::curved::true_surface;
use crate::contact::normals::{Normals, ends};
use crate::contact::obstacle::Rigid;
use crate::contact::relative::free_part;
use crate::contact::search::{Hit, Line};
use crate::contact::weights::{NodalWeight, nodal_weights};
use crate::contact::{ContactError, End};
use crate::fem::Analysis;
use crate::geometry::{Groups, Point, add_scaled, distance, dot, sub, unit};
use crate::linalg::signed::least_squares_nonnegative;
use crate::mesh::{Facet, SHARP};
use std::collections::{BTreeMap, BTreeSet};

/// The parts of a side between its sharp corners or edges, in the order of its chain, in space of their first facets; the whole
/// if it has no corner.
///
/// Errors: unknown or empty sides, nodes off the true surface of the side.
pub fn smooth_parts<const D: usize>(end: End<'_, D>) -> Result<Vec<Vec<Facet>>, ContactError> {
    let (mesh, side) = (&end.body.mesh, end.facets()?);
    let Surfaces { first, sharp } = surfaces(end)?;
    if !sharp {
        return Ok(vec![side.to_vec()]);
    }
    let mut parts: BTreeMap<usize, Vec<Facet>> = BTreeMap::new();
    for (&facet, &first) in side.iter().zip(&first) {
        parts.entry(first).or_default().push(facet);
    }
    let mut parts: Vec<Vec<Facet>> = parts.into_values().collect();
    if let Some(plane) = mesh.in_plane() {
        let chains = plane.chain(end.side).unwrap_or_default();
        let along = chains.iter().flat_map(|chain| &chain.facets).enumerate();
        let place: BTreeMap<Facet, usize> = along.map(|(place, &facet)| (facet, place)).collect();
        let first = |part: &Vec<Facet>| part.iter().filter_map(|facet| place.get(facet)).min();
        parts.sort_by_key(|part| first(part).copied());
    }
    Ok(parts)
}

/// Whether a side meets a flat one by its corners alone: it has some, and none of its facets lies along the other, to ten degrees.
///
/// Errors: unknown or empty sides, nodes off the true surface of a side.
pub fn is_pointed<const D: usize>(
    end: End<'_, D>,
    other: End<'_, D>,
) -> Result<bool, ContactError> {
    let normals = |end: End<'_, D>| -> Result<Vec<Point<D>>, ContactError> {
        let mesh = &end.body.mesh;
        let facets = end.facets()?.iter();
        let at_centre = |&facet: &Facet| {
            let centre = mesh.facet_kind(facet).domain().centre();
            unit(mesh.outward_normal(facet, &centre))
        };
        Ok(facets.filter_map(at_centre).collect())
    };
    let others = normals(other)?;
    let Some(&across) = others.first() else {
        return Ok(false);
    };
    let flat = others.iter().all(|&n| dot(n, across) > TOUCHED);
    let towards = |n: &Point<D>| -dot(*n, across);
    let own = normals(end)?;
    let most = own.iter().map(towards).fold(f64::NEG_INFINITY, f64::max);
    Ok(flat && most > 0.0 && most < TOUCHED && surfaces(end)?.sharp)
}

/// The smooth surfaces of a side: facets that meet at common nodes without a corner.
pub(super) struct Surfaces {
    /// By facet of the side, the index of the first one of its surface.
    pub first: Vec<usize>,
    /// Some facets meet at a corner.
    pub sharp: bool,
}

/// Errors: unknown or empty sides, nodes off the true surface of the side.
pub(super) fn surfaces<const D: usize>(end: End<'_, D>) -> Result<Surfaces, ContactError> {
    let side = end.facets()?;
    let (mut groups, mut sharp) = (Groups::new(side.len()), false);
    for meeting in meeting(end)?.values() {
        for (place, &(a, normal)) in meeting.iter().enumerate() {
            for &(b, other) in &meeting[place + 1..] {
                match dot(normal, other) > SHARP {
                    true => groups.join(a, b),
                    false => sharp = true,
                }
            }
        }
    }
    Ok(Surfaces {
        first: (0..side.len()).map(|index| groups.first(index)).collect(),
        sharp,
    })
}

/// Facets of a side, by index, with their normals, at each of its nodes.
type Meeting<const D: usize> = BTreeMap<usize, Vec<(usize, Point<D>)>>;

/// Errors: unknown or empty sides, nodes off the true surface of the side.
fn meeting<const D: usize>(end: End<'_, D>) -> Result<Meeting<D>, ContactError> {
    let (mesh, side) = (&end.body.mesh, end.facets()?);
    let known = true_surface(end, side)?;
    let mut meeting = Meeting::new();
    for (index, &facet) in side.iter().enumerate() {
        let kind = mesh.facet_kind(facet);
        for (node, xi) in mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
            let here = meeting.entry(node as usize).or_default();
            here.push((index, known.normal(facet, xi)));
        }
    }
    Ok(meeting)
}

/// Corners that meet an obstacle between the normals of their faces, by node.
pub type Corners<const D: usize> = BTreeMap<usize, Corner<D>>;

/// A corner that meets an obstacle between the normals of its faces: they have one common condition.
#[derive(Debug, Clone)]
pub struct Corner<const D: usize> {
    /// The direction of this condition.
    pub normal: Point<D>,
    /// Weights of the node in the bearing facets (those that face the obstacle, or else all), and in all facets.
    pub weights: [NodalWeight; 2],
    /// The bearing facet most nearly opposite to the obstacle: the condition belongs to its surface.
    pub owner: Facet,
}

/// The corners of a whole side that meet an obstacle between the normals of their faces.
///
/// Errors: unknown or empty sides, nodes off the true surface of the side.
pub fn corners_above<const D: usize>(
    whole: End<'_, D>,
    rigid: &Rigid<D>,
    analysis: Analysis,
) -> Result<Corners<D>, ContactError> {
    let (mesh, side) = (&whole.body.mesh, whole.facets()?);
    let meeting = meeting(whole)?;
    let sharp = meeting.iter().filter(|(_, meeting)| is_sharp(meeting));
    let between = sharp.filter_map(|(&node, meeting)| {
        let way = rigid.towards(mesh.points()[node])?;
        Some((node, between(meeting.iter().map(|(_, n)| *n), way)?))
    });
    let between: BTreeMap<usize, Point<D>> = between.collect();
    if between.is_empty() {
        return Ok(Corners::new());
    }
    let normals = Normals::new(whole, side)?;
    let faces = |&facet: &Facet| {
        let places = mesh.facet_kind(facet).reference_nodes().iter();
        mesh.facet_nodes(facet).zip(places).all(|(node, xi)| {
            let met = between.get(&(node as usize)).copied();
            let normal = met.unwrap_or_else(|| normals.at(facet, xi));
            rigid.faces(mesh.points()[node as usize], normal)
        })
    };
    let facing: BTreeSet<Facet> = side.iter().copied().filter(faces).collect();
    let weights = |facets: Vec<Facet>| nodal_weights(mesh, facets, analysis, whole.body.thickness);
    let [some, all] = [facing.iter().copied().collect(), side.to_vec()].map(weights);
    let corner = |(&node, &normal): (&usize, &Point<D>)| {
        let around = &meeting[&node];
        let sees = |of: &&(usize, Point<D>)| facing.contains(&side[of.0]);
        let seen: Vec<&(usize, Point<D>)> = around.iter().filter(sees).collect();
        // the tip of a needle touches although neither of its faces is opposed to the obstacle
        let (bearing, own) = match seen.is_empty() {
            true => (around.iter().collect(), all[&node]),
            false => (seen, some[&node]),
        };
        let most = bearing.into_iter();
        let most = most.max_by(|a, b| dot(a.1, normal).total_cmp(&dot(b.1, normal)))?;
        let corner = Corner {
            normal,
            weights: [own, all[&node]],
            owner: side[most.0],
        };
        Some((node, corner))
    };
    Ok(between.iter().filter_map(corner).collect())
}

/// Some facets that meet at a node form a corner there, even if a chain of facets around the corner joins them smoothly.
fn is_sharp<const D: usize>(meeting: &[(usize, Point<D>)]) -> bool {
    let mut groups = Groups::new(meeting.len());
    for (a, (_, normal)) in meeting.iter().enumerate() {
        for (b, (_, other)) in meeting.iter().enumerate().skip(a + 1) {
            if dot(*normal, *other) > SHARP {
                groups.join(a, b);
            }
        }
    }
    (0..meeting.len()).any(|facet| groups.first(facet) > 0)
}

/// The direction in the cone of some normals that is nearest to a given one; `None` if it is one of the normals.
fn between<const D: usize>(
    faces: impl Iterator<Item = Point<D>>,
    direction: Point<D>,
) -> Option<Point<D>> {
    let (nearest, faces) = nearest_in_cone(faces, direction);
    nearest.filter(|_| faces > 1)
}

/// The direction in the cone of some normals that is nearest to a given one, and the number of those that it lies between; `None` if all
/// are opposed to it.
fn nearest_in_cone<const D: usize>(
    faces: impl Iterator<Item = Point<D>>,
    direction: Point<D>,
) -> (Option<Point<D>>, usize) {
    let faces: Vec<Vec<f64>> = faces.map(|normal| normal.to_vec()).collect();
    let (parts, rest) = least_squares_nonnegative(&faces, &direction);
    let several = parts.iter().filter(|&&part| part > 0.0).count();
    let nearest = std::array::from_fn(|k| direction[k] - rest[k]);
    (unit(nearest), several)
}

/// Directions that differ by less are the same.
pub(super) const SAME_DIRECTION: f64 = 1e-9;

/// A corner is touched first only by what lies between its faces or, with a cosine above this, beside: there its neighbours are nearer by
/// a sixth of a facet. Normals within that angle are those of one plane.
const TOUCHED: f64 = 0.985;

/// So many lines find the nearest place of a surface that bends away, each at least a third of a digit more where it is within twice the
/// radius; else the last one that met it counts.
const LINES: usize = 30;

/// A corner that meets the opposite between the faces of its body.
pub(super) struct Leaning<const D: usize> {
    /// A facet of the side there.
    pub facet: Facet,
    /// The direction in which it meets the opposite.
    pub direction: Point<D>,
    /// The line along which it was found, that direction or, where this passes the end of the surface that is met, one beside, and where
    /// that meets it.
    pub along: Point<D>,
    pub hit: Hit,
}

/// What a line from a facet meets, of the smooth surface of another facet if one is given, and the direction against the surface there.
pub(super) type Meets<'a, const D: usize> =
    dyn Fn(Facet, Line<D>, Option<Facet>) -> Option<(Hit, Point<D>)> + 'a;

/// Nodes at the ends of a side, or of a smooth part of it, that meet the opposite between the faces of the body there: against the
/// surface which the line along their normal meets, at its nearest place, or along that direction in the cone of the faces that fall off
/// there which is nearest to it. What is held against it does not lean: a plane of symmetry is no face.
///
/// Errors: unknown or empty sides.
pub(super) fn leaning<const D: usize>(
    end: End<'_, D>,
    normals: &Normals<'_, D>,
    meets: &Meets<'_, D>,
) -> Result<BTreeMap<usize, Leaning<D>>, ContactError> {
    let (mesh, own) = (&end.body.mesh, end.facets()?);
    let (ends, nodal) = (ends(mesh, own), normals.nodal());
    let mut oblique: BTreeMap<usize, (Facet, Vec<Point<D>>)> = BTreeMap::new();
    for &facet in own {
        for node in mesh.facet_nodes(facet).filter(|node| ends.contains(node)) {
            let node = node as usize;
            let Some(&normal) = nodal.get(&node) else {
                continue;
            };
            let (start, direction) = (mesh.points()[node], normal);
            let met = meets(facet, Line { start, direction }, None);
            if met.is_some_and(|(_, against)| distance(against, normal) > SAME_DIRECTION) {
                oblique.entry(node).or_insert((facet, vec![normal]));
            }
        }
    }
    if !oblique.is_empty() {
        // where the body goes on behind a cut of its mesh there is no corner
        let alone = alone(mesh.points(), oblique.keys().copied());
        oblique.retain(|node, _| alone.contains(node));
        add_faces(end, own, &mut oblique);
    }
    let leans = |(node, (facet, faces)): (usize, (Facet, Vec<Point<D>>))| {
        Some((node, towards(end, (node, facet), &faces, meets)?))
    };
    Ok(oblique.into_iter().filter_map(leans).collect())
}

/// Those of some nodes that coincide with no other one.
fn alone<const D: usize>(
    points: &[Point<D>],
    nodes: impl Iterator<Item = usize>,
) -> BTreeSet<usize> {
    let bits = |x: Point<D>| x.map(|c| (c + 0.0).to_bits());
    let mut at: BTreeMap<[u64; D], (usize, usize)> =
        nodes.map(|node| (bits(points[node]), (node, 0))).collect();
    for &point in points {
        if let Some((_, count)) = at.get_mut(&bits(point)) {
            *count += 1;
        }
    }
    let once = at.into_values().filter(|(_, count)| *count == 1);
    once.map(|(node, _)| node).collect()
}

/// Adds the normals of the faces of a body that fall off from some of its nodes, beside those of a side there.
fn add_faces<const D: usize>(
    end: End<'_, D>,
    own: &[Facet],
    nodes: &mut BTreeMap<usize, (Facet, Vec<Point<D>>)>,
) {
    let mesh = &end.body.mesh;
    let faces = |side: &String| mesh.side(side).unwrap_or_default();
    let cut = end.body.cyclic.iter().flat_map(|c| [&c.from, &c.to]);
    let inside: BTreeSet<&Facet> = cut.flat_map(faces).chain(own).collect();
    let outside = mesh.boundary_facets().into_iter();
    for facet in outside.filter(|facet| !inside.contains(facet)) {
        let kind = mesh.facet_kind(facet);
        let middle = mesh.facet_point(facet, &kind.domain().centre());
        for (node, xi) in mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
            let Some((_, faces)) = nodes.get_mut(&(node as usize)) else {
                continue;
            };
            // the far face of a hollow corner is met by itself
            let falls_off = dot(sub(middle, mesh.points()[node as usize]), faces[0]) < 0.0;
            faces.extend(unit(mesh.outward_normal(facet, xi)).filter(|_| falls_off));
        }
    }
}

/// How a corner of these faces, that of the side first, leans; `None` if it does not.
fn towards<const D: usize>(
    end: End<'_, D>,
    (node, facet): (usize, Facet),
    faces: &[Point<D>],
    meets: &Meets<'_, D>,
) -> Option<Leaning<D>> {
    let (start, upright) = (end.body.mesh.points()[node], faces[0]);
    let held = end.constraints.at(node);
    let free = |lean: Point<D>| {
        free_part(lean, held.iter().map(|h| h.axis))
            .map_or([0.0; D], |free| free.map(|c| c * dot(free, lean)))
    };
    let nearest = |against: Point<D>| {
        let nearest = nearest_in_cone(faces.iter().copied(), against).0?;
        // beyond the faces the body goes on towards what is met: a neighbour is nearer
        if dot(nearest, against) < TOUCHED {
            return Some(upright);
        }
        let along = dot(nearest, upright);
        let lean = free(add_scaled(nearest, -along, upright));
        unit(add_scaled(lean, along, upright))
    };
    let (mut direction, mut last, mut halved) = (upright, f64::INFINITY, false);
    let mut found: Option<Leaning<D>> = None;
    for _ in 0..LINES {
        let of = found.as_ref().map(|found| found.hit.facet);
        let Some((hit, against)) = meets(facet, Line { start, direction }, of) else {
            // past its end, or past a small roller
            direction = unit(add_scaled(direction, 1.0, found.as_ref()?.along))?;
            continue;
        };
        let next = nearest(against)?;
        let step = distance(next, direction);
        found = Some(Leaning {
            facet,
            direction: next,
            along: direction,
            hit,
        });
        if step <= SAME_DIRECTION {
            break;
        }
        // a roller of the radius R at the distance s turns the error of the direction over, s/R times as large
        halved |= step > 0.5 * last;
        direction = match halved {
            true => unit(add_scaled(direction, 1.0, next))?,
            false => next,
        };
        last = step;
    }
    found.filter(|found| distance(found.direction, upright) > SAME_DIRECTION)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, end, held, node_at, plate, ring, wall};
    use crate::contact::opposite::Opposite;
    use crate::contact::{Against, InitialGap};
    use crate::fem::{Body, Constraints};
    use crate::geometry::{Surface, distance};
    use crate::mesh::{CellKind, Cuboid, Mesh};

    fn parts<const D: usize>(mesh: Mesh<D>, side: &str) -> (Body<D>, Vec<Vec<Facet>>) {
        let (body, free) = (body(mesh), Constraints::default());
        let parts = smooth_parts(end(&body, side, &free)).unwrap();
        (body, parts)
    }

    #[test]
    fn the_four_faces_of_a_plate_are_parts_in_the_order_of_the_chain() {
        let mesh = plate([0.0, 0.0], [3.0, 1.0], [4, 2]).mesh;
        let mesh = Mesh::clone(&mesh).with_side("all", |[x, y]| {
            [x, 3.0 - x, y, 1.0 - y].into_iter().any(|c| c.abs() < 1e-9)
        });
        let (body, parts) = parts(mesh, "all");
        assert_eq!(parts.iter().map(Vec::len).sum::<usize>(), 12);
        let along = body.mesh.chain("all").unwrap()[0].facets.clone();
        let place = |facet: &Facet| along.iter().position(|f| f == facet).unwrap();
        let firsts: Vec<usize> = parts
            .iter()
            .map(|part| part.iter().map(place).min().unwrap())
            .collect();
        assert!(firsts.is_sorted());
        for name in ["bottom", "right", "top", "left"] {
            let face = body.mesh.side(name).unwrap();
            assert!(parts.iter().any(|part| part == face), "{name}");
        }
    }

    #[test]
    fn facets_meet_at_a_corner_when_their_normals_turn_too_far() {
        for (angle, count) in [(30.0f64, 1), (30.1, 2)] {
            let (s, c) = angle.to_radians().sin_cos();
            for cell in [CellKind::Quad4, CellKind::Quad8] {
                let points = [
                    [-2.0, 0.0],
                    [-1.0, 0.0],
                    [0.0, 0.0],
                    [c, s],
                    [2.0 * c, 2.0 * s],
                ];
                let mesh = wall(&points, 4.0, cell).mesh;
                let (body, parts) = parts(Mesh::clone(&mesh), "bottom");
                assert_eq!(parts.len(), count, "{angle}");
                let whole = body.mesh.side("bottom").unwrap();
                let all: Vec<Facet> = parts.into_iter().flatten().collect();
                assert_eq!(all, whole);
            }
        }
    }

    #[test]
    fn a_smooth_side_stays_whole() {
        let (body, found) = parts(Mesh::clone(&ring([0.0, 0.0], [1.0, 2.0], 12).mesh), "outer");
        assert_eq!(found, [body.mesh.side("outer").unwrap()]);
        // so do two faces that do not touch
        let mesh = plate([0.0, 0.0], [3.0, 1.0], [4, 2]).mesh;
        let mesh = Mesh::clone(&mesh).with_side("both", |[_, y]| y * (1.0 - y) < 1e-9);
        let (body, found) = parts(mesh, "both");
        assert_eq!(found, [body.mesh.side("both").unwrap()]);
    }

    #[test]
    fn the_faces_of_a_box_are_parts_whatever_the_order_of_their_facets() {
        for cell in [CellKind::Tet4, CellKind::Hex8] {
            let cuboid = Cuboid {
                from: [0.0; 3],
                to: [1.0; 3],
                cells: [3, 3, 3],
                cell,
            };
            let mesh = cuboid.build().unwrap();
            let mesh = mesh.with_side("all", |_| true);
            let (body, parts) = parts(mesh, "all");
            assert_eq!(parts.len(), 6);
            for name in ["left", "right", "front", "back", "bottom", "top"] {
                let face = body.mesh.side(name).unwrap();
                assert!(parts.iter().any(|part| part == face), "{name}");
            }
            let firsts: Vec<Facet> = parts.iter().map(|part| part[0]).collect();
            assert!(firsts.is_sorted());
        }
    }

    #[test]
    fn a_corner_meets_what_is_before_it_along_the_nearest_of_its_normals() {
        let cube = Cuboid {
            from: [0.0; 3],
            to: [1.0; 3],
            cells: [2, 2, 2],
            cell: CellKind::Hex8,
        };
        let mesh = cube.build().unwrap().with_side("all", |_| true);
        let (body, free) = (body(mesh), Constraints::default());
        let end = end(&body, "all", &free);
        let ball = |center: Point<3>| Rigid::Surface {
            surface: Surface::Sphere {
                center,
                radius: 0.9,
            },
            inside: false,
        };
        let at = |center: Point<3>, place: Point<3>| {
            let corners = corners_above(end, &ball(center), Analysis::Solid).unwrap();
            let node = body.mesh.points().iter().position(|&p| p == place).unwrap();
            corners.get(&node).cloned()
        };
        let s = |n: f64| 1.0 / n.sqrt();
        // in front of the corner: straight to the ball; its three facets do not face it, and all bear
        let corner = at([2.0; 3], [1.0; 3]).unwrap();
        assert!(distance(corner.normal, [s(3.0); 3]) < 1e-15);
        assert!((corner.weights[0].area - 3.0 / 16.0).abs() < 1e-15);
        // in front of an edge: across it, whatever the position along it
        for along in [0.5, 0.7] {
            let corner = at([along, 2.0, 2.0], [0.5, 1.0, 1.0]).unwrap();
            assert!(distance(corner.normal, [0.0, s(2.0), s(2.0)]) < 1e-15);
            assert!((corner.weights[1].area - 4.0 / 16.0).abs() < 1e-15);
        }
        // in front of a face: along its own normal, one for each face
        assert!(at([0.5, 0.5, 2.0], [1.0; 3]).is_none());
        assert!(at([2.0; 3], [0.5, 0.5, 1.0]).is_none());
        // slightly off the face the result is the same, and the more nearly opposed face bears
        let corner = at([1.01, 1.02, 2.0], [1.0; 3]).unwrap();
        assert!(distance(corner.normal, unit([0.01, 0.02, 1.0]).unwrap()) < 1e-15);
        let top = body.mesh.side("top").unwrap();
        assert!(top.contains(&corner.owner));
        assert!((corner.weights[0].area - 1.0 / 16.0).abs() < 1e-15);
    }

    #[test]
    fn an_unknown_side_has_no_parts() {
        let (body, free) = (
            plate([0.0, 0.0], [1.0, 1.0], [1, 1]),
            Constraints::default(),
        );
        let error = smooth_parts(end(&body, "nowhere", &free)).unwrap_err();
        assert!(error.to_string().contains("nowhere"), "{error}");
    }

    /// The directions in which the end of a floor's top at x = 1 meets a wall below these points, by node.
    fn leaning_to(points: &[Point<2>], supports: &Constraints<2>) -> Vec<(usize, Point<2>)> {
        let floor = plate([0.0, -1.0], [1.0, 0.0], [2, 2]);
        let wall = wall(points, 9.0, CellKind::Quad4);
        let none = Constraints::default();
        let against = Against::Side(end(&wall, "bottom", &none));
        let own = end(&floor, "top", supports);
        let sides = Opposite::new(own, against, InitialGap::Measured, 0.0).unwrap();
        let corners = sides.corners().unwrap().into_iter();
        corners
            .map(|(node, corner)| (node, corner.at.normal))
            .collect()
    }

    #[test]
    fn a_corner_leans_to_a_face_that_comes_down_beside_it() {
        let free = Constraints::default();
        let floor = plate([0.0, -1.0], [1.0, 0.0], [2, 2]);
        let corner = node_at(&floor, [1.0, 0.0]);
        // the wall comes down to the right by 0.2 for each 1, above both corners: the left one is met from inside
        let sloping = [[-2.0, 1.0], [3.0, 0.0]];
        let [(node, direction)] = leaning_to(&sloping, &free)[..] else {
            panic!("one corner leans")
        };
        assert_eq!(node, corner);
        assert!(distance(direction, unit([0.2, 1.0]).unwrap()) < 1e-12);
        // a plane of symmetry is no face, and a level wall is met along the normal
        let held = held(&[(corner, [1.0, 0.0], true)]);
        assert!(leaning_to(&sloping, &held).is_empty());
        assert!(leaning_to(&[[-2.0, 0.5], [3.0, 0.5]], &free).is_empty());
    }

    #[test]
    fn in_front_of_a_bent_wall_a_corner_leans_to_the_nearest_place() {
        // arcs about (1.5, 1.5) of several radii: the nearest place is along (1, 3) from the corner at (1, 0)
        let arc = |radius: f64| -> Vec<Point<2>> {
            let angles = (0..=90).map(|k| f64::to_radians(180.0 + 2.0 * f64::from(k)));
            let at = |angle: f64| [1.5 + radius * angle.cos(), 1.5 + radius * angle.sin()];
            angles.map(at).collect()
        };
        for radius in [0.55, 1.0, 1.5] {
            let found = leaning_to(&arc(radius), &Constraints::default());
            let [(_, direction)] = found[..] else {
                panic!("one corner leans: {found:?}")
            };
            // a facet turns by 2 degrees
            let nearest = unit([1.0, 3.0]).unwrap();
            assert!(
                distance(direction, nearest) < 1e-3,
                "{radius}: {direction:?}"
            );
        }
    }
}
