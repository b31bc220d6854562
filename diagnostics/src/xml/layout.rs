//! The layout of XML files, and the proof that it changes nothing that a reader sees.
//!
//! Every element has its own line, indented by [`INDENT`] columns below its parent. A tag that would be longer than
//! [`WIDTH`] columns, or in which a value has line breaks, has one attribute per line, below the first. Attributes stay
//! in their order: people and Groot2 have different ones, and a change of the order would hide a change of a value.
//! A comment stays behind what is on its line. One blank line at most is kept, and none beside a parent's tag.
//!
//! Values, text, CDATA sections, comments and processing instructions are not rewritten: entities stay as they are.
//! White space between elements is layout; that of an element with text, or with a value by its language, is not.

use std::ops::Range;

use roxmltree::{Document, Node, NodeType};

use crate::Problem;

/// The columns by which a child is indented.
const INDENT: usize = 2;

/// The longest line that is not broken, in columns.
const WIDTH: usize = 120;

/// The columns of a tab in the indentation of a comment.
const TAB: usize = 4;

/// Elements may be nested this deep, so that no text can exhaust the stack. Chosen, not measured.
const MAX_DEPTH: usize = 300;

/// The namespace of `xml:space`.
const XML: &str = "http://www.w3.org/XML/1998/namespace";

/// Whether the white space in an element is part of its value, by the rules of the file's language.
pub type HasValue<'f> = &'f dyn Fn(Node<'_, '_>) -> bool;

/// The text of a document in its canonical layout. Line breaks are line feeds.
///
/// # Errors
/// If elements are nested too deeply.
pub fn layout(document: &Document<'_>, has_value: HasValue<'_>) -> Result<String, Problem> {
    let text = document.input_text();
    let mut layouter = Layouter { text, out: String::with_capacity(text.len() * 5 / 4), has_value };
    let start = declaration(text).len();
    layouter.out.push_str(&text[..start]);
    layouter.children(document.root(), start, 0)?;
    layouter.out.push('\n');
    Ok(layouter.out)
}

/// Whether a reader sees the same in both documents: all but white space that is layout, by the rules of the files'
/// language, and the indentation of comments.
#[must_use]
pub fn is_same(one: &Document<'_>, other: &Document<'_>, has_value: HasValue<'_>) -> bool {
    declaration(one.input_text()) == declaration(other.input_text())
        && is_same_node(one.root(), other.root(), false, has_value)
}

/// The `<?xml …?>` at the beginning of a text.
fn declaration(text: &str) -> &str {
    let end = if text.starts_with("<?xml ") { text.find("?>").map_or(0, |end| end + "?>".len()) } else { 0 };
    &text[..end]
}

/// Whether an element's contents stay as they are, apart from the language: it has text, or `xml:space`.
fn is_kept(element: Node<'_, '_>, has_value: HasValue<'_>) -> bool {
    element.is_element()
        && (element.attribute((XML, "space")) == Some("preserve")
            || has_value(element)
            || element.children().any(|child| child.is_text() && is_text(child)))
}

/// Whether a piece of text is more than layout: blanks in a CDATA section or as references are.
fn is_text(text: Node<'_, '_>) -> bool {
    // The range of a text that has several pieces is that of the first.
    let (input, start) = (text.document().input_text(), text.range().start);
    let end = match text.next_sibling() {
        Some(next) => next.range().start,
        None => text.parent().map_or(start, |parent| end_tag(input, parent.range())),
    };
    !is_blank(&input[start..end])
}

/// Where the end tag of an element that is not closed by its start tag begins.
fn end_tag(input: &str, element: Range<usize>) -> usize {
    input[element.clone()].rfind("</").map_or(element.end, |end| element.start + end)
}

/// Whether a text consists of XML's white space; a no-break space, for example, is text.
fn is_blank(text: &str) -> bool {
    text.bytes().all(|byte| matches!(byte, b' ' | b'\t' | b'\r' | b'\n'))
}

