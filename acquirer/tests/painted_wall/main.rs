//! Choosing colours and the thesis's method, tested on painted walls.

#![allow(
    clippy::unwrap_used,
    reason = "a step that fails in a helper fails its test"
)]

mod wall;

mod colour_choice;

mod thesis_method;
