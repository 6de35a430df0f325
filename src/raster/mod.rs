//! Stage 7: renders warped geometry into a [`Frame`].
//!
//! A [`Raster`] is opened once for a scene's materials, then renders frames: `start`, `draw` for every sample pass,
//! `finish`. [`cpu`] is the reference in safe Rust; [`vulkan`] draws the same picture on a device. Functions of the
//! same name in `shaders/` and `raster/cpu/` compute the same thing.

pub mod cpu;
pub(crate) mod geometry;
pub mod vulkan;

mod error;
mod open;
mod window;

pub use crate::image::ChannelGroup;
pub use error::RasterError;
pub use open::open;
pub(crate) use open::resampler;

use crate::image::Frame;
use crate::image::cryptomatte::MatteId;
use crate::pose::PosedLight;
use crate::space::{FrameSize, PixelRect, ScenePoint};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec2};

/// One vertex, ready to draw. All fields except `screen`, `next` and `previous` are unwarped.
///
/// Interpolation over a triangle is perspective-correct with `screen.w` for all fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RasterVertex {
    /// Warped homogeneous screen position (x·w, y·w, z·w, w); w > 0; x, y in frame heights, y up;
    /// z in 0..=1, **1 at the near plane** (reversed), linear on the screen.
    pub screen: [f32; 4],
    /// Scene position.
    pub position: [f32; 3],
    /// Distance along the view axis in metres.
    pub depth: f32,
    /// Scene normal (not unit after interpolation).
    pub normal: [f32; 3],
    /// Warped homogeneous screen position one frame later: (x·w, y·w, w) with that frame's w.
    pub next: [f32; 3],
    /// Warped homogeneous screen position one frame earlier.
    pub previous: [f32; 3],
    /// Scene tangent, w = handedness; zero if there is none.
    pub tangent: [f32; 4],
    /// TEXCOORD_0 (u, v) and TEXCOORD_1 (u, v).
    pub uv: [f32; 4],
    /// Linear vertex colour.
    pub color: [f32; 4],
}

impl RasterVertex {
    /// Returns the warped position on the screen; arbitrary if w is not positive.
    pub(crate) fn on_screen(&self) -> DVec2 {
        let [x, y, _, w] = self.screen.map(f64::from);
        DVec2::new(x, y) / w
    }
}

/// The Cryptomattes that a frame can have: by node names, material names, and the shot's layer names.
pub(crate) const MATTE_LAYERS: [&str; 3] = ["CryptoObject", "CryptoMaterial", "CryptoLayer"];

/// Triangles with the same material and ids; drawn in the given order.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// Vertex indices as a range of [`Geometry::indices`], three per triangle.
    pub indices: std::ops::Range<u32>,
    /// Index into the scene's materials.
    pub material: u32,
    /// 1 + index of the layer in the shot; 0 if no layer includes the mesh.
    pub layer_id: u32,
    /// 1 + index of the node in the scene.
    pub object_id: u32,
    /// Ids in the Cryptomattes: of its node, material and layer; 0: no coverage there.
    pub mattes: [MatteId; MATTE_LAYERS.len()],
    /// Whether the node mirrors the part, so that front faces are clockwise.
    pub is_mirrored: bool,
}

/// The geometry at one time.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// Shared vertices.
    pub vertices: Vec<RasterVertex>,
    /// Vertex indices. Facing is determined on the screen, so the caller swaps two corners of a triangle that the warp
    /// inverted, to keep its front face.
    pub indices: Vec<u32>,
    /// Opaque and masked draws first, then blended triangles from back to front over all objects.
    pub draws: Vec<Draw>,
    /// Position of the camera (perspective).
    pub eye: ScenePoint,
    /// Set for an orthographic camera: unit scene vector towards the viewer, used instead of `eye`.
    pub parallel_view: Option<glam::Vec3>,
    /// All lights.
    pub lights: Vec<PosedLight>,
    /// Strength of the neutral environment (soft light from above, grey ground); 0: none.
    pub environment: f32,
}

