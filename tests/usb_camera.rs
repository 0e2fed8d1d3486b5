//! A USB webcam under the kernel's own driver: the simulated room's camera speaks the USB video class, a guest machine has
//! it plugged in, and the acquirer captures from it, sets it, loses it, and works with it and a projector's real window.
//!
//! ```text
//! projector <--requests over TCP-- acquirer <- /dev/video0 <- uvcvideo <- vhci-hcd
//!  | window '--notices--> room's camera <--------------USB/IP over TCP----------'
//!  '-> Xvfb
//! ```

#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests fail by panicking, as tests do"
)]

#[allow(dead_code, reason = "there is no mouse here")]
#[path = "projector_support/display.rs"]
mod display;

use std::sync::LazyLock;

use display::Display;
use rig_tests::ProjectorProgram;
use rig_tests::guest::{Device, Guest, built_program};
use rig_tests::told::{assert_frames_at_the_end, error_kinds, events, section, told};
use rig_tests::usb_camera::UsbCamera;
use serde_json::Value;
use shared::pattern::RasterSize;

const RASTER: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};

/// Small frames at a slow rate, so that the slow guest keeps up.
const SCRIPT: &str = r#"
part() { echo "== $1"; }
plug() { usb_attach 10.0.2.2:$device; n=0; while [ ! -e /dev/video0 ] && [ $n -lt 200 ]; do n=$((n+1)); sleep 0.1; done; }
order() { echo "$@" | nc 10.0.2.2 $orders | grep -q done || echo "the camera does not know: $@"; }
probe() { camera_probe capture /dev/video0 "$@"; }
capture() { probe --rate 10 --width 320 --height 240 "$@"; }
# begin: captures in the background, returns when the first frame has come
begin() { rm -f /tmp/mark /tmp/over; capture --mark /tmp/mark --after /tmp/over --patience-ms 700 "$@" & probe=$!
    while [ ! -e /tmp/mark ] && kill -0 $probe 2>/dev/null; do sleep 0.1; done; }
# over: the trouble has been caused; some more frames, then the end
over() { touch /tmp/over; wait $probe; }
automatic() { v4l2-ctl -d /dev/video0 -c auto_exposure=3,white_balance_automatic=1; }
settings() { v4l2-ctl -d /dev/video0 -C auto_exposure,exposure_time_absolute,white_balance_automatic,gain; }
usb-load; plug
part list; camera_probe list
part controls; automatic; camera_probe controls /dev/video0
for format in YUYV MJPG; do part $format; probe --rate 5 --frames 3 --format $format; done
part rates; probe --frames 1 --rate 30; probe --frames 1 --rate 2
part held; settings; begin --frames 1 --hold; settings; over; settings
part wished; settings; begin --frames 1 --control exposure=5ms --control gain=40; settings; over; settings
part panic; settings; begin --frames 1 --control exposure=5ms --control gain=40 --panic; settings; over; settings
part broken-frames; begin --frames 3; order errors 3; sleep 1; over
part cut-yuyv; begin --frames 3; order cut 3; sleep 1; over
part cut-mjpg; begin --frames 3 --format MJPG; order cut 3; sleep 1; over
part stall; begin --frames 3; order stall 4000; sleep 4; over
part unplugged; begin --frames 3 --control gain=40; usb-unplug; sleep 2; plug; sleep 2; settings; over; settings
rig="--projector 127.0.0.1:4460 --camera /dev/video0 --rate 5"
nc -ll -p 4460 -e nc 10.0.2.2 $projector & sleep 1
part live; automatic; v4l2-ctl -d /dev/video0 -c gain=64
acquirer live $rig --expose --frames 4 --json; settings
part doctor; acquirer doctor $rig --expose --json; settings
"#;

static OUTPUT: LazyLock<String> = LazyLock::new(|| {
    let display = Display::start(RASTER);
    let projector = ProjectorProgram::full_screen(&display.environment()).unwrap();
    let camera = UsbCamera::start("cube", projector.address()).unwrap();
    let ports = format!(
        "device={} orders={} projector={}",
        camera.device_port(),
        camera.order_port(),
        projector.port()
    );
    let programs = ["acquirer", "camera_probe", "usb_attach"];
    let guest = Guest::with(Device::None);
    let guest = programs.into_iter().fold(guest, |guest, name| {
        guest.program(built_program(name).unwrap())
    });
    guest
        .run(&format!("{ports}\n{SCRIPT}"))
        .unwrap_or_else(|error| panic!("{error:#}"))
});

