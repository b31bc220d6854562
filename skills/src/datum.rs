//! The values of a machine's data model: those of ECMAScript, as plain data.

mod coerce;
mod error;
mod json;
mod memory;
mod xml;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

#[cfg(feature = "ecmascript")]
pub(crate) use coerce::Identity;
pub(crate) use coerce::{MAX_TEXT_BYTES, numeric};
pub(crate) use error::EvaluationError;
pub(crate) use memory::Memory;
#[cfg(feature = "ecmascript")]
pub(crate) use memory::Renewed;
#[cfg(feature = "ecmascript")]
pub(crate) use xml::describe_xml;
pub(crate) use xml::standalone;

/// A value of a machine's data model.
///
/// Copies are cheap: texts, arrays and objects are shared. A copy of an array or an object that is held outside a
/// machine never changes. Within one machine's data, two copies are the same object, as in ECMAScript.
///
/// `==` on this type means that two values are equal in every respect: a number equals another with the same bits,
/// including NaN. It is not the `==` of ECMAScript, which expressions use.
#[derive(Clone, Default)]
pub enum Datum {
    /// `undefined`
    #[default]
    Undefined,
    /// `null`
    Null,
    /// `true` or `false`
    Bool(bool),
    /// A number.
    Number(f64),
    /// A string.
    Text(Arc<str>),
    /// An array.
    Array(Arc<Array>),
    /// An object: members by name, in the order of their insertion.
    Object(Arc<Object>),
    /// A function, as its source. Only the cargo feature `ecmascript` can call it.
    Function(Arc<str>),
    /// One or more XML elements as stand-alone text: every element declares its namespace. Only the cargo feature
    /// `ecmascript` can look into it.
    Xml(Arc<str>),
}

/// The value would be nested too deeply or contain too many parts to be compared and hashed in reasonable time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a value may be nested at most {} deep and have at most {} parts", Extent::MAX_HEIGHT, Extent::MAX_WEIGHT)]
pub struct TooLarge;

impl Datum {
    /// The string.
    #[must_use]
    pub fn text(text: &str) -> Self {
        Self::Text(text.into())
    }

    /// The array of these values.
    ///
    /// # Errors
    /// [`TooLarge`] if the array would be nested more than 64 deep or have more than 100,000 parts.
    pub fn array(items: impl IntoIterator<Item = Self>) -> Result<Self, TooLarge> {
        Ok(Self::Array(Arc::new(Array::new(items.into_iter().collect())?)))
    }

    /// The object with these members. If a name occurs twice, the last value counts.
    ///
    /// # Errors
    /// [`TooLarge`] if the object would be nested more than 64 deep or have more than 100,000 parts.
    ///
    /// ```
    /// use skills::Datum;
    ///
    /// let data = Datum::object([("level", Datum::from(83.2))])?;
    /// assert_eq!(data.member("level"), Some(&Datum::Number(83.2)));
    /// assert_eq!(data.to_string(), r#"{"level": 83.2}"#);
    /// # Ok::<(), skills::TooLarge>(())
    /// ```
    pub fn object<N: Into<Arc<str>>>(members: impl IntoIterator<Item = (N, Self)>) -> Result<Self, TooLarge> {
        let mut object = Object::default();
        let mut places: BTreeMap<Arc<str>, usize> = BTreeMap::new();
        for (name, value) in members {
            let name: Arc<str> = name.into();
            match places.entry(Arc::clone(&name)) {
                Entry::Occupied(place) => object.members[*place.get()].1 = value,
                Entry::Vacant(place) => {
                    place.insert(object.members.len());
                    object.members.push((name, value));
                }
            }
        }
        object.extent = Extent::around(object.members.iter().map(|(_, value)| value))?;
        Ok(Self::Object(Arc::new(object)))
    }

