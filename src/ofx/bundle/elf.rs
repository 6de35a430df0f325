//! The exports and dependencies of a shared library, read from its ELF file ("System V Application Binary Interface",
//! chapters 4, 5).
//!
//! In: the bytes of a 64-bit little-endian file. Out: names of its exports, libraries and symbol versions, sorted.

/// Section types.
const DYNAMIC: u32 = 6;
const DYNSYM: u32 = 11;
const VERSIONS_NEEDED: u32 = 0x6fff_fffe;
/// Dynamic tag: a needed library.
const NEEDED: u64 = 1;

/// The external interface of a shared library.
#[derive(Clone, Debug, Default)]
pub(crate) struct Elf {
    /// Exported symbols.
    pub(crate) exports: Vec<String>,
    /// Libraries it needs.
    pub(crate) needs: Vec<String>,
    /// Symbol versions it needs, such as `GLIBC_2.17`.
    pub(crate) versions: Vec<String>,
}

/// A section's header.
#[derive(Clone, Copy)]
struct Section {
    kind: u32,
    start: usize,
    length: usize,
    /// Index of the section that holds its names.
    link: usize,
}

/// A file with bounds-checked reads.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn number<const N: usize>(self, at: usize) -> Option<u64> {
        let bytes = self.0.get(at..at.checked_add(N)?)?;
        Some(bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn place(self, at: usize) -> Option<usize> {
        usize::try_from(self.number::<8>(at)?).ok()
    }

    fn text(self, at: usize) -> Option<String> {
        let rest = self.0.get(at..)?;
        let end = rest.iter().position(|byte| *byte == 0)?;
        Some(String::from_utf8_lossy(&rest[..end]).into_owned())
    }

    fn sections(self) -> Option<Vec<Section>> {
        let [size, count] = [self.number::<2>(0x3a)?, self.number::<2>(0x3c)?].map(|number| number as usize);
        let start = self.place(0x28)?;
        (0..count)
            .map(|index| {
                let at = start.checked_add(index * size)?;
                let kind = self.number::<4>(at + 4)? as u32;
                let link = self.number::<4>(at + 40)? as usize;
                Some(Section { kind, start: self.place(at + 24)?, length: self.place(at + 32)?, link })
            })
            .collect()
    }
}

impl Elf {
    /// Parses a file; `None` if it is not an ELF file or is damaged.
    pub(crate) fn parse(file: &[u8]) -> Option<Self> {
        let is_ours = file.starts_with(b"\x7fELF\x02\x01");
        let bytes = Bytes(file);
        let sections = bytes.sections().filter(|_| is_ours)?;
        let mut elf = Self::default();
        for section in &sections {
            let names = || sections.get(section.link).map(|names| names.start);
            match section.kind {
                DYNSYM => elf.exports = exports(bytes, *section, names()?)?,
                DYNAMIC => elf.needs = needs(bytes, *section, names()?)?,
                VERSIONS_NEEDED => elf.versions = versions(bytes, *section, names()?)?,
                _ => {}
            }
        }
        [&mut elf.exports, &mut elf.needs, &mut elf.versions].into_iter().for_each(|names| names.sort());
        Some(elf)
    }

    /// Returns the newest glibc version that is needed.
    pub(crate) fn newest_glibc(&self) -> Option<[u32; 2]> {
        self.versions.iter().filter_map(|name| version(name.strip_prefix("GLIBC_")?)).max()
    }
}

/// Parses a version such as `2.28`; a third component is dropped.
pub(crate) fn version(text: &str) -> Option<[u32; 2]> {
    let mut parts = text.split('.').map(str::parse);
    Some([parts.next()?.ok()?, parts.next()?.ok()?])
}

/// Returns the defined symbols that are not local.
fn exports(bytes: Bytes, section: Section, names: usize) -> Option<Vec<String>> {
    let symbols = (0..section.length / 24).map(|index| section.start + 24 * index);
    let shown = symbols.filter(|at| {
        let is_local = bytes.number::<1>(at + 4).is_none_or(|info| info >> 4 == 0);
        !is_local && bytes.number::<2>(at + 6).is_some_and(|section| section != 0)
    });
    shown.map(|at| bytes.text(names.checked_add(bytes.number::<4>(at)? as usize)?)).collect()
}

fn needs(bytes: Bytes, section: Section, names: usize) -> Option<Vec<String>> {
    let entries = (0..section.length / 16).map(|index| section.start + 16 * index);
    let needed = entries.filter(|at| bytes.number::<8>(*at) == Some(NEEDED));
    needed.map(|at| bytes.text(names.checked_add(bytes.place(at + 8)?)?)).collect()
}

/// Returns the needed versions: one record per library, linked by offsets.
fn versions(bytes: Bytes, section: Section, names: usize) -> Option<Vec<String>> {
    let mut found = Vec::new();
    let mut library = section.start;
    loop {
        let mut version = library.checked_add(bytes.number::<4>(library + 8)? as usize)?;
        for _ in 0..bytes.number::<2>(library + 2)? {
            found.push(bytes.text(names.checked_add(bytes.number::<4>(version + 8)? as usize)?)?);
            version = version.checked_add(bytes.number::<4>(version + 12)? as usize)?;
        }
        match bytes.number::<4>(library + 12)? {
            0 => return Some(found),
            next => library = library.checked_add(next as usize)?,
        }
    }
}
