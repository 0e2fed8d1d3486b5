//! How good a reading is, where the truth is known: simulated and recorded test scenes.
//!
//! Takes true and read vertices of one stage, gives coverage, wrong labels and position errors. A vertex is right
//! when it lies within 0.2 of the pitch, and within 0.45 of the way to the crossing's nearest other vertex, of its
//! own true place.

use std::collections::{HashMap, HashSet};

use serde::Serialize;
use shared::{
    geometry::CameraPixel,
    pattern::{Corner, GridIndex},
    simulation::TruthVertex,
    stage::Stage,
};

/// A vertex as it was read: its label and where it stands.
pub type ReadVertex = (GridIndex, Corner, CameraPixel);

/// Share of the pitch within which a vertex is right.
const REACH_OF_PITCH: f64 = 0.2;
/// Share of the way to the crossing's next vertex within which a vertex is right.
const REACH_OF_NEIGHBOUR: f64 = 0.45;

/// The score of one stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageScore {
    /// Which stage.
    pub stage: Stage,
    /// Crossings that are seen whole and unbroken: those a good reader finds.
    pub clear_crossings: usize,
    /// Vertices reported.
    pub reported: usize,
    /// Share of the clear crossings' vertices reported with the right label, in percent.
    pub coverage_percent: f64,
    /// Reported vertices whose label is not that of the place they stand at.
    pub wrong: usize,
    /// The same as a share of all reported, in percent.
    pub wrong_percent: f64,
    /// Distance of the right ones from the truth, root mean square, in camera pixels; `None` without any.
    pub rms_px: Option<f64>,
    /// Mean outward displacement from the crossing's centre, in camera pixels; 0 for unbiased edges.
    pub bias_px: Option<f64>,
}

impl StageScore {
    /// The score in one line for people.
    #[must_use]
    pub fn sentence(&self) -> String {
        let px = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.3} px"));
        format!(
            "{:.1} % of {} clear crossings read right, {} of {} vertices wrong, RMS {}, bias {}",
            self.coverage_percent,
            self.clear_crossings,
            self.wrong,
            self.reported,
            px(self.rms_px),
            px(self.bias_px),
        )
    }
}

type Key = (GridIndex, Corner);

/// Compares the vertices read in a stage with its truth; truth of other stages is left out. A label that comes
/// twice counts as wrong from the second time on.
#[must_use]
pub fn score_stage(truth: &[TruthVertex], read: &[ReadVertex], stage: Stage) -> StageScore {
    let truth: HashMap<Key, &TruthVertex> = truth
        .iter()
        .filter(|vertex| vertex.stage == stage)
        .map(|vertex| ((vertex.index, vertex.corner), vertex))
        .collect();
    let clear = truth.values().filter(|vertex| vertex.clear).count();
    let (mut right, mut wrong, mut errors, mut outward) = (0, 0, Vec::new(), Vec::new());
    let mut seen = HashSet::new();
    for &(index, corner, at) in read {
        let own = truth
            .get(&(index, corner))
            .filter(|_| seen.insert((index, corner)));
        let Some(own) = own else {
            wrong += 1;
            continue;
        };
        let error = distance(at, own.camera);
        let others = others(&truth, index, corner);
        let reach = others
            .iter()
            .map(|other| REACH_OF_NEIGHBOUR * distance(own.camera, *other))
            .fold(REACH_OF_PITCH * own.pitch_px, f64::min);
        if !error.is_finite() || error > reach {
            wrong += 1;
        } else if own.clear {
            right += 1;
            errors.push(error);
            outward.extend(outward_displacement(at, own.camera, &others));
        }
    }
    let reported = read.len();
    StageScore {
        stage,
        clear_crossings: clear / 4,
        reported,
        coverage_percent: percent(right, clear),
        wrong,
        wrong_percent: percent(wrong, reported),
        rms_px: mean(errors.iter().map(|e| e * e)).map(f64::sqrt),
        bias_px: mean(outward.iter().copied()),
    }
}

/// The true places of a crossing's other vertices.
fn others(
    truth: &HashMap<Key, &TruthVertex>,
    index: GridIndex,
    corner: Corner,
) -> Vec<CameraPixel> {
    let rest = Corner::ALL.into_iter().filter(|&other| other != corner);
    rest.filter_map(|other| truth.get(&(index, other)).map(|vertex| vertex.camera))
        .collect()
}

/// How far a vertex lies outward of its true place, seen from the crossing's centre; `None` where the truth of the
/// crossing is not whole.
fn outward_displacement(at: CameraPixel, own: CameraPixel, others: &[CameraPixel]) -> Option<f64> {
    let [a, b, c] = others else { return None };
    let centre_x = (own.x + a.x + b.x + c.x) / 4.0;
    let centre_y = (own.y + a.y + b.y + c.y) / 4.0;
    let (dx, dy) = (own.x - centre_x, own.y - centre_y);
    Some(((at.x - own.x) * dx + (at.y - own.y) * dy) / dx.hypot(dy))
}

fn distance(a: CameraPixel, b: CameraPixel) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

fn percent(part: usize, of: usize) -> f64 {
    if of == 0 {
        0.0
    } else {
        100.0 * part as f64 / of as f64
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> Option<f64> {
    let count = values.len();
    (count > 0).then(|| values.sum::<f64>() / count as f64)
}
