//! The dataset: one Parquet file with one row per run, in the order of the runs.
//!
//! | column | type | meaning |
//! |---|---|---|
//! | `k`, `seed` | integer | the run's number and its root seed |
//! | `param.KEY` | integer, real, boolean or text | the value of each parameter |
//! | `outcome` | text | `as_expected`, `not_as_expected` or `failed` |
//! | `failure` | text | why the run failed (then all following columns are null); null if it did not |
//! | `ended` | text | why the run ended: `arrival`, `violation`, `settled`, `time_limit` or `schedule` |
//! | `sim_time_s` | real | simulated duration of the run |
//! | `ticks` | integer | how many ticks were generated |
//! | `arrived_s` | real | when the robot first came to rest at a place where the scenario stops |
//! | `battery_minimum_pct`, `battery_final_pct` | real | the battery's charge |
//! | `distance_m` | real | how far the robot drove |
//! | `collisions` | integer | contacts of the robot with anything else |
//! | `localization_rmse_m`, `localization_max_m` | real | error of the estimated position |
//! | `faults` | integer | how many faults took effect |
//! | `fault_onset_s` | real | when the first fault took effect |
//! | `trace_hash` | text | BLAKE3 hash of the trace |
//! | `PROPERTY.verdict` | text | `satisfied`, `violated` or `inconclusive` |
//! | `PROPERTY.tick`, `PROPERTY.time_s` | integer, real | when it was violated |
//! | `PROPERTY.latency_s` | real | time from the first fault's onset to the violation |
//! | `PROPERTY.violations` | integer | how often it was violated; for good counts once |
//! | `PROPERTY.violated_s` | real | how long in all, if it can be violated again |
//! | `PROPERTY.vacuous` | boolean | whether it was satisfied although a condition in it never occurred |
//!
//! Missing values are null. A dataset depends only on the records of its runs: the same campaign gives the same bytes
//! on any number of cores, resumed or not, sharded or not.

use std::io;
use std::path::Path;
use std::sync::Arc;

use diagnostics::Unfinished;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::journal::{Layout, ParameterKind};
use super::{ParameterValue, RunFacts, RunRecord};
use crate::Error;

/// This many runs are held in memory and written as one row group.
const ROW_GROUP: usize = 2_000;

/// A dataset that is being written.
pub(super) struct DatasetWriter {
    writer: SerializedFileWriter<Unfinished>,
    layout: Layout,
    rows: Vec<RunRecord>,
}

impl DatasetWriter {
    pub(super) fn begin(path: &Path, layout: &Layout) -> Result<Self, Error> {
        let failed = |source| Error::unwritten(path, source);
        let fields: Result<Vec<_>, ParquetError> =
            columns(layout, &[]).iter().map(|(name, cells)| cells.field(name).map(Arc::new)).collect();
        let schema = fields.and_then(|fields| Type::group_type_builder("campaign").with_fields(fields).build());
        let schema = schema.map_err(|error| failed(io_error(error)))?;
        let creator = format!("steward {}", env!("CARGO_PKG_VERSION"));
        let provenance = serde_json::to_string(&layout.provenance).expect("it is always JSON");
        let about = vec![KeyValue::new("steward.provenance".to_owned(), provenance)];
        let properties =
            WriterProperties::builder().set_created_by(creator).set_key_value_metadata(Some(about)).build();
        let file = Unfinished::create(path)?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties));
        let writer = writer.map_err(|error| failed(io_error(error)))?;
        Ok(Self { writer, layout: layout.clone(), rows: Vec::new() })
    }

    pub(super) fn push(&mut self, record: RunRecord) -> io::Result<()> {
        self.rows.push(record);
        if self.rows.len() == ROW_GROUP { self.flush() } else { Ok(()) }
    }

    /// Writes the remaining rows and returns the file.
    pub(super) fn finish(mut self) -> io::Result<Unfinished> {
        if !self.rows.is_empty() {
            self.flush()?;
        }
        self.writer.into_inner().map_err(io_error)
    }

    fn flush(&mut self) -> io::Result<()> {
        let mut group = self.writer.next_row_group().map_err(io_error)?;
        for (_, cells) in columns(&self.layout, &self.rows) {
            cells.write(&mut group).map_err(io_error)?;
        }
        group.close().map_err(io_error)?;
        self.rows.clear();
        Ok(())
    }
}

