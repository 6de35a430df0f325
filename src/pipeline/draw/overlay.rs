//! Draws the result of a solve over the preview: lattice, pins, targets, folded cells.
//!
//! In: a solved [`TimeSample`]. Out: a [`Picture`] that can be drawn onto a preview later, on another thread.

use super::overlay_branches::BranchPicture;
use super::overlay_legend::{self, FOLDED, FOLDED_EMPTY, GRID, HANDLE, Mark, NAME, REGION, REST, TARGET, outline};
use crate::image::{Canvas, Preview};
use crate::lattice::{SceneLattice, ScreenLattice};
use crate::pipeline::evaluate::layer_pins::region;
use crate::pipeline::evaluate::screen_shape::screen_shape;
use crate::pipeline::{LayerState, PinState, PreparedShot, TimeSample};
use crate::screen::Camera;
use crate::solve::{ModelCells, Shape};
use crate::space::{FrameSize, ImagePoint, ScreenPoint};
use glam::{DVec2, DVec3};

/// Line segments per span.
const PIECES: usize = 8;

/// The overlay of one frame.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct Picture {
    frame: FrameSize,
    camera: Camera,
    layers: Vec<LayerPicture>,
}

#[derive(Clone, Debug)]
struct LayerPicture {
    lattice: SolvedLattice,
    /// Folded cells, by column and row.
    folds: Vec<([usize; 2], Fold)>,
    pins: Vec<PinPicture>,
}

/// Whether a fold is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fold {
    /// The cell contains part of the model.
    Model,
    /// The cell is empty, so the fold is not visible.
    Empty,
}

#[derive(Clone, Debug)]
struct PinPicture {
    state: PinState,
    name: String,
    /// Radius of the pin's region on the screen, frame heights; `None` without a region and for world layers.
    radius: Option<f64>,
}

#[derive(Clone, Debug)]
enum SolvedLattice {
    Screen(ScreenLattice),
    /// The largest branch, and all branches.
    Branches(ScreenLattice, Vec<BranchPicture>),
    World(SceneLattice),
}

impl SolvedLattice {
    fn of(state: &LayerState) -> Option<Self> {
        let screen = state.solution.as_ref().map(|solution| match &solution.branches {
            Some(branches) => Self::Branches(solution.lattice.clone(), BranchPicture::all_of(branches)),
            None => Self::Screen(solution.lattice.clone()),
        });
        screen.or_else(|| state.world.as_ref().map(|world| Self::World(world.lattice.clone())))
    }
}

impl Picture {
    /// Collects the overlay of a sample.
    #[must_use]
    pub(in crate::pipeline) fn of(prepared: &PreparedShot, sample: &TimeSample) -> Self {
        let layers =
            prepared.shot.layers.iter().zip(&sample.layers).enumerate().filter_map(|(index, (layer, state))| {
                let lattice = SolvedLattice::of(state)?;
                let diagonal = state.solution.as_ref().map(|solution| solution.lattice.grid.diagonal());
                let named = |pin: &PinState| PinPicture {
                    state: *pin,
                    name: layer.pins[pin.pin].name.clone(),
                    radius: diagonal.and_then(|diagonal| region(&layer.pins[pin.pin], diagonal)).map(|one| one.radius),
                };
                let seen = state.pins.iter().filter(|pin| pin.is_in_view);
                let folds = match &lattice {
                    SolvedLattice::Screen(lattice) => folds(lattice, || screen_shape(prepared, sample, index)),
                    SolvedLattice::Branches(..) | SolvedLattice::World(_) => Vec::new(),
                };
                Some(LayerPicture { lattice, folds, pins: seen.map(named).collect() })
            });
        Self { frame: prepared.shot.size, camera: sample.camera, layers: layers.collect() }
    }

