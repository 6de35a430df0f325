//! Maps compared: the one in a file and the one that the plugin rendered.
//!
//! In: a plate and pixels. Out: how far they are apart.

use crate::host::Pixels;
use pinwarp::image::Plate;

/// The largest difference of u and v anywhere in the frame.
pub(crate) fn worst(exported: &Plate, found: &Pixels) -> f32 {
    let part = &exported.parts[0];
    let height = found.bounds.y2;
    let channel = |name: &str| part.channels.iter().find(|channel| channel.name == name).expect("a map has u and v");
    let samples = ["R", "G"].map(|name| &channel(name).samples);
    let mut worst = 0.0_f32;
    for y in 0..height {
        for x in 0..found.bounds.x2 {
            let row = (height - 1 - y) as usize;
            for (index, samples) in samples.iter().enumerate() {
                let expected = samples[row * found.width() + x as usize];
                worst = worst.max((expected - found.at(x, y, index)).abs());
            }
        }
    }
    worst
}
