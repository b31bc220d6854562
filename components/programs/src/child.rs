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

/// The hint for a program that prints anything else.
pub(crate) const ONLY_ANSWERS: &str = "standard output is only for answers, so print anything else to standard error";

/// How long a program may continue after its input has been closed, before it is killed. Whatever it writes in that
/// time is unsolicited. A program that ends with its input takes about 20 ms. Chosen, not measured.
const GRACE: Duration = Duration::from_secs(1);

/// How long to wait for the end of a program after all its processes have been killed.
const END_TIMEOUT: Duration = Duration::from_secs(10);

/// A running program. When this value is dropped, all processes of the program are ended.
#[derive(Debug)]
pub(crate) struct Child {
    /// The outer keeper of the program or, on systems without keepers, the program itself.
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

/// Why a program gave no valid answer, as a phrase that follows its name.
#[derive(Debug, thiserror::Error)]
pub(crate) enum AnswerError {
    #[error("cannot be started: {0}")]
    Unstartable(#[from] io::Error),
    #[error("{} before it answered", ending(.0))]
    Ended(process::ExitStatus),
    #[error("closed its standard output before it answered")]
    Closed,
    #[error("did not answer within {} s", .0.as_secs_f64())]
    Timeout(Duration),
    #[error("did not end its line within {} s: {:?}", .0.as_secs_f64(), .1)]
    IncompleteLine(Duration, String),
    #[error("wrote a line that is longer than {} bytes", LONGEST)]
    TooLong,
    #[error("wrote without a request: {0:?}; {ONLY_ANSWERS}")]
    Unsolicited(String),
    #[error("{} when the run ended", ending(.0))]
    FailedAtEnd(process::ExitStatus),
    #[error("wrote a line that is not UTF-8")]
    NotText,
}

impl Child {
    pub(crate) fn start(program: &Program) -> Result<Self, AnswerError> {
        let temporary = program.needs_folder().then(TempDir::new).transpose()?;
        let path = temporary.as_ref().map_or(Path::new(""), TempDir::path);
        let command = program.command(path)?;
        let limits = program.limits;
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

    fn spawn(command: &mut Command, limits: Limits, folder: Option<TempDir>) -> Result<Self, AnswerError> {
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
        // If a program does not read its input, this thread blocks until the program is ended.
        thread().spawn(move || lines.into_iter().try_for_each(|line| stdin.write_all(line.as_bytes())))?;
        thread().spawn(move || pump(stdout, &chunks))?;
        thread().spawn(move || keep_end(stderr, &end, running))?;
        Ok(child)
    }

    /// Sends the program a line and waits for its answer. After an error, no more lines may be sent.
    ///
    /// It waits in real time, so only a program that answers in time makes a run reproducible. The first line is the
    /// answer, no matter what follows it and when: anything more is found before the next request or at the end.
    pub(crate) fn request(&mut self, mut line: String) -> Result<String, AnswerError> {
        self.check_unsolicited(Duration::ZERO)?;
        line.push('\n');
        // The program may answer even after it has closed its input.
        let _ = self.requests.send(line);
        let deadline = now() + self.limits.answer_within;
        let mut searched = 0;
        loop {
            if let Some(end) = self.rest[searched..].iter().position(|byte| *byte == b'\n') {
                return self.answer(searched + end);
            }
            searched = self.rest.len();
            if searched > LONGEST {
                return Err(AnswerError::TooLong);
            }
            match self.answers.recv_timeout(deadline.saturating_duration_since(now())) {
                Ok(chunk) => self.rest.extend(chunk),
                Err(RecvTimeoutError::Timeout) if self.rest.is_empty() => {
                    return Err(AnswerError::Timeout(self.limits.answer_within));
                }
                Err(RecvTimeoutError::Timeout) => {
                    return Err(AnswerError::IncompleteLine(self.limits.answer_within, beginning(&self.rest)));
                }
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended(deadline)),
            }
        }
    }

