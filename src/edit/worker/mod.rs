//! The worker thread that loads, solves and draws, so that the window never blocks.
//!
//! In: [`Job`]s, of which only the newest counts, and [`Question`]s. Out: [`Reply`]s as results become available:
//! marks, a draft, the rendered picture.

mod draft_size;
mod drag_solve;
mod file_watch;
mod frame_worker;
mod handle;
mod keyed_poses;
mod mail;
mod plate_watch;

pub(in crate::edit) use handle::Worker;
pub(crate) use mail::Loaded;
pub(crate) use mail::SolvedFrame;
pub(in crate::edit) use mail::{FoundPoint, HeldPlace, Job, Purpose, Question, Reply};
