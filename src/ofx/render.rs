//! Renders: a window of the warped picture, or of its map.
//!
//! In: the window, the source (and mask, background), the settings. Out: pixels in the host's image.

use super::api::names::{image, prop};
use super::api::{RectI, Status};
use super::canvas::Canvas;
use super::describe::{BACKGROUND_CLIP, MASK_CLIP};
use super::entry::{Call, Kind};
use super::fault::Fault;
use super::images::{Depth, Image, Rows};
use super::regions::connected;
use super::settings::{Alpha, Moment, Settings, ShapeChoice};
use crate::live::Warp;
use crate::plate::{Planes, WarpMap, resampled, stmap_of};
use crate::space::PixelRect;

/// A render's arguments.
struct Task<'a> {
    call: Call<'a>,
    time: f64,
    output: Image<'a>,
    /// Pixels to draw, within the output.
    pixels: RectI,
    canvas: Canvas,
    settings: Settings,
}

/// Planes of a picture and where they lie in image space.
struct Picture {
    window: PixelRect,
    planes: Vec<Vec<f32>>,
}

/// Draws a window of the output.
pub(super) fn render(call: Call) -> Result<Status, Fault> {
    let Some(task) = Task::of(call)? else { return Ok(Status::OK) };
    let mut planes = match call.kind {
        Kind::PinWarp => task.picture()?,
        Kind::StMap => task.map()?,
    };
    if call.effect.is_aborted() {
        return Err(Fault::Aborted);
    }
    let rows = match call.args.text(image::FIELD_TO_RENDER).unwrap_or_default().as_bytes() {
        field if field == image::FIELD_LOWER.to_bytes() => Rows::Even,
        field if field == image::FIELD_UPPER.to_bytes() => Rows::Odd,
        _ => Rows::All,
    };
    task.output.write(task.pixels, rows, &mut planes);
    call.effect.unsay();
    Ok(Status::OK)
}

impl<'a> Task<'a> {
    /// `None`: there is nothing to draw.
    fn of(call: Call<'a>) -> Result<Option<Self>, Fault> {
        let time = call.args.double(prop::TIME).unwrap_or(0.0);
        let clip = call.effect.clip(image::OUTPUT_CLIP).ok_or(Fault::Missing("output clip"))?;
        let output = clip.image(time)?.ok_or(Fault::Missing("output image"))?;
        let RectI { x1, y1, x2, y2 } = output.bounds;
        let asked = call.args.ints(image::RENDER_WINDOW).unwrap_or([x1, y1, x2, y2]);
        let pixels = RectI { x1: asked[0].max(x1), y1: asked[1].max(y1), x2: asked[2].min(x2), y2: asked[3].min(y2) };
        if pixels.x1 >= pixels.x2 || pixels.y1 >= pixels.y2 {
            return Ok(None);
        }
        // Fusion announces one scale and renders at another: what the image says holds.
        let scale = output.scale.or_else(|| call.args.doubles(image::RENDER_SCALE)).unwrap_or([1.0, 1.0]);
        let canvas = Canvas::of(call.effect, time, scale.map(|side| if side > 0.0 { side } else { 1.0 }));
        let settings = Moment::of(call.effect, time)?.settings(&canvas)?;
        Ok(Some(Self { call, time, output, pixels, canvas, settings }))
    }

    fn window(&self) -> PixelRect {
        self.canvas.window(self.pixels)
    }

    /// A clip's picture with the channels of the output; `None`: it has none at this time.
    fn fetch(&self, name: &'static std::ffi::CStr) -> Result<Option<Picture>, Fault> {
        let Some(image) = self.call.effect.clip(name).map(|clip| clip.image(self.time)).transpose()?.flatten() else {
            return Ok(None);
        };
        let channels = if name == MASK_CLIP { 1 } else { self.output.channels };
        let planes = as_channels(image.planes(), channels);
        Ok(Some(Picture { window: self.canvas.window(image.bounds), planes }))
    }

    fn warp(&self, source: Option<&Picture>) -> Result<std::sync::Arc<Warp>, Fault> {
        let has_alpha = |source: &&Picture| source.planes.len() != 3;
        let alpha = source
            .filter(has_alpha)
            .and_then(|source| Some(Alpha { window: source.window, samples: source.planes.last()? }));
        let warp = self.settings.warp(&self.canvas, alpha)?;
        if self.call.effect.is_aborted() { Err(Fault::Aborted) } else { Ok(warp) }
    }

