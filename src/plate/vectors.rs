//! Channels that are components of vectors: motion and normals.
//!
//! In: the entries of a canvas. Out: pairs of channels, what is known of how they are stored, and their warped samples.

use super::canvas::Canvas;
use super::contents::{Entry, Place};
use super::draw::{Drawing, Planned, Shared};
use super::motion::{Behind, Vectors};
use super::nearest::Pick;
use super::{Meaning, MotionRule, NormalRule, PlateReport};
use crate::image::Plate;
use crate::space::PixelRect;

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
                    report.warnings.extend(self.unfilled(shared, &layer));
                    self.copy(&layer, (canvas, shared), planes);
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
        let frame = self.contents.plate.frame_size();
        let mut planes = canvas.motion(vectors, &shared.picks, movers, frame);
        if let Some((behind, window)) = self.vectors_behind([u, v], (direction, rule)) {
            let behind = Behind { vectors: behind, window, mover: &movers[0] };
            canvas.fill_motion(&behind, &shared.picks, (frame, rule), &mut planes);
        }
        let [us, vs] = planes;
        Ok([(u.place, us), (v.place, vs)])
    }

    /// The vectors of what fills holes, and how they are stored: a clean plate's as the plate's, ours as ours.
    fn vectors_behind(
        &self,
        pair: [&Entry; 2],
        (direction, rule): (Meaning, MotionRule),
    ) -> Option<(Vectors<'_>, PixelRect)> {
        let filling = self.filling.as_ref()?;
        let [u, v] = [filling.find(pair[0])?, filling.find(pair[1])?];
        let is_alike = filling.is_stored_alike(u, pair[0]) && filling.is_stored_alike(v, pair[1]);
        let rule = if is_alike { rule } else { known_rule(filling.plate(), u, direction)? };
        let [(us, window), (vs, other)] = [u, v].map(|entry| filling.samples(entry.place));
        (window == other).then_some((Vectors { uv: [us, vs], direction, rule }, window))
    }

    /// Says so where vectors that could fill holes cannot be stored as the plate's are.
    fn unfilled(&self, shared: &Shared, layer: &[&Entry]) -> Option<String> {
        let filling = self.filling.as_ref().filter(|_| shared.picks.contains(&Pick::Hole))?;
        let is_left =
            |entry: &&Entry| filling.find(entry).is_some_and(|behind| !filling.is_stored_alike(behind, entry));
        layer.iter().any(is_left).then(|| format!("{}: holes stay empty for the same reason", names(layer)))
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

/// Which of the two components on the screen a name means.
pub(super) fn axis_of(component: &str) -> Option<usize> {
    PAIRS.iter().find_map(|pair| pair.iter().position(|name| component.eq_ignore_ascii_case(name)))
}

fn names(layer: &[&Entry]) -> String {
    layer.iter().map(|entry| entry.name.full.as_str()).collect::<Vec<_>>().join(", ")
}
