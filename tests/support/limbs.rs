//! Random animations of a limb: bones drawn as a strip, pins on joints that are posed by keys.
//!
//! In: a seed. Out: the problem at any time, in frame heights. The same seed gives the same animation everywhere.

use crate::internal::numbers::{Random, SplitMix};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{Guard, ModelPoint, PointPin, Settings, Shape, SolveError, Targets, TimedProblem, Timeline};

/// One pixel at 1080 lines.
pub(crate) const PIXEL: f64 = 1.0 / 1080.0;

/// Length of the limb at rest, frame heights, and half its width.
const LENGTH: f64 = 0.6;
const HALF_WIDTH: f64 = 0.035;

/// Cells of the strip along and across.
const CELLS: [usize; 2] = [48, 4];

/// Points of the model that a trajectory watches.
const WATCHED: usize = 160;

/// A key: angle of each bone against the one before, radians, and its length over its length at rest.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    pub(crate) frame: f64,
    pub(crate) bones: Vec<[f64; 2]>,
}

/// A limb and its keys.
#[derive(Clone, Debug)]
pub(crate) struct Limb {
    pub(crate) keys: Vec<Key>,
    /// Which joints are pinned, the root first.
    pub(crate) is_pinned: Vec<bool>,
    /// Angles of the bones at rest.
    pub(crate) rest: Vec<f64>,
    grid: Grid<2>,
    shape: Shape<2>,
    settings: Settings,
    /// Knots that its trajectory holds at once.
    pub(crate) window: usize,
}

impl Limb {
    /// Two to four bones; keys every 12 frames turn joints by up to 60 degrees and shorten bones by up to `shortening`.
    pub(crate) fn random(seed: u64, shortening: f64, last_frame: f64) -> Self {
        let mut random = SplitMix(seed);
        let count = random.between(2.0, 5.0) as usize;
        let rest: Vec<f64> = (0..count).map(|_| random.between(-0.4, 0.4)).collect();
        let most = 60_f64.to_radians();
        let mut key = |frame: f64| Key {
            frame,
            bones: (0..count).map(|_| [random.between(-most, most), 1.0 - random.between(0.0, shortening)]).collect(),
        };
        let keys = (0..=(last_frame / 12.0).ceil() as usize).map(|k| key(12.0 * k as f64)).collect();
        let mut is_pinned: Vec<bool> = (0..=count).map(|_| random.between(0.0, 1.0) < 0.7).collect();
        (is_pinned[0], is_pinned[count]) = (true, true);
        Self::new(rest, is_pinned, keys)
    }

    pub(crate) fn new(rest: Vec<f64>, is_pinned: Vec<bool>, keys: Vec<Key>) -> Self {
        let still: Vec<[f64; 2]> = rest.iter().map(|&angle| [angle, 1.0]).collect();
        let joints = joints(&still);
        let shape = strip(&joints);
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in &shape.points {
            (0..2).for_each(|d| (lo[d], hi[d]) = (lo[d].min(point[d]), hi[d].max(point[d])));
        }
        let padding: [f64; 2] = std::array::from_fn(|d| 0.1 * (hi[d] - lo[d]));
        let grid = Grid {
            dims: [10, 10],
            basis: Basis::Bspline,
            lo: std::array::from_fn(|d| lo[d] - padding[d]),
            hi: std::array::from_fn(|d| hi[d] + padding[d]),
            angle: 0.0,
        };
        Self { keys, is_pinned, rest, grid, shape, settings: Settings::default(), window: usize::MAX }
    }

    /// The same limb, with the barrier against folds.
    pub(crate) fn guarded(mut self) -> Self {
        self.settings.guard = Guard::Limit;
        self
    }

