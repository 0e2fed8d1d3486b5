//! Servers of the tests: threads that can be ended, and clients that they wait for.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context;

/// How often the threads look whether they should end.
const LOOK: Duration = Duration::from_millis(50);

/// Threads that are told to end, and waited for, when this is dropped.
#[derive(Debug, Default)]
pub(crate) struct Threads {
    stop: Arc<AtomicBool>,
    running: Vec<JoinHandle<()>>,
}

impl Threads {
    /// Starts one; what it is given tells when it should end.
    pub(crate) fn start(&mut self, work: impl FnOnce(&Arc<AtomicBool>) + Send + 'static) {
        let stop = Arc::clone(&self.stop);
        self.running.push(std::thread::spawn(move || work(&stop)));
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.running.drain(..) {
            if thread.join().is_err() {
                eprintln!("a server's thread has died");
            }
        }
    }
}

/// A listener on a free port of this machine that does not block, so that its thread can end.
pub(crate) fn listener() -> anyhow::Result<TcpListener> {
    let listener = TcpListener::bind("127.0.0.1:0").context("no free port")?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// The next client, or nothing when the server should end.
pub(crate) fn client(listener: &TcpListener, stop: &AtomicBool) -> Option<TcpStream> {
    while !stop.load(Ordering::Relaxed) {
        match listener.accept() {
            Ok((stream, _)) => return stream.set_nonblocking(false).ok().map(|()| stream),
            Err(_) => std::thread::sleep(LOOK),
        }
    }
    None
}
