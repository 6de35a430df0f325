//! The channels of one view over one data window: what moves there, and how.
//!
//! In: the contents of a plate, the layers of a job. Out: [`Canvas`]: sheets from back to front with shares and maps.

use super::contents::{Contents, Entry};
use super::draw::HOLE;
use super::map_view::Direction;
use super::matte::{Ground, Share};
use super::nearest::nearest_source;
use super::{Field, Matte, PlateError, PlateJob, WarpMap};
use crate::space::{FrameSize, PixelRect};
use crate::spelling::counted;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Something that moves as one: what stays behind, or a layer.
#[derive(Clone, Debug)]
pub(super) struct Mover<'a> {
    /// For messages.
    pub(super) name: &'a str,
    /// What it takes along; `None`: what no layer takes.
    pub(super) matte: Option<&'a Matte>,
    /// Name and field of each layer that bends it.
    pub(super) bent_by: Vec<(&'a str, &'a Field)>,
    /// Which way it takes the picture: forward along its fields, or back against them.
    pub(super) course: Direction,
    pub(super) now: Field,
    pub(super) previous: Field,
    pub(super) next: Field,
}

/// What is drawn of a mover.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    /// Its place among the movers.
    pub(super) mover: usize,
    pub(super) share: Share,
    /// The pixels it may appear in.
    pub(super) window: PixelRect,
    /// Where the pixels of that window come from; `None`: nothing moves.
    pub(super) map: Option<Arc<WarpMap>>,
}

/// The channels of one view over one data window. Windows are measured from the upper left corner of the display window.
#[derive(Debug)]
pub(super) struct Canvas<'a> {
    pub(super) view: Option<&'a str>,
    pub(super) entries: Vec<&'a Entry>,
    /// Data window of the plate.
    pub(super) source: PixelRect,
    /// Data window of the result.
    pub(super) window: PixelRect,
    /// From back to front.
    pub(super) sheets: Vec<Sheet>,
    /// How much of every pixel of the source layers take away for good: #pixels; `None`: nothing.
    pub(super) carved: Option<Vec<f32>>,
    /// Pixels that more than one layer takes; in words.
    pub(super) overlap: Option<String>,
}

impl<'a> Mover<'a> {
    /// What stays behind, then the layers with mattes in the shot's order. Layers without bend everything.
    pub(super) fn all_of(job: &'a PlateJob) -> Vec<Self> {
        let whole: Vec<_> = job.layers.iter().filter(|layer| layer.matte.is_none()).collect();
        let matted = job.layers.iter().filter(|layer| layer.matte.is_some());
        let chain = |first: Option<&Field>, pick: &dyn Fn(&super::LayerJob) -> Field| {
            Field::chain(first.cloned().into_iter().chain(whole.iter().map(|layer| pick(layer))).collect())
        };
        let now = |layer: &super::LayerJob| layer.field.clone();
        let previous = |layer: &super::LayerJob| layer.previous.clone().unwrap_or_else(|| layer.field.clone());
        let next = |layer: &super::LayerJob| layer.next.clone().unwrap_or_else(|| layer.field.clone());
        let of = |layer: Option<&'a super::LayerJob>| Self {
            bent_by: layer.into_iter().chain(whole.iter().copied()).map(|layer| (&*layer.name, &layer.field)).collect(),
            name: layer.map_or("", |layer| layer.name.as_str()),
            matte: layer.and_then(|layer| layer.matte.as_ref()),
            course: Direction::Forward,
            now: chain(layer.map(now).as_ref(), &now),
            previous: chain(layer.map(previous).as_ref(), &previous),
            next: chain(layer.map(next).as_ref(), &next),
        };
        std::iter::once(of(None)).chain(matted.map(|layer| of(Some(layer)))).collect()
    }
}

