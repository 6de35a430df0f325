//! The editor's window: thin widgets over a [`Session`](super::Session).
//!
//! In: window events. Out: calls of the session, and shapes to draw. The only module that depends on the toolkit.

mod accessible;
mod actions;
mod arrow_keys;
mod browser;
mod brush;
mod bundled;
mod curves;
mod dialogs;
mod drops;
mod editor;
mod export_window;
mod frame_scale;
mod handle_panel;
mod icons;
mod inspector;
mod kept_view;
mod key_window;
mod keys;
mod lattice_panel;
mod layers;
mod marks;
mod matte;
mod menus;
mod name_field;
mod number_field;
mod onion;
mod options;
mod over;
mod pan;
mod panel_edge;
mod panels;
mod pen;
mod picture_parts;
mod pin_names;
mod questions;
mod references;
mod render_window;
mod rendered_bar;
mod screenshot;
mod shot_panel;
mod software;
mod start;
mod theme;
mod timeline;
mod tour_window;
mod track_row;
mod transport;
mod turn_fields;
mod viewport;
mod window;

#[cfg(test)]
pub(crate) use editor::Editor;
#[cfg(any(test, feature = "cli"))]
pub(crate) use eframe::egui::Theme;
#[cfg(any(test, feature = "cli"))]
pub(crate) use options::EditorOptions;
#[cfg(any(test, feature = "cli"))]
pub(crate) use screenshot::{Screenshot, screenshot};
#[cfg(any(test, feature = "cli"))]
pub(crate) use window::run;
