//! Rigid tools of any shape: a surface of facets, closed or open.
//!
//! A tool is paired as the side of a body whose nodes all move alike: the rows on its nodes, summed, are rows on its translation, and
//! the moments that the tangential rows take over from one facet to the other vanish in the sum. Edges and corners of a tool between
//! two nodes of a body so press where they are.

use crate::contact::search::{Line, NEAR, Screen};
use crate::contact::{ContactError, Driven, End, Interface, Row};
use crate::fem::{Body, Constraints, Held};
use crate::geometry::{Point, Surface, add_scaled, unit};
use crate::mesh::{Facet, Mesh, MeshError, Skin, Surrounding};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// The side of a tool.
const SIDE: &str = "surface";

/// A line that meets a facet with a cosine above this comes from behind it.
const BEHIND: f64 = 0.1;

/// The surface of a rigid tool.
#[derive(Debug)]
pub struct Tool<const D: usize> {
    body: Body<D>,
    skin: Skin<D>,
    /// All directions of all nodes are held: at rest, and moved.
    held: [Constraints<D>; 2],
    free: Constraints<D>,
    /// For distances; made on first use.
    near: OnceLock<Surrounding<D>>,
}

impl<const D: usize> PartialEq for Tool<D> {
    fn eq(&self, other: &Self) -> bool {
        self.body.mesh == other.body.mesh
    }
}

impl<const D: usize> Tool<D> {
    /// A tool with a name, of these facets: segments with the solid on their left, or triangles that turn outwards, by their corners;
    /// and the true curves behind some of them.
    ///
    /// Errors: facets without a length or area, coordinates that are not finite.
    pub fn new(
        name: &str,
        points: Vec<Point<D>>,
        facets: &[[u32; D]],
        curves: &BTreeMap<usize, Surface<D>>,
    ) -> Result<Self, MeshError> {
        let mesh = Mesh::shell(SIDE, points, facets, curves)?;
        let held = [true, false].map(|still| held(&mesh, still));
        Ok(Self {
            skin: Skin::of(&mesh),
            body: Body::of(name, mesh.into()),
            held,
            free: Constraints::default(),
            near: OnceLock::new(),
        })
    }

    /// Its surface.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.body.mesh
    }

    /// It as a side of a body.
    pub(super) fn end(&self, driven: Driven) -> End<'_, D> {
        End {
            body: &self.body,
            side: SIDE,
            constraints: match driven {
                Driven::Free => &self.free,
                Driven::Still => &self.held[0],
                Driven::Prescribed => &self.held[1],
            },
            part: None,
        }
    }

    fn near(&self) -> &Surrounding<D> {
        let everywhere = ([f64::NEG_INFINITY; D], [f64::INFINITY; D]);
        self.near
            .get_or_init(|| self.skin.at(self.mesh().points(), everywhere))
    }

    /// Distance of a point, negative behind the surface; beyond the end of an open one positive.
    pub fn distance(&self, point: Point<D>) -> f64 {
        let found = self.near().depth(point);
        found.map_or(f64::INFINITY, |(depth, _)| -depth)
    }

    /// The nearest point of the surface.
    pub fn closest(&self, point: Point<D>) -> Point<D> {
        self.near().closest(point).map_or(point, |(at, _)| at)
    }

    /// The outward unit normal of the nearest facet.
    pub fn normal(&self, point: Point<D>) -> Option<Point<D>> {
        self.near()
            .closest(point)
            .and_then(|(_, normal)| unit(normal))
    }

    /// Errors: lines from the facets of a side meet the tool in front of it, and all of them its back first.
    pub fn check_turned(&self, end: End<'_, D>) -> Result<(), ContactError> {
        let screen = Screen::new(self.mesh(), &self.mesh().boundary_facets());
        let mesh = &end.body.mesh;
        let meets_back = |&facet: &Facet| {
            let centre = mesh.facet_kind(facet).domain().centre();
            let direction = unit(mesh.outward_normal(facet, &centre))?;
            let start = mesh.facet_point(facet, &centre);
            let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
            let met = screen.meets(Line { start, direction }, everywhere, |cosine| {
                cosine.abs() > BEHIND
            });
            let first = met
                .into_iter()
                .min_by(|a, b| a.0.distance.abs().total_cmp(&b.0.distance.abs()));
            let rounding = NEAR * mesh.facet_length(facet);
            first.map(|(hit, cosine)| cosine > 0.0 && hit.distance >= -rounding)
        };
        let met: Vec<bool> = end.facets()?.par_iter().filter_map(meets_back).collect();
        match !met.is_empty() && met.iter().all(|&back| back) {
            false => Ok(()),
            true => Err(ContactError::Turned {
                tool: self.body.name.clone(),
                side: end.name(),
            }),
        }
    }

    /// Its surface as simplices.
    pub(crate) fn skin(&self) -> &Skin<D> {
        &self.skin
    }
}

/// All directions of all nodes.
fn held<const D: usize>(mesh: &Mesh<D>, still: bool) -> Constraints<D> {
    let along = |d: usize| Held {
        axis: std::array::from_fn(|i| f64::from(u8::from(i == d))),
        value: 0.0,
        terms: 0.0,
        still,
        supports: Vec::new(),
    };
    let nodes = 0..mesh.points().len();
    Constraints {
        nodes: nodes
            .map(|node| (node, (0..D).map(along).collect()))
            .collect(),
    }
}

impl<const D: usize> Interface<D> {
    /// The interface with a tool as one with its translation, which is its node 0.
    pub(super) fn on_translation(mut self) -> Self {
        let sum = |row: &mut Row<D>| {
            let whole = row
                .iter()
                .fold([0.0; D], |sum, (_, part)| add_scaled(sum, 1.0, *part));
            *row = vec![(0, whole)];
        };
        self.mortar.iter_mut().for_each(sum);
        self.implied
            .iter_mut()
            .for_each(|implied| sum(&mut implied.rows[1]));
        let opposite = self.nodes.iter_mut().map(|node| &mut node.opposite);
        let opposite = opposite.chain(self.points.iter_mut().map(|point| &mut point.opposite));
        let faced = opposite.filter(|opposite| !opposite.is_empty());
        faced.for_each(|opposite| *opposite = vec![(0, 1.0)]);
        self
    }
}
