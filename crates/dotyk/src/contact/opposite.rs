//! What lies opposite a side: the line along its contact normal, the facet that it meets, and the gap between.

use crate::contact::curved::TrueSurface;
use crate::contact::normals::Normals;
use crate::contact::obstacle::finite_gap;
use crate::contact::search::{Hit, Line, Search};
use crate::contact::{Against, ContactError, End, InitialGap};
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh};

/// A nonmortar side and what it is paired with, ready to be looked across.
pub(super) struct Opposite<'a, const D: usize> {
    pub nonmortar: End<'a, D>,
    pub against: Against<'a, D>,
    gap: InitialGap<'a>,
    pub time: f64,
    pub normals: Normals<'a, D>,
    /// True surfaces of both sides; none of an obstacle.
    surfaces: [Option<TrueSurface<'a, D>>; 2],
    /// None against an obstacle.
    pub search: Option<Search<'a, D>>,
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
        let mut surfaces = [Some(TrueSurface::of(nonmortar, own)?), None];
        let search = match against {
            Against::Obstacle(..) => None,
            Against::Side(mortar) => {
                let other = mortar.facets()?;
                surfaces[1] = Some(TrueSurface::of(mortar, other)?);
                Some(Search::new(&nonmortar.body.mesh, &mortar.body.mesh, other))
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
        })
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

    /// Where a line from a facet meets the other side's mesh, if it faces it; see [`Search::opposite`].
    pub fn facing(&self, facet: Facet, line: Line<D>) -> Option<Hit> {
        let shallow = self.mesh().facet_length(facet);
        self.search.as_ref()?.opposite(line, shallow)
    }

    /// What of the other side lies opposite ξ of a facet; none where the line misses it, and of an obstacle.
    pub fn at(&self, facet: Facet, xi: &[f64]) -> Result<Option<Found>, ContactError> {
        let line = self.line(facet, xi);
        let (Some(hit), Against::Side(mortar)) = (self.facing(facet, line), self.against) else {
            return Ok(None);
        };
        let place = hit.xi.map(|c| c.clamp(-1.0, 1.0));
        Ok(Some(Found {
            facet: hit.facet,
            nodes: shape(&mortar.body.mesh, hit.facet, &place),
            gap: self.gap_at(facet, line, hit)?,
        }))
    }

    /// The gap at a line from a facet to where it meets the other side.
    pub fn gap_at(&self, facet: Facet, line: Line<D>, hit: Hit) -> Result<f64, ContactError> {
        match self.gap {
            InitialGap::Measured => Ok(self.true_distance(facet, line, hit)),
            InitialGap::Closed => Ok(0.0),
            InitialGap::Given(field) => finite_gap(field, line.start, self.time, self.nonmortar),
        }
    }

    /// The distance along a line from a facet to a hit, between the true surfaces where the sides have them.
    fn true_distance(&self, facet: Facet, line: Line<D>, hit: Hit) -> f64 {
        let [own, other] = &self.surfaces;
        let own = own.as_ref().and_then(|surface| surface.at(facet));
        let other = other.as_ref().and_then(|surface| surface.at(hit.facet));
        let polygons = hit.distance;
        let start = own.map_or(0.0, |surface| line.along(surface.closest(line.start)));
        let nearest = |hits: Vec<f64>| {
            hits.into_iter()
                .min_by(|a, b| (a - polygons).abs().total_cmp(&(b - polygons).abs()))
        };
        let end = other.and_then(|s| nearest(s.intersections(line.start, line.direction)));
        end.unwrap_or(polygons) - start
    }
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
