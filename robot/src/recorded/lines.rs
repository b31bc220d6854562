//! The lines of a log, each on its own.

use maps::{Pose, pose};

use super::complaint::{Complaints, Flaw, RecordingError};
use crate::VelocityCommand;

/// Coordinates beyond this, in meters, are treated as mistakes.
const FARTHEST_M: f64 = 1e6;

/// More beams than this are treated as a mistake.
const MOST_BEAMS: usize = 100_000;

/// Odometry just before a scan is usually at most this far from the scan's own, in meters.
const SAME_FRAME_M: f64 = 1.0;

/// A line with odometry.
#[derive(Clone, Debug)]
pub(super) struct LogLine {
    pub(super) number: usize,
    pub(super) clock_s: f64,
    pub(super) odometry: Pose,
    pub(super) velocity: VelocityCommand,
    pub(super) corrected: Option<Pose>,
    pub(super) scan: Option<Scan>,
}

/// A scan as the line has it.
#[derive(Clone, Debug)]
pub(super) struct Scan {
    /// 0 at the front, 1 at the rear.
    pub(super) laser: usize,
    /// NaN for impossible ranges.
    pub(super) ranges_m: Vec<f32>,
}

/// The lines of a log that matter.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines {
    pub(super) lines: Vec<LogLine>,
    /// The first line with a scan in the format of later loggers, which is not supported.
    later_format: Option<usize>,
    /// Scans of the front laser that could not be used.
    unusable: usize,
    pub(super) front_offset_m: f64,
    pub(super) rear_offset_m: f64,
    /// The range that stands for "no hit" according to the log.
    pub(super) range_max_m: Option<f64>,
    /// The number of beams of the front and the rear laser; zero for a missing laser.
    pub(super) beams: [usize; 2],
}

impl Lines {
    pub(super) fn parse(text: &[u8], complaints: &mut Complaints) -> Result<Self, RecordingError> {
        let mut lines = Self::default();
        // Some editors write this byte order mark at the beginning of a text.
        let text = text.strip_prefix("\u{feff}".as_bytes()).unwrap_or(text);
        let is_whole = text.is_empty() || text.ends_with(b"\n");
        let count = text.split(|byte| *byte == b'\n').count();
        for (index, line) in text.split(|byte| *byte == b'\n').enumerate() {
            let breaks_off = index + 1 == count && !is_whole;
            let line = String::from_utf8_lossy(line);
            let taken = match lines.take(index + 1, &line) {
                // A truncated keyword looks like a different one.
                Ok(()) if breaks_off && line.split_ascii_whitespace().count() == 1 => Err(Flaw::LineBreaksOff),
                taken => taken,
            };
            if let Err(flaw) = taken {
                lines.unusable += usize::from(line.starts_with("FLASER"));
                complaints.add(index + 1, if breaks_off { Flaw::LineBreaksOff } else { flaw });
            }
        }
        if let Some(line) = lines.later_format.filter(|_| lines.unusable == 0 && lines.front_scans() == 0) {
            return Err(RecordingError::LaterFormat { line });
        }
        if lines.unusable == 0 && lines.front_scans() == 0 {
            return Err(RecordingError::NoScans { complaints: std::mem::take(complaints).into_sorted() });
        }
        Ok(lines)
    }

    fn take(&mut self, number: usize, line: &str) -> Result<(), Flaw> {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        match fields.first() {
            None => {}
            Some(comment) if comment.starts_with('#') => {}
            Some(&"ODOM") => self.lines.push(odom(number, &fields)?),
            Some(&"FLASER") => self.lines.push(laser(number, "FLASER", 0, &fields)?),
            Some(&"RLASER") => self.lines.push(laser(number, "RLASER", 1, &fields)?),
            Some(&"PARAM") => self.param(&fields),
            Some(&"ROBOTLASER1" | &"RAWLASER1") => {
                self.later_format.get_or_insert(number);
            }
            Some(word) if is_keyword(word) => {}
            Some(word) => return Err(Flaw::NoKeyword { start: shown(word) }),
        }
        Ok(())
    }

