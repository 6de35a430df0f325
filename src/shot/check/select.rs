//! Validates `nodes` and `select` of a layer.
//!
//! In: raw tables. Out: a [`Selection`].

use super::{Check, Kind, LayerDefaults};
use crate::shot::raw::{RawMask, RawNamedNodes, RawNodes, RawSelect};
use crate::shot::selection::FEATHER;
use crate::shot::{ColorChannel, Layer, PaintedMask, Selection};

impl Check<'_> {
    pub(super) fn selection(&mut self, raw: &RawSelect, layer: &str, shot: &LayerDefaults) -> Selection {
        let key = format!("{layer}.select");
        if shot.source != Kind::Scene && self.document.has(&key) {
            let hint = "remove `select`; a layer takes whole pictures by `nodes`, parts of plates by `matte`";
            self.fault(&key, "only meshes of a `scene` have joints, materials, vertex colours and UVs", hint);
        }
        let selection = Selection {
            is_rest: false,
            joints: raw.joints.clone().unwrap_or_default(),
            materials: raw.materials.clone().unwrap_or_default(),
            vertex_color: raw.vertex_color,
            mask: raw.mask.as_ref().map(|mask| self.mask(mask)),
            feather: raw.feather.unwrap_or(FEATHER),
        };
        if selection.is_whole() && raw.feather.is_some() {
            let hint = "add joints, materials, vertex_color or mask";
            self.fault(&format!("{key}.feather"), "whole meshes have no border to soften", hint);
        }
        selection
    }

    fn mask(&self, raw: &RawMask) -> PaintedMask {
        PaintedMask {
            file: self.folder().join(&raw.file),
            channel: raw.channel.unwrap_or(ColorChannel::R),
            uv_set: raw.texcoord,
        }
    }

    /// Checks that at most one layer takes the remaining nodes.
    pub(super) fn rest_layers(&mut self, layers: &[Layer]) {
        let mut rests = layers.iter().enumerate().filter(|(_, layer)| layer.selection.is_rest);
        let Some((_, first)) = rests.next() else { return };
        for (index, _) in rests {
            let what = format!("layer '{}' takes the rest already", first.name);
            self.fault(&format!("layer[{index}].nodes"), what, "name nodes, for example nodes = [\"Body*\"]");
        }
    }
}

/// Returns the node patterns, and whether the layer takes the nodes that no other layer takes.
pub(super) fn nodes(raw: Option<RawNodes>) -> (Vec<String>, bool) {
    match raw {
        None => (Vec::new(), false),
        Some(RawNodes::Named(RawNamedNodes::Rest)) => (Vec::new(), true),
        Some(RawNodes::Patterns(patterns)) => (patterns, false),
    }
}
