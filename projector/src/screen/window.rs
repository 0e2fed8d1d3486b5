//! The event loop of the windows: the picture's, and the operator's.
//!
//! Takes orders, gives what winit and the GPU make of them. While a new picture is not certainly shown it
//! is presented again and again; then the loop sleeps until something happens. The operator's window is drawn
//! only while no picture is on its way and none came for a while.

use std::{
    net::SocketAddr,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
    time::{Duration, Instant},
};

use look::log::Warnings;
use serde::{Deserialize, Serialize};
use shared::protocol::Command;
use winit::{
    application::ApplicationHandler,
    event::{ElementState, KeyEvent, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy},
    keyboard::{Key, NamedKey},
    monitor::MonitorHandle,
    window::WindowId,
};

use super::{
    Orders, Placement, Reporter, ScreenError,
    keys::command_of,
    monitors::{self, Monitor},
    operator_window::{OperatorWindow, Outcome},
    pattern_window::{Look, PatternWindow},
    presentation::{Next, Presentation},
    surface::Frame,
};
use crate::{
    operator::Action,
    state::{Overview, Picture},
};

/// How often it is looked whether the monitor is still there.
const MONITOR_CHECK: Duration = Duration::from_secs(2);
/// Pause before a frame that could not be presented is tried again.
const RETRY: Duration = Duration::from_millis(100);
/// The operator's window is drawn while the next presentation of a picture is at least this far away.
const QUIET: Duration = Duration::from_millis(25);

/// What the window is opened with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WindowSettings {
    /// Where it goes.
    pub placement: Placement,
    /// After how many refreshes a picture is taken as certainly shown.
    pub hold_refreshes: u32,
    /// The operator's window.
    pub operator: OperatorSettings,
}

/// What the operator's window is opened with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OperatorSettings {
    /// Whether it opens by itself.
    pub when: WhenOperator,
    /// Where commands are taken from the network, for people to see.
    pub listening: Option<SocketAddr>,
}

/// Whether the operator's window opens by itself. The O key opens and closes it in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WhenOperator {
    /// If there is a second monitor, so that it doesn't cover the picture.
    #[default]
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// Opens the window and runs until the orders, the Escape key or its close button end it.
///
/// # Errors
/// There is no desktop, no such monitor, or no graphics driver, or the desktop ended meanwhile.
pub fn run(
    settings: WindowSettings,
    orders: Arc<Orders>,
    reporter: Reporter,
    warnings: Warnings,
) -> Result<(), ScreenError> {
    let event_loop = EventLoop::<()>::with_user_event().build()?;
    let proxy = event_loop.create_proxy();
    let for_orders = proxy.clone();
    orders.set_wake(move || wake(&for_orders));
    let for_warnings = proxy.clone();
    warnings.set_wake(move || wake(&for_warnings));
    let mut screen = WindowScreen::new(settings, orders, reporter, (proxy, warnings));
    // winit and wgpu panic where the desktop does not answer any more
    let ran = catch_unwind(AssertUnwindSafe(|| event_loop.run_app(&mut screen)));
    ran.map_err(|_| ScreenError::DesktopEnded)??;
    screen.failure.map_or(Ok(()), Err)
}

fn wake(proxy: &EventLoopProxy<()>) {
    // It fails only when the loop has ended, and then there is nothing to wake.
    proxy.send_event(()).ok();
}

struct WindowScreen {
    settings: WindowSettings,
    orders: Arc<Orders>,
    reporter: Reporter,
    proxy: EventLoopProxy<()>,
    /// For the operator's window.
    warnings: Warnings,
    pattern: Option<PatternWindow>,
    operator: Option<OperatorWindow>,
    overview: Option<Overview>,
    picture: Option<Picture>,
    /// Present while the picture is not certainly shown.
    presentation: Option<Presentation>,
    redraw_at: Option<Instant>,
    /// When the pattern changed last, or became certain.
    still_since: Instant,
    check_at: Option<Instant>,
    failure: Option<ScreenError>,
}

impl WindowScreen {
    fn new(
        settings: WindowSettings,
        orders: Arc<Orders>,
        reporter: Reporter,
        (proxy, warnings): (EventLoopProxy<()>, Warnings),
    ) -> Self {
        Self {
            settings,
            orders,
            reporter,
            proxy,
            warnings,
            pattern: None,
            operator: None,
            overview: None,
            picture: None,
            presentation: None,
            redraw_at: None,
            still_since: Instant::now(),
            check_at: None,
            failure: None,
        }
    }

    /// Opens the picture's window where the settings say; a window that is open already is closed after it.
    fn open_pattern(&mut self, event_loop: &ActiveEventLoop) -> Result<(), ScreenError> {
        let gpu = self.pattern.as_ref().map(|open| open.canvas.gpu().clone());
        let opened = PatternWindow::open(event_loop, &self.settings.placement, gpu.as_ref())?;
        self.check_at = opened
            .fills_monitor()
            .then(|| Instant::now() + MONITOR_CHECK);
        self.pattern = Some(opened);
        self.report();
        Ok(())
    }

