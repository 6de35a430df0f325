//! A solved warp, and what a host draws over the picture.
//!
//! In: a solved lattice. Out: where points go; lines, handles and pins as points of the screen.

use super::key::Key;
use crate::lattice::ScreenLattice;
use crate::plate::{Coverage, Field, WarpMap};
use crate::solve::SolveReport;
use crate::space::{FrameSize, PixelRect, ScreenPoint};

/// The warp of a picture at one moment.
#[derive(Clone, Debug)]
pub struct Warp {
    /// Where every point of the screen goes; where the picture has parts, those of the largest.
    pub field: Field,
    /// The parts of a picture whose lattice branches, from back to front: where each goes, and what it has of every pixel (all together
    /// have all); empty where the picture moves as one.
    pub parts: Vec<(Field, Coverage)>,
    /// How much of every pixel the shape of the parts covers; `None` where there are none.
    pub covered: Option<Coverage>,
    /// The lattice behind it, at rest where nothing moves; `None`: there is nothing to lay one over.
    pub lattice: Option<ScreenLattice>,
    /// One a pin of the controls, in their order.
    pub pins: Vec<PinPlace>,
    /// How good the solve is (pin errors, own pins of a shot first; folded cells); `None`: nothing was solved.
    pub report: Option<SolveReport>,
    /// What the solve found beside the report; [`Warp::notices`] has all of it in words.
    pub warnings: Vec<Warning>,
    /// The pins that [`SolveReport::pin_errors`] speaks of, in its order.
    pub(super) acting: Vec<ActingPin>,
    /// What stands for all that it was solved from.
    pub(super) key: Key,
}

/// Something unexpected that a solve found.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// A sentence.
    Text(String),
    /// The border, which rests elsewhere, gives way to a pin that is dragged to it or past it.
    BorderGivesWay {
        /// Place among the pins that [`SolveReport::pin_errors`](crate::solve::SolveReport::pin_errors) speaks of.
        pin: usize,
        /// How far it moves at most, frame heights.
        by: f64,
    },
    /// A pin has no surface under it, so it is fixed on the screen.
    OffModel {
        /// Index of the pin in the controls.
        pin: usize,
        /// Where it was placed.
        at: ScreenPoint,
        /// The frame in which it was placed.
        frame: i32,
    },
}

/// A pin that acts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ActingPin {
    /// One of the shot file's, by its name.
    OfShot(String),
    /// One of the controls', by its index.
    OfControls(usize),
}

/// A pin at the moment of the warp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinPlace {
    /// Where its point is before the warp; over a shot it follows the model.
    pub rest: ScreenPoint,
    /// Where it has to go, strength applied.
    pub target: ScreenPoint,
    /// Where the lattice brings it.
    pub moved: ScreenPoint,
    /// 1, less where the point comes close to the camera, 0 where the pin does not act.
    pub presence: f64,
}

/// A line of the lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct GridLine {
    /// Points before the warp, from left to right or from below.
    pub rest: Vec<ScreenPoint>,
    /// The same points after it.
    pub moved: Vec<ScreenPoint>,
}

/// Pixels of shares that weigh as much as a warp without parts.
const PIXELS_A_WEIGHT: usize = 1 << 14;

impl Warp {
    /// A warp that moves nothing, and why.
    pub(super) fn nothing(why: &str, key: Key) -> Self {
        let warnings = vec![Warning::Text(why.to_owned())];
        let field = Field::identity();
        Self {
            field,
            parts: Vec::new(),
            covered: None,
            lattice: None,
            pins: Vec::new(),
            report: None,
            warnings,
            acting: Vec::new(),
            key,
        }
    }

    /// Nothing moves anywhere (by more than 1e-8 frame heights).
    #[must_use]
    pub fn is_identity(&self) -> bool {
        self.field.is_identity() && self.parts.iter().all(|(field, _)| field.is_identity())
    }

    /// The fields of all parts, or the only one.
    pub(super) fn fields(&self) -> impl Iterator<Item = &Field> {
        let only = self.parts.is_empty().then_some(&self.field);
        only.into_iter().chain(self.parts.iter().map(|(field, _)| field))
    }

