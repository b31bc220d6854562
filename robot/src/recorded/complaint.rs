//! What is wrong with a log.

use std::fmt;
use std::sync::Arc;

/// What is wrong with a line of a log, and with how many more: part of what [`Recording`](super::Recording) tells.
///
/// As text it says what has been done about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Complaint {
    /// The first line that has the flaw, from 1.
    pub line: usize,
    /// The flaw as it is on that line.
    pub flaw: Flaw,
    /// How many more lines have the like.
    pub more: usize,
}

/// What can be wrong with a line.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Flaw {
    /// The gzipped file ends before its time.
    CompressionBreaksOff,
    /// The file ends within the line.
    LineBreaksOff,
    /// It begins with no word in capitals.
    NoKeyword {
        /// How it begins.
        start: String,
    },
    /// It has more or fewer fields than it should have.
    Fields {
        /// Its first word.
        keyword: &'static str,
        /// As many as it should have.
        expected: usize,
        /// As many as it has.
        found: usize,
    },
    /// A field should be a finite number and is none.
    Number {
        /// What the field stands for.
        field: &'static str,
        /// What it says.
        text: String,
    },
    /// The scan has another number of beams than most.
    Beams {
        /// As many as most have.
        expected: usize,
        /// As many as it has.
        found: usize,
    },
    /// Ranges of the scan are negative or no numbers.
    Ranges {
        /// How many.
        count: usize,
    },
    /// The clock is earlier than on a line before.
    ClockBack {
        /// By so many seconds.
        by_s: f64,
    },
    /// The clock of odometry is so much earlier than on the lines around it that the line may be from elsewhere.
    ClockElsewhere {
        /// By so many seconds.
        by_s: f64,
    },
    /// Odometry of its own is, as a rule, elsewhere than that of the scans.
    OtherFrame {
        /// By so many metres.
        by_m: f64,
    },
    /// The clock was set back, and goes on from there.
    ClockSetBack {
        /// By so many seconds.
        by_s: f64,
    },
    /// The clock was set forward by a day or more, and goes on from there.
    ClockSetForward {
        /// By so many seconds.
        by_s: f64,
    },
    /// The clock is ahead of that of most lines that follow.
    ClockAhead {
        /// By so many seconds.
        by_s: f64,
    },
    /// Odometry is farther from that of the line before than a robot can have driven.
    OdometryJumps {
        /// By so many metres.
        by_m: f64,
    },
    /// The corrected pose is far from those of the scans before and after it.
    StrayPose {
        /// By so many metres.
        by_m: f64,
    },
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CompressionBreaksOff => write!(f, "the compressed file breaks off here"),
            Self::LineBreaksOff => write!(f, "the log breaks off within this line"),
            Self::NoKeyword { start } => write!(f, "`{start}` is not how a line of a log begins"),
            Self::Fields { keyword, expected, found } => {
                write!(f, "this {keyword} should have {expected} fields, but has {found}")
            }
            Self::Number { field, text } => write!(f, "{field} should be a number, but is `{text}`"),
            Self::Beams { expected, found } => write!(f, "a scan of {found} beams, where most have {expected}"),
            Self::Ranges { count: 1 } => write!(f, "a range is negative or no number"),
            Self::Ranges { count } => write!(f, "{count} ranges are negative or no numbers"),
            Self::ClockBack { by_s } => write!(f, "the clock goes back by {by_s:.3} s"),
            Self::ClockElsewhere { by_s } => {
                write!(f, "the clock of this odometry is {by_s:.3} s behind that of the lines around it")
            }
            Self::OtherFrame { by_m } => {
                write!(f, "ODOM lines are in another frame than the odometry of scans, {by_m:.1} m away as here")
            }
            Self::ClockSetBack { by_s } => write!(f, "the clock is set back by {by_s:.3} s"),
            Self::ClockSetForward { by_s } => write!(f, "the clock is set forward by {by_s:.3} s"),
            Self::ClockAhead { by_s } => write!(f, "the clock is {by_s:.3} s ahead of that of the lines that follow"),
            Self::OdometryJumps { by_m } => write!(f, "odometry jumps by {by_m:.1} m"),
            Self::StrayPose { by_m } => {
                write!(f, "the corrected pose is {by_m:.1} m away from those of the scans around it")
            }
        }
    }
}

