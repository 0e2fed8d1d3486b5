//! The projector program without a window.

use std::{
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
};

use anyhow::Context;

use crate::guest::built_program;

/// A running projector program of 1024 x 768 px on a free port; it ends with this value.
#[derive(Debug)]
pub struct HeadlessProjector {
    child: Child,
    address: String,
}

impl HeadlessProjector {
    /// Starts it and waits until it takes commands.
    ///
    /// # Errors
    /// When it has not been built, or does not say where it listens.
    pub fn start() -> anyhow::Result<Self> {
        let mut child = Command::new(built_program("projector")?)
            .args(["--headless", "1024x768", "--listen", "127.0.0.1:0"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let stdout = child.stdout.take();
        // made at once, so that the program ends however this goes on
        let mut projector = Self {
            child,
            address: String::new(),
        };
        let mut line = String::new();
        BufReader::new(stdout.context("standard output is piped")?).read_line(&mut line)?;
        let address = line.trim().strip_prefix("listening on ");
        address
            .with_context(|| format!("the projector's first line is {line:?}"))?
            .clone_into(&mut projector.address);
        Ok(projector)
    }

    /// Where it listens, as HOST:PORT.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// The port alone.
    #[must_use]
    pub fn port(&self) -> &str {
        self.address.rsplit(':').next().unwrap_or_default()
    }
}

impl Drop for HeadlessProjector {
    fn drop(&mut self) {
        // it may have ended by itself
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
