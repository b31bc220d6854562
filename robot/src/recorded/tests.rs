use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use maps::heading;
use proptest::prelude::*;

use super::*;
use crate::Streams;

const BEAMS: usize = 6;

/// A drive along x, one scan per second with odometry in between, from epoch time on.
fn log() -> Vec<String> {
    let mut log = LogWriter::new("host");
    log.param("robot_frontlaser_offset", -0.04);
    log.param("robot_front_laser_max", 30.0);
    for second in 0..10 {
        let at = |share: f64| pose(second as f64 + share, 0.0, 0.1);
        let time = Duration::from_secs(1_000_000_000 + second);
        let ranges_m = (0..BEAMS).map(|beam| 1.0 + beam as f32 + 0.1 * second as f32).collect();
        log.scan(&LaserScan { time, laser: 0, ranges_m }, &at(0.0), &pose(5.0, second as f64, 1.6));
        let time = time + Duration::from_millis(500);
        log.odometry(&Odometry { time, pose: at(0.5), linear_mps: 0.4, angular_radps: 0.0 });
    }
    log.into_text().lines().map(str::to_owned).collect()
}

fn text(lines: &[String]) -> Vec<u8> {
    (lines.join("\n") + "\n").into_bytes()
}

fn read(lines: &[String]) -> Recording {
    Recording::read(&text(lines)).unwrap()
}

fn gzipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// The complaints after a line was changed, and the number of usable records.
fn complaints_after(line: usize, change: impl Fn(&str) -> String) -> (Vec<String>, usize) {
    let mut lines = log();
    lines[line - 1] = change(&lines[line - 1]);
    let recording = read(&lines);
    (recording.complaints().iter().map(ToString::to_string).collect(), recording.records().len())
}

#[test]
fn a_log_is_read_as_it_was_written() {
    let recording = read(&log());
    assert_eq!(recording.complaints(), []);
    let laser = &recording.model().lasers[0];
    assert_eq!((laser.beams, laser.range_max_m, laser.period), (BEAMS, 30.0, Duration::from_secs(1)));
    assert!((laser.mount.translation.x + 0.04).abs() < 1e-12);
    assert!((laser.beam_angle_rad(3)).abs() < 1e-12, "half of an even number of beams lie to the right");
    assert_eq!(recording.records().len(), 20);
    let last = &recording.records()[18];
    assert_eq!((last.line, last.time), (21, Duration::from_secs(9)));
    assert!((last.odometry.translation.x - 9.0).abs() < 1e-9);
    let corrected = last.corrected.unwrap();
    assert!((corrected.translation.y - 9.0).abs() < 1e-9 && (heading(&corrected) - 1.6).abs() < 1e-9);
    assert!((last.scan.as_ref().unwrap().ranges_m[0] - 1.9).abs() < 1e-6);
}

