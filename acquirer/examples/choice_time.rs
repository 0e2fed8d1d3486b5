//! CPU time of choosing the colours, once the frames are there.
//!
//! ```text
//! cargo run -p acquirer --example choice_time -- [--size 1280x720] [--threads 1] [--scene coloured-room]
//! ```
//!
//! Renders a colour trial of a shipped scene for a camera of this size (black and white twice, the grid in each of
//! the sixteen colours), chooses again and again, and prints `choice MS`: the median CPU time of one choice in
//! milliseconds, all threads together.

use std::time::Instant;

use acquirer::pipeline::{Projected, colour_choice::choose_colours};
use anyhow::Result;
use clap::Parser;
use rig_tests::measure::{colour_trial, cpu_time, scene_of_camera};
use shared::{pattern::GridSettings, stage::Stage};

/// Fewest repetitions.
const FEWEST: usize = 20;
/// Time after which no more repetitions are begun, seconds.
const LONG_ENOUGH_S: f64 = 1.5;

/// CPU time of choosing the colours.
#[derive(Parser)]
struct Arguments {
    /// The camera's size.
    #[arg(long, default_value = "640x480", value_parser = size)]
    size: (u32, u32),
    /// Threads that choose.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// A scene in `config/scenes`.
    #[arg(long, default_value = "coloured-room")]
    scene: String,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let scene = scene_of_camera(&arguments.scene, arguments.size)?;
    let projected = Projected {
        pattern: GridSettings::default(),
        raster: scene.projector_size(),
    };
    let trial = colour_trial(&scene, Stage::Object, &projected.pattern.coded);
    let threads = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads);
    threads.build()?.install(|| {
        let choice = median_ms(|| Ok(choose_colours(&trial, &projected, None).map(drop)?))?;
        println!("choice {choice:.3}");
        Ok(())
    })
}

/// Median CPU time of one call, ms.
fn median_ms(mut call: impl FnMut() -> Result<()>) -> Result<f64> {
    call()?;
    let (mut times, begun) = (Vec::new(), Instant::now());
    while times.len() < FEWEST || begun.elapsed().as_secs_f64() < LONG_ENOUGH_S {
        let before = cpu_time()?;
        call()?;
        times.push((cpu_time()? - before).as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parts = text
        .split_once('x')
        .and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    parts.ok_or_else(|| "write WIDTHxHEIGHT, for example 640x480".into())
}
