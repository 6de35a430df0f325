//! Validates `plate`, `[warp]` and `matte`: the options of shots that warp finished frames.
//!
//! In: raw tables. Out: [`WarpSettings`], [`Matte`]s, paths, and the source that the shot's lattices deform.

use super::{Check, Kind, LayerDefaults};
use crate::image::{ImageError, SequencePath};
use crate::plate::{Holes, Matte, MotionEncoding, MotionUnit, WarpSettings};
use crate::shot::Source;
use crate::shot::raw::{
    RawHoles, RawHorizontal, RawLayer, RawMatte, RawMatteSource, RawMotion, RawMotionUnit, RawNamedMatte, RawNamedUnit,
    RawShot, RawSpace, RawVertical, RawWarp,
};
use std::path::{Path, PathBuf};

/// The suggestion for a shot without a scene, image or plate.
const SOURCES: &str = "write for example `scene = \"scene.glb\"`, `image = \"girl.png\"` for a drawing, or `plate = \"beauty.####.exr\"` \
    for finished frames";

impl Check<'_> {
    /// Returns the source that the lattices deform.
    pub(super) fn source(&mut self, raw: &RawShot) -> Source {
        if raw.image.is_some() && raw.scene.is_some() {
            self.fault("image", "excludes `scene`", "keep one of `image` and `scene`");
        }
        match (&raw.scene, &raw.image, &raw.plate) {
            (_, Some(image), _) => return Source::Images(self.images(image)),
            (None, None, Some(_)) => return Source::Frame,
            // A misspelt key, already reported, is the cause.
            (None, None, None) if !self.has_unknown_key(&["scene", "image"]) => {
                self.fault("scene", "is missing", SOURCES);
            }
            _ => {}
        }
        Source::Scene(self.folder().join(raw.scene.as_deref().unwrap_or_default()))
    }

    /// Returns a path that may contain a frame counter, unless a file has exactly this name.
    pub(super) fn plate_path(&mut self, raw: &str, key: &str) -> PathBuf {
        let path = self.folder().join(raw);
        if !path.is_file()
            && let Err(ImageError::Pattern { what, .. }) = SequencePath::parse(Path::new(raw))
        {
            let (what, hint) = what.split_once("; ").unwrap_or((&what, "write for example beauty.####.exr"));
            self.fault(key, format!("{raw:?} {what}"), hint);
        }
        path
    }

    /// Returns the settings of plate warps.
    pub(super) fn warp(&mut self, raw: &RawWarp, source: &Source) -> WarpSettings {
        let holes = match &raw.holes {
            RawHoles::Leave => Holes::Leave,
            RawHoles::Geometry => {
                if !matches!(source, Source::Scene(_)) {
                    let hint = "add `scene`, or give a clean plate: holes = { plate = \"clean.####.exr\" }";
                    self.fault("warp.holes", "the shot has no scene that could fill holes", hint);
                }
                Holes::Geometry
            }
            RawHoles::Plate(path) => Holes::Plate(self.plate_path(path, "warp.holes.plate")),
        };
        let (motion, motion_scale) = raw.motion.as_ref().map_or((None, MotionUnit::default()), motion);
        WarpSettings {
            filter: raw.filter,
            normals: raw.normals,
            motion,
            motion_scale,
            semantics: raw.channels.iter().map(|channel| (channel.name.clone(), channel.meaning)).collect(),
            holes,
        }
    }

    /// Returns the matte of the part of a plate that a layer moves.
    pub(super) fn matte(&mut self, raw: &RawMatte, key: &str, shot: &LayerDefaults) -> Option<Matte> {
        if shot.space == RawSpace::World {
            let what = "a plate is warped on the screen, this layer's lattice lies in the scene";
            self.fault(key, what, "remove it, or `space = \"world\"`");
        }
        if matches!(raw, RawMatte::Named(RawNamedMatte::Nodes)) && shot.source != Kind::Scene {
            self.fault(key, "\"nodes\" are those of a scene, and the shot has none", "use \"alpha\", a channel or ids");
        }
        match raw {
            RawMatte::Named(RawNamedMatte::Alpha) => Some(Matte::Alpha),
            RawMatte::Named(RawNamedMatte::Nodes | RawNamedMatte::None) => None,
            RawMatte::Part(part) => self.part(part, key),
        }
    }

    fn part(&mut self, raw: &RawMatteSource, key: &str) -> Option<Matte> {
        let RawMatteSource { channel, id, values, cryptomatte, of } = raw.clone();
        let lonely = [
            ("values", values.is_some() && id.is_none(), "id"),
            ("of", of.is_some() && cryptomatte.is_none(), "cryptomatte"),
        ];
        for (name, _, owner) in lonely.iter().filter(|(_, is_lonely, _)| *is_lonely) {
            self.fault(
                &format!("{key}.{name}"),
                format!("belongs to `{owner}`"),
                format!("remove it or add `{owner}`"),
            );
        }
        match (channel, id, cryptomatte) {
            (Some(channel), None, None) => Some(Matte::Channel(channel)),
            (None, Some(channel), None) => {
                let Some(values) = values else {
                    self.fault(&format!("{key}.values"), "is missing", "list the ids of the layer: values = [3]");
                    return None;
                };
                Some(Matte::Id { channel, values })
            }
            (None, None, Some(names)) => Some(Matte::Cryptomatte { layer: of, names }),
            (None, None, None) => {
                let hint =
                    "give one of channel = \"mask.R\", id = \"id.object\", cryptomatte = [\"Body*\"], or \"alpha\"";
                self.fault(key, "does not say what it selects", hint);
                None
            }
            _ => {
                let hint = "keep one of them, and make a layer for each part";
                self.fault(key, "names channel, id and cryptomatte, or two of them", hint);
                None
            }
        }
    }

    /// Rejects layer keys that require a scene.
    pub(super) fn plate_layer(&mut self, raw: &RawLayer, key: &str, shot: &LayerDefaults) {
        match shot.source {
            Kind::Scene => return,
            Kind::Images => return self.image_layer(raw, key),
            Kind::Frame => {}
        }
        let parts = [("nodes", raw.nodes.is_some()), ("stiffness", !raw.stiffness.is_empty())];
        for (part, _) in parts.iter().filter(|(_, is_given)| *is_given) {
            let hint = "remove it, or add the `scene` that the plate shows; `matte` selects a part of a plate";
            self.fault(&format!("{key}.{part}"), "names parts of a scene, and this shot has none", hint);
        }
        if raw.lattice.space == RawSpace::World {
            let hint = "remove it, or add the `scene` that the plate shows";
            self.fault(&format!("{key}.lattice.space"), "a plate is warped on the screen", hint);
        }
        for (index, _) in raw
            .pin
            .iter()
            .enumerate()
            .filter(|(_, pin)| pin.anchor.as_ref().is_some_and(|anchor| anchor.node.is_some()))
        {
            let hint = "give a point of the screen: anchor = { screen = [0.9, 0.5] }";
            self.fault(&format!("{key}.pin[{index}].anchor.node"), "this shot has no scene with nodes", hint);
        }
    }

    pub(super) fn folder(&self) -> PathBuf {
        self.document.path.parent().unwrap_or(Path::new("")).to_owned()
    }
}

/// Returns the motion encoding and its unit: pixels or frame sizes.
fn motion(raw: &RawMotion) -> (Option<MotionEncoding>, MotionUnit) {
    let (unit, scale) = match raw.unit {
        RawMotionUnit::Named(RawNamedUnit::Pixels) => ([1.0; 2], MotionUnit::Pixels),
        RawMotionUnit::Number(pixels) => ([pixels; 2], MotionUnit::Pixels),
        RawMotionUnit::Named(RawNamedUnit::Frame) => ([1.0; 2], MotionUnit::Frame),
    };
    let x = if raw.x == RawHorizontal::Left { -unit[0] } else { unit[0] };
    let y = if raw.y == RawVertical::Down { -unit[1] } else { unit[1] };
    (Some(MotionEncoding { pixels_per_unit: [x, y] }), scale)
}
