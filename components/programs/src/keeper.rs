//! The keeper: a process between this one and a program, which ensures that no process of the program is left running.
//!
//! A program may start other processes in different process groups and sessions, and end before them. On Linux, all of
//! them stay descendants of the keeper ([a "subreaper"][1]), and of no other program's keeper. The keeper kills all
//! that are still running, and waits until they have ended, when the program has ended, when the keeper receives
//! SIGTERM, or when the process that started the keeper has ended. On other Unix systems, it kills the program's
//! process group.
//!
//! The program uses the keeper's standard streams. The keeper itself holds only stderr, whose other end closes when the
//! process that started the keeper ends, whatever the cause.
//!
//! A program can kill its keeper, since both belong to the same user. So there are two, and the program of the outer
//! keeper is the inner keeper. If the inner one is killed, the outer one inherits the remaining processes and kills
//! them. If the outer one is killed, the inner one receives SIGTERM ([the "parent-death signal"][2]). If both are
//! killed, the process that started them inherits the remaining processes, and kills them when it ends the program. It
//! also kills an outer keeper that does not end the program in time. So on Linux, a program escapes only if it kills
//! all three.
//!
//! The outer keeper sends SIGTERM to the inner one and never kills it. So an inner keeper that was ended by a signal
//! was killed by another process, even if the outer one received SIGTERM before it noticed.
//!
//! [1]: https://man7.org/linux/man-pages/man2/PR_SET_CHILD_SUBREAPER.2const.html
//! [2]: https://man7.org/linux/man-pages/man2/PR_SET_PDEATHSIG.2const.html

use std::collections::BTreeSet;
use std::env;
use std::ffi::OsString;
use std::fs::OpenOptions;
use std::io;
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::process::{
    Pid, Resource, Rlimit, Signal, WaitOptions, WaitStatus, kill_process, kill_process_group, setrlimit, wait, waitpid,
};
use rustix::stdio::{dup2_stdin, dup2_stdout};

/// The first argument of a keeper process; the second is the memory limit in bytes, or [`OUTER`], and the rest is the
/// command.
const KEEP: &str = "keep-a-program";

/// The second argument of an outer keeper, whose program is another keeper.
const OUTER: &str = "outer";

/// The exit status of a keeper whose program cannot be started.
const UNSTARTABLE: u8 = 127;

/// The exit status of an outer keeper whose inner one was killed.
pub(crate) const INNER_KILLED: u8 = 125;

/// The interval between signals to an inner keeper that is to end.
const BETWEEN_SWEEPS: Duration = Duration::from_millis(100);

/// The executable whose processes can be keepers.
static KEEPER: OnceLock<PathBuf> = OnceLock::new();

/// The program, which is also its process group: that of an outer keeper is the inner one.
static PROGRAM: OnceLock<Pid> = OnceLock::new();

/// Whether this keeper's program is another keeper that has not ended.
static HAS_INNER: AtomicBool = AtomicBool::new(false);

/// Whether all processes must end.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Call this at the beginning of `main`: this executable is started again as the keeper of each program. A keeper
/// process does its work in this function, and must end with the returned exit status.
#[must_use]
pub fn keep() -> Option<ExitCode> {
    let mut arguments = env::args_os().skip(1);
    if arguments.next().is_none_or(|first| first != KEEP) {
        // The file may be replaced while this process runs.
        let own = if cfg!(target_os = "linux") { Ok("/proc/self/exe".into()) } else { env::current_exe() };
        own.into_iter().for_each(keep_with);
        return None;
    }
    let limit = arguments.next().and_then(|bytes| match bytes.to_str()? {
        OUTER => Some(None),
        bytes => bytes.parse().ok().map(Some),
    });
    Some(limit.map_or(ExitCode::FAILURE, |limit| run(limit, arguments)))
}

/// Uses this executable for keepers; its `main` must call [`keep`]. Only the first call has an effect.
pub fn keep_with(program: PathBuf) {
    // Only the first call has an effect.
    let _ = KEEPER.set(program);
}

