//! Conversion of the host's images, of any bit depth, components and row order, to and from planes of floats.
//!
//! In: a clip and a time. Out: an [`Image`], released to the host when dropped. The rows of planes run from top to
//! bottom; those of OpenFX images from bottom to top, or the reverse if the host's row bytes are negative.

use super::effect::Clip;
use super::error::HostError;
use super::props::Props;
use super::suites::Suites;
use crate::ofx::api::PropertySet;
use crate::ofx::api::names::image;
use half::f16;
use rayon::prelude::*;
use std::ffi::CStr;

/// The storage format of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ofx) enum Depth {
    Byte,
    Short,
    Half,
    Float,
}

impl Depth {
    const fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Short | Self::Half => 2,
            Self::Float => 4,
        }
    }
}

/// The rows of a window to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ofx) enum Rows {
    /// All rows.
    All,
    /// Rows 0, 2, 4: the lower field.
    Even,
    /// Rows 1, 3, 5: the upper field.
    Odd,
}

/// An image of the host, released when dropped.
pub(in crate::ofx) struct Image<'a> {
    suites: &'a Suites,
    set: PropertySet,
    memory: Memory,
    /// Its pixels: left column, bottom row, and one past the right column and top row.
    pub(in crate::ofx) bounds: [i32; 4],
    pub(in crate::ofx) depth: Depth,
    /// Components per pixel. 4: RGBA, 3: RGB, 1: alpha.
    pub(in crate::ofx) channels: usize,
    /// Pixels per pixel of the full size, as stated by the image itself; `None` if it does not state it.
    pub(in crate::ofx) scale: Option<[f64; 2]>,
    /// Whether colour is straight, not premultiplied.
    pub(in crate::ofx) is_straight: bool,
}

/// The memory layout of the rows.
struct Memory {
    data: *mut u8,
    row_bytes: isize,
    /// The bottom row, and one past the top row.
    rows: [i32; 2],
}

/// Where pixels of an image are written. Threads may write windows that do not overlap concurrently.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct Target<'a> {
    memory: &'a Memory,
    bounds: [i32; 4],
    depth: Depth,
    channels: usize,
    rows: Rows,
}

// SAFETY: the host leaves the image's memory to this render until the image is released.
unsafe impl Send for Memory {}
// SAFETY: as above; each row is written by one thread only.
unsafe impl Sync for Memory {}

impl Memory {
    /// Returns the address of a row.
    fn start(&self, y: i32) -> *mut u8 {
        assert!((self.rows[0]..self.rows[1]).contains(&y), "rows outside the image are not asked for");
        let offset = (y - self.rows[0]) as isize * self.row_bytes;
        // SAFETY: the host's rows are that many bytes apart.
        unsafe { self.data.offset(offset) }
    }
}

impl Drop for Image<'_> {
    fn drop(&mut self) {
        if let Some(release) = self.suites.effect.clip_release_image {
            // SAFETY: the host's function with the image that it provided, called once.
            let _gone_anyway = unsafe { release(self.set) };
        }
    }
}

impl<'a> Clip<'a> {
    /// Returns the clip's image at a time; `None` if it has none.
    pub(in crate::ofx) fn image(self, time: f64) -> Result<Option<Image<'a>>, HostError> {
        let mut set = PropertySet::NULL;
        let Some(get) = self.suites.effect.clip_get_image else { return Ok(None) };
        // SAFETY: the host's function with its own handle; the region may be null, the out pointer outlives the call.
        let status = unsafe { get(self.handle, time, std::ptr::null(), &raw mut set) };
        if !status.is_ok() || set.is_null() {
            return Ok(None);
        }
        Image::new(self, set).map(Some)
    }
}

