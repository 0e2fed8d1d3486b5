//! The acquirer's end of the wire to the projector.
//!
//! Takes an address and gives a [`ProjectorLink`]: calls that block until the projector has
//! answered, and a queue of what it tells unasked. One thread reads; replies find their caller by
//! the request's number. The protocol itself is `shared::protocol`; what a picture on the wall
//! means is the session's business.
//!
//! A projector whose network cable is pulled shows only by a call that times out: TCP itself
//! notices minutes later.

mod clock_offset;
mod connection;
mod discovery;
mod error;
mod notices;
mod pairing;
mod wire;

pub use clock_offset::{ClockOffset, Ping};
pub use discovery::{AUTO, FindError, Found, find, resolve};
pub use error::LinkError;
pub use notices::Notice;
pub use pairing::{PairError, pair};

use std::time::{Duration, Instant};

use shared::pattern::Rgb;
use shared::protocol::{
    Command, ProjectorState, Role, Selection, SequenceStep, ServerMessage, Shown, View,
};

use connection::Connection;

/// Pause between two tries to reach a projector that may still be starting.
const RETRY: Duration = Duration::from_millis(100);

/// How to reach a projector, and as what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkSettings {
    /// `HOST:PORT`, or `HOST` for the default port.
    pub address: String,
    /// A name for the people at the projector.
    pub name: String,
    /// Whether to decide what is shown, or only to watch.
    pub role: Role,
    /// Take the controller's role from whoever holds it.
    pub take_over: bool,
    /// Longest wait for the connection and the first words.
    pub connect_timeout: Duration,
    /// Longest wait for a reply; a picture may take some refreshes.
    pub reply_timeout: Duration,
}

impl LinkSettings {
    /// The usual limits for a projector at an address: 3 s to connect, 5 s to reply.
    #[must_use]
    pub fn new(address: &str, name: &str, role: Role) -> Self {
        Self {
            address: address.to_owned(),
            name: name.to_owned(),
            role,
            take_over: false,
            connect_timeout: Duration::from_secs(3),
            reply_timeout: Duration::from_secs(5),
        }
    }
}

/// A picture that is on the wall because of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presented {
    /// The picture, its number and the projector's own time of it.
    pub shown: Shown,
    /// When the request was sent, on [`crate::clock::monotonic_now`]'s scale.
    pub requested_at: Duration,
    /// When the reply came, on the same scale: from here on the picture is certainly shown, the
    /// projector's own lag aside.
    pub replied_at: Duration,
}

impl Presented {
    /// From the request to the reply.
    #[must_use]
    pub fn round_trip(&self) -> Duration {
        self.replied_at.saturating_sub(self.requested_at)
    }
}

/// A connection to a projector. Calls may come from several threads at a time.
#[derive(Debug)]
pub struct ProjectorLink {
    settings: LinkSettings,
    connection: Connection,
}

impl ProjectorLink {
    /// Connects and says hello.
    ///
    /// # Errors
    /// When nobody answers, the peer is no projector of this version, or somebody else is the
    /// controller.
    pub fn connect(settings: &LinkSettings) -> Result<Self, LinkError> {
        let connection = Connection::to(settings)?;
        Ok(Self {
            settings: settings.clone(),
            connection,
        })
    }

    /// As [`ProjectorLink::connect`], trying again for `patience` while nobody listens there yet.
    ///
    /// # Errors
    /// As [`ProjectorLink::connect`], the last one met.
    pub fn connect_within(settings: &LinkSettings, patience: Duration) -> Result<Self, LinkError> {
        let deadline = Instant::now() + patience;
        loop {
            match Self::connect(settings) {
                Err(LinkError::Refused { .. }) if Instant::now() < deadline => {
                    std::thread::sleep(RETRY);
                }
                outcome => return outcome,
            }
        }
    }

    /// Connects anew in the same way; the old connection is closed first and its notices are lost.
    ///
    /// # Errors
    /// As [`ProjectorLink::connect`]; the link stays closed then, and this may be called again.
    pub fn reconnect(&mut self) -> Result<(), LinkError> {
        self.connection.close();
        self.connection = Connection::to(&self.settings)?;
        Ok(())
    }

    /// The settings it was opened with.
    #[must_use]
    pub fn settings(&self) -> &LinkSettings {
        &self.settings
    }

    /// What the projector said of itself when the connection was made.
    #[must_use]
    pub fn first_state(&self) -> &ProjectorState {
        self.connection.first_state()
    }