/// The operating system's error, if there was one.
fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => match source.downcast::<io::Error>() {
            Ok(source) => *source,
            Err(source) => io::Error::other(source),
        },
        error => io::Error::other(error),
    }
}

/// A column's values; null where there are none.
enum Cells {
    Integers(Vec<Option<i64>>),
    Numbers(Vec<Option<f64>>),
    Booleans(Vec<Option<bool>>),
    Texts(Vec<Option<String>>),
}

/// All columns of these runs, in order.
fn columns(layout: &Layout, rows: &[RunRecord]) -> Vec<(String, Cells)> {
    // The schema comes from the columns of no rows, so it cannot differ from the columns that are written.
    let mut columns = Columns { rows, all: Vec::new() };
    columns.integer("k", |row| Some(row.k as i64));
    columns.integer("seed", |row| Some(row.seed as i64));
    for (place, parameter) in layout.parameters.iter().enumerate() {
        columns.all.push((format!("param.{}", parameter.key), parameter_cells(parameter.kind, place, rows)));
    }
    columns.text("outcome", |row| Some(row.outcome.name().to_owned()));
    columns.text("failure", |row| row.failure.clone());
    columns.text("ended", |row| Some(row.facts.as_ref()?.ended.clone()));
    columns.fact("sim_time_s", |facts| Some(facts.sim_time_s));
    columns.count("ticks", |facts| facts.ticks);
    columns.fact("arrived_s", |facts| facts.arrived_s);
    columns.fact("battery_minimum_pct", |facts| facts.battery_minimum_pct);
    columns.fact("battery_final_pct", |facts| facts.battery_final_pct);
    columns.fact("distance_m", |facts| facts.distance_m);
    columns.integer("collisions", |row| Some(row.facts.as_ref()?.collisions? as i64));
    columns.fact("localization_rmse_m", |facts| facts.localization_rmse_m);
    columns.fact("localization_max_m", |facts| facts.localization_max_m);
    columns.count("faults", |facts| facts.faults);
    columns.fact("fault_onset_s", |facts| facts.fault_onset_s);
    columns.text("trace_hash", |row| Some(row.facts.as_ref()?.trace_hash.clone()));
    for (place, name) in layout.properties.iter().enumerate() {
        let monitor = |row: &RunRecord| row.facts.as_ref()?.monitors.get(place).cloned();
        columns.text(&format!("{name}.verdict"), |row| Some(monitor(row)?.verdict.name().to_owned()));
        columns.integer(&format!("{name}.tick"), |row| Some(monitor(row)?.tick? as i64));
        columns.number(&format!("{name}.time_s"), |row| monitor(row)?.time_s);
        columns.number(&format!("{name}.latency_s"), |row| monitor(row)?.latency_s);
        columns.integer(&format!("{name}.violations"), |row| Some(monitor(row)?.violations as i64));
        columns.number(&format!("{name}.violated_s"), |row| monitor(row)?.violated_s);
        columns.boolean(&format!("{name}.vacuous"), |row| Some(monitor(row)?.vacuous));
    }
    columns.all
}

/// The columns of these runs so far.
struct Columns<'r> {
    rows: &'r [RunRecord],
    all: Vec<(String, Cells)>,
}

impl Columns<'_> {
    fn push(&mut self, name: &str, cells: Cells) {
        self.all.push((name.to_owned(), cells));
    }

    fn text(&mut self, name: &str, of: impl Fn(&RunRecord) -> Option<String>) {
        self.push(name, Cells::Texts(self.rows.iter().map(of).collect()));
    }

    fn integer(&mut self, name: &str, of: impl Fn(&RunRecord) -> Option<i64>) {
        self.push(name, Cells::Integers(self.rows.iter().map(of).collect()));
    }

    fn number(&mut self, name: &str, of: impl Fn(&RunRecord) -> Option<f64>) {
        self.push(name, Cells::Numbers(self.rows.iter().map(of).collect()));
    }

    fn boolean(&mut self, name: &str, of: impl Fn(&RunRecord) -> Option<bool>) {
        self.push(name, Cells::Booleans(self.rows.iter().map(of).collect()));
    }

    /// The column of a count in each run that did not fail.
    fn count(&mut self, name: &str, of: fn(&RunFacts) -> u64) {
        self.integer(name, |row| row.facts.as_ref().map(|facts| of(facts) as i64));
    }

    /// The column of a measurement in each run that did not fail.
    fn fact(&mut self, name: &str, of: fn(&RunFacts) -> Option<f64>) {
        self.number(name, |row| row.facts.as_ref().and_then(of));
    }
}

