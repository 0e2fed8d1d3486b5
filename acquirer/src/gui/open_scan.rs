//! A scan as the window shows it: everything a panel needs, made in the files' thread.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui::ColorImage;
use image::RgbImage;
use shared::{pattern::GridSettings, stage::Stage};

use super::live_picture::{Overlay, screen_image};
use crate::{
    config::Config,
    output::{
        Summary, colour_map::Scale, maps::shift_map, relief::mesh::Mesh, shift_table::ShiftRow,
    },
    pipeline::{
        Captures, PipelineSettings, StageReading,
        grid::{DecodedGrid, DropReason},
        read_stage,
    },
    process::{ProcessError, StepTime, process_scan, read_calibration},
    scan::{ScanError, ScanFolder, Shows, read_picture},
};

/// A byte from here on counts as clipped.
const CLIPPED_FROM: u8 = 250;

/// A picture with what is seen on it.
pub(super) type Captioned = (String, Arc<ColorImage>);

/// How good a recorded stage is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Quality {
    /// Crossings with a label.
    pub(super) labelled: usize,
    /// Crossings of the projected grid.
    pub(super) possible: usize,
    /// Crossings without a label, by reason.
    pub(super) holes: BTreeMap<DropReason, usize>,
    /// Share of the pixels that are clipped in the coded capture, in percent.
    pub(super) clipped_percent: f64,
}

impl Quality {
    /// Labelled of possible crossings, in percent.
    pub(super) fn coverage_percent(&self) -> f64 {
        100.0 * self.labelled as f64 / self.possible.max(1) as f64
    }

    /// Crossings that the picture does not show: neither read nor seen without being read.
    pub(super) fn unseen(&self) -> usize {
        let holes: usize = self.holes.values().sum();
        self.possible.saturating_sub(self.labelled + holes)
    }
}

/// One stage of a scan: what was captured, what every step made of it, and what was read.
#[derive(Debug, Clone)]
pub(super) struct StageView {
    /// Which stage.
    pub(super) stage: Stage,
    /// How good it is.
    pub(super) quality: Quality,
    /// The capture of the coded grid and the products of the steps, in the order of the pipeline.
    pub(super) steps: Vec<Captioned>,
    /// What was read.
    pub(super) grid: DecodedGrid,
    /// The same in strokes.
    pub(super) overlay: Arc<Overlay>,
    /// What was projected.
    pub(super) pattern: GridSettings,
}

impl StageView {
    /// Reads one stage of a recorded scan.
    pub(super) fn read(
        dir: &Path,
        stage: Stage,
        settings: &PipelineSettings,
    ) -> Result<Self, ProcessError> {
        let folder = ScanFolder::open(dir)?;
        let calibration = folder.calibration_path();
        let calibration = calibration
            .map(|path| read_calibration(&path))
            .transpose()?;
        let captures = folder.captures(stage)?;
        let settings = PipelineSettings {
            pictures: true,
            ..*settings
        };
        let reading = read_stage(
            &captures,
            &folder.projected(),
            calibration.as_ref(),
            &settings,
        );
        let reading = reading.map_err(|source| ProcessError::Pipeline { stage, source })?;
        Ok(Self::of(&folder, stage, reading, &captures))
    }

    fn of(folder: &ScanFolder, stage: Stage, reading: StageReading, captures: &Captures) -> Self {
        let pattern = folder.manifest().pattern.clone();
        let pictures = reading.pictures.iter();
        let products = pictures.map(|p| (caption(p.name), screen_image(&p.picture)));
        let captured = captures.prmvs.first().map(captured);
        Self {
            stage,
            quality: quality(&reading.grid, &pattern, captures.prmvs.first()),
            steps: captured.into_iter().chain(products).collect(),
            overlay: Arc::new(Overlay::of(&reading.grid, &pattern.coded)),
            grid: reading.grid,
            pattern,
        }
    }
}

fn captured(picture: &RgbImage) -> Captioned {
    let caption = "The camera's picture of the coded grid.".to_owned();
    (caption, screen_image(picture))
}

fn quality(grid: &DecodedGrid, pattern: &GridSettings, coded: Option<&RgbImage>) -> Quality {
    let holes = grid.dropped_by_reason().into_iter();
    Quality {
        labelled: grid.crossings.len(),
        possible: pattern.coded.rows() * pattern.coded.columns(),
        holes: holes.filter(|(_, count)| *count > 0).collect(),
        clipped_percent: coded.map_or(0.0, clipped_percent),
    }
}

fn clipped_percent(picture: &RgbImage) -> f64 {
    let pixels = picture.as_raw().chunks_exact(3);
    let of = pixels.len().max(1);
    let clipped = pixels.filter(|pixel| pixel.iter().any(|&byte| byte >= CLIPPED_FROM));
    100.0 * clipped.count() as f64 / of as f64
}

/// A scan that was read.
#[derive(Debug)]
pub(super) struct OpenScan {
    /// Its folder.
    pub(super) dir: PathBuf,
    /// The report.
    pub(super) report: PathBuf,
    /// Its figures.
    pub(super) summary: Summary,
    /// How long each step took.
    pub(super) times: Vec<StepTime>,
    /// What was read without and with the object.
    pub(super) stages: [Option<Arc<StageView>>; 2],
    /// How far the crossings moved, over the picture of the object.
    pub(super) shift_map: Option<Arc<ColorImage>>,
    /// The same in numbers.
    pub(super) shifts: Vec<ShiftRow>,
    /// The surface, in millimetres or camera pixels and relative depth.
    pub(super) mesh: Mesh,
    /// The colours of its depths.
    pub(super) scale: Scale,
    /// Whether it is in millimetres.
    pub(super) in_mm: bool,
    /// The scene in white light, or as it was captured.
    pub(super) picture: Option<Arc<ColorImage>>,
}

