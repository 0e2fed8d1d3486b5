//! The vertices and line points of both stages, their shifts, and the points of the surface as CSV.
//!
//! Takes the pipeline's products, gives the text of `vertices.csv` (edge coordinates of the camera's picture,
//! to 1/1000 px) and of `points.csv` (millimetres in the camera frame, to 1/1000 mm). Lines stand in the order
//! of the pipeline. A position that is not a finite number is left out, since no reader could use it.

use std::fmt::Write as _;

use shared::{
    pattern::{Axis, Corner},
    stage::Stage,
};

use crate::pipeline::{result::ScanResult, surface::SurfacePoint};

/// The text of `vertices.csv`: one line per identified vertex, the background first.
#[must_use]
pub fn vertex_table(result: &ScanResult) -> String {
    let mut text = String::from("stage,row,column,vertex,x_px,y_px,confidence\n");
    for stage in Stage::BOTH {
        for crossing in result.stage(stage).iter().flat_map(|s| &s.grid.crossings) {
            for (corner, at) in Corner::ALL.iter().zip(crossing.vertices) {
                if !(at.x.is_finite() && at.y.is_finite()) {
                    continue;
                }
                let (row, column) = (crossing.index.row, crossing.index.column);
                let confidence = share(crossing.confidence);
                push_line(
                    &mut text,
                    format_args!(
                        "{stage},{row},{column},{corner},{:.3},{:.3},{confidence:.4}",
                        at.x, at.y
                    ),
                );
            }
        }
    }
    text
}

/// The text of `points.csv`: a vertex has row, column and corner; a point along a line has one index only.
#[must_use]
pub fn point_table(surface: &[SurfacePoint]) -> String {
    let mut text = String::from("row,column,vertex,x_mm,y_mm,z_mm,confidence\n");
    for point in finite_points(surface) {
        let index = |line: Option<u16>| line.map(|k| k.to_string()).unwrap_or_default();
        let [x, y, z] = point.position_mm;
        push_line(
            &mut text,
            format_args!(
                "{},{},{},{x:.3},{y:.3},{z:.3},{:.4}",
                index(point.row),
                index(point.column),
                point.corner.map_or("", Corner::name),
                share(point.confidence)
            ),
        );
    }
    text
}

/// The text of `lines.csv`: every point of every decoded line of both stages, camera px, edge coordinates.
#[must_use]
pub fn line_table(result: &ScanResult) -> String {
    let mut text = String::from("stage,axis,line,x_px,y_px,half_width_px,confidence\n");
    for (stage, lines) in Stage::BOTH.into_iter().zip(&result.lines) {
        for line in lines {
            let axis = axis_name(line.axis);
            for point in &line.points {
                let (at, sure) = (point.position, share(point.confidence));
                push_line(
                    &mut text,
                    format_args!(
                        "{stage},{axis},{},{:.3},{:.3},{:.3},{sure:.4}",
                        line.line, at.x, at.y, point.half_width_px
                    ),
                );
            }
        }
    }
    text
}

/// The text of `line_shifts.csv`: where each line point stands with the object, how far it moved along the
/// epipolar direction (px, positive towards nearer surfaces), and the relative depth that this makes.
#[must_use]
pub fn line_shift_table(result: &ScanResult) -> String {
    let mut text = String::from("axis,line,x_px,y_px,shift_px,depth,confidence\n");
    for point in &result.line_shifts.points {
        push_line(
            &mut text,
            format_args!(
                "{},{},{:.3},{:.3},{:.4},{:.4},{:.4}",
                axis_name(point.axis),
                point.line,
                point.at.x,
                point.at.y,
                point.shift_px,
                point.depth,
                share(point.confidence)
            ),
        );
    }
    text
}

/// The text of `shift_quality.csv`: the vertices of `shifts.csv` in their order, the shift's parts along the
/// epipolar direction (depth) and across it (error), px; `rejected` is 1 beyond three standard deviations.
#[must_use]
pub fn shift_quality_table(result: &ScanResult) -> String {
    let mut text = String::from("vertex,row,column,along_px,across_px,rejected\n");
    for (shift, split) in result.shifts.iter().zip(&result.line_shifts.vertices) {
        push_line(
            &mut text,
            format_args!(
                "{},{},{},{:.4},{:.4},{}",
                shift.corner,
                shift.index.row,
                shift.index.column,
                split.along_px,
                split.across_px,
                u8::from(split.rejected)
            ),
        );
    }
    text
}

/// The text of `difference.csv`: the object's points (mm, camera frame), the background's depth on the same
/// projector ray, and the distance between both, positive where the object is nearer.
#[must_use]
pub fn difference_table(result: &ScanResult) -> String {
    let mut text =
        String::from("row,column,vertex,x_mm,y_mm,z_mm,background_z_mm,height_mm,confidence\n");
    for difference in &result.differences {
        let point = &difference.point;
        let index = |line: Option<u16>| line.map(|k| k.to_string()).unwrap_or_default();
        let [x, y, z] = point.position_mm;
        push_line(
            &mut text,
            format_args!(
                "{},{},{},{x:.3},{y:.3},{z:.3},{:.3},{:.3},{:.4}",
                index(point.row),
                index(point.column),
                point.corner.map_or("", Corner::name),
                difference.background_mm[2],
                difference.height_mm,
                share(point.confidence)
            ),
        );
    }
    text
}

fn axis_name(axis: Axis) -> &'static str {
    match axis {
        Axis::Row => "row",
        Axis::Column => "column",
    }
}

/// The points whose position can be used.
pub(super) fn finite_points(surface: &[SurfacePoint]) -> impl Iterator<Item = &SurfacePoint> {
    surface
        .iter()
        .filter(|point| point.position_mm.iter().all(|v| v.is_finite()))
}

/// A confidence brought into 0 to 1; what is not a number counts as 0.
pub(super) fn share(confidence: f64) -> f64 {
    if confidence.is_nan() {
        0.0
    } else {
        confidence.clamp(0.0, 1.0)
    }
}

fn push_line(text: &mut String, line: std::fmt::Arguments<'_>) {
    text.write_fmt(line)
        .unwrap_or_else(|error| unreachable!("a String takes every write: {error}"));
    text.push('\n');
}
