//! Measures the jerk of a layer, that is, the unevenness of its motion over four frames, before the warp and due to it.
//!
//! In: a solved frame and the three before it. Out: third differences in pixels, and a warning if the warp jerks
//! although its input does not and the motion is not smooth between frames either. The measurement never changes a
//! picture.

use crate::lattice::ScreenLattice;
use crate::pipeline::evaluate::camera_cuts::take_at;
use crate::pipeline::evaluate::part_triangle_ranges::triangles_of;
use crate::pipeline::{FrameReport, Jerk, LayerState, PinAnchor, PreparedShot, TimeSample};
use crate::raster::geometry::vertex_triangles;
use crate::screen::primitive;
use crate::shot::Rotation;
use crate::solve::Solution;
use crate::space::{ScreenPoint, ScreenVector};
use std::collections::{BTreeMap, VecDeque};

/// Number of surface points of a layer that are measured, in addition to its pins.
const SURFACE_POINTS: usize = 64;

/// Jerk of the warp below which it is not visible, pixels; a flicker that alternates from frame to frame has a jerk of
/// eight times its amplitude.
const VISIBLE_PX: f64 = 2.0;

/// Maximum ratio of the warp's jerk to the unrest of its input: far from the pins the warp swings farther than they move.
const MAX_AMPLIFICATION: f64 = 6.0;

/// Ratio of jerks above which a motion is rough, when the step is halved.
///
/// Halving the step leaves an eighth of the jerk of a smooth motion, a quarter if its curvature jumps (as at the knots
/// of a trajectory), half at a kink, and all of it at a jump.
const ROUGH: f64 = 0.35;

/// Offsets, in frames, at which samples are inserted by successive halvings before a motion counts as rough. Buckling
/// is smooth, but only within a fraction of a frame.
const SUBDIVISION_STEPS: [f64; 3] = [0.5, 0.25, 0.125];

/// Displacement around a pin per radian of its rotation, relative to the lattice's diagonal.
const DISPLACEMENT_PER_RADIAN: f64 = 0.25;

/// Measures the jerk of successive frames; earlier frames are remembered, and solved if they are missing.
#[derive(Debug, Default)]
pub(crate) struct JerkMeter {
    /// The preceding frames, at most three, without gaps.
    past: VecDeque<(i32, Vec<Option<FramePoints>>)>,
}

/// Points of a layer in one frame; points out of sight are `None`.
#[derive(Clone, Debug, Default)]
struct FramePoints {
    /// Positions before the warp.
    points: Vec<Option<ScreenVector>>,
    /// Displacements by the warp.
    displacements: Vec<Option<ScreenVector>>,
    /// Offsets prescribed by the keys.
    wanted: Vec<Option<ScreenVector>>,
}

impl JerkMeter {
    /// Adds the jerk of every layer in a frame's report, and a warning if it is excessive. The result is the same for a
    /// single frame as in a sequence. The first three frames of a shot have none.
    pub(crate) fn watch(&mut self, prepared: &PreparedShot, sample: &TimeSample, report: &mut FrameReport) {
        self.look_back(prepared, report.frame);
        let now = frame_points(prepared, sample);
        for (index, layer) in prepared.shot.layers.iter().enumerate() {
            let Some((jerk, unrest_px)) = self.jerk(&now, index, f64::from(prepared.shot.size.height)) else {
                continue;
            };
            let Some(reported) = report.layers.iter_mut().find(|reported| reported.layer == layer.name) else {
                continue;
            };
            reported.jerk = Some(jerk);
            // The keys of a transferred lattice are in another shot, so its input is unknown here.
            let is_followed = layer.transfer.is_none();
            let is_uneven = jerk.warp_px > VISIBLE_PX.max(MAX_AMPLIFICATION * unrest_px);
            if is_followed && is_uneven && self.is_rough(prepared, index, &now).unwrap_or(true) {
                report.warnings.push(format!(
                    "layer '{}': the warp jerks by {:.1} px where model and keys jerk by {:.1} px: it may flicker here; \
                     look for pins that are nearly on one point, or for parts that no pin holds",
                    layer.name, jerk.warp_px, jerk.input_px
                ));
            }
        }
        self.past.push_back((report.frame, now));
        if self.past.len() > 3 {
            self.past.pop_front();
        }
    }

    /// Fills `past` with the three frames before `frame`. If one of them cannot be solved, it and those before it are left out.
    fn look_back(&mut self, prepared: &PreparedShot, frame: i32) {
        let wanted = frame.saturating_sub(3)..frame;
        let take = |frame: i32| take_at(prepared, f64::from(frame));
        let is_cut = take(wanted.start) < take(frame);
        if wanted.start < prepared.shot.frames.first || is_cut || prepared.shot.layers.is_empty() {
            // Too early for a measurement, also after a cut of the camera; known frames may serve the next one.
            self.past.retain(|&(past, _)| wanted.contains(&past) && take(past) == take(frame));
            return;
        }
        let mut known: BTreeMap<i32, Vec<Option<FramePoints>>> = self.past.drain(..).collect();
        for past in wanted {
            let found =
                known.remove(&past).or_else(|| Some(frame_points(prepared, &*prepared.mid_exposure(past).ok()?)));
            match found {
                Some(found) => self.past.push_back((past, found)),
                None => self.past.clear(),
            }
        }
    }

