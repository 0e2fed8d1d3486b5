//! What can go wrong between the two programs, each with what to do about it.

use std::time::Duration;

use shared::protocol::{ErrorCode, ServerMessage};
use thiserror::Error;

/// Why there is no connection, or no answer.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinkError {
    /// The address cannot be understood or found.
    #[error(
        "projector address '{address}': {reason}; give HOST:PORT, for example 192.168.1.20:4460"
    )]
    Address {
        /// The address as given.
        address: String,
        /// Why.
        reason: String,
    },
    /// The machine is there and nobody listens.
    #[error(
        "no projector program listens at {address}: start `projector` there, or check the port"
    )]
    Refused {
        /// The address.
        address: String,
    },
    /// The machine cannot be reached.
    #[error(
        "cannot reach {address}: {reason}; check the network cable, the address and the firewall"
    )]
    Unreachable {
        /// The address.
        address: String,
        /// What the system says.
        reason: String,
    },
    /// Whoever listens there is no projector.
    #[error("{address} does not answer like a projector: {reason}")]
    NotAProjector {
        /// The address.
        address: String,
        /// What came instead.
        reason: String,
    },
    /// The two programs are of different releases.
    #[error("version mismatch: {0}")]
    Version(String),
    /// The projector lets in who is paired.
    #[error(
        "not paired with the projector at {address}: type `acquirer pair CODE` with the code that `projector pair` \
         makes there ({reason})"
    )]
    NotPaired {
        /// The address.
        address: String,
        /// What it says.
        reason: String,
    },
    /// Another certificate than the paired one.
    #[error(
        "{address} is not the projector that was paired: its certificate is another one; if it was set up anew, pair \
         again, else somebody stands between"
    )]
    OtherProjector {
        /// The address.
        address: String,
    },
    /// What is remembered of paired projectors can't be read.
    #[error("paired projectors: {0}")]
    Remembered(String),
    /// Somebody else is the controller, or there are too many connections.
    #[error("the projector is taken: {0}")]
    Taken(String),
    /// The projector refuses a request; nothing has changed there.
    #[error("the projector refuses: {message}")]
    Denied {
        /// The reason for programs.
        code: ErrorCode,
        /// The reason for people.
        message: String,
    },
    /// No reply in time.
    #[error("the projector did not answer within {} ms; is its window frozen or its network cable out?", waited.as_millis())]
    NoReply {
        /// How long was waited.
        waited: Duration,
    },
    /// The connection has ended.
    #[error("the connection to the projector was lost: {0}")]
    Lost(String),
    /// A reply of another kind than the request asks for.
    #[error("the projector answered with something else: {0}")]
    Unexpected(String),
}

impl LinkError {
    /// A reply that does not fit its request; an error message is the projector's refusal.
    pub(super) fn unexpected(message: &ServerMessage) -> Self {
        match message {
            ServerMessage::Error { code, message, .. } => Self::Denied {
                code: *code,
                message: message.clone(),
            },
            other => Self::Unexpected(clip(&format!("{other:?}"))),
        }
    }

    /// The projector's answer to `hello`, when it is not `welcome`.
    pub(super) fn refusal(address: &str, message: &ServerMessage) -> Self {
        match message {
            ServerMessage::Error {
                code: ErrorCode::Version,
                message,
                ..
            } => Self::Version(message.clone()),
            ServerMessage::Error {
                code: ErrorCode::Token,
                message,
                ..
            } => Self::NotPaired {
                address: address.to_owned(),
                reason: message.clone(),
            },
            ServerMessage::Error {
                code: ErrorCode::ControllerTaken | ErrorCode::Full,
                message,
                ..
            } => Self::Taken(message.clone()),
            ServerMessage::Error { code, message, .. } => Self::Denied {
                code: *code,
                message: message.clone(),
            },
            other => {
                let reason = format!("its first words are {}", clip(&format!("{other:?}")));
                Self::NotAProjector {
                    address: address.to_owned(),
                    reason,
                }
            }
        }
    }
}

/// A stranger's words, shortened.
fn clip(text: &str) -> String {
    text.chars().take(200).collect()
}
