//! `acquirer` without a command: the window.

use look::log::Warnings;

use super::args::WindowArgs;
use crate::{
    gui::{self, Startup},
    session::Cancel,
};

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
