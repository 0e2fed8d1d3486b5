//! The pipeline on pictures made here: the pattern's own raster seen through known homographies, with
//! colours, ambient light, blur and noise.

#![allow(clippy::unwrap_used)] // a fixture that can't be made fails its test

use acquirer::pipeline::{
    Captures, PipelineError, PipelineSettings, Projected, StageReading, grid::DropReason,
    read_stage,
};
use image::RgbImage;
use nalgebra::{Matrix3, Vector3};
use shared::pattern::{Corner, Grid, GridSettings, Pattern, Raster, RasterSize, Rgb};

const RASTER: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};
const BOLD: [[u8; 3]; 4] = [[255, 0, 0], [255, 255, 0], [255, 0, 255], [0, 255, 0]];

/// A flat scene seen by a camera without distortion.
struct Scene {
    size: (u32, u32),
    /// Projector px (homogeneous) from camera px.
    projector_from_camera: Matrix3<f64>,
    ambient: f64,
    noise: f64,
    albedo: fn(f64, f64) -> [f64; 3],
}

fn grey(_: f64, _: f64) -> [f64; 3] {
    [0.6; 3]
}

/// Patches of strong colours, 60 px wide, as on posters.
fn patchwork(x: f64, y: f64) -> [f64; 3] {
    const SOME: [[f64; 3]; 5] = [
        [0.6, 0.15, 0.1],
        [0.1, 0.5, 0.15],
        [0.5, 0.5, 0.5],
        [0.7, 0.6, 0.1],
        [0.15, 0.2, 0.6],
    ];
    let patch = (x / 60.0).floor() as i64 * 7 + (y / 60.0).floor() as i64 * 3;
    SOME[patch.rem_euclid(5) as usize]
}

impl Scene {
    /// A camera that sees the whole projected picture, turned by some degrees and tilted.
    fn seen(size: (u32, u32), turn_deg: f64, tilt: f64) -> Self {
        let (w, h) = (f64::from(size.0), f64::from(size.1));
        let scale =
            0.92 * (w / 1024.0).min(h / 768.0) / (1.0 + 0.6 * turn_deg.to_radians().sin().abs());
        let turn = Matrix3::new_rotation(turn_deg.to_radians());
        let centred = Matrix3::new_translation(&nalgebra::Vector2::new(-512.0, -384.0));
        let tilted = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, tilt / w, 0.3 * tilt / h, 1.0);
        let placed = Matrix3::new(scale, 0.0, w / 2.0, 0.0, scale, h / 2.0, 0.0, 0.0, 1.0);
        let camera_from_projector = placed * tilted * turn * centred;
        Self {
            size,
            projector_from_camera: camera_from_projector.try_inverse().unwrap(),
            ambient: 0.03,
            noise: 0.004,
            albedo: grey,
        }
    }

    fn camera(&self, x: f64, y: f64) -> (f64, f64) {
        let p = self.projector_from_camera.try_inverse().unwrap() * Vector3::new(x, y, 1.0);
        (p.x / p.z, p.y / p.z)
    }

    /// What the camera gives while the projector shows a picture.
    fn capture(&self, raster: &Raster, seed: u64) -> RgbImage {
        const SUB: u32 = 3; // samples per pixel and direction: the sensor's area
        let mut random = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        RgbImage::from_fn(self.size.0, self.size.1, |x, y| {
            let mut light = [0.0; 3];
            for sub in 0..SUB * SUB {
                let at = |k: u32, sub: u32| f64::from(k) + (f64::from(sub) + 0.5) / f64::from(SUB);
                let p = self.projector_from_camera
                    * Vector3::new(at(x, sub % SUB), at(y, sub / SUB), 1.0);
                let (u, v) = (p.x / p.z, p.y / p.z);
                if u >= 0.0 && v >= 0.0 {
                    let Rgb(colour) = raster.pixel(u as u32, v as u32);
                    for c in 0..3 {
                        light[c] += linear(colour[c]) / f64::from(SUB * SUB);
                    }
                }
            }
            let albedo = (self.albedo)(f64::from(x), f64::from(y));
            image::Rgb(std::array::from_fn(|c| {
                let clean = albedo[c] * (light[c] + self.ambient);
                byte(clean + normal(&mut random) * (self.noise * (0.3 + clean)))
            }))
        })
    }

    fn captures(&self, pattern: &GridSettings) -> Captures {
        let shot = |pattern: Pattern, seed| self.capture(&pattern.raster(RASTER), seed);
        Captures {
            black: vec![shot(Pattern::BLACK, 1), shot(Pattern::BLACK, 2)],
            white: vec![shot(Pattern::WHITE, 3), shot(Pattern::WHITE, 4)],
            prmvs: vec![shot(pattern.coded.clone().into(), 5)],
            unary: vec![shot(pattern.unary_grid().into(), 6)],
        }
    }
}

