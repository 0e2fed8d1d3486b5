//! Drawings into pixels, with smooth edges; letters are an 8 x 8 bitmap font, smoothed when enlarged.

use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};
use image::{Rgb as Pixel, RgbImage};

use super::{Anchor, Drawing, Form, Ink, Text, distance_to_segment};

/// Height and width of a letter in the font, in dots.
const LETTER_DOTS: f64 = 8.0;
/// A letter's height as a part of the text's size, so that it looks as high as the report's letters.
const LETTER_SHARE: f64 = 0.82;

impl Drawing {
    /// Paints the drawing over a picture that shows one unit as `scale` pixels.
    pub fn paint(&self, picture: &mut RgbImage, scale: f64) {
        let scaled = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
            points.iter().map(|p| p.map(|v| v * scale)).collect()
        };
        for mark in &self.marks {
            match &mark.form {
                Form::Stroke { points, width, ink } => {
                    stroke(picture, &scaled(points), width * scale, *ink);
                }
                Form::Area { points, ink } => area(picture, &scaled(points), *ink),
                Form::Disc {
                    centre,
                    radius,
                    ink,
                } => {
                    let centre = centre.map(|v| v * scale);
                    stroke(picture, &[centre, centre], 2.0 * radius * scale, *ink);
                }
                Form::Text(text) => letters(picture, text, scale),
            }
        }
    }
}

fn stroke(picture: &mut RgbImage, points: &[[f64; 2]], width: f64, ink: Ink) {
    let reach = width / 2.0;
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        cover(picture, &[a, b], reach + 1.0, ink, |p| {
            reach + 0.5 - distance_to_segment(p, a, b)
        });
    }
}

fn area(picture: &mut RgbImage, points: &[[f64; 2]], ink: Ink) {
    let sides: Vec<_> = (0..points.len())
        .map(|k| (points[k], points[(k + 1) % points.len()]))
        .filter(|(a, b)| a != b)
        .collect();
    let twice_area: f64 = sides.iter().map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    // each side as its inward normal and its distance from the origin
    let sides: Vec<[f64; 3]> = sides
        .iter()
        .map(|(a, b)| {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let scale = twice_area.signum() / dx.hypot(dy);
            let (nx, ny) = (-dy * scale, dx * scale);
            [nx, ny, nx * a[0] + ny * a[1]]
        })
        .collect();
    cover(picture, points, 1.0, ink, |p| {
        let mut inside = f64::INFINITY;
        for [nx, ny, distance] in &sides {
            inside = inside.min(nx * p[0] + ny * p[1] - distance);
        }
        inside + 0.5
    });
}

/// Blends ink into every pixel near some points, as far as `coverage` (cut to 0..1) says for its centre.
fn cover(
    picture: &mut RgbImage,
    points: &[[f64; 2]],
    margin: f64,
    ink: Ink,
    coverage: impl Fn([f64; 2]) -> f64,
) {
    if !points.iter().flatten().all(|v| v.is_finite()) {
        return;
    }
    let range = |axis: usize, length: u32| {
        let values = points.iter().map(|p| p[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min) - margin;
        let high = values.fold(f64::NEG_INFINITY, f64::max) + margin;
        let pixel = |v: f64| v.clamp(0.0, f64::from(length)) as u32;
        pixel(low.floor())..pixel(high.ceil())
    };
    let columns = range(0, picture.width());
    for y in range(1, picture.height()) {
        for x in columns.clone() {
            let share = coverage([f64::from(x) + 0.5, f64::from(y) + 0.5]).clamp(0.0, 1.0);
            if share > 0.0 {
                blend(picture.get_pixel_mut(x, y), ink, share);
            }
        }
    }
}

fn blend(pixel: &mut Pixel<u8>, ink: Ink, share: f64) {
    let share = share * ink.opacity;
    for (below, above) in pixel.0.iter_mut().zip(ink.colour.0) {
        // both are at most 255, so adding a half and cutting off rounds
        *below = (f64::from(*below) * (1.0 - share) + f64::from(above) * share + 0.5) as u8;
    }
}

fn letters(picture: &mut RgbImage, text: &Text, scale: f64) {
    // whole dots up to four pixels keep small letters clear
    let wanted = text.size * scale * LETTER_SHARE / LETTER_DOTS;
    let dot = if wanted < 4.0 {
        wanted.round().max(1.0)
    } else {
        wanted
    };
    let width = dot * LETTER_DOTS * text.text.chars().count() as f64;
    let before = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => width / 2.0,
        Anchor::End => width,
    };
    let left = (text.at[0] * scale - before).round();
    let top = (text.at[1] * scale - dot * LETTER_DOTS / 2.0).round();
    let passes = [text.halo.map(|ink| (ink, dot)), Some((text.ink, 0.0))];
    for (ink, grow) in passes.into_iter().flatten() {
        for (k, letter) in text.text.chars().enumerate() {
            let corner = [left + k as f64 * dot * LETTER_DOTS, top];
            paint_letter(picture, bitmap(letter), corner, dot, (ink, grow));
        }
    }
}

/// The rows of a letter, the lowest bit on the left; a letter the font lacks is a box.
fn bitmap(letter: char) -> [u8; 8] {
    BASIC_FONTS
        .get(letter)
        .or_else(|| LATIN_FONTS.get(letter))
        .unwrap_or([0x7e, 0x42, 0x42, 0x42, 0x42, 0x42, 0x7e, 0])
}

fn paint_letter(
    picture: &mut RgbImage,
    rows: [u8; 8],
    [left, top]: [f64; 2],
    dot: f64,
    (ink, grow): (Ink, f64),
) {
    let side = dot * LETTER_DOTS;
    let corners = [[left, top], [left + side, top + side]];
    let is_set = |x: i64, y: i64| {
        (0..8).contains(&x) && (0..8).contains(&y) && rows[y as usize] >> x & 1 == 1
    };
    cover(picture, &corners, grow.ceil(), ink, |[px, py]| {
        let (u, v) = ((px - left) / dot, (py - top) / dot);
        if grow > 0.0 {
            let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let hit = |(dx, dy)| is_set(u.floor() as i64 + dx, v.floor() as i64 + dy);
            return if near.into_iter().any(hit) { 1.0 } else { 0.0 };
        }
        if dot < 2.0 {
            return f64::from(u8::from(is_set(u.floor() as i64, v.floor() as i64)));
        }
        smooth_dot(u - 0.5, v - 0.5, is_set, dot)
    });
}

/// Dots blended into their neighbours and cut again at half: rounds the corners of an enlarged letter.
fn smooth_dot(u: f64, v: f64, is_set: impl Fn(i64, i64) -> bool, dot: f64) -> f64 {
    let (x, y) = (u.floor(), v.floor());
    let (fx, fy) = (u - x, v - y);
    let set = |dx: i64, dy: i64| f64::from(u8::from(is_set(x as i64 + dx, y as i64 + dy)));
    let upper = set(0, 0) * (1.0 - fx) + set(1, 0) * fx;
    let lower = set(0, 1) * (1.0 - fx) + set(1, 1) * fx;
    let level = upper * (1.0 - fy) + lower * fy;
    (level - 0.5) * dot + 0.5
}
