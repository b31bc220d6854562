//! The thread that checks.

use std::sync::mpsc::{Sender, channel};
use std::thread;

use editor::{Documents, Project};

use crate::guard::guarded;
use crate::incoming::{CheckResult, Incoming};

/// What to check, and the number of the edit after which it is so.
pub(crate) type Job = (u64, Documents);

/// Starts the thread. Of the jobs that wait, only the last one is done.
pub(crate) fn start(results: Sender<Incoming>) -> Sender<Job> {
    let (sender, jobs) = channel::<Job>();
    thread::spawn(move || {
        let mut project = Project::default();
        while let Ok(mut job) = jobs.recv() {
            while let Ok(later) = jobs.try_recv() {
                job = later;
            }
            let (edit, documents) = job;
            let found = guarded(|| project.check(&documents));
            if found.is_err() {
                project = Project::default();
            }
            if results.send(Incoming::Checked(CheckResult { edit, found })).is_err() {
                break;
            }
        }
    });
    sender
}
