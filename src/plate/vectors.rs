//! Warps channels that are vector components: motion and normals.
//!
//! In: the entries of a composite. Out: pairs of channels, their encoding, and their warped samples.

use super::channel_table::{ChannelEntry, ChannelIndex};
use super::composite::Composite;
use super::compositor::{AlphaGroup, OutputPlanes, PlateCompositor};
use super::motion::{HoleVectors, MotionVectors, fill_motion, warped_motion};
use super::normals::turn_normals;
use super::semantics::VECTOR_COMPONENTS;
use super::visible_samples::VisibleSample;
use super::{MotionEncoding, NormalMode, PlateReport, Semantic};
use crate::image::Plate;
use crate::space::{FrameWindow, PixelRect};

/// The missing information because of which vectors pass through unchanged.
enum Unknown {
    Pair,
    Encoding,
    Time,
}

/// Warps the vectors of a group: motion, and normals if they are to rotate.
pub(super) fn compose_vectors(
    compositor: &PlateCompositor,
    composite: &Composite,
    group: &AlphaGroup,
    planes: &mut OutputPlanes,
    report: &mut PlateReport,
) {
    for semantic in [Semantic::Forward, Semantic::Backward] {
        for layer in layers(&group.of(&[semantic])) {
            match motion(compositor, (composite, group), &layer, semantic) {
                Ok(warped) => planes.extend(warped),
                Err(unknown) => {
                    report.warnings.push(unknown.in_words(&layer));
                    report.warnings.extend(unfilled(compositor, group, &layer));
                    compositor.copy(&layer, (composite, group), planes);
                }
            }
        }
    }
    if compositor.settings.normals == NormalMode::Rotate {
        rotate_normals(compositor, (composite, group), planes, report);
    }
}

fn motion(
    compositor: &PlateCompositor,
    (composite, group): (&Composite, &AlphaGroup),
    layer: &[&ChannelEntry],
    semantic: Semantic,
) -> Result<[(ChannelIndex, Vec<f32>); 2], Unknown> {
    let moving_layers = compositor.moving_layers.ok_or(Unknown::Time)?;
    let [u, v] = pair(layer).filter(|_| layer.len() == 2).ok_or(Unknown::Pair)?;
    let encoding = encoding_of(compositor, u, semantic).ok_or(Unknown::Encoding)?;
    let uv = [u, v].map(|entry| &compositor.table.channel(entry.index).samples[..]);
    let vectors = MotionVectors { uv, semantic, encoding };
    let frame = compositor.table.plate.frame_size();
    let mut planes = warped_motion(composite, vectors, (&group.visible, moving_layers), frame);
    if let Some((behind, window)) = hole_vectors(compositor, [u, v], (semantic, encoding)) {
        let place = FrameWindow { frame, window };
        let behind = HoleVectors { vectors: behind, place, background: &moving_layers[0] };
        fill_motion(composite, &behind, &group.visible, encoding, &mut planes);
    }
    let [us, vs] = planes;
    Ok([(u.index, us), (v.index, vs)])
}

/// Returns the vectors that fill holes, and their encoding: that of the plate for a clean plate, our own for our render.
fn hole_vectors<'a>(
    compositor: &'a PlateCompositor,
    pair: [&ChannelEntry; 2],
    (semantic, encoding): (Semantic, MotionEncoding),
) -> Option<(MotionVectors<'a>, PixelRect)> {
    let filling = compositor.filling.as_ref()?;
    let [u, v] = [filling.find(pair[0])?, filling.find(pair[1])?];
    let is_alike = filling.is_stored_alike(u, pair[0]) && filling.is_stored_alike(v, pair[1]);
    let encoding = if is_alike { encoding } else { known_encoding(filling.plate(), u, semantic)? };
    let [(us, window), (vs, other)] = [u, v].map(|entry| filling.samples(entry.index));
    (window == other).then_some((MotionVectors { uv: [us, vs], semantic, encoding }, window))
}

