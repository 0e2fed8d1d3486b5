//! Broken input for everything that reads bytes from outside. Each target reads its input as the programs do; whatever
//! comes, it must end, soon, without a panic, and what was read must be read the same from what it is written as.
//!
//! Inputs come from random changes and, guided by coverage, from the crate in `tests/fuzz`.

mod random;

pub use random::{Found, run};

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    sync::OnceLock,
    time::{Duration, Instant},
};

use acquirer::{
    camera::load_scene,
    config::Config,
    output::shift_table::read_shift_table,
    scan::{ScanFolder, check_scan, read_picture},
};
use shared::{
    geometry::RigCalibration,
    pattern::Palette,
    protocol::{ClientMessage, Decoder, Message, PairingCode, ServerMessage, encode},
};

/// Most bytes of an input.
const MAX_BYTES: usize = 64 * 1024;
/// Longest time that one input may take.
pub const MAX_TIME: Duration = Duration::from_secs(10);

/// What is fed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Lines of the protocol, both directions, and pairing codes.
    Codec,
    /// `scan.json` of a folder.
    Scan,
    /// `acquirer.toml`, palettes and rooms.
    Configuration,
    /// `projector.toml` and `pattern.toml`.
    Projector,
    /// `calibration.json`.
    Calibration,
    /// Shift tables.
    Csv,
    /// PNG and JPEG pictures.
    Image,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Codec,
        Self::Scan,
        Self::Configuration,
        Self::Projector,
        Self::Calibration,
        Self::Csv,
        Self::Image,
    ];

    /// The word on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Codec => "codec",
            Self::Scan => "scan",
            Self::Configuration => "configuration",
            Self::Projector => "projector",
            Self::Calibration => "calibration",
            Self::Csv => "csv",
            Self::Image => "image",
        }
    }

    /// Valid inputs to begin with, from the repository.
    #[must_use]
    pub fn seeds(self) -> Vec<Vec<u8>> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let page = root.join("shared/src/protocol/PROTOCOL.md");
        let files = match self {
            Self::Codec => vec![page],
            Self::Scan => vec![root.join("tests/recorded/wall-cube/scan.json")],
            Self::Configuration => vec![
                root.join("config/acquirer.toml"),
                root.join("config/palettes/sixteen.toml"),
                root.join("config/scenes/cube.toml"),
                root.join("config/scenes/glossy-mug.toml"),
            ],
            Self::Projector => vec![
                root.join("config/projector.toml"),
                root.join("config/pattern.toml"),
            ],
            Self::Calibration => vec![root.join("tests/recorded/wall-cube/calibration.json")],
            Self::Csv => vec![root.join("tests/recorded/appendix-c.csv")],
            Self::Image => return pictures(),
        };
        let read = files.iter().filter_map(|file| fs::read(file).ok());
        let mut seeds: Vec<Vec<u8>> = read.collect();
        if self == Self::Codec {
            let page = seeds.remove(0);
            let lines = page.split(|byte| *byte == b'\n');
            seeds = lines
                .filter(|line| line.starts_with(b"{"))
                .map(|line| [line, b"\n"].concat())
                .collect();
            let code = format!("SLP1/A:1/{}/{}", "A".repeat(64), "B".repeat(32));
            seeds.push(code.into_bytes());
        }
        seeds.iter_mut().for_each(|seed| seed.truncate(MAX_BYTES));
        seeds
    }

    /// Reads an input as the programs do, as a file in this folder where they read files; gives a number that tells how
    /// far it came.
    ///
    /// # Panics
    /// When the programs would, or what was read is written so that it is read otherwise.
    pub fn feed(self, input: &[u8], dir: &Path) -> u64 {
        match self {
            Self::Codec => codec(input),
            Self::Scan => with_file(dir, "scan.json", input, |_| {
                let opened = ScanFolder::open(dir).map_or(0, |folder| {
                    let captures = folder.manifest().captures.len() as u64;
                    folder.selection().ok();
                    1 + captures
                });
                let checked = check_scan(dir).map_or(0, |check| check.damaged.len() as u64);
                opened << 8 | checked
            }),
            Self::Configuration => with_file(dir, "scene.toml", input, |path| {
                let config = u64::from(configuration(path));
                let text = String::from_utf8_lossy(input);
                let palette = u64::from(Palette::from_toml(&text).is_ok());
                let scene = u64::from(load_scene(&path.display().to_string()).is_ok());
                config | palette << 1 | scene << 2
            }),
            Self::Projector => with_file(dir, "projector.toml", input, |path| {
                let config = u64::from(projector::config::Config::read(path).is_ok());
                config | u64::from(projector::config::read_grid(path).is_ok()) << 1
            }),
            Self::Calibration => RigCalibration::from_json(input).map_or(0, |calibration| {
                // numbers may come back changed in their last digit
                let written = calibration.to_json().expect("it was read");
                RigCalibration::from_json(written.as_bytes()).expect("it was written");
                1
            }),
            Self::Csv => with_file(dir, "shifts.csv", input, |path| {
                read_shift_table(path).map_or(0, |rows| 1 + rows.len() as u64)
            }),
            Self::Image => with_file(dir, "picture", input, |path| {
                read_picture(path).map_or(0, |picture| {
                    1 + u64::from(picture.width()) * u64::from(picture.height())
                })
            }),
        }
    }
}

