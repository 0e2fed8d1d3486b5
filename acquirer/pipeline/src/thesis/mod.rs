//! The thesis's own reading of a stage, kept as the baseline to compare with: `--method thesis`.
//!
//! Takes the captures of one stage, gives the labelled crossings and a picture of each step. The geometry
//! comes from the unary capture, the colours from the coded one (chapter 4.3). Positions are whole pixels.
//!
//! ```text
//! background -> threshold -> edges -> corners -> lines -> reconstruct
//! ```
//!
//! Three things are added so that any input can be read: hue is averaged as an angle, a white grid may be told
//! from the background by its lightness, and a fourth vertex is completed from the other three. It fails
//! quietly where the scene's own colours shift the hue of the projected light.
//!
//! Source: the thesis, chapters 4.1 to 4.5.

pub(crate) mod hsl;

pub(crate) mod settings;

pub(crate) mod background;

pub(crate) mod threshold;

mod edges;

mod corners;

mod lines;

mod reconstruct;

mod pictures;

use image::RgbImage;
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, Rgb},
};

pub use settings::ThesisSettings;

use super::{
    Captures, PipelineError, Projected, StageReading, check_sizes,
    grid::{DecodedCrossing, DecodedGrid, DroppedCrossing, LinePoint, LineTrack},
};
use background::Background;
use corners::{Crossing, find_crossings, find_vertices, label_edges};
use edges::find_edges;
use lines::{Links, link_crossings, mend};
use reconstruct::{Label, reconstruct};
use threshold::{RecoveredGrid, find_colours, has_hue, recover_grid};

/// Reads one stage as the thesis does.
///
/// # Errors
/// [`PipelineError::NoCodedCapture`] without a capture of the coded grid, and captures without pixels or of
/// different sizes.
pub fn read_stage(
    captures: &Captures,
    projected: &Projected,
    settings: &ThesisSettings,
) -> Result<StageReading, PipelineError> {
    check_sizes(captures.named())?;
    let coded_frame = mean_frame(&captures.prmvs).ok_or(PipelineError::NoCodedCapture)?;
    let unary_frame = mean_frame(&captures.unary);
    let grid = &projected.pattern.coded;
    let background = Background::new(&captures.black);
    let recover = |frame: &RgbImage, colour: Rgb, hueless: bool| {
        let foreground = background
            .as_ref()
            .map(|background| background.foreground(frame, settings.background_sigmas, hueless));
        let everything = vec![true; frame.as_raw().len() / 3];
        let mask = foreground
            .as_ref()
            .map_or(&everything, |foreground| &foreground.mask);
        let recovered = recover_grid(frame, background.as_ref(), mask, colour);
        (recovered, foreground)
    };
    let some_hueless = grid.colours().iter().any(|colour| !has_hue(*colour));
    let (coded, coded_foreground) = recover(&coded_frame, Rgb::WHITE, some_hueless);
    let (geometry, foreground) = match &unary_frame {
        Some(frame) => {
            let colour = projected.pattern.unary;
            recover(frame, colour, !has_hue(colour))
        }
        None => (coded.clone(), coded_foreground),
    };
    let width = coded_frame.width() as usize;
    let map = find_edges(&geometry, width);
    let stripe = stripe_width(&geometry, width);
    let edges = label_edges(&map);
    let reach = (2 * stripe).clamp(4, 64) as i32;
    let vertices = find_vertices(&edges, reach);
    let crossings = find_crossings(&vertices, reach);
    let colours = find_colours(&coded_frame, &coded, grid.colours());
    let mut links = link_crossings(
        &crossings,
        &mend(&edges, &vertices, stripe as i32),
        &colours,
    );
    links.keep_squares();
    let labels = reconstruct(&mut links, grid);
    let decoded = decoded_grid(&crossings, &links, &labels);
    let shown = pictures::Steps {
        foreground: foreground.as_ref(),
        colours: &colours,
        palette: grid.colours(),
        edges: &map,
        crossings: &crossings,
        links: &links,
        labels: &labels,
    };
    Ok(StageReading {
        pictures: shown.pictures(coded_frame.dimensions()),
        grid: decoded,
    })
}

