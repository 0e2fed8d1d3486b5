//! One client's connection: bytes to events for the hub, messages to bytes.
//!
//! Reading waits for the hub, so a client that sends faster than pictures can be shown is slowed down.
//! Writing never makes the hub wait: messages go into a bounded queue, and when that is full the connection
//! is cut. On a network everything goes through TLS, and a hello needs the token of a pairing; a pairing that is
//! revoked ends its connection. `ping` is answered here, so that a picture in progress does not lengthen the round trip.

use std::{
    io,
    sync::{Arc, OnceLock},
    time::Duration,
};

use shared::protocol::{
    ClientMessage, Command, DecodeError, Decoder, ErrorCode, Hello, Request, ServerMessage, encode,
};
use tokio::{
    io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt},
    net::TcpStream,
    sync::{Notify, mpsc},
};
use tokio_rustls::TlsAcceptor;

use super::places::{Place, Stranger};
use crate::{access::Access, clock::Clock, state::ConnectionId};

/// Longest time a client may take to say hello.
const HELLO_TIMEOUT: Duration = Duration::from_secs(10);
/// Longest time a farewell may take to be sent.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(1);
/// How often a connection looks whether its pairing was revoked.
const REVOCATION_CHECK: Duration = Duration::from_secs(1);
/// First byte of every TLS connection: a handshake record.
const TLS_HANDSHAKE: u8 = 0x16;
/// Bytes read at a time.
const READ_BYTES: usize = 4096;

/// What a connection tells the hub.
#[derive(Debug)]
pub(super) enum Event {
    /// A client said hello.
    Hello(ConnectionId, Hello, Peer),
    /// A client asked for something.
    Request(ConnectionId, Request),
    /// The connection ended.
    Gone(ConnectionId),
    /// A pairing code is open, or none is any more.
    PairingCode(Option<String>),
}

#[derive(Debug)]
enum Outgoing {
    Line(Arc<str>),
    /// Nothing comes after this; the connection ends when all before is sent.
    Last,
}

/// The way to a client.
#[derive(Debug, Clone)]
pub(super) struct Peer {
    queue: mpsc::Sender<Outgoing>,
    cut: Arc<Notify>,
}

impl Peer {
    /// Sends a line; cuts the connection and gives `false` if the client does not read.
    pub(super) fn send_line(&self, line: Arc<str>) -> bool {
        self.put(Outgoing::Line(line))
    }

    /// Sends a message; cuts the connection and gives `false` if the client does not read.
    pub(super) fn send(&self, message: &ServerMessage) -> bool {
        self.send_line(encode(message).into())
    }

    /// Ends the connection once everything before is sent.
    pub(super) fn close(&self) {
        self.put(Outgoing::Last);
    }

    fn put(&self, outgoing: Outgoing) -> bool {
        let taken = self.queue.try_send(outgoing).is_ok();
        if !taken {
            self.cut.notify_one();
        }
        taken
    }
}

/// What every connection is served with.
#[derive(Debug, Clone)]
pub(super) struct Service {
    /// Messages that may wait for one client.
    pub(super) queue_messages: usize,
    /// Who is let in; nothing where everybody is.
    pub(super) access: Option<Arc<Access>>,
    pub(super) events: mpsc::Sender<Event>,
    pub(super) clock: Clock,
}

/// Serves one connection until it ends, or until there is no room for a stranger any more.
pub(super) async fn run(id: ConnectionId, stream: TcpStream, stranger: Stranger, service: Service) {
    let stranger = Arc::new(stranger);
    let Some(access) = &service.access else {
        return talk(id, stream, stranger, service).await;
    };
    let acceptor = TlsAcceptor::from(access.tls());
    let protecting = tokio::time::timeout(HELLO_TIMEOUT, protect(stream, acceptor));
    let protected = tokio::select! {
        protected = protecting => protected,
        () = stranger.sent_away() => return log_sent_away(id),
    };
    match protected {
        Ok(Ok(protected)) => talk(id, protected, stranger, service).await,
        Ok(Err(error)) => tracing::info!("connection {} refused: {error}", id.0),
        Err(_) => tracing::info!("connection {} refused: no TLS handshake in time", id.0),
    }
}

