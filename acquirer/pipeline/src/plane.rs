//! One number per camera pixel, row by row in a flat buffer: what the pixel stages pass on.
//!
//! Positions are edge coordinates, so the value of pixel (x, y) stands at (x + 1/2, y + 1/2).

/// A picture of one `f32` per pixel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plane {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Plane {
    /// A picture with the same value everywhere.
    #[must_use]
    pub fn filled(width: usize, height: usize, value: f32) -> Self {
        Self {
            width,
            height,
            values: vec![value; width * height],
        }
    }

    /// Makes it another size, in the same memory where that is enough; what it held is of no use any more.
    pub fn resize(&mut self, width: usize, height: usize) {
        (self.width, self.height) = (width, height);
        self.values.resize(width * height, 0.0);
    }

    /// Pixels in a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values, row by row: width x height.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// All values, row by row, to be written.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// One row; the last one for a larger `y`, empty for a picture without pixels.
    #[must_use]
    pub fn row(&self, y: usize) -> &[f32] {
        let y = y.min(self.height.saturating_sub(1));
        &self.values[y * self.width..((y + 1) * self.width).min(self.values.len())]
    }

    /// The value at an edge-coordinate position, bilinear between pixel centres; beyond the border the
    /// border's value holds. 0 for a picture without pixels.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> f32 {
        if self.values.is_empty() {
            return 0.0;
        }
        let (x0, fx) = split(x, self.width);
        let (y0, fy) = split(y, self.height);
        let (x1, y1) = ((x0 + 1).min(self.width - 1), (y0 + 1).min(self.height - 1));
        let (upper, lower) = (y0 * self.width, y1 * self.width);
        let v = &self.values;
        let top = v[upper + x0] + fx * (v[upper + x1] - v[upper + x0]);
        let bottom = v[lower + x0] + fx * (v[lower + x1] - v[lower + x0]);
        top + fy * (bottom - top)
    }
}

/// Pixel whose centre lies at or before a position, and the way to the next one, 0 to 1.
fn split(position: f64, length: usize) -> (usize, f32) {
    let from_first = (position - 0.5).clamp(0.0, (length - 1) as f64);
    let whole = from_first as usize; // truncates towards zero; NaN gives 0
    (whole.min(length - 1), (from_first - whole as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_at_pixel_centres_and_the_border_goes_on() {
        let mut plane = Plane::filled(3, 2, 0.0);
        plane
            .values_mut()
            .copy_from_slice(&[0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
        assert_eq!(plane.at(1.5, 0.5), 1.0);
        assert_eq!(plane.at(2.0, 1.0), 6.5);
        assert_eq!(plane.at(-5.0, 99.0), 10.0);
        assert_eq!(Plane::default().at(1.0, 1.0), 0.0);
    }
}
