//! A solved warp, and its overlay.
//!
//! In: a solved lattice. Out: the images of points; lines, handles and pins as screen points.

use super::key::Key;
use crate::lattice::ScreenLattice;
use crate::plate::{Coverage, Field, WarpMap};
use crate::solve::SolveReport;
use crate::space::{FrameSize, FrameWindow, ScreenPoint};

/// The warp of a picture at one time.
#[derive(Clone, Debug)]
pub struct Warp {
    /// The warp of the screen; if the picture has parts, that of the largest.
    pub field: Field,
    /// Field and share of every pixel for the parts of a picture whose lattice branches, from back to front; the shares
    /// sum to 1. Empty if the picture moves as one.
    pub parts: Vec<(Field, Coverage)>,
    /// Coverage of the shape of all parts; `None` if there are none.
    pub(crate) covered: Option<Coverage>,
    /// The solved lattice, at rest where nothing moves; `None` if there is nothing to lay it over.
    pub lattice: Option<ScreenLattice>,
    /// Warped outlines of the cells in which the lattice folds where it holds part of the shape.
    #[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin reads it"))]
    pub(crate) folds: Vec<Vec<ScreenPoint>>,
    /// One per pin of the controls, in order.
    #[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin reads it"))]
    pub(crate) pins: Vec<PinPlace>,
    /// Quality of the solve (pin errors, with a shot's own pins first; folded cells); `None`: nothing was solved.
    pub report: Option<SolveReport>,
    /// Warnings of the solve besides the report; [`Warp::notices`] formats all of them.
    #[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin reads it"))]
    pub(crate) warnings: Vec<Warning>,
    /// The pins of [`SolveReport::pin_errors`], in order.
    #[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin reads it"))]
    pub(super) acting: Vec<ActingPin>,
    /// Hash of all inputs of the solve.
    pub(super) key: Key,
}

/// Something unexpected that a solve found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Warning {
    /// Message text.
    Text(String),
    /// The otherwise fixed border gives way to a pin that is dragged to it or past it.
    BorderGivesWay {
        /// Index of the pin in [`SolveReport::pin_errors`](crate::solve::SolveReport::pin_errors).
        pin: usize,
        /// Largest displacement of the border, in frame heights.
        by: f64,
    },
    /// No surface lies under the pin, so it is fixed on the screen.
    OffModel {
        /// Index of the pin in the controls.
        pin: usize,
        /// Position at which it was placed.
        at: ScreenPoint,
        /// Frame in which it was placed.
        frame: i32,
    },
}

/// An active pin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ActingPin {
    /// A pin of the shot file, by name.
    OfShot(String),
    /// A pin of the controls, by index.
    OfControls(usize),
}

/// A pin at the time of the warp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PinPlace {
    /// Position before the warp; with a shot, it follows the model.
    pub rest: ScreenPoint,
    /// Target position, with strength applied.
    pub target: ScreenPoint,
    /// Position after the warp.
    pub moved: ScreenPoint,
    /// 1; less if the point comes close to the camera, 0 if the pin is inactive.
    pub presence: f64,
}

/// A line of the lattice.
#[cfg(any(test, feature = "ofx"))]
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GridLine {
    /// Points before the warp, from left to right or from the bottom up.
    pub rest: Vec<ScreenPoint>,
    /// The same points after the warp.
    pub moved: Vec<ScreenPoint>,
}

/// Pixels of shares per unit of cache weight; a warp without parts weighs one.
const PIXELS_A_WEIGHT: usize = 1 << 14;

impl Warp {
    /// Creates the identity warp with the reason as a warning.
    pub(super) fn identity(why: &str, key: Key) -> Self {
        let warnings = vec![Warning::Text(why.to_owned())];
        let field = Field::identity();
        Self {
            field,
            parts: Vec::new(),
            covered: None,
            lattice: None,
            folds: Vec::new(),
            pins: Vec::new(),
            report: None,
            warnings,
            acting: Vec::new(),
            key,
        }
    }

