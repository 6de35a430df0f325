//! The editor: its model as scripts drive it, and its real interface as people do, without a display.

#[allow(dead_code, reason = "other tests need more of it")]
#[path = "../support/tiny.rs"]
mod tiny;

#[path = "../support/assets.rs"]
mod assets;
#[path = "../support/endurance.rs"]
mod endurance;

mod acts;
mod brush;
mod crowd;
mod export;
mod faults;
mod first_try;
mod foreign;
mod handles;
mod kept_view;
mod keyboard;
mod keys;
mod latency;
mod layer_panel;
mod layout;
mod model;
mod on_disk;
mod pan;
mod panels;
mod parts;
mod pins;
mod poses;
mod quick_hands;
mod render_window;
mod seen;
mod session_memory;
mod snapshot;
mod space;
mod stage;
mod start_page;
mod story;
mod strange;
mod time;
mod view;
mod window;