fn is_same_node(one: Node<'_, '_>, other: Node<'_, '_>, is_inside_kept: bool, has_value: HasValue<'_>) -> bool {
    let is_kept = is_inside_kept || is_kept(one, has_value);
    let itself = match (one.node_type(), other.node_type()) {
        (NodeType::Root, NodeType::Root) => true,
        (NodeType::Element, NodeType::Element) => {
            let attributes = |node: Node<'_, '_>| -> Vec<(Option<String>, String, String)> {
                let all = node.attributes().map(|attribute| {
                    let namespace = attribute.namespace().map(str::to_owned);
                    (namespace, attribute.name().to_owned(), attribute.value().to_owned())
                });
                all.collect()
            };
            one.tag_name() == other.tag_name()
                && attributes(one) == attributes(other)
                && one.namespaces().eq(other.namespaces())
        }
        (NodeType::Text, NodeType::Text) => one.text() == other.text(),
        (NodeType::PI, NodeType::PI) => one.pi() == other.pi(),
        (NodeType::Comment, NodeType::Comment) => {
            let words = |node: Node<'_, '_>| -> Vec<String> {
                node.text().unwrap_or_default().split_whitespace().map(str::to_owned).collect()
            };
            words(one) == words(other)
        }
        _ => false,
    };
    let counts = |child: &Node<'_, '_>| is_kept || !child.is_text();
    let (mut own, mut others) = (one.children().filter(counts), other.children().filter(counts));
    itself
        && std::iter::from_fn(|| match (own.next(), others.next()) {
            (None, None) => None,
            (Some(own), Some(other)) => Some(is_same_node(own, other, is_kept, has_value)),
            _ => Some(false),
        })
        .all(|same| same)
}

struct Layouter<'a> {
    text: &'a str,
    out: String,
    has_value: HasValue<'a>,
}

impl<'a> Layouter<'a> {
    /// Writes the children of a node, which begin at this byte, without their text.
    fn children(&mut self, parent: Node<'_, '_>, from: usize, depth: usize) -> Result<(), Problem> {
        if depth > MAX_DEPTH {
            let problem = Problem::new(format!("elements may be nested at most {MAX_DEPTH} deep"));
            return Err(problem.at(super::name_span(parent), "one too many"));
        }
        let mut end = from;
        for child in parent.children().filter(|child| !child.is_text()) {
            let breaks = self.text[end..child.range().start].matches('\n').count();
            if child.is_comment() && breaks == 0 && (end > from || parent.is_element()) {
                self.out.push(' ');
            } else if !self.out.is_empty() {
                let is_first = end == from && parent.is_element();
                self.out.push_str(if breaks > 1 && !is_first { "\n\n" } else { "\n" });
                self.indent(depth);
            }
            match child.node_type() {
                NodeType::Element => self.element(child, depth)?,
                NodeType::Comment => self.comment(child.range()),
                _ => self.out.push_str(&self.text[child.range()]),
            }
            end = child.range().end;
        }
        Ok(())
    }

    fn indent(&mut self, depth: usize) {
        self.out.extend(std::iter::repeat_n(' ', depth * INDENT));
    }

    fn element(&mut self, element: Node<'_, '_>, depth: usize) -> Result<(), Problem> {
        let range = element.range();
        let tag = Tag::at(self.text, range.start);
        let contents = if tag.is_closed { "" } else { &self.text[tag.end..end_tag(self.text, range)] };
        let is_kept = is_kept(element, self.has_value);
        let is_empty = contents.is_empty() || is_blank(contents) && !is_kept;
        self.tag(&tag, if is_empty { "/>" } else { ">" });
        if is_empty {
            return Ok(());
        }
        if is_kept {
            self.out.push_str(contents);
        } else {
            self.children(element, tag.end, depth + 1)?;
            self.out.push('\n');
            self.indent(depth);
        }
        self.out.push_str("</");
        self.out.push_str(tag.name);
        self.out.push('>');
        Ok(())
    }