fn log_sent_away(id: ConnectionId) {
    tracing::info!(
        "connection {} ended before its hello: too many wait to be let in",
        id.0
    );
}

/// The TLS handshake. A client that does not speak TLS is told so in words it understands.
async fn protect(
    mut stream: TcpStream,
    acceptor: TlsAcceptor,
) -> io::Result<tokio_rustls::server::TlsStream<TcpStream>> {
    let mut first = [0];
    if stream.peek(&mut first).await? == 1 && first[0] != TLS_HANDSHAKE {
        let refusal = ServerMessage::Error {
            id: None,
            code: ErrorCode::Token,
            message: "this projector speaks TLS and lets in who is paired: type `acquirer pair CODE` with the code \
                      that `projector pair` makes there"
                .to_owned(),
        };
        stream.write_all(encode(&refusal).as_bytes()).await?;
        stream.shutdown().await?;
        return Err(io::Error::other("the client does not speak TLS"));
    }
    acceptor.accept(stream).await
}

async fn talk<S: AsyncRead + AsyncWrite>(
    id: ConnectionId,
    stream: S,
    stranger: Arc<Stranger>,
    service: Service,
) {
    let (read_half, write_half) = tokio::io::split(stream);
    let Service {
        queue_messages,
        access,
        events,
        clock,
    } = service;
    let (queue, queue_in) = mpsc::channel(queue_messages);
    let peer = Peer {
        queue,
        cut: Arc::default(),
    };
    let cut = peer.cut.clone();
    let pairing = Arc::new(OnceLock::new());
    let told = peer.clone();
    let mut reader = Reader {
        id,
        peer,
        events: events.clone(),
        clock,
        said_hello: false,
        access: access.clone(),
        pairing: pairing.clone(),
        stranger: stranger.clone(),
        place: None,
    };
    let writing = write_all(write_half, queue_in);
    tokio::pin!(writing);
    let reading_ended = tokio::select! {
        ended = reader.read_all(read_half) => Some(ended),
        written = &mut writing => { log_end(id, "writing", written); None }
        () = cut.notified() => {
            tracing::warn!("connection {} cut: the client does not read its messages", id.0);
            None
        }
        () = stranger.sent_away() => { log_sent_away(id); None }
        () = revoked(access.as_deref(), &pairing) => {
            told.send(&refusal(None, ErrorCode::Token, "the pairing was revoked at the projector"));
            Some(Ok(()))
        }
    };
    if let Some(ended) = reading_ended {
        log_end(id, "reading", ended);
        // The last words, for example why a hello was refused, still go out.
        reader.peer.close();
        if tokio::time::timeout(FAREWELL_TIMEOUT, writing)
            .await
            .is_err()
        {
            tracing::debug!("connection {}: the last messages were not taken", id.0);
        }
    }
    if events.send(Event::Gone(id)).await.is_err() {
        tracing::debug!("connection {} ended with the program", id.0);
    }
}

/// Waits until the pairing that a connection was let in by is taken back.
async fn revoked(access: Option<&Access>, pairing: &OnceLock<String>) {
    let Some(access) = access else {
        return std::future::pending().await;
    };
    loop {
        tokio::time::sleep(REVOCATION_CHECK).await;
        let Some(token_sha256) = pairing.get() else {
            continue;
        };
        match access.is_paired(token_sha256) {
            Ok(true) => {}
            Ok(false) => return,
            Err(error) => tracing::warn!("nobody knows who is paired: {error}"),
        }
    }
}

fn log_end(id: ConnectionId, what: &str, ended: io::Result<()>) {
    match ended {
        Ok(()) => tracing::debug!("connection {} ended", id.0),
        Err(error) => tracing::info!("connection {} ended while {what}: {error}", id.0),
    }
}

async fn write_all(
    mut stream: impl AsyncWrite + Unpin,
    mut queue: mpsc::Receiver<Outgoing>,
) -> io::Result<()> {
    while let Some(Outgoing::Line(line)) = queue.recv().await {
        stream.write_all(line.as_bytes()).await?;
        stream.flush().await?;
    }
    stream.shutdown().await
}

