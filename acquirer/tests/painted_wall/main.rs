//! Choosing colours and the thesis's method, tested on painted walls and in a simulated room.

#![allow(
    clippy::unwrap_used,
    reason = "a step that fails in a helper fails its test"
)]

mod wall;

mod colour_choice;

mod thesis_method;

mod simulated_rooms;
