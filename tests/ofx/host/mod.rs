//! A host in this process, in Rust, over the C ABI: scripted, strict with the plugin, and free in all that hosts are free in.
//!
//! In: a [`Profile`](profile::Profile) and calls of [`Host`](session::Host). Out: pictures, answers, and a failed test for every fault.

#[allow(dead_code, unreachable_pub, unused_imports, reason = "some of it is for the plugin")]
#[path = "../../../src/ofx/api/mod.rs"]
pub(crate) mod api;
mod effects;
mod extras;
mod making;
mod params;
mod pen;
pub(crate) mod pixels;
pub(crate) mod profile;
mod props;
pub(crate) mod session;
mod spec;
mod world;

pub(crate) use making::{Set, feed};
pub(crate) use pixels::{Depth, Pixels, Rows};
pub(crate) use profile::Profile;
pub(crate) use session::{Frame, Host, Node, Which, declared};
pub(crate) use world::{Drawn, Value};
