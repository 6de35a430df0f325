//! Finds the right spelling that a wrong one comes nearest to, for error messages.

/// Names listed in a hint, at most.
const LISTED: usize = 12;

/// The nearest of the right spellings, if it is near enough to be meant.
pub(crate) fn nearest<'a>(wrong: &str, right: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let closeness = |name: &str| strsim::jaro_winkler(&wrong.to_lowercase(), &name.to_lowercase());
    let best = right.map(|name| (closeness(name), name)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > 0.75).then_some(best.1)
}

/// How to fix a wrong name: the nearest right one, or what there is.
pub(crate) fn hint<'a>(wrong: &str, right: impl Iterator<Item = &'a str> + Clone) -> String {
    if let Some(name) = nearest(wrong, right.clone()) {
        return format!("did you mean \"{name}\"?");
    }
    list(right)
}

/// What there is, in words; long lists are cut.
pub(crate) fn list<'a>(names: impl Iterator<Item = &'a str> + Clone) -> String {
    let shown: Vec<&str> = names.clone().take(LISTED).collect();
    let more = names.count().saturating_sub(shown.len());
    match (shown.is_empty(), more) {
        (true, _) => "there are none".into(),
        (false, 0) => format!("there are: {}", shown.join(", ")),
        (false, more) => format!("there are: {} and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_name_is_suggested_and_a_far_one_lists_all() {
        let names = ["Teapot", "Ground"];
        assert_eq!(hint("Taepot", names.into_iter()), "did you mean \"Teapot\"?");
        assert_eq!(hint("xyz", names.into_iter()), "there are: Teapot, Ground");
        assert_eq!(hint("xyz", std::iter::empty()), "there are none");
    }
}
