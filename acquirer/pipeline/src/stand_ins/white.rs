//! White light that was not captured: the strongest light around, or the unary grid's own.

use image::RgbImage;

use super::{GridKind, Grids, fill, set};
use crate::{
    channels::Channels,
    gain::GainSettings,
    levels::Level,
    reference::NoiseLaw,
    region::Region,
    response::{CLIPPED_LIGHT, Light, Response},
    stale::StaleTiles,
    tiles::Tiles,
};

/// Share of a tile's pixels that are darker than the strongest lines there.
const LINE_SHARE: f64 = 0.97;

/// White light for one grid of a frame.
#[derive(Debug, Default)]
pub(super) struct White {
    light: Option<Channels>,
    levels: Vec<Level>,
    /// Where they are not the captured ones.
    patched: StaleTiles,
    strongest: Tiles<1>,
}

impl White {
    /// What was found last, over black.
    pub(super) fn light(&self) -> Option<&Channels> {
        self.light.as_ref()
    }

    /// Black and white side by side; empty where one of them was not captured.
    pub(super) fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Finds it for one of the grids over its black; the list of regions is for passing notes.
    pub(super) fn find(
        &mut self,
        (grids, kind): (&Grids<'_>, GridKind),
        black: &Light,
        settings: &GainSettings,
        regions: &mut Vec<Region>,
    ) {
        let (size, references) = (grids.size(), grids.references);
        let captured = references.white.as_ref();
        let kept = self.light.take().filter(|white| white.size() == size);
        let white = kept.or_else(|| captured.cloned());
        let white = self
            .light
            .insert(white.unwrap_or_else(|| Channels::dark(size)));
        if self.levels.len() != references.levels.len() {
            self.levels.clone_from(&references.levels);
        }
        if let Some(captured) = captured {
            self.patched.regions_without(grids.stale, size, regions);
            white.copy(captured, regions);
            for at in regions.iter().flat_map(|region| region.pixels(size.0)) {
                if let Some(level) = self.levels.get_mut(at) {
                    *level = references.levels[at];
                }
            }
        }
        grids.lacking(captured.is_some(), regions);
        if grids.unary_is_white_of(kind) {
            let unary = OverBlack::new((grids, GridKind::Unary), black);
            fill_from_unary((&unary, grids.unary_colour), regions, white);
        } else {
            let over_black = OverBlack::new((grids, kind), black);
            self.strongest.cover(size, settings.tile_px);
            let sample = |at| [over_black.strongest(at)];
            let least = least_light(&references.noise);
            let strongest = (&mut self.strongest, LINE_SHARE, sample);
            fill(strongest, regions, white, |[level]| [level.max(least); 3]);
        }
        for at in regions.iter().flat_map(|region| region.pixels(size.0)) {
            if let Some(level) = self.levels.get_mut(at) {
                let (black, white) = (black.channels.at(at), white.at(at));
                *level = Level::new(black, white, references.clipped[at]);
            }
        }
        self.patched.copy(grids.stale);
    }
}

/// The unary grid's light over its colour's share of white.
fn fill_from_unary(
    (unary, colour): (&OverBlack<'_>, [f32; 3]),
    regions: &[Region],
    white: &mut Channels,
) {
    let (width, _) = white.size();
    let of_white = colour.map(|share| 1.0 / share);
    white.write(regions, |planes, region| {
        for at in region.pixels(width) {
            let light = unary.at(at);
            let whites = [0, 1, 2].map(|c| (light[c].unwrap_or(0.0) * of_white[c]).max(0.0));
            set(planes, at, whites);
        }
    });
}

/// Least light that counts as a line's: well above noise.
fn least_light(noise: &NoiseLaw) -> f32 {
    4.0 * noise.floor.iter().copied().fold(0.0, f32::max).sqrt()
}

/// The light of a grid above black.
struct OverBlack<'a> {
    frames: &'a [RgbImage],
    response: &'a Response,
    black: &'a Channels,
}

impl<'a> OverBlack<'a> {
    fn new((grids, kind): (&Grids<'a>, GridKind), black: &'a Light) -> Self {
        let (frames, response) = grids.captures(kind);
        Self {
            frames,
            response,
            black: &black.channels,
        }
    }

    /// Each channel's light above black, unless it was clipped.
    fn at(&self, at: usize) -> [Option<f32>; 3] {
        let (light, black) = (self.response.light_at(self.frames, at), self.black.at(at));
        [0, 1, 2].map(|c| (light[c] < CLIPPED_LIGHT).then(|| light[c] - black[c]))
    }

    /// The strongest channel's light above black, at most full light.
    fn strongest(&self, at: usize) -> f32 {
        let light = self
            .at(at)
            .into_iter()
            .map(|light| light.unwrap_or(1.0).min(1.0));
        light.fold(f32::MIN, f32::max)
    }
}
