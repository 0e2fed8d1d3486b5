//! The keys of both windows, for pointing and focusing without a second computer.

use shared::protocol::{Command, View};
use winit::keyboard::Key;

/// How long the I key shows the identify card, in seconds.
const IDENTIFY_S: u32 = 5;

/// What a key asks for.
pub(super) fn command_of(key: &Key) -> Option<Command> {
    let Key::Character(text) = key else {
        return None;
    };
    let view = match text.to_lowercase().as_str() {
        "c" => View::Coded,
        "2" => View::TwoColour,
        "u" => View::Unary,
        "k" => View::Black,
        "w" => View::White,
        "t" => View::TestCard,
        "r" => View::Ramp,
        "i" => {
            return Some(Command::Identify {
                seconds: IDENTIFY_S,
            });
        }
        _ => return None,
    };
    Some(Command::Show { view })
}
