//! Places along which a probe is read: points of a line, or the nodes of a side in their order.
//!
//! A side is split where its chains end, at sharp corners for quantities that depend on the normal, and between materials for
//! quantities that depend on these: such a node is listed twice, with the normal of each of its faces and the material of each of
//! its cells.

use crate::contact::nodal_weights;
use crate::fem::{Analysis, Body, SidePoint, side_facets, side_points};
use crate::geometry::{Point, add_scaled, distance, dot, unit};
use crate::mesh::{Facet, Located, SHARP};
use crate::model::nouns::error::ProbeError;
use std::collections::BTreeMap;

/// A place on a line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Station<const D: usize> {
    /// From the first place.
    pub s: f64,
    /// Undeformed.
    pub point: Point<D>,
    /// Nodes and weights of its value; `None` where there is no value.
    pub located: Option<Located<D>>,
    /// ∫N dS over the side, or the part of it that a point of integration stands for, with thickness or 2πr; zero on a line.
    pub share: f64,
    /// It begins a piece.
    pub starts: bool,
}

/// Places where a side is split although its facets go on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Breaks {
    /// At sharp corners.
    pub corners: bool,
    /// Between materials.
    pub materials: bool,
}

impl Breaks {
    /// Between two facets, each with its block and unit normal.
    fn between<const D: usize>(
        self,
        body: &Body<D>,
        a: (usize, Point<D>),
        b: (usize, Point<D>),
    ) -> bool {
        let law = |block: usize| {
            let material = body.material(&body.mesh.blocks()[block]).ok();
            material.map(|material| (material.elastic, material.strength))
        };
        (self.corners && is_sharp(a.1, b.1))
            || (self.materials && a.0 != b.0 && law(a.0) != law(b.0))
    }
}

/// Points at equal distances from one to another, (points,).
pub(crate) fn points_between<const D: usize>(
    from: Point<D>,
    to: Point<D>,
    points: usize,
) -> Vec<Point<D>> {
    let last = points.saturating_sub(1).max(1) as f64;
    let at = |k: usize| {
        let t = k as f64 / last;
        // both ends are exact
        std::array::from_fn(|i| (1.0 - t) * from[i] + t * to[i])
    };
    (0..points).map(at).collect()
}

/// Stations at points, with what was found there.
pub(crate) fn stations_at<const D: usize>(
    points: &[Point<D>],
    located: Vec<Option<Located<D>>>,
) -> Vec<Station<D>> {
    let (last, ends) = (points.len().max(2) - 1, [points.first(), points.last()]);
    let length = match ends {
        [Some(&from), Some(&to)] => distance(from, to),
        _ => 0.0,
    };
    let places = points.iter().zip(located).enumerate();
    let station = |(k, (&point, located))| Station {
        s: length * (k as f64 / last as f64),
        point,
        located,
        share: 0.0,
        starts: k == 0,
    };
    places.map(station).collect()
}

/// The nodes of a side in the order of its chains, middle nodes included, with the means of the facets' unit normals; of a
/// closed chain the first once more at its end.
///
/// In space the nodes have no order and the places no distance along the side: each has only its normal and share.
///
/// Errors: a side that is not there or is empty.
pub(crate) fn stations_along<const D: usize>(
    body: &Body<D>,
    side: &str,
    analysis: Analysis,
    breaks: Breaks,
) -> Result<Vec<Station<D>>, ProbeError<D>> {
    let mesh = &body.mesh;
    let facets = side_facets(mesh, side)?;
    let Some(plane) = mesh.in_plane() else {
        return Ok(scattered(body, facets, analysis, breaks));
    };
    let mut stations: Vec<Station<D>> = Vec::new();
    for chain in plane.chain(side).unwrap_or_default() {
        let mut joints = joined(body, &chain.facets, analysis, breaks);
        if chain.cyclic {
            close(body, &mut joints, breaks);
        }
        for joint in joints {
            let point = mesh.points()[joint.node];
            let before = stations.last();
            stations.push(Station {
                s: before.map_or(0.0, |last| last.s + distance(last.point, point)),
                point,
                located: Some(joint.located()),
                share: joint.share,
                starts: joint.starts,
            });
        }
    }
    Ok(stations)
}

