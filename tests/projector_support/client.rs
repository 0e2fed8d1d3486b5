//! A client that waits for what it asks for.

use std::{
    io::{Read, Write},
    net::{SocketAddr, TcpStream},
    time::Duration,
};

use shared::protocol::{
    ClientMessage, Command, Decoder, Hello, ProjectorState, Request, Role, ServerMessage, Shown,
    VERSION, View, encode,
};

/// Far longer than anything takes; a test that waits this long has failed.
const TIMEOUT: Duration = Duration::from_secs(60);

/// One connection to the projector.
pub(crate) struct Client {
    stream: TcpStream,
    decoder: Decoder<ServerMessage>,
    last_id: u64,
    /// Notices that came while a reply was waited for, oldest first.
    pub(crate) notices: Vec<ServerMessage>,
}

impl Client {
    /// A connection on which nothing was said.
    pub(crate) fn connect(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).expect("the projector listens");
        stream
            .set_read_timeout(Some(TIMEOUT))
            .expect("a timeout can be set");
        Self {
            stream,
            decoder: Decoder::new(),
            last_id: 0,
            notices: Vec::new(),
        }
    }

    /// A client that was welcomed.
    pub(crate) fn join(address: SocketAddr, role: Role, name: &str) -> Self {
        let mut client = Self::connect(address);
        let welcome = client.hello(role, name, false);
        assert!(
            matches!(welcome, Some(ServerMessage::Welcome { .. })),
            "{welcome:?}"
        );
        client
    }

    /// Says hello and gives the answer.
    pub(crate) fn hello(
        &mut self,
        role: Role,
        name: &str,
        take_over: bool,
    ) -> Option<ServerMessage> {
        let hello = Hello {
            version: VERSION,
            role,
            name: name.to_owned(),
            take_over,
            token: None,
        };
        self.send_bytes(encode(&ClientMessage::from(hello)).as_bytes());
        self.next()
    }

    pub(crate) fn send_bytes(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("the projector reads");
    }

    /// Sends a request and does not wait for its reply; gives its number.
    pub(crate) fn send(&mut self, command: Command) -> u64 {
        self.last_id += 1;
        let request = Request {
            id: self.last_id,
            command,
        };
        self.send_bytes(encode(&ClientMessage::from(request)).as_bytes());
        self.last_id
    }

    /// The next message; `None` when the connection has ended.
    pub(crate) fn next(&mut self) -> Option<ServerMessage> {
        let mut buffer = [0; 4096];
        loop {
            if let Some(message) = self.decoder.next_message() {
                return Some(message.expect("the projector sends valid messages"));
            }
            match self.stream.read(&mut buffer) {
                Ok(0) => return None,
                Ok(count) => self.decoder.push(&buffer[..count]),
                Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => return None,
                Err(error) => panic!("no message came: {error}"),
            }
        }
    }

    /// Sends a request and waits for its reply.
    pub(crate) fn ask(&mut self, command: Command) -> ServerMessage {
        let id = self.send(command);
        loop {
            let message = self.next().expect("the connection stays");
            if message.reply_to() == Some(id) {
                return message;
            }
            self.notices.push(message);
        }
    }

    /// Asks for another picture and waits until it is shown.
    pub(crate) fn change(&mut self, command: Command) -> Shown {
        match self.ask(command) {
            ServerMessage::Done { shown, .. } => shown,
            other => panic!("{other:?}"),
        }
    }

    pub(crate) fn show(&mut self, view: View) -> Shown {
        self.change(Command::Show { view })
    }

    pub(crate) fn state(&mut self) -> ProjectorState {
        match self.ask(Command::State) {
            ServerMessage::State { state, .. } => state,
            other => panic!("{other:?}"),
        }
    }

    pub(crate) fn clock_ns(&mut self) -> u64 {
        match self.ask(Command::Ping) {
            ServerMessage::Pong { clock_ns, .. } => clock_ns,
            other => panic!("{other:?}"),
        }
    }
}
