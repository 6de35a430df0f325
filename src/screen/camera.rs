//! The camera: projects scene points to homogeneous screen points.
//!
//! In: the camera's placement and lens, the frame. Out: [`Projected`] points, and the matrices stored in EXR files.

use crate::pose::Pose;
use crate::scene::Lens;
use crate::space::{FrameSize, ScenePoint, ScreenPoint, ScreenVector};
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, Vec3};

/// Vertical field of view of the automatic camera in degrees: a portrait lens.
const AUTOMATIC_YFOV_DEGREES: f64 = 30.0;

/// Direction from the scene's centre to the automatic camera: in front, slightly to the right and above.
const AUTOMATIC_DIRECTION: DVec3 = DVec3::new(0.35, 0.22, 1.0);

/// Frame size relative to the size of the fitted content.
const FIT_AIR: f64 = 1.05;

/// A camera at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// view_from_scene: the camera looks along −z, y up.
    view_from_scene: DMat4,
    lens: Lens,
    near: f64,
    aspect: f64,
}

/// A projected point. Its screen position is `h / w`, in frame heights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projected {
    /// Homogeneous screen position (x·w, y·w).
    pub h: DVec2,
    /// Perspective: the depth; orthographic: 1.
    pub w: f64,
    /// Distance along the view axis, metres.
    pub depth: f64,
}

impl Projected {
    /// Returns its screen position; valid only for points beyond the near plane (w > 0).
    #[must_use]
    pub fn point(self) -> ScreenPoint {
        ScreenPoint(self.h / self.w)
    }

    /// Interpolates linearly in scene space, by a fraction `t` of the way to `other`. Symmetric for t = 0.5.
    #[must_use]
    pub(crate) fn lerp(self, other: Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a * (1.0 - t) + b * t;
        Self { h: self.h * (1.0 - t) + other.h * t, w: mix(self.w, other.w), depth: mix(self.depth, other.depth) }
    }
}

impl Camera {
    /// Creates the camera of a node placed by `scene_from_camera` (scale and reflection are ignored, as glTF requires).
    ///
    /// `near` is kept above a millionth of a metre for a perspective lens.
    #[must_use]
    pub fn new(scene_from_camera: Mat4, lens: Lens, near: f32, frame: FrameSize) -> Self {
        let placed = scene_from_camera.as_dmat4();
        let axis = |column: DVec4, fallback: DVec3| column.truncate().try_normalize().unwrap_or(fallback).extend(0.0);
        let (y, z) = (axis(placed.y_axis, DVec3::Y), axis(placed.z_axis, DVec3::Z));
        let x = if placed.determinant() < 0.0 {
            y.truncate().cross(z.truncate()).extend(0.0)
        } else {
            axis(placed.x_axis, DVec3::X)
        };
        let rigid = DMat4::from_cols(x, y, z, placed.w_axis);
        let near = match lens {
            Lens::Perspective { .. } => f64::from(near).max(1e-6),
            Lens::Orthographic { .. } => f64::from(near),
        };
        Self { view_from_scene: rigid.inverse(), lens, near, aspect: frame.aspect() }
    }

    /// Creates a camera at a placement. `near`: distance of the near plane in metres, > 0 for a perspective lens.
    #[must_use]
    pub(crate) fn placed(placement: &CameraPlacement, lens: Lens, near: f64, frame: FrameSize) -> Self {
        Self { view_from_scene: placement.scene_from_view.inverse(), lens, near, aspect: frame.aspect() }
    }

    /// Projects a scene point to the screen.
    #[must_use]
    pub fn project(&self, point: ScenePoint) -> Projected {
        self.project_exact(point.0.as_dvec3())
    }

    /// Projects a point in f64, without rounding it to f32 as mesh vertices are.
    #[must_use]
    pub(crate) fn project_exact(&self, point: DVec3) -> Projected {
        let view = self.view_from_scene.transform_point3(point);
        let depth = -view.z;
        let w = match self.lens {
            Lens::Perspective { .. } => depth,
            Lens::Orthographic { .. } => 1.0,
        };
        let half = DVec2::new(self.aspect * 0.5, 0.5);
        Projected { h: view.truncate() * (0.5 * self.zoom()) + half * w, w, depth }
    }

    /// Returns the direction of a vector at a point of the scene as the camera sees it: the derivative of the projection, up to a
    /// positive factor.
    #[must_use]
    pub(crate) fn direction_seen(&self, at: DVec3, vector: DVec3) -> ScreenVector {
        let (from, to) = (self.project_exact(at), self.project_exact(at + vector));
        ScreenVector((to.h - from.h) * from.w - from.h * (to.w - from.w))
    }

