//! Judges whether a map that was read from a file can be one, or is a picture that was taken for an STMap.
//!
//! In: a [`WarpMap`]. Out: the reason for doubt; `None` for maps, however they bend, mirror, fold or tear the picture.

use super::WarpMap;
use glam::{DMat2, DVec2, IVec2};

/// Number of places along the longer side of a map at which it is judged. Steps between them are longer than those of
/// half floats and than the details of a rough map.
const PLACES: u32 = 64;
/// Smallest number of places for a judgement.
const FEWEST: usize = 16;
/// Largest plausible minification, and smallest plausible magnification by its reciprocal, per axis.
const STRETCH: f64 = 64.0;
/// Smallest plausible sine of the angle between the images of the axes.
const SKEW: f64 = 0.1;
/// Largest change of a step to the next one, relative to the step.
const BEND: f64 = 0.5;
/// Fraction of the places, or of the variance, that has to be that of a map.
const MOST: f64 = 0.5;
/// Plausible sources, in frame sizes around the frame.
const AROUND: f64 = 1.0;

/// A pixel at which a map is judged, in pixels.
struct Probe {
    at: DVec2,
    source: DVec2,
    /// Whether the neighbouring sources lie around this one as its neighbours do; `None`: some are unknown.
    is_smooth: Option<bool>,
}

impl WarpMap {
    /// Returns the reason why this is probably no map; `None` if it is one, or if it is too small to tell.
    ///
    /// A map is locally smooth nearly everywhere, or it is roughly an affine map, however rough it is in detail. The
    /// channels of a picture are neither: they jump at every outline, stay constant in even areas, and brighten together.
    pub(crate) fn doubt(&self) -> Option<&'static str> {
        let places = self.places();
        if places.len() < FEWEST {
            return None;
        }
        let judged: Vec<bool> = places.iter().filter_map(|place| place.is_smooth).collect();
        let smooth = judged.iter().filter(|is_smooth| **is_smooth).count();
        let is_smooth = judged.len() >= FEWEST && smooth as f64 >= MOST * judged.len() as f64;
        if !is_smooth && !is_affine(&places) {
            return Some("neighbouring pixels lead to places that are not neighbours");
        }
        let size = DVec2::new(f64::from(self.frame.width), f64::from(self.frame.height));
        let is_near = |place: &&Probe| {
            place.source.cmpge(-size * AROUND).all() && place.source.cmple(size * (1.0 + AROUND)).all()
        };
        let near = places.iter().filter(is_near).count();
        ((near as f64) < MOST * places.len() as f64).then_some("most of its pixels lead far outside the frame")
    }

    /// Returns the places at which the map is judged.
    fn places(&self) -> Vec<Probe> {
        let side = self.window.width.max(self.window.height);
        let step = (side / PLACES).max(1) as i32;
        let corner = IVec2::new(self.window.x, self.window.y);
        let source = |pixel: IVec2| self.source(pixel.x, pixel.y).map(DVec2::from);
        let place = |column: i32, row: i32| {
            let pixel = corner + IVec2::new(column, row) * step;
            let own = source(pixel)?;
            let around = [IVec2::X, IVec2::Y].map(|axis| [source(pixel - axis * step), source(pixel + axis * step)]);
            let known = around.iter().flatten().all(Option::is_some);
            let [x, y] = around.map(|around| around.map(Option::unwrap_or_default));
            let is_smooth = known.then(|| is_smooth(own, [x, y], f64::from(step)));
            Some(Probe { at: pixel.as_dvec2() + 0.5, source: own, is_smooth })
        };
        let [columns, rows] = [self.window.width, self.window.height].map(|side| side as i32 / step);
        (0..rows).flat_map(|row| (0..columns).filter_map(move |column| place(column, row))).collect()
    }
}

/// Whether the sources around one lie around it as their pixels do: before and after it along x and along y.
fn is_smooth(own: DVec2, around: [[DVec2; 2]; 2], step: f64) -> bool {
    let is_even =
        |[before, after]: [DVec2; 2]| (before + after - 2.0 * own).length() <= BEND * (after - before).length();
    let [x, y] = around.map(|[before, after]| (after - before) / (2.0 * step));
    around.into_iter().all(is_even) && spans_plane(DMat2::from_cols(x, y))
}

/// Whether a linear map is neither flat nor extreme.
fn spans_plane(map: DMat2) -> bool {
    let [x, y] = [map.x_axis.length(), map.y_axis.length()];
    let is_plausible = |length: f64| (1.0 / STRETCH..=STRETCH).contains(&length);
    is_plausible(x) && is_plausible(y) && map.determinant().abs() >= SKEW * x * y
}

