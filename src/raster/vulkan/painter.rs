//! Draws of one kind into a rendering.
//!
//! In: draws in order. Out: recorded state changes, only where state changes, and draws.

use super::commands::Commands;
use super::materials::Materials;
use super::memory::Buffer;
use super::pass::View;
use super::pipeline::{Key, Pipelines, Stage};
use super::rendering::{Faces, Rendering};
use super::upload::MeshPlace;
use crate::raster::{Draw, RasterError};
use ash::vk;

/// All that draws need besides the attachments.
pub(super) struct Painter<'a> {
    pub(super) commands: &'a Commands,
    /// Holds the mesh.
    pub(super) buffer: &'a Buffer,
    pub(super) place: MeshPlace,
    pub(super) pass_set: vk::DescriptorSet,
    pub(super) pipelines: &'a Pipelines,
    pub(super) materials: &'a Materials,
    pub(super) view: View,
    pub(super) extent: vk::Extent2D,
}

impl Painter<'_> {
    /// Draws in the order given; all pipelines are prepared.
    pub(super) fn paint(&self, rendering: &Rendering, stage: Stage, draws: &[&Draw]) -> Result<(), RasterError> {
        if draws.is_empty() {
            return Ok(());
        }
        let layout = &self.pipelines.geometry_layout;
        rendering.bind_mesh(self.buffer, self.place.vertices, self.place.indices);
        rendering.bind_set(layout, 0, self.pass_set);
        let (mut key, mut set, mut faces) = (Last::new(), Last::new(), Last::new());
        for draw in draws {
            let look = self.materials.look(draw.material)?;
            if let Some(key) = key.change(Key { stage, alpha: look.alpha, textures: look.textures }) {
                rendering.bind_pipeline(self.pipelines.geometry(key)?);
            }
            if let Some(set) = set.change(look.set) {
                rendering.bind_set(layout, 1, set);
            }
            if let Some(faces) = faces.change(shown_faces(draw, look.is_double_sided)) {
                rendering.set_faces(faces);
            }
            rendering.push(layout, bytemuck::bytes_of(&self.view.of_draw(draw)));
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

/// Remembers what was set last.
struct Last<T>(Option<T>);

impl<T: Copy + PartialEq> Last<T> {
    const fn new() -> Self {
        Self(None)
    }

    /// The value, where it is another than before.
    fn change(&mut self, value: T) -> Option<T> {
        (self.0.replace(value) != Some(value)).then_some(value)
    }
}
