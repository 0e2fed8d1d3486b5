//! How a long action tells where it is, and how it is told to stop.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Where a long action is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// What is being done, for the operator.
    pub what: String,
    /// Steps done.
    pub done: usize,
    /// Steps in all.
    pub of: usize,
}

/// Receives the progress of an action, in the action's own thread.
pub type Report<'a> = &'a mut dyn FnMut(Progress);

/// A flag that ends long actions: set by Ctrl-C, by a button, or by the end of the program.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks the action to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it has been asked to stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Lets the next action run.
    pub fn reset(&self) {
        self.0.store(false, Ordering::Relaxed);
    }
}
