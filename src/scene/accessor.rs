//! Reads accessors as plain numbers.
//!
//! In: an accessor's index. Out: its elements, dense, as f32 or u32, with sparse values applied. Ranges are checked
//! against the buffers before the first byte is read, so nothing here can panic, or allocate more than the file
//! justifies.

use super::SceneError;
use super::file::{File, ViewBytes, slice};
use crate::spelling::pluralised;
use gltf::json::accessor::{ComponentType, Type, sparse};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index};
use std::fmt::Arguments;

/// Maximum number of elements of an accessor without data: zeros take no space in the file, but memory here.
pub(super) const MAX_ZEROS: u64 = 1 << 22;

/// How integers are converted to floats.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Integers {
    /// As given by the accessor's `normalized`.
    AsFlagged,
    /// Always to 0..1 or -1..1, for attributes that the format requires to be normalised.
    Normalized,
}

/// The elements of an accessor as floats.
pub(super) struct Floats {
    /// Components per element.
    pub(super) width: usize,
    /// `width` values per element.
    pub(super) values: Vec<f32>,
}

impl Floats {
    /// Converts the elements to vectors (or other plain types) of `N` = `width` components.
    pub(super) fn map<const N: usize, T>(&self, convert: impl Fn([f32; N]) -> T) -> Vec<T> {
        assert_eq!(self.width, N, "the accessor's type was checked when it was read");
        let (arrays, _) = self.values.as_chunks::<N>();
        arrays.iter().map(|array| convert(*array)).collect()
    }
}

/// An accessor with all ranges checked.
struct Source<'a> {
    elements: Elements<'a>,
    /// Number of elements.
    count: usize,
    component: ComponentType,
    /// Components per element.
    width: usize,
    is_normalized: bool,
    sparse: Option<Sparse<'a>>,
}

/// The storage of elements.
enum Elements<'a> {
    /// Elements `stride` bytes apart; the last one is complete.
    Stored { bytes: &'a [u8], stride: usize },
    /// All zeros.
    Zeros,
}

/// Sparse replacements: `indices.len()` elements, tightly packed in `values`.
struct Sparse<'a> {
    indices: Vec<usize>,
    values: &'a [u8],
}

impl File {
    /// Reads an accessor of one of `types` as floats; `what` names its role in errors.
    pub(super) fn floats(
        &self,
        index: Index<Accessor>,
        types: &[Type],
        integers: Integers,
        what: Arguments<'_>,
    ) -> Result<Floats, SceneError> {
        let source = self.source(index, types, what)?;
        let is_normalized = integers == Integers::Normalized || source.is_normalized;
        let values = match (source.component, is_normalized) {
            (ComponentType::F32, _) => source.decode(f32::from_le_bytes),
            (ComponentType::I8, true) => source.decode(|[b]: [u8; 1]| (f32::from(b as i8) / 127.0).max(-1.0)),
            (ComponentType::I8, false) => source.decode(|[b]: [u8; 1]| f32::from(b as i8)),
            (ComponentType::U8, true) => source.decode(|[b]: [u8; 1]| f32::from(b) / 255.0),
            (ComponentType::U8, false) => source.decode(|[b]: [u8; 1]| f32::from(b)),
            (ComponentType::I16, true) => source.decode(|b| (f32::from(i16::from_le_bytes(b)) / 32767.0).max(-1.0)),
            (ComponentType::I16, false) => source.decode(|b| f32::from(i16::from_le_bytes(b))),
            (ComponentType::U16, true) => source.decode(|b| f32::from(u16::from_le_bytes(b)) / 65535.0),
            (ComponentType::U16, false) => source.decode(|b| f32::from(u16::from_le_bytes(b))),
            (ComponentType::U32, true) => {
                source.decode(|b| (f64::from(u32::from_le_bytes(b)) / 4_294_967_295.0) as f32)
            }
            (ComponentType::U32, false) => source.decode(|b| u32::from_le_bytes(b) as f32),
        };
        Ok(Floats { width: source.width, values })
    }

    /// Reads an accessor of unsigned integers, as a flat list of components.
    pub(super) fn integers(
        &self,
        index: Index<Accessor>,
        kind: Type,
        what: Arguments<'_>,
    ) -> Result<Vec<u32>, SceneError> {
        let source = self.source(index, &[kind], what)?;
        match source.component {
            ComponentType::U8 => Ok(source.decode(|[b]: [u8; 1]| u32::from(b))),
            ComponentType::U16 => Ok(source.decode(|b| u32::from(u16::from_le_bytes(b)))),
            ComponentType::U32 => Ok(source.decode(u32::from_le_bytes)),
            other => {
                Err(self.invalid(format!("{what}: its accessor holds {other:?} where unsigned integers are expected")))
            }
        }
    }

    /// Returns the number of elements that an accessor declares.
    pub(super) fn count(&self, index: Index<Accessor>, what: Arguments<'_>) -> Result<usize, SceneError> {
        let count = self.accessor(index, what)?.count.0;
        usize::try_from(count).map_err(|_| self.invalid(format!("{what}: {count} elements are too many")))
    }

