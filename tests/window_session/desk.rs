//! Both programs with their windows on a display nobody sees, and the mouse over them.

use std::{
    env, fs,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use image::RgbImage;
use rig_tests::built_program;
use serde_json::Value;
use shared::pattern::RasterSize;

use crate::display::Display;

/// Room for the picture on the wall, the operator's window below it, and the acquirer's window beside them.
const SCREEN: RasterSize = RasterSize {
    width: 3040,
    height: 1500,
};
/// Size of the acquirer's window, in pixels; `windows.sh` asks for another one.
const SIZE: &str = "1280x720";
const SIZE_VARIABLE: &str = "WINDOW_SIZE";
/// Size of the picture on the wall.
pub(crate) const WALL: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};
/// Far longer than anything takes; a test that waits this long has failed.
const PATIENCE: Duration = Duration::from_secs(300);
/// Longest wait for a click to do something before it is tried again.
const CLICK: Duration = Duration::from_secs(20);
/// With this variable the test leaves a picture of each window it comes through in that folder; `windows.sh` makes the
/// README's pictures so.
const PICTURES: &str = "WINDOW_PICTURES";
/// Until a window has been drawn, for pictures that nothing is judged by.
const DRAWN: Duration = Duration::from_secs(2);
/// Between two looks at what a window says.
const LOOK: Duration = Duration::from_millis(50);

/// A program that ends with this value.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        // it may have ended by itself
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// The display with both programs.
pub(crate) struct Desk {
    pub(crate) display: Display,
    /// Where the projector takes commands.
    pub(crate) address: String,
    home: PathBuf,
    _programs: [Program; 2],
}

impl Desk {
    /// Starts both programs, the acquirer in the simulated room of the cube with scans under `home`.
    pub(crate) fn new(home: &Path) -> Self {
        let display = Display::start(SCREEN);
        remember_size(home);
        let windowed = format!("--windowed {WALL} --operator --listen 127.0.0.1:0");
        let mut projector = start("projector", &windowed, &display, home);
        let stdout = projector.0.stdout.take().expect("it is piped");
        let mut line = String::new();
        BufReader::new(stdout).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("listening on ");
        let address = address.expect("the projector tells where it listens");
        let out = home.join("cube");
        let with = format!(
            "--projector {address} --camera sim:cube --out {}",
            out.display()
        );
        let acquirer = start("acquirer", &with, &display, home);
        Self {
            address: address.to_owned(),
            display,
            home: home.to_owned(),
            _programs: [projector, acquirer],
        }
    }

    /// The acquirer's window.
    pub(crate) fn acquirer(&self) -> Window<'_> {
        self.window("acquirer", "acquirer", (1090, 0))
    }

    /// The operator's window of the projector.
    pub(crate) fn operator(&self) -> Window<'_> {
        self.window("projector", "projector - operator", (0, 775))
    }

    /// A program's window, brought to its place.
    fn window(&self, program: &str, title: &str, (x, y): (u32, u32)) -> Window<'_> {
        let found = self
            .display
            .xdotool(&["search", "--sync", "--name", &format!("^{title}$")]);
        let id = found.lines().last().expect("it was found").to_owned();
        let place = [x.to_string(), y.to_string()];
        self.display
            .xdotool(&["windowmove", "--sync", &id, &place[0], &place[1]]);
        let window = Window {
            display: &self.display,
            widgets: self.home.join(program),
            title: title.to_owned(),
            id,
        };
        window.wait("something in it", |window| !window.widgets().is_empty());
        window
    }
}

/// Leaves the settings file that gives the acquirer's window its size.
fn remember_size(home: &Path) {
    let size = env::var(SIZE_VARIABLE).unwrap_or_else(|_| SIZE.to_owned());
    let folder = home.join(".config/acquirer");
    fs::create_dir_all(&folder).unwrap();
    let text = format!("window = [{}]\n", size.replace('x', ", "));
    fs::write(folder.join("window.toml"), text).unwrap();
}

fn start(program: &str, arguments: &str, display: &Display, home: &Path) -> Program {
    let child = Command::new(built_program(program).unwrap())
        .args(arguments.split_whitespace())
        .envs(display.environment())
        .env("HOME", home)
        .env_remove("XDG_CONFIG_HOME")
        .env_remove("WAYLAND_DISPLAY")
        .env("ACQUIRER_WIDGETS", home.join("acquirer"))
        .env("PROJECTOR_WIDGETS", home.join("projector"))
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    Program(child.expect("the program can be started"))
}

