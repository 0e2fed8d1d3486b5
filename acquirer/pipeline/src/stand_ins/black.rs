//! Light under black projection that was not captured: from the dark cells of the grids.

use super::{Grids, fill};
use crate::{
    channels::Channels, reference::ReferenceSettings, region::Region, response::Light,
    stale::StaleTiles, tiles::Tiles,
};

/// Share of a tile's pixels that lie in dark cells at least.
const DARK_SHARE: f64 = 0.25;

/// Black light for a frame's grids.
#[derive(Debug, Default)]
pub(super) struct Black {
    light: Option<Light>,
    /// Where it is not the captured one.
    patched: StaleTiles,
    dark: Tiles<3>,
}

impl Black {
    /// What was found last.
    pub(super) fn light(&self) -> Option<&Light> {
        self.light.as_ref()
    }

    /// Finds it; the list of regions is for passing notes.
    pub(super) fn find(
        &mut self,
        grids: &Grids<'_>,
        settings: &ReferenceSettings,
        regions: &mut Vec<Region>,
    ) -> &Light {
        let size = grids.size();
        let captured = grids.references.black.as_ref();
        let kept = self.light.take();
        let kept = kept.filter(|black| black.channels.size() == size);
        let black = kept.or_else(|| captured.cloned());
        let black = self.light.insert(black.unwrap_or_else(|| Light {
            channels: Channels::dark(size),
            clipped: Vec::new(),
            repeats: 1,
        }));
        if let Some(captured) = captured {
            self.patched.regions_without(grids.stale, size, regions);
            black.channels.copy(&captured.channels, regions);
        }
        grids.lacking(captured.is_some(), regions);
        self.dark.cover(size, settings.tile_px);
        let dark = (&mut self.dark, DARK_SHARE, |at| grids.least(at));
        fill(dark, regions, &mut black.channels, |levels| levels);
        self.patched.copy(grids.stale);
        black
    }
}
