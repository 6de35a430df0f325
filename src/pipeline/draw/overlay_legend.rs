//! Draws the legend of an overlay, which explains the marks present in the picture.
//!
//! In: the marks that were drawn. Out: a panel in the lower left corner of the preview.

use crate::image::{Canvas, Rgba8};
use crate::space::{FrameSize, ImagePoint};
use glam::DVec2;

pub(in crate::pipeline) const GRID: Rgba8 = Rgba8([64, 200, 255, 150]);
pub(in crate::pipeline) const HANDLE: Rgba8 = Rgba8([64, 200, 255, 220]);
pub(in crate::pipeline) const FOLDED: Rgba8 = Rgba8([255, 40, 40, 130]);
pub(in crate::pipeline) const FOLDED_EMPTY: Rgba8 = Rgba8([255, 90, 90, 170]);
pub(in crate::pipeline) const REGION: Rgba8 = Rgba8([255, 200, 40, 90]);
pub(in crate::pipeline) const REST: Rgba8 = Rgba8([255, 255, 255, 230]);
pub(in crate::pipeline) const TARGET: Rgba8 = Rgba8([255, 200, 40, 255]);
pub(in crate::pipeline) const NAME: Rgba8 = Rgba8([255, 255, 255, 255]);
const PANEL: Rgba8 = Rgba8([16, 16, 20, 190]);

/// Width of a character and height of a line in pixels, at scale 1.
const CHARACTER: DVec2 = DVec2::new(6.0, 14.0);

/// Width of the mark in front of the text, and margin around everything, in pixels at scale 1.
const MARK: f64 = 22.0;
const MARGIN: f64 = 8.0;

/// The marks of an overlay, in legend order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::pipeline) enum Mark {
    Grid,
    Rest,
    Target,
    Region,
    Folded,
    FoldedEmpty,
}

impl Mark {
    const fn words(self) -> &'static str {
        match self {
            Self::Grid => "lattice, warped",
            Self::Rest => "pin before the warp",
            Self::Target => "pin's target",
            Self::Region => "pin's region",
            Self::Folded => "fold in the model",
            Self::FoldedEmpty => "fold beside the model",
        }
    }

    /// Draws the mark centred on a point.
    fn draw(self, canvas: &mut Canvas, at: DVec2, scale: f64) {
        let point = |x: f64, y: f64| ImagePoint(at + DVec2::new(x, y) * scale);
        let square = [point(-6.0, -4.0), point(6.0, -4.0), point(6.0, 4.0), point(-6.0, 4.0)];
        match self {
            Self::Grid => {
                canvas.line(point(-8.0, 0.0), point(8.0, 0.0), scale, GRID);
                canvas.disc(point(0.0, 0.0), 1.5 * scale, HANDLE);
            }
            Self::Rest => canvas.ring(point(0.0, 0.0), 4.0 * scale, 1.5 * scale, REST),
            Self::Target => canvas.disc(point(0.0, 0.0), 4.0 * scale, TARGET),
            Self::Region => canvas.ring(point(0.0, 0.0), 5.0 * scale, scale, REGION),
            Self::Folded => canvas.fill_polygon(&square, FOLDED),
            Self::FoldedEmpty => outline(canvas, &square, (scale, FOLDED_EMPTY)),
        }
    }
}

/// Draws a closed polyline.
pub(in crate::pipeline) fn outline(canvas: &mut Canvas, corners: &[ImagePoint], (width_px, color): (f64, Rgba8)) {
    for (index, &corner) in corners.iter().enumerate() {
        canvas.line(corner, corners[(index + 1) % corners.len()], width_px, color);
    }
}

/// Draws the legend if the frame is large enough.
pub(in crate::pipeline) fn draw(canvas: &mut Canvas, frame: FrameSize, (marks, unit_px): (&[Mark], f64)) {
    let scale = unit_px.round();
    let longest = marks.iter().map(|mark| mark.words().len()).max().unwrap_or_default() as f64;
    let size = DVec2::new(MARK + longest * CHARACTER.x, marks.len() as f64 * CHARACTER.y) + 2.0 * MARGIN;
    let (panel, frame) = (size * scale, DVec2::new(f64::from(frame.width), f64::from(frame.height)));
    if marks.is_empty() || panel.x > 0.5 * frame.x || panel.y > 0.5 * frame.y {
        return;
    }
    let corner = DVec2::new(MARGIN * scale, frame.y - MARGIN * scale - panel.y);
    let at = |x: f64, y: f64| ImagePoint(corner + DVec2::new(x, y));
    canvas.fill_polygon(&[at(0.0, 0.0), at(panel.x, 0.0), at(panel.x, panel.y), at(0.0, panel.y)], PANEL);
    for (line, mark) in marks.iter().enumerate() {
        let top = (MARGIN + line as f64 * CHARACTER.y) * scale;
        mark.draw(canvas, at((MARGIN + 0.4 * MARK) * scale, top + 0.4 * CHARACTER.y * scale).0, scale);
        canvas.text(at((MARGIN + MARK) * scale, top + scale), mark.words(), scale as u32, NAME);
    }
}
