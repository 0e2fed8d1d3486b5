//! CPU time of reading one frame, for comparing with other programs.
//!
//! ```text
//! cargo run --release -p acquirer --example frame_time -- --size 1280x720 --threads 1 [--dump FOLDER]
//! ```
//!
//! Renders the box before the wall (`config/scenes/cube.toml`) for a camera of this size under black, white and the
//! coded 15 x 15 grid, reads the coded frame again and again, and prints `frame_to_grid MS`: the median CPU time of
//! one frame in milliseconds, all threads together (`CLOCK_PROCESS_CPUTIME_ID`). `--dump` writes the frames as PNG.

use std::{fs, path::PathBuf, time::Instant};

use acquirer::pipeline::{Captures, PipelineSettings, Reader};
use anyhow::{Context, Result};
use clap::Parser;
use rig_tests::measure::{Repeats, SimulatedScan, cpu_time};

/// Fewest repetitions.
const FEWEST: usize = 5;
/// Time after which no more repetitions are begun, seconds.
const LONG_ENOUGH_S: f64 = 1.5;

/// CPU time of reading one frame.
#[derive(Parser)]
struct Arguments {
    /// The camera's size.
    #[arg(long, default_value = "640x480", value_parser = size)]
    size: (u32, u32),
    /// Threads that read one frame.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Folder for the frames as PNG files.
    #[arg(long)]
    dump: Option<PathBuf>,
    /// Only writes the frames.
    #[arg(long, requires = "dump")]
    no_timing: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let scan = SimulatedScan::of_camera(arguments.size, Repeats::SINGLE_FRAME)?;
    if let Some(folder) = &arguments.dump {
        dump(&scan, folder)?;
    }
    if arguments.no_timing {
        return Ok(());
    }
    let threads = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads);
    let took = threads
        .build()?
        .install(|| median_ms(frame_reader(&scan)?))?;
    println!("frame_to_grid {took:.4}");
    Ok(())
}

/// What reads one coded frame, made ready once from the references; gives how many crossings it read.
fn frame_reader(scan: &SimulatedScan) -> Result<impl FnMut() -> Result<usize>> {
    let Captures {
        black,
        white,
        prmvs,
        ..
    } = scan.stages[1].clone();
    let settings = PipelineSettings::live();
    let references = (&black[..], &white[..]);
    let calibration = Some(&scan.calibration);
    let mut reader = Reader::new(references, &scan.projected, calibration, &settings)?;
    Ok(move || Ok(reader.read(&prmvs[0])?.crossings.len()))
}

/// Median CPU time of one call, ms.
fn median_ms(mut read: impl FnMut() -> Result<usize>) -> Result<f64> {
    let crossings = read()?;
    eprintln!("{crossings} crossings read");
    let (mut times, begun) = (Vec::new(), Instant::now());
    while times.len() < FEWEST || begun.elapsed().as_secs_f64() < LONG_ENOUGH_S {
        let before = cpu_time()?;
        read()?;
        times.push((cpu_time()? - before).as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

/// Writes the object stage's frames: `black-0.png`, `white-0.png`, `coded-0.png` and so on.
fn dump(scan: &SimulatedScan, folder: &std::path::Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let captures = &scan.stages[1];
    for (name, frames) in [
        ("black", &captures.black),
        ("white", &captures.white),
        ("coded", &captures.prmvs),
    ] {
        for (k, frame) in frames.iter().enumerate() {
            frame.save(folder.join(format!("{name}-{k}.png")))?;
        }
    }
    Ok(())
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parts = text
        .split_once('x')
        .and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    parts.ok_or_else(|| "write WIDTHxHEIGHT, for example 640x480".into())
}