    /// Whether the jerk of a layer's warp comes from a jump or kink rather than from fast smooth motion: an arm that is
    /// raised evenly rotates, and rotation always has jerk. `None` if the layer cannot be solved between frames.
    fn is_rough(&self, prepared: &PreparedShot, layer: usize, now: &[Option<FramePoints>]) -> Option<bool> {
        let mut first = prepared.mid_exposure_time(f64::from(self.past.front()?.0));
        let known = self.past.iter().map(|(_, frame_points)| frame_points).map(Vec::as_slice).chain([now]);
        let mut four: Vec<FramePoints> =
            known.map(|frame_points| frame_points[layer].clone()).collect::<Option<_>>()?;
        let mut whole = jerk_of(&four);
        for step in SUBDIVISION_STEPS {
            let between = |k: i32| {
                FramePoints::of(prepared, &*prepared.sample_at(first + step * f64::from(2 * k + 1)).ok()?, layer)
            };
            let middles = (0..3).map(between).collect::<Option<Vec<_>>>()?;
            let mut seven: Vec<FramePoints> = Vec::with_capacity(7);
            for (place, middle) in four.iter().cloned().zip(middles) {
                seven.extend([place, middle]);
            }
            seven.push(four.pop()?);
            let halves = seven.windows(4).map(jerk_of).enumerate();
            let (worst, half) = halves.max_by(|a, b| a.1.total_cmp(&b.1))?;
            if half <= ROUGH * whole {
                return Some(false);
            }
            (whole, first) = (half, first + step * worst as f64);
            four = seven.drain(worst..worst + 4).collect();
        }
        Some(true)
    }

    /// Returns the jerk of a layer, and the unrest of its warp's input in pixels, in which jerks of opposite signs do not cancel.
    fn jerk(&self, now: &[Option<FramePoints>], layer: usize, height_px: f64) -> Option<(Jerk, f64)> {
        let mut frames: Vec<&FramePoints> = Vec::with_capacity(4);
        for (_, past) in &self.past {
            frames.push(past[layer].as_ref()?);
        }
        frames.push(now[layer].as_ref()?);
        let [a, b, c, d] = <[&FramePoints; 4]>::try_from(frames).ok()?;
        let most = |of: fn(&FramePoints) -> &[Option<ScreenVector>]| {
            unevenness([of(a), of(b), of(c), of(d)]).map(|length| length * height_px)
        };
        let [points, wanted, warp] = [
            most(|frame_points| &frame_points.points),
            most(|frame_points| &frame_points.wanted),
            most(|frame_points| &frame_points.displacements),
        ];
        let jerk = Jerk { warp_px: warp[0], input_px: points[0].max(wanted[0]) };
        Some((jerk, points[1].max(wanted[1])))
    }
}

/// Returns the jerk of the displacements at four times, in frame heights per cubed step.
fn jerk_of(four: &[FramePoints]) -> f64 {
    let [a, b, c, d] = four else { return 0.0 };
    unevenness([&a.displacements, &b.displacements, &c.displacements, &d.displacements])[0]
}

/// Returns the largest third difference, and the largest sum of the lengths of both second differences, over the points
/// that are in sight in all four frames. The third difference may vanish at an extremum of a key on twos; the sum
/// cannot.
fn unevenness([a, b, c, d]: [&[Option<ScreenVector>]; 4]) -> [f64; 2] {
    let frames = a.iter().zip(b).zip(c.iter().zip(d));
    let bends = frames.filter_map(|((a, b), (c, d))| {
        let [a, b, c, d] = [a.as_ref()?.0, b.as_ref()?.0, c.as_ref()?.0, d.as_ref()?.0];
        Some([a - 2.0 * b + c, b - 2.0 * c + d])
    });
    bends.fold([0.0_f64; 2], |[jerk, unrest], [first, second]| {
        [jerk.max((second - first).length()), unrest.max(first.length() + second.length())]
    })
}

/// Returns the points of all layers in one frame.
fn frame_points(prepared: &PreparedShot, sample: &TimeSample) -> Vec<Option<FramePoints>> {
    (0..prepared.shot.layers.len()).map(|layer| FramePoints::of(prepared, sample, layer)).collect()
}

