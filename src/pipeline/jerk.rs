//! Jerk: how unevenly a layer moves over four frames, before the warp and by it.
//!
//! In: a solved frame and the three before it. Out: third differences in pixels, and a warning where the warp jerks, nothing that it
//! follows does, and it is no smooth motion either. It looks and never changes a picture.

use super::{FrameReport, Jerk, PreparedShot, TimeSample};
use crate::lattice::ScreenLattice;
use crate::shot::Rotation;
use crate::space::{ScreenPoint, ScreenVector};
use std::collections::{BTreeMap, VecDeque};

/// Points of a layer's surface that are looked at, beside its pins.
const SURFACE_POINTS: usize = 64;

/// Jerk of the warp below this is not seen, pixels: an eighth of it is the flicker of a single frame.
const VISIBLE_PX: f64 = 2.0;

/// The warp may jerk this many times as much as what it follows: far from the pins it swings farther than they move.
const AMPLIFIED: f64 = 6.0;

/// In steps of half the length a smooth motion has an eighth of the jerk, one whose curvature jumps, as at the knots of a trajectory, a quarter,
/// a kink a half and a jump all of it. A motion is rough above this fraction.
const ROUGH: f64 = 0.35;

/// Steps in which a motion is looked at before it counts as rough, frames: what buckles is smooth, but within a part of a frame.
const HALVINGS: [f64; 3] = [0.5, 0.25, 0.125];

/// A turn of a pin moves its surroundings by this part of the lattice's diagonal a radian.
const LEVER: f64 = 0.25;

/// Measures frames; what it knows of the last ones is kept, what it does not know is solved.
#[derive(Debug, Default)]
pub struct JerkMeter {
    /// The last frames, at most three, each the one after the other.
    past: VecDeque<(i32, Vec<Option<Places>>)>,
}

/// A layer in one frame; points out of sight are `None`.
#[derive(Clone, Debug, Default)]
struct Places {
    /// Before the warp.
    points: Vec<Option<ScreenVector>>,
    /// By the warp.
    displacements: Vec<Option<ScreenVector>>,
    /// What the keys ask for.
    wanted: Vec<Option<ScreenVector>>,
}

