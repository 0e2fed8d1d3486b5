//! Reading frame after frame takes no new memory once the first frames have been read.

#![allow(clippy::unwrap_used)] // a fixture that can't be made fails its test

use std::{alloc::System, fs, path::Path};

use image::RgbImage;
use pipeline::{PipelineSettings, Projected, Reader};
use rayon::ThreadPoolBuilder;
use shared::{
    pattern::{GridSettings, Pattern},
    simulation::{Room, Scene},
    stage::Stage,
};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

/// Counts what all threads of this program allocate: so this file has one test.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn scene() -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/scenes");
    let text = fs::read_to_string(folder.join("cube.toml")).unwrap();
    Scene::parse(&text, &folder).unwrap()
}

/// Frames of one pattern, each with its own noise.
fn shoot(scene: &Scene, pattern: &Pattern, numbers: std::ops::Range<u64>) -> Vec<RgbImage> {
    let room = Room::new(scene, Stage::Object);
    let light = scene.project(&pattern.raster(scene.projector_size()));
    numbers.map(|number| room.render(&light, number)).collect()
}

/// The frames with something bright in the middle that is not there any more when the grid is shown.
fn with_a_bright_sheet(frames: &[RgbImage]) -> Vec<RgbImage> {
    let mut frames = frames.to_vec();
    for (x, y, pixel) in frames.iter_mut().flat_map(RgbImage::enumerate_pixels_mut) {
        if (200..440).contains(&x) && (140..340).contains(&y) {
            pixel.0 = pixel.0.map(|byte| byte.saturating_add(80));
        }
    }
    frames
}

/// How often a reader allocated or enlarged memory for a repetition of frames that it knows, and for new ones.
fn allocations(reader: &mut Reader, known: &[RgbImage], new: &[RgbImage]) -> [usize; 2] {
    let mut read = |frames: &[RgbImage]| {
        let region = Region::new(ALLOCATOR);
        let crossings = frames
            .iter()
            .map(|frame| reader.read(frame).unwrap().crossings.len());
        assert!(crossings.min() > Some(170), "of 225");
        let change = region.change();
        change.allocations + change.reallocations
    };
    // in the second round each frame finds the lists that the other one left
    for _ in 0..2 {
        read(known);
    }
    let again: usize = (0..3).map(|_| read(known)).sum();
    [again, read(new)]
}

#[test]
fn frames_like_those_before_allocate_nothing_on_any_number_of_threads() {
    let scene = scene();
    let black = shoot(&scene, &Pattern::BLACK, 0..2);
    let white = shoot(&scene, &Pattern::WHITE, 2..4);
    let coded = shoot(&scene, &GridSettings::default().coded.into(), 4..10);
    let [black_before, white_before] = [&black, &white].map(|frames| with_a_bright_sheet(frames));
    let projected = Projected {
        pattern: GridSettings::default(),
        raster: scene.projector_size(),
    };
    let rig = scene.calibration();
    let still = PipelineSettings {
        pictures: false,
        ..PipelineSettings::default()
    };
    let live = PipelineSettings::live();
    // threads take memory when they start and when they end: all are there from here to the end
    let pools = [1, 2].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.broadcast(|_| ());
        pool
    });
    let captured = (&black[..], &white[..]);
    let changed = (&black_before[..], &white_before[..]);
    for (references, threads, calibration, settings, case) in [
        (captured, 1, Some(&rig), live, "live"),
        (captured, 2, Some(&rig), live, "live on two threads"),
        (captured, 1, None, live, "live without calibration"),
        (captured, 1, None, still, "still"),
        (captured, 2, None, still, "still on two threads"),
        (changed, 1, Some(&rig), live, "something moved since"),
        (changed, 2, None, still, "something moved, still"),
        (
            (&black[..], &white[..0]),
            1,
            Some(&rig),
            live,
            "without white",
        ),
        (
            (&black[..0], &white[..]),
            1,
            Some(&rig),
            live,
            "without black",
        ),
        (
            (&black[..0], &white[..0]),
            2,
            Some(&rig),
            live,
            "without references",
        ),
    ] {
        // in the pool: handing it a frame from outside takes a little memory of its own now and then
        let [again, new] = pools[threads - 1].install(|| {
            let mut reader = Reader::new(references, &projected, calibration, &settings).unwrap();
            allocations(&mut reader, &coded[..2], &coded[2..])
        });
        assert_eq!(again, 0, "for six known frames, {case}");
        // a frame with more in it than any before enlarges lists, each by half at least
        assert!(new <= 60, "{new} for four new frames, {case}");
    }
}
