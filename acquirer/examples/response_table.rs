//! What a measured camera response does for the reading: `tests/measured/response.md`.
//!
//! ```text
//! cargo run -p acquirer --example response_table -- [--print]
//! ```
//!
//! Takes the shipped rooms with cameras of other curves than sRGB, records black, white, grids and solid colours, and
//! reads both stages without a calibration twice: with the sRGB table and with the measured curve. The colour error is
//! that of single pixels of the four grid colours shown all over: light over white, both above black, nearest to the
//! mean of which colour. Light that adds up gives one mean on all surfaces.

use std::{fmt::Write, fs};

use acquirer::{
    pipeline::{
        Captures, PipelineSettings, Projected, read_stage,
        response::{Response, ResponseSettings, SolidCaptures, measure_response, ramp_colours},
    },
    score::{StageScore, score_stage},
};
use anyhow::Result;
use image::RgbImage;
use rig_tests::measure::{Condition, Repeats, SimulatedScan, in_repository};
use shared::{
    pattern::{GridSettings, Pattern, Rgb},
    simulation::{Room, Scene, TruthVertex},
    stage::Stage,
};

const SCENES: [&str; 4] = ["coloured-room", "cube", "dark-cloth", "two-boxes"];
/// Curves as in a scene file, and their names.
const CURVES: [(&str, &str); 5] = [
    ("sRGB", "\"srgb\""),
    ("none", "\"linear\""),
    ("power 1.8", "{ power = 1.8 }"),
    ("power 3", "{ power = 3.0 }"),
    ("contrast 0.6", "{ contrast = 0.6 }"),
];

fn main() -> Result<()> {
    let mut table = String::from(
        "# A measured camera response\n\n\
         Written by `cargo run -p acquirer --example response_table`. Rooms whose camera has another tone curve, read \
         with the sRGB table and with the curve measured from eleven solid colours a stage; both stages together, no \
         calibration. Residual: by how many byte values the solid colours miss adding up. Colour error: share of single \
         pixels nearest to another grid colour's mean response. Bias: mean outward displacement of the vertices.\n\n\
         | scene | camera's curve | sRGB: residual | colour error % | coverage % | wrong | RMS px | bias px | \
         measured: residual | colour error % | coverage % | wrong | RMS px | bias px |\n\
         |---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for name in SCENES {
        for (curve, value) in CURVES {
            eprintln!("{name}, {curve}");
            let room = Recorded::new(name, value)?;
            let measured = measure_response(&room.solids)?;
            let assumed = room.cells(ResponseSettings::default())?;
            let found = room.cells(ResponseSettings {
                curve: Some(measured.curve),
                ..ResponseSettings::default()
            })?;
            let kept = if measured.is_srgb { " (sRGB kept)" } else { "" };
            let [srgb, own] = [measured.srgb_residual_levels, measured.residual_levels];
            writeln!(
                table,
                "| {name} | {curve} | {srgb:.2} | {assumed} | {own:.2}{kept} | {found} |"
            )?;
        }
    }
    if std::env::args().any(|argument| argument == "--print") {
        print!("{table}");
    } else {
        fs::write(in_repository("tests/measured/response.md"), table)?;
    }
    Ok(())
}

/// A room with everything that was seen in it.
struct Recorded {
    projected: Projected,
    stages: [Captures; 2],
    truth: Vec<TruthVertex>,
    solids: [SolidCaptures; 2],
    /// For each stage black, white, and the grid's colours all over.
    shown: Vec<(RgbImage, RgbImage, Vec<RgbImage>)>,
}

impl Recorded {
    fn new(name: &str, curve: &str) -> Result<Self> {
        let text = format!("name = \"\"\n[set]\n\"camera.tone_curve\" = {curve}");
        let condition: Condition = toml::from_str(&text)?;
        let scene = condition.scene(name, &toml::Table::new())?;
        let pattern = GridSettings::default();
        let scan = SimulatedScan::record(&scene, &pattern, Repeats::default());
        let mut shown = Vec::new();
        let solids = Stage::BOTH.map(|stage| {
            let room = Room::new(&scene, stage);
            let mut solids = SolidCaptures::default();
            for colour in [Rgb::BLACK, Rgb::WHITE].into_iter().chain(ramp_colours()) {
                solids.add(colour, &shoot(&scene, &room, colour));
            }
            let grid_colours = pattern.coded.colours().iter();
            shown.push((
                shoot(&scene, &room, Rgb::BLACK),
                shoot(&scene, &room, Rgb::WHITE),
                grid_colours
                    .map(|&colour| shoot(&scene, &room, colour))
                    .collect(),
            ));
            solids
        });
        Ok(Self {
            projected: scan.projected,
            stages: scan.stages,
            truth: scan.truth,
            solids,
            shown,
        })
    }

