//! The images that a frame is drawn into.
//!
//! In: window and channels. Out: attachments, made when first used, kept from frame to frame while they are large
//! enough.

use super::descriptors::Descriptors;
use super::device::Device;
use super::memory::{Home, Image, ImageUse};
use super::pipeline::PipelineLayout;
use crate::raster::RasterError;
use ash::vk;
use std::sync::Arc;

/// Linear colour with associated alpha.
pub(super) const COLOR_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Normal and depth; motion forward and backward; layer and object id.
pub(super) const DATA_FORMATS: [vk::Format; 3] =
    [vk::Format::R32G32B32A32_SFLOAT, vk::Format::R32G32B32A32_SFLOAT, vk::Format::R32G32_SFLOAT];

/// Reversed z.
pub(super) const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// What data channels hold where nothing is: `depth.Z` is 1e10.
pub(super) const DATA_CLEAR: [[f32; 4]; 3] = [[0.0, 0.0, 0.0, 1e10], [0.0; 4], [0.0; 4]];

const ATTACHMENT: vk::ImageUsageFlags = vk::ImageUsageFlags::COLOR_ATTACHMENT;
/// Of images that the host reads.
pub(super) const READ_BACK: vk::ImageUsageFlags =
    vk::ImageUsageFlags::from_raw(ATTACHMENT.as_raw() | vk::ImageUsageFlags::TRANSFER_SRC.as_raw());
const RESOLVED: vk::ImageUsageFlags =
    vk::ImageUsageFlags::from_raw(ATTACHMENT.as_raw() | vk::ImageUsageFlags::SAMPLED.as_raw());

/// Which images a frame needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The colour of the frame.
    Color,
    /// The colour of one sample pass, where there are several.
    Sample,
    /// Depth of a beauty pass drawn by itself.
    BeautyDepth,
    /// Data channels and their depth, which all data passes share.
    Data,
}

/// Colour, sample colour, depths and data of frames up to `extent`.
pub(super) struct Attachments {
    pub(super) color: Option<Image>,
    pub(super) sample: Option<Image>,
    pub(super) beauty_depth: Option<Image>,
    pub(super) data: Option<DataImages>,
    /// Reads `sample`.
    pub(super) sample_set: vk::DescriptorSet,
    extent: vk::Extent2D,
    device: Arc<Device>,
}

/// Data channels, as [`DATA_FORMATS`], with the depth that decides which surface they show.
pub(super) struct DataImages {
    pub(super) images: [Image; 3],
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

    /// Makes room for frames of that size. No submitted commands may use the images.
    pub(super) fn resize(&mut self, extent: vk::Extent2D) {
        if extent.width > self.extent.width || extent.height > self.extent.height {
            (self.color, self.sample, self.beauty_depth, self.data) = (None, None, None, None);
            self.extent = extent;
        }
    }

    /// Makes the images of a part if they are not there yet.
    pub(super) fn prepare(&mut self, part: Part, descriptors: &Descriptors) -> Result<(), RasterError> {
        match part {
            Part::Color if self.color.is_none() => self.color = Some(self.image("colour", COLOR_FORMAT, READ_BACK)?),
            Part::BeautyDepth if self.beauty_depth.is_none() => self.beauty_depth = Some(self.depth("depth")?),
            Part::Sample if self.sample.is_none() => {
                let sample = self.image("sample colour", COLOR_FORMAT, RESOLVED)?;
                descriptors.write_images(self.sample_set, &[sample.view()], &[]);
                self.sample = Some(sample);
            }
            Part::Data if self.data.is_none() => self.data = Some(self.data_images()?),
            _ => {}
        }
        Ok(())
    }

    fn data_images(&self) -> Result<DataImages, RasterError> {
        let [normal_depth, motion, ids] = DATA_FORMATS;
        Ok(DataImages {
            images: [
                self.image("normal and depth", normal_depth, READ_BACK)?,
                self.image("motion", motion, READ_BACK)?,
                self.image("ids", ids, READ_BACK)?,
            ],
            depth: self.depth("data depth")?,
        })
    }

    fn image(&self, name: &'static str, format: vk::Format, usage: vk::ImageUsageFlags) -> Result<Image, RasterError> {
        let is_mapped = usage == READ_BACK && self.device.facts().has_mapped_attachments;
        let home = if is_mapped { Home::Mapped } else { Home::Device };
        Image::new(&self.device, ImageUse { name, format, usage, mip_levels: 1, home }, self.extent)
    }

    fn depth(&self, name: &'static str) -> Result<Image, RasterError> {
        self.image(name, DEPTH_FORMAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)
    }
}
