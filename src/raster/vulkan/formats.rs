//! Formats and uses of the attachments: shared by pipelines, attachments and the choice of a device.
//!
//! In: the channel table. Out: one [`ImageSpec`] per attachment, in the order of the locations in `geometry.wgsl`.

use crate::image::ChannelGroup;
use ash::vk;

/// A colour attachment and the channels in its components.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageSpec {
    pub(super) name: &'static str,
    pub(super) format: vk::Format,
    /// The groups whose channels are consecutive in a pixel.
    pub(super) groups: &'static [ChannelGroup],
}

impl ImageSpec {
    /// Returns group and specification of every channel, in the order of the components.
    pub(super) fn channels(&self) -> impl Iterator<Item = (ChannelGroup, &'static crate::image::ChannelSpec)> {
        self.groups.iter().flat_map(|&group| group.channels().iter().map(move |spec| (group, spec)))
    }

    /// Number of components per pixel.
    pub(super) fn components(&self) -> usize {
        self.channels().count()
    }

    /// Returns the value of empty pixels.
    pub(super) fn clear(&self) -> [f32; 4] {
        let mut clear = [0.0; 4];
        clear.iter_mut().zip(self.channels()).for_each(|(value, (_, spec))| *value = spec.empty);
        clear
    }
}

/// Linear colour with associated alpha.
pub(super) const COLOR: ImageSpec =
    ImageSpec { name: "colour", format: vk::Format::R32G32B32A32_SFLOAT, groups: &[ChannelGroup::Beauty] };

/// The data channels.
pub(super) const DATA: [ImageSpec; 3] = [
    ImageSpec {
        name: "normal and depth",
        format: vk::Format::R32G32B32A32_SFLOAT,
        groups: &[ChannelGroup::Normal, ChannelGroup::Depth],
    },
    ImageSpec { name: "motion", format: vk::Format::R32G32B32A32_SFLOAT, groups: &[ChannelGroup::Motion] },
    ImageSpec { name: "ids", format: vk::Format::R32G32_SFLOAT, groups: &[ChannelGroup::Id] },
];

/// All images that are read back.
pub(super) const IMAGES: [ImageSpec; 4] = [COLOR, DATA[0], DATA[1], DATA[2]];

/// Reversed z.
pub(super) const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// Usage of an image that is only rendered into.
pub(super) const ATTACHMENT: vk::ImageUsageFlags = vk::ImageUsageFlags::COLOR_ATTACHMENT;

/// Usage of an image that is also read back.
pub(super) const READ_BACK: vk::ImageUsageFlags =
    vk::ImageUsageFlags::from_raw(ATTACHMENT.as_raw() | vk::ImageUsageFlags::TRANSFER_SRC.as_raw());

/// Usage of an image that is resolved into another.
pub(super) const RESOLVED: vk::ImageUsageFlags =
    vk::ImageUsageFlags::from_raw(ATTACHMENT.as_raw() | vk::ImageUsageFlags::SAMPLED.as_raw());

/// Textures of a material: base colour, metallic-roughness, normal, occlusion, emissive.
pub(super) const TEXTURES_PER_MATERIAL: usize = 5;