impl<'a> Image<'a> {
    fn new(clip: Clip<'a>, set: PropertySet) -> Result<Self, HostError> {
        let props = Props::new(clip.suites.property, set);
        let told = |name| props.text(name).or_else(|| clip.props().text(name)).unwrap_or_default();
        let depth = told(image::PIXEL_DEPTH);
        let components = told(image::COMPONENTS);
        let fault = |what: String| Err(HostError::Image { clip: clip.name.to_string_lossy().into_owned(), what });
        let [x1, y1, x2, y2] = props.ints(image::BOUNDS).unwrap_or_default();
        let made = Self {
            suites: clip.suites,
            set,
            memory: Memory {
                data: props.pointer(image::DATA).map_or(std::ptr::null_mut(), |data| data.cast()),
                row_bytes: props.int(image::ROW_BYTES).unwrap_or(0) as isize,
                rows: [y1, y2],
            },
            bounds: [x1, y1, x2, y2],
            depth: match depth.as_bytes() {
                name if name == image::DEPTH_BYTE.to_bytes() => Depth::Byte,
                name if name == image::DEPTH_SHORT.to_bytes() => Depth::Short,
                name if name == image::DEPTH_HALF.to_bytes() => Depth::Half,
                _ => Depth::Float,
            },
            channels: match components.as_bytes() {
                name if name == image::COMPONENT_RGB.to_bytes() => 3,
                name if name == image::COMPONENT_ALPHA.to_bytes() => 1,
                _ => 4,
            },
            scale: props.doubles(image::RENDER_SCALE).filter(|scale: &[f64; 2]| scale.iter().all(|side| *side > 0.0)),
            // pyofx spells it "OfxImageUnPreMultiplied".
            is_straight: told(image::PREMULTIPLICATION).to_ascii_lowercase().ends_with("unpremultiplied"),
        };
        let is_known = |told: &str, names: &[&CStr]| {
            told.is_empty() || names.iter().any(|name| name.to_bytes() == told.as_bytes())
        };
        if !is_known(&depth, &[image::DEPTH_BYTE, image::DEPTH_SHORT, image::DEPTH_HALF, image::DEPTH_FLOAT]) {
            return fault(format!("pixels of {depth}; pinwarp takes bytes, shorts, halves and floats"));
        }
        if !is_known(&components, &[image::COMPONENT_RGBA, image::COMPONENT_RGB, image::COMPONENT_ALPHA]) {
            return fault(format!("channels of {components}; pinwarp takes RGBA, RGB and alpha"));
        }
        let row = made.width() * made.pixel_bytes();
        if x1 >= x2 || y1 >= y2 || made.memory.data.is_null() {
            return fault(format!("an image without pixels ({x1}, {y1} to {x2}, {y2})"));
        }
        if y2 - y1 > 1 && made.memory.row_bytes.unsigned_abs() < row {
            let found = made.memory.row_bytes;
            return fault(format!("rows of {found} bytes for {row} bytes of pixels ({depth}, {components})"));
        }
        Ok(made)
    }

    fn width(&self) -> usize {
        usize::try_from(i64::from(self.bounds[2]) - i64::from(self.bounds[0])).unwrap_or(0)
    }

    fn pixel_bytes(&self) -> usize {
        self.channels * self.depth.bytes()
    }

    /// Returns the number of pixels within the bounds.
    pub(in crate::ofx) fn area(&self) -> usize {
        self.width() * (self.bounds[3] - self.bounds[1]) as usize
    }

    /// Reads all pixels of the bounds into planes of [`Self::area`] samples, one per channel: rows from the top, alpha
    /// last.
    pub(in crate::ofx) fn read(&self, planes: &mut [Vec<f32>]) {
        assert!(planes.len() == self.channels && planes.iter().all(|plane| plane.len() == self.area()));
        let (width, length) = (self.width(), self.width() * self.pixel_bytes());
        let height = (self.bounds[3] - self.bounds[1]) as usize;
        let mut rows: Vec<Vec<&mut [f32]>> = (0..height).map(|_| Vec::with_capacity(self.channels)).collect();
        for plane in planes {
            rows.iter_mut().zip(plane.chunks_mut(width)).for_each(|(row, part)| row.push(part));
        }
        let (memory, depth) = (&self.memory, self.depth);
        rows.par_iter_mut().enumerate().for_each(|(index, row)| {
            let start = memory.start(memory.rows[1] - 1 - index as i32);
            // SAFETY: a row of the host's image; nobody writes to it while the image is held.
            spread(unsafe { std::slice::from_raw_parts(start, length) }, depth, row);
        });
    }

    /// Returns where its pixels are written, restricted to `rows`.
    pub(in crate::ofx) const fn target(&self, rows: Rows) -> Target<'_> {
        Target { memory: &self.memory, bounds: self.bounds, depth: self.depth, channels: self.channels, rows }
    }
}

