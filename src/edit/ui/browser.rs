//! The file browser inside the editor's window, for opening and saving.

use super::accessible::Accessible;
use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::{self, Align, Align2, Key, Label, Layout, Response, RichText, ScrollArea, TextEdit, Ui, vec2};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The purpose of the file choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    Open,
    SaveAs,
    Plate,
    Reference,
}

/// Extensions of pictures that may form sequences.
const PICTURES: [&str; 4] = ["exr", "png", "jpg", "jpeg"];

/// Extensions of files that can be opened.
const KNOWN: [&str; 8] = ["toml", "glb", "gltf", "png", "jpg", "jpeg", "exr", "json"];

/// Extension of shots.
const SHOT: &str = "toml";

/// What can be opened.
const EVERYTHING: &str =
    "Shots (.toml), scenes (.glb, .gltf), pictures (.png, .jpg, .exr), plates: frame.####.exr, problems (.json)";

/// A file browser window.
pub(super) struct Browser {
    pub(super) purpose: Purpose,
    path: String,
    folder: PathBuf,
    entries: Vec<(String, bool)>,
    /// Whether the path gets the keyboard focus: it was just opened.
    is_new: bool,
}

/// The browser's result.
pub(super) enum Choice {
    /// Still open.
    None,
    Cancelled,
    File(PathBuf),
}

impl Browser {
    /// Opens the browser in the folder of a file.
    pub(super) fn new(purpose: Purpose, near: &Path) -> Self {
        let folder = if near.is_dir() { near } else { near.parent().unwrap_or(Path::new("")) };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        let path = match purpose {
            Purpose::SaveAs => folder.join(near.file_name().unwrap_or_default()),
            Purpose::Open | Purpose::Plate | Purpose::Reference => folder.clone(),
        };
        let path = path.to_string_lossy().into_owned();
        let mut browser = Self { purpose, path, folder, entries: Vec::new(), is_new: true };
        browser.list();
        browser
    }

    fn list(&mut self) {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let known = entries.filter_map(|entry| {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
            let known: &[&str] = match self.purpose {
                Purpose::Open => &KNOWN,
                Purpose::SaveAs => &[SHOT],
                Purpose::Plate | Purpose::Reference => &PICTURES,
            };
            let is_known = path.is_dir() || ending.is_some_and(|ending| known.contains(&ending.as_str()));
            (is_known && !name.starts_with('.')).then(|| (name, path.is_dir()))
        });
        self.entries = known.collect();
        let names: Vec<&str> =
            self.entries.iter().filter(|(_, is_folder)| !is_folder).map(|(name, _)| name.as_str()).collect();
        let sequences: Vec<(String, bool)> = sequences(&names).into_iter().map(|name| (name, false)).collect();
        self.entries.extend(sequences);
        self.entries.sort_by_key(|(name, is_folder)| (!is_folder, name.to_lowercase()));
    }

    pub(super) fn show(&mut self, ctx: &egui::Context) -> Choice {
        let (title, verb, kinds) = match self.purpose {
            Purpose::Open => ("Open", "Open", EVERYTHING),
            Purpose::SaveAs => ("Save as", "Save", "Shots (.toml)"),
            Purpose::Plate => (
                "Plate",
                "Use",
                "Finished frames: beauty.####.exr (.png, .jpg), all of them by any one, or one picture for all frames",
            ),
            Purpose::Reference => {
                ("Reference picture", "Lay over", "Pictures (.png, .jpg, .exr), sequences: draw.####.png")
            }
        };
        let mut choice = Choice::None;
        let window = egui::Window::new(title).collapsible(false).resizable(true).default_size(vec2(560.0, 420.0));
        window.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(ctx, |ui| {
            // The buttons come first, so that the path takes what is left.
            let row = vec2(ui.available_width(), ui.spacing().interact_size.y);
            ui.allocate_ui_with_layout(row, Layout::right_to_left(Align::Center), |ui| {
                if ui.button("Cancel").clicked() || ui.input(|input| input.key_pressed(Key::Escape)) {
                    choice = Choice::Cancelled;
                }
                let is_chosen = ui.button(verb).accessible("Choose").clicked();
                let response = self.path_field(ui);
                let is_entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                if is_chosen || is_entered {
                    choice = self.chosen();
                }
            });
            ui.add(Label::new(RichText::new(kinds).weak()).wrap());
            ui.separator();
            ScrollArea::vertical().auto_shrink(false).max_height(360.0).show(ui, |ui| {
                let mut entered = None;
                if let Some(above) = self.folder.parent()
                    && ui.selectable_label(false, "../").clicked()
                {
                    entered = Some(above.to_owned());
                }
                for (name, is_folder) in &self.entries {
                    let sign = if *is_folder { "/" } else { "" };
                    let response = ui.selectable_label(false, format!("{name}{sign}"));
                    let path = self.folder.join(name);
                    if response.clicked() && *is_folder {
                        entered = Some(path);
                    } else if self.purpose != Purpose::SaveAs && is_opened(&response, &path, &self.path) {
                        choice = Choice::File(path);
                    } else if response.clicked() {
                        self.path = path.to_string_lossy().into_owned();
                    }
                }
                if let Some(folder) = entered {
                    self.enter(folder);
                }
            });
        });
        choice
    }