    /// Returns the unit vector from the eye to a point of the scene; with a parallel projection, the direction of view.
    #[must_use]
    pub(crate) fn line_of_sight(&self, at: DVec3) -> DVec3 {
        let view = self.view_from_scene.transform_point3(at);
        let sight = if self.is_parallel() { DVec3::NEG_Z } else { view.normalize_or(DVec3::NEG_Z) };
        self.scene_from_view().transform_vector3(sight)
    }

    /// Returns the scene vector that moves a point of the given w by `vector` on the screen at constant depth.
    #[must_use]
    pub fn scene_from_screen_vector(&self, vector: ScreenVector, w: f64) -> DVec3 {
        let in_view = (vector.0 * (w / (0.5 * self.zoom()))).extend(0.0);
        self.scene_from_view().transform_vector3(in_view)
    }

    /// Returns the length of a frame height at a depth, metres.
    #[must_use]
    pub(crate) fn frame_height_at(&self, depth: f64) -> f64 {
        let w = if self.is_parallel() { 1.0 } else { depth };
        self.scene_from_screen_vector(ScreenVector(DVec2::Y), w).length()
    }

    /// Returns half frame heights per metre at depth 1.
    fn zoom(&self) -> f64 {
        match self.lens {
            Lens::Perspective { yfov } => 1.0 / (f64::from(yfov) * 0.5).tan(),
            Lens::Orthographic { ymag } => 1.0 / f64::from(ymag),
        }
    }

    /// Returns the lens.
    #[cfg(any(test, feature = "cli"))]
    #[must_use]
    pub(crate) const fn lens(&self) -> Lens {
        self.lens
    }

    /// Returns the distance of the near plane in metres.
    #[must_use]
    pub const fn near(&self) -> f64 {
        self.near
    }

    /// Returns whether the lens is orthographic.
    #[must_use]
    pub(crate) const fn is_parallel(&self) -> bool {
        matches!(self.lens, Lens::Orthographic { .. })
    }

    /// Returns the camera's position.
    #[must_use]
    pub fn eye(&self) -> ScenePoint {
        ScenePoint(self.scene_from_view().w_axis.truncate().as_vec3())
    }

    /// Returns the unit scene vector from the scene towards the viewer along the view axis.
    #[must_use]
    pub(crate) fn towards_viewer(&self) -> Vec3 {
        self.scene_from_view().z_axis.truncate().as_vec3()
    }

    /// Returns scene_from_view: the camera's axes and position.
    #[must_use]
    pub(crate) fn scene_from_view(&self) -> DMat4 {
        self.view_from_scene.inverse()
    }

    /// Returns the matrix that EXR calls worldToCamera (column vectors; the camera looks along −z, y up).
    #[must_use]
    pub(crate) const fn view_from_scene(&self) -> DMat4 {
        self.view_from_scene
    }

    /// Returns the matrix from scene space to homogeneous screen space (x·w, y·w, z·w, w): frame heights, y up. For a
    /// perspective lens, z/w is 0 at the near plane and tends to 1; for an orthographic one it is the distance behind
    /// the near plane.
    #[must_use]
    pub(crate) fn screen_from_scene(&self) -> DMat4 {
        let (zoom, half, near) = (0.5 * self.zoom(), DVec2::new(self.aspect * 0.5, 0.5), self.near);
        let rows = match self.lens {
            Lens::Perspective { .. } => [
                DVec4::new(zoom, 0.0, -half.x, 0.0),
                DVec4::new(0.0, zoom, -half.y, 0.0),
                DVec4::new(0.0, 0.0, -1.0, -near),
                DVec4::new(0.0, 0.0, -1.0, 0.0),
            ],
            Lens::Orthographic { .. } => [
                DVec4::new(zoom, 0.0, 0.0, half.x),
                DVec4::new(0.0, zoom, 0.0, half.y),
                DVec4::new(0.0, 0.0, -1.0, -near),
                DVec4::W,
            ],
        };
        DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose() * self.view_from_scene
    }
}

/// Position and orientation of a camera, which looks along its −z, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPlacement {
    /// Rigid: without scale or reflection.
    scene_from_view: DMat4,
}

