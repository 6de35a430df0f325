//! What a solved frame does to points of a layer: where the warp moves them, how it turns and scales what surrounds them.
//!
//! In: a prepared shot, a solved [`TimeSample`]. Out: displacements on the screen, angles, scales.

use crate::pipeline::{PickedPoint, PinAnchor, PipelineError, PreparedShot, TimeSample};
use crate::plate::Field;
use crate::raster::geometry::PartPoint;
use crate::shot::{LayerSpace, Source};
use crate::space::{ScreenPoint, ScreenVector};
use glam::DVec2;
use std::sync::Arc;

/// Half the distance over which the gradient of a warp is measured, frame heights.
const STEP: f64 = 1e-4;

/// How the warp turns and scales what surrounds a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PinTurn {
    /// Index of the pin in its layer.
    pub pin: usize,
    /// Rotation in radians, counter-clockwise.
    pub angle: f64,
    /// Scale factor.
    pub scale: f64,
}

impl PreparedShot {
    /// Returns a frame in which one layer is solved: as it is rendered if the range is solved over time, else that frame alone.
    ///
    /// # Errors
    /// [`PipelineError`] if the layer cannot be solved.
    pub(crate) fn sample_of_layer(&self, frame: i32, layer: usize) -> Result<Arc<TimeSample>, PipelineError> {
        if self.is_settled() {
            return self.mid_exposure(frame);
        }
        let all: Vec<usize> = (0..self.shot.layers.len()).collect();
        let mut sample = self.provisional_without(frame, &all)?;
        sample.layers[layer] = self.provisional_layer(&sample, layer)?;
        Ok(Arc::new(sample))
    }

    /// Returns by how much a layer on the screen displaces a picked point in a solved frame; `None` if the camera does not see it, and for
    /// layers in the scene.
    #[must_use]
    pub(crate) fn displacement(&self, sample: &TimeSample, point: &PickedPoint) -> Option<ScreenVector> {
        let anchor = match self.shot.source {
            Source::Frame => PinAnchor::Screen(point.rest),
            Source::Scene(_) | Source::Images(_) => PinAnchor::on(&self.scene, &sample.pose, &point.hit),
        };
        let layer = point.layer.filter(|&layer| self.is_on_screen(layer))?;
        let rest = anchor.rest(&sample.mesh(), &sample.camera);
        (rest.presence > 0.0).then(|| warped(sample, layer, &anchor, rest.point) - rest.point)
    }

    /// Returns how a layer on the screen turns and scales what surrounds its pins in a solved frame; none for layers in the scene.
    #[must_use]
    pub(crate) fn pin_turns(&self, sample: &TimeSample, layer: usize) -> Vec<PinTurn> {
        if !self.is_on_screen(layer) {
            return Vec::new();
        }
        let (mesh, anchors) = (sample.mesh(), self.anchors_of(layer));
        let turn = |(pin, anchor): (usize, &PinAnchor)| {
            let rest = anchor.rest(&mesh, &sample.camera);
            let image = |by: DVec2| warped(sample, layer, anchor, ScreenPoint(rest.point.0 + by)).0;
            let along = |axis: DVec2| (image(axis * STEP) - image(axis * -STEP)) / (2.0 * STEP);
            let (x, y) = (along(DVec2::X), along(DVec2::Y));
            // The rotation and scale nearest to the gradient, whose columns are x and y.
            let turned = DVec2::new(x.x + y.y, x.y - y.x) / 2.0;
            (rest.presence > 0.0).then(|| PinTurn { pin, angle: turned.to_angle(), scale: turned.length() })
        };
        anchors.iter().enumerate().filter_map(turn).collect()
    }

    fn is_on_screen(&self, layer: usize) -> bool {
        self.shot.layers.get(layer).is_some_and(|layer| matches!(layer.space, LayerSpace::Screen { .. }))
    }
}

/// Warps a point of the screen that lies on the surface of an anchor.
fn warped(sample: &TimeSample, layer: usize, anchor: &PinAnchor, point: ScreenPoint) -> ScreenPoint {
    let state = &sample.layers[layer];
    match *anchor {
        PinAnchor::Surface { part, triangle, .. } => {
            state.part_warp(part).warp(point, PartPoint { weights: &[], triangle: triangle as u32 })
        }
        PinAnchor::Screen(_) => match (&state.whole, &state.solution) {
            (Some(whole), _) => Field::of_whole(whole).carry(point),
            (None, Some(solution)) => solution.lattice.warp(point),
            (None, None) => point,
        },
    }
}
