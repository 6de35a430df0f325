//! The native editor, `pinwarp edit`: interactive pinning (picture of the parts: docs/ARCHITECTURE.md).
//!
//! In: any file that can be opened. Out: a shot file with comments and order preserved; frames exactly as rendered. A
//! front end of `shot` and `pipeline` without geometry or solver of its own.

mod axis_ring;
mod channel_keys;
mod command;
mod curve;
mod document;
mod dropped;
mod error;
mod export_order;
mod first_keys;
mod frame_runs;
mod history;
mod journal;
mod journal_line;
mod keyed_frames;
mod layer_space;
mod open;
mod picture;
mod playhead;
mod recent;
mod reference;
mod regrid;
mod render_hold;
mod render_order;
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

pub(crate) mod ui;

pub(crate) use axis_ring::AxisRing;
pub(crate) use curve::{Channel, Tangent, TangentEnd};
pub(crate) use document::{DiskChange, Document};
pub(crate) use dropped::Dropped;
pub(crate) use error::EditError;
pub(crate) use export_order::{EXPORTS, ExportOrder};
pub(crate) use layer_space::Space;
pub(crate) use open::open;
pub(crate) use picture::{Picture, Quality};
pub(crate) use playhead::Pace;
pub(crate) use recent::{recent_shots, remember_shot};
pub(crate) use reference::Reference;
pub(crate) use render_order::{RenderOrder, RenderRange};
pub(crate) use session::{BRUSH_RADII, BRUSH_STIFFNESSES, CurveUnit, Figure, Onion, Wipe};
pub(crate) use session::{EasePreset, Held, KeyStep, MatteChoice, PinPart, RenderRun, Ring, RunState, Session, Shown};
pub(crate) use shortcuts::Action;
pub(crate) use shortcuts::{Chord, Shortcuts};
pub(crate) use tour::Tour;
pub(crate) use track::AutoKey;
pub(crate) use track_keys::Track;
pub(crate) use unfinished::{Unfinished, forget, unfinished};
pub(crate) use view_settings::{Brightness, PanelSizes, ViewSettings};
pub(crate) use zoom::{Lens, Zoom};
