//! What a program's log warns of, for its window to show.
//!
//! Takes the log's events, gives the warnings and errors of our own code as sentences; those of the window system's and
//! the graphics crates say nothing to an operator.

use std::{
    collections::VecDeque,
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use tracing::{
    Event, Level, Subscriber,
    field::{Field, Visit},
};
use tracing_subscriber::{Layer, layer::Context};

/// Warnings that are kept until somebody takes them.
const KEPT: usize = 50;
/// The crates whose warnings are for the operator.
const OWN: [&str; 5] = ["acquirer", "look", "pipeline", "projector", "shared"];

/// What is called when there is a new warning.
type Wake = Box<dyn Fn() + Send>;

/// A layer of the log that keeps warnings. Copies keep them together.
#[derive(Clone, Default)]
pub struct Warnings(Arc<Mutex<Kept>>);

#[derive(Default)]
struct Kept {
    warnings: VecDeque<String>,
    wake: Option<Wake>,
}

impl fmt::Debug for Warnings {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_list().entries(&self.kept().warnings).finish()
    }
}

impl Warnings {
    /// The warnings since the last call, the oldest first.
    #[must_use]
    pub fn take(&self) -> Vec<String> {
        self.kept().warnings.drain(..).collect()
    }

    /// Has something done at every warning from now on. It must not write to the log itself.
    pub fn set_wake(&self, wake: impl Fn() + Send + 'static) {
        self.kept().wake = Some(Box::new(wake));
    }

    fn keep(&self, warning: String) {
        let mut kept = self.kept();
        if kept.warnings.len() == KEPT {
            kept.warnings.pop_front();
        }
        kept.warnings.push_back(warning);
        if let Some(wake) = &kept.wake {
            wake();
        }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
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
        if field.name() == "message" {
            self.message += &format!("{value:?}");
        } else {
            let comma = if self.values.is_empty() { "" } else { ", " };
            self.values += &format!("{comma}{} {value:?}", field.name());
        }
    }
}

#[cfg(test)]
mod tests {
    use tracing_subscriber::layer::SubscriberExt;

    use super::*;

    #[test]
    fn our_own_warnings_are_kept_once_and_nothing_else_is() {
        let warnings = Warnings::default();
        let (woken, wakes) = std::sync::mpsc::channel();
        warnings.set_wake(move || woken.send(()).unwrap_or_default());
        let log = tracing_subscriber::registry().with(warnings.clone());
        tracing::subscriber::with_default(log, || {
            tracing::info!("all is well");
            tracing::warn!(target: "wgpu_core", "a texture");
            tracing::warn!(target: "acquirer::camera", camera = "a webcam", "no frames");
        });
        assert_eq!(warnings.take(), ["no frames (camera \"a webcam\")"]);
        assert!(warnings.take().is_empty());
        assert_eq!(wakes.try_iter().count(), 1);
    }
}
