//! The head of an EXR file, put into an order that is the same every time.
//!
//! In: a file that the EXR crate wrote. Out: the same file; the attributes of each part stand in the order of their
//! names, as OpenEXR's own library writes them.
//!
//! The crate keeps attributes that it does not know in hash maps, so they are written in random order.

use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result, Seek, SeekFrom, Write};

/// Magic number and version (OpenEXR file layout).
const HEADER_START: u64 = 8;
/// Version field: names of up to 255 bytes instead of 31.
const LONG_NAMES: u32 = 1 << 10;
/// Version field: each header ends with a zero byte, and one more ends their list.
const SEVERAL_PARTS: u32 = 1 << 12;
/// The longest name that needs no flag.
const SHORT_NAME: usize = 31;

/// Sorts the attributes of each header. The head keeps its size, so that offsets of chunks stay valid. Says in the
/// version field where channels have long names: the crate looks at the names of attributes only.
pub(super) fn sort_attributes(file: &mut (impl Read + Write + Seek)) -> Result<()> {
    file.seek(SeekFrom::Start(4))?;
    let mut reader = BufReader::new(&mut *file);
    let mut version = u32::from_le_bytes(read_array(&mut reader)?);
    let mut sorted = Vec::new();
    loop {
        let mut header = read_header(&mut reader)?;
        // The zero byte that ends the list of headers looks like one more header, without attributes.
        if header.is_empty() {
            break;
        }
        if header.iter().any(Attribute::has_long_channel_names) {
            version |= LONG_NAMES;
        }
        header.sort_by(|a, b| a.name.cmp(&b.name));
        header.iter().for_each(|attribute| sorted.extend_from_slice(&attribute.bytes));
        sorted.push(0);
        if version & SEVERAL_PARTS == 0 {
            break;
        }
    }
    drop(reader);
    file.seek(SeekFrom::Start(4))?;
    file.write_all(&version.to_le_bytes())?;
    file.seek(SeekFrom::Start(HEADER_START))?;
    file.write_all(&sorted)
}

/// An attribute as it stands in the file.
struct Attribute {
    /// Without the zero byte.
    name: Vec<u8>,
    /// Where the value begins in `bytes`.
    value: usize,
    /// Name, type, size and value.
    bytes: Vec<u8>,
}

impl Attribute {
    /// A channel list holds, for each channel, its name, a zero byte, and 16 bytes of what it is; a zero byte ends it.
    fn has_long_channel_names(&self) -> bool {
        let mut rest = if self.name == b"channels" { &self.bytes[self.value..] } else { &[] };
        while let Some(length) = rest.iter().position(|&byte| byte == 0) {
            if length > SHORT_NAME {
                return true;
            }
            rest = rest.get(length + 17..).unwrap_or_default();
        }
        false
    }
}

/// The attributes up to the zero byte that ends the header.
fn read_header(reader: &mut impl BufRead) -> Result<Vec<Attribute>> {
    let mut header = Vec::new();
    loop {
        let name = read_name(reader)?;
        if name.len() == 1 {
            return Ok(header);
        }
        let kind = read_name(reader)?;
        let size = read_array(reader)?;
        let bytes_wanted = u64::from(u32::from_le_bytes(size));
        let mut bytes = [name.as_slice(), &kind, &size].concat();
        let value = bytes.len();
        if reader.take(bytes_wanted).read_to_end(&mut bytes)? as u64 != bytes_wanted {
            return Err(cut_off());
        }
        header.push(Attribute { name: name[..name.len() - 1].to_vec(), value, bytes });
    }
}

/// A name and the zero byte after it.
fn read_name(reader: &mut impl BufRead) -> Result<Vec<u8>> {
    let mut name = Vec::new();
    reader.read_until(0, &mut name)?;
    if name.last() == Some(&0) { Ok(name) } else { Err(cut_off()) }
}

fn read_array(reader: &mut impl Read) -> Result<[u8; 4]> {
    let mut bytes = [0; 4];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn cut_off() -> Error {
    Error::new(ErrorKind::UnexpectedEof, "the head of the file ends too early")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn attribute(name: &str, value: &[u8]) -> Vec<u8> {
        [name.as_bytes(), b"\0string\0", &(value.len() as u32).to_le_bytes(), value].concat()
    }

    fn file(version: u32, head: &[Vec<u8>]) -> Vec<u8> {
        [b"\x76\x2f\x31\x01".as_slice(), &version.to_le_bytes(), &head.concat(), b"chunks"].concat()
    }

    fn sorted(version: u32, head: &[Vec<u8>]) -> Vec<u8> {
        let mut cursor = Cursor::new(file(version, head));
        sort_attributes(&mut cursor).expect("a sound head");
        cursor.into_inner()
    }

    #[test]
    fn attributes_stand_in_the_order_of_their_names() {
        let [a, b, c] = [attribute("a", b"one"), attribute("b", b""), attribute("c", b"b\0a")];
        let end = vec![0];
        let before = [c.clone(), a.clone(), b.clone(), end.clone()];
        let after = [a.clone(), b.clone(), c.clone(), end.clone()];
        assert_eq!(sorted(2, &before), file(2, &after));
        assert_eq!(sorted(2, &after), file(2, &after));

        let parts = [b.clone(), a.clone(), end.clone(), c.clone(), b.clone(), end.clone(), end.clone()];
        let expected = [a, b.clone(), end.clone(), b, c, end.clone(), end];
        assert_eq!(sorted(2 | SEVERAL_PARTS, &parts), file(2 | SEVERAL_PARTS, &expected));
    }

    #[test]
    fn long_channel_names_are_declared() {
        for (length, version) in [(31, 2), (32, 2 | LONG_NAMES)] {
            let list = ["A", &"n".repeat(length)].map(|name| [name.as_bytes(), &[0; 17]].concat()).concat();
            let head = [attribute("channels", &[list, vec![0]].concat()), vec![0]];
            assert_eq!(sorted(2, &head), file(version, &head), "{length}");
        }
    }

    #[test]
    fn a_head_that_ends_too_early_is_an_error() {
        let whole = file(2, &[attribute("a", b"one"), vec![0]]);
        for length in 0..whole.len() - b"chunks".len() {
            assert!(sort_attributes(&mut Cursor::new(whole[..length].to_vec())).is_err(), "{length}");
        }
    }
}
