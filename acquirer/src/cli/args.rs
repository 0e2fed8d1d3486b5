//! What can be said on the command line.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};

use shared::pattern::LINE_COUNTS;

use crate::{camera::CameraSpec, pipeline::Method};

/// Captures the projected grid through a camera, picks its colours, reads it, and gives the object's shape.
#[derive(Debug, Parser)]
#[command(
    name = "acquirer",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Examples:
  acquirer demo                                       the whole rig in a simulated room
  acquirer cameras                                    which cameras are there
  acquirer colours --projector 192.168.0.7:4460 --camera /dev/video0
  acquirer scan --out cup --projector 192.168.0.7:4460 --camera /dev/video0
  acquirer process cup --method thesis                read a recorded scan again
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
    /// Calibration of the rig (calibration.json), copied into each scan; gives points in mm.
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List the cameras with their formats, sizes and rates.
    Cameras(CamerasArgs),
    /// Show every colour of the palette on the scene, pick the best four and the unary colour, and send them to
    /// the projector.
    Colours(ColoursArgs),
    /// Record a scan without and with an object, and read it.
    Scan(ScanArgs),
    /// Read a recorded scan: labels, shifts, surface, pictures, report.
    Process(ProcessArgs),
    /// Run the whole rig in a simulated room: projector program, colours, scan, results, report.
    Demo(DemoArgs),
    /// Draw a shift table (shifts.csv, or the tables of the thesis's Appendix C) as a 3-D view.
    Draw(DrawArgs),
}

/// Which rig.
#[derive(Debug, Clone, ClapArgs)]
pub struct RigArgs {
    /// The projector program, as HOST:PORT.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:4460")]
    pub projector: String,
    /// The camera: /dev/videoN, replay:DIR (a recorded scan), or sim:SCENE (a file's name in config/scenes, or a
    /// path). Without it: the first camera that `acquirer cameras` lists.
    #[arg(long, value_name = "CAMERA")]
    pub camera: Option<CameraSpec>,
    /// Take the projector over from whoever controls it.
    #[arg(long)]
    pub take_over: bool,
    /// Configuration file; the shipped config/acquirer.toml lists every key.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
}

/// `acquirer cameras`.
#[derive(Debug, ClapArgs)]
pub(super) struct CamerasArgs {
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
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
  acquirer scan --out cup --camera /dev/video0 --densify 31,63
  acquirer scan --out cube --camera sim:cube --json
  acquirer scan --out cup --camera /dev/video0 --place-object './turntable next'")]
pub(super) struct ScanArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// Folder of the new scan.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Pick the colours on the scene first.
    #[arg(long)]
    pub pick_colours: bool,
    /// Record finer grids after the base grid and read them with its help: numbers of lines, for example 31,63.
    #[arg(long, value_name = "LINES", value_delimiter = ',', value_parser = line_count)]
    pub densify: Vec<usize>,
    /// Leave out the solid colours that tell the camera's response (some three seconds a stage); the sRGB curve is taken.
    #[arg(long)]
    pub no_ramp: bool,
    /// Calibration of the rig (calibration.json), copied into the scan; gives points in mm.
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// A command that puts the object into the scene (a turntable, a robot), instead of asking a person.
    #[arg(long, value_name = "COMMAND")]
    pub place_object: Option<String>,
    /// How to read the scan; likelihood unless the configuration says otherwise.
    #[arg(long, value_enum)]
    pub method: Option<MethodArg>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
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
    /// How to read the scan; likelihood unless the configuration says otherwise.
    #[arg(long, value_enum)]
    pub method: Option<MethodArg>,
    /// Calibration of the rig, instead of the scan's own.
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// Configuration file; the shipped config/acquirer.toml lists every key.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
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
    /// Record finer grids after the base grid and read them with its help: numbers of lines, for example 31,63.
    #[arg(long, value_name = "LINES", value_delimiter = ',', value_parser = line_count)]
    pub densify: Vec<usize>,
    /// Use a projector program that runs already, as HOST:PORT, instead of starting one.
    #[arg(long, value_name = "HOST:PORT")]
    pub projector: Option<String>,
    /// Open the real windows: the projector's picture and the acquirer.
    #[arg(long)]
    pub gui: bool,
    /// How to read the scan; likelihood unless the configuration says otherwise.
    #[arg(long, value_enum)]
    pub method: Option<MethodArg>,
    /// Configuration file; the shipped config/acquirer.toml lists every key.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
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