impl OpenScan {
    /// Reads a scan, writes its results, and keeps what the window shows.
    pub(super) fn read(dir: &Path, config: &Config) -> Result<Self, ProcessError> {
        let folder = ScanFolder::open(dir)?;
        let processed = process_scan(&folder, config)?;
        let result = &processed.result;
        let summary = Summary::of(&folder, result);
        let shifts: Vec<ShiftRow> = result.shifts.iter().map(ShiftRow::from).collect();
        let seen = scene(&folder)?;
        let object = result.object.as_ref().map(|reading| &reading.grid);
        let in_mm = !result.surface.is_empty();
        let mesh = match object.filter(|_| in_mm) {
            Some(grid) => Mesh::from_surface(&result.surface, grid),
            None => Mesh::from_shifts(&shifts),
        };
        let depths = mesh.nodes.iter().map(|node| node.position[2]);
        let scale = Scale::covering(depths, 0.0, if in_mm { "z / mm" } else { "rel. depth" });
        let map = seen.as_ref().filter(|_| !shifts.is_empty());
        let pictures = &processed.paths.pictures;
        Ok(Self {
            report: processed.paths.report.clone(),
            shift_map: map.map(|seen| screen_image(&shift_map(&result.shifts, seen).painted())),
            picture: seen.as_ref().map(screen_image),
            stages: [
                stage_view(
                    &folder,
                    Stage::Background,
                    result.background.as_ref(),
                    pictures,
                )?,
                stage_view(&folder, Stage::Object, result.object.as_ref(), pictures)?,
            ],
            scale: if in_mm { scale.turned() } else { scale },
            dir: dir.to_owned(),
            times: processed.times,
            summary,
            shifts,
            mesh,
            in_mm,
        })
    }

    /// The name of its folder.
    pub(super) fn name(&self) -> String {
        let name = self.dir.file_name().unwrap_or(self.dir.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// The view of one stage.
    pub(super) fn stage(&self, stage: Stage) -> Option<&Arc<StageView>> {
        self.stages[usize::from(stage == Stage::Object)].as_ref()
    }
}

/// The object in white light, or in the light of the coded grid.
fn scene(folder: &ScanFolder) -> Result<Option<RgbImage>, ScanError> {
    for (stage, shows) in [
        (Stage::Object, Shows::White),
        (Stage::Object, Shows::Prmvs),
        (Stage::Background, Shows::White),
    ] {
        if let Some(picture) = folder.first_capture(stage, shows)? {
            return Ok(Some(picture));
        }
    }
    Ok(None)
}

/// A stage whose products stand in the folder of pictures.
fn stage_view(
    folder: &ScanFolder,
    stage: Stage,
    reading: Option<&StageReading>,
    pictures: &Path,
) -> Result<Option<Arc<StageView>>, ScanError> {
    let Some(reading) = reading else {
        return Ok(None);
    };
    let coded = folder.first_capture(stage, Shows::Prmvs)?;
    let pattern = folder.manifest().pattern.clone();
    let captured = coded.as_ref().map(captured).into_iter();
    let steps = captured.chain(products(stage, pictures)?).collect();
    Ok(Some(Arc::new(StageView {
        stage,
        quality: quality(&reading.grid, &pattern, coded.as_ref()),
        steps,
        grid: reading.grid.clone(),
        overlay: Arc::new(Overlay::of(&reading.grid, &pattern.coded)),
        pattern,
    })))
}

/// The products of the steps, which were written as `object-02-gain.png`, in their order.
fn products(stage: Stage, pictures: &Path) -> Result<Vec<Captioned>, ScanError> {
    let start = format!("{stage}-");
    let entries = std::fs::read_dir(pictures).into_iter().flatten().flatten();
    let mut named: Vec<(String, PathBuf)> = entries
        .filter_map(|entry| {
            let path = entry.path();
            let stem = path.file_stem()?.to_str()?.strip_prefix(&start)?.to_owned();
            stem.starts_with(|c: char| c.is_ascii_digit())
                .then_some((stem, path))
        })
        .collect();
    named.sort();
    let products = named.into_iter().map(|(stem, path)| {
        let name = stem.trim_start_matches(|c: char| c.is_ascii_digit() || c == '-');
        Ok((caption(name), screen_image(&read_picture(&path)?)))
    });
    products.collect()
}

/// What is seen on the product of a step.
fn caption(name: &str) -> String {
    let text = match name {
        "mask" => "Mask: black is shadow, red clipped, blue has changed since the references.",
        "gain" => "Gain: the share of white light that arrives, whatever the surface's colour.",
        "lines" => {
            "Lines: the middles of rows (orange) and columns (blue), to a fraction of a pixel."
        }
        "crossings" => "Crossings: vertices of labelled ones (green), dropped ones (red).",
        other => return format!("The step \"{other}\"."),
    };
    text.to_owned()
}
