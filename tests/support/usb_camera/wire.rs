//! USB/IP as it travels: what the guest's kernel asks of the device, and the answers.
//!
//! All numbers are big-endian. Each message has a head of 48 bytes; behind a write's head comes its data, behind the
//! answer to a read what was read.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::Mutex;

use anyhow::{Context, bail};

use super::lock;

const HEAD: usize = 48;
const SUBMIT: u32 = 1;
const UNLINK: u32 = 2;
const SUBMIT_ANSWER: u32 = 3;
const UNLINK_ANSWER: u32 = 4;
/// The device does not take a request: EPIPE.
const STALLED: i32 = -32;
/// A request was taken back before it was answered: ECONNRESET.
const TAKEN_BACK: i32 = -104;
/// More data than the driver would ever send in one request.
const MOST_DATA: u32 = 1 << 20;

/// Which way a request's data goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// From the computer to the device.
    Out,
    /// From the device to the computer.
    In,
}

/// A request to an endpoint.
#[derive(Debug)]
pub(super) struct Submit {
    pub(super) number: u32,
    pub(super) direction: Direction,
    pub(super) endpoint: u32,
    /// Bytes that may be read at most.
    pub(super) length: usize,
    /// The head of a control request.
    pub(super) setup: [u8; 8],
    /// What is written.
    pub(super) data: Vec<u8>,
}

/// A message from the guest's kernel.
#[derive(Debug)]
pub(super) enum Message {
    Submit(Submit),
    /// Takes an earlier request back.
    Unlink {
        number: u32,
        unlinks: u32,
    },
}

/// The guest's messages.
pub(super) struct Requests {
    connection: TcpStream,
}

impl Requests {
    /// Those of a connection whose reads time out.
    pub(super) fn from(connection: TcpStream) -> Self {
        Self { connection }
    }

    /// The next message; nothing when the guest has gone or the device ends.
    pub(super) fn next(&mut self, ended: &impl Fn() -> bool) -> anyhow::Result<Option<Message>> {
        let mut head = [0; HEAD];
        if !self.fill(&mut head, ended)? {
            return Ok(None);
        }
        let word = |k: usize| u32::from_be_bytes(std::array::from_fn(|byte| head[4 * k + byte]));
        let number = word(1);
        match word(0) {
            SUBMIT => {
                let direction = match word(3) {
                    0 => Direction::Out,
                    _ => Direction::In,
                };
                let length = word(6);
                if length > MOST_DATA {
                    bail!("a request of {length} bytes");
                }
                let mut data = match direction {
                    Direction::Out => vec![0; length as usize],
                    Direction::In => Vec::new(),
                };
                if !self.fill(&mut data, ended)? {
                    return Ok(None);
                }
                Ok(Some(Message::Submit(Submit {
                    number,
                    direction,
                    endpoint: word(4),
                    length: length as usize,
                    setup: std::array::from_fn(|k| head[40 + k]),
                    data,
                })))
            }
            UNLINK => Ok(Some(Message::Unlink {
                number,
                unlinks: word(5),
            })),
            other => bail!("unknown message {other:#x}"),
        }
    }

    /// Fills a buffer; false when the guest has gone or the device ends.
    fn fill(&mut self, buffer: &mut [u8], ended: &impl Fn() -> bool) -> anyhow::Result<bool> {
        let mut filled = 0;
        while filled < buffer.len() {
            match self.connection.read(&mut buffer[filled..]) {
                Ok(0) => return Ok(false),
                Ok(count) => filled += count,
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut if !ended() => {}
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::ConnectionReset => {
                        return Ok(false);
                    }
                    ErrorKind::Interrupted => {}
                    _ => return Err(error).context("reading from the guest"),
                },
            }
        }
        Ok(true)
    }
}

/// The device's answers, from any thread.
pub(super) struct Replies {
    connection: Mutex<TcpStream>,
}

impl Replies {
    pub(super) fn to(connection: TcpStream) -> Self {
        Self {
            connection: Mutex::new(connection),
        }
    }

    /// Gives what a request wanted to read, cut to what it takes.
    pub(super) fn data(&self, submit: &Submit, data: &[u8]) -> std::io::Result<()> {
        let data = &data[..data.len().min(submit.length)];
        self.answer(SUBMIT_ANSWER, submit.number, [0, data.len() as i32], data)
    }

    /// Has taken all that a request wrote.
    pub(super) fn taken(&self, submit: &Submit) -> std::io::Result<()> {
        let length = submit.data.len() as i32;
        self.answer(SUBMIT_ANSWER, submit.number, [0, length], &[])
    }

    /// Does not know such a request, or refuses it.
    pub(super) fn stall(&self, submit: &Submit) -> std::io::Result<()> {
        self.answer(SUBMIT_ANSWER, submit.number, [STALLED, 0], &[])
    }

    /// Tells whether a request that was taken back was still waiting.
    pub(super) fn unlinked(&self, number: u32, waited: bool) -> std::io::Result<()> {
        let status = if waited { TAKEN_BACK } else { 0 };
        self.answer(UNLINK_ANSWER, number, [status, 0], &[])
    }

    fn answer(
        &self,
        command: u32,
        number: u32,
        [status, length]: [i32; 2],
        data: &[u8],
    ) -> std::io::Result<()> {
        let mut message = vec![0; HEAD];
        message[..4].copy_from_slice(&command.to_be_bytes());
        message[4..8].copy_from_slice(&number.to_be_bytes());
        message[20..24].copy_from_slice(&status.to_be_bytes());
        message[24..28].copy_from_slice(&length.to_be_bytes());
        message.extend_from_slice(data);
        lock(&self.connection).write_all(&message)
    }
}
