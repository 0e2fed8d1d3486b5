//! A long run of both programs in simulation at full rate: is what they take of the machine steady, do the clocks stay
//! related, is every pattern shown and told?

use std::{
    fmt,
    path::Path,
    time::{Duration, Instant},
};

use acquirer::{
    camera::{CameraSpec, Losses, open_camera},
    config::Config,
    projector_link::{LinkSettings, ProjectorLink},
    scan::ScanFolder,
    session::{Cancel, NewScan, Rig, SessionError, measure_latency, record_stage},
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
    /// Files in the scan folder.
    pub files: usize,
    /// What was done since the sample before.
    pub done: Done,
}

/// What was done between two samples.
#[derive(Debug, Clone, Copy, Default)]
pub struct Done {
    /// Stages that were recorded.
    pub stages: u64,
    /// Pictures that the projector showed.
    pub pictures: u64,
    /// Frames that the camera gave.
    pub frames: u64,
    /// Mean time of a stage.
    pub mean: Duration,
    /// Longest time of a stage.
    pub longest: Duration,
}

/// What a run found.
#[derive(Debug, Clone, Default)]
pub struct Endurance {
    /// How long it was.
    pub time: Duration,
    /// Stages that were recorded: every pattern shown, told from the frames, and written to the disk.
    pub stages: u64,
    /// Patterns of a stage, each shown once unless a frame of it was in doubt.
    pub patterns: u64,
    /// Stages that could not be recorded, with the reasons.
    pub missed: Vec<String>,
    /// Pictures that the projector showed.
    pub pictures: u64,
    /// Frames that the camera gave.
    pub frames: u64,
    /// Frames that were lost on their way.
    pub losses: Losses,
    /// Change of the relation of the two clocks.
    pub clock_drift: Duration,
    /// Usage, first when the programs have warmed up.
    pub samples: Vec<Sample>,
}

/// Recording before the first sample: buffers, caches and the allocator's arenas have their sizes by then.
const WARM_UP: Duration = Duration::from_secs(15);

/// Records a simulated room over and over for some time, into one folder, after a warm-up.
///
/// # Errors
/// A rig that can't be opened.
pub fn run(time: Duration, every: Duration) -> anyhow::Result<Endurance> {
    let dir = tempfile::tempdir()?;
    let projector = ProjectorProgram::headless()?;
    let mut run = Run::begin(&projector, &dir.path().join("scan"))?;
    let warming = Instant::now();
    let mut patterns = run.record()?;
    while warming.elapsed() < WARM_UP {
        patterns = run.record()?;
    }

    let begun = Instant::now();
    let first_clock = run.rig.projector.clock_offset(16)?;
    let mut found = Endurance {
        patterns,
        ..Endurance::default()
    };
    run.counted = run.counters()?;
    found.samples.push(run.sample(begun, &[])?);
    while begun.elapsed() < time {
        let due = begun.elapsed() + every;
        let mut times = Vec::new();
        while begun.elapsed() < due.min(time) {
            let stage_begun = Instant::now();
            match run.record() {
                Ok(_) => times.push(stage_begun.elapsed()),
                Err(error) => found.missed.push(error.to_string()),
            }
        }
        found.samples.push(run.sample(begun, &times)?);
    }
    found.time = begun.elapsed();
    let total = |figure: fn(&Done) -> u64| found.samples.iter().map(|s| figure(&s.done)).sum();
    found.stages = total(|done| done.stages);
    found.pictures = total(|done| done.pictures);
    found.frames = total(|done| done.frames);
    found.losses = run.rig.camera.losses();
    let drift_ns = run
        .rig
        .projector
        .clock_offset(16)?
        .offset_ns
        .abs_diff(first_clock.offset_ns);
    found.clock_drift = Duration::from_nanos(drift_ns);
    Ok(found)
}

/// A rig that records.
struct Run<'a> {
    projector: &'a ProjectorProgram,
    rig: Rig,
    folder: ScanFolder,
    config: Config,
    /// Pictures shown and frames given up to the last sample.
    counted: [u64; 2],
}