    /// Colour error, coverage, wrong labels, RMS and bias with a response.
    fn cells(&self, response: ResponseSettings) -> Result<String> {
        let settings = PipelineSettings {
            response,
            pictures: false,
            ..PipelineSettings::default()
        };
        let mut scores = Vec::new();
        for (stage, captures) in Stage::BOTH.into_iter().zip(&self.stages) {
            let reading = read_stage(captures, &self.projected, None, &settings)?;
            let read: Vec<_> = reading.grid.vertices().collect();
            scores.push(score_stage(&self.truth, &read, stage));
        }
        let mean = |f: &dyn Fn(&StageScore) -> f64| {
            scores.iter().map(f).sum::<f64>() / scores.len() as f64
        };
        let wrong: usize = scores.iter().map(|score| score.wrong).sum();
        let squares = mean(&|score| score.rms_px.unwrap_or(f64::NAN).powi(2));
        Ok(format!(
            "{:.2} | {:.1} | {wrong} | {:.3} | {:+.3}",
            100.0 * self.colour_error(&Response::new(&response)),
            mean(&|score| score.coverage_percent),
            squares.sqrt(),
            mean(&|score| score.bias_px.unwrap_or(f64::NAN)),
        ))
    }

    /// Share of pixels whose response is nearest to the mean of another colour.
    fn colour_error(&self, response: &Response) -> f64 {
        let mut pixels: Vec<(usize, [f64; 3])> = Vec::new();
        for (black, white, colours) in &self.shown {
            for (class, picture) in colours.iter().enumerate() {
                let triples = black.pixels().zip(white.pixels()).zip(picture.pixels());
                pixels.extend(triples.filter_map(|((k, w), p)| {
                    Some((class, over_white(response, [k.0, w.0, p.0])?))
                }));
            }
        }
        let classes = self.projected.pattern.coded.colours().len();
        let means: Vec<[f64; 3]> = (0..classes)
            .map(|class| {
                let own = pixels.iter().filter(|(of, _)| *of == class);
                let count = own.clone().count().max(1) as f64;
                std::array::from_fn(|c| own.clone().map(|(_, r)| r[c]).sum::<f64>() / count)
            })
            .collect();
        let nearest = |response: &[f64; 3]| {
            let distance =
                |mean: &[f64; 3]| -> f64 { (0..3).map(|c| (mean[c] - response[c]).powi(2)).sum() };
            (0..classes).min_by(|&a, &b| distance(&means[a]).total_cmp(&distance(&means[b])))
        };
        let wrong = pixels
            .iter()
            .filter(|(class, r)| nearest(r) != Some(*class))
            .count();
        wrong as f64 / pixels.len().max(1) as f64
    }
}

fn shoot(scene: &Scene, room: &Room, colour: Rgb) -> RgbImage {
    let picture = (Pattern::Solid { colour }).raster(scene.projector_size());
    let [red, green, blue] = colour.0.map(u64::from);
    // every colour has noise of its own
    room.render(
        &scene.project(&picture),
        1000 + (red << 16 | green << 8 | blue),
    )
}

/// Light of a colour over that of white, both above black; `None` where white is too weak or clipped to tell.
fn over_white(response: &Response, [black, white, colour]: [[u8; 3]; 3]) -> Option<[f64; 3]> {
    const CLIPPED: u8 = 250;
    const LEAST: u8 = 20; // byte values of white above black
    let tells = (0..3).all(|c| white[c] < CLIPPED && white[c] >= black[c].saturating_add(LEAST));
    tells.then(|| {
        std::array::from_fn(|c| {
            let [k, w, p] =
                [black[c], white[c], colour[c]].map(|byte| f64::from(response.linear(byte)));
            (p - k) / (w - k).max(1e-6)
        })
    })
}
