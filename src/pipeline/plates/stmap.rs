//! STMaps of any program as maps of our own.
//!
//! In: a picture whose R and G say where every pixel comes from: u = (x + ½) / width, v = 1 − (y + ½) / height of the
//! display window. Out: a [`WarpMap`].

use super::super::PipelineError;
use crate::image::{Channel, Plate, PlatePart, Storage};
use crate::plate::WarpMap;
use crate::space::{FrameSize, PixelRect};
use rayon::prelude::*;
use std::path::Path;

/// Offsets below this are what 32-bit numbers near 1 make of none at all, pixels at 8192 across.
const ROUNDING_PX: f64 = 1.0 / 2048.0;

/// The map of a plate of that size.
pub(super) fn map_of(stmap: &Plate, size: FrameSize, path: &Path) -> Result<WarpMap, PipelineError> {
    let shown = stmap.frame_size();
    if (shown.width, shown.height) != (size.width, size.height) {
        let what = format!(
            "the STMap {} is for {} x {} pixels, the plate shows {} x {}",
            path.display(),
            shown.width,
            shown.height,
            size.width,
            size.height
        );
        return Err(unusable(what, "make the map at the size of the plate"));
    }
    let Some((part, u, v)) = stmap.parts.iter().find_map(components) else {
        let what = format!("{} has no channels R and G", path.display());
        return Err(unusable(what, "an STMap says in them where every pixel comes from"));
    };
    if u.storage == Storage::Uint || v.storage == Storage::Uint {
        let what = format!("R and G of {} are whole numbers", path.display());
        return Err(unusable(what, "an STMap holds numbers from 0 to 1: write 32-bit floats"));
    }
    let PixelRect { x, y, width, height } = part.data_window;
    let window = PixelRect { x: x - stmap.display.x, y: y - stmap.display.y, width, height };
    let alpha = part.channel("A").map(|alpha| alpha.samples.as_slice());
    let mut map = WarpMap::identity(size, window);
    map.offsets.par_iter_mut().enumerate().for_each(|(at, offset)| {
        let is_seen = alpha.is_none_or(|alpha| alpha[at] > 0.0);
        let place = [u.samples[at], v.samples[at]].map(f64::from);
        let pixel = [at % width.max(1) as usize, at / width.max(1) as usize];
        *offset = if is_seen { offset_of(place, pixel, (window, size)) } else { [f32::NAN; 2] };
    });
    Ok(map)
}

/// From the centre of a pixel to the place it shows, in pixels, y down.
fn offset_of([u, v]: [f64; 2], [column, row]: [usize; 2], (window, size): (PixelRect, FrameSize)) -> [f32; 2] {
    let from = [f64::from(window.x) + column as f64 + 0.5, f64::from(window.y) + row as f64 + 0.5];
    let to = [u * f64::from(size.width), (1.0 - v) * f64::from(size.height)];
    let offset = [to[0] - from[0], to[1] - from[1]];
    offset.map(|offset| if offset.abs() < ROUNDING_PX { 0.0 } else { offset as f32 })
}

/// A part that holds a map.
fn components(part: &PlatePart) -> Option<(&PlatePart, &Channel, &Channel)> {
    Some((part, part.channel("R")?, part.channel("G")?))
}

fn unusable(what: String, hint: &str) -> PipelineError {
    PipelineError::Unusable { what, hint: hint.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Frame;

    /// A map of 4 x 2 pixels, measured by the display window, with a pixel of overscan on every side.
    fn stmap(shift: [f32; 2]) -> Plate {
        let display = PixelRect { x: 10, y: 20, width: 4, height: 2 };
        let data_window = PixelRect { x: 9, y: 19, width: 6, height: 4 };
        let place = |at: usize| [(at % 6) as f32 - 0.5 + shift[0], (at / 6) as f32 - 0.5 + shift[1]];
        let channel = |name: &str, of: &dyn Fn(usize) -> f32| Channel {
            name: name.into(),
            storage: Storage::Float,
            samples: (0..24).map(of).collect(),
        };
        let channels = vec![
            channel("R", &|at| place(at)[0] / 4.0),
            channel("G", &|at| 1.0 - place(at)[1] / 2.0),
            channel("A", &|at| if at == 5 { 0.0 } else { 1.0 }),
        ];
        Plate::from_frame(Frame { display, data_window, pixel_aspect: 1.0, channels })
    }

    #[test]
    fn the_identity_is_exact_and_overscan_counts() {
        let size = FrameSize::new(4, 2);
        let map = map_of(&stmap([0.0; 2]), size, Path::new("m.exr")).expect("a map");
        assert_eq!(map.window, PixelRect { x: -1, y: -1, width: 6, height: 4 });
        assert!(map.offsets[5][0].is_nan(), "nothing is seen there");
        assert!(map.offsets.iter().enumerate().all(|(at, offset)| at == 5 || *offset == [0.0; 2]), "{:?}", map.offsets);
        let map = map_of(&stmap([1.25, -0.5]), size, Path::new("m.exr")).expect("a map");
        assert!((map.offsets[7][0] - 1.25).abs() < 1e-6 && (map.offsets[7][1] + 0.5).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_map_is_refused() {
        let says = |stmap: &Plate, size| map_of(stmap, size, Path::new("m.exr")).expect_err("refused").to_string();
        assert!(
            says(&stmap([0.0; 2]), FrameSize::new(8, 4)).contains("m.exr is for 4 x 2 pixels, the plate shows 8 x 4")
        );
        let mut bare = stmap([0.0; 2]);
        bare.parts[0].channels.remove(1);
        assert!(says(&bare, FrameSize::new(4, 2)).contains("m.exr has no channels R and G"));
    }
}
