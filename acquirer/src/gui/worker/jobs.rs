//! The jobs of the rig's thread, one function each.

use std::path::Path;

use anyhow::Context;
use shared::{
    pattern::{Palette, Rgb},
    protocol::View,
    stage::Stage,
};

use super::{RigWorker, Session};
use crate::{
    gui::events::{Event, Job, Who},
    scan::{CaptureEntry, FINER_KEY, ScanFolder, fresh_folder},
    session::{
        ColourTrialOrder, NewScan, Progress, Rig, apply_selection, measure_latency, projected,
        record_stage, recording_warnings, try_colours,
    },
};

/// How long the projector says which one it is, in seconds.
const IDENTIFY_S: u32 = 5;

impl RigWorker {
    pub(super) fn job(
        &self,
        job: &Job,
        rig: &mut Rig,
        session: &mut Session,
    ) -> anyhow::Result<()> {
        if matches!(job, Job::PickColours { .. } | Job::Record(_)) {
            self.need_latency(rig)?;
        }
        match *job {
            Job::PickColours { apply } => {
                self.pick_colours(apply, rig, session)?;
                show_grid(rig)
            }
            Job::ApplyColours(best, unary) => {
                self.apply_colours((best, unary), rig, session)?;
                show_grid(rig)
            }
            Job::Record(stage) => {
                self.record(stage, rig, session)?;
                show_grid(rig)
            }
            Job::NextObject => self.next_object(session),
            Job::NewScan => {
                session.folder = None;
                self.teller.tell(Event::NewScan);
                Ok(())
            }
            Job::Identify => Ok(rig.projector.identify(IDENTIFY_S).map(drop)?),
            // these two are taken over before
            Job::Open(_) | Job::ReadLive(_) => Ok(()),
        }
    }

    pub(super) fn progress(&self, progress: Progress) {
        self.teller.tell(Event::Progress(Who::Rig, progress));
    }

    pub(super) fn need_latency(&self, rig: &mut Rig) -> anyhow::Result<()> {
        if rig.latency.is_none() {
            let mut report = |p| self.progress(p);
            let latency = measure_latency(rig, &self.config.latency, &self.cancel, &mut report)?;
            self.teller.tell(Event::Latency(latency));
        }
        Ok(())
    }

    fn pick_colours(
        &self,
        apply: bool,
        rig: &mut Rig,
        session: &mut Session,
    ) -> anyhow::Result<()> {
        let now = projected(rig)?;
        let palette = Palette::default();
        let order = ColourTrialOrder {
            palette: &palette,
            projected: &now,
            current: now.pattern.coded.colours().try_into().ok(),
        };
        let mut report = |p| self.progress(p);
        let mut measured = |so_far| self.teller.tell(Event::ColoursSoFar(Box::new(so_far)));
        let tried = try_colours(rig, &order, &self.cancel, &mut report, Some(&mut measured))?;
        if apply {
            apply_selection(rig, &tried.selection)?;
            // captures in other colours do not belong to this scan any more
            session.folder = None;
        }
        session.selection = Some(tried.selection.clone());
        self.teller
            .tell(Event::Colours(Box::new(tried.selection), apply));
        Ok(())
    }

    fn apply_colours(
        &self,
        (best, unary): ([Rgb; 4], Rgb),
        rig: &mut Rig,
        session: &mut Session,
    ) -> anyhow::Result<()> {
        match session.selection.as_mut() {
            Some(selection) => {
                if (selection.best, selection.unary) != (best, unary) {
                    if let Some(set) = selection.set_of(best) {
                        selection.expected_error = set.expected_error;
                    }
                    (selection.best, selection.unary) = (best, unary);
                    let by_hand = "The operator chose these colours by hand.".to_owned();
                    selection.reasons = vec![by_hand];
                }
                apply_selection(rig, selection)?;
            }
            None => {
                rig.projector.set_colours(&best, unary)?;
            }
        }
        session.folder = None;
        self.teller.tell(Event::NewScan);
        let palette = Palette::default();
        let names = best.map(|colour| palette.name_of(colour));
        let told = format!("the grid is drawn in {}", names.join(", "));
        self.teller.tell(Event::Note(told));
        Ok(())
    }

    fn record(&self, stage: Stage, rig: &mut Rig, session: &mut Session) -> anyhow::Result<()> {
        let of_another_grid = |folder: &ScanFolder, rig: &Rig| {
            projected(rig).is_ok_and(|now| now.pattern != folder.manifest().pattern)
        };
        // somebody at the projector may have changed the grid meanwhile
        if stage == Stage::Background
            && session
                .folder
                .as_ref()
                .is_some_and(|f| of_another_grid(f, rig))
        {
            session.folder = None;
        }
        let mut folder = match session.folder.take() {
            Some(folder) => folder,
            None => self.new_folder(rig, session)?,
        };
        if of_another_grid(&folder, rig) {
            session.folder = Some(folder);
            anyhow::bail!(
                "the projector's grid was changed since the scene without the object was recorded: record that anew"
            );
        }
        let mut report = |p| self.progress(p);
        let settings = &self.config.record;
        let done = record_stage(rig, &mut folder, stage, settings, &self.cancel, &mut report);
        let dir = folder.dir().to_owned();
        session.folder = Some(folder);
        done?;
        self.teller.tell(Event::Recorded(stage, dir));
        Ok(())
    }

