//! The colors of the page, by name: a light and a dark set.
//!
//! Charts are drawn in the colors of all pictures (`drawing::theme`). On the page, each color becomes a variable, which
//! the style sheet sets for the light and the dark scheme.

use drawing::theme::{self, Color};
use maud::{Markup, PreEscaped};

/// Each color's name on the page, its light value, and its dark value.
const COLORS: [(&str, Color, Color); 22] = [
    ("page", theme::PAGE, "#11161b"),
    ("paper", theme::PAPER, "#1a2128"),
    ("rule", theme::RULE, "#313b45"),
    ("ink", theme::INK, "#e8edf2"),
    ("muted", theme::MUTED, "#a5b1bd"),
    ("line", theme::LINE, "#74818d"),
    ("unknown", theme::UNKNOWN, "#12171c"),
    ("wall", theme::WALL, "#9aa7b4"),
    ("solid", theme::SOLID, "#3a4550"),
    ("good", theme::GOOD, "#4fc489"),
    ("good-light", theme::GOOD_LIGHT, "#173a2a"),
    ("bad", theme::BAD, "#ff7d6e"),
    ("bad-light", theme::BAD_LIGHT, "#4a2320"),
    ("busy", theme::BUSY, "#f0a63a"),
    ("busy-light", theme::BUSY_LIGHT, "#42320f"),
    ("busy-dark", theme::BUSY_DARK, "#f3c27a"),
    ("idle", theme::IDLE, "#66727e"),
    ("idle-light", theme::IDLE_LIGHT, "#232b33"),
    ("laser", theme::LASER, "#6cabff"),
    ("belief", theme::BELIEF, "#4cc2d0"),
    ("body", theme::BODY, "#c79ceb"),
    ("body-light", theme::BODY_LIGHT, "#3a2a49"),
];

/// The colors of the tree's stages, first to last: most eyes can distinguish them, and they mean nothing else on the
/// map.
pub(super) const ACTIVITIES: [Color; 6] =
    [theme::LASER, theme::BUSY_DARK, theme::BODY, theme::BELIEF, theme::GOOD, theme::MUTED];

pub(super) fn activity(number: usize) -> Color {
    ACTIVITIES[number % ACTIVITIES.len()]
}

/// The style sheet's definitions of all colors.
pub(super) fn definitions() -> String {
    let set = |value: fn(&(&str, Color, Color)) -> Color| {
        let all = COLORS.iter().map(|color| format!("--{}:{}", color.0, value(color)));
        all.collect::<Vec<_>>().join(";")
    };
    let (light, dark) = (set(|color| color.1), set(|color| color.2));
    format!(
        ":root{{color-scheme:light dark;{light}}}\n\
         @media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
    )
}

/// A drawing in the colors of the page.
pub(super) fn adopted(elements: &str) -> Markup {
    let mut adopted = elements.to_owned();
    for (name, color, _) in COLORS {
        adopted = adopted.replace(&format!("\"{color}\""), &format!("\"var(--{name})\""));
    }
    PreEscaped(adopted)
}

/// The name of a color of the theme in the style sheet, without the dashes: `good`.
pub(super) fn name(color: Color) -> Option<&'static str> {
    COLORS.iter().find(|(_, light, _)| *light == color).map(|(name, ..)| *name)
}

/// A color of the theme as the style sheet has it: `var(--good)`.
pub(super) fn variable(color: Color) -> String {
    name(color).map_or_else(|| color.to_owned(), |name| format!("var(--{name})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_color_of_the_theme_has_its_own_name() {
        for color in theme::ALL.into_iter().filter(|color| *color != "#000000") {
            assert!(variable(color).starts_with("var(--"), "{color} has no name on the page");
        }
        let names: std::collections::BTreeSet<_> = COLORS.iter().map(|(name, ..)| name).collect();
        assert_eq!(names.len(), COLORS.len());
    }

    /// Contrast of two colors by WCAG 2.
    fn contrast(a: Color, b: Color) -> f64 {
        let luminance = |color: Color| {
            let [red, green, blue] = theme::rgb(color).map(|part| {
                let part = f64::from(part) / 255.0;
                if part <= 0.03928 { part / 12.92 } else { libm::pow((part + 0.055) / 1.055, 2.4) }
            });
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        a.max(b) / a.min(b)
    }

    #[test]
    fn text_is_legible_on_its_background_in_light_and_dark() {
        let of = |wanted: &str| COLORS.iter().find(|(name, ..)| *name == wanted).expect("a color of the page");
        let pairs = [
            ("ink", "paper"),
            ("ink", "page"),
            ("muted", "paper"),
            ("muted", "page"),
            ("good", "paper"),
            ("bad", "paper"),
            ("busy-dark", "paper"),
            ("ink", "good-light"),
            ("ink", "bad-light"),
            ("ink", "busy-light"),
            ("ink", "idle-light"),
            ("paper", "good"),
            ("paper", "bad"),
        ];
        let stages = ACTIVITIES.map(|color| ("paper", name(color).expect("it has a name")));
        for (front, ground) in pairs.into_iter().chain(stages) {
            let (front_colors, ground_colors) = (of(front), of(ground));
            for (a, b) in [(front_colors.1, ground_colors.1), (front_colors.2, ground_colors.2)] {
                let contrast = contrast(a, b);
                assert!(contrast >= 4.2, "{front} on {ground}: {contrast:.2}");
            }
        }
    }
}
