//! The thesis's method on painted walls whose camera sees the projector pixel for pixel, so that every
//! vertex's place is known.

use crate::wall::PaintedWall;
use acquirer::pipeline::{
    Captures, PipelineError, Projected, StageReading,
    thesis::{ThesisSettings, read_stage},
};
use image::RgbImage;
use proptest::prelude::*;
use shared::pattern::{Corner, Grid, GridSettings, Pattern, RasterSize, Rgb};

fn wall() -> PaintedWall {
    PaintedWall {
        size: RasterSize {
            width: 640,
            height: 480,
        },
        ..PaintedWall::grey()
    }
}

fn captures(wall: &PaintedWall, pattern: &GridSettings) -> Captures {
    Captures {
        black: (1..4)
            .map(|seed| wall.shoot(&Pattern::BLACK, seed))
            .collect(),
        prmvs: vec![wall.shoot(&pattern.coded.clone().into(), 5)],
        unary: vec![wall.shoot(&pattern.unary_grid().into(), 6)],
        ..Captures::default()
    }
}

fn read(wall: &PaintedWall, pattern: &GridSettings, captures: &Captures) -> StageReading {
    let projected = Projected {
        pattern: pattern.clone(),
        raster: wall.size,
    };
    read_stage(captures, &projected, &ThesisSettings::default()).unwrap()
}

/// How many crossings were read, how many of them with a wrong label, and the farthest vertex of the others
/// from its place, in pixels.
fn score(reading: &StageReading, grid: &Grid, size: RasterSize) -> (usize, usize, f64) {
    let (mut wrong, mut farthest) = (0, 0.0_f64);
    for crossing in &reading.grid.crossings {
        let distance = |(k, corner): (usize, Corner)| {
            let truth = grid.vertex(crossing.index, corner, size);
            (crossing.vertices[k].x - truth.x).hypot(crossing.vertices[k].y - truth.y)
        };
        let worst = Corner::ALL
            .into_iter()
            .enumerate()
            .map(distance)
            .fold(0.0, f64::max);
        if worst > 8.0 {
            wrong += 1;
        } else {
            farthest = farthest.max(worst);
        }
    }
    (reading.grid.crossings.len(), wrong, farthest)
}

fn red_unary() -> GridSettings {
    GridSettings {
        unary: Rgb([255, 0, 0]),
        ..GridSettings::default()
    }
}

#[test]
fn on_a_grey_wall_nearly_every_crossing_is_read_to_about_a_pixel() {
    let (wall, pattern) = (wall(), red_unary());
    let reading = read(&wall, &pattern, &captures(&wall, &pattern));
    let (count, wrong, farthest) = score(&reading, &pattern.coded, wall.size);
    assert!(
        count >= 215 && wrong == 0 && farthest <= 2.0,
        "{count} {wrong} {farthest}"
    );
    assert!(
        reading
            .grid
            .crossings
            .iter()
            .all(|c| c.confidence > 0.0 && c.confidence <= 1.0)
    );
    let whole = |v: f64| (v - 0.5).fract() == 0.0;
    assert!(
        reading
            .grid
            .crossings
            .iter()
            .flat_map(|c| c.vertices)
            .all(|v| whole(v.x) && whole(v.y))
    );
}

#[test]
fn each_step_leaves_a_picture_of_the_cameras_size() {
    let (wall, pattern) = (wall(), red_unary());
    let pictures = read(&wall, &pattern, &captures(&wall, &pattern)).pictures;
    let names: Vec<_> = pictures.iter().map(|p| p.name).collect();
    assert_eq!(
        names,
        [
            "thesis_background",
            "thesis_threshold",
            "thesis_edges",
            "thesis_grid"
        ]
    );
    for picture in pictures {
        assert_eq!(picture.picture.dimensions(), (640, 480));
        assert!(
            picture.picture.as_raw().iter().any(|b| *b > 100),
            "{} is dark",
            picture.name
        );
    }
}

#[test]
fn a_white_unary_grid_and_a_missing_one_are_read_too() {
    let (wall, pattern) = (wall(), GridSettings::default());
    let mut captures = captures(&wall, &pattern);
    let (count, wrong, _) = score(&read(&wall, &pattern, &captures), &pattern.coded, wall.size);
    assert!(count >= 200 && wrong == 0, "white: {count} {wrong}");
    captures.unary.clear();
    let (count, wrong, _) = score(&read(&wall, &pattern, &captures), &pattern.coded, wall.size);
    assert!(count >= 60 && wrong == 0, "coded alone: {count} {wrong}");
}

