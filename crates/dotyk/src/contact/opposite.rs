//! The opposite of a side: the line along its contact normal, the facet that it meets, and the gap in between.

use crate::contact::corners::{SAME_DIRECTION, leaning, surfaces};
use crate::contact::curved::true_surface;
use crate::contact::normals::Normals;
use crate::contact::obstacle::{Rigid, beyond, finite_gap};
use crate::contact::search::{Hit, Line, SideSearch};
use crate::contact::{Against, ContactError, End, GapPoint, InitialGap};
use crate::fem::TrueSurface;
use crate::geometry::{Point, add_scaled, distance, dot, unit};
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh};
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

/// A nonmortar side and its opposite, prepared for the search.
pub(super) struct Opposite<'a, const D: usize> {
    pub nonmortar: End<'a, D>,
    pub against: Against<'a, D>,
    gap: InitialGap<'a>,
    pub time: f64,
    pub normals: Normals<'a, D>,
    /// True surfaces of both sides; `None` for an obstacle.
    surfaces: [Option<TrueSurface<'a, D>>; 2],
    /// None against an obstacle.
    pub search: Option<SideSearch<'a, D>>,
    /// Nodes of both sides, such as those at the tip of a slit.
    pub common: BTreeSet<usize>,
}

/// Nodes of two sides of one body.
fn common_nodes<const D: usize>(
    a: End<'_, D>,
    b: End<'_, D>,
) -> Result<BTreeSet<usize>, ContactError> {
    match std::ptr::eq(a.body, b.body) {
        true => Ok(&a.nodes()? & &b.nodes()?),
        false => Ok(BTreeSet::new()),
    }
}

impl<'a, const D: usize> Opposite<'a, D> {
    /// Errors: unknown or empty sides, nodes off their true surface.
    pub fn new(
        nonmortar: End<'a, D>,
        against: Against<'a, D>,
        gap: InitialGap<'a>,
        time: f64,
    ) -> Result<Self, ContactError> {
        let own = nonmortar.facets()?;
        let against = against.paired();
        let mut surfaces = [Some(true_surface(nonmortar, own)?), None];
        let mut common = BTreeSet::new();
        let search = match against {
            Against::Obstacle(..) => None,
            Against::Side(mortar) => {
                let other = mortar.facets()?;
                surfaces[1] = Some(true_surface(mortar, other)?);
                common = common_nodes(nonmortar, mortar)?;
                Some(SideSearch::new(
                    &nonmortar.body.mesh,
                    &mortar.body.mesh,
                    other,
                ))
            }
        };
        Ok(Self {
            nonmortar,
            against,
            gap,
            time,
            normals: Normals::new(nonmortar, own)?,
            surfaces,
            search,
            common,
        })
    }

    /// Corners of the side that meet the other one between the faces of the body, by node. A gap that is given is one along the normals of
    /// the side: its corners do not lean.
    ///
    /// Errors: those of both sides; a gap that is not finite.
    pub fn corners(&self) -> Result<BTreeMap<usize, Corner<D>>, ContactError> {
        let (Against::Side(mortar), Some(search)) = (self.against, &self.search) else {
            return Ok(BTreeMap::new());
        };
        if matches!(self.gap, InitialGap::Given(_)) {
            return Ok(BTreeMap::new());
        }
        // flat sides do not ask for them
        let others = OnceCell::new();
        let others = || others.get_or_init(|| Smooth::of(mortar).ok()).as_ref();
        let flat = |hit: &Hit| unit(mortar.body.mesh.outward_normal(hit.facet, &hit.xi));
        let meets = |facet: Facet, line: Line<D>, of: Option<Facet>| {
            let shallow = self.mesh().facet_length(facet);
            let Some(of) = of else {
                let hit = self.most_opposed(search, line, shallow)?;
                let own = flat(&hit)?.map(|c| -c);
                return match distance(own, line.direction) <= SAME_DIRECTION {
                    true => Some((hit, own)),
                    false => Some((hit, others()?.against(&hit))),
                };
            };
            let others = others()?;
            let on = |facet: Facet| others.surface_of[&of] == others.surface_of[&facet];
            let hit = search.opposite_among(line, shallow, on)?;
            Some((hit, others.against(&hit)))
        };
        let mut corners = BTreeMap::new();
        for (node, found) in leaning(self.nonmortar, &self.normals, &meets)? {
            if self.common.contains(&node) {
                continue;
            }
            let (start, hit) = (self.mesh().points()[node], found.hit);
            let direction = found.along;
            let away = self.gap_at(found.facet, Line { start, direction }, hit)?;
            let place = hit.xi.map(|c| c.clamp(-1.0, 1.0));
            let at = GapPoint {
                own: vec![(node, 1.0)],
                opposite: shape(&mortar.body.mesh, hit.facet, &place),
                normal: found.direction,
                // to the plane that touches the surface there
                gap: away * dot(direction, found.direction),
            };
            let along = direction;
            corners.insert(node, Corner { at, along, hit });
        }
        Ok(corners)
    }

