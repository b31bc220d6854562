//! Values that Nav2's nodes read: rates, and the robot, its goals and its path from the blackboard.

use std::collections::VecDeque;
use std::sync::Arc;

use super::input::{Input, ReadError};
use super::pose;
use crate::Status;
use crate::blackboard::{Blackboard, Slot, Type, Value, ValueError};
use crate::semantics::PortReading;

/// Values that one of Nav2's nodes reads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Nav2 {
    Index(Index),
    /// The numbers of the watched entries that are requests to pause and to resume.
    Requests([usize; 2]),
    Rate(Input),
    Distance(DistanceLimit),
    Speed(SpeedLimit),
    Goals(Goals),
    Updates([Update; 2]),
    Path(DetourGuard),
}

/// The distance after which a child is ticked again.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DistanceLimit {
    pub(crate) distance: Input,
    pub(crate) pose: Slot,
    /// The number of the memo with the position where the distance begins.
    pub(crate) memo: usize,
}

/// The rate for the current speed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SpeedLimit {
    /// Minimum and maximum.
    pub(crate) rates: [Input; 2],
    pub(crate) speeds: [Input; 2],
    pub(crate) speed: Slot,
    pub(crate) goals: Goals,
}

/// A path that may become much longer near the goal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DetourGuard {
    pub(crate) path: Option<Input>,
    pub(crate) near: Input,
    pub(crate) factor: Input,
    /// The number of the memo with the previous path and the one of the last tick.
    pub(crate) memo: usize,
}

/// The index of a child, which is an entry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Index {
    pub(crate) slot: Slot,
    pub(crate) key: Arc<str>,
    pub(crate) children: usize,
    /// The number of the memo with the index of the child that is ticked: a child may change the entry.
    pub(crate) memo: usize,
}

/// A goal and a list of goals that may change.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Goals {
    pub(crate) goals: [Input; 2],
    /// The number of the memo with the last ones.
    pub(crate) memo: usize,
}

/// A goal that may be replaced by an update.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Update {
    pub(crate) input: Option<Input>,
    pub(crate) update: Slot,
    pub(crate) output: Option<Slot>,
}

impl Nav2 {
    /// The entries that it reads, except those of which it only counts how often they are written.
    pub(crate) fn entries(&self) -> Vec<Slot> {
        let of = |inputs: &[&Input]| inputs.iter().filter_map(|input| input.entry()).collect::<Vec<_>>();
        match self {
            Self::Index(index) => vec![index.slot],
            Self::Requests(_) => Vec::new(),
            Self::Rate(hz) => of(&[hz]),
            Self::Distance(limit) => [of(&[&limit.distance]), vec![limit.pose]].concat(),
            Self::Speed(SpeedLimit { rates, speeds, speed, goals }) => {
                let inputs = rates.iter().chain(speeds).chain(&goals.goals).collect::<Vec<_>>();
                [of(&inputs), vec![*speed]].concat()
            }
            Self::Goals(goals) => of(&goals.goals.each_ref()),
            Self::Updates(updates) => {
                let slots = updates.iter().flat_map(|update| {
                    let input = update.input.as_ref().and_then(Input::entry);
                    [input, Some(update.update), update.output].into_iter().flatten()
                });
                slots.collect()
            }
            Self::Path(guard) => {
                let inputs = guard.path.iter().chain([&guard.near, &guard.factor]).collect::<Vec<_>>();
                of(&inputs)
            }
        }
    }

    /// The entries that it writes.
    pub(crate) fn outputs(&self) -> Vec<Slot> {
        match self {
            Self::Index(index) => vec![index.slot],
            Self::Updates(updates) => updates.iter().filter_map(|update| update.output).collect(),
            _ => Vec::new(),
        }
    }

