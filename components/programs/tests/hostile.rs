//! Faulty programs: each fails with one clear message, and none of its processes is left running.

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::time::Duration;

use channels::{Action, Process};
use programs::{Limits, Program, ProgramProcess, Word};

use crate::machine::has_python;
use crate::stage::{Stage, keeper, say, sent};

/// Enough time for a program to fail, even when many tests run at once. Tests of missing answers wait less.
const LIMITS: Limits = Limits { answer_within: Duration::from_secs(60), memory_bytes: 1 << 30 };

/// Enough time for a shell to start, and then to fail because it does not answer.
const SHORT_LIMITS: Limits = Limits { answer_within: Duration::from_secs(2), ..LIMITS };

/// The beginning of a program that works until it receives `say`.
const WORKING_AT_FIRST: &str = "import os, signal, sys, time
sys.stdin.readline()
print('{}', flush=True)
sys.stdin.readline()
";

/// The same for the shell.
const SHELL_WORKING_AT_FIRST: &str = "read line; echo '{}'; read line\n";

/// The failure of a program that does this when it receives `say`.
fn failure_when_requested(doing: &str) -> Option<String> {
    let stage = Stage::new(&format!("{WORKING_AT_FIRST}{doing}\n"));
    has_python().then(|| failure(&stage, "python3", LIMITS))
}

/// The only failure of a program that works at first.
fn failure(stage: &Stage, interpreter: &str, limits: Limits) -> String {
    let mut process = stage.command(&[interpreter, "program.py"], limits);
    process.start(Duration::ZERO).unwrap();
    say(&mut process, 0, 1, "hello", 1.0);
    let [mishap] = process.mishaps() else { panic!("one failure, not {:?}", process.mishaps()) };
    let message = mishap.message.clone();
    assert_eq!(stage.left_over(), [""; 0], "{message}");

    // From now on it receives every message and answers none.
    assert_eq!((process.location().as_str(), process.next_timer()), ("crashed", None));
    for request in 2..4 {
        let mut offers = Vec::new();
        process.offers(&mut offers);
        assert!(offers.len() == 2 && offers.iter().all(|offer| matches!(offer.action, Action::Receive(..))));
        say(&mut process, 0, request, "hello?", 2.0);
    }
    assert_eq!((sent(&mut process), process.mishaps().len()), (vec![], 1));
    message
}

/// Checks the failure of a Python program that does this.
#[track_caller]
fn fails(doing: &str, expected: &str) {
    if let Some(message) = failure_when_requested(doing) {
        check(&message, expected);
    }
}

/// Checks the failure of a shell program that does this and never answers.
#[track_caller]
fn fails_without_answer(doing: &str, expected: &str) {
    let stage = Stage::new(&format!("{SHELL_WORKING_AT_FIRST}{doing}\n"));
    check(&failure(&stage, "sh", SHORT_LIMITS), expected);
}

#[track_caller]
fn check(message: &str, expected: &str) {
    let expected = format!("the program, sent `say` by Guide, {expected}");
    assert!(message.starts_with(&expected), "{message:?} does not begin with {expected:?}");
}

/// Checks the failure of a program that gives this answer.
#[track_caller]
fn answers_wrongly(answer: &str, expected: &str) {
    fails(&format!("print({answer:?}, flush=True); time.sleep(1000)"), &format!("answered wrongly: {expected}"));
}

#[test]
fn a_program_that_never_answers_is_ended() {
    for doing in ["sleep 1000", "while :; do :; done", "kill -STOP $$", "exec <&-; sleep 1000"] {
        fails_without_answer(doing, "did not answer within 2 s");
    }
    fails_without_answer("echo 'I am busy' >&2; sleep 1000", "did not answer within 2 s; on stderr: I am busy");
    fails_without_answer("yes >&2", "did not answer within 2 s; on stderr: y / y / y");
    fails_without_answer("exec >&-; sleep 1000", "closed its standard output before it answered");
}

