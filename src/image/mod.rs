//! Stage 8: a [`Frame`] to and from EXR and PNG files; frame sequences.

use crate::space::PixelRect;

/// A picture of named channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The frame as the viewer sees it, in pixels.
    pub display: PixelRect,
    /// The pixels that are stored; may lie outside the display window.
    pub data_window: PixelRect,
    /// Width of a pixel divided by its height.
    pub pixel_aspect: f64,
    /// All channels, each with `data_window.area()` samples.
    pub channels: Vec<Channel>,
}

/// One channel: rows from the top, no padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name as in the EXR file: `R`, `depth.Z`.
    pub name: String,
    /// How it is stored.
    pub storage: Storage,
    /// #pixels of the data window.
    pub samples: Vec<f32>,
}

/// How a channel's samples lie in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// 16-bit float: colour.
    Half,
    /// 32-bit float: everything that is not colour.
    Float,
    /// 32-bit unsigned: ids of other programs.
    Uint,
}

impl Frame {
    /// The channel of that name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }
}

/// EXR compressions offered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// None.
    None,
    /// Run lengths.
    Rle,
    /// Deflate, one line a block.
    Zips,
    /// Deflate, 16 lines a block.
    #[default]
    Zip,
    /// Wavelets.
    Piz,
    /// DCT, lossy on colour.
    Dwaa,
    /// DCT, lossy on colour, large blocks.
    Dwab,
}
