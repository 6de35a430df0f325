//! Maps between two pictures of the same surfaces: a scene before and after a warp.
//!
//! In: for both pictures, the nearest surface at every pixel and its displacement to the other picture. Out: a
//! [`WarpMap`] that follows every surface, whatever moves it. Pixels whose surface the other picture hides are NaN.

use super::WarpMap;
use crate::space::{FrameSize, PixelRect};
use glam::{DMat2, DVec2, IVec2};
use rayon::prelude::*;

/// Displacement below which a surface counts as still, in pixels.
const STILL: f64 = 1e-3;
/// Deviation from the place where a surface is expected up to which it is the same surface, in pixels.
const SAME: f64 = 0.75;
/// Deviation from which on it is another surface, in pixels.
const OTHER: f64 = 3.0;

/// The eight pixels around a pixel, those that share a side first.
const AROUND: [IVec2; 8] = [
    IVec2::new(-1, 0),
    IVec2::new(1, 0),
    IVec2::new(0, -1),
    IVec2::new(0, 1),
    IVec2::new(-1, -1),
    IVec2::new(1, -1),
    IVec2::new(-1, 1),
    IVec2::new(1, 1),
];

/// The offset where nothing is visible.
const HOLE: [f32; 2] = [f32::NAN; 2];

/// The nearest surface at every pixel of a picture, sampled at the pixel centres.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfacePicture {
    /// The pixels of the picture, relative to the upper left corner of the display window.
    pub(crate) window: PixelRect,
    /// #pixels: id of the object; 0 where there is no surface.
    pub(crate) objects: Vec<f32>,
    /// #pixels: distance from the camera, metres.
    pub(crate) depths: Vec<f32>,
    /// #pixels: displacement to the place of the surface in the other picture, in pixels, x right, y DOWN.
    pub(crate) offsets: Vec<[f32; 2]>,
}

/// A pixel that shows a surface.
#[derive(Clone, Copy)]
struct SurfacePixel {
    object: f32,
    depth: f32,
    offset: DVec2,
}

impl SurfacePicture {
    /// Returns the surface at a pixel; `None` outside the window and where there is none.
    fn at(&self, pixel: IVec2) -> Option<SurfacePixel> {
        let index = self.window.sample_index(pixel.to_array())?;
        let offset = DVec2::from(self.offsets[index].map(f64::from));
        let object = self.objects[index];
        (object > 0.0).then(|| SurfacePixel { object, depth: self.depths[index], offset })
    }

    /// Returns the displacements of all pixels; NaN where there is no surface.
    pub(super) fn displacements(&self, frame: FrameSize) -> WarpMap {
        let all = self.objects.iter().zip(&self.offsets);
        let offsets = all.map(|(&object, &offset)| if object > 0.0 { offset } else { HOLE }).collect();
        WarpMap { frame, window: self.window, offsets, folded_pixels: Vec::new() }
    }

    /// Whether a moved surface covers the pixel or one beside it.
    fn is_left(&self, pixel: IVec2) -> bool {
        let is_moved = |by: IVec2| self.at(pixel + by).is_some_and(|surface| surface.offset.length() > STILL);
        is_moved(IVec2::ZERO) || AROUND.into_iter().any(is_moved)
    }

    /// Whether this picture shows the surface at the source of a pixel, and nothing in front covers a part of it.
    fn shows(&self, object: f32, source: &Source) -> bool {
        let corner = (source.place - 0.5).floor().as_ivec2();
        let near = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| corner + IVec2::new(x, y));
        if near.iter().all(|&pixel| self.at(pixel).is_none()) {
            // Something thinner than a pixel, or something outside the window.
            return true;
        }
        let is_own = |&pixel: &IVec2| {
            self.at(pixel).is_some_and(|found| found.object == object && source.deviation(pixel, found) < SAME)
        };
        near.iter().any(is_own) && !self.is_under_edge(source)
    }

    /// Whether a surface that moves away covers the source pixel, or a part of it in front of the one at its centre.
    fn is_under_edge(&self, source: &Source) -> bool {
        let pixel = source.place.floor().as_ivec2();
        let Some(own) = self.at(pixel) else { return false };
        let is_other = |by: IVec2, found: SurfacePixel| source.deviation(pixel + by, found) > OTHER;
        let is_front =
            |by: IVec2| self.at(pixel + by).is_some_and(|front| front.depth < own.depth && is_other(by, front));
        is_other(IVec2::ZERO, own) || AROUND.into_iter().any(is_front)
    }

    /// Whether the soft edge of a surface lies at the source of a pixel beside it: no surface covers its centre, and
    /// only this one is near.
    fn has_edge(&self, source: &Source) -> bool {
        let pixel = source.place.floor().as_ivec2();
        let is_other =
            |by: IVec2| self.at(pixel + by).is_some_and(|beside| source.deviation(pixel + by, beside) > OTHER);
        self.at(pixel).is_none() && !AROUND.into_iter().any(is_other)
    }
}

