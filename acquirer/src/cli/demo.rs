//! `acquirer demo`: the whole rig in a simulated room, as two programs on the real wire.

use std::path::{Path, PathBuf};

use shared::{
    pattern::Palette,
    simulation::{Room, Scene},
    stage::Stage,
};

use super::{
    args::{DemoArgs, RigArgs},
    colours,
    console::Console,
    process,
    projector_program::ProjectorProgram,
    rig::open_rig,
    scan::{Placing, Recording},
};
use crate::{
    camera::{CameraSpec, load_scene},
    config::Config,
    gui::{self, Startup},
    process::{Processed, load_selection, process_scan},
    scan::ScanFolder,
    score::{StageScore, score_stage},
    session::Cancel,
};

pub(super) fn run(args: &DemoArgs, cancel: &Cancel) -> anyhow::Result<()> {
    let mut config = Config::load(args.config.as_deref())?;
    config.set_method(args.method.map(Into::into));
    config.set_densify(&args.densify);
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
        take_over: false,
        config: args.config.clone(),
    };
    if args.gui {
        let startup = Startup {
            rig: rig_args,
            config,
            out: args
                .out
                .clone()
                .unwrap_or_else(|| fresh_folder(&args.scene)),
            calibration: Some(scene.calibration()),
            run_all: true,
        };
        return gui::run(startup, cancel);
    }
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| fresh_folder(&args.scene));
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
    };
    let mut folder = recording.run(&mut rig, &config, cancel, &mut console)?;
    folder.set_calibration(&scene.calibration().to_json()?)?;
    console.say("reading the scan");
    let processed = process_scan(&folder, &config)?;
    let scores = score_against_truth(&scene, &folder, &processed);
    let selection = load_selection(&folder)?;
    if args.json {
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

/// A folder that is not there yet: demo-cube, demo-cube-2, ...
fn fresh_folder(scene: &str) -> PathBuf {
    let stem = Path::new(scene)
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let numbered = (2..).map(|n| PathBuf::from(format!("demo-{stem}-{n}")));
    let mut names = std::iter::once(PathBuf::from(format!("demo-{stem}"))).chain(numbered);
    names.find(|name| !name.exists()).unwrap_or_default()
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
