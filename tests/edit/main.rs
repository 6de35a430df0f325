//! The editor: its model as scripts drive it, and its real interface as people do, without a display.

#[allow(dead_code, reason = "other tests need more of it")]
#[path = "../support/tiny.rs"]
mod tiny;

#[path = "../support/endurance.rs"]
mod endurance;

mod brush;
mod export;
mod foreign;
mod handles;
mod kept_view;
mod keyboard;
mod keys;
mod model;
mod panels;
mod pins;
mod session_memory;
mod snapshot;
mod space;
mod stage;
mod window;
