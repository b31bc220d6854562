//! A log and what it is judged by.

use std::path::{Path, PathBuf};

use bags::Remapping;
use recording::BagTree;

/// A log and what it is judged by.
#[derive(Clone, Copy, Debug)]
pub struct LogRequest<'r> {
    /// An event log, a recording, a log of BehaviorTree.CPP or a ROS 2 bag; `-` is standard input.
    pub path: &'r Path,
    /// The files with properties; without any, those that a recording contains.
    pub properties: &'r [PathBuf],
    /// The scenario with the processes and channels, if the log does not name it.
    pub scenario: Option<&'r str>,
    /// The file that maps the messages of a bag to channels.
    pub mapping: Option<&'r Path>,
    /// The robots of a bag.
    pub robots: Robots<'r>,
    /// The tree whose statuses a bag has.
    pub tree: Option<&'r BagTree>,
    /// Whether the log may still be written.
    pub is_followed: bool,
}

/// Robots, and what their topics are called.
#[derive(Clone, Copy, Debug, Default)]
pub struct Robots<'r> {
    /// The namespaces of several robots, each with `/` at its beginning.
    pub spaces: &'r [String],
    /// The topics, services and actions that have other names than in the mapping.
    pub remapped: &'r [Remapping],
}
