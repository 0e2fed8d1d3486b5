//! One connection: connecting, the first words, and the thread that reads.
//!
//! Replies are handed to the caller that waits for the request's number, notices to the queue. When
//! the connection ends, every caller that waits learns why.

use std::collections::HashMap;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use shared::protocol::{
    ClientMessage, Command, DEFAULT_PORT, Decoder, Hello, ProjectorState, Request, ServerMessage,
    VERSION, encode,
};

use super::notices::{Notice, Notices};
use super::pairing::{Credentials, remembered};
use super::wire::{Wire, is_other_certificate};
use super::{LinkError, LinkSettings};
use crate::clock::monotonic_now;

/// Unreadable lines in the first words after which the peer is no projector.
const PATIENCE_LINES: usize = 3;

/// A reply and the times around it.
#[derive(Debug)]
pub(super) struct Reply {
    pub(super) message: ServerMessage,
    pub(super) sent_at: Duration,
    pub(super) received_at: Duration,
}

/// A reply on its way to its caller, with the time it came.
type Arrival = (ServerMessage, Duration);

/// Who waits for which reply; nothing once the connection has ended, then with the reason.
#[derive(Debug)]
enum Waiting {
    Open(HashMap<u64, SyncSender<Arrival>>),
    Ended(String),
}

/// What callers and the reading thread share.
#[derive(Debug)]
struct Shared {
    waiting: Mutex<Waiting>,
    notices: Notices,
}

impl Shared {
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the connection for everybody; the first reason stays.
    fn end(&self, reason: &str) {
        let mut waiting = self.waiting();
        if matches!(*waiting, Waiting::Open(_)) {
            *waiting = Waiting::Ended(reason.to_owned()); // drops the senders, which wakes the callers
        }
        drop(waiting);
        self.notices.end(reason);
    }

    fn end_reason(&self) -> String {
        match &*self.waiting() {
            Waiting::Ended(reason) => reason.clone(),
            Waiting::Open(_) => "it was closed".into(),
        }
    }

    /// Gives a message to whoever it is for.
    fn deliver(&self, message: ServerMessage) {
        let now = monotonic_now();
        if let Some(id) = message.reply_to() {
            if let Waiting::Open(callers) = &mut *self.waiting()
                && let Some(caller) = callers.remove(&id)
                && caller.try_send((message, now)).is_err()
            {
                tracing::debug!(id, "a reply came after its caller had given up");
            }
            return;
        }
        match message {
            ServerMessage::Shown(shown) => self.notices.push(Notice::Shown {
                shown,
                received_at: now,
            }),
            ServerMessage::StateChanged { state } => {
                self.notices.push(Notice::StateChanged(Box::new(state)));
            }
            ServerMessage::Controller { change, name } => {
                self.notices.push(Notice::Controller { change, name });
            }
            ServerMessage::Error { code, message, .. } => {
                tracing::warn!(?code, "the projector complains: {message}");
            }
            other => tracing::debug!(?other, "a message that nobody asked for"),
        }
    }
}

/// An open connection.
#[derive(Debug)]
pub(super) struct Connection {
    wire: Arc<Wire>,
    shared: Arc<Shared>,
    reader: Option<JoinHandle<()>>,
    welcome: Welcome,
    next_id: AtomicU64,
    reply_timeout: Duration,
}

/// The projector's first words.
#[derive(Debug)]
struct Welcome {
    state: ProjectorState,
    /// Our own token, when we have just been paired.
    new_token: Option<String>,
}

impl Connection {
    /// To a projector, with what is remembered of it.
    pub(super) fn to(settings: &LinkSettings) -> Result<Self, LinkError> {
        let known = remembered(&settings.address);
        let known = known.map_err(|error| LinkError::Remembered(error.to_string()))?;
        Self::open(settings, known)
    }

