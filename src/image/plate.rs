//! The complete contents of an EXR file of any program, as plain data.
//!
//! In: a file's contents, or frames. Out: all parts, views, channels and attributes, for modification and writing.

use super::exr_file::{string, text};
use super::{Channel, Frame, FrameMetadata};
use crate::space::{FrameSize, PixelRect};
use exr::image::{Blocks, Encoding};
use exr::meta::attribute::{AttributeValue, IntegerBounds, LineOrder};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use std::collections::BTreeMap;

/// The complete contents of an EXR file, so that reading and writing is lossless.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// The display window, in pixels.
    pub display: PixelRect,
    /// Width of a pixel divided by its height.
    pub pixel_aspect: f64,
    /// Parts in file order.
    pub parts: Vec<PlatePart>,
    /// Messages about contents of the file that are not in the plate: `part 'rgba': smaller mip levels`.
    pub left_out: Vec<String>,
    /// Attributes shared by all parts, except for the windows and the pixel aspect.
    pub(super) attributes: ImageAttributes,
}

/// One part of an EXR file.
#[derive(Clone, Debug, PartialEq)]
pub struct PlatePart {
    /// Name, if it has one: `rgba.left`. Files with several parts need distinct names.
    pub name: Option<String>,
    /// View, if it has one: `left`.
    pub view: Option<String>,
    /// Window of the stored pixels; may lie outside the display window.
    pub data_window: PixelRect,
    /// All channels in file order, each with `data_window.area()` samples.
    pub channels: Vec<Channel>,
    /// Further attributes of the part, including Cryptomatte manifests, except for name, view and position.
    pub(super) attributes: LayerAttributes,
    /// Compression and tiling.
    pub(super) encoding: Encoding,
    /// The `pLinear` flag of each channel: whether lossy compressions treat it as linear.
    pub(super) linear: BTreeMap<String, bool>,
}

impl Plate {
    /// Creates a plate of these parts without further attributes.
    #[must_use]
    pub(crate) fn new(display: PixelRect, pixel_aspect: f64, parts: Vec<PlatePart>) -> Self {
        Self { display, pixel_aspect, parts, left_out: Vec::new(), attributes: no_shared_attributes() }
    }

    /// Creates a plate of one unnamed part, compressed as [`super::Compression::Zip`].
    #[must_use]
    pub fn from_frame(frame: Frame) -> Self {
        let part = PlatePart::new(frame.data_window, frame.channels);
        Self::new(frame.display, frame.pixel_aspect, vec![part])
    }

    /// Creates a plate of our own frame with all metadata that [`super::write_exr`] would write.
    #[must_use]
    pub(crate) fn from_render(frame: Frame, metadata: &FrameMetadata) -> Self {
        let mut plate = Self::from_frame(frame);
        let size = plate.frame_size();
        plate.parts.iter_mut().for_each(|part| metadata.add_to_layer(&mut part.attributes, size));
        plate
    }

    /// Returns the plate with other parts; keeps the display window, pixel aspect and shared attributes.
    #[must_use]
    pub fn with_parts(&self, parts: Vec<PlatePart>) -> Self {
        let (left_out, attributes) = (self.left_out.clone(), self.attributes.clone());
        Self { display: self.display, pixel_aspect: self.pixel_aspect, parts, left_out, attributes }
    }

    /// Returns all channels of the first part, and those of further parts with the same data window and new names. A
    /// plate without parts gives a frame without channels.
    #[must_use]
    pub fn into_frame(self) -> Frame {
        let mut parts = self.parts.into_iter();
        let first = parts.next().unwrap_or_else(|| PlatePart::new(self.display, Vec::new()));
        let (display, pixel_aspect, data_window) = (self.display, self.pixel_aspect, first.data_window);
        let mut frame = Frame { display, data_window, pixel_aspect, channels: first.channels };
        for part in parts.filter(|part| part.data_window == data_window) {
            let new: Vec<_> =
                part.channels.into_iter().filter(|channel| frame.channel(&channel.name).is_none()).collect();
            frame.channels.extend(new);
        }
        frame
    }

