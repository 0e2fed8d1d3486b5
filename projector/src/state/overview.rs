//! What the operator's window is told: the state as clients see it, and what only the person at the projector sees.

use shared::protocol::{ProjectorState, Role};

/// A program that is connected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// The name it gave.
    pub name: String,
    /// What it is now; a controller whose role was taken over is a watcher.
    pub role: Role,
}

/// The state as the operator sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Overview {
    /// The state as clients see it.
    pub state: ProjectorState,
    /// Who is connected, in the order they came.
    pub members: Vec<Member>,
    /// The identify card is shown for some seconds.
    pub identifying: bool,
    /// Steps of the running sequence that are still to come.
    pub steps_left: usize,
    /// The picture asked for last is not on the screen yet.
    pub on_its_way: bool,
}
