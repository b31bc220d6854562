//! What a machine does, apart from where that is written.

use std::sync::Arc;

use diagnostics::Source;

use super::Chart;
use super::content::InvokeSource;

impl Chart {
    /// Everything about the machine and those inside it that does not depend on the lines of their file: equal for two
    /// machines that do the same in every run. States without an id are named after their lines; these are left out.
    pub(crate) fn meaning(mut self) -> String {
        let mut text = String::new();
        self.tell(&mut text);
        let mut pieces = text.split('@');
        let first = pieces.next().unwrap_or_default().to_owned();
        pieces.fold(first, |told, piece| told + "@" + piece.trim_start_matches(|c: char| c.is_ascii_digit()))
    }

    fn tell(&mut self, text: &mut String) {
        self.relocate(Source::new("", ""), &|_| 0..0);
        for invoke in self.states.iter_mut().flat_map(|state| &mut state.invokes) {
            if let InvokeSource::Inline(inner) = &mut invoke.source {
                Arc::get_mut(inner).expect("nothing else has a machine that was just compiled").tell(text);
            }
        }
        let warnings: Vec<String> = self.warnings.iter().map(ToString::to_string).collect();
        let Self { ids, binding, states, transitions, data, scripts, events, foreign, mentions, .. } = self;
        let parts = (ids, binding, states, transitions, data, scripts, events, foreign, mentions, warnings);
        *text += &format!("{parts:?}");
    }
}

#[cfg(test)]
mod tests {
    use crate::Chart;

    fn meaning(content: &str) -> String {
        let text = format!("<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'>{content}</scxml>");
        let chart = Chart::load("test.scxml", &text).unwrap_or_else(|error| panic!("{error:?}"));
        std::sync::Arc::into_inner(chart).expect("nothing else has it").meaning()
    }

    #[test]
    fn the_meaning_of_a_machine_is_all_that_it_does() {
        let inside = |state: &str| {
            format!("<state id='a'><invoke><content><scxml version='1.0'>{state}</scxml></content></invoke></state>")
        };
        assert_eq!(meaning(&inside("<state/>")), meaning(&format!("\n\n{}", inside("\n<state/>"))));
        let different = [
            "<state id='a'/>".to_owned(),
            "<state id='b'/>".to_owned(),
            "<state/>".to_owned(),
            "<final id='a'/>".to_owned(),
            "<state id='a'><onentry><log expr='1'/></onentry></state>".to_owned(),
            "<state id='a'><onentry><log expr='2'/></onentry></state>".to_owned(),
            "<state id='a'><transition event='e' target='a'/></state>".to_owned(),
            "<state id='a'><transition event='f' target='a'/></state>".to_owned(),
            inside("<state id='b'/>"),
            inside("<state id='c'/>"),
        ];
        let meanings: std::collections::BTreeSet<String> = different.iter().map(|content| meaning(content)).collect();
        assert_eq!(meanings.len(), different.len());
    }
}
