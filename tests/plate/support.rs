//! Small plates and fields for the tests of the plate stage.

use pinwarp::image::{Channel, Plate, PlatePart, Storage};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::plate::{Field, LayerJob, Matte, PlateJob, PlateReport, WarpSettings, warp_plate};
use pinwarp::space::PixelRect;

/// A channel whose samples follow from column and row, counted from the upper left corner of the data window.
pub(crate) fn channel(name: &str, storage: Storage, window: PixelRect, value: impl Fn(u32, u32) -> f32) -> Channel {
    let rows = (0..window.height).flat_map(|y| (0..window.width).map(move |x| (x, y)));
    Channel { name: name.to_owned(), storage, samples: rows.map(|(x, y)| value(x, y)).collect() }
}

/// A plate of one part that fills its frame, or lies in it.
pub(crate) fn plate(display: PixelRect, window: PixelRect, channels: Vec<Channel>) -> Plate {
    Plate::new(display, 1.0, vec![PlatePart::new(window, channels)])
}

pub(crate) fn window(x: i32, y: i32, width: u32, height: u32) -> PixelRect {
    PixelRect { x, y, width, height }
}

/// Everything moves by whole pixels, x right and y down, of a frame of `height` pixels.
pub(crate) fn shift(dx: i32, dy: i32, height: u32) -> Field {
    let mut lattice =
        Grid { dims: [4, 4], basis: Basis::Bspline, lo: [-8.0, -8.0], hi: [8.0, 8.0], angle: 0.0 }.at_rest();
    for handle in &mut lattice.handles {
        handle[0] += f64::from(dx) / f64::from(height);
        handle[1] -= f64::from(dy) / f64::from(height);
    }
    Field::of_layer(lattice)
}

/// A layer whose neighbour frames have the same field.
pub(crate) fn layer(name: &str, field: Field, matte: Option<Matte>) -> LayerJob {
    LayerJob { name: name.into(), field, previous: None, next: None, matte, front: None }
}

/// The plate warped by these layers.
pub(crate) fn warped(plate: &Plate, layers: Vec<LayerJob>, settings: &WarpSettings) -> (Plate, PlateReport) {
    warp_plate(plate, &PlateJob { layers, settings, fill: None }).expect("the plate has what the mattes ask for")
}

/// Samples of a channel of the first part that has it.
pub(crate) fn samples<'a>(plate: &'a Plate, name: &str) -> &'a [f32] {
    let found = plate.parts.iter().find_map(|part| part.channel(name));
    &found.expect("the channel is kept").samples
}
