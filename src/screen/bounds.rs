//! Bounds of a layer on the screen, and the box that follows them.
//!
//! In: projected parts. Out: boxes in frame heights.

use super::{ScreenMesh, clip_near, primitive};
use crate::pose::Pose;
use crate::scene::Scene;
use crate::space::{FrameSize, ScreenBox, ScreenPoint};
use glam::DVec2;

/// Bounds are cut to the frame grown by this factor about its middle, so that a limb that comes close to the camera
/// cannot stretch the lattice without end.
const REACH: f64 = 1.5;

/// Air around a followed box on each side, as a share of its size.
const PADDING: f64 = 0.1;

/// A followed box is smoothed over this many frames on either side.
const FOLLOW_FRAMES: i32 = 3;

/// A lattice box is never thinner than this, in frame heights.
const MIN_SIDE: f64 = 0.01;

/// How far lattices reach: the frame grown by a half.
#[must_use]
pub fn reach_of_frame(frame: FrameSize) -> ScreenBox {
    let size = DVec2::new(frame.aspect(), 1.0);
    let margin = size * ((REACH - 1.0) * 0.5);
    ScreenBox::new(ScreenPoint(-margin), ScreenPoint(size + margin))
}

/// What of a scene [`bounds`] looks at.
#[derive(Clone, Copy, Debug)]
pub struct Extent<'a> {
    /// Indices into the pose's parts.
    pub parts: &'a [usize],
    /// Distance of the near plane, metres: what is nearer does not count.
    pub near: f64,
    /// What lies outside is cut off.
    pub reach: ScreenBox,
}

/// Bounds of the chosen parts, clipped at the near plane and cut to the reach.
///
/// `None` where nothing of them is within reach.
#[must_use]
pub fn bounds(scene: &Scene, pose: &Pose, mesh: &ScreenMesh, extent: Extent) -> Option<ScreenBox> {
    let Extent { parts, near, reach } = extent;
    let of_part = |&part: &usize| {
        let vertices = &mesh.parts[part].vertices;
        // Corners of triangles only: other vertices may belong to other parts.
        let triangles = &primitive(scene, &pose.parts[part]).triangles;
        ScreenBox::around(triangles.iter().flat_map(|corners| {
            let corners = corners.map(|corner| vertices[corner as usize]);
            let (cut, count) = clip_near(corners, near);
            let place =
                move |corner: super::Corner| corners[corner.from].lerp(corners[corner.to], corner.share).point();
            cut.into_iter().take(count).flatten().map(place)
        }))
    };
    let whole = parts.iter().filter_map(of_part).reduce(ScreenBox::union)?;
    let min = whole.min.0.max(reach.min.0);
    let max = whole.max.0.min(reach.max.0);
    (min.cmple(max).all() && min.is_finite() && max.is_finite())
        .then(|| ScreenBox::new(ScreenPoint(min), ScreenPoint(max)))
}

/// The neighbouring frames that a followed box at a (fractional) frame looks at, with their weights.
#[derive(Clone, Copy, Debug)]
pub struct FollowWindow {
    frame: f64,
}

impl FollowWindow {
    /// The window around a frame.
    #[must_use]
    pub const fn new(frame: f64) -> Self {
        Self { frame }
    }

    /// The whole frames whose bounds count.
    #[must_use]
    pub fn frames(self) -> std::ops::RangeInclusive<i32> {
        let (low, high) = (self.frame.floor() as i32, self.frame.ceil() as i32);
        low.saturating_sub(FOLLOW_FRAMES)..=high.saturating_add(FOLLOW_FRAMES)
    }

    /// The box: centre and size are tent-weighted means over the neighbours' bounds, then padded, then grown where
    /// needed to hold `now`, the bounds of the frame itself. `None` where neither it nor a neighbour shows anything.
    #[must_use]
    pub fn smooth(self, neighbours: &[(i32, Option<ScreenBox>)], now: Option<ScreenBox>) -> Option<ScreenBox> {
        let half_width = f64::from(FOLLOW_FRAMES + 1);
        let mut total = 0.0;
        let (mut center, mut size) = (DVec2::ZERO, DVec2::ZERO);
        for &(frame, bounds) in neighbours {
            let weight = (1.0 - (f64::from(frame) - self.frame).abs() / half_width).max(0.0);
            if let Some(bounds) = bounds {
                total += weight;
                center += bounds.center().0 * weight;
                size += bounds.size() * weight;
            }
        }
        let mean = (total > 0.0).then(|| {
            let half = size / total * (0.5 + PADDING);
            ScreenBox::new(ScreenPoint(center / total - half), ScreenPoint(center / total + half))
        });
        let followed = [mean, now].into_iter().flatten().reduce(ScreenBox::union)?;
        let lacking = (DVec2::splat(MIN_SIDE) - followed.size()).max(DVec2::ZERO) * 0.5;
        Some(ScreenBox::new(ScreenPoint(followed.min.0 - lacking), ScreenPoint(followed.max.0 + lacking)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box_at(x: f64) -> ScreenBox {
        ScreenBox::new(ScreenPoint::new(x, 0.0), ScreenPoint::new(x + 1.0, 1.0))
    }

    #[test]
    fn a_followed_box_is_padded_and_moves_evenly() {
        let at = |frame: i32| (frame, Some(unit_box_at(f64::from(frame) * 0.01)));
        let window = FollowWindow::new(10.0);
        let neighbours: Vec<_> = window.frames().map(at).collect();
        let followed = window.smooth(&neighbours, at(10).1).expect("visible");
        assert!((followed.min.0 - DVec2::new(0.0, -0.1)).length() < 1e-12, "{followed:?}");
        assert!((followed.max.0 - DVec2::new(1.2, 1.1)).length() < 1e-12);
    }

    #[test]
    fn a_followed_box_always_holds_the_bounds() {
        let window = FollowWindow::new(4.5);
        let neighbours: Vec<_> = window.frames().map(|frame| (frame, Some(unit_box_at(0.0)))).collect();
        let now = unit_box_at(5.0);
        let followed = window.smooth(&neighbours, Some(now)).expect("visible");
        assert_eq!(followed.union(now), followed);
        assert_eq!(window.smooth(&[(4, None)], None), None);
    }
}
