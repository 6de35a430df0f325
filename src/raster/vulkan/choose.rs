//! Enumerates the Vulkan devices and selects one.
//!
//! In: an instance, the user's choice. Out: a physical device with its limits and features.

use super::fault::{no_device, vulkan_error};
use super::formats::{COLOR, DATA, DEPTH_FORMAT, IMAGES, READ_BACK};
use super::instance::{API_VERSION, Instance, version_text};
use crate::raster::{DeviceChoice, RasterError};
use ash::vk;
use std::fmt;

/// Kinds of device, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum DeviceKind {
    /// A graphics card.
    Discrete,
    /// Integrated into the processor.
    Integrated,
    /// A virtual GPU.
    Virtual,
    /// A software driver on the CPU.
    Software,
    /// Anything else.
    Other,
}

impl DeviceKind {
    /// Returns whether it is graphics hardware, not a software driver.
    #[must_use]
    pub(crate) const fn is_card(self) -> bool {
        matches!(self, Self::Discrete | Self::Integrated | Self::Virtual)
    }
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Software => "software",
            Self::Other => "other",
        })
    }
}

/// A device as listed by `pinwarp devices`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DeviceInfo {
    /// Its index for `--device`.
    pub index: usize,
    /// Its name; any part of it can be passed to `--device`.
    pub name: String,
    /// Its kind.
    pub kind: DeviceKind,
    /// Driver name and version: `llvmpipe Mesa 22.3.6 (LLVM 15.0.6)`.
    pub driver: String,
    /// Vulkan version: `1.3.230`.
    pub api_version: String,
    /// Device memory in bytes.
    pub memory_bytes: u64,
    /// The reason why it is unusable; `None` if it is usable.
    pub unusable: Option<String>,
}

/// A device with the properties that determine whether and how it can be used.
pub(super) struct Candidate {
    pub(super) physical: vk::PhysicalDevice,
    pub(super) info: DeviceInfo,
    pub(super) limits: vk::PhysicalDeviceLimits,
    pub(super) max_allocation_bytes: u64,
    pub(super) queue_family: u32,
    pub(super) has_anisotropy: bool,
    /// Whether indices above 2^24 - 1 may be drawn.
    pub(super) has_full_indices: bool,
    pub(super) has_mapped_attachments: bool,
}

/// Returns all Vulkan devices, usable or not.
///
/// # Errors
/// [`RasterError::NoDevice`] if loader or drivers are missing.
pub(crate) fn devices() -> Result<Vec<DeviceInfo>, RasterError> {
    let instance = Instance::new(None)?;
    Ok(candidates(&instance)?.into_iter().map(|candidate| candidate.info).collect())
}

/// Returns the best device for the choice.
pub(super) fn choose(instance: &Instance, choice: &DeviceChoice) -> Result<Candidate, RasterError> {
    let mut all = candidates(instance)?;
    let wanted = match choice {
        DeviceChoice::Auto => best(&all, |kind| kind.is_card())?,
        DeviceChoice::Vulkan => best(&all, |_| true)?,
        DeviceChoice::Named(name) => named(&all, name)?,
        DeviceChoice::Cpu => return Err(RasterError::Misuse("the CPU is not a Vulkan device")),
    };
    Ok(all.swap_remove(wanted))
}

/// Returns the best usable device of the accepted kinds.
fn best(all: &[Candidate], is_wanted: impl Fn(DeviceKind) -> bool) -> Result<usize, RasterError> {
    let serves = |candidate: &Candidate| candidate.info.unusable.is_none() && is_wanted(candidate.info.kind);
    let usable = all.iter().enumerate().filter(|(_, candidate)| serves(candidate));
    let best = usable.min_by_key(|(_, candidate)| candidate.info.kind).map(|(index, _)| index);
    best.ok_or_else(|| {
        let reasons: Vec<String> = all.iter().map(|candidate| reason(&candidate.info)).collect();
        no_device(if reasons.is_empty() { "no driver found a device".into() } else { reasons.join(", ") })
    })
}

fn reason(info: &DeviceInfo) -> String {
    format!("{}: {}", info.name, info.unusable.as_deref().unwrap_or("software, slower than --device cpu"))
}

/// Finds a device by index, else by a case-insensitive part of its name.
fn named(all: &[Candidate], wanted: &str) -> Result<usize, RasterError> {
    let lower = wanted.to_lowercase();
    let by_name = || all.iter().position(|candidate| candidate.info.name.to_lowercase().contains(&lower));
    let found = wanted.parse().ok().filter(|&index: &usize| index < all.len()).or_else(by_name);
    let Some(index) = found else {
        let names: Vec<String> =
            all.iter().map(|candidate| format!("{} {}", candidate.info.index, candidate.info.name)).collect();
        let available = if names.is_empty() { "none".into() } else { names.join(", ") };
        return Err(RasterError::UnknownDevice { wanted: wanted.into(), available });
    };
    match &all[index].info.unusable {
        None => Ok(index),
        Some(_) => Err(no_device(reason(&all[index].info))),
    }
}

