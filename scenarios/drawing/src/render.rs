//! Pictures in pixels.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg;

use super::error::Error;
use super::font;
use super::geometry::Area;
use super::palette::Palette;

/// Turns SVG pictures into pixels, with the embedded fonts only: the same bytes on every machine.
///
/// Creating one reads the fonts, so reuse it.
///
/// ```
/// use drawing::canvas::{Canvas, Paint, TextStyle};
/// use drawing::text::Font;
/// use drawing::{Area, Renderer, theme};
///
/// let mut canvas = Canvas::new();
/// canvas.rounded(Area::new(4.0, 4.0, 112.0, 32.0), 8.0, Paint::fill(theme::GOOD_LIGHT));
/// canvas.centered_text((14.0, 20.0), "docked", TextStyle::new(Font::bold(16.0), theme::GOOD));
/// let svg = canvas.finish(120.0, 40.0);
///
/// let renderer = Renderer::new();
/// assert!(renderer.png(&svg)?.starts_with(b"\x89PNG"));
/// let texts = renderer.texts(&svg)?;
/// assert_eq!(texts[0].0, "docked");
/// # Ok::<(), drawing::Error>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    options: usvg::Options<'static>,
    palette: Palette,
}

impl Default for Renderer {
    fn default() -> Self {
        Self::new()
    }
}

impl Renderer {
    /// A renderer.
    #[must_use]
    pub fn new() -> Self {
        Self { options: font::options(), palette: Palette::new() }
    }

    /// The picture as a PNG file in its own size, with the palette of all pictures: all colors of soft edges would take
    /// several times the bytes.
    ///
    /// # Errors
    /// If the text is not an SVG picture, or if it is too large to be rendered.
    pub fn png(&self, svg: &str) -> Result<Vec<u8>, Error> {
        let pixels = self.pixels(svg, 1.0)?;
        Ok(rasters::encode_rgb_png(pixels.width, pixels.height, &pixels.colors))
    }

    /// All texts of the picture, each with the box around its letters in pixels, to check that nothing overlaps.
    ///
    /// # Errors
    /// If the text is not an SVG picture.
    pub fn texts(&self, svg: &str) -> Result<Vec<(String, Area)>, Error> {
        fn collect(group: &usvg::Group, found: &mut Vec<(String, Area)>) {
            for node in group.children() {
                match node {
                    usvg::Node::Group(group) => collect(group, found),
                    usvg::Node::Text(text) => {
                        let area = text.abs_bounding_box();
                        let [x, y, width, height] = [area.x(), area.y(), area.width(), area.height()].map(f64::from);
                        let content = text.chunks().iter().map(|chunk| chunk.text()).collect();
                        // The box is that of the font; letters take up the middle of it.
                        let area = Area::new(x, y + height * 0.12, width, height * 0.76);
                        // A halo is the same text at the same place.
                        if found.last().is_none_or(|(_, last)| *last != area) {
                            found.push((content, area));
                        }
                    }
                    _ => {}
                }
            }
        }
        let tree = usvg::Tree::from_str(svg, &self.options).map_err(Error::Read)?;
        let mut found = Vec::new();
        collect(tree.root(), &mut found);
        Ok(found)
    }

    /// The pixels of the picture at `scale` times its size.
    pub(super) fn pixels(&self, svg: &str, scale: f32) -> Result<Pixels, Error> {
        let tree = usvg::Tree::from_str(svg, &self.options).map_err(Error::Read)?;
        let size = tree.size().to_int_size().scale_by(scale).ok_or(Error::Size)?;
        let mut pixmap = Pixmap::new(size.width(), size.height()).ok_or(Error::Size)?;
        resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixmap.as_mut());
        let (colors, _) = pixmap.data().as_chunks::<4>();
        let colors = colors.iter().map(|&[red, green, blue, _]| self.palette.closest([red, green, blue])).collect();
        Ok(Pixels { width: size.width() as usize, height: size.height() as usize, colors })
    }
}

/// An opaque picture: red, green and blue of each pixel, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pixels {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) colors: Vec<[u8; 3]>,
}