struct Reader {
    id: ConnectionId,
    peer: Peer,
    events: mpsc::Sender<Event>,
    clock: Clock,
    said_hello: bool,
    access: Option<Arc<Access>>,
    /// What the client was let in by.
    pairing: Arc<OnceLock<String>>,
    stranger: Arc<Stranger>,
    /// Held from the hello on.
    place: Option<Place>,
}

impl Reader {
    async fn read_all(&mut self, mut stream: impl AsyncRead + Unpin) -> io::Result<()> {
        let mut decoder = Decoder::<ClientMessage>::new();
        let mut buffer = [0; READ_BYTES];
        let hello_due = tokio::time::Instant::now() + HELLO_TIMEOUT;
        loop {
            let read = stream.read(&mut buffer);
            let count = if self.said_hello {
                read.await?
            } else {
                let Ok(count) = tokio::time::timeout_at(hello_due, read).await else {
                    self.refuse(None, ErrorCode::Hello, "no hello came in time");
                    return Ok(());
                };
                count?
            };
            if count == 0 {
                return Ok(());
            }
            decoder.push(&buffer[..count]);
            while let Some(message) = decoder.next_message() {
                if !self.take(message).await {
                    return Ok(());
                }
            }
        }
    }

    /// Takes one message; whether the connection goes on.
    async fn take(&mut self, message: Result<ClientMessage, DecodeError>) -> bool {
        match message {
            Err(error) => {
                tracing::debug!("connection {}: {error}", self.id.0);
                self.peer.send(&error.reply()) && self.said_hello
            }
            Ok(ClientMessage::Hello(_)) if self.said_hello => {
                self.refuse(None, ErrorCode::Hello, "hello was said already");
                true
            }
            Ok(ClientMessage::Hello(hello)) => {
                // before the token is looked at: a pairing code is not used up where there is no place
                self.place = self.stranger.let_in();
                if self.place.is_none() {
                    let why = format!(
                        "{} connections are open already, the most that is allowed: close one",
                        self.stranger.most()
                    );
                    self.refuse(None, ErrorCode::Full, &why);
                    return false;
                }
                if !self.admit(&hello) {
                    return false;
                }
                self.said_hello = true;
                self.tell(Event::Hello(self.id, hello, self.peer.clone()))
                    .await
            }
            Ok(ClientMessage::Request(Request {
                id,
                command: Command::Ping,
            })) if self.said_hello => self.peer.send(&ServerMessage::Pong {
                id,
                clock_ns: self.clock.now_ns(),
            }),
            Ok(ClientMessage::Request(request)) if self.said_hello => {
                self.tell(Event::Request(self.id, request)).await
            }
            Ok(ClientMessage::Request(request)) => {
                self.refuse(Some(request.id), ErrorCode::Hello, "say hello first");
                false
            }
        }
    }

    /// Whether the client may go on; one that has just been paired is given its token.
    fn admit(&self, hello: &Hello) -> bool {
        let Some(access) = &self.access else {
            return true;
        };
        match access.admit(hello.token.as_deref(), &hello.name) {
            Ok(admission) => {
                // set once: a connection says hello once
                self.pairing.get_or_init(|| admission.token_sha256);
                admission.new_token.is_none_or(|token| {
                    let token = token.to_string();
                    self.peer.send(&ServerMessage::Paired { token })
                })
            }
            Err(error) => {
                tracing::warn!("{:?} refused: {error}", hello.name);
                self.refuse(None, ErrorCode::Token, &error.to_string());
                false
            }
        }
    }

    async fn tell(&self, event: Event) -> bool {
        self.events.send(event).await.is_ok()
    }

    fn refuse(&self, id: Option<u64>, code: ErrorCode, why: &str) {
        self.peer.send(&refusal(id, code, why));
    }
}

fn refusal(id: Option<u64>, code: ErrorCode, why: &str) -> ServerMessage {
    ServerMessage::Error {
        id,
        code,
        message: why.to_owned(),
    }
}
