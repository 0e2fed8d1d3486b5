//! Time of reading one frame, at three camera sizes: all of it on one thread and on two, and each stage on one.
//!
//! The frame is the coded 15 x 15 grid on the box before the wall, in the simulated room. Run with
//! `cargo bench -p acquirer --bench pipeline`.

use acquirer::pipeline::{
    Captures, PipelineSettings, Reader,
    colours::{ColourBuffers, ColouredLines, Colours, find_colours, nominal_response},
    crossings::{CrossingBuffers, Crossings, find_crossings},
    gain::{GainBuffers, GainFilter, GainImage, find_gain},
    grid::{DecodeBuffers, DecodedGrid, Decoding, Observed},
    line_light::LineLight,
    lines::{LineBuffers, Lines, find_lines, find_scale},
    reference::find_references,
    response::Response,
};
use criterion::{Criterion, criterion_group, criterion_main};
use rayon::{ThreadPool, ThreadPoolBuilder};
use rig_tests::measure::{Repeats, SimulatedScan};

const SIZES: [(u32, u32); 3] = [(640, 480), (1280, 720), (1920, 1080)];

fn pool(threads: usize) -> ThreadPool {
    let built = ThreadPoolBuilder::new().num_threads(threads).build();
    built.expect("threads can be started")
}

fn settings() -> PipelineSettings {
    PipelineSettings::live()
}

fn frame_to_grid(criterion: &mut Criterion) {
    for (width, height) in SIZES {
        let scan = SimulatedScan::of_camera((width, height), Repeats::SINGLE_FRAME)
            .expect("the scene is shipped");
        let captures = &scan.stages[1];
        let mut group = criterion.benchmark_group(format!("{width}x{height}"));
        group.sample_size(20);
        for threads in [1, 2] {
            let references = (&captures.black[..], &captures.white[..]);
            let calibration = Some(&scan.calibration);
            let mut reader = Reader::new(references, &scan.projected, calibration, &settings())
                .expect("the references fit");
            let pool = pool(threads);
            group.bench_function(format!("frame to grid, {threads} threads"), |bencher| {
                let frame = &captures.prmvs[0];
                bencher.iter(|| pool.install(|| reader.read(frame).map(|g| g.crossings.len())));
            });
        }
        stages(&mut group, &scan, captures);
        group.finish();
    }
}

type Group<'a> = criterion::BenchmarkGroup<'a, criterion::measurement::WallTime>;

fn stages(group: &mut Group<'_>, scan: &SimulatedScan, captures: &Captures) {
    let (settings, pool) = (settings(), pool(1));
    let response = Response::new(&settings.response);
    let Captures {
        black,
        white,
        prmvs,
        ..
    } = captures;
    group.bench_function("reference, once", |bencher| {
        bencher.iter(|| {
            pool.install(|| find_references(black, white, &response, &settings.reference))
        });
    });
    let references = find_references(black, white, &response, &settings.reference);
    let light = LineLight::new((prmvs, &response), &references).expect("both were captured");
    let coded = &scan.projected.pattern.coded;
    let nominal: Vec<_> = coded
        .colours()
        .iter()
        .map(|&c| nominal_response(c))
        .collect();
    let filter = GainFilter::new(&light, &nominal, &settings.gain);
    let mut buffers = LineBuffers::default();
    let pitch_widths = scan.projected.pitch_widths();
    let mut scale = || {
        find_scale(
            (&light, &filter),
            pitch_widths,
            &settings.lines,
            &mut buffers,
        )
    };
    group.bench_function("scale", |bencher| bencher.iter(|| pool.install(&mut scale)));
    let scale = scale();
    let (mut rows, mut image) = (GainBuffers::default(), GainImage::default());
    group.bench_function("gain", |bencher| {
        bencher.iter(|| {
            let bin = scale.sampling.bin;
            pool.install(|| find_gain(&light, &filter, bin, (&mut rows, &mut image)));
        });
    });
    let shrink = settings.gain.shrink;
    let mut lines = Lines::default();
    let mut find = || {
        let found = (&mut buffers, &mut lines);
        find_lines((&image, shrink), &scale, &settings.lines, found);
    };
    group.bench_function("lines", |bencher| bencher.iter(|| pool.install(&mut find)));
    find();
    let (mut buffers, mut crossings) = (CrossingBuffers::default(), Crossings::default());
    let mut find = || {
        let found = (&mut buffers, &mut crossings);
        find_crossings(&lines, &settings.crossings, found);
    };
    group.bench_function("crossings", |bencher| {
        bencher.iter(|| pool.install(&mut find));
    });
    find();
    let seen = ColouredLines {
        light: &light,
        gain: None,
        lines: &lines,
        crossings: &crossings,
    };
    let (mut buffers, mut found) = (ColourBuffers::default(), Colours::default());
    let mut colours = || {
        let found = (&mut buffers, &mut found);
        find_colours(&seen, &nominal, &settings.colours, found);
    };
    group.bench_function("colours", |bencher| {
        bencher.iter(|| pool.install(&mut colours));
    });
    colours();
    let observed = Observed {
        lines: &lines,
        crossings: &crossings,
        colours: &found,
    };
    let decoding = Decoding::new(coded);
    let rig = (&scan.projected, Some(&scan.calibration));
    let (mut buffers, mut grid) = (DecodeBuffers::default(), DecodedGrid::default());
    group.bench_function("grid", |bencher| {
        bencher.iter(|| {
            let found = (&mut buffers, &mut grid);
            pool.install(|| decoding.find_grid(observed, rig, &settings.grid, found));
        });
    });
}

criterion_group!(benches, frame_to_grid);
criterion_main!(benches);
