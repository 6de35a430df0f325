//! A frame drawn once with some layers at rest, whose pictures are then warped again and again: scenes that take long to draw
//! follow the pointer that way.
//!
//! In: a solved time and the layers that move. Out: frames in which these layers are warped as pictures, and lie before or behind
//! everything else by their depth. Surfaces that a layer hides at rest stay hidden, so these frames are provisional.

use super::still::Device;
use crate::image::{EMPTY_DEPTH, Frame, Plate};
use crate::pipeline::draw::geometry_thread::geometry_of;
use crate::pipeline::{LayerState, PipelineError, PreparedShot, TimeSample};
use crate::plate::{Filter, LayerJob, Matte, PlateJob, WarpSettings, warp_plate};
use crate::raster::{ChannelGroup, Geometry, Pass, PassRole, RasterError, Target};
use crate::shot::LayerSpace;
use crate::space::FrameSize;
use glam::Vec2;

/// The channels of the pictures: colour, alpha, depth.
const CHANNELS: [ChannelGroup; 2] = [ChannelGroup::Beauty, ChannelGroup::Depth];

/// A frame as layers of pictures.
#[derive(Debug)]
pub(crate) struct WarpedStill {
    /// All that does not move.
    still: Frame,
    /// Moving layers at rest, with their indices.
    moving: Vec<(usize, Plate)>,
}

impl PreparedShot {
    /// Draws a solved time with some layers at rest, each as a picture of its own; `None` if one of them cannot be warped as a
    /// picture, because its lattice lies in the scene or branches.
    ///
    /// # Errors
    /// [`PipelineError`] if drawing fails.
    pub(crate) fn warped_still(
        &self,
        device: &mut Device,
        (sample, layers): (&mut TimeSample, &[usize]),
        size: FrameSize,
    ) -> Result<Option<WarpedStill>, PipelineError> {
        let is_flat = |&layer: &usize| matches!(self.shot.layers[layer].space, LayerSpace::Screen { .. });
        if !layers.iter().all(|layer| is_flat(layer) && !branches(&sample.layers[*layer])) {
            return Ok(None);
        }
        let moved: Vec<LayerState> = layers.iter().map(|&layer| std::mem::take(&mut sample.layers[layer])).collect();
        let mut geometry = geometry_of(self, sample, None);
        layers.iter().zip(moved).for_each(|(&layer, state)| sample.layers[layer] = state);
        let draws = std::mem::take(&mut geometry.draws);
        let mut drawn = |is_drawn: &dyn Fn(usize) -> bool| {
            // Layer ids count from 1.
            let chosen = draws.iter().filter(|draw| is_drawn((draw.layer_id as usize).wrapping_sub(1)));
            geometry.draws = chosen.cloned().collect();
            draw(device, &geometry, size)
        };
        let still = drawn(&|layer| !layers.contains(&layer))?;
        let moving = layers.iter().map(|&moving| Ok((moving, Plate::from_frame(drawn(&|layer| layer == moving)?))));
        Ok(Some(WarpedStill { still, moving: moving.collect::<Result<_, RasterError>>()? }))
    }
}

fn branches(state: &LayerState) -> bool {
    state.solution.as_ref().is_some_and(|solution| solution.branches.is_some())
}

fn draw(device: &mut Device, geometry: &Geometry, size: FrameSize) -> Result<Frame, RasterError> {
    device.start(&Target { frame: size, window: size.window(), channels: CHANNELS.into(), beauty_passes: 1 })?;
    device.draw(&Pass { geometry, jitter_px: Vec2::ZERO, role: PassRole::BeautyAndData })?;
    device.finish()
}