fn candidates(instance: &Instance) -> Result<Vec<Candidate>, RasterError> {
    // SAFETY: the instance is alive.
    let found = unsafe { instance.raw().enumerate_physical_devices() };
    let physical = found.map_err(|result| match result {
        vk::Result::ERROR_INITIALIZATION_FAILED => no_device("drivers are installed, but none finds its hardware"),
        result => vulkan_error("vkEnumeratePhysicalDevices")(result),
    })?;
    Ok(physical.into_iter().enumerate().map(|(index, physical)| candidate(instance, index, physical)).collect())
}

fn candidate(instance: &Instance, index: usize, physical: vk::PhysicalDevice) -> Candidate {
    // SAFETY: `physical` comes from this instance, here and below.
    let basic = unsafe { instance.raw().get_physical_device_properties(physical) };
    // A driver older than 1.1 does not fill the chained structures.
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut maintenance = vk::PhysicalDeviceMaintenance3Properties::default();
    let mut more = vk::PhysicalDeviceProperties2::default();
    if basic.api_version >= API_VERSION {
        more = more.push_next(&mut driver).push_next(&mut maintenance);
    }
    if basic.api_version >= vk::API_VERSION_1_1 {
        // SAFETY: as above; the chain is valid for the device's version.
        unsafe { instance.raw().get_physical_device_properties2(physical, &mut more) };
    }
    // SAFETY: as above.
    let features = unsafe { instance.raw().get_physical_device_features(physical) };
    let queue_family = graphics_family(instance, physical);
    let info = DeviceInfo {
        index,
        name: text(basic.device_name_as_c_str()),
        kind: kind(basic.device_type),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
        api_version: version_text(basic.api_version),
        memory_bytes: device_memory(instance, physical),
        unusable: unusable(instance, physical, &basic, queue_family),
    };
    Candidate {
        physical,
        info,
        limits: basic.limits,
        max_allocation_bytes: maintenance.max_memory_allocation_size,
        queue_family: queue_family.unwrap_or(0),
        has_anisotropy: features.sampler_anisotropy == vk::TRUE,
        has_full_indices: features.full_draw_index_uint32 == vk::TRUE,
        has_mapped_attachments: has_mapped_attachments(instance, physical, &basic),
    }
}

/// Returns whether the host may read attachments in place. Queried for software devices only, whose memory is the
/// host's and whose images are linear anyway; a graphics card renders faster into its own memory and layout.
fn has_mapped_attachments(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    basic: &vk::PhysicalDeviceProperties,
) -> bool {
    use vk::MemoryPropertyFlags as Memory;
    let needed = Memory::DEVICE_LOCAL | Memory::HOST_VISIBLE | Memory::HOST_COHERENT | Memory::HOST_CACHED;
    // SAFETY: `physical` comes from this instance, here and below.
    let memory = unsafe { instance.raw().get_physical_device_memory_properties(physical) };
    let is_host_memory = memory.memory_types_as_slice().iter().all(|kind| kind.property_flags.contains(needed));
    let can_be_linear = |format: vk::Format| {
        // SAFETY: as above.
        let features = unsafe { instance.raw().get_physical_device_format_properties(physical, format) };
        let blended = vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND;
        let (kind, tiling) = (vk::ImageType::TYPE_2D, vk::ImageTiling::LINEAR);
        let none = vk::ImageCreateFlags::empty();
        // SAFETY: as above.
        let limits = unsafe {
            instance.raw().get_physical_device_image_format_properties(physical, format, kind, tiling, READ_BACK, none)
        };
        let side = basic.limits.max_image_dimension2_d;
        features.linear_tiling_features.contains(blended)
            && limits.is_ok_and(|limits| limits.max_extent.width.min(limits.max_extent.height) >= side)
    };
    basic.device_type == vk::PhysicalDeviceType::CPU
        && is_host_memory
        && IMAGES.iter().all(|spec| can_be_linear(spec.format))
}

fn text(name: Result<&std::ffi::CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn kind(kind: vk::PhysicalDeviceType) -> DeviceKind {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Software,
        _ => DeviceKind::Other,
    }
}

