//! The scripts that run before and after a node's ticks.

use crate::Status;
use crate::blackboard::Blackboard;
use crate::script::{Script, ScriptError};

/// The scripts of one node.
#[derive(Clone, Debug, PartialEq, Default)]
pub(crate) struct Hooks {
    pub(crate) failure_if: Option<Script>,
    pub(crate) success_if: Option<Script>,
    pub(crate) skip_if: Option<Script>,
    pub(crate) while_: Option<Script>,
    pub(crate) on_halted: Option<Script>,
    pub(crate) on_failure: Option<Script>,
    pub(crate) on_success: Option<Script>,
    pub(crate) post: Option<Script>,
}

/// The effect of a node's scripts before its tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entrance {
    /// It is ticked.
    Open,
    /// It gives this answer instead.
    Closed(Status),
    /// It was running and is halted; then it is skipped.
    Left,
}

impl Hooks {
    /// The attributes that contain scripts.
    pub(crate) const NAMES: [&str; 8] =
        ["_failureIf", "_successIf", "_skipIf", "_while", "_onHalted", "_onFailure", "_onSuccess", "_post"];

    /// Whether a node with this status may be ticked; `None` is idle.
    pub(crate) fn enter(&self, was: Option<Status>, board: &mut Blackboard) -> Result<Entrance, ScriptError> {
        let mut holds = |script: &Option<Script>| script.as_ref().map(|script| script.holds(board)).transpose();
        match was {
            None => {
                if holds(&self.failure_if)? == Some(true) {
                    return Ok(Entrance::Closed(Status::Failure));
                }
                if holds(&self.success_if)? == Some(true) {
                    return Ok(Entrance::Closed(Status::Success));
                }
                if holds(&self.skip_if)? == Some(true) || holds(&self.while_)? == Some(false) {
                    return Ok(Entrance::Closed(Status::Skipped));
                }
            }
            Some(Status::Running) if holds(&self.while_)? == Some(false) => return Ok(Entrance::Left),
            Some(_) => {}
        }
        Ok(Entrance::Open)
    }

    /// Runs the scripts for a node that has succeeded or failed.
    pub(crate) fn leave(&self, status: Status, board: &mut Blackboard) -> Result<(), ScriptError> {
        let own = match status {
            Status::Success => &self.on_success,
            Status::Failure => &self.on_failure,
            Status::Running | Status::Skipped => return Ok(()),
        };
        for script in [own, &self.post].into_iter().flatten() {
            script.run(board)?;
        }
        Ok(())
    }

    /// Runs the script for a node that has been halted.
    pub(crate) fn halted(&self, board: &mut Blackboard) -> Result<(), ScriptError> {
        self.on_halted.as_ref().map_or(Ok(()), |script| script.run(board).map(|_| ()))
    }

    pub(crate) fn script(&mut self, attribute: &str) -> Option<&mut Option<Script>> {
        Some(match attribute {
            "_failureIf" => &mut self.failure_if,
            "_successIf" => &mut self.success_if,
            "_skipIf" => &mut self.skip_if,
            "_while" => &mut self.while_,
            "_onHalted" => &mut self.on_halted,
            "_onFailure" => &mut self.on_failure,
            "_onSuccess" => &mut self.on_success,
            "_post" => &mut self.post,
            _ => return None,
        })
    }

    /// Those that decide whether the node is ticked.
    pub(crate) fn conditions(&self) -> impl Iterator<Item = &Script> {
        [&self.failure_if, &self.success_if, &self.skip_if, &self.while_].into_iter().flatten()
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = &Script> {
        let before = [&self.failure_if, &self.success_if, &self.skip_if, &self.while_];
        let after = [&self.on_halted, &self.on_failure, &self.on_success, &self.post];
        before.into_iter().chain(after).flatten()
    }

    pub(crate) fn has_entrance(&self) -> bool {
        [&self.failure_if, &self.success_if, &self.skip_if, &self.while_].into_iter().any(Option::is_some)
    }

    pub(crate) fn has_exit(&self) -> bool {
        [&self.on_failure, &self.on_success, &self.post].into_iter().any(Option::is_some)
    }
}
