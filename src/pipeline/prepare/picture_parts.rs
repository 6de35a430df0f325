//! The parts into which a mask, ids or the lines of a drawing divide a picture.
//!
//! In: a cut of a picture. Out: the part of every pixel or triangle, or a [`KeyFault`] with its key within the cut. Lines that two cuts choose go to one of them.

use super::rest_mesh::RestMesh;
use crate::image::{
    CHOSEN, LabelMap, LineRule, NO_LABEL, OTHER, PaintedMap, Plate, are_of_one_shape, flat_colors, read_any,
};
use crate::key_fault::KeyFault;
use crate::pipeline::PipelineError;
use crate::pipeline::pictures::{drawing_in, drawing_of};
use crate::plate::{PlateError, channel_labels, chosen_labels, cryptomatte_labels};
use crate::shot::{Anchor, Cut, IdChoice, IdPicture, Layer, LineArt, PaintedMask, Selection, Shot};
use crate::space::{FrameSize, uv_from_screen};
use std::collections::BTreeMap;
use std::path::Path;

/// Number of places along each side of a triangle at which its part is looked up.
const PLACES: usize = 6;

/// The parts into which a cut divides a frame.
pub(super) struct PartMap {
    /// The part of every pixel.
    pub(super) map: LabelMap,
    /// #pixels: the area of the region to which a chosen line belongs, in pixels; 0 elsewhere. Empty if no region is chosen.
    lines: Vec<u32>,
}

impl From<LabelMap> for PartMap {
    fn from(map: LabelMap) -> Self {
        Self { map, lines: Vec::new() }
    }
}

/// Leaves lines that several cuts choose to that with the smaller region, of equal ones to the first.
pub(super) fn share_lines(parts: &mut [Option<PartMap>]) {
    for second in 1..parts.len() {
        let (before, [after, ..]) = parts.split_at_mut(second) else { return };
        let Some(after) = after else { continue };
        let size = after.map.size;
        for before in before.iter_mut().flatten().filter(|before| before.map.size == size) {
            for pixel in 0..before.lines.len().min(after.lines.len()) {
                let [first, second] = [before.lines[pixel], after.lines[pixel]];
                if first > 0 && second > 0 {
                    let loser = if first <= second { &mut *after } else { &mut *before };
                    (loser.lines[pixel], loser.map.labels[pixel]) = (0, OTHER);
                }
            }
        }
    }
}

/// A picture of a shot.
pub(super) struct PictureParts<'a> {
    /// The shot.
    pub(super) shot: &'a Shot,
    /// The layer that moves it.
    pub(super) layer: &'a Layer,
    /// Name of the picture.
    pub(super) name: &'a str,
}

