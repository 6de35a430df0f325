//! Stored pictures of all scenes: what the program draws today is what it drew when somebody last looked.
//!
//! Small EXR files beside this one; README.md says how to add one. `UPDATE=1` writes them anew.

mod cases;
#[path = "../support/compare.rs"]
mod compare;
mod limits;
mod report;
#[path = "../support/skip.rs"]
mod skip;

use cases::{Case, cases};
use limits::Backend;
use pinwarp::image::{Frame, Plate, read_exr, write_plate};
use pinwarp::pipeline::PipelineError;
use pinwarp::raster::{DeviceChoice, RasterError};
use std::path::{Path, PathBuf};

/// The largest stored file, bytes.
const LARGEST: u64 = 160_000;

fn stored(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.exr"))
}

fn is_update() -> bool {
    std::env::var_os("UPDATE").is_some()
}

/// What is wrong with a picture, in words; `None` where it is as it was.
fn fault(case: &Case, drawn: &Frame, backend: Backend) -> Option<String> {
    let expected = match read_exr(&stored(case.name)) {
        Ok(expected) => expected,
        Err(error) => return Some(format!("{}: {error}; UPDATE=1 writes it", case.name)),
    };
    let faults = limits::faults(drawn, &expected, backend);
    if faults.is_empty() {
        return None;
    }
    let strip = report::write_strip(case.name, [&expected, drawn]);
    Some(format!("{}: {faults:?}; expected, difference, drawn: {}", case.name, strip.display()))
}

#[test]
fn pictures_are_as_they_were() {
    let all = cases();
    assert!(all.len() >= 25, "{} cases", all.len());
    let mut faults = Vec::new();
    for case in all {
        let drawn = case.draw(DeviceChoice::Cpu).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        if is_update() {
            write_plate(&stored(case.name), &Plate::from_frame(drawn)).expect("the folder can be written to");
        } else {
            faults.extend(fault(case, &drawn, Backend::Cpu));
        }
    }
    assert!(faults.is_empty(), "{} of {} pictures differ\n{}", faults.len(), all.len(), faults.join("\n"));
}

#[test]
fn a_driver_draws_the_same_pictures() {
    let mut faults = Vec::new();
    for case in cases().iter().filter(|case| case.is_drawn()) {
        match case.draw(DeviceChoice::Named("0".into())) {
            Ok(drawn) => faults.extend(fault(case, &drawn, Backend::Vulkan)),
            Err(PipelineError::Raster(RasterError::NoDevice { .. } | RasterError::UnknownDevice { .. }))
                if !is_required() =>
            {
                skip::skip("no Vulkan driver");
                return;
            }
            Err(error) => panic!("{}: {error}", case.name),
        }
    }
    assert!(faults.is_empty(), "{} pictures differ\n{}", faults.len(), faults.join("\n"));
}

fn is_required() -> bool {
    std::env::var_os("PINWARP_REQUIRE_VULKAN").is_some()
}

#[test]
fn every_stored_picture_has_a_case_and_is_small() {
    let names: Vec<&str> = cases().iter().map(|case| case.name).collect();
    for entry in std::fs::read_dir(stored("x").with_file_name("")).expect("the folder exists").flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|extension| extension == "exr") {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            assert!(names.contains(&name.as_str()), "{name}.exr belongs to no case");
            let bytes = entry.metadata().expect("a file").len();
            assert!(bytes <= LARGEST, "{name}.exr has {bytes} bytes");
        }
    }
}

/// A picture drawn from one pin pulled a 25th of the frame too far must not pass for the stored one, on any backend.
#[test]
fn a_wrong_pose_is_noticed() {
    let case = cases().iter().find(|case| case.name == "teapot.0012").expect("a case");
    let drawn = case.spoiled(cases::pull_too_far);
    let expected = read_exr(&stored(case.name)).expect("it is stored");
    for backend in [Backend::Cpu, Backend::Vulkan] {
        assert!(!limits::faults(&drawn, &expected, backend).is_empty(), "{backend:?} does not see it");
    }
}
