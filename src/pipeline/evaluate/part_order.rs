//! Divides the shape of a branching layer into parts that move as one, with their order where they overlap.
//!
//! In: a [`PreparedShot`], a solved [`TimeSample`], and a layer whose lattice branches. Out: [`OrderedParts`].

use super::ordered_parts::{OrderedPart, OrderedParts};
use super::part_levels::PartLevels;
use super::part_triangle_ranges::PartTriangleRanges;
use super::pin_places::pin_places;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::shot::order_at;
use crate::solve::BranchedLattice;
use std::collections::BTreeMap;

/// Returns the branches of a layer and its parts, which are decided at the first call; `None` if its lattice does not branch.
pub(in crate::pipeline) fn ordered_parts<'a>(
    prepared: &PreparedShot,
    layer: usize,
    now: &'a TimeSample,
) -> Option<(&'a BranchedLattice<2>, &'a OrderedParts)> {
    let state = &now.layers[layer];
    let branches = state.solution.as_ref()?.branches.as_ref()?;
    if let Some(parts) = state.parts.get() {
        return Some((branches, parts));
    }
    // Decided outside of the cell: threads that wait for it could not help with what it takes.
    let parts = OrderedParts::of(prepared, layer, (now, branches));
    Some((branches, state.parts.get_or_init(|| parts)))
}

impl OrderedParts {
    fn of(prepared: &PreparedShot, layer: usize, (now, branches): (&TimeSample, &BranchedLattice<2>)) -> Self {
        let orders = orders(prepared, layer, (now, branches)).unwrap_or_else(|| vec![0; branches.pieces().count()]);
        let levels = PartLevels::of(prepared, layer, (now, branches), &orders);
        let level_of = |piece: usize| levels.of_polygons.get(piece).copied().unwrap_or(0);
        let part = |(piece, (branch, _))| OrderedPart { order: orders[piece], branch, level: level_of(piece) };
        let parts: Vec<OrderedPart> = branches.pieces().enumerate().map(part).collect();
        let mut places: BTreeMap<OrderedPart, u32> = parts.iter().map(|&part| (part, 0)).collect();
        (0..).zip(places.values_mut()).for_each(|(number, place)| *place = number);
        let of_pieces = parts.iter().map(|part| places[part]).collect();
        Self { of_pieces, list: places.into_keys().collect(), crossing_pins: levels.pins }
    }
}

/// Returns the order of each piece; `None` if neither a pin nor a part has an order.
fn orders(
    prepared: &PreparedShot,
    index: usize,
    (now, branches): (&TimeSample, &BranchedLattice<2>),
) -> Option<Vec<i32>> {
    let (layer, starts) = (&prepared.shot.layers[index], &now.layers[index].starts);
    let parts = prepared.ordered_parts_of(index);
    let has_ordered_pins = layer.pins.iter().any(|pin| !pin.is_muted && !pin.order.is_empty());
    if parts.is_empty() && !has_ordered_pins {
        return None;
    }
    let key_frame = prepared.key_frame(layer, now.frame);
    let part_of = parts_of_shape(parts, starts);
    let triangles: Vec<usize> = branches.pieces_of_triangles().map(|(triangle, ..)| triangle).collect();
    let mut orders: Vec<Option<i32>> = triangles
        .iter()
        .map(|&triangle| order_at(&layer.connectivity.orders[parts[part_of(triangle)?].0], key_frame))
        .collect();
    if has_ordered_pins {
        let pins = pin_places(prepared, index, (now, branches));
        let places: Vec<_> = pins.iter().map(|pin| (pin.at, pin.triangle)).collect();
        let of_pins: Vec<_> = pins.iter().map(|pin| order_at(&layer.pins[pin.pin].order, key_frame)).collect();
        let nearest = if places.is_empty() { Vec::new() } else { branches.nearest_along_shape(&places) };
        for ((order, &triangle), pin) in orders.iter_mut().zip(&triangles).zip(nearest) {
            // A part keeps its order against pins beside it.
            let is_beside = |held: u32| part_of(held as usize) != part_of(triangle);
            if order.is_none() || !places[pin].1.is_none_or(is_beside) {
                *order = of_pins[pin].or(*order);
            }
        }
    }
    Some(orders.into_iter().map(Option::unwrap_or_default).collect())
}

/// Returns a function from the triangles of a shape to the last of some parts that has them. `parts`: with one flag for every triangle at
/// rest.
fn parts_of_shape(parts: &[(usize, Vec<bool>)], starts: &[PartTriangleRanges]) -> impl Fn(usize) -> Option<usize> {
    let runs = starts.iter().flat_map(|part| part.starts.windows(2));
    let part_at_rest = |triangle: usize| parts.iter().rposition(|(_, is_in)| is_in.get(triangle) == Some(&true));
    let of_run = |(number, run): (usize, &[u32])| {
        let part = part_at_rest(number);
        (run[0]..run[1]).map(move |_| part)
    };
    let list: Vec<Option<usize>> =
        if parts.is_empty() { Vec::new() } else { runs.enumerate().flat_map(of_run).collect() };
    move |triangle| list.get(triangle).copied().flatten()
}
