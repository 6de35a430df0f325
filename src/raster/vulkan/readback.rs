//! Reads rendered images back to the host.
//!
//! In: attachments, requested channel groups. Out: channels, one plane each. Every image has its own buffer, commands
//! and fence, so that the host unpacks one while the device copies the next; mapped images are read in place.

use super::attachments::Attachments;
use super::commands::{Commands, Contents, Usage};
use super::device::Device;
use super::formats::{IMAGES, ImageSpec};
use super::memory::{Buffer, BufferUse, Image, MemoryLocation};
use crate::image::{Channel, ChannelGroup};
use crate::raster::RasterError;
use ash::vk;
use rayon::prelude::*;
use std::sync::Arc;

const READ_BACK: BufferUse =
    BufferUse { name: "read back", usage: vk::BufferUsageFlags::TRANSFER_DST, location: MemoryLocation::GpuToCpu };

/// Pixels unpacked at a time, so that source and planes stay in the cache.
const BLOCK: usize = 8192;

/// Copies one image to the host. Field order: the commands wait before the buffer is dropped.
struct ImageCopy {
    commands: Commands,
    buffer: Option<Buffer>,
}

/// Copies frames to the host, image by image.
pub(super) struct Readback {
    copies: [ImageCopy; IMAGES.len()],
    device: Arc<Device>,
}

impl Readback {
    pub(super) fn new(device: &Arc<Device>) -> Result<Self, RasterError> {
        let copy = || Ok::<_, RasterError>(ImageCopy { commands: Commands::new(device, "read back")?, buffer: None });
        Ok(Self { copies: [copy()?, copy()?, copy()?, copy()?], device: Arc::clone(device) })
    }

    /// Returns the requested channels of the images copied by [`Self::copy`], in the order of [`ChannelGroup`].
    pub(super) fn read(
        &mut self,
        attachments: &mut Attachments,
        extent: vk::Extent2D,
        wanted: &[ChannelGroup],
    ) -> Result<Vec<Channel>, RasterError> {
        let mut channels = Vec::new();
        for ((copy, image), spec) in self.copies.iter_mut().zip(images(attachments)).zip(IMAGES) {
            if !is_wanted(&spec, wanted) {
                continue;
            }
            copy.commands.wait()?;
            let row_bytes = extent.width as usize * spec.components() * 4;
            let copied = copy.buffer.as_ref().map(|buffer| (buffer.bytes(), row_bytes));
            let mapped = image.and_then(|image| image.mapped_rows());
            let rows = mapped.or(copied).ok_or(RasterError::Misuse("an image was not copied"))?;
            unpack((rows, extent), &spec, wanted, &mut channels);
        }
        channels.sort_by_key(|(group, _)| *group);
        Ok(channels.into_iter().map(|(_, channel)| channel).collect())
    }

    /// Submits the copies of the upper left `extent` of all requested images.
    pub(super) fn copy(
        &mut self,
        attachments: &mut Attachments,
        extent: vk::Extent2D,
        wanted: &[ChannelGroup],
    ) -> Result<(), RasterError> {
        let images = images(attachments);
        for ((copy, image), spec) in self.copies.iter_mut().zip(images).zip(IMAGES) {
            if !is_wanted(&spec, wanted) {
                continue;
            }
            let image = image.ok_or(RasterError::Misuse("an image was not drawn"))?;
            copy.commands.begin()?;
            if image.mapped_rows().is_some() {
                copy.commands.prepare(image, Usage::HostRead, Contents::Keep);
            } else {
                let bytes = bytes_of(&spec, extent);
                let buffer = Buffer::reserve(&mut copy.buffer, &self.device, READ_BACK, (bytes, bytes))?;
                copy.commands.prepare(image, Usage::CopySource, Contents::Keep);
                copy.commands.copy_to_host(image, buffer, extent);
            }
            copy.commands.submit()?;
        }
        Ok(())
    }

    /// Creates buffers for all images of that extent.
    pub(super) fn reserve(&mut self, extent: vk::Extent2D) -> Result<(), RasterError> {
        for (copy, spec) in self.copies.iter_mut().zip(IMAGES) {
            let bytes = bytes_of(&spec, extent);
            Buffer::reserve(&mut copy.buffer, &self.device, READ_BACK, (bytes, bytes))?;
        }
        Ok(())
    }

    /// Records the copies of all images into other commands; the buffers must exist.
    pub(super) fn record_all(
        &self,
        commands: &Commands,
        attachments: &mut Attachments,
        extent: vk::Extent2D,
    ) -> Result<(), RasterError> {
        for (copy, image) in self.copies.iter().zip(images(attachments)) {
            let (Some(image), Some(buffer)) = (image, &copy.buffer) else {
                return Err(RasterError::Misuse("an image was not drawn"));
            };
            commands.prepare(image, Usage::CopySource, Contents::Keep);
            commands.copy_to_host(image, buffer, extent);
        }
        Ok(())
    }

