//! An action called by a host on one of the plugins, with its arguments.
//!
//! In: the handles passed to `entry`. Out: [`Call`], the argument of every action's function.

use super::api::Status;
use super::fault::Fault;
use super::host::{Effect, Props};

/// Which of the library's plugins an action addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PluginKind {
    /// The warp.
    PinWarp,
    /// The STMap of that warp.
    StMap,
}

/// An action on an effect, with its arguments.
#[derive(Clone, Copy)]
pub(super) struct Call<'a> {
    pub(super) kind: PluginKind,
    pub(super) effect: Effect<'a>,
    /// Its in arguments; empty if there are none.
    pub(super) args: Props<'a>,
    /// Its out arguments.
    pub(super) out: Props<'a>,
}

/// The function that handles an action.
pub(super) type Action = fn(Call) -> Result<Status, Fault>;
