//! A raster with validation on, and ways to draw with it.

use crate::internal::skip::skip;
use glam::Vec2;
use pinwarp::image::Frame;
use pinwarp::raster::vulkan::{Messages, VulkanRaster};
use pinwarp::raster::{ChannelGroup, DeviceChoice, Geometry, Pass, PassRole, Raster, RasterError, Target};
use pinwarp::scene::Scene;
use pinwarp::space::FrameSize;
use std::ops::{Deref, DerefMut};

/// All groups, in the order of the frame's channels.
pub(crate) const ALL: [ChannelGroup; 5] =
    [ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Normal, ChannelGroup::Id];

/// A raster whose validation messages fail the test when it is dropped.
pub(crate) struct Checked {
    raster: Option<VulkanRaster>,
    messages: Messages,
}

impl Deref for Checked {
    type Target = VulkanRaster;

    fn deref(&self) -> &VulkanRaster {
        self.raster.as_ref().expect("open")
    }
}

impl DerefMut for Checked {
    fn deref_mut(&mut self) -> &mut VulkanRaster {
        self.raster.as_mut().expect("open")
    }
}

impl Drop for Checked {
    fn drop(&mut self) {
        // Leaks are reported while the device goes.
        self.raster = None;
        let messages = self.messages.take();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation: {messages:#?}");
        }
    }
}

fn is_required() -> bool {
    std::env::var_os("PINWARP_REQUIRE_VULKAN").is_some_and(|value| value == "1")
}

/// The best device with validation on (off where only the layer is missing); `None`: no device, said so.
pub(crate) fn open(scene: &Scene) -> Option<Checked> {
    let messages = Messages::default();
    match VulkanRaster::open_validated(&DeviceChoice::Vulkan, scene, &messages) {
        Ok(raster) => return Some(Checked { raster: Some(raster), messages }),
        Err(error) if is_required() => panic!("PINWARP_REQUIRE_VULKAN is set, but {error}"),
        Err(error @ RasterError::NoDevice { .. }) => skip(&format!("validation: {error}")),
        Err(error) => panic!("{error}"),
    }
    match VulkanRaster::open(&DeviceChoice::Vulkan, scene) {
        Ok(raster) => Some(Checked { raster: Some(raster), messages }),
        Err(error) => {
            skip(&error.to_string());
            None
        }
    }
}

/// A frame with all channels.
pub(crate) fn target(width: u32, height: u32) -> Target {
    let frame = FrameSize::new(width, height);
    Target { frame, window: frame.window(), channels: ALL.to_vec(), beauty_passes: 1 }
}

/// Draws one pass.
pub(crate) fn draw(raster: &mut dyn Raster, target: &Target, geometry: &Geometry) -> Frame {
    draw_passes(raster, target, &[(geometry, Vec2::ZERO, PassRole::BeautyAndData)])
}

/// Draws several passes.
pub(crate) fn draw_passes(raster: &mut dyn Raster, target: &Target, passes: &[(&Geometry, Vec2, PassRole)]) -> Frame {
    raster.start(target).expect("start");
    for &(geometry, jitter_px, role) in passes {
        raster.draw(&Pass { geometry, jitter_px, role }).expect("draw");
    }
    raster.finish().expect("finish")
}

/// The samples of a channel.
pub(crate) fn samples<'a>(frame: &'a Frame, name: &str) -> &'a [f32] {
    &frame.channel(name).unwrap_or_else(|| panic!("no channel {name}")).samples
}

/// Pixel (x, y) of the data window, y down.
pub(crate) fn pixel(frame: &Frame, name: &str, (x, y): (usize, usize)) -> f32 {
    samples(frame, name)[y * frame.data_window.width as usize + x]
}

/// Puts a tile into a frame that holds all of it.
pub(crate) fn paste(frame: &mut Frame, tile: &Frame) {
    let (whole, part) = (frame.data_window, tile.data_window);
    let (left, top) = ((part.x - whole.x) as usize, (part.y - whole.y) as usize);
    let (width, columns) = (whole.width as usize, part.width as usize);
    for (to, from) in frame.channels.iter_mut().zip(&tile.channels) {
        for (y, row) in from.samples.chunks(columns).enumerate() {
            let start = (top + y) * width + left;
            to.samples[start..start + columns].copy_from_slice(row);
        }
    }
}

/// Writes the colour of a frame to `$PINWARP_DUMP/<name>.ppm`, to look at; nothing where that is not set.
pub(crate) fn dump(name: &str, frame: &Frame) {
    let Some(folder) = std::env::var_os("PINWARP_DUMP") else { return };
    let code = |x: f32| (x.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
    let colour = ["R", "G", "B"].map(|channel| samples(frame, channel));
    let mut bytes = format!("P6 {} {} 255\n", frame.data_window.width, frame.data_window.height).into_bytes();
    bytes.extend((0..frame.data_window.area()).flat_map(|at| colour.map(|plane| code(plane[at]))));
    std::fs::write(std::path::Path::new(&folder).join(format!("{name}.ppm")), bytes).expect("the folder exists");
}
