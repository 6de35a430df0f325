//! Editing of layers: order, names, lattices, strengths, mattes.
//!
//! In: user commands. Out: one document change each.

use super::{Purpose, Session};
use crate::edit::regrid::regridded;
use crate::edit::track_keys::axes_of;
use crate::plate::Matte;
use crate::shot::edit::{
    Setting, layer_number, move_layer, put_box, put_handle, put_layer_setting, remove_layer, rename_layer,
};
use crate::shot::{Layer, LayerSpace, Unmatted};
use crate::spelling::pluralised;

/// The part of a plate that a layer moves, as offered by the window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum MatteChoice {
    /// The layer's own nodes; without a scene, the whole picture.
    Usual,
    /// The layer's own nodes, even where it moves all of the scene.
    Nodes,
    /// The whole picture, background included.
    Picture,
    /// Everything with alpha.
    Alpha,
    /// The values of a channel.
    Channel(String),
    /// Names in a Cryptomatte.
    Cryptomatte(Vec<String>),
}

impl MatteChoice {
    /// Returns the choice that a layer's settings correspond to; `None` if the window does not offer it.
    #[must_use]
    pub(crate) fn of(layer: &Layer) -> Option<Self> {
        match (&layer.matte, layer.unmatted) {
            (None, Unmatted::OwnNodes) => Some(Self::Usual),
            (None, Unmatted::Nodes) => Some(Self::Nodes),
            (None, Unmatted::Picture) => Some(Self::Picture),
            (Some(Matte::Alpha), _) => Some(Self::Alpha),
            (Some(Matte::Channel(name)), _) => Some(Self::Channel(name.clone())),
            (Some(Matte::Cryptomatte { layer: None, names }), _) => Some(Self::Cryptomatte(names.clone())),
            (Some(_), _) => None,
        }
    }
}

impl Session {
    /// Sets a value of the selected layer. Consecutive changes with the same `series` are undone together.
    pub(crate) fn set_layer(&mut self, label: &str, key: &[&str], setting: &Setting, series: Option<&str>) {
        let Some(layer) = self.document.shot().layers.get(self.selection.layer) else { return };
        let text = put_layer_setting(self.document.text(), &layer.name, key, setting);
        let series = series.map(|series| format!("{series} of {}", layer.name));
        self.change(label, text, series.as_deref());
    }

    /// Renames a layer, with the pins that follow pins of it. It stays muted or soloed.
    pub(crate) fn rename_layer(&mut self, index: usize, name: &str) {
        let Some(layer) = self.document.shot().layers.get(index) else { return };
        let old = layer.name.clone();
        let text = rename_layer(self.document.text(), &old, name);
        let is_solo = self.is_solo(&old);
        if self.change("Rename layer", text, None) && is_solo {
            self.solo = Some(name.to_owned());
            self.frames_changed();
            self.refresh(Purpose::Look);
        }
    }

    /// Deletes the selected layer.
    pub(crate) fn delete_layer(&mut self) {
        let Some(layer) = self.document.shot().layers.get(self.selection.layer) else { return };
        let text = remove_layer(self.document.text(), &layer.name);
        let keys = layer.pins.iter().map(|pin| pin.key_frames().count()).sum::<usize>()
            + layer.handles.iter().map(|handle| handle.keys.len()).sum::<usize>();
        let (pins, keys) = (pluralised(layer.pins.len(), "pin", "pins"), pluralised(keys, "key", "keys"));
        let told = format!("Deleted: layer '{}' with {pins} and {keys}. Ctrl+Z brings it back.", layer.name);
        self.selection.clear();
        if self.change("Delete layer", text, None) {
            self.say(told);
        }
    }

    /// Moves the selected layer up or down in the list.
    pub(crate) fn move_layer(&mut self, by: isize) {
        let from = self.selection.layer;
        let Some(to) = from.checked_add_signed(by) else { return };
        let layers = &self.document.shot().layers;
        let Some(layer) = layers.get(from).filter(|_| to < layers.len()) else { return };
        let text = move_layer(self.document.text(), &layer.name, to);
        self.selection.clear();
        if self.change("Move layer", text, None) {
            self.selection.layer = to;
        }
    }