    /// Draws the overlay onto a preview.
    pub(in crate::pipeline) fn draw(&self, preview: &mut Preview) {
        // Line widths scale with the size of the picture.
        let unit_px = (f64::from(self.frame.height) / 720.0).max(1.0);
        let mut canvas = Canvas::new(preview);
        for layer in &self.layers {
            match &layer.lattice {
                SolvedLattice::Screen(lattice) => self.draw_lattice(&mut canvas, (lattice, &layer.folds), unit_px),
                SolvedLattice::Branches(_, branches) => {
                    let place = (self.frame, unit_px);
                    // In reverse order, so that the largest branch lies on top.
                    let numbered = branches.iter().enumerate().rev();
                    numbered.for_each(|(number, branch)| branch.draw(&mut canvas, number, place));
                }
                SolvedLattice::World(lattice) => self.draw_scene_lattice(&mut canvas, lattice, unit_px),
            }
            for pin in &layer.pins {
                let lattice = match &layer.lattice {
                    SolvedLattice::Screen(lattice) | SolvedLattice::Branches(lattice, _) => Some(lattice),
                    SolvedLattice::World(_) => None,
                };
                if let Some(lattice) = lattice {
                    self.draw_region(&mut canvas, lattice, pin, unit_px);
                }
                self.draw_pin(&mut canvas, (&pin.state, &pin.name), unit_px);
            }
        }
        overlay_legend::draw(&mut canvas, self.frame, (&self.marks(), unit_px));
    }

    /// Returns the marks present in the picture.
    fn marks(&self) -> Vec<Mark> {
        let of_branches = |layer: &LayerPicture| match &layer.lattice {
            SolvedLattice::Branches(_, branches) => branches.iter().any(BranchPicture::has_folds),
            SolvedLattice::Screen(_) | SolvedLattice::World(_) => false,
        };
        let has_fold = |fold: Fold| {
            let in_branch = fold == Fold::Model && self.layers.iter().any(of_branches);
            in_branch || self.layers.iter().any(|layer| layer.folds.iter().any(|(_, other)| *other == fold))
        };
        let has_pin =
            |is_wanted: fn(&PinPicture) -> bool| self.layers.iter().any(|layer| layer.pins.iter().any(is_wanted));
        let marks = [
            (Mark::Grid, !self.layers.is_empty()),
            (Mark::Rest, has_pin(|_| true)),
            (Mark::Target, has_pin(|_| true)),
            (Mark::Region, has_pin(|pin| pin.radius.is_some())),
            (Mark::Folded, has_fold(Fold::Model)),
            (Mark::FoldedEmpty, has_fold(Fold::Empty)),
        ];
        marks.into_iter().filter(|(_, is_there)| *is_there).map(|(mark, _)| mark).collect()
    }

    fn px(&self, point: ScreenPoint) -> ImagePoint {
        self.frame.image_from_screen(point)
    }

    /// Draws the warped grid of the rest box, one cell per span, and the handles.
    fn draw_lattice(
        &self,
        canvas: &mut Canvas,
        (lattice, folds): (&ScreenLattice, &[([usize; 2], Fold)]),
        unit_px: f64,
    ) {
        // The outermost handles of a B-spline lie outside the box.
        let margin = lattice.grid.basis.margin();
        let [nx, ny] = lattice.grid.dims.map(|count| lattice.grid.basis.spans(count));
        let warped = |i: f64, j: f64| {
            let at = lattice.grid.point_from_unit([i / nx as f64, j / ny as f64]);
            self.px(lattice.warp(ScreenPoint(at.into())))
        };
        let along = |k: usize| k as f64 / PIECES as f64;
        for &([i, j], fold) in folds {
            let (i, j) = ((i - margin) as f64, (j - margin) as f64);
            let sides = [|t: f64| [t, 0.0], |t: f64| [1.0, t], |t: f64| [1.0 - t, 1.0], |t: f64| [0.0, 1.0 - t]];
            let rim = sides.iter().flat_map(|side| (0..PIECES).map(move |k| side(along(k))));
            let rim: Vec<ImagePoint> = rim.map(|[x, y]| warped(i + x, j + y)).collect();
            match fold {
                Fold::Model => canvas.fill_polygon(&rim, FOLDED),
                Fold::Empty => outline(canvas, &rim, (unit_px, FOLDED_EMPTY)),
            }
        }
        for j in 0..=ny {
            for k in 0..nx * PIECES {
                canvas.line(warped(along(k), j as f64), warped(along(k + 1), j as f64), unit_px, GRID);
            }
        }
        for i in 0..=nx {
            for k in 0..ny * PIECES {
                canvas.line(warped(i as f64, along(k)), warped(i as f64, along(k + 1)), unit_px, GRID);
            }
        }
        for &handle in &lattice.handles {
            canvas.disc(self.px(ScreenPoint(handle.into())), 1.5 * unit_px, HANDLE);
        }
    }

