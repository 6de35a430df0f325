//! Tests that need the inside of the raster: failing creations, and that the validation layers see mistakes.

use super::choose::choose;
use super::commands::{Commands, Contents, Usage};
use super::device::Device;
use super::instance::Instance;
use super::memory::{Buffer, BufferUse, Home, Image, ImageUse, MemoryLocation};
use super::{Messages, VulkanRaster, VulkanRemap};
use crate::image::Frame;
use crate::plate::{Filter as PlateFilter, Planes, WarpMap};
use crate::raster::{
    ChannelGroup, DeviceChoice, Draw, Geometry, Pass, PassRole, Raster, RasterError, RasterVertex, Target,
};
use crate::scene::{AlphaMode, Filter, Image as SceneImage, Material, Scene, Texture, TextureRef, Wrap};
use crate::space::FrameSize;
use ash::vk;
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// An instance with validation; `None`: not to be had here, said so.
fn instance(messages: &Messages) -> Option<Arc<Instance>> {
    let opened = Instance::new(Some(messages)).and_then(|instance| {
        choose(&instance, &DeviceChoice::Auto)?;
        Ok(Arc::new(instance))
    });
    if std::env::var_os("PINWARP_REQUIRE_VULKAN").is_some_and(|value| value == "1") {
        return Some(opened.expect("PINWARP_REQUIRE_VULKAN is set"));
    }
    opened.map_err(|error| eprintln!("SKIPPED: {error}")).ok()
}

fn device(instance: &Arc<Instance>) -> Arc<Device> {
    device_with(instance, Home::Mapped)
}

/// With attachments mapped where the device can do that, or always copied.
fn device_with(instance: &Arc<Instance>, home: Home) -> Arc<Device> {
    let mut candidate = choose(instance, &DeviceChoice::Auto).unwrap();
    candidate.has_mapped_attachments &= home == Home::Mapped;
    Device::new(Arc::clone(instance), &candidate).unwrap()
}

/// An opaque, textured and a blended material.
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

/// Every image and pipeline of the raster takes part: two beauty passes with data, of growing size.
fn draw_all(device: Arc<Device>) -> Result<Frame, RasterError> {
    let mut raster = VulkanRaster::on_device(device, &scene())?;
    let frame = FrameSize::new(16, 16);
    let channels = vec![ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Id];
    raster.start(&Target { frame, window: frame.window(), channels, beauty_passes: 2 })?;
    for role in [PassRole::BeautyAndData, PassRole::BeautyAndData] {
        raster.draw(&Pass { geometry: &geometry(), jitter_px: Vec2::ZERO, role })?;
    }
    raster.finish()
}

#[test]
fn any_creation_may_fail_and_nothing_leaks() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    for home in [Home::Mapped, Home::Device] {
        fail_each_creation(&instance, home, &messages);
    }
}

fn fail_each_creation(instance: &Arc<Instance>, home: Home, messages: &Messages) {
    for count in 0.. {
        let device = device_with(instance, home);
        device.fail_after(count);
        let drawn = draw_all(Arc::clone(&device));
        let has_failed = device.has_failed();
        assert_eq!(Arc::strong_count(&device), 1, "creation {count} failed, and something still holds the device");
        drop(device);
        let said = messages.take();
        assert!(said.is_empty(), "creation {count} failed: {said:#?}");
        if !has_failed {
            drawn.expect("nothing failed");
            assert!(count > 80, "only {count} creations went through the counter");
            break;
        }
        assert!(matches!(drawn, Err(RasterError::OutOfMemory { .. })), "creation {count}: {drawn:?}");
    }
}

/// Resamples a small plate, moved by half a pixel.
fn resample(mut remap: VulkanRemap) -> Result<Vec<Vec<f32>>, RasterError> {
    let frame = FrameSize::new(16, 16);
    let mut map = WarpMap::identity(frame, frame.window());
    map.offsets.fill([0.5, 0.0]);
    let plane = vec![1.0; 256];
    let source = Planes { window: frame.window(), planes: vec![&plane] };
    remap.resample(&map, &source, PlateFilter::Lanczos)
}

#[test]
fn any_creation_of_a_remap_may_fail_and_nothing_leaks() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    for count in 0.. {
        let device = device(&instance);
        device.fail_after(count);
        let drawn = VulkanRemap::on_device(Arc::clone(&device)).and_then(resample);
        let has_failed = device.has_failed();
        assert_eq!(Arc::strong_count(&device), 1, "creation {count} failed, and something still holds the device");
        drop(device);
        assert_eq!(messages.take(), Vec::<String>::new(), "creation {count} failed");
        if !has_failed {
            let drawn = drawn.expect("nothing failed");
            assert!(drawn[0][..15].iter().all(|x| (x - 1.0).abs() < 1e-6), "{drawn:?}");
            assert!(count > 15, "only {count} creations went through the counter");
            break;
        }
        assert!(matches!(drawn, Err(RasterError::OutOfMemory { .. })), "creation {count}: {drawn:?}");
    }
}

#[test]
fn copied_and_mapped_images_make_the_same_frame() {
    let messages = Messages::default();
    let Some(instance) = instance(&messages) else { return };
    let [mapped, copied] = [Home::Mapped, Home::Device].map(|home| draw_all(device_with(&instance, home)).unwrap());
    assert!(mapped == copied);
    assert!(mapped.channels.iter().any(|channel| channel.samples.contains(&2.0)), "something was drawn");
    assert_eq!(messages.take(), Vec::<String>::new());
}

/// An image of 4x4 texels, a buffer that holds as many, and commands.
fn copy_kit(device: &Arc<Device>) -> (Commands, Image, Buffer) {
    let usage = vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::SAMPLED;
    let wanted =
        ImageUse { name: "canary", format: vk::Format::R8G8B8A8_UNORM, usage, mip_levels: 1, home: Home::Device };
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
    // SAFETY: no preconditions; the fence is left behind on purpose.
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
