//! The inspector: values of the selected pin, and the report of the frame.

use super::handle_panel;
use super::icons;
use super::name_field::NameField;
use super::number_field::NumberField;
use super::theme::heat;
use super::turn_fields::{self, PinValues};
use crate::edit::{Figure, Session};
use crate::shot::{Goal, OffsetUnit, PinKey, PinRegion};
use crate::space::{ScreenPoint, ScreenVector};
use eframe::egui::{self, Align, Checkbox, Color32, Grid, Label, Layout, RichText, ScrollArea, Ui, vec2};

/// The field of a pin's name.
const NAME: NameField = NameField { name: "Pin name", hint: "Pin name", width: f32::INFINITY };

pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    if session.selection.single_pin().is_none()
        && let Some((at, name)) = NAME.take_left(ui.ctx())
    {
        session.rename_pin(at, &name);
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.add_space(6.0);
        match session.selection.single_pin() {
            Some(at) => pin(ui, session, at),
            None => {
                ui.strong("Pin");
                ui.separator();
                let what = session.subject();
                ui.weak(match session.selection.pins.len() {
                    0 => {
                        format!("None is selected. Click the {what} to place one; drag empty space to select several.")
                    }
                    count => format!("{count} pins are selected: drag one of them, nudge them with the arrow keys."),
                });
                hard(ui, session);
            }
        }
        handle_panel::show(ui, session);
        ui.add_space(14.0);
        report(ui, session);
    });
}

fn pin(ui: &mut Ui, session: &mut Session, at: [usize; 2]) {
    let Some(own) = session.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1])).cloned() else { return };
    ui.horizontal(|ui| {
        ui.strong("Pin");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.small_button("Delete").clicked() {
                session.delete_pins();
            }
            if ui.small_button(if own.is_muted { "Unmute" } else { "Mute" }).clicked() {
                session.toggle_pin_mute(&[at]);
            }
        });
    });
    ui.separator();
    if let Some((at, name)) = NAME.show(ui, at, &own.name) {
        session.rename_pin(at, &name);
    }
    let Some(key) = session.key_here(at) else { return };
    let is_keyed = session.has_key_here(at);
    ui.horizontal(|ui| {
        icons::key_sign(ui, is_keyed);
        ui.weak(match (own.is_muted, is_keyed) {
            (true, _) => "muted: it does not act",
            (false, true) => "keyed in this frame",
            (false, false) => between(own.key_frames(), key.frame),
        });
    });
    Grid::new("pin").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
        place(ui, session, PinValues { at, key });
        turn_fields::show(ui, session, PinValues { at, key });
        region(ui, session, (at, own.region));
        weight(ui, session, at, own.weight);
    });
}

/// Returns where a frame lies among keys.
fn between(keys: impl Iterator<Item = f64>, frame: f64) -> &'static str {
    match keys.fold([false; 2], |[before, after], key| [before || key < frame, after || key > frame]) {
        [true, true] => "between keys",
        [true, false] => "after the last key",
        [false, true] => "before the first key",
        [false, false] => "without keys",
    }
}

/// Edits the pin's weight, from soft to hard.
fn weight(ui: &mut Ui, session: &mut Session, at: [usize; 2], old: f64) {
    ui.label("Firmness");
    hard(ui, session);
    ui.end_row();
    ui.label("Weight");
    let mut weight = old;
    let hint = "1 holds the point exactly; less gives way to the shape and to other pins";
    let field = NumberField { name: "Weight", hint, range: 0.0..=1.0, decimals: 2 };
    if field.slider(ui, &mut weight, |slider| slider) {
        session.set_weight(at, weight);
    }
    ui.end_row();
}

