//! Reads scans whose truth is known and adds up the scores.

use std::time::Duration;

use acquirer::{
    pipeline::{Captures, Method, PipelineSettings, Projected, read_stage},
    score::{ReadVertex, StageScore, score_stage},
};
use nix::time::{ClockId, clock_gettime};
use shared::{geometry::RigCalibration, simulation::TruthVertex, stage::Stage};

/// What a stage is read with.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    /// What the projector showed.
    pub projected: &'a Projected,
    /// For the epipolar check of the labels, if at all.
    pub calibration: Option<&'a RigCalibration>,
    /// The method.
    pub method: Method,
}

impl Reading<'_> {
    /// Reads the captures of one stage and compares with the truth. Gives the CPU time of the reading, all threads
    /// together, as well.
    ///
    /// # Errors
    /// Captures that can't be read at all.
    pub fn score(
        &self,
        captures: &Captures,
        truth: &[TruthVertex],
        stage: Stage,
    ) -> anyhow::Result<(StageScore, Duration)> {
        let settings = PipelineSettings {
            method: self.method,
            pictures: false,
            ..PipelineSettings::default()
        };
        let before = cpu_time()?;
        let reading = read_stage(captures, self.projected, self.calibration, &settings)?;
        let took = cpu_time()?.saturating_sub(before);
        let read: Vec<ReadVertex> = reading.grid.vertices().collect();
        Ok((score_stage(truth, &read, stage), took))
    }
}

/// CPU time that this process has used.
///
/// # Errors
/// A system without this clock.
pub fn cpu_time() -> anyhow::Result<Duration> {
    Ok(clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID)?.into())
}

/// Scores added up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sum {
    /// Crossings seen clear.
    pub clear: usize,
    /// Vertices reported.
    pub reported: usize,
    /// Vertices with a wrong label.
    pub wrong: usize,
    /// Vertices of clear crossings read right.
    right: f64,
    /// Sum of their squared errors, square px.
    squares: f64,
}

impl Sum {
    /// Adds one stage's score.
    pub fn add(&mut self, score: &StageScore) {
        let vertices = 4.0 * score.clear_crossings as f64;
        let right = score.coverage_percent / 100.0 * vertices;
        self.clear += score.clear_crossings;
        self.reported += score.reported;
        self.wrong += score.wrong;
        self.right += right;
        self.squares += right * score.rms_px.unwrap_or(0.0).powi(2);
    }

    /// Adds another sum.
    pub fn join(&mut self, other: &Self) {
        self.clear += other.clear;
        self.reported += other.reported;
        self.wrong += other.wrong;
        self.right += other.right;
        self.squares += other.squares;
    }

    /// Share of the clear crossings' vertices read right, in percent.
    #[must_use]
    pub fn coverage_percent(&self) -> f64 {
        100.0 * self.right / (4.0 * self.clear as f64).max(1.0)
    }

    /// Share of the reported vertices whose label is wrong, in percent.
    #[must_use]
    pub fn wrong_percent(&self) -> f64 {
        100.0 * self.wrong as f64 / (self.reported as f64).max(1.0)
    }

    /// Distance of the right vertices from the truth, root mean square, px; `None` without any.
    #[must_use]
    pub fn rms_px(&self) -> Option<f64> {
        (self.right > 0.5).then(|| (self.squares / self.right).sqrt())
    }

    /// Five cells of a Markdown table: clear, coverage, wrong, wrong %, RMS.
    #[must_use]
    pub fn cells(&self) -> String {
        let rms = self.rms_px().map_or("-".into(), |rms| format!("{rms:.3}"));
        format!(
            "{} | {:.1} | {} | {:.3} | {rms}",
            self.clear,
            self.coverage_percent(),
            self.wrong,
            self.wrong_percent(),
        )
    }
}