/// The points of integration of a side, each with its part of the area.
///
/// Errors: a side that is not there or is empty.
pub(crate) fn stations_within<const D: usize>(
    body: &Body<D>,
    side: &str,
    analysis: Analysis,
) -> Result<Vec<Station<D>>, ProbeError<D>> {
    let station = |at: SidePoint<D>| {
        let nodes: Vec<usize> = body
            .mesh
            .facet_nodes(at.facet)
            .map(|n| n as usize)
            .collect();
        Station {
            s: f64::NAN,
            point: at.point,
            located: Some(Located {
                block: at.facet.block as usize,
                cell: None,
                shape: at.shape[..nodes.len()].to_vec(),
                nodes,
                normal: at.normal,
                outside: 0.0,
            }),
            share: at.area,
            starts: true,
        }
    };
    Ok(side_points(body, side, analysis)?.map(station).collect())
}

/// The nodes of facets in space, each once for every face that it is on and every material that it is of, where these count.
fn scattered<const D: usize>(
    body: &Body<D>,
    facets: &[Facet],
    analysis: Analysis,
    breaks: Breaks,
) -> Vec<Station<D>> {
    let mut joints: BTreeMap<usize, Vec<Joint<D>>> = BTreeMap::new();
    for &facet in facets {
        let block = facet.block as usize;
        for (node, normal, share) in of_facet(body, facet, analysis) {
            let faces = joints.entry(node).or_default();
            let like = |joint: &&mut Joint<D>| {
                let mean = unit(joint.normal).unwrap_or(normal);
                !breaks.between(body, (joint.block, mean), (block, normal))
            };
            match faces.iter_mut().find(like) {
                Some(face) => face.join(normal, share),
                None => faces.push(Joint {
                    block,
                    node,
                    normal,
                    share,
                    starts: true,
                }),
            }
        }
    }
    let joints = joints.into_values().flatten();
    let station = |joint: Joint<D>| Station {
        s: f64::NAN,
        point: body.mesh.points()[joint.node],
        located: Some(joint.located()),
        share: joint.share,
        starts: true,
    };
    joints.map(station).collect()
}

/// The nodes of a facet with the unit normals there, and their parts of its area.
fn of_facet<const D: usize>(
    body: &Body<D>,
    facet: Facet,
    analysis: Analysis,
) -> Vec<(usize, Point<D>, f64)> {
    let mesh = &body.mesh;
    let shares = nodal_weights(mesh, [facet], analysis, body.thickness);
    let places = mesh.facet_kind(facet).reference_nodes().iter();
    let normals = places.map(|xi| unit(mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]));
    let nodes = mesh.facet_nodes(facet).map(|node| node as usize);
    let nodes = nodes.zip(normals);
    nodes
        .map(|(node, normal)| (node, normal, shares[&node].area))
        .collect()
}

/// A node of a side while its facets are joined.
struct Joint<const D: usize> {
    /// Block of the cell behind its first facet.
    block: usize,
    node: usize,
    /// Sum of the unit normals of the facets that meet here.
    normal: Point<D>,
    share: f64,
    starts: bool,
}

impl<const D: usize> Joint<D> {
    /// Takes one more facet in.
    fn join(&mut self, normal: Point<D>, share: f64) {
        self.normal = add_scaled(self.normal, 1.0, normal);
        self.share += share;
    }

    fn located(&self) -> Located<D> {
        Located::at_node(self.block, self.node, unit(self.normal).unwrap_or([0.0; D]))
    }
}

/// The nodes of facets that follow each other.
fn joined<const D: usize>(
    body: &Body<D>,
    facets: &[Facet],
    analysis: Analysis,
    breaks: Breaks,
) -> Vec<Joint<D>> {
    let mut joints: Vec<Joint<D>> = Vec::new();
    for &facet in facets {
        let mut along = of_facet(body, facet, analysis);
        // a facet names its ends first
        along[1..].rotate_left(1);
        let block = facet.block as usize;
        let goes_on = |last: &Joint<D>, normal| {
            !breaks.between(body, (last.block, last.normal), (block, normal))
        };
        for (k, (node, normal, share)) in along.into_iter().enumerate() {
            match joints.last_mut() {
                Some(last) if k == 0 && goes_on(last, normal) => last.join(normal, share),
                _ => joints.push(Joint {
                    block,
                    node,
                    normal,
                    share,
                    starts: k == 0,
                }),
            }
        }
    }
    joints
}

/// Gives the two places of the node where a closed chain begins and ends one normal, if it goes on there.
fn close<const D: usize>(body: &Body<D>, joints: &mut [Joint<D>], breaks: Breaks) {
    if let [first, .., last] = joints
        && !breaks.between(body, (first.block, first.normal), (last.block, last.normal))
    {
        first.normal = add_scaled(first.normal, 1.0, last.normal);
        last.normal = first.normal;
    }
}

/// Two unit normals are those of a sharp corner.
fn is_sharp<const D: usize>(a: Point<D>, b: Point<D>) -> bool {
    dot(a, b) < SHARP
}
