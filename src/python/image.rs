//! Conversion of pictures between NumPy and plates.
//!
//! In: an array (H, W) or (H, W, C) of float32, float16 or uint8, or a dict of channels (H, W). Out: a [`Plate`] of
//! planes, as the kernels require: samples are copied once. A warped plate is converted back to the form of the input:
//! channels of float32 in a dict are moved, everything else is copied once more.

use super::arrays::described;
use super::failure::Failure;
use crate::image::{Channel, Frame, Plate, Storage, bytes_of_plate, plate_of_bytes};
use crate::space::PixelRect;
use half::f16;
use numpy::ndarray::{ArrayViewD, Axis};
use numpy::{Element, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

/// The form of the input picture, restored after the warp.
pub(super) enum Form {
    /// An array of this sample type, (H, W) or (H, W, C).
    Array { depth: Depth, shape: Vec<usize> },
    /// A dict of channels, each with its sample type.
    Channels(Vec<Depth>),
}

/// The sample type of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    Byte,
    Half,
    Float,
    Id,
}

/// A sample type for light or data, not for ids.
trait Sample: Element + Copy + Send + Sync {
    fn light(self) -> f32;
    fn of_light(light: f32) -> Self;
}

impl Sample for f32 {
    fn light(self) -> f32 {
        self
    }

    fn of_light(light: f32) -> Self {
        light
    }
}

impl Sample for f16 {
    fn light(self) -> f32 {
        self.to_f32()
    }

    fn of_light(light: f32) -> Self {
        Self::from_f32(light)
    }
}

const TYPES: &str = "use image.astype(numpy.float32), or float16, or uint8";

/// Converts a picture to a plate. `names`: channel names; `None`: Y, YA, RGB, RGBA, further ones numbered.
pub(super) fn plate_of(image: &Bound<'_, PyAny>, names: Option<Vec<String>>) -> Result<(Plate, Form), Failure> {
    if let Ok(channels) = image.cast::<PyDict>() {
        return plate_of_channels(channels);
    }
    let py = image.py();
    if let Ok(array) = image.cast::<PyArrayDyn<u8>>() {
        return of_bytes(py, &array.readonly());
    }
    let form = |depth, shape: &[usize]| Form::Array { depth, shape: shape.to_vec() };
    match (image.cast::<PyArrayDyn<f32>>(), image.cast::<PyArrayDyn<f16>>()) {
        (Ok(array), _) => Ok((of_samples(py, &array.readonly(), names)?, form(Depth::Float, array.shape()))),
        (_, Ok(array)) => Ok((of_samples(py, &array.readonly(), names)?, form(Depth::Half, array.shape()))),
        _ => Err(Failure::argument("image", format!("is {}", described(image)), TYPES)),
    }
}

/// Returns width and height, and the number of channels, of an array.
fn extent(shape: &[usize]) -> Result<([u32; 2], usize), Failure> {
    let (rows, columns, channels) = match *shape {
        [rows, columns] => (rows, columns, 1),
        [rows, columns, channels] => (rows, columns, channels),
        _ => (0, 0, 0),
    };
    let side = |pixels: usize| u32::try_from(pixels).ok().filter(|&pixels| pixels > 0 && pixels <= 1 << 16);
    match (side(columns), side(rows)) {
        (Some(width), Some(height)) if channels > 0 => Ok(([width, height], channels)),
        _ => {
            let hint =
                "give an array of the shape (height, width) or (height, width, channels), sides of 1 to 65536 pixels";
            Err(Failure::argument("image", format!("has the shape {shape:?}"), hint))
        }
    }
}

fn of_bytes(py: Python<'_>, array: &PyReadonlyArrayDyn<'_, u8>) -> Result<(Plate, Form), Failure> {
    let (size, channels) = extent(array.shape())?;
    let form = Form::Array { depth: Depth::Byte, shape: array.shape().to_vec() };
    let view = array.as_array();
    let plate = py.detach(|| plate_of_bytes(size, channels, view.iter().copied().collect()));
    let plate = plate.ok_or_else(|| {
        let what = format!("has {channels} channels of uint8");
        Failure::argument("image", what, "pictures of bytes have 1 to 4; give more as float32")
    })?;
    Ok((plate, form))
}

fn of_samples<T: Sample>(
    py: Python<'_>,
    array: &PyReadonlyArrayDyn<'_, T>,
    names: Option<Vec<String>>,
) -> Result<Plate, Failure> {
    let (size, count) = extent(array.shape())?;
    let names = names.unwrap_or_else(|| usual_names(count));
    if names.len() != count {
        let what = format!("has {} names for {count} channels", names.len());
        return Err(Failure::argument("names", what, "name every channel"));
    }
    let view = array.as_array();
    let view = if view.ndim() == 2 { view.insert_axis(Axis(2)) } else { view };
    let channel = |(index, name): (usize, String)| Channel {
        name,
        storage: Storage::Float,
        samples: view.index_axis(Axis(2), index).iter().map(|sample| sample.light()).collect(),
    };
    let channels = py.detach(|| names.into_par_iter().enumerate().map(channel).collect());
    Ok(plate_over(size, channels))
}

/// Returns the default channel names.
fn usual_names(count: usize) -> Vec<String> {
    let names: &[&str] = match count {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        4 => &["R", "G", "B", "A"],
        _ => return (0..count).map(|index| format!("channel{index}")).collect(),
    };
    names.iter().map(|&name| name.to_owned()).collect()
}

