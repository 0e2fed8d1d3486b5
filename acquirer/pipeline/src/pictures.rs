//! The stages' products as pictures that a person can look at.

use image::{Rgb, RgbImage};
use shared::{geometry::CameraPixel, pattern::Axis};

use super::{
    PipelineSettings, StagePicture,
    gain::GainImage,
    grid::DecodedGrid,
    line_light::LineLight,
    lines::Lines,
    plane::Plane,
    reference::{References, lit_mask},
    response::CLIPPED_LIGHT,
    stale::StaleTiles,
};

const ROW_COLOUR: Rgb<u8> = Rgb([255, 160, 0]);
const COLUMN_COLOUR: Rgb<u8> = Rgb([0, 180, 255]);
const READ_COLOUR: Rgb<u8> = Rgb([0, 255, 80]);
const DROPPED_COLOUR: Rgb<u8> = Rgb([255, 40, 40]);

/// The stages' products.
pub(super) struct Seen<'a> {
    pub(super) references: &'a References,
    pub(super) stale: &'a StaleTiles,
    pub(super) coded: &'a LineLight<'a>,
    /// The gain image that the lines were found in.
    pub(super) gain: &'a GainImage,
    pub(super) lines: &'a Lines,
    pub(super) grid: &'a DecodedGrid,
}

/// The pictures in reading order.
pub(super) fn draw(seen: &Seen<'_>, settings: &PipelineSettings) -> Vec<StagePicture> {
    let Seen { lines, grid, .. } = seen;
    let gain = gain(seen);
    let dimmed = dimmed(&gain);
    vec![
        StagePicture {
            name: "mask",
            caption:
                "Where the projector's light can be used: black is shadow or out of reach, red was \
                      clipped in the coded capture or a reference, blue has changed since the references."
                    .to_owned(),
            picture: mask(seen, settings),
        },
        StagePicture {
            name: "gain",
            caption:
                "Gain image: the share of white light that arrives, whatever the surface's colour."
                    .to_owned(),
            picture: gain,
        },
        StagePicture {
            name: "lines",
            caption: format!(
                "Line map: the middles of {} rows' (orange) and {} columns' (blue) tracks.",
                lines.rows.tracks.len(),
                lines.columns.tracks.len()
            ),
            picture: tracks(lines, dimmed.clone()),
        },
        StagePicture {
            name: "crossings",
            caption: format!(
                "Vertices of {} labelled crossings (green) and {} dropped crossings (red).",
                grid.crossings.len(),
                grid.dropped.len()
            ),
            picture: crossings(grid, dimmed),
        },
    ]
}

fn byte(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0) as u8
}

fn grey(plane: &Plane) -> RgbImage {
    RgbImage::from_fn(plane.width() as u32, plane.height() as u32, |x, y| {
        let value = plane.values()[y as usize * plane.width() + x as usize];
        Rgb([byte(value); 3])
    })
}

/// The gain at the camera's resolution.
fn gain(seen: &Seen<'_>) -> RgbImage {
    let (width, height) = (seen.coded.width(), seen.coded.height());
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        Rgb([byte(seen.gain.at(x as usize, y as usize)); 3])
    })
}

fn dimmed(gain: &RgbImage) -> RgbImage {
    let mut picture = gain.clone();
    picture.iter_mut().for_each(|byte| *byte /= 3);
    picture
}

fn mask(seen: &Seen<'_>, settings: &PipelineSettings) -> RgbImage {
    let (width, height) = (seen.coded.width(), seen.coded.height());
    let mut picture = match seen.references.white {
        Some(_) => grey(&lit_mask(seen.coded, &settings.reference)),
        None => RgbImage::from_pixel(width as u32, height as u32, Rgb([255; 3])),
    };
    let mut light = std::array::from_fn(|_| vec![0.0; width]);
    for y in 0..height {
        seen.coded
            .response
            .light_row(seen.coded.frames, y, &mut light);
        for x in 0..width {
            let before = seen.coded.clipped.get(y * width + x).copied();
            if seen.stale.holds(x, y) {
                let pixel = picture.get_pixel_mut(x as u32, y as u32);
                pixel.0 = [pixel.0[0] / 2, pixel.0[1] / 2, pixel.0[2] / 2 + 100];
            }
            if before.is_some_and(|bits| bits != 0)
                || light.iter().any(|channel| channel[x] >= CLIPPED_LIGHT)
            {
                picture.put_pixel(x as u32, y as u32, DROPPED_COLOUR);
            }
        }
    }
    picture
}

fn tracks(lines: &Lines, mut picture: RgbImage) -> RgbImage {
    for axis in Axis::BOTH {
        for track in &lines.family(axis).tracks {
            for (k, (&across, &strength)) in track.across.iter().zip(&track.strength).enumerate() {
                let along = track.along(k);
                let (position, colour) = match axis {
                    Axis::Row => (CameraPixel::new(along, f64::from(across)), ROW_COLOUR),
                    Axis::Column => (CameraPixel::new(f64::from(across), along), COLUMN_COLOUR),
                };
                if strength > 0.0 {
                    dot(&mut picture, position, colour);
                }
            }
        }
    }
    picture
}

fn crossings(grid: &DecodedGrid, mut picture: RgbImage) -> RgbImage {
    for vertex in grid.crossings.iter().flat_map(|crossing| crossing.vertices) {
        dot(&mut picture, vertex, READ_COLOUR);
    }
    for crossing in &grid.dropped {
        for k in -2..=2 {
            let at = |dx, dy| CameraPixel::new(crossing.centre.x + dx, crossing.centre.y + dy);
            dot(&mut picture, at(f64::from(k), f64::from(k)), DROPPED_COLOUR);
            dot(
                &mut picture,
                at(f64::from(k), f64::from(-k)),
                DROPPED_COLOUR,
            );
        }
    }
    picture
}

fn dot(picture: &mut RgbImage, at: CameraPixel, colour: Rgb<u8>) {
    if at.x >= 0.0
        && at.y >= 0.0
        && at.x < f64::from(picture.width())
        && at.y < f64::from(picture.height())
    {
        picture.put_pixel(at.x as u32, at.y as u32, colour);
    }
}
