//! Neighbourhoods of pins: discs that stay smooth, so that a pin pulls out a bulge and not a spike, and regions that move rigidly
//! with their pin.
//!
//! In: pins and radii. Out: a [`Distortion`], the energy of the shape with those of the neighbourhoods,
//! E = ... + Σ_p m r²/s² (a r²/(D + 6) ‖H‖² + g ‖J̄ − R‖²), where H is the second derivative around the pin, J̄ the mean gradient
//! over the region, and R the rotation nearest to J̄.

use super::distortion::{Distortion, DistortionMetrics, Flops, RotationHessian, ScaledDirection};
use super::rotation_hessian::{differential_row, rotation_differential};
use super::rotation_response::{RotationResponse, SampleResponse};
use crate::lattice::Grid;
use crate::solve::cancel::Cancel;
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::linalg::normal_matrix::{NormalMatrix, index_extent};
use crate::solve::linalg::small_matrix::{SquareMatrix, nearest_rotation, squared_distance};
use crate::solve::problem::PointPin;
use crate::solve::second_differences::{SecondDifferences, bend_around, fade};
use crate::solve::settings::Settings;

/// Radii of the rings of quadrature points (2D: circles, 3D: spheres) relative to the radius of the disc; enough to resolve
/// cubics, the pieces of a B-spline.
const RINGS: [f64; 3] = [0.3, 0.6, 0.9];

/// Weight of a region of rigidity 1, as a multiple of the weight of the model.
const REGION_RIGIDITY: f64 = 300.0;

/// Disc or rigid region around a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PinNeighbourhood<const D: usize> {
    at: [f64; D],
    radius: f64,
    /// a: weight of the deviation from an affine map.
    affine: f64,
    /// g: weight of the deviation of that affine map from a rotation.
    rigid: f64,
}

/// A pin whose neighbourhoods act on unknowns other than the handles of a grid.
pub(crate) trait Neighbourhood<const D: usize> {
    /// The pin.
    fn pin(&self) -> &PointPin<D>;

    /// Converts rows over handles around the pin to rows over unknowns.
    fn rows(&self, rows: &LeastSquaresRows<D>) -> LeastSquaresRows<D>;

    /// Returns the weighted mean of ∇W at points around the pin, as (unknown, gradient) in ascending order of the unknowns.
    fn mean_gradient(&self, points: &[([f64; D], f64)]) -> Vec<(usize, [f64; D])>;
}

/// A region that stays rigid: the coefficients of its mean gradient J̄.
#[derive(Clone, Debug)]
struct RigidRegion<const D: usize> {
    /// Handles and the mean of their ∇W over the region.
    mean: Vec<(usize, [f64; D])>,
    weight: f64,
}

/// The energy of a shape and of the neighbourhoods of its pins.
#[derive(Debug)]
pub(crate) struct WithPinNeighbourhoods<const D: usize> {
    shape: Box<dyn Distortion<D>>,
    /// Rows of the discs, each set with its weight.
    discs: Vec<(f64, LeastSquaresRows<D>)>,
    regions: Vec<RigidRegion<D>>,
}

impl<const D: usize> WithPinNeighbourhoods<D> {
    /// Adds the neighbourhoods of the pins to the energy of a shape; returns that energy unchanged if there are none.
    pub(crate) fn around(
        shape: Box<dyn Distortion<D>>,
        grid: &Grid<D>,
        pins: &[PointPin<D>],
        settings: &Settings,
    ) -> Box<dyn Distortion<D>> {
        let specs: Vec<_> = pins.iter().flat_map(|pin| PinNeighbourhood::of(grid, pin, settings)).collect();
        if specs.is_empty() {
            return shape;
        }
        let mass = shape.mass();
        let mut with_pins = Self { shape, discs: Vec::new(), regions: Vec::new() };
        let kinds = SecondDifferences::of(grid);
        for spec in &specs {
            with_pins.add((grid, &kinds), spec, mass * (spec.radius / grid.diagonal()).powi(2));
        }
        Box::new(with_pins)
    }

    /// Same as [`Self::around`] for unknowns other than handles. `rows` are additional rows of the energy, weighted relative to
    /// its mean.
    pub(crate) fn over(
        shape: Box<dyn Distortion<D>>,
        grid: &Grid<D>,
        settings: &Settings,
        (pins, rows): (&[impl Neighbourhood<D>], LeastSquaresRows<D>),
    ) -> Box<dyn Distortion<D>> {
        let mass = shape.mass();
        let mut with_pins = Self { shape, discs: vec![(mass, rows)], regions: Vec::new() };
        let kinds = SecondDifferences::of(grid);
        for around in pins {
            for spec in PinNeighbourhood::of(grid, around.pin(), settings) {
                let size = mass * (spec.radius / grid.diagonal()).powi(2);
                if spec.rigid > 0.0 {
                    let mean = around.mean_gradient(&pattern(grid, &spec));
                    with_pins.regions.push(RigidRegion { mean, weight: size * spec.rigid });
                }
                let rows = around.rows(&bend_around(&kinds, grid, (spec.at, spec.radius)));
                with_pins.discs.push((size * spec.bend_weight(), rows));
            }
        }
        Box::new(with_pins)
    }

