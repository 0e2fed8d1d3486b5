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
use rig_tests::guest::{Device, Guest};
use rig_tests::told::{assert_frames_at_the_end, error_kinds, events, section, told};
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
gain() { v4l2-ctl -d /dev/video0 -C gain_automatic; v4l2-ctl -d /dev/video0 -C gain; }
part list; camera_probe list
part controls; camera_probe controls /dev/video0
set_control osd_text_mode=2 # colour bars alone
for format in YUYV NV12 RGB3 BGR3 GREY; do part $format; capture --frames 3 --format $format; done
part hold; v4l2-ctl -d /dev/video0 -C gain_automatic
begin --frames 1 --hold; v4l2-ctl -d /dev/video0 -C gain_automatic; over
v4l2-ctl -d /dev/video0 -C gain_automatic
part settings; begin --frames 1 --control gain=77 --control brightness=99; gain; over; gain
part wrong-settings; capture --frames 1 --control gain=9999; capture --frames 1 --control nonsense=1
part odd-size; camera_probe capture /dev/video0 --width 500 --height 300 --frames 1
part slow-reader; capture --rate 5 --frames 4 --pause-ms 2500
part fractional-rate; v4l2-ctl -d /dev/video0 --set-fmt-video=width=320,height=180,pixelformat=YUYV >/dev/null
v4l2-ctl -d /dev/video0 --set-parm=12.5; capture --frames 2 --rate 13; capture --frames 2
part busy; v4l2-ctl -d /dev/video0 --set-fmt-video=width=640,height=360 >/dev/null
v4l2-ctl -d /dev/video0 --stream-mmap >/dev/null 2>&1 & other=$!; sleep 2
capture --frames 2; kill $other; wait $other 2>/dev/null
part broken-frames; begin --frames 3
for i in 1 2 3; do set_control inject_v4l2_buf_flag_error=1; sleep 0.3; done; over
part refused-start; for call in reqbufs streamon; do
set_control inject_vidioc_${call}_error=1; capture --frames 1; capture --frames 1; done
part refused-buffer; begin --frames 3; set_control inject_vidioc_qbuf_error=1; sleep 1; over
part stall; begin --frames 3
set_control percentage_of_dropped_buffers=100; sleep 5; set_control percentage_of_dropped_buffers=0; over
part fatal-error; begin --frames 3; set_control inject_fatal_streaming_error=1; sleep 1; over
part unplugged; begin --frames 3; unplug; sleep 2; replug; over
part replugged-settings; begin --frames 3 --control gain=77; unplug; sleep 2; replug; sleep 3; gain; over; gain
part renumbered; begin --frames 3; exec 9<>/dev/video0; unplug; sleep 2; replug; sleep 2; over; exec 9>&-
unplug; replug
part no-camera; unplug; capture --frames 1
part many-nodes; rmmod vivid; insmod /mod/vivid.ko n_devs=1; echo "nodes: $(ls /dev/video* | wc -l)"; camera_probe list
"#;

const LOOPBACK: &str = r#"
part() { echo "== $1"; }
fed() { frame_feeder /dev/video0 "$@" & feeder=$!; wait-fed; }
done_feeding() { kill $feeder 2>/dev/null; wait $feeder 2>/dev/null; loop-load; }
part unfed; camera_probe list; camera_probe capture /dev/video0 --frames 1
part steps; fed steps 640 480 15 400; camera_probe list; camera_probe capture /dev/video0 --frames 10; done_feeding
part pause; fed steps 640 480 15 400 --pause-after 20 --pause-ms 4000
camera_probe capture /dev/video0 --frames 30 --patience-ms 500; done_feeding
part rounded-buffer; fed steps 322 182 10 300; camera_probe capture /dev/video0 --frames 3; done_feeding
part cut-yuyv; fed files YUYV 320 240 10 400 /whole.yuyv /short.yuyv
camera_probe capture /dev/video0 --frames 4 --width 320 --height 240; done_feeding
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
    let grey = [120, 128].repeat(320 * 240);
    let short = file("short.yuyv", &grey[..grey.len() / 2]);
    let grey = file("whole.yuyv", &grey);
    boot(
        Device::Loopback,
        LOOPBACK,
        &[&whole, &cut, &garbage, &small, &grey, &short],
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
    let values = told(&ON_VIVID, "hold", "gain_automatic");
    assert_eq!(values, ["1", "0", "1"]);
    assert_eq!(
        events(&lines, "held")[0]["controls"],
        serde_json::json!([["gain", null]])
    );
}

#[test]
fn controls_are_listed_with_number_range_menu_and_value() {
    let controls = &section(&ON_VIVID, "controls")[0];
    let all = controls.as_array().unwrap();
    let of = |key: &str| all.iter().find(|control| control["key"] == key).unwrap();
    let brightness = of("brightness");
    assert_eq!(brightness["id"], "0x00980900");
    assert_eq!(brightness["kind"], "number");
    assert_eq!(
        (
            &brightness["least"],
            &brightness["most"],
            &brightness["value"]
        ),
        (&0.into(), &255.into(), &128.into())
    );
    assert_eq!(of("gain_automatic")["kind"], "switch");
    assert_eq!(of("gain")["inactive"], true, "its automatic has it in hand");
    let items = of("test_pattern")["items"].as_array().unwrap();
    assert_eq!(
        items[0]["name"], "75% Colorbar",
        "names of a driver's own menu"
    );
    assert!(items.len() > 5);
}

