//! Makes the header of an EXR file deterministic.
//!
//! In: a file written by the EXR crate. Out: the same file, with the attributes of each part sorted by name, as
//! OpenEXR's own library writes them (the crate writes custom ones in random order), and the attribute [`CHECKSUM`] set
//! to the checksum of everything after the header.

use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result, Seek, SeekFrom, Write};

/// Magic number and version (OpenEXR file layout).
const HEADER_START: u64 = 8;
/// Version field: names of up to 255 bytes instead of 31.
const LONG_NAMES: u32 = 1 << 10;
/// Version field: each header ends with a zero byte, and their list with another.
const SEVERAL_PARTS: u32 = 1 << 12;
/// Longest name that does not need the flag.
const SHORT_NAME: usize = 31;

/// Attribute with the checksum of everything after the header: offset tables and pixels.
pub(super) const CHECKSUM: &str = "pinwarpChecksum";
/// Number of hexadecimal digits of a checksum.
pub(super) const CHECKSUM_DIGITS: usize = 8;

/// End of the header, and the positions of checksums in it, in bytes from the start of the file.
#[derive(Debug, Default)]
pub(super) struct Checksums {
    pub(super) head_end: u64,
    pub(super) places: Vec<u64>,
}

/// Sorts the attributes of each header. The size of the header does not change, so chunk offsets stay valid. Also sets
/// the flag for long channel names, since the crate only considers attribute names.
pub(super) fn sort_attributes(file: &mut (impl Read + Write + Seek)) -> Result<Checksums> {
    let mut head = Head::read(file)?;
    if head.headers.iter().flatten().any(Attribute::has_long_channel_names) {
        head.version |= LONG_NAMES;
    }
    head.headers.iter_mut().for_each(|header| header.sort_by(|a, b| a.name.cmp(&b.name)));
    let mut sorted = Vec::new();
    for header in &head.headers {
        header.iter().for_each(|attribute| sorted.extend_from_slice(&attribute.bytes));
        sorted.push(0);
    }
    file.seek(SeekFrom::Start(4))?;
    file.write_all(&head.version.to_le_bytes())?;
    file.seek(SeekFrom::Start(HEADER_START))?;
    file.write_all(&sorted)?;
    Ok(head.checksums())
}

/// Finds the checksums in the header of a file.
pub(super) fn find_checksums(file: &mut (impl Read + Seek)) -> Result<Checksums> {
    Ok(Head::read(file)?.checksums())
}

/// Computes the checksum of a written file and stores it in its places, if there are any.
pub(super) fn stamp(file: &mut (impl Read + Write + Seek), checksums: &Checksums) -> Result<()> {
    if checksums.places.is_empty() {
        return Ok(());
    }
    let digits = checksum(file, checksums.head_end)?;
    for &place in &checksums.places {
        file.seek(SeekFrom::Start(place))?;
        file.write_all(digits.as_bytes())?;
    }
    Ok(())
}

/// Returns the CRC-32 of all bytes from `start` to the end of the file, as hexadecimal digits.
pub(super) fn checksum(file: &mut (impl Read + Seek), start: u64) -> Result<String> {
    file.seek(SeekFrom::Start(start))?;
    let mut hasher = crc32fast::Hasher::new();
    let mut reader = BufReader::with_capacity(1 << 20, file);
    loop {
        let bytes = reader.fill_buf()?;
        if bytes.is_empty() {
            return Ok(format!("{:08x}", hasher.finalize()));
        }
        hasher.update(bytes);
        let count = bytes.len();
        reader.consume(count);
    }
}

/// All headers of a file, in file order.
struct Head {
    version: u32,
    headers: Vec<Vec<Attribute>>,
}

impl Head {
    fn read(file: &mut (impl Read + Seek)) -> Result<Self> {
        file.seek(SeekFrom::Start(4))?;
        let mut reader = BufReader::new(&mut *file);
        let version = u32::from_le_bytes(read_array(&mut reader)?);
        let mut headers = Vec::new();
        loop {
            let header = read_header(&mut reader)?;
            // The zero byte at the end of the list reads like another header without attributes.
            if header.is_empty() {
                break;
            }
            headers.push(header);
            if version & SEVERAL_PARTS == 0 {
                break;
            }
        }
        Ok(Self { version, headers })
    }

    fn checksums(&self) -> Checksums {
        let (mut at, mut places) = (HEADER_START, Vec::new());
        for header in &self.headers {
            for attribute in header {
                if attribute.is_checksum() {
                    places.push(at + attribute.value as u64);
                }
                at += attribute.bytes.len() as u64;
            }
            at += 1;
        }
        let list_end = u64::from(self.version & SEVERAL_PARTS != 0);
        Checksums { head_end: at + list_end, places }
    }
}

/// Returns the compression number of each part.
pub(super) fn compressions(reader: &mut impl BufRead) -> Result<Vec<u8>> {
    let [_, version] = [read_array(reader)?, read_array(reader)?].map(u32::from_le_bytes);
    let mut found = Vec::new();
    loop {
        let header = read_header(reader)?;
        let codec = header.iter().find(|attribute| attribute.name == b"compression");
        found.extend(codec.and_then(|codec| codec.bytes.get(codec.value)));
        if header.is_empty() || version & SEVERAL_PARTS == 0 {
            return Ok(found);
        }
    }
}

/// A raw attribute of the file.
struct Attribute {
    /// Name without the terminating zero.
    name: Vec<u8>,
    /// Offset of the value in `bytes`.
    value: usize,
    /// Name, type, size and value.
    bytes: Vec<u8>,
}

impl Attribute {
    fn is_checksum(&self) -> bool {
        self.name == CHECKSUM.as_bytes() && self.bytes.len() - self.value == CHECKSUM_DIGITS
    }

    /// A channel list contains, per channel, the zero-terminated name and 16 bytes of data; a zero byte ends it.
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

/// Reads the attributes up to the zero byte that ends the header.
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

/// Reads a zero-terminated name, including the zero byte.
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
    fn checksums_cover_all_that_follows_the_head() {
        let sum = attribute(CHECKSUM, b"00000000");
        let [a, end] = [attribute("a", b"one"), vec![0]];
        for (version, head) in [
            (2, vec![sum.clone(), a.clone(), end.clone()]),
            (2 | SEVERAL_PARTS, vec![a.clone(), sum.clone(), end.clone(), sum, a, end.clone(), end]),
        ] {
            let mut cursor = Cursor::new(file(version, &head));
            let found = sort_attributes(&mut cursor).expect("a sound head");
            assert_eq!(found.head_end as usize, cursor.get_ref().len() - b"chunks".len());
            stamp(&mut cursor, &found).expect("stamped");
            assert_eq!(find_checksums(&mut cursor).expect("sound").places, found.places);
            let digits = format!("{:08x}", crc32fast::hash(b"chunks"));
            for place in found.places {
                assert_eq!(&cursor.get_ref()[place as usize..][..CHECKSUM_DIGITS], digits.as_bytes());
            }
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
