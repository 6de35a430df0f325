//! The space of a layer's lattice, and its fixed box.
//!
//! In: user commands, the marks of the frame. Out: one document change each.

use super::Session;
use crate::edit::layer_space::{Space, moved, needs_marks};
use crate::pipeline::LayerMarks;
use crate::shot::LayerSpace;
use crate::space::ScreenBox;

impl Session {
    /// Moves the selected layer's lattice from the screen into the scene, or back, and tells what could not be kept.
    pub(crate) fn set_space(&mut self, to: Space) {
        let index = self.selection.layer;
        let Some(layer) = self.document.shot().layers.get(index).filter(|layer| Space::of(layer.space) != to) else {
            return;
        };
        let refusal = match (self.document.shot().scene(), &layer.transfer) {
            (None, _) => Some("Only a scene has room for a lattice: this shot has pictures alone."),
            (Some(_), Some(_)) => Some("This layer takes its lattices from a file, which lie on the screen."),
            (Some(_), None) if needs_marks(layer, to) && !self.is_solve_current() => {
                Some("The frame is still being solved: change the space once it is shown.")
            }
            (Some(_), None) => None,
        };
        if let Some(refusal) = refusal {
            return self.say(refusal);
        }
        let name = layer.name.clone();
        let (text, dropped) = match moved((self.document.shot(), self.document.text()), index, to, self.marks_of(index))
        {
            Ok((text, dropped)) => (Ok(text), dropped),
            Err(error) => (Err(error), Vec::new()),
        };
        self.selection.handles.clear();
        self.selection.keys.clear();
        if !self.change("Change space", text, None) {
            return;
        }
        let place = if to == Space::Scene { "in the scene" } else { "on the screen" };
        let lies = format!("The lattice of '{name}' lies {place} now");
        self.say(match &dropped[..] {
            [] => format!("{lies}."),
            dropped => format!("{lies}. Not kept: {}. Undo brings them back.", dropped.join(", ")),
        });
    }

    /// Fixes the box of the selected layer's lattice where it is in this frame: on the screen, or in the scene along its axes.
    pub(crate) fn fix_box(&mut self) {
        if !self.is_solve_current() {
            return self.say("The frame is still being solved: fix the box once it is shown.");
        }
        let space = self.document.shot().layers.get(self.selection.layer).map(|layer| layer.space);
        let marks = self.marks_of(self.selection.layer);
        match space.zip(marks).and_then(|(space, marks)| corners(space, marks)) {
            Some(corners) => self.set_box(&corners),
            None => self.say("The box is not known in this frame: go to one in which the layer is seen."),
        }
    }

    /// Returns whether the marks are those of the current frame and document.
    fn is_solve_current(&self) -> bool {
        let here = (self.playhead.frame(), self.revision);
        self.current_solve.as_ref().is_some_and(|solve| (solve.frame, solve.revision) == here)
    }
}

