//! What a projector's or a computer's scaler makes of a picture: another size, a keystone correction.
//!
//! Takes a raster of bytes, gives one of the same size that holds it smaller, larger or as a trapezium, black around
//! it. As scalers do, it mixes the bytes of the four nearest pixels, not their light.

use super::scene::FaultsTable;
use crate::pattern::{Raster, Rgb};

/// A scaler and its settings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaler {
    scale: [f64; 2],
    keystone: f64,
}

impl Scaler {
    /// The scaler of a scene; `None` when each pixel stays what it is.
    pub(super) fn new(faults: &FaultsTable) -> Option<Self> {
        let scaler = Self {
            scale: faults.picture_scale,
            keystone: faults.keystone,
        };
        (scaler.scale != [1.0, 1.0] || scaler.keystone != 0.0).then_some(scaler)
    }

    pub(super) fn apply(self, picture: &Raster) -> Raster {
        let size = picture.size();
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        Raster::from_fn(size, |x, y| {
            let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let narrowed = self.scale[0] * (1.0 - self.keystone * (1.0 - y / height));
            let from = |v: f64, length: f64, scale: f64| length / 2.0 + (v - length / 2.0) / scale;
            sample(
                picture,
                from(x, width, narrowed),
                from(y, height, self.scale[1]),
            )
        })
    }
}

/// The mean of the four pixels around an edge-coordinate position by nearness; beyond the border it is black.
fn sample(picture: &Raster, x: f64, y: f64) -> Rgb {
    let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
    let (u, v) = (x - 0.5 - left, y - 0.5 - top);
    let at = |dx: f64, dy: f64| {
        let (x, y) = (left + dx, top + dy);
        if x < 0.0 || y < 0.0 {
            return [0.0; 3];
        }
        picture.pixel(x as u32, y as u32).0.map(f64::from)
    };
    let (a, b, c, d) = (at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0));
    Rgb([0, 1, 2].map(|k| {
        let upper = a[k] * (1.0 - u) + b[k] * u;
        let lower = c[k] * (1.0 - u) + d[k] * u;
        (upper * (1.0 - v) + lower * v).round() as u8
    }))
}
