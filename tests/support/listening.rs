//! Waiting for clients in threads that can be ended.

use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Context;

/// How often the threads look whether they should end.
const LOOK: Duration = Duration::from_millis(50);

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
