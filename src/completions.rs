//! `steward completions SHELL`: completion of commands, options and shipped names.

use campaigns::Error;
use clap::{Arg, Args, Command};
use clap_complete::Shell;

use crate::output::print;

/// For which shell.
#[derive(Debug, Args)]
#[command(after_help = "\
To complete commands in every new shell, save the script as:
  bash  ~/.local/share/bash-completion/completions/steward
  zsh   _steward in a folder of your $fpath
  fish  ~/.config/fish/completions/steward.fish")]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Prints the script.
pub(crate) fn completions(args: &CompletionsArgs, mut command: Command) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "steward", &mut script);
    let mut script = String::from_utf8_lossy(&script).into_owned();
    match args.shell {
        Shell::Zsh => with_files(&mut script, &command),
        Shell::Fish => with_names(&mut script, &command),
        _ => {}
    }
    print(&script)
}

/// The arguments that take a shipped name or a file, each with its subcommand and the names.
fn named(command: &Command) -> impl Iterator<Item = (&Command, &Arg, String)> {
    let all = std::iter::once(command).chain(command.get_subcommands());
    let hidden = all.flat_map(|command| command.get_arguments().map(move |arg| (command, arg)));
    hidden.filter(|(_, arg)| arg.is_hide_possible_values_set()).map(|(command, arg)| {
        let names: Vec<String> = arg.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
        (command, arg, names.join(" "))
    })
}

/// In zsh, wherever a name can be completed, a file can be completed, too.
fn with_files(script: &mut String, command: &Command) {
    for (_, _, names) in named(command) {
        let both = format!(":{{_alternative \"names:name:({names})\" \"files:file:_files\"}}'");
        *script = script.replace(&format!(":({names})'"), &both);
    }
}

/// In fish, names also complete arguments without an option.
fn with_names(script: &mut String, command: &Command) {
    for (command, _, names) in named(command).filter(|(_, arg, _)| arg.is_positional()) {
        let name = command.get_name();
        *script += &format!("complete -c steward -n \"__fish_steward_using_subcommand {name}\" -a \"{names}\"\n");
    }
}