/// Returns the corners of a lattice's rest box, as in the file.
fn corners(space: LayerSpace, marks: &LayerMarks) -> Option<Vec<f64>> {
    let (corners, unit) = match space {
        LayerSpace::Screen { .. } => {
            let ScreenBox { min, max } = marks.rest_box?.upright;
            (vec![min.0.x, min.0.y, max.0.x, max.0.y], 1.0)
        }
        LayerSpace::World { .. } => {
            let [low, high] = marks.scene_box?;
            let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(f64::MIN_POSITIVE, f64::max);
            // Models may be millimetres or kilometres long.
            ([low, high].concat(), 10.0_f64.powi(longest.log10().floor() as i32))
        }
    };
    let digits = 1e4 / unit;
    Some(corners.into_iter().map(|value| (value * digits).round() / digits).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shot::{Goal, Rotation, WorldBoxRule};

    const SCREEN: &str = "scene = 'a.glb' # mine
frames = { first = 1, last = 24 }

[[layer]]
name = 'a'
matte = 'nodes'
lattice = { dims = [6, 6], box = 'frame', cuts = [{ nodes = ['Arm'] }] } # coarse

  [[layer.pin]]
  name   = 'p'
  anchor = { node = 'n', triangle = 0, barycentric = [1.0, 0.0, 0.0] }
  keys   = [ { frame = 1, offset = [0.1, 0.2], rotate = 20 }, { frame = 9, offset = [0.3, 0.1] } ]

  [[layer.pin]]
  name   = 'q'
  anchor = { screen = [0.2, 0.5] }

  [[layer.pin]]
  name   = 'r'
  mirror = 'q'

  [[layer.handle]]
  index = [1, 2]
  keys  = [ { frame = 1, offset = [0.1, 0.0] } ]
";

    #[test]
    fn a_layer_moves_into_the_scene_in_one_step_and_tells_what_is_lost() {
        let mut session = Session::of_text(SCREEN);
        session.set_space(Space::Scene);
        let layer = session.document().shot().layers[0].clone();
        assert_eq!(layer.space.dims(), [5, 5, 5], "{:?}", session.message());
        assert!(matches!(layer.space, LayerSpace::World { .. }) && layer.handles.is_empty());
        assert_eq!(layer.connectivity.cuts.len(), 1, "cuts act as before");
        assert_eq!(layer.pins, Session::of_text(SCREEN).document().shot().layers[0].pins[..1]);
        let told = session.message().unwrap_or_default().to_owned();
        for what in ["1 moved handle", "the box of the whole frame", "the matte", "pins 'q', 'r'"] {
            assert!(told.contains(what), "{told}");
        }
        assert_eq!(session.document().history().labels().collect::<Vec<_>>(), ["Change space"]);
        assert!(session.document().text().contains("# mine") && session.document().text().contains("# coarse"));
        session.undo();
        assert_eq!(session.document().text(), SCREEN);
    }

    #[test]
    fn what_has_three_axes_is_told_when_a_layer_moves_to_the_screen() {
        let text = "scene = 'a.glb'
frames = { first = 1, last = 24 }
[[layer]]
name = 'a'
lattice = { space = 'world', dims = [4, 4, 4], box = { fixed = [0, 0, 0, 1, 1, 1] } }
[[layer.pin]]
name = 'p'
anchor = { node = 'n', triangle = 0, barycentric = [1.0, 0.0, 0.0] }
keys = [ { frame = 1, target = [0.1, 0.2, 0.3], rotate = [1, 2, 3] }, { frame = 9, target = [1, 1, 1] } ]
[[layer.pin]]
name = 'q'
anchor = { node = 'n', triangle = 0, barycentric = [1.0, 0.0, 0.0] }
keys = [ { frame = 1, offset = [0.1, 0.2], rotate = 30 } ]
";
        let mut session = Session::of_text(text);
        session.set_space(Space::Screen);
        let layer = session.document().shot().layers[0].clone();
        assert_eq!(layer.space.dims(), [10, 10, 1], "{:?}", session.message());
        let [p, q] = [&layer.pins[0], &layer.pins[1]];
        assert_eq!((p.keys.len(), p.keys[0].goal), (1, Goal::Offset(crate::space::ScreenVector::default())));
        assert_eq!((p.keys[0].rotate_degrees, q.keys[0].rotate_degrees), (None, Some(Rotation::InView(30.0))));
        let told = session.message().unwrap_or_default();
        for what in ["the fixed box", "the keys of pin 'p'", "the rotation of pin 'p'"] {
            assert!(told.contains(what), "{told}");
        }
        assert!(!told.contains("'q'"), "{told}");
        session.undo();
        assert_eq!(session.document().text(), text);
    }

    #[test]
    fn a_box_that_is_fixed_in_the_scene_follows_no_node() {
        let mut session = Session::of_text(
            "scene = 'a.glb'\nframes = { first = 1, last = 24 }\n[[layer]]\nname = 'a'\n\
             lattice = { space = 'world', dims = [4, 4, 4], frame = { node = 'Spine' } }\n",
        );
        session.set_box(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
        let layer = &session.document().shot().layers[0];
        let fixed = WorldBoxRule::Fixed([[0.0; 3], [1.0, 2.0, 3.0]]);
        assert_eq!(layer.space, LayerSpace::World { dims: [4; 3], bounds: fixed }, "{:?}", session.message());
        assert_eq!(layer.orientation.node, None);
    }

    #[test]
    fn layers_that_have_no_place_in_the_scene_stay_as_they_are() {
        let plate = "plate = 'p.exr'\nsize = [9, 9]\nframes = { first = 1, last = 2 }\n[[layer]]\nname = 'a'\n";
        let region = SCREEN.replacen("name   = 'p'", "name   = 'p'\n  region = { radius = 0.1, rigidity = 1.0 }", 1);
        for (text, words) in [(plate, "Only a scene"), (&region, "still being solved")] {
            let mut session = Session::of_text(text);
            session.set_space(Space::Scene);
            assert!(session.message().is_some_and(|told| told.contains(words)), "{:?}", session.message());
            assert_eq!(session.document().text(), text);
        }
    }
}
