//! A text chunk in PNG files that stores the frame's provenance (PNG specification, third edition, 11.3.3.4 iTXt).
//!
//! In: an encoded PNG and [`FrameMetadata`]. Out: the same picture with the chunk; and the chunk of a file, read after
//! verifying the checksums of all chunks.

use super::FrameMetadata;
use super::provenance::{self, Provenance};
use std::io::{BufReader, Error, ErrorKind, Read, Result};
use std::path::Path;

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Signature and header chunk, which always comes first and is 25 bytes long.
const HEAD_END: usize = 33;

/// The metadata of a PNG file.
pub(super) struct Note {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// `None`: written by another program.
    pub(super) fields: Option<Provenance>,
}

/// Inserts the text chunk after the header chunk.
pub(super) fn noted(mut png: Vec<u8>, metadata: &FrameMetadata) -> Vec<u8> {
    // Keyword, no compression, no language, no translated keyword.
    let content = [b"iTXt", provenance::NAME.as_bytes(), &[0; 5], metadata.provenance().json().as_bytes()].concat();
    let length = u32::try_from(content.len() - 4).expect("a note is short");
    let chunk = [&length.to_be_bytes(), content.as_slice(), &crc32fast::hash(&content).to_be_bytes()].concat();
    if png.len() >= HEAD_END {
        png.splice(HEAD_END..HEAD_END, chunk);
    }
    png
}

/// Reads all chunks.
///
/// # Errors
/// [`Error`] if the file cannot be read or is truncated, or the checksum of a chunk is wrong.
pub(super) fn read(path: &Path) -> Result<Note> {
    let mut file = BufReader::new(std::fs::File::open(path)?);
    if read_array(&mut file)? != SIGNATURE {
        return Err(damaged());
    }
    let mut note = Note { size: [0; 2], fields: None };
    loop {
        let length = u32::from_be_bytes(read_array(&mut file)?);
        let mut chunk = Vec::new();
        let wanted = u64::from(length) + 4;
        if file.by_ref().take(wanted).read_to_end(&mut chunk)? as u64 != wanted {
            return Err(damaged());
        }
        if u32::from_be_bytes(read_array(&mut file)?) != crc32fast::hash(&chunk) {
            return Err(damaged());
        }
        match chunk.split_at(4) {
            (b"IHDR", content) => {
                let side = |at: usize| content.get(at..at + 4)?.try_into().ok().map(u32::from_be_bytes);
                note.size = [side(0).ok_or_else(damaged)?, side(4).ok_or_else(damaged)?];
            }
            (b"iTXt", content) => note.fields = fields(content).or(note.fields),
            (b"IEND", _) => return Ok(note),
            _ => {}
        }
    }
}

fn fields(content: &[u8]) -> Option<Provenance> {
    let json = content.strip_prefix(provenance::NAME.as_bytes())?.strip_prefix(&[0; 5])?;
    serde_json::from_slice(json).ok()
}

fn read_array<const N: usize>(reader: &mut impl Read) -> Result<[u8; N]> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn damaged() -> Error {
    Error::new(ErrorKind::InvalidData, "not a whole PNG file")
}
