//! The host's plane and ours: the one place that knows both.
//!
//! ```text
//! canonical  x right, y up, square units of the full size, origin anywhere     parameters, regions
//! pixels     x right, y up; x = canonical x · scale / pixel aspect             images, render windows
//! ours       screen points, and image space (y down), of the project's picture [`crate::space`]
//! ```

use super::api::names::image;
use super::api::{RectD, RectI};
use super::effect::Effect;
use crate::space::{FrameSize, PixelRect, ScreenPoint};

/// Largest side of a picture, pixels: a host's "everywhere" is cut to it.
const FURTHEST: f64 = 1e6;

/// The project's picture at a render scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Canvas {
    /// The picture in pixels at this scale; its pixel aspect makes up for scales that differ in x and y.
    pub(super) frame: FrameSize,
    /// Its lower left pixel.
    origin: [i32; 2],
    /// Pixels per canonical unit.
    pixels: [f64; 2],
}

impl Canvas {
    /// The picture that pins are measured in: the project's, or else the whole of the source.
    pub(super) fn of(effect: Effect, time: f64, scale: [f64; 2]) -> Self {
        Self::at_render(effect, time, scale, None)
    }

    /// The same while an image of these pixels is drawn: of hosts without a project, MLT tells regions of the source in
    /// pixels of its preview, and its older versions tell none.
    pub(super) fn at_render(effect: Effect, time: f64, scale: [f64; 2], drawn: Option<RectI>) -> Self {
        let props = effect.props();
        let size = props.doubles(image::PROJECT_SIZE).or_else(|| props.doubles(image::PROJECT_EXTENT));
        let offset: [f64; 2] = props.doubles(image::PROJECT_OFFSET).unwrap_or_default();
        let source = effect.clip(image::SOURCE_CLIP);
        let aspect = source.and_then(|source| source.props().double(image::PIXEL_ASPECT));
        let aspect = aspect.or_else(|| props.double(image::PROJECT_PIXEL_ASPECT)).filter(|aspect| *aspect > 0.0);
        let aspect = aspect.unwrap_or(1.0);
        let region = match size.filter(|size: &[f64; 2]| size.iter().all(|side| *side >= 1.0)) {
            Some([width, height]) => {
                RectD { x1: offset[0], y1: offset[1], x2: offset[0] + width, y2: offset[1] + height }
            }
            None => without_project(source.and_then(|source| source.region(time)), drawn, aspect, scale),
        };
        Self::new(region, aspect, scale)
    }

    fn new(region: RectD, aspect: f64, scale: [f64; 2]) -> Self {
        let pixels = [scale[0] / aspect, scale[1]];
        let side = |length: f64| length.round().clamp(1.0, FURTHEST) as u32;
        let frame = FrameSize {
            width: side((region.x2 - region.x1) * pixels[0]),
            height: side((region.y2 - region.y1) * pixels[1]),
            pixel_aspect: pixels[1] / pixels[0],
        };
        let origin = [(region.x1 * pixels[0]).round() as i32, (region.y1 * pixels[1]).round() as i32];
        Self { frame, origin, pixels }
    }

    /// A canonical point on the screen.
    pub(super) fn screen(&self, [x, y]: [f64; 2]) -> ScreenPoint {
        let unit = f64::from(self.frame.height);
        let x = (x * self.pixels[0] - f64::from(self.origin[0])) * self.frame.pixel_aspect;
        ScreenPoint::new(x / unit, (y * self.pixels[1] - f64::from(self.origin[1])) / unit)
    }

    /// A screen point as a canonical one.
    pub(super) fn canonical(&self, ScreenPoint(point): ScreenPoint) -> [f64; 2] {
        let unit = f64::from(self.frame.height);
        let x = point.x * unit / self.frame.pixel_aspect + f64::from(self.origin[0]);
        [x / self.pixels[0], (point.y * unit + f64::from(self.origin[1])) / self.pixels[1]]
    }

