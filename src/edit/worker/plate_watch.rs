//! Detects changes of the plates that a shot shows, a part of a long sequence at a time.

use crate::image::SequencePath;
use crate::shot::{Shot, Source};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Number of files that are looked at at once.
const BATCH: usize = 250;

/// The plates of a shot and their modification times.
#[derive(Debug, Default)]
pub(super) struct PlateWatch {
    /// The path, possibly with a frame counter; `None`: the shot shows no plates.
    pattern: Option<PathBuf>,
    range: [i32; 2],
    files: Vec<PlateFile>,
    /// Index of the file that is looked at next.
    next: usize,
}

/// A file of plates.
#[derive(Debug)]
struct PlateFile {
    path: PathBuf,
    /// The first and last frame that show it.
    frames: [i32; 2],
    stamp: Option<SystemTime>,
}

/// Returns the modification time of a file; `None` if there is none.
pub(super) fn stamp(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|data| data.modified()).ok()
}

/// Returns the plate that a shot shows: scenes are shown themselves.
fn pattern(shot: &Shot) -> Option<&PathBuf> {
    shot.plate.as_ref().filter(|_| matches!(shot.source, Source::Frame))
}

impl PlateWatch {
    /// Watches the plates of a shot.
    pub(super) fn of(shot: &Shot) -> Self {
        let (pattern, range) = (pattern(shot).cloned(), [shot.frames.first, shot.frames.last]);
        let sequence = pattern.as_deref().and_then(|pattern| SequencePath::of_input(pattern).ok());
        let file = |(path, frames): (PathBuf, [i32; 2])| PlateFile { stamp: stamp(&path), path, frames };
        let files = match sequence {
            None => Vec::new(),
            Some(sequence) if sequence.has_counter() => {
                (range[0]..=range[1]).map(|frame| file((sequence.path_of(frame), [frame; 2]))).collect()
            }
            Some(sequence) => vec![file((sequence.path_of(range[0]), range))],
        };
        Self { pattern, range, files, next: 0 }
    }

    /// Returns whether these are the plates of a shot.
    pub(super) fn is_of(&self, shot: &Shot) -> bool {
        self.pattern.as_ref() == pattern(shot) && self.range == [shot.frames.first, shot.frames.last]
    }

    /// Looks at the next files. Returns the first and last frames whose plates changed or appeared since they were looked at last; a
    /// file that is missing may be one that is being written.
    pub(super) fn look(&mut self) -> Vec<[i32; 2]> {
        let (count, begin) = (self.files.len(), self.next);
        let mut changed = Vec::new();
        for place in (begin..begin + count.min(BATCH)).map(|place| place % count) {
            let file = &mut self.files[place];
            let now = stamp(&file.path);
            if now.is_some() && now != file.stamp {
                file.stamp = now;
                changed.push(file.frames);
            }
        }
        self.next = (begin + BATCH.min(count)) % count.max(1);
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn shot(folder: &Path, more: &str) -> Shot {
        let text = format!("frames = {{ first = 1, last = 600 }}\nsize = [96, 54]\n{more}\n[[layer]]\nname = 'all'\n");
        Shot::parse(&text, &folder.join("shot.toml")).expect("a shot")
    }

    #[test]
    fn plates_that_change_or_appear_are_found_though_the_sequence_is_long() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |frame: i32| folder.path().join(format!("plate.{frame:04}.exr"));
        for frame in [1, 3, 599] {
            fs::write(at(frame), "").expect("written");
        }
        let shot = shot(folder.path(), "plate = 'plate.####.exr'");
        let mut watch = PlateWatch::of(&shot);
        let mut round = || -> Vec<[i32; 2]> { (0..3).flat_map(|_| watch.look()).collect() };
        assert!(round().is_empty());
        let later = SystemTime::now() + Duration::from_secs(10);
        fs::File::options().write(true).open(at(599)).and_then(|file| file.set_modified(later)).expect("written");
        fs::write(at(2), "").expect("written");
        fs::remove_file(at(3)).expect("there");
        let mut found = round();
        found.sort_unstable();
        assert_eq!(found, [[2, 2], [599, 599]]);
        assert!(round().is_empty(), "it is told once");
        let longer = Shot { frames: crate::shot::FrameRange { last: 700, ..shot.frames }, ..shot.clone() };
        assert!(watch.is_of(&shot) && !watch.is_of(&longer));
    }

    #[test]
    fn a_single_plate_belongs_to_all_frames_and_plates_behind_a_scene_are_not_shown() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut watch = PlateWatch::of(&shot(folder.path(), "plate = 'plate.exr'"));
        fs::write(folder.path().join("plate.exr"), "").expect("written");
        assert_eq!(watch.look(), [[1, 600]]);
        let mut watch = PlateWatch::of(&shot(folder.path(), "plate = 'new.exr'\nscene = 'a.glb'"));
        fs::write(folder.path().join("new.exr"), "").expect("written");
        assert!(watch.look().is_empty());
    }
}
