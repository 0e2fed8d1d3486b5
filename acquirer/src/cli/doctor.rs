//! `acquirer doctor`: examines the rig and says what to do.

use anyhow::bail;
use clap::{CommandFactory, error::ErrorKind};

use super::{
    args::{Args, RigArgs},
    console::Console,
    rig::open_rig,
};
use crate::{
    camera::CameraSpec,
    session::{
        Cancel, Diagnosis, Examination, Finding, Measured, SessionError, State, examine,
        set_exposure,
    },
};

/// `acquirer doctor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer doctor --camera /dev/video0
  acquirer doctor --projector 192.168.0.7:4460 --camera /dev/video0 --json
  acquirer doctor --camera sim:cube

Exit codes: 0 all is well, 1 something is to be done (the last line says about what) or it failed, 2 wrong use.
The limits stand in config/acquirer.toml under [doctor].")]
pub(super) struct DoctorArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Width of a line on the operator's terminal.
const LINE: usize = 100;
/// Where the text of a finding begins.
const INDENT: usize = 24;

pub(super) fn run(args: &DoctorArgs, cancel: &Cancel) -> anyhow::Result<()> {
    if let Some(CameraSpec::Replay(dir)) = &args.rig.camera {
        let message = format!(
            "--camera replay:{}: a recording cannot be examined, its pictures do not follow the projector; give a device \
             or sim:SCENE",
            dir.display()
        );
        Args::command()
            .error(ErrorKind::ValueValidation, message)
            .exit();
    }
    let mut config = args.rig.config.load()?;
    config.exposure.set |= args.rig.camera_settings.expose;
    let mut rig = open_rig(&args.rig, &config)?;
    let mut console = Console::new();
    if config.exposure.set {
        let exposure = set_exposure(&mut rig, &config.exposure, cancel, &mut |p| {
            console.show(&p);
        });
        console.say(&match exposure {
            Ok(exposure) => exposure.sentence(),
            Err(SessionError::Cancelled) => return Err(SessionError::Cancelled.into()),
            Err(error) => format!("the exposure can't be set: {error}"),
        });
    }
    let examination = Examination {
        limits: &config.doctor,
        latency: &config.latency,
        response: &config.pipeline.response,
    };
    let diagnosis = examine(&mut rig, &examination, cancel, &mut |p| console.show(&p))?;
    if args.json {
        println!("{}", serde_json::to_string(&diagnosis)?);
    } else {
        print!("{}", text(&diagnosis));
    }
    if !diagnosis.well {
        bail!("something is to be done about {}", diagnosis.bad.join(", "));
    }
    Ok(())
}

/// The diagnosis for people.
fn text(diagnosis: &Diagnosis) -> String {
    let mut text = format!(
        "camera     {}, {}\nprojector  {}\n\n",
        diagnosis.camera, diagnosis.format, diagnosis.projector
    );
    for finding in &diagnosis.findings {
        text.push_str(&finding_text(finding));
    }
    let unchecked = |finding: &&Finding| finding.state == State::NotChecked;
    let unchecked = diagnosis.findings.iter().filter(unchecked).count();
    text.push_str(&match (diagnosis.well, unchecked) {
        (true, 0) => "\nAll is well.\n".into(),
        (true, n) => format!("\nNothing is wrong, but {n} could not be checked.\n"),
        (false, _) => format!(
            "\nTo do: {}. Run this again afterwards.\n",
            diagnosis.bad.join(", ")
        ),
    });
    text
}

fn finding_text(finding: &Finding) -> String {
    let mark = match finding.state {
        State::Good => "good",
        State::Bad => "BAD",
        State::NotChecked => "-",
    };
    let mut text = format!("{mark:<6}{:<18}", finding.name.replace('_', " "));
    text.push_str(&wrapped(&finding.says));
    if finding.state == State::Bad {
        for measured in &finding.measured {
            text.push_str(&format!("{:INDENT$}{}\n", "", figure(measured)));
        }
    }
    if let Some(fix) = &finding.fix {
        text.push_str(&format!("{:INDENT$}", ""));
        text.push_str(&wrapped(&format!("=> {fix}")));
    }
    text
}

/// A figure with its limit.
fn figure(measured: &Measured) -> String {
    let value = format!("{}: {:.1} {}", measured.what, measured.value, measured.unit);
    match (measured.at_most, measured.at_least) {
        (Some(limit), _) => format!("{value} (good up to {limit:.1})"),
        (None, Some(limit)) => format!("{value} (good from {limit:.1} on)"),
        (None, None) => value,
    }
}

/// Text broken between words, further lines indented.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let room = LINE - INDENT;
        if let Some(line) = lines.last_mut() {
            if line.is_empty() {
                line.push_str(word);
            } else if line.chars().count() + 1 + word.chars().count() <= room {
                line.push(' ');
                line.push_str(word);
            } else {
                lines.push(word.to_owned());
            }
        }
    }
    lines.join(&format!("\n{:INDENT$}", "")) + "\n"
}
