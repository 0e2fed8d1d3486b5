//! Edges of the recovered grid by the Sobel operator (thesis, chapter 4.4.1).
//!
//! Takes the light of the recovered grid (0 off it), gives the edge map: pixels where the gradient's magnitude
//! exceeds a threshold and is greatest across the edge. Its direction tells which side of a stripe an edge
//! is: dark to bright rightwards is the left side of a column, and so on. Positions are whole pixels. An
//! edge lies on the dark side of the stripe's soft flank as often as on the bright one, so stripes of few
//! pixels come out up to a pixel too wide, quietly.

use rayon::prelude::*;

use super::threshold::RecoveredGrid;

/// Which side of a stripe an edge pixel lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Side {
    /// Left side of a column.
    Left,
    /// Right side of a column.
    Right,
    /// Upper side of a row.
    Upper,
    /// Lower side of a row.
    Lower,
}

impl Side {
    /// Whether it belongs to a column, and so runs downwards.
    pub(crate) fn is_of_column(self) -> bool {
        matches!(self, Self::Left | Self::Right)
    }
}

/// The edge map.
#[derive(Debug, Clone)]
pub(crate) struct EdgeMap {
    /// Width of the picture in pixels.
    pub width: usize,
    /// Row by row; `None` off the edges.
    pub sides: Vec<Option<Side>>,
}

/// The edges of the grid; `None` for the pixels on the picture's border.
pub(crate) fn find_edges(grid: &RecoveredGrid, width: usize) -> EdgeMap {
    // a step as high as the mask's threshold has a gradient of 4 thresholds; half of that marks its middle
    let threshold = 2.0 * grid.threshold;
    let gradients: Vec<[f32; 2]> = (0..grid.light.len())
        .into_par_iter()
        .map(|at| gradient(&grid.light, width, at))
        .collect();
    let magnitude: Vec<f32> = gradients
        .iter()
        .map(|[down, right]| down.hypot(*right))
        .collect();
    let side = |at: usize| {
        if magnitude[at] <= threshold {
            return None;
        }
        let side = side_of(gradients[at]);
        let step = if side.is_of_column() { 1 } else { width };
        // of two equal neighbours the first counts
        let is_crest =
            magnitude[at] > magnitude[at - step] && magnitude[at] >= magnitude[at + step];
        is_crest.then_some(side)
    };
    let sides = (0..magnitude.len()).into_par_iter().map(side).collect();
    EdgeMap { width, sides }
}

fn side_of([down, right]: [f32; 2]) -> Side {
    if right.abs() >= down.abs() {
        if right > 0.0 { Side::Left } else { Side::Right }
    } else if down > 0.0 {
        Side::Upper
    } else {
        Side::Lower
    }
}

/// The answers of the row mask H1 and the column mask H2: how much brighter it gets downwards and to the
/// right. Zero on the picture's border.
fn gradient(light: &[f32], width: usize, at: usize) -> [f32; 2] {
    let (x, height) = (at % width, light.len() / width);
    let y = at / width;
    if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
        return [0.0; 2];
    }
    let above = &light[at - width - 1..at - width + 2];
    let level = &light[at - 1..at + 2];
    let below = &light[at + width - 1..at + width + 2];
    let down = (below[0] + 2.0 * below[1] + below[2]) - (above[0] + 2.0 * above[1] + above[2]);
    let right = (above[2] + 2.0 * level[2] + below[2]) - (above[0] + 2.0 * level[0] + below[0]);
    [down, right]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_a_left_and_a_right_side_and_a_row_an_upper_and_a_lower_one() {
        let light = |x: usize, y: usize| {
            if (10..16).contains(&x) || (20..26).contains(&y) {
                100.0
            } else {
                0.0
            }
        };
        let grid = RecoveredGrid {
            light: (0..40 * 40).map(|at| light(at % 40, at / 40)).collect(),
            count: 444,
            threshold: 40.0,
        };
        let edges = find_edges(&grid, 40);
        let row_of_column: Vec<_> = (0..40)
            .filter_map(|x| edges.sides[5 * 40 + x].map(|s| (x, s)))
            .collect();
        assert_eq!(row_of_column, [(9, Side::Left), (15, Side::Right)]);
        let column_of_row: Vec<_> = (0..40)
            .filter_map(|y| edges.sides[y * 40 + 30].map(|s| (y, s)))
            .collect();
        assert_eq!(column_of_row, [(19, Side::Upper), (25, Side::Lower)]);
        assert_eq!(edges.sides[23 * 40 + 13], None);
    }

    #[test]
    fn pictures_of_one_pixel_or_one_line_have_no_edges() {
        for (count, width) in [(1, 1), (9, 9), (9, 1), (4, 2)] {
            let grid = RecoveredGrid {
                light: vec![9.0; count],
                count,
                threshold: 1.0,
            };
            assert!(find_edges(&grid, width).sides.iter().all(Option::is_none));
        }
    }
}
