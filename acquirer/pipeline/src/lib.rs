//! From captures to labelled vertices, shifts and surfaces. A crate of its own, so that the compiler sees to it that
//! it knows no camera, window, network or clock: the same captures and settings give the same result, bit for bit, on
//! any number of threads.
//!
//! ```text
//! captures -> reference, line_light -> gain -> lines -> crossings -> grid (decoded) -> shift / surface
//! ```
//!
//! # Conventions
//! Camera positions are edge coordinates: pixel k covers [k, k + 1), its centre lies at k + 1/2; x to the
//! right, y down. Rows and columns are counted from 0. Millimetres are in the camera frame: x right,
//! y down, z forward.

pub mod channels;
pub mod plane;

pub mod response;

pub mod reference;

pub mod subtraction;

pub mod line_light;

pub mod gain;

pub mod lines;

pub mod crossings;

pub mod colours;

pub mod grid;

pub mod dense;

pub mod shift;

pub mod surface;

pub mod result;

pub mod densify;

mod levels;
mod pictures;
mod reader;
mod region;
mod settings;
mod spare;
mod stale;
mod stand_ins;
mod tiles;
mod wide;

pub mod thesis;

pub mod colour_choice;

use image::RgbImage;
use shared::{
    geometry::RigCalibration,
    pattern::{Axis, GridSettings, RasterSize},
};
use thiserror::Error;

use grid::DecodedGrid;

pub use reader::Reader;
pub use settings::PipelineSettings;
pub use surface::find_surface;

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
}

impl Captures {
    /// Every capture with what it shows.
    pub(crate) fn named(&self) -> impl Iterator<Item = (String, &RgbImage)> {
        let known = [
            ("coded", &self.prmvs),
            ("unary", &self.unary),
            ("black", &self.black),
            ("white", &self.white),
        ];
        known
            .into_iter()
            .flat_map(|(what, frames)| frames.iter().map(move |frame| (what.to_owned(), frame)))
    }
}

/// Checks that captures have pixels and are all of one size.
///
/// # Errors
/// [`PipelineError::Empty`] or [`PipelineError::SizesDiffer`] with the first one that fails.
pub(crate) fn check_sizes<'a, W: Into<String>>(
    captures: impl Iterator<Item = (W, &'a RgbImage)>,
) -> Result<(), PipelineError> {
    let mut expected = None;
    for (what, frame) in captures {
        let found = RasterSize {
            width: frame.width(),
            height: frame.height(),
        };
        if found.pixels() == 0 {
            let what = what.into();
            return Err(PipelineError::Empty { what });
        }
        let expected = *expected.get_or_insert(found);
        if found != expected {
            return Err(PipelineError::SizesDiffer {
                what: what.into(),
                found,
                expected,
            });
        }
    }
    Ok(())
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

impl Method {
    /// The word for it on the command line and in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Likelihood => "likelihood",
            Self::Thesis => "thesis",
        }
    }
}

/// What the projector showed while the captures were taken.
#[derive(Debug, Clone)]
pub struct Projected {
    /// The coded grid and its unary colour.
    pub pattern: GridSettings,
    /// The projector's raster.
    pub raster: RasterSize,
}

impl Projected {
    /// The pitches of rows and columns in widths of their lines.
    #[must_use]
    pub fn pitch_widths(&self) -> [f64; 2] {
        let grid = &self.pattern.coded;
        Axis::BOTH
            .map(|axis| grid.pitch_px(axis, self.raster) / f64::from(grid.width_px(axis).max(1)))
    }
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

/// Reads the grid in the captures of one stage. With a calibration the labels are checked against its
/// epipolar geometry, else against each other.
///
/// # Errors
/// No capture of the coded grid, a capture without pixels, or captures of different sizes.
pub fn read_stage(
    captures: &Captures,
    projected: &Projected,
    calibration: Option<&RigCalibration>,
    settings: &PipelineSettings,
) -> Result<StageReading, PipelineError> {
    if settings.method == Method::Thesis {
        return read_as_the_thesis(captures, projected, settings);
    }
    let mut reader = stage_reader(captures, projected, calibration, settings)?;
    reader.read_grids(&captures.prmvs, &captures.unary)?;
    Ok(reader.into_reading())
}

/// As [`read_stage`], in less memory: of black and of white only the first capture stays when their light has been
/// averaged.
///
/// # Errors
/// As [`read_stage`].
pub fn read_stage_sparingly(
    captures: &mut Captures,
    projected: &Projected,
    calibration: Option<&RigCalibration>,
    settings: &PipelineSettings,
) -> Result<StageReading, PipelineError> {
    if settings.method == Method::Thesis {
        return read_as_the_thesis(captures, projected, settings);
    }
    let mut reader = stage_reader(captures, projected, calibration, settings)?;
    captures.black.truncate(1);
    captures.white.truncate(1);
    reader.read_grids(&captures.prmvs, &captures.unary)?;
    Ok(reader.into_reading())
}

fn read_as_the_thesis(
    captures: &Captures,
    projected: &Projected,
    settings: &PipelineSettings,
) -> Result<StageReading, PipelineError> {
    let mut reading = thesis::read_stage(captures, projected, &settings.thesis)?;
    if !settings.pictures {
        reading.pictures.clear();
    }
    Ok(reading)
}

/// A reader that knows the stage's references.
fn stage_reader(
    captures: &Captures,
    projected: &Projected,
    calibration: Option<&RigCalibration>,
    settings: &PipelineSettings,
) -> Result<Reader, PipelineError> {
    check_sizes(captures.named())?;
    if captures.prmvs.is_empty() {
        return Err(PipelineError::NoCodedCapture);
    }
    let references = (&captures.black[..], &captures.white[..]);
    Reader::new(references, projected, calibration, settings)
}