fn linear(byte: u8) -> f64 {
    let value = f64::from(byte) / 255.0;
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

fn byte(light: f64) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (value * 255.0).round() as u8
}

/// About normal: the sum of four uniform numbers.
fn normal(state: &mut u64) -> f64 {
    let mut sum = 0.0;
    for _ in 0..4 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        sum += (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
    }
    sum * 3f64.sqrt()
}

fn pattern(rows: usize, columns: usize, width_px: u32, colours: &[[u8; 3]]) -> GridSettings {
    let colours: Vec<Rgb> = colours.iter().map(|&c| Rgb(c)).collect();
    GridSettings {
        coded: Grid::coded(rows, columns, width_px, width_px, &colours).unwrap(),
        unary: Rgb::WHITE,
    }
}

fn projected(pattern: &GridSettings) -> Projected {
    Projected {
        pattern: pattern.clone(),
        raster: RASTER,
    }
}

fn quiet() -> PipelineSettings {
    PipelineSettings {
        pictures: false,
        ..PipelineSettings::default()
    }
}

fn read(captures: &Captures, pattern: &GridSettings) -> StageReading {
    read_stage(captures, &projected(pattern), None, &quiet()).unwrap()
}

/// Share of the grid's crossings well inside the picture that were read, number of wrong labels, RMS and mean
/// outward error of the vertices in px.
fn judge(scene: &Scene, pattern: &GridSettings, reading: &StageReading) -> (f64, usize, f64, f64) {
    const BORDER_PX: f64 = 25.0;
    let grid = &pattern.coded;
    let inside = |x: f64, y: f64| {
        x > BORDER_PX
            && y > BORDER_PX
            && x < f64::from(scene.size.0) - BORDER_PX
            && y < f64::from(scene.size.1) - BORDER_PX
    };
    let (mut expected, mut found) = (0, 0);
    for row in 0..grid.rows() as u16 {
        for column in 0..grid.columns() as u16 {
            let index = shared::pattern::GridIndex { row, column };
            let p = grid.vertex(index, Corner::UpperLeft, RASTER);
            let (x, y) = scene.camera(p.x, p.y);
            if inside(x, y) {
                expected += 1;
                found += usize::from(reading.grid.crossing(index).is_some());
            }
        }
    }
    let (mut wrong, mut squares, mut outward, mut count) = (0, 0.0, 0.0, 0.0);
    for crossing in &reading.grid.crossings {
        for (corner, seen) in Corner::ALL.into_iter().zip(crossing.vertices) {
            let p = grid.vertex(crossing.index, corner, RASTER);
            let (x, y) = scene.camera(p.x, p.y);
            let (dx, dy) = (seen.x - x, seen.y - y);
            if dx.hypot(dy) > 2.0 {
                wrong += 1;
                continue;
            }
            let (ox, oy) = (x - crossing.centre.x, y - crossing.centre.y);
            squares += dx * dx + dy * dy;
            outward += (dx * ox + dy * oy) / ox.hypot(oy);
            count += 1.0;
        }
    }
    let count = f64::max(count, 1.0);
    (
        f64::from(found as u32) / f64::from(expected.max(1)),
        wrong,
        (squares / count).sqrt(),
        outward / count,
    )
}

