//! Feeds a v4l2loopback device, which hands the frames to whoever reads it as a camera.
//!
//! The frames are grey steps, files, or come over TCP from the frame server of the tests. Writing
//! is paced at the nominal rate: the device keeps a ring of buffers, and a faster writer overwrites
//! what is being read.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Parser;
use v4l::fraction::Fraction;
use v4l::video::Output;
use v4l::video::output::Parameters;
use v4l::{Device, Format, FourCC};

#[derive(Parser)]
struct Feeder {
    /// The v4l2loopback device.
    device: PathBuf,
    #[command(subcommand)]
    source: Source,
}

#[derive(clap::Subcommand)]
enum Source {
    /// Grey YUYV frames; frame n has the luma 20 + n modulo 200.
    Steps {
        width: u32,
        height: u32,
        rate: u32,
        frames: u32,
        /// Stops for a while after this many frames.
        #[arg(long, default_value_t = u32::MAX)]
        pause_after: u32,
        #[arg(long, default_value_t = 0)]
        pause_ms: u64,
    },
    /// Files in turn, each a frame of the given format.
    Files {
        fourcc: String,
        width: u32,
        height: u32,
        rate: u32,
        frames: u32,
        files: Vec<PathBuf>,
    },
    /// YUYV frames over TCP: a line `WIDTH HEIGHT RATE`, then the frames one after another.
    Tcp { address: String },
}

fn main() -> anyhow::Result<()> {
    let feeder = Feeder::parse();
    match feeder.source {
        Source::Steps {
            width,
            height,
            rate,
            frames,
            pause_after,
            pause_ms,
        } => {
            let mut out = open(&feeder.device, "YUYV", width, height, rate)?;
            let mut pace = Pace::new(rate);
            for n in 0..frames {
                if n == pause_after {
                    std::thread::sleep(Duration::from_millis(pause_ms));
                    pace = Pace::new(rate);
                }
                let luma = u8::try_from(20 + n % 200)?;
                out.write_all(&[luma, 128].repeat(width as usize * height as usize))
                    .context("writing a frame")?;
                pace.wait();
            }
        }
        Source::Files {
            fourcc,
            width,
            height,
            rate,
            frames,
            files,
        } => {
            let frames_of_files: Vec<_> =
                files.iter().map(std::fs::read).collect::<Result<_, _>>()?;
            let mut out = open(&feeder.device, &fourcc, width, height, rate)?;
            let mut pace = Pace::new(rate);
            for frame in frames_of_files.iter().cycle().take(frames as usize) {
                out.write_all(frame).context("writing a frame")?;
                pace.wait();
            }
        }
        Source::Tcp { address } => pump(&feeder.device, &address)?,
    }
    Ok(())
}

/// Tells the server that a frame has been taken.
const TAKEN: u8 = b'.';

/// Writes what comes over TCP until the other side ends.
///
/// Each frame is acknowledged, so that the server sends the newest one next instead of filling the
/// network's buffers with old ones.
fn pump(device: &Path, address: &str) -> anyhow::Result<()> {
    let stream = TcpStream::connect(address).with_context(|| format!("connecting to {address}"))?;
    let mut stream = BufReader::new(stream);
    let mut head = String::new();
    stream.read_line(&mut head)?;
    let numbers: Vec<u32> = head
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let [width, height, rate] = numbers[..] else {
        bail!("'{head}' is no head of a stream")
    };
    let mut out = open(device, "YUYV", width, height, rate)?;
    let mut frame = vec![0; width as usize * height as usize * 2];
    while stream.read_exact(&mut frame).is_ok() {
        out.write_all(&frame).context("writing a frame")?;
        stream
            .get_mut()
            .write_all(&[TAKEN])
            .context("asking for the next frame")?;
    }
    Ok(())
}

/// Opens the device for writing and sets what its readers will see.
fn open(path: &Path, fourcc: &str, width: u32, height: u32, rate: u32) -> anyhow::Result<Device> {
    let device = Device::with_path(path).with_context(|| format!("opening {}", path.display()))?;
    let code: [u8; 4] = fourcc
        .as_bytes()
        .try_into()
        .context("a format code has four letters")?;
    let mut format = Format::new(width, height, FourCC::new(&code));
    format.size = width * height * 2;
    let set = Output::set_format(&device, &format).context("setting the format")?;
    if (set.width, set.height, set.fourcc) != (width, height, format.fourcc) {
        bail!("the device chose {set}");
    }
    // Reported to readers only; the pace is kept here.
    if let Err(error) = Output::set_params(&device, &Parameters::new(Fraction::new(1, rate.max(1))))
    {
        eprintln!("frame_feeder: the rate cannot be told: {error}");
    }
    Ok(device)
}

/// Keeps a rate without drifting.
struct Pace {
    next: Instant,
    interval: Duration,
}

impl Pace {
    fn new(rate: u32) -> Self {
        Self {
            next: Instant::now(),
            interval: Duration::from_secs(1) / rate.max(1),
        }
    }

    fn wait(&mut self) {
        self.next += self.interval;
        std::thread::sleep(self.next.saturating_duration_since(Instant::now()));
    }
}
