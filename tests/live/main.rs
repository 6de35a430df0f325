//! The host-neutral core: warps of one moment, their caches, pixels and shot files.

mod support;
mod warps;