#[test]
fn half_a_line_is_not_an_answer() {
    fails_without_answer("printf '{}'; sleep 1000", "did not end its line within 2 s: \"{}\"");
    fails_without_answer("printf '{'", "ended with exit status 0 before it answered");
}

#[test]
fn how_a_program_ended_is_reported() {
    fails("sys.exit(3)", "ended with exit status 3");
    fails("os.kill(os.getpid(), signal.SIGSEGV)", "ended with the signal SIGSEGV");
    fails("os.abort()", "ended with the signal SIGABRT");
    let message = failure_when_requested("1 / 0");
    assert!(message.is_none_or(|message| message.ends_with(" / ZeroDivisionError: division by zero")));
}

#[test]
fn a_program_that_ends_at_the_start_fails_there() {
    if !has_python() {
        return;
    }
    let fails_to_start = |command: &[&str]| {
        let stage = Stage::new("import speech");
        let mut process = stage.command(command, LIMITS);
        let failure = process.start(Duration::ZERO).unwrap_err().to_string();
        assert_eq!((stage.left_over(), process.location()), (vec![], "crashed".to_owned()));
        failure
    };
    let message = fails_to_start(&["python3", "program.py"]);
    let (begins, ends) = (
        "the program, sent `start`, ended with exit status 1 before it answered; on stderr: ",
        "No module named 'speech'",
    );
    assert!(message.starts_with(begins) && message.ends_with(ends), "{message}");
    let message = fails_to_start(&["python3", "speaker.py"]);
    assert!(
        message.starts_with("the program, sent `start`, ended with exit status 2 before it answered; on stderr: "),
        "{message}"
    );
    assert!(message.contains("No such file"), "{message}");
}

#[test]
fn a_file_that_cannot_be_executed_is_reported() {
    let stage = Stage::new("");
    let file = stage.folder.path().join("binary");
    std::fs::write(&file, [0, 1, 2]).unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
    let failure = stage.command(&["./binary"], LIMITS).start(Duration::ZERO).unwrap_err().to_string();
    assert!(
        failure.starts_with(
            "the program, sent `start`, ended with exit status 127 before it answered; on stderr: Exec format error"
        ),
        "{failure}"
    );
}

#[test]
fn a_flood_is_cut_off() {
    let long = "wrote a line that is longer than 1048576 bytes";
    fails("while True: sys.stdout.write('x' * 65536)", long);
    fails("sys.stdout.write('{\"state\": \"' + 'x' * 2000000 + '\"}\\n'); sys.stdout.flush(); time.sleep(1000)", long);
}

/// A program that does this when it receives `say`, until its input ends. It has received one.
fn asked_once(doing: &str) -> (Stage, ProgramProcess) {
    let stage = Stage::new(&format!("{WORKING_AT_FIRST}{doing}\nfor line in sys.stdin: print('{{}}', flush=True)\n"));
    let mut process = stage.process(LIMITS);
    process.start(Duration::ZERO).unwrap();
    say(&mut process, 0, 1, "hello", 1.0);
    assert_eq!(process.mishaps(), []);
    (stage, process)
}

#[test]
fn the_first_line_is_the_answer_and_what_follows_it_is_found_later() {
    if !has_python() {
        return;
    }
    let unasked = |line: &str| format!("wrote without a request: {line:?}; standard output is only for answers");
    let cases = [
        ("os.write(1, b'{}\\nso far\\n')", "so far"),
        ("print('{}', flush=True); print('so far', flush=True)", "so far"),
        (
            "print('{}', flush=True); time.sleep(0.3); print('{\"state\": \"late\"}', flush=True)",
            "{\"state\": \"late\"}",
        ),
        ("while True: os.write(1, b'{}\\n' * 20000)", "{}"),
    ];
    for (doing, line) in cases {
        let (stage, mut process) = asked_once(doing);
        process.conclude();
        let [mishap] = process.mishaps() else { panic!("one failure, not {:?}", process.mishaps()) };
        assert!(mishap.message.contains(&unasked(line)), "{}", mishap.message);
        assert_eq!(stage.left_over(), [""; 0]);
    }
    // It is written together with the answer, so it always arrives before the next message.
    let (_stage, mut process) = asked_once(cases[0].0);
    say(&mut process, 0, 2, "hello", 2.0);
    let message = &process.mishaps()[0].message;
    assert!(message.contains(&format!("sent `say` by Guide, {}", unasked("so far"))), "{message}");

    let (_stage, process) = asked_once(cases[0].0);
    let restarted = process.succeeding(&process, Duration::from_secs(2));
    assert!(restarted.mishaps()[0].message.contains(&unasked("so far")), "{:?}", restarted.mishaps());
    assert_eq!(restarted.location(), "running");
}