impl CameraPlacement {
    /// Places a camera at `distance` from `target`, looking at it. Yaw, pitch and roll in degrees: yaw 0 is at +z of
    /// the target, 90 at +x; pitch 90 looks straight down; roll turns the camera counter-clockwise about its view axis.
    ///
    /// ```
    /// use glam::DVec3;
    /// use pinwarp::screen::CameraPlacement;
    /// let side = CameraPlacement::orbit(DVec3::Y, 2.0, [90.0, 0.0, 0.0]);
    /// assert!(side.position().abs_diff_eq(DVec3::new(2.0, 1.0, 0.0), 1e-12));
    /// ```
    #[must_use]
    pub fn orbit(target: DVec3, distance: f64, angles: [f64; 3]) -> Self {
        let [yaw, pitch, roll] = angles.map(f64::to_radians);
        let turn = DMat4::from_rotation_y(yaw) * DMat4::from_rotation_x(-pitch) * DMat4::from_rotation_z(roll);
        let position = target + turn.z_axis.truncate() * distance;
        Self { scene_from_view: DMat4::from_translation(position) * turn }
    }

    /// Places a camera at `position`, looking at `target`; the scene's y is up in the frame. Roll in degrees, as in
    /// [`Self::orbit`].
    #[must_use]
    pub(crate) fn towards(position: DVec3, target: DVec3, roll: f64) -> Self {
        let back = (position - target).try_normalize().unwrap_or(DVec3::Z);
        let yaw = back.x.atan2(back.z).to_degrees();
        let pitch = back.y.clamp(-1.0, 1.0).asin().to_degrees();
        Self::orbit(position, 0.0, [yaw, pitch, roll])
    }

    /// Returns the position in metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.scene_from_view.w_axis.truncate()
    }
}

/// Returns the smallest distance in metres at which an orbiting camera shows all of `points` with a small margin.
/// `at_one`: the camera at a distance of 1.
#[must_use]
pub(crate) fn fit_distance(points: &[DVec3], at_one: &CameraPlacement, (lens, frame): (Lens, FrameSize)) -> f64 {
    let view_from_scene = at_one.scene_from_view.inverse();
    let in_view = || points.iter().map(|&point| view_from_scene.transform_point3(point) + DVec3::Z);
    let distance = match lens {
        Lens::Perspective { yfov } => {
            let up = (f64::from(yfov) * 0.5).tan() / FIT_AIR;
            let right = up * frame.aspect();
            in_view().map(|at| at.z + (at.x.abs() / right).max(at.y.abs() / up)).fold(0.0, f64::max)
        }
        // The size in the frame does not depend on the distance, which only has to keep everything in front of the
        // camera.
        Lens::Orthographic { .. } => in_view().map(|at| 2.0 * at.length()).fold(0.0, f64::max),
    };
    distance.max(1e-3)
}

