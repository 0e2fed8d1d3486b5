//! What can be said on the command line: the commands, and the arguments that several of them have.

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use shared::{geometry::RigCalibration, pattern::LINE_COUNTS};

use super::{
    cameras::CamerasArgs, check::CheckArgs, colours::ColoursArgs, demo::DemoArgs,
    doctor::DoctorArgs, draw::DrawArgs, find::FindArgs, live::LiveArgs, pair::PairArgs,
    process::ProcessArgs, scan::ScanArgs, window::WindowArgs,
};
use crate::{
    camera::{CameraSettings, CameraSpec, ControlWish},
    config::{Config, ConfigError},
    pipeline::Method,
    process::{ProcessError, read_calibration},
    session::RecordSettings,
};

/// Captures the projected grid through a camera, picks its colours, reads it, and gives the object's shape.
#[derive(Debug, Parser)]
#[command(
    name = "acquirer",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Examples:
  acquirer demo                                       the whole rig in a simulated room
  acquirer cameras --controls                         which cameras are there, and how they can be set
  acquirer find                                       which projectors are on the network
  acquirer pair CODE                                  once, with a projector on the network
  acquirer doctor --camera /dev/video0                is the rig well, and what is to be done
  acquirer colours --projector 192.168.0.7:4460 --camera /dev/video0
  acquirer scan --out cup --projector 192.168.0.7:4460 --camera /dev/video0
  acquirer live --camera /dev/video0 --json           read every frame, one line each
  acquirer process cup --method thesis                read a recorded scan again
  acquirer check cup                                  whether a scan is still what was recorded
  acquirer --camera sim:cube                          the window, on a simulated room

Exit codes: 0 done, 1 failed, 2 wrong use. RUST_LOG=info or debug tells more."
)]
pub(super) struct Args {
    /// Without a command: the window.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Arguments of the window.
    #[command(flatten)]
    pub window: WindowArgs,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List the cameras with their formats, sizes and rates.
    Cameras(CamerasArgs),
    /// List the projectors that announce themselves on the network.
    Find(FindArgs),
    /// Get to know a projector on the network by the code that it shows or `projector pair` prints.
    Pair(PairArgs),
    /// Examine the rig before it is used: screen, pixels, focus, automatics, exposure, flicker, latency, frames,
    /// network; each with what to do.
    Doctor(DoctorArgs),
    /// Show every colour of the palette on the scene, pick the best four and the unary colour, and send them to
    /// the projector.
    Colours(ColoursArgs),
    /// Record a scan without and with an object, and read it.
    Scan(ScanArgs),
    /// Read every frame as it comes, one line each, until Ctrl-C.
    Live(LiveArgs),
    /// Read a recorded scan: labels, shifts, surface, pictures, report.
    Process(ProcessArgs),
    /// Compare a scan and its results with their checksums: names what is damaged or missing.
    Check(CheckArgs),
    /// Run the whole rig in a simulated room: projector program, colours, scan, results, report.
    Demo(DemoArgs),
    /// Draw a shift table (shifts.csv, or the tables of the thesis's Appendix C) as a 3-D view.
    Draw(DrawArgs),
}

/// Which rig.
#[derive(Debug, Clone, clap::Args)]
pub struct RigArgs {
    /// The projector program, as HOST:PORT, or `auto` for the paired one that announces itself on the network.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:4460")]
    pub projector: String,
    /// The camera: /dev/videoN, replay:DIR (a recorded scan), or sim:SCENE (a file's name in config/scenes, or a
    /// path). Without it: the first camera that `acquirer cameras` lists.
    #[arg(long, value_name = "CAMERA")]
    pub camera: Option<CameraSpec>,
    /// How the camera is set.
    #[command(flatten)]
    pub camera_settings: CameraArgs,
    /// Take the projector over from whoever controls it.
    #[arg(long)]
    pub take_over: bool,
    /// Settings.
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// How the camera is set; what is not given is as the configuration says.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct CameraArgs {
    /// Size of the frames, for example 1280x720; the nearest that the camera has.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Highest rate in frames per second, for example 30, 29.97 or 12.5.
    #[arg(long, value_name = "HZ", value_parser = parse_rate)]
    rate: Option<f64>,
    /// The only pixel format allowed: YUYV, NV12, RGB3, BGR3, MJPG or GREY.
    #[arg(long, value_name = "CODE")]
    format: Option<String>,
    /// A control of the camera, for example exposure=120 (in 100 us), exposure=12ms or mains="60 Hz"; more than once
    /// for several. `acquirer cameras --controls` lists them. They get their old values back at the end.
    #[arg(long = "control", value_name = "KEY=VALUE")]
    controls: Vec<ControlWish>,
    /// Set the exposure first, so that the white-lit scene does not clip.
    #[arg(long)]
    pub expose: bool,
}