#[test]
fn an_odd_number_of_beams_has_one_at_either_end() {
    let mut log = LogWriter::new("host");
    let scan = LaserScan { time: Duration::ZERO, laser: 0, ranges_m: vec![1.0; 181] };
    log.scan(&scan, &pose(0.0, 0.0, 0.0), &pose(0.0, 0.0, 0.0));
    log.scan(&LaserScan { laser: 1, ..scan }, &pose(0.0, 0.0, 0.0), &pose(0.0, 0.0, 0.0));
    let recording = Recording::read(log.into_text().as_bytes()).unwrap();
    let [front, rear] = &recording.model().lasers[..] else { panic!("two lasers") };
    assert!((front.angle_increment_rad - 1_f64.to_radians()).abs() < 1e-12);
    assert!((front.beam_angle_rad(180) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!((heading(&rear.mount).abs() - std::f64::consts::PI).abs() < 1e-9);
    assert_eq!(recording.corrected_scans().count(), 1, "only the front laser's poses are the robot's");
}

#[test]
fn the_range_that_stands_for_no_hit_is_detected() {
    let mut log = LogWriter::new("host");
    for second in 0..30 {
        let ranges_m = vec![2.0 + 0.01 * second as f32, 8.191, 3.0];
        let scan = LaserScan { time: Duration::from_secs(second), laser: 0, ranges_m };
        log.scan(&scan, &pose(0.0, 0.0, 0.0), &pose(0.0, 0.0, 0.0));
    }
    let recording = Recording::read(log.into_text().as_bytes()).unwrap();
    assert!((recording.model().lasers[0].range_max_m - 8.191).abs() < 1e-6);
    assert_eq!(recording.records()[0].scan.as_ref().unwrap().ranges_m[1], f32::INFINITY);
}

#[test]
fn a_recorded_robot_senses_what_was_recorded_and_ignores_commands() {
    let recording = Arc::new(read(&log()));
    let errors = || OdometryErrors::new(0.1, 0.0, Streams::new(1).stream("odometry"));
    let mut robot = RecordedRobot::new(Arc::clone(&recording), errors());
    let (mut readings, mut advanced) = (Vec::new(), 0);
    while robot.advance().is_some() {
        robot.drive(VelocityCommand { linear_mps: 9.0, angular_radps: 9.0 });
        robot.read(&mut readings);
        advanced += 1;
    }
    assert_eq!((advanced, readings.len()), (20, 30));
    assert!(readings.windows(2).all(|pair| pair[0].time() <= pair[1].time()));
    let Reading::Odometry(last) = readings.last().unwrap() else { panic!("the last line is odometry") };
    assert!((last.pose.translation.x - 9.5 * 1.1).abs() < 1e-9, "{}", last.pose);
    let mut late = RecordedRobot::new(recording, errors()).from_line(21);
    assert_eq!(late.advance().map(|record| record.line), Some(21));
}

#[test]
fn gzipped_logs_are_equivalent_and_truncated_ones_are_used_up_to_their_end() {
    let plain = text(&log());
    let packed = gzipped(&plain);
    assert_eq!(Recording::read(&packed).unwrap(), Recording::read(&plain).unwrap());
    let broken = Recording::read(&packed[..packed.len() - 20]).unwrap();
    assert!(broken.records().len() < 20 && !broken.records().is_empty());
    assert_eq!(broken.complaints()[0].flaw, Flaw::CompressionBreaksOff);
    let mut damaged = packed;
    let checksum = damaged.len() - 6;
    damaged[checksum] ^= 0xff;
    assert!(matches!(Recording::read(&damaged), Err(RecordingError::Damaged { line: 23, .. })));
}

#[test]
fn a_truncated_log_is_used_up_to_its_end() {
    let mut bytes = text(&log());
    bytes.truncate(bytes.len() - 30);
    let recording = Recording::read(&bytes).unwrap();
    assert_eq!(recording.records().len(), 19);
    assert_eq!(
        recording.complaints()[0].to_string(),
        "line 22: the log is truncated within this line; only the lines before it are used"
    );
}

#[test]
fn wrong_lines_are_left_out_and_named() {
    let (complaints, left) = complaints_after(5, |line| line.replace("FLASER 6", "FLASER 7"));
    assert_eq!(complaints, ["line 5: this FLASER should have 18 fields, but has 17; left out"]);
    assert_eq!(left, 19);
    let (complaints, left) = complaints_after(5, |line| line.replace("FLASER 6", "FLASER 7 1.0"));
    assert_eq!(
        complaints,
        ["line 5: this scan has 7 beams, but most have 6; left out, since its beams may have other angles"]
    );
    assert_eq!(left, 19);
    let (complaints, _) = complaints_after(5, |line| line.replace("FLASER 6", "FLASER many"));
    assert_eq!(complaints, ["line 5: the number of beams should be a number, but is `many`; left out"]);
    let (complaints, _) = complaints_after(6, |line| line.replace("ODOM 1.5", "ODOM NaN"));
    assert_eq!(complaints, ["line 6: x should be a number, but is `NaN`; left out"]);
    let (complaints, _) = complaints_after(6, |_| "\u{1b}[2J".to_owned());
    assert_eq!(complaints, ["line 6: no line of a log begins with `\u{fffd}[2J`; left out"], "no control characters");
    let (complaints, _) = complaints_after(6, |_| "what is this".to_owned());
    assert_eq!(complaints, ["line 6: no line of a log begins with `what`; left out"]);
}

#[test]
fn impossible_ranges_are_not_used() {
    let mut lines = log();
    lines[4] = lines[4].replace(" 2.1 ", " NaN ").replace(" 3.1 ", " -3.1 ").replace(" 4.1 ", " 40.0 ");
    let recording = read(&lines);
    assert_eq!(
        recording.complaints()[0].to_string(),
        "line 5: 2 ranges are negative or not numbers; these beams are not used"
    );
    let ranges_m = &recording.records()[2].scan.as_ref().unwrap().ranges_m;
    assert!(ranges_m[1].is_nan() && ranges_m[2].is_nan() && ranges_m[3] == f32::INFINITY);
}

#[test]
fn clocks_that_go_back_do_not_turn_back_time() {
    let reset = |line: &str, clock: &str| {
        let fields: Vec<&str> = line.split(' ').collect();
        let time = fields.len() - 3;
        fields[..time].iter().chain(&[clock, "host", clock]).copied().collect::<Vec<_>>().join(" ")
    };
    let (complaints, left) = complaints_after(7, |line| reset(line, "1000000000.2"));
    assert_eq!(complaints, ["line 7: the clock goes back by 1.300 s; lines are used in the order of the file"]);
    assert_eq!(left, 20);
    // Odometry without a clock, as programs that correct logs insert it.
    let (complaints, left) = complaints_after(8, |line| reset(line, "0"));
    assert!(complaints[0].starts_with("line 8: the clock of this odometry is 1000000002"), "{complaints:?}");
    assert_eq!(left, 19);
    // A clock that is ahead must not pull the others along.
    let (complaints, left) = complaints_after(8, |line| reset(line, "1000000900.0"));
    assert!(complaints.len() == 1 && complaints[0].contains("ahead of the lines that follow"), "{complaints:?}");
    assert_eq!(left, 20);
    // A clock that was set back by 500 s.
    let mut lines = log();
    for line in &mut lines[8..] {
        *line = line.replace("10000000", "9999995");
    }
    let recording = read(&lines);
    assert!(matches!(recording.complaints()[0], Complaint { line: 9, flaw: Flaw::ClockSetBack { .. }, more: 0 }));
    let times: Vec<Duration> = recording.records().iter().map(|record| record.time).collect();
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]) && times[19] > Duration::from_secs(8), "{times:?}");
}