/// A window of a program, and the list of what stands in it.
pub(crate) struct Window<'a> {
    display: &'a Display,
    widgets: PathBuf,
    title: String,
    id: String,
}

impl Window<'_> {
    /// What stands in the window: labels, places in pixels, whether they can be used.
    fn widgets(&self) -> Vec<Value> {
        let text = fs::read(&self.widgets).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    /// Where a widget stands that can be used, and has this label or one that begins so.
    pub(crate) fn find(&self, label: &str) -> Option<[i64; 2]> {
        let widgets = self.widgets();
        let is = |widget: &&Value, test: &dyn Fn(&str) -> bool| {
            widget["enabled"] == true && widget["label"].as_str().is_some_and(test)
        };
        let whole = widgets.iter().find(|w| is(w, &|text| text == label));
        let begins = || {
            widgets
                .iter()
                .find(|w| is(w, &|text| text.starts_with(label)))
        };
        let found = whole.or_else(begins)?;
        let place = |key: &str| found[key].as_f64().map(|v| v.round() as i64);
        Some([place("x")?, place("y")?])
    }

    /// How many labels hold these words.
    pub(crate) fn count(&self, words: &str) -> usize {
        let widgets = self.widgets();
        let labels = widgets.iter().filter_map(|w| w["label"].as_str());
        labels.filter(|label| label.contains(words)).count()
    }

    /// Whether these words stand in the window.
    pub(crate) fn says(&self, words: &str) -> bool {
        self.count(words) > 0
    }

    /// Waits until something holds of the window.
    pub(crate) fn wait(&self, what: &str, holds: impl Fn(&Self) -> bool) {
        assert!(self.holds_within(PATIENCE, &holds), "{}", self.told(what));
    }

    fn holds_within(&self, patience: Duration, holds: &impl Fn(&Self) -> bool) -> bool {
        let begun = Instant::now();
        while !holds(self) {
            if begun.elapsed() > patience {
                return false;
            }
            thread::sleep(LOOK);
        }
        true
    }

    fn told(&self, what: &str) -> String {
        let widgets = self.widgets();
        let labels = widgets.iter().filter_map(|widget| widget["label"].as_str());
        let labels: Vec<&str> = labels.collect();
        format!("waited for {what} in vain; there is {labels:?}")
    }

    /// Clicks a widget once it can be used, and waits for what it should do.
    pub(crate) fn click(&self, label: &str, done: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        loop {
            self.wait(label, |window| window.find(label).is_some());
            self.click_at(self.resting_place(label));
            if self.holds_within(CLICK, &done) {
                return;
            }
            // a click that came while the window moved its parts may have hit nothing
            assert!(
                begun.elapsed() < PATIENCE,
                "{}",
                self.told(&format!("what {label} does"))
            );
        }
    }

    /// Where a widget stands once it stands still.
    fn resting_place(&self, label: &str) -> [i64; 2] {
        let mut last = None;
        loop {
            let place = self.find(label);
            if let (Some(place), true) = (place, place == last) {
                return place;
            }
            last = place;
            thread::sleep(2 * LOOK);
        }
    }

    /// Leaves a picture of the window if somebody wants one.
    pub(crate) fn picture(&self, name: &str) {
        let Some(folder) = env::var_os(PICTURES) else {
            return;
        };
        // away from every button, so that none explains itself
        self.display
            .xdotool(&["mousemove", "--sync", "--window", &self.id, "560", "8"]);
        thread::sleep(DRAWN);
        let seen = self.display.window(&self.title);
        let RasterSize { width, height } = seen.size();
        let picture =
            RgbImage::from_raw(width, height, seen.into_bytes()).expect("3 bytes a pixel");
        let file = Path::new(&folder).join(format!("{name}.png"));
        picture.save(file).unwrap();
    }

    fn click_at(&self, [x, y]: [i64; 2]) {
        let (x, y) = (x.to_string(), y.to_string());
        self.display.xdotool(&[
            "mousemove",
            "--sync",
            "--window",
            &self.id,
            &x,
            &y,
            "click",
            "1",
        ]);
    }
}
