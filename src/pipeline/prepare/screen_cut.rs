//! Finds which links of a layer a stroke over a scene crosses, as the camera sees the scene in one frame.
//!
//! In: the triangles of a layer in that frame, a camera, a stroke on the screen. Out: a [`ScreenCut`]. It reaches from the viewer to the
//! back of the front-most solid: what lies behind that stays connected.

use super::rest_mesh::RestMesh;
use crate::screen::{Camera, Projected};
use crate::solve::Link;
use glam::{DVec2, DVec3};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Depth beyond the back of the front-most solid at which links still count as its own, in diagonals of the layer.
const TOLERANCE: f64 = 0.005;

/// The bounds of a triangle on the screen, with its index.
type Leaf = GeomWithData<Rectangle<[f64; 2]>, usize>;

/// A stroke over the triangles of a layer.
pub(super) struct ScreenCut<'a> {
    stroke: &'a [[f64; 2]],
    mesh: &'a RestMesh,
    /// #points: projected corners.
    points: Vec<Projected>,
    near: f64,
    tolerance: f64,
    tree: RTree<Leaf>,
}

/// A surface under a point of the screen.
struct Layer {
    depth: f64,
    is_front: bool,
}

impl<'a> ScreenCut<'a> {
    /// Projects a layer. `mesh`: the layer posed as in the frame.
    pub(super) fn new(stroke: &'a [[f64; 2]], mesh: &'a RestMesh, camera: &Camera) -> Self {
        let points: Vec<Projected> =
            mesh.points.iter().map(|&point| camera.project_exact(DVec3::from(point))).collect();
        let near = camera.near();
        let leaf = |(number, corners): (usize, &[u32; 3])| {
            let corners = corners.map(|corner| points[corner as usize]);
            let is_seen = corners.iter().all(|corner| corner.depth > near && corner.w > 0.0);
            let bounds = AABB::from_points(&corners.map(|corner| corner.point().0.to_array()));
            is_seen.then(|| Leaf::new(Rectangle::from_corners(bounds.lower(), bounds.upper()), number))
        };
        let tree = RTree::bulk_load(mesh.triangles.iter().enumerate().filter_map(leaf).collect());
        Self { stroke, mesh, points, near, tolerance: TOLERANCE * mesh.diagonal(), tree }
    }

    /// Whether the stroke separates the triangles of a link: whether it crosses the way between their middles. Where surfaces touch, the
    /// link itself has no length.
    pub(super) fn separates(&self, link: &Link) -> bool {
        let [from, to] = link.ends.map(|end| self.middle(end.triangle as usize));
        if [from, to].iter().any(|end| end.depth <= self.near || end.w <= 0.0) {
            return false;
        }
        let way = [from, to].map(|end| end.point().0);
        self.stroke.windows(2).any(|segment| {
            let crossing = crossing(way, [segment[0], segment[1]].map(DVec2::from));
            crossing.is_some_and(|along| {
                let at = way[0].lerp(way[1], along);
                // Equal steps on the screen are no equal steps in the scene.
                let share = along * from.w / (along * from.w + (1.0 - along) * to.w);
                from.lerp(to, share).depth <= self.back_of_front(at) + self.tolerance
            })
        })
    }

    /// The projected middle of a triangle.
    fn middle(&self, triangle: usize) -> Projected {
        let corners = self.mesh.triangles[triangle].map(|corner| self.points[corner as usize]);
        let mean = |value: fn(&Projected) -> f64| corners.iter().map(value).sum::<f64>() / 3.0;
        Projected { h: DVec2::new(mean(|p| p.h.x), mean(|p| p.h.y)), w: mean(|p| p.w), depth: mean(|p| p.depth) }
    }

    /// Returns the depth at which a ray leaves the first solid that it meets; solids that reach into each other are one. For a surface
    /// without a back, its own depth; infinite where there is no surface.
    fn back_of_front(&self, at: DVec2) -> f64 {
        let leaves = self.tree.locate_all_at_point(at.to_array());
        let mut layers: Vec<Layer> = leaves.filter_map(|leaf| self.layer(leaf.data, at)).collect();
        layers.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        // A point on a common side lies in both triangles.
        layers.dedup_by(|b, a| a.is_front == b.is_front && b.depth - a.depth <= 1e-9 * a.depth.abs());
        let mut inside = 0;
        let leaves = layers.iter().find(|layer| {
            inside += if layer.is_front { 1 } else { -1 };
            inside <= 0
        });
        let back = leaves.or_else(|| layers.iter().find(|layer| !layer.is_front)).or(layers.first());
        back.map_or(f64::INFINITY, |layer| layer.depth)
    }