    /// The number of bytes of its text or, for a value with parts, roughly the number that they represent.
    pub(crate) fn size(&self) -> usize {
        match self {
            Self::Text(text) | Self::Function(text) | Self::Xml(text) => text.len(),
            Self::Array(array) => array.extent.bytes(),
            Self::Object(object) => object.extent.bytes(),
            Self::Undefined | Self::Null | Self::Bool(_) | Self::Number(_) => 0,
        }
    }

    /// The member with this name, if the value is an object that has it.
    #[must_use]
    pub fn member(&self, name: &str) -> Option<&Self> {
        match self {
            Self::Object(object) => object.get(name),
            _ => None,
        }
    }
}

/// The items of an array.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub struct Array {
    items: Vec<Datum>,
    extent: Extent,
}

impl Array {
    fn new(items: Vec<Datum>) -> Result<Self, TooLarge> {
        let extent = Extent::around(items.iter())?;
        Ok(Self { items, extent })
    }

    /// The items in order.
    #[must_use]
    pub fn items(&self) -> &[Datum] {
        &self.items
    }

    /// The item at `index`. If there is none, the array grows to that length, with `undefined` in between.
    ///
    /// The extent is stale until [`Self::measure`] is called.
    pub(crate) fn item_mut(&mut self, index: usize) -> Result<&mut Datum, TooLarge> {
        if index >= Extent::MAX_WEIGHT as usize {
            return Err(TooLarge);
        }
        if index >= self.items.len() {
            self.items.resize(index + 1, Datum::Undefined);
        }
        Ok(&mut self.items[index])
    }

    /// Truncates the array, or extends it with `undefined`.
    pub(crate) fn set_length(&mut self, length: usize) -> Result<(), TooLarge> {
        if length > Extent::MAX_WEIGHT as usize {
            return Err(TooLarge);
        }
        self.items.resize(length, Datum::Undefined);
        self.measure()
    }

    pub(crate) fn measure(&mut self) -> Result<(), TooLarge> {
        self.extent = Extent::around(self.items.iter())?;
        Ok(())
    }
}

/// The members of an object.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub struct Object {
    members: Vec<(Arc<str>, Datum)>,
    extent: Extent,
}

impl Object {
    /// The member with this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Datum> {
        self.members.iter().find(|(known, _)| &**known == name).map(|(_, value)| value)
    }

    /// The number of members.
    pub(crate) fn len(&self) -> usize {
        self.members.len()
    }

    /// The members in the order of their insertion.
    pub fn members(&self) -> impl Iterator<Item = (&str, &Datum)> {
        self.members.iter().map(|(name, value)| (&**name, value))
    }

    /// The member with this name; if there is none, it is inserted as `undefined`.
    ///
    /// The extent is stale until [`Self::measure`] is called.
    pub(crate) fn member_mut(&mut self, name: &Arc<str>) -> &mut Datum {
        let index = self.members.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
            self.members.push((Arc::clone(name), Datum::Undefined));
            self.members.len() - 1
        });
        &mut self.members[index].1
    }

    pub(crate) fn measure(&mut self) -> Result<(), TooLarge> {
        self.extent = Extent::around(self.members.iter().map(|(_, value)| value))?;
        Ok(())
    }
}

/// The depth and size of a value, written as a tree.
///
/// A shared part counts each time that it occurs: `x = [x, x]` doubles a value at no cost in memory, but comparing or
/// hashing it would soon take forever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
struct Extent {
    height: u32,
    weight: u32,
}

impl Extent {
    const MAX_HEIGHT: u32 = 64;
    const MAX_WEIGHT: u32 = 100_000;
    const BYTES_PER_PART: usize = 64;

    fn bytes(self) -> usize {
        self.weight as usize * Self::BYTES_PER_PART
    }

    fn of(datum: &Datum) -> Self {
        match datum {
            Datum::Array(array) => array.extent,
            Datum::Object(object) => object.extent,
            Datum::Text(text) | Datum::Function(text) | Datum::Xml(text) => {
                let parts = u32::try_from(text.len() / Self::BYTES_PER_PART).unwrap_or(u32::MAX);
                Self { height: 0, weight: parts.saturating_add(1) }
            }
            Datum::Undefined | Datum::Null | Datum::Bool(_) | Datum::Number(_) => Self { height: 0, weight: 1 },
        }
    }

