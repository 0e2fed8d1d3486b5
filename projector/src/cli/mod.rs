//! The command line: what it takes, and how it comes together with the configuration.

mod pair;

mod render;

mod screens;

mod show;

use std::{io::IsTerminal, path::PathBuf, str::FromStr};

use clap::{Args, Parser, Subcommand};
use look::log::Warnings;
use shared::pattern::RasterSize;
use tracing_subscriber::{
    EnvFilter, Layer, filter::LevelFilter, layer::SubscriberExt, util::SubscriberInitExt,
};

const EXAMPLES: &str = "\
Examples:
  projector                             full-screen on the monitor that is not primary
  projector --screen HDMI-1 --listen 0.0.0.0:4460
  projector --windowed 1024x768         an ordinary window, to look at
  projector --headless 1024x768         no window at all, for a simulated room
  projector screens                     which monitors there are
  projector pair                        opens a pairing code for one client
  projector revoke --all                nobody is paired any more
  projector render --pattern config/pattern.toml --size 1024x768 grid.png

Keys in the window: I identify, T test card for focus and keystone, C coded grid,
2 two-colour grid, U unary grid, K black, W white, R ramp, B blank and back,
O the operator's window, Escape end.
Standard output gets one line, \"listening on ADDR:PORT\", once the first picture
is shown and commands are taken. The log goes to standard error; RUST_LOG=debug
makes it longer.
Exit codes: 0 ended as asked, 1 failed, 2 wrong use.";

/// Shows the colour-coded grid full-screen and takes commands over TCP.
#[derive(Debug, Parser)]
#[command(name = "projector", version, after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Subcommands>,
    #[command(flatten)]
    show: ShowArgs,
}

#[derive(Debug, Subcommand)]
enum Subcommands {
    /// Lists the monitors, and which one gets the picture.
    Screens(ScreensArgs),
    /// Opens a pairing code that lets one client in, prints it, and has a running projector show it as a QR code.
    Pair,
    /// Lists who is paired.
    Pairings(PairingsArgs),
    /// Takes pairings back; their connections end.
    Revoke(RevokeArgs),
    /// Writes a pattern into a picture file, pixel for pixel as it would be shown.
    Render(RenderArgs),
}

/// How to show pictures.
#[derive(Debug, Args)]
struct ShowArgs {
    /// Show nothing, but count pictures as shown at 60 Hz on a raster of this size.
    #[arg(long, value_name = "WxH", conflicts_with_all = ["windowed", "screen"])]
    headless: Option<RasterSize>,
    /// Open an ordinary window whose inside has this size in pixels.
    #[arg(long, value_name = "WxH", conflicts_with = "screen")]
    windowed: Option<RasterSize>,
    /// Fill the monitor of this name (see `projector screens`).
    #[arg(long, value_name = "NAME")]
    screen: Option<String>,
    /// Open the operator's window even if it covers the picture; by itself it opens on a second monitor only.
    #[arg(long, conflicts_with_all = ["headless", "no_operator"])]
    operator: bool,
    /// Don't open the operator's window.
    #[arg(long)]
    no_operator: bool,
    /// Take commands on this address (default 127.0.0.1:4460); port 0 takes a free one. On an address other
    /// than loopback the projector speaks TLS and lets in who is paired.
    #[arg(long, value_name = "ADDR:PORT")]
    listen: Option<Address>,
    /// Read settings from this file, in the form of config/projector.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Begin with the grid in this file, in the form of config/pattern.toml.
    #[arg(long, value_name = "FILE")]
    pattern: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct ScreensArgs {
    /// Print one JSON object and nothing else.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct PairingsArgs {
    /// Print one JSON object and nothing else.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct RevokeArgs {
    /// The client's name, as `projector pairings` lists it.
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// Everybody.
    #[arg(long)]
    all: bool,
}

#[derive(Debug, Args)]
#[command(after_help = render::FORMS)]
struct RenderArgs {
    /// What to draw, as JSON or TOML (a name ending in .toml).
    #[arg(long, value_name = "FILE")]
    pattern: PathBuf,
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WxH")]
    size: RasterSize,
    /// Draw the single-colour twin of the grid, in the file's `unary` colour.
    #[arg(long)]
    unary: bool,
    /// The picture to write.
    #[arg(value_name = "OUT.png")]
    out: PathBuf,
}

/// An address with a port; the address may be a name.
#[derive(Debug, Clone)]
struct Address(String);

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let port = text.rsplit_once(':').filter(|(host, _)| !host.is_empty());
        match port.map(|(_, port)| port.parse::<u16>()) {
            Some(Ok(_)) => Ok(Self(text.to_owned())),
            _ => Err("write ADDRESS:PORT, for example 127.0.0.1:4460".to_owned()),
        }
    }
}

/// Sends the log to standard error: warnings and what happened, or what RUST_LOG asks for. Gives the warnings for the
/// operator's window.
#[must_use]
pub fn start_log() -> Warnings {
    let quiet_libraries = "info,wgpu_core=warn,wgpu_hal=error,naga=warn,winit=warn";
    let filter =
        EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(quiet_libraries));
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal());
    let warnings = Warnings::default();
    tracing_subscriber::registry()
        .with(lines.with_filter(filter))
        .with(warnings.clone().with_filter(LevelFilter::WARN))
        .init();
    warnings
}

/// Does what the command line says; the operator's window shows the warnings.
///
/// # Errors
/// Whatever failed, with what to do about it.
pub fn run(cli: Cli, warnings: Warnings) -> anyhow::Result<()> {
    match cli.command {
        None => show::run(cli.show, warnings),
        Some(Subcommands::Pair) => pair::invite(),
        Some(Subcommands::Pairings(args)) => pair::list(args.json),
        Some(Subcommands::Revoke(args)) => pair::revoke(args.name.as_deref()),
        Some(Subcommands::Screens(args)) => screens::run(args.json),
        Some(Subcommands::Render(args)) => render::run(&args),
    }
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::Cli;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn wrong_use_is_refused() {
        for words in [
            "--headless 0x768",
            "--headless 64x48 --windowed 64x48",
            "--screen A --windowed 64x48",
            "--operator --no-operator",
            "--operator --headless 64x48",
            "--listen 4460",
            "--listen :4460",
            "--listen localhost:99999",
            "render --size 64x48 out.png",
            "revoke",
            "revoke somebody --all",
            "sing",
        ] {
            let arguments = ["projector"].into_iter().chain(words.split(' '));
            assert!(Cli::try_parse_from(arguments).is_err(), "{words}");
        }
    }
}
