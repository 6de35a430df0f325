//! File names of frame sequences.
//!
//! In: `frame.####.exr`, `frame.%04d.exr`, or a plain path. Out: the path of each frame.

use super::ImageError;
#[cfg(feature = "cli")]
use super::PictureKind;
#[cfg(feature = "cli")]
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A path with at most one frame counter, in the file name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SequencePath {
    pattern: PathBuf,
    name: Name,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Name {
    Single,
    /// Minimum width of the counter including the sign, as in `printf` and Nuke.
    Counted {
        before: String,
        width: usize,
        after: String,
    },
}

impl SequencePath {
    /// Parses any number of `#`, `%d` and `%04d` in the file name; a name without a counter denotes a single frame. `#`
    /// and `%` in directory names are literal.
    ///
    /// # Errors
    /// [`ImageError::Pattern`] for two counters, for printf forms other than `%d` and `%04d`, and for a missing file name.
    pub(crate) fn parse(pattern: &Path) -> Result<Self, ImageError> {
        let wrong = |what: String| ImageError::Pattern { pattern: shortened(pattern), what };
        let Some(file_name) = pattern.file_name() else {
            return Err(wrong("does not end in a file name; write for example frame.####.exr".into()));
        };
        let name = match file_name.to_str() {
            Some(name) => parse_name(name).map_err(wrong)?,
            None if file_name.as_encoded_bytes().iter().any(|byte| b"#%".contains(byte)) => {
                return Err(wrong("has a frame counter in a name that is not valid Unicode; rename it".into()));
            }
            None => Name::Single,
        };
        Ok(Self { pattern: pattern.to_owned(), name })
    }

    /// As [`Self::parse`], of files that are read: a file with exactly this name is a single picture, whatever its name.
    ///
    /// # Errors
    /// Those of [`Self::parse`], if there is no such file.
    pub(crate) fn of_input(pattern: &Path) -> Result<Self, ImageError> {
        if pattern.is_file() {
            return Ok(Self { pattern: pattern.to_owned(), name: Name::Single });
        }
        Self::parse(pattern)
    }

    /// Returns the path of frame number `frame`; that of a single frame does not depend on the number.
    #[must_use]
    pub(crate) fn path_of(&self, frame: i32) -> PathBuf {
        match &self.name {
            Name::Single => self.pattern.clone(),
            Name::Counted { before, width, after } => {
                self.pattern.with_file_name(format!("{before}{frame:0width$}{after}"))
            }
        }
    }

    /// Returns the path with its counter, as given.
    #[cfg(feature = "cli")]
    pub(crate) fn pattern(&self) -> &Path {
        &self.pattern
    }

    /// Whether each frame has its own file.
    #[must_use]
    pub(crate) fn has_counter(&self) -> bool {
        self.name != Name::Single
    }

    /// Returns the common name of the frames: the file name without counter, preceding separators and extension.
    #[cfg(any(test, feature = "cli"))]
    #[must_use]
    pub(crate) fn stem(&self) -> String {
        let stem = self.pattern.file_stem().unwrap_or_default().to_string_lossy();
        match &self.name {
            Name::Single => stem.into_owned(),
            Name::Counted { before, after, .. } => {
                let after = after.rsplit_once('.').map_or("", |(after, _)| after);
                format!("{}{after}", before.trim_end_matches(['.', '_', '-']))
            }
        }
    }

    /// Returns the numbers of the existing frames, increasing; empty if there are none or the directory does not exist.
    /// `None` for a path without a counter.
    ///
    /// # Errors
    /// [`ImageError::Io`] if the directory cannot be listed.
    pub(crate) fn frames_on_disk(&self) -> Result<Option<Vec<i32>>, ImageError> {
        if !self.has_counter() {
            return Ok(None);
        }
        let folder = self.pattern.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let entries = match std::fs::read_dir(folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Some(Vec::new())),
            Err(error) => return Err(ImageError::reading(folder, error)),
        };
        let names = entries.filter_map(|entry| Some(entry.ok()?.file_name()));
        let mut frames: Vec<i32> = names.filter_map(|name| self.frame_named(name.to_str()?)).collect();
        frames.sort_unstable();
        Ok(Some(frames))
    }

    /// Finds the sequences in a directory: picture files whose names differ only in the last number, with the width of
    /// the shortest. Previews (PNG files beside EXR files of the same name) are excluded.
    ///
    /// # Errors
    /// [`ImageError::Io`] if the directory cannot be listed.
    #[cfg(feature = "cli")]
    pub(crate) fn in_folder(folder: &Path) -> Result<Vec<Self>, ImageError> {
        let entries = std::fs::read_dir(folder).map_err(|error| ImageError::reading(folder, error))?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let names: BTreeSet<String> = names.collect();
        let mut widths: BTreeMap<(String, String), usize> = BTreeMap::new();
        for name in names.iter().filter(|name| PictureKind::of(Path::new(name)).is_some()) {
            let Some((stem, ending)) = name.rsplit_once('.') else { continue };
            let before = stem.trim_end_matches(|letter: char| letter.is_ascii_digit());
            let before = before.strip_suffix('-').filter(|before| before.ends_with(['.', '_'])).unwrap_or(before);
            let digits = stem.len() - before.len();
            if digits > 0 && !before.contains(['#', '%']) {
                let width = widths.entry((before.to_owned(), ending.to_owned())).or_insert(digits);
                *width = digits.min(*width);
            }
        }
        let is_preview = |(before, ending): &(String, String)| {
            ending == "png" && widths.contains_key(&(before.clone(), "exr".to_owned()))
        };
        let found = widths.iter().filter(|(name, _)| !is_preview(name));
        let path = |((before, ending), &width): (&(String, String), &usize)| {
            let pattern = folder.join(format!("{before}{}.{ending}", "#".repeat(width)));
            Self { pattern, name: Name::Counted { before: before.clone(), width, after: format!(".{ending}") } }
        };
        Ok(found.map(path).collect())
    }

    /// Returns the frame number of a file name; `None` if it does not match the pattern, or the path has no counter:
    /// `f.7.exr` is not frame 7 of `f.####.exr`.
    #[must_use]
    pub(crate) fn frame_named(&self, name: &str) -> Option<i32> {
        let Name::Counted { before, after, .. } = &self.name else { return None };
        let frame = name.strip_prefix(before.as_str())?.strip_suffix(after.as_str())?.parse().ok()?;
        self.path_of(frame).file_name().is_some_and(|own| own == name).then_some(frame)
    }

    /// Checks that every frame of a range gets its own file.
    ///
    /// # Errors
    /// [`ImageError::Pattern`] if there are several frames and no counter.
    pub(crate) fn check_frame_count(&self, count: usize) -> Result<(), ImageError> {
        if count <= 1 || self.has_counter() {
            return Ok(());
        }
        let stem = self.pattern.file_stem().unwrap_or_default().to_string_lossy();
        let extension = self.pattern.extension().unwrap_or(std::ffi::OsStr::new("exr")).to_string_lossy();
        let what = format!("has no frame counter for {count} frames; write {stem}.####.{extension}");
        Err(ImageError::Pattern { pattern: self.pattern.clone(), what })
    }
}

