//! Lattices in scene space, placed in the rigid frame of the node that carries their box.
//!
//! In: scene points. Out: their images, and the gradient that transforms tangents and normals.

use super::grid::Lattice;
use glam::{DMat3, DMat4, DVec3};

/// The coordinate frame of a box in the scene: a rotation and an origin, so that its unit is the metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxFrame {
    /// Axes of the box in scene space: orthonormal, right-handed.
    axes: DMat3,
    origin: DVec3,
}

impl BoxFrame {
    /// The scene's own axes and origin.
    pub const SCENE: Self = Self { axes: DMat3::IDENTITY, origin: DVec3::ZERO };

    /// Creates a frame with these axes and origin; `None` if the axes are left-handed or not orthonormal within 1e-6.
    #[must_use]
    pub(crate) fn new(axes: DMat3, origin: DVec3) -> Option<Self> {
        let is_rigid = (axes * axes.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-6) && axes.determinant() > 0.0;
        (is_rigid && origin.is_finite()).then_some(Self { axes, origin })
    }

    /// Returns the rigid part of a transform: axes orthonormalised in the order x, y, z (Gram-Schmidt); scale and
    /// reflection are dropped, and an axis of length zero is replaced by the scene's.
    #[must_use]
    pub(crate) fn of(scene_from_node: DMat4) -> Self {
        let axis =
            |column: usize, fallback: DVec3| scene_from_node.col(column).truncate().try_normalize().unwrap_or(fallback);
        let x = axis(0, DVec3::X);
        let y = axis(1, DVec3::Y).reject_from_normalized(x).try_normalize().unwrap_or(x.any_orthonormal_vector());
        Self { axes: DMat3::from_cols(x, y, x.cross(y)), origin: scene_from_node.w_axis.truncate() }
    }

    /// Returns the rotation scene_from_box.
    #[must_use]
    pub const fn axes(&self) -> DMat3 {
        self.axes
    }

    /// Returns the origin of the frame in scene space.
    #[must_use]
    pub(crate) const fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Transforms a point of the box frame to scene space.
    #[must_use]
    pub(crate) fn scene_from_box(&self, point: DVec3) -> DVec3 {
        self.axes * point + self.origin
    }

    /// Transforms a scene point to the box frame.
    #[must_use]
    pub(crate) fn box_from_scene(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * (point - self.origin)
    }
}

/// A lattice in scene space.
///
/// ```
/// use glam::DVec3;
/// use pinwarp::lattice::{Basis, BoxFrame, Grid, SceneLattice};
/// let grid = Grid { dims: [4; 3], basis: Basis::Bspline, lo: [0.0; 3], hi: [1.0; 3], angle: 0.0 };
/// let mut lattice = grid.at_rest();
/// lattice.handles.iter_mut().for_each(|handle| handle[1] += 0.5);
/// let placed = SceneLattice { frame: BoxFrame::SCENE, lattice };
/// assert!(placed.warp(DVec3::splat(0.3)).distance(DVec3::new(0.3, 0.8, 0.3)) < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLattice {
    /// Frame of its box.
    pub frame: BoxFrame,
    /// The lattice in that frame, metres.
    pub lattice: Lattice<3>,
}

impl SceneLattice {
    /// Returns the image of a scene point. Outside the box it has the displacement of the nearest box point.
    #[must_use]
    pub fn warp(&self, point: DVec3) -> DVec3 {
        let at = self.frame.box_from_scene(point);
        // Rotating the displacement instead of the position keeps points at rest within rounding.
        point + self.frame.axes * (DVec3::from(self.lattice.deform(at.to_array())) - at)
    }

    /// Returns the image of a scene point, and the gradient there. Along an axis on which the point lies outside the
    /// box, the gradient is that of the identity.
    #[must_use]
    pub(crate) fn warp_with_gradient(&self, point: DVec3) -> (DVec3, DMat3) {
        let at = self.frame.box_from_scene(point);
        let inside = DVec3::from(self.lattice.grid.clamp_to_box(at.to_array()));
        let carried = self.lattice.evaluate_with_gradient(inside.to_array());
        let mut gradient = DMat3::from_cols_array_2d(&carried.gradient).transpose();
        for axis in (0..3).filter(|&axis| inside[axis] != at[axis]) {
            *gradient.col_mut(axis) = DVec3::AXES[axis];
        }
        let axes = self.frame.axes;
        (point + axes * (DVec3::from(carried.point) - inside), axes * gradient * axes.transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};

    fn bent(basis: Basis) -> SceneLattice {
        let mut lattice =
            Grid { dims: [5, 4, 6], basis, lo: [-1.0, 0.0, 0.5], hi: [1.0, 1.0, 2.0], angle: 0.0 }.at_rest();
        for (k, handle) in lattice.handles.iter_mut().enumerate() {
            (0..3).for_each(|axis| handle[axis] += 0.05 * ((k + 7 * axis) as f64).sin());
        }
        let turned = DMat4::from_rotation_y(0.7) * DMat4::from_rotation_x(-1.1) * DMat4::from_scale(DVec3::splat(3.0));
        SceneLattice { frame: BoxFrame::of(DMat4::from_translation(DVec3::new(4.0, -2.0, 1.0)) * turned), lattice }
    }

    #[test]
    fn the_gradient_is_the_slope_of_the_warp_in_scene_space() {
        for basis in [Basis::Bernstein, Basis::Bspline, Basis::Bilinear, Basis::Barytri] {
            let placed = bent(basis);
            for point in [DVec3::new(0.31, 0.43, 1.17), DVec3::new(-0.6, 0.81, 0.73), DVec3::new(1.4, 0.5, 1.9)] {
                let at = placed.frame.scene_from_box(point);
                let (image, gradient) = placed.warp_with_gradient(at);
                assert!(image.distance(placed.warp(at)) < 1e-12);
                for axis in DVec3::AXES {
                    let [low, high] = [-1e-6, 1e-6].map(|step| placed.warp(at + axis * step));
                    assert!(((high - low) / 2e-6).distance(gradient * axis) < 1e-7, "{basis:?} at {point}");
                }
            }
        }
    }

    #[test]
    fn frames_are_rigid_whatever_the_node_does() {
        let mirrored = DMat4::from_scale(DVec3::new(-2.0, 0.5, 3.0));
        let sheared =
            DMat4::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.7, 1.0, 0.0, 0.0, 0.0, 0.2, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0]);
        let flat = DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0));
        for placement in [mirrored, sheared, flat, DMat4::ZERO] {
            let axes = BoxFrame::of(placement).axes();
            assert!((axes.determinant() - 1.0).abs() < 1e-12, "{placement}");
            assert!((axes * axes.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12), "{placement}");
        }
    }

    #[test]
    fn outside_the_box_the_displacement_is_that_of_the_nearest_box_point() {
        let placed = bent(Basis::Bspline);
        let [border, outside] =
            [DVec3::new(1.0, 0.5, 1.5), DVec3::new(9.0, 0.5, 1.5)].map(|point| placed.frame.scene_from_box(point));
        assert!((placed.warp(outside) - outside).distance(placed.warp(border) - border) < 1e-12);
    }
}
