//! `steward tree`: behavior trees without a robot.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use bt::{Moment, Outcome, Rehearsal, Request, Tree};
use clap::{Subcommand, ValueEnum};
use serde_json::json;

use super::tree_script::{MOST_TICKS, TreeScript};
use super::{print, warn};
use crate::{Error, draw, pictures};

/// What can be done with a tree.
#[derive(Debug, Subcommand)]
pub(super) enum TreeCommand {
    /// Says everything that is wrong with a tree file, or looks wrong
    Check {
        /// The tree, BehaviorTree.CPP's XML
        file: PathBuf,
    },
    /// Shows a tree's nodes
    Show {
        /// The tree, BehaviorTree.CPP's XML
        file: PathBuf,
        /// An outline, a graph for Graphviz, a drawing, or format 4 of BehaviorTree.CPP's XML
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
    },
    /// Ticks a tree whose leaves answer by a script, and prints every node's status at every tick
    Run {
        /// The tree, BehaviorTree.CPP's XML
        file: PathBuf,
        /// What each leaf answers at each of its ticks (TOML)
        #[arg(long, value_name = "FILE")]
        leaves: PathBuf,
        /// How many ticks; as long as the longest part if neither this nor the file says so
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=MOST_TICKS))]
        ticks: Option<u64>,
        /// Prints JSON
        #[arg(long)]
        json: bool,
    },
}

/// How a tree is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    Text,
    Dot,
    Svg,
    Xml,
}

/// Carries out a command on a tree.
pub(super) fn tree(command: &TreeCommand) -> Result<ExitCode, Error> {
    match command {
        TreeCommand::Check { file } => check(&open(file)?),
        TreeCommand::Show { file, format } => show(&open(file)?, *format),
        TreeCommand::Run { file, leaves, ticks, json } => run(file, leaves, *ticks, *json),
    }
}

fn open(file: &Path) -> Result<Tree, Error> {
    Tree::from_file(file).map_err(Error::bad_input)
}

fn check(tree: &Tree) -> Result<ExitCode, Error> {
    if let Some(concerns) = tree.concerns() {
        warn(concerns);
    }
    let (nodes, leaves) = (tree.nodes().len(), tree.leaves().count());
    let note = if tree.concerns().is_none() { "nothing to complain about" } else { "it can run" };
    print(&format!("{}: {nodes} nodes, {leaves} of them leaves; {note}\n", tree.name()))?;
    Ok(ExitCode::SUCCESS)
}

fn show(tree: &Tree, format: Format) -> Result<ExitCode, Error> {
    print(&match format {
        Format::Text => tree.to_string(),
        Format::Dot => tree.to_dot(None),
        Format::Svg => draw::tree_svg(&pictures::tree_nodes(tree, &[])),
        Format::Xml => tree.to_xml(),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Exit status 1 if something went wrong in a node: a script that could not be evaluated, a port without a value.
fn run(file: &Path, leaves: &Path, ticks: Option<u64>, as_json: bool) -> Result<ExitCode, Error> {
    let tree = Arc::new(open(file)?);
    let script = TreeScript::open(leaves, &tree)?;
    let moments = rehearse(&tree, &script, ticks)?;
    let text = if as_json { to_json(&tree, &moments) } else { bt::table(&tree, &moments) };
    print(&text)?;
    let failed = moments.iter().any(|moment| !moment.faults.is_empty());
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn rehearse(tree: &Arc<Tree>, script: &TreeScript, ticks: Option<u64>) -> Result<Vec<Moment>, Error> {
    let mut rehearsal = Rehearsal::new(Arc::clone(tree), script.parts.iter().cloned());
    for (key, value) in &script.blackboard {
        let board = rehearsal.execution_mut().blackboard_mut();
        board.set(key, value.clone()).map_err(|error| {
            Error::refused(format!("`{key}` on the blackboard: {error}"), "the entry is used as a port of that type")
        })?;
    }
    let mut moments = Vec::new();
    for tick in 0..ticks.unwrap_or(script.ticks) {
        let now = script.period.saturating_mul(u32::try_from(tick).unwrap_or(u32::MAX));
        moments.push(rehearsal.tick(now));
        if script.halts.contains(&(tick + 1)) {
            moments.push(rehearsal.halt(now));
        }
    }
    Ok(moments)
}

fn to_json(tree: &Tree, moments: &[Moment]) -> String {
    let nodes = tree.nodes().iter().map(|node| {
        json!({
            "node": node.id().index(),
            "parent": node.parent().map(bt::NodeId::index),
            "kind": node.kind().name(),
            "id": node.type_id(),
            "label": node.label(),
        })
    });
    let moments = moments.iter().map(|moment| {
        let outcomes = moment.nodes.iter().map(|node| node.outcome.map(Outcome::name));
        let calls = moment.calls.iter().map(|call| {
            let request = if call.request == Request::Tick { "tick" } else { "halt" };
            json!({ "node": call.leaf.index(), "request": request })
        });
        let faults = moment.faults.iter();
        json!({
            "tick": moment.tick,
            "time_s": moment.time.as_secs_f64(),
            "status": moment.status.map_or("halted", bt::Status::name),
            "nodes": outcomes.collect::<Vec<_>>(),
            "calls": calls.collect::<Vec<_>>(),
            "faults": faults.map(|f| json!({ "node": f.node.index(), "message": f.message })).collect::<Vec<_>>(),
        })
    });
    let all = json!({ "tree": tree.name(), "nodes": nodes.collect::<Vec<_>>(), "ticks": moments.collect::<Vec<_>>() });
    serde_json::to_string_pretty(&all).expect("what is printed is always JSON") + "\n"
}
