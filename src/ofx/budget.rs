//! The plugin's memory budget: the user sets it before the host starts, renders reserve from it.
//!
//! In: `PINWARP_MAX_MEMORY`, what a render is about to take. Out: a [`Reservation`], or a [`Fault`] that the host shows.

use super::fault::Fault;
use super::host::{Effect, Image};
use crate::memory::{self, MemoryLimit, Reservation};
use std::sync::LazyLock;

/// The variable that holds the limit, written as `--max-memory` is.
const VARIABLE: &str = "PINWARP_MAX_MEMORY";

/// Bytes that a map takes for a pixel.
pub(super) const MAP_BYTES: u128 = 8;

/// Bytes of a sample.
const SAMPLE: u128 = 4;

/// Reads the variable once; what is wrong with it.
static LIMIT: LazyLock<Result<(), String>> = LazyLock::new(|| {
    let Some(text) = std::env::var_os(VARIABLE) else { return Ok(()) };
    let text = text.to_string_lossy();
    let limit: MemoryLimit = text.parse().map_err(|hint| format!("{VARIABLE} is \"{text}\"; {hint}"))?;
    memory::set_limit(limit);
    Ok(())
});

/// Takes over the user's limit. What is wrong with it is told by the first render.
pub(super) fn read_limit() {
    LazyLock::force(&LIMIT);
}

/// Bytes of so many planes.
pub(super) fn planes(count: usize, area: usize) -> u128 {
    count as u128 * area as u128 * SAMPLE
}

/// Bytes of an image as planes of at least so many channels. Straight colour is multiplied by its alpha in a copy.
pub(super) fn image(image: &Image, channels: usize) -> u128 {
    let copies = if image.is_straight { 2 } else { 1 };
    copies * planes(image.channels.max(channels), image.area())
}

/// Reserves bytes for a picture of that size, and waits while other renders hold them. No image may be fetched while they
/// are reserved: hosts may answer that with a render of another instance on the same thread.
pub(super) fn reserve(effect: Effect, bytes: u128, size: [u32; 2]) -> Result<Reservation, Fault> {
    LIMIT.clone().map_err(Fault::Limit)?;
    let reserved = memory::reserve_until(bytes, &|| effect.is_aborted());
    let reserved = reserved.map_err(|source| Fault::Memory { size, source })?;
    reserved.ok_or(Fault::Aborted)
}
