//! The commands that the listener receives on its standard input.

use std::io::stdin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::exchange::{LEAVING, ListenerCommand, Subscribed};
use crate::clock::sleep;

/// The commands that have been received and not been executed.
#[derive(Default)]
pub(super) struct Inbox {
    /// Whether the input has ended. Then the listener ends as well.
    is_closed: AtomicBool,
    /// The new subscriptions, if they have changed.
    subscribed: Mutex<Option<Subscribed>>,
    commands: Mutex<Vec<ListenerCommand>>,
}

impl Inbox {
    /// Receives commands in a thread of its own, which wakes the current thread for each of them. A while after the
    /// input has ended, it ends the process.
    pub(super) fn open() -> Arc<Self> {
        let inbox = Arc::new(Self::default());
        let (listening, received) = (std::thread::current(), Arc::clone(&inbox));
        std::thread::spawn(move || {
            while let Some(command) = ListenerCommand::read(&mut stdin().lock()) {
                match command {
                    ListenerCommand::Join { .. } => {}
                    ListenerCommand::Subscribe(to) => *locked(&received.subscribed) = Some(to),
                    ListenerCommand::Publish(_)
                    | ListenerCommand::Request(_)
                    | ListenerCommand::Serve(..)
                    | ListenerCommand::Respond(_) => locked(&received.commands).push(command),
                }
                listening.unpark();
            }
            received.is_closed.store(true, Ordering::Relaxed);
            listening.unpark();
            // The process that started this one has left the domain or ended. This one must not outlive it.
            sleep(LEAVING);
            std::process::exit(0);
        });
        inbox
    }

    pub(super) fn is_closed(&self) -> bool {
        self.is_closed.load(Ordering::Relaxed)
    }

    /// The new subscriptions, if they have changed since the last call.
    pub(super) fn take_subscribed(&self) -> Option<Subscribed> {
        locked(&self.subscribed).take()
    }

    /// The other commands since the last call.
    pub(super) fn take_commands(&self) -> Vec<ListenerCommand> {
        std::mem::take(&mut *locked(&self.commands))
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
