//! Stage 8: reads and writes frames and plates as EXR, PNG and JPEG files; frame sequences; drawing on previews.
//!
//! In: frames and their metadata. Out: files, written atomically and deterministically. Samples that a file cannot
//! represent are clamped or replaced, never an error: see [`write_exr`].

mod atomic;
mod channels;
mod closed_regions;
#[cfg(any(test, feature = "cli"))]
mod codes;
mod complete;
#[cfg(feature = "cli")]
mod contact_sheet;
mod convex_spans;
pub mod cryptomatte;
mod draw;
mod error;
mod exr_file;
mod exr_guard;
mod exr_head;
mod exr_read;
mod exr_write;
mod flat_colors;
mod font;
mod guard;
mod ink;
mod kept;
mod kind;
mod label_borders;
mod label_map;
mod line_owners;
mod mask;
mod metadata;
mod picture;
mod plate;
mod plate_read;
mod plate_write;
mod png_note;
mod preview;
mod provenance;
mod sequence;
mod size;
mod squared_distance;
mod srgb;
mod window;

#[cfg(feature = "editor")]
pub(crate) use atomic::remove_unfinished;
pub use atomic::{Destination, Durability};
pub(crate) use atomic::{remove_stale, replace_bytes, replace_text};
pub use channels::{ChannelGroup, ChannelSpec};
pub(crate) use closed_regions::{Drawing, LineRule};
#[cfg(any(test, feature = "cli"))]
pub(crate) use codes::write_codes;
pub use complete::is_complete;
#[cfg(feature = "cli")]
pub(crate) use contact_sheet::ContactSheet;
pub(crate) use convex_spans::convex_spans;
pub use draw::{Canvas, Rgba8};
pub use error::ImageError;
pub use exr_read::{read_exr, read_metadata};
pub use exr_write::write_exr;
pub(crate) use flat_colors::flat_colors;
pub use guard::Existing;
pub(crate) use guard::{Inputs, is_there};
#[cfg(feature = "cli")]
pub(crate) use kept::read_whole;
pub(crate) use kept::{Depth, Expected, StaleReason, check_kept};
pub(crate) use kind::{FileKind, PictureKind};
pub(crate) use label_map::{CHOSEN, LabelMap, NO_LABEL, OTHER, neighbours};
pub(crate) use mask::{PaintedMap, are_of_one_shape};
pub use metadata::{CameraMatrices, FrameMetadata};
pub(crate) use picture::read_numbers;
#[cfg(feature = "python")]
pub(crate) use picture::{bytes_of_plate, plate_of_bytes};
pub use picture::{read_any, read_any_head, read_picture, write_any, write_picture};
pub use plate::{Plate, PlatePart};
pub use plate_read::read_plate;
pub use plate_write::write_plate;
pub(crate) use preview::write_frame_preview;
pub use preview::{Preview, png_bytes, preview, write_png};
pub(crate) use sequence::{SequencePath, without_counter};
pub use size::picture_size;
#[cfg(any(test, feature = "cli"))]
pub(crate) use size::sequence_size;
pub(crate) use size::{PictureExtent, picture_extent, plate_size};

use crate::space::PixelRect;

/// Depth where there is no surface, in scene units. Finite on purpose: infinities turn into NaN in compositing.
pub(crate) const EMPTY_DEPTH: f32 = 1e10;

/// A picture of named channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The display window, in pixels.
    pub display: PixelRect,
    /// Window of the stored pixels; may lie outside the display window.
    pub data_window: PixelRect,
    /// Width of a pixel divided by its height.
    pub pixel_aspect: f64,
    /// All channels, each with `data_window.area()` samples.
    pub channels: Vec<Channel>,
}

/// One channel: rows from the top, no padding. Ids compare equal by their bits, regardless of their value as a number.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Name as in the EXR file: `R`, `depth.Z`.
    pub name: String,
    /// Pixel type in the file.
    pub storage: Storage,
    /// #pixels of the data window.
    pub samples: Vec<f32>,
}

/// The pixel type of a channel in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// 16-bit float: colour.
    Half,
    /// 32-bit float: everything that is not colour.
    Float,
    /// 32-bit unsigned: ids of other programs. Samples hold the bits of the id (`f32::from_bits`), since an `f32` is
    /// exact only up to 2^24; they may be copied, but not used in arithmetic.
    Uint,
}

impl Frame {
    /// Returns the channel of this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Returns the number of NaN samples, which indicate an error in the scene or plate and are worth a warning, since
    /// [`write_exr`] replaces them by 0.
    #[must_use]
    pub fn nan_count(&self) -> usize {
        let floats = self.channels.iter().filter(|channel| channel.storage != Storage::Uint);
        floats.flat_map(|channel| &channel.samples).filter(|sample| sample.is_nan()).count()
    }
}

impl PartialEq for Channel {
    fn eq(&self, other: &Self) -> bool {
        let are_samples_equal = match self.storage {
            Storage::Uint => self.samples.iter().map(|id| id.to_bits()).eq(other.samples.iter().map(|id| id.to_bits())),
            Storage::Half | Storage::Float => self.samples == other.samples,
        };
        self.name == other.name && self.storage == other.storage && are_samples_equal
    }
}

impl Channel {
    /// Returns the value of empty pixels: [`EMPTY_DEPTH`] for depth (`Z`, `depth.Z`), else 0.
    #[must_use]
    pub(crate) fn empty_value(&self) -> f32 {
        if self.is_depth() { EMPTY_DEPTH } else { 0.0 }
    }

    fn is_depth(&self) -> bool {
        self.name == "Z" || self.name == "depth.Z" || self.name.ends_with(".depth.Z")
    }
}

/// Supported EXR compressions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Uncompressed.
    None,
    /// Run-length encoding.
    Rle,
    /// Deflate, one line per block.
    Zips,
    /// Deflate, 16 lines per block.
    #[default]
    Zip,
    /// Wavelets.
    Piz,
    /// DCT, lossy on colour (half channels) only.
    Dwaa,
    /// As `Dwaa`, in larger blocks.
    Dwab,
}

impl Compression {
    /// Whether the compression is lossy on colour.
    #[must_use]
    pub(crate) const fn is_lossy(self) -> bool {
        matches!(self, Self::Dwaa | Self::Dwab)
    }
}
