//! A file being loaded: typed JSON, resolved buffers, and errors that name it.
//!
//! In: what `json` parsed. Out: bytes of buffers, views and URIs; every index and range is checked.

use super::{FileAccess, SceneError, access};
use crate::memory::OverBudget;
use crate::spelling::pluralised;
use base64::Engine as _;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::json::{Index, Root, buffer};
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Base64 as in data URIs; writers differ in padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// A parsed file with all its buffers in memory.
pub(super) struct File {
    /// Its path; relative URIs are resolved against its folder.
    path: PathBuf,
    /// The files that it may refer to.
    access: FileAccess,
    /// Typed JSON.
    pub(super) root: Root,
    /// One per buffer of the JSON, at least as long as the JSON says.
    buffers: Vec<Vec<u8>>,
}

impl File {
    /// Resolves the buffers of `root`; `binary`: the range of the binary chunk in `bytes`, the whole file.
    pub(super) fn resolve(
        path: (&Path, FileAccess),
        root: Root,
        mut bytes: Vec<u8>,
        binary: Option<Range<usize>>,
    ) -> Result<Self, SceneError> {
        let mut chunk = binary.map(|range| {
            bytes.truncate(range.end);
            bytes.split_off(range.start)
        });
        let mut file = Self::unresolved(path, root);
        for index in 0..file.root.buffers.len() {
            let resolved = file.resolve_buffer(index, &mut chunk)?;
            file.buffers.push(resolved);
        }
        Ok(file)
    }

    /// Wraps the JSON without resolving buffers.
    pub(super) fn unresolved((path, access): (&Path, FileAccess), root: Root) -> Self {
        Self { path: path.to_owned(), access, root, buffers: Vec::new() }
    }

    /// Returns the buffers, in the order of the JSON.
    pub(super) fn buffers(&self) -> &[Vec<u8>] {
        &self.buffers
    }

    fn resolve_buffer(&self, index: usize, chunk: &mut Option<Vec<u8>>) -> Result<Vec<u8>, SceneError> {
        let buffer = &self.root.buffers[index];
        let bytes = match (&buffer.uri, index) {
            (Some(uri), _) => {
                self.read_uri(uri).map_err(|fault| self.uri_error(fault, &format!("buffers[{index}]")))?
            }
            (None, 0) if chunk.is_some() => chunk.take().unwrap_or_default(),
            (None, _) => {
                return Err(
                    self.invalid(format!("buffers[{index}] has no uri and the file has no binary chunk for it"))
                );
            }
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            return Err(self.invalid(format!(
                "buffers[{index}] must have {} and has {}; copy or export it again",
                pluralised(buffer.byte_length.0, "byte", "bytes"),
                bytes.len()
            )));
        }
        Ok(bytes)
    }

    /// Creates an error about the contents of this file.
    pub(super) fn invalid(&self, what: impl Into<String>) -> SceneError {
        SceneError::Invalid { path: self.path.clone(), what: what.into() }
    }

    /// Creates an error about the memory that this file needs.
    pub(super) fn too_large(&self, what: String, source: OverBudget) -> SceneError {
        SceneError::TooLarge { path: self.path.clone(), what, source }
    }

