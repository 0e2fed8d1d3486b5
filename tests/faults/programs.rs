//! Either program is killed.

use std::{
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use acquirer::{
    projector_link::{LinkError, LinkSettings, ProjectorLink},
    scan::ScanFolder,
};
use rig_tests::{ProjectorProgram, built_program};
use shared::{
    protocol::{Role, View},
    stage::Stage,
};

use super::{PATIENCE, assert_done, assert_fails, pair, recorded, scan};

/// As the controller, as soon as the place is free.
pub(super) fn controller(address: &str) -> ProjectorLink {
    let settings = LinkSettings::new(address, "next", Role::Controller);
    let deadline = Instant::now() + PATIENCE;
    loop {
        match ProjectorLink::connect(&settings) {
            Ok(link) => return link,
            Err(LinkError::Taken(_)) if Instant::now() < deadline => {
                thread::sleep(Duration::from_millis(50));
            }
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn a_projector_killed_in_the_middle_of_a_scan_is_told_and_the_scan_goes_on_with_the_next() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("scan");
    let home = root.path().join("projector");
    let projector = ProjectorProgram::on_network(&home, "0").unwrap();
    let port = projector.port().to_owned();
    pair(&projector, projector.address(), &home, root.path());
    let address = projector.address().to_owned();
    // when the object is to be placed, the background is recorded
    let kill = format!("kill -9 {}", projector.process());
    let output = scan(&address, &out, root.path())
        .args(["--place-object", &kill])
        .output()
        .unwrap();
    assert_fails(&output, "the connection to the projector was lost");
    assert!(
        ScanFolder::open(&out)
            .unwrap()
            .is_recorded(Stage::Background)
    );
    let output = scan(&address, &out, root.path()).arg("--resume").output();
    assert_fails(&output.unwrap(), "no projector program listens");

    drop(projector);
    let again = ProjectorProgram::on_network(&home, &port).unwrap();
    assert_eq!(again.address(), address);
    let output = scan(&address, &out, root.path()).arg("--resume").output();
    assert_done(&output.unwrap());
    assert!(ScanFolder::open(&out).unwrap().is_recorded(Stage::Object));
}

#[test]
fn an_acquirer_killed_at_any_moment_leaves_the_picture_and_the_place() {
    let projector = ProjectorProgram::headless().unwrap();
    for moment_ms in [150, 600, 1500] {
        let mut killed = Command::new(built_program("acquirer").unwrap())
            .args(["live", "--json", "--projector", projector.address()])
            .args(["--camera", &format!("replay:{}", recorded().display())])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(Duration::from_millis(moment_ms));
        killed.kill().unwrap();
        killed.wait().unwrap();
        let link = controller(projector.address());
        let before = link.state().unwrap().shown;
        thread::sleep(Duration::from_millis(200));
        assert_eq!(link.state().unwrap().shown, before, "it stands");
        link.show(View::White).unwrap();
    }
}
