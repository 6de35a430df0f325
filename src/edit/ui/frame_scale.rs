//! The horizontal time scale shared by ruler, rows and curves.

use super::theme::ACCENT;
use crate::edit::Session;
use eframe::egui::{Painter, Rect, Stroke};

/// Width of the names to the left of the rows.
pub(super) const NAMES: f32 = 150.0;

/// A horizontal time scale.
#[derive(Clone, Copy)]
pub(super) struct FrameScale {
    pub(super) first: f32,
    pub(super) left: f32,
    pub(super) per_frame: f32,
}

impl FrameScale {
    pub(super) fn x(self, frame: f64) -> f32 {
        self.left + (frame as f32 - self.first + 0.5) * self.per_frame
    }

    pub(super) fn frame(self, x: f32) -> f32 {
        (x - self.left) / self.per_frame - 0.5 + self.first
    }
}

/// Draws the playhead.
pub(super) fn playhead(painter: &Painter, rect: Rect, session: &Session, scale: FrameScale) {
    let x = scale.x(f64::from(session.playhead.frame()));
    painter.vline(x, rect.y_range(), Stroke::new(1.5, ACCENT));
}