/// What the settings were, one time after the other: exposure mode, exposure time, automatic white balance, gain.
fn settings(name: &str) -> Vec<[i64; 4]> {
    let controls = [
        "auto_exposure",
        "exposure_time_absolute",
        "white_balance_automatic",
        "gain",
    ];
    let number = |text: &str| text.split(' ').next().unwrap().parse().unwrap();
    let values = controls.map(|control| told(&OUTPUT, name, control));
    (0..values[0].len())
        .map(|time| [0, 1, 2, 3].map(|k| number(values[k][time])))
        .collect()
}

#[test]
fn a_usb_camera_is_listed_with_sizes_and_rates_and_without_its_metadata() {
    let cameras = &section(&OUTPUT, "list")[0];
    assert_eq!(cameras.as_array().unwrap().len(), 1, "{cameras}");
    let camera = &cameras[0];
    assert_eq!(camera["driver"], "uvcvideo");
    let formats = camera["formats"].as_array().unwrap();
    let codes: Vec<_> = formats.iter().map(|format| &format["fourcc"]).collect();
    assert_eq!(codes, ["YUYV", "MJPG"]);
    for format in formats {
        let sizes = format["sizes"].as_array().unwrap();
        let widths: Vec<_> = sizes.iter().map(|size| &size["width"]).collect();
        assert_eq!(widths, [640, 320]);
        let rates = serde_json::json!(["2997/100", "15", "10", "5", "2"]);
        assert!(
            sizes.iter().all(|size| size["rates"] == rates),
            "{format:#}"
        );
    }
}

#[test]
fn a_usb_cameras_controls_have_units_menus_and_automatics() {
    let controls = &section(&OUTPUT, "controls")[0];
    let all = controls.as_array().unwrap();
    let of = |key: &str| all.iter().find(|control| control["key"] == key).unwrap();
    let exposure = of("exposure_time_absolute");
    assert_eq!(exposure["unit"], "x 100 us");
    assert_eq!(exposure["inactive"], true, "the automatic has it in hand");
    let modes = of("auto_exposure")["items"].as_array().unwrap();
    let modes: Vec<_> = modes.iter().map(|item| &item["name"]).collect();
    assert_eq!(
        modes,
        ["Manual Mode", "Aperture Priority Mode"],
        "those alone that this camera has"
    );
    assert_eq!(of("gain")["least"], 16);
}

#[test]
fn both_pixel_formats_of_a_usb_camera_give_the_same_picture() {
    let bars = |format: &str| -> Vec<i64> {
        let lines = section(&OUTPUT, format);
        let opened = events(&lines, "open")[0]["format"].as_str().unwrap();
        assert!(
            opened.starts_with(&format!("640x480 {format}")),
            "{lines:?}"
        );
        let frames = events(&lines, "frame");
        assert_eq!(frames.len(), 3);
        let bars = frames[2]["bars"].as_array().unwrap().iter();
        let channels = bars.flat_map(|bar| bar.as_array().unwrap());
        channels.map(|channel| channel.as_i64().unwrap()).collect()
    };
    let (yuyv, mjpg) = (bars("YUYV"), bars("MJPG"));
    let alike = yuyv.iter().zip(&mjpg).all(|(a, b)| (a - b).abs() < 30);
    assert!(alike, "YUYV {yuyv:?}, MJPG {mjpg:?}");
}

#[test]
fn the_rates_that_were_asked_for_are_taken_fractions_too() {
    let lines = section(&OUTPUT, "rates");
    let formats: Vec<_> = events(&lines, "open")
        .iter()
        .map(|open| open["format"].as_str().unwrap())
        .collect();
    assert_eq!(formats.len(), 2, "{lines:?}");
    assert!(formats[0].contains("2997/100"), "{formats:?}");
    assert!(
        formats[1].ends_with("at 2 frames per second"),
        "{formats:?}"
    );
}

#[test]
fn exposure_and_white_balance_are_held_and_given_back_to_the_automatics() {
    let [before, held, after] = settings("held")[..] else {
        panic!("{}", *OUTPUT)
    };
    assert_eq!([before[0], before[2]], [3, 1], "both automatic");
    assert_eq!([held[0], held[2]], [1, 0], "both held");
    assert_eq!([after[0], after[2]], [3, 1], "both automatic again");
    let lines = section(&OUTPUT, "held");
    assert_eq!(
        events(&lines, "held")[0]["controls"],
        serde_json::json!([["exposure time", null], ["white balance", null]])
    );
}

