//! Slowly varying pictures: one value per tile, bilinear between the tiles' centres.
//!
//! Serves levels that the stages need locally: the dark between lines, the strength of lines. A change
//! within a tile (an edge between two surfaces) is smoothed over one tile.

use super::plane::Plane;

/// One value for each square tile of a picture.
#[derive(Debug, Clone)]
pub struct Tiles {
    side: usize,
    columns: usize,
    rows: usize,
    values: Vec<f32>,
}

impl Tiles {
    /// Tiles of `side` pixels over a picture, from the value that `level` gives for each tile's samples
    /// (sorted; every second pixel of every second row).
    fn from_samples(plane: &Plane, side: usize, level: impl Fn(&[f32]) -> f32) -> Self {
        let side = side.clamp(4, 4096);
        let (columns, rows) = (
            plane.width().div_ceil(side).max(1),
            plane.height().div_ceil(side).max(1),
        );
        let mut values = Vec::with_capacity(columns * rows);
        let mut samples = Vec::new();
        for ty in 0..rows {
            for tx in 0..columns {
                samples.clear();
                for y in (ty * side..((ty + 1) * side).min(plane.height())).step_by(2) {
                    let row = plane.row(y);
                    let end = ((tx + 1) * side).min(row.len());
                    samples.extend(row[(tx * side).min(end)..end].iter().step_by(2));
                }
                samples.sort_by(f32::total_cmp);
                values.push(level(&samples));
            }
        }
        Self {
            side,
            columns,
            rows,
            values,
        }
    }

    /// The quantile `share` (0 to 1) of each tile.
    #[must_use]
    pub fn quantile(plane: &Plane, side: usize, share: f64) -> Self {
        Self::from_samples(plane, side, |sorted| {
            let at = (share * sorted.len() as f64) as usize;
            sorted
                .get(at.min(sorted.len().saturating_sub(1)))
                .copied()
                .unwrap_or(0.0)
        })
    }

    /// The value at an edge-coordinate position, bilinear between the tiles' centres.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> f32 {
        let side = self.side as f64;
        let cell = |position: f64, count: usize| {
            let from_first = (position / side - 0.5).clamp(0.0, (count - 1) as f64);
            let whole = (from_first as usize).min(count - 1);
            (
                whole,
                (whole + 1).min(count - 1),
                (from_first - whole as f64) as f32,
            )
        };
        let (x0, x1, fx) = cell(x, self.columns);
        let (y0, y1, fy) = cell(y, self.rows);
        let value = |x: usize, y: usize| self.values[y * self.columns + x];
        let top = value(x0, y0) + fx * (value(x1, y0) - value(x0, y0));
        let bottom = value(x0, y1) + fx * (value(x1, y1) - value(x0, y1));
        top + fy * (bottom - top)
    }

    /// A picture of the given size.
    #[must_use]
    pub fn spread(&self, width: usize, height: usize) -> Plane {
        let mut plane = Plane::filled(width, height, 0.0);
        for y in 0..height {
            let row = &mut plane.values_mut()[y * width..(y + 1) * width];
            for (x, value) in row.iter_mut().enumerate() {
                *value = self.at(x as f64 + 0.5, y as f64 + 0.5);
            }
        }
        plane
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_found_beside_bright_lines() {
        let mut plane = Plane::filled(64, 48, 0.2);
        for y in 0..48 {
            plane.values_mut()[y * 64 + 20] = 1.0;
        }
        let level = Tiles::quantile(&plane, 16, 0.25).spread(64, 48);
        assert!(level.values().iter().all(|&v| (v - 0.2).abs() < 1e-6));
    }

    #[test]
    fn a_picture_smaller_than_a_tile_has_one_tile() {
        let tiles = Tiles::quantile(&Plane::filled(1, 1, 0.5), 32, 0.5);
        assert_eq!(tiles.at(0.5, 0.5), 0.5);
        assert_eq!(
            Tiles::quantile(&Plane::default(), 32, 0.5).at(0.0, 0.0),
            0.0
        );
    }
}
