//! Writes machines as SCXML.

use diagnostics::markup::attribute;

/// The text of a machine.
#[derive(Default)]
pub(super) struct Text {
    written: String,
    depth: usize,
}

impl Text {
    pub(super) fn line(&mut self, line: &str) {
        self.written += &format!("{:1$}{line}\n", "", 2 * self.depth);
    }

    /// Begins the machine with this name.
    pub(super) fn open_machine(&mut self, name: &str) {
        let namespace = "http://www.w3.org/2005/07/scxml";
        self.open(&format!(
            "scxml xmlns=\"{namespace}\" version=\"1.0\" datamodel=\"ecmascript\" name=\"{}\"",
            attribute(name)
        ));
    }

    /// Ends the machine.
    pub(super) fn finish(mut self) -> String {
        self.close("scxml");
        self.written
    }

    fn open(&mut self, tag: &str) {
        self.line(&format!("<{tag}>"));
        self.depth += 1;
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(&format!("</{name}>"));
    }

    /// An element with this content, if there is any.
    pub(super) fn element(&mut self, tag: &str, content: impl FnOnce(&mut Self)) {
        let before = self.written.len();
        self.open(tag);
        let inside = self.written.len();
        content(self);
        if self.written.len() > inside {
            self.close(tag.split(' ').next().unwrap_or_default());
        } else {
            self.written.truncate(before);
            self.depth -= 1;
            self.line(&format!("<{tag}/>"));
        }
    }

    pub(super) fn state(&mut self, id: &str, content: impl FnOnce(&mut Self)) {
        self.element(&format!("state id=\"{id}\""), content);
    }

    /// An element with a line for each item.
    pub(super) fn filled<T>(&mut self, tag: &str, items: &[T], line: impl Fn(&T) -> String) {
        self.element(tag, |text| items.iter().for_each(|item| text.line(&line(item))));
    }
}
