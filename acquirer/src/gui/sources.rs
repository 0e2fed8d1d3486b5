//! Where pictures can come from, for the operator to choose: the cameras of this machine, simulated rooms, recorded
//! scans.

use std::path::{Path, PathBuf};

use crate::camera::{
    CameraSettings, CameraSpec, scenes,
    v4l2::{CameraInfo, list_cameras},
};

/// A camera with what is asked of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Source {
    /// Which camera; `None` is the first one that is plugged in.
    pub(super) camera: Option<CameraSpec>,
    /// Size, rate and format.
    pub(super) settings: CameraSettings,
}

/// What there is to choose from.
#[derive(Debug, Clone, Default)]
pub(super) struct Sources {
    /// The cameras.
    pub(super) cameras: Vec<CameraInfo>,
    /// Names of simulated rooms.
    pub(super) rooms: Vec<String>,
    /// Scan folders beside the one that is recorded into, the newest first.
    pub(super) scans: Vec<PathBuf>,
}

impl Sources {
    /// Looks for everything; `beside` is the folder that scans are recorded as.
    pub(super) fn find(beside: &Path) -> Self {
        Self {
            cameras: list_cameras(),
            rooms: scenes().into_iter().map(|(name, _)| name).collect(),
            scans: scans_beside(beside),
        }
    }

    /// The camera of this specification, if it is plugged in; the first without one.
    pub(super) fn camera(&self, spec: Option<&CameraSpec>) -> Option<&CameraInfo> {
        match spec {
            None => self.cameras.first(),
            Some(CameraSpec::Device(path)) => self.cameras.iter().find(|info| info.path == *path),
            Some(_) => None,
        }
    }
}

/// The folders with a scan in them that lie where this one lies.
fn scans_beside(folder: &Path) -> Vec<PathBuf> {
    let above = folder
        .parent()
        .filter(|above| !above.as_os_str().is_empty());
    let entries = std::fs::read_dir(above.unwrap_or(Path::new("."))).into_iter();
    let mut found: Vec<_> = entries
        .flatten()
        .flatten()
        .filter_map(|entry| {
            let path = entry.path();
            let written = path.join("scan.json").metadata().ok()?.modified().ok()?;
            let short = path.strip_prefix(".").unwrap_or(&path).to_owned();
            Some((written, short))
        })
        .collect();
    found.sort_by(|a, b| b.cmp(a));
    found.into_iter().map(|(_, path)| path).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn scans_beside_the_recording_are_found_and_other_folders_are_not() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["cup", "not-a-scan"] {
            fs::create_dir(dir.path().join(name)).unwrap();
        }
        fs::write(dir.path().join("cup/scan.json"), "{}").unwrap();
        let found = scans_beside(&dir.path().join("new"));
        assert_eq!(found, [dir.path().join("cup")]);
    }
}
