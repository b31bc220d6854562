//! A recording that is still being written.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::files::{is_missing, is_same, names, skipped, stem_and_number};
use super::mcap::{LogOrder, MAGIC, McapFollower};
use super::metadata::{METADATA, Metadata};
use super::source::{Account, Aside, Received, Source, Wanted, received};
use super::survey::Survey;
use super::{Bag, unpack};
use crate::Error;

/// How long a file that rosbag2 has not closed may rest after rosbag2 has ended: it may write the metadata first.
/// Chosen, not measured.
const PATIENCE: Duration = Duration::from_secs(5);

/// The messages of a recording that is still being written, as [`Messages`](super::Messages) reads those of a bag: an
/// MCAP file, or the folder of a bag, whose files follow one another.
///
/// A message counts once its record is in the file as a whole, or its chunk if there are chunks. A file is over when it
/// has been closed, and a folder when rosbag2 has also written its metadata. A folder that has it from the start gets
/// the checks of a [bag](Bag) that is opened.
pub struct Following {
    path: PathBuf,
    is_folder: bool,
    /// The names of the folder's files that have been opened; if the path is a file, whether it has been.
    opened: BTreeSet<String>,
    current: Option<(PathBuf, McapFollower)>,
    survey: Survey,
    wanted: Wanted,
    aside: Aside,
    order: LogOrder,
    /// For how many topics it is known that what is lost may belong before all that has been read.
    displaced: usize,
    /// Since when nothing more is expected.
    resting: Option<Instant>,
    /// Whether everything has been read that has been written as a whole to the last file.
    is_waiting: bool,
    is_over: bool,
}

impl Following {
    /// Starts at the beginning of a recording. Reads the messages of the topics with these names.
    ///
    /// # Errors
    /// If there is no such file or folder, or it is in a format that cannot be followed; also if a folder with metadata
    /// is not one recording.
    pub fn open<'n>(path: &Path, topics: impl IntoIterator<Item = &'n str>) -> Result<Self, Error> {
        let wanted = Wanted::Named(topics.into_iter().map(str::to_owned).collect());
        Self::begin(path.to_owned(), wanted, Survey::of_recorder())
    }

    /// Starts at the beginning again. The topics that have been seen keep their indices.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn restart(self) -> Result<Self, Error> {
        let counts = vec![0; self.survey.topics.len()];
        let survey = Survey { topics: self.survey.topics, counts, ..Survey::of_recorder() };
        Self::begin(self.path, self.wanted, survey)
    }

    fn begin(path: PathBuf, wanted: Wanted, survey: Survey) -> Result<Self, Error> {
        let mut following = Self {
            is_folder: path.is_dir(),
            path,
            opened: BTreeSet::new(),
            current: None,
            survey,
            wanted,
            aside: Aside::default(),
            order: LogOrder::default(),
            displaced: 0,
            resting: None,
            is_waiting: false,
            is_over: false,
        };
        let first = following.next_file()?;
        if following.is_folder && following.path.join(METADATA).exists() {
            let Bag { survey, .. } = Bag::open(&following.path)?;
            following.aside = Aside { lost: survey.lost, notes: survey.notes };
        }
        if let Some((name, path)) = first {
            following.enter(name, path)?;
        }
        Ok(following)
    }

    /// Opens a file, if its writer has begun it. Returns whether it has.
    fn enter(&mut self, name: String, path: PathBuf) -> Result<bool, Error> {
        let length = diagnostics::open_regular(&path).and_then(|file| Ok(file.metadata()?.len()));
        let length = length.map_err(|source| diagnostics::Error::Read { path: path.clone(), source })?;
        if length < MAGIC.len() as u64 {
            return Ok(false);
        }
        let reader = McapFollower::open(&path).map_err(|error| match error {
            Error::NoBag(path) => Error::Followed(path),
            other => other,
        })?;
        self.opened.insert(name);
        if self.is_folder && self.listed().is_empty() {
            let mut names: Vec<String> = self.opened.iter().cloned().collect();
            names.sort_by_key(|name| stem_and_number(name).1);
            let skipped = skipped(&names).into_iter().filter(|what| !self.aside.lost.contains(what));
            self.aside.lost.extend(skipped.collect::<Vec<_>>());
        }
        self.current = Some((path, reader));
        Ok(true)
    }

    /// The name and the path of the next file, if there is one.
    fn next_file(&self) -> Result<Option<(String, PathBuf)>, Error> {
        if !self.is_folder {
            return Ok(self.opened.is_empty().then(|| (String::new(), self.path.clone())));
        }
        let names = names(&self.path)?;
        if let Some(other) = names.iter().find(|name| name.ends_with(".db3")) {
            return Err(Error::Followed(self.path.join(other)));
        }
        // Once there is a list, only what it contains; until then, what is named like the first file.
        let listed = self.listed();
        let first = self.opened.first().map(|name| stem_and_number(name).0);
        let is_of_it = |name: &String| match listed.is_empty() {
            true => first.is_none_or(|first| stem_and_number(name).0 == first),
            false => listed.contains(name),
        };
        let is_next = |name: &String| name.ends_with(".mcap") && is_of_it(name) && !self.has_opened(name);
        let next = names.into_iter().find(is_next);
        Ok(next.map(|name| (name.clone(), self.path.join(name))))
    }

    /// What rosbag2's metadata lists, once there is any.
    fn listed(&self) -> Vec<String> {
        Metadata::of(&self.path).listed
    }

    /// Whether no further file is to be expected.
    fn is_complete(&self) -> bool {
        let is_gone = |path: &Path| fs::metadata(path).is_err_and(|error| error.kind() == ErrorKind::NotFound);
        match self.is_folder {
            true => self.path.join(METADATA).exists() || is_gone(&self.path),
            false => !self.opened.is_empty() && self.current.is_none() || is_gone(&self.path),
        }
    }

    /// What comes next if nothing more has been written to the last file.
    #[expect(clippy::disallowed_methods, reason = "waits for another program")]
    fn rest(&mut self, file: &Path) -> Received {
        self.is_waiting = true;
        if !self.is_complete() {
            self.resting = None;
            return Received::Idle;
        }
        if self.resting.get_or_insert_with(Instant::now).elapsed() < PATIENCE {
            return Received::Idle;
        }
        self.close(Some(format!("{} was never closed: its end is missing", file.display())))
    }

    /// That the next file breaks off, in words, if not even what it begins with is there as a whole.
    fn breaks_off(&self) -> Option<String> {
        let (_, path) = self.next_file().ok()??;
        let length = fs::metadata(&path).ok()?.len();
        let is_part = length > 0 && length < MAGIC.len() as u64;
        is_part.then(|| format!("{} breaks off before its first message: the rest is lost", path.display()))
    }

    /// Whether a file has been opened, by this name or another.
    fn has_opened(&self, name: &str) -> bool {
        self.opened.contains(name)
            || self.opened.iter().any(|other| is_same(&self.path.join(other), &self.path.join(name)))
    }

    /// Which listed file was never found, or which was read that is not listed, or that the folder is gone, in words.
    fn missing(&mut self) -> Option<String> {
        if !self.is_folder {
            return None;
        }
        if !self.path.join(METADATA).exists() {
            return Some(format!("{} was removed while it was followed", self.path.display()));
        }
        let metadata = Metadata::of(&self.path);
        metadata.compare_topics(&mut self.survey);
        let Metadata { listed, lost, .. } = metadata;
        if lost.is_some() {
            return lost;
        }
        let missing = listed.iter().find(|name| !self.has_opened(name)).map(|name| is_missing(name));
        let other = || self.opened.iter().find(|name| !listed.is_empty() && !listed.contains(name));
        let other = || other().map(|name| format!("{name} was read, although {METADATA} does not list it"));
        let wrong = missing.or_else(other)?;
        self.survey.doubt(&wrong);
        Some(wrong)
    }

    fn close(&mut self, lost: Option<String>) -> Received {
        let lost = lost.filter(|what| !self.aside.lost.contains(what));
        self.aside.lost.extend(lost);
        self.is_over = true;
        Received::Over
    }
}