    /// Draws a world lattice as seen by the camera.
    fn draw_scene_lattice(&self, canvas: &mut Canvas, placed: &SceneLattice, unit_px: f64) {
        let SceneLattice { frame, lattice } = placed;
        let grid = &lattice.grid;
        let spans = grid.dims.map(|count| grid.basis.spans(count));
        let seen = |point: DVec3| {
            let place = self.camera.project_exact(point);
            (place.w > 0.0 && place.depth >= self.camera.near()).then(|| self.px(place.point()))
        };
        let warped = |share: [f64; 3]| {
            let at = grid.point_from_unit(std::array::from_fn(|axis| share[axis] / spans[axis] as f64));
            seen(placed.warp(frame.scene_from_box(DVec3::from_array(at))))
        };
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            for line in 0..(spans[u] + 1) * (spans[v] + 1) {
                let along = |k: usize| {
                    let mut share = [0.0; 3];
                    share[axis] = k as f64 / PIECES as f64;
                    share[u] = (line % (spans[u] + 1)) as f64;
                    share[v] = (line / (spans[u] + 1)) as f64;
                    warped(share)
                };
                let points: Vec<_> = (0..=spans[axis] * PIECES).map(along).collect();
                for pair in points.windows(2) {
                    let [Some(from), Some(to)] = *pair else { continue };
                    canvas.line(from, to, unit_px, GRID);
                }
            }
        }
        for handle in lattice.handles.iter().filter_map(|&handle| seen(frame.scene_from_box(handle.into()))) {
            canvas.disc(handle, 1.5 * unit_px, HANDLE);
        }
    }

    /// Draws the rim of a pin's region, if it has one, warped by the lattice.
    fn draw_region(&self, canvas: &mut Canvas, lattice: &ScreenLattice, pin: &PinPicture, unit_px: f64) {
        let Some(radius) = pin.radius else { return };
        let rest = pin.state.rest;
        let count = 8 * PIECES;
        let rim = |k: usize| {
            let turn = k as f64 / count as f64 * std::f64::consts::TAU;
            self.px(lattice.warp(ScreenPoint(rest.0 + radius * DVec2::from_angle(turn))))
        };
        (0..count).for_each(|k| canvas.line(rim(k), rim(k + 1), unit_px, REGION));
    }

    /// Draws a ring at the rest point, a line to the target, a disc at the target, and the pin's name beside it.
    fn draw_pin(&self, canvas: &mut Canvas, (pin, name): (&PinState, &str), unit_px: f64) {
        let (rest, target) = (self.px(pin.rest), self.px(pin.target));
        canvas.line(rest, target, 1.5 * unit_px, TARGET);
        canvas.ring(rest, 5.0 * unit_px, 1.5 * unit_px, REST);
        canvas.disc(target, 4.0 * unit_px, TARGET);
        canvas.text(self.name_place(target, name, unit_px), name, unit_px.round() as u32, NAME);
    }

    /// Returns the position of the name: beside the target, moved inside the frame if it fits.
    fn name_place(&self, target: ImagePoint, name: &str, unit_px: f64) -> ImagePoint {
        let size = DVec2::new(6.0 * name.chars().count() as f64, 9.0) * unit_px.round();
        let frame = DVec2::new(f64::from(self.frame.width), f64::from(self.frame.height));
        let beside = target.0 + DVec2::new(7.0, -4.0) * unit_px;
        let last = (frame - size - 2.0).max(DVec2::splat(2.0));
        ImagePoint(beside.clamp(DVec2::splat(2.0), last))
    }
}

/// Returns the folded cells of a lattice. The shape is computed only if there are any.
fn folds(lattice: &ScreenLattice, shape: impl Fn() -> Shape<2>) -> Vec<([usize; 2], Fold)> {
    let folded = lattice.folded_cells();
    if folded.is_empty() {
        return Vec::new();
    }
    let (_, on_model) = ModelCells::of(&lattice.grid, &shape()).folds_and_active(lattice);
    let fold = |cell: [usize; 2]| (cell, if on_model.contains(&cell) { Fold::Model } else { Fold::Empty });
    folded.into_iter().map(fold).collect()
}