/// The place in the other picture that a pixel shows.
struct Source {
    /// Centre of the pixel.
    target: DVec2,
    /// Its place in the other picture, in pixels.
    place: DVec2,
    /// Change of the place per pixel to the right and down.
    jacobian: DMat2,
}

impl Source {
    /// Returns the source of a pixel whose map has an offset and a Jacobian as of [`WarpMap::jacobian`].
    fn of(pixel: IVec2, offset: [f32; 2], [x, y]: [[f32; 2]; 2]) -> Self {
        let target = center(pixel);
        let jacobian = DMat2::from_cols_array_2d(&[x, y].map(|row| row.map(f64::from))).transpose();
        Self { target, place: target + DVec2::from(offset.map(f64::from)), jacobian }
    }

    /// How far the surface at a pixel of the other picture is from where the surface at the source would be there: in
    /// pixels of that picture, or of this one where it is shrunk.
    fn deviation(&self, pixel: IVec2, found: SurfacePixel) -> f64 {
        let target = center(pixel) + found.offset;
        let expected = center(pixel) - self.place;
        let [x, y] = [self.jacobian.x_axis.length(), self.jacobian.y_axis.length()];
        (self.jacobian * (target - self.target) - expected).length() / x.max(y).max(1.0)
    }
}

impl WarpMap {
    /// Returns, for every pixel of `shown`, its place in `other`. The map continues by one pixel beyond the outlines,
    /// for their soft edges. It is NaN where `other` hides the surface, and where a surface left an empty pixel;
    /// 0 elsewhere. Both pictures belong to the display window `frame`.
    pub(crate) fn between(shown: &SurfacePicture, other: &SurfacePicture, frame: FrameSize) -> Self {
        let window = shown.window;
        let pixel_at = |index: usize| IVec2::from(window.pixel_at(index));
        let drawn = shown.displacements(frame);
        let on_surface = |index: usize| {
            let offset = drawn.offsets[index];
            let source = Source::of(pixel_at(index), offset, drawn.jacobian(index));
            if source.place.is_finite() && other.shows(shown.objects[index], &source) { offset } else { HOLE }
        };
        let offsets = (0..window.area()).into_par_iter().map(on_surface).collect();
        let inside = Self { frame, window, offsets, folded_pixels: Vec::new() };
        let offset = |index: usize| match shown.at(pixel_at(index)) {
            Some(_) => inside.offsets[index],
            None => inside.beyond_outline(pixel_at(index), other),
        };
        let offsets = (0..window.area()).into_par_iter().map(offset).collect();
        let is_flipped = |&index: &u32| {
            let [[a, b], [c, d]] = inside.jacobian(index as usize);
            !inside.offsets[index as usize][0].is_nan() && a * d - b * c < 0.0
        };
        let folded_pixels = (0..window.area() as u32).into_par_iter().filter(is_flipped).collect();
        Self { frame, window, offsets, folded_pixels }
    }

    /// Returns the offset of a pixel without a surface: continued from a pixel beside it, unless it would fetch
    /// another surface; NaN where a surface moved away; else 0.
    fn beyond_outline(&self, pixel: IVec2, other: &SurfacePicture) -> [f32; 2] {
        let continued = |by: IVec2| {
            let index = self.window.sample_index((pixel + by).to_array())?;
            let jacobian = self.jacobian(index);
            let [[a, b], [c, d]] = jacobian;
            let [x, y] = self.offsets[index];
            let [u, v] = (-by).as_vec2().to_array();
            let offset = [x + (a - 1.0) * u + b * v, y + c * u + (d - 1.0) * v];
            let source = Source::of(pixel, offset, jacobian);
            (source.place.is_finite() && other.has_edge(&source)).then_some(offset)
        };
        let outside = if other.is_left(pixel) { HOLE } else { [0.0; 2] };
        AROUND.into_iter().find_map(continued).unwrap_or(outside)
    }
}

