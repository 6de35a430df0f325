//! Geometry assembly: splitting follows the warp without cracks, the near plane is respected, blended parts are sorted.

use glam::{DVec2, Mat4, Quat, Vec2, Vec3};
use pinwarp::lattice::{Basis, Grid, ScreenLattice};
use pinwarp::pose::{Pose, PosedPart};
use pinwarp::raster::Geometry;
use pinwarp::raster::geometry::{Assembly, PartWarp, PosedScene, Submesh, WarpBlend, assemble};
use pinwarp::scene::{AlphaMode, Lens, Material, Mesh, Node, Placement, Primitive, Scene};
use pinwarp::screen::Camera;
use pinwarp::space::{FrameSize, ScenePoint, SceneVector, ScreenBox, ScreenPoint};
use std::collections::HashMap;

const FRAME: FrameSize = FrameSize::new(1600, 1000);

/// Of lines, frame heights.
const WIDTH: f64 = 0.002;

/// A scene of one node a primitive.
fn scene_of(primitives: Vec<Primitive>, materials: Vec<Material>) -> Scene {
    let node = |mesh: usize| Node {
        name: format!("n{mesh}"),
        parent: None,
        rest: Placement::Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE },
        mesh: Some(mesh),
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
    };
    Scene {
        nodes: (0..primitives.len()).map(node).collect(),
        meshes: primitives.into_iter().map(|p| Mesh { primitives: vec![p], ..Mesh::default() }).collect(),
        materials,
        ..Scene::default()
    }
}

/// The scene as it stands, without nodes' placements.
fn still(scene: &Scene) -> Pose {
    let part = |(mesh, source): (usize, &Mesh)| PosedPart {
        node: mesh,
        mesh,
        primitive: 0,
        positions: source.primitives[0].positions.iter().map(|&point| ScenePoint(point)).collect(),
        normals: source.primitives[0].normals.iter().map(|&normal| SceneVector(normal)).collect(),
        tangents: Vec::new(),
        is_mirrored: false,
    };
    Pose { parts: scene.meshes.iter().enumerate().map(part).collect(), ..Pose::default() }
}

fn quad(size: f32, z: f32) -> Primitive {
    Primitive {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(x * size, y * size, z))
            .to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], Vec::new()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Primitive::default()
    }
}

fn camera() -> Camera {
    Camera::new(Mat4::IDENTITY, Lens::Perspective { yfov: 1.0 }, 0.1, FRAME)
}

/// A lattice over the frame whose middle handle is pulled up and right.
fn bulge() -> ScreenLattice {
    let bounds = ScreenBox::new(ScreenPoint::new(-0.2, -0.2), ScreenPoint::new(1.8, 1.2));
    let mut lattice = Grid::over(bounds, [10, 10], Basis::Bspline).at_rest();
    for (index, by) in [(44, [0.2, 0.1]), (45, [0.1, 0.2])] {
        (0..2).for_each(|axis| lattice.handles[index][axis] += by[axis]);
    }
    lattice
}

fn build(scene: &Scene, pose: &Pose, lattice: Option<&ScreenLattice>) -> Geometry {
    let warps = vec![lattice.map_or(PartWarp::Rest, PartWarp::Lattice); pose.parts.len()];
    build_warped(scene, pose, &warps)
}

fn build_warped(scene: &Scene, pose: &Pose, warps: &[PartWarp]) -> Geometry {
    let camera = camera();
    let now = PosedScene { pose, camera: &camera, warps };
    let submeshes = vec![vec![Submesh { layer_id: 1, ..Submesh::default() }]; pose.parts.len()];
    assemble(&Assembly {
        split_for: None,
        scene,
        now,
        neighbours: None,
        submeshes: &submeshes,
        lights: &[],
        environment: 1.0,
        line_width: WIDTH,
    })
}

fn place(geometry: &Geometry, vertex: u32) -> DVec2 {
    let [x, y, _, w] = geometry.vertices[vertex as usize].screen.map(f64::from);
    DVec2::new(x / w, y / w)
}

#[test]
fn an_unwarped_mesh_is_not_split() {
    let scene = scene_of(vec![quad(1.0, -3.0)], vec![Material::default()]);
    let geometry = build(&scene, &still(&scene), None);
    assert_eq!((geometry.vertices.len(), geometry.indices.len()), (4, 6));
}