    fn disc_energy(&self, handles: &[[f64; D]]) -> f64 {
        self.discs.iter().map(|(weight, rows)| weight * rows.energy(handles)).sum()
    }

    fn add(&mut self, (grid, kinds): (&Grid<D>, &[SecondDifferences<D>]), spec: &PinNeighbourhood<D>, size: f64) {
        if spec.rigid > 0.0 {
            self.regions
                .push(RigidRegion { mean: mean_gradient(grid, &pattern(grid, spec)), weight: size * spec.rigid });
        }
        self.discs.push((size * spec.bend_weight(), bend_around(kinds, grid, (spec.at, spec.radius))));
    }
}

impl<const D: usize> PinNeighbourhood<D> {
    /// Returns the disc of a pin and its rigid region, as far as they have a radius and a weight; both weights fade with that of
    /// the pin.
    fn of(grid: &Grid<D>, pin: &PointPin<D>, settings: &Settings) -> Vec<Self> {
        let disc = Self {
            at: pin.at,
            radius: settings.disc.radius * grid.diagonal(),
            affine: settings.disc.weight * pin.weight * share_of_disc(grid, settings),
            rigid: 0.0,
        };
        let region = pin.region.map(|region| {
            let firmness = REGION_RIGIDITY * region.rigidity * pin.weight;
            // The gradient that a pin prescribes already determines the mean gradient of the region.
            let rigid = if pin.gradient.is_some() { 0.0 } else { firmness };
            Self { radius: region.radius, affine: firmness, rigid, ..disc }
        });
        [Some(disc), region].into_iter().flatten().filter(|spec| spec.radius > 0.0 && spec.affine > 0.0).collect()
    }

    /// Weight of ‖H‖². Where H is constant, Σ_k ω_k ‖J_k − J̄‖² is ‖H‖² r² / (D + 6) for the weights ω of `fade`.
    fn bend_weight(&self) -> f64 {
        self.affine * (self.radius.powi(2) / (D + 6) as f64)
    }
}

/// Fraction of the disc's weight that is used. A lattice whose handle spacing exceeds the radius cannot form a spike; there the
/// disc would only stiffen limbs (docs/METHOD.md, "Discs and regions of pins").
fn share_of_disc<const D: usize>(grid: &Grid<D>, settings: &Settings) -> f64 {
    let pitch = (0..D).map(|axis| grid.spacing(axis)).fold(0.0, f64::max);
    (settings.disc.radius * grid.diagonal() / pitch).min(1.0).powi(6)
}

/// Returns Σ ω_k ∇W(x_k) over the points of a pattern, as (handle, gradient) in ascending order of the handles.
fn mean_gradient<const D: usize>(grid: &Grid<D>, points: &[([f64; D], f64)]) -> Vec<(usize, [f64; D])> {
    let mut mean = std::collections::BTreeMap::new();
    for (point, share) in points {
        grid.for_each_weight(*point, |term| {
            let slot = mean.entry(term.handle).or_insert([0.0; D]);
            (0..D).for_each(|axis| slot[axis] += share * term.gradient[axis]);
        });
    }
    mean.into_iter().collect()
}

impl<const D: usize> RigidRegion<D> {
    /// Mean gradient J̄ over the region.
    fn gradient_at(&self, handles: &[[f64; D]]) -> SquareMatrix<D> {
        let mut gradient = [[0.0; D]; D];
        for &(handle, mean) in &self.mean {
            for (row, coordinate) in gradient.iter_mut().zip(handles[handle]) {
                (0..D).for_each(|axis| row[axis] += coordinate * mean[axis]);
            }
        }
        gradient
    }

    /// Adds `scale` · matrix · (mean gradient of W) to the sum of every handle of the region.
    fn add_scaled(&self, scale: f64, matrix: &SquareMatrix<D>, sums: &mut [[f64; D]]) {
        for (handle, mean) in &self.mean {
            for (slot, row) in sums[*handle].iter_mut().zip(matrix) {
                *slot += scale * (0..D).map(|axis| row[axis] * mean[axis]).sum::<f64>();
            }
        }
    }
}