    pub(super) fn open(
        settings: &LinkSettings,
        credentials: Option<Credentials>,
    ) -> Result<Self, LinkError> {
        let address = &settings.address;
        let stream = reach(address, settings.connect_timeout)?;
        let unreachable = |error: std::io::Error| unreachable(address, &error);
        stream.set_nodelay(true).map_err(unreachable)?; // requests are small and waited for
        stream
            .set_write_timeout(Some(settings.reply_timeout))
            .map_err(unreachable)?;
        let wire = Arc::new(protect(stream, settings, credentials)?);
        let mut decoder = Decoder::new();
        let token = credentials.map(|known| known.token.to_string());
        let welcome = greet(&wire, &mut decoder, settings, token)?;
        wire.set_receive_timeout(None).map_err(unreachable)?;
        let shared = Arc::new(Shared {
            waiting: Mutex::new(Waiting::Open(HashMap::new())),
            notices: Notices::default(),
        });
        let reader = std::thread::Builder::new()
            .name("projector link".into())
            .spawn({
                let (shared, wire) = (Arc::clone(&shared), Arc::clone(&wire));
                move || read_until_the_end(&wire, decoder, &shared)
            })
            .map_err(unreachable)?;
        Ok(Self {
            wire,
            shared,
            reader: Some(reader),
            welcome,
            next_id: AtomicU64::new(1),
            reply_timeout: settings.reply_timeout,
        })
    }

    pub(super) fn first_state(&self) -> &ProjectorState {
        &self.welcome.state
    }

    /// The token that the projector gave us while it paired us.
    pub(super) fn new_token(&self) -> Option<&str> {
        self.welcome.new_token.as_deref()
    }

    /// Sends a command and waits for its reply.
    pub(super) fn request(&self, command: Command) -> Result<Reply, LinkError> {
        let id = self.next_id.fetch_add(1, Ordering::Relaxed);
        let (sender, reply) = sync_channel(1);
        match &mut *self.shared.waiting() {
            Waiting::Open(callers) => callers.insert(id, sender),
            Waiting::Ended(reason) => return Err(LinkError::Lost(reason.clone())),
        };
        let sent_at = monotonic_now();
        if let Err(error) = self.write(&Request { id, command }.into()) {
            // Half a line may have gone out: nothing sent later could be read.
            self.shared.end(&error.to_string());
            return Err(LinkError::Lost(error.to_string()));
        }
        match reply.recv_timeout(self.reply_timeout) {
            Ok((message @ ServerMessage::Error { .. }, _)) => Err(LinkError::unexpected(&message)),
            Ok((message, received_at)) => Ok(Reply {
                message,
                sent_at,
                received_at,
            }),
            Err(RecvTimeoutError::Timeout) => {
                if let Waiting::Open(callers) = &mut *self.shared.waiting() {
                    callers.remove(&id);
                }
                Err(LinkError::NoReply {
                    waited: self.reply_timeout,
                })
            }
            Err(RecvTimeoutError::Disconnected) => Err(LinkError::Lost(self.shared.end_reason())),
        }
    }

    fn write(&self, message: &ClientMessage) -> std::io::Result<()> {
        self.wire.send(encode(message).as_bytes())
    }

    pub(super) fn next_notice(&self, timeout: Duration) -> Result<Option<Notice>, LinkError> {
        self.shared.notices.take(timeout).map_err(LinkError::Lost)
    }

    pub(super) fn notices_dropped(&self) -> u64 {
        self.shared.notices.dropped()
    }

    /// Closes the connection and waits for the reading thread, which the shutdown wakes.
    pub(super) fn close(&mut self) {
        self.shared.end("it was closed");
        // Fails only if the peer has closed already.
        drop(self.wire.shutdown());
        if let Some(reader) = self.reader.take()
            && reader.join().is_err()
        {
            tracing::warn!("the thread that reads from the projector had died");
        }
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.close();
    }
}

/// A TCP connection to the first of the address's machines that answers.
fn reach(address: &str, timeout: Duration) -> Result<TcpStream, LinkError> {
    let bad = |reason: String| LinkError::Address {
        address: address.to_owned(),
        reason,
    };
    let mut last = bad("the name has no address".into());
    for machine in machines(address).map_err(|error| bad(error.to_string()))? {
        match TcpStream::connect_timeout(&machine, timeout) {
            Ok(stream) => return Ok(stream),
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => {
                last = LinkError::Refused {
                    address: machine.to_string(),
                };
            }
            Err(error) => last = unreachable(&machine.to_string(), &error),
        }
    }
    Err(last)
}

fn machines(address: &str) -> std::io::Result<Vec<SocketAddr>> {
    match address.to_socket_addrs() {
        Ok(machines) => Ok(machines.collect()),
        // A host alone means the usual port.
        Err(error) => match (address, DEFAULT_PORT).to_socket_addrs() {
            Ok(machines) => Ok(machines.collect()),
            Err(_) => Err(error),
        },
    }
}

