//! Sweeps the timing of simulated rigs and writes the table `tests/measured/tagging.md`.
//!
//! ```text
//! cargo run -p acquirer --example tagging -- [--rigs N] [--out FILE]
//! ```
//!
//! Every rig measures its timing by flashes, then records nineteen patterns. `--rigs` are the rigs of each cell of the
//! tables, fewer for a quick look.

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
    /// The table's file.
    #[arg(long)]
    out: Option<PathBuf>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut total = TaggingScore::default();
    let rates = by_rates(arguments.rigs, &mut total)?;
    let alone = one_by_one(arguments.rigs, &mut total)?;
    let page = format!(
        "# Which pattern does a frame show?\n\n\
         Written by `cargo run -p acquirer --example tagging`. Simulated rigs, reduced to bands of light with noise, \
         measure their timing by flashes and then record black, white, the coded grid and the unary grid in sixteen \
         colours, one frame each, again and again for what was not told. A frame is mislabelled when it was given a \
         pattern and more than a tenth of the light of some band is another one's. Frames are lost with the \
         probability told, and those that are not are given twice with the same probability.\n\n\
         **{} of {} frames that were given a pattern are mislabelled;** {} of {} patterns could not be told within \
         twelve passes; of {} rigs the timing of {} could not be measured. The latency is off by {:.1} ms on average.\n\n\
         ## Camera frames per change of the pattern, by rates and losses\n\n\
         Latency 0 to 300 ms, jitter 0 to 30 ms, read-out 0 to 30 ms (at most a frame), exposure 2 ms to half a frame, \
         by chance; lost passes and holds for jitter included, the latency left out.\n\n{rates}\n\
         ## One condition after the other\n\n\
         Projector 59.94 Hz, camera 29.97 Hz, latency 60 ms, jitter 2 ms, read-out 15 ms, exposure 8 ms, nothing \
         lost, but for the one that the row names.\n\n{alone}",
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

/// Scores rigs in parallel and adds them to the total.
fn score(
    rigs: u64,
    total: &mut TaggingScore,
    rig: impl Fn(u64) -> TaggingRig + Sync,
) -> TaggingScore {
    let scores: Vec<TaggingScore> = (0..rigs)
        .into_par_iter()
        .map(|seed| score_tagging(rig(seed), seed))
        .collect();
    let mut sum = TaggingScore::default();
    scores.iter().for_each(|score| sum.add(score));
    total.add(&sum);
    sum
}

fn by_rates(rigs: u64, total: &mut TaggingScore) -> Result<String> {
    let mut table = String::from(
        "| projector Hz | camera Hz | nothing lost | 10 % lost, 10 % twice | 20 % lost, 20 % twice | frames given a \
         pattern | mislabelled |\n|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for (p, projector_hz) in PROJECTORS_HZ.into_iter().enumerate() {
        for (c, camera_hz) in CAMERAS_HZ.into_iter().enumerate() {
            let mut row = TaggingScore::default();
            write!(table, "| {projector_hz} | {camera_hz} |")?;
            for (l, loss) in LOSSES.into_iter().enumerate() {
                let cell = 1000 * (100 * p + 10 * c + l) as u64;
                let score = score(rigs, total, |seed| {
                    TaggingRig::by_chance(projector_hz, camera_hz, loss, cell + seed)
                });
                write!(table, " {:.1} |", score.frames_per_change())?;
                row.add(&score);
            }
            writeln!(table, " {} | {} |", row.accepted, row.mislabelled)?;
            eprintln!("{projector_hz} Hz, {camera_hz} Hz: {row:?}");
        }
    }
    Ok(table)
}

fn one_by_one(rigs: u64, total: &mut TaggingScore) -> Result<String> {
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
    for latency_ms in [0.0, 150.0, 300.0] {
        rows.push((
            format!("latency {latency_ms} ms"),
            TaggingRig {
                latency_ms,
                ..usual
            },
        ));
    }
    for jitter_ms in [0.0, 10.0, 20.0, 30.0] {
        rows.push((
            format!("jitter {jitter_ms} ms"),
            TaggingRig { jitter_ms, ..usual },
        ));
    }
    for readout_ms in [0.0, 30.0] {
        rows.push((
            format!("read-out {readout_ms} ms"),
            TaggingRig {
                readout_ms,
                ..usual
            },
        ));
    }
    for loss in [0.05, 0.1, 0.2] {
        let what = format!("{:.0} % lost and given twice", 100.0 * loss);
        rows.push((what, TaggingRig { loss, ..usual }));
    }
    let mut table = String::from(
        "| condition | camera frames per change | frames given a pattern | mislabelled |\n|---|--:|--:|--:|\n",
    );
    for (what, rig) in rows {
        let score = score(rigs, total, |_| rig);
        writeln!(
            table,
            "| {what} | {:.1} | {} | {} |",
            score.frames_per_change(),
            score.accepted,
            score.mislabelled
        )?;
    }
    Ok(table)
}
