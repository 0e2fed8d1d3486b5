//! What goes over the wire: requests of the clients, replies and notices of the projector.
//!
//! `PROTOCOL.md` is the reference; the names here are the names there.

use serde::{Deserialize, Serialize};

use super::{ProjectorState, Selection, Shown};
use crate::pattern::{Grid, Rgb};

/// Anything a client sends.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ClientMessage {
    /// The first message of a connection.
    Hello(Hello),
    /// Every later message.
    #[serde(untagged)]
    Request(Request),
}

impl From<Hello> for ClientMessage {
    fn from(hello: Hello) -> Self {
        Self::Hello(hello)
    }
}

impl From<Request> for ClientMessage {
    fn from(request: Request) -> Self {
        Self::Request(request)
    }
}

/// Who calls, and as what.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// Version of the protocol the client speaks: [`super::VERSION`].
    pub version: u32,
    /// What the client wants to be.
    pub role: Role,
    /// A name for people, for example `acquirer on bench-2`; at most [`super::MAX_TEXT_CHARS`] characters.
    pub name: String,
    /// Take the controller's role from whoever holds it.
    #[serde(default, skip_serializing_if = "is_false")]
    pub take_over: bool,
    /// What lets the client in, in hexadecimal digits; not asked for on the loopback address.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
}

fn is_false(flag: &bool) -> bool {
    !flag
}

/// What a client may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Decides what is shown. There is at most one.
    Controller,
    /// Sees every notice and may ask for the state and the clock.
    Watcher,
}

/// A command with the number its reply carries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Chosen by the client, 0 to 2^53 - 1; the reply carries it back.
    pub id: u64,
    /// What to do.
    #[serde(flatten)]
    pub command: Command,
}

/// What a client may ask for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Command {
    /// Shows a view and ends a blanking.
    Show {
        /// What to show.
        view: View,
    },
    /// Shows views one after the other, each for its time, without further requests. Any other request that
    /// changes the picture ends the sequence.
    ShowSequence {
        /// What to show for how long, 1 to [`super::MAX_STEPS`].
        steps: Vec<SequenceStep>,
        /// When the first step is sent to the screen, on the projector's clock, at most [`super::MAX_HOLD_MS`] from now;
        /// at once without it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begin_ns: Option<u64>,
    },
    /// Changes the colours of the coded grid and of its unary twin.
    SetColours {
        /// As many as the coded grid has: colour k draws symbol k.
        colours: Vec<Rgb>,
        /// Colour of the unary grid.
        unary: Rgb,
    },
    /// Changes the line widths of the coded and the unary grid.
    SetWidths {
        /// Width of the rows, in projector pixels.
        row_width_px: u32,
        /// Width of the columns, in projector pixels.
        column_width_px: u32,
    },
    /// Changes the number of lines of the coded and the unary grid.
    SetLines {
        /// 15, 31, 63, 127 or 255.
        rows: usize,
        /// 15, 31, 63, 127 or 255.
        columns: usize,
    },
    /// Shows the identify card for some seconds, then what was shown before.
    Identify {
        /// How long, in seconds, 1 to 60.
        #[serde(default = "default_identify_seconds")]
        seconds: u32,
    },
    /// Turns the picture black, or back to what was shown.
    Blank {
        /// Black (`true`) or back (`false`).
        on: bool,
    },
    /// Asks for the whole state.
    State,
    /// Hands over the colours that were selected for the scene, for everybody to see.
    ReportSelection {
        /// The outcome.
        selection: Selection,
    },
    /// Asks for the projector's clock; answered at once, for measuring the round trip.
    Ping,
}

fn default_identify_seconds() -> u32 {
    5
}

impl Command {
    /// The words that stand for commands in `type`.
    pub(super) const TYPES: [&str; 10] = [
        "show",
        "show_sequence",
        "set_colours",
        "set_widths",
        "set_lines",
        "identify",
        "blank",
        "state",
        "report_selection",
        "ping",
    ];

    /// Whether only the controller may send it.
    #[must_use]
    pub fn needs_control(&self) -> bool {
        !matches!(self, Self::State | Self::Ping)
    }
}

