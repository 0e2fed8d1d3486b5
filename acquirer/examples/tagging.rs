//! Sweeps the timing of simulated rigs and writes the table `tests/measured/tagging.md`.
//!
//! ```text
//! cargo run -p acquirer --example tagging -- [--rigs N] [--seed N] [--out FILE]
//! ```
//!
//! Every rig measures its timing by flashes, then makes a recording and a trial of sixteen colours. `--rigs` are the
//! rigs of each cell of the tables, fewer for a quick look; `--seed` other rigs of the same kinds.

use std::{fmt::Write, fs, path::PathBuf};

use anyhow::Result;
use clap::Parser;
use rayon::prelude::*;
use rig_tests::measure::{TaggingRig, TaggingScore, in_repository, score_tagging};

const PROJECTORS_HZ: [f64; 5] = [50.0, 59.94, 60.0, 75.0, 120.0];
const CAMERAS_HZ: [f64; 5] = [15.0, 25.0, 29.97, 30.0, 60.0];
const LOSSES: [f64; 3] = [0.0, 0.1, 0.2];

/// Sweeps the timing of simulated rigs.
#[derive(Parser)]
struct Arguments {
    /// Rigs of each cell.
    #[arg(long, default_value_t = 16)]
    rigs: u64,
    /// Where the random numbers begin.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// The table's file.
    #[arg(long)]
    out: Option<PathBuf>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut sweep = Sweep {
        rigs: arguments.rigs,
        seed: arguments.seed,
        total: TaggingScore::default(),
    };
    let alone = sweep.one_by_one()?;
    let rates = sweep.by_rates()?;
    let total = sweep.total;
    let page = format!(
        "# Which pattern does a frame show?\n\n\
         Written by `cargo run -p acquirer --example tagging`. Simulated rigs, reduced to bands of light with noise, \
         measure their timing by flashes, then make a recording (black and white three times, coded and unary grid twice) \
         and a trial of colours (black and white twice, the unary grid in sixteen colours once), again and again for \
         what was not told. A frame is mislabelled when it was given a pattern and more than a tenth of the light of some \
         band is another one's. Frames are lost with the probability told, and those that are not are given twice with \
         the same probability.\n\n\
         **{} of {} frames that were given a pattern are mislabelled;** {} of {} patterns could not be told within \
         twelve passes; of {} rigs the timing of {} could not be measured. The latency is off by {:.1} ms on average.\n\n\
         The time per change of the pattern is counted in camera frames, from the first pattern's light to the last frame \
         needed: lost passes, holds for jitter and changes that only prepare are in, the latency and the further frames \
         of patterns that are taken several times are not.\n\n\
         ## One condition after the other\n\n\
         Projector 59.94 Hz, camera 29.97 Hz, latency 60 ms, jitter 2 ms, read-out 15 ms, exposure 8 ms, nothing \
         lost, but for the one that the row names. A sequence is begun so that changes fall between the frames that are \
         wanted, up to a refresh of the projector. A pattern is held for two frames while exposure, read-out, jitter and \
         that refresh together are known to be shorter than two, or the first three shorter than one, or while the \
         flashes spoilt one frame each; else for three or more, and what could not be told is shown again.\n\n{alone}\n\
         ## By rates and losses\n\n\
         Latency 0 to 300 ms, jitter 0 to 30 ms, read-out 0 to 30 ms (at most a frame), exposure 2 ms to half a frame, \
         by chance: in most of these rigs exposure, read-out and jitter together are longer than a frame, and no \
         two frames would show each pattern once all over.\n\n{rates}",
        total.mislabelled,
        total.accepted,
        total.untold,
        total.patterns,
        total.rigs,
        total.timeless,
        total.latency_error_ms / (total.rigs - total.timeless).max(1) as f64,
    );
    fs::write(
        arguments
            .out
            .unwrap_or_else(|| in_repository("tests/measured/tagging.md")),
        page,
    )?;
    Ok(())
}

/// A sweep and what it gave so far.
struct Sweep {
    rigs: u64,
    seed: u64,
    total: TaggingScore,
}

