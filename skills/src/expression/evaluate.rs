//! Evaluating a compiled expression.

use std::sync::{Arc, OnceLock};

use super::location::Access;
use super::{BinaryOp, EventField, Expr, Location, LogicOp, UnaryOp};
use crate::bit_set::BitSet;
use crate::datum::{EvaluationError, MAX_TEXT_BYTES};
use crate::ids::Identifiers;
use crate::steps::Steps;
use crate::{Datum, Event};

type Result<T> = std::result::Result<T, EvaluationError>;

/// The environment that an expression can see.
#[derive(Clone, Copy, Default)]
pub(crate) struct Scope<'a> {
    pub(crate) ids: Option<&'a Identifiers>,
    pub(crate) session: &'a str,
    pub(crate) configuration: Option<&'a BitSet>,
    pub(crate) data: &'a [Datum],
    pub(crate) event: Option<&'a Event>,
    /// `_event` as an object, created on first use: it is the same object until the next event.
    pub(crate) event_object: Option<&'a OnceLock<Datum>>,
    pub(crate) io_processors: Option<&'a Datum>,
    /// The budget of steps.
    pub(crate) steps: Option<&'a Steps>,
}

impl Scope<'_> {
    /// `_event`; undefined before the first event.
    pub(crate) fn whole_event(&self) -> Result<Datum> {
        if self.event.is_none() {
            return Ok(Datum::Undefined);
        }
        if let Some(known) = self.event_object.and_then(OnceLock::get) {
            return Ok(known.clone());
        }
        let fields = EventField::ALL.map(|(name, field)| event_field(field, self).map(|value| (name, value)));
        let fields: Vec<_> = fields.into_iter().collect::<Result<_>>()?;
        let object = Datum::object(fields)?;
        Ok(match self.event_object {
            Some(cell) => cell.get_or_init(|| object).clone(),
            None => object,
        })
    }

    /// Counts the steps for handling a value.
    fn weigh(&self, value: &Datum) -> Result<()> {
        self.take_size(value.size())
    }

    fn take_size(&self, size: usize) -> Result<()> {
        self.steps.map_or(Ok(()), |steps| steps.take_size(size))
    }

    fn is_active(&self, state: usize) -> bool {
        self.configuration.is_some_and(|active| active.contains(state))
    }

    fn is_active_id(&self, id: &str) -> bool {
        let state = self.ids.and_then(|ids| ids.find_state(id));
        state.is_some_and(|state| self.is_active(state.index()))
    }
}

impl Location {
    /// The evaluated member names that lead from the datum to the location.
    pub(crate) fn keys(&self, scope: &Scope<'_>) -> Result<Vec<Arc<str>>> {
        let key = |access: &Access| match access {
            Access::Member(name) => Ok(Arc::clone(name)),
            Access::Index(index) => Ok(index.evaluate(scope)?.to_text()),
        };
        self.path.iter().map(key).collect()
    }
}

impl Expr {
    /// The expression's value.
    pub(crate) fn evaluate(&self, scope: &Scope<'_>) -> Result<Datum> {
        Ok(match self {
            Self::Constant(_) | Self::Data(_) | Self::Member(..) | Self::EventField(EventField::Data) => {
                match self.place(scope)? {
                    Some(place) => place.clone(),
                    None => self.computed_member(scope)?,
                }
            }
            Self::Unknown(name) => return Err(EvaluationError::Unknown(Arc::clone(name))),
            Self::Broken(reason) => return Err(EvaluationError::Broken(Arc::clone(reason))),
            Self::Foreign(_) => return Err(EvaluationError::Broken("only an engine can evaluate this".into())),
            Self::Event => scope.whole_event()?,
            Self::EventField(field) => event_field(*field, scope)?,
            Self::MachineName => scope.ids.map_or(Datum::Undefined, |ids| Datum::text(&ids.machine)),
            Self::SessionId => Datum::text(scope.session),
            Self::IoProcessors => scope.io_processors.cloned().unwrap_or_default(),
            // An operation takes as long as its operands are large, so their sizes count against the budget.
            Self::Index(parts) => {
                let [value, index] = &**parts;
                let value = value.evaluate(scope)?;
                let index = index.evaluate(scope)?;
                scope.weigh(&value)?;
                member_of(&value, &index.to_primitive())?
            }
            Self::Unary(op, operand) => {
                let operand = operand.evaluate(scope)?;
                scope.weigh(&operand)?;
                unary(*op, &operand)
            }
            Self::Binary(op, parts) => {
                let (left, right) = (parts[0].evaluate(scope)?, parts[1].evaluate(scope)?);
                scope.weigh(&left)?;
                scope.weigh(&right)?;
                binary(*op, &left, &right)?
            }
            Self::Logic(op, parts) => {
                let left = parts[0].evaluate(scope)?;
                if is_settled(*op, &left) { left } else { parts[1].evaluate(scope)? }
            }
            Self::Choice(parts) => {
                let chosen = if parts[0].truth(scope)? { 1 } else { 2 };
                parts[chosen].evaluate(scope)?
            }
            Self::In(state) => scope.is_active(state.index()).into(),
            Self::InDynamic(id) => scope.is_active_id(&id.evaluate(scope)?.to_text()).into(),
            Self::Array(items) => array(items, scope)?,
            Self::Object(members) => object(members, scope)?,
        })
    }

