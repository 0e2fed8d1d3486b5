//! A small room, lit by a scripted projector on a real socket.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};

use shared::pattern::{Pattern, RasterSize, Rgb};
use shared::protocol::{ServerMessage, encode};

use super::*;
use crate::camera::controls::ids;

/// A grey wall, and before it a white box in the second stage.
const ROOM: &str = r##"
title = "test room"
[camera]
width = 64
height = 48
focal_px = [69.0, 69.0]
centre_px = [32.0, 24.0]
position_mm = [0.0, 0.0, 0.0]
looks_at_mm = [0.0, 0.0, 1000.0]
frame_rate_hz = 50.0
exposure_ms = 5.0
[projector]
width = 64
height = 48
focal_px = [60.0, 60.0]
centre_px = [32.0, 24.0]
position_mm = [20.0, 0.0, 0.0]
looks_at_mm = [0.0, 0.0, 1000.0]
display_latency_ms = 80.0
[ambient]
[[solids]]
name = "wall"
position_mm = [0.0, 0.0, 1000.0]
plane = { size_mm = [4000.0, 4000.0] }
surface = { colour = "#808080" }
[[solids]]
name = "box"
when = "object"
position_mm = [0.0, 0.0, 900.0]
box = { size_mm = [200.0, 200.0, 100.0] }
surface = { colour = "#ffffff" }
"##;

const STATE: &str = r##"{"screen":{"kind":"headless","name":"headless","raster":{"width":64,"height":48}},"grid":{"rows":15,"columns":15,"row_width_px":6,"column_width_px":6,"colours":["#ff0000","#ffff00","#ff00ff","#00ff00"],"unary":"#ffffff"},"view":{"kind":"black"},"blank":false,"shown":{"serial":1,"pattern":{"kind":"solid","colour":"#000000"},"raster":{"width":64,"height":48},"presented_ns":1000}}"##;

const SOON: Duration = Duration::from_secs(20);

/// A projector that says what the test wants it to say.
struct Projector {
    listener: TcpListener,
}

impl Projector {
    fn new() -> Self {
        Self {
            listener: TcpListener::bind("127.0.0.1:0").unwrap(),
        }
    }

    fn address(&self) -> String {
        self.listener.local_addr().unwrap().to_string()
    }

    /// Accepts the watcher that the camera is.
    fn welcome(&self) -> TcpStream {
        let (mut stream, _) = self.listener.accept().unwrap();
        let mut hello = String::new();
        BufReader::new(&stream).read_line(&mut hello).unwrap();
        assert!(hello.contains("\"watcher\""), "{hello}");
        let welcome = format!(
            "{{\"type\":\"welcome\",\"version\":1,\"role\":\"watcher\",\"state\":{STATE}}}\n"
        );
        stream.write_all(welcome.as_bytes()).unwrap();
        stream
    }
}

/// Opens the room in front of a projector; gives the camera and the projector's end of the wire.
fn open(projector: &Projector) -> (SimulatedCamera, TcpStream) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.toml");
    std::fs::write(&file, ROOM).unwrap();
    std::thread::scope(|threads| {
        let wire = threads.spawn(|| projector.welcome());
        let camera = SimulatedCamera::open(file.to_str().unwrap(), &projector.address()).unwrap();
        (camera, wire.join().unwrap())
    })
}

fn show_white(wire: &mut TcpStream) {
    let raster = RasterSize {
        width: 64,
        height: 48,
    };
    let pattern = Pattern::Solid {
        colour: Rgb([255; 3]),
    };
    let shown = Shown {
        serial: 2,
        pattern,
        raster,
        presented_ns: 5,
    };
    wire.write_all(encode(&ServerMessage::Shown(shown)).as_bytes())
        .unwrap();
}

/// Green in the middle of the picture, where the object would stand.
fn middle(frame: &Frame) -> u8 {
    frame.picture.get_pixel(32, 24).0[1]
}

#[test]
fn light_follows_a_notice_after_the_displays_latency() {
    let projector = Projector::new();
    let (mut camera, mut wire) = open(&projector);
    let dark = middle(&camera.next_frame(SOON).unwrap());
    let sent = monotonic_now();
    show_white(&mut wire);
    let latency = Duration::from_millis(80);
    let lit = loop {
        let frame = camera.next_frame(SOON).unwrap();
        // The stamp is the end of the exposure: until then no light can have come.
        if frame.captured_at <= sent + latency {
            assert_eq!(middle(&frame), dark);
        }
        if middle(&frame) > dark + 60 {
            break frame;
        }
    };
    assert!(lit.captured_at > sent + latency);
    assert!(lit.number > 0);
}

