//! An animated GIF, frame by frame.

use std::io::{self, Write};
use std::time::Duration;

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, RgbaImage};

/// Writes an animated GIF that repeats forever, one frame at a time.
///
/// Every frame after the first contains only what has changed, so the file stays small. Colors are exact as long as a
/// frame has at most 255 of them. The bytes depend only on the frames and their delays.
///
/// ```
/// use std::time::Duration;
///
/// let mut gif = rasters::Animation::new(Vec::new(), 2, Duration::from_millis(100));
/// gif.push(vec![[255; 3]; 4])?;
/// gif.push(vec![[0; 3]; 4])?;
/// assert!(gif.finish(Duration::from_secs(2))?.starts_with(b"GIF89a"));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Animation<W: Write> {
    writer: W,
    width: usize,
    delay: Duration,
    /// What is on the screen; empty before the first frame.
    shown: Vec<[u8; 3]>,
}

impl<W: Write> Animation<W> {
    /// Begins an animation of this width in which every frame is shown for `delay` (in hundredths of a second, and at
    /// least two, since most viewers are not faster).
    #[must_use]
    pub fn new(writer: W, width: u16, delay: Duration) -> Self {
        Self { writer, width: width.into(), delay, shown: Vec::new() }
    }

    /// Adds a frame: red, green and blue of each pixel, row by row from the top.
    ///
    /// # Errors
    /// If the writer fails.
    ///
    /// # Panics
    /// If the frame has no rows, more than 65,535, or not as many as the first.
    pub fn push(&mut self, next: Vec<[u8; 3]>) -> io::Result<()> {
        if self.shown.is_empty() {
            let whole = ImagePart { left: 0, top: 0, width: self.width, pixels: next.iter().map(opaque).collect() };
            let file = whole.encode(self.delay);
            self.writer.write_all(&file[..file.len() - TRAILER.len()])?;
        } else {
            assert_eq!(next.len(), self.shown.len(), "all frames have the same size");
            self.write_part(ImagePart::between(&self.shown, &next, self.width), self.delay)?;
        }
        self.shown = next;
        Ok(())
    }

    /// Ends the animation: its last frame is shown for `pause` before the first one follows again. Returns the writer,
    /// to which nothing was written if there are no frames.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn finish(mut self, pause: Duration) -> io::Result<W> {
        if !self.shown.is_empty() {
            // A frame is written before it is known to be the last, so the pause is a separate frame of one pixel.
            self.write_part(ImagePart::unchanged(), pause)?;
            self.writer.write_all(TRAILER)?;
        }
        Ok(self.writer)
    }

    fn write_part(&mut self, part: ImagePart, delay: Duration) -> io::Result<()> {
        let file = part.encode(delay);
        self.writer.write_all(&file[start_of_frame(&file)..file.len() - TRAILER.len()])
    }
}

/// The byte that ends a GIF.
const TRAILER: &[u8] = b";";

/// Where the frame of a GIF with one frame begins: with the first graphic control extension, after the header and the
/// extension that makes it repeat.
fn start_of_frame(file: &[u8]) -> usize {
    const HEADER_BYTES: usize = 13;
    let blocks = &file[HEADER_BYTES..];
    let found = blocks.windows(3).position(|bytes| bytes == [0x21, 0xf9, 4]);
    HEADER_BYTES + found.expect("every encoded frame begins with a graphic control extension")
}

/// A rectangle of the screen and its new pixels. Transparent ones are unchanged.
#[derive(Clone, Debug, PartialEq, Eq)]
struct ImagePart {
    left: usize,
    top: usize,
    width: usize,
    pixels: Vec<[u8; 4]>,
}

const TRANSPARENT: [u8; 4] = [0; 4];

fn opaque([red, green, blue]: &[u8; 3]) -> [u8; 4] {
    [*red, *green, *blue, 255]
}

impl ImagePart {
    /// One pixel that changes nothing.
    fn unchanged() -> Self {
        Self { left: 0, top: 0, width: 1, pixels: vec![TRANSPARENT] }
    }

    /// The smallest rectangle around everything that differs between two frames of this width.
    fn between(before: &[[u8; 3]], next: &[[u8; 3]], width: usize) -> Self {
        let rows = || before.chunks(width).zip(next.chunks(width)).enumerate();
        let mut changed = rows().filter(|(_, (old, new))| old != new).map(|(row, _)| row);
        let Some(top) = changed.next() else { return Self::unchanged() };
        let bottom = changed.next_back().unwrap_or(top);
        let (mut left, mut right) = (width, 0);
        for (_, (old, new)) in rows().take(bottom + 1).skip(top) {
            let differs = |(old, new): (&[u8; 3], &[u8; 3])| old != new;
            left = left.min(old.iter().zip(new).position(differs).unwrap_or(width));
            right = right.max(old.iter().zip(new).rposition(differs).unwrap_or(0));
        }
        let pixels = rows().take(bottom + 1).skip(top).flat_map(|(_, (old, new))| {
            let pairs = old[left..=right].iter().zip(&new[left..=right]);
            pairs.map(|(old, new)| if old == new { TRANSPARENT } else { opaque(new) })
        });
        Self { left, top, width: right + 1 - left, pixels: pixels.collect() }
    }

