//! Up to where things are good.

use serde::{Deserialize, Serialize};

/// The limits of the findings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DoctorSettings {
    /// Longest usual round trip to the projector, in milliseconds. The clocks are related to half of it.
    pub round_trip_ms: f64,
    /// Most that the brightness of a steady picture may drift, as a share of it, 0 to 1. Colours are told apart by
    /// steps of a tenth and more.
    pub drift: f64,
    /// Largest share of the frames that may get lost, 0 to 1.
    pub lost_frames: f64,
    /// Least share of the camera's own rate that must be reached, 0 to 1.
    pub rate: f64,
    /// Longest latency, in milliseconds.
    pub latency_ms: f64,
    /// Widest jitter of the latency, in milliseconds.
    pub jitter_ms: f64,
    /// Largest share of the lit pixels that may be clipped under white light, 0 to 1: what is clipped is not read.
    pub clipped: f64,
    /// Least difference of white and black at the middle one of the lit pixels, in levels of 255.
    pub levels: f64,
    /// Most that the light may swing from frame to frame, as a share of the projector's white, 0 to 1.
    pub swing: f64,
    /// Least light of lines one pixel wide, as a share of the light of as much area in lines of two pixels, 0 to 1.
    pub fine_lines: f64,
    /// Widest edges, as a share of the width of the grid's lines.
    pub edge_width: f64,
}

impl Default for DoctorSettings {
    fn default() -> Self {
        Self {
            round_trip_ms: 20.0,
            drift: 0.03,
            lost_frames: 0.05,
            rate: 0.9,
            latency_ms: 150.0,
            jitter_ms: 40.0,
            clipped: 0.02,
            levels: 40.0,
            swing: 0.02,
            fine_lines: 0.9,
            edge_width: 1.0,
        }
    }
}