    /// Returns the bytes of a buffer view.
    pub(super) fn view(&self, index: Index<buffer::View>) -> Result<ViewBytes<'_>, SceneError> {
        let number = index.value();
        let view = self.root.get(index).ok_or_else(|| self.invalid(format!("bufferViews[{number}] does not exist")))?;
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(|| {
            self.invalid(format!("bufferViews[{number}] names buffers[{}], which does not exist", view.buffer.value()))
        })?;
        let bytes = slice(buffer, view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0);
        let bytes = bytes.ok_or_else(|| {
            self.invalid(format!("bufferViews[{number}] reaches past the end of buffers[{}]", view.buffer.value()))
        })?;
        Ok(ViewBytes { bytes, stride: view.byte_stride.map_or(0, |stride| stride.0) })
    }

    /// Reads the bytes of a data URI or relative URI.
    pub(super) fn read_uri(&self, uri: &str) -> Result<Vec<u8>, UriFault> {
        if let Some(data) = uri.strip_prefix("data:") {
            return decode_data_uri(data);
        }
        let path = self.path_of(uri)?;
        if self.access == FileAccess::SceneFolder && !access::is_inside(self.folder(), &path) {
            return Err(UriFault::Outside(path));
        }
        access::read_file(&path).map_err(|source| UriFault::Io { path, source })
    }

    /// Returns the files that buffers and images refer to.
    pub(super) fn beside(&self) -> Vec<PathBuf> {
        let buffers = self.root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
        let images = self.root.images.iter().filter_map(|image| image.uri.as_deref());
        let uris = buffers.chain(images).filter(|uri| !uri.starts_with("data:"));
        uris.filter_map(|uri| self.path_of(uri).ok()).collect()
    }

    /// Returns the path of a URI other than `data:`.
    fn path_of(&self, uri: &str) -> Result<PathBuf, UriFault> {
        let relative = match uri.split_once(':') {
            Some(("file", rest)) => rest.trim_start_matches("//"),
            // A single letter is a Windows drive, not a scheme.
            Some((scheme, _)) if scheme.len() > 1 && is_scheme(scheme) => {
                return Err(UriFault::Scheme(scheme.to_owned()));
            }
            _ => uri,
        };
        let decoded: Cow<'_, str> = percent_decode_str(relative).decode_utf8_lossy();
        let folder = self.folder();
        let plain = folder.join(relative);
        let path = folder.join(&*decoded);
        // Some exporters do not escape a `%` in the file name.
        Ok(if !path.exists() && plain.exists() { plain } else { path })
    }

    fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    fn uri_error(&self, fault: UriFault, what: &str) -> SceneError {
        match fault {
            UriFault::Io { path, source } => SceneError::Io { path, source },
            UriFault::Data(why) => self.invalid(format!("{what}: {why}")),
            UriFault::Outside(path) => SceneError::Unsupported {
                path: self.path.clone(),
                what: format!("{what} from {}, outside the folder of the scene", path.display()),
                hint: ALLOW_OUTSIDE.to_owned(),
            },
            UriFault::Scheme(scheme) => SceneError::Unsupported {
                path: self.path.clone(),
                what: format!("{what} from a {scheme}: address"),
                hint: "fetch the file and refer to it by a relative path".to_owned(),
            },
        }
    }
}

/// The bytes of a buffer view.
pub(super) struct ViewBytes<'a> {
    /// Exactly the view's range.
    pub(super) bytes: &'a [u8],
    /// Distance between elements in bytes; 0: tightly packed.
    pub(super) stride: usize,
}

/// What to do about files outside the scene's folder.
const ALLOW_OUTSIDE: &str = "move it below that folder, or use --allow-outside if you trust the scene";

/// The reason why a URI could not be read.
#[derive(Debug, thiserror::Error)]
pub(super) enum UriFault {
    /// Its file cannot be read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file outside the scene's folder.
    #[error("{path} lies outside the folder of the scene; {ALLOW_OUTSIDE}", path = .0.display())]
    Outside(PathBuf),
    /// A damaged data URI.
    #[error("{0}")]
    Data(String),
    /// An unsupported scheme, such as a network address.
    #[error("{0}: addresses are not fetched")]
    Scheme(String),
}

fn is_scheme(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
}

/// Decodes the part after `data:`.
fn decode_data_uri(data: &str) -> Result<Vec<u8>, UriFault> {
    let Some((head, body)) = data.split_once(',') else {
        return Err(UriFault::Data("a data URI without a comma".to_owned()));
    };
    let plain: Vec<u8> = percent_decode_str(body).collect();
    if !head.ends_with(";base64") {
        return Ok(plain);
    }
    BASE64.decode(plain).map_err(|error| UriFault::Data(format!("a data URI that is not base64: {error}")))
}

/// Returns `length` bytes of `bytes` from `offset`; `None` if they extend past the end.
pub(super) fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(start..end)
}
