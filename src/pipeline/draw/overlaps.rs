//! Reports how parts of a drawing overlap: an order without effect, and limbs that cross without one.
//!
//! In: a solved [`TimeSample`]. Out: a warning and a note per layer.

use crate::pipeline::evaluate::part_order::ordered_parts;
use crate::pipeline::{LayerNote, PreparedShot, TimeSample};
use std::collections::BTreeSet;

/// Returns the note that limbs of a layer cross, with the pin at the one in front first; `None` if none do, or if their pins have orders.
pub(in crate::pipeline) fn crossing_note(
    prepared: &PreparedShot,
    index: usize,
    sample: &TimeSample,
) -> Option<LayerNote> {
    let layer = &prepared.shot.layers[index];
    let (_, parts) = ordered_parts(prepared, index, sample)?;
    let [front, behind] = parts.crossing_pins?.map(|pin| &layer.pins[pin].name);
    let what = if front == behind {
        format!("parts near pin '{front}' cross; the one that moves further lies in front")
    } else {
        format!("the parts at pins '{front}' and '{behind}' cross; the one at '{front}' lies in front")
    };
    let text = format!("layer '{}': {what}, unless `order` of a pin says otherwise", layer.name);
    Some(LayerNote { layer: layer.name.clone(), text })
}

/// Returns the warning that an order of a layer has no effect, because its picture is one part.
pub(super) fn order_warning(prepared: &PreparedShot, index: usize, sample: &TimeSample) -> Option<String> {
    let layer = &prepared.shot.layers[index];
    let of_pins = layer.pins.iter().filter(|pin| !pin.is_muted).map(|pin| &pin.order);
    let has_order = of_pins.chain(&layer.connectivity.orders).any(|keys| !keys.is_empty());
    let is_one = ordered_parts(prepared, index, sample).is_none_or(|(_, parts)| {
        let without_level = parts.list.iter().map(|part| (part.order, part.branch));
        without_level.collect::<BTreeSet<_>>().len() < 2
    });
    (has_order && is_one).then(|| {
        format!(
            "layer '{}': its picture moves as one part, so `order` says nothing; raise `dims`, or separate parts that touch by `cuts`",
            layer.name
        )
    })
}