    /// Unknown parameters are ignored.
    fn param(&mut self, fields: &[&str]) {
        let (Some(name), Some(value)) = (fields.get(1), fields.get(2)) else { return };
        let Some(value) = value.parse::<f64>().ok().filter(|value| value.abs() < FARTHEST_M) else { return };
        match *name {
            "robot_frontlaser_offset" => self.front_offset_m = value,
            "robot_rearlaser_offset" => self.rear_offset_m = value,
            "robot_front_laser_max" if value > 0.0 => self.range_max_m = Some(value),
            _ => {}
        }
    }

    /// The same, without scans whose number of beams differs from most scans of their laser.
    pub(super) fn with_usual_beams(mut self, complaints: &mut Complaints) -> Self {
        self.beams = [0, 1].map(|laser| usual(self.scans(laser).map(|scan| scan.ranges_m.len())));
        let (beams, mut unusable) = (self.beams, 0);
        self.lines.retain(|line| {
            let Some(scan) = &line.scan else { return true };
            let (found, expected) = (scan.ranges_m.len(), beams[scan.laser]);
            if found != expected {
                complaints.add(line.number, Flaw::Beams { expected, found });
                unusable += usize::from(scan.laser == 0);
            }
            found == expected
        });
        self.unusable += unusable;
        for line in &self.lines {
            let ranges_m = line.scan.iter().flat_map(|scan| &scan.ranges_m);
            match ranges_m.filter(|range_m| range_m.is_nan()).count() {
                0 => {}
                count => complaints.add(line.number, Flaw::Ranges { count }),
            }
        }
        self
    }

    /// The same, without pure odometry lines if these use another frame than the odometry of scans: some programs that
    /// correct logs correct only one of the two.
    pub(super) fn in_one_frame(mut self, complaints: &mut Complaints) -> Self {
        let mut apart_m = Vec::new();
        let mut latest: Option<&LogLine> = None;
        for line in &self.lines {
            if let (Some(odom), Some(_)) = (latest.take(), &line.scan) {
                let apart = line.odometry.translation.vector - odom.odometry.translation.vector;
                apart_m.push((apart.norm(), odom.number));
            }
            latest = Some(line).filter(|line| line.scan.is_none());
        }
        apart_m.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let usual = apart_m.get(apart_m.len() / 2).copied();
        if let Some((by_m, number)) = usual.filter(|(by_m, _)| *by_m > SAME_FRAME_M) {
            complaints.add(number, Flaw::OtherFrame { by_m });
            self.lines.retain(|line| line.scan.is_some());
        }
        self
    }

    /// # Errors
    /// [`RecordingError::Unusable`] if more than this share of the front laser's scans is unusable.
    pub(super) fn check(&self, most_unusable: f64, complaints: &Complaints) -> Result<(), RecordingError> {
        let (unusable, scans) = (self.unusable, self.unusable + self.front_scans());
        if (unusable as f64) < most_unusable * scans as f64 {
            return Ok(());
        }
        Err(RecordingError::Unusable { unusable, scans, complaints: complaints.clone().into_sorted() })
    }

    pub(super) fn scans(&self, laser: usize) -> impl Iterator<Item = &Scan> {
        self.lines.iter().filter_map(|line| line.scan.as_ref()).filter(move |scan| scan.laser == laser)
    }

    fn front_scans(&self) -> usize {
        self.scans(0).count()
    }
}

