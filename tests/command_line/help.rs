//! Help, tables and messages on a terminal of 80 columns, shell completions, and man pages.

use std::path::Path;
use std::process::Command;

use scenarios::faults::KINDS;
use tempfile::tempdir;

use crate::steward::{binary, steward};

/// The binary's output with that number of columns and these variables: stdout and stderr.
fn said(columns: &str, variables: &[(&str, &str)], arguments: &[&str]) -> String {
    let output = Command::new(binary())
        .args(arguments)
        .env("COLUMNS", columns)
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat()
}

fn fits(text: &str, columns: usize) {
    for line in text.lines() {
        assert!(line.chars().count() <= columns, "{} columns: {line}", line.chars().count());
    }
}

/// The subcommands of a command, with their help.
fn helps(command: &[&str], all: &mut Vec<(String, String)>) {
    let help = said("80", &[], &[command, &["--help"]].concat());
    let listed = help.split_once("\nCommands:\n").map_or("", |(_, list)| list.split("\n\n").next().unwrap());
    let names = listed.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    for name in names.map(|line| line.split_whitespace().next().unwrap()).filter(|name| *name != "help") {
        helps(&[command, &[name]].concat(), all);
    }
    all.push((["steward"].iter().chain(command).copied().collect::<Vec<_>>().join("_"), help));
}

#[test]
fn the_help_of_every_command_fits_80_columns() {
    let mut all = Vec::new();
    helps(&[], &mut all);
    assert!(all.len() > 30, "{}", all.len());
    for (command, help) in all {
        fits(&help, 80);
        insta::assert_snapshot!(command, help);
    }
}

#[test]
fn explanations_fit_80_columns() {
    for topic in ["scenario", "faults", "scope"] {
        fits(&String::from_utf8(steward(&["help", topic]).stdout).unwrap(), 80);
    }
    fits(&said("80", &[], &["help", "campaign"]), 80);
    for kind in KINDS {
        let said = String::from_utf8(steward(&["faults", kind.name]).stdout).unwrap();
        fits(&said, 80);
        assert!(!said.contains("\n\n\n"), "{said}");
    }
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn tables_and_messages_fit_80_columns_without_broken_words() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("out");
    let out = ["--out", out.to_str().unwrap()];
    let commands: [&[&str]; 7] = [
        &["list"],
        &["faults"],
        &["navigate", "--goals", "2", "--people", "3"],
        &["matrix", "faults/joypad", "faults/component_wrong_reply", "--runs", "1"],
        &["reproduce", "--seeds", "1"],
        &["run", "battery_fault", "--no-snapshots"],
        &["run", "batery_fault"],
    ];
    for (place, command) in commands.iter().enumerate() {
        let command = if (2..6).contains(&place) { [command, &out[..]].concat() } else { command.to_vec() };
        let (narrow, wide) = (said("80", &[], &command), said("9999", &[], &command));
        // Unbreakable text, such as the name of a folder, may stick out.
        let unbroken = |line: &&str| line.split_whitespace().count() > 2;
        fits(&narrow.lines().filter(unbroken).collect::<Vec<_>>().join("\n"), 80);
        let words =
            |text: &str| text.split_whitespace().filter(|word| *word != "|").map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&narrow), words(&wide), "{command:?}");
    }
}

#[test]
fn colors_are_for_terminals_and_for_those_who_force_them() {
    let folder = tempdir().unwrap();
    let run = ["run", "battery_fault", "--no-snapshots", "--out", folder.path().to_str().unwrap()];
    let violated = "\u{1b}[1m\u{1b}[31mviolated";
    assert!(!said("80", &[], &run).contains('\u{1b}'));
    assert!(said("80", &[("CLICOLOR_FORCE", "1")], &run).contains(violated));
    assert!(!said("80", &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")], &run).contains('\u{1b}'));
    let refused = ["run", "nominl"];
    assert!(!said("80", &[], &refused).contains('\u{1b}'));
    assert!(said("80", &[("CLICOLOR_FORCE", "1")], &refused).contains('\u{1b}'));
}

/// A shell's completions of `steward ru` and `steward run nomin`; `None` if the shell is not installed.
fn completed(shell: &str, script: &Path) -> Option<String> {
    let script = script.to_str().unwrap();
    let text = match shell {
        "bash" => format!(
            "source {script}\n\
             complete_line() {{ COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); _steward steward \"${{@: -1}}\"; \
             echo \"${{COMPREPLY[@]}}\"; }}\n\
             complete_line steward ru\ncomplete_line steward run nomin\n"
        ),
        // Completion works only in an interactive shell.
        "zsh" => format!(
            "zmodload zsh/zpty\nzpty shell zsh -f -i\n\
             zpty -w shell 'PROMPT=; autoload -U compinit && compinit -D -u; source {script}; stty -echo; unsetopt beep'\n\
             zpty -w -n shell $'steward ru\\t nomin\\t\\C-a: \\n'\n\
             repeat 1000; do zpty -r -t shell line && print -r -- $line && [[ $line == *nominal* ]] && break\n\
             sleep 0.1; done\nzpty -d shell\n"
        ),
        "fish" => format!("source {script}\ncomplete -C 'steward ru'\ncomplete -C 'steward run nomin'\n"),
        other => unreachable!("{other}"),
    };
    let flag: &[&str] = if shell == "fish" { &["--no-config", "-c"] } else { &["-c"] };
    let output = match Command::new(shell).args(flag).arg(text).output() {
        Ok(output) => output,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
        Err(error) => panic!("{shell}: {error}"),
    };
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(output.status.success() && said[1].is_empty(), "{shell}: {said:?}");
    Some(said[0].clone())
}

#[test]
fn shells_complete_commands_and_names() {
    let folder = tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let output = steward(&["completions", shell]);
        assert!(output.status.success());
        let script = folder.path().join(shell);
        std::fs::write(&script, output.stdout).unwrap();
        match completed(shell, &script) {
            Some(said) => {
                println!("ran: completion in {shell}");
                assert!(said.contains("run") && said.contains("nominal"), "{shell}: {said}");
            }
            None => println!("not run here: completion in {shell}, which is not installed"),
        }
    }
}

#[test]
fn every_command_has_a_man_page() {
    let folder = tempdir().unwrap();
    let output = steward(&["man", folder.path().to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(page("steward.1").contains("Exit status:") && page("steward.1").contains("steward\\-run(1)"));
    assert!(page("steward-run.1").contains("\\-\\-seed"), "{}", page("steward-run.1"));
    assert!(page("steward-tree-check.1").contains("BehaviorTree.CPP"));
}

/// The output of the commands that only read; the book shows the output of the others.
#[test]
fn commands_print_the_same_as_before() {
    let calls: [&[&str]; 12] = [
        &["list"],
        &["faults"],
        &["faults", "joypad"],
        &["check", "nominal", "guide", "pick", "noise"],
        &["monitor", "check", "phi1", "phi2"],
        &["monitor", "explain", "phi1", "phi2", "phi3"],
        &["monitor", "export", "phi1"],
        &["tree", "check", "recharge"],
        &["tree", "show", "recharge"],
        &["skill", "check", "BatteryLevel"],
        &["skill", "show", "BatteryLevel"],
        &["skill", "mutants", "AtDestination"],
    ];
    let printed = |call: &&[&str]| format!("$ steward {}\n{}", call.join(" "), said("80", &[], call));
    let printed = calls.iter().map(printed).collect::<Vec<_>>().join("\n");
    insta::assert_snapshot!(printed);
}
