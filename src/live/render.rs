//! Renders a window of the warped picture.
//!
//! In: a [`Warp`] and a [`Render`]. Out: planes of the window, whole or in pieces; pixels do not depend on the window.

use super::composite::Compositor;
use super::map_tiles::MapTile;
use super::mix::Mix;
use super::picture::{Alpha, Picture};
use super::{LiveError, Render, Warp, recycle_planes};
use crate::space::PixelRect;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Tiles drawn at a time per thread, since their cost varies.
const SIDE_BY_SIDE: usize = 2;

/// A finished piece of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece<'a> {
    /// Its pixels, within the rendered window.
    pub window: PixelRect,
    /// As many planes as the source has, each `window.area()` samples, rows from the top.
    pub planes: &'a [Vec<f32>],
}

/// Renders a window to as many planes as the source has, each `window.area()` samples, with the alpha mode of the source.
///
/// # Errors
/// [`LiveError::Aborted`]; [`LiveError::Planes`] if planes do not match their windows, or the number of planes of the
/// background differs from that of the source.
pub(crate) fn render(warp: &Warp, job: &Render) -> Result<Vec<Vec<f32>>, LiveError> {
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

/// Renders the mean of several warps of one picture: motion blur by shutter samples.
///
/// # Errors
/// As [`render`].
#[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin calls it"))]
pub(crate) fn render_mean(warps: &[Arc<Warp>], job: &Render) -> Result<Vec<Vec<f32>>, LiveError> {
    job.check()?;
    let is_straight = job.source.alpha == Alpha::Straight;
    let multiplied = job.source.associated();
    let source = Picture {
        window: job.source.window,
        planes: multiplied.planes.iter().map(|plane| &plane[..]).collect(),
        alpha: if is_straight { Alpha::Premultiplied } else { job.source.alpha },
    };
    let sample = Render { source: &source, mix: Mix::FULL, ..*job };
    let share = 1.0 / warps.len() as f32;
    let mut planes = vec![vec![0.0; job.window.area()]; job.source.planes.len()];
    for warp in warps {
        for (sum, plane) in planes.iter_mut().zip(render(warp, &sample)?) {
            sum.par_iter_mut().zip(plane).for_each(|(sum, sample)| *sum += sample * share);
        }
    }
    if let (true, Some((alpha, colors))) = (is_straight, planes.split_last_mut()) {
        for color in colors {
            color.iter_mut().zip(&*alpha).filter(|(_, alpha)| **alpha > 0.0).for_each(|(color, alpha)| *color /= alpha);
        }
    }
    job.mix.blend(&mut planes, job.window, job.source);
    Ok(planes)
}

/// Renders the window of a job and passes on each piece as soon as it is finished. Pieces do not overlap; they arrive in
/// any order, from several threads at a time.
///
/// # Errors
/// [`LiveError::Aborted`]; [`LiveError::Planes`] if planes do not match their windows, or the number of planes of the
/// background differs from that of the source.
pub fn render_pieces(warp: &Warp, job: &Render, finished: impl Fn(Piece) + Sync) -> Result<(), LiveError> {
    job.check()?;
    let compositor = Compositor::of(warp, job);
    let side_by_side = SIDE_BY_SIDE * rayon::current_num_threads();
    for tiles in MapTile::all_of(job.frame, job.window).chunks(side_by_side) {
        // Hosts expect the abort callback on the calling thread.
        if (job.abort)() {
            return Err(LiveError::Aborted);
        }
        // Threads that draw pieces of the same tiles wait here for each other's maps.
        let maps: Vec<_> =
            tiles.iter().map(|tile| compositor.is_some().then(|| tile.maps_of_parts(warp, job.frame))).collect();
        tiles.par_iter().zip(maps).for_each(|(tile, maps)| {
            let window = tile.window().intersection(job.window);
            let mut planes = match (&compositor, maps) {
                (Some(compositor), Some(maps)) => compositor.draw(&maps, window),
                _ => job
                    .source
                    .planes
                    .iter()
                    .map(|plane| job.source.window.resized_samples(plane, window, 0.0))
                    .collect(),
            };
            job.mix.blend(&mut planes[..job.source.planes.len()], window, job.source);
            finished(Piece { window, planes: &planes[..job.source.planes.len()] });
            recycle_planes(planes);
        });
    }
    Ok(())
}
