//! Validates `mirror` of pins and `symmetry` of layers, and gives mirrored pins the keys of the pins they follow.
//!
//! In: all checked layers, and the pins that `mirror` names. Out: the layers, with [`Mirror`]s, keys and units set.

use super::{Check, Kind, LayerDefaults};
use crate::shot::raw::{RawMirror, RawSymmetry};
use crate::shot::{AxisPlane, Layer, LayerSpace, Mirror};
use crate::spelling;

/// What `mirror` of each pin names: #layers, then #pins.
pub(super) type Followed = Vec<Vec<Option<RawMirror>>>;

/// Returns the key of a pin.
fn key_of([layer, pin]: [usize; 2]) -> String {
    format!("layer[{layer}].pin[{pin}]")
}

impl Check<'_> {
    /// Returns the plane of a layer's `symmetry`.
    pub(super) fn symmetry(&mut self, raw: RawSymmetry, layer: &str, shot: &LayerDefaults) -> AxisPlane {
        let axis = raw.axis.index();
        if axis == 2 && shot.source != Kind::Scene {
            let hint = "write \"x\" for left and right, \"y\" for top and bottom";
            self.fault(&format!("{layer}.symmetry.axis"), "pictures and plates have no depth", hint);
        }
        AxisPlane { axis, at: raw.at }
    }

    /// Resolves the names of followed pins and copies keys, unit, region and weight from them, where a mirrored pin has none of its own.
    pub(super) fn mirrored_pins(&mut self, layers: &mut [Layer], followed: &Followed) {
        for (index, names) in followed.iter().enumerate() {
            for (number, name) in names.iter().enumerate() {
                let Some(name) = name else { continue };
                let Some(mirror) = self.mirror(name, [index, number], layers, followed) else { continue };
                let source = layers[mirror.layer].pins[mirror.pin].clone();
                let own = &mut layers[index].pins[number];
                own.mirror = Some(mirror);
                own.copy_keys(&source);
                own.region = own.region.or(source.region);
                if mirror.is_anchor_mirrored {
                    own.anchor = source.anchor;
                }
                if !self.document.has(&format!("{}.weight", key_of([index, number]))) {
                    own.weight = source.weight;
                }
            }
        }
    }

    /// Returns the pin that `mirror` names; `None` if it names none that can be followed, which is a fault.
    fn mirror(&mut self, name: &RawMirror, place: [usize; 2], layers: &[Layer], followed: &Followed) -> Option<Mirror> {
        let key = key_of(place);
        for other in ["keys", "rotate_keys", "scale_keys", "unit"].map(|other| format!("{key}.{other}")) {
            if self.document.has(&other) {
                self.fault(&other, "a mirrored pin takes this from the pin that it follows", "remove it, or `mirror`");
            }
        }
        let key_of_mirror = format!("{key}.mirror");
        let (layer, pin) = match name {
            RawMirror::Pin(pin) => (place[0], pin),
            RawMirror::Of(of) => {
                let names = layers.iter().map(|layer| layer.name.as_str());
                let Some(layer) = layers.iter().position(|layer| layer.name == of.layer) else {
                    let hint = spelling::hint(&of.layer, names);
                    self.fault(&format!("{key_of_mirror}.layer"), format!("there is no layer '{}'", of.layer), hint);
                    return None;
                };
                (layer, &of.pin)
            }
        };
        let names = layers[layer].pins.iter().map(|pin| pin.name.as_str());
        let Some(found) = layers[layer].pins.iter().position(|other| other.name == *pin) else {
            let what = format!("layer '{}' has no pin '{pin}'", layers[layer].name);
            self.fault(&key_of_mirror, what, spelling::hint(pin, names));
            return None;
        };
        let is_world = |index: usize| matches!(layers[index].space, LayerSpace::World { .. });
        let fault = if [layer, found] == place {
            Some(("a pin cannot follow itself", "name the pin on the other side"))
        } else if followed[layer][found].is_some() {
            Some(("the pin that it names is mirrored itself", "name the pin that has the keys"))
        } else if is_world(layer) != is_world(place[0]) {
            let hint = "give both lattices the same `space`";
            Some(("one of the two layers moves on the screen, the other in the scene", hint))
        } else {
            None
        };
        if let Some((what, hint)) = fault {
            self.fault(&key_of_mirror, what, hint);
            return None;
        }
        let is_anchor_mirrored = !self.document.has(&format!("{key}.anchor"));
        Some(Mirror { layer, pin: found, is_anchor_mirrored })
    }
}
