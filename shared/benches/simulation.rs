//! Times of the simulated room at 640 x 480: working out a room, a projector picture, a frame.
//!
//! Run: `cargo bench -p shared --bench simulation`.

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use shared::{
    pattern::{Grid, Pattern, Rgb},
    simulation::{Room, Scene},
    stage::Stage,
};

fn simulation(criterion: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/scenes/cube.toml");
    let scene = Scene::load(&path).expect("the scene is part of the repository");
    let colours = [[255, 0, 0], [255, 255, 0], [255, 0, 255], [0, 255, 0]].map(Rgb);
    let grid = Grid::coded(15, 15, 6, 6, &colours).expect("a grid of 15 lines exists");
    let picture = Pattern::Grid(grid).raster(scene.projector_size());
    let room = Room::new(&scene, Stage::Object);
    let light = scene.project(&picture);

    let mut group = criterion.benchmark_group("simulation");
    group.sample_size(20);
    group.bench_function("room", |b| {
        b.iter(|| Room::new(black_box(&scene), Stage::Object));
    });
    group.bench_function("picture", |b| b.iter(|| scene.project(black_box(&picture))));
    let mut frame_number = 0;
    group.bench_function("frame", |b| {
        b.iter(|| {
            frame_number += 1;
            room.render(black_box(&light), frame_number)
        });
    });
    group.finish();
}

criterion_group!(benches, simulation);
criterion_main!(benches);
