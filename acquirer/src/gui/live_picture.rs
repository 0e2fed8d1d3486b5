//! The live picture as the window shows it: made in the rig's thread, so that the window's own only hands it on.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

use eframe::egui::{Color32, ColorImage};
use image::RgbImage;
use shared::pattern::Grid;

use super::preferences::Overlays;
use crate::{
    output::{drawing::simplified, maps::reason_colour},
    pipeline::{
        Reader,
        grid::{DecodedGrid, DropReason},
        plane::Plane,
    },
    session::{CarriedLabel, LiveMode},
};

/// Lines may be drawn this far beside their points, in camera pixels.
const TOLERANCE_PX: f64 = 0.35;
/// A byte from here on counts as clipped, one up to there as black.
const CLIPPED_FROM: u8 = 250;
const BLACK_TO: u8 = 5;
const CLIPPED: Color32 = Color32::from_rgba_premultiplied(235, 30, 30, 240);
const BLACK: Color32 = Color32::from_rgba_premultiplied(20, 50, 160, 170);
const SHADOW: Color32 = Color32::from_rgba_premultiplied(70, 20, 90, 130);
/// Lines that were found but not read.
const UNREAD: Color32 = Color32::from_gray(150);

/// What of the live picture is wanted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Wishes {
    /// The picture after processing instead of the camera's.
    pub(super) after: bool,
    /// Processing takes the background away.
    pub(super) subtract: bool,
    /// Hues and number of the recovered pixels.
    pub(super) histogram: bool,
    /// What lies over the picture.
    pub(super) overlays: Overlays,
    /// The camera's controls are in sight, and are to be told when they change.
    pub(super) controls: bool,
}

/// A picture of the live view.
#[derive(Debug, Clone)]
pub(super) struct LivePicture {
    /// What is seen.
    pub(super) image: Arc<ColorImage>,
    /// Marks of pixels over it, if any are wanted.
    pub(super) marks: Option<Arc<ColorImage>>,
    /// The camera's number of the frame.
    pub(super) number: u64,
    /// Frames per second over the last second.
    pub(super) rate_hz: f64,
    /// Frames that the camera made and nobody saw.
    pub(super) lost: u64,
    /// What was read from the frame, while frames are read.
    pub(super) reading: Option<LiveReading>,
    /// Pixels that are left when the background is taken away, and their hues.
    pub(super) recovered: Option<(usize, Vec<u32>)>,
}

/// What was read from a live frame.
#[derive(Debug, Clone)]
pub(super) struct LiveReading {
    /// How it was read.
    pub(super) mode: LiveMode,
    /// What the frame shows, in the words of the session.
    pub(super) pattern: &'static str,
    /// Crossings with a label.
    pub(super) crossings: usize,
    /// Crossings of the projected grid.
    pub(super) possible: usize,
    /// How many crossings have no label, by reason.
    pub(super) reasons: BTreeMap<&'static str, usize>,
    /// Time that reading took, in milliseconds.
    pub(super) ms: f64,
    /// What is drawn over the picture.
    pub(super) overlay: Arc<Overlay>,
}

/// The decoded grid in strokes; positions in camera pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct Overlay {
    /// Lines in the colours they were projected in, grey where they were not read.
    pub(super) lines: Vec<(Vec<[f32; 2]>, Color32)>,
    /// Row and column of labelled crossings.
    pub(super) labels: Vec<([f32; 2], [u16; 2])>,
    /// Crossings without a label.
    pub(super) holes: Vec<([f32; 2], DropReason)>,
}

impl Overlay {
    /// What a decoded grid looks like.
    pub(super) fn of(grid: &DecodedGrid, pattern: &Grid) -> Self {
        let place = |x: f64, y: f64| [x as f32, y as f32];
        let lines = grid.tracks.iter().map(|track| {
            let points = track.points.iter().map(|p| [p.position.x, p.position.y]);
            let points = simplified(&points.collect::<Vec<_>>(), TOLERANCE_PX);
            let colour = track
                .line
                .and_then(|k| pattern.line_colour(track.axis, k.into()))
                .map_or(UNREAD, |c| Color32::from_rgb(c.0[0], c.0[1], c.0[2]));
            (points.iter().map(|p| place(p[0], p[1])).collect(), colour)
        });
        let labels = grid
            .crossings
            .iter()
            .map(|c| (place(c.centre.x, c.centre.y), [c.index.row, c.index.column]));
        let holes = grid
            .dropped
            .iter()
            .map(|d| (place(d.centre.x, d.centre.y), d.reason));
        Self {
            lines: lines.collect(),
            labels: labels.collect(),
            holes: holes.collect(),
        }
    }
}