#[test]
fn a_program_that_only_answers_is_ended_without_a_failure() {
    if !has_python() {
        return;
    }
    // The first ends with its input, the second continues.
    for doing in ["print('{}', flush=True)", "print('{}', flush=True); time.sleep(1000)"] {
        let (stage, mut process) = asked_once(doing);
        process.conclude();
        assert_eq!((process.mishaps(), stage.left_over()), (&[][..], vec![]));
    }
}

/// Whether the program has noticed the end of its input depends on real time.
#[test]
fn a_program_that_ends_with_a_failure_at_the_end_of_its_run_has_failed() {
    if !has_python() {
        return;
    }
    let told = [
        ("print('{}', flush=True); os._exit(3)", "the program ended with exit status 3 when the run ended"),
        (
            "print('{}', flush=True); os.kill(os.getpid(), signal.SIGSEGV)",
            "the program ended with the signal SIGSEGV when the run ended",
        ),
        (
            "print('{}', flush=True); sys.stdin.read(); sys.exit('no more')",
            "the program ended with exit status 1 when the run ended; on stderr: no more",
        ),
    ];
    for (doing, message) in told {
        let (stage, mut process) = asked_once(doing);
        process.conclude();
        let messages: Vec<&str> = process.mishaps().iter().map(|mishap| mishap.message.as_str()).collect();
        assert_eq!(messages, [message]);
        assert_eq!(stage.left_over(), [""; 0]);
    }
}

#[test]
fn an_unsolicited_line_is_noticed_before_the_next_message() {
    if !has_python() {
        return;
    }
    let stage = Stage::new(
        "import sys, time\nfor line in sys.stdin:\n print('{}', flush=True)\n time.sleep(0.01)\n print('and then', flush=True)",
    );
    let mut process = stage.process(LIMITS);
    process.start(Duration::ZERO).unwrap();
    // The second line may arrive at any time: it may count as the answer to the next message.
    say(&mut process, 0, 1, "hello", 1.0);
    say(&mut process, 0, 2, "hello", 2.0);
    let message = &process.mishaps()[0].message;
    assert!(message.contains("wrote without a request") || message.contains("it is not JSON"), "{message}");
    assert_eq!(stage.left_over(), [""; 0]);
}

#[test]
fn nonsense_is_reported_with_its_position() {
    answers_wrongly("hello", "it is not JSON: expected value at column 1: hello");
    answers_wrongly("{\"send\": NaN}", "it is not JSON: ");
    answers_wrongly("{} {}", "it is not JSON: trailing characters at column 4: {} {}");
    answers_wrongly("[]", "it must be a JSON object: []");
    answers_wrongly("{\"sent\": []}", "at `sent`: unknown field `sent`, expected one of `send`, `timers`, `state`: {");
    answers_wrongly("{\"send\": {}}", "at `send`: invalid type: map, expected a sequence");
    answers_wrongly("{\"send\": [{\"to\": 1}]}", "at `send[0].to`: invalid type: integer `1`, expected a string");
    answers_wrongly("{\"send\": [{\"to\": \"Guide\"}]}", "at `send[0]`: missing field `event`");
    answers_wrongly(
        "{\"timers\": [{\"event\": \"x\", \"after\": \"1\"}]}",
        "at `timers[0].after`: invalid type: string",
    );
    answers_wrongly(
        "{\"timers\": [{\"event\": \"x\", \"after\": 0}]}",
        "at `timers[0].after`: 0 is not between 0.001 and",
    );
    answers_wrongly(&format!("{}1{}", "[".repeat(200), "]".repeat(200)), "it is not JSON: recursion limit exceeded");
    answers_wrongly("{\"timers\": [[1, \"x\"]]}", "at `timers[0]`: it must be a JSON object");
    fails("sys.stdout.buffer.write(b'\\xff\\n'); sys.stdout.flush()", "wrote a line that is not UTF-8");
}