#[test]
fn a_split_mesh_follows_the_warp_to_a_tenth_of_a_pixel() {
    let mut tilted = quad(1.4, -3.0);
    tilted.positions[2].z -= 1.5;
    let scene = scene_of(vec![tilted], vec![Material::default()]);
    let pose = still(&scene);
    let lattice = bulge();
    let geometry = build(&scene, &pose, Some(&lattice));
    assert!(geometry.vertices.len() > 100, "{}", geometry.vertices.len());
    let camera = camera();
    let mut worst: f64 = 0.0;
    for corners in geometry.indices.as_chunks::<3>().0 {
        // The raster interpolates position and w linearly between the corners; the scene point there is linear, too.
        let mix = |of: &dyn Fn(u32) -> [f64; 3]| -> [f64; 3] {
            let [a, b, c] = corners.map(of);
            std::array::from_fn(|i| a[i] * 0.5 + b[i] * 0.3 + c[i] * 0.2)
        };
        let [x, y, w] = mix(&|v| {
            let [x, y, _, w] = geometry.vertices[v as usize].screen.map(f64::from);
            [x, y, w]
        });
        let point = mix(&|v| geometry.vertices[v as usize].position.map(f64::from));
        let point = ScenePoint(Vec3::from_array(point.map(|x| x as f32)));
        let wanted = lattice.warp(camera.project(point).point());
        worst = worst.max(wanted.0.distance(DVec2::new(x / w, y / w)));
    }
    assert!(worst < 1e-4, "worst deviation {worst} frame heights");
}

/// Splits that halve halves again: weights of vertices that were created on edges are those of the edge.
#[test]
fn a_split_blend_moves_every_point_by_its_weights() {
    // Seen straight on, so that weights, like colours, are linear on the screen.
    let mut source = quad(1.4, -3.0);
    let weights = [[1.0, 0.0], [0.25, 0.5], [0.0, 0.875], [0.5, 0.125]];
    source.colors = weights.iter().map(|&[r, g]| glam::Vec4::new(r, g, 0.0, 1.0)).collect();
    let scene = scene_of(vec![source], vec![Material::default()]);
    let lattices = [bulge(), {
        let mut other = bulge();
        other.handles[63][0] -= 0.3;
        other
    }];
    let camera = camera();
    for count in [1, 2] {
        let rows: Vec<f32> = weights.iter().flat_map(|row| &row[..count]).copied().collect();
        let layers = lattices[..count].iter().map(PartWarp::Lattice).collect();
        let warp = PartWarp::Blend(WarpBlend { layers, weights: &rows });
        let geometry = build_warped(&scene, &still(&scene), &[warp]);
        assert!(geometry.vertices.len() > 100, "{}", geometry.vertices.len());
        for (index, vertex) in geometry.vertices.iter().enumerate() {
            let rest = camera.project(ScenePoint(Vec3::from_array(vertex.position))).point();
            let moves = lattices[..count].iter().zip(vertex.color);
            let by: DVec2 = moves.map(|(lattice, weight)| (lattice.warp(rest) - rest).0 * f64::from(weight)).sum();
            let now = place(&geometry, index as u32);
            assert!(now.distance(rest.0 + by) < 1e-5, "{count} lattices, vertex {index}: {now} is not {}", rest.0 + by);
        }
    }
}

#[test]
fn split_edges_leave_no_cracks_across_seams() {
    // Two triangles that share an edge by place only: their vertices are doubled, as at a UV seam, in other order.
    let mut seam = quad(1.4, -3.0);
    seam.positions.extend([seam.positions[2], seam.positions[0]]);
    seam.normals.extend([Vec3::Z; 2]);
    seam.uvs[0].extend([Vec2::ZERO; 2]);
    seam.triangles = vec![[0, 1, 2], [3, 5, 4]];
    let scene = scene_of(vec![seam], vec![Material::default()]);
    let geometry = build(&scene, &still(&scene), Some(&bulge()));
    let mut sides: HashMap<[[u64; 2]; 2], i32> = HashMap::new();
    let key = |vertex| place(&geometry, vertex).to_array().map(f64::to_bits);
    for corners in geometry.indices.as_chunks::<3>().0 {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (key(corners[a]), key(corners[b]));
            let (edge, turn) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
            *sides.entry(edge).or_default() += turn;
        }
    }
    let open: Vec<_> = sides.iter().filter(|(_, turn)| **turn != 0).collect();
    // All open edges lie on the outline: their unwarped places have |x| or |y| at the border. Count them by length:
    // an interior crack would add edges on the diagonal, whose middle is inside.
    let camera = camera();
    let outline = [(-1.4, -1.4), (1.4, -1.4), (1.4, 1.4), (-1.4, 1.4)]
        .map(|(x, y)| camera.project(ScenePoint(Vec3::new(x, y, -3.0))).point().0);
    let lattice = bulge();
    let on_outline = |point: [u64; 2]| {
        let point = DVec2::from_array(point.map(f64::from_bits));
        (0..4).any(|side| {
            let (a, b) = (outline[side], outline[(side + 1) % 4]);
            (0..=4000).any(|k| lattice.warp(ScreenPoint(a.lerp(b, f64::from(k) / 4000.0))).0.distance(point) < 1e-3)
        })
    };
    assert!(open.len() > 40);
    for (edge, _) in open {
        assert!(edge.iter().all(|&end| on_outline(end)), "a crack at {:?}", edge.map(|end| end.map(f64::from_bits)));
    }
}