impl Target<'_> {
    /// Writes planes of a window within the bounds, one per channel, rows from the top.
    pub(in crate::ofx) fn write(&self, window: [i32; 4], planes: &[Vec<f32>]) {
        let ([x1, y1, x2, y2], pixel_bytes) = (window, self.channels * self.depth.bytes());
        let width = (x2 - x1) as usize;
        let left = (x1 - self.bounds[0]) as usize * pixel_bytes;
        assert!(x1 >= self.bounds[0] && x2 <= self.bounds[2], "columns are within the image");
        let height = (y2 - y1) as usize;
        assert!(planes.len() == self.channels && planes.iter().all(|plane| plane.len() == width * height));
        (0..height).into_par_iter().for_each(|index| {
            let row: Vec<&[f32]> = planes.iter().map(|plane| &plane[index * width..][..width]).collect();
            let y = y2 - 1 - index as i32;
            if self.rows == Rows::Even && y.rem_euclid(2) == 1 || self.rows == Rows::Odd && y.rem_euclid(2) == 0 {
                return;
            }
            let start = self.memory.start(y).wrapping_add(left);
            // SAFETY: part of a row of the host's output; windows written concurrently do not overlap, and each row of
            // a window is written by one task.
            gather(&row, self.depth, unsafe { std::slice::from_raw_parts_mut(start, width * pixel_bytes) });
        });
    }
}

/// Deinterleaves a row into one row per plane.
fn spread(row: &[u8], depth: Depth, planes: &mut [&mut [f32]]) {
    match depth {
        Depth::Byte => spread_as(row, planes, |[byte]| f32::from(byte) / 255.0),
        Depth::Short => spread_as(row, planes, |short| f32::from(u16::from_ne_bytes(short)) / 65535.0),
        Depth::Half => spread_as(row, planes, |half| f16::from_ne_bytes(half).to_f32()),
        Depth::Float => spread_as(row, planes, f32::from_ne_bytes),
    }
}

fn spread_as<const N: usize>(row: &[u8], planes: &mut [&mut [f32]], value: impl Fn([u8; N]) -> f32) {
    match planes {
        [r, g, b, a] => unwoven([r, g, b, a], row, value),
        [r, g, b] => unwoven([r, g, b], row, value),
        planes => planes.iter_mut().for_each(|plane| unwoven([plane], row, &value)),
    }
}

/// A constant number of planes lets the compiler vectorise the shuffle.
fn unwoven<const N: usize, const C: usize>(planes: [&mut [f32]; C], row: &[u8], value: impl Fn([u8; N]) -> f32) {
    let pixels = row.as_chunks::<N>().0.as_chunks::<C>().0;
    let planes = planes.map(|plane| &mut plane[..pixels.len()]);
    for (place, pixel) in pixels.iter().enumerate() {
        (0..C).for_each(|channel| planes[channel][place] = value(pixel[channel]));
    }
}

/// Interleaves one row per plane.
fn gather(planes: &[&[f32]], depth: Depth, row: &mut [u8]) {
    // NaN becomes 0, by the definition of `as`.
    match depth {
        Depth::Byte => gather_as(planes, row, |value| [(value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8]),
        Depth::Short => gather_as(planes, row, |value| ((value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16).to_ne_bytes()),
        Depth::Half => gather_as(planes, row, |value| f16::from_f32(value).to_ne_bytes()),
        Depth::Float => gather_as(planes, row, f32::to_ne_bytes),
    }
}

fn gather_as<const N: usize>(planes: &[&[f32]], row: &mut [u8], bytes: impl Fn(f32) -> [u8; N]) {
    match planes {
        [r, g, b, a] => woven([r, g, b, a], row, bytes),
        [r, g, b] => woven([r, g, b], row, bytes),
        planes => planes.iter().for_each(|plane| woven([plane], row, &bytes)),
    }
}

fn woven<const N: usize, const C: usize>(planes: [&[f32]; C], row: &mut [u8], bytes: impl Fn(f32) -> [u8; N]) {
    let pixels = row.as_chunks_mut::<N>().0.as_chunks_mut::<C>().0;
    let planes = planes.map(|plane| &plane[..pixels.len()]);
    for (place, pixel) in pixels.iter_mut().enumerate() {
        (0..C).for_each(|channel| pixel[channel] = bytes(planes[channel][place]));
    }
}