/// What a client wants to see, before the projector's settings turn it into a pattern.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum View {
    /// The coded grid of the settings.
    Coded,
    /// The unary twin of the coded grid.
    Unary,
    /// The same lines in the first two colours of the settings, coded by the two-colour sequence.
    TwoColour,
    /// Nothing projected.
    Black,
    /// Everything projected.
    White,
    /// One colour all over.
    Solid {
        /// The colour.
        colour: Rgb,
    },
    /// A grid of the client's own, whatever the settings are.
    Grid(Grid),
    /// Every byte value in every channel.
    Ramp,
    /// The card for focus and keystone.
    TestCard,
    /// The identify card, until something else is shown.
    Identify,
}

/// A view of a sequence and its time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SequenceStep {
    /// What to show.
    pub view: View,
    /// Time until the next step is sent to the screen, in milliseconds, 1 to [`super::MAX_HOLD_MS`]; the last
    /// view stays.
    pub hold_ms: f64,
}

/// Anything the projector sends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ServerMessage {
    /// Before `welcome`, to a client that said hello with the token of a pairing code: it is paired.
    Paired {
        /// What to say hello with from now on.
        token: String,
    },
    /// Reply to `hello`.
    Welcome {
        /// Version of the protocol the projector speaks.
        version: u32,
        /// What the client is from now on.
        role: Role,
        /// Everything there is to know.
        state: ProjectorState,
    },
    /// Reply to whatever changes the picture, sent once the picture is presented.
    Done {
        /// The request's.
        id: u64,
        /// What is shown now.
        #[serde(flatten)]
        shown: Shown,
    },
    /// Reply to `state`.
    State {
        /// The request's.
        id: u64,
        /// Everything there is to know.
        state: ProjectorState,
    },
    /// Reply to `report_selection` and `show_sequence`.
    Noted {
        /// The request's.
        id: u64,
    },
    /// Reply to `ping`.
    Pong {
        /// The request's.
        id: u64,
        /// The projector's monotonic clock, in nanoseconds since it started.
        clock_ns: u64,
    },
    /// Reply to what cannot be done; nothing has changed, except after [`ErrorCode::NotPresented`].
    Error {
        /// The request's, if it could be read.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        id: Option<u64>,
        /// Why, for programs.
        code: ErrorCode,
        /// Why and what to do, for people.
        message: String,
    },
    /// Notice: another picture is shown, whoever asked for it.
    Shown(Shown),
    /// Notice: anything else of the state has changed.
    StateChanged {
        /// The state after the change.
        state: ProjectorState,
    },
    /// Notice: the controller joined or left.
    Controller {
        /// What happened.
        change: ControllerChange,
        /// Who it is about.
        name: String,
    },
}

impl ServerMessage {
    /// The words that stand for messages in `type`.
    pub(super) const TYPES: [&str; 10] = [
        "paired",
        "welcome",
        "done",
        "state",
        "noted",
        "pong",
        "error",
        "shown",
        "state_changed",
        "controller",
    ];

    /// The number of the request this replies to, `None` for notices and `welcome`.
    #[must_use]
    pub fn reply_to(&self) -> Option<u64> {
        match self {
            Self::Done { id, .. }
            | Self::State { id, .. }
            | Self::Noted { id }
            | Self::Pong { id, .. } => Some(*id),
            Self::Error { id, .. } => *id,
            Self::Paired { .. }
            | Self::Welcome { .. }
            | Self::Shown(_)
            | Self::StateChanged { .. }
            | Self::Controller { .. } => None,
        }
    }
}

/// What happened to the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerChange {
    /// It holds the role from now on; whoever held it before is a watcher now.
    Joined,
    /// Its connection ended.
    Left,
}

/// Why a message was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorCode {
    /// The line is longer than [`super::MAX_LINE_BYTES`]; it was skipped.
    TooLong,
    /// The line is not a JSON object in UTF-8 with a `type`.
    Malformed,
    /// The `type` is not known.
    UnknownType,
    /// A value is missing, of another kind, or out of its range.
    Invalid,
    /// The projector speaks another version; the connection ends.
    Version,
    /// The first message was not `hello`, or a second `hello` came.
    Hello,
    /// Another client is the controller; the connection ends.
    ControllerTaken,
    /// A watcher may not do this.
    NotController,
    /// There are as many connections as the projector allows; the connection ends.
    Full,
    /// The picture was not presented in time, for example because the window is covered; a notice comes when
    /// it is after all.
    NotPresented,
    /// The client is not paired, or its pairing was revoked; the connection ends.
    Token,
    /// A reason this version does not know.
    #[serde(other)]
    Other,
}
