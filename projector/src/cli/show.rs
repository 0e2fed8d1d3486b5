//! `projector`: shows pictures and takes commands until it is told to end.

use std::{io::Write, net::SocketAddr, sync::Arc};

use anyhow::Context;
use look::log::Warnings;
use shared::pattern::RasterSize;

use super::{ShowArgs, pair};
use crate::{
    access::Access,
    announcement::Announcement,
    config::{self, Config},
    control::{Control, ControlSettings, Listening},
    screen::{self, OperatorSettings, Orders, Placement, Reporter, WhenOperator, WindowSettings},
};

/// The checked command line and configuration.
struct Plan {
    screen: Screen,
    listen: String,
    control: ControlSettings,
}

enum Screen {
    Headless(RasterSize),
    Window(WindowSettings),
}

pub(super) fn run(args: ShowArgs, warnings: Warnings) -> anyhow::Result<()> {
    let mut plan = plan(args)?;
    let listening = Listening::bind(&plan.listen)?;
    let mut announcement = None;
    if !listening.address().ip().is_loopback() {
        let access = protect(listening.address())?;
        announcement = announce_on_network(listening.address(), &access);
        plan.control.access = Some(Arc::new(access));
    }
    if let Screen::Window(settings) = &mut plan.screen {
        settings.operator.listening = Some(listening.address());
    }
    let orders = Arc::new(Orders::new());
    let for_signals = orders.clone();
    ctrlc::set_handler(move || for_signals.end()).context("cannot take Ctrl-C and SIGTERM")?;
    let (control, reporter) = Control::start(listening, plan.control, orders.clone(), announce)?;
    let shown = show(plan.screen, orders, reporter, warnings);
    drop(announcement);
    let stopped = control.stop();
    shown?;
    stopped?;
    tracing::info!("ended");
    Ok(())
}

/// Prepares TLS and pairings; tells the pairing code when nobody is paired.
fn protect(address: SocketAddr) -> anyhow::Result<Access> {
    let access = Access::open()?;
    access.listens_on(address)?;
    match access.open_code()? {
        Some(code) => pair::tell(&code),
        None => tracing::info!(
            "paired: {}; `projector pair` lets another one in",
            access.pairings()?.len()
        ),
    }
    Ok(access)
}

/// Clients find the projector by themselves; where that fails they still reach it by its address.
fn announce_on_network(address: SocketAddr, access: &Access) -> Option<Announcement> {
    Announcement::start(address, access.fingerprint())
        .inspect_err(|error| tracing::warn!("clients must be told the address: {error}"))
        .ok()
}

/// The command line goes before the configuration file, and that before the shipped values.
fn plan(args: ShowArgs) -> anyhow::Result<Plan> {
    let Config {
        control,
        screen,
        operator,
    } = match &args.config {
        Some(path) => Config::read(path)?,
        None => config::shipped_config()?,
    };
    let grid = match &args.pattern {
        Some(path) => config::read_grid(path)?,
        None => config::shipped_grid()?,
    };
    let hold_refreshes = screen.hold_refreshes.get().into();
    let name = args
        .screen
        .or_else(|| Some(screen.name).filter(|name| !name.is_empty()));
    let when = match (args.operator, args.no_operator) {
        (true, _) => WhenOperator::Always,
        (_, true) => WhenOperator::Never,
        _ => operator.window,
    };
    let operator = OperatorSettings {
        when,
        listening: None,
    };
    let window = |placement| {
        Screen::Window(WindowSettings {
            placement,
            hold_refreshes,
            operator,
        })
    };
    Ok(Plan {
        screen: match (args.headless, args.windowed) {
            (Some(size), _) => Screen::Headless(size),
            (None, Some(size)) => window(Placement::Window(size)),
            (None, None) => window(Placement::FullScreen(name)),
        },
        listen: args.listen.map_or(control.listen, |address| address.0),
        control: ControlSettings {
            max_connections: control.max_connections.get().into(),
            queue_messages: control.queue_messages.get().into(),
            on_controller_lost: control.on_controller_lost,
            grid,
            view: screen.start.into(),
            access: None,
        },
    })
}

fn show(
    screen: Screen,
    orders: Arc<Orders>,
    reporter: Reporter,
    warnings: Warnings,
) -> anyhow::Result<()> {
    match screen {
        Screen::Headless(raster) => screen::run_headless(raster, &orders, &reporter),
        Screen::Window(settings) => screen::run_window(settings, orders, reporter, warnings)?,
    }
    Ok(())
}

/// The one line on standard output, for whoever started the program and waits until it can be used.
fn announce(address: SocketAddr) {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = writeln!(stdout, "listening on {address}").and_then(|()| stdout.flush()) {
        tracing::warn!("standard output is closed: {error}");
    }
    tracing::info!("taking commands on {address}");
}
