//! A room in one of its two stages, and the frames that its camera takes.
//!
//! Takes a scene and what the projector shows, gives camera frames. The room stands still, so everything but the
//! projector's light is worked out once: four rays per camera pixel find the surface, where on the projector's
//! raster its light comes from, how much of it arrives (distance, angle, shadow, vignetting, colour, gloss) and the
//! ambient light. A frame is then four look-ups per pixel and the sensor. Left out: light that reaches a surface
//! by way of another one, and lenses that are out of focus at some depths only.

use std::time::Duration;

use image::RgbImage;
use nalgebra::Vector4;
use rayon::prelude::*;

use super::{
    flicker::Lamp,
    light::{Place, ProjectedLight},
    room_camera::{Gathered, RowLight},
    scene::Scene,
    sensor::Sensor,
    solid::Hit,
    space::Space,
    surface::albedo_of,
    timeline::Timeline,
    truth::TruthVertex,
    tuning::CameraTuning,
};
use crate::{
    geometry::{CameraPixel, ProjectorPixel},
    pattern::{Grid, RasterSize},
    stage::Stage,
};

/// Where in a pixel its four rays go, px from its corner.
const SUBPIXELS: [[f64; 2]; 4] = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];

/// A scene in one stage, ready to give frames.
#[derive(Debug, Clone)]
pub struct Room {
    space: Space,
    sensor: Sensor,
    /// The scene's own settings of the camera.
    tuning: CameraTuning,
    readout: Duration,
    lamp: Lamp,
    pixels: Vec<Pixel>,
    /// Pixels in a row.
    width: usize,
}

/// The light that a camera pixel gathers, apart from what the projector shows.
#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    ambient: [f32; 3],
    lit: [Lit; 4],
}

/// One of a pixel's four rays: where on the projector its light comes from and how much of it arrives.
#[derive(Debug, Clone, Copy, Default)]
struct Lit {
    at: Place,
    share: [f32; 3],
}

impl Room {
    /// Works out the room: about a second for 640 x 480 on two cores.
    #[must_use]
    pub fn new(scene: &Scene, stage: Stage) -> Self {
        let mut room = Self {
            space: Space::new(scene, stage),
            sensor: Sensor::new(&scene.camera, scene.random()),
            tuning: CameraTuning::of(scene),
            readout: scene.readout(),
            lamp: Lamp::new(&scene.faults),
            pixels: Vec::new(),
            width: scene.camera.width as usize,
        };
        let count = room.width * scene.camera.height as usize;
        room.pixels = (0..count)
            .into_par_iter()
            .map(|index| room.pixel(scene, index))
            .collect();
        room
    }

    /// The frame that the camera takes while the projector shows one picture all the time.
    ///
    /// The same light and frame number give the same bytes.
    #[must_use]
    pub fn render(&self, light: &ProjectedLight, frame_number: u64) -> RgbImage {
        let steady = |_| RowLight {
            ambient: 1.0,
            projected: vec![(light.clone(), [1.0; 3])],
        };
        self.frame(steady, frame_number, &self.tuning, &mut Gathered::default())
    }

    /// The frame whose exposure began at a time of the timeline.
    ///
    /// Each row gathers what was on during its own exposure, so that a frame is torn or mixed where the picture
    /// changed meanwhile.
    #[must_use]
    pub fn render_at(
        &self,
        timeline: &Timeline,
        exposure_start: Duration,
        frame_number: u64,
    ) -> RgbImage {
        let moment = (timeline, exposure_start);
        self.expose(moment, frame_number, &self.tuning, &mut Gathered::default())
    }

    /// As [`Room::render_at`], by a camera with other settings than the scene's, which has the light of the frame
    /// before.
    pub(super) fn expose(
        &self,
        (timeline, exposure_start): (&Timeline, Duration),
        frame_number: u64,
        tuning: &CameraTuning,
        gathered: &mut Gathered,
    ) -> RgbImage {
        let rows = (self.pixels.len() / self.width) as f64;
        let lights = |row: usize| {
            let start = exposure_start.saturating_add(self.readout.mul_f64(row as f64 / rows));
            let end = start.saturating_add(tuning.exposure);
            RowLight {
                ambient: self.lamp.mean(start, end),
                projected: timeline.between(start, end),
            }
        };
        self.frame(lights, frame_number, tuning, gathered)
    }

    /// The geometry of the room.
    #[must_use]
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// See [`Space::truth`].
    #[must_use]
    pub fn truth(&self, grid: &Grid, size: RasterSize) -> Vec<TruthVertex> {
        self.space.truth(grid, size)
    }

    /// See [`Space::projector_at`].
    #[must_use]
    pub fn projector_at(&self, at: CameraPixel) -> Option<ProjectorPixel> {
        self.space.projector_at(at)
    }

