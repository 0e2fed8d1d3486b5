//! What the window remembers from one time to the next, in `window.toml` in the operator's configuration folder.

use std::{
    env,
    path::{Path, PathBuf},
};

use eframe::egui::ThemePreference;
use serde::{Deserialize, Serialize};

use crate::{camera::CameraSettings, scan::write_whole};

/// Light or dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Theme {
    /// As the desktop.
    #[default]
    System,
    /// Dark on light.
    Light,
    /// Light on dark.
    Dark,
}

impl From<Theme> for ThemePreference {
    fn from(theme: Theme) -> Self {
        match theme {
            Theme::System => Self::System,
            Theme::Light => Self::Light,
            Theme::Dark => Self::Dark,
        }
    }
}

/// What is drawn over the live picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Overlays {
    /// The lines that were read, in their projected colours.
    pub(super) grid: bool,
    /// Row and column at each crossing.
    pub(super) labels: bool,
    /// Crossings without a label, in the colour of the reason.
    pub(super) holes: bool,
    /// Pixels that are too bright (red) or black (blue).
    pub(super) clipping: bool,
    /// Where the projector's light does not reach.
    pub(super) shadow: bool,
}

impl Default for Overlays {
    fn default() -> Self {
        Self {
            grid: true,
            labels: false,
            holes: true,
            clipping: false,
            shadow: false,
        }
    }
}

/// What the window remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Preferences {
    /// Light or dark.
    pub(super) theme: Theme,
    /// Size of everything, 0.5 to 3.
    pub(super) zoom: f32,
    /// Width and height of the window, in points.
    pub(super) window: [f32; 2],
    /// Read every frame while nothing else is done.
    pub(super) read_live: bool,
    /// Show the picture after processing instead of the camera's.
    pub(super) after: bool,
    /// Processing takes the background away.
    pub(super) subtract: bool,
    /// Show the histogram of hues.
    pub(super) histogram: bool,
    /// Colour the surface by the camera's picture instead of by depth.
    pub(super) colour_by_picture: bool,
    /// The camera that was used last, as after `--camera`.
    pub(super) camera: String,
    /// What is drawn over the live picture.
    pub(super) overlays: Overlays,
    /// What is asked of the camera.
    pub(super) camera_settings: Option<CameraSettings>,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            theme: Theme::default(),
            zoom: 1.0,
            window: [1280.0, 720.0],
            read_live: false,
            after: false,
            subtract: true,
            histogram: false,
            colour_by_picture: false,
            camera: String::new(),
            overlays: Overlays::default(),
            camera_settings: None,
        }
    }
}

impl Preferences {
    /// Reads what was remembered. Without a file the usual holds; a file that cannot be read is told and the usual
    /// holds as well.
    pub(super) fn load(path: &Path) -> (Self, Option<String>) {
        let Ok(text) = std::fs::read_to_string(path) else {
            return (Self::default(), None);
        };
        match toml::from_str::<Self>(&text) {
            Ok(found) => (found.checked(), None),
            Err(error) => {
                let told = format!(
                    "{}: {error}; the window starts with its usual settings",
                    path.display()
                );
                (Self::default(), Some(told))
            }
        }
    }

    /// Writes the file, and its folder if need be.
    pub(super) fn save(&self, path: &Path) -> Result<(), String> {
        let told = |error: &dyn std::fmt::Display| {
            format!(
                "the window's settings can't be kept in {}: {error}",
                path.display()
            )
        };
        let text = toml::to_string_pretty(self).map_err(|error| told(&error))?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| told(&error))?;
        }
        let written = write_whole(path, text.as_bytes());
        written.map(drop).map_err(|error| told(&error))
    }

    fn checked(mut self) -> Self {
        let usual = Self::default();
        if !(0.5..=3.0).contains(&self.zoom) {
            self.zoom = usual.zoom;
        }
        if !self
            .window
            .iter()
            .all(|side| (300.0..=16_384.0).contains(side))
        {
            self.window = usual.window;
        }
        self
    }
}

/// Where the file stands: `$XDG_CONFIG_HOME/acquirer/window.toml`, or under `~/.config`. `None` without a home.
pub(super) fn usual_path() -> Option<PathBuf> {
    let folder = |name: &str| {
        env::var_os(name)
            .map(PathBuf::from)
            .filter(|p| p.is_absolute())
    };
    let config = folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")))?;
    Some(config.join("acquirer/window.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_remembered_comes_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("new/window.toml");
        let mut preferences = Preferences {
            theme: Theme::Light,
            camera: "sim:cube".into(),
            camera_settings: Some(CameraSettings::default()),
            ..Preferences::default()
        };
        preferences.overlays.labels = true;
        preferences.save(&path).unwrap();
        assert_eq!(Preferences::load(&path), (preferences, None));
    }

    #[test]
    fn a_missing_or_broken_file_gives_the_usual_settings() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("window.toml");
        assert_eq!(Preferences::load(&path), (Preferences::default(), None));
        std::fs::write(&path, "zoom = 1e9\nwindow = [1.0, 1.0]").unwrap();
        assert_eq!(Preferences::load(&path).0, Preferences::default());
        std::fs::write(&path, "zoom = [").unwrap();
        let (usual, told) = Preferences::load(&path);
        assert_eq!(usual, Preferences::default());
        assert!(told.unwrap().contains("window.toml"));
    }
}