    fn picture(&self) -> Result<Vec<Vec<f32>>, Fault> {
        let window = self.window();
        let Some(source) = self.fetch(image::SOURCE_CLIP)? else {
            return Ok(vec![vec![0.0; window.area()]; self.output.channels]);
        };
        let warp = self.warp(Some(&source))?;
        let map = WarpMap::backward(&warp.field, self.canvas.frame, window);
        let seen = |picture: &Picture, map: &WarpMap, filter| {
            let planes = picture.planes.iter().map(Vec::as_slice).collect();
            resampled(map, &Planes { window: picture.window, planes }, filter)
        };
        let mut planes = seen(&source, &map, self.settings.filter);
        let still =
            |picture: &Picture| seen(picture, &WarpMap::identity(self.canvas.frame, window), self.settings.filter);
        if connected(self.call, BACKGROUND_CLIP).is_some() && self.output.channels == 4 {
            if let Some(background) = self.fetch(BACKGROUND_CLIP)? {
                lay_over(&mut planes, &still(&background));
            }
        }
        if connected(self.call, MASK_CLIP).is_some() {
            // A mask without an image is black: nothing is warped.
            let mask = self.fetch(MASK_CLIP)?.map(|mask| still(&mask)).unwrap_or_default();
            mix(&mut planes, &still(&source), mask.first().map(Vec::as_slice));
        }
        Ok(planes)
    }

    fn map(&self) -> Result<Vec<Vec<f32>>, Fault> {
        if self.output.depth != Depth::Float {
            let what = "STMaps need 32-bit floats; set the project or the node to float".to_owned();
            return Err(Fault::Image { clip: "Output".to_owned(), what });
        }
        let source = match self.settings.shape {
            ShapeChoice::Alpha => self.fetch(image::SOURCE_CLIP)?,
            _ => None,
        };
        let warp = self.warp(source.as_ref())?;
        let map = WarpMap::backward(&warp.field, self.canvas.frame, self.window());
        let channels = stmap_of(&map).channels.into_iter().map(|channel| channel.samples).collect();
        Ok(as_channels(channels, self.output.channels))
    }
}

/// Planes as the channels of another picture: 4 are RGBA, 3 RGB, 1 alpha. What has no alpha is opaque.
fn as_channels(mut planes: Vec<Vec<f32>>, channels: usize) -> Vec<Vec<f32>> {
    let length = planes.first().map_or(0, Vec::len);
    match (planes.len(), channels) {
        (4, 3) => planes.truncate(3),
        (4, 1) => planes = planes.split_off(3),
        (3, 4) => planes.push(vec![1.0; length]),
        (3, 1) => planes = vec![vec![1.0; length]],
        (1, 3) => planes = vec![planes.swap_remove(0); 3],
        (1, 4) => planes = [vec![vec![0.0; length]; 3], planes].concat(),
        _ => {}
    }
    planes
}

/// Lays RGBA over a background, both associated.
fn lay_over(front: &mut [Vec<f32>], background: &[Vec<f32>]) {
    let Some((alpha, colours)) = front.split_last_mut() else { return };
    let over = |plane: &mut Vec<f32>, back: &Vec<f32>, alpha: &[f32]| {
        plane.iter_mut().zip(back).zip(alpha).for_each(|((front, back), alpha)| *front += back * (1.0 - alpha));
    };
    colours.iter_mut().zip(background).for_each(|(plane, back)| over(plane, back, alpha));
    if let Some(back) = background.last() {
        alpha.iter_mut().zip(back).for_each(|(front, back)| *front += back * (1.0 - *front));
    }
}

/// Keeps what is warped where the mask is 1, what is not where it is 0; no mask is black.
fn mix(warped: &mut [Vec<f32>], still: &[Vec<f32>], mask: Option<&[f32]>) {
    for (plane, still) in warped.iter_mut().zip(still) {
        let Some(mask) = mask else {
            plane.clone_from(still);
            continue;
        };
        for ((value, still), mask) in plane.iter_mut().zip(still).zip(mask) {
            *value = still + (*value - still) * mask.clamp(0.0, 1.0);
        }
    }
}