    /// The opposite of a point; where several facets meet at one place, the one most nearly opposed to the line.
    fn most_opposed(&self, search: &SideSearch<'a, D>, line: Line<D>, shallow: f64) -> Option<Hit> {
        let Against::Side(mortar) = self.against else {
            return None;
        };
        let opposed = |facet: Facet| {
            let centre = mortar.body.mesh.facet_kind(facet).domain().centre();
            let normal = unit(mortar.body.mesh.outward_normal(facet, &centre));
            -dot(normal.unwrap_or([0.0; D]), line.direction)
        };
        let mut hit = search.opposite(line, shallow)?;
        loop {
            let more = opposed(hit.facet) + SAME_DISTANCE;
            let other = search.opposite_among(line, shallow, |facet| opposed(facet) > more);
            let there =
                |other: &Hit| (other.distance - hit.distance).abs() <= SAME_DISTANCE * shallow;
            match other.filter(there) {
                Some(other) => hit = other,
                None => return Some(hit),
            }
        }
    }

    /// With lines that lead over to the directions of these corners on the facets beside them.
    ///
    /// Errors: as [`Self::corners`].
    pub fn leaning(mut self) -> Result<Self, ContactError> {
        let corners = self.corners()?;
        if !corners.is_empty() {
            let corners = corners.into_iter();
            let directions = corners.map(|(node, corner)| (node, corner.at.normal));
            self.normals.lean(&directions.collect());
        }
        Ok(self)
    }

    /// The smooth surface of each facet of the other side's mesh, by the index of its first one; `None` before an obstacle without facets.
    pub fn surfaces_opposite(&self) -> Option<BTreeMap<Facet, usize>> {
        let Against::Side(mortar) = self.against else {
            return None;
        };
        let facets = mortar.facets().ok()?.iter().copied();
        Some(facets.zip(surfaces(mortar).ok()?.first).collect())
    }

    pub fn mesh(&self) -> &'a Mesh<D> {
        &self.nonmortar.body.mesh
    }

    /// The line from ξ of a facet along the contact normal.
    pub fn line(&self, facet: Facet, xi: &[f64]) -> Line<D> {
        Line {
            start: self.mesh().facet_point(facet, xi),
            direction: self.normals.at(facet, xi),
        }
    }

    /// The hit of a line from a facet on the other side's mesh, if it faces it; see [`SideSearch::opposite`].
    pub fn facing(&self, facet: Facet, line: Line<D>) -> Option<Hit> {
        let shallow = self.mesh().facet_length(facet);
        self.search.as_ref()?.opposite(line, shallow)
    }

    /// The place of the other side opposite ξ of a facet; `None` where the line misses it, and for an obstacle.
    pub fn at(&self, facet: Facet, xi: &[f64]) -> Result<Option<Found>, ContactError> {
        self.at_among(facet, xi, |_| true)
    }

    /// The same if the place belongs to some facets of the other side: of several that meet there the search finds one.
    pub fn at_among(
        &self,
        facet: Facet,
        xi: &[f64],
        among: impl Fn(Facet) -> bool,
    ) -> Result<Option<Found>, ContactError> {
        let line = self.line(facet, xi);
        let (Some(search), Against::Side(mortar)) = (&self.search, self.against) else {
            return Ok(None);
        };
        let Some(nearest) = self.facing(facet, line) else {
            return Ok(None);
        };
        let there = |hit: &Hit| {
            let beside = (hit.distance - nearest.distance).abs();
            beside <= SAME_DISTANCE * mortar.body.mesh.facet_length(hit.facet)
        };
        let hit = match among(nearest.facet) {
            true => Some(nearest),
            false => search.opposite_among(line, f64::INFINITY, among),
        };
        let Some(hit) = hit.filter(there) else {
            return Ok(None);
        };
        let place = hit.xi.map(|c| c.clamp(-1.0, 1.0));
        Ok(Some(Found {
            facet: hit.facet,
            nodes: shape(&mortar.body.mesh, hit.facet, &place),
            gap: self.gap_at(facet, line, hit)?,
        }))
    }

    /// The gap along a line from a facet to its hit on the other side.
    pub fn gap_at(&self, facet: Facet, line: Line<D>, hit: Hit) -> Result<f64, ContactError> {
        match self.gap {
            InitialGap::Measured => Ok(self.true_distance(facet, line, hit)),
            InitialGap::Adjusted(most) => Ok(beyond(most, self.true_distance(facet, line, hit))),
            InitialGap::Closed => Ok(0.0),
            InitialGap::Given(field) => finite_gap(field, line.start, self.time, self.nonmortar),
        }
    }

    /// The distance along a line from a facet to a hit, between the true surfaces where the sides have them.
    fn true_distance(&self, facet: Facet, line: Line<D>, hit: Hit) -> f64 {
        let [own, other] = &self.surfaces;
        let other = other.as_ref().and_then(|surface| surface.at(hit.facet));
        let polygons = hit.distance;
        let start = rise(own, facet, line);
        let nearest = |hits: Vec<f64>| {
            hits.into_iter()
                .min_by(|a, b| (a - polygons).abs().total_cmp(&(b - polygons).abs()))
        };
        let end = other.and_then(|s| nearest(s.intersections(line.start, line.direction)));
        end.unwrap_or(polygons) - start
    }

    /// Contact normal and gap along a line from a facet to the obstacle, from the true surface if the side has one; `None` where the
    /// line misses, and if the opposite is a side.
    ///
    /// Errors: a gap that is not finite.
    pub fn obstacle(
        &self,
        facet: Facet,
        line: Line<D>,
    ) -> Result<Option<(Point<D>, f64)>, ContactError> {
        let Against::Obstacle(rigid, _) = self.against else {
            return Ok(None);
        };
        let start = match rigid {
            // a tool is paired as a side
            Rigid::Gap(_) | Rigid::Tool(_) => line.start,
            Rigid::Surface { .. } => {
                let rise = rise(&self.surfaces[0], facet, line);
                add_scaled(line.start, rise, line.direction)
            }
        };
        rigid.opposite((start, line.direction), self.time, self.nonmortar)
    }
}

