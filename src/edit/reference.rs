//! Reference pictures above or below the frame, for matching by eye, such as a director's draw-over. They belong to the
//! window, not to the shot.
//!
//! In: pictures or sequences. Out: their pictures of a frame, each decoded by a thread of its own.

use super::EditError;
use super::picture::{Picture, Quality};
use crate::image::{SequencePath, read_any};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::SystemTime;

/// A reference picture.
#[derive(Debug)]
pub(crate) struct Reference {
    path: PathBuf,
    /// Opacity, 0 to 1.
    pub(crate) opacity: f32,
    /// Whether it is drawn above the frame; else below.
    pub(crate) is_above: bool,
    /// Offset to the right and up, in frame heights.
    pub(crate) offset: [f32; 2],
    /// Its height in frame heights.
    pub(crate) scale: f32,
    /// Whether it shows what was rendered, in place of the frame.
    pub(crate) is_rendered: bool,
    /// The file that was decoded last, and its picture, if it could be decoded.
    decoded: Option<(FileState, Option<Arc<Picture>>)>,
    /// The file that is being decoded, and where its picture arrives.
    pending: Option<(FileState, Receiver<Result<Picture, String>>)>,
    /// What is wrong with the file that was decoded last, until it is told.
    fault: Option<String>,
}

/// A file as it was found.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FileState {
    path: PathBuf,
    written: Option<SystemTime>,
}

impl FileState {
    fn of(path: PathBuf) -> std::io::Result<Self> {
        let written = fs::metadata(&path)?.modified().ok();
        Ok(Self { path, written })
    }
}

impl Reference {
    /// Opens a picture, or a path with a frame counter; it is decoded later.
    ///
    /// # Errors
    /// [`EditError`] if there is no such file.
    pub(crate) fn open(path: &Path, frame: i32) -> Result<Self, EditError> {
        let (opacity, is_above, offset, scale) = (0.5, true, [0.0; 2], 1.0);
        let (decoded, pending, fault) = (None, None, None);
        let (path, is_rendered) = (path.to_owned(), false);
        let reference = Self { path, opacity, is_above, offset, scale, is_rendered, decoded, pending, fault };
        let file = reference.file_of(frame)?;
        FileState::of(file.clone()).map_err(|source| EditError::Io { path: file, source })?;
        Ok(reference)
    }

    /// Returns whether it shows this picture or sequence.
    pub(crate) fn is_of(&self, path: &Path) -> bool {
        self.path == path
    }

    /// Returns the name of its file.
    #[must_use]
    pub(crate) fn name(&self) -> String {
        self.path
            .file_name()
            .map_or_else(|| self.path.display().to_string(), |name| name.to_string_lossy().into_owned())
    }

    /// Returns the picture of a frame, or until that is decoded the one before; `None` if the sequence lacks it, or it cannot be decoded.
    pub(crate) fn at(&mut self, frame: i32) -> Option<Arc<Picture>> {
        self.collect();
        let wanted = FileState::of(self.file_of(frame).ok()?).ok()?;
        let is_known = self.decoded.as_ref().is_some_and(|(known, _)| *known == wanted);
        if !is_known && self.pending.is_none() {
            self.begin(wanted);
        }
        self.decoded.as_ref()?.1.clone()
    }

    /// Returns whether a picture is being decoded.
    pub(crate) const fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    /// Returns what is wrong with a file, once for each state of it.
    pub(crate) const fn take_fault(&mut self) -> Option<String> {
        self.fault.take()
    }

    /// Begins to decode a file.
    fn begin(&mut self, file: FileState) {
        let (sender, receiver) = channel();
        let path = file.path.clone();
        let work = move || {
            let read = read_any(&path).map_err(|error| error.to_string());
            // Nobody waits for a picture that was removed.
            let _ = sender.send(read.map(|plate| Picture::of(&plate.into_frame(), (0, 0), Quality::Final)));
        };
        match std::thread::Builder::new().name("edit: reference".into()).spawn(work) {
            Ok(_) => self.pending = Some((file, receiver)),
            Err(error) => self.fail(file, format!("no thread can be started: {error}")),
        }
    }

    /// Takes the picture that was decoded, if it has arrived.
    fn collect(&mut self) {
        let Some((file, receiver)) = self.pending.take() else { return };
        match receiver.try_recv() {
            Ok(Ok(picture)) => self.decoded = Some((file, Some(Arc::new(picture)))),
            Ok(Err(error)) => self.fail(file, error),
            Err(TryRecvError::Disconnected) => {
                let what = format!("{}: it cannot be decoded: internal error", file.path.display());
                self.fail(file, what);
            }
            Err(TryRecvError::Empty) => self.pending = Some((file, receiver)),
        }
    }

    fn fail(&mut self, file: FileState, what: String) {
        self.decoded = Some((file, None));
        self.fault = Some(what);
    }

    fn file_of(&self, frame: i32) -> Result<PathBuf, EditError> {
        if self.path.is_file() {
            return Ok(self.path.clone());
        }
        Ok(SequencePath::of_input(&self.path)?.path_of(frame))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Preview, write_png};
    use std::time::{Duration, Instant};

    /// Waits until nothing is being decoded; returns the picture of a frame.
    fn settled(reference: &mut Reference, frame: i32) -> Option<Arc<Picture>> {
        let begun = Instant::now();
        loop {
            let picture = reference.at(frame);
            if !reference.is_pending() {
                return picture;
            }
            assert!(begun.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_broken_picture_is_told_once_and_tried_again_when_it_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let [one, two] = [1, 2].map(|frame| folder.path().join(format!("draw.{frame:04}.png")));
        write_png(&one, &Preview::transparent(16, 9)).expect("written");
        fs::write(&two, "no picture").expect("written");
        let pattern = folder.path().join("draw.####.png");
        assert!(Reference::open(&pattern, 3).is_err(), "there is none");
        let mut reference = Reference::open(&pattern, 1).expect("there");
        assert!(reference.at(1).is_none() && reference.is_pending(), "it does not wait");
        assert_eq!(settled(&mut reference, 1).map(|picture| picture.size), Some([16, 9]));
        assert!(settled(&mut reference, 2).is_none());
        assert!(reference.take_fault().is_some_and(|fault| fault.contains("draw.0002.png")));
        assert!(settled(&mut reference, 2).is_none() && reference.take_fault().is_none(), "it is told once");
        write_png(&two, &Preview::transparent(8, 8)).expect("written");
        let later = SystemTime::now() + Duration::from_secs(10);
        fs::File::options().write(true).open(&two).and_then(|file| file.set_modified(later)).expect("written");
        assert_eq!(settled(&mut reference, 2).map(|picture| picture.size), Some([8, 8]));
        assert!(reference.at(3).is_none() && !reference.is_pending(), "the sequence lacks it");
    }
}
