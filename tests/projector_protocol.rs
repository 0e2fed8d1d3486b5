//! The program `projector` without a window: what it says over TCP, on the command line, and at its end.

mod projector_support;

#[path = "projector_protocol/clients.rs"]
mod clients;
#[path = "projector_protocol/pictures.rs"]
mod pictures;
#[path = "projector_protocol/program.rs"]
mod program;

use projector_support::Projector;
use shared::{
    pattern::RasterSize,
    protocol::{ErrorCode, ServerMessage},
};

/// Runs the program to its end, without a display.
fn run(arguments: &str) -> std::process::Output {
    projector_support::run(arguments, &[])
}

const SIZE: RasterSize = RasterSize {
    width: 64,
    height: 48,
};

fn headless() -> Projector {
    Projector::start("--headless 64x48", &[])
}

/// Starts a headless projector with this configuration file.
fn configured(config: &str) -> Projector {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("projector.toml");
    std::fs::write(&file, config).expect("a writable folder");
    Projector::start(
        &format!("--headless 64x48 --config {}", file.display()),
        &[],
    )
}

fn error_of(message: Option<ServerMessage>) -> (ErrorCode, Option<u64>, String) {
    match message {
        Some(ServerMessage::Error { id, code, message }) => (code, id, message),
        other => panic!("{other:?}"),
    }
}
