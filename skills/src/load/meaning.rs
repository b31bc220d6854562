//! What a machine does, apart from where that is written.

use super::origin::Origin;
use crate::SkillError;
use crate::chart::Chart;

/// Everything about the machine in a text, and about those inside it, that does not depend on the lines of the text:
/// equal for two machines that do the same in every run. States without an id are named after their lines; these are
/// left out.
///
/// # Errors
/// [`SkillError::Load`] with as many problems as the text has, all at its beginning.
pub(super) fn meaning(text: &str, origin: &Origin) -> Result<String, SkillError> {
    let (chart, mut written) = (Chart::compile(text, &|_| 0..0, origin)?, String::new());
    write(&chart, &mut written);
    let mut pieces = written.split('@');
    let first = pieces.next().unwrap_or_default().to_owned();
    Ok(pieces.fold(first, |kept, piece| kept + "@" + piece.trim_start_matches(|c: char| c.is_ascii_digit())))
}

fn write(chart: &Chart, text: &mut String) {
    chart.inner().for_each(|inner| write(inner, text));
    let warnings: Vec<String> = chart.warnings.iter().map(ToString::to_string).collect();
    let Chart { ids, binding, states, transitions, data, scripts, events, foreign, mentions, .. } = chart;
    let parts = (ids, binding, states, transitions, data, scripts, events, foreign, mentions, warnings);
    *text += &format!("{parts:?}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Strictness;

    fn meaning(content: &str) -> String {
        let text = format!("<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'>{content}</scxml>");
        let origin = Origin::of("test.scxml", &text, Strictness::Strict);
        super::meaning(&text, &origin).unwrap_or_else(|error| panic!("{error:?}"))
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