    fn frame(
        &self,
        lights: impl Fn(usize) -> RowLight + Sync,
        frame_number: u64,
        tuning: &CameraTuning,
        gathered: &mut Gathered,
    ) -> RgbImage {
        // 1 at the scene's own exposure, whatever that is
        let scale = tuning.exposure.as_secs_f64() / self.tuning.exposure.as_secs_f64();
        let size = (self.width, self.pixels.len() / self.width);
        let blur = |signal: &[[f32; 3]]| self.sensor.blur(signal);
        let signal = gathered.follow(
            size,
            |row| lights(row).scaled(scale as f32),
            |row, light, signal| self.gather_row(row, light, signal),
            blur,
        );
        self.sensor.expose(signal, frame_number, tuning.gains())
    }

    fn gather_row(&self, row: usize, light: &RowLight, signal: &mut [[f32; 3]]) {
        let pixels = &self.pixels[row * self.width..(row + 1) * self.width];
        for (signal, pixel) in signal.iter_mut().zip(pixels) {
            *signal = pixel.ambient.map(|ambient| ambient * light.ambient);
        }
        for (light, [r, g, b]) in &light.projected {
            let share = Vector4::new(*r, *g, *b, 0.0);
            for (signal, pixel) in signal.iter_mut().zip(pixels) {
                let gathered = pixel.gather(light).component_mul(&share);
                signal
                    .iter_mut()
                    .zip(gathered.iter())
                    .for_each(|(s, g)| *s += g);
            }
        }
    }

    fn pixel(&self, scene: &Scene, index: usize) -> Pixel {
        let (x, y) = ((index % self.width) as f64, (index / self.width) as f64);
        let mut pixel = Pixel::default();
        for (lit, [dx, dy]) in pixel.lit.iter_mut().zip(SUBPIXELS) {
            let Some(sight) = self.space.sight(CameraPixel::new(x + dx, y + dy)) else {
                continue;
            };
            let albedo = self.space.solids[sight.hit.solid].albedo(&sight.hit);
            let ambient = ambient_light(scene, &sight.hit);
            for c in 0..3 {
                pixel.ambient[c] += albedo[c] * ambient[c] / 4.0;
            }
            if let Some(at) = sight.projector {
                *lit = self.lit(scene, &sight.hit, at, albedo);
            }
        }
        pixel
    }

    /// How much of the projector's light a place gives back towards the camera (Lambert, and Blinn's lobe).
    fn lit(&self, scene: &Scene, hit: &Hit, at: ProjectorPixel, albedo: [f32; 3]) -> Lit {
        let surface = &self.space.solids[hit.solid].surface;
        let [to_light, to_eye] = self.space.ways(&hit.point);
        let arriving = (scene.reference_mm / to_light.norm()).powi(2) * vignette(scene, at) / 4.0;
        let cosine = hit.shading_normal.dot(&to_light.normalize()).max(0.0);
        let halfway = to_light.normalize() + to_eye.normalize();
        let mirrored = halfway
            .try_normalize(1e-9)
            .map_or(0.0, |h| hit.shading_normal.dot(&h).max(0.0));
        let lobe = (surface.gloss_exponent + 8.0) / 8.0 * mirrored.powf(surface.gloss_exponent);
        let gloss = (surface.gloss * lobe * cosine * arriving) as f32;
        let diffuse = ((1.0 - surface.gloss) * cosine * arriving) as f32;
        Lit {
            at: Place::new(scene.projector_size(), at),
            share: albedo.map(|a| a * diffuse + gloss),
        }
    }
}

impl Pixel {
    /// The projector's light that this pixel gathers, before the sensor.
    #[inline]
    fn gather(&self, light: &ProjectedLight) -> Vector4<f32> {
        let mut sum = Vector4::zeros();
        for lit in self.lit.iter().filter(|lit| lit.share != [0.0; 3]) {
            let [r, g, b] = lit.share;
            sum += light.at(lit.at).component_mul(&Vector4::new(r, g, b, 0.0));
        }
        sum
    }
}

/// The ambient light on a place; 1 is as much as the projector's white at its reference distance.
fn ambient_light(scene: &Scene, hit: &Hit) -> [f32; 3] {
    let table = &scene.ambient;
    // y points down: a surface that looks up has a negative y
    let upwards = (1.0 - hit.shading_normal.y) / 2.0;
    let level = table.level * (1.0 - table.from_above + table.from_above * upwards);
    albedo_of(table.colour).map(|c| c * level as f32)
}

/// The share of light that vignetting leaves, falling with the square of the distance from the raster's middle.
fn vignette(scene: &Scene, at: ProjectorPixel) -> f64 {
    let (w, h) = (
        f64::from(scene.projector.width),
        f64::from(scene.projector.height),
    );
    let corner2 = (w * w + h * h) / 4.0;
    let distance2 = (at.x - w / 2.0).powi(2) + (at.y - h / 2.0).powi(2);
    1.0 - scene.projector.vignetting * (distance2 / corner2).min(1.0)
}
