//! The network side: takes commands over TCP and tells everybody what is shown.
//!
//! `server` accepts connections, `places` says which may stay, `connection` turns one connection's bytes into events and back, and
//! `hub` does the events one by one: it owns the [`State`](crate::state::State) and is the only one to
//! change it. All of it runs in one thread of its own; every queue is bounded, and a client that does not
//! read is disconnected rather than waited for.

mod server;

mod connection;

mod places;

mod hub;

use std::{
    io,
    net::{SocketAddr, TcpListener},
    sync::Arc,
    thread::{self, JoinHandle},
};

use serde::{Deserialize, Serialize};
use shared::{pattern::GridSettings, protocol::View};
use thiserror::Error;
use tokio::sync::{mpsc, watch};

use crate::{
    access::Access,
    clock::Clock,
    screen::{Orders, Reporter},
};

/// Events that may wait for the hub; a connection whose event finds no room waits.
const EVENT_QUEUE: usize = 64;
/// Reports of the screen that may wait for the hub; there is one per picture.
const SCREEN_QUEUE: usize = 16;

/// Why the projector does not take commands.
#[derive(Debug, Error)]
pub enum ControlError {
    /// The address cannot be listened on.
    #[error(
        "cannot listen on {address}: choose another address with --listen if another projector runs"
    )]
    Listen {
        /// The address asked for.
        address: String,
        /// The system's reason.
        source: io::Error,
    },
    /// The system refuses a thread or an event queue.
    #[error("cannot start the network thread")]
    Start(#[source] io::Error),
    /// The thread ended by a defect.
    #[error("the network thread ended unexpectedly")]
    Ended,
}

/// What happens to the picture when the controller's connection ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnControllerLost {
    /// It stays.
    #[default]
    Keep,
    /// It turns black.
    Blank,
}

/// How commands are taken.
#[derive(Debug, Clone)]
pub struct ControlSettings {
    /// Most clients at a time.
    pub max_connections: usize,
    /// Messages that may wait for one client before it is disconnected.
    pub queue_messages: usize,
    /// What happens when the controller is lost.
    pub on_controller_lost: OnControllerLost,
    /// The grid to begin with.
    pub grid: GridSettings,
    /// The view to begin with.
    pub view: View,
    /// Who is let in, on a socket that is reached over a network.
    pub access: Option<Arc<Access>>,
}

/// A socket that listens, with nobody to answer yet.
#[derive(Debug)]
pub struct Listening {
    listener: TcpListener,
    address: SocketAddr,
}

impl Listening {
    /// Listens on an address like `127.0.0.1:4460`; port 0 takes a free one.
    ///
    /// # Errors
    /// The address is not one of this machine's, or is in use.
    pub fn bind(address: &str) -> Result<Self, ControlError> {
        let bind = || {
            let listener = TcpListener::bind(address)?;
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok(Self { listener, address })
        };
        bind().map_err(|source| ControlError::Listen {
            address: address.to_owned(),
            source,
        })
    }

    /// The address, with the port that was really taken.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

/// The running network thread.
#[derive(Debug)]
pub struct Control {
    thread: JoinHandle<()>,
    stop: watch::Sender<bool>,
}

impl Control {
    /// Starts the thread. Once the screen has presented the first picture, `ready` is called and clients
    /// are answered; pictures go to `orders`. What the screen reports goes into the reporter given back.
    ///
    /// # Errors
    /// The system refuses a thread or an event queue.
    pub fn start(
        listening: Listening,
        settings: ControlSettings,
        orders: Arc<Orders>,
        ready: impl FnOnce(SocketAddr) + Send + 'static,
    ) -> Result<(Self, Reporter), ControlError> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(ControlError::Start)?;
        let (presented, presented_in) = mpsc::channel(SCREEN_QUEUE);
        let (operator, operator_in) = mpsc::channel(SCREEN_QUEUE);
        let (info, info_in) = watch::channel(None);
        let (stop, stop_in) = watch::channel(false);
        let clock = Clock::start();
        let reporter = Reporter {
            clock,
            info,
            presented,
            operator,
        };
        let screen = hub::ScreenSide {
            orders: orders.clone(),
            info: info_in,
            presented: presented_in,
            operator: operator_in,
        };
        let work = server::serve(listening, settings, screen, clock, ready);
        let thread = thread::Builder::new()
            .name("control".to_owned())
            .spawn(move || {
                // Whatever ends this thread ends the program: a screen nobody can command is of no use.
                let _end = EndOnDrop(orders);
                runtime.block_on(until_stopped(work, stop_in));
            })
            .map_err(ControlError::Start)?;
        Ok((Self { thread, stop }, reporter))
    }

    /// Closes all connections and ends the thread.
    ///
    /// # Errors
    /// The thread had ended by a defect.
    pub fn stop(self) -> Result<(), ControlError> {
        self.stop.send_replace(true);
        self.thread.join().map_err(|_| ControlError::Ended)
    }
}

struct EndOnDrop(Arc<Orders>);

impl Drop for EndOnDrop {
    fn drop(&mut self) {
        self.0.end();
    }
}

async fn until_stopped(work: impl Future<Output = ()>, mut stop: watch::Receiver<bool>) {
    tokio::select! {
        () = work => {}
        // An error means that the program has dropped the sender, which is an end as well.
        _ = stop.wait_for(|stopped| *stopped) => {}
    }
}
