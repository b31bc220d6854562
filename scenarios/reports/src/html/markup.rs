//! Small pieces of HTML.

use std::iter;
use std::time::Duration;

use drawing::Verdict;
use drawing::icons::Look;
use maud::{Markup, Render, html};
use monitors::Outcome;

use super::figure::sign;

/// A text for people, without a line break between a number and its percent sign.
pub fn text(text: &str) -> String {
    text.replace(" %", "\u{a0}%")
}

/// A moment in words, which leads to it on the timeline.
pub(super) fn moment(time: Duration, words: &str) -> Markup {
    html! { a href="#timeline" data-at=(time.as_secs_f64()) { (words) } }
}

/// A name that may be broken between its words.
pub(super) fn breakable(name: &str) -> Markup {
    html! {
        @for (before, character) in iter::once(' ').chain(name.chars()).zip(name.chars()) {
            @if before.is_lowercase() && character.is_uppercase() || matches!(before, '_' | '.') { wbr; }
            (character)
        }
    }
}

/// Words in which `backticks` enclose code.
pub(super) fn prose(words: &str) -> Markup {
    html! {
        @for (index, part) in words.split('`').enumerate() {
            @if index % 2 == 1 { code { (part) } } @else { (text(part)) }
        }
    }
}

/// A property's outcome as pictures show it.
pub(super) fn verdict_of(outcome: Outcome) -> Verdict {
    match outcome {
        Outcome::Violated => Verdict::Violated,
        Outcome::Satisfied => Verdict::Satisfied,
        Outcome::Inconclusive => Verdict::Inconclusive,
    }
}

/// The sign of a verdict on its background.
pub(super) fn verdict_sign(verdict: Verdict, side: f64) -> Markup {
    let look = Look::of_verdict(verdict);
    sign(side, |canvas, center| {
        canvas.circle(center, side / 2.0, drawing::canvas::Paint::fill(look.ground));
        look.icon.draw(canvas, center, side * 0.62, look.front);
    })
}

/// A verdict with its sign, as a label.
pub(super) fn pill(outcome: Outcome) -> Markup {
    let look = Look::of_verdict(verdict_of(outcome));
    let icon = sign(14.0, |canvas, center| look.icon.draw(canvas, center, 13.0, look.front));
    html! { span.pill.(outcome) { (icon) (outcome) } }
}

/// A command line, in which lines break between options.
pub fn command(line: &str) -> Markup {
    let mut parts = line.split(" --");
    let first = parts.next().unwrap_or_default();
    html! { code { (first) @for option in parts { " " span.option { "--" (option) } } } }
}

/// A section; empty without content.
pub fn section(id: &str, title: &str, content: Markup) -> Markup {
    html! { @if !content.0.is_empty() { section id=(id) { h2 { (title) } (content) } } }
}

/// A table with a heading for each column.
pub fn table<'n>(class: &str, columns: impl IntoIterator<Item = &'n str>, rows: &Markup) -> Markup {
    html! {
        table.(class) {
            thead { tr { @for name in columns { th scope="col" { (breakable(name)) } } } }
            tbody { (rows) }
        }
    }
}

/// A row of a table: its first cell is a heading.
pub fn row(name: impl Render, cells: impl IntoIterator<Item = impl Render>) -> Markup {
    html! { tr { th scope="row" { (name) } @for cell in cells { td { (cell) } } } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_break_between_words() {
        assert_eq!(breakable("GotoRechargingStation, <B>").into_string(), "Goto<wbr>Recharging<wbr>Station, &lt;B&gt;");
        assert_eq!(breakable("stop.after_s").into_string(), "stop.<wbr>after_<wbr>s");
    }

    #[test]
    fn text_between_backticks_is_code_and_nothing_is_markup() {
        assert_eq!(prose("A told B `[<ok>]` & left").into_string(), "A told B <code>[&lt;ok&gt;]</code> &amp; left");
    }
}
