//! The stages one after another, with all that lives between frames.
//!
//! Takes the references of a scene once, then grid captures one by one; gives the decoded grid of each. Pictures
//! and evidence stay in the same memory from frame to frame. The same frames give the same grids, bit for bit,
//! on any number of threads.

mod products;

use image::RgbImage;
use shared::{
    geometry::RigCalibration,
    pattern::{RasterSize, Rgb},
};

use super::{
    PipelineError, PipelineSettings, Projected, StagePicture, StageReading, check_sizes,
    colours::{ColourBuffers, ColouredLines, Colours, find_colours, nominal_response},
    crossings::{CrossingBuffers, Crossings, find_crossings},
    densify::KnownPlaces,
    gain::{GainBuffers, GainFilter, GainImage, find_gain, merge_gains},
    grid::{DecodeBuffers, DecodedGrid, Decoding, Observed},
    line_light::LineLight,
    lines::{LineBuffers, LineScale, Lines, find_lines, find_scale},
    pictures::{self, Seen},
    reference::{References, find_references},
    response::Response,
    stale::{DarkCells, StaleTiles},
    stand_ins::{GridKind, Grids, StandIns},
};

/// Reads grid captures of one scene.
#[derive(Debug)]
pub struct Reader {
    projected: Projected,
    calibration: Option<RigCalibration>,
    settings: PipelineSettings,
    response: Response,
    references: References,
    /// Size of the references' pictures.
    size: Option<RasterSize>,
    /// Linear light of the coded grid's colours.
    colours: Vec<[f32; 3]>,
    /// Linear light of the unary grid's colour.
    unary_colour: [f32; 3],
    decoding: Decoding,
    dark_cells: DarkCells,
    stale: StaleTiles,
    stand_ins: StandIns,
    buffers: Buffers,
    grid: DecodedGrid,
    pictures: Vec<StagePicture>,
}

/// What is written anew for every frame.
#[derive(Debug, Default)]
struct Buffers {
    rows: GainBuffers,
    unary: GainImage,
    gain: GainImage,
    lines: LineBuffers,
    found_lines: Lines,
    crossings: CrossingBuffers,
    found_crossings: Crossings,
    colours: ColourBuffers,
    found_colours: Colours,
    grid: DecodeBuffers,
}

/// The light of one grid, and the filter for its lines.
struct LitGrid<'a> {
    light: LineLight<'a>,
    filter: GainFilter,
}

impl<'a> LitGrid<'a> {
    fn new(light: LineLight<'a>, colours: &[[f32; 3]], settings: &PipelineSettings) -> Self {
        Self {
            filter: GainFilter::new(&light, colours, &settings.gain),
            light,
        }
    }
}

/// The light of the grids that were captured.
struct LitGrids<'a> {
    coded: LitGrid<'a>,
    unary: Option<LitGrid<'a>>,
}

impl Buffers {
    /// Makes the gain image in which lines are looked for, `gain`, and the unary grid's; gives the lines' scale.
    fn find_gains(
        &mut self,
        grids: &LitGrids<'_>,
        pitch_widths: [f64; 2],
        settings: &PipelineSettings,
    ) -> LineScale {
        let LitGrids { coded, unary } = grids;
        let source = unary.as_ref().unwrap_or(coded);
        let source = (&source.light, &source.filter);
        let scale = find_scale(source, pitch_widths, &settings.lines, &mut self.lines);
        let bin = scale.sampling.bin;
        let mut find = |grid: &LitGrid<'_>, image| {
            find_gain(&grid.light, &grid.filter, bin, (&mut self.rows, image));
        };
        match unary {
            None => find(coded, &mut self.gain),
            Some(unary) if settings.gain.both_grids => {
                find(unary, &mut self.unary);
                find(coded, &mut self.gain);
                merge_gains(&mut self.gain, &self.unary, &settings.gain);
            }
            Some(unary) => {
                find(unary, &mut self.unary);
                self.gain.clone_from(&self.unary);
            }
        }
        scale
    }
}

impl Reader {
    /// A reader for captures under the given light, black and white projection; either may be empty.
    ///
    /// # Errors
    /// References without pixels or of different sizes.
    pub fn new(
        (black, white): (&[RgbImage], &[RgbImage]),
        projected: &Projected,
        calibration: Option<&RigCalibration>,
        settings: &PipelineSettings,
    ) -> Result<Self, PipelineError> {
        check_sizes(named(&[("black", black), ("white", white)]))?;
        let response = Response::new(&settings.response);
        let references = find_references(black, white, &response, &settings.reference);
        Ok(Self {
            dark_cells: DarkCells::new(&references),
            stale: StaleTiles::default(),
            stand_ins: StandIns::default(),
            references,
            size: black.first().or(white.first()).map(size),
            colours: nominal(projected.pattern.coded.colours()),
            unary_colour: nominal_response(projected.pattern.unary),
            decoding: Decoding::new(&projected.pattern.coded),
            projected: projected.clone(),
            calibration: calibration.cloned(),
            settings: *settings,
            response,
            buffers: Buffers::default(),
            grid: DecodedGrid::default(),
            pictures: Vec::new(),
        })
    }

