//! A prepared shot that stays loaded while its file is edited.
//!
//! In: successive versions of a shot. Out: the same [`PreparedShot`] as if it were prepared anew, with as little work
//! as the edit requires: changed keys cost nothing, pins are attached again, layers are assigned again over the loaded
//! scene.

use crate::pipeline::evaluate::frame_cache::FrameCache;
use crate::pipeline::evaluate::topology::check_branching;
use crate::pipeline::prepare::attach_pins;
use crate::pipeline::prepare::{auto_dims, stiffness};
use crate::pipeline::{PipelineError, PreparedShot};
use crate::pose::pose;
use crate::raster::ChannelGroup;
use crate::scene::Scene;
use crate::shot::{BrushStroke, CameraRule, Cut, KeyLines, Layer, LayerSpace, Pin, Shot, Source, StiffnessRule};
use crate::solve::Settings;
use std::collections::BTreeSet;

/// A loaded shot that is being edited.
#[derive(Debug)]
pub(crate) struct OpenShot {
    /// The shot as given, before preparation fills in automatic settings.
    given: Shot,
    prepared: PreparedShot,
}

/// The amount of work that an edit caused, in increasing order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Rework {
    /// Nothing that affects frames.
    Nothing,
    /// Frames only: keys, strengths, samples.
    Frames,
    /// Stiffness was painted again.
    Stiffness,
    /// Pins were attached to the model again.
    Pins,
    /// Everything except loading the scene.
    Layers,
    /// The scene was loaded again.
    Scene,
}

impl OpenShot {
    /// Loads a shot.
    ///
    /// # Errors
    /// As [`PreparedShot::new`].
    pub(crate) fn new(shot: Shot) -> Result<Self, PipelineError> {
        Ok(Self { given: shot.clone(), prepared: PreparedShot::new(colour_only(shot))? })
    }

    /// Opens a shot whose scene was just loaded.
    ///
    /// # Errors
    /// As [`PreparedShot::new`].
    pub(crate) fn with_scene(shot: Shot, scene: Scene) -> Result<Self, PipelineError> {
        Ok(Self { given: shot.clone(), prepared: PreparedShot::with_own_scene(colour_only(shot), scene)? })
    }

    /// Returns the prepared shot, which renders colour only.
    #[must_use]
    pub(crate) const fn prepared(&self) -> &PreparedShot {
        &self.prepared
    }

    /// Returns the names of all nodes with meshes, in scene order, and whether the shot hides them.
    pub(crate) fn drawn_nodes(&self) -> impl Iterator<Item = (&str, bool)> {
        let hidden = &self.prepared.draw_inputs.hidden_nodes;
        let nodes = self.prepared.scene.nodes.iter().enumerate();
        nodes
            .filter(|(index, node)| node.mesh.is_some() || hidden.contains(index))
            .map(|(index, node)| (node.name.as_str(), hidden.contains(&index)))
    }

    /// Returns the shot as given last.
    #[must_use]
    pub(crate) const fn given(&self) -> &Shot {
        &self.given
    }

    /// Replaces the shot by an edited version. Layers that the edit does not change keep their trajectories.
    ///
    /// # Errors
    /// As [`PreparedShot::new`]; in that case nothing changes.
    pub(crate) fn edit(&mut self, shot: Shot) -> Result<Rework, PipelineError> {
        let rework = rework(&self.given, &shot);
        if matches!(rework, Rework::Frames | Rework::Stiffness | Rework::Pins) {
            // Orders come and go with pins and their keys.
            check_branching(&self.completed(&shot), &self.prepared.assignment)?;
        }
        match rework {
            Rework::Nothing => {}
            Rework::Frames => self.put_shot(&shot),
            Rework::Stiffness => self.repaint(&shot)?,
            Rework::Pins => {
                let old = (self.prepared.layer_inputs.stiffness.clone(), self.prepared.notes.clone());
                self.paint(&shot)?;
                if let Err(error) = self.reattach_pins(&shot) {
                    (self.prepared.layer_inputs.stiffness, self.prepared.notes) = old;
                    return Err(error);
                }
            }
            Rework::Layers => {
                let gallery = self.prepared.gallery.clone();
                let again = PreparedShot::with_scene(colour_only(shot.clone()), self.prepared.scene.clone())?;
                check_branching(&again.shot, &again.assignment)?;
                self.prepared = PreparedShot { gallery, ..again };
            }
            Rework::Scene => self.prepared = PreparedShot::new(colour_only(shot.clone()))?,
        }
        self.given = shot;
        // Pins that are attached again give their notes again.
        let mut known = BTreeSet::new();
        self.prepared.notes.retain(|note| known.insert(note.clone()));
        Ok(rework)
    }

