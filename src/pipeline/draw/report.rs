//! Reports the solves of a frame.
//!
//! In: a solved [`TimeSample`]. Out: a [`FrameReport`] with one entry per solved layer, and warnings as text.

use super::{overlaps, shared_cells};
use crate::pipeline::evaluate::lattice_box::screen_bounds;
use crate::pipeline::evaluate::topology::branching_remedy;
use crate::pipeline::trajectories::{TimedNote, note_at};
use crate::pipeline::{FrameReport, LayerReport, LayerState, PinState, PreparedShot, ScenePin, TimeSample};
use crate::shot::{Layer, LayerSpace};
use crate::solve::{Guard, ResidualReason, SolveReport, Spread};
use crate::spelling::pluralised;

/// Distance from its target above which a pin is reported, pixels.
const PIN_TOLERANCE_PX: f64 = 0.05;

/// Distance from its target above which a handle of a world layer is reported, metres.
const HANDLE_TOLERANCE_M: f64 = 5e-5;

/// Returns the report of the solves of a frame.
#[must_use]
pub fn report(prepared: &PreparedShot, frame: i32, sample: &TimeSample) -> FrameReport {
    report_of_layers(prepared, (frame, sample), |_| true)
}

/// Returns the report of the solves of those layers for which `includes_layer` is true.
pub(super) fn report_of_layers(
    prepared: &PreparedShot,
    (frame, sample): (i32, &TimeSample),
    includes_layer: impl Fn(usize) -> bool,
) -> FrameReport {
    let mut report = FrameReport { frame, ..FrameReport::default() };
    let height_px = f64::from(prepared.shot.size.height);
    let mesh = sample.mesh();
    let layers = prepared.shot.layers.iter().zip(&sample.layers).enumerate();
    for (index, (layer, state)) in layers.filter(|(index, _)| includes_layer(*index)) {
        let is_in_sight = screen_bounds(prepared, index, &sample.pose, &mesh, &sample.camera).is_some();
        if !is_in_sight {
            let text = "nothing of it is in sight (behind the camera or far outside the frame); check the camera, and the layer's nodes";
            report.warnings.push(format!("layer '{}': {text}", layer.name));
        } else if state.report().is_none() && layer.pins.iter().any(|pin| !pin.is_muted) {
            let text = "all its pins are behind the camera or at its near plane: it is not warped; anchor a pin in what the camera sees";
            report.warnings.push(format!("layer '{}': {text}", layer.name));
        }
        let Some(solve) = state.report().cloned() else { continue };
        report.warnings.extend(warnings_of_layer(prepared, index, sample));
        report.warnings.extend(fold_warning(layer, &solve, branching_remedy(&prepared.shot, layer)));
        let told = shared_cells::warning(prepared, index, state, &solve, height_px);
        report.warnings.extend(told);
        match note_at(prepared, index, frame) {
            Some(TimedNote::Spread(spread)) => {
                report.spreads.push(spread.frames);
                report.warnings.push(spread_warning(layer, &spread, height_px));
            }
            Some(TimedNote::Alone(why)) => {
                let text = "cannot be solved over time, so that each frame is solved alone";
                report.warnings.push(format!("layer '{}' {text}: {why}", layer.name));
            }
            Some(TimedNote::Outside([first, last])) => report.warnings.push(format!(
                "layer '{}': the frame lies outside solve_range, over which frames are solved together ({first} to {last}), and may \
                 not fit its neighbours; widen solve_range in the shot",
                layer.name
            )),
            None => {}
        }
        report.warnings.extend(solve.warnings.iter().map(|text| format!("layer '{}': {text}", layer.name)));
        report.warnings.extend(overlaps::order_warning(prepared, index, sample));
        report.notes.extend(overlaps::crossing_note(prepared, index, sample));
        let greatest = |errors: &[f64]| errors.iter().fold(0.0, |a: f64, &b| a.max(b));
        report.layers.push(LayerReport {
            layer: layer.name.clone(),
            pin_error_px: greatest(&pin_errors_px(sample, state, height_px)),
            pin_error_metres: state.world.is_some().then(|| greatest(&solve.pin_errors)),
            jerk: None,
            solve,
        });
    }
    report
}

/// Returns the warnings about targets that the solves of a layer miss, and about borders that are displaced.
pub(crate) fn warnings_of_layer(prepared: &PreparedShot, index: usize, sample: &TimeSample) -> Vec<String> {
    let (layer, state) = (&prepared.shot.layers[index], &sample.layers[index]);
    let height_px = f64::from(prepared.shot.size.height);
    let Some(solve) = state.report() else { return Vec::new() };
    let errors_px = pin_errors_px(sample, state, height_px);
    let mut warnings = pin_warnings(layer, state, (solve, &errors_px), height_px);
    warnings.extend(handle_warnings(layer, solve, height_px));
    warnings.extend(border_warnings(layer, state, height_px));
    warnings
}

/// Returns the warning that the temporal weight spreads a sudden jump over several frames.
fn spread_warning(layer: &Layer, spread: &Spread, height_px: f64) -> String {
    let [first, last] = spread.frames;
    let speed = match layer.space {
        LayerSpace::Screen { .. } => format!("{:.1} pixels", spread.speed * height_px),
        LayerSpace::World { .. } => format!("{:.4} m", spread.speed),
    };
    let name = &layer.name;
    // The range is one word, so that warnings about different jumps stay apart.
    format!(
        "layer '{name}': a sudden jump is spread over frames {first}-{last} (up to {speed} per frame relative to the \
         rigid fit of its pins); another pin where it bends decides for it"
    )
}

