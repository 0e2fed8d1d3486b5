//! Programs in a throw-away guest machine with a real V4L2 device.
//!
//! Takes a device, programs, files and a shell script, gives what the script printed.
//! `tests/guest/guest-test.sh` does the work; the first run on a machine fetches a kernel (about
//! half a minute, 120 MB).

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};

/// The kernel's camera in the guest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// The kernel's test driver, which behaves as a webcam and can be unplugged.
    Vivid,
    /// v4l2loopback, which gives what another program writes into it.
    Loopback,
    /// No camera at all.
    None,
}

/// Memory of the guest, in MiB: its file system lies in it, and the programs with their symbols are large.
const MEMORY_MB: &str = "1024";

/// A guest that has not run yet.
#[derive(Clone, Debug)]
pub struct Guest {
    device: Device,
    arguments: Vec<String>,
    seconds: u32,
}

impl Guest {
    /// A guest with this device as `/dev/video0`, which may run for ten minutes.
    #[must_use]
    pub fn with(device: Device) -> Self {
        Self {
            device,
            arguments: vec![],
            seconds: 600,
        }
    }

    /// Another limit of its run, in seconds.
    #[must_use]
    pub fn for_seconds(mut self, seconds: u32) -> Self {
        self.seconds = seconds;
        self
    }

    /// Puts a program and its libraries into the guest's `/bin`.
    #[must_use]
    pub fn program(self, path: impl AsRef<Path>) -> Self {
        self.option("-x", path.as_ref())
    }

    /// Puts a file into the guest's `/`.
    #[must_use]
    pub fn file(self, path: impl AsRef<Path>) -> Self {
        self.option("-f", path.as_ref())
    }

    /// Has a port of this machine's loopback address lead to one of the guest.
    #[must_use]
    pub fn forward(mut self, here: u16, there: u16) -> Self {
        self.arguments
            .extend(["-F".to_owned(), format!("{here}:{there}")]);
        self
    }

    fn option(mut self, name: &str, path: &Path) -> Self {
        self.arguments
            .extend([name.to_owned(), path.display().to_string()]);
        self
    }

    /// Boots, runs the script with the guest's shell, and gives what it printed on both outputs.
    ///
    /// # Errors
    /// When the guest cannot be made or dies, or the script fails; the error holds what was
    /// printed.
    pub fn run(self, script: &str) -> anyhow::Result<String> {
        let runner = Path::new(env!("CARGO_MANIFEST_DIR")).join("guest/guest-test.sh");
        let device = match self.device {
            Device::Vivid => "vivid",
            Device::Loopback => "loopback",
            Device::None => "none",
        };
        let output = Command::new(&runner)
            .args(["-d", device, "-m", MEMORY_MB, "-t"])
            .arg(self.seconds.to_string())
            .args(&self.arguments)
            .args(["--", "sh", "-c", script])
            .output()
            .with_context(|| format!("cannot start {}", runner.display()))?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        if !output.status.success() {
            bail!(
                "{}: {}\n{text}\n{}",
                runner.display(),
                output.status,
                String::from_utf8_lossy(&output.stderr)
            );
        }
        Ok(text)
    }
}

/// A program of this workspace, which stands beside the program that runs, or above the test that runs.
///
/// # Errors
/// When it has not been built.
pub fn built_program(name: &str) -> anyhow::Result<PathBuf> {
    let here = std::env::current_exe()?;
    let folder = here.parent().context("this program stands nowhere")?;
    let above = folder.parent().unwrap_or(folder).join(name);
    let program = match folder.join(name) {
        beside if beside.is_file() => beside,
        _ => above,
    };
    if !program.is_file() {
        bail!(
            "{} has not been built: run `cargo build --workspace` first",
            program.display()
        );
    }
    Ok(program)
}