impl WarpedStill {
    /// Returns the frame with the moving layers as in a sample; `None` if one of them branches there.
    pub(crate) fn warped(&self, sample: &TimeSample) -> Option<Frame> {
        let mut canvas = self.still.clone();
        for (layer, plate) in &self.moving {
            let state = &sample.layers[*layer];
            if branches(state) {
                return None;
            }
            let settings = WarpSettings { filter: Filter::Cubic, ..WarpSettings::default() };
            let picture = match state.field(false) {
                None => plate.clone(),
                Some(field) => {
                    let moved = LayerJob {
                        name: String::new(),
                        field,
                        previous: None,
                        next: None,
                        matte: Some(Matte::Alpha),
                        front: None,
                    };
                    warp_plate(plate, &PlateJob { layers: vec![moved], settings: &settings, fill: None }).ok()?.0
                }
            };
            composite_by_depth(&mut canvas, &picture.into_frame());
        }
        Some(canvas)
    }
}

/// Composites a picture, each pixel over or under what is there. Soft edges without a depth lie in front.
fn composite_by_depth(canvas: &mut Frame, picture: &Frame) {
    for [to, from] in canvas.data_window.shared_rows(picture.data_window) {
        for (at, sample) in to.zip(from) {
            let [own, other] = [picture.channels[3].samples[sample], canvas.channels[3].samples[at]];
            let [depth, known] = [picture.channels[4].samples[sample], canvas.channels[4].samples[at]];
            let is_in_front = depth <= known || depth == EMPTY_DEPTH;
            let [through, share] = if is_in_front { [1.0 - own.clamp(0.0, 1.0), 1.0] } else { [1.0, 1.0 - other] };
            for (behind, front) in canvas.channels[..4].iter_mut().zip(&picture.channels[..4]) {
                behind.samples[at] = behind.samples[at] * through + front.samples[sample] * share;
            }
            if own > 0.0 {
                canvas.channels[4].samples[at] = known.min(depth);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::Draft;
    use crate::raster::geometry::KeptParts;
    use crate::raster::{DeviceChoice, open};
    use crate::shot::Shot;
    use std::path::Path;

    /// Mean difference of colour between two frames of one size.
    fn difference(a: &Frame, b: &Frame) -> f32 {
        let planes = a.channels[..4].iter().zip(&b.channels[..4]);
        let of_plane = |(a, b): (&[f32], &[f32])| a.iter().zip(b).map(|(a, b)| (a.min(1.0) - b.min(1.0)).abs()).sum();
        let sums: f32 = planes.map(|(a, b)| -> f32 { of_plane((&a.samples, &b.samples)) }).sum();
        sums / (4 * a.channels[0].samples.len()) as f32
    }

    #[test]
    fn a_warped_still_shows_what_is_drawn() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker/shot.toml");
        let prepared = PreparedShot::new(Shot::read(&path).expect("a bundled shot")).expect("its scene");
        let mut device = open(&DeviceChoice::Cpu, &prepared.scene).expect("the CPU draws").0;
        let size = FrameSize { width: 480, height: 270, ..prepared.shot.size };
        let mut sample = prepared.provisional(7).expect("solvable");
        let moved = |sample: &TimeSample| sample.layers.iter().filter(|state| state.solution.is_some()).count();
        assert_eq!(moved(&sample), 3, "all layers move in this frame");
        let still = prepared.warped_still(&mut *device, (&mut sample, &[0, 1]), size).expect("drawn").expect("flat");
        let warped = still.warped(&sample).expect("plain");
        let kept = KeptParts::default();
        let drawn = prepared
            .draft(Some(&mut *device), Draft { sample: &sample, kept: &kept, size }, &|| false)
            .expect("drawn")
            .expect("wanted");
        let mut resting = sample.clone();
        resting.layers[0] = LayerState::default();
        let rest = still.warped(&resting).expect("plain");
        let [same, other] = [difference(&warped, &drawn), difference(&rest, &drawn)];
        println!("mean difference: warped {same:.5}, with one layer at rest {other:.5}");
        assert!(same < 0.004 && other > 2.0 * same, "{same} {other}");
    }
}
