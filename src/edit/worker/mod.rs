//! The thread that loads, solves and draws, so that the window never waits.
//!
//! In: [`Job`]s, of which only the newest counts, and [`Question`]s. Out: [`Reply`]s, in the order in which they are known: marks,
//! a quick picture, the rendered one.

mod draft_size;
mod drag_solve;
mod file_watch;
mod handle;
mod mail;
mod studio;

pub(in crate::edit) use handle::Worker;
pub(in crate::edit) use mail::{Job, Purpose, Question, Reply};
pub use mail::{Loaded, SolvedFrame};
