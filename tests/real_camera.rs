//! The acquirer's camera on real V4L2 devices: the kernel's test driver and v4l2loopback, in a
//! guest machine.
//!
//! Each device is booted once; its script causes one trouble after another, and each test reads
//! what the camera made of one of them. No figure of time is asserted tighter than a guest in
//! software emulation on a busy machine keeps it.

#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests fail by panicking, as tests do"
)]

use std::path::Path;
use std::sync::LazyLock;

use image::codecs::jpeg::JpegEncoder;
use image::{Rgb, RgbImage};
use rig_tests::guest::{Device, Guest, section};
use serde_json::Value;

const PROBE: &str = env!("CARGO_BIN_EXE_camera_probe");
const FEEDER: &str = env!("CARGO_BIN_EXE_frame_feeder");

/// Small frames, so that the slow guest keeps up.
const VIVID: &str = r#"
part() { echo "== $1"; }
capture() { camera_probe capture /dev/video0 --width 320 --height 180 "$@"; }
# begin: captures in the background, returns when the first frame has come
begin() { rm -f /tmp/mark /tmp/over; capture --mark /tmp/mark --after /tmp/over --patience-ms 400 "$@" & probe=$!
    while [ ! -e /tmp/mark ] && kill -0 $probe 2>/dev/null; do sleep 0.1; done; }
# over: the trouble has been caused; some more frames, then the end
over() { touch /tmp/over; wait $probe; }
set_control() { v4l2-ctl -d /dev/video0 -c $1; }
part list; camera_probe list
set_control osd_text_mode=2 # colour bars alone
for format in YUYV NV12 RGB3 BGR3 GREY; do part $format; capture --frames 3 --format $format; done
part hold; v4l2-ctl -d /dev/video0 -C gain_automatic
begin --frames 1 --hold; v4l2-ctl -d /dev/video0 -C gain_automatic; over
v4l2-ctl -d /dev/video0 -C gain_automatic
part fractional-rate; v4l2-ctl -d /dev/video0 --set-fmt-video=width=320,height=180,pixelformat=YUYV >/dev/null
v4l2-ctl -d /dev/video0 --set-parm=12.5; capture --frames 2 --rate 13; capture --frames 2
part busy; v4l2-ctl -d /dev/video0 --set-fmt-video=width=640,height=360 >/dev/null
v4l2-ctl -d /dev/video0 --stream-mmap >/dev/null 2>&1 & other=$!; sleep 2
capture --frames 2; kill $other; wait $other 2>/dev/null
part broken-frames; begin --frames 3
for i in 1 2 3; do set_control inject_v4l2_buf_flag_error=1; sleep 0.3; done; over
part stall; begin --frames 3
set_control percentage_of_dropped_buffers=100; sleep 5; set_control percentage_of_dropped_buffers=0; over
part fatal-error; begin --frames 3; set_control inject_fatal_streaming_error=1; sleep 1; over
part unplugged; begin --frames 3; unplug; sleep 2; replug; over
part no-camera; unplug; capture --frames 1
"#;

const LOOPBACK: &str = r#"
part() { echo "== $1"; }
fed() { frame_feeder /dev/video0 "$@" & feeder=$!; wait-fed; }
done_feeding() { kill $feeder 2>/dev/null; wait $feeder 2>/dev/null; loop-load; }
part unfed; camera_probe list; camera_probe capture /dev/video0 --frames 1
part steps; fed steps 640 480 15 400; camera_probe list; camera_probe capture /dev/video0 --frames 10; done_feeding
part pause; fed steps 640 480 15 400 --pause-after 20 --pause-ms 4000
camera_probe capture /dev/video0 --frames 30 --patience-ms 500; done_feeding
part jpeg; fed files MJPG 320 240 10 400 /whole.jpg /cut.jpg /garbage.jpg /small.jpg
camera_probe capture /dev/video0 --frames 5 --width 320 --height 240; done_feeding
"#;

fn boot(device: Device, script: &str, files: &[&Path]) -> String {
    let guest = Guest::with(device).program(PROBE).program(FEEDER);
    let guest = files.iter().fold(guest, |guest, file| guest.file(file));
    guest
        .run(script)
        .unwrap_or_else(|error| panic!("{error:#}"))
}

