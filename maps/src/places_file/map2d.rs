//! Locations files of YARP's Map2D (`locations.ini`), in which each place is one line:
//!
//! ```text
//! Version:
//! 1
//! Locations:
//! dock office -7.5 9.0 180.0
//! Areas:
//! kitchen office 4 -13.2 15.6 -10.0 15.4 -10.2 12.6 -13.4 13.0
//! ```
//!
//! A location has a name, a map, x and y in meters and a heading in degrees. An area has a name, a map, the number of
//! its corners, and the corners.

use std::collections::BTreeMap;

use diagnostics::{FileProblems, Problem, Source, Span, Spanned};

use super::place::{area, heading_concern, near_enough, near_enough_text, point_at};
use crate::{Place, Places, Point};

const VERSION: &str = "1";

type Word = Spanned<String>;

#[derive(Clone, Copy)]
enum Section {
    Version,
    Locations,
    Areas,
}

/// Places, where each is written, and warnings about them.
pub(super) type Read = (Places, BTreeMap<String, Span>, Vec<Problem>);

/// Reads a locations file.
///
/// # Errors
/// Everything that is wrong with it.
pub(super) fn parse(name: &str, text: &str) -> Result<Read, FileProblems> {
    let source = Source::new(name, text);
    let mut reader = Map2dReader::default();
    let mut section = None;
    for line in lines(&source) {
        let heading = match line.as_slice() {
            [only] => match only.value.as_str() {
                "Version:" => Some(Section::Version),
                "Locations:" => Some(Section::Locations),
                "Areas:" => Some(Section::Areas),
                _ => None,
            },
            _ => None,
        };
        match (heading, section) {
            (Some(heading), _) => section = Some(heading),
            (None, Some(Section::Version)) => reader.version(&line),
            (None, Some(Section::Locations)) => reader.place(&line, Map2dReader::location),
            (None, Some(Section::Areas)) => reader.place(&line, Map2dReader::area),
            // Not reported with the others: this is another kind of file, so every line of it would be a problem.
            (None, None) => {
                let problem = whole(&line).problem("a locations file must begin with `Version:`");
                let help =
                    "YARP's Map2D writes such files; a file with places in TOML must have a name that ends in `.toml`";
                return Err(problem.with_label("this line comes first").with_help(help).into());
            }
        }
    }
    if section.is_none() {
        return Err(source
            .span(0..0)
            .problem("a locations file must begin with `Version:`")
            .with_label("the file is empty")
            .into());
    }
    FileProblems::none_of(reader.problems)?;
    Ok((reader.places, reader.spans, reader.concerns))
}

/// The words of each line that is not blank.
fn lines(source: &Source) -> Vec<Vec<Word>> {
    let mut at = 0;
    let mut lines = Vec::new();
    for line in source.text().split_inclusive('\n') {
        let words = line.split_ascii_whitespace().map(|word| {
            // A word is a slice of its line, so the difference between their addresses is its offset.
            let start = at + (word.as_ptr().addr() - line.as_ptr().addr());
            Spanned { value: word.to_owned(), span: source.span(start..start + word.len()) }
        });
        lines.push(words.collect::<Vec<Word>>());
        at += line.len();
    }
    lines.retain(|words| !words.is_empty());
    lines
}

/// The span from the first to the last of these words.
fn whole(words: &[Word]) -> Span {
    let (first, last) = (&words[0].span, &words[words.len() - 1].span);
    first.source().span(first.range().start..last.range().end)
}

#[derive(Default)]
struct Map2dReader {
    places: Places,
    spans: BTreeMap<String, Span>,
    /// The map that the first place belongs to.
    map: Option<String>,
    problems: Vec<Problem>,
    concerns: Vec<Problem>,
}

impl Map2dReader {
    fn version(&mut self, line: &[Word]) {
        if !matches!(line, [version] if version.value == VERSION) {
            let problem = whole(line).problem("unknown version of the format");
            self.problems
                .push(problem.with_label("this version").with_help(format!("only version {VERSION} is supported")));
        }
    }

    /// A line that begins with the name of a place and that of its map.
    fn place(&mut self, line: &[Word], read: impl FnOnce(&mut Self, &[Word], &Span) -> Option<Place>) {
        let [name, map, rest @ ..] = line else {
            let problem = whole(line).problem("a place needs a name, a map and numbers");
            self.problems.push(problem.with_label("this line"));
            return;
        };
        let first_map = self.map.get_or_insert_with(|| map.value.clone());
        if *first_map != map.value {
            let problem = map.span.problem(format!("`{}` belongs to a different map", name.value));
            let help = format!("the places above belong to `{first_map}`, and a scenario has only one map");
            self.problems.push(problem.with_label("this map").with_help(help));
        }
        if self.spans.contains_key(&name.value) {
            let problem = name.span.problem(format!("there is already a place `{}`", name.value));
            self.problems.push(problem.with_label("this name").with_help("give each place a different name"));
        }
        let span = if rest.is_empty() { whole(line) } else { whole(rest) };
        if let Some(place) = read(self, rest, &span) {
            self.places.insert(&*name.value, place);
            self.spans.insert(name.value.clone(), span);
        }
    }

