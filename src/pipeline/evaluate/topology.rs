//! Where lattices branch: the choice for layers that leave it open, and checks where plain lattices are required.
//!
//! In: a shot and its parts, a [`PreparedShot`]. Out: the topology of layers, errors that name the layer and the remedy.

use crate::pipeline::prepare::layer_assignment::LayerAssignment;
use crate::pipeline::prepare::transfer::Loaded;
use crate::pipeline::{PipelineError, PreparedShot};
use crate::pose::PosedPart;
use crate::scene::{Primitive, Scene};
use crate::screen::primitive;
use crate::shot::{Connectivity, Layer, Shot, Source};
use crate::solve::Topology;

/// Refuses layers with branching lattices where only plain ones are supported; `what`: the operation requested.
///
/// # Errors
/// [`PipelineError::Unusable`] for the first such layer.
pub(crate) fn check_plain(prepared: &PreparedShot, what: &str) -> Result<(), PipelineError> {
    match prepared.shot.layers.iter().find(|layer| layer.settings.topology != Topology::Plain) {
        Some(layer) => Err(PipelineError::Unusable {
            what: format!("the lattice of layer '{}' branches, which {what} cannot carry", layer.name),
            hint: "set topology = \"plain\" in its `lattice`, or render the pictures".into(),
        }),
        None => Ok(()),
    }
}

/// What to do where parts that are apart on a model or picture share handles; empty where the layer branches already, or cannot.
pub(in crate::pipeline) fn branching_remedy(shot: &Shot, layer: &Layer) -> &'static str {
    let is_plain = layer.settings.topology == Topology::Plain;
    let is_fit = match &shot.source {
        Source::Scene(_) => true,
        Source::Images(images) => images.len() == 1,
        Source::Frame => false,
    };
    if is_plain && layer.can_branch() && is_fit {
        ", give parts that are apart on the model handles of their own (topology = \"branching\" in `lattice`)"
    } else {
        ""
    }
}

/// Largest number of triangles of a scene's layer that branches unless its shot says otherwise: every frame splits it anew, which
/// takes about 5 ms for each thousand of triangles.
const MAX_BRANCHING_TRIANGLES: usize = 100_000;

/// Makes layers plain whose shot leaves the topology open and that cannot or should not branch: those whose basis or solver does
/// not support it, those with several pictures, which would count as islands, those with lines or with too many triangles, unless
/// they are cut or joined by hand, and those whose lattices come from a file without branches.
///
/// Returns a note for every layer with too many triangles.
pub(in crate::pipeline) fn choose(
    shot: &mut Shot,
    scene: &Scene,
    (assignment, posed): (&LayerAssignment, &[PosedPart]),
    loaded: &[Option<Loaded>],
) -> Vec<String> {
    let is_picture = matches!(shot.source, Source::Images(_));
    let mut notes = Vec::new();
    for ((layer, parts), loaded) in shot.layers.iter_mut().zip(&assignment.parts_of_layer).zip(loaded) {
        if !layer.has_auto_topology || layer.settings.topology == Topology::Plain {
            continue;
        }
        let has_several_pictures = is_picture && parts.len() > 1;
        let is_loaded_plain = loaded.as_ref().is_some_and(|loaded| !loaded.has_branches());
        let (triangles, has_lines) = size_of(parts.iter().map(|&part| primitive(scene, &posed[part])));
        let is_by_hand = layer.connectivity != Connectivity::default();
        let is_too_fine = !is_picture && !is_by_hand && triangles > MAX_BRANCHING_TRIANGLES;
        let is_unfit = !layer.can_branch() || triangles == 0 || has_lines;
        if is_unfit || is_too_fine || has_several_pictures || is_loaded_plain {
            layer.settings.topology = Topology::Plain;
        }
        if is_too_fine && !is_unfit && loaded.is_none() {
            notes.push(format!(
                "layer '{}': its lattice is plain, because it has {triangles} triangles; topology = \"branching\" in its `lattice` \
                 gives parts that are apart handles of their own, at {} s a frame or more",
                layer.name,
                (triangles / 200_000).max(1)
            ));
        }
    }
    notes
}

/// Whether the lattice of a new shot of a scene branches.
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(in crate::pipeline) fn branches_over(scene: &Scene) -> bool {
    let meshes = scene.nodes.iter().filter_map(|node| node.mesh);
    let (triangles, has_lines) = size_of(meshes.flat_map(|mesh| &scene.meshes[mesh].primitives));
    (1..=MAX_BRANCHING_TRIANGLES).contains(&triangles) && !has_lines
}

/// Number of triangles, and whether there are lines.
fn size_of<'a>(primitives: impl Iterator<Item = &'a Primitive>) -> (usize, bool) {
    primitives.fold((0, false), |(triangles, has_lines), primitive| {
        (triangles + primitive.triangles.len(), has_lines || !primitive.lines.is_empty())
    })
}

/// Refuses what acts on branching lattices alone in layers that turn out to be plain, and several pictures in one branching layer: they
/// would count as islands, each linked to the others at a single place.
///
/// # Errors
/// [`PipelineError::Mismatch`] for the first such layer.
pub(in crate::pipeline) fn check_branching(shot: &Shot, assignment: &LayerAssignment) -> Result<(), PipelineError> {
    check_idle_keys(shot, assignment)?;
    let layers = shot.layers.iter().zip(&assignment.parts_of_layer).enumerate();
    let is_picture = matches!(shot.source, Source::Images(_));
    let mut branching = layers.filter(|(_, (layer, _))| is_picture && layer.settings.topology == Topology::Branching);
    match branching.find(|(_, (_, parts))| parts.len() > 1) {
        Some((index, (layer, parts))) => {
            let what = format!("layer '{}' branches and has {} pictures", layer.name, parts.len());
            let hint = "give each picture a layer of its own, or set topology = \"plain\"";
            let key = format!("layer[{index}].lattice.topology");
            Err(PipelineError::mismatch(shot, &key, what, hint))
        }
        None => Ok(()),
    }
}

/// Refuses cuts, joins and orders of layers whose topology was left open and is plain.
fn check_idle_keys(shot: &Shot, assignment: &LayerAssignment) -> Result<(), PipelineError> {
    for (index, (layer, parts)) in shot.layers.iter().zip(&assignment.parts_of_layer).enumerate() {
        let is_plain = layer.settings.topology == Topology::Plain && layer.has_auto_topology;
        let Some(key) = branching_key(layer).filter(|_| is_plain && layer.transfer.is_none()) else { continue };
        let (why, hint) = match shot.source {
            Source::Images(_) if parts.is_empty() => ("its picture is empty", "remove the key"),
            Source::Images(_) => ("it has several pictures", "give each picture a layer of its own, or remove the key"),
            Source::Scene(_) | Source::Frame => {
                ("its nodes have lines or no triangles", "give the lines a layer of their own, or remove the key")
            }
        };
        let what = format!("it acts on branching lattices only, and that of layer '{}' is plain: {why}", layer.name);
        return Err(PipelineError::mismatch(shot, &format!("layer[{index}].{key}"), what, hint));
    }
    Ok(())
}

/// Returns the first key of a layer that acts on branching lattices alone.
pub(crate) fn branching_key(layer: &Layer) -> Option<String> {
    let pin = layer.pins.iter().position(|pin| !pin.order.is_empty()).map(|pin| format!("pin[{pin}].order"));
    let Connectivity { cuts, joins, .. } = &layer.connectivity;
    let has = |list: bool, key: &str| list.then(|| format!("lattice.{key}"));
    has(!cuts.is_empty(), "cuts").or_else(|| has(!joins.is_empty(), "joins")).or(pin)
}
