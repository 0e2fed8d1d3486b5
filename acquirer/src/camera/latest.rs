//! A place for one item between the thread that makes it and the one that takes it: the latest
//! wins.
//!
//! Gives bounded memory and fresh frames at any speed of the reader; what is overwritten is
//! counted. It also carries the maker's condition, so that a reader who waits in vain learns why.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How the maker is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Condition {
    /// Items come, or should.
    Running,
    /// The device has gone and is looked for.
    Unplugged,
    /// No item will ever come again, with the reason.
    Ended(String),
}

/// Why nothing could be taken.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Nothing {
    /// Nothing came in time.
    InTime,
    /// The device is away.
    Unplugged,
    /// The maker has ended, with the reason.
    Ended(String),
}

#[derive(Debug)]
struct State<T> {
    item: Option<T>,
    overtaken: u64,
    condition: Condition,
}

/// The place for one item.
#[derive(Debug)]
pub(super) struct Latest<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

impl<T> Latest<T> {
    pub(super) fn new() -> Self {
        let state = State {
            item: None,
            overtaken: 0,
            condition: Condition::Running,
        };
        Self {
            state: Mutex::new(state),
            changed: Condvar::new(),
        }
    }

    /// Every change is a whole assignment, so a panic elsewhere cannot leave the state half
    /// changed.
    fn state(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts an item in place of the one nobody took.
    pub(super) fn put(&self, item: T) {
        let mut state = self.state();
        if state.item.replace(item).is_some() {
            state.overtaken += 1;
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Says how the maker is; a reader that waits is woken by an end.
    pub(super) fn set_condition(&self, condition: Condition) {
        self.state().condition = condition;
        self.changed.notify_all();
    }

    /// How the maker is.
    pub(super) fn condition(&self) -> Condition {
        self.state().condition.clone()
    }

    /// Items that were overwritten before anybody took them.
    pub(super) fn overtaken(&self) -> u64 {
        self.state().overtaken
    }

    /// Takes the item, waiting for one up to `timeout`.
    pub(super) fn take(&self, timeout: Duration) -> Result<T, Nothing> {
        let deadline = Instant::now() + timeout;
        let mut state = self.state();
        loop {
            if let Some(item) = state.item.take() {
                return Ok(item);
            }
            if let Condition::Ended(reason) = &state.condition {
                return Err(Nothing::Ended(reason.clone()));
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                let away = state.condition == Condition::Unplugged;
                return Err(if away {
                    Nothing::Unplugged
                } else {
                    Nothing::InTime
                });
            }
            state = self
                .changed
                .wait_timeout(state, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_item_wins_and_the_others_are_counted() {
        let place = Latest::new();
        for item in 1..=3 {
            place.put(item);
        }
        assert_eq!(place.take(Duration::ZERO), Ok(3));
        assert_eq!(place.overtaken(), 2);
        assert_eq!(place.take(Duration::ZERO), Err(Nothing::InTime));
    }

    #[test]
    fn an_end_wakes_a_reader_but_the_last_item_is_still_given() {
        let place = Latest::new();
        place.put(7);
        place.set_condition(Condition::Ended("over".into()));
        assert_eq!(place.take(Duration::from_secs(60)), Ok(7));
        assert_eq!(
            place.take(Duration::from_secs(60)),
            Err(Nothing::Ended("over".into()))
        );
    }

    #[test]
    fn a_reader_in_vain_learns_that_the_device_is_away() {
        let place = Latest::<u8>::new();
        place.set_condition(Condition::Unplugged);
        assert_eq!(
            place.take(Duration::from_millis(1)),
            Err(Nothing::Unplugged)
        );
    }

    #[test]
    fn an_item_from_another_thread_wakes_the_reader() {
        let place = Latest::new();
        std::thread::scope(|threads| {
            threads.spawn(|| place.put(1));
            assert_eq!(place.take(Duration::from_secs(60)), Ok(1));
        });
    }
}