    /// Returns copies of the contents of all buffers.
    pub(super) fn bytes(&self) -> Vec<Vec<u8>> {
        self.copies.iter().filter_map(|copy| copy.buffer.as_ref()).map(|buffer| buffer.bytes().to_vec()).collect()
    }

    /// Waits for all copies.
    pub(super) fn wait(&mut self) -> Result<(), RasterError> {
        self.copies.iter_mut().try_for_each(|copy| copy.commands.wait())
    }
}

fn bytes_of(spec: &ImageSpec, extent: vk::Extent2D) -> u64 {
    u64::from(extent.width) * u64::from(extent.height) * spec.components() as u64 * 4
}

/// Returns the images in the order of [`IMAGES`].
fn images(attachments: &mut Attachments) -> [Option<&mut Image>; 4] {
    let Attachments { color, data, .. } = attachments;
    match data {
        Some(data) => {
            let [normal_depth, motion, ids] = data.images.each_mut();
            [color.as_mut(), Some(normal_depth), Some(motion), Some(ids)]
        }
        None => [color.as_mut(), None, None, None],
    }
}

fn is_wanted(spec: &ImageSpec, wanted: &[ChannelGroup]) -> bool {
    spec.groups.iter().any(|group| wanted.contains(group))
}

/// Bytes from the first pixel on, and the row pitch in bytes.
type Rows<'a> = (&'a [u8], usize);

/// Appends the requested channels of the upper left `extent` of an image to `channels`.
fn unpack(
    (rows, extent): (Rows, vk::Extent2D),
    spec: &ImageSpec,
    wanted: &[ChannelGroup],
    channels: &mut Vec<(ChannelGroup, Channel)>,
) {
    let parts: Vec<_> = spec.channels().collect();
    let is_wanted = |at: usize| parts.get(at).is_some_and(|(group, _)| wanted.contains(group));
    let size = (extent.width as usize, extent.height as usize);
    let planes = match parts.len() {
        2 => Vec::from(planes::<2>(rows, size, is_wanted)),
        _ => Vec::from(planes::<4>(rows, size, is_wanted)),
    };
    for ((group, part), samples) in parts.into_iter().zip(planes).filter(|((group, _), _)| wanted.contains(group)) {
        channels.push((group, Channel { name: part.name.into(), storage: part.storage, samples }));
    }
}

/// Deinterleaves rows of vectors into planes of width · height; planes that are not requested stay empty.
fn planes<const N: usize>(
    (bytes, pitch): Rows,
    (width, height): (usize, usize),
    is_wanted: impl Fn(usize) -> bool,
) -> [Vec<f32>; N] {
    let area = width * height;
    let mut planes: [Vec<f32>; N] = std::array::from_fn(|at| if is_wanted(at) { vec![0.0; area] } else { Vec::new() });
    let mut rest = planes.each_mut().map(Vec::as_mut_slice);
    let rows_a_block = (BLOCK / width).clamp(1, height);
    let mut blocks = Vec::with_capacity(height.div_ceil(rows_a_block));
    // The last row may lack the padding.
    for block in bytes[..(height - 1) * pitch + width * N * 4].chunks(rows_a_block * pitch) {
        let samples = block.len().div_ceil(pitch) * width;
        let mut parts = rest.map(|plane| plane.split_at_mut(samples.min(plane.len())));
        blocks.push((block, parts.each_mut().map(|(part, _)| std::mem::take(part))));
        rest = parts.map(|(_, rest)| rest);
    }
    blocks.into_par_iter().for_each(|(block, mut parts)| {
        for (y, row) in block.chunks(pitch).enumerate() {
            let pixels: &[[f32; N]] = bytemuck::cast_slice(&row[..width * N * 4]);
            for (at, part) in parts.iter_mut().enumerate().filter(|(_, part)| !part.is_empty()) {
                part[y * width..(y + 1) * width].iter_mut().zip(pixels).for_each(|(sample, pixel)| *sample = pixel[at]);
            }
        }
    });
    planes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_hold_the_wanted_components_of_every_pixel() {
        for (width, height, gap) in [(1000, 37, 0), (7, 3, 5), (2 * BLOCK, 2, 1), (1, 1, 0)] {
            let pixels: Vec<[f32; 4]> =
                (0..(width + gap) * height).map(|at| [at as f32, 1.0, -(at as f32), 2.0 * at as f32]).collect();
            // The last row has no padding.
            let bytes: &[u8] = bytemuck::cast_slice(&pixels[..pixels.len() - gap]);
            let [x, y, z, w] = planes((bytes, (width + gap) * 16), (width, height), |at| at != 1);
            assert!(y.is_empty());
            for at in 0..width * height {
                let pixel = pixels[at / width * (width + gap) + at % width];
                assert_eq!([x[at], z[at], w[at]], [pixel[0], pixel[2], pixel[3]]);
            }
        }
    }
}
