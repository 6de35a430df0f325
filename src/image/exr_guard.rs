//! What is checked before the EXR reader may take memory, and what its errors mean.
//!
//! In: a path. Out: the head of the file, or [`ImageError`].

use super::{ImageError, exr_head};
use crate::memory;
use exr::block::chunk::CompressedBlock;
use exr::meta::MetaData;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// The head of a file whose pixels may be read: what it promises fits into memory, and its DWA chunks are sane.
pub(super) fn checked_head(path: &Path) -> Result<MetaData, ImageError> {
    let head = read_head(path)?;
    head.headers.iter().try_for_each(|header| check_codec(path, header))?;
    check_size(path, &head)?;
    if head.headers.iter().any(is_dwa) {
        check_dwa(path, &head.headers)?;
    }
    Ok(head)
}

/// The head alone, unchecked.
pub(super) fn read_head(path: &Path) -> Result<MetaData, ImageError> {
    crate::files::check_regular(path).map_err(|source| ImageError::reading(path, source))?;
    MetaData::read_from_file(path, false).map_err(|failed| match unknown_codec(path) {
        Some(name) => unreadable(path, &name),
        None => read_error(path, failed),
    })
}

/// Names of compressions by their numbers in files, from 10 on (OpenEXR 3.5, ImfCompression.h): none is read.
const NEWER_CODECS: [&str; 4] = ["HTJ2K256", "HTJ2K32", "LJ2K", "ZSTD"];

/// The first compression of a head that is newer than the reader; `None`: there is none, or the head is damaged.
fn unknown_codec(path: &Path) -> Option<String> {
    let codes = exr_head::compressions(&mut BufReader::new(File::open(path).ok()?)).ok()?;
    let code = codes.into_iter().find(|code| *code >= 10)?;
    let name = NEWER_CODECS.get(usize::from(code) - 10);
    Some(name.map_or_else(|| format!("number {code}"), |name| (*name).to_owned()))
}

fn unreadable(path: &Path, codec: &str) -> ImageError {
    let what = format!("its compression ({codec}) is not supported yet; save it again with ZIP compression");
    ImageError::unsupported(path, what)
}

/// The reader knows some compressions by name only.
fn check_codec(path: &Path, header: &Header) -> Result<(), ImageError> {
    match header.compression {
        Compression::HTJ2K32 => Err(unreadable(path, "HTJ2K32")),
        Compression::HTJ2K256 => Err(unreadable(path, "HTJ2K256")),
        _ => Ok(()),
    }
}

/// One wrong byte in the head may promise a picture of petabytes: nothing is believed that such a file cannot hold, and the
/// memory is asked for before the reader takes it.
fn check_size(path: &Path, head: &MetaData) -> Result<(), ImageError> {
    let parts = head.headers.iter().map(|header| {
        let pixels = header.layer_size.width() as u128 * header.layer_size.height() as u128;
        let bytes = pixels * header.channels.bytes_per_pixel as u128;
        (bytes, pixels * header.channels.list.len() as u128, best_ratio(header.compression))
    });
    let (bytes, samples, ratio) =
        parts.fold((0, 0, 1), |(bytes, samples, ratio), part| (bytes + part.0, samples + part.1, ratio.max(part.2)));
    check_promise(path, bytes, ratio)?;
    // As they are stored, and as floats.
    check_memory(path, bytes + 4 * samples)
}

/// Bytes of pixels that a byte of a chunk becomes at the very best.
fn best_ratio(compression: Compression) -> u128 {
    match compression {
        // Subsampled channels, refused later, are counted four times.
        Compression::Uncompressed => 4,
        // 128 equal bytes in two.
        Compression::RLE => 64,
        // 4 x 4 equal halves in three bytes.
        Compression::B44 | Compression::B44A => 11,
        // Deflate: 1032, as M. Adler, "zlib technical details", says. PIZ: 255 equal halves in ten bits.
        Compression::ZIP1 | Compression::ZIP16 | Compression::PXR24 | Compression::PIZ => 1100,
        // Runs of 64 zeros in two bytes, and those deflated.
        _ => 70_000,
    }
}

/// What files may promise whatever their length: heads count too.
const SMALL: u128 = 1 << 24;

/// Whether a file of that length can hold so many bytes of pixels, where a byte becomes `ratio` at the very best.
pub(super) fn check_promise(path: &Path, bytes: u128, ratio: u128) -> Result<(), ImageError> {
    let length = std::fs::metadata(path).map_err(|source| ImageError::reading(path, source))?.len();
    if bytes <= SMALL + ratio * u128::from(length) {
        return Ok(());
    }
    let what = format!("its head promises {} MB of pixels, more than {length} bytes can hold", bytes / 1_000_000);
    Err(ImageError::damaged(path, what))
}

/// Whether a picture may take so many bytes while it is decoded.
pub(super) fn check_memory(path: &Path, bytes: u128) -> Result<(), ImageError> {
    memory::check(bytes).map_err(|source| ImageError::TooLarge { path: path.to_owned(), source })
}

/// A DWA chunk begins with nine sizes that the reader believes as they stand. Goes through the chunks without decoding.
fn check_dwa(path: &Path, headers: &[Header]) -> Result<(), ImageError> {
    let damaged = |failed| read_error(path, failed);
    let file = File::open(path).map_err(|source| ImageError::reading(path, source))?;
    let reader = exr::block::read(BufReader::new(file), false).map_err(damaged)?;
    for chunk in reader.all_chunks(false).map_err(damaged)? {
        let chunk = chunk.map_err(damaged)?;
        let is_stored_raw = |header: &Header| raw_bytes(header, &chunk.compressed_block);
        let bytes = match &chunk.compressed_block {
            CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
            CompressedBlock::Tile(block) => &block.compressed_pixels_le,
            _ => continue,
        };
        let is_sane = |header: &Header| {
            // What does not become smaller is stored as it is.
            is_stored_raw(header) == Some(bytes.len()) || are_dwa_sizes_sane(header, bytes)
        };
        if headers.get(chunk.layer_index).is_some_and(|header| is_dwa(header) && !is_sane(header)) {
            return Err(ImageError::damaged(path, "a DWA chunk promises more than its block can hold"));
        }
    }
    Ok(())
}

/// Bytes of a block that is not compressed.
fn raw_bytes(header: &Header, block: &CompressedBlock) -> Option<usize> {
    let place = header.get_block_data_indices(block).ok()?;
    let pixels = header.get_absolute_block_pixel_coordinates(place).ok()?.size;
    pixels.width().checked_mul(pixels.height())?.checked_mul(header.channels.bytes_per_pixel)
}

fn is_dwa(header: &Header) -> bool {
    matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_))
}

/// The sizes follow the version, eight bytes each (OpenEXR, DataSizesSingle). Blocks of 8x8 make a thin picture 64 times
/// larger at worst.
fn are_dwa_sizes_sane(header: &Header, chunk: &[u8]) -> bool {
    let limit = 64 * header.max_block_byte_size() as u64 + (1 << 16);
    let sizes = chunk.chunks_exact(8).skip(1).take(9).filter_map(|bytes| bytes.first_chunk::<8>());
    sizes.copied().all(|bytes| u64::from_le_bytes(bytes) <= limit)
}

pub(super) fn read_error(path: &Path, failed: exr::error::Error) -> ImageError {
    match failed {
        exr::error::Error::Io(source) => ImageError::reading(path, source),
        exr::error::Error::NotSupported(what) => {
            ImageError::unsupported(path, format!("{what}; export a flat scan-line EXR"))
        }
        other => ImageError::damaged(path, other.to_string()),
    }
}
