//! An SVG picture while it is drawn.

use diagnostics::markup;

use super::font::Face;
use super::geometry::{Area, Spot};
use super::path::{Path, number};
use super::text::{Font, Run, Weight, runs};
use super::theme::{self, Color};

/// Which part of a text is at its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text is centered there.
    Middle,
    /// The text ends there.
    End,
}

/// The style of a text.
#[derive(Clone, Copy, Debug)]
pub struct TextStyle {
    /// Typeface and size.
    pub font: Font,
    /// The color of the letters.
    pub color: Color,
    /// Which part of the text is at its spot.
    pub anchor: Anchor,
    /// Whether the letters have a halo in the color of paper, so that they stay readable on top of lines.
    pub halo: bool,
}

impl TextStyle {
    /// Left-aligned text without halo.
    pub const fn new(font: Font, color: Color) -> Self {
        Self { font, color, anchor: Anchor::Start, halo: false }
    }

    /// The same, anchored differently.
    pub const fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same with a halo.
    pub const fn with_halo(self) -> Self {
        Self { halo: true, ..self }
    }
}

/// How the inside and the outline of a shape are painted.
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    fill: Option<Color>,
    fill_opacity: f64,
    stroke: Option<(Color, f64)>,
    stroke_opacity: f64,
    dash: Option<&'static str>,
}

impl Paint {
    /// Filled, without outline.
    pub const fn fill(color: Color) -> Self {
        Self { fill: Some(color), fill_opacity: 1.0, stroke: None, stroke_opacity: 1.0, dash: None }
    }

    /// An outline of this width in pixels, not filled; ends and corners are round.
    pub const fn stroke(color: Color, width: f64) -> Self {
        Self { fill: None, fill_opacity: 1.0, stroke: Some((color, width)), stroke_opacity: 1.0, dash: None }
    }

    /// The same with an outline.
    pub const fn outlined(self, color: Color, width: f64) -> Self {
        Self { stroke: Some((color, width)), ..self }
    }

    /// The same with this opacity of the inside (0 to 1).
    pub const fn fill_opacity(self, opacity: f64) -> Self {
        Self { fill_opacity: opacity, ..self }
    }

    /// The same with this opacity of the outline (0 to 1).
    pub const fn stroke_opacity(self, opacity: f64) -> Self {
        Self { stroke_opacity: opacity, ..self }
    }

    /// The same with a dashed outline (lengths of dashes and gaps in pixels).
    pub const fn dashed(self, dash: &'static str) -> Self {
        Self { dash: Some(dash), ..self }
    }
}

/// What will draw the letters of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Letters {
    /// The renderer, with the fonts used to measure them.
    #[default]
    Embedded,
    /// A browser, with whatever fonts it has: the length of every text is prescribed.
    Browser,
}

/// The elements of a picture so far, in drawing order. Positions are in pixels, x to the right and y downwards.
///
/// ```
/// use drawing::canvas::{Anchor, Canvas, Paint, TextStyle};
/// use drawing::text::Font;
/// use drawing::theme;
///
/// let mut canvas = Canvas::new();
/// canvas.line((10.0, 20.0), (90.0, 20.0), Paint::stroke(theme::RULE, 1.5).dashed("4 3"));
/// canvas.circle((50.0, 20.0), 6.0, Paint::fill(theme::PAPER).outlined(theme::INK, 2.0));
/// let style = TextStyle::new(Font::regular(12.0), theme::MUTED).anchored(Anchor::Middle);
/// canvas.text((50.0, 44.0), "goal", style);
/// let svg = canvas.finish(100.0, 50.0);
/// assert!(svg.starts_with("<svg") && svg.contains(">goal</text>"));
/// ```
#[derive(Debug, Default)]
pub struct Canvas {
    elements: String,
    letters: Letters,
}

impl Canvas {
    /// An empty picture for the renderer.
    pub fn new() -> Self {
        Self::default()
    }

    /// A canvas for a picture inside a web page.
    pub fn for_browsers() -> Self {
        Self { letters: Letters::Browser, ..Self::default() }
    }

    /// Draws the other canvas's picture in front of this one.
    pub fn append(&mut self, other: Self) {
        self.elements += &other.elements;
    }