    /// Reads what the node needs when it is ticked. `starts` means that it was idle.
    pub(super) fn read(&self, board: &mut Blackboard, starts: bool) -> Result<PortReading, ReadError> {
        match self {
            Self::Index(index) => index.begin(board),
            Self::Requests(requests) => {
                Ok(PortReading::Numbers(requests.map(|number| board.has_changed(number).into())))
            }
            Self::Rate(hz) => Ok(PortReading::Numbers([period(real(hz, board)?)?, 0])),
            Self::Distance(limit) => limit.read(board, starts),
            Self::Speed(limit) => limit.read(board, starts),
            Self::Goals(goals) if goals.have_changed(board, starts) => Ok(PortReading::Proceed),
            Self::Goals(_) => Ok(PortReading::Nothing),
            Self::Updates(updates) => {
                updates.iter().try_for_each(|update| update.pass(board))?;
                Ok(PortReading::Proceed)
            }
            Self::Path(guard) => guard.read(board),
        }
    }

    /// Reads what the node needs when a child has given this answer.
    pub(super) fn read_after(&self, status: Status, board: &mut Blackboard) -> Result<PortReading, ReadError> {
        match self {
            Self::Index(index) => {
                let current = board.memo(index.memo).as_ref().and_then(|kept| kept.front()?.to_int().ok());
                let next = if status == Status::Failure { 0 } else { current.unwrap_or_default().saturating_add(1) };
                Ok(PortReading::Numbers([index.move_to(next, board)?, 0]))
            }
            Self::Distance(DistanceLimit { pose, memo, .. }) => {
                let Some(here) = position(board, *pose)? else { return Ok(PortReading::Status(Status::Failure)) };
                *board.memo(*memo) = Some(of_position(here));
                Ok(PortReading::Proceed)
            }
            Self::Path(DetourGuard { memo, .. }) => {
                // The new path becomes the previous one.
                if let Some(kept) = board.memo(*memo)
                    && kept.len() > 1
                {
                    kept.pop_front();
                }
                Ok(PortReading::Proceed)
            }
            _ => Ok(PortReading::Nothing),
        }
    }
}

impl DistanceLimit {
    fn read(&self, board: &mut Blackboard, starts: bool) -> Result<PortReading, ReadError> {
        let Some(here) = position(board, self.pose)? else { return Ok(PortReading::Status(Status::Failure)) };
        let distance = real(&self.distance, board)?;
        let kept = board.memo(self.memo);
        Ok(match kept.as_ref().filter(|_| !starts).and_then(as_position) {
            Some(from) if pose::distance(from, here) < distance => PortReading::Nothing,
            Some(_) => PortReading::Proceed,
            None => {
                *kept = Some(of_position(here));
                PortReading::Proceed
            }
        })
    }
}

impl SpeedLimit {
    /// Whether a goal is new, 1 or 0, and the period of the rate: linear between the two speeds, and at most the
    /// maximum beyond them.
    fn read(&self, board: &mut Blackboard, starts: bool) -> Result<PortReading, ReadError> {
        let [min_rate, max_rate] = [real(&self.rates[0], board)?, real(&self.rates[1], board)?];
        let [min_speed, max_speed] = [real(&self.speeds[0], board)?, real(&self.speeds[1], board)?];
        if self.goals.have_changed(board, starts) {
            return Ok(PortReading::Numbers([1, period(max_rate)?]));
        }
        let speed = board.value(self.speed).map_or(Ok(0.0), Value::to_real)?;
        let share = (speed - min_speed) / (max_speed - min_speed);
        let rate = (share * (max_rate - min_rate) + min_rate).min(max_rate).max(min_rate);
        Ok(PortReading::Numbers([0, period(rate)?]))
    }
}

impl DetourGuard {
    fn read(&self, board: &mut Blackboard) -> Result<PortReading, ReadError> {
        let new = self.path.as_ref().and_then(|path| path.value(board)).map_or(Arc::default(), Value::to_text);
        let (near, factor) = (real(&self.near, board)?, real(&self.factor, board)?);
        let kept = board.memo(self.memo);
        let old = kept.as_ref().and_then(|kept| Some(kept.front()?.to_text()));
        let is_longer = old.as_deref().map_or(Ok(false), |old| is_detour(old, &new, near, factor))?;
        // While the child is busy with a detour, new paths are compared with the path before it.
        let previous = old.filter(|_| is_longer).unwrap_or_else(|| new.clone());
        *kept = Some([Value::Text(previous), Value::Text(new)].into());
        Ok(if is_longer { PortReading::Proceed } else { PortReading::Status(Status::Success) })
    }
}

