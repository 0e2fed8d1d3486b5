//! The desktop: none, without a graphics driver, its windows closed, its monitor or itself gone.

use std::{
    fs::{self, File},
    path::Path,
    process::{Child, Command, Stdio},
    thread,
};

use acquirer::{
    projector_link::{LinkSettings, ProjectorLink},
    scan::ScanFolder,
};
use rig_tests::{ProjectorProgram, built_program};
use shared::{
    pattern::RasterSize,
    protocol::{Role, View},
    stage::Stage,
};

use super::{assert_done, assert_fails, desktop_client::Desktop, display::Display, scan, until};

const SIZE: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};

#[test]
fn without_a_display_both_programs_say_so() {
    for (program, arguments) in [
        (
            "projector",
            &["--windowed", "640x480", "--listen", "127.0.0.1:0"][..],
        ),
        ("acquirer", &["--camera", "sim:cube"]),
    ] {
        let projector = ProjectorProgram::headless().unwrap();
        let mut command = Command::new(built_program(program).unwrap());
        command.args(arguments);
        if program == "acquirer" {
            command.args(["--projector", projector.address()]);
        }
        let output = command
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .unwrap();
        assert_fails(&output, "DISPLAY");
    }
}

/// A program in its window on a display; what it says goes into a file.
fn in_window(name: &str, arguments: &[&str], environment: &[(&str, &str)], home: &Path) -> Child {
    let log = File::create(home.join(name)).unwrap();
    Command::new(built_program(name).unwrap())
        .args(arguments)
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_CONFIG_HOME", home)
        .envs(environment.iter().copied())
        .stdout(Stdio::null())
        .stderr(log)
        .spawn()
        .unwrap()
}

#[test]
fn without_a_graphics_driver_both_programs_say_what_to_install() {
    let display = Display::start(SIZE);
    let home = tempfile::tempdir().unwrap();
    let projector = ProjectorProgram::headless().unwrap();
    let acquirer = ["--camera", "sim:cube", "--projector", projector.address()];
    for (name, arguments) in [
        ("projector", &["--listen", "127.0.0.1:0"][..]),
        ("acquirer", &acquirer),
    ] {
        let output = Command::new(built_program(name).unwrap())
            .args(arguments)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_CONFIG_HOME", home.path())
            .envs(display.environment())
            .env("VK_ICD_FILENAMES", "/nowhere.json")
            .output()
            .unwrap();
        assert_fails(&output, "no graphics driver");
        assert_fails(&output, "mesa-vulkan-drivers");
    }
}

#[test]
fn a_desktop_that_ends_ends_both_windows_with_a_message() {
    let home = tempfile::tempdir().unwrap();
    let other = ProjectorProgram::headless().unwrap();
    let acquirer = ["--camera", "sim:cube", "--projector", other.address()];
    for (name, arguments) in [
        ("projector", &["--listen", "127.0.0.1:0"][..]),
        ("acquirer", &acquirer),
    ] {
        let display = Display::start(SIZE);
        let mut program = in_window(name, arguments, &display.environment(), home.path());
        Desktop::of(&display).window(name);
        drop(display);
        let status = program.wait().unwrap();
        let said = fs::read_to_string(home.path().join(name)).unwrap();
        assert_eq!(status.code(), Some(1), "{said}");
        // whoever notices first: the X library, or the program
        let told = ["the desktop ended", "X connection to", "on X server"];
        assert!(told.iter().any(|words| said.contains(words)), "{said}");
    }
    // what the projector showed for the window that ended stands, its place is free
    super::programs::controller(other.address());
}

#[test]
fn a_projector_whose_window_is_closed_in_the_middle_of_a_scan_is_told_and_the_scan_goes_on_with_the_next()
 {
    let root = tempfile::tempdir().unwrap();
    let [out, asked, closed] = ["scan", "asked", "closed"].map(|name| root.path().join(name));
    let display = Display::start(SIZE);
    let desktop = Desktop::of(&display);
    let mut projector = ProjectorProgram::full_screen(&display.environment()).unwrap();
    let window = desktop.window("projector");
    let place = format!(
        "touch {}; until [ -e {} ]; do sleep 0.1; done",
        asked.display(),
        closed.display()
    );
    let mut command = scan(projector.address(), &out, root.path());
    command.args(["--place-object", &place]);
    let recording = thread::spawn(move || command.output().unwrap());
    until("the object is asked for", || asked.exists().then_some(()));
    desktop.close(window);
    assert_eq!(projector.ended().unwrap().code(), Some(0));
    fs::write(&closed, "").unwrap();
    assert_fails(
        &recording.join().unwrap(),
        "the connection to the projector was lost",
    );

    let next = ProjectorProgram::headless().unwrap();
    let output = scan(next.address(), &out, root.path())
        .arg("--resume")
        .output();
    assert_done(&output.unwrap());
    let folder = ScanFolder::open(&out).unwrap();
    assert!(Stage::BOTH.iter().all(|&stage| folder.is_recorded(stage)));
}

#[test]
fn a_monitor_that_is_unplugged_is_told_and_shows_the_picture_when_it_is_back() {
    let display = Display::start(SIZE);
    let desktop = Desktop::of(&display);
    let projector = ProjectorProgram::full_screen(&display.environment()).unwrap();
    let settings = LinkSettings::new(projector.address(), "test", Role::Controller);
    let link = ProjectorLink::connect(&settings).unwrap();
    let problem = || link.state().unwrap().screen.problem;
    assert_eq!(problem(), None);
    let plug_in = desktop.unplug();
    let told = until("the missing monitor is told", problem);
    assert!(told.contains("plug it in again"), "{told}");
    // commands are taken meanwhile
    let shown = link.show(View::Coded).unwrap().shown;
    plug_in();
    until("the monitor is back", || problem().is_none().then_some(()));
    assert_eq!(link.state().unwrap().shown, shown);
    assert_eq!(display.window("projector").size(), SIZE);
    assert!(
        display.screenshot() == shown.pattern.raster(SIZE),
        "the picture is as it was"
    );
}
