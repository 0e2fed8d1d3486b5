//! Bytes to messages and back, without a socket.
//!
//! Takes bytes in pieces of any size and gives one message per line. Memory is bounded by
//! [`MAX_LINE_BYTES`] plus the largest piece pushed: a longer line is reported once and skipped up to its
//! end, so that the next line is read again.

use std::marker::PhantomData;

use serde::Serialize;
use serde_json::Value;
use thiserror::Error;

use super::{ClientMessage, Command, ErrorCode, Hello, Request, ServerMessage};

/// Longest line, the line feed not counted.
pub const MAX_LINE_BYTES: usize = 65_536;

/// Why a line is not a message.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum DecodeError {
    /// The line has more than [`MAX_LINE_BYTES`] bytes.
    #[error("line longer than {MAX_LINE_BYTES} bytes: it was skipped")]
    TooLong,
    /// The bytes are not text.
    #[error("line is not UTF-8")]
    NotUtf8,
    /// The text is not JSON.
    #[error("line is not JSON: {0}")]
    NotJson(String),
    /// The JSON is not an object with a text as `type`.
    #[error(
        "message has no \"type\": send one JSON object per line, for example {{\"id\":1,\"type\":\"ping\"}}"
    )]
    NoType,
    /// No message has this type.
    #[error("unknown type {kind:?}: known are {known}")]
    UnknownType {
        /// The request's number, if there is one.
        id: Option<u64>,
        /// The type that came.
        kind: String,
        /// The types there are.
        known: String,
    },
    /// The message is of a known type but its content is wrong.
    #[error("{kind}: {reason}")]
    Invalid {
        /// The request's number, if there is one.
        id: Option<u64>,
        /// The message's type.
        kind: String,
        /// What is wrong.
        reason: String,
    },
}

impl DecodeError {
    /// The number of the request that could not be read, as far as that could be read.
    #[must_use]
    pub fn id(&self) -> Option<u64> {
        match self {
            Self::UnknownType { id, .. } | Self::Invalid { id, .. } => *id,
            Self::TooLong | Self::NotUtf8 | Self::NotJson(_) | Self::NoType => None,
        }
    }

    /// The code that goes back to the sender.
    #[must_use]
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::TooLong => ErrorCode::TooLong,
            Self::NotUtf8 | Self::NotJson(_) | Self::NoType => ErrorCode::Malformed,
            Self::UnknownType { .. } => ErrorCode::UnknownType,
            Self::Invalid { .. } => ErrorCode::Invalid,
        }
    }

    /// The reply that tells the sender.
    #[must_use]
    pub fn reply(&self) -> ServerMessage {
        ServerMessage::Error {
            id: self.id(),
            code: self.code(),
            message: self.to_string(),
        }
    }
}

/// A message of one direction.
pub trait Message: Serialize + Sized {
    /// Reads a message from one line without its line feed. Unknown fields are ignored.
    ///
    /// # Errors
    /// See [`DecodeError`].
    fn from_line(line: &str) -> Result<Self, DecodeError>;
}

impl Message for ClientMessage {
    fn from_line(line: &str) -> Result<Self, DecodeError> {
        let (kind, value) = object(line)?;
        if kind == "hello" {
            return content::<Hello>(&kind, value).map(Self::Hello);
        }
        if !Command::TYPES.contains(&kind.as_str()) {
            let known = format!("hello, {}", Command::TYPES.join(", "));
            return Err(DecodeError::UnknownType {
                id: id_of(&value),
                kind: clip(&kind),
                known,
            });
        }
        content::<Request>(&kind, value).map(Self::Request)
    }
}

impl Message for ServerMessage {
    fn from_line(line: &str) -> Result<Self, DecodeError> {
        let (kind, value) = object(line)?;
        if !Self::TYPES.contains(&kind.as_str()) {
            let known = Self::TYPES.join(", ");
            return Err(DecodeError::UnknownType {
                id: id_of(&value),
                kind: clip(&kind),
                known,
            });
        }
        content(&kind, value)
    }
}

fn object(line: &str) -> Result<(String, Value), DecodeError> {
    let value: Value =
        serde_json::from_str(line).map_err(|error| DecodeError::NotJson(error.to_string()))?;
    let kind = value
        .get("type")
        .and_then(Value::as_str)
        .ok_or(DecodeError::NoType)?;
    Ok((kind.to_owned(), value))
}

fn content<T: serde::de::DeserializeOwned>(kind: &str, value: Value) -> Result<T, DecodeError> {
    let id = id_of(&value);
    serde_json::from_value(value).map_err(|error| DecodeError::Invalid {
        id,
        kind: kind.to_owned(),
        reason: clip(&error.to_string()),
    })
}

fn id_of(value: &Value) -> Option<u64> {
    value.get("id").and_then(Value::as_u64)
}

/// What a stranger sent goes back to him shortened.
fn clip(text: &str) -> String {
    text.chars().take(200).collect()
}

/// A message as its line, line feed included.
#[must_use]
pub fn encode<M: Message>(message: &M) -> String {
    match serde_json::to_string(message) {
        Ok(line) => line + "\n",
        // Messages hold only texts, numbers and lists, for which JSON always has a form.
        Err(error) => unreachable!("a message can always be written: {error}"),
    }
}

/// Turns received bytes into messages.
#[derive(Debug)]
pub struct Decoder<M> {
    pending: Vec<u8>,
    /// Bytes at the start of `pending` that are known to hold no line feed.
    searched: usize,
    /// The end of an over-long line has not come yet.
    skipping: bool,
    messages: PhantomData<fn() -> M>,
}

impl<M> Default for Decoder<M> {
    fn default() -> Self {
        Self {
            pending: Vec::new(),
            searched: 0,
            skipping: false,
            messages: PhantomData,
        }
    }
}

impl<M: Message> Decoder<M> {
    /// A decoder that has seen nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes received bytes. Call [`Self::next_message`] until it gives `None` before pushing more.
    pub fn push(&mut self, bytes: &[u8]) {
        self.pending.extend_from_slice(bytes);
    }

    /// The next message, or why a line is none; `None` when no whole line is there yet.
    pub fn next_message(&mut self) -> Option<Result<M, DecodeError>> {
        loop {
            let line = match self.next_line()? {
                Ok(line) => line,
                Err(error) => return Some(Err(error)),
            };
            if line.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            let text = std::str::from_utf8(&line).map_err(|_| DecodeError::NotUtf8);
            return Some(text.and_then(M::from_line));
        }
    }

    /// Bytes held back for a line whose end has not come yet.
    #[must_use]
    pub fn pending_bytes(&self) -> usize {
        self.pending.len()
    }

    fn next_line(&mut self) -> Option<Result<Vec<u8>, DecodeError>> {
        loop {
            let found = self.pending[self.searched..]
                .iter()
                .position(|&byte| byte == b'\n');
            let Some(offset) = found else {
                self.searched = self.pending.len();
                if self.searched <= MAX_LINE_BYTES && !self.skipping {
                    return None;
                }
                self.pending.clear();
                self.searched = 0;
                let first_time = !std::mem::replace(&mut self.skipping, true);
                return first_time.then_some(Err(DecodeError::TooLong));
            };
            let mut line: Vec<u8> = self.pending.drain(..=self.searched + offset).collect();
            line.pop();
            self.searched = 0;
            if std::mem::take(&mut self.skipping) {
                continue;
            }
            if line.len() > MAX_LINE_BYTES {
                return Some(Err(DecodeError::TooLong));
            }
            return Some(Ok(line));
        }
    }
}