    /// Tells what is known of the places on the projector, from now on.
    pub(super) fn expect_places(&mut self, known: KnownPlaces) {
        self.decoding.expect_places(known);
    }

    /// Reads one frame of the coded grid.
    ///
    /// # Errors
    /// A frame without pixels or of another size than the references.
    pub fn read(&mut self, frame: &RgbImage) -> Result<&DecodedGrid, PipelineError> {
        self.read_grids(std::slice::from_ref(frame), &[])?;
        Ok(&self.grid)
    }

    /// Reads repeated captures of the coded grid, with the geometry of the unary grid's, if there are any.
    ///
    /// # Errors
    /// No coded capture, captures without pixels or of another size than the references.
    pub fn read_grids(
        &mut self,
        coded: &[RgbImage],
        unary: &[RgbImage],
    ) -> Result<&DecodedGrid, PipelineError> {
        self.check(coded, unary)?;
        let settings = &self.settings;
        let grid = if unary.is_empty() { coded } else { unary };
        self.dark_cells
            .find_stale(&self.response, grid, &mut self.stale);
        let captured = Grids {
            coded,
            unary,
            unary_colour: self.unary_colour,
            response: &self.response,
            references: &self.references,
            stale: &self.stale,
        };
        self.stand_ins.find(&captured, settings);
        let light = |of| self.stand_ins.light(&captured, of);
        let Some(coded) = light(GridKind::Coded) else {
            return Err(PipelineError::NoCodedCapture);
        };
        let unary = light(GridKind::Unary);
        let has_unary = unary.is_some();
        let buffers = &mut self.buffers;
        let grids = LitGrids {
            coded: LitGrid::new(coded, &self.colours, settings),
            unary: unary.map(|light| LitGrid::new(light, &[self.unary_colour], settings)),
        };
        let scale = buffers.find_gains(&grids, self.projected.pitch_widths(), settings);
        let image = (&buffers.gain, settings.gain.shrink);
        let lines = (&mut buffers.lines, &mut buffers.found_lines);
        find_lines(image, &scale, &settings.lines, lines);
        let lines = &buffers.found_lines;
        let crossings = (&mut buffers.crossings, &mut buffers.found_crossings);
        find_crossings(lines, &settings.crossings, crossings);
        let crossings = &buffers.found_crossings;
        // a unary grid that stood for white says nothing about the gain any more
        let says_gain = has_unary && self.references.white.is_some();
        let seen = ColouredLines {
            light: &grids.coded.light,
            gain: says_gain.then_some(&buffers.unary),
            lines,
            crossings,
        };
        let found = (&mut buffers.colours, &mut buffers.found_colours);
        find_colours(&seen, &self.colours, &settings.colours, found);
        let observed = Observed {
            lines,
            crossings,
            colours: &buffers.found_colours,
        };
        let rig = (&self.projected, self.calibration.as_ref());
        let found = (&mut buffers.grid, &mut self.grid);
        self.decoding
            .find_grid(observed, rig, &settings.grid, found);
        if settings.pictures {
            let seen = Seen {
                references: &self.references,
                stale: &self.stale,
                coded: &grids.coded.light,
                gain: &buffers.gain,
                lines,
                grid: &self.grid,
            };
            self.pictures = pictures::draw(&seen, settings);
        }
        Ok(&self.grid)
    }

    /// What was read last, with its pictures.
    #[must_use]
    pub fn into_reading(self) -> StageReading {
        StageReading {
            grid: self.grid,
            pictures: self.pictures,
        }
    }

    fn check(&self, coded: &[RgbImage], unary: &[RgbImage]) -> Result<(), PipelineError> {
        if coded.is_empty() {
            return Err(PipelineError::NoCodedCapture);
        }
        check_sizes(named(&[("coded", coded), ("unary", unary)]))?;
        let found = size(&coded[0]);
        match self.size {
            Some(expected) if expected != found => Err(PipelineError::SizesDiffer {
                what: "coded".to_owned(),
                found,
                expected,
            }),
            _ => Ok(()),
        }
    }
}

fn size(frame: &RgbImage) -> RasterSize {
    RasterSize {
        width: frame.width(),
        height: frame.height(),
    }
}

fn named<'a>(
    kinds: &'a [(&'static str, &'a [RgbImage])],
) -> impl Iterator<Item = (&'static str, &'a RgbImage)> {
    kinds
        .iter()
        .flat_map(|&(what, frames)| frames.iter().map(move |f| (what, f)))
}

fn nominal(colours: &[Rgb]) -> Vec<[f32; 3]> {
    colours
        .iter()
        .map(|&colour| nominal_response(colour))
        .collect()
}