fn unreachable(address: &str, error: &std::io::Error) -> LinkError {
    LinkError::Unreachable {
        address: address.to_owned(),
        reason: error.to_string(),
    }
}

/// Brings TLS over the connection to a paired projector. Others are spoken to on this computer only.
fn protect(
    stream: TcpStream,
    settings: &LinkSettings,
    credentials: Option<Credentials>,
) -> Result<Wire, LinkError> {
    let address = &settings.address;
    let unreachable = |error: std::io::Error| unreachable(address, &error);
    let here = stream.peer_addr().map_err(unreachable)?.ip().is_loopback();
    let timeout = Some(settings.connect_timeout);
    stream.set_read_timeout(timeout).map_err(unreachable)?;
    match credentials {
        Some(known) => Wire::protected(stream, known.fingerprint).map_err(|error| {
            if is_other_certificate(&error) {
                return LinkError::OtherProjector {
                    address: address.clone(),
                };
            }
            LinkError::NotAProjector {
                address: address.clone(),
                reason: format!("it does not speak TLS as when it was paired: {error}"),
            }
        }),
        None if here => Ok(Wire::plain(stream)),
        None => Err(LinkError::NotPaired {
            address: address.clone(),
            reason: "nothing is remembered of it here".into(),
        }),
    }
}

/// Says hello and waits for the welcome; bytes behind it stay in the decoder.
fn greet(
    wire: &Wire,
    decoder: &mut Decoder<ServerMessage>,
    settings: &LinkSettings,
    token: Option<String>,
) -> Result<Welcome, LinkError> {
    let address = &settings.address;
    let stranger = |reason: String| LinkError::NotAProjector {
        address: address.clone(),
        reason,
    };
    let name = settings.name.clone();
    let hello = Hello {
        version: VERSION,
        role: settings.role,
        name,
        take_over: settings.take_over,
        token,
    };
    wire.send(encode(&ClientMessage::from(hello)).as_bytes())
        .map_err(|error| stranger(error.to_string()))?;
    let deadline = Instant::now() + settings.connect_timeout;
    let (mut bytes, mut unreadable, mut new_token) = (Vec::new(), 0, None);
    loop {
        while let Some(message) = decoder.next_message() {
            match message {
                Ok(ServerMessage::Welcome {
                    version: VERSION,
                    role,
                    state,
                }) if role == settings.role => {
                    return Ok(Welcome { state, new_token });
                }
                Ok(ServerMessage::Paired { token }) => new_token = Some(token),
                Ok(ServerMessage::Welcome { version, role, .. }) => {
                    return Err(LinkError::Version(format!(
                        "the projector speaks version {version} and made us {role:?}, this program speaks version {VERSION}"
                    )));
                }
                Ok(other) => return Err(LinkError::refusal(address, &other)),
                Err(error) => {
                    unreadable += 1;
                    if unreadable == PATIENCE_LINES {
                        return Err(stranger(error.to_string()));
                    }
                }
            }
        }
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(stranger(format!(
                "no welcome within {} ms",
                settings.connect_timeout.as_millis()
            )));
        }
        wire.set_receive_timeout(Some(left))
            .map_err(|error| unreachable(address, &error))?;
        bytes.clear();
        match wire.receive(&mut bytes) {
            Ok(0) => return Err(stranger("it closed the connection without a word".into())),
            Ok(_) => decoder.push(&bytes),
            Err(error) if again(&error) => {}
            Err(error) => return Err(stranger(error.to_string())),
        }
    }
}

/// A read that found nothing and may be repeated.
fn again(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// The body of the reading thread.
fn read_until_the_end(wire: &Wire, mut decoder: Decoder<ServerMessage>, shared: &Shared) {
    let mut bytes = Vec::new();
    loop {
        while let Some(message) = decoder.next_message() {
            match message {
                Ok(message) => shared.deliver(message),
                Err(error) => {
                    tracing::warn!(%error, "the projector sent a line that cannot be read");
                }
            }
        }
        bytes.clear();
        match wire.receive(&mut bytes) {
            Ok(0) => return shared.end("the projector closed it"),
            Ok(_) => decoder.push(&bytes),
            Err(error) if again(&error) => {}
            Err(error) => return shared.end(&error.to_string()),
        }
    }
}
