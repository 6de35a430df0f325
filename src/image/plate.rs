//! A whole EXR file of any program, as plain data.
//!
//! In: what was read. Out: all parts, views, channels and attributes, ready to be changed and written again.

use super::Channel;
use crate::space::PixelRect;
use exr::image::Encoding;
use exr::meta::header::{ImageAttributes, LayerAttributes};

/// A whole EXR file, so that nothing is lost between reading and writing.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// The frame as the viewer sees it, in pixels.
    pub display: PixelRect,
    /// Width of a pixel divided by its height.
    pub pixel_aspect: f64,
    /// Parts in the file's order; a file of one part has one.
    pub parts: Vec<PlatePart>,
    /// Attributes that the parts share.
    pub(super) attributes: ImageAttributes,
}

/// One part of an EXR file.
#[derive(Clone, Debug, PartialEq)]
pub struct PlatePart {
    /// Its name, where it has one: `rgba.left`.
    pub name: Option<String>,
    /// Its view, where it has one: `left`.
    pub view: Option<String>,
    /// The pixels that are stored; may lie outside the display window.
    pub data_window: PixelRect,
    /// All channels, in the file's order, each with `data_window.area()` samples.
    pub channels: Vec<Channel>,
    /// What else the part says about itself; Cryptomatte manifests stand here.
    pub(super) attributes: LayerAttributes,
    /// How its pixels are compressed.
    pub(super) encoding: Encoding,
}