#[test]
fn triangles_across_the_near_plane_are_cut() {
    let mut through = quad(1.0, -0.5);
    through.positions[0].z = 0.5;
    through.positions[1].z = 0.2;
    let scene = scene_of(vec![through], vec![Material::default()]);
    let geometry = build(&scene, &still(&scene), Some(&bulge()));
    assert!(!geometry.indices.is_empty());
    for &index in &geometry.indices {
        let vertex = &geometry.vertices[index as usize];
        assert!(vertex.depth >= 0.1 - 1e-6 && vertex.screen[3] > 0.0, "{vertex:?}");
        assert!(vertex.screen[2] / vertex.screen[3] <= 1.0 + 1e-6);
    }
}

#[test]
fn everything_behind_the_camera_gives_nothing() {
    let scene = scene_of(vec![quad(1.0, 3.0)], vec![Material::default()]);
    let geometry = build(&scene, &still(&scene), Some(&bulge()));
    assert!(geometry.indices.is_empty() && geometry.draws.is_empty());
}

#[test]
fn blended_triangles_come_last_and_from_back_to_front() {
    let glass = Material { alpha: AlphaMode::Blend, ..Material::default() };
    let mut primitives = vec![quad(1.0, -2.0), quad(1.0, -4.0), quad(1.0, -3.0)];
    primitives[0].material = 1;
    primitives[2].material = 1;
    let scene = scene_of(primitives, vec![Material::default(), glass]);
    let geometry = build(&scene, &still(&scene), None);
    let objects: Vec<u32> = geometry.draws.iter().map(|draw| draw.object_id).collect();
    assert_eq!(objects, [2, 3, 1]);
}

#[test]
fn a_fold_keeps_facing_the_viewer() {
    let scene = scene_of(vec![quad(1.0, -3.0)], vec![Material::default()]);
    let bounds = ScreenBox::new(ScreenPoint::new(0.0, 0.0), ScreenPoint::new(1.6, 1.0));
    let mut mirrored = Grid::over(bounds, [6, 6], Basis::Bspline).at_rest();
    mirrored.handles.iter_mut().for_each(|handle| handle[0] = 1.6 - handle[0]);
    for lattice in [None, Some(&mirrored)] {
        let geometry = build(&scene, &still(&scene), lattice);
        for corners in geometry.indices.as_chunks::<3>().0 {
            let [a, b, c] = corners.map(|corner| place(&geometry, corner));
            assert!((b - a).perp_dot(c - a) > 0.0, "front faces stay counter-clockwise");
        }
    }
}

/// A cube with edges of 1 m whose front is 2.5 m away.
fn cube() -> Primitive {
    let corner = |k: u32| Vec3::new((k & 1) as f32 - 0.5, (k >> 1 & 1) as f32 - 0.5, (k >> 2) as f32 - 3.5);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Primitive {
        positions: (0..8).map(corner).collect(),
        normals: vec![Vec3::Z; 8],
        triangles: faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Primitive::default()
    }
}

#[test]
fn back_faces_of_closed_surfaces_are_drawn_where_layers_may_open_the_front() {
    let bounds = ScreenBox::new(ScreenPoint::new(-0.2, -0.2), ScreenPoint::new(1.8, 1.2));
    let mut moved = Grid::over(bounds, [10, 10], Basis::Bspline).at_rest();
    moved.handles.iter_mut().for_each(|handle| handle[0] += 0.1);
    // The front moves, the back stays.
    let weights: Vec<f32> = (0..8).map(|k| (k >> 2) as f32).collect();
    let blend = || PartWarp::Blend(WarpBlend { layers: vec![PartWarp::Lattice(&moved)], weights: &weights });
    let drawn = |source: Primitive, material: Material, warp: PartWarp| {
        let scene = scene_of(vec![source], vec![material]);
        build_warped(&scene, &still(&scene), &[warp])
    };
    let opened = drawn(cube(), Material::default(), blend());
    // Seen from the middle in front, all faces but the front face away.
    assert_eq!(opened.indices.len() / 3, 12 + 10);
    for corners in &opened.indices.as_chunks::<3>().0[12..] {
        let turned = corners.map(|corner| opened.vertices[corner as usize]);
        assert!(turned.iter().all(|vertex| vertex.normal == [0.0, 0.0, -1.0]), "it faces the viewer");
        let z = |index: usize| opened.vertices[index].screen[2];
        let own = opened.vertices.iter().position(|vertex| vertex.position == turned[0].position);
        assert!(turned[0].screen[2] < z(own.expect("the vertex itself")), "behind the front at outlines");
    }
    let mut open = cube();
    open.triangles.pop();
    let double_sided = Material { double_sided: true, ..Material::default() };
    for (source, material, warp, count) in [
        (cube(), Material::default(), PartWarp::Lattice(&moved), 12),
        (cube(), Material::default(), PartWarp::Rest, 12),
        (cube(), double_sided, blend(), 12),
        (open, Material::default(), blend(), 11),
    ] {
        assert_eq!(drawn(source, material, warp).indices.len() / 3, count);
    }
}

