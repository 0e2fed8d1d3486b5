//! `acquirer cameras`: which cameras are plugged in and what they offer, as a table or as JSON.

use std::fmt::Write;

use serde::Serialize;

use crate::camera::v4l2::{CameraInfo, SizeInfo, list_cameras};

/// What the command gives; with `--json` it goes out as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraList {
    /// The capture devices, in the order of their numbers.
    pub cameras: Vec<CameraInfo>,
}

/// Asks this machine for its cameras.
#[must_use]
pub fn cameras() -> CameraList {
    CameraList {
        cameras: list_cameras(),
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

fn paragraph(camera: &CameraInfo) -> String {
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
    text
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
    use crate::camera::Rate;
    use crate::camera::v4l2::FormatInfo;

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
            cameras: vec![camera],
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
    fn no_camera_is_told_with_what_to_do_instead() {
        assert!(table(&CameraList { cameras: vec![] }).contains("replay:DIR"));
    }
}
