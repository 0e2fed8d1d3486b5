//! Runs the acquirer's V4L2 camera on a device and tells what happens, one JSON object per line.
//!
//! For the tests in the guest: they cause trouble (stalls, unplugging, broken frames) and read here
//! what the camera made of it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use acquirer::camera::v4l2::{V4l2Camera, list_cameras};
use acquirer::camera::{Camera, CameraError, CameraSettings, Frame};
use acquirer::clock::monotonic_now;
use anyhow::Context;
use clap::Parser;
use serde_json::json;

#[derive(Parser)]
enum Probe {
    /// Lists the cameras.
    List,
    /// Captures from a device until enough frames have come or the time is over.
    Capture {
        device: PathBuf,
        /// Frames to take.
        #[arg(long, default_value_t = 30)]
        frames: u32,
        /// Longest wait for one frame, in milliseconds.
        #[arg(long, default_value_t = 1000)]
        patience_ms: u64,
        /// Ends after this many seconds, whatever has come.
        #[arg(long, default_value_t = 60)]
        seconds: u64,
        /// V4L2 code of the pixel format.
        #[arg(long, default_value = "")]
        format: String,
        #[arg(long, default_value_t = 640)]
        width: u32,
        #[arg(long, default_value_t = 480)]
        height: u32,
        /// Highest rate.
        #[arg(long, default_value_t = 30)]
        rate: u32,
        /// Waits this long before each frame, in milliseconds.
        #[arg(long, default_value_t = 0)]
        dawdle_ms: u64,
        /// Holds the camera's automatics before capturing.
        #[arg(long)]
        hold: bool,
        /// A file that is made when the first frame has come, for the script beside.
        #[arg(long)]
        mark: Option<PathBuf>,
    },
}

fn main() -> anyhow::Result<()> {
    match Probe::parse() {
        Probe::List => println!("{}", serde_json::to_string(&list_cameras())?),
        Probe::Capture {
            device,
            frames,
            patience_ms,
            seconds,
            format,
            width,
            height,
            rate,
            dawdle_ms,
            hold,
            mark,
        } => {
            let settings = CameraSettings {
                width,
                height,
                max_rate: rate,
                pixel_format: format,
                ..CameraSettings::default()
            };
            let ends = Instant::now() + Duration::from_secs(seconds);
            let mut camera = match V4l2Camera::open(&device, &settings) {
                Ok(camera) => camera,
                Err(error) => {
                    tell_error(&error);
                    return Ok(());
                }
            };
            println!(
                "{}",
                json!({"event": "open", "camera": camera.description(), "format": camera.format().to_string()})
            );
            if hold {
                let held = camera.hold_automatics()?;
                let names: Vec<_> = held
                    .iter()
                    .map(|held| (held.name, held.refused.clone()))
                    .collect();
                println!("{}", json!({"event": "held", "controls": names}));
            }
            capture(
                &mut camera,
                frames,
                ends,
                Duration::from_millis(patience_ms),
                Duration::from_millis(dawdle_ms),
                mark.as_deref(),
            )?;
            let closing = Instant::now();
            drop(camera);
            println!(
                "{}",
                json!({"event": "closed", "took_ms": u64::try_from(closing.elapsed().as_millis())?})
            );
        }
    }
    Ok(())
}

fn capture(
    camera: &mut V4l2Camera,
    frames: u32,
    ends: Instant,
    patience: Duration,
    dawdle: Duration,
    mark: Option<&Path>,
) -> anyhow::Result<()> {
    let mut got = 0;
    while got < frames && Instant::now() < ends {
        std::thread::sleep(dawdle);
        match camera.next_frame(patience) {
            Ok(frame) => {
                got += 1;
                tell_frame(&frame)?;
                if let Some(mark) = mark.filter(|_| got == 1) {
                    std::fs::write(mark, "")
                        .with_context(|| format!("cannot make {}", mark.display()))?;
                }
            }
            Err(error) => tell_error(&error),
        }
    }
    println!("{}", json!({"event": "end", "losses": camera.losses()}));
    Ok(())
}

fn tell_frame(frame: &Frame) -> anyhow::Result<()> {
    let age = monotonic_now().saturating_sub(frame.captured_at);
    let (width, height) = frame.picture.dimensions();
    println!(
        "{}",
        json!({
            "event": "frame",
            "number": frame.number,
            "dropped": frame.dropped,
            "age_ms": u64::try_from(age.as_millis())?,
            "size": [width, height],
            "centre": frame.picture.get_pixel(width / 2, height / 2).0,
            "corner": frame.picture.get_pixel(0, 0).0,
        })
    );
    Ok(())
}

fn tell_error(error: &CameraError) {
    let debug = format!("{error:?}");
    let kind = debug.split([' ', '{', '(']).next().unwrap_or_default();
    println!(
        "{}",
        json!({"event": "error", "kind": kind, "text": error.to_string()})
    );
}
