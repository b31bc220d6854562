//! Writes machines as SCXML.

use diagnostics::markup::attribute;

/// The text of a machine. The values of attributes are escaped here.
#[derive(Default)]
pub(super) struct Text {
    written: String,
    depth: usize,
}

impl Text {
    /// The text of the machine with this name.
    pub(super) fn machine(name: &str, content: impl FnOnce(&mut Self)) -> String {
        let mut text = Self::default();
        let namespace = "http://www.w3.org/2005/07/scxml";
        let attributes = [("xmlns", namespace), ("version", "1.0"), ("datamodel", "ecmascript"), ("name", name)];
        text.element("scxml", &attributes, content);
        text.written
    }

    fn line(&mut self, line: &str) {
        self.written += &format!("{:1$}{line}\n", "", 2 * self.depth);
    }

    /// An element with this content, if there is any.
    pub(super) fn element(&mut self, name: &str, attributes: &[(&str, &str)], content: impl FnOnce(&mut Self)) {
        let attributes: String =
            attributes.iter().map(|(name, value)| format!(" {name}=\"{}\"", attribute(value))).collect();
        let before = self.written.len();
        self.line(&format!("<{name}{attributes}>"));
        self.depth += 1;
        let inside = self.written.len();
        content(self);
        self.depth -= 1;
        if self.written.len() > inside {
            self.line(&format!("</{name}>"));
        } else {
            self.written.truncate(before);
            self.line(&format!("<{name}{attributes}/>"));
        }
    }

    /// An element without content.
    pub(super) fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.element(name, attributes, |_| {});
    }

    pub(super) fn state(&mut self, id: &str, content: impl FnOnce(&mut Self)) {
        self.element("state", &[("id", id)], content);
    }

    pub(super) fn transition(
        &mut self,
        event: &str,
        cond: Option<&str>,
        target: Option<&str>,
        content: impl FnOnce(&mut Self),
    ) {
        let attributes = [("event", Some(event)), ("cond", cond), ("target", target)];
        let given: Vec<_> = attributes.into_iter().filter_map(|(name, value)| Some((name, value?))).collect();
        self.element("transition", &given, content);
    }

    pub(super) fn assign(&mut self, location: &str, expr: &str) {
        self.empty("assign", &[("location", location), ("expr", expr)]);
    }

    /// A `<send>` with these parameters, each a name and an expression.
    pub(super) fn send<'p>(
        &mut self,
        attributes: &[(&str, &str)],
        params: impl IntoIterator<Item = (&'p str, String)>,
    ) {
        self.element("send", attributes, |text| {
            params.into_iter().for_each(|(name, expr)| text.empty("param", &[("name", name), ("expr", &expr)]));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_escaped_and_an_element_without_content_is_one_tag() {
        let text = Text::machine("a \"b\"", |text| {
            text.state("s", |text| {
                text.transition("x", Some("a < b && 'c'"), None, |_| {});
                text.element("onentry", &[], |text| text.send(&[("event", "e")], [("p", "1 > 2".to_owned())]));
            });
        });
        let (_, machine) = text.split_once(" name=").expect("a name");
        let lines = [
            "\"a &quot;b&quot;\">",
            "  <state id=\"s\">",
            "    <transition event=\"x\" cond=\"a &lt; b &amp;&amp; 'c'\"/>",
            "    <onentry>",
            "      <send event=\"e\">",
            "        <param name=\"p\" expr=\"1 &gt; 2\"/>",
            "      </send>",
            "    </onentry>",
            "  </state>",
            "</scxml>\n",
        ];
        assert_eq!(machine, lines.join("\n"));
    }
}