    fn tag(&mut self, tag: &Tag<'_>, end: &str) {
        let width = |text: &str| text.chars().count();
        let lengths = tag.attributes.iter().map(|(name, value)| 2 + width(name) + width(value));
        let length = self.column() + 1 + width(tag.name) + lengths.sum::<usize>() + end.len();
        let is_broken = length > WIDTH || tag.attributes.iter().any(|(_, value)| value.contains('\n'));
        self.out.push('<');
        self.out.push_str(tag.name);
        let below = " ".repeat(self.column() + 1);
        for (place, (name, value)) in tag.attributes.iter().enumerate() {
            let before = if place > 0 && is_broken { format!("\n{below}") } else { " ".to_owned() };
            self.out.extend([&before, *name, "=", value]);
        }
        self.out.push_str(end);
    }

    /// Writes a comment. Its further lines move with the first.
    fn comment(&mut self, range: Range<usize>) {
        let line_start = self.text[..range.start].rfind('\n').map_or(0, |end| end + 1);
        let (old, new) = (columns(&self.text[line_start..range.start]), self.column());
        for (place, line) in self.text[range].split('\n').enumerate() {
            let line = line.trim_end_matches([' ', '\t', '\r']);
            let words = line.trim_start_matches([' ', '\t']);
            if place > 0 {
                self.out.push('\n');
                let column = if words.is_empty() {
                    0
                } else {
                    (columns(&line[..line.len() - words.len()]) + new).saturating_sub(old)
                };
                self.out.extend(std::iter::repeat_n(' ', column));
            }
            self.out.push_str(if place > 0 { words } else { line });
        }
    }

    /// The columns that are already on the line.
    fn column(&self) -> usize {
        let line_start = self.out.rfind('\n').map_or(0, |end| end + 1);
        self.out[line_start..].chars().count()
    }
}

fn columns(text: &str) -> usize {
    text.chars().map(|character| if character == '\t' { TAB } else { 1 }).sum()
}

/// A start tag as it is written.
struct Tag<'a> {
    name: &'a str,
    /// The names and the values with their quotes.
    attributes: Vec<(&'a str, String)>,
    /// The byte after it.
    end: usize,
    /// Whether it is the whole element.
    is_closed: bool,
}