/// The outputs that a sample pass contributes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassRole {
    /// Filtered colour only (another time than mid-shutter).
    Beauty,
    /// Depth, normal, motion, ids only (mid-shutter, not jittered); no shading. Exactly one pass of a frame draws data.
    Data,
    /// Both.
    BeautyAndData,
}

/// One sample pass.
#[derive(Clone, Copy, Debug)]
pub struct Pass<'a> {
    /// The geometry to draw.
    pub geometry: &'a Geometry,
    /// The picture is shifted by this many pixels, x right, y down, before sampling at pixel centres.
    pub jitter_px: Vec2,
    /// The outputs it contributes to.
    pub role: PassRole,
}

/// The target of a frame.
#[derive(Clone, Debug)]
pub struct Target {
    /// The display window that screen space refers to.
    pub frame: FrameSize,
    /// The pixels to draw: the frame, a tile of it, or more than it. At most [`Raster::max_side`] on each side.
    pub window: PixelRect,
    /// Requested channels, in any order.
    pub channels: Vec<ChannelGroup>,
    /// Number of passes that contribute to beauty, each weighted by its reciprocal.
    pub beauty_passes: u32,
}

/// A rasteriser.
///
/// Data channels are one exact sample at each pixel centre: the nearest surface (greatest reversed z; the first drawn
/// if two are equal) with an alpha of at least 0.5, from the one pass that draws data. Beauty is the mean over its
/// passes, and so is the coverage of mattes: the part of each pass's alpha that belongs to an id.
pub trait Raster {
    /// Returns the device's name, for messages: `CPU`, `llvmpipe (LLVM 15.0.6, 256 bits)`.
    fn name(&self) -> String;

    /// Returns the device class, for files: independent of the machine.
    fn class(&self) -> DeviceClass;

    /// Returns the maximum width or height of a target in pixels.
    fn max_side(&self) -> u32;

    /// Begins a frame.
    ///
    /// # Errors
    /// [`RasterError`] if memory is exhausted or the device fails.
    fn start(&mut self, target: &Target) -> Result<(), RasterError>;

    /// Adds a pass to the current frame.
    ///
    /// # Errors
    /// [`RasterError`] if memory is exhausted or the device fails.
    fn draw(&mut self, pass: &Pass) -> Result<(), RasterError>;

    /// Finishes the frame: data window = the target's window, channels in the order of [`ChannelGroup`].
    ///
    /// # Errors
    /// [`RasterError`] if memory is exhausted or the device fails.
    fn finish(&mut self) -> Result<Frame, RasterError>;
}

/// The message for a second data pass in a frame.
const SECOND_DATA_PASS: &str = "a frame has only one data pass, and it has already been drawn";

/// The kind of rasteriser that drew a frame; frames of one class have the same bytes on one driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceClass {
    /// [`cpu::CpuRaster`].
    Cpu,
    /// [`vulkan::VulkanRaster`].
    Vulkan,
}

impl std::fmt::Display for DeviceClass {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Cpu => "CPU",
            Self::Vulkan => "Vulkan",
        })
    }
}

/// The choice of device (`--device`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// A graphics card (discrete, integrated or virtual), else the CPU; never a software driver.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// The best Vulkan device, software drivers included.
    Vulkan,
    /// A Vulkan device by index or part of its name.
    Named(String),
}

impl DeviceChoice {
    /// Parses `auto`, `cpu`, `vulkan`, case-insensitively; anything else is part of a device's name, or its index.
    #[cfg(any(test, feature = "cli"))]
    #[must_use]
    pub(crate) fn of_name(name: &str) -> Self {
        match name.to_lowercase().as_str() {
            "auto" => Self::Auto,
            "cpu" => Self::Cpu,
            "vulkan" => Self::Vulkan,
            _ => Self::Named(name.to_owned()),
        }
    }
}
