//! What can be said on the command line.

use std::{
    num::{NonZeroU8, NonZeroUsize},
    path::PathBuf,
};

use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};
use shared::{geometry::RigCalibration, pattern::LINE_COUNTS};

use crate::{
    camera::{CameraSettings, CameraSpec, ControlWish},
    config::{Config, ConfigError},
    pipeline::Method,
    process::{ProcessError, read_calibration},
    session::{LiveMode, RecordSettings},
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

/// `acquirer` without a command.
#[derive(Debug, ClapArgs)]
pub(super) struct WindowArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// Folder of the recorded scan; further ones get -2, -3 and so on.
    #[arg(long, value_name = "DIR", default_value = "scan")]
    pub out: PathBuf,
    /// The rig's calibration.
    #[command(flatten)]
    pub calibration: CalibrationArgs,
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
#[derive(Debug, Clone, ClapArgs)]
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
#[derive(Debug, Clone, Default, ClapArgs)]
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
#[derive(Debug, Clone, Default, ClapArgs)]
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
#[derive(Debug, ClapArgs)]
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
#[derive(Debug, ClapArgs)]
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
#[derive(Debug, ClapArgs)]
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

/// `acquirer cameras`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer cameras
  acquirer cameras --controls
  acquirer cameras --controls --json")]
pub(super) struct CamerasArgs {
    /// List each camera's controls too, with their ranges and what they are set to.
    #[arg(long)]
    pub controls: bool,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `acquirer doctor`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer doctor --camera /dev/video0
  acquirer doctor --projector 192.168.0.7:4460 --camera /dev/video0 --json
  acquirer doctor --camera sim:cube

Exit codes: 0 all is well, 1 something is to be done (the last line says about what) or it failed, 2 wrong use.
The limits stand in config/acquirer.toml under [doctor].")]
pub(super) struct DoctorArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `acquirer find`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer find
  acquirer scan --out cup --projector auto           with the only one that is paired

Exit codes: 0 some were found, 1 none or it failed, 2 wrong use.")]
pub(super) struct FindArgs {
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `acquirer pair`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer pair SLP1/192.168.0.7:4460/...            the code as it was printed
  acquirer pair --camera /dev/video0                  the code as the projector shows it")]
pub(super) struct PairArgs {
    /// The pairing code.
    #[arg(value_name = "CODE", conflicts_with = "camera")]
    pub code: Option<String>,
    /// Read the code from the wall through this camera.
    #[arg(long, value_name = "CAMERA")]
    pub camera: Option<CameraSpec>,
    /// Reach the projector by this address instead of the code's own.
    #[arg(long, value_name = "HOST:PORT")]
    pub projector: Option<String>,
    /// Settings.
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// `acquirer colours`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer colours --camera sim:coloured-room
  acquirer colours --projector 192.168.0.7:4460 --camera /dev/video0 --json --keep")]
pub(super) struct ColoursArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// Palette file of sixteen colours; the shipped one is config/palettes/sixteen.toml.
    #[arg(long, value_name = "FILE")]
    pub palette: Option<PathBuf>,
    /// Only tell the choice, leave the projector's colours as they are.
    #[arg(long)]
    pub keep: bool,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `acquirer scan`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer scan --out cup --camera /dev/video0
  acquirer scan --out cup --camera /dev/video0 --pick-colours --calibration rig.json
  acquirer scan --out cup --camera /dev/video0 --size 1280x720 --control exposure=20ms --control gain=0
  acquirer scan --out cup --camera /dev/video0 --densify 31,63
  acquirer scan --out cube --camera sim:cube --json
  acquirer scan --out cup --camera /dev/video0 --place-object './turntable next'
  acquirer scan --out cup --camera /dev/video0 --resume      after a crash or a power cut")]
pub(super) struct ScanArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// Folder of the new scan.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Go on with the scan in that folder where it was interrupted: stages and finer grids that are recorded stay, with
    /// their grid.
    #[arg(long, conflicts_with = "pick_colours")]
    pub resume: bool,
    /// Pick the colours on the scene first.
    #[arg(long)]
    pub pick_colours: bool,
    /// What is recorded.
    #[command(flatten)]
    pub record: RecordArgs,
    /// The rig's calibration.
    #[command(flatten)]
    pub calibration: CalibrationArgs,
    /// A command that puts the object into the scene (a turntable, a robot), instead of asking a person.
    #[arg(long, value_name = "COMMAND")]
    pub place_object: Option<String>,
    /// How to read.
    #[command(flatten)]
    pub reading: ReadingArgs,
}

/// `acquirer live`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer live --camera /dev/video0
  acquirer live --camera /dev/video0 --json | tee frames.jsonl
  acquirer live --camera sim:cylinder --mode tracking --refresh 60 --frames 300
  acquirer live --camera /dev/video0 --mode static --average 8

A line tells: the frame's number, its time, what it shows (coded, unary, black, white, other, mixed), crossings with a
label, milliseconds, and how many crossings have no label and why. Only frames that show the mode's grid are read.")]
pub(super) struct LiveArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// How frames are read.
    #[arg(long, value_enum, default_value = "dynamic")]
    pub mode: LiveModeArg,
    /// End after so many lines.
    #[arg(long, value_name = "N")]
    pub frames: Option<u64>,
    /// Coded frames that are averaged with --mode static, 1 to 255.
    #[arg(long, value_name = "N", default_value = "4")]
    pub average: NonZeroU8,
    /// Frames between two looks at the coded grid with --mode tracking.
    #[arg(long, value_name = "N", default_value = "60")]
    pub refresh: NonZeroUsize,
    /// The rig's calibration: labels are checked against its epipolar lines.
    #[command(flatten)]
    pub calibration: CalibrationArgs,
    /// One JSON object per line on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `--mode`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum LiveModeArg {
    /// Nothing moves: the newest coded frames are averaged, the unary grid gives the geometry.
    Static,
    /// Things move: the coded grid stays up, every frame is read by itself.
    Dynamic,
    /// Things move slowly: the unary grid stays up, labels are carried on, the coded grid is shown now and then.
    Tracking,
}

impl From<LiveModeArg> for LiveMode {
    fn from(mode: LiveModeArg) -> Self {
        match mode {
            LiveModeArg::Static => Self::Static,
            LiveModeArg::Dynamic => Self::Dynamic,
            LiveModeArg::Tracking => Self::Tracking,
        }
    }
}

/// `acquirer process`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer process cup
  acquirer process cup --json
  acquirer process cup --method thesis --calibration rig.json")]
pub(super) struct ProcessArgs {
    /// Scan folder, with scan.json in it.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// How to read.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Calibration of the rig, instead of the scan's own.
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// Settings.
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// `acquirer check`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer check cup
  acquirer check cup --json

Exit code 1 when a file is damaged or missing.")]
pub(super) struct CheckArgs {
    /// Scan folder, with scan.json in it.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `acquirer demo`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer demo
  acquirer demo --scene cylinder --out /tmp/cylinder
  acquirer demo --scene coloured-room --json")]
pub(super) struct DemoArgs {
    /// The room: a file's name in config/scenes without .toml, or a path.
    #[arg(long, value_name = "NAME", default_value = "cube")]
    pub scene: String,
    /// Folder of the recorded scan; demo-SCENE in the current folder unless given.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// What is recorded.
    #[command(flatten)]
    pub record: RecordArgs,
    /// Use a projector program that runs already, as HOST:PORT, instead of starting one.
    #[arg(long, value_name = "HOST:PORT")]
    pub projector: Option<String>,
    /// Open the real windows: the projector's picture and the acquirer.
    #[arg(long)]
    pub gui: bool,
    /// How to read.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Settings.
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// `acquirer draw`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "Examples:
  acquirer draw cup/results/shifts.csv cup.png
  acquirer draw tests/recorded/appendix-c.csv cube.png --object cube")]
pub(super) struct DrawArgs {
    /// shifts.csv of a scan, or a table in the form of the thesis's Appendix C.
    #[arg(value_name = "TABLE")]
    pub table: PathBuf,
    /// Picture to write (PNG).
    #[arg(value_name = "OUT")]
    pub out: PathBuf,
    /// Which object of the table, where it holds several.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
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