impl Mover<'_> {
    /// Says that it lies over itself, which layers fold it, and what to do.
    pub(super) fn fold_warning(&self, pixels: usize, (frame, window): (FrameSize, PixelRect)) -> String {
        let folding: Vec<&str> = match &self.bent_by[..] {
            [(only, _)] => vec![only],
            layers => layers.iter().filter(|(_, field)| field.folds_in(frame, window)).map(|(name, _)| *name).collect(),
        };
        let folding = if folding.is_empty() { self.bent_by.iter().map(|(name, _)| *name).collect() } else { folding };
        let names: Vec<String> = folding.iter().map(|name| format!("\"{name}\"")).collect();
        let subject = match &names[..] {
            [only] => format!("the warp of layer {only} folds"),
            names => format!("the warps of the layers {} fold", names.join(" and ")),
        };
        let pixels = counted(pixels, "pixel", "pixels");
        let remedy = match (self.course, self.matte) {
            (Direction::Backward, _) => "which cannot be undone there",
            (Direction::Forward, Some(_)) => "move its pins less far, or hold what folds with more pins",
            (Direction::Forward, None) => {
                "move its pins less far, hold what folds with more pins, or give the layer a matte of what it moves"
            }
        };
        format!("{subject}: the picture lies over itself in {pixels}; {remedy}")
    }
}

impl<'a> Canvas<'a> {
    /// The canvases of a plate, nothing in them yet.
    pub(super) fn all_of(contents: &'a Contents) -> Vec<Self> {
        let mut canvases: Vec<Self> = Vec::new();
        for entry in &contents.entries {
            let (view, source) = (entry.name.view.as_deref(), contents.window(entry.place));
            match canvases.iter_mut().find(|canvas| canvas.view == view && canvas.source == source) {
                Some(canvas) => canvas.entries.push(entry),
                None => canvases.push(Self {
                    view,
                    entries: vec![entry],
                    source,
                    window: source,
                    sheets: Vec::new(),
                    carved: None,
                    overlap: None,
                }),
            }
        }
        canvases
    }

    /// Shares the picture out among the movers.
    pub(super) fn share_out(&mut self, contents: &Contents, movers: &[Mover]) -> Result<(), PlateError> {
        let ground = Ground { view: self.view, window: self.source };
        let mut shares = vec![Share::default()];
        for mover in movers.iter().skip(1) {
            let matte = mover.matte.expect("only the first mover has no matte");
            shares.push(contents.share(mover.name, matte, ground)?);
        }
        self.carved = taken_together(&shares[1..]);
        self.overlap = overlap(&shares, movers, self.source);
        let is_all_taken = movers.iter().skip(1).any(|mover| matches!(mover.matte, Some(Matte::Alpha)));
        shares[0].pixels = match &self.carved {
            _ if is_all_taken => Some(vec![0.0; self.source.area()]),
            Some(carved) => Some(carved.iter().map(|taken| 1.0 - taken).collect()),
            None => None,
        };
        self.sheets = shares
            .into_iter()
            .enumerate()
            .map(|(mover, share)| Sheet { mover, share, window: self.source, map: None })
            .collect();
        Ok(())
    }

    /// The data window after a map: all pixels that show something of the source. A plate that fills its frame keeps its
    /// own.
    pub(super) fn window_under(&self, map: &WarpMap) -> PixelRect {
        if self.source.union(map.frame.window()) == self.source {
            return self.source.intersection(map.window);
        }
        let seen: Vec<f32> = (0..map.window.area())
            .into_par_iter()
            .map(|index| {
                let source = nearest_source(map.window.pixel_at(index), map.offsets[index]);
                f32::from(u8::from(source.is_some_and(|source| self.source.place_of(source).is_some())))
            })
            .collect();
        let seen = bounds(&seen, map.window);
        // A pixel more on every side, for what filters spread.
        let seen = if seen.area() == 0 { seen } else { seen.grown(1) };
        seen.intersection(map.frame.window().union(self.source))
    }

