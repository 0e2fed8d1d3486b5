//! Triangles into pixels: a depth buffer, nine samples per pixel, light from the upper left.

use image::{Rgb as Pixel, RgbImage};

/// Samples per pixel in each direction.
const SAMPLES: u32 = 3;
/// Width of the line along the grid, in px.
const LINE_PX: f64 = 1.3;
/// How much of a line's light is left.
const LINE_SHADE: f64 = 0.55;

/// How much of a dot's light is left.
const DOT_SHADE: f64 = 0.7;
/// How far a dot stands before the surface, in px, so that the surface through it does not hide it.
const DOT_BEFORE_PX: f64 = 2.0;

/// A corner of a triangle, as it is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    /// Position on the drawing and distance from the viewer, in px.
    pub(super) place: [f64; 3],
    /// Direction square to the surface (right, down, away), of any length; zero for no shading.
    pub(super) normal: [f64; 3],
    /// What is handed to the colouring: a number, or a place in a picture.
    pub(super) value: [f64; 2],
}

/// Samples of a picture that triangles have been drawn into.
pub(super) struct Samples {
    width: u32,
    height: u32,
    away: Vec<f32>,
    colour: Vec<[u8; 3]>,
}

impl Samples {
    /// Nothing drawn, for a picture of this size in px.
    pub(super) fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width * SAMPLES, height * SAMPLES);
        let count = width as usize * height as usize;
        Self {
            width,
            height,
            away: vec![f32::INFINITY; count],
            colour: vec![[0; 3]; count],
        }
    }

    /// Draws a triangle; the side between its first two corners is a line of the grid.
    pub(super) fn triangle(&mut self, corners: &[Corner; 3], colour: &dyn Fn([f64; 2]) -> [u8; 3]) {
        let scale = f64::from(SAMPLES);
        let p = corners.map(|c| [c.place[0] * scale, c.place[1] * scale]);
        let twice_area = cross(p[0], p[1], p[2]);
        if !twice_area.is_finite() || twice_area.abs() < 1e-9 {
            return;
        }
        let side = (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]);
        let line_share = LINE_PX / 2.0 * scale * side / twice_area.abs();
        let span = |k: usize, length: u32| {
            let values = p.map(|q| q[k]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let clamp = |v: f64| v.clamp(0.0, f64::from(length)) as u32;
            clamp((low - 0.5).ceil())..clamp((high + 0.5).ceil())
        };
        let columns = span(0, self.width);
        for y in span(1, self.height) {
            for x in columns.clone() {
                let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let weights = [
                    cross(at, p[1], p[2]) / twice_area,
                    cross(p[0], at, p[2]) / twice_area,
                    cross(p[0], p[1], at) / twice_area,
                ];
                if weights.iter().all(|&w| w >= -1e-9) {
                    let shade = if weights[2] < line_share {
                        LINE_SHADE
                    } else {
                        1.0
                    };
                    self.sample((x, y), corners, weights, (shade, colour));
                }
            }
        }
    }

    /// Draws a round dot of a given radius (px) a little before the surface, darker than it.
    pub(super) fn dot(&mut self, place: [f64; 3], radius: f64, colour: [u8; 3]) {
        if !place.iter().all(|v| v.is_finite()) {
            return;
        }
        let scale = f64::from(SAMPLES);
        let (x, y, r) = (place[0] * scale, place[1] * scale, radius * scale);
        let away = (place[2] - DOT_BEFORE_PX) as f32;
        let span = |centre: f64, length: u32| {
            let clamp = |v: f64| v.clamp(0.0, f64::from(length)) as u32;
            clamp((centre - r).floor())..clamp((centre + r).ceil())
        };
        for sy in span(y, self.height) {
            for sx in span(x, self.width) {
                let at = sy as usize * self.width as usize + sx as usize;
                let inside = (f64::from(sx) + 0.5 - x).hypot(f64::from(sy) + 0.5 - y) <= r;
                if inside && away < self.away[at] {
                    self.away[at] = away;
                    self.colour[at] = colour.map(|v| (f64::from(v) * DOT_SHADE) as u8);
                }
            }
        }
    }

    fn sample(
        &mut self,
        (x, y): (u32, u32),
        corners: &[Corner; 3],
        weights: [f64; 3],
        (shade, colour): (f64, &dyn Fn([f64; 2]) -> [u8; 3]),
    ) {
        let [a, b, c] = corners;
        let [u, v, w] = weights;
        let mix = |a: f64, b: f64, c: f64| u * a + v * b + w * c;
        let away = mix(a.place[2], b.place[2], c.place[2]) as f32;
        let at = y as usize * self.width as usize + x as usize;
        if away >= self.away[at] {
            return;
        }
        let normal = [0, 1, 2].map(|k| mix(a.normal[k], b.normal[k], c.normal[k]));
        let value = [0, 1].map(|k| mix(a.value[k], b.value[k], c.value[k]));
        let light = shade * light(normal);
        self.away[at] = away;
        self.colour[at] = colour(value).map(|v| (f64::from(v) * light).clamp(0.0, 255.0) as u8);
    }

    /// Puts what was drawn over a picture, each pixel the mean of its samples.
    pub(super) fn put_over(&self, picture: &mut RgbImage) {
        for (x, y, pixel) in picture.enumerate_pixels_mut() {
            if !self.is_covered(x, y) {
                continue;
            }
            let mut sum = [0_u32; 3];
            for dy in 0..SAMPLES {
                for dx in 0..SAMPLES {
                    let (sx, sy) = (x * SAMPLES + dx, y * SAMPLES + dy);
                    let at = sy as usize * self.width as usize + sx as usize;
                    let below = pixel.0;
                    let sample = match self.away.get(at) {
                        Some(away) if away.is_finite() => self.colour[at],
                        _ => below,
                    };
                    for (total, value) in sum.iter_mut().zip(sample) {
                        *total += u32::from(value);
                    }
                }
            }
            let count = SAMPLES * SAMPLES;
            *pixel = Pixel(sum.map(|total| ((total + count / 2) / count) as u8));
        }
    }
}

impl Samples {
    /// Whether something was drawn into a pixel.
    fn is_covered(&self, x: u32, y: u32) -> bool {
        (0..SAMPLES).any(|dy| {
            let begin = (y * SAMPLES + dy) as usize * self.width as usize + (x * SAMPLES) as usize;
            let row = self.away.get(begin..begin + SAMPLES as usize);
            row.is_some_and(|row| row.iter().any(|away| away.is_finite()))
        })
    }
}

/// How much light a surface sends to the viewer: matt, lit from the upper left, never quite dark.
fn light(normal: [f64; 3]) -> f64 {
    let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length < 1e-12 {
        return 1.0;
    }
    // the side that is seen points to the viewer
    let towards = if normal[2] > 0.0 { -1.0 } else { 1.0 };
    let lamp = [-0.48, -0.52, -0.707];
    let cosine: f64 = normal.iter().zip(lamp).map(|(a, b)| a * b).sum();
    0.42 + 0.66 * (towards * cosine / length).max(0.0)
}

fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
