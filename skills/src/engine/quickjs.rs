//! The engine: QuickJS, newly created for every evaluation, so that evaluations cannot affect each other.
//!
//! Its resources are limited and counted in the same way in every thread and on every computer: memory in bytes
//! requested, time in calls and loop iterations, the stack in bytes from the start of the evaluation. The stack limit
//! is far smaller than any thread's stack.

mod builtins;
mod convert;
mod failure;
mod reading;
mod runtime;

use std::cell::Cell;
use std::rc::Rc;

use rquickjs::object::Property;
use rquickjs::{Ctx, Object, Value};

use super::World;
use crate::Datum;
use crate::datum::EvaluationError;
use crate::expression::Code;
use crate::ids::DataId;
use crate::ids::Identifiers;
use builtins::Tools;
use convert::{Extractor, Injector};
use failure::{Failure, TOO_LARGE};
pub(super) use reading::check;
use runtime::{STEPS_PER_TURN, Turns, engine};

pub(super) const AVAILABLE: bool = true;

/// The cost of any evaluation, because it needs its own engine. Chosen, not measured.
const STEPS_TO_BEGIN: u64 = 100;

/// Runs a program: puts in the data that it mentions, and takes them out again.
pub(super) fn run(code: &Code, world: &mut World<'_>, argument: Option<&Datum>) -> Result<Datum, EvaluationError> {
    let turns = Turns::new(world.steps.left());
    let random = Rc::new(Cell::new(*world.random));
    let context = engine(&turns).map_err(|_| EvaluationError::Thrown(TOO_LARGE.to_owned()))?;
    let outcome = context.with(|ctx| {
        let mut evaluate = || {
            let tools = builtins::install(&ctx, world, &random)?;
            Evaluation { ctx: &ctx, tools: &tools, turns: &turns }.run(code, world, argument)
        };
        evaluate().map_err(|failure: Failure| failure.reported(&ctx, &turns))
    });
    *world.random = random.get();
    // A program that does not end has used up everything.
    let taken = if turns.are_over() { world.steps.left() } else { STEPS_TO_BEGIN + turns.taken.get() * STEPS_PER_TURN };
    let counted = world.steps.take(taken);
    outcome.and_then(|value| counted.map(|()| value))
}

/// An engine that runs one program.
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

    /// Runs the pending jobs of promises: a program has ended when none are left.
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
        let Some(names) = world.scope.ids else {
            return Ok(());
        };
        // A function in the data may mention any name (`run`): then everything is put in.
        let everything = ids.len() > code.mentions.len();
        for id in ids {
            let value = injector.inject(&world.memory[id.index()])?;
            global.prop(names.datum(*id), Property::from(value).writable().enumerable().configurable())?;
        }
        let fix = |name: &str, value: Value<'js>| global.prop(name, Property::from(value).enumerable());
        if code.mentions_event || everything {
            let event = injector.inject(&world.scope.whole_event()?)?;
            if event.is_object() {
                self.tools.freeze.call::<_, ()>((event.clone(),))?;
            }
            fix("_event", event)?;
        }
        for (name, value) in system_variables(names, world) {
            if code.program.contains(name) || everything {
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

    /// Reads the value and the data. Data are changed only if all of them can be kept.
    fn take_out(
        &self,
        value: &Value<'js>,
        world: &mut World<'_>,
        ids: &[DataId],
        injector: &Injector<'_, 'js>,
    ) -> Result<Datum, Failure> {
        let global: Object<'js> = self.ctx.globals();
        let mut extractor = Extractor::new(self.tools, injector);
        let mut data = Vec::with_capacity(ids.len());
        if let Some(names) = world.scope.ids {
            for id in ids {
                let value: Value<'js> = global.get(names.datum(*id))?;
                data.push((*id, extractor.read(&value)?));
            }
        }
        // A changed object may be in other data, or in none of these any longer.
        for object in injector.objects() {
            extractor.read(object)?;
        }
        let result = extractor.read(value)?;
        let renewed = extractor.into_renewed();
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
fn system_variables(names: &Identifiers, world: &World<'_>) -> [(&'static str, Datum); 4] {
    [
        ("_ioprocessors", world.scope.io_processors.cloned().unwrap_or_default()),
        ("_sessionid", Datum::text(world.scope.session)),
        ("_name", Datum::text(&names.machine)),
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
