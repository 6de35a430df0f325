//! Checks EXR files before the reader allocates memory, and translates its errors.
//!
//! In: a path. Out: the header of the file, or [`ImageError`].

use super::{ImageError, exr_head};
use crate::memory;
use exr::block::chunk::CompressedBlock;
use exr::meta::MetaData;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Reads the header of a file and checks that its declared size fits into memory and its DWA chunks are valid.
pub(super) fn checked_head(path: &Path) -> Result<MetaData, ImageError> {
    let head = read_head(path)?;
    head.headers.iter().try_for_each(|header| check_codec(path, header))?;
    check_size(path, &head)?;
    if head.headers.iter().any(is_dwa) {
        check_dwa(path, &head.headers)?;
    }
    Ok(head)
}

/// Reads the header without these checks.
pub(super) fn read_head(path: &Path) -> Result<MetaData, ImageError> {
    crate::files::check_regular(path).map_err(|source| ImageError::reading(path, source))?;
    MetaData::read_from_file(path, false).map_err(|failed| match unknown_codec(path) {
        Some(name) => unreadable(path, &name),
        None => read_error(path, failed),
    })
}

/// Compressions from number 10 on (OpenEXR 3.5, ImfCompression.h), none of which can be read.
const NEWER_CODECS: [&str; 4] = ["HTJ2K256", "HTJ2K32", "LJ2K", "ZSTD"];

/// Returns the first compression in a header that is newer than the reader; `None` if there is none, or the header is damaged.
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

/// Rejects compressions that the reader knows only by name.
fn check_codec(path: &Path, header: &Header) -> Result<(), ImageError> {
    match header.compression {
        Compression::HTJ2K32 => Err(unreadable(path, "HTJ2K32")),
        Compression::HTJ2K256 => Err(unreadable(path, "HTJ2K256")),
        _ => Ok(()),
    }
}

/// Checks the declared size: a single wrong byte in the header may declare petabytes. Rejects sizes that the file
/// cannot possibly contain, and checks the memory before the reader allocates it.
fn check_size(path: &Path, head: &MetaData) -> Result<(), ImageError> {
    let parts = head.headers.iter().map(|header| {
        let pixels = header.layer_size.width() as u128 * header.layer_size.height() as u128;
        let bytes = pixels * header.channels.bytes_per_pixel as u128;
        (bytes, pixels * header.channels.list.len() as u128, best_ratio(header.compression))
    });
    let (bytes, samples, ratio) =
        parts.fold((0, 0, 1), |(bytes, samples, ratio), part| (bytes + part.0, samples + part.1, ratio.max(part.2)));
    check_promise(path, bytes, ratio)?;
    // Both the stored samples and their conversion to floats.
    check_memory(path, bytes + 4 * samples)
}

/// Returns the greatest possible number of pixel bytes per byte of a chunk.
fn best_ratio(compression: Compression) -> u128 {
    match compression {
        // Subsampled channels, which are rejected later, are counted four times.
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

/// Size that is accepted regardless of the file's length, which also counts the header.
const SMALL: u128 = 1 << 24;

/// Checks that a file of this length can contain so many bytes of pixels at a compression of at most `ratio`.
pub(super) fn check_promise(path: &Path, bytes: u128, ratio: u128) -> Result<(), ImageError> {
    let length = std::fs::metadata(path).map_err(|source| ImageError::reading(path, source))?.len();
    if bytes <= SMALL + ratio * u128::from(length) {
        return Ok(());
    }
    let what = format!("its header declares {} MB of pixels, more than {length} bytes can contain", bytes / 1_000_000);
    Err(ImageError::damaged(path, what))
}

/// Checks that decoding may use so many bytes.
pub(super) fn check_memory(path: &Path, bytes: u128) -> Result<(), ImageError> {
    memory::check(bytes).map_err(|source| ImageError::TooLarge { path: path.to_owned(), source })
}

/// Checks the nine sizes at the start of each DWA chunk, which the reader trusts. Reads the chunks without decoding them.
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
            // Incompressible blocks are stored raw.
            is_stored_raw(header) == Some(bytes.len()) || are_dwa_sizes_sane(header, bytes)
        };
        if headers.get(chunk.layer_index).is_some_and(|header| is_dwa(header) && !is_sane(header)) {
            return Err(ImageError::damaged(path, "a DWA chunk declares more data than its block can hold"));
        }
    }
    Ok(())
}

/// Returns the size of an uncompressed block, in bytes.
fn raw_bytes(header: &Header, block: &CompressedBlock) -> Option<usize> {
    let place = header.get_block_data_indices(block).ok()?;
    let pixels = header.get_absolute_block_pixel_coordinates(place).ok()?.size;
    pixels.width().checked_mul(pixels.height())?.checked_mul(header.channels.bytes_per_pixel)
}

fn is_dwa(header: &Header) -> bool {
    matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_))
}

/// The sizes follow the version, eight bytes each (OpenEXR, DataSizesSingle). Because of the 8x8 blocks, a thin picture
/// grows by up to 64 times.
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
