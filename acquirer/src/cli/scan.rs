//! `acquirer scan`: records without and with the object, then reads.

use std::{
    io::{BufRead, IsTerminal},
    path::{Path, PathBuf},
    process::Command,
    thread,
    time::Duration,
};

use anyhow::{Context, bail};
use shared::{
    geometry::RigCalibration,
    pattern::{Palette, RasterSize},
    stage::Stage,
};

use super::{
    args::{CalibrationArgs, ReadingArgs, RecordArgs, RigArgs},
    colours,
    console::Console,
    process,
    rig::{make_ready, open_rig, show_grid},
};
use crate::{
    camera::CameraSpec,
    config::Config,
    process::process_scan,
    scan::{ScanError, ScanFolder},
    session::{
        Cancel, NewScan, Rig, SessionError, complete_stage, is_lacking, projected, record_stage,
        recording_warnings, resumed_settings,
    },
};

/// `acquirer scan`.
#[derive(Debug, clap::Args)]
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

pub(super) fn run(args: &ScanArgs, cancel: &Cancel) -> anyhow::Result<()> {
    let mut config = args.reading.config(&args.rig.config)?;
    config.exposure.set |= args.rig.camera_settings.expose;
    args.record.apply(&mut config.record);
    let is_replayed = matches!(args.rig.camera, Some(CameraSpec::Replay(_)));
    if is_replayed && !args.record.densify.is_empty() {
        bail!(
            "a recording can't show finer grids; leave out --densify, or use a camera or a simulated room"
        );
    }
    let calibration = args.calibration.load()?;
    let begun = args.out.join("scan.json").exists();
    if begun && !args.resume {
        return Err(ScanError::Exists(args.out.clone()).into());
    }
    let mut console = Console::new();
    if begun {
        let folder = resume(args, &config, calibration.as_ref(), cancel, &mut console)?;
        let processed = process_scan(&folder, &config)?;
        return process::print(&folder, &processed, args.reading.json);
    }
    let object = Placing::of(args)?;
    let mut rig = open_rig(&args.rig, &config)?;
    let recording = Recording {
        out: &args.out,
        pick_colours: args.pick_colours,
        object,
        calibration: calibration.as_ref(),
    };
    let folder = recording.run(&mut rig, &config, cancel, &mut console)?;
    let processed = process_scan(&folder, &config)?;
    process::print(&folder, &processed, args.reading.json)
}

/// Records the stages and the finer grids that an interrupted scan lacks.
fn resume(
    args: &ScanArgs,
    config: &Config,
    calibration: Option<&RigCalibration>,
    cancel: &Cancel,
    console: &mut Console,
) -> anyhow::Result<ScanFolder> {
    let mut folder = ScanFolder::open(&args.out)?;
    folder.remove_unfinished()?;
    if let Some(calibration) = calibration {
        folder.set_calibration(calibration)?;
    }
    let record = resumed_settings(&folder, &config.record);
    let mut missing = Vec::new();
    for stage in Stage::BOTH {
        if is_lacking(&folder, stage, &record)? {
            missing.push(stage);
        }
    }
    if missing.is_empty() {
        console.say("both stages are recorded already");
        return Ok(folder);
    }
    let object = Placing::of(args)?;
    let mut rig = open_rig(&args.rig, config)?;
    show_grid(&rig.projector, &folder.manifest().pattern)?;
    check_same_rig(&rig, &folder)?;
    make_ready(&mut rig, config, cancel, console)?;
    for stage in missing {
        match stage {
            Stage::Background => console.say("going on with the scene without the object"),
            Stage::Object => object.place(cancel, console)?,
        }
        complete_stage(&mut rig, &mut folder, stage, &record, cancel, &mut |p| {
            console.show(&p);
        })?;
    }
    Ok(folder)
}

