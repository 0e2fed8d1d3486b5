//! Some 4000 pixels of every frame: all that the choice looks at, so that its time hardly depends on the camera.
//!
//! Takes whole frames, gives small pictures of the pixels of a lattice, row by row. Each of the lattice's rows begins
//! elsewhere, and so does each of its columns, so that they fall into step with no grid.

use image::RgbImage;

use super::{ColourTrial, Shots, TILES};

/// About how many pixels of a frame are looked at.
const PLACES: f64 = 4000.0;

/// The frames of a trial, thinned; all of one size.
#[derive(Debug, Clone)]
pub(super) struct ThinTrial {
    pub thinning: Thinning,
    pub black: Vec<RgbImage>,
    pub white: Vec<RgbImage>,
    /// By colour, in the order of the shots.
    pub shots: Vec<Vec<RgbImage>>,
}

impl ThinTrial {
    pub(super) fn new(trial: &ColourTrial, shots: &[Shots<'_>]) -> Self {
        let (width, height) = trial.shots.first().map_or((1, 1), |s| s.1.dimensions());
        Self::of_step(trial, shots, Thinning::new(width, height))
    }

    pub(super) fn of_step(trial: &ColourTrial, shots: &[Shots<'_>], thinning: Thinning) -> Self {
        let thin = |frame: &RgbImage| thinning.thin(frame);
        Self {
            thinning,
            black: trial.black.iter().map(thin).collect(),
            white: trial.white.iter().map(thin).collect(),
            shots: shots
                .iter()
                .map(|shot| shot.frames.iter().map(|frame| thin(frame)).collect())
                .collect(),
        }
    }
}

/// The pixels of a picture that are looked at, themselves a small picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Thinning {
    /// Pixels from one to the next, across and down.
    step: usize,
    /// Width and height of the small picture.
    pub size: (usize, usize),
    /// Pixels of the whole picture for each one.
    pub scale: f64,
}

impl Thinning {
    pub(super) fn new(width: u32, height: u32) -> Self {
        let pixels = f64::from(width) * f64::from(height);
        let step = (pixels / PLACES).sqrt().round() as u32;
        Self::of_step(width, height, step.clamp(1, width.min(height).max(1)))
    }

    /// With a step that is no larger than the picture.
    pub(super) fn of_step(width: u32, height: u32, step: u32) -> Self {
        let size = ((width / step) as usize, (height / step) as usize);
        let whole = f64::from(width) * f64::from(height);
        Self {
            step: step as usize,
            size,
            scale: whole / (size.0 * size.1).max(1) as f64,
        }
    }

    fn thin(self, frame: &RgbImage) -> RgbImage {
        let (across, down) = self.size;
        let row_bytes = 3 * frame.width() as usize;
        let columns: Vec<usize> = (0..across)
            .map(|n| self.shift(n) * row_bytes + 3 * n * self.step)
            .collect();
        let mut bytes = Vec::with_capacity(3 * across * down);
        for n in 0..down {
            let row = &frame.as_raw()[n * self.step * row_bytes + 3 * self.shift(n)..];
            for &at in &columns {
                bytes.extend_from_slice(&row[at..at + 3]);
            }
        }
        RgbImage::from_raw(across as u32, down as u32, bytes).unwrap_or_default()
    }

    /// Where the lattice's row or column `n` begins: a share of the step by the golden section, in pixels.
    fn shift(self, n: usize) -> usize {
        ((n as f64 * 0.618_034).fract() * self.step as f64) as usize
    }

    /// The tile that a pixel of the small picture lies in.
    pub(super) fn tile(self, x: usize, y: usize) -> usize {
        let along = |at: usize, length: usize, tiles: usize| (at * tiles / length).min(tiles - 1);
        along(y, self.size.1, TILES.1) * TILES.0 + along(x, self.size.0, TILES.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_camera_is_looked_at_in_as_many_places() {
        for (width, height) in [(640, 480), (1280, 720), (1920, 1080), (3840, 2160)] {
            let (across, down) = Thinning::new(width, height).size;
            assert!((3500..4600).contains(&(across * down)), "{across} x {down}");
        }
    }

    #[test]
    fn the_smallest_pictures_have_a_place() {
        for (width, height) in [(1, 1), (1, 100_000), (2, 3), (7, 20_000)] {
            let thinning = Thinning::new(width, height);
            let small = thinning.thin(&RgbImage::new(width, height));
            assert!(
                small.width() > 0 && small.height() > 0,
                "{width} x {height}"
            );
        }
    }

    #[test]
    fn the_pixels_come_from_all_columns_and_rows_of_a_grid() {
        let frame = RgbImage::from_fn(640, 480, |x, y| {
            image::Rgb([(x % 32) as u8, (y % 32) as u8, 0])
        });
        let small = Thinning::new(640, 480).thin(&frame);
        for c in 0..2 {
            let mut seen = [0; 32];
            small
                .pixels()
                .for_each(|pixel| seen[usize::from(pixel.0[c])] += 1);
            let mean = small.pixels().len() / 32;
            assert!(
                seen.iter().all(|&n| 2 * n > mean && n < 2 * mean),
                "{seen:?}"
            );
        }
    }
}