    /// Changes the dims of the selected layer's lattice. Pins preserve the edit; manually moved handles are transferred
    /// to the nearest new handles.
    pub(crate) fn set_dims(&mut self, dims: &[usize]) {
        let Some(layer) = self.document.shot().layers.get(self.selection.layer).cloned() else { return };
        let tracks = match (layer.space, dims) {
            (LayerSpace::Screen { dims: old, .. }, &[columns, rows]) => {
                regridded(&layer.handles, layer.basis, (old, [columns, rows]))
            }
            (LayerSpace::World { dims: old, .. }, &[x, y, z]) => {
                regridded(&layer.handles, layer.basis, (old, [x, y, z]))
            }
            (LayerSpace::World { .. }, _) => return self.say("A lattice in the scene has three dims."),
            (LayerSpace::Screen { .. }, _) => return self.say("A lattice on the screen has two dims."),
        };
        let mut text = Ok(self.document.text().to_owned());
        for track in &layer.handles {
            let index = axes_of(layer.space, &track.index);
            text = text.and_then(|text| put_handle(&text, &layer.name, index, &[]));
        }
        let setting = Setting::Wholes(dims.iter().map(|&count| count as i64).collect());
        text = text.and_then(|text| put_layer_setting(&text, &layer.name, &["lattice", "dims"], &setting));
        for track in tracks {
            let index = axes_of(layer.space, &track.index);
            text = text.and_then(|text| put_handle(&text, &layer.name, index, &track.keys));
        }
        self.selection.handles.clear();
        // Resizes are not merged when handles were moved: handles that coincide in an intermediate size would be lost.
        let series = layer.handles.is_empty().then(|| format!("dims {}", layer.name));
        self.change("Resize lattice", text, series.as_deref());
    }

    /// Fixes the box of the selected layer's lattice at these corners, as in the file.
    pub(crate) fn set_box(&mut self, corners: &[f64]) {
        let Some(layer) = self.document.shot().layers.get(self.selection.layer) else { return };
        // A fixed box in the scene has the scene's axes.
        let upright = match layer.space {
            LayerSpace::Screen { .. } => Ok(self.document.text().to_owned()),
            LayerSpace::World { .. } => {
                put_layer_setting(self.document.text(), &layer.name, &["lattice", "frame"], &Setting::Default)
            }
        };
        let text = upright.and_then(|text| put_box(&text, &layer.name, corners));
        let series = format!("box of {}", layer.name);
        self.change("Change box", text, Some(&series));
    }

    /// Sets the patterns of node names that the selected layer moves; none: all nodes.
    pub(crate) fn set_nodes(&mut self, nodes: Vec<String>) {
        let setting = if nodes.is_empty() { Setting::Default } else { Setting::Texts(nodes) };
        self.set_layer("Change nodes", &["nodes"], &setting, None);
    }

    /// Sets the part of a plate that the selected layer moves.
    pub(crate) fn set_matte(&mut self, matte: &MatteChoice) {
        let Some(layer) = self.document.shot().layers.get(self.selection.layer) else { return };
        let put = |text: &str, key: &[&str], setting: &Setting| put_layer_setting(text, &layer.name, key, setting);
        let named = |text: &str, name: &str| put(text, &["matte"], &Setting::Text(name.to_owned()));
        let mut text = put(self.document.text(), &["matte"], &Setting::Default);
        text = match matte {
            MatteChoice::Usual => text,
            MatteChoice::Nodes => text.and_then(|text| named(&text, "nodes")),
            MatteChoice::Picture => text.and_then(|text| named(&text, "none")),
            MatteChoice::Alpha => text.and_then(|text| named(&text, "alpha")),
            MatteChoice::Channel(name) => {
                text.and_then(|text| put(&text, &["matte", "channel"], &Setting::Text(name.clone())))
            }
            MatteChoice::Cryptomatte(names) => {
                text.and_then(|text| put(&text, &["matte", "cryptomatte"], &Setting::Texts(names.clone())))
            }
        };
        let series = format!("matte {}", layer.name);
        self.change("Change matte", text, Some(&series));
    }

    /// Returns the soloed layer: the picture then lacks what renders have.
    #[must_use]
    pub(crate) fn solo(&self) -> Option<&str> {
        self.solo.as_deref()
    }

