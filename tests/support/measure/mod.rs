//! Measuring against known truth: simulated scans, their scores, and the tables in `tests/measured`.

mod simulated;

mod conditions;

mod trial;

mod reading;

mod sweep;

mod tagging;

pub use conditions::{Condition, Group, Sweep, in_repository, shipped_scenes};
pub use reading::{Reading, Sum, cpu_time};
pub use simulated::{Repeats, SimulatedScan, scene_of_camera};
pub use sweep::{Row, SweepTable, run_sweep};
pub use tagging::{TaggingRig, TaggingScore, score_tagging};
pub use trial::colour_trial;
