//! What resamples the planes of a plate, and memory that is used again.
//!
//! In: maps, planes, a filter. Out: planes. The kernels of this stage resample, or a device that is lent; where that
//! fails, the kernels go on, and a warning says why.

use super::{Filter, Planes, WarpMap, resample_into};
use crate::image::Plate;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Something that resamples planes.
pub trait Resampler: Send {
    /// What resamples, for messages and metadata.
    fn name(&self) -> String;

    /// The planes as seen through the map, as [`resample_into`] gives them: each of `results` has `map.window.area()`
    /// samples, and every one of them is written.
    ///
    /// # Errors
    /// Where memory or the device fails; `results` may hold anything then.
    fn resample(
        &mut self,
        map: &WarpMap,
        source: &Planes,
        filter: Filter,
        results: &mut [Vec<f32>],
    ) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;
}

/// What a warp uses from plate to plate.
#[derive(Default)]
pub(super) struct ResampleContext {
    /// `None`: the kernels of this stage.
    device: Mutex<Option<Box<dyn Resampler>>>,
    /// Planes that nobody needs any more.
    buffer_pool: Mutex<Vec<Vec<f32>>>,
    warnings: Mutex<Vec<String>>,
}

/// What colour is resampled by.
#[derive(Clone, Copy)]
pub(super) struct Resampling<'a> {
    pub(super) context: &'a ResampleContext,
    pub(super) filter: Filter,
}

impl ResampleContext {
    pub(super) fn with_device(device: Option<Box<dyn Resampler>>) -> Self {
        Self { device: Mutex::new(device), ..Self::default() }
    }

    /// What resamples, where it is not the CPU.
    pub(super) fn device(&self) -> Option<String> {
        locked(&self.device).as_ref().map(|device| device.name())
    }

    /// Keeps the planes of a plate for the next one, instead of those kept before: fresh memory costs more time than
    /// what is written into it.
    pub(super) fn recycle(&self, plate: Plate) {
        let channels = plate.parts.into_iter().flat_map(|part| part.channels);
        *locked(&self.buffer_pool) = channels.map(|channel| channel.samples).collect();
    }

    /// A plane of so many samples, whatever they are.
    pub(super) fn plane(&self, length: usize) -> Vec<f32> {
        let mut buffers = locked(&self.buffer_pool);
        let fitting =
            buffers.iter().position(|plane| plane.capacity() >= length && plane.capacity() < 2 * length.max(1));
        let plane = fitting.map(|place| buffers.swap_remove(place));
        drop(buffers);
        plane.map_or_else(
            || vec![0.0; length],
            |mut plane| {
                plane.resize(length, 0.0);
                plane
            },
        )
    }

    /// What went wrong since this was asked before.
    pub(super) fn take_warnings(&self) -> Vec<String> {
        std::mem::take(&mut locked(&self.warnings))
    }
}

impl Resampling<'_> {
    /// The planes as seen through a map.
    pub(super) fn seen(self, map: &WarpMap, source: &Planes) -> Vec<Vec<f32>> {
        let mut results: Vec<_> = source.planes.iter().map(|_| self.context.plane(map.window.area())).collect();
        let mut device = locked(&self.context.device);
        if let Some(lent) = device.as_mut() {
            match lent.resample(map, source, self.filter, &mut results) {
                Ok(()) => return results,
                Err(error) => {
                    let name = lent.name();
                    locked(&self.context.warnings).push(format!("{name}: {error}; the CPU resamples from here on"));
                    *device = None;
                }
            }
        }
        // The kernels share out their work: nobody may wait for the lock meanwhile.
        drop(device);
        resample_into(map, source, self.filter, &mut results);
        results
    }
}

/// What a panicking thread left behind is whole: nothing is changed in steps.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{FrameSize, PixelRect};

    /// A device that works so many times.
    struct Mortal(usize);

    impl Resampler for Mortal {
        fn name(&self) -> String {
            "mortal".into()
        }

        fn resample(
            &mut self,
            _: &WarpMap,
            source: &Planes,
            _: Filter,
            results: &mut [Vec<f32>],
        ) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
            results.iter_mut().for_each(|plane| plane.fill(source.planes.len() as f32));
            self.0 = self.0.checked_sub(1).ok_or("the device was lost")?;
            Ok(())
        }
    }

    #[test]
    fn a_lost_device_is_told_once_and_the_cpu_goes_on() {
        let window = PixelRect { x: 0, y: 0, width: 3, height: 2 };
        let map = WarpMap::identity(FrameSize::new(3, 2), window);
        let samples = [0.5, 1.0, 2.0, 3.0, 4.0, 5.0];
        let source = Planes { window, planes: vec![&samples] };
        let context = ResampleContext::with_device(Some(Box::new(Mortal(1))));
        let by = Resampling { context: &context, filter: Filter::Cubic };
        assert_eq!(by.seen(&map, &source), [[1.0; 6]]);
        assert_eq!(context.device().as_deref(), Some("mortal"));
        for _ in 0..2 {
            assert_eq!(by.seen(&map, &source), [samples]);
        }
        assert_eq!(context.take_warnings(), ["mortal: the device was lost; the CPU resamples from here on"]);
        assert_eq!((context.device(), context.take_warnings()), (None, Vec::new()));
    }
}
