//! Conversion between data and the engine's values. Two copies of an object are one object in both.

use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use rquickjs::object::{Filter, Property};
use rquickjs::{Array, Ctx, Function, Object, Type, Value};

use super::builtins::Tools;
use super::failure::Failure;
use super::reading::readable;
use crate::datum::EvaluationError;
use crate::datum::{Identity, MAX_TEXT_BYTES, Renewed, describe_xml};
use crate::{Datum, TooLarge};

/// The maximum nesting of values in the engine; slightly more than for data.
const MAX_DEPTH: usize = 70;
/// The maximum number of parts of a value, as for data.
const MAX_PARTS: usize = 100_000;
/// The part of a DOM that XML data need (SCXML B.2.1).
const ELEMENTS: &str = include_str!("elements.js");

/// Puts data into the engine.
pub(super) struct Injector<'e, 'js> {
    ctx: &'e Ctx<'js>,
    tools: &'e Tools<'js>,
    made: BTreeMap<Identity, Value<'js>>,
    /// The objects that were put in, and their original data.
    originals: Vec<(Value<'js>, Datum)>,
    /// Makes an object that can be read like an element from its description.
    make_element: OnceCell<Function<'js>>,
}

impl<'e, 'js> Injector<'e, 'js> {
    pub(super) fn new(ctx: &'e Ctx<'js>, tools: &'e Tools<'js>) -> Self {
        Self { ctx, tools, made: BTreeMap::new(), originals: Vec::new(), make_element: OnceCell::new() }
    }

    pub(super) fn inject(&mut self, value: &Datum) -> Result<Value<'js>, Failure> {
        let ctx = self.ctx.clone();
        let identity = match value {
            Datum::Undefined => return Ok(Value::new_undefined(ctx)),
            Datum::Null => return Ok(Value::new_null(ctx)),
            Datum::Bool(truth) => return Ok(Value::new_bool(ctx, *truth)),
            Datum::Number(number) => return Ok(Value::new_float(ctx, *number)),
            Datum::Text(text) => return Ok(rquickjs::String::from_str(ctx, text)?.into_value()),
            Datum::Array(_) | Datum::Object(_) | Datum::Function(_) | Datum::Xml(_) => value.identity(),
        };
        if let Some(made) = identity.and_then(|identity| self.made.get(&identity)) {
            return Ok(made.clone());
        }
        let object = self.make(value)?;
        if let Some(identity) = identity {
            self.made.insert(identity, object.clone());
        }
        self.originals.push((object.clone(), value.clone()));
        Ok(object)
    }

    fn make(&mut self, value: &Datum) -> Result<Value<'js>, Failure> {
        let ctx = self.ctx.clone();
        match value {
            Datum::Array(array) => {
                let made = Array::new(ctx)?;
                for (index, item) in array.items().iter().enumerate() {
                    made.set(index, self.inject(item)?)?;
                }
                Ok(made.into_value())
            }
            Datum::Object(members) => {
                let object = Object::new(ctx)?;
                for (name, value) in members.members() {
                    let value = self.inject(value)?;
                    object.prop(name, Property::from(value).writable().enumerable().configurable())?;
                }
                Ok(object.into_value())
            }
            Datum::Function(source) => Ok(self.ctx.eval(format!("({})()", function_program(source)))?),
            Datum::Xml(source) => {
                // The description is no datum: its own injector keeps it apart from the objects to be read back.
                let description = describe_xml(source)?;
                let description = Self::new(self.ctx, self.tools).inject(&description)?;
                let make = match self.make_element.get() {
                    Some(make) => make.clone(),
                    None => {
                        let make: Function<'js> = self.ctx.eval(ELEMENTS)?;
                        self.make_element.get_or_init(|| make).clone()
                    }
                };
                Ok(make.call((description,))?)
            }
            _ => Err(unkept("an object without parts").into()),
        }
    }

    pub(super) fn objects(&self) -> impl Iterator<Item = &Value<'js>> {
        self.originals.iter().map(|(object, _)| object)
    }
}

fn function_program(source: &str) -> String {
    format!("function(){{'use strict';return (\n{source}\n)}}")
}

fn unkept(what: &str) -> EvaluationError {
    EvaluationError::Thrown(format!("{what} cannot be kept in data"))
}

/// Takes data out of the engine. Unchanged data come back as they were.
pub(super) struct Extractor<'e, 'js> {
    tools: &'e Tools<'js>,
    originals: HashMap<Value<'js>, Datum>,
    read: HashMap<Value<'js>, Datum>,
    renewed: Renewed,
    depth: usize,
    parts: usize,
}

impl<'e, 'js> Extractor<'e, 'js> {
    pub(super) fn new(tools: &'e Tools<'js>, injector: &Injector<'_, 'js>) -> Self {
        let originals = injector.originals.iter().cloned().collect();
        Self { tools, originals, read: HashMap::new(), renewed: Renewed::new(), depth: 0, parts: 0 }
    }

