//! The same XML, written in another way. Shared by the tests of the crates that lay XML out.

/// What may stand between two elements.
const BETWEEN: [&str; 8] =
    ["", "\n", "\n\n\n", " \t ", "<!-- c -->", "\n<!--\n  c\n\td -->", " <?p q?> ", "\r\n  <!-- c -->\r\n"];

/// What may stand between two attributes.
const BETWEEN_ATTRIBUTES: [&str; 4] = [" ", "\n   ", "  ", "\t"];

/// What a reader takes for the same in a value: a blank.
const BLANKS: [&str; 4] = [" ", "\n", "&#32;", "\t"];

/// A text with other white space, comments, processing instructions, quotes and references, as the numbers choose.
pub(crate) fn disturbed(text: &str, numbers: &[u8]) -> String {
    let mut numbers = numbers.iter().cycle().map(|number| usize::from(*number));
    let mut roll = |sides: usize| numbers.next().map_or(0, |number| number % sides);
    let (mut out, mut is_in_tag, mut quotes) = (String::new(), false, None);
    let mut end_of_opaque = 0;
    for (at, c) in text.char_indices() {
        if at < end_of_opaque {
            out.push(c);
            continue;
        }
        let opaque = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((_, end)) = opaque.into_iter().find(|(begin, _)| !is_in_tag && text[at..].starts_with(begin)) {
            end_of_opaque = text[at..].find(end).map_or(text.len(), |place| at + place + end.len());
            out.push(c);
            continue;
        }
        match (is_in_tag, quotes, c) {
            (true, None, '"' | '\'') => {
                let new = if roll(3) == 0 { '\'' } else { '"' };
                out.push(new);
                quotes = Some((c, new));
            }
            (_, Some((old, new)), _) if c == old => {
                out.push(new);
                quotes = None;
            }
            (_, Some((_, '"')), '"') => out.push_str("&quot;"),
            (_, Some((_, '\'')), '\'') => out.push_str("&apos;"),
            (_, Some(_), ' ') if roll(4) == 0 => out.push_str(BLANKS[roll(4)]),
            (true, None, ' ') => out.push_str(BETWEEN_ATTRIBUTES[roll(4)]),
            (true, None, '=') if roll(4) == 0 => out.push_str(" =  "),
            (true, None, '>') => {
                is_in_tag = false;
                out.push('>');
                out.push_str(if at + 1 < text.len() { BETWEEN[roll(8)] } else { "" });
            }
            (false, _, '<') => {
                is_in_tag = true;
                out.push('<');
            }
            _ => out.push(c),
        }
    }
    out
}
