//! MCAP files.
//!
//! A file is read record by record, and large chunks as a stream, so memory does not depend on the size of either.
//! Where its messages are, and when they were recorded, follows from the index of its chunks; what has none is walked
//! through once before it is read. Chunks without wanted topics are skipped. Unwanted messages are skipped, too, where
//! there is neither compression nor a checksum.

mod walk;

use std::collections::BTreeMap;
use std::mem;
use std::path::Path;

use ::mcap::records::{ChunkIndex, MessageHeader};

use super::merge::{Block, Plan, UNIT, Unit};
use super::source::{Received, Wanted};
use super::survey::{Head, Survey, Topic};
use crate::Error;
use walk::{ReadDepth, Walk, WalkStep, absent_chunks, nanoseconds, redeclared};

/// What every file begins with.
pub(super) const MAGIC: &[u8] = ::mcap::MAGIC;

/// Adds the contents of a file. Returns its plan if it had to be read in full.
pub(super) fn survey(path: &Path, survey: &mut Survey) -> Result<Option<Plan>, Error> {
    let mut walk = Walk::open(path)?;
    let summary = walk.summary();
    survey.distributions.append(&mut walk.known.distributions);
    if let Some(summary) = summary {
        let topics: BTreeMap<u16, usize> =
            walk.known.channels.iter().map(|(id, topic)| (*id, survey.add(topic.clone()))).collect();
        for (channel, count) in &summary.counts {
            if let Some(topic) = topics.get(channel) {
                survey.counts[*topic] += count;
            }
        }
        if let Some((first, last)) = summary.span {
            survey.note_times(nanoseconds(first), nanoseconds(last));
        }
        for (channel, topic) in topics {
            if let Some((first, last)) = walk.span_of(channel, &summary.chunks) {
                survey.note_times_on(topic, (nanoseconds(first), nanoseconds(last)));
            }
        }
        return Ok(None);
    }
    // What is lost will be reported when the messages are read.
    let (mut seen, mut plan) = (BTreeMap::<u16, (u64, i64, i64)>::new(), Plan::default());
    let chunks = walk.divide(MAGIC.len() as u64, None, &mut plan, &mut |head| {
        let time_ns = nanoseconds(head.log_time);
        let (count, first_ns, last_ns) = seen.entry(head.channel_id).or_insert((0, time_ns, time_ns));
        (*count, *first_ns, *last_ns) = (*count + 1, time_ns.min(*first_ns), time_ns.max(*last_ns));
        survey.note_times(time_ns, time_ns);
    });
    survey.distributions.append(&mut walk.known.distributions);
    let found = seen.values().map(|(count, ..)| count).sum();
    survey.lost.append(&mut plan.unfit);
    survey.lost.extend(walk.unfit(found, &chunks));
    // Chunks have checksums of their own.
    survey.lost.extend(chunks.is_empty().then(|| walk.wrong_checksum()).flatten());
    for (channel, topic) in &walk.known.channels {
        let topic = survey.add(topic.clone());
        if let Some((count, first_ns, last_ns)) = seen.get(channel) {
            survey.counts[topic] += count;
            survey.note_times_on(topic, (*first_ns, *last_ns));
        }
    }
    plan.topics = walk.known.channels;
    Ok(Some(plan))
}

/// Where the messages of a file are.
pub(super) fn plan(path: &Path) -> Result<Plan, Error> {
    let mut walk = Walk::open(path)?;
    let (mut plan, begin) = (Plan::default(), MAGIC.len() as u64);
    let mut chunks = Vec::new();
    match walk.summary() {
        Some(summary) if is_in_order(&summary.chunks) => {
            let mut at = begin;
            for chunk in &summary.chunks {
                walk.divide(at, Some(chunk.chunk_start_offset), &mut plan, &mut |_| {});
                plan.units.push(unit(chunk));
                chunks.push(chunk.chunk_start_offset);
                at = chunk_end(chunk).saturating_add(chunk.message_index_length);
            }
            chunks.extend(walk.divide(at, Some(summary.start), &mut plan, &mut |_| {}));
            plan.counts = Some(summary.counts);
        }
        summary => {
            chunks = walk.divide(begin, None, &mut plan, &mut |_| {});
            plan.counts = summary.map(|summary| summary.counts);
        }
    }
    plan.unfit.extend(chunks.is_empty().then(|| walk.wrong_checksum()).flatten());
    plan.topics = walk.known.channels;
    Ok(plan)
}

