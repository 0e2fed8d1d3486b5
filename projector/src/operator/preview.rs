//! The picture on the wall made small, true in its colours, in a thread of its own.
//!
//! Takes a pattern and a raster size, gives a picture of another size. Every pixel is the average light of the area it
//! stands for (in linear light, as an eye far away sees it), so a line thinner than a pixel stays visible: one pixel
//! in eight is still drawn at two fifths of its drive value. Nothing waits for the thread; a newer picture replaces
//! one that was not taken up.

use std::{
    io,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread,
};

use shared::pattern::{Pattern, Raster, RasterSize, Rgb};

/// What is to be made small.
#[derive(Debug, Clone, PartialEq)]
pub struct Original {
    /// The pattern.
    pub pattern: Pattern,
    /// The raster it is shown in.
    pub raster: RasterSize,
    /// The size wanted, in pixels.
    pub size: RasterSize,
}

#[derive(Debug, Default)]
struct Slot {
    wanted: Option<Original>,
    made: Option<Raster>,
    end: bool,
}

/// The thread that makes previews.
#[derive(Debug)]
pub struct PreviewMaker {
    slot: Arc<(Mutex<Slot>, Condvar)>,
    asked: Option<Original>,
}

impl PreviewMaker {
    /// Starts the thread; `ready` is called whenever a preview can be taken.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn start(ready: impl Fn() + Send + 'static) -> io::Result<Self> {
        let slot = Arc::new((Mutex::new(Slot::default()), Condvar::new()));
        let theirs = slot.clone();
        thread::Builder::new()
            .name("preview".to_owned())
            .spawn(move || {
                while let Some(original) = next(&theirs) {
                    let picture = small(&original);
                    lock(&theirs.0).made = Some(picture);
                    ready();
                }
            })?;
        Ok(Self { slot, asked: None })
    }

    /// Asks for a preview, unless it is the one asked for last.
    pub fn ask(&mut self, original: Original) {
        if self.asked.as_ref() == Some(&original) {
            return;
        }
        lock(&self.slot.0).wanted = Some(original.clone());
        self.slot.1.notify_all();
        self.asked = Some(original);
    }

    /// The newest preview, if one was made since the last call.
    #[must_use]
    pub fn take(&self) -> Option<Raster> {
        lock(&self.slot.0).made.take()
    }
}

impl Drop for PreviewMaker {
    fn drop(&mut self) {
        lock(&self.slot.0).end = true;
        self.slot.1.notify_all();
    }
}

/// The next picture to make small; `None` at the end.
fn next((slot, changed): &(Mutex<Slot>, Condvar)) -> Option<Original> {
    let nothing = |slot: &mut Slot| slot.wanted.is_none() && !slot.end;
    let mut slot = changed
        .wait_while(lock(slot), nothing)
        .unwrap_or_else(PoisonError::into_inner);
    if slot.end { None } else { slot.wanted.take() }
}

fn lock(slot: &Mutex<Slot>) -> MutexGuard<'_, Slot> {
    // Each assignment leaves the slot valid.
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The picture in the size wanted.
#[must_use]
pub fn small(original: &Original) -> Raster {
    scaled(&original.pattern.raster(original.raster), original.size)
}

/// A picture in another size: each pixel is the average light of the area it covers.
#[must_use]
pub fn scaled(picture: &Raster, size: RasterSize) -> Raster {
    let from = picture.size();
    let light: Vec<f32> = (0..=255)
        .map(|value| linear(value as f32 / 255.0))
        .collect();
    let columns = shares(from.width, size.width);
    let rows = shares(from.height, size.height);
    let stride = 3 * from.width as usize;
    let across = |row: usize| -> Vec<f32> {
        let bytes = &picture.bytes()[row * stride..(row + 1) * stride];
        let mut sums = Vec::with_capacity(3 * columns.len());
        for parts in &columns {
            for channel in 0..3 {
                let light_of =
                    |&(k, share): &(usize, f32)| light[usize::from(bytes[3 * k + channel])] * share;
                sums.push(parts.iter().map(light_of).sum::<f32>());
            }
        }
        sums
    };
    let mut bytes = Vec::with_capacity(3 * size.pixels());
    let mut known: Option<(usize, Vec<f32>)> = None;
    for parts in &rows {
        let mut sums = vec![0.0; 3 * columns.len()];
        for &(row, share) in parts {
            if known.as_ref().is_none_or(|(k, _)| *k != row) {
                known = Some((row, across(row)));
            }
            let line = known.as_ref().map_or(&[][..], |(_, line)| line);
            for (sum, value) in sums.iter_mut().zip(line) {
                *sum += share * value;
            }
        }
        bytes.extend(sums.iter().map(|&light| drive(light)));
    }
    Raster::from_fn(size, |x, y| {
        let at = 3 * (y as usize * size.width as usize + x as usize);
        Rgb([bytes[at], bytes[at + 1], bytes[at + 2]])
    })
}