    /// The host's pixels in image space.
    pub(super) fn window(&self, rect: RectI) -> PixelRect {
        let top = i64::from(self.frame.height) - (i64::from(rect.y2) - i64::from(self.origin[1]));
        PixelRect {
            x: rect.x1.saturating_sub(self.origin[0]),
            y: i32::try_from(top).unwrap_or_default(),
            width: u32::try_from(i64::from(rect.x2) - i64::from(rect.x1)).unwrap_or(0),
            height: u32::try_from(i64::from(rect.y2) - i64::from(rect.y1)).unwrap_or(0),
        }
    }

    /// Pixels of image space that hold a canonical region.
    pub(super) fn window_of(&self, region: RectD) -> PixelRect {
        let [least, most] = [-FURTHEST, FURTHEST];
        self.window(RectI {
            x1: (region.x1.clamp(least, most) * self.pixels[0]).floor() as i32,
            y1: (region.y1.clamp(least, most) * self.pixels[1]).floor() as i32,
            x2: (region.x2.clamp(least, most) * self.pixels[0]).ceil() as i32,
            y2: (region.y2.clamp(least, most) * self.pixels[1]).ceil() as i32,
        })
    }

    /// A window of image space as a canonical region.
    pub(super) fn region(&self, window: PixelRect) -> [f64; 4] {
        let left = f64::from(window.x) + f64::from(self.origin[0]);
        let top = f64::from(self.frame.height) - f64::from(window.y) + f64::from(self.origin[1]);
        let [x, y] = self.pixels;
        [left / x, (top - f64::from(window.height)) / y, (left + f64::from(window.width)) / x, top / y]
    }
}

/// The source's region, or that of the drawn pixels where the host tells none, or tells it in pixels.
fn without_project(region: Option<RectD>, drawn: Option<RectI>, aspect: f64, [across, up]: [f64; 2]) -> RectD {
    let scaled = |RectI { x1, y1, x2, y2 }: RectI, [x, y]: [f64; 2]| {
        let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(f64::from);
        RectD { x1: x1 * x, y1: y1 * y, x2: x2 * x, y2: y2 * y }
    };
    match (region, drawn) {
        (Some(region), Some(drawn)) if region == scaled(drawn, [aspect, 1.0]) => {
            scaled(drawn, [aspect / across, 1.0 / up])
        }
        (Some(region), _) => region,
        (None, Some(drawn)) => scaled(drawn, [aspect / across, 1.0 / up]),
        (None, None) => RectD { x1: 0.0, y1: 0.0, x2: 1920.0, y2: 1080.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PAL project in a corner of its canvas, at a scale that gives no whole pixels.
    fn canvas() -> Canvas {
        let region = RectD { x1: 10.0, y1: 20.0, x2: 778.0, y2: 596.0 };
        Canvas::new(region, 768.0 / 720.0, [0.3, 0.3])
    }

    #[test]
    fn points_go_to_the_screen_and_back() {
        let canvas = canvas();
        for point in [[10.0, 20.0], [400.5, 300.25], [-50.0, 900.0]] {
            let back = canvas.canonical(canvas.screen(point));
            assert!((0..2).all(|axis| (back[axis] - point[axis]).abs() < 1e-9), "{point:?} came back as {back:?}");
        }
        // The centre of the host's pixel (100, 50) is that of our pixel in image space.
        let pixel = canvas.screen([100.5 * (768.0 / 720.0) / 0.3, 50.5 / 0.3]);
        let ours = canvas.window(RectI { x1: 100, y1: 50, x2: 101, y2: 51 });
        let image = canvas.frame.image_from_screen(pixel);
        let error = image.0 - glam::DVec2::new(f64::from(ours.x) + 0.5, f64::from(ours.y) + 0.5);
        assert!(error.length() < 1e-9, "{error}");
    }

    #[test]
    fn regions_hold_their_windows_and_everywhere_is_cut() {
        let canvas = canvas();
        let window = PixelRect { x: -3, y: 7, width: 40, height: 25 };
        let [x1, y1, x2, y2] = canvas.region(window);
        let slack = 1e-9;
        let inner = RectD { x1: x1 + slack, y1: y1 + slack, x2: x2 - slack, y2: y2 - slack };
        assert_eq!(canvas.window_of(inner), window);
        let everywhere = RectD { x1: f64::from(i32::MIN), y1: f64::from(i32::MIN), x2: 2e9, y2: 2e9 };
        assert!(canvas.window_of(everywhere).width <= 700_000);
    }
}