#[test]
fn wished_settings_are_made_and_taken_back_even_by_a_panic() {
    for part in ["wished", "panic"] {
        let [before, wished, after] = settings(part)[..] else {
            panic!("{part}: {}", *OUTPUT)
        };
        assert_eq!(
            [wished[0], wished[1], wished[3]],
            [1, 50, 40],
            "{part}: manual, 5 ms, gain 40"
        );
        assert_eq!(
            [after[0], after[3]],
            [before[0], before[3]],
            "{part}: as it was found"
        );
    }
    assert!(OUTPUT.contains("as it was told"), "{}", *OUTPUT);
}

#[test]
fn frames_that_the_driver_flags_or_that_are_cut_are_left_out_and_counted() {
    for part in ["broken-frames", "cut-yuyv", "cut-mjpg"] {
        let lines = section(&OUTPUT, part);
        assert_frames_at_the_end(&lines);
        let losses = &events(&lines, "end")[0]["losses"];
        // the driver keeps raw frames to itself that went wrong; compressed ones it can't judge
        let lost = ["by_driver", "damaged"].map(|how| losses[how].as_u64().unwrap());
        assert!(lost[0] + lost[1] >= 3, "{part}: {losses}");
        assert_eq!(lost[1] > 0, part == "cut-mjpg", "{part}: {losses}");
    }
}

#[test]
fn a_usb_stream_that_stalls_goes_on_by_itself() {
    let lines = section(&OUTPUT, "stall");
    assert!(error_kinds(&lines).contains(&"NoFrame"), "{lines:?}");
    assert_frames_at_the_end(&lines);
}

#[test]
fn a_plug_that_is_pulled_and_put_in_again_is_survived_with_its_settings() {
    let lines = section(&OUTPUT, "unplugged");
    assert!(error_kinds(&lines).contains(&"Unplugged"), "{lines:?}");
    assert_frames_at_the_end(&lines);
    let gains: Vec<_> = settings("unplugged").iter().map(|all| all[3]).collect();
    assert_eq!(gains, [40, 16], "set again, then taken back");
}

#[test]
fn a_rig_with_a_usb_camera_sets_its_exposure_and_reads_the_grid() {
    let frames = section(&OUTPUT, "live");
    assert_eq!(frames.len(), 4, "{}", *OUTPUT);
    for frame in &frames {
        assert_eq!(frame["pattern"], "coded", "{frame}");
        assert!(frame["crossings"].as_u64() > Some(150), "{frame}");
    }
    let exposed = OUTPUT
        .lines()
        .find(|line| line.contains("the white-lit scene reaches"));
    let exposed = exposed.unwrap_or_else(|| panic!("{}", *OUTPUT));
    assert!(exposed.contains("period(s) of the projector"), "{exposed}");
    let brightest = exposed.split("reaches byte ").nth(1);
    let brightest = brightest.and_then(|rest| rest.split(',').next()?.parse().ok());
    assert!(
        brightest.is_some_and(|byte: u8| (100..250).contains(&byte)),
        "bright, and not clipped: {exposed}"
    );
    let after = settings("live")[0];
    assert_eq!([after[0], after[2], after[3]], [3, 1, 64], "as it was");
}

/// What a slow and busy guest may do worse than a rig.
const TIMES: [&str; 2] = ["frames", "latency"];

#[test]
fn the_doctor_finds_a_rig_with_a_usb_camera_well() {
    let diagnosis = &section(&OUTPUT, "doctor")[0];
    let bad = diagnosis["bad"].as_array().unwrap();
    let known = |name: &Value| TIMES.iter().any(|time| name == time);
    assert!(bad.iter().all(known), "{diagnosis:#}");
    let findings = diagnosis["findings"].as_array().unwrap();
    let automatics = findings.iter().find(|f| f["name"] == "automatics").unwrap();
    let says = automatics["says"].as_str().unwrap();
    assert!(
        says.contains("exposure time") && says.contains("white balance"),
        "{says}"
    );
    let after = settings("doctor")[0];
    assert_eq!([after[0], after[2], after[3]], [3, 1, 64], "as it was");
}
