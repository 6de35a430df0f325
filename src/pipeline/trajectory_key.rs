//! What a trajectory follows from, as a name for its file.
//!
//! In: a [`PreparedShot`] and a layer. Out: a [`FileKey`]: the same wherever the same bits would be computed, and nowhere else. Frames and pins
//! of other layers on the screen, and where anything lies on the machine, do not count.

use super::trajectory_files::FileKey;
use super::{PreparedShot, contents};
use crate::shot::LayerSpace;
use std::fmt::{self, Debug, Write};
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_128;

/// Longest name of a shot within the name of a file.
const LONGEST_NAME: usize = 40;

impl PreparedShot {
    /// The key of a layer's trajectory.
    pub(super) fn trajectory_key(&self, index: usize) -> FileKey {
        let shared = *self.cache.trajectory_inputs.get_or_init(|| self.trajectory_inputs());
        let mut digest = Digest::default();
        digest.add(&(shared, index));
        self.add_layer(index, &mut digest);
        let stem = self.shot.path.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
        let is_plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
        let stem: String = stem.chars().filter(|&letter| is_plain(letter)).take(LONGEST_NAME).collect();
        FileKey { prefix: format!("{stem}.{index}"), digest: digest.finish() }
    }

    /// What all of them follow from: this very program, the files of the shot, the scene as it moves and is seen.
    fn trajectory_inputs(&self) -> u128 {
        let mut digest = Digest::default();
        digest.add(&env!("CARGO_PKG_VERSION"));
        // Builds of one version may differ in the last bit.
        let program = std::env::current_exe().ok();
        digest.add(&program.map(|program| contents::Contents::default().digest(&[&program])));
        digest.add(&self.contents_digest());
        let Self { shot, assignment, camera, clip, .. } = self;
        let frames = shot.frames;
        digest.add(&(shot.solve_range, frames.rate, frames.clip_start, shot.is_looped, clip, camera));
        digest.add(&(shot.size.aspect(), shot.size.pixel_aspect, shot.shutter, &shot.visibility, shot.allow_outside));
        digest.add(assignment);
        // Layers of the scene move what is seen.
        let is_world = |index: &usize| matches!(shot.layers[*index].space, LayerSpace::World { .. });
        (0..shot.layers.len()).filter(is_world).for_each(|index| self.add_layer(index, &mut digest));
        digest.0.finish_128()
    }

    /// All that is said of a layer, but for how its part of the scene was found.
    fn add_layer(&self, index: usize, digest: &mut Digest) {
        let layer = &self.shot.layers[index];
        let mut plain = layer.clone();
        // Where a file lies does not count; what it holds does, see above.
        plain.transfer.iter_mut().for_each(|transfer| transfer.file = name_of(&transfer.file));
        plain.selection.mask.iter_mut().for_each(|mask| mask.file = name_of(&mask.file));
        digest.add(&plain);
        // Layers on twos count from the first frame.
        digest.add(&(layer.step > 1).then_some(self.shot.frames.first));
        let inputs = &self.layer_inputs;
        digest.add(&(&inputs.anchors[index], &inputs.stiffness[index], &inputs.links[index]));
    }
}

fn name_of(path: &Path) -> PathBuf {
    path.file_name().map(Into::into).unwrap_or_default()
}

/// A digest of values by what they say of themselves: derived texts name every field, and write floats with all their digits.
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
