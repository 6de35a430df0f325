//! Uploads geometry to the device.
//!
//! In: a pass's [`Geometry`]. Out: a host-visible buffer per pass in flight (vertices, clip positions, indices, viewer
//! and lights), which grows and is reused.

use super::commands::Commands;
use super::descriptors::Descriptors;
use super::device::Device;
use super::memory::{Buffer, BufferUse, MemoryLocation};
use super::pipeline::PipelineLayout;
use crate::raster::cpu::shading::Light;
use crate::raster::window::WindowFromScreen;
use crate::raster::{Geometry, RasterError, RasterVertex};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use rayon::prelude::*;
use std::sync::Arc;

const UPLOAD: BufferUse = BufferUse {
    name: "geometry",
    usage: vk::BufferUsageFlags::from_raw(
        vk::BufferUsageFlags::VERTEX_BUFFER.as_raw()
            | vk::BufferUsageFlags::INDEX_BUFFER.as_raw()
            | vk::BufferUsageFlags::STORAGE_BUFFER.as_raw(),
    ),
    location: MemoryLocation::CpuToGpu,
};

/// The header of `Pass` in geometry.wgsl; lights follow.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct GpuPass {
    eye: [f32; 4],
    environment: f32,
    light_count: u32,
    padding: [u32; 2],
}

/// Commands of a pass with the buffer they read. Field order: the commands wait before the buffer is dropped.
pub(super) struct UploadSlot {
    pub(super) commands: Commands,
    pub(super) pass_set: vk::DescriptorSet,
    buffer: Option<Buffer>,
    device: Arc<Device>,
}

/// Offsets of the parts of a mesh in the buffer of its pass, in bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshRange {
    pub(super) vertices: u64,
    pub(super) clip_positions: u64,
    pub(super) indices: u64,
}

/// Maximum spare capacity of a buffer: geometry varies slightly from frame to frame.
const SPARE_BYTES: u64 = 4 << 20;

impl UploadSlot {
    pub(super) fn new(
        device: &Arc<Device>,
        descriptors: &Descriptors,
        layout: &PipelineLayout,
    ) -> Result<Self, RasterError> {
        let commands = Commands::new(device, "pass")?;
        let pass_set = descriptors.set(layout.set(0), "pass")?;
        Ok(Self { commands, pass_set, buffer: None, device: Arc::clone(device) })
    }

    /// Waits until the slot is free and uploads a pass into it.
    pub(super) fn fill(
        &mut self,
        geometry: &Geometry,
        (window_from_screen, extent): (WindowFromScreen, vk::Extent2D),
        descriptors: &Descriptors,
    ) -> Result<MeshRange, RasterError> {
        check(geometry, self.device.facts().max_index)?;
        self.commands.wait()?;
        let lights: Vec<Light> = match geometry.lights.is_empty() {
            // The shader's array has at least one element.
            true => vec![Light::zeroed()],
            false => geometry.lights.iter().map(Light::from).collect(),
        };
        let head = pass_head(geometry);
        let (vertices, indices): (&[u8], &[u8]) =
            (bytemuck::cast_slice(&geometry.vertices), bytemuck::cast_slice(&geometry.indices));
        let [head, lights]: [&[u8]; 2] = [bytemuck::bytes_of(&head), bytemuck::cast_slice(&lights)];
        let clip_bytes = size_of::<[f32; 4]>() * geometry.vertices.len();
        let mesh = MeshRange {
            vertices: 0,
            clip_positions: vertices.len() as u64,
            indices: (vertices.len() + clip_bytes) as u64,
        };
        let align = self.device.facts().offset_alignment.max(16);
        let pass = (mesh.indices + indices.len() as u64).next_multiple_of(align);
        let pass_bytes = (head.len() + lights.len()) as u64;
        let needed = pass + pass_bytes;
        let wanted = needed + (needed / 2).min(SPARE_BYTES);
        let buffer = Buffer::reserve(&mut self.buffer, &self.device, UPLOAD, (needed, wanted))?;
        let bytes = buffer.bytes_mut();
        let parts = [(0, vertices), (mesh.indices, indices), (pass, head), (pass + head.len() as u64, lights)];
        for (start, part) in parts {
            bytes[start as usize..start as usize + part.len()].copy_from_slice(part);
        }
        let clip = &mut bytes[mesh.clip_positions as usize..][..clip_bytes];
        write_clip_positions(geometry, (window_from_screen, extent), bytemuck::cast_slice_mut(clip));
        descriptors.write_buffer((self.pass_set, 0), vk::DescriptorType::STORAGE_BUFFER, (buffer, pass, pass_bytes));
        Ok(mesh)
    }

    /// Returns the filled buffer.
    pub(super) fn buffer(&self) -> Result<&Buffer, RasterError> {
        self.buffer.as_ref().ok_or(RasterError::Misuse("a pass was drawn before it was filled"))
    }
}

fn write_clip_positions(
    geometry: &Geometry,
    (window_from_screen, extent): (WindowFromScreen, vk::Extent2D),
    to: &mut [[f32; 4]],
) {
    let size = DVec2::new(f64::from(extent.width), f64::from(extent.height));
    let pairs = to.par_iter_mut().zip(&geometry.vertices).with_min_len(4096);
    pairs.for_each(|(clip, vertex)| *clip = window_from_screen.clip_position(vertex, size));
}

/// Rejects geometry with out-of-bounds indices, or beyond the device's limits.
fn check(geometry: &Geometry, max_index: u32) -> Result<(), RasterError> {
    let vertices = geometry.vertices.len();
    let last = geometry.indices.par_iter().with_min_len(1 << 16).max().copied();
    if last.is_some_and(|last| last as usize >= vertices) {
        return Err(RasterError::Misuse("an index points past the vertices"));
    }
    if last.is_some_and(|last| last > max_index) {
        return Err(RasterError::TooManyVertices { vertices, limit: u64::from(max_index) + 1 });
    }
    let count = geometry.indices.len();
    let is_inside = |range: &std::ops::Range<u32>| range.start <= range.end && range.end as usize <= count;
    if !geometry.draws.iter().all(|draw| is_inside(&draw.indices)) {
        return Err(RasterError::Misuse("a draw reaches past the indices"));
    }
    Ok(())
}

fn pass_head(geometry: &Geometry) -> GpuPass {
    let eye = match geometry.parallel_view {
        Some(towards_viewer) => towards_viewer.extend(0.0),
        None => geometry.eye.0.extend(1.0),
    };
    GpuPass {
        eye: eye.to_array(),
        environment: geometry.environment,
        light_count: geometry.lights.len() as u32,
        padding: [0; 2],
    }
}

const _: () = assert!(size_of::<Light>() == 64 && size_of::<GpuPass>() == 32);
const _: () = assert!(size_of::<RasterVertex>() == 116);
