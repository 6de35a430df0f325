//! The numbers of the selected handles of lattices.
//!
//! In: a [`Session`]. Out: a selected handle; typed offsets.

use super::accessible::Accessible;
use super::number_field::{NumberField, whole};
use crate::edit::Session;
use crate::shot::{HandleKey, LayerSpace};
use eframe::egui::{self, Grid, Ui};

/// The names of the coordinates of a handle, and of the axes of its offset.
const AXES: [(&str, &str); 3] = [("column", "x"), ("row", "y"), ("layer", "z")];

/// Shows the selected handles while handles are shown.
pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    let handles: Vec<(usize, [usize; 3])> = session.selection.handles.iter().copied().collect();
    if handles.is_empty() && !session.shown.handles {
        return;
    }
    let layer = handles.first().map_or(session.selection.layer, |(layer, _)| *layer);
    let Some(owner) = session.shot().layers.get(layer) else { return };
    let (space, has_auto_dims) = (owner.space, owner.has_auto_dims);
    ui.add_space(14.0);
    ui.horizontal(|ui| {
        ui.strong(if handles.len() > 1 { "Handles" } else { "Handle" });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let hint = "Put the selected handles back to rest, with all their keys";
            if !handles.is_empty() && ui.small_button("Reset").on_hover_text(hint).clicked() {
                session.reset_handles();
            }
        });
    });
    ui.separator();
    match &handles[..] {
        [] if has_auto_dims => {
            ui.weak("The dims of this lattice are automatic: set them in the layer's settings to move handles.");
            return;
        }
        [] => {
            ui.weak("None is selected. Click one, or drag a box around several.");
            if ui.small_button("Select the first").clicked() {
                session.selection.only_handle((layer, [0; 3]));
            }
            return;
        }
        [_] => {}
        more => _ = ui.weak(format!("{} handles are selected: a number goes to all of them.", more.len())),
    }
    Grid::new("handles").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
        if let [only] = handles[..] {
            place(ui, session, only, space);
        }
        offset(ui, session, &handles);
    });
}

/// Returns the number of axes of a lattice.
const fn axes(space: LayerSpace) -> usize {
    match space {
        LayerSpace::Screen { .. } => 2,
        LayerSpace::World { .. } => 3,
    }
}

/// Chooses a handle by its coordinates in the lattice.
fn place(ui: &mut Ui, session: &mut Session, (layer, old): (usize, [usize; 3]), space: LayerSpace) {
    let (mut new, dims) = (old, space.dims());
    ui.label("Place").on_hover_text("column, row and layer in the lattice, counted from 0");
    ui.horizontal(|ui| {
        for axis in 0..axes(space) {
            let field = whole(&mut new[axis], 0..=dims[axis].saturating_sub(1));
            ui.add(field).accessible(&format!("Handle {}", AXES[axis].0));
        }
    });
    ui.end_row();
    if new != old {
        session.selection.only_handle((layer, new));
    }
}

/// Edits the offset of the handles in per cent of the lattice's box.
fn offset(ui: &mut Ui, session: &mut Session, handles: &[(usize, [usize; 3])]) {
    let keys: Vec<HandleKey> = handles.iter().filter_map(|&at| session.handle_here(at)).collect();
    let spaces = handles.iter().filter_map(|(layer, _)| Some(session.shot().layers.get(*layer)?.space));
    let (Some(first), Some(axes)) = (keys.first(), spaces.map(axes).min()) else { return };
    let mut typed = None;
    ui.label("Offset").on_hover_text("in per cent of the lattice's box, along its axes");
    ui.vertical(|ui| {
        for (axis, (_, letter)) in AXES.into_iter().enumerate().take(axes) {
            let name = format!("Handle offset {letter}");
            let field = NumberField { name: &name, hint: &name, range: f64::MIN..=f64::MAX, decimals: 3 };
            let mut percent = 100.0 * first.offset[axis];
            let is_mixed = keys.iter().any(|key| key.offset[axis] != first.offset[axis]);
            let is_edited = field.drag(ui, &mut percent, |number| match is_mixed {
                true => number
                    .speed(0.1)
                    .custom_formatter(|_, _| "mixed".to_owned())
                    .custom_parser(|text| text.trim_end_matches('%').trim().parse().ok()),
                false => number.speed(0.1).prefix(format!("{letter} ")).suffix(" %"),
            });
            if is_edited {
                typed = Some((axis, percent / 100.0));
            }
        }
    });
    ui.end_row();
    if let Some((axis, offset)) = typed {
        session.type_handles(axis, offset);
    }
}