impl Index {
    /// The child to tick, or success if the index is past the last child.
    fn begin(&self, board: &mut Blackboard) -> Result<PortReading, ReadError> {
        let current = self.read(board)?;
        if usize::try_from(current).is_ok_and(|current| current >= self.children) {
            self.move_to(current, board)?;
            return Ok(PortReading::Status(Status::Success));
        }
        *board.memo(self.memo) = Some([Value::Int(current)].into());
        Ok(PortReading::Numbers([current, 0]))
    }

    fn read(&self, board: &Blackboard) -> Result<i64, ReadError> {
        Ok(board.value(self.slot).ok_or_else(|| ReadError::Empty(self.key.clone()))?.to_int()?)
    }

    /// Writes the index, 0 if it is past the last child.
    fn move_to(&self, index: i64, board: &mut Blackboard) -> Result<i64, ValueError> {
        let index = if usize::try_from(index).is_ok_and(|index| index < self.children) { index } else { 0 };
        board.write(self.slot, Value::Int(index), &Type::INT, true)?;
        *board.memo(self.memo) = Some([Value::Int(index)].into());
        Ok(index)
    }
}

impl Goals {
    /// Whether one of them differs from what it was at the last tick, or the node starts.
    fn have_changed(&self, board: &mut Blackboard, starts: bool) -> bool {
        let now: VecDeque<Value> = self.goals.iter().map(|goal| shown(goal.value(board))).collect();
        let before = board.memo(self.memo).replace(now);
        starts || before != *board.memo(self.memo)
    }
}

impl Update {
    /// Writes the update, or else the input, to the output.
    fn pass(&self, board: &mut Blackboard) -> Result<(), ReadError> {
        let input = self.input.as_ref().and_then(|input| input.value(board));
        let update = board.value(self.update).filter(|update| match pose::stamp(&update.to_text()) {
            Some(0) => false,
            Some(stamp) => input.and_then(|input| pose::stamp(&input.to_text())).is_none_or(|own| stamp >= own),
            None => true,
        });
        match (self.output, update.or(input).cloned()) {
            (Some(output), Some(goal)) => Ok(board.write(output, goal, &Type::Any, true)?),
            _ => Ok(()),
        }
    }
}

/// The nanoseconds between two ticks at this rate.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a period that is too long for the type becomes the longest that it allows"
)]
pub(crate) fn period(hz: f64) -> Result<i64, ReadError> {
    if hz > 0.0 { Ok((1e9 / hz).round() as i64) } else { Err(ValueError::new(hz, "a rate greater than 0").into()) }
}

fn real(input: &Input, board: &Blackboard) -> Result<f64, ReadError> {
    Ok(input.read(board, &Type::Real)?.to_real()?)
}

/// The value of an entry, or an empty string.
fn shown(value: Option<&Value>) -> Value {
    value.cloned().unwrap_or_else(|| "".into())
}

/// The position in an entry; `None` if it has no value.
fn position(board: &Blackboard, slot: Slot) -> Result<Option<[f64; 2]>, ValueError> {
    let Some(pose) = board.value(slot) else { return Ok(None) };
    pose::position(&pose.to_text()).map(Some).ok_or_else(|| ValueError::new(pose, "a pose, such as `1.5;2`"))
}

fn of_position(position: [f64; 2]) -> VecDeque<Value> {
    position.map(Value::Real).into()
}

fn as_position(kept: &VecDeque<Value>) -> Option<[f64; 2]> {
    Some([kept.front()?.to_real().ok()?, kept.get(1)?.to_real().ok()?])
}

/// Whether the new path to the same goal is longer than the old one by this factor, and the goal was near.
fn is_detour(old: &str, new: &str, near: f64, factor: f64) -> Result<bool, ValueError> {
    let path = |text: &str| pose::path(text).ok_or_else(|| ValueError::new(text, "a path, such as `0;0;1.5;2`"));
    let (old, new) = (path(old)?, path(new)?);
    let have_same_goal = old.last().is_some() && old.last() == new.last();
    let length = pose::length(&old);
    Ok(have_same_goal && old.len() != new.len() && length < near && pose::length(&new) > factor * length)
}
