//! Scenes that lie flat in the frame: scene x and y equal screen x and y, in frame heights.
//!
//! In: the frame's aspect ratio. Out: a [`Scene`] of unlit cards in front of a camera that sees exactly the frame.

use super::outline::{Triangulated, cut_along};
use super::{Camera, Lens, Material, Mesh, Node, Placement, Primitive, Scene};
use crate::space::uv_from_screen;
use glam::{Quat, Vec2, Vec3};

/// Name of the only card of [`frame_card`].
const FRAME: &str = "frame";

/// Number of cells along the longer side of a rectangle.
const CELLS: f64 = 24.0;

/// Distance between consecutive cards, and from the front card to the camera, in frame heights.
const STEP: f32 = 0.01;

/// Returns the scene of a shot that warps whole plates: one card, `frame`, that fills the frame.
///
/// ```
/// let scene = pinwarp::scene::frame_card(16.0 / 9.0);
/// assert_eq!((scene.nodes[0].name.as_str(), scene.cameras.len()), ("frame", 1));
/// ```
#[must_use]
pub fn frame_card(aspect: f64) -> Scene {
    flat_scene(aspect, vec![(FRAME.to_owned(), rectangle(aspect, [[0.0; 2], [aspect, 1.0]]))])
}

/// Returns a scene of cards, from back to front, each a node with its own mesh, and a camera in front of them.
pub(super) fn flat_scene(aspect: f64, cards: Vec<(String, Primitive)>) -> Scene {
    let mut scene = Scene {
        materials: vec![Material { unlit: true, double_sided: true, ..Material::default() }],
        cameras: vec![Camera { name: String::new(), lens: Lens::Orthographic { ymag: 0.5 }, near: 0.0 }],
        ..Scene::default()
    };
    for (place, (name, card)) in cards.into_iter().enumerate() {
        scene.meshes.push(Mesh { name: name.clone(), primitives: vec![card], ..Mesh::default() });
        scene.nodes.push(Node { mesh: Some(place), ..node(name, Vec3::Z * (STEP * place as f32)) });
    }
    let before = STEP * scene.nodes.len() as f32;
    let middle = Vec3::new((0.5 * aspect) as f32, 0.5, before);
    scene.nodes.push(Node { camera: Some(0), ..node("camera".to_owned(), middle) });
    // A file written from it has the same nodes.
    scene.file_from_scene = (0..scene.nodes.len()).collect();
    scene
}

fn node(name: String, translation: Vec3) -> Node {
    let rest = Placement::Trs { translation, rotation: Quat::IDENTITY, scale: Vec3::ONE };
    Node { name, parent: None, rest, mesh: None, skin: None, camera: None, light: None, weights: Vec::new() }
}

/// Returns a box on the screen, given by its lower left and upper right corner, as a grid of nearly square cells, split
/// along alternating diagonals.
pub(super) fn rectangle(aspect: f64, [low, high]: [[f64; 2]; 2]) -> Primitive {
    let size = [high[0] - low[0], high[1] - low[1]];
    let side = size[0].max(size[1]) / CELLS;
    let [columns, rows] = size.map(|size| (size / side).round().max(1.0) as u32);
    let place = |axis: usize, k: u32, of: u32| low[axis] + size[axis] * f64::from(k) / f64::from(of);
    let points = (0..=rows).flat_map(|j| (0..=columns).map(move |i| [place(0, i, columns), place(1, j, rows)]));
    let points: Vec<[f64; 2]> = points.collect();
    let corner = |i: u32, j: u32| i + j * (columns + 1);
    let mut triangles = Vec::with_capacity(2 * (columns * rows) as usize);
    for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        let halves = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        triangles.extend(halves);
    }
    card(&points, triangles, aspect)
}

/// Returns screen-space triangles, counter-clockwise, with UVs that map a picture of the whole frame onto the frame.
pub(super) fn card(points: &[[f64; 2]], triangles: Vec<[u32; 3]>, aspect: f64) -> Primitive {
    let uv = |&point: &[f64; 2]| Vec2::from(uv_from_screen(point, aspect).map(|x| x as f32));
    Primitive {
        positions: points.iter().map(|&[x, y]| Vec3::new(x as f32, y as f32, 0.0)).collect(),
        normals: vec![Vec3::Z; points.len()],
        uvs: [points.iter().map(uv).collect(), Vec::new()],
        triangles,
        ..Primitive::default()
    }
}

/// Returns a card that is divided along polylines on the screen, from which it deviates by up to `tolerance`, frame heights.
pub(crate) fn cut_card(of: &Primitive, aspect: f64, lines: &[Vec<[f64; 2]>], tolerance: f64) -> Primitive {
    let points = of.positions.iter().map(|point| [f64::from(point.x), f64::from(point.y)]).collect();
    let cut = cut_along(&Triangulated { points, triangles: of.triangles.clone() }, lines, tolerance);
    card(&cut.points, cut.triangles, aspect)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_card_covers_the_frame_once() {
        for aspect in [16.0 / 9.0, 1.0, 0.2, 300.0] {
            let card = rectangle(aspect, [[0.0; 2], [aspect, 1.0]]);
            let corner = |index: u32| card.positions[index as usize].truncate();
            let area = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).perp_dot(corner(c) - corner(a)) * 0.5;
            assert!(card.triangles.iter().all(|triangle| area(triangle) > 0.0), "{aspect}");
            let total: f32 = card.triangles.iter().map(area).sum();
            assert!((f64::from(total) / aspect - 1.0).abs() < 1e-4, "{aspect}: {total}");
        }
    }

    #[test]
    fn the_camera_stands_before_all_cards() {
        let card = || ("card".to_owned(), rectangle(1.0, [[0.0; 2], [1.0; 2]]));
        let scene = flat_scene(1.0, vec![card(), card(), card()]);
        let depth = |node: &Node| match node.rest {
            Placement::Trs { translation, .. } => translation.z,
            Placement::Matrix(_) => unreachable!("cards are placed by translation"),
        };
        let camera = scene.nodes.last().expect("a camera");
        assert!(scene.nodes[..3].iter().all(|node| depth(node) < depth(camera)) && camera.camera == Some(0));
    }
}