    /// Shows the path. What another one differs in is selected at first, so that it can be typed at once.
    fn path_field(&mut self, ui: &mut Ui) -> Response {
        let mut field = TextEdit::singleline(&mut self.path).desired_width(ui.available_width()).show(ui);
        if std::mem::take(&mut self.is_new) {
            let [from, to] = typed_part(&self.path, self.purpose).map(CCursor::new);
            field.state.cursor.set_char_range(Some(CCursorRange::two(from, to)));
            field.state.store(ui.ctx(), field.response.id);
            field.response.request_focus();
        }
        field.response.response.accessible("Path")
    }

    fn enter(&mut self, folder: PathBuf) {
        let name = Path::new(&self.path).file_name().map(ToOwned::to_owned).filter(|_| self.purpose == Purpose::SaveAs);
        self.path = folder.join(name.unwrap_or_default()).to_string_lossy().into_owned();
        self.folder = folder;
        self.list();
    }

    fn chosen(&mut self) -> Choice {
        // What is typed without a folder means the one that is listed.
        let path = self.folder.join(self.path.trim());
        if path.is_dir() {
            self.enter(path);
            return Choice::None;
        }
        Choice::File(if self.purpose == Purpose::SaveAs { shot_path(path) } else { path })
    }
}

/// Returns whether a click opens an entry: a double click, or one on what is chosen already. In a slow window the clicks of a double click
/// are seen apart.
fn is_opened(response: &Response, path: &Path, chosen: &str) -> bool {
    response.double_clicked() || response.clicked() && Path::new(chosen) == path
}

/// Returns the part of a path, from letter to letter, that another one is typed over: of a shot the name without its ending.
fn typed_part(path: &str, purpose: Purpose) -> [usize; 2] {
    let count = |text: &str| text.chars().count();
    let name = Path::new(path).file_name().map_or(0, |name| count(&name.to_string_lossy()));
    let ending = Path::new(path).extension().map_or(0, |ending| count(&ending.to_string_lossy()) + 1);
    match purpose {
        Purpose::SaveAs => [count(path) - name, count(path) - ending],
        Purpose::Open | Purpose::Plate | Purpose::Reference => [0, count(path)],
    }
}

/// Returns a path with the ending of shots, so that no other file is overwritten.
fn shot_path(path: PathBuf) -> PathBuf {
    let is_shot = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(SHOT));
    if is_shot { path } else { path.with_added_extension(SHOT) }
}

/// Groups numbered files into sequences, each named by its pattern: `frame.####.exr`.
fn sequences(names: &[&str]) -> Vec<String> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for name in names {
        let Some((stem, ending)) = name.rsplit_once('.').filter(|(_, ending)| PICTURES.contains(ending)) else {
            continue;
        };
        let start = stem.trim_end_matches(|letter: char| letter.is_ascii_digit());
        let digits = stem.len() - start.len();
        if digits > 0 {
            *counts.entry(format!("{start}{}.{ending}", "#".repeat(digits))).or_default() += 1;
        }
    }
    counts.into_iter().filter(|(_, count)| *count > 1).map(|(pattern, _)| pattern).collect()
}

#[cfg(test)]
mod tests {
    use super::{Browser, Choice, Purpose, sequences, shot_path, typed_part};
    use std::path::{Path, PathBuf};

    #[test]
    fn only_shots_are_listed_and_chosen_to_be_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["hero.glb", "hero.png", "hero.toml"] {
            std::fs::write(folder.path().join(name), "").expect("written");
        }
        let mut browser = Browser::new(Purpose::SaveAs, &folder.path().join("hero.toml"));
        assert_eq!(browser.entries, [("hero.toml".to_owned(), false)]);
        browser.path = folder.path().join("hero.glb").display().to_string();
        let Choice::File(chosen) = browser.chosen() else { panic!("it is a file") };
        assert_eq!(chosen, folder.path().join("hero.glb.toml"));
        for (given, path) in [("a.toml", "a.toml"), ("a.TOML", "a.TOML"), ("a", "a.toml"), ("v1.2", "v1.2.toml")] {
            assert_eq!(shot_path(PathBuf::from(given)), Path::new(path));
        }
    }

    #[test]
    fn a_path_is_typed_over_and_of_a_shot_its_name_alone() {
        assert_eq!(typed_part("/a/b\u{e4}r", Purpose::Open), [0, 6]);
        assert_eq!(typed_part("/a/b\u{e4}r.toml", Purpose::SaveAs), [3, 6]);
        assert_eq!(typed_part("/a/b", Purpose::SaveAs), [3, 4]);
        let folder = tempfile::tempdir().expect("a folder");
        let mut browser = Browser::new(Purpose::Open, folder.path());
        browser.path = "hero.glb".into();
        let Choice::File(chosen) = browser.chosen() else { panic!("it is a file") };
        assert_eq!(
            chosen,
            folder.path().canonicalize().expect("there").join("hero.glb"),
            "a name in the listed folder"
        );
    }

    #[test]
    fn frames_of_one_name_are_a_sequence() {
        let names =
            ["a.0001.exr", "a.0002.exr", "a.0001.png", "b1.exr", "b2.exr", "b10.exr", "shot.toml", "c.exr", "7.glb"];
        assert_eq!(sequences(&names), ["a.####.exr", "b#.exr"]);
        assert!(sequences(&[]).is_empty());
    }
}
