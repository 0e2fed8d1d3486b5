//! How the windows of both programs look, and how scripts find their way in them.
//!
//! It opens no window: it takes egui contexts and gives them a style ([`style`]) or watches what is drawn
//! ([`widget_list`]).

pub mod style;
pub mod widget_list;
