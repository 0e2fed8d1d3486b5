//! The stage that decodes: from crossings and colours to the decoded grid.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use shared::{
    geometry::{ProjectorPixel, RigCalibration},
    pattern::{Axis, Grid, GridIndex},
};

use super::{
    DecodedCrossing, DecodedGrid, DropReason, DroppedCrossing, LineTrack,
    checks::{Geometry, Match},
    code::{Code, Orientation},
    expected::ExpectedLines,
    labels::{Decoder, EpipolarDistance, Label},
    links::{Link, Patch, find_patches, neighbouring_links, regular_links},
    rest::{Numbers, label_rest},
    stretches::find_stretches,
    vertices::{Neighbours, Placement, find_vertices},
};
use crate::{
    Projected,
    colours::Colours,
    crossings::{Crossing, Crossings},
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

    pub(super) fn codes_of(&self, orientation: Orientation) -> [&Code; 2] {
        let same = Orientation::ALL.iter().zip(&self.codes);
        let mut same = same.filter(|(way, _)| **way == orientation);
        same.next()
            .map_or(self.codes[0].each_ref(), |(_, codes)| codes.each_ref())
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
        let links = regular_links(observed.crossings, settings);
        let (closed, patches) = find_patches(&links, observed.crossings.all.len());
        let reading = Reading {
            decoding: self,
            observed,
            projected,
            calibration,
            settings,
            links: &links,
            closed: &closed,
            gaps_px: observed.crossings.gaps_px,
        };
        let (orientation, labels) = reading.best_orientation(&patches);
        reading.finish(orientation, labels)
    }
}

pub(super) struct Reading<'a> {
    pub(super) decoding: &'a Decoding,
    pub(super) observed: Observed<'a>,
    pub(super) projected: &'a Projected,
    pub(super) calibration: Option<&'a RigCalibration>,
    pub(super) settings: &'a DecodeSettings,
    /// All links between neighbours.
    pub(super) links: &'a [Link],
    /// Those of closed cells.
    pub(super) closed: &'a [Link],
    /// Typical gap between crossings along flat and along steep lines, camera px.
    pub(super) gaps_px: [f64; 2],
}

pub(super) type Labels = BTreeMap<usize, Label>;

/// What has become of a crossing.
pub(super) type Outcome = Result<DecodedCrossing, DropReason>;