    /// Where a point goes, with the part that has most of it in a frame of that size.
    pub(super) fn carry(&self, point: ScreenPoint, size: FrameSize) -> ScreenPoint {
        let at = size.image_from_screen(point).0.floor();
        let last = [size.width, size.height].map(|side| side as i32 - 1);
        let pixel = [(at.x as i32).clamp(0, last[0]), (at.y as i32).clamp(0, last[1])];
        let share = |(_, share): &(Field, Coverage)| share.at(pixel, size);
        let part = self.parts.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
        part.map_or(&self.field, |(field, _)| field).carry(point)
    }

    /// Where the pixels of a window come from, where the picture has parts.
    pub(super) fn map_of_parts(&self, (frame, window): (FrameSize, PixelRect)) -> Option<WarpMap> {
        let covered = self.covered.as_ref().filter(|_| !self.parts.is_empty())?;
        Some(WarpMap::backward_of_shares(&self.parts, covered, (frame, window)))
    }

    /// What it weighs in a cache: 1, and more where its parts have pixels.
    pub(super) fn weight(&self) -> usize {
        let shares = self.parts.iter().map(|(_, share)| share).chain(&self.covered);
        1 + shares.map(|share| share.samples.len()).sum::<usize>() / PIXELS_A_WEIGHT
    }

    /// The greatest distance of a pin from its target, frame heights; 0 without pins.
    #[must_use]
    pub fn pin_error(&self) -> f64 {
        self.report.iter().flat_map(|report| &report.pin_errors).copied().fold(0.0, f64::max)
    }

    /// Cells of the lattice that turn over where some of the shape is.
    #[must_use]
    pub fn folded_cells(&self) -> usize {
        self.report.as_ref().map_or(0, |report| report.folded_model_cells)
    }

    /// Rest place and place of every handle, by index (x fastest).
    #[must_use]
    pub fn handles(&self) -> Vec<[ScreenPoint; 2]> {
        let point = |[x, y]: [f64; 2]| ScreenPoint::new(x, y);
        let Some(lattice) = &self.lattice else { return Vec::new() };
        let rest = lattice.grid.rest_handles();
        rest.into_iter().zip(&lattice.handles).map(|(rest, moved)| [point(rest), point(*moved)]).collect()
    }

    /// The lines between the cells of the lattice's box, each in `pieces` pieces a cell.
    #[must_use]
    pub fn grid_lines(&self, pieces: usize) -> Vec<GridLine> {
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

impl Warp {
    /// The outlines of cells that fold over after the warp, each side in `pieces` pieces; none where nothing that is seen
    /// folds.
    #[must_use]
    pub fn folded_outlines(&self, pieces: usize) -> Vec<Vec<ScreenPoint>> {
        let Some(lattice) = self.lattice.as_ref().filter(|_| self.folded_cells() > 0) else { return Vec::new() };
        let folds = lattice.folds(&vec![true; lattice.grid.cell_count()]);
        // Cells count from the handle outside the box.
        let margin = lattice.grid.basis.margin();
        let steps = 0..4 * pieces;
        let outline = |cell: &[usize; 2]| {
            let [x, y] = cell.map(|place| place as f64 - margin as f64);
            let place = |step: usize| {
                let along = (step % pieces) as f64 / pieces as f64;
                match step / pieces {
                    0 => [x + along, y],
                    1 => [x + 1.0, y + along],
                    2 => [x + 1.0 - along, y + 1.0],
                    _ => [x, y + 1.0 - along],
                }
            };
            steps.clone().chain([0]).map(|step| lattice.warp(on_box(lattice, place(step)))).collect()
        };
        folds.cells.iter().map(outline).collect()
    }
}

/// A place counted in cells.
fn on_box(lattice: &ScreenLattice, cells: [f64; 2]) -> ScreenPoint {
    let grid = &lattice.grid;
    let at = |axis: usize| grid.lo[axis] + cells[axis] * grid.spacing(axis);
    ScreenPoint::new(at(0), at(1))
}
