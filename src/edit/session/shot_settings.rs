//! Editing of the shot: frames, clip, plate, hidden nodes.
//!
//! In: user commands. Out: one document change each.

use super::Session;
use crate::edit::dropped::sequence_around;
use crate::files::located;
use crate::shot::edit::{Setting, put_setting};
use std::path::Path;

impl Session {
    /// Sets a value of the shot.
    pub(crate) fn set_shot(&mut self, label: &str, key: &[&str], setting: &Setting, series: Option<&str>) {
        let text = put_setting(self.document.text(), key, setting);
        self.change(label, text, series);
    }

    /// Sets the first and last frame. A range over which frames are solved together grows with them.
    pub(crate) fn set_frames(&mut self, [first, last]: [i32; 2]) {
        let (shot, text) = (self.document.shot(), self.document.text());
        let (old, [from, to]) = (shot.frames, shot.solve_range);
        let put = |text: String, key: &[&str], setting: &Setting| put_setting(&text, key, setting);
        let has_range = put(text.to_owned(), &["solve_range"], &Setting::Default).is_ok_and(|without| without != text);
        let mut new = Ok(text.to_owned());
        let mut range = [from, to];
        if first != old.first {
            range[0] = from.min(first);
            new = new.and_then(|text| put(text, &["frames", "first"], &Setting::Whole(first.into())));
        }
        if last != old.last {
            range[1] = to.max(last);
            new = new.and_then(|text| put(text, &["frames", "last"], &Setting::Whole(last.into())));
        }
        if has_range && range != [from, to] {
            let range = Setting::Wholes(range.map(i64::from).to_vec());
            new = new.and_then(|text| put(text, &["solve_range"], &range));
        }
        self.change("Change frames", new, Some("frames"));
    }

    /// Sets the finished frames that belong to the shot: a path with a frame counter, or one picture; `None`: there are none.
    pub(crate) fn set_plate(&mut self, path: Option<&Path>) {
        let folder = self.document.path().parent().unwrap_or(Path::new(""));
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        let file = path.map(located);
        let setting = match file.as_deref().map(|file| file.strip_prefix(&folder).unwrap_or(file).to_str()) {
            None => Setting::Default,
            Some(Some(name)) => Setting::Text(if cfg!(windows) { name.replace('\\', "/") } else { name.to_owned() }),
            Some(None) => return self.say("The name of this plate is not valid Unicode: rename it."),
        };
        let label = if path.is_some() { "Choose plate" } else { "Remove plate" };
        self.set_shot(label, &["plate"], &setting, None);
    }

    /// Sets the finished frames from one picture that was chosen: if it is one of a sequence, all of them.
    pub(crate) fn choose_plate(&mut self, path: &Path) {
        let Some((sequence, count)) = sequence_around(path) else { return self.set_plate(Some(path)) };
        self.set_plate(Some(&sequence));
        if self.document.shot().plate.as_deref().and_then(Path::file_name) == sequence.file_name() {
            let name = sequence.file_name().unwrap_or_default().to_string_lossy();
            self.say(format!(
                "The plate is the sequence of {count} pictures, {name}. For the same picture in all frames, write its name into the shot file."
            ));
        }
    }

    /// Selects a clip of the scene, and sets the frame range to its length.
    pub(crate) fn choose_clip(&mut self, name: &str, secs: f64) {
        let frames = &self.document.shot().frames;
        let last = i64::from(frames.first) + (secs * frames.rate).round().max(0.0) as i64;
        let range = Setting::Wholes(vec![i64::from(frames.first), last]);
        let text = put_setting(self.document.text(), &["frames", "clip"], &Setting::Text(name.to_owned()))
            .and_then(|text| put_setting(&text, &["frames", "last"], &Setting::Whole(last)))
            .and_then(|text| put_setting(&text, &["solve_range"], &range));
        self.change("Choose clip", text, None);
    }

    /// Hides or shows a node.
    pub(crate) fn toggle_node(&mut self, name: &str) {
        let nodes = &self.loaded.nodes;
        let is_hidden = |node: &&(String, bool)| (node.0 == name) != node.1;
        let hidden: Vec<String> = nodes.iter().filter(is_hidden).map(|(name, _)| name.clone()).collect();
        let setting = if hidden.is_empty() { Setting::Default } else { Setting::Texts(hidden) };
        let text = put_setting(self.document.text(), &["hide"], &setting)
            .and_then(|text| put_setting(&text, &["show"], &Setting::Default));
        self.change("Hide or show", text, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plate_is_named_from_the_folder_of_the_shot() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path().canonicalize().expect("there");
        std::fs::create_dir(root.join("plates")).expect("made");
        let text = "scene = 'a.glb' # mine\nframes = { first = 1, last = 24 }\n";
        let document = crate::edit::Document::new(&root.join("shot.toml"), text.to_owned()).expect("a shot");
        let mut session = Session::new(document, crate::raster::DeviceChoice::Cpu, || ());
        session.set_plate(Some(&root.join("plates/p.####.exr")));
        assert!(session.document().text().contains("plate = \"plates/p.####.exr\""), "{}", session.document().text());
        assert_eq!(session.shot().plate, Some(root.join("plates/p.####.exr")));
        session.set_plate(None);
        assert_eq!(session.document().text(), text);
        assert_eq!(session.document().history().labels().collect::<Vec<_>>(), ["Choose plate", "Remove plate"]);
        // Finished frames alone are the source of a shot, which cannot be without.
        let mut session = Session::of_text("plate = 'p.exr'\nsize = [9, 9]\nframes = { first = 1, last = 2 }\n");
        session.set_plate(None);
        assert!(session.shot().plate.is_some() && session.message().is_some());
    }

    #[test]
    fn one_picture_of_a_sequence_stands_for_all_of_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path().canonicalize().expect("there");
        for name in ["p.0001.png", "p.0002.png", "q.0001.png"] {
            std::fs::write(root.join(name), "").expect("written");
        }
        let text = "scene = 'a.glb'\nframes = { first = 1, last = 24 }\n";
        let document = crate::edit::Document::new(&root.join("shot.toml"), text.to_owned()).expect("a shot");
        let mut session = Session::new(document, crate::raster::DeviceChoice::Cpu, || ());
        session.choose_plate(&root.join("p.0002.png"));
        assert_eq!(session.shot().plate, Some(root.join("p.####.png")));
        assert!(session.message().is_some_and(|told| told.contains("sequence of 2 pictures, p.####.png")));
        session.choose_plate(&root.join("q.0001.png"));
        assert_eq!((session.shot().plate.clone(), session.message()), (Some(root.join("q.0001.png")), None));
    }

    #[test]
    fn frames_that_are_added_are_solved_with_the_others() {
        let text = "scene = 'a.glb'\nframes = { first = 1, last = 24 }\n";
        let mut session = Session::of_text(&format!("{text}solve_range = [1, 24]\n"));
        session.set_frames([1, 30]);
        assert_eq!(session.shot().solve_range, [1, 30]);
        session.set_frames([5, 20]);
        assert_eq!((session.shot().solve_range, session.shot().frames.last), ([1, 30], 20), "trimmed frames keep it");
        session.document_mut().end_series();
        session.set_frames([-3, 20]);
        assert_eq!(session.shot().solve_range, [-3, 30]);
        session.undo();
        assert_eq!(session.shot().solve_range, [1, 30], "undone at once");
        let mut session = Session::of_text(text);
        session.set_frames([1, 30]);
        assert!(!session.document().text().contains("solve_range"));
    }
}