    /// Returns a shot as it is prepared, over the same scene, camera and layers.
    fn completed(&self, shot: &Shot) -> Shot {
        let mut next = colour_only(shot.clone());
        if let CameraRule::Own(camera) = &self.prepared.shot.camera {
            next.camera = CameraRule::Own(camera.clone());
        }
        for (layer, known) in next.layers.iter_mut().zip(&self.prepared.shot.layers) {
            // Automatic dims and topologies were chosen when the shot was prepared.
            if layer.has_auto_dims {
                layer.space = known.space;
            }
            if layer.has_auto_topology {
                layer.settings.topology = known.settings.topology;
            }
        }
        next
    }

    /// Replaces the shot, keeping scene, layer assignment and pin anchors.
    fn put_shot(&mut self, shot: &Shot) {
        let next = self.completed(shot);
        let prepared = &mut self.prepared;
        let is_same = |index: usize| self.given.layers.get(index) == shot.layers.get(index);
        let is_world = |layer: &Layer| matches!(layer.space, LayerSpace::World { .. });
        // World layers move the meshes below screen layers.
        let is_scene_still = (0..shot.layers.len()).all(|index| is_same(index) || !is_world(&shot.layers[index]));
        let old = std::mem::take(&mut prepared.cache);
        let mut cache = FrameCache::default();
        (cache.world_bounds, cache.rest) = (old.world_bounds, old.rest);
        (cache.strokes, cache.mirrors, cache.slenderness) = (old.strokes, old.mirrors, old.slenderness);
        (cache.far_points, cache.plate_drafts) = (old.far_points, old.plate_drafts);
        if is_scene_still {
            (cache.screen_bounds, cache.picture_changes) = (old.screen_bounds, old.picture_changes);
        }
        if is_scene_still && is_time_same(&self.given, shot) {
            old.trajectories.retain(is_same);
            old.world_trajectories.retain(is_same);
            cache.trajectories = old.trajectories;
            cache.world_trajectories = old.world_trajectories;
        }
        (prepared.shot, prepared.cache) = (next, cache);
    }

    /// Replaces a shot in which the stiffness of layers changed.
    fn repaint(&mut self, shot: &Shot) -> Result<(), PipelineError> {
        self.paint(shot)?;
        self.put_shot(shot);
        Ok(())
    }

    /// Paints the stiffness of a shot with the same layers, unless it is as before.
    fn paint(&mut self, shot: &Shot) -> Result<(), PipelineError> {
        if painting(&self.given) == painting(shot) {
            return Ok(());
        }
        let prepared = &mut self.prepared;
        let inputs = (&prepared.assignment.parts_of_layer[..], &prepared.cache);
        let painted = stiffness::paint(shot, &prepared.scene, inputs)?;
        let old = std::mem::replace(&mut prepared.layer_inputs.stiffness, painted);
        prepared.notes.retain(|note| !old.notes.contains(note));
        prepared.notes.extend(prepared.layer_inputs.stiffness.notes.iter().cloned());
        Ok(())
    }

