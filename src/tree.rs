//! `steward tree`: behavior trees without a robot.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use bt::{Outcome, RehearsedTick, Request, Status, Tree};
use campaigns::Error;
use checks::{FileKind, named_files};
use clap::{Subcommand, ValueEnum};
use diagnostics::{Disk, seconds};
use drawing::FoldedTree;
use reports::pictures;
use scenarios::tree_script::{MOST_TICKS, TreeScript};
use serde_json::json;

use crate::check;
use crate::output::{print, print_json};
use crate::results::ResultsArgs;

/// The commands for a tree.
#[derive(Debug, Subcommand)]
pub(crate) enum TreeCommand {
    /// Reports everything that is wrong, or looks wrong, with trees
    Check {
        /// Trees: files in BehaviorTree.CPP's XML, or names of shipped ones
        #[arg(value_name = "FILE", required = true)]
        files: Vec<PathBuf>,
    },
    /// Prints a tree's nodes
    Show {
        /// The tree: a file in BehaviorTree.CPP's XML, or the name of a shipped one
        file: PathBuf,
        /// An outline, a graph for Graphviz, a drawing, or format 4 of BehaviorTree.CPP's XML
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
    },
    /// Ticks a tree whose leaves answer according to a script, and prints every node's status at every tick
    ///
    /// One line per node, one column per tick: S is success, F failure, R running, K skipped and H halted; · is a node
    /// that the tick did not reach.
    Run {
        /// The tree: a file in BehaviorTree.CPP's XML, or the name of a shipped one
        file: PathBuf,
        /// What each leaf answers at each of its ticks (TOML)
        #[arg(long, value_name = "FILE")]
        leaves: PathBuf,
        /// How many ticks [default: as the file says, or as long as the longest part]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=MOST_TICKS))]
        ticks: Option<u64>,
        /// Prints JSON, with what each leaf read from its ports and the blackboard after each tick
        #[arg(long)]
        json: bool,
    },
}

/// How to show a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Text,
    Dot,
    Svg,
    Xml,
}

/// Carries out a command on a tree.
pub(crate) fn tree(command: &TreeCommand) -> Result<ExitCode, Error> {
    match command {
        TreeCommand::Check { files } => check::each(files, false, &ResultsArgs::default(), |file| {
            FileKind::Tree.examine(&Disk::default(), file, None).result
        }),
        TreeCommand::Show { file, format } => show(&named_files::tree(&Disk::default(), file)?, *format),
        TreeCommand::Run { file, leaves, ticks, json } => run(file, leaves, *ticks, *json),
    }
}

fn show(tree: &Tree, format: Format) -> Result<ExitCode, Error> {
    print(&match format {
        Format::Text => tree.to_string(),
        Format::Dot => tree.to_dot(None),
        Format::Svg => drawing::tree_svg(&FoldedTree::whole(&pictures::tree_nodes(&nodes(tree), &[]))),
        Format::Xml => tree.to_xml(),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// The nodes of a tree, as in records.
fn nodes(tree: &Tree) -> Vec<recording::Node> {
    tree.nodes().iter().map(recording::Node::from).collect()
}

/// Exit status 1 if there was an error in a node: a script that could not be evaluated, or a port without a value.
fn run(file: &Path, leaves: &Path, ticks: Option<u64>, as_json: bool) -> Result<ExitCode, Error> {
    let written = TreeScript::open(leaves)?;
    let tree = named_files::tree_with(&Disk::default(), file, written.leaves(), written.constants()?)?;
    let tree = Arc::new(tree);
    let script = written.read(&tree)?;
    let (mut moments, mut boards) = (Vec::new(), Vec::new());
    script.rehearse(&tree, ticks, |rehearsal, moment| {
        if as_json {
            boards.push(to_entries(&tree, rehearsal.execution().blackboard()));
        }
        moments.push(moment);
    })?;
    if as_json {
        print_json(&to_json(&tree, &moments, boards))?
    } else {
        print(&format!("{}\n{}\n", bt::table(&tree, &moments), legend(&moments)))?
    }
    let failed = moments.iter().any(|moment| !moment.faults.is_empty());
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// The meaning of the signs that appear in the table.
fn legend(moments: &[RehearsedTick]) -> String {
    let signs = [
        (Some(Outcome::Answered(Status::Success)), "S success"),
        (Some(Outcome::Answered(Status::Failure)), "F failure"),
        (Some(Outcome::Answered(Status::Running)), "R running"),
        (Some(Outcome::Answered(Status::Skipped)), "K skipped"),
        (Some(Outcome::Halted), "H halted"),
        (None, "· not reached"),
    ];
    let has = |outcome| moments.iter().flat_map(|moment| &moment.nodes).any(|node| node.outcome == outcome);
    signs.into_iter().filter(|(outcome, _)| has(*outcome)).map(|(_, words)| words).collect::<Vec<_>>().join(", ")
}

/// The contents of the blackboard: the entries of the main tree and of its subtrees.
fn to_entries(tree: &Tree, board: &bt::Blackboard) -> serde_json::Value {
    let subtrees = tree.nodes().iter().filter(|node| node.kind() == bt::Kind::SubTree);
    let subtrees: Vec<usize> = subtrees.map(|node| node.id().index()).collect();
    let entries = board.entries().map(|(keeper, key, value)| {
        // The main tree is 0, and subtrees follow in the order of their nodes.
        let subtree = keeper.checked_sub(1).map(|place| subtrees[place]);
        json!({ "subtree": subtree, "key": key, "value": to_value(value) })
    });
    entries.collect()
}

fn to_value(value: &bt::Value) -> serde_json::Value {
    match value {
        bt::Value::Int(number) => json!(number),
        bt::Value::Real(number) => json!(number),
        bt::Value::Text(text) => json!(**text),
        bt::Value::List(items) => items.iter().map(to_value).collect(),
    }
}

fn to_json(tree: &Tree, moments: &[RehearsedTick], boards: Vec<serde_json::Value>) -> serde_json::Value {
    let nodes = tree.nodes().iter().map(|node| {
        json!({
            "node": node.id().index(),
            "parent": node.parent().map(bt::NodeId::index),
            "kind": node.kind().name(),
            "id": node.type_id(),
            "label": node.label(),
            "process": node.kind().is_leaf().then(|| node.process()),
        })
    });
    let moments = moments.iter().zip(boards).map(|(moment, board)| {
        let outcomes = moment.nodes.iter().map(|node| node.outcome.map(Outcome::name));
        let calls = moment.calls.iter().zip(&moment.inputs).map(|(call, inputs)| {
            let node = call.leaf.index();
            let inputs =
                inputs.iter().map(|(port, value)| (port.clone(), value.as_ref().map_or(json!(null), to_value)));
            match call.request {
                Request::Tick => json!({
                    "node": node, "request": "tick", "inputs": inputs.collect::<serde_json::Map<_, _>>(),
                }),
                Request::Halt => json!({ "node": node, "request": "halt" }),
            }
        });
        let faults = moment.faults.iter();
        json!({
            "tick": moment.tick,
            "time_s": seconds(moment.time),
            "status": moment.status.map_or("halted", bt::Status::name),
            "nodes": outcomes.collect::<Vec<_>>(),
            "calls": calls.collect::<Vec<_>>(),
            "blackboard": board,
            "faults": faults.map(|f| json!({ "node": f.node.index(), "message": f.message })).collect::<Vec<_>>(),
        })
    });
    json!({ "tree": tree.name(), "nodes": nodes.collect::<Vec<_>>(), "ticks": moments.collect::<Vec<_>>() })
}
