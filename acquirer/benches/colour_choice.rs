//! How long the choice of colours takes at 640 x 480, once the frames are there.
//!
//! `separability` is the measuring and predicting, `choice` all of it: with the thesis's score, which looks
//! at a lattice of pixels of the sixteen frames.

#[path = "../tests/painted_wall/wall.rs"]
mod wall;

use acquirer::pipeline::{
    Projected,
    colour_choice::{choose_colours, measure_separability},
};
use criterion::{Criterion, criterion_group, criterion_main};
use shared::pattern::{GridSettings, RasterSize};
use wall::PaintedWall;

fn colour_choice(criterion: &mut Criterion) {
    let wall = PaintedWall {
        size: RasterSize {
            width: 640,
            height: 480,
        },
        ..PaintedWall::coloured(0.8, 0.3)
    };
    let pattern = GridSettings::default();
    let trial = wall.trial(&pattern.coded);
    let projected = Projected {
        pattern,
        raster: wall.size,
    };
    let mut group = criterion.benchmark_group("colour_choice");
    group.sample_size(20);
    group.bench_function("separability", |bencher| {
        bencher.iter(|| measure_separability(&trial));
    });
    group.bench_function("choice", |bencher| {
        bencher.iter(|| choose_colours(&trial, &projected, None));
    });
    group.finish();
}

criterion_group!(benches, colour_choice);
criterion_main!(benches);
