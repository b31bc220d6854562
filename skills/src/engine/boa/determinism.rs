//! What the engine would otherwise ask the machine that it runs on: time, chance, and the last bits of a sine.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use boa_engine::context::HostHooks;
use boa_engine::context::time::{Clock, JsInstant};
use boa_engine::object::FunctionObjectBuilder;
use boa_engine::property::Attribute;
use boa_engine::realm::Realm;
use boa_engine::{Context, JsNativeError, JsResult, JsString, JsValue, NativeFunction, js_string};

use crate::expression::Scope;

/// Simulated time, counted from 1970.
#[derive(Debug, Default)]
pub(super) struct SimulatedClock(Cell<Duration>);

impl SimulatedClock {
    pub(super) fn set(&self, now: Duration) {
        self.0.set(now);
    }
}

impl Clock for SimulatedClock {
    fn now(&self) -> JsInstant {
        JsInstant::new(self.0.get().as_secs(), self.0.get().subsec_nanos())
    }

    fn system_time_millis(&self) -> i64 {
        i64::try_from(self.0.get().as_millis()).unwrap_or(i64::MAX)
    }
}

/// The engine is nowhere: its time zone is UTC. It compiles no text that a program has put together.
#[derive(Debug)]
pub(super) struct Nowhere;

impl HostHooks for Nowhere {
    fn local_timezone_offset_seconds(&self, _: i64) -> i32 {
        0
    }

    fn ensure_can_compile_strings(
        &self,
        _: Realm,
        _: &[JsString],
        _: &JsString,
        _: bool,
        _: &mut Context,
    ) -> JsResult<()> {
        Err(JsNativeError::eval().with_message("text cannot be run as code").into())
    }

    fn max_buffer_size(&self, _: &mut Context) -> u64 {
        1 << 20
    }
}

thread_local! {
    static RANDOM: Cell<u64> = const { Cell::new(0) };
    static ACTIVE: RefCell<BTreeSet<Arc<str>>> = const { RefCell::new(BTreeSet::new()) };
}

pub(super) fn set_random(state: u64) {
    RANDOM.set(state);
}

pub(super) fn random_state() -> u64 {
    RANDOM.get()
}

/// Tells `In` which states are active.
pub(super) fn set_active(scope: Scope<'_>) {
    let active = scope.chart.into_iter().flat_map(|chart| {
        let states = scope.configuration.into_iter().flat_map(|configuration| configuration.iter());
        states.filter_map(|state| chart.states.get(state)).map(|state| Arc::clone(&state.id))
    });
    ACTIVE.set(active.collect());
}

/// SplitMix64 (Steele, Lea and Flood, 2014): a number in [0, 1) of 53 bits.
fn random() -> f64 {
    let state = RANDOM.get().wrapping_add(0x9E37_79B9_7F4A_7C15);
    RANDOM.set(state);
    let mut mixed = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^= mixed >> 31;
    (mixed >> 11) as f64 / (1_u64 << 53) as f64
}

type Unary = fn(f64) -> f64;
type Binary = fn(f64, f64) -> f64;

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

/// Gives the engine `In`, and `Math` the functions of libm and a sequence of its own.
pub(super) fn install(context: &mut Context) -> JsResult<()> {
    let is_active = |_: &JsValue, arguments: &[JsValue], context: &mut Context| {
        let id = arguments.first().cloned().unwrap_or_default().to_string(context)?.to_std_string_lossy();
        Ok(JsValue::from(ACTIVE.with_borrow(|active| active.contains(id.as_str()))))
    };
    context.register_global_callable(js_string!("In"), 1, NativeFunction::from_fn_ptr(is_active))?;
    for (name, function) in UNARY {
        let call = move |_: &JsValue, arguments: &[JsValue], context: &mut Context| {
            Ok(JsValue::from(function(number(arguments, 0, context)?)))
        };
        method(name, 1, NativeFunction::from_copy_closure(call), context)?;
    }
    let binary: [(&str, Binary); 2] = [("atan2", libm::atan2), ("pow", power)];
    for (name, function) in binary {
        let call = move |_: &JsValue, arguments: &[JsValue], context: &mut Context| {
            Ok(JsValue::from(function(number(arguments, 0, context)?, number(arguments, 1, context)?)))
        };
        method(name, 2, NativeFunction::from_copy_closure(call), context)?;
    }
    let hypot = |_: &JsValue, arguments: &[JsValue], context: &mut Context| {
        (0..arguments.len())
            .try_fold(0.0, |sum, index| Ok(libm::hypot(sum, number(arguments, index, context)?)))
            .map(JsValue::from)
    };
    method("hypot", 2, NativeFunction::from_fn_ptr(hypot), context)?;
    method("random", 0, NativeFunction::from_fn_ptr(|_, _, _| Ok(JsValue::from(random()))), context)
}

fn number(arguments: &[JsValue], index: usize, context: &mut Context) -> JsResult<f64> {
    arguments.get(index).map_or(Ok(f64::NAN), |argument| argument.to_number(context))
}

/// `Math.pow` is not quite that of C (ECMA-262, Number::exponentiate).
fn power(base: f64, exponent: f64) -> f64 {
    if exponent.is_nan() || base.abs() == 1.0 && exponent.is_infinite() { f64::NAN } else { libm::pow(base, exponent) }
}

fn method(name: &str, length: usize, function: NativeFunction, context: &mut Context) -> JsResult<()> {
    let function =
        FunctionObjectBuilder::new(context.realm(), function).name(JsString::from(name)).length(length).build();
    let math = context.global_object().get(js_string!("Math"), context)?;
    if let Some(math) = math.as_object() {
        math.insert_property(
            JsString::from(name),
            boa_engine::property::PropertyDescriptor::builder()
                .value(function)
                .writable(Attribute::all().writable())
                .enumerable(false)
                .configurable(true)
                .build(),
        );
    }
    Ok(())
}
