//! Points of the surface in millimetres, from labelled vertices and a calibrated rig.

use shared::pattern::Corner;

/// A point of the surface, in the camera frame: x right, y down, z forward.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePoint {
    /// Row of the pattern it lies on, if any.
    pub row: Option<u16>,
    /// Column of the pattern it lies on, if any.
    pub column: Option<u16>,
    /// The vertex it is, or `None` for a point along a line.
    pub corner: Option<Corner>,
    /// Position in millimetres.
    pub position_mm: [f64; 3],
    /// Colour of the surface there, as the camera sees it under white light.
    pub colour: [u8; 3],
    /// Probability that the label is right, 0 to 1.
    pub confidence: f64,
}
