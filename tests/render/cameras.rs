//! The camera that a frame's file tells is the camera that took it.

use super::support::{Studio, at, pixels};
use super::tiny::{Lens, Tiny, grid};
use exr::meta::MetaData;
use glam::{DVec2, DVec4, Mat4};
use pinwarp::image::read_exr;

#[test]
fn matrices_are_those_of_the_frame() {
    for lens in [Lens::Perspective(0.9), Lens::Parallel] {
        let mut quad = grid("Quad", [-0.05, -0.05, 0.05, 0.05], 1);
        quad.place = [0.2, 0.3, 2.0];
        let mut tiny = Tiny { lens, ..Tiny::of(vec![quad]) };
        tiny.camera_velocity = [2.4, -1.2, 0.0];
        let mut studio = Studio::tiny(&tiny, "");
        studio.shot.size = pinwarp::space::FrameSize::new(320, 200);
        let mut seen = Vec::new();
        for path in studio.files(&[1, 3]) {
            let head = MetaData::read_from_file(&path, false).expect("a whole file").headers.remove(0).own_attributes;
            // Stored for row vectors: the same numbers, read as columns.
            let matrix = |stored: Option<[f32; 16]>| Mat4::from_cols_array(&stored.expect("a camera")).as_dmat4();
            let point = DVec4::new(0.2, 0.3, 2.0, 1.0);
            assert!(((matrix(head.world_to_camera) * point).z - 3.0).abs() < 1e-5, "three metres ahead");
            let ndc = matrix(head.world_to_normalized_device) * point;
            let place = DVec2::new(ndc.x, ndc.y) / ndc.w * DVec2::new(320.0, 200.0);

            let frame = read_exr(&path).expect("readable");
            let covered: Vec<_> = pixels(&frame).filter(|&(x, y)| at(&frame, "id.object", x, y) > 0.0).collect();
            let sum: DVec2 = covered.iter().map(|&(x, y)| DVec2::new(f64::from(x), f64::from(y)) + 0.5).sum();
            let middle = sum / covered.len() as f64;
            assert!(covered.len() > 30 && middle.distance(place) < 0.75, "{lens:?}: {middle} is not {place}");
            seen.push(middle);
        }
        assert!(seen[0].distance(seen[1]) > 5.0, "the camera moves, or nothing was compared: {seen:?}");
    }
}