    /// Returns the part of this name.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn part(&self, name: &str) -> Option<&PlatePart> {
        self.parts.iter().find(|part| part.name.as_deref() == Some(name))
    }

    /// Returns the display window, which defines screen space.
    #[must_use]
    pub const fn frame_size(&self) -> FrameSize {
        FrameSize { width: self.display.width, height: self.display.height, pixel_aspect: self.pixel_aspect }
    }

    /// Returns the data window of a part, relative to the upper left corner of the display window.
    #[must_use]
    pub(crate) fn window_of(&self, part: &PlatePart) -> PixelRect {
        part.data_window.relative_to(self.display)
    }

    /// Returns the union of the display window and all data windows, relative to the corner of the display window.
    #[must_use]
    pub(crate) fn reach(&self) -> PixelRect {
        self.parts.iter().map(|part| self.window_of(part)).fold(self.frame_size().window(), PixelRect::union)
    }

    /// Whether pinwarp rendered the plate; false for warped frames of other programs, which keep their software attribute.
    #[must_use]
    pub(crate) fn is_own_render(&self) -> bool {
        let software = self.parts.first().and_then(|part| part.attributes.software_name.as_ref());
        software.is_some_and(|software| string(software).starts_with("pinwarp "))
    }

    /// Stores which frame of which shot this is in the first part, for [`super::read_metadata`]. Keeps the plate's
    /// software, rate and camera.
    pub(crate) fn set_metadata(&mut self, metadata: &FrameMetadata) {
        if let Some(first) = self.parts.first_mut() {
            metadata.add_provenance(&mut first.attributes);
        }
    }
}

impl PlatePart {
    /// Creates a part without a name, view or attributes; scan lines, compressed as [`super::Compression::Zip`].
    #[must_use]
    pub(crate) fn new(data_window: PixelRect, channels: Vec<Channel>) -> Self {
        let encoding = Encoding {
            compression: exr::prelude::Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let (attributes, linear) = (LayerAttributes::default(), BTreeMap::new());
        Self { name: None, view: None, data_window, channels, attributes, encoding, linear }
    }

    /// Returns the part with the same attributes and other pixels.
    #[must_use]
    pub fn with_channels(&self, data_window: PixelRect, channels: Vec<Channel>) -> Self {
        Self {
            name: self.name.clone(),
            view: self.view.clone(),
            data_window,
            channels,
            attributes: self.attributes.clone(),
            encoding: self.encoding,
            linear: self.linear.clone(),
        }
    }

    /// Returns OpenEXR's name of the compression: `zip`.
    #[cfg(any(test, feature = "cli"))]
    #[must_use]
    pub(crate) fn compression(&self) -> String {
        match self.encoding.compression {
            exr::prelude::Compression::Uncompressed => "none".to_owned(),
            exr::prelude::Compression::RLE => "rle".to_owned(),
            exr::prelude::Compression::ZIP1 => "zips".to_owned(),
            exr::prelude::Compression::ZIP16 => "zip".to_owned(),
            exr::prelude::Compression::PIZ => "piz".to_owned(),
            exr::prelude::Compression::PXR24 => "pxr24".to_owned(),
            exr::prelude::Compression::B44 => "b44".to_owned(),
            exr::prelude::Compression::B44A => "b44a".to_owned(),
            exr::prelude::Compression::DWAA(_) => "dwaa".to_owned(),
            exr::prelude::Compression::DWAB(_) => "dwab".to_owned(),
            other => format!("{other:?}").to_lowercase(),
        }
    }

    /// Returns the channel of this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Returns the part's own view, or else the views that share it (`multiView`), starting with that of channels which name none.
    #[must_use]
    pub(crate) fn views(&self) -> Vec<String> {
        let shared = self.attributes.multi_view_names.iter().flatten().map(string);
        self.view.clone().map_or_else(|| shared.collect(), |view| vec![view])
    }

    /// Sets the views that share this part, starting with that of channels which name none.
    #[cfg(test)]
    pub(crate) fn set_views(&mut self, views: &[&str]) {
        self.attributes.multi_view_names = Some(views.iter().map(|view| text(view)).collect());
    }

    /// Returns a custom text attribute: `cryptomatte/f834d0a/manifest`.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<String> {
        text_of(self.attributes.other.get(&text(name))?)
    }

    /// Sets a custom text attribute. Names are 1 to 255 bytes long.
    pub fn set_text(&mut self, name: &str, value: &str) {
        self.attributes.other.insert(text(name), AttributeValue::Text(text(value)));
    }

    /// Returns all custom text attributes whose names begin with `prefix`, by name.
    #[must_use]
    pub fn texts(&self, prefix: &str) -> BTreeMap<String, String> {
        let texts = self.attributes.other.iter().filter_map(|(name, value)| Some((string(name), text_of(value)?)));
        texts.filter(|(name, _)| name.starts_with(prefix)).collect()
    }

    /// Removes every custom attribute whose name begins with `prefix`.
    pub(crate) fn remove_attributes(&mut self, prefix: &str) {
        self.attributes.other.retain(|name, _| !string(name).starts_with(prefix));
    }
}

fn text_of(value: &AttributeValue) -> Option<String> {
    if let AttributeValue::Text(text) = value { Some(string(text)) } else { None }
}

/// The window is a placeholder; [`Plate::display`] is used instead.
pub(super) fn no_shared_attributes() -> ImageAttributes {
    ImageAttributes::new(IntegerBounds::from_dimensions((1, 1)))
}
