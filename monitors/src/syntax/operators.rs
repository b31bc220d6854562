//! The words and signs of the language, for help and reference.

/// A word or a sign of the language.
#[derive(Clone, Copy, Debug)]
pub struct Operator {
    /// How it is written.
    pub written: &'static str,
    /// Alternative spellings, separated by spaces.
    pub signs: &'static str,
    /// Its meaning, in a sentence or two.
    pub about: &'static str,
    /// An example, in which `E` and `F` stand for events.
    pub example: &'static str,
}

const fn word(written: &'static str, signs: &'static str, about: &'static str, example: &'static str) -> Operator {
    Operator { written, signs, about, example }
}

/// All words and signs of the language, with what they mean. The crate's documentation defines the semantics.
pub const OPERATORS: &[Operator] = &[
    word("property", "", "Begins a property: its name, `:=` or `≔`, and its formula.", "property phi := always E"),
    word(
        "timed",
        "",
        "Before `property`: durations are measured by the times at which messages and ticks occur, not by counting ticks.",
        "timed property phi := always (E implies time_until F < 300 ms)",
    ),
    word("const", "", "Begins a constant, which may stand for a value or a bound.", "const theta := 10"),
    word(
        "(P, Q, C)",
        "",
        "An event: the last message that the process Q received from P satisfies the condition C. Before the first \
         message it is false.",
        "always (BatteryReader, BatteryLevel, m[2] >= 20)",
    ),
    word(
        "(*, Q, C)",
        "",
        "Any sender: one of the events with each process whose messages to Q condition C can be about; one whose \
         messages never have a field or a value that C names is left out, also where C says `!=`. Likewise \
         `(P, *, C)`, for any receiver.",
        "always (E implies not (*, BatteryLevel, m[2] < 20))",
    ),
    word(
        "m[K]",
        "m.NAME NAME",
        "In a condition, field K of the message, counted from 1; or the field with this name, in the messages that have \
         it: in all others, only `!=` holds.",
        "always (BatteryReader, BatteryLevel, m.level >= 20)",
    ),
    word(
        "= != < <= > >=",
        "≠ ≤ ≥",
        "In a condition, compares a field with a number, `true`, `false`, a `\"string\"`, a `<symbol>`, another field \
         or a remembered value.",
        "eventually (BatteryReader, BatteryLevel, m[1] = <ok>)",
    ),
    word(
        "0.3 m/s",
        "",
        "A number with a unit is a number: in meters, m/s, rad or rad/s for m, cm, mm, km, m/s, km/h, rad, deg, rad/s and \
         deg/s, as ROS has them (km/h and degrees are rounded); unchanged for %, V, A, W, N, kg and Hz.",
        "always (BatteryReader, BatteryLevel, level >= 20 %)",
    ),
    word(
        "as",
        "",
        "In a condition, the message has the field, and its value gets a name. The rest of the formula in the same \
         state can compare with it, including its parts about the past or the future.",
        "always ((BatteryReader, BatteryLevel, level as l) implies next (BatteryReader, BatteryLevel, level <= l))",
    ),
    word(
        "+ - * /",
        "",
        "In a condition, arithmetic on fields, numbers and remembered values. A result that is no finite number, \
         as after a division by zero or of an infinite distance, compares like a missing field.",
        "always (BatteryReader, BatteryLevel, level / 100 <= 1)",
    ),
    word(
        "distance(X,Y,U,V)",
        "angle(A,B) yaw(X,Y,Z,W)",
        "In a condition, the distance between two points, the angle between two directions (0 to π), and the yaw of a \
         quaternion (−π to π), in the unit of the fields and in radians.",
        "always (World, Monitors, distance(x_m, y_m, 0, 0) < 5 m and angle(yaw_rad, 0) < 90 deg)",
    ),
    word(
        "any(C)",
        "all(C) count(C)",
        "In a condition, it holds for some item of a list, for every item, or for so many. In C, each list stands for \
         its item at the same place, up to the end of the longest. A message without these lists satisfies none of them.",
        "always (Laser, Monitor, all(ranges > 0.2) or count(ranges < 1 m) <= 3)",
    ),
    word("true", "⊤", "True of any message, at any time.", "always (BatteryReader, BatteryLevel, true)"),
    word("false", "⊥", "Never holds.", "always (E implies false)"),
    word("not", "¬ !", "The following does not hold.", "always not E"),
    word("and", "∧", "Both hold.", "always (E and F)"),
    word("or", "∨", "At least one of them holds.", "always (E or F)"),
    word("implies", "-> → ⇒", "If the first holds, so does the second.", "always (E implies F)"),
    word("always", "□", "It holds from now on, whenever one of its channels carries a message.", "always E"),
    word("eventually", "◇", "It holds now or at some later time.", "eventually E"),
    word("next", "○", "It holds at the next message on one of its channels.", "always (E implies next E)"),
    word("until", "", "The second holds now or later, and the first holds until then.", "not E until F"),
    word(
        "once",
        "",
        "It holds now, or held at some earlier time. After each past operator, `[<= 5 s]` limits how long ago: a \
         number \
         of ticks, a constant or a duration, after < <= = != >= or >.",
        "always (E implies once[<= 5 s] F)",
    ),
    word("historically", "", "It holds now, and held at all earlier times.", "always (E implies historically[< 10] F)"),
    word("previous", "", "It held the last time: at the previous message on one of its channels.", "always previous E"),
    word(
        "becomes",
        "",
        "It holds now and did not hold the last time: at the previous message on one of its channels. What holds at the \
         first message becomes so there.",
        "always (becomes E implies F)",
    ),
    word(
        "fresh",
        "",
        "The message that passes now satisfies the event. An event by itself holds until the next message on its channel.",
        "always (fresh E implies F)",
    ),
    word(
        "since",
        "",
        "The second holds now or held earlier, and the first has held ever since.",
        "always (E implies F since E)",
    ),
    word(
        "at most N E in T",
        "",
        "At most N messages have satisfied the event in the last T: a number of ticks, a constant or a duration.",
        "always at most 3 E in 10 s",
    ),
    word(
        "at least N E in T",
        "",
        "At least N messages have satisfied the event in the last T. `at least 0` is `true`.",
        "always (F implies at least 2 E in 10 s)",
    ),
    word(
        "time_until",
        "",
        "A message that satisfies the event passes now or later, after a number of ticks within the bound. The bound \
         is a number, a constant, or a duration in ms, s, min or h, after < <= = != >= or >.",
        "always (E implies time_until F < 30 s)",
    ),
];

#[cfg(test)]
mod tests {
    use super::super::token::{Keyword, SIGNS, TokenKind};
    use super::*;

    #[test]
    fn every_keyword_and_sign_is_explained() {
        let explained: Vec<&str> = OPERATORS
            .iter()
            .flat_map(|operator| operator.written.split(' ').chain(operator.signs.split(' ')))
            .collect();
        for keyword in Keyword::all() {
            assert!(explained.contains(&keyword.text()), "{}", keyword.text());
        }
        let is_operator = |kind: &TokenKind| matches!(kind, TokenKind::Keyword(_) | TokenKind::Relation(_));
        for (sign, _) in SIGNS.iter().filter(|(_, kind)| is_operator(kind)) {
            assert!(explained.contains(sign), "{sign}");
        }
    }
}
