//! Handles of lattices that are moved by hand: dragging and resetting.
//!
//! In: the selected handles. Out: their keys; document changes.

use super::Session;
use crate::edit::track::{box_sizes, handle_moved, key_time};
use crate::edit::track_keys::axes_of;
use crate::shot::edit::put_handle;
use crate::shot::{HandleTrack, LayerSpace, Shot};
use glam::{DVec2, DVec3};

impl Session {
    /// Moves the selected handles of a shot on the screen; those of lattices in the scene at constant depth.
    pub(super) fn drag_handles(&self, shot: &mut Shot, base: &Shot, by: DVec2) {
        for &(layer, index) in &self.selection.handles {
            let owner = &base.layers[layer];
            let Some(by) = self.in_box(layer, index, by) else { continue };
            let time = key_time(&base.frames, owner, self.playhead.frame());
            let moved = handle_moved(base, (layer, index), (time, self.auto_key), by.to_array());
            let Some(keys) = moved else { continue };
            let handles = &mut shot.layers[layer].handles;
            match handles.iter_mut().find(|track| track.index == index) {
                Some(track) => track.keys = keys,
                None => handles.push(HandleTrack { index, keys }),
            }
        }
    }

    /// Converts a movement of a handle on the screen to sizes of its lattice's box; `None` if the handle is not seen.
    fn in_box(&self, layer: usize, index: [usize; 3], by: DVec2) -> Option<DVec3> {
        let marks = self.marks_of(layer)?;
        let space = self.document.shot().layers.get(layer)?.space;
        if let LayerSpace::Screen { .. } = space {
            return Some(box_sizes(marks.rest_box?, by).extend(0.0));
        }
        let [columns, rows, _] = space.dims();
        let steps = marks.handle_steps.get(index[0] + columns * (index[1] + rows * index[2]))?;
        Some(steps[0] * by.x + steps[1] * by.y)
    }

    /// Puts the selected handles back to rest, with all their keys.
    pub(super) fn without_handles(&self, text: &str) -> Result<String, crate::shot::ShotError> {
        let mut text = Ok(text.to_owned());
        for &(layer, index) in &self.selection.handles {
            let Some(owner) = self.document.shot().layers.get(layer) else { continue };
            text = text.and_then(|text| put_handle(&text, &owner.name, axes_of(owner.space, &index), &[]));
        }
        text
    }
}
