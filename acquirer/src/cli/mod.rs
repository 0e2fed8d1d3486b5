//! The command line: parse, check, run; one place where the exit code is made.
//!
//! Exit codes: 0 done, 1 failed, 2 wrong use. Figures go to standard output (with `--json` one object and nothing
//! else, `live` one per frame), progress and messages to standard error.

mod args;
pub mod cameras;
mod check;
mod colours;
mod console;
mod demo;
mod doctor;
mod draw;
mod find;
mod live;
mod pair;
mod process;
mod projector_program;
mod rig;
mod scan;
mod window;

use std::{io::IsTerminal, process::ExitCode};

use clap::Parser;
use look::log::Warnings;
use tracing_subscriber::{
    EnvFilter, Layer, filter::LevelFilter, layer::SubscriberExt, util::SubscriberInitExt,
};

use crate::session::Cancel;
pub use args::RigArgs;
use args::{Args, Command};
use cameras::CamerasArgs;
pub use pair::code_in;
pub use process::figures_text;
pub use rig::open_rig;

/// Runs the program with the arguments of the process.
#[must_use]
pub fn main() -> ExitCode {
    let args = Args::parse();
    let warnings = Warnings::default();
    init_log(&warnings);
    let cancel = Cancel::default();
    let on_signal = cancel.clone();
    if let Err(error) = ctrlc::set_handler(move || on_signal.quit()) {
        tracing::warn!("Ctrl-C will end the program at once: {error}");
    }
    match run(args, &cancel, &warnings) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("acquirer: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: Args, cancel: &Cancel, warnings: &Warnings) -> anyhow::Result<()> {
    match args.command {
        None => window::run(args.window, cancel, warnings),
        Some(Command::Cameras(args)) => list_cameras(&args),
        Some(Command::Find(args)) => find::run(&args),
        Some(Command::Pair(args)) => pair::run(&args, cancel),
        Some(Command::Colours(args)) => colours::run(&args, cancel),
        Some(Command::Scan(args)) => scan::run(&args, cancel),
        Some(Command::Doctor(args)) => doctor::run(&args, cancel),
        Some(Command::Live(args)) => live::run(&args, cancel),
        Some(Command::Process(args)) => process::run(&args),
        Some(Command::Check(args)) => check::run(&args),
        Some(Command::Demo(args)) => demo::run(&args, cancel, warnings),
        Some(Command::Draw(args)) => draw::run(&args),
    }
}

fn list_cameras(args: &CamerasArgs) -> anyhow::Result<()> {
    let list = cameras::cameras(args.controls);
    if args.json {
        println!("{}", serde_json::to_string(&list)?);
    } else {
        print!("{}", cameras::table(&list));
    }
    Ok(())
}

/// The log goes to standard error; its warnings are kept for a window as well.
fn init_log(warnings: &Warnings) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time();
    tracing_subscriber::registry()
        .with(lines.with_filter(filter))
        .with(warnings.clone().with_filter(LevelFilter::WARN))
        .init();
}