static ON_VIVID: LazyLock<String> = LazyLock::new(|| boot(Device::Vivid, VIVID, &[]));
static ON_LOOPBACK: LazyLock<String> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let whole = jpeg(320, 240);
    let cut = file("cut.jpg", &whole[..whole.len() / 2]);
    let garbage = file("garbage.jpg", &[0xa5; 20_000]);
    let small = file("small.jpg", &jpeg(160, 120));
    let whole = file("whole.jpg", &whole);
    boot(
        Device::Loopback,
        LOOPBACK,
        &[&whole, &cut, &garbage, &small],
    )
});

/// A red picture as JPEG, long enough that half of it is not all header.
fn jpeg(width: u32, height: u32) -> Vec<u8> {
    let mut file = Vec::new();
    let picture = RgbImage::from_fn(width, height, |x, y| {
        Rgb([200, (x * 7 % 40) as u8, (y * 5 % 40) as u8])
    });
    JpegEncoder::new_with_quality(&mut file, 95)
        .encode_image(&picture)
        .unwrap();
    file
}

/// What a capture told of one kind of event.
fn events<'a>(section: &'a [Value], event: &str) -> Vec<&'a Value> {
    section
        .iter()
        .filter(|line| line["event"] == event)
        .collect()
}

fn numbers(section: &[Value], key: &str) -> Vec<u64> {
    events(section, "frame")
        .iter()
        .map(|frame| frame[key].as_u64().unwrap())
        .collect()
}

/// Each frame's number is the one before, plus what was dropped, plus one: nothing is lost
/// uncounted.
fn assert_every_loss_is_counted(section: &[Value]) {
    let (numbers, dropped) = (numbers(section, "number"), numbers(section, "dropped"));
    assert!(numbers.len() > 1, "{section:?}");
    for k in 1..numbers.len() {
        assert_eq!(numbers[k], numbers[k - 1] + dropped[k] + 1, "{section:?}");
    }
}

/// Frames came after the trouble: the capture did not end for lack of time.
fn assert_frames_at_the_end(section: &[Value]) {
    let end = section
        .iter()
        .position(|line| line["event"] == "end")
        .unwrap();
    assert_eq!(section[end - 1]["event"], "frame", "{section:?}");
}

fn error_kinds(section: &[Value]) -> Vec<&str> {
    events(section, "error")
        .iter()
        .map(|error| error["kind"].as_str().unwrap())
        .collect()
}

#[test]
fn the_kernels_camera_is_listed_with_its_exact_rates() {
    let cameras = &section(&ON_VIVID, "list")[0];
    assert_eq!(cameras.as_array().unwrap().len(), 1);
    assert_eq!(
        (&cameras[0]["path"], &cameras[0]["driver"]),
        (&"/dev/video0".into(), &"vivid".into())
    );
    let yuyv = cameras[0]["formats"]
        .as_array()
        .unwrap()
        .iter()
        .find(|format| format["fourcc"] == "YUYV")
        .unwrap();
    let sizes = yuyv["sizes"].as_array().unwrap();
    let vga = sizes
        .iter()
        .find(|size| size["width"] == 640 && size["height"] == 480)
        .unwrap();
    assert_eq!(
        vga["rates"],
        serde_json::json!(["25", "15", "25/2", "10", "5", "4", "2", "1"])
    );
}

#[test]
fn every_pixel_format_gives_the_same_colours() {
    let bars = |format: &str| -> Vec<i64> {
        let lines = section(&ON_VIVID, format);
        let opened = events(&lines, "open")[0]["format"].as_str().unwrap();
        assert!(opened.contains(format), "{lines:?}");
        assert_every_loss_is_counted(&lines);
        let bars = events(&lines, "frame")[0]["bars"].as_array().unwrap();
        let channels = bars.iter().flat_map(|bar| bar.as_array().unwrap());
        channels.map(|channel| channel.as_i64().unwrap()).collect()
    };
    let rgb = bars("RGB3");
    let yellow = &rgb[3..6];
    assert!(
        yellow[0] > yellow[2] + 100 && yellow[1] > yellow[2] + 100,
        "{rgb:?}"
    );
    for format in ["YUYV", "NV12", "BGR3"] {
        let other = bars(format);
        let alike = rgb.iter().zip(&other).all(|(a, b)| (a - b).abs() <= 4);
        assert!(alike, "RGB3 {rgb:?}, {format} {other:?}");
    }
    assert!(
        bars("GREY")
            .chunks(3)
            .all(|bar| bar[0] == bar[1] && bar[1] == bar[2])
    );
}

