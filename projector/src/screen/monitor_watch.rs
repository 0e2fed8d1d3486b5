//! Looks whether the projector's monitor is still there, and where.
//!
//! winit 0.30 keeps its first list of monitors on X11: the server's change events do not reach it. So on X11
//! the server is asked over a connection of our own; elsewhere winit's list is the present one. Where that
//! connection fails the monitor counts as there, as nothing says otherwise.

use std::fmt;

use shared::pattern::RasterSize;
use winit::{event_loop::ActiveEventLoop, platform::x11::ActiveEventLoopExtX11};
use x11rb::{
    connection::Connection,
    errors::ReplyOrIdError,
    protocol::randr::{ConnectionExt, GetCrtcInfoReply},
    rust_connection::RustConnection,
};

use super::monitors::{self, Monitor};

/// The place of a monitor on the desktop, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl From<&Monitor> for Place {
    fn from(monitor: &Monitor) -> Self {
        let Monitor {
            x,
            y,
            width,
            height,
            ..
        } = *monitor;
        Self {
            x,
            y,
            width,
            height,
        }
    }
}

impl Place {
    /// The monitor's size.
    pub(super) fn size(self) -> RasterSize {
        RasterSize {
            width: self.width,
            height: self.height,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {},{}", self.size(), self.x, self.y)
    }
}

/// Whoever knows the monitors.
pub(super) struct MonitorWatch {
    server: Option<(RustConnection, usize)>,
}

impl MonitorWatch {
    /// Prepares to look at the monitors of this desktop.
    pub(super) fn new(event_loop: &ActiveEventLoop) -> Self {
        if !event_loop.is_x11() {
            return Self { server: None };
        }
        let server = RustConnection::connect(None);
        if let Err(error) = &server {
            tracing::warn!("it will not be noticed when the monitor is unplugged: {error}");
        }
        Self {
            server: server.ok(),
        }
    }

    /// Where the monitor of this name is now; `None` when it is gone.
    pub(super) fn find(&self, event_loop: &ActiveEventLoop, name: &str) -> Option<Place> {
        let by_winit = || {
            let monitors = monitors::available(event_loop);
            monitors
                .iter()
                .find(|(_, monitor)| monitor.name == name)
                .map(|(_, m)| Place::from(m))
        };
        let Some((connection, screen)) = &self.server else {
            return by_winit();
        };
        find_output(connection, *screen, name).unwrap_or_else(|error| {
            tracing::debug!("the X server does not tell its monitors: {error}");
            by_winit()
        })
    }
}

/// Monitors are named as winit names them: by the first output of each active CRTC.
fn find_output(
    connection: &RustConnection,
    screen: usize,
    name: &str,
) -> Result<Option<Place>, ReplyOrIdError> {
    let Some(root) = connection
        .setup()
        .roots
        .get(screen)
        .map(|screen| screen.root)
    else {
        return Ok(None);
    };
    let resources = connection
        .randr_get_screen_resources_current(root)?
        .reply()?;
    let time = resources.config_timestamp;
    for crtc in resources.crtcs {
        let crtc: GetCrtcInfoReply = connection.randr_get_crtc_info(crtc, time)?.reply()?;
        let Some(&output) = crtc.outputs.first().filter(|_| crtc.width > 0) else {
            continue;
        };
        let output = connection.randr_get_output_info(output, time)?.reply()?;
        if output.name == name.as_bytes() {
            let (x, y) = (crtc.x.into(), crtc.y.into());
            let (width, height) = (crtc.width.into(), crtc.height.into());
            return Ok(Some(Place {
                x,
                y,
                width,
                height,
            }));
        }
    }
    Ok(None)
}
