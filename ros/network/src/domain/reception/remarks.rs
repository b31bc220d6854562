//! Losses and notes, in words.

/// The most lines of each kind.
const MOST: usize = 1000;

/// What is reported beside the messages.
#[derive(Default)]
pub(in crate::domain) struct Remarks {
    pub(in crate::domain) lost: Vec<String>,
    pub(in crate::domain) notes: Vec<String>,
}

impl Remarks {
    pub(super) fn lose(&mut self, what: String) {
        add(&mut self.lost, what, "more was lost later");
    }

    pub(super) fn note(&mut self, what: String) {
        add(&mut self.notes, what, "more happened later");
    }
}

/// Adds a line, unless it is there already. The line after the last is `more`.
fn add(lines: &mut Vec<String>, line: String, more: &str) {
    match lines.len() {
        ..MOST if !lines.contains(&line) => lines.push(line),
        MOST => lines.push(more.to_owned()),
        _ => {}
    }
}
