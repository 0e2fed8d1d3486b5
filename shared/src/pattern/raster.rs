//! Patterns as pictures: every pixel of the projector, in bytes.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

use super::{Axis, Grid, PatternError, Rgb, identify, pairing_card, test_card};

/// Size of the projector's raster in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct RasterSize {
    /// Pixels in a line.
    pub width: u32,
    /// Lines.
    pub height: u32,
}

impl RasterSize {
    /// The length across which the lines of one direction are spread: the width for columns, the
    /// height for rows.
    #[must_use]
    pub fn along(self, axis: Axis) -> u32 {
        match axis {
            Axis::Row => self.height,
            Axis::Column => self.width,
        }
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl fmt::Display for RasterSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// Largest width or height of a raster, in pixels: above every projector on sale, below every GPU's limit.
const MAX_SIDE: u32 = 16_384;

impl FromStr for RasterSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
        text.split_once('x')
            .and_then(|(w, h)| Some(Self { width: side(w)?, height: side(h)? }))
            .ok_or_else(|| {
                format!("{text:?} is not a size: write WIDTHxHEIGHT, for example 1024x768, at most {MAX_SIDE}")
            })
    }
}

/// A picture for the projector.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Pattern {
    /// One colour all over.
    Solid {
        /// The colour.
        colour: Rgb,
    },
    /// Coded, unary or explicit lines.
    Grid(Grid),
    /// Every byte value in every channel: pixel (x, y) is (x, y, x + y) modulo 256. For checking that
    /// nothing between us and the projector changes a value.
    Ramp,
    /// A card to focus the projector by and to set its keystone.
    TestCard,
    /// A card that tells a person which output this is and how it stands.
    Identify {
        /// Text in the middle, for example the monitor's name.
        label: String,
    },
    /// A pairing code as a QR code.
    PairingCode {
        /// The code.
        text: String,
    },
}

impl Pattern {
    /// Nothing projected.
    pub const BLACK: Self = Self::Solid { colour: Rgb::BLACK };
    /// Everything projected.
    pub const WHITE: Self = Self::Solid { colour: Rgb::WHITE };

    /// The picture, every pixel.
    #[must_use]
    pub fn raster(&self, size: RasterSize) -> Raster {
        match self {
            Self::Solid { colour } => Raster::from_fn(size, |_, _| *colour),
            Self::Grid(grid) => grid_raster(grid, size),
            Self::Ramp => Raster::from_fn(size, |x, y| {
                Rgb([x, y, x + y].map(|value| (value % 256) as u8))
            }),
            Self::TestCard => test_card::raster(size),
            Self::Identify { label } => identify::raster(label, size),
            Self::PairingCode { text } => pairing_card::raster(text, size),
        }
    }
}

impl From<Grid> for Pattern {
    fn from(grid: Grid) -> Self {
        Self::Grid(grid)
    }
}

impl TryFrom<&str> for Pattern {
    type Error = PatternError;

    /// A solid colour from `#rrggbb`.
    fn try_from(colour: &str) -> Result<Self, PatternError> {
        Ok(Self::Solid {
            colour: colour.parse()?,
        })
    }
}

fn grid_raster(grid: &Grid, size: RasterSize) -> Raster {
    let columns = grid.profile(Axis::Column, size);
    let rows = grid.profile(Axis::Row, size);
    Raster::from_fn(size, |x, y| {
        columns[x as usize]
            .or(rows[y as usize])
            .unwrap_or(Rgb::BLACK)
    })
}

/// A projector picture: 3 bytes (red, green, blue) a pixel, row by row from the upper left.
#[derive(Clone, PartialEq, Eq)]
pub struct Raster {
    size: RasterSize,
    bytes: Vec<u8>,
}

impl Raster {
    /// A picture from the colour of each pixel (x, y).
    pub fn from_fn(size: RasterSize, mut colour: impl FnMut(u32, u32) -> Rgb) -> Self {
        let mut bytes = Vec::with_capacity(3 * size.pixels());
        for y in 0..size.height {
            for x in 0..size.width {
                bytes.extend(colour(x, y).0);
            }
        }
        Self { size, bytes }
    }

    /// Size in pixels.
    #[must_use]
    pub fn size(&self) -> RasterSize {
        self.size
    }

    /// All bytes, row by row: 3 x width x height.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// All bytes, given away.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// The colour of one pixel; black outside the raster.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Rgb {
        if x >= self.size.width || y >= self.size.height {
            return Rgb::BLACK;
        }
        let at = 3 * (y as usize * self.size.width as usize + x as usize);
        Rgb([self.bytes[at], self.bytes[at + 1], self.bytes[at + 2]])
    }
}

impl fmt::Debug for Raster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Raster({})", self.size)
    }
}
