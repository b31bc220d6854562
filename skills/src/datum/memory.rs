//! The data of a machine, in which two copies of an object are one object.

use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::sync::Arc;

use super::coerce::Identity;
use super::{Datum, EvaluationError, TooLarge};
use crate::ids::DataId;

/// The contents of a machine's data, by index.
///
/// After `b = a; a.x = 1`, `b.x` has changed as well if `a` is an object: every datum that holds the object sees the
/// change. Objects are immutable underneath, so a copy of the memory is a full copy; a change creates a new object and
/// puts it wherever the old one was. Two memories are equal if their data are equal and, in both,
/// the same data are one object. Objects that contain themselves cannot be created.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    slots: Vec<Datum>,
}

/// Replaced objects, with their replacements.
pub(crate) type Renewed = BTreeMap<Identity, Datum>;

impl Memory {
    /// This many data, all undefined.
    pub(crate) fn new(count: usize) -> Self {
        Self { slots: vec![Datum::Undefined; count] }
    }

    pub(crate) fn set(&mut self, data: DataId, value: Datum) {
        self.slots[data.index()] = value;
    }

    /// Stores a value in the part of a datum that the keys lead to. A failure changes nothing.
    pub(crate) fn put(&mut self, data: DataId, keys: &[Arc<str>], value: Datum) -> Result<(), EvaluationError> {
        let Some((key, way)) = keys.split_last() else {
            self.set(data, value);
            return Ok(());
        };
        let slot = &mut self.slots[data.index()];
        // One number more or less never makes a value too large, so this cannot fail halfway.
        if matches!(value, Datum::Undefined | Datum::Null | Datum::Bool(_) | Datum::Number(_))
            && is_unshared(slot, keys)
        {
            return put(slot, keys, value);
        }
        let holder = way.iter().try_fold(&self.slots[data.index()], |holder, key| item(holder, key))?;
        if value.is_composite() && contains(&value, holder.identity()) {
            return Err(EvaluationError::NotAssignable("an object, inside itself,".to_owned()));
        }
        let mut changed = holder.clone();
        put(&mut changed, std::slice::from_ref(key), value)?;
        let renewed = holder.identity().map(|holder| (holder, changed)).into_iter().collect();
        self.renew(renewed)
    }

    /// Puts new objects wherever the old ones are.
    pub(crate) fn renew(&mut self, mut renewed: Renewed) -> Result<(), EvaluationError> {
        let slots: Result<Vec<Datum>, TooLarge> = self.slots.iter().map(|slot| renew(slot, &mut renewed)).collect();
        self.slots = slots?;
        Ok(())
    }

    /// Which objects are the same: for each object, in the order of the walk, where it was first seen.
    fn pattern(&self) -> Vec<usize> {
        let (mut seen, mut pattern) = (BTreeMap::new(), Vec::new());
        self.slots.iter().for_each(|slot| note_pattern(slot, &mut seen, &mut pattern));
        pattern
    }
}

impl Deref for Memory {
    type Target = [Datum];

    fn deref(&self) -> &[Datum] {
        &self.slots
    }
}

impl PartialEq for Memory {
    fn eq(&self, other: &Self) -> bool {
        self.slots == other.slots && (!self.slots.iter().any(Datum::is_composite) || self.pattern() == other.pattern())
    }
}

impl Eq for Memory {}

impl Hash for Memory {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.slots.hash(state);
    }
}

fn note_pattern(value: &Datum, seen: &mut BTreeMap<Identity, usize>, pattern: &mut Vec<usize>) {
    let Some(identity) = value.identity() else {
        return;
    };
    let next = seen.len();
    let first = *seen.entry(identity).or_insert(next);
    pattern.push(first);
    if first == next {
        parts(value).for_each(|part| note_pattern(part, seen, pattern));
    }
}

/// The items of an array or the values of an object.
fn parts(value: &Datum) -> Box<dyn Iterator<Item = &Datum> + '_> {
    match value {
        Datum::Array(array) => Box::new(array.items().iter()),
        Datum::Object(object) => Box::new(object.members().map(|(_, value)| value)),
        _ => Box::new(std::iter::empty()),
    }
}

fn contains(value: &Datum, object: Option<Identity>) -> bool {
    object.is_some() && (value.identity() == object || parts(value).any(|part| contains(part, object)))
}

/// Whether the keys lead to an existing part and nothing else holds any of the objects along the way, so that they can
/// be changed in place.
fn is_unshared(slot: &mut Datum, keys: &[Arc<str>]) -> bool {
    let Some((key, rest)) = keys.split_first() else {
        return true;
    };
    let inner = match slot {
        Datum::Array(array) => {
            let place = key.parse::<usize>().ok();
            Arc::get_mut(array).zip(place).and_then(|(array, place)| array.items.get_mut(place))
        }
        Datum::Object(object) => {
            let members = Arc::get_mut(object).map(|object| &mut object.members);
            let member = members.and_then(|members| members.iter_mut().find(|(name, _)| name == key));
            member.map(|(_, value)| value)
        }
        _ => None,
    };
    inner.is_some_and(|inner| is_unshared(inner, rest))
}

