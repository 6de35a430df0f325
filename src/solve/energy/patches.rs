//! Neighbourhoods of pins: a disc that stays smooth, so that a pin pulls a bulge and not a spike, and regions that move
//! with their pin as one piece.
//!
//! In: pins, radii. Out: a [`Distortion`] around the shape's own, E = ... + Σ_p m r²/s² (a r²/(D + 6) ‖H‖² + g ‖J̄ − R‖²).
//! H is the second derivative around the pin, J̄ the mean gradient over the region, R the rotation nearest to it.

use super::turns::{turn, turned_row};
use super::{Distortion, Quality, Turns, Work};
use crate::lattice::Grid;
use crate::solve::bend::{SecondDifferences, bend_around, fade};
use crate::solve::matrix::Normal;
use crate::solve::packs::span;
use crate::solve::rows::RowSet;
use crate::solve::small::{Square, nearest_rotation, squared_distance};
use crate::solve::{PointPin, Settings};

/// Radii of the rings (2D: circles, 3D: spheres) as parts of the disc's; they see cubics, the pieces of a B-spline.
const RINGS: [f64; 3] = [0.3, 0.6, 0.9];

/// How firmly a region with a grip of 1 moves as one piece, as a multiple of the model's own firmness.
const GRIP: f64 = 300.0;

/// One neighbourhood.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spec<const D: usize> {
    at: [f64; D],
    radius: f64,
    /// a: how firmly it stays an affine image of itself.
    affine: f64,
    /// g: how firmly that image is a rigid one.
    rigid: f64,
}

/// J̄ of one neighbourhood, with its rotation.
#[derive(Clone, Debug)]
struct Piece<const D: usize> {
    /// Handles and their mean gradients.
    mean: Vec<(usize, [f64; D])>,
    weight: f64,
}

/// A distortion with the neighbourhoods of its pins.
#[derive(Debug)]
pub(crate) struct Patched<const D: usize> {
    shape: Box<dyn Distortion<D>>,
    /// Each with its weight.
    discs: Vec<(f64, RowSet<D>)>,
    pieces: Vec<Piece<D>>,
}

impl<const D: usize> Patched<D> {
    /// Adds the neighbourhoods of the pins, where there are any.
    pub(crate) fn around(
        shape: Box<dyn Distortion<D>>,
        grid: &Grid<D>,
        pins: &[PointPin<D>],
        settings: &Settings,
    ) -> Box<dyn Distortion<D>> {
        let specs: Vec<_> = pins.iter().flat_map(|pin| Spec::of(grid, pin, settings)).collect();
        if specs.is_empty() {
            return shape;
        }
        let mass = shape.mass();
        let mut patched = Self { shape, discs: Vec::new(), pieces: Vec::new() };
        let kinds = SecondDifferences::of(grid);
        for spec in &specs {
            patched.add((grid, &kinds), spec, mass * (spec.radius / grid.diagonal()).powi(2));
        }
        Box::new(patched)
    }

    fn disc_energy(&self, handles: &[[f64; D]]) -> f64 {
        self.discs.iter().map(|(weight, rows)| weight * rows.energy(handles)).sum()
    }

    fn add(&mut self, (grid, kinds): (&Grid<D>, &[SecondDifferences<D>]), spec: &Spec<D>, size: f64) {
        if spec.rigid > 0.0 {
            self.pieces.push(Piece { mean: mean_gradient(grid, &pattern(grid, spec)), weight: size * spec.rigid });
        }
        // Of a field with one second derivative H all over, Σ_k ω_k ‖J_k − J̄‖² is ‖H‖² r² / (D + 6) for this fade.
        let spread = spec.radius.powi(2) / (D + 6) as f64;
        self.discs.push((size * spec.affine * spread, bend_around(kinds, grid, (spec.at, spec.radius))));
    }
}

impl<const D: usize> Spec<D> {
    /// The disc of a pin and the region it grips; both fade with the pin.
    fn of(grid: &Grid<D>, pin: &PointPin<D>, settings: &Settings) -> Vec<Self> {
        let disc = Self {
            at: pin.at,
            radius: settings.disc.radius * grid.diagonal(),
            affine: settings.disc.weight * pin.weight * share_of_disc(grid, settings),
            rigid: 0.0,
        };
        let grip = pin.region.map(|region| {
            let firmness = GRIP * region.grip * pin.weight;
            // A pin that holds a gradient gives it to the region: all gradients in it are equal.
            let rigid = if pin.gradient.is_some() { 0.0 } else { firmness };
            Self { radius: region.radius, affine: firmness, rigid, ..disc }
        });
        [Some(disc), grip].into_iter().flatten().filter(|spec| spec.radius > 0.0 && spec.affine > 0.0).collect()
    }
}

/// How much of a disc's weight is needed: a lattice whose handles are farther apart than the radius has nothing to make a
/// spike of, and there the disc would only stiffen limbs (docs/METHOD.md has what it costs).
fn share_of_disc<const D: usize>(grid: &Grid<D>, settings: &Settings) -> f64 {
    let pitch = (0..D).map(|axis| grid.pitch(axis)).fold(0.0, f64::max);
    (settings.disc.radius * grid.diagonal() / pitch).min(1.0).powi(6)
}

