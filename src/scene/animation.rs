//! Reads animation clips.
//!
//! In: the JSON's animations. Out: tracks of scene nodes with checked keys; `clips[i]` is the file's i-th.

use super::accessor::Integers;
use super::file::File;
use super::limits::{LARGEST, is_usable};
use super::nodes::{self, Tree};
use super::{Clip, Interpolation, Node, Placement, SceneError, Track, TrackValues};
use crate::spelling::pluralised;
use glam::{Quat, Vec3};
use gltf::json::accessor::Type;
use gltf::json::animation::{Channel, Interpolation as JsonInterpolation, Property, Sampler};
use gltf::json::validation::Checked;
use gltf::json::{self, Accessor, Index};
use std::collections::HashSet;

/// Reads all clips. An animated node with a matrix in the file gets a TRS transform in `nodes`.
pub(super) fn load(
    file: &File,
    tree: &Tree,
    nodes: &mut [Node],
    warnings: &mut Vec<String>,
) -> Result<Vec<Clip>, SceneError> {
    let mut clips = Vec::with_capacity(file.root.animations.len());
    for (index, animation) in file.root.animations.iter().enumerate() {
        let name = animation.name.clone().filter(|name| !name.is_empty());
        let mut loader = Loader {
            file,
            tree,
            nodes,
            warnings,
            animation,
            clip: name.unwrap_or_else(|| format!("clip_{index}")),
            taken: HashSet::new(),
        };
        let tracks = loader.tracks()?;
        let ends = tracks.iter().filter_map(|track| track.times.last().copied());
        clips.push(Clip { end_secs: ends.fold(0.0, f32::max), name: loader.clip, tracks });
    }
    Ok(clips)
}

struct Loader<'a> {
    file: &'a File,
    tree: &'a Tree,
    nodes: &'a mut [Node],
    warnings: &'a mut Vec<String>,
    animation: &'a json::Animation,
    /// Name of the clip.
    clip: String,
    /// Nodes and properties that have a track already.
    taken: HashSet<(usize, u8)>,
}

/// A channel's name, for messages.
struct ChannelLabel<'a> {
    clip: &'a str,
    channel: usize,
    node: &'a str,
}

impl std::fmt::Display for ChannelLabel<'_> {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "clip \"{}\", channel {} (node \"{}\")", self.clip, self.channel, self.node)
    }
}

impl Loader<'_> {
    fn tracks(&mut self) -> Result<Vec<Track>, SceneError> {
        let mut tracks = Vec::new();
        for (number, channel) in self.animation.channels.iter().enumerate() {
            tracks.extend(self.track(number, channel)?);
        }
        Ok(tracks)
    }

    /// Reads the track of a channel; `None` if it does not animate a node of this scene.
    fn track(&mut self, number: usize, channel: &Channel) -> Result<Option<Track>, SceneError> {
        let file_node = channel.target.node.value();
        let name = nodes::name(self.file, file_node);
        let label = ChannelLabel { clip: &self.clip, channel: number, node: &name };
        let Some(node) = self.tree.scene_from_file.get(file_node) else {
            return Err(self.file.invalid(format!("{label}: the node does not exist")));
        };
        let (Some(node), Checked::Valid(property)) = (*node, channel.target.path) else { return Ok(None) };
        if !self.taken.insert((node, property as u8)) {
            self.warnings.push(format!("{label}: its {property:?} is animated twice; the second track is ignored"));
            return Ok(None);
        }
        let Some(sampler) = self.animation.samplers.get(channel.sampler.value()) else {
            return Err(self.file.invalid(format!("{label}: its sampler does not exist")));
        };
        let targets = self.nodes[node].weights.len();
        if property == Property::MorphTargetWeights && targets == 0 {
            self.warnings.push(format!("{label} moves morph weights, but there are no morph targets"));
            return Ok(None);
        }
        let keys = Keys { file: self.file, label: &label, sampler, targets };
        let track = keys.read(node, property, self.warnings)?;
        if property != Property::MorphTargetWeights {
            decompose(&mut self.nodes[node]);
        }
        Ok(track)
    }
}

/// Decomposes a matrix into TRS, so that a track can replace one component.
fn decompose(node: &mut Node) {
    if let Placement::Matrix(matrix) = node.rest {
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        node.rest = Placement::Trs { translation, rotation: nodes::unit(rotation), scale };
    }
}

/// Reads the keys of one channel.
struct Keys<'a> {
    file: &'a File,
    label: &'a ChannelLabel<'a>,
    sampler: &'a Sampler,
    /// Number of morph targets of the node.
    targets: usize,
}

