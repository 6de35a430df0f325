//! The OpenFX plugin: pinwarp inside compositors that load `PinWarp.ofx.bundle`. An adapter without geometry of its own.
//!
//! In: actions of a host, with its clips and parameters. Out: pixels, regions and messages, computed by `crate::live`.
//! Actions arrive in `entry`; `host` wraps the C declarations of `api` safely for all other files.

#![expect(unsafe_code, reason = "OpenFX is a C API; safe wrappers around single calls, each with its SAFETY remark")]

#[allow(dead_code, unused_imports, reason = "some of it is for the host of the tests, which includes these files")]
mod api;
mod budget;
mod buttons;
mod call;
mod changed;
mod clips;
mod describe;
mod entry;
mod fault;
mod host;
mod host_frame;
mod notices;
mod overlay;
mod params;
mod pen;
mod pins;
mod regions;
mod render;
mod settings;
mod values;

pub use entry::{number_of_plugins, plugin, set_host};