/// Makes the selected pins hard or soft.
fn hard(ui: &mut Ui, session: &mut Session) {
    if session.selection.pins.is_empty() {
        return;
    }
    let are_hard = session.are_hard();
    let mut is_hard = are_hard.unwrap_or(false);
    let hint = "On: the point is held exactly. Off: it gives way to the shape and to other pins, with the weight that it had last";
    let checkbox = Checkbox::new(&mut is_hard, "Hard").indeterminate(are_hard.is_none());
    if ui.add(checkbox).on_hover_text(hint).changed() {
        session.set_hard(is_hard);
    }
}

/// Edits a position in pixels, or in per cent of the lattice's box.
fn place(ui: &mut Ui, session: &mut Session, PinValues { at, key }: PinValues) {
    let lines = f64::from(session.shot().size.height);
    let is_box = session.shot().layers[at[0]].pins[at[1]].unit == OffsetUnit::Box;
    let (scale, unit, hint) = match key.goal {
        Goal::Offset(_) if is_box => (100.0, " %", "in per cent of the lattice's box"),
        _ => (lines, " px", "in pixels of the frame"),
    };
    let (what, old) = match key.goal {
        Goal::Offset(offset) => ("Offset", offset.0),
        Goal::Target(target) => ("Target", target.0),
        Goal::SceneOffset(offset) => return place_in_scene(ui, session, PinValues { at, key }, "Offset", offset),
        Goal::SceneTarget(target) => return place_in_scene(ui, session, PinValues { at, key }, "Target", target),
    };
    let mut new = old * scale;
    ui.label(what).on_hover_text(hint);
    let is_changed = ui
        .horizontal(|ui| {
            let mut number = |value: &mut f64, name: &str| {
                let field = NumberField { name, hint: name, range: f64::MIN..=f64::MAX, decimals: 1 };
                field.drag(ui, value, |number| number.speed(0.5).suffix(unit))
            };
            let changed = [number(&mut new.x, &format!("{what} x")), number(&mut new.y, &format!("{what} y"))];
            changed.contains(&true)
        })
        .inner;
    ui.end_row();
    if is_changed {
        let rounded = (new / scale * 1e6).round() / 1e6;
        let goal = match key.goal {
            Goal::Target(_) => Goal::Target(ScreenPoint(rounded)),
            _ => Goal::Offset(ScreenVector(rounded)),
        };
        session.put_key(at, PinKey { goal, ..key });
    }
}

/// Edits a position in the scene, in its own unit.
fn place_in_scene(ui: &mut Ui, session: &mut Session, PinValues { at, key }: PinValues, what: &str, old: [f64; 3]) {
    let unit = session.shot().layers[at[0]].pins[at[1]].unit;
    let hint = if unit == OffsetUnit::Box { "in sizes of the lattice's box" } else { "in metres of the scene" };
    ui.label(what).on_hover_text(hint);
    let Some(new) = three(ui, what, (old, 0.002)) else { return };
    let rounded = new.map(|value| (value * 1e6).round() / 1e6);
    let goal = match key.goal {
        Goal::SceneTarget(_) => Goal::SceneTarget(rounded),
        _ => Goal::SceneOffset(rounded),
    };
    session.put_key(at, PinKey { goal, ..key });
}

/// Shows three numbers, along or about x, y and z; returns them if one is changed.
fn three(ui: &mut Ui, what: &str, (mut values, speed): ([f64; 3], f64)) -> Option<[f64; 3]> {
    let is_changed = ui
        .vertical(|ui| {
            let mut is_changed = false;
            for (value, axis) in values.iter_mut().zip(["x", "y", "z"]) {
                let name = &format!("{what} {axis}");
                let field = NumberField { name, hint: name, range: f64::MIN..=f64::MAX, decimals: 4 };
                is_changed |= field.drag(ui, value, |number| number.speed(speed).prefix(format!("{axis} ")));
            }
            is_changed
        })
        .inner;
    ui.end_row();
    is_changed.then_some(values)
}

