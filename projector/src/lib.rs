//! The projector: shows the colour-coded grid full-screen and takes commands over TCP.
//!
//! ```text
//! client --TCP--> control --change--> state --picture--> screen --light-->
//!        <-------         <-effects--       <-presented-
//! ```
//!
//! [`access`] knows who may command over a network, [`announcement`] tells where the projector is, [`control`] speaks the protocol of [`shared::protocol`], [`state`]
//! knows what is shown and who decides it, [`screen`] draws, [`operator`] is the window for the person at the projector.
//! Only `state` decides, only `screen` touches the window system, and only `control`
//! and `announcement` touch the network. [`config`] and [`cli`] bring the settings together.

pub mod cli;

pub mod config;

pub mod access;

pub mod announcement;

pub mod control;

pub mod state;

pub mod screen;

pub mod operator;

pub mod clock;
