//! The faces of a contact in space: values at their nodes, and the part of them that is shown.
//!
//! The nonmortar side carries the values. On the other side a node has those of the point of the nonmortar side that is
//! nearest to it, by the triangles around the nearest node; no value where it does not face that side.
//! Where a small part of a side touches, its picture is a cutout: that part with its surroundings.

use crate::geometry::{Point, add_scaled, bounding_box, cross, distance, dot, norm, sub, unit};
use crate::mesh::{Facet, Mesh};
use crate::model::{ContactNode, ContactSolution, OnSide, SideRef, Status};
use crate::output::interface::length_scale;
use crate::output::json::{in_contact, largest};
use crate::output::space::camera::Camera;
use crate::output::space::scene::Scene;
use crate::output::space::skin::{Lattices, Skin};
use crate::output::text::without_noise;
use crate::output::view::Box2;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// If the closed part is smaller than this part of a side, the rest is cut away.
const SMALL_PART: f64 = 0.5;

/// Surroundings of the closed part on all sides, as a part of its size.
const AROUND: f64 = 0.3;

/// Facets whose mean unit normal is longer lie almost in a plane.
const FLAT_FACE: f64 = 0.97;

/// A side with the values of the contact at its nodes; NaN and `None` without a value.
pub struct Face<'a> {
    /// `body.side`, and from where it is seen.
    pub title: String,
    /// Index of the body.
    pub body: usize,
    /// Its facets.
    pub skin: Skin<'a>,
    /// By node of the body.
    pub pressure: Vec<f64>,
    /// By node of the body; rounding is set to zero.
    pub gap: Vec<f64>,
    /// By node of the body.
    pub status: Vec<Option<Status>>,
    /// The visible part.
    pub view: View,
}

/// The visible part of a side, and its camera.
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Its box on paper, in units of length.
    pub extent: Box2,
    /// Parts of the side lie outside.
    pub cutout: bool,
}

impl View {
    /// Of a side whose nodes have these states; `other`: from another direction.
    fn of(mesh: &Mesh<3>, facets: &[Facet], status: &[Option<Status>], other: bool) -> Self {
        let some = |is: &dyn Fn(Status) -> bool| -> Vec<Facet> {
            let node = |n: u32| status[n as usize].is_some_and(is);
            let own = |facet: &&Facet| mesh.facet_nodes(**facet).any(node);
            facets.iter().filter(own).copied().collect()
        };
        let known = match some(&|_| true) {
            none if none.is_empty() => facets.to_vec(),
            known => known,
        };
        let touching = some(&in_contact);
        let cutout =
            !touching.is_empty() && size(mesh, &touching) < SMALL_PART * size(mesh, &known);
        let seen = if cutout { &touching } else { &known };
        let cameras = cameras(mesh, if cutout { seen } else { facets }, cutout);
        let camera = cameras[usize::from(other)];
        let on_paper = |facets: &[Facet]| {
            let points = facets.iter().flat_map(|&facet| mesh.facet_points(facet));
            camera.extent(points)
        };
        let mut extent = on_paper(seen);
        if cutout {
            extent = surrounded(extent, on_paper(&known));
        }
        Self {
            camera,
            extent,
            cutout,
        }
    }

    /// A node of the side at this place is in sight.
    pub fn sees(&self, point: Point<3>) -> bool {
        let [x, y, _] = self.camera.turned(point);
        let (low, high) = self.extent;
        x >= low[0] && x <= high[0] && y >= low[1] && y <= high[1]
    }
}

/// Diagonal of the box around facets.
fn size(mesh: &Mesh<3>, facets: &[Facet]) -> f64 {
    let points = facets.iter().flat_map(|&facet| mesh.facet_points(facet));
    let (low, high) = bounding_box(&points.collect::<Vec<_>>());
    distance(low, high)
}

/// A box with its surroundings, within the given limits.
fn surrounded((low, high): Box2, (least, most): Box2) -> Box2 {
    let room = AROUND * (high[0] - low[0]).max(high[1] - low[1]);
    (
        [0, 1].map(|i| (low[i] - room).max(least[i])),
        [0, 1].map(|i| (high[i] + room).min(most[i])),
    )
}

impl Face<'_> {
    /// The largest of some values at nodes of the side that are in sight.
    pub fn largest_in_sight(&self, values: &[f64]) -> f64 {
        let mesh = self.skin.mesh;
        let known = self.status.iter().zip(mesh.points()).zip(values);
        let seen = known.filter(|((status, point), _)| status.is_some() && self.view.sees(**point));
        largest(seen.map(|(_, value)| *value))
    }
}

