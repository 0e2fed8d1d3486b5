//! What both programs agree on: sequences, patterns, protocol, geometry and the simulated room.
//!
//! This crate opens no socket, no window and no camera, and asks no clock. It writes no file but those that hold
//! secrets.

pub mod computer;
pub mod field;
pub mod geometry;
pub mod pattern;
pub mod private_file;
pub mod protocol;
pub mod sequence;
pub mod simulation;
pub mod stage;