impl<'a> Run<'a> {
    fn begin(projector: &'a ProjectorProgram, dir: &Path) -> anyhow::Result<Self> {
        let config = Config::default();
        let settings = LinkSettings::new(projector.address(), "endurance", Role::Controller);
        let link = ProjectorLink::connect(&settings)?;
        let spec = CameraSpec::Simulated("cube".to_owned());
        let camera = open_camera(&spec, &config.camera, Some(projector.address()))?;
        let mut rig = Rig::new(link, camera);
        measure_latency(&mut rig, &config.latency, &Cancel::default(), &mut |_| {})?;
        let scan = NewScan {
            dir,
            config: &config,
            selection: None,
            calibration: None,
        };
        let folder = scan.begin(&rig)?;
        Ok(Self {
            projector,
            rig,
            folder,
            config,
            counted: [0; 2],
        })
    }

    /// Records the stage anew; gives how many patterns it has.
    fn record(&mut self) -> Result<u64, SessionError> {
        let mut patterns = 0;
        record_stage(
            &mut self.rig,
            &mut self.folder,
            Stage::Background,
            &self.config.record,
            &Cancel::default(),
            &mut |progress| patterns = progress.of as u64,
        )?;
        Ok(patterns)
    }

    fn counters(&mut self) -> anyhow::Result<[u64; 2]> {
        let frame = self.rig.next_frame(Duration::from_secs(5))?;
        Ok([self.rig.projector.state()?.shown.serial, frame.number])
    }

    /// What the programs take now, and what they did since the last sample.
    fn sample(&mut self, begun: Instant, times: &[Duration]) -> anyhow::Result<Sample> {
        let counted = self.counters()?;
        let [pictures, frames] = [0, 1].map(|of| counted[of] - self.counted[of]);
        self.counted = counted;
        let stages = times.len() as u64;
        let mean = times.iter().sum::<Duration>().as_secs_f64() / stages.max(1) as f64;
        Ok(Sample {
            at: begun.elapsed(),
            projector: self.projector.usage()?,
            acquirer: Usage::of(std::process::id())?,
            files: files(self.folder.dir())?,
            done: Done {
                stages,
                pictures,
                frames,
                mean: Duration::from_secs_f64(mean),
                longest: times.iter().copied().max().unwrap_or_default(),
            },
        })
    }
}

/// How many files stand in a folder and those in it.
fn files(dir: &Path) -> std::io::Result<usize> {
    let mut count = 0;
    for entry in std::fs::read_dir(dir)? {
        let path = entry?.path();
        count += if path.is_dir() { files(&path)? } else { 1 };
    }
    Ok(count)
}

impl Endurance {
    /// Growth of a figure from the first half of the samples to the second: of the lowest ones, since what is at work
    /// while a sample is taken comes and goes.
    #[must_use]
    pub fn growth(&self, figure: impl Fn(&Sample) -> u64) -> i64 {
        let lowest = |samples: &[Sample]| samples.iter().map(&figure).min();
        let (first, second) = self.samples.split_at(self.samples.len() / 2);
        match (lowest(first), lowest(second)) {
            (Some(first), Some(second)) => second.cast_signed() - first.cast_signed(),
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
             - stages recorded: {}, each of {} patterns; missed: {}\n\
             - pictures shown: {}, {} besides one for each pattern (a lead before one that is up already; once more where no \
             frame was sure)\n- frames of the camera: {}, lost: {}, nobody asked (while files are written): {}\n\
             - drift of the clocks' relation: {:.3} ms\n",
            self.time.as_secs_f64() / 60.0,
            self.stages,
            self.patterns,
            self.missed.len(),
            self.pictures,
            self.pictures.saturating_sub(self.patterns * self.stages),
            self.frames,
            self.losses.by_driver + self.losses.damaged,
            self.losses.overtaken,
            1000.0 * self.clock_drift.as_secs_f64(),
        )?;
        for missed in &self.missed {
            writeln!(f, "- missed: {missed}")?;
        }
        writeln!(
            f,
            "| minute | stages | pictures | frames | s a stage: mean | longest | projector MiB | threads | descriptors | acquirer MiB | threads \
             | descriptors | files |\n|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
        )?;
        for sample in &self.samples {
            let done = sample.done;
            write!(
                f,
                "| {:.1} | {} | {} | {} | {:.2} | {:.2} |",
                sample.at.as_secs_f64() / 60.0,
                done.stages,
                done.pictures,
                done.frames,
                done.mean.as_secs_f64(),
                done.longest.as_secs_f64(),
            )?;
            for usage in [sample.projector, sample.acquirer] {
                write!(
                    f,
                    " {:.1} | {} | {} |",
                    usage.memory_kib as f64 / 1024.0,
                    usage.threads,
                    usage.descriptors
                )?;
            }
            writeln!(f, " {} |", sample.files)?;
        }
        Ok(())
    }
}
