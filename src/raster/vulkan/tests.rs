//! Tests that need the rasteriser's internals: failing calls, and detection of errors by the validation layers.

use super::choose::{Candidate, choose};
use super::commands::{Commands, Contents, Usage};
use super::device::Device;
use super::instance::Instance;
use super::memory::{Buffer, BufferUse, Image, ImageUse, MemoryLocation, Placement};
use super::messenger::Messages;
use super::raster::VulkanRaster;
use super::remap::VulkanRemap;
use super::shim::{self, Fault};
use crate::image::Frame;
use crate::internal::skip::skip;
use crate::plate::{Filter as PlateFilter, Planes, WarpMap};
use crate::raster::{
    ChannelGroup, DeviceChoice, Draw, Geometry, Pass, PassRole, Raster, RasterError, RasterVertex, Target,
};
use crate::scene::{AlphaMode, Filter, Image as SceneImage, Material, Scene, Texture, TextureRef, Wrap};
use crate::space::FrameSize;
use ash::vk;
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// Creates an instance with validation; `None`, with a message, if that is not available here.
fn instance(messages: &Messages) -> Option<Arc<Instance>> {
    let opened = Instance::new(Some(messages)).and_then(|instance| {
        choose(&instance, &DeviceChoice::Vulkan)?;
        Ok(Arc::new(instance))
    });
    if std::env::var_os("PINWARP_REQUIRE_VULKAN").is_some_and(|value| value == "1") {
        return Some(opened.expect("PINWARP_REQUIRE_VULKAN is set"));
    }
    opened.map_err(|error| skip(&error.to_string())).ok()
}

fn device(instance: &Arc<Instance>) -> Arc<Device> {
    device_with(instance, Placement::Mapped)
}

fn device_with(instance: &Arc<Instance>, placement: Placement) -> Arc<Device> {
    Device::new(Arc::clone(instance), &candidate(instance, placement)).unwrap()
}

/// Returns the best device, with mapped attachments if supported, or with copied ones.
fn candidate(instance: &Instance, placement: Placement) -> Candidate {
    let mut candidate = choose(instance, &DeviceChoice::Vulkan).unwrap();
    candidate.has_mapped_attachments &= placement == Placement::Mapped;
    candidate
}

/// A scene with an opaque, a textured and a blended material.
fn scene() -> Scene {
    let reference = TextureRef { texture: 0, uv_set: 0, texture_from_uv: [Vec3::X, Vec3::Y] };
    let textured = Material { base_color_texture: Some(reference), ..Material::default() };
    let blended = Material { alpha: AlphaMode::Blend, ..Material::default() };
    let (wrap, linear) = ([Wrap::Repeat; 2], Filter::Linear);
    Scene {
        materials: vec![textured, blended],
        textures: vec![Texture { image: 0, wrap, magnify: linear, minify: linear, mipmap: Some(linear) }],
        images: vec![SceneImage { width: 4, height: 4, rgba: vec![200; 64], is_srgb: true }],
        ..Scene::default()
    }
}

/// The same triangle with each material.
fn geometry() -> Geometry {
    let corner = |x: f32, y: f32| RasterVertex { screen: [x, y, 0.5, 1.0], next: [x, y, 1.0], ..Default::default() };
    let draw = |material| Draw {
        indices: 0..3,
        material,
        layer_id: 1,
        object_id: 2,
        mattes: Default::default(),
        is_mirrored: false,
    };
    Geometry {
        vertices: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)],
        indices: vec![0, 1, 2],
        draws: vec![draw(0), draw(1)],
        ..Geometry::default()
    }
}

/// Renders with every image and pipeline: two beauty passes with data, of growing size.
fn draw_all(device: Arc<Device>) -> Result<Frame, RasterError> {
    let mut raster = VulkanRaster::on_device(device, &scene())?;
    let frame = FrameSize::new(16, 16);
    let channels = vec![ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Id];
    raster.start(&Target { frame, window: frame.window(), channels, beauty_passes: 2 })?;
    for role in [PassRole::BeautyAndData, PassRole::Beauty] {
        raster.draw(&Pass { geometry: &geometry(), jitter_px: Vec2::ZERO, role })?;
    }
    raster.finish()
}

