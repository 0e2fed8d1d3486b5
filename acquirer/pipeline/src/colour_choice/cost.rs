//! What another choice than the best would cost: for a person who wants other colours.

use shared::pattern::Rgb;

use super::{
    ColourSelection, ColourSet,
    select::UNKNOWN_ERROR,
    sets::{Set, members_of},
};

impl ColourSelection {
    /// Four of the colours that were tried, in the order given, with what is expected of them. `None` when one was not
    /// tried or two are the same.
    #[must_use]
    pub fn set_of(&self, colours: [Rgb; 4]) -> Option<ColourSet> {
        let tried: Vec<Rgb> = self.colours.iter().map(|entry| entry.colour).collect();
        let set = Set::new(members_of(colours, &tried)?, &self.separability);
        let name = |colour: Rgb| {
            let entry = self.colours.iter().find(|entry| entry.colour == colour);
            entry.map_or_else(|| colour.to_string(), |entry| entry.name.clone())
        };
        Some(ColourSet {
            colours,
            names: colours.map(name),
            expected_error: if self.measured {
                set.error.min(1.0)
            } else {
                UNKNOWN_ERROR
            },
            least_distance: set.distance,
        })
    }
}
