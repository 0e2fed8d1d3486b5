//! `acquirer` without a command: the window.

use std::path::PathBuf;

use look::log::Warnings;

use super::args::{CalibrationArgs, RigArgs};
use crate::{
    gui::{self, Startup},
    session::Cancel,
};

/// `acquirer` without a command.
#[derive(Debug, clap::Args)]
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

pub(super) fn run(args: WindowArgs, cancel: &Cancel, log: &Warnings) -> anyhow::Result<()> {
    let startup = Startup {
        config: args.rig.config.load()?,
        calibration: args.calibration.load()?,
        rig: args.rig,
        out: args.out,
        run_all: false,
        remember: gui::usual_settings_file(),
        log: log.clone(),
    };
    gui::run(startup, cancel)
}
