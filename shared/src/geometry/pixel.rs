//! Positions on the two rasters, as types of their own, so that one is never taken for the other.

use serde::{Deserialize, Serialize};

/// A position on the camera's picture, in px, edge coordinates (the first pixel's centre is at 0.5, 0.5).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CameraPixel {
    /// To the right, px.
    pub x: f64,
    /// Downwards, px.
    pub y: f64,
}

/// A position on the projector's raster, in px, edge coordinates (the first pixel's centre is at 0.5, 0.5).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ProjectorPixel {
    /// To the right, px; a column of the raster.
    pub x: f64,
    /// Downwards, px; a row of the raster.
    pub y: f64,
}

impl CameraPixel {
    /// The position (`x`, `y`) in px.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }
}

impl ProjectorPixel {
    /// The position (`x`, `y`) in px.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }
}