    /// The line up to this newline.
    fn answer(&mut self, newline: usize) -> Result<String, AnswerError> {
        let more = self.rest.split_off(newline + 1);
        let mut line = std::mem::replace(&mut self.rest, more);
        line.pop();
        String::from_utf8(line).map_err(|_| AnswerError::NotText)
    }

    /// An error if the program has written more than its answers, or does so within this time.
    fn check_unsolicited(&mut self, within: Duration) -> Result<(), AnswerError> {
        if self.rest.is_empty() {
            self.rest.extend(self.answers.recv_timeout(within).unwrap_or_default());
        }
        if self.rest.is_empty() { Ok(()) } else { Err(AnswerError::Unsolicited(beginning(&self.rest))) }
    }

    /// The reason why there is no more output.
    fn ended(&mut self, deadline: Instant) -> AnswerError {
        match self.gone.recv_timeout(deadline.saturating_duration_since(now())) {
            Err(RecvTimeoutError::Disconnected) => {
                self.process.wait().map_or_else(AnswerError::from, AnswerError::Ended)
            }
            _ => AnswerError::Closed,
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

    /// Ends the program. An error if it, or one of its keepers, had ended before, if it ends with a failure, or if it
    /// has written unsolicited output. To find this out, its input is closed: a program that ends with its input has
    /// then written all its output. Whether a failure comes before or after that depends on real time, so both count.
    pub(crate) fn conclude(&mut self) -> Result<(), AnswerError> {
        self.check_unsolicited(Duration::ZERO)?;
        if let Some(status) = self.process.try_wait()? {
            return Err(AnswerError::FailedAtEnd(status));
        }
        self.requests = channel().0;
        let deadline = now() + GRACE;
        self.check_unsolicited(GRACE)?;
        let left = deadline.saturating_duration_since(now());
        let has_ended = self.gone.recv_timeout(left) == Err(RecvTimeoutError::Disconnected);
        self.stop();
        match self.process.try_wait()? {
            Some(status) if has_ended && !status.success() => Err(AnswerError::FailedAtEnd(status)),
            // The outer keeper may not have noticed this yet.
            #[cfg(unix)]
            Some(status) if keeper_was_killed(&status) => Err(AnswerError::FailedAtEnd(status)),
            _ => Ok(()),
        }
    }

    /// Kills all its processes and waits until they have ended.
    fn stop(&mut self) {
        if std::mem::replace(&mut self.is_stopped, true) {
            return;
        }
        // The number of a process that has been waited for may already belong to another process.
        if matches!(self.process.try_wait(), Ok(None)) {
            #[cfg(unix)]
            let _ = rustix::process::kill_process(
                rustix::process::Pid::from_child(&self.process),
                rustix::process::Signal::TERM,
            );
            #[cfg(not(unix))]
            let _ = self.process.kill();
            if self.gone.recv_timeout(END_TIMEOUT) == Err(RecvTimeoutError::Timeout) {
                // The program has stopped its keeper, or one of its processes has escaped.
                let _ = self.process.kill();
            }
        }
        let ended = self.process.wait();
        #[cfg(unix)]
        crate::keeper::reaped(self.process.id(), ended.is_ok_and(|status| status.code().is_none()));
        #[cfg(not(unix))]
        drop(ended);
        // This channel is closed when every process that could write to stderr has ended.
        let _ = self.gone.recv_timeout(END_TIMEOUT);
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Forwards a program's output in chunks, at most two of them ahead of the reader.
fn pump(mut stdout: impl Read, chunks: &SyncSender<Vec<u8>>) {
    let mut chunk = vec![0; 1 << 16];
    while let Ok(length @ 1..) = stdout.read(&mut chunk) {
        if chunks.send(chunk[..length].to_vec()).is_err() {
            return;
        }
    }
}

/// Keeps the end of a program's stderr. `_running` is closed when the output ends.
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
    if keeper_was_killed(status) {
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
fn keeper_was_killed(status: &process::ExitStatus) -> bool {
    status.code().is_none_or(|code| code == i32::from(crate::keeper::INNER_KILLED))
}