fn region(ui: &mut Ui, session: &mut Session, (at, region): ([usize; 2], Option<PinRegion>)) {
    let mut has_region = region.is_some();
    ui.label("Region");
    let hint = "What moves with the pin, not its point alone; hold R and drag the pin to size it";
    if ui.checkbox(&mut has_region, "takes along").on_hover_text(hint).changed() {
        let radius = 0.1 * session.radius_per_height(at).unwrap_or(1.0);
        let usual = PinRegion { radius, rigidity: 1.0, stiffness: 1.0 };
        session.set_region(at, has_region.then_some(usual));
    }
    ui.end_row();
    let Some(old) = region else { return };
    let (mut new, lines) = (old, f64::from(session.shot().size.height));
    ui.label("Radius");
    let (unit, scale) = session.radius_unit(at).display(lines);
    let mut radius = old.radius * scale;
    let decimals = if scale == lines { 0 } else { 3 };
    let field = NumberField {
        name: "Radius",
        hint: "How far around the pin things move with it",
        range: 1e-5 * scale..=1e5 * scale,
        decimals,
    };
    let mut is_edited = field.drag(ui, &mut radius, |number| number.speed(scale / lines).suffix(unit));
    if is_edited {
        new.radius = radius / scale;
    }
    ui.end_row();
    ui.label("Rigidity");
    let field = NumberField {
        name: "Rigidity",
        hint: "1: the region moves as one piece; 0: it bends",
        range: 0.0..=1.0,
        decimals: 2,
    };
    is_edited |= field.slider(ui, &mut new.rigidity, |slider| slider);
    ui.end_row();
    ui.label("Stiffness");
    let field = NumberField {
        name: "Stiffness",
        hint: "How much the region resists bending; 1: as the rest",
        range: 0.001..=1000.0,
        decimals: 3,
    };
    is_edited |= field.slider(ui, &mut new.stiffness, |slider| slider.logarithmic(true));
    ui.end_row();
    if is_edited {
        session.set_region(at, Some(new));
    }
}

fn report(ui: &mut Ui, session: &mut Session) {
    ui.horizontal(|ui| {
        ui.strong("Report");
        ui.weak(format!("frame {}", session.playhead.frame()));
    });
    ui.separator();
    let Some(solve) = session.solve().cloned() else { return ui.weak("The frame is not solved yet.").into_inner() };
    if !solve.is_final {
        ui.weak("The report comes with the rendered frame.");
    } else if solve.report.layers.is_empty() {
        ui.weak("No layer is warped.");
    }
    let mut wanted = None;
    let [known, all] = session.reported();
    let hint = match known < all {
        true => format!("Go to the worst frame of those that are known: {known} of {all} frames so far"),
        false => "Go to the worst frame of those that are played".to_owned(),
    };
    for figure in Figure::ALL {
        let Some(here) = figure.of(&solve.report) else { continue };
        let row = vec2(ui.available_width(), ui.spacing().interact_size.y);
        // The number comes first, so that the name takes what is left.
        ui.allocate_ui_with_layout(row, Layout::right_to_left(Align::Center), |ui| {
            let button = ui.small_button("worst").on_hover_text(&hint);
            if button.accessible_name(format!("Worst frame by {}", figure.name())).clicked() {
                wanted = Some(figure);
            }
            let color = if figure.is_bad(here) { heat(3.0) } else { ui.visuals().text_color() };
            ui.label(RichText::new(format!("{here:.3}")).color(color).monospace());
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(Label::new(figure.name()).truncate()).on_hover_text(figure.explanation());
            });
        });
    }
    if known < all && solve.is_final {
        ui.weak(format!("Worst of {known} of {all} frames so far"));
    }
    if let Some(figure) = wanted {
        session.go_to_worst(figure);
    }
    for text in &solve.report.warnings {
        ui.add_space(4.0);
        ui.label(RichText::new(text).color(warning(ui)).size(12.0));
    }
}

fn warning(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(255, 190, 110) } else { Color32::from_rgb(150, 76, 0) }
}

/// Discards a response, so that a block may end with a widget.
trait IntoInner {
    fn into_inner(self);
}

impl IntoInner for egui::Response {
    fn into_inner(self) {}
}
