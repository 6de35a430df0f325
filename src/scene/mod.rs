//! Stage 1: loads a glTF file into a [`Scene`] with everything resolved.
//!
//! In: a path. Out: plain data without indices into buffers, accessors, sparse parts or extensions. Later stages are
//! independent of the file format.

mod access;
mod accessor;
mod animation;
mod approximate;
mod attributes;
mod budget;
mod card;
mod error;
mod file;
mod find;
mod geometry;
mod instances;
mod json;
mod limits;
mod lines;
mod load;
mod material;
mod materials;
mod mesh;
mod nodes;
mod outline;
#[cfg(any(test, feature = "cli", feature = "editor"))]
mod pack;
mod pictures;
mod skin;
mod solid;
mod tangents;
mod texture;
mod vertices;

pub(crate) use access::FileAccess;
pub(crate) use card::cut_card;
pub use card::frame_card;
pub use error::SceneError;
pub use find::FindError;
pub(crate) use load::files_beside;
pub use load::load;
pub(crate) use load::load_with;
pub(crate) use material::Wrap;
pub use material::{AlphaMode, Filter, Image, Material, Texture, TextureRef};
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(crate) use pack::Packed;
#[cfg(any(test, feature = "cli"))]
pub(crate) use pack::pack;
pub(crate) use pictures::{Picture, picture_cards};
pub(crate) use solid::{SolidVertices, position_bits};

use glam::{Mat4, Quat, Vec2, Vec3, Vec4};
use std::path::PathBuf;

/// A whole glTF scene. Nodes are ordered with parents before their children.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The file it came from.
    pub path: PathBuf,
    /// The buffer and image files that it refers to.
    pub files_beside: Vec<PathBuf>,
    /// All nodes of the scene; a parent has a smaller index than its children. Instances of EXT_mesh_gpu_instancing are
    /// children of their node, named `<node>[0]`, `<node>[1]`, ...
    pub nodes: Vec<Node>,
    /// #nodes: index among the nodes of the file, where instances follow all others; without a file: the node's own
    /// index.
    pub file_from_scene: Vec<usize>,
    /// Meshes that nodes refer to.
    pub meshes: Vec<Mesh>,
    /// Skins that nodes refer to.
    pub skins: Vec<Skin>,
    /// Cameras that nodes refer to.
    pub cameras: Vec<Camera>,
    /// Lights that nodes refer to.
    pub lights: Vec<Light>,
    /// Materials; `materials[0]` always exists (glTF's default material stands there when the file has none).
    pub materials: Vec<Material>,
    /// Textures: an image with its sampler.
    pub textures: Vec<Texture>,
    /// Decoded images, shared by textures.
    pub images: Vec<Image>,
    /// Animation clips.
    pub clips: Vec<Clip>,
    /// Warnings about unsupported or ignored content, worded for the user.
    pub warnings: Vec<String>,
}

/// One node of the hierarchy.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name in the file, or `node_<index in the file>`.
    pub name: String,
    /// Index of the parent in [`Scene::nodes`].
    pub parent: Option<usize>,
    /// Transform relative to the parent at rest.
    pub rest: Placement,
    /// Index into [`Scene::meshes`].
    pub mesh: Option<usize>,
    /// Index into [`Scene::skins`].
    pub skin: Option<usize>,
    /// Index into [`Scene::cameras`].
    pub camera: Option<usize>,
    /// Index into [`Scene::lights`].
    pub light: Option<usize>,
    /// Rest weights of the mesh's morph targets (the node's own, else the mesh's); #targets.
    pub weights: Vec<f32>,
}

/// The transform of a node relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// Translation, rotation, scale; may be animated.
    Trs {
        /// Translation in metres.
        translation: Vec3,
        /// Rotation as a unit quaternion.
        rotation: Quat,
        /// Scale factor per axis.
        scale: Vec3,
    },
    /// Any affine matrix (TRS cannot express shear); never animated.
    Matrix(Mat4),
}

impl Placement {
    /// The transform as a matrix.
    #[cfg(any(test, feature = "cli", feature = "editor"))]
    #[must_use]
    pub(crate) fn matrix(&self) -> Mat4 {
        match *self {
            Self::Trs { translation, rotation, scale } => {
                Mat4::from_scale_rotation_translation(scale, rotation, translation)
            }
            Self::Matrix(matrix) => matrix,
        }
    }
}

/// A mesh: primitives that share morph weights.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the file, or `mesh_<index>`.
    pub name: String,
    /// One per material.
    pub primitives: Vec<Primitive>,
    /// The vertices on closed surfaces.
    pub(crate) solid: SolidVertices,
}