impl Overlay {
    /// What a frame of the unary grid looks like: lines without a colour, and the labels that were carried on to it.
    pub(super) fn carried(grid: &DecodedGrid, labels: &[CarriedLabel], pattern: &Grid) -> Self {
        let labels = labels.iter().map(|(index, centre)| {
            let at = [centre.x as f32, centre.y as f32];
            (at, [index.row, index.column])
        });
        let mut seen = Self::of(grid, pattern);
        // a colour that is read in one-coloured lines means nothing
        for (_, colour) in &mut seen.lines {
            *colour = UNREAD;
        }
        Self {
            labels: labels.collect(),
            holes: Vec::new(),
            ..seen
        }
    }
}

/// The colour of a reason why a crossing has no label.
pub(super) fn hole_colour(reason: DropReason) -> Color32 {
    let [r, g, b] = reason_colour(reason);
    Color32::from_rgb(r, g, b)
}

/// A picture for the screen.
pub(super) fn screen_image(picture: &RgbImage) -> Arc<ColorImage> {
    let size = [picture.width() as usize, picture.height() as usize];
    Arc::new(ColorImage::from_rgb(size, picture.as_raw()))
}

/// The picture that is wanted of a frame, and what the histogram needs.
pub(super) fn wanted_picture(
    picture: &RgbImage,
    reader: Option<&Reader>,
    wishes: &Wishes,
) -> (Arc<ColorImage>, Option<(usize, Vec<u32>)>) {
    let takes_away = wishes.histogram || (wishes.after && wishes.subtract);
    let without = reader
        .filter(|_| takes_away)
        .and_then(|reader| reader.without_background(picture));
    let processed = match (&without, reader) {
        (Some(without), _) if wishes.subtract => Some(screen_image(&without.picture)),
        (_, Some(reader)) => reader.gain_picture().map(|gain| screen_image(&gain)),
        _ => None,
    };
    let image = processed
        .filter(|_| wishes.after)
        .unwrap_or_else(|| screen_image(picture));
    (image, without.map(|w| (w.recovered_px, w.hues)))
}

/// Marks of clipped and black pixels and of shadow; `None` when none are wanted.
pub(super) fn marks(
    picture: &RgbImage,
    lit: Option<&Plane>,
    overlays: Overlays,
) -> Option<Arc<ColorImage>> {
    if !(overlays.clipping || overlays.shadow) {
        return None;
    }
    let lit = lit.filter(|lit| {
        overlays.shadow && lit.values().len() == (picture.width() * picture.height()) as usize
    });
    let pixels = picture.as_raw().chunks_exact(3).enumerate();
    let marks = pixels.map(|(at, pixel)| {
        let brightest = pixel.iter().copied().max().unwrap_or(0);
        if overlays.clipping && brightest >= CLIPPED_FROM {
            CLIPPED
        } else if overlays.clipping && brightest <= BLACK_TO {
            BLACK
        } else if lit.is_some_and(|lit| lit.values()[at] < 0.5) {
            SHADOW
        } else {
            Color32::TRANSPARENT
        }
    });
    let size = [picture.width() as usize, picture.height() as usize];
    Some(Arc::new(ColorImage::new(size, marks.collect())))
}

/// A place for the newest picture, and for what is wanted of the next.
#[derive(Debug, Clone, Default)]
pub(super) struct LivePlace {
    picture: Arc<Mutex<Option<LivePicture>>>,
    wishes: Arc<Mutex<Wishes>>,
}

impl LivePlace {
    /// Puts a picture in place of the one nobody took.
    pub(super) fn put(&self, picture: LivePicture) {
        *self.picture.lock().unwrap_or_else(PoisonError::into_inner) = Some(picture);
    }

    /// Takes the newest picture, if there is a new one.
    pub(super) fn take(&self) -> Option<LivePicture> {
        self.picture
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
    }

    /// Says what is wanted from now on.
    pub(super) fn wish(&self, wishes: Wishes) {
        *self.wishes.lock().unwrap_or_else(PoisonError::into_inner) = wishes;
    }

    /// What is wanted.
    pub(super) fn wishes(&self) -> Wishes {
        *self.wishes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use image::Rgb;

    use super::*;

    #[test]
    fn clipped_pixels_are_red_black_ones_blue_and_others_free() {
        let mut picture = RgbImage::from_pixel(3, 1, Rgb([90, 90, 90]));
        picture.put_pixel(0, 0, Rgb([10, 255, 10]));
        picture.put_pixel(1, 0, Rgb([2, 0, 1]));
        let overlays = Overlays {
            clipping: true,
            ..Overlays::default()
        };
        let marks = marks(&picture, None, overlays).unwrap();
        assert_eq!(marks.pixels, [CLIPPED, BLACK, Color32::TRANSPARENT]);
    }

    #[test]
    fn without_a_wish_no_marks_are_made() {
        let overlays = Overlays::default();
        assert!(marks(&RgbImage::new(2, 2), None, overlays).is_none());
    }
}
