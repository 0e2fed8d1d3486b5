//! Where each line and each vertex of a grid lies on the projector's raster.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Axis, Grid, RasterSize, Rgb};
use crate::geometry::ProjectorPixel;

/// A crossing of the grid: row and column, both counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct GridIndex {
    /// Row, counted downwards.
    pub row: u16,
    /// Column, counted to the right.
    pub column: u16,
}

impl GridIndex {
    /// The number of the row, or of the column.
    #[must_use]
    pub fn line(self, axis: Axis) -> u16 {
        match axis {
            Axis::Row => self.row,
            Axis::Column => self.column,
        }
    }
}

/// One of the four vertices of a crossing, as seen on the projector's picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Corner {
    /// Upper edge of the row, left edge of the column.
    UpperLeft,
    /// Upper edge of the row, right edge of the column.
    UpperRight,
    /// Lower edge of the row, right edge of the column.
    LowerRight,
    /// Lower edge of the row, left edge of the column.
    LowerLeft,
}

impl Corner {
    /// All four, clockwise from the upper left.
    pub const ALL: [Self; 4] = [
        Self::UpperLeft,
        Self::UpperRight,
        Self::LowerRight,
        Self::LowerLeft,
    ];

    /// The name used in result files, for example `UPPER_LEFT`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::UpperLeft => "UPPER_LEFT",
            Self::UpperRight => "UPPER_RIGHT",
            Self::LowerRight => "LOWER_RIGHT",
            Self::LowerLeft => "LOWER_LEFT",
        }
    }

    /// Whether it lies on the right edge of the column.
    #[must_use]
    pub fn is_right(self) -> bool {
        matches!(self, Self::UpperRight | Self::LowerRight)
    }

    /// Whether it lies on the lower edge of the row.
    #[must_use]
    pub fn is_lower(self) -> bool {
        matches!(self, Self::LowerRight | Self::LowerLeft)
    }
}

impl fmt::Display for Corner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The pixels a line covers across its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSpan {
    /// First pixel covered; negative where the line sticks out of the raster.
    pub start_px: i64,
    /// Number of pixels covered.
    pub width_px: u32,
    /// The nominal centre (k + 1/2) x size / lines, in edge coordinates.
    pub nominal_centre_px: f64,
}

impl LineSpan {
    /// First edge, in edge coordinates.
    #[must_use]
    pub fn low_px(self) -> f64 {
        self.start_px as f64
    }

    /// Second edge, in edge coordinates.
    #[must_use]
    pub fn high_px(self) -> f64 {
        self.low_px() + f64::from(self.width_px)
    }

    /// Centre of the pixels really covered, in edge coordinates; within half a pixel of the nominal one.
    #[must_use]
    pub fn centre_px(self) -> f64 {
        self.low_px() + f64::from(self.width_px) / 2.0
    }
}

impl Grid {
    /// The pixels that line `k` covers on a raster; lines beyond the last continue the spacing.
    #[must_use]
    pub fn line(&self, axis: Axis, k: usize, size: RasterSize) -> LineSpan {
        let lines = self.lines(axis) as i64;
        let length = i64::from(size.along(axis));
        let width = i64::from(self.width_px(axis));
        let twice_k = 2 * k as i64 + 1;
        // round((k + 1/2) L/n - w/2), halves up, in whole numbers: no rounding error on either side
        let start_px = (twice_k * length - width * lines + lines).div_euclid(2 * lines);
        LineSpan {
            start_px,
            width_px: self.width_px(axis),
            nominal_centre_px: twice_k as f64 * length as f64 / (2 * lines) as f64,
        }
    }

    /// Where a vertex of a crossing lies on the projector's raster, in edge coordinates.
    #[must_use]
    pub fn vertex(&self, index: GridIndex, corner: Corner, size: RasterSize) -> ProjectorPixel {
        let column = self.line(Axis::Column, usize::from(index.column), size);
        let row = self.line(Axis::Row, usize::from(index.row), size);
        ProjectorPixel {
            x: if corner.is_right() {
                column.high_px()
            } else {
                column.low_px()
            },
            y: if corner.is_lower() {
                row.high_px()
            } else {
                row.low_px()
            },
        }
    }

    /// Distance from one line to the next, in projector pixels.
    #[must_use]
    pub fn pitch_px(&self, axis: Axis, size: RasterSize) -> f64 {
        f64::from(size.along(axis)) / self.lines(axis) as f64
    }

    /// The colour of the line that covers each pixel along one direction, `None` between the lines.
    ///
    /// For [`Axis::Column`] it has `size.width` entries, for [`Axis::Row`] `size.height`. A pixel of the
    /// picture shows its column's colour, else its row's colour, else black. Where lines of one family
    /// overlap, because they are wider than their pitch, the later line is on top.
    #[must_use]
    pub fn profile(&self, axis: Axis, size: RasterSize) -> Vec<Option<Rgb>> {
        let length = size.along(axis) as usize;
        let mut profile = vec![None; length];
        for k in 0..self.lines(axis) {
            let span = self.line(axis, k, size);
            let clamp = |edge: i64| edge.clamp(0, length as i64) as usize;
            let covered = clamp(span.start_px)..clamp(span.start_px + i64::from(span.width_px));
            profile[covered].fill(self.line_colour(axis, k));
        }
        profile
    }

    /// What an operator should know before this grid goes on a raster of this size: lines that touch,
    /// and lines too fine for most cameras. Empty when all is well.
    #[must_use]
    pub fn warnings(&self, size: RasterSize) -> Vec<String> {
        let mut warnings = Vec::new();
        for axis in Axis::BOTH {
            let (pitch, width) = (self.pitch_px(axis, size), self.width_px(axis));
            let name = match axis {
                Axis::Row => "row",
                Axis::Column => "column",
            };
            if f64::from(width) >= pitch {
                warnings.push(format!(
                    "{name}s touch: {width} px wide every {pitch:.1} px; choose a width below \
                     {:.0} px or fewer {name}s",
                    pitch.floor()
                ));
            } else if f64::from(width) > pitch / 2.0 {
                warnings.push(format!(
                    "{name}s fill more than half of their {pitch:.1} px pitch; a width of at most \
                     {:.0} px leaves dark cells to measure the ambient light in",
                    (pitch / 2.0).floor().max(1.0)
                ));
            }
        }
        warnings
    }
}