impl FramePoints {
    fn of(prepared: &PreparedShot, sample: &TimeSample, layer: usize) -> Option<Self> {
        let state = &sample.layers[layer];
        let solution = state.solution.as_ref()?;
        let mut frame_points = Self::default();
        for (point, place) in surface_points(prepared, sample, layer) {
            frame_points.add(point, |point| image(state, solution, point, place));
        }
        for (pin, anchor) in prepared.anchors_of(layer).iter().enumerate() {
            let pin = state.pins.iter().find(|state| state.pin == pin);
            let place = match *anchor {
                PinAnchor::Surface { part, triangle, .. } => Some([part, triangle]),
                PinAnchor::Screen(_) => None,
            };
            frame_points.add(pin.map(|pin| pin.rest), |point| image(state, solution, point, place));
            frame_points.wanted.push(pin.map(|pin| pin.target - pin.rest));
        }
        frame_points.add_keys(prepared, sample, (layer, &solution.lattice));
        Some(frame_points)
    }

    fn add(&mut self, point: Option<ScreenPoint>, image: impl Fn(ScreenPoint) -> Option<ScreenPoint>) {
        let point = point.and_then(|point| Some((point, image(point)?)));
        self.points.push(point.map(|(point, _)| ScreenVector(point.0)));
        self.displacements.push(point.map(|(point, image)| image - point));
    }

    /// Adds the rotations and stretches of pins, and the offsets of handles, converted to lengths.
    fn add_keys(&mut self, prepared: &PreparedShot, sample: &TimeSample, (layer, lattice): (usize, &ScreenLattice)) {
        let targets = prepared.shot.pin_targets(layer, prepared.key_frame(&prepared.shot.layers[layer], sample.frame));
        let lever = DISPLACEMENT_PER_RADIAN * lattice.grid.diagonal();
        let turns = targets.pins.iter().map(|pin| match pin.rotation {
            Some(Rotation::InView(turn)) => [turn, pin.log_scale.unwrap_or(0.0)],
            _ => [0.0, pin.log_scale.unwrap_or(0.0)],
        });
        self.wanted.extend(turns.map(|[turn, stretch]| Some(ScreenVector::new(lever * turn, lever * stretch))));
        let offsets = targets.handles.iter().map(|offset| lattice.grid.scaled_to_box([offset[0], offset[1]]));
        self.wanted.extend(offsets.map(|offset| Some(ScreenVector(offset.into()))));
    }
}

/// Returns the image of a point of the screen, which on a branching lattice depends on the triangle that it lies on, given by part
/// and triangle; `None` if the triangle is out of sight.
fn image(
    state: &LayerState,
    solution: &Solution<2>,
    point: ScreenPoint,
    place: Option<[usize; 2]>,
) -> Option<ScreenPoint> {
    let Some(branches) = &solution.branches else { return Some(solution.lattice.warp(point)) };
    let [part, triangle] = place?;
    let [x, y] = branches.warp(triangles_of(&state.starts, part, triangle)?, point.0.to_array());
    Some(ScreenPoint::new(x, y))
}

/// Returns the same surface points of a layer in every frame, spread over its vertices, `None` if out of sight; each with its part
/// and a triangle of that part, if the lattice branches.
fn surface_points<'a>(
    prepared: &'a PreparedShot,
    sample: &'a TimeSample,
    layer: usize,
) -> impl Iterator<Item = (Option<ScreenPoint>, Option<[usize; 2]>)> + 'a {
    let parts = prepared.assignment.parts_of_layer[layer].iter().copied();
    let vertices = parts.flat_map(move |part| {
        let share = prepared.assignment.share(layer, part);
        let vertices = 0..sample.pose.parts[part].positions.len() as u32;
        vertices.filter(move |vertex| share.at(*vertex) > 0.0).map(move |vertex| (part, vertex as usize))
    });
    let step = vertices.clone().count().div_ceil(SURFACE_POINTS).max(1);
    let has_branches = sample.layers[layer].solution.as_ref().is_some_and(|solution| solution.branches.is_some());
    // The triangles of the part that was looked at last.
    let mut known: Option<(usize, Vec<u32>)> = None;
    vertices.step_by(step).map(move |(part, vertex)| {
        let posed = &sample.pose.parts[part];
        if has_branches && known.as_ref().is_none_or(|(known, _)| *known != part) {
            known = Some((part, vertex_triangles(primitive(&prepared.scene, posed))));
        }
        let triangle = known.as_ref().map(|(_, triangles)| [part, triangles[vertex] as usize]);
        let projected = sample.camera.project(posed.positions[vertex]);
        ((projected.w > 0.0).then(|| projected.point()), triangle)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_third_difference_of_a_cubic_is_six_and_of_a_parabola_nothing() {
        let frame = |t: f64| [Some(ScreenVector::new(t * t * t, 0.0)), Some(ScreenVector::new(0.0, 5.0 * t * t - t))];
        let frames = [1.0, 2.0, 3.0, 4.0].map(frame);
        let of = |point: usize| unevenness(frames.each_ref().map(|frame| &frame[point..=point]));
        assert!((of(0)[0] - 6.0).abs() < 1e-12 && of(1)[0].abs() < 1e-12);
        assert!((of(0)[1] - 30.0).abs() < 1e-12 && (of(1)[1] - 20.0).abs() < 1e-12);
        assert_eq!(unevenness([&frames[0], &frames[1], &frames[2], &[None, None]]), [0.0; 2]);
    }
}
