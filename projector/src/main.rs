//! The program `projector`: reads the command line and the configuration, checks them, runs.

use std::process::ExitCode;

use clap::Parser;
use projector::cli::{self, Cli};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let warnings = cli::start_log();
    match cli::run(cli, warnings) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("projector: {error:#}");
            ExitCode::FAILURE
        }
    }
}
