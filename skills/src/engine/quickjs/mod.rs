//! The engine: QuickJS, made anew for every evaluation, so that nothing of one can be seen by another.
//!
//! Everything that it may take is counted, and counts alike in every thread and on every machine: memory in bytes asked
//! for, time in calls and rounds of loops, the stack in bytes from where the evaluation began. It is far smaller than that
//! of any thread.

mod builtins;
mod convert;

use std::cell::Cell;
use std::rc::Rc;

use rquickjs::context::intrinsic;
use rquickjs::object::Property;
use rquickjs::{Context, Ctx, Error, Object, Runtime, Value};

use super::{Code, Form, World};
use crate::Datum;
use crate::chart::{Chart, DataId};
use crate::expression::{EvaluationError, ExpressionProblem};
use builtins::Tools;
use convert::{Injector, Reader};

pub(super) const AVAILABLE: bool = true;

/// What an evaluation may keep in memory, its own objects and the engine's.
const MAX_MEMORY_BYTES: usize = 4 << 20;
/// Calls may lie in each other so deeply. A thread has 2 MiB at least.
const MAX_STACK_BYTES: usize = 256 << 10;
/// The engine counts 10,000 calls and rounds of loops before it asks whether it may go on. Each may be as much work as
/// several of a machine's own steps.
const STEPS_PER_TURN: u64 = 50_000;
/// What an evaluation costs whatever the program is: it needs an engine of its own.
const STEPS_TO_BEGIN: u64 = 100;

const TOO_LARGE: &str = "the code needs more memory than 4 MiB";

/// What of ECMAScript there is. Proxies, typed arrays and weak references are not ([`builtins`] says why).
type Intrinsics = (
    intrinsic::Eval,
    intrinsic::Date,
    intrinsic::RegExpCompiler,
    intrinsic::RegExp,
    intrinsic::Json,
    intrinsic::MapSet,
    intrinsic::Promise,
);

/// How often the engine has asked whether it may go on.
#[derive(Clone)]
struct Turns {
    taken: Rc<Cell<u64>>,
    allowed: u64,
}

impl Turns {
    fn new(steps: u64) -> Self {
        Self { taken: Rc::default(), allowed: (steps / STEPS_PER_TURN).max(1) }
    }

    fn take(&self) {
        self.taken.set(self.taken.get() + 1);
    }

    fn are_over(&self) -> bool {
        self.taken.get() > self.allowed
    }
}

/// An engine that has run nothing yet.
fn engine(turns: &Turns) -> Result<Context, Error> {
    let runtime = Runtime::new()?;
    runtime.set_max_stack_size(MAX_STACK_BYTES);
    // Nothing lives long enough to be worth collecting, and QuickJS 0.16 crashes if memory ends in the middle of a change and
    // the error that is then made has it collect.
    runtime.set_gc_threshold(usize::MAX);
    let context = Context::custom::<Intrinsics>(&runtime)?;
    runtime.set_memory_limit(MAX_MEMORY_BYTES);
    let turns = turns.clone();
    runtime.set_interrupt_handler(Some(Box::new(move || {
        turns.take();
        turns.are_over()
    })));
    Ok(context)
}

/// Whether a source can be read.
pub(super) fn check(source: &str, form: Form) -> Result<(), ExpressionProblem> {
    // What escapes from one pair of brackets does not fit into the other. Nothing is called; what escapes from the
    // function may run, in an engine that nobody looks at.
    let around = match form {
        Form::Expression => [("return (\n", "\n)"), ("return [\n", "\n]")],
        Form::Location => [("(\n", "\n) = 0"), ("[(\n", "\n) = 0]")],
        Form::Script => [("{\n", "\n}"), ("(function () {\n", "\n})")],
    };
    let read =
        |(before, after): &(&str, &str)| readable(&format!("(function(){{'use strict';{before}{source}{after}}})"));
    around.iter().try_for_each(read).map_err(|complaint| complaint.about(source))
}

/// What the engine says about a text that it cannot read.
struct Complaint {
    message: String,
    /// Line and column, from 1.
    place: Option<(usize, usize)>,
}

