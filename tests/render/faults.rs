//! Devices that fail and users who stop a render: the other frames are good, and nothing hangs.

use super::support::{Studio, pinned_layer};
use super::tiny::{Tiny, grid};
use pinwarp::image::{Frame, is_complete};
use pinwarp::pipeline::{Event, PreparedShot, RenderOptions, Summary, render_on};
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::{DeviceClass, Pass, Raster, RasterError, Target};
use pinwarp::shot::Shutter;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A step of drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Start,
    Draw(usize),
    Finish,
}

/// A device that fails at one step of its third frame.
struct Faulty {
    inner: CpuRaster,
    fails_at: Step,
    frames: usize,
    passes: usize,
}

impl Faulty {
    fn step(&self, step: Step) -> Result<(), RasterError> {
        if self.frames == 3 && step == self.fails_at {
            return Err(RasterError::OutOfMemory { what: "a test".into() });
        }
        Ok(())
    }
}

impl Raster for Faulty {
    fn name(&self) -> String {
        "faulty".into()
    }

    fn class(&self) -> DeviceClass {
        DeviceClass::Cpu
    }

    fn max_side(&self) -> u32 {
        self.inner.max_side()
    }

    fn start(&mut self, target: &Target) -> Result<(), RasterError> {
        self.frames += 1;
        self.passes = 0;
        self.step(Step::Start)?;
        self.inner.start(target)
    }

    fn draw(&mut self, pass: &Pass) -> Result<(), RasterError> {
        self.passes += 1;
        self.step(Step::Draw(self.passes))?;
        self.inner.draw(pass)
    }

    fn finish(&mut self) -> Result<Frame, RasterError> {
        self.step(Step::Finish)?;
        self.inner.finish()
    }
}

/// Eight blurred frames of a square.
fn prepared(folder: &std::path::Path) -> (Studio, PreparedShot) {
    let keys = "{ frame = 1, offset = [0.0, 0.0] }, { frame = 9, offset = [0.4, 0.0] }";
    let tiny = Tiny::of(vec![grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2)]);
    let mut studio = Studio::tiny(&tiny, &pinned_layer(keys));
    studio.shot.frames.last = 8;
    studio.shot.samples = 6;
    studio.shot.shutter = Shutter { angle: 180.0, phase: -90.0 };
    studio.shot.output.path = folder.join("f.####.exr");
    let prepared = studio.prepared();
    (studio, prepared)
}

/// Renders; the frames that are done and that failed, as told.
fn told(
    device: &mut dyn Raster,
    prepared: &PreparedShot,
    cancel_after: usize,
) -> (Vec<i32>, Vec<(i32, String)>, Summary) {
    let (done, failed) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let cancel = AtomicBool::new(false);
    let tell = |event: Event| match event {
        Event::FrameDone(report) => {
            let mut done = done.lock().expect("no panic");
            done.push(report.frame);
            cancel.fetch_or(done.len() >= cancel_after, Ordering::Relaxed);
        }
        Event::FrameFailed { frame, error } => failed.lock().expect("no panic").push((frame, error)),
        _ => {}
    };
    let summary = render_on(device, prepared, &RenderOptions::default(), &cancel, &tell).expect("it starts");
    (done.into_inner().expect("no panic"), failed.into_inner().expect("no panic"), summary)
}

#[test]
fn a_frame_that_fails_does_not_stop_the_others() {
    for fails_at in [Step::Start, Step::Draw(1), Step::Draw(4), Step::Draw(7), Step::Finish] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (_studio, prepared) = prepared(folder.path());
        let mut device = Faulty { inner: CpuRaster::new(&prepared.scene), fails_at, frames: 0, passes: 0 };
        let (done, failed, summary) = told(&mut device, &prepared, usize::MAX);
        assert_eq!(done, [1, 2, 4, 5, 6, 7, 8], "{fails_at:?}");
        assert!(failed.len() == 1 && failed[0].0 == 3 && failed[0].1.contains("a test"), "{fails_at:?}: {failed:?}");
        assert_eq!((summary.rendered, summary.failed, summary.is_cancelled), (7, 1, false));
        for frame in 1..=8 {
            assert_eq!(is_complete(&folder.path().join(format!("f.{frame:04}.exr"))), frame != 3);
        }
    }
}

#[test]
fn a_stopped_render_ends_with_whole_frames() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_studio, mut prepared) = prepared(folder.path());
    prepared.shot.frames.last = 12;
    let (done, failed, summary) = told(&mut CpuRaster::new(&prepared.scene), &prepared, 2);
    assert!(summary.is_cancelled && failed.is_empty());
    // Those in flight are finished: one being posed, drawn, written, and one waiting at each border.
    assert!((2..12).contains(&done.len()), "{done:?}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), done.len());
    assert!(done.iter().all(|frame| is_complete(&folder.path().join(format!("f.{frame:04}.exr")))));
}
