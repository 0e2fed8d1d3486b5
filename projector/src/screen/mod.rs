//! Where the pictures go: a window on a projector, or nowhere with the same timing.
//!
//! Beside the picture's window there may be the operator's, which shows and changes the state like any client.
//!
//! A screen runs on the program's main thread, as window systems want it. It takes [`Orders`], and gives
//! back through a [`Reporter`] what it is and from when on a picture is certainly shown. It decides nothing.

mod orders;

mod headless;

mod monitors;

mod monitor_watch;

mod painter;

mod gpu;

mod surface;

mod presentation;

mod placement;

mod keys;

mod pattern_window;

mod operator_window;

mod window;

mod error;

pub use error::ScreenError;
pub use headless::run as run_headless;
pub use monitors::{Monitor, list as list_monitors};
pub use orders::{Orders, Pending};
pub use painter::PainterError;
pub use placement::Placement;
pub use window::{OperatorSettings, WhenOperator, WindowSettings, run as run_window};

use shared::{
    pattern::RasterSize,
    protocol::{Command, ScreenInfo},
};
use tokio::sync::{mpsc, watch};

use crate::clock::Clock;

/// What a screen says about a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presented {
    /// Number of the picture.
    pub serial: u64,
    /// The size it was drawn in.
    pub raster: RasterSize,
    /// From when on it is certainly shown, on the projector's clock.
    pub now_ns: u64,
}

/// The screen's way to tell what happens. Nothing here waits.
#[derive(Debug, Clone)]
pub struct Reporter {
    /// The clock that presentations are dated by.
    pub clock: Clock,
    /// What the screen is; `None` until it is ready. The latest counts.
    pub info: watch::Sender<Option<ScreenInfo>>,
    /// Pictures that are certainly shown.
    pub presented: mpsc::Sender<Presented>,
    /// What the person at the projector asks for by keyboard.
    pub operator: mpsc::Sender<Command>,
}

impl Reporter {
    /// Tells what the screen is, if that is news.
    pub fn screen(&self, info: ScreenInfo) {
        self.info.send_if_modified(|last| {
            let news = last.as_ref() != Some(&info);
            if news {
                *last = Some(info);
            }
            news
        });
    }

    /// Tells that a picture is certainly shown from now on.
    pub fn presented(&self, serial: u64, raster: RasterSize) {
        let report = Presented {
            serial,
            raster,
            now_ns: self.clock.now_ns(),
        };
        if let Err(error) = self.presented.try_send(report) {
            tracing::warn!("nobody takes the report of picture {serial}: {error}");
        }
    }

    /// Passes on what the person at the projector asks for.
    pub fn operator(&self, command: Command) {
        if let Err(error) = self.operator.try_send(command) {
            tracing::warn!("key dropped: {error}");
        }
    }
}
