//! Reads textures and their images.
//!
//! In: which texture is used as colour or as data. Out: decoded RGBA8 images. An image that is missing or cannot be
//! decoded gives a warning, and the textures that use it are dropped.

use super::file::File;
use super::{Filter, Image, SceneError, Texture, Wrap, budget};
use gltf::json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use image::{ImageFormat, ImageReader};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

/// A use of one of the file's textures by a material.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    /// Index in the file.
    pub(super) texture: usize,
    /// Whether it is used as colour, not as data.
    pub(super) is_srgb: bool,
}

/// The scene's textures.
#[derive(Default)]
pub(super) struct Textures {
    pub(super) textures: Vec<Texture>,
    pub(super) images: Vec<Image>,
    /// Scene index of each use, without those of dropped textures.
    pub(super) scene_from_use: BTreeMap<Use, usize>,
}

/// Loads all textures in `uses`.
pub(super) fn load(file: &File, uses: &BTreeSet<Use>, warnings: &mut Vec<String>) -> Result<Textures, SceneError> {
    let mut sources = BTreeMap::new();
    for one in uses {
        sources.insert(one.texture, source(file, one.texture, warnings)?);
    }
    let numbers: BTreeSet<usize> = sources.values().copied().flatten().collect();
    let encoded: Vec<(usize, Result<Encoded, String>)> =
        numbers.into_iter().map(|number| (number, read(file, number))).collect();
    let pixels = encoded.iter().filter_map(|(_, encoded)| Some(encoded.as_ref().ok()?.pixels)).sum();
    budget::check(file, &[], pixels)?;
    let decoded: Vec<(usize, Result<Image, String>)> =
        encoded.into_par_iter().map(|(number, encoded)| (number, encoded.and_then(decode))).collect();
    let mut images = BTreeMap::new();
    for (number, result) in decoded {
        match result {
            Ok(image) => drop(images.insert(number, image)),
            Err(why) => warnings.push(format!("images[{number}] is left out of the textures: {why}")),
        }
    }
    collect(file, uses, &sources, &images)
}

/// Renumbers textures and images; an image used both as colour and as data is duplicated.
fn collect(
    file: &File,
    uses: &BTreeSet<Use>,
    sources: &BTreeMap<usize, Option<usize>>,
    decoded: &BTreeMap<usize, Image>,
) -> Result<Textures, SceneError> {
    let mut out = Textures::default();
    let mut image_places = BTreeMap::new();
    for &one in uses {
        let Some(number) = sources.get(&one.texture).copied().flatten() else { continue };
        let Some(pixels) = decoded.get(&number) else { continue };
        let image = *image_places.entry((number, one.is_srgb)).or_insert_with(|| {
            out.images.push(Image { is_srgb: one.is_srgb, ..pixels.clone() });
            out.images.len() - 1
        });
        let sampler = match file.root.textures[one.texture].sampler {
            None => Sampler::default(),
            Some(index) => {
                let missing = || file.invalid(format!("textures[{}] names a sampler that does not exist", one.texture));
                file.root.get(index).ok_or_else(missing)?.clone()
            }
        };
        out.scene_from_use.insert(one, out.textures.len());
        out.textures.push(texture(image, &sampler));
    }
    Ok(out)
}

/// Returns the image of a texture; `None` if only an unsupported extension gives one.
fn source(file: &File, texture: usize, warnings: &mut Vec<String>) -> Result<Option<usize>, SceneError> {
    // The crate's placeholder for a texture without a source.
    const ABSENT: usize = u32::MAX as usize;
    let number = file.root.textures[texture].source.value();
    if number == ABSENT {
        warnings.push(format!("textures[{texture}] has no PNG or JPEG image and is left out"));
        return Ok(None);
    }
    if number >= file.root.images.len() {
        return Err(file.invalid(format!("textures[{texture}] names images[{number}], which does not exist")));
    }
    Ok(Some(number))
}

fn texture(image: usize, sampler: &Sampler) -> Texture {
    let (minify, mipmap) = match sampler.min_filter {
        Some(Checked::Valid(MinFilter::Nearest)) => (Filter::Nearest, None),
        Some(Checked::Valid(MinFilter::Linear)) => (Filter::Linear, None),
        Some(Checked::Valid(MinFilter::NearestMipmapNearest)) => (Filter::Nearest, Some(Filter::Nearest)),
        Some(Checked::Valid(MinFilter::LinearMipmapNearest)) => (Filter::Linear, Some(Filter::Nearest)),
        Some(Checked::Valid(MinFilter::NearestMipmapLinear)) => (Filter::Nearest, Some(Filter::Linear)),
        _ => (Filter::Linear, Some(Filter::Linear)),
    };
    let magnify = match sampler.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        _ => Filter::Linear,
    };
    Texture { image, wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)], magnify, minify, mipmap }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

/// An encoded image.
struct Encoded<'a> {
    bytes: Cow<'a, [u8]>,
    pixels: u128,
}

/// Reads an image of the file, and its size from its header.
fn read(file: &File, number: usize) -> Result<Encoded<'_>, String> {
    let image = &file.root.images[number];
    let bytes = match (image.buffer_view, &image.uri) {
        (Some(view), _) => Cow::Borrowed(file.view(view).map_err(|error| error.to_string())?.bytes),
        (None, Some(uri)) => Cow::Owned(file.read_uri(uri).map_err(|error| error.to_string())?),
        (None, None) => return Err("it has neither data nor a uri".to_owned()),
    };
    let (width, height) = reader(&bytes)?.into_dimensions().map_err(undecodable)?;
    Ok(Encoded { bytes, pixels: u128::from(width) * u128::from(height) })
}

/// Decodes an image; 16-bit and grey ones are converted to RGBA8.
fn decode(encoded: Encoded) -> Result<Image, String> {
    let pixels = reader(&encoded.bytes)?.decode().map_err(undecodable)?.into_rgba8();
    Ok(Image { width: pixels.width(), height: pixels.height(), rgba: pixels.into_raw(), is_srgb: false })
}

fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("it is neither PNG nor JPEG; export it as PNG or JPEG".to_owned());
    }
    // The memory budget limits the size instead.
    reader.no_limits();
    Ok(reader)
}

fn undecodable(error: impl std::fmt::Display) -> String {
    format!("it does not decode: {error}")
}
