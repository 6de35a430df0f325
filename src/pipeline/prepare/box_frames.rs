//! Checks the nodes that the boxes of layers turn with.
//!
//! In: a shot and its scene. Out: an error for an unknown node; notes on nodes whose axis points at the camera.

use crate::pipeline::{PipelineError, PreparedShot};
use crate::pose::placed_nodes;
use crate::scene::Scene;
use crate::shot::{LayerSpace, Shot};
use crate::spelling;

/// Smallest angle between a node's axis and the line of sight, in degrees, at which the box turns steadily.
const LEAST_ANGLE: f64 = 10.0;

/// Maximum number of frames that are looked at.
const LOOKS: usize = 100;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Refuses nodes that the scene does not have.
pub(in crate::pipeline) fn check(shot: &Shot, scene: &Scene) -> Result<(), PipelineError> {
    for (index, layer) in shot.layers.iter().enumerate() {
        let Some((name, _)) = &layer.orientation.node else { continue };
        if scene.node_named(name).is_none() {
            let hint = spelling::hint(name, scene.nodes.iter().map(|node| node.name.as_str()));
            let key = format!("layer[{index}].lattice.frame.node");
            return Err(PipelineError::mismatch(shot, &key, format!("there is no node '{name}' in the scene"), hint));
        }
    }
    Ok(())
}

/// Adds a note for each screen layer whose box turns with an axis that points at the camera, where its direction on the
/// screen is undefined.
pub(in crate::pipeline) fn note_foreshortened(prepared: &mut PreparedShot) {
    let frames = prepared.shot.frames;
    let step = frames.count().div_ceil(LOOKS);
    let mut notes = Vec::new();
    for layer in &prepared.shot.layers {
        let (Some((name, axis)), LayerSpace::Screen { .. }) = (&layer.orientation.node, layer.space) else { continue };
        let Some(node) = prepared.scene.node_named(name) else { continue };
        let cosine = |frame: i32| {
            let frame = f64::from(frame);
            let pose = placed_nodes(&prepared.scene, prepared.clip, frames.seconds(frame));
            let camera = prepared.camera.at((&prepared.shot, &prepared.scene), frame, &pose);
            let placed = pose.scene_from_node[node].as_dmat4();
            let sight = camera.line_of_sight(placed.w_axis.truncate());
            placed.col(*axis).truncate().normalize_or_zero().dot(sight).abs()
        };
        let looks = (frames.first..=frames.last).step_by(step.max(1)).map(|frame| (frame, cosine(frame)));
        let nearest = looks.max_by(|a, b| a.1.total_cmp(&b.1));
        let foreshortened = nearest.filter(|(_, cosine)| *cosine > LEAST_ANGLE.to_radians().cos());
        if let Some((frame, _)) = foreshortened {
            let axis = AXES[*axis];
            notes.push(format!(
                "layer '{}': the {axis} axis of '{name}' points at the camera around frame {frame}, where the box swings round; \
                 name another `axis` in `lattice.frame`",
                layer.name
            ));
        }
    }
    prepared.notes.extend(notes);
}
