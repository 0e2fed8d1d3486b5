//! The camera of a room that takes frame after frame.
//!
//! Gives the same frames as the room itself. A picture stands for several frames as a rule, so the light of each row is
//! kept with what it came from, and worked out anew only when that is another.

use std::{sync::Arc, time::Duration};

use image::RgbImage;
use rayon::prelude::*;

use super::{Room, light::ProjectedLight, timeline::Timeline, tuning::CameraTuning};

/// Takes one frame of a room after the other.
#[derive(Debug)]
pub struct RoomCamera {
    room: Arc<Room>,
    gathered: Gathered,
}

impl RoomCamera {
    /// The camera of a room.
    #[must_use]
    pub fn new(room: Arc<Room>) -> Self {
        Self {
            room,
            gathered: Gathered::default(),
        }
    }

    /// Looks at a room: another stage of the scene, say.
    pub fn look_at(&mut self, room: &Arc<Room>) {
        if !Arc::ptr_eq(&self.room, room) {
            *self = Self::new(Arc::clone(room));
        }
    }

    /// The frame whose exposure began at a time of the timeline, by a camera with these settings; as
    /// [`Room::render_at`].
    #[must_use]
    pub fn take(
        &mut self,
        timeline: &Timeline,
        exposure_start: Duration,
        frame_number: u64,
        tuning: &CameraTuning,
    ) -> RgbImage {
        let moment = (timeline, exposure_start);
        self.room
            .expose(moment, frame_number, tuning, &mut self.gathered)
    }
}

/// The light that a camera has gathered during one exposure, before the sensor.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    rows: Vec<RowLight>,
    signal: Vec<[f32; 3]>,
    /// The same behind the lens.
    blurred: Vec<[f32; 3]>,
}

/// The light on a row of the camera during its exposure.
#[derive(Debug, Clone, Default)]
pub(super) struct RowLight {
    /// Ambient light as a share of its mean, at the scene's own exposure.
    pub(super) ambient: f32,
    /// Projector pictures, and the share of that exposure for which each of their colours was on.
    pub(super) projected: Vec<(ProjectedLight, [f32; 3])>,
}

impl RowLight {
    /// So many times as much.
    pub(super) fn scaled(mut self, scale: f32) -> Self {
        self.ambient *= scale;
        let shares = self.projected.iter_mut().flat_map(|(_, shares)| shares);
        shares.for_each(|share| *share *= scale);
        self
    }

    fn is(&self, other: &Self) -> bool {
        self.ambient == other.ambient
            && self.projected.len() == other.projected.len()
            && self
                .projected
                .iter()
                .zip(&other.projected)
                .all(|((a, share), (b, other))| a.is(b) && share == other)
    }
}

impl Gathered {
    /// Gathers the light of all rows of `width` pixels: `gather` writes a row's, `blur` makes a picture as the lens
    /// gives it.
    pub(super) fn follow(
        &mut self,
        (width, height): (usize, usize),
        lights: impl Fn(usize) -> RowLight + Sync,
        gather: impl Fn(usize, &RowLight, &mut [[f32; 3]]) + Sync,
        blur: impl FnOnce(&[[f32; 3]]) -> Vec<[f32; 3]>,
    ) -> &[[f32; 3]] {
        let fresh = self.rows.len() != height;
        if fresh {
            self.rows = vec![RowLight::default(); height];
            self.signal = vec![[0.0; 3]; width * height];
        }
        let rows = self
            .signal
            .par_chunks_mut(width)
            .zip(&mut self.rows)
            .enumerate();
        let changed = rows.map(|(row, (signal, before))| {
            let light = lights(row);
            let changed = fresh || !before.is(&light);
            if changed {
                gather(row, &light, signal);
                *before = light;
            }
            changed
        });
        if changed.reduce(|| false, |a, b| a | b) {
            self.blurred = blur(&self.signal);
        }
        &self.blurred
    }
}