#[test]
fn a_message_that_its_channel_does_not_carry_is_reported_with_its_position() {
    let send = |sent: &str| format!("{{\"send\": [{{\"to\": \"Guide\", \"event\": \"ok\"}}, {sent}]}}");
    let second = |sent: &str, expected: &str| answers_wrongly(&send(sent), &format!("at `send[1]`: {expected}"));
    second("{\"to\": \"Gide\", \"event\": \"ok\"}", "there is no channel Speaker → Gide");
    second("{\"to\": \"Host\", \"event\": \"okay\"}", "<okay> cannot be sent to Host: no message begins with <okay>");
    second("{\"to\": \"Host\", \"event\": \"error\"}", "<error> cannot be sent to Host: the field reason is missing");
    second(
        "{\"to\": \"Host\", \"event\": \"error\", \"data\": {\"reason\": 3}}",
        "<error> cannot be sent to Host: the field reason is text, and 3 is not",
    );
    second("{\"to\": \"Host\", \"event\": \"ok\"}", "<ok> answers nothing: Host is not waiting for an answer");
    second("{\"to\": \"Guide\", \"event\": \"ok\"}", "<ok> answers nothing: Guide is not waiting for an answer");
}

#[test]
fn memory_is_limited() {
    let message = failure_when_requested("x = bytearray(10 << 30)");
    assert!(message.is_none_or(|message| message.ends_with("MemoryError")));
}

#[test]
fn nothing_that_a_program_started_is_left_running() {
    // Children in sessions of their own whose parents have ended, and which ignore all signals that can be ignored.
    let hide = "
def hide():
    if os.fork(): return
    os.setsid()
    if os.fork(): os._exit(0)
    for number in range(1, 65):
        try: signal.signal(number, signal.SIG_IGN)
        except (OSError, ValueError): pass
    os.write(ready, b'.')
    time.sleep(1000)
wait, ready = os.pipe()
for _ in range(3): hide()
os.read(wait, 1), os.read(wait, 1), os.read(wait, 1)
";
    fails(&format!("{hide}sys.exit(3)"), "ended with exit status 3");
    fails_without_answer(
        "(setsid sh -c 'trap \"\" HUP INT TERM; sleep 1000; :' &); sleep 1000",
        "did not answer within 2 s",
    );
    fails(&format!("{hide}os.close(1); os.close(2); os.kill(0, signal.SIGKILL)"), "ended with the signal SIGKILL");
    fails(
        &format!("{hide}os.execvp('env', ['env', '-i', 'sh', '-c', 'setsid sleep 1000 & exit 4'])"),
        "ended with exit status 4",
    );
    fails_without_answer("while :; do setsid sleep 1000 & sleep 0.02; done", "did not answer within 2 s");
}

/// A number below `below` from a sequence.
fn draw(state: &mut u64, below: u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state % below
}

