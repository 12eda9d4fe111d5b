//! Points of a nonmortar side between its nodes, and their opposites: samples for the judge, independent of the rows.
//!
//! ```text
//!   gap(x) = g₀(x) + n·(u_m(y) − u_s(x)),     y on the line x + s·n(x)
//! ```
//!
//! g₀ is the initial gap as the contact defines it (measured, closed, given). A pressure that varies from node to node dents
//! both bodies by about p (h_s/E_s + h_m/E_m), h the lengths of the facets, E their plane moduli: what the meshes cannot
//! resolve.

use crate::contact::opposite::{Opposite, shape};
use crate::contact::{Against, ContactError, End, GapPoint, InitialGap, Rigid};
use crate::fem::quadrature;
use crate::geometry::Point;
use crate::mesh::{CellKind, Domain, Facet};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Points on each line: the middles of as many equal parts.
const POINTS: usize = 6;

/// Degree of the rule whose points are sampled on a surface, plus its corners: ten points on a triangle, thirteen on a square. The
/// opposite side may have an edge near one of this facet, which only its corners show.
const DEGREE: usize = 5;

/// One point with an opposite.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample<const D: usize> {
    /// Undeformed position.
    pub point: Point<D>,
    /// Reference coordinates on its facet, missing ones zero.
    pub xi: [f64; 2],
    /// Its opposite.
    pub at: GapPoint<D>,
    /// The smooth surface of the other side there, by the index of its first facet.
    pub surface: usize,
    /// Depth of the dent between the nodes under a unit pressure, a length³/force.
    pub dent: f64,
}

/// The points of every facet of the nonmortar side with an opposite, facet by facet. The corners of the side lean as those of the
/// rows do, if they do.
///
/// Errors: unknown or empty sides, nodes off their true surface, a gap that is not finite.
pub fn samples<const D: usize>(
    nonmortar: End<'_, D>,
    against: Against<'_, D>,
    gap: InitialGap<'_>,
    time: f64,
    leaning: bool,
) -> Result<Vec<Vec<Sample<D>>>, ContactError> {
    let mut sides = Opposite::new(nonmortar, against, gap, time)?;
    if leaning {
        sides = sides.leaning()?;
    }
    let surfaces = sides.surfaces_opposite().unwrap_or_default();
    let is_tool = matches!(against, Against::Obstacle(Rigid::Tool(_), _));
    let at = |facet: Facet, places: &[[f64; 2]]| {
        let found = places.iter();
        let found = found.filter_map(|xi| sample((&sides, &surfaces), facet, *xi).transpose());
        let mut found = found.collect::<Result<Vec<Sample<D>>, _>>()?;
        // the nodes of a tool move alike
        let opposites = found.iter_mut().map(|sample| &mut sample.at.opposite);
        opposites.filter(|_| is_tool).for_each(Vec::clear);
        Ok(found)
    };
    let on_facet = |&facet: &Facet| {
        let kind = sides.mesh().facet_kind(facet);
        let places = places(kind);
        let mut found = at(facet, &places)?;
        // on a facet that faces the other side in part these points may miss most
        if D == 3 && !found.is_empty() && found.len() < places.len() {
            found.extend(at(facet, &lattice(kind))?);
        }
        Ok(found)
    };
    nonmortar.facets()?.par_iter().map(on_facet).collect()
}

/// The sample points on a facet of some kind.
fn places(kind: CellKind) -> Vec<[f64; 2]> {
    match kind.domain() {
        Domain::Line => {
            let middle = |k| -1.0 + (2 * k + 1) as f64 / POINTS as f64;
            (0..POINTS).map(|k| [middle(k), 0.0]).collect()
        }
        _ => {
            let rule = quadrature::rule(kind, DEGREE).into_iter();
            let inside = rule.map(|point| [point.xi[0], point.xi[1]]);
            let corners = &kind.reference_nodes()[..kind.corners()];
            let corners = corners.iter().map(|xi| [xi[0], xi[1]]);
            inside.chain(corners).collect()
        }
    }
}

/// Steps of the lattice along an edge.
const LATTICE: usize = 8;

/// The points of a lattice over a surface, its edges included, corners left out.
fn lattice(kind: CellKind) -> Vec<[f64; 2]> {
    let corners = &kind.reference_nodes()[..kind.corners()];
    let (origin, ends) = (corners[0], [corners[1], corners[kind.corners() - 1]]);
    let part = |k: usize| k as f64 / LATTICE as f64;
    let at = |i: usize, j: usize| {
        [0, 1].map(|d| {
            let along = part(i) * (ends[0][d] - origin[d]);
            origin[d] + along + part(j) * (ends[1][d] - origin[d])
        })
    };
    let inside = |i: usize, j: usize| kind.corners() > 3 || i + j <= LATTICE;
    let ends_at = |k: usize| k == 0 || k == LATTICE;
    let is_corner = |i: usize, j: usize| ends_at(i) && ends_at(j);
    let places = (0..=LATTICE).flat_map(|i| (0..=LATTICE).map(move |j| (i, j)));
    let places = places.filter(|&(i, j)| inside(i, j) && !is_corner(i, j));
    places.map(|(i, j)| at(i, j)).collect()
}

