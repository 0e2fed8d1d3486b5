//! The whole rig with a real camera device: the acquirer in a guest machine with its own `/dev/video0`, the
//! projector on this machine, and between them the wire and the light of a simulated room. The guest runs all of
//! `acquirer scan`, from the latency to the report; its figures and labels are checked here against the room.
//!
//! ```text
//! projector --notices--> frame server --frames over TCP--> frame_feeder -> v4l2loopback -> acquirer scan
//!     ^--------------------------- requests over TCP, guest to host ---------------------------'
//! ```

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::io::ErrorKind;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Stdio};

use acquirer::camera::load_scene;
use acquirer::projector_link::{LinkSettings, ProjectorLink};
use acquirer::score::score_stage;
use rig_tests::frame_server::FrameServer;
use rig_tests::guest::{Device, Guest, built_program, section};
use rig_tests::{HeadlessProjector, read_vertices};
use shared::pattern::RasterSize;
use shared::protocol::Role;
use shared::simulation::Room;
use shared::stage::Stage;

/// Frames a second: few, since the guest decodes each in software emulation.
const RATE: u32 = 5;
const RASTER: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};

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

/// Records a scan in the guest; gives what the guest printed, the folder then lies in `into`.
fn scan_in_a_guest(projector: &HeadlessProjector, room: &FrameServer, into: &Path) -> String {
    let archive = TcpListener::bind("127.0.0.1:0").unwrap();
    let script = format!(
        r#"frame_feeder /dev/video0 tcp 10.0.2.2:{frames} & feeder=$!
wait-fed
echo "== cameras"; acquirer cameras --json
echo "== scan"
# a tunnel, as by ssh: the projector serves its own computer alone, and the guest's end is the guest's own
nc -ll -p 4460 -e nc 10.0.2.2 {projector} & sleep 1
acquirer scan --projector 127.0.0.1:4460 --camera /dev/video0 --out /tmp/scan --json \
    --place-object 'echo object | nc 10.0.2.2 {stages} | grep done' >/tmp/figures 2>/tmp/log & scan=$!
# once all is recorded the emulated processor is wanted for reading
while ! grep -q "recorded object" /tmp/log && kill -0 $scan 2>/dev/null; do sleep 0.5; done
kill $feeder
wait $scan; code=$?
cat /tmp/log /tmp/figures
tar -c -C /tmp scan | nc 10.0.2.2 {archive}
exit $code"#,
        frames = room.frame_port(),
        stages = room.stage_port(),
        projector = projector.port(),
        archive = archive.local_addr().unwrap().port(),
    );
    let guest = Guest::with(Device::Loopback)
        .program(env!("CARGO_BIN_EXE_acquirer"))
        .program(built_program("frame_feeder").unwrap());
    let into = into.to_owned();
    let taking = std::thread::spawn(move || take_archive(&archive, &into));
    let output = guest
        .run(&script)
        .unwrap_or_else(|error| panic!("{error:#}"));
    taking.join().unwrap();
    output
}

#[test]
fn a_scan_through_a_real_camera_device_reads_the_room_right() {
    let projector = HeadlessProjector::start().unwrap();
    let room = FrameServer::start("cube", projector.address(), RATE).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let output = scan_in_a_guest(&projector, &room, folder.path());
    let cameras = &section(&output, "cameras")[0]["cameras"];
    assert_eq!(cameras[0]["path"], "/dev/video0", "{output}");

    let scan = folder.path().join("scan");
    let figures = &section(&output, "scan")[0];
    assert!(
        scan.join("results/report.html").exists(),
        "the scan in the guest ends with its report: {output}"
    );
    let link = LinkSettings::new(projector.address(), "test", Role::Watcher);
    let grid = ProjectorLink::connect(&link)
        .unwrap()
        .first_state()
        .grid
        .clone();
    let scene = load_scene("cube").unwrap();
    for stage in Stage::BOTH {
        let vertices = read_vertices(&scan.join("results"), stage).unwrap();
        let truth = Room::new(&scene, stage).truth(&grid.coded, RASTER);
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
