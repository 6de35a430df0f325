//! Paths in JSON.
//!
//! In: any path. Out: text; bytes if it is not valid Unicode.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A path that is written to JSON without loss.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Written", into = "Written")]
pub(super) struct StoredPath(pub(super) PathBuf);

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Text(String),
    Bytes(Vec<u8>),
}

impl From<StoredPath> for Written {
    fn from(StoredPath(path): StoredPath) -> Self {
        match path.into_os_string().into_string() {
            Ok(text) => Self::Text(text),
            Err(other) => Self::Bytes(other.into_encoded_bytes()),
        }
    }
}

impl From<Written> for StoredPath {
    fn from(written: Written) -> Self {
        Self(match written {
            Written::Text(text) => text.into(),
            Written::Bytes(bytes) => path_of(bytes),
        })
    }
}

#[cfg(unix)]
fn path_of(bytes: Vec<u8>) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    std::ffi::OsString::from_vec(bytes).into()
}

#[cfg(not(unix))]
fn path_of(bytes: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn paths_of_any_bytes_come_back() {
        for bytes in [&b"/shots/a.toml"[..], b"/shots/\xff\xfe.toml"] {
            let path = StoredPath(path_of(bytes.to_vec()));
            let text = serde_json::to_string(&path).expect("written");
            assert_eq!(serde_json::from_str::<StoredPath>(&text).expect("read"), path, "{text}");
        }
        assert_eq!(serde_json::to_string(&StoredPath("a.toml".into())).expect("written"), "\"a.toml\"");
    }
}
