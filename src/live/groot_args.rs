//! What `steward live --groot` takes.

use std::path::PathBuf;

use clap::Args;

use crate::out_file::OutFile;

/// A program that runs a tree, and what is done with what it sends.
#[derive(Clone, Debug, Args)]
pub(crate) struct GrootArgs {
    /// Shows the tree that a program with BehaviorTree.CPP runs: the host, and the port of its Groot2Publisher
    #[arg(long, value_name = "HOST[:PORT]", conflicts_with_all = ["runs", "seed", "set", "use_sim_time"])]
    pub(crate) groot: Option<String>,
    /// Checks the program against a property file, or a shipped one by its name; may be given more than once
    #[arg(long = "property", value_name = "FILE", conflicts_with = "runs")]
    pub(crate) properties: Vec<PathBuf>,
    /// Writes what the program sends to FILE, a recording; after each change of the tree to another, with a number
    #[arg(long, value_name = "FILE", conflicts_with = "runs")]
    pub(crate) record: Option<OutFile>,
    /// Only requests the statuses of the nodes, a hundred times a second, and leaves transitions to others, such as
    /// Groot2: what changes in between is not seen
    #[arg(long, conflicts_with = "runs")]
    pub(crate) passive: bool,
}