/// Whether it is one; it must be the same when it is read from what it is written as.
fn configuration(path: &Path) -> bool {
    let Ok(config) = Config::load(Some(path)) else {
        return false;
    };
    if let Ok(written) = toml::to_string(&config) {
        let read: Config = toml::from_str(&written).expect("it was written");
        assert_eq!(format!("{read:?}"), format!("{config:?}"));
    }
    true
}

fn codec(input: &[u8]) -> u64 {
    let mut pairing = 0;
    if let Ok(text) = std::str::from_utf8(input)
        && let Ok(code) = text.parse::<PairingCode>()
    {
        assert_eq!(code.to_string().parse(), Ok(code));
        pairing = 1 << 40;
    }
    pairing | messages::<ClientMessage>(input) << 20 | messages::<ServerMessage>(input)
}

/// Messages that were read; each must be read again from what it is written as.
fn messages<M: Message + PartialEq + std::fmt::Debug>(input: &[u8]) -> u64 {
    let (mut decoder, mut read) = (Decoder::<M>::new(), 0);
    for piece in input.chunks(37) {
        decoder.push(piece);
        while let Some(message) = decoder.next_message() {
            if let Ok(message) = message {
                let line = encode(&message);
                assert_eq!(M::from_line(line.trim_end()), Ok(message));
                read += 1;
            }
        }
    }
    read
}

fn with_file(dir: &Path, name: &str, input: &[u8], read: impl FnOnce(&Path) -> u64) -> u64 {
    let path = dir.join(name);
    fs::write(&path, input).map_or(0, |()| read(&path))
}

/// Small pictures of each format that is read.
fn pictures() -> Vec<Vec<u8>> {
    let picture = crate::numbered::picture(7);
    let formats = [image::ImageFormat::Png, image::ImageFormat::Jpeg];
    let encoded = formats.map(|format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).ok();
        bytes.into_inner()
    });
    encoded.into()
}

/// Feeds one input; tells what went wrong, or how far it came.
///
/// # Errors
/// A panic, or an input that takes too long.
pub fn feed(target: Target, input: &[u8], dir: &Path) -> Result<u64, String> {
    let begun = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| target.feed(input, dir)));
    match outcome {
        Err(_) => Err("panic".to_owned()),
        Ok(_) if begun.elapsed() > MAX_TIME => Err(format!("took {:?}", begun.elapsed())),
        Ok(far) => Ok(far),
    }
}

/// Inputs of a target that are kept in the repository, with their files.
#[must_use]
pub fn kept(target: Target, folder: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let dir = root.join(folder).join(target.name());
    let entries = fs::read_dir(dir).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    let read = paths.into_iter().filter_map(|path| {
        let bytes = fs::read(&path).ok()?;
        Some((path, bytes))
    });
    read.collect()
}

/// Feeds one input in a temporary folder of this process, for a fuzzer that makes its inputs itself and catches panics.
///
/// # Panics
/// As [`Target::feed`], or when there can be no temporary folder.
pub fn feed_here(target: Target, input: &[u8]) {
    static DIR: OnceLock<PathBuf> = OnceLock::new();
    let dir = DIR.get_or_init(|| {
        let dir = std::env::temp_dir().join(format!("fuzz-{}", std::process::id()));
        fs::create_dir_all(&dir).expect("a temporary folder");
        dir
    });
    target.feed(input, dir);
}