    fn new_folder(&self, rig: &Rig, session: &Session) -> anyhow::Result<ScanFolder> {
        let now = projected(rig)?;
        for warning in recording_warnings(rig, &now, &self.config.record)? {
            self.teller.tell(Event::Note(format!("warning: {warning}")));
        }
        let calibration = self.calibration();
        let scan = NewScan {
            dir: &fresh_folder(&self.out),
            config: &self.config,
            selection: session
                .selection
                .as_ref()
                .filter(|selection| selection.best.as_slice() == now.pattern.coded.colours()),
            calibration: calibration.as_ref(),
        };
        Ok(scan.begin(rig)?)
    }

    /// A new folder with the same background, for the next object.
    fn next_object(&self, session: &mut Session) -> anyhow::Result<()> {
        let old = session.folder.as_ref();
        let old = old.context("record the scene without an object first")?;
        let new = with_background(old, &fresh_folder(&self.out))?;
        let dir = new.dir().to_owned();
        session.folder = Some(new);
        self.teller.tell(Event::NextObject(dir));
        Ok(())
    }
}

/// Leaves the coded grid on the wall, so that the live picture shows what was done.
fn show_grid(rig: &mut Rig) -> anyhow::Result<()> {
    rig.projector.show(View::Coded)?;
    Ok(())
}

/// A new scan folder that holds the background of another one, and everything that stands beside its captures.
fn with_background(old: &ScanFolder, dir: &Path) -> anyhow::Result<ScanFolder> {
    let manifest = old.manifest();
    let mut new = ScanFolder::create(dir, &old.projected(), manifest.camera)?;
    for (key, value) in manifest.extra.iter().filter(|(key, _)| *key != FINER_KEY) {
        new.note(key, value)?;
    }
    if let Some(selection) = old.selection()? {
        new.set_selection(&selection)?;
    }
    if let Some(path) = old.calibration_path() {
        new.set_calibration(&crate::process::read_calibration(&path)?)?;
    }
    let background = |entry: &&CaptureEntry| entry.stage == Stage::Background;
    for entry in manifest.captures.iter().filter(background) {
        new.add_capture(entry.stage, entry.shows, &old.picture(entry)?)?;
    }
    for grid in old.finer()? {
        for entry in grid.captures.iter().filter(background) {
            new.add_finer_capture(
                &grid.pattern,
                entry.stage,
                entry.shows,
                &old.picture(entry)?,
            )?;
        }
    }
    Ok(new)
}

#[cfg(test)]
mod tests {
    use image::{Rgb as Pixel, RgbImage};
    use shared::pattern::{GridSettings, RasterSize};

    use super::*;
    use crate::{pipeline::Projected, scan::Shows};

    #[test]
    fn the_next_object_gets_the_same_background_and_no_object() {
        let dir = tempfile::tempdir().unwrap();
        let size = RasterSize {
            width: 8,
            height: 6,
        };
        let projected = Projected {
            pattern: GridSettings::default(),
            raster: size,
        };
        let mut old = ScanFolder::create(&dir.path().join("one"), &projected, size).unwrap();
        let finer = GridSettings::default();
        let grey = Shows::Solid(Rgb([90; 3]));
        for (stage, light) in [(Stage::Background, 7), (Stage::Object, 9)] {
            let picture = RgbImage::from_pixel(8, 6, Pixel([light; 3]));
            for shows in Shows::RECORDING.into_iter().chain([grey]) {
                old.add_capture(stage, shows, &picture).unwrap();
            }
            old.add_finer_capture(&finer, stage, Shows::Prmvs, &picture)
                .unwrap();
        }
        old.note("camera_name", &"a camera").unwrap();
        let new = with_background(&old, &dir.path().join("two")).unwrap();
        assert_eq!(new.captures(Stage::Object).unwrap().prmvs.len(), 0);
        let white = &new.captures(Stage::Background).unwrap().white[0];
        assert_eq!(white.get_pixel(0, 0).0, [7; 3]);
        assert_eq!(new.manifest().extra["camera_name"], "a camera");
        let solids = |c: &&CaptureEntry| c.shows == grey;
        assert_eq!(new.manifest().captures.iter().filter(solids).count(), 1);
        let finer = &new.finer().unwrap()[0].captures;
        assert_eq!(
            finer.iter().map(|c| c.stage).collect::<Vec<_>>(),
            [Stage::Background]
        );
    }
}
