//! Dispatches the resampling of planes, and recycles their memory.
//!
//! In: maps, planes, a filter. Out: resampled planes, from the CPU kernels of this stage or from a device. If the
//! device fails, the kernels take over with a warning.

use super::{Filter, Planes, WarpMap, resample_into};
use crate::image::Plate;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A device that resamples planes.
pub(crate) trait Resampler: Send {
    /// Name of the device, for messages and metadata.
    fn name(&self) -> String;

    /// Resamples planes through a map with the results of [`resample_into`]. Each of `results` has `map.window.area()`
    /// samples, all of which are written.
    ///
    /// # Errors
    /// Fails if memory runs out or the device fails; the contents of `results` are then unspecified.
    fn resample(
        &mut self,
        map: &WarpMap,
        source: &Planes,
        filter: Filter,
        results: &mut [Vec<f32>],
    ) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;
}

/// State that a warper keeps from plate to plate.
#[derive(Default)]
pub(super) struct ResampleContext {
    /// `None`: the CPU kernels.
    device: Mutex<Option<Box<dyn Resampler>>>,
    /// Planes to be reused.
    buffer_pool: Mutex<Vec<Vec<f32>>>,
    warnings: Mutex<Vec<String>>,
}

/// The filter and context with which colour is resampled.
#[derive(Clone, Copy)]
pub(super) struct Resampling<'a> {
    pub(super) context: &'a ResampleContext,
    pub(super) filter: Filter,
}

impl ResampleContext {
    pub(super) fn with_device(device: Option<Box<dyn Resampler>>) -> Self {
        Self { device: Mutex::new(device), ..Self::default() }
    }

    /// Returns the name of the resampling device; `None` for the CPU.
    pub(super) fn device(&self) -> Option<String> {
        locked(&self.device).as_ref().map(|device| device.name())
    }

    /// Keeps the planes of a plate for the next one, replacing those kept before: allocating memory takes longer than
    /// writing the samples.
    pub(super) fn recycle(&self, plate: Plate) {
        let channels = plate.parts.into_iter().flat_map(|part| part.channels);
        *locked(&self.buffer_pool) = channels.map(|channel| channel.samples).collect();
    }

    /// Returns a plane of `length` samples with unspecified contents.
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

    /// Returns and clears the warnings.
    pub(super) fn take_warnings(&self) -> Vec<String> {
        std::mem::take(&mut locked(&self.warnings))
    }
}

impl Resampling<'_> {
    /// Resamples the planes through a map.
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
        // The kernels run in parallel: no thread may hold the lock meanwhile.
        drop(device);
        resample_into(map, source, self.filter, &mut results);
        results
    }
}

/// Locks a mutex, ignoring poisoning: the guarded data are never in an intermediate state.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{FrameSize, PixelRect};

    /// A device that fails after a number of calls.
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