/// A command that starts another one with two keepers.
pub(crate) fn kept(memory_bytes: u64, command: &[OsString]) -> io::Result<Command> {
    let keeper =
        KEEPER.get().ok_or_else(|| io::Error::other("the `main` of this process does not call `programs::keep`"))?;
    let mut kept = Command::new(keeper);
    // Ctrl-C on a terminal reaches a whole process group: the process that started the keeper decides what to do then.
    kept.args([KEEP, OUTER]).arg(keeper).arg(KEEP).arg(memory_bytes.to_string()).args(command).process_group(0);
    Ok(kept)
}

/// The outer keepers that this process has started and not yet waited for. All its other children were inherited from
/// keepers that were killed: this process starts no others while programs run.
static KEEPERS: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

/// Starts a [`kept`] command.
pub(crate) fn spawn(command: &mut Command) -> io::Result<Child> {
    let mut keepers = KEEPERS.lock().unwrap_or_else(PoisonError::into_inner);
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_child_subreaper(Some(rustix::process::getpid()));
    let keeper = command.spawn()?;
    keepers.insert(keeper.id());
    Ok(keeper)
}

/// Call this after a keeper has ended and been waited for. If it was `killed`, kills the processes that it has left
/// behind, and waits until they have ended.
pub(crate) fn reaped(keeper: u32, killed: bool) {
    let mut keepers = KEEPERS.lock().unwrap_or_else(PoisonError::into_inner);
    keepers.remove(&keeper);
    #[cfg(target_os = "linux")]
    if killed {
        // When an orphan ends, its children become orphans.
        loop {
            let children = descendants::children(rustix::process::getpid());
            let mut orphans = children.filter(|pid| !keepers.contains(&pid.as_raw_pid().unsigned_abs())).peekable();
            if orphans.peek().is_none() {
                return;
            }
            for orphan in orphans {
                let _ = (kill_process(orphan, Signal::KILL), waitpid(Some(orphan), WaitOptions::empty()));
            }
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = killed;
}

/// The work of a keeper. Only an inner one has a limit.
fn run(memory_bytes: Option<u64>, mut command: impl Iterator<Item = OsString>) -> ExitCode {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_child_subreaper(Some(rustix::process::getpid()));
    // No core files beside the scenario.
    let _ = setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) });
    let _ = ctrlc::set_handler(end);
    #[cfg(target_os = "linux")]
    if memory_bytes.is_some() {
        let _ = rustix::process::set_parent_process_death_signal(Some(Signal::TERM));
    }
    std::thread::spawn(|| {
        let stderr = io::stderr();
        while poll(&mut [PollFd::new(&stderr, PollFlags::empty())], None) == Err(rustix::io::Errno::INTR) {}
        end();
    });
    let started = Command::new(command.next().unwrap_or_default()).args(command).process_group(0).spawn();
    match started {
        Ok(child) => ExitCode::from(supervise(Pid::from_child(&child), memory_bytes)),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(UNSTARTABLE)
        }
    }
}

/// Waits until the program and all processes that it started have ended. Returns the program's exit status or, like a
/// shell, 128 plus the number of the signal that ended it.
fn supervise(program: Pid, memory_bytes: Option<u64>) -> u8 {
    if let Some(bytes) = memory_bytes {
        limit_memory(program, bytes);
    }
    HAS_INNER.store(memory_bytes.is_none(), Ordering::SeqCst);
    PROGRAM.get_or_init(|| program);
    if let Ok(null) = OpenOptions::new().read(true).write(true).open("/dev/null") {
        let _ = (dup2_stdin(&null), dup2_stdout(&null));
    }
    if ENDING.load(Ordering::SeqCst) {
        sweep();
    }
    let mut status = None;
    loop {
        match wait(WaitOptions::empty()) {
            Ok(Some((ended, how))) if ended == program => {
                let was_inner = HAS_INNER.swap(false, Ordering::SeqCst);
                status = Some(if was_inner && how.signaled() { INNER_KILLED } else { shell_status(how) });
                end();
            }
            // Processes that were started in the meantime are orphans now: their parent has just been waited for.
            Ok(_) if ENDING.load(Ordering::SeqCst) => sweep(),
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(_) => return status.unwrap_or(0),
        }
    }
}

