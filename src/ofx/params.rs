//! The table of parameters: the source of the descriptors, of the values read back and of `docs/OPENFX.md`.
//!
//! In: nothing. Out: [`table`], in display order. Ids are stored in projects: never rename one.

use super::api::names::param;
use crate::live::{Basis, LatticeStyle};
use crate::plate::Filter;
use std::ffi::CStr;
use std::sync::LazyLock;

/// Number of pins per instance.
pub(super) const PINS: usize = 32;

/// The type of a parameter, with its default and limits.
#[derive(Clone, Debug)]
pub(super) enum ParamKind {
    /// A group of the parameters that name it; 1: shown open.
    Group(i32),
    /// An integer: default, range, slider range.
    Integer(i32, [i32; 2], [i32; 2]),
    /// A double: default, range, slider range, meaning.
    Double(f64, [f64; 2], [f64; 2], &'static CStr),
    /// A checkbox; 1: checked.
    Toggle(i32),
    /// A choice of options; the first is the default.
    Choice(&'static [&'static str]),
    /// A position in the host's coordinates.
    Point,
    /// A line of text or a path.
    Text(&'static CStr),
    /// A push button.
    Button,
}

/// A parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub(super) id: String,
    pub(super) label: String,
    pub(super) hint: &'static str,
    pub(super) kind: ParamKind,
    /// Id of its group; empty if none.
    pub(super) group: String,
    /// Whether it can be animated (if the host supports it for its type).
    pub(super) animates: bool,
}

/// The source of the shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ShapeFrom {
    Frame,
    Alpha,
    Shot,
}

/// How the overlay draws the lattice.
pub(super) const OVERLAYS: Options<LatticeStyle, 3> = [
    ("Lattice", LatticeStyle::Plain),
    ("Lattice, coloured by stretch", LatticeStyle::Stretch),
    ("Pins only", LatticeStyle::Hidden),
];

/// What a drag in the viewer moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Handles {
    Targets,
    Pins,
}

