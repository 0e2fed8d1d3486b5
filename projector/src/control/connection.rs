//! One client's connection: bytes to events for the hub, messages to bytes.
//!
//! Reading waits for the hub, so a client that sends faster than pictures can be shown is slowed down.
//! Writing never makes the hub wait: messages go into a bounded queue, and when that is full the connection
//! is cut. `ping` is answered here, so that a picture in progress does not lengthen the round trip.

use std::{io, sync::Arc, time::Duration};

use shared::protocol::{
    ClientMessage, Command, DecodeError, Decoder, ErrorCode, Hello, Request, ServerMessage, encode,
};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{
        TcpStream,
        tcp::{OwnedReadHalf, OwnedWriteHalf},
    },
    sync::{Notify, mpsc},
};

use crate::{clock::Clock, state::ConnectionId};

/// Longest time a client may take to say hello.
const HELLO_TIMEOUT: Duration = Duration::from_secs(10);
/// Longest time a farewell may take to be sent.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(1);
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

/// Serves one connection until it ends.
pub(super) async fn run(
    id: ConnectionId,
    stream: TcpStream,
    queue_messages: usize,
    events: mpsc::Sender<Event>,
    clock: Clock,
) {
    let (read_half, write_half) = stream.into_split();
    let (queue, queue_in) = mpsc::channel(queue_messages);
    let peer = Peer {
        queue,
        cut: Arc::default(),
    };
    let cut = peer.cut.clone();
    let mut reader = Reader {
        id,
        peer,
        events: events.clone(),
        clock,
        said_hello: false,
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

fn log_end(id: ConnectionId, what: &str, ended: io::Result<()>) {
    match ended {
        Ok(()) => tracing::debug!("connection {} ended", id.0),
        Err(error) => tracing::info!("connection {} ended while {what}: {error}", id.0),
    }
}

async fn write_all(
    mut stream: OwnedWriteHalf,
    mut queue: mpsc::Receiver<Outgoing>,
) -> io::Result<()> {
    while let Some(Outgoing::Line(line)) = queue.recv().await {
        stream.write_all(line.as_bytes()).await?;
    }
    stream.shutdown().await
}

struct Reader {
    id: ConnectionId,
    peer: Peer,
    events: mpsc::Sender<Event>,
    clock: Clock,
    said_hello: bool,
}

impl Reader {
    async fn read_all(&mut self, mut stream: OwnedReadHalf) -> io::Result<()> {
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

    async fn tell(&self, event: Event) -> bool {
        self.events.send(event).await.is_ok()
    }

    fn refuse(&self, id: Option<u64>, code: ErrorCode, why: &str) {
        self.peer.send(&ServerMessage::Error {
            id,
            code,
            message: why.to_owned(),
        });
    }
}
