//! The animation of an exported scene: the clip's own keys, shifted in time, and the weights of the deformed meshes.
//!
//! In: a clip and frames. Out: one animation in the file.

use super::baked::{AddedCamera, BakedScene, NodeMotion, SampledNode};
use super::buffer::{add, add_times, push};
use crate::scene::{Interpolation, Packed, Track, TrackValues};
use glam::{Quat, Vec4};
use serde_json::{Value, json};

/// Replaces the animations of the file by one that combines the clip and the deformed meshes.
pub(super) fn write(packed: &mut Packed, baked: &BakedScene<'_>) {
    if let Some(root) = packed.json.as_object_mut() {
        root.remove("animations");
    }
    let clip = baked.clip.and_then(|clip| baked.scene.clips.get(clip));
    let name = clip.map_or("pinwarp", |clip| clip.name.as_str());
    let mut animation = json!({ "name": name, "samplers": [], "channels": [] });
    match &baked.motion {
        NodeMotion::Keys { shift_secs } => {
            let tracks = clip.iter().flat_map(|clip| &clip.tracks);
            tracks.for_each(|track| Moving { packed, baked, animation: &mut animation }.track(track, *shift_secs));
        }
        NodeMotion::Sampled(nodes) => {
            let times: Vec<f32> = baked.times_secs.iter().map(|&time| time as f32).collect();
            let input = add_times(packed, &times);
            nodes.iter().for_each(|node| Moving { packed, baked, animation: &mut animation }.samples(node, input));
        }
    }
    add_weights(packed, baked, &mut animation);
    if animation["channels"].as_array().is_some_and(|channels| !channels.is_empty()) {
        push(&mut packed.json, "animations", animation);
    }
}

/// State while the channels of the clip are added.
struct Moving<'a> {
    packed: &'a mut Packed,
    baked: &'a BakedScene<'a>,
    animation: &'a mut Value,
}

impl Moving<'_> {
    fn track(&mut self, track: &Track, shift_secs: f64) {
        // The morph targets of deformed meshes are not those that the clip's weights refer to.
        if matches!(track.values, TrackValues::Weights(_)) && self.is_deformed(track.node) {
            return;
        }
        let shifted = |time: &f32| (f64::from(*time) + shift_secs) as f32;
        let input = add_times(self.packed, &track.times.iter().map(shifted).collect::<Vec<_>>());
        let as_vectors = |turns: &[Quat]| turns.iter().map(|turn| Vec4::from(*turn)).collect::<Vec<_>>();
        let (path, output) = match &track.values {
            TrackValues::Translation(values) => ("translation", add(self.packed, values)),
            TrackValues::Rotation(values) => ("rotation", add(self.packed, &as_vectors(values))),
            TrackValues::Scale(values) => ("scale", add(self.packed, values)),
            TrackValues::Weights(values) => ("weights", add(self.packed, values)),
        };
        let interpolation = match track.interpolation {
            Interpolation::Step => "STEP",
            Interpolation::Linear => "LINEAR",
            Interpolation::CubicSpline => "CUBICSPLINE",
        };
        self.channel(track.node, path, json!({ "input": input, "output": output, "interpolation": interpolation }));
    }

    fn samples(&mut self, node: &SampledNode, input: usize) {
        let mut outputs = vec![
            ("translation", add(self.packed, &node.translations)),
            ("rotation", add(self.packed, &node.rotations)),
            ("scale", add(self.packed, &node.scales)),
        ];
        if !node.weights.is_empty() && !self.is_deformed(node.node) {
            outputs.push(("weights", add(self.packed, &node.weights)));
        }
        for (path, output) in outputs {
            self.channel(node.node, path, json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        }
        // The format only allows animating translation, rotation and scale.
        let node = &mut self.packed.json["nodes"][self.baked.scene.file_from_scene[node.node]];
        node.as_object_mut().and_then(|node| node.remove("matrix"));
    }

    fn channel(&mut self, node: usize, path: &str, sampler: Value) {
        let sampler = push(self.animation, "samplers", sampler);
        let node = self.baked.scene.file_from_scene[node];
        push(self.animation, "channels", json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }

    fn is_deformed(&self, node: usize) -> bool {
        self.baked.nodes.iter().any(|deformed| deformed.node == node)
    }
}

/// Adds the keys of a moving camera, one per frame, to the file's animation.
pub(super) fn add_camera_motion(packed: &mut Packed, baked: &BakedScene<'_>, (camera, node): (&AddedCamera, usize)) {
    if camera.motion.is_empty() {
        return;
    }
    let times: Vec<f32> = baked.times_secs.iter().map(|&time| time as f32).collect();
    let placed = camera.motion.iter().map(glam::Mat4::to_scale_rotation_translation);
    let (mut rotations, mut translations) = (Vec::new(), Vec::new());
    let mut last = Quat::IDENTITY;
    for (_, rotation, translation) in placed {
        // Keep neighbours in the same hemisphere, since players interpolate along the shorter arc.
        last = if rotation.dot(last) < 0.0 { -rotation } else { rotation };
        rotations.push(Vec4::from(last));
        translations.push(translation);
    }
    let input = add_times(packed, &times);
    let outputs = [("translation", add(packed, &translations)), ("rotation", add(packed, &rotations))];
    if packed.json["animations"].get(0).is_none() {
        push(&mut packed.json, "animations", json!({ "name": "pinwarp", "samplers": [], "channels": [] }));
    }
    let animation = &mut packed.json["animations"][0];
    for (path, output) in outputs {
        let sampler = json!({ "input": input, "output": output, "interpolation": "LINEAR" });
        let sampler = push(animation, "samplers", sampler);
        push(animation, "channels", json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }
}

/// Frame k shows only target k; between frames, neighbours are interpolated linearly, as in lattice files.
fn add_weights(packed: &mut Packed, baked: &BakedScene<'_>, animation: &mut Value) {
    if baked.nodes.is_empty() {
        return;
    }
    let count = baked.frames.len();
    let times: Vec<f32> = baked.times_secs.iter().map(|&time| time as f32).collect();
    let weights: Vec<f32> = (0..count * count).map(|k| f32::from(u8::from(k / count == k % count))).collect();
    let (input, output) = (add_times(packed, &times), add(packed, &weights));
    let sampler = json!({ "input": input, "output": output, "interpolation": "LINEAR" });
    let sampler = push(animation, "samplers", sampler);
    for node in &baked.nodes {
        let node = baked.scene.file_from_scene[node.node];
        push(animation, "channels", json!({ "sampler": sampler, "target": { "node": node, "path": "weights" } }));
    }
}
