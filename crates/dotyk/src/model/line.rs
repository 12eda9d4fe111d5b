//! Where a probe is read along: points of a line, or the nodes of a side in their order.
//!
//! A side falls into pieces where its chains end, and at its sharp corners for what depends on the normal: a corner node then
//! stands there twice, with the normal of each of its faces.

use crate::contact::{SHARP, nodal_weights};
use crate::fem::{Analysis, Body, side_facets};
use crate::geometry::{Point, add_scaled, distance, dot, unit};
use crate::mesh::Facet;
use crate::model::error::ProbeError;
use crate::model::locate::Located;

/// A place on a line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Station<const D: usize> {
    /// From the first place.
    pub s: f64,
    /// Undeformed.
    pub point: Point<D>,
    /// What its value is made of; `None` where there is none.
    pub located: Option<Located>,
    /// Outward unit normal of the side; zero on a line.
    pub normal: Point<D>,
    /// ∫N dS over the side, with thickness or 2πr; zero on a line.
    pub share: f64,
    /// It begins a piece.
    pub starts: bool,
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
    located: Vec<Option<Located>>,
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
        normal: [0.0; D],
        share: 0.0,
        starts: k == 0,
    };
    places.map(station).collect()
}

/// The nodes of a side in the order of its chains, middle nodes included, with the means of the facets' unit normals; of a
/// closed chain the first once more at its end. With `corners` the side falls into pieces at its sharp ones, too.
///
/// Errors: a side that is not there or is empty; a side in space.
pub(crate) fn stations_along<const D: usize>(
    body: &Body<D>,
    side: &str,
    analysis: Analysis,
    corners: bool,
) -> Result<Vec<Station<D>>, ProbeError<D>> {
    let mesh = &body.mesh;
    side_facets(mesh, side)?;
    let plane = mesh.in_plane().ok_or(ProbeError::SideInSpace)?;
    let mut stations: Vec<Station<D>> = Vec::new();
    for chain in plane.chain(side).unwrap_or_default() {
        let mut joints = joined(body, &chain.facets, analysis, corners);
        if chain.cyclic {
            close(&mut joints, corners);
        }
        for joint in joints {
            let point = mesh.points()[joint.node];
            let before = stations.last();
            stations.push(Station {
                s: before.map_or(0.0, |last| last.s + distance(last.point, point)),
                point,
                located: Some((vec![joint.node], vec![1.0])),
                normal: unit(joint.normal).unwrap_or([0.0; D]),
                share: joint.share,
                starts: joint.starts,
            });
        }
    }
    Ok(stations)
}

/// A node of a side while its facets are joined.
struct Joint<const D: usize> {
    node: usize,
    /// Sum of the unit normals of the facets that meet here.
    normal: Point<D>,
    share: f64,
    starts: bool,
}

/// The nodes of facets that follow each other.
fn joined<const D: usize>(
    body: &Body<D>,
    facets: &[Facet],
    analysis: Analysis,
    corners: bool,
) -> Vec<Joint<D>> {
    let mesh = &body.mesh;
    let mut joints: Vec<Joint<D>> = Vec::new();
    for &facet in facets {
        let shares = nodal_weights(mesh, [facet], analysis, body.thickness);
        let places = mesh.facet_kind(facet).reference_nodes().iter();
        let normals = places.map(|xi| unit(mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]));
        let mut along: Vec<(usize, Point<D>)> = mesh
            .facet_nodes(facet)
            .map(|node| node as usize)
            .zip(normals)
            .collect();
        // a facet names its ends first
        along[1..].rotate_left(1);
        for (k, (node, normal)) in along.into_iter().enumerate() {
            let share = shares[&node].area;
            match joints.last_mut() {
                Some(last) if k == 0 && !(corners && is_sharp(last.normal, normal)) => {
                    last.normal = add_scaled(last.normal, 1.0, normal);
                    last.share += share;
                }
                _ => joints.push(Joint {
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

/// Gives the two places of the node where a closed chain begins and ends one normal, if there is no corner.
fn close<const D: usize>(joints: &mut [Joint<D>], corners: bool) {
    if let [first, .., last] = joints
        && !(corners && is_sharp(first.normal, last.normal))
    {
        first.normal = add_scaled(first.normal, 1.0, last.normal);
        last.normal = first.normal;
    }
}

/// Two unit normals are those of a sharp corner.
fn is_sharp<const D: usize>(a: Point<D>, b: Point<D>) -> bool {
    dot(a, b) < SHARP
}
