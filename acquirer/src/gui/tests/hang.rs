//! The window goes on while its rig hangs: in the opening, in the camera, in the projector.

use std::{
    io::{BufRead, BufReader, Write},
    net::{TcpListener, TcpStream},
    sync::{
        Mutex,
        mpsc::{Receiver, Sender, SyncSender, channel, sync_channel},
    },
    thread,
    time::{Duration, Instant},
};

use eframe::egui::Key;
use egui_kittest::{Harness, kittest::Queryable};
use look::log::Warnings;
use shared::protocol::{Role, ServerMessage, VERSION, encode};

use super::fixture::rig;
use crate::{
    camera::{Camera, CameraError, CaptureFormat, Frame, Losses, PixelFormat, Rate},
    cli::RigArgs,
    config::Config,
    gui::{
        live_picture::LivePlace,
        model::{Model, Ports, Tab},
        preferences::Preferences,
        style,
        waker::Waker,
        window,
        worker::{RigWorker, Teller},
    },
    projector_link::{LinkSettings, ProjectorLink},
    session::{Cancel, Rig},
};

/// No wait of the test is anywhere near as long.
const LONG: Duration = Duration::from_secs(100);

/// A camera that gives no frame until it is let go on, and says when it is asked for one.
struct HangingCamera {
    asked: Sender<()>,
    go_on: Receiver<()>,
}

impl Camera for HangingCamera {
    fn description(&self) -> String {
        "a camera that hangs".into()
    }

    fn format(&self) -> CaptureFormat {
        CaptureFormat {
            width: 640,
            height: 480,
            rate: Rate::new(30, 1).unwrap(),
            pixels: PixelFormat::Yuyv,
        }
    }

    fn losses(&self) -> Losses {
        Losses::default()
    }

    fn next_frame(&mut self, waited: Duration) -> Result<Frame, CameraError> {
        self.asked.send(()).ok();
        self.go_on.recv().ok();
        let name = self.description();
        Err(CameraError::NoFrame { name, waited })
    }
}

/// A projector that lets everybody in, tells its state, and answers nothing else: it says when it is asked for that.
fn silent_projector(asked: Sender<()>) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        let mut lines = BufReader::new(stream);
        let state = || rig().projector;
        let mut line = String::new();
        while lines.read_line(&mut line).is_ok_and(|read| read > 0) {
            let request: serde_json::Value = serde_json::from_str(&line).unwrap();
            let id = request["id"].as_u64();
            match (request["type"].as_str(), id) {
                (Some("hello"), _) => say(&mut lines, &welcome(state())),
                (Some("state"), Some(id)) => {
                    let state = state();
                    say(&mut lines, &ServerMessage::State { id, state });
                }
                _ => asked.send(()).unwrap_or_default(),
            }
            line.clear();
        }
    });
    address
}

fn welcome(state: shared::protocol::ProjectorState) -> ServerMessage {
    ServerMessage::Welcome {
        version: VERSION,
        role: Role::Controller,
        state,
    }
}

fn say(peer: &mut BufReader<TcpStream>, message: &ServerMessage) {
    let line = encode(message);
    peer.get_mut().write_all(line.as_bytes()).unwrap();
}

/// The window with a real thread for its rig.
struct Hung {
    harness: Harness<'static, Model>,
    /// The rig is being opened; it is, once this is answered.
    opening: Receiver<()>,
    open: SyncSender<()>,
    camera_asked: Receiver<()>,
    camera: SyncSender<()>,
    projector_asked: Receiver<()>,
}

impl Hung {
    fn start() -> Self {
        let (opening_sender, opening) = channel();
        let (open, may_open) = sync_channel(1);
        let (camera_sender, camera_asked) = channel();
        let (camera, go_on) = sync_channel(1);
        let (projector_sender, projector_asked) = channel();
        let address = silent_projector(projector_sender);
        let (jobs_sender, jobs) = sync_channel(8);
        let (files, _) = sync_channel(8);
        let (events_sender, events) = sync_channel(64);
        let cancel = Cancel::default();
        let ports = Ports {
            jobs: jobs_sender,
            files,
            events,
            live: LivePlace::default(),
            cancel: cancel.clone(),
            cancel_files: cancel.beside(),
            log: Warnings::default(),
        };
        let source = rig().source;
        let (preferences, live) = (Preferences::default(), ports.live.clone());
        let places = (address.clone(), "scan".into());
        let model = Model::new(ports, preferences, source.clone(), places, false);
        let shown = |ui: &mut eframe::egui::Ui, model: &mut Model| {
            model.take_events();
            window::show(model, ui);
        };
        let harness = Harness::builder()
            .with_size([1280.0, 720.0])
            .with_context_setup(style::apply)
            .build_ui_state(shown, model);
        let parts = Mutex::new(Some((camera_sender, go_on)));
        let worker = RigWorker {
            open: Box::new(move |args: &RigArgs, _: &Config| {
                opening_sender.send(()).ok();
                may_open.recv().ok();
                let (asked, go_on) = parts.lock().unwrap().take().unwrap();
                let settings = LinkSettings::new(&args.projector, "acquirer", Role::Controller);
                let projector = ProjectorLink::connect(&settings)?;
                let camera = Box::new(HangingCamera { asked, go_on });
                Ok(Rig::new(projector, camera))
            }),
            rig: RigArgs {
                projector: address,
                camera: None,
                camera_settings: Default::default(),
                take_over: false,
                config: Default::default(),
            },
            source,
            config: Config::default(),
            out: "scan".into(),
            calibration: None,
            read_live: None,
            cancel,
            jobs,
            live,
            teller: Teller {
                events: events_sender,
                waker: Waker::new(&harness.ctx),
            },
        };
        thread::spawn(move || worker.run());
        Self {
            harness,
            opening,
            open,
            camera_asked,
            camera,
            projector_asked,
        }
    }

    /// Frames keep coming, and the window does what it is told to.
    fn works(&mut self, during: &str) {
        let mut longest = Duration::ZERO;
        let keys = [Key::Num2, Key::Num3, Key::Num4, Key::Num1];
        let tabs = [Tab::Steps, Tab::Result, Tab::Compare, Tab::Live];
        for (key, tab) in keys.into_iter().zip(tabs).cycle().take(20) {
            self.harness.key_press(key);
            let begun = Instant::now();
            self.harness.run_steps(2);
            longest = longest.max(begun.elapsed() / 2);
            assert_eq!(self.harness.state().tab, tab, "during {during}");
        }
        println!("during {during} a frame took at most {longest:?}");
    }
}

#[test]
fn the_window_goes_on_while_opening_camera_and_projector_hang() {
    let mut hung = Hung::start();
    hung.opening.recv_timeout(LONG).unwrap();
    hung.works("the opening");
    assert!(hung.harness.state().rig.is_err());

    hung.open.send(()).unwrap();
    hung.camera_asked.recv_timeout(LONG).unwrap();
    hung.works("a camera without frames");
    assert!(hung.harness.state().rig.is_ok());

    hung.harness.get_by_label("Identify").click();
    hung.harness.run_steps(3);
    hung.camera.send(()).unwrap();
    hung.projector_asked.recv_timeout(LONG).unwrap();
    hung.works("a projector without an answer");
    hung.harness.key_press(Key::Escape);
    hung.harness.run_steps(2);
    assert!(hung.harness.state().ports.cancel.is_cancelled());
}
