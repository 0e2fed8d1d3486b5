//! A whole session in the real windows, by the mouse alone: both programs on a display nobody sees, real clicks, from
//! the colours to a saved scan.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

#[allow(dead_code, reason = "no pixels are looked at here")]
#[path = "projector_support/display.rs"]
mod display;

use std::{
    fs,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use display::Display;
use rig_tests::guest::built_program;
use serde_json::Value;
use shared::pattern::RasterSize;

/// Both windows side by side.
const SCREEN: RasterSize = RasterSize {
    width: 2330,
    height: 790,
};
/// Where the acquirer's window is put, right of the projector's.
const LEFT: &str = "1040";
/// Far longer than anything takes; a test that waits this long has failed.
const PATIENCE: Duration = Duration::from_secs(400);
/// Longest wait for a click to do something before it is tried again.
const CLICK: Duration = Duration::from_secs(15);

/// A program that ends with this value.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        // it may have ended by itself
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// The acquirer's window and the mouse over it.
struct Window {
    widgets: PathBuf,
    display: Display,
    id: String,
}

impl Window {
    /// What stands in the window: labels, places in pixels, whether they can be used.
    fn widgets(&self) -> Vec<Value> {
        let text = fs::read(&self.widgets).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    fn find(&self, label: &str) -> Option<(u64, u64)> {
        let widgets = self.widgets();
        let found = widgets
            .iter()
            .find(|w| w["label"] == label && w["enabled"] == true)?;
        let place = |key: &str| found[key].as_f64().map(|v| v as u64);
        Some((place("x")?, place("y")?))
    }

    fn says(&self, text: &str) -> bool {
        let widgets = self.widgets();
        let mut labels = widgets.iter().filter_map(|w| w["label"].as_str());
        labels.any(|label| label.contains(text))
    }

    /// Waits until something holds of the window.
    fn wait(&self, what: &str, holds: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while !holds(self) {
            let told: Vec<_> = self
                .widgets()
                .iter()
                .map(|w| w["label"].to_string())
                .collect();
            assert!(
                begun.elapsed() < PATIENCE,
                "waited for {what} in vain; there is {told:?}"
            );
            thread::sleep(Duration::from_millis(200));
        }
    }

    /// Clicks a button once it can be used, until what it should do is seen.
    fn click(&self, label: &str, done: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while !done(self) {
            assert!(begun.elapsed() < PATIENCE, "{label} did nothing");
            if let Some(place) = self.find(label) {
                self.click_at(place);
            }
            let clicked = Instant::now();
            while !done(self) && clicked.elapsed() < CLICK {
                thread::sleep(Duration::from_millis(200));
            }
        }
    }

    fn click_at(&self, (x, y): (u64, u64)) {
        let (x, y) = (x.to_string(), y.to_string());
        xdotool(&self.display, &["mousemove", "--window", &self.id, &x, &y]);
        // a window that is drawn slowly should see the mouse come before it clicks
        thread::sleep(Duration::from_millis(300));
        xdotool(&self.display, &["click", "1"]);
    }
}

fn xdotool(display: &Display, arguments: &[&str]) -> String {
    let output = Command::new("xdotool")
        .args(arguments)
        .envs(display.environment())
        .output()
        .expect("xdotool is installed: apt-get install -y --no-install-recommends xdotool");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

fn start(program: &str, display: &Display, arguments: &[&str], home: &Path) -> Program {
    let child = Command::new(built_program(program).unwrap())
        .args(arguments)
        .envs(display.environment())
        .env("HOME", home)
        .env_remove("XDG_CONFIG_HOME")
        .env_remove("WAYLAND_DISPLAY")
        .env("ACQUIRER_WIDGETS", home.join("widgets.json"))
        .stdout(Stdio::piped())
        .spawn();
    Program(child.expect("the program can be started"))
}

fn address(projector: &mut Program) -> String {
    let mut line = String::new();
    let stdout = projector.0.stdout.take().unwrap();
    BufReader::new(stdout).read_line(&mut line).unwrap();
    line.trim()
        .strip_prefix("listening on ")
        .expect(&line)
        .to_owned()
}

/// Both programs, connected.
fn session(home: &Path) -> (Window, [Program; 2]) {
    let display = Display::start(SCREEN);
    let windowed = ["--windowed", "1024x768", "--listen", "127.0.0.1:0"];
    let mut projector = start("projector", &display, &windowed, home);
    let address = address(&mut projector);
    let out = home.join("cube");
    let out = out.to_str().unwrap();
    let arguments = [
        "--projector",
        &address,
        "--camera",
        "sim:cube",
        "--out",
        out,
    ];
    let acquirer = start("acquirer", &display, &arguments, home);
    let mut window = Window {
        widgets: home.join("widgets.json"),
        display,
        id: String::new(),
    };
    window.wait("the window", |window| window.find("Colours").is_some());
    let found = xdotool(&window.display, &["search", "--name", "^acquirer$"]);
    window.id = found.lines().last().unwrap().to_owned();
    xdotool(&window.display, &["windowmove", &window.id, LEFT, "0"]);
    let size = ["windowsize", &window.id, "1280", "780"];
    xdotool(&window.display, &size);
    (window, [projector, acquirer])
}

#[test]
fn a_session_by_mouse_alone_ends_in_a_saved_scan() {
    let home = tempfile::tempdir().unwrap();
    let (window, _programs) = session(home.path());

    window.click("Colours", |w| w.says("Measure all sixteen"));
    window.click("Measure all sixteen", |w| w.says("Cancel"));
    window.wait("the choice of colours", |w| {
        w.says("Expected to be misread")
    });
    let there = |w: &Window| w.says("The projector shows these colours");
    window.click("Apply to the projector", there);

    window.click("Scan", |w| w.says("Record without object"));
    for (record, kept) in [("Record without object", 1), ("Record with object", 2)] {
        window.click(record, |w| w.says("Cancel") || w.find("Keep").is_some());
        window.wait("the quality", |w| w.find("Keep").is_some());
        window.click("Keep", move |w| {
            w.widgets().iter().filter(|v| v["label"] == "Kept").count() == kept
        });
    }
    window.wait("the result", |w| w.says("vertices shifted"));
    window.click("Save", |w| w.says("saved as"));

    let kept = home.path().join("cube-kept");
    for file in ["scan.json", "results/report.html", "results/shifts.csv"] {
        assert!(kept.join(file).is_file(), "{file}");
    }
    let summary = fs::read(kept.join("results/summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    for stage in ["background", "object"] {
        let coverage = summary[stage]["coverage_percent"].as_f64().unwrap();
        assert!(coverage > 80.0, "{stage}: {coverage}");
    }
}
