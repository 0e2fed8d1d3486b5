//! A scan made by formulas: a wall 1000 mm away, and a box 150 mm before it that covers 5 x 5 crossings.

use std::path::Path;

use image::{Rgb as Pixel, RgbImage};
use nalgebra::Vector3;
use shared::{
    geometry::{CameraPixel, Lens, Pose, RigCalibration},
    pattern::{Axis, Corner, GridIndex, GridSettings, RasterSize, Rgb},
    stage::Stage,
};

use crate::{
    output::{EncodedPicture, OutputError, ResultPaths, write_results},
    pipeline::{
        Method, Projected, StagePicture, StageReading,
        colour_choice::{ColourScore, ColourSelection, ColourSet, Separability, TileScore},
        grid::{DecodedCrossing, DecodedGrid, DropReason, DroppedCrossing, LinePoint, LineTrack},
        result::ScanResult,
        shift::{THESIS_DEPTH_PER_PX, find_shifts},
        surface::SurfacePoint,
    },
    scan::{ScanFolder, Shows},
};

/// Size of the camera's picture.
pub(super) const CAMERA: RasterSize = RasterSize {
    width: 640,
    height: 480,
};
/// The projector's raster.
const RASTER: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};
/// Distance of wall and box, in millimetres.
pub(super) const WALL_MM: f64 = 1000.0;
pub(super) const BOX_MM: f64 = 850.0;
/// Rows and columns whose crossings lie on the box.
const BOX: std::ops::RangeInclusive<u16> = 5..=9;
const FOCAL_PX: f64 = 600.0;
const PITCH_MM: f64 = 48.0;

/// Whether a crossing lies on the box.
pub(super) fn on_box(index: GridIndex) -> bool {
    BOX.contains(&index.row) && BOX.contains(&index.column)
}

fn distance_mm(index: GridIndex, stage: Stage) -> f64 {
    if stage == Stage::Object && on_box(index) {
        BOX_MM
    } else {
        WALL_MM
    }
}

/// Where a place of the grid lies in space: the projector stands 200 mm to the left of the camera.
fn position_mm(row: f64, column: f64, z: f64) -> [f64; 3] {
    let x = (column - 7.0) * PITCH_MM * z / WALL_MM + 200.0 * (z / WALL_MM - 1.0);
    [x, (row - 7.0) * PITCH_MM * z / WALL_MM, z]
}

fn seen([x, y, z]: [f64; 3]) -> CameraPixel {
    CameraPixel::new(320.0 + FOCAL_PX * x / z, 240.0 + FOCAL_PX * y / z)
}

fn corner_position(index: GridIndex, corner: Corner, z: f64) -> [f64; 3] {
    let side = |far: bool| if far { 0.06 } else { -0.06 };
    position_mm(
        f64::from(index.row) + side(corner.is_lower()),
        f64::from(index.column) + side(corner.is_right()),
        z,
    )
}

fn indices() -> impl Iterator<Item = GridIndex> {
    (0..15).flat_map(|row| (0..15).map(move |column| GridIndex { row, column }))
}

fn reading(stage: Stage) -> StageReading {
    let crossings = indices()
        .filter(|index| index.row != 14 || index.column != 14)
        .map(|index| {
            let z = distance_mm(index, stage);
            DecodedCrossing {
                index,
                centre: seen(position_mm(index.row.into(), index.column.into(), z)),
                vertices: Corner::ALL.map(|corner| seen(corner_position(index, corner, z))),
                confidence: 0.98,
            }
        })
        .collect();
    let track = |axis, k: u16| LineTrack {
        axis,
        line: Some(k),
        points: (0..29)
            .map(|step| {
                let along = f64::from(step) / 2.0;
                let (row, column) = match axis {
                    Axis::Row => (f64::from(k), along),
                    Axis::Column => (along, f64::from(k)),
                };
                LinePoint {
                    position: seen(position_mm(row, column, WALL_MM)),
                    half_width_px: 2.0,
                    confidence: 0.9,
                }
            })
            .collect(),
    };
    StageReading {
        grid: DecodedGrid {
            crossings,
            partial: Vec::new(),
            dropped: vec![DroppedCrossing {
                centre: CameraPixel::new(600.0, 440.0),
                reason: DropReason::TooDark,
            }],
            tracks: (0..15)
                .flat_map(|k| Axis::BOTH.map(|axis| track(axis, k)))
                .collect(),
        },
        pictures: Vec::new(),
    }
}

fn surface() -> Vec<SurfacePoint> {
    indices()
        .flat_map(|index| {
            let z = distance_mm(index, Stage::Object);
            Corner::ALL.map(|corner| SurfacePoint {
                row: Some(index.row),
                column: Some(index.column),
                corner: Some(corner),
                position_mm: corner_position(index, corner, z),
                colour: [200, 150, 100],
                confidence: 0.98,
            })
        })
        .chain([SurfacePoint {
            row: None,
            column: Some(3),
            corner: None,
            position_mm: position_mm(2.5, 3.0, WALL_MM),
            colour: [10, 20, 30],
            confidence: 0.5,
        }])
        .collect()
}

