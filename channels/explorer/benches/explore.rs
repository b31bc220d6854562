//! How fast states are found and how much memory they take: philosophers who ask for their forks and wait for an
//! answer.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use channels::{
    Capacity, ChannelId, ChannelSystem, Domain, FieldKind, GraphMonitor, GraphProcess, Message, Process, ProcessId,
    ProgramGraph, Shape, Topology,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use explorer::{Closed, Environment, Exploration, Limits, Model, Outcome, Reduction, explore, promela};

fn main() {
    divan::main();
}

/// Guests at a round table with a fork between every two neighbors, and the property that no guest is given the first
/// fork while the other one of its guests holds it.
fn table(guests: usize) -> (ChannelSystem, GraphMonitor) {
    let mut topology = Topology::default();
    let mut seat = |kind: &str, index: usize| topology.process(&format!("{kind}{index}")).expect("a new name");
    let people: Vec<ProcessId> = (0..guests).map(|index| seat("Guest", index)).collect();
    let forks: Vec<ProcessId> = (0..guests).map(|index| seat("Fork", index)).collect();
    let words = || Domain::new([Shape::new([("word", FieldKind::symbols(["take", "put"]))])]);
    let answers = || Domain::new([Shape::new([("word", FieldKind::symbols(["ok"]))])]);
    let mut line = |guest: usize, fork: usize| -> [ChannelId; 2] {
        let asks = topology.channel(people[guest], forks[fork], Capacity::One, words()).expect("a new channel");
        [asks, topology.channel(forks[fork], people[guest], Capacity::One, answers()).expect("a new channel")]
    };
    let lines: Vec<[[ChannelId; 2]; 2]> =
        (0..guests).map(|guest| [line(guest, guest), line(guest, (guest + 1) % guests)]).collect();
    let [take, put, ok] = ["take", "put", "ok"].map(|word| Message::symbols([word]));
    let mut processes: Vec<(ProcessId, Box<dyn Process>)> = Vec::new();
    for guest in 0..guests {
        let mut graph = ProgramGraph::builder("guest");
        let places: Vec<_> = (0..6).map(|index| graph.location(&format!("{index}"))).collect();
        let [[left, from_left], [right, from_right]] = lines[guest];
        graph.send(places[0], left, take.clone(), places[1]);
        graph.transition(places[1], channels::Label::Receive(from_left, channels::Slot::Given(ok.clone())), places[2]);
        graph.send(places[2], right, take.clone(), places[3]);
        graph.transition(places[3], channels::Label::Receive(from_right, channels::Slot::Given(ok.clone())), places[4]);
        graph.send(places[4], left, put.clone(), places[5]);
        graph.send(places[5], right, put.clone(), places[0]);
        let graph = graph.initial(places[0]).build().expect("a sound graph");
        processes.push((people[guest], Box::new(GraphProcess::new(Arc::new(graph)))));
    }
    for fork in 0..guests {
        let mut graph = ProgramGraph::builder("fork");
        let free = graph.location("free");
        for [asked, answers] in [lines[fork][0], lines[(fork + guests - 1) % guests][1]] {
            let [asked_for, held] = ["asked for", "held"].map(|name| graph.location(name));
            graph.receive(free, asked, take.clone(), asked_for);
            graph.send(asked_for, answers, ok.clone(), held);
            graph.receive(held, asked, put.clone(), free);
        }
        let graph = graph.initial(free).build().expect("a sound graph");
        processes.push((forks[fork], Box::new(GraphProcess::new(Arc::new(graph)))));
    }
    let mut rule = ProgramGraph::builder("one at a time");
    let [free, twice] = ["free", "taken twice"].map(|name| rule.location(name));
    let asks = [lines[0][0][0], lines[guests - 1][1][0]];
    let held = ["held by the first", "held by the last"].map(|name| rule.location(name));
    for (holder, other) in [(0, 1), (1, 0)] {
        rule.receive(free, asks[holder], take.clone(), held[holder]);
        rule.receive(held[holder], asks[holder], put.clone(), free);
        rule.receive(held[holder], asks[other], take.clone(), twice);
    }
    let rule = GraphMonitor::new(Arc::new(rule.initial(free).build().expect("a sound graph")), [twice]);
    (ChannelSystem::new(Arc::new(topology), processes).expect("a sound system"), rule)
}

#[divan::bench(args = [(5, 1), (6, 1), (6, 2)], sample_count = 3)]
fn philosophers(bencher: Bencher<'_, '_>, (guests, threads): (usize, usize)) {
    let (system, rule) = table(guests);
    let model = Model::new(&system, None, Closed.erased());
    let limits = Limits { threads, reduction: Reduction::Off, ..Limits::default() };
    let run = || explore(&model, Some(&rule), &limits, &mut |_| ()).expect("a finite system");
    let Exploration { outcome, progress: found, .. } = run();
    assert!(matches!(outcome, Outcome::Proved), "{outcome:?}");
    eprintln!("{guests} guests: {} states, {:.1} bytes each", found.states, found.memory as f64 / found.states as f64);
    bencher.counter(ItemsCount::new(found.states)).bench(run);
}

/// More than 100 million states within 4 GB: runs only on request, since it takes minutes.
#[divan::bench(args = [8], sample_count = 1, sample_size = 1, ignore)]
fn a_hundred_million_states(bencher: Bencher<'_, '_>, guests: usize) {
    let (system, rule) = table(guests);
    let model = Model::new(&system, None, Closed.erased());
    let limits = Limits { memory: 4 << 30, reduction: Reduction::Off, ..Limits::default() };
    bencher.bench_local(|| {
        let found = explore(&model, Some(&rule), &limits, &mut |_| ()).expect("a finite system");
        let explorer::Progress { states, memory, depth, .. } = found.progress;
        let bytes = memory as f64 / states as f64;
        eprintln!("{guests} guests: {states} states to depth {depth}, {bytes:.1} bytes each, {memory} bytes in all");
        assert!(states > 100_000_000, "{states}");
    });
}

/// The same model in SPIN, without SPIN's reduction: the states are the items, so rates can be compared.
#[divan::bench(args = [5, 6], sample_count = 3)]
fn philosophers_in_spin(bencher: Bencher<'_, '_>, guests: usize) {
    let (system, rule) = table(guests);
    let model = Model::new(&system, None, Closed.erased());
    let exported = promela(&model, Some(&rule), &Limits::default(), &mut |_| ()).expect("a finite system");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("model.pml"), exported.text).expect("a file");
    let compile = "spin -a -o1 -o2 -o3 model.pml && cc -O2 -w -DSAFETY -DNOREDUCE -o pan pan.c";
    if Command::new("spin").arg("-V").output().is_err() || run(folder.path(), compile).is_none() {
        return eprintln!("not run here: spin or cc is not installed");
    }
    let search = || run(folder.path(), "./pan -m4000000 -n").expect("an answer from SPIN");
    let output = search();
    let number = |words: &str| {
        let line = output.lines().find(|line| line.contains(words));
        line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).expect("a number")
    };
    let (states, megabytes) = (number("states, stored"), number("actual memory usage for states"));
    eprintln!("{guests} guests in SPIN: {states} states, {:.1} bytes each", megabytes * 1024.0 * 1024.0 / states);
    bencher.counter(ItemsCount::new(exported.states)).bench(search);
}

/// Runs a command in a folder and returns its output if it succeeds.
fn run(folder: &Path, command: &str) -> Option<String> {
    let output = Command::new("sh").args(["-c", command]).current_dir(folder).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}
