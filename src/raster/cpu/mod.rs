//! The CPU rasteriser: the reference implementation, in safe Rust, in tiles over all cores.
//!
//! In: a scene's materials, then [`Pass`]es of geometry. Out: a [`Frame`], the same bytes for any number of threads.
//! Triangles are binned into tiles (`bin`, `triangle`); tiles determine visibility (`coverage`) and shade visible
//! pixels once (`tile`, `fragment`, `texture`, `shading`).

mod bin;
mod coverage;
mod fragment;
mod layout;
mod material;
mod matte;
pub(crate) mod mipmap;
pub(crate) mod shading;
mod texture;
mod tile;
mod triangle;

use super::{DeviceClass, Pass, PassRole, Raster, RasterError, SECOND_DATA_PASS, Target};
use crate::image::{Channel, ChannelGroup, ChannelSpec, Frame};
use crate::raster::window::WindowFromScreen;
use crate::scene::Scene;
use bin::{Bins, TILE, Tiling};
use fragment::Shade;
use glam::{IVec2, Vec2};
use layout::Layout;
use material::Materials;
use matte::gather_mattes;
use rayon::prelude::*;
use shading::Light;
use std::time::{Duration, Instant};
use tile::{Scratch, Tile, TilePass};
use triangle::MAX_SIDE;

/// Renders frames on the CPU.
///
/// ```
/// use pinwarp::raster::{ChannelGroup, Geometry, Pass, PassRole, Raster, Target, cpu::CpuRaster};
/// use pinwarp::{scene::Scene, space::FrameSize};
/// let frame = FrameSize::new(4, 3);
/// let mut raster = CpuRaster::new(&Scene::default());
/// let channels = vec![ChannelGroup::Beauty, ChannelGroup::Depth];
/// raster.start(&Target { frame, window: frame.window(), channels, beauty_passes: 1 })?;
/// let geometry = Geometry::default();
/// raster.draw(&Pass { geometry: &geometry, jitter_px: glam::Vec2::ZERO, role: PassRole::BeautyAndData })?;
/// assert_eq!(raster.finish()?.channels[4].samples, [1e10; 12]);
/// # Ok::<(), pinwarp::raster::RasterError>(())
/// ```
#[derive(Debug)]
pub struct CpuRaster {
    materials: Materials,
    bins: Bins,
    tiles: Vec<Tile>,
    job: Option<Job>,
    times: StageTimes,
}

/// The frame being drawn.
#[derive(Debug)]
struct Job {
    target: Target,
    layout: Layout,
    tiling: Tiling,
    /// Whether a pass has drawn data.
    has_data: bool,
}

/// Time spent since the last `start`, for benchmarks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Vertex transform, triangle set-up, binning.
    pub bin: Duration,
    /// Visibility and shading.
    pub tiles: Duration,
    /// Assembling the channels from tiles.
    pub resolve: Duration,
}

impl CpuRaster {
    /// Prepares the scene's materials and the mip chains of its images.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self::with(Materials::of(scene))
    }

    /// Prepares a rasteriser for mattes only: only the images that determine alpha are loaded.
    pub(super) fn for_mattes(scene: &Scene) -> Self {
        Self::with(Materials::of_alpha(scene))
    }

    fn with(materials: Materials) -> Self {
        Self { materials, bins: Bins::default(), tiles: Vec::new(), job: None, times: StageTimes::default() }
    }

    /// Returns the time spent since the last `start`.
    #[must_use]
    pub fn stage_times(&self) -> StageTimes {
        self.times
    }
}

impl Raster for CpuRaster {
    fn name(&self) -> String {
        "CPU".into()
    }

    fn class(&self) -> DeviceClass {
        DeviceClass::Cpu
    }

    fn max_side(&self) -> u32 {
        MAX_SIDE
    }

