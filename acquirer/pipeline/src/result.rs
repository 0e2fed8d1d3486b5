//! All that the pipeline gives for one scan: both stages, the shifts between them, the surface.

use std::collections::BTreeMap;

use shared::{pattern::GridSettings, stage::Stage};

use super::{
    Method, StageReading,
    dense::DenseLine,
    response::{MeasuredResponse, NoMeasurement},
    shift::{Shift, lines::LineShifts},
    surface::{SurfaceDrop, SurfacePoint, difference::Difference},
};

/// The products of one scan. A stage that was not recorded is `None`; without a calibration there is no
/// surface.
#[derive(Debug, Clone, Default)]
pub struct ScanResult {
    /// The reading method that was used.
    pub method: Method,
    /// Relative depth for one camera pixel of shift, as used for [`Self::shifts`].
    pub depth_per_px: f64,
    /// The scene before the object was put in.
    pub background: Option<StageReading>,
    /// The scene with the object.
    pub object: Option<StageReading>,
    /// The vertices read in both stages.
    pub shifts: Vec<Shift>,
    /// The unbroken pieces of all decoded lines, before and with the object.
    pub lines: [Vec<DenseLine>; 2],
    /// What moved along the epipolar direction: vertices and line points.
    pub line_shifts: LineShifts,
    /// Points of the object stage in millimetres, in the camera frame.
    pub surface: Vec<SurfacePoint>,
    /// The same of the background stage.
    pub background_surface: Vec<SurfacePoint>,
    /// Vertices and line points of both stages that gave no point of the surface, by reason.
    pub surface_dropped: [BTreeMap<SurfaceDrop, usize>; 2],
    /// How far the object stands out of the background.
    pub differences: Vec<Difference>,
    /// What finer grids gave, coarse before fine.
    pub finer: Vec<FinerScan>,
    /// The camera's response as measured with this scan's solid colours; `None` when it has none.
    pub response: Option<Result<MeasuredResponse, NoMeasurement>>,
    /// The effective settings of the pipeline, for the report and the summary; `Null` when there are none.
    pub settings: serde_json::Value,
}

/// What a finer grid of the same scan gave.
#[derive(Debug, Clone)]
pub struct FinerScan {
    /// The grid and its unary colour.
    pub pattern: GridSettings,
    /// Its products; it has no finer grids itself.
    pub result: ScanResult,
}

impl FinerScan {
    /// The larger number of its lines.
    #[must_use]
    pub fn most_lines(&self) -> usize {
        self.pattern.coded.rows().max(self.pattern.coded.columns())
    }
}

impl ScanResult {
    /// The reading of one stage.
    #[must_use]
    pub fn stage(&self, stage: Stage) -> Option<&StageReading> {
        match stage {
            Stage::Background => self.background.as_ref(),
            Stage::Object => self.object.as_ref(),
        }
    }
}
