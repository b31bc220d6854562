//! `steward live --groot`: shows the tree of a program with BehaviorTree.CPP in the browser, and checks properties.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use campaigns::Error;
use cockpit::{Cockpit, Feed};
use judging::{ShowRun, TreeProgram, Wanted};

use crate::interrupt::{self, HOST};
use crate::live::groot_args::GrootArgs;
use crate::live::{PageArgs, serve_meanwhile};
use crate::output::{note, print_wrapped};
use crate::verify::announcer::{Announcer, Reactions};
use crate::verify::in_words;

/// Shows and checks the trees of a program until Ctrl-C. Status 2 if a property has no verdict, otherwise 1 if one is
/// violated, or its verdict is unsure.
pub(crate) fn live(args: &GrootArgs, address: &str, page: &PageArgs) -> Result<ExitCode, Error> {
    interrupt::listen();
    let mut program = TreeProgram::connect(address, args.passive, HOST)?;
    let (feed, records) = Feed::new();
    let records = Cell::new(Some(records));
    let show: ShowRun<'_> = &|view| {
        feed.begin(view);
        if let Some(records) = records.take() {
            serve_meanwhile(page.announce(Cockpit::follow(records, page.port))?);
        }
        Ok(Box::new(feed.clone()))
    };
    let mut status = 0;
    for number in 1.. {
        let record = args.record.as_deref().map(|file| numbered(file, number));
        let wanted = Wanted {
            command: String::new(),
            folder: None,
            stories: false,
            inputs: &Vec::new,
            observer: Some(Announcer::boxed(false, Reactions::default())),
            record: record.as_deref(),
            page: Some(show),
            host: HOST,
        };
        let Some(result) = program.judge(&args.properties, wanted)? else { break };
        result.notes.iter().for_each(|text| note(text));
        if !result.properties.is_empty() {
            print_wrapped(in_words(&result))?;
        }
        status = status.max(result.status());
    }
    Ok(ExitCode::from(status))
}

/// The file of the tree with this number.
fn numbered(file: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return file.to_owned();
    }
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let name = format!("{stem}-{number}");
    match file.extension() {
        Some(ending) => file.with_file_name(name).with_extension(ending),
        None => file.with_file_name(name),
    }
}
