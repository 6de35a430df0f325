//! Editing of the shot: frames, clip, hidden nodes.
//!
//! In: user commands. Out: one document change each.

use super::Session;
use crate::shot::edit::{Setting, put_setting};

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
