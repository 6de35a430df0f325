//! The settings of a layer's lattice, and the nodes that it moves.

use super::accessible::Accessible;
use super::number_field::{NumberField, whole};
use crate::edit::{Session, Space};
use crate::lattice::Basis;
use crate::shot::edit::Setting;
use crate::shot::{BoxRule, Layer, LayerSpace, WorldBoxRule};
use crate::space::ScreenBox;
use eframe::egui::{Button, ComboBox, Popup, ScrollArea, Ui};

/// Shows the rows of the grid of settings.
pub(super) fn show(ui: &mut Ui, session: &mut Session, layer: &Layer) {
    if session.shot().scene().is_some() {
        ui.label("Space");
        space(ui, session, Space::of(layer.space));
        ui.end_row();
    }
    ui.label("Lattice");
    ui.horizontal(|ui| dims(ui, session, layer));
    ui.end_row();
    ui.label("Basis");
    basis(ui, session, layer.basis);
    ui.end_row();
    ui.label("Box");
    bounds(ui, session, layer.space);
    ui.end_row();
    corners(ui, session, layer.space);
    if !session.loaded().nodes.is_empty() && session.shot().scene().is_some() {
        ui.label("Nodes");
        nodes(ui, session, layer);
        ui.end_row();
    }
}

/// Chooses whether the lattice lies on the screen or in the scene.
fn space(ui: &mut Ui, session: &mut Session, now: Space) {
    let list = ComboBox::from_id_salt("space").selected_text(now.name()).width(110.0).show_ui(ui, |ui| {
        for (other, hint) in [
            (Space::Screen, "Bends the rendered picture; lighting and depth are unchanged"),
            (Space::Scene, "Bends the model itself, with its lighting and depth, for every camera"),
        ] {
            if ui.selectable_label(other == now, other.name()).on_hover_text(hint).clicked() {
                session.set_space(other);
            }
        }
    });
    let hint = "Where the lattice lies. On the screen it bends the picture, in the scene the model itself";
    list.response.explained("Space", hint);
}

fn dims(ui: &mut Ui, session: &mut Session, layer: &Layer) {
    if layer.has_auto_dims {
        let chosen = session.automatic_dims();
        ui.weak(chosen.map_or_else(|| "auto".to_owned(), |[columns, rows]| format!("auto: {columns} x {rows}")));
        let set = ui.add_enabled(chosen.is_some(), Button::new("set").small());
        if let Some(dims) = chosen
            && set.on_hover_text("Keep these numbers of handles, and type others").clicked()
        {
            session.set_dims(&dims);
        }
        return;
    }
    let names = ["Columns", "Rows", "Layers of handles"];
    let mut new = match layer.space {
        LayerSpace::Screen { dims, .. } => dims.to_vec(),
        LayerSpace::World { dims, .. } => dims.to_vec(),
    };
    let old = new.clone();
    for (count, name) in new.iter_mut().zip(names) {
        ui.add(whole(count, layer.basis.min_handles()..=64).speed(0.1)).accessible(name);
    }
    if new != old {
        session.set_dims(&new);
    }
    let can_be_auto = matches!(layer.space, LayerSpace::Screen { .. }) && layer.handles.is_empty();
    let hint = "Choose the numbers of handles by the thinnest parts of the layer";
    if can_be_auto && layer.basis.can_branch() && ui.small_button("auto").on_hover_text(hint).clicked() {
        session.set_layer("Resize lattice", &["lattice", "dims"], &Setting::Text("auto".into()), None);
    }
}

fn basis(ui: &mut Ui, session: &mut Session, basis: Basis) {
    let name = serde_json::to_value(basis).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default();
    let list = ComboBox::from_id_salt("basis").selected_text(&name).width(110.0).show_ui(ui, |ui| {
        for other in ["bspline", "bilinear", "bernstein", "barytri"] {
            if ui.selectable_label(other == name, other).clicked() {
                session.set_layer("Change basis", &["lattice", "basis"], &Setting::Text(other.into()), None);
            }
        }
    });
    let hint = "How handles pull what lies between them. bspline: smooth and local, the usual one; bilinear: straight within each \
                cell; bernstein: smooth, each handle pulls everything; barytri: straight within triangles";
    list.response.explained("Basis", hint);
}

