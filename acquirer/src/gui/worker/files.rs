//! The thread that reads, processes and copies files, so that neither the rig's thread nor the window's waits for
//! them.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::{Arc, mpsc::Receiver},
};

use anyhow::{Context, anyhow, bail};

use super::Teller;
use crate::{
    config::Config,
    gui::{
        events::{Event, FileJob, Who},
        open_scan::{OpenScan, StageView},
        sources::Sources,
    },
    process::ProcessError,
    scan::{ScanError, copy_scan},
    session::{Cancel, Progress},
};

/// Everything the thread needs.
pub(in crate::gui) struct FileWorker {
    pub(in crate::gui) config: Config,
    /// Folder that scans are recorded as.
    pub(in crate::gui) out: PathBuf,
    pub(in crate::gui) cancel: Cancel,
    pub(in crate::gui) jobs: Receiver<FileJob>,
    pub(in crate::gui) teller: Teller,
}

impl FileWorker {
    /// Runs until the window is gone.
    pub(in crate::gui) fn run(self) {
        while let Ok(job) = self.jobs.recv() {
            self.cancel.reset();
            match self.job(job) {
                Ok(event) => self.teller.tell(event),
                Err(error) if is_cancelled(&error) => {
                    self.teller.tell(Event::Note(format!("{error:#}")));
                }
                Err(error) => self.teller.tell(Event::Failed(format!("{error:#}"))),
            }
            self.teller.tell(Event::Idle(Who::Files));
        }
    }

    fn job(&self, job: FileJob) -> anyhow::Result<Event> {
        Ok(match job {
            FileJob::FindSources => Event::Sources(Box::new(Sources::find(&self.out))),
            FileJob::ReadStage(dir, stage) => {
                let view = StageView::read(
                    (&dir, stage),
                    &self.config.pipeline,
                    &self.cancel,
                    &mut |progress| self.progress(progress),
                )?;
                Event::StageRead(dir, Arc::new(view))
            }
            FileJob::Read(dir, place) => {
                let mut report = |progress| self.progress(progress);
                let scan = OpenScan::read(&dir, &self.config, &self.cancel, &mut report)?;
                Event::Read(Box::new(scan), place)
            }
            FileJob::Save { from, to } => {
                self.begin(format!("saving {}", to.display()));
                save_as(&from, &to)?;
                Event::Note(format!("saved as {}", to.display()))
            }
            FileJob::OpenOutside(path) => {
                open_outside(&path)?;
                Event::Note(format!("opened {}", path.display()))
            }
        })
    }

    fn begin(&self, what: String) {
        self.progress(Progress {
            what,
            done: 0,
            of: 0,
        });
    }

    fn progress(&self, progress: Progress) {
        self.teller.tell(Event::Progress(Who::Files, progress));
    }
}

fn is_cancelled(error: &anyhow::Error) -> bool {
    let cause = error.downcast_ref::<ProcessError>();
    matches!(cause, Some(ProcessError::Cancelled))
}

/// Saves a scan under another name.
fn save_as(from: &Path, to: &Path) -> anyhow::Result<()> {
    copy_scan(from, to).map_err(|error| match error {
        ScanError::Exists(_) => anyhow!(
            "{}: there is a scan already; choose another name",
            to.display()
        ),
        other => anyhow!(other).context(format!(
            "the scan can't be saved as {}: choose a folder that can be written",
            to.display()
        )),
    })
}

/// Asks the desktop to show a file or folder; its program outlives this one.
fn open_outside(path: &Path) -> anyhow::Result<()> {
    let shown = fs::canonicalize(path).with_context(|| format!("{}", path.display()))?;
    let mut child = Command::new("xdg-open")
        .arg(&shown)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .with_context(|| {
            format!(
                "this desktop has no xdg-open to show {}: open it by hand",
                shown.display()
            )
        })?;
    if let Some(status) = child.try_wait()?
        && !status.success()
    {
        bail!(
            "the desktop can't show {}: open it by hand",
            shown.display()
        );
    }
    Ok(())
}
