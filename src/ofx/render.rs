//! Renders a window of the warped picture or of its STMap.
//!
//! In: the window, the source (and mask, background), the settings. Out: pixels in the host's image.

use super::api::Status;
use super::api::names::{image, prop};
use super::budget;
use super::call::{Call, PluginKind};
use super::clips::{BACKGROUND_CLIP, MASK_CLIP, MATTE_CLIP, connected};
use super::fault::Fault;
use super::host::{Depth, HostError, Image, Props, Rows, Target};
use super::host_frame::{host_frame_at, project_at};
use super::notices;
use super::settings::{Settings, ShapeChoice, exposed_settings};
use super::values::ParamValues;
use crate::live::{self, Alpha, HostFrame, Mix, OwnedPicture, Render, Warp};
use crate::memory::Reservation;
use crate::space::PixelRect;
use std::ffi::CStr;
use std::sync::Arc;

/// A render's arguments.
struct Task<'a> {
    call: Call<'a>,
    time: f64,
    output: Image<'a>,
    /// Pixels to render, within the output.
    pixels: [i32; 4],
    /// The rows of `pixels` to render.
    rows: Rows,
    host_frame: HostFrame,
    project: HostFrame,
    /// The settings at each time sample of the shutter; at least one.
    exposed: Vec<Settings>,
}

/// Returns a clip's image at a time, in the host's memory; `None` if it has none.
pub(super) fn image_of<'a>(call: Call<'a>, name: &'static CStr, time: f64) -> Result<Option<Image<'a>>, Fault> {
    Ok(call.effect.clip(name).map(|clip| clip.image(time)).transpose()?.flatten())
}

/// Converts an image to a picture.
pub(super) fn picture_of(image: &Image, host_frame: &HostFrame) -> OwnedPicture {
    let mut planes = live::take_planes(image.channels, image.area());
    image.read(&mut planes);
    let alpha = match (image.channels, image.is_straight) {
        (3, _) => Alpha::Opaque,
        (_, true) => Alpha::Straight,
        (_, false) => Alpha::Premultiplied,
    };
    OwnedPicture { window: host_frame.window(image.bounds), planes, alpha }
}

/// Renders a window of the output.
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
    /// Collects a render's arguments; `None` if there is nothing to render.
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
        // Fusion announces one scale and renders at another: the image's own scale takes precedence.
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

    fn image(&self, name: &'static CStr) -> Result<Option<Image<'a>>, Fault> {
        image_of(self.call, name, self.time)
    }

    /// Returns the image of an optional clip.
    fn connected_image(&self, name: &'static CStr) -> Result<Option<Image<'a>>, Fault> {
        connected(self.call, name).map_or(Ok(None), |_| self.image(name))
    }

    fn picture(&self, image: &Image) -> OwnedPicture {
        picture_of(image, &self.host_frame)
    }

    /// Reserves the memory of these images as planes, plus `bytes_per_pixel` for each rendered pixel.
    fn reserve(&self, images: &[Option<&Image>], bytes_per_pixel: u128) -> Result<Reservation, Fault> {
        let (effect, window) = (self.call.effect, self.window());
        let read: u128 = images.iter().flatten().map(|image| budget::image(image, self.output.channels)).sum();
        budget::reserve(effect, read + window.area() as u128 * bytes_per_pixel, [window.width, window.height])
    }

    /// Returns the settings at mid-shutter.
    fn settings(&self) -> &Settings {
        &self.exposed[self.exposed.len() / 2]
    }

    fn warp(&self, settings: &Settings, source: Option<&OwnedPicture>) -> Result<Arc<Warp>, Fault> {
        let warp = settings.warp(self.call.effect, &self.host_frame, source.and_then(OwnedPicture::coverage))?;
        if self.call.effect.is_aborted() { Err(Fault::Aborted) } else { Ok(warp) }
    }

    /// Returns a mask or matte; one that is connected but has no image is black everywhere.
    fn mask(&self, name: &'static CStr, image: Option<&Image>) -> Option<OwnedPicture> {
        connected(self.call, name)?;
        Some(image.map_or_else(OwnedPicture::black_mask, |image| self.picture(image).with_channels(1)))
    }

    /// Renders the picture; returns the warp at mid-shutter, if there was a source.
    fn draw_picture(&self) -> Result<Option<Arc<Warp>>, Fault> {
        let (window, channels) = (self.window(), self.output.channels);
        let images = [
            self.image(image::SOURCE_CLIP)?,
            self.connected_image(MASK_CLIP)?,
            self.connected_image(MATTE_CLIP)?,
            self.connected_image(BACKGROUND_CLIP)?,
        ];
        let images = images.each_ref().map(Option::as_ref);
        let sets = if self.exposed.len() > 1 { 2 } else { 1 };
        let _memory = self.reserve(&images, budget::MAP_BYTES + budget::planes(sets * channels, 1))?;
        let [source, mask, matte, background] = images;
        let Some(source) = source.map(|source| self.picture(source)) else {
            self.target().write(self.pixels, &vec![vec![0.0; window.area()]; channels]);
            return Ok(None);
        };
        let warps: Vec<Arc<Warp>> =
            self.exposed.iter().map(|settings| self.warp(settings, Some(&source))).collect::<Result<_, _>>()?;
        let source = source.with_channels(channels);
        let (mask, matte) = (self.mask(MASK_CLIP, mask), self.mask(MATTE_CLIP, matte));
        let background = background.map(|image| self.picture(image).with_channels(channels));
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
        let source = if is_of_alpha { self.image(image::SOURCE_CLIP)? } else { None };
        // The map in tiles, the whole map, and four planes.
        let _memory = self.reserve(&[source.as_ref()], 2 * budget::MAP_BYTES + budget::planes(4, 1))?;
        let source = source.map(|source| self.picture(&source));
        let warp = self.warp(self.settings(), source.as_ref())?;
        let [own, project] = [self.host_frame.frame, self.project.frame];
        let map = live::stmap(&warp, own, self.window());
        // STMap nodes of Natron and Nuke measure in the project's format.
        let map = map.measured_over(own, project, self.host_frame.corner_in(&self.project));
        let blue = vec![0.0; map.u.len()];
        let planes = vec![map.u, map.v, blue, map.coverage];
        let map = OwnedPicture { window: map.window, planes, alpha: Alpha::Straight };
        self.target().write(self.pixels, &map.with_channels(self.output.channels).planes);
        Ok(warp)
    }
}
