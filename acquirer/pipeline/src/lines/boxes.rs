//! The derivative that finds lines, from sums over boxes.
//!
//! A box twice applied and a difference over as many pixels is the derivative of a quadratic spline, which comes
//! within a few percent of a Gaussian's of half that width (M. Unser, "Splines: a perfect fit", 1999), at a
//! few additions per pixel. The gain comes in whole steps, so that all sums are exact in whatever order.

/// The derivative of a line's profile over boxes of `side` pixels: with the line's own width it answers best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Boxes {
    /// Pixels in a box, 2 or more.
    pub(super) side: usize,
}

impl Boxes {
    /// For lines of this width, in pixels.
    pub(super) fn for_width(width_px: f64) -> Self {
        Self {
            side: (width_px.round() as usize).max(2),
        }
    }

    /// Pixels that a value of the derivative looks at, less one.
    pub(super) fn reach(self) -> usize {
        3 * self.side - 2
    }

    /// Pixels to be put before a row, so that its first derivative lies before its first pixel's centre.
    pub(super) fn pad(self) -> usize {
        self.reach().div_ceil(2)
    }

    /// Edge coordinate of the derivative that begins at pixel 0.
    pub(super) fn middle(self) -> f32 {
        0.5 * (self.reach() + 1) as f32
    }

    /// Variance of the smoothing kernel, in pixels squared: two discrete boxes and, by the difference, a third.
    pub(super) fn variance(self) -> f32 {
        let square = (self.side * self.side) as f32;
        (3.0 * square - 2.0) / 12.0
    }

    /// Sum of the weights of the smoothing kernel, difference included.
    pub(super) fn weight(self) -> f32 {
        (self.side * self.side * self.side) as f32
    }

    /// Weights with which noise enters the difference of two neighbouring derivatives, as a root sum of squares: boxes
    /// with the weights 1, -2 and 1, side by side.
    pub(super) fn noise(self) -> f32 {
        (6.0 * self.side as f32).sqrt()
    }
}

/// The sum of each value and the `side - 1` behind it; where there are not so many left, `out` stays as it is. It is as
/// long as `row`.
#[inline(always)]
pub(super) fn box_sums(row: &[f32], out: &mut [f32], side: usize) {
    match side {
        2 => box_sums_of::<2>(row, out),
        3 => box_sums_of::<3>(row, out),
        4 => box_sums_of::<4>(row, out),
        5 => box_sums_of::<5>(row, out),
        6 => box_sums_of::<6>(row, out),
        _ => {
            let mut sum: f32 = row.iter().take(side).sum();
            for k in 0..(row.len() + 1).saturating_sub(side) {
                out[k] = sum;
                sum += row.get(k + side).unwrap_or(&0.0) - row[k];
            }
        }
    }
}

#[inline(always)]
fn box_sums_of<const SIDE: usize>(row: &[f32], out: &mut [f32]) {
    let length = (row.len() + 1).saturating_sub(SIDE);
    let behind: [&[f32]; SIDE] = std::array::from_fn(|k| &row[k.min(row.len())..][..length]);
    for (at, sum) in out[..length].iter_mut().enumerate() {
        let mut total = behind[0][at];
        for other in &behind[1..] {
            total += other[at];
        }
        *sum = total;
    }
}

/// Columns that are looked at together, so that they stay in the first-level cache.
pub(super) const BLOCK: usize = 64;

/// The derivative down the columns of a picture [`BLOCK`] values wide, row after row.
///
/// Its second difference takes four rows only: the kernel is three boxes' differences, each of them twice summed up.
#[derive(Debug, Clone)]
pub(super) struct DownSlopes {
    before: [f32; BLOCK],
    after: [f32; BLOCK],
    /// From the next derivative to the one after it.
    growth: [f32; BLOCK],
}

impl Default for DownSlopes {
    fn default() -> Self {
        let zeros = [0.0; BLOCK];
        Self {
            before: zeros,
            after: zeros,
            growth: zeros,
        }
    }
}

