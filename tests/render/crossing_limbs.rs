//! Limbs of one branch that cross on the screen: one of them lies in front, all over the crossing and as long as it lasts.

use super::pictures::{SIZE, Wall, drawn};
use super::support::at;
use pinwarp::image::{Frame, read_exr};
use pinwarp::pipeline::{Event, PreparedShot, RenderOptions, render};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

/// Columns of the left and the right leg.
const LEGS: [std::ops::Range<f32>; 2] = [28.0..38.0, 58.0..68.0];

/// A body with two legs, and two ears so close to each other that the lattice branches.
fn body_and_legs(x: f32, y: f32) -> f32 {
    let is_ear = [(42.0..46.0), (50.0..54.0)].iter().any(|ear| ear.contains(&x)) && y < 6.0;
    let is_body = (24.0..72.0).contains(&x) && (4.0..16.0).contains(&y);
    let is_leg = LEGS.iter().any(|leg| leg.contains(&x)) && (4.0..60.0).contains(&y);
    f32::from(u8::from(is_body || is_leg || is_ear))
}

/// Pins: name, place, and how far it moves to the right in frames 1 and 2, pixels.
type Pins = [(&'static str, [f64; 2], [f64; 2]); 6];

/// In frame 1 the left leg moves further above, the right one below; in frame 2 the right one everywhere.
const PINS: Pins = [
    ("hips", [33.0, 8.0], [0.0, 0.0]),
    ("hip", [63.0, 8.0], [0.0, 0.0]),
    ("left thigh", [33.0, 31.0], [16.0, 12.0]),
    ("left knee", [33.0, 42.0], [15.0, 13.0]),
    ("right thigh", [63.0, 31.0], [-10.0, -14.0]),
    ("right knee", [63.0, 42.0], [-22.0, -22.0]),
];

/// Both legs are pulled equally far, the left one in frame 1 and the right one in frame 2.
const EQUAL_PINS: Pins = [
    ("hips", [33.0, 8.0], [0.0, 0.0]),
    ("hip", [63.0, 8.0], [0.0, 0.0]),
    ("left thigh", [33.0, 31.0], [20.0, 12.0]),
    ("left knee", [33.0, 42.0], [20.0, 12.0]),
    ("right thigh", [63.0, 31.0], [-12.0, -20.0]),
    ("right knee", [63.0, 42.0], [-12.0, -20.0]),
];

/// A weight that ties the frames of a layer.
const TEMPORAL: f64 = 0.1;

/// The first two frames, and the notes about layers. `order`: a line for a pin. `temporal`: 0 solves each frame alone.
fn frames(pins: Pins, temporal: f64, order: (&str, &str)) -> (Vec<Frame>, Vec<String>) {
    let wall = Wall::new();
    wall.hang("legs.exr", SIZE, drawn(SIZE, "", body_and_legs));
    let pin = |(name, [x, y], [first, second]): (&str, [f64; 2], [f64; 2])| {
        let (x, y, line) = (x / 64.0, 1.0 - y / 64.0, if name == order.0 { order.1 } else { "" });
        let key = |frame: i32, by: f64| format!("{{ frame = {frame}, offset = [{}, 0] }}", by / 64.0);
        format!(
            "[[layer.pin]]\nname = '{name}'\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\n{line}\nkeys = [{}, {}]\n",
            key(1, first),
            key(2, second)
        )
    };
    let text = format!(
        "version = 1\nimage = 'legs.exr'\nshutter = {{ angle = 0 }}\n[[layer]]\nname = 'walker'\nlattice = {{ dims = [24, 28] }}\n\
         solve = {{ temporal = {temporal} }}\n{}",
        pins.map(pin).concat()
    );
    let prepared = PreparedShot::new(wall.shot(&text)).expect("the picture is there");
    let options = RenderOptions { frames: vec![1, 2], ..RenderOptions::default() };
    let told = Mutex::new(Vec::new());
    let tell = |event: Event| {
        if let Event::FrameDone(report) = event {
            told.lock().expect("nobody panics").extend(report.notes.into_iter().map(|note| note.text));
        }
    };
    let summary = render(&prepared, &options, &AtomicBool::new(false), &tell).expect("it renders");
    assert_eq!(summary.failed, 0);
    let read = |frame: i32| read_exr(&wall.folder.path().join(format!("out/f.{frame:04}.exr"))).expect("written");
    ([1, 2].map(read).to_vec(), told.into_inner().expect("nobody panics"))
}

/// The leg that a pixel shows, by its colour, which is that of its column.
fn leg_at(frame: &Frame, x: i32, y: i32) -> Option<usize> {
    let red = LEGS.map(|leg| [leg.start, leg.end].map(|x| x * 0.02 - 0.3));
    let shown = at(frame, "R", x, y);
    (0..2).find(|&leg| at(frame, "A", x, y) > 0.99 && (red[leg][0] - 0.01..red[leg][1] + 0.01).contains(&shown))
}

/// Pixels that show the left leg if it is in front and the right one if that is, below the body.
fn crossing(left: &Frame, right: &Frame) -> Vec<(i32, i32)> {
    let pixels = (20..64).flat_map(|y| (0..96).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| leg_at(left, x, y) == Some(0) && leg_at(right, x, y) == Some(1)).collect()
}

#[test]
fn one_leg_is_in_front_all_over_a_crossing_and_in_all_frames() {
    let ordered = |pin: &str| frames(PINS, 0.0, (pin, "order = 1"));
    // A pin with an order decides for the whole crossing, also where other pins of its leg are nearer.
    let [(left, told_left), (right, told_right)] = ["left knee", "right knee"].map(ordered);
    let (chosen, told) = frames(PINS, 0.0, ("", ""));
    for frame in 0..2 {
        let crossing = crossing(&left[frame], &right[frame]);
        assert!(crossing.len() > 80, "frame {}: {} pixels cross", frame + 1, crossing.len());
        let shown = |leg: usize| crossing.iter().filter(|&&(x, y)| leg_at(&chosen[frame], x, y) == Some(leg)).count();
        // That whose pin goes furthest in the shot, by 22 pixels. A few pixels blend its border.
        let (left, right) = (shown(0), shown(1));
        assert!(
            left == 0 && 20 * right > 19 * crossing.len(),
            "frame {}: {left} {right} of {}",
            frame + 1,
            crossing.len()
        );
    }
    assert!(told_left.is_empty() && told_right.is_empty(), "{told_left:?} {told_right:?}");
    assert_eq!(told.len(), 2, "{told:?}");
    let wanted = "layer 'walker': the parts at pins 'right ";
    assert!(
        told.iter().all(|note| note.starts_with(wanted) && note.contains("'left ") && note.contains("`order`")),
        "{told:?}"
    );
}

#[test]
fn what_is_chosen_by_motion_lasts_as_long_as_the_crossing() {
    let ordered = |pin: &str| frames(EQUAL_PINS, TEMPORAL, (pin, "order = 1")).0;
    let [left, right] = ["left knee", "right knee"].map(ordered);
    let (chosen, _) = frames(EQUAL_PINS, TEMPORAL, ("", ""));
    let front = [0, 1].map(|frame| {
        let crossing = crossing(&left[frame], &right[frame]);
        assert!(crossing.len() > 40, "frame {}: {} pixels cross", frame + 1, crossing.len());
        let shown = |leg: usize| crossing.iter().filter(|&&(x, y)| leg_at(&chosen[frame], x, y) == Some(leg)).count();
        let shown = [shown(0), shown(1)];
        assert!(shown.contains(&0), "frame {}: {shown:?}", frame + 1);
        usize::from(shown[1] > shown[0])
    });
    assert_eq!(front[0], front[1], "the legs cross in both frames");
}