    /// The replacements of objects that have changed.
    pub(super) fn into_renewed(self) -> Renewed {
        self.renewed
    }

    pub(super) fn read(&mut self, value: &Value<'js>) -> Result<Datum, Failure> {
        Ok(match value.type_of() {
            Type::Undefined | Type::Uninitialized => Datum::Undefined,
            Type::Null => Datum::Null,
            Type::Bool => value.as_bool().unwrap_or_default().into(),
            Type::Int | Type::Float => value.as_number().unwrap_or(f64::NAN).into(),
            Type::String => Datum::text(&self.text(value)?),
            Type::BigInt => return Err(unkept("a BigInt").into()),
            Type::Symbol => return Err(unkept("a symbol").into()),
            _ => match value.as_object() {
                Some(object) => self.object(value, object)?,
                None => return Err(unkept("a value of this kind").into()),
            },
        })
    }

    /// A string; invalid characters become U+FFFD.
    fn text(&self, value: &Value<'js>) -> Result<String, Failure> {
        let text = match value.get::<String>() {
            Err(rquickjs::Error::Utf8(_)) => self.tools.well_formed.call((value.clone(),))?,
            text => text?,
        };
        if text.len() > MAX_TEXT_BYTES { Err(EvaluationError::LongText.into()) } else { Ok(text) }
    }

    fn object(&mut self, value: &Value<'js>, object: &Object<'js>) -> Result<Datum, Failure> {
        if let Some(known) = self.read.get(value) {
            return Ok(known.clone());
        }
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(TooLarge.into());
        }
        let original = self.originals.get(value).cloned();
        let result = match original {
            Some(fixed @ (Datum::Function(_) | Datum::Xml(_))) => fixed,
            Some(original) => {
                let now = self.composite(object)?;
                if is_same(&original, &now) {
                    original
                } else {
                    // Whatever else holds the object gets the new one, too (`Memory::renew`).
                    self.renewed.extend(original.identity().map(|identity| (identity, now.clone())));
                    now
                }
            }
            None => self.composite(object)?,
        };
        self.depth -= 1;
        self.read.insert(value.clone(), result.clone());
        Ok(result)
    }

    fn composite(&mut self, object: &Object<'js>) -> Result<Datum, Failure> {
        match self.tools.kind.call::<_, i32>((object.clone(),))? {
            0 => self.members(object),
            1 => self.function(object),
            2 => self.array(object),
            3 => {
                let source: Value<'js> = object.get("outerXML")?;
                Ok(Datum::Xml(self.text(&source)?.into()))
            }
            4 => {
                let text: Value<'js> = self.tools.text.call((object.clone(),))?;
                self.read(&text)
            }
            5 => Err(unkept("a Date, only its number `getTime()` or its text `toISOString()`,").into()),
            _ => Err(unkept("an object of this class").into()),
        }
    }

    fn array(&mut self, object: &Object<'js>) -> Result<Datum, Failure> {
        let length: f64 = object.get("length")?;
        self.count(length as usize)?;
        let mut items = Vec::with_capacity(length as usize);
        for index in 0..length as u32 {
            let item: Value<'js> = object.get(index)?;
            items.push(self.read(&item)?);
        }
        Ok(Datum::array(items)?)
    }

    fn members(&mut self, object: &Object<'js>) -> Result<Datum, Failure> {
        let keys = object.own_keys::<Value<'js>>(Filter::new().string().enum_only());
        let keys: Vec<Value<'js>> = keys.collect::<Result<_, _>>()?;
        self.count(keys.len())?;
        let mut members: Vec<(Arc<str>, Datum)> = Vec::with_capacity(keys.len());
        for key in keys {
            let value: Value<'js> = object.get(key.clone())?;
            members.push((self.text(&key)?.into(), self.read(&value)?));
        }
        Ok(Datum::object(members)?)
    }

    fn count(&mut self, parts: usize) -> Result<(), Failure> {
        self.parts = self.parts.saturating_add(parts);
        if self.parts > MAX_PARTS { Err(TooLarge.into()) } else { Ok(()) }
    }

    /// The source of a function. The source of a method is converted to that of a function.
    fn function(&self, object: &Object<'js>) -> Result<Datum, Failure> {
        let source: Value<'js> = self.tools.source.call((object.clone(),))?;
        let source = self.text(&source)?;
        for candidate in [source.clone(), format!("function {source}")] {
            if readable(&format!("({})", function_program(&candidate))).is_ok() {
                return Ok(Datum::Function(candidate.into()));
            }
        }
        Err(unkept("a built-in function").into())
    }
}

/// Whether an object still has its original parts: the same objects, and equal values otherwise.
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