#[test]
fn automatics_that_the_camera_has_are_held_until_it_is_closed() {
    let lines = section(&ON_VIVID, "hold");
    let values: Vec<_> = ON_VIVID
        .lines()
        .filter_map(|line| line.trim_end().strip_prefix("gain_automatic: "))
        .collect();
    assert_eq!(values, ["1", "0", "1"]);
    assert_eq!(
        events(&lines, "held")[0]["controls"],
        serde_json::json!([["gain", null]])
    );
}

#[test]
fn a_camera_that_stands_at_a_fractional_rate_opens_and_can_be_asked_for_one() {
    let lines = section(&ON_VIVID, "fractional-rate");
    let formats: Vec<_> = events(&lines, "open")
        .iter()
        .map(|open| open["format"].as_str().unwrap())
        .collect();
    assert_eq!(
        formats,
        [
            "320x180 YUYV at 25/2 frames per second",
            "320x180 YUYV at 30 frames per second"
        ]
    );
    assert_eq!(events(&lines, "frame").len(), 4);
}

#[test]
fn a_camera_that_another_program_uses_is_told_to_be_busy() {
    assert_eq!(error_kinds(&section(&ON_VIVID, "busy")), ["Busy"]);
}

#[test]
fn frames_with_an_error_mark_are_left_out_and_counted() {
    let lines = section(&ON_VIVID, "broken-frames");
    assert_frames_at_the_end(&lines);
    let losses = &events(&lines, "end")[0]["losses"];
    assert!(
        (1..=3).contains(&losses["damaged"].as_u64().unwrap()),
        "{losses}"
    );
    assert_every_loss_is_counted(&lines);
}

#[test]
fn a_stalled_camera_is_told_and_goes_on_by_itself() {
    let lines = section(&ON_VIVID, "stall");
    assert!(error_kinds(&lines).contains(&"NoFrame"), "{lines:?}");
    assert_frames_at_the_end(&lines);
}

#[test]
fn a_fatal_error_of_the_stream_is_cured_by_starting_it_anew() {
    let lines = section(&ON_VIVID, "fatal-error");
    assert_frames_at_the_end(&lines);
    assert_every_loss_is_counted(&lines);
    assert!(
        ON_VIVID.contains("Input/output error (os error 5)"),
        "the error was not met"
    );
}

#[test]
fn an_unplugged_camera_is_told_and_found_again_by_its_name() {
    let lines = section(&ON_VIVID, "unplugged");
    assert!(error_kinds(&lines).contains(&"Unplugged"), "{lines:?}");
    assert_frames_at_the_end(&lines);
    assert_eq!(events(&lines, "closed").len(), 1, "{lines:?}");
}

#[test]
fn a_missing_device_is_told_with_what_there_is() {
    let lines = section(&ON_VIVID, "no-camera");
    assert_eq!(error_kinds(&lines), ["NotACamera"]);
    assert!(
        events(&lines, "error")[0]["text"]
            .as_str()
            .unwrap()
            .contains("replay:DIR"),
        "{lines:?}"
    );
}

#[test]
fn a_device_without_a_writer_is_refused_at_once() {
    let lines = section(&ON_LOOPBACK, "unfed");
    assert_eq!(error_kinds(&lines).len(), 1, "{lines:?}");
}

#[test]
fn fed_frames_come_in_order_and_every_loss_is_counted() {
    let lines = section(&ON_LOOPBACK, "steps");
    assert_eq!(lines[0][0]["formats"][0]["fourcc"], "YUYV");
    assert_every_loss_is_counted(&lines);
    let greys: Vec<u64> = events(&lines, "frame")
        .iter()
        .map(|frame| frame["corner"][0].as_u64().unwrap())
        .collect();
    assert_eq!(greys.len(), 10);
    assert!(greys.is_sorted() && greys[0] < greys[9], "{greys:?}");
}

#[test]
fn a_feeder_that_pauses_is_waited_for() {
    let lines = section(&ON_LOOPBACK, "pause");
    assert!(error_kinds(&lines).contains(&"NoFrame"), "{lines:?}");
    assert_frames_at_the_end(&lines);
}

#[test]
fn cut_and_foreign_jpegs_are_left_out_and_whole_ones_given() {
    let lines = section(&ON_LOOPBACK, "jpeg");
    let frames = events(&lines, "frame");
    assert_eq!(frames.len(), 5, "{lines:?}");
    for frame in frames {
        assert_eq!(frame["size"], serde_json::json!([320, 240]));
        assert!(frame["centre"][0].as_u64().unwrap() > 180, "{frame}");
    }
    let losses = &events(&lines, "end")[0]["losses"];
    assert!(losses["damaged"].as_u64().unwrap() >= 3, "{losses}");
}
