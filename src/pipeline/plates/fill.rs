//! Renders what lies behind the layers of a plate that have moved away.
//!
//! In: a shot with a scene, and the layers with mattes. Out: the unwarped scene of a frame without those layers.

use super::at_rest::SceneAtRest;
use crate::image::Plate;
use crate::pipeline::{PipelineError, PreparedShot};
use crate::plate::{WarpSettings, has_cryptomattes};
use crate::raster::geometry::Submesh;
use crate::raster::{ChannelGroup, DeviceChoice};

/// Renders the background of matted layers.
pub(super) struct Filler<'a>(SceneAtRest<'a>);

impl<'a> Filler<'a> {
    /// Creates the renderer; `None` if no layer has a matte, or nothing would be left to draw.
    pub(super) fn of(prepared: &'a PreparedShot, device: &'a DeviceChoice, layers: &[usize]) -> Option<Self> {
        let has_matte =
            |&&layer: &&usize| prepared.shot.layers[layer].matte.is_some() || prepared.moves_own_nodes(layer);
        let hidden: Vec<usize> = layers.iter().filter(has_matte).copied().collect();
        let submeshes = || prepared.draw_inputs.submeshes.iter().flatten();
        let is_hidden = |submesh: &Submesh| hidden.iter().any(|&layer| submesh.layer_id == layer as u32 + 1);
        if !submeshes().any(is_hidden) || submeshes().all(is_hidden) {
            return None;
        }
        // The other layers bend the whole picture, including this background.
        Some(Self(SceneAtRest::new(prepared, device, hidden)))
    }

    /// Renders the unwarped frame without matted layers, at the size of a plate, with the metadata of a render.
    pub(super) fn draw(
        &mut self,
        frame: i32,
        (plate, settings): (&Plate, &WarpSettings),
    ) -> Result<Plate, PipelineError> {
        let mut channels = ChannelGroup::PLANAR.to_vec();
        channels.extend(has_cryptomattes(plate, settings).then_some(ChannelGroup::Cryptomatte));
        let (drawn, metadata) = self.0.draw(frame, (plate.frame_size(), &channels))?;
        Ok(Plate::from_render(drawn, &metadata))
    }
}