/// Distances along a line that differ by less than this part of a facet are equal: facets meet at their edges up to rounding.
const SAME_DISTANCE: f64 = 1e-6;

/// Distance along a line by which the true surface of its side lies in front of its starting facet; zero without a known surface.
fn rise<const D: usize>(surface: &Option<TrueSurface<'_, D>>, facet: Facet, line: Line<D>) -> f64 {
    let surface = surface.as_ref().and_then(|surface| surface.at(facet));
    surface.map_or(0.0, |surface| line.along(surface.closest(line.start)))
}

/// A side by its smooth surfaces.
struct Smooth<'a, const D: usize> {
    normals: Normals<'a, D>,
    /// The first facet of the surface of each, by index.
    surface_of: BTreeMap<Facet, usize>,
}

impl<'a, const D: usize> Smooth<'a, D> {
    /// Errors: an unknown or empty side, nodes off its true surface.
    fn of(end: End<'a, D>) -> Result<Self, ContactError> {
        let facets = end.facets()?;
        let surfaces = surfaces(end)?.first;
        Ok(Self {
            normals: Normals::new(end, facets)?,
            surface_of: facets.iter().copied().zip(surfaces).collect(),
        })
    }

    /// The direction against the surface where a line meets it.
    fn against(&self, hit: &Hit) -> Point<D> {
        self.normals.nearby(hit.facet, &hit.xi).map(|c| -c)
    }
}

/// A corner that meets the other side between the faces of its body.
pub(super) struct Corner<const D: usize> {
    /// It and the place that it meets, along the direction there.
    pub at: GapPoint<D>,
    /// The line along which it was found, and where it meets the other side.
    pub along: Point<D>,
    pub hit: Hit,
}

/// A place of the other side.
pub(super) struct Found {
    pub facet: Facet,
    /// Its nodes, with their shape functions there.
    pub nodes: Vec<(usize, f64)>,
    pub gap: f64,
}

