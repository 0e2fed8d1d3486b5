//! The projector program, without a window or with its real one on a display.

use std::{
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
};

use anyhow::Context;

use crate::guest::built_program;

/// A running projector program of 1024 x 768 px without a window on a free port; it ends with this value.
#[derive(Debug)]
pub struct HeadlessProjector(Program);

/// A running projector program that fills a display; it ends with this value.
#[derive(Debug)]
pub struct WindowProjector(Program);

impl HeadlessProjector {
    /// Starts it and waits until it takes commands.
    ///
    /// # Errors
    /// When it has not been built, or does not say where it listens.
    pub fn start() -> anyhow::Result<Self> {
        Program::start(&["--headless", "1024x768"], &[]).map(Self)
    }

    /// Where it listens, as HOST:PORT.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.0.address
    }
}

impl WindowProjector {
    /// Starts it with these variables, which name the display, and waits until it takes commands.
    ///
    /// # Errors
    /// When it has not been built, or does not say where it listens.
    pub fn start(environment: &[(&str, &str)]) -> anyhow::Result<Self> {
        Program::start(&[], environment).map(Self)
    }

    /// Where it listens, as HOST:PORT.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.0.address
    }

    /// The port alone.
    #[must_use]
    pub fn port(&self) -> &str {
        self.0.address.rsplit(':').next().unwrap_or_default()
    }
}

#[derive(Debug)]
struct Program {
    child: Child,
    address: String,
}

impl Program {
    fn start(arguments: &[&str], environment: &[(&str, &str)]) -> anyhow::Result<Self> {
        let mut child = Command::new(built_program("projector")?)
            .args(arguments)
            .args(["--listen", "127.0.0.1:0"])
            .env_remove("WAYLAND_DISPLAY")
            .envs(environment.iter().copied())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let stdout = child.stdout.take();
        // made at once, so that the program ends however this goes on
        let mut program = Self {
            child,
            address: String::new(),
        };
        let mut line = String::new();
        BufReader::new(stdout.context("standard output is piped")?).read_line(&mut line)?;
        let address = line.trim().strip_prefix("listening on ");
        address
            .with_context(|| format!("the projector's first line is {line:?}"))?
            .clone_into(&mut program.address);
        Ok(program)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // it may have ended by itself
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
