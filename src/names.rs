//! Shipped names, for shells to complete. Any other text is accepted as well: it may be a file.

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::error::Error;
use clap::{Arg, Command};
use scenarios::faults::KINDS;
use scenarios::files::{shipped_campaigns, shipped_scenarios};

/// A parser that accepts any text, and lists these names.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShippedNames(fn() -> Vec<&'static str>);

pub(crate) const SCENARIOS: ShippedNames = ShippedNames(shipped_scenarios);
pub(crate) const CAMPAIGNS: ShippedNames = ShippedNames(|| shipped_campaigns().map(|(name, _)| name).collect());
pub(crate) const FAULTS: ShippedNames = ShippedNames(|| KINDS.iter().map(|kind| kind.name).collect());

impl TypedValueParser for ShippedNames {
    type Value = String;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &std::ffi::OsStr) -> Result<String, Error> {
        StringValueParser::new().parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new((self.0)().into_iter().map(PossibleValue::new)))
    }
}
