#![doc = include_str!("PROTOCOL.md")]
//!
//! # In Rust
//! [`Decoder`] turns received bytes into [`ClientMessage`]s or [`ServerMessage`]s and [`encode`] turns a
//! message into its line. Neither opens a socket or asks a clock.
//!
//! ```
//! use shared::protocol::{ClientMessage, Command, Decoder, Request, encode};
//!
//! let ping = ClientMessage::from(Request { id: 7, command: Command::Ping });
//! let line = encode(&ping);
//! assert_eq!(line, "{\"id\":7,\"type\":\"ping\"}\n");
//!
//! let mut decoder = Decoder::<ClientMessage>::new();
//! decoder.push(&line.as_bytes()[..10]);
//! assert!(decoder.next_message().is_none()); // not all bytes yet
//! decoder.push(&line.as_bytes()[10..]);
//! assert_eq!(decoder.next_message(), Some(Ok(ping)));
//! ```

mod codec;
mod message;
mod pairing;
mod state;

pub use codec::{DecodeError, Decoder, MAX_LINE_BYTES, Message, encode};
pub use message::{
    ClientMessage, Command, ControllerChange, ErrorCode, Hello, Request, Role, SequenceStep,
    ServerMessage, View,
};
pub use pairing::{Fingerprint, PairingCode, PairingError, Token};
pub use state::{
    ColourScore, MAX_CANDIDATES, MAX_TEXT_CHARS, ProjectorState, ScreenInfo, ScreenKind, Selection,
    Shown,
};

/// The version of the protocol written here. A peer of another version is refused.
pub const VERSION: u32 = 1;

/// Most steps of one sequence.
pub const MAX_STEPS: usize = 64;

/// Longest time of one step of a sequence, and until it begins, in milliseconds.
pub const MAX_HOLD_MS: f64 = 60_000.0;

/// The TCP port the projector listens on unless told otherwise.
pub const DEFAULT_PORT: u16 = 4460;

/// The kind of service that a projector on a network announces itself as, by multicast DNS (RFC 6762 and 6763).
pub const SERVICE: &str = "_colour-grid._tcp.local.";

#[cfg(test)]
mod tests;