impl DownSlopes {
    /// Stands on the derivative that begins in the first of these rows.
    #[inline(always)]
    pub(super) fn begin(&mut self, rows: &[f32], side: usize) {
        let row = |k: usize| &rows[k * BLOCK..][..BLOCK];
        self.after.fill(0.0);
        self.growth.fill(0.0);
        for k in 0..2 * side - 1 {
            let weight = (k + 1).min(2 * side - 1 - k) as f32;
            let pairs = row(k + side).iter().zip(row(k));
            for (slope, (more, less)) in self.after.iter_mut().zip(pairs) {
                *slope += weight * (more - less);
            }
        }
        for k in 0..side {
            let three = row(k).iter().zip(row(k + side)).zip(row(k + 2 * side));
            for (growth, ((a, b), c)) in self.growth.iter_mut().zip(three) {
                *growth += (a - b) + (c - b);
            }
        }
    }

    /// Goes one row down; `rows` begin where the derivative does that is left.
    #[inline(always)]
    pub(super) fn go_down(&mut self, rows: &[f32], side: usize) {
        std::mem::swap(&mut self.before, &mut self.after);
        let row = |k: usize| &rows[k * side * BLOCK..][..BLOCK];
        let (a, b, c, d) = (row(0), row(1), row(2), row(3));
        for k in 0..BLOCK {
            self.after[k] = self.before[k] + self.growth[k];
            self.growth[k] += (d[k] - a[k]) + 3.0 * (b[k] - c[k]);
        }
    }

    /// The derivative that was left, and the one below it.
    pub(super) fn before_and_after(&self) -> (&[f32], &[f32]) {
        (&self.before, &self.after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers without order.
    fn values(count: usize) -> Vec<f32> {
        (0..count).map(|k| (k * k * 7 % 31) as f32 - 15.0).collect()
    }

    #[test]
    fn the_derivative_is_the_same_along_and_down_for_boxes_of_any_length() {
        for side in 2..=9 {
            let row = values(60);
            let (mut once, mut twice) = (row.clone(), row.clone());
            box_sums(&row, &mut once, side);
            box_sums(&once, &mut twice, side);
            let sum: f32 = row[7..7 + side].iter().sum();
            assert_eq!(once[7], sum, "{side}");
            let slope = |k: usize| twice[k + side] - twice[k];
            let picture: Vec<f32> = row.iter().flat_map(|&v| [v; BLOCK]).collect();
            let mut down = DownSlopes::default();
            down.begin(&picture, side);
            for k in 0..row.len() - 3 * side {
                down.go_down(&picture[k * BLOCK..], side);
                let (before, after) = down.before_and_after();
                assert_eq!((before[5], after[63]), (slope(k), slope(k + 1)), "{side}");
            }
        }
    }

    #[test]
    fn the_derivative_of_a_line_falls_through_zero_on_its_middle() {
        for (middle, width) in [(20.0, 4.0), (20.3, 4.0), (19.85, 3.0), (21.45, 5.4)] {
            let boxes = Boxes::for_width(width);
            let (low, high) = (middle - 0.5 * width, middle + 0.5 * width);
            let covered = |k: usize| {
                let (from, to) = (low.max(k as f64), high.min(k as f64 + 1.0));
                (to - from).max(0.0) as f32
            };
            let profile: Vec<f32> = (0..44).map(covered).collect();
            let (mut once, mut row) = (profile.clone(), profile.clone());
            box_sums(&profile, &mut once, boxes.side);
            box_sums(&once, &mut row, boxes.side);
            let slope = |k: usize| row[k + boxes.side] - row[k];
            let at = (0..44 - boxes.reach() - 1)
                .find(|&k| slope(k) > 0.01 && slope(k + 1) <= 0.0)
                .unwrap();
            let share = slope(at) / (slope(at) - slope(at + 1));
            let found = f64::from(at as f32 + boxes.middle() + share);
            assert!((found - middle).abs() < 0.04, "{found} for {middle}");
        }
    }

    #[test]
    fn noise_passes_the_boxes_as_their_weights_say() {
        // side 2: boxes 1 1 twice over 1 -1, less the same two pixels on: 1 1 -2 -2 1 1
        let noise = Boxes { side: 2 }.noise();
        assert!((noise - 12.0_f32.sqrt()).abs() < 1e-6, "{noise}");
    }
}