/// A polyline of one primitive.
fn line(points: &[[f32; 3]]) -> Scene {
    let primitive = Primitive {
        positions: points.iter().map(|&point| Vec3::from_array(point)).collect(),
        normals: vec![Vec3::Z; points.len()],
        lines: vec![(0..points.len() as u32).collect()],
        ..Primitive::default()
    };
    scene_of(vec![primitive], vec![Material { unlit: true, double_sided: true, ..Material::default() }])
}

/// Middles and widths of a ribbon.
fn across(geometry: &Geometry) -> Vec<(DVec2, f64)> {
    let pairs = (0..geometry.vertices.len() as u32 / 2).map(|k| [2 * k, 2 * k + 1].map(|v| place(geometry, v)));
    pairs.map(|[left, right]| ((left + right) * 0.5, left.distance(right))).collect()
}

#[test]
fn lines_are_ribbons_of_one_width_however_far_they_are() {
    let scene = line(&[[-1.0, 0.0, -3.0], [0.0, 0.0, -6.0], [2.0, 0.0, -9.0]]);
    let geometry = build(&scene, &still(&scene), None);
    assert_eq!((geometry.vertices.len(), geometry.indices.len()), (6, 12));
    let middle = camera().project(ScenePoint(Vec3::new(0.0, 0.0, -6.0))).point().0;
    let across = across(&geometry);
    assert!(across.iter().all(|(_, width)| (width - WIDTH).abs() < 1e-6), "{across:?}");
    assert!(across[1].0.distance(middle) < 1e-6);
}

#[test]
fn lines_bend_with_the_warp_and_keep_their_width() {
    let scene = line(&[[-1.4, -0.5, -3.0], [1.4, 0.7, -3.0]]);
    let lattice = bulge();
    let geometry = build(&scene, &still(&scene), Some(&lattice));
    let across = across(&geometry);
    assert!(across.len() > 10, "{}", across.len());
    let [from, to] = [[-1.4, -0.5, -3.0], [1.4, 0.7, -3.0]].map(Vec3::from_array);
    for (k, (middle, width)) in across.iter().enumerate().skip(1).take(across.len() - 2) {
        assert!((width - WIDTH).abs() < 0.02 * WIDTH, "{width}");
        let position = Vec3::from_array(geometry.vertices[2 * k].position);
        assert!((position - from).cross(to - from).length() < 1e-5, "the scene's line stays");
        let wanted = lattice.warp(camera().project(ScenePoint(position)).point()).0;
        assert!(middle.distance(wanted) < 1e-6, "{middle} is not {wanted}");
    }
}

#[test]
fn lines_end_at_the_near_plane() {
    let scene = line(&[[0.1, 0.0, -3.0], [0.1, 0.1, 2.0], [0.2, 0.2, 3.0], [0.3, 0.0, -4.0]]);
    let geometry = build(&scene, &still(&scene), None);
    assert_eq!((geometry.vertices.len(), geometry.indices.len()), (8, 12), "two lines of one segment");
    assert!(geometry.vertices.iter().all(|vertex| f64::from(vertex.depth) >= 0.1 - 1e-6));
}

#[test]
fn closed_lines_close_without_a_notch() {
    let mut scene = line(&[[-0.5, -0.5, -3.0], [0.5, -0.5, -3.0], [0.0, 0.5, -3.0]]);
    scene.meshes[0].primitives[0].lines = vec![vec![0, 1, 2, 0]];
    let geometry = build(&scene, &still(&scene), None);
    assert_eq!(geometry.vertices.len(), 8);
    for side in 0..2 {
        assert_eq!(geometry.vertices[side].screen, geometry.vertices[6 + side].screen);
    }
}
