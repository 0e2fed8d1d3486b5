//! Runs the acquirer's V4L2 camera on a device and tells what happens, one JSON object per line.
//!
//! For the tests in the guest: they cause trouble (stalls, unplugging, broken frames) and read here
//! what the camera made of it.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use acquirer::camera::v4l2::{list_cameras, list_controls};
use acquirer::camera::{
    Camera, CameraError, CameraSettings, CameraSpec, ControlWish, ControlWishes, Frame, open_camera,
};
use acquirer::clock::monotonic_now;
use anyhow::Context;
use clap::Parser;
use serde_json::json;

#[derive(Parser)]
enum Probe {
    /// Lists the cameras.
    List,
    /// Lists the controls of a device.
    Controls { device: PathBuf },
    /// Captures from a device until enough frames have come or the time is over.
    Capture(CaptureArgs),
}

#[derive(clap::Args)]
struct CaptureArgs {
    device: PathBuf,
    /// Frames to take.
    #[arg(long, default_value_t = 30)]
    frames: u32,
    /// Begins to count the frames when this file is there.
    #[arg(long)]
    after: Option<PathBuf>,
    /// Longest wait for one frame, in milliseconds.
    #[arg(long, default_value_t = 1000)]
    patience_ms: u64,
    /// Ends after this many seconds, whatever has come.
    #[arg(long, default_value_t = 120)]
    seconds: u64,
    /// V4L2 code of the pixel format.
    #[arg(long, default_value = "")]
    format: String,
    #[arg(long, default_value_t = 640)]
    width: u32,
    #[arg(long, default_value_t = 480)]
    height: u32,
    /// Highest rate.
    #[arg(long, default_value_t = 30.0)]
    rate: f64,
    /// Holds the camera's automatics before capturing.
    #[arg(long)]
    hold: bool,
    /// Control to set, as KEY=VALUE.
    #[arg(long = "control")]
    controls: Vec<ControlWish>,
    /// Time after each frame in which nobody asks for one, in milliseconds.
    #[arg(long, default_value_t = 0)]
    pause_ms: u64,
    /// Dies of a panic when the frames have come.
    #[arg(long)]
    panic: bool,
    /// Makes this file when the first frame has come, for the script beside.
    #[arg(long)]
    mark: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .init();
    match Probe::parse() {
        Probe::List => println!("{}", serde_json::to_string(&list_cameras())?),
        Probe::Controls { device } => match list_controls(&device) {
            Ok(controls) => println!("{}", serde_json::to_string(&controls)?),
            Err(error) => tell_error(&error),
        },
        Probe::Capture(args) => {
            let mut controls = ControlWishes::default();
            for wish in &args.controls {
                controls.add(wish.clone());
            }
            let settings = CameraSettings {
                width: args.width,
                height: args.height,
                max_rate: args.rate,
                controls,
                pixel_format: args.format.clone(),
            };
            match open_camera(&CameraSpec::Device(args.device.clone()), &settings, None) {
                Ok(camera) => probe(camera, &args)?,
                Err(error) => tell_error(&error),
            }
        }
    }
    Ok(())
}

fn probe(mut camera: Box<dyn Camera>, args: &CaptureArgs) -> anyhow::Result<()> {
    let (description, format) = (camera.description(), camera.format().to_string());
    println!(
        "{}",
        json!({"event": "open", "camera": description, "format": format})
    );
    if args.hold {
        let held = camera.hold_automatics()?;
        let controls: Vec<_> = held
            .into_iter()
            .map(|held| (held.name, held.refused))
            .collect();
        println!("{}", json!({"event": "held", "controls": controls}));
    }
    capture(&mut *camera, args)?;
    assert!(!args.panic, "as it was told");
    println!("{}", json!({"event": "end", "losses": camera.losses()}));
    let closing = Instant::now();
    drop(camera);
    let took_ms = u64::try_from(closing.elapsed().as_millis())?;
    println!("{}", json!({"event": "closed", "took_ms": took_ms}));
    Ok(())
}

fn capture(camera: &mut dyn Camera, args: &CaptureArgs) -> anyhow::Result<()> {
    let ends = Instant::now() + Duration::from_secs(args.seconds);
    let (mut any, mut counted) = (false, 0);
    while counted < args.frames && Instant::now() < ends {
        let counting = args.after.as_ref().is_none_or(|file| file.exists());
        match camera.next_frame(Duration::from_millis(args.patience_ms)) {
            Ok(frame) => {
                tell_frame(&frame)?;
                if let Some(mark) = args.mark.as_ref().filter(|_| !any) {
                    std::fs::write(mark, "")
                        .with_context(|| format!("cannot make {}", mark.display()))?;
                }
                any = true;
                counted += u32::from(counting);
                std::thread::sleep(Duration::from_millis(args.pause_ms));
            }
            Err(error) => tell_error(&error),
        }
    }
    Ok(())
}

fn tell_frame(frame: &Frame) -> anyhow::Result<()> {
    let now = monotonic_now();
    let age = now.saturating_sub(frame.captured_at);
    let ahead = frame.captured_at.saturating_sub(now);
    let (width, height) = frame.picture.dimensions();
    let bar = |k: u32| {
        frame
            .picture
            .get_pixel(width * (2 * k + 1) / 16, height * 3 / 4)
            .0
    };
    let bars: Vec<_> = (0..8).map(bar).collect();
    println!(
        "{}",
        json!({
            "event": "frame",
            "number": frame.number,
            "dropped": frame.dropped,
            "age_ms": u64::try_from(age.as_millis())?,
            "ahead_us": u64::try_from(ahead.as_micros())?,
            "stamp_us": u64::try_from(frame.captured_at.as_micros())?,
            "size": [width, height],
            "centre": frame.picture.get_pixel(width / 2, height / 2).0,
            "bars": bars,
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
