//! What the program's log warns of, for a window to show.
//!
//! Takes the log's events, gives the warnings and errors of our own code as sentences; those of the window system's and
//! the graphics crates say nothing to an operator.

use std::{
    collections::VecDeque,
    fmt::{self, Write},
    sync::{Arc, Mutex, PoisonError},
};

use tracing::{
    Event, Level, Subscriber,
    field::{Field, Visit},
};
use tracing_subscriber::{Layer, layer::Context};

/// Warnings that are kept until somebody takes them.
const KEPT: usize = 50;
/// The crates whose warnings are for the operator.
const OWN: [&str; 3] = ["acquirer", "pipeline", "shared"];

/// A layer of the log that keeps warnings. Copies keep them together.
#[derive(Debug, Clone, Default)]
pub struct Warnings(Arc<Mutex<VecDeque<String>>>);

impl Warnings {
    /// The warnings since the last call, the oldest first.
    #[must_use]
    pub fn take(&self) -> Vec<String> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.drain(..).collect()
    }

    fn keep(&self, warning: String) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() == KEPT {
            kept.pop_front();
        }
        kept.push_back(warning);
    }
}

impl<S: Subscriber> Layer<S> for Warnings {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let metadata = event.metadata();
        let krate = metadata.target().split("::").next().unwrap_or_default();
        if *metadata.level() <= Level::WARN && OWN.contains(&krate) {
            let mut sentence = Sentence::default();
            event.record(&mut sentence);
            self.keep(sentence.text());
        }
    }
}

/// The message of an event, and its values behind it.
#[derive(Default)]
struct Sentence {
    message: String,
    values: String,
}

impl Sentence {
    fn text(self) -> String {
        if self.values.is_empty() {
            return self.message;
        }
        format!("{} ({})", self.message, self.values)
    }
}

impl Visit for Sentence {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        // writing into a string does not fail
        let _ = if field.name() == "message" {
            write!(self.message, "{value:?}")
        } else {
            let comma = if self.values.is_empty() { "" } else { ", " };
            write!(self.values, "{comma}{} {value:?}", field.name())
        };
    }
}

#[cfg(test)]
mod tests {
    use tracing_subscriber::layer::SubscriberExt;

    use super::*;

    #[test]
    fn our_own_warnings_are_kept_once_and_nothing_else_is() {
        let warnings = Warnings::default();
        let log = tracing_subscriber::registry().with(warnings.clone());
        tracing::subscriber::with_default(log, || {
            tracing::info!("all is well");
            tracing::warn!(target: "wgpu_core", "a texture");
            tracing::warn!(target: "acquirer::camera", camera = "a webcam", "no frames");
        });
        assert_eq!(warnings.take(), ["no frames (camera \"a webcam\")"]);
        assert!(warnings.take().is_empty());
    }
}
