//! The window: full-screen on the projector's monitor, or an ordinary one to look at.
//!
//! Takes orders, gives what winit and the GPU make of them. While a new picture is not certainly shown it
//! is presented again and again; then the loop sleeps until something happens.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use shared::protocol::{ScreenInfo, ScreenKind};
use winit::{
    application::ApplicationHandler,
    dpi::{PhysicalPosition, PhysicalSize},
    event::{ElementState, KeyEvent, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    keyboard::{Key, NamedKey},
    window::{Window, WindowAttributes, WindowId},
};

use super::{
    Orders, Placement, Reporter, ScreenError,
    keys::command_of,
    monitor_watch::{MonitorWatch, Place},
    placement::{choose_monitor, full_screen},
    presentation::{Next, Presentation},
    surface::{Canvas, Frame},
};
use crate::state::Picture;

/// How often it is looked whether the monitor is still there.
const MONITOR_CHECK: Duration = Duration::from_secs(2);
/// Pause before a frame that could not be presented is tried again.
const RETRY: Duration = Duration::from_millis(100);
/// Refresh rate taken where the system tells none.
const USUAL_REFRESH_HZ: f64 = 60.0;

/// What the window is opened with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WindowSettings {
    /// Where it goes.
    pub placement: Placement,
    /// After how many refreshes a picture is taken as certainly shown.
    pub hold_refreshes: u32,
}

/// Opens the window and runs until the orders, the Escape key or its close button end it.
///
/// # Errors
/// There is no desktop, no such monitor, or no graphics driver.
pub fn run(
    settings: WindowSettings,
    orders: Arc<Orders>,
    reporter: Reporter,
) -> Result<(), ScreenError> {
    let event_loop = EventLoop::<()>::with_user_event().build()?;
    let proxy = event_loop.create_proxy();
    orders.set_wake(move || {
        // It fails only when the loop has ended, and then there is nothing to wake.
        proxy.send_event(()).ok();
    });
    let mut screen = WindowScreen::new(settings, orders, reporter);
    event_loop.run_app(&mut screen)?;
    screen.failure.map_or(Ok(()), Err)
}

/// An open window and what is drawn in it.
struct Opened {
    window: Arc<Window>,
    canvas: Canvas,
    name: String,
    period: Duration,
    /// The monitor that is filled; `None` for a window.
    monitor: Option<(MonitorWatch, Place)>,
}

struct WindowScreen {
    settings: WindowSettings,
    orders: Arc<Orders>,
    reporter: Reporter,
    opened: Option<Opened>,
    picture: Option<Picture>,
    /// Present while the picture is not certainly shown.
    presentation: Option<Presentation>,
    redraw_at: Option<Instant>,
    check_at: Option<Instant>,
    monitor_gone: bool,
    failure: Option<ScreenError>,
}

impl WindowScreen {
    fn new(settings: WindowSettings, orders: Arc<Orders>, reporter: Reporter) -> Self {
        Self {
            settings,
            orders,
            reporter,
            opened: None,
            picture: None,
            presentation: None,
            redraw_at: None,
            check_at: None,
            monitor_gone: false,
            failure: None,
        }
    }

    fn open(&self, event_loop: &ActiveEventLoop) -> Result<Opened, ScreenError> {
        let base = WindowAttributes::default().with_title("projector");
        let (attributes, name, monitor) = match &self.settings.placement {
            Placement::FullScreen(wanted) => {
                let (handle, monitor) = choose_monitor(event_loop, wanted.as_deref())?;
                (
                    full_screen(base, &handle),
                    monitor.name.clone(),
                    Some(monitor),
                )
            }
            Placement::Window(size) => {
                let inner = PhysicalSize::new(size.width, size.height);
                let attributes = base.with_inner_size(inner).with_resizable(false);
                (attributes, "window".to_owned(), None)
            }
        };
        let window = Arc::new(event_loop.create_window(attributes)?);
        window.set_cursor_visible(monitor.is_none());
        let canvas = Canvas::new(event_loop, window.clone())?;
        let refresh_hz = monitor.as_ref().and_then(|monitor| monitor.refresh_hz);
        let period = Duration::from_secs_f64(1.0 / refresh_hz.unwrap_or(USUAL_REFRESH_HZ).max(1.0));
        let monitor = monitor.map(|monitor| (MonitorWatch::new(event_loop), Place::from(&monitor)));
        Ok(Opened {
            window,
            canvas,
            name,
            period,
            monitor,
        })
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: ScreenError) {
        self.failure = Some(error);
        event_loop.exit();
    }