    /// Attaches the pins of the same layers again.
    fn reattach_pins(&mut self, shot: &Shot) -> Result<(), PipelineError> {
        let old_anchors = std::mem::take(&mut self.prepared.layer_inputs.anchors);
        let old_mirrored = self.prepared.layer_inputs.mirrored.clone();
        let old_shot = self.prepared.shot.clone();
        let old_notes = self.prepared.notes.len();
        self.put_shot(shot);
        let prepared = &mut self.prepared;
        let first = pose(&prepared.scene, prepared.clip, shot.frames.seconds(f64::from(shot.reference_frame())));
        if let Err(error) = attach_pins(prepared, &first) {
            prepared.layer_inputs.anchors = old_anchors;
            prepared.layer_inputs.mirrored = old_mirrored;
            prepared.shot = old_shot;
            prepared.cache = FrameCache::default();
            prepared.notes.truncate(old_notes);
            return Err(error);
        }
        auto_dims::choose(prepared);
        Ok(())
    }
}

/// Restricts the channels to colour, which is all that viewers show.
fn colour_only(mut shot: Shot) -> Shot {
    shot.output.channels = vec![ChannelGroup::Beauty];
    shot
}

/// Whether both shots are solved over the same range and show the same times.
fn is_time_same(old: &Shot, new: &Shot) -> bool {
    old.frames == new.frames && old.solve_range == new.solve_range && old.shutter == new.shutter
}

/// Determines what has to be done again.
fn rework(old: &Shot, new: &Shot) -> Rework {
    let without_lines = |shot: &Shot| Shot { lines: KeyLines::default(), ..shot.clone() };
    if without_lines(old) == without_lines(new) {
        return Rework::Nothing;
    }
    let has_same_source = old.source == new.source
        && old.visibility == new.visibility
        && old.allow_outside == new.allow_outside
        && old.size == new.size
        && old.path == new.path
        && (matches!(new.source, Source::Scene(_)) || cuts(old) == cuts(new));
    if !has_same_source {
        return Rework::Scene;
    }
    if structural_settings(old) != structural_settings(new) {
        return Rework::Layers;
    }
    let attachments = |shot: &Shot| -> Vec<Vec<_>> {
        let of_pin = |pin: &Pin| (pin.name.clone(), pin.anchor.clone(), pin.mirror);
        let of_layer = |layer: &Layer| layer.pins.iter().map(of_pin).collect();
        shot.layers.iter().map(of_layer).collect()
    };
    if attachments(old) != attachments(new) {
        Rework::Pins
    } else if painting(old) != painting(new) {
        Rework::Stiffness
    } else {
        Rework::Frames
    }
}

/// Returns the cuts of each layer, along which the meshes of pictures are divided.
fn cuts(shot: &Shot) -> Vec<&[Cut]> {
    shot.layers.iter().map(|layer| &layer.connectivity.cuts[..]).collect()
}

/// Returns what determines the stiffness of each layer.
fn painting(shot: &Shot) -> Vec<(&[StiffnessRule], &[BrushStroke])> {
    shot.layers.iter().map(|layer| (&layer.stiffness[..], &layer.strokes[..])).collect()
}

/// Reduces a shot to the settings on which preparation depends, except pins.
fn structural_settings(shot: &Shot) -> Shot {
    let mut shot = shot.clone();
    shot.lines = KeyLines::default();
    shot.output = crate::shot::Output { channels: Vec::new(), ..shot.output };
    (shot.samples, shot.shutter.angle, shot.shutter.phase, shot.exposure_stops) = (1, 0.0, 0.0, 0.0);
    // What holds for the whole shot is measured in the first frame of it.
    shot.solve_range[1] = shot.solve_range[0];
    for layer in &mut shot.layers {
        layer.pins.clear();
        layer.handles.clear();
        layer.stiffness.clear();
        layer.strokes.clear();
        (layer.strength, layer.is_muted, layer.step) = (1.0, false, 1);
        layer.settings = Settings { topology: layer.settings.topology, ..Settings::default() };
        if let LayerSpace::Screen { dims, .. } = &mut layer.space {
            *dims = [4, 4];
        }
    }
    shot
}
