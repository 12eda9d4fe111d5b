//! The contact normal as a field on the nonmortar side.
//!
//! Where the side has a true surface, its normal. Else unit normals at the nodes, interpolated on each facet: at an end
//! the mean of the facets that meet there, unless they meet at a sharp corner. At the end of a side on a plane of
//! symmetry the polygon's last normal is tilted by half the angle of a facet; it is turned back into that plane, but
//! never by more than the side itself turns there.
//!
//! Source: the bisector rule and the axis direction on the axis, Janovský & Procházka (1980) III, section 7.

use crate::contact::corners::SHARP;
use crate::contact::curved::TrueSurface;
use crate::contact::relative::free_part;
use crate::contact::{ContactError, End};
use crate::geometry::{Point, add_scaled, dot, unit};
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh};
use std::collections::{BTreeMap, HashMap};

/// Outward unit normals of a side.
pub(crate) struct Normals<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    at_nodes: HashMap<Facet, [Point<D>; MAX_FACET_NODES]>,
    surface: TrueSurface<'a, D>,
}

impl<'a, const D: usize> Normals<'a, D> {
    /// Normals of the facets of one end of an interface.
    ///
    /// Errors: nodes off the true surface of the side.
    pub fn new(end: End<'a, D>, facets: &[Facet]) -> Result<Self, ContactError> {
        let mesh = &end.body.mesh;
        let surface = TrueSurface::of(end, facets)?;
        let mut at_nodes: HashMap<Facet, [Point<D>; MAX_FACET_NODES]> = HashMap::new();
        let mut around: BTreeMap<usize, Vec<(Facet, Point<D>)>> = BTreeMap::new();
        for &facet in facets {
            let kind = mesh.facet_kind(facet);
            let own = at_nodes.entry(facet).or_insert([[0.0; D]; _]);
            let places = mesh.facet_nodes(facet).zip(kind.reference_nodes());
            for (normal, (node, xi)) in own.iter_mut().zip(places) {
                *normal = unit(mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]);
                around
                    .entry(node as usize)
                    .or_default()
                    .push((facet, *normal));
            }
        }
        let own = at_nodes.clone();
        for (&facet, normals) in &mut at_nodes {
            for (normal, node) in normals.iter_mut().zip(mesh.facet_nodes(facet)) {
                let meeting = &around[&(node as usize)];
                *normal = match meeting[..] {
                    [_] => turned_back(end, node as usize, facet, &own, &around, *normal),
                    _ => mean(*normal, meeting),
                };
            }
        }
        Ok(Self {
            mesh,
            at_nodes,
            surface,
        })
    }

    /// Normal at ξ of a facet.
    pub fn at(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let kind = self.mesh.facet_kind(facet);
        let mut shape = [0.0; MAX_FACET_NODES];
        kind.shape(xi, &mut shape);
        let nodal = &self.at_nodes[&facet];
        let sum = nodal[..kind.nodes()]
            .iter()
            .zip(shape)
            .fold([0.0; D], |sum, (&n, value)| add_scaled(sum, value, n));
        let normal = unit(sum).unwrap_or(sum);
        match self.surface.at(facet) {
            None => normal,
            Some(surface) => {
                let true_normal = surface.normal(self.mesh.facet_point(facet, xi));
                true_normal.map_or(normal, |n| n.map(|c| c * dot(n, normal).signum()))
            }
        }
    }

    /// Normals at the nodes: the mean of those of the facets that meet there.
    pub fn nodal(&self) -> BTreeMap<usize, Point<D>> {
        let mut facets: Vec<Facet> = self.at_nodes.keys().copied().collect();
        facets.sort_unstable();
        let mut sums: BTreeMap<usize, Point<D>> = BTreeMap::new();
        for facet in facets {
            let kind = self.mesh.facet_kind(facet);
            for (node, xi) in self.mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
                let sum = sums.entry(node as usize).or_insert([0.0; D]);
                *sum = add_scaled(*sum, 1.0, self.at(facet, xi));
            }
        }
        sums.into_iter()
            .filter_map(|(node, sum)| Some((node, unit(sum)?)))
            .collect()
    }
}

/// Mean of a facet's normal and those that meet it without a corner.
fn mean<const D: usize>(own: Point<D>, meeting: &[(Facet, Point<D>)]) -> Point<D> {
    let smooth = meeting.iter().filter(|(_, n)| dot(*n, own) > SHARP);
    let sum = smooth.fold([0.0; D], |sum, (_, n)| add_scaled(sum, 1.0, *n));
    unit(sum).unwrap_or(own)
}

/// The normal at the end of a side, in the directions that the supports leave free, if the side is curved enough for that.
fn turned_back<const D: usize>(
    end: End<'_, D>,
    node: usize,
    facet: Facet,
    own: &HashMap<Facet, [Point<D>; MAX_FACET_NODES]>,
    around: &BTreeMap<usize, Vec<(Facet, Point<D>)>>,
    normal: Point<D>,
) -> Point<D> {
    let held = end.constraints.at(node);
    let Some(free) = free_part(normal, held.iter().map(|h| h.axis)) else {
        return normal;
    };
    let angle = |a: Point<D>, b: Point<D>| dot(a, b).clamp(-1.0, 1.0).acos();
    let neighbours = end.body.mesh.facet_nodes(facet).map(|n| n as usize);
    let turns = neighbours
        .flat_map(|n| &around[&n])
        .flat_map(|(other, _)| &own[other])
        .map(|&other| angle(normal, other));
    let most = turns.filter(|turn| turn.is_finite()).fold(0.0, f64::max);
    let sharp = SHARP.acos();
    if angle(normal, free) <= 1.05 * most.min(sharp) {
        free
    } else {
        normal
    }
}
