//! A text field whose text counts once the field is left: names, which would be taken or invalid while they are typed.
//!
//! In: what is named, its name. Out: the typed name, with what it belongs to.

use eframe::egui::{Context, Id, Key, TextEdit, Ui};

/// A field, by its accessible name.
pub(super) struct NameField {
    pub(super) name: &'static str,
    pub(super) hint: &'static str,
    pub(super) width: f32,
}

/// What is typed, and what it is the name of.
#[derive(Clone)]
struct Draft<T> {
    owner: T,
    old: String,
    text: String,
}

impl<T> Draft<T> {
    /// Returns a changed name with its owner.
    fn changed(self) -> Option<(T, String)> {
        (!self.text.trim().is_empty() && self.text != self.old).then_some((self.owner, self.text))
    }
}

impl NameField {
    /// Shows the field. Returns a new name and its owner once Enter is pressed or the field is left, except by Escape. The owner
    /// is that of the text, even if another one has been selected meanwhile.
    pub(super) fn show<T: Clone + Send + Sync + 'static>(
        &self,
        ui: &mut Ui,
        owner: T,
        old: &str,
    ) -> Option<(T, String)> {
        let id = self.id();
        let draft = ui.data(|data| data.get_temp::<Draft<T>>(id));
        let mut draft = draft.unwrap_or_else(|| Draft { owner, old: old.to_owned(), text: old.to_owned() });
        let field = TextEdit::singleline(&mut draft.text).id(id.with("text")).desired_width(self.width);
        let response = ui.add(field).on_hover_text(self.hint).accessible_name(self.name);
        let has_focus = ui.memory(|memory| memory.has_focus(response.id));
        // What the press selects is known only after this pass.
        let is_left_by_pen = has_focus && ui.input(|input| input.pointer.any_pressed()) && !response.contains_pointer();
        if has_focus && !is_left_by_pen {
            ui.data_mut(|data| data.insert_temp(id, draft));
            return None;
        }
        ui.data_mut(|data| data.remove::<Draft<T>>(id));
        if is_left_by_pen {
            response.surrender_focus();
            return draft.changed();
        }
        let is_given_up = ui.input(|input| input.key_pressed(Key::Escape));
        if response.lost_focus() && !is_given_up { draft.changed() } else { None }
    }

    /// Returns what was typed into a field that is not shown any more.
    pub(super) fn take_left<T: Clone + Send + Sync + 'static>(&self, ctx: &Context) -> Option<(T, String)> {
        let id = self.id();
        let draft = ctx.data(|data| data.get_temp::<Draft<T>>(id))?;
        ctx.data_mut(|data| data.remove::<Draft<T>>(id));
        draft.changed()
    }

    fn id(&self) -> Id {
        Id::unique(self.name)
    }
}
