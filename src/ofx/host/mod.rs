//! Safe wrappers of the host: suites, properties, effects with their clips and parameters, images, overlays.
//!
//! In: handles and tables of C functions. Out: Rust values; what a host does not provide is `None` or has no effect.
//! Nothing here depends on what the plugin does.

mod effect;
mod error;
mod guard;
mod images;
mod interact;
mod kept;
mod lifetime;
mod messages;
mod paint;
mod param_set;
mod props;
mod suites;

pub(super) use effect::{Clip, Effect};
pub(super) use error::HostError;
pub(super) use guard::{action_name, caught, guarded};
pub(super) use images::{Depth, Image, Rows, Target};
pub(super) use interact::Interact;
pub(super) use kept::Kept;
pub(super) use lifetime::{begin_effect, end_effect, has_ended};
pub(super) use messages::FrameWarning;
pub(super) use paint::Painter;
pub(super) use param_set::{Params, When};
pub(super) use props::Props;
pub(super) use suites::{Suites, load, meet, suites};
