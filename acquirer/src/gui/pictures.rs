//! Pictures on the graphics card: each is handed over once, and let go when no panel shows it any more.

use std::{
    collections::HashMap,
    fmt,
    sync::{Arc, Weak},
};

use eframe::egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};

/// A picture is halved until it is no wider than this, in pixels.
const SMALLEST: usize = 240;

/// A picture in its own size and in smaller ones, each half as wide and high as the one before. They are made by the
/// thread that reads the picture, so that the window's own only hands one of them over.
#[derive(Debug, Clone)]
pub(super) struct ScaledPicture(Vec<Arc<ColorImage>>);

impl ScaledPicture {
    /// Makes the smaller ones.
    pub(super) fn of(image: Arc<ColorImage>) -> Self {
        let mut sizes = vec![image];
        while let Some(last) = sizes.last().filter(|last| last.width() > SMALLEST) {
            let half = Arc::new(halved(last));
            sizes.push(half);
        }
        Self(sizes)
    }

    /// The picture in its own size.
    pub(super) fn whole(&self) -> &Arc<ColorImage> {
        &self.0[0]
    }

    /// The one to be shown at `scale` screen pixels for each pixel of the whole: no pixel of it is left out, so that
    /// thin lines stay lines.
    pub(super) fn at(&self, scale: f32) -> &Arc<ColorImage> {
        let halvings = (1.0 / scale.clamp(0.01, 1.0)).log2().round() as usize;
        &self.0[halvings.min(self.0.len() - 1)]
    }
}

struct Held {
    image: Weak<ColorImage>,
    texture: TextureHandle,
    used: bool,
}

/// The pictures that are shown, by what they are shown as.
#[derive(Default)]
pub(super) struct Pictures(HashMap<String, Held>);

impl fmt::Debug for Pictures {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_set().entries(self.0.keys()).finish()
    }
}

impl Pictures {
    /// The texture of a picture that is shown under this name; it is handed over when it is another one than before.
    pub(super) fn texture(
        &mut self,
        context: &Context,
        name: &str,
        image: &Arc<ColorImage>,
    ) -> TextureHandle {
        let options = TextureOptions::LINEAR;
        let held = self.0.entry(name.to_owned()).or_insert_with(|| Held {
            image: Arc::downgrade(image),
            texture: context.load_texture(name, image.clone(), options),
            used: true,
        });
        held.used = true;
        if held.image.as_ptr() != Arc::as_ptr(image) {
            held.image = Arc::downgrade(image);
            held.texture.set(image.clone(), options);
        }
        held.texture.clone()
    }

    /// Lets go of what was not shown since the last call.
    pub(super) fn forget_unused(&mut self) {
        self.0.retain(|_, held| std::mem::take(&mut held.used));
    }
}

/// Half as wide and high: each pixel is the brightest of four in every channel, for what is seen on these pictures are
/// thin lines on black.
fn halved(image: &ColorImage) -> ColorImage {
    let [width, height] = image.size;
    let size = [(width / 2).max(1), (height / 2).max(1)];
    let brightest = |x: usize, y: usize| {
        let at = |dx: usize, dy: usize| {
            let (x, y) = ((2 * x + dx).min(width - 1), (2 * y + dy).min(height - 1));
            image.pixels[y * width + x].to_array()
        };
        let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let most = |k: usize| four.iter().map(|pixel| pixel[k]).max();
        let [r, g, b, a] = std::array::from_fn(|k| most(k).unwrap_or_default());
        Color32::from_rgba_premultiplied(r, g, b, a)
    };
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| brightest(x, y)));
    ColorImage::new(size, pixels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thin_lines_are_still_there_in_the_small_picture() {
        let mut image = ColorImage::filled([1000, 500], Color32::BLACK);
        for y in 0..500 {
            image.pixels[y * 1000 + 501] = Color32::RED;
        }
        let picture = ScaledPicture::of(Arc::new(image));
        assert_eq!(picture.at(1.0).size, picture.whole().size);
        let small = picture.at(0.25);
        assert_eq!(small.size, [250, 125]);
        let red = |y: usize| (0..250).any(|x| small.pixels[y * 250 + x] == Color32::RED);
        assert!((0..125).all(red));
        assert!(picture.at(0.0).width() >= SMALLEST / 2);
    }
}
