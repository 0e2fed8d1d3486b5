//! A display nobody sees: Xvfb, and what is on it.

use std::{
    ffi::OsStr,
    fmt,
    io::{BufRead, BufReader},
    path::PathBuf,
    process::{Child, Command, Output, Stdio},
};

use shared::pattern::{Raster, RasterSize, Rgb};

/// What these tests need; they fail without it rather than pass unseen.
const INSTALL: &str = "apt-get install -y --no-install-recommends xvfb x11-apps xdotool mesa-vulkan-drivers \
                       libxcursor1 libxi6 libxkbcommon-x11-0 xserver-xorg-core xserver-xorg-video-dummy x11-xserver-utils";

/// A running X server without a window manager.
pub(crate) struct Display {
    server: Child,
    name: String,
    driver: String,
    /// Whether only root can end it.
    by_sudo: bool,
    /// The server's configuration, if it has one.
    _folder: Option<tempfile::TempDir>,
}

impl Display {
    /// Starts a server with one monitor on a free display number.
    pub(crate) fn start(size: RasterSize) -> Self {
        let mut server = Command::new("Xvfb");
        server.args(["-screen", "0", &format!("{size}x24")]);
        Self::of_server(server, None)
    }

    /// The same with two monitors side by side, `DUMMY0`, which is primary, and `DUMMY1`.
    #[allow(dead_code, reason = "not all tests have two")]
    pub(crate) fn with_two_monitors([left, right]: [RasterSize; 2]) -> Self {
        let folder = tempfile::tempdir().expect("a folder for the server's files");
        let file = |name: &str| folder.path().join(name);
        std::fs::write(file("xorg.conf"), XORG).expect("a file for the server's configuration");
        let mut server = as_root("Xorg");
        server.arg("-config").arg(file("xorg.conf"));
        server.arg("-logfile").arg(file("log"));
        server.args(["-novtswitch", "-sharevts"]);
        let display = Self::of_server(server, Some(folder));
        let [left, right] = [left, right].map(|size| size.to_string());
        display.xrandr(&["--addmode", "DUMMY1", &right]);
        display.xrandr(&["--output", "DUMMY0", "--mode", &left, "--primary"]);
        display.xrandr(&[
            "--output",
            "DUMMY1",
            "--mode",
            &right,
            "--right-of",
            "DUMMY0",
        ]);
        display
    }

    /// Starts a server on a free display number.
    fn of_server(mut server: Command, folder: Option<tempfile::TempDir>) -> Self {
        let driver = software_vulkan();
        let program = server.get_program().to_owned();
        let mut server = server
            .args(["-displayfd", "1", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| missing(&program.to_string_lossy(), &error));
        let mut number = String::new();
        let stdout = server.stdout.take().expect("standard output is piped");
        BufReader::new(stdout)
            .read_line(&mut number)
            .expect("the server tells its display number");
        let name = format!(":{}", number.trim_end());
        assert!(name.len() > 1, "{} did not start", program.display());
        Self {
            server,
            name,
            driver,
            by_sudo: program == SUDO,
            _folder: folder,
        }
    }

    /// Plugs monitors and sets their modes, as the program of this name.
    #[allow(dead_code, reason = "not all tests have two monitors")]
    pub(crate) fn xrandr(&self, arguments: &[&str]) {
        let output = Command::new("xrandr")
            .args(arguments)
            .envs(self.environment())
            .output()
            .unwrap_or_else(|error| missing("xrandr", &error));
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "xrandr: {error}");
    }

    /// The variables that bring a program here, drawn by the software driver.
    pub(crate) fn environment(&self) -> [(&str, &str); 3] {
        [
            ("DISPLAY", &self.name),
            ("VK_ICD_FILENAMES", &self.driver),
            ("WGPU_BACKEND", "vulkan"),
        ]
    }

    /// Everything that is on the display.
    pub(crate) fn screenshot(&self) -> Raster {
        self.dump(&["-root"])
    }

    /// The inside of the window of this title.
    pub(crate) fn window(&self, title: &str) -> Raster {
        self.dump(&["-name", title])
    }

