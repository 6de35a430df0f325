//! Handles of lattices that are moved by hand: finding, dragging, typing and resetting.
//!
//! In: the selected handles. Out: their keys; document changes.

use super::Session;
use crate::edit::track::{Keying, box_sizes, handle_key_at, handle_moved, key_time, with_handle_key};
use crate::edit::track_keys::{Track, TrackKeys, axes_of};
use crate::pipeline::LayerMarks;
use crate::shot::edit::put_handle;
use crate::shot::{HandleKey, HandleTrack, LayerSpace, Shot};
use crate::space::ScreenPoint;
use glam::{DVec2, DVec3};

impl Session {
    /// Moves the selected handles of a shot on the screen; those of lattices in the scene at constant depth.
    pub(super) fn drag_handles(&self, shot: &mut Shot, base: &Shot, by: DVec2) {
        for &(layer, index) in &self.selection.handles {
            let owner = &base.layers[layer];
            let Some(by) = self.in_box(layer, index, by) else { continue };
            let time = key_time(&base.frames, owner, self.playhead.frame());
            let moved = handle_moved(base, (layer, index), Keying { time, auto: self.auto_key }, by.to_array());
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

    /// Returns the handles of a lattice that are in view, with their places.
    pub(crate) fn handles_in_view(
        &self,
        marks: &LayerMarks,
    ) -> impl Iterator<Item = ((usize, [usize; 3]), ScreenPoint)> {
        let layer = self.document.shot().layers.get(marks.layer);
        let [columns, rows, _] = layer.map_or([1; 3], |layer| layer.space.dims());
        let index = move |number: usize| [number % columns, number / columns % rows, number / columns / rows];
        let places = marks.handles.iter().enumerate();
        places.filter_map(move |(number, place)| Some(((marks.layer, index(number)), (*place)?)))
    }

    /// Returns the nearest visible handle.
    #[must_use]
    pub(crate) fn handle_near(&self, at: ScreenPoint, reach: f64) -> Option<(usize, [usize; 3])> {
        if !self.shown.shows_handles() {
            return None;
        }
        let far = |(_, place): &(_, ScreenPoint)| (*place - at).0.length();
        let handles = self.marks().iter().flat_map(|marks| self.handles_in_view(marks));
        let near = handles.filter(|handle| far(handle) <= reach).min_by(|a, b| far(a).total_cmp(&far(b)));
        near.map(|(handle, _)| handle)
    }

    /// Returns the visible handles with their places, without those of lattices whose dims follow their pins.
    pub(crate) fn movable_handles(&self) -> impl Iterator<Item = ((usize, [usize; 3]), ScreenPoint)> {
        let layers = &self.document.shot().layers;
        let can_move = |marks: &&LayerMarks| layers.get(marks.layer).is_some_and(|layer| !layer.has_auto_dims);
        let marks = self.marks().iter().filter(|_| self.shown.shows_handles());
        marks.filter(can_move).flat_map(|marks| self.handles_in_view(marks))
    }

    /// Returns the handles that can be moved whose places satisfy a condition.
    pub(super) fn handles_where(&self, holds: impl Fn(ScreenPoint) -> bool) -> Vec<(usize, [usize; 3])> {
        self.movable_handles().filter(|(_, place)| holds(*place)).map(|(handle, _)| handle).collect()
    }

    /// Returns the interpolated key of a handle at the current frame: its offset is in sizes of the lattice's box.
    #[must_use]
    pub(crate) fn handle_here(&self, at: (usize, [usize; 3])) -> Option<HandleKey> {
        let shot = self.shot();
        handle_key_at(shot, at, key_time(&shot.frames, shot.layers.get(at.0)?, self.playhead.frame()))
    }

    /// Sets a key of each selected handle with a typed offset along an axis, in sizes of the lattice's box.
    pub(crate) fn type_handles(&mut self, axis: usize, offset: f64) {
        let shot = self.document.shot();
        let typed = |&at: &(usize, [usize; 3])| {
            let owner = shot.layers.get(at.0)?;
            let mut key = handle_key_at(shot, at, key_time(&shot.frames, owner, self.playhead.frame()))?;
            *key.offset.get_mut(axis)? = (offset * 1e6).round() / 1e6;
            let track = owner.handles.iter().find(|track| track.index == at.1);
            let keys = with_handle_key(track, f64::from(shot.frames.first), key);
            Some((Track::Handle(at), TrackKeys::Handle(keys)))
        };
        let keys: Vec<_> = self.selection.handles.iter().filter_map(typed).collect();
        let series = format!("type {:?}", self.selection.handles);
        self.write_keys("Type key", &keys, Some(&series));
    }

    /// Puts the selected handles back to rest.
    pub(crate) fn reset_handles(&mut self) {
        let text = self.without_handles(self.document.text());
        let label = if self.selection.handles.len() == 1 { "Reset handle" } else { "Reset handles" };
        self.change(label, text, None);
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

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "scene = 'a.glb'\nframes = { first = 1, last = 24 }\n\
                        [[layer]]\nname = 'arm'\nlattice = { dims = [6, 6] }\n";

    /// A handle with the frames and offsets of its keys.
    type Offsets = ([usize; 3], Vec<(f64, [f64; 3])>);

    fn offsets(session: &Session) -> Vec<Offsets> {
        let handles = &session.document().shot().layers[0].handles;
        let keys = |track: &HandleTrack| track.keys.iter().map(|key| (key.frame, key.offset)).collect();
        handles.iter().map(|track| (track.index, keys(track))).collect()
    }

    #[test]
    fn typed_offsets_are_keyed_on_all_selected_handles_and_reset_at_once() {
        let mut session = Session::of_text(TEXT);
        let before = session.document().text().to_owned();
        session.selection.handles.extend([(0, [1, 2, 0]), (0, [4, 4, 0])]);
        session.go(9);
        for offset in [0.1, 0.125] {
            session.type_handles(1, offset);
        }
        let keys = vec![(1.0, [0.0; 3]), (9.0, [0.0, 0.125, 0.0])];
        assert_eq!(offsets(&session), [([1, 2, 0], keys.clone()), ([4, 4, 0], keys)]);
        session.go(5);
        let halfway = session.handle_here((0, [1, 2, 0])).expect("it is there");
        assert!(halfway.offset[1] > 0.0 && halfway.offset[1] < 0.125, "{halfway:?}");
        session.reset_handles();
        assert_eq!((session.document().text(), session.selection.handles.len()), (before.as_str(), 2));
        session.undo();
        session.undo();
        assert_eq!((session.document().text(), session.document().history().labels().count()), (before.as_str(), 0));
    }
}
