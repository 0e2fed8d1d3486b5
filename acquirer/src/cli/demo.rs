//! `acquirer demo`: the whole rig in a simulated room, as two programs on the real wire.

use std::path::{Path, PathBuf};

use look::log::Warnings;
use shared::{
    pattern::Palette,
    simulation::{Room, Scene},
    stage::Stage,
};

use super::{
    args::{CameraArgs, ConfigArgs, ReadingArgs, RecordArgs, RigArgs},
    colours,
    console::Console,
    process,
    projector_program::ProjectorProgram,
    rig::open_rig,
    scan::{Placing, Recording},
};
use crate::{
    camera::{CameraSpec, load_scene},
    gui::{self, Startup},
    process::{Processed, process_scan},
    scan::{ScanFolder, fresh_folder},
    score::{StageScore, score_stage},
    session::Cancel,
};

/// `acquirer demo`.
#[derive(Debug, clap::Args)]
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

pub(super) fn run(args: &DemoArgs, cancel: &Cancel, log: &Warnings) -> anyhow::Result<()> {
    let mut config = args.reading.config(&args.config)?;
    args.record.apply(&mut config.record);
    let scene = load_scene(&args.scene)?;
    let mut console = Console::new();
    let program = match &args.projector {
        Some(_) => None,
        None => Some(ProjectorProgram::start(scene.projector_size(), args.gui)?),
    };
    let address = match (&args.projector, &program) {
        (Some(address), _) => address.clone(),
        (None, Some(program)) => program.address().to_owned(),
        (None, None) => unreachable!("a projector program was started"),
    };
    let rig_args = RigArgs {
        projector: address,
        camera: Some(CameraSpec::Simulated(args.scene.clone())),
        camera_settings: CameraArgs::default(),
        take_over: false,
        config: args.config.clone(),
    };
    let calibration = scene.calibration();
    let out = match &args.out {
        Some(out) => out.clone(),
        None => fresh_folder(&usual_folder(&args.scene)),
    };
    if args.gui {
        let startup = Startup {
            rig: rig_args,
            config,
            out,
            calibration: Some(calibration),
            run_all: true,
            remember: None,
            log: log.clone(),
        };
        return gui::run(startup, cancel);
    }
    let mut rig = open_rig(&rig_args, &config)?;
    console.say(&format!(
        "projector {}, {}",
        rig_args.projector,
        rig.camera.description()
    ));
    let recording = Recording {
        out: &out,
        pick_colours: true,
        object: Placing::Camera,
        calibration: Some(&calibration),
    };
    let folder = recording.run(&mut rig, &config, cancel, &mut console)?;
    console.say("reading the scan");
    let processed = process_scan(&folder, &config)?;
    let scores = score_against_truth(&scene, &folder, &processed);
    let selection = folder.selection()?;
    if args.reading.json {
        let mut figures = process::figures(&folder, &processed)?;
        figures["truth"] = serde_json::to_value(&scores)?;
        figures["colours"] = serde_json::to_value(&selection)?;
        println!("{figures}");
        return Ok(());
    }
    if let Some(selection) = selection {
        print!("{}", colours::text(&selection, &Palette::default()));
    }
    process::print(&folder, &processed, false)?;
    for score in &scores {
        println!(
            "{:<22}{}",
            format!("truth, {}", score.stage),
            score.sentence()
        );
    }
    Ok(())
}

/// demo-cube for the scene `cube`, and for the scene file `rooms/cube.toml`.
fn usual_folder(scene: &str) -> PathBuf {
    let stem = Path::new(scene).file_stem().unwrap_or_default();
    PathBuf::from(format!("demo-{}", stem.to_string_lossy()))
}

/// What was read against what the simulation knows.
fn score_against_truth(
    scene: &Scene,
    folder: &ScanFolder,
    processed: &Processed,
) -> Vec<StageScore> {
    let projected = folder.projected();
    let stages = Stage::BOTH.into_iter().filter_map(|stage| {
        let reading = processed.result.stage(stage)?;
        let truth = Room::new(scene, stage).truth(&projected.pattern.coded, projected.raster);
        let read: Vec<_> = reading.grid.vertices().collect();
        Some(score_stage(&truth, &read, stage))
    });
    stages.collect()
}