fn assert_read(
    scene: &Scene,
    pattern: &GridSettings,
    captures: &Captures,
    least_share: f64,
    rms_px: f64,
) {
    let reading = read(captures, pattern);
    let (share, wrong, rms, bias) = judge(scene, pattern, &reading);
    assert_eq!(wrong, 0, "wrong labels");
    assert!(
        share >= least_share,
        "read {share:.3}, dropped {:?}",
        reading.grid.dropped_by_reason()
    );
    assert!(rms <= rms_px, "rms {rms:.4} px");
    assert!(bias.abs() <= 0.05, "bias {bias:.4} px");
}

#[test]
fn a_grey_wall_is_read_whole_and_without_bias() {
    let scene = Scene::seen((640, 480), 3.0, 0.15);
    let pattern = pattern(15, 15, 6, &BOLD);
    assert_read(&scene, &pattern, &scene.captures(&pattern), 0.995, 0.1);
}

#[test]
fn strongly_coloured_patches_are_read_as_well() {
    let scene = Scene {
        albedo: patchwork,
        ambient: 0.1,
        ..Scene::seen((640, 480), -4.0, 0.1)
    };
    let pattern = pattern(15, 15, 6, &BOLD);
    assert_read(&scene, &pattern, &scene.captures(&pattern), 0.97, 0.15);
}

#[test]
fn different_line_counts_and_a_finer_camera_are_read() {
    let scene = Scene::seen((1280, 960), 2.0, -0.1);
    let pattern = pattern(63, 31, 4, &BOLD);
    assert_read(&scene, &pattern, &scene.captures(&pattern), 0.97, 0.15);
}

#[test]
fn two_colours_are_read() {
    let scene = Scene::seen((640, 480), 0.0, 0.1);
    let pattern = pattern(31, 15, 5, &[[255, 0, 0], [0, 255, 255]]);
    assert_read(&scene, &pattern, &scene.captures(&pattern), 0.97, 0.15);
}

#[test]
fn without_the_unary_grid_the_coded_one_gives_the_geometry() {
    let scene = Scene::seen((640, 480), 3.0, 0.1);
    let pattern = pattern(15, 15, 6, &BOLD);
    let captures = Captures {
        unary: Vec::new(),
        ..scene.captures(&pattern)
    };
    assert_read(&scene, &pattern, &captures, 0.97, 0.2);
}

#[test]
fn without_black_and_white_the_unary_grid_is_the_reference() {
    let scene = Scene::seen((640, 480), 3.0, 0.1);
    let pattern = pattern(15, 15, 6, &BOLD);
    let captures = Captures {
        black: Vec::new(),
        white: Vec::new(),
        ..scene.captures(&pattern)
    };
    assert_read(&scene, &pattern, &captures, 0.95, 0.2);
}

#[test]
fn a_grid_turned_by_a_right_angle_is_read() {
    let scene = Scene::seen((640, 640), 90.0, 0.05);
    let pattern = pattern(15, 15, 6, &BOLD);
    assert_read(&scene, &pattern, &scene.captures(&pattern), 0.97, 0.2);
}

#[test]
fn a_turned_grid_is_read() {
    let scene = Scene::seen((800, 800), 12.0, 0.1);
    let pattern = pattern(15, 15, 8, &BOLD);
    assert_read(&scene, &pattern, &scene.captures(&pattern), 0.9, 0.2);
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let scene = Scene {
        albedo: patchwork,
        ..Scene::seen((320, 240), 3.0, 0.1)
    };
    let pattern = pattern(15, 15, 8, &BOLD);
    let captures = scene.captures(&pattern);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| read(&captures, &pattern).grid)
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn colours_that_look_alike_are_dropped_not_guessed() {
    // a part of the grid: with all lines in view their number alone would tell which they are
    let mut scene = Scene::seen((640, 480), 3.0, 0.1);
    scene.projector_from_camera *= Matrix3::new_translation(&nalgebra::Vector2::new(200.0, 150.0));
    let alike = [[255, 0, 0]; 4];
    let pattern = pattern(15, 15, 6, &alike);
    let reading = read(&scene.captures(&pattern), &pattern);
    assert!(reading.grid.crossings.is_empty());
    let ambiguous = reading.grid.dropped_by_reason()[2];
    assert_eq!(ambiguous.0, DropReason::AmbiguousColour);
    assert!(ambiguous.1 > 100, "{:?}", reading.grid.dropped_by_reason());
}

