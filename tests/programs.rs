//! Scenarios with components that are programs: that their answers reach the run, and that nothing is left running.

#[path = "../components/programs/tests/machine.rs"]
mod machine;

use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::{TempDir, tempdir};

pub(crate) use self::machine::has_python;
use self::machine::left_over;
use crate::steward::{binary, refusal, report, steward};

const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Tour">
  <BehaviorTree ID="Tour"><AnnounceArrival/></BehaviorTree>
  <TreeNodesModel><Action ID="AnnounceArrival"/></TreeNodesModel>
</root>"#;

const INTERFACE: &str = include_str!("../skills/examples/speaker.toml");

const PROGRAM: &str = include_str!("../components/programs/examples/speaker.py");

/// A folder with a scenario in which this speaker is asked to say something again and again.
struct Stage {
    folder: TempDir,
}

impl Stage {
    fn new(speaker: &str) -> Self {
        let folder = tempdir().unwrap();
        let skill = include_str!("../skills/examples/AnnounceArrival.scxml");
        let machine = include_str!("../skills/examples/Speaker.scxml");
        let scenario = format!(
            "tree = \"tree.xml\"\nskills = \"skills\"\nexecution.max_time_s = 20\n\n\
             [components.Speaker]\ninterface = \"speaker.toml\"\n{speaker}\n"
        );
        fs::create_dir(folder.path().join("skills")).unwrap();
        for (name, text) in [
            ("tree.xml", TREE),
            ("skills/AnnounceArrival.scxml", skill),
            ("Speaker.scxml", machine),
            ("speaker.py", PROGRAM),
            ("speaker.toml", INTERFACE),
            ("announce.toml", &scenario),
        ] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        Self { folder }
    }

    /// The same, but the speaker is this Python program.
    fn of_program(program: &str) -> Self {
        let stage = Self::new("program = [\"python3\", \"speaker.py\"]");
        fs::write(stage.folder.path().join("speaker.py"), program).unwrap();
        stage
    }

    fn scenario(&self) -> PathBuf {
        self.folder.path().join("announce.toml")
    }

    fn report(&self, arguments: &[&str]) -> Value {
        let out = self.folder.path().join("out");
        let arguments = [&["--no-snapshots"], arguments].concat();
        let report = report(self.scenario().to_str().unwrap(), &out, &arguments);
        assert_eq!(self.left_over(), [""; 0]);
        report
    }

    fn refusal(&self) -> String {
        let out = self.folder.path().join("out");
        let said = refusal(&["run", self.scenario().to_str().unwrap(), "--out", out.to_str().unwrap()]);
        assert_eq!(self.left_over(), [""; 0]);
        said.replace(['\n', '│', '|'], " ").split_whitespace().collect::<Vec<_>>().join(" ")
    }

    fn left_over(&self) -> Vec<String> {
        left_over(self.folder.path())
    }
}

#[test]
fn a_speaker_in_python_gives_the_same_trace_as_its_machine() {
    if !has_python() {
        return;
    }
    assert!(PROGRAM.lines().count() <= 30);
    let (program, machine) = ("program = [\"python3\", \"speaker.py\"]", "machine = \"Speaker.scxml\"");
    let trace = |speaker: &str, arguments: &[&str]| {
        let report = Stage::new(speaker).report(arguments);
        assert_eq!(report["skill_errors"], Value::Array(vec![]), "{report}");
        report["trace_hash"].clone()
    };
    for policy in ["random", "round-robin"] {
        let policy = format!("execution.policy={policy}");
        for pace in [0.02, 0.1, 0.13] {
            let pace = format!("components.Speaker.data.seconds_per_letter={pace}");
            let arguments = ["--set", &policy, "--set", &pace];
            assert_eq!(trace(program, &arguments), trace(machine, &arguments), "{arguments:?}");
        }
    }
    let slower = ["--set", "components.Speaker.data.seconds_per_letter=0.1"];
    assert_ne!(trace(program, &[]), trace(program, &slower), "the speaker's answers are in the trace");
}

