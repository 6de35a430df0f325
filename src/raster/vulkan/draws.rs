//! Records the draws of a pass in one rendering.
//!
//! In: draws in order, an uploaded mesh. Out: recorded draws, with state set only where it changes.

use super::commands::Commands;
use super::materials::Materials;
use super::memory::Buffer;
use super::pipeline::{Key, PUSH_BYTES, Pipelines, Stage};
use super::rendering::{Faces, Rendering};
use super::upload::MeshRange;
use crate::raster::{Draw, RasterError};
use ash::vk;
use bytemuck::{Pod, Zeroable};

/// `Push` of geometry.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Push {
    pixels_from_screen: [f32; 2],
    ids: [f32; 2],
}

const _: () = assert!(size_of::<Push>() == PUSH_BYTES as usize);

/// The inputs of draws besides the attachments.
pub(super) struct DrawContext<'a> {
    pub(super) commands: &'a Commands,
    /// The buffer that holds the mesh.
    pub(super) buffer: &'a Buffer,
    pub(super) mesh: MeshRange,
    pub(super) pass_set: vk::DescriptorSet,
    pub(super) pipelines: &'a Pipelines,
    pub(super) materials: &'a Materials,
    /// Pixels per frame height, across and up.
    pub(super) pixels_from_screen: [f32; 2],
    pub(super) extent: vk::Extent2D,
}

impl DrawContext<'_> {
    /// Records draws in the given order; all pipelines must be prepared.
    pub(super) fn draw(&self, rendering: &Rendering, stage: Stage, draws: &[&Draw]) -> Result<(), RasterError> {
        if draws.is_empty() {
            return Ok(());
        }
        let layout = &self.pipelines.geometry_layout;
        rendering.bind_mesh(self.buffer, self.mesh);
        rendering.bind_set(layout, 0, self.pass_set);
        let (mut key, mut set, mut faces) = (BoundState::new(), BoundState::new(), BoundState::new());
        for draw in draws {
            let state = self.materials.state(draw.material)?;
            if let Some(key) = key.change(Key { stage, variant: state.variant }) {
                rendering.bind_pipeline(self.pipelines.geometry(key)?);
            }
            if let Some(set) = set.change(state.set) {
                rendering.bind_set(layout, 1, set);
            }
            if let Some(faces) = faces.change(shown_faces(draw, state.is_double_sided)) {
                rendering.set_faces(faces);
            }
            let ids = [draw.layer_id as f32, draw.object_id as f32];
            let push = Push { pixels_from_screen: self.pixels_from_screen, ids };
            rendering.push(layout, bytemuck::bytes_of(&push));
            rendering.draw_indexed(draw.indices.clone());
        }
        Ok(())
    }
}

fn shown_faces(draw: &Draw, is_double_sided: bool) -> Faces {
    match (is_double_sided, draw.is_mirrored) {
        (true, false) => Faces::All,
        (true, true) => Faces::AllMirrored,
        (false, false) => Faces::CounterClockwise,
        (false, true) => Faces::Clockwise,
    }
}

/// The currently bound value.
struct BoundState<T>(Option<T>);

impl<T: Copy + PartialEq> BoundState<T> {
    const fn new() -> Self {
        Self(None)
    }

    /// Returns the value if it differs from the bound one.
    fn change(&mut self, value: T) -> Option<T> {
        (self.0.replace(value) != Some(value)).then_some(value)
    }
}