impl Complaint {
    /// What is wrong with a source, which was read with a line before it.
    fn about(&self, source: &str) -> ExpressionProblem {
        let place = self.place.and_then(|(line, column)| {
            let before: usize = source.split_inclusive('\n').take(line.checked_sub(2)?).map(str::len).sum();
            let line = source.get(before..)?.lines().next().unwrap_or_default();
            let (offset, letter) = line.char_indices().nth(column.checked_sub(1)?)?;
            Some(before + offset..before + offset + letter.len_utf8())
        });
        let what = self.message.strip_prefix("SyntaxError: ").unwrap_or(&self.message);
        ExpressionProblem::new(format!("this is not ECMAScript: {what}"), place.unwrap_or(0..source.len()), "here")
    }
}

fn readable(program: &str) -> Result<(), Complaint> {
    let turns = Turns::new(STEPS_PER_TURN);
    let complaint = |message: &str| Complaint { message: message.to_owned(), place: None };
    let context = engine(&turns).map_err(|error| complaint(&error.to_string()))?;
    context.with(|ctx| match ctx.eval::<Value<'_>, _>(program) {
        Ok(_) => Ok(()),
        Err(Error::Exception) => {
            let thrown = ctx.catch();
            let Some(error) = thrown.as_object() else {
                return Err(complaint("it is too large"));
            };
            let number = |name: &str| error.get::<_, usize>(name).ok();
            let place = number("lineNumber").zip(number("columnNumber"));
            let message = error.get::<_, String>("message").unwrap_or_default();
            Err(Complaint { message, place })
        }
        Err(error) => Err(complaint(&error.to_string())),
    })
}

/// Runs a program: puts the data that it mentions in, and takes them out again.
pub(super) fn run(code: &Code, world: &mut World<'_>, argument: Option<&Datum>) -> Result<Datum, EvaluationError> {
    let turns = Turns::new(world.steps.left());
    let random = Rc::new(Cell::new(*world.random));
    let context = engine(&turns).map_err(|_| EvaluationError::Thrown(TOO_LARGE.to_owned()))?;
    let outcome = context.with(|ctx| {
        let mut evaluate = || {
            let tools = builtins::install(&ctx, world, &random)?;
            Evaluation { ctx: &ctx, tools: &tools, turns: &turns }.run(code, world, argument)
        };
        evaluate().map_err(|failure: Failure| failure.told(&ctx, &turns))
    });
    *world.random = random.get();
    // What does not end has taken all there is.
    let taken = if turns.are_over() { world.steps.left() } else { STEPS_TO_BEGIN + turns.taken.get() * STEPS_PER_TURN };
    let counted = world.steps.take(taken);
    outcome.and_then(|value| counted.map(|()| value))
}

/// Why a program has no value.
enum Failure {
    Failed(EvaluationError),
    /// Something was thrown, and is with the engine.
    Thrown(Error),
}

impl From<EvaluationError> for Failure {
    fn from(error: EvaluationError) -> Self {
        Self::Failed(error)
    }
}

impl From<crate::TooLarge> for Failure {
    fn from(error: crate::TooLarge) -> Self {
        Self::Failed(error.into())
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Thrown(error)
    }
}

impl Failure {
    fn told(self, ctx: &Ctx<'_>, turns: &Turns) -> EvaluationError {
        let error = match self {
            Self::Failed(error) => return error,
            Self::Thrown(error) => error,
        };
        let thrown = matches!(error, Error::Exception).then(|| ctx.catch());
        if turns.are_over() {
            return EvaluationError::TooLong;
        }
        let text = thrown.and_then(|thrown| thrown_text(ctx, &thrown));
        // Where there is no room for an error, there is none to tell.
        EvaluationError::Thrown(text.unwrap_or_else(|| TOO_LARGE.to_owned()))
    }
}

