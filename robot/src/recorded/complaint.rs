//! Problems of a log.

use std::fmt;
use std::sync::Arc;

/// A flaw of a line in a log, and the number of further lines that have it; part of a [`Recording`](super::Recording).
///
/// Its text also names what was done about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Complaint {
    /// The first line that has the flaw, from 1.
    pub line: usize,
    /// The flaw on this line.
    pub flaw: Flaw,
    /// The number of further lines with this kind of flaw.
    pub more: usize,
}

/// Possible problems of a line.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Flaw {
    /// The gzipped file is truncated.
    CompressionBreaksOff,
    /// The last line is truncated.
    LineBreaksOff,
    /// It does not begin with a word in capitals.
    NoKeyword {
        /// How it begins.
        start: String,
    },
    /// It has the wrong number of fields.
    Fields {
        /// Its first word.
        keyword: &'static str,
        /// The number of fields that it should have.
        expected: usize,
        /// The number of fields that it has.
        found: usize,
    },
    /// A field should be a finite number but is not.
    Number {
        /// The meaning of the field.
        field: &'static str,
        /// The content of the field.
        text: String,
    },
    /// The scan has a different number of beams than most.
    Beams {
        /// The number that most scans have.
        expected: usize,
        /// The number that this scan has.
        found: usize,
    },
    /// Ranges of the scan are negative or not numbers.
    Ranges {
        /// How many.
        count: usize,
    },
    /// The clock is earlier than on a previous line.
    ClockBack {
        /// The difference in seconds.
        by_s: f64,
    },
    /// The clock of an odometry line is so much earlier than on the lines around it that the line may belong elsewhere.
    ClockElsewhere {
        /// The difference in seconds.
        by_s: f64,
    },
    /// Odometry lines usually differ from the odometry of the scans.
    OtherFrame {
        /// The difference in meters.
        by_m: f64,
    },
    /// The clock was set back and continues from there.
    ClockSetBack {
        /// The difference in seconds.
        by_s: f64,
    },
    /// The clock was set forward by a day or more and continues from there.
    ClockSetForward {
        /// The difference in seconds.
        by_s: f64,
    },
    /// The clock is ahead of most lines that follow.
    ClockAhead {
        /// The difference in seconds.
        by_s: f64,
    },
    /// Odometry is farther from the previous line's than a robot can have driven.
    OdometryJumps {
        /// The distance in meters.
        by_m: f64,
    },
    /// The corrected pose is far from those of the scans before and after it.
    StrayPose {
        /// The distance in meters.
        by_m: f64,
    },
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CompressionBreaksOff => write!(f, "the compressed file is truncated here"),
            Self::LineBreaksOff => write!(f, "the log is truncated within this line"),
            Self::NoKeyword { start } => write!(f, "no line of a log begins with `{start}`"),
            Self::Fields { keyword, expected, found } => {
                write!(f, "this {keyword} should have {expected} fields, but has {found}")
            }
            Self::Number { field, text } => write!(f, "{field} should be a number, but is `{text}`"),
            Self::Beams { expected, found } => write!(f, "this scan has {found} beams, but most have {expected}"),
            Self::Ranges { count: 1 } => write!(f, "a range is negative or not a number"),
            Self::Ranges { count } => write!(f, "{count} ranges are negative or not numbers"),
            Self::ClockBack { by_s } => write!(f, "the clock goes back by {by_s:.3} s"),
            Self::ClockElsewhere { by_s } => {
                write!(f, "the clock of this odometry is {by_s:.3} s behind the lines around it")
            }
            Self::OtherFrame { by_m } => {
                write!(f, "ODOM lines use another frame than the odometry of scans (here {by_m:.1} m away)")
            }
            Self::ClockSetBack { by_s } => write!(f, "the clock was set back by {by_s:.3} s"),
            Self::ClockSetForward { by_s } => write!(f, "the clock was set forward by {by_s:.3} s"),
            Self::ClockAhead { by_s } => write!(f, "the clock is {by_s:.3} s ahead of the lines that follow"),
            Self::OdometryJumps { by_m } => write!(f, "odometry jumps by {by_m:.1} m"),
            Self::StrayPose { by_m } => {
                write!(f, "the corrected pose is {by_m:.1} m away from those of neighboring scans")
            }
        }
    }
}

impl Flaw {
    fn remedy(&self) -> &'static str {
        match self {
            Self::CompressionBreaksOff | Self::LineBreaksOff => "only the lines before it are used",
            Self::NoKeyword { .. } | Self::Fields { .. } | Self::Number { .. } => "left out",
            Self::Beams { .. } => "left out, since its beams may have other angles",
            Self::Ranges { .. } => "these beams are not used",
            Self::ClockBack { .. } => "lines are used in the order of the file",
            Self::ClockElsewhere { .. } => "left out; scans have their own odometry",
            Self::OtherFrame { .. } => "all of them are left out",
            Self::ClockSetBack { .. } | Self::ClockSetForward { .. } => "time continues from the previous line",
            Self::ClockAhead { .. } => "time continues as before",
            Self::OdometryJumps { .. } => "the robot is assumed to have stood still",
            Self::StrayPose { .. } => "not used",
        }
    }
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.flaw)?;
        match self.more {
            0 => {}
            1 => write!(f, ", and on another line")?,
            more => write!(f, ", and on {more} more lines")?,
        }
        write!(f, "; {}", self.flaw.remedy())
    }
}

/// Why a file cannot be used as a recording at all.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The compressed data is inconsistent, so none of it can be trusted.
    #[error("the compressed log is damaged at or before line {line}: {source}")]
    Damaged {
        /// The last line that could be decompressed.
        line: usize,
        /// The decompressor's error.
        source: Arc<std::io::Error>,
    },
    /// It is longer than a gibibyte.
    #[error("the log is longer than 1 GiB")]
    TooLong,
    /// All its scans are in the format of later loggers.
    #[error(
        "line {line}: the scans of this log are in ROBOTLASER lines, the format of later \
         CARMEN loggers, which is not supported: only FLASER lines have room for both a corrected pose and odometry"
    )]
    LaterFormat {
        /// The first such line.
        line: usize,
    },
    /// It has no scans, or almost none of its lines belong in a log.
    #[error("not a CARMEN log: no line begins with FLASER{}", first(.complaints))]
    NoScans {
        /// The problems of its lines.
        complaints: Vec<Complaint>,
    },
    /// Most of it is unusable, so the rest is meaningless.
    #[error("{unusable} of {scans} scans cannot be used, so the others are not used either{}", first(.complaints))]
    Unusable {
        /// The number of unusable scans.
        unusable: usize,
        /// The number of all scans.
        scans: usize,
        /// The problems of its lines.
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
