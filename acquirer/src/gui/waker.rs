//! Has the window repainted when a thread has something new for it.
//!
//! A graphics card shows every frame's picture. A driver in software draws on the processors that read the frames, and
//! needs a fifth of a second of one for a window of 1280x720: there the window is repainted less often.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use eframe::{CreationContext, egui, wgpu};

/// Least time between two repaints that are drawn in software.
const IN_SOFTWARE: Duration = Duration::from_millis(300);

/// Wakes the window up. Clones count together.
#[derive(Debug, Clone)]
pub(super) struct Waker {
    context: egui::Context,
    /// Least time between two repaints.
    every: Duration,
    /// When the window is repainted, last or next.
    woken: Arc<Mutex<Option<Instant>>>,
}

impl Waker {
    /// For a window that is repainted whenever there is something new.
    pub(super) fn new(context: &egui::Context) -> Self {
        Self {
            context: context.clone(),
            every: Duration::ZERO,
            woken: Arc::default(),
        }
    }

    /// For a window that is drawn as it was created.
    pub(super) fn of(created: &CreationContext<'_>) -> Self {
        let driver = created.wgpu_render_state.as_ref();
        let kind = driver.map(|driver| driver.adapter.get_info().device_type);
        let mut waker = Self::new(&created.egui_ctx);
        if kind == Some(wgpu::DeviceType::Cpu) {
            waker.every = IN_SOFTWARE;
        }
        waker
    }

    /// Has the window repainted, now or as soon as it may be.
    pub(super) fn wake(&self) {
        if let Some(delay) = self.delay_at(Instant::now()) {
            self.context.request_repaint_after(delay);
        }
    }

    /// How long a repaint must wait that is asked for now; `None` when one is due already, which shows what is newest
    /// then.
    fn delay_at(&self, now: Instant) -> Option<Duration> {
        let mut woken = self.woken.lock().unwrap_or_else(PoisonError::into_inner);
        if woken.is_some_and(|woken| woken > now) {
            return None;
        }
        let due = woken.map_or(now, |woken| now.max(woken + self.every));
        *woken = Some(due);
        Some(due - now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the askers of repaints get to hear who ask at these milliseconds.
    fn delays_ms(every_ms: u64, asked_ms: &[u64]) -> Vec<Option<u128>> {
        let waker = Waker {
            every: Duration::from_millis(every_ms),
            ..Waker::new(&egui::Context::default())
        };
        let begun = Instant::now();
        let delay = |ms: &u64| waker.delay_at(begun + Duration::from_millis(*ms));
        let delays = asked_ms.iter().map(delay);
        delays
            .map(|delay| delay.map(|delay| delay.as_millis()))
            .collect()
    }

    #[test]
    fn a_window_that_is_drawn_in_software_is_woken_less_often() {
        let asked = [0, 33, 66, 299, 301, 333, 1000];
        let delays = [Some(0), Some(267), None, None, Some(299), None, Some(0)];
        assert_eq!(delays_ms(300, &asked), delays);
    }

    #[test]
    fn a_window_that_a_graphics_card_draws_is_woken_every_time() {
        assert_eq!(delays_ms(0, &[0, 33, 33, 66]), [Some(0); 4]);
    }
}