    /// Shows a view; returns when it is certainly on the screen.
    ///
    /// # Errors
    /// As every call here: the projector refuses, does not answer in time, or has gone.
    pub fn show(&self, view: View) -> Result<Presented, LinkError> {
        self.present(Command::Show { view })
    }

    /// Has views shown one after the other, each for its time, the first one when the projector's clock shows `begin_ns`
    /// or at once; returns as soon as the projector has taken the order. The next [`Notice::Shown`]s are those of the
    /// steps, in their order.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn show_sequence(
        &self,
        steps: Vec<SequenceStep>,
        begin_ns: Option<u64>,
    ) -> Result<(), LinkError> {
        self.note(Command::ShowSequence { steps, begin_ns })
    }

    /// Changes the colours of the coded grid and the unary colour.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn set_colours(&self, colours: &[Rgb], unary: Rgb) -> Result<Presented, LinkError> {
        self.present(Command::SetColours {
            colours: colours.to_vec(),
            unary,
        })
    }

    /// Changes the widths of the lines, in projector pixels.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn set_widths(
        &self,
        row_width_px: u32,
        column_width_px: u32,
    ) -> Result<Presented, LinkError> {
        self.present(Command::SetWidths {
            row_width_px,
            column_width_px,
        })
    }

    /// Changes the numbers of lines.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn set_lines(&self, rows: usize, columns: usize) -> Result<Presented, LinkError> {
        self.present(Command::SetLines { rows, columns })
    }

    /// Shows the identify card for 1 to 60 seconds.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn identify(&self, seconds: u32) -> Result<Presented, LinkError> {
        self.present(Command::Identify { seconds })
    }

    /// Turns the picture black, or back.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn blank(&self, on: bool) -> Result<Presented, LinkError> {
        self.present(Command::Blank { on })
    }

    /// Everything there is to know about the projector now.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn state(&self) -> Result<ProjectorState, LinkError> {
        match self.connection.request(Command::State)?.message {
            ServerMessage::State { state, .. } => Ok(state),
            other => Err(LinkError::unexpected(&other)),
        }
    }

    /// Tells everybody which colours were chosen for the scene; the projector's settings stay.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn report_selection(&self, selection: Selection) -> Result<(), LinkError> {
        self.note(Command::ReportSelection { selection })
    }

    /// Measures one round trip and relates the projector's clock to ours.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn ping(&self) -> Result<Ping, LinkError> {
        let reply = self.connection.request(Command::Ping)?;
        match reply.message {
            ServerMessage::Pong { clock_ns, .. } => {
                Ok(Ping::new(reply.sent_at, reply.received_at, clock_ns))
            }
            other => Err(LinkError::unexpected(&other)),
        }
    }

    /// The clock offset from the quickest of some round trips, which bounds its error best.
    ///
    /// # Errors
    /// As [`ProjectorLink::show`].
    pub fn clock_offset(&self, pings: u32) -> Result<ClockOffset, LinkError> {
        let mut best = self.ping()?;
        for _ in 1..pings {
            let ping = self.ping()?;
            if ping.round_trip < best.round_trip {
                best = ping;
            }
        }
        Ok(best.offset)
    }

    /// The oldest notice not taken yet; waits for one up to `timeout`, and gives nothing when none
    /// came.
    ///
    /// # Errors
    /// [`LinkError::Lost`] when the connection has ended and every notice was taken.
    pub fn next_notice(&self, timeout: Duration) -> Result<Option<Notice>, LinkError> {
        self.connection.next_notice(timeout)
    }

    /// Notices that were thrown away because nobody took them in time.
    #[must_use]
    pub fn notices_dropped(&self) -> u64 {
        self.connection.notices_dropped()
    }

    fn note(&self, command: Command) -> Result<(), LinkError> {
        match self.connection.request(command)?.message {
            ServerMessage::Noted { .. } => Ok(()),
            other => Err(LinkError::unexpected(&other)),
        }
    }

    fn present(&self, command: Command) -> Result<Presented, LinkError> {
        let reply = self.connection.request(command)?;
        match reply.message {
            ServerMessage::Done { shown, .. } => Ok(Presented {
                shown,
                requested_at: reply.sent_at,
                replied_at: reply.received_at,
            }),
            other => Err(LinkError::unexpected(&other)),
        }
    }
}

#[cfg(test)]
mod tests;
