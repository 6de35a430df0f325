//! A ball seen by a camera, as fine as wanted: what benches and pictures draw.
//!
//! In: the frame, rings and segments. Out: [`Geometry`] with one draw of material 0.

use glam::{Mat4, Vec3};
use pinwarp::pose::PosedLight;
use pinwarp::raster::{Draw, Geometry, RasterVertex};
use pinwarp::scene::{Lens, LightKind};
use pinwarp::screen::Camera;
use pinwarp::space::{FrameSize, ScenePoint, SceneVector};

/// A ball of radius 1 around the origin with 2·rings·segments triangles (less the poles'), bumped by `bump` metres,
/// seen from (0, 0.5, 4) by a 29° lens; a light from the upper left.
pub(crate) fn ball(frame: FrameSize, (rings, segments): (u32, u32), bump: f32) -> Geometry {
    // Tilted down so that it looks at the origin.
    let tilt = Mat4::from_rotation_x(-(0.5f32 / 4.0).atan());
    let scene_from_camera = Mat4::from_translation(Vec3::new(0.0, 0.5, 4.0)) * tilt;
    let camera = Camera::new(scene_from_camera, Lens::Perspective { yfov: 0.5 }, 0.1, frame);
    let mut vertices = Vec::new();
    for ring in 0..=rings {
        for segment in 0..=segments {
            vertices.push(ball_vertex(&camera, ring as f32 / rings as f32, segment as f32 / segments as f32, bump));
        }
    }
    let mut indices = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let a = ring * (segments + 1) + segment;
            let (b, c, d) = (a + 1, a + segments + 1, a + segments + 2);
            indices.extend([a, c, b, b, c, d]);
        }
    }
    let light = PosedLight {
        kind: LightKind::Directional,
        color: Vec3::splat(3.0),
        position: ScenePoint(Vec3::ZERO),
        direction: SceneVector(Vec3::new(0.6, -0.7, -0.5).normalize()),
        range: f32::INFINITY,
    };
    let whole = 0..indices.len() as u32;
    let draws = vec![Draw {
        indices: whole,
        material: 0,
        layer_id: 3,
        object_id: 7,
        mattes: Default::default(),
        is_mirrored: false,
    }];
    let (eye, lights) = (camera.eye(), vec![light]);
    Geometry { vertices, indices, draws, eye, parallel_view: None, lights, environment: 0.4 }
}

fn ball_vertex(camera: &Camera, down: f32, around: f32, bump: f32) -> RasterVertex {
    use std::f32::consts::{PI, TAU};
    let (polar, azimuth) = (down * PI, around * TAU);
    let normal = Vec3::new(polar.sin() * azimuth.sin(), polar.cos(), polar.sin() * azimuth.cos());
    let height = 1.0 + bump * (azimuth * 40.0).sin() * (polar * 40.0).sin();
    let position = normal * height;
    let seen = camera.project(ScenePoint(position));
    let homogeneous = [seen.h.x as f32, seen.h.y as f32, seen.w as f32];
    RasterVertex {
        screen: [homogeneous[0], homogeneous[1], camera.near() as f32, homogeneous[2]],
        position: position.to_array(),
        depth: seen.depth as f32,
        normal: normal.to_array(),
        next: homogeneous,
        previous: homogeneous,
        tangent: [azimuth.cos(), 0.0, -azimuth.sin(), 1.0],
        uv: [around, down, around, down],
        color: [1.0; 4],
    }
}
