//! `steward map --log LOG --out MAP.yaml`: makes a map from a recorded robot's scans.

use std::path::PathBuf;
use std::process::ExitCode;

use campaigns::Error;
use clap::Args;
use maps::{Cell, ImageFormat};
use replay::mapping::{MappingParameters, map_of};

use crate::localize::{Log, TopicArgs, open_log};
use crate::output::print_wrapped;

/// A log, and how to make a map from it.
#[derive(Debug, Args)]
pub(crate) struct MapArgs {
    /// The log, in CARMEN's format (.log or .log.gz), or a ROS 2 bag
    #[arg(long)]
    log: PathBuf,
    #[command(flatten)]
    topics: TopicArgs,
    /// Where the map goes: a YAML file, with the image (PGM) beside it, or a folder [default: the log's name with
    /// .yaml, here]
    #[arg(long, value_name = "MAP.yaml|DIR")]
    out: Option<PathBuf>,
    /// Overwrites an existing map
    #[arg(long)]
    force: bool,
    /// The size of a cell, in meters
    #[arg(long, value_name = "M", default_value_t = 0.05, value_parser = meters)]
    resolution: f64,
    /// Uses beams up to this range, in meters
    #[arg(long, value_name = "M", default_value_t = 20.0, value_parser = meters)]
    max_range: f64,
}

fn meters(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|_| "not a number".to_owned())?;
    if (0.005..=1000.0).contains(&value) { Ok(value) } else { Err("not from 0.005 to 1000".to_owned()) }
}

/// Builds the map and writes it.
pub(crate) fn map(args: &MapArgs) -> Result<ExitCode, Error> {
    let path = yaml_path(args);
    let files = [path.clone(), path.with_extension("pgm")];
    if let Some(there) = files.iter().find(|path| !args.force && path.exists()) {
        let message = format!("{} is there already", there.display());
        return Err(Error::refused(message, "`--force` replaces a map and its image"));
    }
    let Log { recording, .. } = open_log(&args.log, &args.topics)?;
    files.iter().try_for_each(|file| diagnostics::check_unread(file))?;
    let parameters = MappingParameters {
        resolution_m: args.resolution,
        range_max_m: args.max_range,
        ..MappingParameters::default()
    };
    let grid = map_of(&recording, &parameters).map_err(|error| {
        let help = "a map is made from the scans of FLASER lines, at the first pose in each of these lines";
        Error::refused(format!("{}: {error}", args.log.display()), help)
    })?;
    maps::save_map(&grid, &path, ImageFormat::Pgm).map_err(scenarios::Error::from)?;
    let occupied = grid.cells().iter().filter(|cell| **cell == Cell::Occupied).count();
    let free = grid.cells().iter().filter(|cell| **cell == Cell::Free).count();
    print_wrapped(format!(
        "{}: {} × {} cells of {} m from {} scans, {free} of them free and {occupied} occupied\n",
        path.display(),
        grid.width(),
        grid.height(),
        grid.resolution_m(),
        recording.corrected_scans().count(),
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The path of the YAML file: named after the log if it goes to a folder; otherwise, `.yaml` is appended unless the
/// name already ends in `.yaml` or `.yml`.
fn yaml_path(args: &MapArgs) -> PathBuf {
    let name = args.log.file_name().unwrap_or_default().to_string_lossy();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let by_log = format!("{}.yaml", name.strip_suffix(".log").unwrap_or(name));
    let Some(out) = &args.out else { return by_log.into() };
    if out.is_dir() || out.as_os_str().as_encoded_bytes().ends_with(b"/") {
        return out.join(by_log);
    }
    match out.extension() {
        Some(ending) if ending == "yaml" || ending == "yml" => out.clone(),
        _ => {
            let mut path = out.clone().into_os_string();
            path.push(".yaml");
            path.into()
        }
    }
}