    /// What has been drawn, for a picture that is assembled elsewhere.
    pub fn into_elements(self) -> String {
        self.elements
    }

    /// The finished picture, a standalone SVG of this size in pixels.
    pub fn finish(self, width: f64, height: f64) -> String {
        let (width, height) = (number(width), number(height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"{}\" stroke-linecap=\"round\" stroke-linejoin=\"round\" \
             xml:space=\"preserve\">\n{}</svg>\n",
            Face::Sans.families(),
            self.elements
        )
    }

    /// Draws a shape.
    pub fn path(&mut self, path: &Path, paint: Paint) {
        if path.data().is_empty() {
            return;
        }
        self.elements += &format!("<path d=\"{}\"", path.data());
        self.paint(paint);
        self.elements += "/>\n";
    }

    /// Draws a circle; `radius` in pixels.
    pub fn circle(&mut self, center: Spot, radius: f64, paint: Paint) {
        self.path(&Path::circle(center, radius), paint);
    }

    /// Draws a rectangle with rounded corners; `radius` in pixels.
    pub fn rounded(&mut self, area: Area, radius: f64, paint: Paint) {
        self.path(&Path::rounded(area, radius), paint);
    }

    /// Draws a straight line.
    pub fn line(&mut self, from: Spot, to: Spot, paint: Paint) {
        self.path(&Path::through([from, to]), paint);
    }

    /// Writes a text with its baseline at `at`.
    pub fn text(&mut self, at: Spot, text: &str, style: TextStyle) {
        let runs = runs(text);
        if runs.iter().all(|run| run.text.trim().is_empty()) {
            return;
        }
        if style.halo {
            let width = style.font.size * 0.34;
            let paint = format!("fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"", theme::PAPER, number(width));
            self.letters(at, &runs, style, &format!("{paint} stroke-opacity=\"0.85\""));
        }
        let color = style.color;
        let paint = match (self.letters, style.font.weight) {
            (Letters::Browser, Weight::Regular) => format!("fill=\"{color}\""),
            (Letters::Browser, Weight::Bold) => format!("fill=\"{color}\" font-weight=\"600\""),
            (Letters::Embedded, weight) => {
                let stroke = number(style.font.size * weight.stroke_em());
                format!("fill=\"{color}\" stroke=\"{color}\" stroke-width=\"{stroke}\"")
            }
        };
        self.letters(at, &runs, style, &paint);
    }

    /// Writes a text with its middle at the height of `at`.
    pub fn centered_text(&mut self, at: Spot, text: &str, style: TextStyle) {
        self.text((at.0, at.1 + style.font.baseline_below_middle()), text, style);
    }

    /// Draws what `draw` draws, clipped to `area`. `name` is the clip's id, which must be unique.
    pub fn clipped(&mut self, name: &str, area: Area, draw: impl FnOnce(&mut Self)) {
        self.elements += &format!(
            "<clipPath id=\"{name}\"><path d=\"{}\"/></clipPath><g clip-path=\"url(#{name})\">\n",
            Path::rounded(area, 0.0).data()
        );
        draw(self);
        self.elements += "</g>\n";
    }

    /// Draws what `draw` draws as a part of the picture that a page can find, by its `kind` and number.
    pub fn part(&mut self, kind: &'static str, number: usize, draw: impl FnOnce(&mut Self)) {
        if self.letters == Letters::Embedded {
            return draw(self);
        }
        self.elements += &format!("<g data-{kind}=\"{number}\">\n");
        draw(self);
        self.elements += "</g>\n";
    }

    /// Gives the part that is being drawn a text that a page shows under the pointer.
    pub fn title(&mut self, text: &str) {
        if self.letters == Letters::Browser {
            self.elements += &format!("<title>{}</title>\n", shown(text));
        }
    }

    /// Makes what has been drawn a group with this id, to which a page can refer.
    pub fn name(&mut self, id: &str) {
        self.elements = format!("<g id=\"{id}\">\n{}</g>\n", self.elements);
    }

    /// Adds path data in other coordinates; `matrix` transforms them to the page (as in SVG: a b c d e f).
    pub fn placed_path(&mut self, data: &str, matrix: [f64; 6], fill: Color) {
        if data.is_empty() {
            return;
        }
        let [a, b, c, d, e, f] = matrix;
        self.elements += &format!(
            "<path transform=\"matrix({a:.7} {b:.7} {c:.7} {d:.7} {e:.4} {f:.4})\" fill=\"{fill}\" \
             fill-rule=\"evenodd\" d=\"{data}\"/>\n"
        );
    }

    /// Writes the letters of a text.
    fn letters(&mut self, at: Spot, runs: &[Run], style: TextStyle, paint: &str) {
        match runs {
            [run @ Run { face: Face::Sans, .. }] => self.one_face(at, run, style, paint),
            runs => self.several_faces(at, runs, style, paint),
        }
    }

    fn one_face(&mut self, (x, y): Spot, run: &Run, style: TextStyle, paint: &str) {
        let anchor = match style.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (x, y, size) = (number(x), number(y), number(style.font.size));
        let (spacing, fitted, text) = (self.spacing(style.font), self.fitted(style.font, run), shown(&run.text));
        self.elements +=
            &format!("<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{anchor}{spacing}{fitted} {paint}>{text}</text>\n");
    }

    /// Each run is a separate text chunk, placed by its measured width: the renderer draws a whole chunk in the other
    /// face if the first one lacks one of its characters.
    fn several_faces(&mut self, at: Spot, runs: &[Run], style: TextStyle, paint: &str) {
        let font = style.font;
        let width: f64 = runs.iter().map(|run| font.run_width(run)).sum();
        let mut x = match style.anchor {
            Anchor::Start => at.0,
            Anchor::Middle => at.0 - width / 2.0,
            Anchor::End => at.0 - width,
        };
        let (y, size, spacing) = (number(at.1), number(font.size), self.spacing(font));
        self.elements += &format!("<text y=\"{y}\" font-size=\"{size}\"{spacing} {paint}>");
        for run in runs {
            let (start, text, fitted) = (number(x), shown(&run.text), self.fitted(font, run));
            let family = match self.letters {
                Letters::Embedded => format!(" font-family=\"{}\"", run.face.families()),
                Letters::Browser => String::new(),
            };
            self.elements += &format!("<tspan x=\"{start}\"{family}{fitted}>{text}</tspan>");
            x += font.run_width(run);
        }
        self.elements += "</text>\n";
    }

    /// Room for the strokes with which the embedded letters are drawn bold; browsers have bold letters.
    fn spacing(&self, font: Font) -> String {
        match font.weight.spacing_em() {
            ems if ems > 0.0 && self.letters == Letters::Embedded => {
                format!(" letter-spacing=\"{}\"", number(ems * font.size))
            }
            _ => String::new(),
        }
    }

    /// The measured length, to which a browser fits its own letters.
    fn fitted(&self, font: Font, run: &Run) -> String {
        match self.letters {
            Letters::Embedded => String::new(),
            Letters::Browser => {
                format!(" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\"", number(font.run_width(run)))
            }
        }
    }

    fn paint(&mut self, paint: Paint) {
        let out = &mut self.elements;
        *out += &format!(" fill=\"{}\"", paint.fill.unwrap_or("none"));
        if paint.fill_opacity < 1.0 {
            *out += &format!(" fill-opacity=\"{}\"", number(paint.fill_opacity));
        }
        if let Some((color, width)) = paint.stroke {
            *out += &format!(" stroke=\"{color}\" stroke-width=\"{}\"", number(width));
        }
        if paint.stroke_opacity < 1.0 {
            *out += &format!(" stroke-opacity=\"{}\"", number(paint.stroke_opacity));
        }
        if let Some(dash) = paint.dash {
            *out += &format!(" stroke-dasharray=\"{dash}\"");
        }
    }
}

/// A text as it is drawn: on one line, and without characters that no font has letters for.
fn shown(text: &str) -> String {
    let on_one_line =
        text.chars().map(|character| if matches!(character, '\t' | '\n' | '\r') { ' ' } else { character });
    markup::text(&on_one_line.filter(|character| !character.is_control()).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_shown_on_one_line_and_without_forbidden_characters() {
        assert_eq!(shown("a < b & \"c\" >\n'd'\u{0}\u{ffff}"), "a &lt; b &amp; \"c\" &gt; 'd'");
    }
}