/// The beginning of an arbitrary text, for a message.
fn shown(text: &str) -> String {
    text.chars().take(24).map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// Whether it may begin a line of another kind: `SYNC`, `ROBOTLASER1`.
fn is_keyword(word: &str) -> bool {
    word.len() >= 2 && word.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
}

/// The most frequent number, the first of them if there are several; zero if there are no numbers.
fn usual(numbers: impl Iterator<Item = usize>) -> usize {
    let mut counts: Vec<(usize, usize)> = Vec::new();
    for number in numbers {
        match counts.iter_mut().find(|(known, _)| *known == number) {
            Some((_, count)) => *count += 1,
            None => counts.push((number, 1)),
        }
    }
    counts.iter().rev().max_by_key(|(_, count)| *count).map_or(0, |(number, _)| *number)
}

/// `ODOM x y theta tv rv accel time host logger_time`.
fn odom(number: usize, fields: &[&str]) -> Result<LogLine, Flaw> {
    has_fields("ODOM", fields, 10)?;
    let odometry = pose_at(fields, 1, ["x", "y", "theta"])?;
    let velocity = VelocityCommand { linear_mps: finite(fields, 4, "tv")?, angular_radps: finite(fields, 5, "rv")? };
    Ok(LogLine { number, clock_s: clock(fields, 7)?, odometry, velocity, corrected: None, scan: None })
}

/// `FLASER n r1 … rn x y theta odom_x odom_y odom_theta time host logger_time`, or the same with `RLASER`.
fn laser(number: usize, keyword: &'static str, laser: usize, fields: &[&str]) -> Result<LogLine, Flaw> {
    let count = fields.get(1).copied().unwrap_or_default();
    let beams = count.parse::<usize>().ok().filter(|beams| (1..=MOST_BEAMS).contains(beams));
    let beams = beams.ok_or_else(|| Flaw::Number { field: "the number of beams", text: shown(count) })?;
    has_fields(keyword, fields, beams + 11)?;
    let ranges_m = fields[2..2 + beams].iter().map(|field| range(field)).collect::<Result<_, _>>()?;
    let corrected = pose_at(fields, 2 + beams, ["x", "y", "theta"])?;
    let odometry = pose_at(fields, 5 + beams, ["odom_x", "odom_y", "odom_theta"])?;
    Ok(LogLine {
        number,
        clock_s: clock(fields, 8 + beams)?,
        odometry,
        velocity: VelocityCommand::STOP,
        corrected: (laser == 0).then_some(corrected),
        scan: Some(Scan { laser, ranges_m }),
    })
}

/// Some programs add their own fields. The position of the host's name shows that these come last and that no field is
/// missing before it.
fn has_fields(keyword: &'static str, fields: &[&str], expected: usize) -> Result<(), Flaw> {
    let found = fields.len();
    let is_in_place = || fields[expected - 2].parse::<f64>().is_err();
    if found == expected || (found > expected && is_in_place()) {
        Ok(())
    } else {
        Err(Flaw::Fields { keyword, expected, found })
    }
}

/// A range; NaN if it is impossible. A word is not a range at all.
fn range(field: &str) -> Result<f32, Flaw> {
    let range_m = field.parse::<f32>().map_err(|_| Flaw::Number { field: "a range", text: shown(field) })?;
    Ok(if range_m >= 0.0 { range_m } else { f32::NAN })
}

fn pose_at(fields: &[&str], first: usize, names: [&'static str; 3]) -> Result<Pose, Flaw> {
    let [x, y, theta] = [0, 1, 2].map(|index| finite(fields, first + index, names[index]));
    Ok(pose(x?, y?, theta?))
}

fn finite(fields: &[&str], index: usize, field: &'static str) -> Result<f64, Flaw> {
    let number = fields[index].parse::<f64>().ok().filter(|number| number.abs() < FARTHEST_M);
    number.ok_or_else(|| Flaw::Number { field, text: shown(fields[index]) })
}

fn clock(fields: &[&str], index: usize) -> Result<f64, Flaw> {
    let number = fields[index].parse::<f64>().ok().filter(|number| number.abs() < 1e12);
    number.ok_or_else(|| Flaw::Number { field: "time", text: shown(fields[index]) })
}
