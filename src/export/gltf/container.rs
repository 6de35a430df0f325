//! The container of a .glb file (glTF 2.0, section 4).
//!
//! In: the packed file of a scene. Out: bytes.

use crate::export::ExportError;
use crate::scene::Packed;
use serde_json::json;

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
/// Sizes in bytes of the file header and of a chunk header.
const HEADERS: [usize; 2] = [12, 8];

/// Returns a packed file: the header, the JSON chunk padded with spaces, and the binary chunk padded with zeros.
///
/// # Errors
/// [`ExportError::TooLarge`] above 4 GiB, the limit of the format.
pub(crate) fn packed_glb(mut packed: Packed) -> Result<Vec<u8>, ExportError> {
    packed.binary.resize(packed.binary.len().next_multiple_of(4), 0);
    packed.json["buffers"] = json!([{ "byteLength": packed.binary.len() }]);
    let mut text = packed.json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = HEADERS[0] + 2 * HEADERS[1] + text.len() + packed.binary.len();
    let length = u32::try_from(total).map_err(|_| ExportError::TooLarge { bytes: total })?;
    let mut bytes = Vec::with_capacity(total);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&length.to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &packed.binary)] {
        bytes.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        bytes.extend_from_slice(kind);
        bytes.extend_from_slice(chunk);
    }
    Ok(bytes)
}
