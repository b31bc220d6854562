//! The dataset: one Parquet file with a row for each run, in the order of the runs.
//!
//! | column | type | |
//! |---|---|---|
//! | `k`, `seed` | integer | the run's number and its root seed |
//! | `param.KEY` | integer, real, boolean or text | the value of each parameter |
//! | `outcome` | text | `as_expected`, `not_as_expected` or `failed` |
//! | `failure` | text | why the run failed; null otherwise, and then nothing below is |
//! | `sim_time_s`, `ticks` | real, integer | how long the run took |
//! | `arrived_s` | real | when the robot came to rest where the scenario stops |
//! | `battery_minimum_pct`, `battery_final_pct` | real | the battery's charge |
//! | `distance_m`, `collisions` | real, integer | how the robot fared |
//! | `localization_rmse_m`, `localization_max_m` | real | how well it knew where it was |
//! | `faults`, `fault_onset_s` | integer, real | how many faults took hold, and when the first did |
//! | `trace_hash` | text | BLAKE3 hash of the trace |
//! | `PROPERTY.verdict` | text | `satisfied`, `violated` or `inconclusive` |
//! | `PROPERTY.tick`, `PROPERTY.time_s` | integer, real | when it was violated |
//! | `PROPERTY.latency_s` | real | time from the first fault's onset to the violation |
//!
//! What does not exist is null. A dataset is a function of its runs' records: the same campaign gives the same bytes, on
//! any number of cores, resumed, sharded or neither.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::journal::{Layout, ParameterKind};
use super::{RunFacts, RunRecord, Value};
use crate::Error;

/// So many runs are held in memory and written as one row group.
const ROW_GROUP: usize = 10_000;

/// A dataset on its way to a file.
pub(super) struct DatasetWriter {
    writer: SerializedFileWriter<File>,
    layout: Layout,
    rows: Vec<RunRecord>,
}

impl DatasetWriter {
    /// Begins a dataset.
    pub(super) fn begin(path: &Path, layout: &Layout) -> Result<Self, Error> {
        let failed = |source| Error::Write { path: path.to_owned(), source };
        let fields: Result<Vec<_>, ParquetError> =
            columns(layout, &[]).iter().map(|(name, cells)| cells.field(name).map(Arc::new)).collect();
        let schema = fields.and_then(|fields| Type::group_type_builder("campaign").with_fields(fields).build());
        let schema = schema.map_err(|error| failed(io_error(error)))?;
        let creator = format!("steward {}", env!("CARGO_PKG_VERSION"));
        let properties = WriterProperties::builder().set_created_by(creator).build();
        let file = File::create(path).map_err(failed)?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties));
        let writer = writer.map_err(|error| failed(io_error(error)))?;
        Ok(Self { writer, layout: layout.clone(), rows: Vec::new() })
    }

    /// Adds a run.
    pub(super) fn push(&mut self, record: RunRecord) -> io::Result<()> {
        self.rows.push(record);
        if self.rows.len() == ROW_GROUP { self.flush() } else { Ok(()) }
    }

    /// Writes what is left.
    pub(super) fn finish(mut self) -> io::Result<()> {
        if !self.rows.is_empty() {
            self.flush()?;
        }
        let file = self.writer.into_inner().map_err(io_error)?;
        file.sync_all()
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

/// What the system said, where that is what was wrong.
fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => match source.downcast::<io::Error>() {
            Ok(source) => *source,
            Err(source) => io::Error::other(source),
        },
        error => io::Error::other(error),
    }
}

/// A column's values; null where there is none.
enum Cells {
    Integers(Vec<Option<i64>>),
    Numbers(Vec<Option<f64>>),
    Booleans(Vec<Option<bool>>),
    Texts(Vec<Option<String>>),
}

/// All columns of these runs, in their order.
fn columns(layout: &Layout, rows: &[RunRecord]) -> Vec<(String, Cells)> {
    let mut columns = vec![
        ("k".to_owned(), Cells::Integers(rows.iter().map(|row| Some(row.k as i64)).collect())),
        ("seed".to_owned(), Cells::Integers(rows.iter().map(|row| Some(row.seed as i64)).collect())),
    ];
    for (place, parameter) in layout.parameters.iter().enumerate() {
        columns.push((format!("param.{}", parameter.key), parameter_cells(parameter.kind, place, rows)));
    }
    columns.push(("outcome".to_owned(), texts(rows, |row| Some(row.outcome.name().to_owned()))));
    columns.push(("failure".to_owned(), texts(rows, |row| row.failure.clone())));
    let mut integer = |name: &str, of: fn(&RunFacts) -> Option<u64>| {
        let cell = |row: &RunRecord| row.facts.as_ref().and_then(of).map(|value| value as i64);
        columns.push((name.to_owned(), Cells::Integers(rows.iter().map(cell).collect())));
    };
    integer("ticks", |facts| Some(facts.ticks));
    integer("collisions", |facts| Some(facts.collisions));
    integer("faults", |facts| Some(facts.faults));
    let mut number = |name: &str, of: fn(&RunFacts) -> Option<f64>| {
        let cell = |row: &RunRecord| row.facts.as_ref().and_then(of);
        columns.push((name.to_owned(), Cells::Numbers(rows.iter().map(cell).collect())));
    };
    number("sim_time_s", |facts| Some(facts.sim_time_s));
    number("arrived_s", |facts| facts.arrived_s);
    number("battery_minimum_pct", |facts| Some(facts.battery_minimum_pct));
    number("battery_final_pct", |facts| Some(facts.battery_final_pct));
    number("distance_m", |facts| Some(facts.distance_m));
    number("localization_rmse_m", |facts| Some(facts.localization_rmse_m));
    number("localization_max_m", |facts| Some(facts.localization_max_m));
    number("fault_onset_s", |facts| facts.fault_onset_s);
    columns.push(("trace_hash".to_owned(), texts(rows, |row| Some(row.facts.as_ref()?.trace_hash.clone()))));
    for (place, name) in layout.properties.iter().enumerate() {
        let monitor = |row: &RunRecord| row.facts.as_ref()?.monitors.get(place).cloned();
        let monitors: Vec<_> = rows.iter().map(monitor).collect();
        let each = || monitors.iter().map(Option::as_ref);
        let ticks = each().map(|monitor| monitor?.tick.map(|tick| tick as i64)).collect();
        columns.push((format!("{name}.verdict"), Cells::Texts(each().map(|m| Some(m?.verdict.clone())).collect())));
        columns.push((format!("{name}.tick"), Cells::Integers(ticks)));
        columns.push((format!("{name}.time_s"), Cells::Numbers(each().map(|m| m?.time_s).collect())));
        columns.push((format!("{name}.latency_s"), Cells::Numbers(each().map(|m| m?.latency_s).collect())));
    }
    columns
}