    /// Opens the operator's window on a monitor without the picture, if there is one.
    fn open_operator(&mut self, event_loop: &ActiveEventLoop) {
        let Some(pattern) = &self.pattern else { return };
        let proxy = self.proxy.clone();
        let other = other_monitor(event_loop, pattern);
        let gpu = pattern.canvas.gpu();
        match OperatorWindow::open(event_loop, gpu, other.as_ref(), move || wake(&proxy)) {
            Ok(opened) => {
                self.operator = Some(opened);
                self.tell_operator(event_loop);
            }
            Err(error) => tracing::error!("there is no operator's window: {error}"),
        }
    }

    fn wants_operator(&self, event_loop: &ActiveEventLoop) -> bool {
        match self.settings.operator.when {
            WhenOperator::Always => true,
            WhenOperator::Never => false,
            WhenOperator::Auto => event_loop.available_monitors().count() > 1,
        }
    }

    fn tell_operator(&mut self, event_loop: &ActiveEventLoop) {
        if let (Some(operator), Some(overview)) = (&mut self.operator, &self.overview) {
            let listening = self.settings.operator.listening;
            operator.tell(overview.clone(), list(event_loop), listening);
        }
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: ScreenError) {
        self.failure = Some(error);
        event_loop.exit();
    }

    /// Tells what the screen is, with what is wrong about it.
    fn report(&self) {
        let Some(pattern) = &self.pattern else { return };
        let info = pattern.info();
        if let Some(problem) = &info.problem {
            tracing::warn!("{problem}");
        }
        self.reporter.screen(info);
    }

    /// Starts to present the picture, in the present size.
    fn present(&mut self) {
        let (Some(pattern), Some(picture)) = (&mut self.pattern, &self.picture) else {
            return;
        };
        if let Err(error) = pattern.canvas.load(&picture.pattern) {
            tracing::error!("picture {} cannot be drawn: {error}", picture.serial);
            return;
        }
        self.presentation = Some(Presentation::new(
            self.settings.hold_refreshes,
            pattern.period,
        ));
        self.redraw_at = None;
        self.still_since = Instant::now();
        pattern.window.request_redraw();
    }

    fn resized(&mut self) {
        let changed = self
            .pattern
            .as_mut()
            .is_some_and(|pattern| pattern.canvas.follow_window());
        if changed {
            self.report();
            self.present();
        }
    }

    fn draw(&mut self) {
        let Some(pattern) = &mut self.pattern else {
            return;
        };
        if let Frame::NotNow(why) = pattern.canvas.draw() {
            tracing::debug!("picture not presented: {why}");
            self.redraw_at = Some(Instant::now() + RETRY);
            return;
        }
        let Some(presentation) = &mut self.presentation else {
            return;
        };
        match presentation.presented(Instant::now()) {
            Next::Again => pattern.window.request_redraw(),
            Next::AgainAt(time) => self.redraw_at = Some(time),
            Next::Certain => self.finish(),
        }
    }

    /// Tells that the picture is shown, once the GPU has drawn the last presentation.
    fn finish(&mut self) {
        let (Some(pattern), Some(picture)) = (&self.pattern, &self.picture) else {
            return;
        };
        if pattern.canvas.finish() {
            self.presentation = None;
            self.still_since = Instant::now();
            self.reporter
                .presented(picture.serial, pattern.canvas.raster());
        } else {
            tracing::warn!("the GPU does not finish picture {}", picture.serial);
            self.redraw_at = Some(Instant::now() + RETRY);
        }
    }

    /// Whether the operator's window may be drawn: no picture is on its way, or its next presentation is far off.
    fn is_quiet(&self) -> bool {
        let far = |time: Instant| time.saturating_duration_since(Instant::now()) >= QUIET;
        self.presentation.is_none() || self.redraw_at.is_some_and(far)
    }

    fn draw_operator(&mut self, event_loop: &ActiveEventLoop) {
        let (quiet, still_since) = (self.is_quiet(), self.still_since);
        let Some(operator) = &mut self.operator else {
            return;
        };
        operator.changed();
        if !quiet
            || operator
                .due(still_since)
                .is_some_and(|time| time > Instant::now())
        {
            return;
        }
        for action in operator.draw() {
            match action {
                Action::Command(command) => self.reporter.operator(command),
                Action::MoveTo(name) => self.move_to(event_loop, name),
                Action::End => event_loop.exit(),
            }
        }
    }

    /// Fills another monitor with the picture; the operator's window makes room.
    fn move_to(&mut self, event_loop: &ActiveEventLoop, name: String) {
        let before = std::mem::replace(
            &mut self.settings.placement,
            Placement::FullScreen(Some(name)),
        );
        if let Err(error) = self.open_pattern(event_loop) {
            tracing::error!("the picture stays where it is: {error}");
            self.settings.placement = before;
            return;
        }
        self.present();
        if let (Some(operator), Some(pattern)) = (&mut self.operator, &self.pattern)
            && let Some(other) = other_monitor(event_loop, pattern)
        {
            operator.move_to(&other);
        }
    }

