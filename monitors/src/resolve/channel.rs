//! The channel of an event.

use channels::ChannelId;
use diagnostics::{Problem, nearest_or_all};

use super::Resolver;
use crate::WORLD;
use crate::formula::EventAtom;
use crate::syntax::{self, Name};

impl Resolver<'_> {
    /// The event with its channel and condition resolved; `None` after its problems have been reported.
    pub(super) fn event(&mut self, event: &syntax::Event) -> Option<EventAtom> {
        let channel = self.channel(event);
        let condition = self.condition(&event.condition, channel);
        Some(EventAtom { channel: channel?, condition: condition? })
    }

    fn channel(&mut self, event: &syntax::Event) -> Option<ChannelId> {
        if event.source.text == WORLD && self.topology.find_process(WORLD).is_none() {
            let problem = Problem::new("nothing shows here what is true in the world");
            let help = "only simulated runs on a map do, and recordings of runs whose own properties ask for it; for a bag, \
                        a mapping can name a topic that measures it";
            self.problems.push(problem.at(event.source.span, "no such process").with_help(help));
            return None;
        }
        let known = [self.process_is_known(&event.source), self.process_is_known(&event.target)];
        if known != [true, true] {
            return None;
        }
        let (source, target) = (event.source.text.as_str(), event.target.text.as_str());
        let Some(channel) = self.topology.find_channel(source, target) else {
            let span = event.source.span.to(event.target.span);
            let problem = Problem::new(format!("there is no channel from {source} to {target}"));
            self.problems.push(problem.at(span, "no such channel").with_help(self.other_channels(source, target)));
            return None;
        };
        if self.topology.is_internal(channel) {
            let span = event.source.span.to(event.target.span);
            let problem = Problem::new(format!("messages from {source} to {target} are internal to one process"));
            let problem = problem.at(span, "not visible to properties");
            self.problems.push(problem.with_help("properties can only refer to messages between processes"));
            return None;
        }
        Some(channel)
    }

    fn process_is_known(&mut self, name: &Name) -> bool {
        if self.topology.find_process(&name.text).is_some() {
            return true;
        }
        // Members of a process have no channels to which a property may refer.
        let topology = self.topology;
        let wholes = topology.processes().filter(|process| topology.whole(*process) == *process);
        let known: Vec<&str> = wholes.map(|process| topology.name(process)).collect();
        let problem = Problem::new(format!("unknown process `{}`", name.text)).at(name.span, "no such process");
        self.problems.push(problem.with_help(nearest_or_all(&name.text, "processes", &known)));
        false
    }

    /// The channels that may have been meant: the opposite direction, or those of the sender.
    fn other_channels(&self, source: &str, target: &str) -> String {
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