/// Returns a path with `_` for each `#` and `%` of its file name, so that a frame counter can be added to it.
pub(crate) fn without_counter(path: &Path) -> PathBuf {
    let name = path.file_name().and_then(|name| name.to_str());
    name.map_or_else(|| path.to_owned(), |name| path.with_file_name(name.replace(['#', '%'], "_")))
}

/// Shortens a path for display: overlong invalid names would fill the screen.
fn shortened(pattern: &Path) -> PathBuf {
    const SHOWN: usize = 300;
    let text = pattern.to_string_lossy();
    if text.len() <= SHOWN {
        return pattern.to_owned();
    }
    PathBuf::from(format!("{}...", text.chars().take(SHOWN).collect::<String>()))
}

/// Maximum width of a counter: file names are limited to 255 bytes everywhere.
const LONGEST_COUNTER: usize = 255;

fn parse_name(name: &str) -> Result<Name, String> {
    let Some((start, end, width)) = find_counter(name)? else { return Ok(Name::Single) };
    let (before, after) = (name[..start].to_owned(), name[end..].to_owned());
    if find_counter(&after)?.is_some() {
        return Err("has two frame counters; keep one run of # or one %04d".into());
    }
    Ok(Name::Counted { before, width, after })
}

/// Returns start and end (in bytes) of the first counter, and its width.
fn find_counter(name: &str) -> Result<Option<(usize, usize, usize)>, String> {
    let Some(start) = name.find(['#', '%']) else { return Ok(None) };
    let rest = &name[start..];
    if rest.starts_with('#') {
        let width = rest.bytes().take_while(|&byte| byte == b'#').count();
        if width > LONGEST_COUNTER {
            return Err(format!("has a counter of {width} characters, longer than any file name; write ####"));
        }
        return Ok(Some((start, start + width, width)));
    }
    let digits = rest[1..].bytes().take_while(u8::is_ascii_digit).count();
    let number = &rest[1..=digits];
    let is_printf = rest[1 + digits..].starts_with('d') && (number.is_empty() || number.starts_with('0'));
    let width = if number.is_empty() { Some(1) } else { number.parse().ok().filter(|&width| width <= LONGEST_COUNTER) };
    match width.filter(|_| is_printf) {
        Some(width) => Ok(Some((start, start + digits + 2, width))),
        None => Err(format!("has '%{number}' in its name, which is not a frame counter; write #### or %04d")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path_of(pattern: &str, frame: i32) -> String {
        SequencePath::parse(Path::new(pattern)).expect(pattern).path_of(frame).display().to_string().replace('\\', "/")
    }

    #[test]
    fn counters_are_filled_like_in_nuke() {
        for (pattern, frame, path) in [
            ("a/frame.####.exr", 101, "a/frame.0101.exr"),
            ("frame.####.exr", -1, "frame.-001.exr"),
            ("frame.####.exr", 123_456, "frame.123456.exr"),
            ("frame_#.exr", 12, "frame_12.exr"),
            ("########.exr", 5, "00000005.exr"),
            ("frame.%04d.exr", 7, "frame.0007.exr"),
            ("frame.%04d.exr", -7, "frame.-007.exr"),
            ("frame.%d.exr", -7, "frame.-7.exr"),
            ("%08d", i32::MIN, "-2147483648"),
            ("take#3/100%/frame.##.exr", 1, "take#3/100%/frame.01.exr"),
            ("still.exr", 12, "still.exr"),
            ("Bild_ä.###.exr", 3, "Bild_ä.003.exr"),
        ] {
            assert_eq!(path_of(pattern, frame), path);
        }
    }

    #[test]
    fn a_file_of_exactly_this_name_is_no_sequence() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["girl#2.png", "a.####.##.exr", "100%.png", "%04d.png"] {
            let path = folder.path().join(name);
            let before = SequencePath::of_input(&path).ok();
            assert_eq!(before, SequencePath::parse(&path).ok(), "{name} is not there yet");
            std::fs::write(&path, "").expect("written");
            let input = SequencePath::of_input(&path).expect(name);
            assert_eq!((input.has_counter(), input.path_of(7)), (false, path), "{name}");
        }
        std::fs::create_dir(folder.path().join("d#.png")).expect("a folder");
        assert!(SequencePath::of_input(&folder.path().join("d#.png")).expect("a counter").has_counter());
    }

    #[test]
    fn frames_on_disk_are_those_the_pattern_would_give() {
        let folder = tempfile::tempdir().expect("a folder");
        let names = ["a.0003.exr", "a.-001.exr", "a.12345.exr", "a.7.exr", "a.00008.exr", "a.+009.exr", "a.0003.png"];
        names.iter().for_each(|name| std::fs::write(folder.path().join(name), "").expect("written"));
        let on_disk = |name: &str| SequencePath::parse(&folder.path().join(name)).expect("a name").frames_on_disk();
        assert_eq!(on_disk("a.####.exr").expect("listed"), Some(vec![-1, 3, 12345]));
        assert_eq!(on_disk("a.#.exr").expect("listed"), Some(vec![7, 12345]));
        assert_eq!(on_disk("b.####.exr").expect("listed"), Some(vec![]));
        assert_eq!(on_disk("nowhere/a.####.exr").expect("listed"), Some(vec![]));
        assert_eq!(on_disk("a.0003.exr").expect("no counter"), None);
    }

    #[cfg(feature = "cli")]
    #[test]
    fn sequences_of_a_folder_are_those_of_their_names() {
        let folder = tempfile::tempdir().expect("a folder");
        let names =
            ["a.0003.exr", "a.-001.exr", "a.12345.exr", "a.0003.png", "b_7.png", "b_12.png", "still.exr", "c.0001.txt"];
        names.iter().for_each(|name| std::fs::write(folder.path().join(name), "").expect("written"));
        let found = SequencePath::in_folder(folder.path()).expect("listed");
        let patterns: Vec<_> = found.iter().map(|path| path.pattern.strip_prefix(&folder).expect("in it")).collect();
        assert_eq!(patterns, [Path::new("a.####.exr"), Path::new("b_#.png")]);
        assert_eq!(found[0].frames_on_disk().expect("listed"), Some(vec![-1, 3, 12345]));
        assert_eq!(found[1].frames_on_disk().expect("listed"), Some(vec![7, 12]));
        assert!(SequencePath::in_folder(&folder.path().join("nowhere")).is_err());
    }

    #[test]
    fn names_lose_their_counters() {
        for (path, plain) in [
            ("take#1/s#1.toml", "take#1/s_1.toml"),
            ("s%04d", "s_04d"),
            ("sh v2 100%", "sh v2 100_"),
            ("shot", "shot"),
            ("", ""),
        ] {
            assert_eq!(without_counter(Path::new(path)), Path::new(plain));
        }
    }

    #[test]
    fn errors_say_what_to_write() {
        for (pattern, part) in [
            ("a.####.##.exr", "two frame counters"),
            ("a.####.%04d.exr", "two frame counters"),
            ("a.%4d.exr", "write #### or %04d"),
            ("a.%s.exr", "write #### or %04d"),
            ("a.%", "write #### or %04d"),
            ("a.%0999d.exr", "write #### or %04d"),
            ("out/..", "does not end in a file name"),
            ("", "does not end in a file name"),
        ] {
            let error = SequencePath::parse(Path::new(pattern)).expect_err(pattern).to_string();
            assert!(error.contains(part), "{pattern}: {error}");
        }
        for width in [256, 70_000, 1 << 20] {
            let error = SequencePath::parse(Path::new(&"#".repeat(width))).expect_err("too long").to_string();
            assert!(error.contains("longer than any file name") && error.len() < 1000, "{width}: {error}");
        }
        assert!(SequencePath::parse(Path::new(&"#".repeat(255))).is_ok());
    }

    #[test]
    #[cfg(unix)]
    fn names_that_are_not_unicode_are_single_frames() {
        use std::os::unix::ffi::OsStrExt;
        let parse = |name: &[u8]| SequencePath::parse(Path::new(std::ffi::OsStr::from_bytes(name)));
        let single = parse(b"out/\xff.exr").expect("a plain path");
        assert_eq!(single.path_of(7).as_os_str().as_bytes(), b"out/\xff.exr");
        let counted = parse(b"\xff\xfe/a.##.exr").expect("folders may be called anything");
        assert_eq!(counted.path_of(7).as_os_str().as_bytes(), b"\xff\xfe/a.07.exr");
        for name in [b"\xff.####.exr".as_slice(), b"\xff.%04d.exr"] {
            assert!(parse(name).expect_err("no counter").to_string().contains("not valid Unicode"));
        }
    }

    #[test]
    fn several_frames_need_a_counter() {
        let single = SequencePath::parse(Path::new("out/still.exr")).expect("a plain path");
        assert!(single.check_frame_count(1).is_ok());
        let error = single.check_frame_count(48).expect_err("48 frames in one file").to_string();
        assert!(error.contains("48 frames") && error.contains("still.####.exr"), "{error}");
        assert!(SequencePath::parse(Path::new("a.#.exr")).expect("a counter").check_frame_count(48).is_ok());
    }

    #[test]
    fn the_stem_is_the_common_name_of_the_frames() -> Result<(), crate::image::ImageError> {
        use crate::image::SequencePath;
        use std::path::Path;
        for pattern in ["out/frame.%04d.exr", "out/frame.####.exr", "frame.exr"] {
            assert_eq!(SequencePath::parse(Path::new(pattern))?.stem(), "frame");
        }
        Ok(())
    }
}