    /// The expression as a condition.
    pub(crate) fn truth(&self, scope: &Scope<'_>) -> Result<bool> {
        match self {
            Self::In(state) => Ok(scope.is_active(state.index())),
            Self::Unary(UnaryOp::Not, operand) => operand.truth(scope).map(|truth| !truth),
            _ => Ok(self.evaluate(scope)?.truthy()),
        }
    }

    /// The value in place, without a copy, if it is stored somewhere.
    fn place<'a>(&'a self, scope: &Scope<'a>) -> Result<Option<&'a Datum>> {
        match self {
            Self::Constant(value) => Ok(Some(value)),
            Self::Data(id) => Ok(scope.data.get(id.index())),
            Self::EventField(EventField::Data) => Ok(Some(&current_event(scope, "data")?.data)),
            Self::Member(value, name) => Ok(match value.place(scope)? {
                // A missing member is looked up again more carefully.
                Some(Datum::Object(object)) => {
                    scope.take_size(object.len())?;
                    object.get(name)
                }
                _ => None,
            }),
            _ => Ok(None),
        }
    }

    fn computed_member(&self, scope: &Scope<'_>) -> Result<Datum> {
        match self {
            Self::Member(value, name) => {
                let value = value.evaluate(scope)?;
                scope.weigh(&value)?;
                member_of(&value, &Datum::Text(Arc::clone(name)))
            }
            _ => Ok(Datum::Undefined),
        }
    }
}

fn array(items: &[Expr], scope: &Scope<'_>) -> Result<Datum> {
    let items: Vec<Datum> = items.iter().map(|item| item.evaluate(scope)).collect::<Result<_>>()?;
    Ok(Datum::array(items)?)
}

fn object(members: &[(Arc<str>, Expr)], scope: &Scope<'_>) -> Result<Datum> {
    let evaluate = |(name, value): &(Arc<str>, Expr)| Ok((Arc::clone(name), value.evaluate(scope)?));
    let members: Vec<(Arc<str>, Datum)> = members.iter().map(evaluate).collect::<Result<_>>()?;
    Ok(Datum::object(members)?)
}

fn is_settled(op: LogicOp, left: &Datum) -> bool {
    match op {
        LogicOp::And => !left.truthy(),
        LogicOp::Or => left.truthy(),
        LogicOp::Coalesce => !matches!(left, Datum::Undefined | Datum::Null),
    }
}

fn current_event<'a>(scope: &Scope<'a>, field: &str) -> Result<&'a Event> {
    scope.event.ok_or_else(|| EvaluationError::NoMembers {
        value: "_event, which is undefined before the first event,",
        member: field.into(),
    })
}

fn event_field(field: EventField, scope: &Scope<'_>) -> Result<Datum> {
    let optional =
        |text: &Option<Arc<str>>| text.as_ref().map_or(Datum::Undefined, |text| Datum::Text(Arc::clone(text)));
    let event = current_event(scope, "that name")?;
    Ok(match field {
        EventField::Name => Datum::Text(Arc::clone(&event.name)),
        EventField::Type => event.kind.name().into(),
        EventField::SendId => optional(&event.send_id),
        EventField::Origin => optional(&event.origin),
        EventField::OriginType => optional(&event.origin_type),
        EventField::InvokeId => optional(&event.invoke_id),
        EventField::Data => event.data.clone(),
        EventField::Raw => Datum::text(&event.raw()),
    })
}

