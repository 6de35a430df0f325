//! The OpenFX plugin in a host of our own, in this process: strict where the API is, free where hosts are.
//!
//! `host/` is the host; `host/profile.rs` has the hosts it imitates. On other systems than these variadic calls are passed
//! in ways that plain functions cannot receive (`host/params.rs`).
#![cfg(any(
    all(unix, target_arch = "x86_64", not(target_vendor = "apple")),
    all(target_os = "linux", target_arch = "aarch64")
))]
#![expect(unsafe_code, reason = "a host of a C API; one operation a block, each with its SAFETY remark")]

mod actions;
mod buttons;
mod clicks;
mod dying;
mod host;
mod life;
mod maps;
mod memory;
mod overlay;
mod picture;
mod pixels;
mod plates;
mod preferences;
mod regions;
mod rendering;
mod scales;
#[path = "../support/skip.rs"]
mod skip;
mod strangers;
mod traps;
mod unplaced;
mod warnings;

use host::{Host, Node, Pixels};

/// Size of most pictures.
pub(crate) const SIZE: [i32; 2] = [160, 90];

/// A node through which a picture goes, with one pin pulled and one that stays.
pub(crate) fn pulled(host: &mut Host, pixels: &Pixels) -> Node {
    let node = host.node();
    host.through(node, pixels);
    pull(host, node);
    node
}

/// One pin pulled and one that stays, in canonical units of pictures of [`SIZE`] at full scale.
pub(crate) fn pull(host: &Host, node: Node) {
    host.pin(node, 1, [80.0, 45.0], [96.0, 54.0]);
    host.pin(node, 2, [40.0, 45.0], [40.0, 45.0]);
}
