//! Computes the silhouette of a shot's unwarped picture: where a map folds, transparent pixels must not hide visible ones.
//!
//! In: a [`PreparedShot`]. Out: the [`Coverage`] of a frame: of the model of a scene, or the alpha of pictures or of a plate.

use super::at_rest::SceneAtRest;
use crate::image::{Frame, SequencePath, read_any};
use crate::pipeline::{BranchView, Exposure, PipelineError, PreparedShot, SampleInMotion, fields_of};
use crate::plate::{Coverage, SharedParts, color_layers};
use crate::raster::{ChannelGroup, DeviceChoice};
use crate::space::FrameSize;

/// Coverage of parts that no layer moves: more than nothing, but below one half, at which a pixel counts as visible.
const UNCLAIMED: f32 = 0.25;

/// Computes silhouettes.
pub(crate) struct Silhouette<'a> {
    prepared: &'a PreparedShot,
    /// The only layer to include; `None`: all.
    layer: Option<usize>,
    scene: Option<SceneAtRest<'a>>,
}

impl<'a> Silhouette<'a> {
    /// Creates the silhouette of everything, or of one layer given by its name.
    #[must_use]
    pub(crate) fn of(prepared: &'a PreparedShot, layer: Option<&str>) -> Self {
        let layer = layer.and_then(|name| prepared.shot.layer_index(name));
        let scene = prepared.shot.scene().map(|_| SceneAtRest::new(prepared, &DeviceChoice::Cpu, Vec::new()));
        Self { prepared, layer, scene: scene.map(SceneAtRest::with_one_sample) }
    }

    /// Returns the coverage of a frame; `None` if nothing determines it.
    ///
    /// # Errors
    /// [`PipelineError`] if the scene cannot be drawn.
    pub(crate) fn at(&mut self, frame: i32) -> Result<Option<Coverage>, PipelineError> {
        let size = self.prepared.shot.size;
        if let Some(scene) = &mut self.scene {
            let (drawn, _) = scene.draw(frame, (size, &[ChannelGroup::Beauty, ChannelGroup::Id]))?;
            return Ok(of_render(&drawn, size, self.layer));
        }
        if let Some(gallery) = &self.prepared.gallery {
            let shown = |index: usize| {
                self.layer.is_none_or(|layer| self.prepared.assignment.layer_of_part[index] == Some(layer))
            };
            return Ok(Some(Coverage { frame: size, window: size.window(), samples: gallery.coverage(shown) }));
        }
        Ok(self.of_plate(frame))
    }

    /// Returns the branches of a layer at a frame's own time, from back to front: their fields and their shares of the
    /// unwarped picture, and the coverage of the whole layer. `None` if its lattice does not branch.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub(crate) fn branches(
        &self,
        frame: i32,
        (layer, size): (&str, FrameSize),
    ) -> Result<Option<SharedParts>, PipelineError> {
        let Some(index) = self.prepared.shot.layer_index(layer) else { return Ok(None) };
        let sample = self.prepared.sample_at(f64::from(frame))?;
        let view = BranchView { size, exposure: Exposure::Instant };
        let parts = self.prepared.branch_parts(index, SampleInMotion { now: &sample, around: None }, view);
        Ok(parts.and_then(fields_of))
    }

    /// Returns the alpha of the shot's plate, if the plate exists and has one.
    fn of_plate(&self, frame: i32) -> Option<Coverage> {
        let path = SequencePath::of_input(self.prepared.shot.plate.as_ref()?).ok()?.path_of(frame);
        let plate = read_any(&path).ok()?;
        let (layers, _) = color_layers(&plate, &self.prepared.shot.warp.semantics);
        let layer = layers.first()?;
        let samples = layer.channels[3]?.samples.clone();
        let coverage = Coverage { frame: plate.frame_size(), window: plate.window_of(layer.part), samples };
        coverage.samples.iter().any(|alpha| *alpha > 0.0).then_some(coverage)
    }
}

/// Converts a render to coverage: parts that layers move count fully, all others with [`UNCLAIMED`]; given a layer, only its
/// own parts count.
fn of_render(drawn: &Frame, size: FrameSize, layer: Option<usize>) -> Option<Coverage> {
    let ids = drawn.channel("id.layer")?;
    let share = |(alpha, id): (&f32, &f32)| {
        let own = layer.map_or(*id > 0.0, |layer| *id == layer as f32 + 1.0);
        match (own, layer) {
            (true, _) => alpha.clamp(0.0, 1.0),
            (false, None) => UNCLAIMED * alpha.clamp(0.0, 1.0),
            (false, Some(_)) => 0.0,
        }
    };
    let samples = drawn.channel("A")?.samples.iter().zip(&ids.samples).map(share).collect();
    Some(Coverage { frame: size, window: drawn.data_window, samples })
}
