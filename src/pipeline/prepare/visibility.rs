//! Hides nodes as the keys `hide` and `show` of a shot request.
//!
//! In: patterns of node names. Out: a scene whose hidden nodes have no meshes, so that no later stage sees them.

use crate::pipeline::PipelineError;
use crate::scene::Scene;
use crate::shot::{Shot, Visibility};
use crate::spelling;

/// Removes the meshes of hidden nodes and returns those nodes.
pub(in crate::pipeline) fn hide(shot: &Shot, scene: &mut Scene) -> Result<Vec<usize>, PipelineError> {
    let Visibility { hide, show } = &shot.visibility;
    if hide.is_empty() && show.is_empty() {
        return Ok(Vec::new());
    }
    let (is_matched, is_shown) = (matching(shot, scene, ("hide", hide))?, matching(shot, scene, ("show", show))?);
    let is_hidden = |node: usize| (is_matched[node] || hide.is_empty()) && !is_shown[node];
    let hidden: Vec<usize> =
        (0..scene.nodes.len()).filter(|&node| scene.nodes[node].mesh.is_some() && is_hidden(node)).collect();
    for &node in &hidden {
        scene.nodes[node].mesh = None;
    }
    Ok(hidden)
}

/// #nodes: whether one of the patterns matches the node or one of its ancestors.
fn matching(shot: &Shot, scene: &Scene, (key, patterns): (&str, &[String])) -> Result<Vec<bool>, PipelineError> {
    let mut is_matched = vec![false; scene.nodes.len()];
    for (index, pattern) in patterns.iter().enumerate() {
        let matched = scene.matching(pattern);
        if matched.is_empty() {
            let names = scene.nodes.iter().map(|node| node.name.as_str());
            let hint = spelling::hint(pattern, names);
            let what = format!("no node matches '{pattern}'");
            return Err(PipelineError::mismatch(shot, &format!("{key}[{index}]"), what, hint));
        }
        matched.into_iter().for_each(|node| is_matched[node] = true);
    }
    for node in 0..scene.nodes.len() {
        // Parents precede their children.
        is_matched[node] |= scene.nodes[node].parent.is_some_and(|parent| is_matched[parent]);
    }
    Ok(is_matched)
}
