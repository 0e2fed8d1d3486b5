//! Pictures on the graphics card: each is handed over once, and let go when no panel shows it any more.

use std::{
    collections::HashMap,
    fmt,
    sync::{Arc, Weak},
};

use eframe::egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};

struct Held {
    image: Weak<ColorImage>,
    /// How often it was halved.
    halvings: u32,
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
        self.reduced(context, name, image, 1.0)
    }

    /// The same of a picture that is shown at `scale` screen pixels for each of its own: it is halved until no pixel
    /// would be left out, so that thin lines stay lines.
    pub(super) fn reduced(
        &mut self,
        context: &Context,
        name: &str,
        image: &Arc<ColorImage>,
        scale: f32,
    ) -> TextureHandle {
        let halvings = (1.0 / scale.clamp(0.01, 1.0)).log2().round() as u32;
        let small = || (0..halvings).fold(image.clone(), |image, _| Arc::new(halved(&image)));
        let options = TextureOptions::LINEAR;
        let held = self.0.entry(name.to_owned()).or_insert_with(|| Held {
            image: Arc::downgrade(image),
            halvings,
            texture: context.load_texture(name, small(), options),
            used: true,
        });
        held.used = true;
        if held.image.as_ptr() != Arc::as_ptr(image) || held.halvings != halvings {
            held.image = Arc::downgrade(image);
            held.halvings = halvings;
            held.texture.set(small(), options);
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
