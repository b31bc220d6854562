//! The engine: boa, one for each thread, shared by all machines that run there and changed by none.

mod convert;
mod determinism;
mod limits;
mod setup;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::mem::ManuallyDrop;
use std::rc::Rc;
use std::sync::Arc;

use boa_engine::property::{Attribute, PropertyDescriptor, PropertyKey};
use boa_engine::{Context, JsError, JsObject, JsString, JsValue, Script, Source};

use super::{Code, Form, World};
use crate::Datum;
use crate::chart::{Chart, DataId};
use crate::expression::{EvaluationError, ExpressionProblem};
use convert::{Injector, Reader};
use determinism::SimulatedClock;

pub(super) const AVAILABLE: bool = true;

thread_local! {
    /// Never dropped: its objects belong to a collector that may be gone by the time the thread ends.
    static ENGINE: RefCell<Option<ManuallyDrop<Engine>>> = const { RefCell::new(None) };
}

/// So many programs are kept compiled.
const MAX_PROGRAMS: usize = 4_096;

/// What code may do with what is not its own to change.
const FIXED: Attribute = Attribute::CONFIGURABLE.union(Attribute::ENUMERABLE);

struct Engine {
    context: Context,
    clock: Rc<SimulatedClock>,
    /// Makes an object that is looked into like an element out of a description of it.
    make_element: JsObject,
    programs: BTreeMap<Arc<str>, Script>,
}

/// Lends out the thread's engine. `work` says whether it can be used again.
fn with_engine<T>(work: impl FnOnce(&mut Engine) -> (T, Health)) -> T {
    let mut engine = ENGINE.take().unwrap_or_else(|| ManuallyDrop::new(Engine::new()));
    let (result, health) = work(&mut engine);
    match health {
        Health::Sound => ENGINE.set(Some(engine)),
        Health::Spoiled => drop(ManuallyDrop::into_inner(engine)),
    }
    result
}

/// Whether an engine can be used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Health {
    Sound,
    /// It was stopped in the middle of something.
    Spoiled,
}

/// Whether a source can be read.
pub(super) fn check(source: &str, form: Form) -> Result<(), ExpressionProblem> {
    with_engine(|engine| {
        let around = match form {
            // What escapes from one pair of brackets does not fit into the other.
            Form::Expression => [("(\n", "\n)"), ("[\n", "\n]")],
            Form::Location => [("(\n", "\n) = 0"), ("[(\n", "\n) = 0]")],
            Form::Script => [("{\n", "\n}"), ("(function () {\n", "\n})")],
        };
        let read = |(before, after): &(&str, &str)| engine.read(&format!("{before}{source}{after}")).map(|_| ());
        let outcome = around.iter().try_for_each(read);
        (outcome.map_err(|error| limits::syntax_problem(source, &first_line(&error))), Health::Sound)
    })
}

/// Runs a program: puts the data that it mentions in, and takes them out again.
pub(super) fn run(code: &Code, world: &mut World<'_>, argument: Option<&Datum>) -> Result<Datum, EvaluationError> {
    with_engine(|engine| {
        engine.clock.set(world.now);
        determinism::set_random(*world.random);
        let outcome = engine.run(code, world, argument);
        *world.random = determinism::random_state();
        match outcome {
            Err(Failure::Interrupted) => (Err(EvaluationError::Thrown(limits::TOO_LONG.to_owned())), Health::Spoiled),
            Err(Failure::Failed(error)) => (Err(error), Health::Sound),
            Ok(value) => (Ok(value), Health::Sound),
        }
    })
}

/// Why a program has no value.
enum Failure {
    Failed(EvaluationError),
    /// It took too long and was stopped.
    Interrupted,
}

impl From<EvaluationError> for Failure {
    fn from(error: EvaluationError) -> Self {
        Self::Failed(error)
    }
}

impl From<JsError> for Failure {
    fn from(error: JsError) -> Self {
        Self::Failed(thrown(&error))
    }
}

fn thrown(error: &JsError) -> EvaluationError {
    EvaluationError::Thrown(first_line(error))
}

fn first_line(error: &JsError) -> String {
    error.to_string().lines().next().unwrap_or_default().to_owned()
}

impl Engine {
    fn read(&mut self, text: &str) -> Result<Script, JsError> {
        Script::parse(Source::from_bytes(text), None, &mut self.context)
    }

    /// A program, compiled or remembered.
    fn program(&mut self, text: &Arc<str>) -> Result<Script, JsError> {
        if let Some(known) = self.programs.get(text) {
            return Ok(known.clone());
        }
        let script = self.read(text)?;
        if self.programs.len() >= MAX_PROGRAMS {
            self.programs.clear();
        }
        self.programs.insert(Arc::clone(text), script.clone());
        Ok(script)
    }

