//! Time of one whole stage, from captures to the decoded grid, on the pattern's own raster at 640 x 480.

use acquirer::pipeline::{Captures, PipelineSettings, Projected, read_stage};
use criterion::{Criterion, criterion_group, criterion_main};
use image::RgbImage;
use shared::pattern::{GridSettings, Pattern, RasterSize};

fn whole_frame(criterion: &mut Criterion) {
    let raster = RasterSize {
        width: 640,
        height: 480,
    };
    let pattern = GridSettings::default();
    let shot = |pattern: Pattern| {
        let bytes = pattern.raster(raster).into_bytes();
        RgbImage::from_raw(raster.width, raster.height, bytes).unwrap_or_default()
    };
    let captures = Captures {
        black: vec![shot(Pattern::BLACK)],
        white: vec![shot(Pattern::WHITE)],
        prmvs: vec![shot(pattern.coded.clone().into())],
        unary: vec![shot(pattern.unary_grid().into())],
        solid: Vec::new(),
    };
    let projected = Projected { pattern, raster };
    let settings = PipelineSettings {
        pictures: false,
        ..PipelineSettings::default()
    };
    criterion.bench_function("read_stage 640x480", |bencher| {
        bencher.iter(|| read_stage(&captures, &projected, None, &settings));
    });
}

criterion_group!(benches, whole_frame);
criterion_main!(benches);
