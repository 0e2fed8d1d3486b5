//! Finer grids read with the help of a coarse one.

#![allow(
    clippy::unwrap_used,
    reason = "a step that fails in a helper fails its test"
)]

use std::{fs, path::Path, sync::LazyLock};

use acquirer::{
    config::Config,
    pipeline::{
        Captures, PipelineSettings, StageReading,
        densify::{KnownPlaces, finer_pattern, read_finer},
        grid::{DecodedGrid, DropReason},
        read_stage,
    },
    process::process_scan,
    scan::{ScanError, ScanFolder, Shows},
    score::score_stage,
};
use image::RgbImage;
use rig_tests::measure::{Repeats, SimulatedScan, in_repository};
use shared::{geometry::CameraPixel, pattern::GridSettings, simulation::Scene, stage::Stage};

/// Two boxes before a wall, with the base grid and with 31 lines.
static SCANS: LazyLock<[SimulatedScan; 2]> = LazyLock::new(|| {
    let scene = Scene::load(&in_repository("config/scenes/two-boxes.toml")).unwrap();
    [15, 31].map(|lines| {
        let pattern = finer_pattern(&GridSettings::default(), lines, scene.projector_size());
        SimulatedScan::record(&scene, &pattern.unwrap(), Repeats::default())
    })
});

fn settings() -> PipelineSettings {
    PipelineSettings {
        pictures: false,
        ..PipelineSettings::default()
    }
}

fn coarse() -> StageReading {
    let base = &SCANS[0];
    read_stage(&base.stages[1], &base.projected, None, &settings()).unwrap()
}

fn fine(captures: &Captures, known: KnownPlaces) -> StageReading {
    let mut captures = captures.clone();
    let projected = &SCANS[1].projected;
    read_finer(&mut captures, projected, None, &settings(), known).unwrap()
}

/// Labelled crossings, and vertices with a wrong label.
fn score(grid: &DecodedGrid) -> (usize, usize) {
    let read: Vec<_> = grid.vertices().collect();
    let score = score_stage(&SCANS[1].truth, &read, Stage::Object);
    (grid.crossings.len(), score.wrong)
}

/// The captures with the grids shown in a window only: left, top, right, bottom.
fn through_a_window([left, top, right, bottom]: [u32; 4]) -> Captures {
    let mut captures = SCANS[1].stages[1].clone();
    let black = captures.black[0].clone();
    let cover = |frame: &mut RgbImage| {
        for (x, y, pixel) in frame.enumerate_pixels_mut() {
            if !(left..right).contains(&x) || !(top..bottom).contains(&y) {
                *pixel = *black.get_pixel(x, y);
            }
        }
    };
    captures.prmvs.iter_mut().for_each(cover);
    captures.unary.iter_mut().for_each(cover);
    captures
}

#[test]
fn a_patch_too_small_for_its_own_code_is_placed_by_the_coarse_grid() {
    for (x, y) in [(100, 100), (300, 220), (450, 300)] {
        let captures = through_a_window([x, y, x + 66, y + 70]);
        let alone = fine(&captures, KnownPlaces::default());
        assert_eq!(
            score(&alone.grid).0,
            0,
            "it takes four columns, three are seen"
        );
        let known = KnownPlaces::of(&coarse().grid, &SCANS[0].projected);
        let (labelled, wrong) = score(&fine(&captures, known).grid);
        assert!(labelled >= 4, "{labelled} crossings at {x}, {y}");
        assert_eq!(wrong, 0);
    }
}

#[test]
fn beside_the_coarse_grid_no_less_is_read_and_no_more_wrong() {
    let captures = &SCANS[1].stages[1];
    let (alone, wrong_alone) = score(&fine(captures, KnownPlaces::default()).grid);
    let known = KnownPlaces::of(&coarse().grid, &SCANS[0].projected);
    let (helped, wrong) = score(&fine(captures, known).grid);
    assert!(helped >= alone, "{helped} crossings against {alone} alone");
    assert!(wrong <= wrong_alone, "{wrong} against {wrong_alone} alone");
}

#[test]
fn what_contradicts_the_coarse_grid_is_dropped_with_its_reason() {
    let mut grid = coarse().grid;
    for crossing in &mut grid.crossings {
        crossing.index.row = (crossing.index.row + 1) % 15;
    }
    grid.crossings.sort_by_key(|crossing| crossing.index);
    let known = KnownPlaces::of(&grid, &SCANS[0].projected);
    let reading = fine(&SCANS[1].stages[1], known);
    let off = DropReason::OffEpipolarLine;
    let dropped = reading
        .grid
        .dropped
        .iter()
        .filter(|d| d.reason == off)
        .count();
    assert!(dropped > 300, "{:?}", reading.grid.dropped_by_reason());
    assert!(
        reading.grid.crossings.len() < 200,
        "{} labelled",
        reading.grid.crossings.len()
    );
}

