//! The native editor, `pinwarp edit`: interactive pinning.
//!
//! In: any file that can be opened. Out: a shot file with comments and order preserved; frames exactly as rendered. A
//! front end of `shot` and `pipeline` without geometry or solver of its own.
//!
//! ```text
//! pen, keys ─ui─▶ Session ─shot::edit─▶ Document: text, Shot, Commands ─▶ shot.toml, journal
//!                    │  ▲
//!                Job ▼  │ Reply: marks, quick picture, rendered frame
//!             Worker: OpenShot ─▶ TimeSample ─▶ Frame
//! ```

mod axis_ring;
mod channel_keys;
mod command;
mod curve;
mod document;
mod dropped;
mod error;
mod export_order;
mod history;
mod journal;
mod journal_line;
mod open;
mod picture;
mod playhead;
mod reference;
mod regrid;
mod session;
mod shortcuts;
mod stored_path;
mod tour;
mod track;
mod track_curve;
mod track_keys;
mod unfinished;
mod view_settings;
mod worker;
mod zoom;

pub mod ui;

pub(crate) use axis_ring::AxisRing;
pub use command::{Command, merged};
pub use curve::{Channel, Tangent};
pub use document::{DiskChange, Document};
pub(crate) use dropped::Dropped;
pub use error::EditError;
pub(crate) use export_order::{EXPORTS, ExportOrder};
pub use history::History;
pub use open::open;
pub use picture::{Picture, Quality};
pub(crate) use playhead::Pace;
pub use playhead::Playhead;
pub(crate) use reference::Reference;
pub(crate) use session::{BRUSH_RADII, BRUSH_STIFFNESSES, CurveUnit, Onion, Wipe};
pub use session::{
    Brush, EasePreset, Held, KeyStep, MatteChoice, PinPart, RenderRun, Ring, RunState, Selection, Session, Shown,
};
pub use shortcuts::Action;
pub(crate) use shortcuts::{Chord, Shortcuts};
pub(crate) use tour::Tour;
pub(crate) use track::AutoKey;
pub use track_keys::Track;
pub(crate) use unfinished::{Unfinished, forget, unfinished};
pub(crate) use view_settings::{Brightness, PanelSizes, ViewSettings};
pub use worker::SolvedFrame;
pub use zoom::{Lens, Zoom};
