//! What the projector showed, when: the memory of a simulated screen.
//!
//! Times are those of the caller's clock, as durations since any fixed moment; nothing here looks at a clock.

use std::{collections::VecDeque, time::Duration};

use super::{flicker::ColourWheel, light::ProjectedLight, random::Random, scene::Scene};
use crate::pattern::{Raster, Rgb};

/// The pictures of a projector in the order in which they were sent to it.
///
/// The light follows a picture after the display's latency, plus a share of its jitter that depends only on the
/// scene's seed and on how many pictures came before.
#[derive(Debug, Clone)]
pub struct Timeline {
    scene: Scene,
    wheel: ColourWheel,
    random: Random,
    count: u64,
    dark: ProjectedLight,
    shown: VecDeque<Shown>,
}

#[derive(Debug, Clone)]
struct Shown {
    lit_from: Duration,
    picture: Raster,
    light: ProjectedLight,
}

impl Timeline {
    /// A projector that is on and has shown nothing but black.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let black = Raster::from_fn(scene.projector_size(), |_, _| Rgb::BLACK);
        Self {
            wheel: ColourWheel::new(&scene.faults),
            random: scene.random().part(u64::MAX),
            count: 0,
            dark: scene.project(&black),
            shown: VecDeque::new(),
            scene: scene.clone(),
        }
    }

    /// A picture is sent to the screen at time `at`; it stays until the next one.
    pub fn show(&mut self, at: Duration, picture: &Raster) {
        let jitter = self.scene.projector.display_jitter_ms * self.random.uniform(self.count);
        self.count += 1;
        let delay_ms = self.scene.projector.display_latency_ms + jitter;
        let delay = Duration::from_secs_f64(delay_ms / 1000.0);
        let earliest = self
            .shown
            .back()
            .map_or(Duration::ZERO, |last| last.lit_from);
        let lit_from = at.saturating_add(delay).max(earliest);
        // flashes come again and again, and a slow machine must keep up with them
        let known = self.shown.iter().find(|shown| shown.picture == *picture);
        let light = known.map_or_else(|| self.scene.project(picture), |shown| shown.light.clone());
        self.shown.push_back(Shown {
            lit_from,
            picture: picture.clone(),
            light,
        });
    }

    /// Forgets the pictures whose light had gone by time `at`, to free their memory.
    pub fn forget_before(&mut self, at: Duration) {
        while self.shown.get(1).is_some_and(|next| next.lit_from <= at) {
            self.shown.pop_front();
        }
    }

    /// The lights between two times and the share of that time each was on, for red, green and blue; the shares
    /// sum to 1 unless the colours come one after the other.
    ///
    /// An empty span is the moment `from`.
    pub(super) fn between(&self, from: Duration, to: Duration) -> Vec<(ProjectedLight, [f32; 3])> {
        let starts = std::iter::once((Duration::ZERO, &self.dark)).chain(
            self.shown
                .iter()
                .map(|shown| (shown.lit_from, &shown.light)),
        );
        let ends = self
            .shown
            .iter()
            .map(|shown| shown.lit_from)
            .chain([Duration::MAX]);
        let span = to.saturating_sub(from);
        if span.is_zero() {
            let last = starts.take_while(|(start, _)| *start <= from).last();
            return last
                .map(|(_, light)| (light.clone(), [1.0; 3]))
                .into_iter()
                .collect();
        }
        starts
            .zip(ends)
            .map(|((start, light), end)| (light, start.max(from), end.min(to)))
            .filter(|(_, begin, end)| begin < end)
            .map(|(light, begin, end)| (light.clone(), self.wheel.shares(begin, end, span)))
            .collect()
    }
}