fn shell_status(status: WaitStatus) -> u8 {
    let code = status.exit_status().or_else(|| status.terminating_signal().map(|signal| 128 + signal));
    code.and_then(|code| u8::try_from(code).ok()).unwrap_or(u8::MAX)
}

#[cfg(target_os = "linux")]
fn limit_memory(program: Pid, bytes: u64) {
    let _ =
        rustix::process::prlimit(Some(program), Resource::As, Rlimit { current: Some(bytes), maximum: Some(bytes) });
}

#[cfg(not(target_os = "linux"))]
fn limit_memory(_: Pid, _: u64) {}

#[expect(clippy::disallowed_methods, reason = "processes end in real time")]
fn end() {
    ENDING.store(true, Ordering::SeqCst);
    sweep();
    // What was started during the sweep may have stopped the inner keeper again.
    while HAS_INNER.load(Ordering::SeqCst) {
        std::thread::sleep(BETWEEN_SWEEPS);
        sweep();
    }
}

/// Kills all processes that are running now, but sends SIGTERM to an inner keeper.
fn sweep() {
    let program = PROGRAM.get().copied();
    let inner = program.filter(|_| HAS_INNER.load(Ordering::SeqCst));
    #[cfg(target_os = "linux")]
    for pid in descendants::of(rustix::process::getpid()).into_iter().filter(|pid| Some(*pid) != inner) {
        let _ = kill_process(pid, Signal::KILL);
    }
    match (inner, program) {
        // The program, which has been killed, may have stopped the inner keeper with a signal.
        (Some(inner), _) => {
            let _ = (kill_process(inner, Signal::TERM), kill_process(inner, Signal::CONT));
        }
        (None, Some(group)) => {
            let _ = kill_process_group(group, Signal::KILL);
        }
        (None, None) => {}
    }
}

#[cfg(target_os = "linux")]
mod descendants {
    use std::collections::BTreeMap;
    use std::fs;

    use rustix::process::Pid;

    /// The descendants of a process.
    pub(super) fn of(ancestor: Pid) -> Vec<Pid> {
        let mut children: BTreeMap<i32, Vec<i32>> = BTreeMap::new();
        for (pid, parent) in processes() {
            children.entry(parent).or_default().push(pid);
        }
        let mut found = children.remove(&ancestor.as_raw_pid()).unwrap_or_default();
        let mut next = 0;
        while let Some(pid) = found.get(next) {
            found.extend(children.remove(pid).unwrap_or_default());
            next += 1;
        }
        found.into_iter().filter_map(Pid::from_raw).collect()
    }

    pub(super) fn children(parent: Pid) -> impl Iterator<Item = Pid> {
        let own = processes().filter(move |(_, of)| *of == parent.as_raw_pid());
        own.filter_map(|(pid, _)| Pid::from_raw(pid))
    }

    /// All processes, each with its parent.
    fn processes() -> impl Iterator<Item = (i32, i32)> {
        fs::read_dir("/proc").into_iter().flatten().filter_map(|entry| {
            let pid = entry.ok()?.file_name().to_str()?.parse().ok()?;
            let stat = fs::read(format!("/proc/{pid}/stat")).ok()?;
            // The name of the program is in parentheses, and may contain some itself; its state follows, then its
            // parent.
            let rest = &stat[stat.iter().rposition(|byte| *byte == b')')? + 1..];
            Some((pid, std::str::from_utf8(rest).ok()?.split_whitespace().nth(1)?.parse().ok()?))
        })
    }
}
