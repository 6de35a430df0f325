//! Channels that are components of vectors: motion and normals.
//!
//! In: the entries of a canvas. Out: pairs of channels, what is known of how they are stored, and their warped samples.

use super::canvas::Canvas;
use super::contents::{Entry, Place};
use super::draw::{Drawing, Planned, Shared};
use super::motion::Vectors;
use super::{Meaning, MotionRule, NormalRule, PlateReport};
use crate::image::Plate;

/// Names of two components, in their order.
const PAIRS: [[&str; 2]; 7] =
    [["u", "v"], ["x", "y"], ["r", "g"], ["z", "w"], ["nx", "ny"], ["red", "green"], ["horizontal", "vertical"]];

/// What is not known where vectors pass through as they are.
enum Unknown {
    Pair,
    Rule,
    Time,
}

impl Drawing<'_> {
    pub(super) fn draw_vectors(
        &self,
        canvas: &Canvas,
        shared: &Shared,
        planes: &mut Planned,
        report: &mut PlateReport,
    ) {
        for direction in [Meaning::Forward, Meaning::Backward] {
            self.draw_motion(canvas, shared, direction, (planes, report));
        }
        if self.rules.normals == NormalRule::Rotate {
            self.turn_normals(canvas, shared, planes, report);
        }
    }

    fn draw_motion(
        &self,
        canvas: &Canvas,
        shared: &Shared,
        direction: Meaning,
        (planes, report): (&mut Planned, &mut PlateReport),
    ) {
        for layer in layers(&shared.of(&[direction])) {
            match self.motion(canvas, shared, &layer, direction) {
                Ok(warped) => planes.extend(warped),
                Err(unknown) => {
                    report.warnings.push(unknown.in_words(&layer));
                    planes.extend(layer.iter().map(|entry| (entry.place, self.copy(entry, canvas, shared))));
                }
            }
        }
    }

    fn motion(
        &self,
        canvas: &Canvas,
        shared: &Shared,
        layer: &[&Entry],
        direction: Meaning,
    ) -> Result<[(Place, Vec<f32>); 2], Unknown> {
        let movers = self.movers.ok_or(Unknown::Time)?;
        let [u, v] = pair(layer).filter(|_| layer.len() == 2).ok_or(Unknown::Pair)?;
        let rule = self.rule_of(u, direction).ok_or(Unknown::Rule)?;
        let uv = [u, v].map(|entry| &self.contents.channel(entry.place).samples[..]);
        let vectors = Vectors { uv, direction, rule };
        let [us, vs] = canvas.motion(vectors, &shared.picks, movers, self.contents.plate.frame_size());
        Ok([(u, us), (v, vs)].map(|(entry, mut plane)| {
            self.fill_picked(entry, canvas, shared, &mut plane);
            (entry.place, plane)
        }))
    }

    /// How a layer's vectors are stored: as the shot says, which is then the whole truth, or as a program is known to do it.
    fn rule_of(&self, entry: &Entry, direction: Meaning) -> Option<MotionRule> {
        self.rules.motion.or_else(|| known_rule(self.contents.plate, entry, direction))
    }

    fn turn_normals(&self, canvas: &Canvas, shared: &Shared, planes: &mut Planned, report: &mut PlateReport) {
        for layer in layers(&shared.of(&[Meaning::Normal])) {
            let Some(pair) = pair(&layer) else {
                report.warnings.push(format!("{}: not turned, since x and y are not both there", names(&layer)));
                continue;
            };
            if self.contents.plate.is_own_render() {
                report.warnings.push(format!("{}: not turned, since they lie in scene space", names(&layer)));
                continue;
            }
            let [Some(mut xs), Some(mut ys)] = pair.map(|entry| planes.remove(&entry.place)) else { continue };
            canvas.turn_normals(&shared.picks, [&mut xs, &mut ys], self.contents.plate.pixel_aspect);
            planes.extend([(pair[0].place, xs), (pair[1].place, ys)]);
        }
    }
}

/// How the programs that are known store their vectors.
fn known_rule(plate: &Plate, entry: &Entry, direction: Meaning) -> Option<MotionRule> {
    let is_blender = entry.name.layer_word() == Some("vector");
    // Of the vector to the next frame Cycles stores this frame's place less the next one's.
    let sign = if is_blender && direction == Meaning::Forward { -1.0 } else { 1.0 };
    (is_blender || plate.is_own_render()).then_some(MotionRule { pixels_per_unit: [sign; 2] })
}

impl Unknown {
    fn in_words(&self, layer: &[&Entry]) -> String {
        let names = names(layer);
        match self {
            Self::Pair => format!("{names}: kept as they are, since motion needs two components, u and v"),
            Self::Rule => format!(
                "{names}: motion vectors keep their values, since nothing says how they are stored; say so with `motion` under [warp]"
            ),
            Self::Time => {
                format!("{names}: motion vectors keep their values, since a map does not tell of other frames")
            }
        }
    }
}

/// Entries of one layer each.
fn layers<'a>(entries: &[&'a Entry]) -> Vec<Vec<&'a Entry>> {
    let mut layers: Vec<Vec<&Entry>> = Vec::new();
    for &entry in entries {
        let is_same = |layer: &&mut Vec<&Entry>| {
            layer[0].place.part == entry.place.part && layer[0].name.segments == entry.name.segments
        };
        match layers.iter_mut().find(is_same) {
            Some(layer) => layer.push(entry),
            None => layers.push(vec![entry]),
        }
    }
    layers
}

/// The two components on the screen.
fn pair<'a>(layer: &[&'a Entry]) -> Option<[&'a Entry; 2]> {
    let find = |name: &str| layer.iter().copied().find(|entry| entry.name.component.eq_ignore_ascii_case(name));
    PAIRS.iter().find_map(|[a, b]| Some([find(a)?, find(b)?]))
}

fn names(layer: &[&Entry]) -> String {
    layer.iter().map(|entry| entry.name.full.as_str()).collect::<Vec<_>>().join(", ")
}