fn chunk_end(chunk: &ChunkIndex) -> u64 {
    chunk.chunk_start_offset.saturating_add(chunk.chunk_length)
}

/// Whether each chunk begins after the one before it has ended.
fn is_in_order(chunks: &[ChunkIndex]) -> bool {
    chunks.is_sorted_by(|a, b| chunk_end(a).saturating_add(a.message_index_length) <= b.chunk_start_offset)
}

fn unit(chunk: &ChunkIndex) -> Unit {
    Unit {
        start: nanoseconds(chunk.chunk_start_offset),
        end: nanoseconds(chunk_end(chunk)),
        first_ns: nanoseconds(chunk.message_start_time),
        last_ns: nanoseconds(chunk.message_end_time),
        channels: Some(chunk.message_index_offsets.keys().copied().collect()),
    }
}

/// The wanted messages of a file that is still being written, as they are written.
pub(super) struct McapFollower {
    walk: Walk,
    /// The channels that have been seen, with their topics if these are wanted, and how many messages of them.
    seen: BTreeMap<u16, (Option<usize>, u64)>,
}

/// Whether messages have been in the order of their log times so far.
pub(super) struct LogOrder {
    newest_ns: i64,
    pub(super) is_ascending: bool,
}

impl Default for LogOrder {
    fn default() -> Self {
        Self { newest_ns: i64::MIN, is_ascending: true }
    }
}

impl LogOrder {
    fn note(&mut self, log_ns: i64) {
        self.is_ascending &= self.newest_ns <= log_ns;
        self.newest_ns = log_ns;
    }
}

impl McapFollower {
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        let mut walk = Walk::open(path)?;
        walk.grows = true;
        Ok(Self { walk, seen: BTreeMap::new() })
    }

    pub(super) fn receive(
        &mut self,
        wanted: &Wanted,
        survey: &mut Survey,
        body: &mut Vec<u8>,
        lost: &mut Vec<String>,
        order: &mut LogOrder,
    ) -> Received {
        let Self { walk, seen } = self;
        walk.first_ns = Some(survey.first_ns());
        let (mut topic, mut is_undeclared) = (None, false);
        let chooses = |head: &MessageHeader, channels: &BTreeMap<u16, Topic>| {
            let (of_channel, count) = seen.entry(head.channel_id).or_insert_with(|| {
                let topic = channels.get(&head.channel_id);
                is_undeclared |= topic.is_none();
                (topic.and_then(|topic| wanted.index(topic, survey)), 0)
            });
            *count += 1;
            order.note(nanoseconds(head.log_time));
            topic = *of_channel;
            if topic.is_some() { ReadDepth::Body } else { ReadDepth::Nothing }
        };
        let head = walk.next_message(chooses, body, lost);
        lost.extend(is_undeclared.then(|| undeclared(&walk.path)));
        match head.zip(topic) {
            Some((head, topic)) => Received::Message(in_survey(&head, topic)),
            None if walk.is_over => Received::Over,
            None => Received::Idle,
        }
    }

    /// Now that it is over, adds the wanted topics that the file lists, with or without messages, and compares what has
    /// been read with what follows the data, as far as that has been written by now.
    pub(super) fn finish(&self, wanted: &Wanted, survey: &mut Survey, lost: &mut Vec<String>) {
        let Self { walk, seen } = self;
        let declared = &walk.known.channels;
        for topic in declared.values() {
            wanted.index(topic, survey);
        }
        let mut again = match Walk::open(&walk.path) {
            Ok(again) => again,
            Err(error) => return lost.push(error.to_string()),
        };
        let summary = again.summary();
        let listed = mem::take(&mut again.known.channels);
        for topic in listed.values() {
            wanted.index(topic, survey);
        }
        let found: BTreeMap<u16, u64> = seen.iter().map(|(channel, (_, count))| (*channel, *count)).collect();
        let mut wrong = Vec::new();
        again.go_to(walk.at);
        match summary {
            Some(summary) => wanted.compare(&walk.path, &listed, [&summary.counts, &found], survey),
            None => wrong.extend(again.unfit(found.values().sum(), &walk.chunks)),
        }
        let mut both = listed.iter().filter_map(|(channel, topic)| Some((topic, declared.get(channel)?)));
        wrong.extend(both.any(|(topic, other)| topic != other).then(|| redeclared(&walk.path)));
        // Chunks have checksums of their own.
        wrong.extend(walk.chunks.is_empty().then(|| again.wrong_checksum()).flatten());
        // It may be about any message that has been read.
        for what in wrong {
            survey.doubt(&what);
            lost.extend((!lost.contains(&what)).then_some(what));
        }
    }

    /// That the file breaks off, in words, if only a part of the next record is in it, and no more of it is awaited.
    pub(super) fn breaks_off(&mut self) -> Option<String> {
        self.walk.breaks_off()
    }
}

