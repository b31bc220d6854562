//! The thread that checks.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Sender, channel};
use std::thread;

use editor::{Documents, Project};

use super::incoming::{CheckResult, Checked, Incoming};

/// What to check, and the number of the edit after which it is so.
pub(super) type Job = (u64, Documents);

/// Starts the thread. Of the jobs that wait, only the last one is done.
pub(super) fn start(results: Sender<Incoming>) -> Sender<Job> {
    let (sender, jobs) = channel::<Job>();
    thread::spawn(move || {
        let mut project = Project::default();
        while let Ok(mut job) = jobs.recv() {
            while let Ok(later) = jobs.try_recv() {
                job = later;
            }
            let (edit, documents) = job;
            // Should a reader of files ever panic, the editor goes on, and says so.
            let found = catch_unwind(AssertUnwindSafe(|| Checked {
                findings: project.check(&documents),
                contexts: project.contexts(&documents),
            }));
            let found = found.map_err(|panic| {
                project = Project::default();
                format!("a check failed: {}; please report this", reason(panic.as_ref()))
            });
            if results.send(Incoming::Checked(CheckResult { edit, found })).is_err() {
                break;
            }
        }
    });
    sender
}

fn reason(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("for an unknown reason")
}