/// The column of a parameter's values.
fn parameter_cells(kind: ParameterKind, place: usize, rows: &[RunRecord]) -> Cells {
    let values = rows.iter().map(|row| row.values.get(place));
    match kind {
        ParameterKind::Integer => {
            let integer = |value: Option<&ParameterValue>| {
                if let Some(ParameterValue::Integer(value)) = value { Some(*value) } else { None }
            };
            Cells::Integers(values.map(integer).collect())
        }
        // A list such as `[1, 2.5]` is of numbers, though TOML reads its first value as an integer.
        ParameterKind::Number => Cells::Numbers(values.map(|value| value?.number()).collect()),
        ParameterKind::Boolean => {
            let boolean = |value: Option<&ParameterValue>| {
                if let Some(ParameterValue::Boolean(value)) = value { Some(*value) } else { None }
            };
            Cells::Booleans(values.map(boolean).collect())
        }
        ParameterKind::Text => {
            let text = |value: &ParameterValue| match value {
                ParameterValue::Text(text) => text.clone(),
                other => other.to_string(),
            };
            Cells::Texts(values.map(|value| value.map(text)).collect())
        }
    }
}

impl Cells {
    fn field(&self, name: &str) -> Result<Type, ParquetError> {
        let (physical, logical) = match self {
            Self::Integers(_) => (Physical::INT64, None),
            Self::Numbers(_) => (Physical::DOUBLE, None),
            Self::Booleans(_) => (Physical::BOOLEAN, None),
            Self::Texts(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
        field.with_logical_type(logical).build()
    }

    fn write(self, group: &mut SerializedRowGroupWriter<'_, Unfinished>) -> Result<(), ParquetError> {
        match self {
            Self::Integers(cells) => write_column::<Int64Type>(group, cells),
            Self::Numbers(cells) => write_column::<DoubleType>(group, cells),
            Self::Booleans(cells) => write_column::<BoolType>(group, cells),
            Self::Texts(cells) => {
                let bytes = |text: String| ByteArray::from(text.into_bytes());
                write_column::<ByteArrayType>(group, cells.into_iter().map(|cell| cell.map(bytes)).collect())
            }
        }
    }
}

fn write_column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Unfinished>,
    cells: Vec<Option<T::T>>,
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<T::T> = cells.into_iter().flatten().collect();
    let missing = || ParquetError::General("the schema has fewer columns than the data".into());
    let mut column = group.next_column()?.ok_or_else(missing)?;
    column.typed::<T>().write_batch(&values, Some(&levels), None)?;
    column.close()
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::super::journal::ParameterLayout;
    use super::super::{MonitorFacts, RunOutcome};
    use super::*;

    fn record(k: u64) -> RunRecord {
        let monitor = MonitorFacts {
            verdict: monitors::Outcome::Violated,
            tick: Some(k),
            time_s: Some(0.1),
            latency_s: None,
            violations: 3,
            violated_s: Some(1.5),
            vacuous: false,
        };
        let facts = RunFacts {
            ended: "time_limit".into(),
            sim_time_s: 1.0 / 3.0,
            ticks: 7,
            arrived_s: None,
            battery_minimum_pct: Some(20.5),
            battery_final_pct: Some(21.5),
            distance_m: Some(3.0),
            collisions: Some(2),
            localization_rmse_m: Some(0.01),
            localization_max_m: Some(0.02),
            faults: 1,
            fault_onset_s: Some(0.05),
            trace_hash: "ab".into(),
            monitors: vec![monitor],
        };
        let values = vec![
            ParameterValue::Integer(5),
            ParameterValue::Integer(2),
            ParameterValue::Boolean(true),
            ParameterValue::Text("über".into()),
        ];
        if k.is_multiple_of(2) {
            let outcome = RunOutcome::NotAsExpected;
            return RunRecord { k, seed: k + 1, values, outcome, unmet: Vec::new(), failure: None, facts: Some(facts) };
        }
        let failure = Some("panicked".to_owned());
        RunRecord { k, seed: k + 1, values, outcome: RunOutcome::Failed, unmet: Vec::new(), failure, facts: None }
    }

    fn provenance() -> recording::Provenance {
        let inputs = vec![recording::InputFile::shipped(Path::new("scenarios/errand.toml"), "")];
        recording::Provenance {
            commit: Some("abc".into()),
            scenario: "errand".into(),
            set: vec!["robot.radius_m=0.3".into()],
            inputs,
        }
    }

    fn written(path: &Path, runs: u64) -> Vec<u8> {
        let kinds = [ParameterKind::Integer, ParameterKind::Number, ParameterKind::Boolean, ParameterKind::Text];
        let parameter = |(place, kind)| ParameterLayout {
            key: format!("a.{place}"),
            kind,
            domain: String::new(),
            logarithmic: false,
            name: None,
            about: None,
        };
        let layout = Layout {
            campaign: "some.toml".into(),
            asked: None,
            scenario: "errand".into(),
            about: String::new(),
            provenance: provenance(),
            expects: true,
            measures: Vec::new(),
            model: None,
            of_roaml: false,
            parameters: kinds.into_iter().enumerate().map(parameter).collect(),
            properties: vec!["phi1".into()],
        };
        let mut dataset = DatasetWriter::begin(path, &layout).unwrap();
        (0..runs).for_each(|k| dataset.push(record(k)).unwrap());
        dataset.finish().unwrap().finish().unwrap();
        std::fs::read(path).unwrap()
    }

    #[test]
    fn a_dataset_with_several_row_groups_is_read_back_unchanged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("some.parquet");
        let runs = ROW_GROUP as u64 + 3;
        let last = ROW_GROUP + 2;
        assert_eq!(written(&path, runs), written(&path, runs), "the same bytes every time");
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        assert_eq!(reader.metadata().num_row_groups(), 2);
        let about = reader.metadata().file_metadata().key_value_metadata().unwrap();
        let told = about.iter().find(|about| about.key == "steward.provenance").unwrap().value.as_deref().unwrap();
        assert_eq!(serde_json::from_str::<recording::Provenance>(told).unwrap(), provenance());
        let schema = reader.metadata().file_metadata().schema_descr();
        let names: Vec<&str> = schema.columns().iter().map(|column| column.name()).collect();
        let cells =
            include_str!("dataset.rs").lines().filter_map(|line| line.strip_prefix("//! | `")?.split('|').next());
        let documented = cells.flat_map(|cell| cell.split('`').step_by(2)).filter(|name| !name.trim().is_empty());
        let documented: String = documented.map(|name| name.replace("PROPERTY", "phi1") + " ").collect();
        let documented = documented.replace("param.KEY", "param.a.0 param.a.1 param.a.2 param.a.3");
        assert_eq!(names.join(" "), documented.trim(), "the columns, and those in the table on top");
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len() as u64, runs);
        let cell = |row: usize, name: &str| {
            let (_, field) = rows[row].get_column_iter().find(|(column, _)| *column == name).unwrap();
            field.clone()
        };
        for (name, wanted) in [
            ("k", Field::Long(last as i64)),
            ("seed", Field::Long(last as i64 + 1)),
            ("param.a.0", Field::Long(5)),
            ("param.a.1", Field::Double(2.0)),
            ("param.a.2", Field::Bool(true)),
            ("param.a.3", Field::Str("über".into())),
            ("outcome", Field::Str("not_as_expected".into())),
            ("failure", Field::Null),
            ("sim_time_s", Field::Double(1.0 / 3.0)),
            ("arrived_s", Field::Null),
            ("collisions", Field::Long(2)),
            ("phi1.verdict", Field::Str("violated".into())),
            ("phi1.tick", Field::Long(last as i64)),
            ("phi1.latency_s", Field::Null),
            ("phi1.violations", Field::Long(3)),
            ("phi1.violated_s", Field::Double(1.5)),
            ("phi1.vacuous", Field::Bool(false)),
        ] {
            assert_eq!(cell(last, name), wanted, "{name}");
        }
        assert_eq!(cell(1, "failure"), Field::Str("panicked".into()));
        assert_eq!((cell(1, "sim_time_s"), cell(1, "phi1.verdict")), (Field::Null, Field::Null));
    }
}
