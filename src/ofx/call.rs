//! An action of a host on one of the plugins, with its arguments.
//!
//! In: handles that `entry` was called with. Out: [`Call`], which every action's function takes.

use super::api::Status;
use super::fault::Fault;
use super::host::{Effect, Props};

/// Which of the library's plugins an action addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PluginKind {
    /// Warps the picture.
    PinWarp,
    /// Writes the STMap of that warp.
    StMap,
}

/// An action on an effect.
#[derive(Clone, Copy)]
pub(super) struct Call<'a> {
    pub(super) kind: PluginKind,
    pub(super) effect: Effect<'a>,
    /// Its arguments; empty where it has none.
    pub(super) args: Props<'a>,
    /// Where its answers go.
    pub(super) out: Props<'a>,
}

/// What an action does.
pub(super) type Action = fn(Call) -> Result<Status, Fault>;
