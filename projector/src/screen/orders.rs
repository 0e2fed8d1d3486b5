//! The slot from which a screen takes what to show next. The latest picture replaces an older one that was
//! not taken yet, so the slot holds at most one.

use std::{
    fmt,
    sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError},
};

use crate::state::Picture;

/// What a screen finds in the slot.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pending {
    /// The picture to show now.
    pub picture: Option<Picture>,
    /// The program is to end.
    pub end: bool,
}

type Wake = Box<dyn Fn() + Send + Sync>;

/// The slot, shared by the screen and those who give it orders.
#[derive(Default)]
pub struct Orders {
    pending: Mutex<Pending>,
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

    /// Asks for the end of the program.
    pub fn end(&self) {
        self.lock().end = true;
        self.notify();
    }

    /// Takes what is there, without waiting.
    #[must_use]
    pub fn take(&self) -> Pending {
        let mut pending = self.lock();
        Pending {
            picture: pending.picture.take(),
            end: pending.end,
        }
    }

    /// Takes what is there, and waits while there is nothing.
    #[must_use]
    pub fn wait(&self) -> Pending {
        let nothing = |pending: &mut Pending| pending.picture.is_none() && !pending.end;
        let guard = self.filled.wait_while(self.lock(), nothing);
        let mut pending = guard.unwrap_or_else(PoisonError::into_inner);
        Pending {
            picture: pending.picture.take(),
            end: pending.end,
        }
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

impl fmt::Debug for Orders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Orders")
            .field("pending", &*self.lock())
            .finish_non_exhaustive()
    }
}
