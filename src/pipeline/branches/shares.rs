//! Computes the share of every label in every pixel of a frame.
//!
//! In: the labels that the passes of a picture show. Out: [`Coverage`]s that sum to 1 everywhere.

use super::drawn_pieces::NO_LABEL;
use crate::plate::Coverage;
use crate::space::{FrameSize, PixelRect};

/// The shares of all labels.
pub(super) struct Shares<'a> {
    /// #passes x #pixels of the window.
    seen: &'a [Vec<u32>],
    window: PixelRect,
    frame: FrameSize,
    /// Predominant label of every pixel of the frame; uncovered pixels have that of the nearest covered pixel.
    main: Vec<u32>,
    /// Bounding box of the pixels of each label: left, top, right, bottom, inclusive.
    bounds: Vec<Option<[u32; 4]>>,
}

impl<'a> Shares<'a> {
    pub(super) fn of(seen: &'a [Vec<u32>], (window, frame): (PixelRect, FrameSize), labels: usize) -> Self {
        let mut main = vec![NO_LABEL; frame.window().area()];
        let mut bounds = vec![None; labels];
        let width = frame.width as usize;
        for place in 0..window.area() {
            let [x, y] = window.pixel_at(place);
            if let Some(label) = most(seen, place) {
                main[y as usize * width + x as usize] = label;
            }
            for label in seen.iter().map(|labels| labels[place]).filter(|&label| label != NO_LABEL) {
                extend(&mut bounds[label as usize], [x as u32, y as u32]);
            }
        }
        spread(&mut main, width);
        for (place, &label) in main.iter().enumerate().filter(|(_, label)| **label != NO_LABEL) {
            extend(&mut bounds[label as usize], [(place % width) as u32, (place / width) as u32]);
        }
        Self { seen, window, frame, main, bounds }
    }

    /// Returns the share of a label; `None` if it is not visible.
    pub(super) fn of_label(&self, label: u32) -> Option<Coverage> {
        let [x0, y0, x1, y1] = self.bounds[label as usize]?;
        let window = PixelRect { x: x0 as i32, y: y0 as i32, width: x1 - x0 + 1, height: y1 - y0 + 1 };
        let samples = (0..window.area()).map(|place| self.share(window.pixel_at(place), label)).collect();
        Some(Coverage { frame: self.frame, window, samples })
    }

    /// Returns the coverage of all labels together.
    pub(super) fn covered(&self) -> Coverage {
        let count = self.seen.len().max(1) as f32;
        let shown = |place: usize| self.seen.iter().filter(|labels| labels[place] != NO_LABEL).count() as f32 / count;
        Coverage { frame: self.frame, window: self.window, samples: (0..self.window.area()).map(shown).collect() }
    }

    fn share(&self, pixel: [i32; 2], label: u32) -> f32 {
        let covered = self.window.sample_index(pixel).map(|place| {
            let shown = self.seen.iter().map(|labels| labels[place]).filter(|&shown| shown != NO_LABEL);
            shown.fold([0_u32; 2], |[own, all], shown| [own + u32::from(shown == label), all + 1])
        });
        match covered {
            Some([own, all]) if all > 0 => own as f32 / all as f32,
            _ => {
                let main = self.main[pixel[1] as usize * self.frame.width as usize + pixel[0] as usize];
                f32::from(u8::from(main == label))
            }
        }
    }
}

/// Returns the label shown by most passes at a pixel; the first of several equal ones.
fn most(seen: &[Vec<u32>], place: usize) -> Option<u32> {
    let mut counts: Vec<(u32, u32)> = Vec::new();
    for label in seen.iter().map(|labels| labels[place]).filter(|&label| label != NO_LABEL) {
        match counts.iter_mut().find(|(known, _)| *known == label) {
            Some((_, count)) => *count += 1,
            None => counts.push((label, 1)),
        }
    }
    counts.into_iter().reduce(|best, next| if next.1 > best.1 { next } else { best }).map(|(label, _)| label)
}

/// Gives unlabelled pixels the label of a neighbour, ring by ring outwards.
fn spread(labels: &mut [u32], width: usize) {
    let mut ring: Vec<usize> = (0..labels.len()).filter(|&pixel| labels[pixel] != NO_LABEL).collect();
    while !ring.is_empty() {
        let mut next = Vec::new();
        for pixel in ring {
            let column = pixel % width;
            let left = (column > 0).then(|| pixel - 1);
            let right = (column + 1 < width).then_some(pixel + 1);
            let below = Some(pixel + width).filter(|&below| below < labels.len());
            for neighbour in [left, right, pixel.checked_sub(width), below].into_iter().flatten() {
                if labels[neighbour] == NO_LABEL {
                    labels[neighbour] = labels[pixel];
                    next.push(neighbour);
                }
            }
        }
        ring = next;
    }
}

fn extend(bounds: &mut Option<[u32; 4]>, [x, y]: [u32; 2]) {
    let [x0, y0, x1, y1] = bounds.unwrap_or([x, y, x, y]);
    *bounds = Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)]);
}