impl<'a> Tag<'a> {
    /// The tag that begins at a byte of a well-formed text.
    fn at(text: &'a str, start: usize) -> Self {
        let ends = |c: char| c.is_ascii_whitespace() || matches!(c, '/' | '>' | '=');
        let word = |from: usize| text[from..].find(ends).map_or(text.len(), |length| from + length);
        let blank = |from: usize| from + text[from..].bytes().take_while(u8::is_ascii_whitespace).count();
        let mut end = word(start + 1);
        let (name, mut attributes) = (&text[start + 1..end], Vec::new());
        loop {
            let begin = blank(end);
            end = word(begin);
            if begin == end {
                let is_closed = text[begin..].starts_with('/');
                return Self { name, attributes, end: (begin + 1 + usize::from(is_closed)).min(text.len()), is_closed };
            }
            let open = blank(blank(end) + "=".len());
            let quote = if text[open..].starts_with('\'') { '\'' } else { '"' };
            let close = text[open + 1..].find(quote).map_or(text.len(), |length| open + 1 + length);
            let value = &text[open + 1..close];
            let quote = if value.contains('"') { quote } else { '"' };
            attributes.push((&text[begin..end], format!("{quote}{value}{quote}")));
            end = close + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The layout, in which `<v>` has a value.
    fn laid_out(text: &str) -> String {
        let has_value = |node: Node<'_, '_>| node.has_tag_name("v");
        let before = Document::parse(text).expect(text);
        let after = layout(&before, &has_value).expect("not deep");
        let document = Document::parse(&after).expect(&after);
        assert!(is_same(&before, &document, &has_value), "{after}");
        assert_eq!(layout(&document, &has_value).expect("not deep"), after, "it is idempotent");
        after
    }

    #[test]
    fn elements_have_their_own_lines_and_blank_lines_stay() {
        let text = "<?xml version='1.0'?><a\n><b  c = 'd'></b>\n\n\n\t<e>\n\n <f/></e >\n\n</a>";
        assert_eq!(laid_out(text), "<?xml version='1.0'?>\n<a>\n  <b c=\"d\"/>\n\n  <e>\n    <f/>\n  </e>\n</a>\n");
    }

    #[test]
    fn a_comment_stays_behind_what_is_on_its_line() {
        let text = "<!-- one --><a><!-- two --><b/>  <!-- three\n  four --> <c/>\n<!-- five -->\n</a><!-- six -->";
        let after =
            "<!-- one -->\n<a> <!-- two -->\n  <b/> <!-- three\nfour -->\n  <c/>\n  <!-- five -->\n</a> <!-- six -->\n";
        assert_eq!(laid_out(text), after);
    }

    #[test]
    fn further_lines_of_a_comment_move_with_the_first() {
        let text = "<a>\n<b>\n<!-- one\n  two\n\n\tthree-->\n</b></a>";
        assert_eq!(laid_out(text), "<a>\n  <b>\n    <!-- one\n      two\n\n        three-->\n  </b>\n</a>\n");
    }

    #[test]
    fn values_and_text_keep_every_byte() {
        for element in [
            "<v> <w  x='1'> </w></v>",
            "<b>text <c/> </b>",
            "<b>&#32;</b>",
            "<b> <![CDATA[ ]]><c/></b>",
            "<b>&#32;<c/></b>",
            "<b xml:space=\"preserve\"> <c/> </b>",
            "<b><![CDATA[ <x> ]]></b>",
            "<b c=\"&#10; &quot; '\"/>",
            "<b c='\"'/>",
            "<?pi  some  data ?>",
        ] {
            assert_eq!(laid_out(&format!("<a>{element}</a>")), format!("<a>\n  {element}\n</a>\n"));
        }
    }

    #[test]
    fn a_long_tag_has_one_attribute_per_line() {
        let long = "x".repeat(WIDTH);
        let after = format!("<a b=\"{long}\"\n   c=\"1\"\n   d=\"2\"/>\n");
        assert_eq!(laid_out(&format!("<a b='{long}' c='1' d='2'></a>")), after);
        assert_eq!(laid_out("<a b='1\n2' c='3'/>"), "<a b=\"1\n2\"\n   c=\"3\"/>\n");
        let fits = format!("<a b=\"{}\"/>\n", "x".repeat(WIDTH - "<a b=\"\"/>".len()));
        assert_eq!(laid_out(&fits), fits);
    }

    #[test]
    fn a_difference_that_a_reader_sees_is_one() {
        let is_same = |one: &str, other: &str| {
            let [one, other] = [one, other].map(|text| Document::parse(text).expect(text));
            is_same(&one, &other, &|node| node.has_tag_name("v"))
        };
        assert!(is_same("<a b='1'> <c/> </a>", "<a b=\"1\"><c></c></a>"));
        assert!(is_same("<a><!-- one\n  two --></a>", "<a>\n<!-- one two --></a>"));
        for (one, other) in [
            ("<a b='1'/>", "<a b='2'/>"),
            ("<a b='1' c='2'/>", "<a c='2' b='1'/>"),
            ("<a/>", "<b/>"),
            ("<a xmlns='x'/>", "<a/>"),
            ("<a><b/><c/></a>", "<a><c/><b/></a>"),
            ("<a><b/></a>", "<a/>"),
            ("<a>text</a>", "<a>text </a>"),
            ("<a><v> </v></a>", "<a><v/></a>"),
            ("<a><!--x--></a>", "<a/>"),
            ("<a><?x y?></a>", "<a><?x z?></a>"),
            ("<?xml version='1.0'?><a/>", "<a/>"),
        ] {
            assert!(!is_same(one, other), "{one} {other}");
        }
    }

    #[test]
    fn a_text_that_is_nested_too_deeply_is_refused() {
        let text = format!("{}{}", "<a>".repeat(MAX_DEPTH + 2), "</a>".repeat(MAX_DEPTH + 2));
        let document = Document::parse(&text).expect("well-formed");
        assert!(layout(&document, &|_| false).is_err());
    }
}
