//! The contents of a picture, and how `pinwarp warp` treats each of its channels.
//!
//! In: its path. Out: windows, parts, channels with their storage and meaning.

use super::Lines;
use crate::image::{Plate, Storage, read_any_head};
use crate::plate::{ChannelReport, Semantic, SemanticReason, WarpSettings, channel_semantics};
use crate::space::PixelRect;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
pub(super) struct PictureInfo {
    kind: &'static str,
    file: PathBuf,
    /// x and y of the upper left pixel, width, height.
    display_window: [i64; 4],
    pixel_aspect: f64,
    parts: Vec<PartInfo>,
}

#[derive(Serialize)]
struct PartInfo {
    name: Option<String>,
    view: Option<String>,
    compression: Option<String>,
    data_window: [i64; 4],
    channels: Vec<ChannelInfo>,
}

#[derive(Serialize)]
struct ChannelInfo {
    name: String,
    storage: &'static str,
    meaning: Semantic,
    reason: SemanticReason,
    warp: &'static str,
}

impl PictureInfo {
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let plate = read_any_head(path)?;
        let is_exr = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr"));
        let mut reports = channel_semantics(&plate, &WarpSettings::default()).into_iter();
        let parts = plate.parts.iter().map(|part| PartInfo {
            name: part.name.clone(),
            view: part.view.clone(),
            compression: is_exr.then(|| part.compression()),
            data_window: window(part.data_window),
            channels: part
                .channels
                .iter()
                .zip(&mut reports)
                .map(|(channel, report)| channel_info((&channel.name, channel.storage), &report))
                .collect(),
        });
        let parts = parts.collect();
        let Plate { display, pixel_aspect, .. } = plate;
        Ok(Self { kind: "picture", file: path.to_owned(), display_window: window(display), pixel_aspect, parts })
    }
}

fn window(rect: PixelRect) -> [i64; 4] {
    [rect.x.into(), rect.y.into(), rect.width.into(), rect.height.into()]
}

fn channel_info((name, storage): (&str, Storage), report: &ChannelReport) -> ChannelInfo {
    let storage = match storage {
        Storage::Half => "half",
        Storage::Float => "float",
        Storage::Uint => "uint",
    };
    let (meaning, reason) = (report.semantic, report.reason);
    ChannelInfo { name: name.to_owned(), storage, meaning, reason, warp: treatment(meaning) }
}

/// Describes how a warp treats channels of a meaning.
const fn treatment(meaning: Semantic) -> &'static str {
    match meaning {
        Semantic::Color => "filtered as colour",
        Semantic::Alpha => "filtered as coverage",
        Semantic::Depth => "depth: nearest sample, never blended",
        Semantic::Id => "ids: nearest sample, never blended",
        Semantic::Cryptomatte => "Cryptomatte: coverage resampled per id",
        Semantic::Forward => "motion to the next frame: warped and derived anew",
        Semantic::Backward => "motion to the previous frame: warped and derived anew",
        Semantic::Normal => "normals: nearest sample",
        Semantic::Data => "data: nearest sample, never blended",
    }
}

const fn source(reason: SemanticReason) -> &'static str {
    match reason {
        SemanticReason::Shot => "by the shot",
        SemanticReason::Metadata => "by the file's metadata",
        SemanticReason::Name => "by its name",
        SemanticReason::Guess => "a guess: say what it is in [[warp.channels]]",
    }
}

impl Lines for PictureInfo {
    fn lines(&self) -> Vec<String> {
        let [x, y, width, height] = self.display_window;
        let mut out = vec![format!("{}: {width} x {height} pixels from {x}, {y}", self.file.display())];
        if self.pixel_aspect != 1.0 {
            out.push(format!("pixel aspect: {}", self.pixel_aspect));
        }
        for (number, part) in self.parts.iter().enumerate() {
            let name = part.name.clone().unwrap_or_else(|| (number + 1).to_string());
            let view = part.view.as_ref().map(|view| format!(", view {view}")).unwrap_or_default();
            let compression = part.compression.as_ref().map(|name| format!(", compression {name}")).unwrap_or_default();
            let [x, y, width, height] = part.data_window;
            out.push(format!("part {name}: stored {width} x {height} from {x}, {y}{view}{compression}"));
            let channel = |channel: &ChannelInfo| {
                let ChannelInfo { name, storage, warp, reason, .. } = channel;
                format!("  {name} ({storage}): {warp} ({})", source(*reason))
            };
            out.extend(part.channels.iter().map(channel));
        }
        out
    }
}