#[test]
fn wished_controls_are_set_and_get_their_old_values_back() {
    let gains = told(&ON_VIVID, "settings", "gain");
    let automatic = told(&ON_VIVID, "settings", "gain_automatic");
    assert_eq!(gains[0], "77");
    assert_eq!(automatic, ["0", "1"], "the automatic in whose hand it was");
    assert_eq!(events(&section(&ON_VIVID, "settings"), "closed").len(), 1);
}

#[test]
fn wrong_controls_are_told_with_the_right_ones() {
    let lines = section(&ON_VIVID, "wrong-settings");
    assert_eq!(error_kinds(&lines), ["BadControlValue", "NoSuchControl"]);
    let texts: Vec<_> = events(&lines, "error")
        .iter()
        .map(|error| error["text"].as_str().unwrap())
        .collect();
    assert!(texts[0].contains("0 to 255"), "{texts:?}");
    assert!(texts[1].contains("gain_automatic"), "{texts:?}");
}

#[test]
fn settings_survive_a_replug_and_are_taken_back_at_the_end() {
    let lines = section(&ON_VIVID, "replugged-settings");
    assert_frames_at_the_end(&lines);
    assert_eq!(told(&ON_VIVID, "replugged-settings", "gain")[0], "77");
    let automatic = told(&ON_VIVID, "replugged-settings", "gain_automatic");
    assert_eq!(automatic, ["0", "1"]);
}

#[test]
fn a_camera_that_comes_back_under_another_number_is_found() {
    let lines = section(&ON_VIVID, "renumbered");
    assert!(error_kinds(&lines).contains(&"Unplugged"), "{lines:?}");
    assert_frames_at_the_end(&lines);
    assert!(
        ON_VIVID.contains("/dev/video1"),
        "it came back as the old one"
    );
}

#[test]
fn the_nearest_size_is_taken() {
    let lines = section(&ON_VIVID, "odd-size");
    let opened = events(&lines, "open")[0]["format"].as_str().unwrap();
    assert!(opened.starts_with("640x360"), "{opened}");
    assert_eq!(events(&lines, "frame").len(), 1);
}

#[test]
fn a_slow_reader_gets_fresh_frames_and_the_others_counted() {
    let lines = section(&ON_VIVID, "slow-reader");
    assert_every_loss_is_counted(&lines);
    let frames = events(&lines, "frame");
    for frame in &frames[1..] {
        // kept in the driver's buffers it would be as old as the pause
        assert!(frame["age_ms"].as_u64().unwrap() < 1500, "{frame}");
        assert!(frame["dropped"].as_u64().unwrap() > 3, "{frame}");
    }
}

#[test]
fn stamps_grow_and_are_never_ahead_of_the_clock() {
    for part in ["YUYV", "slow-reader", "stall", "renumbered"] {
        let lines = section(&ON_VIVID, part);
        let stamps = numbers(&lines, "stamp_us");
        assert!(
            stamps.windows(2).all(|pair| pair[0] < pair[1]),
            "{stamps:?}"
        );
        assert!(numbers(&lines, "ahead_us").iter().all(|ahead| *ahead == 0));
    }
}

#[test]
fn a_stream_that_cannot_start_is_told_and_the_next_try_is_good() {
    let lines = section(&ON_VIVID, "refused-start");
    assert_eq!(error_kinds(&lines), ["Setup", "Setup"], "{lines:?}");
    assert_eq!(events(&lines, "frame").len(), 2, "{lines:?}");
}

#[test]
fn a_buffer_that_is_refused_does_not_end_the_stream() {
    assert_frames_at_the_end(&section(&ON_VIVID, "refused-buffer"));
}

#[test]
fn outputs_and_metadata_nodes_are_no_cameras() {
    let nodes = told(&ON_VIVID, "many-nodes", "nodes");
    assert!(nodes[0].parse::<u32>().unwrap() > 1, "{nodes:?}");
    let cameras = &section(&ON_VIVID, "many-nodes")[0];
    assert_eq!(cameras.as_array().unwrap().len(), 1, "{cameras}");
}

#[test]
fn a_buffer_rounded_to_pages_is_cut_to_the_picture() {
    let lines = section(&ON_LOOPBACK, "rounded-buffer");
    let frames = events(&lines, "frame");
    assert_eq!(frames.len(), 3, "{lines:?}");
    for frame in frames {
        assert_eq!(frame["size"], serde_json::json!([322, 182]));
    }
    assert_eq!(events(&lines, "end")[0]["losses"]["damaged"], 0);
}

#[test]
fn frames_that_are_too_short_are_left_out_and_counted() {
    let lines = section(&ON_LOOPBACK, "cut-yuyv");
    let frames = events(&lines, "frame");
    assert_eq!(frames.len(), 4, "{lines:?}");
    let losses = &events(&lines, "end")[0]["losses"];
    assert!(losses["damaged"].as_u64().unwrap() >= 1, "{losses}");
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
