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
use super::settings::{Settings, ShapeChoice, settings_of};
use crate::live::{self, Alpha, Coverage, Picture, Render, Warp};
use crate::space::PixelRect;
use std::ffi::CStr;
use std::sync::Arc;

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

/// Planes of a clip and where they lie in image space.
pub(super) struct Fetched {
    window: PixelRect,
    planes: Vec<Vec<f32>>,
    alpha: Alpha,
}

impl Fetched {
    /// A clip's picture at a time, as so many channels; `None`: it has none.
    pub(super) fn of(call: Call, name: &'static CStr, time: f64, canvas: &Canvas) -> Result<Option<Self>, Fault> {
        let image = call.effect.clip(name).map(|clip| clip.image(time)).transpose()?.flatten();
        Ok(image.map(|image| Self {
            window: canvas.window(image.bounds),
            planes: image.planes(),
            alpha: image.alpha(),
        }))
    }

    /// A mask without pixels.
    fn black() -> Self {
        Self { window: PixelRect::default(), planes: vec![Vec::new()], alpha: Alpha::Premultiplied }
    }

    /// The same with the channels of another picture: 4 are RGBA, 3 RGB, 1 alpha. What has no alpha is opaque.
    fn with_channels(mut self, channels: usize) -> Self {
        let area = self.window.area();
        match (self.planes.len(), channels) {
            (4, 3) => self.planes.truncate(3),
            (4, 1) => self.planes = self.planes.split_off(3),
            (3, 4) => self.planes.push(vec![1.0; area]),
            (3, 1) => self.planes = vec![vec![1.0; area]],
            (1, 3) => self.planes = vec![self.planes.swap_remove(0); 3],
            (1, 4) => self.planes = [vec![vec![0.0; area]; 3], self.planes].concat(),
            _ => return self,
        }
        self.alpha = if channels == 3 { Alpha::Opaque } else { Alpha::Premultiplied };
        self
    }

    fn picture(&self) -> Picture<'_> {
        Picture { window: self.window, planes: self.planes.iter().map(Vec::as_slice).collect(), alpha: self.alpha }
    }

    /// Its alpha; `None`: it has none.
    pub(super) fn coverage(&self) -> Option<Coverage<'_>> {
        let alpha = self.planes.last().filter(|_| self.alpha != Alpha::Opaque)?;
        Some(Coverage { window: self.window, alpha })
    }
}

/// Draws a window of the output.
pub(super) fn render(call: Call) -> Result<Status, Fault> {
    let Some(task) = Task::of(call)? else { return Ok(Status::OK) };
    let planes = match call.kind {
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
    task.output.write(task.pixels, rows, &planes);
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
        let scale = scale.map(|side| if side > 0.0 { side } else { 1.0 });
        let canvas = Canvas::at_render(call.effect, time, scale, Some(output.bounds));
        let settings = settings_of(call, time, &canvas)?;
        Ok(Some(Self { call, time, output, pixels, canvas, settings }))
    }

    fn window(&self) -> PixelRect {
        self.canvas.window(self.pixels)
    }

    fn fetch(&self, name: &'static CStr) -> Result<Option<Fetched>, Fault> {
        Fetched::of(self.call, name, self.time, &self.canvas)
    }

    fn warp(&self, source: Option<&Fetched>) -> Result<Arc<Warp>, Fault> {
        let warp = self.settings.warp(&self.canvas, source.and_then(Fetched::coverage))?;
        if self.call.effect.is_aborted() { Err(Fault::Aborted) } else { Ok(warp) }
    }

    fn picture(&self) -> Result<Vec<Vec<f32>>, Fault> {
        let (window, channels) = (self.window(), self.output.channels);
        let Some(source) = self.fetch(image::SOURCE_CLIP)? else {
            return Ok(vec![vec![0.0; window.area()]; channels]);
        };
        let warp = self.warp(Some(&source))?;
        let source = source.with_channels(channels);
        // A mask that is connected and has no image is black everywhere: nothing is warped.
        let mask = match connected(self.call, MASK_CLIP) {
            Some(_) => Some(self.fetch(MASK_CLIP)?.map(|mask| mask.with_channels(1)).unwrap_or_else(Fetched::black)),
            None => None,
        };
        let background = match connected(self.call, BACKGROUND_CLIP) {
            Some(_) => self.fetch(BACKGROUND_CLIP)?.map(|picture| picture.with_channels(channels)),
            None => None,
        };
        let (mask, background) = (mask.as_ref().map(Fetched::picture), background.as_ref().map(Fetched::picture));
        let effect = self.call.effect;
        let job = Render {
            frame: self.canvas.frame,
            window,
            source: &source.picture(),
            mask: mask.as_ref(),
            background: background.as_ref(),
            filter: self.settings.filter,
            abort: &|| effect.is_aborted(),
        };
        Ok(live::render(&warp, &job)?)
    }

    fn map(&self) -> Result<Vec<Vec<f32>>, Fault> {
        if self.output.depth != Depth::Float {
            let what = "STMaps need 32-bit floats; set the project or the node to float".to_owned();
            return Err(Fault::Image { clip: "Output".to_owned(), what });
        }
        let is_of_alpha = self.settings.shape == ShapeChoice::Alpha;
        let source = if is_of_alpha { self.fetch(image::SOURCE_CLIP)? } else { None };
        let map = live::stmap(&*self.warp(source.as_ref())?, self.canvas.frame, self.window());
        let blue = vec![0.0; map.u.len()];
        let planes = vec![map.u, map.v, blue, map.coverage];
        let map = Fetched { window: map.window, planes, alpha: Alpha::Straight };
        Ok(map.with_channels(self.output.channels).planes)
    }
}
