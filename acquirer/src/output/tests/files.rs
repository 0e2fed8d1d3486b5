//! Tables, point cloud, summary, and what happens when they can't be written.

use std::{collections::BTreeMap, fs, path::Path, sync::OnceLock};

use super::fixture::{BOX_MM, WALL_MM, recorded, write};
use crate::output::{ResultPaths, shift_table::read_shift_table};

/// The results of the calibrated scan, written once for all tests that only read them.
fn written() -> &'static ResultPaths {
    static WRITTEN: OnceLock<(tempfile::TempDir, ResultPaths)> = OnceLock::new();
    let (_dir, paths) = WRITTEN.get_or_init(|| {
        let dir = tempfile::tempdir().unwrap();
        let paths = write(&recorded(dir.path(), true), true).unwrap();
        (dir, paths)
    });
    paths
}

fn lines(path: &Path) -> Vec<Vec<String>> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .from_path(path)
        .unwrap()
        .records()
        .map(|record| record.unwrap().iter().map(str::to_owned).collect())
        .collect()
}

#[test]
fn every_vertex_of_both_stages_stands_in_the_vertex_table_once() {
    let table = lines(&written().vertices);
    let header = "stage,row,column,vertex,x_px,y_px,confidence";
    assert_eq!(table[0].join(","), header);
    assert_eq!(table.len(), 1 + 2 * 4 * 224);
    let keys: std::collections::BTreeSet<_> = table[1..].iter().map(|l| l[..4].to_vec()).collect();
    assert_eq!(keys.len(), 2 * 4 * 224);
    let first = &table[1];
    assert_eq!(first[..4].join(","), "background,0,0,UPPER_LEFT");
    assert!((first[4].parse::<f64>().unwrap() - (320.0 - 600.0 * 0.048 * 7.06)).abs() < 1e-3);
    assert!((first[5].parse::<f64>().unwrap() - (240.0 - 600.0 * 0.048 * 7.06)).abs() < 1e-3);
    assert_eq!(first[6], "0.9800");
}

#[test]
fn the_shift_table_has_the_place_with_the_object_and_the_relative_depth() {
    let rows = read_shift_table(&written().shifts).unwrap();
    assert_eq!(rows.len(), 4 * 224);
    let moved = rows.iter().filter(|row| row.shift_px > 1.0).count();
    assert_eq!(moved, 4 * 25);
    let row = rows.iter().find(|row| row.shift_px > 1.0).unwrap();
    let expected = 600.0 * 200.0 * (1.0 / BOX_MM - 1.0 / WALL_MM);
    assert!((row.shift_px - expected).abs() < 1e-3, "{}", row.shift_px);
    assert!((row.depth - 0.6633 * expected).abs() < 1e-3);
}

#[test]
fn a_point_along_a_line_leaves_vertex_and_other_index_empty() {
    let table = lines(written().points.as_ref().unwrap());
    assert_eq!(
        table[0].join(","),
        "row,column,vertex,x_mm,y_mm,z_mm,confidence"
    );
    assert_eq!(table.len(), 1 + 4 * 225 + 1);
    assert_eq!(table[1][..3].join(","), "0,0,UPPER_LEFT");
    assert_eq!(
        table.last().unwrap().join(","),
        ",3,,-192.000,-216.000,1000.000,0.5000"
    );
}

/// A property's type and name, with its size in bytes.
fn properties(header: &str) -> Vec<(&str, usize)> {
    let size = BTreeMap::from([("float", 4), ("int", 4), ("uchar", 1)]);
    header
        .lines()
        .filter_map(|line| line.strip_prefix("property "))
        .map(|line| line.split_once(' ').unwrap())
        .map(|(kind, name)| (name, size[kind]))
        .collect()
}

#[test]
fn the_point_cloud_reads_back_by_its_own_header() {
    let bytes = fs::read(written().cloud.as_ref().unwrap()).unwrap();
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let (header, body) = (std::str::from_utf8(&bytes[..at]).unwrap(), &bytes[at..]);
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\ncomment "));
    assert!(header.contains("millimetres") && header.contains("calibration calibration.json"));
    let properties = properties(header);
    let names: Vec<_> = properties.iter().map(|(name, _)| *name).collect();
    assert_eq!(
        names.join(" "),
        "x y z red green blue row column confidence"
    );
    let stride: usize = properties.iter().map(|(_, size)| size).sum();
    assert!(header.contains("element vertex 901\n"));
    assert_eq!(body.len(), 901 * stride);
    let word = |at: usize| <[u8; 4]>::try_from(&body[at..at + 4]).unwrap();
    let depths: Vec<f32> = (0..901)
        .map(|k| f32::from_le_bytes(word(k * stride + 8)))
        .collect();
    assert_eq!(depths.iter().filter(|&&z| z == 850.0).count(), 100);
    assert_eq!(depths.iter().filter(|&&z| z == 1000.0).count(), 801);
    let last = 900 * stride;
    assert_eq!(body[last + 12..last + 15], [10, 20, 30]);
    assert_eq!(i32::from_le_bytes(word(last + 15)), -1);
    assert_eq!(i32::from_le_bytes(word(last + 19)), 3);
}