fn plate_over([width, height]: [u32; 2], channels: Vec<Channel>) -> Plate {
    let window = PixelRect { x: 0, y: 0, width, height };
    Plate::from_frame(Frame { display: window, data_window: window, pixel_aspect: 1.0, channels })
}

fn plate_of_channels(channels: &Bound<'_, PyDict>) -> Result<(Plate, Form), Failure> {
    let mut found: Option<([u32; 2], String)> = None;
    let (mut planes, mut depths) = (Vec::new(), Vec::new());
    for (name, values) in channels {
        let name: String = name.extract().map_err(|_| {
            Failure::argument("image", "has a channel whose name is not a string", "name channels as EXR files do")
        })?;
        let key = format!("image[{name:?}]");
        let (size, samples, depth) = plane(&values, &key)?;
        match &found {
            Some((other, first)) if *other != size => {
                let what = format!("has {size:?} pixels, {first:?} has {other:?}");
                return Err(Failure::argument(key, what, "give all channels the same shape"));
            }
            _ => _ = found.get_or_insert_with(|| (size, name.clone())),
        }
        let storage = if depth == Depth::Id { Storage::Uint } else { Storage::Float };
        planes.push(Channel { name, storage, samples });
        depths.push(depth);
    }
    let (size, _) = found.ok_or_else(|| Failure::argument("image", "is empty", "give at least one channel"))?;
    Ok((plate_over(size, planes), Form::Channels(depths)))
}

/// Returns size, samples and type of a channel; ids are stored by their bits.
fn plane(values: &Bound<'_, PyAny>, key: &str) -> Result<([u32; 2], Vec<f32>, Depth), Failure> {
    fn all<T: Element + Copy>(view: &ArrayViewD<'_, T>, light: impl Fn(T) -> f32) -> Vec<f32> {
        view.iter().map(|sample| light(*sample)).collect()
    }
    let (shape, samples, depth) = if let Ok(array) = values.cast::<PyArrayDyn<f32>>() {
        (array.shape().to_vec(), all(&array.readonly().as_array(), |sample| sample), Depth::Float)
    } else if let Ok(array) = values.cast::<PyArrayDyn<f16>>() {
        (array.shape().to_vec(), all(&array.readonly().as_array(), f16::to_f32), Depth::Half)
    } else if let Ok(array) = values.cast::<PyArrayDyn<u32>>() {
        (array.shape().to_vec(), all(&array.readonly().as_array(), f32::from_bits), Depth::Id)
    } else {
        let hint = "give channels of float32 or float16, ids of uint32";
        return Err(Failure::argument(key, format!("is {}", described(values)), hint));
    };
    match shape.as_slice() {
        [_, _] => Ok((extent(&shape)?.0, samples, depth)),
        _ => Err(Failure::argument(key, format!("has the shape {shape:?}"), "give (height, width)")),
    }
}

/// Converts a plate to the given form.
pub(super) fn image_of<'py>(py: Python<'py>, plate: Plate, form: &Form) -> PyResult<Bound<'py, PyAny>> {
    match form {
        Form::Channels(depths) => channels_of(py, plate, depths),
        Form::Array { depth: Depth::Half, shape } => interleaved::<f16>(py, plate.into_frame().channels, shape),
        Form::Array { depth: Depth::Byte, shape } => {
            let count = shape.get(2).copied().unwrap_or(1);
            let bytes = py.detach(|| bytes_of_plate(&plate, count)).unwrap_or_default();
            Ok(PyArray1::from_vec(py, bytes).reshape(shape.as_slice())?.into_any())
        }
        Form::Array { shape, .. } => interleaved::<f32>(py, plate.into_frame().channels, shape),
    }
}

fn interleaved<'py, T: Sample>(
    py: Python<'py>,
    channels: Vec<Channel>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let count = channels.len();
    let samples = py.detach(|| {
        let mut samples = vec![T::of_light(0.0); channels.first().map_or(0, |channel| channel.samples.len()) * count];
        samples.par_chunks_exact_mut(count.max(1)).with_min_len(1 << 14).enumerate().for_each(|(pixel, to)| {
            to.iter_mut().zip(&channels).for_each(|(to, from)| *to = T::of_light(from.samples[pixel]));
        });
        samples
    });
    Ok(PyArray1::from_vec(py, samples).reshape(shape)?.into_any())
}

/// Converts channels to a dict.
fn channels_of<'py>(py: Python<'py>, plate: Plate, depths: &[Depth]) -> PyResult<Bound<'py, PyAny>> {
    let shape = [plate.display.height as usize, plate.display.width as usize];
    let dict = PyDict::new(py);
    for (channel, depth) in plate.into_frame().channels.into_iter().zip(depths) {
        let name = channel.name.clone();
        let array = match depth {
            Depth::Half => {
                let samples = channel.samples.iter().map(|sample| f16::from_f32(*sample)).collect();
                PyArray1::<f16>::from_vec(py, samples).reshape(shape)?.into_any()
            }
            _ => channel_array(py, channel, shape)?,
        };
        dict.set_item(name, array)?;
    }
    Ok(dict.into_any())
}

/// Converts a channel to an array (H, W): float32, which is moved, or uint32 for ids.
pub(super) fn channel_array(py: Python<'_>, channel: Channel, shape: [usize; 2]) -> PyResult<Bound<'_, PyAny>> {
    if channel.storage == Storage::Uint {
        let ids = channel.samples.iter().map(|id| id.to_bits()).collect();
        return Ok(PyArray1::from_vec(py, ids).reshape(shape)?.into_any());
    }
    Ok(PyArray1::from_vec(py, channel.samples).reshape(shape)?.into_any())
}
