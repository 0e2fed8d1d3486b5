//! What stands for black and white light where it was not captured, or where the scene has changed since.
//!
//! Takes the captures of the grids and the references, gives the light to read the grids by. Black is read from the
//! dark cells between the lines, tile by tile (their lower quartile). White is the strongest light around; or better,
//! for the coded grid, the unary grid's own light over its colour, if that has all three channels: lines then have
//! their own albedo and profile as reference. All of it stays in the same memory from frame to frame, and only those
//! parts are written whose light has no reference.

mod black;
mod white;

use image::RgbImage;

use super::{
    PipelineSettings, channels::Channels, line_light::LineLight, plane::Plane,
    reference::References, region::Region, response::Response, stale::StaleTiles, tiles::Tiles,
};
use black::Black;
use white::White;

/// The captures of the grids of one frame, and what there is to read them by.
#[derive(Clone, Copy)]
pub(super) struct Grids<'a> {
    pub(super) coded: &'a [RgbImage],
    /// May be empty.
    pub(super) unary: &'a [RgbImage],
    /// Linear light of the unary grid's colour.
    pub(super) unary_colour: [f32; 3],
    pub(super) response: &'a Response,
    pub(super) references: &'a References,
    /// Where the references do not hold; nowhere without black.
    pub(super) stale: &'a StaleTiles,
}

impl<'a> Grids<'a> {
    fn size(&self) -> (usize, usize) {
        let first = self.coded.first();
        first.map_or((0, 0), |frame| {
            (frame.width() as usize, frame.height() as usize)
        })
    }

    /// Whether light must be found that no reference gives.
    fn lack_references(&self) -> bool {
        self.references.black.is_none() || self.references.white.is_none() || self.stale.any()
    }

    /// The parts whose light must be found: all of it if it was not captured.
    fn lacking(&self, captured: bool, regions: &mut Vec<Region>) {
        if captured {
            let none = StaleTiles::default();
            self.stale.regions_without(&none, self.size(), regions);
        } else {
            regions.clear();
            regions.push(Region::whole(self.size()));
        }
    }

    /// The least light of a pixel in any of the grids.
    fn least(&self, at: usize) -> [f32; 3] {
        let light = |frames| self.response.light_at(frames, at);
        let mut least = light(self.coded).map(|light| light.min(1.0)); // clipped
        if !self.unary.is_empty() {
            let other = light(self.unary);
            least = [0, 1, 2].map(|c| least[c].min(other[c]));
        }
        least
    }

    /// Whether the unary grid's light is a grid's white.
    fn unary_is_white_of(&self, kind: GridKind) -> bool {
        const LEAST: f32 = 0.15; // of full light in each channel, for a usable signal
        kind == GridKind::Coded
            && !self.unary.is_empty()
            && self.unary_colour.iter().all(|&share| share >= LEAST)
    }

    fn captures(&self, kind: GridKind) -> (&'a [RgbImage], &'a Response) {
        let frames = match kind {
            GridKind::Coded => self.coded,
            GridKind::Unary => self.unary,
        };
        (frames, self.response)
    }
}

/// Which of the two grids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GridKind {
    Coded,
    Unary,
}

/// Black and white light for a frame's grids.
#[derive(Debug, Default)]
pub(super) struct StandIns {
    black: Black,
    coded: White,
    unary: White,
    regions: Vec<Region>,
}

impl StandIns {
    /// Finds the light for a frame's grids.
    pub(super) fn find(&mut self, grids: &Grids<'_>, settings: &PipelineSettings) {
        if !grids.lack_references() {
            return;
        }
        let regions = &mut self.regions;
        let black = self.black.find(grids, &settings.reference, regions);
        for (kind, white) in [
            (GridKind::Coded, &mut self.coded),
            (GridKind::Unary, &mut self.unary),
        ] {
            if !grids.captures(kind).0.is_empty() {
                white.find((grids, kind), black, &settings.gain, regions);
            }
        }
    }

    /// The captures of one of the grids beside the light that was found for them; `None` if there are none.
    pub(super) fn light<'a>(&'a self, grids: &Grids<'a>, kind: GridKind) -> Option<LineLight<'a>> {
        let (frames, response) = grids.captures(kind);
        if frames.is_empty() {
            return None;
        }
        let references = grids.references;
        if !grids.lack_references() {
            return LineLight::new((frames, response), references);
        }
        let white = match kind {
            GridKind::Coded => &self.coded,
            GridKind::Unary => &self.unary,
        };
        Some(LineLight {
            frames,
            response,
            black: self.black.light()?,
            white: white.light()?,
            clipped: &references.clipped,
            white_is_measured: references.white.is_some() || grids.unary_is_white_of(kind),
            noise: references.noise,
            levels: white.levels(),
        })
    }
}

/// Writes what `light` makes of the tiles' levels: of the quantile `share` of each tile's samples.
fn fill<const N: usize>(
    (tiles, share, sample): (&mut Tiles<N>, f64, impl Fn(usize) -> [f32; N]),
    regions: &[Region],
    channels: &mut Channels,
    light: impl Fn([f32; N]) -> [f32; 3],
) {
    let (width, _) = channels.size();
    for region in regions {
        tiles.find(region, share, |x, y| sample(y * width + x));
    }
    channels.write(regions, |planes, region| {
        for y in region.rows.clone() {
            tiles.row(y, region.columns.clone(), |x, levels| {
                set(planes, y * width + x, light(levels));
            });
        }
    });
}

fn set(planes: &mut [Plane; 3], at: usize, values: [f32; 3]) {
    for (plane, value) in planes.iter_mut().zip(values) {
        plane.values_mut()[at] = value;
    }
}
