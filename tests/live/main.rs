//! The host-neutral core: warps of one moment, their caches, pixels and shot files.

mod alpha_regions;
mod branches;
#[path = "../support/drawn_girl.rs"]
mod drawn_girl;
mod files;
mod pixels;
mod polls;
mod regions;
mod shots;
mod support;
mod warps;

/// A warp that moves nothing.
fn live_warp_at_rest() -> std::sync::Arc<pinwarp::live::Warp> {
    use pinwarp::live::{Controls, ShapeSource, warp};
    warp(&Controls::default(), &ShapeSource::Frame, support::WIDE).expect("solves")
}
