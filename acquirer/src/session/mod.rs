//! What the operator does with the rig: set the exposure, measure the latency, choose the colours, record a scan.
//!
//! Each action drives the projector through its link and takes frames from the camera; it tells its progress
//! as [`Progress`] events and stops at the next frame when it is cancelled. Nothing here knows a window or a
//! command line.

mod colours;
mod doctor;
mod exposure;
mod finer;
mod latency;
mod live;
mod new_scan;
mod progress;
mod rig;
mod scan;
mod sequence;
pub mod tagging;

pub use colours::{ColourTrialOrder, ColourTrialResult, OnMeasured, apply_selection, try_colours};
pub use doctor::{Diagnosis, DoctorSettings, Examination, Finding, Measured, State, examine};
pub use exposure::{Exposure, ExposureSettings, WholePeriods, set_exposure};
pub use latency::{Latency, LatencySettings, measure_latency};
pub use live::{CarriedLabel, LiveFrame, LiveMode, LiveSettings, LiveView, OnFrame, read_live};
pub use new_scan::{NewScan, grid_warnings, projected, recording_warnings};
pub use progress::{Cancel, Progress, Report};
pub use rig::{Rig, SessionError, Tap};
pub use scan::{RecordSettings, complete_stage, is_lacking, record_stage, resumed_settings};
pub use sequence::Shot;
