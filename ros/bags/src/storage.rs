//! The files of a bag: their topics, and their messages one after the other.

mod files;
mod following;
mod mcap;
mod source;
#[cfg(feature = "sqlite")]
mod sqlite;
mod survey;
mod writer;
mod zstandard;

use std::io::Read;
use std::path::{Path, PathBuf};

use crate::Error;
use files::Format;
use source::{Aside, Wanted};
use zstandard::Zstandard;

pub use files::is_bag;
pub use following::Following;
pub(crate) use source::is_note;
pub use source::{Received, Source, Through};
pub use survey::{Definition, Head, Survey, Topic};
pub use writer::{BagWriter, Recorder};

/// A ROS 2 recording: a file, or a folder of files.
#[derive(Clone, Debug)]
pub struct Bag {
    files: Vec<(PathBuf, Format)>,
    survey: Survey,
}

impl Bag {
    /// Finds the files of a bag and the topics in them. Reads the summaries of the files; a file that was not closed
    /// has none and is read once in full.
    ///
    /// # Errors
    /// If it is not a bag or cannot be read at all. Damage is not an error: everything before it is read.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let mut survey = Survey::of_recorder();
        let files = files::of(path, &mut survey)?;
        for (path, format) in &files {
            let file = diagnostics::open_regular(path);
            let file = file.map_err(|source| diagnostics::Error::Read { path: path.clone(), source })?;
            if file.metadata().is_ok_and(|found| found.len() == 0) {
                return Err(Error::Empty(path.clone()));
            }
            match format {
                Format::Mcap => mcap::survey(path, &mut survey)?,
                #[cfg(feature = "sqlite")]
                Format::Sqlite => sqlite::survey(path, &mut survey)?,
                #[cfg(not(feature = "sqlite"))]
                Format::Sqlite => return Err(Error::NoSqlite(path.clone())),
            }
        }
        Ok(Self { files, survey })
    }

    /// What the bag contains.
    #[must_use]
    pub fn survey(&self) -> &Survey {
        &self.survey
    }

    /// Reads the messages of the topics with the indices `wanted`, in the order in which they were recorded.
    #[must_use]
    pub fn messages(&self, wanted: &[usize]) -> Messages {
        let wanted = (0..self.survey.topics.len()).map(|topic| wanted.contains(&topic)).collect();
        self.messages_of(Wanted::Known(wanted))
    }

    /// The same for topics with these names.
    #[must_use]
    pub fn messages_on<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> Messages {
        self.messages_of(Wanted::Named(names.into_iter().map(str::to_owned).collect()))
    }

    fn messages_of(&self, wanted: Wanted) -> Messages {
        let (files, survey) = (self.files.clone().into_iter(), self.survey.clone());
        Messages { files, survey, wanted, current: None, aside: Aside::default() }
    }
}

/// The messages of a bag, one after the other.
pub struct Messages {
    files: std::vec::IntoIter<(PathBuf, Format)>,
    survey: Survey,
    wanted: Wanted,
    current: Option<StorageReader>,
    aside: Aside,
}

enum StorageReader {
    Mcap(Box<mcap::McapReader>),
    #[cfg(feature = "sqlite")]
    Sqlite(Box<sqlite::SqliteReader>),
}

impl StorageReader {
    fn open(path: &Path, format: Format, wanted: &Wanted, survey: &mut Survey) -> Result<Self, Error> {
        match format {
            Format::Mcap => mcap::McapReader::open(path, wanted, survey).map(|reader| Self::Mcap(Box::new(reader))),
            #[cfg(feature = "sqlite")]
            Format::Sqlite => {
                sqlite::SqliteReader::open(path, wanted, survey).map(|reader| Self::Sqlite(Box::new(reader)))
            }
            #[cfg(not(feature = "sqlite"))]
            Format::Sqlite => Err(Error::NoSqlite(path.to_owned())),
        }
    }
}

impl Messages {
    /// Reads the next message into `body`. Returns its time and topic; none at the end.
    pub fn next_into(&mut self, body: &mut Vec<u8>) -> Option<Head> {
        loop {
            let next = match &mut self.current {
                None => {
                    let (path, format) = self.files.next()?;
                    match StorageReader::open(&path, format, &self.wanted, &mut self.survey) {
                        Ok(reader) => self.current = Some(reader),
                        Err(error) => self.aside.lost.push(error.to_string()),
                    }
                    continue;
                }
                Some(StorageReader::Mcap(reader)) => {
                    match reader.receive(&self.wanted, &mut self.survey, body, &mut self.aside.lost) {
                        Received::Message(head) => Some(head),
                        _ => None,
                    }
                }
                #[cfg(feature = "sqlite")]
                Some(StorageReader::Sqlite(reader)) => reader.next_into(body, &mut self.aside.lost),
            };
            if next.is_some() {
                unpack(body, &mut self.aside.lost);
                return next;
            }
            self.current = None;
        }
    }

    /// Damaged or missing parts so far, in words.
    #[must_use]
    pub fn lost(&self) -> &[String] {
        &self.aside.lost
    }
}

impl Source for Messages {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        while let Some(head) = self.next_into(body) {
            if let Some(received) = source::received(head, &mut self.survey, &self.wanted, body, &mut self.aside) {
                return received;
            }
        }
        Received::Over
    }

    fn survey(&self) -> &Survey {
        &self.survey
    }

    fn lost(&self) -> &[String] {
        &self.aside.lost
    }

    fn notes(&self) -> &[String] {
        &self.aside.notes
    }

    fn counts_losses(&self) -> bool {
        self.survey.topics.iter().any(|topic| topic.name == source::MISSING)
    }
}

/// Unpacks a message that rosbag2 compressed individually. CDR never begins like Zstandard.
fn unpack(body: &mut Vec<u8>, lost: &mut Vec<String>) {
    const ZSTANDARD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
    if !body.starts_with(&ZSTANDARD) {
        return;
    }
    let mut plain = Vec::new();
    match Zstandard::new(body.as_slice()).and_then(|mut packed| packed.read_to_end(&mut plain)) {
        Ok(_) => *body = plain,
        Err(error) => lost.push(format!("a compressed message is lost: {error}")),
    }
}