    /// Tells what the screen is, with what is wrong about it.
    fn report(&self) {
        let Some(opened) = &self.opened else { return };
        let raster = opened.canvas.raster();
        let (kind, wanted) = match (&opened.monitor, &self.settings.placement) {
            (Some((_, place)), _) => (ScreenKind::FullScreen, place.size()),
            (None, Placement::Window(size)) => (ScreenKind::Window, *size),
            (None, Placement::FullScreen(_)) => (ScreenKind::Window, raster),
        };
        let problem = if self.monitor_gone {
            Some(format!(
                "the monitor {} is gone: plug it in again",
                opened.name
            ))
        } else if raster != wanted {
            Some(format!(
                "the picture is {raster}, not {wanted}: the desktop changed the window"
            ))
        } else {
            None
        };
        if let Some(problem) = &problem {
            tracing::warn!("{problem}");
        }
        self.reporter.screen(ScreenInfo {
            kind,
            name: opened.name.clone(),
            raster,
            problem,
        });
    }

    /// Starts to present the picture, in the present size.
    fn present(&mut self) {
        let (Some(opened), Some(picture)) = (&mut self.opened, &self.picture) else {
            return;
        };
        if let Err(error) = opened.canvas.load(&picture.pattern) {
            tracing::error!("picture {} cannot be drawn: {error}", picture.serial);
            return;
        }
        self.presentation = Some(Presentation::new(
            self.settings.hold_refreshes,
            opened.period,
        ));
        self.redraw_at = None;
        opened.window.request_redraw();
    }

    fn resized(&mut self) {
        let changed = self
            .opened
            .as_mut()
            .is_some_and(|opened| opened.canvas.follow_window());
        if changed {
            self.report();
            self.present();
        }
    }

    fn draw(&mut self) {
        let Some(opened) = &mut self.opened else {
            return;
        };
        if let Frame::NotNow(why) = opened.canvas.draw() {
            tracing::debug!("picture not presented: {why}");
            self.redraw_at = Some(Instant::now() + RETRY);
            return;
        }
        let Some(presentation) = &mut self.presentation else {
            return;
        };
        match presentation.presented(Instant::now()) {
            Next::Again => opened.window.request_redraw(),
            Next::AgainAt(time) => self.redraw_at = Some(time),
            Next::Certain => self.finish(),
        }
    }

    /// Tells that the picture is shown, once the GPU has drawn the last presentation.
    fn finish(&mut self) {
        let (Some(opened), Some(picture)) = (&self.opened, &self.picture) else {
            return;
        };
        if opened.canvas.finish() {
            self.presentation = None;
            self.reporter
                .presented(picture.serial, opened.canvas.raster());
        } else {
            tracing::warn!("the GPU does not finish picture {}", picture.serial);
            self.redraw_at = Some(Instant::now() + RETRY);
        }
    }

    fn key(&self, event_loop: &ActiveEventLoop, key: &Key) {
        if *key == Key::Named(NamedKey::Escape) {
            event_loop.exit();
        } else if let Some(command) = command_of(key) {
            self.reporter.operator(command);
        }
    }

    /// Looks whether the monitor is still where the window is, and puts the window back if it came back.
    fn check_monitor(&mut self, event_loop: &ActiveEventLoop) {
        let Some(opened) = &mut self.opened else {
            return;
        };
        let Some((watch, place)) = &mut opened.monitor else {
            return;
        };
        let found = watch.find(event_loop, &opened.name);
        let was_gone = std::mem::replace(&mut self.monitor_gone, found.is_none());
        if let Some(now) = found
            && (was_gone || now != *place)
        {
            tracing::info!("the monitor {} is {now} now", opened.name);
            *place = now;
            opened
                .window
                .set_outer_position(PhysicalPosition::new(now.x, now.y));
            // Where the system resizes at once it tells so here, and sends no event.
            if opened
                .window
                .request_inner_size(PhysicalSize::new(now.width, now.height))
                .is_some()
            {
                self.resized();
            }
            self.report();
        } else if was_gone != self.monitor_gone {
            self.report();
        }
    }

    fn take_orders(&mut self, event_loop: &ActiveEventLoop) {
        let pending = self.orders.take();
        if pending.end {
            event_loop.exit();
        }
        if let Some(picture) = pending.picture {
            self.picture = Some(picture);
            self.present();
        }
    }
}

impl ApplicationHandler for WindowScreen {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.opened.is_some() {
            return;
        }
        match self.open(event_loop) {
            Ok(opened) => {
                self.check_at = opened
                    .monitor
                    .is_some()
                    .then(|| Instant::now() + MONITOR_CHECK);
                self.opened = Some(opened);
                self.report();
            }
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::RedrawRequested => self.draw(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => self.resized(),
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::KeyboardInput {
                event:
                    KeyEvent {
                        logical_key,
                        state: ElementState::Pressed,
                        repeat: false,
                        ..
                    },
                ..
            } => self.key(event_loop, &logical_key),
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.take_orders(event_loop);
        let now = Instant::now();
        if self.redraw_at.is_some_and(|time| time <= now) {
            self.redraw_at = None;
            if let Some(opened) = &self.opened {
                opened.window.request_redraw();
            }
        }
        if self.check_at.is_some_and(|time| time <= now) {
            self.check_at = Some(now + MONITOR_CHECK);
            self.check_monitor(event_loop);
        }
        let next = [self.redraw_at, self.check_at].into_iter().flatten().min();
        event_loop.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
