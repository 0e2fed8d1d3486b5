//! The projector program as a child process, for the demo: the same program, the same wire as in the lab.

use std::{
    env,
    io::{BufRead, BufReader},
    path::PathBuf,
    process::{Child, Command, Stdio},
};

use anyhow::{Context, bail};
use shared::pattern::RasterSize;

/// How the projector program says where it listens.
const LISTENING: &str = "listening on ";

/// A running projector program; it ends with this value.
pub(super) struct ProjectorProgram {
    child: Child,
    address: String,
}

impl ProjectorProgram {
    /// Starts the projector program that stands beside this one, on a free port of this machine; with its window it
    /// opens the operator's too.
    pub(super) fn start(raster: RasterSize, window: bool) -> anyhow::Result<Self> {
        let program = beside_this_program()?;
        let screen = if window { "--windowed" } else { "--headless" };
        let mut child = Command::new(&program)
            .args([screen, &raster.to_string(), "--listen", "127.0.0.1:0"])
            .args(window.then_some("--operator"))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("{} can't be started", program.display()))?;
        let mut line = String::new();
        if let Some(stdout) = child.stdout.take() {
            BufReader::new(stdout)
                .read_line(&mut line)
                .context("the projector program")?;
        }
        let Some(address) = line.trim().strip_prefix(LISTENING).map(str::to_owned) else {
            child.kill().ok();
            let status = child.wait()?;
            bail!("the projector program did not start ({status}); its message stands above");
        };
        Ok(Self { child, address })
    }

    /// Where it listens, as HOST:PORT.
    pub(super) fn address(&self) -> &str {
        &self.address
    }
}

impl Drop for ProjectorProgram {
    fn drop(&mut self) {
        // it may have ended by itself, by the same Ctrl-C
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

fn beside_this_program() -> anyhow::Result<PathBuf> {
    let here = env::current_exe().context("the path of this program is not known")?;
    let program = here.with_file_name(format!("projector{}", env::consts::EXE_SUFFIX));
    if !program.exists() {
        bail!(
            "{} is missing; build both programs (cargo build --workspace), or start a projector yourself and \
             give --projector HOST:PORT",
            program.display()
        );
    }
    Ok(program)
}