impl<const D: usize> Distortion<D> for WithPinNeighbourhoods<D> {
    fn mass(&self) -> f64 {
        self.shape.mass()
    }

    fn bandwidth(&self) -> usize {
        let regions = self.regions.iter().filter_map(|region| index_extent(region.mean.iter().map(|entry| entry.0)));
        let discs = self.discs.iter().map(|(_, rows)| rows.bandwidth());
        regions.chain(discs).fold(self.shape.bandwidth(), usize::max)
    }

    fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel) {
        self.shape.add_normal(scale, normal, cancel);
        self.discs.iter().for_each(|(weight, rows)| rows.add_normal(scale * weight, normal, cancel));
        for region in &self.regions {
            for axis in 0..D {
                let row: Vec<_> = region.mean.iter().map(|(handle, mean)| (*handle, mean[axis])).collect();
                normal.add_row(scale * region.weight, &row);
            }
        }
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]], cancel: &Cancel) -> f64 {
        let mut energy = self.shape.local_step(handles, scale, right_side, cancel) + self.disc_energy(handles);
        for region in &self.regions {
            let gradient = region.gradient_at(handles);
            let wanted = nearest_rotation(&gradient);
            energy += region.weight * squared_distance(&gradient, &wanted);
            region.add_scaled(scale * region.weight, &wanted, right_side);
        }
        energy
    }

    fn flops(&self) -> Option<Flops> {
        self.shape.flops()
    }

    fn subtract_rotation_hessian(
        &self,
        handles: &[[f64; D]],
        hessian: RotationHessian,
        normal: &mut NormalMatrix,
        cancel: &Cancel,
    ) {
        self.shape.subtract_rotation_hessian(handles, hessian, normal, cancel);
        // In 3D the rotation Hessian of regions is left out, so the matrix is an upper bound of the second derivative.
        if D != 2 {
            return;
        }
        for region in &self.regions {
            let differential = rotation_differential(&region.gradient_at(handles), hessian.limit);
            let row = region.mean.iter().flat_map(|(handle, mean)| {
                let [x, y] = differential_row(differential, [mean[0], mean[1]]);
                [(2 * handle, x), (2 * handle + 1, y)]
            });
            normal.add_row(-hessian.scale * region.weight, &row.collect::<Vec<_>>());
        }
    }

    fn rotation_response(&self, handles: &[[f64; D]], limit: f64) -> Option<RotationResponse<D>> {
        let mut response = self.shape.rotation_response(handles, limit)?;
        let regions = self.regions.iter().map(|region| SampleResponse::at(&region.gradient_at(handles), limit));
        response.regions.extend(regions);
        Some(response)
    }

    fn subtract_rotation_product(
        &self,
        response: &RotationResponse<D>,
        along: ScaledDirection<D>,
        product: &mut [[f64; D]],
        cancel: &Cancel,
    ) {
        self.shape.subtract_rotation_product(response, along, product, cancel);
        let ScaledDirection { direction, scale } = along;
        for (region, response) in self.regions.iter().zip(&response.regions) {
            let turned = response.turned(&region.gradient_at(direction));
            region.add_scaled(-scale * region.weight, &turned, product);
        }
    }

    fn energy(&self, handles: &[[f64; D]], rotations_at: &[[f64; D]]) -> f64 {
        let regions = self.regions.iter().map(|region| {
            let wanted = nearest_rotation(&region.gradient_at(rotations_at));
            region.weight * squared_distance(&region.gradient_at(handles), &wanted)
        });
        self.shape.energy(handles, rotations_at) + self.disc_energy(handles) + regions.sum::<f64>()
    }

    fn metrics(&self, handles: &[[f64; D]]) -> DistortionMetrics {
        self.shape.metrics(handles)
    }
}

/// Returns quadrature points of a disc with weights that sum to 1: the fade ω times the measure of the ring. Points outside the
/// box are moved to its border.
fn pattern<const D: usize>(grid: &Grid<D>, spec: &PinNeighbourhood<D>) -> Vec<([f64; D], f64)> {
    let mut points = vec![(grid.clamp_to_box(spec.at), 0.1_f64.powi(D as i32))];
    let directions = directions::<D>();
    for ring in RINGS {
        let share = ring.powi(D as i32 - 1) * fade(ring) / directions.len() as f64;
        for direction in &directions {
            let at = std::array::from_fn(|d| spec.at[d] + spec.radius * ring * direction[d]);
            points.push((grid.clamp_to_box(at), share));
        }
    }
    let total: f64 = points.iter().map(|point| point.1).sum();
    points.iter_mut().for_each(|point| point.1 /= total);
    points
}

/// Returns evenly distributed unit vectors: eight around a circle, or the face centres and corners of a cube.
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
