//! Small pieces of HTML.

use drawing::Verdict;
use drawing::icons::Look;
use monitors::Outcome;

use super::figure::sign;

pub use drawing::canvas::escape;

/// A text set as code.
pub(super) fn code(text: &str) -> String {
    format!("<code>{}</code>", escape(text))
}

/// A text for people: escaped, and with no line's end between a number and its percent sign.
pub fn text(text: &str) -> String {
    escape(text).replace(" %", "&nbsp;%")
}

/// A name that may be broken between the words that it is made of.
pub(super) fn breakable(name: &str) -> String {
    let mut markup = String::new();
    let mut before = ' ';
    for character in name.chars() {
        if character.is_uppercase() && before.is_lowercase() {
            markup.push_str("<wbr>");
        }
        markup.push_str(&escape(character.encode_utf8(&mut [0; 4])));
        before = character;
    }
    markup
}

/// Words in which `backticks` enclose code; everything else is escaped.
pub(super) fn prose(words: &str) -> String {
    let parts = words.split('`').enumerate();
    parts.map(|(index, part)| if index % 2 == 1 { code(part) } else { self::text(part) }).collect()
}

/// What came of a property as pictures know it.
pub(super) fn verdict_of(outcome: Outcome) -> Verdict {
    match outcome {
        Outcome::Violated => Verdict::Violated,
        Outcome::Satisfied => Verdict::Satisfied,
        Outcome::Inconclusive => Verdict::Inconclusive,
    }
}

/// The sign of a verdict on its ground.
pub(super) fn verdict_sign(verdict: Verdict, side: f64) -> String {
    let look = Look::of_verdict(verdict);
    sign(side, |canvas, center| {
        canvas.circle(center, side / 2.0, drawing::canvas::Paint::fill(look.ground));
        look.icon.draw(canvas, center, side * 0.62, look.front);
    })
}

/// A verdict with its sign, as a label.
pub(super) fn pill(outcome: Outcome) -> String {
    let look = Look::of_verdict(verdict_of(outcome));
    let icon = sign(14.0, |canvas, center| look.icon.draw(canvas, center, 13.0, look.front));
    format!("<span class=\"pill {outcome}\">{icon}{outcome}</span>")
}

/// A row of a table: the first cell names it.
pub(super) fn row(name: &str, cells: &[String]) -> String {
    let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
    format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_break_between_words() {
        assert_eq!(breakable("GotoRechargingStation, <B>"), "Goto<wbr>Recharging<wbr>Station, &lt;B&gt;");
    }

    #[test]
    fn what_is_written_between_backticks_is_code_and_nothing_is_markup() {
        assert_eq!(prose("A told B `[<ok>]` & left"), "A told B <code>[&lt;ok&gt;]</code> &amp; left");
    }
}