    /// Pins at a time.
    pub(crate) fn pins(&self, time: f64) -> Vec<PointPin<2>> {
        let after = self.keys.iter().position(|key| key.frame > time).unwrap_or(self.keys.len());
        let (from, to) = (&self.keys[after.max(1) - 1], &self.keys[after.min(self.keys.len() - 1)]);
        let span = (to.frame - from.frame).max(1e-9);
        let t = ((time - from.frame) / span).clamp(0.0, 1.0);
        let eased = t * t * (3.0 - 2.0 * t);
        let bone = |k: usize| {
            let [a, b] = [from.bones[k], to.bones[k]];
            [self.rest[k] + a[0] + (b[0] - a[0]) * eased, a[1] + (b[1] - a[1]) * eased]
        };
        let posed: Vec<[f64; 2]> = (0..self.rest.len()).map(bone).collect();
        let still: Vec<[f64; 2]> = self.rest.iter().map(|&angle| [angle, 1.0]).collect();
        let pairs = joints(&still).into_iter().zip(joints(&posed)).zip(&self.is_pinned);
        pairs.filter(|(_, is_pinned)| **is_pinned).map(|((at, target), _)| PointPin::new(at, target)).collect()
    }

    /// The points of the strip.
    pub(crate) fn points(&self) -> &[[f64; 2]] {
        &self.shape.points
    }
}

impl Timeline<2> for Limb {
    type Error = SolveError;

    fn settings(&self) -> &Settings {
        &self.settings
    }

    fn window(&self) -> usize {
        self.window
    }

    fn at(&self, time: f64) -> Result<Option<TimedProblem<2>>, SolveError> {
        let goal = Targets { pins: self.pins(time), handles: Vec::new() };
        let step = self.shape.points.len().div_ceil(WATCHED);
        let points = self.shape.points.iter().step_by(step).map(|&at| ModelPoint { at, triangle: None }).collect();
        Ok(Some(TimedProblem {
            grid: self.grid.clone(),
            shape: self.shape.clone(),
            path: vec![goal],
            points,
            drawing: 0,
            take: 0,
        }))
    }
}

/// Places of the joints, the root first: bones with an angle against the one before and a length over that at rest.
fn joints(bones: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let length = LENGTH / bones.len() as f64;
    let (mut place, mut angle) = ([0.3, 0.5], 0.0);
    let mut joints = vec![place];
    for [turn, share] in bones {
        angle += turn;
        let (sin, cos) = f64::sin_cos(angle);
        place = [place[0] + length * share * cos, place[1] + length * share * sin];
        joints.push(place);
    }
    joints
}

/// A strip along a line of joints, with a little beyond its ends.
fn strip(joints: &[[f64; 2]]) -> Shape<2> {
    let [along, across] = CELLS;
    let bones = (joints.len() - 1) as f64;
    let place = |i: usize, j: usize| {
        let t = (i as f64 / along as f64 * 1.04 - 0.02) * bones;
        let bone = (t.floor().max(0.0) as usize).min(joints.len() - 2);
        let (a, b, s) = (joints[bone], joints[bone + 1], t - bone as f64);
        // Normals are mixed at the joints, so that the strip has no gaps.
        let normal = |k: usize| {
            let (a, b) = (joints[k.saturating_sub(1)], joints[(k + 1).min(joints.len() - 1)]);
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            [(a[1] - b[1]) / length, (b[0] - a[0]) / length]
        };
        let (n, m) = (normal(bone), normal(bone + 1));
        let side = HALF_WIDTH * (2.0 * j as f64 / across as f64 - 1.0);
        std::array::from_fn(|d| a[d] + (b[d] - a[d]) * s + side * (n[d] + (m[d] - n[d]) * s.clamp(0.0, 1.0)))
    };
    let points = (0..=along).flat_map(|i| (0..=across).map(move |j| (i, j))).map(|(i, j)| place(i, j)).collect();
    let corner = |i: usize, j: usize| (i * (across + 1) + j) as u32;
    let cells = (0..along).flat_map(|i| (0..across).map(move |j| (i, j)));
    let halves = |(i, j): (usize, usize)| {
        [[corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)], [corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)]]
    };
    Shape::of_triangles(points, cells.flat_map(halves).collect())
}
