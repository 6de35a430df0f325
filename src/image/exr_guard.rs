//! What is checked before the EXR reader may take memory, and what its errors mean.
//!
//! In: a path. Out: the head of the file, or [`ImageError`].

use super::ImageError;
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
    check_size(path, &head)?;
    if head.headers.iter().any(is_dwa) {
        check_dwa(path, &head.headers)?;
    }
    Ok(head)
}

/// The head alone, unchecked.
pub(super) fn read_head(path: &Path) -> Result<MetaData, ImageError> {
    MetaData::read_from_file(path, false).map_err(|failed| read_error(path, failed))
}

/// One wrong byte in the head may promise a picture of petabytes: nothing is believed that such a file cannot hold, and the
/// memory is asked for before the reader takes it.
fn check_size(path: &Path, head: &MetaData) -> Result<(), ImageError> {
    let parts = head.headers.iter().map(|header| {
        let pixels = header.layer_size.width() as u128 * header.layer_size.height() as u128;
        (pixels * header.channels.bytes_per_pixel as u128, best_ratio(header.compression))
    });
    let (bytes, ratio) = parts.fold((0, 1), |(sum, best), (bytes, ratio)| (sum + bytes, ratio.max(best)));
    check_promise(path, bytes, ratio)?;
    check_memory(path, bytes)
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

/// Whether there is room for so many bytes of pixels.
pub(super) fn check_memory(path: &Path, bytes: u128) -> Result<(), ImageError> {
    let is_there_memory = usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    if is_there_memory {
        return Ok(());
    }
    let what = format!("its head promises {} MB of pixels, more than this machine can hold", bytes / 1_000_000);
    Err(ImageError::damaged(path, what))
}

/// A DWA chunk begins with nine sizes that the reader believes as they stand. Goes through the chunks without decoding.
fn check_dwa(path: &Path, headers: &[Header]) -> Result<(), ImageError> {
    let damaged = |failed| read_error(path, failed);
    let file = File::open(path).map_err(|source| ImageError::reading(path, source))?;
    let reader = exr::block::read(BufReader::new(file), false).map_err(damaged)?;
    for chunk in reader.all_chunks(false).map_err(damaged)? {
        let chunk = chunk.map_err(damaged)?;
        let bytes = match &chunk.compressed_block {
            CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
            CompressedBlock::Tile(block) => &block.compressed_pixels_le,
            _ => continue,
        };
        if headers.get(chunk.layer_index).is_some_and(|header| is_dwa(header) && !are_dwa_sizes_sane(header, bytes)) {
            return Err(ImageError::damaged(path, "a DWA chunk promises more than its block can hold"));
        }
    }
    Ok(())
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
