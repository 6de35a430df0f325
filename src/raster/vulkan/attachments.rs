//! The images that a frame is rendered into.
//!
//! In: the size of a frame. Out: attachments, created on first use and reused between frames while they are large
//! enough.

use super::descriptors::Descriptors;
use super::device::Device;
use super::formats::{COLOR, DATA, DEPTH_FORMAT, READ_BACK, RESOLVED};
use super::memory::{Image, ImageUse, Placement};
use super::pipeline::PipelineLayout;
use crate::raster::RasterError;
use ash::vk;
use std::sync::Arc;

/// Images that are created together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AttachmentSet {
    /// The colour of the frame.
    Color,
    /// The colour of one sample pass, if there are several.
    Sample,
    /// Depth of a separate beauty pass.
    BeautyDepth,
    /// Data channels and their depth.
    Data,
}

/// Colour, sample colour, depths and data of frames up to `extent`.
pub(super) struct Attachments {
    pub(super) color: Option<Image>,
    pub(super) sample: Option<Image>,
    pub(super) beauty_depth: Option<Image>,
    pub(super) data: Option<DataImages>,
    /// The descriptor set that reads `sample`.
    pub(super) sample_set: vk::DescriptorSet,
    extent: vk::Extent2D,
    device: Arc<Device>,
}

/// Data channels, as in [`DATA`], with the depth that determines their visible surface.
pub(super) struct DataImages {
    pub(super) images: [Image; DATA.len()],
    pub(super) depth: Image,
}

impl Attachments {
    pub(super) fn new(
        device: &Arc<Device>,
        descriptors: &Descriptors,
        resolve_layout: &PipelineLayout,
    ) -> Result<Self, RasterError> {
        Ok(Self {
            color: None,
            sample: None,
            beauty_depth: None,
            data: None,
            sample_set: descriptors.set(resolve_layout.set(0), "sample colour")?,
            extent: vk::Extent2D::default(),
            device: Arc::clone(device),
        })
    }

    /// Resizes the images for frames of that size. No submitted commands may use them.
    pub(super) fn resize(&mut self, extent: vk::Extent2D) {
        if extent.width > self.extent.width || extent.height > self.extent.height {
            (self.color, self.sample, self.beauty_depth, self.data) = (None, None, None, None);
            self.extent = extent;
        }
    }

    /// Creates the images of a set if needed.
    pub(super) fn prepare(&mut self, set: AttachmentSet, descriptors: &Descriptors) -> Result<(), RasterError> {
        match set {
            AttachmentSet::Color if self.color.is_none() => {
                self.color = Some(self.image(COLOR.name, COLOR.format, READ_BACK)?);
            }
            AttachmentSet::BeautyDepth if self.beauty_depth.is_none() => self.beauty_depth = Some(self.depth("depth")?),
            AttachmentSet::Sample if self.sample.is_none() => {
                let sample = self.image("sample colour", COLOR.format, RESOLVED)?;
                descriptors.write_images(self.sample_set, &[sample.view()], &[]);
                self.sample = Some(sample);
            }
            AttachmentSet::Data if self.data.is_none() => self.data = Some(self.data_images()?),
            _ => {}
        }
        Ok(())
    }

    fn data_images(&self) -> Result<DataImages, RasterError> {
        let [first, second, third] = DATA.map(|spec| self.image(spec.name, spec.format, READ_BACK));
        Ok(DataImages { images: [first?, second?, third?], depth: self.depth("data depth")? })
    }

    fn image(&self, name: &'static str, format: vk::Format, usage: vk::ImageUsageFlags) -> Result<Image, RasterError> {
        let is_mapped = usage == READ_BACK && self.device.facts().has_mapped_attachments;
        let placement = if is_mapped { Placement::Mapped } else { Placement::Device };
        Image::new(&self.device, ImageUse { name, format, usage, mip_levels: 1, placement }, self.extent)
    }

    fn depth(&self, name: &'static str) -> Result<Image, RasterError> {
        self.image(name, DEPTH_FORMAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)
    }
}