    fn run(&mut self, code: &Code, world: &mut World<'_>, argument: Option<&Datum>) -> Result<Datum, Failure> {
        let everything = code.mentions.iter().any(|id| holds_functions(&world.memory[id.index()]));
        let ids: Vec<DataId> =
            if everything { (0..world.memory.len()).map(DataId::new).collect() } else { code.mentions.clone() };
        determinism::set_active(world.scope);
        let mut injector = Injector::default();
        let mut names: Vec<JsString> = Vec::new();
        let outcome = self.put_in(code, world, argument, &ids, &mut injector, &mut names).and_then(|()| {
            let script = self.program(&code.program)?;
            let value = limits::evaluate(&script, &mut self.context)?;
            self.take_out(&value, world, &ids, injector)
        });
        if !matches!(outcome, Err(Failure::Interrupted)) {
            let global = self.context.global_object();
            for name in names {
                // They were put in as configurable.
                let _ = global.delete_property_or_throw(name, &mut self.context);
            }
        }
        outcome
    }

    fn put_in(
        &mut self,
        code: &Code,
        world: &World<'_>,
        argument: Option<&Datum>,
        ids: &[DataId],
        injector: &mut Injector,
        names: &mut Vec<JsString>,
    ) -> Result<(), Failure> {
        let Some(chart) = world.scope.chart else {
            return Ok(());
        };
        for id in ids {
            let value = injector.inject(&world.memory[id.index()], self)?;
            self.define(&chart.data[id.index()].id, value, Attribute::all(), names)?;
        }
        if code.mentions_event || ids.len() > code.mentions.len() {
            let event = injector.inject(&world.scope.whole_event()?, self)?;
            if let Some(event) = event.as_object() {
                event.set_integrity_level(boa_engine::object::IntegrityLevel::Frozen, &mut self.context)?;
            }
            self.define("_event", event, FIXED, names)?;
        }
        for (name, value) in system_variables(chart, world) {
            if code.program.contains(name) || ids.len() > code.mentions.len() {
                let value = injector.inject(&value, self)?;
                self.define(name, value, FIXED, names)?;
            }
        }
        if let Some(argument) = argument {
            let value = injector.inject(argument, self)?;
            self.define("$value", value, FIXED, names)?;
        }
        if code.program.contains("$data.") {
            let global = JsValue::from(self.context.global_object());
            self.define("$data", global, FIXED, names)?;
        }
        Ok(())
    }

    fn define(
        &mut self,
        name: &str,
        value: JsValue,
        attribute: Attribute,
        names: &mut Vec<JsString>,
    ) -> Result<(), Failure> {
        let name = JsString::from(name);
        let descriptor = PropertyDescriptor::builder()
            .value(value)
            .writable(attribute.writable())
            .enumerable(attribute.enumerable())
            .configurable(attribute.configurable());
        let key = PropertyKey::from(name.clone());
        self.context.global_object().define_property_or_throw(key, descriptor, &mut self.context)?;
        names.push(name);
        Ok(())
    }

    /// Reads the value and the data. Only if all of it can be kept is anything changed.
    fn take_out(
        &mut self,
        value: &JsValue,
        world: &mut World<'_>,
        ids: &[DataId],
        injector: Injector,
    ) -> Result<Datum, Failure> {
        let global = self.context.global_object();
        let mut reader = Reader::new(&injector);
        let mut data = Vec::with_capacity(ids.len());
        if let Some(chart) = world.scope.chart {
            for id in ids {
                let name = JsString::from(&*chart.data[id.index()].id);
                let value = global.get(name, &mut self.context)?;
                data.push((*id, reader.read(&value, self)?));
            }
        }
        for object in injector.objects() {
            reader.read(&JsValue::from(object), self)?;
        }
        let result = reader.read(value, self)?;
        let renewed = reader.into_renewed();
        if !renewed.is_empty() {
            world.memory.renew(renewed)?;
        }
        for (id, value) in data {
            world.memory.set(id, value);
        }
        Ok(result)
    }
}

/// The system variables besides `_event` (SCXML 5.10).
fn system_variables(chart: &Chart, world: &World<'_>) -> [(&'static str, Datum); 4] {
    [
        ("_ioprocessors", world.scope.io_processors.cloned().unwrap_or_default()),
        ("_sessionid", Datum::text(world.scope.session)),
        ("_name", Datum::text(chart.name())),
        ("_x", Datum::object::<&str>([]).unwrap_or_default()),
    ]
}

fn holds_functions(value: &Datum) -> bool {
    match value {
        Datum::Function(_) => true,
        Datum::Array(array) => array.items().iter().any(holds_functions),
        Datum::Object(object) => object.members().any(|(_, value)| holds_functions(value)),
        _ => false,
    }
}
