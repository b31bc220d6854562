//! Times, numbers and messages in words.

use std::time::Duration;

use channels::{Relation, Shape, Value};
use monitors::{EventTime, MessageCondition};

use recording::RunView;
pub(super) use recording::{decimals, length};

/// A time or duration, in seconds as everywhere else: `21.02 s`.
pub(super) fn time(time: Duration) -> String {
    format!("{} s", decimals(time.as_secs_f64(), 2))
}

/// A time of a run: of a recording with dates, with its time of day.
pub(super) fn moment(view: &RunView, at: Duration) -> String {
    match view.date(at) {
        Some(date) => format!("{} ({})", time(at), date.format("%H:%M:%S%.3f UTC")),
        None => time(at),
    }
}

/// A battery's level in percent, cut off after one decimal: one that violates `>= 20` must not look like 20.
pub(super) fn level(charge_pct: f64) -> String {
    let cut = (10.0 * charge_pct).floor() / 10.0;
    format!("{}{} %", decimals(cut, 1), if cut < charge_pct { "…" } else { "" })
}

/// The tick at which something happened, or its time if it is not known when the tree was ticked.
pub(super) fn tick(knows_ticks: bool, at: &EventTime) -> String {
    if knows_ticks { format!("tick {}", at.tick) } else { time(at.time) }
}

/// The same, always with its time.
pub(super) fn tick_and_time(knows_ticks: bool, at: &EventTime) -> String {
    if knows_ticks { format!("tick {} ({})", at.tick, time(at.time)) } else { time(at.time) }
}

/// A duration, roughly: `0.3 s`, `14 s`.
pub(super) fn roughly(seconds: f64) -> String {
    format!("{} s", decimals(seconds, if seconds < 10.0 { 1 } else { 0 }))
}

fn value(value: &Value) -> String {
    format!("{value:#}")
}

/// A message that a condition requires: as a message if the condition determines every field, otherwise the condition.
pub(super) fn wanted(condition: &MessageCondition, shapes: &[Shape]) -> String {
    let parts = match condition {
        MessageCondition::And(parts) => parts.as_slice(),
        other => std::slice::from_ref(other),
    };
    let field = |number: usize| {
        parts.iter().find_map(|part| match part {
            MessageCondition::Compare { field, relation: Relation::Equal, value } if field.number == number => {
                Some(value)
            }
            _ => None,
        })
    };
    let fields: Option<Vec<String>> = (1..=parts.len()).map(|number| field(number).map(value)).collect();
    fields.map_or_else(
        || format!("a message with {}", condition.text(shapes)),
        |fields| format!("[{}]", fields.join(", ")),
    )
}

/// A list as people write it: `a, b and c`.
pub(super) fn list(items: &[String]) -> String {
    match items {
        [] => "nothing".to_owned(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// A text that begins with a capital letter and ends with a period.
pub(super) fn sentence(text: &str) -> String {
    let text = text.trim();
    let mut characters = text.chars();
    let Some(first) = characters.next() else { return String::new() };
    let end = if text.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{}{}{end}", first.to_uppercase(), characters.as_str())
}

#[cfg(test)]
mod tests {
    use channels::FieldKind;
    use monitors::MessageField;

    use super::*;

    #[test]
    fn times_are_written_as_people_say_them() {
        let written = [0.02, 21.02, 120.0, 1483.94].map(|seconds| time(Duration::from_secs_f64(seconds)));
        assert_eq!(written, ["0.02 s", "21.02 s", "120 s", "1483.94 s"]);
        assert_eq!([0.25, 14.4, 1397.0].map(roughly), ["0.2 s", "14 s", "1397 s"]);
        assert_eq!([0.000_41, 0.292_1, 14.7644].map(length), ["0.4 mm", "0.29 m", "14.76 m"]);
    }

    #[test]
    fn levels_are_cut_off_as_the_numbers_of_messages_are() {
        assert_eq!([19.96, 9.962_000_000_000_021, 20.0, 19.9].map(level), ["19.9… %", "9.9… %", "20 %", "19.9 %"]);
    }

    #[test]
    fn a_condition_on_every_field_is_a_message() {
        let equals =
            |field: usize, value| MessageCondition::Compare { field: field.into(), relation: Relation::Equal, value };
        let start = [equals(1, Value::symbol("start_navigation")), equals(2, Value::symbol("RechargingStation"))];
        assert_eq!(wanted(&MessageCondition::And(start.to_vec()), &[]), "[<start_navigation>, <RechargingStation>]");
        assert_eq!(wanted(&equals(2, true.into()), &[]), "a message with m[2] = true");
        let answer = Shape::new([("status", FieldKind::symbols(["ok"])), ("at", FieldKind::Bool)]);
        assert_eq!(wanted(&equals(2, true.into()), std::slice::from_ref(&answer)), "a message with m[2] = true");
        let field = MessageField { number: 2, name: Some("at".into()), given: None };
        let named = MessageCondition::Compare { field, relation: Relation::Equal, value: true.into() };
        assert_eq!(wanted(&named, &[answer]), "a message with m.at = true");
    }

    #[test]
    fn sentences_begin_and_end_as_they_should() {
        assert_eq!(sentence("the level is never below 20 %"), "The level is never below 20 %.");
        assert_eq!(sentence("Done!"), "Done!");
        assert_eq!(list(&["a".into(), "b".into(), "c".into()]), "a, b and c");
    }
}