#[test]
fn another_code_than_the_projected_one_is_not_found_in_the_picture() {
    let scene = Scene::seen((640, 480), 3.0, 0.1);
    let shown = pattern(31, 31, 4, &BOLD);
    let mut json = serde_json::to_value(&shown).unwrap();
    json["row_symbols"] = vec![0; 31].into();
    let asked: GridSettings = serde_json::from_value(json).unwrap();
    let reading = read(&scene.captures(&shown), &asked);
    assert!(reading.grid.crossings.is_empty());
    assert!(!reading.grid.dropped.is_empty());
}

#[test]
fn an_overexposed_scene_gives_no_wrong_labels() {
    let scene = Scene {
        ambient: 1.6,
        ..Scene::seen((640, 480), 3.0, 0.1)
    };
    let pattern = pattern(15, 15, 6, &BOLD);
    let (_, wrong, _, _) = judge(&scene, &pattern, &read(&scene.captures(&pattern), &pattern));
    assert_eq!(wrong, 0);
}

#[test]
fn broken_captures_are_refused_or_give_nothing_but_never_panic() {
    let pattern = pattern(15, 15, 6, &BOLD);
    let all = |picture: RgbImage| Captures {
        black: vec![picture.clone()],
        white: vec![picture.clone()],
        prmvs: vec![picture.clone()],
        unary: vec![picture],
    };
    let read = |captures: &Captures| {
        read_stage(
            captures,
            &projected(&pattern),
            None,
            &PipelineSettings::default(),
        )
    };
    assert_eq!(
        read(&Captures::default()).unwrap_err(),
        PipelineError::NoCodedCapture
    );
    assert!(matches!(
        read(&all(RgbImage::new(0, 0))),
        Err(PipelineError::Empty { .. })
    ));
    let mut odd = all(RgbImage::new(40, 30));
    odd.white = vec![RgbImage::new(30, 40)];
    assert!(matches!(read(&odd), Err(PipelineError::SizesDiffer { .. })));
    let mut random = 7;
    let noise = RgbImage::from_fn(160, 120, |_, _| {
        image::Rgb(std::array::from_fn(|_| {
            (128.0 + 60.0 * normal(&mut random)) as u8
        }))
    });
    let white = |w, h| RgbImage::from_pixel(w, h, image::Rgb([255; 3]));
    let sizes = [(1, 1), (2, 3), (1, 50), (50, 1), (64, 48)];
    let pictures = sizes
        .iter()
        .flat_map(|&(w, h)| [RgbImage::new(w, h), white(w, h)]);
    for picture in pictures.chain([noise]) {
        let reading = read(&all(picture.clone())).unwrap();
        assert!(reading.grid.crossings.is_empty());
        let alone = Captures {
            prmvs: vec![picture],
            ..Captures::default()
        };
        assert!(read(&alone).unwrap().grid.crossings.is_empty());
    }
}

#[test]
fn what_moved_since_the_references_is_read_by_its_own_light() {
    /// The patchwork, with a dark sheet over it that the references do not show.
    fn with_a_new_sheet(x: f64, y: f64) -> [f64; 3] {
        if (200.0..420.0).contains(&x) && (120.0..330.0).contains(&y) {
            [0.25, 0.2, 0.2]
        } else {
            patchwork(x, y)
        }
    }
    let before = Scene {
        ambient: 0.25,
        albedo: patchwork,
        ..Scene::seen((640, 480), 2.0, 0.1)
    };
    let after = Scene {
        albedo: with_a_new_sheet,
        ..Scene::seen((640, 480), 2.0, 0.1)
    };
    let after = Scene {
        ambient: before.ambient,
        ..after
    };
    let pattern = GridSettings {
        unary: Rgb([255; 3]),
        ..pattern(15, 15, 8, &BOLD)
    };
    let mut captures = after.captures(&pattern);
    let references = before.captures(&pattern);
    (captures.black, captures.white) = (references.black, references.white);
    let reading = read(&captures, &pattern);
    let (coverage, wrong, _, _) = judge(&after, &pattern, &reading);
    assert_eq!(wrong, 0);
    assert!(coverage > 0.9, "{coverage}");
}
