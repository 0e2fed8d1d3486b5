//! Why there is no screen.

use thiserror::Error;
use winit::error::{EventLoopError, OsError};

use super::PainterError;

/// Why the window cannot be opened or drawn into.
#[derive(Debug, Error)]
pub enum ScreenError {
    /// No X11 or Wayland session.
    #[error(
        "there is no desktop to open a window on: {0}. Start the projector from a graphical session \
         (DISPLAY or WAYLAND_DISPLAY must be set), or without a window: --headless 1024x768"
    )]
    NoDesktop(String),
    /// A desktop without monitors.
    #[error("the desktop has no monitor: plug the projector in, or use --headless 1024x768")]
    NoMonitor,
    /// No monitor of the name asked for.
    #[error("there is no monitor {name:?}; there are: {known}. `projector screens` lists them")]
    UnknownMonitor {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The window system went away, which its library takes for a defect.
    #[error(
        "the desktop ended: the window is gone, and with it the picture. Start the projector again from a graphical \
         session, or without a window: --headless 1024x768"
    )]
    DesktopEnded,
    /// The window system refused the window.
    #[error("the window cannot be opened")]
    Window(#[from] OsError),
    /// The graphics driver refused the window.
    #[error(
        "no graphics driver can draw into the window: install one \
         (on Debian without a GPU: apt-get install mesa-vulkan-drivers)"
    )]
    Surface(#[from] wgpu::CreateSurfaceError),
    /// No graphics driver fits.
    #[error(
        "no graphics driver can draw into the window: install one \
         (on Debian without a GPU: apt-get install mesa-vulkan-drivers)"
    )]
    NoAdapter(#[from] wgpu::RequestAdapterError),
    /// The graphics driver does not start.
    #[error("the graphics driver does not start")]
    Device(#[from] wgpu::RequestDeviceError),
    /// The system refuses a thread.
    #[error("cannot start a thread")]
    Thread(#[source] std::io::Error),
    /// Only formats that would change the colours.
    #[error(
        "the window has no 8-bit format without sRGB conversion (it has {0}): use another driver"
    )]
    NoExactFormat(String),
    /// A picture the GPU cannot hold.
    #[error(transparent)]
    Painter(#[from] PainterError),
}

impl From<EventLoopError> for ScreenError {
    /// Keeps the system's reason without the place in the window library's source where it arose.
    fn from(error: EventLoopError) -> Self {
        let text = error.to_string();
        let reason = text
            .split_once(".rs:")
            .and_then(|(_, place)| place.split_once(": "));
        let reason = reason.map_or(text.as_str(), |(_, reason)| reason);
        Self::NoDesktop(reason.trim_end_matches('.').to_owned())
    }
}
