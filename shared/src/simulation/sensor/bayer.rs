//! One colour per pixel, and the other two filled in from the neighbours.
//!
//! The mosaic is red, green / green, blue, from the upper left; the missing colours are the means of the two or
//! four nearest pixels that have them (bilinear), which gives the usual coloured fringes at edges.

use rayon::prelude::*;

/// The colour that the pixel in column `x` and row `y` sees: 0 red, 1 green, 2 blue.
#[inline]
pub(super) fn colour(x: usize, y: usize) -> usize {
    (x & 1) + (y & 1)
}

/// All three colours of every pixel of a mosaic with rows of `width`.
pub(super) fn fill_in(mosaic: &[f32], width: usize) -> Vec<[f32; 3]> {
    let mut picture = vec![[0.0; 3]; mosaic.len()];
    let height = mosaic.len() / width.max(1);
    picture
        .par_chunks_mut(width.max(1))
        .enumerate()
        .for_each(|(y, out)| {
            // mirrored at the border, so that the colours keep their turn
            let row = |y: usize| &mosaic[y * width..][..width];
            let above = row(if y == 0 { 1.min(height - 1) } else { y - 1 });
            let below = row(if y + 1 == height {
                y.saturating_sub(1)
            } else {
                y + 1
            });
            let rows = [above, row(y), below];
            for (x, out) in out.iter_mut().enumerate() {
                let left = if x == 0 { 1.min(width - 1) } else { x - 1 };
                let right = if x + 1 == width {
                    x.saturating_sub(1)
                } else {
                    x + 1
                };
                *out = fill_pixel(rows, [left, x, right], y);
            }
        });
    picture
}

#[inline]
fn fill_pixel(rows: [&[f32]; 3], [left, x, right]: [usize; 3], y: usize) -> [f32; 3] {
    let own = rows[1][x];
    let beside = (rows[1][left] + rows[1][right]) / 2.0;
    let stacked = (rows[0][x] + rows[2][x]) / 2.0;
    let cross = (beside + stacked) / 2.0;
    let diagonal = (rows[0][left] + rows[0][right] + rows[2][left] + rows[2][right]) / 4.0;
    match (x & 1, y & 1) {
        (0, 0) => [own, cross, diagonal],
        (1, 0) => [beside, own, stacked],
        (0, _) => [stacked, own, beside],
        _ => [diagonal, cross, own],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_colour_is_filled_in_exactly() {
        let (width, height) = (7, 5);
        let even = [0.5, 0.25, 0.125];
        let mosaic: Vec<f32> = (0..width * height)
            .map(|k| even[colour(k % width, k / width)])
            .collect();
        assert!(fill_in(&mosaic, width).iter().all(|pixel| *pixel == even));
    }

    #[test]
    fn a_ramp_of_grey_is_filled_in_exactly_inside() {
        let (width, height) = (8, 6);
        let level = |k: usize| (k % width) as f32 + 10.0 * (k / width) as f32;
        let mosaic: Vec<f32> = (0..width * height).map(level).collect();
        let picture = fill_in(&mosaic, width);
        for y in 1..height - 1 {
            for x in 1..width - 1 {
                assert_eq!(picture[y * width + x], [level(y * width + x); 3]);
            }
        }
    }
}