impl CameraArgs {
    /// The configuration's settings with those of the command line.
    #[must_use]
    pub fn over(&self, settings: &CameraSettings) -> CameraSettings {
        let mut settings = settings.clone();
        if let Some((width, height)) = self.size {
            (settings.width, settings.height) = (width, height);
        }
        if let Some(rate) = self.rate {
            settings.max_rate = rate;
        }
        if let Some(format) = &self.format {
            settings.pixel_format = format.to_ascii_uppercase();
        }
        for wish in &self.controls {
            settings.controls.add(wish.clone());
        }
        settings
    }
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    sides
        .filter(|(width, height)| *width > 0 && *height > 0)
        .ok_or_else(|| "give width and height in pixels, as 640x480".into())
}

fn parse_rate(text: &str) -> Result<f64, String> {
    let rate: Option<f64> = match text.split_once('/') {
        Some((frames, seconds)) => {
            let parts = frames.parse::<f64>().ok().zip(seconds.parse::<f64>().ok());
            parts.map(|(frames, seconds)| frames / seconds)
        }
        None => text.parse().ok(),
    };
    rate.filter(|rate| rate.is_finite() && *rate > 0.0)
        .ok_or_else(|| "give frames per second above 0, as 30, 12.5 or 30000/1001".into())
}

/// Settings.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct ConfigArgs {
    /// Configuration file; the shipped config/acquirer.toml lists every key.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

impl ConfigArgs {
    /// The configuration: the built-in one, changed by the file's keys if there is a file.
    ///
    /// # Errors
    /// A file that can't be read or has an unknown key.
    pub(super) fn load(&self) -> Result<Config, ConfigError> {
        Config::load(self.config.as_deref())
    }
}

/// The rig's calibration, for what records.
#[derive(Debug, clap::Args)]
pub(super) struct CalibrationArgs {
    /// Calibration of the rig (calibration.json): labels are checked against its epipolar lines, and scans give
    /// points in mm.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
}

impl CalibrationArgs {
    /// The calibration, if one was named.
    ///
    /// # Errors
    /// A file that can't be read or is no calibration.
    pub(super) fn load(&self) -> Result<Option<RigCalibration>, ProcessError> {
        let path = self.calibration.as_deref();
        path.map(read_calibration).transpose()
    }
}

/// How a scan is read, and how its figures are printed.
#[derive(Debug, clap::Args)]
pub(super) struct ReadingArgs {
    /// How to read the scan; likelihood unless the configuration says otherwise.
    #[arg(long, value_enum)]
    method: Option<MethodArg>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

impl ReadingArgs {
    /// The configuration with the method of the command line.
    ///
    /// # Errors
    /// As [`ConfigArgs::load`].
    pub(super) fn config(&self, file: &ConfigArgs) -> Result<Config, ConfigError> {
        let mut config = file.load()?;
        config.set_method(self.method.map(Into::into));
        Ok(config)
    }
}

/// What is recorded besides the base grid.
#[derive(Debug, clap::Args)]
pub(super) struct RecordArgs {
    /// Record finer grids after the base grid and read them with its help: numbers of lines, for example 31,63.
    #[arg(long, value_name = "LINES", value_delimiter = ',', value_parser = line_count)]
    pub densify: Vec<usize>,
    /// Leave out the solid colours that tell the camera's response; the sRGB curve is taken.
    #[arg(long)]
    pub no_ramp: bool,
}

impl RecordArgs {
    /// Takes over what the command line asks for.
    pub(super) fn apply(&self, settings: &mut RecordSettings) {
        settings.ramp &= !self.no_ramp;
        if !self.densify.is_empty() {
            settings.densify.clone_from(&self.densify);
        }
    }
}

/// A number of lines that a finer grid may have.
fn line_count(text: &str) -> Result<usize, String> {
    let finer = &LINE_COUNTS[1..];
    let lines = text.parse().ok().filter(|lines| finer.contains(lines));
    lines.ok_or_else(|| format!("give some of {finer:?}, with commas between them"))
}

/// `--method`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArg {
    /// Sub-pixel lines, likelihood colours, maximum-likelihood decoding.
    Likelihood,
    /// The thesis of 2001: hue/saturation background, masked threshold, Sobel edges, 2 x 2 windows.
    Thesis,
}

impl From<MethodArg> for Method {
    fn from(method: MethodArg) -> Self {
        match method {
            MethodArg::Likelihood => Self::Likelihood,
            MethodArg::Thesis => Self::Thesis,
        }
    }
}