    fn around<'a>(parts: impl Iterator<Item = &'a Datum>) -> Result<Self, TooLarge> {
        let mut whole = Self { height: 0, weight: 1 };
        for part in parts.map(Self::of) {
            whole.height = whole.height.max(part.height);
            whole.weight = whole.weight.saturating_add(part.weight);
        }
        whole.height += 1;
        if whole.height > Self::MAX_HEIGHT || whole.weight > Self::MAX_WEIGHT { Err(TooLarge) } else { Ok(whole) }
    }
}

/// A number's bits, with one pattern for NaN.
fn number_bits(number: f64) -> u64 {
    if number.is_nan() { f64::NAN.to_bits() } else { number.to_bits() }
}

impl PartialEq for Datum {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Undefined, Self::Undefined) | (Self::Null, Self::Null) => true,
            (Self::Bool(a), Self::Bool(b)) => a == b,
            (Self::Number(a), Self::Number(b)) => number_bits(*a) == number_bits(*b),
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::Array(a), Self::Array(b)) => a == b,
            (Self::Object(a), Self::Object(b)) => a == b,
            (Self::Function(a), Self::Function(b)) | (Self::Xml(a), Self::Xml(b)) => a == b,
            _ => false,
        }
    }
}

impl Eq for Datum {}

impl Hash for Datum {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        match self {
            Self::Undefined | Self::Null => {}
            Self::Bool(truth) => truth.hash(state),
            Self::Number(number) => number_bits(*number).hash(state),
            Self::Text(text) | Self::Function(text) | Self::Xml(text) => text.hash(state),
            Self::Array(array) => array.hash(state),
            Self::Object(object) => object.hash(state),
        }
    }
}

/// As JSON, as far as JSON can express it.
impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => fmt::Debug::fmt(text, f),
            Self::Array(array) => f.debug_list().entries(&array.items).finish(),
            Self::Object(object) => f.debug_map().entries(object.members()).finish(),
            Self::Function(text) | Self::Xml(text) => f.write_str(text),
            Self::Undefined | Self::Null | Self::Bool(_) | Self::Number(_) => f.write_str(&self.to_text()),
        }
    }
}

impl fmt::Debug for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl From<bool> for Datum {
    fn from(truth: bool) -> Self {
        Self::Bool(truth)
    }
}

impl From<f64> for Datum {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Datum {
    fn from(text: &str) -> Self {
        Self::text(text)
    }
}

impl From<Arc<str>> for Datum {
    fn from(text: Arc<str>) -> Self {
        Self::Text(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_double_themselves_are_refused() {
        let mut value = Datum::from(1.0);
        let refused = (0..64).find(|_| match Datum::array([value.clone(), value.clone()]) {
            Ok(twice) => {
                value = twice;
                false
            }
            Err(TooLarge) => true,
        });
        assert_eq!(refused, Some(15), "2^15 times 3 parts fit, twice as many do not");
    }

    #[test]
    fn identity_is_by_bits_with_one_nan() {
        assert_eq!(Datum::from(f64::NAN), Datum::from(-f64::NAN));
        assert_ne!(Datum::from(0.0), Datum::from(-0.0), "1/x tells them apart");
        assert_ne!(Datum::Undefined, Datum::Null);
    }

    #[test]
    fn prints_as_json() {
        let list = Datum::array([Datum::Null, true.into(), "a\"b".into()]).unwrap();
        let object = Datum::object([("x", 1.0.into()), ("list", list), ("x", 2.5.into())]).unwrap();
        assert_eq!(object.to_string(), r#"{"x": 2.5, "list": [null, true, "a\"b"]}"#);
    }
}
