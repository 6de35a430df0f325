//! Flat triangles placed on the screen.
//!
//! In: a few numbers. Out: [`Geometry`] with one draw of material 0, unless said otherwise.

use glam::{Vec2, Vec3};
use pinwarp::raster::{Draw, Geometry, RasterVertex};

/// A draw of all indices with ids 3 and 7.
pub(crate) fn draw(indices: std::ops::Range<u32>) -> Draw {
    Draw { indices, material: 0, layer_id: 3, object_id: 7, mattes: Default::default(), is_mirrored: false }
}

/// A vertex at a screen place (frame heights, y up) with reversed z and w = 1, facing the viewer, white, at rest.
pub(crate) fn vertex(at: Vec2, z: f32) -> RasterVertex {
    RasterVertex {
        screen: [at.x, at.y, z, 1.0],
        position: [at.x, at.y, z],
        depth: 1.0 / z.max(1e-6),
        normal: [0.0, 0.0, 1.0],
        next: [at.x, at.y, 1.0],
        previous: [at.x, at.y, 1.0],
        color: [1.0; 4],
        ..RasterVertex::default()
    }
}

/// Triangles over vertices, seen from in front, without lights; surroundings at strength 1.
pub(crate) fn flat(vertices: Vec<RasterVertex>, indices: Vec<u32>) -> Geometry {
    let draws = vec![draw(0..indices.len() as u32)];
    Geometry { vertices, indices, draws, parallel_view: Some(Vec3::Z), environment: 1.0, ..Geometry::default() }
}
