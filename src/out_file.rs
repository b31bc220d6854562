//! Files that options name to be written.

use std::ffi::OsString;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use campaigns::Error;
use clap::builder::ValueParserFactory;
use clap::{Arg, ArgMatches, Command};
use reports::ResultsFile;

/// A file that an option names to be written. The type makes it known as such: nothing that the command reads may be
/// this file.
#[derive(Clone, Debug)]
pub(crate) struct OutFile(PathBuf);

impl Deref for OutFile {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl AsRef<Path> for OutFile {
    fn as_ref(&self) -> &Path {
        self
    }
}

impl ValueParserFactory for OutFile {
    type Parser = clap::builder::MapValueParser<clap::builder::PathBufValueParser, fn(PathBuf) -> Self>;

    fn value_parser() -> Self::Parser {
        use clap::builder::TypedValueParser;
        clap::builder::PathBufValueParser::new().map(Self)
    }
}

/// Guards what the command will read from being overwritten by the files that its options name.
pub(crate) fn guard(command: &Command, matches: &ArgMatches) -> Result<(), Error> {
    let (mut outputs, mut named) = (Vec::new(), Vec::new());
    sort(command, matches, &mut outputs, &mut named);
    Ok(diagnostics::guard_inputs(outputs, named.iter().map(Path::new))?)
}

/// Whether the name of an option's value is that of some file.
fn is_of_file(arg: &Arg) -> bool {
    let names = arg.get_value_names().unwrap_or_default();
    names.iter().any(|name| ["FILE", "LOG", "RECORDING"].iter().any(|known| name.contains(known)))
}

/// The values of all options of a command and its subcommands: files to be written, each with its option, and others.
fn sort(command: &Command, matches: &ArgMatches, outputs: &mut Vec<(String, PathBuf)>, named: &mut Vec<OsString>) {
    for arg in command.get_arguments() {
        let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten().into_iter().flatten();
        let kind = arg.get_value_parser().type_id();
        if kind == std::any::TypeId::of::<OutFile>() || kind == std::any::TypeId::of::<ResultsFile>() {
            let option = format!("--{}", arg.get_long().unwrap_or_default());
            outputs.extend(values.map(|value| (option.clone(), PathBuf::from(value))));
        } else if arg.is_positional() || is_of_file(arg) {
            named.extend(values.map(ToOwned::to_owned));
        }
    }
    if let Some((name, matches)) = matches.subcommand()
        && let Some(command) = command.find_subcommand(name)
    {
        sort(command, matches, outputs, named);
    }
}
