//! A recording survives being killed at any moment, a write that fails at any call, and a power cut: what was said to
//! be recorded is there, whole, and nothing is half there.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::{
    collections::HashSet,
    fs,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::Duration,
};

use acquirer::scan::{ScanFolder, check_scan};
use rig_tests::{copy_folder, numbered};

/// Kills at random moments. With `NOTHING_LOST_KILLS` set, so many.
const KILLS: u32 = 500;
/// Captures after which a scan is begun anew, so that looking through it stays cheap.
const LONG_SCAN: usize = 60;

fn recorder() -> &'static str {
    env!("CARGO_BIN_EXE_capture_recorder")
}

/// What a recorder said before its end.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
struct Said {
    captures: u32,
    generation: u32,
}

impl Said {
    fn hear(&mut self, line: &str) {
        match line.split_once(' ') {
            Some(("capture", number)) => self.captures = number.parse::<u32>().unwrap() + 1,
            Some(("stage", generation)) => self.generation = generation.parse().unwrap(),
            _ => panic!("{line:?}"),
        }
    }
}

/// What is on disk, every picture read and compared; at most one step more than what was said.
fn look(dir: &Path, said: Said) -> Said {
    if !dir.join("scan.json").exists() {
        assert_eq!(said, Said::default(), "said to be recorded, and no scan");
        return said;
    }
    let folder = ScanFolder::open(dir).unwrap();
    let numbers = numbered::captures(&folder).unwrap();
    assert!(numbers.iter().copied().eq(0..numbers.len() as u32));
    let found = Said {
        captures: numbers.len() as u32,
        generation: numbered::generation(&folder).unwrap(),
    };
    let more = found.captures - said.captures + found.generation - said.generation;
    assert!(more <= 1, "{said:?} was said, {found:?} is there");
    let checked = check_scan(dir).unwrap();
    assert!(checked.intact, "{checked:?}");
    assert!(checked.without_checksum.is_empty(), "{checked:?}");
    found
}

#[test]
fn kills_at_random_moments_lose_nothing_that_was_recorded() {
    let kills = std::env::var("NOTHING_LOST_KILLS").map_or(KILLS, |kills| kills.parse().unwrap());
    let root = tempfile::tempdir().unwrap();
    let (mut dir, mut said) = (root.path().join("scan-0"), Said::default());
    let (mut recorded, mut random) = (0, 0x2545_f491_u32);
    for kill in 0..kills {
        let mut child = Command::new(recorder())
            .arg(&dir)
            .arg("100000")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let heard = thread::spawn(move || {
            let mut said = said;
            lines
                .map_while(Result::ok)
                .for_each(|line| said.hear(&line));
            said
        });
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        thread::sleep(Duration::from_micros(u64::from(random >> 16)));
        child.kill().unwrap();
        child.wait().unwrap();
        let before = said.captures;
        said = look(&dir, heard.join().unwrap());
        recorded += said.captures - before;
        if said.captures as usize > LONG_SCAN {
            (dir, said) = (root.path().join(format!("scan-{kill}")), Said::default());
        }
    }
    assert!(
        recorded > kills / 10,
        "the kills came before anything was recorded"
    );
    println!("{kills} kills, {recorded} captures, 0 bytes lost");
}

/// The calls by which a recording reaches the disk.
const CALLS: [&str; 5] = ["openat", "write", "fsync", "rename", "mkdir"];
/// Steps of a traced recording: captures, and a stage that is replaced.
const STEPS: &str = "3";

/// Runs the recorder under strace with these arguments of it.
fn traced(arguments: &[&str], dir: &Path) -> std::process::Output {
    Command::new("strace")
        .args(["-f", "-qq"])
        .args(arguments)
        .arg(recorder())
        .arg(dir)
        .arg(STEPS)
        .output()
        .expect("strace can be started (apt-get install strace)")
}