/// `value[key]` (ECMA-262, 13.3.2).
fn member_of(value: &Datum, key: &Datum) -> Result<Datum> {
    let length = |count: usize| Datum::Number(count as f64);
    Ok(match (value, key) {
        (Datum::Undefined | Datum::Null, key) => {
            let value = if matches!(value, Datum::Null) { "null" } else { "undefined" };
            return Err(EvaluationError::NoMembers { value, member: key.to_text() });
        }
        (Datum::Object(object), key) => {
            let name = key.to_text();
            match object.get(&name) {
                Some(value) => value.clone(),
                None => return missing(&name),
            }
        }
        (Datum::Array(array), Datum::Text(name)) if &**name == "length" => length(array.items().len()),
        (Datum::Text(text), Datum::Text(name)) if &**name == "length" => length(text.encode_utf16().count()),
        (Datum::Array(array), key) => {
            let item = |index| Ok(array.items().get(index).cloned().unwrap_or_default());
            return index(key).map_or_else(|| missing(&key.to_text()), item);
        }
        (Datum::Text(text), key) => {
            // ECMAScript counts in units of UTF-16. Half of a pair is no character, and becomes U+FFFD.
            let letter = |index| {
                let unit = text.encode_utf16().nth(index);
                Ok(unit.map_or(Datum::Undefined, |unit| Datum::text(&String::from_utf16_lossy(&[unit]))))
            };
            return index(key).map_or_else(|| missing(&key.to_text()), letter);
        }
        (Datum::Bool(_) | Datum::Number(_) | Datum::Function(_) | Datum::Xml(_), key) => {
            return missing(&key.to_text());
        }
    })
}

/// The index that a key represents: a whole number, or a string in the form of one.
fn index(key: &Datum) -> Option<usize> {
    match key {
        Datum::Number(number) if *number >= 0.0 && number.fract() == 0.0 => Some(*number as usize),
        Datum::Text(text) => text.parse().ok().filter(|index: &usize| index.to_string() == **text),
        _ => None,
    }
}

/// A member that a value does not have itself: undefined, or inherited, which only an engine has.
fn missing(name: &str) -> Result<Datum> {
    if super::vocabulary::is_inherited(name) {
        Err(EvaluationError::Inherited(name.into()))
    } else {
        Ok(Datum::Undefined)
    }
}

fn unary(op: UnaryOp, operand: &Datum) -> Datum {
    match op {
        UnaryOp::Not => (!operand.truthy()).into(),
        UnaryOp::Minus => (-operand.to_number()).into(),
        UnaryOp::Plus => operand.to_number().into(),
        UnaryOp::BitNot => f64::from(!to_int32(operand)).into(),
        UnaryOp::TypeOf => operand.type_name().into(),
        UnaryOp::Void => Datum::Undefined,
    }
}

/// The value of `left op right`.
pub(crate) fn binary(op: BinaryOp, left: &Datum, right: &Datum) -> Result<Datum> {
    use std::cmp::Ordering::{Equal, Greater, Less};
    let (a, b) = (left, right);
    let numbers = || (a.to_number(), b.to_number());
    Ok(match op {
        BinaryOp::Add => return add(a, b),
        BinaryOp::Subtract => (numbers().0 - numbers().1).into(),
        BinaryOp::Multiply => (numbers().0 * numbers().1).into(),
        BinaryOp::Divide => (numbers().0 / numbers().1).into(),
        BinaryOp::Remainder => (numbers().0 % numbers().1).into(),
        BinaryOp::Less => (a.order(b) == Some(Less)).into(),
        BinaryOp::LessEqual => matches!(a.order(b), Some(Less | Equal)).into(),
        BinaryOp::Greater => (a.order(b) == Some(Greater)).into(),
        BinaryOp::GreaterEqual => matches!(a.order(b), Some(Greater | Equal)).into(),
        BinaryOp::Equal => a.equal(b).into(),
        BinaryOp::NotEqual => (!a.equal(b)).into(),
        BinaryOp::Identical => a.identical(b).into(),
        BinaryOp::NotIdentical => (!a.identical(b)).into(),
        BinaryOp::BitAnd => f64::from(to_int32(a) & to_int32(b)).into(),
        BinaryOp::BitOr => f64::from(to_int32(a) | to_int32(b)).into(),
        BinaryOp::BitXor => f64::from(to_int32(a) ^ to_int32(b)).into(),
        // Only the lower five bits of a shift count (ECMA-262, 6.1.6.1.9), as in `wrapping_shl` of 32 bits.
        BinaryOp::ShiftLeft => f64::from(to_int32(a).wrapping_shl(to_uint32(b))).into(),
        BinaryOp::ShiftRight => f64::from(to_int32(a).wrapping_shr(to_uint32(b))).into(),
        BinaryOp::ShiftRightUnsigned => f64::from(to_uint32(a).wrapping_shr(to_uint32(b))).into(),
    })
}