/// A scan goes on only with the projector and the camera that it was begun with.
fn check_same_rig(rig: &Rig, folder: &ScanFolder) -> anyhow::Result<()> {
    let (manifest, format) = (folder.manifest(), rig.camera.format());
    let raster = projected(rig)?.raster;
    let camera = RasterSize {
        width: format.width,
        height: format.height,
    };
    if (raster, camera) != (manifest.projector, manifest.camera) {
        bail!(
            "{} was begun with a projector of {} px and a camera of {} px, these are {raster} and {camera}: \
             use the same ones, or record anew into another folder",
            folder.dir().display(),
            manifest.projector,
            manifest.camera
        );
    }
    Ok(())
}

/// Who puts the object into the scene between the two stages.
pub(super) enum Placing<'a> {
    /// The camera itself: a recording or a simulated room.
    Camera,
    /// A person, asked on the terminal.
    Person,
    /// A command.
    Command(&'a str),
}

impl<'a> Placing<'a> {
    fn of(args: &'a ScanArgs) -> anyhow::Result<Self> {
        if let Some(command) = &args.place_object {
            return Ok(Self::Command(command));
        }
        match args.rig.camera {
            Some(CameraSpec::Replay(_) | CameraSpec::Simulated(_)) => Ok(Self::Camera),
            _ if std::io::stdin().is_terminal() => Ok(Self::Person),
            _ => bail!(
                "nobody can be asked to place the object, standard input is not a terminal; give \
                 --place-object COMMAND"
            ),
        }
    }

    fn place(&self, cancel: &Cancel, console: &mut Console) -> anyhow::Result<()> {
        match self {
            Self::Camera => Ok(()),
            Self::Person => {
                console.say("Put the object into the scene, then press Enter.");
                wait_for_enter(cancel)
            }
            Self::Command(command) => run_command(command),
        }
    }
}

/// A recording of both stages into a new folder.
pub(super) struct Recording<'a> {
    /// The folder.
    pub(super) out: &'a Path,
    /// Whether the colours are picked first.
    pub(super) pick_colours: bool,
    /// Who places the object.
    pub(super) object: Placing<'a>,
    /// The rig's calibration, if there is one.
    pub(super) calibration: Option<&'a RigCalibration>,
}

impl Recording<'_> {
    /// Measures the latency, picks colours if asked, records both stages.
    pub(super) fn run(
        &self,
        rig: &mut Rig,
        config: &Config,
        cancel: &Cancel,
        console: &mut Console,
    ) -> anyhow::Result<ScanFolder> {
        make_ready(rig, config, cancel, console)?;
        let selection = match self.pick_colours {
            true => Some(colours::pick(
                rig,
                &Palette::default(),
                true,
                cancel,
                console,
            )?),
            false => None,
        };
        for warning in recording_warnings(rig, &projected(rig)?, &config.record)? {
            console.say(&format!("warning: {warning}"));
        }
        let scan = NewScan {
            dir: self.out,
            config,
            selection: selection.as_ref(),
            calibration: self.calibration,
        };
        let mut folder = scan.begin(rig)?;
        for stage in Stage::BOTH {
            if stage == Stage::Object {
                self.object.place(cancel, console)?;
            }
            record_stage(rig, &mut folder, stage, &config.record, cancel, &mut |p| {
                console.show(&p);
            })?;
        }
        Ok(folder)
    }
}

fn run_command(command: &str) -> anyhow::Result<()> {
    let status = Command::new("/bin/sh")
        .args(["-c", command])
        .stdout(std::io::stderr())
        .status()
        .with_context(|| format!("--place-object {command:?} can't be started"))?;
    if !status.success() {
        bail!("--place-object {command:?} ended with {status}; the background is kept");
    }
    Ok(())
}

/// Waits for a line on standard input, so that Ctrl-C still ends the program meanwhile.
fn wait_for_enter(cancel: &Cancel) -> anyhow::Result<()> {
    let reader = thread::Builder::new().name("enter".into()).spawn(|| {
        let mut line = String::new();
        std::io::stdin().lock().read_line(&mut line).map(|_| ())
    })?;
    while !reader.is_finished() {
        if cancel.is_cancelled() {
            return Err(SessionError::Cancelled.into());
        }
        thread::sleep(Duration::from_millis(50));
    }
    match reader.join() {
        Ok(read) => read.context("standard input"),
        Err(_) => bail!("the thread that reads standard input has ended"),
    }
}
