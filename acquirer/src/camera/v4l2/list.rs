//! The cameras of this machine and what they offer.
//!
//! Takes the device nodes `/dev/video*`, gives the real capture devices among them: a UVC camera
//! has a second node for metadata, and there are outputs and codecs. Formats, sizes and rates are
//! as the driver enumerates them; a range of sizes or rates is given by its ends and the usual
//! values inside it.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use serde::Serialize;
use v4l::Device;
use v4l::capability::Flags;
use v4l::video::Capture;

use super::modes;
use crate::camera::{CameraError, PixelFormat, Rate};

/// A capture device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraInfo {
    /// The device node.
    pub path: PathBuf,
    /// The camera's own name.
    pub name: String,
    /// The kernel driver, `uvcvideo` for a webcam.
    pub driver: String,
    /// Where it is plugged in.
    pub bus: String,
    /// What it offers; empty when it cannot be asked.
    pub formats: Vec<FormatInfo>,
    /// Why it cannot be used at the moment, if so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// One pixel format of a camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormatInfo {
    /// V4L2's four-character code.
    pub fourcc: String,
    /// The driver's words for it.
    pub description: String,
    /// Whether this program can decode it.
    pub usable: bool,
    /// The sizes of this format.
    pub sizes: Vec<SizeInfo>,
}

/// One size of a format.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SizeInfo {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Frames per second, exact fractions as text (`30000/1001`), fastest first; empty when the
    /// driver does not say.
    pub rates: Vec<Rate>,
}

/// Every capture device, in the order of their numbers. A device that may not be opened is listed
/// with the reason.
#[must_use]
pub fn list_cameras() -> Vec<CameraInfo> {
    nodes()
        .into_iter()
        .filter_map(|path| probe(&path))
        .collect()
}

/// The device nodes `/dev/videoN`, by N.
fn nodes() -> Vec<PathBuf> {
    let number = |path: &PathBuf| {
        path.file_name()?
            .to_str()?
            .strip_prefix("video")?
            .parse::<u32>()
            .ok()
    };
    let entries = std::fs::read_dir("/dev")
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path());
    let mut numbered: Vec<_> = entries
        .filter_map(|path| Some((number(&path)?, path)))
        .collect();
    numbered.sort();
    numbered.into_iter().map(|(_, path)| path).collect()
}

/// What stands behind a node; nothing when it is no capture device.
fn probe(path: &Path) -> Option<CameraInfo> {
    let unreadable = |problem: String| {
        let number = path.file_name()?;
        let name = std::fs::read_to_string(
            Path::new("/sys/class/video4linux")
                .join(number)
                .join("name"),
        )
        .ok()?;
        let (driver, bus) = (String::new(), String::new());
        let info = CameraInfo {
            path: path.into(),
            name: name.trim().into(),
            driver,
            bus,
            formats: vec![],
            problem: None,
        };
        Some(CameraInfo {
            problem: Some(problem),
            ..info
        })
    };
    match identify(path) {
        Ok((device, info)) => {
            let formats = formats_of(&device);
            let problem = formats
                .is_empty()
                .then(|| "it offers no format at the moment".to_owned());
            Some(CameraInfo {
                formats,
                problem,
                ..info
            })
        }
        Err(CameraError::NotACamera { .. }) => None,
        Err(error) => unreadable(error.to_string()),
    }
}

/// Opens a node and asks who it is; its formats are not asked.
pub(super) fn identify(path: &Path) -> Result<(Device, CameraInfo), CameraError> {
    let device = Device::with_path(path).map_err(|error| open_error(path, &error))?;
    let caps = guarded(|| device.query_caps()).map_err(|error| CameraError::Setup {
        path: path.into(),
        step: "asking what it is",
        reason: error.to_string(),
    })?;
    if !caps
        .capabilities
        .contains(Flags::VIDEO_CAPTURE | Flags::STREAMING)
    {
        let reason = format!("{} ({}) does not capture video", caps.card, caps.driver);
        return Err(CameraError::NotACamera {
            path: path.into(),
            reason,
            present: present(),
        });
    }
    let (name, driver, bus) = (caps.card, caps.driver, caps.bus);
    Ok((
        device,
        CameraInfo {
            path: path.into(),
            name,
            driver,
            bus,
            formats: vec![],
            problem: None,
        },
    ))
}

/// Who stands behind each node that can be opened now, without their formats.
pub(super) fn identities() -> Vec<CameraInfo> {
    nodes()
        .iter()
        .filter_map(|path| identify(path).ok())
        .map(|(_, info)| info)
        .collect()
}

pub(super) fn open_error(path: &Path, error: &io::Error) -> CameraError {
    match error.raw_os_error() {
        Some(super::backend::EBUSY) => CameraError::Busy { path: path.into() },
        _ if error.kind() == io::ErrorKind::PermissionDenied => {
            CameraError::Denied { path: path.into() }
        }
        _ => CameraError::NotACamera {
            path: path.into(),
            reason: error.to_string(),
            present: present(),
        },
    }
}

/// The cameras that are there, as a sentence for an error.
fn present() -> String {
    let names: Vec<_> = nodes()
        .iter()
        .filter_map(|path| {
            let (_, info) = Device::with_path(path).ok().and_then(|device| {
                let caps = guarded(|| device.query_caps()).ok()?;
                caps.capabilities
                    .contains(Flags::VIDEO_CAPTURE | Flags::STREAMING)
                    .then_some((device, caps.card))
            })?;
            Some(format!("{} ({info})", path.display()))
        })
        .collect();
    if names.is_empty() {
        "no camera is plugged in; replay:DIR and sim:SCENE need none".into()
    } else {
        format!("cameras here: {}", names.join(", "))
    }
}

/// Calls into the v4l crate, which panics on names that are not UTF-8 and on values newer than
/// itself.
pub(super) fn guarded<T>(call: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    catch_unwind(AssertUnwindSafe(call))
        .unwrap_or_else(|_| Err(io::Error::other("the driver's answer cannot be read")))
}

/// What a device offers.
pub(super) fn formats_of(device: &Device) -> Vec<FormatInfo> {
    let descriptions = guarded(|| device.enum_formats()).unwrap_or_default();
    descriptions
        .into_iter()
        .map(|format| {
            let fourcc = format.fourcc.to_string();
            let frame_sizes = guarded(|| device.enum_framesizes(format.fourcc)).unwrap_or_default();
            let sizes = modes::sizes(frame_sizes)
                .into_iter()
                .map(|(width, height)| {
                    let intervals =
                        guarded(|| device.enum_frameintervals(format.fourcc, width, height));
                    SizeInfo {
                        width,
                        height,
                        rates: modes::rates(&intervals.unwrap_or_default()),
                    }
                });
            let usable = PixelFormat::from_fourcc(&fourcc).is_some();
            FormatInfo {
                description: format.description,
                usable,
                sizes: sizes.collect(),
                fourcc,
            }
        })
        .collect()
}