/// Returns the distance of each active pin from its target as seen by the camera, pixels; 0 for pins out of view.
fn pin_errors_px(sample: &TimeSample, state: &LayerState, height_px: f64) -> Vec<f64> {
    let Some(world) = &state.world else {
        return state.report().into_iter().flat_map(|solve| &solve.pin_errors).map(|error| error * height_px).collect();
    };
    let miss = |(pin, in_scene): (&PinState, &ScenePin)| {
        let reached = sample.camera.project_exact(world.lattice.warp(in_scene.rest));
        if pin.is_in_view { (reached.point() - pin.target).0.length() * height_px } else { 0.0 }
    };
    state.pins.iter().zip(&world.pins).map(miss).collect()
}

/// Returns warnings about pins that contradict each other, and about others that miss their targets.
fn pin_warnings(
    layer: &Layer,
    state: &LayerState,
    (solve, errors_px): (&SolveReport, &[f64]),
    height_px: f64,
) -> Vec<String> {
    let name_of = |index: usize| &layer.pins[state.pins[index].pin].name;
    let contradiction = |&[first, second]: &[usize; 2]| {
        let apart_px = (state.pins[first].target - state.pins[second].target).0.length() * height_px;
        format!(
            "layer '{}': pins '{}' and '{}' hold the same point, but their targets are {apart_px:.2} px apart: it goes \
             between them (least squares); remove one of them",
            layer.name,
            name_of(first),
            name_of(second)
        )
    };
    let is_told = |index: usize| solve.conflicts.iter().flatten().any(|&other| other == index);
    let missed = solve.pin_residuals.iter().filter(|miss| errors_px[miss.pin] > PIN_TOLERANCE_PX);
    let missed = missed.filter(|miss| !is_told(miss.pin)).map(|miss| {
        let (name, off_px) = (name_of(miss.pin), errors_px[miss.pin]);
        if miss.reason == ResidualReason::Guard {
            return guarded(layer, solve, &format!("pin '{name}'"), &format!("{off_px:.1} px"));
        }
        let why = miss.reason.words(|pin| format!("'{}'", name_of(pin)));
        format!("layer '{}': pin '{name}' is {off_px:.2} px off its target: {why}", layer.name)
    });
    solve.conflicts.iter().map(contradiction).chain(missed).collect()
}

/// Returns warnings about pins that displace the border of a whole picture.
fn border_warnings(layer: &Layer, state: &LayerState, height_px: f64) -> Vec<String> {
    let told = |&(pin, by): &(usize, f64)| {
        let (layer, pin, by) = (&layer.name, &layer.pins[state.pins[pin].pin].name, by * height_px);
        format!(
            "layer '{layer}': pin '{pin}' comes too close to the border for its path, so the border is displaced there by {by:.1} px; \
             move the pin less, or place it farther inside"
        )
    };
    state.whole.iter().flat_map(|whole| &whole.given_way).map(told).collect()
}

/// Returns warnings about moved handles that yielded to the guard.
fn handle_warnings(layer: &Layer, solve: &SolveReport, height_px: f64) -> Vec<String> {
    if !solve.is_held_back {
        return Vec::new();
    }
    let told = |(index, error): (&[usize; 3], f64)| match layer.space {
        LayerSpace::Screen { .. } if error * height_px > PIN_TOLERANCE_PX => {
            let [column, row, _] = index;
            let distance = format!("{:.1} px", error * height_px);
            Some(guarded(layer, solve, &format!("handle [{column}, {row}]"), &distance))
        }
        LayerSpace::World { .. } if error > HANDLE_TOLERANCE_M => {
            Some(guarded(layer, solve, &format!("handle {index:?}"), &format!("{error:.4} m")))
        }
        _ => None,
    };
    let handles = layer.handles.iter().map(|track| &track.index);
    handles.zip(solve.handle_errors.iter().copied()).filter_map(told).collect()
}

/// Returns a warning about folded cells in which the model overlaps itself.
fn fold_warning(layer: &Layer, solve: &SolveReport, branching_remedy: &str) -> Option<String> {
    if solve.folded_model_cells == 0 {
        return None;
    }
    let cells = pluralised(solve.folded_model_cells, "cell of the lattice", "cells of the lattice");
    let guard_remedy = match layer.settings.guard {
        Guard::Report => ", or let `solve = { guard = \"limit\" }` keep it from folding",
        Guard::Limit => "",
    };
    Some(format!(
        "layer '{}': the model folds over itself in {cells}; move its pins less or farther apart, add pins that hold what \
         lies between{branching_remedy}{guard_remedy} (--overlay shows the cells in red)",
        layer.name
    ))
}

/// Returns the warning that a pin or handle yielded to the guard, with its distance from the target.
fn guarded(layer: &Layer, solve: &SolveReport, what: &str, distance: &str) -> String {
    let why = if solve.folded_model_cells == 0 {
        "nothing folds".to_owned()
    } else {
        let folded = pluralised(solve.folded_model_cells, "cell folds", "cells fold");
        format!("{folded} nevertheless")
    };
    format!(
        "layer '{}': guard: {what} stops {distance} short of its target; {why}; move it less, or add pins that hold what lies around it",
        layer.name
    )
}
