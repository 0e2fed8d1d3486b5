//! The disk is full, a folder can't be written, a file system turns read-only.

use std::{fs, path::Path, process::Command};

use acquirer::scan::ScanFolder;
use rig_tests::{ProjectorProgram, built_program};
use shared::stage::Stage;

use super::{assert_done, assert_fails, message, scan};

#[test]
fn a_disk_that_is_full_in_the_middle_is_told_and_the_scan_goes_on_when_it_is_not() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("scan");
    let projector = ProjectorProgram::headless().unwrap();
    let plain = scan(projector.address(), &out, root.path());
    let mut full = Command::new("strace");
    full.args(["-f", "-qq", "-o", "/dev/null"])
        // in the middle of the background, after the manifest and its notes
        .args([
            "-e",
            "trace=fsync",
            "-e",
            "inject=fsync:error=ENOSPC:when=30+",
        ])
        .arg(plain.get_program())
        .args(plain.get_args())
        .env("XDG_CONFIG_HOME", root.path());
    assert_fails(&full.output().unwrap(), "No space left on device");
    let folder = ScanFolder::open(&out).unwrap();
    assert!(!(folder.is_recorded(Stage::Background) && folder.is_recorded(Stage::Object)));
    let output = scan(projector.address(), &out, root.path())
        .arg("--resume")
        .output();
    assert_done(&output.unwrap());
    let check = Command::new(built_program("acquirer").unwrap())
        .arg("check")
        .arg(&out)
        .output();
    assert!(check.unwrap().status.success());
}

#[test]
fn a_folder_that_cannot_be_written_is_told_with_its_name() {
    let root = tempfile::tempdir().unwrap();
    let projector = ProjectorProgram::headless().unwrap();
    let out = Path::new("/proc/a-scan");
    let output = scan(projector.address(), out, root.path()).output();
    assert_fails(&output.unwrap(), "/proc/a-scan");
}

/// A disk of 1 MiB that a script has to itself: `$DISK` is where it is mounted, `scan [--resume]` records to `$DISK/scan`,
/// `told NAME COMMAND...` runs a command and tells its exit code and its messages.
const SMALL_DISK: &str = r#"
mount -t tmpfs -o size=1m rig "$DISK"
scan() { sh "$SCAN" "$@"; }
told() { name=$1; shift; said=$("$@" 2>&1 >/dev/null); printf '== %s\n%s\n%s\n' "$name" $? "$said"; }
"#;

/// Runs a script with a [`SMALL_DISK`] in a mount namespace; gives what it told. Nothing where the system makes none.
fn with_small_disk(script: &str) -> Option<String> {
    let may = Command::new("unshare").args(["--mount", "true"]).output();
    if !may.expect("unshare can be started").status.success() {
        eprintln!("SKIPPED: no mount namespaces here (they need root): no disk was filled");
        return None;
    }
    let root = tempfile::tempdir().unwrap();
    let [disk, command] = ["disk", "command"].map(|name| root.path().join(name));
    fs::create_dir(&disk).unwrap();
    let projector = ProjectorProgram::headless().unwrap();
    let plain = scan(projector.address(), &disk.join("scan"), root.path());
    let words = std::iter::once(plain.get_program()).chain(plain.get_args());
    let quoted: String = words.map(|word| format!("'{}' ", word.display())).collect();
    fs::write(&command, format!("exec {quoted} \"$@\"")).unwrap();
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", &format!("{SMALL_DISK}{script}")])
        .envs([("DISK", disk), ("SCAN", command)])
        .env("ACQUIRER", built_program("acquirer").unwrap())
        .env("PROJECTOR", built_program("projector").unwrap())
        .env("XDG_CONFIG_HOME", root.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", message(&output));
    Some(String::from_utf8(output.stdout).unwrap())
}

/// That a command of the script ended with this code, and said this.
#[track_caller]
fn assert_told(output: &str, name: &str, code: u32, message: &str) {
    let begin = format!("== {name}\n{code}\n");
    let (_, said) = output
        .split_once(&begin)
        .unwrap_or_else(|| panic!("{name}: {output}"));
    let said = said.split("\n== ").next().unwrap_or_default();
    assert!(said.contains(message), "{name}: {output}");
}

#[test]
fn a_disk_of_1_mib_is_told_and_the_scan_goes_on_when_there_is_room() {
    let script = r#"
told full scan
mount -o remount,size=64m "$DISK"
told room scan --resume
told check "$ACQUIRER" check "$DISK/scan"
"#;
    let Some(output) = with_small_disk(script) else {
        return;
    };
    assert_told(&output, "full", 1, "No space left on device");
    assert_told(&output, "room", 0, "");
    assert_told(&output, "check", 0, "");
}

#[test]
fn a_disk_that_turns_read_only_is_told_and_the_scan_goes_on_when_it_is_not() {
    let script = r#"
mount -o remount,size=64m "$DISK"
told middle scan --place-object 'mount -o remount,ro "$DISK"'
told still scan --resume
XDG_CONFIG_HOME=$DISK/home told projector "$PROJECTOR" --headless 640x480 --listen 0.0.0.0:0
mount -o remount,rw "$DISK"
told again scan --resume
told check "$ACQUIRER" check "$DISK/scan"
"#;
    let Some(output) = with_small_disk(script) else {
        return;
    };
    for name in ["middle", "still", "projector"] {
        assert_told(&output, name, 1, "Read-only file system");
    }
    assert_told(&output, "again", 0, "");
    assert_told(&output, "check", 0, "");
}
