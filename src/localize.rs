//! `steward localize --map MAP.yaml --log LOG`: localizes a recorded robot.

mod log;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use campaigns::Error;
use checks::named_files;
use clap::Args;
use diagnostics::{Disk, Staging, seconds};
use drawing::{MapPicture, Renderer, Trajectories};
use maps::OccupancyGrid;
use nav::Atlas;
use robot::recorded::Recording;
use serde_json::json;
use trials::localize::fit::Fit;
use trials::localize::starts::{Start, WITHIN_M, try_starts};
use trials::localize::{Conditions, Course, Score, Stretch, replay};

use crate::output::{note, print_json, print_wrapped, warn};

pub(crate) use log::{Log, TopicArgs, open_log};

/// The name of the results' file.
const TRAJECTORIES: &str = "trajectories.csv";
/// The name of the picture.
const PICTURE: &str = "trajectories.png";

/// A log, and the map of the place where it was recorded.
#[derive(Debug, Args)]
pub(crate) struct LocalizeArgs {
    /// The map: a file in ROS `map_server` format, or the name of a shipped one [default: the one in the bag]
    #[arg(long, value_name = "MAP.yaml")]
    map: Option<PathBuf>,
    /// The log, in CARMEN's format (.log or .log.gz), or a ROS 2 bag
    #[arg(long)]
    log: PathBuf,
    #[command(flatten)]
    topics: TopicArgs,
    /// Starts without a pose instead of from the first corrected one
    #[arg(long)]
    global: bool,
    /// Starts at N places spread over the log, and says how far the robot drove before it was found
    #[arg(long, value_name = "N", requires = "global", conflicts_with = "out",
          value_parser = clap::value_parser!(u16).range(1..))]
    starts: Option<u16>,
    /// By how much odometry overestimates each motion and turn: 0.05 or 5%
    #[arg(long, value_name = "SHARE", default_value = "0", value_parser = share, allow_hyphen_values = true)]
    odometry_drift: f64,
    /// Additional random error of odometry, as a standard deviation: 0.05 or 5%
    #[arg(long, value_name = "SHARE", default_value = "0", value_parser = share, allow_hyphen_values = true)]
    odometry_noise: f64,
    /// The root seed for particles and noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Prints the result as JSON
    #[arg(long)]
    json: bool,
    /// Writes both trajectories to DIR, as trajectories.csv and trajectories.png
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl LocalizeArgs {
    fn map_name(&self) -> String {
        self.map.as_ref().map_or_else(|| "of the bag".to_owned(), |path| path.display().to_string())
    }
}

/// A share, as a number from 0 to 1 or in percent.
fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.strip_suffix('%') {
        Some(percent) => (percent.trim_end(), 0.01),
        None => (text, 1.0),
    };
    let value = number.parse::<f64>().map_err(|_| "not a number, such as 0.05 or 5%".to_owned())? * unit;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("not between 0 and 1 (0% and 100%)".to_owned()) }
}

/// The map and the recording that the arguments name.
fn open(args: &LocalizeArgs) -> Result<(Arc<OccupancyGrid>, Arc<Recording>), Error> {
    let Log { recording, map } = open_log(&args.log, &args.topics)?;
    let map = match (&args.map, map) {
        (Some(path), _) => {
            let (map, concerns) = named_files::map(&Disk::default(), path)?;
            concerns.iter().for_each(|concern| warn(concern));
            map
        }
        (None, Some(map)) => map,
        (None, None) => {
            let message = format!("{} has no map", args.log.display());
            return Err(Error::refused(message, "add `--map MAP.yaml`"));
        }
    };
    Ok((Arc::new(map), Arc::new(recording)))
}