fn in_survey(head: &MessageHeader, topic: usize) -> Head {
    Head { topic, log_ns: nanoseconds(head.log_time), publish_ns: nanoseconds(head.publish_time) }
}

/// Reads the units of a file.
pub(super) struct McapReader {
    walk: Walk,
    /// The channels that have been seen, with their topics if these are wanted, and how many messages of them have been
    /// seen since they were counted last.
    seen: BTreeMap<u16, (Option<usize>, u64)>,
}

impl McapReader {
    pub(super) fn open(path: &Path, plan: &Plan) -> Result<Self, Error> {
        let mut walk = Walk::open(path)?;
        walk.known.channels.clone_from(&plan.topics);
        Ok(Self { walk, seen: BTreeMap::new() })
    }

    /// Reads the wanted messages of a unit. Counts those of each channel that it reads for the first time.
    pub(super) fn load(
        &mut self,
        unit: &Unit,
        block: &mut Block,
        wanted: &Wanted,
        survey: &mut Survey,
        read: &mut BTreeMap<u16, u64>,
        lost: &mut Vec<String>,
    ) {
        let Self { walk, seen } = self;
        walk.first_ns = Some(survey.first_ns());
        walk.go_to(unit.start.unsigned_abs());
        let end = unit.end.unsigned_abs();
        if unit.channels.is_some() && !matches!(walk.chunk_end(), Ok(Some(found)) if found == end) {
            lost.push(absent_chunks(&walk.path));
            return;
        }
        let (mut bytes, mut is_early, mut is_undeclared) = (mem::take(&mut block.bytes), false, false);
        // How many messages preceded those of the chunk that is in memory as a whole.
        let mut begun = None;
        while !walk.is_over && (walk.is_in_chunk() || walk.at < end) {
            let is_whole = walk.is_whole();
            if is_whole {
                begun.get_or_insert(block.count());
            }
            let mut chosen = None;
            let mut chooses = |head: &MessageHeader, channels: &BTreeMap<u16, Topic>| {
                let (topic, count) = seen.entry(head.channel_id).or_insert_with(|| {
                    let topic = channels.get(&head.channel_id);
                    is_undeclared |= topic.is_none();
                    (topic.and_then(|topic| wanted.index(topic, survey)), 0)
                });
                *count += 1;
                let Some(topic) = *topic else { return ReadDepth::Nothing };
                let head = in_survey(head, topic);
                is_early |= head.log_ns < unit.first_ns;
                chosen = block.place(head.log_ns).map(|number| (head, number));
                match chosen {
                    None => ReadDepth::Nothing,
                    Some(_) if is_whole => ReadDepth::Head,
                    Some(_) => ReadDepth::Body,
                }
            };
            let step = walk.advance(&mut chooses, &mut bytes, lost);
            if let (WalkStep::Message(_, length), Some((head, number))) = (step, chosen) {
                let at = walk.place_in_chunk(length).unwrap_or_else(|| bytes.len() - length);
                block.add(head, number, at, length);
            }
            if let Some(count) = begun.take_if(|_| !walk.is_whole()) {
                take_chunk(&mut bytes, &mut walk.spare, count, block);
            }
            if begun.is_none() && block.is_full(bytes.len()) {
                mem::swap(&mut bytes, &mut block.bytes);
                block.shorten();
                bytes = mem::take(&mut block.bytes);
            }
        }
        block.bytes = bytes;
        for (channel, (_, count)) in seen.iter_mut() {
            let new = mem::take(count);
            *read.entry(*channel).or_default() += if block.is_again() { 0 } else { new };
        }
        lost.extend(is_undeclared.then(|| undeclared(&walk.path)));
        if is_early {
            lost.push(format!("{}: its index is wrong about when messages were recorded", walk.path.display()));
        }
    }
}

