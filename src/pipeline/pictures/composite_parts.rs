//! Composites the warped parts of one picture.
//!
//! In: parts from back to front, with the channels of [`PART_CHANNELS`]. Out: one picture with [`CHANNELS`]. A part extends under the connected
//! parts in front of it by a rim, which is the same drawing a second time. Composited by coverage, soft pixels of the
//! rim would thicken the edges. The rim is therefore hidden by the region of the part in front, whether its pixels are opaque or not.

use super::read::{CHANNELS, pictured};
use crate::image::Frame;
use crate::space::{FrameSize, PixelRect};

/// The channels of a cut-out part: its colours with the rim, the region of its own pixels (1, and 0 outside), the alpha of the rim.
pub(super) const PART_CHANNELS: [&str; 6] = ["R", "G", "B", "A", REGION, RIM];

/// Name of the channel of a part's own region.
pub(super) const REGION: &str = "region";

/// Name of the channel of the rim's alpha.
pub(super) const RIM: &str = "rim";

/// Returns the picture of all parts.
pub(super) fn composite_parts(size: FrameSize, parts: &[Frame]) -> Frame {
    let window = parts.iter().map(|part| part.data_window).reduce(PixelRect::union).unwrap_or_default();
    let mut canvas = Canvas { planes: CHANNELS.map(|_| vec![0.0; window.area()]), rim: vec![0.0; window.area()] };
    for part in parts {
        let planes: [&[f32]; 6] = std::array::from_fn(|index| part.channels[index].samples.as_slice());
        for [to, from] in window.shared_rows(part.data_window) {
            to.zip(from).for_each(|(at, sample)| canvas.put(at, planes.map(|plane| plane[sample])));
        }
    }
    pictured(size, window, canvas.planes).into_frame()
}

/// The parts composited so far.
struct Canvas {
    /// One per channel of [`CHANNELS`].
    planes: [Vec<f32>; 4],
    /// The portion of the alpha that belongs to rims.
    rim: Vec<f32>,
}

impl Canvas {
    /// Composites a pixel of a part, given by [`PART_CHANNELS`]. Where nothing lies behind, its samples keep their bits.
    fn put(&mut self, at: usize, [front @ .., region, rim]: [f32; 6]) {
        let [covered, behind_rim] = [self.planes[3][at], self.rim[at]];
        // Filters with negative lobes can make alpha overshoot.
        let [through_alpha, through_region] = [front[3], region].map(|cover| 1.0 - cover.clamp(0.0, 1.0));
        let rims = if covered > 0.0 { (behind_rim / covered).clamp(0.0, 1.0) } else { 0.0 };
        let through = through_alpha + rims * (through_region - through_alpha);
        // Where three parts meet, the rim of one in the middle lies over that of one behind; together they cover no more than all.
        let through = if rims > 0.0 { through.min(through_alpha / covered) } else { through };
        for (plane, front) in self.planes.iter_mut().zip(front) {
            plane[at] = if plane[at] == 0.0 { front } else { front + plane[at] * through };
        }
        self.rim[at] = rim + behind_rim * through_region;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn composited(parts: &[[f32; 6]]) -> [f32; 4] {
        let mut canvas = Canvas { planes: CHANNELS.map(|_| vec![0.0]), rim: vec![0.0] };
        parts.iter().for_each(|part| canvas.put(0, *part));
        canvas.planes.map(|plane| plane[0])
    }

    #[test]
    fn a_soft_pixel_under_its_own_part_is_drawn_once() {
        let (own, rim) = ([0.3, 0.2, 0.1, 0.5, 1.0, 0.0], [0.3, 0.2, 0.1, 0.5, 0.0, 0.5]);
        assert_eq!(composited(&[rim, own]), [0.3, 0.2, 0.1, 0.5]);
        // An unconnected soft part behind shines through.
        let other = [0.0, 0.0, 0.4, 0.4, 1.0, 0.0];
        assert_eq!(composited(&[other, own])[3], 0.7);
    }

    #[test]
    fn a_corner_of_three_parts_is_drawn_once() {
        // Their own shares are a half, a quarter and a quarter; the rims of the two behind lie under those in front.
        let [behind, middle, front] =
            [[1.0, 1.0, 1.0, 1.0, 0.5, 0.5], [0.5, 0.5, 0.5, 0.5, 0.25, 0.25], [0.25, 0.25, 0.25, 0.25, 0.25, 0.0]];
        assert_eq!(composited(&[behind, middle, front]), [1.0; 4]);
    }

    #[test]
    fn a_filtered_seam_between_parts_stays_opaque() {
        // The seam halves the pixel: the part behind covers it with one half of its own and one of its rim.
        let (behind, front) = ([1.0, 1.0, 1.0, 1.0, 0.5, 0.5], [0.5, 0.5, 0.5, 0.5, 0.5, 0.0]);
        assert_eq!(composited(&[behind, front]), [1.0; 4]);
    }
}
