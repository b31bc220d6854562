//! `--tree FILE`: the tree whose statuses a bag has.

use std::convert::Infallible;
use std::path::{Path, PathBuf};

use campaigns::Error;
use checks::named_files;
use clap::Args;
use diagnostics::Disk;
use recording::{BagTree, Recording};
use reports::html::quoted;

/// The tree of a bag that Nav2 wrote.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct BagTreeArgs {
    /// The tree that ran, for a bag with Nav2's topic `/behavior_tree_log`: the XML file that Nav2 loaded. Of several
    /// such topics, `/TOPIC=FILE` names one
    #[arg(long, value_name = "[TOPIC=]FILE", value_parser = topic_and_file)]
    tree: Option<TopicAndFile>,
}

/// The file of a tree, and the topic that it belongs to.
#[derive(Clone, Debug)]
struct TopicAndFile {
    topic: Option<String>,
    file: PathBuf,
}

/// A file may have any name: what exists is one.
fn topic_and_file(text: &str) -> Result<TopicAndFile, Infallible> {
    let named = text.split_once('=').filter(|(topic, _)| topic.starts_with('/') && !Path::new(text).exists());
    let (topic, file) = named.map_or((None, text), |(topic, file)| (Some(topic.to_owned()), file));
    Ok(TopicAndFile { topic, file: file.into() })
}

impl BagTreeArgs {
    /// The tree, if one is named: then not all of the logs may have a tree of their own.
    pub(crate) fn load(&self, logs: &[PathBuf]) -> Result<Option<BagTree>, Error> {
        let Some(TopicAndFile { topic, file }) = &self.tree else { return Ok(None) };
        if logs.iter().all(|log| Recording::open(log).is_ok()) {
            let help = "leave it out: a recording, and a log of BehaviorTree.CPP, has its tree";
            return Err(Error::refused("`--tree` is for a ROS 2 bag", help));
        }
        Ok(Some(BagTree { topic: topic.clone(), ..named_files::tree(&Disk::default(), file)?.into() }))
    }

    /// Its file, or the name of a shipped one.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.tree.as_ref().map(|tree| tree.file.as_path())
    }

    /// Whether one is named.
    pub(crate) fn is_named(&self) -> bool {
        self.tree.is_some()
    }

    /// As words of a command.
    pub(crate) fn words(&self) -> impl Iterator<Item = String> {
        let words = |TopicAndFile { topic, file }: &TopicAndFile| {
            let topic = topic.as_ref().map_or_else(String::new, |topic| format!("{topic}="));
            ["--tree".to_owned(), quoted(&(topic + &file.to_string_lossy()))]
        };
        self.tree.iter().flat_map(words)
    }
}
