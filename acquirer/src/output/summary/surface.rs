//! Where the surface lies, and how far the object stands out of the background, in figures.

use std::collections::BTreeMap;

use serde::Serialize;

use super::rounded;
use crate::{output::tables::finite_points, pipeline::result::ScanResult};

/// Where the surface lies, in millimetres of the camera frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceFigures {
    /// All points.
    pub points: usize,
    /// Points that are vertices of crossings.
    pub vertices: usize,
    /// Vertices and line points of the object without a point, for each reason by its name.
    pub dropped: BTreeMap<&'static str, usize>,
    /// Smallest and largest x (to the right).
    pub x_mm: [f64; 2],
    /// Smallest and largest y (downwards).
    pub y_mm: [f64; 2],
    /// Smallest and largest z (forward).
    pub z_mm: [f64; 2],
    /// Half of the points are nearer.
    pub median_z_mm: f64,
}

impl SurfaceFigures {
    pub(super) fn of(result: &ScanResult) -> Option<Self> {
        let along = |axis: usize| {
            let mut values: Vec<f64> = finite_points(&result.surface)
                .map(|point| point.position_mm[axis])
                .collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let range = |values: &[f64]| Some([rounded(*values.first()?), rounded(*values.last()?)]);
        let z = along(2);
        Some(Self {
            points: z.len(),
            vertices: finite_points(&result.surface)
                .filter(|point| point.corner.is_some())
                .count(),
            dropped: result.surface_dropped[1]
                .iter()
                .map(|(reason, count)| (reason.name(), *count))
                .collect(),
            x_mm: range(&along(0))?,
            y_mm: range(&along(1))?,
            z_mm: range(&z)?,
            median_z_mm: rounded(z[z.len() / 2]),
        })
    }
}

/// How far the object stands out of the background, in mm along the projector's rays.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DifferenceFigures {
    /// Points compared.
    pub points: usize,
    /// Half of the points stand out less.
    pub median_mm: f64,
    /// 95 % of the points stand out less.
    pub p95_mm: f64,
    /// The largest height.
    pub largest_mm: f64,
}

impl DifferenceFigures {
    pub(super) fn of(result: &ScanResult) -> Option<Self> {
        let mut heights: Vec<f64> = result.differences.iter().map(|d| d.height_mm).collect();
        heights.retain(|height| height.is_finite());
        heights.sort_by(f64::total_cmp);
        let at = |share: f64| {
            heights
                .get((share * heights.len() as f64) as usize)
                .copied()
        };
        Some(Self {
            points: heights.len(),
            median_mm: rounded(at(0.5)?),
            p95_mm: rounded(at(0.95)?),
            largest_mm: rounded(*heights.last()?),
        })
    }
}
