//! The stage that decodes: from crossings and colours to the decoded grid.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use shared::{
    geometry::{CameraPixel, ProjectorPixel, RigCalibration},
    pattern::{Axis, Grid, GridIndex},
};

use super::{
    DecodedCrossing, DecodedGrid, DropReason, DroppedCrossing, LinePoint, LineTrack, checks,
    code::{Code, Orientation},
    expected::ExpectedLines,
    labels::{Decoder, Label},
    links::{Link, Patch, find_patches},
    vertices::{Neighbours, Placement, find_vertices},
};
use crate::{
    Projected,
    colours::Colours,
    crossings::{Crossings, median_gap},
    densify::KnownPlaces,
    lines::Lines,
};

/// How crossings are linked and decoded.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DecodeSettings {
    /// Shortest gap between linked crossings, as a share of the gaps around it, 0.1 to 1.
    pub shortest_gap: f64,
    /// Longest gap between linked crossings, as a share of the gaps around it, 1 to 1.9.
    pub longest_gap: f64,
    /// Lead of the best place in the code over the second, in nats, 1 to 100; ln 10^4 = 9.2 is one error in
    /// ten thousand if the evidence is honest.
    pub margin_nats: f64,
    /// What cutting one link costs in belief propagation, in nats, 0.5 to 50.
    pub cut_nats: f64,
    /// Rounds of belief propagation, 1 to 200.
    pub rounds: usize,
    /// What a crossing beyond the pattern's border costs, in nats, 1 to 100.
    pub outside_nats: f64,
    /// A crossing is dropped when its own colour speaks against its patch's label by more than this, in nats.
    pub contradiction_nats: f64,
    /// Largest distance from the epipolar line (Sampson), in camera pixels, 0.5 to 50.
    pub epipolar_px: f64,
    /// White must stand out of the noise by this many standard deviations, else a line counts as too dark.
    pub dark_sigma: f64,
}

impl Default for DecodeSettings {
    fn default() -> Self {
        Self {
            shortest_gap: 0.55,
            longest_gap: 1.5,
            margin_nats: 9.2,
            cut_nats: 5.0,
            rounds: 30,
            outside_nats: 15.0,
            contradiction_nats: 6.0,
            epipolar_px: 3.0,
            dark_sigma: 1.5,
        }
    }
}

/// What the earlier stages saw of the grid.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// The lines.
    pub lines: &'a Lines,
    /// Their crossings.
    pub crossings: &'a Crossings,
    /// The evidence for their colours.
    pub colours: &'a Colours,
}

/// The codes of a pattern in all ways that it may stand in the picture.
#[derive(Debug, Clone)]
pub struct Decoding {
    /// The codes of the flat and of the steep family, in the order of [`Orientation::ALL`].
    codes: [[Code; 2]; 8],
    /// What coarser grids tell of the places on the projector.
    known: Option<KnownPlaces>,
}

impl Decoding {
    /// The codes of this grid.
    #[must_use]
    pub fn new(grid: &Grid) -> Self {
        Self {
            codes: Orientation::ALL.map(|way| Axis::BOTH.map(|family| way.code(grid, family))),
            known: None,
        }
    }

    /// Tells what is known of the places on the projector, from now on.
    pub(crate) fn expect_places(&mut self, known: KnownPlaces) {
        self.known = Some(known);
    }

    /// Decodes a picture of the grid.
    #[must_use]
    pub fn find_grid(
        &self,
        observed: Observed<'_>,
        projected: &Projected,
        calibration: Option<&RigCalibration>,
        settings: &DecodeSettings,
    ) -> DecodedGrid {
        let (links, patches) = find_patches(observed.crossings, settings);
        let reading = Reading {
            decoding: self,
            observed,
            projected,
            calibration,
            settings,
            links: &links,
        };
        let (orientation, labels) = reading.best_orientation(&patches);
        reading.finish(orientation, &labels)
    }
}

struct Reading<'a> {
    decoding: &'a Decoding,
    observed: Observed<'a>,
    projected: &'a Projected,
    calibration: Option<&'a RigCalibration>,
    settings: &'a DecodeSettings,
    links: &'a [Link],
}

type Labels = BTreeMap<usize, Label>;

