//! The plugin's memory budget: the user sets it before the host starts, and renders reserve from it.
//!
//! In: `PINWARP_MAX_MEMORY` and the bytes that a render will need. Out: a [`Reservation`], or a [`Fault`] that the host
//! shows.

use super::fault::Fault;
use super::host::{Effect, Image};
use crate::memory::{self, MemoryLimit, Reservation};
use std::sync::LazyLock;

/// The environment variable that holds the limit, in the syntax of `--max-memory`.
const VARIABLE: &str = "PINWARP_MAX_MEMORY";

/// Bytes of a map per pixel.
pub(super) const MAP_BYTES: u128 = 8;

/// Bytes per sample.
const SAMPLE: u128 = 4;

/// The result of reading the variable, once per process: an error message if it is invalid.
static LIMIT: LazyLock<Result<(), String>> = LazyLock::new(|| {
    let Some(text) = std::env::var_os(VARIABLE) else { return Ok(()) };
    let text = text.to_string_lossy();
    let limit: MemoryLimit = text.parse().map_err(|hint| format!("{VARIABLE} is \"{text}\"; {hint}"))?;
    memory::set_limit(limit);
    Ok(())
});

/// Applies the user's limit. An invalid limit is reported by the first render.
pub(super) fn read_limit() {
    LazyLock::force(&LIMIT);
}

/// Returns the bytes of `count` planes of `area` samples each.
pub(super) fn planes(count: usize, area: usize) -> u128 {
    count as u128 * area as u128 * SAMPLE
}

/// Returns the bytes of an image as planes of at least `channels` channels. Straight colour is premultiplied in a copy.
pub(super) fn image(image: &Image, channels: usize) -> u128 {
    let copies = if image.is_straight { 2 } else { 1 };
    copies * planes(image.channels.max(channels), image.area())
}

/// Reserves bytes for a picture of `size` pixels, waiting while other renders hold them.
///
/// No image may be fetched while the reservation is held: a host may respond by rendering another instance on the same
/// thread, which would deadlock.
pub(super) fn reserve(effect: Effect, bytes: u128, size: [u32; 2]) -> Result<Reservation, Fault> {
    LIMIT.clone().map_err(Fault::Limit)?;
    let reserved = memory::reserve_until(bytes, &|| effect.is_aborted());
    let reserved = reserved.map_err(|source| Fault::Memory { size, source })?;
    reserved.ok_or(Fault::Aborted)
}