    fn ask(&self, outcome: Outcome) {
        match outcome {
            Outcome::Ask(command) => self.reporter.operator(command),
            Outcome::ToggleBlank => {
                let blank = self.overview.as_ref().is_some_and(|all| all.state.blank);
                self.reporter.operator(Command::Blank { on: !blank });
            }
            Outcome::Nothing | Outcome::Close | Outcome::Draw => {}
        }
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, key: &Key) {
        match key {
            Key::Named(NamedKey::Escape) => event_loop.exit(),
            Key::Character(text) if text.eq_ignore_ascii_case("o") => {
                if self.operator.take().is_none() {
                    self.open_operator(event_loop);
                }
            }
            Key::Character(text) if text.eq_ignore_ascii_case("b") => {
                self.ask(Outcome::ToggleBlank);
            }
            key => {
                if let Some(command) = command_of(key) {
                    self.reporter.operator(command);
                }
            }
        }
    }

    fn operator_event(&mut self, event_loop: &ActiveEventLoop, event: &WindowEvent) {
        let Some(operator) = &mut self.operator else {
            return;
        };
        match operator.event(event) {
            Outcome::Draw => self.draw_operator(event_loop),
            Outcome::Close => {
                self.operator = None;
                tracing::info!("the operator's window is closed: the O key opens it again");
            }
            outcome => self.ask(outcome),
        }
    }

    fn check_monitor(&mut self, event_loop: &ActiveEventLoop) {
        let Some(pattern) = &mut self.pattern else {
            return;
        };
        match pattern.look(event_loop) {
            Look::Same => {}
            Look::Changed => self.report(),
            Look::Resized => {
                self.resized();
                self.report();
            }
        }
    }

    fn take_orders(&mut self, event_loop: &ActiveEventLoop) {
        let pending = self.orders.take();
        if pending.end {
            event_loop.exit();
        }
        if let Some(overview) = pending.overview {
            self.overview = Some(*overview);
            self.tell_operator(event_loop);
        }
        if let Some(picture) = pending.picture {
            self.picture = Some(picture);
            self.present();
        }
        if let Some(operator) = &mut self.operator {
            operator.take_preview();
            operator.warn(self.warnings.take());
        }
    }

    /// When to look again; asks for the drawings that are due.
    fn next_time(&mut self, event_loop: &ActiveEventLoop) -> Option<Instant> {
        let now = Instant::now();
        if self.redraw_at.is_some_and(|time| time <= now) {
            self.redraw_at = None;
            if let Some(pattern) = &self.pattern {
                pattern.window.request_redraw();
            }
        }
        if self.check_at.is_some_and(|time| time <= now) {
            self.check_at = Some(now + MONITOR_CHECK);
            self.check_monitor(event_loop);
        }
        let operator_at = self
            .operator
            .as_ref()
            .and_then(|operator| operator.due(self.still_since));
        let quiet = self.is_quiet();
        if let Some(operator) = &self.operator
            && quiet
            && operator_at.is_some_and(|time| time <= now)
        {
            operator.request_redraw();
        }
        let later = operator_at.filter(|time| *time > now);
        [self.redraw_at, self.check_at, later]
            .into_iter()
            .flatten()
            .min()
    }
}

fn list(event_loop: &ActiveEventLoop) -> Vec<Monitor> {
    let monitors = monitors::available(event_loop).into_iter();
    monitors.map(|(_, monitor)| monitor).collect()
}

/// The monitor for the operator: the primary one, or the first, unless the picture fills it.
fn other_monitor(event_loop: &ActiveEventLoop, pattern: &PatternWindow) -> Option<MonitorHandle> {
    let monitors = monitors::available(event_loop);
    let free = |monitor: &Monitor| !pattern.fills_monitor() || monitor.name != pattern.name;
    let mut others: Vec<_> = monitors
        .into_iter()
        .filter(|(_, monitor)| free(monitor))
        .collect();
    let primary = others.iter().position(|(_, monitor)| monitor.primary);
    (!others.is_empty()).then(|| others.swap_remove(primary.unwrap_or(0)).0)
}

impl ApplicationHandler for WindowScreen {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.pattern.is_some() {
            return;
        }
        match self.open_pattern(event_loop) {
            Ok(()) if self.wants_operator(event_loop) => self.open_operator(event_loop),
            Ok(()) => {}
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        if self
            .operator
            .as_ref()
            .is_some_and(|operator| operator.id() == id)
        {
            return self.operator_event(event_loop, &event);
        }
        // What comes late for a window that was closed is nobody's.
        if self
            .pattern
            .as_ref()
            .is_none_or(|pattern| pattern.window.id() != id)
        {
            return;
        }
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
        let next = self.next_time(event_loop);
        event_loop.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
