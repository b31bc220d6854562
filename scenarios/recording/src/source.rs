//! What gives the records of a run, and its way to the followers.

use std::ops::ControlFlow;
use std::path::Path;

use crate::{Archive, Detail, Follower, Recording, RecordingError, RunView};

/// Gives the records of a run, one after the other: a simulation, a recording, or events that monitors judge.
pub trait RecordSource {
    /// Why the run cannot begin or go on.
    type Error;

    /// The run at its start. Its steps are to have at least as much detail as `wanted`.
    ///
    /// # Errors
    /// If it cannot begin.
    fn start(&mut self, wanted: Detail) -> Result<RunView, Self::Error>;

    /// Advances the view by one step; the last step brings the end with it. If `is_stopped`, the source is to end
    /// with this step, without waiting; only runs do.
    ///
    /// # Errors
    /// If there is no further step.
    fn next(&mut self, view: &mut RunView, wanted: Detail, is_stopped: bool) -> Result<Next<Self::Error>, Self::Error>;
}

/// How a run has gone on.
#[derive(Debug)]
pub enum Next<E> {
    /// By a step.
    Step,
    /// Not yet: the next step may come later.
    Idle,
    /// By a step that shows why it cannot go on.
    Failed(E),
}

/// Takes a run to its end, for the follower that `begin` makes from its start. The follower sees at least as much as
/// `wanted`. `goes_on` is called at the start, after every step and while one waits, and may stop the run. If there is
/// a `record`, the run is written to it as an [`Archive`].
///
/// # Errors
/// A file that could not be written; the reason why the run cannot continue; an error of the follower.
pub fn conduct<S: RecordSource, F: Follower, E>(
    mut source: S,
    wanted: Detail,
    record: Option<&Path>,
    begin: impl FnOnce(&RunView) -> Result<F, E>,
    mut goes_on: impl FnMut(&RunView) -> ControlFlow<()>,
) -> Result<(F, RunView), E>
where
    E: From<S::Error> + From<diagnostics::Error> + From<F::Error>,
{
    let wanted = if record.is_some() { wanted.max(Detail::Full) } else { wanted };
    let mut view = source.start(wanted)?;
    let mut archive = record.map(|path| Archive::begin(path, &view)).transpose()?;
    let mut follower = begin(&view)?;
    loop {
        let is_stopped = goes_on(&view).is_break();
        if view.end().is_some() {
            break;
        }
        match source.next(&mut view, wanted, is_stopped)? {
            Next::Idle => {}
            Next::Step => {
                archive.follow(&view)?;
                follower.follow(&view)?;
            }
            Next::Failed(error) => {
                archive.follow(&view)?;
                archive.map_or(Ok(()), Archive::finish)?;
                return Err(error.into());
            }
        }
    }
    archive.map_or(Ok(()), Archive::finish)?;
    Ok((follower, view))
}

impl<S: RecordSource> RecordSource for &mut S {
    type Error = S::Error;

    fn start(&mut self, wanted: Detail) -> Result<RunView, S::Error> {
        (**self).start(wanted)
    }

    fn next(&mut self, view: &mut RunView, wanted: Detail, is_stopped: bool) -> Result<Next<S::Error>, S::Error> {
        (**self).next(view, wanted, is_stopped)
    }
}

/// Its steps have the detail with which they were recorded, and all of them are given.
impl RecordSource for Recording {
    type Error = RecordingError;

    fn start(&mut self, _: Detail) -> Result<RunView, RecordingError> {
        self.begin()
    }

    fn next(&mut self, view: &mut RunView, _: Detail, _: bool) -> Result<Next<RecordingError>, RecordingError> {
        self.advance(view).map(|()| Next::Step)
    }
}
