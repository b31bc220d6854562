//! Publishers appear, leave, restart and replace each other: what that means for their messages.

use std::collections::{BTreeMap, BTreeSet};

use super::Reception;
use super::sequence_gaps::Phase;
use crate::domain::exchange::{Server, Writer};
use crate::domain::names;

impl Reception {
    /// Compares the writers that are in the domain now with those that were there before.
    pub(super) fn compare(
        &mut self,
        writers: Vec<Writer>,
        servers: &BTreeMap<String, Vec<Server>>,
        goodbyes: BTreeSet<[u8; 16]>,
    ) {
        self.discovery.add_goodbyes(goodbyes);
        let present: BTreeSet<[u8; 16]> = writers.iter().map(|writer| writer.guid).collect();
        if !self.failover.has_failed {
            self.remove_all_but(&present);
        }
        for writer in writers {
            self.gaps.absences.mark_found(&writer.guid);
            if !self.discovery.writers.contains_key(&writer.guid) {
                self.add(writer);
            }
        }
        self.failover.present = present;
        self.discovery.forget_absent_nodes();
        self.discovery.describe(servers);
    }

    fn remove_all_but(&mut self, present: &BTreeSet<[u8; 16]>) {
        let writers = self.discovery.writers.keys();
        let left: Vec<[u8; 16]> = writers.filter(|guid| !present.contains(*guid)).copied().collect();
        left.into_iter().for_each(|guid| self.remove(guid));
    }

    /// The publishers that a new participant has not found again in time are gone.
    pub(super) fn remove_absent(&mut self) {
        let present = std::mem::take(&mut self.failover.present);
        self.remove_all_but(&present);
        (self.failover.present, self.failover.has_failed) = (present, false);
    }

    fn add(&mut self, writer: Writer) {
        let guid = writer.guid;
        let is_late = self.gaps.phase == Phase::Watching && self.discovery.wanted.names.is_some();
        let (new_topic, has_left) = self.discovery.add(writer, is_late, self.gaps.newest_ns);
        if has_left {
            self.restart(&guid);
        }
        if let (Some(topic), Some(unseen_ns)) = (new_topic.filter(|_| is_late), self.failover.unseen_since_ns) {
            // The topic may have had a publisher, and messages, while nothing could be received.
            self.gaps.lose_on(topic, unseen_ns);
        }
        if self.gaps.phase != Phase::Looking {
            self.report_unreceivable(&guid);
        }
    }

    fn remove(&mut self, guid: [u8; 16]) {
        let Some(known) = self.discovery.remove(&guid, self.gaps.newest_ns) else { return };
        let is_reported = self.gaps.phase != Phase::Looking && self.discovery.wanted.names.is_some();
        let is_judged = |topic: &usize| is_reported && !self.discovery.is_only_shown(*topic);
        if let Some(topic) = known.topic.filter(is_judged) {
            let (name, when) = (&self.discovery.survey.topics[topic].name, bags::moment(self.gaps.newest_ns));
            let publisher = self.discovery.name_of(&known.writer);
            if known.has_left {
                self.remarks.note(format!("{publisher} stopped publishing on {name} at {when}"));
                self.end_absence(&guid);
            } else {
                self.remarks.note(format!(
                    "{publisher}, which publishes on {name}, was given up at {when}: it has died, or is out of reach"
                ));
                // It may go on publishing, and its messages be lost, until another publisher replaces it.
                self.gaps.lose_on(topic, known.last.map_or(known.since_ns, |last| last.at_ns));
                self.gaps.absences.add(topic, guid);
                let mut writers = self.discovery.writers.keys();
                let successor = writers.find(|writer| self.discovery.replaces(writer, &known)).copied();
                self.discovery.gone.insert(guid, known);
                return successor.into_iter().for_each(|successor| self.end_absences(&successor));
            }
        }
        self.discovery.remember(guid, known);
    }

    /// The publishers that a writer replaces are not absent any more.
    fn end_absences(&mut self, successor: &[u8; 16]) {
        for guid in self.discovery.replaced_by(successor) {
            self.end_absence(&guid);
        }
    }

    fn end_absence(&mut self, guid: &[u8; 16]) {
        let complete = self.gaps.absences.remove(guid);
        self.gaps.resume(complete, self.gaps.newest_ns);
    }

    /// Writers have restarted: they number their messages from 1 again, and the last numbers before that are unknown.
    pub(super) fn restart(&mut self, of: &[u8; 16]) {
        let is_watching = self.gaps.phase == Phase::Watching;
        let mut topics = self.discovery.restart(of, is_watching);
        let discovery = &self.discovery;
        topics.retain(|(topic, guid, _)| {
            is_watching
                && discovery.wanted.names.is_some()
                && !discovery.is_only_shown(*topic)
                && discovery.writers.contains_key(guid)
        });
        for (topic, guid, since_ns) in topics {
            let name = &discovery.survey.topics[topic].name;
            self.remarks.note(format!("a publisher on {name} has begun anew after {}", bags::moment(since_ns)));
            self.gaps.absences.add(topic, guid);
            self.gaps.lose_on(topic, since_ns);
        }
    }

    /// Reports what cannot be received from a writer.
    pub(super) fn report_unreceivable(&mut self, guid: &[u8; 16]) {
        let (discovery, remarks) = (&self.discovery, &mut self.remarks);
        let Some(known) = discovery.writers.get(guid).filter(|_| discovery.wanted.names.is_some()) else { return };
        let Some(topic) = known.topic.filter(|topic| !discovery.is_only_shown(*topic)) else { return };
        let (name, publisher) = (&discovery.survey.topics[topic].name, discovery.name_of(&known.writer));
        let (writer, kind) = (&known.writer, names::kind(&known.writer.kind));
        if let Some(policy) = &writer.unfit {
            remarks.lose(format!("{publisher} publishes on {name} with a {policy} that cannot be subscribed to"));
        } else if !known.is_read {
            remarks
                .lose(format!("{publisher} publishes messages of another type on {name}, {kind}, which are left out"));
        } else if writer.is_latched && discovery.volatile.contains(&topic) {
            remarks.note(format!(
                "{publisher} latches on {name}, and another publisher does not: what was latched is not received"
            ));
            self.gaps.lose_on(topic, self.gaps.begun_ns);
        }
    }

    /// Notes the publishers that have been discovered, once their nodes are known, or have not been listed for long.
    pub(super) fn note_publishers(&mut self, now_ns: i64) {
        for (since_ns, guid, topic) in self.discovery.take_named(now_ns) {
            self.end_absences(&guid);
            let notes = self.discovery.notes_on(&guid, topic, since_ns);
            notes.into_iter().for_each(|note| self.remarks.note(note));
        }
    }
}