#[test]
fn the_summary_counts_what_was_read_and_what_was_dropped() {
    let text = fs::read_to_string(&written().summary).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["format"], 1);
    assert_eq!(summary["method"], "likelihood");
    assert_eq!(summary["pattern"]["rows"], 15);
    assert_eq!(summary["object"]["crossings_possible"], 225);
    assert_eq!(summary["object"]["crossings_labelled"], 224);
    assert_eq!(summary["object"]["coverage_percent"], 99.556);
    assert_eq!(summary["object"]["dropped"]["too_dark"], 1);
    assert_eq!(summary["object"]["dropped"]["clipped"], 0);
    assert_eq!(summary["shifts"]["vertices"], 896);
    assert_eq!(summary["shifts"]["smallest_px"], 0.0);
    assert_eq!(summary["surface"]["z_mm"][0], 850.0);
    assert_eq!(summary["surface"]["points"], 901);
    assert_eq!(summary["settings"]["lines"]["sigma_px"], 1.5);
}

/// Every file under a folder, by its path in it.
fn contents(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            let inner = contents(&path).into_iter();
            files.extend(inner.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else {
            files.insert(name, fs::read(path).unwrap());
        }
    }
    files
}

#[test]
fn the_same_scan_gives_the_same_bytes_wherever_and_whenever_it_is_processed() {
    let other = tempfile::tempdir().unwrap();
    let again = write(&recorded(other.path(), true), true).unwrap();
    let (first, second) = (contents(&written().dir), contents(&again.dir));
    assert_eq!(
        first.keys().collect::<Vec<_>>(),
        second.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &first {
        assert!(bytes == &second[name], "{name} differs");
    }
}

#[test]
fn files_of_an_earlier_run_do_not_stay_beside_new_ones() {
    let dir = tempfile::tempdir().unwrap();
    let folder = recorded(dir.path(), false);
    let results = folder.results_dir();
    fs::create_dir_all(results.join("pictures")).unwrap();
    for name in ["points.ply", "points.csv", "pictures/old.png", "notes.txt"] {
        fs::write(results.join(name), "of an earlier run").unwrap();
    }
    let paths = write(&folder, false).unwrap();
    assert_eq!((paths.points, paths.cloud), (None, None));
    let files = contents(&results);
    let left: Vec<_> = files
        .keys()
        .filter(|name| !name.ends_with(".png"))
        .collect();
    let expected = [
        "SHA256SUMS",
        "line_shifts.csv",
        "lines.csv",
        "notes.txt",
        "report.html",
        "shift_quality.csv",
        "shifts.csv",
        "summary.json",
        "vertices.csv",
    ];
    assert_eq!(left, expected);
    assert!(files.contains_key("pictures/view-depth.png"));
    assert!(!files.contains_key("pictures/old.png"));
}

#[test]
fn a_file_in_the_place_of_the_results_folder_is_an_error_with_its_path() {
    let dir = tempfile::tempdir().unwrap();
    let folder = recorded(dir.path(), false);
    let place = folder.results_dir();
    fs::write(&place, "in the way").unwrap();
    let error = write(&folder, false).unwrap_err();
    assert!(
        error.to_string().contains(place.to_str().unwrap()),
        "{error}"
    );
}

#[test]
fn a_folder_in_the_place_of_a_file_is_an_error_with_its_path() {
    let dir = tempfile::tempdir().unwrap();
    let folder = recorded(dir.path(), false);
    let place = folder.results_dir().join("shifts.csv");
    fs::create_dir_all(place.join("inner")).unwrap();
    let error = write(&folder, false).unwrap_err();
    assert!(
        error.to_string().contains(place.to_str().unwrap()),
        "{error}"
    );
    assert!(
        !folder.results_dir().join("summary.json").exists(),
        "a broken run has no summary"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_and_a_read_only_place_are_errors_with_the_path() {
    use std::os::unix::fs::symlink;
    let dir = tempfile::tempdir().unwrap();
    let folder = recorded(dir.path(), false);
    let results = folder.results_dir();
    fs::create_dir(&results).unwrap();
    symlink("/dev/full", results.join("vertices.csv.part")).unwrap();
    let full = write(&folder, false).unwrap_err();
    assert!(full.to_string().contains("vertices.csv: No space left"));
    fs::remove_dir_all(&results).unwrap();
    symlink("/proc", &results).unwrap();
    let read_only = write(&folder, false).unwrap_err();
    assert!(
        read_only.to_string().contains("results/pictures: "),
        "{read_only}"
    );
}
