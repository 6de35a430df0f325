//! Draws what a solve did over the preview: lattice, pins, targets, folded cells.
//!
//! In: a solved [`Moment`]. Out: a [`Picture`] that can be drawn onto a preview later, on another thread.

use super::layer_pins::region;
use super::{LayerState, Moment, PinState, Setup};
use crate::image::{Canvas, Preview, Rgba8};
use crate::lattice::{Basis, SceneLattice, ScreenLattice};
use crate::screen::Camera;
use crate::space::{FrameSize, ImagePoint, ScreenPoint};
use glam::{DVec2, DVec3};

/// Line pieces a span.
const PIECES: usize = 8;

const GRID: Rgba8 = Rgba8([64, 200, 255, 150]);
const HANDLE: Rgba8 = Rgba8([64, 200, 255, 220]);
const FOLDED: Rgba8 = Rgba8([255, 40, 40, 110]);
const REGION: Rgba8 = Rgba8([255, 200, 40, 90]);
const REST: Rgba8 = Rgba8([255, 255, 255, 230]);
const TARGET: Rgba8 = Rgba8([255, 200, 40, 255]);
const NAME: Rgba8 = Rgba8([255, 255, 255, 255]);

/// What is drawn over one frame.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    frame: FrameSize,
    camera: Camera,
    layers: Vec<LayerPicture>,
}

#[derive(Clone, Debug)]
struct LayerPicture {
    lattice: SolvedLattice,
    pins: Vec<PinPicture>,
}

#[derive(Clone, Debug)]
struct PinPicture {
    state: PinState,
    name: String,
    /// Radius of its region on the screen, frame heights; `None`: none, or one of a lattice of the scene.
    radius: Option<f64>,
}

#[derive(Clone, Debug)]
enum SolvedLattice {
    Screen(ScreenLattice),
    World(SceneLattice),
}

impl SolvedLattice {
    fn of(state: &LayerState) -> Option<Self> {
        let screen = state.solution.as_ref().map(|solution| Self::Screen(solution.lattice.clone()));
        screen.or_else(|| state.world.as_ref().map(|world| Self::World(world.lattice.clone())))
    }
}

impl Picture {
    /// What a moment's solves did.
    #[must_use]
    pub(super) fn of(setup: &Setup, moment: &Moment) -> Self {
        let layers = setup.shot.layers.iter().zip(&moment.layers).filter_map(|(layer, state)| {
            let lattice = SolvedLattice::of(state)?;
            let diagonal = state.solution.as_ref().map(|solution| solution.lattice.grid.diagonal());
            let named = |pin: &PinState| PinPicture {
                state: *pin,
                name: layer.pins[pin.pin].name.clone(),
                radius: diagonal.and_then(|diagonal| region(&layer.pins[pin.pin], diagonal)).map(|one| one.radius),
            };
            let seen = state.pins.iter().filter(|pin| pin.is_in_view);
            Some(LayerPicture { lattice, pins: seen.map(named).collect() })
        });
        Self { frame: setup.shot.size, camera: moment.camera, layers: layers.collect() }
    }

    /// Draws it.
    pub(super) fn draw(&self, preview: &mut Preview) {
        // Lines keep their looks at any size of the picture.
        let unit_px = (f64::from(self.frame.height) / 720.0).max(1.0);
        let mut canvas = Canvas::new(preview);
        for layer in &self.layers {
            match &layer.lattice {
                SolvedLattice::Screen(lattice) => self.draw_lattice(&mut canvas, lattice, unit_px),
                SolvedLattice::World(lattice) => self.draw_scene_lattice(&mut canvas, lattice, unit_px),
            }
            for pin in &layer.pins {
                if let (SolvedLattice::Screen(lattice), Some(radius)) = (&layer.lattice, pin.radius) {
                    self.draw_region(&mut canvas, lattice, (pin.state.rest, radius), unit_px);
                }
                self.draw_pin(&mut canvas, (&pin.state, &pin.name), unit_px);
            }
        }
    }

    fn px(&self, point: ScreenPoint) -> ImagePoint {
        self.frame.image_from_screen(point)
    }

    /// The warped grid of the rest box, one cell a span, and the handles themselves.
    fn draw_lattice(&self, canvas: &mut Canvas, lattice: &ScreenLattice, unit_px: f64) {
        // Handles of a B-spline lie outside the box, too: the box is one span smaller on each side.
        let margin = usize::from(lattice.grid.basis == Basis::Bspline);
        let [nx, ny] = lattice.grid.dims.map(|count| lattice.grid.basis.spans(count));
        let warped = |i: f64, j: f64| {
            let share = [i / nx as f64, j / ny as f64];
            let at = |axis: usize| lattice.grid.lo[axis] + share[axis] * lattice.grid.size(axis);
            self.px(lattice.warp(ScreenPoint::new(at(0), at(1))))
        };
        let along = |k: usize| k as f64 / PIECES as f64;
        for [i, j] in lattice.folded_cells() {
            let (i, j) = ((i - margin) as f64, (j - margin) as f64);
            canvas.fill_polygon(
                &[warped(i, j), warped(i + 1.0, j), warped(i + 1.0, j + 1.0), warped(i, j + 1.0)],
                FOLDED,
            );
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

    /// The same for a lattice of the scene, as the camera sees it.
    fn draw_scene_lattice(&self, canvas: &mut Canvas, placed: &SceneLattice, unit_px: f64) {
        let SceneLattice { frame, lattice } = placed;
        let grid = &lattice.grid;
        let spans = grid.dims.map(|count| grid.basis.spans(count));
        let seen = |point: DVec3| {
            let place = self.camera.project_exact(point);
            (place.w > 0.0 && place.depth >= self.camera.near()).then(|| self.px(place.point()))
        };
        let warped = |share: [f64; 3]| {
            let at = std::array::from_fn(|axis| grid.lo[axis] + share[axis] / spans[axis] as f64 * grid.size(axis));
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

    /// The rim of a pin's region, as the lattice warps it.
    fn draw_region(
        &self,
        canvas: &mut Canvas,
        lattice: &ScreenLattice,
        (rest, radius): (ScreenPoint, f64),
        unit_px: f64,
    ) {
        let count = 8 * PIECES;
        let rim = |k: usize| {
            let turn = k as f64 / count as f64 * std::f64::consts::TAU;
            self.px(lattice.warp(ScreenPoint(rest.0 + radius * DVec2::from_angle(turn))))
        };
        (0..count).for_each(|k| canvas.line(rim(k), rim(k + 1), unit_px, REGION));
    }

    /// A ring at rest, a line to the target, a disc there, the pin's name beside it.
    fn draw_pin(&self, canvas: &mut Canvas, (pin, name): (&PinState, &str), unit_px: f64) {
        let (rest, target) = (self.px(pin.rest), self.px(pin.target));
        canvas.line(rest, target, 1.5 * unit_px, TARGET);
        canvas.ring(rest, 5.0 * unit_px, 1.5 * unit_px, REST);
        canvas.disc(target, 4.0 * unit_px, TARGET);
        let beside = ImagePoint(target.0 + DVec2::new(7.0, -4.0) * unit_px);
        canvas.text(beside, name, unit_px.round() as u32, NAME);
    }
}
