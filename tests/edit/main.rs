//! The editor: its model as scripts drive it, and its real interface as people do, without a display.

#[allow(dead_code, reason = "other tests need more of it")]
#[path = "../support/tiny.rs"]
mod tiny;

mod foreign;
mod model;
mod pins;
mod snapshot;
mod stage;
mod window;
