//! Renders: a window of the warped picture, or of its map.
//!
//! In: the window, the source (and mask, background), the settings. Out: pixels in the host's image.

use super::api::Status;
use super::api::names::{image, prop};
use super::call::{Call, PluginKind};
use super::clips::{BACKGROUND_CLIP, MASK_CLIP, MATTE_CLIP, connected};
use super::fault::Fault;
use super::host::{Depth, HostError, Image, Props, Rows, Target};
use super::host_frame::{host_frame_at, project_at};
use super::notices;
use super::settings::{Settings, ShapeChoice, exposed_settings};
use super::values::ParamValues;
use crate::live::{self, Alpha, HostFrame, Mix, OwnedPicture, Render, Warp};
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
    host_frame: HostFrame,
    project: HostFrame,
    /// What is set while the shutter is open; at least once.
    exposed: Vec<Settings>,
}

/// A clip's picture at a time; `None`: it has none.
pub(super) fn fetched(
    call: Call,
    name: &'static CStr,
    time: f64,
    host_frame: &HostFrame,
) -> Result<Option<OwnedPicture>, Fault> {
    let image = call.effect.clip(name).map(|clip| clip.image(time)).transpose()?.flatten();
    Ok(image.map(|image| {
        let mut planes = live::take_planes(image.channels, image.area());
        image.read(&mut planes);
        let alpha = match (image.channels, image.is_straight) {
            (3, _) => Alpha::Opaque,
            (_, true) => Alpha::Straight,
            (_, false) => Alpha::Premultiplied,
        };
        OwnedPicture { window: host_frame.window(image.bounds), planes, alpha }
    }))
}

/// Draws a window of the output.
pub(super) fn render(call: Call) -> Result<Status, Fault> {
    let Some(task) = Task::of(call)? else { return Ok(Status::OK) };
    let warp = match call.kind {
        PluginKind::PinWarp => task.draw_picture()?,
        PluginKind::StMap => Some(task.draw_map()?),
    };
    if call.effect.is_aborted() {
        return Err(Fault::Aborted);
    }
    let values = ParamValues::of(call.effect, task.time)?;
    let warning = warp.and_then(|warp| notices::warning(values, task.settings(), &task.host_frame, &warp));
    call.effect.frame_succeeded(task.time, warning.is_some());
    warning.iter().for_each(|warning| call.effect.warn(warning));
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
        let drawn = (scale, Some(output.bounds));
        let host_frame = host_frame_at(call.effect, time, drawn);
        let project = project_at(call.effect, time, drawn);
        let exposed = exposed_settings(call, time, &host_frame)?;
        let rows = rows_asked(call.args);
        Ok(Some(Self { call, time, output, pixels, rows, host_frame, project, exposed }))
    }

    fn window(&self) -> PixelRect {
        self.host_frame.window(self.pixels)
    }

    const fn target(&self) -> Target<'_> {
        self.output.target(self.rows)
    }

    fn fetch(&self, name: &'static CStr) -> Result<Option<OwnedPicture>, Fault> {
        fetched(self.call, name, self.time, &self.host_frame)
    }

    /// The settings in the middle of the shutter.
    fn settings(&self) -> &Settings {
        &self.exposed[self.exposed.len() / 2]
    }

    fn warp(&self, settings: &Settings, source: Option<&OwnedPicture>) -> Result<Arc<Warp>, Fault> {
        let warp = settings.warp(self.call.effect, &self.host_frame, source.and_then(OwnedPicture::coverage))?;
        if self.call.effect.is_aborted() { Err(Fault::Aborted) } else { Ok(warp) }
    }

    /// A mask or matte; one that is connected and has no image is black everywhere.
    fn mask(&self, name: &'static CStr) -> Result<Option<OwnedPicture>, Fault> {
        if connected(self.call, name).is_none() {
            return Ok(None);
        }
        Ok(Some(self.fetch(name)?.map_or_else(OwnedPicture::black_mask, |mask| mask.with_channels(1))))
    }

    /// Draws the picture; the warp in the middle of the shutter, if there was a source.
    fn draw_picture(&self) -> Result<Option<Arc<Warp>>, Fault> {
        let (window, channels) = (self.window(), self.output.channels);
        let Some(source) = self.fetch(image::SOURCE_CLIP)? else {
            self.target().write(self.pixels, &vec![vec![0.0; window.area()]; channels]);
            return Ok(None);
        };
        let warps: Vec<Arc<Warp>> =
            self.exposed.iter().map(|settings| self.warp(settings, Some(&source))).collect::<Result<_, _>>()?;
        let source = source.with_channels(channels);
        let (mask, matte) = (self.mask(MASK_CLIP)?, self.mask(MATTE_CLIP)?);
        let background = match connected(self.call, BACKGROUND_CLIP) {
            Some(_) => self.fetch(BACKGROUND_CLIP)?.map(|picture| picture.with_channels(channels)),
            None => None,
        };
        let [mask_shown, matte_shown, background_shown] =
            [&mask, &matte, &background].map(|one| one.as_ref().map(OwnedPicture::picture));
        let effect = self.call.effect;
        let job = Render {
            frame: self.host_frame.frame,
            window,
            source: &source.picture(),
            mask: mask_shown.as_ref(),
            background: background_shown.as_ref(),
            filter: self.settings().filter,
            mix: Mix { amount: self.settings().mix, matte: matte_shown.as_ref() },
            abort: &|| effect.is_aborted(),
        };
        let (target, host_frame) = (self.target(), &self.host_frame);
        match &warps[..] {
            [warp] => live::render_pieces(warp, &job, |piece| {
                target.write(host_frame.pixels(piece.window), piece.planes);
            })?,
            warps => target.write(self.pixels, &live::render_mean(warps, &job)?),
        }
        let done = [Some(source), mask, matte, background].into_iter().flatten();
        done.for_each(|picture| live::recycle_planes(picture.planes));
        Ok(warps.into_iter().nth(self.exposed.len() / 2))
    }

    fn draw_map(&self) -> Result<Arc<Warp>, Fault> {
        if self.output.depth != Depth::Float {
            let what = "STMaps need 32-bit floats; set the project or the node to float".to_owned();
            return Err(HostError::Image { clip: "Output".to_owned(), what }.into());
        }
        let is_of_alpha = self.settings().shape == ShapeChoice::Alpha;
        let source = if is_of_alpha { self.fetch(image::SOURCE_CLIP)? } else { None };
        let warp = self.warp(self.settings(), source.as_ref())?;
        let [own, project] = [self.host_frame.frame, self.project.frame];
        let map = live::stmap(&warp, own, self.window());
        // Natron's STMap, and Nuke's, measure by the project's format.
        let map = map.measured_over(own, project, self.host_frame.corner_in(&self.project));
        let blue = vec![0.0; map.u.len()];
        let planes = vec![map.u, map.v, blue, map.coverage];
        let map = OwnedPicture { window: map.window, planes, alpha: Alpha::Straight };
        self.target().write(self.pixels, &map.with_channels(self.output.channels).planes);
        Ok(warp)
    }
}
