//! What stands in the tables of a scan's results: columns, units, indices, empty fields, and that they agree with each
//! other, with the summary and with the scene's truth. The scan is the recorded wall and cube, read by the program.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    collections::{BTreeMap, HashMap},
    fs,
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
};

use rig_tests::{copy_folder, measure::in_repository, read_truth};
use serde_json::Value;
use shared::{simulation::TruthVertex, stage::Stage};

/// One scan read for all tests here; `summary` is that of its figures.
struct Read {
    dir: tempfile::TempDir,
    summary: Value,
}

fn read() -> &'static Read {
    static READ: OnceLock<Read> = OnceLock::new();
    READ.get_or_init(|| {
        let dir = tempfile::tempdir().unwrap();
        copy_folder(&in_repository("tests/recorded/wall-cube"), dir.path()).unwrap();
        let summary = process(dir.path());
        Read { dir, summary }
    })
}

fn process(dir: &Path) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_acquirer"))
        .args(["process", "--json"])
        .arg(dir)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let figures: Value = serde_json::from_slice(&output.stdout).unwrap();
    figures["summary"].clone()
}

fn result_file(name: &str) -> PathBuf {
    read().dir.path().join("results").join(name)
}

/// A table by the names of its columns; `header` is what the columns must be.
fn table(name: &str, header: &str) -> Vec<HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(result_file(name)).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(Into::into).collect();
    assert_eq!(names.join(","), header, "{name}");
    let records = reader.records().map(Result::unwrap);
    let rows = records.map(|record| {
        let fields = record.iter().map(str::to_owned);
        names.iter().cloned().zip(fields).collect()
    });
    rows.collect()
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    let value: f64 = row[column].parse().unwrap();
    assert!(value.is_finite());
    value
}