/// Options of a choice, indexed by the numbers that hosts store: label and meaning.
pub(super) type Options<T, const N: usize> = [(&'static str, T); N];

/// Options of `shape`.
pub(super) const SHAPES: Options<ShapeFrom, 3> =
    [("Whole frame", ShapeFrom::Frame), ("Source alpha", ShapeFrom::Alpha), ("Shot file", ShapeFrom::Shot)];
/// Options of `basis`.
pub(super) const BASES: Options<Basis, 4> = [
    ("B-spline", Basis::Bspline),
    ("Bernstein", Basis::Bernstein),
    ("Bilinear", Basis::Bilinear),
    ("Triangles", Basis::Barytri),
];
/// Options of `filter`.
pub(super) const FILTERS: Options<Filter, 4> =
    [("Cubic", Filter::Cubic), ("EWA", Filter::Ewa), ("Lanczos", Filter::Lanczos), ("Nearest", Filter::Nearest)];
/// Options of `handles`.
pub(super) const HANDLES: Options<Handles, 2> =
    [("Targets", Handles::Targets), ("Pins with their targets", Handles::Pins)];

/// Returns the labels of the options.
const fn words<T, const N: usize>(options: &Options<T, N>) -> [&'static str; N] {
    let mut words = [""; N];
    let mut number = 0;
    while number < N {
        words[number] = options[number].0;
        number += 1;
    }
    words
}

/// Returns the number that hosts store for a meaning.
pub(super) fn number_of<T: PartialEq, const N: usize>(options: &Options<T, N>, meaning: T) -> i32 {
    options.iter().position(|(_, option)| *option == meaning).unwrap_or(0) as i32
}

/// Group, id, label, kind, hint.
type Row = (&'static str, &'static str, &'static str, ParamKind, &'static str);

/// All parameters except those of the pins.
#[rustfmt::skip]
const ROWS: &[Row] = &[
    ("", "lattice", "Lattice", ParamKind::Group(1), "What bends, and how stiffly."),
    ("lattice", "shape", "Shape from", ParamKind::Choice(&words(&SHAPES)),
     "What keeps its shape. Whole frame: everything. Source alpha: what the picture's alpha shows. Shot file: the animated model of a shot; lattice and pins follow it."),
    ("lattice", "columns", "Columns", ParamKind::Integer(10, [2, 64], [4, 24]),
     "Handles of the lattice from left to right; B-splines need 4."),
    ("lattice", "rows", "Rows", ParamKind::Integer(10, [2, 64], [4, 24]),
     "Handles of the lattice from bottom to top; B-splines need 4."),
    ("lattice", "basis", "Basis", ParamKind::Choice(&words(&BASES)),
     "How handles are blended: softly and locally, softly over all, or in flat cells."),
    ("lattice", "smoothness", "Smoothness", ParamKind::Double(1.0, [0.1, 10.0], [0.1, 10.0], param::DOUBLE_SCALE),
     "More: a pin takes more of the picture along. Less: its pull stays near it."),
    ("lattice", "strength", "Strength", ParamKind::Double(1.0, [-10.0, 10.0], [0.0, 1.0], param::DOUBLE_SCALE),
     "Scales all offsets and rotations; 0 is no warp."),
    ("lattice", "holdBorder", "Hold the border", ParamKind::Toggle(1),
     "The border of the frame stays where it is, so that a background neither slides nor tears; nothing folds, whatever the pins ask for. It gives way only to pins that are dragged to it or past it, with a message. Off: everything is free, for elements with alpha. With the shape from the source's alpha nothing is held."),
    ("lattice", "guard", "Stop before folds", ParamKind::Toggle(0),
     "The picture does not fold over: it bends around the place, and pins that would need too much force give way. Off: folds are warned of; with a shot file, as its layer says."),
    ("lattice", "filter", "Filter", ParamKind::Choice(&words(&FILTERS)),
     "How colour is sampled. Cubic is sharp and quick. EWA neither rings nor flickers where the warp shrinks, and takes three times as long. Nearest keeps exact values."),
    ("", "pins", "Pins", ParamKind::Group(1), "Points of the picture and where they go."),
    ("pins", "handles", "Handles move", ParamKind::Choice(&words(&HANDLES)),
     "What dragging in the viewer does: it moves targets, or puts pins elsewhere with their targets."),
    ("pins", "clickAdds", "Click adds a pin", ParamKind::Toggle(1),
     "A click in the viewer where there is no pin puts the first free pin there, switched on."),
    ("pins", "overlay", "Viewer shows", ParamKind::Choice(&words(&OVERLAYS)),
     "The warped lattice, red where it folds over; or coloured, blue where it shrinks and orange where it stretches; or pins alone."),
    ("pins", "selected", "Selected pin", ParamKind::Integer(0, [0, PINS as i32], [0, PINS as i32]),
     "Number of the pin that the buttons act on while none is selected in the viewer; 0: none."),
    ("pins", "previousPin", "Previous pin", ParamKind::Button, "Selects the pin before; in the viewer the key [."),
    ("pins", "nextPin", "Next pin", ParamKind::Button, "Selects the next pin; in the viewer the key ]."),
    ("pins", "resetPins", "Reset pins", ParamKind::Button,
     "Brings the targets of the selected pins back to their pins, without rotation; in the viewer the key R."),
    ("pins", "restToTargets", "Copy targets to pins", ParamKind::Button,
     "Puts the selected pins, else all, where their targets are: from there on they hold the picture as it is."),
    ("pins", "deletePins", "Delete pins", ParamKind::Button,
     "Switches the selected pins off and forgets their places and keys; in the viewer Delete or Backspace."),
    ("pins", "clearPins", "Clear all pins", ParamKind::Button, "Deletes every pin; one step to undo."),
    ("", "rendering", "Rendering", ParamKind::Group(0), "Motion blur, and how much of the warp is seen."),
    ("rendering", "mix", "Mix", ParamKind::Double(1.0, [0.0, 1.0], [0.0, 1.0], param::DOUBLE_SCALE),
     "0: the source as it came. 1: the warped picture."),
    ("rendering", "blurSamples", "Motion blur samples", ParamKind::Integer(1, [1, 64], [1, 32]),
     "Warps per frame that are averaged while the shutter is open; 1: no motion blur. The source itself is not blurred."),
    ("rendering", "shutter", "Shutter angle", ParamKind::Double(180.0, [0.0, 720.0], [0.0, 360.0], param::DOUBLE_ANGLE),
     "How long the shutter is open; 360 degrees are a frame."),
    ("rendering", "shutterPhase", "Shutter phase",
     ParamKind::Double(-90.0, [-360.0, 360.0], [-180.0, 180.0], param::DOUBLE_ANGLE),
     "When it opens, from the frame on; minus half the angle centres it."),
    ("", "shot", "Shot file", ParamKind::Group(0), "A pinwarp shot whose model the lattice follows."),
    ("shot", "shotFile", "Shot file", ParamKind::Text(param::STRING_FILE_PATH), "The .toml file of the shot."),
    ("shot", "camera", "Camera", ParamKind::Text(param::STRING_SINGLE_LINE), "Name of the camera; empty: the shot's own."),
    ("shot", "layer", "Layer", ParamKind::Text(param::STRING_SINGLE_LINE),
     "Layer that the pins belong to; empty: the first on the screen."),
    ("shot", "frameOffset", "Frame offset", ParamKind::Integer(0, [-1_000_000, 1_000_000], [-100, 100]),
     "Frame of the shot less frame of the host."),
    ("shot", "pinFrame", "Pins placed at", ParamKind::Integer(1, [-1_000_000, 1_000_000], [1, 200]),
     "Frame of the shot in which the pins were put on the model; from there they follow it."),
    ("shot", "shotPins", "Shot's own pins act", ParamKind::Toggle(1),
     "Pins that are in the file act beside those below. Reading the shot switches this off."),
    ("shot", "readShot", "Read the shot", ParamKind::Button,
     "Takes lattice, filter, pins and their keys from the shot file; one step to undo."),
    ("shot", "writePath", "Write to", ParamKind::Text(param::STRING_FILE_PATH),
     "Where a shot file is written; never the file that is read."),
    ("shot", "writeShot", "Write a shot", ParamKind::Button,
     "Writes lattice, filter, pins and their keys as a shot file for `pinwarp`. In a new file, name your picture; between keys every frame gets one."),
    ("shot", "stmapFolder", "STMaps folder", ParamKind::Text(param::STRING_DIRECTORY_PATH),
     "The folder that STMaps are written to."),
    ("shot", "stmapName", "STMaps name", ParamKind::Text(param::STRING_SINGLE_LINE),
     "Their name without number and ending; empty: stmap."),
    ("shot", "stmapPadding", "STMaps padding", ParamKind::Integer(4, [1, 9], [1, 9]),
     "Digits of the frame number: 4 writes stmap.0001.exr."),
    ("shot", "stmapPath", "STMaps pattern", ParamKind::Text(param::STRING_FILE_PATH),
     "Instead of a folder: a path with #### for the frame. Some hosts, as Natron, put the number in themselves; use the folder there."),
    ("shot", "writeStmaps", "Write STMaps", ParamKind::Button,
     "Writes the map of every frame of the source as a 32-bit EXR."),
];

/// The parameters of each pin: id suffix, label, kind, hint.
#[rustfmt::skip]
const PIN_ROWS: &[(&str, &str, ParamKind, &str)] = &[
    ("On", "On", ParamKind::Toggle(0), "The pin acts. Switched on for the first time it comes to the middle of the frame; one that lies in the corner with its target (0, 0) does nothing."),
    ("Rest", "Pin", ParamKind::Point, "The point of the picture that is held, before the warp."),
    ("Target", "Target", ParamKind::Point,
     "Where that point goes; with a shot file the difference to the pin is added to wherever the point is."),
    ("Turns", "Holds a rotation", ParamKind::Toggle(0), "The pin turns what is around it."),
    ("Angle", "Rotation", ParamKind::Double(0.0, [-36_000.0, 36_000.0], [-180.0, 180.0], param::DOUBLE_ANGLE),
     "Degrees, counter-clockwise; more than a turn is allowed."),
    ("Weight", "Weight", ParamKind::Double(1.0, [0.0, 1.0], [0.0, 1.0], param::DOUBLE_SCALE),
     "How much the pin pulls against the shape and other pins; 1 holds it exactly."),
    ("Radius", "Radius", ParamKind::Double(0.0, [0.0, 1e5], [0.0, 500.0], param::DOUBLE_PLAIN),
     "Pixels around the pin that it takes along; 0: its point alone."),
    ("Rigidity", "Rigidity", ParamKind::Double(1.0, [0.0, 1.0], [0.0, 1.0], param::DOUBLE_SCALE),
     "How firmly what lies within the radius moves with the pin as one piece."),
    ("Stiffness", "Stiffness", ParamKind::Double(1.0, [0.01, 100.0], [0.1, 10.0], param::DOUBLE_SCALE),
     "How stiff the picture is at the pin, fading out to the radius; 1: as everywhere."),
    ("Name", "Name", ParamKind::Text(param::STRING_SINGLE_LINE), "The pin's name in shot files; empty: its number."),
];

/// Returns the id of a parameter of a pin, counted from 0; with an empty suffix, that of its group.
pub(super) fn pin_id(pin: usize, suffix: &str) -> String {
    format!("pin{}{suffix}", pin + 1)
}

impl ParamKind {
    /// Returns the API's type.
    pub(super) const fn type_name(&self) -> &'static CStr {
        match self {
            Self::Group(_) => param::TYPE_GROUP,
            Self::Integer(..) => param::TYPE_INTEGER,
            Self::Double(..) => param::TYPE_DOUBLE,
            Self::Toggle(_) => param::TYPE_BOOLEAN,
            Self::Choice(_) => param::TYPE_CHOICE,
            Self::Point => param::TYPE_DOUBLE_2D,
            Self::Text(_) => param::TYPE_STRING,
            Self::Button => param::TYPE_PUSH_BUTTON,
        }
    }
}

/// Returns increment and digits of a double of this meaning.
pub(super) fn precision(meaning: &CStr) -> (f64, i32) {
    if meaning == param::DOUBLE_SCALE { (0.01, 3) } else { (1.0, 2) }
}

/// Pins per page of parameters, for hosts that show pages.
const PINS_A_PAGE: usize = 8;

/// Returns the pages for hosts that show them: id, label, parameters.
pub(super) fn pages() -> Vec<(String, String, Vec<&'static str>)> {
    let has_value = |param: &&Param| !matches!(param.kind, ParamKind::Group(_));
    let ids = |is_on: &dyn Fn(&str) -> bool| {
        table().iter().filter(has_value).filter(|param| is_on(&param.group)).map(|param| param.id.as_str()).collect()
    };
    let fixed = [("lattice", "Lattice"), ("pins", "Pins"), ("rendering", "Rendering"), ("shot", "Shot file")];
    let fixed = fixed.map(|(id, label)| (format!("{id}Page"), label.to_owned(), ids(&|group| group == id)));
    let of_pins = (0..PINS).step_by(PINS_A_PAGE).map(|first| {
        let last = (first + PINS_A_PAGE).min(PINS);
        let groups: Vec<String> = (first..last).map(|pin| pin_id(pin, "")).collect();
        let label = format!("Pins {} to {last}", first + 1);
        (format!("pins{}Page", first + 1), label, ids(&|group| groups.iter().any(|of| of == group)))
    });
    fixed.into_iter().chain(of_pins).collect()
}

/// Returns all parameters in display order.
pub(super) fn table() -> &'static [Param] {
    static TABLE: LazyLock<Vec<Param>> = LazyLock::new(|| {
        let fixed = ROWS.iter().map(|(group, id, label, kind, hint)| Param {
            id: (*id).into(),
            label: (*label).into(),
            hint,
            kind: kind.clone(),
            group: (*group).into(),
            animates: matches!(*id, "strength" | "smoothness" | "mix"),
        });
        fixed.chain((0..PINS).flat_map(pin)).collect()
    });
    &TABLE
}

