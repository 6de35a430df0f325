//! The contents of a glTF scene.
//!
//! In: its path. Out: the node tree, clips, cameras, materials, textures, bounds and counts.

use super::Lines;
use crate::cli::shared_args::OutsideArg;
use crate::pose::{ClipChoice, pose};
use crate::scene::{self, Lens, LightKind, Node, Scene};
use crate::spelling::pluralised;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Maximum depth that increases the indentation of the tree.
const DEEPEST_INDENT: usize = 24;

#[derive(Serialize)]
pub(super) struct SceneInfo {
    kind: &'static str,
    file: PathBuf,
    counts: Counts,
    /// Lower and upper corner of the rest pose in metres; `None` if nothing is visible.
    bounds: Option<[[f32; 3]; 2]>,
    nodes: Vec<NodeInfo>,
    clips: Vec<ClipInfo>,
    cameras: Vec<CameraInfo>,
    materials: Vec<String>,
    textures: Vec<TextureInfo>,
    notes: Vec<String>,
}

#[derive(Serialize)]
struct Counts {
    nodes: usize,
    meshes: usize,
    primitives: usize,
    vertices: usize,
    triangles: usize,
    lines: usize,
    morph_targets: usize,
    skins: usize,
    lights: usize,
}

#[derive(Serialize)]
struct NodeInfo {
    name: String,
    /// Index of the parent in the list.
    parent: Option<usize>,
    /// Depth in the tree.
    depth: usize,
    mesh: Option<MeshInfo>,
    /// Number of joints of its skin.
    joints: Option<usize>,
    is_joint: bool,
    camera: bool,
    light: Option<&'static str>,
}

#[derive(Serialize)]
struct MeshInfo {
    name: String,
    triangles: usize,
    lines: usize,
    morph_targets: usize,
    materials: Vec<String>,
    /// Whether any of its primitives has COLOR_0.
    vertex_colors: bool,
    /// Indices of the UV sets that any of its primitives has.
    texcoords: Vec<usize>,
}

#[derive(Serialize)]
struct ClipInfo {
    name: String,
    seconds: f32,
    tracks: usize,
}

#[derive(Serialize)]
struct CameraInfo {
    /// Name of the node, by which shots refer to it.
    name: String,
    /// Vertical field of view; `None` if orthographic.
    fov_degrees: Option<f32>,
    /// Visible height in metres of an orthographic camera.
    ortho_metres: Option<f32>,
}

#[derive(Serialize)]
struct TextureInfo {
    width: u32,
    height: u32,
    is_color: bool,
}

impl SceneInfo {
    pub(super) fn read(path: &Path, outside: OutsideArg) -> anyhow::Result<Self> {
        let scene = scene::load_with(path, outside.access())?;
        let joints: BTreeSet<usize> = scene.skins.iter().flat_map(|skin| &skin.joints).copied().collect();
        let mut nodes: Vec<NodeInfo> = Vec::with_capacity(scene.nodes.len());
        for (index, node) in scene.nodes.iter().enumerate() {
            // Parents come before their children.
            let depth = node.parent.map_or(0, |parent| nodes[parent].depth + 1);
            nodes.push(node_info(&scene, node, (depth, joints.contains(&index))));
        }
        let clips = scene.clips.iter();
        Ok(Self {
            kind: "scene",
            file: path.to_owned(),
            counts: counts(&scene),
            bounds: bounds(&scene),
            nodes,
            clips: clips
                .map(|clip| ClipInfo { name: clip.name.clone(), seconds: clip.end_secs, tracks: clip.tracks.len() })
                .collect(),
            cameras: scene.nodes.iter().filter_map(|node| camera_info(&scene, node)).collect(),
            materials: (0..scene.materials.len()).map(|index| material_name(&scene, index)).collect(),
            textures: scene.images.iter().map(texture_info).collect(),
            notes: scene.warnings,
        })
    }
}

fn counts(scene: &Scene) -> Counts {
    let primitives = || scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
    Counts {
        nodes: scene.nodes.len(),
        meshes: scene.meshes.len(),
        primitives: primitives().count(),
        vertices: primitives().map(|primitive| primitive.positions.len()).sum(),
        triangles: primitives().map(|primitive| primitive.triangles.len()).sum(),
        lines: primitives().map(|primitive| primitive.lines.len()).sum(),
        morph_targets: primitives().map(|primitive| primitive.targets.len()).sum(),
        skins: scene.skins.len(),
        lights: scene.nodes.iter().filter(|node| node.light.is_some()).count(),
    }
}

fn bounds(scene: &Scene) -> Option<[[f32; 3]; 2]> {
    let posed = pose(scene, ClipChoice::default(), 0.0);
    let points = || posed.parts.iter().flat_map(|part| &part.positions).map(|point| point.0);
    let low = points().reduce(|a, b| a.min(b))?;
    let high = points().reduce(|a, b| a.max(b))?;
    Some([low.to_array(), high.to_array()])
}

fn node_info(scene: &Scene, node: &Node, (depth, is_joint): (usize, bool)) -> NodeInfo {
    let light = node.light.map(|light| match scene.lights[light].kind {
        LightKind::Directional => "directional",
        LightKind::Point => "point",
        LightKind::Spot { .. } => "spot",
    });
    NodeInfo {
        name: node.name.clone(),
        parent: node.parent,
        depth,
        mesh: node.mesh.map(|mesh| mesh_info(scene, mesh)),
        joints: node.skin.map(|skin| scene.skins[skin].joints.len()),
        is_joint,
        camera: node.camera.is_some(),
        light,
    }
}