    /// Returns the surface of a triangle under a point; `None` beside it.
    fn layer(&self, triangle: usize, at: DVec2) -> Option<Layer> {
        let corners = self.mesh.triangles[triangle].map(|corner| self.points[corner as usize]);
        let [a, b, c] = corners.map(|corner| corner.point().0);
        let doubled = (b - a).perp_dot(c - a);
        let shares = [(b - at).perp_dot(c - at), (c - at).perp_dot(a - at), (a - at).perp_dot(b - at)];
        let shares = shares.map(|share| share / doubled);
        if doubled == 0.0 || shares.iter().any(|share| *share < 0.0) {
            return None;
        }
        // Linear on the screen are the inverses of w.
        let inverse = |value: fn(&Projected) -> f64| -> f64 {
            corners.iter().zip(shares).map(|(corner, share)| share * value(corner) / corner.w).sum()
        };
        Some(Layer { depth: inverse(|p| p.depth) / inverse(|_| 1.0), is_front: doubled > 0.0 })
    }
}

/// Returns how far along the first of two segments they cross, 0 to 1.
fn crossing([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> Option<f64> {
    let across = (b - a).perp_dot(d - c);
    let [along, other] = [(c - a).perp_dot(d - c) / across, (c - a).perp_dot(b - a) / across];
    (across != 0.0 && (0.0..=1.0).contains(&along) && (0.0..=1.0).contains(&other)).then_some(along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Lens;
    use crate::solve::{LinkEnd, LinkKind};
    use crate::space::FrameSize;
    use glam::{Mat4, Vec3};

    /// Adds a box, all of whose sides face outwards, to a mesh.
    fn add_box(mesh: &mut RestMesh, low: [f64; 3], high: [f64; 3]) {
        let base = mesh.points.len() as u32;
        let corner = |k: usize| std::array::from_fn(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] });
        mesh.points.extend((0..8).map(corner));
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for [a, b, c, d] in sides {
            mesh.triangles.extend([[a, b, c], [a, c, d]].map(|corners| corners.map(|corner: u32| corner + base)));
        }
        mesh.is_mirrored.resize(mesh.triangles.len(), false);
        mesh.nodes.resize(mesh.triangles.len(), 0);
    }

    /// A link between the first corners of triangles of box 0.
    fn link(mesh: &RestMesh, ends: [[f64; 3]; 2]) -> Link {
        let end = |wanted: [f64; 3]| {
            let of = |corners: &[u32; 3]| corners.iter().position(|&corner| mesh.points[corner as usize] == wanted);
            let found = mesh.triangles.iter().enumerate().find_map(|(number, corners)| Some((number, of(corners)?)));
            let (triangle, corner) = found.expect("a corner");
            LinkEnd::corner(triangle, corner)
        };
        Link { ends: ends.map(end), kind: LinkKind::Across }
    }

    #[test]
    fn a_stroke_cuts_the_front_most_solid_through_and_nothing_behind_it() {
        let mut mesh = RestMesh::default();
        add_box(&mut mesh, [-1.0, -1.0, 1.0], [1.0, 1.0, 2.0]);
        add_box(&mut mesh, [-1.5, -1.0, -2.0], [1.5, 1.0, -1.0]);
        for lens in [Lens::Perspective { yfov: 0.9 }, Lens::Orthographic { ymag: 3.0 }] {
            let camera = Camera::new(Mat4::from_translation(Vec3::Z * 9.0), lens, 0.1, FrameSize::new(100, 100));
            let stroke = [[0.5, 0.0], [0.5, 1.0]];
            let cut = ScreenCut::new(&stroke, &mesh, &camera);
            let across = |y: f64, z: [f64; 2], x: f64| cut.separates(&link(&mesh, [[-x, y, z[0]], [x, y, z[1]]]));
            assert!(across(1.0, [2.0, 2.0], 1.0) && across(1.0, [1.0, 1.0], 1.0), "front and back of the front box");
            assert!(across(-1.0, [2.0, 1.0], 1.0), "through it");
            assert!(!across(-1.0, [-1.0, -1.0], 1.5) && !across(1.0, [-2.0, -1.0], 1.5), "behind it");
            let beside = [[0.95, 0.0], [0.95, 1.0]];
            let cut = ScreenCut::new(&beside, &mesh, &camera);
            assert!(!cut.separates(&link(&mesh, [[-1.0, 1.0, 2.0], [1.0, 1.0, 2.0]])), "beside the stroke");
        }
    }
}
