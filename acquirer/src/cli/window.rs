//! `acquirer` without a command: the window.

use super::args::WindowArgs;
use crate::{
    config::Config,
    gui::{self, Startup},
    process::read_calibration,
    session::Cancel,
};

pub(super) fn run(args: WindowArgs, cancel: &Cancel) -> anyhow::Result<()> {
    let startup = Startup {
        config: Config::load(args.rig.config.as_deref())?,
        calibration: args
            .calibration
            .as_deref()
            .map(read_calibration)
            .transpose()?,
        rig: args.rig,
        out: args.out,
        run_all: false,
    };
    gui::run(startup, cancel)
}
