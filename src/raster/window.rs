//! The transform of vertices to the window of a target, with a common sub-pixel grid for every rasteriser.
//!
//! In: a target, the jitter of a pass, vertices. Out: window pixels (x right, y down), snapped or not. Rasterisers that
//! snap identically cover the same pixels: a vertex on the grid stays there however a device rounds.

use super::{RasterVertex, Target};
use glam::{DVec2, IVec2, Vec2};

/// Sub-pixel steps per pixel, as on Vulkan devices (`subPixelPrecisionBits` = 8).
pub(super) const SUBPIXELS: f64 = 256.0;

/// The guard band in window pixels: vertices outside it are not snapped but clipped first.
pub(super) const GUARD_BAND: std::ops::RangeInclusive<f64> = -16384.0..=32768.0;

/// The transform from screen space to window pixels: at = screen · scale + offset, y down.
#[derive(Clone, Copy, Debug)]
pub(super) struct WindowFromScreen {
    scale: DVec2,
    offset: DVec2,
}

impl WindowFromScreen {
    /// Creates the transform for a target; the picture is shifted by the jitter.
    pub(super) fn new(target: &Target, jitter_px: Vec2) -> Self {
        let height = f64::from(target.frame.height);
        let origin = DVec2::new(f64::from(target.window.x), f64::from(target.window.y));
        Self {
            scale: DVec2::new(height / target.frame.pixel_aspect, -height),
            offset: DVec2::new(0.0, height) + jitter_px.as_dvec2() - origin,
        }
    }

    /// Returns the window pixels of a vertex, not snapped; arbitrary if w is not positive.
    pub(super) fn point(&self, vertex: &RasterVertex) -> DVec2 {
        vertex.on_screen() * self.scale + self.offset
    }

    /// Returns the vertex in clip space of a window of `size` pixels, y down, on the sub-pixel grid of the window: the
    /// input with which a device covers the same pixels as the CPU rasteriser.
    pub(super) fn clip_position(&self, vertex: &RasterVertex, size: DVec2) -> [f32; 4] {
        let [x, y, _, w] = vertex.screen.map(f64::from);
        let at = self.point(vertex);
        let is_snapped = w > 0.0 && is_in_guard_band(at);
        let homogeneous = if is_snapped {
            (snap(at).as_dvec2() / SUBPIXELS * 2.0 / size - 1.0) * w
        } else {
            DVec2::new(x, y) * self.scale * 2.0 / size + (self.offset * 2.0 / size - 1.0) * w
        };
        [homogeneous.x as f32, homogeneous.y as f32, vertex.screen[2], vertex.screen[3]]
    }
}

/// Returns whether a point may be snapped: it is finite and within the guard band.
pub(super) fn is_in_guard_band(at: DVec2) -> bool {
    GUARD_BAND.contains(&at.x) && GUARD_BAND.contains(&at.y)
}

/// Snaps window pixels to the sub-pixel grid.
pub(super) fn snap(at: DVec2) -> IVec2 {
    (at * SUBPIXELS).round().as_ivec2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ChannelGroup;
    use crate::space::FrameSize;

    /// Rounds a clip position as a device does: to 32-bit floats, then to its own grid.
    fn on_device([x, y, _, w]: [f32; 4], size: u32) -> [i32; 2] {
        let half = size as f32 * 0.5;
        [x, y].map(|at| ((at / w * half + half) * 256.0).round() as i32)
    }

    #[test]
    fn devices_snap_to_the_grid_of_the_cpu() {
        for size in [64, 1080, 4096] {
            let frame = FrameSize::new(size, size);
            let target =
                Target { frame, window: frame.window(), channels: vec![ChannelGroup::Beauty], beauty_passes: 1 };
            let to_window = WindowFromScreen::new(&target, Vec2::new(0.3, -0.2));
            for k in 0..20_000u32 {
                // A low-discrepancy sequence over the frame and a tenth around it, at many depths.
                let place = |step: f64| (0.5 + step * f64::from(k)).fract() * 1.2 - 0.1;
                let w = 0.3 + 7.0 * (0.5 + 0.618_034 * f64::from(k)).fract();
                let [x, y] = [place(0.754_877), place(0.569_840)].map(|at| (at * w) as f32);
                let vertex = RasterVertex { screen: [x, y, 0.1, w as f32], ..RasterVertex::default() };
                let clip = to_window.clip_position(&vertex, DVec2::splat(f64::from(size)));
                assert_eq!(on_device(clip, size), snap(to_window.point(&vertex)).to_array(), "{size}, vertex {k}");
            }
        }
    }

    #[test]
    fn vertices_behind_the_camera_keep_their_homogeneous_place() {
        let frame = FrameSize::new(100, 100);
        let target = Target { frame, window: frame.window(), channels: Vec::new(), beauty_passes: 1 };
        let to_window = WindowFromScreen::new(&target, Vec2::ZERO);
        let vertex = RasterVertex { screen: [-0.25, -0.5, 0.1, -1.0], ..RasterVertex::default() };
        // Screen (0.25, 0.5): a quarter of the window from the left, its middle row.
        assert_eq!(to_window.clip_position(&vertex, DVec2::splat(100.0)), [0.5, 0.0, 0.1, -1.0]);
        let flat = RasterVertex { screen: [1.0, 0.0, 0.1, 0.0], ..RasterVertex::default() };
        assert_eq!(to_window.clip_position(&flat, DVec2::splat(100.0)), [2.0, 0.0, 0.1, 0.0]);
    }
}