/// Triangles or lines of one material, in the space of their node. All per-vertex arrays are empty or #vertices long.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// #vertices.
    pub positions: Vec<Vec3>,
    /// #vertices, always present: the file's, or flat normals (vertices are then not shared between triangles).
    pub normals: Vec<Vec3>,
    /// Whether the file has no normals: `normals` are then those of the triangles, and posing recomputes them after
    /// moving vertices.
    pub has_flat_normals: bool,
    /// #vertices if the material has a normal map (the file's, else MikkTSpace's); else empty. The bitangent w ·
    /// cross(normal, tangent) points up in the image.
    pub tangents: Vec<Vec4>,
    /// TEXCOORD_0 and TEXCOORD_1; each empty or #vertices.
    pub uvs: [Vec<Vec2>; 2],
    /// COLOR_0, linear RGBA; empty means white.
    pub colors: Vec<Vec4>,
    /// Joint influences, #vertices; empty if not skinned. Up to eight per vertex (JOINTS_0 and JOINTS_1).
    pub influences: Vec<[Influence; 8]>,
    /// Morph targets.
    pub targets: Vec<MorphTarget>,
    /// Vertex indices, counter-clockwise seen from the front. Triangle order is the file's (strips and fans converted).
    pub triangles: Vec<[u32; 3]>,
    /// Polylines as lists of vertices; a closed one repeats its first. A primitive has either triangles or lines.
    pub lines: Vec<Vec<u32>>,
    /// Index into [`Scene::materials`]; lines have unlit ones of their own.
    pub material: usize,
}

impl Primitive {
    /// Returns whether there is anything to draw.
    #[must_use]
    pub(crate) fn is_visible(&self) -> bool {
        !(self.triangles.is_empty() && self.lines.is_empty())
    }

    /// Returns the end points of the segments of all lines.
    pub(crate) fn segments(&self) -> impl Iterator<Item = [u32; 2]> {
        self.lines.iter().flat_map(|line| line.windows(2).map(|ends| [ends[0], ends[1]]))
    }
}

/// The influence of a joint on a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influence {
    /// Index into the skin's joints.
    pub joint: u16,
    /// Weight; the weights of a vertex sum to 1.
    pub weight: f32,
}

/// Displacements of one morph target; each array is empty or #vertices long.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    /// Position displacements.
    pub positions: Vec<Vec3>,
    /// Normal displacements.
    pub normals: Vec<Vec3>,
    /// Tangent displacements.
    pub tangents: Vec<Vec3>,
}

/// A skin: joints and the matrices that transform the mesh to each joint's rest space.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Indices into [`Scene::nodes`].
    pub joints: Vec<usize>,
    /// #joints: joint_from_mesh at rest, the inverse bind matrices.
    pub joint_from_mesh: Vec<Mat4>,
}

/// A camera; it looks along its node's −z, y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the camera in the file (may be empty); shots select by node name first, then by this.
    pub name: String,
    /// Its lens.
    pub lens: Lens,
    /// Distance of the near plane in metres, > 0 for a perspective lens.
    pub near: f32,
}

/// The projection of a camera. The width follows from the frame's own aspect ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Perspective.
    Perspective {
        /// Full vertical field of view in radians.
        yfov: f32,
    },
    /// Orthographic.
    Orthographic {
        /// Half of the visible height in metres.
        ymag: f32,
    },
}

/// A light of KHR_lights_punctual, which shines along its node's −z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Kind and shape.
    pub kind: LightKind,
    /// Linear RGB times intensity: lux for directional, candela for point and spot.
    pub color: Vec3,
    /// Distance at which it ends in metres; infinite if the file gives none.
    pub range: f32,
}

/// Kinds of punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light.
    Directional,
    /// Shines in all directions.
    Point,
    /// A cone.
    Spot {
        /// Half angle in radians at which the fall-off starts.
        inner: f32,
        /// Half angle in radians at which the fall-off ends.
        outer: f32,
    },
}

/// An animation clip.
#[derive(Clone, Debug, Default)]
pub struct Clip {
    /// Name in the file, or `clip_<index>`.
    pub name: String,
    /// Time of the last key in seconds.
    pub end_secs: f32,
    /// One per node and property.
    pub(crate) tracks: Vec<Track>,
}

/// Keys of one property of one node.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// Interpolation between keys.
    pub(crate) interpolation: Interpolation,
    /// Key times in seconds, strictly increasing, never empty.
    pub times: Vec<f32>,
    /// Values: one per key, three for cubic splines (in-tangent, value, out-tangent).
    pub values: TrackValues,
}

/// glTF's interpolations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    /// Hold.
    Step,
    /// Linear; rotations spherically.
    Linear,
    /// Cubic Hermite with stored tangents.
    CubicSpline,
}

/// The values of a track, by its property.
#[derive(Clone, Debug)]
pub(crate) enum TrackValues {
    /// Translations in metres.
    Translation(Vec<Vec3>),
    /// Quaternions (cubic tangents are not unit).
    Rotation(Vec<Quat>),
    /// Scale factors.
    Scale(Vec<Vec3>),
    /// Morph weights, #targets per value.
    Weights(Vec<f32>),
}