/// Returns a camera that shows all of `poses`, for scenes without one; `None` if nothing is visible.
#[must_use]
pub(crate) fn automatic(poses: &[Pose], frame: FrameSize) -> Option<Camera> {
    let points =
        || poses.iter().flat_map(|pose| &pose.parts).flat_map(|part| &part.positions).map(|point| point.0.as_dvec3());
    let low = points().reduce(DVec3::min)?;
    let high = points().reduce(DVec3::max)?;
    let center = (low + high) * 0.5;
    let radius = points().map(|point| point.distance(center)).fold(1e-3, f64::max);
    let yfov = AUTOMATIC_YFOV_DEGREES.to_radians();
    // The narrower of the two half angles must contain the bounding sphere, with a small margin.
    let half_angle = (yfov * 0.5).tan().min((yfov * 0.5).tan() * frame.aspect()).atan();
    let distance = 1.05 * radius / half_angle.sin();
    let back = AUTOMATIC_DIRECTION.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let scene_from_view = DMat4::from_cols(
        right.extend(0.0),
        back.cross(right).extend(0.0),
        back.extend(0.0),
        (center + back * distance).extend(1.0),
    );
    let lens = Lens::Perspective { yfov: yfov as f32 };
    Some(Camera::new(scene_from_view.as_mat4(), lens, (distance * 0.01) as f32, frame))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn at_origin(lens: Lens) -> Camera {
        Camera::new(Mat4::from_scale(Vec3::splat(3.0)), lens, 0.1, FrameSize::new(1920, 1080))
    }

    #[test]
    fn frame_height_at_the_field_of_view_is_one() {
        let camera = at_origin(Lens::Perspective { yfov: 1.0 });
        let top = camera.project(ScenePoint(Vec3::new(0.0, 2.0 * 0.5_f32.tan(), -2.0)));
        assert!((top.point().0 - DVec2::new(16.0 / 18.0, 1.0)).length() < 1e-6);
        assert!((top.depth - 2.0).abs() < 1e-9);
    }

    #[test]
    fn screen_matrix_agrees_with_the_projection() {
        for lens in [Lens::Perspective { yfov: 0.7 }, Lens::Orthographic { ymag: 2.5 }] {
            let camera = at_origin(lens);
            let point = Vec3::new(0.3, -0.8, -4.0);
            let homogeneous = camera.screen_from_scene() * point.as_dvec3().extend(1.0);
            let projected = camera.project(ScenePoint(point));
            assert!((homogeneous.truncate().truncate() - projected.h).length() < 1e-9, "{lens:?}");
            assert!((homogeneous.w - projected.w).abs() < 1e-9, "{lens:?}");
        }
    }

    #[test]
    fn orbits_look_at_their_target_from_where_they_stand() {
        let target = DVec3::new(0.3, 1.0, -2.0);
        for (angles, from, up) in [
            ([0.0, 0.0, 0.0], DVec3::Z, DVec3::Y),
            ([90.0, 0.0, 0.0], DVec3::X, DVec3::Y),
            ([180.0, 0.0, 0.0], DVec3::NEG_Z, DVec3::Y),
            ([0.0, 90.0, 0.0], DVec3::Y, DVec3::NEG_Z),
            ([0.0, 0.0, 90.0], DVec3::Z, DVec3::NEG_X),
        ] {
            let placed = CameraPlacement::orbit(target, 3.0, angles);
            assert!((placed.position() - target - from * 3.0).length() < 1e-12, "{angles:?}");
            let camera = Camera::placed(&placed, Lens::Perspective { yfov: 0.5 }, 0.1, FrameSize::new(160, 90));
            let middle = ScreenPoint::new(8.0 / 9.0, 0.5);
            assert!((camera.project_exact(target).point() - middle).0.length() < 1e-12, "{angles:?}");
            assert!((camera.project_exact(target + up * 0.1).point() - middle).0.y > 0.01, "{angles:?}");
            if angles[2] == 0.0 {
                let same = CameraPlacement::towards(placed.position(), target, 0.0);
                assert!(same.scene_from_view.abs_diff_eq(placed.scene_from_view, 1e-9), "{angles:?}");
            }
        }
    }

    #[test]
    fn fitted_cameras_show_everything_and_little_more() {
        let points = [DVec3::new(-1.0, 0.0, 0.5), DVec3::new(1.0, 2.0, -0.5), DVec3::new(0.2, -0.7, 0.9)];
        for (frame, angles) in
            [(FrameSize::new(160, 90), [30.0, 10.0, 0.0]), (FrameSize::new(50, 200), [0.0, 60.0, 20.0])]
        {
            let lens = Lens::Perspective { yfov: 0.6 };
            let middle = DVec3::new(0.0, 0.65, 0.2);
            let distance = fit_distance(&points, &CameraPlacement::orbit(middle, 1.0, angles), (lens, frame));
            let camera = Camera::placed(&CameraPlacement::orbit(middle, distance, angles), lens, 0.01, frame);
            let places =
                points.map(|point| camera.project_exact(point).point().0 - DVec2::new(frame.aspect(), 1.0) * 0.5);
            let share = places.map(|place| (2.0 * place.x.abs() / frame.aspect()).max(2.0 * place.y.abs()));
            let largest = share.into_iter().fold(0.0, f64::max);
            assert!((largest - 1.0 / FIT_AIR).abs() < 1e-9, "{largest}");
        }
    }

    #[test]
    fn a_vector_of_the_screen_moves_a_point_at_its_depth() {
        let turned = Mat4::from_rotation_y(0.6) * Mat4::from_rotation_z(0.3);
        for lens in [Lens::Perspective { yfov: 0.7 }, Lens::Orthographic { ymag: 2.5 }] {
            let camera = Camera::new(turned, lens, 0.1, FrameSize::new(1920, 1080));
            let point = turned.as_dmat4().transform_point3(DVec3::new(0.3, -0.8, -4.0));
            let before = camera.project_exact(point);
            let by = ScreenVector::new(0.2, -0.1);
            let after = camera.project_exact(point + camera.scene_from_screen_vector(by, before.w));
            assert!((after.point() - (before.point() + by)).0.length() < 1e-12, "{lens:?}");
            assert!((after.depth - before.depth).abs() < 1e-12, "{lens:?}");
        }
    }

    #[test]
    fn a_reflected_camera_node_does_not_mirror_the_picture() {
        let frame = FrameSize::new(100, 100);
        let lens = Lens::Perspective { yfov: 1.0 };
        let mirrored = Camera::new(Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)), lens, 0.1, frame);
        assert_eq!(mirrored, Camera::new(Mat4::IDENTITY, lens, 0.1, frame));
    }
}
