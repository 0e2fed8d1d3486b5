//! The camera side of the rig: captures frames, reads the projected grid, chooses its colours, records
//! scans without and with an object, and gives the object's shape.
//!
//! ```text
//! camera (v4l2, replay, simulated) -> scan -> pipeline -> output
//! session (latency, colour selection, scan) drives the projector through projector_link
//! ```

pub mod camera;
pub mod cli;
pub mod clock;
pub mod config;
mod densify;
pub mod gui;
pub mod output;
pub mod process;
pub mod projector_link;
pub mod scan;
pub mod score;
pub mod session;

pub use ::pipeline;
