//! The whole rig with a real window and a real camera device: the projector's window fills a display of this machine
//! that nobody sees, the acquirer runs in a guest machine with its own `/dev/video0`, and between them are the wire and
//! the light of a simulated room. The guest reads live for some frames and then runs all of `acquirer scan`, from the
//! latency and the choice of colours to the report; its figures and labels are checked here against the room. The room
//! is lit by what the projector tells that it shows, and every such picture is compared with the window's own pixels.
//! All the while the guest's clock jumps by hours, for the acquirer with its camera, and at the end for another
//! projector program in the guest.
//!
//! ```text
//! projector --notices--> frame server --frames over TCP--> frame_feeder -> v4l2loopback -> acquirer
//!  | window  ^--------------------------- requests over TCP, guest to host ----------------------'
//!  '-> Xvfb --screenshots--> compared with the notices
//! ```

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

#[allow(dead_code, reason = "there is no mouse here")]
#[path = "projector_support/display.rs"]
mod display;

use std::io::ErrorKind;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use acquirer::camera::load_scene;
use acquirer::projector_link::{LinkSettings, Notice, ProjectorLink};
use acquirer::score::score_stage;
use display::Display;
use rig_tests::frame_server::FrameServer;
use rig_tests::guest::{Device, Guest, built_program};
use rig_tests::told::section;
use rig_tests::{ProjectorProgram, read_vertices};
use shared::pattern::RasterSize;
use shared::protocol::{Role, ScreenKind};
use shared::simulation::Room;
use shared::stage::Stage;

/// Frames a second: few, since the guest decodes each in software emulation, perhaps on a busy machine.
const RATE: u32 = 2;
const RASTER: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};

/// By how much the guest's clock is set forwards and back, twice a second.
const JUMP_S: u32 = 7 * 3600;

/// Flashes for the latency: fewer than usual, since each takes long at that rate.
const QUICK: &str = "[latency]\\nflashes = 8\\n";

/// Pictures that the window was told to show, and those that it did.
#[derive(Debug, Default, PartialEq, Eq)]
struct Compared {
    same: usize,
    other: Vec<String>,
}

/// Compares the display with every picture that the projector says is shown, until told to stop. A picture may have
/// been followed by the next one before the screenshot was taken.
fn compare_window(display: &Display, link: &ProjectorLink, stop: &AtomicBool) -> Compared {
    let mut compared = Compared::default();
    while !stop.load(Ordering::Relaxed) {
        let notice = link.next_notice(Duration::from_millis(100)).unwrap();
        let Some(Notice::Shown { mut shown, .. }) = notice else {
            continue;
        };
        let seen = display.screenshot();
        let deadline = Instant::now() + Duration::from_secs(10);
        while seen != shown.pattern.raster(shown.raster) && Instant::now() < deadline {
            if let Some(Notice::Shown { shown: next, .. }) =
                link.next_notice(Duration::from_millis(100)).unwrap()
            {
                shown = next;
            }
        }
        if Instant::now() < deadline {
            compared.same += 1;
        } else {
            compared.other.push(format!("{shown:?}"));
        }
    }
    compared
}

/// Takes what the guest sends over TCP as a tar archive and unpacks it into a folder.
fn take_archive(listener: &TcpListener, into: &Path) {
    let (stream, _) = listener.accept().unwrap();
    let mut tar = Command::new("tar")
        .arg("-x")
        .current_dir(into)
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let copied = std::io::copy(&mut &stream, &mut tar.stdin.take().unwrap());
    assert!(tar.wait().unwrap().success());
    match copied {
        // tar may leave at the archive's end mark, before the padding behind it has come
        Err(error) if error.kind() == ErrorKind::BrokenPipe => {
            std::io::copy(&mut &stream, &mut std::io::sink()).unwrap();
        }
        copied => assert!(copied.unwrap() > 0),
    }
}