fn sample<const D: usize>(
    (sides, surfaces): (&Opposite<'_, D>, &BTreeMap<Facet, usize>),
    facet: Facet,
    xi: [f64; 2],
) -> Result<Option<Sample<D>>, ContactError> {
    let line = sides.line(facet, &xi);
    let own = sides.nonmortar;
    let (normal, gap, opposite, (other, surface)) = match sides.against {
        Against::Obstacle(..) => match sides.obstacle(facet, line)? {
            Some((normal, gap)) => (normal, gap, Vec::new(), (0.0, 0)),
            None => return Ok(None),
        },
        Against::Side(mortar) => {
            let Some(found) = sides.at(facet, &xi)? else {
                return Ok(None);
            };
            let dent = dent(mortar, found.facet);
            let surface = surfaces.get(&found.facet).copied().unwrap_or(0);
            (line.direction, found.gap, found.nodes, (dent, surface))
        }
    };
    Ok(Some(Sample {
        point: line.start,
        xi,
        at: GapPoint {
            own: shape(&own.body.mesh, facet, &xi),
            opposite,
            normal,
            gap,
        },
        surface,
        dent: dent(own, facet) + other,
    }))
}

/// h/E of a facet: its length over the plane modulus E/(1 − ν²) of its cell; zero without a material.
fn dent<const D: usize>(end: End<'_, D>, facet: Facet) -> f64 {
    let block = &end.body.mesh.blocks()[facet.block as usize];
    let elastic = end.body.elastic(block);
    elastic.map_or(0.0, |e| {
        end.body.mesh.facet_length(facet) / e.plane_modulus()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, end, flat, plate, ring};
    use crate::contact::{Driven, Rigid};
    use crate::fem::{Body, Constraints};
    use crate::geometry::{Field, Surface, add_scaled, distance};
    use crate::mesh::Cuboid;

    #[test]
    fn both_bodies_dent_by_the_length_of_their_facets_over_their_modulus() {
        let (lower, upper) = (
            plate([0.0, 0.0], [3.0, 1.0], [6, 2]),
            plate([0.0, 1.1], [3.0, 2.0], [12, 2]),
        );
        let free = Constraints::default();
        let against = Against::Side(end(&lower, "top", &free));
        let nonmortar = end(&upper, "bottom", &free);
        let found = samples(nonmortar, against, InitialGap::Measured, 0.0, true).unwrap();
        assert_eq!(found.len(), 12);
        let modulus = 1.0 / (1.0 - 0.3 * 0.3);
        for sample in found.iter().flatten() {
            assert!((sample.dent - (0.25 + 0.5) / modulus).abs() < 1e-15);
            assert!((sample.at.gap - 0.1).abs() < 1e-14);
        }
    }

    #[test]
    fn samples_lie_in_the_middles_of_six_parts_of_a_line() {
        let upper = flat(&[0.0, 6.0, 12.0], 1.0, CellKind::Quad4);
        let rigid = Rigid::Gap(Field::function("x + t", |p, t| p[0] + t));
        let free = Constraints::default();
        let nonmortar = end(&upper, "bottom", &free);
        let against = Against::Obstacle(&rigid, Driven::Still);
        let found = samples(nonmortar, against, InitialGap::Measured, 3.0, true).unwrap();
        assert_eq!(found.len(), 2);
        let modulus = 1.0 / (1.0 - 0.3 * 0.3);
        for (k, sample) in found.iter().flatten().enumerate() {
            let x = k as f64 + 0.5;
            assert!((sample.point[0] - x).abs() < 1e-14 && sample.point[1] == 0.0);
            let expected = ((2 * (k % 6)) as f64 - 5.0) / 6.0;
            assert!((sample.xi[0] - expected).abs() < 1e-15 && sample.xi[1] == 0.0);
            assert!((sample.at.gap - (x + 3.0)).abs() < 1e-13);
            assert!(sample.at.opposite.is_empty());
            assert_eq!(sample.at.normal, [0.0, -1.0]);
            // an obstacle is not dented
            assert!((sample.dent - 6.0 / modulus).abs() < 1e-14);
        }
        assert_eq!(found.iter().flatten().count(), 12);
    }

    #[test]
    fn samples_of_surfaces_face_each_other_along_the_normal() {
        for (cell, count) in [(CellKind::Tet4, 10), (CellKind::Hex8, 13)] {
            let build = |from: f64, cells: usize| {
                let cuboid = Cuboid {
                    from: [0.0, 0.0, from],
                    to: [1.0, 1.2, from + 1.0],
                    cells: [cells; 3],
                    cell,
                };
                body(cuboid.build().unwrap())
            };
            let (lower, upper) = (build(0.0, 2), build(1.25, 3));
            let free = Constraints::default();
            let against = Against::Side(end(&lower, "top", &free));
            let nonmortar = end(&upper, "bottom", &free);
            let found = samples(nonmortar, against, InitialGap::Measured, 0.0, true).unwrap();
            for on_facet in &found {
                assert_eq!(on_facet.len(), count);
            }
            for sample in found.iter().flatten() {
                let place = |nodes: &[(usize, f64)], body: &Body<3>| {
                    let nodes = nodes.iter();
                    nodes.fold([0.0; 3], |sum, &(node, n)| {
                        add_scaled(sum, n, body.mesh.points()[node])
                    })
                };
                let own = place(&sample.at.own, &upper);
                let other = place(&sample.at.opposite, &lower);
                assert!(distance(own, sample.point) < 1e-14);
                assert!(distance(other, [own[0], own[1], 1.0]) < 1e-14, "{other:?}");
                assert!((sample.at.gap - 0.25).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_body_without_material_is_not_dented() {
        let mut upper = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        upper.materials.clear();
        let free = Constraints::default();
        let rigid = Rigid::Gap(Field::constant(0.5));
        let against = Against::Obstacle(&rigid, Driven::Still);
        let nonmortar = end(&upper, "bottom", &free);
        let found = samples(nonmortar, against, InitialGap::Measured, 0.0, true).unwrap();
        assert!(found.iter().flatten().all(|sample| sample.dent == 0.0));
    }

    #[test]
    fn gaps_are_measured_between_true_circles_whatever_the_polygons() {
        let (mut outer, mut inner) = (
            ring([0.5, 0.0], [1.1, 2.0], 14),
            ring([0.5, 0.0], [0.5, 1.0], 18),
        );
        let circle = |radius| Surface::Sphere {
            center: [0.5, 0.0],
            radius,
        };
        let free = Constraints::default();
        let gaps = |inner: &Body<2>, outer: &Body<2>| -> Vec<f64> {
            let against = Against::Side(end(outer, "inner", &free));
            let nonmortar = end(inner, "outer", &free);
            let found = samples(nonmortar, against, InitialGap::Measured, 0.0, true).unwrap();
            assert_eq!(found.iter().flatten().count(), 108);
            found.iter().flatten().map(|sample| sample.at.gap).collect()
        };
        // with the polygons alone the gap varies by their distance from the curves
        assert!(
            gaps(&inner, &outer)
                .iter()
                .any(|gap| (gap - 0.1).abs() > 0.01)
        );
        inner
            .surfaces
            .insert("outer".to_string(), Some(circle(1.0)));
        // the outer polygon is nearer than its circle, by 2 % at most
        let mixed = gaps(&inner, &outer);
        assert!(mixed.iter().all(|gap| *gap < 0.1 + 1e-12 && *gap > 0.07));
        outer
            .surfaces
            .insert("inner".to_string(), Some(circle(1.1)));
        for gap in gaps(&inner, &outer) {
            assert!((gap - 0.1).abs() < 1e-13, "{gap}");
        }
    }

    #[test]
    fn an_obstacle_is_seen_from_the_true_circle_and_not_from_its_polygon() {
        let mut inner = ring([0.5, 0.0], [0.5, 1.0], 18);
        let free = Constraints::default();
        let hole = |radius| Rigid::Surface {
            surface: Surface::Sphere {
                center: [0.5, 0.0],
                radius,
            },
            inside: true,
        };
        let largest = |inner: &Body<2>, radius: f64| {
            let rigid = hole(radius);
            let against = Against::Obstacle(&rigid, Driven::Still);
            let nonmortar = end(inner, "outer", &free);
            let found = samples(nonmortar, against, InitialGap::Measured, 0.0, true).unwrap();
            assert_eq!(found.iter().flatten().count(), 108);
            let gaps = found.iter().flatten().map(|sample| sample.at.gap);
            gaps.fold(0.0, |s: f64, gap| s.max((gap - (radius - 1.0)).abs()))
        };
        assert!(largest(&inner, 1.0) > 0.01);
        let circle = Surface::Sphere {
            center: [0.5, 0.0],
            radius: 1.0,
        };
        inner.surfaces.insert("outer".to_string(), Some(circle));
        for radius in [1.0, 1.1] {
            assert!(largest(&inner, radius) < 1e-14);
        }
    }
}
