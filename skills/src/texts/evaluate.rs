//! What an expression may be, as far as texts are concerned.

use channels::{Beyond, Possible};
use diagnostics::Problem;
use miette::SourceSpan;

use super::family::Family;
use super::trigger::Trigger;
use crate::expression::scan::words;
use crate::expression::{BinaryOp, Code, EventField, Expr, UnaryOp};
use crate::ids::DataId;
use crate::{Chart, Datum};

/// How to fix a machine that does too much with a text.
const WAY_OUT: &str = "compare it with other texts by `==` and `!=`, or test whether it is empty, and keep it in \
                       `<data>`; a proof tells texts apart only by that";

/// The results of `typeof`.
const TYPES: [&str; 6] = ["undefined", "object", "boolean", "number", "string", "function"];

/// One machine of the family, which is walked through.
pub(super) struct MachineWalk<'w, 'a> {
    pub(super) chart: &'a Chart,
    /// Its number in the family.
    pub(super) number: usize,
    pub(super) family: &'w mut Family<'a>,
}

impl<'a> MachineWalk<'_, 'a> {
    pub(super) fn held(&self, data: DataId) -> Possible {
        self.family.held(self.number, data)
    }

    /// Reports what the machine does with a chosen text.
    pub(super) fn refuse(&mut self, what: &str, place: SourceSpan) {
        let problem = Problem::new(format!("the machine {what}, which a proof cannot follow"));
        self.family.report(problem.of(self.chart.file()).at(place, "here").with_help(WAY_OUT));
    }

    /// Reports if this may be a chosen text: `what` is done with its name.
    pub(super) fn keep_out(&mut self, value: &Possible, what: impl FnOnce(&str) -> String, place: SourceSpan) {
        if value.has_choice() {
            let what = what(&self.family.names(value));
            self.refuse(&what, place);
        }
    }
}

/// What a constant may be.
pub(super) fn of_datum(value: &Datum) -> Possible {
    match value {
        Datum::Undefined | Datum::Null => Possible::default(),
        Datum::Bool(_) | Datum::Number(_) => Possible::number(),
        Datum::Text(text) => Possible::texts([text.clone()]),
        Datum::Array(array) => array.items().iter().map(of_datum).collect::<Possible>().around(),
        Datum::Object(object) => object.members().map(|(_, value)| of_datum(value)).collect::<Possible>().around(),
        Datum::Function(_) | Datum::Xml(_) => Possible::open(),
    }
}

impl MachineWalk<'_, '_> {
    /// What the expression may be. What it does with chosen texts is noted.
    pub(super) fn value(&mut self, expr: &Expr, trigger: &Trigger<'_>, place: SourceSpan) -> Possible {
        match expr {
            Expr::Constant(value) => of_datum(value),
            Expr::Data(data) => self.held(*data),
            Expr::Unknown(_) | Expr::Broken(_) => Possible::default(),
            Expr::Foreign(code) => {
                let touched = self.touched(code, trigger);
                self.keep_out(&touched, |name| format!("uses {name} in code for the engine"), place);
                Possible::anything()
            }
            Expr::Event => [self.family.fields(trigger, None).around(), Possible::open()].into_iter().collect(),
            Expr::EventField(EventField::Data) => self.family.fields(trigger, None).around(),
            Expr::EventField(EventField::Raw) => {
                let all = self.family.fields(trigger, None);
                self.keep_out(&all, |name| format!("looks at an event with {name} as a text"), place);
                Possible::open()
            }
            Expr::EventField(_) | Expr::SessionId | Expr::IoProcessors => Possible::open(),
            Expr::MachineName => Possible::texts([self.chart.name()]),
            Expr::Member(of, name) => self.member(of, name, trigger, place),
            Expr::Index(parts) => match &parts[1] {
                Expr::Constant(Datum::Text(name)) => self.member(&parts[0], name, trigger, place),
                index => {
                    let index = self.value(index, trigger, place);
                    self.keep_out(&index, |name| format!("takes the name of a member from {name}"), place);
                    let mut of = self.value(&parts[0], trigger, place);
                    let direct = Possible { chosen: std::mem::take(&mut of.chosen), ..Possible::default() };
                    self.keep_out(&direct, |name| format!("looks into {name}"), place);
                    // A letter of a text, or a part of a structure.
                    if of.depth == 0 && !of.texts.is_empty() {
                        of.join(&Possible::open());
                    }
                    of.part()
                }
            },
            Expr::Unary(op, operand) => {
                let operand = self.value(operand, trigger, place);
                match op {
                    // Whether it is empty.
                    UnaryOp::Not => Possible::number(),
                    UnaryOp::TypeOf => Possible::texts(TYPES),
                    UnaryOp::Void => Possible::default(),
                    UnaryOp::Minus | UnaryOp::Plus | UnaryOp::BitNot => {
                        self.keep_out(&operand, |name| format!("computes with {name}"), place);
                        Possible::number()
                    }
                }
            }
            Expr::Binary(op, parts) => {
                let (left, right) = (self.value(&parts[0], trigger, place), self.value(&parts[1], trigger, place));
                let value = binary(self, *op, &left, &right, place);
                if *op == BinaryOp::Add && is_literal(&parts[0]) && is_literal(&parts[1]) {
                    return joined(&left, &right);
                }
                value
            }
            Expr::Logic(_, parts) => parts.iter().map(|part| self.value(part, trigger, place)).collect(),
            Expr::Choice(parts) => {
                self.value(&parts[0], trigger, place);
                parts[1..].iter().map(|part| self.value(part, trigger, place)).collect()
            }
            Expr::In(_) => Possible::number(),
            Expr::InDynamic(id) => {
                let id = self.value(id, trigger, place);
                self.keep_out(&id, |name| format!("takes the name of a state from {name}"), place);
                Possible::number()
            }
            Expr::Array(items) => {
                items.iter().map(|item| self.value(item, trigger, place)).collect::<Possible>().around()
            }
            Expr::Object(members) => {
                members.iter().map(|(_, value)| self.value(value, trigger, place)).collect::<Possible>().around()
            }
        }
    }

