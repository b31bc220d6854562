//! `--tree FILE`: the tree whose statuses a bag has.

use std::path::{Path, PathBuf};

use bt::Tree;
use campaigns::Error;
use clap::Args;
use recording::Recording;
use reports::html::quoted;

use crate::named_files;

/// The tree of a bag that Nav2 wrote.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct BagTreeArgs {
    /// The tree that ran, for a bag with Nav2's topic `/behavior_tree_log`: the XML file that Nav2 loaded
    #[arg(long, value_name = "FILE")]
    tree: Option<PathBuf>,
}

impl BagTreeArgs {
    /// The tree, if one is named: then not all of the logs may have a tree of their own.
    pub(crate) fn load(&self, logs: &[PathBuf]) -> Result<Option<Tree>, Error> {
        let Some(file) = &self.tree else { return Ok(None) };
        if logs.iter().all(|log| Recording::open(log).is_ok()) {
            let help = "leave it out: a recording, and a log of BehaviorTree.CPP, has its tree";
            return Err(Error::refused("`--tree` is for a ROS 2 bag", help));
        }
        Ok(Some(named_files::tree(file)?))
    }

    /// Whether one is named.
    pub(crate) fn is_named(&self) -> bool {
        self.tree.is_some()
    }

    /// As words of a command.
    pub(crate) fn words(&self) -> impl Iterator<Item = String> {
        let file = self.tree.as_deref().map(Path::to_string_lossy);
        file.into_iter().flat_map(|file| ["--tree".to_owned(), quoted(&file)])
    }
}