impl Reading<'_> {
    /// Tries how the pattern may stand in the picture, until one explains most crossings.
    fn best_orientation(&self, patches: &[Patch]) -> (Orientation, Labels) {
        let linked: usize = patches.iter().map(|patch| patch.nodes.len()).sum();
        let mut best: Option<(usize, Orientation, Labels)> = None;
        for (orientation, codes) in Orientation::ALL.into_iter().zip(&self.decoding.codes) {
            let geometry = self
                .calibration
                .map(|rig| Geometry::of_rig(rig, self.settings));
            let placement = self.placement(orientation);
            let epipolar = geometry.as_ref().map(|g| self.distance(&placement, g));
            let expected = self.expected_lines(&placement);
            let decoder = Decoder {
                codes: codes.each_ref(),
                colours: self.observed.colours,
                links: self.closed,
                settings: self.settings,
                epipolar: epipolar.as_deref(),
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
            gaps_px: self.gaps_px,
        }
    }

    /// The lines that the crossings should lie on, as far as coarser grids tell.
    fn expected_lines(&self, placement: &Placement<'_>) -> Option<ExpectedLines> {
        let known = self.decoding.known.as_ref()?;
        Some(ExpectedLines::new(
            self.observed.crossings,
            known,
            placement,
        ))
    }

    /// How far a crossing lies from the epipolar line of a flat and a steep line's numbers.
    fn distance<'a>(
        &'a self,
        placement: &'a Placement<'_>,
        geometry: &'a Geometry<'_>,
    ) -> Box<EpipolarDistance<'a>> {
        Box::new(move |node, flat, steep| {
            let from = self.projector_centre(index(placement, flat, steep)?);
            geometry.distance((self.observed.crossings.all[node].centre, from))
        })
    }

    fn finish(&self, orientation: Orientation, mut labels: Labels) -> DecodedGrid {
        let crossings = self.observed.crossings;
        let placement = self.placement(orientation);
        let mut outcome = self.place(&placement, &labels);
        let geometry = self.geometry(&outcome);
        self.check_positions(&geometry, &mut outcome);
        if self.stand_apart()
            && geometry.is_known()
            && self.label_rest(&placement, &geometry, &outcome, &mut labels)
        {
            outcome = self.place(&placement, &labels);
            self.check_positions(&geometry, &mut outcome);
        }
        self.keep_one_of_each(&mut outcome);
        self.find_contradictions(orientation, &labels, &mut outcome);
        let mut grid = DecodedGrid {
            tracks: self.tracks(&placement, &outcome),
            ..DecodedGrid::default()
        };
        let neighbours = self.neighbours(&labels);
        let before_edge = self.before_an_edge(&placement, &outcome);
        for (node, (crossing, outcome)) in crossings.all.iter().zip(&mut outcome).enumerate() {
            let whole = crossing.is_whole() && neighbours.on_both_lines(node);
            if let Ok(decoded) = outcome
                && (!whole || before_edge[node])
            {
                grid.partial.push(decoded.clone());
                *outcome = Err(DropReason::BrokenLine);
            }
        }
        self.find_causes(&mut outcome);
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

    /// Every crossing with its label's place in the pattern and its vertices.
    fn place(&self, placement: &Placement<'_>, labels: &Labels) -> Vec<Outcome> {
        let crossings = self.observed.crossings;
        let neighbours = self.neighbours(labels);
        let place = |(node, crossing): (usize, &Crossing)| match labels.get(&node) {
            Some(&Label::Known {
                flat,
                steep,
                confidence,
            }) => {
                let vertices =
                    find_vertices(node, (flat, steep), crossings, &neighbours, placement);
                let index = index(placement, flat, steep);
                index
                    .ok_or(DropReason::NotInCode)
                    .map(|index| DecodedCrossing {
                        index,
                        centre: crossing.centre,
                        vertices,
                        confidence,
                    })
            }
            Some(&Label::Dropped(reason)) => Err(reason),
            None => Err(DropReason::BrokenLine),
        };
        crossings.all.iter().enumerate().map(place).collect()
    }

    /// The neighbours of each crossing whose labels agree.
    fn neighbours(&self, labels: &Labels) -> Neighbours {
        let crossings = self.observed.crossings;
        let links = neighbouring_links(self.links, labels, crossings, self.settings);
        Neighbours::new(crossings.all.len(), links.into_iter())
    }

    /// Labels what the patches left, if anything.
    fn label_rest(
        &self,
        placement: &Placement<'_>,
        geometry: &Geometry<'_>,
        outcome: &[Outcome],
        labels: &mut Labels,
    ) -> bool {
        let known: Vec<Option<Numbers>> = (0..outcome.len())
            .map(|node| match labels.get(&node) {
                Some(&Label::Known { flat, steep, .. }) if outcome[node].is_ok() => {
                    Some((flat.into(), steep.into()))
                }
                _ => None,
            })
            .collect();
        let codes = self.decoding.codes_of(placement.orientation);
        let epipolar = self.distance(placement, geometry);
        let expected = self.expected_lines(placement);
        let decoder = Decoder {
            codes,
            colours: self.observed.colours,
            links: self.links,
            settings: self.settings,
            epipolar: Some(&*epipolar),
            expected: expected.as_ref(),
        };
        let more = label_rest(&decoder, &known, self.links);
        let any = !more.is_empty();
        labels.extend(more);
        any
    }

    fn geometry(&self, outcome: &[Outcome]) -> Geometry<'_> {
        if let Some(rig) = self.calibration {
            return Geometry::of_rig(rig, self.settings);
        }
        let matches: Vec<Match> = outcome.iter().flatten().map(|c| self.matched(c)).collect();
        Geometry::of_labels(&matches, self.uncalibrated_limit_px())
    }

    fn matched(&self, crossing: &DecodedCrossing) -> Match {
        (crossing.centre, self.projector_centre(crossing.index))
    }

    fn tracks(&self, placement: &Placement<'_>, outcome: &[Outcome]) -> Vec<LineTrack> {
        let of_family = |family| {
            let axis = placement.orientation.pattern_axis(family);
            let lines = self.observed.lines.family(family);
            find_stretches((family, axis), lines, self.observed.crossings, outcome)
        };
        Axis::BOTH.into_iter().flat_map(of_family).collect()
    }

    fn check_positions(&self, geometry: &Geometry<'_>, outcome: &mut [Outcome]) {
        for outcome in outcome {
            if let Ok(crossing) = outcome
                && geometry.contradicts(self.matched(crossing))
            {
                *outcome = Err(DropReason::OffEpipolarLine);
            }
        }
    }

    /// Whether the lines stand so far apart that the distance from an epipolar line tells neighbours apart.
    fn stand_apart(&self) -> bool {
        const SHARE_OF_PITCH: f64 = 0.25;
        let [a, b] = self.gaps_px;
        self.settings.epipolar_px <= SHARE_OF_PITCH * a.min(b)
    }

    /// A wrong label is off by a whole pitch at least, so a good part of it is allowed for what an uncalibrated
    /// check does not know, above all lens distortion.
    fn uncalibrated_limit_px(&self) -> f64 {
        const SHARE_OF_PITCH: f64 = 0.2;
        let [a, b] = self.gaps_px;
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