impl Following {
    fn read(&mut self, body: &mut Vec<u8>) -> Received {
        while !self.is_over {
            let Some((path, reader)) = &mut self.current else {
                match self.next_file() {
                    Ok(Some((name, path))) => match self.enter(name, path.clone()) {
                        Ok(true) => continue,
                        Ok(false) => return self.rest(&path),
                        Err(error) => return self.close(Some(error.to_string())),
                    },
                    Ok(None) if !self.is_complete() => return Received::Idle,
                    // The last file may have been written in between.
                    Ok(None) if self.next_file().is_ok_and(|next| next.is_some()) => continue,
                    Ok(None) => {
                        let missing = self.missing();
                        return self.close(missing);
                    }
                    Err(error) => return self.close(Some(error.to_string())),
                }
            };
            match reader.receive(&self.wanted, &mut self.survey, body, &mut self.aside.lost, &mut self.order) {
                Received::Message(head) => {
                    (self.resting, self.is_waiting) = (None, false);
                    self.survey.count(head.topic, head.log_ns);
                    unpack(body, &mut self.aside.lost);
                    if let Some(received) = received(head, &mut self.survey, &self.wanted, body, &mut self.aside) {
                        return received;
                    }
                }
                Received::Over => {
                    if let Some((_, reader)) = self.current.take() {
                        reader.finish(&self.wanted, &mut self.survey, &mut self.aside.lost);
                    }
                }
                _ => {
                    let path = path.clone();
                    return self.rest(&path);
                }
            }
        }
        Received::Over
    }

    /// What is lost of a recording whose messages are out of order may belong before all that has been read.
    fn displace_lost(&mut self) {
        if self.order.is_ascending {
            return;
        }
        if let Some(what) = self.aside.lost.first() {
            let topics = self.displaced..self.survey.topics.len();
            self.displaced = topics.end;
            self.survey.missing.extend(topics.map(|topic| (topic, what.clone())));
        }
    }
}

impl Source for Following {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        let received = self.read(body);
        self.displace_lost();
        received
    }

    /// If only a part of the next record has been written, its rest is not awaited any longer: it is lost.
    fn end(&mut self) {
        if self.is_over {
            return;
        }
        let lost = match &mut self.current {
            _ if !self.is_waiting => None,
            Some((_, reader)) => reader.breaks_off(),
            None => self.breaks_off(),
        };
        self.close(lost);
        self.displace_lost();
    }

    fn account(&self) -> Account<'_> {
        self.aside.account(&self.survey, true)
    }
}
