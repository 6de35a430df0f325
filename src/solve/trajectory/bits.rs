//! Serialisation of a trajectory to bytes, without loss.
//!
//! In: a [`Trajectory`], or its bytes. Out: little-endian bytes (counts as 64-bit integers, floats as their IEEE 754 bits), or
//! the trajectory. Malformed bytes are refused. A count is checked against the number of remaining bytes before anything of that
//! size is read.

use super::displacement::Displacement;
use super::interior::Interior;
use super::solved_knots::SolvedKnots;
use super::{Coupling, Spread, Trajectory};
use crate::solve::branching::CopyName;
use crate::solve::point_weights::PointWeights;

/// Stands in place of the number of handles for a knot without a state.
const NO_STATE: u64 = u64::MAX;

impl<const D: usize> Trajectory<D> {
    /// Serialises the trajectory.
    #[must_use]
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut out = Bytes(Vec::new());
        let SolvedKnots { coupling, states, model_angles, drawings, takes, weights } = &self.knots;
        let Coupling { first, last, knots_per_frame, weight, least_speed } = *coupling;
        out.count(D);
        out.floats(&[first, last, f64::from(knots_per_frame), weight, least_speed, self.weight]);
        out.count(states.len());
        for (index, state) in states.iter().enumerate() {
            out.word(drawings[index].cast_unsigned());
            out.word(takes[index].cast_unsigned());
            out.floats(&[model_angles[index]]);
            match state {
                None => out.word(NO_STATE),
                Some(Displacement { handles, copies, points, box_angle }) => {
                    out.count(handles.len());
                    out.count(copies.len());
                    out.count(points.len());
                    out.floats(handles.as_flattened());
                    for copy in copies {
                        out.count(copy.handle);
                        out.count(copy.triangle);
                    }
                    out.floats(points.as_flattened());
                    out.floats(&[*box_angle]);
                }
            }
        }
        out.count(weights.len());
        weights.iter().for_each(|weights| out.weights(weights));
        self.interiors.iter().for_each(|interior| out.word(u64::from(*interior == Interior::Interpolated)));
        out.count(self.spreads.len());
        self.spreads.iter().for_each(|spread| out.floats(&[spread.frames[0], spread.frames[1], spread.speed]));
        out.0
    }

    /// Reads the bytes written by [`Self::to_bytes`]; `None` if they are malformed, or of another dimension.
    #[must_use]
    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut rest = Reader(bytes);
        if rest.word()? != D as u64 {
            return None;
        }
        let [first, last, knots_per_frame, coupling_weight, least_speed, weight] = rest.array()?;
        if knots_per_frame.fract() != 0.0 || !(1.0..=f64::from(u32::MAX)).contains(&knots_per_frame) {
            return None;
        }
        let knots_per_frame = knots_per_frame as u32;
        let coupling = Coupling { first, last, knots_per_frame, weight: coupling_weight, least_speed };
        let (mut drawings, mut takes) = (Vec::new(), Vec::new());
        let (mut model_angles, mut states) = (Vec::new(), Vec::new());
        for _ in 0..rest.count(4)? {
            drawings.push(rest.word()?.cast_signed());
            takes.push(rest.word()?.cast_signed());
            model_angles.push(rest.float()?);
            states.push(rest.state()?);
        }
        let intervals = rest.count(3)?;
        let weights = (0..intervals).map(|_| rest.weights()).collect::<Option<Vec<_>>>()?;
        let interiors = (0..intervals).map(|_| rest.interior()).collect::<Option<Vec<_>>>()?;
        let spreads: Option<Vec<_>> = (0..rest.count(3)?).map(|_| rest.spread()).collect();
        let is_whole =
            rest.0.is_empty() && weights.len() == states.len().saturating_sub(1) && have_points(&weights, &states);
        let knots = SolvedKnots { coupling, states, model_angles, drawings, takes, weights };
        is_whole.then_some(Self { knots, interiors, weight, spreads: spreads? })
    }
}

/// Whether weights of each point in an interval belong to as many points as the states at its ends have.
fn have_points<const D: usize>(weights: &[PointWeights], states: &[Option<Displacement<D>>]) -> bool {
    let fits = |weights: &PointWeights, state: &Option<Displacement<D>>| match (weights, state) {
        (PointWeights::Each(weights), Some(state)) => weights.len() == state.points.len(),
        _ => true,
    };
    weights.iter().zip(states.windows(2)).all(|(weights, ends)| ends.iter().all(|state| fits(weights, state)))
}

struct Bytes(Vec<u8>);

impl Bytes {
    fn word(&mut self, word: u64) {
        self.0.extend(word.to_le_bytes());
    }

    fn count(&mut self, count: usize) {
        self.word(count as u64);
    }

    /// Writes one number for all points as that of no points.
    fn weights(&mut self, weights: &PointWeights) {
        match weights {
            PointWeights::Uniform(weight) => {
                self.count(0);
                self.floats(&[*weight]);
            }
            PointWeights::Each(weights) => {
                self.count(weights.len());
                self.floats(weights);
            }
        }
    }

