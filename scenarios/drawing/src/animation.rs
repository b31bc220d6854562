//! An animation of a run, frame by frame.

use std::io::Write;
use std::time::Duration;

use rasters::Animation;

use super::error::Error;
use super::frame::Frame;
use super::page::{self, Page};
use super::render::Renderer;

/// Width and height of an animation, in pixels.
pub const ANIMATION_SIZE_PX: (u16, u16) = (960, 540);

/// How long the last frame is shown before the animation starts over.
const PAUSE: Duration = Duration::from_secs(2);

/// Writes an animated GIF of 960 × 540 pixels that repeats forever, one frame at a time.
///
/// Every frame after the first contains only what has changed, so the file stays small. The bytes depend only on the
/// frames and the delay.
///
/// ```
/// # use std::sync::Arc;
/// # use drawing::{BatteryHistory, Frame, MapPicture, Scene};
/// # let map = Arc::new(MapPicture::new(&maps::house::map()));
/// # let scene = Scene::new(map, maps::pose(0.0, 0.0, 0.0), 0.3);
/// # let mut frame = Frame {
/// #     scenario: "nominal".to_owned(), seed: Some(1), caption: String::new(),
/// #     time: std::time::Duration::ZERO, tick: Some(0),
/// #     scene: Some(scene), battery: Some(BatteryHistory::default()), tree: Vec::new(), monitors: Vec::new(),
/// # };
/// use std::time::Duration;
///
/// use drawing::{GifWriter, Renderer};
///
/// let renderer = Renderer::new();
/// let mut gif = GifWriter::new(Vec::new(), Duration::from_millis(100));
/// for second in 0..2 {
///     frame.time = Duration::from_secs(second);
///     gif.push(&renderer, &frame)?;
/// }
/// assert!(gif.finish()?.starts_with(b"GIF89a"));
/// # Ok::<(), drawing::Error>(())
/// ```
#[derive(Debug)]
pub struct GifWriter<W: Write> {
    animation: Animation<W>,
}

impl<W: Write> GifWriter<W> {
    /// Begins an animation in which every frame is shown for `delay` (in hundredths of a second, and at least two,
    /// since most viewers are not faster).
    #[must_use]
    pub fn new(writer: W, delay: Duration) -> Self {
        Self { animation: Animation::new(writer, ANIMATION_SIZE_PX.0, delay) }
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`Error::Write`] if the writer fails.
    pub fn push(&mut self, renderer: &Renderer, frame: &Frame) -> Result<(), Error> {
        let (width, _) = ANIMATION_SIZE_PX;
        let scale = f32::from(width) / Page::Animation.size_px().0 as f32;
        Ok(self.animation.push(renderer.pixels(&page::draw(frame, Page::Animation), scale)?.colors)?)
    }

    /// Ends the animation, with two seconds for its last frame, and returns the writer.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn finish(self) -> Result<W, Error> {
        Ok(self.animation.finish(PAUSE)?)
    }
}
