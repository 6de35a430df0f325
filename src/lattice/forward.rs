//! Evaluates the free-form deformation: images of points, and the gradient.
//!
//! In: moved handles and a point. Out: v = Σ_h W_h P_h (paper, equation 1) and J = Σ_h P_h ∇W_hᵀ, J[row][column].

use super::axis::{AxisTerms, MAX_HANDLES, MAX_LOCAL};
use super::basis::Support;
use super::grid::Lattice;
use crate::space::ScreenPoint;
use glam::{DMat2, DVec2};

/// The image of a point, and the gradient there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointAndGradient<const D: usize> {
    /// Image of the point.
    pub point: [f64; D],
    /// Gradient, `[row][column]`: column c is the image of axis c.
    pub gradient: [[f64; D]; D],
}

impl<const D: usize> Lattice<D> {
    /// Returns the image of a point; outside the box the polynomials are extended.
    #[must_use]
    pub fn evaluate(&self, point: [f64; D]) -> [f64; D] {
        let mut image = [0.0; D];
        self.grid.for_each_weight(point, |term| {
            let handle = self.handles[term.handle];
            for axis in 0..D {
                image[axis] += term.weight * handle[axis];
            }
        });
        image
    }

    /// Returns the image of a point; outside the box it has the displacement of the nearest box point.
    #[must_use]
    pub fn deform(&self, point: [f64; D]) -> [f64; D] {
        let inside = self.grid.clamp_to_box(point);
        let image = self.evaluate(inside);
        std::array::from_fn(|axis| point[axis] + (image[axis] - inside[axis]))
    }

    /// Returns the image and the gradient of a point; outside the box the polynomials are extended.
    #[must_use]
    pub(crate) fn evaluate_with_gradient(&self, point: [f64; D]) -> PointAndGradient<D> {
        let mut carried = PointAndGradient { point: [0.0; D], gradient: [[0.0; D]; D] };
        self.grid.for_each_weight(point, |term| {
            let handle = self.handles[term.handle];
            for (row, coordinate) in handle.into_iter().enumerate() {
                carried.point[row] += term.weight * coordinate;
                (0..D).for_each(|column| carried.gradient[row][column] += term.gradient[column] * coordinate);
            }
        });
        carried
    }
}

impl Lattice<2> {
    /// Returns the image of a point. Outside the box it has the displacement of the nearest box point.
    #[must_use]
    pub fn warp(&self, point: ScreenPoint) -> ScreenPoint {
        let inside = DVec2::from(self.grid.clamp_to_box(point.0.to_array()));
        let at = inside.to_array();
        let image = match self.grid.basis.support() {
            Support::Simplex => DVec2::from(self.evaluate(at)),
            Support::Tensor { .. } => sum_rows(self, &self.grid.axes::<MAX_LOCAL>(at)),
            Support::Global => sum_rows(self, &self.grid.axes::<MAX_HANDLES>(at)),
        };
        ScreenPoint(point.0 + (image - inside))
    }

    /// Returns the gradient of [`Self::warp`] at a point. Along an axis on which the point lies outside the box, it is
    /// that of the identity.
    #[must_use]
    pub(crate) fn jacobian(&self, point: ScreenPoint) -> DMat2 {
        // The point before the rotation of the box, and the nearest box point.
        let upright = DVec2::from(self.grid.upright_from_point(point.0.to_array()));
        let inside = upright.clamp(self.grid.lo.into(), self.grid.hi.into());
        let at = if inside == upright { point.0.to_array() } else { self.grid.point_from_upright(inside.to_array()) };
        // Skipped without a rotation: this is called often.
        let axes = (self.grid.angle != 0.0).then(|| DMat2::from_angle(self.grid.angle));
        let along_box = match self.grid.basis.support() {
            Support::Simplex => {
                let [[xx, xy], [yx, yy]] = self.evaluate_with_gradient(at).gradient;
                let gradient = DMat2::from_cols_array_2d(&[[xx, yx], [xy, yy]]);
                axes.map_or(gradient, |axes| gradient * axes)
            }
            Support::Tensor { .. } => gradient_of_rows(self, &self.grid.axes::<MAX_LOCAL>(at)),
            Support::Global => gradient_of_rows(self, &self.grid.axes::<MAX_HANDLES>(at)),
        };
        let beyond = axes.unwrap_or(DMat2::IDENTITY);
        let x_axis = if inside.x == upright.x { along_box.x_axis } else { beyond.x_axis };
        let y_axis = if inside.y == upright.y { along_box.y_axis } else { beyond.y_axis };
        let gradient = DMat2::from_cols(x_axis, y_axis);
        axes.map_or(gradient, |axes| gradient * axes.transpose())
    }
}