/// The part that a key leads to.
fn item<'a>(holder: &'a Datum, key: &Arc<str>) -> Result<&'a Datum, EvaluationError> {
    static NOTHING: Datum = Datum::Undefined;
    let found = match holder {
        Datum::Object(object) => object.get(key),
        Datum::Array(array) => key.parse::<usize>().ok().and_then(|place| array.items().get(place)),
        other => return Err(not_assignable(key, other)),
    };
    Ok(found.unwrap_or(&NOTHING))
}

fn not_assignable(key: &str, holder: &Datum) -> EvaluationError {
    EvaluationError::NotAssignable(format!("the member {key} of {}", holder.type_name()))
}

/// Stores a value in the part of `target` that the keys lead to.
fn put(target: &mut Datum, keys: &[Arc<str>], value: Datum) -> Result<(), EvaluationError> {
    let Some((key, rest)) = keys.split_first() else {
        *target = value;
        return Ok(());
    };
    match target {
        Datum::Object(object) => {
            let object = Arc::make_mut(object);
            put(object.member_mut(key), rest, value)?;
            // Only now is it known whether it is too large. The caller has made a copy, which is then dropped.
            object.measure()?;
        }
        Datum::Array(array) if &**key == "length" && rest.is_empty() => {
            let length = match value {
                Datum::Number(number) if number >= 0.0 && number.fract() == 0.0 => Some(number as usize),
                _ => None,
            };
            let unfit = || EvaluationError::NotAssignable("this length of an array".to_owned());
            Arc::make_mut(array).set_length(length.ok_or_else(unfit)?)?;
        }
        Datum::Array(array) => {
            let index =
                key.parse().map_err(|_| EvaluationError::NotAssignable(format!("the item {key} of an array")))?;
            let array = Arc::make_mut(array);
            put(array.item_mut(index)?, rest, value)?;
            array.measure()?;
        }
        other => return Err(not_assignable(key, other)),
    }
    Ok(())
}

/// The value with new objects instead of the old ones. Objects around them that had to be recreated are added to
/// `renewed`.
fn renew(value: &Datum, renewed: &mut Renewed) -> Result<Datum, TooLarge> {
    let Some(identity) = value.identity() else {
        return Ok(value.clone());
    };
    if let Some(known) = renewed.get(&identity) {
        return Ok(known.clone());
    }
    let result = match value {
        Datum::Array(array) => {
            let items: Vec<Datum> = array.items().iter().map(|item| renew(item, renewed)).collect::<Result<_, _>>()?;
            // An object without a change inside remains the same object for all that hold it.
            if same(array.items().iter(), items.iter()) { value.clone() } else { Datum::array(items)? }
        }
        Datum::Object(object) => {
            let members: Vec<(Arc<str>, Datum)> = object
                .members
                .iter()
                .map(|(name, value)| Ok((Arc::clone(name), renew(value, renewed)?)))
                .collect::<Result<_, TooLarge>>()?;
            let unchanged = same(object.members().map(|(_, value)| value), members.iter().map(|(_, value)| value));
            if unchanged { value.clone() } else { Datum::object(members)? }
        }
        other => other.clone(),
    };
    renewed.insert(identity, result.clone());
    Ok(result)
}

fn same<'a>(old: impl Iterator<Item = &'a Datum>, new: impl Iterator<Item = &'a Datum>) -> bool {
    old.zip(new).all(|(old, new)| old.identity() == new.identity())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(name: &str) -> Arc<str> {
        name.into()
    }

    fn two() -> (Memory, DataId, DataId) {
        let mut memory = Memory::new(2);
        let (a, b) = (DataId::new(0), DataId::new(1));
        let inner = Datum::object([("x", Datum::from(1.0))]).unwrap();
        memory.set(a, Datum::object([("inner", inner.clone())]).unwrap());
        memory.set(b, inner);
        (memory, a, b)
    }

    #[test]
    fn every_holder_of_an_object_sees_it_change() {
        let (mut memory, a, b) = two();
        memory.put(a, &[key("inner"), key("x")], 2.0.into()).unwrap();
        assert_eq!(memory[b.index()].to_string(), r#"{"x": 2}"#);
        memory.put(b, &[key("y")], 3.0.into()).unwrap();
        assert_eq!(memory[0].to_string(), r#"{"inner": {"x": 2, "y": 3}}"#);
        assert!(memory[0].member("inner").unwrap().identical(&memory[1]));
    }

    #[test]
    fn a_copy_of_the_memory_is_independent() {
        let (mut memory, _, b) = two();
        let copy = memory.clone();
        memory.put(b, &[key("x")], 9.0.into()).unwrap();
        assert_eq!(copy[0].to_string(), r#"{"inner": {"x": 1}}"#);
        assert!(copy[0].member("inner").unwrap().identical(&copy[1]));
        assert_ne!(memory, copy);
    }

    #[test]
    fn two_names_for_one_object_make_a_different_memory() {
        let (memory, _, b) = two();
        let mut other = memory.clone();
        assert_eq!(memory, other);
        other.set(b, Datum::object([("x", Datum::from(1.0))]).unwrap());
        assert_ne!(memory, other);
    }

    #[test]
    fn no_object_can_contain_itself() {
        let (mut memory, a, b) = two();
        let (whole, before) = (memory[0].clone(), memory.clone());
        assert!(memory.put(a, &[key("self")], whole.clone()).is_err());
        assert!(memory.put(b, &[key("outer")], whole).is_err());
        assert_eq!(memory, before);
    }
}
