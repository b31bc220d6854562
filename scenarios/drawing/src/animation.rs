//! An animation of a run, frame by frame.

use std::io::{BufWriter, Write};
use std::time::Duration;

use super::error::Error;
use super::frame::Frame;
use super::page::{self, Page};
use super::palette::{self, UNCHANGED};
use super::render::Renderer;

/// Width and height of an animation, in pixels.
pub const ANIMATION_SIZE_PX: (u16, u16) = (960, 540);

/// How long the last frame is shown before the animation starts over.
const PAUSE: Duration = Duration::from_secs(2);

/// Writes an animated GIF of 960 × 540 pixels that repeats forever, one frame at a time.
///
/// Every frame after the first contains only what has changed, and all frames have the same palette, so the file stays
/// small and no frame has to wait for another. The bytes depend only on the frames and the delay.
///
/// ```
/// # use std::sync::Arc;
/// # use drawing::{Battery, Frame, MapPicture, Scene};
/// # let map = Arc::new(MapPicture::new(&maps::house::draw()));
/// # let scene = Scene::new(map, maps::pose(0.0, 0.0, 0.0), 0.3);
/// # let mut frame = Frame {
/// #     scenario: "nominal".to_owned(), seed: 1, caption: String::new(), time: std::time::Duration::ZERO, tick: 0,
/// #     scene: Some(scene), battery: Some(Battery::default()), tree: Vec::new(), monitors: Vec::new(),
/// # };
/// use std::time::Duration;
///
/// use drawing::{GifWriter, Renderer};
///
/// let renderer = Renderer::new();
/// let mut gif = GifWriter::new(Vec::new(), Duration::from_millis(100))?;
/// for second in 0..2 {
///     frame.time = Duration::from_secs(second);
///     gif.push(&renderer, &frame)?;
/// }
/// assert!(gif.finish()?.starts_with(b"GIF89a"));
/// # Ok::<(), drawing::Error>(())
/// ```
pub struct GifWriter<W: Write> {
    encoder: gif::Encoder<BufWriter<W>>,
    /// The previous frame, one color number per pixel; empty before the first.
    shown: Vec<u8>,
    delay: u16,
}

impl<W: Write> GifWriter<W> {
    /// Begins an animation in which every frame is shown for `delay` (in hundredths of a second, and at least two,
    /// since most viewers are not faster).
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn new(writer: W, delay: Duration) -> Result<Self, Error> {
        let (width, height) = ANIMATION_SIZE_PX;
        // One palette for all frames: with one per frame, a pixel that keeps its color could change its number, and
        // every frame would have 768 more bytes.
        let mut encoder = gif::Encoder::new(BufWriter::new(writer), width, height, &palette::bytes())?;
        encoder.set_repeat(gif::Repeat::Infinite)?;
        Ok(Self { encoder, shown: Vec::new(), delay: hundredths(delay) })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`Error::Write`] if the writer fails.
    pub fn push(&mut self, renderer: &Renderer, frame: &Frame) -> Result<(), Error> {
        let (width, _) = ANIMATION_SIZE_PX;
        let scale = f32::from(width) / Page::Animation.size_px().0 as f32;
        let next = renderer.pixels(&page::draw(frame, Page::Animation), scale)?.numbers;
        self.write(&next)?;
        self.shown = next;
        Ok(())
    }

    /// Ends the animation, with two seconds for its last frame, and returns the writer.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn finish(mut self) -> Result<W, Error> {
        if !self.shown.is_empty() {
            // A frame is written before it is known to be the last, so the pause is a separate frame of one pixel.
            self.delay = hundredths(PAUSE);
            let shown = std::mem::take(&mut self.shown);
            self.shown.clone_from(&shown);
            self.write(&shown)?;
        }
        let buffered = self.encoder.into_inner()?;
        buffered.into_inner().map_err(|error| error.into_error().into())
    }

    /// Writes what has changed.
    fn write(&mut self, next: &[u8]) -> Result<(), Error> {
        let part = ChangedPart::between(&self.shown, next, usize::from(ANIMATION_SIZE_PX.0));
        let frame = gif::Frame {
            delay: self.delay,
            dispose: gif::DisposalMethod::Keep,
            transparent: Some(UNCHANGED),
            left: part.left as u16,
            top: part.top as u16,
            width: part.width as u16,
            height: part.height as u16,
            buffer: part.pixels.into(),
            ..gif::Frame::default()
        };
        Ok(self.encoder.write_frame(&frame)?)
    }
}

/// Hundredths of a second, as GIF counts time.
fn hundredths(duration: Duration) -> u16 {
    u16::try_from(duration.as_millis() / 10).unwrap_or(u16::MAX).max(2)
}

/// The smallest rectangle around everything that has changed; unchanged pixels in it are [`UNCHANGED`].
#[derive(Clone, Debug, PartialEq, Eq)]
struct ChangedPart {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl ChangedPart {
    /// The difference between two pictures of this width: all of `next` if there is no picture before it; one unchanged
    /// pixel if they are equal.
    fn between(before: &[u8], next: &[u8], width: usize) -> Self {
        if before.len() != next.len() {
            return Self { left: 0, top: 0, width, height: next.len() / width, pixels: next.to_vec() };
        }
        let rows = || before.chunks(width).zip(next.chunks(width)).enumerate();
        let mut changed = rows().filter(|(_, (old, new))| old != new).map(|(row, _)| row);
        let Some(top) = changed.next() else {
            return Self { left: 0, top: 0, width: 1, height: 1, pixels: vec![UNCHANGED] };
        };
        let bottom = changed.next_back().unwrap_or(top);
        let (mut left, mut right) = (width, 0);
        for (_, (old, new)) in rows().take(bottom + 1).skip(top) {
            let differs = |(old, new): (&u8, &u8)| old != new;
            left = left.min(old.iter().zip(new).position(differs).unwrap_or(width));
            right = right.max(old.iter().zip(new).rposition(differs).unwrap_or(0));
        }
        let pixels = rows().take(bottom + 1).skip(top).flat_map(|(_, (old, new))| {
            old[left..=right].iter().zip(&new[left..=right]).map(|(old, new)| if old == new { UNCHANGED } else { *new })
        });
        Self { left, top, width: right + 1 - left, height: bottom + 1 - top, pixels: pixels.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_has_changed_is_kept() {
        let before = [1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];
        let mut next = before;
        (next[5], next[11]) = (7, 8);
        let part = ChangedPart::between(&before, &next, 4);
        let pixels = vec![7, UNCHANGED, UNCHANGED, UNCHANGED, UNCHANGED, 8];
        assert_eq!(part, ChangedPart { left: 1, top: 1, width: 3, height: 2, pixels });
        let same = ChangedPart::between(&before, &before, 4);
        assert_eq!((same.width, same.height, same.pixels), (1, 1, vec![UNCHANGED]));
        assert_eq!(ChangedPart::between(&[], &before, 4).pixels, before);
    }

    #[test]
    fn delays_are_counted_in_hundredths() {
        assert_eq!(hundredths(Duration::from_millis(105)), 10);
        assert_eq!(hundredths(Duration::ZERO), 2);
        assert_eq!(hundredths(Duration::MAX), u16::MAX);
    }
}
