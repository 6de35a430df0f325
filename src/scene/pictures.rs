//! Pictures as a scene: each a flat card with the outline of its visible part.
//!
//! In: coverage of pictures, from back to front. Out: a [`Scene`] of the kind that [`super::frame_card`] creates.

use super::card::{card, flat_scene, rectangle};
use super::outline::{self, Filling};
use super::{Primitive, Scene, SceneError};
use crate::space::{FrameSize, ImagePoint, PixelRect};
use std::path::PathBuf;

/// A picture's coverage.
#[derive(Clone, Debug)]
pub(crate) struct Picture<'a> {
    /// The file, for messages.
    pub(crate) path: PathBuf,
    /// Name of its node.
    pub(crate) name: String,
    /// The stored pixels, in image space; may lie partly outside the frame.
    pub(crate) window: PixelRect,
    /// Alpha, #pixels of the window, rows from the top; `None`: opaque.
    pub(crate) alpha: Option<&'a [f32]>,
}

/// Returns the scene of pictures of one size, from back to front; each is a node with a mesh of some hundred vertices.
///
/// `frame` is the size of the pictures, not the render resolution, so that triangles are the same at any resolution.
///
/// # Errors
/// [`SceneError::Empty`] if a picture is completely transparent.
pub(crate) fn picture_cards(frame: FrameSize, pictures: &[Picture<'_>]) -> Result<Scene, SceneError> {
    let cards = pictures.iter().map(|picture| Ok((picture.name.clone(), shape(frame, picture)?)));
    Ok(flat_scene(frame.aspect(), cards.collect::<Result<_, SceneError>>()?))
}

fn shape(frame: FrameSize, picture: &Picture<'_>) -> Result<Primitive, SceneError> {
    let filling = match picture.alpha {
        _ if picture.window.area() == 0 => Filling::Nothing,
        None => Filling::Everything,
        Some(alpha) => outline::filling(alpha),
    };
    let on_screen = |&[x, y]: &[f64; 2]| frame.screen_from_image(ImagePoint::new(x, y)).0.to_array();
    match (filling, picture.alpha) {
        (Filling::Nothing, _) => Err(SceneError::Empty { path: picture.path.clone(), picture: picture.name.clone() }),
        (Filling::Some, Some(alpha)) => {
            let made = outline::triangulated(picture.window, alpha);
            let points: Vec<[f64; 2]> = made.points.iter().map(on_screen).collect();
            Ok(card(&points, made.triangles, frame.aspect()))
        }
        _ => {
            let PixelRect { x, y, width, height } = picture.window;
            let [left, top] = [x, y].map(f64::from);
            let [right, bottom] = [left + f64::from(width), top + f64::from(height)];
            let corners = [on_screen(&[left, bottom]), on_screen(&[right, top])];
            Ok(rectangle(frame.aspect(), corners))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const SIDE: u32 = 512;

    /// Returns the alpha of an implicit field: 1 where it is below 0, with an edge of one pixel.
    fn drawn(side: u32, field: impl Fn(f64, f64) -> f64) -> Vec<f32> {
        let place = |k: u32| (f64::from(k % side) + 0.5, f64::from(k / side) + 0.5);
        (0..side * side).map(|k| (0.5 - field(place(k).0, place(k).1)).clamp(0.0, 1.0) as f32).collect()
    }

    fn disc(x: f64, y: f64, radius: f64) -> impl Fn(f64, f64) -> f64 {
        move |px, py| (px - x).hypot(py - y) - radius
    }

    fn meshed(side: u32, alpha: &[f32]) -> Primitive {
        let frame = FrameSize::new(side, side);
        let picture = Picture { path: "a.png".into(), name: "a".into(), window: frame.window(), alpha: Some(alpha) };
        let scene = picture_cards(frame, &[picture]).expect("something to see");
        scene.meshes[0].primitives[0].clone()
    }

    fn area_of(mesh: &Primitive, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize].truncate().as_dvec2());
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Returns the area in pixels, asserting that all triangles face the viewer.
    fn area(mesh: &Primitive, side: u32) -> f64 {
        let areas = mesh.triangles.iter().map(|&triangle| area_of(mesh, triangle));
        areas.inspect(|&area| assert!(area > 0.0, "a triangle faces away")).sum::<f64>() * f64::from(side).powi(2)
    }

    fn covers(mesh: &Primitive, x: f64, y: f64, side: u32) -> bool {
        let at = Vec3::new((x / f64::from(side)) as f32, (1.0 - y / f64::from(side)) as f32, 0.0).truncate();
        mesh.triangles.iter().any(|triangle| {
            let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize].truncate());
            [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (to - from).perp_dot(at - from) >= 0.0)
        })
    }

    fn min_angle_degrees(mesh: &Primitive) -> f64 {
        let angles = mesh.triangles.iter().flat_map(|triangle| {
            let corner = triangle.map(|corner| mesh.positions[corner as usize].as_dvec3());
            (0..3).map(move |k| (corner[(k + 1) % 3] - corner[k]).angle_between(corner[(k + 2) % 3] - corner[k]))
        });
        angles.fold(f64::INFINITY, f64::min).to_degrees()
    }

    /// Checks that the mesh covers what the alpha covers, and at most two pixels around it.
    fn check_area(mesh: &Primitive, (alpha, length): (&[f32], f64), side: u32) {
        let covered: f64 = alpha.iter().map(|&alpha| f64::from(alpha)).sum();
        let found = area(mesh, side);
        assert!(found >= 0.99 * covered && found <= covered + 2.0 * length, "{found} of {covered} pixels");
    }

    #[test]
    fn a_disc_becomes_well_shaped_triangles() {
        let alpha = drawn(SIDE, disc(250.3, 260.8, 200.0));
        let mesh = meshed(SIDE, &alpha);
        check_area(&mesh, (&alpha, 2.0 * std::f64::consts::PI * 200.0), SIDE);
        assert!((200..=700).contains(&mesh.positions.len()), "{} vertices", mesh.positions.len());
        assert!(min_angle_degrees(&mesh) > 19.0, "{}", min_angle_degrees(&mesh));
    }

    #[test]
    fn holes_stay_open_and_islands_stay() {
        let ring = |x: f64, y: f64| disc(200.0, 200.0, 180.0)(x, y).max(-disc(200.0, 200.0, 90.0)(x, y));
        let all = |x: f64, y: f64| ring(x, y).min(disc(200.0, 200.0, 30.0)(x, y)).min(disc(440.0, 440.0, 50.0)(x, y));
        let alpha = drawn(SIDE, all);
        let mesh = meshed(SIDE, &alpha);
        check_area(&mesh, (&alpha, std::f64::consts::TAU * 350.0), SIDE);
        for ((x, y), wanted) in [
            ((200.0, 200.0), true),
            ((200.0, 260.0), false),
            ((200.0, 330.0), true),
            ((440.0, 440.0), true),
            ((400.0, 300.0), false),
        ] {
            assert_eq!(covers(&mesh, x, y, SIDE), wanted, "{x}, {y}");
        }
    }

    #[test]
    fn single_pixels_and_lines_have_triangles() {
        let mut dot = vec![0.0; 64 * 64];
        dot[20 * 64 + 30] = 0.02;
        let mesh = meshed(64, &dot);
        assert!(covers(&mesh, 30.5, 20.5, 64) && area(&mesh, 64) < 12.0, "{}", area(&mesh, 64));
        let line = drawn(256, |x, y| (x - y).abs() - 0.5);
        let mesh = meshed(256, &line);
        assert!((1..256).all(|k| covers(&mesh, f64::from(k), f64::from(k), 256)));
        let corner = meshed(2, &[0.0, 0.0, 0.0, 1.0]);
        assert!(covers(&corner, 1.5, 1.5, 2));
    }

    #[test]
    fn what_touches_the_border_ends_there() {
        let mesh = meshed(SIDE, &drawn(SIDE, |x, y| 150.0 - x.min(y)));
        let most = mesh.positions.iter().fold(Vec3::ZERO, |most, &point| most.max(point));
        assert!(most.max_element() <= 1.0 && covers(&mesh, 511.4, 511.4, SIDE) && !covers(&mesh, 140.0, 400.0, SIDE));
    }

    #[test]
    fn opaque_pictures_are_rectangles() {
        let frame = FrameSize::new(160, 90);
        for (window, alpha, wanted) in [
            (frame.window(), None, 16.0 / 9.0),
            (frame.window(), Some(vec![1.0; 160 * 90]), 16.0 / 9.0),
            (PixelRect { x: 45, y: 0, width: 45, height: 90 }, None, 0.5),
        ] {
            let picture = Picture { path: "a.png".into(), name: "a".into(), window, alpha: alpha.as_deref() };
            let scene = picture_cards(frame, &[picture]).expect("something to see");
            let found = area(&scene.meshes[0].primitives[0], 1);
            assert!((found / wanted - 1.0).abs() < 1e-4, "{found} instead of {wanted}");
        }
    }

    #[test]
    fn empty_pictures_are_refused() {
        let frame = FrameSize::new(8, 8);
        for alpha in [vec![0.0; 64], vec![f32::NAN; 64], vec![-1.0; 64]] {
            let picture =
                Picture { path: "b/a.png".into(), name: "a".into(), window: frame.window(), alpha: Some(&alpha) };
            let error = picture_cards(frame, &[picture]).expect_err("nothing to see").to_string();
            assert!(error.contains("b/a.png") && error.contains("alpha is 0 everywhere"), "{error}");
        }
    }

    #[test]
    fn noise_and_huge_pictures_are_meshed_in_time() {
        let begun = std::time::Instant::now();
        let wave = |x: f64, y: f64| (x * 0.013).sin() * (y * 0.017).cos() - 0.3;
        let mesh = meshed(4096, &drawn(4096, wave));
        assert!(covers(&mesh, 362.0, 10.0, 4096) && mesh.positions.len() < 2000, "{}", mesh.positions.len());
        let noise: Vec<f32> = (0..SIDE * SIDE).map(|k| (k.wrapping_mul(2_654_435_761) >> 30) as f32 / 3.0).collect();
        assert!(!meshed(SIDE, &noise).triangles.is_empty());
        assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
    }

    #[test]
    fn meshes_come_out_the_same_every_time() {
        let alpha = drawn(SIDE, |x, y| disc(250.0, 250.0, 200.0)(x, y) + 20.0 * (x * 0.1).sin());
        let [one, two] = [0, 1].map(|_| meshed(SIDE, &alpha));
        assert!(one.positions == two.positions && one.triangles == two.triangles);
    }
}
