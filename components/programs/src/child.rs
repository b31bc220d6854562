//! A running program: it receives lines, and answers each with a line.

use std::convert::Infallible;
use std::io::{self, Read, Write as _};
use std::path::Path;
use std::process::{self, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::program::{Limits, Program};

/// The maximum length of an answer, in bytes.
pub(crate) const LONGEST: usize = 1 << 20;

/// How much of a program's stderr is kept, from its end.
const KEPT_OF_STDERR: usize = 4 << 10;

/// How many of the last lines on stderr are reported, and how many characters of each.
const SHOWN_LINES: usize = 3;
const SHOWN_CHARACTERS: usize = 200;

/// What a program that prints something else has to know.
pub(crate) const ONLY_ANSWERS: &str = "standard output is only for answers, so print anything else to standard error";

/// How long a program whose input has ended has time to write what nobody asked for, before it is killed. One that ends
/// with its input takes some 20 ms. Chosen, not measured.
const FAREWELL: Duration = Duration::from_secs(1);

/// How long to wait for the end of a program after everything of it has been killed.
const PATIENCE: Duration = Duration::from_secs(10);

/// A running program. When the value is dropped, nothing of the program is left running.
#[derive(Debug)]
pub(crate) struct Child {
    /// The program's keeper or, on systems without keepers, the program itself.
    process: process::Child,
    requests: Sender<String>,
    answers: Receiver<Vec<u8>>,
    /// Output received after the last answer.
    rest: Vec<u8>,
    stderr: Arc<Mutex<Vec<u8>>>,
    /// Closed when `process` has ended.
    gone: Receiver<Infallible>,
    is_stopped: bool,
    limits: Limits,
    /// The folder of the files that came with it.
    _folder: Option<TempDir>,
}

/// Why a program did not answer, as a phrase that follows its name.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Silence {
    #[error("cannot be started: {0}")]
    Unstartable(#[from] io::Error),
    #[error("{} before it answered", ending(.0))]
    Ended(process::ExitStatus),
    #[error("closed its standard output before it answered")]
    Closed,
    #[error("did not answer within {} s", .0.as_secs_f64())]
    Timeout(Duration),
    #[error("did not end its line within {} s: {:?}", .0.as_secs_f64(), .1)]
    HalfALine(Duration, String),
    #[error("wrote a line that is longer than {} bytes", LONGEST)]
    TooLong,
    #[error("wrote without being asked: {0:?}; {ONLY_ANSWERS}")]
    Unasked(String),
    #[error("{} when the run ended", ending(.0))]
    Gone(process::ExitStatus),
    #[error("wrote a line that is not UTF-8")]
    NotText,
}

impl Child {
    /// Starts a program.
    pub(crate) fn start(program: &Program) -> Result<Self, Silence> {
        let temporary = program.needs_folder().then(TempDir::new).transpose()?;
        let path = temporary.as_ref().map_or(Path::new(""), TempDir::path);
        let command = program.command(path)?;
        let limits = program.limits();
        #[cfg(unix)]
        let mut command = crate::keeper::kept(limits.memory_bytes, &command)?;
        #[cfg(not(unix))]
        let mut command = {
            let mut direct = Command::new(&command[0]);
            direct.args(&command[1..]);
            direct
        };
        Self::spawn(command.current_dir(program.folder().unwrap_or(path)), limits, temporary)
    }

    fn spawn(command: &mut Command, limits: Limits, folder: Option<TempDir>) -> Result<Self, Silence> {
        let command = command.env_clear().envs(Program::environment());
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        let mut process = crate::keeper::spawn(command)?;
        #[cfg(not(unix))]
        let mut process = command.spawn()?;
        let streams = (process.stdin.take(), process.stdout.take(), process.stderr.take());
        let (Some(mut stdin), Some(stdout), Some(stderr)) = streams else { unreachable!("all three are pipes") };
        let ((requests, lines), (chunks, answers), (running, gone)) = (channel::<String>(), sync_channel(1), channel());
        let end = Arc::default();
        let child = Self {
            process,
            requests,
            answers,
            rest: Vec::new(),
            stderr: Arc::clone(&end),
            gone,
            is_stopped: false,
            limits,
            _folder: folder,
        };
        let thread = || Builder::new().name("program".to_owned());
        // A program that does not read makes its writer wait until both are ended.
        thread().spawn(move || lines.into_iter().try_for_each(|line| stdin.write_all(line.as_bytes())))?;
        thread().spawn(move || pump(stdout, &chunks))?;
        thread().spawn(move || keep_end(stderr, &end, running))?;
        Ok(child)
    }

    /// Sends the program a line and waits for its answer. After an error it must not be asked again.
    ///
    /// It waits in real time, so only a program that answers in time makes a run reproducible. The first line is the
    /// answer, no matter what follows it and when: that is found before the next question or at the end.
    pub(crate) fn ask(&mut self, mut line: String) -> Result<String, Silence> {
        self.unasked(Duration::ZERO)?;
        line.push('\n');
        // The program may have closed its input and still answer.
        let _ = self.requests.send(line);
        let deadline = now() + self.limits.answer_within;
        let mut searched = 0;
        loop {
            if let Some(end) = self.rest[searched..].iter().position(|byte| *byte == b'\n') {
                return self.answer(searched + end);
            }
            searched = self.rest.len();
            if searched > LONGEST {
                return Err(Silence::TooLong);
            }
            match self.answers.recv_timeout(deadline.saturating_duration_since(now())) {
                Ok(chunk) => self.rest.extend(chunk),
                Err(RecvTimeoutError::Timeout) if self.rest.is_empty() => {
                    return Err(Silence::Timeout(self.limits.answer_within));
                }
                Err(RecvTimeoutError::Timeout) => {
                    return Err(Silence::HalfALine(self.limits.answer_within, beginning(&self.rest)));
                }
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended(deadline)),
            }
        }
    }

    /// The line up to this newline.
    fn answer(&mut self, newline: usize) -> Result<String, Silence> {
        let more = self.rest.split_off(newline + 1);
        let mut line = std::mem::replace(&mut self.rest, more);
        line.pop();
        String::from_utf8(line).map_err(|_| Silence::NotText)
    }

    /// An error if the program has written more than its answers, or does so within this time.
    fn unasked(&mut self, within: Duration) -> Result<(), Silence> {
        if self.rest.is_empty() {
            self.rest.extend(self.answers.recv_timeout(within).unwrap_or_default());
        }
        if self.rest.is_empty() { Ok(()) } else { Err(Silence::Unasked(beginning(&self.rest))) }
    }

    /// The reason why there is no more output.
    fn ended(&mut self, deadline: Instant) -> Silence {
        match self.gone.recv_timeout(deadline.saturating_duration_since(now())) {
            Err(RecvTimeoutError::Disconnected) => self.process.wait().map_or_else(Silence::from, Silence::Ended),
            _ => Silence::Closed,
        }
    }

    /// Ends the program. Returns its last lines on stderr, if it wrote any.
    pub(crate) fn end(mut self) -> Option<String> {
        self.stop();
        let stderr = self.stderr.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&stderr);
        let mut lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let lines = lines.split_off(lines.len().saturating_sub(SHOWN_LINES));
        let shown: Vec<String> = lines.iter().map(|line| line.chars().take(SHOWN_CHARACTERS).collect()).collect();
        (!shown.is_empty()).then(|| shown.join(" / "))
    }

    /// Ends the program. An error if it, or a process that watches it, had ended before, if it ends with a failure, or
    /// if it has written without being asked. To find that out, its input is closed: a program that ends with its input
    /// has then written all. Whether a failure comes before or after that depends on real time, so both count.
    pub(crate) fn conclude(&mut self) -> Result<(), Silence> {
        self.unasked(Duration::ZERO)?;
        if let Some(status) = self.process.try_wait()? {
            return Err(Silence::Gone(status));
        }
        self.requests = channel().0;
        let deadline = now() + FAREWELL;
        self.unasked(FAREWELL)?;
        let left = deadline.saturating_duration_since(now());
        let has_ended = self.gone.recv_timeout(left) == Err(RecvTimeoutError::Disconnected);
        self.stop();
        match self.process.try_wait()? {
            Some(status) if has_ended && !status.success() => Err(Silence::Gone(status)),
            // The outer keeper may not yet have noticed it.
            #[cfg(unix)]
            Some(status) if was_unkept(&status) => Err(Silence::Gone(status)),
            _ => Ok(()),
        }
    }

    /// Kills all its processes and waits until they are gone.
    fn stop(&mut self) {
        if std::mem::replace(&mut self.is_stopped, true) {
            return;
        }
        // Once a process has been waited for, its number may belong to another one.
        if matches!(self.process.try_wait(), Ok(None)) {
            #[cfg(unix)]
            let _ = rustix::process::kill_process(
                rustix::process::Pid::from_child(&self.process),
                rustix::process::Signal::TERM,
            );
            #[cfg(not(unix))]
            let _ = self.process.kill();
            if self.gone.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                // A program has stopped its keeper, or something escaped from it.
                let _ = self.process.kill();
            }
        }
        let ended = self.process.wait();
        #[cfg(unix)]
        crate::keeper::buried(self.process.id(), ended.is_ok_and(|status| status.code().is_none()));
        #[cfg(not(unix))]
        drop(ended);
        // It is closed when everything that could write to it is gone.
        let _ = self.gone.recv_timeout(PATIENCE);
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Passes on what a program writes, never more than a little ahead of the reader.
fn pump(mut stdout: impl Read, chunks: &SyncSender<Vec<u8>>) {
    let mut chunk = vec![0; 1 << 16];
    while let Ok(length @ 1..) = stdout.read(&mut chunk) {
        if chunks.send(chunk[..length].to_vec()).is_err() {
            return;
        }
    }
}

