//! What the operator sees while a command runs: progress on standard error.

use std::io::{IsTerminal, Write};

use crate::session::Progress;

/// Shows progress as one line that is rewritten on a terminal, or one line per step elsewhere.
pub(super) struct Console {
    rewrites: bool,
    width: usize,
}

impl Console {
    pub(super) fn new() -> Self {
        Self {
            rewrites: std::io::stderr().is_terminal(),
            width: 0,
        }
    }

    /// Shows where an action is. Nobody needs to know when standard error is gone.
    pub(super) fn show(&mut self, progress: &Progress) {
        let text = format!("[{:>2}/{}] {}", progress.done, progress.of, progress.what);
        let mut stderr = std::io::stderr().lock();
        let written = if self.rewrites {
            let padding = self.width.saturating_sub(text.len());
            let end = if progress.done == progress.of {
                "\n"
            } else {
                ""
            };
            write!(stderr, "\r{text}{:padding$}{end}", "")
        } else {
            writeln!(stderr, "{text}")
        };
        self.width = if progress.done == progress.of {
            0
        } else {
            text.len()
        };
        written.and_then(|()| stderr.flush()).ok();
    }

    /// A message on a line of its own.
    pub(super) fn say(&mut self, text: &str) {
        if self.rewrites && self.width > 0 {
            eprintln!();
        }
        self.width = 0;
        eprintln!("{text}");
    }
}
