//! A long run of both programs in simulation at full rate: is what they take of the machine steady, do the clocks stay
//! related, is every pattern shown and told?

use std::{
    fmt,
    path::Path,
    time::{Duration, Instant},
};

use acquirer::{
    camera::{CameraSpec, open_camera},
    config::Config,
    projector_link::{LinkSettings, ProjectorLink},
    session::{Cancel, NewScan, Rig, measure_latency, record_stage},
};
use shared::{protocol::Role, stage::Stage};

use crate::{ProjectorProgram, Usage};

/// What the programs took of the machine at a time.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Since the beginning.
    pub at: Duration,
    /// The projector program.
    pub projector: Usage,
    /// The acquirer's side: this process.
    pub acquirer: Usage,
}

/// What a run found.
#[derive(Debug, Clone, Default)]
pub struct Endurance {
    /// How long it was.
    pub time: Duration,
    /// Stages that were recorded, each of four patterns shown, told from the frames, and written to the disk.
    pub stages: u64,
    /// Stages that could not be recorded, with the reasons.
    pub missed: Vec<String>,
    /// Pictures that the projector showed.
    pub pictures: u64,
    /// Frames that the camera gave.
    pub frames: u64,
    /// Change of the relation of the two clocks.
    pub clock_drift: Duration,
    /// Usage, first after everything had been used once.
    pub samples: Vec<Sample>,
}

/// Records a simulated room over and over for some time, into one folder.
///
/// # Errors
/// A rig that can't be opened.
pub fn run(time: Duration, every: Duration) -> anyhow::Result<Endurance> {
    let dir = tempfile::tempdir()?;
    let projector = ProjectorProgram::headless()?;
    let config = Config::default();
    let settings = LinkSettings::new(projector.address(), "endurance", Role::Controller);
    let link = ProjectorLink::connect(&settings)?;
    let spec = CameraSpec::Simulated("cube".to_owned());
    let camera = open_camera(&spec, &config.camera, Some(projector.address()))?;
    let mut rig = Rig::new(link, camera);
    let cancel = Cancel::default();
    measure_latency(&mut rig, &config.latency, &cancel, &mut |_| {})?;
    let scan = NewScan {
        dir: &dir.path().join("scan"),
        config: &config,
        selection: None,
        calibration: None,
    };
    let mut folder = scan.begin(&rig)?;
    record_stage(
        &mut rig,
        &mut folder,
        Stage::Background,
        &config.record,
        &cancel,
        &mut |_| {},
    )?;

    let (begun, mut found) = (Instant::now(), Endurance::default());
    let first = rig.projector.clock_offset(16)?;
    let first_serial = rig.projector.state()?.shown.serial;
    let first_frame = rig.next_frame(Duration::from_secs(5))?.number;
    let mut due = Duration::ZERO;
    while begun.elapsed() < time {
        if begun.elapsed() >= due {
            due += every;
            found.samples.push(Sample {
                at: begun.elapsed(),
                projector: projector.usage()?,
                acquirer: Usage::of(std::process::id())?,
            });
        }
        let recorded = record_stage(
            &mut rig,
            &mut folder,
            Stage::Background,
            &config.record,
            &cancel,
            &mut |_| {},
        );
        match recorded {
            Ok(()) => found.stages += 1,
            Err(error) => found.missed.push(error.to_string()),
        }
    }
    found.samples.push(Sample {
        at: begun.elapsed(),
        projector: projector.usage()?,
        acquirer: Usage::of(std::process::id())?,
    });
    found.time = begun.elapsed();
    found.pictures = rig.projector.state()?.shown.serial - first_serial;
    found.frames = rig.next_frame(Duration::from_secs(5))?.number - first_frame;
    let last = rig.projector.clock_offset(16)?;
    let drift_ns = last.offset_ns.abs_diff(first.offset_ns);
    found.clock_drift = Duration::from_nanos(drift_ns);
    Ok(found)
}

impl Endurance {
    /// Growth of a figure from the first to the last sample.
    #[must_use]
    pub fn growth(&self, figure: impl Fn(&Sample) -> u64) -> i64 {
        match (self.samples.first(), self.samples.last()) {
            (Some(first), Some(last)) => figure(last).cast_signed() - figure(first).cast_signed(),
            _ => 0,
        }
    }

    /// Writes the page with the figures.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        std::fs::write(path, self.to_string())
    }
}

impl fmt::Display for Endurance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "A room in simulation, recorded over and over at full rate by `./rig endure`: {:.0} minutes.\n\n\
             - stages recorded: {}, missed: {}\n- pictures shown: {}, frames taken: {}\n\
             - drift of the clocks' relation: {:.3} ms\n",
            self.time.as_secs_f64() / 60.0,
            self.stages,
            self.missed.len(),
            self.pictures,
            self.frames,
            1000.0 * self.clock_drift.as_secs_f64(),
        )?;
        for missed in &self.missed {
            writeln!(f, "- missed: {missed}")?;
        }
        writeln!(
            f,
            "| minute | projector MiB | threads | descriptors | acquirer MiB | threads | descriptors |\n\
             |--:|--:|--:|--:|--:|--:|--:|"
        )?;
        for sample in &self.samples {
            write!(f, "| {:.1} |", sample.at.as_secs_f64() / 60.0)?;
            for usage in [sample.projector, sample.acquirer] {
                write!(
                    f,
                    " {:.1} | {} | {} |",
                    usage.memory_kib as f64 / 1024.0,
                    usage.threads,
                    usage.descriptors
                )?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
