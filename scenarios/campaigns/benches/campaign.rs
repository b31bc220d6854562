//! The cost of a campaign: `cargo bench -p campaigns --bench campaign [-- set-up | overhead | cores | memory [RUNS…]]`.
//!
//! - `set-up`: how long the set-up of a run takes once another run has been set up.
//! - `overhead`: a campaign's time relative to that of its bare runs, which are set up, stepped to their end and
//!   dropped.
//! - `cores`: runs per second on two cores relative to one.
//! - `memory`: the peak of resident memory for this many runs, by default 1,000 and 100,000 (Linux).
//!
//! The campaign is `noise_short`: localization under sensor noise, with runs of 10 simulated seconds. The alternatives
//! are measured in turn, pair by pair. Processor time is shown, too: other programs affect it less than elapsed time.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a measurement, not a library")]
#![expect(clippy::disallowed_methods, reason = "measures the computer's time")]

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use campaigns::{Plan, Shard};
use runs::Run;
use scenarios::scenario::Scenario;

/// How many pairs are compared.
const PAIRS: usize = 7;

fn main() {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let wanted = |section: &str| arguments.is_empty() || arguments[0] == section;
    if arguments.first().is_some_and(|first| first == "peak") {
        return println!("{}", peak_kib(arguments[1].parse().unwrap()));
    }
    if wanted("set-up") {
        set_up();
    }
    if wanted("overhead") {
        overhead(100);
    }
    if wanted("cores") {
        cores(200);
    }
    if wanted("memory") {
        let runs: Vec<u64> = arguments.iter().skip(1).map(|runs| runs.parse().unwrap()).collect();
        memory(if runs.is_empty() { &[1_000, 100_000] } else { &runs });
    }
}

fn plan(runs: u64) -> Plan {
    Plan::load(Path::new("noise_short")).unwrap().with_runs(runs).unwrap()
}

/// Minimum, median and maximum.
fn spread(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [values[0], values[values.len() / 2], values[values.len() - 1]]
}

fn set_up() {
    let plan = plan(200);
    let (mut loading, mut starting) = (Vec::new(), Vec::new());
    for k in 0..plan.runs() {
        let run = plan.run(k);
        let began = Instant::now();
        let scenario = Arc::new(Scenario::load(plan.scenario(), &run.overrides(&plan)).unwrap());
        let loaded = Instant::now();
        black_box(Run::new(scenario, run.seed, true).unwrap());
        starting.push(loaded.elapsed().as_secs_f64() * 1e3);
        loading.push((loaded - began).as_secs_f64() * 1e3);
    }
    let both = loading.iter().zip(&starting).map(|(loading, starting)| loading + starting).collect();
    for (what, times) in [("loading", loading), ("starting", starting), ("set-up", both)] {
        let [least, middle, greatest] = spread(times);
        println!("{what:<10} {middle:.3} ms ({least:.3} to {greatest:.3}) after the first run");
    }
}

/// The elapsed time and the processor time of something, in seconds.
fn seconds(work: impl FnOnce()) -> [f64; 2] {
    let (began, used) = (Instant::now(), processor_s());
    work();
    [began.elapsed().as_secs_f64(), processor_s() - used]
}

/// Processor time of this process so far, in seconds; NaN if the system does not provide it.
fn processor_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> =
        stat.rsplit(')').next().unwrap_or("").split_whitespace().filter_map(|field| field.parse().ok()).collect();
    // Fields 14 and 15 of proc(5), in hundredths of a second; the state, which is not a number, is left out.
    fields.get(10..12).map_or(f64::NAN, |ticks| (ticks[0] + ticks[1]) / 100.0)
}

/// Runs a campaign on this many cores, including dataset and summary.
fn run(plan: &Plan, cores: usize) {
    let folder = tempfile::tempdir().unwrap();
    let interrupted = AtomicBool::new(false);
    let ran = campaigns::run(plan, Shard::ALL, folder.path(), cores, &interrupted, |_| {}).unwrap();
    black_box(ran.finish().unwrap());
}

/// Runs each run of a campaign to its end, and nothing else.
fn run_bare(plan: &Plan) {
    for k in 0..plan.runs() {
        let run = plan.run(k);
        let scenario = Arc::new(Scenario::load(plan.scenario(), &run.overrides(plan)).unwrap());
        let limit = scenario.file.execution.max_time;
        let mut run = Run::new(scenario, run.seed, true).unwrap();
        while run.time() < limit {
            black_box(run.step()).unwrap();
        }
    }
}

fn overhead(runs: u64) {
    let plan = plan(runs);
    run_bare(&plan);
    let ratios = (0..PAIRS).map(|_| {
        let (campaign, bare) = (seconds(|| run(&plan, 1)), seconds(|| run_bare(&plan)));
        [campaign[0] / bare[0], campaign[1] / bare[1]]
    });
    print_ratios("campaign over bare runs", &ratios.collect::<Vec<_>>());
}

fn cores(runs: u64) {
    let plan = plan(runs);
    run(&plan, 2);
    let mut rates = Vec::new();
    let ratios = (0..PAIRS).map(|_| {
        let (two, one) = (seconds(|| run(&plan, 2)), seconds(|| run(&plan, 1)));
        rates.push(runs as f64 / two[0]);
        [one[0] / two[0], one[1] / two[1]]
    });
    print_ratios("two cores over one", &ratios.collect::<Vec<_>>());
    println!("{:<24} {:.1} runs of 10 simulated seconds per second", "", spread(rates)[1]);
}

fn print_ratios(what: &str, ratios: &[[f64; 2]]) {
    for (place, measure) in ["by the clock", "processor time"].iter().enumerate() {
        let [least, middle, greatest] = spread(ratios.iter().map(|ratio| ratio[place]).collect());
        println!("{what:<24} {middle:.3} ({least:.3} to {greatest:.3}) {measure}");
    }
}

fn memory(runs: &[u64]) {
    for runs in runs {
        let peak = Command::new(std::env::current_exe().unwrap()).args(["peak", &runs.to_string()]).output().unwrap();
        let kib: f64 = String::from_utf8(peak.stdout).unwrap().trim().parse().unwrap();
        println!("{runs:>7} runs: at most {:.1} MB resident", kib / 1024.0);
    }
}

/// The peak of this process's resident memory, in KiB, after this many runs.
fn peak_kib(runs: u64) -> u64 {
    run(&plan(runs), 2);
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches("kB").trim().parse().unwrap()
}