fn count(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

/// Which line a row is of: its row, its column, or (a vertex) both; a point of one line has the other field empty.
fn assert_indices(row: &HashMap<String, String>) {
    let is_vertex = !row["vertex"].is_empty();
    let named = ["row", "column"].map(|name| !row[name].is_empty());
    assert_eq!(named[0] && named[1], is_vertex, "{row:?}");
    assert!(named[0] || named[1], "{row:?}");
    for name in ["row", "column"]
        .into_iter()
        .filter(|n| !row[*n].is_empty())
    {
        assert!((0.0..15.0).contains(&number(row, name)), "{row:?}");
    }
}

const POINTS: &str = "row,column,vertex,x_mm,y_mm,z_mm,confidence";
const DIFFERENCES: &str = "row,column,vertex,x_mm,y_mm,z_mm,background_z_mm,height_mm,confidence";

/// A vertex by stage and by its fields in a table.
type TruthByName = HashMap<(Stage, [String; 3]), TruthVertex>;

fn truth() -> TruthByName {
    let truth = read_truth(&read().dir.path().join("truth.csv")).unwrap();
    let named = truth.into_iter().filter(|v| v.clear).map(|v| {
        let index = [v.index.row.to_string(), v.index.column.to_string()];
        let [row, column] = index;
        ((v.stage, [row, column, v.corner.name().to_owned()]), v)
    });
    named.collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn lines_csv_holds_every_line_point_of_both_stages_inside_the_picture() {
    let rows = table(
        "lines.csv",
        "stage,axis,line,x_px,y_px,half_width_px,confidence",
    );
    for stage in Stage::BOTH {
        let own = rows.iter().filter(|row| row["stage"] == stage.name());
        let told = count(&read().summary[stage.name()]["line_points"]);
        assert_eq!(own.count(), told, "{stage}");
    }
    let mut lines = BTreeMap::<(&str, &str), usize>::new();
    for row in &rows {
        *lines.entry((&row["axis"], &row["line"])).or_default() += 1;
        assert!((0.0..=640.0).contains(&number(row, "x_px")), "{row:?}");
        assert!((0.0..=480.0).contains(&number(row, "y_px")), "{row:?}");
        assert!(
            (0.3..8.0).contains(&number(row, "half_width_px")),
            "{row:?}"
        );
        assert!((0.0..=1.0).contains(&number(row, "confidence")), "{row:?}");
    }
    assert!(lines.len() > 25, "{} different lines", lines.len());
    let known = |axis: &str| ["row", "column"].contains(&axis);
    assert!(
        lines
            .keys()
            .all(|(axis, k)| known(axis) && k.parse::<u16>().unwrap() < 15)
    );
}

#[test]
fn line_shifts_csv_gives_depth_as_the_shift_times_the_rigs_factor() {
    let rows = table(
        "line_shifts.csv",
        "axis,line,x_px,y_px,shift_px,depth,confidence",
    );
    let told = &read().summary["line_shifts"];
    assert_eq!(rows.len(), count(&told["points"]));
    assert_eq!(told["direction"], "calibration");
    let factor = read().summary["shifts"]["depth_per_px"].as_f64().unwrap();
    for row in &rows {
        let error = number(row, "depth") - factor * number(row, "shift_px");
        assert!(error.abs() < 1.5e-4, "{row:?}");
    }
    let nearer = rows.iter().filter(|row| number(row, "shift_px") > 1.0);
    let farther = rows.iter().filter(|row| number(row, "shift_px") < -1.0);
    let [nearer, farther] = [nearer.count(), farther.count()];
    assert!(
        nearer > 500 && farther < nearer / 100,
        "{nearer} nearer, {farther} farther"
    );
}

#[test]
fn shift_quality_csv_splits_the_vertices_of_shifts_csv_in_their_order() {
    let shifts = table("shifts.csv", "vertex,row,column,x_px,y_px,shift_px,depth");
    let quality = table(
        "shift_quality.csv",
        "vertex,row,column,along_px,across_px,rejected",
    );
    assert_eq!(shifts.len(), quality.len());
    for (shift, split) in shifts.iter().zip(&quality) {
        for key in ["vertex", "row", "column"] {
            assert_eq!(shift[key], split[key]);
        }
        let parts = number(split, "along_px").hypot(number(split, "across_px"));
        assert!(
            (parts - number(shift, "shift_px")).abs() < 3e-4,
            "{split:?}"
        );
    }
    let rejected = quality.iter().filter(|row| row["rejected"] == "1").count();
    assert_eq!(
        rejected,
        count(&read().summary["line_shifts"]["rejected_vertices"])
    );
    assert!(
        quality
            .iter()
            .all(|row| ["0", "1"].contains(&row["rejected"].as_str()))
    );
}

#[test]
fn difference_csv_gives_the_true_height_of_the_object_over_the_wall() {
    let rows = table("difference.csv", DIFFERENCES);
    assert_eq!(rows.len(), count(&read().summary["difference"]["points"]));
    let truth = truth();
    let mut errors = Vec::new();
    for row in &rows {
        assert_indices(row);
        let (z, before) = (number(row, "z_mm"), number(row, "background_z_mm"));
        let height = number(row, "height_mm");
        assert!(height.abs() + 2e-3 >= (before - z).abs(), "{row:?}");
        assert!(
            height.abs() < 2e-3 || (height > 0.0) == (before > z),
            "{row:?}"
        );
        let name = ["row", "column", "vertex"].map(|key| row[key].clone());
        let [before, after] = Stage::BOTH.map(|stage| truth.get(&(stage, name.clone())));
        if let (Some(before), Some(after)) = (before, after) {
            errors.push(height.abs() - (before.point_mm - after.point_mm).norm());
        }
    }
    assert!(errors.len() > 400, "{} vertices compared", errors.len());
    // 0.06 % of the distance, which is less than 1.2 m, in each of two stages
    assert!(
        rms(&errors) < 1.0,
        "RMS of the heights is {:.3} mm",
        rms(&errors)
    );
}

/// The points of a PLY file: x, y, z, row, column.
fn cloud(name: &str) -> Vec<([f32; 3], [i32; 2])> {
    const STRIDE: usize = 12 + 3 + 8 + 4;
    let bytes = fs::read(result_file(name)).unwrap();
    let end = b"end_header\n";
    let body = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let header = String::from_utf8_lossy(&bytes[..body]);
    let points = bytes[body..].chunks_exact(STRIDE);
    assert!(header.contains(&format!("element vertex {}\n", points.len())));
    let word = |point: &[u8], at: usize| <[u8; 4]>::try_from(&point[at..at + 4]).unwrap();
    let read = points.map(|point| {
        let position = [0, 4, 8].map(|at| f32::from_le_bytes(word(point, at)));
        (
            position,
            [15, 19].map(|at| i32::from_le_bytes(word(point, at))),
        )
    });
    read.collect()
}

#[test]
fn points_csv_and_points_ply_hold_the_same_points_in_millimetres() {
    let (rows, cloud) = (table("points.csv", POINTS), cloud("points.ply"));
    assert_eq!(rows.len(), cloud.len());
    assert_eq!(rows.len(), count(&read().summary["surface"]["points"]));
    for (row, (position, lines)) in rows.iter().zip(&cloud) {
        assert_indices(row);
        for (name, value) in ["x_mm", "y_mm", "z_mm"].into_iter().zip(position) {
            assert!(
                (number(row, name) - f64::from(*value)).abs() < 1e-3,
                "{row:?}"
            );
        }
        for (name, line) in ["row", "column"].into_iter().zip(lines) {
            let field = row[name].parse().unwrap_or(-1);
            assert_eq!(field, *line, "{row:?}");
        }
    }
    let vertices = rows.iter().filter(|row| !row["vertex"].is_empty()).count();
    assert_eq!(vertices, count(&read().summary["surface"]["vertices"]));
}

#[test]
fn background_ply_lies_on_the_true_wall() {
    let cloud = cloud("background.ply");
    let before = truth()
        .into_iter()
        .filter(|((stage, _), _)| *stage == Stage::Background);
    let depths: Vec<f64> = before.map(|(_, vertex)| vertex.point_mm.z).collect();
    let low = depths.iter().copied().fold(f64::INFINITY, f64::min);
    let high = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // lines reach half a pitch beyond the outermost crossings
    let reach = 0.1 * (high - low) + 0.01 * low;
    let on_wall = cloud
        .iter()
        .filter(|(position, _)| (low - reach..=high + reach).contains(&f64::from(position[2])));
    let share = on_wall.count() as f64 / cloud.len() as f64;
    assert!(
        cloud.len() > 5000 && share > 0.999,
        "{share} of {}",
        cloud.len()
    );
}

#[test]
fn what_gave_no_surface_point_is_counted_by_its_reason() {
    let (object, surface) = (&read().summary["object"], &read().summary["surface"]);
    let dropped = surface["dropped"].as_object().unwrap();
    let reasons = [
        "along_epipolar",
        "off_epipolar",
        "outside_raster",
        "no_meeting",
    ];
    assert!(
        dropped
            .keys()
            .all(|reason| reasons.contains(&reason.as_str()))
    );
    let left_out: usize = dropped.values().map(count).sum();
    assert!(
        count(&surface["dropped"]["along_epipolar"]) > 0,
        "{dropped:?}"
    );
    assert_eq!(
        count(&object["vertices"]) + count(&object["line_points"]),
        count(&surface["points"]) + left_out,
        "every vertex and line point is either a point or counted"
    );
}

#[test]
fn a_grid_too_dense_for_the_camera_is_warned_of_with_what_it_could_resolve() {
    assert_eq!(read().summary["warnings"], serde_json::json!([]));
    let dir = tempfile::tempdir().unwrap();
    copy_folder(&in_repository("tests/recorded/wall-cube"), dir.path()).unwrap();
    let manifest = dir.path().join("scan.json");
    let mut scan: Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    scan["pattern"]["rows"] = 127.into();
    scan["pattern"]["row_width_px"] = 2.into();
    fs::write(&manifest, scan.to_string()).unwrap();
    let summary = process(dir.path());
    let warnings = summary["warnings"].as_array().unwrap();
    let warnings: Vec<&str> = warnings.iter().map(|w| w.as_str().unwrap()).collect();
    let dense = warnings
        .iter()
        .find(|w| w.contains("127 rows are too many"));
    assert!(
        dense.unwrap().contains("at most 31 rows would work"),
        "{warnings:?}"
    );
    let report = fs::read_to_string(dir.path().join("results/report.html")).unwrap();
    assert!(
        report.contains("127 rows are too many"),
        "the report says so as well"
    );
}