/// Makes every call fail once, the first, the second, and so on, until none is left: the error must be `is_clean`,
/// everything must be destroyed, and the layers must report nothing. Returns the number of calls.
fn fail_each_call<T>(
    (instance, messages): (&Arc<Instance>, &Messages),
    (fault, placement): (Fault, Placement),
    draw: impl Fn(Arc<Device>) -> Result<T, RasterError>,
) -> usize {
    let mut after = 0;
    loop {
        let device = shim::device(instance, &candidate(instance, placement), Fault { after, ..fault }).unwrap();
        let drawn = draw(Arc::clone(&device));
        let failed = shim::heal();
        assert_eq!(Arc::strong_count(&device), 1, "{failed:?} failed, and something still holds the device");
        assert!(!device.is_abandoned(), "{failed:?} failed once, and the device was given up");
        drop(device);
        assert_eq!(messages.take(), Vec::<String>::new(), "call {after}, {failed:?}, failed");
        let Some(failed) = failed else {
            drawn.expect("nothing failed");
            return after;
        };
        let is_clean = match fault.code {
            vk::Result::ERROR_DEVICE_LOST => matches!(drawn, Err(RasterError::DeviceLost { .. })),
            _ => matches!(drawn, Err(RasterError::OutOfMemory { .. })),
        };
        // The allocator retries with smaller sizes, and a dropped rasteriser waits again.
        let may_recover = ["allocate_memory", "map_memory", "wait_for_fences"].contains(&failed) && drawn.is_ok();
        assert!(is_clean || may_recover, "{failed} failed: {:?}", drawn.err());
        after += 1;
    }
}

const MEMORY: Fault = Fault { after: 0, code: vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, calls: &[], is_lasting: false };
const LOST: Fault =
    Fault { code: vk::Result::ERROR_DEVICE_LOST, calls: &["queue_submit2", "wait_for_fences"], ..MEMORY };

#[test]
fn any_call_may_run_out_of_memory_and_nothing_leaks() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    for placement in [Placement::Mapped, Placement::Device] {
        let calls = fail_each_call((&instance, &messages), (MEMORY, placement), draw_all);
        assert!(calls > 120, "only {calls} calls went through the table");
    }
}

#[test]
fn the_device_may_be_lost_at_any_time() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let calls = fail_each_call((&instance, &messages), (LOST, Placement::Device), draw_all);
    assert!(calls > 8, "only {calls} submissions and waits went through the table");
}

#[test]
fn a_wait_that_fails_leaves_the_commands_pending() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let fault = Fault { calls: &["wait_for_fences"], ..MEMORY };
    let device = shim::device(&instance, &candidate(&instance, Placement::Device), fault).unwrap();
    let (mut commands, mut image, buffer) = copy_kit(&device);
    commands.begin().unwrap();
    commands.prepare(&mut image, Usage::CopyTarget, Contents::Discard);
    commands.copy_from_host(&buffer, &image, &WHOLE);
    commands.submit().unwrap();
    assert!(matches!(commands.wait(), Err(RasterError::OutOfMemory { .. })));
    // It waits again: the pool must not be reset while commands run.
    commands.begin().unwrap();
    assert_eq!(shim::heal(), Some("wait_for_fences"));
    drop((commands, image, buffer));
    drop(device);
    assert_eq!(messages.take(), Vec::<String>::new());
}

#[test]
fn what_a_device_may_still_use_is_not_destroyed() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let fault = Fault { calls: &["wait_for_fences", "device_wait_idle"], is_lasting: true, ..MEMORY };
    let device = shim::device(&instance, &candidate(&instance, Placement::Device), fault).unwrap();
    let drawn = draw_all(Arc::clone(&device));
    assert!(matches!(drawn, Err(RasterError::OutOfMemory { .. })), "{drawn:?}");
    assert_eq!(Arc::strong_count(&device), 1);
    assert!(device.is_abandoned());
    drop(device);
    shim::heal();
    assert_eq!(messages.take(), Vec::<String>::new());
}

#[test]
fn vertices_beyond_the_device_s_limit_are_refused() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let mut candidate = candidate(&instance, Placement::Device);
    (candidate.has_full_indices, candidate.limits.max_draw_indexed_index_value) = (false, 1);
    let drawn = draw_all(Device::new(Arc::clone(&instance), &candidate).unwrap());
    let error = drawn.unwrap_err().to_string();
    assert!(error.contains("3 vertices") && error.contains("2 at most") && error.contains("--device cpu"), "{error}");
    (candidate.has_full_indices, candidate.limits.max_draw_indexed_index_value) = (false, 2);
    assert!(draw_all(Device::new(instance, &candidate).unwrap()).is_ok());
}