/// Replays the log and prints the errors of the estimates.
pub(crate) fn localize(args: &LocalizeArgs) -> Result<ExitCode, Error> {
    let (map, recording) = open(args)?;
    if let Some(folder) = &args.out {
        [TRAJECTORIES, PICTURE].iter().try_for_each(|name| diagnostics::check_unread(&folder.join(name)))?;
    }
    let fit = check_fit(args, &recording, &map)?;
    let atlas = Atlas::new(Arc::clone(&map), recording.model(), fit.parameters());
    let atlas = Arc::new(atlas.map_err(|error| {
        Error::refused(
            format!("{}: {error}", args.map_name()),
            "a robot can be localized only on a map that has free cells",
        )
    })?);
    let conditions = Conditions {
        global: args.global,
        odometry_drift: args.odometry_drift,
        odometry_noise: args.odometry_noise,
        seed: args.seed,
    };
    if let Some(count) = args.starts {
        let starts = try_starts(&recording, &atlas, &conditions, usize::from(count));
        if args.json { print_json(&starts_as_json(&starts)) } else { print_wrapped(starts_in_words(&starts)) }?;
        return Ok(ExitCode::SUCCESS);
    }
    let course = replay(&recording, &atlas, &conditions);
    let score = Score::of(&course);
    if let Some(folder) = &args.out {
        write(folder, args, &map, &course, &score)?;
    }
    if args.json {
        print_json(&as_json(args, &recording, &fit, &course, &score))?;
    } else {
        print_wrapped(in_words(args, &fit, &course, &score))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn check_fit(args: &LocalizeArgs, recording: &Recording, map: &OccupancyGrid) -> Result<Fit, Error> {
    let Some(fit) = Fit::of(recording, map) else {
        let message = format!("{}: no beam of the log hits anything", args.log.display());
        return Err(Error::refused(message, "a robot is localized by its laser scans"));
    };
    let shares = format!(
        "at the log's corrected poses, {:.0} % of which are on free floor, {}{:.0} % of beams end at an obstacle",
        100.0 * fit.poses,
        if fit.is_plausible() { "only " } else { "" },
        100.0 * fit.beams,
    );
    let (map, log) = (args.map_name(), args.log.display());
    if fit.is_plausible() {
        if !fit.is_good() {
            note(&format!(
                "the map {map} fits the log {log} badly: {shares}; the errors below include those of the map and the poses"
            ));
        }
        return Ok(fit);
    }
    let message = format!("the map {map} does not fit the log {log}: {shares}");
    let help = "use a map of the same place, in the frame of the log's poses; `steward map --log LOG` makes one";
    Err(Error::refused(message, help))
}

fn write(folder: &Path, args: &LocalizeArgs, map: &OccupancyGrid, course: &Course, score: &Score) -> Result<(), Error> {
    let staging = Staging::begin(folder)?;
    staging.write(TRAJECTORIES, csv(course))?;
    let picture = Trajectories {
        title: args.log.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        caption: caption(args, score),
        map: &MapPicture::new(map),
        corrected: course.waypoints.iter().map(|at| at.corrected.translation.vector.into()).collect(),
        estimate: course.waypoints.iter().map(|at| at.estimate.translation.vector.into()).collect(),
        odometry: course.waypoints.iter().map(|at| at.odometry.translation.vector.into()).collect(),
        errors: course.waypoints.iter().map(|at| (at.time.as_secs_f64(), at.error_m())).collect(),
    };
    let png = Renderer::new().png(&picture.svg()).map_err(reports::Error::from)?;
    staging.write(PICTURE, png)?;
    Ok(staging.publish(&[TRAJECTORIES])?)
}

/// The subject of the picture, on one line.
fn caption(args: &LocalizeArgs, score: &Score) -> String {
    let odometry = match (args.odometry_drift, args.odometry_noise) {
        (0.0, 0.0) => "odometry as recorded".to_owned(),
        (drift, noise) => format!("odometry with {:.0} % drift and {:.0} % noise", 100.0 * drift, 100.0 * noise),
    };
    let start = if args.global { "from nothing" } else { "from the first corrected pose" };
    format!("Localized {start}, {odometry}: off by {:.3} m (median), at most {:.2} m.", score.median_m, score.max_m)
}

fn csv(course: &Course) -> String {
    let mut text = "line,time_s,corrected_x_m,corrected_y_m,corrected_heading_rad,\
                    estimate_x_m,estimate_y_m,estimate_heading_rad,error_m,error_rad,\
                    sigma_x_m,sigma_y_m,sigma_heading_rad,odometry_x_m,odometry_y_m,odometry_heading_rad\n"
        .to_owned();
    for at in &course.waypoints {
        let of = |pose: &maps::Pose| {
            let position = pose.translation.vector;
            format!("{:.4},{:.4},{:.5}", position.x, position.y, maps::heading(pose))
        };
        let sigma = at.covariance.diagonal().map(f64::sqrt);
        text += &format!(
            "{},{:.3},{},{},{:.4},{:.5},{:.4},{:.4},{:.5},{}\n",
            at.line,
            at.time.as_secs_f64(),
            of(&at.corrected),
            of(&at.estimate),
            at.error_m(),
            at.error_rad(),
            sigma.x,
            sigma.y,
            sigma.z,
            of(&at.odometry),
        );
    }
    text
}

fn in_words(args: &LocalizeArgs, fit: &Fit, course: &Course, score: &Score) -> String {
    let mut text = format!("{}, seed {}\n", args.log.display(), args.seed);
    let mut line = |name: &str, what: String| text += &format!("  {name:<8}  {what}\n");
    let found = match (score.converged_at, score.converged_after_m) {
        (Some(at), Some(way_m)) => format!("at {:.1} s, after {way_m:.1} m", at.as_secs_f64()),
        _ => "never".to_owned(),
    };
    line("scans", format!("{} over {:.0} m, {} updates", score.scans, score.driven_m, course.updates));
    line("surfaces", format!("{:.3} m behind the faces of the map's cells", fit.surface_depth_m));
    line("found", found);
    line(
        "position",
        format!("median {:.4} m, RMSE {:.4} m, at most {:.3} m", score.median_m, score.rmse_m, score.max_m),
    );
    line("heading", format!("median {:.4} rad, RMSE {:.4} rad", score.median_rad, score.rmse_rad));
    let seconds = |stretch: &Stretch| format!("{:.1}–{:.1} s", stretch.from.as_secs_f64(), stretch.to.as_secs_f64());
    let lost: Vec<String> = score.lost.iter().map(seconds).collect();
    line("lost", if lost.is_empty() { "never".to_owned() } else { lost.join(", ") });
    if let Some(folder) = &args.out {
        line("wrote", format!("trajectories.csv and trajectories.png in {}", folder.display()));
    }
    text
}

fn as_json(args: &LocalizeArgs, recording: &Recording, fit: &Fit, course: &Course, score: &Score) -> serde_json::Value {
    let lost = score.lost.iter().map(|stretch| [stretch.from, stretch.to].map(seconds));
    json!({
        "map": args.map_name(),
        "log": args.log.display().to_string(),
        "seed": args.seed,
        "global": args.global,
        "odometry_drift": args.odometry_drift,
        "odometry_noise": args.odometry_noise,
        "surface_depth_m": fit.surface_depth_m,
        "scans": score.scans,
        "updates": course.updates,
        "driven_m": score.driven_m,
        "median_m": score.median_m,
        "rmse_m": score.rmse_m,
        "max_m": score.max_m,
        "median_rad": score.median_rad,
        "rmse_rad": score.rmse_rad,
        "lost": lost.collect::<Vec<_>>(),
        "converged_at_s": score.converged_at.map(seconds),
        "converged_after_m": score.converged_after_m,
        "complaints": recording.complaints().iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn starts_in_words(starts: &[Start]) -> String {
    let mut text = String::from("start  line    time      found after\n");
    for (number, start) in starts.iter().enumerate() {
        let found = start.found_after_m.map_or_else(|| "not found".to_owned(), |way_m| format!("{way_m:.1} m"));
        text += &format!("{:>5}  {:<6}  {:>6.1} s  {found}\n", number + 1, start.line, start.time.as_secs_f64());
    }
    text += &format!("found within {WITHIN_M} m: {} of {}\n", found(starts), starts.len());
    text
}

fn starts_as_json(starts: &[Start]) -> serde_json::Value {
    let each = starts.iter().map(
        |start| json!({ "line": start.line, "time_s": seconds(start.time), "found_after_m": start.found_after_m }),
    );
    json!({ "within_m": WITHIN_M, "found": found(starts), "starts": each.collect::<Vec<_>>() })
}

fn found(starts: &[Start]) -> usize {
    starts.iter().filter(|start| start.is_found()).count()
}
