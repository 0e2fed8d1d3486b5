//! Examines a rig before it is used: is everything such that grids can be read, and if not, what is to be done?
//!
//! Takes a rig, shows pictures and looks at their frames, gives a [`Diagnosis`]: one [`Finding`] per question, each
//! with what was measured, whether that is good, and what to do if not. One file per finding, named as the finding is;
//! they are asked in the order of this list. A question that cannot be answered because of an earlier finding is not
//! checked, so that one fault gives one finding.
//!
//! - `network`: round trips to the projector and the relation of the clocks.
//! - `screen`: the camera sees what the projector program shows.
//! - `automatics`: the same light gives the same picture.
//! - `frames`: as many frames come as the camera says.
//! - `latency`: from the projector's word to its light, and how much that varies.
//! - `exposure`: white is neither clipped nor dark.
//! - `mains_flicker`, `colour_wheel`: the light is steady from frame to frame (`modulation`).
//! - `pixels`: projector pixels are shown one to one.
//! - `focus`: edges are narrower than lines.
//!
//! # Conventions
//! Light is linear, 1 is the camera's full white. Positions and lengths in the camera's picture are camera px.

mod finding;
mod settings;

mod bench;
mod light;
mod modulation;
mod patterns;

mod network;

mod screen;

mod automatics;

mod frames;

mod latency;

mod exposure;

mod mains_flicker;

mod colour_wheel;

mod pixels;

mod focus;

pub use finding::{Diagnosis, Finding, Measured, State};
pub use settings::DoctorSettings;

use bench::Bench;
use light::{Light, Lit};

use shared::{pattern::Axis, protocol::View};

use super::{Cancel, LatencySettings, Report, Rig, SessionError};
use crate::pipeline::response::ResponseSettings;

/// Steady pictures that several questions are answered from.
struct Pictures {
    black: Light,
    white: Light,
    /// White bars that tell y and x.
    bars: [(Axis, Light); 2],
    lit: Lit,
}

impl Pictures {
    fn take(bench: &mut Bench) -> Result<Self, SessionError> {
        let raster = bench.rig.projector.state()?.screen.raster;
        let black = bench.light("black", View::Black, STEADY_FRAMES)?;
        let white = bench.light("white", View::White, STEADY_FRAMES)?;
        let mut bars = |axis| -> Result<(Axis, Light), SessionError> {
            let view = patterns::bars(axis, raster)?;
            Ok((axis, bench.light("bars", view, PICTURE_FRAMES)?))
        };
        Ok(Self {
            bars: [bars(Axis::Row)?, bars(Axis::Column)?],
            lit: Lit::new(&black, &white),
            black,
            white,
        })
    }

    /// Takes some more of black and white: a flicker that nearly keeps step with the camera shows after seconds only.
    fn look_again(&mut self, bench: &mut Bench) -> Result<(), SessionError> {
        bench.add_light(&mut self.black, "black again", View::Black, PICTURE_FRAMES)?;
        bench.add_light(&mut self.white, "white again", View::White, PICTURE_FRAMES)?;
        self.lit = Lit::new(&self.black, &self.white);
        Ok(())
    }
}

/// What is examined with which limits.
#[derive(Debug, Clone, Copy)]
pub struct Examination<'a> {
    /// The limits.
    pub limits: &'a DoctorSettings,
    /// How the latency is measured.
    pub latency: &'a LatencySettings,
    /// How camera bytes become light.
    pub response: &'a ResponseSettings,
}

/// Frames of black and of white in which the light's steadiness is judged: over half a second at 30 frames per second.
const STEADY_FRAMES: usize = 24;
/// Frames of each other picture, averaged.
const PICTURE_FRAMES: usize = 6;

/// Examines a rig; what the projector showed before is shown again afterwards, whatever comes of it.
///
/// # Errors
/// A projector that does not answer, a camera that is silent, or [`SessionError::Cancelled`].
pub fn examine(
    rig: &mut Rig,
    examination: &Examination,
    cancel: &Cancel,
    report: Report,
) -> Result<Diagnosis, SessionError> {
    let before = rig.projector.state()?;
    let mut bench = Bench::new(rig, examination, cancel, report);
    let outcome = run(&mut bench);
    if outcome.is_ok() {
        bench.finish();
    }
    let shown_again = rig.projector.show(before.view).and_then(|shown| {
        if before.blank {
            rig.projector.blank(true)
        } else {
            Ok(shown)
        }
    });
    if let Err(error) = shown_again {
        tracing::warn!("the projector does not show again what it showed before: {error}");
    }
    let findings = outcome?;
    Ok(Diagnosis::new(rig, findings))
}

/// Asks question after question.
fn run(bench: &mut Bench) -> Result<Vec<Finding>, SessionError> {
    let mut findings = vec![network::examine(bench)?];
    let step = bench.step()?;
    let screen = screen::examine(bench, &step)?;
    let seen = screen.is_good();
    findings.push(screen);
    if !seen {
        let asked = ["automatics", "frames", "latency", "exposure"];
        let light = ["mains_flicker", "colour_wheel", "pixels", "focus"];
        let reason = "the camera does not see the projector's picture";
        findings.extend(asked.into_iter().chain(light).map(|name| {
            if name == "frames" {
                frames::examine(bench)
            } else {
                Finding::not_checked(name, reason)
            }
        }));
        return Ok(findings);
    }
    let mut pictures = Pictures::take(bench)?;
    let automatics = automatics::examine(bench, &step, &pictures);
    let steady = automatics.is_good();
    findings.push(automatics);
    findings.push(frames::examine(bench));
    if !steady {
        let reason = "the camera changes its picture by itself";
        let light = [
            "latency",
            "exposure",
            "mains_flicker",
            "colour_wheel",
            "pixels",
            "focus",
        ];
        findings.extend(light.map(|name| Finding::not_checked(name, reason)));
        return Ok(findings);
    }
    findings.push(latency::examine(bench)?);
    pictures.look_again(bench)?;
    examine_light(bench, &pictures, &mut findings)?;
    Ok(findings)
}

/// The questions that frames of steady pictures answer.
fn examine_light(
    bench: &mut Bench,
    pictures: &Pictures,
    findings: &mut Vec<Finding>,
) -> Result<(), SessionError> {
    findings.push(exposure::examine(bench, &pictures.lit));
    let lamps = mains_flicker::examine(bench, pictures);
    let wheel = colour_wheel::examine(bench, pictures, &lamps);
    findings.extend([lamps.finding, wheel]);
    if pictures.lit.usable_share() < light::LEAST_USABLE {
        let reason = "too little of the white picture is neither dark nor clipped";
        findings.extend(["pixels", "focus"].map(|name| Finding::not_checked(name, reason)));
        return Ok(());
    }
    findings.push(pixels::examine(bench, pictures)?);
    findings.push(focus::examine(bench, pictures)?);
    Ok(())
}