fn pin(index: usize) -> impl Iterator<Item = Param> {
    let group = Param {
        id: pin_id(index, ""),
        label: format!("Pin {}", index + 1),
        hint: "A pin.",
        kind: ParamKind::Group(0),
        group: "pins".into(),
        animates: false,
    };
    let rows = PIN_ROWS.iter().map(move |(suffix, label, kind, hint)| Param {
        id: pin_id(index, suffix),
        label: format!("{label} {}", index + 1),
        hint,
        kind: kind.clone(),
        group: pin_id(index, ""),
        animates: !matches!(kind, ParamKind::Text(_)),
    });
    std::iter::once(group).chain(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fmt::Write;

    /// Returns the table as in the manual; the first pin stands for all.
    fn manual() -> String {
        let mut text = String::from("| parameter | id | default | what it does |\n|---|---|---|---|\n");
        let is_shown = |param: &&Param| {
            let of_pin =
                |id: &str| id.strip_prefix("pin").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
            let is_first = param.id == "pin1" || param.group == "pin1";
            is_first || !of_pin(&param.id)
        };
        for param in table().iter().filter(is_shown) {
            let default = match &param.kind {
                ParamKind::Group(_) => {
                    let _ = writeln!(text, "| **{}** | | | {} |", param.label, param.hint);
                    continue;
                }
                ParamKind::Integer(default, [least, most], _) => format!("{default} ({least} to {most})"),
                ParamKind::Double(default, [least, most], ..) => format!("{default} ({least} to {most})"),
                ParamKind::Toggle(default) => ["off", "on"][*default as usize].into(),
                ParamKind::Choice(options) => options.join(", "),
                ParamKind::Point => "0, 0".into(),
                ParamKind::Text(_) | ParamKind::Button => String::new(),
            };
            let _ = writeln!(text, "| {} | `{}` | {default} | {} |", param.label, param.id, param.hint);
        }
        text
    }

    #[test]
    fn ids_are_unique_and_groups_come_before_their_parameters() {
        let mut seen = BTreeSet::new();
        for param in table() {
            assert!(param.group.is_empty() || seen.contains(&param.group), "{}: its group comes later", param.id);
            assert!(param.id.is_ascii() && seen.insert(param.id.clone()), "{} is there twice", param.id);
        }
    }

    #[test]
    fn the_manual_has_the_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/OPENFX.md");
        let page = std::fs::read_to_string(path).expect("the manual is part of the repository");
        let (before, rest) = page.split_once("<!-- parameters -->\n").expect("the manual marks its table");
        let (shown, after) = rest.split_once("<!-- end of parameters -->").expect("and the table's end");
        if std::env::var_os("UPDATE").is_some() {
            let page = format!("{before}<!-- parameters -->\n{}<!-- end of parameters -->{after}", manual());
            std::fs::write(path, page).expect("the manual can be written");
        } else {
            assert_eq!(shown, manual(), "run `UPDATE=1 cargo test --features ofx --lib ofx::params`");
        }
    }
}
