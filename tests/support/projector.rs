//! The projector program, without a window or with its real one on a display.

use std::{
    ffi::OsStr,
    fs,
    io::{BufRead, BufReader},
    path::Path,
    process::{Child, Command, ExitStatus, Stdio},
};

use anyhow::Context;

use crate::guest::built_program;

/// A running projector program; it ends with this value.
#[derive(Debug)]
pub struct ProjectorProgram {
    child: Child,
    address: String,
}

impl ProjectorProgram {
    /// Starts it without a window for this computer alone, on a free port, and waits until it takes commands.
    ///
    /// # Errors
    /// When it has not been built, or does not say where it listens.
    pub fn headless() -> anyhow::Result<Self> {
        Self::run(&["--listen", "127.0.0.1:0"], Path::new("/nowhere"))
    }

    /// As [`Self::headless`], but it fills the display that these variables name.
    ///
    /// # Errors
    /// As [`Self::headless`].
    pub fn full_screen(environment: &[(&str, &str)]) -> anyhow::Result<Self> {
        let mut program = Command::new(built_program("projector")?);
        program
            .args(["--listen", "127.0.0.1:0"])
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_CONFIG_HOME", "/nowhere")
            .envs(environment.iter().copied());
        Self::of(program)
    }

    /// Starts it on a port (0: a free one) of every network, with its secrets in `home`. It is reached on this computer
    /// by [`Self::address`].
    ///
    /// # Errors
    /// As [`Self::headless`].
    pub fn on_network(home: &Path, port: &str) -> anyhow::Result<Self> {
        let mut projector = Self::run(&["--listen", &format!("0.0.0.0:{port}")], home)?;
        projector.address = format!("127.0.0.1:{}", projector.port());
        Ok(projector)
    }

    /// Starts it as a screen of 1024 x 768 px with these arguments, with its secrets in `home`.
    ///
    /// # Errors
    /// As [`Self::headless`].
    pub fn run<A: AsRef<OsStr>>(arguments: &[A], home: &Path) -> anyhow::Result<Self> {
        let mut program = Command::new(built_program("projector")?);
        program
            .args(["--headless", "1024x768"])
            .args(arguments)
            .env("XDG_CONFIG_HOME", home);
        Self::of(program)
    }

    fn of(mut program: Command) -> anyhow::Result<Self> {
        let mut child = program
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

    /// Its process.
    #[must_use]
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// Waits for its end.
    ///
    /// # Errors
    /// What the system says.
    pub fn ended(&mut self) -> std::io::Result<ExitStatus> {
        self.child.wait()
    }

    /// What it takes of the machine now.
    ///
    /// # Errors
    /// When it has ended.
    pub fn usage(&self) -> anyhow::Result<Usage> {
        Usage::of(self.child.id())
    }
}

impl Drop for ProjectorProgram {
    fn drop(&mut self) {
        // it may have ended by itself
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// What a process takes of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Usage {
    /// Memory in use, in KiB.
    pub memory_kib: u64,
    /// Threads.
    pub threads: usize,
    /// Open files and sockets.
    pub descriptors: usize,
}

impl Usage {
    /// Of a process of this machine.
    ///
    /// # Errors
    /// When it has ended.
    pub fn of(process: u32) -> anyhow::Result<Self> {
        let dir = Path::new("/proc").join(process.to_string());
        let status = fs::read_to_string(dir.join("status"))?;
        let memory = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let memory = memory.context("no VmRSS: the process has ended")?;
        Ok(Self {
            memory_kib: memory.trim().trim_end_matches(" kB").parse()?,
            threads: fs::read_dir(dir.join("task"))?.count(),
            descriptors: fs::read_dir(dir.join("fd"))?.count(),
        })
    }
}
