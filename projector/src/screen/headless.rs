//! A screen without a window: pictures count as shown at the next tick of a 60 Hz clock.
//!
//! Nothing is drawn. Whoever wants to know what would be on the wall takes it from the notices, as the
//! simulated camera does.

use std::{thread, time::Duration};

use shared::{
    pattern::RasterSize,
    protocol::{ScreenInfo, ScreenKind},
};

use super::{Orders, Reporter};

/// Time between two refreshes of a usual projector.
const REFRESH: Duration = Duration::from_nanos(1_000_000_000 / 60);

/// Runs until the orders end it.
pub fn run(raster: RasterSize, orders: &Orders, reporter: &Reporter) {
    let name = "headless".to_owned();
    reporter.screen(ScreenInfo {
        kind: ScreenKind::Headless,
        name,
        raster,
        problem: None,
    });
    loop {
        let pending = orders.wait();
        if pending.end {
            return;
        }
        if let Some(picture) = pending.picture {
            thread::sleep(to_next_tick(reporter.clock.now_ns()));
            reporter.presented(picture.serial, raster);
        }
    }
}

fn to_next_tick(now_ns: u64) -> Duration {
    let period = REFRESH.as_nanos() as u64;
    Duration::from_nanos(period - now_ns % period)
}
