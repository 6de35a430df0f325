//! Finding devices: by index, by name, none at all, on two threads.

use super::stage::{self, everything};
use super::support::{self, draw, target};
use crate::internal::skip::skip;
use pinwarp::raster::vulkan::{VulkanRaster, devices};
use pinwarp::raster::{self, DeviceChoice, DeviceClass, Raster as _, RasterError};
use pinwarp::scene::Scene;
use std::process::Command;

/// Points the loader at other driver files.
const DRIVERS: &str = "VK_ICD_FILENAMES";

#[test]
fn devices_are_found_by_index_and_by_part_of_their_name() {
    if support::open(&Scene::default()).is_none() {
        return;
    }
    let all = devices().unwrap();
    for info in all.iter().filter(|info| info.unusable.is_none()) {
        assert!(!info.driver.trim().is_empty() && info.memory_bytes > 0, "{info:?}");
        let part = info.name.split(' ').next().unwrap().to_uppercase();
        for choice in [info.index.to_string(), info.name.clone(), part] {
            let raster = VulkanRaster::open(&DeviceChoice::Named(choice), &Scene::default()).unwrap();
            assert!(all.iter().any(|info| info.name == raster.name()));
        }
    }
    let best = VulkanRaster::open(&DeviceChoice::Vulkan, &Scene::default()).unwrap().name();
    let least = all.iter().filter(|info| info.unusable.is_none()).map(|info| info.kind).min();
    assert!(all.iter().any(|info| info.name == best && Some(info.kind) == least));
}

#[test]
fn an_unknown_device_is_an_error_that_lists_what_there_is() {
    if support::open(&Scene::default()).is_none() {
        return;
    }
    let error = raster::open(&DeviceChoice::Named("voodoo2".into()), &Scene::default()).err().unwrap();
    let first = devices().unwrap().remove(0).name;
    assert!(matches!(&error, RasterError::UnknownDevice { wanted, .. } if wanted == "voodoo2"));
    assert!(error.to_string().contains(&first), "{error}");
}

#[test]
fn two_threads_open_and_draw_at_once() {
    let scene = stage::scene();
    let picture = || {
        let mut raster = support::open(&scene)?;
        Some(draw(&mut *raster, &target(80, 60), &everything(4.0 / 3.0)))
    };
    let (first, second) = std::thread::scope(|scope| {
        let threads = [scope.spawn(picture), scope.spawn(picture)];
        let [first, second] = threads.map(|thread| thread.join().unwrap());
        (first, second)
    });
    assert!(first == second);
}

/// Not a test by itself: prints what opening says, for a process whose environment is another.
#[test]
#[ignore = "run by the tests below"]
fn probe() {
    let (raster, _) = raster::open(&DeviceChoice::Auto, &Scene::default()).unwrap();
    let reason = raster::open(&DeviceChoice::Vulkan, &Scene::default()).err().map(|error| error.to_string());
    println!("PROBE {} | {}", raster.name(), reason.unwrap_or_default());
}

fn probe_with(drivers: &str) -> String {
    let arguments = ["--exact", "internal::vulkan::devices::probe", "--ignored", "--nocapture"];
    let run = Command::new(std::env::current_exe().unwrap()).args(arguments).env(DRIVERS, drivers).output().unwrap();
    let text = String::from_utf8_lossy(&run.stdout);
    text.lines().find(|line| line.contains("PROBE")).unwrap_or_else(|| panic!("{text}")).to_owned()
}

#[test]
fn without_a_driver_the_cpu_draws_and_vulkan_says_why_not() {
    let said = probe_with("/nonexistent/driver.json");
    assert!(said.contains("PROBE CPU") && said.contains("no usable Vulkan device"), "{said}");
}

#[test]
fn a_driver_without_its_hardware_is_no_device() {
    let drivers =
        ["radeon", "intel", "intel_hasvk"].map(|name| format!("/usr/share/vulkan/icd.d/{name}_icd.x86_64.json"));
    let Some(driver) = drivers.iter().find(|path| std::path::Path::new(path).exists()) else {
        skip("no driver of a graphics card is installed");
        return;
    };
    let is_card = |info: &raster::vulkan::DeviceInfo| info.kind != raster::vulkan::DeviceKind::Software;
    if devices().is_ok_and(|all| all.iter().any(is_card)) {
        skip("a driver without its hardware: there is a graphics card");
        return;
    }
    let said = probe_with(driver);
    assert!(said.contains("PROBE CPU") && said.contains("hardware"), "{said}");
}

#[test]
fn a_software_driver_draws_only_where_it_is_asked_for() {
    if support::open(&Scene::default()).is_none() {
        return;
    }
    let has_card = devices().unwrap().iter().any(|info| info.unusable.is_none() && info.kind.is_card());
    let class = |choice| raster::open(&choice, &Scene::default()).unwrap().0.class();
    let automatic = if has_card { DeviceClass::Vulkan } else { DeviceClass::Cpu };
    assert_eq!(class(DeviceChoice::Auto), automatic);
    assert_eq!(raster::resampler(&DeviceChoice::Auto).unwrap().is_some(), has_card);
    assert_eq!(class(DeviceChoice::Vulkan), DeviceClass::Vulkan);
    assert_eq!(class(DeviceChoice::Named("0".into())), DeviceClass::Vulkan);
    assert_eq!(class(DeviceChoice::Cpu), DeviceClass::Cpu);
}
