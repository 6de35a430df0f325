//! The size of the maps of an export.
//!
//! In: the arguments, and a shot or a lattice file. Out: a [`FrameSize`] of the same shape.

use super::source::Source;
use crate::cli::args::ExportArgs;
use crate::space::FrameSize;
use anyhow::bail;
use std::io::{self, Write};

/// Height in pixels of the maps of a lattice file, which has no resolution.
const DEFAULT_HEIGHT: f64 = 1080.0;

/// Returns the size of the maps: the requested one, the shot's, or one of the shape of a lattice file.
pub(super) fn map_size(args: &ExportArgs, source: &Source) -> anyhow::Result<FrameSize> {
    let (aspect, of_shot) = source.frame_shape();
    let Some([width, height]) = args.size else {
        let of_file = || FrameSize::new((DEFAULT_HEIGHT * aspect).round().max(1.0) as u32, DEFAULT_HEIGHT as u32);
        return Ok(squared(of_shot.unwrap_or_else(of_file)));
    };
    let pixel_aspect = of_shot.map_or(1.0, |size| size.pixel_aspect);
    let wanted = FrameSize { width, height, pixel_aspect };
    let pixels_of_frame = FrameSize { pixel_aspect: aspect * f64::from(height) / f64::from(width), ..wanted };
    if !wanted.is_as_wide_as(aspect) {
        check_shape(args, (wanted, pixels_of_frame), of_shot.is_some())?;
    }
    Ok(squared(pixels_of_frame))
}

/// Refuses a size of another shape than the shot's. Lattice files do not store the shape of pixels, so for them a note
/// says which pixels fit the size.
fn check_shape(args: &ExportArgs, (wanted, fitting): (FrameSize, FrameSize), is_shot: bool) -> anyhow::Result<()> {
    let FrameSize { width, height, pixel_aspect } = wanted;
    let (shape, aspect, file) = (wanted.aspect(), fitting.aspect(), args.shot.display());
    let shapes = format!("--size {width}x{height} is {shape:.4} wide to 1 high, {file} is {aspect:.4} to 1");
    if !is_shot {
        let pixels = fitting.pixel_aspect;
        writeln!(io::stderr(), "note: {shapes}: the maps are for pixels that are {pixels:.4} wide to 1 high")?;
        return Ok(());
    }
    let side = |length: f64| length.round().max(1.0);
    let [lower, wider] =
        [f64::from(width) * pixel_aspect / aspect, f64::from(height) * aspect / pixel_aspect].map(side);
    bail!(
        "{shapes}; give a size of the same shape, such as {width}x{lower} or {wider}x{height}, or correct `size` and \
         `pixel_aspect` of the shot"
    );
}

/// Makes pixels exactly square if they are square up to rounding.
fn squared(size: FrameSize) -> FrameSize {
    let is_square = (size.pixel_aspect - 1.0).abs() * f64::from(size.width) <= 1.0;
    if is_square { FrameSize::new(size.width, size.height) } else { size }
}