fn center(pixel: IVec2) -> DVec2 {
    pixel.as_dvec2() + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: FrameSize = FrameSize { width: 40, height: 8, pixel_aspect: 1.0 };

    /// A picture of columns: (object, depth, displacement in pixels to the right) of each.
    fn columns(surface: impl Fn(i32) -> (f32, f32, f32)) -> SurfacePicture {
        let window = FRAME.window();
        let all: Vec<_> = (0..window.area()).map(|index| surface(window.pixel_at(index)[0])).collect();
        SurfacePicture {
            window,
            objects: all.iter().map(|surface| surface.0).collect(),
            depths: all.iter().map(|surface| surface.1).collect(),
            offsets: all.iter().map(|surface| [surface.2, 0.0]).collect(),
        }
    }

    /// The columns that those of the middle row come from; `None` for holes.
    fn sources(map: &WarpMap) -> Vec<Option<i32>> {
        (0..40).map(|x| map.source(x, 4).map(|[source, _]| (source - 0.5).round() as i32)).collect()
    }

    #[test]
    fn a_surface_in_front_leaves_a_hole_without_an_outline() {
        const STILL: (f32, f32, f32) = (1.0, 5.0, 0.0);
        let unwarped = columns(|x| if (10..16).contains(&x) { (2.0, 3.0, 12.0) } else { STILL });
        let warped = columns(|x| if (22..28).contains(&x) { (2.0, 3.0, -12.0) } else { STILL });
        let expected = |x: i32| match x {
            // Pixels 9 and 16 contain the soft edges of the surface that left.
            9..=16 => None,
            22..28 => Some(x - 12),
            _ => Some(x),
        };
        let map = WarpMap::between(&warped, &unwarped, FRAME);
        assert_eq!(sources(&map), (0..40).map(expected).collect::<Vec<_>>());
        assert!(map.folded_pixels.is_empty());
    }

    #[test]
    fn soft_edges_travel_with_a_surface_over_nothing() {
        const NOTHING: (f32, f32, f32) = (0.0, 0.0, 0.0);
        let unwarped = columns(|x| if (10..16).contains(&x) { (2.0, 3.0, 12.0) } else { NOTHING });
        let warped = columns(|x| if (22..28).contains(&x) { (2.0, 3.0, -12.0) } else { NOTHING });
        let expected = |x: i32| match x {
            9..=16 => None,
            21..=28 => Some(x - 12),
            _ => Some(x),
        };
        assert_eq!(sources(&WarpMap::between(&warped, &unwarped, FRAME)), (0..40).map(expected).collect::<Vec<_>>());
        // The inverse swaps the pictures.
        let back = |x: i32| match x {
            9..=16 => Some(x + 12),
            21..=28 => None,
            _ => Some(x),
        };
        assert_eq!(sources(&WarpMap::between(&unwarped, &warped, FRAME)), (0..40).map(back).collect::<Vec<_>>());
    }

    #[test]
    fn a_surface_that_was_hidden_is_a_hole() {
        // Everything moves right by 4 columns, except that the surface in front moves by 8.
        let unwarped = columns(|x| if (10..16).contains(&x) { (2.0, 3.0, 8.0) } else { (1.0, 5.0, 4.0) });
        let warped = columns(|x| if (18..24).contains(&x) { (2.0, 3.0, -8.0) } else { (1.0, 5.0, -4.0) });
        let expected = |x: i32| match x {
            13..18 => None,
            18..24 => Some(x - 8),
            _ => Some(x - 4),
        };
        let map = WarpMap::between(&warped, &unwarped, FRAME);
        assert_eq!(sources(&map), (0..40).map(expected).collect::<Vec<_>>());
    }

    #[test]
    fn stretched_and_flipped_surfaces_stay_whole() {
        let stretched = columns(|x| (1.0, 5.0, 3.0 * x as f32));
        let wide = columns(|x| (1.0, 5.0, -0.75 * x as f32));
        let map = WarpMap::between(&wide, &stretched, FRAME);
        assert!(sources(&map).iter().all(Option::is_some) && map.folded_pixels.is_empty());
        let mirrored = columns(|x| (1.0, 5.0, (39 - 2 * x) as f32));
        let flipped = WarpMap::between(&mirrored, &mirrored, FRAME);
        assert_eq!(flipped.folded_pixels.len(), 40 * 8);
    }
}
