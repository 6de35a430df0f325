//! What somebody looks at when a picture differs: expected, difference and drawn side by side, as PNG.

use pinwarp::image::{Frame, Preview, preview, write_png};
use std::path::{Path, PathBuf};

/// Differences are shown this much stronger.
const GAIN: u32 = 8;

/// Writes the strip; gives its path.
pub(crate) fn write_strip(name: &str, [expected, drawn]: [&Frame; 2]) -> PathBuf {
    let (expected, drawn) = (preview(expected), preview(drawn));
    let apart = Preview {
        rgba: expected.rgba.iter().zip(&drawn.rgba).enumerate().map(|(k, (a, b))| gained(k, *a, *b)).collect(),
        ..expected
    };
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("golden.{name}.png"));
    write_png(&path, &beside([&expected, &apart, &drawn])).expect("the folder of test files can be written to");
    path
}

fn gained(index: usize, a: u8, b: u8) -> u8 {
    // Alpha stays opaque, so that differences of colour show.
    if index % 4 == 3 { 255 } else { (u32::from(a.abs_diff(b)) * GAIN).min(255) as u8 }
}

fn beside(panels: [&Preview; 3]) -> Preview {
    let Preview { width, height, .. } = *panels[0];
    let bytes = 4 * width as usize;
    let row = |y: usize| panels.iter().flat_map(move |panel| panel.rgba[y * bytes..][..bytes].iter().copied());
    Preview { width: 3 * width, height, rgba: (0..height as usize).flat_map(row).collect() }
}