fn bounds(ui: &mut Ui, session: &mut Session, space: LayerSpace) {
    let (now, offered): (&str, &[&str]) = match space {
        LayerSpace::Screen { bounds: BoxRule::Follow, .. } => ("follow", &["follow", "frame", "fixed"]),
        LayerSpace::Screen { bounds: BoxRule::Frame, .. } => ("frame", &["follow", "frame", "fixed"]),
        LayerSpace::Screen { bounds: BoxRule::Fixed(_), .. } => ("fixed", &["follow", "frame", "fixed"]),
        LayerSpace::World { bounds: WorldBoxRule::Follow, .. } => ("follow", &["follow", "fixed"]),
        LayerSpace::World { bounds: WorldBoxRule::Fixed(_), .. } => ("fixed", &["follow", "fixed"]),
    };
    let list = ComboBox::from_id_salt("box").selected_text(now).width(110.0).show_ui(ui, |ui| {
        for &other in offered {
            let is_chosen = ui.selectable_label(other == now, other).clicked() && other != now;
            if is_chosen && other == "fixed" {
                session.fix_box();
            } else if is_chosen {
                session.set_layer("Change box", &["lattice", "box"], &Setting::Text(other.into()), None);
            }
        }
    });
    let hint =
        "What the lattice covers. follow: the layer, as it moves; frame: the whole frame; fixed: what it covers now";
    list.response.explained("Box", hint);
}

/// Shows the corners of a box that is fixed, in pixels or in metres of the scene.
fn corners(ui: &mut Ui, session: &mut Session, space: LayerSpace) {
    let lines = f64::from(session.shot().size.height);
    let (mut corners, names, (scale, unit, decimals)) = match space {
        LayerSpace::Screen { bounds: BoxRule::Fixed(ScreenBox { min, max }), .. } => {
            let names = &["Box left", "Box bottom", "Box right", "Box top"][..];
            (vec![min.0.x, min.0.y, max.0.x, max.0.y], names, (lines, " px", 1))
        }
        LayerSpace::World { bounds: WorldBoxRule::Fixed(corners), .. } => {
            let names = &["Box x from", "Box y from", "Box z from", "Box x to", "Box y to", "Box z to"][..];
            (corners.concat(), names, (1.0, " m", 3))
        }
        _ => return,
    };
    let mut is_edited = false;
    ui.label("Corners");
    ui.vertical(|ui| {
        for (corners, names) in corners.chunks_mut(names.len() / 2).zip(names.chunks(names.len() / 2)) {
            ui.horizontal(|ui| {
                for (corner, name) in corners.iter_mut().zip(names) {
                    let field = NumberField { name, hint: name, range: f64::MIN..=f64::MAX, decimals };
                    let mut value = *corner * scale;
                    if field.drag(ui, &mut value, |number| number.speed(0.002 * scale).suffix(unit)) {
                        *corner = (value / scale * 1e6).round() / 1e6;
                        is_edited = true;
                    }
                }
            });
        }
    });
    ui.end_row();
    if is_edited {
        session.set_box(&corners);
    }
}

/// Shows the patterns of the layer, and all nodes to choose from.
fn nodes(ui: &mut Ui, session: &mut Session, layer: &Layer) {
    if layer.selection.is_rest {
        ui.weak("the rest");
        return;
    }
    let words = match &layer.nodes[..] {
        [] => "all".to_owned(),
        [only] => only.clone(),
        more => format!("{} and {} more", more[0], more.len() - 1),
    };
    let button =
        ui.add(Button::new(words).truncate()).explained("Nodes", "The parts of the scene that this layer moves");
    Popup::menu(&button).close_behavior(eframe::egui::PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        let mut names: Vec<String> = session.loaded().nodes.iter().map(|(name, _)| name.clone()).collect();
        let patterns = layer.nodes.iter().filter(|pattern| !names.contains(pattern)).cloned();
        names = patterns.chain(names.clone()).collect();
        ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
            for name in names {
                let mut is_in = layer.nodes.contains(&name);
                if ui.checkbox(&mut is_in, &name).changed() {
                    let mut nodes: Vec<String> = layer.nodes.iter().filter(|other| **other != name).cloned().collect();
                    if is_in {
                        nodes.push(name);
                    }
                    session.set_nodes(nodes);
                }
            }
        });
    });
}
