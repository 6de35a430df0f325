//! A window of the warped picture.
//!
//! In: a [`Warp`] and a [`Render`]. Out: planes of the window, page by page or whole: the same pixels whatever the window.

use super::composite::Sheets;
use super::pages::Page;
use super::picture::Picture;
use super::{LiveError, Warp, keep_planes};
use crate::plate::Filter;
use crate::space::{FrameSize, PixelRect};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Pages that are drawn at a time, a thread: some are done sooner than others.
const SIDE_BY_SIDE: usize = 2;

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
    /// Asked now and then, by the thread that renders; true: the picture is not wanted any more.
    pub abort: &'a (dyn Fn() -> bool + Sync),
}

/// A finished part of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece<'a> {
    /// Its pixels, within the window.
    pub window: PixelRect,
    /// As many as the source has, each `window.area()` samples, rows from the top.
    pub planes: &'a [Vec<f32>],
}

/// Renders a window: as many planes as the source has, each `window.area()` samples, alpha as the source has it.
///
/// # Errors
/// [`LiveError::Aborted`]; [`LiveError::Planes`] where planes do not fit their windows, or the background's are not as
/// many as the source's.
pub fn render(warp: &Warp, job: &Render) -> Result<Vec<Vec<f32>>, LiveError> {
    let planes = Mutex::new(vec![vec![0.0; job.window.area()]; job.source.planes.len()]);
    render_pieces(warp, job, |piece| {
        let mut planes = planes.lock().unwrap_or_else(PoisonError::into_inner);
        for (plane, part) in planes.iter_mut().zip(piece.planes) {
            for [from, to] in piece.window.shared_rows(job.window) {
                plane[to].copy_from_slice(&part[from]);
            }
        }
    })?;
    Ok(planes.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// As [`render`], but hands over every part as soon as it is finished, so that nothing is copied twice. Parts do not
/// overlap and come in any order, from several threads at a time.
///
/// # Errors
/// As [`render`].
pub fn render_pieces(warp: &Warp, job: &Render, finished: impl Fn(Piece) + Sync) -> Result<(), LiveError> {
    job.check()?;
    let sheets = Sheets::of(warp, job);
    let side_by_side = SIDE_BY_SIDE * rayon::current_num_threads();
    for pages in Page::all_of(job.frame, job.window).chunks(side_by_side) {
        // Hosts want to be asked by the thread that they called.
        if (job.abort)() {
            return Err(LiveError::Aborted);
        }
        // Threads that draw tiles of the same pages wait here for each other's maps.
        let maps: Vec<_> = pages.iter().map(|page| sheets.is_some().then(|| page.map(warp, job.frame))).collect();
        pages.par_iter().zip(maps).for_each(|(page, map)| {
            let window = page.window().intersection(job.window);
            let planes = match (&sheets, map) {
                (Some(sheets), Some(map)) => sheets.draw(&map, window),
                _ => job.source.planes.iter().map(|plane| job.source.window.over(plane, window, 0.0)).collect(),
            };
            finished(Piece { window, planes: &planes[..job.source.planes.len()] });
            keep_planes(planes);
        });
    }
    Ok(())
}
