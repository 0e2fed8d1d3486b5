//! Triangles into pixels: a depth buffer, nine samples per pixel, light from the upper left.
//!
//! A picture is drawn in bands of rows, so that the samples of only a few rows are in memory at a time.

use std::ops::Range;

use image::RgbImage;
use rayon::prelude::*;

/// Samples per pixel in each direction.
const SAMPLES: u32 = 3;
/// Rows of a band, in px.
const BAND_ROWS: usize = 16;
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

/// Draws over a picture, each pixel the mean of its samples. `draw` is asked for each band, by several threads, and
/// must do the same for all.
pub(super) fn draw_over(picture: &mut RgbImage, draw: impl Fn(&mut Samples) + Sync) {
    let (width, height) = picture.dimensions();
    let band = 3 * width.max(1) as usize * BAND_ROWS;
    let bands = picture.par_chunks_mut(band).enumerate();
    bands.for_each(|(k, pixels)| {
        let first = (k * BAND_ROWS) as u32;
        let last = (first + BAND_ROWS as u32).min(height);
        let mut samples = Samples::new(width, first..last);
        draw(&mut samples);
        samples.put_over(pixels);
    });
}

/// Samples of a band of a picture that triangles are drawn into.
pub(super) struct Samples {
    width: u32,
    rows: Range<u32>,
    away: Vec<f32>,
    colour: Vec<[u8; 3]>,
}

impl Samples {
    /// Nothing drawn, for a picture of this width and some of its rows, in px.
    fn new(width: u32, rows: Range<u32>) -> Self {
        let width = width * SAMPLES;
        let rows = rows.start * SAMPLES..rows.end * SAMPLES;
        let count = width as usize * rows.len();
        Self {
            width,
            rows,
            away: vec![f32::INFINITY; count],
            colour: vec![[0; 3]; count],
        }
    }

    /// Where a sample of the whole picture stands in the band.
    fn at(&self, x: u32, y: u32) -> usize {
        (y - self.rows.start) as usize * self.width as usize + x as usize
    }

    /// The samples between two places along the rows, or down the picture, that the band has.
    fn span(low: f64, high: f64, within: &Range<u32>) -> Range<u32> {
        let clamp = |v: f64| v.clamp(f64::from(within.start), f64::from(within.end)) as u32;
        clamp(low.ceil())..clamp(high.ceil())
    }

    /// Draws a cell as four triangles that meet in its middle, with lines along its sides.
    pub(super) fn cell(&mut self, corners: &[Corner; 4], colour: &dyn Fn([f64; 2]) -> [u8; 3]) {
        let middle = mean(corners);
        for k in 0..4 {
            self.triangle(&[corners[k], corners[(k + 1) % 4], middle], colour);
        }
    }

    /// Draws a triangle; the side between its first two corners is a line of the grid.
    fn triangle(&mut self, corners: &[Corner; 3], colour: &dyn Fn([f64; 2]) -> [u8; 3]) {
        let scale = f64::from(SAMPLES);
        let p = corners.map(|c| [c.place[0] * scale, c.place[1] * scale]);
        let twice_area = cross(p[0], p[1], p[2]);
        if !twice_area.is_finite() || twice_area.abs() < 1e-9 {
            return;
        }
        let side = (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]);
        let line_share = LINE_PX / 2.0 * scale * side / twice_area.abs();
        let span = |k: usize, within: &Range<u32>| {
            let values = p.map(|q| q[k]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            Self::span(low - 0.5, high + 0.5, within)
        };
        let columns = span(0, &(0..self.width));
        for y in span(1, &self.rows) {
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
    pub(super) fn dot(&mut self, place: [f64; 3], radius: f64, colour: impl Fn() -> [u8; 3]) {
        if !place.iter().all(|v| v.is_finite()) {
            return;
        }
        let scale = f64::from(SAMPLES);
        let (x, y, r) = (place[0] * scale, place[1] * scale, radius * scale);
        let away = (place[2] - DOT_BEFORE_PX) as f32;
        let span =
            |centre: f64, within: &Range<u32>| Self::span((centre - r).floor(), centre + r, within);
        let (columns, rows) = (span(x, &(0..self.width)), span(y, &self.rows));
        if rows.is_empty() {
            return;
        }
        let shaded = colour().map(|v| (f64::from(v) * DOT_SHADE) as u8);
        for sy in rows {
            for sx in columns.clone() {
                let at = self.at(sx, sy);
                let inside = (f64::from(sx) + 0.5 - x).hypot(f64::from(sy) + 0.5 - y) <= r;
                if inside && away < self.away[at] {
                    self.away[at] = away;
                    self.colour[at] = shaded;
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
        let at = self.at(x, y);
        if away >= self.away[at] {
            return;
        }
        let normal = [0, 1, 2].map(|k| mix(a.normal[k], b.normal[k], c.normal[k]));
        let value = [0, 1].map(|k| mix(a.value[k], b.value[k], c.value[k]));
        let light = shade * light(normal);
        self.away[at] = away;
        self.colour[at] = colour(value).map(|v| (f64::from(v) * light).clamp(0.0, 255.0) as u8);
    }

    /// Puts what was drawn over the pixels of the band.
    fn put_over(&self, pixels: &mut [u8]) {
        let width = (self.width / SAMPLES) as usize;
        for (at, pixel) in pixels.chunks_exact_mut(3).enumerate() {
            let (x, y) = ((at % width) as u32, (at / width) as u32);
            let samples = self.of_pixel(x, y);
            if samples.clone().all(|at| self.away[at].is_infinite()) {
                continue;
            }
            let mut sum = [0_u32; 3];
            for at in samples {
                let drawn = self.away[at].is_finite();
                for (c, total) in sum.iter_mut().enumerate() {
                    let value = if drawn { self.colour[at][c] } else { pixel[c] };
                    *total += u32::from(value);
                }
            }
            let count = SAMPLES * SAMPLES;
            for (value, total) in pixel.iter_mut().zip(sum) {
                *value = ((total + count / 2) / count) as u8;
            }
        }
    }

    /// The samples of a pixel of the band.
    fn of_pixel(&self, x: u32, y: u32) -> impl Iterator<Item = usize> + Clone {
        let first = (y * SAMPLES) as usize * self.width as usize + (x * SAMPLES) as usize;
        let width = self.width as usize;
        (0..SAMPLES as usize)
            .flat_map(move |dy| (0..SAMPLES as usize).map(move |dx| first + dy * width + dx))
    }
}

fn mean(corners: &[Corner; 4]) -> Corner {
    let sum = |value: &dyn Fn(&Corner) -> f64| corners.iter().map(value).sum::<f64>() / 4.0;
    Corner {
        place: [0, 1, 2].map(|k| sum(&|c| c.place[k])),
        normal: [0, 1, 2].map(|k| sum(&|c| c.normal[k])),
        value: [0, 1].map(|k| sum(&|c| c.value[k])),
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