impl PictureParts<'_> {
    /// Returns the parts into which a cut divides the frame; `None` for strokes, and for cuts that name nothing of a picture.
    pub(super) fn of(&self, cut: &Cut) -> Result<Option<PartMap>, KeyFault> {
        match cut {
            Cut::Ids(ids) => self.by_ids(ids).map(|map| Some(map.into())),
            Cut::Regions(lines) => self.by_regions(lines).map(Some),
            Cut::Part { selection: Selection { mask: Some(mask), .. }, .. } => {
                self.painted(mask).map(|map| Some(map.into()))
            }
            Cut::Part { .. } | Cut::Stroke(_) | Cut::SceneStroke { .. } => Ok(None),
        }
    }

    /// Returns [`CHOSEN`] where a mask that lies over the frame is painted, [`OTHER`] elsewhere.
    fn painted(&self, mask: &PaintedMask) -> Result<LabelMap, KeyFault> {
        let PaintedMap { size, values } = PaintedMap::read(&mask.file, mask.channel.index()).map_err(|error| {
            KeyFault::new("mask.file", error.to_string(), "give a PNG, JPEG or EXR file of the picture's shape")
        })?;
        self.check_shape("mask", size)?;
        let label = |value: f32| if value > 0.5 { CHOSEN } else { OTHER };
        Ok(LabelMap { size, labels: values.into_iter().map(label).collect() })
    }

    /// Returns the parts by the ids of a picture over the frame.
    fn by_ids(&self, picture: &IdPicture) -> Result<LabelMap, KeyFault> {
        const KEY: &str = "ids.file";
        let plate = read_any(&picture.file)
            .map_err(|error| KeyFault::new(KEY, error.to_string(), "give a PNG or EXR file of the picture's shape"))?;
        let FrameSize { width, height, .. } = plate.frame_size();
        self.check_shape("ids", [width, height])?;
        let missing = |error: PlateError| missing(&picture.file, error);
        match &picture.ids {
            IdChoice::Chosen(matte) => chosen_labels(&plate, matte).map_err(missing),
            IdChoice::EachOfChannel(channel) => channel_labels(&plate, channel).map_err(missing),
            IdChoice::Each(of) => match cryptomatte_labels(&plate, of.as_deref()).map_err(missing)? {
                Some(map) => Ok(map),
                None => colors_of(&plate, &picture.file),
            },
        }
    }

    /// Returns the parts by the regions that lines close.
    fn by_regions(&self, lines: &LineArt) -> Result<PartMap, KeyFault> {
        let found = match &lines.file {
            Some(file) => drawing_in(self.shot, file),
            None => drawing_of(self.shot, self.name),
        };
        let unread =
            |what: String| KeyFault::new("regions.file", what, "give a picture of the lines: a PNG, JPEG or EXR file");
        let found = found.map_err(|error| match error {
            PipelineError::Mismatch { what, .. } => unread(what),
            error => unread(error.to_string()),
        })?;
        let (drawing, size) = found.ok_or_else(|| unread("the picture is empty".to_owned()))?;
        self.check_shape("regions", size)?;
        let LineArt { threshold, gap, line, .. } = *lines;
        let regions = drawing.regions(LineRule { threshold, gap, line });
        if regions.areas.is_empty() {
            let hint = "lower `threshold` if the lines are faint, `gap` if the regions are narrow";
            return Err(KeyFault::new("regions", "the drawing has no closed region", hint));
        }
        if lines.at.is_empty() {
            return Ok(regions.map(&self.regions_with_pins(&regions.inside)).into());
        }
        let chosen = self.regions_at(&lines.at, &regions.inside)?;
        let mut map = regions.map(&chosen);
        let part = |(pixel, label): (usize, &mut u32)| {
            let area = if chosen.contains(label) { regions.areas[*label as usize - 1] as u32 } else { 0 };
            *label = if area > 0 { CHOSEN } else { OTHER };
            if regions.is_ink(pixel) { area } else { 0 }
        };
        let lines = map.labels.iter_mut().enumerate().map(part).collect();
        Ok(PartMap { map, lines })
    }

    /// Returns the regions that hold a pin of the layer which is placed on the screen.
    fn regions_with_pins(&self, inside: &LabelMap) -> Vec<u32> {
        let places = self.layer.pins.iter().filter_map(|pin| match pin.anchor {
            Anchor::Screen { at, .. } => Some(inside.at(uv_from_screen(at.0.to_array(), self.shot.size.aspect()))),
            Anchor::Surface { .. } => None,
        });
        places.collect()
    }

    /// Returns the regions that contain points.
    fn regions_at(&self, points: &[[f64; 2]], inside: &LabelMap) -> Result<Vec<u32>, KeyFault> {
        let aspect = self.shot.size.aspect();
        let region = |(number, &[x, y]): (usize, &[f64; 2])| {
            let key = format!("regions.at[{number}]");
            if !(0.0..=aspect).contains(&x) || !(0.0..=1.0).contains(&y) {
                let what = format!("{x}, {y} lies outside the picture");
                let hint = format!("give x from 0 to {aspect:.4} and y from 0 to 1, in frame heights, y up");
                return Err(KeyFault::new(key, what, hint));
            }
            match inside.at(uv_from_screen([x, y], aspect)) {
                NO_LABEL => {
                    let what = format!("{x}, {y} lies on a line, or outside of what the lines close");
                    Err(KeyFault::new(
                        key,
                        what,
                        "move it into a region; lower `gap` or `line` if the region is narrow",
                    ))
                }
                region => Ok(region),
            }
        };
        points.iter().enumerate().map(region).collect()
    }

    fn check_shape(&self, key: &str, size: [u32; 2]) -> Result<(), KeyFault> {
        let FrameSize { width, height, .. } = self.shot.size;
        if are_of_one_shape(size, [width, height]) {
            return Ok(());
        }
        let [w, h] = size;
        let what = match key {
            "mask" => format!("the mask has {w} x {h} pixels, the picture {width} x {height}"),
            _ => format!("the file has {w} x {h} pixels, the picture {width} x {height}"),
        };
        let hint = "paint it over the picture; other sizes of that shape will do";
        Err(KeyFault::new(format!("{key}.file"), what, hint))
    }
}

