//! How long the choice of colours takes at three camera sizes, once the frames are there: all of it, on one thread,
//! with the thesis's score.
//!
//! Run with `cargo bench -p acquirer --bench colour_choice`; `--profile dev` times what the demo and the tests run. The
//! example `choice_time` prints CPU time, for a machine that others use as well.

#[path = "../tests/painted_wall/wall.rs"]
mod wall;

use acquirer::pipeline::{Projected, colour_choice::choose_colours};
use criterion::{Criterion, criterion_group, criterion_main};
use rayon::ThreadPoolBuilder;
use shared::pattern::{GridSettings, RasterSize};
use wall::PaintedWall;

fn colour_choice(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("colour_choice");
    group.sample_size(20);
    let threads = ThreadPoolBuilder::new().num_threads(1);
    let threads = threads.build().expect("a thread can be started");
    for (width, height) in [(640, 480), (1280, 720), (1920, 1080)] {
        let wall = PaintedWall {
            size: RasterSize { width, height },
            ..PaintedWall::coloured(0.8, 0.3)
        };
        let pattern = GridSettings::default();
        let trial = wall.trial(&pattern.coded);
        let projected = Projected {
            pattern,
            raster: wall.size,
        };
        group.bench_function(format!("{width}x{height}"), |bencher| {
            threads.install(|| bencher.iter(|| choose_colours(&trial, &projected, None)));
        });
    }
    group.finish();
}

criterion_group!(benches, colour_choice);
criterion_main!(benches);