impl Flaw {
    /// What is done about it.
    fn remedy(&self) -> &'static str {
        match self {
            Self::CompressionBreaksOff | Self::LineBreaksOff => "the lines before are used",
            Self::NoKeyword { .. } | Self::Fields { .. } | Self::Number { .. } => "left out",
            Self::Beams { .. } => "left out, since its beams may point elsewhere",
            Self::Ranges { .. } => "these beams are not used",
            Self::ClockBack { .. } => "lines are taken in the order of the file",
            Self::ClockElsewhere { .. } => "left out; scans carry odometry of their own",
            Self::OtherFrame { .. } => "all of them are left out",
            Self::ClockSetBack { .. } | Self::ClockSetForward { .. } => "time goes on from where it was",
            Self::ClockAhead { .. } => "time goes on as before",
            Self::OdometryJumps { .. } => "the robot is taken to have stood still",
            Self::StrayPose { .. } => "it is not used",
        }
    }
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.flaw)?;
        match self.more {
            0 => {}
            1 => write!(f, ", and another line has the like")?,
            more => write!(f, ", and {more} more lines have the like")?,
        }
        write!(f, "; {}", self.flaw.remedy())
    }
}

/// Why a file cannot be used as a recording at all.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The compressed data contradict themselves, so that nothing of them can be trusted.
    #[error("the compressed log is damaged, at line {line} at the latest: {source}")]
    Damaged {
        /// As far as it could be decompressed.
        line: usize,
        /// What the decompressor says.
        source: Arc<std::io::Error>,
    },
    /// It is longer than a gibibyte.
    #[error("the log is longer than 1 GiB")]
    TooLong,
    /// It has scans in the format of later loggers alone.
    #[error(
        "line {line}: the scans of this log are in ROBOTLASER lines, the format of later CARMEN loggers, which is not read: \
         only FLASER lines have room for both a corrected pose and odometry"
    )]
    LaterFormat {
        /// The first such line.
        line: usize,
    },
    /// It has no scans, or hardly anything in it is a line of a log.
    #[error("this is no CARMEN log: it has no line that begins with FLASER{}", first(.complaints))]
    NoScans {
        /// What is wrong with its lines.
        complaints: Vec<Complaint>,
    },
    /// Most of it cannot be used, so that the rest means nothing.
    #[error("{unusable} of {scans} scans cannot be used, so the others are not used either{}", first(.complaints))]
    Unusable {
        /// Scans that cannot be used.
        unusable: usize,
        /// Scans that there are.
        scans: usize,
        /// What is wrong with its lines.
        complaints: Vec<Complaint>,
    },
}

fn first(complaints: &[Complaint]) -> String {
    complaints.first().map_or_else(String::new, |complaint| format!("; line {}: {}", complaint.line, complaint.flaw))
}

/// Collects complaints, one for each kind of flaw.
#[derive(Clone, Debug, Default)]
pub(super) struct Complaints(Vec<Complaint>);

impl Complaints {
    pub(super) fn add(&mut self, line: usize, flaw: Flaw) {
        let alike =
            |complaint: &&mut Complaint| std::mem::discriminant(&complaint.flaw) == std::mem::discriminant(&flaw);
        match self.0.iter_mut().find(alike) {
            Some(complaint) => complaint.more += 1,
            None => self.0.push(Complaint { line, flaw, more: 0 }),
        }
    }

    /// All of them by line.
    pub(super) fn into_sorted(mut self) -> Vec<Complaint> {
        self.0.sort_by_key(|complaint| complaint.line);
        self.0
    }
}