/// The nonmortar side, then the mortar side; of a contact with an obstacle the first alone, from two directions.
pub fn faces<'a>(scene: &Scene<'a>, contact: &ContactSolution<3>) -> Option<Vec<Face<'a>>> {
    let own = &contact.nonmortar;
    let skin = side_skin(scene, own)?;
    let mesh = skin.mesh;
    let nodes = mesh.points().len();
    let (mut pressure, mut gap) = (vec![f64::NAN; nodes], vec![f64::NAN; nodes]);
    let mut status = vec![None; nodes];
    let rounding = length_scale(contact.nodes.iter());
    // NaN stays NaN
    let opened = |node: &ContactNode<3>| match node.gap {
        gap if gap < 0.0 => 0.0,
        gap => without_noise(gap, rounding),
    };
    for node in &contact.nodes {
        pressure[node.node] = node.pressure;
        gap[node.node] = opened(node);
        status[node.node] = Some(node.status);
    }
    for place in OnSide::new(mesh, contact).between() {
        pressure[place.node] = place.mean(|node| node.pressure);
        gap[place.node] = place.mean(opened);
    }
    let name = |side: &SideRef| format!("{}.{}", scene.model.bodies[side.body.0].name, side.side);
    let nonmortar = Face {
        title: name(own),
        body: own.body.0,
        view: View::of(mesh, &skin.facets, &status, false),
        skin,
        pressure,
        gap,
        status,
    };
    let other = match contact
        .mortar
        .as_ref()
        .and_then(|m| Some((m, side_skin(scene, m)?)))
    {
        Some((mortar, skin)) => carried(&nonmortar, mortar, skin, name(mortar)),
        // from straight above there is no other direction
        None if nonmortar.view.cutout => return Some(vec![nonmortar]),
        None => Face {
            title: format!("{}, another direction", name(own)),
            skin: side_skin(scene, own)?,
            pressure: nonmortar.pressure.clone(),
            gap: nonmortar.gap.clone(),
            status: nonmortar.status.clone(),
            view: View::of(mesh, &nonmortar.skin.facets, &nonmortar.status, true),
            ..nonmortar
        },
    };
    Some(vec![nonmortar, other])
}

fn side_skin<'a>(scene: &Scene<'a>, side: &SideRef) -> Option<Skin<'a>> {
    let body = scene.model.bodies.get(side.body.0)?;
    let facets = scene.side(side.body.0, &side.side);
    (!facets.is_empty()).then(|| Skin::new(&body.mesh, facets.to_vec()))
}

/// Two directions that show facets: about their mean normal, or the usual ones where they have none. A cutout that is almost
/// plane is seen from straight above, where lengths are true.
fn cameras(mesh: &Mesh<3>, facets: &[Facet], cutout: bool) -> [Camera; 2] {
    let (mut sum, mut area) = ([0.0; 3], 0.0);
    for &facet in facets {
        let normal = mesh.outward_normal(facet, &mesh.facet_kind(facet).domain().centre());
        sum = add_scaled(sum, 1.0, normal);
        area += norm(normal);
    }
    let mean = sum.map(|s| s / area);
    let [x, y, z] = mean;
    match norm(mean) {
        r if cutout && r > FLAT_FACE => [Camera::from(mean); 2],
        r if r < 0.3 => [Camera::around(32.0, 26.0), Camera::around(-148.0, 26.0)],
        r if z.abs() > 0.75 * r => [32.0, -148.0].map(|a| Camera::around(a, 52.0_f64.copysign(z))),
        _ => {
            let own = x.atan2(-y).to_degrees();
            let lift = 24.0 + 0.5 * z.asin().to_degrees();
            [
                Camera::around(own + 30.0, lift),
                Camera::around(own - 30.0, lift),
            ]
        }
    }
}

/// The other side with the values of the nearest points.
fn carried<'a>(from: &Face<'_>, mortar: &SideRef, skin: Skin<'a>, title: String) -> Face<'a> {
    let mesh = skin.mesh;
    let count = mesh.points().len();
    let (mut pressure, mut gap) = (vec![f64::NAN; count], vec![f64::NAN; count]);
    let mut status = vec![None; count];
    let nearest = Nearest::new(&from.skin);
    let nodes = skin
        .facets
        .iter()
        .flat_map(|&facet| mesh.facet_nodes(facet));
    for node in nodes.map(|n| n as usize) {
        let Some(on) = nearest.on(mesh.points()[node]) else {
            continue;
        };
        let value = |values: &[f64]| on.iter().map(|&(n, w)| w * values[n]).sum();
        pressure[node] = value(&from.pressure);
        gap[node] = value(&from.gap);
        let near = on.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        status[node] = near.and_then(|&(n, _)| from.status[n]);
    }
    Face {
        title,
        body: mortar.body.0,
        view: View::of(mesh, &skin.facets, &status, false),
        skin,
        pressure,
        gap,
        status,
    }
}

