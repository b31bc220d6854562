//! Shipped names, for shells to complete. Any other text is accepted as well: it may be a file.

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::error::Error;
use clap::{Arg, Command};
use scenarios::faults::KINDS;
use scenarios::files::{shipped_campaigns, shipped_scenarios};

/// A parser that accepts any text, and knows some.
macro_rules! names {
    ($(#[$about:meta])* $parser:ident, $names:expr) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $parser;

        impl TypedValueParser for $parser {
            type Value = String;

            fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &std::ffi::OsStr) -> Result<String, Error> {
                StringValueParser::new().parse_ref(command, arg, value)
            }

            fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
                Some(Box::new($names.into_iter().map(PossibleValue::new)))
            }
        }
    };
}

names!(
    /// A scenario: a name, or any text.
    ScenarioName,
    shipped_scenarios()
);
names!(
    /// A campaign: a name, or any text.
    CampaignName,
    shipped_campaigns().map(|(name, _)| name)
);
names!(
    /// A kind of fault.
    FaultName,
    KINDS.iter().map(|kind| kind.name)
);