    /// Returns whether the accessor stores no data, so that every element is zero.
    pub(super) fn is_all_zero(&self, index: Index<Accessor>) -> bool {
        self.root.get(index).is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
    }

    fn accessor(&self, index: Index<Accessor>, what: Arguments<'_>) -> Result<&Accessor, SceneError> {
        let missing = || self.invalid(format!("{what}: accessors[{}] does not exist", index.value()));
        self.root.get(index).ok_or_else(missing)
    }

    fn source(&self, index: Index<Accessor>, types: &[Type], what: Arguments<'_>) -> Result<Source<'_>, SceneError> {
        let number = index.value();
        let fault = |text: &str| self.invalid(format!("{what}: accessors[{number}] {text}"));
        let accessor = self.accessor(index, what)?;
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
            return Err(fault("has an unknown type or componentType"));
        };
        if !types.contains(&kind) {
            return Err(fault(&format!("is a {kind:?} where {types:?} is expected")));
        }
        let (component, width) = (component.0, kind.multiplicity());
        let count = usize::try_from(accessor.count.0).map_err(|_| fault("announces too many elements"))?;
        let elements = match accessor.buffer_view {
            Some(view) => {
                let view = self.view(view)?;
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                stored(&view, offset, count, width * component.size()).map_err(|text| fault(&text))?
            }
            None if accessor.count.0 > MAX_ZEROS => return Err(fault("asks for more zeros than are allowed")),
            None => Elements::Zeros,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(self.sparse(sparse, count, width * component.size(), what)?),
            None => None,
        };
        Ok(Source { elements, count, component, width, is_normalized: accessor.normalized, sparse })
    }

    /// Checks the sparse part of an accessor of `count` elements of `size` bytes.
    fn sparse(
        &self,
        sparse: &sparse::Sparse,
        count: usize,
        size: usize,
        what: Arguments<'_>,
    ) -> Result<Sparse<'_>, SceneError> {
        let fault = |text: &str| self.invalid(format!("{what}: the sparse part of its accessor {text}"));
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(fault("has an unknown componentType"));
        };
        let kind = kind.0;
        let index_bytes = self.view(sparse.indices.buffer_view)?.bytes;
        let value_bytes = self.view(sparse.values.buffer_view)?.bytes;
        let range = |bytes, offset: u64, size: usize| slice(bytes, offset, sparse.count.0.checked_mul(size as u64)?);
        let stored = range(index_bytes, sparse.indices.byte_offset.0, kind.size());
        let values = range(value_bytes, sparse.values.byte_offset.0, size);
        let (Some(stored), Some(values)) = (stored, values) else {
            return Err(fault("reaches past the end of its buffer view"));
        };
        let indices: Vec<usize> = stored.chunks_exact(kind.size()).map(little_endian).collect();
        match indices.iter().find(|&&index| index >= count) {
            Some(index) => Err(fault(&format!("replaces element {index} of {count}"))),
            None => Ok(Sparse { indices, values }),
        }
    }
}

impl Source<'_> {
    /// Decodes all components in order, each with `read` from its `N` bytes.
    fn decode<const N: usize, T: Copy + Default>(&self, read: impl Fn([u8; N]) -> T) -> Vec<T> {
        let size = self.width * N;
        let mut out = Vec::with_capacity(self.count * self.width);
        match self.elements {
            Elements::Zeros => out.resize(self.count * self.width, T::default()),
            Elements::Stored { bytes, stride } if stride == size => {
                out.extend(bytes.as_chunks().0.iter().map(|raw| read(*raw)));
            }
            Elements::Stored { bytes, stride } => {
                for element in bytes.chunks(stride) {
                    out.extend(element[..size].as_chunks().0.iter().map(|raw| read(*raw)));
                }
            }
        }
        let Some(sparse) = &self.sparse else { return out };
        for (&index, element) in sparse.indices.iter().zip(sparse.values.chunks_exact(size)) {
            let place = &mut out[index * self.width..(index + 1) * self.width];
            for (value, raw) in place.iter_mut().zip(element.as_chunks().0) {
                *value = read(*raw);
            }
        }
        out
    }
}

/// Returns the bytes of `count` elements of `size` bytes in `view`, up to the end of the last one.
fn stored<'a>(view: &ViewBytes<'a>, offset: u64, count: usize, size: usize) -> Result<Elements<'a>, String> {
    let stride = if view.stride == 0 { size } else { view.stride };
    if stride < size {
        return Err(format!("has elements of {size} bytes in a buffer view of stride {stride}"));
    }
    let length = match count.checked_sub(1) {
        None => Some(0),
        Some(gaps) => (gaps as u64).checked_mul(stride as u64).and_then(|bytes| bytes.checked_add(size as u64)),
    };
    let bytes = length.and_then(|length| slice(view.bytes, offset, length));
    let reach = || pluralised(count, "element", "elements");
    let bytes = bytes.ok_or_else(|| format!("reaches past the end of its buffer view ({})", reach()))?;
    Ok(Elements::Stored { bytes, stride })
}

fn little_endian(bytes: &[u8]) -> usize {
    bytes.iter().rev().fold(0, |value, byte| value << 8 | usize::from(*byte))
}
