//! A recording as a camera: `--camera replay:DIR`.
//!
//! Takes a scan folder or a folder of pictures, gives their frames. With a scan folder it answers
//! what is shown with the captures of that kind in turn, so that a scan of it is the recorded scan
//! again; told nothing, it gives all captures in the order of recording. Pictures come in the order
//! of their names. After the last one it begins again.

use std::path::{Path, PathBuf};
use std::time::Duration;

use shared::stage::Stage;

use super::{Camera, CameraError, CaptureFormat, Frame, Losses, PixelFormat, Rate};
use crate::clock::monotonic_now;
use crate::scan::{ScanFolder, Shows, read_picture};

/// One recorded frame on disk.
#[derive(Clone, Debug)]
struct Recorded {
    path: PathBuf,
    /// What it shows, when that is known.
    kind: Option<(Stage, Shows)>,
}

/// A camera that plays a recording.
#[derive(Debug)]
pub struct ReplayCamera {
    folder: PathBuf,
    recorded: Vec<Recorded>,
    expected: Option<(Stage, Shows)>,
    /// Frames given since what is expected changed.
    turn: usize,
    given: u64,
    size: (u32, u32),
}

impl ReplayCamera {
    /// Opens a scan folder, or a folder with PNG or JPEG files.
    ///
    /// # Errors
    /// When there is neither, or its first picture cannot be read.
    pub fn open(folder: &Path) -> Result<Self, CameraError> {
        let failed = |reason: String| CameraError::Replay {
            folder: folder.into(),
            reason,
        };
        let recorded = if folder.join("scan.json").is_file() {
            scan(folder).map_err(failed)?
        } else {
            pictures(folder).map_err(|error| failed(error.to_string()))?
        };
        let first = recorded
            .first()
            .ok_or_else(|| failed("it holds neither scan.json nor PNG or JPEG files".into()))?;
        let size = read_picture(&first.path)
            .map_err(|error| failed(error.to_string()))?
            .dimensions();
        Ok(Self {
            folder: folder.into(),
            recorded,
            expected: None,
            turn: 0,
            given: 0,
            size,
        })
    }

    fn failed(&self, reason: String) -> CameraError {
        CameraError::Replay {
            folder: self.folder.clone(),
            reason,
        }
    }

    /// The frames that answer what is expected; all of them where the recording does not say what
    /// it shows.
    fn answers(&self) -> Result<Vec<&Recorded>, CameraError> {
        let says_nothing = self.recorded.iter().all(|frame| frame.kind.is_none());
        let fits = |frame: &&Recorded| {
            says_nothing || self.expected.is_none() || frame.kind == self.expected
        };
        let answers: Vec<_> = self.recorded.iter().filter(fits).collect();
        match (answers.is_empty(), self.expected) {
            (true, Some((stage, shows))) => Err(self.failed(format!(
                "it has no {} capture of the {stage} stage",
                shows.stem()
            ))),
            _ => Ok(answers),
        }
    }
}

impl Camera for ReplayCamera {
    fn description(&self) -> String {
        format!(
            "recording {} ({} frames)",
            self.folder.display(),
            self.recorded.len()
        )
    }

    fn format(&self) -> CaptureFormat {
        let (width, height) = self.size;
        CaptureFormat {
            width,
            height,
            rate: Rate::per_second(30),
            pixels: PixelFormat::Rgb,
        }
    }

    fn losses(&self) -> Losses {
        Losses::default()
    }

    fn next_frame(&mut self, _timeout: Duration) -> Result<Frame, CameraError> {
        let answers = self.answers()?;
        let path = &answers[self.turn % answers.len()].path;
        let picture = read_picture(path).map_err(|error| self.failed(error.to_string()))?;
        if picture.dimensions() != self.size {
            let (found, wanted) = (picture.dimensions(), self.size);
            let reason = format!(
                "{} is {found:?} px, the first one {wanted:?} px",
                path.display()
            );
            return Err(self.failed(reason));
        }
        let frame = Frame {
            picture,
            number: self.given,
            captured_at: monotonic_now(),
            dropped: 0,
        };
        self.turn += 1;
        self.given += 1;
        Ok(frame)
    }

    /// A recording has no clock: its next frame is always fresh.
    fn frame_after(&mut self, _instant: Duration, timeout: Duration) -> Result<Frame, CameraError> {
        self.next_frame(timeout)
    }

    fn follows_projector(&self) -> bool {
        false
    }

    fn has(&self, shows: Shows, stage: Stage) -> bool {
        let mut kinds = self.recorded.iter().map(|frame| frame.kind);
        kinds.any(|kind| kind == Some((stage, shows)))
    }

    fn expect(&mut self, shows: Shows, stage: Stage) {
        if self.expected.replace((stage, shows)) != Some((stage, shows)) {
            self.turn = 0;
        }
    }
}

fn scan(folder: &Path) -> Result<Vec<Recorded>, String> {
    let scan = ScanFolder::open(folder).map_err(|error| error.to_string())?;
    let captures = scan.manifest().captures.iter();
    Ok(captures
        .map(|capture| Recorded {
            path: folder.join(&capture.file),
            kind: Some((capture.stage, capture.shows)),
        })
        .collect())
}

