//! Choosing the grid's colours in the shipped simulated rooms: posters, patches, a ball.

use std::path::Path;

use acquirer::pipeline::{Method, Projected, colour_choice::choose_colours};
use image::RgbImage;
use rig_tests::measure::{Reading, Repeats, SimulatedScan, Sum, colour_trial};
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, Grid, GridSettings, Pattern, Rgb},
    simulation::{Room, Scene},
    stage::Stage,
};

use crate::colour_choice::{FIXED, nearest};

/// A common webcam's noise, for the reading that is compared: standard deviation without light, and variance
/// per unit of light.
const NOISE: (f64, f64) = (0.002, 1.5e-4);

/// A shipped scene with everything that shows a picture in it.
struct Simulated {
    scene: Scene,
    room: Room,
}

impl Simulated {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/scenes");
        let scene = Scene::load(&folder.join(name).with_extension("toml")).unwrap();
        let room = Room::new(&scene, Stage::Object);
        Self { scene, room }
    }

    fn shoot(&self, pattern: &Pattern, number: u64) -> RgbImage {
        let picture = pattern.raster(self.scene.projector_size());
        self.room.render(&self.scene.project(&picture), number)
    }

    /// The camera pixels in the middle of a column and away from rows, with the column's symbol.
    fn column_pixels(&self, grid: &Grid) -> Vec<((u32, u32), usize)> {
        let size = self.scene.projector_size();
        let from_line = |axis: Axis, at: f64| {
            let k = (at / grid.pitch_px(axis, size)) as usize;
            (k, (at - grid.line(axis, k, size).centre_px()).abs())
        };
        let (width, height) = self.scene.camera_size();
        let mut pixels = Vec::new();
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let middle = CameraPixel::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(at) = self.room.projector_at(middle) else {
                continue;
            };
            let (column, from_column) = from_line(Axis::Column, at.x);
            let (_, from_row) = from_line(Axis::Row, at.y);
            if let Some(symbol) = grid.symbols(Axis::Column).get(column)
                && from_column < 0.2 * f64::from(grid.width_px(Axis::Column))
                && from_row > 1.2 * f64::from(grid.width_px(Axis::Row))
            {
                pixels.push(((x, y), usize::from(symbol.0)));
            }
        }
        pixels
    }
}

#[test]
fn in_a_coloured_room_the_choice_beats_the_fixed_set_in_expected_and_in_measured_error() {
    let room = Simulated::new("coloured-room");
    let pattern = GridSettings::default();
    let projected = Projected {
        pattern: pattern.clone(),
        raster: room.scene.projector_size(),
    };
    let trial = colour_trial(&room.scene, Stage::Object, &pattern.coded);
    let fixed = choose_colours(&trial, &projected, Some(FIXED)).unwrap();
    let chosen = choose_colours(&trial, &projected, None).unwrap();
    let (dark, unary) = (
        room.shoot(&Pattern::BLACK, 30),
        room.shoot(&pattern.coded.unary(Rgb::WHITE).into(), 31),
    );
    let pixels = room.column_pixels(&pattern.coded);
    let measured = |colours: [Rgb; 4]| {
        let grid = pattern.coded.recoloured(&colours).unwrap();
        let frame = room.shoot(&grid.into(), 32);
        let responses = colours.map(|colour| {
            let score = chosen.colours.iter().find(|c| c.colour == colour);
            score.unwrap().response
        });
        let is_wrong = |(at, symbol): &&((u32, u32), usize)| {
            nearest(&responses, &dark, &unary, &frame, *at, NOISE) != *symbol
        };
        pixels.iter().filter(is_wrong).count() as f64 / pixels.len() as f64
    };
    let (ours, theirs) = (measured(chosen.best), measured(FIXED));
    let expected = (chosen.expected_error, fixed.current.unwrap().expected_error);
    println!(
        "{:?}: expected {:.4} against {:.4}, measured {ours:.4} against {theirs:.4}, thesis {:?} {:.4} \
         measured {:.4}\n{}",
        chosen.best,
        expected.0,
        expected.1,
        chosen.thesis_choice.names,
        chosen.thesis_choice.expected_error,
        measured(chosen.thesis_choice.colours),
        chosen.reasons.join("\n")
    );
    assert!(pixels.len() > 5000);
    assert!(expected.0 < 0.8 * expected.1, "{expected:?}");
    assert!(ours < theirs, "{ours} {theirs}");
}

/// How a coded frame of both stages is read without a unary one.
fn read_alone(scene: &Scene, colours: [Rgb; 4]) -> Sum {
    let pattern = GridSettings {
        coded: GridSettings::default().coded.recoloured(&colours).unwrap(),
        unary: Rgb::WHITE,
    };
    let repeats = Repeats {
        references: 2,
        coded: 1,
        unary: 0,
    };
    let scan = SimulatedScan::record(scene, &pattern, repeats);
    let reading = Reading {
        projected: &scan.projected,
        calibration: Some(&scan.calibration),
        method: Method::Likelihood,
    };
    let mut sum = Sum::default();
    for (stage, captures) in Stage::BOTH.into_iter().zip(&scan.stages) {
        sum.add(&reading.score(captures, &scan.truth, stage).unwrap().0);
    }
    sum
}

#[test]
fn in_a_coloured_room_a_coded_frame_alone_is_read_better_in_the_chosen_colours() {
    let room = Simulated::new("coloured-room");
    let pattern = GridSettings::default();
    let projected = Projected {
        pattern: pattern.clone(),
        raster: room.scene.projector_size(),
    };
    let trial = colour_trial(&room.scene, Stage::Object, &pattern.coded);
    let selection = choose_colours(&trial, &projected, Some(FIXED)).unwrap();
    let (ours, theirs) = (
        read_alone(&room.scene, selection.best),
        read_alone(&room.scene, FIXED),
    );
    println!("{ours:?} against {theirs:?}");
    assert!(ours.coverage_percent() > theirs.coverage_percent());
    assert_eq!(ours.wrong, 0);
}
