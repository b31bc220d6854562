//! `steward monitor new PATTERN`: a property after one of the usual patterns.

use campaigns::Error;
use clap::Args;
use clap::builder::PossibleValuesParser;
use monitors::{Pattern, PatternEvents, Scope};

/// The pattern and its events.
#[derive(Debug, Args)]
pub(crate) struct NewProperty {
    /// What is required of P: that it never comes (absence), that it comes (existence), that every message is one
    /// (universality), that it comes only after S (precedence), or that S follows it (response)
    #[arg(value_name = "PATTERN", value_parser = PossibleValuesParser::new(Pattern::ALL.map(Pattern::name)))]
    pattern: String,
    /// The event that it is about, `(SENDER, RECEIVER, CONDITION)`
    #[arg(value_name = "P")]
    p: String,
    /// The event that precedes or follows it
    #[arg(value_name = "S")]
    s: Option<String>,
    /// Only from this event on
    #[arg(long, value_name = "Q")]
    after: Option<String>,
    /// Only before this event; with `--after`, only if it comes
    #[arg(long, value_name = "R")]
    before: Option<String>,
    /// With `--after`: up to this event, or to the end
    #[arg(long, value_name = "R", requires = "after", conflicts_with = "before")]
    until: Option<String>,
    /// The property's name; by default, the pattern's
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// The scenario whose processes and channels the events mention
    #[arg(long, value_name = "NAME|FILE", default_value = "nominal")]
    pub(super) scenario: String,
}

/// The text of a file with the property.
pub(super) fn text(args: &NewProperty) -> Result<String, Error> {
    let named = |pattern: &Pattern| pattern.name() == args.pattern;
    let pattern = Pattern::ALL.into_iter().find(named).expect("the argument is one of them");
    if pattern.has_other() != args.s.is_some() {
        let (name, needs) = (pattern.name(), if pattern.has_other() { "needs two events" } else { "has one event" });
        let help = "steward monitor new precedence P S; response P S; absence P; existence P; universality P";
        return Err(Error::refused(format!("{name} {needs}"), help));
    }
    let (scope, r) = match (&args.after, &args.before, &args.until) {
        (None, None, _) => (Scope::Globally, None),
        (None, Some(before), _) => (Scope::Before, Some(before)),
        (Some(_), None, None) => (Scope::After, None),
        (Some(_), Some(before), _) => (Scope::Between, Some(before)),
        (Some(_), None, Some(until)) => (Scope::AfterUntil, Some(until)),
    };
    let written = |event: Option<&String>| event.map_or("", String::as_str).trim().to_owned();
    let [p, s, q, r] = [Some(&args.p), args.s.as_ref(), args.after.as_ref(), r].map(written);
    let formula = pattern.formula(scope, PatternEvents { p: &p, s: &s, q: &q, r: &r });
    let name = args.name.as_deref().unwrap_or(pattern.name());
    Ok(format!("// {}, {scope}: {}.\nproperty {name} := {formula}\n", pattern.name(), pattern.about()))
}
