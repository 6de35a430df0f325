//! Screen-space bounds of a layer.
//!
//! In: projected parts. Out: boxes in frame heights.

use super::clip::{Corner, clip_near};
use super::mesh::{ScreenMesh, primitive};
use crate::pose::Pose;
use crate::scene::Scene;
use crate::space::{FrameSize, ScreenBox, ScreenPoint};
use glam::DVec2;

/// Bounds are clipped to the frame scaled by this factor about its centre, so that a limb close to the camera cannot
/// stretch the lattice arbitrarily.
const REACH: f64 = 1.5;

/// Returns the maximum extent of lattices: the frame scaled by 1.5.
#[must_use]
pub(crate) fn reach_of_frame(frame: FrameSize) -> ScreenBox {
    let size = DVec2::new(frame.aspect(), 1.0);
    let margin = size * ((REACH - 1.0) * 0.5);
    ScreenBox::new(ScreenPoint(-margin), ScreenPoint(size + margin))
}

/// The part of a scene that [`bounds`] considers.
#[derive(Clone, Copy)]
pub(crate) struct Extent<'a> {
    /// Indices into the pose's parts.
    pub(crate) parts: &'a [usize],
    /// Returns whether a triangle counts, given its part and corners.
    pub(crate) counts: &'a (dyn Fn(usize, &[u32; 3]) -> bool + Sync),
    /// Distance of the near plane in metres; nearer geometry is ignored.
    pub(crate) near: f64,
    /// The box that bounds are clipped to.
    pub(crate) reach: ScreenBox,
    /// Origin of the axes of the bounds.
    pub(crate) origin: DVec2,
    /// Angle of these axes, in radians, counter-clockwise.
    pub(crate) angle: f64,
}

/// Returns the bounds of the selected parts, clipped at the near plane and to the reach, along the given axes.
///
/// `None` if nothing is within reach.
#[must_use]
pub(crate) fn bounds(scene: &Scene, pose: &Pose, mesh: &ScreenMesh, extent: Extent) -> Option<ScreenBox> {
    let Extent { parts, counts, near, reach, origin, angle } = extent;
    let turn = (angle != 0.0).then(|| DVec2::from_angle(-angle));
    let along_axes = |ScreenPoint(point): ScreenPoint| {
        let from_origin = point - origin;
        ScreenPoint(turn.map_or(from_origin, |turn| turn.rotate(from_origin)))
    };
    let reach = reach.around_moved(along_axes);
    let of_part = |&part: &usize| {
        let vertices = &mesh.parts[part].vertices;
        // Only vertices referenced by triangles or lines count: others may belong to other parts.
        let source = primitive(scene, &pose.parts[part]);
        let segments = source.segments().map(|[a, b]| [a, b, b]);
        let triangles = source.triangles.iter().copied().filter(|corners| counts(part, corners));
        ScreenBox::around(triangles.chain(segments).flat_map(|corners| {
            let corners = corners.map(|corner| vertices[corner as usize]);
            let (cut, count) = clip_near(corners, near);
            let place =
                move |corner: Corner| along_axes(corners[corner.from].lerp(corners[corner.to], corner.share).point());
            cut.into_iter().take(count).flatten().map(place)
        }))
    };
    let whole = parts.iter().filter_map(of_part).reduce(ScreenBox::union)?;
    let min = whole.min.0.max(reach.min.0);
    let max = whole.max.0.min(reach.max.0);
    (min.cmple(max).all() && min.is_finite() && max.is_finite())
        .then(|| ScreenBox::new(ScreenPoint(min), ScreenPoint(max)))
}