/// Reads live and records a scan in the guest; gives what the guest printed, the folder then lies in `into`.
fn work_in_a_guest(
    projector: &ProjectorProgram,
    room: &FrameServer,
    into: &Path,
) -> anyhow::Result<String> {
    let archive = TcpListener::bind("127.0.0.1:0").unwrap();
    let script = format!(
        r#"step={JUMP_S}
while date -s "@$(($(date +%s) + step))"; do step=$((-step)); sleep 0.5; done >/tmp/jumps 2>&1 &
frame_feeder /dev/video0 tcp 10.0.2.2:{frames} & feeder=$!
wait-fed
echo "== cameras"; acquirer cameras --controls --json
printf '{QUICK}' >/tmp/quick.toml
export RUST_LOG=info
# a tunnel, as by ssh: the projector serves its own computer alone, and the guest's end is the guest's own
nc -ll -p 4460 -e nc 10.0.2.2 {projector} & sleep 1
rig="--projector 127.0.0.1:4460 --camera /dev/video0 --config /tmp/quick.toml --json"
echo "== live"
acquirer live $rig --mode dynamic --frames 4 || exit
kept() {{ v4l2-ctl -d /dev/video0 -C keep_format; }}
echo "== interrupted"; kept
acquirer live $rig --control keep_format=on >/tmp/live 2>&1 & live=$!
while ! kept | grep -q 1 && kill -0 $live 2>/dev/null; do sleep 0.5; done
kept; kill -INT $live; wait $live; kept
echo "== scan"
acquirer scan $rig --pick-colours --out /tmp/scan \
    --place-object 'echo object | nc 10.0.2.2 {stages} | grep done' >/tmp/figures 2>/tmp/log & scan=$!
# once all is recorded the emulated processor is wanted for reading
while ! grep -q "recorded object" /tmp/log && kill -0 $scan 2>/dev/null; do sleep 0.5; done
kill $feeder
wait $scan; code=$?
cat /tmp/log /tmp/figures
echo "== projector"
projector --headless 1024x768 --listen 127.0.0.1:4461 >/tmp/projector 2>&1 & projector=$!
while ! grep -q listening /tmp/projector && kill -0 $projector; do sleep 0.5; done
acquirer live --projector 127.0.0.1:4461 --camera replay:/tmp/scan --frames 2 --json
kill $projector; wait $projector; echo "== jumps"; wc -l </tmp/jumps
tar -c -C /tmp scan | nc 10.0.2.2 {archive}
exit $code"#,
        frames = room.frame_port(),
        stages = room.stage_port(),
        projector = projector.port(),
        archive = archive.local_addr().unwrap().port(),
    );
    let guest = Guest::with(Device::Loopback)
        .for_seconds(1200)
        .program(env!("CARGO_BIN_EXE_acquirer"))
        .program(built_program("frame_feeder").unwrap())
        .program(built_program("projector").unwrap());
    let into = into.to_owned();
    let taking = std::thread::spawn(move || take_archive(&archive, &into));
    let output = guest.run(&script)?;
    taking.join().unwrap();
    Ok(output)
}

#[test]
fn a_rig_with_a_real_window_and_a_real_camera_device_reads_the_room_right() {
    let display = Display::start(RASTER);
    let projector = ProjectorProgram::full_screen(&display.environment()).unwrap();
    let room = FrameServer::start("cube", projector.address(), RATE).unwrap();
    let watcher = LinkSettings::new(projector.address(), "test", Role::Watcher);
    let link = ProjectorLink::connect(&watcher).unwrap();
    assert_eq!(link.first_state().screen.kind, ScreenKind::FullScreen);
    assert_eq!(display.window("projector").size(), RASTER);
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let (output, compared) = std::thread::scope(|scope| {
        let comparing = scope.spawn(|| compare_window(&display, &link, &stop));
        let output = work_in_a_guest(&projector, &room, folder.path());
        stop.store(true, Ordering::Relaxed);
        (output, comparing.join().unwrap())
    });
    let output = output.unwrap_or_else(|error| panic!("{error:#}"));
    let cameras = &section(&output, "cameras")[0]["cameras"];
    assert_eq!(cameras[0]["path"], "/dev/video0", "{output}");
    assert_eq!(compared.other, Vec::<String>::new());
    assert!(compared.same > 40, "{compared:?}");

    let live = section(&output, "live");
    assert_eq!(live.len(), 4, "{output}");
    for frame in &live {
        assert_eq!(frame["pattern"], "coded", "{frame}");
        assert!(frame["crossings"].as_u64() > Some(150), "{frame}");
    }
    let jumps = section(&output, "jumps")[0].as_u64();
    assert!(jumps > Some(20), "the clock was set: {output}");
    let under_jumps = section(&output, "projector");
    assert_eq!(under_jumps.len(), 2, "{output}");
    let controls = cameras[0]["controls"].as_array().unwrap();
    let keep = controls
        .iter()
        .find(|control| control["key"] == "keep_format");
    assert_eq!(keep.unwrap()["kind"], "switch");
    let kept = output
        .lines()
        .filter_map(|line| line.trim_end().strip_prefix("keep_format: "));
    assert_eq!(
        kept.collect::<Vec<_>>(),
        ["0", "1", "0"],
        "a control set for a command is set back when it is interrupted: {output}"
    );

    let scan = folder.path().join("scan");
    let figures = &section(&output, "scan")[0];
    assert!(
        scan.join("results/report.html").exists(),
        "the scan in the guest ends with its report: {output}"
    );
    let state = ProjectorLink::connect(&watcher).unwrap();
    let state = state.first_state();
    let choice = std::fs::read(scan.join("colours.json")).unwrap();
    let choice: serde_json::Value = serde_json::from_slice(&choice).unwrap();
    let shown = serde_json::to_value(state.grid.coded.colours()).unwrap();
    assert_eq!(shown, choice["best"], "the grid took the choice");
    let scene = load_scene("cube").unwrap();
    for stage in Stage::BOTH {
        let vertices = read_vertices(&scan.join("results"), stage).unwrap();
        let truth = Room::new(&scene, stage).truth(&state.grid.coded, RASTER);
        let score = score_stage(&truth, &vertices, stage);
        assert_eq!(score.wrong, 0, "{}", score.sentence());
        assert!(score.coverage_percent > 80.0, "{}", score.sentence());
        let labelled = &figures["summary"][stage.name()]["crossings_labelled"];
        assert_eq!(
            labelled.as_u64(),
            Some(score.reported as u64 / 4),
            "the figures printed in the guest are those of its tables"
        );
    }
}
