//! Geometry on its way to the device.
//!
//! In: a pass's [`Geometry`]. Out: one host-visible buffer a pass in flight (vertices, indices, viewer and lights),
//! which grows and is used again; two take turns, so that one is filled while the other is drawn.

use super::commands::Commands;
use super::descriptors::Descriptors;
use super::device::Device;
use super::memory::{Buffer, BufferUse, MemoryLocation};
use super::pipeline::PipelineLayout;
use crate::raster::cpu::shading::Light;
use crate::raster::{Geometry, RasterError, RasterVertex};
use ash::vk;
use bytemuck::{Pod, Zeroable};
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

/// Head of `Pass` of geometry.wgsl; lights follow.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct GpuPass {
    eye: [f32; 4],
    environment: f32,
    light_count: u32,
    padding: [u32; 2],
}

/// Commands of a pass with the buffer they read. Field order: the commands wait before the buffer goes.
pub(super) struct Slot {
    pub(super) commands: Commands,
    pub(super) pass_set: vk::DescriptorSet,
    buffer: Option<Buffer>,
    device: Arc<Device>,
}

/// Where the parts of a pass lie in its buffer, bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshPlace {
    pub(super) vertices: u64,
    pub(super) indices: u64,
}

impl Slot {
    pub(super) fn new(
        device: &Arc<Device>,
        descriptors: &Descriptors,
        layout: &PipelineLayout,
    ) -> Result<Self, RasterError> {
        let commands = Commands::new(device, "pass")?;
        let pass_set = descriptors.set(layout.set(0), "pass")?;
        Ok(Self { commands, pass_set, buffer: None, device: Arc::clone(device) })
    }

    /// Waits until the slot is free and puts a pass into it.
    pub(super) fn fill(&mut self, geometry: &Geometry, descriptors: &Descriptors) -> Result<MeshPlace, RasterError> {
        check(geometry)?;
        self.commands.wait()?;
        let lights: Vec<Light> = match geometry.lights.is_empty() {
            // The shader's array has at least one element.
            true => vec![Light::zeroed()],
            false => geometry.lights.iter().map(Light::from).collect(),
        };
        let head = pass_head(geometry);
        let parts: [&[u8]; 4] = [
            bytemuck::cast_slice(&geometry.vertices),
            bytemuck::cast_slice(&geometry.indices),
            bytemuck::bytes_of(&head),
            bytemuck::cast_slice(&lights),
        ];
        let align = self.device.facts().offset_alignment.max(16);
        let indices = parts[0].len() as u64;
        let pass = (indices + parts[1].len() as u64).next_multiple_of(align);
        let pass_bytes = (parts[2].len() + parts[3].len()) as u64;
        let bytes = pass + pass_bytes;
        // Geometry differs a little from frame to frame: room to grow by a half.
        let buffer = Buffer::reserve(&mut self.buffer, &self.device, UPLOAD, (bytes, bytes + bytes / 2))?;
        let bytes = buffer.bytes_mut();
        let starts = [0, indices, pass, pass + parts[2].len() as u64];
        for (start, part) in starts.into_iter().zip(parts) {
            bytes[start as usize..start as usize + part.len()].copy_from_slice(part);
        }
        descriptors.write_buffer((self.pass_set, 0), vk::DescriptorType::STORAGE_BUFFER, (buffer, pass, pass_bytes));
        Ok(MeshPlace { vertices: 0, indices })
    }

    /// The filled buffer.
    pub(super) fn buffer(&self) -> Result<&Buffer, RasterError> {
        self.buffer.as_ref().ok_or(RasterError::Misuse("a pass was drawn before it was filled"))
    }
}

/// What the device would read out of bounds must not reach it.
fn check(geometry: &Geometry) -> Result<(), RasterError> {
    let vertices = geometry.vertices.len();
    if geometry.indices.iter().max().is_some_and(|&last| last as usize >= vertices) {
        return Err(RasterError::Misuse("an index points past the vertices"));
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