/// Returns Σ_j y_j Σ_i x_i P_ij: two short loops instead of one product per handle.
fn sum_rows<const N: usize>(lattice: &Lattice<2>, [x, y]: &[AxisTerms<N>; 2]) -> DVec2 {
    let width = lattice.grid.dims[0];
    let mut image = DVec2::ZERO;
    for (row, weight) in y.values().iter().enumerate() {
        let start = (y.first + row) * width + x.first;
        let handles = &lattice.handles[start..start + x.values().len()];
        let sum: DVec2 = handles.iter().zip(x.values()).map(|(&handle, &w)| DVec2::from(handle) * w).sum();
        image += sum * *weight;
    }
    image
}

/// Returns the derivatives along the axes of the box from the functions of the axes.
fn gradient_of_rows<const N: usize>(lattice: &Lattice<2>, [x, y]: &[AxisTerms<N>; 2]) -> DMat2 {
    let Lattice { grid, handles } = lattice;
    let width = grid.dims[0];
    let mut columns = [DVec2::ZERO; 2];
    for (row, (value, slope)) in y.values().iter().zip(y.slopes()).enumerate() {
        let start = (y.first + row) * width + x.first;
        let (mut sum, mut slant) = (DVec2::ZERO, DVec2::ZERO);
        for (i, &handle) in handles[start..start + x.values().len()].iter().enumerate() {
            sum += DVec2::from(handle) * x.values()[i];
            slant += DVec2::from(handle) * x.slopes()[i];
        }
        columns[0] += slant * *value;
        columns[1] += sum * *slope;
    }
    DMat2::from_cols(columns[0] / grid.size(0), columns[1] / grid.size(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};

    fn bent(basis: Basis) -> Lattice<2> {
        let mut lattice = Grid { dims: [6, 7], basis, lo: [0.0, 0.0], hi: [2.0, 1.0], angle: 0.0 }.at_rest();
        for (k, handle) in lattice.handles.iter_mut().enumerate() {
            *handle = [handle[0] + 0.05 * (k as f64).sin(), handle[1] + 0.05 * (1.3 * k as f64).cos()];
        }
        lattice
    }

    impl Lattice<2> {
        /// The lattice rotated with its box.
        fn rotated(&self, angle: f64) -> Self {
            let grid = Grid { angle, ..self.grid.clone() };
            Self { handles: self.handles.iter().map(|&handle| grid.point_from_upright(handle)).collect(), grid }
        }
    }

    #[test]
    fn outside_the_box_the_displacement_is_that_of_the_nearest_box_point() {
        for lattice in Basis::ALL.map(bent) {
            let rotated = lattice.rotated(0.7);
            for point in [[2.3, 0.3], [-0.4, 1.2], [1.1, 0.4]] {
                let [place, wanted] =
                    [point, lattice.deform(point)].map(|point| rotated.grid.point_from_upright(point));
                let gap = rotated.warp(ScreenPoint(place.into())).0 - DVec2::from(wanted);
                assert!(
                    gap.length() < 1e-12 && (DVec2::from(rotated.deform(place)) - DVec2::from(wanted)).length() < 1e-12
                );
            }
            let border = ScreenPoint::new(2.0, 0.3);
            let outside = lattice.warp(ScreenPoint::new(5.0, 0.3));
            let wanted = lattice.warp(border).0 + DVec2::new(3.0, 0.0);
            assert!((outside.0 - wanted).length() < 1e-12);
            assert_eq!(
                lattice.deform([5.0, 0.3]).map(|x| (x * 1e9).round()),
                wanted.to_array().map(|x| (x * 1e9).round())
            );
            assert_eq!(lattice.jacobian(ScreenPoint::new(5.0, 0.3)).x_axis, DVec2::X);
        }
    }

    #[test]
    fn the_jacobian_is_the_slope_of_the_warp() {
        let rotated = Basis::ALL.map(bent).map(|lattice| lattice.rotated(0.5));
        for lattice in Basis::ALL.map(bent).into_iter().chain(rotated) {
            for point in [DVec2::new(0.71, 0.33), DVec2::new(1.23, 0.77), DVec2::new(0.5, 1.4)] {
                let gradient = lattice.jacobian(ScreenPoint(point));
                for (axis, column) in [(DVec2::X, gradient.x_axis), (DVec2::Y, gradient.y_axis)] {
                    let [low, high] = [-1e-6, 1e-6].map(|step| lattice.warp(ScreenPoint(point + axis * step)).0);
                    assert!(((high - low) / 2e-6 - column).length() < 1e-7);
                }
            }
        }
    }
}
