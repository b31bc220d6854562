//! Between data and the engine's values. Two copies of an object are one object there as they are in the data.

use std::collections::BTreeMap;
use std::sync::Arc;

use boa_engine::object::builtins::JsArray;
use boa_engine::property::PropertyKey;
use boa_engine::{JsObject, JsString, JsValue, JsVariant};

use super::{Engine, Failure};
use crate::datum::{Identity, MAX_TEXT_BYTES, Renewed, describe_xml};
use crate::expression::EvaluationError;
use crate::{Datum, TooLarge};

/// Values may be nested so deeply in the engine; a little more than data may.
const MAX_DEPTH: usize = 70;
/// A value may have so many parts.
const MAX_PARTS: usize = 100_000;

/// Puts data into the engine.
#[derive(Default)]
pub(super) struct Injector {
    made: BTreeMap<Identity, JsObject>,
    /// The objects that were put in, and what they were.
    originals: Vec<(JsObject, Datum)>,
}

impl Injector {
    pub(super) fn inject(&mut self, value: &Datum, engine: &mut Engine) -> Result<JsValue, Failure> {
        let identity = match value {
            Datum::Undefined => return Ok(JsValue::undefined()),
            Datum::Null => return Ok(JsValue::null()),
            Datum::Bool(truth) => return Ok(JsValue::from(*truth)),
            Datum::Number(number) => return Ok(JsValue::from(*number)),
            Datum::Text(text) => return Ok(JsValue::from(JsString::from(&**text))),
            Datum::Array(_) | Datum::Object(_) | Datum::Function(_) | Datum::Xml(_) => value.identity(),
        };
        if let Some(made) = identity.and_then(|identity| self.made.get(&identity)) {
            return Ok(JsValue::from(made.clone()));
        }
        let object = self.make(value, engine)?;
        if let Some(identity) = identity {
            self.made.insert(identity, object.clone());
        }
        self.originals.push((object.clone(), value.clone()));
        Ok(JsValue::from(object))
    }

    fn make(&mut self, value: &Datum, engine: &mut Engine) -> Result<JsObject, Failure> {
        match value {
            Datum::Array(array) => {
                let items: Vec<JsValue> =
                    array.items().iter().map(|item| self.inject(item, engine)).collect::<Result<_, _>>()?;
                Ok(JsArray::from_iter(items, &mut engine.context).into())
            }
            Datum::Object(members) => {
                let object = JsObject::with_object_proto(engine.context.intrinsics());
                for (name, value) in members.members() {
                    let value = self.inject(value, engine)?;
                    object.create_data_property_or_throw(JsString::from(name), value, &mut engine.context)?;
                }
                Ok(object)
            }
            Datum::Function(source) => {
                let program: Arc<str> = function_program(source).into();
                let function = engine.program(&program)?.evaluate(&mut engine.context)?;
                function.as_object().ok_or_else(|| Failure::from(unkept("what is no function")))
            }
            Datum::Xml(source) => {
                let description = describe_xml(source)?;
                let description = Self::default().inject(&description, engine)?;
                let make = engine.make_element.clone();
                let element = make.call(&JsValue::undefined(), &[description], &mut engine.context)?;
                element.as_object().ok_or_else(|| Failure::from(unkept("what is no element")))
            }
            _ => Err(unkept("what has no parts").into()),
        }
    }

    pub(super) fn objects(&self) -> Vec<JsObject> {
        self.originals.iter().map(|(object, _)| object.clone()).collect()
    }
}

fn function_program(source: &str) -> String {
    format!("(function(){{'use strict';return (\n{source}\n)}})()")
}

/// Where an object lies: it tells it from all others as long as they all live.
fn address(object: &JsObject) -> usize {
    std::ptr::from_ref(&*object.borrow()).cast::<()>().addr()
}

fn unkept(what: &str) -> EvaluationError {
    EvaluationError::Thrown(format!("{what} cannot be kept in data"))
}

/// Takes data out of the engine. What was put in and has not changed comes back as it was.
pub(super) struct Reader {
    originals: BTreeMap<usize, Datum>,
    read: BTreeMap<usize, Datum>,
    renewed: Renewed,
    depth: usize,
    parts: usize,
}

impl Reader {
    pub(super) fn new(injector: &Injector) -> Self {
        let originals = injector.originals.iter().map(|(object, value)| (address(object), value.clone())).collect();
        Self { originals, read: BTreeMap::new(), renewed: Renewed::new(), depth: 0, parts: 0 }
    }

    /// What is to be put in place of objects that have changed.
    pub(super) fn into_renewed(self) -> Renewed {
        self.renewed
    }

    pub(super) fn read(&mut self, value: &JsValue, engine: &mut Engine) -> Result<Datum, Failure> {
        Ok(match value.variant() {
            JsVariant::Undefined => Datum::Undefined,
            JsVariant::Null => Datum::Null,
            JsVariant::Boolean(truth) => truth.into(),
            JsVariant::Integer32(number) => f64::from(number).into(),
            JsVariant::Float64(number) => number.into(),
            JsVariant::String(text) => self.text(&text)?,
            JsVariant::BigInt(_) => return Err(unkept("a BigInt").into()),
            JsVariant::Symbol(_) => return Err(unkept("a symbol").into()),
            JsVariant::Object(object) => self.object(&object, engine)?,
        })
    }