fn add(left: &Datum, right: &Datum) -> Result<Datum> {
    if let (Datum::Number(a), Datum::Number(b)) = (left, right) {
        return Ok((a + b).into());
    }
    match (left.to_primitive(), right.to_primitive()) {
        (a, b) if matches!(a, Datum::Text(_)) || matches!(b, Datum::Text(_)) => {
            let (a, b) = (a.to_text(), b.to_text());
            if a.len() + b.len() > MAX_TEXT_BYTES {
                return Err(EvaluationError::LongText);
            }
            Ok(Datum::text(&[a, b].concat()))
        }
        (a, b) => Ok((a.to_number() + b.to_number()).into()),
    }
}

/// ToUint32 (ECMA-262, 7.1.7): modulo 2^32, and 0 for values that are not finite.
fn to_uint32(value: &Datum) -> u32 {
    const RANGE: f64 = 4_294_967_296.0;
    let number = value.to_number();
    if number.is_finite() { number.trunc().rem_euclid(RANGE) as u32 } else { 0 }
}

/// ToInt32 (ECMA-262, 7.1.6).
fn to_int32(value: &Datum) -> i32 {
    to_uint32(value).cast_signed()
}

#[cfg(test)]
mod tests {
    use super::super::{Names, expression};
    use super::*;
    use crate::ids::DataId;

    fn value(source: &str) -> Datum {
        let mut names = Names::default();
        for (index, name) in ["x", "list", "thing"].into_iter().enumerate() {
            names.data.insert(name.to_owned(), DataId::new(index));
        }
        let list = Datum::array([10.0.into(), 20.0.into()]).unwrap();
        let thing = Datum::object([("a", Datum::from(1.0)), ("inner", Datum::object([("b", "deep".into())]).unwrap())])
            .unwrap();
        let data = [Datum::Undefined, list, thing];
        let parsed = expression(source, &names);
        let expr = parsed.outcome.unwrap_or_else(|problem| panic!("{source}: {problem:?}"));
        expr.evaluate(&Scope { data: &data, ..Scope::default() })
            .unwrap_or_else(|error| Datum::text(&error.to_string()))
    }

    #[test]
    fn operators_bind_as_in_ecmascript() {
        let cases = [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("10 - 4 - 3", 3.0),
            ("-2 * -3", 6.0),
            ("- 2 - 3", -5.0),
            ("7 % 4", 3.0),
            ("-7 % 4", -3.0),
            ("1 < 2 ? 3 : 4", 3.0),
            ("false ? 1 : true ? 2 : 3", 2.0),
            ("1 + 2 << 3", 24.0),
            ("-1 >>> 28", 15.0),
            ("5 & 3 | 8", 9.0),
            ("~5", -6.0),
            ("null ?? 4", 4.0),
            ("0 || 5", 5.0),
            ("1 && 6", 6.0),
            ("list[1]", 20.0),
            ("list.length", 2.0),
            ("thing.a + thing['a']", 2.0),
            ("'5' * '2'", 10.0),
            ("+'0x10'", 16.0),
        ];
        for (source, number) in cases {
            assert_eq!(value(source), number.into(), "{source}");
        }
    }

    #[test]
    fn truth_values_follow_ecmascript() {
        let truths = [
            ("undefined > 30", false),
            ("undefined <= 30", false),
            ("undefined == null", true),
            ("undefined === null", false),
            ("NaN == NaN", false),
            ("'a' < 'b'", true),
            ("'10' < '9'", true),
            ("'10' < 9", false),
            ("'' == 0", true),
            ("!x", true),
            ("!!list", true),
            ("1 !== '1'", true),
            ("1 != '1'", false),
            ("x === undefined", true),
            ("typeof nothing === 'undefined'", true),
            ("1 < 2 === true", true),
            ("thing.inner.b === 'deep'", true),
            ("In('nowhere')", false),
        ];
        for (source, truth) in truths {
            assert_eq!(value(source), truth.into(), "{source}");
        }
    }

    #[test]
    fn plus_concatenates_if_one_side_is_a_string() {
        for (source, text) in
            [("1 + '2'", "12"), ("'a' + null", "anull"), ("1 + 2 + 'b'", "3b"), ("list + ''", "10,20")]
        {
            assert_eq!(value(source), text.into(), "{source}");
        }
        assert_eq!(value("1 + null"), 1.0.into());
        assert_eq!(value("typeof (1 + undefined)"), "number".into());
    }

    #[test]
    fn an_expression_without_a_value_says_why() {
        assert_eq!(value("x.y"), "undefined has no member y".into());
        assert_eq!(value("nothing"), "nothing is not defined".into());
        assert_eq!(value("list == thing"), false.into());
        assert_eq!(value("list === list"), true.into());
        assert_eq!(value("thing.missing"), Datum::Undefined);
        assert_eq!(value("_event"), Datum::Undefined);
    }
}