fn graphics_family(instance: &Instance, physical: vk::PhysicalDevice) -> Option<u32> {
    // SAFETY: `physical` comes from this instance.
    let families = unsafe { instance.raw().get_physical_device_queue_family_properties(physical) };
    // Plates are warped by compute shaders; every graphics driver has a family for both.
    let needed = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    (0u32..).zip(families).find(|(_, family)| family.queue_flags.contains(needed)).map(|(at, _)| at)
}

fn device_memory(instance: &Instance, physical: vk::PhysicalDevice) -> u64 {
    // SAFETY: `physical` comes from this instance.
    let memory = unsafe { instance.raw().get_physical_device_memory_properties(physical) };
    let heaps = memory.memory_heaps_as_slice().iter();
    heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL)).map(|heap| heap.size).max().unwrap_or(0)
}

fn unusable(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    basic: &vk::PhysicalDeviceProperties,
    family: Option<u32>,
) -> Option<String> {
    if basic.api_version < API_VERSION {
        return Some(format!("it offers Vulkan {} only, 1.3 is needed", version_text(basic.api_version)));
    }
    if family.is_none() {
        return Some("it has no graphics queue".into());
    }
    if let Some(fault) = lacks_attachments(&basic.limits) {
        return Some(fault);
    }
    use vk::FormatFeatureFlags as Feature;
    let color = Feature::COLOR_ATTACHMENT | Feature::TRANSFER_SRC;
    let blended = color | Feature::COLOR_ATTACHMENT_BLEND | Feature::SAMPLED_IMAGE;
    let needs = DATA.iter().map(|spec| (spec.format, color));
    let needs = needs.chain([(COLOR.format, blended), (DEPTH_FORMAT, Feature::DEPTH_STENCIL_ATTACHMENT)]);
    needs.into_iter().find_map(|(format, needed)| {
        // SAFETY: `physical` comes from this instance.
        let found = unsafe { instance.raw().get_physical_device_format_properties(physical, format) };
        let lacks = needed & !found.optimal_tiling_features;
        (!lacks.is_empty()).then(|| format!("it lacks {lacks:?} for images of {format:?}"))
    })
}

/// Colour and all data are rendered simultaneously.
fn lacks_attachments(limits: &vk::PhysicalDeviceLimits) -> Option<String> {
    let most = limits.max_color_attachments.min(limits.max_fragment_output_attachments);
    let needed = IMAGES.len() as u32;
    (most < needed).then(|| format!("it draws into {most} images at once, {needed} are needed"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(name: &str, kind: DeviceKind, unusable: Option<&str>) -> Candidate {
        Candidate {
            physical: vk::PhysicalDevice::null(),
            info: DeviceInfo {
                index: 0,
                name: name.into(),
                kind,
                driver: String::new(),
                api_version: "1.3.0".into(),
                memory_bytes: 1 << 30,
                unusable: unusable.map(str::to_owned),
            },
            limits: vk::PhysicalDeviceLimits::default(),
            max_allocation_bytes: 1 << 30,
            queue_family: 0,
            has_anisotropy: false,
            has_full_indices: false,
            has_mapped_attachments: false,
        }
    }

    #[test]
    fn a_card_is_chosen_and_never_a_software_driver() {
        use DeviceKind::{Discrete, Integrated, Other, Software, Virtual};
        let soft = || candidate("llvmpipe", Software, None);
        let chosen = |all: &[Candidate]| best(all, DeviceKind::is_card);
        assert_eq!(chosen(&[soft(), candidate("a", Integrated, None), candidate("b", Discrete, None)]).ok(), Some(2));
        assert_eq!(chosen(&[soft(), candidate("a", Virtual, None)]).ok(), Some(1));
        assert_eq!(chosen(&[candidate("a", Discrete, Some("it is old")), candidate("b", Virtual, None)]).ok(), Some(1));
        for all in [vec![], vec![soft()], vec![soft(), candidate("x", Other, None)]] {
            assert!(matches!(chosen(&all), Err(RasterError::NoDevice { .. })));
        }
        let error = chosen(&[soft(), candidate("a", Discrete, Some("it is old"))]).unwrap_err().to_string();
        assert!(error.contains("llvmpipe: software") && error.contains("a: it is old"), "{error}");
        assert_eq!(best(&[soft()], |_| true).ok(), Some(0), "asked for by name");
    }

    #[test]
    fn devices_need_an_attachment_for_every_image() {
        let limits = |most| vk::PhysicalDeviceLimits {
            max_color_attachments: most,
            max_fragment_output_attachments: 8,
            ..vk::PhysicalDeviceLimits::default()
        };
        assert_eq!(lacks_attachments(&limits(4)), None);
        assert_eq!(lacks_attachments(&limits(3)).unwrap(), "it draws into 3 images at once, 4 are needed");
    }
}