    /// Moves and clicks the mouse, or asks for windows: the arguments of `xdotool`; gives what it says.
    pub(crate) fn xdotool<A: AsRef<OsStr>>(&self, arguments: &[A]) -> String {
        let output = Command::new("xdotool")
            .args(arguments)
            .envs(self.environment())
            .output()
            .unwrap_or_else(|error| missing("xdotool", &error));
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "xdotool: {error}");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    fn dump(&self, what: &[&str]) -> Raster {
        let Output {
            status,
            stdout,
            stderr,
        } = Command::new("xwd")
            .args(["-silent", "-display", &self.name])
            .args(what)
            .output()
            .unwrap_or_else(|error| missing("xwd", &error));
        assert!(status.success(), "{}", String::from_utf8_lossy(&stderr));
        read_xwd(&stdout)
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // It may have ended by itself.
        if self.by_sudo {
            let process = self.server.id().to_string();
            Command::new(SUDO).args(["kill", &process]).status().ok();
        } else {
            self.server.kill().ok();
        }
        self.server.wait().ok();
    }
}

/// A server whose screen is memory alone, with as many monitors as one likes.
const XORG: &str = r#"
Section "ServerFlags"
  Option "AutoAddDevices" "false"
EndSection
Section "Device"
  Identifier "device"
  Driver "dummy"
  VideoRam 65536
EndSection
Section "Monitor"
  Identifier "monitor"
  HorizSync 5.0 - 1000.0
  VertRefresh 5.0 - 200.0
EndSection
Section "Screen"
  Identifier "screen"
  Device "device"
  Monitor "monitor"
  DefaultDepth 24
  SubSection "Display"
    Virtual 4096 2048
  EndSubSection
EndSection
"#;

const SUDO: &str = "sudo";

/// A program that only root may start so.
fn as_root(program: &str) -> Command {
    let user = Command::new("id").arg("-u").output();
    if user.is_ok_and(|user| user.stdout == b"0\n") {
        return Command::new(program);
    }
    let mut command = Command::new(SUDO);
    command.arg(program);
    command
}

fn missing(what: &str, error: &dyn fmt::Display) -> ! {
    panic!("{what}: {error}. These tests need: {INSTALL}")
}

/// The description file of Mesa's software Vulkan driver.
fn software_vulkan() -> String {
    let folder = PathBuf::from("/usr/share/vulkan/icd.d");
    let files = std::fs::read_dir(&folder).unwrap_or_else(|error| missing("Vulkan", &error));
    let names = files
        .flatten()
        .map(|file| file.path().display().to_string());
    let found = names.into_iter().find(|name| name.contains("/lvp_icd"));
    found.unwrap_or_else(|| missing("lavapipe", &"no lvp_icd file in /usr/share/vulkan/icd.d"))
}

/// Reads an X window dump of a 24-bit TrueColor screen: a header of big-endian 32-bit numbers, a colour
/// map, and rows of 4 bytes a pixel.
fn read_xwd(bytes: &[u8]) -> Raster {
    let field = |k: usize| u32::from_be_bytes(bytes[4 * k..4 * k + 4].try_into().expect("4 bytes"));
    let [header, format, width, height] = [0, 2, 4, 5].map(field);
    let [bits, stride, colours] = [11, 12, 19].map(field);
    let (order, masks) = (field(7), [14, 15, 16].map(field));
    assert_eq!(
        (format, bits, masks),
        (2, 32, [0xff_0000, 0xff00, 0xff]),
        "not 24-bit TrueColor"
    );
    let start = (header + 12 * colours) as usize;
    Raster::from_fn(RasterSize { width, height }, |x, y| {
        let at = start + (y * stride + 4 * x) as usize;
        let pixel: [u8; 4] = bytes[at..at + 4].try_into().expect("4 bytes");
        let value = if order == 0 {
            u32::from_le_bytes(pixel)
        } else {
            u32::from_be_bytes(pixel)
        };
        let [_, red, green, blue] = value.to_be_bytes();
        Rgb([red, green, blue])
    })
}
