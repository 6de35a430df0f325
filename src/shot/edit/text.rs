//! Converts text to an editable document and back, preserving what `toml_edit` alone would change: line endings, a byte
//! order mark.
//!
//! In: any TOML. Out: the same text except for the edits.

use toml_edit::{DocumentMut, Table};

const BYTE_ORDER_MARK: char = '\u{feff}';

/// An editable document that can be converted back to its text.
pub(super) struct EditableText {
    pub(super) document: DocumentMut,
    has_mark: bool,
    has_crlf: bool,
}

impl EditableText {
    /// Parses a text.
    ///
    /// # Errors
    /// The problem and a remedy, if the text is not TOML or mixes line endings (which could not be preserved).
    pub(super) fn parse(text: &str) -> Result<Self, (String, &'static str)> {
        let body = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        let has_crlf = body.contains("\r\n");
        let lines = body.replace("\r\n", "\n");
        if has_crlf && lines.replace('\n', "\r\n") != body {
            let what = "some lines of the shot file end in CRLF, some in LF".to_owned();
            return Err((what, "save it with one kind of line ends"));
        }
        let document: DocumentMut = lines.parse().map_err(|error| not_toml(&lines, &error))?;
        Ok(Self { document, has_mark: body.len() < text.len(), has_crlf })
    }

    pub(super) fn finish(self) -> String {
        let body = self.document.to_string();
        let body = if self.has_crlf { body.replace('\n', "\r\n") } else { body };
        if self.has_mark { format!("{BYTE_ORDER_MARK}{body}") } else { body }
    }
}

fn not_toml(text: &str, error: &toml_edit::TomlError) -> (String, &'static str) {
    let start = error.span().map_or(0, |span| span.start);
    let line = 1 + text.bytes().take(start).filter(|&byte| byte == b'\n').count();
    let what = format!("the shot file is not valid TOML in line {line}: {}", error.message().replace('\n', ", "));
    (what, "mend it first")
}

/// Returns the white space before a table's header.
pub(super) fn indent_of(table: &Table) -> String {
    let prefix = table.decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default();
    prefix.rsplit('\n').next().unwrap_or_default().to_owned()
}
