//! Drawing commands: a [`Rendering`] lives between vkCmdBeginRendering and vkCmdEndRendering.
//!
//! In: prepared attachments, pipelines, sets, buffers. Out: recorded draws.

use super::commands::Commands;
use super::memory::{Buffer, Image};
use super::pipeline::{Pipeline, PipelineLayout};
use super::upload::MeshRange;
use ash::vk;

/// An attachment, prepared for its use; `clear` is its initial value, `None` preserves its pixels.
pub(super) struct Attachment<'a, T> {
    pub(super) image: &'a Image,
    pub(super) clear: Option<T>,
}

/// A render pass instance over the upper left part of its attachments; ends when dropped.
pub(super) struct Rendering<'a> {
    commands: &'a Commands,
}

/// The faces to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Faces {
    /// Both sides; the front is counter-clockwise.
    All,
    /// Both sides; the front is clockwise (mirrored nodes).
    AllMirrored,
    /// Front faces only; the front is counter-clockwise on the screen.
    CounterClockwise,
    /// Front faces only; the front is clockwise.
    Clockwise,
}

impl<'a> Rendering<'a> {
    pub(super) fn begin(
        commands: &'a Commands,
        extent: vk::Extent2D,
        colors: &[Attachment<[f32; 4]>],
        depth: Option<Attachment<f32>>,
    ) -> Self {
        let colors: Vec<_> = colors
            .iter()
            .map(|color| {
                let clear = color.clear.map(|float32| vk::ClearValue { color: vk::ClearColorValue { float32 } });
                attachment(color.image, clear)
            })
            .collect();
        let depth = depth.map(|depth| {
            let clear = depth.clear.map(|depth| vk::ClearDepthStencilValue { depth, stencil: 0 });
            attachment(depth.image, clear.map(|depth_stencil| vk::ClearValue { depth_stencil }))
        });
        let area = vk::Rect2D::default().extent(extent);
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        let this = Self { commands };
        // SAFETY: recording, not inside rendering; the area lies in all attachments
        // (VUID-VkRenderingInfo-pNext-06079, -06080), which are in attachment layouts (`Commands::prepare`).
        unsafe { this.raw().cmd_begin_rendering(this.buffer(), &info) };
        this.cover(extent);
        this
    }

    fn raw(&self) -> &ash::Device {
        self.commands.raw()
    }

    fn buffer(&self) -> vk::CommandBuffer {
        self.commands.buffer()
    }

    fn cover(&self, extent: vk::Extent2D) {
        let viewport = vk::Viewport {
            x: 0.0,
            y: 0.0,
            width: extent.width as f32,
            height: extent.height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        // SAFETY: recording; within the limits, as `Facts::max_side` ensures (VUID-VkViewport-width-01771).
        unsafe { self.raw().cmd_set_viewport(self.buffer(), 0, &[viewport]) };
        let scissor = vk::Rect2D::default().extent(extent);
        // SAFETY: recording.
        unsafe { self.raw().cmd_set_scissor(self.buffer(), 0, &[scissor]) };
    }

    /// Binds a pipeline, which must have been created for the formats of the attachments.
    pub(super) fn bind_pipeline(&self, pipeline: &Pipeline) {
        // SAFETY: recording; a graphics pipeline (VUID-vkCmdBindPipeline-pipelineBindPoint-00779).
        unsafe {
            self.raw().cmd_bind_pipeline(self.buffer(), vk::PipelineBindPoint::GRAPHICS, pipeline.get());
        }
    }

    pub(super) fn bind_set(&self, layout: &PipelineLayout, index: u32, set: vk::DescriptorSet) {
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: recording; the set was allocated for this index of the layout
        // (VUID-vkCmdBindDescriptorSets-pDescriptorSets-00358).
        unsafe { self.raw().cmd_bind_descriptor_sets(self.buffer(), point, layout.get(), index, &[set], &[]) };
    }

    /// Sets the push constants; `data` fills the layout's range from its start.
    pub(super) fn push(&self, layout: &PipelineLayout, data: &[u8]) {
        // SAFETY: recording; no longer than the layout's range, multiples of 4 bytes
        // (VUID-vkCmdPushConstants-offset-01795, -size-00369), for the range's stages (-offset-01796).
        unsafe {
            self.raw().cmd_push_constants(self.buffer(), layout.get(), PipelineLayout::PUSH_STAGES, 0, data);
        }
    }

    pub(super) fn set_faces(&self, faces: Faces) {
        let (cull, front) = match faces {
            Faces::All => (vk::CullModeFlags::NONE, vk::FrontFace::COUNTER_CLOCKWISE),
            Faces::AllMirrored => (vk::CullModeFlags::NONE, vk::FrontFace::CLOCKWISE),
            Faces::CounterClockwise => (vk::CullModeFlags::BACK, vk::FrontFace::COUNTER_CLOCKWISE),
            Faces::Clockwise => (vk::CullModeFlags::BACK, vk::FrontFace::CLOCKWISE),
        };
        // SAFETY: recording; dynamic in Vulkan 1.3.
        unsafe { self.raw().cmd_set_cull_mode(self.buffer(), cull) };
        // SAFETY: as above.
        unsafe { self.raw().cmd_set_front_face(self.buffer(), front) };
    }

    /// Binds a mesh that is stored in one buffer.
    pub(super) fn bind_mesh(&self, buffer: &Buffer, mesh: MeshRange) {
        let (buffers, offsets) = ([buffer.get(); 2], [mesh.vertices, mesh.clip_positions]);
        // SAFETY: recording; the offsets lie in the buffer (VUID-vkCmdBindVertexBuffers-pOffsets-00626).
        unsafe { self.raw().cmd_bind_vertex_buffers(self.buffer(), 0, &buffers, &offsets) };
        // SAFETY: as above, aligned to 4 (VUID-vkCmdBindIndexBuffer-offset-08783).
        unsafe { self.raw().cmd_bind_index_buffer(self.buffer(), buffer.get(), mesh.indices, vk::IndexType::UINT32) };
    }

    /// Draws indexed triangles; `upload` checked that indices and vertices exist and are within the device's limits.
    pub(super) fn draw_indexed(&self, indices: std::ops::Range<u32>) {
        let count = indices.end - indices.start;
        // SAFETY: pipeline, sets, push constants and buffers are bound; the range lies in the index buffer
        // (VUID-vkCmdDrawIndexed-robustBufferAccess2-08798).
        unsafe { self.raw().cmd_draw_indexed(self.buffer(), count, 1, indices.start, 0, 0) };
    }

    /// Draws a triangle whose corners the vertex shader generates.
    pub(super) fn draw_triangle(&self) {
        // SAFETY: as above, without buffers.
        unsafe { self.raw().cmd_draw(self.buffer(), 3, 1, 0, 0) };
    }
}

impl Drop for Rendering<'_> {
    fn drop(&mut self) {
        // SAFETY: begun in `begin` (VUID-vkCmdEndRendering-None-06161).
        unsafe { self.raw().cmd_end_rendering(self.buffer()) };
    }
}

fn attachment<'a>(image: &Image, clear: Option<vk::ClearValue>) -> vk::RenderingAttachmentInfo<'a> {
    vk::RenderingAttachmentInfo::default()
        .image_view(image.view())
        .image_layout(image.state.layout)
        .load_op(if clear.is_some() { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD })
        .store_op(vk::AttachmentStoreOp::STORE)
        .clear_value(clear.unwrap_or_default())
}
