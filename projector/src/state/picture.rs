//! From a view, which refers to the settings, to a pattern, which stands by itself.

use shared::{
    pattern::{GridSettings, Pattern},
    protocol::View,
};

/// A pattern to be presented, with its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// 1 for the first picture, one more for each other one.
    pub serial: u64,
    /// What to draw.
    pub pattern: Pattern,
}

/// The pattern that a view means with these settings on a screen of this name.
pub(super) fn of_view(view: &View, grid: &GridSettings, screen_name: &str) -> Pattern {
    match view {
        View::Coded => grid.coded.clone().into(),
        View::Unary => grid.unary_grid().into(),
        View::TwoColour => grid.two_colour_grid().into(),
        View::Black => Pattern::BLACK,
        View::White => Pattern::WHITE,
        View::Solid { colour } => Pattern::Solid { colour: *colour },
        View::Grid(grid) => grid.clone().into(),
        View::Ramp => Pattern::Ramp,
        View::TestCard => Pattern::TestCard,
        View::Identify => Pattern::Identify {
            label: screen_name.to_owned(),
        },
    }
}