/// Returns the part that has most of each triangle of a picture in a frame of this size; of equal shares, the one with the smaller label.
pub(super) fn parts_of_triangles(mesh: &RestMesh, map: &LabelMap, size: FrameSize) -> Vec<u32> {
    let shares: Vec<[f64; 3]> = (0..PLACES)
        .flat_map(|i| (0..PLACES - i).map(move |j| [i, j, PLACES - 1 - i - j]))
        // The middles of equal cells, so that no place lies on a side.
        .map(|counts| counts.map(|count| (count as f64 + 1.0 / 3.0) / PLACES as f64))
        .collect();
    let points: Vec<[f64; 2]> = mesh.flat().into_iter().map(|point| uv_from_screen(point, size.aspect())).collect();
    let most = |corners: &[u32; 3]| {
        let corners = corners.map(|corner| points[corner as usize]);
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        for shares in &shares {
            let at = [0, 1].map(|axis| (0..3).map(|k| shares[k] * corners[k][axis]).sum());
            *counts.entry(map.at(at)).or_default() += 1;
        }
        let most = counts.iter().max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(a.0)));
        most.map_or(NO_LABEL, |(label, _)| *label)
    };
    mesh.triangles.iter().map(most).collect()
}

/// Returns the flat colours of a picture.
fn colors_of(plate: &Plate, file: &Path) -> Result<LabelMap, KeyFault> {
    let fault = |what: String, hint: &str| Err(KeyFault::new("ids.file", what, hint));
    match flat_colors(plate) {
        None => {
            let what = format!("{} has no colours and no Cryptomatte", file.display());
            fault(what, "name its channel of ids: id = \"id.object\"")
        }
        Some((_, 0)) => {
            let hint = "fill each part with one colour and save it as PNG or EXR; JPEG changes colours";
            fault("no colour fills as much as 3 x 3 pixels".to_owned(), hint)
        }
        Some((map, _)) => Ok(map),
    }
}

/// Says what a file of ids lacks.
fn missing(file: &Path, error: PlateError) -> KeyFault {
    let file = file.display();
    match error {
        PlateError::NoMatteChannel { channel, hint, .. } => {
            KeyFault::new("ids.id", format!("{file} has no channel \"{channel}\""), hint)
        }
        PlateError::NoCryptomatte { wanted, hint, .. } => {
            KeyFault::new("ids", format!("no Cryptomatte of {file} contains {wanted}"), hint)
        }
        error => KeyFault::new("ids.file", error.to_string(), "give a PNG or EXR file of the picture's shape"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_two_cuts_choose_goes_to_the_smaller_region() {
        let part = |lines: [u32; 4]| {
            let labels = lines.map(|area| if area > 0 { CHOSEN } else { OTHER }).to_vec();
            Some(PartMap { map: LabelMap { size: [4, 1], labels }, lines: lines.to_vec() })
        };
        let mut parts = [part([9, 9, 0, 9]), None, part([5, 9, 5, 0]), part([5, 0, 0, 20])];
        share_lines(&mut parts);
        let chosen = parts.each_ref().map(|part| part.as_ref().map(|part| part.map.labels.clone()));
        let [a, b] = [CHOSEN, OTHER];
        assert_eq!(chosen, [Some(vec![b, a, b, a]), None, Some(vec![a, b, a, b]), Some(vec![b, b, b, b])]);
    }
}
