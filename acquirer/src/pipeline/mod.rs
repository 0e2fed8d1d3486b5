//! From captures to labelled vertices, shifts and surfaces. Knows no camera, window, network or clock:
//! the same captures and settings give the same result, bit for bit, on any number of threads.
//!
//! ```text
//! captures -> reference -> gain -> lines -> crossings -> grid (decoded) -> shift / surface
//! ```
//!
//! # Conventions
//! Camera positions are edge coordinates: pixel k covers [k, k + 1), its centre lies at k + 1/2; x to the
//! right, y down. Rows and columns are counted from 0. Millimetres are in the camera frame: x right,
//! y down, z forward.

pub mod thesis;

pub mod colour_choice;

pub mod grid;
pub mod result;
pub mod shift;
pub mod surface;

use image::RgbImage;
use shared::pattern::{GridSettings, RasterSize, Rgb};
use thiserror::Error;

use grid::DecodedGrid;

/// Why captures can't be read at all. A picture without a readable grid is no error but a result.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PipelineError {
    /// No picture of the coded grid.
    #[error("no capture shows the coded grid; record at least one with the PRMVS pattern on")]
    NoCodedCapture,
    /// Pictures that don't belong together.
    #[error(
        "the {what} capture has {found} px but the others have {expected} px; record all with one camera setting"
    )]
    SizesDiffer {
        /// What the capture shows, for example `white`.
        what: String,
        /// Its size.
        found: RasterSize,
        /// The size of the first capture.
        expected: RasterSize,
    },
    /// Pictures without a pixel.
    #[error("the {what} capture has no pixels")]
    Empty {
        /// What the capture shows, for example `white`.
        what: String,
    },
    /// Not enough colours to choose four from.
    #[error(
        "shots of {found} different colours, but four grid colours must be chosen; show more colours"
    )]
    TooFewColours {
        /// Different colours among the shots.
        found: usize,
    },
}

/// The pictures of one stage (without or with the object), by what the projector showed.
#[derive(Debug, Clone, Default)]
pub struct Captures {
    /// The projector showed black: ambient light only. May be empty.
    pub black: Vec<RgbImage>,
    /// The projector showed white. May be empty.
    pub white: Vec<RgbImage>,
    /// The coded grid.
    pub prmvs: Vec<RgbImage>,
    /// The single-colour grid. May be empty; the coded grid then gives the geometry as well.
    pub unary: Vec<RgbImage>,
    /// Other solid colours.
    pub solid: Vec<(Rgb, RgbImage)>,
}

/// Which reading method the pipeline uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Gain image, sub-pixel lines, likelihood colours, maximum-likelihood decoding over patches.
    #[default]
    Likelihood,
    /// The thesis of 2001: hue/saturation background, masked threshold, Sobel edges, 2 x 2 windows.
    Thesis,
}

/// What the projector showed while the captures were taken.
#[derive(Debug, Clone)]
pub struct Projected {
    /// The coded grid and its unary colour.
    pub pattern: GridSettings,
    /// The projector's raster.
    pub raster: RasterSize,
}

/// What was read from one stage.
#[derive(Debug, Clone, Default)]
pub struct StageReading {
    /// The labelled crossings, the dropped ones with their reasons, and the lines.
    pub grid: DecodedGrid,
    /// The products of the stages as pictures of the camera's size, in reading order, for the report.
    pub pictures: Vec<StagePicture>,
}

/// One stage's product as a picture that a person can look at.
#[derive(Debug, Clone)]
pub struct StagePicture {
    /// File name without ending, for example `gain`.
    pub name: &'static str,
    /// One sentence for the report: what is seen here.
    pub caption: String,
    /// The picture.
    pub picture: RgbImage,
}