#[test]
fn thirty_one_lines_are_read_by_windows_of_three_by_three_and_two_colours_by_four_by_four() {
    let wall = wall();
    let colours = [[255, 0, 0], [255, 255, 0], [255, 0, 255], [0, 255, 0]].map(Rgb);
    for (lines, width, colours) in [(31, 3, &colours[..]), (15, 6, &[colours[0], colours[3]])] {
        let coded = Grid::coded(lines, lines, width, width, colours).unwrap();
        let pattern = GridSettings {
            coded,
            unary: Rgb([0, 255, 0]),
        };
        let reading = read(&wall, &pattern, &captures(&wall, &pattern));
        let (count, wrong, _) = score(&reading, &pattern.coded, wall.size);
        assert!(
            10 * count >= 7 * lines * lines && wrong == 0,
            "{lines}: {count} {wrong}"
        );
    }
}

#[test]
fn on_a_strongly_coloured_wall_it_reads_less_and_says_what_was_dropped() {
    let wall = PaintedWall {
        size: wall().size,
        ..PaintedWall::coloured(0.9, 0.5)
    };
    let pattern = red_unary();
    let reading = read(&wall, &pattern, &captures(&wall, &pattern));
    assert!(
        reading.grid.crossings.len() < 150,
        "{}",
        reading.grid.crossings.len()
    );
    assert!(!reading.grid.dropped.is_empty());
}

#[test]
fn a_dark_picture_gives_no_crossing_and_no_error() {
    let (wall, pattern) = (wall(), red_unary());
    let dark = RgbImage::new(640, 480);
    let captures = Captures {
        prmvs: vec![dark.clone()],
        unary: vec![dark.clone()],
        ..Captures::default()
    };
    assert!(read(&wall, &pattern, &captures).grid.crossings.is_empty());
    let captures = Captures {
        black: vec![dark],
        ..captures
    };
    assert!(read(&wall, &pattern, &captures).grid.crossings.is_empty());
}

#[test]
fn captures_without_the_coded_grid_without_pixels_or_of_two_sizes_are_refused() {
    let projected = Projected {
        pattern: red_unary(),
        raster: wall().size,
    };
    let refused = |captures: &Captures| {
        read_stage(captures, &projected, &ThesisSettings::default()).unwrap_err()
    };
    assert_eq!(refused(&Captures::default()), PipelineError::NoCodedCapture);
    let pixelless = Captures {
        prmvs: vec![RgbImage::new(0, 0)],
        ..Captures::default()
    };
    assert!(matches!(refused(&pixelless), PipelineError::Empty { .. }));
    let mixed = Captures {
        prmvs: vec![RgbImage::new(8, 8)],
        black: vec![RgbImage::new(8, 9)],
        ..Captures::default()
    };
    assert!(matches!(refused(&mixed), PipelineError::SizesDiffer { .. }));
}

#[test]
fn an_unknown_setting_is_refused_and_the_others_have_defaults() {
    let settings: ThesisSettings = toml::from_str("background_sigmas = 3.0").unwrap();
    assert_eq!(settings.background_sigmas, 3.0);
    assert_eq!(
        toml::from_str::<ThesisSettings>("").unwrap(),
        ThesisSettings::default()
    );
    assert!(toml::from_str::<ThesisSettings>("sigmas = 3.0").is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn no_picture_makes_it_panic(
        width in 1_u32..40,
        height in 1_u32..40,
        bytes in proptest::collection::vec(any::<u8>(), 1..64),
        symbols in proptest::collection::vec(0_u8..3, 1..6),
        repeats in 0_usize..3,
    ) {
        let noise = |shift: usize| {
            RgbImage::from_fn(width, height, |x, y| {
                let at = (x / 3 + 7 * (y / 3)) as usize * 3 + shift;
                image::Rgb([0, 1, 2].map(|c| bytes[(at + c) % bytes.len()]))
            })
        };
        let json = format!(
            r##"{{"row_symbols": {symbols:?}, "column_symbols": {symbols:?}, "row_width_px": 2,
                "column_width_px": 3, "colours": ["#ff0000", "#ffffff", "#0000ff"], "unary": "#000000"}}"##
        );
        let pattern: GridSettings = serde_json::from_str(&json).unwrap();
        let captures = Captures {
            black: (0..repeats).map(noise).collect(),
            prmvs: vec![noise(5), noise(6)],
            unary: (0..repeats).map(|k| noise(k + 9)).collect(),
            ..Captures::default()
        };
        let projected = Projected { pattern, raster: RasterSize { width: 64, height: 48 } };
        let reading = read_stage(&captures, &projected, &ThesisSettings::default()).unwrap();
        let indices: Vec<_> = reading.grid.crossings.iter().map(|c| c.index).collect();
        prop_assert!(indices.windows(2).all(|two| two[0] < two[1]));
    }
}
