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

/// How often a reader allocated or enlarged memory for a repetition of frames that it knows, and for new ones.
fn allocations(reader: &mut Reader, known: &[RgbImage], new: &[RgbImage]) -> [usize; 2] {
    let mut read = |frames: &[RgbImage]| {
        let region = Region::new(ALLOCATOR);
        let crossings = frames
            .iter()
            .map(|frame| reader.read(frame).unwrap().crossings.len());
        assert!(crossings.min() > Some(100), "the frames show the grid");
        let change = region.change();
        change.allocations + change.reallocations
    };
    read(known);
    let again: usize = (0..3).map(|_| read(known)).sum();
    [again, read(new)]
}

#[test]
fn from_the_third_frame_on_one_thread_allocates_nothing_and_more_threads_next_to_nothing() {
    let scene = scene();
    let black = shoot(&scene, &Pattern::BLACK, 0..2);
    let white = shoot(&scene, &Pattern::WHITE, 2..4);
    let coded = shoot(&scene, &GridSettings::default().coded.into(), 4..10);
    let projected = Projected {
        pattern: GridSettings::default(),
        raster: scene.projector_size(),
    };
    let rig = scene.calibration();
    for (threads, calibration, settings) in [
        (1, Some(&rig), PipelineSettings::live()),
        (2, Some(&rig), PipelineSettings::live()),
        (1, None, PipelineSettings::live()),
        (
            2,
            None,
            PipelineSettings {
                pictures: false,
                ..PipelineSettings::default()
            },
        ),
    ] {
        let pool = ThreadPoolBuilder::new().num_threads(threads);
        // in the pool: handing it a frame from outside takes a little memory of its own now and then
        let [again, new] = pool.build().unwrap().install(|| {
            let references = (&black[..], &white[..]);
            let mut reader = Reader::new(references, &projected, calibration, &settings).unwrap();
            allocations(&mut reader, &coded[..2], &coded[2..])
        });
        let case = format!("{threads} threads, calibrated: {}", calibration.is_some());
        // which thread takes which strip is left to chance: one may meet its largest piece in a later frame
        let settling = 4 * (threads - 1);
        assert!(again <= settling, "{again} for six known frames, {case}");
        // a frame with more in it than any before enlarges lists, each by half at least
        assert!(new <= 60, "{new} for four new frames, {case}");
    }
}