/// A process of the program, or one of its keepers, is stopped for a while, or killed, while messages are sent. This is
/// repeated `STOPS` times (default 8). The program has received all messages that it has answered, and a killed process
/// is one failure.
#[test]
#[expect(clippy::disallowed_methods, reason = "processes are stopped in real time")]
fn a_keeper_may_be_stopped_for_a_while_and_its_death_is_noticed() {
    if !has_python() {
        return;
    }
    let seed: u64 = env_number("SEED", 1);
    for stop in 0..env_number("STOPS", 8) {
        let mut random = 0x9e37_79b9_7f4a_7c15 ^ ((seed << 32) | (stop + 1));
        let stage = Stage::new(
            "import json, sys\ntold = open('told', 'w')\nfor line in sys.stdin:\n text = json.loads(line)['data'].get('text', '')\n \
             print(text, file=told, flush=True)\n print(json.dumps({'state': text or 'begun'}), flush=True)",
        );
        let mut process = stage.process(LIMITS);
        process.start(Duration::ZERO).unwrap();
        let running = running(stage.folder.path());
        // The program, its inner keeper and its outer keeper.
        assert!(running.len() >= 3, "{running:?}");
        let target = running[draw(&mut random, running.len() as u64) as usize];
        let kills = draw(&mut random, 4) == 0;
        // From 10 ms to 1.3 s, and as often below as above 0.1 s.
        let (before, shortest) = (draw(&mut random, 50), 10 << draw(&mut random, 7));
        let pause = shortest + draw(&mut random, shortest);
        let signal = |signal: &str| {
            let done = std::process::Command::new("kill").args([&format!("-{signal}"), &target.to_string()]).status();
            assert!(done.is_ok_and(|done| done.success()));
        };
        let sleep = |milliseconds| std::thread::sleep(Duration::from_millis(milliseconds));
        let mut answered = vec!["begun".to_owned()];
        std::thread::scope(|scope| {
            let stopping = scope.spawn(|| {
                sleep(before);
                signal(if kills { "KILL" } else { "STOP" });
                sleep(pause);
                if !kills {
                    signal("CONT");
                }
            });
            for number in 1.. {
                let text = format!("text {number}");
                say(&mut process, 0, number, &text, number as f64);
                if process.location() != text {
                    break;
                }
                answered.push(text);
                if stopping.is_finished() {
                    break;
                }
                sleep(3);
            }
        });
        process.conclude();
        let told = std::fs::read_to_string(stage.folder.path().join("told")).unwrap();
        let told: Vec<&str> = told.lines().map(|text| if text.is_empty() { "begun" } else { text }).collect();
        let of = format!("stop {stop}: {} of {target} among {running:?}", if kills { "death" } else { "pause" });
        assert!(
            told.starts_with(&answered.iter().map(String::as_str).collect::<Vec<_>>()),
            "{of}: {told:?} {answered:?}"
        );
        assert!(told.len() <= answered.len() + 1, "{of}: {told:?} {answered:?}");
        assert_eq!(process.mishaps().len(), usize::from(kills), "{of}: {:?}", process.mishaps());
        assert_eq!(stage.left_over(), [""; 0], "{of}");
    }
}

/// The numbers of the processes that work in this folder.
fn running(folder: &Path) -> Vec<u32> {
    let number = |entry: std::io::Result<std::fs::DirEntry>| {
        let process = entry.ok()?.path();
        let works_there = std::fs::read_link(process.join("cwd")).is_ok_and(|place| place.starts_with(folder));
        process.file_name()?.to_str()?.parse().ok().filter(|_| works_there)
    };
    std::fs::read_dir("/proc").into_iter().flatten().filter_map(number).collect()
}

fn env_number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap())
}

#[test]
fn a_slow_program_that_answers_in_time_is_as_good_as_a_fast_one() {
    if !has_python() {
        return;
    }
    let stage = Stage::new(
        "import sys, time\nfor line in sys.stdin:\n time.sleep(0.3)\n print('{\"state\": \"awake\"}', flush=True)",
    );
    let mut process = stage.process(LIMITS);
    process.start(Duration::ZERO).unwrap();
    say(&mut process, 0, 1, "hello", 1.0);
    assert_eq!((process.location().as_str(), process.mishaps()), ("awake", &[][..]));
}