/// Returns a message if vectors that could fill holes cannot be converted to the plate's encoding.
fn unfilled(compositor: &PlateCompositor, group: &AlphaGroup, layer: &[&ChannelEntry]) -> Option<String> {
    let filling = compositor.filling.as_ref().filter(|_| group.visible.contains(&VisibleSample::Hole))?;
    let is_left =
        |entry: &&ChannelEntry| filling.find(entry).is_some_and(|behind| !filling.is_stored_alike(behind, entry));
    layer.iter().any(is_left).then(|| format!("{}: holes stay empty for the same reason", names(layer)))
}

/// Returns the encoding of a layer's vectors: that of the shot if it gives one, or else that of the program that wrote them, if known.
fn encoding_of(compositor: &PlateCompositor, entry: &ChannelEntry, semantic: Semantic) -> Option<MotionEncoding> {
    compositor.settings.motion.or_else(|| known_encoding(compositor.table.plate, entry, semantic))
}

fn rotate_normals(
    compositor: &PlateCompositor,
    (composite, group): (&Composite, &AlphaGroup),
    planes: &mut OutputPlanes,
    report: &mut PlateReport,
) {
    let plate = compositor.table.plate;
    for layer in layers(&group.of(&[Semantic::Normal])) {
        let Some(pair) = pair(&layer) else {
            report.warnings.push(format!("{}: not rotated, because x or y is missing", names(&layer)));
            continue;
        };
        if plate.is_own_render() {
            report.warnings.push(format!("{}: not rotated, because they are in scene space", names(&layer)));
            continue;
        }
        let [Some(mut xs), Some(mut ys)] = pair.map(|entry| planes.remove(&entry.index)) else { continue };
        turn_normals(composite, &group.visible, [&mut xs, &mut ys], plate.pixel_aspect);
        planes.extend([(pair[0].index, xs), (pair[1].index, ys)]);
    }
}

/// Returns the motion encoding of known programs.
fn known_encoding(plate: &Plate, entry: &ChannelEntry, semantic: Semantic) -> Option<MotionEncoding> {
    let is_blender = entry.name.layer_word() == Some("vector");
    // For the vector to the next frame, Cycles stores the position in this frame minus that in the next.
    let sign = if is_blender && semantic == Semantic::Forward { -1.0 } else { 1.0 };
    (is_blender || plate.is_own_render()).then_some(MotionEncoding { pixels_per_unit: [sign; 2] })
}

impl Unknown {
    fn in_words(&self, layer: &[&ChannelEntry]) -> String {
        let names = names(layer);
        match self {
            Self::Pair => format!("{names}: left unchanged, because motion needs two components, u and v"),
            Self::Encoding => format!(
                "{names}: motion vectors left unchanged, because their encoding is unknown; set `motion` under [warp]"
            ),
            Self::Time => {
                format!("{names}: motion vectors left unchanged, because a map has no data for other frames")
            }
        }
    }
}

/// Groups entries by layer.
fn layers<'a>(entries: &[&'a ChannelEntry]) -> Vec<Vec<&'a ChannelEntry>> {
    let mut layers: Vec<Vec<&ChannelEntry>> = Vec::new();
    for &entry in entries {
        let is_same = |layer: &&mut Vec<&ChannelEntry>| {
            layer[0].index.part == entry.index.part && layer[0].name.segments == entry.name.segments
        };
        match layers.iter_mut().find(is_same) {
            Some(layer) => layer.push(entry),
            None => layers.push(vec![entry]),
        }
    }
    layers
}

/// Returns the two screen components.
fn pair<'a>(layer: &[&'a ChannelEntry]) -> Option<[&'a ChannelEntry; 2]> {
    let find = |name: &str| layer.iter().copied().find(|entry| entry.name.component.eq_ignore_ascii_case(name));
    VECTOR_COMPONENTS.iter().find_map(|[a, b]| Some([find(a)?, find(b)?]))
}

fn names(layer: &[&ChannelEntry]) -> String {
    layer.iter().map(|entry| entry.name.full.as_str()).collect::<Vec<_>>().join(", ")
}
