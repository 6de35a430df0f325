//! Adds layers: where they work, with the lattice of new shots and with the pins that lie on what they take.
//!
//! In: offers of the worker. Out: one document change, and what it did to the pose.

use super::Session;
use crate::pipeline::LayerOffer;
use crate::shot::edit::{PinName, Setting, add_layer, layer_number, move_layer, move_pin, put_layer_setting};
use crate::shot::{Shot, ShotError, Source};
use crate::spelling::pluralised;

impl Session {
    /// Adds a layer at its place, and selects it. Pins that lie on what it takes from other layers come along.
    pub(crate) fn add_layer(&mut self, offer: &LayerOffer) {
        let Ok(place) = offer.place else { return };
        let shot = self.document.shot();
        let nodes: Vec<String> = offer.node.iter().cloned().collect();
        let name = free_name(shot, offer.node.as_deref().unwrap_or("layer"));
        let place = place.min(shot.layers.len());
        let is_there = |[layer, pin]: &&[String; 2]| {
            let own = shot.layers.iter().find(|own| own.name == *layer);
            own.is_some_and(|own| own.pins.iter().any(|own| own.name == *pin))
        };
        let pins: Vec<[String; 2]> = offer.pins.iter().filter(is_there).cloned().collect();
        let text = add_layer(self.document.text(), &name, &nodes)
            .and_then(|text| self.with_lattice(text, &name))
            .and_then(|text| with_pins(text, &name, &pins))
            .and_then(|text| move_layer(&text, &name, place));
        if !self.change("Add layer", text, None) {
            return;
        }
        self.selection.clear();
        self.selection.layer = place;
        let told = match &pins[..] {
            [] => format!("Layer '{name}' has no pins: what it moves is at rest. Click it to place some."),
            [[from, _], ..] => {
                let (count, names) = (pluralised(pins.len(), "pin", "pins"), pins.iter().map(|[_, pin]| pin.as_str()));
                let names = names.collect::<Vec<_>>().join(", ");
                format!("Layer '{name}' took {count} along from '{from}': {names}. Other pins pull it no longer.")
            }
        };
        self.say(told);
    }

    /// Gives a layer the lattice that new shots have.
    fn with_lattice(&self, text: String, name: &str) -> Result<String, ShotError> {
        let named = |value: &str| Setting::Text(value.to_owned());
        let settings = match self.document.shot().source {
            Source::Scene(_) if self.loaded.can_branch => {
                vec![("dims", named("auto")), ("topology", named("branching")), ("box", named("follow"))]
            }
            Source::Images(_) => vec![("dims", named("auto"))],
            Source::Scene(_) | Source::Frame => Vec::new(),
        };
        let put =
            |text: String, (key, value): (&str, Setting)| put_layer_setting(&text, name, &["lattice", key], &value);
        settings.into_iter().try_fold(text, put)
    }

    /// Returns the numbers of handles that the selected layer's thinnest parts chose; `None` until they are known.
    #[must_use]
    pub(crate) fn automatic_dims(&self) -> Option<[usize; 2]> {
        let layer = self.document.shot().layers.get(self.selection.layer).filter(|layer| layer.has_auto_dims)?;
        let (_, [columns, rows, _]) = self.loaded.dims.iter().find(|(name, _)| *name == layer.name)?;
        Some([*columns, *rows])
    }
}

/// Moves pins into a layer, with the strength and step of the layer that they come from.
fn with_pins(text: String, name: &str, pins: &[[String; 2]]) -> Result<String, ShotError> {
    let Some([from, _]) = pins.first() else { return Ok(text) };
    let mut text = text;
    for key in ["strength", "step"] {
        if let Some(value) = layer_number(&text, from, &[key]) {
            let value = if key == "step" { Setting::Whole(value as i64) } else { Setting::Number(value) };
            text = put_layer_setting(&text, name, &[key], &value)?;
        }
    }
    pins.iter().try_fold(text, |text, [layer, pin]| move_pin(&text, PinName { layer, pin }, name))
}

/// Returns the first name of a layer that is free.
fn free_name(shot: &Shot, base: &str) -> String {
    let is_free = |name: &String| shot.layers.iter().all(|layer| layer.name != *name);
    let names = std::iter::once(base.to_owned()).chain((2..).map(|number| format!("{base} {number}")));
    { names }.find(is_free).unwrap_or_default()
}
