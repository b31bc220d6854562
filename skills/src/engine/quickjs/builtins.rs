//! Replacements for what depends on the computer: time, random numbers, and the last bits of a sine.

use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

use rquickjs::function::{Opt, Rest};
use rquickjs::object::Property;
use rquickjs::{Coerced, Ctx, Error, Function, Object, Value};

use super::World;
use crate::expression::Scope;
use crate::random;

/// The total work that the built-in functions of an evaluation may do, roughly in nanoseconds: a second. Chosen,
/// not measured.
const ALLOWANCE: f64 = 1e9;

/// Counts what the engine's functions do, and replaces those that depend on the machine.
const BUILTINS: &str = include_str!("builtins.js");

/// The operations on values that the host requires of the engine.
pub(super) struct Tools<'js> {
    pub(super) freeze: Function<'js>,
    pub(super) kind: Function<'js>,
    pub(super) source: Function<'js>,
    pub(super) text: Function<'js>,
    pub(super) well_formed: Function<'js>,
}

type Unary = fn(f64) -> f64;

/// Functions of one number.
const UNARY: [(&str, Unary); 19] = [
    ("acos", libm::acos),
    ("acosh", libm::acosh),
    ("asin", libm::asin),
    ("asinh", libm::asinh),
    ("atan", libm::atan),
    ("atanh", libm::atanh),
    ("cbrt", libm::cbrt),
    ("cos", libm::cos),
    ("cosh", libm::cosh),
    ("exp", libm::exp),
    ("expm1", libm::expm1),
    ("log", libm::log),
    ("log10", libm::log10),
    ("log1p", libm::log1p),
    ("log2", libm::log2),
    ("sin", libm::sin),
    ("sinh", libm::sinh),
    ("tan", libm::tan),
    ("tanh", libm::tanh),
];

/// Gives the engine the time of the run, `In`, the functions of libm and a sequence of random numbers.
pub(super) fn install<'js>(ctx: &Ctx<'js>, world: &World<'_>, random: &Rc<Cell<u64>>) -> Result<Tools<'js>, Error> {
    let global = ctx.globals();
    let math: Object<'js> = global.get("Math")?;
    for (name, function) in UNARY {
        let call = move |ctx: Ctx<'js>, x: Number| float(ctx, function(number(&x)));
        method(&math, name, Function::new(ctx.clone(), call)?)?;
    }
    let arctangent = |ctx: Ctx<'js>, y: Number, x: Number| float(ctx, libm::atan2(number(&y), number(&x)));
    method(&math, "atan2", Function::new(ctx.clone(), arctangent)?)?;
    let raised = |ctx: Ctx<'js>, base: Number, exponent: Number| float(ctx, power(number(&base), number(&exponent)));
    method(&math, "pow", Function::new(ctx.clone(), raised)?)?;
    let length = |ctx: Ctx<'js>, sides: Rest<Coerced<f64>>| {
        float(ctx, sides.0.iter().fold(0.0, |sum, side| libm::hypot(sum, side.0)))
    };
    method(&math, "hypot", Function::new(ctx.clone(), length)?)?;
    let state = Rc::clone(random);
    method(&math, "random", Function::new(ctx.clone(), move || next_random(&state))?)?;

    // A missing argument is `undefined`, which `In` reads as the id of a state like any other string.
    let active = active_states(world.scope);
    let is_active = move |id: Opt<Coerced<String>>| {
        active.iter().any(|active| Some(&**active) == id.0.as_ref().map_or(Some("undefined"), |id| Some(&*id.0)))
    };
    method(&global, "In", Function::new(ctx.clone(), is_active)?)?;

    let begin: Function<'js> = ctx.eval(BUILTINS)?;
    let now = world.now.as_millis() as f64;
    let tools: Object<'js> = begin.call((now, ALLOWANCE))?;
    Ok(Tools {
        freeze: tools.get("freeze")?,
        kind: tools.get("kind")?,
        source: tools.get("source")?,
        text: tools.get("text")?,
        well_formed: tools.get("wellFormed")?,
    })
}

type Number = Opt<Coerced<f64>>;

fn number(given: &Number) -> f64 {
    given.0.as_ref().map_or(f64::NAN, |number| number.0)
}

/// A number unchanged: rquickjs would convert a whole number to an integer and lose the sign of -0.
fn float(ctx: Ctx<'_>, number: f64) -> Value<'_> {
    Value::new_float(ctx, number)
}

fn method<'js>(object: &Object<'js>, name: &str, function: Function<'js>) -> Result<(), Error> {
    object.prop(name, Property::from(function.with_name(name)?).writable().configurable())
}

fn active_states(scope: Scope<'_>) -> Vec<Arc<str>> {
    let active = scope.ids.into_iter().flat_map(|ids| {
        let states = scope.configuration.into_iter().flat_map(|configuration| configuration.iter());
        states.filter_map(|state| ids.state(state)).map(Arc::clone)
    });
    active.collect()
}

fn next_random(position: &Cell<u64>) -> f64 {
    let mut next = position.get();
    let number = random::next(&mut next);
    position.set(next);
    number
}

/// `Math.pow` differs slightly from C's (ECMA-262, Number::exponentiate).
fn power(base: f64, exponent: f64) -> f64 {
    if exponent.is_nan() || base.abs() == 1.0 && exponent.is_infinite() { f64::NAN } else { libm::pow(base, exponent) }
}
