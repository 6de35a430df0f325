//! Tells what the solves of a frame amount to.
//!
//! In: a solved [`Moment`]. Out: a [`FrameReport`] with one entry a solved layer and warnings in words.

use super::{FrameReport, LayerReport, LayerState, Moment, Setup};
use crate::shot::Layer;
use crate::solve::SolveReport;

/// A pin further than this from its target is told to the user, pixels.
const PIN_TOLERANCE_PX: f64 = 0.05;

/// What the solves of a frame say.
#[must_use]
pub fn report(setup: &Setup, frame: i32, moment: &Moment) -> FrameReport {
    let mut report = FrameReport { frame, ..FrameReport::default() };
    let height_px = f64::from(setup.shot.size.height);
    for (index, (layer, state)) in setup.shot.layers.iter().zip(&moment.layers).enumerate() {
        let is_in_sight = setup.bounds_of(index, &moment.pose, &moment.mesh, &moment.camera).is_some();
        if !is_in_sight {
            let text = "nothing of it is in sight (behind the camera or far outside the frame)";
            report.warnings.push(format!("layer '{}': {text}", layer.name));
        } else if state.solution.is_none() && !layer.pins.is_empty() {
            let text = "all its pins are behind the camera or at its near plane: it is not warped";
            report.warnings.push(format!("layer '{}': {text}", layer.name));
        }
        let Some(solution) = &state.solution else { continue };
        let solve = solution.report.clone();
        report.warnings.extend(pin_warnings(layer, state, &solve, height_px));
        report.warnings.extend(solve.warnings.iter().map(|text| format!("layer '{}': {text}", layer.name)));
        let pin_error_px = solve.pin_errors.iter().fold(0.0, |a: f64, &b| a.max(b)) * height_px;
        report.layers.push(LayerReport { layer: layer.name.clone(), pin_error_px, solve });
    }
    report
}

/// Pins that contradict each other, and others that miss their targets.
fn pin_warnings(layer: &Layer, state: &LayerState, solve: &SolveReport, height_px: f64) -> Vec<String> {
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
    let missed = solve.pin_misses.iter().filter(|miss| miss.distance * height_px > PIN_TOLERANCE_PX);
    let missed = missed.filter(|miss| !is_told(miss.pin)).map(|miss| {
        let (name, off_px) = (name_of(miss.pin), miss.distance * height_px);
        let why = miss.reason.words(|pin| format!("'{}'", name_of(pin)));
        format!("layer '{}': pin '{name}' is {off_px:.2} px off its target: {why}", layer.name)
    });
    solve.conflicts.iter().map(contradiction).chain(missed).collect()
}
