//! Sets the resampling filter of plates in the text of a shot.
//!
//! In: a text, a filter. Out: the new text; everything else is preserved, comments included.

use super::fault;
use super::layer::{replace, sub_table, word};
use super::text::EditableText;
use crate::plate::Filter;
use crate::shot::ShotError;

/// Sets `warp.filter`.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, or `warp` is not a table.
pub(crate) fn put_filter(text: &str, filter: Filter) -> Result<String, ShotError> {
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault("warp", &what, hint))?;
    let warp = sub_table(text.document.as_table_mut(), "warp");
    let warp = warp.ok_or_else(|| fault("warp", "`warp` is no table", "write warp = { filter = \"ewa\" }"))?;
    replace(warp, "filter", word(filter));
    Ok(text.finish())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_filter_is_replaced_in_place() -> Result<(), crate::shot::ShotError> {
        use crate::plate::Filter;
        use crate::shot::edit;
        let text = "plate = 'a.exr'\nwarp.filter = 'ewa' # soft\n";
        assert_eq!(edit::put_filter(text, Filter::Cubic)?, "plate = 'a.exr'\nwarp.filter = \"cubic\" # soft\n");
        Ok(())
    }
}
