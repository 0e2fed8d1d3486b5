//! Starts the program `projector` and talks to it.

mod client;

mod program;

pub(crate) use client::Client;
pub(crate) use program::{Projector, run};