fn picture(grey: u8) -> RgbImage {
    RgbImage::from_fn(CAMERA.width, CAMERA.height, |x, y| {
        Pixel([grey, (x % 64) as u8, (y % 64) as u8])
    })
}

fn calibration() -> RigCalibration {
    let lens = |size: RasterSize| Lens {
        width: size.width,
        height: size.height,
        fx: FOCAL_PX,
        fy: FOCAL_PX,
        cx: f64::from(size.width) / 2.0,
        cy: f64::from(size.height) / 2.0,
        distortion: [0.0; 5],
    };
    RigCalibration {
        camera: lens(CAMERA),
        projector: lens(RASTER),
        projector_from_camera: Pose {
            translation_mm: Vector3::new(200.0, 0.0, 0.0),
            ..Pose::identity()
        },
    }
}

/// A recorded scan with one capture of each kind.
pub(super) fn recorded(dir: &Path, calibrated: bool) -> ScanFolder {
    let projected = Projected {
        pattern: GridSettings::default(),
        raster: RASTER,
    };
    let mut folder = ScanFolder::create(dir, &projected, CAMERA).unwrap();
    for stage in Stage::BOTH {
        for (shows, grey) in Shows::RECORDING.into_iter().zip([10, 200, 80, 90]) {
            folder.add_capture(stage, shows, &picture(grey)).unwrap();
        }
    }
    if calibrated {
        folder.set_calibration(&calibration()).unwrap();
    }
    folder
}

/// What the pipeline gives for this scan.
pub(super) fn result(calibrated: bool) -> ScanResult {
    let (background, object) = (reading(Stage::Background), reading(Stage::Object));
    ScanResult {
        method: Method::Likelihood,
        depth_per_px: THESIS_DEPTH_PER_PX,
        shifts: find_shifts(&background.grid, &object.grid, THESIS_DEPTH_PER_PX),
        background: Some(background),
        object: Some(object),
        surface: if calibrated { surface() } else { Vec::new() },
        settings: serde_json::json!({"lines": {"sigma_px": 1.5}}),
        ..ScanResult::default()
    }
}

/// Writes the results of a recorded scan.
pub(super) fn write(folder: &ScanFolder, calibrated: bool) -> Result<ResultPaths, OutputError> {
    write_results(folder, &stage_pictures(), &result(calibrated), None)
}

/// One picture of the pipeline for each stage.
pub(super) fn stage_pictures() -> [Vec<EncodedPicture>; 2] {
    Stage::BOTH.map(|stage| {
        let picture = StagePicture {
            name: "gain",
            caption: "Light of the projector, without the room's & the surface's <share>.".into(),
            picture: picture(60),
        };
        EncodedPicture::of_stage(stage, vec![picture]).unwrap()
    })
}

/// A choice among four colours, with round numbers.
pub(super) fn selection() -> ColourSelection {
    let names = ["red", "yellow", "magenta", "green"];
    let best = [[255, 0, 0], [255, 255, 0], [255, 0, 255], [0, 255, 0]].map(Rgb);
    let set = ColourSet {
        colours: best,
        names: names.map(str::to_owned),
        expected_error: 0.004,
        least_distance: 4.3,
    };
    let table = |value: f64| vec![vec![value; 4]; 4];
    let score = |(name, colour): (&str, Rgb)| ColourScore {
        name: name.to_owned(),
        colour,
        recovered_px: 20_994,
        share_of_expected: 0.58,
        hue_histogram: (0..64).map(|bin| bin % 7).collect(),
        response: [0.9, 0.1, 0.1],
        line_error_px: 0.061,
    };
    let tile = |k: u32| TileScore {
        x_px: k % 4 * 160,
        y_px: k / 4 * 160,
        width_px: 160,
        height_px: 160,
        lit: 0.9,
        expected_error: (k != 5).then_some(0.02),
        seen: if k == 5 { Vec::new() } else { vec![0.9; 4] },
    };
    ColourSelection {
        best,
        unary: best[0],
        expected_error: 0.004,
        measured: true,
        changed: true,
        colours: names.into_iter().zip(best).map(score).collect(),
        separability: Separability {
            error: table(0.015),
            distance: table(4.3),
            dark_error: vec![0.001; 4],
            dark_distance: vec![6.0; 4],
        },
        ranking: vec![set.clone()],
        thesis_choice: set.clone(),
        current: Some(set),
        tiles: (0..12).map(tile).collect(),
        reasons: vec!["red is expected to be read well.".into()],
    }
}