#[test]
fn the_same_log_in_a_different_format_gives_the_same_result() {
    let lines = log();
    let expected = read(&lines);
    let exponent = |field: &str| match field.parse::<f64>() {
        Ok(number) if field.contains('.') => format!("{number:e}"),
        _ => field.to_owned(),
    };
    let otherwise = [
        lines.join("\r\n") + "\r\n",
        format!("\u{feff}{}\n", lines.join("\n")),
        lines.join("\n").replace(' ', "\t") + "\n",
        lines.iter().map(|line| line.split(' ').map(exponent).collect::<Vec<_>>().join("  ") + "\n").collect(),
    ];
    for text in otherwise {
        let recording = Recording::read(text.as_bytes()).unwrap();
        assert_eq!(recording.complaints(), []);
        assert_eq!(recording.records(), expected.records(), "{text}");
        assert_eq!(Recording::read(&gzipped(text.as_bytes())).unwrap(), recording);
    }
}

#[test]
fn other_kinds_of_lines_are_ignored_and_later_formats_are_refused() {
    let robotlaser =
        "ROBOTLASER1 0 -1.570796 3.141593 1.570796 30.0 0.01 0 3 1.0 2.0 3.0 0 1 2 0.1 1 2 0.1 0 0 1 1 1 5.0 h 5.0";
    let others = ["# a comment", "", "SYNC tag", "TRUEPOS 0 0 0 0 0 0 1 h 1", "NEFF 3.0", robotlaser];
    let mut lines = log();
    lines.splice(4..4, others.map(str::to_owned));
    let recording = read(&lines);
    assert_eq!((recording.records().len(), recording.complaints().len()), (20, 0));
    lines.retain(|line| !line.starts_with("FLASER"));
    let error = Recording::read(&text(&lines)).unwrap_err().to_string();
    assert!(error.starts_with("line 9: ") && error.contains("ROBOTLASER"), "{error}");
}