#[test]
fn a_message_may_be_longer_than_a_pipe() {
    if !has_python() {
        return;
    }
    let stage = Stage::new(
        "import sys, json\nfor line in sys.stdin:\n text = json.loads(line)['data'].get('text', '')\n print(json.dumps({'state': str(len(text))}), flush=True)",
    );
    let mut process = stage.process(LIMITS);
    process.start(Duration::ZERO).unwrap();
    say(&mut process, 0, 1, &"x".repeat(300_000), 1.0);
    assert_eq!(process.location(), "300000");
    // A program that does not read its input has no more time than any other.
    let unreading = Stage::new("echo '{}'; sleep 1000");
    let mut process = unreading.command(&["sh", "program.py"], SHORT_LIMITS);
    process.start(Duration::ZERO).unwrap();
    say(&mut process, 0, 1, &"x".repeat(300_000), 1.0);
    assert_eq!(process.mishaps()[0].message, "the program, sent `say` by Guide, did not answer within 2 s");
    assert_eq!(unreading.left_over(), [""; 0]);
}

#[test]
#[cfg(target_os = "linux")]
fn the_environment_of_a_program_is_the_same_for_every_user() {
    // The environment of the process itself, without the variables that the shell adds.
    let own = "tr '\\0' '\\n' < /proc/$$/environ | sed 's/=.*//' | sort | tr '\\n' ' '";
    let stage = Stage::new(&format!("read line\necho \"{{\\\"state\\\": \\\"$({own})\\\"}}\"\nread line"));
    let mut process = stage.command(&["sh", "program.py"], LIMITS);
    process.start(Duration::ZERO).unwrap();
    let location = process.location();
    let allowed = " HOME LC_ALL LD_LIBRARY_PATH PATH PYTHONDONTWRITEBYTECODE PYTHONHASHSEED PYTHONPATH PYTHONUNBUFFERED TMPDIR TZ";
    assert!(location.split(' ').all(|name| allowed.split(' ').any(|known| known == name)), "{location}");
    assert!(location.contains("PATH") && location.contains("PYTHONHASHSEED"), "{location}");
}

#[test]
fn a_program_that_cannot_be_run_is_refused_before_anything_starts() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plain.sh"), "").unwrap();
    let refused = |words: &[&str]| {
        let words = words.iter().map(|word| Word::Text((*word).to_owned())).collect();
        let problem = Program::new(words, Some(folder.path()), LIMITS).unwrap_err();
        let help = miette::Diagnostic::help(&problem).unwrap().to_string();
        (problem.to_string().replace(folder.path().to_str().unwrap(), "FOLDER"), help)
    };
    let example = "name a program and its arguments: program = [\"python3\", \"speaker.py\"]";
    assert_eq!(refused(&[]), ("the command is empty".into(), example.into()));
    assert_eq!(refused(&["pyhton3"]), ("there is no program `pyhton3` on the PATH".into(), example.into()));
    assert_eq!(refused(&["plain.sh"]).1, "to run the file beside the scenario, write `./plain.sh`");
    assert_eq!(refused(&["./speaker"]), ("there is no program FOLDER/speaker".into(), example.into()));
    let (message, help) = refused(&["./plain.sh"]);
    assert_eq!(message, "the program FOLDER/plain.sh is not executable");
    assert!(help.starts_with("make it executable (`chmod +x`), or name the interpreter"), "{help}");
}

#[test]
fn a_file_that_comes_with_the_program_exists_while_it_runs() {
    if !has_python() {
        return;
    }
    programs::keep_with(keeper());
    let contents = b"import json, sys\nfor line in sys.stdin: print(json.dumps({'state': sys.argv[0]}), flush=True)";
    let file = Word::File { name: "guide/speaker.py".into(), contents: contents.as_slice().into() };
    let program = Program::new(vec![Word::Text("python3".into()), file], None, LIMITS).unwrap();
    assert_eq!(program.to_string(), "python3 guide/speaker.py");
    let mut topology = channels::Topology::default();
    let id = topology.process("Speaker").unwrap();
    let mut process = programs::ProgramProcess::new(&topology, id, program.into(), skills::Datum::default());
    process.start(Duration::ZERO).unwrap();
    let file = std::path::PathBuf::from(process.location());
    assert!(file.ends_with("speaker.py") && file.is_absolute() && file.exists(), "{file:?}");
    drop(process);
    assert!(!file.exists());
}
