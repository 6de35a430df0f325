//! Divides the shape of a branching layer into parts that move as one, with their order where they overlap.
//!
//! In: a [`PreparedShot`], a solved [`TimeSample`], and a layer whose lattice branches. Out: [`OrderedParts`].

use super::part_triangle_ranges::held_triangle;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::solve::BranchedLattice;
use std::collections::BTreeMap;

/// The pieces of a branch that have the same order. Sorts by order, then by branch with the largest branch first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::pipeline) struct OrderedPart {
    /// Order of the pin nearest along the shape; 0 if no pin has an order.
    pub(in crate::pipeline) order: i32,
    pub(in crate::pipeline) branch: usize,
}

/// The parts of a layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::pipeline) struct OrderedParts {
    /// From back to front, as far as order and size of the branches determine it.
    pub(in crate::pipeline) list: Vec<OrderedPart>,
    /// Index into the list for each piece, in the order of [`BranchedLattice::pieces`].
    pub(in crate::pipeline) of_pieces: Vec<u32>,
}

impl OrderedParts {
    pub(in crate::pipeline) fn of(
        prepared: &PreparedShot,
        layer: usize,
        (now, branches): (&TimeSample, &BranchedLattice<2>),
    ) -> Self {
        let orders = orders(prepared, layer, (now, branches));
        let order_of = |piece: usize| orders.as_ref().map_or(0, |orders| orders[piece]);
        let parts: Vec<OrderedPart> = (branches.pieces().enumerate())
            .map(|(piece, (branch, _))| OrderedPart { order: order_of(piece), branch })
            .collect();
        let mut places: BTreeMap<OrderedPart, u32> = parts.iter().map(|&part| (part, 0)).collect();
        (0..).zip(places.values_mut()).for_each(|(number, place)| *place = number);
        Self { of_pieces: parts.iter().map(|part| places[part]).collect(), list: places.into_keys().collect() }
    }
}

/// Returns the order of each piece; `None` if no pin has an order.
fn orders(
    prepared: &PreparedShot,
    index: usize,
    (now, branches): (&TimeSample, &BranchedLattice<2>),
) -> Option<Vec<i32>> {
    let (layer, state) = (&prepared.shot.layers[index], &now.layers[index]);
    if state.pins.is_empty() || layer.pins.iter().all(|pin| pin.order.is_empty()) {
        return None;
    }
    let anchors = prepared.anchors_of(index);
    let held = state.pins.iter().map(|pin| (pin.rest.0.to_array(), held_triangle(&anchors[pin.pin], &state.starts)));
    let nearest = branches.nearest_along_shape(&held.collect::<Vec<_>>());
    let key_frame = prepared.key_frame(layer, now.frame);
    let of_pins: Vec<i32> = state.pins.iter().map(|pin| layer.pins[pin.pin].order_at(key_frame)).collect();
    Some(nearest.into_iter().map(|pin| of_pins[pin]).collect())
}