#[test]
fn odometry_of_another_frame_is_left_out() {
    let mut lines = log();
    for line in lines.iter_mut().filter(|line| line.starts_with("ODOM")) {
        *line = line.replacen("ODOM ", "ODOM 70", 1);
    }
    let recording = read(&lines);
    assert_eq!(recording.records().len(), 10);
    assert!(matches!(recording.complaints(), [Complaint { flaw: Flaw::OtherFrame { by_m }, .. }] if *by_m > 600.0));
}

#[test]
fn a_file_that_is_not_a_log_is_refused() {
    for bytes in [&b""[..], b"\n\n", b"# nothing\nPARAM a b\n", b"hello\nworld\n", &[0x1f, 0x8b, 0, 0], &[0xff; 500]] {
        assert!(Recording::read(bytes).is_err(), "{bytes:?}");
    }
    let mut lines = log();
    for line in lines.iter_mut().filter(|line| line.starts_with("FLASER")) {
        line.truncate(line.rfind(' ').unwrap());
    }
    let error = Recording::read(&text(&lines)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "10 of 10 scans cannot be used, so the others are not used either; \
         line 3: this FLASER should have 17 fields, but has 16"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Whatever happens to a log's bytes: no panic, time never decreases, and every record is finite.
    #[test]
    fn damaged_logs_are_read_or_refused(
        spoilt in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(b"0 -.nNaeEF\n\x00\xff9".to_vec())), 0..40),
        cut in any::<prop::sample::Index>(),
        packed in any::<bool>(),
    ) {
        let mut bytes = text(&log());
        if packed {
            bytes = gzipped(&bytes);
        }
        for (index, byte) in spoilt {
            let at = index.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate(bytes.len() - cut.index(bytes.len()) / 4);
        if let Ok(recording) = Recording::read(&bytes) {
            let records = recording.records();
            prop_assert!(records.windows(2).all(|pair| pair[0].time <= pair[1].time && pair[0].line < pair[1].line));
            for record in records {
                let finite = |pose: &Pose| pose.translation.vector.iter().all(|c| c.is_finite()) && heading(pose).is_finite();
                prop_assert!(finite(&record.odometry) && record.corrected.as_ref().is_none_or(finite));
                prop_assert!(record.scan.as_ref().is_none_or(|scan| scan.ranges_m.len() == recording.model().lasers[scan.laser].beams));
            }
        }
    }
}

#[test]
fn the_log_has_the_laser_pose_and_the_record_the_robot_pose() {
    let line = "FLASER 2 1.0 1.0 3.0 4.0 1.5707963267948966 0 0 0 1.0 host 1.0\n";
    let log = format!("PARAM robot_frontlaser_offset 0.5 host 0\n{line}");
    let recording = Recording::read(log.as_bytes()).unwrap();
    let (record, scan, robot) = recording.corrected_scans().next().unwrap();
    assert!((robot.translation.vector - nalgebra::vector![3.0, 3.5]).norm() < 1e-9, "{robot}");
    let laser = robot * recording.model().lasers[scan.laser].mount;
    assert!((laser.translation.vector - nalgebra::vector![3.0, 4.0]).norm() < 1e-9, "{laser}");
    assert_eq!(record.odometry.translation.vector, nalgebra::vector![0.0, 0.0]);
}

/// The distance between the odometry of the first record and the last one, in meters.
fn driven_m(recording: &Recording) -> f64 {
    let [first, .., last] = recording.records() else { panic!("two records at least") };
    (last.odometry.translation.vector - first.odometry.translation.vector).norm()
}

