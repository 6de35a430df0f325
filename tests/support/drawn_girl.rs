//! The drawn girl of `scenes/puppet` at half her size, for tests that look at every pixel.

use std::path::Path;

/// Writes her picture into a folder. Gives the text of her shot, which belongs beside it.
pub(crate) fn small_girl(folder: &Path) -> String {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/puppet");
    let girl = image::open(own.join("puppet.png")).expect("it comes with the program").into_rgba8();
    let every_second = |x, y| *girl.get_pixel(2 * x, 2 * y);
    let small = image::RgbaImage::from_fn(girl.width() / 2, girl.height() / 2, every_second);
    small.save(folder.join("puppet.png")).expect("written");
    std::fs::read_to_string(own.join("shot.toml")).expect("it comes with the program")
}
