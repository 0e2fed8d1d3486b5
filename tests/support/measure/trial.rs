//! The frames of a colour trial in a simulated room, in memory.

use acquirer::pipeline::colour_choice::ColourTrial;
use shared::{
    pattern::{Grid, Palette, Pattern},
    simulation::{Room, Scene},
    stage::Stage,
};

/// Black and white twice and the grid in each colour of the shipped palette, as `acquirer colours` takes them; the
/// same arguments give the same bytes.
#[must_use]
pub fn colour_trial(scene: &Scene, stage: Stage, grid: &Grid) -> ColourTrial {
    let room = Room::new(scene, stage);
    let mut number = 0;
    let mut shoot = |pattern: &Pattern| {
        number += 1;
        let light = scene.project(&pattern.raster(scene.projector_size()));
        room.render(&light, number)
    };
    ColourTrial {
        black: (0..2).map(|_| shoot(&Pattern::BLACK)).collect(),
        white: (0..2).map(|_| shoot(&Pattern::WHITE)).collect(),
        shots: Palette::default()
            .colours()
            .iter()
            .map(|entry| (entry.clone(), shoot(&grid.unary(entry.colour).into())))
            .collect(),
    }
}