fn texts(rows: &[RunRecord], of: impl Fn(&RunRecord) -> Option<String>) -> Cells {
    Cells::Texts(rows.iter().map(of).collect())
}

/// The values of a parameter.
fn parameter_cells(kind: ParameterKind, place: usize, rows: &[RunRecord]) -> Cells {
    let values = rows.iter().map(|row| row.values.get(place));
    match kind {
        ParameterKind::Integer => {
            let integer =
                |value: Option<&Value>| if let Some(Value::Integer(value)) = value { Some(*value) } else { None };
            Cells::Integers(values.map(integer).collect())
        }
        ParameterKind::Number => {
            let number = |value: Option<&Value>| match value {
                Some(Value::Number(value)) => Some(*value),
                Some(Value::Integer(value)) => Some(*value as f64),
                _ => None,
            };
            Cells::Numbers(values.map(number).collect())
        }
        ParameterKind::Boolean => {
            let boolean =
                |value: Option<&Value>| if let Some(Value::Boolean(value)) = value { Some(*value) } else { None };
            Cells::Booleans(values.map(boolean).collect())
        }
        ParameterKind::Text => {
            let text = |value: &Value| match value {
                Value::Text(text) => text.clone(),
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

    fn write(self, group: &mut SerializedRowGroupWriter<'_, File>) -> Result<(), ParquetError> {
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
    group: &mut SerializedRowGroupWriter<'_, File>,
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
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::super::journal::ParameterLayout;
    use super::super::{MonitorFacts, RunOutcome};
    use super::*;

    fn record(k: u64) -> RunRecord {
        let monitor = MonitorFacts { verdict: "violated".into(), tick: Some(k), time_s: Some(0.1), latency_s: None };
        let facts = RunFacts {
            sim_time_s: 1.0 / 3.0,
            ticks: 7,
            arrived_s: None,
            battery_minimum_pct: 20.5,
            battery_final_pct: 21.5,
            distance_m: 3.0,
            collisions: 2,
            localization_rmse_m: 0.01,
            localization_max_m: 0.02,
            faults: 1,
            fault_onset_s: Some(0.05),
            trace_hash: "ab".into(),
            monitors: vec![monitor],
        };
        let values = vec![Value::Integer(5), Value::Integer(2), Value::Boolean(true), Value::Text("über".into())];
        if k.is_multiple_of(2) {
            let outcome = RunOutcome::NotAsExpected;
            return RunRecord { k, seed: k + 1, values, outcome, failure: None, facts: Some(facts) };
        }
        let failure = Some("panicked".to_owned());
        RunRecord { k, seed: k + 1, values, outcome: RunOutcome::Failed, failure, facts: None }
    }

    fn written(path: &Path, runs: u64) -> Vec<u8> {
        let kinds = [ParameterKind::Integer, ParameterKind::Number, ParameterKind::Boolean, ParameterKind::Text];
        let parameter = |(place, kind)| ParameterLayout { key: format!("a.{place}"), kind };
        let layout = Layout {
            campaign: "some.toml".into(),
            scenario: "errand".into(),
            parameters: kinds.into_iter().enumerate().map(parameter).collect(),
            properties: vec!["phi1".into()],
        };
        let mut dataset = DatasetWriter::begin(path, &layout).unwrap();
        (0..runs).for_each(|k| dataset.push(record(k)).unwrap());
        dataset.finish().unwrap();
        std::fs::read(path).unwrap()
    }

    #[test]
    fn a_dataset_is_read_back_as_it_was_written_in_several_row_groups() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("some.parquet");
        let runs = ROW_GROUP as u64 + 3;
        assert_eq!(written(&path, runs), written(&path, runs), "the same bytes each time");
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        assert_eq!(reader.metadata().num_row_groups(), 2);
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len() as u64, runs);
        let cell = |row: usize, name: &str| {
            let (_, field) = rows[row].get_column_iter().find(|(column, _)| *column == name).unwrap();
            field.clone()
        };
        for (name, wanted) in [
            ("k", Field::Long(10_002)),
            ("seed", Field::Long(10_003)),
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
            ("phi1.tick", Field::Long(10_002)),
            ("phi1.latency_s", Field::Null),
        ] {
            assert_eq!(cell(10_002, name), wanted, "{name}");
        }
        assert_eq!(cell(1, "failure"), Field::Str("panicked".into()));
        assert_eq!((cell(1, "sim_time_s"), cell(1, "phi1.verdict")), (Field::Null, Field::Null));
    }
}
