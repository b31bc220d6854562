//! Conducts a run from start to end.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use recording::{Archive, Detail, Ended, RecordRef, RunView};

use crate::Error;
use crate::ending::Ending;
use crate::live::Live;

/// Runs a scenario to its end. `follow` is called at the start and after every step, and may stop the run: one more
/// step then ends it as [interrupted](Ended::Interrupted). `follow` sees at least as much as `detail` requires. If
/// there is a `record`, the run is written to it as an [`Archive`].
///
/// # Errors
/// A file that could not be written; the reason why the run cannot continue; an error of `follow`.
pub fn conduct<E: From<Error>>(
    mut live: Live,
    detail: Detail,
    record: Option<&Path>,
    mut follow: impl FnMut(&RunView) -> Result<ControlFlow<()>, E>,
) -> Result<RunView, E> {
    let detail = if record.is_some() { detail.max(Detail::Full) } else { detail };
    let scenario = Arc::clone(live.scenario());
    let (header, start) = (live.header(), live.record(detail));
    let archive = record.map(|path| Archive::begin(path, &header, &start)).transpose();
    let mut archive = archive.map_err(Error::from)?;
    let mut view = RunView::new(header, start).expect(FITS);
    let mut ending = Ending::default();
    loop {
        if let Some(archive) = &mut archive {
            archive.follow(&view).map_err(Error::from)?;
        }
        let interrupted = follow(&view)?.is_break().then_some(Ended::Interrupted);
        if view.end().is_some() {
            break;
        }
        let failure = live.step().err();
        let step = live.record(detail);
        // A failed step is also recorded: it may show the reason.
        if let Some(archive) = &mut archive {
            archive.record(RecordRef::Step(&step)).map_err(Error::from)?;
        }
        view.apply(step).expect(FITS);
        if let Some(failure) = failure {
            if let Some(mut archive) = archive {
                archive.follow(&view).map_err(Error::from)?;
                archive.finish().map_err(Error::from)?;
            }
            return Err(Error::from(failure).into());
        }
        let over = live.is_over().then_some(Ended::Scheduled);
        if let Some(why) = ending.reached(&scenario.file, &view).or(over).or(interrupted) {
            let end = live.end(why, detail);
            if let Some(archive) = &mut archive {
                archive.record(RecordRef::End(&end)).map_err(Error::from)?;
            }
            view.finish(end).expect(FITS);
        }
    }
    archive.map_or(Ok(()), Archive::finish).map_err(Error::from)?;
    Ok(view)
}

/// The invariant of the records of a run in progress.
pub const FITS: &str = "a run's records refer only to what its header contains";
