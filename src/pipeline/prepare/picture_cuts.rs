//! Divides the triangles of pictures along the cuts of their layers, so that parts separate where the cuts are.
//!
//! In: a shot of pictures, its scene, the parts of its layers. Out: the parts of every picture by its cuts; finer meshes.

use super::picture_parts::{PartMap, PictureParts, share_lines};
use crate::image::LabelMap;
use crate::key_fault::KeyFault;
use crate::pipeline::PipelineError;
use crate::pose::PosedPart;
use crate::scene::{Scene, cut_card};
use crate::shot::{Cut, Shot, Source};
use crate::space::screen_from_uv;
use std::collections::BTreeMap;

/// What borders of parts may be moved for the sake of fewer triangles, in pixels: the steps of pixels are no shape.
const TOLERANCE: f64 = 0.75;

/// The cuts of the pictures of a shot.
#[derive(Debug, Default)]
pub(super) struct PictureCuts {
    /// By layer and number of the cut.
    maps: BTreeMap<[usize; 2], LabelMap>,
    /// By index of the mesh.
    lines: BTreeMap<usize, CutLines>,
}

/// The lines along which a mesh is divided.
#[derive(Debug, Default)]
struct CutLines {
    /// Polylines on the screen, frame heights.
    lines: Vec<Vec<[f64; 2]>>,
    /// Largest deviation from them, frame heights.
    tolerance: f64,
}

impl PictureCuts {
    /// Finds the cuts of all branching layers of pictures.
    ///
    /// # Errors
    /// [`PipelineError::Mismatch`] if the picture of a cut cannot be read, or does not lie over the picture.
    pub(super) fn find(
        (shot, scene): (&Shot, &Scene),
        (posed, parts_of_layer): (&[PosedPart], &[Vec<usize>]),
    ) -> Result<Self, PipelineError> {
        let mut found = Self::default();
        if matches!(shot.source, Source::Scene(_)) {
            return Ok(found);
        }
        for (index, (layer, parts)) in shot.layers.iter().zip(parts_of_layer).enumerate() {
            // Several pictures in one layer are refused later.
            let &[part] = &parts[..] else { continue };
            let node = &scene.nodes[posed[part].node];
            let Some(mesh) = node.mesh.filter(|_| layer.can_branch()) else { continue };
            let cuts = &layer.connectivity.cuts;
            let picture = PictureParts { shot, layer, name: &node.name };
            let parts = cuts.iter().enumerate().map(|(number, cut)| {
                picture.of(cut).map_err(|KeyFault { key, what, hint }| {
                    fault((shot, index), &format!("cuts[{number}].{key}"), &what, &hint)
                })
            });
            let mut parts: Vec<Option<PartMap>> = parts.collect::<Result<_, _>>()?;
            share_lines(&mut parts);
            for (number, (cut, parts)) in cuts.iter().zip(parts).enumerate() {
                let map = parts.map(|parts| parts.map);
                let of_mesh = found.lines.entry(mesh).or_default();
                let height = map.as_ref().map_or(shot.size.height, |map| map.size[1]);
                of_mesh.tolerance = of_mesh.tolerance.max(TOLERANCE / f64::from(height));
                match (cut, map) {
                    (Cut::Stroke(stroke), _) => of_mesh.lines.push(stroke.clone()),
                    (_, Some(map)) => {
                        of_mesh.lines.extend(on_screen(map.borders(), shot.size.aspect()));
                        found.maps.insert([index, number], map);
                    }
                    _ => {}
                }
            }
        }
        Ok(found)
    }

    /// Divides the meshes. Returns whether there was anything to divide.
    pub(super) fn divide(&self, shot: &Shot, scene: &mut Scene) -> bool {
        for (&mesh, CutLines { lines, tolerance }) in &self.lines {
            for primitive in &mut scene.meshes[mesh].primitives {
                *primitive = cut_card(primitive, shot.size.aspect(), lines, *tolerance);
            }
        }
        !self.lines.is_empty()
    }

    /// Returns the parts into which a cut of a layer divides its picture; `None` for strokes.
    pub(super) fn map(&self, layer: usize, cut: usize) -> Option<&LabelMap> {
        self.maps.get(&[layer, cut])
    }
}

/// Converts lines over the unit square, v down, to the screen.
fn on_screen(mut lines: Vec<Vec<[f64; 2]>>, aspect: f64) -> Vec<Vec<[f64; 2]>> {
    lines.iter_mut().flatten().for_each(|point| *point = screen_from_uv(*point, aspect));
    lines
}

/// Says what is wrong with a key of a layer's lattice.
pub(super) fn fault((shot, layer): (&Shot, usize), key: &str, what: &str, hint: &str) -> PipelineError {
    let name = &shot.layers[layer].name;
    PipelineError::mismatch(shot, &format!("layer[{layer}].lattice.{key}"), format!("layer '{name}': {what}"), hint)
}