/// Nodes of a facet with their shape functions at ξ.
pub(super) fn shape<const D: usize>(mesh: &Mesh<D>, facet: Facet, xi: &[f64]) -> Vec<(usize, f64)> {
    let mut values = [0.0; MAX_FACET_NODES];
    mesh.facet_kind(facet).shape(xi, &mut values);
    let nodes = mesh.facet_nodes(facet).map(|node| node as usize);
    nodes.zip(values).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{end, flat, node_at, wall};
    use crate::fem::Constraints;
    use crate::geometry::{Field, Surface};
    use crate::mesh::CellKind;

    #[test]
    fn overlaps_up_to_the_length_of_a_facet_are_believed() {
        // of a thin body, so that the line has left it
        for (depth, found) in [(0.9, true), (1.1, false)] {
            let upper = flat(&[0.0, 1.0, 2.0], 0.1, CellKind::Quad4);
            let points = [[0.0, depth], [0.7, depth], [2.0, depth]];
            let lower = wall(&points, -0.2, CellKind::Quad4);
            let free = Constraints::default();
            let against = Against::Side(end(&lower, "bottom", &free));
            let nonmortar = end(&upper, "bottom", &free);
            let sides = Opposite::new(nonmortar, against, InitialGap::Measured, 0.0).unwrap();
            for &facet in nonmortar.facets().unwrap() {
                let at = sides.at(facet, &[0.3]).unwrap();
                assert_eq!(at.is_some(), found, "{depth}");
                if let Some(at) = at {
                    assert!((at.gap + depth).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn what_lies_opposite_has_its_nodes_and_the_gap_that_is_asked_for() {
        let (upper, lower) = (
            flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4),
            wall(&[[-1.0, -0.5], [3.0, -0.5]], -2.0, CellKind::Quad4),
        );
        let free = Constraints::default();
        let field = Field::function("x + 10 t", |p, t| p[0] + 10.0 * t);
        for (gap, expected) in [
            (InitialGap::Measured, 0.5),
            (InitialGap::Closed, 0.0),
            (InitialGap::Given(&field), 21.5),
        ] {
            let against = Against::Side(end(&lower, "bottom", &free));
            let nonmortar = end(&upper, "bottom", &free);
            let sides = Opposite::new(nonmortar, against, gap, 2.0).unwrap();
            let facet = nonmortar.facets().unwrap()[1];
            let at = sides.at(facet, &[0.0]).unwrap().unwrap();
            assert_eq!(at.gap, expected);
            assert_eq!(at.facet, lower.mesh.side("bottom").unwrap()[0]);
            // x = 1.5 between −1 and 3
            for (place, share) in [([-1.0, -0.5], 0.375), ([3.0, -0.5], 0.625)] {
                let node = node_at(&lower, place);
                let found = at.nodes.iter().find(|(j, _)| *j == node).unwrap().1;
                assert!((found - share).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn gaps_lie_between_true_surfaces() {
        let plane = |height: f64| Surface::Plane {
            point: [7.0, height],
            normal: [0.0, 1.0],
        };
        let circle = Surface::Sphere {
            center: [0.5, -2.0],
            radius: 1.0,
        };
        // the circle is 1 below the middle, its polygon 0.00125 lower
        let near = -2.0 + f64::sqrt(1.0 - 0.05 * 0.05);
        let chord = [[0.45, near], [0.55, near]];
        let long: [Point<2>; 2] = [[-4.5, -1.0], [5.5, -1.0]];
        let free = Constraints::default();
        for (own, points, other, gap) in [
            (None, long, None, 1.0),
            (Some(plane(0.005)), long, None, 1.005),
            (Some(plane(-0.005)), long, Some(plane(-1.003)), 0.998),
            (None, long, Some(plane(-1.003)), 1.003),
            // of the two sides of the circle the one near the polygon
            (None, chord, Some(circle), 1.0),
        ] {
            let mut upper = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
            let mut lower = wall(&points, -3.0, CellKind::Quad4);
            upper
                .surfaces
                .extend(own.map(|s| ("bottom".to_string(), Some(s))));
            lower
                .surfaces
                .extend(other.map(|s| ("bottom".to_string(), Some(s))));
            let against = Against::Side(end(&lower, "bottom", &free));
            let nonmortar = end(&upper, "bottom", &free);
            let sides = Opposite::new(nonmortar, against, InitialGap::Measured, 0.0).unwrap();
            let facet = nonmortar.facets().unwrap()[0];
            let at = sides.at(facet, &[0.0]).unwrap().unwrap();
            assert!((at.gap - gap).abs() < 1e-14, "{}", at.gap);
        }
    }

    #[test]
    fn an_obstacle_has_no_nodes_to_be_found() {
        let (upper, free) = (
            flat(&[0.0, 1.0], 1.0, CellKind::Quad4),
            Constraints::default(),
        );
        let rigid = crate::contact::Rigid::Gap(Field::constant(1.0));
        let against = Against::Obstacle(&rigid, crate::contact::Driven::Still);
        let nonmortar = end(&upper, "bottom", &free);
        let sides = Opposite::new(nonmortar, against, InitialGap::Measured, 0.0).unwrap();
        let facet = nonmortar.facets().unwrap()[0];
        assert!(sides.at(facet, &[0.0]).unwrap().is_none());
    }
}
