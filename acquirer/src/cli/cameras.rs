//! `acquirer cameras`: which cameras are plugged in, what they offer and how they can be set, as a table or as JSON.

use std::fmt::Write;

use serde::Serialize;

use crate::camera::ControlInfo;
use crate::camera::controls::sort_for_people;
use crate::camera::v4l2::{CameraInfo, SizeInfo, list_cameras, list_controls};

/// `acquirer cameras`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer cameras
  acquirer cameras --controls
  acquirer cameras --controls --json")]
pub(super) struct CamerasArgs {
    /// List each camera's controls too, with their ranges and what they are set to.
    #[arg(long)]
    pub controls: bool,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// What the command gives; with `--json` it goes out as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraList {
    /// The capture devices, in the order of their numbers.
    pub cameras: Vec<ListedCamera>,
}

/// A camera of the list.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ListedCamera {
    /// What it is and what it offers.
    #[serde(flatten)]
    pub camera: CameraInfo,
    /// Its controls, if they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controls: Option<Vec<ControlInfo>>,
}

/// Asks this machine for its cameras, and for their controls if `with_controls`.
#[must_use]
pub fn cameras(with_controls: bool) -> CameraList {
    let listed = |mut camera: CameraInfo| {
        let controls = with_controls.then(|| {
            let mut controls = list_controls(&camera.path).unwrap_or_else(|error| {
                camera.problem.get_or_insert_with(|| error.to_string());
                vec![]
            });
            sort_for_people(&mut controls);
            controls
        });
        ListedCamera { camera, controls }
    };
    CameraList {
        cameras: list_cameras().into_iter().map(listed).collect(),
    }
}

/// The list for people: a paragraph per camera, a line per size.
#[must_use]
pub fn table(list: &CameraList) -> String {
    if list.cameras.is_empty() {
        return "No camera is plugged in. `--camera replay:DIR` and `--camera sim:SCENE` need none.\n".into();
    }
    let paragraphs: Vec<String> = list.cameras.iter().map(paragraph).collect();
    paragraphs.join("\n")
}

fn paragraph(listed: &ListedCamera) -> String {
    let camera = &listed.camera;
    let mut text = format!("{}  {}", camera.path.display(), camera.name);
    // Writing to a String cannot fail; the results are of a trait that is also for files.
    if !camera.driver.is_empty() {
        write!(text, "  (driver {}, at {})", camera.driver, camera.bus).ok();
    }
    text.push('\n');
    if let Some(problem) = &camera.problem {
        writeln!(text, "  problem: {problem}").ok();
    }
    for format in &camera.formats {
        let note = if format.usable {
            ""
        } else {
            "  [cannot be decoded here]"
        };
        writeln!(text, "  {}  {}{note}", format.fourcc, format.description).ok();
        text.extend(format.sizes.iter().map(size_line));
    }
    if let Some(controls) = &listed.controls {
        text.push_str("  controls\n");
        text.extend(controls.iter().map(control_line));
    }
    text
}

fn control_line(control: &ControlInfo) -> String {
    let now = control
        .value
        .map_or_else(|| "not readable".into(), |value| control.value_text(value));
    let state = match (control.read_only, control.inactive) {
        (true, _) => "  [read only]",
        (false, true) => "  [an automatic has it in hand]",
        (false, false) => "",
    };
    let (key, range) = (&control.key, control.range_text());
    let default = control.value_text(control.default);
    format!("    {key:<28}{now}  (range: {range}; default: {default}){state}\n")
}

fn size_line(size: &SizeInfo) -> String {
    let rates: Vec<String> = size.rates.iter().map(ToString::to_string).collect();
    let rates = if rates.is_empty() {
        "rates unknown".into()
    } else {
        format!("{} per second", rates.join(", "))
    };
    let dimensions = format!("{}x{}", size.width, size.height);
    format!("    {dimensions:<11}{rates}\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::v4l2::FormatInfo;
    use crate::camera::{ControlKind, Rate};

    #[test]
    fn a_camera_is_told_with_every_size_and_exact_rates() {
        let rates = vec![Rate::per_second(30), Rate::new(30_000, 1001).unwrap()];
        let sizes = vec![
            SizeInfo {
                width: 640,
                height: 480,
                rates,
            },
            SizeInfo {
                width: 64,
                height: 48,
                rates: vec![],
            },
        ];
        let format = |fourcc: &str, usable, sizes| FormatInfo {
            fourcc: fourcc.into(),
            description: "words".into(),
            usable,
            sizes,
        };
        let camera = CameraInfo {
            path: "/dev/video2".into(),
            name: "Desk Cam".into(),
            driver: "uvcvideo".into(),
            bus: "usb-1".into(),
            formats: vec![format("YUYV", true, sizes), format("H264", false, vec![])],
            problem: Some("in use".into()),
        };
        let list = CameraList {
            cameras: vec![ListedCamera {
                camera,
                controls: None,
            }],
        };
        assert_eq!(
            table(&list),
            "/dev/video2  Desk Cam  (driver uvcvideo, at usb-1)\n  problem: in use\n  YUYV  words\n    \
             640x480    30, 30000/1001 per second\n    64x48      rates unknown\n  H264  words  [cannot be decoded here]\n"
        );
        let json = serde_json::to_value(&list).unwrap();
        assert_eq!(
            json["cameras"][0]["formats"][0]["sizes"][0]["rates"][1],
            "30000/1001"
        );
    }

    #[test]
    fn controls_are_told_with_value_and_range() {
        let kind = ControlKind::Number {
            least: 1,
            most: 5000,
            step: 1,
        };
        let exposure = ControlInfo {
            id: 0x009a_0902,
            key: "exposure_time_absolute".into(),
            name: "Exposure Time, Absolute".into(),
            kind,
            unit: Some("x 100 us"),
            default: 157,
            value: Some(50),
            inactive: true,
            read_only: false,
        };
        assert_eq!(
            control_line(&exposure),
            "    exposure_time_absolute      50 (5 ms)  (range: 1 to 5000 x 100 us; default: 157 (15.7 ms))  \
             [an automatic has it in hand]\n"
        );
    }

    #[test]
    fn no_camera_is_told_with_what_to_do_instead() {
        assert!(table(&CameraList { cameras: vec![] }).contains("replay:DIR"));
    }
}