#[test]
fn the_object_stands_in_the_room_for_its_stage_only() {
    let projector = Projector::new();
    let (mut camera, mut wire) = open(&projector);
    show_white(&mut wire);
    while middle(&camera.next_frame(SOON).unwrap()) < 60 {}
    let wall = middle(&camera.frame_after(monotonic_now(), SOON).unwrap());
    camera.expect(Shows::White, Stage::Object);
    let object = middle(&camera.frame_after(monotonic_now(), SOON).unwrap());
    camera.expect(Shows::White, Stage::Background);
    let wall_again = middle(&camera.frame_after(monotonic_now(), SOON).unwrap());
    assert!(object > wall + 30, "wall {wall}, object {object}");
    assert!(wall_again.abs_diff(wall) <= 2);
}

#[test]
fn frames_go_on_when_the_projector_goes_and_it_is_found_again() {
    let projector = Projector::new();
    let (mut camera, wire) = open(&projector);
    drop(wire);
    let before = camera.next_frame(SOON).unwrap().number;
    let mut wire = std::thread::scope(|threads| {
        let wire = threads.spawn(|| projector.welcome());
        while !wire.is_finished() {
            camera.next_frame(SOON).unwrap();
        }
        wire.join().unwrap()
    });
    show_white(&mut wire);
    while middle(&camera.next_frame(SOON).unwrap()) < 60 {}
    assert!(camera.next_frame(SOON).unwrap().number > before);
}

#[test]
fn without_a_projector_there_is_no_room() {
    let spec = "sim:cube".parse().unwrap();
    let settings = crate::camera::CameraSettings::default();
    let Err(error) = crate::camera::open_camera(&spec, &settings, None) else {
        panic!("opened")
    };
    assert!(error.to_string().contains("--projector"), "{error}");
}

#[test]
fn twice_the_exposure_is_twice_the_light_and_gain_amplifies() {
    let projector = Projector::new();
    let (mut camera, mut wire) = open(&projector);
    show_white(&mut wire);
    while middle(&camera.next_frame(SOON).unwrap()) < 60 {}
    let mut light = |id: u32, value: i64| {
        assert_eq!(camera.set_control(id, value).unwrap(), value);
        // the frame that is being exposed still has the old setting
        camera.frame_after(monotonic_now(), SOON).unwrap();
        let frame = camera.frame_after(monotonic_now(), SOON).unwrap();
        (f64::from(middle(&frame)) / 255.0).powf(2.2)
    };
    let whole = light(ids::EXPOSURE_TIME, 50);
    let half = light(ids::EXPOSURE_TIME, 25);
    assert!((1.8..2.2).contains(&(whole / half)), "{whole} and {half}");
    let amplified = light(ids::GAIN, 32);
    assert!((0.9..1.1).contains(&(amplified / whole)), "{amplified}");
}

#[test]
fn automatics_settle_have_their_values_in_hand_and_can_be_held() {
    let projector = Projector::new();
    let (mut camera, mut wire) = open(&projector);
    show_white(&mut wire);
    while middle(&camera.next_frame(SOON).unwrap()) < 60 {}
    let fixed = middle(&camera.next_frame(SOON).unwrap());
    camera.set_control(ids::AUTO_EXPOSURE, 3).unwrap();
    let refused = camera.set_control(ids::EXPOSURE_TIME, 10).unwrap_err();
    assert!(refused.to_string().contains("automatic"), "{refused}");
    let automatic = |camera: &mut SimulatedCamera| {
        for _ in 0..30 {
            camera.next_frame(SOON).unwrap();
        }
        middle(&camera.next_frame(SOON).unwrap())
    };
    let settled = automatic(&mut camera);
    assert!(settled.abs_diff(fixed) > 8, "{fixed}, then {settled}");
    let held = camera.hold_automatics().unwrap();
    assert!(held.iter().all(|held| held.refused.is_none()), "{held:?}");
    let controls = camera.controls().unwrap();
    assert!(controls.iter().all(|control| !control.inactive));
    assert!(automatic(&mut camera).abs_diff(settled) <= 3);
}