    /// Whether the warp is the identity everywhere (within 1e-8 frame heights).
    #[must_use]
    pub(crate) fn is_identity(&self) -> bool {
        self.field.is_identity() && self.parts.iter().all(|(field, _)| field.is_identity())
    }

    /// Returns the fields of all parts, or the single field.
    pub(super) fn fields(&self) -> impl Iterator<Item = &Field> {
        let only = self.parts.is_empty().then_some(&self.field);
        only.into_iter().chain(self.parts.iter().map(|(field, _)| field))
    }

    /// Warps a point with the part that has the largest share of it in a frame of this size.
    pub(super) fn carry(&self, point: ScreenPoint, size: FrameSize) -> ScreenPoint {
        let at = size.image_from_screen(point).0.floor();
        let last = [size.width, size.height].map(|side| side as i32 - 1);
        let pixel = [(at.x as i32).clamp(0, last[0]), (at.y as i32).clamp(0, last[1])];
        let share = |(_, share): &(Field, Coverage)| share.at(pixel, size);
        let part = self.parts.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
        part.map_or(&self.field, |(field, _)| field).carry(point)
    }

    /// Computes the map of a window if the picture has parts.
    #[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin calls it"))]
    pub(super) fn map_of_parts(&self, FrameWindow { frame, window }: FrameWindow) -> Option<WarpMap> {
        let covered = self.covered.as_ref().filter(|_| !self.parts.is_empty())?;
        Some(WarpMap::backward_of_shares(&self.parts, covered, FrameWindow { frame, window }))
    }

    /// Returns its weight in a cache: 1, and more for the pixels of its parts.
    pub(super) fn weight(&self) -> usize {
        let shares = self.parts.iter().map(|(_, share)| share).chain(&self.covered);
        1 + shares.map(|share| share.samples.len()).sum::<usize>() / PIXELS_A_WEIGHT
    }

    /// Returns the greatest distance of a pin from its target, in frame heights; 0 without pins.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn pin_error(&self) -> f64 {
        self.report.iter().flat_map(|report| &report.pin_errors).copied().fold(0.0, f64::max)
    }

    /// Returns the rest and the current position of every handle, by index (x fastest).
    #[cfg(test)]
    #[must_use]
    pub(crate) fn handles(&self) -> Vec<[ScreenPoint; 2]> {
        let point = |[x, y]: [f64; 2]| ScreenPoint::new(x, y);
        let Some(lattice) = &self.lattice else { return Vec::new() };
        let rest = lattice.grid.rest_handles();
        rest.into_iter().zip(&lattice.handles).map(|(rest, moved)| [point(rest), point(*moved)]).collect()
    }

    /// Returns the grid lines of the lattice's box, with `pieces` segments per cell.
    #[cfg(any(test, feature = "ofx"))]
    #[must_use]
    pub(crate) fn grid_lines(&self, pieces: usize) -> Vec<GridLine> {
        let Some(lattice) = &self.lattice else { return Vec::new() };
        let spans = lattice.grid.dims.map(|count| lattice.grid.basis.spans(count));
        let pieces = pieces.max(1);
        let mut lines = Vec::new();
        for along in 0..2 {
            for line in 0..=spans[1 - along] {
                let rest: Vec<ScreenPoint> = (0..=spans[along] * pieces)
                    .map(|step| {
                        let mut place = [0.0; 2];
                        place[along] = step as f64 / pieces as f64;
                        place[1 - along] = line as f64;
                        on_box(lattice, place)
                    })
                    .collect();
                let moved = rest.iter().map(|&point| self.field.carry(point)).collect();
                lines.push(GridLine { rest, moved });
            }
        }
        lines
    }
}

/// Converts a position in cells to a point of the box.
#[cfg(any(test, feature = "ofx"))]
fn on_box(lattice: &ScreenLattice, cells: [f64; 2]) -> ScreenPoint {
    ScreenPoint(lattice.grid.point_from_spans(cells).into())
}
