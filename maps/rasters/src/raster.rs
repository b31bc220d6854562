//! A decoded image, and why there is none.

use std::error::Error;
use std::io::ErrorKind;

use image::{ImageDecoder, ImageError};

/// A decoded image, row by row from the top.
#[derive(Debug, PartialEq)]
pub struct Raster {
    width: usize,
    channels: usize,
    white: u16,
    /// `width` × height × `channels` samples, each at most `white`.
    samples: Vec<u16>,
}

/// Why bytes are not an image that can be used. The message completes "the image cannot be used:".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RasterError {
    /// The first bytes are those of another format.
    #[error("it is neither PGM, PNG nor BMP")]
    Format,
    /// There are no pixels.
    #[error("it has {width} × {height} pixels")]
    Empty {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// There are more pixels than the caller allows.
    #[error("it has {width} × {height} pixels, more than the {allowed} that are allowed")]
    TooLarge {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
        /// The number of pixels that the caller allows.
        allowed: usize,
    },
    /// The file ends before the last pixel.
    #[error("it ends early")]
    Truncated,
    /// A graymap or pixmap ends before the last pixel.
    #[error("it ends early: {found} of {wanted} pixels")]
    TruncatedPixels {
        /// The complete pixels in the file.
        found: usize,
        /// The pixels that the header promises.
        wanted: usize,
    },
    /// A graymap or pixmap has a sample above the maximum that its header gives.
    #[error("it has a sample of {value}, above its maximum of {white}")]
    TooBright {
        /// The first such sample.
        value: u32,
        /// The maximum.
        white: u32,
    },
    /// The content contradicts the format.
    #[error("it is damaged: {0}")]
    Damaged(String),
}

impl Raster {
    /// Reads what the decoder's header promises.
    pub(super) fn read(decoder: impl ImageDecoder, max_pixels: usize) -> Result<Self, RasterError> {
        let (width, height) = decoder.dimensions();
        let pixels = pixel_count(width, height, max_pixels)?;
        let color = decoder.color_type();
        let channels = usize::from(color.channel_count());
        let sample_bytes = usize::from(color.bytes_per_pixel()) / channels;
        let mut bytes = vec![0; pixels * channels * sample_bytes];
        decoder.read_image(&mut bytes)?;
        let (white, samples) = match sample_bytes {
            1 => (255, bytes.into_iter().map(u16::from).collect()),
            _ => (u16::MAX, bytes.as_chunks().0.iter().map(|bytes| u16::from_ne_bytes(*bytes)).collect()),
        };
        Ok(Self { width: width as usize, channels, white, samples })
    }

    /// The same image with its samples scaled to another white.
    pub(super) fn scaled_to(self, white: u16) -> Self {
        let (old, new) = (u32::from(self.white), u32::from(white));
        let scaled = |sample: u16| ((u64::from(sample) * u64::from(new) + u64::from(old / 2)) / u64::from(old)) as u16;
        Self { white, samples: self.samples.into_iter().map(scaled).collect(), ..self }
    }

    /// Pixels per row, at least one.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows, at least one.
    #[must_use]
    pub fn height(&self) -> usize {
        self.samples.len() / (self.width * self.channels)
    }

    /// The sample that means white, or opaque.
    #[must_use]
    pub fn white(&self) -> u16 {
        self.white
    }

    /// The samples of each pixel, row by row from the top: one for gray, two for gray and alpha, three for RGB, four
    /// for RGB and alpha; each at most [`white`](Self::white).
    pub fn pixels(&self) -> impl DoubleEndedIterator<Item = &[u16]> {
        self.samples.chunks_exact(self.channels)
    }
}

/// The number of pixels of an image of this size, if it is allowed.
pub(super) fn pixel_count(width: u32, height: u32, allowed: usize) -> Result<usize, RasterError> {
    let count = usize::try_from(u64::from(width) * u64::from(height)).ok().filter(|count| *count <= allowed);
    match count {
        Some(0) => Err(RasterError::Empty { width, height }),
        Some(count) => Ok(count),
        None => Err(RasterError::TooLarge { width, height, allowed }),
    }
}

impl From<ImageError> for RasterError {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => Self::Truncated,
            // The outer error only names the format.
            error => Self::Damaged(error.source().map_or_else(|| error.to_string(), ToString::to_string)),
        }
    }
}
