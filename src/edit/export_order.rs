//! What `pinwarp export` is asked for: a format and the options that it has.
//!
//! In: the user's choices. Out: arguments of the program.

use crate::space::FrameSize;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The flag that replaces files, which the program names where they are in the way.
pub(in crate::edit) const REPLACE: &str = "--overwrite";

/// A format of `pinwarp export --to`.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct ExportFormat {
    /// Its name on the command line.
    id: &'static str,
    /// Its display name.
    pub(crate) name: &'static str,
    /// Whether some of the layers can be exported.
    pub(crate) has_layers: bool,
    /// Whether it writes maps, which have a size and a margin.
    pub(crate) has_maps: bool,
    /// Whether its maps can undo the warp.
    pub(crate) has_inverse: bool,
}

const fn format(
    (id, name): (&'static str, &'static str),
    [has_layers, has_maps, has_inverse]: [bool; 3],
) -> ExportFormat {
    ExportFormat { id, name, has_layers, has_maps, has_inverse }
}

/// All formats.
pub(crate) static EXPORTS: [ExportFormat; 6] = [
    format(("lattice-json", "Lattices (JSON)"), [true, false, false]),
    format(("stmap", "STMaps (EXR)"), [true, true, true]),
    format(("nuke", "Nuke script"), [true, true, true]),
    format(("blender", "Blender script"), [false, false, false]),
    format(("gltf", "glTF with shape keys"), [false, false, false]),
    format(("after-effects", "After Effects script"), [true, true, false]),
];

/// An export as it is ordered.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ExportOrder {
    pub(crate) format: &'static ExportFormat,
    /// The file to write, relative to the folder of the shot; empty: the name that the program chooses beside the shot.
    pub(crate) output: String,
    /// A list of frames, "1-48x2,60"; empty: all.
    pub(crate) frames: String,
    /// Names of layers that are not exported.
    pub(crate) left_out: BTreeSet<String>,
    /// The size of the maps; `None`: the shot's.
    pub(crate) size: Option<[u32; 2]>,
    /// Pixels that the maps extend beyond the frame on each side.
    pub(crate) overscan: u32,
    /// Whether the maps undo the warp.
    pub(crate) is_inverse: bool,
    /// Whether existing files are replaced; else they are asked about.
    pub(crate) replaces: bool,
}

impl ExportOrder {
    /// Orders all of a shot in a format.
    pub(in crate::edit) fn of(format: &'static ExportFormat) -> Self {
        Self {
            format,
            output: String::new(),
            frames: String::new(),
            left_out: BTreeSet::new(),
            size: None,
            overscan: 0,
            is_inverse: false,
            replaces: false,
        }
    }

    /// Returns the pixels of the maps, for a shot of this size.
    pub(crate) fn pixels(&self, shot: FrameSize) -> [u32; 2] {
        self.size.unwrap_or([shot.width, shot.height])
    }

    /// Returns the arguments of the program for a shot with these layers.
    pub(in crate::edit) fn arguments<'a>(&self, shot: &Path, layers: impl Iterator<Item = &'a str>) -> Vec<OsString> {
        let mut all: Vec<OsString> = vec!["export".into(), shot.into(), "--to".into(), self.format.id.into()];
        let mut option = |flag: &str, value: String| all.extend([flag.into(), value.into()]);
        for (flag, text) in [("--output", &self.output), ("--frames", &self.frames)] {
            if !text.trim().is_empty() {
                option(flag, text.trim().to_owned());
            }
        }
        if self.format.has_layers && !self.left_out.is_empty() {
            let chosen: Vec<&str> = layers.filter(|name| !self.left_out.contains(*name)).collect();
            option("--layer", chosen.join(","));
        }
        if let Some([width, height]) = self.size.filter(|_| self.format.has_maps) {
            option("--size", format!("{width}x{height}"));
        }
        if self.overscan > 0 && self.format.has_maps {
            option("--overscan", self.overscan.to_string());
        }
        let flags = [(self.is_inverse && self.format.has_inverse, "--inverse"), (self.replaces, REPLACE)];
        all.extend(flags.into_iter().filter(|(is_set, _)| *is_set).map(|(_, flag)| flag.into()));
        all
    }

    /// Returns a chosen layer whose name cannot stand in a list, because it has a comma; `None` if all layers are exported.
    pub(in crate::edit) fn unlisted<'a>(&self, layers: impl Iterator<Item = &'a String>) -> Option<&'a String> {
        let is_list = self.format.has_layers && !self.left_out.is_empty();
        layers.filter(|name| !self.left_out.contains(*name)).find(|name| is_list && name.contains(','))
    }

    /// Returns a path in the folder of the files that are written; all their names begin with its stem.
    pub(in crate::edit) fn target(&self, shot: &Path) -> PathBuf {
        match self.output.trim() {
            "" => shot.to_owned(),
            output => shot.parent().unwrap_or(Path::new("")).join(output),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(order: &ExportOrder) -> String {
        let words = order.arguments(Path::new("/s/a.toml"), ["head", "tail", "hat"].into_iter());
        words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn only_the_options_that_a_format_has_are_passed_on() {
        let mut order = ExportOrder::of(&EXPORTS[1]);
        assert_eq!(words(&order), "export /s/a.toml --to stmap");
        order.left_out.insert("tail".into());
        (order.output, order.frames) = ("m/m.####.exr ".into(), "1-9x2".into());
        (order.size, order.overscan, order.is_inverse, order.replaces) = (Some([64, 36]), 8, true, true);
        let all =
            "--output m/m.####.exr --frames 1-9x2 --layer head,hat --size 64x36 --overscan 8 --inverse --overwrite";
        assert_eq!(words(&order), format!("export /s/a.toml --to stmap {all}"));
        assert_eq!(order.target(Path::new("/s/a.toml")), Path::new("/s/m/m.####.exr"));
        let names = ["head".to_owned(), "a, b".to_owned()];
        assert_eq!(order.unlisted(names.iter()), Some(&names[1]));
        assert_eq!(order.unlisted(names[..1].iter()), None);
        order.format = &EXPORTS[4];
        assert_eq!(order.unlisted(names.iter()), None, "it always exports all layers");
        assert_eq!(words(&order), "export /s/a.toml --to gltf --output m/m.####.exr --frames 1-9x2 --overwrite");
        order.format = &EXPORTS[5];
        assert!(words(&order).contains("--size") && !words(&order).contains("--inverse"));
    }
}