    /// Returns whether a layer acts in the editor: it is neither muted nor beside a soloed one.
    #[must_use]
    pub(crate) fn is_heard(&self, layer: usize) -> bool {
        let layer = self.shot().layers.get(layer);
        layer.is_none_or(|layer| !layer.is_muted && self.solo().is_none_or(|solo| solo == layer.name))
    }

    /// Forgets a soloed layer that does not exist.
    pub(super) fn forget_missing_layers(&mut self) {
        let layers = &self.document.shot().layers;
        let is_there = |name: &String| layers.iter().any(|layer| layer.name == *name);
        self.solo = self.solo.take().filter(is_there);
    }

    /// Returns whether a layer is soloed.
    #[must_use]
    pub(crate) fn is_solo(&self, name: &str) -> bool {
        self.solo.as_deref() == Some(name)
    }

    /// Mutes or unmutes a layer, also in the file and in renders.
    pub(crate) fn toggle_mute(&mut self, name: &str) {
        let Some(layer) = self.document.shot().layers.iter().find(|layer| layer.name == name) else { return };
        let (setting, label) = match layer.is_muted {
            true => (Setting::Default, "Unmute layer"),
            false => (Setting::Flag(true), "Mute layer"),
        };
        let text = put_layer_setting(self.document.text(), name, &["mute"], &setting);
        self.change(label, text, None);
    }

    /// Soloes or unsoloes a layer in the editor; the file is not changed.
    pub(crate) fn toggle_solo(&mut self, name: &str) {
        self.solo = if self.is_solo(name) { None } else { Some(name.to_owned()) };
        self.frames_changed();
        self.refresh(Purpose::Look);
    }
}

impl Session {
    /// Returns the layer's strength from the file, without the shot's.
    #[must_use]
    pub(crate) fn own_strength(&self, layer: usize) -> f64 {
        self.number_in_file(layer, &["strength"]).unwrap_or(1.0)
    }

    /// Returns the layer's smoothness from the file.
    #[must_use]
    pub(crate) fn own_smoothness(&self, layer: usize) -> f64 {
        self.number_in_file(layer, &["solve", "smoothness"]).unwrap_or(1.0)
    }

    fn number_in_file(&self, layer: usize, key: &[&str]) -> Option<f64> {
        let layer = self.document.shot().layers.get(layer)?;
        layer_number(self.document.text(), &layer.name, key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shot::BoxRule;
    use crate::space::ScreenPoint;

    const TEXT: &str = "scene = 'a.glb'\nframes = { first = 1, last = 24 }\n\
                        [[layer]]\nname = 'arm'\n[[layer]]\nname = 'leg'\n";

    #[test]
    fn a_box_is_fixed_by_its_corners() {
        let mut session =
            Session::of_text(&TEXT.replace("'leg'", "'leg' # left\nlattice = { box = \"follow\" } # it\n"));
        session.selection.layer = 1;
        session.set_box(&[0.25, 0.0, 1.0, 0.5]);
        let LayerSpace::Screen { bounds: BoxRule::Fixed(found), .. } = session.shot().layers[1].space else {
            panic!("{}", session.document().text())
        };
        assert_eq!((found.min, found.max), (ScreenPoint::new(0.25, 0.0), ScreenPoint::new(1.0, 0.5)));
        assert!(session.document().text().contains("{ box = { fixed = [0.25, 0.0, 1.0, 0.5] } } # it"));
        // A box without extent is told, and changes nothing.
        session.set_box(&[1.0, 0.0, 1.0, 0.5]);
        assert!(session.message().is_some_and(|told| told.contains("box")), "{:?}", session.message());
        session.undo();
        assert!(session.document().text().contains("{ box = \"follow\" } # it"));
    }

    #[test]
    fn renamed_layers_stay_muted_and_deleted_ones_silence_nothing() {
        let mut session = Session::of_text(TEXT);
        session.toggle_solo("arm");
        session.toggle_mute("arm");
        session.rename_layer(0, "hand");
        assert!(session.is_solo("hand") && session.shot().layers[0].is_muted && !session.shot().layers[1].is_muted);
        session.delete_layer();
        assert_eq!(session.shot().layers.len(), 1);
        assert_eq!(session.solo(), None);
    }
}
