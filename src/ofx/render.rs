//! Renders: a window of the warped picture, or of its map.
//!
//! In: the window, the source (and mask, background), the settings. Out: pixels in the host's image.

use super::api::Status;
use super::api::names::{image, prop};
use super::canvas::canvas_at;
use super::describe::{BACKGROUND_CLIP, MASK_CLIP};
use super::entry::{Call, Kind};
use super::fault::Fault;
use super::host::{Depth, HostError, Image, Props, Rows, Target};
use super::regions::connected;
use super::settings::{Settings, ShapeChoice, settings_of};
use crate::live::{self, Alpha, Canvas, OwnedPicture, Render, Warp};
use crate::space::PixelRect;
use std::ffi::CStr;
use std::sync::Arc;

/// A render's arguments.
struct Task<'a> {
    call: Call<'a>,
    time: f64,
    output: Image<'a>,
    /// Pixels to draw, within the output.
    pixels: [i32; 4],
    /// Those of them to draw.
    rows: Rows,
    canvas: Canvas,
    settings: Settings,
}

/// A clip's picture at a time; `None`: it has none.
pub(super) fn fetched(
    call: Call,
    name: &'static CStr,
    time: f64,
    canvas: &Canvas,
) -> Result<Option<OwnedPicture>, Fault> {
    let image = call.effect.clip(name).map(|clip| clip.image(time)).transpose()?.flatten();
    Ok(image.map(|image| {
        let mut planes = live::spare_planes(image.channels, image.area());
        image.read(&mut planes);
        let alpha = match (image.channels, image.is_straight) {
            (3, _) => Alpha::Opaque,
            (_, true) => Alpha::Straight,
            (_, false) => Alpha::Premultiplied,
        };
        OwnedPicture { window: canvas.window(image.bounds), planes, alpha }
    }))
}

/// Draws a window of the output.
pub(super) fn render(call: Call) -> Result<Status, Fault> {
    let Some(task) = Task::of(call)? else { return Ok(Status::OK) };
    match call.kind {
        Kind::PinWarp => task.draw_picture()?,
        Kind::StMap => task.target().write(task.pixels, &task.map()?),
    }
    if call.effect.is_aborted() {
        return Err(Fault::Aborted);
    }
    call.effect.unsay();
    Ok(Status::OK)
}

fn rows_asked(args: Props) -> Rows {
    match args.text(image::FIELD_TO_RENDER).unwrap_or_default().as_bytes() {
        field if field == image::FIELD_LOWER.to_bytes() => Rows::Even,
        field if field == image::FIELD_UPPER.to_bytes() => Rows::Odd,
        _ => Rows::All,
    }
}

impl<'a> Task<'a> {
    /// `None`: there is nothing to draw.
    fn of(call: Call<'a>) -> Result<Option<Self>, Fault> {
        let time = call.args.double(prop::TIME).unwrap_or(0.0);
        let clip = call.effect.clip(image::OUTPUT_CLIP).ok_or(HostError::Missing("output clip"))?;
        let output = clip.image(time)?.ok_or(HostError::Missing("output image"))?;
        let [x1, y1, x2, y2] = output.bounds;
        let asked = call.args.ints(image::RENDER_WINDOW).unwrap_or(output.bounds);
        let pixels = [asked[0].max(x1), asked[1].max(y1), asked[2].min(x2), asked[3].min(y2)];
        if pixels[0] >= pixels[2] || pixels[1] >= pixels[3] {
            return Ok(None);
        }
        // Fusion announces one scale and renders at another: what the image says holds.
        let scale = output.scale.or_else(|| call.args.doubles(image::RENDER_SCALE)).unwrap_or([1.0, 1.0]);
        let scale = scale.map(|side| if side > 0.0 { side } else { 1.0 });
        let canvas = canvas_at(call.effect, time, scale, Some(output.bounds));
        let settings = settings_of(call, time, &canvas)?;
        let rows = rows_asked(call.args);
        Ok(Some(Self { call, time, output, pixels, rows, canvas, settings }))
    }

    fn window(&self) -> PixelRect {
        self.canvas.window(self.pixels)
    }

    const fn target(&self) -> Target<'_> {
        self.output.target(self.rows)
    }

    fn fetch(&self, name: &'static CStr) -> Result<Option<OwnedPicture>, Fault> {
        fetched(self.call, name, self.time, &self.canvas)
    }

    fn warp(&self, source: Option<&OwnedPicture>) -> Result<Arc<Warp>, Fault> {
        let warp = self.settings.warp(&self.canvas, source.and_then(OwnedPicture::coverage))?;
        if self.call.effect.is_aborted() { Err(Fault::Aborted) } else { Ok(warp) }
    }

    fn draw_picture(&self) -> Result<(), Fault> {
        let (window, channels) = (self.window(), self.output.channels);
        let Some(source) = self.fetch(image::SOURCE_CLIP)? else {
            self.target().write(self.pixels, &vec![vec![0.0; window.area()]; channels]);
            return Ok(());
        };
        let warp = self.warp(Some(&source))?;
        let source = source.with_channels(channels);
        // A mask that is connected and has no image is black everywhere: nothing is warped.
        let mask = match connected(self.call, MASK_CLIP) {
            Some(_) => Some(self.fetch(MASK_CLIP)?.map_or_else(OwnedPicture::black_mask, |mask| mask.with_channels(1))),
            None => None,
        };
        let background = match connected(self.call, BACKGROUND_CLIP) {
            Some(_) => self.fetch(BACKGROUND_CLIP)?.map(|picture| picture.with_channels(channels)),
            None => None,
        };
        let [mask_shown, background_shown] = [&mask, &background].map(|one| one.as_ref().map(OwnedPicture::picture));
        let effect = self.call.effect;
        let job = Render {
            frame: self.canvas.frame,
            window,
            source: &source.picture(),
            mask: mask_shown.as_ref(),
            background: background_shown.as_ref(),
            filter: self.settings.filter,
            abort: &|| effect.is_aborted(),
        };
        let (target, canvas) = (self.target(), &self.canvas);
        live::render_pieces(&warp, &job, |piece| target.write(canvas.pixels(piece.window), piece.planes))?;
        let done = [Some(source), mask, background].into_iter().flatten();
        done.for_each(|picture| live::keep_planes(picture.planes));
        Ok(())
    }

    fn map(&self) -> Result<Vec<Vec<f32>>, Fault> {
        if self.output.depth != Depth::Float {
            let what = "STMaps need 32-bit floats; set the project or the node to float".to_owned();
            return Err(HostError::Image { clip: "Output".to_owned(), what }.into());
        }
        let is_of_alpha = self.settings.shape == ShapeChoice::Alpha;
        let source = if is_of_alpha { self.fetch(image::SOURCE_CLIP)? } else { None };
        let map = live::stmap(&*self.warp(source.as_ref())?, self.canvas.frame, self.window());
        let blue = vec![0.0; map.u.len()];
        let planes = vec![map.u, map.v, blue, map.coverage];
        let map = OwnedPicture { window: map.window, planes, alpha: Alpha::Straight };
        Ok(map.with_channels(self.output.channels).planes)
    }
}
