//! Colors, bars and numbers as the script of the timeline takes them.

use std::collections::HashMap;

use drawing::theme::Color;

use crate::html::colors;

/// The looks of all bars, each once: text, ground, outline and ink.
#[derive(Default)]
pub(super) struct Looks {
    numbers: HashMap<[String; 4], usize>,
    pub(super) all: Vec<[String; 4]>,
}

impl Looks {
    /// The number of a look. Without a ground, a bar is a thin line.
    pub(super) fn number(&mut self, look: [String; 4]) -> usize {
        let all = &mut self.all;
        *self.numbers.entry(look).or_insert_with_key(|look| {
            all.push(look.clone());
            all.len() - 1
        })
    }
}

/// The name of a color in the page's style sheet: `--good`.
pub(super) fn variable(color: Color) -> String {
    colors::name(color).map_or_else(|| color.to_owned(), |name| format!("--{name}"))
}

/// A number with this precision: one millionth is `1e6`.
pub(super) fn round(number: f64, parts: f64) -> f64 {
    let rounded = (number * parts).round() / parts;
    if rounded.is_finite() { rounded } else { number }
}