    fn location(&mut self, numbers: &[Word], span: &Span) -> Option<Place> {
        let [x_m, y_m, heading_deg] = numbers else {
            let problem = span.problem("a location needs x and y in meters and a heading in degrees");
            self.problems.push(problem.with_label(format!("expected three numbers, found {}", numbers.len())));
            return None;
        };
        let heading = &heading_deg.span;
        let [x_m, y_m, heading_deg] = [x_m, y_m, heading_deg].map(|word| self.number(word));
        let position = self.position([x_m?, y_m?], span)?;
        self.concerns.extend(heading_concern(heading_deg?, heading));
        Some(point_at(position, heading_deg?))
    }

    fn area(&mut self, numbers: &[Word], span: &Span) -> Option<Place> {
        let (count, corners) = numbers.split_first()?;
        let wanted = count.value.parse::<usize>().ok();
        if wanted.and_then(|wanted| wanted.checked_mul(2)) != Some(corners.len()) {
            let problem = count.span.problem("an area needs its number of corners, followed by x and y of each");
            self.problems.push(problem.with_label(format!("{} numbers follow", corners.len())));
            return None;
        }
        let corner = |reader: &mut Self, pair: &[Word]| {
            let span = whole(pair);
            let [x_m, y_m] = [&pair[0], &pair[1]].map(|word| reader.number(word));
            let position = reader.position([x_m?, y_m?], &span)?;
            Some(Spanned { value: Point::from(position), span })
        };
        let corners: Vec<_> = corners.chunks_exact(2).map(|pair| corner(self, pair)).collect();
        area(corners.into_iter().collect::<Option<_>>()?, span, false)
            .map_err(|problems| self.problems.extend(problems))
            .ok()
    }

    fn number(&mut self, word: &Word) -> Option<f64> {
        let number = word.value.parse().ok().filter(|number: &f64| number.is_finite());
        if number.is_none() {
            self.problems.push(word.span.problem("expected a number").with_label("this is not a number"));
        }
        number
    }

    fn position(&mut self, position: [f64; 2], span: &Span) -> Option<[f64; 2]> {
        let near = near_enough(&position);
        if !near {
            self.problems.push(span.problem(format!("a position must {}", near_enough_text())));
        }
        near.then_some(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heading;

    const HOUSE: &str = "Version:\n1\nLocations:\ndock office -7.5 9.0 180.0\nAreas:\n\
                         kitchen office 4 -13.2 15.6 -10.0 15.4 -10.2 12.6 -13.4 13.0\n";

    fn rendered(text: &str) -> String {
        parse("locations.ini", text).expect_err(text).plain()
    }

    #[test]
    fn locations_become_points_and_areas_become_polygons() {
        for text in [HOUSE.to_owned(), HOUSE.replace('\n', "\r\n"), HOUSE.replace("Areas", "\n\nAreas")] {
            let (places, spans, _) = parse("locations.ini", &text).expect(&text);
            let dock = places.get("dock").expect("a place");
            assert_eq!(dock.goal_position(), Point::new(-7.5, 9.0));
            let Place::Point { pose, .. } = dock else { panic!("a point") };
            assert_eq!(heading(pose), std::f64::consts::PI);
            assert!(matches!(places.get("kitchen"), Some(Place::Area { corners }) if corners.len() == 4));
            assert_eq!(spans["kitchen"].line(), text[..text.find("kitchen").unwrap_or(0)].matches('\n').count() + 1);
        }
    }

    #[test]
    fn every_mistake_is_reported_with_its_location() {
        for (from, to, words) in [
            ("\n1\n", "\n7\n", "locations.ini:2:1: unknown version of the format"),
            ("9.0 180.0", "9.0", "locations.ini:4:13: a location needs x and y in meters"),
            ("9.0 180.0", "nine 180.0", "locations.ini:4:18: expected a number"),
            ("office 4", "office 5", "locations.ini:6:16: an area needs its number of corners"),
            ("kitchen office", "kitchen garden", "`kitchen` belongs to a different map"),
            ("kitchen office", "dock office", "there is already a place `dock`"),
            ("-13.4 13.0", "-13.2 15.6", "the same point"),
            ("-7.5", "-7.5e9", "a position must lie within"),
            ("Version:\n", "", "a locations file must begin with `Version:`"),
            ("dock office -7.5 9.0 180.0", "dock", "a place needs a name, a map and numbers"),
        ] {
            let text = rendered(&HOUSE.replace(from, to));
            assert!(text.contains(words), "{words} is not in\n{text}");
        }
        let both = rendered(&HOUSE.replace("9.0", "nine").replace("12.6", "twelve"));
        assert_eq!(both.lines().count(), 2, "all problems at once: {both}");
        assert!(rendered("").contains("must begin with `Version:`"));
    }
}
