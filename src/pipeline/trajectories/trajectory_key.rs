//! Derives the name of a trajectory's file from the inputs of the trajectory.
//!
//! In: a [`PreparedShot`] and a layer. Out: a [`FileKey`], which is the same exactly where the same bits would be
//! computed. The frames of the shot, its shutter, the pins of other screen layers, and the locations of files do not
//! count, but for layers on twos the first frame modulo the step and the middle of the shutter do.

use super::trajectory_files::FileKey;
use crate::pipeline::PreparedShot;
use crate::pipeline::draw::passes::mid_shutter;
use crate::pipeline::run::contents;
use crate::pose::is_still;
use crate::shot::LayerSpace;
use std::fmt::{self, Debug, Write};
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_128;

/// Maximum length of the shot's name in a file name.
const LONGEST_NAME: usize = 40;

impl PreparedShot {
    /// Returns the key of a layer's trajectory.
    pub(in crate::pipeline) fn trajectory_key(&self, index: usize) -> FileKey {
        let shared = *self.cache.trajectory_inputs.get_or_init(|| self.trajectory_inputs());
        let mut digest = Digest::default();
        digest.add(&(shared, index));
        self.add_layer(index, &mut digest);
        let stem = self.shot.path.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
        let is_plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
        let stem: String = stem.chars().filter(|&letter| is_plain(letter)).take(LONGEST_NAME).collect();
        FileKey { prefix: format!("{stem}.{index}"), digest: digest.finish() }
    }

    /// Digests the inputs that all trajectories share: the program, the files of the shot, the animated scene and its camera.
    fn trajectory_inputs(&self) -> u128 {
        let mut digest = Digest::default();
        digest.add(&env!("CARGO_PKG_VERSION"));
        // Builds of one version may differ in the last bit.
        let program = std::env::current_exe().ok();
        digest.add(&program.map(|program| contents::Contents::default().digest(&[&program])));
        digest.add(&self.contents_digest());
        let Self { shot, assignment, camera, clip, .. } = self;
        let frames = shot.frames;
        digest.add(&(shot.solve_range, camera));
        // Frames become seconds only for the clip.
        let has_clip = !is_still(&self.scene, *clip);
        digest.add(&has_clip.then_some((frames.rate, frames.clip_start, shot.is_looped, clip)));
        digest.add(&(shot.size.aspect(), shot.size.pixel_aspect, &shot.visibility, shot.allow_outside));
        digest.add(assignment);
        // World layers move what screen layers see.
        let is_world = |index: &usize| matches!(shot.layers[*index].space, LayerSpace::World { .. });
        (0..shot.layers.len()).filter(is_world).for_each(|index| self.add_layer(index, &mut digest));
        digest.0.finish_128()
    }

    /// Adds all settings of a layer, except how its parts of the scene were selected.
    fn add_layer(&self, index: usize, digest: &mut Digest) {
        let layer = &self.shot.layers[index];
        let mut plain = layer.clone();
        // The location of a file does not count; its contents are part of the shared inputs.
        plain.transfer.iter_mut().for_each(|transfer| transfer.file = name_of(&transfer.file));
        plain.selection.mask.iter_mut().for_each(|mask| mask.file = name_of(&mask.file));
        digest.add(&plain);
        // Layers on twos count their drawings from the first frame, and are solved in the middle of exposures.
        let first_drawing = i64::from(self.shot.frames.first).rem_euclid(i64::from(layer.step));
        digest.add(&(layer.step > 1).then_some((first_drawing, mid_shutter(self.shot.shutter))));
        let inputs = &self.layer_inputs;
        digest.add(&(
            &inputs.anchors[index],
            &inputs.mirrored[index],
            &inputs.stiffness.painted[index],
            &inputs.links[index],
        ));
    }
}

fn name_of(path: &Path) -> PathBuf {
    path.file_name().map(Into::into).unwrap_or_default()
}

/// A digest of the debug output of values: derived implementations name every field, and print floats exactly.
#[derive(Default)]
struct Digest(XxHash3_128);

impl Digest {
    fn add(&mut self, value: &dyn Debug) {
        writeln!(self, "{value:?}").expect("a digest takes any text");
    }

    fn finish(&self) -> String {
        format!("{:032x}", self.0.finish_128())
    }
}

impl Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}
