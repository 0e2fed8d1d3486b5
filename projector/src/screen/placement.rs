//! Where the window goes: the monitor, and how the window is put over all of it.

use shared::pattern::RasterSize;
use winit::{
    event_loop::ActiveEventLoop,
    monitor::MonitorHandle,
    window::{Fullscreen, WindowAttributes},
};

use super::{
    ScreenError,
    monitors::{self, Monitor},
};

/// Where the window goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Placement {
    /// All of the monitor of this name; without a name, of the one that is not primary.
    FullScreen(Option<String>),
    /// A window whose inside has this size.
    Window(RasterSize),
}

/// The monitor to fill, with the handle that the window is placed by.
///
/// # Errors
/// No monitor at all, or none of this name.
pub(super) fn choose_monitor(
    event_loop: &ActiveEventLoop,
    wanted: Option<&str>,
) -> Result<(MonitorHandle, Monitor), ScreenError> {
    let mut available = monitors::available(event_loop);
    let all: Vec<Monitor> = available
        .iter()
        .map(|(_, monitor)| monitor.clone())
        .collect();
    let chosen = monitors::choose(&all, wanted)?;
    let (handle, monitor) = available.swap_remove(chosen);
    tracing::info!(
        "showing on {} ({}x{})",
        monitor.name,
        monitor.width,
        monitor.height
    );
    if wanted.is_none() && monitor.primary {
        tracing::warn!(
            "{} is the only monitor: the picture covers your desktop, Escape ends it",
            monitor.name
        );
    }
    Ok((handle, monitor))
}

/// Position and size go with the full-screen hint: without a window manager the hint alone leaves the size
/// wrong. The window stays resizable, because some window managers make no other window full-screen.
pub(super) fn full_screen(base: WindowAttributes, monitor: &MonitorHandle) -> WindowAttributes {
    base.with_decorations(false)
        .with_position(monitor.position())
        .with_inner_size(monitor.size())
        .with_fullscreen(Some(Fullscreen::Borderless(Some(monitor.clone()))))
}