    /// Pixels, as places in the window, at which a mover lies over itself and something of it is visible. `alpha`:
    /// #pixels of the source.
    pub(super) fn folded_pixels(&self, mover: usize, alpha: Option<&[f32]>) -> BTreeSet<usize> {
        let of_sheet = |sheet: &Sheet| -> Vec<usize> {
            let folded = sheet.map.iter().flat_map(|map| map.folded_pixels.iter().map(|&index| index as usize));
            let pixels = folded.map(|index| sheet.window.pixel_at(index));
            let shown = pixels.filter(|&pixel| self.is_visible(sheet, pixel, alpha));
            shown.filter_map(|pixel| self.window.place_of(pixel)).collect()
        };
        self.sheets.iter().filter(|sheet| sheet.mover == mover).flat_map(of_sheet).collect()
    }

    /// Whether a sheet has anything of the picture at a pixel that can be seen.
    fn is_visible(&self, sheet: &Sheet, pixel: [i32; 2], alpha: Option<&[f32]>) -> bool {
        let of = |plane: Option<&[f32]>, source: usize| plane.map_or(1.0, |plane| plane[source]);
        self.source_of(sheet, pixel)
            .is_some_and(|source| of(sheet.share.pixels.as_deref(), source) * of(alpha, source) > HOLE)
    }

    /// What no layer takes, in front where it lies over itself: it is as large as the window.
    pub(super) fn base(&self) -> &Sheet {
        &self.sheets[self.folded_base().len()]
    }

    /// What lies behind the base where that lies over itself, from the back.
    pub(super) fn folded_base(&self) -> &[Sheet] {
        let count = self.sheets.iter().take_while(|sheet| sheet.mover == 0).count();
        &self.sheets[..count.saturating_sub(1)]
    }

    /// The sheets of layers with a matte, from back to front.
    pub(super) fn matted_sheets(&self) -> &[Sheet] {
        &self.sheets[self.folded_base().len() + 1..]
    }
}

/// Finds where sheets may appear, and with them the data windows of the result. A plate that fills its frame keeps its
/// window; others may grow as far as the frame.
pub(super) fn find_windows(canvases: &mut [Canvas], frame: FrameSize, movers: &[Mover]) {
    for canvas in canvases.iter_mut() {
        for sheet in &mut canvas.sheets {
            let held = match &sheet.share.pixels {
                Some(share) if sheet.mover > 0 => bounds(share, canvas.source),
                _ => canvas.source,
            };
            sheet.window = movers[sheet.mover].now.warped_window(frame, held);
        }
        let all = canvas.sheets.iter().map(|sheet| sheet.window).reduce(PixelRect::union).unwrap_or_default();
        let most = canvas.source.union(frame.window());
        canvas.window = if most == canvas.source { canvas.source } else { all.intersection(most) };
    }
    settle_windows(canvases);
}

/// Views that share a part share its data window, which holds a pixel at least.
pub(super) fn settle_windows(canvases: &mut [Canvas]) {
    let windows: Vec<_> = canvases.iter().map(|canvas| (canvas.source, canvas.window)).collect();
    for canvas in canvases {
        let same = windows.iter().filter(|(source, _)| *source == canvas.source);
        let window = same.map(|(_, window)| *window).fold(PixelRect::default(), PixelRect::union);
        let pixel = PixelRect { width: 1, height: 1, ..canvas.source };
        canvas.window = if window.area() == 0 { pixel } else { window };
        for sheet in &mut canvas.sheets {
            // What stays behind is asked everywhere whether it is there.
            sheet.window = if sheet.mover == 0 { canvas.window } else { sheet.window.intersection(canvas.window) };
        }
    }
}

/// Gives every sheet its map: one a mover for all canvases, cut to what each needs.
pub(super) fn find_maps(canvases: &mut [Canvas], frame: FrameSize, movers: &[Mover]) {
    for (index, mover) in movers.iter().enumerate() {
        let wanted = canvases.iter().flat_map(|canvas| &canvas.sheets).filter(|sheet| sheet.mover == index);
        let window = wanted.map(|sheet| sheet.window).reduce(PixelRect::union).unwrap_or_default();
        if mover.now.reach() == 0.0 || window.area() == 0 {
            continue;
        }
        let mut maps = WarpMap::backward_sheets(&mover.now, frame, window).into_iter();
        give_map(canvases, index, &Arc::new(maps.next().expect("one sheet is always in front")));
        maps.for_each(|folded| lay_behind(canvases, index, &folded));
    }
}