    fn member(&mut self, of: &Expr, name: &str, trigger: &Trigger<'_>, place: SourceSpan) -> Possible {
        if matches!(of, Expr::EventField(EventField::Data)) {
            return self.family.fields(trigger, Some(name));
        }
        let mut of = self.value(of, trigger, place);
        if name == "length" {
            let direct = Possible { chosen: of.chosen.clone(), ..Possible::default() };
            self.keep_out(&direct, |name| format!("takes the length of {name}"), place);
            return Possible::number();
        }
        of.chosen.clear();
        of.part()
    }

    /// The chosen texts that code for the engine may see.
    fn touched(&self, code: &Code, trigger: &Trigger<'_>) -> Possible {
        let mut touched: Possible = code.mentions.iter().map(|data| self.held(*data)).collect();
        if code.mentions_event {
            // A function that it calls may read the event, which is then in the code of that function.
            let sees_all = code.program.split("_event").skip(1).any(|rest| !names_a_field(rest));
            if sees_all {
                touched.join(&self.family.fields(trigger, None));
            }
            words(&code.program).for_each(|word| _ = touched.join(&self.family.fields(trigger, Some(word))));
        }
        touched
    }
}

/// Whether `_event` is followed by a field of it, and by one of its data.
fn names_a_field(rest: &str) -> bool {
    let Some(rest) = rest.trim_start().strip_prefix('.') else { return false };
    match rest.trim_start().strip_prefix("data") {
        Some(rest) => rest.trim_start().starts_with('.'),
        None => !rest.trim_start().starts_with("raw"),
    }
}

/// The result of an operator on these.
pub(super) fn binary(
    walk: &mut MachineWalk<'_, '_>,
    op: BinaryOp,
    left: &Possible,
    right: &Possible,
    place: SourceSpan,
) -> Possible {
    use BinaryOp::{Add, Equal, Greater, GreaterEqual, Identical, Less, LessEqual, NotEqual, NotIdentical};
    match op {
        Equal | NotEqual | Identical | NotIdentical => {
            let converts = matches!(op, Equal | NotEqual);
            if let Err(beyond) = walk.family.comparisons.compare(left, right, converts) {
                let mut both = left.clone();
                both.join(right);
                let what = |name: &str| match beyond {
                    Beyond::Open => format!("compares {name} with a text that is computed"),
                    Beyond::Number => format!("compares {name} with a number"),
                    Beyond::Structure => format!("compares a list or an object that has {name} in it"),
                };
                walk.keep_out(&both, what, place);
            }
            Possible::number()
        }
        Less | LessEqual | Greater | GreaterEqual => {
            [left, right].into_iter().for_each(|side| {
                walk.keep_out(side, |name| format!("compares {name} by order"), place);
            });
            Possible::number()
        }
        _ => {
            for side in [left, right] {
                walk.keep_out(side, |name| format!("computes with {name}"), place);
            }
            if op == Add { sum(left, right) } else { Possible::number() }
        }
    }
}

/// With more texts than this on both sides together, their sums are open.
const MOST_SUMS: usize = 64;

/// The sum of anything: numbers are added, and texts joined.
fn sum(left: &Possible, right: &Possible) -> Possible {
    let has_text = |side: &Possible| side.is_open || !side.texts.is_empty() || side.has_choice() || side.depth > 0;
    if has_text(left) || has_text(right) { Possible::anything() } else { Possible::number() }
}

/// The sum of literal texts.
fn joined(left: &Possible, right: &Possible) -> Possible {
    if left.texts.len() * right.texts.len() > MOST_SUMS {
        return Possible::open();
    }
    Possible::texts(left.texts.iter().flat_map(|a| right.texts.iter().map(move |b| format!("{a}{b}"))))
}

/// Whether the expression is a text, or one of several, whatever the data are.
fn is_literal(expr: &Expr) -> bool {
    match expr {
        Expr::Constant(Datum::Text(_)) => true,
        Expr::Binary(BinaryOp::Add, parts) => parts.iter().all(is_literal),
        Expr::Choice(parts) => parts[1..].iter().all(is_literal),
        _ => false,
    }
}