/// That a channel is unknown, in words.
fn undeclared(path: &Path) -> String {
    format!("{} has messages of a channel that it does not declare", path.display())
}

/// Adds the bytes of a chunk, in which the messages since there were `count` are.
fn take_chunk(bytes: &mut Vec<u8>, chunk: &mut Vec<u8>, count: usize, block: &mut Block) {
    if block.count() == count {
        return;
    }
    if bytes.is_empty() {
        mem::swap(bytes, chunk);
    } else {
        block.shift(count, bytes.len());
        bytes.extend_from_slice(chunk);
    }
}

impl Walk {
    /// Divides a part of the file into units, each with the times of its messages. Walks through all of them. Returns
    /// where chunks begin.
    fn divide(
        &mut self,
        start: u64,
        end: Option<u64>,
        plan: &mut Plan,
        counted: &mut dyn FnMut(&MessageHeader),
    ) -> Vec<u64> {
        let mut chunks = Vec::new();
        if end.is_some_and(|end| end <= start) {
            return chunks;
        }
        let (mut none, mut unit) = (Vec::new(), Unit::empty(nanoseconds(start)));
        let (lost, mut origin) = (plan.lost.len(), self.origin.0);
        let mut chunk = ChunkCount::default();
        self.go_to(start);
        while !self.is_over && (self.is_in_chunk() || end.is_none_or(|end| self.at < end)) {
            let step = self.advance(&mut |_: &_, _: &_| ReadDepth::Head, &mut none, &mut plan.lost);
            if origin != self.origin.0 {
                origin = self.origin.0;
                // Indexes belong to the chunk before them.
                if !matches!(step, WalkStep::Index(_)) {
                    plan.unfit.extend(chunk.misfit(&self.path, plan.lost.len()));
                    chunk = ChunkCount { lost: plan.lost.len(), ..ChunkCount::default() };
                }
                if self.after_chunk > origin {
                    chunks.push(origin);
                }
                let at = nanoseconds(origin);
                if !unit.is_empty() && origin.saturating_sub(unit.start.unsigned_abs()) >= UNIT {
                    let next = Unit::empty(at);
                    plan.units.push(Unit { end: at, ..mem::replace(&mut unit, next) });
                }
                // Messages in it may be damaged.
                self.origin.1.into_iter().for_each(|earliest| unit.note(nanoseconds(earliest)));
            }
            match step {
                WalkStep::Index(entries) => *chunk.indexed.get_or_insert(0) += entries,
                WalkStep::Message(head, _) => {
                    chunk.found += 1;
                    unit.note(nanoseconds(head.log_time));
                    counted(&head);
                }
                _ => {}
            }
        }
        plan.unfit.extend(chunk.misfit(&self.path, plan.lost.len()));
        unit.end = end.map_or(i64::MAX, nanoseconds);
        let is_damaged = plan.lost.len() > lost;
        if unit.is_empty() && is_damaged {
            unit.note(i64::MIN);
        }
        if !unit.is_empty() || is_damaged {
            plan.units.push(unit);
        }
        chunks
    }
}

/// How many messages a chunk has, and how many the indexes after it have.
#[derive(Default)]
struct ChunkCount {
    found: u64,
    indexed: Option<u64>,
    /// How much was lost before it.
    lost: usize,
}

impl ChunkCount {
    /// That the two numbers differ, in words. Nothing if more is lost by now than before the chunk: it is damaged, so
    /// it is known that messages are missing.
    fn misfit(&self, path: &Path, lost: usize) -> Option<String> {
        let Self { found, indexed, lost: before } = *self;
        let indexed = indexed.filter(|indexed| *indexed != found && lost == before)?;
        let counts = format!("counts {indexed} messages, and {found} are there");
        Some(format!("{} has a chunk whose index {counts}", path.display()))
    }
}