/// Whether an affine map explains most of the sources.
fn is_affine(places: &[Probe]) -> bool {
    let count = places.len() as f64;
    let mean = |value: &dyn Fn(&Probe) -> DVec2| places.iter().map(value).sum::<DVec2>() / count;
    let [at, source] = [mean(&|place| place.at), mean(&|place| place.source)];
    // Sums of products, as in linear regression: of the pixels with themselves, and with the sources.
    let outer = |a: DVec2, b: DVec2| DMat2::from_cols(a * b.x, a * b.y);
    let of_pixels = places.iter().map(|place| outer(place.at - at, place.at - at)).fold(DMat2::ZERO, |a, b| a + b);
    let mixed = places.iter().map(|place| outer(place.source - source, place.at - at)).fold(DMat2::ZERO, |a, b| a + b);
    if of_pixels.determinant() <= 0.0 {
        return false;
    }
    let linear = mixed * of_pixels.inverse();
    let square = |v: DVec2| v * v;
    let all = mean(&|place| square(place.source - source));
    let left = mean(&|place| square(place.source - source - linear * (place.at - at)));
    spans_plane(linear) && left.cmple(all * (1.0 - MOST)).all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::read_plate;
    use crate::plate::{Field, map_of_stmap, stmap_of};
    use crate::space::{FrameSize, PixelRect};
    use std::path::Path;

    const FRAME: FrameSize = FrameSize { width: 320, height: 180, pixel_aspect: 1.0 };
    const OVERSCAN: PixelRect = PixelRect { x: -160, y: -90, width: 640, height: 360 };

    /// A map with the source of every pixel, both in shares of the frame, y down.
    fn map(window: PixelRect, source: impl Fn(DVec2) -> DVec2) -> WarpMap {
        let size = DVec2::new(320.0, 180.0);
        let mut map = WarpMap::identity(FRAME, window);
        for (index, offset) in map.offsets.iter_mut().enumerate() {
            let place = IVec2::from(window.pixel_at(index)).as_dvec2() + 0.5;
            *offset = (source(place / size) * size - place).as_vec2().to_array();
        }
        map
    }

    /// Numbers from -0.5 to 0.5 that look random.
    fn noise(at: DVec2) -> DVec2 {
        let of = |factors: DVec2| (at.dot(factors).sin() * 43758.5453).fract() * 0.5;
        DVec2::new(of(DVec2::new(12989.8, 78233.0)), of(DVec2::new(39346.8, 11135.0)))
    }

    #[test]
    fn maps_are_never_doubted() {
        let half = |at: DVec2| (at * 256.0).floor() / 256.0;
        let centre = DVec2::splat(0.5);
        let polar = |at: DVec2| DVec2::new((at - centre).y.atan2((at - centre).x) / 6.3 + 0.5, at.distance(centre));
        let kaleidoscope = |at: DVec2| DVec2::new((at.x * 3.0).fract(), 1.0 - (2.0 * at.y - 1.0).abs());
        let holed = |at: DVec2| if (at.x * 20.0).fract() < 0.4 { DVec2::NAN } else { at };
        let part = |at: DVec2| if at.x > 0.3 { DVec2::NAN } else { DVec2::new(at.x * 0.5, at.y) };
        type Source<'a> = (&'a str, &'a dyn Fn(DVec2) -> DVec2);
        let sources: [Source; 14] = [
            ("identity", &|at| at),
            ("moved", &|at| at + DVec2::new(0.7, -0.3)),
            ("mirrored", &|at| DVec2::new(1.0 - at.x, at.y)),
            ("turned", &|at| 1.0 - at),
            ("on its side", &|at| DVec2::new(at.y, at.x)),
            ("bent", &|at| at + DVec2::new(0.1 * (9.0 * at.y).sin(), 0.1 * (7.0 * at.x).cos())),
            ("folded", &|at| at + DVec2::new(0.4 * (9.0 * at.x).sin(), 0.3 * (8.0 * at.y).sin())),
            ("magnified 30 times", &|at| centre + (at - centre) / 30.0),
            ("of 8 bits", &half),
            ("rough", &|at| at + 0.05 * noise(at)),
            ("polar", &polar),
            ("kaleidoscope", &kaleidoscope),
            ("with holes", &holed),
            ("of a part", &part),
        ];
        for (name, source) in sources {
            for window in [FRAME.window(), OVERSCAN] {
                assert_eq!(map(window, source).doubt(), None, "{name}, {window:?}");
            }
        }
        let mut lattice = crate::lattice::Grid {
            dims: [5, 5],
            basis: crate::lattice::Basis::Bilinear,
            lo: [0.0; 2],
            hi: [16.0 / 9.0, 1.0],
            angle: 0.0,
        }
        .at_rest();
        for (index, handle) in lattice.handles.iter_mut().enumerate() {
            let by = noise(DVec2::splat(index as f64));
            *handle = [handle[0] + by.x, handle[1] + by.y];
        }
        let creased = WarpMap::backward(&Field::of_layer(lattice), FRAME, OVERSCAN);
        assert!(!creased.folded_pixels.is_empty(), "the cells fold");
        assert_eq!(creased.doubt(), None);
        let written = crate::image::Plate::from_frame(stmap_of(&creased));
        assert_eq!(map_of_stmap(&written).expect("a map").doubt(), None);
    }

    #[test]
    fn pictures_are_doubted() {
        let wrong: [(&str, &dyn Fn(DVec2) -> DVec2); 5] = [
            ("one colour", &|_| DVec2::new(0.5, 0.5)),
            ("a grey sky", &|at| DVec2::new(0.5 + 0.4 * at.y, 0.5 - 0.4 * at.y)),
            ("noise", &|at| noise(at) + 0.5),
            ("one channel", &|at| DVec2::new(at.x, 0.0)),
            ("far away", &|at| at + 7.0),
        ];
        for (name, source) in wrong {
            assert!(map(FRAME.window(), source).doubt().is_some(), "{name}");
        }
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
        for name in ["teapot.0012", "cat.0008", "flag.0007", "gingerman.0008", "hare.0008", "walker.0007", "plate.ewa"]
        {
            let picture = read_plate(&folder.join(format!("{name}.exr"))).expect("a picture");
            let judged = map_of_stmap(&picture).map(|map| map.doubt());
            let is_refused = !matches!(judged, Ok(None));
            assert!(is_refused, "{name}: {judged:?}");
        }
        let stmap = read_plate(&folder.join("plate.stmap.exr")).expect("a map");
        assert_eq!(map_of_stmap(&stmap).expect("a map").doubt(), None);
    }
}