fn pictures(folder: &Path) -> std::io::Result<Vec<Recorded>> {
    let is_picture = |path: &PathBuf| {
        let ending = path
            .extension()
            .and_then(|ending| ending.to_str())
            .unwrap_or_default()
            .to_ascii_lowercase();
        matches!(ending.as_str(), "png" | "jpg" | "jpeg")
    };
    let entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    let mut paths: Vec<_> = entries
        .into_iter()
        .map(|entry| entry.path())
        .filter(is_picture)
        .collect();
    paths.sort();
    Ok(paths
        .into_iter()
        .map(|path| Recorded { path, kind: None })
        .collect())
}

#[cfg(test)]
mod tests {
    use image::{Rgb, RgbImage};
    use shared::pattern::RasterSize;

    use super::*;

    /// The red of the next frame's pixels, which says which picture it is.
    fn red(camera: &mut ReplayCamera) -> u8 {
        camera
            .next_frame(Duration::ZERO)
            .unwrap()
            .picture
            .get_pixel(0, 0)
            .0[0]
    }

    fn save(path: &Path, size: u32, red: u8) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        RgbImage::from_pixel(size, size, Rgb([red, 0, 0]))
            .save(path)
            .unwrap();
    }

    /// A scan folder whose capture k has the red k.
    fn recorded_scan(folder: &Path) {
        let kinds = [
            ("background", "black"),
            ("background", "prmvs"),
            ("background", "prmvs"),
            ("object", "prmvs"),
        ];
        let captures: Vec<_> = kinds
            .iter()
            .enumerate()
            .map(|(k, (stage, shows))| {
                let file = format!("{stage}/{shows}-{k:02}.png");
                save(&folder.join(&file), 8, k as u8);
                serde_json::json!({"stage": stage, "shows": shows, "file": file})
            })
            .collect();
        let size = RasterSize {
            width: 8,
            height: 8,
        };
        let colours = ["#ff0000", "#ffff00", "#ff00ff", "#00ff00"];
        let pattern = serde_json::json!({"rows": 15, "columns": 15, "row_width_px": 6, "column_width_px": 6,
            "colours": colours, "unary": "#ff0000"});
        let manifest = serde_json::json!({"format": 1, "pattern": pattern, "projector": size, "camera": size, "captures": captures});
        std::fs::write(folder.join("scan.json"), manifest.to_string()).unwrap();
    }

    #[test]
    fn a_scan_folder_answers_what_is_shown_and_begins_again() {
        let folder = tempfile::tempdir().unwrap();
        recorded_scan(folder.path());
        let mut camera = ReplayCamera::open(folder.path()).unwrap();
        assert_eq!([(); 5].map(|()| red(&mut camera)), [0, 1, 2, 3, 0]);
        camera.expect(Shows::Prmvs, Stage::Background);
        assert_eq!([(); 3].map(|()| red(&mut camera)), [1, 2, 1]);
        camera.expect(Shows::Prmvs, Stage::Object);
        assert_eq!(red(&mut camera), 3);
        assert!(camera.has(Shows::Prmvs, Stage::Object));
        assert!(!camera.has(Shows::White, Stage::Object));
        camera.expect(Shows::White, Stage::Object);
        let message = camera.next_frame(Duration::ZERO).unwrap_err().to_string();
        assert!(
            message.contains("no white capture of the object stage"),
            "{message}"
        );
    }

    #[test]
    fn plain_pictures_come_in_the_order_of_their_names_whatever_is_shown() {
        let folder = tempfile::tempdir().unwrap();
        for (name, red) in [("b.png", 2), ("a.png", 1), ("c.PNG", 3)] {
            save(&folder.path().join(name), 4, red);
        }
        std::fs::write(folder.path().join("notes.txt"), "not a picture").unwrap();
        let mut camera = ReplayCamera::open(folder.path()).unwrap();
        camera.expect(Shows::White, Stage::Object);
        assert_eq!([(); 4].map(|()| red(&mut camera)), [1, 2, 3, 1]);
        assert_eq!(
            camera
                .frame_after(Duration::MAX, Duration::ZERO)
                .unwrap()
                .number,
            4
        );
    }

    #[test]
    fn a_folder_without_pictures_or_with_a_broken_one_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let message = ReplayCamera::open(folder.path()).unwrap_err().to_string();
        assert!(message.contains("neither"), "{message}");
        std::fs::write(folder.path().join("a.png"), "no picture").unwrap();
        assert!(ReplayCamera::open(folder.path()).is_err());
        assert!(ReplayCamera::open(Path::new("/no/such/folder")).is_err());
    }

    #[test]
    fn pictures_of_two_sizes_are_no_recording() {
        let folder = tempfile::tempdir().unwrap();
        save(&folder.path().join("a.png"), 4, 1);
        save(&folder.path().join("b.png"), 5, 1);
        let mut camera = ReplayCamera::open(folder.path()).unwrap();
        assert_eq!(red(&mut camera), 1);
        assert!(
            camera
                .next_frame(Duration::ZERO)
                .unwrap_err()
                .to_string()
                .contains("b.png")
        );
    }
}