/// Adds what a mover shows behind itself, where it lies over itself.
fn lay_behind(canvases: &mut [Canvas], mover: usize, map: &WarpMap) {
    let seen: Vec<f32> = map.offsets.iter().map(|offset| f32::from(u8::from(!offset[0].is_nan()))).collect();
    let folded = bounds(&seen, map.window);
    for canvas in canvases {
        let Some(place) = canvas.sheets.iter().position(|sheet| sheet.mover == mover) else { continue };
        let window = folded.intersection(canvas.sheets[place].window);
        if window.area() > 0 {
            let map = Some(Arc::new(map.cut_to(window)));
            let sheet = Sheet { window, map, ..canvas.sheets[place].clone() };
            canvas.sheets.insert(place, sheet);
        }
    }
}

/// Gives all sheets of a mover their part of a map.
pub(super) fn give_map(canvases: &mut [Canvas], mover: usize, map: &Arc<WarpMap>) {
    let mut cuts: Vec<Arc<WarpMap>> = vec![Arc::clone(map)];
    for sheet in canvases.iter_mut().flat_map(|canvas| &mut canvas.sheets).filter(|sheet| sheet.mover == mover) {
        let known = cuts.iter().find(|known| known.window == sheet.window).cloned();
        let part = known.unwrap_or_else(|| {
            cuts.push(Arc::new(map.cut_to(sheet.window)));
            Arc::clone(&cuts[cuts.len() - 1])
        });
        sheet.map = Some(part);
    }
}

/// The sum of all shares of layers with a matte, at most 1: mattes of one picture share its pixels among them.
fn taken_together(shares: &[Share]) -> Option<Vec<f32>> {
    let mut carving = shares.iter().filter_map(|share| share.pixels.as_ref());
    let mut sum = carving.next()?.clone();
    for share in carving {
        sum.iter_mut().zip(share).for_each(|(sum, share)| *sum = (*sum + share).min(1.0));
    }
    Some(sum)
}

/// Says how many pixels layers take of which there is no more than one.
fn overlap(shares: &[Share], movers: &[Mover], window: PixelRect) -> Option<String> {
    let share = |layer: usize, pixel: usize| shares[layer].pixels.as_ref().map_or(1.0, |share| share[pixel]);
    let layers = 1..shares.len();
    if layers.len() < 2 {
        return None;
    }
    let is_shared = |&pixel: &usize| layers.clone().map(|layer| share(layer, pixel)).sum::<f32>() > 1.0 + HOLE;
    let pixels: Vec<usize> = (0..window.area()).into_par_iter().filter(is_shared).collect();
    let takes = |&layer: &usize| pixels.iter().any(|&pixel| share(layer, pixel) > HOLE);
    let names: Vec<String> = layers.clone().filter(takes).map(|layer| format!("\"{}\"", movers[layer].name)).collect();
    (!pixels.is_empty()).then(|| {
        format!(
            "the mattes of the layers {} overlap: {} more than once; let each pixel belong to one layer",
            names.join(" and "),
            counted(pixels.len(), "pixel moves", "pixels move")
        )
    })
}

/// The smallest window that holds every pixel with a share.
fn bounds(share: &[f32], window: PixelRect) -> PixelRect {
    let width = window.width as usize;
    let rows = share.chunks_exact(width.max(1)).enumerate();
    let mut found: Option<[usize; 4]> = None;
    for (y, row) in rows {
        let Some(left) = row.iter().position(|&share| share > 0.0) else { continue };
        let right = row.iter().rposition(|&share| share > 0.0).unwrap_or(left);
        let [x0, y0, x1, _] = found.unwrap_or([left, y, right, y]);
        found = Some([x0.min(left), y0, x1.max(right), y]);
    }
    let Some([x0, y0, x1, y1]) = found else { return PixelRect { width: 0, height: 0, ..window } };
    PixelRect {
        x: window.x + x0 as i32,
        y: window.y + y0 as i32,
        width: (x1 - x0 + 1) as u32,
        height: (y1 - y0 + 1) as u32,
    }
}
