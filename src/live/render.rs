//! A window of the warped picture.
//!
//! In: a [`Warp`] and a [`Render`]. Out: planes of the window, page by page or whole: the same pixels whatever the window.

use super::composite::Sheets;
use super::pages::Page;
use super::picture::Picture;
use super::{LiveError, Warp};
use crate::plate::Filter;
use crate::space::{FrameSize, PixelRect};

/// What is rendered.
#[derive(Clone, Copy)]
pub struct Render<'a> {
    /// The display window, in pixels of this render (proxies have fewer).
    pub frame: FrameSize,
    /// The pixels that are wanted; may lie outside the frame.
    pub window: PixelRect,
    /// The picture that is warped; [`Warp::source_of`] tells how much of it is needed.
    pub source: &'a Picture<'a>,
    /// One plane, 0 to 1: what is moved. The rest of the picture stays. Where it has no samples nothing is moved.
    pub mask: Option<&'a Picture<'a>>,
    /// What is seen where something moved away, or the picture does not reach: as many planes as the source.
    pub background: Option<&'a Picture<'a>>,
    /// How it is resampled.
    pub filter: Filter,
    /// Asked before every page; true: the picture is not wanted any more.
    pub abort: &'a (dyn Fn() -> bool + Sync),
}

/// A finished part of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Its pixels, within the window.
    pub window: PixelRect,
    /// As many as the source has, each `window.area()` samples, rows from the top.
    pub planes: Vec<Vec<f32>>,
}

/// Renders a window: as many planes as the source has, each `window.area()` samples, alpha as the source has it.
///
/// # Errors
/// [`LiveError::Aborted`]; [`LiveError::Planes`] where planes do not fit their windows, or the background's are not as
/// many as the source's.
pub fn render(warp: &Warp, job: &Render) -> Result<Vec<Vec<f32>>, LiveError> {
    let mut planes = vec![vec![0.0; job.window.area()]; job.source.planes.len()];
    render_pieces(warp, job, |piece| {
        for (plane, part) in planes.iter_mut().zip(&piece.planes) {
            for [from, to] in piece.window.shared_rows(job.window) {
                plane[to].copy_from_slice(&part[from]);
            }
        }
    })?;
    Ok(planes)
}

/// As [`render`], but hands over every part as soon as it is finished, so that nothing is copied twice.
///
/// # Errors
/// As [`render`].
pub fn render_pieces(warp: &Warp, job: &Render, mut finished: impl FnMut(Piece)) -> Result<(), LiveError> {
    job.check()?;
    let sheets = Sheets::of(warp, job);
    for page in Page::all_of(job.window) {
        if (job.abort)() {
            return Err(LiveError::Aborted);
        }
        let window = page.window().intersection(job.window);
        let planes = match &sheets {
            Some(sheets) => sheets.draw(&page.map(warp, job.frame), window),
            None => job.source.planes.iter().map(|plane| job.source.window.over(plane, window, 0.0)).collect(),
        };
        finished(Piece { window, planes });
    }
    Ok(())
}