/// The trace of a recording that nothing disturbs, a line a call.
fn undisturbed(dir: &Path, calls: &str) -> Vec<String> {
    let trace = tempfile::NamedTempFile::new().unwrap();
    let to_file = ["-y", "-o", trace.path().to_str().unwrap(), "-e", calls];
    let output = traced(&to_file, dir);
    assert!(output.status.success(), "{output:?}");
    let text = fs::read_to_string(&trace).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// A scan with some captures and a replaced stage.
fn begun(root: &Path) -> (PathBuf, Said) {
    let dir = root.join("begun");
    let output = Command::new(recorder()).arg(&dir).arg("6").output();
    assert!(output.unwrap().status.success());
    let said = Said {
        captures: 6,
        generation: 1,
    };
    assert_eq!(look(&dir, said), said);
    (dir, said)
}

/// Disturbs every call that a recording makes, one a run, and looks at the scan after each.
fn disturb_every_call(how: &str) {
    let root = tempfile::tempdir().unwrap();
    let (base, said_before) = begun(root.path());
    let mut disturbed = 0;
    for call in CALLS {
        let copy = root.path().join(format!("{call}-whole"));
        copy_folder(&base, &copy).unwrap();
        let calls = undisturbed(&copy, &format!("trace={call}")).len();
        for number in 1..=calls {
            let dir = root.path().join(format!("{call}-{number}"));
            copy_folder(&base, &dir).unwrap();
            let inject = format!("inject={call}:{how}:when={number}");
            let output = traced(&["-o", "/dev/null", "-e", &inject], &dir);
            let mut said = said_before;
            String::from_utf8(output.stdout)
                .unwrap()
                .lines()
                .for_each(|line| said.hear(line));
            look(&dir, said);
            let again = Command::new(recorder())
                .arg(&dir)
                .arg("1")
                .output()
                .unwrap();
            assert!(again.status.success(), "{inject}: {again:?}");
            assert!(check_scan(&dir).unwrap().unfinished.is_empty(), "{inject}");
            fs::remove_dir_all(&dir).unwrap();
            disturbed += 1;
        }
    }
    assert!(disturbed > 40, "only {disturbed} calls were disturbed");
    println!("{how} at each of {disturbed} calls, 0 bytes lost");
}

#[test]
fn a_full_disk_at_any_call_leaves_what_was_recorded() {
    disturb_every_call("error=ENOSPC");
}

#[test]
fn a_broken_disk_at_any_call_leaves_what_was_recorded() {
    disturb_every_call("error=EIO");
}

#[test]
fn a_kill_at_any_call_leaves_what_was_recorded() {
    disturb_every_call("signal=SIGKILL");
}

#[test]
fn a_full_disk_is_told_with_the_file_and_leaves_no_half_file() {
    let root = tempfile::tempdir().unwrap();
    let (base, said) = begun(root.path());
    let output = traced(
        &["-o", "/dev/null", "-e", "inject=fsync:error=ENOSPC:when=1"],
        &base,
    );
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("prmvs-06.png") && message.contains("No space left"),
        "{message}"
    );
    assert_eq!(look(&base, said), said);
    assert!(check_scan(&base).unwrap().unfinished.is_empty());
}

/// What a power cut would leave is what was flushed. So every file must be flushed before it takes its name, and the
/// folder before anything is said or named that rests on it.
#[test]
fn everything_is_flushed_before_it_counts() {
    let root = tempfile::tempdir().unwrap();
    let root = fs::canonicalize(root.path()).unwrap();
    let dir = root.join("new/scan");
    let trace = undisturbed(&dir, "trace=write,fsync,rename,mkdir");
    let (mut unflushed, mut renames) = (HashSet::new(), 0);
    for line in &trace {
        let line = line.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ');
        let (call, rest) = line.split_once('(').unwrap();
        match call {
            "write" if rest.starts_with("1<") => {
                assert!(unflushed.is_empty(), "{line} although {unflushed:?}");
            }
            "write" => drop(unflushed.insert(descriptor(rest))),
            "fsync" => drop(unflushed.remove(&descriptor(rest))),
            "rename" => {
                assert!(unflushed.is_empty(), "{line} although {unflushed:?}");
                unflushed.insert(parent(rest.split('"').nth(3).unwrap()));
                renames += 1;
            }
            "mkdir" if line.ends_with("= 0") => {
                unflushed.insert(parent(rest.split('"').nth(1).unwrap()));
            }
            "mkdir" => {}
            other => panic!("{other}: {line}"),
        }
    }
    assert!(renames >= 6, "{trace:?}");
}

/// The path of the descriptor in `3</path/of/file>, ...`.
fn descriptor(rest: &str) -> String {
    let path = rest.split_once('<').unwrap().1.split('>').next();
    path.unwrap().to_owned()
}

fn parent(path: &str) -> String {
    Path::new(path).parent().unwrap().display().to_string()
}
