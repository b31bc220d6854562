//! Unknown names in a file.

use diagnostics::{Problem, Spanned};

/// The problem of an unknown name.
pub fn unknown<'n>(what: &str, name: &Spanned<String>, known: impl IntoIterator<Item = &'n str>) -> Problem {
    let known: Vec<&str> = known.into_iter().collect();
    let list = || match known.as_slice() {
        [] => "there is none".to_owned(),
        [only] => format!("the only one is `{only}`"),
        known => format!("the known ones are `{}`", known.join("`, `")),
    };
    let help = diagnostics::did_you_mean(&name.value, known.iter().copied()).unwrap_or_else(list);
    let problem = name.span.problem(format!("unknown {what} `{}`", name.value));
    problem.with_label(format!("no such {what}")).with_help(help)
}