#[test]
fn odometry_that_jumps_continues_from_its_last_position() {
    let usual_m = driven_m(&read(&log()));
    // One line that is elsewhere, and all lines from one on.
    let elsewhere = |line: &mut String| *line = line.replacen("ODOM ", "ODOM 900", 1);
    let mut lines = log();
    elsewhere(&mut lines[9]);
    let recording = read(&lines);
    assert!((driven_m(&recording) - usual_m).abs() <= 1.0 + 1e-9, "{} m", driven_m(&recording));
    let text: Vec<String> = recording.complaints().iter().map(ToString::to_string).collect();
    assert!(text.len() == 1 && text[0].contains("line 10: odometry jumps by"), "{text:?}");
    let steps_m = recording
        .records()
        .windows(2)
        .map(|pair| (pair[1].odometry.translation.vector - pair[0].odometry.translation.vector).norm());
    assert!(steps_m.fold(0.0, f64::max) < 1.0);
}

#[test]
fn a_stray_corrected_pose_is_left_out_but_a_kidnapped_robot_is_not() {
    let moved = |lines: &mut [String], by_m: f64| {
        for line in lines.iter_mut().filter(|line| line.starts_with("FLASER")) {
            let mut fields: Vec<String> = line.split(' ').map(str::to_owned).collect();
            let x: f64 = fields[2 + BEAMS].parse().unwrap();
            fields[2 + BEAMS] = (x + by_m).to_string();
            *line = fields.join(" ");
        }
    };
    let mut lines = log();
    moved(&mut lines[8..9], 9e5);
    let recording = read(&lines);
    assert_eq!(recording.corrected_scans().count(), 9);
    let complaint = recording.complaints()[0].to_string();
    assert!(
        complaint.starts_with("line 9: the corrected pose is 9000") && complaint.ends_with("not used"),
        "{complaint}"
    );
    let mut carried = log();
    moved(&mut carried[8..], 40.0);
    assert_eq!((read(&carried).corrected_scans().count(), read(&carried).complaints().len()), (10, 0));
}

/// The log with a different clock on one line.
fn with_clock(lines: &mut [String], line: usize, clock_s: &str) {
    let mut fields: Vec<&str> = lines[line - 1].split(' ').collect();
    let place = fields.len() - 3;
    fields[place] = clock_s;
    lines[line - 1] = fields.join(" ");
}

#[test]
fn a_clock_ahead_of_all_others_does_not_affect_them() {
    let mut lines = log();
    with_clock(&mut lines, 8, "1000000600.0");
    let recording = read(&lines);
    assert_eq!(recording.records().len(), 20, "none is left out");
    let complaint = recording.complaints()[0].to_string();
    assert!(
        complaint.starts_with("line 8: the clock is") && complaint.ends_with("time continues as before"),
        "{complaint}"
    );
    assert!(recording.records()[19].time < Duration::from_secs(11));
}

#[test]
fn a_clock_set_forward_by_years_continues_from_its_last_time() {
    let mut lines = log();
    for line in 10..=22 {
        let clock = 4_000_000_000.0 + line as f64;
        with_clock(&mut lines, line, &clock.to_string());
    }
    let recording = read(&lines);
    assert_eq!(recording.complaints().len(), 1, "{:?}", recording.complaints());
    assert!(recording.complaints()[0].to_string().contains("the clock was set forward by"));
    assert!(recording.records()[19].time < Duration::from_secs(30));
}

#[test]
fn extra_fields_are_ignored_at_the_end_and_refused_before_it() {
    let (complaints, records) = complaints_after(3, |line| format!("{line} 0 0"));
    assert_eq!((complaints.len(), records), (0, 20));
    let (complaints, records) =
        complaints_after(3, |line| line.replacen(' ', " 6 1.5 ", 1).replacen("6 1.5 6", "6 1.5", 1));
    assert_eq!((complaints.len(), records), (1, 19), "{complaints:?}");
    assert!(complaints[0].contains("should have"), "{complaints:?}");
}
