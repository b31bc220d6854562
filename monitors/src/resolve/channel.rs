//! The channel of an event.

use channels::{ChannelId, ProcessId, Shape, Symbol};
use diagnostics::{Problem, nearest_or_all};

use super::Resolver;
use crate::WORLD;
use crate::formula::EventAtom;
use crate::syntax::{self, Name};

impl Resolver<'_> {
    /// The event with its channel and condition resolved: one for each channel that it stands for, of which there is at
    /// least one. `None` after its problems have been reported.
    pub(super) fn events(&mut self, event: &syntax::Event) -> Option<Vec<EventAtom>> {
        let (Some(source), Some(target)) = (event.source.name(), event.target.name()) else {
            return self.any(event);
        };
        let channel = self.channel(source, target);
        let condition = self.condition(&event.condition, channel);
        Some(vec![EventAtom { channel: channel?, condition: condition? }])
    }

    /// The events on all channels that fit: whose messages the condition can be about.
    fn any(&mut self, event: &syntax::Event) -> Option<Vec<EventAtom>> {
        let topology = self.topology;
        let ends = [event.source.name(), event.target.name()].map(|name| name.map(|name| self.process(name)));
        if ends.contains(&Some(None)) {
            return None;
        }
        let fits = |channel: &ChannelId| {
            let (source, target) = topology.ends(*channel);
            let is_meant = |meant: Option<ProcessId>, end: &str| meant.is_none_or(|meant| topology.name(meant) == end);
            let [from, to] = ends.map(Option::flatten);
            !topology.is_internal(*channel) && is_meant(from, source) && is_meant(to, target)
        };
        let noted = self.problems.len();
        let (mut events, mut reasons): (Vec<EventAtom>, Option<Vec<Problem>>) = (Vec::new(), None);
        let mut warnings: Option<Vec<Problem>> = None;
        for channel in topology.channels().filter(fits) {
            let condition = self.condition(&event.condition, Some(channel));
            let problems = self.problems.split_off(noted);
            match condition.filter(|_| !problems.iter().any(Problem::is_error)) {
                Some(condition) => {
                    events.push(EventAtom { channel, condition });
                    // A warning about one channel is not repeated for the next.
                    warnings =
                        Some(warnings.filter(|known: &Vec<Problem>| known.len() >= problems.len()).unwrap_or(problems));
                }
                None if reasons.as_ref().is_none_or(|known| problems.len() < known.len()) => reasons = Some(problems),
                None => {}
            }
        }
        if !events.is_empty() {
            self.problems.extend(warnings.into_iter().flatten());
            return Some(events);
        }
        // The condition fits no channel: its problems on the channel that it fits best are reported.
        let mut reasons = reasons.unwrap_or_else(|| {
            let problem = Problem::new(format!("no channel is from {} to {}", event.source, event.target));
            vec![problem.at(event.span, "no such channel")]
        });
        let unread: Vec<&str> = match ends[0].flatten() {
            Some(source) => topology.unread_topics(source).flat_map(Shape::heads).map(Symbol::name).collect(),
            None => Vec::new(),
        };
        if let Some(last) = reasons.pop_if(|_| !unread.is_empty()) {
            let (topics, source) = (topics_in_words(&unread), &event.source);
            let help = format!("nothing reads {topics} of {source} here, so no message of it arrives anywhere");
            reasons.push(last.with_help(help));
        }
        self.problems.extend(reasons);
        None
    }

    fn channel(&mut self, source: &Name, target: &Name) -> Option<ChannelId> {
        if source.text == WORLD && self.topology.find_process(WORLD).is_none() {
            let problem = Problem::new("nothing shows here what is true in the world");
            let help = "only simulated runs on a map do, and recordings of runs whose own properties ask for it; for a bag, \
                        a mapping can name a topic that measures it";
            self.problems.push(problem.at(source.span, "no such process").with_help(help));
            return None;
        }
        let span = source.span.to(target.span);
        let (source, target) = (self.process(source), self.process(target));
        let (source, target) = (self.topology.name(source?), self.topology.name(target?));
        let Some(channel) = self.topology.find_channel(source, target) else {
            let problem = Problem::new(format!("there is no channel from {source} to {target}"));
            self.problems.push(problem.at(span, "no such channel").with_help(self.other_channels(source, target)));
            return None;
        };
        if self.topology.is_internal(channel) {
            let problem = Problem::new(format!("messages from {source} to {target} are internal to one process"));
            let problem = problem.at(span, "not visible to properties");
            self.problems.push(problem.with_help("properties can only refer to messages between processes"));
            return None;
        }
        Some(channel)
    }

    /// The process that is meant by a name. `None` after the problem has been reported.
    fn process(&mut self, name: &Name) -> Option<ProcessId> {
        let meant = self.topology.meant_by(&name.text);
        if let [process] = *meant {
            return Some(process);
        }
        if !meant.is_empty() {
            let problem = Problem::new(format!("{} processes are called `{}`", meant.len(), name.text));
            let problem = problem.at(name.span, "which of them?");
            self.problems.push(problem.with_help(format!("call one by its full path: {}", self.paths(&meant))));
            return None;
        }
        // Members of a process have no channels to which a property may refer.
        let topology = self.topology;
        let wholes = topology.processes().filter(|process| topology.whole(*process) == *process);
        let known: Vec<&str> = wholes.map(|process| topology.name(process)).collect();
        let problem = Problem::new(format!("unknown process `{}`", name.text)).at(name.span, "no such process");
        self.problems.push(problem.with_help(nearest_or_all(&name.text, "processes", &known)));
        None
    }

    /// The most specific names of these processes, as they are written.
    fn paths(&self, processes: &[ProcessId]) -> String {
        const MOST: usize = 10;
        let paths = processes.iter().filter_map(|process| self.topology.other_names(*process).first());
        let paths: Vec<String> = paths.take(MOST).map(|path| format!("{path:?}")).collect();
        let others = processes.len().saturating_sub(MOST);
        let others = if others == 0 { String::new() } else { format!(", and {others} others") };
        paths.join(", ") + &others
    }

    /// The channels that may have been meant: the opposite direction, or those of the sender.
    fn other_channels(&self, source: &str, target: &str) -> String {
        let topics = self.topology.find_process(source).map(|source| self.topology.topics(source));
        let topics: Vec<&str> = topics.into_iter().flatten().flat_map(Shape::heads).map(Symbol::name).collect();
        if !topics.is_empty() {
            let topics = topics_in_words(&topics);
            return format!("{target} does not read {topics} of {source}: `({source}, *, …)` means whatever reads it");
        }
        if self.topology.find_channel(target, source).is_some() {
            return format!("did you mean `({target}, {source}, …)`? The sender comes first");
        }
        let receivers = self.topology.channels().map(|channel| self.topology.ends(channel));
        let receivers: Vec<&str> =
            receivers.filter(|(from, to)| *from == source && *to != source).map(|(_, to)| to).collect();
        if receivers.is_empty() {
            format!("{source} sends nothing")
        } else {
            format!("{source} sends to {}", receivers.join(", "))
        }
    }
}

/// Topics by their names: "the topic `level`".
fn topics_in_words(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [one] => format!("the topic {one}"),
        more => format!("the topics {}", more.join(", ")),
    }
}
