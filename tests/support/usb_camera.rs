//! A USB webcam made of the simulated room, for the kernel's own `uvcvideo` driver in the guest.
//!
//! Takes a scene and a running projector, serves the room's camera as a USB device over TCP, in the protocol of USB/IP
//! (Linux, `Documentation/usb/usbip_protocol.rst`) as far as a device needs it that was imported already: the program
//! `usb_attach` hands the connection to the guest's kernel, which finds a camera of the USB video class 1.0 with a
//! bulk endpoint. Formats, frame rates and controls are asked for and set by the driver, as with any webcam, and do to
//! the frames what the simulated camera's controls do. A second port takes lines that cause trouble and answers
//! `done`: `stall MS` sends nothing for a while, `errors N` flags the next N frames as broken, `cut N` ends them half-way,
//! `background` and `object` are the stages.

mod descriptors;
mod requests;
mod stream;
mod wire;

use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use acquirer::camera::SimulatedCamera;
use anyhow::Context;
use shared::stage::Stage;

use crate::listening::{Threads, client, listener};
use requests::{Answer, Device};
use stream::Faults;
use wire::{Direction, Message, Replies, Submit};

/// Longest wait of the streaming thread before it looks whether it should end.
const LOOK: Duration = Duration::from_millis(50);

/// A USB camera that can be attached until it is dropped.
#[derive(Debug)]
pub struct UsbCamera {
    device: SocketAddr,
    orders: SocketAddr,
    _threads: Threads,
}

impl UsbCamera {
    /// Opens the room of a scene in front of a projector (`HOST:PORT`) and offers its camera.
    ///
    /// # Errors
    /// When the room cannot be opened or no port is free.
    pub fn start(scene: &str, projector: &str) -> anyhow::Result<Self> {
        let camera = SimulatedCamera::open(scene, projector)?;
        let (device, orders) = (listener()?, listener()?);
        let addresses = (device.local_addr()?, orders.local_addr()?);
        let shared = Arc::new(Shared {
            device: Mutex::new(Device::new(camera)),
            pending: Mutex::new(Vec::new()),
            arrived: Condvar::new(),
            faults: Mutex::new(Faults::default()),
        });
        let ordered = Arc::clone(&shared);
        let mut threads = Threads::default();
        threads.start(move |stop| serve(&device, &shared, stop));
        threads.start(move |stop| take_orders(&orders, &ordered, stop));
        Ok(Self {
            device: addresses.0,
            orders: addresses.1,
            _threads: threads,
        })
    }

    /// Port at which `usb_attach` gets the device, on this machine.
    #[must_use]
    pub fn device_port(&self) -> u16 {
        self.device.port()
    }

    /// Port that takes orders.
    #[must_use]
    pub fn order_port(&self) -> u16 {
        self.orders.port()
    }
}

/// What the threads share.
struct Shared {
    device: Mutex<Device>,
    /// Reads of the video endpoint that wait for a frame, in their order.
    pending: Mutex<Vec<Submit>>,
    arrived: Condvar,
    faults: Mutex<Faults>,
}

/// Every change under these locks is a whole assignment, so that a thread that died left nothing half done.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Serves one connection after the other: a plug pulled and put in again.
fn serve(listener: &TcpListener, shared: &Arc<Shared>, stop: &Arc<AtomicBool>) {
    while let Some(connection) = client(listener, stop) {
        lock(&shared.device).unplug();
        lock(&shared.pending).clear();
        let plugged = Arc::new(AtomicBool::new(true));
        match serve_connection(connection, shared, stop, &plugged) {
            Err(error) if !is_pulled(&error) => eprintln!("USB camera: {error:#}"),
            _ => {}
        }
        plugged.store(false, Ordering::Relaxed);
    }
}

/// Whether the guest has let go of the device.
fn is_pulled(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<std::io::Error>().map(|e| e.kind());
    matches!(
        kind,
        Some(ErrorKind::BrokenPipe | ErrorKind::ConnectionReset)
    )
}

fn serve_connection(
    connection: TcpStream,
    shared: &Arc<Shared>,
    stop: &Arc<AtomicBool>,
    plugged: &Arc<AtomicBool>,
) -> anyhow::Result<()> {
    connection.set_nodelay(true)?;
    connection.set_read_timeout(Some(LOOK))?;
    let replies = Arc::new(Replies::to(connection.try_clone()?));
    let streaming = std::thread::spawn({
        let (shared, replies) = (Arc::clone(shared), Arc::clone(&replies));
        let (stop, plugged) = (Arc::clone(stop), Arc::clone(plugged));
        move || {
            let ended = || stop.load(Ordering::Relaxed) || !plugged.load(Ordering::Relaxed);
            stream::send_frames(&shared, &replies, &ended)
        }
    });
    let ended = || stop.load(Ordering::Relaxed) || streaming.is_finished();
    let mut reader = wire::Requests::from(connection);
    let served = loop {
        match reader.next(&ended) {
            Ok(Some(message)) => {
                if let Err(error) = take(message, shared, &replies) {
                    break Err(error);
                }
            }
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    plugged.store(false, Ordering::Relaxed);
    shared.arrived.notify_all();
    match streaming.join() {
        Ok(streamed) => served.and(streamed),
        Err(_) => anyhow::bail!("the thread that sends frames has died"),
    }
}

fn take(message: Message, shared: &Shared, replies: &Replies) -> anyhow::Result<()> {
    match message {
        Message::Submit(submit) if submit.endpoint == 0 => {
            let answer = lock(&shared.device).answer(submit.setup, &submit.data);
            match answer {
                Answer::Data(data) => replies.data(&submit, &data),
                Answer::Taken => replies.taken(&submit),
                Answer::Stall => replies.stall(&submit),
            }
        }
        Message::Submit(submit) if submit.direction == Direction::In => {
            lock(&shared.pending).push(submit);
            shared.arrived.notify_all();
            Ok(())
        }
        Message::Submit(submit) => replies.stall(&submit),
        Message::Unlink { number, unlinks } => {
            let mut pending = lock(&shared.pending);
            let place = pending.iter().position(|submit| submit.number == unlinks);
            if let Some(place) = place {
                pending.remove(place);
            }
            replies.unlinked(number, place.is_some())
        }
    }
    .context("answering the guest")
}

fn take_orders(listener: &TcpListener, shared: &Shared, stop: &AtomicBool) {
    while let Some(mut stream) = client(listener, stop) {
        let mut line = String::new();
        let read = stream
            .try_clone()
            .and_then(|stream| BufReader::new(stream).read_line(&mut line));
        let words: Vec<&str> = line.split_whitespace().collect();
        let done = read.is_ok() && order(&words, shared).is_some();
        let answer = if done { "done\n" } else { "unknown\n" };
        stream.write_all(answer.as_bytes()).ok(); // whoever asked may have gone
    }
}

/// Carries out an order; nothing for one that is none.
fn order(words: &[&str], shared: &Shared) -> Option<()> {
    let stage = |name: &str| Stage::BOTH.into_iter().find(|stage| stage.name() == name);
    match words {
        ["stall", ms] => lock(&shared.faults).stall_ms = ms.parse().ok()?,
        ["errors", count] => lock(&shared.faults).errors = count.parse().ok()?,
        ["cut", count] => lock(&shared.faults).cut = count.parse().ok()?,
        [name] => lock(&shared.device).camera.set_stage(stage(name)?),
        _ => return None,
    }
    Some(())
}
