//! The slot from which a screen takes what to show next. The latest picture replaces an older one that was
//! not taken yet, so the slot holds at most one.

use std::{
    fmt,
    sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError},
};

use crate::state::{Overview, Picture};

/// What a screen finds in the slot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pending {
    /// The picture to show now.
    pub picture: Option<Picture>,
    /// The state for the operator's window, if it has changed.
    pub overview: Option<Box<Overview>>,
    /// The program is to end.
    pub end: bool,
}

type Wake = Box<dyn Fn() + Send + Sync>;

/// The slot, shared by the screen and those who give it orders.
#[derive(Default)]
pub struct Orders {
    pending: Mutex<Pending>,
    told: Mutex<Option<Overview>>,
    filled: Condvar,
    wake: OnceLock<Wake>,
}

impl Orders {
    /// An empty slot.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks for a picture.
    pub fn show(&self, picture: Picture) {
        self.lock().picture = Some(picture);
        self.notify();
    }

    /// Tells the state to the operator's window, if it is news.
    pub fn tell(&self, overview: Overview) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.as_ref() != Some(&overview) {
            self.lock().overview = Some(Box::new(overview.clone()));
            *told = Some(overview);
            self.notify();
        }
    }

    /// Asks for the end of the program.
    pub fn end(&self) {
        self.lock().end = true;
        self.notify();
    }

    /// Takes what is there, without waiting.
    #[must_use]
    pub fn take(&self) -> Pending {
        take(&mut self.lock())
    }

    /// Takes what is there, and waits while there is neither a picture nor the end.
    #[must_use]
    pub fn wait(&self) -> Pending {
        let nothing = |pending: &mut Pending| pending.picture.is_none() && !pending.end;
        let guard = self.filled.wait_while(self.lock(), nothing);
        take(&mut guard.unwrap_or_else(PoisonError::into_inner))
    }

    /// Sets what wakes a screen that sleeps elsewhere than in [`Self::wait`]. Only the first call counts.
    pub fn set_wake(&self, wake: impl Fn() + Send + Sync + 'static) {
        if self.wake.set(Box::new(wake)).is_err() {
            tracing::warn!("the screen's alarm is set already");
        }
    }

    fn lock(&self) -> MutexGuard<'_, Pending> {
        // The slot is valid after every single assignment, so a panic elsewhere does not spoil it.
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn notify(&self) {
        self.filled.notify_all();
        if let Some(wake) = self.wake.get() {
            wake();
        }
    }
}

/// Everything but the end, which stays.
fn take(pending: &mut Pending) -> Pending {
    Pending {
        picture: pending.picture.take(),
        overview: pending.overview.take(),
        end: pending.end,
    }
}

impl fmt::Debug for Orders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Orders")
            .field("pending", &*self.lock())
            .finish_non_exhaustive()
    }
}
