//! The window with the picture: full-screen on the projector's monitor, or an ordinary one to look at.

use std::{sync::Arc, time::Duration};

use shared::{
    pattern::RasterSize,
    protocol::{ScreenInfo, ScreenKind},
};
use winit::{
    dpi::{PhysicalPosition, PhysicalSize},
    event_loop::ActiveEventLoop,
    window::{Window, WindowAttributes},
};

use super::{
    Placement, ScreenError,
    gpu::Gpu,
    monitor_watch::{MonitorWatch, Place},
    placement::{choose_monitor, full_screen},
    surface::Canvas,
};

/// Refresh rate taken where the system tells none.
const USUAL_REFRESH_HZ: f64 = 60.0;

/// The monitor that is filled.
struct Filled {
    watch: MonitorWatch,
    place: Place,
    gone: bool,
}

/// What became of the monitor since the last look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Look {
    /// Nothing.
    Same,
    /// It is gone, or is back: what is told about the screen has changed.
    Changed,
    /// The window was put where the monitor is now, and has another size already.
    Resized,
}

/// An open window and what is drawn in it.
pub(super) struct PatternWindow {
    pub(super) window: Arc<Window>,
    pub(super) canvas: Canvas,
    pub(super) name: String,
    /// Time between two refreshes.
    pub(super) period: Duration,
    /// The size asked for.
    wanted: RasterSize,
    /// `None` for an ordinary window.
    filled: Option<Filled>,
}

impl PatternWindow {
    /// Opens the window, with the driver that is open already, if there is one.
    ///
    /// # Errors
    /// No such monitor, or no graphics driver.
    pub(super) fn open(
        event_loop: &ActiveEventLoop,
        placement: &Placement,
        gpu: Option<&Gpu>,
    ) -> Result<Self, ScreenError> {
        let base = WindowAttributes::default().with_title("projector");
        let (attributes, name, monitor) = match placement {
            Placement::FullScreen(wanted) => {
                let (handle, monitor) = choose_monitor(event_loop, wanted.as_deref())?;
                let attributes = full_screen(base, &handle);
                (attributes, monitor.name.clone(), Some(monitor))
            }
            Placement::Window(size) => {
                let inner = PhysicalSize::new(size.width, size.height);
                let attributes = base.with_inner_size(inner).with_resizable(false);
                (attributes, "window".to_owned(), None)
            }
        };
        let window = Arc::new(event_loop.create_window(attributes)?);
        window.set_cursor_visible(monitor.is_none());
        let canvas = Canvas::new(event_loop, window.clone(), gpu)?;
        let refresh_hz = monitor.as_ref().and_then(|monitor| monitor.refresh_hz);
        let period = Duration::from_secs_f64(1.0 / refresh_hz.unwrap_or(USUAL_REFRESH_HZ).max(1.0));
        let wanted = match (&monitor, placement) {
            (Some(monitor), _) => Place::from(monitor).size(),
            (None, Placement::Window(size)) => *size,
            (None, Placement::FullScreen(_)) => canvas.raster(),
        };
        let filled = monitor.map(|monitor| Filled {
            watch: MonitorWatch::new(event_loop),
            place: Place::from(&monitor),
            gone: false,
        });
        Ok(Self {
            window,
            canvas,
            name,
            period,
            wanted,
            filled,
        })
    }

    /// Whether a monitor is filled whose presence is to be looked after.
    pub(super) fn fills_monitor(&self) -> bool {
        self.filled.is_some()
    }

    /// What the screen is, with what is wrong about it.
    pub(super) fn info(&self) -> ScreenInfo {
        let (raster, wanted) = (self.canvas.raster(), self.wanted);
        let gone = self.filled.as_ref().is_some_and(|filled| filled.gone);
        let problem = if gone {
            Some(format!(
                "the monitor {} is gone: plug it in again",
                self.name
            ))
        } else if raster != wanted {
            Some(format!(
                "the picture is {raster}, not {wanted}: the desktop changed the window"
            ))
        } else {
            None
        };
        let kind = match self.filled {
            Some(_) => ScreenKind::FullScreen,
            None => ScreenKind::Window,
        };
        ScreenInfo {
            kind,
            name: self.name.clone(),
            raster,
            problem,
        }
    }

    /// Looks whether the monitor is still where the window is, and puts the window back if it came back.
    pub(super) fn look(&mut self, event_loop: &ActiveEventLoop) -> Look {
        let Some(filled) = &mut self.filled else {
            return Look::Same;
        };
        let found = filled.watch.find(event_loop, &self.name);
        let was_gone = std::mem::replace(&mut filled.gone, found.is_none());
        let Some(now) = found.filter(|now| was_gone || *now != filled.place) else {
            return if was_gone == filled.gone {
                Look::Same
            } else {
                Look::Changed
            };
        };
        tracing::info!("the monitor {} is {now} now", self.name);
        filled.place = now;
        self.wanted = now.size();
        self.window
            .set_outer_position(PhysicalPosition::new(now.x, now.y));
        let size = PhysicalSize::new(now.width, now.height);
        // Where the system resizes at once it tells so here, and sends no event.
        match self.window.request_inner_size(size) {
            Some(_) => Look::Resized,
            None => Look::Changed,
        }
    }
}