/// Resamples a small plate, shifted by half a pixel.
fn resample(mut remap: VulkanRemap) -> Result<Vec<Vec<f32>>, RasterError> {
    let frame = FrameSize::new(16, 16);
    let mut map = WarpMap::identity(frame, frame.window());
    map.offsets.fill([0.5, 0.0]);
    let plane = vec![1.0; 256];
    let source = Planes { window: frame.window(), planes: vec![&plane] };
    remap.resample(&map, &source, PlateFilter::Lanczos)
}

#[test]
fn any_call_of_a_remap_may_fail_and_nothing_leaks() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let draw = |device| VulkanRemap::on_device(device).and_then(resample);
    let calls = fail_each_call((&instance, &messages), (MEMORY, Placement::Device), draw);
    assert!(calls > 20, "only {calls} calls went through the table");
    fail_each_call((&instance, &messages), (LOST, Placement::Device), draw);
    let remap = VulkanRemap::on_device(device(&instance)).unwrap();
    let drawn = resample(remap).unwrap();
    assert!(drawn[0][..15].iter().all(|x| (x - 1.0).abs() < 1e-6), "{drawn:?}");
}

#[test]
fn copied_and_mapped_images_make_the_same_frame() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let [mapped, copied] =
        [Placement::Mapped, Placement::Device].map(|placement| draw_all(device_with(&instance, placement)).unwrap());
    assert!(mapped == copied);
    assert!(mapped.channels.iter().any(|channel| channel.samples.contains(&2.0)), "something was drawn");
    assert_eq!(messages.take(), Vec::<String>::new());
}

/// Returns an image of 4x4 texels, a buffer of the same size, and commands.
fn copy_kit(device: &Arc<Device>) -> (Commands, Image, Buffer) {
    let usage = vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::SAMPLED;
    let wanted = ImageUse {
        name: "canary",
        format: vk::Format::R8G8B8A8_UNORM,
        usage,
        mip_levels: 1,
        placement: Placement::Device,
    };
    let image = Image::new(device, wanted, vk::Extent2D { width: 4, height: 4 }).unwrap();
    let wanted =
        BufferUse { name: "canary", usage: vk::BufferUsageFlags::TRANSFER_SRC, location: MemoryLocation::CpuToGpu };
    (Commands::new(device, "canary").unwrap(), image, Buffer::new(device, wanted, 64).unwrap())
}

const WHOLE: [(u32, vk::Extent2D, u64); 1] = [(0, vk::Extent2D { width: 4, height: 4 }, 0)];

#[test]
fn a_missing_barrier_is_seen() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let device = device(&instance);
    let (mut commands, mut image, buffer) = copy_kit(&device);
    commands.begin().unwrap();
    commands.prepare(&mut image, Usage::CopyTarget, Contents::Discard);
    commands.copy_from_host(&buffer, &image, &WHOLE);
    assert_eq!(messages.take(), Vec::<String>::new(), "so far all is well");
    commands.copy_from_host(&buffer, &image, &WHOLE);
    commands.submit().unwrap();
    commands.wait().unwrap();
    let said = messages.take();
    assert!(said.iter().any(|text| text.contains("SYNC-HAZARD-WRITE-AFTER-WRITE")), "{said:#?}");
}

#[test]
fn a_wrong_layout_is_seen() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let device = device(&instance);
    let (mut commands, mut image, buffer) = copy_kit(&device);
    commands.begin().unwrap();
    commands.prepare(&mut image, Usage::CopySource, Contents::Discard);
    commands.copy_from_host(&buffer, &image, &WHOLE);
    commands.submit().unwrap();
    commands.wait().unwrap();
    let said = messages.take();
    assert!(said.iter().any(|text| text.contains("VUID-vkCmdCopyBufferToImage-dstImageLayout")), "{said:#?}");
}

#[test]
fn leaks_are_seen() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let device = device(&instance);
    // SAFETY: no preconditions; the fence is leaked on purpose.
    let _fence = unsafe { device.raw().create_fence(&vk::FenceCreateInfo::default(), None) }.unwrap();
    let requirements = vk::MemoryRequirements { size: 64, alignment: 16, memory_type_bits: u32::MAX };
    let wanted = gpu_allocator::vulkan::AllocationCreateDesc {
        name: "left behind",
        requirements,
        location: MemoryLocation::GpuOnly,
        linear: true,
        allocation_scheme: gpu_allocator::vulkan::AllocationScheme::GpuAllocatorManaged,
    };
    std::mem::forget(device.allocate(&wanted).unwrap());
    drop(device);
    let said = messages.take();
    assert!(said.iter().any(|text| text.contains("leaked memory: left behind")), "{said:#?}");
    assert!(said.iter().any(|text| text.contains("VkFence")), "{said:#?}");
}
