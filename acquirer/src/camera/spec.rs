//! The `--camera` argument: which source of frames is meant.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::CameraError;

/// A source of frames, as the operator names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraSpec {
    /// A V4L2 device: `/dev/videoN`, or a stable link such as `/dev/v4l/by-id/...`.
    Device(PathBuf),
    /// `replay:DIR`: a scan folder, or a folder of pictures.
    Replay(PathBuf),
    /// `sim:SCENE`: the simulated room of that scene, a file's name in `config/scenes/` or a path.
    Simulated(String),
}

impl FromStr for CameraSpec {
    type Err = CameraError;

    fn from_str(text: &str) -> Result<Self, CameraError> {
        let bad = || CameraError::BadSpec {
            text: text.to_owned(),
        };
        if let Some(folder) = text.strip_prefix("replay:") {
            return if folder.is_empty() {
                Err(bad())
            } else {
                Ok(Self::Replay(folder.into()))
            };
        }
        if let Some(scene) = text.strip_prefix("sim:") {
            return if scene.is_empty() {
                Err(bad())
            } else {
                Ok(Self::Simulated(scene.to_owned()))
            };
        }
        match text.strip_prefix("/dev/") {
            Some(name) if !name.is_empty() => Ok(Self::Device(text.into())),
            _ => Err(bad()),
        }
    }
}

impl fmt::Display for CameraSpec {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device(path) => write!(out, "{}", path.display()),
            Self::Replay(folder) => write!(out, "replay:{}", folder.display()),
            Self::Simulated(scene) => write!(out, "sim:{scene}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_form_is_read_and_written_back() {
        for text in [
            "/dev/video0",
            "/dev/v4l/by-id/usb-cam-index0",
            "replay:scans/one",
            "sim:wall-cube",
        ] {
            let spec: CameraSpec = text.parse().unwrap();
            assert_eq!(spec.to_string(), text);
        }
        assert_eq!(
            "sim:a/b.toml".parse::<CameraSpec>().unwrap(),
            CameraSpec::Simulated("a/b.toml".into())
        );
    }

    #[test]
    fn anything_else_is_refused_with_the_three_forms() {
        for text in [
            "", "0", "video0", "replay:", "sim:", "/dev/", "webcam:1", "\u{0}",
        ] {
            let message = text.parse::<CameraSpec>().unwrap_err().to_string();
            assert!(
                message.contains("/dev/videoN")
                    && message.contains("replay:DIR")
                    && message.contains("sim:SCENE")
            );
        }
    }
}