impl Reading<'_> {
    /// Tries how the pattern may stand in the picture, until one explains most crossings.
    fn best_orientation(&self, patches: &[Patch]) -> (Orientation, Labels) {
        let linked: usize = patches.iter().map(|patch| patch.nodes.len()).sum();
        let mut best: Option<(usize, Orientation, Labels)> = None;
        for (orientation, codes) in Orientation::ALL.into_iter().zip(&self.decoding.codes) {
            let [flat, steep] = codes;
            let placement = self.placement(orientation);
            let epipolar = |node: usize, flat: u16, steep: u16| {
                let from = self.projector_centre(index(&placement, flat, steep)?);
                let seen = self.observed.crossings.all[node].centre;
                self.calibration?.sampson_px(seen, from)
            };
            let expected = self.decoding.known.as_ref();
            let expected = expected
                .map(|known| ExpectedLines::new(self.observed.crossings, known, &placement));
            let decoder = Decoder {
                flat,
                steep,
                colours: self.observed.colours,
                links: self.links,
                settings: self.settings,
                epipolar: self.calibration.map(|_| &epipolar as _),
                expected: expected.as_ref(),
            };
            let labels = decoder.label(patches);
            let known = labels
                .values()
                .filter(|label| matches!(label, Label::Known { .. }))
                .count();
            if best.as_ref().is_none_or(|(most, _, _)| known > *most) {
                best = Some((known, orientation, labels));
            }
            if 2 * known > linked {
                break;
            }
        }
        best.map_or(
            (Orientation::ALL[0], Labels::new()),
            |(_, orientation, labels)| (orientation, labels),
        )
    }

    fn placement(&self, orientation: Orientation) -> Placement<'_> {
        Placement {
            grid: &self.projected.pattern.coded,
            raster: self.projected.raster,
            orientation,
        }
    }

    fn finish(&self, orientation: Orientation, labels: &Labels) -> DecodedGrid {
        let crossings = self.observed.crossings;
        let placement = self.placement(orientation);
        let number = |node: usize, family: Axis| match labels.get(&node) {
            Some(&Label::Known { flat, steep, .. }) => Some(match family {
                Axis::Row => flat,
                Axis::Column => steep,
            }),
            _ => None,
        };
        let neighbours = Neighbours::new(crossings.all.len(), self.links, number);
        let mut outcome: Vec<Result<DecodedCrossing, DropReason>> = Vec::new();
        for (node, crossing) in crossings.all.iter().enumerate() {
            outcome.push(match labels.get(&node) {
                Some(&Label::Known {
                    flat,
                    steep,
                    confidence,
                }) if crossing.is_whole() => {
                    let vertices =
                        find_vertices(node, (flat, steep), crossings, &neighbours, &placement);
                    let index = index(&placement, flat, steep);
                    vertices
                        .zip(index)
                        .ok_or(DropReason::BrokenLine)
                        .map(|(vertices, index)| DecodedCrossing {
                            index,
                            centre: crossing.centre,
                            vertices,
                            confidence,
                        })
                }
                Some(Label::Known { .. }) | None => Err(DropReason::BrokenLine),
                Some(&Label::Dropped(reason)) => Err(reason),
            });
        }
        self.check_positions(&mut outcome);
        keep_one_of_each(&mut outcome);
        self.find_causes(&mut outcome);
        let tracks = self.tracks(&placement, &outcome);
        let mut grid = DecodedGrid {
            tracks,
            ..DecodedGrid::default()
        };
        for (crossing, outcome) in crossings.all.iter().zip(outcome) {
            match outcome {
                Ok(decoded) => grid.crossings.push(decoded),
                Err(reason) => grid.dropped.push(DroppedCrossing {
                    centre: crossing.centre,
                    reason,
                }),
            }
        }
        grid.crossings.sort_by_key(|crossing| crossing.index);
        grid
    }

    /// Behind a broken line or an unclear colour often stands light that was too weak or too strong.
    fn find_causes(&self, outcome: &mut [Result<DecodedCrossing, DropReason>]) {
        for (node, outcome) in outcome.iter_mut().enumerate() {
            let Err(reason @ (DropReason::BrokenLine | DropReason::AmbiguousColour)) = outcome
            else {
                continue;
            };
            let on = Axis::BOTH.map(|axis| self.observed.colours.on(axis)[node]);
            if on.iter().any(|evidence| evidence.clipped > 0.5) {
                *reason = DropReason::Clipped;
            } else if on
                .iter()
                .any(|evidence| f64::from(evidence.signal) < self.settings.dark_sigma)
            {
                *reason = DropReason::TooDark;
            }
        }
    }

    fn check_positions(&self, outcome: &mut [Result<DecodedCrossing, DropReason>]) {
        let known: Vec<usize> = (0..outcome.len()).filter(|&k| outcome[k].is_ok()).collect();
        let matches: Vec<checks::Match> = outcome
            .iter()
            .flatten()
            .map(|crossing| (crossing.centre, self.projector_centre(crossing.index)))
            .collect();
        let off = match self.calibration {
            Some(calibration) => checks::against_calibration(&matches, calibration, self.settings),
            None => checks::against_each_other(&matches, self.uncalibrated_limit_px()),
        };
        for (k, off) in known.into_iter().zip(off) {
            if off {
                outcome[k] = Err(DropReason::OffEpipolarLine);
            }
        }
    }

    /// A wrong label is off by a whole pitch at least, so a good part of it is allowed for what an uncalibrated
    /// check does not know, above all lens distortion.
    fn uncalibrated_limit_px(&self) -> f64 {
        const SHARE_OF_PITCH: f64 = 0.2;
        let crossings = self.observed.crossings;
        let [a, b] = Axis::BOTH.map(|axis| median_gap(crossings, axis));
        self.settings.epipolar_px.max(SHARE_OF_PITCH * a.min(b))
    }

    fn projector_centre(&self, index: GridIndex) -> ProjectorPixel {
        let grid = &self.projected.pattern.coded;
        let line = |axis, k: u16| {
            grid.line(axis, usize::from(k), self.projected.raster)
                .centre_px()
        };
        ProjectorPixel::new(line(Axis::Column, index.column), line(Axis::Row, index.row))
    }

    /// The tracks, cut where their line number changes between two crossings.
    fn tracks(
        &self,
        placement: &Placement<'_>,
        outcome: &[Result<DecodedCrossing, DropReason>],
    ) -> Vec<LineTrack> {
        let mut tracks = Vec::new();
        for family in Axis::BOTH {
            let axis = placement.orientation.pattern_axis(family);
            let lines = self.observed.lines.family(family);
            for (track, on) in lines.tracks.iter().zip(self.observed.crossings.on(family)) {
                let mut known = Vec::new();
                for &k in on {
                    if let Ok(crossing) = &outcome[k] {
                        let line = match axis {
                            Axis::Row => crossing.index.row,
                            Axis::Column => crossing.index.column,
                        };
                        let at = self.observed.crossings.all[k].along(family);
                        let half = half_width(crossing, axis);
                        known.push((at, line, half, crossing.confidence));
                    }
                }
                tracks.extend(stretches(track, family, axis, &known, 0.5 * lines.width_px));
            }
        }
        tracks
    }
}