impl Keys<'_> {
    fn read(&self, node: usize, property: Property, warnings: &mut Vec<String>) -> Result<Option<Track>, SceneError> {
        let interpolation = match self.sampler.interpolation {
            Checked::Valid(JsonInterpolation::Step) => Interpolation::Step,
            Checked::Valid(JsonInterpolation::Linear) => Interpolation::Linear,
            Checked::Valid(JsonInterpolation::CubicSpline) => Interpolation::CubicSpline,
            Checked::Invalid => return Err(self.fault("an unknown interpolation")),
        };
        let mut times = self.floats(self.sampler.input, Type::Scalar, Integers::AsFlagged)?;
        if times.is_empty() {
            return Ok(None);
        }
        let is_cubic = interpolation == Interpolation::CubicSpline;
        let per_key = if is_cubic { 3 } else { 1 };
        let mut values = self.values(property, is_cubic)?;
        let (have, need) = match &values {
            TrackValues::Translation(values) | TrackValues::Scale(values) => (values.len(), times.len() * per_key),
            TrackValues::Rotation(values) => (values.len(), times.len() * per_key),
            TrackValues::Weights(values) => (values.len(), times.len() * per_key * self.targets),
        };
        if have != need {
            return Err(self.fault(&format!("{} instead of {need}", pluralised(have, "value", "values"))));
        }
        let kept = rising(&times);
        if kept.len() < times.len() {
            warnings.push(format!(
                "{}: {} not later than the one before",
                self.label,
                pluralised(times.len() - kept.len(), "key is", "keys are")
            ));
            times = kept.iter().map(|&key| times[key]).collect();
            keep_keys(&mut values, &kept, per_key, self.targets);
        }
        Ok(Some(Track { node, interpolation, times, values }))
    }

    fn values(&self, property: Property, is_cubic: bool) -> Result<TrackValues, SceneError> {
        let output = self.sampler.output;
        let vectors = |integers| {
            let values = self.floats(output, Type::Vec3, integers)?;
            Ok(values.as_chunks::<3>().0.iter().map(|value| Vec3::from_array(*value)).collect())
        };
        Ok(match property {
            Property::Translation => TrackValues::Translation(vectors(Integers::AsFlagged)?),
            Property::Scale => TrackValues::Scale(vectors(Integers::AsFlagged)?),
            Property::Rotation => {
                let values = self.floats(output, Type::Vec4, Integers::Normalized)?;
                let raw = values.as_chunks::<4>().0.iter().map(|value| Quat::from_array(*value));
                // The tangents of cubic keys are not rotations; interpolated values are normalised later.
                TrackValues::Rotation(if is_cubic { raw.collect() } else { raw.map(nodes::unit).collect() })
            }
            Property::MorphTargetWeights => {
                TrackValues::Weights(self.floats(output, Type::Scalar, Integers::Normalized)?)
            }
        })
    }

    fn floats(&self, accessor: Index<Accessor>, kind: Type, integers: Integers) -> Result<Vec<f32>, SceneError> {
        let values = self.file.floats(accessor, &[kind], integers, format_args!("{}", self.label))?.values;
        match values.iter().find(|value| !is_usable(**value)) {
            Some(value) if value.is_finite() => {
                Err(self.fault(&format!("the value {value:e}, which is beyond {LARGEST:e}")))
            }
            Some(_) => Err(self.fault("a value that is not a finite number")),
            None => Ok(values),
        }
    }

    fn fault(&self, what: &str) -> SceneError {
        self.file.invalid(format!("{} has {what}", self.label))
    }
}

/// Returns the indices of keys that are later than all keys before them.
fn rising(times: &[f32]) -> Vec<usize> {
    let mut latest = f32::NEG_INFINITY;
    let is_later = |&key: &usize| {
        let is_later = times[key] > latest;
        latest = latest.max(times[key]);
        is_later
    };
    (0..times.len()).filter(is_later).collect()
}

/// Keeps only the values of the keys in `kept`; each key has `per_key` values, or that many lists of `targets` weights.
fn keep_keys(values: &mut TrackValues, kept: &[usize], per_key: usize, targets: usize) {
    fn keep<T: Copy>(values: &mut Vec<T>, kept: &[usize], width: usize) {
        *values = kept.iter().flat_map(|&key| &values[key * width..(key + 1) * width]).copied().collect();
    }
    match values {
        TrackValues::Translation(values) | TrackValues::Scale(values) => keep(values, kept, per_key),
        TrackValues::Rotation(values) => keep(values, kept, per_key),
        TrackValues::Weights(values) => keep(values, kept, per_key * targets),
    }
}
