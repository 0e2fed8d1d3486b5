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

/// A flag that ends long actions: raised by Ctrl-C for good, or by a button for the action under way.
#[derive(Debug, Clone, Default)]
pub struct Cancel {
    action: Arc<AtomicBool>,
    program: Arc<AtomicBool>,
}

impl Cancel {
    /// A flag for actions that go on beside: it is raised by itself, and with this one when the program is to end.
    #[must_use]
    pub fn beside(&self) -> Self {
        Self {
            action: Arc::default(),
            program: self.program.clone(),
        }
    }

    /// Asks the action under way to stop.
    pub fn cancel(&self) {
        self.action.store(true, Ordering::Relaxed);
    }

    /// Asks the program to end, and every action with it.
    pub fn quit(&self) {
        self.program.store(true, Ordering::Relaxed);
    }

    /// Whether the action under way has been asked to stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.action.load(Ordering::Relaxed) || self.is_quitting()
    }

    /// Whether the program has been asked to end.
    #[must_use]
    pub fn is_quitting(&self) -> bool {
        self.program.load(Ordering::Relaxed)
    }

    /// Lets the next action run, unless the program is to end.
    pub fn reset(&self) {
        self.action.store(false, Ordering::Relaxed);
    }
}
