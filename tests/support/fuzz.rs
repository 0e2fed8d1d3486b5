//! Broken input for everything that reads bytes from outside: valid files, mutated at random over and over.
//!
//! Each target reads its input as the programs do; whatever comes, it must end, soon, without a panic. The changes are
//! those of a usual fuzzer (bits, bytes, runs, numbers at their limits, words of the format, pieces of other inputs),
//! without its measure of coverage: that wants a compiler of another channel. An input that gets a target further than
//! the rest, by its own account of what it read, joins the corpus.

use std::{
    collections::HashSet,
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
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
    /// `calibration.json`.
    Calibration,
    /// Shift tables.
    Csv,
    /// PNG and JPEG pictures.
    Image,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Codec,
        Self::Scan,
        Self::Configuration,
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
            Self::Calibration => "calibration",
            Self::Csv => "csv",
            Self::Image => "image",
        }
    }

    /// Valid inputs to begin with, from the repository.
    fn seeds(self) -> Vec<Vec<u8>> {
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

    /// Reads an input as the programs do; gives a number that tells how far it came.
    fn feed(self, input: &[u8], dir: &Path) -> u64 {
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
                let config = u64::from(Config::load(Some(path)).is_ok());
                let text = String::from_utf8_lossy(input);
                let palette = u64::from(Palette::from_toml(&text).is_ok());
                let scene = u64::from(load_scene(&path.display().to_string()).is_ok());
                config | palette << 1 | scene << 2
            }),
            Self::Calibration => RigCalibration::from_json(input).map_or(0, |calibration| {
                u64::from(calibration.to_json().is_ok()) + 1
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

/// What a run found.
#[derive(Debug, Default)]
pub struct Found {
    /// Inputs that were fed.
    pub inputs: u64,
    /// Inputs that got further than others before.
    pub corpus: Vec<Vec<u8>>,
    /// Inputs that made the target panic or took too long, with what happened.
    pub failures: Vec<(Vec<u8>, String)>,
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

/// Feeds mutated inputs for some time.
///
/// # Errors
/// No temporary folder.
pub fn run(target: Target, time: Duration, seed: u64) -> anyhow::Result<Found> {
    let dir = tempfile::tempdir()?;
    let mut random = Random(seed | 1);
    let mut pool = target.seeds();
    pool.extend(kept(target, "corpus").into_iter().map(|(_, input)| input));
    let (mut seen, mut found) = (HashSet::new(), Found::default());
    for input in &pool {
        seen.extend(feed(target, input, dir.path()));
    }
    let begun = Instant::now();
    while begun.elapsed() < time {
        let input = mutated(&pool, &mut random);
        found.inputs += 1;
        match feed(target, &input, dir.path()) {
            Ok(far) if seen.len() < 4096 && seen.insert(far) => {
                pool.push(input.clone());
                found.corpus.push(input);
            }
            Ok(_) => {}
            Err(what) => found.failures.push((input, what)),
        }
    }
    Ok(found)
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

/// Pieces that mean something in one of the formats, or stand at a limit.
const WORDS: [&[u8]; 24] = [
    b"-1",
    b"0",
    b"1e308",
    b"1e400",
    b"NaN",
    b"18446744073709551616",
    b"4294967295",
    b"9007199254740993",
    b"60000",
    b"1000000000",
    b"null",
    b"true",
    b"{}",
    b"[]",
    b"\"\"",
    b"\"#ffffff\"",
    b"../../etc/passwd",
    b"\xff\xfe",
    b"\\ud800",
    b"\n",
    b"[[a]]\n",
    b"=",
    b",,,",
    b"\x00\x00\x00\x00",
];

fn mutated(pool: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut input = pool[random.below(pool.len())].clone();
    for _ in 0..=random.below(6) {
        let at = random.below(input.len() + 1);
        let end = (at + 1 + random.below(16)).min(input.len());
        match random.below(8) {
            0 if at < input.len() => input[at] ^= 1 << random.below(8),
            1 if at < input.len() => input[at] = random.below(256) as u8,
            2 if at < end => drop(input.drain(at..end)),
            3 => insert(&mut input, at, WORDS[random.below(WORDS.len())]),
            4 if at < end => {
                let word = WORDS[random.below(WORDS.len())];
                input.splice(at..end, word.iter().copied());
            }
            5 if at < end => {
                let run = input[at..end].repeat(1 + random.below(64));
                insert(&mut input, at, &run);
            }
            6 => {
                let other = &pool[random.below(pool.len())];
                let from = random.below(other.len() + 1);
                let to = (from + random.below(256)).min(other.len());
                insert(&mut input, at, &other[from..to]);
            }
            _ => input.truncate(at.max(1)),
        }
    }
    input.truncate(MAX_BYTES);
    input
}

fn insert(input: &mut Vec<u8>, at: usize, piece: &[u8]) {
    input.splice(at..at, piece.iter().copied());
}

/// xorshift (Marsaglia 2003): the same seed gives the same inputs.
struct Random(u64);

impl Random {
    /// 0 to `limit` - 1.
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) % limit.max(1) as u64) as usize
    }
}