/// Keeps the end of what a program writes to stderr. `_running` is closed when the output ends.
fn keep_end(mut stderr: impl Read, end: &Mutex<Vec<u8>>, _running: Sender<Infallible>) {
    let mut chunk = [0; KEPT_OF_STDERR];
    while let Ok(length @ 1..) = stderr.read(&mut chunk) {
        let mut end = end.lock().unwrap_or_else(PoisonError::into_inner);
        end.extend(&chunk[..length]);
        let excess = end.len().saturating_sub(KEPT_OF_STDERR);
        end.drain(..excess);
    }
}

#[expect(clippy::disallowed_methods, reason = "a program is waited for in real time")]
fn now() -> Instant {
    Instant::now()
}

/// The beginning of a program's output, at most a line, for a message.
fn beginning(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).lines().next().unwrap_or_default().chars().take(60).collect()
}

/// How a program ended, as a phrase that follows its name. Like a shell, a keeper reports signals as exit statuses.
fn ending(status: &process::ExitStatus) -> String {
    #[cfg(unix)]
    if was_unkept(status) {
        return "lost a process that watches it, which was killed, and was ended".to_owned();
    }
    #[cfg(unix)]
    if let Some(signal) = status.code().and_then(|code| rustix::process::Signal::from_named_raw(code.checked_sub(128)?))
    {
        let signal = format!("{signal:?}").trim_matches('"').replace("ABORT", "ABRT");
        return format!("ended with {}", signal.replace("Signal::", "the signal SIG"));
    }
    status.code().map_or_else(|| format!("ended with {status}"), |code| format!("ended with exit status {code}"))
}

/// Whether one of a program's keepers was killed. A program's own exit status may be the same.
#[cfg(unix)]
fn was_unkept(status: &process::ExitStatus) -> bool {
    status.code().is_none_or(|code| code == i32::from(crate::keeper::UNKEPT))
}
