//! `acquirer live`: reads frame after frame and prints one line for each.

use std::{
    io::{ErrorKind, Write},
    ops::ControlFlow,
};

use super::{
    args::LiveArgs,
    console::Console,
    rig::{make_ready, open_rig},
};
use crate::session::{Cancel, LiveFrame, LiveSettings, grid_warnings, projected, read_live};

pub(super) fn run(args: &LiveArgs, cancel: &Cancel) -> anyhow::Result<()> {
    let mut config = args.rig.config.load()?;
    config.exposure.set |= args.rig.camera_settings.expose;
    let calibration = args.calibration.load()?;
    let mut rig = open_rig(&args.rig, &config)?;
    let mut console = Console::new();
    let projected = projected(&rig)?;
    for warning in grid_warnings(&rig, &projected) {
        console.say(&format!("warning: {warning}"));
    }
    make_ready(&mut rig, &config, cancel, &mut console)?;
    let settings = LiveSettings {
        mode: args.mode.into(),
        average: args.average.get().into(),
        refresh: args.refresh.get(),
        check_latency_every: config.latency.check_every(),
        record: config.record,
        pipeline: config.pipeline,
    };
    let (mut left, mut broken) = (args.frames, None);
    let scene = (&projected, calibration.as_ref());
    read_live(&mut rig, scene, &settings, cancel, &mut |seen| {
        if let Err(error) = print(seen.told, args.json) {
            broken = Some(error);
            return ControlFlow::Break(());
        }
        if let Some(left) = &mut left {
            *left = left.saturating_sub(1);
            if *left == 0 {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    })?;
    match broken {
        // whoever read the lines has had enough
        Some(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

fn print(frame: &LiveFrame, json: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    if json {
        serde_json::to_writer(&mut out, frame)?;
        writeln!(out)?;
    } else {
        let reasons = frame.reasons.iter();
        let reasons = reasons.map(|(reason, count)| format!("  {reason} {count}"));
        writeln!(
            out,
            "{:>8} {:>12.3} s  {:<6} {:>5} crossings {:>7.1} ms{}",
            frame.frame,
            frame.time_s,
            frame.pattern,
            frame.crossings,
            frame.ms,
            reasons.collect::<String>()
        )?;
    }
    out.flush()
}
