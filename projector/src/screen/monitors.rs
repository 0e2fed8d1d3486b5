//! The monitors there are, and which of them is the projector.

use serde::Serialize;
use winit::{
    application::ApplicationHandler,
    event::WindowEvent,
    event_loop::{ActiveEventLoop, EventLoop},
    monitor::MonitorHandle,
    window::WindowId,
};

use super::ScreenError;

/// A monitor, as the system describes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Monitor {
    /// Its name, for example `HDMI-1`; what `--screen` takes.
    pub name: String,
    /// Left edge on the desktop, in pixels.
    pub x: i32,
    /// Upper edge on the desktop, in pixels.
    pub y: i32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Refreshes per second, if the system tells.
    pub refresh_hz: Option<f64>,
    /// The operator's monitor, as far as the system tells.
    pub primary: bool,
}

impl Monitor {
    fn describe(handle: &MonitorHandle, primary: bool) -> Self {
        let (position, size) = (handle.position(), handle.size());
        Self {
            name: handle.name().unwrap_or_else(|| "unnamed".to_owned()),
            x: position.x,
            y: position.y,
            width: size.width,
            height: size.height,
            refresh_hz: handle
                .refresh_rate_millihertz()
                .map(|rate| f64::from(rate) / 1000.0),
            primary,
        }
    }
}

/// The monitors of the running desktop, each with the handle that windows are placed by.
pub(super) fn available(event_loop: &ActiveEventLoop) -> Vec<(MonitorHandle, Monitor)> {
    let primary = event_loop.primary_monitor();
    let describe = |handle: MonitorHandle| {
        let monitor = Monitor::describe(&handle, primary.as_ref() == Some(&handle));
        (handle, monitor)
    };
    event_loop.available_monitors().map(describe).collect()
}

/// Which monitor gets the picture: the one of this name, or without a name the last that is not primary,
/// because a projector is usually plugged in last; the only one if there is no other.
///
/// # Errors
/// No monitor at all, or none of this name.
pub(super) fn choose(monitors: &[Monitor], name: Option<&str>) -> Result<usize, ScreenError> {
    let Some(last) = monitors.len().checked_sub(1) else {
        return Err(ScreenError::NoMonitor);
    };
    let Some(name) = name else {
        return Ok(monitors
            .iter()
            .rposition(|monitor| !monitor.primary)
            .unwrap_or(last));
    };
    monitors
        .iter()
        .position(|monitor| monitor.name == name)
        .ok_or_else(|| {
            let known: Vec<_> = monitors
                .iter()
                .map(|monitor| monitor.name.as_str())
                .collect();
            ScreenError::UnknownMonitor {
                name: name.to_owned(),
                known: known.join(", "),
            }
        })
}

struct Lister(Vec<Monitor>);

impl ApplicationHandler for Lister {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        self.0 = available(event_loop)
            .into_iter()
            .map(|(_, monitor)| monitor)
            .collect();
        event_loop.exit();
    }

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
}

/// The monitors of the desktop this program runs on, and the index of the one that gets the picture
/// unless `--screen` names another.
///
/// # Errors
/// There is no desktop.
pub fn list() -> Result<(Vec<Monitor>, Option<usize>), ScreenError> {
    let event_loop = EventLoop::new()?;
    let mut lister = Lister(Vec::new());
    event_loop.run_app(&mut lister)?;
    let chosen = choose(&lister.0, None).ok();
    Ok((lister.0, chosen))
}

#[cfg(test)]
mod tests {
    use super::{Monitor, choose};

    fn monitor(name: &str, primary: bool) -> Monitor {
        let (width, height) = (1024, 768);
        Monitor {
            name: name.into(),
            x: 0,
            y: 0,
            width,
            height,
            refresh_hz: None,
            primary,
        }
    }

    #[test]
    fn the_projector_is_the_monitor_that_is_not_primary() {
        let monitors = [monitor("eDP-1", true), monitor("HDMI-1", false)];
        assert_eq!(choose(&monitors, None).ok(), Some(1));
        let monitors = [monitor("HDMI-1", false), monitor("eDP-1", true)];
        assert_eq!(choose(&monitors, None).ok(), Some(0));
        assert_eq!(
            choose(&monitors[1..], None).ok(),
            Some(0),
            "there is no other"
        );
    }

    #[test]
    fn without_a_primary_monitor_the_last_is_taken() {
        let monitors = [monitor("A", false), monitor("B", false)];
        assert_eq!(choose(&monitors, None).ok(), Some(1));
    }

    #[test]
    fn an_unknown_name_is_refused_with_the_names_there_are() {
        let monitors = [monitor("eDP-1", true), monitor("HDMI-1", false)];
        assert_eq!(choose(&monitors, Some("eDP-1")).ok(), Some(0));
        let error = choose(&monitors, Some("HDMI-2")).unwrap_err().to_string();
        assert!(
            error.contains("HDMI-2") && error.contains("eDP-1, HDMI-1"),
            "{error}"
        );
        assert!(choose(&[], None).is_err());
    }
}
