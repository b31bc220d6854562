//! What a property requires, in the words of its author.

/// The first sentence, without its full stop, of the comment that ends on the line above the property that begins at
/// this byte.
pub(crate) fn summary_above(text: &str, start: usize) -> Option<String> {
    let line_start = text[..start].rfind('\n').map_or(0, |end| end + 1);
    if !text[line_start..start].trim().is_empty() {
        return None;
    }
    let above: Vec<&str> = text[..line_start].lines().rev().map_while(|line| line.trim().strip_prefix("//")).collect();
    let comment = above.iter().rev().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
    let sentence = comment.split_once(". ").map_or(comment.as_str(), |(first, _)| first);
    let sentence = sentence.trim().trim_end_matches('.');
    (!sentence.is_empty()).then(|| sentence.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_comment_directly_above_a_property_is_its_summary() {
        let text = "// Not this.\n\n// The level read is\n// never below 20 %. More about it.\nproperty p := true";
        let summary = |text: &str| summary_above(text, text.find("property p").expect("the property is there"));
        assert_eq!(summary(text).as_deref(), Some("The level read is never below 20 %"));
        assert_eq!(summary("property p := true"), None);
        assert_eq!(summary("const a := 1\nproperty p := true"), None);
        assert_eq!(summary("// Another.\nconst a := 1 property p := true"), None);
    }
}