/// The first line of what was thrown; `None` if that was the want of memory.
fn thrown_text(ctx: &Ctx<'_>, thrown: &Value<'_>) -> Option<String> {
    /// More is of no use to anybody.
    const MAX_CHARS: usize = 300;
    if thrown.is_null() || thrown.type_of() == rquickjs::Type::Uninitialized {
        return None;
    }
    let text = match thrown.get::<rquickjs::Coerced<String>>() {
        Ok(text) => text.0,
        Err(_) => {
            ctx.catch();
            "something that is no text was thrown".to_owned()
        }
    };
    if text.ends_with("out of memory") {
        return None;
    }
    Some(text.lines().next().unwrap_or_default().chars().take(MAX_CHARS).collect())
}

/// An engine at work on one program.
struct Evaluation<'e, 'js> {
    ctx: &'e Ctx<'js>,
    tools: &'e Tools<'js>,
    turns: &'e Turns,
}

impl<'js> Evaluation<'_, 'js> {
    fn run(&self, code: &Code, world: &mut World<'_>, argument: Option<&Datum>) -> Result<Datum, Failure> {
        let everything = code.mentions.iter().any(|id| holds_functions(&world.memory[id.index()]));
        let ids: Vec<DataId> =
            if everything { (0..world.memory.len()).map(DataId::new).collect() } else { code.mentions.clone() };
        let mut injector = Injector::new(self.ctx, self.tools);
        self.put_in(code, world, argument, &ids, &mut injector)?;
        let value: Value<'js> = self.ctx.eval(&*code.program)?;
        self.finish_jobs()?;
        self.take_out(&value, world, &ids, &injector)
    }

    /// Runs what promises have put off: a program has ended when nothing is left to do.
    fn finish_jobs(&self) -> Result<(), Failure> {
        let mut jobs = 0;
        while self.ctx.execute_pending_job() {
            jobs += 1;
            if jobs % 10_000 == 0 {
                self.turns.take();
            }
            if self.turns.are_over() {
                return Err(EvaluationError::TooLong.into());
            }
        }
        Ok(())
    }

    fn put_in(
        &self,
        code: &Code,
        world: &World<'_>,
        argument: Option<&Datum>,
        ids: &[DataId],
        injector: &mut Injector<'_, 'js>,
    ) -> Result<(), Failure> {
        let global = self.ctx.globals();
        let Some(chart) = world.scope.chart else {
            return Ok(());
        };
        for id in ids {
            let value = injector.inject(&world.memory[id.index()])?;
            global.prop(&*chart.data[id.index()].id, Property::from(value).writable().enumerable().configurable())?;
        }
        let fix = |name: &str, value: Value<'js>| global.prop(name, Property::from(value).enumerable());
        if code.mentions_event || ids.len() > code.mentions.len() {
            let event = injector.inject(&world.scope.whole_event()?)?;
            if event.is_object() {
                self.tools.freeze.call::<_, ()>((event.clone(),))?;
            }
            fix("_event", event)?;
        }
        for (name, value) in system_variables(chart, world) {
            if code.program.contains(name) || ids.len() > code.mentions.len() {
                fix(name, injector.inject(&value)?)?;
            }
        }
        if let Some(argument) = argument {
            fix("$value", injector.inject(argument)?)?;
        }
        if code.program.contains("$data.") {
            fix("$data", global.clone().into_value())?;
        }
        Ok(())
    }

    /// Reads the value and the data. Only if all of it can be kept is anything changed.
    fn take_out(
        &self,
        value: &Value<'js>,
        world: &mut World<'_>,
        ids: &[DataId],
        injector: &Injector<'_, 'js>,
    ) -> Result<Datum, Failure> {
        let global: Object<'js> = self.ctx.globals();
        let mut reader = Reader::new(self.tools, injector);
        let mut data = Vec::with_capacity(ids.len());
        if let Some(chart) = world.scope.chart {
            for id in ids {
                let value: Value<'js> = global.get(&*chart.data[id.index()].id)?;
                data.push((*id, reader.read(&value)?));
            }
        }
        for object in injector.objects() {
            reader.read(object)?;
        }
        let result = reader.read(value)?;
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