#[test]
fn a_program_that_fails_is_in_the_report_and_the_run_goes_on() {
    if !has_python() {
        return;
    }
    let stage = Stage::of_program(&PROGRAM.replace("duration = max", "duration = 1 / 0 + max"));
    let report = stage.report(&[]);
    let [error] = report["skill_errors"].as_array().unwrap().as_slice() else { panic!("{report}") };
    let said = ["kind", "skill", "state", "times"].map(|field| error[field].clone());
    assert_eq!(said, ["component".into(), "Speaker".into(), "silent".into(), Value::from(1)]);
    let message = error["message"].as_str().unwrap();
    let begins = "the program, sent `say` by AnnounceArrival, ended with exit status 1 before it answered; on stderr: ";
    assert!(message.starts_with(begins) && message.ends_with(" / ZeroDivisionError: division by zero"), "{message}");
    let page = fs::read_to_string(stage.folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("ZeroDivisionError") && page.contains(">component</th>"), "{page}");
    let out = stage.folder.path().join("out");
    let ran = steward(&["run", stage.scenario().to_str().unwrap(), "--no-snapshots", "--out", out.to_str().unwrap()]);
    let summary = String::from_utf8(ran.stdout).unwrap();
    assert!(summary.contains("  component  Speaker, state silent: the program, sent `say`"), "{summary}");
}

#[test]
fn a_program_that_crashes_because_of_a_fault_starts_again() {
    if !has_python() {
        return;
    }
    let crash = "[[faults]]\nkind = \"component_crash\"\ncomponent = \"Speaker\"\nat_s = 5\nlasts_s = 3\n";
    let trace = |speaker: &str| Stage::new(&format!("{speaker}\n\n{crash}")).report(&[])["trace_hash"].clone();
    let program = trace("program = [\"python3\", \"speaker.py\"]");
    assert_eq!(program, trace("machine = \"Speaker.scxml\""));
    assert_ne!(program, Stage::new("machine = \"Speaker.scxml\"").report(&[])["trace_hash"]);
}

#[test]
fn a_program_that_cannot_start_is_bad_input() {
    let said = Stage::new("program = [\"pyhton3\", \"speaker.py\"]").refusal();
    assert!(said.contains("there is no program `pyhton3` on the PATH"), "{said}");
    let said = Stage::new("program = [\"./speaker.toml\"]").refusal();
    assert!(said.contains("is not executable") && said.contains("chmod +x"), "{said}");
    let said = Stage::new("program = [\"sh\", \"-c\", \"echo no voice >&2; exit 3\"]").refusal();
    let expected = "the component Speaker does not start: the program, sent `start`, ended with exit status 3 before it \
                    answered; on stderr: no voice";
    assert!(said.contains(expected), "{said}");
    let said = Stage::new("program = [\"sh\"]\nasks = [\"Spaeker\"]").refusal();
    assert!(said.contains("Spaeker"), "{said}");
}

/// A program that reports through a pipe that it is running, and hides a child that would never end.
const HIDDEN: &str = "
import os, sys, time
pipe = os.open('alive', os.O_WRONLY)
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        os.write(pipe, b'.')
    else:
        os._exit(0)
time.sleep(1000)
";

/// Ends steward in this way while a program does not answer; nothing may be left running.
fn ends_all(end: impl Fn(&mut std::process::Child)) {
    if !has_python() {
        return;
    }
    let stage = Stage::of_program(HIDDEN);
    let (folder, pipe): (&Path, _) = (stage.folder.path(), stage.folder.path().join("alive"));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut run = Command::new(binary());
    run.arg("run")
        .arg(stage.scenario())
        .arg("--out")
        .arg(folder.join("out"))
        .args(["--set", "components.Speaker.answer_within_s=1000"]);
    let mut steward = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut pipe = File::open(pipe).unwrap();
    let mut one = [0];
    pipe.read_exact(&mut one).unwrap();
    end(&mut steward);
    steward.wait().unwrap();
    // The pipe ends once all processes that could write to it are gone.
    assert_eq!(pipe.read_to_end(&mut Vec::new()).unwrap(), 0);
}

#[test]
fn nothing_is_left_running_when_steward_is_killed() {
    ends_all(|steward| steward.kill().unwrap());
}

#[test]
fn nothing_is_left_running_after_ctrl_c() {
    ends_all(|steward| {
        // The first asks for an orderly end, which a program that does not answer delays; the second ends steward.
        while steward.try_wait().unwrap().is_none() {
            Command::new("kill").args(["-INT", &steward.id().to_string()]).status().unwrap();
        }
    });
}