impl Sweep {
    /// Scores rigs in parallel and adds them to the total; gives what became of recordings, of trials, and of both.
    fn score(&mut self, rig: impl Fn(u64) -> TaggingRig + Sync) -> [TaggingScore; 3] {
        let seeds = (0..self.rigs).into_par_iter().map(|k| k + self.seed);
        let scores: Vec<[TaggingScore; 2]> =
            seeds.map(|seed| score_tagging(rig(seed), seed)).collect();
        let mut sums = [TaggingScore::default(); 3];
        for [recording, trial] in &scores {
            sums[0].add(recording);
            sums[1].add(trial);
        }
        let [recordings, trials, mut both] = sums;
        both.add(&recordings);
        both.add(&trials);
        self.total.add(&both);
        [recordings, trials, both]
    }

    fn by_rates(&mut self) -> Result<String> {
        let mut table = String::from(
            "| projector Hz | camera Hz | recording, nothing lost | colours, nothing lost | both, 10 % lost, 10 % twice | \
             both, 20 % lost, 20 % twice | frames given a pattern | mislabelled |\n\
             |--:|--:|--:|--:|--:|--:|--:|--:|\n",
        );
        for (p, projector_hz) in PROJECTORS_HZ.into_iter().enumerate() {
            for (c, camera_hz) in CAMERAS_HZ.into_iter().enumerate() {
                let mut row = TaggingScore::default();
                write!(table, "| {projector_hz} | {camera_hz} |")?;
                for (l, loss) in LOSSES.into_iter().enumerate() {
                    let cell = 1_000_003 * (100 * p + 10 * c + l) as u64;
                    let [recordings, trials, both] = self.score(|seed| {
                        TaggingRig::by_chance(projector_hz, camera_hz, loss, cell + seed)
                    });
                    if loss == 0.0 {
                        let per_change = recordings.frames_per_change();
                        write!(
                            table,
                            " {per_change:.1} | {:.1} |",
                            trials.frames_per_change()
                        )?;
                    } else {
                        write!(table, " {:.1} |", both.frames_per_change())?;
                    }
                    row.add(&both);
                }
                writeln!(table, " {} | {} |", row.accepted, row.mislabelled)?;
                eprintln!("{projector_hz} Hz, {camera_hz} Hz: {row:?}");
            }
        }
        Ok(table)
    }

    fn one_by_one(&mut self) -> Result<String> {
        let mut table = String::from(
            "| condition | recording | colours | frames given a pattern | mislabelled |\n|---|--:|--:|--:|--:|\n",
        );
        for (what, rig) in conditions() {
            let [recordings, trials, both] = self.score(|_| rig);
            writeln!(
                table,
                "| {what} | {:.1} | {:.1} | {} | {} |",
                recordings.frames_per_change(),
                trials.frames_per_change(),
                both.accepted,
                both.mislabelled
            )?;
        }
        Ok(table)
    }
}

/// A usual rig, and the same with one thing changed.
fn conditions() -> Vec<(String, TaggingRig)> {
    let usual = TaggingRig {
        projector_hz: 59.94,
        camera_hz: 29.97,
        latency_ms: 60.0,
        jitter_ms: 2.0,
        readout_ms: 15.0,
        exposure_ms: 8.0,
        loss: 0.0,
    };
    let mut rows = vec![("as told".to_owned(), usual)];
    let mut add = |what: String, change: &dyn Fn(&mut TaggingRig)| {
        let mut rig = usual;
        change(&mut rig);
        rows.push((what, rig));
    };
    for ms in [0.0, 150.0, 300.0] {
        add(format!("latency {ms} ms"), &|rig| rig.latency_ms = ms);
    }
    for ms in [0.0, 5.0, 10.0, 20.0, 30.0] {
        add(format!("jitter {ms} ms"), &|rig| rig.jitter_ms = ms);
    }
    for ms in [0.0, 30.0] {
        add(format!("read-out {ms} ms"), &|rig| rig.readout_ms = ms);
    }
    for ms in [2.0, 16.0] {
        add(format!("exposure {ms} ms"), &|rig| rig.exposure_ms = ms);
    }
    for hz in [50.0, 60.0] {
        add(format!("projector {hz} Hz"), &|rig| rig.projector_hz = hz);
    }
    for loss in [0.05, 0.1, 0.2] {
        let what = format!("{:.0} % lost and given twice", 100.0 * loss);
        add(what, &|rig| rig.loss = loss);
    }
    rows
}
