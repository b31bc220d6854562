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

#[cfg(test)]
mod tests {
    use std::any::TypeId;
    use std::collections::BTreeMap;

    use super::*;

    /// What the tests of the command line know of each option and argument: `reads`, or `writes`, which they try.
    const KNOWN: &str = include_str!("../tests/overwriting/options.txt");

    /// The options and arguments of a command and its subcommands whose values may name files or folders, and whether
    /// they are written according to their type.
    fn with_files(command: &Command, path: &str, found: &mut BTreeMap<String, bool>) {
        for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values()) {
            let value = arg.get_value_names().unwrap_or_default().join(" ");
            let kind = arg.get_value_parser().type_id();
            let is_written = kind == TypeId::of::<OutFile>() || kind == TypeId::of::<ResultsFile>();
            let names = ["FILE", "DIR", "FOLDER", "PATH", "MAP", "LOG", "RECORDING", "SCENARIO"];
            if is_written || kind == TypeId::of::<PathBuf>() || names.iter().any(|name| value.contains(name)) {
                let name = arg.get_long().map_or(value, |long| format!("--{long}"));
                found.insert(format!("{path} {name}"), is_written);
            }
        }
        for inner in command.get_subcommands() {
            with_files(inner, format!("{path} {}", inner.get_name()).trim_start(), found);
        }
    }

    #[test]
    fn every_option_with_a_file_is_known_to_read_or_to_write_it() {
        let mut found = BTreeMap::new();
        with_files(&crate::command(), "", &mut found);
        // Without a command, it is `run`.
        let found = found.into_iter().map(|(name, is_written)| match name.strip_prefix(' ') {
            Some(option) => (format!("run {option}"), is_written),
            None => (name, is_written),
        });
        let found: BTreeMap<String, bool> = found.collect();
        let known = KNOWN.lines().map(|line| line.split_once("  ").expect("two columns"));
        let known: BTreeMap<&str, bool> = known.map(|(does, name)| (name.trim(), does == "writes")).collect();
        let unknown: Vec<_> = found.keys().filter(|name| !known.contains_key(name.as_str())).collect();
        assert!(
            unknown.is_empty(),
            "tests/overwriting/options.txt does not list whether these read or write: {unknown:?}"
        );
        let gone: Vec<_> = known.keys().filter(|name| !found.contains_key(**name)).collect();
        assert!(gone.is_empty(), "there are no such options: {gone:?}");
        let wrong: Vec<_> = found.iter().filter(|(name, writes)| **writes && !known[name.as_str()]).collect();
        assert!(wrong.is_empty(), "they write: {wrong:?}");
    }
}
