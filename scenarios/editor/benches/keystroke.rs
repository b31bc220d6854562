//! How long an editor waits for the problems of a scenario of 30 files after a keystroke: the median and the 95th
//! percentile, for each kind of file that is edited.
//!
//! The files are those of an application with twenty leaves, each with its machine, and five property files.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use editor::{Documents, Project};

const LEAVES: usize = 20;
const KEYSTROKES: usize = 100;

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    write_application(folder.path());
    for file in ["main.toml", "tree.xml", "skills/Say07.scxml", "said3.scope"] {
        let mut times = times_of(folder.path(), file);
        times.sort();
        let [median, p95] = [times.len() / 2, times.len() * 95 / 100].map(|place| times[place].as_secs_f64() * 1e3);
        eprintln!("{file}: median {median:.1} ms, 95th percentile {p95:.1} ms");
    }
}

fn write_application(folder: &Path) {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../skills/examples");
    let example = |name: &str| fs::read_to_string(examples.join(name)).expect("an example");
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("a file");
    fs::create_dir(folder.join("skills")).expect("a folder");
    let names: Vec<String> = (0..LEAVES).map(|number| format!("Say{number:02}")).collect();
    for name in &names {
        write(&format!("skills/{name}.scxml"), &example("AnnounceArrival.scxml").replace("AnnounceArrival", name));
    }
    let leaves: String = names.iter().map(|name| format!("<{name}/>")).collect();
    let models: String = names.iter().map(|name| format!("<Action ID=\"{name}\"/>")).collect();
    write(
        "tree.xml",
        &format!(
            "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\"><Sequence>{leaves}</Sequence></BehaviorTree>\
             <TreeNodesModel>{models}</TreeNodesModel></root>"
        ),
    );
    write("Speaker.scxml", &example("Speaker.scxml"));
    write("speaker.toml", &example("speaker.toml"));
    let properties: Vec<String> = (0..5).map(|number| format!("said{number}.scope")).collect();
    for (number, name) in properties.iter().enumerate() {
        write(name, &format!("property said{number} := always not (Speaker, Say0{number}, m[1] = <error>)\n"));
    }
    write("base.toml", "base = \"nominal\"\nexpect = {}\n");
    write(
        "main.toml",
        &format!(
            "base = \"base.toml\"\ntree = \"tree.xml\"\nskills = \"skills\"\nproperties = {properties:?}\n\
             components.Speaker = {{ machine = \"Speaker.scxml\", interface = \"speaker.toml\" }}\n"
        ),
    );
    assert!(checks::examine(&diagnostics::Disk::default(), &folder.join("main.toml").to_string_lossy(), None).is_ok());
}

/// The times from a keystroke in this file, at its end, until everything is checked.
fn times_of(folder: &Path, file: &str) -> Vec<Duration> {
    let path = folder.join(file);
    let text = fs::read_to_string(&path).expect("a text");
    let mut documents = Documents { folders: vec![folder.to_owned()], ..Documents::default() };
    documents.open.insert(path.clone(), text.as_str().into());
    let mut project = Project::default();
    assert!(project.check(&documents).findings.is_empty());
    let stroke = |number: usize| {
        documents.open.insert(path.clone(), format!("{text}{}", " ".repeat(number + 1)).into());
        #[expect(clippy::disallowed_methods, reason = "this is measured")]
        let start = Instant::now();
        let found = project.check(&documents).findings;
        let time = start.elapsed();
        assert!(found.is_empty());
        time
    };
    (0..KEYSTROKES).map(stroke).collect()
}