    fn text(&mut self, text: &JsString) -> Result<Datum, Failure> {
        let text = text.to_std_string_lossy();
        if text.len() > MAX_TEXT_BYTES {
            return Err(EvaluationError::LongText.into());
        }
        Ok(Datum::text(&text))
    }

    fn object(&mut self, object: &JsObject, engine: &mut Engine) -> Result<Datum, Failure> {
        let address = address(object);
        if let Some(known) = self.read.get(&address) {
            return Ok(known.clone());
        }
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(EvaluationError::TooLarge(TooLarge).into());
        }
        let original = self.originals.get(&address).cloned();
        let result = match original {
            Some(fixed @ (Datum::Function(_) | Datum::Xml(_))) => fixed,
            Some(original) => {
                let now = self.composite(object, engine)?;
                if is_same(&original, &now) {
                    original
                } else {
                    self.renewed.extend(original.identity().map(|identity| (identity, now.clone())));
                    now
                }
            }
            None => self.composite(object, engine)?,
        };
        self.depth -= 1;
        self.read.insert(address, result.clone());
        Ok(result)
    }

    fn composite(&mut self, object: &JsObject, engine: &mut Engine) -> Result<Datum, Failure> {
        if object.is_callable() {
            return function_source(object, engine);
        }
        if object.is_array() {
            return self.array(object, engine);
        }
        let outer = object.get(JsString::from("outerXML"), &mut engine.context)?;
        if let Some(source) = outer.as_string() {
            return Ok(Datum::Xml(source.to_std_string_lossy().into()));
        }
        if object.is_ordinary() {
            return self.members(object, engine);
        }
        let to_json = object.get(JsString::from("toJSON"), &mut engine.context)?;
        match to_json.as_callable() {
            Some(to_json) => {
                let value = to_json.call(&JsValue::from(object.clone()), &[], &mut engine.context)?;
                self.read(&value, engine)
            }
            None if object.is::<boa_engine::builtins::error::Error>() => {
                let text = JsValue::from(object.clone()).to_string(&mut engine.context)?;
                self.text(&text)
            }
            None => Err(unkept("an object of this class").into()),
        }
    }

    fn array(&mut self, object: &JsObject, engine: &mut Engine) -> Result<Datum, Failure> {
        let array = JsArray::from_object(object.clone())?;
        let length = usize::try_from(array.length(&mut engine.context)?).unwrap_or(usize::MAX);
        self.count(length)?;
        let mut items = Vec::with_capacity(length);
        for index in 0..length {
            let item = array.get(index as u32, &mut engine.context)?;
            items.push(self.read(&item, engine)?);
        }
        Ok(Datum::array(items).map_err(EvaluationError::from)?)
    }

    fn members(&mut self, object: &JsObject, engine: &mut Engine) -> Result<Datum, Failure> {
        let keys = object.own_property_keys(&mut engine.context)?;
        self.count(keys.len())?;
        let mut members: Vec<(Arc<str>, Datum)> = Vec::with_capacity(keys.len());
        for key in keys {
            let name = match &key {
                PropertyKey::String(name) => name.to_std_string_lossy(),
                PropertyKey::Index(index) => index.get().to_string(),
                PropertyKey::Symbol(_) => continue,
            };
            let is_enumerable =
                object.borrow().properties().get(&key).is_some_and(|own| own.enumerable().unwrap_or(false));
            if is_enumerable {
                let value = object.get(key, &mut engine.context)?;
                members.push((name.into(), self.read(&value, engine)?));
            }
        }
        Ok(Datum::object(members).map_err(EvaluationError::from)?)
    }

    fn count(&mut self, parts: usize) -> Result<(), Failure> {
        self.parts = self.parts.saturating_add(parts);
        if self.parts > MAX_PARTS { Err(EvaluationError::TooLarge(TooLarge).into()) } else { Ok(()) }
    }
}

/// Whether an object still has the parts that it had: the same objects, and equal values otherwise.
fn is_same(one: &Datum, other: &Datum) -> bool {
    let part = |a: &Datum, b: &Datum| if a.is_composite() { a.identity() == b.identity() } else { a == b };
    match (one, other) {
        (Datum::Array(a), Datum::Array(b)) => {
            a.items().len() == b.items().len() && a.items().iter().zip(b.items()).all(|(a, b)| part(a, b))
        }
        (Datum::Object(a), Datum::Object(b)) => {
            a.members().count() == b.members().count()
                && a.members().zip(b.members()).all(|((name, a), (other, b))| name == other && part(a, b))
        }
        _ => false,
    }
}

/// The source of a function. A method's is made that of a function.
fn function_source(object: &JsObject, engine: &mut Engine) -> Result<Datum, Failure> {
    let prototype = engine.context.intrinsics().constructors().function().prototype();
    let to_string = prototype.get(JsString::from("toString"), &mut engine.context)?;
    let Some(to_string) = to_string.as_callable() else {
        return Err(unkept("this function").into());
    };
    let source = to_string.call(&JsValue::from(object.clone()), &[], &mut engine.context)?;
    let source = source.to_string(&mut engine.context)?.to_std_string_lossy();
    for candidate in [source.clone(), format!("function {source}")] {
        if engine.read(&function_program(&candidate)).is_ok() {
            return Ok(Datum::Function(candidate.into()));
        }
    }
    Err(unkept("a function of the engine's").into())
}

impl From<TooLarge> for Failure {
    fn from(error: TooLarge) -> Self {
        Self::Failed(EvaluationError::TooLarge(error))
    }
}