/// Triangles of a side by their corners.
struct Nearest<'a> {
    mesh: &'a Mesh<3>,
    tree: RTree<GeomWithData<[f64; 3], usize>>,
    /// Triangles at each corner, by the order of the tree's data.
    around: Vec<Vec<[usize; 3]>>,
}

impl<'a> Nearest<'a> {
    fn new(skin: &Skin<'a>) -> Self {
        let mesh = skin.mesh;
        let mut around: Vec<Vec<[usize; 3]>> = vec![Vec::new(); mesh.points().len()];
        let mut lattices = Lattices::default();
        for &facet in &skin.facets {
            let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|n| n as usize).collect();
            let lattice = lattices.of(mesh.facet_kind(facet), 0);
            for triangle in &lattice.triangles {
                let corners = triangle.map(|i| nodes[i]);
                corners.iter().for_each(|&n| around[n].push(corners));
            }
        }
        let corners = around
            .iter()
            .enumerate()
            .filter(|(_, list)| !list.is_empty());
        let corners = corners.map(|(n, _)| GeomWithData::new(mesh.points()[n], n));
        Self {
            mesh,
            tree: RTree::bulk_load(corners.collect()),
            around,
        }
    }

    /// The nearest point of the side as weights of three nodes; `None` where it lies beside the foot of the normal by more
    /// than half an edge.
    fn on(&self, point: Point<3>) -> Option<[(usize, f64); 3]> {
        let corner = self.tree.nearest_neighbor(point)?.data;
        let at = |n: usize| self.mesh.points()[n];
        let candidates = self.around[corner].iter().map(|triangle| {
            let corners = triangle.map(at);
            let weights = closest(corners, point);
            let foot = (0..3).fold([0.0; 3], |sum, i| add_scaled(sum, weights[i], corners[i]));
            (distance(foot, point), foot, corners, weights, triangle)
        });
        let (_, foot, corners, weights, triangle) =
            candidates.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let normal = unit(cross(
            sub(corners[1], corners[0]),
            sub(corners[2], corners[0]),
        ))?;
        let away = sub(point, foot);
        let beside = norm(add_scaled(away, -dot(away, normal), normal));
        let edge = distance(corners[0], corners[1]).max(distance(corners[0], corners[2]));
        (beside <= 0.5 * edge).then(|| [0, 1, 2].map(|i| (triangle[i], weights[i])))
    }
}

/// Weights of the corners in the point of a triangle that is nearest to a point.
///
/// Source: C. Ericson, Real-Time Collision Detection (2005), section 5.1.5, as described in.
fn closest([a, b, c]: [Point<3>; 3], p: Point<3>) -> [f64; 3] {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;
    use crate::output::space::tests::cuboid;

    /// States of the top of a plate of 40 × 40: nodes within this distance of a corner touch.
    fn view(reach: f64) -> View {
        let mesh = cuboid([0.0; 3], [40.0, 40.0, 1.0], [40, 40, 1], CellKind::Hex8);
        let state = |p: &Point<3>| match (p[2] > 0.5, p[0].max(p[1]) <= reach) {
            (true, true) => Some(Status::Closed),
            (true, false) => Some(Status::Open),
            (false, _) => None,
        };
        let status: Vec<_> = mesh.points().iter().map(state).collect();
        View::of(&mesh, mesh.side("top").unwrap(), &status, false)
    }

    #[test]
    fn a_small_contact_is_cut_out_with_its_surroundings_from_straight_above() {
        let view = view(4.0);
        assert!(view.cutout && view.camera.towards == [0.0, 0.0, 1.0]);
        // facets with a node that touches reach to 5; the side ends at 0
        let room = 5.0 * (1.0 + AROUND);
        assert_eq!(view.extent, ([0.0, 0.0], [room, room]));
        assert!(view.sees([6.0, 1.0, 1.0]) && !view.sees([7.0, 1.0, 1.0]));
    }

    #[test]
    fn a_side_that_touches_in_half_of_its_size_is_seen_whole() {
        for reach in [20.0, 40.0, -1.0] {
            let view = view(reach);
            assert!(!view.cutout && view.sees([39.0, 1.0, 1.0]), "{reach}");
        }
    }
}