impl JerkMeter {
    /// Adds the jerk of every layer to a frame's report, and a warning where it is bad: the same for a frame alone as in a
    /// sequence. The first three frames of a shot have none.
    pub fn watch(&mut self, prepared: &PreparedShot, sample: &TimeSample, report: &mut FrameReport) {
        self.look_back(prepared, report.frame);
        let now = places(prepared, sample);
        for (index, layer) in prepared.shot.layers.iter().enumerate() {
            let Some((jerk, unrest_px)) = self.jerk(&now, index, f64::from(prepared.shot.size.height)) else {
                continue;
            };
            report.layers.iter_mut().filter(|told| told.layer == layer.name).for_each(|told| told.jerk = Some(jerk));
            // What a transferred lattice follows lies in another shot: nothing here to blame it by.
            let is_followed = layer.transfer.is_none();
            let is_uneven = jerk.warp_px > VISIBLE_PX.max(AMPLIFIED * unrest_px);
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

    /// Makes `past` the frames right before one, as far as the shot has them; it stays empty where one cannot be solved.
    fn look_back(&mut self, prepared: &PreparedShot, frame: i32) {
        let wanted = frame.saturating_sub(3)..frame;
        if wanted.start < prepared.shot.frames.first || prepared.shot.layers.is_empty() {
            // Too early to be measured; what is known may serve the next frame.
            self.past.retain(|&(past, _)| wanted.contains(&past));
            return;
        }
        let mut known: BTreeMap<i32, Vec<Option<Places>>> = self.past.drain(..).collect();
        for past in wanted {
            let found = known.remove(&past).or_else(|| Some(places(prepared, &*prepared.mid_exposure(past).ok()?)));
            match found {
                Some(found) => self.past.push_back((past, found)),
                None => self.past.clear(),
            }
        }
    }

    /// Whether the warp of a layer jerks as it does because it jumps or bends, and not because it is carried around fast: an arm that is
    /// raised evenly turns, and what turns is never without jerk. `None` where it cannot be solved between frames.
    fn is_rough(&self, prepared: &PreparedShot, layer: usize, now: &[Option<Places>]) -> Option<bool> {
        let mut first = prepared.mid_exposure_time(f64::from(self.past.front()?.0));
        let known = self.past.iter().map(|(_, places)| places).map(Vec::as_slice).chain([now]);
        let mut four: Vec<Places> = known.map(|places| places[layer].clone()).collect::<Option<_>>()?;
        let mut whole = jerk_of(&four);
        for step in HALVINGS {
            let between =
                |k: i32| Places::of(prepared, &*prepared.sample_at(first + step * f64::from(2 * k + 1)).ok()?, layer);
            let middles = (0..3).map(between).collect::<Option<Vec<_>>>()?;
            let mut seven: Vec<Places> = Vec::with_capacity(7);
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

    /// The jerk of a layer; and the unrest of what its warp follows, pixels, in which jerks of both signs do not cancel.
    fn jerk(&self, now: &[Option<Places>], layer: usize, height_px: f64) -> Option<(Jerk, f64)> {
        let mut frames: Vec<&Places> = Vec::with_capacity(4);
        for (_, past) in &self.past {
            frames.push(past[layer].as_ref()?);
        }
        frames.push(now[layer].as_ref()?);
        let [a, b, c, d] = <[&Places; 4]>::try_from(frames).ok()?;
        let most = |of: fn(&Places) -> &[Option<ScreenVector>]| {
            unevenness([of(a), of(b), of(c), of(d)]).map(|length| length * height_px)
        };
        let [points, wanted, warp] =
            [most(|places| &places.points), most(|places| &places.wanted), most(|places| &places.displacements)];
        let jerk = Jerk { warp_px: warp[0], input_px: points[0].max(wanted[0]) };
        Some((jerk, points[1].max(wanted[1])))
    }
}

/// The jerk of the displacements at four times, frame heights a step cubed.
fn jerk_of(four: &[Places]) -> f64 {
    let [a, b, c, d] = four else { return 0.0 };
    unevenness([&a.displacements, &b.displacements, &c.displacements, &d.displacements])[0]
}

/// Of points that are in sight in all four frames, the greatest third difference, and the greatest sum of the lengths of
/// both second differences. The former may vanish at an extreme of a key on twos, the latter cannot.
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

/// All layers in one frame.
fn places(prepared: &PreparedShot, sample: &TimeSample) -> Vec<Option<Places>> {
    (0..prepared.shot.layers.len()).map(|layer| Places::of(prepared, sample, layer)).collect()
}

impl Places {
    fn of(prepared: &PreparedShot, sample: &TimeSample, layer: usize) -> Option<Self> {
        let solution = sample.layers[layer].solution.as_ref().filter(|solution| solution.branches.is_none())?;
        let lattice = &solution.lattice;
        let mut places = Self::default();
        surface_points(prepared, sample, layer).for_each(|point| places.add(point, lattice));
        let state = &sample.layers[layer];
        for pin in 0..prepared.shot.layers[layer].pins.len() {
            let pin = state.pins.iter().find(|state| state.pin == pin);
            places.add(pin.map(|pin| pin.rest), lattice);
            places.wanted.push(pin.map(|pin| pin.target - pin.rest));
        }
        places.add_keys(prepared, sample, (layer, lattice));
        Some(places)
    }

    fn add(&mut self, point: Option<ScreenPoint>, lattice: &ScreenLattice) {
        self.points.push(point.map(|point| ScreenVector(point.0)));
        self.displacements.push(point.map(|point| lattice.warp(point) - point));
    }

    /// Turns and stretches of pins, and offsets of handles, as lengths.
    fn add_keys(&mut self, prepared: &PreparedShot, sample: &TimeSample, (layer, lattice): (usize, &ScreenLattice)) {
        let targets = prepared.shot.pin_targets(layer, prepared.key_frame(&prepared.shot.layers[layer], sample.frame));
        let lever = LEVER * lattice.grid.diagonal();
        let turns = targets.pins.iter().map(|pin| match pin.rotation {
            Some(Rotation::InView(turn)) => [turn, pin.log_scale.unwrap_or(0.0)],
            _ => [0.0, pin.log_scale.unwrap_or(0.0)],
        });
        self.wanted.extend(turns.map(|[turn, stretch]| Some(ScreenVector::new(lever * turn, lever * stretch))));
        let size = [lattice.grid.size(0), lattice.grid.size(1)];
        let offsets = targets.handles.iter().map(|offset| ScreenVector::new(offset[0] * size[0], offset[1] * size[1]));
        self.wanted.extend(offsets.map(Some));
    }
}

/// The same points of a layer's surface in every frame, spread over its vertices; `None` where they are out of sight.
fn surface_points<'a>(
    prepared: &'a PreparedShot,
    sample: &'a TimeSample,
    layer: usize,
) -> impl Iterator<Item = Option<ScreenPoint>> + 'a {
    let points = move || {
        prepared.assignment.parts_of_layer[layer].iter().flat_map(move |&part| {
            let share = prepared.assignment.share(layer, part);
            let vertices = (0..).zip(&sample.pose.parts[part].positions);
            vertices.filter(move |(vertex, _)| share.at(*vertex) > 0.0).map(|(_, point)| *point)
        })
    };
    let step = points().count().div_ceil(SURFACE_POINTS).max(1);
    let projected = points().step_by(step).map(|point| sample.camera.project(point));
    projected.map(|vertex| (vertex.w > 0.0).then(|| vertex.point()))
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