/// The pattern's row and column of two lines of the picture; `None` beyond the pattern.
fn index(placement: &Placement<'_>, flat: u16, steep: u16) -> Option<GridIndex> {
    let flat = placement.pattern_number(Axis::Row, flat);
    let steep = placement.pattern_number(Axis::Column, steep);
    let (row, column) = match placement.orientation.pattern_axis(Axis::Row) {
        Axis::Row => (flat, steep),
        Axis::Column => (steep, flat),
    };
    let inside = |axis, line: u16| usize::from(line) < placement.grid.lines(axis);
    (inside(Axis::Row, row) && inside(Axis::Column, column)).then_some(GridIndex { row, column })
}

/// Half the width of a crossing's line of the given pattern axis, in camera pixels.
fn half_width(crossing: &DecodedCrossing, axis: Axis) -> f64 {
    let [upper_left, upper_right, _, lower_left] = crossing.vertices;
    let other = match axis {
        Axis::Row => lower_left,
        Axis::Column => upper_right,
    };
    0.5 * (other.x - upper_left.x).hypot(other.y - upper_left.y)
}

/// A known crossing on a track: position along, line number, half width, confidence.
type Known = (f64, u16, f64, f64);

/// One track as stretches of one line number each. Between two crossings of one number every point has
/// it; beyond the last and between different numbers none has.
fn stretches(
    track: &crate::lines::Track,
    family: Axis,
    axis: Axis,
    known: &[Known],
    half_width_px: f64,
) -> Vec<LineTrack> {
    let mut stretches: Vec<LineTrack> = Vec::new();
    let mut next = 0;
    for (k, &across) in track.across.iter().enumerate() {
        if track.strength[k] <= 0.0 {
            continue;
        }
        let along = track.along(k);
        while next < known.len() && known[next].0 < along {
            next += 1;
        }
        let (line, half_width_px, confidence) =
            match (next.checked_sub(1).map(|k| known[k]), known.get(next)) {
                (Some(a), Some(b)) if a.1 == b.1 => {
                    let share = (along - a.0) / (b.0 - a.0).max(1e-9);
                    (Some(a.1), a.2 + share * (b.2 - a.2), a.3.min(b.3))
                }
                _ => (None, half_width_px, 0.0),
            };
        let position = match family {
            Axis::Row => CameraPixel::new(along, f64::from(across)),
            Axis::Column => CameraPixel::new(f64::from(across), along),
        };
        if stretches.last().is_none_or(|stretch| stretch.line != line) {
            stretches.push(LineTrack {
                axis,
                line,
                points: Vec::new(),
            });
        }
        if let Some(stretch) = stretches.last_mut() {
            stretch.points.push(LinePoint {
                position,
                half_width_px,
                confidence,
            });
        }
    }
    stretches
}

/// Of crossings with one label the most confident stays.
fn keep_one_of_each(outcome: &mut [Result<DecodedCrossing, DropReason>]) {
    let mut best: BTreeMap<GridIndex, (usize, f64)> = BTreeMap::new();
    for k in 0..outcome.len() {
        let Ok(crossing) = &outcome[k] else { continue };
        let (index, confidence) = (crossing.index, crossing.confidence);
        let loser = match best.get(&index) {
            Some(&(_, other)) if other >= confidence => Some(k),
            Some(&(other, _)) => {
                best.insert(index, (k, confidence));
                Some(other)
            }
            None => {
                best.insert(index, (k, confidence));
                None
            }
        };
        if let Some(loser) = loser {
            outcome[loser] = Err(DropReason::OffEpipolarLine);
        }
    }
}
