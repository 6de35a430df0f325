//! The editor: its model as scripts drive it, and its real interface as people do, without a display.

#[path = "../support/tiny.rs"]
mod tiny;

mod model;
mod stage;
mod window;
