//! Left-right counterparts by name.
//!
//! In: a name. Out: the name of the counterpart on the other side.

/// Pairs of words that name the sides, anywhere in a name.
const WORDS: [[&str; 2]; 4] = [["left", "right"], ["Left", "Right"], ["LEFT", "RIGHT"], ["near", "far"]];

/// Separators before a single-letter side suffix.
const SEPARATORS: [char; 4] = ['.', '_', '-', ' '];

/// Returns the name of the other side, such as "right hand" for "left hand" and "Hand.R" for "Hand.L"; `None` if the
/// name denotes no side.
#[must_use]
pub(in crate::edit) fn other_side(name: &str) -> Option<String> {
    let both = WORDS.iter().flat_map(|[one, other]| [(one, other), (other, one)]);
    if let Some((side, other)) = { both }.find(|(side, _)| name.contains(**side)) {
        return Some(name.replacen(side, other, 1));
    }
    let (start, last) = name.split_at(name.char_indices().last()?.0);
    let other = match last {
        "l" => "r",
        "r" => "l",
        "L" => "R",
        "R" => "L",
        _ => return None,
    };
    start.ends_with(SEPARATORS).then(|| format!("{start}{other}"))
}

#[cfg(test)]
mod tests {
    use super::other_side;

    #[test]
    fn sides_go_there_and_back() {
        for (left, right) in [
            ("left hand", "right hand"),
            ("HandLeft", "HandRight"),
            ("Hand.L", "Hand.R"),
            ("ear_l", "ear_r"),
            ("near toe", "far toe"),
        ] {
            assert_eq!(other_side(left).as_deref(), Some(right));
            assert_eq!(other_side(right).as_deref(), Some(left));
        }
        for name in ["belly", "tail", "", "l", "ä"] {
            assert_eq!(other_side(name), None, "{name}");
        }
    }
}