fn mesh_info(scene: &Scene, mesh: usize) -> MeshInfo {
    let mesh = &scene.meshes[mesh];
    let mut materials: Vec<String> = Vec::new();
    for primitive in mesh.primitives.iter().filter(|primitive| primitive.is_visible()) {
        let name = material_name(scene, primitive.material);
        if !materials.contains(&name) {
            materials.push(name);
        }
    }
    MeshInfo {
        name: mesh.name.clone(),
        triangles: mesh.primitives.iter().map(|primitive| primitive.triangles.len()).sum(),
        lines: mesh.primitives.iter().map(|primitive| primitive.lines.len()).sum(),
        morph_targets: mesh.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0),
        materials,
        vertex_colors: mesh.primitives.iter().any(|primitive| !primitive.colors.is_empty()),
        texcoords: (0..2).filter(|&set| mesh.primitives.iter().any(|one| !one.uvs[set].is_empty())).collect(),
    }
}

fn material_name(scene: &Scene, index: usize) -> String {
    let name = &scene.materials[index].name;
    if name.is_empty() { format!("material_{index}") } else { name.clone() }
}

fn camera_info(scene: &Scene, node: &Node) -> Option<CameraInfo> {
    let (fov_degrees, ortho_metres) = match scene.cameras[node.camera?].lens {
        Lens::Perspective { yfov } => (Some(yfov.to_degrees()), None),
        Lens::Orthographic { ymag } => (None, Some(2.0 * ymag)),
    };
    Some(CameraInfo { name: node.name.clone(), fov_degrees, ortho_metres })
}

fn texture_info(image: &scene::Image) -> TextureInfo {
    TextureInfo { width: image.width, height: image.height, is_color: image.is_srgb }
}

impl Lines for SceneInfo {
    fn lines(&self) -> Vec<String> {
        let Counts { nodes, meshes, primitives: _, vertices, triangles, lines, morph_targets, skins, lights } =
            self.counts;
        let mut out = vec![format!(
            "{}: {}, {}, {}, {}",
            self.file.display(),
            pluralised(nodes, "node", "nodes"),
            pluralised(meshes, "mesh", "meshes"),
            pluralised(triangles, "triangle", "triangles"),
            pluralised(vertices, "vertex", "vertices")
        )];
        let more = [
            (lines, pluralised(lines, "line", "lines")),
            (morph_targets, pluralised(morph_targets, "morph target", "morph targets")),
            (skins, pluralised(skins, "skin", "skins")),
            (lights, pluralised(lights, "light", "lights")),
        ];
        out.extend(more.into_iter().filter(|(count, _)| *count > 0).map(|(_, text)| format!("  {text}")));
        if let Some([low, high]) = self.bounds {
            out.push(format!("bounds at rest, metres: {} to {}", place(low), place(high)));
        }
        out.push(format!("clips: {}", self.clips.len()));
        let clip = |clip: &ClipInfo| {
            format!("  {} ({:.2} s, {})", clip.name, clip.seconds, pluralised(clip.tracks, "track", "tracks"))
        };
        out.extend(self.clips.iter().map(clip));
        out.push(format!("cameras: {}", self.cameras.len()));
        out.extend(self.cameras.iter().map(CameraInfo::line));
        out.push(format!("materials: {}", self.materials.join(", ")));
        let texture = |one: &TextureInfo| {
            format!("{}x{} {}", one.width, one.height, if one.is_color { "colour" } else { "data" })
        };
        let textures: Vec<String> = self.textures.iter().map(texture).collect();
        out.push(format!("textures: {}", if textures.is_empty() { "none".to_owned() } else { textures.join(", ") }));
        out.push("nodes:".to_owned());
        out.extend(self.nodes.iter().map(NodeInfo::line));
        out.extend(self.notes.iter().map(|note| format!("note: {note}")));
        out
    }
}

fn place([x, y, z]: [f32; 3]) -> String {
    format!("[{x:.3}, {y:.3}, {z:.3}]")
}

impl CameraInfo {
    fn line(&self) -> String {
        match (self.fov_degrees, self.ortho_metres) {
            (Some(fov), _) => format!("  {} (perspective, {fov:.1} degrees)", self.name),
            (None, height) => format!("  {} (orthographic, {:.3} m high)", self.name, height.unwrap_or_default()),
        }
    }
}

impl NodeInfo {
    fn line(&self) -> String {
        let indent = "  ".repeat(1 + self.depth.min(DEEPEST_INDENT));
        let mut about = Vec::new();
        if let Some(mesh) = &self.mesh {
            about.push(pluralised(mesh.triangles, "triangle", "triangles"));
            if mesh.lines > 0 {
                about.push(pluralised(mesh.lines, "line", "lines"));
            }
            if mesh.morph_targets > 0 {
                about.push(pluralised(mesh.morph_targets, "morph target", "morph targets"));
            }
            about.push(format!("material {}", mesh.materials.join(", ")));
            about.extend(mesh.vertex_colors.then(|| "vertex colours".to_owned()));
            about.extend(mesh.texcoords.iter().map(|set| format!("TEXCOORD_{set}")));
        }
        if let Some(joints) = self.joints {
            about.push(format!("skin of {}", pluralised(joints, "joint", "joints")));
        }
        about.extend(self.is_joint.then(|| "joint".to_owned()));
        about.extend(self.camera.then(|| "camera".to_owned()));
        about.extend(self.light.map(|kind| format!("{kind} light")));
        let about = if about.is_empty() { String::new() } else { format!(": {}", about.join(", ")) };
        format!("{indent}{}{about}", self.name)
    }
}