    /// A GIF whose only frame is this part, at its place on the screen, to stay there when the next one is shown.
    ///
    /// The encoder of `image` puts each frame in the corner and clears it before the next, so an animation would have
    /// to consist of whole frames, which take ten times the bytes. The two fields for this are corrected here.
    fn encode(self, delay: Duration) -> Vec<u8> {
        const DISPOSAL: u8 = 0b0001_1100;
        const KEEP: u8 = 0b0000_0100;
        let (width, height) = (self.width as u32, (self.pixels.len() / self.width) as u32);
        let image = RgbaImage::from_raw(width, height, self.pixels.into_flattened()).expect("there are whole rows");
        let frame = Frame::from_parts(image, 0, 0, Delay::from_saturating_duration(at_least_two_hundredths(delay)));
        let mut file = Vec::new();
        let mut encoder = GifEncoder::new(&mut file);
        encoder.set_repeat(Repeat::Infinite).and_then(|()| encoder.encode_frame(frame)).expect("memory can be written");
        drop(encoder);
        // An extension of eight bytes, with flags in the fourth; then a separator, the left and the top edge.
        let frame = start_of_frame(&file);
        file[frame + 3] = file[frame + 3] & !DISPOSAL | KEEP;
        file[frame + 9..][..2].copy_from_slice(&(self.left as u16).to_le_bytes());
        file[frame + 11..][..2].copy_from_slice(&(self.top as u16).to_le_bytes());
        file
    }
}

/// GIF counts time in hundredths of a second, up to 655 seconds.
fn at_least_two_hundredths(delay: Duration) -> Duration {
    delay.clamp(Duration::from_millis(20), Duration::from_millis(655_350))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::AnimationDecoder;
    use image::codecs::gif::GifDecoder;
    use proptest::prelude::*;

    use super::*;

    fn decoded(file: &[u8]) -> Vec<Frame> {
        GifDecoder::new(Cursor::new(file)).unwrap().into_frames().collect_frames().unwrap()
    }

    #[test]
    fn only_what_has_changed_is_kept() {
        let before = [1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3].map(|gray| [gray; 3]);
        let mut next = before;
        (next[5], next[11]) = ([7; 3], [8; 3]);
        let unchanged = TRANSPARENT;
        let pixels = vec![[7, 7, 7, 255], unchanged, unchanged, unchanged, unchanged, [8, 8, 8, 255]];
        assert_eq!(ImagePart::between(&before, &next, 4), ImagePart { left: 1, top: 1, width: 3, pixels });
        assert_eq!(ImagePart::between(&before, &before, 4), ImagePart::unchanged());
    }

    #[test]
    fn delays_are_counted_in_hundredths() {
        let millis = Duration::from_millis;
        for (delay, counted) in
            [(millis(105), millis(100)), (Duration::ZERO, millis(20)), (Duration::MAX, millis(655_350))]
        {
            let mut gif = Animation::new(Vec::new(), 1, delay);
            gif.push(vec![[9; 3]]).unwrap();
            let frames = decoded(&gif.finish(millis(2_000)).unwrap());
            assert!(frames.iter().map(|frame| Duration::from(frame.delay())).eq([counted, millis(2_000)]));
        }
    }

    proptest! {
        #[test]
        fn the_screen_shows_each_frame_as_it_was_pushed(
            width in 1_usize..8,
            rows in 1_usize..40,
            changes in proptest::collection::vec(proptest::collection::vec((any::<prop::sample::Index>(), 0..255_u8), 0..9), 0..6),
        ) {
            let mut frame: Vec<[u8; 3]> = (0..width * rows).map(|number| [(number % 255) as u8, 7, 9]).collect();
            let mut gif = Animation::new(Vec::new(), width as u16, Duration::from_millis(50));
            gif.push(frame.clone()).unwrap();
            let mut pushed = vec![frame.clone()];
            for change in changes {
                for (place, red) in change {
                    let place = place.index(frame.len());
                    frame[place] = [red, 7, 9];
                }
                gif.push(frame.clone()).unwrap();
                pushed.push(frame.clone());
            }
            pushed.push(frame);
            let frames = decoded(&gif.finish(Duration::from_secs(2)).unwrap());
            prop_assert_eq!(frames.len(), pushed.len());
            for (shown, pushed) in frames.iter().zip(pushed) {
                let pixels: Vec<[u8; 4]> = pushed.iter().map(opaque).collect();
                prop_assert_eq!(shown.buffer().as_raw(), pixels.as_flattened());
            }
        }
    }
}
