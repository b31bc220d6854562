//! ECMAScript beyond the compiled subset.
//!
//! With the cargo feature `ecmascript`, everything that [`crate::expression`] does not compile becomes [`Code`] for a
//! real engine. The data stay where they are: before an evaluation, the engine gets the data that the code mentions
//! (all of them, if there are functions among them); afterwards they are taken back. So a machine remains a value, and
//! two machines share nothing. Only what data can hold is kept between evaluations: plain values, arrays, plain
//! objects, and functions as their source. A function therefore sees data and other functions, but no variables of an
//! enclosing function. An object loses its class, and a class is known only in its own script. A `Date`, a `Map`, a
//! `RegExp` and the like cannot be kept. Of a `Date`, loading warns where the text shows it.
//!
//! Every evaluation has its own engine: changes to the engine's objects are gone afterwards, and so are thrown errors.
//! Promises are settled before the program ends.
//!
//! The engine is deterministic: `Date` shows simulated time, counted from 1970, in UTC; `Math.random` continues a
//! sequence that belongs to the machine; the functions of `Math` are those of libm. Code is strict, and there is no
//! `eval`. `**` is refused, because its precision depends on the computer.
//!
//! Memory, stack and steps are limited and counted ([`crate::steps`]). `Proxy`, `BigInt`, typed arrays and `WeakRef`
//! are left out, because the work that they do could not be counted.

#[cfg(not(feature = "ecmascript"))]
mod absent;
#[cfg(feature = "ecmascript")]
mod quickjs;
mod world;

use std::collections::BTreeSet;

#[cfg(not(feature = "ecmascript"))]
use absent as present;
#[cfg(feature = "ecmascript")]
use quickjs as present;

pub(crate) use world::World;

use crate::Datum;
use crate::datum::EvaluationError;
use crate::expression::scan::{Declarations, Piece, declarations, pieces, too_deep, words};
use crate::expression::{Code, ExpressionProblem, Form, Names};
use crate::ids::DataId;

/// The longest source.
const MAX_BYTES: usize = 1 << 18;
/// Names of internal variables that the code must not use: the object whose members are the data while the engine runs,
/// and the value that is assigned to a location.
const OWN_NAMES: [&str; 2] = ["$data", "$value"];

impl Code {
    /// Reads a source; `None` if there is no engine.
    pub(crate) fn new(source: &str, form: Form, names: &Names) -> Option<Result<Self, ExpressionProblem>> {
        // `new Thing();` is a statement, but the expression that it means is clear.
        let source = if form == Form::Expression { source.trim_end().trim_end_matches(';') } else { source };
        present::AVAILABLE.then(|| {
            refuse(source)?;
            present::check(source, form)?;
            let mentions: BTreeSet<DataId> = words(source).filter_map(|word| names.data.get(word)).copied().collect();
            let mentions_event = words(source).any(|word| word == "_event");
            Ok(Self { program: program(source, form).into(), mentions: mentions.into_iter().collect(), mentions_event })
        })
    }

    /// The value of the code; `argument` is the value assigned to a location.
    pub(crate) fn run(&self, world: &mut World<'_>, argument: Option<&Datum>) -> Result<Datum, EvaluationError> {
        present::run(self, world, argument)
    }
}

/// Refuses code that the engine must not read.
fn refuse(source: &str) -> Result<(), ExpressionProblem> {
    if source.len() > MAX_BYTES {
        let message = format!("code may have at most {MAX_BYTES} bytes");
        return Err(ExpressionProblem::new(message, 0..source.len(), "too long"));
    }
    if let Some(word) = words(source).find(|word| OWN_NAMES.contains(word)) {
        let start = word.as_ptr().addr() - source.as_ptr().addr();
        return Err(ExpressionProblem::new(
            format!("`{word}` is reserved"),
            start..start + word.len(),
            "cannot be a name here",
        ));
    }
    if let Some(span) = too_deep(source) {
        return Err(ExpressionProblem::new("this is nested too deeply", span, "here"));
    }
    let pieces = pieces(source);
    let mark = |piece: Piece| piece == Piece::Mark(b'*');
    for (index, (piece, at)) in pieces.iter().enumerate() {
        let text = &source[at.clone()];
        // The contents of templates are not analyzed: anything there that looks like a problem is refused.
        let hidden = *piece == Piece::Text && text.contains("${");
        let next = pieces.get(index + 1).filter(|(next, place)| mark(*next) && place.start == at.end);
        if mark(*piece) && next.is_some() || hidden && text.contains("**") {
            let problem =
                ExpressionProblem::new("`**` does not have the same value on every computer", at.clone(), "refused");
            return Err(problem.with_help("Math.pow(a, b)"));
        }
        let is_big = |word: &str| word.ends_with('n') && word.starts_with(|first: char| first.is_ascii_digit());
        let has_big = |text: &str| text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(is_big);
        if *piece == Piece::Word && is_big(text) || hidden && has_big(text) {
            return Err(ExpressionProblem::new("BigInt is not supported", at.clone(), "refused"));
        }
    }
    Ok(())
}

/// The program that evaluates a source: strict code in its own function. Functions that a script declares become data.
fn program(source: &str, form: Form) -> String {
    match form {
        Form::Expression => format!("(function(){{'use strict';return (\n{source}\n)}})()"),
        Form::Location => format!("(function(){{'use strict';(\n{source}\n) = $value}})()"),
        Form::Script => {
            let Declarations { functions, script, .. } = declarations(source);
            let keep: String = functions.iter().map(|name| format!("$data.{name}={name};")).collect();
            format!("(function(){{'use strict';{keep}\n{script}\n;{keep}}})()")
        }
    }
}