/// Σ ω_k ∇W(x_k) over the points of a pattern: handles, ascending, and their gradients.
fn mean_gradient<const D: usize>(grid: &Grid<D>, points: &[([f64; D], f64)]) -> Vec<(usize, [f64; D])> {
    let mut mean = std::collections::BTreeMap::new();
    for (point, share) in points {
        grid.visit(*point, |term| {
            let slot = mean.entry(term.handle).or_insert([0.0; D]);
            (0..D).for_each(|axis| slot[axis] += share * term.gradient[axis]);
        });
    }
    mean.into_iter().collect()
}

impl<const D: usize> Piece<D> {
    /// J̄.
    fn gradient_at(&self, handles: &[[f64; D]]) -> Square<D> {
        let mut gradient = [[0.0; D]; D];
        for &(handle, mean) in &self.mean {
            for (row, coordinate) in gradient.iter_mut().zip(handles[handle]) {
                (0..D).for_each(|axis| row[axis] += coordinate * mean[axis]);
            }
        }
        gradient
    }
}

impl<const D: usize> Distortion<D> for Patched<D> {
    fn mass(&self) -> f64 {
        self.shape.mass()
    }

    fn reach(&self) -> usize {
        let pieces = self.pieces.iter().filter_map(|piece| span(piece.mean.iter().map(|entry| entry.0)));
        let discs = self.discs.iter().map(|(_, rows)| rows.reach());
        pieces.chain(discs).fold(self.shape.reach(), usize::max)
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        self.shape.add_normal(scale, normal);
        self.discs.iter().for_each(|(weight, rows)| rows.add_normal(scale * weight, normal));
        for piece in &self.pieces {
            for axis in 0..D {
                let row: Vec<_> = piece.mean.iter().map(|(handle, mean)| (*handle, mean[axis])).collect();
                normal.add_row(scale * piece.weight, &row);
            }
        }
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) -> f64 {
        let mut energy = self.shape.local_step(handles, scale, right_side) + self.disc_energy(handles);
        for piece in &self.pieces {
            let gradient = piece.gradient_at(handles);
            let wanted = nearest_rotation(&gradient);
            energy += piece.weight * squared_distance(&gradient, &wanted);
            for (handle, mean) in &piece.mean {
                for (slot, row) in right_side[*handle].iter_mut().zip(&wanted) {
                    *slot += scale * piece.weight * (0..D).map(|axis| row[axis] * mean[axis]).sum::<f64>();
                }
            }
        }
        energy
    }

    fn work(&self) -> Option<Work> {
        self.shape.work()
    }

    fn subtract_turns(&self, handles: &[[f64; D]], turns: Turns, normal: &mut Normal) {
        self.shape.subtract_turns(handles, turns, normal);
        for piece in &self.pieces {
            let turn = turn(&piece.gradient_at(handles), turns.limit);
            let row = piece.mean.iter().flat_map(|(handle, mean)| {
                let [x, y] = turned_row(turn, [mean[0], mean[1]]);
                [(2 * handle, x), (2 * handle + 1, y)]
            });
            normal.add_row(-turns.scale * piece.weight, &row.collect::<Vec<_>>());
        }
    }

    fn energy(&self, handles: &[[f64; D]], turned_at: &[[f64; D]]) -> f64 {
        let pieces = self.pieces.iter().map(|piece| {
            let wanted = nearest_rotation(&piece.gradient_at(turned_at));
            piece.weight * squared_distance(&piece.gradient_at(handles), &wanted)
        });
        self.shape.energy(handles, turned_at) + self.disc_energy(handles) + pieces.sum::<f64>()
    }

    fn quality(&self, handles: &[[f64; D]]) -> Quality {
        self.shape.quality(handles)
    }
}

/// Points over the disc with shares that add up to 1: ω fades to the rim, times the room a ring has. Points outside the box stand on its border.
fn pattern<const D: usize>(grid: &Grid<D>, spec: &Spec<D>) -> Vec<([f64; D], f64)> {
    let mut points = vec![(grid.nearest_in_box(spec.at), 0.1_f64.powi(D as i32))];
    let directions = directions::<D>();
    for ring in RINGS {
        let share = ring.powi(D as i32 - 1) * fade(ring) / directions.len() as f64;
        for direction in &directions {
            let at = std::array::from_fn(|d| spec.at[d] + spec.radius * ring * direction[d]);
            points.push((grid.nearest_in_box(at), share));
        }
    }
    let total: f64 = points.iter().map(|point| point.1).sum();
    points.iter_mut().for_each(|point| point.1 /= total);
    points
}

/// Evenly spread unit vectors: eight around a circle; the corners and face middles of a cube.
fn directions<const D: usize>() -> Vec<[f64; D]> {
    if D == 2 {
        let around = (0..8).map(|k| (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos());
        return around.map(|(sin, cos)| std::array::from_fn(|d| if d == 0 { cos } else { sin })).collect();
    }
    let faces = (0..2 * D).map(|k| {
        std::array::from_fn(|d| {
            if k / 2 != d {
                0.0
            } else if k % 2 == 0 {
                1.0
            } else {
                -1.0
            }
        })
    });
    let side = 1.0 / (D as f64).sqrt();
    let corners = (0..1_usize << D).map(|k| std::array::from_fn(|d| if k >> d & 1 == 0 { side } else { -side }));
    faces.chain(corners).collect()
}
