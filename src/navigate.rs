//! `steward navigate`: how well the robot drives from anywhere to anywhere.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use campaigns::Error;
use checks::named_files;
use clap::{Args, ValueEnum};
use diagnostics::{Disk, Staging};
use drawing::Renderer;
use reports::file_name;
use scenarios::Complaints;
use trials::navigate::{About, Benchmark, Course, Scenes, Settings, Trip, picture, table};

use crate::output::{print, print_wrapped, warn};
use crate::progress::CountProgress;

/// The name of the results' file.
const DATA: &str = "navigate.json";

/// The trips to drive.
#[derive(Debug, Args)]
pub(crate) struct NavigateArgs {
    /// Maps to drive on: YAML files, or names of shipped ones
    #[arg(long, value_name = "MAP.yaml", num_args = 1.., default_value = "house")]
    map: Vec<PathBuf>,
    /// How many trips there are on each map, between random places
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    goals: u64,
    /// How many people there are: two thirds walk back and forth across the robot's path, and the
    /// others stand still
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1000))]
    people: u16,
    /// How many boxes that are not on the map stand beside the robot's path, leaving it room
    #[arg(long, value_name = "B", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1000))]
    boxes: u16,
    /// The root seed of the first trip on each map; each further trip uses the next one
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Exits with 1 if less than PCT percent of the trips arrive, or if the robot touches a wall or anything that
    /// stands still
    #[arg(long, value_name = "PCT", value_parser = percent)]
    at_least: Option<f64>,
    /// Which trips to draw
    #[arg(long, value_enum, default_value_t = Pictures::Failed)]
    pictures: Pictures,
    /// Where the pictures and the data go
    #[arg(long, value_name = "DIR", default_value = "out/navigate")]
    out: PathBuf,
    /// Prints the results as JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Shows no progress
    #[arg(long, short)]
    quiet: bool,
}

/// The trips that are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Pictures {
    /// Trips that did not arrive, or touched a wall or anything that stood still
    Failed,
    /// All trips
    All,
    /// No trip
    None,
}

/// Drives all trips and prints their results.
pub(crate) fn navigate(args: &NavigateArgs) -> Result<ExitCode, Error> {
    let seeds = seeds(args.seed, args.goals)?;
    let mut complaints = Complaints::default();
    let maps = args.map.iter().zip(names(&args.map));
    let courses: Vec<Course> = maps.filter_map(|(path, name)| complaints.take(course(path, &name))).collect();
    complaints.check()?;
    check_outputs(args, &seeds)?;
    let about = About { people: args.people.into(), boxes: args.boxes.into() };
    let scenes = match args.pictures {
        Pictures::Failed => Scenes::Failed,
        Pictures::All => Scenes::All,
        Pictures::None => Scenes::None,
    };
    let settings = Settings { seeds, about, scenes };
    let bar = CountProgress::new(args.quiet || args.json, "trips");
    let benchmark = Benchmark::run(&courses, &settings, |done, all| bar.show(done, all));
    drop(bar);
    let json = serde_json::to_string_pretty(&benchmark).expect("a benchmark is always JSON") + "\n";
    let pictures = write(args, &benchmark, &json)?;
    if args.json {
        print(&json)?;
    } else {
        let again = |trip: &Trip| again(args, trip);
        let wrote = match pictures {
            0 => String::new(),
            count => format!(" and {count} pictures"),
        };
        print_wrapped(format!("{}wrote {}{wrote}\n", table(&benchmark, again), args.out.join(DATA).display()))?;
    }
    Ok(ExitCode::from(u8::from(args.at_least.is_some_and(|pct| !is_enough(&benchmark, pct)))))
}

/// A share, in percent.
fn percent(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|_| "not a number, such as 95".to_owned())?;
    if (0.0..=100.0).contains(&value) { Ok(value) } else { Err("not from 0 to 100".to_owned()) }
}

/// The root seeds of this many trips.
fn seeds(first: u64, count: u64) -> Result<RangeInclusive<u64>, Error> {
    let last = first.checked_add(count - 1).ok_or_else(|| {
        let message = format!("there are no {count} seeds beginning with {first}: the last is {}", u64::MAX);
        Error::refused(message, "use a smaller --seed, or fewer --goals")
    })?;
    Ok(first..=last)
}

/// The names of maps: those of their files, numbered if several have the same name.
fn names(maps: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for path in maps {
        let stem = path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into());
        let mut name = stem.clone();
        let mut number = 1;
        while names.contains(&name) {
            number += 1;
            name = format!("{stem}_{number}");
        }
        names.push(name);
    }
    names
}

fn course(path: &Path, name: &str) -> Result<Course, scenarios::Error> {
    let (map, concerns) = named_files::map(&Disk::default(), path)?;
    concerns.iter().for_each(|concern| warn(concern));
    Course::new(name, path, map).map_err(|error| {
        let help = "the robot is a disc of 0.3 m radius and drives on free cells";
        scenarios::Error::refused(format!("{}: {error}", path.display()), help)
    })
}

/// Checks before the trips that the results overwrite no input.
fn check_outputs(args: &NavigateArgs, seeds: &RangeInclusive<u64>) -> Result<(), Error> {
    diagnostics::check_unread(&args.out.join(DATA))?;
    if args.pictures == Pictures::None {
        return Ok(());
    }
    for map in names(&args.map) {
        seeds.clone().try_for_each(|seed| diagnostics::check_unread(&args.out.join(picture_file(&map, seed))))?;
    }
    Ok(())
}

/// The name of the picture of a trip.
fn picture_file(map: &str, seed: u64) -> String {
    format!("{}_{seed}.png", file_name(map))
}

/// Writes the results, and the pictures of the trips that have a scene. Returns the number of pictures.
fn write(args: &NavigateArgs, benchmark: &Benchmark, json: &str) -> Result<usize, Error> {
    let staging = Staging::begin(&args.out)?;
    staging.write(DATA, json)?;
    let renderer = Renderer::new();
    for (trip, scene) in &benchmark.scenes {
        let png = renderer.png(&picture(trip, scene)).map_err(reports::Error::from)?;
        staging.write(picture_file(&trip.map, trip.seed), png)?;
    }
    staging.publish(&[DATA])?;
    Ok(benchmark.scenes.len())
}

/// The command that drives one trip again.
fn again(args: &NavigateArgs, trip: &Trip) -> String {
    let (map, people, seed) = (&trip.map_file, args.people, trip.seed);
    let boxes = if args.boxes > 0 { format!(" --boxes {}", args.boxes) } else { String::new() };
    format!("steward navigate --map {map} --goals 1 --people {people}{boxes} --seed {seed} --pictures all")
}

fn is_enough(benchmark: &Benchmark, at_least_pct: f64) -> bool {
    benchmark
        .maps
        .last()
        .is_some_and(|all| all.arrived_pct >= at_least_pct && all.wall_contacts == 0 && all.standing_contacts == 0)
}