/// A program that starts another one in a session of its own and, when it is asked, kills a process that watches it:
/// its parent, or the parent of that.
fn killer(of_parent: bool) -> String {
    let victim =
        if of_parent { "parent" } else { "int(open(f'/proc/{parent}/stat').read().rsplit(')')[1].split()[1])" };
    format!(
        "import os, signal, subprocess, sys
for line in sys.stdin:
    if '\"say\"' in line:
        subprocess.Popen(['sh', '-c', 'setsid sleep 1000 >&- 2>&- <&- &']).wait()
        parent = os.getppid()
        os.kill({victim}, signal.SIGKILL)
    print('{{}}', flush=True)
"
    )
}

#[test]
#[cfg(target_os = "linux")]
fn a_program_that_kills_its_keeper_does_not_escape_and_fails_the_run() {
    if !has_python() {
        return;
    }
    for of_parent in [true, false] {
        let report = Stage::of_program(&killer(of_parent)).report(&[]);
        assert_eq!(report["outcome"], "not_as_expected", "{report}");
        let differences = report["differences"].to_string();
        assert!(differences.contains("there was an error in the component Speaker"), "{differences}");
    }
}

/// A program that starts another one in a session of its own and then kills or stops both keepers, one after the other.
fn killer_of_both(signal: &str) -> String {
    format!(
        "import os, signal, subprocess, sys
pipe = os.open('alive', os.O_WRONLY)
def parent_of(pid):
    return int(open(f'/proc/{{pid}}/stat').read().rsplit(')')[1].split()[1])
for line in sys.stdin:
    if '\"say\"' in line:
        subprocess.Popen(['setsid', 'sleep', '1000'], pass_fds=[pipe])
        inner = os.getppid()
        outer = parent_of(inner)
        os.kill(outer, signal.{signal})
        os.kill(inner, signal.{signal})
    print('{{}}', flush=True)
"
    )
}

#[test]
#[cfg(target_os = "linux")]
fn a_program_that_kills_or_stops_all_its_keepers_does_not_escape() {
    if !has_python() {
        return;
    }
    for signal in ["SIGKILL", "SIGSTOP"] {
        let stage = Stage::of_program(&killer_of_both(signal));
        let pipe = stage.folder.path().join("alive");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let survivors = std::thread::spawn(move || {
            let mut pipe = File::open(pipe).unwrap();
            pipe.read_to_end(&mut Vec::new()).unwrap()
        });
        let report = stage.report(&[]);
        assert_eq!(report["outcome"], "not_as_expected", "{report}");
        // The pipe ends once all processes that could write to it are gone.
        assert_eq!(survivors.join().unwrap(), 0, "{signal}");
    }
}

#[test]
fn a_check_names_the_programs_of_a_scenario_and_starts_none() {
    let stage = Stage::new("program = [\"sh\", \"-c\", \"touch started; exit 3\"]");
    let checked = steward(&["check", stage.scenario().to_str().unwrap()]);
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert_eq!(checked.status.code(), Some(0), "{said}");
    assert!(
        said.contains("a run starts `sh -c \"touch started; exit 3\"` in ") && said.contains("for Speaker"),
        "{said}"
    );
    assert!(!stage.folder.path().join("started").exists());
    let of_folder = steward(&["check", stage.folder.path().to_str().unwrap(), "--json"]);
    assert!(String::from_utf8_lossy(&of_folder.stdout).contains("announce.toml"));
}

#[test]
fn a_stray_line_is_quoted() {
    if !has_python() {
        return;
    }
    let stage =
        Stage::of_program("import sys\nfor line in sys.stdin: sys.stdout.write('so far\\n{}\\n'); sys.stdout.flush()");
    let said = stage.refusal();
    assert!(said.contains("answered wrongly: it is not JSON") && said.contains("so far"), "{said}");
    assert!(said.contains("print anything else to standard error"), "{said}");
}

#[test]
fn a_pipe_is_no_recording() {
    let folder = tempdir().unwrap();
    for name in ["run.rec", "run.mcap", "run"] {
        let pipe = folder.path().join(name);
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let pipe = pipe.to_str().unwrap();
        // It waits for no writer.
        refusal(&["verify", "--list", pipe]);
        let said = refusal(&["report", pipe]);
        assert!(said.contains("a device or a pipe"), "{said}");
    }
    for name in ["run.rec", "run.mcap"] {
        let said = refusal(&["live", "--no-open", folder.path().join(name).to_str().unwrap()]);
        assert!(said.contains("a device or a pipe"), "{said}");
    }
}