#[test]
fn a_known_place_is_exact_to_a_fraction_of_the_pitch_and_none_is_told_far_from_all_cells() {
    let base = &SCANS[0];
    let known = KnownPlaces::of(&coarse().grid, &base.projected);
    let scene = Scene::load(&in_repository("config/scenes/two-boxes.toml")).unwrap();
    let space = shared::simulation::Space::new(&scene, Stage::Object);
    let (mut told, mut near) = (0, 0);
    for (x, y) in (0..48).flat_map(|y| (0..64).map(move |x| (x, y))) {
        let at = CameraPixel::new(10.0 * f64::from(x) + 5.0, 10.0 * f64::from(y) + 5.0);
        if let (Some(place), Some(truth)) = (known.at(at), space.projector_at(at)) {
            told += 1;
            let off = (place.at.x - truth.x)
                .abs()
                .max((place.at.y - truth.y).abs());
            near += usize::from(off < 3.0 * place.spread_px);
        }
    }
    assert!(told > 1000, "{told} places");
    assert!(near as f64 > 0.97 * told as f64, "{near} of {told}");
    assert_eq!(known.at(CameraPixel::new(-500.0, 100.0)), None);
}

fn save(dir: &Path, with_finer: bool) {
    let [base, finer] = &*SCANS;
    base.save(dir).unwrap();
    if !with_finer {
        return;
    }
    let mut folder = ScanFolder::open(dir).unwrap();
    for (stage, captures) in Stage::BOTH.into_iter().zip(&finer.stages) {
        for (shows, frames) in [
            (Shows::Prmvs, &captures.prmvs),
            (Shows::Unary, &captures.unary),
        ] {
            for frame in frames {
                folder
                    .add_finer_capture(&finer.projected.pattern, stage, shows, frame)
                    .unwrap();
            }
        }
    }
}

#[test]
fn a_scan_with_a_finer_grid_keeps_the_base_tables_and_gets_its_own_and_one_denser_cloud() {
    let dir = tempfile::tempdir().unwrap();
    let [plain, dense] = ["plain", "dense"].map(|name| dir.path().join(name));
    save(&plain, false);
    save(&dense, true);
    for folder in [&plain, &dense] {
        process_scan(&ScanFolder::open(folder).unwrap(), &Config::default()).unwrap();
    }
    let bytes = |folder: &Path, file: &str| fs::read(folder.join("results").join(file)).unwrap();
    for table in ["vertices.csv", "lines.csv", "points.csv", "shifts.csv"] {
        assert!(
            bytes(&plain, table) == bytes(&dense, table),
            "{table} of the base grid"
        );
        let finer = bytes(&dense, &format!("finer-31/{table}"));
        assert!(
            finer.len() > bytes(&plain, table).len(),
            "{table} of the finer grid"
        );
    }
    let header = |folder: &Path| {
        let ply = bytes(folder, "points.ply");
        String::from_utf8_lossy(&ply[..800]).into_owned()
    };
    assert!(header(&dense).contains("property int grid"));
    assert!(!header(&plain).contains("property int grid"));
    let summary: serde_json::Value =
        serde_json::from_slice(&bytes(&dense, "summary.json")).unwrap();
    assert_eq!(summary["finer"][0]["lines"], serde_json::json!([31, 31]));
    assert!(summary["finer"][0]["points"].as_u64() > Some(10_000));
    let report = String::from_utf8(bytes(&dense, "report.html")).unwrap();
    assert!(report.contains("Finer grids"));

    // a stage recorded anew has no finer captures, and their old results go
    let mut folder = ScanFolder::open(&dense).unwrap();
    for (stage, captures) in Stage::BOTH.into_iter().zip(&SCANS[0].stages) {
        let coded = captures.prmvs.iter().map(|picture| (Shows::Prmvs, picture));
        folder.replace_stage(stage, coded).unwrap();
    }
    assert!(folder.finer().unwrap().is_empty());
    process_scan(&ScanFolder::open(&dense).unwrap(), &Config::default()).unwrap();
    assert!(!dense.join("results/finer-31").exists());
}

#[test]
fn a_finer_capture_outside_of_the_folder_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    SCANS[0].save(dir.path()).unwrap();
    let mut folder = ScanFolder::open(dir.path()).unwrap();
    let finer = serde_json::json!([{
        "pattern": SCANS[1].projected.pattern,
        "captures": [{"stage": "object", "shows": "prmvs", "file": "../elsewhere.png"}],
    }]);
    folder.note("finer", &finer).unwrap();
    assert!(matches!(folder.finer(), Err(ScanError::Outside { .. })));
}