    fn start(&mut self, target: &Target) -> Result<(), RasterError> {
        if target.window.width.max(target.window.height) > MAX_SIDE {
            return Err(RasterError::Misuse("the window is larger than the CPU raster draws; split it into tiles"));
        }
        let tiling = Tiling { size: IVec2::new(target.window.width as i32, target.window.height as i32) };
        let count = tiling.count();
        self.tiles
            .try_reserve(count.saturating_sub(self.tiles.len()))
            .map_err(|_| RasterError::OutOfMemory { what: format!("{count} tiles") })?;
        self.tiles.resize_with(count, Tile::default);
        self.tiles.iter_mut().for_each(Tile::reset);
        self.job = Some(Job { target: target.clone(), layout: Layout::of(&target.channels), tiling, has_data: false });
        self.times = StageTimes::default();
        Ok(())
    }

    fn draw(&mut self, pass: &Pass) -> Result<(), RasterError> {
        let job = self.job.as_mut().ok_or(RasterError::Misuse("draw was called before start"))?;
        if pass.role != PassRole::Beauty && std::mem::replace(&mut job.has_data, true) {
            return Err(RasterError::Misuse(SECOND_DATA_PASS));
        }
        let job = &*job;
        let begin = Instant::now();
        let window_from_screen = WindowFromScreen::new(&job.target, pass.jitter_px);
        self.bins.fill(pass.geometry, &self.materials, (window_from_screen, job.tiling));
        let binned = Instant::now();
        let lights: Vec<Light> = pass.geometry.lights.iter().map(Light::from).collect();
        let height = f64::from(job.target.frame.height);
        let shade = Shade {
            geometry: pass.geometry,
            materials: &self.materials,
            lights: &lights,
            pixels_per_unit: Vec2::new((height / job.target.frame.pixel_aspect) as f32, height as f32),
        };
        let bins = &self.bins;
        self.tiles.par_iter_mut().enumerate().for_each_init(Scratch::default, |scratch, (index, tile)| {
            let origin = job.tiling.origin(index);
            let pass = TilePass {
                shade: &shade,
                layout: &job.layout,
                role: pass.role,
                weight: 1.0 / job.target.beauty_passes.max(1) as f32,
                origin,
                size: (job.tiling.size - origin).min(IVec2::splat(TILE)),
            };
            tile.draw(&pass, bins.of_tile(index), scratch);
        });
        self.times.bin += binned - begin;
        self.times.tiles += binned.elapsed();
        Ok(())
    }

    fn finish(&mut self) -> Result<Frame, RasterError> {
        let job = self.job.take().ok_or(RasterError::Misuse("finish was called before start"))?;
        let begin = Instant::now();
        let wanted: Vec<_> = job.layout.channels().collect();
        let mut channels: Vec<Channel> =
            wanted.into_par_iter().map(|channel| gather(&job, &self.tiles, channel)).collect::<Result<_, _>>()?;
        if job.layout.has_mattes {
            let mattes: Vec<_> = self.tiles.iter().map(|tile| &tile.mattes).collect();
            channels.extend(gather_mattes(job.tiling, &mattes)?);
        }
        self.times.resolve += begin.elapsed();
        Ok(Frame {
            display: job.target.frame.window(),
            data_window: job.target.window,
            pixel_aspect: job.target.frame.pixel_aspect,
            channels,
        })
    }
}

/// Assembles one channel from the tiles, row by row.
fn gather(
    job: &Job,
    tiles: &[Tile],
    (group, spec, plane): (ChannelGroup, &ChannelSpec, usize),
) -> Result<Channel, RasterError> {
    let area = job.target.window.area();
    let mut samples = Vec::new();
    samples
        .try_reserve_exact(area)
        .map_err(|_| RasterError::OutOfMemory { what: format!("channel {} of {area} pixels", spec.name) })?;
    let (size, side) = (job.tiling.size, TILE as usize);
    let row_of_tiles = job.tiling.columns().max(1);
    for (row, tiles) in tiles.chunks(row_of_tiles).enumerate() {
        let planes: Vec<Option<&[f32]>> = tiles.iter().map(|tile| tile.plane(group, plane)).collect();
        for y in 0..side.min(size.y as usize - row * side) {
            for (column, plane) in planes.iter().enumerate() {
                let width = side.min(size.x as usize - column * side);
                match plane {
                    Some(plane) => samples.extend_from_slice(&plane[y * side..y * side + width]),
                    None => samples.resize(samples.len() + width, spec.empty),
                }
            }
        }
    }
    Ok(Channel { name: spec.name.to_owned(), storage: spec.storage, samples })
}
