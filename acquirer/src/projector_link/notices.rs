//! What the projector tells unasked, in a queue of bounded length.
//!
//! The newest matter: when nobody takes them, the oldest are thrown away and counted.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use shared::protocol::{ControllerChange, ProjectorState, Shown};

/// Longest queue. A session shows some pictures a second, so this is minutes of them.
const CAPACITY: usize = 256;

/// Something the projector told unasked.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// Another picture is on the screen.
    Shown {
        /// The picture.
        shown: Shown,
        /// When the notice came, on [`crate::clock::monotonic_now`]'s scale.
        received_at: Duration,
    },
    /// Something else of the projector's state has changed.
    StateChanged(Box<ProjectorState>),
    /// A controller joined or left.
    Controller {
        /// Which of the two.
        change: ControllerChange,
        /// Its name.
        name: String,
    },
}

#[derive(Debug, Default)]
struct Queue {
    notices: VecDeque<Notice>,
    dropped: u64,
    /// Why no more will come.
    ended: Option<String>,
}

/// The queue between the reading thread and whoever takes notices.
#[derive(Debug, Default)]
pub(super) struct Notices {
    queue: Mutex<Queue>,
    changed: Condvar,
}

impl Notices {
    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn push(&self, notice: Notice) {
        let mut queue = self.queue();
        if queue.notices.len() == CAPACITY {
            queue.notices.pop_front();
            queue.dropped += 1;
        }
        queue.notices.push_back(notice);
        drop(queue);
        self.changed.notify_all();
    }

    /// No more will come; those in the queue can still be taken.
    pub(super) fn end(&self, reason: &str) {
        self.queue().ended.get_or_insert_with(|| reason.to_owned());
        self.changed.notify_all();
    }

    /// The oldest notice, nothing within `timeout`, or why none will come.
    pub(super) fn take(&self, timeout: Duration) -> Result<Option<Notice>, String> {
        let deadline = Instant::now() + timeout;
        let mut queue = self.queue();
        loop {
            if let Some(notice) = queue.notices.pop_front() {
                return Ok(Some(notice));
            }
            if let Some(reason) = &queue.ended {
                return Err(reason.clone());
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            queue = self
                .changed
                .wait_timeout(queue, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }

    pub(super) fn dropped(&self) -> u64 {
        self.queue().dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(name: usize) -> Notice {
        Notice::Controller {
            change: ControllerChange::Joined,
            name: name.to_string(),
        }
    }

    #[test]
    fn the_oldest_are_thrown_away_and_counted_when_nobody_takes_them() {
        let notices = Notices::default();
        (0..CAPACITY + 3).for_each(|name| notices.push(joined(name)));
        assert_eq!(notices.dropped(), 3);
        assert_eq!(notices.take(Duration::ZERO), Ok(Some(joined(3))));
    }

    #[test]
    fn what_came_before_the_end_can_still_be_taken() {
        let notices = Notices::default();
        notices.push(joined(1));
        notices.end("gone");
        notices.end("a later reason");
        assert_eq!(notices.take(Duration::from_secs(60)), Ok(Some(joined(1))));
        assert_eq!(notices.take(Duration::from_secs(60)), Err("gone".into()));
    }
}
