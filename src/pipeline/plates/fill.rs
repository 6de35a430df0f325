//! What the scene of a shot shows where a layer of a plate has moved away.
//!
//! In: a shot with a scene, the layers that have a matte. Out: the unwarped scene of a frame, drawn without them.

use super::super::{PipelineError, PreparedShot};
use super::at_rest::SceneAtRest;
use crate::image::Plate;
use crate::plate::{WarpSettings, has_cryptomattes};
use crate::raster::geometry::Piece;
use crate::raster::{ChannelGroup, DeviceChoice};

/// Draws what lies behind.
pub(super) struct Filler<'a>(SceneAtRest<'a>);

impl<'a> Filler<'a> {
    /// `None` where no layer has a matte, or nothing would be left to draw.
    pub(super) fn of(prepared: &'a PreparedShot, device: &'a DeviceChoice, layers: &[usize]) -> Option<Self> {
        let has_matte =
            |&&layer: &&usize| prepared.shot.layers[layer].matte.is_some() || prepared.moves_own_nodes(layer);
        let hidden: Vec<usize> = layers.iter().filter(has_matte).copied().collect();
        let pieces = || prepared.draw_inputs.pieces.iter().flatten();
        let is_hidden = |piece: &Piece| hidden.iter().any(|&layer| piece.layer_id == layer as u32 + 1);
        if !pieces().any(is_hidden) || pieces().all(is_hidden) {
            return None;
        }
        // Layers that are left bend the whole picture, and this with it.
        Some(Self(SceneAtRest::new(prepared, device, hidden)))
    }

    /// The unwarped frame without what has a matte, in pixels of a plate; it says of itself what a render says.
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