    fn floats(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.word(value.to_bits()));
    }
}

/// The bytes not read yet.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn word(&mut self) -> Option<u64> {
        let (word, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*word))
    }

    /// Reads the number of elements that follow, each at least `words` words long; `None` if the remaining bytes are too few.
    fn count(&mut self, words: usize) -> Option<usize> {
        let count = self.word()?;
        self.checked_count(count, words)
    }

    /// `count` as `usize`, if at least `count` times `words` words remain.
    fn checked_count(&self, count: u64, words: usize) -> Option<usize> {
        let count = usize::try_from(count).ok()?;
        (count.checked_mul(words)? <= self.0.len() / 8).then_some(count)
    }

    fn array<const N: usize>(&mut self) -> Option<[f64; N]> {
        self.floats(N)?.try_into().ok()
    }

    fn float(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits)
    }

    fn floats(&mut self, count: usize) -> Option<Vec<f64>> {
        (0..count).map(|_| self.float()).collect()
    }

    fn places<const D: usize>(&mut self, count: usize) -> Option<Vec<[f64; D]>> {
        (0..count).map(|_| self.array()).collect()
    }

    fn state<const D: usize>(&mut self) -> Option<Option<Displacement<D>>> {
        let handles = self.word()?;
        if handles == NO_STATE {
            return Some(None);
        }
        let handles = self.checked_count(handles, D)?;
        let copies = self.count(2)?;
        let points = self.count(D)?;
        if copies != 0 && copies != handles {
            return None;
        }
        let handles = self.places(handles)?;
        let copies = (0..copies).map(|_| self.copy()).collect::<Option<Vec<_>>>()?;
        Some(Some(Displacement { handles, copies, points: self.places(points)?, box_angle: self.float()? }))
    }

    fn weights(&mut self) -> Option<PointWeights> {
        match self.count(1)? {
            0 => self.float().map(PointWeights::Uniform),
            count => self.floats(count).map(PointWeights::Each),
        }
    }

    fn copy(&mut self) -> Option<CopyName> {
        let [handle, triangle] = [self.word()?, self.word()?].map(usize::try_from);
        Some(CopyName { handle: handle.ok()?, triangle: triangle.ok()? })
    }

    fn interior(&mut self) -> Option<Interior> {
        match self.word()? {
            0 => Some(Interior::Coupled),
            1 => Some(Interior::Interpolated),
            _ => None,
        }
    }

    fn spread(&mut self) -> Option<Spread> {
        let [first, last, speed] = self.array()?;
        Some(Spread { frames: [first, last], speed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trajectory() -> Trajectory<2> {
        let state = |x: f64| Displacement {
            handles: vec![[x, -0.0]; 3],
            copies: Vec::new(),
            points: vec![[f64::MIN_POSITIVE, x]; 2],
            box_angle: 0.25 * x,
        };
        let copies = [[0, 4], [2, 1], [2, usize::MAX]].map(|[handle, triangle]| CopyName { handle, triangle });
        let branching = Displacement { copies: copies.to_vec(), ..state(-7e300) };
        let knots = SolvedKnots {
            coupling: Coupling { first: -3.5, last: 9.0, knots_per_frame: 2, weight: 0.3, least_speed: 1e-3 },
            states: vec![Some(state(1.0 / 3.0)), None, Some(branching), Some(state(0.1))],
            model_angles: vec![0.0, -0.0, 3.5, 1e-17],
            drawings: vec![3, -1, i64::MAX, 0],
            takes: vec![0, 1, 1, i64::MAX],
            weights: vec![PointWeights::ZERO, PointWeights::Uniform(0.1), PointWeights::Each(vec![12.5, -0.0])],
        };
        Trajectory {
            knots,
            interiors: vec![Interior::Coupled, Interior::Coupled, Interior::Interpolated],
            weight: 0.6,
            spreads: vec![Spread { frames: [2.5, 3.0], speed: 0.01 }],
        }
    }

    #[test]
    fn every_bit_comes_back() {
        let bytes = trajectory().to_bytes();
        let read = Trajectory::<2>::from_bytes(&bytes).expect("it was written so");
        assert_eq!(read, trajectory());
        assert_eq!(read.to_bytes(), bytes, "also the sign of zero");
    }

    #[test]
    fn what_is_cut_off_too_long_or_of_other_dimensions_is_refused() {
        let bytes = trajectory().to_bytes();
        for end in 0..bytes.len() {
            assert_eq!(Trajectory::<2>::from_bytes(&bytes[..end]), None, "cut off after {end} bytes");
        }
        assert_eq!(Trajectory::<2>::from_bytes(&[&bytes[..], &[0; 8]].concat()), None);
        assert_eq!(Trajectory::<3>::from_bytes(&bytes), None);
        // Counts larger than any memory.
        for place in (0..bytes.len()).step_by(8) {
            let mut hostile = bytes.clone();
            hostile[place..place + 8].copy_from_slice(&(u64::MAX - 1).to_le_bytes());
            let _ = Trajectory::<2>::from_bytes(&hostile);
        }
    }
}
