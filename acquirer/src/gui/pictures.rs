//! Pictures on the graphics card: each is handed over once, and let go when no panel shows it any more.

use std::{
    collections::HashMap,
    fmt,
    sync::{Arc, Weak},
};

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};

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