/// The usual width of a stripe in pixels: the median of the shorter of a pixel's two runs.
fn stripe_width(grid: &RecoveredGrid, width: usize) -> usize {
    let count = grid.light.len();
    let run = |at: usize, step: usize, room: usize| {
        (0..room.min(64))
            .take_while(|k| grid.covers(at + k * step))
            .count()
    };
    let mut widths: Vec<usize> = Vec::new();
    for at in 0..count {
        // the first pixel of a run across, or of a run down
        let across = at % width == 0 || !grid.covers(at - 1);
        let down = at < width || !grid.covers(at - width);
        if grid.covers(at) && (across || down) {
            let along = run(at, 1, width - at % width);
            let below = run(at, width, (count - at).div_ceil(width));
            widths.push(along.min(below));
        }
    }
    widths.sort_unstable();
    widths.get(widths.len() / 2).copied().unwrap_or(2)
}

/// The mean of repeated frames of one size; `None` without frames.
fn mean_frame(frames: &[RgbImage]) -> Option<RgbImage> {
    let first = frames.first()?;
    if frames.len() == 1 {
        return Some(first.clone());
    }
    let count = frames.len() as u32;
    let mut mean = first.clone();
    for (at, byte) in mean.iter_mut().enumerate() {
        let sum: u32 = frames
            .iter()
            .map(|frame| u32::from(frame.as_raw()[at]))
            .sum();
        *byte = ((sum + count / 2) / count) as u8;
    }
    Some(mean)
}

fn decoded_grid(
    crossings: &[Crossing],
    links: &Links,
    labels: &[Result<Label, super::grid::DropReason>],
) -> DecodedGrid {
    let mut decoded = DecodedGrid::default();
    for (crossing, label) in crossings.iter().zip(labels) {
        let [x, y] = crossing.centre();
        let centre = CameraPixel::new(x, y);
        match label {
            Ok(label) => decoded.crossings.push(DecodedCrossing {
                index: label.index,
                centre,
                vertices: crossing.corners.map(middle_of),
                confidence: label.agreement,
            }),
            Err(reason) => decoded.dropped.push(DroppedCrossing {
                centre,
                reason: *reason,
            }),
        }
    }
    decoded.crossings.sort_by_key(|crossing| crossing.index);
    for axis in Axis::BOTH {
        decoded
            .tracks
            .extend(tracks(crossings, links, labels, axis));
    }
    decoded
}

fn middle_of([x, y]: [i32; 2]) -> CameraPixel {
    CameraPixel::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// The chains of linked crossings of one direction.
fn tracks(
    crossings: &[Crossing],
    links: &Links,
    labels: &[Result<Label, super::grid::DropReason>],
    axis: Axis,
) -> Vec<LineTrack> {
    let next = match axis {
        Axis::Row => &links.right,
        Axis::Column => &links.down,
    };
    let mut is_start = vec![true; crossings.len()];
    for link in next.iter().flatten() {
        is_start[link.to] = false;
    }
    let mut tracks = Vec::new();
    for start in (0..crossings.len()).filter(|&k| is_start[k] && next[k].is_some()) {
        let mut points = Vec::new();
        let mut at = Some(start);
        while let Some(k) = at {
            let confidence = labels[k].map_or(0.0, |label| label.agreement);
            points.push(line_point(&crossings[k], axis, confidence));
            at = next[k].map(|link| link.to);
        }
        let line = labels[start].ok().map(|label| match axis {
            Axis::Row => label.index.row,
            Axis::Column => label.index.column,
        });
        tracks.push(LineTrack { axis, line, points });
    }
    tracks
}

fn line_point(crossing: &Crossing, axis: Axis, confidence: f64) -> LinePoint {
    let [x, y] = crossing.centre();
    let [upper_left, _, lower_right, _] = crossing.corners;
    let across = match axis {
        Axis::Row => lower_right[1] - upper_left[1],
        Axis::Column => lower_right[0] - upper_left[0],
    };
    LinePoint {
        position: CameraPixel::new(x, y),
        half_width_px: f64::from(across.abs()) / 2.0,
        confidence,
    }
}