/// For each of `to` pixels: which of `from` pixels it covers, and how much of it each is.
fn shares(from: u32, to: u32) -> Vec<Vec<(usize, f32)>> {
    let scale = f64::from(from) / f64::from(to.max(1));
    let covered = |k: u32| {
        let (start, end) = (f64::from(k) * scale, f64::from(k + 1) * scale);
        let last = (end.ceil() as u32).clamp(1, from);
        let part = |p: u32| {
            let overlap = end.min(f64::from(p + 1)) - start.max(f64::from(p));
            (p as usize, (overlap / scale) as f32)
        };
        ((start as u32).min(from - 1)..last)
            .map(part)
            .filter(|(_, share)| *share > 1e-6)
            .collect()
    };
    (0..to).map(covered).collect()
}

/// Light of a drive value, both from 0 to 1, by the sRGB curve: what the operator's monitor does.
fn linear(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

fn drive(light: f32) -> u8 {
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use shared::pattern::{Grid, Pattern, RasterSize, Rgb};

    use super::{Original, PreviewMaker, scaled, small};

    const XGA: RasterSize = RasterSize {
        width: 1024,
        height: 768,
    };

    fn original(pattern: Pattern, width: u32, height: u32) -> Original {
        let size = RasterSize { width, height };
        Original {
            pattern,
            raster: XGA,
            size,
        }
    }

    #[test]
    fn a_picture_of_one_colour_keeps_it_in_every_size() {
        let colour = Rgb([255, 128, 1]);
        for (width, height) in [(1, 1), (333, 250), (1024, 768), (1500, 900)] {
            let preview = small(&original(Pattern::Solid { colour }, width, height));
            assert_eq!(preview.size(), RasterSize { width, height });
            assert!(
                preview.bytes().chunks(3).all(|pixel| pixel == colour.0),
                "{width}x{height}"
            );
        }
    }

    #[test]
    fn in_its_own_size_a_picture_is_itself() {
        let card = Pattern::TestCard.raster(XGA);
        assert_eq!(scaled(&card, XGA), card);
    }

    #[test]
    fn lines_of_one_pixel_stay_visible_and_keep_their_hue() {
        let red = Rgb([255, 0, 0]);
        let grid = Grid::coded(15, 15, 1, 1, &[red]).unwrap();
        let preview = small(&original(grid.into(), 256, 192));
        for y in 0..192 {
            let brightest = (0..256)
                .map(|x| preview.pixel(x, y))
                .max_by_key(|Rgb([r, ..])| *r);
            let Some(Rgb([r, g, b])) = brightest else {
                panic!("a line of pixels")
            };
            assert!(r > 120 && g == 0 && b == 0, "{r} {g} {b} in line {y}");
        }
    }

    #[test]
    fn the_thread_makes_the_last_picture_asked_for() {
        let (ready, made) = std::sync::mpsc::channel();
        let mut maker = PreviewMaker::start(move || ready.send(()).unwrap()).unwrap();
        maker.ask(original(Pattern::BLACK, 8, 6));
        maker.ask(original(Pattern::WHITE, 8, 6));
        let white = small(&original(Pattern::WHITE, 8, 6));
        loop {
            made.recv().unwrap();
            if maker.take() == Some(white.clone()) {
                break;
            }
        }
    }
}
