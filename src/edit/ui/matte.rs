//! Selection of the part of a plate that the selected layer moves.

use super::accessible::Accessible;
use super::name_field::NameField;
use crate::edit::{MatteChoice, Session};
use crate::shot::Layer;
use eframe::egui::{ComboBox, Ui};

/// Shows the list of kinds, and the names that some kinds require.
pub(super) fn show(ui: &mut Ui, session: &mut Session, layer: &Layer) {
    let Some(now) = MatteChoice::of(layer) else {
        ui.weak("as the shot file says");
        return;
    };
    let list = ComboBox::from_id_salt("matte").selected_text(name(&now)).width(120.0).show_ui(ui, |ui| {
        let kinds = [
            MatteChoice::Usual,
            MatteChoice::Nodes,
            MatteChoice::Picture,
            MatteChoice::Alpha,
            MatteChoice::Cryptomatte(vec!["*".into()]),
            MatteChoice::Channel("A".into()),
        ];
        for kind in kinds {
            let is_this = name(&kind) == name(&now);
            if ui.selectable_label(is_this, name(&kind)).clicked() && !is_this {
                session.set_matte(&kind);
            }
        }
    });
    list.response.explained("Matte", "The part of the plate that this layer moves");
    let Some((old, hint)) = words(&now) else { return };
    let field = NameField { name: "Names of the matte", hint, width: 120.0 };
    let typed = field.show(ui, session.selection.layer, &old);
    if let Some((_, text)) = typed.filter(|(layer, _)| *layer == session.selection.layer) {
        let names = || text.split(',').map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect();
        session.set_matte(&match now {
            MatteChoice::Channel(_) => MatteChoice::Channel(text.trim().to_owned()),
            _ => MatteChoice::Cryptomatte(names()),
        });
    }
}

const fn name(matte: &MatteChoice) -> &'static str {
    match matte {
        MatteChoice::Usual => "usual",
        MatteChoice::Nodes => "own nodes",
        MatteChoice::Picture => "whole picture",
        MatteChoice::Alpha => "alpha",
        MatteChoice::Channel(_) => "channel",
        MatteChoice::Cryptomatte(_) => "Cryptomatte",
    }
}

/// Returns the names of a kind that requires them, with a hint.
fn words(matte: &MatteChoice) -> Option<(String, &'static str)> {
    match matte {
        MatteChoice::Usual | MatteChoice::Nodes | MatteChoice::Picture | MatteChoice::Alpha => None,
        MatteChoice::Channel(name) => Some((name.clone(), "Full name of a channel: mask.R")),
        MatteChoice::Cryptomatte(names) => Some((names.join(", "), "Names with * and ?, with commas between them")),
    }
}
