//! A machine with those inside it, and what is known of their data and of what they send.

use std::collections::BTreeSet;
use std::sync::Arc;

use channels::{Comparisons, Possible};
use diagnostics::Problem;

use super::sources::{PassedText, TextSources, TextUse};
use super::trigger::Trigger;
use crate::Chart;
use crate::ids::DataId;

/// An event that machines of the family send to each other.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Inner {
    event: Option<Arc<str>>,
    /// `None` for all fields.
    field: Option<Arc<str>>,
    value: Possible,
}

/// The machines, and what is known of them.
pub(super) struct Family<'a> {
    /// The machines, by number.
    pub(super) charts: Vec<&'a Chart>,
    pub(super) sources: TextSources<'a>,
    /// By chart and datum.
    data: Vec<Vec<Possible>>,
    inner: Vec<Inner>,
    passed: Vec<PassedText>,
    pub(super) comparisons: Comparisons,
    problems: Vec<Problem>,
    has_changed: bool,
}

impl<'a> Family<'a> {
    pub(super) fn of(chart: &'a Chart, sources: TextSources<'a>) -> Self {
        let mut charts = vec![chart];
        let mut next = 0;
        while let Some(chart) = charts.get(next).copied() {
            charts.extend(chart.inner().map(|inner| &**inner));
            next += 1;
        }
        let data = charts.iter().map(|chart| vec![Possible::default(); chart.data.len()]).collect();
        Self {
            charts,
            sources,
            data,
            inner: Vec::new(),
            passed: Vec::new(),
            comparisons: Comparisons::default(),
            problems: Vec::new(),
            has_changed: true,
        }
    }

    /// Whether anything has become known since this was asked last, or nothing was ever asked.
    pub(super) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.has_changed)
    }

    pub(super) fn into_text_use(self) -> TextUse {
        let Self { data, passed, comparisons, mut problems, .. } = self;
        problems.sort_by_key(Problem::offset);
        problems.dedup_by_key(|problem| (problem.offset(), problem.to_string()));
        let kept = || data.iter().flatten().filter(|held| held.has_choice());
        let in_structures = kept().flat_map(|held| &held.inside).copied().collect();
        let kept = kept().map(|held| held.choices().collect()).collect();
        TextUse { passed, comparisons, kept, in_structures, problems }
    }

    /// What a datum of a machine may hold.
    pub(super) fn held(&self, number: usize, data: DataId) -> Possible {
        self.data[number][data.index()].clone()
    }

    /// Notes that a datum of a machine may hold this.
    pub(super) fn hold(&mut self, number: usize, data: DataId, value: &Possible) {
        self.has_changed |= self.data[number][data.index()].join(value);
    }

    pub(super) fn report(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    /// What the fields with this name, or all fields, of an event that triggers something may hold.
    pub(super) fn fields(&self, trigger: &Trigger<'_>, name: Option<&str>) -> Possible {
        let has_name = |field: &str| name.is_none_or(|name| name == field);
        let received = self.sources.received.iter().filter(|event| trigger.is_one_of(&event.names));
        let received = received.flat_map(|event| {
            let fields = event.fields.iter().filter(|(field, _)| has_name(field));
            fields.map(|(_, value)| value).chain([&event.others])
        });
        let inner = self
            .inner
            .iter()
            .filter(|inner| trigger.may_be(inner.event.as_deref()) && inner.field.as_deref().is_none_or(has_name));
        received.chain(inner.map(|inner| &inner.value)).cloned().collect()
    }

    /// Notes an event that machines of the family send to each other.
    pub(super) fn send_inside(&mut self, event: Option<Arc<str>>, field: Option<Arc<str>>, value: Possible) {
        let same = |known: &&mut Inner| known.event == event && known.field == field;
        match self.inner.iter_mut().find(same) {
            Some(known) => self.has_changed |= known.value.join(&value),
            None => {
                self.has_changed = true;
                self.inner.push(Inner { event, field, value });
            }
        }
    }

    /// Notes a field of a message that is sent over a channel.
    pub(super) fn pass(&mut self, passed: PassedText) {
        let same = |known: &&mut PassedText| {
            (&known.target, &known.head, &known.field) == (&passed.target, &passed.head, &passed.field)
        };
        match self.passed.iter_mut().find(same) {
            Some(known) => self.has_changed |= known.value.join(&passed.value),
            None => {
                self.has_changed = true;
                self.passed.push(passed);
            }
        }
    }

    /// The chosen texts among these, in words.
    pub(super) fn names(&self, of: &Possible) -> String {
        let names: BTreeSet<&str> = of.choices().map(|choice| self.sources.choices[choice].as_str()).collect();
        names.into_iter().collect::<Vec<_>>().join(" or ")
    }
}
